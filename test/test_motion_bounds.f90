!> The bounds of motions, attacked: random bodies, effects, frames and wheels are followed finely, forward and backward,
!> and no column may change faster or be greater than the bounds from the start say, without the margins that events
!> leave; and runs that sleep by them find what runs find that look into every step.
submodule(suites_of_methods) test_motion_bounds
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_column_event, only: column_event_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: torque_t
   use nutate_effect_bounds, only: bounds_of_drag, effect_bounds_t, linear_map_t
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp
   use nutate_methods, only: default_settings
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_motion_bounds, only: bound_motion, motion_bounds_t, speed_bounds_t
   use nutate_rotor, only: rotor_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_attack_case, only: attack_case_t, draw_case, make_system
   use test_event_support, only: keeper_t, rate_event_t
   use test_problems, only: make_state, new_system, system_t
   use test_support, only: check, check_below, error_type, new_unittest, random_unit, random_vector, share_of
   implicit none

   !> Motions drawn, and a third of them. Rows of each.
   integer, parameter :: many = 600, rows = 100
   !> Longest turn between two rows, rad, that is followed to more than the digits that count; of the bound, for
   !> round-off and the errors of the reference; the margins of events, which the bounds have to do without here.
   real(wp), parameter :: followed = 0.15_wp, round_off = 1e-7_wp, noise = 1e-11_wp, margin_of_rates = 1.25_wp, &
                          margin_of_values = 1.01_wp

   !> Columns with a bound of their rate; the first `with_range` of them have one of their value too.
   integer, parameter :: n_columns = 31, with_range = 23, LAST_Q = 4, AT_THETA = 21, AT_WHEEL = 27
   character(len=16), parameter :: columns(n_columns) = [character(len=16) :: 'q0', 'q1', 'q2', 'q3', 'p0', 'p1', &
      'p2', 'p3', 'omega1', 'omega2', 'omega3', 'omega_x', 'omega_y', 'omega_z', 'L1', 'L2', 'L3', 'l_x', 'l_y', &
      'l_z', 'theta', 'kinetic', 'angular_speed', 'total', 'potential', 'jacobi', 'wheel1_speed', &
      'wheel1_momentum', 'wheel2_speed', 'wheel2_momentum', 'wheel3_speed']

   !> A torque -DΩ with a full D, which no scene has.
   type, extends(torque_t) :: full_drag_t
      !> D, body axes, N m s; shape (3,3).
      real(wp) :: drag(3, 3) = 0.0_wp
   contains
      procedure :: torque => drag_torque
      procedure :: bound => drag_bound
   end type full_drag_t

   !> Counts of the randomised stress test.
   type :: tally_t
      !> Motions assessed, and bounds that were compared and that were exceeded.
      integer :: motions = 0, compared = 0, exceeded = 0
      !> First exceeded bound: motion, column, and factor.
      integer :: motion = 0
      character(len=16) :: column = ''
      !> Number of comparisons of the bound of each column over a whole motion, and how many of these were within the
      !> factor `near` of the fastest rate, and of the greatest value; shape (n_columns).
      integer, dimension(n_columns) :: assessed = 0, near_rates = 0, near_values = 0
   end type tally_t
   real(wp), parameter :: near = 3.0_wp

contains

   module procedure collect_motion_bounds
      testsuite = [ &
                  new_unittest("no motion exceeds its bounds", no_motion_exceeds_its_bounds), &
                  new_unittest("bounds are near what they bound", bounds_are_near), &
                  new_unittest("a run that sleeps finds what one finds that does not", sleep_hides_nothing), &
                  new_unittest("what pulls apart without end has no bounds", no_bounds_without_end)]
   end procedure collect_motion_bounds

   pure function drag_torque(self, t, q, omega) result(tau)
      class(full_drag_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -matmul(self%drag, omega)
   end function drag_torque

   pure subroutine drag_bound(self, map, radius, gamma, slack, bounds)
      class(full_drag_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds = bounds_of_drag(map, radius, self%drag)
   end subroutine drag_bound

   integer function motions()
      motions = share_of(many)
   end function motions

   subroutine no_motion_exceeds_its_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      character(len=200) :: text
      call attack(motions(), tally)
      write (text, '(4(i0,a))') tally%exceeded, ' of ', tally%compared, ' bounds exceeded, first in motion ', &
         tally%motion, ' by '//trim(tally%column)//'; ', tally%motions, ' motions assessed'
      call check(error, tally%exceeded == 0, trim(text))
      call check(error, 3*tally%motions > 2*motions(), trim(text))
   end subroutine no_motion_exceeds_its_bounds

   !> A bound of the rates, over the whole motion, is within a factor of three for every column in one motion of twenty,
   !> that of the values in one of six; a bound that were always far off would not let a run sleep. It takes many.
   subroutine bounds_are_near(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      logical :: is_near
      integer :: i
      call attack(many, tally)
      ! One motion in ten has wheels: their speeds are assessed together.
      tally%near_rates(AT_WHEEL::2) = sum(tally%near_rates(AT_WHEEL::2))
      tally%assessed(AT_WHEEL::2) = sum(tally%assessed(AT_WHEEL::2))
      do i = 1, n_columns
         is_near = 20*tally%near_rates(i) > tally%assessed(i)
         if (i < AT_THETA) is_near = is_near .and. 6*tally%near_values(i) > tally%assessed(i)
         call check(error, is_near, 'far from '//columns(i))
      end do
   end subroutine bounds_are_near

   !> Checks that no bounds are reported if drag drives a body for so long that numbers overflow.
   subroutine no_bounds_without_end(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(status_t) :: status
      type(motion_t) :: motion
      type(motion_bounds_t) :: bounds
      type(speed_bounds_t) :: speeds
      system => new_system()
      call make_body(diagonal([1.0_wp, 2.0_wp, 2.5_wp]), system%body, status)
      call system%effects%add(damping_t([-1.0_wp, -1.0_wp, -1.0_wp]))
      call find_motion(system, make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 0.0_wp, 0.0_wp]), motion)
      bounds = bound_motion(system)
      speeds = bounds%within(motion, bounds%room(system, motion), 1.0_wp)
      call check(error, speeds%known .and. speeds%axis_speeds(1) >= exp(1.0_wp), 'driven for a second')
      speeds = bounds%within(motion, bounds%room(system, motion), 1000.0_wp)
      call check(error,.not. speeds%known, 'driven for a thousand')
   end subroutine no_bounds_without_end

   !> Levels next to extremes of a column, or between them, in runs of two hundred steps. An event that does not know
   !> its bounds keeps the second run awake.
   subroutine sleep_hides_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start
      type(keeper_t), allocatable :: asleep, awake
      type(event_list_t) :: events
      type(column_event_t) :: event
      type(integrator_settings_t) :: settings
      character(len=120) :: text
      real(wp) :: time
      integer(int64) :: seed
      integer :: number, found, i
      logical :: is_fit
      system => new_system()
      found = 0
      do number = 1, motions()
         call draw_motion(number, system, start, time, is_fit)
         if (.not. is_fit) cycle
         seed = ieor(2862933555777941757_int64, ishft(int(number, int64), 24) + number)
         call warm_up(seed)
         allocate (asleep, awake)
         call follow(system, start, time, awake, is_fit)
         if (is_fit) call draw_event(seed, system, awake, event, settings, is_fit)
         if (is_fit) then
            awake%n = 0
            events = event_list_t()
            call events%add(event)
            call run(events, asleep)
            call events%add(rate_event_t(level=1e30_wp))
            call run(events, awake)
            write (text, '(a,i0,4a,g0,2(a,i0))') 'motion ', number, ', ', trim(settings%method), ', ', &
               trim(event%columns(1))//' crosses ', event%level, ': ', asleep%n, ' times asleep, awake ', awake%n
            found = found + awake%n
            call check(error, asleep%n == awake%n, trim(text))
            call check_below(error, maxval(abs(asleep%times(1:asleep%n) - awake%times(1:awake%n))), &
                             1e-6_wp*abs(time)/rows, trim(text))
         end if
         deallocate (asleep, awake)
         if (allocated(error)) return
      end do
      call check(error, 3*found > motions(), 'too few events')

   contains

      subroutine run(events, keeper)
         type(event_list_t), intent(in) :: events
         type(keeper_t), intent(inout) :: keeper
         type(run_summary_t) :: summary
         type(status_t) :: status
         type(state_t) :: state
         state = start
         call integrate(system, settings, state, run_plan_t(time_step=0.5_wp*time/rows, end_time=start%t + time), &
                        status, keeper, summary, events)
         if (.not. status%ok()) keeper%n = -1
      end subroutine run

   end subroutine sleep_hides_nothing

   !> A column and a level that it comes to, or nearly; and a method.
   subroutine draw_event(seed, system, keeper, event, settings, is_fit)
      integer(int64), intent(inout) :: seed
      type(system_t), intent(in) :: system
      !> Observer with states of the motion.
      type(keeper_t), intent(in) :: keeper
      type(column_event_t), intent(out) :: event
      type(integrator_settings_t), intent(out) :: settings
      !> The column varies by more than the errors of a method.
      logical, intent(out) :: is_fit
      type(motion_t) :: motion
      real(wp) :: value, least, greatest, part
      integer :: i
      event%columns(1) = columns(1 + int(25*random_unit(seed)))
      call event%place()
      least = huge(least)
      greatest = -huge(greatest)
      do i = 0, keeper%rows - 1
         call find_motion(system, keeper%states(i), motion)
         value = event%value(system, motion)
         least = min(least, value)
         greatest = max(greatest, value)
      end do
      is_fit = greatest - least > 1e-3_wp*max(abs(least), abs(greatest))
      part = 10.0_wp**(-4*random_unit(seed))
      if (random_unit(seed) < 0.3_wp) part = -part
      if (random_unit(seed) < 0.5_wp) part = 1 - part
      event%level = least + part*(greatest - least)
      select case (int(6*random_unit(seed)))
      case (0)
         settings = default_settings('taylor')
      case (1)
         settings = default_settings('rk4')
      case (2)
         settings = default_settings('dop853')
      case (3)
         settings = default_settings('rk8')
      case default
         settings = integrator_settings_t(order=merge(4, 8, random_unit(seed) < 0.5_wp))
      end select
   end subroutine draw_event

   !> Draws motions 1 to n and compares them with their bounds.
   subroutine attack(n, tally)
      integer, intent(in) :: n
      type(tally_t), intent(out) :: tally
      type(system_t), pointer :: system
      type(state_t) :: start
      type(keeper_t), allocatable :: keeper
      type(column_event_t) :: events(n_columns)
      real(wp) :: time
      integer :: number, i
      logical :: is_fit
      do i = 1, n_columns
         events(i)%columns(1) = columns(i)
         call events(i)%place()
      end do
      system => new_system()
      do number = 1, n
         call draw_motion(number, system, start, time, is_fit)
         if (.not. is_fit) cycle
         allocate (keeper)
         call follow(system, start, time, keeper, is_fit)
         if (is_fit) call assess(number, system, keeper, events, tally)
         deallocate (keeper)
      end do
   end subroutine attack

   !> The first numbers of neighbouring seeds are alike.
   subroutine warm_up(seed)
      integer(int64), intent(inout) :: seed
      real(wp) :: dropped
      integer :: i
      do i = 1, 16
         dropped = random_unit(seed)
      end do
   end subroutine warm_up

   !> A system with bounds, a state, and for how long it is followed, s; negative: backward.
   subroutine draw_motion(number, system, start, time, is_fit)
      integer, intent(in) :: number
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: start
      real(wp), intent(out) :: time
      logical, intent(out) :: is_fit
      type(attack_case_t) :: drawn
      type(motion_bounds_t) :: bounds
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: rate, kind, drag(3, 3)
      integer :: i
      seed = ieor(1442695040888963407_int64, ishft(int(number, int64), 24) + number)
      call warm_up(seed)
      call draw_case(7, number, drawn)
      rate = norm2(drawn%omega)
      kind = random_unit(seed)
      if (kind < 0.35_wp) call make_symmetric(seed, drawn)
      call make_system(drawn, system, status)
      is_fit = status%ok()
      if (.not. is_fit) return
      if (kind < 0.35_wp) call add_along_axis(seed, rate, system)
      if (kind > 0.8_wp) call system%effects%add(rotating_frame_t(name='rotating_frame', rate=rate*random_vector(seed)))
      if (kind > 0.5_wp .and. kind < 0.85_wp) call add_wheels(seed, rate, system, is_fit)
      if (random_unit(seed) < 0.15_wp) then
         do i = 1, 3
            drag(:, i) = (0.3_wp*minval(system%body%moments)*rate)*random_vector(seed)
         end do
         call system%effects%add(full_drag_t(name='drag', drag=drag))
      end if
      bounds = bound_motion(system)
      is_fit = is_fit .and. bounds%known
      start = make_state(system, drawn%q, drawn%omega)
      start%t = drawn%t
      time = 10.0_wp**(2.5_wp*random_unit(seed) - 1.5_wp)/rate
      if (random_unit(seed) < 0.2_wp) time = -time
   end subroutine draw_motion

   !> Makes a body symmetric about an axis, near which it mostly spins, and leaves it one or no effect.
   subroutine make_symmetric(seed, drawn)
      integer(int64), intent(inout) :: seed
      type(attack_case_t), intent(inout) :: drawn
      integer :: axis
      axis = 1 + int(3*random_unit(seed))
      drawn%axes = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      drawn%moments = drawn%moments(1)
      drawn%moments(axis) = drawn%moments(1)*(0.1_wp + 1.8_wp*random_unit(seed))
      drawn%rotor = 0.0_wp
      drawn%n_effects = min(drawn%n_effects, int(2*random_unit(seed)))
      if (random_unit(seed) < 0.5_wp) then
         drawn%omega = 0.1_wp*drawn%omega
         drawn%omega(axis) = 10*drawn%omega(axis)
      end if
   end subroutine make_symmetric

   !> Effects along the axis of a symmetric body: a rotor, a torque, a field, which may also lie across it.
   subroutine add_along_axis(seed, rate, system)
      integer(int64), intent(inout) :: seed
      real(wp), intent(in) :: rate
      type(system_t), intent(inout) :: system
      real(wp) :: along(3), size
      integer :: axis
      along = 0.0_wp
      do axis = 1, 3
         if (count(abs(system%body%moments - system%body%moments(axis)) > 0.0_wp) == 2) along(axis) = 1.0_wp
      end do
      size = minval(system%body%moments)*rate*10.0_wp**(2*random_unit(seed) - 1.5_wp)
      if (random_unit(seed) < 0.3_wp) call system%effects%add(rotor_t(name='rotor', momentum=size*along))
      if (random_unit(seed) < 0.2_wp) call system%effects%add(applied_torque_t(amplitude=0.1_wp*size*rate*along))
      if (random_unit(seed) < 0.3_wp) along = random_vector(seed)
      if (random_unit(seed) < 0.7_wp) call system%effects%add(dipole_t(size*rate*along, [0.0_wp, 0.0_wp, 1.0_wp]))
   end subroutine add_along_axis

   !> One to three wheels with motors, in a body that is heavy enough for them.
   subroutine add_wheels(seed, rate, system, is_fit)
      integer(int64), intent(inout) :: seed
      real(wp), intent(in) :: rate
      type(system_t), intent(inout) :: system
      logical, intent(out) :: is_fit
      type(wheel_t) :: wheel
      type(status_t) :: status
      real(wp) :: least
      integer :: i
      least = minval(system%body%moments)
      do i = 1, 1 + int(3*random_unit(seed))
         wheel = wheel_t(name='wheel', inertia=0.2_wp*least*random_unit(seed), speed=5*rate*(2*random_unit(seed) - 1))
         wheel%axis = random_vector(seed)
         if (random_unit(seed) < 0.5_wp) wheel%axis = [0.0_wp, 0.0_wp, 1.0_wp]
         wheel%axis = wheel%axis/norm2(wheel%axis)
         if (random_unit(seed) < 0.7_wp) allocate (wheel%motor, source=applied_torque_t(amplitude= &
            [least*rate**2*(random_unit(seed) - 0.5_wp), 0.0_wp, 0.0_wp], frequency=rate*random_unit(seed)))
         call add_wheel(system, wheel, status)
         is_fit = status%ok()
         if (.not. is_fit) return
      end do
   end subroutine add_wheels

   !> Keeps states of a motion at equal times; fit if no step turns the body too far for its method.
   subroutine follow(system, start, time, keeper, is_fit)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: time
      type(keeper_t), intent(inout) :: keeper
      logical, intent(out) :: is_fit
      type(state_t) :: state
      type(motion_t) :: motion
      type(status_t) :: status
      integer :: i
      state = start
      call integrate(system, default_settings('dop853'), state, &
                     run_plan_t(time_step=time/rows, end_time=start%t + time), status, keeper)
      is_fit = status%ok()
      do i = 0, keeper%rows - 1
         call find_motion(system, keeper%states(i), motion)
         is_fit = is_fit .and. norm2(motion%omega)*abs(time) < followed*rows
      end do
   end subroutine follow

   !> Compares every row with what the first one bounds.
   subroutine assess(number, system, keeper, events, tally)
      integer, intent(in) :: number
      type(system_t), intent(in) :: system
      type(keeper_t), intent(in) :: keeper
      !> The columns, placed; the levels are set here. Shape (n_columns).
      type(column_event_t), intent(inout) :: events(:)
      type(tally_t), intent(inout) :: tally
      type(motion_bounds_t) :: bounds
      type(speed_bounds_t) :: speeds
      type(motion_t) :: first, motion
      real(wp) :: room, time, rate, value, scale, fastest(n_columns), greatest(n_columns)
      integer :: i, k
      bounds = bound_motion(system)
      call find_motion(system, keeper%states(0), first)
      room = bounds%room(system, first)
      fastest = 0.0_wp
      greatest = 0.0_wp
      tally%motions = tally%motions + 1
      do k = 1, keeper%rows - 1
         call find_motion(system, keeper%states(k), motion)
         call find_rates(system, motion%state%t, motion)
         time = abs(motion%state%t - first%state%t)
         speeds = bounds%within(first, room, time)
         if (.not. speeds%known) exit
         call compare(norm2(motion%omega), speeds%speed, '|omega|')
         call compare(norm2(motion%omega(1:2)), speeds%tilting, 'tilting')
         call compare(norm2(motion%momentum), speeds%momentum, '|L|')
         call compare(norm2(motion%torque + motion%potential_torque), speeds%torque, '|torque|')
         scale = size_of(motion, speeds)
         do i = 1, n_columns
            if (columns(i)(1:5) == 'wheel' .and. system%effects%n_wheels < 3) cycle
            associate (event => events(i))
               rate = abs(event%rate(system, motion))
               value = abs(event%value(system, motion))
               fastest(i) = max(fastest(i), rate)
               greatest(i) = max(greatest(i), value)
               event%level = 0.0_wp
               ! A conserved quantity changes by round-off.
               if (rate*time > noise*scale) &
                  call note(.not. event%is_out_of_reach(speeds, rate_to(rate), time), columns(i))
               if (i > with_range .or. .not. value > noise*scale) cycle
               event%level = value*margin_of_values*(1 - round_off)
               if (i == AT_THETA) event%level = value
               if (i <= LAST_Q) event%level = value*(1 - round_off)
               call note(.not. event%is_out_of_reach(speeds, 0.0_wp, time), columns(i))
            end associate
         end do
      end do
      if (speeds%known) call find_distances()

   contains

      !> A distance at which a quantity that changes at a rate is not safe.
      pure real(wp) function rate_to(rate)
         real(wp), intent(in) :: rate
         rate_to = margin_of_rates*rate*time*(1 - round_off)
      end function rate_to

      subroutine compare(actual, bound, what)
         real(wp), intent(in) :: actual, bound
         character(len=*), intent(in) :: what
         call note(actual*(1 - round_off) <= bound, what)
      end subroutine compare

      subroutine note(holds, what)
         logical, intent(in) :: holds
         character(len=*), intent(in) :: what
         tally%compared = tally%compared + 1
         if (holds) return
         if (tally%exceeded == 0) tally%motion = number
         if (tally%exceeded == 0) tally%column = what
         tally%exceeded = tally%exceeded + 1
      end subroutine note

      !> Counts the columns whose bounds are near what was reached.
      subroutine find_distances()
         do i = 1, n_columns
            if (.not. fastest(i) > 0.0_wp) cycle
            tally%assessed(i) = tally%assessed(i) + 1
            events(i)%level = 0.0_wp
            if (events(i)%is_out_of_reach(speeds, near*margin_of_rates*fastest(i)*time, time)) &
               tally%near_rates(i) = tally%near_rates(i) + 1
            events(i)%level = near*margin_of_values*greatest(i)
            if (events(i)%is_out_of_reach(speeds, 0.0_wp, time)) tally%near_values(i) = tally%near_values(i) + 1
         end do
      end subroutine find_distances

   end subroutine assess

   !> Returns the size of the quantities that columns are made of.
   pure real(wp) function size_of(motion, speeds) result(size)
      type(motion_t), intent(in) :: motion
      type(speed_bounds_t), intent(in) :: speeds
      associate (turn => max(1.0_wp, norm2(motion%omega)))
         size = 1 + turn*(turn + norm2(motion%momentum) + maxval(abs(motion%state%wheel_momentum)) + speeds%torque)
      end associate
   end function size_of

end submodule test_motion_bounds
