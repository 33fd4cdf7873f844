!> Bodies of the procedures whose interfaces are in `nutate_event`.
submodule(nutate_event) nutate_event_procedures
   use nutate_kinds, only: eps
   use nutate_limits, only: is_moderate
   use nutate_motion, only: displaced, find_motion, find_rates
   use nutate_small_products, only: vector_length
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   implicit none

contains

   module procedure leave_as_it_is
      problem = ''
   end procedure leave_as_it_is

   module procedure check_event
      character(len=:), allocatable :: problem
      call event%complete(problem)
      if (problem == '') then
         if (all(event%kind /= [CROSSING, MAXIMUM, MINIMUM, EXTREMUM])) then
            problem = 'kind is unknown (expected CROSSING, MAXIMUM, MINIMUM or EXTREMUM)'
         else if (abs(event%direction) > 1) then
            problem = 'direction is out of range (expected -1, 0 or 1)'
         else if (.not. is_moderate(event%level)) then
            problem = 'level is out of range (expected up to 1e100)'
         else if (.not. (is_moderate(event%period) .and. event%period >= 0.0_wp)) then
            problem = 'period is out of range (expected a number >= 0)'
         else if (event%count < 0) then
            problem = 'count is out of range (expected a number >= 0)'
         else if (event%action < 0 .or. event%action > SWITCH_TOGGLE) then
            problem = 'action is unknown (expected SWITCH_ON, SWITCH_OFF, SWITCH_TOGGLE or 0)'
         end if
      end if
      if (problem /= '') status = fail(NUTATE_BAD_ARGUMENT, "event '"//trim(event%name)//"': "//problem, 'event')
   end procedure check_event

   module procedure not_known
      not_known = .false.
   end procedure not_known

   module procedure one_part
      parts(1) = part_t(self%value(system, motion), self%period, self%rate(system, motion))
   end procedure one_part

   module procedure no_family
      no_family = 0
   end procedure no_family

   module procedure first_component
      first_component = 1
   end procedure first_component

   module procedure own_value
      values = [self%value(system, motion), 0.0_wp, 0.0_wp]
   end procedure own_value

   module procedure own_size
      magnitude = abs(self%value(system, motion))
   end procedure own_size

   module procedure rate_by_differences
      real(wp) :: rates(3)
      rates = family_rates(self, system, motion)
      rate = rates(self%component())
   end procedure rate_by_differences

   module procedure find_family
      values = event%family_values(system, motion)
      rates = family_rates(event, system, motion)
   end procedure find_family

   !> Computes the rates of a family by central differences of sixth order along the tangent of the motion: to 1e-13 of
   !> the size of g over the time of a radian; shape (3).
   pure function family_rates(event, system, motion) result(rates)
      class(event_t), intent(in) :: event
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp), parameter :: weights(3) = [45.0_wp/60, -9.0_wp/60, 1.0_wp/60]
      type(motion_t) :: there
      real(wp) :: rates(3), h, ahead(3), change(3)
      integer :: i
      h = wide*time_scale(motion)
      rates = 0.0_wp
      do i = 1, 3
         call find_motion(system, displaced(motion, i*h), there)
         ahead = event%family_values(system, there)
         call find_motion(system, displaced(motion, -i*h), there)
         change = ahead - event%family_values(system, there)
         if (event%period > 0.0_wp) change = change - event%period*anint(change/event%period)
         rates = rates + weights(i)*change
      end do
      rates = rates/h
   end function family_rates

   module procedure second_rate
      type(motion_t) :: there
      real(wp) :: h, ahead
      h = narrow*time_scale(motion)
      call find_motion(system, displaced(motion, h), there)
      call find_rates(system, window_time, there)
      ahead = event%rate(system, there)
      call find_motion(system, displaced(motion, -h), there)
      call find_rates(system, window_time, there)
      rate = (ahead - event%rate(system, there))/(2*h)
   end procedure second_rate

   module procedure time_scale
      real(wp) :: rate, size
      rate = vector_length(motion%omega)
      size = vector_length(motion%acceleration)
      if (size > rate*rate) rate = sqrt(size)
      scale = 1.0_wp
      if (rate > tiny(1.0_wp)/eps) scale = 1/rate
   end procedure time_scale

   module procedure counted_direction
      select case (self%kind)
      case (MAXIMUM)
         counted_direction = -1
      case (MINIMUM)
         counted_direction = 1
      case (EXTREMUM)
         counted_direction = 0
      case default
         counted_direction = self%direction
      end select
   end procedure counted_direction

end submodule nutate_event_procedures
