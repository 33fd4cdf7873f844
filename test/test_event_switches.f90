!> Switches by events: a bang-bang torque, a potential that comes and goes, switches without end.
submodule(suites_of_methods) test_event_switches
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_event, only: SWITCH_OFF, SWITCH_ON, SWITCH_TOGGLE
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_methods, only: default_settings, methods
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STEP_LIMIT
   use nutate_integrator_settings, only: integrator_settings_t
   use test_event_support, only: angle_event_t, compass, keeper_t, no_effects, rate_event_t
   use test_problems, only: make_state, new_problem, problem_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_event_switches
      testsuite = [ &
                  new_unittest("a bang-bang torque keeps the order of the method", bang_bang), &
                  new_unittest("switch times have the order of the method", switch_times_have_the_order), &
                  new_unittest("a potential that is switched books its energy", switched_potential), &
                  new_unittest("switches without end end the run", endless_switches)]
   end procedure collect_event_switches

   !> A body with a thruster for each sense about axis 3; one of them is on.
   function thrusters() result(problem)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(applied_torque_t(name='torque', label='plus', amplitude=[0.0_wp, 0.0_wp, &
         0.02_wp], &
                                                       on=.false.))
      call problem%system%effects%add(applied_torque_t(name='torque', label='minus', &
                                                       amplitude=[0.0_wp, 0.0_wp, -0.02_wp]))
      problem%start = make_state(problem%system, [cos(0.1_wp), 0.0_wp, 0.0_wp, sin(0.1_wp)], &
                                 [0.0_wp, 0.0_wp, -0.01_wp])
   end function thrusters

   !> Parabolas in closed form: J = 1, u = 0.02, line s = θ + 2θ', on at 1e-2, off at 5e-3, 19 switches in 40 s.
   subroutine bang_bang(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: first(8) = [2.373397172404482_wp, 2.6344122549008547_wp, 4.6315632352028424_wp, &
                                         4.9168711797659357_wp, 5.1208306770530034_wp, 5.4926958380445302_wp, &
                                         5.6692506674570252_wp, 6.1735555496876636_wp], &
                             last(2) = [-0.0039300749765000849_wp, 0.0012881294457582911_wp]
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      integer :: row
      real(wp) :: energy
      call events%add(angle_event_t(name='minus on', lead=2.0_wp, level=1e-2_wp, direction=1, effect='minus', &
                                    action=SWITCH_ON))
      call events%add(angle_event_t(name='minus off', lead=2.0_wp, level=5e-3_wp, direction=-1, effect='minus', &
                                    action=SWITCH_OFF))
      call events%add(angle_event_t(name='plus on', lead=2.0_wp, level=-1e-2_wp, direction=-1, effect='plus', &
                                    action=SWITCH_ON))
      call events%add(angle_event_t(name='plus off', lead=2.0_wp, level=-5e-3_wp, direction=1, effect='plus', &
                                    action=SWITCH_OFF))
      do row = 1, size(methods)
         if (methods(row)%order == 0) cycle
         problem => thrusters()
         settings = default_settings(methods(row)%name)
         settings%order = methods(row)%order
         settings%formulation = methods(row)%formulation
         settings%conserve = methods(row)%projected
         state = problem%start
         energy = total_energy(problem%system, state)
         allocate (keeper)
         call integrate(problem%system, settings, state, run_plan_t(time_step=0.05_wp, end_time=40.0_wp), status, &
            keeper, &
                        summary, events)
         call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
         call check(error, keeper%n, 19, trim(methods(row)%name)//': switches')
         ! The torque is constant between switches: about a fixed axis all methods of order 4 and more are exact but for
         ! the error of the attitude.
         call check_close(error, keeper%times(1:8), first, merge(1e-4_wp, 1e-8_wp, methods(row)%order == 2), &
                          trim(methods(row)%name))
         call check_close(error, 2*atan2(state%q(4), state%q(1)), last(1), merge(1e-4_wp, 1e-8_wp, &
            methods(row)%order == 2), &
                          trim(methods(row)%name)//': end')
         if (methods(row)%conserving) call check_below(error, abs(total_energy(problem%system, state) - energy - &
                                                       sum(summary%work)), 1e-16_wp, trim(methods(row)%name)// &
                                                       ': account')
         deallocate (keeper)
      end do
   end subroutine bang_bang

   !> Thrusters that turn a tumbling body, so that no method is exact between switches: with half the step the error of
   !> the last switch, against that of the series, falls by 2^order; the account is closed.
   subroutine switch_times_have_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: orders(3) = [2, 4, 8]
      real(wp) :: reference, times(2), account
      integer :: i, k, n, switches
      call switch_tumbling(default_settings('taylor'), 0.02_wp, reference, switches, account)
      call check(error, switches == 3 .and. account <= 1e-13_wp, 'switches of the series')
      do i = 1, size(orders)
         do k = 1, 2
            if (allocated(error)) return
            call switch_tumbling(integrator_settings_t(order=orders(i)), merge(0.2_wp, 0.05_wp, orders(i) == 8)/k, &
                                 times(k), n, account)
            call check(error, n, switches, 'switches')
            call check_below(error, account, 1e-13_wp, 'account')
         end do
         associate (errors => abs(times - reference))
            call check(error, log(errors(1)/max(errors(2), eps))/log(2.0_wp) > orders(i) - 0.6_wp, 'order of the times')
         end associate
      end do
   end subroutine switch_times_have_the_order

   !> A tumbling body whose thruster goes over whenever a rate passes a value.
   subroutine switch_tumbling(settings, dt, last_time, switches, account)
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: dt
      !> s.
      real(wp), intent(out) :: last_time
      integer, intent(out) :: switches
      !> Energy less work, over the energy.
      real(wp), intent(out) :: account
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: energy
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.4_wp, 2.0_wp]), problem%system%body, status)
      call problem%system%effects%add(applied_torque_t(name='torque', label='jet', amplitude=[0.3_wp, 0.1_wp, 0.6_wp]))
      state = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.7_wp, 0.4_wp, 0.9_wp])
      energy = total_energy(problem%system, state)
      call events%add(rate_event_t(name='over', axis=1, level=0.2_wp, effect='jet', action=SWITCH_TOGGLE))
      allocate (keeper)
      call integrate(problem%system, settings, state, run_plan_t(time_step=dt, end_time=10.0_wp), status, keeper, &
                     summary, events)
      switches = keeper%n
      last_time = keeper%times(max(keeper%n, 1))
      account = abs(total_energy(problem%system, state) - energy - sum(summary%work))/energy
      if (.not. status%ok()) switches = -1
   end subroutine switch_tumbling

   !> A field that is off while the needle points away: energy less what was booked is what it was.
   subroutine switched_potential(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(dipole_t) :: needle
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: energy, scale
      integer :: row
      call events%add(angle_event_t(name='switch', level=1.0_wp, period=2*pi, effect='field', action=SWITCH_TOGGLE))
      do row = 1, size(methods)
         if (methods(row)%order == 0 .or. .not. methods(row)%conserving) cycle
         problem => compass()
         problem%system%effects = no_effects()
         needle = dipole_t([5.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 0.0_wp, 0.0_wp])
         needle%label = 'field'
         call problem%system%effects%add(needle)
         problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 3.5_wp])
         settings = default_settings(methods(row)%name)
         settings%order = methods(row)%order
         settings%formulation = methods(row)%formulation
         settings%conserve = methods(row)%projected
         state = problem%start
         energy = total_energy(problem%system, state)
         scale = energy + 10
         allocate (keeper)
         call integrate(problem%system, settings, state, run_plan_t(time_step=0.04_wp, end_time=10.0_wp), status, &
            keeper, &
                        summary, events)
         call check(error, status%ok(), trim(status%message))
         call check(error, keeper%n > 2, trim(methods(row)%name)//': switches')
         call check(error, abs(summary%switch_work) > 0.1_wp, 'work of time-dependent potentials')
         call check_close(error, keeper%last_work, summary%switch_work, 0.0_wp, 'the last row has it')
         if (mod(keeper%n, 2) == 1) call problem%system%effects%switch('field')
         call check_below(error, abs(total_energy(problem%system, state) - energy - summary%switch_work), &
                          64*eps*scale, &
                          trim(methods(row)%name)//': account')
         deallocate (keeper)
      end do
   end subroutine switched_potential

   !> Without a dead band: a torque that drives the rate through zero each time.
   subroutine endless_switches(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(state_t) :: state
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(applied_torque_t(name='torque', label='push', amplitude=[0.0_wp, 0.0_wp, &
         2.0_wp], &
                                                       on=.false.))
      call problem%system%effects%add(applied_torque_t(name='torque', label='drag', amplitude=[0.0_wp, 0.0_wp, &
         -1.0_wp]))
      state = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp])
      call events%add(rate_event_t(name='chatter', level=0.5_wp, effect='push', action=SWITCH_TOGGLE))
      call integrate(problem%system, integrator_settings_t(), state, run_plan_t(time_step=0.1_wp, end_time=2.0_wp), &
         status, &
                     events=events)
      call check(error, status%code, NUTATE_STEP_LIMIT, trim(status%message))
      call check(error, index(status%message, 'chatter') > 0, 'the event is named')
   end subroutine endless_switches

end submodule test_event_switches
