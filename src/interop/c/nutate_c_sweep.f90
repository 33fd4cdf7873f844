!> C interface: members of an ensemble. The functions are documented in `include/nutate_sweep.h`.
module nutate_c_sweep
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_int64_t, c_loc, c_ptr, c_size_t
   use nutate_c_effects, only: status_of_failure, report_failures_to
   use nutate_c_scene_handle, only: found, null_argument, report, scene_handle_t
   use nutate_c_polls, only: poll_t
   use nutate_c_text, only: lock_texts, copy_text, text_to_c, unlock_texts
   use nutate_effect_list, only: effect_list_t
   use nutate_forks, only: has_threads
   use nutate_member_rows, only: fill_rows
   use nutate_row_layout, only: field_length, make_layout, row_layout_t
   use nutate_scene, only: scene_kinds, scene_t
   use nutate_scene_ensemble, only: add_table
   use nutate_scene_error, only: scene_error_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_BAD_SCENE, NUTATE_OK
   use nutate_sweep_watcher, only: sweep_watcher_t
   !$ use omp_lib, only: omp_get_thread_num
   implicit none
   private

   public :: nutate_sweep_size, nutate_sweep_field, nutate_sweep_table, nutate_sweep_members

   character(len=*), parameter :: no_scene = 'scene is NULL, destroyed or not a scene'
   !> Largest number of names of a table, as in a file; largest number of threads, more than any machine has.
   integer(c_size_t), parameter :: most_names = 200
   integer(c_int), parameter :: most_threads = 4096
   !> Size of a field, bytes.
   integer(c_int64_t), parameter :: word = 8

   !> Data that the threads share.
   type :: answer_t
      type(poll_t) :: poll
      logical :: ended = .false.
      !> True if only the calling thread works.
      logical :: alone = .false.
      !> Status of a callback that failed, and the value that it returned, by thread; shape (2, threads).
      integer(c_int), allocatable :: failures(:, :)
   end type answer_t

   !> Calls the poll callback of a scene in the calling thread, and passes its answer to the other threads. Keeps the
   !> failures of callbacks.
   type, extends(sweep_watcher_t) :: polling_sweep_t
      type(answer_t), pointer, private :: answer => null()
   contains
      !> Sets the poll callback.
      procedure :: start
      procedure :: wants_end => ask_program
      procedure :: prepare => prepare_callbacks
      procedure :: check => check_callbacks
      final :: forget
   end type polling_sweep_t

contains

   integer(c_int) function nutate_sweep_size(scene, members, fields) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      integer(c_int64_t), intent(inout), optional :: members
      integer(c_size_t), intent(inout), optional :: fields
      type(scene_handle_t), pointer :: handle
      type(row_layout_t) :: layout
      call find_rows(scene, handle, layout, code)
      if (code /= NUTATE_OK) return
      if (present(members)) members = handle%scene%ensemble%members
      if (present(fields)) fields = layout%width()
   end function nutate_sweep_size

   integer(c_int) function nutate_sweep_field(scene, field, is_whole, name, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, name
      integer(c_size_t), intent(in), value :: field, size
      integer(c_int), intent(inout), optional :: is_whole
      type(scene_handle_t), pointer :: handle
      type(row_layout_t) :: layout
      call find_rows(scene, handle, layout, code)
      if (code /= NUTATE_OK) return
      code = NUTATE_BAD_ARGUMENT
      if (field < 0 .or. field >= layout%width()) return
      code = text_to_c(trim(layout%names(field + 1)), name, size)
      if (code == NUTATE_OK .and. present(is_whole)) is_whole = merge(1, 0, layout%is_whole(field + 1))
   end function nutate_sweep_field

   integer(c_int) function nutate_sweep_table(scene, names, n_names, numbers, lines, message, size) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: scene, names, numbers, message
      integer(c_size_t), intent(in), value :: n_names, lines, size
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      character(len=:), allocatable :: whole
      if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, no_scene)
      else if (.not. c_associated(names) .or. .not. c_associated(numbers)) then
         status = null_argument('names or numbers')
      else if (n_names < 1 .or. n_names > most_names .or. lines < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has no line, or not 1 to 200 columns', 'n_names')
      else
         call lock_texts()
         call add_cases(handle%scene, names, int(n_names), numbers, lines, status, whole)
         call unlock_texts()
      end if
      code = report(status, message, size, whole)
   end function nutate_sweep_table

   integer(c_int) function nutate_sweep_members(scene, first, last, threads, rows, bytes, message, size) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, rows, message
      integer(c_int64_t), intent(in), value :: first, last
      integer(c_int), intent(in), value :: threads
      integer(c_size_t), intent(in), value :: bytes, size
      type(scene_handle_t), pointer :: handle
      type(row_layout_t) :: layout
      type(polling_sweep_t), target :: watcher
      type(status_t) :: status
      integer(c_int64_t), pointer :: fields(:, :)
      if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, no_scene)
      else if (.not. c_associated(rows)) then
         status = null_argument('rows')
      else
         call check_members(handle, first, last, threads, status)
      end if
      if (status%ok()) call find_layout(handle%scene, layout, status)
      if (status%ok()) then
         if (bytes /= (last - first + 1)*layout%width()*word) status = fail( &
            NUTATE_BAD_ARGUMENT, 'rows has the wrong size (expected 8 bytes for each field of each member)', 'bytes')
      end if
      if (status%ok()) then
         call c_f_pointer(rows, fields, [int(layout%width(), c_int64_t), last - first + 1])
         call watcher%start(handle%poll, int(threads))
         call fill_rows(handle%scene, layout, first, last, int(threads), watcher, fields, status)
      end if
      code = report(status, message, size)
   end function nutate_sweep_members

   !> Finds a scene by its handle, and the fields of a row. Code: `NUTATE_BAD_HANDLE`, or the error of `find_layout`.
   subroutine find_rows(scene, handle, layout, code)
      type(c_ptr), intent(in) :: scene
      type(scene_handle_t), pointer, intent(out) :: handle
      type(row_layout_t), intent(out) :: layout
      integer(c_int), intent(out) :: code
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call find_layout(handle%scene, layout, status)
      code = status%code
   end subroutine find_rows

   !> Finds the fields of a row; none if the scene has no ensemble. Errors: a set of columns that does not exist.
   subroutine find_layout(scene, layout, status)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(out) :: layout
      type(status_t), intent(out) :: status
      allocate (layout%names(0))
      if (.not. scene%ensemble%active()) return
      call lock_texts()
      call make_layout(scene, layout, status)
      call unlock_texts()
   end subroutine find_layout

   !> Tests the arguments of `nutate_sweep_members`. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_members(handle, first, last, threads, status)
      type(scene_handle_t), intent(in) :: handle
      integer(c_int64_t), intent(in) :: first, last
      integer(c_int), intent(in) :: threads
      type(status_t), intent(out) :: status
      if (.not. handle%scene%ensemble%active()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the scene has no ensemble (expected &ensemble, or a table)', 'scene')
      else if (first < 1 .or. last < first .or. last > handle%scene%ensemble%members) then
         status = fail(NUTATE_BAD_ARGUMENT, 'members are out of range (expected 1 to the number of members)', 'first')
      else if (threads < 1 .or. threads > most_threads) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the number of threads is out of its range (expected 1 to 4096)', 'threads')
      else if (threads > 1 .and. .not. has_threads()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'this library was built without threads (expected 1)', 'threads')
      end if
   end subroutine check_members

   !> Adds a table of cases to a scene. Errors: `NUTATE_BAD_SCENE`; the scene is unchanged then.
   subroutine add_cases(scene, names, n_names, numbers, lines, status, whole)
      type(scene_t), intent(inout) :: scene
      !> Names, `char *[n_names]`, and values, `double[lines][n_names]`.
      type(c_ptr), intent(in) :: names, numbers
      integer, intent(in) :: n_names
      integer(c_size_t), intent(in) :: lines
      type(status_t), intent(out) :: status
      !> Complete error message, if there is an error.
      character(len=:), allocatable, intent(out) :: whole
      type(c_ptr), pointer :: list(:)
      real(c_double), pointer :: values(:, :)
      character(len=field_length) :: texts(n_names)
      character(len=:), allocatable :: text
      type(scene_error_t) :: error
      integer :: i
      call c_f_pointer(names, list, [n_names])
      call c_f_pointer(numbers, values, [int(n_names, c_size_t), lines])
      do i = 1, n_names
         if (.not. c_associated(list(i))) status = null_argument('names[i]')
         call copy_text(list(i), text)
         if (len(text) > field_length) status = fail(NUTATE_BAD_SCENE, 'the name of a number is too long')
         texts(i) = text
      end do
      if (.not. status%ok()) return
      call add_table(texts, values, scene%groups, scene_kinds(), scene%ensemble, error)
      if (.not. error%raised) return
      status = fail(NUTATE_BAD_SCENE, error%text)
      whole = error%text
   end subroutine add_cases

   !> Sets the poll callback.
   subroutine start(self, poll, threads)
      class(polling_sweep_t), intent(inout) :: self
      type(poll_t), intent(in) :: poll
      !> Number of threads; the first is the calling one.
      integer, intent(in) :: threads
      if (.not. associated(self%answer)) allocate (self%answer)
      self%answer%poll = poll
      self%answer%alone = threads == 1
      allocate (self%answer%failures(2, threads), source=0_c_int)
   end subroutine start

   logical function ask_program(self) result(wants_end)
      class(polling_sweep_t), intent(in) :: self
      integer :: thread
      thread = thread_of(self)
      !$omp atomic read
      wants_end = self%answer%ended
      if (wants_end .or. thread > 1) return
      wants_end = self%answer%poll%wants_end()
      if (.not. wants_end) return
      !$omp atomic write
      self%answer%ended = .true.
   end function ask_program

   !> Returns the number of the current thread, from 1, the thread that called the library.
   integer function thread_of(self) result(thread)
      class(polling_sweep_t), intent(in) :: self
      thread = 1
      !$ if (.not. self%answer%alone) thread = omp_get_thread_num() + 1
   end function thread_of

   !> Makes the callbacks among the effects report their failures to the cell of the current thread.
   subroutine prepare_callbacks(self, effects)
      class(polling_sweep_t), intent(in) :: self
      type(effect_list_t), intent(inout) :: effects
      integer :: thread
      thread = thread_of(self)
      self%answer%failures(:, thread) = 0
      call report_failures_to(effects, c_loc(self%answer%failures(1, thread)))
   end subroutine prepare_callbacks

   subroutine check_callbacks(self, status)
      class(polling_sweep_t), intent(in) :: self
      type(status_t), intent(out) :: status
      integer :: thread
      thread = thread_of(self)
      if (self%answer%failures(1, thread) /= NUTATE_OK) status = status_of_failure(self%answer%failures(:, thread))
   end subroutine check_callbacks

   subroutine forget(self)
      type(polling_sweep_t), intent(inout) :: self
      if (associated(self%answer)) deallocate (self%answer)
   end subroutine forget

end module nutate_c_sweep
