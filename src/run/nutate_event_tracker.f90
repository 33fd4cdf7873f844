!> The events of a run and the data kept of each from step to step: on which side of zero its function is, how often it
!> has happened, and when.
module nutate_event_tracker
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_control, only: limit_events, find_limits
   use nutate_effect_list, only: effect_list_t
   use nutate_event, only: CROSSING, event_t, most_parts, part_t, find_family, second_rate
   use nutate_event_roots, only: node_t
   use nutate_kinds, only: wp, eps, long
   use nutate_limit_event, only: limit_event_t, limit_slot_t
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_motion_bounds, only: bound_motion, motion_bounds_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   use nutate_system, only: system_t
   implicit none
   private

   public :: event_list_t, event_slot_t, event_tracker_t, watched_t, bring_near, check_parts

   !> Steps in which the variation of a function is not known yet.
   integer, parameter :: young = 32

   !> Largest number of steps for which one test excludes events: so few that the energy gained in them by a motion that
   !> does not conserve it exactly is within the margins.
   integer, parameter :: most_asleep = 1024

   !> Places in a step, and values of families, that are remembered: the search for each event evaluates the same few.
   integer, parameter :: most_places = 64, most_recalled = 64

   !> Motion at a position in the step that is searched.
   type :: place_t
      !> Position, in steps.
      real(wp) :: s = 0.0_wp
      type(motion_t) :: motion = motion_t()
   end type place_t

   !> Values and rates of a family of quantities at a motion; the family is 0 in a slot that is empty.
   type :: recalled_t
      integer :: family = 0
      type(motion_t) :: motion = motion_t()
      real(wp) :: values(3) = 0.0_wp, rates(3) = 0.0_wp
   end type recalled_t

   !> Holds one event.
   type :: event_slot_t
      class(event_t), allocatable :: item
   end type event_slot_t

   !> The events of a run.
   type :: event_list_t
      type(event_slot_t), allocatable :: slots(:)
   contains
      !> Adds a copy of an event.
      procedure :: add => add_event
      !> Number of events.
      procedure :: count => count_events
   end type event_list_t

   !> One event under way.
   type :: watched_t
      class(event_t), allocatable :: event
      !> Number of times the event has happened.
      integer(long) :: number = 0
      !> First and last time of the event, s.
      real(wp) :: first_time = 0.0_wp, last_time = 0.0_wp
      !> Derivative of the last time by each sensitivity, s a unit of the sensitivity's parameter; shape (n). Not
      !> allocated: the time has no derivative, or there are no sensitivities.
      real(wp), allocatable :: time_change(:)
      !> Largest last increment of an iteration for a time, s.
      real(wp) :: worst = 0.0_wp
      !> The side of zero at the end of the last step, 1 or -1; 0: not known. With a period, if it is known, the
      !> function is from `cell` periods on, up to one more; the last event was at so many periods as `at` says.
      integer :: side = 0
      real(wp) :: cell = 0.0_wp, at = 0.0_wp
      !> The last step ended on the event: the function is zero there, but for so much of its unit, unless a switch has
      !> moved it. 0: the step ended elsewhere.
      real(wp) :: near = 0.0_wp
      !> Function at the end of the last step, and its derivative by time; parts of the function, angles followed from
      !> the first step on.
      real(wp) :: f = 0.0_wp, slope = 0.0_wp
      type(part_t) :: parts(most_parts) = part_t()
      logical :: followed = .false.
      !> Failure for a quantity that was not finite between two steps; zero takes its place there.
      type(status_t) :: start_status
      !> The function has jumped since the last step, because torques have begun or ceased to act, or potentials were
      !> switched.
      logical :: jumped = .false.
      !> Range of the function over the ends of steps evaluated so far, and their number.
      real(wp) :: lowest = huge(1.0_wp), highest = -huge(1.0_wp)
      integer :: seen = 0
   end type watched_t

   !> All events of a run.
   type :: event_tracker_t
      !> Events that the program has set, followed by those of limits; number of the former.
      type(watched_t), allocatable :: watched(:)
      integer :: n_asked = 0
      !> The run is over.
      logical :: stopped = .false.
      !> Events whose switches are to be made, in this order, before the next step.
      integer, allocatable :: due(:)
      integer :: n_due = 0
      !> Switches since the last whole step.
      integer :: switches = 0
      !> Time of the last switch, s, and its derivative by each sensitivity if there are any; shape (n).
      real(wp) :: switch_time = -huge(1.0_wp)
      real(wp), allocatable :: switch_change(:)
      !> Motion at the end of the last step, and the torques that acted in it; with functions and slopes of the events
      !> there, if `known`.
      type(motion_t) :: motion = motion_t()
      logical, allocatable :: acts(:)
      !> Start times of the pieces of the torques that acted, s.
      real(wp), allocatable :: pieces(:)
      logical :: known = .false.
      !> A motion has been noted.
      logical :: placed = .false.
      !> System as it is now, with switches made.
      type(system_t) :: system
      !> Time at which a controller takes its next sample, s; beyond all times if none does, or before the run has
      !> begun.
      real(wp) :: next_sample = huge(1.0_wp)
      !> No event can happen up to the time `wakes`, by bounds of the motion.
      logical :: asleep = .false.
      !> Number of steps without events found last, end of that time, s, and bounds of the motion.
      integer :: steps_asleep = 0
      real(wp) :: wakes = 0.0_wp
      type(motion_bounds_t) :: bounds = motion_bounds_t()
      !> The last positions in the step that is searched, and how many have been evaluated.
      type(place_t), private :: places(most_places) = place_t()
      integer, private :: n_places = 0
      !> Values that may be needed again, and the slot that was filled last.
      type(recalled_t), private :: recalled(most_recalled) = recalled_t()
      integer, private :: last_recalled = 0
   contains
      !> Forgets the positions in the last step; returns, or stores, the motion at a position in a step.
      procedure :: open_places
      procedure :: recall_place
      procedure :: store_place
      procedure :: begin
      !> Sets how often events have happened in an earlier run.
      procedure :: remember
      !> Returns true if no event can happen up to a time.
      procedure :: sleeps_until
      !> Finds out for how long no event can happen.
      procedure :: fall_asleep
      !> Sets a system with other effects on.
      procedure :: set_system
      !> Stores the sides on which the quantities of limits are, as recorded in the system.
      procedure :: hold_sides
      !> Evaluates the parts of an event's function.
      procedure :: evaluate
      !> Evaluates functions and slopes at the start of a step.
      procedure :: open_step
      !> Notes functions and slopes at the position where a step was ended.
      procedure :: place
      !> Returns the size of the variation of a function.
      procedure :: variation
      procedure :: transfer
      !> Writes or reads the derivatives of times in checkpoint data.
      procedure :: transfer_changes
      !> Forgets the derivatives of times, for other sensitivities.
      procedure :: forget_changes
   end type event_tracker_t

contains

   !> Adds a copy of an event.
   subroutine add_event(self, event)
      class(event_list_t), intent(inout) :: self
      class(event_t), intent(in) :: event
      type(event_slot_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%count() + 1))
      do i = 1, self%count()
         call move_alloc(self%slots(i)%item, grown(i)%item)
      end do
      allocate (grown(self%count() + 1)%item, source=event)
      call move_alloc(grown, self%slots)
   end subroutine add_event

   !> Returns the number of events.
   pure integer function count_events(self)
      class(event_list_t), intent(in) :: self
      count_events = 0
      if (allocated(self%slots)) count_events = size(self%slots)
   end function count_events

   !> Sets events, system and first state. Errors: `NUTATE_BAD_ARGUMENT` for a switch of an effect that does not exist.
   subroutine begin(self, events, system, state, status)
      class(event_tracker_t), intent(inout) :: self
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(status_t), intent(inout) :: status
      type(limit_slot_t), allocatable :: limits(:)
      integer :: i
      limits = limit_events(system%effects)
      self%n_asked = events%count()
      allocate (self%watched(self%n_asked + size(limits)), self%due(self%n_asked + size(limits)))
      do i = 1, size(limits)
         allocate (self%watched(self%n_asked + i)%event, source=limits(i)%item)
      end do
      allocate (self%acts(system%effects%n_torques + system%effects%n_wheels), source=.false.)
      allocate (self%pieces(size(self%acts)), source=0.0_wp)
      do i = 1, events%count()
         allocate (self%watched(i)%event, source=events%slots(i)%item)
         associate (event => self%watched(i)%event)
            if (event%action == 0) cycle
            if (.not. system%effects%has(event%effect)) status = fail(NUTATE_BAD_ARGUMENT, &
               "no effect that can be switched is called '"//trim(event%effect)//"'", 'switch')
         end associate
      end do
      call self%set_system(system)
      if (size(limits) == 0) return
      call find_limits(self%system, state)
      call self%hold_sides()
   end subroutine begin

   !> Sets how often the first events have happened in an earlier run, and on which side they are.
   pure subroutine remember(self, before)
      !> Tracker that has begun.
      class(event_tracker_t), intent(inout) :: self
      !> Tracker of the earlier run, with fewer events or more.
      type(event_tracker_t), intent(in) :: before
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
   end subroutine remember

   !> Sets a system with other effects on.
   subroutine set_system(self, system)
      class(event_tracker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      self%system = system
      self%known = .false.
      self%asleep = .false.
      self%bounds = bound_motion(system)
      self%recalled%family = 0
   end subroutine set_system

   !> Forgets the positions in the last step.
   pure subroutine open_places(self)
      class(event_tracker_t), intent(inout) :: self
      self%n_places = 0
   end subroutine open_places

   !> Returns the motion at a position in the step, if it has been stored.
   pure subroutine recall_place(self, s, motion, found)
      class(event_tracker_t), intent(in) :: self
      !> Position, in steps.
      real(wp), intent(in) :: s
      type(motion_t), intent(inout) :: motion
      logical, intent(out) :: found
      integer :: i
      found = .false.
      do i = 1, min(self%n_places, most_places)
         if (abs(self%places(i)%s - s) > 0.0_wp) cycle
         motion = self%places(i)%motion
         found = .true.
         return
      end do
   end subroutine recall_place

   !> Stores the motion at a position in the step, instead of the oldest.
   pure subroutine store_place(self, s, motion)
      class(event_tracker_t), intent(inout) :: self
      !> Position, in steps.
      real(wp), intent(in) :: s
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      self%places(1 + mod(self%n_places, most_places)) = place_t(s, motion)
      self%n_places = self%n_places + 1
   end subroutine store_place

   !> Stores the sides on which the quantities of limits are, as recorded in the system. At its level, the round-off of
   !> a quantity does not determine the side: a command at its limit that is not found to leave it would stay there.
   pure subroutine hold_sides(self)
      class(event_tracker_t), intent(inout) :: self
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
   end subroutine hold_sides

   !> Returns true if no event can happen up to a time.
   pure logical function sleeps_until(self, t, sense)
      class(event_tracker_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> 1: forward in time; -1: backward.
      real(wp), intent(in) :: sense
      sleeps_until = .false.
      if (self%asleep) sleeps_until = sense*(self%wakes - t) >= 0.0_wp
   end function sleeps_until

   !> Finds out, between two steps, for how long no event can happen.
   subroutine fall_asleep(self, t, step)
      !> Tracker whose functions and slopes are known.
      class(event_tracker_t), intent(inout) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Length of the steps, s.
      real(wp), intent(in) :: step
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
   end subroutine fall_asleep

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

   !> Evaluates the parts of an event's function at a motion, and their derivatives by time; angles are not followed.
   pure subroutine evaluate(self, i, system, window_time, motion, parts)
      class(event_tracker_t), intent(inout) :: self
      !> Index of the event.
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      !> Time that decides which torques act, s.
      real(wp), intent(in) :: window_time
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      type(part_t), intent(out) :: parts(most_parts)
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
   end subroutine evaluate

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

   !> Evaluates functions and slopes at the start of a step, as they are in it: they change if other torques act than in
   !> the last step.
   subroutine open_step(self, system, state, window_time)
      class(event_tracker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Time that decides which torques act, s.
      real(wp), intent(in) :: window_time
      type(state_t) :: start
      real(wp) :: before
      logical :: placed
      integer :: i
      call see_torques(self, system, window_time)
      if (self%known) return
      start = state
      placed = self%placed
      ! The state is that observed at the end of the last step: continuous functions are the same to the last digit.
      if (placed .and. .not. abs(self%motion%state%t - state%t) > 0.0_wp) start = self%motion%state
      call find_motion(system, start, self%motion)
      call find_rates(system, window_time, self%motion)
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
   end subroutine open_step

   !> Notes functions and slopes at the position where a step was ended, as they are in the step.
   subroutine place(self, system, state, window_time)
      class(event_tracker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State as the observer receives it.
      type(state_t), intent(in) :: state
      !> Time that decides which torques act, s.
      real(wp), intent(in) :: window_time
      integer :: i
      call find_motion(system, state, self%motion)
      call find_rates(system, window_time, self%motion)
      do i = 1, size(self%watched)
         call evaluate_functions(self, i, system, window_time)
      end do
      self%known = .false.
      self%placed = .true.
   end subroutine place

   !> Errors: `NUTATE_NOT_FINITE` for a quantity, or its rate, that is not finite.
   pure subroutine check_parts(event, parts, status)
      class(event_t), intent(in) :: event
      type(part_t), intent(in) :: parts(most_parts)
      type(status_t), intent(inout) :: status
      if (all(ieee_is_finite(parts%value)) .and. all(ieee_is_finite(parts%rate))) return
      status = fail(NUTATE_NOT_FINITE, "the quantity of the event '"//trim(event%name)//"', or its rate, is not finite")
   end subroutine check_parts

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

   !> Brings parts that are known except for their wraps as near as possible to other values.
   pure subroutine bring_near(parts, values)
      type(part_t), intent(inout) :: parts(most_parts)
      real(wp), intent(in) :: values(most_parts)
      integer :: i
      do i = 1, most_parts
         associate (part => parts(i))
            if (part%wrap > 0.0_wp) part%value = part%value + part%wrap*anint((values(i) - part%value)/part%wrap)
         end associate
      end do
   end subroutine bring_near

   !> Returns the size of the variation of a function: its range so far, and that of an oscillation with the slopes of
   !> the step.
   pure real(wp) function variation(self, i, last, turn)
      class(event_tracker_t), intent(in) :: self
      integer, intent(in) :: i
      !> The end of the step; slope by the time in steps.
      type(node_t), intent(in) :: last
      !> Rotation of the body in the step, rad.
      real(wp), intent(in) :: turn
      associate (watched => self%watched(i))
         variation = 0.0_wp
         if (watched%highest > watched%lowest) variation = watched%highest - watched%lowest
         if (watched%seen < young) variation = max(variation, abs(last%f))
         ! An angle may grow without end.
         if (any(watched%parts%wrap > 0.0_wp)) variation = min(variation, sum(watched%parts%wrap))
         if (turn > eps) variation = max(variation, abs(last%slope)/turn)
      end associate
   end function variation

   !> Writes or reads the data on which the next steps depend in checkpoint data.
   subroutine transfer(self, archive)
      !> Tracker that has begun with the same events and system.
      class(event_tracker_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
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
   end subroutine transfer

   !> Forgets the derivatives of times, for other sensitivities.
   pure subroutine forget_changes(self)
      class(event_tracker_t), intent(inout) :: self
      integer :: i
      do i = 1, size(self%watched)
         if (allocated(self%watched(i)%time_change)) deallocate (self%watched(i)%time_change)
      end do
      if (allocated(self%switch_change)) deallocate (self%switch_change)
   end subroutine forget_changes

   !> Writes or reads the derivatives of times in checkpoint data.
   subroutine transfer_changes(self, n, archive)
      !> Tracker that has begun with the same events and system.
      class(event_tracker_t), intent(inout) :: self
      !> Number of sensitivities.
      integer, intent(in) :: n
      class(archive_t), intent(inout) :: archive
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

   end subroutine transfer_changes

end module nutate_event_tracker
