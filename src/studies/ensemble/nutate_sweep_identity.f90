!> Checksum of what the rows of a sweep depend on; it shows whether a file belongs to a scene.
module nutate_sweep_identity
   use nutate_byte_archive, only: byte_archive_t
   use nutate_checksum, only: checksum
   use nutate_ensemble_plan, only: CASES
   use nutate_keys, only: name_length
   use nutate_kinds, only: wp, long
   use nutate_scene, only: scene_t
   use nutate_scene_print, only: print_of
   use nutate_version, only: version
   implicit none
   private

   public :: identity_of

   !> Keys that set where and how results are written.
   character(len=name_length), parameter :: of_files(5) = [character(len=name_length) :: &
                                            'file', 'events', 'precision', 'histories', 'chunk']

contains

   !> Returns a checksum over version, scene, ensemble and members. It is the same for sweeps with the same rows.
   integer(long) function identity_of(scene, first, last)
      type(scene_t), intent(in) :: scene
      !> First and last member.
      integer(long), intent(in) :: first, last
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: text
      integer(long) :: bounds(2)
      real(wp), allocatable :: line(:)
      integer :: i, k
      call archive%begin_writing()
      text = version
      call archive%transfer(text)
      bounds = [first, last]
      call archive%transfer(bounds(1))
      call archive%transfer(bounds(2))
      do i = 1, size(scene%groups)
         if (scene%groups(i)%name == 'scene') cycle
         text = print_of(scene%groups(i), of_files)
         call archive%transfer(text)
      end do
      do i = 1, size(scene%ensemble%variations)
         if (scene%ensemble%variations(i)%distribution /= CASES) cycle
         do k = 1, size(scene%ensemble%variations(i)%cases, 2)
            line = scene%ensemble%variations(i)%cases(:, k)
            call archive%transfer(line)
         end do
      end do
      do i = 1, size(scene%ensemble%targets)
         text = trim(scene%ensemble%targets(i)%name)
         call archive%transfer(text)
      end do
      identity_of = checksum(archive%content())
   end function identity_of

end module nutate_sweep_identity
