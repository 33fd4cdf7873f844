!> Cost of `accuracy` on every scene, trial runs included, with the methods that `method = 'auto'` chooses from, and
!> with its choice.
!>
!> Runs are repeated in turn, so that a busy machine slows all of them alike, and the shortest counts.
program bench_choice
   use bench_problems, only: asymmetric_top, find_reference, scene_problem
   use nutate, only: integrate, integrator_settings_t, run_plan_t, state_t, status_t, wp
   use nutate_method_choice, only: choose_method
   use nutate_methods, only: default_settings
   use nutate_quaternion, only: attitude_distance
   use nutate_reference, only: reference_t
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: problem_t
   implicit none

   real(wp), parameter :: accuracies(8) = [1e-1_wp, 1e-2_wp, 1e-3_wp, 1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp, 1e-12_wp]
   !> Rounds of repeated runs.
   integer, parameter :: rounds = 7
   integer, parameter :: n_ways = 4

   write (*, '(a,t44,8es10.0)') 'ms, trial runs included, for an accuracy of (rad)', accuracies
   call study('all_effects', 20.0_wp)
   call study('', 10.0_wp)
   call study('box', 20.0_wp)
   call study('compass', 60.0_wp)
   call study('fast_top', 2.0_wp)
   call study('gravity_gradient_satellite', 21560.0_wp)
   call study('gyrostat', 20.0_wp)
   call study('heavy_top', 2.0_wp)
   call study('precessing_top', 2.0_wp)
   call study('slowing_plate', 20.0_wp)
   call study('spin_up', 120.0_wp)
   call study('spring_gyroscope', 6.0_wp)

contains

   !> Writes a row for each way on a scene; `!` after a time: the error is more than ten times the accuracy.
   subroutine study(scene, end_time)
      !> Name of the scene; blank: the asymmetric top.
      character(len=*), intent(in) :: scene
      !> s.
      real(wp), intent(in) :: end_time
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(integrator_settings_t) :: ways(n_ways), settings
      character(len=32) :: title, names(n_ways)
      character(len=:), allocatable :: reason
      real(wp) :: seconds(size(accuracies), n_ways), error(size(accuracies), n_ways), one
      integer :: i, k, round
      if (scene == '') then
         call asymmetric_top(problem)
      else
         call scene_problem(scene, problem)
      end if
      problem%end_time = end_time
      call find_reference(problem, reference)
      names = [character(len=32) :: 'taylor', 'dop853+conserve', 'rk8', 'nielsen_krenk 8 reduced']
      ways(1) = default_settings('taylor')
      ways(2) = default_settings('dop853')
      ways(2)%conserve = .true.
      ways(3) = default_settings('rk8')
      ways(4)%order = 8
      ways(4)%formulation = 'reduced'
      seconds = huge(1.0_wp)
      do round = 1, rounds
         do k = 1, size(accuracies)
            do i = 1, n_ways
               if (round > 1 .and. i == n_ways) cycle
               call run_to_accuracy(problem, ways(i), accuracies(k), reference%q, one, error(k, i))
               seconds(k, i) = min(seconds(k, i), one)
            end do
         end do
      end do
      title = scene
      if (scene == '') title = 'asymmetric heavy top'
      write (*, '(/,a,", known to",es8.1," rad")') trim(title), reference%uncertainty
      do i = 1, n_ways
         write (*, '(2x,a,t44,8(f9.3,a1))') names(i), (1e3_wp*seconds(k, i), &
            merge('!', ' ', error(k, i) > 10*accuracies(k)), k=1, size(accuracies))
      end do
      write (*, '(2x,a,t44)', advance='no') 'auto takes'
      do k = 1, size(accuracies)
         call choose_method(problem%system, problem%start, problem%duration(), accuracies(k), settings, reason)
         write (*, '(a10)', advance='no') settings%method
      end do
      write (*, *)
   end subroutine study

   subroutine run_to_accuracy(problem, settings, accuracy, exact, seconds, error)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> rad.
      real(wp), intent(in) :: accuracy, exact(4)
      !> s.
      real(wp), intent(out) :: seconds
      !> rad.
      real(wp), intent(out) :: error
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(status_t) :: status
      type(stopwatch_t) :: clock
      plan%goal%accuracy = accuracy
      plan%end_time = problem%end_time
      plan%every = huge(plan%every)
      state = problem%start
      call clock%start()
      call integrate(problem%system, settings, state, plan, status)
      seconds = clock%seconds()
      error = huge(1.0_wp)
      if (status%ok()) error = attitude_distance(state%q, exact)
   end subroutine run_to_accuracy

end program bench_choice
