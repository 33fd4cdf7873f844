!> C interface: runs of a stepper that looks for events, or whose wheels and regulators only a run watches over. What
!> they do stands in `include/nutate_events.h` and `include/nutate_satellites.h`.
module nutate_c_event_runs
   use nutate_c_handles, only: stepper_handle_t
   use nutate_c_polls, only: find_steps_asking
   use nutate_c_rows, only: row_taker_t, write_row
   use nutate_c_settings, only: settings_of_run, take_choice
   use nutate_c_stepping, only: take_back
   use nutate_control, only: free_senses, is_watched, needs_control
   use nutate_kinds, only: wp
   use nutate_progress, only: progress_t
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: run_with_events, needs_whole_run, keep_work

contains

   !> True where single steps would not do: there are events, limits of speed, samples or laws that jump.
   pure logical function needs_whole_run(handle)
      type(stepper_handle_t), intent(in) :: handle
      needs_whole_run = handle%events%count() > 0 .or. is_watched(handle%system%effects)
   end function needs_whole_run

   !> Runs to the end of a plan, or to where an event ends it; the rows are those of the plan. A run that begins where
   !> the last one ended goes on as one with it. Errors: those of the steps, of callbacks and rows; after a failed
   !> callback the state is that before the run.
   subroutine run_with_events(handle, plan, taker, status)
      !> Prepared.
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(inout) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(run_t), allocatable :: run
      type(state_t) :: first
      taker%handle => handle
      taker%sees_every_step = handle%columns%follows_steps
      taker%wants_works = handle%columns%needs_works
      handle%failure = 0
      handle%error = 0.0_wp
      handle%found%n = 0
      first = handle%run%state
      if (.not. abs(plan%end_time - first%t) > 0.0_wp) then
         if (taker%every == 0) call write_row(handle, taker, status)
         return
      end if
      call join_steps(handle, plan)
      if (taker%every > 0) taker%end_time = plan%end_time
      allocate (run)
      if (plan%goal%active()) then
         call run%begin(handle%system, settings_of_run(handle), first, plan, status)
         call take_choice(handle, run%summary)
      else
         call run%begin(handle%system, handle%stepper, first, plan, status)
      end if
      if (status%ok()) call run%expect(handle%events, handle%system, status)
      if (.not. status%ok()) return
      if (is_where_it_ended(handle)) call run%go_on_from(handle%run)
      call find_steps_asking(run, handle%poll, handle%failure, handle%system, status)
      if (status%ok()) call run%go(handle%system, status, taker)
      handle%found_tolerance = run%plan%goal%local_tolerance
      if (handle%failure(1) /= 0) then
         call take_back(handle, first, status)
         handle%found%n = 0
         return
      end if
      if (status%ok()) handle%error = [run%summary%estimate, run%summary%round_off]
      call take_over(handle, run, status%ok() .and. .not. plan%goal%active())
   end subroutine run_with_events

   !> Makes the steps of a plan those behind the steps of the last run, if it has ended on one of its nominal steps;
   !> else what that has done is put to the sums.
   subroutine join_steps(handle, plan)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_plan_t), intent(inout) :: plan
      real(wp) :: grid
      if (.not. plan%goal%active() .and. handle%under_way .and. is_where_it_ended(handle)) then
         associate (run => handle%run)
            plan%steps_before = run%plan%steps_before + run%summary%steps
            plan%first_time = run%t_first
            grid = plan%first_time + real(plan%steps_before, wp)*plan%time_step
            if (abs(grid - run%state%t) > 0.0_wp .or. run%way%begun) plan%steps_before = 0
            if (plan%steps_before > 0 .and. plan%steps > 0) plan%end_time = plan%first_time + &
               real(plan%steps_before + plan%steps, wp)*plan%time_step
         end associate
      end if
      if (plan%steps_before > 0) return
      call keep_work(handle)
      handle%under_way = .false.
   end subroutine join_steps

   !> The state is the one in which the last run with events ended.
   pure logical function is_where_it_ended(handle)
      type(stepper_handle_t), intent(in) :: handle
      is_where_it_ended = allocated(handle%run%events)
      if (.not. is_where_it_ended) return
      associate (last => handle%last_state, here => handle%run%state)
         is_where_it_ended = .not. any(abs([last%t - here%t, last%q - here%q, last%p - here%p, &
                                            last%wheel_momentum - here%wheel_momentum]) > 0.0_wp)
      end associate
   end function is_where_it_ended

   !> Adds the works of the run under way, and its steps without a proof, to those of earlier ones.
   subroutine keep_work(handle)
      type(stepper_handle_t), intent(inout) :: handle
      integer :: i
      associate (summary => handle%run%summary)
         if (.not. allocated(summary%work)) return
         do i = 1, size(summary%work)
            call add_increment(handle%work, handle%work_compensation, summary%work(i))
         end do
         call add_increment(handle%work, handle%work_compensation, summary%world_work)
         handle%works(:) = handle%works + [summary%work, summary%world_work]
         deallocate (summary%work)
         summary%world_work = 0.0_wp
         handle%unproved_steps = handle%unproved_steps + summary%unproved_steps
      end associate
   end subroutine keep_work

   !> Takes state, works, switches and counts of a run that has ended.
   subroutine take_over(handle, run, on_grid)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_t), intent(inout) :: run
      !> It has taken nominal steps, the stepper's own, and no step has failed.
      logical, intent(in) :: on_grid
      if (.not. allocated(handle%given)) allocate (handle%given, source=handle%system%effects)
      handle%system%effects = run%events%system%effects
      if (.not. needs_control(handle%system%effects)) call free_senses(handle%system%effects)
      handle%run = run%progress_t
      handle%last_state = run%state
      handle%under_way = on_grid
      handle%t_reached = run%state%t
      handle%plain = .false.
      handle%ready = handle%ready .and. on_grid
   end subroutine take_over

end module nutate_c_event_runs
