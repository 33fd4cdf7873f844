!> Bodies of the procedures whose interfaces are in `nutate_event_tracker`.
submodule(nutate_event_tracker) nutate_event_tracker_procedures
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_control, only: limit_events, find_limits
   use nutate_event, only: check_event, CROSSING, find_family, second_rate
   use nutate_kinds, only: eps
   use nutate_limit_event, only: limit_event_t
   use nutate_motion, only: renew_motion
   use nutate_motion_bounds, only: bound_motion
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   implicit none

contains

   module procedure begin
      type(event_list_t) :: limits
      integer :: i
      limits = limit_events(system%effects)
      self%n_asked = events%count()
      allocate (self%watched(self%n_asked + limits%count()), self%due(self%n_asked + limits%count()))
      do i = 1, limits%count()
         allocate (self%watched(self%n_asked + i)%event, source=limits%slots(i)%item)
      end do
      allocate (self%acts(system%effects%n_torques + system%effects%n_wheels), source=.false.)
      allocate (self%pieces(size(self%acts)), source=0.0_wp)
      do i = 1, events%count()
         allocate (self%watched(i)%event, source=events%slots(i)%item)
         associate (event => self%watched(i)%event)
            if (status%ok()) call check_event(event, status)
            if (event%action == 0) cycle
            if (.not. system%effects%has(event%effect)) status = fail(NUTATE_BAD_ARGUMENT, &
               "no effect that can be switched is called '"//trim(event%effect)//"'", 'switch')
         end associate
      end do
      call self%set_system(system)
      if (limits%count() == 0) return
      call find_limits(self%system, state)
      call self%hold_sides()
   end procedure begin

   module procedure remember
      integer :: i
      do i = 1, min(self%n_asked, before%n_asked)
         associate (here => self%watched(i), earlier => before%watched(i))
            here%number = earlier%number
            here%first_time = earlier%first_time
            here%last_time = earlier%last_time
            here%side = earlier%side
            here%cell = earlier%cell
            here%f = earlier%f
            here%parts = earlier%parts
            here%followed = earlier%followed
         end associate
      end do
   end procedure remember

   module procedure set_system
      self%system = system
      self%known = .false.
      self%asleep = .false.
      self%bounds = bound_motion(system)
      self%recalled%family = 0
   end procedure set_system

   module procedure recall_place
      integer :: i
      found = .false.
      do i = 1, min(self%n_places, most_places)
         if (abs(self%places(i)%s - s) > 0.0_wp) cycle
         motion = self%places(i)%motion
         found = .true.
         return
      end do
   end procedure recall_place

   module procedure store_place
      self%places(1 + mod(self%n_places, most_places)) = place_t(s, motion)
      self%n_places = self%n_places + 1
   end procedure store_place

   module procedure hold_sides
      integer :: i
      do i = self%n_asked + 1, size(self%watched)
         associate (watched => self%watched(i))
            watched%side = 0
            select type (event => watched%event)
            class is (limit_event_t)
               watched%side = event%side_held(self%system)
            end select
            if (watched%side /= 0) watched%near = 0.0_wp
         end associate
      end do
   end procedure hold_sides

   module procedure sleeps_until
      sleeps_until = .false.
      if (self%asleep) sleeps_until = sense*(self%wakes - t) >= 0.0_wp
   end procedure sleeps_until

   module procedure fall_asleep
      real(wp) :: room
      integer :: steps, longer, i
      self%asleep = .false.
      if (.not. self%known) return
      if (.not. self%bounds%known) return
      room = self%bounds%room(self%system, self%motion)
      ! A time that was right once may be so again.
      steps = max(self%steps_asleep, 1)
      if (all_stay_away(self, room, steps*abs(step))) then
         longer = min(2*steps, most_asleep)
         if (longer > steps) then
            if (all_stay_away(self, room, longer*abs(step))) steps = longer
         end if
      else
         steps = (2*steps)/3
         if (steps > 0) then
            if (.not. all_stay_away(self, room, steps*abs(step))) steps = steps/2
         end if
         self%steps_asleep = steps
         if (steps == 0) return
         if (.not. all_stay_away(self, room, steps*abs(step))) return
      end if
      self%steps_asleep = steps
      self%wakes = t + steps*step
      self%asleep = .true.
      self%known = .false.
      ! A function that stays away keeps its side; but the revolutions of an angle are not followed.
      do i = 1, size(self%watched)
         if (any(self%watched(i)%parts%wrap > 0.0_wp)) self%watched(i)%side = 0
      end do
   end procedure fall_asleep

   !> Returns true if no event can happen for a time.
   pure logical function all_stay_away(self, room, time)
      class(event_tracker_t), intent(in) :: self
      !> Energy that potentials can give to the motion, J.
      real(wp), intent(in) :: room
      !> Duration, s.
      real(wp), intent(in) :: time
      real(wp) :: distance
      integer :: i
      all_stay_away = .false.
      associate (speeds => self%bounds%within(self%motion, room, time))
         if (.not. speeds%known) return
         do i = 1, size(self%watched)
            associate (event => self%watched(i)%event)
               distance = self%watched(i)%f
               if (event%period > 0.0_wp .and. event%kind == CROSSING) &
                  distance = distance - event%period*anint(distance/event%period)
               if (.not. event%is_out_of_reach(speeds, distance, time)) return
            end associate
         end do
      end associate
      all_stay_away = .true.
   end function all_stay_away

   module procedure evaluate
      associate (event => self%watched(i)%event)
         if (event%kind == CROSSING .and. event%family() /= 0) then
            call evaluate_family(self, event, system, motion, parts(1))
         else if (event%kind == CROSSING) then
            call event%parts(system, motion, parts)
         else
            parts(1)%value = event%rate(system, motion)
            parts(1)%rate = second_rate(event, system, window_time, motion)
         end if
      end associate
   end procedure evaluate

   !> Returns the part of an event of a family: computed, or recalled if another event of it has been evaluated there.
   pure subroutine evaluate_family(self, event, system, motion, part)
      class(event_tracker_t), intent(inout) :: self
      class(event_t), intent(in) :: event
      type(system_t), intent(in) :: system
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      type(part_t), intent(out) :: part
      integer :: i, place
      place = 0
      do i = 1, most_recalled
         if (self%recalled(i)%family /= event%family()) cycle
         if (is_same(self%recalled(i)%motion, motion)) place = i
      end do
      if (place == 0) then
         place = 1 + mod(self%last_recalled, most_recalled)
         self%last_recalled = place
         associate (slot => self%recalled(place))
            slot%family = event%family()
            slot%motion = motion
            call find_family(event, system, motion, slot%values, slot%rates)
         end associate
      end if
      associate (slot => self%recalled(place), k => event%component())
         part = part_t(slot%values(k), event%period, slot%rates(k))
      end associate
   end subroutine evaluate_family

   !> Returns true for the same state with the same rates.
   pure logical function is_same(a, b)
      type(motion_t), intent(in) :: a, b
      is_same = .false.
      if (abs(a%state%t - b%state%t) > 0.0_wp) return
      is_same = maxval(abs(a%state%q - b%state%q)) + maxval(abs(a%state%p - b%state%p)) + &
                maxval(abs(a%acceleration - b%acceleration)) + maxval(abs(a%wheel_rate - b%wheel_rate)) + &
                maxval(abs(a%state%wheel_momentum - b%state%wheel_momentum)) <= 0.0_wp
   end function is_same

   module procedure open_step
      real(wp) :: before
      logical :: placed
      integer :: i
      self%n_places = 0
      call see_torques(self, system, window_time)
      if (self%known) return
      placed = self%placed
      ! A state at the time of the last one is that observed at the end of the last step: continuous functions are the
      ! same to the last digit.
      if (.not. placed .or. abs(self%motion%state%t - state%t) > 0.0_wp) self%motion%state = state
      call renew_motion(system, window_time, self%motion)
      do i = 1, size(self%watched)
         associate (watched => self%watched(i))
            before = watched%f
            call evaluate_functions(self, i, system, window_time)
            watched%jumped = placed .and. abs(watched%f - before) > 0.0_wp
            watched%followed = .true.
         end associate
      end do
      self%known = .true.
      self%placed = .true.
   end procedure open_step

   module procedure place
      integer :: i
      self%motion%state = state
      call renew_motion(system, window_time, self%motion)
      do i = 1, size(self%watched)
         call evaluate_functions(self, i, system, window_time)
      end do
      self%known = .false.
      self%placed = .true.
   end procedure place

   module procedure check_parts
      if (all(ieee_is_finite(parts%value)) .and. all(ieee_is_finite(parts%rate))) return
      status = fail(NUTATE_NOT_FINITE, "the quantity of the event '"//trim(event%name)//"', or its rate, is not finite")
   end procedure check_parts

   !> Evaluates function and slope of an event at the motion, angles as near as possible to their last values.
   subroutine evaluate_functions(self, i, system, window_time)
      class(event_tracker_t), intent(inout) :: self
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: window_time
      type(part_t) :: parts(most_parts)
      call self%evaluate(i, system, window_time, self%motion, parts)
      associate (watched => self%watched(i))
         watched%start_status = status_t()
         call check_parts(watched%event, parts, watched%start_status)
         if (.not. watched%start_status%ok()) parts = part_t()
         if (watched%followed) call bring_near(parts, watched%parts%value)
         watched%parts = parts
         watched%f = sum(parts%value)
         if (watched%event%kind == CROSSING) watched%f = watched%f - watched%event%level
         watched%slope = sum(parts%rate)
      end associate
   end subroutine evaluate_functions

   !> Detects if other torques act than in the last step, or other pieces of them.
   subroutine see_torques(self, system, window_time)
      class(event_tracker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: window_time
      real(wp) :: piece(2)
      logical :: acts
      integer :: i
      do i = 1, size(self%acts)
         if (i <= system%effects%n_torques) then
            acts = system%effects%torques(i)%item%acts_at(window_time)
            call system%effects%torques(i)%item%piece(window_time, piece(1), piece(2))
         else
            acts = system%effects%wheels(i - system%effects%n_torques)%is_driven(window_time)
            piece = system%effects%wheels(i - system%effects%n_torques)%drive_window(window_time)
         end if
         if ((acts .neqv. self%acts(i)) .or. abs(piece(1) - self%pieces(i)) > 0.0_wp) self%known = .false.
         self%acts(i) = acts
         self%pieces(i) = piece(1)
      end do
   end subroutine see_torques

   module procedure bring_near
      integer :: i
      do i = 1, most_parts
         associate (part => parts(i))
            if (part%wrap > 0.0_wp) part%value = part%value + part%wrap*anint((values(i) - part%value)/part%wrap)
         end associate
      end do
   end procedure bring_near

   module procedure variation
      associate (watched => self%watched(i))
         variation = 0.0_wp
         if (watched%highest > watched%lowest) variation = watched%highest - watched%lowest
         if (watched%seen < young) variation = max(variation, abs(last%f))
         ! An angle may grow without end.
         if (any(watched%parts%wrap > 0.0_wp)) variation = min(variation, sum(watched%parts%wrap))
         if (turn > eps) variation = max(variation, abs(last%slope)/turn)
      end associate
   end procedure variation

   module procedure transfer
      integer :: i
      call archive%expect('events')
      do i = 1, size(self%watched)
         associate (watched => self%watched(i))
            call archive%transfer(watched%number)
            call archive%transfer(watched%first_time)
            call archive%transfer(watched%last_time)
            call archive%transfer(watched%worst)
            call archive%transfer(watched%side)
            call archive%transfer(watched%cell)
            call archive%transfer(watched%at)
            call archive%transfer(watched%near)
            call archive%transfer(watched%f)
            call archive%transfer(watched%slope)
            call archive%transfer(watched%parts%value)
            call archive%transfer(watched%parts%wrap)
            call archive%transfer(watched%parts%rate)
            call archive%transfer(watched%followed)
            call archive%transfer(watched%jumped)
            call archive%transfer(watched%lowest)
            call archive%transfer(watched%highest)
            call archive%transfer(watched%seen)
         end associate
      end do
      call archive%transfer(self%switches)
      call archive%transfer(self%next_sample)
      call archive%transfer(self%known)
      call archive%transfer(self%placed)
      call archive%transfer(self%asleep)
      call archive%transfer(self%wakes)
      call archive%transfer(self%steps_asleep)
      do i = 1, size(self%acts)
         call archive%transfer(self%acts(i))
         call archive%transfer(self%pieces(i))
      end do
      call self%motion%state%transfer(archive)
      call self%motion%state%transfer_wheels(archive)
      call archive%transfer(self%motion%omega)
      call archive%transfer(self%motion%momentum)
      call archive%transfer(self%motion%acceleration)
      call archive%transfer(self%motion%potential_torque)
      call archive%transfer(self%motion%torque)
      call archive%transfer(self%motion%wheel_rate)
      call archive%transfer(self%motion%inner_power)
      call self%system%effects%transfer_switches(archive)
      if (archive%is_reading()) self%bounds = bound_motion(self%system)
   end procedure transfer

   module procedure forget_changes
      integer :: i
      do i = 1, size(self%watched)
         if (allocated(self%watched(i)%time_change)) deallocate (self%watched(i)%time_change)
      end do
      if (allocated(self%switch_change)) deallocate (self%switch_change)
   end procedure forget_changes

   module procedure transfer_changes
      integer :: i
      do i = 1, size(self%watched)
         call transfer_one(self%watched(i)%time_change)
      end do
      call archive%transfer(self%switch_time)
      call transfer_one(self%switch_change)

   contains

      subroutine transfer_one(change)
         real(wp), allocatable, intent(inout) :: change(:)
         logical :: known
         known = allocated(change)
         call archive%transfer(known)
         if (.not. known) return
         if (.not. allocated(change)) allocate (change(n), source=0.0_wp)
         call archive%transfer(change)
      end subroutine transfer_one

   end procedure transfer_changes

end submodule nutate_event_tracker_procedures
