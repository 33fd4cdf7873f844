!> A wheel that a motor drives: fixed in the body but for its rotation about an axis s. The state of the wheel is its
!> absolute momentum about that axis, `h = Jw(ω + s·Ω)`, ω its speed relative to the body:
!>
!>     ḣ = u - cω,   L = JᵣΩ + Σ s h,   T = ½ΩᵀJᵣΩ + Σ h²/2Jw,   Jᵣ = J - Σ Jw ssᵀ
!>
!> with the torque u of the motor and the friction c of the bearing, both relative to the body. The motor does work at
!> the rate u ω, the friction at -cω². u is the torque of the wheel's own motor, or the command of a controller. If |ω|
!> has reached its limit the motor does not push further, until |ω| has fallen by a hundredth of the limit.
!>
!> The momentum of an inner sphere (`nutate_inner_sphere`) is that of three wheels of its inertia, one along each body
!> axis, which are no part of J and do not rotate with the body: ḣ gains h×Ω.
module nutate_wheel
   use nutate_archive, only: archive_t
   use nutate_effect, only: effect_t, LINEAR_SERIES, parameter_t, torque_t
   use nutate_effect_traits, only: IS_LAW
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, is_unit, least_size
   use nutate_saturation_count, only: saturation_count_t, transfer_count
   implicit none
   private

   public :: wheel_t, speed_change, friction_change, follow_switch
   public :: axis_change, motor_change, put_at_limit

   !> |ω| over its limit at which a motor that has reached it pushes again.
   real(wp), parameter, public :: released_at = 0.99_wp

   !> A reaction wheel; `add_wheel` adds it to a system.
   type, extends(effect_t) :: wheel_t
      !> s, unit vector, body axes; shape (3).
      real(wp) :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> Length of the axis as it was given.
      real(wp) :: reach = 1.0_wp
      !> Jw about the axis, kg m².
      real(wp) :: inertia = 0.0_wp
      !> ω at the initial state, relative to the body, rad/s.
      real(wp) :: speed = 0.0_wp
      !> c, N m s.
      real(wp) :: friction = 0.0_wp
      !> Body axis of this component of the momentum of an inner sphere; 0: a reaction wheel.
      integer :: component = 0
      !> c of an inner sphere that is on, N m s.
      real(wp) :: damping = 0.0_wp
      !> The motor: u is component 1 of its torque. Not allocated if there is none.
      class(torque_t), allocatable :: motor
      !> u of a wheel without a motor, N m: the command that a controller holds.
      real(wp) :: command = 0.0_wp
      !> Count of how often the commanded torque has reached `torque_limit`.
      type(saturation_count_t) :: saturations = saturation_count_t()
      !> Limit of the |u| that controllers command, N m, and of |ω|, rad/s; huge: none.
      real(wp) :: torque_limit = huge(1.0_wp), speed_limit = huge(1.0_wp)
      !> 1: ω is at `speed_limit`; -1: at `-speed_limit`; 0: neither. Runs set it at an event.
      integer :: at_limit = 0
   contains
      procedure :: series_kind => wheel_series
      procedure :: is_valid => wheel_is_valid
      !> Returns true if u acts at a time.
      procedure, non_overridable :: is_driven
      !> Returns u at a time.
      procedure, non_overridable :: drive
      !> Returns the interval in which u is smooth.
      procedure, non_overridable :: drive_window
      !> Returns ω from the momentum.
      procedure, non_overridable :: speed_of
      procedure :: parameters => wheel_parameters
      !> Returns the change of u by a change of `parameters`.
      procedure, non_overridable :: drive_change
      procedure :: follows => wheel_follows
      procedure :: own_window => window_of_motor
      procedure :: transfer => transfer_wheel
      !> Returns true if a controller drives the wheel at all times, by feedback of the motion.
      procedure, non_overridable :: has_law
   end type wheel_t

contains

   !> Returns how the motor supplies its power series; `LINEAR_SERIES` for a wheel without one.
   pure integer function wheel_series(self) result(kind)
      class(wheel_t), intent(in) :: self
      kind = LINEAR_SERIES
      if (allocated(self%motor)) kind = self%motor%series_kind()
   end function wheel_series

   !> Returns true if axis, inertia, speed, friction and limits can be computed with.
   pure logical function wheel_is_valid(self) result(valid)
      class(wheel_t), intent(in) :: self
      valid = all(is_moderate([self%axis, self%inertia, self%speed, self%friction]))
      if (valid) valid = is_unit([0.0_wp, self%axis], attitude_tolerance) .and. self%inertia >= least_size .and. &
                               self%friction >= 0.0_wp .and. self%torque_limit > 0.0_wp .and. self%speed_limit > 0.0_wp
      if (valid) valid = is_moderate(self%inertia*self%speed) .and. is_moderate(self%friction*self%speed)
      if (valid) valid = is_moderate(self%inertia*self%speed*self%speed)
      if (valid .and. allocated(self%motor)) valid = self%motor%is_valid()
   end function wheel_is_valid

   !> Returns true if the motor acts at a time and does not push the wheel beyond the limit of its speed.
   pure logical function is_driven(self, t)
      class(wheel_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp), parameter :: unturned(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], at_rest(3) = 0.0_wp
      is_driven = .false.
      if (.not. self%on) return
      is_driven = abs(self%command) > 0.0_wp
      if (allocated(self%motor)) is_driven = self%motor%acts_at(t)
      if (is_driven .and. self%at_limit /= 0) is_driven = .not. self%at_limit*self%drive(t, unturned, at_rest) > 0.0_wp
   end function is_driven

   !> Returns the torque u of a motor that acts, N m.
   pure real(wp) function drive(self, t, q, omega) result(u)
      class(wheel_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: tau(3)
      u = self%command
      if (.not. allocated(self%motor)) return
      tau = self%motor%torque(t, q, omega)
      u = tau(1)
   end function drive

   !> Returns the interval around a time in which u is a smooth function of time, s: the intersection of window and
   !> piece.
   pure function drive_window(self, moment) result(window)
      class(wheel_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: moment
      real(wp) :: window(2)
      real(wp) :: piece(2)
      window = [-huge(1.0_wp), huge(1.0_wp)]
      if (.not. allocated(self%motor)) return
      call self%motor%window(window(1), window(2))
      call self%motor%piece(moment, piece(1), piece(2))
      window = [max(window(1), piece(1)), min(window(2), piece(2))]
   end function drive_window

   !> Returns the speed relative to the body, ω = h/Jw - s·Ω, rad/s.
   pure real(wp) function speed_of(self, momentum, omega) result(speed)
      class(wheel_t), intent(in) :: self
      !> h, N m s, and Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: momentum, omega(3)
      speed = momentum/self%inertia - dot_product(self%axis, omega)
   end function speed_of

   !> Returns the parameters: s in the length in which it was given, Jw, ω0 and c; then those of the motor, whose torque
   !> is one number. The parameters of an inner sphere are those of each of its components.
   pure function wheel_parameters(self) result(list)
      class(wheel_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('axis', 3), parameter_t('inertia'), parameter_t('speed'), parameter_t('friction')]
      if (self%component > 0) &
         list = [parameter_t('angular_velocity', 3), parameter_t('inertia'), parameter_t(''), parameter_t('damping')]
      if (.not. allocated(self%motor)) return
      ! How a controller shares its torque depends on the axes of all wheels.
      if (self%motor%has(IS_LAW)) list(1)%name = ''
      list = [list, self%motor%drive_parameters()]
   end function wheel_parameters

   !> Returns true if the motor follows an orbit.
   pure logical function wheel_follows(self, path) result(follows)
      class(wheel_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      follows = .false.
      if (allocated(self%motor)) follows = self%motor%follows(path)
   end function wheel_follows

   !> Returns the window, s, that the motor's own parameters define.
   pure subroutine window_of_motor(self, start, stop)
      class(wheel_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
      if (allocated(self%motor)) call self%motor%own_window(start, stop)
   end subroutine window_of_motor

   !> Writes or reads the values that runs set in the wheel, and in its motor.
   subroutine transfer_wheel(self, archive)
      class(wheel_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%on)
      call follow_switch(self)
      call archive%transfer(self%at_limit)
      call archive%transfer(self%command)
      call transfer_count(self%saturations, archive)
      if (allocated(self%motor)) call self%motor%transfer(archive)
   end subroutine transfer_wheel

   pure logical function has_law(self)
      class(wheel_t), intent(in) :: self
      has_law = .false.
      if (allocated(self%motor)) has_law = self%motor%has(IS_LAW)
   end function has_law

   !> Puts the wheel at a limit of its speed; a motor that a law drives observes the limit itself.
   pure subroutine put_at_limit(self, side)
      type(wheel_t), intent(inout) :: self
      !> Side, 1: at the limit; -1: at the negative limit; 0: at neither.
      integer, intent(in) :: side
      if (self%has_law()) then
         self%motor%at_limit = side
      else
         self%at_limit = side
      end if
   end subroutine put_at_limit

   !> Returns the change of the parameters of the motor.
   pure function motor_change(self, change) result(of_motor)
      type(wheel_t), intent(in) :: self
      !> Change of `parameters`, with those of the motor.
      real(wp), intent(in) :: change(:)
      real(wp), allocatable :: of_motor(:)
      of_motor = self%motor%drive_change(change(7:))
   end function motor_change

   !> Returns the change of the unit vector s; shape (3).
   pure function axis_change(self, change) result(axis)
      type(wheel_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      real(wp) :: axis(3)
      axis = 0.0_wp
      if (self%component == 0) axis = (change(1:3) - dot_product(self%axis, change(1:3))*self%axis)/self%reach
   end function axis_change

   !> Returns the change of ω at the initial state, rad/s.
   pure real(wp) function speed_change(self, change)
      type(wheel_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      speed_change = change(5)
      if (self%component > 0) speed_change = change(self%component)
   end function speed_change

   !> Returns the change of c, N m s.
   pure real(wp) function friction_change(self, change)
      type(wheel_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      friction_change = change(6)
      if (self%component > 0 .and. .not. self%on) friction_change = 0.0_wp
   end function friction_change

   !> Sets c of an inner sphere: 0 while it is off.
   pure subroutine follow_switch(self)
      class(wheel_t), intent(inout) :: self
      if (self%component > 0) self%friction = merge(self%damping, 0.0_wp, self%on)
   end subroutine follow_switch

   !> Returns the change of u, N m.
   pure real(wp) function drive_change(self, change, t, q, omega) result(u)
      class(wheel_t), intent(in) :: self
      !> Change of `parameters`; time, s; attitude, unit quaternion, body→space, and Ω, body axes, rad/s; shapes (4),
      !> (3).
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      u = 0.0_wp
      if (size(change) <= 6 .or. .not. allocated(self%motor)) return
      tau = self%motor%torque_change(motor_change(self, change), t, q, omega)
      u = tau(1)
   end function drive_change

end module nutate_wheel
