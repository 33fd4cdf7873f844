!> Tables of cases: a header with names of numbers of the scene, then a line of numbers for each member.
module nutate_scene_cases
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_table, only: begin_of, count_lines, next_field, read_named_file, read_row
   implicit none
   private

   public :: read_cases

   !> Maximum numbers of columns, and of letters of a name.
   integer, parameter :: most_columns = 200, longest_name = 80

contains

   !> Reads the table that a group names by its key `table`. Raises an error, with file and line, for an invalid table.
   subroutine read_cases(group, scene, names, numbers, path, error)
      type(group_t), intent(in) :: group
      !> Path of the scene.
      character(len=*), intent(in) :: scene
      character(len=longest_name), allocatable, intent(out) :: names(:)
      !> Shape (columns, lines without the header).
      real(wp), allocatable, intent(out) :: numbers(:, :)
      !> Path of the table.
      character(len=:), allocatable, intent(out) :: path
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: text, problem
      integer :: position, line

      call read_named_file(group, 'table', scene, 'a CSV file', path, text, error)
      if (error%raised) return
      position = begin_of(text)
      call read_names(text, position, names, problem)
      if (problem == '') then
         allocate (numbers(size(names), count_lines(text) - 1))
         if (size(numbers, 2) == 0) problem = 'the table has no line (expected one for each member)'
      end if
      if (problem /= '') then
         call error%raise_in(path, 1, problem)
         return
      end if
      do line = 1, size(numbers, 2)
         call read_row(text, position, numbers(:, line), problem)
         if (problem == '') cycle
         call error%raise_in(path, line + 1, problem)
         return
      end do
   end subroutine read_cases

   !> Reads the header row.
   subroutine read_names(text, position, names, problem)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: position
      character(len=longest_name), allocatable, intent(out) :: names(:)
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=longest_name) :: found(most_columns)
      integer :: n, first, last
      logical :: ends

      problem = ''
      ends = .false.
      n = 0
      do while (.not. ends .and. problem == '')
         call next_field(text, position, first, last, ends, problem)
         if (problem /= '') exit
         if (n == most_columns) then
            problem = 'the table has too many columns (expected 200 at most)'
         else if (last < first .or. last - first >= longest_name) then
            problem = quoted(text(first:last))//' is not the name of a number (expected names such as '// &
                      'initial.angular_velocity.3)'
         else
            n = n + 1
            found(n) = text(first:last)
         end if
      end do
      names = found(1:n)
   end subroutine read_names

end module nutate_scene_cases
