!> A wheel that a motor drives: fixed in the body but for its rotation about an axis s. Its state is its absolute
!> momentum about that axis, `h = Jw(ω + s·Ω)`, ω its speed relative to the body:
!>
!>     ḣ = u - cω,   L = JᵣΩ + Σ s h,   T = ½ΩᵀJᵣΩ + Σ h²/2Jw,   Jᵣ = J - Σ Jw ssᵀ
!>
!> with the torque u of the motor and the friction c of the bearing, both against the body. The motor's work is u ω, the
!> friction's -cω².
module nutate_wheel
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, LINEAR_SERIES, torque_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_admissible, only: ANY_DIRECTION, NON_NEGATIVE, POSITIVE
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, is_unit, least_size
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: wheel_t, wheel_keys, build_wheel

   !> Keys of the scene group `&wheel`.
   type(key_t), parameter :: wheel_keys(9) = [ &
      key_t(name='axis', least=3, most=3, range=ANY_DIRECTION, required=.true.), &
      key_t(name='inertia', range=POSITIVE, required=.true.), &
      key_t(name='speed', default='0'), &
      key_t(name='torque', default='0'), &
      key_t(name='frequency', default='0', beside='torque'), &
      key_t(name='phase', default='0', beside='torque'), &
      key_t(name='friction', range=NON_NEGATIVE, default='0'), &
      key_t(name='start'), &
      key_t(name='stop')]

   !> A wheel; `add_wheel` puts it into a system.
   type, extends(effect_t) :: wheel_t
      !> s, unit vector, body axes; shape (3).
      real(wp) :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> Jw about the axis, kg m².
      real(wp) :: inertia = 0.0_wp
      !> ω at the start, relative to the body, rad/s.
      real(wp) :: speed = 0.0_wp
      !> c, N m s.
      real(wp) :: friction = 0.0_wp
      !> The motor: u is component 1 of its torque. Not allocated: there is none.
      class(torque_t), allocatable :: motor
   contains
      procedure :: series_kind => wheel_series
      procedure :: is_moderate => wheel_is_moderate
      !> u acts at a time.
      procedure :: is_driven
      !> u at a time.
      procedure :: drive
      !> ω of a momentum.
      procedure :: speed_of
   end type wheel_t

contains

   !> A wheel as a scene's group asks for it. Errors: `NUTATE_BAD_ARGUMENT` for a motor that stops before it starts.
   subroutine build_wheel(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(wheel_t) :: wheel
      type(applied_torque_t) :: motor
      real(wp) :: axis(3)
      wheel%name = 'wheel'
      axis = group%vector('axis', wheel%axis)
      ! Scaled first: the squares of a long or short vector would leave the range of numbers.
      axis = axis/maxval(abs(axis))
      wheel%axis = axis/norm2(axis)
      wheel%inertia = group%number('inertia', wheel%inertia)
      wheel%speed = group%number('speed', wheel%speed)
      wheel%friction = group%number('friction', wheel%friction)
      motor%name = 'motor'
      motor%amplitude(1) = group%number('torque', 0.0_wp)
      motor%frequency = group%number('frequency', motor%frequency)
      motor%phase = group%number('phase', motor%phase)
      motor%start = group%number('start', motor%start)
      motor%stop = group%number('stop', motor%stop)
      if (.not. motor%stop > motor%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the motor stops before it starts (expected stop > start)', 'stop')
         return
      end if
      if (group%has('torque')) allocate (wheel%motor, source=motor)
      allocate (effect, source=wheel)
   end subroutine build_wheel

   !> Wheels have a series where their motors have one.
   pure integer function wheel_series(self) result(kind)
      class(wheel_t), intent(in) :: self
      kind = LINEAR_SERIES
      if (allocated(self%motor)) kind = self%motor%series_kind()
   end function wheel_series

   pure logical function wheel_is_moderate(self) result(moderate)
      class(wheel_t), intent(in) :: self
      moderate = all(is_moderate([self%axis, self%inertia, self%speed, self%friction]))
      if (moderate) moderate = is_unit([0.0_wp, self%axis], attitude_tolerance) .and. self%inertia >= least_size .and. &
                               self%friction >= 0.0_wp
      if (moderate) moderate = is_moderate(self%inertia*self%speed) .and. is_moderate(self%friction*self%speed)
      if (moderate) moderate = is_moderate(self%inertia*self%speed*self%speed)
      if (moderate .and. allocated(self%motor)) moderate = self%motor%is_moderate()
   end function wheel_is_moderate

   !> True for a motor that acts at a time.
   pure logical function is_driven(self, t)
      class(wheel_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      is_driven = self%on .and. allocated(self%motor)
      if (is_driven) is_driven = self%motor%acts_at(t)
   end function is_driven

   !> u, N m, of a motor that acts.
   pure real(wp) function drive(self, t, q, omega) result(u)
      class(wheel_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: tau(3)
      tau = self%motor%torque(t, q, omega)
      u = tau(1)
   end function drive

   !> ω = h/Jw - s·Ω, rad/s.
   pure real(wp) function speed_of(self, momentum, omega) result(speed)
      class(wheel_t), intent(in) :: self
      !> h, N m s, and Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: momentum, omega(3)
      speed = momentum/self%inertia - dot_product(self%axis, omega)
   end function speed_of

end module nutate_wheel
