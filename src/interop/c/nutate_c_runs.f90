!> C interface: runs of many steps. The functions are documented in `include/nutate_stepper.h`.
module nutate_c_runs
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int64_t, c_ptr, c_size_t
   use nutate_admissible, only: admits, POSITIVE
   use nutate_c_effects, only: add_failure, has_callbacks
   use nutate_c_stepper_handle, only: conclude, found, stepper_handle_t
   use nutate_c_polls, only: find_steps_asking
   use nutate_c_rows, only: row_receiver_t, write_row
   use nutate_c_settings, only: prepare_if_needed
   use nutate_c_stepping, only: test_step
   use nutate_control, only: free_senses, needs_control
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_kinds, only: wp, long
   use nutate_limits, only: is_countable, is_moderate
   use nutate_method_choice, only: choose_with_tangent
   use nutate_run_plan, only: run_plan_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OK
   implicit none
   private

   public :: nutate_stepper_run, nutate_stepper_run_to, nutate_stepper_count_rows, run_to, travel

contains

   integer(c_int) function nutate_stepper_run(stepper, n, every, rows, capacity, n_rows) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, rows
      integer(c_int64_t), intent(in), value :: n, every
      integer(c_size_t), intent(in), value :: capacity
      integer(c_size_t), intent(inout), optional :: n_rows
      type(stepper_handle_t), pointer :: handle
      type(row_receiver_t) :: receiver
      type(run_plan_t) :: plan
      type(status_t) :: status
      if (present(n_rows)) n_rows = 0
      if (.not. found(stepper, handle, code)) return
      receiver%array = rows
      receiver%capacity = capacity
      call get_going(handle, status)
      if (status%ok() .and. (n < 0 .or. every < 1)) &
         status = fail(NUTATE_BAD_ARGUMENT, 'n is negative, or every not positive', 'n')
      if (status%ok()) call receiver%open_array(handle%columns%width, n/every, status)
      if (status%ok()) then
         receiver%leaves_out_ends = .true.
         plan = run_plan_t(time_step=handle%plan%time_step, every=every, steps=n, &
                           end_time=handle%run%end_of_steps(n, handle%plan%time_step))
         call travel(handle, plan, receiver, status)
      end if
      if (present(n_rows)) n_rows = receiver%rows
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
      type(row_receiver_t) :: receiver
      type(run_plan_t) :: plan
      type(status_t) :: status
      if (present(n_rows)) n_rows = 0
      if (.not. found(stepper, handle, code)) return
      receiver%array = rows
      receiver%capacity = capacity
      plan = run_plan_t(end_time=end_time, every=every, interval=interval)
      call run_to(handle, plan, receiver, status)
      if (present(n_rows)) n_rows = receiver%rows
      code = conclude(handle, status)
   end function nutate_stepper_run_to

   integer(c_int) function nutate_stepper_count_rows(stepper, end_time, every, n_rows) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: end_time
      integer(c_int64_t), intent(in), value :: every
      integer(c_size_t), intent(inout), optional :: n_rows
      type(stepper_handle_t), pointer :: handle
      integer(long) :: n
      if (.not. found(stepper, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(n_rows) .or. every < 1 .or. .not. is_moderate(end_time) .or. handle%stale) return
      if (.not. abs(handle%plan%time_step) > 0.0_wp .or. handle%plan%goal%active()) return
      n = steps_to(handle, end_time)
      if (n < 0) return
      n_rows = rows_of(n, every)
      code = NUTATE_OK
   end function nutate_stepper_count_rows

   !> Runs to the end time of a plan, which defines when rows are due, with nominal steps or adaptive steps. Errors:
   !> `NUTATE_BAD_ARGUMENT`, those of steps, callbacks and rows.
   subroutine run_to(handle, plan, receiver, status)
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(inout) :: plan
      type(row_receiver_t), intent(inout) :: receiver
      type(status_t), intent(out) :: status
      integer(long) :: n, rows
      call check_run(handle, plan, status)
      if (.not. status%ok()) return
      rows = 0
      if (handle%plan%goal%active()) then
         plan%goal = handle%plan%goal
      else
         call get_going(handle, status)
         if (.not. status%ok()) return
         plan%time_step = handle%plan%time_step
         n = steps_to(handle, plan%end_time)
         if (n < 0) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the time step does not lead to the end time, or not in 9e15 steps', &
                          'end_time')
            return
         end if
         if (.not. allocated(plan%times)) rows = rows_of(n, plan%every)
      end if
      call receiver%open_array(handle%columns%width, rows, status)
      if (status%ok()) call travel(handle, plan, receiver, status)
   end subroutine run_to

   !> Prepares a stepper for nominal steps. Errors: `NUTATE_BAD_ARGUMENT`.
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
   end subroutine get_going

   !> Runs from the present state to the end of a plan. Errors: those of the steps, of callbacks and rows; after a
   !> failed callback the state is the one before the step.
   subroutine travel(handle, plan, receiver, status)
      !> Prepared stepper.
      type(stepper_handle_t), intent(inout), target :: handle
      type(run_plan_t), intent(in) :: plan
      type(row_receiver_t), intent(inout) :: receiver
      type(status_t), intent(inout) :: status
      type(integrator_settings_t) :: requested
      logical :: is_watched
      receiver%handle => handle
      receiver%observes_every_step = handle%columns%follows_steps
      receiver%wants_works = handle%columns%needs_works
      receiver%wants_tangent = handle%columns%differentiates
      receiver%checks_steps = has_callbacks(handle%system%effects) .or. handle%events%count() > 0
      handle%plain = .false.
      handle%failure = 0
      if (allocated(handle%found)) handle%found%n = 0
      if (.not. abs(plan%end_time - handle%run%state%t) > 0.0_wp) then
         if (.not. is_first_a_row(plan, receiver)) return
         call propagate_along(handle, status)
         if (allocated(handle%run%tangent)) receiver%tangent = handle%run%tangent
         if (allocated(handle%run%summary%chaos)) receiver%chaos = handle%run%summary%chaos
         if (status%ok()) call write_row(handle, receiver, status)
         call put_down(handle)
         return
      end if
      is_watched = allocated(handle%run%events)
      requested = handle%run%requested
      if (allocated(handle%chaos) .and. plan%goal%active()) call choose_with_tangent(.true., handle%run%requested)
      call handle%run%set_plan(handle%system, plan, status)
      if (status%ok() .and. .not. is_watched) call handle%run%set_events(handle%events, handle%system, status)
      if (status%ok()) call find_steps_asking(handle%run, handle%poll, handle%failure, handle%system, status)
      if (status%ok()) call propagate_along(handle, status)
      if (status%ok()) call handle%run%run_to_end(handle%system, status, receiver)
      call put_down(handle)
      ! Later runs may follow no chaos.
      if (allocated(handle%chaos)) handle%run%requested = requested
      call add_failure(handle%failure, status)
      if (allocated(handle%run%events)) call copy_effects(handle)
      if (allocated(handle%inside)) deallocate (handle%inside)
      ! The stepper of nominal steps has not followed an adaptive run.
      if (plan%goal%active() .and. allocated(handle%run%stepper)) deallocate (handle%run%stepper)
   end subroutine travel

   !> Makes the run propagate the sensitivities and chaos indicators of the stepper. Errors: `NUTATE_BAD_ARGUMENT` if a
   !> derivative does not exist.
   subroutine propagate_along(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(inout) :: status
      if (allocated(handle%indicators)) deallocate (handle%indicators)
      if (allocated(handle%variations) .and. handle%columns%differentiates) &
         call handle%run%differentiate(handle%variations, handle%system, status)
      if (status%ok() .and. allocated(handle%chaos)) call handle%run%follow_chaos(handle%chaos, handle%system, status)
   end subroutine propagate_along

   !> Stops propagating, which single steps do not support, and keeps the chaos indicators.
   subroutine put_down(handle)
      type(stepper_handle_t), intent(inout) :: handle
      associate (run => handle%run)
         if (allocated(run%summary%chaos)) call move_alloc(run%summary%chaos, handle%indicators)
         if (allocated(run%last_chaos)) deallocate (run%last_chaos)
         if (allocated(run%tangent)) deallocate (run%tangent, run%last_tangent)
      end associate
   end subroutine put_down

   !> Returns true if a run that ends at its first state has this state as a row.
   pure logical function is_first_a_row(plan, receiver)
      type(run_plan_t), intent(in) :: plan
      type(row_receiver_t), intent(in) :: receiver
      is_first_a_row = .not. receiver%leaves_out_ends
      if (allocated(plan%times)) is_first_a_row = size(plan%times) > 0
   end function is_first_a_row

   !> Copies the effects as a run has switched them, and the values that it holds.
   subroutine copy_effects(handle)
      type(stepper_handle_t), intent(inout) :: handle
      if (.not. allocated(handle%given)) allocate (handle%given, source=handle%system%effects)
      handle%system%effects = handle%run%events%system%effects
      handle%is_valid = .false.
      if (.not. needs_control(handle%system%effects)) call free_senses(handle%system%effects)
   end subroutine copy_effects

   !> Tests the arguments of a run to a time. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_run(handle, plan, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      ! A run with adaptive steps makes a stepper of its own.
      if (.not. (handle%is_valid .and. handle%plan%goal%active())) call prepare_if_needed(handle, status)
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

   !> Returns the number of nominal steps to a time, the last one shortened if necessary; negative if they lead away
   !> from it or are too many to count.
   pure integer(long) function steps_to(handle, end_time) result(n)
      type(stepper_handle_t), intent(in) :: handle
      !> End time, s.
      real(wp), intent(in) :: end_time
      n = -1
      if ((end_time - handle%run%state%t)*sign(1.0_wp, handle%plan%time_step) < 0.0_wp) return
      if (.not. is_countable(end_time - handle%run%state%t, handle%plan%time_step)) return
      n = handle%run%steps_to(end_time, handle%plan%time_step)
   end function steps_to

   !> Returns the number of rows of a run to a time: the first state, one after every `every` steps, and the last state.
   pure integer(long) function rows_of(n, every) result(rows)
      !> Number of steps of the run, and of steps between rows.
      integer(long), intent(in) :: n, every
      rows = 1 + n/every
      if (mod(n, every) > 0) rows = rows + 1
   end function rows_of

end module nutate_c_runs
