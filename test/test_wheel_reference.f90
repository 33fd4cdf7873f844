!> A wheel that is spun up, against 20 digits, with every method of order 8 and more.
module test_wheel_reference
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_kinds, only: wp
   use nutate_methods, only: methods
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, kinetic_energy, make_state, new_problem, problem_t
   use test_resume, only: label_of, settings_of
   use test_support, only: check, check_close, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_wheel_reference, reference_problem

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   !> A wheel along (1, 2, 2)/3, driven with 0.2 N m until t = 50 s: integrated with 33 digits, not by this code.
   !> Times, q, Ω, h, speed, kinetic energy, work of the motor.
   real(wp), parameter :: spin_up(12, 5) = reshape([ &
      10.0_wp, 0.9911173077372739188_wp, 0.084087961154740951434_wp, -0.083976687354586973245_wp, &
      0.059696005506286580567_wp, 0.013356795933442611609_wp, -0.023636905941914788658_wp, &
      -0.0068318766712277234393_wp, 2.001_wp, 40.035860256430947471_wp, 40.076900548101355568_wp, &
      40.035900548101355568_wp, &
      25.0_wp, 0.91323600018183243801_wp, 0.21142395703896253687_wp, -0.24150825987550024917_wp, &
      -0.25094556934479417738_wp, 0.0073071292210120909415_wp, -0.028708856869405668005_wp, &
      -0.077589772561116276715_wp, 5.001_wp, 100.08843004321334393_wp, 250.26390904867412719_wp, &
      250.22290904867412719_wp, &
      50.0_wp, -0.18240679502587072404_wp, -0.046283077967879897408_wp, 0.19624470785572399171_wp, &
      -0.96232720654714458506_wp, -0.057208758196280491495_wp, -0.06913537928761647975_wp, &
      -0.1285967451602878396_wp, 10.001_wp, 200.17089100236402971_wp, 1000.9164461790598913_wp, &
      1000.8754461790598913_wp, &
      100.0_wp, 0.21822328936461055047_wp, 0.80595786217156160125_wp, -0.38351049612484700278_wp, &
      0.39462668402530672906_wp, -0.013513138370762048085_wp, -0.07425678554706597441_wp, &
      -0.14715534364017275795_wp, 10.001_wp, 200.1721124655817465_wp, 1000.9164461790598913_wp, &
      1000.8754461790598913_wp, &
      200.0_wp, 0.86881159644678229898_wp, -0.025450073490557099336_wp, 0.40153931049972560222_wp, &
      0.28859120874053612593_wp, -0.04169291543090866191_wp, -0.082188597302224508895_wp, &
      -0.12268466554995729292_wp, 10.001_wp, 200.17047981371175742_wp, 1000.9164461790598913_wp, &
      1000.8754461790598913_wp], [12, 5])

contains

   subroutine collect_wheel_reference(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a spin-up agrees with 20 digits", spin_up_agrees), &
                  new_unittest("it does with the motor's times inside of steps", spin_up_agrees_with_odd_steps)]
   end subroutine collect_wheel_reference

   !> Body and start of the reference.
   function reference_problem() result(problem)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(wheel_t) :: wheel
      problem => new_problem()
      call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), problem%system%body, status)
      wheel = wheel_t(name='wheel', axis=[1.0_wp, 2.0_wp, 2.0_wp]/3, inertia=0.05_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[0.2_wp, 0.0_wp, 0.0_wp], start=0.0_wp, stop=50.0_wp))
      call add_wheel(problem%system, wheel, status)
      problem%start = make_state(problem%system, identity, [0.02_wp, -0.01_wp, 0.03_wp])
   end function reference_problem

   !> Runs the reference with a step up to its times.
   subroutine compare_with_reference(error, settings, plan, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      type(integrator_settings_t), intent(in) :: settings
      !> Plan of the run; it ends with the reference.
      type(run_plan_t), intent(in) :: plan
      real(wp), intent(in) :: tolerance
      character(len=*), intent(in) :: label
      type(problem_t), pointer :: problem
      type(run_plan_t) :: a_plan
      type(state_t) :: state
      type(status_t) :: status
      class(run_t), allocatable :: run
      real(wp) :: omega(3), values(11), scale(11)
      integer :: i
      allocate (run)
      problem => reference_problem()
      do i = 1, size(spin_up, 2)
         a_plan = plan
         a_plan%end_time = spin_up(1, i)
         call run%begin(problem%system, settings, problem%start, a_plan, status)
         if (status%ok()) call run%run_to_end(problem%system, status)
         call check(error, status%ok(), label//": "//trim(status%message))
         if (allocated(error)) return
         state = run%state
         omega = angular_velocity(problem%system, state)
         values = [sign(1.0_wp, dot_product(state%q, spin_up(2:5, i)))*state%q, omega, state%wheel_momentum(1), &
                   problem%system%effects%wheels(1)%speed_of(state%wheel_momentum(1), omega), &
                   kinetic_energy(problem%system, state), state%wheel_work(1, 1)]
         scale(1:4) = 1.0_wp
         scale(5:7) = norm2(spin_up(6:8, i))
         scale(8:11) = spin_up(9:12, i)
         call check_close(error, values/scale, spin_up(2:12, i)/scale, tolerance, label)
      end do
   end subroutine compare_with_reference

   !> Order 8 in both forms, the series and the explicit methods of order 8.
   subroutine spin_up_agrees(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call compare_with_reference(error, settings_of(methods(m)), run_plan_t(time_step=0.5_wp), 1e-11_wp, &
                                     label_of(methods(m)))
      end do
   end subroutine spin_up_agrees

   !> 50 s is inside of a step of 0.7 s, and of every step that is chosen by its error.
   subroutine spin_up_agrees_with_odd_steps(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call compare_with_reference(error, settings_of(methods(m)), run_plan_t(time_step=0.7_wp), 1e-11_wp, &
                                     label_of(methods(m)))
         call compare_with_reference(error, settings_of(methods(m)), &
                                     run_plan_t(goal=run_goal_t(local_tolerance=1e-13_wp)), 1e-10_wp, &
                                     label_of(methods(m))//", steps by their error")
      end do
   end subroutine spin_up_agrees_with_odd_steps

end module test_wheel_reference
