!> Sensitivities and events: derivatives of the times of events, and columns that cross switches; closed forms,
!> central differences of runs, time reversal.
submodule(suites_of_effects) test_tangent_events
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_byte_archive, only: byte_archive_t
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_column_event, only: column_event_t
   use nutate_controller, only: controller_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_event, only: event_t, EXTREMUM, MAXIMUM, MINIMUM, SWITCH_OFF, SWITCH_TOGGLE
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, long, pi
   use nutate_progress, only: total_work
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_product
   use nutate_rotor, only: rotor_t
   use nutate_run, only: run_record_t, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STOPPED
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_event_support, only: angle_event_t, rate_event_t, tilt_event_t
   use test_problems, only: body_momentum, make_state, new_system, system_t
   use test_stopping_observer, only: stopping_observer_t
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest
   implicit none

   !> Most events of a run, and columns.
   integer, parameter :: room = 60, most = 10

   !> Keeps events and the derivatives of their times.
   type, extends(stopping_observer_t) :: keeper_t
      integer :: n = 0
      integer :: which(room) = 0
      logical :: known(room) = .false.
      real(wp) :: times(room) = 0.0_wp, changes(most, room) = 0.0_wp, theta(room) = 0.0_wp
   contains
      procedure :: observe_event => keep_event
   end type keeper_t

   type(integrator_settings_t), parameter :: methods(5) = [ &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=8), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=8), &
      integrator_settings_t(method='rk8'), &
      integrator_settings_t(method='rk8', conserve=.true.), &
      integrator_settings_t(method='dop853')]

contains

   module procedure collect_tangent_events
      testsuite = [ &
                  new_unittest("a thruster that stops at a rate or an angle has the closed form", stop_thruster), &
                  new_unittest("columns cross switches as differences of runs do", cross_switches), &
                  new_unittest("times of all quantities have the derivatives of differences", differ_times), &
                  new_unittest("columns cross limits as differences of runs do", cross_limits), &
                  new_unittest("a switch that is crossed backward undoes what it did", go_there_and_back), &
                  new_unittest("a quantity that touches its level has no derivative", touch_level), &
                  new_unittest("a maximum at a switch has the time of the switch", peak_at_switch), &
                  new_unittest("a run goes on with the derivatives of times", resume_times)]
   end procedure collect_tangent_events

   subroutine keep_event(self, system, event, which, number, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      self%n = min(self%n + 1, room)
      self%which(self%n) = which
      self%times(self%n) = state%t
      self%known(self%n) = allocated(self%time_change)
      if (self%known(self%n)) self%changes(:size(self%time_change), self%n) = self%time_change
      if (self%wants_tangent .and. allocated(self%tangent)) self%theta(self%n) = self%tangent%theta(1, 1)
   end subroutine keep_event

   !> A run with events, with columns or without.
   subroutine go(run, system, start, settings, plan, events, keeper, status, columns)
      type(run_t), intent(out) :: run
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(event_list_t), intent(in) :: events
      type(keeper_t), intent(inout) :: keeper
      type(status_t), intent(out) :: status
      type(variation_t), intent(in), optional :: columns(:)
      call run%begin(system, settings, start, plan, status)
      if (status%ok()) call run%set_events(events, system, status)
      if (present(columns) .and. status%ok()) call run%differentiate(columns, system, status)
      if (status%ok()) call run%run_to_end(system, status, keeper)
   end subroutine go

   !> J = 2 about axis 3, torque 0.5 from rate 0.2; off at rate 0.6, or at the angle 0.7: t = (Ω1 - Ω0)J/τ, then a
   !> steady rotation.
   subroutine stop_thruster(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: j = 2.0_wp, tau = 0.5_wp, first = 0.2_wp, rate = 0.6_wp, angle = 0.7_wp, last = 3.0_wp
      type(system_t), pointer :: system
      type(state_t) :: start
      type(event_list_t) :: by_rate, by_angle
      type(variation_t) :: columns(4)
      type(status_t) :: status
      real(wp) :: t, then, dt(4), dthen(4), dtheta(4)
      integer :: i
      system => new_system()
      call make_body(diagonal([1.5_wp, 1.5_wp, j]), system%body, status)
      call system%effects%add(applied_torque_t(name='torque', label='thruster', amplitude=[0.0_wp, 0.0_wp, tau]))
      start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, first])
      columns(1) = attitude_variation(3)
      columns(2) = rate_variation(3)
      columns(3) = inertia_variation(3, 3)
      call columns(4)%add(system%effects, 'torque', 1, 'body', [0.0_wp, 0.0_wp, 1.0_wp], status)
      call check(error, status%ok(), trim(status%message))
      call by_rate%add(rate_event_t(name='fast', level=rate, effect='thruster', action=SWITCH_OFF))
      call by_angle%add(angle_event_t(name='rotated', level=angle, effect='thruster', action=SWITCH_OFF))
      do i = 1, size(methods)
         if (allocated(error)) return
         t = (rate - first)*j/tau
         dt = [0.0_wp, -j/tau, (rate - first)/tau, -(rate - first)*j/tau**2]
         ! θ = (Ω1² - Ω0²)J/2τ + Ω1(last - t)
         dtheta = [1.0_wp, -first*j/tau, (rate**2 - first**2)/(2*tau), -(rate**2 - first**2)*j/(2*tau**2)] - rate*dt
         call compare_thruster(error, methods(i), by_rate, t, dt, dtheta, [0.0_wp, 0.0_wp, rate, 0.0_wp])
         ! Ω² = Ω0² + 2(angle - θ0)τ/J; θ = angle + Ω(last - t)
         then = sqrt(first**2 + 2*angle*tau/j)
         t = (then - first)*j/tau
         dthen = [-tau/j, first, -angle*tau/j**2, angle/j]/then
         dt = dthen*j/tau
         dt(2:4) = dt(2:4) + [-j/tau, (then - first)/tau, -(then - first)*j/tau**2]
         dtheta = dthen*(last - t) - then*dt
         call compare_thruster(error, methods(i), by_angle, t, dt, dtheta, j*dthen + [0.0_wp, 0.0_wp, then, 0.0_wp])
      end do

   contains

      subroutine compare_thruster(error, settings, events, t, dt, dtheta, dmomentum)
         type(error_type), allocatable, intent(inout) :: error
         type(integrator_settings_t), intent(in) :: settings
         type(event_list_t), intent(in) :: events
         real(wp), intent(in) :: t, dt(4), dtheta(4), dmomentum(4)
         class(run_t), allocatable :: run
         type(keeper_t) :: keeper
      allocate (run)
         keeper%wants_tangent = .true.
         call go(run, system, start, settings, run_plan_t(time_step=0.1_wp, end_time=last), events, keeper, status, &
                 columns)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         ! A rotation by steps of order 8: 1e-13 of a radian.
         call check_close(error, keeper%times(1), t, 1e-12_wp, 'time')
         call check_close(error, keeper%changes(:4, 1), dt, 1e-11_wp, 'derivative of the time')
         call check_close(error, run%events%watched(1)%time_change, dt, 1e-11_wp, 'the same, kept')
         call check_close(error, run%tangent%theta(:, 3), dtheta, 1e-11_wp, 'theta')
         call check_close(error, run%tangent%momentum(:, 3), dmomentum, 1e-11_wp, 'momentum')
         call check_below(error, maxval(abs(run%tangent%theta(:, 1:2))), 1e-14_wp, 'across')
      end subroutine compare_thruster

   end subroutine stop_thruster

   !> A tumbling body with everything that can be switched; x holds changes of the start and of parameters.
   subroutine build(x, limited, system, start)
      real(wp), intent(in) :: x(most)
      !> A controller acts too, up to a limit of its torque, and the speed of the wheel has one.
      logical, intent(in) :: limited
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: start
      type(wheel_t) :: wheel
      type(controller_t) :: controller
      type(status_t) :: status
      real(wp) :: inertia(3, 3)
      inertia = reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3])
      inertia(1, 3) = inertia(1, 3) + x(3)
      inertia(3, 1) = inertia(1, 3)
      call make_body(inertia, system%body, status)
      associate (effects => system%effects)
         call effects%add(dipole_t([1.0_wp + x(4), -2.0_wp, 3.0_wp], [0.5_wp, 1.0_wp + x(5), -1.0_wp]))
         call effects%add(spring_t([0.5_wp, 0.0_wp, 0.5_wp], [2.0_wp, 1.0_wp, 0.0_wp], 3.0_wp + x(6), 0.5_wp))
         call effects%add(damping_t([0.3_wp + x(7), 0.2_wp, 0.4_wp]))
         call effects%add(applied_torque_t(name='torque', label='thruster', amplitude=[0.5_wp, 2.0_wp, -1.0_wp], &
                                           in_space=.true., frequency=0.4_wp + x(8)))
         call effects%add(rotor_t(name='rotor', momentum=[1.0_wp, 2.0_wp + x(9), -1.0_wp]))
         effects%potentials(1)%item%label = 'magnet'
         effects%potentials(2)%item%label = 'spring'
         effects%torques(1)%item%label = 'brake'
      end associate
      wheel = wheel_t(name='wheel', label='motor', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp + x(10), &
                      speed=5.0_wp, friction=0.02_wp)
      if (limited) then
         allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp]))
         wheel%speed_limit = 6.0_wp
         controller = controller_t(name='controller', limit=3.0_wp)
         controller%rate_gain = diagonal([1.2_wp, 1.2_wp, 1.2_wp])
         controller%attitude_gain = diagonal([2.0_wp, 2.0_wp, 2.0_wp])
         call system%effects%add(controller)
      else
         allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp], frequency=0.2_wp))
      end if
      call add_wheel(system, wheel, status)
      start = make_state(system, quat_product([0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], &
                                              quat_exp([0.5_wp*x(1), 0.0_wp, 0.0_wp])), &
                         [1.0_wp, -2.0_wp + x(2), 3.0_wp])
   end subroutine build

   !> The columns of `build`.
   subroutine list_variations(system, columns, error)
      type(system_t), intent(in) :: system
      type(variation_t), intent(out) :: columns(most)
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status(6)
      real(wp), parameter :: e(3) = [1.0_wp, 0.0_wp, 0.0_wp]
      columns(1) = attitude_variation(1)
      columns(2) = rate_variation(2)
      columns(3) = inertia_variation(1, 3)
      call columns(4)%add(system%effects, 'dipole', 1, 'moment', e, status(1))
      call columns(5)%add(system%effects, 'dipole', 1, 'field', [0.0_wp, 1.0_wp, 0.0_wp], status(2))
      call columns(6)%add(system%effects, 'spring', 1, 'stiffness', [1.0_wp], status(3))
      call columns(7)%add(system%effects, 'damping', 1, 'coefficient', e, status(4))
      call columns(8)%add(system%effects, 'torque', 1, 'frequency', [1.0_wp], status(5))
      columns(9)%rotor = [0.0_wp, 1.0_wp, 0.0_wp]
      call columns(10)%add(system%effects, 'wheel', 1, 'inertia', [1.0_wp], status(6))
      call check(error, all(status%code == 0), 'columns: '//trim(status(1)%message))
   end subroutine list_variations

   !> A switch of each effect at a quantity of each kind.
   subroutine cross_switches(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_list_t) :: events
      type(run_plan_t) :: plan
      integer :: i
      call events%add(rate_event_t(name='rate', axis=3, level=2.0_wp, effect='magnet', action=SWITCH_TOGGLE))
      call events%add(tilt_event_t(name='tilt', level=0.2_wp, effect='brake', action=SWITCH_TOGGLE))
      call add_columns(events, 'theta', 0.0_wp, 'thruster', EXTREMUM)
      call add_columns(events, 'kinetic', 44.0_wp, 'spring')
      call add_columns(events, 'psi', 1.0_wp, 'motor')
      do i = 1, size(methods)
         if (allocated(error)) return
         if (.not. in_turn(i)) cycle
         plan = run_plan_t(time_step=0.02_wp, end_time=2.0_wp)
         call compare(error, methods(i), plan, .false., events, [1, 2, 3, 4, 5], 5e-9_wp)
      end do
      ! The shift may change the acceptance of a step: differences then have the error of the steps.
      plan = run_plan_t(end_time=2.0_wp)
      plan%goal%local_tolerance = 1e-12_wp
      if (.not. allocated(error)) &
         call compare(error, methods(1), plan, .false., events, [1, 2, 3, 4, 5], 1e-7_wp)
      if (.not. allocated(error)) call compare(error, methods(5), plan, .false., events, [1, 2, 3, 4, 5], 1e-7_wp)
   end subroutine cross_switches

   !> Quantities that have parameters of their own, without switches.
   subroutine differ_times(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_list_t) :: events
      call add_columns(events, 'potential', 0.0_wp)
      call add_columns(events, 'total', 45.0_wp)
      call add_columns(events, 'L1', 8.0_wp)
      call add_columns(events, 'wheel1_momentum', 3.0_wp)
      call add_columns(events, 'phi', 3.0_wp)
      call add_columns(events, 'psi', 1.0_wp)
      call add_columns(events, 'potential', 0.0_wp, kind=MAXIMUM)
      call add_columns(events, 'wheel1_speed', 0.0_wp, kind=EXTREMUM)
      call compare(error, methods(3), run_plan_t(time_step=0.02_wp, end_time=2.0_wp), .false., events, &
                   [1, 2, 3, 4, 5, 6, 7, 8], 3e-8_wp)
   end subroutine differ_times

   !> Adds an event of a column: a crossing of either direction, or what else it is.
   subroutine add_columns(events, name, level, effect, kind)
      type(event_list_t), intent(inout) :: events
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: level
      !> Effect that is toggled.
      character(len=*), intent(in), optional :: effect
      integer, intent(in), optional :: kind
      type(column_event_t) :: event
      event%name = name
      event%columns(1) = name
      event%level = level
      if (any(name == ['phi', 'psi'])) event%period = 2*pi
      if (present(kind)) event%kind = kind
      if (present(effect)) then
         event%effect = effect
         event%action = SWITCH_TOGGLE
      end if
      call event%place()
      call events%add(event)
   end subroutine add_columns

   !> All columns at the end, the work and the times of events, against differences of runs by ±h and ±½h, extrapolated.
   subroutine compare(error, settings, plan, limited, events, expected, bound)
      type(error_type), allocatable, intent(inout) :: error
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      logical, intent(in) :: limited
      type(event_list_t), intent(in) :: events
      !> Numbers of the events that must happen.
      integer, intent(in) :: expected(:)
      !> Bound of differences relative to the largest entry of a column.
      real(wp), intent(in) :: bound
      real(wp), parameter :: parts(4) = [1.0_wp, -1.0_wp, 0.5_wp, -0.5_wp], shift = 2e-4_wp
      type(variation_t) :: columns(most)
      type(system_t) :: system
      type(state_t) :: start, ends(4)
      type(status_t) :: status
      class(run_t), allocatable :: run, plain, shifted
      type(keeper_t) :: keeper, other(4)
      real(wp) :: x(most), work(4), column(8), difference(8)
      character(len=40) :: label
      integer :: i, j, k
      allocate (run, plain, shifted)
      call build([(0.0_wp, j=1, most)], limited, system, start)
      call list_variations(system, columns, error)
      keeper%wants_tangent = .true.
      call go(run, system, start, settings, plan, events, keeper, status, columns)
      call check(error, status%ok(), trim(status%message))
      call go(plain, system, start, settings, plan, events, other(1), status)
      if (allocated(error)) return
      ! Adaptive steps of explicit methods and series are chosen by the columns too.
      if (settings%method == 'nielsen_krenk' .or. .not. plan%goal%active()) &
         call check(error, all(abs([run%state%q - plain%state%q, run%state%p - plain%state%p]) <= 0.0_wp) .and. &
                    all(abs(keeper%times - other(1)%times) <= 0.0_wp), 'bits of the state and of times')
      do i = 1, size(expected)
         call check(error, run%events%watched(expected(i))%number > 0_long, 'event happens')
      end do
      do k = 1, most
         do i = 1, 4
            x = parts(i)*shift*[(merge(1, 0, j == k), j=1, most)]
            call build(x, limited, system, start)
            other(i) = keeper_t()
            call go(shifted, system, start, settings, plan, events, other(i), status)
            call check(error, status%ok() .and. other(i)%n == keeper%n, 'shifted: '//trim(status%message))
            if (allocated(error)) return
            ends(i) = shifted%state
            work(i) = total_work(shifted%summary)
         end do
         write (label, '(a,1x,a,i3)') trim(settings%method), trim(settings%formulation), k
         difference = (4*difference_of(ends(3), ends(4), work(3) - work(4), 0.5_wp*shift) &
                       - difference_of(ends(1), ends(2), work(1) - work(2), shift))/3
         column = [run%tangent%theta(k, :), run%tangent%momentum(k, :), run%tangent%work(k), run%tangent%wheels(k, 1)]
         call check_below(error, maxval(abs(column - difference))/maxval(abs(column)), bound, trim(label))
         call check(error, all(keeper%known(:keeper%n)), 'times have derivatives')
         associate (times => (8*(other(3)%times - other(4)%times) - (other(1)%times - other(2)%times))/(6*shift))
            do i = 1, keeper%n
               call check_below(error, abs(keeper%changes(k, i) - times(i))/max(1.0_wp, maxval(abs(times))), bound, &
                                trim(label)//' time')
            end do
         end associate
      end do
   end subroutine compare

   !> (q1, L1, work, h1) against (q2, L2, work, h2) over twice a shift; shape (8).
   pure function difference_of(one, other, work, shift) result(difference)
      type(state_t), intent(in) :: one, other
      real(wp), intent(in) :: work, shift
      real(wp) :: difference(8), turn(4)
      turn = quat_product(quat_conjugate(other%q), one%q)
      difference = [turn(2:4)/shift, (body_momentum(one) - body_momentum(other))/(2*shift), work/(2*shift), &
                    (one%wheel_momentum(1) - other%wheel_momentum(1))/(2*shift)]
   end function difference_of

   !> The torque of a controller comes to its limit and leaves it, the wheel comes to the limit of its speed.
   subroutine cross_limits(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_list_t) :: events
      ! The limits are those of the wheel's speed, of the sign of e0, of two components of the torque.
      call compare(error, methods(3), run_plan_t(time_step=0.02_wp, end_time=2.0_wp), .true., events, &
                   [3, 4, 5, 7, 16], 5e-9_wp)
      if (.not. allocated(error)) &
         call compare(error, methods(1), run_plan_t(time_step=0.02_wp, end_time=2.0_wp), .true., events, &
                      [3, 4, 5, 7, 16], 5e-9_wp)
   end subroutine cross_limits

   !> Six columns forward, and six backward over the same switches: their product is the unit matrix, by steps of order
   !> 2 too, which are reversible.
   subroutine go_there_and_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start
      type(event_list_t) :: events
      class(run_t), allocatable :: there, back
      type(run_plan_t) :: plan
      type(keeper_t) :: keeper, backward
      type(status_t) :: status
      type(variation_t) :: columns(6)
      real(wp) :: unit(6, 6), first(6, 6), second(6, 6)
      integer :: k
      system => new_system()
      allocate (there, back)
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), system%body, status)
      call system%effects%add(dipole_t([1.0_wp, -2.0_wp, 3.0_wp], [0.5_wp, 1.0_wp, -1.0_wp]))
      call system%effects%add(applied_torque_t(name='torque', label='thruster', amplitude=[0.5_wp, 2.0_wp, -1.0_wp]))
      system%effects%potentials(1)%item%label = 'magnet'
      start = make_state(system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -2.0_wp, 3.0_wp])
      call events%add(rate_event_t(name='rate', axis=1, level=0.5_wp, effect='magnet', action=SWITCH_TOGGLE))
      call events%add(tilt_event_t(name='tilt', level=0.2_wp, effect='thruster', action=SWITCH_TOGGLE))
      do k = 1, 3
         columns(k) = attitude_variation(k)
         columns(3 + k) = rate_variation(k)
      end do
      plan = run_plan_t(time_step=0.05_wp, end_time=4.0_wp)
      call go(there, system, start, integrator_settings_t(method='nielsen_krenk', order=2), plan, events, keeper, &
              status, columns)
      call check(error, status%ok(), trim(status%message))
      call check(error, keeper%n >= 3, 'switches')
      if (allocated(error)) return
      plan%time_step = -plan%time_step
      plan%end_time = 0.0_wp
      call go(back, there%events%system, there%state, integrator_settings_t(method='nielsen_krenk', order=2), plan, &
              events, backward, status, columns)
      call check(error, status%ok() .and. backward%n == keeper%n, trim(status%message))
      if (allocated(error)) return
      first(1:3, :) = transpose(there%tangent%theta)
      first(4:6, :) = transpose(there%tangent%momentum)
      second(1:3, :) = transpose(back%tangent%theta)
      second(4:6, :) = transpose(back%tangent%momentum)
      unit = 0.0_wp
      do k = 1, 3
         unit(k, k) = 1.0_wp
         unit(3 + k, 3 + k) = system%body%moments(k)
         second(:, 3 + k) = second(:, 3 + k)/system%body%moments(k)
      end do
      ! Round-off of the products, and the times of events to 1e-15 s.
      call check_below(error, maxval(abs(matmul(second, first) - unit))/(maxval(abs(first))*maxval(abs(second))), &
                       1e-13_wp, 'there and back')
   end subroutine go_there_and_back

   !> A rotation that turns back at an angle, 2e-15 rad beyond its level: the event happens, its time has no
   !> derivative, and a switch there ends the run. The minimum there has one.
   subroutine touch_level(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start
      type(event_list_t) :: rotating, touching, switching
      class(run_t), allocatable :: run
      type(run_plan_t) :: plan
      type(keeper_t) :: keeper
      type(status_t) :: status
      real(wp) :: level
      system => new_system()
      allocate (run)
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), system%body, status)
      call system%effects%add(applied_torque_t(name='torque', label='thruster', amplitude=[0.0_wp, 0.0_wp, 1.0_wp]))
      start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, -1.0_wp])
      plan = run_plan_t(time_step=0.3_wp, end_time=1.5_wp)
      call rotating%add(angle_event_t(name='turn', kind=MINIMUM, stop=.true.))
      call go(run, system, start, methods(3), plan, rotating, keeper, status, [rate_variation(3)])
      call check(error, status%ok() .and. keeper%n == 1, 'turn: '//trim(status%message))
      if (allocated(error)) return
      ! t = -Ω0 J/τ; second differences are good to 1e-9.
      call check_close(error, keeper%changes(1, 1), -1.0_wp, 1e-8_wp, 'time of the minimum')
      level = 2*atan2(run%state%q(4), run%state%q(1)) + 2e-15_wp
      call touching%add(angle_event_t(name='touch', level=level, direction=-1))
      keeper = keeper_t()
      call go(run, system, start, methods(3), plan, touching, keeper, status, [rate_variation(3)])
      call check(error, status%ok() .and. keeper%n == 1, 'touch: '//trim(status%message))
      call check(error, .not. keeper%known(1), 'no derivative')
      call switching%add(angle_event_t(name='touch', level=level, direction=-1, effect='thruster', action=SWITCH_OFF))
      call go(run, system, start, methods(3), plan, switching, keeper, status, [rate_variation(3)])
      call check(error, index(status%message, "the event 'touch' only touches its level") > 0, trim(status%message))
      call go(run, system, start, methods(3), plan, switching, keeper, status)
      call check(error, status%ok(), 'without columns: '//trim(status%message))
   end subroutine touch_level

   !> A thruster against a brake, J = 2: the rate grows by 0.2 rad/s² up to 0.6, and falls from there on. The maximum is
   !> made by the switch, at t = (0.6 - Ω0)J/(τ - b).
   subroutine peak_at_switch(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start
      type(event_list_t) :: events
      type(variation_t) :: columns(2)
      type(keeper_t) :: keeper
      class(run_t), allocatable :: run
      type(status_t) :: status
      integer :: i
      system => new_system()
      allocate (run)
      call make_body(diagonal([1.5_wp, 1.5_wp, 2.0_wp]), system%body, status)
      call system%effects%add(applied_torque_t(name='torque', label='thruster', amplitude=[0.0_wp, 0.0_wp, 0.5_wp]))
      call system%effects%add(applied_torque_t(name='torque', label='brake', amplitude=[0.0_wp, 0.0_wp, -0.1_wp]))
      start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.2_wp])
      columns(1) = rate_variation(3)
      call columns(2)%add(system%effects, 'torque', 2, 'body', [0.0_wp, 0.0_wp, 1.0_wp], status)
      call events%add(rate_event_t(name='fast', level=0.6_wp, direction=1, effect='thruster', action=SWITCH_OFF))
      call events%add(rate_event_t(name='peak', kind=MAXIMUM))
      call go(run, system, start, methods(1), run_plan_t(time_step=0.3_wp, end_time=3.0_wp), events, keeper, status, &
              columns)
      call check(error, status%ok(), trim(status%message))
      call check(error, keeper%n, 2, 'events')
      if (allocated(error)) return
      do i = 1, 2
         call check_close(error, keeper%times(i), 2.0_wp, 1e-14_wp, 'time')
         ! Derivatives with respect to Ω0 and to the torque: -J/(τ - b), -0.4J/(τ - b)².
         call check_close(error, keeper%changes(:2, i), [-5.0_wp, -5.0_wp], 1e-11_wp, 'derivative of the time')
      end do
   end subroutine peak_at_switch

   !> A run from a checkpoint behind some switches on has the columns and the derivatives of one that was not
   !> interrupted, bit by bit.
   subroutine resume_times(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_list_t) :: events
      type(system_t), pointer :: system
      type(state_t) :: start
      type(run_plan_t) :: plan
      class(run_t), allocatable :: whole, broken, resumed
      type(keeper_t) :: keeper
      type(byte_archive_t) :: archive
      type(variation_t) :: columns(most)
      type(status_t) :: status
      real(wp), parameter :: nothing(most) = 0.0_wp
      integer :: i
      system => new_system()
      allocate (whole, broken, resumed)
      call build(nothing, .false., system, start)
      call list_variations(system, columns, error)
      call events%add(tilt_event_t(name='tilt', level=0.2_wp, effect='magnet', action=SWITCH_TOGGLE))
      call add_columns(events, 'psi', 1.0_wp)
      plan = run_plan_t(end_time=6.0_wp)
      plan%goal%local_tolerance = 1e-8_wp
      call go(whole, system, start, methods(1), plan, events, keeper, status, columns)
      call check(error, status%ok(), trim(status%message))
      keeper = keeper_t(stops_at=keeper%polls/2)
      call go(broken, system, start, methods(1), plan, events, keeper, status, columns)
      call check(error, status%code, NUTATE_STOPPED, 'the run is stopped')
      call check(error, allocated(keeper%archive) .and. keeper%n > 0, 'a checkpoint behind events')
      if (allocated(error)) return
      call archive%begin_reading(keeper%archive)
      call resumed%begin(system, methods(1), start, plan, status)
      if (status%ok()) call resumed%set_events(events, system, status)
      if (status%ok()) call resumed%differentiate(columns, system, status)
      if (status%ok()) call resumed%resume(archive, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      do i = 1, 2
         if (.not. broken%events%watched(i)%number > 0_long) cycle
         call check(error, all(abs(resumed%events%watched(i)%time_change - &
                                   broken%events%watched(i)%time_change) <= 0.0_wp), &
                    'derivatives at the checkpoint')
      end do
      call resumed%run_to_end(system, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, all(abs(resumed%state%q - whole%state%q) <= 0.0_wp), 'state')
      call check(error, maxval(abs(resumed%tangent%theta - whole%tangent%theta)) <= 0.0_wp, 'theta')
      call check(error, maxval(abs(resumed%tangent%work - whole%tangent%work)) <= 0.0_wp, 'work')
      do i = 1, 2
         call check(error, all(abs(resumed%events%watched(i)%time_change - &
                                   whole%events%watched(i)%time_change) <= 0.0_wp), &
                    'derivatives at the end')
      end do
   end subroutine resume_times

end submodule test_tangent_events
