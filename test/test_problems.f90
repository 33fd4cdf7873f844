!> The problems that several suites integrate, with their published data, and a loop of steps.
module test_problems
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body, make_shape_body
   use nutate_damping, only: damping_t
   use nutate_effect, only: rotor_t
   use nutate_gravity, only: gravity_t
   use nutate_hamiltonian, only: make_state
   use nutate_kinds, only: wp, pi
   use nutate_methods, only: make_stepper
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   implicit none
   private

   public :: problem_t, box, precessing_top, fast_top, bruls_top, simo_top, free_body, forced_body, march, &
      solve, wheeled_body

   !> A system with the state it starts from.
   type :: problem_t
      type(system_t) :: system
      type(state_t) :: start
   contains
      final :: end_problem
   end type problem_t

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   !> Does nothing, and lets gfortran free the components in one place, not wherever such a variable ends.
   impure elemental subroutine end_problem(self)
      type(problem_t), intent(inout) :: self
   end subroutine end_problem

   !> The paper's box: edges 4, 1, 2 m, 12 kg, spinning about its intermediate axis 3.
   type(problem_t) function box() result(problem)
      type(status_t) :: status
      call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], problem%system%body, status, mass=12.0_wp)
      problem%start = make_state(problem%system, identity, [0.1_wp, 0.0_wp, 10.0_wp])
   end function box

   !> The cone on its tip that the tops of the paper's reference [3] are.
   type(problem_t) function cone_top(omega) result(problem)
      real(wp), intent(in) :: omega(3)
      type(status_t) :: status
      call make_shape_body('cone', [0.05_wp, 0.1_wp], problem%system%body, status, density=2700.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, [cos(pi/6), sin(pi/6), 0.0_wp, 0.0_wp], omega)
   end function cone_top

   !> θ = π/3, precession 10 rad/s, spin 135.6 rad/s: steady.
   type(problem_t) function precessing_top() result(problem)
      problem = cone_top([0.0_wp, 10*sin(pi/3), 140.6_wp])
   end function precessing_top

   !> θ = π/3, pure spin 200 rad/s: nutates.
   type(problem_t) function fast_top() result(problem)
      problem = cone_top([0.0_wp, 0.0_wp, 200.0_wp])
   end function fast_top

   !> Heavy top of Brüls, Cardona and Arnold.
   type(problem_t) function bruls_top() result(problem)
      type(status_t) :: status
      call make_body(diagonal([0.234375_wp, 0.46875_wp, 0.234375_wp]), problem%system%body, status, mass=15.0_wp, &
                     center_of_mass=[0.0_wp, 1.0_wp, 0.0_wp], about_center_of_mass=.true.)
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, identity, [0.0_wp, 150.0_wp, -4.61538_wp])
   end function bruls_top

   !> Heavy top of Simo and Wong.
   type(problem_t) function simo_top() result(problem)
      type(status_t) :: status
      call make_body(diagonal([5.0_wp, 5.0_wp, 1.0_wp]), problem%system%body, status, mass=20.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -1.0_wp]))
      problem%start = make_state(problem%system, [cos(0.025_wp), sin(0.025_wp), 0.0_wp, 0.0_wp], &
                                 [0.0_wp, 0.0_wp, 50.0_wp])
   end function simo_top

   !> A free body of given moments (triangle rule not tested) and body angular momentum.
   type(problem_t) function free_body(moments, momentum) result(problem)
      real(wp), intent(in) :: moments(3), momentum(3)
      type(status_t) :: status
      call make_body(diagonal(moments), problem%system%body, status, check_triangle=.false.)
      problem%start = make_state(problem%system, identity, momentum/moments)
   end function free_body

   !> A full tensor under potentials, torques and a rotor.
   type(problem_t) function forced_body() result(problem)
      type(status_t) :: status
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     problem%system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
      associate (effects => problem%system%effects)
         call effects%add(gravity_t(problem%system%body, [1.0_wp, -2.0_wp, -9.0_wp]))
         call effects%add(spring_t([0.5_wp, 0.0_wp, 0.5_wp], [2.0_wp, 1.0_wp, 0.0_wp], 3.0_wp, 0.5_wp))
         call effects%add(damping_t([0.1_wp, 0.2_wp, 0.3_wp]))
         call effects%add(applied_torque_t(name='torque', amplitude=[0.5_wp, 1.0_wp, -1.0_wp], in_space=.true., &
                                           frequency=0.4_wp))
         call effects%add(rotor_t(name='rotor', momentum=[1.0_wp, 2.0_wp, -1.0_wp]))
      end associate
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -2.0_wp, 3.0_wp])
   end function forced_body

   !> Returns the forced body with two wheels: one that a motor drives from 0.103 to 0.257 s, and one that friction
   !> stops.
   type(problem_t) function wheeled_body() result(problem)
      type(wheel_t) :: wheel
      type(status_t) :: status
      problem = forced_body()
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp, speed=5.0_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp], frequency=0.8_wp, &
                                                     start=0.103_wp, stop=0.257_wp))
      call add_wheel(problem%system, wheel, status)
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, &
                                             speed=-20.0_wp, friction=0.15_wp), status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -2.0_wp, 3.0_wp])
   end function wheeled_body

   !> Performs `n` steps; on failure `status` says why and `state` is the last one reached.
   subroutine march(system, stepper, state, dt, n, status)
      type(system_t), intent(in) :: system
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      type(status_t), intent(out) :: status
      integer :: i
      do i = 1, n
         call stepper%step(system, state, dt, status)
         if (.not. status%ok()) return
      end do
   end subroutine march

   !> The state of a problem after `n` steps of the conserving scheme.
   subroutine solve(problem, dt, n, state, status, inverse_j0)
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      type(state_t), intent(out) :: state
      type(status_t), intent(out) :: status
      real(wp), intent(in), optional :: inverse_j0
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      if (present(inverse_j0)) settings%inverse_auxiliary_inertia = inverse_j0
      state = problem%start
      call make_stepper(problem%system, settings, stepper, status)
      if (status%ok()) call march(problem%system, stepper, state, dt, n, status)
   end subroutine solve

end module test_problems
