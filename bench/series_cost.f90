!> Cost of an attitude error with the Taylor series, as ratios to dop853: to the best that its adaptive steps reach and
!> to fixed steps. Then the cost of a step by order, and of a run.
!>
!> Runs are repeated in turn, so that a busy machine slows all of them alike, and the shortest counts.
program bench_series
   use bench_problems, only: asymmetric_top, find_reference, scene_problem
   use nutate, only: integrator_settings_t, state_t, status_t, stepper_t, wp
   use nutate_methods, only: default_settings, make_stepper
   use nutate_quaternion, only: attitude_distance
   use nutate_reference, only: reference_t
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: run_monitor_t, outcome_t, problem_t, run_once, run_to_tolerance
   implicit none

   !> A way to integrate, and its time at a series of steps or tolerances.
   type :: way_t
      character(len=32) :: name = ''
      type(integrator_settings_t) :: settings
      !> True if steps are chosen to a tolerance; else they have one length.
      logical :: chosen = .false.
      integer :: levels = 0
      !> Tolerance, rad, or step, s.
      real(wp) :: setting(40) = 0.0_wp
      !> Errors, rad; times, s; numbers of steps.
      real(wp) :: error(40) = 0.0_wp, seconds(40) = 0.0_wp
      integer :: steps(40) = 0
   end type way_t

   integer, parameter :: n_ways = 5
   real(wp), parameter :: accuracies(5) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp, 1e-12_wp]
   !> Rounds of repeated runs.
   integer, parameter :: rounds = 15
   !> Longest time of a run, s.
   real(wp), parameter :: patience = 0.1_wp

   call study('box', 100.0_wp, 'free box, 100 s')
   call study('heavy_top', 2.0_wp, 'heavy top of Brüls, 2 s')
   call study('', 10.0_wp, 'asymmetric heavy top, 10 s')
   call study('all_effects', 20.0_wp, 'all effects, 20 s')

contains

   !> Writes the times of all ways on a problem.
   subroutine study(scene, end_time, title)
      !> Name of the scene; blank: the asymmetric top.
      character(len=*), intent(in) :: scene, title
      !> s.
      real(wp), intent(in) :: end_time
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(way_t) :: ways(n_ways)
      integer :: i
      if (scene == '') then
         call asymmetric_top(problem)
      else
         call scene_problem(scene, problem)
      end if
      problem%end_time = end_time
      call find_reference(problem, reference)
      ways(1) = way('taylor', .true., .true.)
      ways(2) = way('taylor', .false., .true.)
      ways(3) = way('dop853', .true., .false.)
      ways(4) = way('dop853', .false., .true.)
      ways(5) = way('dop853', .false., .false.)
      do i = 1, n_ways
         call find_levels(problem, reference%q, ways(i))
      end do
      call repeat_runs(problem, ways)
      call write_times(title, reference%uncertainty, ways)
      call write_step(problem)
      call write_orders(problem)
   end subroutine study

   type(way_t) function way(method, conserve, chosen)
      character(len=*), intent(in) :: method
      logical, intent(in) :: conserve, chosen
      way%settings = default_settings(method)
      way%settings%conserve = conserve
      way%chosen = chosen
      way%name = method
      if (conserve) way%name = trim(way%name)//'+conserve'
      way%name = trim(way%name)//merge(', chosen steps', ', fixed steps ', chosen)
   end function way

   !> Finds errors and steps at every level; the last level has no gain near round-off, or takes too long.
   subroutine find_levels(problem, exact, one)
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: exact(4)
      type(way_t), intent(inout) :: one
      real(wp) :: setting
      integer :: k, worse
      worse = 0
      setting = merge(1e-2_wp, problem%end_time/8, one%chosen)
      do k = 1, size(one%setting)
         setting = setting*merge(0.3162277660168379_wp, 0.75_wp, one%chosen)
         one%setting(k) = setting
         call run_level(problem, one, k, exact)
         one%levels = k
         if (one%seconds(k) > patience .or. setting < 1e-16_wp) return
         if (k > 4 .and. one%error(k) < 1e-8_wp) worse = worse + merge(1, 0, one%error(k) > 0.7_wp*one%error(k - 1))
         if (worse > 3) return
      end do
   end subroutine find_levels

   !> Performs one run at a level: its time counts if it is the shortest so far.
   subroutine run_level(problem, one, k, exact)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(inout) :: one
      integer, intent(in) :: k
      real(wp), intent(in), optional :: exact(4)
      class(stepper_t), allocatable :: stepper
      type(problem_t) :: own
      type(run_monitor_t) :: monitor
      type(outcome_t) :: outcome
      type(status_t) :: status
      own = problem
      own%settings = one%settings
      if (one%chosen) then
         call run_to_tolerance(own, one%settings, one%setting(k), monitor, outcome, status)
      else
         call make_stepper(own%system, one%settings, stepper, status)
         call run_once(own, stepper, one%setting(k), monitor, outcome, status)
      end if
      if (present(exact)) then
         one%seconds(k) = outcome%seconds
         one%error(k) = huge(1.0_wp)
         one%steps(k) = int(outcome%summary%parts)
         if (status%ok() .and. 10*outcome%summary%subdivided_steps <= outcome%summary%steps) &
            one%error(k) = attitude_distance(outcome%state%q, exact)
      end if
      one%seconds(k) = min(one%seconds(k), outcome%seconds)
   end subroutine run_level

   subroutine repeat_runs(problem, ways)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(inout) :: ways(:)
      integer :: i, k, round
      do round = 1, rounds
         do k = 1, maxval(ways%levels)
            do i = 1, size(ways)
               if (k <= ways(i)%levels) call run_level(problem, ways(i), k)
            end do
         end do
      end do
   end subroutine repeat_runs

   !> Returns the time for an error, interpolated: that of the first level within it whose next level nearly is too.
   pure subroutine time_for_error(one, accuracy, seconds, steps)
      type(way_t), intent(in) :: one
      real(wp), intent(in) :: accuracy
      !> Time, s; huge if the error is not reached.
      real(wp), intent(out) :: seconds
      integer, intent(out) :: steps
      real(wp) :: fraction
      integer :: k
      seconds = huge(seconds)
      steps = 0
      do k = 2, one%levels
         if (one%error(k) > accuracy) cycle
         if (one%error(min(k + 1, one%levels)) > 4*accuracy) cycle
         seconds = one%seconds(k)
         steps = one%steps(k)
         if (one%error(k - 1) > accuracy .and. one%error(k - 1) < 1.0_wp .and. one%error(k) > 0.0_wp) then
            fraction = log(accuracy/one%error(k))/log(one%error(k - 1)/one%error(k))
            seconds = one%seconds(k)*(one%seconds(k - 1)/one%seconds(k))**fraction
         end if
         return
      end do
   end subroutine time_for_error

   subroutine write_times(title, uncertainty, ways)
      character(len=*), intent(in) :: title
      real(wp), intent(in) :: uncertainty
      type(way_t), intent(in) :: ways(:)
      real(wp) :: seconds(n_ways, size(accuracies)), ours
      integer :: steps(n_ways, size(accuracies)), i, k
      do k = 1, size(accuracies)
         do i = 1, n_ways
            call time_for_error(ways(i), accuracies(k), seconds(i, k), steps(i, k))
         end do
      end do
      write (*, '(a," (attitude known to",es8.1," rad): ms and steps to an attitude error",/)') title, uncertainty
      write (*, '(a,t30,5es15.0)') 'rad', accuracies
      do i = 1, n_ways
         write (*, '(a,t30)', advance='no') trim(ways(i)%name)
         do k = 1, size(accuracies)
            if (steps(i, k) > 0) then
               write (*, '(f9.4,i6)', advance='no') 1e3_wp*seconds(i, k), steps(i, k)
            else
               write (*, '(a15)', advance='no') '-'
            end if
         end do
         write (*, *)
      end do
      do i = 4, 5
         write (*, '(a,t30)', advance='no') 'best of ours over '//trim(ways(i)%name(9:))//' dop853'
         do k = 1, size(accuracies)
            ! Only the ways that conserve.
            ours = min(seconds(1, k), seconds(3, k))
            if (ours < huge(ours) .and. steps(i, k) > 0) then
               write (*, '(f15.2)', advance='no') ours/seconds(i, k)
            else
               write (*, '(a15)', advance='no') '-'
            end if
         end do
         write (*, *)
      end do
      write (*, *)
   end subroutine write_times

   !> Writes the time of a step of the series by order, ns, with and without the projection onto the invariants, and of
   !> dop853.
   subroutine write_step(problem)
      type(problem_t), intent(in) :: problem
      integer, parameter :: orders(5) = [4, 8, 12, 16, 24]
      integer :: k
      write (*, '(a)', advance='no') 'ns per step of order'
      do k = 1, size(orders)
         write (*, '(i4,":",f6.0,"/",f6.0)', advance='no') orders(k), step_time(problem, 'taylor', orders(k), .true.), &
            step_time(problem, 'taylor', orders(k), .false.)
      end do
      write (*, '("; dop853:",f6.0,/)') step_time(problem, 'dop853', 0, .false.)
   end subroutine write_step

   real(wp) function step_time(problem, method, order, conserve) result(nanoseconds)
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      integer, intent(in) :: order
      logical, intent(in) :: conserve
      integer, parameter :: repeats = 4000
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(stopwatch_t) :: clock
      type(state_t) :: state
      type(status_t) :: status
      integer :: i, round
      settings = default_settings(method)
      settings%conserve = conserve
      settings%series_order = order
      nanoseconds = huge(nanoseconds)
      do round = 1, rounds
         call make_stepper(problem%system, settings, stepper, status)
         state = problem%start
         call clock%start()
         do i = 1, repeats
            call stepper%step(problem%system, state, 1e-5_wp, status)
            if (.not. status%ok()) error stop 'a step of the benchmark failed'
         end do
         nanoseconds = min(nanoseconds, 1e9_wp*clock%seconds()/repeats)
      end do
   end function step_time

   !> Writes the time of a run of the series by order, ms, at three tolerances of its steps. The default order is 11 and
   !> one for each decimal digit of the tolerance.
   subroutine write_orders(problem)
      type(problem_t), intent(in) :: problem
      integer, parameter :: orders(6) = [8, 12, 16, 20, 24, 28]
      real(wp), parameter :: tolerances(3) = [1e-4_wp, 1e-8_wp, 1e-12_wp]
      type(integrator_settings_t) :: settings
      type(run_monitor_t) :: monitor
      type(outcome_t) :: outcome
      type(status_t) :: status
      real(wp) :: shortest
      integer :: i, k, round
      write (*, '(a,t32,6i10)') 'ms by order, at a tolerance of', orders
      settings = default_settings('taylor')
      do i = 1, size(tolerances)
         write (*, '(t24,es8.0)', advance='no') tolerances(i)
         do k = 1, size(orders)
            settings%series_order = orders(k)
            shortest = huge(shortest)
            do round = 1, rounds
               call run_to_tolerance(problem, settings, tolerances(i), monitor, outcome, status)
               if (status%ok()) shortest = min(shortest, outcome%seconds)
            end do
            write (*, '(f10.4)', advance='no') 1e3_wp*shortest
         end do
         write (*, *)
      end do
      write (*, *)
   end subroutine write_orders

end program bench_series
