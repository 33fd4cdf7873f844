!> Uniform gravity on a body whose centre of mass is not at the reference point: V = -m g·(R c).
module nutate_gravity
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, parameter_t
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_BODY
   implicit none
   private

   public :: gravity_t, gravity_keys, build_gravity, standard_gravity

   !> Acceleration if a scene does not give one, space axes, m/s².
   real(wp), parameter :: standard_gravity(3) = [0.0_wp, 0.0_wp, -9.80665_wp]

   !> Keys of the scene group `&gravity`.
   type(key_t), parameter :: gravity_keys(1) = [ &
                                       key_t(name='acceleration', least=3, most=3, default='0, 0, -9.80665')]

   !> U(γ) = -m c·γ with γ = Rᵀg.
   type, extends(linear_potential_t) :: gravity_t
   contains
      procedure :: parameters => gravity_parameters
      procedure :: factor_change => mass_change
   end type gravity_t

   !> Makes gravity on a body.
   interface gravity_t
      module procedure new_gravity
   end interface gravity_t

contains

   !> Makes the potential -m x_c·R(q)ᵀg of a body in uniform gravity, x_c its centre of mass.
   pure function new_gravity(body, acceleration) result(gravity)
      !> Body, of which mass and centre of mass are used.
      type(body_t), intent(in) :: body
      !> g, space axes, m/s²; shape (3).
      real(wp), intent(in) :: acceleration(3)
      type(gravity_t) :: gravity
      gravity%name = 'gravity'
      gravity%direction = acceleration
      gravity%moment = body%mass*body%center_of_mass
      gravity%by_center = body%mass
   end function new_gravity

   !> Builds gravity from its scene group. Errors: `NUTATE_BAD_BODY` if the body has no mass.
   subroutine build_gravity(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      if (.not. body%has_mass) then
         status = fail(NUTATE_BAD_BODY, 'gravity needs the mass of the body (expected mass or density in &body)')
         return
      end if
      allocate (effect, source=gravity_t(body, group%vector('acceleration', standard_gravity)))
   end subroutine build_gravity

   !> Returns the parameters m c, g and, if the centre of mass moves, m, which multiplies its displacement.
   pure function gravity_parameters(self) result(list)
      class(gravity_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('mass_moment', 3), parameter_t('acceleration', 3)]
      if (self%varies) list = [list, parameter_t('mass')]
   end function gravity_parameters

   !> Returns the change of the mass.
   pure function mass_change(self, change) result(factors)
      class(gravity_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      real(wp) :: factors(2)
      factors = 0.0_wp
      if (size(change) > 6) factors(2) = change(7)
   end function mass_change

end module nutate_gravity
