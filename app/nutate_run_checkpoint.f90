!> Checkpoints: the data to resume a run, in a file that is replaced at once and detects damage.
!>
!> A checkpoint holds the version, the precision, the groups of the scene and the path of the rows, followed by the
!> archives of the watcher and of the run.
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

   !> First bytes of a checkpoint: its kind, and the number of its format, which changes with the content of an archive.
   character(len=*), parameter :: signature = 'nutate checkpoint 3'//achar(10)

   !> File and schedule of the checkpoints of a run.
   type :: checkpoint_t
      !> Path of the file; not allocated if there are no checkpoints.
      character(len=:), allocatable :: file
      !> Time between checkpoints, s.
      real(wp) :: every = 60.0_wp
      !> True if a checkpoint exists.
      logical :: written = .false.
      !> Groups of the scene, and path of its rows.
      type(group_t), allocatable, private :: groups(:)
      character(len=:), allocatable, private :: output
      !> Clock count at which the next checkpoint is due, and counts between two checkpoints.
      integer(long), private :: due = 0, interval = 0
   contains
      !> Stores the scene.
      procedure :: prepare
      !> Returns true if checkpoints are written at all.
      procedure :: is_wanted
      !> Returns true if a checkpoint is due.
      procedure :: is_due
      !> Writes a checkpoint.
      procedure :: write => write_checkpoint
      !> Removes the last checkpoint.
      procedure :: remove
   end type checkpoint_t

contains

   !> Stores the scene of the run.
   subroutine prepare(self, file, every, scene, is_resumed)
      class(checkpoint_t), intent(inout) :: self
      character(len=*), intent(in) :: file
      !> Time between checkpoints, s.
      real(wp), intent(in) :: every
      type(scene_t), intent(in) :: scene
      !> True if the file holds the checkpoint that the run resumes.
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

   !> Returns true if checkpoints are written at all.
   pure logical function is_wanted(self)
      class(checkpoint_t), intent(in) :: self
      is_wanted = allocated(self%file)
   end function is_wanted

   !> Returns true if a checkpoint is due.
   pure logical function is_due(self, now)
      class(checkpoint_t), intent(in) :: self
      !> Count of the system clock.
      integer(long), intent(in) :: now
      is_due = .false.
      if (allocated(self%file)) is_due = now >= self%due
   end function is_due

   !> Writes a checkpoint. Errors: `NUTATE_IO`; the last checkpoint stays then.
   subroutine write_checkpoint(self, content, status)
      class(checkpoint_t), intent(inout) :: self
      !> Archives of the watcher and of the run.
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

   !> Removes the last checkpoint. Errors: `NUTATE_IO`.
   subroutine remove(self, status)
      class(checkpoint_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      if (self%written) call remove_file(self%file, status)
      self%written = .false.
   end subroutine remove

   !> Reads a checkpoint of a scene.
   subroutine read_checkpoint(file, scene, content, problem)
      character(len=*), intent(in) :: file
      !> Scene of the run; the path of its output is set to that in the checkpoint.
      type(scene_t), intent(inout) :: scene
      !> Archives of the watcher and of the run.
      character(len=:), allocatable, intent(out) :: content
      !> Error message, one line; empty on success.
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

   !> Puts version, precision and scene into an archive, or compares them with those in the archive.
   subroutine transfer_origin(archive, groups, problem)
      type(byte_archive_t), intent(inout) :: archive
      type(group_t), intent(in) :: groups(:)
      !> Difference in words; empty if there is none.
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
