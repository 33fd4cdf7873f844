!> Results do not depend on how many threads call the library: bit for bit those of one. Steps, runs and trial runs; not
!> the reading of scenes, in which gfortran keeps the lengths of texts in static variables.
module test_threads
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_funloc, c_int, c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_hamiltonian, only: make_state, system_t
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_c_support, only: run_threads
   use test_support, only: check, error_type, in_turn, new_unittest, random_unit_quaternion, random_vector, &
      unittest_type
   implicit none
   private

   public :: collect_threads

   integer, parameter :: n_threads = 8, n_states = 64, n_steps = 40

   !> Data that the threads share: they read all but their own outcomes.
   type :: job_t
      class(system_t), allocatable :: system
      type(integrator_settings_t) :: settings
      !> Time step, s.
      real(wp) :: time_step = 0.0_wp
      type(state_t) :: states(n_states)
      integer :: codes(n_states) = -1
   end type job_t

   !> Data that threads with whole runs share, and their results.
   type :: run_job_t
      class(scene_t), allocatable :: scene
      type(state_t) :: ends(n_states)
      real(wp) :: works(n_states) = 0.0_wp
      integer :: codes(n_states) = -1
   end type run_job_t

   !> Keeps the work.
   type, extends(observer_t) :: work_watch_t
      real(wp) :: work = 0.0_wp
   contains
      procedure :: observe => keep_work
   end type work_watch_t

contains

   subroutine collect_threads(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("64 states from 8 threads step as from one", states_step_as_from_one), &
                  new_unittest("64 runs from 8 threads end as from one", runs_end_as_from_one)]
   end subroutine collect_threads

   !> Every method on a system that all threads share, with effects and without.
   subroutine states_step_as_from_one(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: names(2) = [character(len=11) :: 'all_effects', 'box']
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i, row
      allocate (scene)
      do i = 1, size(names)
         call read_scene('scenes/'//trim(names(i))//'.nml', scene, status, message)
         call check(error, status%ok(), message)
         do row = 1, size(methods)
            if (methods(row)%name == 'exact' .and. names(i) /= 'box') cycle
            if (.not. in_turn(row + i)) cycle
            call compare_steps(error, scene, row)
         end do
      end do
   end subroutine states_step_as_from_one

   !> Steps the same states from one thread and from several.
   subroutine compare_steps(error, scene, row)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(in) :: scene
      !> Row of the table of methods.
      integer, intent(in) :: row
      type(job_t), target :: serial, threaded
      integer(int64) :: seed
      integer :: i
      allocate (serial%system, source=scene%system)
      serial%time_step = 0.05_wp
      serial%settings%method = methods(row)%name
      serial%settings%formulation = methods(row)%formulation
      serial%settings%order = methods(row)%order
      seed = 2012
      do i = 1, n_states
         serial%states(i) = make_state(scene%system, random_unit_quaternion(seed), 3*random_vector(seed))
      end do
      threaded = serial
      call step_states(c_loc(serial), 0_c_int, 1_c_int)
      call check(error, run_threads(c_funloc(step_states), c_loc(threaded), int(n_threads, c_int)) == 0, &
                 "threads cannot be started")
      call check(error, all(serial%codes == 0), trim(methods(row)%name)//" fails")
      call check(error, all(threaded%codes == 0) .and. all(same_bits(serial%states, threaded%states)), &
                 trim(methods(row)%name)//" "//trim(methods(row)%formulation)//": threads change the result")
   end subroutine compare_steps

   !> The share of a thread: every so manieth state, each thread with a stepper of its own.
   subroutine step_states(context, thread, threads) bind(c)
      type(c_ptr), intent(in), value :: context
      integer(c_int), intent(in), value :: thread, threads
      type(job_t), pointer :: job
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      integer :: i, k
      call c_f_pointer(context, job)
      do i = 1 + thread, n_states, threads
         call make_stepper(job%system, job%settings, stepper, status)
         do k = 1, n_steps
            if (status%ok()) call stepper%step(job%system, job%states(i), job%time_step, status)
         end do
         job%codes(i) = status%code
      end do
   end subroutine step_states

   !> Fixed steps, and trial runs with controlled steps after them, from different starts.
   subroutine runs_end_as_from_one(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_job_t), target :: serial, threaded
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (serial%scene)
      call read_scene('scenes/all_effects.nml', serial%scene, status, message, &
                      [character(len=24) :: 'integrator.end_time=2.5', 'integrator.order=4'])
      call check(error, status%ok(), message)
      if (allocated(error)) return
      threaded = serial
      call make_runs(c_loc(serial), 0_c_int, 1_c_int)
      call check(error, run_threads(c_funloc(make_runs), c_loc(threaded), int(n_threads, c_int)) == 0, &
                 "threads cannot be started")
      call check(error, all(serial%codes == 0), "runs fail")
      call check(error, all(threaded%codes == 0), "runs fail in threads")
      call check(error, all(same_bits(serial%ends, threaded%ends)), "states differ")
      call check(error, all(abs(serial%works - threaded%works) <= 0.0_wp), "works differ")
   end subroutine runs_end_as_from_one

   !> The share of a thread: every so manieth run.
   subroutine make_runs(context, thread, threads) bind(c)
      type(c_ptr), intent(in), value :: context
      integer(c_int), intent(in), value :: thread, threads
      type(run_job_t), pointer :: job
      integer :: i
      call c_f_pointer(context, job)
      do i = 1 + thread, n_states, threads
         job%ends(i) = make_state(job%scene%system, job%scene%initial%q, 0.05_wp*[i, 2, 3])
         call make_run(job%scene, modulo(i, 4) == 0, job%ends(i), job%works(i), job%codes(i))
      end do
   end subroutine make_runs

   subroutine make_run(scene, controlled, state, work, code)
      type(scene_t), intent(in) :: scene
      logical, intent(in) :: controlled
      type(state_t), intent(inout) :: state
      real(wp), intent(inout) :: work
      integer, intent(inout) :: code
      type(work_watch_t) :: watch
      type(run_plan_t) :: plan
      type(status_t) :: status
      plan = scene%plan
      if (controlled) plan%goal%accuracy = 1e-4_wp
      call integrate(scene%system, scene%integrator, state, plan, status, watch)
      work = watch%work
      code = status%code
   end subroutine make_run

   subroutine keep_work(self, system, state, record, status)
      class(work_watch_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%work = record%work
   end subroutine keep_work

   !> True where two states are the same to the last bit, signs of zero and compensations included.
   elemental logical function same_bits(a, b)
      type(state_t), intent(in) :: a, b
      same_bits = all(transfer([a%q, a%p, a%q_compensation, a%p_compensation, a%t], [0_int64]) == &
                      transfer([b%q, b%p, b%q_compensation, b%p_compensation, b%t], [0_int64]))
   end function same_bits

end module test_threads
