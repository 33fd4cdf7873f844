!> Work of every run around its steps, however they are chosen: limits, events, output points, polls, checkpoint data.
module nutate_run_loop
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_control, only: check_sampling, next_sample, take_samples
   use nutate_event_following, only: follow_events, make_switches
   use nutate_root_search, only: root_search_t
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp, eps, long
   use nutate_limits, only: same_time
   use nutate_observer, only: observer_t, run_record_t
   use nutate_passed_windows, only: pass_windows, pass_windows_inside
   use nutate_progress, only: few_rows, fraction_done, is_over, progress_t, put_works, run_point_t, sense_of, &
      take_back, transfer_progress
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STEP_LIMIT
   use nutate_step_subdivision, only: spare_tries
   use nutate_step_policy, only: step_policy_t
   implicit none
   private

   public :: drive, transfer_run

   !> Rotation angle between two states, rad, that can be followed; longer rotations are watched in parts of half this
   !> angle. Greatest number of parts, which take some tenths of a millisecond: enough for every step that a method
   !> chooses.
   real(wp), parameter :: followed_angle = 3.0_wp, most_parts = 2e3_wp

contains

   !> Continues a run from where it is to its end, and leaves it with a state projected for output.
   !>
   !> Errors: those of the steps, `NUTATE_STEP_LIMIT`, and what the observer returned. The state is then the last one
   !> reached.
   subroutine drive(progress, policy, first_system, status, observer)
      !> A run that was started, or resumed.
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      !> The system without the switches of events.
      type(system_t), intent(in), target :: first_system
      !> Success on entry.
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      !> The present system: the given one, or that of a run with events.
      type(system_t), pointer :: system
      type(system_t), allocatable, target :: switched
      !> The run before a step, set if the step may be taken back, and the searches of all events.
      type(run_point_t), allocatable :: mark
      type(root_search_t), allocatable :: searches(:)
      system => first_system
      if (present(observer)) then
         if (observer%wants_works) progress%record%works = [progress%summary%work, progress%summary%switch_work]
      end if
      if (allocated(progress%events)) then
         call drive_switched()
      else
         if (present(observer)) call observe_first()
         call take_steps()
         call policy%project_for_output(system, progress%state)
      end if

   contains

      !> Continues a run with events to its end: from switch to switch, with a system of its own.
      subroutine drive_switched()
         switched = progress%events%system
         system => switched
         call sample_state()
         if (present(observer)) call observe_first()
         do
            call take_steps()
            call policy%project_for_output(system, progress%state)
            if (status%code /= 0 .or. .not. (progress%events%n_due > 0 .or. is_sample_due(progress))) exit
            if (progress%events%n_due > 0) then
               call make_switches(policy, system, progress, status)
               deallocate (searches)
            end if
            call sample_state()
            call check_sampling(system, progress%state, status)
            if (status%code /= 0 .or. progress%events%stopped .or. is_over(progress)) exit
         end do
      end subroutine drive_switched

      !> Lets controllers take their samples, if these are due or the controllers were switched.
      subroutine sample_state()
         real(wp) :: sense
         logical :: changed
         sense = sense_of(progress)
         call take_samples(system, progress%state, sense, sample_margin(progress), changed)
         progress%events%next_sample = next_sample(system%effects, progress%state%t + sense*sample_margin(progress), &
                                                   sense)
         if (.not. changed) return
         call progress%events%set_system(system)
         call policy%update_commands()
      end subroutine sample_state

      !> Takes steps to the end of a run, or to the next switch or sample: the only loop there is, for all methods,
      !> policies and interfaces. Each round takes one step of the method, which may be a part of a step of the run.
      subroutine take_steps()
         integer(long) :: steps, next_poll
         real(wp) :: watched, sense, quiet_until
         logical :: over, watches, waits, vets
         type(state_t), allocatable :: before
         next_poll = poll_after(progress, policy)
         over = is_over(progress)
         watches = .false.
         waits = .false.
         vets = .false.
         if (present(observer)) vets = observer%checks_steps
         sense = sense_of(progress)
         quiet_until = -sense*huge(1.0_wp)
         do while (status%code == 0 .and. .not. over)
            steps = progress%summary%steps
            watched = progress%state%t
            if (tries_of(progress) - merge(spare_tries, 0_long, progress%way%begun) >= progress%plan%max_steps) then
               call end_at_limit()
               return
            end if
            ! If an event is possible in the step, a mark is set to which the step can be taken back.
            if (allocated(progress%events)) then
               if (sense*quiet_until < sense*progress%state%t + policy%longest_step) &
                  call see_ahead(sense*policy%longest_step, watches, waits, quiet_until)
            end if
            if (vets .or. watches) mark = progress%run_point_t
            if (allocated(progress%tangent)) before = progress%state
            call policy%advance(system, progress, status, observer)
            over = is_over(progress)
            ! Events are processed in the order of time; the step ends at one that stops the run or switches an effect.
            if (waits .and. status%code == 0) then
               if (watches) watches = .not. progress%events%sleeps_until(progress%state%t, sense)
               if (watches) then
                  call follow_events(policy, system, progress, mark, searches, observer, status)
                  over = progress%events%stopped .or. is_over(progress)
               else if (progress%summary%steps /= steps) then
                  progress%events%switches = 0
               end if
            end if
            if (vets) call vet_step()
            if (allocated(progress%tangent)) call propagate_sensitivities(before)
            if (status%code /= 0) return
            ! The step is accepted now: the observer receives its output points, and is polled.
            if (present(observer)) then
               call observe_step(progress, policy, system, watched, over .or. progress%summary%steps /= steps, over, &
                                 observer, status)
               if (vets .or. tries_of(progress) >= next_poll) call poll_observer(next_poll)
            end if
            if (waits) then
               if (progress%events%n_due > 0 .or. is_sample_due(progress)) return
            end if
         end do
      end subroutine take_steps

      !> Moves the sensitivities over the step that was accepted, if one was.
      subroutine propagate_sensitivities(before)
         !> The start of the step.
         type(state_t), intent(in) :: before
         if (status%code /= 0 .or. .not. abs(progress%state%t - before%t) > 0.0_wp) return
         if (progress%keeps_starts) then
            progress%last_tangent = progress%tangent
            if (allocated(progress%summary%chaos)) progress%last_chaos = progress%summary%chaos
         end if
         call policy%propagate(system, before, progress, status)
         if (status%code == 0) call pass_windows(progress, system, before%t)
         if (.not. allocated(progress%summary%chaos) .or. status%code /= 0) return
         ! A switch that is due needs the sensitivities by which the derivative of its time was computed.
         if (is_switch_due(progress)) return
         call progress%summary%chaos%follow(system, progress%state, progress%tangent, status)
      end subroutine propagate_sensitivities

      !> Ends a run that may not take more steps.
      subroutine end_at_limit()
         status = fail(NUTATE_STEP_LIMIT, 'the run needs more steps than allowed')
         if (.not. present(observer)) return
         if (observer%saves_at_step_limit) call offer()
      end subroutine end_at_limit

      !> Takes a step back and ends the run if the observer rejects the step.
      subroutine vet_step()
         type(status_t) :: verdict, renewed
         call observer%check_step(verdict)
         if (verdict%ok()) return
         status = verdict
         call take_back(progress, mark)
         call policy%renew(system, renewed)
      end subroutine vet_step

      !> Polls the observer, and saves the checkpoint that it then wants; not before a switch that is due.
      subroutine poll_observer(next_poll)
         !> Tries after which the next poll is due.
         integer(long), intent(inout) :: next_poll
         if (status%code /= 0 .or. is_switch_due(progress)) return
         next_poll = poll_after(progress, policy)
         call observer%poll(fraction_done(progress), status)
         if (observer%wants_checkpoint) call offer()
      end subroutine poll_observer

      !> Determines whether an event, a switch or a sample is possible in the next step.
      subroutine see_ahead(step, watches, waits, quiet_until)
         !> Greatest length of the step, s.
         real(wp), intent(in) :: step
         !> True if the step must be searched for events.
         logical, intent(out) :: watches
         !> True if a switch or a sample may be due at its end.
         logical, intent(out) :: waits
         !> Time up to which only whole steps matter, s.
         real(wp), intent(out) :: quiet_until
         type(state_t) :: seen
         real(wp) :: sense
         quiet_until = -sign(huge(1.0_wp), step)
         associate (events => progress%events, state => progress%state)
            watches = size(events%watched) > 0
            if (watches .and. abs(step) < huge(step)) then
               sense = sign(1.0_wp, step)
               watches = .not. events%sleeps_until(state%t + step, sense)
               if (watches) then
                  if (.not. events%known) then
                     seen = state
                     call policy%project_for_output(system, seen)
                     call events%open_step(system, seen, state%t + 0.5_wp*step)
                  end if
                  call events%fall_asleep(state%t, step)
                  watches = .not. events%sleeps_until(state%t + step, sense)
               end if
            end if
         end associate
         waits = watches .or. progress%way%begun .or. abs(progress%events%next_sample) < huge(1.0_wp)
         if (.not. waits) then
            quiet_until = progress%events%wakes
            progress%events%switches = 0
         end if
         progress%keeps_starts = waits .or. allocated(progress%plan%times) .or. progress%keeps_dense_output
      end subroutine see_ahead

      !> Passes the first output point to the observer, unless the run was resumed after it, or the plan has other
      !> times.
      subroutine observe_first()
         real(wp) :: t
         logical :: due
         due = .not. progress%resumed
         if (due .and. allocated(progress%plan%times)) then
            call find_row(progress, t, due)
            if (due) progress%rows = progress%rows + 1
         end if
         if (due) call give_sensitivities(progress, observer)
         if (due) call observer%observe(system, progress%state, progress%record, status)
         if (observer%wants_checkpoint .and. status%ok()) call offer()
      end subroutine observe_first

      !> Writes checkpoint data and passes them to the observer.
      subroutine offer()
         type(byte_archive_t) :: archive
         type(status_t) :: kept
         call archive%begin_writing()
         call transfer_run(progress, policy, archive)
         observer%wants_checkpoint = .false.
         call observer%save_checkpoint(archive, kept)
         if (status%ok()) status = kept
      end subroutine offer

   end subroutine drive

   !> Returns true if a switch is due: it comes before everything else, since checkpoints hold none that are due.
   pure logical function is_switch_due(progress)
      type(progress_t), intent(in) :: progress
      is_switch_due = .false.
      if (allocated(progress%events)) is_switch_due = progress%events%n_due > 0
   end function is_switch_due

   !> Returns true at a sample of a controller.
   pure logical function is_sample_due(progress)
      type(progress_t), intent(in) :: progress
      is_sample_due = sense_of(progress)*(progress%events%next_sample - progress%state%t) <= sample_margin(progress)
   end function is_sample_due

   !> Returns the time, s, within which a sample coincides with the end of a step: no further step ends for it.
   pure real(wp) function sample_margin(progress) result(margin)
      type(progress_t), intent(in) :: progress
      associate (plan => progress%plan)
         margin = same_time*abs(plan%time_step) + 4*eps*max(abs(progress%state%t), abs(plan%end_time))
      end associate
   end function sample_margin

   !> Passes the sensitivities at the last state to an observer that requires them.
   subroutine give_sensitivities(progress, observer)
      type(progress_t), intent(in) :: progress
      class(observer_t), intent(inout) :: observer
      if (.not. (observer%wants_tangent .and. allocated(progress%tangent))) return
      observer%tangent = progress%tangent
      if (allocated(progress%summary%chaos)) observer%chaos = progress%summary%chaos
   end subroutine give_sensitivities

   !> Returns the number of steps so far, with the parts of subdivided ones: one step may take thousands.
   pure integer(long) function tries_of(progress) result(tries)
      type(progress_t), intent(in) :: progress
      tries = progress%summary%parts + progress%record%continued
   end function tries_of

   !> Returns the number of tries after which the next poll is due.
   pure integer(long) function poll_after(progress, policy) result(tries)
      type(progress_t), intent(in) :: progress
      class(step_policy_t), intent(in) :: policy
      tries = (tries_of(progress)/policy%steps_per_poll + 1)*policy%steps_per_poll
   end function poll_after

   !> Passes the output points in the accepted step of the method to the observer, and lets it watch the step.
   subroutine observe_step(progress, policy, system, watched, ends, over, observer, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(in) :: system
      !> Time up to which the observer watched, s.
      real(wp), intent(inout) :: watched
      !> A step of the run ends there; it was the last one.
      logical, intent(in) :: ends, over
      class(observer_t), intent(inout) :: observer
      type(status_t), intent(inout) :: status
      logical :: between
      if (.not. (ends .or. abs(progress%state%t - watched) > 0.0_wp)) return
      associate (plan => progress%plan)
         between = allocated(plan%times) .or. (plan%interval > 0.0_wp .and. .not. observer%rows_at_steps)
         if (between) call observe_inside()
         if (ends .and. .not. allocated(plan%times) .and. &
             (over .or. .not. between .and. mod(progress%summary%steps - progress%first_step, plan%every) == 0)) then
            call observe_end()
         else if (observer%observes_every_step) then
            call watch_rotation(progress%state)
         end if
      end associate

   contains

      !> Passes the present state to the observer as an output point.
      subroutine observe_end()
         type(state_t) :: seen
         seen = progress%state
         call policy%project_for_output(system, seen)
         if (observer%observes_every_step) call watch_rotation(seen)
         if (status%code /= 0) return
         call put_works(progress%summary, progress%record)
         call give_sensitivities(progress, observer)
         call observer%observe(system, seen, progress%record, status)
      end subroutine observe_end

      !> Passes the output points at intervals, or at times of the plan, inside the last step to the observer. Errors:
      !> `NUTATE_STEP_LIMIT` if there are more of them at intervals than the plan allows steps; those of the method, and
      !> of the observer.
      subroutine observe_inside()
         type(state_t) :: state
         type(run_record_t) :: record
         real(wp) :: t
         logical :: due
         call find_row(progress, t, due)
         do while (due .and. status%code == 0)
            progress%rows = progress%rows + 1
            if (progress%rows > max(progress%plan%max_steps, few_rows) .and. .not. allocated(progress%plan%times)) then
               status = fail(NUTATE_STEP_LIMIT, 'the run needs more rows than steps are allowed')
               exit
            end if
            if (allocated(progress%plan%times) .and. .not. abs(t - progress%state%t) > 0.0_wp) then
               call observe_end()
            else
               if (observer%wants_tangent .and. allocated(progress%tangent)) then
                  observer%tangent = progress%last_tangent
                  if (allocated(progress%last_chaos)) observer%chaos = progress%last_chaos
                  call policy%state_inside(system, progress, t, state, status, record, observer%tangent)
                  if (status%ok()) call pass_windows_inside(progress, system, state, observer%tangent)
               else
                  call policy%state_inside(system, progress, t, state, status, record)
               end if
               if (observer%observes_every_step .and. status%ok()) call watch_rotation(state)
               if (status%ok()) call observer%observe(system, state, record, status)
            end if
            call find_row(progress, t, due)
         end do
      end subroutine observe_inside

      !> Lets the observer watch the states inside the last step from a time up to a state, and this one: so many that
      !> no revolution is lost.
      subroutine watch_rotation(state)
         type(state_t), intent(in) :: state
         real(wp) :: angle
         integer :: i, n
         n = 1
         if (policy%is_dense) then
            angle = norm2(angular_velocity(system, state))*abs(state%t - watched)
            if (angle > followed_angle) n = int(min(2*angle, most_parts)/followed_angle) + 1
         end if
         do i = 1, n - 1
            block
               type(state_t) :: inside
               call policy%state_inside(system, progress, watched + (real(i, wp)/n)*(state%t - watched), inside, status)
               call observer%observe_step(inside)
            end block
            if (status%code /= 0) return
         end do
         call observer%observe_step(state)
         watched = state%t
      end subroutine watch_rotation

   end subroutine observe_step

   !> Finds the time of the next output point at intervals or at times of the plan, and whether the run has reached
   !> it.
   pure subroutine find_row(progress, t, due)
      type(progress_t), intent(in) :: progress
      !> s; undefined if no output point is due.
      real(wp), intent(out) :: t
      logical, intent(out) :: due
      real(wp) :: sense
      associate (plan => progress%plan)
         sense = sense_of(progress)
         t = progress%state%t
         if (allocated(plan%times)) then
            due = progress%rows < size(plan%times)
            if (due) t = plan%times(progress%rows + 1)
         else
            t = progress%t_first + sense*plan%interval*real(progress%rows + 1, wp)
            due = sense*(plan%end_time - t) > same_time*plan%interval + &
                  min(4*eps*max(abs(progress%t_first), abs(plan%end_time)), 0.25_wp*plan%interval)
         end if
         due = due .and. sense*(t - progress%state%t) <= 0.0_wp
      end associate
   end subroutine find_row

   !> Writes or reads in checkpoint data everything that changes in a run.
   subroutine transfer_run(progress, policy, archive)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      class(archive_t), intent(inout) :: archive
      type(status_t) :: status
      call transfer_progress(progress, archive)
      if (allocated(progress%events) .and. archive%is_reading()) then
         call policy%renew(progress%events%system, status)
         if (.not. status%ok()) call archive%refuse(trim(status%message))
      end if
      call policy%transfer(archive)
   end subroutine transfer_run

end module nutate_run_loop
