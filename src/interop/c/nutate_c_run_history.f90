!> C interface: runs of steppers into histories, and poll callbacks of runs. The functions are documented in
!> `include/nutate_runs.h`.
module nutate_c_run_history
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_funptr, c_int, c_int64_t, &
      c_null_ptr, c_ptr, c_size_t
   use nutate_c_scene_handle, only: found, scene_handle_t
   use nutate_c_stepper_handle, only: conclude, found, get_propagated, null_argument, open_slot, set_chaos, &
      set_propagated, stepper_handle_t
   use nutate_c_polls, only: poll_t
   use nutate_c_reading, only: choose_columns
   use nutate_c_rows, only: row_receiver_t
   use nutate_c_runs, only: run_to
   use nutate_c_stepper, only: find_variations
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_run_plan, only: run_plan_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OK
   use nutate_propagated, only: propagated_t
   use nutate_variation, only: variation_t
   implicit none
   private

   public :: nutate_stepper_run_history, nutate_stepper_run_rows, nutate_stepper_differentiate, &
      nutate_stepper_follow_chaos, nutate_stepper_set_poll, nutate_scene_set_poll

   !> A run of `nutate_stepper_run_rows`, as `nutate_row_run` of C.
   type, bind(C), private :: row_run_t
      real(c_double) :: end_time
      integer(c_int64_t) :: every
      real(c_double) :: interval
      type(c_ptr) :: times
      integer(c_size_t) :: n_times
      type(c_ptr) :: rows
      integer(c_size_t) :: capacity
      integer(c_int64_t) :: counts(5)
      real(c_double) :: errors(3)
      type(c_ptr) :: history
   end type row_run_t

contains

   integer(c_int) function nutate_stepper_run_history(stepper, end_time, every, interval, times, n_times, history) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, times, history
      real(c_double), intent(in), value :: end_time, interval
      integer(c_int64_t), intent(in), value :: every
      integer(c_size_t), intent(in), value :: n_times
      type(c_ptr), pointer :: slot
      type(stepper_handle_t), pointer :: handle
      type(row_receiver_t) :: receiver
      type(status_t) :: status
      slot => open_slot(history)
      if (.not. found(stepper, handle, code)) return
      if (.not. associated(slot)) then
         code = conclude(handle, null_argument('history'))
         return
      end if
      receiver%slot => slot
      call keep_run(handle, run_plan_t(end_time=end_time, every=every, interval=interval), times, n_times, receiver, &
                    status)
      code = conclude(handle, status)
   end function nutate_stepper_run_history

   integer(c_int) function nutate_stepper_run_rows(stepper, run) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      type(row_run_t), intent(inout), target, optional :: run
      type(stepper_handle_t), pointer :: handle
      type(row_receiver_t) :: receiver
      type(status_t) :: status
      if (present(run)) run%history = c_null_ptr
      if (.not. found(stepper, handle, code)) return
      if (.not. present(run)) then
         code = conclude(handle, null_argument('run'))
         return
      end if
      receiver%slot => run%history
      receiver%array = run%rows
      receiver%capacity = run%capacity
      call keep_run(handle, run_plan_t(end_time=run%end_time, every=run%every, interval=run%interval), run%times, &
                    run%n_times, receiver, status)
      run%counts = [receiver%rows, int(handle%columns%width, c_int64_t), 0_c_int64_t, 0_c_int64_t, &
                    handle%run%summary%uncertified_steps]
      if (associated(receiver%history)) run%counts(3) = receiver%history%found%n
      if (associated(receiver%history) .and. allocated(handle%indicators)) run%counts(4) = handle%indicators%n
      run%errors = [error_of(handle, status), handle%plan%goal%accuracy]
      code = conclude(handle, status)
   end function nutate_stepper_run_rows

   integer(c_int) function nutate_stepper_differentiate(stepper, scene) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, scene
      type(stepper_handle_t), pointer :: handle
      type(scene_handle_t), pointer :: from
      type(propagated_t) :: before, propagated
      type(variation_t), allocatable :: variations(:)
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. found(scene, from, code)) return
      call get_propagated(handle, before)
      if (allocated(handle%variations)) variations = handle%variations
      propagated = from%scene%propagated()
      if (size(propagated%names) == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the scene has no free parameters (expected &free)', 'scene')
      else
         call find_variations(from%scene, handle, status)
      end if
      if (status%ok()) then
         propagated%exponents = before%exponents
         call set_propagated(handle, propagated)
         ! Columns of sensitivities have other names now.
         if (handle%columns%differentiates) call choose_columns(handle, handle%sets, status)
         if (.not. status%ok()) then
            call set_propagated(handle, before)
            call move_alloc(variations, handle%variations)
         end if
      end if
      code = conclude(handle, status)
   end function nutate_stepper_differentiate

   integer(c_int) function nutate_stepper_follow_chaos(stepper, scene) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, scene
      type(stepper_handle_t), pointer :: handle
      type(scene_handle_t), pointer :: from
      type(propagated_t) :: before, propagated
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. found(scene, from, code)) return
      call get_propagated(handle, before)
      propagated = before
      propagated%exponents = from%scene%chaos%exponents
      call set_propagated(handle, propagated)
      if (handle%columns%differentiates) call choose_columns(handle, handle%sets, status)
      if (status%ok()) then
         call set_chaos(handle, from%scene%chaos)
      else
         call set_propagated(handle, before)
      end if
      code = conclude(handle, status)
   end function nutate_stepper_follow_chaos

   !> Runs a stepper to the end of a plan and keeps the rows: in the array of the receiver if all of them fit and there
   !> is nothing else to keep, otherwise in a history. Errors: `NUTATE_NO_MEMORY`, those of the run.
   subroutine keep_run(handle, plan, times, n_times, receiver, status)
      type(stepper_handle_t), pointer, intent(in) :: handle
      type(run_plan_t), intent(in) :: plan
      !> Times of the rows, s, as `double[n_times]`; null: none.
      type(c_ptr), intent(in) :: times
      integer(c_size_t), intent(in) :: n_times
      type(row_receiver_t), intent(inout) :: receiver
      type(status_t), intent(out) :: status
      type(run_plan_t) :: timed
      timed = plan
      call set_times(times, n_times, handle%run%state%t, timed, status)
      if (status%ok() .and. .not. c_associated(receiver%array)) call receiver%open_history(handle, status)
      if (.not. status%ok()) return
      call run_to(handle, timed, receiver, status)
      if (has_more(handle)) call receiver%open_history(handle, status)
      if (.not. associated(receiver%history)) return
      associate (rows => receiver%history)
         rows%uncertified_steps = handle%run%summary%uncertified_steps
         if (allocated(handle%found)) rows%found = handle%found
         if (allocated(handle%indicators)) rows%indicators = handle%indicators
         rows%accuracy = handle%plan%goal%accuracy
         rows%error = error_of(handle, status)
      end associate
   end subroutine keep_run

   !> Returns true if the last run found events or computed chaos indicators.
   pure logical function has_more(handle)
      type(stepper_handle_t), intent(in) :: handle
      has_more = allocated(handle%indicators)
      if (allocated(handle%found)) has_more = has_more .or. handle%found%n > 0
   end function has_more

   !> Returns the estimated error of the last run, and the part of it due to round-off, rad; zeros without an accuracy.
   pure function error_of(handle, status) result(error)
      type(stepper_handle_t), intent(in) :: handle
      !> Status of the run.
      type(status_t), intent(in) :: status
      real(wp) :: error(2)
      error = 0.0_wp
      if (status%code == NUTATE_OK .and. handle%plan%goal%accuracy > 0.0_wp) &
         error = [handle%run%summary%estimate, handle%run%summary%round_off]
   end function error_of

   integer(c_int) function nutate_stepper_set_poll(stepper, poll, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, user
      type(c_funptr), intent(in), value :: poll
      type(stepper_handle_t), pointer :: handle
      if (.not. found(stepper, handle, code)) return
      handle%poll = poll_t(function=poll, user=user)
      code = NUTATE_OK
   end function nutate_stepper_set_poll

   integer(c_int) function nutate_scene_set_poll(scene, poll, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, user
      type(c_funptr), intent(in), value :: poll
      type(scene_handle_t), pointer :: handle
      if (.not. found(scene, handle, code)) return
      handle%poll = poll_t(function=poll, user=user)
      code = NUTATE_OK
   end function nutate_scene_set_poll

   !> Puts the times of rows into a plan. Errors: `NUTATE_BAD_ARGUMENT` for times out of their order, or outside of the
   !> run.
   subroutine set_times(address, n, start, plan, status)
      !> Times of the rows, s, as `double[n]`; null: none.
      type(c_ptr), intent(in) :: address
      integer(c_size_t), intent(in) :: n
      !> Time at the start of the run, s.
      real(wp), intent(in) :: start
      type(run_plan_t), intent(inout) :: plan
      type(status_t), intent(inout) :: status
      real(c_double), pointer :: times(:)
      real(wp) :: sense, before
      integer(c_size_t) :: i
      if (.not. c_associated(address)) return
      if (n < 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the number of times is out of its range', 'n_times')
         return
      end if
      call c_f_pointer(address, times, [n])
      sense = sign(1.0_wp, plan%end_time - start)
      before = start
      do i = 1, n
         if (.not. is_moderate(times(i))) exit
         if (sense*times(i) < sense*before .or. sense*times(i) > sense*plan%end_time) exit
         if (i > 1 .and. .not. abs(times(i) - before) > 0.0_wp) exit
         before = times(i)
      end do
      if (i <= n) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the times of the rows are not in order from the present time '// &
                       'to end_time', 'times')
         return
      end if
      plan%times = times
   end subroutine set_times

end module nutate_c_run_history
