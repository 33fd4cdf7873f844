!> Content of the groups of a scene as bytes, by which a file is recognised as belonging to a scene.
module nutate_scene_print
   use nutate_byte_archive, only: byte_archive_t
   use nutate_keys, only: group_t, setting_t
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: print_of

contains

   !> Returns the content of a group as bytes: identical for groups with the same settings in the same order.
   function print_of(group, leave_out) result(bytes)
      type(group_t), intent(in) :: group
      !> Keys that are left out.
      character(len=*), intent(in), optional :: leave_out(:)
      character(len=:), allocatable :: bytes
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: text
      integer(long) :: bytes_of_table
      integer :: i
      call archive%begin_writing()
      text = group%name
      call archive%transfer(text)
      if (allocated(group%table)) then
         bytes_of_table = group%table%checksum
         call archive%transfer(bytes_of_table)
      end if
      if (allocated(group%center_table)) then
         bytes_of_table = group%center_table%checksum
         call archive%transfer(bytes_of_table)
      end if
      do i = 1, size(group%settings)
         if (present(leave_out)) then
            if (any(leave_out == group%settings(i)%name)) cycle
         end if
         call add_setting(archive, group%settings(i))
      end do
      bytes = archive%content()
   end function print_of

   subroutine add_setting(archive, setting)
      type(byte_archive_t), intent(inout) :: archive
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      integer :: i
      real(wp) :: number
      integer :: whole
      logical :: flag
      text = setting%name
      call archive%transfer(text)
      do i = 1, size(setting%values)
         number = setting%values(i)%number
         whole = setting%values(i)%whole
         flag = setting%values(i)%flag
         text = ''
         if (allocated(setting%values(i)%text)) text = setting%values(i)%text
         call archive%transfer(number)
         call archive%transfer(whole)
         call archive%transfer(flag)
         call archive%transfer(text)
      end do
   end subroutine add_setting

end module nutate_scene_print
