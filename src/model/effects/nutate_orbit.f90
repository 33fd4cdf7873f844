!> Orbit of the centre of mass, used by gravity gradients, LVLH attitudes and output columns.
!>
!> The scene's space axes are inertial, x to the equinox, z north; on request those of a circular orbit itself (LVLH: x
!> forward, y against the normal, z to the centre of attraction), which rotate at the constant rate (0, -n, 0).
module nutate_orbit
   use nutate_effect_base, only: effect_t, LINEAR_SERIES, parameter_t
   use nutate_kepler_orbit, only: kepler_orbit_t, axes_change, turn_rate_change, mean_motion_change
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: cross, rotate_to_space
   use nutate_track, only: track_axes_rate
   implicit none
   private

   public :: orbit_t, earth_mu, earth_radius
   public :: frame_rate_change, axes_rate_change, shadow_rate

   !> Gravitational parameter of the Earth, m³/s², and the radius to which altitudes refer, m.
   real(wp), parameter :: earth_mu = 3.986004418e14_wp, earth_radius = 6378137.0_wp

   !> An orbit, and the rate of the space axes.
   type, extends(effect_t) :: orbit_t
      !> ω of the space axes, in these axes, 0 if they are inertial, rad/s; shape (3).
      real(wp) :: rate(3) = 0.0_wp
      type(kepler_orbit_t) :: path = kepler_orbit_t()
      !> True if the space axes are those of the orbit.
      logical :: is_frame = .false.
      !> True for the one of several orbits to whose LVLH frame columns and controllers refer.
      logical :: is_main = .false.
      !> Unit vector to the sun, inertial axes, zero if none is known; shape (3). Radius of the body that casts the
      !> shadow, m.
      real(wp) :: sun(3) = 0.0_wp, shadow_radius = earth_radius
   contains
      procedure :: series_kind => constant_series
      procedure :: is_valid => orbit_is_valid
      procedure :: parameters => elements_of_orbit
      !> Adds a change to the elements.
      procedure, non_overridable :: shift
      !> Returns the unit quaternion from orbital to space axes at a time.
      procedure, non_overridable :: axes
      !> Returns the rate of the orbital axes at a time, space axes, rad/s.
      procedure, non_overridable :: axes_rate
      !> Returns true if there is a sun.
      procedure, non_overridable :: has_sun
      !> Returns the depth of the body in the shadow at a time, m.
      procedure, non_overridable :: shadow_depth
   end type orbit_t

   !> Makes an orbit from its path.
   interface orbit_t
      module procedure new_orbit
   end interface orbit_t

contains

   !> Returns `LINEAR_SERIES`: a constant rate adds no terms of its own.
   pure integer function constant_series(self)
      class(orbit_t), intent(in) :: self
      constant_series = LINEAR_SERIES
   end function constant_series

   !> Makes the orbit of a body for a system, without a sun. The space axes are inertial unless `inertial` is false;
   !> those of an elliptic orbit (e > 0) are inertial in any case.
   pure function new_orbit(path, inertial) result(orbit)
      type(kepler_orbit_t), intent(in) :: path
      !> The space axes are inertial; if false, those of the LVLH frame. Default: true.
      logical, intent(in), optional :: inertial
      type(orbit_t) :: orbit
      orbit%name = 'orbit'
      orbit%path = path
      call orbit%path%store_plane()
      if (present(inertial)) &
         orbit%is_frame = .not. (inertial .or. path%eccentricity > 0.0_wp .or. allocated(path%track))
      if (orbit%is_frame) orbit%rate = [0.0_wp, -path%mean_motion(), 0.0_wp]
   end function new_orbit

   !> Returns the attitude of the LVLH frame in the space axes of the scene at a time, a unit quaternion, LVLH→space;
   !> shape (4).
   pure function axes(self, t) result(q)
      class(orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: q(4)
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (.not. self%is_frame) q = self%path%axes(t)
   end function axes

   !> Returns the angular velocity of the LVLH frame relative to the space axes of the scene, rad/s; shape (3).
   pure function axes_rate(self, t) result(rate)
      class(orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: rate(3)
      rate = self%rate
      if (allocated(self%path%track)) then
         rate = track_axes_rate(self%path%track, t)
         return
      end if
      if (.not. self%is_frame) rate = rotate_to_space(self%axes(t), [0.0_wp, -self%path%turn_rate(t), 0.0_wp])
   end function axes_rate

   !> Returns true if the direction of the sun was given, so that eclipses can be computed.
   pure logical function has_sun(self)
      class(orbit_t), intent(in) :: self
      has_sun = any(abs(self%sun) > 0.0_wp)
   end function has_sun

   !> Returns the depth in the cylindrical shadow, m, positive inside. Behind the planet, seen from the sun, it is the
   !> radius less the distance from the axis of the shadow; in front of it the radius less the distance from the centre.
   !> The depth is smooth where the two meet.
   pure real(wp) function shadow_depth(self, t) result(depth)
      class(orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: r(3)
      r = self%path%position(t)
      if (dot_product(r, self%sun) < 0.0_wp) r = r - dot_product(r, self%sun)*self%sun
      depth = self%shadow_radius - norm2(r)
   end function shadow_depth

   !> Returns the time derivative of `shadow_depth`, m/s.
   pure real(wp) function shadow_rate(self, t) result(rate)
      type(orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: r(3)
      r = self%path%position(t)
      if (dot_product(r, self%sun) < 0.0_wp) r = r - dot_product(r, self%sun)*self%sun
      rate = 0.0_wp
      if (norm2(r) > 0.0_wp) rate = -dot_product(r/norm2(r), self%path%velocity(t))
   end function shadow_rate

   !> Returns true if the elements, and the rate of rotation at periapsis, are of a size that can be computed with. On
   !> an open orbit the distance grows with the speed for as long as a run can last.
   pure logical function orbit_is_valid(self)
      class(orbit_t), intent(in) :: self
      real(wp), parameter :: greatest_speed = 1e20_wp
      associate (path => self%path)
         if (allocated(path%track)) then
            orbit_is_valid = is_moderate(path%fastest_turn())
            return
         end if
         if (path%is_from_periapsis()) then
            orbit_is_valid = is_moderate(path%fastest_turn()) .and. is_moderate(path%periapsis_time)
            if (orbit_is_valid) orbit_is_valid = path%periapsis_distance*path%fastest_turn() <= greatest_speed
            return
         end if
         orbit_is_valid = is_moderate(path%mean_motion()) .and. path%eccentricity < 1.0_wp
         if (orbit_is_valid) orbit_is_valid = &
            is_moderate(path%mean_motion()/(1 - path%eccentricity)**2) .and. is_moderate(path%semi_major_axis)
      end associate
   end function orbit_is_valid

   !> Returns the elements. If the space axes are those of a circular orbit, the eccentricity is no parameter; a table
   !> has no elements.
   pure function elements_of_orbit(self) result(list)
      class(orbit_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('semi_major_axis'), parameter_t('eccentricity'), parameter_t('inclination'), &
              parameter_t('raan'), parameter_t('argument_of_periapsis'), parameter_t('mean_anomaly'), parameter_t('mu')]
      if (self%path%is_from_periapsis()) then
         list(1)%name = 'periapsis_distance'
         list(6)%name = 'periapsis_time'
      end if
      if (self%is_frame) list(2)%name = ''
      if (allocated(self%path%track)) list%name = ''
   end function elements_of_orbit

   !> Returns the change of the rate of the space axes, in these, rad/s; shape (3).
   pure function frame_rate_change(self, change) result(rate)
      type(orbit_t), intent(in) :: self
      !> Change of the elements; shape (n_elements).
      real(wp), intent(in) :: change(:)
      real(wp) :: rate(3)
      rate = 0.0_wp
      if (self%is_frame) rate(2) = -mean_motion_change(self%path, change)
   end function frame_rate_change

   !> Returns the change of `axes_rate` at a time, space axes, rad/s; shape (3).
   pure function axes_rate_change(self, change, t) result(rate)
      type(orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: rate(3)
      if (self%is_frame) then
         rate = frame_rate_change(self, change)
      else
         rate = cross(axes_change(self%path, change, t), self%axes_rate(t)) + &
                rotate_to_space(self%axes(t), [0.0_wp, -turn_rate_change(self%path, change, t), 0.0_wp])
      end if
   end function axes_rate_change

   !> Adds a change to the elements, and to the rate of the space axes that follows from them.
   pure subroutine shift(self, change)
      class(orbit_t), intent(inout) :: self
      !> Change of the elements; shape (n_elements).
      real(wp), intent(in) :: change(:)
      call self%path%shift(change)
      if (self%is_frame) self%rate = [0.0_wp, -self%path%mean_motion(), 0.0_wp]
   end subroutine shift

end module nutate_orbit
