!> Fixed steps for an accuracy: which motions they suit, and that the accuracy is kept.
submodule(suites_of_methods) test_equal_steps
   use nutate_dipole, only: dipole_t
   use nutate_equal_steps, only: equal_steps_t
   use nutate_error_control, only: error_control_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, methods
   use nutate_noise, only: noise_t
   use nutate_progress, only: progress_t, start_run
   use nutate_quaternion, only: attitude_distance
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t, run_t
   use nutate_run_loop, only: drive
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: box, bruls_top, forced_body, free_body, problem_t, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Counts rows, and keeps the times between them.
   type, extends(observer_t) :: clock_t
      integer :: rows = 0
      real(wp) :: last = 0.0_wp, shortest = huge(1.0_wp), longest = 0.0_wp
      !> Energy at the first row, and the most that others differ from it, J.
      real(wp) :: first = 0.0_wp, loss = 0.0_wp
   contains
      procedure :: observe => note_row
   end type clock_t

contains

   module procedure collect_equal_steps
      testsuite = [ &
                  new_unittest("they suit short motions in uniform fields", suited_motions), &
                  new_unittest("an accuracy is kept with few runs", accuracy_is_kept), &
                  new_unittest("errors that cancel in one pair are noticed", cancelled_errors_are_noticed), &
                  new_unittest("rows leave the motion as it is", rows_change_nothing), &
                  new_unittest("a plan with steps that were found is the same run", found_steps_are_kept), &
                  new_unittest("steppers that have made a noisy run are as new", steppers_are_as_new)]
   end procedure collect_equal_steps

   !> A dipole for which the errors of orders 8 and 9 cancel at the steps of the first trial run: its end is seven times
   !> nearer to that of the next one than it ought to be.
   subroutine cancelled_errors_are_noticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state, reference
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => free_body([1.70903754553769316_wp, 1.15144412096108439_wp, 1.48243426433196035_wp], &
                          [-1.9649968383920205e-4_wp, 1.2050443191317919e-3_wp, 1.0892317730914886e-3_wp])
      call problem%system%effects%add(dipole_t( &
                         [2.2924914017966495e-7_wp, -1.4274739862532194e-6_wp, -7.6493895359554742e-6_wp], &
                         [0.62722671637516036_wp, 0.52275795117657053_wp, 0.57733072908594441_wp]))
      state = problem%start
      reference = problem%start
      call integrate(problem%system, integrator_settings_t(method='rk8', conserve=.true.), state, &
                     run_plan_t(end_time=1e4_wp, goal=run_goal_t(accuracy=1e-9_wp)), status, summary=summary)
      if (status%ok()) call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), &
                         reference, run_plan_t(end_time=1e4_wp, goal=run_goal_t(accuracy=1e-12_wp)), status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(state%q, reference%q), summary%estimate, "error")
   end subroutine cancelled_errors_are_noticed

   subroutine suited_motions(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      call expect(error, bruls_top(), 'rk8', 2.0_wp, 1e-6_wp, .true.)
      call expect(error, bruls_top(), 'rk8', -2.0_wp, 1e-10_wp, .true.)
      call expect(error, bruls_top(), 'rk8', 2.0_wp, 9e-11_wp, .false.)
      call expect(error, bruls_top(), 'rk8', 2.0_wp, 0.0_wp, .false.)
      call expect(error, bruls_top(), 'rk8', 20.0_wp, 1e-6_wp, .false.)
      call expect(error, bruls_top(), 'dop853', 2.0_wp, 1e-6_wp, .false.)
      call expect(error, forced_body(), 'rk8', 2.0_wp, 1e-6_wp, .false.)
      call expect(error, box(), 'rk8', 2.0_wp, 1e-6_wp, .true.)
      call expect(error, box(), 'rk8', 1e300_wp, 1e-6_wp, .false.)
      problem => bruls_top()
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=[0.1_wp, -0.2_wp, 0.3_wp]))
      call expect(error, problem, 'rk8', 2.0_wp, 1e-6_wp, .false.)
   end subroutine suited_motions

   subroutine expect(error, problem, method, duration, accuracy, suit)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      !> s; rad.
      real(wp), intent(in) :: duration, accuracy
      logical, intent(in) :: suit
      type(equal_steps_t) :: equal
      call equal%recognise(problem%system, default_settings(method), problem%start, duration, accuracy)
      call check(error, equal%suit .eqv. suit, method)
   end subroutine expect

   !> A top, an asymmetric one, and a compass that swings from rest.
   subroutine accuracy_is_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      call keep(error, bruls_top(), 2.0_wp)
      problem => free_body([0.345_wp, 0.653_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
      call problem%system%effects%add(dipole_t([0.0_wp, 0.3_wp, 1.0_wp], [0.0_wp, 0.6_wp, -0.8_wp]))
      call keep(error, problem, 10.0_wp)
      if (.not. allocated(error)) call keep(error, problem, -10.0_wp)
      problem => free_body([0.5_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 4.0_wp, 0.2_wp]))
      call keep(error, problem, 10.0_wp)
   end subroutine accuracy_is_kept

   !> The error is below what is reported, and that below what was asked for.
   subroutine keep(error, problem, end_time)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> s.
      real(wp), intent(in) :: end_time
      real(wp), parameter :: accuracies(4) = [1e-2_wp, 1e-4_wp, 1e-7_wp, 1e-10_wp]
      type(state_t) :: state, reference
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: i
      reference = problem%start
      call integrate(problem%system, default_settings('taylor'), reference, &
                     run_plan_t(end_time=end_time, goal=run_goal_t(local_tolerance=1e-17_wp)), status)
      do i = 1, size(accuracies)
         state = problem%start
         call integrate(problem%system, default_settings('rk8'), state, &
                        run_plan_t(end_time=end_time, goal=run_goal_t(accuracy=accuracies(i))), status, summary=summary)
         call check(error, status%ok() .and. summary%subdivided_steps == 0, trim(status%message))
         call check_below(error, summary%estimate, accuracies(i), "said")
         call check_below(error, attitude_distance(state%q, reference%q), summary%estimate, "error")
      end do
   end subroutine keep

   !> A run that is seen takes the steps of the one that nobody sees, to the last bit; but for the last they have one
   !> length.
   subroutine rows_change_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      type(clock_t) :: clock
      type(state_t) :: seen, unseen
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => bruls_top()
      plan = run_plan_t(end_time=1.3_wp, goal=run_goal_t(accuracy=1e-6_wp))
      unseen = problem%start
      call integrate(problem%system, default_settings('rk8'), unseen, plan, status)
      call check(error, status%ok(), trim(status%message))
      seen = problem%start
      call integrate(problem%system, default_settings('rk8'), seen, plan, status, clock, summary)
      call check_close(error, [seen%q, seen%p], [unseen%q, unseen%p], 0.0_wp, "rows at steps")
      call check_below(error, clock%longest - clock%shortest, 8*eps*plan%end_time, "one length")
      call check(error, clock%rows == int(summary%steps) + 1, "rows")
      plan%interval = 0.1_wp
      seen = problem%start
      call integrate(problem%system, default_settings('rk8'), seen, plan, status, clock)
      call check_close(error, [seen%q, seen%p], [unseen%q, unseen%p], 0.0_wp, "rows at intervals")
      ! 15 ε of 5463 J, as at fixed steps (suite `rk8`).
      call check_below(error, clock%loss, 15*eps*5463.0_wp, "energy of rows")
   end subroutine rows_change_nothing

   subroutine found_steps_are_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(run_t), allocatable :: search
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      allocate (search)
      problem => bruls_top()
      call search%begin(problem%system, default_settings('rk8'), problem%start, &
                        run_plan_t(end_time=1.3_wp, goal=run_goal_t(accuracy=1e-6_wp)), status)
      if (status%ok()) call search%find_steps(problem%system, status)
      state = problem%start
      if (status%ok()) call integrate(problem%system, default_settings('rk8'), state, search%plan, status, &
                                      summary=summary)
      if (status%ok()) call search%run_to_end(problem%system, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [search%state%q, search%state%p], [state%q, state%p], 0.0_wp)
      call check(error, search%summary%steps == summary%steps, "steps")
   end subroutine found_steps_are_kept

   !> Checks every method, on a top and on a body under torques.
   subroutine steppers_are_as_new(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(error_control_t), allocatable :: used, new
      type(progress_t) :: progress
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      integer :: i, k
      do k = 1, 2
         problem => bruls_top()
         if (k == 2) problem => forced_body()
         do i = 1, size(methods)
            if (methods(i)%order < 1) cycle
            settings = integrator_settings_t(method=methods(i)%name, order=methods(i)%order, &
                                             formulation=methods(i)%formulation, conserve=methods(i)%projected)
            if (allocated(new)) deallocate (new)
            if (allocated(used)) deallocate (used)
            allocate (new, used)
            call go(problem, settings, new, 0.0_wp, progress, status)
            state = progress%state
            if (status%ok()) call go(problem, settings, used, 1e-7_wp, progress, status)
            if (status%ok()) call go(problem, settings, used, 0.0_wp, progress, status)
            call check(error, status%ok(), methods(i)%name//trim(status%message))
            call check_close(error, [progress%state%q, progress%state%p], [state%q, state%p], 0.0_wp, methods(i)%name)
         end do
      end do
   end subroutine steppers_are_as_new

   !> Half a second with adaptive steps.
   subroutine go(problem, settings, control, amplitude, progress, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(error_control_t), intent(inout) :: control
      !> Amplitude of the noise; 0: no noise.
      real(wp), intent(in) :: amplitude
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(out) :: status
      type(noise_t) :: noise
      noise%amplitude = amplitude
      call start_run(progress, problem%system%effects, problem%start, &
                     run_plan_t(end_time=0.5_wp, goal=run_goal_t(local_tolerance=1e-5_wp)), status)
      if (status%ok()) call control%begin(problem%system, settings, progress, status)
      if (.not. status%ok()) return
      if (amplitude > 0.0_wp) call control%disturb(noise)
      call drive(progress, control, problem%system, status)
   end subroutine go

   subroutine note_row(self, system, state, record, status)
      class(clock_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      ! Ends of trial runs are no rows.
      if (self%rows > 0 .and. state%t > self%last) then
         self%shortest = min(self%shortest, state%t - self%last)
         self%longest = max(self%longest, state%t - self%last)
      end if
      if (self%rows == 0) self%first = total_energy(system, state)
      self%loss = max(self%loss, abs(total_energy(system, state) - self%first))
      self%last = state%t
      self%rows = self%rows + 1
   end subroutine note_row

end submodule test_equal_steps
