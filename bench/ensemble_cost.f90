!> Cost of sweeps, by their number of members and of threads, and of files of rows.
program bench_ensemble
   use, intrinsic :: iso_fortran_env, only: int64
   use, intrinsic :: iso_c_binding, only: c_double
   use nutate, only: parse_scene, scene_t, status_t, wp
   use nutate_forks, only: has_threads
   use nutate_member_rows, only: fill_rows
   use nutate_npy, only: npy_header
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_sweep_csv, only: write_csv
   use nutate_sweep_file, only: sweep_file_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none

   interface
      real(c_double) function bench_thread_seconds() bind(C)
         import :: c_double
      end function bench_thread_seconds

      real(c_double) function bench_process_seconds() bind(C)
         import :: c_double
      end function bench_process_seconds
   end interface

   integer :: i

   write (*, '(a)') 'us a member of 100 steps (one thread: CPU time; two: CPU time of both, wall time)'
   write (*, '(a)') '  members threads'
   do i = 2, 4
      call sweep(10_int64**i, 1)
      if (has_threads()) call sweep(10_int64**i, 2)
   end do
   call files()

contains

   !> Measures rows per second into a NumPy file, each chunk on the disk before the next, and from it into CSV.
   subroutine files()
      integer(int64), parameter :: members = 200000, chunk = 4096
      character(len=*), parameter :: name = 'bench_rows'
      type(sweep_file_t) :: file
      type(scene_t) :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(int64), allocatable :: rows(:, :)
      integer(int64) :: begun, written, ended, rate, k
      integer :: error, unit
      call make_scene(members, scene, layout)
      allocate (rows(layout%width(), chunk))
      rows = transfer(1.0_wp/3, rows(1, 1))
      call system_clock(begun, rate)
      call file%open(name//'.npy', npy_header(layout, members), layout%width(), members, chunk, 1_int64, .false., &
                     status)
      do k = 1, (members + chunk - 1)/chunk
         call file%put_chunk(k, rows(:, 1:min(chunk, members - (k - 1)*chunk)), error)
         if (error /= 0) error stop 'rows of the benchmark cannot be written'
         call file%mark(k, status)
      end do
      call file%finish(status)
      call system_clock(written)
      call write_csv(name//'.npy', layout, members, name//'.csv', status)
      call system_clock(ended)
      if (.not. status%ok()) error stop 'the files of the benchmark cannot be written'
      write (*, '(/,a,i0,a,2es9.1)') 'rows of ', layout%width(), ' fields a second, .npy and CSV: ', &
         real(members, wp)*real(rate, wp)/real(written - begun, wp), &
         real(members, wp)*real(rate, wp)/real(ended - written, wp)
      open (newunit=unit, file=name//'.npy')
      close (unit, status='delete')
      open (newunit=unit, file=name//'.csv')
      close (unit, status='delete')
   end subroutine files

   !> Makes a scene with members of 100 steps.
   subroutine make_scene(members, scene, layout)
      integer(int64), intent(in) :: members
      type(scene_t), intent(out) :: scene
      type(row_layout_t), intent(out) :: layout
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=12) :: digits
      write (digits, '(i0)') members
      call parse_scene("&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 / "// &
                       "&rotor momentum = 2, 1, 5 / &integrator time_step = 0.1, end_time = 10, "// &
                       "method = 'taylor' / &output every = 100, columns = 'quaternion' / "// &
                       "&ensemble members = "//digits//" / &vary key = 'initial.angular_velocity', "// &
                       "distribution = 'normal', sigma = 0.1, 0.1, 0.1 /", 'bench', scene, status, message)
      if (.not. status%ok()) error stop 'the scene of the benchmark is refused'
      call make_layout(scene, layout, status)
   end subroutine make_scene

   !> Times a sweep in memory.
   subroutine sweep(members, threads)
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      real(wp) :: spent(2)
      call cost(members, threads, spent)
      write (*, '(i9,i8,*(f10.2))') members, threads, spent(:threads)
   end subroutine sweep

   !> Measures the time of a member, us, of processors and on the wall: the least of some sweeps, of many if they are
   !> short. With several threads the processor time is the mean, since the clock of a process is coarse.
   subroutine cost(members, threads, spent)
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      real(wp), intent(out) :: spent(2)
      type(sweep_watcher_t), target :: nobody
      type(scene_t) :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(int64), allocatable :: rows(:, :)
      integer(int64) :: begun, ended, rate, sweeps, k
      real(wp) :: start, all_start
      call make_scene(members, scene, layout)
      allocate (rows(layout%width(), members))
      spent = huge(spent)
      sweeps = min(1000_int64, max(2_int64, 300000/members))
      all_start = bench_process_seconds()
      do k = 1, sweeps
         call system_clock(begun, rate)
         start = bench_thread_seconds()
         call fill_rows(scene, layout, 1_int64, members, threads, nobody, rows, status)
         spent(1) = min(spent(1), bench_thread_seconds() - start)
         call system_clock(ended)
         spent(2) = min(spent(2), real(ended - begun, wp)/real(rate, wp))
      end do
      if (threads > 1) spent(1) = (bench_process_seconds() - all_start)/sweeps
      spent = 1e6_wp*spent/real(members, wp)
   end subroutine cost

end program bench_ensemble
