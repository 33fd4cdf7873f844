!> Sweeps whose chunks are handed out by hand to others that have joined them, as a program of several processes does.
module test_sweep
   use, intrinsic :: iso_c_binding, only: c_int
   use nutate_files, only: remove_file
   use nutate_kinds, only: long
   use nutate_member_run, only: member_run_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_IO
   use nutate_sweep, only: sweep_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_text_file, only: read_text_file
   use test_support, only: check, error_type, new_unittest, test_failed, unittest_type
   implicit none
   private

   public :: collect_sweep

   character, parameter :: line_feed = achar(10)
   character(len=*), parameter :: box = "&body inertia = 5.0, 20.0, 17.0 /"//line_feed// &
                                  "&initial angular_velocity = 0.1, 0.0, 10.0 /"//line_feed// &
                                  "&integrator time_step = 0.01, end_time = 0.1 /"//line_feed// &
                                  "&vary key = 'body.inertia.1', distribution = 'uniform', low=4, high=6 /"//line_feed
   integer(long), parameter :: members = 23

   !> A process that has joined a sweep, or leads it.
   type :: hand_t
      type(sweep_t) :: sweep
      type(member_run_t) :: runner
      integer(long) :: chunk = 0
      integer(long), allocatable :: fields(:, :)
   contains
      final :: end_hand
   end type hand_t

   interface
      integer(c_int) function getpid() bind(c, name='getpid')
         import :: c_int
      end function getpid
   end interface

contains

   !> Does nothing, and lets gfortran free the components in one place, not wherever such a variable ends.
   impure elemental subroutine end_hand(self)
      type(hand_t), intent(inout) :: self
   end subroutine end_hand

   subroutine collect_sweep(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("chunks of several processes make the file of one", rows_of_several), &
                  new_unittest("what is not finished is run by those who go on", gone_on), &
                  new_unittest("sums of several processes are those of one, in any order", sums_of_several), &
                  new_unittest("a process with another scene, or another file, is refused", strangers)]
   end subroutine collect_sweep

   !> The box with an ensemble.
   subroutine make(rows, scene, error)
      character(len=*), intent(in) :: rows
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(box//"&ensemble members = 23, seed = 5, chunk = 3, rows = '"//rows//"' /", 'box.nml', scene, &
                       status, message)
      if (.not. status%ok()) call test_failed(error, message)
   end subroutine make

   !> A path for a file of this process.
   function scratch(name) result(path)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: path
      character(len=512) :: folder
      character(len=12) :: number
      integer :: length
      call get_environment_variable('TMPDIR', folder, length)
      write (number, '(i0)') getpid()
      path = '/tmp'
      if (length > 0) path = folder(1:length)
      path = path//'/nutate-sweep-'//trim(number)//'-'//name
   end function scratch

   !> The file of a sweep by one process.
   subroutine run_alone(scene, name, content)
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      character(len=:), allocatable, intent(out) :: content
      class(sweep_t), allocatable :: sweep
      type(sweep_watcher_t) :: nobody
      type(status_t) :: status
      allocate (sweep)
      call sweep%open(scene, 1_long, members, name, .false., status)
      if (status%ok()) call sweep%go(scene, 1, nobody, status)
      if (status%ok()) call sweep%close(status)
      call read_content(name, content)
   end subroutine run_alone

   !> Reads the content of a file, and removes the file.
   subroutine read_content(name, content)
      character(len=*), intent(in) :: name
      character(len=:), allocatable, intent(out) :: content
      character(len=:), allocatable :: problem
      type(status_t) :: status
      call read_text_file(name, content, problem)
      if (problem /= '') content = 'cannot be read'
      call remove_file(name, status)
   end subroutine read_content

   !> A leader and two who join it; the leader runs nothing.
   subroutine gather(scene, name, resume, leader, hands, status)
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      logical, intent(in) :: resume
      type(sweep_t), intent(inout) :: leader
      type(hand_t), intent(inout) :: hands(:)
      type(status_t), intent(out) :: status
      integer :: i
      call leader%open(scene, 1_long, members, name, resume, status)
      do i = 1, size(hands)
         if (status%ok()) call hands(i)%sweep%join(scene, 1_long, members, name, leader%chunk, leader%identity, status)
         if (status%ok()) call hands(i)%runner%prepare(scene, hands(i)%sweep%layout, status)
      end do
   end subroutine gather

   !> Hands out chunks, and takes them back in the order last come, first done.
   subroutine work(scene, leader, hands, most, status)
      type(scene_t), intent(in) :: scene
      type(sweep_t), intent(inout) :: leader
      type(hand_t), intent(inout), target :: hands(:)
      !> Rounds.
      integer, intent(in) :: most
      type(status_t), intent(inout) :: status
      integer :: i, round
      do round = 1, most
         do i = 1, size(hands)
            call leader%get_chunk(hands(i)%chunk)
         end do
         do i = size(hands), 1, -1
            associate (hand => hands(i))
               if (hand%chunk == 0 .or. .not. status%ok()) cycle
               call hand%sweep%run_chunk(scene, hand%runner, hand%chunk, hand%fields, status)
               if (status%ok()) call leader%finish_chunk(hand%chunk, hand%fields, status)
            end associate
         end do
      end do
   end subroutine work

   subroutine rows_of_several(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call make('final', scene, error)
      if (allocated(error)) return
      call compare(scene, 'rows.npy', error)
   end subroutine rows_of_several

   subroutine sums_of_several(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call make('none', scene, error)
      if (allocated(error)) return
      call compare(scene, 'sums.csv', error)
   end subroutine sums_of_several

   !> The file of two who have joined is that of one process.
   subroutine compare(scene, name, error)
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      type(error_type), allocatable, intent(inout) :: error
      class(sweep_t), allocatable :: leader
      type(hand_t) :: hands(2)
      type(status_t) :: status, closing
      character(len=:), allocatable :: whole, content
      integer :: i
      allocate (leader)
      call run_alone(scene, scratch(name), whole)
      call gather(scene, scratch(name), .false., leader, hands, status)
      if (status%ok()) call work(scene, leader, hands, 4, status)
      if (status%ok()) call check(error, leader%members_done == members)
      do i = 1, 2
         call hands(i)%sweep%abandon(closing)
      end do
      if (status%ok()) call leader%close(status)
      if (.not. status%ok()) call test_failed(error, trim(status%message))
      call read_content(scratch(name), content)
      call check(error, len(whole) > 200 .and. content == whole)
   end subroutine compare

   subroutine gone_on(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(sweep_t), allocatable :: leader, next
      type(hand_t) :: hands(2), others(1)
      type(status_t) :: status, closing
      character(len=:), allocatable :: whole, content
      integer(long) :: lost
      allocate (scene, leader, next)
      call make('final', scene, error)
      if (allocated(error)) return
      call run_alone(scene, scratch('on.npy'), whole)
      call gather(scene, scratch('on.npy'), .false., leader, hands, status)
      if (status%ok()) call work(scene, leader, hands, 2, status)
      ! Run, but nobody has been told.
      call leader%get_chunk(lost)
      if (status%ok()) call hands(1)%sweep%run_chunk(scene, hands(1)%runner, lost, hands(1)%fields, status)
      call leader%abandon(closing)
      if (status%ok()) call gather(scene, scratch('on.npy'), .true., next, others, status)
      if (status%ok()) call check(error, next%members_done == 12)
      if (status%ok()) call work(scene, next, others, 4, status)
      if (status%ok()) call next%close(status)
      if (.not. status%ok()) call test_failed(error, trim(status%message))
      call read_content(scratch('on.npy'), content)
      call check(error, content == whole)
   end subroutine gone_on

   subroutine strangers(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene, other
      class(sweep_t), allocatable :: leader, stranger
      type(status_t) :: status, ignored
      character(len=:), allocatable :: name
      allocate (scene, leader, stranger)
      name = scratch('strangers.npy')
      call make('final', scene, error)
      if (allocated(error)) return
      allocate (other, source=scene)
      other%ensemble%targets(1)%name = 'body.inertia.2'
      call leader%open(scene, 1_long, members, name, .false., status)
      call check(error, status%code, 0)
      call stranger%join(other, 1_long, members, name, leader%chunk, leader%identity, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call stranger%join(scene, 1_long, members, name//'x', leader%chunk, leader%identity, status)
      call check(error, status%code, NUTATE_IO)
      call leader%abandon(ignored)
      call remove_file(name//'.partial', ignored)
   end subroutine strangers

end module test_sweep
