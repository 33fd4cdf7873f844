!> C interface: runs of a stepper that looks for events. What they do stands in `include/nutate_events.h`.
module nutate_c_event_runs
   use nutate_c_effects, only: judge_failure
   use nutate_c_handles, only: stepper_handle_t
   use nutate_c_polls, only: find_steps_asking
   use nutate_c_rows, only: row_taker_t, write_row
   use nutate_c_settings, only: prepare_if_needed
   use nutate_c_stepping, only: take_back
   use nutate_event_tracker, only: event_tracker_t
   use nutate_kinds, only: wp
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: run_with_events

contains

   !> Runs to the end of a plan, or to where an event ends it; the rows are those of the plan. Errors: those of the
   !> steps, of callbacks and rows; after a failed callback the state is that before the run.
   subroutine run_with_events(handle, plan, taker, status)
      !> Prepared; the work of runs before has been kept.
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(in) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(run_t), allocatable :: run
      type(state_t) :: first
      taker%handle => handle
      taker%sees_every_step = handle%columns%follows_steps
      handle%failure = 0
      handle%error = 0.0_wp
      handle%found%n = 0
      first = handle%run%state
      if (.not. abs(plan%end_time - first%t) > 0.0_wp) then
         call write_row(handle, taker, status)
         return
      end if
      allocate (run)
      if (plan%goal%active()) then
         call run%begin(handle%system, handle%settings, first, plan, status)
      else
         call run%begin(handle%system, handle%stepper, first, plan, status)
      end if
      if (status%ok()) call run%expect(handle%events, handle%system, status)
      if (.not. status%ok()) return
      call remember(handle, first, run%events)
      call find_steps_asking(run, handle%poll, handle%failure, handle%system, status)
      if (status%ok()) call run%go(handle%system, status, taker)
      handle%found_tolerance = run%plan%goal%local_tolerance
      if (handle%failure(1) /= 0) then
         call take_back(handle, first, status)
         handle%found%n = 0
         return
      end if
      if (status%ok()) handle%error = [run%summary%estimate, run%summary%round_off]
      call take_over(handle, run)
   end subroutine run_with_events

   !> What a run before this one knows of the events, if it ended here: how often they have happened, and on which side
   !> they are.
   subroutine remember(handle, first, events)
      type(stepper_handle_t), intent(in) :: handle
      type(state_t), intent(in) :: first
      type(event_tracker_t), intent(inout) :: events
      integer :: i
      if (.not. allocated(handle%followed)) return
      associate (last => handle%last_state)
         if (any(abs([last%t - first%t, last%q - first%q, last%p - first%p]) > 0.0_wp)) return
      end associate
      do i = 1, min(size(events%watched), size(handle%followed%watched))
         associate (here => events%watched(i), before => handle%followed%watched(i))
            here%number = before%number
            here%first_time = before%first_time
            here%last_time = before%last_time
            here%side = before%side
         end associate
      end do
   end subroutine remember

   !> Takes state, work, switches and counts of a run that has ended.
   subroutine take_over(handle, run)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_t), intent(inout) :: run
      integer :: i
      handle%run%state = run%state
      handle%run%record = run%record
      handle%last_state = run%state
      handle%unproved_steps = handle%unproved_steps + run%summary%unproved_steps
      do i = 1, size(run%summary%work)
         call add_increment(handle%work, handle%work_compensation, run%summary%work(i))
      end do
      call add_increment(handle%work, handle%work_compensation, run%summary%world_work)
      handle%system%effects = run%events%system%effects
      handle%ready = .false.
      handle%plain = .false.
      call move_alloc(run%events, handle%followed)
   end subroutine take_over

end module nutate_c_event_runs
