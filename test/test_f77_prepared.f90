!> Work arrays of FORTRAN 77 programs share what has been prepared for their set-up, and nothing else.
submodule(suites_of_interfaces) test_f77_prepared
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_int, c_loc, c_ptr
   use nutate_f77_prepared, only: f77_body_t, find_body, let_go
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_number_archive, only: number_archive_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_c_support, only: run_threads
   use test_f77_routines, only: nuomeg, nustep, potspr, tormot
   use test_f77_twins, only: forced_twin, iuser, most, plain, row_keeper_t, run_library, start, top_twin, twin_of, &
      twin_t
   use test_problems, only: box, forced_body, problem_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   integer, parameter :: n_threads = 8, n_steps = 30

   !> A motion in a WORK of its own.
   type :: motion_t
      real(wp) :: work(most) = 0.0_wp, t = 0.0_wp, q(4) = 0.0_wp, p(4) = 0.0_wp, dt = 0.0_wp
      integer :: info = 0
   end type motion_t

   !> Data that threads share: each has its own motion.
   type :: job_t
      type(motion_t) :: motions(n_threads)
   end type job_t

contains

   module procedure collect_f77_prepared
      testsuite = [ &
                  new_unittest("F77 bodies of one set-up do not disturb each other", alike_bodies_are_alone), &
                  new_unittest("F77 WORK that is put back repeats its steps", work_put_back_repeats), &
                  new_unittest("F77 more bodies than a cache had room for", many_bodies_are_alone), &
                  new_unittest("F77 bodies of one hash are told apart", equal_hashes_are_told_apart), &
                  new_unittest("F77 body in use is not given to a second call", busy_body_is_not_shared), &
                  new_unittest("F77 threads step bodies of one set-up", threads_step_alike_bodies), &
                  new_unittest("numbers of a stepper are those that it archives", numbers_are_those_archived)]
   end procedure collect_f77_prepared

   !> Begins a motion.
   subroutine begin(twin, dt, motion)
      type(twin_t), intent(in) :: twin
      real(wp), intent(in) :: dt
      type(motion_t), intent(out) :: motion
      call start(twin, motion%work, most, motion%t, motion%q, motion%p, motion%info)
      motion%dt = dt
   end subroutine begin

   !> Takes steps.
   subroutine step(motion, n)
      type(motion_t), intent(inout) :: motion
      integer, intent(in) :: n
      call nustep(n, motion%dt, motion%t, motion%q, motion%p, potspr, tormot, iuser, plain, motion%work, &
                  most, motion%info)
   end subroutine step

   !> The motion is the library's after some steps, to the last digit.
   subroutine check_digits(error, twin, motion, n)
      type(error_type), allocatable, intent(inout) :: error
      type(twin_t), intent(in) :: twin
      type(motion_t), intent(in) :: motion
      integer, intent(in) :: n
      type(state_t) :: state
      type(row_keeper_t) :: keeper
      type(status_t) :: status
      call run_library(twin, motion%dt, n, n, state, keeper, status)
      call check(error, status%ok() .and. motion%info == 0, trim(status%message))
      call check_close(error, [motion%t, motion%q, motion%p], [state%t, state%q, state%p], 0.0_wp)
   end subroutine check_digits

   !> One of the bodies fails in between, another one changes its step for a step.
   subroutine alike_bodies_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(motion_t) :: motions(4), failing
      type(twin_t) :: twins(3)
      integer :: form, i, k
      twins(1) = top_twin(1, 2)
      twins(2) = top_twin(2, 2)
      twins(3) = forced_twin(1, 4)
      do form = 1, size(twins)
         do k = 1, size(motions)
            call begin(twins(form), merge(1e-3_wp, 2.5e-4_wp, form == 3)*(8 + k), motions(k))
         end do
         call begin(twins(form), 1e3_wp, failing)
         do i = 1, n_steps
            do k = 1, size(motions)
               call step(motions(k), 1)
            end do
            if (mod(i, 5) == 0 .and. form < 3) then
               call step(failing, 1)
               call check(error, failing%info > 0, 'a step of 1000 s was taken')
            end if
         end do
         do k = 1, size(motions)
            call check_digits(error, twins(form), motions(k), n_steps)
         end do
      end do
   end subroutine alike_bodies_are_alone

   subroutine work_put_back_repeats(error)
      type(error_type), allocatable, intent(out) :: error
      type(motion_t) :: motion, kept, moved
      integer :: i, repetition
      call begin(forced_twin(1, 2), 0.01_wp, motion)
      do i = 1, 10
         call step(motion, 1)
      end do
      kept = motion
      do repetition = 1, 2
         motion = kept
         do i = 11, n_steps
            call step(motion, 1)
         end do
         call check_digits(error, forced_twin(1, 2), motion, n_steps)
      end do
      moved = kept
      call step(moved, n_steps - 10)
      call check_digits(error, forced_twin(1, 2), moved, n_steps)
   end subroutine work_put_back_repeats

   !> Boxes of 200 masses, one step each in turn, against the steps of each in one call.
   subroutine many_bodies_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n_bodies = 200, n = 7
      type(motion_t), allocatable :: motions(:)
      type(motion_t) :: alone
      integer :: i, k
      allocate (motions(n_bodies))
      do k = 1, n_bodies
         call begin(heavier_box(k), 0.01_wp, motions(k))
      end do
      do i = 1, n
         do k = 1, n_bodies
            call step(motions(k), 1)
         end do
      end do
      do k = 1, n_bodies
         call begin(heavier_box(k), 0.01_wp, alone)
         call step(alone, n)
         call check_alike(error, motions(k), alone)
      end do
   end subroutine many_bodies_are_alone

   !> Two motions are the same, to the last digit.
   subroutine check_alike(error, motion, other)
      type(error_type), allocatable, intent(inout) :: error
      type(motion_t), intent(in) :: motion, other
      call check(error, motion%info == 0 .and. other%info == 0, 'a step failed')
      call check_close(error, [motion%q, motion%p], [other%q, other%p], 0.0_wp)
   end subroutine check_alike

   !> A box whose moments are 1 + k/7 times as large.
   type(twin_t) function heavier_box(k) result(twin)
      integer, intent(in) :: k
      twin = twin_of(box(), 1, 2)
      twin%aj = (1 + k/7.0_wp)*twin%aj
   end function heavier_box

   !> Two boxes whose WORKs are given the same hash, WORK(5), as two of some 1e5 set-ups have by chance.
   subroutine equal_hashes_are_told_apart(error)
      type(error_type), allocatable, intent(out) :: error
      type(motion_t) :: motions(2)
      type(motion_t) :: alone
      integer :: i, k
      do k = 1, size(motions)
         call begin(heavier_box(k), 0.01_wp, motions(k))
         motions(k)%work(5) = 1234567.0_wp
      end do
      do i = 1, n_steps
         do k = 1, size(motions)
            call step(motions(k), 1)
         end do
      end do
      do k = 1, size(motions)
         call begin(heavier_box(k), 0.01_wp, alone)
         call step(alone, n_steps)
         call check_alike(error, motions(k), alone)
      end do
   end subroutine equal_hashes_are_told_apart

   subroutine busy_body_is_not_shared(error)
      type(error_type), allocatable, intent(out) :: error
      type(f77_body_t), pointer :: first, second, third
      type(motion_t) :: motion
      real(wp) :: omega(3)
      integer :: info
      call begin(top_twin(1, 2), 2e-3_wp, motion)
      first => find_body(motion%work)
      second => find_body(motion%work)
      call check(error, .not. associated(first, second), 'two calls work with one body')
      call nuomeg(motion%q, motion%p, omega, motion%work, most, info)
      call check(error, info, 0)
      call let_go(second)
      call let_go(first)
      third => find_body(motion%work)
      call check(error, associated(first, third), 'the body is not kept')
      call let_go(third)
   end subroutine busy_body_is_not_shared

   subroutine threads_step_alike_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      type(job_t), target :: job
      integer :: k
      do k = 1, n_threads
         call begin(forced_twin(1, 2), 0.008_wp + 0.001_wp*k, job%motions(k))
      end do
      call check(error, int(run_threads(c_funloc(step_in_thread), c_loc(job), int(n_threads, c_int))), 0)
      do k = 1, n_threads
         call check_digits(error, forced_twin(1, 2), job%motions(k), n_steps)
      end do
   end subroutine threads_step_alike_bodies

   !> The motion of one thread.
   subroutine step_in_thread(context, thread, threads) bind(c)
      type(c_ptr), intent(in), value :: context
      integer(c_int), intent(in), value :: thread, threads
      type(job_t), pointer :: job
      integer :: i
      call c_f_pointer(context, job)
      do i = 1, n_steps*(n_threads/threads)
         call step(job%motions(thread + 1), 1)
      end do
   end subroutine step_in_thread

   !> Checks the numbers before and after steps, with every method that can be archived.
   subroutine numbers_are_those_archived(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t), parameter :: settings(*) = [ &
                                                integrator_settings_t(formulation='reduced', order=2), &
                                                integrator_settings_t(formulation='full', order=2), &
                                                integrator_settings_t(formulation='reduced', order=4), &
                                                integrator_settings_t(formulation='full', order=6), &
                                                integrator_settings_t(method='rk8', conserve=.true.)]
      class(stepper_t), allocatable :: stepper, twin
      type(number_archive_t) :: archive
      type(problem_t), pointer :: problem
      type(state_t) :: state, other
      type(status_t) :: status
      real(wp) :: numbers(4000), archived(4000)
      integer :: i, k, used, read
      problem => forced_body()
      do i = 1, size(settings)
         call make_stepper(problem%system, settings(i), stepper, status)
         state = problem%start
         do k = 1, 9
            call stepper%step(problem%system, state, 0.01_wp, status)
         end do
         call check(error, status%ok(), trim(status%message))
         used = 1
         numbers = 0.0_wp
         call stepper%put_memory(size(numbers), numbers, used)
         archived = 0.0_wp
         call archive%begin_writing(archived(2:))
         call stepper%transfer(archive)
         call check(error, used, 1 + archive%count())
         call check_close(error, numbers, archived, 0.0_wp, 'other numbers')
         call make_stepper(problem%system, settings(i), twin, status)
         read = 1
         call twin%take_memory(size(numbers), numbers, read)
         call check(error, read, used)
         other = state
         do k = 1, 5
            call stepper%step(problem%system, state, 0.01_wp, status)
            call twin%step(problem%system, other, 0.01_wp, status)
         end do
         call check_close(error, [other%q, other%p], [state%q, state%p], 0.0_wp, 'the twin goes another way')
      end do
   end subroutine numbers_are_those_archived

end submodule test_f77_prepared
