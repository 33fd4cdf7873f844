!> The C interface: bitwise identical to the library, and a status for every misuse. The functions are called as C calls
!> them; misuses that only a C program can commit are in `test_c_null.c`, `test_c_misuse.c`, `test_c_callbacks.c` and
!> `test_c_programs.c`.
submodule(suites_of_interfaces) test_c_interface
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_loc, c_null_char, c_null_ptr, c_ptr, &
      c_size_t
   use, intrinsic :: iso_fortran_env, only: compiler_options
   use nutate_c_history, only: nutate_history_destroy, nutate_history_size, nutate_history_values, nutate_scene_run, &
      nutate_scene_write
   use nutate_c_reading, only: nutate_stepper_conjugate_momentum, nutate_stepper_quaternion, nutate_stepper_row, &
      nutate_stepper_width
   use nutate_c_runs, only: nutate_stepper_count_rows, nutate_stepper_run, nutate_stepper_run_to
   use nutate_c_scene, only: nutate_scene_destroy, nutate_scene_read
   use nutate_c_stepper, only: nutate_stepper_create_scene, nutate_stepper_destroy
   use nutate_c_stepping, only: nutate_stepper_steps
   use nutate_columns, only: columns_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   use test_support, only: check, check_below, error_type, new_unittest, shipped_scenes => scene_names, skip_test, &
                           test_failed
   implicit none

   !> Keeps the rows of a run of the library.
   type, extends(observer_t) :: keeper_t
      type(columns_t) :: columns
      integer :: rows = 0
      real(wp), allocatable :: values(:, :)
   contains
      procedure :: observe => keep_row
      procedure :: observe_step => follow_state
   end type keeper_t

   abstract interface
      !> A test in C: how many of its expectations failed.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

   procedure(c_test), bind(C, name='test_c_null_handles') :: test_c_null_handles
   procedure(c_test), bind(C, name='test_c_null_arguments') :: test_c_null_arguments
   procedure(c_test), bind(C, name='test_c_foreign_handles') :: test_c_foreign_handles
   procedure(c_test), bind(C, name='test_c_sizes') :: test_c_sizes
   procedure(c_test), bind(C, name='test_c_bad_steps') :: test_c_bad_steps
   procedure(c_test), bind(C, name='test_c_bad_numbers') :: test_c_bad_numbers
   procedure(c_test), bind(C, name='test_c_unknown_names') :: test_c_unknown_names
   procedure(c_test), bind(C, name='test_c_unprepared') :: test_c_unprepared
   procedure(c_test), bind(C, name='test_c_bad_callbacks') :: test_c_bad_callbacks
   procedure(c_test), bind(C, name='test_c_bad_callbacks_in_runs') :: test_c_bad_callbacks_in_runs
   procedure(c_test), bind(C, name='test_c_jumping_torque') :: test_c_jumping_torque
   procedure(c_test), bind(C, name='test_c_texts') :: test_c_texts
   procedure(c_test), bind(C, name='test_c_attitudes') :: test_c_attitudes
   procedure(c_test), bind(C, name='test_c_account_of_a_new_state') :: test_c_account_of_a_new_state
   procedure(c_test), bind(C, name='test_c_uncertified_steps') :: test_c_uncertified_steps
   procedure(c_test), bind(C, name='test_c_exact_motion') :: test_c_exact_motion
   procedure(c_test), bind(C, name='test_c_threads') :: test_c_threads

   interface
      integer(c_int) function test_c_own_gravity(with_hessian, worst) bind(C)
         import :: c_double, c_int
         integer(c_int), intent(in), value :: with_hessian
         real(c_double), intent(out) :: worst
      end function test_c_own_gravity
      integer(c_int) function test_c_own_damping(worst) bind(C)
         import :: c_double, c_int
         real(c_double), intent(out) :: worst
      end function test_c_own_damping
      integer(c_int) function test_c_many_handles(times) bind(C)
         import :: c_int
         integer(c_int), intent(in), value :: times
      end function test_c_many_handles
   end interface

contains

   module procedure collect_c_interface
      testsuite = [ &
                  new_unittest("every scene runs with the bits of the library", scenes_have_the_bits_of_the_library), &
                  new_unittest("every scene stepped in batches too", batches_have_the_bits_of_the_library), &
                  new_unittest("bare steps have the bits of stepper%step", steps_have_the_bits_of_the_library), &
                  new_unittest("CSV files read back as what is in memory", files_read_back), &
                  new_unittest("NULL handles", null_handles), &
                  new_unittest("NULL for every argument", null_arguments), &
                  new_unittest("foreign and destroyed handles", foreign_handles), &
                  new_unittest("wrong sizes", wrong_sizes), &
                  new_unittest("bad steps leave the state", bad_steps), &
                  new_unittest("bad numbers in every argument", bad_numbers), &
                  new_unittest("unknown names", unknown_names), &
                  new_unittest("settings that do not fit, steps without preparation", unprepared), &
                  new_unittest("callbacks that fail, NaN and extreme results", bad_callbacks), &
                  new_unittest("callbacks that fail in runs", bad_callbacks_in_runs), &
                  new_unittest("a torque that jumps is named, and dop853 runs", jumping_torque), &
                  new_unittest("texts are cut and ended", texts), &
                  new_unittest("attitudes there and back", attitudes), &
                  new_unittest("a user-defined potential is as good as a built-in one", own_gravity), &
                  new_unittest("a user-defined torque is as good as a built-in one", own_damping), &
                  new_unittest("work and energy count from the state that was set", account_of_a_new_state), &
                  new_unittest("steps without a proof are counted", uncertified_steps), &
                  new_unittest("the exact motion is that of short steps", exact_motion), &
                  new_unittest("eight threads have the bits of one", threads), &
                  new_unittest("handles made and freed", many_handles)]
   end procedure collect_c_interface

   !> Fails with the line of a C file.
   subroutine check_line(error, line, file)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      character(len=*), intent(in) :: file
      character(len=12) :: number
      write (number, '(i0)') line
      if (line /= 0) call test_failed(error, file//', line '//trim(number))
   end subroutine check_line

   subroutine null_handles(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_null_handles(), 'test_c_null.c')
   end subroutine null_handles

   subroutine null_arguments(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_null_arguments(), 'test_c_null.c')
   end subroutine null_arguments

   subroutine foreign_handles(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_foreign_handles(), 'test_c_misuse.c')
   end subroutine foreign_handles

   subroutine wrong_sizes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sizes(), 'test_c_misuse.c')
   end subroutine wrong_sizes

   subroutine bad_steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bad_steps(), 'test_c_misuse.c')
   end subroutine bad_steps

   subroutine bad_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bad_numbers(), 'test_c_misuse.c')
   end subroutine bad_numbers

   subroutine unknown_names(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_unknown_names(), 'test_c_misuse.c')
   end subroutine unknown_names

   subroutine unprepared(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_unprepared(), 'test_c_misuse.c')
   end subroutine unprepared

   subroutine bad_callbacks(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bad_callbacks(), 'test_c_callbacks.c')
   end subroutine bad_callbacks

   subroutine jumping_torque(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_jumping_torque(), 'test_c_callbacks.c')
   end subroutine jumping_torque

   subroutine bad_callbacks_in_runs(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bad_callbacks_in_runs(), 'test_c_callbacks.c')
   end subroutine bad_callbacks_in_runs

   subroutine texts(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_texts(), 'test_c_callbacks.c')
   end subroutine texts

   subroutine attitudes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_attitudes(), 'test_c_callbacks.c')
   end subroutine attitudes

   subroutine own_gravity(error)
      type(error_type), allocatable, intent(out) :: error
      real(c_double) :: worst
      call check_line(error, test_c_own_gravity(0_c_int, worst), 'test_c_programs.c')
      call check_line(error, test_c_own_gravity(1_c_int, worst), 'test_c_programs.c')
   end subroutine own_gravity

   subroutine own_damping(error)
      type(error_type), allocatable, intent(out) :: error
      real(c_double) :: worst
      call check_line(error, test_c_own_damping(worst), 'test_c_programs.c')
      call check_below(error, worst, 1e-12_wp)
   end subroutine own_damping

   subroutine account_of_a_new_state(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_account_of_a_new_state(), 'test_c_programs.c')
   end subroutine account_of_a_new_state

   subroutine uncertified_steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_uncertified_steps(), 'test_c_programs.c')
   end subroutine uncertified_steps

   subroutine exact_motion(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_exact_motion(), 'test_c_programs.c')
   end subroutine exact_motion

   !> The check for recursion of gfortran keeps a flag for all threads.
   subroutine threads(error)
      type(error_type), allocatable, intent(out) :: error
      if (index(compiler_options(), '-fcheck=all') > 0 .and. index(compiler_options(), 'no-recursion') == 0) then
         call skip_test(error, "run-time check of recursion")
      else
         call check_line(error, test_c_threads(), 'test_c_programs.c')
      end if
   end subroutine threads

   subroutine many_handles(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_many_handles(6_c_int), 'test_c_programs.c')
   end subroutine many_handles

   subroutine keep_row(self, system, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%rows = self%rows + 1
      call self%columns%evaluate(system, state, record, self%values(:, self%rows))
   end subroutine keep_row

   subroutine follow_state(self, state)
      class(keeper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      call self%columns%follow(state)
   end subroutine follow_state

   !> The rows of a shipped scene by the library.
   subroutine run_library(error, name, scene, keeper)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      type(scene_t), intent(inout) :: scene
      type(keeper_t), intent(inout) :: keeper
      class(stepper_t), allocatable :: stepper
      character(len=:), allocatable :: message
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer(long) :: steps
      call read_scene('scenes/'//trim(name)//'.nml', scene, status, message)
      if (status%ok()) call keeper%columns%choose(scene%output%columns, status)
      steps = nint(scene%plan%end_time/scene%plan%time_step, long)
      keeper%rows = 0
      keeper%observes_every_step = keeper%columns%follows_steps
      if (allocated(keeper%values)) deallocate (keeper%values)
      allocate (keeper%values(keeper%columns%width, steps/scene%plan%every + 2))
      call keeper%columns%start(scene%system, scene%initial, scene%integrator%inverse_auxiliary_inertia)
      state = scene%initial
      if (status%ok()) call integrate(scene%system, scene%integrator, state, scene%plan, status, keeper)
      call check(error, status%ok(), trim(name)//': '//trim(status%message))
   end subroutine run_library

   !> A shipped scene through C.
   subroutine open_scene(error, name, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      type(c_ptr), intent(out), target :: scene
      character(kind=c_char), target :: path(64)
      character(len=64) :: text
      integer :: i
      text = 'scenes/'//trim(name)//'.nml'//c_null_char
      path = [(text(i:i), i=1, 64)]
      call check(error, nutate_scene_read(c_loc(path), c_null_ptr, 0_c_size_t, c_loc(scene), c_null_ptr, 0_c_size_t) &
                 == 0, trim(name)//' cannot be read')
   end subroutine open_scene

   !> Fails unless all bits of the first rows agree.
   subroutine check_bits(error, values, expected, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: values(:, :), expected(:, :)
      character(len=*), intent(in) :: label
      call check(error, all(shape(values) == shape(expected)), label//': shapes differ')
      call check(error, .not. any(abs(values - expected) > 0.0_wp), label//': values differ')
   end subroutine check_bits

   subroutine scenes_have_the_bits_of_the_library(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(keeper_t) :: keeper
      type(c_ptr), target :: handle, history
      integer(c_size_t) :: rows, width
      real(c_double), allocatable :: values(:, :)
      integer :: i
      allocate (scene)
      do i = 1, size(shipped_scenes)
         call run_library(error, shipped_scenes(i), scene, keeper)
         if (allocated(error)) return
         call open_scene(error, shipped_scenes(i), handle)
         if (allocated(error)) return
         call check(error, nutate_scene_run(handle, c_loc(history), c_null_ptr, 0_c_size_t) == 0 .and. &
                    nutate_history_size(history, rows, width) == 0, trim(shipped_scenes(i))//' does not run')
         if (allocated(values)) deallocate (values)
         allocate (values(width, rows))
         call check(error, nutate_history_values(history, values, width*rows), 0)
         call check_bits(error, values, keeper%values(:, 1:keeper%rows), trim(shipped_scenes(i)))
         call check(error, nutate_history_destroy(c_loc(history)) + nutate_scene_destroy(c_loc(handle)), 0)
      end do
   end subroutine scenes_have_the_bits_of_the_library

   !> Runs all steps but the last in batches of uneven length, with the rows of the library, and the last one by
   !> `run_to`; then all steps by one `run_to`.
   subroutine batches_have_the_bits_of_the_library(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(shipped_scenes)
         call run_batches(error, shipped_scenes(i))
         if (.not. allocated(error)) call run_at_once(error, shipped_scenes(i))
      end do
   end subroutine batches_have_the_bits_of_the_library

   subroutine run_batches(error, name)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      class(scene_t), allocatable :: scene
      type(keeper_t) :: keeper
      type(c_ptr), target :: handle, stepper
      real(c_double), allocatable, target :: values(:, :)
      integer(c_size_t) :: room, added
      integer(c_int64_t) :: steps, batch
      integer :: filled, code
      allocate (scene)
      call run_library(error, name, scene, keeper)
      if (.not. allocated(error)) call open_scene(error, name, handle)
      if (allocated(error)) return
      allocate (values, mold=keeper%values)
      code = nutate_stepper_create_scene(handle, c_loc(stepper), c_null_ptr, 0_c_size_t)
      code = code + nutate_stepper_row(stepper, values, size(values, 1, c_size_t))
      filled = 1
      steps = nint(scene%plan%end_time/scene%plan%time_step, long) - scene%plan%every
      batch = scene%plan%every
      do while (steps > 0 .and. code == 0)
         batch = min(2*batch, steps)
         room = size(values, 2) - filled
         code = nutate_stepper_run(stepper, batch, scene%plan%every, c_loc(values(1, filled + 1)), room, added)
         filled = filled + int(added)
         steps = steps - batch
      end do
      call check(error, code, 0, name)
      call check_bits(error, values(:, :filled), keeper%values(:, :filled), name)
      call check(error, filled, keeper%rows - 1, name//': number of rows')
      code = nutate_stepper_run_to(stepper, scene%plan%end_time, scene%plan%every, 0.0_wp, c_null_ptr, 0_c_size_t, &
                                   added)
      code = code + nutate_stepper_row(stepper, values(:, filled + 1), size(values, 1, c_size_t))
      call check(error, code, 0, name)
      call check_last(error, values(:, filled + 1), keeper, name)
      call check(error, nutate_stepper_destroy(c_loc(stepper)) + nutate_scene_destroy(c_loc(handle)), 0)
   end subroutine run_batches

   !> The last row; what the solver did in it is that of its last part only, where the row is asked for afterwards.
   subroutine check_last(error, row, keeper, name)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: row(:)
      type(keeper_t), intent(in) :: keeper
      character(len=*), intent(in) :: name
      integer :: n
      n = size(row)
      if (index(keeper%columns%header(), 'iterations') > 0) n = n - 2
      call check(error, .not. any(abs(row(:n) - keeper%values(:n, keeper%rows)) > 0.0_wp), name//': last row differs')
   end subroutine check_last

   subroutine run_at_once(error, name)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      class(scene_t), allocatable :: scene
      type(keeper_t) :: keeper
      type(c_ptr), target :: handle, stepper
      real(c_double), allocatable, target :: values(:, :)
      integer(c_size_t) :: rows, width, added
      integer :: code
      allocate (scene)
      call run_library(error, name, scene, keeper)
      if (.not. allocated(error)) call open_scene(error, name, handle)
      if (allocated(error)) return
      code = nutate_stepper_create_scene(handle, c_loc(stepper), c_null_ptr, 0_c_size_t)
      code = code + nutate_stepper_width(stepper, width)
      code = code + nutate_stepper_count_rows(stepper, scene%plan%end_time, scene%plan%every, rows)
      allocate (values(width, rows))
      code = code + nutate_stepper_run_to(stepper, scene%plan%end_time, scene%plan%every, 0.0_wp, c_loc(values), rows, &
                                          added)
      call check(error, code == 0 .and. added == rows, name)
      if (.not. allocated(error)) call check_bits(error, values, keeper%values(:, 1:keeper%rows), name)
      if (allocated(error)) return
      call check(error, nutate_stepper_destroy(c_loc(stepper)) + nutate_scene_destroy(c_loc(handle)), 0)
   end subroutine run_at_once

   !> 200 bare steps of every scene that has an attitude.
   subroutine steps_have_the_bits_of_the_library(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(stepper_t), allocatable :: bare
      type(c_ptr), target :: handle, stepper
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(c_double) :: q(4), p(4)
      integer(c_int64_t) :: done
      integer :: i, k, code
      allocate (scene)
      do i = 1, size(shipped_scenes)
         call read_scene('scenes/'//trim(shipped_scenes(i))//'.nml', scene, status, message)
         if (.not. scene%integrator%attitude) cycle
         call make_stepper(scene%system, scene%integrator, bare, status)
         state = scene%initial
         do k = 1, 200
            if (status%ok()) call bare%step(scene%system, state, scene%plan%time_step, status)
         end do
         call open_scene(error, shipped_scenes(i), handle)
         if (allocated(error)) return
         code = nutate_stepper_create_scene(handle, c_loc(stepper), c_null_ptr, 0_c_size_t)
         code = code + nutate_stepper_steps(stepper, scene%plan%time_step, 200_c_int64_t, done)
         code = code + nutate_stepper_quaternion(stepper, q) + nutate_stepper_conjugate_momentum(stepper, p)
         call check(error, code == 0 .and. done == 200 .and. status%ok(), trim(shipped_scenes(i)))
         if (allocated(error)) return
         call check_bits(error, reshape([q, p], [8, 1]), reshape([state%q, state%p], [8, 1]), trim(shipped_scenes(i)))
         call check(error, nutate_stepper_destroy(c_loc(stepper)) + nutate_scene_destroy(c_loc(handle)), 0)
      end do
   end subroutine steps_have_the_bits_of_the_library

   !> The file that C writes holds, digit by digit, the rows of the library.
   subroutine files_read_back(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: file = 'build/test_c_interface.csv'
      character(kind=c_char), target :: path(len(file) + 1)
      class(scene_t), allocatable :: scene
      type(keeper_t) :: keeper
      type(c_ptr), target :: handle
      real(wp), allocatable :: values(:, :)
      character(len=400) :: header
      integer :: i, unit, problem
      allocate (scene)
      path = [(file(i:i), i=1, len(file)), c_null_char]
      call run_library(error, 'spring_gyroscope', scene, keeper)
      if (.not. allocated(error)) call open_scene(error, 'spring_gyroscope', handle)
      if (allocated(error)) return
      call check(error, nutate_scene_write(handle, c_loc(path), c_null_ptr, 0_c_size_t), 0)
      allocate (values, mold=keeper%values(:, 1:keeper%rows))
      open (newunit=unit, file=file, status='old', action='read', iostat=problem)
      if (problem == 0) read (unit, '(a)', iostat=problem) header
      if (problem == 0) read (unit, *, iostat=problem) values
      close (unit, status='delete')
      call check(error, problem == 0 .and. trim(header) == keeper%columns%header(), 'the file cannot be read')
      call check_bits(error, values, keeper%values(:, 1:keeper%rows), 'file')
      call check(error, nutate_scene_destroy(c_loc(handle)), 0)
   end subroutine files_read_back

end submodule test_c_interface
