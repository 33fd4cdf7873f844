!> A magnetic moment fixed in the body, in the field of the Earth along an orbit: V = -m·Rᵀb(t).
module nutate_earth_field
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t
   use nutate_effect_traits, only: IS_EARTH_FIELD
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_moving_linear, only: moving_linear_t
   use nutate_orbit, only: orbit_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: earth_field_t, earth_field_keys, build_earth_field, field_on_orbit

   !> Keys of the scene group `&earth_field`.
   type(key_t), parameter :: earth_field_keys(5) = [ &
      key_t(name='moment', least=3, most=3, default='0, 0, 0'), &
      key_t(name='epoch_angle', default='0'), &
      key_t(name='coefficients', least=3, most=3, default='IGRF-14 of 2025'), &
      key_t(name='orbit', kind=KEY_TEXT), &
      key_t(name='degrees', kind=KEY_LOGICAL)]

   !> U(γ) = -m·γ with γ = R(q)ᵀb(t).
   type, extends(moving_linear_t) :: earth_field_t
   contains
      procedure :: has => has_trait
      !> Returns the field.
      procedure :: field
   end type earth_field_t

   !> Makes a moment in the field of the Earth.
   interface earth_field_t
      module procedure new_earth_field
   end interface earth_field_t

contains

   !> Returns true for `IS_EARTH_FIELD`.
   pure logical function has_trait(self, trait)
      class(earth_field_t), intent(in) :: self
      integer, intent(in) :: trait
      has_trait = trait == IS_EARTH_FIELD
   end function has_trait

   !> Returns the field b, in the space axes of the scene.
   pure type(geomagnetic_field_t) function field(self)
      class(earth_field_t), intent(in) :: self
      select type (vector => self%vector)
      type is (geomagnetic_field_t)
         field = vector
      end select
   end function field

   !> Makes the potential -m·R(q)ᵀb(t) of a magnetic moment in the field of the Earth along an orbit.
   function new_earth_field(moment, field) result(effect)
      !> m, body axes, A m²; shape (3).
      real(wp), intent(in) :: moment(3)
      !> Field b, in the space axes of the scene.
      type(geomagnetic_field_t), intent(in) :: field
      type(earth_field_t) :: effect
      call effect%set_up('earth_field', moment, field)
   end function new_earth_field

   !> Rejects a group in a scene without an orbit. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine build_earth_field(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'the field of the Earth needs an orbit (expected &orbit)')
   end subroutine build_earth_field

   !> Builds the field from its scene group, along the orbit of the scene.
   function field_on_orbit(group, orbit) result(effect)
      type(group_t), intent(in) :: group
      type(orbit_t), intent(in) :: orbit
      type(earth_field_t) :: effect
      type(geomagnetic_field_t) :: field
      real(wp), parameter :: none(3) = 0.0_wp
      field%path = orbit%path
      field%in_orbit = orbit%is_frame
      field%coefficients = group%vector('coefficients', field%coefficients)
      field%epoch_angle = group%number('epoch_angle', 0.0_wp)
      if (group%flag('degrees', .false.)) field%epoch_angle = field%epoch_angle*(pi/180)
      effect = earth_field_t(group%vector('moment', none), field)
   end function field_on_orbit

end module nutate_earth_field
