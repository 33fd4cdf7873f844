!> The calls of `nutate_files.c`, for `nutate_files`; the C file describes each. Functions that can fail return 0 or an
!> error number of the system; paths end with a null.
module nutate_file_calls
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long_long, c_ptr
   implicit none
   private

   public :: file_close, file_error_text, file_is_terminal, file_kind, file_open, file_open_beside, file_open_locked
   public :: file_read_tail, file_readable
   public :: file_remove, file_rename, file_replace, file_replaceable, file_same, file_settle, file_sync, file_target
   public :: file_truncate, file_write, file_write_at, prepare_process

   !> Kinds of file that a path can stand for; `nutate_files.c` has the same numbers.
   integer, parameter, public :: KIND_ABSENT = 0, KIND_REGULAR = 1, KIND_FOLDER = 2

   interface
      integer(c_int) function file_kind(path) bind(c, name='nutate_file_kind')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_kind
      integer(c_int) function file_target(path, target, size, longest) bind(c, name='nutate_file_target')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         character(kind=c_char), intent(out) :: target(*)
         integer(c_int), intent(in), value :: size
         integer(c_int), intent(out) :: longest
      end function file_target
      integer(c_int) function file_same(a, b) bind(c, name='nutate_file_same')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: a(*), b(*)
      end function file_same
      integer(c_int) function file_readable(path) bind(c, name='nutate_file_readable')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_readable
      integer(c_int) function file_replaceable(path) bind(c, name='nutate_file_replaceable')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_replaceable
      integer(c_int) function file_open(path, stop, descriptor) bind(c, name='nutate_file_open')
         import :: c_char, c_int, c_ptr
         character(kind=c_char), intent(in) :: path(*)
         type(c_ptr), intent(in), value :: stop
         integer(c_int), intent(out) :: descriptor
      end function file_open
      integer(c_int) function file_open_locked(path, keep, descriptor) bind(c, name='nutate_file_open_locked')
         import :: c_char, c_int, c_long_long
         character(kind=c_char), intent(in) :: path(*)
         integer(c_long_long), intent(in), value :: keep
         integer(c_int), intent(out) :: descriptor
      end function file_open_locked
      integer(c_int) function file_open_beside(path, size, descriptor) bind(c, name='nutate_file_open_beside')
         import :: c_char, c_int, c_long_long
         character(kind=c_char), intent(in) :: path(*)
         integer(c_long_long), intent(in), value :: size
         integer(c_int), intent(out) :: descriptor
      end function file_open_beside
      integer(c_int) function file_write(descriptor, bytes, count, stop, written) bind(c, name='nutate_file_write')
         import :: c_char, c_int, c_long_long, c_ptr
         integer(c_int), intent(in), value :: descriptor
         character(kind=c_char), intent(in) :: bytes(*)
         integer(c_long_long), intent(in), value :: count
         type(c_ptr), intent(in), value :: stop
         integer(c_long_long), intent(out) :: written
      end function file_write
      integer(c_int) function file_write_at(descriptor, bytes, count, offset) bind(c, name='nutate_file_write_at')
         import :: c_int, c_long_long, c_ptr
         integer(c_int), intent(in), value :: descriptor
         type(c_ptr), intent(in), value :: bytes
         integer(c_long_long), intent(in), value :: count, offset
      end function file_write_at
      integer(c_int) function file_truncate(descriptor, size) bind(c, name='nutate_file_truncate')
         import :: c_int, c_long_long
         integer(c_int), intent(in), value :: descriptor
         integer(c_long_long), intent(in), value :: size
      end function file_truncate
      integer(c_int) function file_sync(descriptor) bind(c, name='nutate_file_sync')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_sync
      integer(c_int) function file_read_tail(path, end, bytes, size, count) bind(c, name='nutate_file_read_tail')
         import :: c_char, c_int, c_long_long
         character(kind=c_char), intent(in) :: path(*)
         integer(c_long_long), intent(in), value :: end
         character(kind=c_char), intent(out) :: bytes(*)
         integer(c_int), intent(in), value :: size
         integer(c_int), intent(out) :: count
      end function file_read_tail
      integer(c_int) function file_replace(path, temporary, bytes, count) bind(c, name='nutate_file_replace')
         import :: c_char, c_int, c_long_long
         character(kind=c_char), intent(in) :: path(*), temporary(*), bytes(*)
         integer(c_long_long), intent(in), value :: count
      end function file_replace
      integer(c_int) function file_remove(path) bind(c, name='nutate_file_remove')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_remove
      integer(c_int) function file_settle(descriptor) bind(c, name='nutate_file_settle')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_settle
      integer(c_int) function file_close(descriptor) bind(c, name='nutate_file_close')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_close
      integer(c_int) function file_rename(from, to) bind(c, name='nutate_file_rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function file_rename
      integer(c_int) function file_is_terminal(descriptor) bind(c, name='nutate_file_is_terminal')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_is_terminal
      !> Prepares a process, to be called first by a program: reports a limit on the size of files as an error of
      !> writing, suppresses backtraces of the runtime for signals that end the program, and reserves the numbers of
      !> closed standard streams.
      subroutine prepare_process() bind(c, name='nutate_file_prepare_process')
      end subroutine prepare_process
      subroutine file_error_text(error, text, size) bind(c, name='nutate_file_error_text')
         import :: c_char, c_int
         integer(c_int), intent(in), value :: error
         character(kind=c_char), intent(out) :: text(*)
         integer(c_int), intent(in), value :: size
      end subroutine file_error_text
   end interface

end module nutate_file_calls
