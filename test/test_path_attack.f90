!> The attack on levels and extremes: columns with a modulus, angles that turn many times in a step, torques that begin,
!> end and jump, by every method, against the path of the quantity at many places. Nothing may be missed or made up.
module test_path_attack
   use, intrinsic :: iso_fortran_env, only: int64, output_unit
   use nutate_event, only: CROSSING, EXTREMUM, MAXIMUM, MINIMUM
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_event_support, only: keeper_t
   use test_path_case, only: draw_path, find_values, most_places, path_case_t, places, steps
   use test_support, only: check, error_type, new_unittest, random_unit, share_of, unittest_type
   implicit none
   private

   public :: collect_path_attack, report_path_attack

   !> Cases of the shortened attack, and a third of them.
   integer, parameter :: short = 400
   !> Times nearer to a place, in distances of places, are on either side of it.
   real(wp), parameter :: blur = 1e-4_wp
   !> Round-off of a difference, relative to the size of the quantity; difference of levels between runs that project
   !> steps at other points; and difference of an extremum by the rates of the motion from the values of steps with an
   !> error of 1e-6.
   real(wp), parameter :: noise = 1e4_wp*eps, level_error = 1e-7_wp, extremum_error = 2e-6_wp

   !> Periods of angles, rad.
   real(wp), parameter :: periods(3) = [2*pi, 4*pi, 1.0_wp]

   !> Results of all cases.
   type :: path_tally_t
      integer :: cases = 0, expected = 0, missed = 0, made_up = 0, broken = 0
      integer :: n_at_fault = 0, at_fault(100) = 0
   end type path_tally_t

contains

   subroutine collect_path_attack(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [new_unittest("no level and no extremum is missed, or made up", nothing_is_missed)]
   end subroutine collect_path_attack

   subroutine nothing_is_missed(error)
      type(error_type), allocatable, intent(out) :: error
      type(path_tally_t) :: tally
      integer :: n
      n = share_of(short)
      call attack_paths(1, 1, n, tally)
      call check(error, tally%missed + tally%made_up + tally%broken == 0, verdict(1, tally))
      call check(error, 3*tally%cases > n .and. tally%expected > tally%cases, 'few: '//verdict(1, tally))
   end subroutine nothing_is_missed

   !> Says what came out of cases 1 to n; of case n alone with `alone`.
   subroutine report_path_attack(seed, n, alone, passed)
      integer, intent(in) :: seed, n
      logical, intent(in) :: alone
      logical, intent(out) :: passed
      type(path_tally_t) :: tally
      call attack_paths(seed, merge(n, 1, alone), n, tally, alone)
      passed = tally%missed + tally%made_up + tally%broken == 0
      write (output_unit, '(a)') verdict(seed, tally)
   end subroutine report_path_attack

   function verdict(seed, tally) result(text)
      integer, intent(in) :: seed
      type(path_tally_t), intent(in) :: tally
      character(len=:), allocatable :: text
      character(len=1200) :: line
      write (line, '(a,6(i0,a))') 'levels and extremes: ', tally%cases, ' cases with ', tally%expected, ' events: ', &
         tally%missed, ' missed, ', tally%made_up, ' made up, ', tally%broken, ' runs failed; seed ', seed
      text = trim(line)
      if (tally%n_at_fault == 0) return
      write (line, '(*(i0,:,1x))') tally%at_fault(1:tally%n_at_fault)
      text = text//', cases at fault '//trim(line)
   end function verdict

   !> Runs cases from one number to another.
   subroutine attack_paths(seed, first, last, tally, aloud)
      integer, intent(in) :: seed, first, last
      type(path_tally_t), intent(out) :: tally
      logical, intent(in), optional :: aloud
      type(path_case_t), allocatable :: item
      integer :: number, faults
      logical :: is_fit
      do number = first, last
         allocate (item)
         call draw_path(seed, number, item, is_fit)
         if (is_fit) then
            call draw_event(seed, number, item)
            faults = tally%missed + tally%made_up + tally%broken
            call assess(item, tally)
            if (tally%missed + tally%made_up + tally%broken > faults) then
               tally%n_at_fault = min(tally%n_at_fault + 1, size(tally%at_fault))
               tally%at_fault(tally%n_at_fault) = number
            end if
         end if
         if (present(aloud)) then
            if (aloud) call describe(item, is_fit)
         end if
         deallocate (item)
      end do
   end subroutine attack_paths

   subroutine describe(item, is_fit)
      type(path_case_t), intent(in) :: item
      logical, intent(in) :: is_fit
      associate (event => item%event)
         write (output_unit, '(2a,i0,a,g0,a,i0,7a,i0,2(a,g0),a,i0,4(a,g0))') trim(item%settings%method), ', order ', &
            item%settings%order, ', step ', item%dt, ' s, ', item%parts, ' parts, ', trim(event%columns(1)), ' ', &
            trim(event%columns(2)), ' ', 'kind', ' ', event%kind, ' level ', event%level, ' modulo ', event%period, &
            ' direction ', event%direction, ' weights ', event%weights(1), ' ', event%weights(2), ', from ', &
            minval(item%g(0:places*item%parts)), ' to ', maxval(item%g(0:places*item%parts))
      end associate
      if (.not. is_fit) write (output_unit, '(a)') 'not assessed'
   end subroutine describe

   !> A level with a modulus or without, or extremes.
   subroutine draw_event(seed, number, item)
      integer, intent(in) :: seed, number
      type(path_case_t), intent(inout) :: item
      integer(int64) :: state
      real(wp) :: range, least
      integer :: i
      state = 7919_int64*number + 104729_int64*seed + 1299709_int64
      do i = 1, 10
         range = random_unit(state)
      end do
      associate (g => item%g(0:places*item%parts), event => item%event)
         range = maxval(g) - minval(g)
         event%level = minval(g) + random_unit(state)*range
         event%kind = int(6*random_unit(state))
         if (event%kind > EXTREMUM) event%kind = CROSSING
         if (event%kind /= CROSSING) return
         event%direction = int(5*random_unit(state)) - 2
         if (abs(event%direction) > 1) event%direction = 0
         least = random_unit(state)
         if (any(event%columns(1) == ['phi', 'psi']) .and. least < 0.6_wp) then
            event%period = periods(1 + int(3*random_unit(state)))
         else if (least < 0.9_wp) then
            event%period = range*10.0_wp**(0.5_wp - 1.8_wp*random_unit(state))
         end if
      end associate
   end subroutine draw_event

   !> Runs a case, and compares.
   subroutine assess(item, tally)
      type(path_case_t), intent(inout) :: item
      type(path_tally_t), intent(inout) :: tally
      type(keeper_t), allocatable :: keeper
      type(event_list_t) :: events
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp), allocatable :: at(:), values(:)
      real(wp) :: range, greatest
      logical :: is_fit
      integer :: n
      greatest = maxval(abs(item%g(0:places*item%parts)))
      range = maxval(item%g(0:places*item%parts)) - minval(item%g(0:places*item%parts))
      ! A quantity that the motion conserves varies by the errors of the method alone: it has no extremum.
      if (range <= 1e-3_wp*greatest .and. (item%event%kind == CROSSING .or. range > 1e-14_wp*greatest)) return
      allocate (keeper)
      call events%add(item%event)
      state = item%start
      call integrate(item%system, item%settings, state, run_plan_t(time_step=item%dt, &
                     end_time=item%start%t + steps*item%dt), status, keeper, summary, events)
      if (.not. status%ok()) then
         tally%broken = tally%broken + 1
         return
      end if
      if (summary%parts /= item%parts .or. keeper%n >= size(keeper%times)) return
      tally%cases = tally%cases + 1
      n = keeper%n
      allocate (values(n))
      call find_values(item, keeper%times(1:n), values, is_fit)
      at = places_of(item, keeper%times(1:n))
      if (range <= 1e-14_wp*greatest) then
         tally%made_up = tally%made_up + n
      else if (item%event%kind == CROSSING) then
         call compare_levels(item, at, values, tally)
      else
         call compare_extremes(item, at, values, tally)
      end if
   end subroutine assess

   !> Times in distances of places from the start; shape (size(times)).
   function places_of(item, times) result(at)
      type(path_case_t), intent(in) :: item
      real(wp), intent(in) :: times(:)
      real(wp) :: at(size(times))
      integer :: i, k
      do i = 1, size(times)
         k = 1
         do while (k < item%parts .and. (times(i) - item%bounds(k))*item%dt > 0.0_wp)
            k = k + 1
         end do
         at(i) = places*(k - 1 + (times(i) - item%bounds(k - 1))/(item%bounds(k) - item%bounds(k - 1)))
      end do
   end function places_of

   !> Between two places as many levels are passed as their cells are apart, or pairs more; each event is at a level.
   subroutine compare_levels(item, at, values, tally)
      type(path_case_t), intent(in) :: item
      real(wp), intent(in) :: at(:), values(:)
      type(path_tally_t), intent(inout) :: tally
      real(wp) :: period, off, size_of_g, cell, next
      integer :: i, n, due, found, first
      size_of_g = maxval(abs(item%g(0:places*item%parts))) + abs(item%event%level)
      period = item%event%period
      if (.not. period > 0.0_wp) period = 4*size_of_g
      do i = 1, size(at)
         off = values(i) - item%event%level
         off = abs(off - period*anint(off/period))
         if (off > level_error*size_of_g) tally%made_up = tally%made_up + 1
      end do
      n = places*item%parts
      due = 0
      first = 0
      cell = floor((item%g(0) - item%event%level)/period)
      do i = 1, n
         next = floor((item%g(i) - item%event%level)/period)
         if (item%event%direction == 0) due = due + nint(abs(next - cell))
         if (item%event%direction /= 0) due = due + max(0, nint(item%event%direction*(next - cell)))
         cell = next
         off = (item%g(i) - item%event%level)/period
         if (i < n .and. (any(abs(at - i) < blur) .or. abs(off - anint(off))*period <= noise*size_of_g)) cycle
         found = count(at > first .and. at < i)
         if (i == n) found = count(at > first .and. at < i + blur)
         if (first == 0) found = found + count(at <= 0.0_wp)
         tally%expected = tally%expected + due
         if (found < due) tally%missed = tally%missed + due - found
         if (item%event%direction == 0 .and. found > due .and. mod(found - due, 2) == 1) &
            tally%made_up = tally%made_up + 1
         due = 0
         first = i
      end do
   end subroutine compare_levels

   !> About a place from which the path turns back there is one extremum, as far out as its neighbours; elsewhere there
   !> is none, unless the path turns back twice between two places.
   subroutine compare_extremes(item, at, values, tally)
      type(path_case_t), intent(in) :: item
      real(wp), intent(in) :: at(:), values(:)
      type(path_tally_t), intent(inout) :: tally
      integer :: sides(most_places), i, n, side
      logical :: belongs(size(at)), is_wanted
      real(wp) :: greatest, least
      n = places*item%parts
      greatest = maxval(abs(item%g(0:n)))
      least = noise*greatest
      do i = 1, n
         sides(i) = 0
         if (abs(item%g(i) - item%g(i - 1)) > least) sides(i) = nint(sign(1.0_wp, item%g(i) - item%g(i - 1)))
      end do
      ! The signs cannot be distinguished from round-off, or are at the limit of the resolution of the positions.
      if (any(sides(1:n) == 0)) return
      if (any(sides(2:n - 1) /= sides(1:n - 2) .and. sides(3:n) /= sides(2:n - 1))) return
      belongs = .false.
      do i = 1, n - 1
         if (sides(i) == sides(i + 1)) cycle
         side = sides(i)
         is_wanted = item%event%kind == EXTREMUM .or. item%event%kind == merge(MAXIMUM, MINIMUM, side > 0)
         if (.not. is_wanted) cycle
         tally%expected = tally%expected + 1
         belongs = belongs .or. (at > i - 1 - blur .and. at < i + 1 + blur)
         select case (count(at > i - 1 - blur .and. at < i + 1 + blur))
         case (0)
            tally%missed = tally%missed + 1
         case (1)
            associate (value => sum(values, mask=at > i - 1 - blur .and. at < i + 1 + blur))
               if (maxval(side*item%g(i - 1:i + 1)) - side*value > extremum_error*greatest) &
                  tally%made_up = tally%made_up + 1
            end associate
         case default
            tally%made_up = tally%made_up + 1
         end select
      end do
      do i = 1, size(at)
         if (belongs(i)) cycle
         if (.not. turns_back(item, at(i), values(i))) tally%made_up = tally%made_up + 1
      end do
   end subroutine compare_extremes

   !> True if the path turns back at an event that lies between two places, about which it is not seen to do so: nearby,
   !> on both sides, it is on one side of its value there.
   logical function turns_back(item, at, value) result(turns)
      type(path_case_t), intent(in) :: item
      real(wp), intent(in) :: at, value
      real(wp) :: part, times(2), values(2), distance
      integer :: k
      part = at/places
      k = min(int(part), item%parts - 1)
      distance = min(0.2_wp/places, 0.2_wp*abs(part - nint(part)))
      associate (first => item%bounds(k), length => item%bounds(k + 1) - item%bounds(k))
         times = first + length*((part - k) + [-distance, distance])
      end associate
      call find_values(item, times, values, turns)
      values = values - value
      turns = turns .and. values(1)*values(2) > 0.0_wp
      if (item%event%kind == MAXIMUM) turns = turns .and. values(1) < 0.0_wp
      if (item%event%kind == MINIMUM) turns = turns .and. values(1) > 0.0_wp
   end function turns_back

end module test_path_attack
