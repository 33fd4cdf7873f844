!> Space axes that turn: what the step keeps in them, that it is the motion seen from inertial axes, and its equations.
submodule(suites_of_runs) test_rotating_frame
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_variation, only: variation_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: torque_t
   use nutate_eight_equations, only: eight_equations_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_quaternion, only: attitude_distance, quat_exp, quat_product, rotate_to_body, rotate_to_space
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: angular_velocity, box, conserved_energy, forced_body, frame_rate_of, kinetic_energy, &
      make_state, march, new_problem, problem_t, space_momentum, system_t
   use test_reference_forms, only: hamilton_equations
   use test_resume, only: settings_of
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

   !> A rate that lies along nothing else, rad/s.
   real(wp), parameter :: inclined(3) = [0.4_wp, -0.7_wp, 0.5_wp]
   character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']

   !> A torque against the absolute rate, -cΩ.
   type, extends(torque_t) :: absolute_drag_t
      !> N m s.
      real(wp) :: c = 0.7_wp
   contains
      procedure :: torque => drag_torque
      procedure :: frame_change => drag_change
   end type absolute_drag_t

contains

   module procedure collect_rotating_frame
      testsuite = [ &
                  new_unittest("the Jacobi integral is kept at any step, with any J0", jacobi_at_any_step), &
                  new_unittest("the account closes with torques, potentials and rotors", account_closes), &
                  new_unittest("8 equations and 3 give the same motion", both_forms_agree), &
                  new_unittest("all methods follow the equations of motion", methods_follow_the_equations), &
                  new_unittest("a free body moves as seen from inertial axes", free_body_as_from_inertial_axes), &
                  new_unittest("a top about the axis of the frame, too", top_as_from_inertial_axes), &
                  new_unittest("orders 2, 4, 6, 8", orders), &
                  new_unittest("a step can be undone", step_can_be_undone), &
                  new_unittest("Jacobians against differences", jacobians_match_differences), &
                  new_unittest("explicit methods keep what the projection is to keep", projection_keeps), &
                  new_unittest("damping acts on the rate against the frame", damping_acts_on_relative_rate), &
                  new_unittest("a torque by the absolute rate is the same in all axes", absolute_drag_is_the_same), &
                  new_unittest("and has derivatives with respect to the rate of the frame", columns_of_absolute_drag), &
                  new_unittest("a frame of rate zero is none", frame_of_rate_zero_is_none)]
   end procedure collect_rotating_frame

   pure function drag_torque(self, t, q, omega) result(tau)
      class(absolute_drag_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -self%c*self%absolute_rate(q, omega)
   end function drag_torque

   pure function drag_change(self, change, t, q, omega) result(tau)
      class(absolute_drag_t), intent(in) :: self
      real(wp), intent(in) :: change(3), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -self%c*rotate_to_body(q, change)
   end function drag_change

   !> A free body with that torque, in inclined axes or in inertial ones.
   function dragged(turns) result(problem)
      logical, intent(in) :: turns
      type(problem_t), pointer :: problem
      problem => box()
      ! The torque comes first: the list then has to tell it the rate.
      call problem%system%effects%add(absolute_drag_t(name='drag'))
      if (turns) call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=inclined))
   end function dragged

   !> Ω in body axes is the same, and the attitude differs by the rotation of the axes.
   subroutine absolute_drag_is_the_same(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: still, rotating
      type(state_t) :: states(2)
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      integer :: m
      still => dragged(.false.)
      rotating => dragged(.true.)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. methods(m)%name == 'taylor' .or. methods(m)%order < 4) cycle
         settings = settings_of(methods(m))
         states = [still%start, rotating%start]
         call integrate(still%system, settings, states(1), run_plan_t(time_step=1e-3_wp, end_time=1.0_wp), status)
         call check(error, status%ok(), trim(status%message))
         call integrate(rotating%system, settings, states(2), run_plan_t(time_step=1e-3_wp, end_time=1.0_wp), status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, angular_velocity(rotating%system, states(2)), &
                          angular_velocity(still%system, states(1)), 1e-7_wp, methods(m)%name)
         call check_below(error, attitude_distance(quat_product(quat_exp(0.5_wp*inclined), states(2)%q), states(1)%q), &
                          1e-7_wp, methods(m)%name)
      end do
   end subroutine absolute_drag_is_the_same

   !> δΩ by the rate of the frame, against differences of runs; damping is added, which depends on the relative rate.
   subroutine columns_of_absolute_drag(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-3_wp
      integer, parameter :: places(4) = [-2, -1, 1, 2], weights(4) = [1, -8, 8, -1]
      type(run_plan_t), parameter :: plan = run_plan_t(time_step=0.01_wp, end_time=1.0_wp)
      type(problem_t), pointer :: problem
      type(problem_t) :: moved
      type(variation_t) :: column
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      class(run_t), allocatable :: run
      real(wp) :: rates(1, 3), differences(3)
      integer :: m, i
      column%name = 'rotating_frame.rate'
      column%frame = [0.3_wp, 0.5_wp, -0.2_wp]
      problem => dragged(.true.)
      call problem%system%effects%add(damping_t([0.3_wp, 0.2_wp, 0.4_wp]))
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. methods(m)%name == 'taylor') cycle
         settings = settings_of(methods(m))
         ! Columns are those of the steps without the projection.
         settings%conserve = .false.
         allocate (run)
         call run%begin(problem%system, settings, problem%start, plan, status)
         if (status%ok()) call run%differentiate([column], problem%system, status)
         if (status%ok()) call run%run_to_end(problem%system, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         rates = run%tangent%rates(problem%system, run%state)
         differences = 0.0_wp
         do i = 1, 4
            moved = problem
            call moved%system%effects%turn_frame((places(i)*h)*column%frame)
            state = problem%start
            call integrate(moved%system, settings, state, plan, status)
            differences = differences + weights(i)*angular_velocity(moved%system, state)/(12*h)
         end do
         call check_close(error, rates(1, :), differences, 1e-9_wp, methods(m)%name)
         call check(error, norm2(rates) > 1e-3_wp, methods(m)%name)
         deallocate (run)
      end do
   end subroutine columns_of_absolute_drag

   !> A body of the tests' own with potentials of all kinds but no torque, in inclined axes.
   function potentials_only(rate) result(problem)
      real(wp), intent(in) :: rate(3)
      type(problem_t), pointer :: problem
      type(problem_t), pointer :: whole
      problem => new_problem()
      whole => forced_body()
      problem%system%body = whole%system%body
      associate (effects => problem%system%effects, body => problem%system%body)
         call effects%add(whole%system%effects%potentials(1)%item)
         call effects%add(whole%system%effects%potentials(2)%item)
         call effects%add(gravity_gradient_t(body, [1.0_wp, 2.0_wp, -1.0_wp], 0.4_wp))
         call effects%add(rotor_t(name='rotor', momentum=[1.0_wp, 2.0_wp, -1.0_wp]))
         call effects%add(rotating_frame_t(name='rotating_frame', rate=rate))
      end associate
      problem%start = make_state(problem%system, whole%start%q, [1.0_wp, -2.0_wp, 3.0_wp])
   end function potentials_only

   subroutine jacobi_at_any_step(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(3) = [0.01_wp, 0.1_wp, 0.25_wp], inverse_j0(3) = [0.0_wp, 0.1_wp, 0.01_wp]
      integer, parameter :: n_steps = 400
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      integer :: i, j, form
      problem => potentials_only(inclined)
      energy = conserved_energy(problem%system, problem%start)
      do form = 1, 2
         do j = 1, size(inverse_j0)
            if (form == 2 .and. j > 1) exit
            do i = 1, size(steps)
               settings%formulation = solvers(form)
               settings%inverse_auxiliary_inertia = inverse_j0(j)
               settings%order = merge(2, 4, i > 1)
               call make_stepper(problem%system, settings, stepper, status)
               state = problem%start
               if (status%ok()) call march(problem%system, stepper, state, steps(i), n_steps, status)
               call check(error, status%ok(), trim(status%message))
               call check_close(error, conserved_energy(problem%system, state), energy, 100*eps*abs(energy) + &
                                100*eps*kinetic_energy(problem%system, state), "H - omega.l")
               call check_close(error, dot_product(state%q, state%q), 1.0_wp, 20*eps, "norm")
               call check_close(error, dot_product(state%q, state%p), 0.0_wp, 4*eps*norm2(state%p), "q.p")
            end do
         end do
      end do
   end subroutine jacobi_at_any_step

   subroutine account_closes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy, work
      integer :: i, form, order
      problem => forced_body()
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=inclined))
      energy = conserved_energy(problem%system, problem%start)
      do form = 1, 2
         do order = 2, 8, 2
            settings%formulation = solvers(form)
            settings%order = order
            call make_stepper(problem%system, settings, stepper, status)
            state = problem%start
            work = 0.0_wp
            do i = 1, 200
               call stepper%step(problem%system, state, 0.05_wp, status)
               call check(error, status%ok(), trim(status%message))
               work = work + sum(stepper%work)
            end do
            call check_close(error, conserved_energy(problem%system, state) - work, energy, 200*eps*100, "account")
         end do
      end do
   end subroutine account_closes

   subroutine both_forms_agree(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: full, reduced
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: k
      do k = 1, 3
         problem => box()
         if (k == 2) problem => potentials_only([0.0_wp, 0.0_wp, 0.0_wp])
         if (k == 3) problem => forced_body()
         call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=inclined))
         call make_stepper(problem%system, integrator_settings_t(formulation='full'), full, status)
         call make_stepper(problem%system, integrator_settings_t(formulation='reduced'), reduced, status)
         a = problem%start
         b = problem%start
         call march(problem%system, full, a, 0.02_wp, 300, status)
         if (status%ok()) call march(problem%system, reduced, b, 0.02_wp, 300, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, b%q, a%q, merge(1e-9_wp, 1e-12_wp, k == 1), "q")
         call check_close(error, b%p, a%p, merge(1e-9_wp, 1e-12_wp, k == 1)*norm2(a%p), "p")
         call check_close(error, reduced%work, full%work, 1e-12_wp*kinetic_energy(problem%system, a), "work")
      end do
   end subroutine both_forms_agree

   !> Every method against Hamilton's equations in these axes, integrated here by Runge and Kutta's formula.
   subroutine methods_follow_the_equations(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: expected, state
      type(status_t) :: status
      integer :: row, i
      problem => forced_body()
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=inclined))
      expected = problem%start
      do i = 1, 2000
         call runge_kutta(0.0005_wp)
      end do
      do row = 1, size(methods)
         if (methods(row)%order < 6 .and. methods(row)%name /= 'taylor' .and. methods(row)%name /= 'rk4') cycle
         if (methods(row)%name == 'exact') cycle
         state = problem%start
         call integrate(problem%system, integrator_settings_t(method=methods(row)%name, order=methods(row)%order, &
                                                              formulation=methods(row)%formulation, &
                                                              conserve=methods(row)%projected), state, &
                        run_plan_t(time_step=merge(0.001_wp, 0.01_wp, methods(row)%order == 4), &
                                   end_time=1.0_wp), status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, expected%q), 2e-11_wp, trim(methods(row)%name))
         call check_close(error, state%p, expected%p, 2e-11_wp*norm2(expected%p), trim(methods(row)%name))
      end do

   contains

      subroutine runge_kutta(h)
         real(wp), intent(in) :: h
         real(wp) :: q_rate(4, 4), p_rate(4, 4)
         real(wp), parameter :: parts(4) = [0.0_wp, 0.5_wp, 0.5_wp, 1.0_wp]
         type(state_t) :: stage
         integer :: k
         do k = 1, 4
            stage = expected
            stage%t = expected%t + parts(k)*h
            if (k > 1) stage%q = expected%q + parts(k)*h*q_rate(:, k - 1)
            if (k > 1) stage%p = expected%p + parts(k)*h*p_rate(:, k - 1)
            call hamilton_equations(problem%system, stage, q_rate(:, k), p_rate(:, k))
         end do
         expected%q = expected%q + h/6*(q_rate(:, 1) + 2*q_rate(:, 2) + 2*q_rate(:, 3) + q_rate(:, 4))
         expected%p = expected%p + h/6*(p_rate(:, 1) + 2*p_rate(:, 2) + 2*p_rate(:, 3) + p_rate(:, 4))
         expected%t = expected%t + h
      end subroutine runge_kutta

   end subroutine methods_follow_the_equations

   subroutine free_body_as_from_inertial_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: row
      do row = 1, size(methods)
         if (methods(row)%order < 8 .or. methods(row)%name == 'exact') cycle
         problem => box()
         problem%start = make_state(problem%system, problem%start%q, [3.0_wp, 1.0_wp, 0.5_wp])
         call compare_with_inertial_axes(error, problem, inclined, methods(row)%name, methods(row)%formulation, &
                                         methods(row)%projected)
      end do
   end subroutine free_body_as_from_inertial_axes

   !> Gravity along the axis of the frame is the same in it.
   subroutine top_as_from_inertial_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      integer :: row, k
      problem => new_problem()
      do row = 1, size(methods)
         if (methods(row)%order < 8 .or. methods(row)%name == 'exact') cycle
         do k = 1, 2
            call make_body(diagonal([2.0_wp, merge(2.0_wp, 3.0_wp, k == 1), 1.5_wp]), problem%system%body, status, &
                           mass=1.0_wp, center_of_mass=[0.0_wp, 0.0_wp, 0.7_wp])
            if (allocated(problem%system%effects%potentials)) deallocate (problem%system%effects%potentials)
            problem%system%effects%n_potentials = 0
            call problem%system%effects%add(gravity_t(problem%system%body, -9.0_wp*inclined))
            problem%start = make_state(problem%system, quat_exp([0.3_wp, 0.1_wp, -0.2_wp]), [1.0_wp, 0.5_wp, 4.0_wp])
            call compare_with_inertial_axes(error, problem, inclined, methods(row)%name, methods(row)%formulation, &
                                            methods(row)%projected)
         end do
      end do
   end subroutine top_as_from_inertial_axes

   !> A problem run in inertial axes, and in axes that turn at a rate and coincide with them at the start.
   subroutine compare_with_inertial_axes(error, problem, rate, method, formulation, conserve)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: rate(3)
      character(len=*), intent(in) :: method, formulation
      logical, intent(in) :: conserve
      real(wp), parameter :: time = 3.0_wp
      type(integrator_settings_t) :: settings
      type(system_t) :: rotating
      type(state_t) :: inertial, seen
      type(status_t) :: status
      rotating = problem%system
      call rotating%effects%add(rotating_frame_t(name='rotating_frame', rate=rate))
      settings = integrator_settings_t(method=method, formulation=formulation, order=8, conserve=conserve)
      inertial = problem%start
      seen = problem%start
      call integrate(problem%system, settings, inertial, run_plan_t(time_step=0.005_wp, end_time=time), status)
      if (status%ok()) call integrate(rotating, settings, seen, run_plan_t(time_step=0.005_wp, end_time=time), status)
      call check(error, status%ok(), trim(status%message))
      associate (turn => quat_exp(-0.5_wp*time*rate))
         call check_below(error, attitude_distance(seen%q, quat_product(turn, inertial%q)), 1e-12_wp, method//": q")
         call check_close(error, space_momentum(seen), rotate_to_space(turn, space_momentum(inertial)), &
                          1e-12_wp*norm2(space_momentum(inertial)), method//": l")
      end associate
      call check_close(error, angular_velocity(rotating, seen), angular_velocity(problem%system, inertial), 1e-11_wp, &
                       method//": omega")
   end subroutine compare_with_inertial_axes

   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: exact, state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      real(wp) :: errors(2), dt
      integer :: form, order, k
      problem => potentials_only(inclined)
      exact = problem%start
      call integrate(problem%system, default_settings('taylor'), exact, &
                     run_plan_t(time_step=0.01_wp, end_time=2.0_wp), status)
      do form = 1, 2
         do order = 2, 8, 2
            settings%formulation = solvers(form)
            settings%order = order
            do k = 1, 2
               state = problem%start
               dt = merge(0.04_wp, merge(0.1_wp, 0.2_wp, order < 8), order == 2)/k
               if (status%ok()) call integrate(problem%system, settings, state, &
                                               run_plan_t(time_step=dt, end_time=2.0_wp), status)
               call check(error, status%ok(), trim(status%message))
               errors(k) = attitude_distance(state%q, exact%q)
            end do
            call check(error, log(errors(1)/errors(2))/log(2.0_wp) > order - 0.4_wp, "order")
         end do
      end do
   end subroutine orders

   subroutine step_can_be_undone(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: form
      problem => potentials_only(inclined)
      do form = 1, 2
         call make_stepper(problem%system, integrator_settings_t(formulation=solvers(form)), &
                           stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.1_wp, 20, status)
         if (status%ok()) call march(problem%system, stepper, state, -0.1_wp, 20, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, problem%start%q, 1e-12_wp, "q")
         call check_close(error, state%p, problem%start%p, 1e-12_wp*norm2(state%p), "p")
      end do
   end subroutine step_can_be_undone

   !> Central differences err by h² of third derivatives and ε/h, h = ε^(1/3).
   subroutine jacobians_match_differences(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(reduced_equations_t) :: three
      type(eight_equations_t) :: eight
      integer(int64) :: seed
      real(wp) :: z(8), shift(8), above(8), below(8), matrix(8, 8), h
      integer :: i
      problem => forced_body()
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=3*inclined))
      seed = 314159_int64
      problem%start = make_state(problem%system, random_unit_quaternion(seed), 2*random_vector(seed))
      call three%forces%prepare(problem%system%effects, .true.)
      call three%set_step(problem%system, 0.2_wp)
      call three%start(problem%system, problem%start)
      call eight%forces%prepare(problem%system%effects, .true.)
      call eight%set_momentum_unit(problem%system, 0.1_wp, 16.0_wp)
      call eight%start(problem%system, problem%start, 0.2_wp)
      z = 0.0_wp
      z(1:3) = 0.4_wp*random_vector(seed)
      h = eps**(1.0_wp/3)
      call three%jacobian(problem%system, z(1:3), matrix(1:3, 1:3))
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         call three%residual(problem%system, z(1:3) + shift(1:3), above(1:3))
         call three%residual(problem%system, z(1:3) - shift(1:3), below(1:3))
         call check_close(error, matrix(1:3, i), (above(1:3) - below(1:3))/(2*h), 5e-9_wp, "three")
      end do
      z = [0.1_wp*random_vector(seed), 0.2_wp*random_vector(seed), 0.1_wp, -0.2_wp]
      call eight%jacobian(problem%system, z, matrix)
      do i = 1, 8
         shift = 0.0_wp
         shift(i) = h
         call eight%residual(problem%system, z + shift, above)
         call eight%residual(problem%system, z - shift, below)
         call check_close(error, matrix(:, i), (above - below)/(2*h), 5e-9_wp, "eight")
      end do
   end subroutine jacobians_match_differences

   !> H - ω·l, and of l what is kept: all of a free body's, but for its rotating; the component along ω of a body whose
   !> potentials lie along it.
   subroutine projection_keeps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy, along, expected(3)
      integer :: row, k
      do row = 1, size(methods)
         if (.not. methods(row)%projected) cycle
         do k = 1, 3
            problem => potentials_only(inclined)
            if (k < 3) then
               deallocate (problem%system%effects%potentials)
               problem%system%effects%n_potentials = 0
               if (k == 2) call problem%system%effects%add(gravity_t(problem%system%body, 5*inclined))
               if (k == 2) call problem%system%effects%add(dipole_t([1.0_wp, 2.0_wp, 0.5_wp], -inclined))
            end if
            state = problem%start
            energy = conserved_energy(problem%system, state)
            call integrate(problem%system, default_or_projected(methods(row)%name), state, &
                           run_plan_t(time_step=0.02_wp, end_time=20.0_wp), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, conserved_energy(problem%system, state), energy, 64*eps*60, "H - omega.l")
            expected = space_momentum(problem%start)
            along = dot_product(expected, inclined)
            if (k == 3) cycle
            call check_close(error, dot_product(space_momentum(state), inclined), along, 64*eps*20, "omega.l")
            if (k > 1) cycle
            expected = rotate_to_body(quat_exp(0.5_wp*state%t*inclined), expected)
            call check_close(error, space_momentum(state), expected, 64*eps*norm2(expected), "l")
         end do
      end do

   contains

      type(integrator_settings_t) function default_or_projected(method) result(settings)
         character(len=*), intent(in) :: method
         settings = default_settings(method)
         settings%conserve = .true.
      end function default_or_projected

   end subroutine projection_keeps

   !> A body that turns with the frame about a principal axis is at rest in it, and damping leaves it so; one at rest in
   !> inertial axes is taken along.
   subroutine damping_acts_on_relative_rate(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp), parameter :: rate(3) = [0.0_wp, 0.0_wp, 0.8_wp], identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      integer :: row
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 2.0_wp, 2.5_wp]), problem%system%body, status)
      call problem%system%effects%add(damping_t([0.3_wp, 0.4_wp, 0.5_wp]))
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=rate))
      do row = 1, size(methods)
         if (methods(row)%name == 'exact') cycle
         associate (settings => integrator_settings_t(method=methods(row)%name, order=methods(row)%order, &
                                                      formulation=methods(row)%formulation, &
                                                      conserve=methods(row)%projected))
            state = make_state(problem%system, identity, rate)
            call integrate(problem%system, settings, state, run_plan_t(time_step=0.1_wp, end_time=10.0_wp), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, state%q, identity, 1e-13_wp, trim(methods(row)%name)//": rest")
            state = make_state(problem%system, identity, [0.0_wp, 0.0_wp, 0.0_wp])
            call integrate(problem%system, settings, state, run_plan_t(time_step=0.02_wp, end_time=5.0_wp), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, angular_velocity(problem%system, state), rate*(1 - exp(-0.5_wp*5.0_wp/2.5_wp)), &
                             merge(1e-4_wp, 1e-7_wp, methods(row)%order == 2), trim(methods(row)%name)//": taken along")
            call check_close(error, frame_rate_of(problem%system%effects, state%q), rate, 1e-12_wp, "axis")
         end associate
      end do
   end subroutine damping_acts_on_relative_rate

   !> Compares to the last bit.
   subroutine frame_of_rate_zero_is_none(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(system_t) :: other
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: row
      problem => forced_body()
      other = problem%system
      call other%effects%add(rotating_frame_t(name='rotating_frame'))
      do row = 1, size(methods)
         if (methods(row)%name == 'exact') cycle
         associate (settings => integrator_settings_t(method=methods(row)%name, order=methods(row)%order, &
                                                      formulation=methods(row)%formulation, &
                                                      conserve=methods(row)%projected))
            a = problem%start
            b = problem%start
            call integrate(problem%system, settings, a, run_plan_t(time_step=0.02_wp, end_time=1.0_wp), status)
            if (status%ok()) call integrate(other, settings, b, run_plan_t(time_step=0.02_wp, end_time=1.0_wp), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, [b%q, b%p], [a%q, a%p], 0.0_wp, trim(methods(row)%name))
         end associate
      end do
   end subroutine frame_of_rate_zero_is_none

end submodule test_rotating_frame
