!> C interface: runs of scenes, in memory and into files. The functions are documented in `include/nutate_scene.h`.
module nutate_c_history
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_int64_t, c_loc, c_ptr, c_size_t
   use nutate_c_effects, only: add_failure
   use nutate_c_handles, only: found, history_handle_t, HISTORY_MARK
   use nutate_c_scene_handle, only: found, scene_handle_t
   use nutate_c_stepper_handle, only: found, is_taken, null_argument, open_slot, report, stepper_handle_t
   use nutate_c_rows, only: row_receiver_t
   use nutate_c_runs, only: travel
   use nutate_c_stepper, only: start_handle, set_scene
   use nutate_c_text, only: lock_texts, nth_name, copy_text, text_to_c, unlock_texts
   use nutate_event_history, only: event_history_t, events_name
   use nutate_files, only: same_file
   use nutate_free_variations, only: usual_sets
   use nutate_history, only: history_t
   use nutate_kinds, only: wp, long
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   use nutate_system, only: system_t
   implicit none
   private

   public :: nutate_scene_run, nutate_scene_write, nutate_history_size, nutate_history_name, nutate_history_column, &
      nutate_history_values, nutate_history_uncertified, nutate_history_accuracy, nutate_history_chaos, &
      nutate_history_summary, nutate_history_destroy

contains

   integer(c_int) function nutate_scene_run(scene, history, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, history, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(scene_handle_t), pointer :: from
      type(history_handle_t), pointer :: handle
      type(status_t) :: status
      integer :: failed
      slot => open_slot(history)
      if (.not. associated(slot)) then
         status = null_argument('history')
      else if (.not. found(scene, from)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else
         allocate (handle, stat=failed)
         if (failed /= 0) then
            status = fail(NUTATE_NO_MEMORY, 'not enough memory for a history')
         else
            handle%mark = HISTORY_MARK
            slot = c_loc(handle)
            call collect(from, handle, status)
         end if
      end if
      code = report(status, message, size)
   end function nutate_scene_run

   integer(c_int) function nutate_scene_write(scene, path, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, path, message
      integer(c_size_t), intent(in), value :: size
      type(scene_handle_t), pointer :: from
      type(status_t) :: status
      character(len=:), allocatable :: name
      if (.not. found(scene, from)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else
         name = from%scene%output%file
         if (c_associated(path)) call copy_text(path, name)
         if (name == '') then
            status = fail(NUTATE_BAD_ARGUMENT, 'the path is empty', 'path')
         else if (same_file(from%scene%file, name)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the output would overwrite the scene', 'path')
         else
            call write_file(from, name, status)
         end if
      end if
      code = report(status, message, size)
   end function nutate_scene_write

   integer(c_int) function nutate_history_size(history, rows, columns) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_size_t), intent(inout), optional :: rows, columns
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      code = NUTATE_OK
      if (present(rows)) rows = handle%rows
      if (present(columns)) columns = handle%width
   end function nutate_history_size

   integer(c_int) function nutate_history_name(history, column, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: history, buffer
      integer(c_size_t), intent(in), value :: column, size
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (column < 0 .or. column >= handle%width) return
      code = text_to_c(trim(nth_name(handle%names, int(column) + 1)), buffer, size)
   end function nutate_history_name

   integer(c_int) function nutate_history_column(history, name, values, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: history, name
      integer(c_size_t), intent(in), value :: size
      real(c_double), intent(inout), optional :: values(*)
      type(history_handle_t), pointer :: handle
      character(len=:), allocatable :: wanted
      integer :: column
      if (.not. found(history, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(values) .or. (size >= 0 .and. size < handle%rows)) return
      call copy_text(name, wanted)
      do column = 1, handle%width
         if (nth_name(handle%names, column) == wanted .and. wanted /= '') exit
      end do
      if (column > handle%width) return
      values(1:handle%rows) = handle%values(column, 1:handle%rows)
      code = NUTATE_OK
   end function nutate_history_column

   integer(c_int) function nutate_history_values(history, values, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_size_t), intent(in), value :: size
      real(c_double), intent(inout), optional :: values(*)
      type(history_handle_t), pointer :: handle
      integer(c_size_t) :: i
      if (.not. found(history, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(values) .or. (size >= 0 .and. size < handle%rows*handle%width)) return
      do i = 1, handle%rows
         values((i - 1)*handle%width + 1:i*handle%width) = handle%values(:, i)
      end do
      code = NUTATE_OK
   end function nutate_history_values

   integer(c_int) function nutate_history_uncertified(history, steps) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_int64_t), intent(inout), optional :: steps
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(steps)) return
      steps = handle%uncertified_steps
      code = NUTATE_OK
   end function nutate_history_uncertified

   integer(c_int) function nutate_history_accuracy(history, error, accuracy) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      real(c_double), intent(inout), optional :: error(2), accuracy
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      if (present(error)) error = handle%error
      if (present(accuracy)) accuracy = handle%accuracy
      code = NUTATE_OK
   end function nutate_history_accuracy

   integer(c_int) function nutate_history_chaos(history, n, exponents, megno, fli, time) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_size_t), intent(inout), optional :: n
      real(c_double), intent(inout), optional :: exponents(*), megno, fli, time
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      code = NUTATE_OK
      if (present(n)) n = 0
      if (.not. allocated(handle%indicators)) return
      associate (chaos => handle%indicators)
         if (present(n)) n = chaos%n
         if (present(exponents)) exponents(1:chaos%n) = chaos%lyapunov()
         if (present(megno)) megno = chaos%megno()
         if (present(fli)) fli = chaos%fli()
         if (present(time)) time = chaos%time
      end associate
   end function nutate_history_chaos

   integer(c_int) function nutate_history_summary(history, counts, errors) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_int64_t), intent(inout), optional :: counts(5)
      real(c_double), intent(inout), optional :: errors(3)
      type(history_handle_t), pointer :: handle
      if (.not. found(history, handle, code)) return
      code = NUTATE_OK
      if (present(errors)) errors = [handle%error, handle%accuracy]
      if (.not. present(counts)) return
      counts = [handle%rows, int(handle%width, c_int64_t), int(handle%found%n, c_int64_t), 0_c_int64_t, &
                handle%uncertified_steps]
      if (allocated(handle%indicators)) counts(4) = handle%indicators%n
   end function nutate_history_summary

   integer(c_int) function nutate_history_destroy(history) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      type(history_handle_t), pointer :: handle
      type(c_ptr) :: taken
      if (.not. is_taken(history, HISTORY_MARK, taken, code)) return
      call c_f_pointer(taken, handle)
      deallocate (handle)
   end function nutate_history_destroy

   !> Runs a scene with a stepper and keeps the rows in a history.
   subroutine collect(from, handle, status)
      type(scene_handle_t), intent(in) :: from
      type(history_handle_t), pointer, intent(in) :: handle
      type(status_t), intent(out) :: status
      type(stepper_handle_t), pointer :: stepper
      type(row_receiver_t) :: receiver
      call start_handle(stepper, status)
      if (.not. status%ok()) return
      associate (scene => from%scene, columns => stepper%columns)
         call set_scene(stepper, from, usual_sets(scene), status)
         call lock_texts()
         if (status%ok()) call columns%choose(usual_sets(scene), status, scene%output%degrees, scene%system%effects, &
                                              scene%propagated())
         handle%names = columns%header()
         call unlock_texts()
         if (status%ok()) then
            call columns%start(stepper%system, scene%initial, scene%integrator%inverse_auxiliary_inertia, &
                               backward=scene%plan%end_time < scene%initial%t)
            receiver%history => handle
            call receiver%open_array(columns%width, 0_long, status)
            stepper%poll = from%poll
            call travel(stepper, scene%plan, receiver, status)
            if (allocated(stepper%found)) handle%found = stepper%found
            if (allocated(stepper%indicators)) handle%indicators = stepper%indicators
            handle%uncertified_steps = stepper%run%summary%uncertified_steps
            handle%accuracy = scene%plan%goal%accuracy
            if (status%ok() .and. handle%accuracy > 0.0_wp) &
               handle%error = [stepper%run%summary%estimate, stepper%run%summary%round_off]
         end if
      end associate
      deallocate (stepper)
   end subroutine collect

   !> Runs a scene with a stepper and writes the rows and events into files.
   subroutine write_file(from, name, status)
      type(scene_handle_t), intent(in) :: from
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(stepper_handle_t), pointer :: stepper
      type(row_receiver_t) :: receiver
      type(history_t), target :: file
      type(event_history_t), target :: events
      call start_handle(stepper, status)
      if (.not. status%ok()) return
      call set_scene(stepper, from, usual_sets(from%scene), status)
      if (status%ok()) call open_files(from%scene, stepper%system, name, file, events, status)
      if (status%ok()) then
         stepper%columns = file%columns
         stepper%poll = from%poll
         receiver%wants_rows = .true.
         receiver%file => file
         receiver%events => events
         call add_failure(stepper%failure, status)
         if (status%ok()) call travel(stepper, from%scene%plan, receiver, status)
         call lock_texts()
         if (events%wanted) call events%file%close(status)
         call file%file%close(status)
         call unlock_texts()
      end if
      deallocate (stepper)
   end subroutine write_file

   !> Opens the file of the rows and, if there are events, the file of the events beside it. Errors: those of the files;
   !> the rows are not kept then.
   subroutine open_files(scene, system, name, file, events, status)
      type(scene_t), intent(in) :: scene
      !> System whose callbacks report their failures.
      type(system_t), intent(in) :: system
      !> Path of the file of the rows.
      character(len=*), intent(in) :: name
      type(history_t), intent(inout) :: file
      type(event_history_t), intent(inout) :: events
      type(status_t), intent(out) :: status
      type(status_t) :: closing
      character(len=:), allocatable :: beside
      call lock_texts()
      call file%open(name, usual_sets(scene), system, scene%initial, scene%integrator%inverse_auxiliary_inertia, &
                     status, scene%output%degrees, scene%output%digits, &
                     backward=scene%plan%end_time < scene%initial%t, epoch=scene%output%epoch, &
                     propagated=scene%propagated())
      beside = scene%output%events
      if (beside == '') beside = events_name(name)
      if (status%ok() .and. scene%events%count() > 0 .and. beside /= '') then
         call events%open(beside, file, status)
         if (.not. status%ok()) call file%abandon(closing)
      end if
      call unlock_texts()
   end subroutine open_files

end module nutate_c_history
