!> Events of motions drawn at random, by every method, against a search of each step at many places: what is missed.
!>
!> The cases are those of the attack on the true root (`test_attack_case`), without windows of time, two steps of each;
!> then a quantity and a level, often next to an extremum, so that pairs of roots lie close together. A case is drawn
!> again from its seed and number alone.
module test_event_attack
   use, intrinsic :: iso_fortran_env, only: int64, output_unit
   use nutate_column_event, only: column_event_t
   use nutate_event, only: CROSSING, EXTREMUM
   use nutate_event_list, only: event_list_t
   use nutate_hamiltonian, only: make_state, system_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_attack_case, only: attack_case_t, draw_case, make_system
   use test_event_support, only: keeper_t
   use test_support, only: check, error_type, new_unittest, random_unit, share_of, unittest_type
   implicit none
   private

   public :: collect_event_attack, attack_events, report_event_attack

   !> Cases of the shortened attack, and a third of them.
   integer, parameter :: short = 1500
   !> Steps of a case, and places that the search of a step looks at.
   integer, parameter :: steps = 2, places = 96
   !> Times nearer to a place, in distances of places, are on either side of it.
   real(wp), parameter :: blur = 1e-4_wp

   character(len=16), parameter :: columns(17) = [character(len=16) :: 'q0', 'q1', 'q2', 'q3', 'p0', 'p2', 'omega1', &
      'omega2', 'omega3', 'omega_x', 'omega_z', 'L1', 'L2', 'L3', 'l_y', 'kinetic', 'potential']

   !> Results of all cases.
   type :: event_tally_t
      !> Cases assessed, their roots, and those found.
      integer :: cases = 0, roots = 0, found = 0
      !> Roots missed that are farther from every other than an eighth of the step, or by a series good to 1e-6 at all;
      !> others that were missed; events where there is no root; cases whose run failed.
      integer :: missed = 0, close_missed = 0, false_events = 0, broken = 0
      !> The first cases at fault.
      integer :: n_at_fault = 0, at_fault(100) = 0
   end type event_tally_t

   !> One case.
   type :: event_case_t
      type(system_t) :: system
      type(state_t) :: start
      type(integrator_settings_t) :: settings
      type(column_event_t) :: event
      real(wp) :: dt = 0.0_wp
      !> The method is a series whose steps are good to 1e-6: states inside a step have the rates of the motion there.
      logical :: follows_rates = .false.
      !> Size of the quantity.
      real(wp) :: size = 0.0_wp
      !> The function of the event at places of the steps, its sign changes are the roots; shape (0:steps*places).
      real(wp) :: f(0:steps*places) = 0.0_wp
   end type event_case_t

contains

   subroutine collect_event_attack(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [new_unittest("no event drawn at random is missed, or made up", nothing_is_missed), &
                   new_unittest("where a step ends unprojected nothing is made up", unprojected_end)]
   end subroutine collect_event_attack

   !> The series is projected every fourth step, and this step's error is larger than that of the one before.
   subroutine unprojected_end(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: number = 40000
      type(event_tally_t) :: tally
      call attack_events(1, number, number, tally)
      call check(error, tally%cases == 1 .and. tally%roots == 2, 'another case: '//verdict(1, tally))
      call check(error, tally%missed + tally%false_events + tally%broken == 0, verdict(1, tally))
   end subroutine unprojected_end

   subroutine nothing_is_missed(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_tally_t) :: tally
      real(wp) :: few
      call attack_events(1, 1, share_of(short), tally)
      call check(error, tally%missed + tally%false_events + tally%broken == 0, verdict(1, tally))
      call check(error, tally%roots > tally%cases/2 .and. 2*tally%cases > share_of(short), &
                 'roots: '//verdict(1, tally))
      ! Pairs nearer than the search promises: 4 % of the roots, with three times the scatter of such a count.
      few = 0.04_wp*tally%roots
      call check(error, tally%close_missed <= few + 3*sqrt(few), 'close pairs: '//verdict(1, tally))
   end subroutine nothing_is_missed

   !> Says what came out of cases 1 to n; of case n alone with `alone`.
   subroutine report_event_attack(seed, n, alone, passed)
      integer, intent(in) :: seed, n
      logical, intent(in) :: alone
      logical, intent(out) :: passed
      type(event_tally_t) :: tally
      call attack_events(seed, merge(n, 1, alone), n, tally)
      passed = tally%missed + tally%false_events + tally%broken == 0
      if (alone) call describe(seed, n)
      write (output_unit, '(a)') verdict(seed, tally)
   end subroutine report_event_attack

   !> Says what a case is.
   subroutine describe(seed, number)
      integer, intent(in) :: seed, number
      type(event_case_t), allocatable :: item
      logical :: is_fit
      allocate (item)
      call draw_event(seed, number, item, is_fit)
      associate (event => item%event)
         write (output_unit, '(2a,i0,a,i0,a,g0,5a,2(a,g0))') trim(item%settings%method), ', order ', &
            item%settings%order, ', ', item%system%effects%n_potentials + item%system%effects%n_torques, &
            ' effects, step ', item%dt, ' s, ', merge('value of   ', 'extremes of', event%kind == CROSSING), ' ', &
            trim(event%columns(1)), merge(' and another', '            ', event%columns(2) /= ''), ', weights ', &
            event%weights(1), ' ', event%weights(2)
         write (output_unit, '(a,g0,a,g0)') 'level ', event%level, ', largest distance from it ', maxval(abs(item%f))
      end associate
      if (.not. is_fit) write (output_unit, '(a)') 'not assessed'
   end subroutine describe

   function verdict(seed, tally) result(text)
      integer, intent(in) :: seed
      type(event_tally_t), intent(in) :: tally
      character(len=:), allocatable :: text
      character(len=1200) :: line
      write (line, '(7(i0,a))') tally%cases, ' cases with ', tally%roots, ' roots: ', tally%missed, ' missed, ', &
         tally%close_missed, ' missed within an eighth of a step of another, ', tally%false_events, ' made up, ', &
         tally%broken, ' runs failed; seed ', seed
      text = trim(line)
      if (tally%n_at_fault == 0) return
      write (line, '(*(i0,:,1x))') tally%at_fault(1:tally%n_at_fault)
      text = text//', cases at fault '//trim(line)
   end function verdict

   !> Runs cases from one number to another.
   subroutine attack_events(seed, first, last, tally)
      integer, intent(in) :: seed, first, last
      type(event_tally_t), intent(out) :: tally
      type(event_case_t), allocatable :: item
      integer :: number, faults
      logical :: is_fit
      do number = first, last
         allocate (item)
         call draw_event(seed, number, item, is_fit)
         if (is_fit) then
            faults = tally%missed + tally%false_events + tally%broken
            call assess_case(item, tally)
            if (tally%missed + tally%false_events + tally%broken > faults) then
               tally%n_at_fault = min(tally%n_at_fault + 1, size(tally%at_fault))
               tally%at_fault(tally%n_at_fault) = number
            end if
         end if
         deallocate (item)
      end do
   end subroutine attack_events

   !> Draws a case; it is fit if its steps can be taken in one piece each, and its quantity varies.
   subroutine draw_event(seed, number, item, is_fit)
      integer, intent(in) :: seed, number
      type(event_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      type(attack_case_t) :: drawn
      type(status_t) :: status
      integer(int64) :: state
      real(wp) :: range
      integer :: i
      is_fit = .false.
      call draw_case(seed, number, drawn)
      ! A stream of its own, warm after a few numbers.
      state = 7919_int64*number + 104729_int64*seed
      do i = 1, 10
         range = random_unit(state)
      end do
      do i = 1, drawn%n_effects
         drawn%effects(i)%start = -huge(1.0_wp)
         drawn%effects(i)%stop = huge(1.0_wp)
         if (random_unit(state) < 0.3_wp) drawn%effects(i)%frequency = random_unit(state)/abs(drawn%dt)
      end do
      call make_system(drawn, item%system, status)
      if (.not. status%ok()) return
      item%start = make_state(item%system, drawn%q, drawn%omega)
      item%start%t = drawn%t
      item%dt = drawn%dt*0.1_wp**random_unit(state)
      call draw_method(state, item)
      call draw_quantity(state, item)
      call sample(item, is_fit)
      if (.not. is_fit) return
      range = maxval(item%f) - minval(item%f)
      ! A quantity that the motion conserves varies by the errors of the method alone, and is rejected.
      if (item%event%kind == EXTREMUM) range = maxval(abs(item%f))*abs(item%dt)
      is_fit = range > 1e-3_wp*item%size
      ! A step of an order too low for its length may jump from one branch to another as it is made longer.
      if (any(abs(item%f(1:) - item%f(:steps*places - 1)) > 0.3_wp*maxval(abs(item%f)))) is_fit = .false.
      if (.not. is_fit .or. item%event%kind /= CROSSING) return
      call draw_level(state, item, range)
   end subroutine draw_event

   subroutine draw_method(state, item)
      integer(int64), intent(inout) :: state
      type(event_case_t), intent(inout) :: item
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: i
      i = int(10*random_unit(state))
      select case (i)
      case (4, 5, 6)
         item%settings = default_settings('taylor')
      case (7)
         item%settings = default_settings('rk4')
      case (8)
         item%settings = default_settings('dop853')
      case (9)
         item%settings = default_settings('rk8')
      case default
         item%settings = integrator_settings_t(order=2*(1 + mod(i, 4)))
      end select
      call make_stepper(item%system, item%settings, stepper, status)
      if (.not. status%ok()) item%settings = default_settings('dop853')
      ! A free body's constants would drift through their values.
      if (item%system%effects%n_potentials + item%system%effects%n_torques == 0) &
         item%settings%conserve = item%settings%method == 'rk4' .or. item%settings%method == 'dop853'
   end subroutine draw_method

   !> A column, or the sum of two of a kind; its value or its extremes.
   subroutine draw_quantity(state, item)
      integer(int64), intent(inout) :: state
      type(event_case_t), intent(inout) :: item
      integer :: i
      i = 1 + int(size(columns)*random_unit(state))
      item%event%columns(1) = columns(i)
      item%event%weights(1) = 2*random_unit(state) - 1
      if (i <= 3 .or. (i >= 7 .and. i <= 8)) then
         item%event%columns(2) = columns(i + 1)
         item%event%weights(2) = 2*random_unit(state) - 1
      end if
      item%event%kind = merge(EXTREMUM, CROSSING, random_unit(state) < 0.3_wp)
      call item%event%place()
   end subroutine draw_quantity

   !> A value that is taken, or one beside an extreme value.
   subroutine draw_level(state, item, range)
      integer(int64), intent(inout) :: state
      type(event_case_t), intent(inout) :: item
      real(wp), intent(in) :: range
      integer :: i, k
      real(wp) :: level
      k = 1 + int((size(item%f) - 2)*random_unit(state))
      level = 0.4_wp*item%f(k) + 0.6_wp*item%f(k + 1)
      do i = k, size(item%f) - 2
         if ((item%f(i) - item%f(i - 1))*(item%f(i + 1) - item%f(i)) >= 0.0_wp) cycle
         level = item%f(i) + sign(range*0.1_wp**(1 + 5*random_unit(state)), item%f(i + 1) - item%f(i))
         exit
      end do
      item%event%level = level
      item%f = item%f - level
   end subroutine draw_level

   !> The function of the event at the places of the steps.
   subroutine sample(item, is_fit)
      type(event_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, inside
      type(motion_t) :: motion
      type(status_t) :: status
      real(wp) :: start, t, work
      integer :: i, k
      is_fit = .false.
      call make_stepper(item%system, item%settings, stepper, status)
      if (.not. status%ok()) return
      call stepper%keep_steps()
      state = item%start
      do k = 0, steps - 1
         start = state%t
         call stepper%step(item%system, state, item%dt, status)
         if (.not. status%ok()) return
         do i = merge(0, 1, k == 0), places
            t = start + item%dt*(real(i, wp)/places)
            if (i == places) t = state%t
            call stepper%state_at(item%system, t, inside, work, status)
            if (.not. status%ok()) return
            call find_motion(item%system, inside, motion)
            item%size = max(item%size, abs(item%event%value(item%system, motion)))
            if (item%event%kind == CROSSING) then
               item%f(k*places + i) = item%event%value(item%system, motion)
            else
               call find_rates(item%system, start + 0.5_wp*item%dt, motion)
               item%f(k*places + i) = item%event%rate(item%system, motion)
            end if
         end do
      end do
      is_fit = follows_the_motion(item, state)
   end subroutine sample

   !> Returns true if steps of half the length come to the same end but for a hundredth. If they do not, the steps are
   !> no motion, and bounds of the motion do not hold for them.
   logical function follows_the_motion(item, last) result(is_near)
      type(event_case_t), intent(inout) :: item
      !> State after the steps.
      type(state_t), intent(in) :: last
      !> Bounds of the error of the motion; and of the error at which states inside a step have its rates.
      real(wp), parameter :: near = 0.01_wp, nearest = 1e-6_wp
      real(wp) :: error
      type(motion_t) :: motion
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: k
      is_near = .false.
      call make_stepper(item%system, item%settings, stepper, status)
      if (.not. status%ok()) return
      state = item%start
      do k = 1, 2*steps
         call stepper%step(item%system, state, 0.5_wp*item%dt, status)
         if (.not. status%ok()) return
      end do
      error = max(norm2(state%q - last%q), norm2(state%p - last%p)/max(norm2(item%start%p), norm2(last%p)))
      is_near = error <= near
      item%follows_rates = item%settings%method == 'taylor' .and. error <= nearest
      ! A quantity that the motion conserves varies by the errors of the method alone, and is rejected.
      if (item%event%kind /= CROSSING) return
      call find_motion(item%system, state, motion)
      is_near = is_near .and. abs(item%event%value(item%system, motion) - item%f(steps*places)) <= &
                30*near*(maxval(item%f) - minval(item%f))
   end function follows_the_motion

   !> Runs a case, and compares its events with the changes of sign.
   subroutine assess_case(item, tally)
      type(event_case_t), intent(in) :: item
      type(event_tally_t), intent(inout) :: tally
      type(keeper_t), allocatable :: keeper
      type(event_list_t) :: events
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp), allocatable :: at(:)
      integer :: roots(steps*places), n, i
      logical :: changes
      allocate (keeper)
      call events%add(item%event)
      state = item%start
      call integrate(item%system, item%settings, state, run_plan_t(time_step=item%dt, &
                     end_time=item%start%t + steps*item%dt), status, keeper, summary, events)
      if (.not. status%ok()) then
         tally%broken = tally%broken + 1
         return
      end if
      if (summary%parts /= steps) return
      tally%cases = tally%cases + 1
      at = (keeper%times(1:keeper%n) - item%start%t)*(places/item%dt)
      n = 0
      do i = 1, steps*places
         if (.not. abs(item%f(i - 1)) > 0.0_wp .or. .not. abs(item%f(i)) > 0.0_wp) cycle
         changes = (item%f(i - 1) > 0.0_wp) .neqv. (item%f(i) > 0.0_wp)
         if (changes) then
            n = n + 1
            roots(n) = i
         end if
      end do
      tally%roots = tally%roots + n
      call count_missed(item, at, roots(1:n), tally)
      call count_false(at, roots(1:n), item%f, tally)
   end subroutine assess_case

   !> A root between places i - 1 and i is found if an event is there.
   subroutine count_missed(item, at, roots, tally)
      type(event_case_t), intent(in) :: item
      !> Times of the events, and places behind the roots, in distances of places.
      real(wp), intent(in) :: at(:)
      integer, intent(in) :: roots(:)
      type(event_tally_t), intent(inout) :: tally
      integer :: i, k
      logical :: is_close
      do k = 1, size(roots)
         i = roots(k)
         if (any(at > i - 1 - blur .and. at < i + blur)) then
            tally%found = tally%found + 1
            cycle
         end if
         ! Noise about an extremum, or about the start: not a root to speak of.
         if (max(abs(item%f(i - 1)), abs(item%f(i))) <= 1e3_wp*eps*(maxval(abs(item%f)) + abs(item%event%level))) cycle
         is_close = any(abs(roots - i) <= places/8 + 1 .and. roots /= i)
         if (is_close .and. .not. item%follows_rates) then
            tally%close_missed = tally%close_missed + 1
         else
            tally%missed = tally%missed + 1
         end if
      end do
   end subroutine count_missed

   !> Between two places without a change of sign events come in pairs.
   subroutine count_false(at, roots, f, tally)
      real(wp), intent(in) :: at(:), f(0:)
      integer, intent(in) :: roots(:)
      type(event_tally_t), intent(inout) :: tally
      integer :: k, i
      do k = 1, size(at)
         i = ceiling(at(k))
         if (abs(at(k) - nint(at(k))) < blur .or. any(roots == i)) cycle
         if (i < 1 .or. i > ubound(f, 1)) cycle
         if (min(abs(f(i - 1)), abs(f(i))) <= 1e3_wp*eps*maxval(abs(f))) cycle
         if (mod(count(at > i - 1 .and. at < i), 2) == 1) tally%false_events = tally%false_events + 1
      end do
   end subroutine count_false

end module test_event_attack
