!> Controllers: samples that are held, in closed form with every method; laws that act at all times; what magnetorquers
!> and wheels cannot do; account and momentum; runs that are interrupted.
submodule(suites_of_effects) test_controllers
   use nutate_body, only: diagonal, make_body
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, long, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: attitude_distance, quat_product
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, forced_body, kinetic_energy, make_state, new_problem, problem_t, &
      space_momentum, total_energy
   use test_resume, only: check_run, label_of, settings_of
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], field(3) = [0.4_wp, -0.3_wp, 0.7_wp]

contains

   module procedure collect_controllers
      testsuite = [ &
                  new_unittest("samples are held to the next, in closed form", samples_have_the_closed_form), &
                  new_unittest("start, stop and limits of what is held", window_and_limit), &
                  new_unittest("wheels hold it too, within their limits", wheels_hold_it), &
                  new_unittest("a law at all times keeps the order", laws_keep_the_order), &
                  new_unittest("samples of a moving target keep the order", moving_targets_keep_the_order), &
                  new_unittest("the quaternion law takes energy away", pointing_takes_energy), &
                  new_unittest("B-dot takes energy and leaves l along the field", bdot_leaves_momentum_along), &
                  new_unittest("wheels leave the momentum, and the account closes", account_and_momentum), &
                  new_unittest("what is interrupted goes on bit for bit", runs_go_on), &
                  new_unittest("what cannot be is refused by name", bad_controllers_are_refused)]
   end procedure collect_controllers

   !> The law -k J e_v - d J Ω.
   pure type(controller_t) function pointing(moments, by, sample) result(controller)
      real(wp), intent(in) :: moments(3)
      integer, intent(in) :: by
      real(wp), intent(in) :: sample
      controller%name = 'controller'
      controller%by = by
      controller%sample = sample
      controller%attitude_gain = 0.6_wp*diagonal(moments)
      controller%rate_gain = 0.5_wp*diagonal(moments)
      if (by == BY_MAGNETORQUERS) controller%field = field
   end function pointing

   !> A body that turns about its axis 3, θ(0) = 1 rad, with a controller by torque or by a wheel.
   function plain_turn(controller, wheel) result(problem)
      type(controller_t), intent(in) :: controller
      type(wheel_t), intent(in), optional :: wheel
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([4.0_wp, 5.0_wp, 3.0_wp]), problem%system%body, status)
      if (present(wheel)) call add_wheel(problem%system, wheel, status)
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, [cos(0.5_wp), 0.0_wp, 0.0_wp, sin(0.5_wp)], [0.0_wp, 0.0_wp, 0.4_wp])
   end function plain_turn

   !> θ and θ' at a time, from samples every so many seconds of -k J sin(θ/2) - d J θ', cut off, on an inertia.
   subroutine go_from_sample_to_sample(sample, until, inertia, limit, theta, rate, first, last)
      !> s; kg m²; N m.
      real(wp), intent(in) :: sample, until, inertia, limit
      real(wp), intent(out) :: theta, rate
      !> The first and the last sample that count, s.
      real(wp), intent(in) :: first, last
      real(wp) :: t, h, torque
      theta = 1.0_wp
      rate = 0.4_wp
      t = 0.0_wp
      do while (t < until - 1e-9_wp)
         h = min(sample, until - t)
         torque = max(-limit, min(limit, -3*(0.6_wp*sin(0.5_wp*theta) + 0.5_wp*rate)))
         if (t < first - 1e-9_wp .or. t > last - 1e-9_wp) torque = 0.0_wp
         theta = theta + h*rate + 0.5_wp*h*h*torque/inertia
         rate = rate + h*torque/inertia
         t = t + h
      end do
   end subroutine go_from_sample_to_sample

   !> Every method, with fixed steps, shorter and longer than a sample and incommensurate with it, and by error.
   subroutine check_plain(error, problem, theta, rate)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> Solution at t = 6.2 s, rad and rad/s.
      real(wp), intent(in) :: theta, rate
      type(run_plan_t) :: plans(4)
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      real(wp) :: omega(3), energy
      integer :: m, i
      plans = run_plan_t(time_step=0.1_wp, end_time=6.2_wp)
      plans(2)%time_step = 0.07_wp
      plans(3)%time_step = 0.8_wp
      plans(4) = run_plan_t(goal=run_goal_t(local_tolerance=1e-10_wp), end_time=6.2_wp)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         do i = 1, size(plans)
            if (i == 4 .and. methods(m)%order < 4) cycle
            state = problem%start
            energy = total_energy(problem%system, state)
            call integrate(problem%system, settings_of(methods(m)), state, plans(i), status, summary=summary)
            call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
            omega = angular_velocity(problem%system, state)
            ! Order 2 turns by an angle with the error of its step, which the next sample sees.
            call check_close(error, omega(3), rate, merge(1e-2_wp, 3e-6_wp, methods(m)%order == 2), &
                  label_of(methods(m)))
            if (i == 1 .and. methods(m)%order > 4) then
               call check_close(error, omega(3), rate, 1e-11_wp, label_of(methods(m))//', rate')
               call check_close(error, 2*atan2(state%q(4), state%q(1)), theta, 1e-11_wp, &
                                label_of(methods(m))//', angle')
            end if
            if (methods(m)%conserving .and. .not. allocated(error)) call check_below( &
               error, abs(total_energy(problem%system, state) - energy - sum(summary%work)), &
               64*eps*(energy + kinetic_energy(problem%system, state) + sum(abs(summary%work))), &
               label_of(methods(m))//', account')
         end do
      end do
   end subroutine check_plain

   subroutine samples_have_the_closed_form(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: theta, rate
      call go_from_sample_to_sample(0.5_wp, 6.2_wp, 3.0_wp, huge(1.0_wp), theta, rate, 0.0_wp, 9.0_wp)
      call check_plain(error, plain_turn(pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_TORQUE, 0.5_wp)), theta, rate)
   end subroutine samples_have_the_closed_form

   !> Samples count from the start; nothing is held before it, nor behind the stop; what is held is cut off.
   subroutine window_and_limit(error)
      type(error_type), allocatable, intent(out) :: error
      type(controller_t) :: controller
      real(wp) :: theta, rate
      controller = pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_TORQUE, 0.6_wp)
      controller%limit = 0.7_wp
      call go_from_sample_to_sample(0.6_wp, 6.2_wp, 3.0_wp, 0.7_wp, theta, rate, 0.0_wp, 9.0_wp)
      call check_plain(error, plain_turn(controller), theta, rate)
      controller%start = 1.2_wp
      controller%stop = 4.8_wp
      call go_from_sample_to_sample(0.6_wp, 6.2_wp, 3.0_wp, 0.7_wp, theta, rate, 1.2_wp, 4.8_wp)
      call check_plain(error, plain_turn(controller), theta, rate)
   end subroutine window_and_limit

   !> A wheel on the axis: the body turns with the inertia without it, by the torque that the motor holds.
   subroutine wheels_hold_it(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: theta, rate
      call go_from_sample_to_sample(0.5_wp, 6.2_wp, 2.9_wp, 0.8_wp, theta, rate, 0.0_wp, 9.0_wp)
      call check_plain(error, plain_turn(pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_WHEELS, 0.5_wp), &
                                         wheel_t(name='wheel', axis=[0.0_wp, 0.0_wp, 1.0_wp], inertia=0.1_wp, &
                                                 torque_limit=0.8_wp)), theta, rate)
   end subroutine wheels_hold_it

   !> A tumbling body with wheels on four inclined axes and a controller.
   function tumbling(controller, forced) result(problem)
      type(controller_t), intent(in) :: controller
      !> The body has every other kind of effect too.
      logical, intent(in), optional :: forced
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: axis(3)
      integer :: i
      problem => new_problem()
      if (present(forced)) problem => forced_body()
      if (.not. present(forced)) call make_body(diagonal([4.0_wp, 5.0_wp, 3.0_wp]), problem%system%body, status)
      do i = 1, 4
         axis = [merge(1, -1, i < 3), merge(1, -1, mod(i, 2) == 0), 1]
         call add_wheel(problem%system, wheel_t(name='wheel', axis=axis/norm2(axis), inertia=0.05_wp, &
               speed=i*1.0_wp), status)
      end do
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [0.3_wp, -0.2_wp, 0.4_wp])
   end function tumbling

   !> Compares with dop853 at a tenth of the step.
   subroutine laws_keep_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(controller_t) :: laws(4)
      type(state_t) :: wanted, state
      type(status_t) :: status
      type(problem_t), pointer :: problem
      real(wp) :: errors(2), step
      integer :: i, m, k
      laws(1) = pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_TORQUE, 0.0_wp)
      laws(2) = pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_MAGNETORQUERS, 0.0_wp)
      laws(3) = controller_t(name='controller', law=DETUMBLING, by=BY_MAGNETORQUERS, gain=1.5_wp, field=field)
      laws(4) = pointing([4.0_wp, 5.0_wp, 3.0_wp], BY_WHEELS, 0.0_wp)
      do i = 1, size(laws)
         problem => tumbling(laws(i))
         wanted = problem%start
         call integrate(problem%system, integrator_settings_t(method='dop853', order=8, formulation=''), wanted, &
                        run_plan_t(time_step=0.005_wp, end_time=3.2_wp), status)
         do m = 1, size(methods)
            if (methods(m)%name == 'exact' .or. methods(m)%name == 'taylor') cycle
            if (methods(m)%name == 'nielsen_krenk' .and. i == 4) cycle
            do k = 1, 2
               step = merge(0.1_wp, 0.4_wp, methods(m)%order < 6)/k
               state = problem%start
               call integrate(problem%system, settings_of(methods(m)), state, run_plan_t(time_step=step, &
                     end_time=3.2_wp), &
                              status)
               call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
               errors(k) = attitude_distance(state%q, wanted%q)
            end do
            call check(error, errors(2) < 1e-12_wp .or. &
                       log(errors(1)/errors(2))/log(2.0_wp) > methods(m)%order - 0.7_wp, label_of(methods(m)))
         end do
      end do
   end subroutine laws_keep_the_order

   !> Checks a target that rotates with an eccentric orbit, and the field of the Earth along it, against dop853 at a
   !> tenth of the step. A sample taken 2e-9 of a step ahead leaves an error of order 1, some 1e-10.
   subroutine moving_targets_keep_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(state_t) :: wanted, state
      type(status_t) :: status
      type(problem_t), pointer :: problem
      real(wp) :: errors(2), step
      integer :: by, m, k
      do by = BY_TORQUE, BY_MAGNETORQUERS
         problem => orbiting(by)
         wanted = problem%start
         call integrate(problem%system, integrator_settings_t(method='dop853', order=8, formulation=''), wanted, &
                        run_plan_t(time_step=0.01_wp, end_time=4.0_wp), status)
         do m = 1, size(methods)
            if (methods(m)%name == 'exact') cycle
            do k = 1, 2
               step = merge(0.1_wp, 0.4_wp, methods(m)%order < 6)/k
               state = problem%start
               call integrate(problem%system, settings_of(methods(m)), state, &
                              run_plan_t(time_step=step, end_time=4.0_wp), status)
               call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
               errors(k) = attitude_distance(state%q, wanted%q)
            end do
            call check(error, errors(2) < 4e-13_wp .or. &
                       log(errors(1)/errors(2))/log(2.0_wp) > methods(m)%order - 0.7_wp, label_of(methods(m)))
         end do
      end do
   end subroutine moving_targets_keep_the_order

   !> A body on a fast eccentric orbit whose controller has a sample, its target seen from there, its field that of the
   !> Earth.
   function orbiting(by) result(problem)
      integer, intent(in) :: by
      type(problem_t), pointer :: problem
      type(controller_t) :: controller
      type(kepler_orbit_t) :: path
      type(status_t) :: status
      problem => new_problem()
      path = kepler_orbit_t(mu=0.4_wp, eccentricity=0.3_wp, inclination=0.5_wp, raan=0.3_wp, mean_anomaly=1.0_wp)
      call make_body(diagonal([4.0_wp, 5.0_wp, 3.0_wp]), problem%system%body, status)
      call problem%system%effects%add(orbit_t(path, inertial=.true.))
      if (by == BY_WHEELS) call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], &
                                                                  inertia=0.1_wp), status)
      controller = pointing([4.0_wp, 5.0_wp, 3.0_wp], by, 0.4_wp)
      controller%follows_orbit = .true.
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, quat_product(path%axes(0.0_wp), [0.8_wp, 0.0_wp, 0.6_wp, 0.0_wp]), &
                                 [0.1_wp, -0.3_wp, 0.2_wp])
   end function orbiting

   !> Checks that T + 2k(1 - |e₀|) falls with gains times the unit matrix, and that the body comes to its target.
   subroutine pointing_takes_energy(error)
      type(error_type), allocatable, intent(out) :: error
      type(controller_t) :: controller
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      type(state_t) :: state
      real(wp) :: before, now
      integer :: i
      controller = pointing([1.0_wp, 1.0_wp, 1.0_wp], BY_TORQUE, 0.0_wp)
      problem => plain_turn(controller)
      problem%start = make_state(problem%system, [0.1_wp, 0.7_wp, -0.5_wp, -0.5_wp], [0.2_wp, -0.4_wp, 0.3_wp])
      state = problem%start
      call make_stepper(problem%system, integrator_settings_t(order=4), stepper, status)
      now = huge(1.0_wp)
      do i = 1, 2000
         before = now
         call stepper%step(problem%system, state, 0.05_wp, status)
         now = kinetic_energy(problem%system, state) + 2*0.6_wp*(1 - abs(state%q(1)))
         call check(error, status%ok() .and. now < before, 'it falls')
         if (allocated(error)) return
      end do
      call check_below(error, 1 - abs(state%q(1)), 1e-4_wp, 'the target')
   end subroutine pointing_takes_energy

   !> m×B is across B: l·b stays, to round-off in the implicit step; the energy falls up to what the field cannot reach.
   subroutine bdot_leaves_momentum_along(error)
      type(error_type), allocatable, intent(out) :: error
      type(controller_t) :: controller
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: change(3), tolerance
      integer :: m, way
      do way = 1, 2
         controller = controller_t(name='controller', law=DETUMBLING, by=BY_MAGNETORQUERS, gain=3.0_wp, field=field, &
                                 sample=merge(0.1_wp, 0.0_wp, way == 1))
         problem => plain_turn(controller)
         do m = 1, size(methods)
            if (methods(m)%name == 'exact' .or. (way == 2 .and. methods(m)%name == 'taylor')) cycle
            state = problem%start
            call integrate(problem%system, settings_of(methods(m)), state, run_plan_t(time_step=0.1_wp, &
                  end_time=40.0_wp), &
                           status, summary=summary)
            call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
            call check(error, summary%work(1) < -0.5_wp*kinetic_energy(problem%system, problem%start), &
                  'it takes energy')
            change = space_momentum(state) - space_momentum(problem%start)
            tolerance = merge(256*eps, 1e-5_wp, methods(m)%name == 'nielsen_krenk')
            call check_below(error, abs(dot_product(change, field))/norm2(field), tolerance, label_of(methods(m)))
         end do
      end do
   end subroutine bdot_leaves_momentum_along

   subroutine account_and_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(controller_t) :: controller
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: energy
      integer :: m, way
      problem => new_problem()
      do way = 1, 3
         controller = pointing([4.0_wp, 5.0_wp, 3.0_wp], merge(BY_MAGNETORQUERS, BY_WHEELS, way == 3), 0.25_wp)
         if (way == 1) problem => tumbling(controller)
         if (way > 1) problem => tumbling(controller, forced=.true.)
         do m = 1, size(methods)
            if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
            state = problem%start
            energy = total_energy(problem%system, state)
            call integrate(problem%system, settings_of(methods(m)), state, run_plan_t(time_step=0.03_wp, &
                  end_time=2.0_wp), &
                           status, summary=summary)
            call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
            call check_below(error, abs(total_energy(problem%system, state) - energy - sum(summary%work)), &
                             64*eps*(abs(energy) + kinetic_energy(problem%system, state) + sum(abs(summary%work))), &
                             label_of(methods(m))//', account')
            if (way == 1) call check_below(error, norm2(space_momentum(state) - space_momentum(problem%start)), &
                                           64*eps*norm2(space_momentum(problem%start)), &
                                           label_of(methods(m))//', momentum')
         end do
      end do
   end subroutine account_and_momentum

   !> Samples between steps, on them, and laws at all times.
   subroutine runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(controller_t) :: controller
      integer :: m, way
      do way = 1, 3
         do m = 1, size(methods)
            if (methods(m)%name == 'exact' .or. (methods(m)%name == 'taylor' .and. way == 3)) cycle
            controller = pointing([4.0_wp, 5.0_wp, 3.0_wp], merge(BY_MAGNETORQUERS, BY_WHEELS, way > 1), 0.11_wp)
            if (way == 3) controller%sample = 0.0_wp
            call check_run(error, tumbling(controller, forced=.true.), settings_of(methods(m)), &
                           run_plan_t(time_step=0.05_wp, end_time=1.0_wp, every=3_long), [2, 3, 7, 14], &
                           label_of(methods(m)))
            if (way == 1) call check_run(error, tumbling(controller, forced=.true.), settings_of(methods(m)), &
                                         run_plan_t(goal=run_goal_t(local_tolerance=1e-7_wp), end_time=0.5_wp), [1, &
                                         3], label_of(methods(m)))
         end do
      end do
   end subroutine runs_go_on

   subroutine bad_controllers_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3) = [4.0_wp, 5.0_wp, 3.0_wp]
      type(problem_t), pointer :: problem
      type(controller_t) :: controller
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call add_controller(problem%system, pointing(moments, BY_WHEELS, 0.5_wp), status)
      call refused('no wheels', 'without wheels')
      controller = pointing(moments, BY_TORQUE, -1.0_wp)
      if (.not. allocated(error)) call add_controller(problem%system, controller, status)
      call refused('a negative period', 'the controller is invalid')
      controller = controller_t(law=DETUMBLING)
      if (.not. allocated(error)) call add_controller(problem%system, controller, status)
      call refused('B-dot without magnetorquers', 'magnetorquers to detumble')
      if (allocated(error)) return
      problem => tumbling(pointing(moments, BY_WHEELS, 0.0_wp))
      call add_controller(problem%system, pointing(moments, BY_WHEELS, 0.5_wp), status)
      call refused('a second one', 'a motor of its own')
      if (.not. allocated(error)) call make_stepper(problem%system, integrator_settings_t(), stepper, status)
      call refused('implicit steps with wheels at all times', 'dop853')
      if (.not. allocated(error)) call make_stepper( &
         problem%system, integrator_settings_t(method='taylor', order=16, formulation=''), stepper, status)
      call refused('a series of feedback', 'expected sample')
      if (allocated(error)) return
      problem => tumbling(pointing(moments, BY_WHEELS, 0.5_wp))
      state = problem%start
      call integrate(problem%system, integrator_settings_t(), state, &
                     run_plan_t(goal=run_goal_t(accuracy=1e-6_wp), end_time=1.0_wp), status)
      call refused('an accuracy', 'a controller has a sample')

   contains

      subroutine refused(label, words)
         character(len=*), intent(in) :: label, words
         if (allocated(error)) return
         call check(error, status%code == NUTATE_BAD_ARGUMENT .and. index(status%message, words) > 0, &
                    label//': '//trim(status%message))
      end subroutine refused

   end subroutine bad_controllers_are_refused

end submodule test_controllers
