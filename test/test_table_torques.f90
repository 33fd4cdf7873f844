!> Tabulated torque: the steps that end on its times, the motion that follows, and the bounds of proofs.
submodule(suites_of_effects) test_table_torques
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_hamiltonian, only: make_state, system_t, total_energy
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use test_effect_samples, only: sample_body
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit
   implicit none

   !> Times that are no whole number of any step, s.
   real(wp), parameter :: odd_times(9) = [0.0137_wp, 0.0731_wp, 0.1973_wp, 0.3119_wp, 0.3307_wp, 0.5501_wp, 0.7333_wp, &
                                          0.8717_wp, 1.1031_wp]
   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], rate(3) = [0.7_wp, -1.1_wp, 0.9_wp]

contains

   module procedure collect_table_torques
      testsuite = [ &
                  new_unittest("steps end on the times of a table, both ways", breaks_are_found), &
                  new_unittest("a table of one value is a constant torque", constant_table_is_constant), &
                  new_unittest("a jump is two torques with a window", jump_is_two_torques), &
                  new_unittest("a periodic table is the table written out", periodic_table_is_written_out), &
                  new_unittest("pieces far from times of a periodic table lie between jumps", pieces_between_jumps), &
                  new_unittest("start and stop cut a table", window_cuts_a_table), &
                  new_unittest("other torques go on behind the end of a table", others_go_on), &
                  new_unittest("a fine table is the harmonic torque", fine_table_is_harmonic), &
                  new_unittest("orders 2 to 8 with times inside of the steps", orders_are_kept), &
                  new_unittest("the account closes for every method", account_closes), &
                  new_unittest("bounds hold for the torque and its derivatives", bounds_hold)]
   end procedure collect_table_torques

   !> Checks that each time is found in turn; those of a periodic table a thousand periods on.
   subroutine breaks_are_found(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      real(wp) :: t, expected, period
      integer :: i, sense, round
      torque = table_of(odd_times, periodic=.false.)
      do sense = -1, 1, 2
         t = merge(-7.0_wp, 7.0_wp, sense > 0)
         do i = 1, 9
            t = torque%next_break(t, real(sense, wp))
            call check_close(error, t, odd_times(merge(i, 10 - i, sense > 0)), 0.0_wp)
         end do
         call check(error, abs(torque%next_break(t, real(sense, wp))) > 1e300_wp, 'no more')
      end do
      torque = table_of(odd_times, periodic=.true.)
      period = odd_times(9) - odd_times(1)
      do sense = -1, 1, 2
         t = odd_times(1) + 1000*period - sense*1e-3_wp
         do i = 0, 20
            t = torque%next_break(t, real(sense, wp))
            round = 1000 + (sense*i - modulo(sense*i, 8))/8
            expected = odd_times(1 + modulo(sense*i, 8)) + round*period
            call check_close(error, t, expected, 8*eps*expected)
         end do
      end do
   end subroutine breaks_are_found

   !> Sines at the given times, the last the first.
   function table_of(times, spline, periodic, in_space, start, stop) result(torque)
      real(wp), intent(in) :: times(:)
      logical, intent(in), optional :: spline, periodic, in_space
      real(wp), intent(in), optional :: start, stop
      type(tabulated_torque_t) :: torque
      type(status_t) :: status
      real(wp) :: values(3, size(times))
      integer :: i, at
      do i = 1, size(times)
         values(:, i) = [3*sin(5*times(i)), 2*cos(7*times(i)), 1.5_wp*sin(3*times(i) + 1)]
      end do
      values(:, size(times)) = values(:, 1)
      call make_tabulated_torque(times, values, torque, status, at, spline, periodic, in_space, start, stop)
   end function table_of

   !> The motion of the sample body.
   subroutine run(torques, settings, plan, state, summary, status)
      class(tabulated_torque_t), intent(in) :: torques(:)
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      type(system_t), pointer :: system
      integer :: i
      system => sample_body()
      do i = 1, size(torques)
         call system%effects%add(torques(i))
      end do
      state = make_state(system, identity, rate)
      call integrate(system, settings, state, plan, status, summary=summary)
   end subroutine run

   !> Every way to step: orders of the composition by both solvers, Runge-Kutta, series; fixed steps and chosen ones.
   pure function methods() result(settings)
      type(integrator_settings_t) :: settings(8)
      settings(1) = integrator_settings_t()
      settings(2) = integrator_settings_t(formulation='reduced')
      settings(3) = integrator_settings_t(order=4)
      settings(4) = integrator_settings_t(order=6, formulation='reduced')
      settings(5) = integrator_settings_t(order=8)
      settings(6) = integrator_settings_t(method='rk4', order=4, conserve=.true.)
      settings(7) = integrator_settings_t(method='dop853', order=8, conserve=.true.)
      settings(8) = integrator_settings_t(method='taylor', order=16, conserve=.true.)
   end function methods

   subroutine constant_table_is_constant(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(applied_torque_t) :: constant
      type(system_t), pointer :: system
      type(state_t) :: state, expected
      type(run_summary_t) :: summary
      type(integrator_settings_t) :: settings(8)
      type(status_t) :: status
      integer :: i, at, space
      settings = methods()
      do space = 0, 1
         constant%amplitude = [0.5_wp, -1.0_wp, 2.0_wp]
         constant%in_space = space == 1
         call make_tabulated_torque([-1.0_wp, 5.0_wp], spread(constant%amplitude, 2, 2), torque, status, at, &
                                    in_space=constant%in_space)
         do i = 1, size(settings)
            call run([torque], settings(i), run_plan_t(time_step=0.05_wp, end_time=1.0_wp), state, summary, status)
            system => sample_body()
            call system%effects%add(constant)
            expected = make_state(system, identity, rate)
            call integrate(system, settings(i), expected, run_plan_t(time_step=0.05_wp, end_time=1.0_wp), status)
            ! A rounding of the momentum in each of the 20 steps.
            call check_close(error, [state%q, state%p], [expected%q, expected%p], 20*eps*norm2(expected%p), &
                             trim(settings(i)%method))
         end do
      end do
   end subroutine constant_table_is_constant

   !> One table whose torque jumps, and two that end and begin there.
   subroutine jump_is_two_torques(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: whole, parts(2)
      type(run_plan_t) :: plan
      type(state_t) :: state, expected
      type(run_summary_t) :: summary
      type(integrator_settings_t) :: settings(8)
      type(status_t) :: status
      real(wp) :: values(3, 4)
      real(wp), parameter :: times(4) = [0.113_wp, 0.527_wp, 0.527_wp, 0.907_wp]
      integer :: i, at, way
      values = reshape([1.0_wp, 2.0_wp, -1.0_wp, 0.5_wp, 0.0_wp, 3.0_wp, -2.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, &
                        1.0_wp], [3, 4])
      settings = methods()
      call make_tabulated_torque(times, values, whole, status, at)
      call make_tabulated_torque(times(1:2), values(:, 1:2), parts(1), status, at)
      call make_tabulated_torque(times(3:4), values(:, 3:4), parts(2), status, at)
      do i = 1, size(settings)
         do way = 1, 2
            plan = run_plan_t(time_step=0.04_wp, end_time=1.0_wp)
            if (way == 2) plan%goal%local_tolerance = 1e-6_wp
            call run([whole], settings(i), plan, state, summary, status)
            call check(error, status%ok(), trim(status%message))
            call run(parts, settings(i), plan, expected, summary, status)
            call check_close(error, [state%q, state%p], [expected%q, expected%p], 512*eps, trim(settings(i)%method))
         end do
      end do
   end subroutine jump_is_two_torques

   !> Three rounds written out, forward and backward; the values at the ends differ, so that there is a jump.
   subroutine periodic_table_is_written_out(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: round, out
      type(run_plan_t) :: plan
      type(state_t) :: state, expected
      type(run_summary_t) :: summary
      type(integrator_settings_t) :: settings(8)
      type(status_t) :: status
      real(wp) :: times(4), values(3, 4), all_times(28), all_values(3, 28)
      integer :: i, k, at, sense
      times = [0.0_wp, 0.0625_wp, 0.21875_wp, 0.34375_wp]
      values = reshape([1.0_wp, 2.0_wp, -1.0_wp, 0.5_wp, 0.0_wp, 3.0_wp, -2.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, &
                        1.0_wp], [3, 4])
      do k = 0, 6
         all_times(4*k + 1:4*k + 4) = times + (k - 3)*times(4)
         all_values(:, 4*k + 1:4*k + 4) = values
      end do
      settings = methods()
      call make_tabulated_torque(times, values, round, status, at, periodic=.true., in_space=.true.)
      call make_tabulated_torque(all_times, all_values, out, status, at, in_space=.true.)
      do i = 1, size(settings)
         do sense = -1, 1, 2
            plan = run_plan_t(time_step=sense*0.05_wp, end_time=sense*1.0_wp)
            call run([round], settings(i), plan, state, summary, status)
            call check(error, status%ok(), trim(status%message))
            call run([out], settings(i), plan, expected, summary, status)
            call check_close(error, [state%q, state%p], [expected%q, expected%p], 512*eps, trim(settings(i)%method))
         end do
      end do
   end subroutine periodic_table_is_written_out

   !> Checks that a periodic table of two values, whose times are rounded more than those of the run, has one value from
   !> end to end of each piece.
   subroutine pieces_between_jumps(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(status_t) :: status
      real(wp) :: t, moment, start, stop, values(3, 4), tau(3, 3)
      integer :: i, at
      values(:, :2) = -1.0_wp
      values(:, 3:) = 1.0_wp
      call make_tabulated_torque(1000 + [0.0_wp, 0.1_wp, 0.1_wp, 0.3_wp], values, torque, status, at, periodic=.true.)
      call check(error, status%ok(), status%message)
      t = -1.0_wp
      do i = 1, 20
         moment = t
         t = torque%next_break(t, 1.0_wp)
         moment = 0.5_wp*(moment + t)
         call torque%piece(moment, start, stop)
         tau(:, 1) = torque%torque(start, identity, rate)
         tau(:, 2) = torque%torque(moment, identity, rate)
         tau(:, 3) = torque%torque(stop, identity, rate)
         call check_close(error, tau(1, [1, 3]), tau(1, [2, 2]), 1e-9_wp)
      end do
   end subroutine pieces_between_jumps

   !> Cut where lines are, a table is the part of it.
   subroutine window_cuts_a_table(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: whole, part
      type(state_t) :: state, expected
      type(run_summary_t) :: summary
      type(status_t) :: status
      type(run_plan_t) :: plan
      real(wp) :: values(3, 7)
      integer :: i, at
      whole = table_of(odd_times, start=odd_times(2), stop=odd_times(8))
      do i = 1, 7
         values(:, i) = whole%torque(odd_times(i + 1), identity, rate)
      end do
      call make_tabulated_torque(odd_times(2:8), values, part, status, at)
      plan = run_plan_t(time_step=0.05_wp, end_time=1.5_wp)
      call run([whole], integrator_settings_t(order=4), plan, state, summary, status)
      call run([part], integrator_settings_t(order=4), plan, expected, summary, status)
      call check_close(error, [state%q, state%p], [expected%q, expected%p], 64*eps)
      call check(error, .not. whole%acts_at(odd_times(1)) .and. whole%acts_at(0.5_wp) .and. .not. whole%acts_at(1.0_wp))
   end subroutine window_cuts_a_table

   !> A table that has ended, beside a harmonic torque: the motion is that of both after one another, for every method.
   subroutine others_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: table
      type(applied_torque_t) :: harmonic
      type(system_t), pointer :: alone
      type(system_t) :: both
      type(state_t) :: state, expected
      type(integrator_settings_t) :: settings(8)
      type(run_plan_t) :: plan
      type(status_t) :: status
      integer :: i
      settings = methods()
      table = table_of(odd_times)
      harmonic%amplitude = [0.5_wp, -0.2_wp, 0.8_wp]
      harmonic%frequency = 0.7_wp
      alone => sample_body()
      call alone%effects%add(harmonic)
      both = alone
      call both%effects%add(table)
      do i = 1, size(settings)
         state = make_state(both, identity, rate)
         call integrate(both, settings(i), state, run_plan_t(time_step=0.05_wp, end_time=1.2_wp), status)
         expected = state
         plan = run_plan_t(time_step=0.05_wp, end_time=2.0_wp)
         call integrate(both, settings(i), state, plan, status)
         call integrate(alone, settings(i), expected, plan, status)
         call check_close(error, [state%q, state%p], [expected%q, expected%p], 64*eps, trim(settings(i)%method))
      end do
   end subroutine others_go_on

   !> A periodic spline through a cosine is off by h⁴ω⁴/384 at most; so is the motion, times torque over inertia.
   subroutine fine_table_is_harmonic(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(applied_torque_t) :: harmonic
      type(system_t), pointer :: system
      type(state_t) :: state, expected
      type(run_summary_t) :: summary
      type(status_t) :: status
      real(wp) :: times(129), values(3, 129), angle
      integer :: i, at, space
      harmonic%amplitude = [0.5_wp, -0.2_wp, 0.8_wp]
      harmonic%frequency = 1.0_wp
      do i = 1, 129
         times(i) = (i - 1)/128.0_wp
         angle = 2*pi*modulo(i - 1, 128)/128.0_wp
         values(:, i) = harmonic%amplitude*cos(angle)
      end do
      do space = 0, 1
         harmonic%in_space = space == 1
         call make_tabulated_torque(times, values, torque, status, at, spline=.true., periodic=.true., &
                                    in_space=harmonic%in_space)
         call run([torque], integrator_settings_t(method='taylor', order=16, conserve=.true.), &
                  run_plan_t(end_time=3.0_wp, goal=run_goal_t(local_tolerance=1e-14_wp)), state, summary, status)
         system => sample_body()
         call system%effects%add(harmonic)
         expected = make_state(system, identity, rate)
         call integrate(system, integrator_settings_t(method='taylor', order=16, conserve=.true.), expected, &
                        run_plan_t(end_time=3.0_wp, goal=run_goal_t(local_tolerance=1e-14_wp)), status)
         call check_below(error, attitude_distance(state%q, expected%q), 3.0_wp*(2*pi/128)**4/384)
         call check(error, attitude_distance(state%q, expected%q) > 1e-13_wp, 'the spline is another torque')
      end do
   end subroutine fine_table_is_harmonic

   !> Slope of the error over one halving: every step has lines inside, at times that are none of its own.
   subroutine orders_are_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(state_t) :: exact, once, twice
      type(run_summary_t) :: summary
      type(status_t) :: status
      real(wp) :: slope
      integer, parameter :: orders(7) = [2, 4, 6, 8, 4, 8, 6], steps(7) = [128, 96, 48, 28, 96, 32, 48]
      character(len=13), parameter :: names(7) = [character(len=13) :: 'nielsen_krenk', 'nielsen_krenk', &
                                                  'nielsen_krenk', 'nielsen_krenk', 'rk4', 'dop853', 'taylor']
      integer :: i, kind
      do kind = 1, 4
         torque = table_of(8*odd_times, spline=kind > 2, periodic=.true., in_space=mod(kind, 2) == 0)
         call run([torque], integrator_settings_t(method='taylor', order=16, conserve=.true.), &
                  run_plan_t(end_time=8.0_wp, goal=run_goal_t(local_tolerance=1e-16_wp)), exact, summary, status)
         do i = 1, size(orders)
            associate (settings => integrator_settings_t(method=names(i), order=orders(i), &
                                                         series_order=merge(orders(i), 0, names(i) == 'taylor')))
               call run([torque], settings, run_plan_t(time_step=8.0_wp/steps(i), end_time=8.0_wp), once, summary, &
                        status)
               call run([torque], settings, run_plan_t(time_step=4.0_wp/steps(i), end_time=8.0_wp), twice, summary, &
                        status)
            end associate
            slope = log(attitude_distance(once%q, exact%q)/attitude_distance(twice%q, exact%q))/log(2.0_wp)
            ! Parts beside a line do not halve with the step, which blurs the slope.
            call check_below(error, orders(i) - slope, 0.6_wp, trim(names(i)))
         end do
      end do
   end subroutine orders_are_kept

   !> Energy less work, for every method, table and way to step, and a step back in time.
   subroutine account_closes(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(integrator_settings_t) :: settings(8)
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(system_t), pointer :: system
      type(run_plan_t) :: plan
      type(status_t) :: status
      real(wp) :: first, scale
      integer :: i, kind, way
      settings = methods()
      system => sample_body()
      first = total_energy(system, make_state(system, identity, rate), 0.0_wp)
      do kind = 1, 4
         torque = table_of(odd_times, spline=kind > 2, periodic=.true., in_space=mod(kind, 2) == 0)
         do i = 1, size(settings)
            do way = -1, 1
               plan = run_plan_t(time_step=way*0.07_wp, end_time=merge(-3.0_wp, 3.0_wp, way < 0))
               if (way == 0) plan%goal%local_tolerance = 1e-5_wp
               call run([torque], settings(i), plan, state, summary, status)
               call check(error, status%ok(), trim(status%message))
               scale = max(first, total_energy(system, state, 0.0_wp))
               call check_below(error, abs(total_energy(system, state, 0.0_wp) - first - sum(summary%work)), &
                                1e-13_wp*scale, trim(settings(i)%method))
            end do
         end do
      end do
   end subroutine account_closes

   !> T(b) of the step, its derivative by b and by time, at random places.
   subroutine bounds_hold(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: torque
      type(effect_bounds_t) :: bounds
      type(linear_map_t) :: map
      real(wp) :: b(3), shift(3), t, at, radius
      real(wp), parameter :: origin(3) = 0.0_wp, h = 1e-4_wp
      integer(int64) :: seed
      integer :: i, kind
      seed = 17
      map%matrix = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      map%norm = 1.0_wp
      do kind = 1, 4
         torque = table_of(odd_times, spline=kind > 2, periodic=.true., in_space=mod(kind, 2) == 0)
         do i = 1, 2000
            radius = 0.9_wp*random_unit(seed)
            b = [random_unit(seed), random_unit(seed), random_unit(seed)] - 0.5_wp
            b = b*(radius/norm2(b))
            shift = [random_unit(seed), random_unit(seed), random_unit(seed)] - 0.5_wp
            shift = shift*(h/norm2(shift))
            t = odd_times(1) + 1.08_wp*random_unit(seed)
            at = t + h
            if (torque%next_break(t - h, 1.0_wp) <= at) cycle
            call torque%bound(map, radius + h, origin, 2.0_wp, bounds)
            call check_below(error, norm2(entering(b, t)), bounds%force, 'force')
            call check_below(error, norm2(entering(b + shift, t) - entering(b - shift, t))/(2*h), bounds%slope, 'slope')
            call check_below(error, norm2(entering(b + shift, t) + entering(b - shift, t) - 2*entering(b, t))/h**2, &
                             bounds%curvature*(1 + 1e-3_wp), 'curvature')
            call check_below(error, norm2(entering(b, at) - entering(b, t - h))/(2*h), bounds%change*(1 + 1e-3_wp), &
                             'change')
            call check_below(error, norm2(entering(b, at) + entering(b, t - h) - 2*entering(b, t))/h**2, &
                             bounds%change_rate*(1 + 1e-3_wp) + 1e-5_wp, 'change of the change')
         end do
      end do
   contains
      !> T = (1+β)τ̄ - 2b(b·τ̄) at the attitude of mid step.
      function entering(b, t) result(force)
         real(wp), intent(in) :: b(3), t
         real(wp) :: force(3), tau(3)
         tau = torque%torque(t, [1.0_wp, b]/sqrt(1 + dot_product(b, b)), rate)
         force = (1 + dot_product(b, b))*tau - 2*dot_product(b, tau)*b
      end function entering
   end subroutine bounds_hold

end submodule test_table_torques
