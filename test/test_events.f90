!> Events against closed forms: when a box flips, when a top nutates, when a compass needle passes; what
!> ends a run; what is not noticed.
submodule(suites_of_methods) test_events
   use nutate_column_event, only: column_event_t
   use nutate_event, only: EXTREMUM, MAXIMUM, MINIMUM
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_methods, only: default_settings, methods
   use nutate_motion, only: displaced, find_motion, find_rates, motion_t
   use nutate_moving_frame, only: make_frame
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quantities, only: names_for
   use nutate_quantity, only: AS_EVENT
   use nutate_quaternion, only: quat_product
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_spelling, only: split_list
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_NOT_FINITE
   use nutate_integrator_settings, only: integrator_settings_t
   use test_event_support, only: angle_event_t, compass, keeper_t, lost_event_t, no_effects, rate_event_t, tilt_event_t
   use test_problems, only: box, fast_top, forced_body, make_state, problem_t, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> First zeros of Ω3 of the box, K/λ and odd multiples.
   real(wp), parameter :: quarter = 0.9664094834075236482704_wp

contains

   module procedure collect_events
      testsuite = [ &
                  new_unittest("the series finds the flips of the box to 1e-12", flips_of_series), &
                  new_unittest("times have the order of the method", orders_of_times), &
                  new_unittest("extremes of the nutation of a top", nutation_extremes), &
                  new_unittest("a needle passes north, and a grazing pair is found", needle), &
                  new_unittest("wraps of an angle are no crossings", wraps), &
                  new_unittest("steps, rows and their bits are the same with events", unnoticed), &
                  new_unittest("stop ends the run at the event, count at the n-th", stop_and_count), &
                  new_unittest("the invariants of states at events are those of the run", invariants_at_events), &
                  new_unittest("rates of columns are those of their values", column_rates), &
                  new_unittest("directions count", directions), &
                  new_unittest("a quantity that is not a number ends the run", no_number)]
   end procedure collect_events

   !> Zeros of Ω3 of the box by a method with fixed steps.
   subroutine flip(settings, dt, end_time, keeper, status)
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: dt, end_time
      type(keeper_t), intent(inout) :: keeper
      type(status_t), intent(out) :: status
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      problem => box()
      call events%add(rate_event_t(name='flip'))
      call integrate(problem%system, settings, problem%start, run_plan_t(time_step=dt, end_time=end_time), status, &
         keeper, &
                     events=events)
   end subroutine flip

   !> Ω3 of the box falls through zero after `quarter`, and is 10 rad/s at the start.
   subroutine no_number(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: names(3) = [character(len=13) :: 'nielsen_krenk', 'taylor', 'dop853']
      real(wp), parameter :: least(3) = [-huge(1.0_wp), 0.0_wp, 20.0_wp], ends(3) = [2.0_wp, quarter, 0.0_wp]
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(status_t) :: status
      type(state_t) :: state
      integer :: i, k
      do i = 1, size(names)
         do k = 1, size(least)
            problem => box()
            if (allocated(events%slots)) deallocate (events%slots)
            call events%add(lost_event_t(name='lost', least=least(k)))
            state = problem%start
            call integrate(problem%system, default_settings(trim(names(i))), state, &
                           run_plan_t(time_step=0.05_wp, end_time=2.0_wp), status, events=events)
            call check(error, status%code == NUTATE_NOT_FINITE .eqv. k > 1, trim(names(i))//': '//trim(status%message))
            if (k > 1) call check(error, index(status%message, "the quantity of the event 'lost'") > 0, &
                                  trim(status%message))
            call check_below(error, abs(state%t - ends(k)), 0.1_wp, 'end of the run')
         end do
      end do
   end subroutine no_number

   subroutine flips_of_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(status_t) :: status
      integer :: i
      allocate (keeper)
      call flip(default_settings('taylor'), 0.01_wp, 10.0_wp, keeper, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, keeper%n, 5, 'number of flips')
      call check_close(error, keeper%times(1), quarter, 1e-12_wp, 'first flip')
      do i = 2, 5
         call check_close(error, keeper%times(i), (2*i - 1)*quarter, 1e-11_wp, 'flip')
         call check(error, int(keeper%numbers(i)), i, 'number')
      end do
   end subroutine flips_of_series

   !> The error of the first time falls by 2^order.
   subroutine orders_of_times(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(integrator_settings_t) :: settings
      type(status_t) :: status
      real(wp) :: errors(2), dt
      logical :: is_explicit
      integer :: row, k
      do row = 1, size(methods)
         if (methods(row)%name == 'taylor' .or. methods(row)%order == 0) cycle
         settings = default_settings(methods(row)%name)
         settings%order = methods(row)%order
         settings%formulation = methods(row)%formulation
         settings%conserve = methods(row)%projected
         do k = 1, 2
            dt = 0.02_wp/k
            is_explicit = methods(row)%projected .or. .not. methods(row)%conserving
            if (methods(row)%order == 8) dt = merge(0.16_wp, 0.08_wp, is_explicit)/k
            if (methods(row)%order == 6) dt = 0.04_wp/k
            allocate (keeper)
            call flip(settings, dt, 1.2_wp, keeper, status)
            call check(error, status%ok(), trim(status%message))
            call check(error, keeper%n, 1, 'one flip')
            errors(k) = abs(keeper%times(1) - quarter)
            deallocate (keeper)
         end do
         call check(error, log(errors(1)/max(errors(2), eps))/log(2.0_wp) > methods(row)%order - 0.5_wp, &
                    trim(methods(row)%name)//' '//trim(methods(row)%formulation)//': order of the times')
      end do
   end subroutine orders_of_times

   subroutine nutation_extremes(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: half = 0.1458052640922589056376_wp
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(status_t) :: status
      integer :: i
      problem => fast_top()
      ! Gravity of the reference.
      call events%add(tilt_event_t(name='lowest', kind=MINIMUM))
      call events%add(tilt_event_t(name='highest', kind=MAXIMUM))
      allocate (keeper)
      call integrate(problem%system, default_settings('taylor'), problem%start, &
                     run_plan_t(time_step=1e-3_wp, end_time=0.9_wp), status, keeper, events=events)
      call check(error, status%ok(), trim(status%message))
      call check(error, keeper%n, 6, 'three of each')
      do i = 1, 6
         call check_close(error, keeper%times(i), i*half, 1e-11_wp, 'extremum of the nutation')
         call check(error, keeper%which(i), merge(1, 2, mod(i, 2) == 1), 'lowest and highest in turn')
      end do
   end subroutine nutation_extremes

   subroutine needle(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: zero = 1.163636428084856387067_wp, graze(2) = [4.651033272447943756403_wp, &
                                                                            4.658058152230907340134_wp]
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(status_t) :: status
      integer :: i
      problem => compass()
      call events%add(angle_event_t(name='north', period=2*pi))
      call events%add(angle_event_t(name='graze', level=149.999_wp*pi/180, period=2*pi))
      allocate (keeper)
      call integrate(problem%system, default_settings('taylor'), problem%start, &
                     run_plan_t(time_step=0.05_wp, end_time=9.0_wp), status, keeper, events=events)
      call check(error, status%ok(), trim(status%message))
      ! Released at rest above the grazing value, it passes it at once.
      call check(error, count(keeper%which(1:keeper%n) == 1), 4, 'passes of north')
      call check(error, count(keeper%which(1:keeper%n) == 2), 3, 'grazes')
      call check_close(error, pack(keeper%times(1:keeper%n), keeper%which(1:keeper%n) == 1), &
                       [(zero*(2*i - 1), i=1, 4)], 1e-11_wp, 'north')
      associate (times => pack(keeper%times(1:keeper%n), keeper%which(1:keeper%n) == 2))
         ! The slope there is 1e-2: errors of the angle count a hundredfold.
         call check_close(error, times(2:3), graze, 1e-10_wp, 'graze')
      end associate
   end subroutine needle

   !> A needle that turns over and over: the wrap at ±π is no crossing of 0.
   subroutine wraps(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(status_t) :: status
      integer :: i
      problem => compass()
      problem%system%effects = no_effects()
      problem%start = make_state(problem%system, [cos(0.5_wp), 0.0_wp, 0.0_wp, sin(0.5_wp)], [0.0_wp, 0.0_wp, 2.0_wp])
      call events%add(angle_event_t(name='north', period=2*pi))
      allocate (keeper)
      call integrate(problem%system, default_settings('taylor'), problem%start, &
                     run_plan_t(time_step=0.1_wp, end_time=20.0_wp), status, keeper, events=events)
      call check(error, keeper%n, 6, 'one in each turn')
      call check_close(error, keeper%times(1:6), [(pi*i - 0.5_wp, i=1, 6)], 1e-12_wp, 'every pi seconds')
   end subroutine wraps

   subroutine unnoticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: plain, watched
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(integrator_settings_t) :: settings
      type(run_plan_t) :: plan
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: row, goal, i
      call events%add(rate_event_t(name='over', axis=1))
      call events%add(rate_event_t(name='most', axis=2, kind=EXTREMUM))
      do row = 1, size(methods)
         do goal = 0, 1
            problem => forced_body()
            if (methods(row)%order == 0) problem => box()
            settings = default_settings(methods(row)%name)
            settings%order = methods(row)%order
            settings%formulation = methods(row)%formulation
            settings%conserve = methods(row)%projected
            plan = run_plan_t(time_step=0.03_wp, end_time=3.01_wp)
            if (goal == 1) plan = run_plan_t(end_time=3.01_wp, goal=run_goal_t(local_tolerance=1e-5_wp), &
               interval=0.07_wp)
            allocate (plain, watched)
            a = problem%start
            b = problem%start
            call integrate(problem%system, settings, a, plan, status, plain)
            call integrate(problem%system, settings, b, plan, status, watched, events=events)
            call check(error, status%ok(), trim(status%message))
            call check(error, watched%n > 1, trim(methods(row)%name)//': no events to speak of')
            call check(error, plain%rows, watched%rows, trim(methods(row)%name)//': rows')
            do i = 0, plain%rows - 1
               call check(error, all([plain%states(i)%q, plain%states(i)%p] == [watched%states(i)%q, &
                  watched%states(i)%p]), &
                          trim(methods(row)%name)//' '//trim(methods(row)%formulation)//' noticed')
            end do
            deallocate (plain, watched)
         end do
      end do
   end subroutine unnoticed

   subroutine stop_and_count(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(state_t) :: state
      type(status_t) :: status
      type(rate_event_t) :: event
      type(run_summary_t) :: summary
      integer :: i, goal
      do goal = 0, 1
         do i = 1, 2
            problem => box()
            state = problem%start
            event = rate_event_t(name='flip', stop=i == 1)
            if (i == 2) event%count = 3
            if (allocated(events%slots)) deallocate (events%slots)
            call events%add(event)
            allocate (keeper)
            if (goal == 0) then
               call integrate(problem%system, default_settings('taylor'), state, &
                              run_plan_t(time_step=0.01_wp, end_time=10.0_wp), status, keeper, summary, events)
            else
               call integrate(problem%system, integrator_settings_t(order=8), state, &
                              run_plan_t(end_time=10.0_wp, goal=run_goal_t(local_tolerance=1e-12_wp)), status, keeper, &
                              summary, events)
            end if
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            call check(error, keeper%n, merge(1, 3, i == 1), 'events')
            call check_close(error, state%t, merge(1, 5, i == 1)*quarter, 1e-9_wp, 'end')
            call check_close(error, keeper%states(keeper%rows - 1)%t, state%t, 0.0_wp, 'the last row is there')
            deallocate (keeper)
         end do
      end do
   end subroutine stop_and_count

   subroutine invariants_at_events(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      integer :: row
      call events%add(rate_event_t(name='over', axis=1))
      do row = 1, size(methods)
         if (methods(row)%order == 0 .or. .not. methods(row)%conserving) cycle
         problem => forced_body()
         settings = default_settings(methods(row)%name)
         settings%order = methods(row)%order
         settings%formulation = methods(row)%formulation
         settings%conserve = methods(row)%projected
         state = problem%start
         energy = total_energy(problem%system, state)
         allocate (keeper)
         call integrate(problem%system, settings, state, run_plan_t(time_step=0.03_wp, end_time=12.0_wp), status, &
            keeper, &
                        events=events)
         call check(error, keeper%n > 1 .and. status%ok(), trim(methods(row)%name)//': events')
         call check_below(error, maxval(abs(keeper%energies(1:keeper%n) - energy - keeper%works(1:keeper%n))), &
                          512*eps*maxval(abs(keeper%energies(1:keeper%n))), trim(methods(row)%name)//': account')
         deallocate (keeper)
      end do
   end subroutine invariants_at_events

   !> Central differences of sixth order along the tangent of the motion.
   subroutine column_rates(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 2e-3_wp, weights(3) = [45.0_wp/60, -9.0_wp/60, 1.0_wp/60]
      type(problem_t), pointer :: problem
      type(column_event_t) :: event
      type(motion_t) :: here, ahead, behind
      real(wp), parameter :: away(4) = [0.9_wp, 0.1_wp, -0.3_wp, 0.3_wp]
      real(wp) :: rate, change, bound
      integer :: i, k, n
      do k = 1, 4
         problem => forced_body()
         if (k == 2) call problem%system%effects%add(rotating_frame_t(name='rotating_frame', &
                                                                      rate=[0.3_wp, -0.5_wp, 0.4_wp]))
         if (k > 2) call add_orbit(problem%system, eccentricity=merge(0.3_wp, 0.0_wp, k == 3))
         ! Away from a pitch of 90 degrees.
         problem%start%q = quat_product(away, problem%start%q)
         problem%start%p = quat_product(away, problem%start%p)
         call add_frames(problem%system)
         call find_motion(problem%system, problem%start, here)
         call find_rates(problem%system, 0.0_wp, here)
         associate (names => split_list(names_for(AS_EVENT)))
            do n = 1, size(names)
               event%columns(1) = names(n)
               call event%place()
               rate = 0.0_wp
               do i = 1, 3
                  call find_motion(problem%system, displaced(here, i*h), ahead)
                  call find_motion(problem%system, displaced(here, -i*h), behind)
                  change = event%value(problem%system, ahead) - event%value(problem%system, behind)
                  ! Angles without a turn of 2π.
                  if (abs(change) > 1.9_wp*pi .and. abs(change) < 2.1_wp*pi) change = change - sign(2*pi, change)
                  rate = rate + weights(i)*change/h
               end do
               ! Differences are as good as h times the rates, which are greater next to an orbit.
               bound = merge(1e-9_wp, 1e-10_wp, k > 2)*max(1.0_wp, abs(rate))
               ! Next to the separatrix, where periods are infinite, h is long.
               if (index(event%columns(1), 'period') > 0) bound = 1e5_wp*bound
               call check_close(error, event%rate(problem%system, here), rate, bound, &
                                trim(event%columns(1)))
               if (allocated(error)) return
            end do
         end associate
      end do
   end subroutine column_rates

   !> Adds rotating frames: with known rates, without them, and one relative to which the scalar part is negative.
   subroutine add_frames(system)
      type(system_t), intent(inout) :: system
      real(wp) :: numbers(8, 2)
      integer :: i, far
      numbers(:, 1) = [-0.6_wp, 0.8_wp, 0.0_wp, 0.6_wp, 0.0_wp, 0.3_wp, -0.9_wp, 0.5_wp]
      numbers(:, 2) = [0.7_wp, 0.1_wp, 0.7_wp, 0.1_wp, 0.7_wp, -0.4_wp, 0.2_wp, 1.1_wp]
      system%effects%n_frames = 3
      allocate (system%effects%frames(3))
      do i = 1, 3
         if (i == 3) numbers(2:5, :) = -numbers(2:5, :)
         call make_frame(numbers(:merge(5, 8, i == 2), :), system%effects%frames(i), far)
      end do
   end subroutine add_frames

   !> Puts a system on an orbit, with its gravity gradient, behind a small body in the sun.
   subroutine add_orbit(system, eccentricity)
      type(system_t), intent(inout) :: system
      real(wp), intent(in) :: eccentricity
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      path = kepler_orbit_t(eccentricity=eccentricity, mu=2.0_wp, inclination=0.4_wp, raan=1.0_wp, mean_anomaly=2.0_wp)
      orbit = orbit_t(path, inertial=.false.)
      orbit%sun = [0.6_wp, 0.64_wp, 0.48_wp]
      orbit%shadow_radius = 0.5_wp
      call system%effects%add(orbit)
      if (eccentricity > 0.0_wp) then
         call system%effects%add(orbital_gradient_t(system%body, path))
      else
         call system%effects%add(gravity_gradient_t(system%body, orbit))
      end if
   end subroutine add_orbit

   subroutine directions(error)
      type(error_type), allocatable, intent(out) :: error
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(event_list_t) :: events
      type(status_t) :: status
      problem => box()
      call events%add(rate_event_t(name='down', direction=-1))
      call events%add(rate_event_t(name='up', direction=1))
      allocate (keeper)
      call integrate(problem%system, default_settings('taylor'), problem%start, &
                     run_plan_t(time_step=0.05_wp, end_time=10.0_wp), status, keeper, events=events)
      call check(error, keeper%n, 5, 'flips')
      call check(error, all(keeper%which(1:5) == [1, 2, 1, 2, 1]), 'down and up in turn')
      call check_close(error, keeper%times(4), 7*quarter, 1e-10_wp, 'fourth')
   end subroutine directions

end submodule test_events
