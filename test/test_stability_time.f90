!> Time: backwards, to any end, far from zero, with any rows.
module test_stability_time
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, run_record_t, run_summary_t
   use nutate_run_plan, only: count_steps, run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   use test_problems, only: forced_body, precessing_top, problem_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_time, time_cases

   !> Keeps the last rows, and whether each was at t0 + kΔt, computed as such.
   type, extends(meter_t) :: clock_meter_t
      !> s
      real(wp) :: t_first = 0.0_wp, spacing = 0.0_wp
      logical :: on_time = .true.
      integer :: kept = 0
      type(state_t) :: states(0:200)
   contains
      procedure :: note => note_time
   end type clock_meter_t

contains

   subroutine collect_stability_time(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("forth and back returns", forth_and_back_returns), &
                  new_unittest("a run ends at any end time", run_ends_at_any_end), &
                  new_unittest("1e9 steps later the digits are the same", later_is_the_same), &
                  new_unittest("rows do not change the motion", rows_do_not_change_the_motion)]
   end subroutine collect_stability_time

   !> The cases, for `make stress`.
   function time_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [back_case(), end_case(), later_case(), rows_case()]
   end function time_cases

   type(stability_case_t) function back_case() result(item)
      item%name = 'forth and back'
      item%guards = 'a step that is not its own inverse: a top, and a damped and driven body, must return to the '// &
                    'start, with its energy'
      item%selected = EVERY_WAY
      item%run => run_back
   end function back_case

   type(stability_case_t) function end_case() result(item)
      item%name = 'end times that are no multiple of the step'
      item%guards = 'a last step too many or too few, or an end missed by a rounding error'
      item%selected = EVERY_WAY
      item%run => run_end
   end function end_case

   type(stability_case_t) function later_case() result(item)
      item%name = 't = 1e9 steps and later'
      item%guards = 'a time that drifts, or steps as long as rounding of t leaves them: the motion from 1e9 Δt on '// &
                    'must have the digits of that from 0 on'
      item%selected = EVERY_WAY
      item%run => run_later
   end function later_case

   type(stability_case_t) function rows_case() result(item)
      item%name = 'rows at every step, at some, once'
      item%guards = 'output must not change the motion: common rows have identical bits'
      item%selected = EVERY_WAY
      item%run => run_rows
   end function rows_case

   subroutine forth_and_back_returns(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, back_case())
   end subroutine forth_and_back_returns

   subroutine run_ends_at_any_end(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, end_case())
   end subroutine run_ends_at_any_end

   subroutine later_is_the_same(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, later_case())
   end subroutine later_is_the_same

   subroutine rows_do_not_change_the_motion(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, rows_case())
   end subroutine rows_do_not_change_the_motion

   subroutine note_time(self, system, state, record)
      class(clock_meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      if (self%kept <= ubound(self%states, 1)) self%states(self%kept) = state
      if (self%spacing > 0.0_wp) &
         self%on_time = self%on_time .and. state%t == self%t_first + real(self%kept, wp)*self%spacing
      self%kept = self%kept + 1
   end subroutine note_time

   subroutine run_back(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(problem_t) :: back
      type(state_t) :: state
      real(wp) :: distance, worst
      integer(long) :: n
      integer :: k
      worst = 0.0_wp
      do k = 1, 2
         ! Damping on the way there is driving on the way back and amplifies round-off.
         n = merge(100000_long, 500_long, whole .and. k == 1)
         problem => precessing_top()
         if (k == 2) problem => forced_body()
         back = problem
         call follow(problem, way, merge(0.001_wp, 0.01_wp, k == 1), n, record, state=back%start)
         call follow(back, way, merge(-0.001_wp, -0.01_wp, k == 1), n, record, state=state)
         distance = max(attitude_distance(state%q, problem%start%q), &
                        norm2(state%p - problem%start%p)/norm2(problem%start%p))
         call record%require_below(distance, 1e-14_wp*n + 1e-12_wp, 'distance from the start')
         call record%require_below(abs(state%t), 1e-14_wp, 'time')
         worst = max(worst, distance)
      end do
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-11_wp)
      call record%show('distance from the start', worst)
   end subroutine run_back

   !> Ends in fractions of a step around whole numbers; each run ends on its time after the right number of steps.
   subroutine run_end(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: dt = 0.001_wp
      real(wp), parameter :: fractions(7) = [1e-8_wp, 0.3_wp, 0.999999_wp, 1 - 1e-8_wp, 1e-10_wp, -1e-10_wp, 0.0_wp]
      integer(long), parameter :: extra(7) = [1, 1, 1, 1, 0, 0, 0]
      type(state_t) :: state, reference
      type(run_summary_t) :: summary
      real(wp) :: distance
      integer(long) :: n
      integer :: i
      n = merge(10000_long, 200_long, whole)
      call run_to(precessing_top(), way, dt, n*dt, record, reference, summary)
      distance = 0.0_wp
      do i = 1, size(fractions)
         call run_to(precessing_top(), way, dt, (n + fractions(i))*dt, record, state, summary)
         call record%require(summary%steps == n + extra(i), 'not the number of steps that the end asks for')
         ! The spin turns it by 140 rad/s.
         distance = attitude_distance(state%q, reference%q)
         call record%require_below(abs(distance - 140.6_wp*abs(fractions(i))*dt), &
                                   2e-3_wp*abs(fractions(i)) + 1e-13_wp*n, 'turn in the last step')
      end do
      call record%require_invariants(1e-11_wp)
   end subroutine run_end

   !> A run of a plan to an end time, which it must hit to the last bit.
   subroutine run_to(problem, way, dt, end_time, record, state, summary)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      !> s
      real(wp), intent(in) :: dt, end_time
      type(record_t), intent(inout) :: record
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(meter_t) :: meter
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      state = problem%start
      meter%inverse_j0 = way%inverse_j0(problem%system)
      call make_stepper(problem%system, way%settings(problem%system), stepper, status)
      if (status%ok()) call integrate(problem%system, stepper, state, &
                                      run_plan_t(time_step=dt, end_time=end_time), status, meter, summary)
      call record%require(status%ok(), trim(status%message))
      call record%require(state%t == end_time, 'the run did not end on its time')
      record%steps = record%steps + summary%steps
      record%energy = max(record%energy, meter%invariants%energy_error())
      record%momentum = max(record%momentum, meter%invariants%momentum_error())
      record%norm = max(record%norm, meter%invariants%norm_error)
   end subroutine run_to

   !> Steps of 0.001 s from 0 and from some 1e6 s on; and the same with adaptive steps.
   subroutine run_later(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: dt = 0.001_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state, reference
      type(clock_meter_t) :: meter, blank
      integer(long) :: n
      integer(long), parameter :: starts(3) = [1000000000_long, 1234567891_long, -999999999_long]
      integer :: i
      n = merge(100000_long, 150_long, whole)
      problem => precessing_top()
      call follow(problem, way, dt, n, record, state=reference)
      do i = 1, size(starts)
         problem%start%t = starts(i)*dt
         meter = blank
         meter%t_first = problem%start%t
         meter%spacing = dt
         call follow(problem, way, dt, n, record, state=state, meter=meter)
         call record%require(meter%on_time, 'a row is not at t0 + kΔt')
         call record%require(all(state%q == reference%q) .and. all(state%p == reference%p), &
                             'a digit depends on the time')
         call record%require(meter%kept == n + 1, 'not as many rows as steps')
         call record%require(count_steps(problem%start%t, run_plan_t(time_step=dt, end_time=(starts(i) + n)*dt)) == n, &
                             'steps are counted wrongly far from zero')
      end do
      call record%require(count_steps(0.0_wp, run_plan_t(time_step=0.7_wp, end_time=0.7_wp*3000000001.0_wp)) == &
                          3000000001_long, 'more than 1e9 steps are counted wrongly')
      call run_controlled_later(way, record)
      call record%require_invariants(1e-11_wp)
   end subroutine run_later

   !> Rows at intervals come at their times, the end is the end, the motion is the same to the tolerance of its steps.
   subroutine run_controlled_later(way, record)
      type(way_t), intent(in) :: way
      type(record_t), intent(inout) :: record
      real(wp), parameter :: t_later = 1e6_wp, interval = 0.01_wp, length = 0.2_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state, reference
      type(clock_meter_t) :: meter, blank
      type(status_t) :: status
      type(run_plan_t) :: plan
      plan = run_plan_t(end_time=length, interval=interval, goal=run_goal_t(local_tolerance=1e-8_wp))
      problem => precessing_top()
      reference = problem%start
      call integrate(problem%system, way%settings(problem%system), reference, plan, status, meter)
      call record%require(status%ok() .and. reference%t == length, 'the controlled run did not end on its time')
      state = problem%start
      state%t = t_later
      plan%end_time = t_later + length
      meter = blank
      meter%t_first = t_later
      meter%spacing = interval
      meter%inverse_j0 = way%inverse_j0(problem%system)
      call integrate(problem%system, way%settings(problem%system), state, plan, status, meter)
      call record%require(status%ok() .and. state%t == plan%end_time, 'the later run did not end on its time')
      call record%require(meter%kept == 21, 'the later run has not the rows asked for')
      call record%require(meter%on_time .or. abs(meter%states(20)%t - plan%end_time) <= 0.0_wp, 'a row is late')
      ! t is known to 1e-10 s there, the body turns by 140 rad/s.
      call record%require_below(attitude_distance(state%q, reference%q), 1e-6_wp, 'attitude of the controlled run')
   end subroutine run_controlled_later

   subroutine run_rows(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(clock_meter_t) :: every, some, once
      type(problem_t), pointer :: problem
      integer :: k
      problem => forced_body()
      call follow(problem, way, 0.02_wp, 200_long, record, meter=every)
      call follow(problem, way, 0.02_wp, 200_long, record, meter=some, every=merge(3_long, 7_long, whole))
      call follow(problem, way, 0.02_wp, 200_long, record, meter=once, every=1000_long)
      call record%require(every%kept == 201 .and. once%kept == 2, 'not the rows asked for')
      do k = 0, some%kept - 2
         associate (a => every%states(k*merge(3, 7, whole)), b => some%states(k))
            call record%require(a%t == b%t .and. all(a%q == b%q) .and. all(a%p == b%p), 'a row depends on others')
         end associate
      end do
      associate (a => every%states(200), b => some%states(some%kept - 1), c => once%states(1))
         call record%require(all(a%q == b%q) .and. all(a%p == b%p) .and. all(a%q == c%q) .and. all(a%p == c%p), &
                             'the last row depends on others')
      end associate
      call record%require_below(max(record%energy, record%norm), 1e-11_wp, 'energy and norm')
   end subroutine run_rows

end module test_stability_time
