!> The step in reduced form: the trajectory of the 8×8 system to round-off, its Jacobian, and what it refuses.
submodule(suites_of_runs) test_reduced
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_gravity, only: gravity_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_reduced, only: reduced_t
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_rotor, only: rotor_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: body_momentum, box, bruls_top, fast_top, forced_body, kinetic_energy, make_state, march, &
      new_system, precessing_top, problem_t, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

contains

   module procedure collect_reduced
      testsuite = [ &
                  new_unittest("box as by the 8x8 system", box_as_by_the_full_system), &
                  new_unittest("tops as by the 8x8 system", tops_as_by_the_full_system), &
                  new_unittest("every kind of effect as by the 8x8 system", effects_as_by_the_full_system), &
                  new_unittest("Jacobian against differences", jacobian_matches_differences), &
                  new_unittest("momentum does not drift", momentum_does_not_drift), &
                  new_unittest("energy of a forced top does not drift", energy_does_not_drift), &
                  new_unittest("a root that clearing denominators adds is refused", added_root_is_refused), &
                  new_unittest("momentum alone as with the attitude", momentum_alone_as_with_attitude), &
                  new_unittest("states off the constraints are refused", states_off_the_constraints_are_refused), &
                  new_unittest("projection cannot be left out", projection_cannot_be_left_out)]
   end procedure collect_reduced

   subroutine box_as_by_the_full_system(error)
      type(error_type), allocatable, intent(out) :: error
      ! The unstable motion amplifies round-off.
      call compare(error, box(), 0.01_wp, 1000, 1e-9_wp)
   end subroutine box_as_by_the_full_system

   subroutine tops_as_by_the_full_system(error)
      type(error_type), allocatable, intent(out) :: error
      call compare(error, precessing_top(), 0.001_wp, 1000, 1e-12_wp)
      call compare(error, fast_top(), 0.001_wp, 1000, 1e-12_wp)
      call compare(error, bruls_top(), 0.001_wp, 1000, 1e-12_wp)
   end subroutine tops_as_by_the_full_system

   subroutine effects_as_by_the_full_system(error)
      type(error_type), allocatable, intent(out) :: error
      call compare(error, forced_body(), 0.01_wp, 1000, 1e-12_wp)
   end subroutine effects_as_by_the_full_system

   !> q and p of both forms after n steps, and the work of the torques in the last one.
   subroutine compare(error, problem, dt, n, tolerance)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt, tolerance
      integer, intent(in) :: n
      type(nielsen_krenk_t) :: full
      type(reduced_t) :: reduced
      type(state_t) :: a, b
      type(status_t) :: status
      call full%prepare(problem%system, integrator_settings_t(), status)
      call reduced%prepare(problem%system, integrator_settings_t(), status)
      a = problem%start
      b = problem%start
      call march(problem%system, full, a, dt, n, status)
      call march(problem%system, reduced, b, dt, n, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, b%q, a%q, tolerance, "q")
      call check_close(error, b%p, a%p, tolerance*norm2(a%p), "p")
      call check_close(error, reduced%work, full%work, tolerance*kinetic_energy(problem%system, a), "work")
   end subroutine compare

   !> Central differences err by h² of third derivatives and ε/h, h = ε^(1/3).
   subroutine jacobian_matches_differences(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(reduced_equations_t) :: equations
      integer(int64) :: seed
      real(wp) :: b(3), shift(3), above(3), below(3), matrix(3, 3), h
      integer :: i
      problem => forced_body()
      seed = 314159_int64
      problem%start = make_state(problem%system, random_unit_quaternion(seed), 2*random_vector(seed))
      call equations%forces%prepare(problem%system%effects, .true.)
      call equations%set_step(problem%system, 0.2_wp)
      call equations%start(problem%system, problem%start)
      b = 0.4_wp*random_vector(seed)
      call equations%jacobian(problem%system, b, matrix)
      h = eps**(1.0_wp/3)
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         call equations%residual(problem%system, b + shift, above)
         call equations%residual(problem%system, b - shift, below)
         call check_close(error, matrix(:, i), (above - below)/(2*h), 2e-9_wp, "column")
      end do
   end subroutine jacobian_matches_differences

   !> The norm error that round-off leaves in q must not turn the momentum: 6e-16 a step would be 3e-11 here.
   subroutine momentum_does_not_drift(error)
      type(error_type), allocatable, intent(out) :: error
      call check_drift(error, box(), 0.01_wp)
   end subroutine momentum_does_not_drift

   !> An iteration that stops while its slowest direction still converges makes energy drift: 6e-16 a step would be
   !> 3e-11 here.
   subroutine energy_does_not_drift(error)
      type(error_type), allocatable, intent(out) :: error
      call check_drift(error, bruls_top(), 0.001_wp)
   end subroutine energy_does_not_drift

   !> 50 000 steps.
   subroutine check_drift(error, problem, dt)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      type(reduced_t) :: stepper
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      state = problem%start
      call invariants%start(problem%system, state)
      call march(problem%system, stepper, state, dt, 50000, status)
      call invariants%measure(problem%system, state)
      call check_below(error, invariants%energy_error(), 1e-13_wp, "energy")
      call check_below(error, invariants%momentum_error(), 1e-13_wp, "momentum")
      call check_below(error, invariants%norm_error, 1e-13_wp, "norm")
   end subroutine check_drift

   !> Under 1e6 g the iteration from these steps comes to b = (-1, 0, 0), where the equation loses its rank but the
   !> Jacobian's determinant stays positive; |b| may round to less than 1.
   subroutine added_root_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(reduced_t) :: stepper
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      integer :: k
      system => new_system()
      call make_body(diagonal([1.0_wp, 1.0_wp, 0.25_wp]), system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81e6_wp]))
      do k = 1, 40
         call stepper%prepare(system, integrator_settings_t(), status)
         state = make_state(system, [cos(0.5_wp), sin(0.5_wp), 0.0_wp, 0.0_wp], [1.0_wp, 0.0_wp, 3.0_wp])
         energy = total_energy(system, state)
         call stepper%step(system, state, k*2.5e-4_wp, status)
         call check_close(error, total_energy(system, state), energy, 1e-12_wp*energy, "energy")
      end do
   end subroutine added_root_is_refused

   subroutine momentum_alone_as_with_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(reduced_t) :: with, without
      type(state_t) :: a, b
      type(status_t) :: status
      problem => box()
      call problem%system%effects%add(damping_t([0.1_wp, 0.2_wp, 0.3_wp]))
      call problem%system%effects%add(rotor_t(name='rotor', momentum=[1.0_wp, 2.0_wp, -1.0_wp]))
      call with%prepare(problem%system, integrator_settings_t(), status)
      call without%prepare(problem%system, integrator_settings_t(attitude=.false.), status)
      a = problem%start
      b = problem%start
      call march(problem%system, with, a, 0.01_wp, 500, status)
      call march(problem%system, without, b, 0.01_wp, 500, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, body_momentum(b), body_momentum(a), 1e-11_wp*norm2(body_momentum(a)), "L")
      call check_close(error, b%q, problem%start%q, 0.0_wp, "attitude integrated all the same")
   end subroutine momentum_alone_as_with_attitude

   subroutine states_off_the_constraints_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(reduced_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      problem => box()
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      state = problem%start
      state%q = 1.001_wp*state%q
      call stepper%step(problem%system, state, 0.01_wp, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      state = problem%start
      state%p = state%p + state%q
      call stepper%step(problem%system, state, 0.01_wp, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine states_off_the_constraints_are_refused

   subroutine projection_cannot_be_left_out(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(reduced_t) :: stepper
      type(status_t) :: status
      problem => box()
      call stepper%prepare(problem%system, integrator_settings_t(projection=.false.), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine projection_cannot_be_left_out

end submodule test_reduced
