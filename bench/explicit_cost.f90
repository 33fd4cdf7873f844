!> Cost of an attitude error: the methods of the library that conserve against bare explicit methods written for the
!> problem (`bare_methods`), all in one process.
!>
!> Each method has a fine ladder of steps or tolerances; runs are repeated in turn and the shortest counts, in CPU time
!> of the thread. Ratios are those of the best of ours to the better of the bare ones.
program bench_explicit
   use, intrinsic :: iso_c_binding, only: c_double
   use bare_methods, only: bare_problem_t, run_dop853, run_rk8
   use bench_problems, only: asymmetric_top, find_reference, scene_problem
   use nutate, only: integrate, integrator_settings_t, run_plan_t, state_t, status_t, stepper_t, wp
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_measured_run, only: problem_t
   use nutate_method_choice, only: choose_method
   use nutate_methods, only: default_settings, make_stepper
   use nutate_quaternion, only: attitude_distance, quat_product
   use nutate_reference, only: reference_t
   implicit none

   interface
      real(c_double) function bench_thread_seconds() bind(C)
         import :: c_double
      end function bench_thread_seconds
   end interface

   !> A way to integrate with its ladder.
   type :: way_t
      character(len=32) :: name = ''
      type(integrator_settings_t) :: settings
      !> True if the way is written for the problem; chooses steps to a tolerance; conserves; is a closed solution,
      !> without steps.
      logical :: bare = .false., chosen = .false., ours = .true., closed = .false.
      integer :: levels = 0
      !> Tolerance, rad, or number of steps; error, rad; time, s.
      real(wp) :: setting(120) = 0.0_wp, error(120) = huge(1.0_wp), seconds(120) = huge(1.0_wp)
   end type way_t

   real(wp), parameter :: accuracies(4) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-12_wp]
   !> Rounds of repeated runs; time that is worth the reading of a clock, s; the longest run, s.
   integer, parameter :: rounds = 25
   real(wp), parameter :: worth_reading = 1e-4_wp, patience = 0.05_wp
   !> Factors from one number of steps or tolerance of a ladder to the next.
   real(wp), parameter :: fewer = 1.06_wp, finer = 0.5_wp

   call study('box', 100.0_wp, 'A: free box, 100 s')
   call study('heavy_top', 2.0_wp, 'B: heavy top of Brüls, 2 s')
   call study('', 10.0_wp, 'C: asymmetric heavy top, 10 s')
   call study('all_effects', 20.0_wp, 'all effects, 20 s; the bare method is dop853 of the library, without projection')

contains

   subroutine study(scene, end_time, title)
      !> Name of the scene; blank: the asymmetric top.
      character(len=*), intent(in) :: scene, title
      !> s.
      real(wp), intent(in) :: end_time
      type(problem_t) :: problem
      type(bare_problem_t) :: bare
      type(reference_t) :: reference
      type(way_t), allocatable :: ways(:)
      integer :: i
      if (scene == '') then
         call asymmetric_top(problem)
      else
         call scene_problem(scene, problem)
      end if
      problem%end_time = end_time
      call find_reference(problem, reference)
      if (scene == 'all_effects') then
         ways = [way('dop853', .false., .false.), way('dop853', .false., .true.)]
      else
         call measure_bare(problem, bare)
         ways = [bare_way('bare RK8', .false.), bare_way('bare DOP853', .true.)]
      end if
      ways = [ways, way('rk8', .true., .false.), way('dop853', .true., .false.), way('dop853', .true., .true.), &
              way('taylor', .true., .false.), way('taylor', .true., .true.), short_series()]
      if (has_exact(problem)) ways = [ways, way('exact', .true., .false.)]
      do i = 1, size(ways)
         call climb(problem, bare, reference%q, ways(i))
      end do
      call repeat_runs(problem, bare, ways)
      write (*, '(a,/,"attitude known to",es8.1," rad; us to an attitude error of",/)') title, reference%uncertainty
      call write_table(ways)
      call write_accuracies(problem, reference%q, ways)
   end subroutine study

   type(way_t) function way(method, conserve, chosen)
      character(len=*), intent(in) :: method
      logical, intent(in) :: conserve, chosen
      way%settings = default_settings(method)
      way%closed = method == 'exact'
      way%settings%conserve = conserve .and. .not. way%closed
      way%ours = conserve
      way%chosen = chosen
      way%name = method
      if (way%closed) return
      if (conserve .and. method /= 'taylor') way%name = trim(way%name)//'+conserve'
      way%name = trim(way%name)//merge(', chosen', ', fixed ', chosen)
   end function way

   !> Returns true if there is a closed solution for the problem.
   logical function has_exact(problem)
      type(problem_t), intent(in) :: problem
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      call make_stepper(problem%system, default_settings('exact'), stepper, status)
      has_exact = status%ok()
   end function has_exact

   !> Returns the series of order 12 with fixed steps, as long as low accuracies allow.
   type(way_t) function short_series()
      short_series = way('taylor', .true., .false.)
      short_series%settings%series_order = 12
      short_series%name = 'taylor of order 12, fixed'
   end function short_series

   type(way_t) function bare_way(name, chosen)
      character(len=*), intent(in) :: name
      logical, intent(in) :: chosen
      bare_way%name = name
      bare_way%bare = .true.
      bare_way%ours = .false.
      bare_way%chosen = chosen
   end function bare_way

   !> Makes the problem of the bare methods, with the third space axis along the field.
   subroutine measure_bare(problem, bare)
      type(problem_t), intent(in) :: problem
      type(bare_problem_t), intent(out) :: bare
      real(wp) :: force
      associate (body => problem%system%body, effects => problem%system%effects)
         bare%inverse = 1/body%moments
         bare%euler = (cshift(body%moments, 1) - cshift(body%moments, 2))/body%moments
         bare%start(1:4) = problem%start%q
         bare%start(5:7) = angular_velocity(problem%system, problem%start)
         bare%end_time = problem%end_time
         bare%heavy = effects%n_potentials > 0
         if (.not. bare%heavy) return
         force = effects%potentials(1)%item%direction(3)
         bare%moment = force*effects%potentials(1)%item%series_moment()
      end associate
   end subroutine measure_bare

   !> Measures errors of a way, from coarse to fine, until they no longer fall or runs take too long.
   subroutine climb(problem, bare, exact, one)
      type(problem_t), intent(in) :: problem
      type(bare_problem_t), intent(in) :: bare
      real(wp), intent(in) :: exact(4)
      type(way_t), intent(inout) :: one
      real(wp) :: setting, turn, q(4)
      integer :: k, worse
      worse = 0
      setting = 1e-1_wp
      turn = problem%end_time*norm2(angular_velocity(problem%system, problem%start))
      if (.not. one%chosen) setting = merge(2.0_wp, max(8.0_wp, turn/60), one%settings%method == 'rk8' .and. turn < 400)
      ! A closed solution performs one step, to the end.
      if (one%closed) setting = 0.5_wp
      do k = 1, merge(1, size(one%setting), one%closed)
         if (one%chosen) setting = setting*finer
         if (.not. one%chosen) setting = real(ceiling(fewer*setting), wp)
         if (setting < 1e-16_wp) return
         one%setting(k) = setting
         call run_level(problem, bare, one, k, q)
         one%error(k) = attitude_distance(q, exact)
         one%levels = k
         if (one%seconds(k) > patience) return
         if (k > 4 .and. minval(one%error(:k)) < 1e-7_wp .and. one%error(k) > 0.9_wp*minval(one%error(:k - 1))) &
            worse = worse + 1
         if (worse > 12) return
      end do
   end subroutine climb

   !> Runs at a level, as many as are worth timing; their mean counts if it is the shortest so far.
   subroutine run_level(problem, bare, one, k, q)
      type(problem_t), intent(in) :: problem
      type(bare_problem_t), intent(in) :: bare
      type(way_t), intent(inout) :: one
      integer, intent(in) :: k
      !> Attitude at the end; zero if the run failed.
      real(wp), intent(out) :: q(4)
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      real(wp) :: start, time
      integer :: i, n
      if (.not. one%bare .and. .not. one%chosen) call make_stepper(problem%system, one%settings, stepper, status)
      n = 1
      if (one%seconds(k) < worth_reading) n = ceiling(worth_reading/one%seconds(k))
      start = bench_thread_seconds()
      do i = 1, n
         if (one%bare) then
            call run_bare(bare, one, one%setting(k), q)
         else
            call run_ours(problem, one, one%setting(k), stepper, q)
         end if
      end do
      time = (bench_thread_seconds() - start)/n
      one%seconds(k) = min(one%seconds(k), time)
   end subroutine run_level

   subroutine run_bare(bare, one, setting, q)
      type(bare_problem_t), intent(in) :: bare
      type(way_t), intent(in) :: one
      real(wp), intent(in) :: setting
      real(wp), intent(out) :: q(4)
      real(wp) :: y(7)
      integer :: steps
      if (one%chosen) then
         call run_dop853(bare, setting, y, steps)
      else
         call run_rk8(bare, nint(setting), y)
      end if
      q = y(1:4)
   end subroutine run_bare

   subroutine run_ours(problem, one, setting, stepper, q)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: one
      real(wp), intent(in) :: setting
      class(stepper_t), allocatable, intent(inout) :: stepper
      real(wp), intent(out) :: q(4)
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(status_t) :: status
      plan%end_time = problem%end_time
      plan%every = huge(plan%every)
      state = problem%start
      if (one%chosen) then
         plan%goal%local_tolerance = setting
         call integrate(problem%system, one%settings, state, plan, status)
      else
         plan%time_step = problem%end_time/setting
         call integrate(problem%system, stepper, state, plan, status)
      end if
      q = state%q
      if (.not. status%ok()) q = 0.0_wp
   end subroutine run_ours

   subroutine repeat_runs(problem, bare, ways)
      type(problem_t), intent(in) :: problem
      type(bare_problem_t), intent(in) :: bare
      type(way_t), intent(inout) :: ways(:)
      real(wp) :: q(4)
      integer :: i, k, round
      do round = 1, rounds
         do k = 1, maxval(ways%levels)
            do i = 1, size(ways)
               if (k <= ways(i)%levels) call run_level(problem, bare, ways(i), k, q)
            end do
         end do
      end do
   end subroutine repeat_runs

   !> Returns the shortest time of a level from which on three levels are within an error; huge if there is none.
   pure real(wp) function time_for(one, accuracy)
      type(way_t), intent(in) :: one
      real(wp), intent(in) :: accuracy
      integer :: k
      time_for = huge(1.0_wp)
      do k = 1, one%levels
         if (any(one%error(k:min(k + 2, one%levels)) > accuracy)) cycle
         time_for = min(time_for, one%seconds(k))
      end do
   end function time_for

   subroutine write_table(ways)
      type(way_t), intent(in) :: ways(:)
      integer :: i, k
      write (*, '(a,t34,4es12.0)') 'rad', accuracies
      do i = 1, size(ways)
         write (*, '(a,t34)', advance='no') trim(ways(i)%name)
         do k = 1, size(accuracies)
            call write_number(1e6_wp*time_for(ways(i), accuracies(k)))
         end do
         write (*, *)
      end do
      if (any(ways%closed)) call write_ratios(ways, .not. ways%closed, 'best of our steps over the bare')
      call write_ratios(ways, ways%ours, 'best of ours over the better bare')
   end subroutine write_table

   !> Writes the ratio of the best of some of ours that conserve to the better bare one.
   subroutine write_ratios(ways, admitted, title)
      type(way_t), intent(in) :: ways(:)
      !> True for those of ours that may be the best; shape (number of ways).
      logical, intent(in) :: admitted(:)
      character(len=*), intent(in) :: title
      real(wp) :: best(2), time
      integer :: i, k
      write (*, '(a,t34)', advance='no') title
      do k = 1, size(accuracies)
         best = huge(1.0_wp)
         do i = 1, size(ways)
            time = time_for(ways(i), accuracies(k))
            if (ways(i)%ours .and. admitted(i)) best(1) = min(best(1), time)
            if (.not. ways(i)%ours) best(2) = min(best(2), time)
         end do
         if (maxval(best) < huge(1.0_wp)) best(1) = best(1)/best(2)
         call write_number(merge(best(1), huge(1.0_wp), maxval(best) < huge(1.0_wp)))
      end do
      write (*, *)
   end subroutine write_ratios

   !> Writes a number, or a dash for an error that is not reached.
   subroutine write_number(x)
      real(wp), intent(in) :: x
      if (x < 1e-2_wp*huge(1.0_wp)) then
         write (*, '(f12.3)', advance='no') x
      else
         write (*, '(a12)', advance='no') '-'
      end if
   end subroutine write_number

   !> Writes the time of `accuracy` with the method of `auto`, trial runs included, the error it achieves, and its time
   !> relative to the best of ours for that error.
   subroutine write_accuracies(problem, exact, ways)
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: exact(4)
      type(way_t), intent(in) :: ways(:)
      type(integrator_settings_t) :: settings
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: reason
      real(wp) :: start, time(size(accuracies)), error(size(accuracies)), best
      integer :: i, k, round
      time = huge(1.0_wp)
      do k = 1, size(accuracies)
         call choose_method(problem%system, problem%start, problem%duration(), accuracies(k), settings, reason)
         do round = 1, rounds
            plan = run_plan_t(end_time=problem%end_time, every=huge(plan%every))
            plan%goal%accuracy = accuracies(k)
            state = problem%start
            start = bench_thread_seconds()
            call integrate(problem%system, settings, state, plan, status)
            time(k) = min(time(k), bench_thread_seconds() - start)
         end do
         error(k) = attitude_distance(state%q, exact)
      end do
      write (*, '(a,t34,4f12.3)') 'accuracy with auto', 1e6_wp*time
      write (*, '(a,t34,4es12.1)') '  error achieved', error
      write (*, '(a,t34)', advance='no') '  over the best of ours for that'
      do k = 1, size(accuracies)
         best = huge(1.0_wp)
         do i = 1, size(ways)
            if (ways(i)%ours) best = min(best, time_for(ways(i), max(error(k), 1e-13_wp)))
         end do
         call write_number(merge(time(k)/best, huge(1.0_wp), best < huge(1.0_wp)))
      end do
      write (*, '(/)')
   end subroutine write_accuracies

end program bench_explicit
