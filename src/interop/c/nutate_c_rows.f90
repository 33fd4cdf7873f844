!> Rows of a run in an array of C, or in a history.
module nutate_c_rows
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_null_ptr, c_ptr, c_size_t
   use nutate_c_effects, only: add_failure, judge_failure
   use nutate_c_handles, only: history_handle_t, make_room, stepper_handle_t
   use nutate_event, only: event_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: total_work
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE, NUTATE_STEP_LIMIT
   use nutate_system, only: system_t
   implicit none
   private

   public :: row_taker_t, write_row, present_record, work_done, unproved_so_far

   !> Writes rows into an array.
   type, extends(observer_t) :: row_taker_t
      !> `double[capacity][width]`, or null; rows that it has room for, beyond the greatest integer a negative number.
      type(c_ptr) :: array = c_null_ptr
      integer(c_size_t) :: capacity = 0
      !> Takes the rows in place of an array, and has room for all.
      type(history_handle_t), pointer :: history => null()
      !> There is an array, or a history.
      logical :: wants_rows = .false.
      !> Rows so far.
      integer(c_size_t) :: rows = 0
      !> Shape (width, room for rows).
      real(wp), pointer, contiguous :: values(:, :) => null()
      !> Where positive: of a run of so many steps between rows, which begins without a row, and ends without one at
      !> this time, s, unless it is due.
      integer(long) :: every = 0
      real(wp) :: end_time = 0.0_wp
      !> The stepper whose run it is; only where steps are chosen by their error.
      type(stepper_handle_t), pointer :: handle => null()
   contains
      !> Opens the array.
      procedure :: take
      procedure :: observe => take_row
      procedure :: poll => ask_callbacks
      procedure :: show_event => take_event
      procedure :: watch => follow_state
   end type row_taker_t

contains

   !> Opens the array. Errors: `NUTATE_BAD_ARGUMENT` where it is too small.
   subroutine take(self, width, needed, status)
      class(row_taker_t), intent(inout) :: self
      integer, intent(in) :: width
      !> Rows that it must hold.
      integer(long), intent(in) :: needed
      type(status_t), intent(out) :: status
      self%wants_rows = associated(self%history)
      if (self%wants_rows) self%history%width = width
      if (.not. c_associated(self%array) .or. self%wants_rows) return
      if (self%capacity >= 0 .and. self%capacity < needed) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the array for the rows is too small', 'capacity')
         return
      end if
      self%wants_rows = .true.
      self%rows = 0
      associate (capacity => self%capacity)
         call c_f_pointer(self%array, self%values, &
                          [int(width, c_size_t), merge(capacity, huge(capacity)/width, capacity >= 0)])
      end associate
   end subroutine take

   !> What belongs to a row beside the state.
   type(run_record_t) function present_record(handle) result(record)
      type(stepper_handle_t), intent(in) :: handle
      logical :: on_grid
      record = handle%run%record
      on_grid = handle%under_way .and. .not. abs(handle%run%state%t - handle%t_reached) > 0.0_wp
      if (.not. on_grid .and. allocated(handle%stepper)) then
         record%iterations = handle%stepper%iterations
         record%residual = handle%stepper%residual
      end if
      call put_works_done(handle, record)
   end function present_record

   !> Work of all torques, and of the world, since the state was set, J.
   real(wp) function work_done(handle)
      type(stepper_handle_t), intent(in) :: handle
      work_done = handle%work
      if (allocated(handle%run%summary%work)) work_done = handle%work + total_work(handle%run%summary)
   end function work_done

   !> Puts the works since the state was set into a record.
   subroutine put_works_done(handle, record)
      type(stepper_handle_t), intent(in) :: handle
      type(run_record_t), intent(inout) :: record
      record%work = work_done(handle)
      if (.not. handle%columns%needs_works) return
      record%works = handle%works
      associate (summary => handle%run%summary)
         if (allocated(summary%work)) record%works = record%works + [summary%work, summary%world_work]
      end associate
   end subroutine put_works_done

   !> Steps since the state was set in which a root was taken for the true one without a proof.
   pure integer(long) function unproved_so_far(handle) result(steps)
      type(stepper_handle_t), intent(in) :: handle
      steps = handle%unproved_steps
      if (allocated(handle%run%summary%work)) steps = steps + handle%run%summary%unproved_steps
   end function unproved_so_far

   !> Writes the present state as a row. Errors: `NUTATE_NOT_FINITE`.
   subroutine write_row(handle, taker, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(row_taker_t), intent(inout) :: taker
      type(status_t), intent(inout) :: status
      type(run_record_t) :: record
      type(state_t) :: seen
      if (.not. taker%wants_rows) return
      ! Between projections the row has a projected copy, as in every run.
      seen = handle%run%state
      call handle%stepper%show(handle%system, seen)
      record = handle%run%record
      call put_works_done(handle, record)
      call put_row(handle, taker, handle%system, seen, record, status)
   end subroutine write_row

   !> Puts a row behind the others. Errors: `NUTATE_NOT_FINITE`; `NUTATE_STEP_LIMIT` where there is no room.
   subroutine put_row(handle, taker, system, state, record, status)
      type(stepper_handle_t), intent(inout) :: handle
      class(row_taker_t), intent(inout) :: taker
      !> With what is switched on now.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      if (associated(taker%history)) then
         call make_room(taker%history, status)
         if (status%code /= 0) return
         taker%values => taker%history%values
      else if (taker%rows >= size(taker%values, 2, c_size_t)) then
         status = fail(NUTATE_STEP_LIMIT, 'the run has more rows than the array has room for')
         return
      end if
      associate (row => taker%values(:, taker%rows + 1))
         call handle%columns%evaluate(system, state, record, row)
         if (.not. all(ieee_is_finite(row))) status = fail(NUTATE_NOT_FINITE, 'a value of a row is not finite')
      end associate
      call add_failure(handle%failure, status)
      if (status%code == 0) taker%rows = taker%rows + 1
      if (associated(taker%history)) taker%history%rows = taker%rows
   end subroutine put_row

   !> Writes a row of a run whose steps are chosen by their error.
   subroutine take_row(self, system, state, record, status)
      class(row_taker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      type(run_record_t) :: own
      status = judge_failure(self%handle%failure)
      if (status%code /= 0 .or. .not. self%wants_rows) return
      if (self%every > 0) then
         if (.not. abs(state%t - self%handle%run%state%t) > 0.0_wp) return
         if (mod(record%step, self%every) /= 0 .and. .not. abs(state%t - self%end_time) > 0.0_wp) return
      end if
      own = record
      own%work = self%handle%work + record%work
      if (allocated(own%works)) own%works(:) = self%handle%works + record%works
      call put_row(self%handle, self, system, state, own, status)
   end subroutine take_row

   !> Keeps an event of a run.
   subroutine take_event(self, system, event, which, number, state, record, status)
      class(row_taker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      status = judge_failure(self%handle%failure)
      if (status%code == 0) call self%handle%found%put(system, event, number, state, status)
   end subroutine take_event

   !> Ends the run where a callback has failed, or the program wants it.
   subroutine ask_callbacks(self, fraction, status)
      class(row_taker_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      status = judge_failure(self%handle%failure)
      if (status%ok()) call self%handle%poll%ask(status)
   end subroutine ask_callbacks

   !> Follows angles that must not lose turns.
   subroutine follow_state(self, state)
      class(row_taker_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      call self%handle%columns%follow(state)
   end subroutine follow_state

end module nutate_c_rows
