!> Cost of `accuracy` beyond the run it ends in: time of a run with `accuracy` relative to that of one with the
!> tolerance found, for the methods that `method = 'auto'` chooses from, on every scene.
!>
!> Both runs are repeated in turn, so that a busy machine slows them alike; the shortest processor time counts.
program bench_search
   use bench_problems, only: asymmetric_top, scene_problem
   use nutate, only: integrate, integrator_settings_t, run_plan_t, state_t, status_t, wp
   use nutate_accuracy, only: find_tolerance
   use nutate_error_control, only: error_control_t
   use nutate_measured_run, only: problem_t
   use nutate_methods, only: default_settings
   use nutate_progress, only: progress_t, start_run
   implicit none

   real(wp), parameter :: accuracies(4) = [1e-2_wp, 1e-4_wp, 1e-8_wp, 1e-12_wp]
   !> Ratio that nine of ten cases are to keep.
   real(wp), parameter :: aim = 3.0_wp
   integer, parameter :: rounds = 11
   !> Shortest time that is measured, s.
   real(wp), parameter :: shortest = 2e-3_wp
   integer :: n = 0, above = 0

   write (*, '(a,t48,4es10.0)') 'run with accuracy over its last run, accuracy (rad)', accuracies
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
   write (*, '(/,i0,a,f3.1,a,i0)') above, ' above ', aim, ' of ', n

contains

   !> Writes a row for each method on a scene.
   subroutine study(scene, end_time)
      !> Name of the scene; blank: the asymmetric top.
      character(len=*), intent(in) :: scene
      !> s.
      real(wp), intent(in) :: end_time
      type(problem_t) :: problem
      type(integrator_settings_t) :: settings
      character(len=40) :: title
      if (scene == '') then
         call asymmetric_top(problem)
      else
         call scene_problem(scene, problem)
      end if
      problem%end_time = end_time
      title = scene
      if (scene == '') title = 'asymmetric heavy top'
      settings = default_settings('taylor')
      call write_row(trim(title)//', taylor', problem, settings)
      settings = default_settings('dop853')
      settings%conserve = .true.
      call write_row(trim(title)//', dop853+conserve', problem, settings)
   end subroutine study

   subroutine write_row(title, problem, settings)
      character(len=*), intent(in) :: title
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      real(wp) :: ratios(size(accuracies))
      integer :: k
      do k = 1, size(accuracies)
         call measure(problem, settings, accuracies(k), ratios(k))
      end do
      write (*, '(a,t48,4f10.2)') title, ratios
      n = n + count(ratios > 0)
      above = above + count(ratios > aim)
   end subroutine write_row

   !> Returns the time of a run with an accuracy relative to that of its last run; 0 if there is none.
   subroutine measure(problem, settings, accuracy, ratio)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> rad.
      real(wp), intent(in) :: accuracy
      real(wp), intent(out) :: ratio
      type(progress_t) :: progress
      type(error_control_t) :: control
      type(run_plan_t) :: asked, found
      type(status_t) :: status
      real(wp) :: whole, last
      integer :: round
      ratio = 0.0_wp
      asked%end_time = problem%end_time
      asked%every = huge(asked%every)
      found = asked
      asked%goal%accuracy = accuracy
      call start_run(progress, problem%system%effects, problem%start, asked, status)
      if (status%ok()) call control%begin(problem%system, settings, progress, status)
      if (status%ok()) call find_tolerance(problem%system, settings, progress, control, status)
      if (.not. status%ok()) return
      found%goal%local_tolerance = progress%plan%goal%local_tolerance
      whole = huge(1.0_wp)
      last = huge(1.0_wp)
      do round = 1, rounds
         last = min(last, time_of(problem, settings, found))
         whole = min(whole, time_of(problem, settings, asked))
      end do
      ratio = whole/last
   end subroutine measure

   !> Returns the processor time of a run, s.
   real(wp) function time_of(problem, settings, plan) result(seconds)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: begun, now
      integer :: repeats
      call cpu_time(begun)
      repeats = 0
      do
         state = problem%start
         call integrate(problem%system, settings, state, plan, status)
         repeats = repeats + 1
         call cpu_time(now)
         if (now - begun >= shortest) exit
      end do
      seconds = (now - begun)/repeats
   end function time_of

end program bench_search
