!> Limits of the speed of wheels, as events of a run: the motor of a wheel that reaches its limit stops pushing; once
!> the speed has fallen by a hundredth of the limit, the motor may push again.
module nutate_speed_limits
   use nutate_effect_list, only: effect_list_t
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp
   use nutate_limit_event, only: limit_event_t, SWITCH_LIMIT
   use nutate_motion, only: find_motion, motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quaternion, only: quat_normalized
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_wheel, only: released_at, wheel_t, put_at_limit
   implicit none
   private

   public :: add_speed_limits, has_speed_limits, find_speed_limits

   !> Event: the speed of a wheel reaches a limit, or leaves it.
   type, extends(limit_event_t) :: speed_event_t
      !> Index of the wheel, and the new value of its `at_limit`.
      integer :: wheel = 0, becomes = 0
   contains
      procedure :: value => speed
      procedure :: rate => speed_rate
      procedure :: settle => settle_speed
      procedure :: is_out_of_reach => speed_is_out_of_reach
   end type speed_event_t

contains

   !> Returns true if a wheel has a limit of its speed.
   pure logical function has_speed_limits(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_speed_limits = .false.
      do i = 1, effects%n_wheels
         has_speed_limits = has_speed_limits .or. is_limited(effects%wheels(i))
      end do
   end function has_speed_limits

   pure logical function is_limited(wheel)
      type(wheel_t), intent(in) :: wheel
      is_limited = wheel%speed_limit < huge(wheel%speed_limit)
   end function is_limited

   !> Adds to a list the events of all wheels that have a limit: each of both limits is reached, or left.
   subroutine add_speed_limits(effects, events)
      type(effect_list_t), intent(in) :: effects
      type(event_list_t), intent(inout) :: events
      type(speed_event_t) :: reached, left
      integer :: i, side
      do i = 1, effects%n_wheels
         if (.not. is_limited(effects%wheels(i))) cycle
         do side = -1, 1, 2
            reached = speed_event_t(wheel=i, becomes=side, direction=side, action=SWITCH_LIMIT, &
                                    level=side*effects%wheels(i)%speed_limit)
            write (reached%name, '("limit of wheel ",i0)') i
            reached%words = reached%name
            left = speed_event_t(wheel=i, words=reached%name, direction=-side, action=SWITCH_LIMIT, &
                                 level=released_at*reached%level)
            call events%add(reached)
            call events%add(left)
         end do
      end do
   end subroutine add_speed_limits

   !> Finds out which wheels are at, or beyond, their limits.
   pure subroutine find_speed_limits(system, state)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      type(motion_t) :: motion
      real(wp) :: speed
      integer :: i, side
      call find_motion(system, state, motion)
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i))
            speed = wheel%speed_of(state%wheel_momentum(i), motion%omega)
            side = 0
            if (abs(speed) >= wheel%speed_limit) side = nint(sign(1.0_wp, speed))
            call put_at_limit(wheel, side)
         end associate
      end do
   end subroutine find_speed_limits

   !> Sets the `at_limit` of the wheel; blocks its motor if a control law would push the wheel beyond the limit.
   pure subroutine settle_speed(self, system, state)
      class(speed_event_t), intent(in) :: self
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      call put_at_limit(system%effects%wheels(self%wheel), self%becomes)
      call block_motor(system, self%wheel, state)
   end subroutine settle_speed

   !> Blocks the motor of a wheel if its control law would push the wheel beyond its limit.
   pure subroutine block_motor(system, i, state)
      type(system_t), intent(inout) :: system
      !> Index of the wheel.
      integer, intent(in) :: i
      type(state_t), intent(in) :: state
      type(motion_t) :: motion
      real(wp) :: command(3)
      if (.not. system%effects%wheels(i)%has_law()) return
      call find_motion(system, state, motion)
      associate (motor => system%effects%wheels(i)%motor)
         command = motor%command(state%t, quat_normalized(state%q), motion%relative)
         motor%blocked = motor%at_limit*command(1) > 0.0_wp
      end associate
   end subroutine block_motor

   pure real(wp) function speed(self, system, motion)
      class(speed_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      speed = system%effects%wheels(self%wheel)%speed_of(motion%state%wheel_momentum(self%wheel), motion%omega)
   end function speed

   !> Returns the rate of the speed, ḣ/Jw - s·Ω̇, rad/s².
   pure real(wp) function speed_rate(self, system, motion)
      class(speed_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      speed_rate = system%effects%wheels(self%wheel)%speed_of(motion%wheel_rate(self%wheel), motion%acceleration)
   end function speed_rate

   !> Returns true if motors and the body's own acceleration cannot bring the speed to its level in the time, with a
   !> quarter more for the errors of a computed motion.
   pure logical function speed_is_out_of_reach(self, speeds, f, time) result(stays)
      class(speed_event_t), intent(in) :: self
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), intent(in) :: f, time
      real(wp), parameter :: margin = 1.25_wp
      stays = abs(f) > margin*speeds%wheel_rates(self%wheel)*time
   end function speed_is_out_of_reach

end module nutate_speed_limits
