!> The round-off of closed solutions: its estimate against an oracle of higher precision.
!>
!> Over long times the oracle follows one period of the body momentum only. The attitude then has rotated about the
!> momentum in space by a rotation that is the same for every period: its power is that of many.
module test_exact_round_off
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use nutate_body, only: make_body
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: rotation_matrix
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_problems, only: body_momentum, kinetic_energy, make_state, new_system, system_t
   use test_support, only: check, error_type, new_unittest, random_unit, random_unit_quaternion, random_vector, &
                           share_of, skip_test, test_failed, unittest_type
   implicit none
   private

   public :: collect_exact_round_off, report_round_off

   character(len=20), parameter :: kinds(8) = [character(len=20) :: 'any moments', 'symmetric', 'nearly symmetric', &
      'near the separatrix', 'near an axis', 'rotated axes', 'extreme moments', 'about an axis']
   !> Cases of the full report, and of `make stress`.
   integer, parameter :: all_cases = 2000, some_cases = 160
   !> Longest rotation that the oracle follows, rad.
   real(wp), parameter :: longest_turn = 300.0_wp
   !> Logarithm of the largest growth that the oracle follows.
   real(wp), parameter :: longest_growth = 30.0_wp
   !> Error of the oracle's steps: initial states off an axis by 1e-16 are to keep their digits.
   real(qp), parameter :: finest = 1e-30_qp

   !> Result of a case.
   type :: outcome_t
      real(wp) :: error = 0.0_wp, estimate = 0.0_wp
      !> Rotation, rad.
      real(wp) :: turn = 0.0_wp
   end type outcome_t

contains

   subroutine collect_exact_round_off(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("the error of free bodies is below its estimate", error_is_below_estimate), &
                  new_unittest("a run to an accuracy has the estimate", run_has_estimate), &
                  new_unittest("a run out of reach says so", out_of_reach_is_told)]
   end subroutine collect_exact_round_off

   subroutine error_is_below_estimate(error)
      type(error_type), allocatable, intent(out) :: error
      type(outcome_t), allocatable :: outcomes(:)
      character(len=80) :: text
      integer :: i, n
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      n = share_of(some_cases)
      allocate (outcomes(n))
      do i = 1, n
         call run_case(i, outcomes(i))
         if (outcomes(i)%error <= outcomes(i)%estimate) cycle
         write (text, '("case ",i0,": ",es9.2," rad, estimated ",es9.2)') i, outcomes(i)%error, outcomes(i)%estimate
         call test_failed(error, trim(text))
         return
      end do
      call check(error, excess_of(outcomes) < 30.0_wp, "the estimate is far too large")
      call check(error, 2*count(outcomes%turn > longest_turn) > n, "times are not long")
   end subroutine error_is_below_estimate

   !> A body of 1 rad/s over 1e7 s.
   subroutine run_has_estimate(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state, start
      type(run_summary_t) :: summary
      type(free_body_t) :: solution
      type(status_t) :: status
      real(qp) :: period, turn(4)
      real(wp), parameter :: end_time = 1e7_wp
      system => new_system()
      call set_up(system, [1.0_wp, 2.0_wp, 2.5_wp])
      start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.6_wp, 0.64_wp, 0.48_wp])
      state = start
      call integrate(system, integrator_settings_t(), state, &
                     run_plan_t(end_time=end_time, goal=run_goal_t(accuracy=1e-6_wp)), status, summary=summary)
      call check(error, status%ok() .and. summary%settings%method == 'exact', "exact")
      call check(error, summary%estimate > 1e7_wp*eps .and. summary%estimate < 1e-6_wp, "estimate")
      call check(error, summary%round_off >= summary%estimate, "round-off is all there is")
      if (allocated(error) .or. .not. has_oracle) return
      call solution%prepare(system%body%moments, start%q, body_momentum(start), status)
      call find_turn(system, start, solution%period(), period, turn)
      call check(error, period > 0.0_qp, "the oracle's period")
      call check(error, true_distance(attitude_at(system, start, end_time, period, turn), &
                 state%q) <= summary%estimate, "error")
   end subroutine run_has_estimate

   subroutine out_of_reach_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      system => new_system()
      call set_up(system, [1.0_wp, 2.0_wp, 2.5_wp])
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.6_wp, 0.64_wp, 0.48_wp])
      call integrate(system, integrator_settings_t(), state, &
                     run_plan_t(end_time=1e5_wp, goal=run_goal_t(accuracy=1e-14_wp)), status, summary=summary)
      call check(error, status%ok() .and. summary%estimate > 1e-12_wp, "out of reach")
   end subroutine out_of_reach_is_told

   !> Runs all cases, or those from one number to another, and writes what came out, to standard output.
   subroutine report_round_off(first, last, failures)
      !> The numbers; 0: all.
      integer, intent(in) :: first, last
      integer, intent(out) :: failures
      type(outcome_t), allocatable :: outcomes(:), some(:)
      integer :: i, k, from, to
      failures = 0
      if (.not. has_oracle) then
         write (error_unit, '(a)') 'no kind of 33 digits: nothing to compare with'
         return
      end if
      from = max(first, 1)
      to = merge(all_cases, last, last < 1)
      allocate (outcomes(from:to))
      do i = from, to
         call run_case(i, outcomes(i))
         associate (outcome => outcomes(i))
            if (from == to .or. .not. outcome%error <= outcome%estimate) &
               print '("case ",i0,", ",a,", ",es8.1," rad of turn: error ",es9.2," rad, estimated ",es9.2)', i, &
               trim(kinds(kind_of(i))), outcome%turn, outcome%error, outcome%estimate
         end associate
      end do
      failures = count(.not. outcomes%error <= outcomes%estimate)
      if (from == to) return
      print '(a,/,a)', '| kind of body | runs | failures | largest error/estimate | median of estimate/error |', &
         '|---|---|---|---|---|'
      do k = 1, size(kinds)
         some = pack(outcomes, [(kind_of(i) == k, i=from, to)])
         if (size(some) > 0) print '("| ",a,2(" | ",i0)," | ",f5.3," | ",f5.1," |")', trim(kinds(k)), size(some), &
            count(.not. some%error <= some%estimate), maxval(some%error/some%estimate), excess_of(some)
      end do
   end subroutine report_round_off

   pure integer function kind_of(number)
      integer, intent(in) :: number
      kind_of = 1 + mod(number - 1, size(kinds))
   end function kind_of

   !> Median of the estimate over the error.
   pure real(wp) function excess_of(outcomes) result(median)
      type(outcome_t), intent(in) :: outcomes(:)
      real(wp) :: ratios(size(outcomes))
      integer :: i
      ratios = outcomes%estimate/max(outcomes%error, 0.1_wp*eps)
      median = 0.0_wp
      do i = 1, size(ratios)
         if (2*count(ratios <= ratios(i)) >= size(ratios) .and. 2*count(ratios >= ratios(i)) >= size(ratios)) &
            median = ratios(i)
      end do
   end function excess_of

   !> The error of a case, and its estimate.
   subroutine run_case(number, outcome)
      integer, intent(in) :: number
      type(outcome_t), intent(out) :: outcome
      type(system_t), pointer :: system
      type(state_t) :: start
      type(free_body_t) :: solution
      type(status_t) :: status
      real(wp) :: t, q(4), momentum(3)
      real(qp) :: period, turn(4)
      system => new_system()
      call make_case(number, system, start, t)
      call solution%prepare(system%body%moments, start%q, body_momentum(start), status, system%body%axes)
      if (.not. status%ok()) error stop 'a case has no solution'
      call find_turn(system, start, solution%period(), period, turn)
      if (.not. period > 0.0_qp) t = sign(min(abs(t), longest_time(system, start)), t)
      call solution%evaluate(t, q, momentum)
      outcome%error = true_distance(attitude_at(system, start, t, period, turn), q)
      outcome%estimate = solution%round_off(t)
      outcome%turn = abs(t)*fastest(system, start)
   end subroutine run_case

   !> The case of a number: body, start and time.
   subroutine make_case(number, system, start, t)
      integer, intent(in) :: number
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: start
      real(wp), intent(out) :: t
      integer(int64) :: seed
      real(wp) :: j(3), momentum(3), q(4), omega(3)
      integer :: i
      seed = 15485863_int64*number + 7919_int64
      do i = 1, 10
         t = random_unit(seed)
      end do
      do i = 1, 3
         j(i) = 10.0_wp**(-1.5_wp*random_unit(seed))
      end do
      momentum = random_vector(seed)
      call shape_case(kind_of(number), seed, j, momentum)
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (mod((number - 1)/size(kinds), 2) == 1) q = random_unit_quaternion(seed)
      if (kinds(kind_of(number)) == 'rotated axes') then
         call set_up(system, j, random_unit_quaternion(seed))
      else
         call set_up(system, j)
      end if
      omega = matmul(system%body%axes, matmul(transpose(system%body%axes), momentum)/system%body%moments)
      omega = omega/maxval(abs(omega))*10.0_wp**(6*random_unit(seed) - 3)
      start = make_state(system, q, omega)
      t = 10.0_wp**(9*random_unit(seed))/fastest(system, start)
      if (random_unit(seed) < 0.5_wp) t = -t
   end subroutine make_case

   !> Makes moments and momentum those of a kind.
   subroutine shape_case(kind, seed, j, momentum)
      integer, intent(in) :: kind
      integer(int64), intent(inout) :: seed
      !> kg m²; direction of the momentum, principal axes.
      real(wp), intent(inout) :: j(3), momentum(3)
      integer :: i, k
      i = 1 + int(3*random_unit(seed))
      k = 1 + mod(i, 3)
      select case (kinds(kind))
      case ('symmetric')
         j(k) = j(i)
      case ('nearly symmetric')
         j(k) = j(i)*(1 + 10.0_wp**(-16*random_unit(seed)))
      case ('near the separatrix')
         j = [0.5_wp, 1.0_wp, 1.5_wp] + 0.2_wp*random_unit(seed)*[1.0_wp, 0.0_wp, -1.0_wp]
         momentum(1) = momentum(3)*sqrt((1/j(2) - 1/j(3))/(1/j(1) - 1/j(2)))
         momentum(1) = momentum(1)*(1 + sign(10.0_wp**(-14*random_unit(seed)), random_unit(seed) - 0.5_wp))
         j = cshift(j, i)
         momentum = cshift(momentum, i)
      case ('near an axis')
         momentum = momentum*10.0_wp**(-16*random_unit(seed))
         momentum(i) = 1.0_wp
      case ('extreme moments')
         j(i) = j(i)*10.0_wp**(12*random_unit(seed) - 6)
         j = j*10.0_wp**(60*random_unit(seed) - 30)
      case ('about an axis')
         momentum = 0.0_wp
         momentum(i) = 1.0_wp
      case default
         ! The values are left as they were drawn.
      end select
   end subroutine shape_case

   !> A free body of principal moments, along the body axes or rotated by a rotation.
   subroutine set_up(system, moments, turn)
      type(system_t), intent(out) :: system
      real(wp), intent(in) :: moments(3)
      real(wp), intent(in), optional :: turn(4)
      type(status_t) :: status
      real(wp) :: tensor(3, 3), r(3, 3)
      integer :: i
      tensor = 0.0_wp
      do i = 1, 3
         tensor(i, i) = moments(i)
      end do
      if (present(turn)) then
         r = rotation_matrix(turn)
         tensor = matmul(r, matmul(tensor, transpose(r)))
         tensor = 0.5_wp*(tensor + transpose(tensor))
      end if
      call make_body(tensor, system%body, status, check_triangle=.false.)
      if (.not. status%ok()) error stop 'a case has no body'
   end subroutine set_up

   !> Largest angular velocity that the energy allows, rad/s.
   real(wp) function fastest(system, start)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      fastest = sqrt(2*kinetic_energy(system, start)/minval(system%body%moments))
   end function fastest

   !> Returns the time for which the oracle follows a motion whose period it cannot determine, s: near the axis of
   !> middle inertia, until the distance from it has grown enough to detect the return of the body.
   real(wp) function longest_time(system, start) result(t)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      t = longest_turn/fastest(system, start)
      if (growth_rate(system, start) > 0.0_wp) t = min(t, longest_growth/growth_rate(system, start))
   end function longest_time

   !> Rate at which a distance of less than 1e-6 from the axis of middle inertia grows, 1/s; 0 for other motions.
   real(wp) function growth_rate(system, start) result(rate)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp) :: along(3)
      integer :: least, most, middle
      rate = 0.0_wp
      associate (j => system%body%moments)
         least = minloc(j, 1)
         most = maxloc(j, 1)
         middle = 6 - least - most
         if (least == most .or. middle < 1 .or. middle > 3) return
         along = matmul(transpose(system%body%axes), body_momentum(start))
         if (abs(along(middle)) < (1 - 1e-12_wp)*norm2(along)) return
         rate = norm2(along)/j(middle)*sqrt((1 - j(least)/j(middle))*(j(middle)/j(least))*(1 - j(middle)/j(most)))
      end associate
   end function growth_rate

   !> The attitude at a time, s, by the oracle.
   function attitude_at(system, start, t, period, turn) result(q)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: t
      !> Period and rotation found by `find_turn`.
      real(qp), intent(in) :: period, turn(4)
      real(qp) :: q(4)
      integer(int64) :: n
      if (period > 0.0_qp) then
         n = int(real(t, qp)/period, int64)
         q = product(power(turn, n), attitude_after(system, start, real(t, qp) - n*period))
      else
         call find_true_attitude(system, start, t, q, finest)
      end if
   end function attitude_at

   !> The period of the momentum, s, and the rotation of a period in space; of a steady rotation those of a radian. 0
   !> where the period is too long to follow, or where a start all but at rest on an axis does not tell it.
   subroutine find_turn(system, start, about, period, turn)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> The period, about, s; 0: none.
      real(wp), intent(in) :: about
      real(qp), intent(out) :: period, turn(4)
      real(qp) :: q0(4), q(4), l0(3), change(3), square
      integer :: i
      q0 = real(start%q, qp)
      l0 = momentum_of(q0, start)
      change = cross(l0, rate_of(system, l0))
      square = dot_product(change, change)
      period = 0.0_qp
      if ((square > 0.0_qp) .neqv. (about > 0.0_wp)) return
      if (about*fastest(system, start) > longest_turn .or. growth_rate(system, start) > 0.0_wp) return
      period = about
      if (.not. square > 0.0_qp) period = 1/fastest(system, start)
      do i = 1, 4
         q = attitude_after(system, start, period)
         if (square > 0.0_qp) period = period - dot_product(momentum_of(q, start) - l0, change)/square
         if (abs(period - about) > 1e-3_qp*about .and. square > 0.0_qp) exit
      end do
      if (i > 4) q = attitude_after(system, start, period)
      if (maxval(abs(momentum_of(q, start) - l0)) > 1e-18_qp*maxval(abs(l0))) period = 0.0_qp
      if (i <= 4) period = 0.0_qp
      turn = product(q, [q0(1), -q0(2:4)])
   end subroutine find_turn

   !> The attitude after a time that no number of the library may hold.
   function attitude_after(system, start, t) result(q)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> s.
      real(qp), intent(in) :: t
      real(qp) :: q(4), omega(3)
      q = real(start%q, qp)
      if (abs(real(t, wp)) > 0.0_wp) call find_true_attitude(system, start, real(t, wp), q, finest)
      omega = rate_of(system, momentum_of(q, start))*(t - real(real(t, wp), qp))
      q = product(q, [1.0_qp, omega/2])
   end function attitude_after

   !> Body momentum at an attitude of the motion: that in space stays.
   function momentum_of(q, start) result(momentum)
      real(qp), intent(in) :: q(4)
      type(state_t), intent(in) :: start
      real(qp) :: momentum(3), l(4), p(4)
      p = real(start%p, qp)
      l = product(p, [real(start%q(1), qp), -real(start%q(2:4), qp)])/(2*sum(real(start%q, qp)**2))
      l(1) = 0.0_qp
      l = product([q(1), -q(2:4)], product(l, q))/sum(q**2)
      momentum = l(2:4)
   end function momentum_of

   !> Angular velocity of a momentum, body axes.
   function rate_of(system, momentum) result(omega)
      type(system_t), intent(in) :: system
      real(qp), intent(in) :: momentum(3)
      real(qp) :: omega(3), a(3, 3), b(3, 3)
      a = real(system%body%inertia, qp)
      b(:, 1) = cross(a(:, 2), a(:, 3))
      b(:, 2) = cross(a(:, 3), a(:, 1))
      b(:, 3) = cross(a(:, 1), a(:, 2))
      omega = matmul(transpose(b), momentum)/dot_product(a(:, 1), b(:, 1))
   end function rate_of

   !> The rotation n times, n of either sign; a unit quaternion.
   pure function power(turn, n) result(q)
      real(qp), intent(in) :: turn(4)
      integer(int64), intent(in) :: n
      real(qp) :: q(4), square(4)
      integer(int64) :: rest
      q = [1.0_qp, 0.0_qp, 0.0_qp, 0.0_qp]
      square = turn
      if (n < 0) square(2:4) = -square(2:4)
      rest = abs(n)
      do while (rest > 0)
         ! Normalisation to length 1: Newton's step for the root of |q|², which is near 1.
         square = square*(3 - sum(square**2))/2
         if (mod(rest, 2_int64) == 1) q = product(square, q)
         square = product(square, square)
         rest = rest/2
      end do
   end function power

   pure function product(a, b) result(c)
      real(qp), intent(in) :: a(4), b(4)
      real(qp) :: c(4)
      c(1) = a(1)*b(1) - dot_product(a(2:4), b(2:4))
      c(2:4) = a(1)*b(2:4) + b(1)*a(2:4) + cross(a(2:4), b(2:4))
   end function product

   pure function cross(a, b) result(c)
      real(qp), intent(in) :: a(3), b(3)
      real(qp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

end module test_exact_round_off
