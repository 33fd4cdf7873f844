!> First error of a scene, and the rules about keys that exclude or require each other.
module nutate_scene_error
   use nutate_keys, only: group_t
   use nutate_printable, only: printable_path
   use nutate_spelling, only: count_text
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: scene_error_t, error_line, allow_one_of, demand_one_of, demand_with
   public :: LINE_OF_SET, LINE_OF_UNSET, PLACE_OF_SET, PLACE_OF_UNSET

   !> Values instead of a line of the file: an override that sets a key, and one that removes a key.
   integer, parameter :: LINE_OF_SET = 0, LINE_OF_UNSET = -1
   !> Prefixes of messages about overrides.
   character(len=*), parameter :: PLACE_OF_SET = 'override: ', PLACE_OF_UNSET = "override with '-': "

   !> First error of a scene. Errors that are raised after it are ignored.
   type :: scene_error_t
      logical :: raised = .false.
      !> Line of the file, or `LINE_OF_...`.
      integer :: line = LINE_OF_SET
      character(len=:), allocatable :: text
      !> Status code if the groups do not come from a scene: `NUTATE_BAD_ARGUMENT`, or the code of a status.
      integer :: code = NUTATE_BAD_ARGUMENT
      !> The text begins with the position of the error in another file than the scene.
      logical :: elsewhere = .false.
   contains
      procedure, non_overridable :: raise
      !> Records an error in a file that a scene names.
      procedure, non_overridable :: raise_in
      !> Records the failure of a status.
      procedure, non_overridable :: raise_status
   end type scene_error_t

contains

   !> Records an error as `what (expected; nearest: name)` unless there is one already.
   pure subroutine raise(self, line, what, expected, nearest)
      class(scene_error_t), intent(inout) :: self
      !> Line of the file, or `LINE_OF_...`.
      integer, intent(in) :: line
      !> Description of the error.
      character(len=*), intent(in) :: what
      !> Description of the correct input.
      character(len=*), intent(in), optional :: expected
      !> Known name that is nearest to an unknown one; blank if there is none.
      character(len=*), intent(in), optional :: nearest

      if (self%raised) return
      self%raised = .true.
      self%line = line
      self%text = what
      if (.not. present(expected)) return
      self%text = what//' (expected '//expected
      if (present(nearest)) then
         if (nearest /= '') self%text = self%text//'; nearest: '//nearest
      end if
      self%text = self%text//')'
   end subroutine raise

   !> Records an error in a file that a scene names, unless there is one already.
   pure subroutine raise_in(self, path, line, what)
      class(scene_error_t), intent(inout) :: self
      character(len=*), intent(in) :: path
      integer, intent(in) :: line
      !> Description of the error and of the correct input.
      character(len=*), intent(in) :: what
      if (self%raised) return
      call self%raise(line, place_of(path, line)//what)
      self%elsewhere = .true.
   end subroutine raise_in

   !> Records a failure unless there is one already.
   pure subroutine raise_status(self, line, status)
      class(scene_error_t), intent(inout) :: self
      integer, intent(in) :: line
      type(status_t), intent(in) :: status

      if (self%raised) return
      call self%raise(line, trim(status%message))
      self%code = status%code
   end subroutine raise_status

   !> Returns the error as a printable line: `FILE:LINE: text`, or `PLACE_OF_...` and the text.
   pure function error_line(path, error) result(line)
      character(len=*), intent(in) :: path
      type(scene_error_t), intent(in) :: error
      character(len=:), allocatable :: line
      if (error%elsewhere) then
         line = error%text
      else if (error%line == LINE_OF_SET) then
         line = PLACE_OF_SET//error%text
      else if (error%line == LINE_OF_UNSET) then
         line = PLACE_OF_UNSET//error%text
      else
         line = place_of(path, error%line)//error%text
      end if
   end function error_line

   !> Returns `FILE:LINE: `.
   pure function place_of(path, line) result(place)
      character(len=*), intent(in) :: path
      integer, intent(in) :: line
      character(len=:), allocatable :: place
      place = printable_path(path)//':'//count_text(line)//': '
   end function place_of

   !> Raises an error on the second of several keys that mean the same.
   subroutine allow_one_of(group, names, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: names(:)
      type(scene_error_t), intent(inout) :: error
      integer :: i, first

      if (.not. allocated(group%settings)) return
      first = 0
      do i = 1, size(group%settings)
         if (.not. any(names == group%settings(i)%name)) cycle
         if (first == 0) then
            first = i
            cycle
         end if
         call error%raise(group%settings(i)%line, trim(group%settings(first)%name)//' and '// &
                          trim(group%settings(i)%name)//' in &'//trim(group%name)//' exclude each other', &
                          expected='one of '//listed(names))
         return
      end do
   end subroutine allow_one_of

   !> Raises an error on the group if none of several keys is there.
   subroutine demand_one_of(group, names, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: names(:)
      type(scene_error_t), intent(inout) :: error
      integer :: i
      if (any([(group%has(trim(names(i))), i=1, size(names))])) return
      call error%raise(group%line, '&'//trim(group%name)//' is incomplete', expected=listed(names))
   end subroutine demand_one_of

   !> Raises an error on the group if a key is given without another that it requires.
   subroutine demand_with(group, name, needed, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: name, needed
      type(scene_error_t), intent(inout) :: error
      if (.not. group%has(name) .or. group%has(needed)) return
      call error%raise(group%line, name//' in &'//trim(group%name)//' requires '//needed, expected=needed)
   end subroutine demand_with

   !> Returns names as `a, b or c`.
   pure function listed(names) result(text)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: text
      integer :: i
      text = trim(names(1))
      do i = 2, size(names)
         if (i < size(names)) then
            text = text//', '//trim(names(i))
         else
            text = text//' or '//trim(names(i))
         end if
      end do
   end function listed

end module nutate_scene_error
