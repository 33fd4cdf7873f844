!> The Taylor series: exact solutions to round-off, invariants at any tolerance, its own states between steps.
submodule(suites_of_methods) test_taylor
   use nutate_applied_torque, only: applied_torque_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_exact_free, only: free_body_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_summary, only: run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_controlled_run, only: recorder_t, run_to
   use test_problems, only: body_momentum, box, bruls_top, fast_top, forced_body, free_body, kinetic_energy, march, &
      precessing_top, problem_t, simo_top
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_taylor
      testsuite = [ &
                  new_unittest("exact solutions of free bodies come out to round-off", exact_free_bodies), &
                  new_unittest("tops of the literature come out to round-off", literature_tops), &
                  new_unittest("invariants hold at every tolerance", invariants_at_every_tolerance), &
                  new_unittest("invariants hold over 1e6 steps", invariants_over_many_steps), &
                  new_unittest("without projection the energy drifts as the tolerance says", without_projection), &
                  new_unittest("accuracy is met", accuracy_is_met), &
                  new_unittest("rows at intervals do not disturb the steps", rows_do_not_disturb), &
                  new_unittest("goes backwards in time", goes_backwards), &
                  new_unittest("steps end where torques start and stop", steps_end_where_torques_do), &
                  new_unittest("units that are powers of two change no digit", powers_of_two), &
                  new_unittest("what stands still stays", stands_still), &
                  new_unittest("quaternions keep their sign in steps beyond half a turn", quaternions_keep_signs)]
   end procedure collect_taylor

   !> Runs a problem, with trial runs where an accuracy is asked for.
   subroutine run(problem, end_time, goal, recorder, state, summary, status, conserve, interval)
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time
      type(run_goal_t), intent(in) :: goal
      type(recorder_t), intent(inout) :: recorder
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      logical, intent(in), optional :: conserve
      !> Between rows, s.
      real(wp), intent(in), optional :: interval
      type(integrator_settings_t) :: settings
      type(run_plan_t) :: plan
      settings = default_settings('taylor')
      if (present(conserve)) settings%conserve = conserve
      plan = run_plan_t(end_time=end_time, goal=goal)
      if (present(interval)) plan%interval = interval
      call run_to(problem, settings, plan, recorder, state, summary, status)
   end subroutine run

   !> Runs to a tolerance of the steps and compares the attitude at the end.
   subroutine check_end(error, problem, end_time, q, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time, q(4), tolerance
      character(len=*), intent(in) :: label
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      if (allocated(error)) return
      goal%local_tolerance = 1e-16_wp
      call run(problem, end_time, goal, recorder, state, summary, status)
      call check(error, status%ok(), label//': '//trim(status%message))
      call check_below(error, attitude_distance(state%q, q), tolerance, label)
   end subroutine check_end

   subroutine exact_free_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call check_end(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, &
                     [-0.736061364160793936_wp, -0.570786951240350733_wp, -0.299388571830790094_wp, &
                      -0.206839086104673192_wp], 2e-14_wp, 'free body')
      call check_free(error, box(), 5.0_wp, 1e-10_wp, 'box')
      call check_free(error, free_body([1.0_wp, 1.0_wp, 2.0_wp], [0.0_wp, 0.0_wp, 3.0_wp]), 7.0_wp, 2e-14_wp, 'spin')
      call check_free(error, free_body([1.0_wp, 1.0_wp, 1.0_wp], [1.0_wp, 2.0_wp, 3.0_wp]), 7.0_wp, 2e-14_wp, 'sphere')
   end subroutine exact_free_bodies

   subroutine check_free(error, problem, end_time, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time, tolerance
      character(len=*), intent(in) :: label
      type(free_body_t) :: solution
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      call solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
      call solution%evaluate(end_time, q, momentum)
      call check_end(error, problem, end_time, q, tolerance, label)
   end subroutine check_free

   !> Values of the exact solution of the Lagrange top.
   subroutine literature_tops(error)
      type(error_type), allocatable, intent(out) :: error
      call check_end(error, bruls_top(), 2.0_wp, [0.122947135041533467_wp, -0.491079892550027015_wp, &
                                                  0.350430030343620962_wp, -0.787986887550485669_wp], 2e-13_wp, 'Bruls')
      call check_end(error, simo_top(), 10.0_wp, [0.2438016485933435_wp, 0.0195997964216783492_wp, &
                                                  -0.0187249229592649203_wp, -0.96944622408030772_wp], 2e-13_wp, 'Simo')
      call check_end(error, precessing_top(), 1.0_wp, [-0.74129324557326555_wp, 0.49974636690044272_wp, &
                                                       0.015923842809073599_wp, -0.44775475884400627_wp], 2e-13_wp, &
                     'precessing')
   end subroutine literature_tops

   subroutine invariants_at_every_tolerance(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(5)
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: bound
      integer :: i, exponent
      character(len=48) :: label
      problems(1) = box()
      problems(2) = bruls_top()
      problems(3) = fast_top()
      problems(4) = simo_top()
      problems(5) = forced_body()
      do i = 1, size(problems)
         do exponent = 4, 13, 3
            write (label, '("problem ",i0,", tolerance 1e-",i0)') i, exponent
            goal = run_goal_t(local_tolerance=10.0_wp**(-exponent))
            call run(problems(i), 1.0_wp, goal, recorder, state, summary, status)
            call check(error, status%ok(), trim(label)//': '//trim(status%message))
            bound = 1e-14_wp*sqrt(real(summary%steps, wp))
            associate (invariants => recorder%invariants)
               call check_below(error, max(invariants%energy_error(), invariants%momentum_error(), &
                                           invariants%norm_error), bound, label)
            end associate
         end do
      end do
   end subroutine invariants_at_every_tolerance

   subroutine invariants_over_many_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(invariants_t) :: invariants
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => bruls_top()
      settings = default_settings('taylor')
      settings%series_order = 5
      call make_stepper(problem%system, settings, stepper, status)
      state = problem%start
      call invariants%start(problem%system, state)
      do i = 1, 10
         if (status%ok()) call march(problem%system, stepper, state, 1e-3_wp, 100000, status)
         call invariants%measure(problem%system, state)
      end do
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check_below(error, max(invariants%energy_error(), invariants%momentum_error(), invariants%norm_error), &
                       1e-14_wp)
   end subroutine invariants_over_many_steps

   subroutine without_projection(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      goal%local_tolerance = 1e-6_wp
      call run(bruls_top(), 1.0_wp, goal, recorder, state, summary, status, conserve=.false.)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, recorder%invariants%energy_error(), 1e-5_wp, 'energy')
      call check_below(error, 1e-12_wp, recorder%invariants%energy_error(), 'no drift at all')
   end subroutine without_projection

   !> The error at the end is at most the accuracy, and not below a fiftieth of it.
   subroutine accuracy_is_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp), parameter :: q(4) = [0.122947135041533467_wp, -0.491079892550027015_wp, 0.350430030343620962_wp, &
                                     -0.787986887550485669_wp]
      real(wp) :: found
      integer :: exponent
      character(len=24) :: label
      do exponent = 4, 12, 2
         goal = run_goal_t(accuracy=10.0_wp**(-exponent))
         call run(bruls_top(), 2.0_wp, goal, recorder, state, summary, status)
         call check(error, status%ok(), trim(status%message))
         write (label, '("accuracy 1e-",i0)') exponent
         found = attitude_distance(state%q, q)
         call check_below(error, found, 10.0_wp**(-exponent), label)
         call check_below(error, found, 4*summary%estimate + 1e-13_wp, trim(label)//': beyond the estimate')
         call check(error, summary%subdivided_steps == 0, trim(label)//': steps in vain')
      end do
   end subroutine accuracy_is_met

   subroutine rows_do_not_disturb(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t) :: goal
      type(recorder_t) :: rare, dense
      type(run_summary_t) :: a, b
      type(state_t) :: few, many
      type(status_t) :: status
      goal%local_tolerance = 1e-8_wp
      call run(forced_body(), 2.0_wp, goal, rare, few, a, status)
      call run(forced_body(), 2.0_wp, goal, dense, many, b, status, interval=0.012_wp)
      call check(error, a%steps == b%steps .and. dense%rows == 168, "other steps, or other rows")
      call check_close(error, [many%q, many%p], [few%q, few%p], 0.0_wp, "last state")
      call check_below(error, max(dense%invariants%energy_error(), dense%invariants%norm_error), 1e-14_wp, "invariants")
   end subroutine rows_do_not_disturb

   subroutine goes_backwards(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(problem_t) :: back
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => forced_body()
      goal%local_tolerance = 1e-15_wp
      call run(problem, -0.5_wp, goal, recorder, state, summary, status)
      back = problem
      back%start = state
      call run(back, 0.0_wp, goal, recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], 1e-13_wp, "start")
      call check_close(error, state%p, problem%start%p, 1e-13_wp*norm2(problem%start%p), "momentum")
   end subroutine goes_backwards

   !> A torque from 0.3 to 0.7 s on a body at rest: its momentum is the torque times 0.4 s to round-off.
   subroutine steps_end_where_torques_do(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(applied_torque_t(name='torque', amplitude=[0.0_wp, 0.0_wp, 2.0_wp], &
                                                       start=0.3_wp, stop=0.7_wp))
      goal%local_tolerance = 1e-8_wp
      call run(problem, 1.0_wp, goal, recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, body_momentum(state), [0.0_wp, 0.0_wp, 0.8_wp], 16*eps, "momentum")
      call check_close(error, recorder%work(recorder%rows), 0.32_wp, 16*eps, "work")
   end subroutine steps_end_where_torques_do

   !> Moments times 2^80, momenta times 2^50: times divided by 2^(-30).
   subroutine powers_of_two(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3) = [0.6_wp, 0.8_wp, 1.0_wp], momentum(3) = [1.8_wp, 0.4_wp, -0.9_wp]
      real(wp), parameter :: heavy = 2.0_wp**80, strong = 2.0_wp**50
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: a, b
      type(status_t) :: status
      goal%local_tolerance = 1e-9_wp
      call run(free_body(moments, momentum), 10.0_wp, goal, recorder, a, summary, status)
      call run(free_body(heavy*moments, strong*momentum), 10.0_wp*heavy/strong, goal, recorder, b, summary, status)
      call check_close(error, b%q, a%q, 0.0_wp, 'attitude')
   end subroutine powers_of_two

   !> Rows lie so close that a quaternion turns by less than 0.4 rad from one to the next, steps by up to 5 rad.
   subroutine quaternions_keep_signs(error)
      type(error_type), allocatable, intent(out) :: error
      type(applied_torque_t) :: torque
      type(problem_t), pointer :: problem
      integer :: k
      do k = 0, 2
         problem => free_body([3.0_wp, 3.05_wp, 3.1_wp], [9.0_wp, 9.15_wp, 9.3_wp]*merge(1, 0, k < 2))
         torque%amplitude = [1e-3_wp, 0.0_wp, 0.0_wp]
         if (k == 2) torque%amplitude = [2.0_wp, 3.0_wp, 1.0_wp]
         call problem%system%effects%add(torque)
         call check_signs(error, problem, 8.0_wp, merge(1e-9_wp, 1e-5_wp, k == 0))
         if (allocated(error)) return
      end do
      call check_signs(error, bruls_top(), 0.2_wp, 1e-4_wp)
   end subroutine quaternions_keep_signs

   subroutine check_signs(error, problem, end_time, tolerance)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), intent(in) :: problem
      !> s, rad.
      real(wp), intent(in) :: end_time, tolerance
      type(recorder_t) :: recorder
      type(run_goal_t) :: goal
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      goal%local_tolerance = tolerance
      call run(problem, end_time, goal, recorder, state, summary, status, interval=end_time/190)
      call check(error, status%ok(), trim(status%message))
      do i = 2, recorder%rows
         if (allocated(error)) return
         call check(error, dot_product(recorder%states(i)%q, recorder%states(i - 1)%q) > 0.9_wp, "the sign changes")
      end do
   end subroutine check_signs

   subroutine stands_still(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      goal%local_tolerance = 1e-9_wp
      call run(problem, 10.0_wp, goal, recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [state%t, state%q, state%p], [10.0_wp, problem%start%q, problem%start%p], 0.0_wp)
      call check_close(error, kinetic_energy(problem%system, state), 0.0_wp, 0.0_wp)
   end subroutine stands_still

end submodule test_taylor
