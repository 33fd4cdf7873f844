!> Starts off the constraint manifold, and starts from the digits of a history.
module test_stability_starts
   use nutate_kinds, only: wp, long
   use nutate_quaternion, only: attitude_distance, quat_normalized
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT
   use test_problems, only: angular_velocity, bilinear_form, box, bruls_top, make_state, precessing_top, problem_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_starts, starts_cases

contains

   subroutine collect_stability_starts(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a norm other than 1 is kept, or refused", norm_is_kept_or_refused), &
                  new_unittest("q.p other than 0 is kept, or refused", product_is_kept_or_refused), &
                  new_unittest("17 digits continue a run", digits_continue_a_run)]
   end subroutine collect_stability_starts

   !> The cases, for `make stress`.
   function starts_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [norm_case(), product_case(), restart_case()]
   end function starts_cases

   type(stability_case_t) function norm_case() result(item)
      item%name = 'norm of q 1 ± 1e-6'
      item%guards = 'the full form must keep the norm that it is given (norm: its change), the reduced form must '// &
                    'reject it; neither may correct it silently'
      item%selected = EVERY_WAY
      item%run => run_norm
   end function norm_case

   type(stability_case_t) function product_case() result(item)
      item%name = 'q·p other than zero'
      item%guards = 'the full form must keep q·p, and let the norm grow as the equations say if J0 is finite; the '// &
                    'reduced form must reject it'
      item%selected = EVERY_WAY
      item%run => run_product
   end function product_case

   type(stability_case_t) function restart_case() result(item)
      item%name = 'restart from a row of 17 digits'
      item%guards = 'a history must hold all that the motion needs: a restarted run may differ by round-off only'
      item%selected = EVERY_WAY
      item%run => run_restart
   end function restart_case

   subroutine norm_is_kept_or_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, norm_case())
   end subroutine norm_is_kept_or_refused

   subroutine product_is_kept_or_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, product_case())
   end subroutine product_is_kept_or_refused

   subroutine digits_continue_a_run(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, restart_case())
   end subroutine digits_continue_a_run

   subroutine run_norm(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(record_t) :: part
      !> Factors as far from 1 as an initial state may be.
      real(wp), parameter :: factors(2) = [1 + 0.9999e-6_wp, 1 - 0.9999e-6_wp]
      real(wp) :: square
      integer :: i
      do i = 1, size(factors)
         problem => precessing_top()
         problem%start%q = factors(i)*problem%start%q
         problem%start%p = problem%start%p/factors(i)
         square = dot_product(problem%start%q, problem%start%q)
         part = record_t()
         call follow(problem, way, 0.001_wp, merge(1000000_long, 2000_long, whole), part, state=state)
         if (way%solver == 'reduced') then
            call require_refusal(problem, state, part, record)
         else
            part%norm = abs(dot_product(state%q, state%q) - square)
            call record%require(.not. part%refused, trim(part%outcome))
            call record%absorb(part)
         end if
      end do
      call record%require_invariants(1e-12_wp)
   end subroutine run_norm

   !> A run that was refused with the reason, before its first step.
   subroutine require_refusal(problem, state, part, record)
      type(problem_t), intent(in) :: problem
      type(state_t), intent(in) :: state
      type(record_t), intent(in) :: part
      type(record_t), intent(inout) :: record
      call record%require(part%refused .and. part%code == NUTATE_BAD_ARGUMENT, 'the state was not refused')
      call record%require(all(state%q == problem%start%q) .and. all(state%p == problem%start%p), &
                          'the state was touched')
      record%refused = .true.
      record%outcome = part%outcome
   end subroutine require_refusal

   !> Runs motions with w₀ = q·p, whose norm grows as d|q|²/dt = ½|q|² w₀/J0.
   subroutine run_product(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(record_t) :: part
      real(wp) :: start(4), w(4), expected
      problem => box()
      problem%start%p = problem%start%p + 1e-3_wp*norm2(problem%start%p)*problem%start%q
      start = bilinear_form(problem%start%q, problem%start%p)
      call follow(problem, way, 0.01_wp, merge(100000_long, 100_long, whole), part, state=state)
      if (way%solver == 'reduced') then
         call require_refusal(problem, state, part, record)
         return
      end if
      call record%require(.not. part%refused, trim(part%outcome))
      w = bilinear_form(state%q, state%p)
      ! Each stage rounds q·p by a part of eps |p|, a thousand times q·p; order 8 has 17 stages.
      call record%require_below(abs(w(1) - start(1)), merge(1e-10_wp, 1e-11_wp, way%finite_j0 .and. way%order > 2)* &
                                abs(start(1)), 'q·p')
      expected = 0.5_wp*start(1)*way%inverse_j0(problem%system)*state%t
      if (expected < 1.0_wp) &
         call record%require_below(abs(log(dot_product(state%q, state%q)) - expected), 1e-3_wp*expected + 1e-11_wp, &
                                   'growth of the norm')
      part%norm = 0.0_wp
      call record%absorb(part)
      call record%require_below(record%energy, 1e-11_wp, 'energy')
      call record%show('growth of |q|²', dot_product(state%q, state%q) - 1)
   end subroutine run_product

   !> A run in one piece and one that goes on from the digits of its middle, of motions that double an error in their
   !> course at most.
   subroutine run_restart(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(problem_t) :: again
      type(state_t) :: state, middle, last
      character(len=24) :: digits(7)
      real(wp) :: values(7), omega(3), distance, stages, bound
      integer(long) :: n
      integer :: i, k
      n = merge(100000_long, 1000_long, whole)
      ! The spins of both runs walk by 2.5e-17 in each stage (half of what the energy does), and turn the bodies by what
      ! they are off times the angle rotated, 0.15 a step: a third of the square, on the average of a walk.
      stages = real(n, wp)*merge(1, 17, way%order == 2)
      bound = 0.15_wp*n*2.5e-17_wp*sqrt(2*stages/3) + 1e-13_wp
      distance = 0.0_wp
      do k = 1, 2
         problem => precessing_top()
         if (k == 2) problem => bruls_top()
         call follow(problem, way, 0.001_wp, n, record, state=middle)
         call follow(problem, way, 0.001_wp, 2*n, record, state=last)
         write (digits, '(es24.16e3)') middle%q, angular_velocity(problem%system, middle)
         read (digits, *) values
         omega = values(5:7)
         again = problem
         again%start = make_state(problem%system, quat_normalized(values(1:4)), omega, t=middle%t)
         call follow(again, way, 0.001_wp, n, record, state=state)
         call record%require(state%t == last%t, 'the restarted run ended at another time')
         distance = max(distance, attitude_distance(state%q, last%q))
         do i = 1, 4
            call record%require_below(abs(state%p(i) - last%p(i)), bound*norm2(last%p), 'momentum')
         end do
      end do
      call record%require_below(distance, bound, 'attitude')
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-12_wp)
      call record%show('departure, rad', distance)
   end subroutine run_restart

end module test_stability_starts
