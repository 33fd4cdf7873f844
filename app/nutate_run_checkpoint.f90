!> Checkpoints: how to go on with a run, in a file that is replaced at once and tells damage.
!>
!> It holds which scene it belongs to, with which numbers of which version, and where the rows are; then, as archives,
!> what the watcher and the run itself need.
module nutate_run_checkpoint
   use nutate_byte_archive, only: byte_archive_t
   use nutate_files, only: remove_file
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp, long
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_print, only: print_of
   use nutate_sealed_file, only: read_sealed, write_sealed
   use nutate_status, only: status_t
   use nutate_version, only: version
   implicit none
   private

   public :: checkpoint_t, read_checkpoint

   !> What a checkpoint begins with: its kind, and the number of its format, which changes with what an archive holds.
   character(len=*), parameter :: signature = 'nutate checkpoint 3'//achar(10)

   !> Where and when checkpoints of a run are written.
   type :: checkpoint_t
      !> Not allocated where there are none.
      character(len=:), allocatable :: file
      !> Time between them, s.
      real(wp) :: every = 60.0_wp
      !> There is one.
      logical :: written = .false.
      !> The scene's groups, and where its rows go.
      type(group_t), allocatable, private :: groups(:)
      character(len=:), allocatable, private :: output
      !> Clock count at which the next one is due, and counts between two.
      integer(long), private :: due = 0, interval = 0
   contains
      !> Stores the scene.
      procedure :: prepare
      !> True if checkpoints are written at all.
      procedure :: is_wanted
      !> True if it is time for one.
      procedure :: is_due
      !> Writes one.
      procedure :: write => write_checkpoint
      !> Removes the last one.
      procedure :: remove
   end type checkpoint_t

contains

   !> Stores the scene of the run.
   subroutine prepare(self, file, every, scene, is_resumed)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: file
      !> s.
      real(wp), intent(in) :: every
      type(scene_t), intent(in) :: scene
      !> The file holds the checkpoint that the run goes on from.
      logical, intent(in) :: is_resumed
      integer(long) :: rate
      self%file = file
      self%every = every
      self%groups = scene%groups
      self%output = scene%output%file
      self%written = is_resumed
      call system_clock(self%due, rate)
      self%interval = int(every*real(rate, wp), long)
   end subroutine prepare

   !> True if checkpoints are written at all.
   pure logical function is_wanted(self)
      class(checkpoint_t), intent(in) :: self
      is_wanted = allocated(self%file)
   end function is_wanted

   !> True if it is time for one.
   pure logical function is_due(self, now)
      class(checkpoint_t), intent(in) :: self
      !> Count of the system clock.
      integer(long), intent(in) :: now
      is_due = .false.
      if (allocated(self%file)) is_due = now >= self%due
   end function is_due

   !> Writes what a run needs to go on. Errors: `NUTATE_IO`; the last one stays then.
   subroutine write_checkpoint(self, content, status)
      class(checkpoint_t), intent(inout) :: self
      !> What the watcher and the run put in archives.
      character(len=*), intent(in) :: content
      type(status_t), intent(out) :: status
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: problem, whole
      whole = content
      call archive%begin_writing()
      call transfer_origin(archive, self%groups, problem)
      call archive%transfer(self%output)
      call archive%transfer(whole)
      call write_sealed(self%file, signature, archive%content(), status)
      call system_clock(self%due)
      self%due = self%due + self%interval
      self%written = self%written .or. status%ok()
   end subroutine write_checkpoint

   !> Removes the last one. Errors: `NUTATE_IO`.
   subroutine remove(self, status)
      class(checkpoint_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      if (self%written) call remove_file(self%file, status)
      self%written = .false.
   end subroutine remove

   !> Reads a checkpoint of a scene.
   subroutine read_checkpoint(file, scene, content, problem)
      character(len=*), intent(in) :: file
      !> The name of its output is set to what it was.
      type(scene_t), intent(inout) :: scene
      !> What the watcher and the run put in archives.
      character(len=:), allocatable, intent(out) :: content
      !> What is wrong, one line; empty if nothing is.
      character(len=:), allocatable, intent(out) :: problem
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: bytes
      content = ''
      call read_sealed(file, signature, bytes, problem)
      if (problem == '') then
         call archive%begin_reading(bytes)
         call transfer_origin(archive, scene%groups, problem)
      end if
      if (problem == '') then
         call archive%transfer(scene%output%file)
         call archive%transfer(content)
         if (archive%problem() /= '') problem = 'is damaged: '//archive%problem()
      end if
      if (problem /= '') problem = printable_path(file)//' '//problem
   end subroutine read_checkpoint

   !> Version, numbers and scene: put in an archive, or compared with those of one.
   subroutine transfer_origin(archive, groups, problem)
      type(byte_archive_t), intent(inout) :: archive
      type(group_t), intent(in) :: groups(:)
      !> How they differ; empty where they do not.
      character(len=:), allocatable, intent(out) :: problem
      character(len=:), allocatable :: text, here
      integer :: bits, n, i

      problem = ''
      text = version
      call archive%transfer(text)
      if (text /= version) then
         problem = 'was written by nutate '//text//' (this is '//version//')'
         return
      end if
      bits = storage_size(1.0_wp)
      call archive%transfer(bits)
      if (bits /= storage_size(1.0_wp)) then
         problem = 'was written by nutate with another precision'
         return
      end if
      n = size(groups)
      call archive%transfer(n)
      do i = 1, min(n, size(groups))
         here = print_of(groups(i))
         text = here
         call archive%transfer(text)
         if (text /= here) then
            problem = 'belongs to another scene (&'//trim(groups(i)%name)//' is not the same)'
            return
         end if
      end do
      if (n /= size(groups)) problem = 'belongs to another scene (with other groups)'
   end subroutine transfer_origin

end module nutate_run_checkpoint
