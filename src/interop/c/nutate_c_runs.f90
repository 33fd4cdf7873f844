!> C interface: runs of many steps. What each function does stands in `include/nutate.h`.
module nutate_c_runs
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int64_t, c_ptr, c_size_t
   use nutate_admissible, only: admits, POSITIVE
   use nutate_c_event_runs, only: keep_work, needs_whole_run, run_with_events
   use nutate_c_handles, only: conclude, find_stepper, stepper_handle_t
   use nutate_c_polls, only: integrate_asking, steps_between_looks
   use nutate_c_rows, only: row_taker_t, write_row
   use nutate_c_settings, only: prepare_if_needed, settings_of_run, take_choice
   use nutate_c_stepping, only: take_back, test_step
   use nutate_columns, only: columns_t
   use nutate_fixed_steps, only: count_steps, take_nominal_step
   use nutate_kinds, only: wp, long
   use nutate_limits, only: is_countable, is_moderate
   use nutate_progress, only: is_over, run_summary_t, start_run
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_OK
   implicit none
   private

   public :: nutate_stepper_run, nutate_stepper_run_to, nutate_stepper_count_rows, run_to

contains

   integer(c_int) function nutate_stepper_run(stepper, n, every, rows, capacity, n_rows) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, rows
      integer(c_int64_t), intent(in), value :: n, every
      integer(c_size_t), intent(in), value :: capacity
      integer(c_size_t), intent(inout), optional :: n_rows
      type(stepper_handle_t), pointer :: handle
      type(row_taker_t) :: taker
      type(run_plan_t) :: plan
      type(status_t) :: status
      if (present(n_rows)) n_rows = 0
      code = NUTATE_BAD_HANDLE
      handle => find_stepper(stepper)
      if (.not. associated(handle)) return
      taker%array = rows
      taker%capacity = capacity
      call get_going(handle, status)
      if (status%ok() .and. (n < 0 .or. every < 1)) &
         status = fail(NUTATE_BAD_ARGUMENT, 'n is negative, or every not positive', 'n')
      if (status%ok()) call taker%take(handle%columns%width, n/every, status)
      if (status%ok() .and. needs_whole_run(handle)) then
         taker%every = every
         plan = run_plan_t(end_time=handle%run%state%t + n*handle%plan%time_step, every=every, steps=n)
         call look_for_events(handle, plan, taker, status)
      else if (status%ok()) then
         handle%run%plan%end_time = handle%run%state%t
         handle%run%n_steps = huge(n)
         call continue_run(handle, n, every, taker, status)
      end if
      if (present(n_rows)) n_rows = taker%rows
      code = conclude(handle, status)
   end function nutate_stepper_run

   integer(c_int) function nutate_stepper_run_to(stepper, end_time, every, interval, rows, capacity, n_rows) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, rows
      real(c_double), intent(in), value :: end_time, interval
      integer(c_int64_t), intent(in), value :: every
      integer(c_size_t), intent(in), value :: capacity
      integer(c_size_t), intent(inout), optional :: n_rows
      type(stepper_handle_t), pointer :: handle
      type(row_taker_t) :: taker
      type(run_plan_t) :: plan
      type(status_t) :: status
      if (present(n_rows)) n_rows = 0
      code = NUTATE_BAD_HANDLE
      handle => find_stepper(stepper)
      if (.not. associated(handle)) return
      taker%array = rows
      taker%capacity = capacity
      plan = run_plan_t(end_time=end_time, every=every, interval=interval)
      call run_to(handle, plan, taker, status)
      if (present(n_rows)) n_rows = taker%rows
      code = conclude(handle, status)
   end function nutate_stepper_run_to

   integer(c_int) function nutate_stepper_count_rows(stepper, end_time, every, n_rows) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: end_time
      integer(c_int64_t), intent(in), value :: every
      integer(c_size_t), intent(inout), optional :: n_rows
      type(stepper_handle_t), pointer :: handle
      integer(long) :: n
      code = NUTATE_BAD_HANDLE
      handle => find_stepper(stepper)
      if (.not. associated(handle)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(n_rows) .or. every < 1 .or. .not. is_moderate(end_time) .or. handle%stale) return
      if (.not. abs(handle%plan%time_step) > 0.0_wp .or. handle%plan%goal%active()) return
      n = steps_to(handle, end_time)
      if (n < 0) return
      n_rows = rows_of(n, every)
      code = NUTATE_OK
   end function nutate_stepper_count_rows

   !> Runs to the end time of a plan that says when rows are due: with nominal steps, or steps chosen by their error.
   !> Errors: `NUTATE_BAD_ARGUMENT`, why a step failed, those of callbacks and rows.
   subroutine run_to(handle, plan, taker, status)
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(inout) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(out) :: status
      call check_run(handle, plan, status)
      if (.not. status%ok()) return
      if (handle%plan%goal%active()) then
         plan%goal = handle%plan%goal
         call run_by_plan(handle, plan, taker, status)
      else if (allocated(plan%times)) then
         call get_going(handle, status)
         plan%time_step = handle%plan%time_step
         if (status%ok()) call run_by_plan(handle, plan, taker, status)
      else
         call run_nominal(handle, plan, taker, status)
      end if
   end subroutine run_to

   !> Prepares what nominal steps need. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine get_going(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      call prepare_if_needed(handle, status)
      if (.not. status%ok()) return
      if (handle%plan%goal%active() .or. .not. abs(handle%plan%time_step) > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'no time_step is set', 'time_step')
         return
      end if
      call test_step(handle, handle%plan%time_step, status)
      if (needs_whole_run(handle)) return
      if (status%ok() .and. .not. is_on_grid(handle)) call start_grid(handle, status)
   end subroutine get_going

   !> The state is where the run under way has left it.
   pure logical function is_on_grid(handle)
      type(stepper_handle_t), intent(in) :: handle
      is_on_grid = handle%under_way .and. .not. abs(handle%run%state%t - handle%t_reached) > 0.0_wp
   end function is_on_grid

   !> Starts a run without an end at the present state.
   subroutine start_grid(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      type(run_plan_t) :: endless
      type(state_t) :: state
      call keep_work(handle)
      endless%time_step = handle%plan%time_step
      endless%end_time = sign(huge(1.0_wp), handle%plan%time_step)
      state = handle%run%state
      call start_run(handle%run, handle%system%effects, state, endless, status)
      handle%under_way = status%ok()
      handle%t_reached = state%t
   end subroutine start_grid

   !> Nominal steps of the run under way, the last of which ends the run if it is that of its plan: then it is a row in
   !> any case. Errors: why a step failed; those of callbacks and rows.
   subroutine continue_run(handle, n, every, taker, status)
      type(stepper_handle_t), intent(inout), target :: handle
      !> Number of steps, and of those between rows.
      integer(long), intent(in) :: n, every
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(state_t) :: before
      type(columns_t) :: columns
      real(wp), allocatable :: works(:)
      integer(long) :: i, unproved
      taker%handle => handle
      taker%sees_every_step = handle%columns%follows_steps
      handle%failure = 0
      do i = 1, n
         if (handle%calls_back) then
            before = handle%run%state
            if (taker%sees_every_step) columns = handle%columns
            works = handle%run%summary%work
            unproved = handle%run%summary%unproved_steps
         end if
         call take_nominal_step(handle%stepper, handle%system, handle%run, status, taker)
         if (handle%failure(1) /= 0) then
            if (taker%sees_every_step) handle%columns = columns
            call take_back(handle, before, status)
            deallocate (handle%run%summary%work)
            call add_increment(handle%work, handle%work_compensation, sum(works))
            handle%works(:) = handle%works + [works, 0.0_wp]
            handle%unproved_steps = handle%unproved_steps + unproved
            handle%under_way = .false.
         end if
         if (status%code /= 0) exit
         handle%t_reached = handle%run%state%t
         if (taker%sees_every_step) call handle%columns%follow(handle%run%state)
         if (taker%wants_rows) then
            if (mod(i, every) == 0 .or. is_over(handle%run)) call write_row(handle, taker, status)
            if (status%code /= 0) exit
         end if
         if (mod(i, steps_between_looks) == 0) call handle%poll%ask(status)
         if (status%code /= 0) exit
      end do
      if (handle%run%n_steps < huge(n)) handle%under_way = .false.
   end subroutine continue_run

   !> Tests the arguments of a run to a time. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_run(handle, plan, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      call prepare_if_needed(handle, status)
      if (.not. status%ok()) return
      if (.not. (is_moderate(plan%end_time) .and. is_moderate(plan%interval)) .or. plan%every < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'end_time or interval is not finite, or every not positive', 'end_time')
      else if (plan%interval < 0.0_wp .or. (plan%interval > 0.0_wp .and. .not. handle%plan%goal%active())) then
         status = fail(NUTATE_BAD_ARGUMENT, 'interval is negative, or needs accuracy or local_tolerance', 'interval')
      else if (plan%interval > 0.0_wp .and. .not. &
               (admits(POSITIVE, [plan%interval]) .and. &
                is_countable(plan%end_time - handle%run%state%t, plan%interval))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'interval is too small for end_time (expected less than 9e15 rows)', &
                       'interval')
      end if
   end subroutine check_run

   !> Nominal steps to the end time of a plan.
   subroutine run_nominal(handle, plan, taker, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_plan_t), intent(in) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      integer(long) :: n
      call get_going(handle, status)
      if (.not. status%ok()) return
      n = steps_to(handle, plan%end_time)
      if (n < 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time step does not lead to the end time, or not in 9e15 steps', &
                       'end_time')
         return
      end if
      call taker%take(handle%columns%width, rows_of(n, plan%every), status)
      handle%failure = 0
      if (status%ok() .and. needs_whole_run(handle)) then
         call look_for_events(handle, plan, taker, status)
         return
      end if
      if (status%ok() .and. taker%wants_rows) call write_row(handle, taker, status)
      if (.not. status%ok()) return
      handle%run%plan%end_time = plan%end_time
      handle%run%n_steps = handle%run%summary%steps + n
      call continue_run(handle, n, plan%every, taker, status)
   end subroutine run_nominal

   !> Number of nominal steps to a time, the last one shortened if need be; negative where they lead away from it
   !> or are too many to count.
   pure integer(long) function steps_to(handle, end_time) result(n)
      type(stepper_handle_t), intent(in) :: handle
      !> s.
      real(wp), intent(in) :: end_time
      type(run_plan_t) :: plan
      n = -1
      if ((end_time - handle%run%state%t)*sign(1.0_wp, handle%plan%time_step) < 0.0_wp) return
      if (.not. is_countable(end_time - handle%run%state%t, handle%plan%time_step)) return
      plan%time_step = handle%plan%time_step
      plan%end_time = end_time
      if (is_on_grid(handle) .and. .not. needs_whole_run(handle)) then
         n = count_steps(handle%run%t_first, plan) - handle%run%summary%steps
      else
         n = count_steps(handle%run%state%t, plan)
      end if
      n = max(n, 0_long)
   end function steps_to

   !> Rows of a run to a time: the first state, those every so often, and the last.
   pure integer(long) function rows_of(n, every) result(rows)
      !> Steps of the run, and between rows.
      integer(long), intent(in) :: n, every
      rows = 1 + n/every
      if (mod(n, every) > 0) rows = rows + 1
   end function rows_of

   !> A run that looks for events, from the present state.
   subroutine look_for_events(handle, plan, taker, status)
      type(stepper_handle_t), intent(inout) :: handle
      !> The nominal step may be missing.
      type(run_plan_t), intent(in) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(run_plan_t) :: whole
      whole = plan
      if (.not. plan%goal%active()) whole%time_step = handle%plan%time_step
      call run_with_events(handle, whole, taker, status)
   end subroutine look_for_events

   !> Steps that the run itself chooses, to the end time of a plan. Errors: those of the method, of callbacks and rows;
   !> after a failed callback the state is that before the run.
   subroutine run_by_plan(handle, plan, taker, status)
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(inout) :: plan
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(run_summary_t) :: summary
      type(state_t) :: first, state
      integer :: i

      call taker%take(handle%columns%width, 0_long, status)
      if (status%ok() .and. needs_whole_run(handle)) call look_for_events(handle, plan, taker, status)
      if (.not. status%ok() .or. needs_whole_run(handle)) return
      taker%handle => handle
      taker%sees_every_step = handle%columns%follows_steps
      taker%wants_works = handle%columns%needs_works
      handle%failure = 0
      handle%error = 0.0_wp
      first = handle%run%state
      state = first
      call keep_work(handle)
      handle%under_way = .false.
      if (abs(plan%end_time - state%t) > 0.0_wp) then
         call integrate_asking(handle%poll, handle%failure, handle%system, settings_of_run(handle), state, plan, &
                               status, taker, summary)
         call take_choice(handle, summary)
         handle%found_tolerance = plan%goal%local_tolerance
      else if (.not. allocated(plan%times)) then
         call write_row(handle, taker, status)
      else if (size(plan%times) > 0) then
         call write_row(handle, taker, status)
      end if
      if (handle%failure(1) /= 0) then
         call take_back(handle, first, status)
         return
      end if
      handle%run%state = state
      handle%ready = .false.
      handle%plain = .false.
      if (status%ok()) handle%error = [summary%estimate, summary%round_off]
      if (.not. allocated(summary%work)) return
      handle%unproved_steps = handle%unproved_steps + summary%unproved_steps
      do i = 1, size(summary%work)
         call add_increment(handle%work, handle%work_compensation, summary%work(i))
      end do
      handle%works(:) = handle%works + [summary%work, summary%world_work]
   end subroutine run_by_plan

end module nutate_c_runs
