!> A magnetic moment fixed in the body, in the field of the Earth along an orbit: V = -m·Rᵀb(t).
module nutate_earth_field
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, parameter_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL, KEY_TEXT
   use nutate_kepler_orbit, only: kepler_orbit_t, n_elements
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: is_moderate
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
      type(geomagnetic_field_t) :: field = geomagnetic_field_t()
   contains
      procedure :: direction_at => direction_of_field
      procedure :: direction_rate => rate_of_field
      procedure :: direction_series => series_of_field
      procedure :: is_valid => effect_is_valid
      procedure :: parameters => parameters_of_field
      procedure :: direction_change => change_of_field
      procedure :: direction_change_series => change_of_series
      procedure :: follows => field_follows
      procedure :: thin_table => thin_path
      procedure :: is_earth_field => always_earth_field
   end type earth_field_t

   !> A moment in the Earth's field.
   interface earth_field_t
      module procedure new_earth_field
   end interface earth_field_t

contains

   !> Returns true.
   pure logical function always_earth_field(self)
      class(earth_field_t), intent(in) :: self
      always_earth_field = .true.
   end function always_earth_field

   !> Makes the potential -m·R(q)ᵀb(t) of a magnetic moment in the field of the Earth along an orbit.
   pure function new_earth_field(moment, field) result(effect)
      !> m, body axes, A m²; shape (3).
      real(wp), intent(in) :: moment(3)
      !> b, in the space axes of the scene.
      type(geomagnetic_field_t), intent(in) :: field
      type(earth_field_t) :: effect
      effect%name = 'earth_field'
      effect%moment = moment
      effect%field = field
      effect%moves = .true.
      effect%direction = 0.0_wp
      if (.not. effect%is_valid()) return
      effect%pace = field%pace()
      effect%direction = field%at(0.0_wp)
   end function new_earth_field

   !> A group that stands without an orbit. Errors: `NUTATE_BAD_ARGUMENT`.
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

   !> Returns b at a time, space axes, T; shape (3).
   pure function direction_of_field(self, t) result(n)
      class(earth_field_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%field%at(t)
   end function direction_of_field

   !> m, G, θ₀ in rad, and the orbit.
   pure function parameters_of_field(self) result(list)
      class(earth_field_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('moment', 3), parameter_t('coefficients', 3), parameter_t('epoch_angle'), &
              parameter_t('orbit', n_elements)]
   end function parameters_of_field

   pure function change_of_field(self, change, t) result(n)
      class(earth_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = self%field%change_by_axis(change(4:6), change(7), t) + self%field%change_by_orbit(change(8:), t)
   end function change_of_field

   pure subroutine change_of_series(self, change, t, time_unit, n, known)
      class(earth_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      type(geomagnetic_field_t) :: field
      real(wp) :: by_orbit(3, 0:ubound(n, 2))
      known = .true.
      field = self%field%with_axis(change(4:6), change(7))
      call field%series(t, time_unit, n)
      if (.not. any(abs(change(8:)) > 0.0_wp)) return
      call self%field%change_series(change(8:), t, time_unit, by_orbit)
      n = n + by_orbit
   end subroutine change_of_series

   pure logical function field_follows(self, path)
      class(earth_field_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      field_follows = self%field%path%equals(path)
   end function field_follows

   !> Returns ḃ at a time, space axes, T/s; shape (3).
   pure function rate_of_field(self, t) result(rate)
      class(earth_field_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: rate(3)
      rate = self%field%rate_at(t)
   end function rate_of_field

   !> Computes the coefficients of the power series of b about a time, space axes, T.
   pure subroutine series_of_field(self, t, time_unit, n)
      class(earth_field_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      call self%field%series(t, time_unit, n)
   end subroutine series_of_field

   !> Returns true if |m||b|, the largest energy and torque, and this times the largest rate of the direction of b, the
   !> largest power, can be computed with.
   pure logical function effect_is_valid(self) result(valid)
      class(earth_field_t), intent(in) :: self
      valid = all(is_moderate(self%moment)) .and. self%field%is_valid()
      if (valid) valid = is_moderate(norm2(self%moment))
      if (valid) valid = is_moderate(norm2(self%moment)*self%field%greatest())
      if (valid) valid = is_moderate(norm2(self%moment)*self%field%greatest()*self%field%pace())
   end function effect_is_valid

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(earth_field_t), intent(inout) :: self
      call self%field%path%thin_table()
   end subroutine thin_path

end module nutate_earth_field
