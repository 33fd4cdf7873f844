!> A magnetic or electric dipole fixed in the body, in a uniform field: V = -m·Rᵀb.
module nutate_dipole
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: dipole_t, dipole_keys, build_dipole

   !> Keys of the scene group `&dipole`.
   type(key_t), parameter :: dipole_keys(2) = [ &
      key_t(name='moment', least=3, most=3, required=.true.), &
      key_t(name='field', least=3, most=3, required=.true.)]

   !> U(γ) = -m·γ with γ = Rᵀb.
   type, extends(linear_potential_t) :: dipole_t
   contains
      procedure :: own_field => field_of_dipole
   end type dipole_t

   !> Makes a dipole in a field.
   interface dipole_t
      module procedure new_dipole
   end interface dipole_t

contains

   !> Makes the potential -m·R(q)ᵀb of a magnetic dipole in a uniform field.
   pure function new_dipole(moment, field) result(dipole)
      !> m, body axes, A m²; shape (3).
      real(wp), intent(in) :: moment(3)
      !> b, space axes, T; shape (3).
      real(wp), intent(in) :: field(3)
      type(dipole_t) :: dipole
      dipole%name = 'dipole'
      dipole%direction = field
      dipole%moment = moment
   end function new_dipole

   !> Returns the field b, space axes, T.
   pure subroutine field_of_dipole(self, field, found)
      class(dipole_t), intent(in) :: self
      real(wp), intent(out) :: field(3)
      logical, intent(out) :: found
      field = self%direction
      found = .true.
   end subroutine field_of_dipole

   !> Builds a dipole from its scene group. Returns no errors.
   subroutine build_dipole(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      real(wp), parameter :: none(3) = 0.0_wp
      allocate (effect, source=dipole_t(group%vector('moment', none), group%vector('field', none)))
   end subroutine build_dipole

end module nutate_dipole
