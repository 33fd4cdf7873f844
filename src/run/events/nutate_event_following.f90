!> Events in the steps of a run: each step of the method is searched once it is taken. The observer receives its events
!> in the order of time; a step in which an event stops the run or switches an effect ends at that event.
module nutate_event_following
   use nutate_event, only: CROSSING, event_t, time_scale, SWITCH_OFF, SWITCH_ON
   use nutate_root_search, only: root_search_t
   use nutate_event_roots, only: node_t
   use nutate_event_times, only: crossing_t, find_time_change
   use nutate_event_tracker, only: check_parts
   use nutate_hamiltonian, only: potential_energy, system_t
   use nutate_kinds, only: wp, long
   use nutate_limit_event, only: limit_event_t, SWITCH_LIMIT
   use nutate_motion, only: renew_motion
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: few_rows, is_over, progress_t, put_works, run_point_t, take_back
   use nutate_saturation, only: count_saturations
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_STEP_LIMIT
   use nutate_step_policy, only: step_policy_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: follow_events, make_switches

   !> Largest number of switches in a nominal step; more are treated as endless.
   integer, parameter :: most_switches = 1000

   !> Largest phase of a torque in a step, rad, that is treated like a rotation of the body: faster torques are searched
   !> as finely as this, in eight parts of a step.
   real(wp), parameter :: most_phase = 8.0_wp

contains

   !> Finds the events in the step just taken and passes them to the observer. If one of them stops the run or switches
   !> an effect, the run is taken back to that event.
   !>
   !> Errors: those of the method and of the observer; `NUTATE_STEP_LIMIT` for switches without end, and for an event
   !> that happens more often than the plan allows steps.
   subroutine follow_events(policy, system, progress, mark, searches, observer, status)
      class(step_policy_t), intent(inout), target :: policy
      type(system_t), intent(in), target :: system
      type(progress_t), intent(inout), target :: progress
      !> The run before the step.
      type(run_point_t), intent(in), target :: mark
      !> Searches of all events, created in the first call and kept for the next.
      type(root_search_t), allocatable, intent(inout) :: searches(:)
      class(observer_t), intent(inout), optional :: observer
      type(status_t), intent(inout) :: status
      !> Sensitivities at the present event, if the run propagates any.
      type(tangent_t), allocatable :: sensitivities
      real(wp) :: length
      integer :: i

      associate (events => progress%events)
         length = progress%state%t - mark%state%t
         if (.not. abs(length) > 0.0_wp) return
         call close_step()
         do i = 1, size(events%watched)
            if (status%code == 0 .and. .not. searches(i)%found) call find_next(i, searches(i)%first)
         end do
         if (status%code == 0) call process_in_order()
         if (status%code == 0) call keep_ends()
         ! If the length of the next step is known, steps without events can be excluded from the search.
         if (status%code == 0 .and. .not. policy%longest_step < huge(length)) &
            call events%fall_asleep(progress%state%t, length)
      end associate

   contains

      !> Evaluates functions and slopes at both ends of the step.
      subroutine close_step()
         real(wp) :: window_time, time, turn
         integer :: k
         if (.not. allocated(searches)) allocate (searches(size(progress%events%watched)))
         associate (events => progress%events)
            window_time = 0.5_wp*(mark%state%t + progress%state%t)
            call events%open_step(system, mark%state, window_time)
            events%start = events%motion%state
            time = time_scale(events%motion)
            ! The end of the step is projected for output: states inside the step lead there.
            events%motion%state = progress%state
            call policy%project_for_output(system, events%motion%state)
            call renew_motion(system, window_time, events%motion)
            turn = abs(length)/min(time, time_scale(events%motion))
            turn = max(turn, min(abs(length)*events%bounds%frequency, most_phase))
            do k = 1, size(searches)
               call open_search(k, window_time, turn)
               if (status%code /= 0) return
            end do
         end associate
      end subroutine close_step

      !> Evaluates function and slope of one event at both ends of the step.
      subroutine open_search(k, window_time, turn)
         integer, intent(in) :: k
         !> Time that decides which torques act, s; rotation of the body in the step, rad.
         real(wp), intent(in) :: window_time, turn
         associate (search => searches(k), curve => searches(k)%curve, watched => progress%events%watched(k))
            curve%policy => policy
            curve%system => system
            curve%progress => progress
            curve%mark => mark
            curve%event = k
            curve%is_cheap = policy%evaluates_cheaply
            call progress%events%evaluate(k, system, window_time, progress%events%motion, search%last_parts)
            status = watched%start_status
            call check_parts(watched%event, search%last_parts, status)
            if (status%code /= 0) return
            call curve%join(watched%parts, search%last_parts, turn, status)
            search%first = node_t(f=watched%f, slope=watched%slope*length)
            search%last = node_t(s=1.0_wp, f=sum(search%last_parts%value), slope=sum(search%last_parts%rate)*length)
            if (watched%event%kind == CROSSING) search%last%f = search%last%f - watched%event%level
            search%turn = turn
            ! Backward in time the derivative grows through zero at a maximum.
            search%wanted = watched%event%counted_direction()
            if (watched%event%kind /= CROSSING .and. length < 0.0_wp) search%wanted = -search%wanted
            search%scale = progress%events%variation(k, search%last, turn)
            if (watched%event%kind /= CROSSING) &
               search%pace = watched%event%magnitude(system, progress%events%motion)/abs(length)
            call search%set_sides(watched, is_over(progress))
            watched%lowest = min(watched%lowest, search%last%f)
            watched%highest = max(watched%highest, search%last%f)
            watched%seen = min(watched%seen + 1, 1000)
         end associate
      end subroutine open_search

      !> Looks for the next root of an event after a position.
      subroutine find_next(k, from)
         integer, intent(in) :: k
         type(node_t), intent(in) :: from
         call searches(k)%find_next(from, spacing(max(abs(mark%state%t), abs(length)))/abs(length), status)
      end subroutine find_next

      !> Processes the events in the order of time, up to one that ends the step.
      subroutine process_in_order()
         integer :: k
         logical :: ends
         do
            k = 0
            do i = 1, size(searches)
               if (.not. searches(i)%found) cycle
               if (k == 0) then
                  k = i
               else if (searches(i)%root%s < searches(k)%root%s) then
                  k = i
               end if
            end do
            if (k == 0) return
            associate (watched => progress%events%watched(k))
               ends = watched%event%action /= 0 .or. ends_run(watched%event, watched%number + 1)
            end associate
            if (ends) then
               call end_step_at(searches(k)%root%s)
               return
            end if
            call observe_inside(k)
            if (status%code == 0) call find_next(k, searches(k)%root)
            if (status%code /= 0) return
         end do
      end subroutine process_in_order

      !> Passes an event inside the step to the observer.
      subroutine observe_inside(k)
         integer, intent(in) :: k
         type(state_t) :: state
         type(run_record_t) :: record
         if (allocated(progress%tangent)) sensitivities = progress%tangent
         if (searches(k)%root%s > 0.0_wp) then
            call policy%state_inside(system, progress, mark%state%t + searches(k)%root%s*length, state, status, &
                                     record, sensitivities, mark)
            if (status%code /= 0) return
         else
            state = progress%events%start
            record = progress%record
            call put_works(mark%summary, record)
         end if
         call happen(k, state, record)
      end subroutine observe_inside

      !> Ends the step at an event, and processes all events that happen there.
      subroutine end_step_at(s)
         real(wp), intent(in) :: s
         type(state_t) :: last
         real(wp) :: t, margin
         integer :: k
         last = progress%state
         margin = 2*spacing(max(abs(mark%state%t), abs(last%t)))/abs(length)
         t = mark%state%t + s*length
         if (s <= margin) then
            call take_back(progress, mark)
         else if (1 - s > margin) then
            call take_back(progress, mark)
            call policy%retake(system, progress, t, status)
         end if
         if (status%code == 0 .and. allocated(progress%tangent)) call propagate_to_end(s > margin)
         if (status%code /= 0) return
         call put_works(progress%summary, progress%record)
         last = progress%events%start
         if (s > margin) then
            last = progress%state
            call policy%project_for_output(system, last)
         end if
         do k = 1, size(searches)
            associate (watched => progress%events%watched(k), curve => searches(k)%curve)
               if (curve%follows) watched%parts%value = curve%expect(s)
            end associate
         end do
         call progress%events%place(system, last, mark%state%t + 0.5_wp*length)
         do k = 1, size(searches)
            searches(k)%found = searches(k)%found .and. searches(k)%root%s <= s + margin
            if (.not. searches(k)%found) cycle
            call happen(k, progress%state, progress%record)
            if (status%code /= 0) return
         end do
         do k = 1, size(searches)
            call searches(k)%leave_cut(progress%events%watched(k), searches(k)%found, margin, s > margin)
         end do
         searches%found = .true.
      end subroutine end_step_at

      !> Computes the sensitivities at the end of the step; those of the run stay at its start until the step is
      !> accepted.
      subroutine propagate_to_end(moved)
         !> The end of the step is not its start.
         logical, intent(in) :: moved
         sensitivities = progress%tangent
         if (.not. moved) return
         call policy%propagate(system, mark%state, progress, status)
         call swap(sensitivities, progress%tangent)
      end subroutine propagate_to_end

      !> Computes the derivative of the time of an event; if its function jumped, that of the switch which made it jump,
      !> or 0 if a torque began or stopped.
      subroutine differentiate_time(k, state)
         integer, intent(in) :: k
         type(state_t), intent(in) :: state
         associate (events => progress%events, watched => progress%events%watched(k))
            if (.not. searches(k)%jumped) then
               call find_time_change(watched%event, system, mark%state%t + 0.5_wp*length, state, searches(k)%scale, &
                                     sensitivities, watched%time_change)
            else if (allocated(events%switch_change) .and. .not. abs(events%switch_time - state%t) > 0.0_wp) then
               watched%time_change = events%switch_change
            else
               watched%time_change = 0*sensitivities%work
            end if
            if (.not. present(observer)) return
            if (allocated(observer%time_change)) deallocate (observer%time_change)
            if (allocated(watched%time_change)) observer%time_change = watched%time_change
            if (observer%wants_tangent) observer%tangent = sensitivities
         end associate
      end subroutine differentiate_time

      !> Processes one event: counts it, passes it to the observer, and notes the action that it requires.
      subroutine happen(k, state, record)
         integer, intent(in) :: k
         type(state_t), intent(in) :: state
         type(run_record_t), intent(in) :: record
         associate (events => progress%events, watched => progress%events%watched(k))
            watched%number = watched%number + 1
            if (watched%number > max(progress%plan%max_steps, few_rows)) then
               status = fail(NUTATE_STEP_LIMIT, words_of(watched%event)//' happens more often than steps are allowed')
               return
            end if
            if (watched%number == 1) watched%first_time = state%t
            watched%last_time = state%t
            call searches(k)%pass_root()
            if (abs(searches(k)%root%slope) > 0.0_wp) watched%worst = max(watched%worst, spacing(state%t))
            if (allocated(sensitivities)) call differentiate_time(k, state)
            if (present(observer) .and. k <= events%n_asked) &
               call observer%observe_event(system, watched%event, k, watched%number, state, record, status)
            if (status%code /= 0) return
            if (ends_run(watched%event, watched%number)) events%stopped = .true.
            if (watched%event%action == 0) return
            events%n_due = events%n_due + 1
            events%due(events%n_due) = k
            events%switches = events%switches + 1
            if (events%switches > most_switches) status = fail(NUTATE_STEP_LIMIT, &
               'more than 1000 switches in one step, the last by '//words_of(watched%event)// &
               ': they switch endlessly')
         end associate
      end subroutine happen

      !> Keeps functions and slopes at the end for the next step, unless the step was cut.
      subroutine keep_ends()
         integer :: k
         associate (events => progress%events)
            if (any(searches%found)) return
            if (progress%summary%steps > mark%summary%steps) events%switches = 0
            do k = 1, size(searches)
               call searches(k)%leave_step(events%watched(k), length)
            end do
         end associate
      end subroutine keep_ends

   end subroutine follow_events

   !> Exchanges sensitivities.
   subroutine swap(a, b)
      type(tangent_t), allocatable, intent(inout) :: a, b
      type(tangent_t), allocatable :: c
      call move_alloc(a, c)
      call move_alloc(b, a)
      call move_alloc(c, b)
   end subroutine swap

   !> Returns the description of an event for messages.
   pure function words_of(event) result(words)
      class(event_t), intent(in) :: event
      character(len=:), allocatable :: words
      words = "the event '"//trim(event%name)//"'"
      select type (event)
      class is (limit_event_t)
         words = 'the '//trim(event%words)
      end select
   end function words_of

   !> Returns true if an event ends the run when it happens for the n-th time.
   pure logical function ends_run(event, n)
      class(event_t), intent(in) :: event
      integer(long), intent(in) :: n
      ends_run = event%stop .and. event%count <= 0
      if (event%count > 0) ends_run = n == event%count
   end function ends_run

   !> Performs the switches that are due. The change of the energy of the potentials is counted as work of switches.
   subroutine make_switches(policy, system, progress, status)
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(inout) :: system
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      real(wp) :: before
      type(crossing_t) :: crossing
      logical :: changed, settled
      integer :: i
      associate (events => progress%events)
         if (allocated(progress%tangent)) call crossing%begin(system, progress%state, progress%tangent)
         before = potential_energy(system%effects, progress%state%q, progress%state%t)
         changed = .false.
         settled = .false.
         call count_saturations(system%effects, progress%state%t)
         do i = 1, events%n_due
            associate (event => events%watched(events%due(i))%event)
               select case (event%action)
               case (SWITCH_ON)
                  call system%effects%switch(event%effect, .true.)
               case (SWITCH_OFF)
                  call system%effects%switch(event%effect, .false.)
               case (SWITCH_LIMIT)
                  call settle(event, system, progress%state)
               case default
                  call system%effects%switch(event%effect)
               end select
               changed = changed .or. event%action /= SWITCH_LIMIT
               settled = settled .or. event%action == SWITCH_LIMIT
               if (allocated(progress%tangent)) call crossing%pass(system, progress%state, words_of(event), &
                  events%watched(events%due(i))%time_change, progress%tangent, status)
            end associate
         end do
         if (allocated(progress%tangent)) then
            call crossing%finish(system, progress%state, changed, progress%tangent)
            events%switch_time = progress%state%t
            if (allocated(events%switch_change)) deallocate (events%switch_change)
            associate (last => events%watched(events%due(events%n_due)))
               if (allocated(last%time_change)) events%switch_change = last%time_change
            end associate
         end if
         if (status%code /= 0) return
         events%n_due = 0
         call count_saturations(system%effects, progress%state%t)
         call events%set_system(system)
         if (settled) call events%hold_sides()
         call add_increment(progress%summary%switch_work, progress%switch_compensation, &
                            potential_energy(system%effects, progress%state%q, progress%state%t) - before)
      end associate
      if (changed) then
         ! The invariants are those of another system from now on.
         progress%state%balance%open = .false.
         call policy%renew(system, status)
      else
         call policy%update_commands()
      end if
   end subroutine make_switches

   !> Settles an event of a limit that was reached or left.
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
