!> The groups of a scene as the text of a scene file.
module nutate_scene_text
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_loc, c_null_char, c_ptr, c_size_t
   use nutate_decimal, only: exact_text
   use nutate_keys, only: group_t, setting_t, KEY_INTEGER, KEY_LOGICAL, KEY_REAL
   use nutate_kinds, only: wp
   use nutate_scene_table, only: names_a_file, path_beside
   use nutate_spelling, only: count_text, escaped
   implicit none
   private

   public :: scene_text

   character, parameter :: line_feed = achar(10)
   integer, parameter :: longest_path = 4096

   interface
      !> Returns the working directory, by the C library; NULL if it does not fit.
      type(c_ptr) function c_working_directory(buffer, size) bind(C, name='getcwd')
         import :: c_ptr, c_size_t
         type(c_ptr), intent(in), value :: buffer
         integer(c_size_t), intent(in), value :: size
      end function c_working_directory
   end interface

contains

   !> Returns the groups as the text of a scene; numbers read back exactly.
   function scene_text(groups, path, target) result(text)
      type(group_t), intent(in) :: groups(:)
      !> Paths of the scene that they were read from, and of the one that the text is for: the names of its files are
      !> relative to the folder of each.
      character(len=*), intent(in) :: path, target
      character(len=:), allocatable :: text
      integer :: i, k
      text = ''
      do i = 1, size(groups)
         text = text//'&'//trim(groups(i)%name)//line_feed
         do k = 1, size(groups(i)%settings)
            text = text//'   '//setting_text(groups(i)%settings(k), groups(i)%name, path, target)//line_feed
         end do
         text = text//'/'//line_feed
      end do
   end function scene_text

   !> Returns a setting as `key = value, value`.
   function setting_text(setting, group, path, target) result(text)
      type(setting_t), intent(in) :: setting
      !> Name of its group.
      character(len=*), intent(in) :: group, path, target
      character(len=:), allocatable :: text
      integer :: i
      text = trim(setting%name)//' = '
      do i = 1, size(setting%values)
         if (i > 1) text = text//', '
         associate (value => setting%values(i))
            select case (setting%kind)
            case (KEY_REAL)
               text = text//number_text(setting%values(i)%number)
            case (KEY_INTEGER)
               text = text//count_text(value%whole)
            case (KEY_LOGICAL)
               text = text//trim(merge('.true. ', '.false.', value%flag))
            case default
               if (names_a_file(group, trim(setting%name))) then
                  text = text//quoted_text(path_from(target, path_beside(path, value%text)))
               else
                  text = text//quoted_text(value%text)
               end if
            end select
         end associate
      end do
   end function setting_text

   !> Returns a path of the working directory relative to the folder of a file; absolute if it is not below that folder.
   function path_from(file, path) result(seen)
      character(len=*), intent(in) :: file, path
      character(len=:), allocatable :: seen
      character(kind=c_char), target :: buffer(longest_path)
      integer :: folder, i
      seen = path
      folder = index(file, '/', back=.true.)
      if (folder == 0 .or. index(path, '/') == 1) return
      if (index(path, file(:folder)) == 1) then
         seen = path(folder + 1:)
      else if (c_associated(c_working_directory(c_loc(buffer), int(longest_path, c_size_t)))) then
         seen = '/'//path
         do i = findloc(buffer, c_null_char, dim=1) - 1, 1, -1
            seen = buffer(i)//seen
         end do
      end if
   end function path_from

   !> Returns a number as text of a scene; it may be infinite.
   pure function number_text(number) result(text)
      real(wp), intent(in) :: number
      character(len=:), allocatable :: text
      text = 'Infinity'
      if (abs(number) <= huge(number)) text = exact_text(number)
   end function number_text

   !> Returns a text in single quotes, with those inside doubled.
   pure function quoted_text(text) result(quoted)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      quoted = "'"//escaped(trim(text), "'", "'")//"'"
   end function quoted_text

end module nutate_scene_text
