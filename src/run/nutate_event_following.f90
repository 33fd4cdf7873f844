!> Events in the steps of a run: each step of the method is searched as it is done; what happens in it is shown in the
!> order of time, and a step in which an event stops the run or switches something ends there.
module nutate_event_following
   use nutate_event, only: CROSSING, event_t, time_scale, SWITCH_OFF, SWITCH_ON, SWITCH_OVER
   use nutate_event_roots, only: curve_t, find_first_root, node_t
   use nutate_event_tracker, only: event_tracker_t, watched_t
   use nutate_hamiltonian, only: potential_energy
   use nutate_kinds, only: wp, eps, long
   use nutate_limit_event, only: limit_event_t, SWITCH_LIMIT
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: progress_t, total_work, way_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_STEP_LIMIT
   use nutate_step_policy, only: step_policy_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: hunt_t, mark_t, mark_progress, follow_events, make_switches

   !> Switches in a nominal step, beyond which they follow each other without end.
   integer, parameter :: most_switches = 1000

   !> Phase of a torque in a step, rad, that counts like a turn of the body: what varies faster is searched as finely
   !> as this, eight parts of a step.
   real(wp), parameter :: most_phase = 8.0_wp

   !> Round-off of a function, over its value.
   real(wp), parameter :: noise = 16*eps

   !> The function of an event along the step.
   type, extends(curve_t) :: step_curve_t
      class(step_policy_t), pointer :: policy => null()
      type(system_t), pointer :: system => null()
      type(progress_t), pointer :: progress => null()
      type(mark_t), pointer :: mark => null()
      !> Which event; its ends, for the branch of a function with a period.
      integer :: event = 0
      type(node_t) :: first = node_t(), last = node_t()
      !> The level that is looked for, from that of the event: whole periods.
      real(wp) :: shift = 0.0_wp
   contains
      procedure :: evaluate
   end type step_curve_t

   !> The search for the next root of one event.
   type :: hunt_t
      type(step_curve_t) :: curve
      real(wp) :: turn = 0.0_wp, scale = 0.0_wp
      !> What the event's `near` was at the start of the step.
      real(wp) :: near = 0.0_wp
      !> The function is zero all through the step but for round-off: there is nothing to find.
      logical :: is_flat = .false.
      logical :: found = .false.
      type(node_t) :: root = node_t()
   end type hunt_t

   !> A run as it was before a step of the method.
   type :: mark_t
      type(state_t) :: state = state_t()
      type(run_record_t) :: record = run_record_t()
      type(way_t) :: way = way_t()
      integer(long) :: steps = 0, cut_steps = 0, parts = 0, iterations = 0, unproved_steps = 0
      !> s.
      real(wp) :: next_break = 0.0_wp
      !> J; shape (number of torques).
      real(wp), allocatable :: work(:), work_compensation(:)
      real(wp) :: total = 0.0_wp
   end type mark_t

contains

   !> Notes how a run is before a step.
   subroutine mark_progress(progress, mark)
      type(progress_t), intent(in) :: progress
      type(mark_t), intent(inout) :: mark
      mark%state = progress%state
      mark%record = progress%record
      mark%way = progress%way
      mark%steps = progress%summary%steps
      mark%cut_steps = progress%summary%cut_steps
      mark%parts = progress%summary%parts
      mark%iterations = progress%summary%iterations
      mark%unproved_steps = progress%summary%unproved_steps
      mark%next_break = progress%next_break
      if (.not. allocated(mark%work)) allocate (mark%work(size(progress%summary%work)), &
                                                mark%work_compensation(size(progress%summary%work)))
      mark%work(:) = progress%summary%work
      mark%work_compensation(:) = progress%work_compensation
      mark%total = total_work(progress%summary)
   end subroutine mark_progress

   !> Takes a run back to where it was.
   subroutine go_back(mark, progress)
      type(mark_t), intent(in) :: mark
      type(progress_t), intent(inout) :: progress
      progress%state = mark%state
      progress%record = mark%record
      progress%way = mark%way
      progress%summary%steps = mark%steps
      progress%summary%cut_steps = mark%cut_steps
      progress%summary%parts = mark%parts
      progress%summary%iterations = mark%iterations
      progress%summary%unproved_steps = mark%unproved_steps
      progress%next_break = mark%next_break
      progress%summary%work(:) = mark%work
      progress%work_compensation(:) = mark%work_compensation
   end subroutine go_back

   !> Finds the events in the step just taken and shows them. Where one of them stops the run or switches an effect, the
   !> run is taken back to there.
   !>
   !> Errors: those of the method and of the observer; `NUTATE_STEP_LIMIT` for switches without end.
   subroutine follow_events(policy, system, progress, mark, hunts, observer, status)
      class(step_policy_t), intent(inout), target :: policy
      type(system_t), intent(in), target :: system
      type(progress_t), intent(inout), target :: progress
      !> The run before the step.
      type(mark_t), intent(in), target :: mark
      !> Made in the first call, and kept for the next.
      type(hunt_t), allocatable, intent(inout) :: hunts(:)
      class(observer_t), intent(inout), optional :: observer
      type(status_t), intent(inout) :: status
      real(wp) :: length
      integer :: i

      associate (events => progress%events)
         length = progress%state%t - mark%state%t
         if (.not. abs(length) > 0.0_wp) return
         call close_step()
         do i = 1, size(events%watched)
            if (status%code == 0) call find_next(i, hunts(i)%curve%first)
         end do
         if (status%code == 0) call take_in_turn()
         if (status%code == 0) call keep_ends()
         ! Where the length of the next step is known, before it.
         if (status%code == 0 .and. .not. policy%longest_step < huge(length)) &
            call events%fall_asleep(progress%state%t, length)
      end associate

   contains

      !> Makes functions and slopes known at both ends.
      subroutine close_step()
         type(motion_t) :: motion
         type(state_t) :: seen
         real(wp) :: window_time, turn, f, slope, guess
         integer :: k
         if (.not. allocated(hunts)) allocate (hunts(size(progress%events%watched)))
         associate (events => progress%events)
            window_time = 0.5_wp*(mark%state%t + progress%state%t)
            call events%open_step(system, mark%state, window_time)
            ! As it is shown: states inside of the step lead there.
            seen = progress%state
            call policy%show(system, seen)
            call find_motion(system, seen, motion)
            call find_rates(system, window_time, motion)
            turn = abs(length)/min(time_scale(events%motion), time_scale(motion))
            turn = max(turn, min(abs(length)*events%bounds%frequency, most_phase))
            do k = 1, size(hunts)
               associate (hunt => hunts(k), watched => events%watched(k))
                  hunt%found = .false.
                  hunt%curve%shift = 0.0_wp
                  hunt%curve%first = node_t(f=watched%f, slope=watched%slope*length)
                  ! By the slope of the start: that of the end is not known yet.
                  guess = watched%f + hunt%curve%first%slope
                  call events%ask(k, system, window_time, motion, guess, f, slope)
                  hunt%curve%last = node_t(s=1.0_wp, f=f, slope=slope*length)
                  hunt%turn = turn
                  hunt%scale = events%variation(k, hunt%curve%last, turn)
                  call set_sides(k, hunt)
                  watched%lowest = min(watched%lowest, f)
                  watched%highest = max(watched%highest, f)
                  watched%seen = min(watched%seen + 1, 1000)
               end associate
            end do
            events%motion = motion
         end associate
      end subroutine close_step

      !> The sides of zero at the ends, of the level next to the middle for a function with a period.
      subroutine set_sides(k, hunt)
         integer, intent(in) :: k
         type(hunt_t), intent(inout) :: hunt
         associate (watched => progress%events%watched(k), first => hunt%curve%first, last => hunt%curve%last)
            if (watched%event%period > 0.0_wp .and. watched%event%kind == CROSSING) then
               hunt%curve%shift = watched%event%period*anint(0.5_wp*(first%f + last%f)/watched%event%period)
               first%f = first%f - hunt%curve%shift
               last%f = last%f - hunt%curve%shift
               ! At the level itself the side is remembered; elsewhere the level may be another one.
               if (abs(first%f) > 1e-6_wp*watched%event%period) watched%side = 0
            end if
            hunt%near = watched%near
            call leave_level(watched, first)
            if (watched%side == 0) watched%side = side_of(first, 1.0_wp)
            first%side = watched%side
            last%side = side_of(last, -1.0_wp)
            if (last%side == 0) last%side = first%side
            if (first%side == 0) first%side = last%side
            hunt%is_flat = max(abs(first%f), abs(last%f), abs(first%slope), abs(last%slope)) <= &
                           noise*(abs(watched%event%level) + hunt%scale)
            if (hunt%is_flat) last%side = first%side
         end associate
      end subroutine set_sides

      !> Looks for the next root of an event behind a place.
      subroutine find_next(k, from)
         integer, intent(in) :: k
         ! By value: it may be the root found last.
         type(node_t), value :: from
         associate (hunt => hunts(k), event => progress%events%watched(k)%event)
            if (hunt%is_flat) return
            hunt%curve%policy => policy
            hunt%curve%system => system
            hunt%curve%progress => progress
            hunt%curve%mark => mark
            hunt%curve%event = k
            hunt%curve%is_cheap = policy%looks_cheaply
            call find_first_root(hunt%curve, from, hunt%curve%last, hunt%turn, hunt%scale, event%wanted(), &
                                 spacing(max(abs(mark%state%t), abs(length)))/abs(length), hunt%found, hunt%root, &
                                 status)
         end associate
      end subroutine find_next

      !> Takes the events in the order of time, up to one that ends the step.
      subroutine take_in_turn()
         integer :: k
         logical :: ends
         do
            k = 0
            do i = 1, size(hunts)
               if (.not. hunts(i)%found) cycle
               if (k == 0) then
                  k = i
               else if (hunts(i)%root%s < hunts(k)%root%s) then
                  k = i
               end if
            end do
            if (k == 0) return
            associate (watched => progress%events%watched(k))
               ends = watched%event%action /= 0 .or. ends_run(watched%event, watched%number + 1)
            end associate
            if (ends) then
               call end_step_at(hunts(k)%root%s)
               return
            end if
            call show_inside(k)
            if (status%code == 0) call find_next(k, hunts(k)%root)
            if (status%code /= 0) return
         end do
      end subroutine take_in_turn

      !> Shows an event inside the step.
      subroutine show_inside(k)
         integer, intent(in) :: k
         type(state_t) :: state
         type(run_record_t) :: record
         real(wp) :: work
         call policy%look_inside(system, mark%state, progress, mark%state%t + hunts(k)%root%s*length, state, work, &
            status)
         if (status%code /= 0) return
         record = progress%record
         record%work = mark%total + work
         call happen(k, state, record)
      end subroutine show_inside

      !> Ends the step at an event, and shows all that happen there.
      subroutine end_step_at(s)
         real(wp), intent(in) :: s
         type(state_t) :: last
         real(wp) :: t, margin
         integer :: k
         last = progress%state
         margin = 2*spacing(max(abs(mark%state%t), abs(last%t)))/abs(length)
         t = mark%state%t + s*length
         if (s <= margin) then
            call go_back(mark, progress)
         else if (1 - s > margin) then
            call go_back(mark, progress)
            call policy%retake(system, progress, t, status)
         end if
         if (status%code /= 0) return
         progress%record%work = total_work(progress%summary)
         do k = 1, size(hunts)
            if (.not. hunts(k)%found) cycle
            if (hunts(k)%root%s > s + margin) cycle
            hunts(k)%near = 4*abs(hunts(k)%root%slope)*margin + noise*(abs(progress%events%watched(k)%event%level) &
                                                                       + hunts(k)%scale)
            hunts(k)%curve%first%side = hunts(k)%root%side
            call happen(k, progress%state, progress%record)
            if (status%code /= 0) return
         end do
         do k = 1, size(hunts)
            progress%events%watched(k)%side = merge(hunts(k)%root%side, hunts(k)%curve%first%side, &
                                                    hunts(k)%found .and. hunts(k)%root%s <= s + margin)
            ! What did not happen now may have done so a moment ago.
            progress%events%watched(k)%near = merge(hunts(k)%near, 0.0_wp, s <= margin .or. &
                                                    (hunts(k)%found .and. hunts(k)%root%s <= s + margin))
         end do
         progress%events%known = .false.
         hunts%found = .true.
      end subroutine end_step_at

      !> One event: counted, shown, and what it asks for put down.
      subroutine happen(k, state, record)
         integer, intent(in) :: k
         type(state_t), intent(in) :: state
         type(run_record_t), intent(in) :: record
         associate (events => progress%events, watched => progress%events%watched(k))
            watched%number = watched%number + 1
            if (watched%number == 1) watched%first_time = state%t
            watched%last_time = state%t
            hunts(k)%curve%first%side = hunts(k)%root%side
            if (abs(hunts(k)%root%slope) > 0.0_wp) watched%worst = max(watched%worst, spacing(state%t))
            if (present(observer) .and. k <= events%n_asked) &
               call observer%show_event(system, watched%event, k, watched%number, state, record, status)
            if (status%code /= 0) return
            if (ends_run(watched%event, watched%number)) events%stopped = .true.
            if (watched%event%action == 0) return
            events%n_due = events%n_due + 1
            events%due(events%n_due) = k
            events%switches = events%switches + 1
            if (events%switches > most_switches) status = fail(NUTATE_STEP_LIMIT, &
               "more than 1000 switches in one step, "// &
               "the last by the event '"//trim(watched%event%name)//"': they follow each other without end")
         end associate
      end subroutine happen

      !> Keeps what is known at the end for the next step, unless the step was cut.
      subroutine keep_ends()
         integer :: k
         associate (events => progress%events)
            if (any(hunts%found)) return
            if (progress%summary%steps > mark%steps) events%switches = 0
            do k = 1, size(hunts)
               associate (watched => events%watched(k), last => hunts(k)%curve%last)
                  watched%f = last%f
                  watched%slope = last%slope/length
                  watched%side = last%side
               end associate
            end do
         end associate
      end subroutine keep_ends

   end subroutine follow_events

   !> True if an event ends the run when it happens for the n-th time.
   pure logical function ends_run(event, n)
      class(event_t), intent(in) :: event
      integer(long), intent(in) :: n
      ends_run = event%stop .and. event%count <= 0
      if (event%count > 0) ends_run = n == event%count
   end function ends_run

   !> Where a step ended on an event, a switch may have turned its function back, or moved it: its side is then that
   !> to which it goes now, so that what only touches its level does not happen twice. But where the event switches
   !> over, to turn back is to switch again: without a dead band that has no end.
   pure subroutine leave_level(watched, first)
      type(watched_t), intent(inout) :: watched
      !> The start of the next step.
      type(node_t), intent(in) :: first
      if (.not. watched%near > 0.0_wp) return
      if (watched%event%action == SWITCH_OVER) then
         watched%near = 0.0_wp
      else if (abs(first%f) > watched%near) then
         watched%side = 0
      else if (abs(first%slope) > 0.0_wp) then
         watched%side = nint(sign(1.0_wp, first%slope))
      end if
      watched%near = 0.0_wp
   end subroutine leave_level

   !> The side of zero on which a curve is; at zero that on which it is just behind, or before.
   pure integer function side_of(node, sense) result(side)
      type(node_t), intent(in) :: node
      !> 1: behind; -1: before.
      real(wp), intent(in) :: sense
      side = 0
      if (node%f > 0.0_wp .or. node%f < 0.0_wp) then
         side = nint(sign(1.0_wp, node%f))
      else if (abs(node%slope) > 0.0_wp) then
         side = nint(sign(1.0_wp, sense*node%slope))
      end if
   end function side_of

   !> The function of an event at a place inside the step.
   subroutine evaluate(self, s, f, slope, status)
      class(step_curve_t), intent(inout) :: self
      real(wp), intent(in) :: s
      real(wp), intent(out) :: f, slope
      type(status_t), intent(inout) :: status
      type(state_t) :: state
      type(motion_t) :: motion
      real(wp) :: start, length, window_time, work
      f = 0.0_wp
      slope = 0.0_wp
      start = self%mark%state%t
      length = self%progress%state%t - start
      window_time = start + 0.5_wp*length
      call self%policy%look_inside(self%system, self%mark%state, self%progress, start + s*length, state, work, status)
      if (status%code /= 0) return
      call find_motion(self%system, state, motion)
      call find_rates(self%system, window_time, motion)
      call self%progress%events%ask(self%event, self%system, window_time, motion, &
                                    self%shift + (1 - s)*self%first%f + s*self%last%f, f, slope)
      f = f - self%shift
      slope = slope*length
   end subroutine evaluate

   !> Makes the switches that are due. What the energy of the potentials changes by is booked as work of the world.
   subroutine make_switches(policy, system, progress, status)
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(inout) :: system
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      real(wp) :: before
      logical :: changed
      integer :: i
      associate (events => progress%events)
         before = potential_energy(system%effects, progress%state%q, progress%state%t)
         changed = .false.
         do i = 1, events%n_due
            associate (event => events%watched(events%due(i))%event)
               select case (event%action)
               case (SWITCH_ON)
                  call system%effects%switch(event%effect, .true.)
               case (SWITCH_OFF)
                  call system%effects%switch(event%effect, .false.)
               case (SWITCH_LIMIT)
                  call settle(event, system, progress%state)
                  ! What others ask for may have jumped with it.
                  events%watched(events%n_asked + 1:)%side = 0
               case default
                  call system%effects%switch(event%effect)
               end select
               changed = changed .or. event%action /= SWITCH_LIMIT
            end associate
         end do
         events%n_due = 0
         call events%take_system(system)
         call add_increment(progress%summary%world_work, progress%world_compensation, &
                            potential_energy(system%effects, progress%state%q, progress%state%t) - before)
      end associate
      if (changed) then
         call policy%renew(system, status)
      else
         call policy%take_commands()
      end if
   end subroutine make_switches

   !> Something has come to its limit, or left it.
   subroutine settle(event, system, state)
      class(event_t), intent(in) :: event
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      select type (event)
      class is (limit_event_t)
         call event%settle(system, state)
      end select
   end subroutine settle

end module nutate_event_following
