!> Bodies of the procedures whose interfaces are in `test_problems`.
submodule(test_problems) test_problems_procedures
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body, make_shape_body
   use nutate_damping, only: damping_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: pi
   use nutate_methods, only: make_stepper
   use nutate_rotor, only: rotor_t
   use nutate_spring, only: spring_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   implicit none

   !> A problem that was made, and the one before it.
   type :: made_t
      type(problem_t) :: problem
      type(made_t), pointer :: before => null()
   end type made_t

   !> The last problem that was made.
   type(made_t), pointer :: last => null()

contains

   module procedure new_problem
      type(made_t), pointer :: made
      allocate (made)
      made%before => last
      last => made
      problem => made%problem
   end procedure new_problem

   module procedure new_system
      type(problem_t), pointer :: problem
      problem => new_problem()
      system => problem%system
   end procedure new_system

   module procedure end_problem
   end procedure end_problem

   module procedure box
      type(status_t) :: status
      problem => new_problem()
      call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], problem%system%body, status, mass=12.0_wp)
      problem%start = make_state(problem%system, identity, [0.1_wp, 0.0_wp, 10.0_wp])
   end procedure box

   !> The cone on its tip that the tops of the paper's reference [3] are.
   function cone_top(omega) result(problem)
      real(wp), intent(in) :: omega(3)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_shape_body('cone', [0.05_wp, 0.1_wp], problem%system%body, status, density=2700.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, [cos(pi/6), sin(pi/6), 0.0_wp, 0.0_wp], omega)
   end function cone_top

   module procedure precessing_top
      problem => cone_top([0.0_wp, 10*sin(pi/3), 140.6_wp])
   end procedure precessing_top

   module procedure fast_top
      problem => cone_top([0.0_wp, 0.0_wp, 200.0_wp])
   end procedure fast_top

   module procedure bruls_top
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([0.234375_wp, 0.46875_wp, 0.234375_wp]), problem%system%body, status, mass=15.0_wp, &
                     center_of_mass=[0.0_wp, 1.0_wp, 0.0_wp], about_center_of_mass=.true.)
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, identity, [0.0_wp, 150.0_wp, -4.61538_wp])
   end procedure bruls_top

   module procedure simo_top
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([5.0_wp, 5.0_wp, 1.0_wp]), problem%system%body, status, mass=20.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -1.0_wp]))
      problem%start = make_state(problem%system, [cos(0.025_wp), sin(0.025_wp), 0.0_wp, 0.0_wp], &
                                 [0.0_wp, 0.0_wp, 50.0_wp])
   end procedure simo_top

   module procedure free_body
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status, check_triangle=.false.)
      problem%start = make_state(problem%system, identity, momentum/moments)
   end procedure free_body

   module procedure forced_body
      type(status_t) :: status
      problem => new_problem()
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
   end procedure forced_body

   module procedure wheeled_body
      type(wheel_t) :: wheel
      type(status_t) :: status
      problem => forced_body()
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp, speed=5.0_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp], frequency=0.8_wp, &
                                                     start=0.103_wp, stop=0.257_wp))
      call add_wheel(problem%system, wheel, status)
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, &
                                             speed=-20.0_wp, friction=0.15_wp), status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -2.0_wp, 3.0_wp])
   end procedure wheeled_body

   module procedure march
      integer :: i
      do i = 1, n
         call stepper%step(system, state, dt, status)
         if (.not. status%ok()) return
      end do
   end procedure march

   module procedure solve
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      if (present(inverse_j0)) settings%inverse_auxiliary_inertia = inverse_j0
      state = problem%start
      call make_stepper(problem%system, settings, stepper, status)
      if (status%ok()) call march(problem%system, stepper, state, dt, n, status)
   end procedure solve

end submodule test_problems_procedures
