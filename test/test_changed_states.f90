!> States that were changed between two steps of a stepper in use. Every method rejects an invalid state, changes
!> nothing, and goes on with a valid one; a clock that was set is no other motion.
submodule(suites_of_runs) test_changed_states
   use, intrinsic :: ieee_arithmetic, only: ieee_get_halting_mode, ieee_positive_inf, ieee_quiet_nan, &
      ieee_set_halting_mode, ieee_usual, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, method_t, methods, stepper_t
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: box, fast_top, make_state, march, problem_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   !> The ways to break a state, each of which is no rotating body's.
   character(len=16), parameter :: breakages(10) = [character(len=16) :: 'q NaN', 'q infinite', 'q zero', 'q huge', &
                                                   'p NaN', 'p infinite', 'p huge', 't NaN', 'step NaN', &
                                                   'step infinite']

contains

   module procedure collect_changed_states
      testsuite = [ &
                  new_unittest("what is no state is refused in mid-run by every method", broken_states_are_refused), &
                  new_unittest("a start off the unit sphere is rejected by every method", long_quaternions), &
                  new_unittest("a clock set in mid-run changes no method's motion", set_clock_changes_nothing)]
   end procedure collect_changed_states

   subroutine broken_states_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      logical :: halting(size(ieee_usual))
      integer :: i, k
      ! Comparing with NaN is an invalid operation; a program that traps it is stopped where it made the NaN.
      call ieee_get_halting_mode(ieee_usual, halting)
      call ieee_set_halting_mode(ieee_usual, .false.)
      do i = 1, size(methods)
         do k = 1, size(breakages)
            call check_method(error, methods(i), breakages(k))
         end do
      end do
      call ieee_set_halting_mode(ieee_usual, halting)
   end subroutine broken_states_are_refused

   !> C, FORTRAN 77 and scenes reject the same attitudes.
   subroutine long_quaternions(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: states(3)
      class(run_t), allocatable :: run
      type(status_t) :: status
      logical :: halting(size(ieee_usual))
      integer :: i, k
      allocate (run)
      ! The momentum of such a state is one that overflows.
      call ieee_get_halting_mode(ieee_usual, halting)
      call ieee_set_halting_mode(ieee_usual, .false.)
      do i = 1, size(methods)
         problem => problem_for(methods(i))
         states = problem%start
         states(1) = make_state(problem%system, 2*problem%start%q, [0.1_wp, 0.2_wp, 3.0_wp])
         states(2) = make_state(problem%system, 1.001_wp*problem%start%q, [0.1_wp, 0.2_wp, 3.0_wp])
         states(3)%q = (1 + 2e-6_wp)*states(3)%q
         call prepare(problem, methods(i), stepper, status)
         do k = 1, size(states)
            call run%begin(problem%system, integrator_settings_t(method=methods(i)%name, order=methods(i)%order, &
                                                                 formulation=methods(i)%formulation), states(k), &
                           run_plan_t(time_step=1e-3_wp, end_time=1.0_wp), status)
            call check(error, index(status%message, 'the norm of quaternion is') == 1, trim(methods(i)%name)//': '// &
                       trim(status%message))
            if (k == 3) cycle
            call stepper%step(problem%system, states(k), 1e-3_wp, status)
            call check(error, .not. status%ok(), trim(methods(i)%name)//' performs a step')
         end do
         deallocate (stepper)
      end do
      call ieee_set_halting_mode(ieee_usual, halting)
   end subroutine long_quaternions

   subroutine set_clock_changes_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(methods)
         call check_clock(error, methods(i))
      end do
   end subroutine set_clock_changes_nothing

   subroutine check_clock(error, method)
      type(error_type), allocatable, intent(inout) :: error
      type(method_t), intent(in) :: method
      real(wp), parameter :: dt = 1e-3_wp
      class(stepper_t), allocatable :: stepper, other
      type(problem_t), pointer :: problem
      type(state_t) :: state, later
      type(status_t) :: status
      problem => problem_for(method)
      call prepare(problem, method, stepper, status)
      call prepare(problem, method, other, status)
      state = problem%start
      call march(problem%system, stepper, state, dt, 3, status)
      later = problem%start
      call march(problem%system, other, later, dt, 3, status)
      later%t = later%t + 5
      call march(problem%system, stepper, state, dt, 3, status)
      call march(problem%system, other, later, dt, 3, status)
      call check(error, status%ok(), trim(method%name)//': '//status%message)
      call check_close(error, [later%t - 5, later%q], [state%t, state%q], 64*eps, trim(method%name))
   end subroutine check_clock

   !> A problem that a method can solve.
   function problem_for(method) result(problem)
      type(method_t), intent(in) :: method
      type(problem_t), pointer :: problem
      problem => fast_top()
      if (method%name == 'exact') problem => box()
   end function problem_for

   subroutine prepare(problem, method, stepper, status)
      type(problem_t), intent(in) :: problem
      type(method_t), intent(in) :: method
      class(stepper_t), allocatable, intent(out) :: stepper
      type(status_t), intent(out) :: status
      call make_stepper(problem%system, integrator_settings_t(method=method%name, order=method%order, &
                                                              formulation=method%formulation, &
                                                              conserve=method%projected), stepper, status)
   end subroutine prepare

   subroutine check_method(error, method, breakage)
      type(error_type), allocatable, intent(inout) :: error
      type(method_t), intent(in) :: method
      character(len=*), intent(in) :: breakage
      real(wp), parameter :: dt = 1e-3_wp
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: sound, broken, before
      real(wp) :: broken_step
      type(status_t) :: status
      character(len=:), allocatable :: label
      label = breakage//' for '//trim(method%name)//' ('//trim(method%equations)//')'
      problem => problem_for(method)
      call prepare(problem, method, stepper, status)
      call check(error, status%ok(), label//': '//status%message)
      if (allocated(error)) return
      sound = problem%start
      call march(problem%system, stepper, sound, dt, 3, status)
      broken = broken_state(sound, breakage)
      before = broken
      broken_step = dt
      if (breakage == 'step NaN') broken_step = ieee_value(dt, ieee_quiet_nan)
      if (breakage == 'step infinite') broken_step = ieee_value(dt, ieee_positive_inf)
      call stepper%step(problem%system, broken, broken_step, status)
      call check(error, .not. status%ok() .and. status%message /= '', label//' was not refused')
      call check(error, all(bits_of(broken) == bits_of(before)), label//': the state was touched')
      call march(problem%system, stepper, sound, dt, 3, status)
      call check(error, status%ok(), label//', then a sound state: '//status%message)
   end subroutine check_method

   !> The state with one value that no state has.
   type(state_t) function broken_state(state, breakage) result(broken)
      type(state_t), intent(in) :: state
      character(len=*), intent(in) :: breakage
      real(wp) :: nan, infinity
      nan = ieee_value(nan, ieee_quiet_nan)
      infinity = ieee_value(infinity, ieee_positive_inf)
      broken = state
      select case (breakage)
      case ('q NaN')
         broken%q(2) = nan
      case ('q infinite')
         broken%q(1) = infinity
      case ('q zero')
         broken%q = 0.0_wp
      case ('q huge')
         broken%q = 1e200_wp*broken%q
      case ('p NaN')
         broken%p(4) = nan
      case ('p infinite')
         broken%p(3) = -infinity
      case ('p huge')
         broken%p = 1e200_wp*broken%p
      case ('t NaN')
         broken%t = nan
      case default
         ! The length of the step is what is broken.
      end select
   end function broken_state

   pure function bits_of(state) result(bits)
      type(state_t), intent(in) :: state
      integer(int64) :: bits(17)
      bits = transfer([state%t, state%q, state%p, state%q_compensation, state%p_compensation], bits)
   end function bits_of

end submodule test_changed_states
