!> Limits of the speed of wheels, as events of a run: where a wheel comes to its limit its motor stops pushing, and
!> where it has fallen by a hundredth of it the motor may push again. Each ends a step, so that methods keep their
!> order.
module nutate_speed_limits
   use nutate_effect_list, only: effect_list_t
   use nutate_event, only: event_t
   use nutate_kinds, only: wp
   use nutate_motion, only: find_motion, motion_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_wheel, only: released_at, wheel_t
   implicit none
   private

   public :: limit_event_t, limit_events, has_limits, take_limits

   !> What becomes of a motor.
   integer, parameter, public :: SWITCH_LIMIT = 4

   !> The speed of a wheel comes to a limit, or leaves it.
   type, extends(event_t) :: limit_event_t
      !> Which wheel, and what becomes of its `at_limit`.
      integer :: wheel = 0, becomes = 0
   contains
      procedure :: value => speed
      procedure :: rate => speed_rate
   end type limit_event_t

contains

   !> True if a wheel has a limit of its speed.
   pure logical function has_limits(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_limits = .false.
      do i = 1, effects%n_wheels
         has_limits = has_limits .or. is_limited(effects%wheels(i))
      end do
   end function has_limits

   pure logical function is_limited(wheel)
      type(wheel_t), intent(in) :: wheel
      is_limited = wheel%speed_limit < huge(wheel%speed_limit)
   end function is_limited

   !> The events of all wheels that have a limit: both limits come to, both left.
   function limit_events(effects) result(events)
      type(effect_list_t), intent(in) :: effects
      type(limit_event_t), allocatable :: events(:)
      integer :: i, side, n
      n = 0
      do i = 1, effects%n_wheels
         if (is_limited(effects%wheels(i))) n = n + 4
      end do
      allocate (events(n))
      n = 0
      do i = 1, effects%n_wheels
         if (.not. is_limited(effects%wheels(i))) cycle
         do side = -1, 1, 2
            associate (reached => events(n + 1), left => events(n + 2))
               reached%level = side*effects%wheels(i)%speed_limit
               reached%becomes = side
               reached%direction = side
               write (reached%name, '("limit of wheel ",i0)') i
               left%level = released_at*reached%level
               left%direction = -side
            end associate
            events(n + 1:n + 2)%wheel = i
            events(n + 1:n + 2)%action = SWITCH_LIMIT
            n = n + 2
         end do
      end do
   end function limit_events

   !> Finds out which wheels are at, or beyond, their limits.
   pure subroutine take_limits(system, state)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      type(motion_t) :: motion
      real(wp) :: speed
      integer :: i
      call find_motion(system, state, motion)
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i))
            speed = wheel%speed_of(state%wheel_momentum(i), motion%omega)
            wheel%at_limit = 0
            if (abs(speed) >= wheel%speed_limit) wheel%at_limit = nint(sign(1.0_wp, speed))
         end associate
      end do
   end subroutine take_limits

   pure real(wp) function speed(self, system, motion)
      class(limit_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      speed = system%effects%wheels(self%wheel)%speed_of(motion%state%wheel_momentum(self%wheel), motion%omega)
   end function speed

   !> ḣ/Jw - s·Ω̇
   pure real(wp) function speed_rate(self, system, motion)
      class(limit_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      speed_rate = system%effects%wheels(self%wheel)%speed_of(motion%wheel_rate(self%wheel), motion%acceleration)
   end function speed_rate

end module nutate_speed_limits
