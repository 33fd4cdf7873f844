!> The count of steps whose root is accepted without certification, from the stepper to the summary.
submodule(suites_of_methods) test_uncertified
   use nutate_body, only: diagonal, make_body
   use nutate_byte_archive, only: byte_archive_t
   use nutate_earth_field, only: earth_field_t
   use nutate_force, only: force_t, moving_force_t
   use nutate_kinds, only: wp, long
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_projected_stepper, only: projected_stepper_t
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_WHEELS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_run, only: integrate, observer_t, run_summary_t, run_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_NOT_CONVERGED, NUTATE_STEP_LIMIT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_attack_case, only: custom_potential_t
   use test_problems, only: box, make_state, new_problem, problem_t, system_t
   use test_satellites, only: field_along, magnet, moments, path_of, point, push, push_along, rotating
   use test_support, only: check, error_type, new_unittest
   implicit none

   !> Performs steps that are not certified where they start from 0.35 to 0.65 s, fails, which leaves a count, for steps
   !> above 0.06 s that start from 0.55 s on.
   type, extends(stepper_t) :: marked_t
   contains
      procedure :: set_up => set_up_nothing
      procedure :: advance => advance_time
   end type marked_t

   !> Keeps the last archive of a run.
   type, extends(observer_t) :: keeper_t
      character(len=:), allocatable :: archive
   contains
      procedure :: save_checkpoint => keep_archive
   end type keeper_t

contains

   module procedure collect_uncertified
      testsuite = [ &
                  new_unittest("a step counts once, whatever its parts", steps_count_once), &
                  new_unittest("a stepper that is projected counts like it", projection_passes_it_on), &
                  new_unittest("an effect without bounds leaves every step uncertified", effect_without_bounds), &
                  new_unittest("nor is what wheels, controllers, moving potentials do", nothing_derived), &
                  new_unittest("a free body has certified steps only", free_body_is_certified), &
                  new_unittest("rows between steps count nothing", rows_count_nothing), &
                  new_unittest("a resumed run ends with the same count", resumed_runs_agree)]
   end procedure collect_uncertified

   subroutine set_up_nothing(self, system, settings, status)
      class(marked_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
   end subroutine set_up_nothing

   subroutine advance_time(self, system, state, dt, window_time, status)
      class(marked_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      self%uncertified = merge(3, 0, state%t > 0.35_wp .and. state%t < 0.65_wp)
      if (state%t > 0.55_wp .and. dt > 0.06_wp) then
         self%uncertified = 5
         status = fail(NUTATE_NOT_CONVERGED, 'as wanted')
         return
      end if
      state%t = state%t + dt
   end subroutine advance_time

   subroutine keep_archive(self, archive, status)
      class(keeper_t), intent(inout) :: self
      type(byte_archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      self%archive = archive%content()
   end subroutine keep_archive

   !> The body of the box under a potential that says nothing of its bounds.
   function unbounded() result(problem)
      type(problem_t), pointer :: problem
      type(custom_potential_t) :: custom
      problem => box()
      custom%name = 'custom'
      custom%axis = [0.6_wp, 0.0_wp, 0.8_wp]
      custom%size = 20.0_wp
      call problem%system%effects%add(custom)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 0.5_wp, -0.3_wp])
   end function unbounded

   !> Checks ten steps: three are marked, the last of these is subdivided, and so are three more that are not marked.
   subroutine steps_count_once(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(marked_t) :: stepper
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => box()
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      call integrate(problem%system, stepper, problem%start, run_plan_t(time_step=0.1_wp, end_time=1.0_wp), status, &
                     summary=summary)
      call check(error, status%ok() .and. summary%steps == 10 .and. summary%subdivided_steps == 4, trim(status%message))
      call check(error, int(summary%uncertified_steps), 3)
   end subroutine steps_count_once

   subroutine projection_passes_it_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(projected_stepper_t) :: projected
      class(stepper_t), allocatable :: base
      type(status_t) :: status
      problem => box()
      allocate (marked_t :: base)
      call projected%wrap(base)
      call projected%prepare(problem%system, integrator_settings_t(), status)
      problem%start%t = 0.4_wp
      call projected%step(problem%system, problem%start, 0.01_wp, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, projected%uncertified, 3)
   end subroutine projection_passes_it_on

   subroutine effect_without_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_summary_t) :: fixed, chosen
      call take(unbounded(), run_plan_t(time_step=0.05_wp, end_time=2.0_wp), fixed)
      call check(error, fixed%steps == 40 .and. fixed%uncertified_steps == 40, 'fixed steps')
      call take(unbounded(), run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-5_wp)), chosen)
      call check(error, chosen%steps > 5 .and. chosen%uncertified_steps == chosen%steps, 'adaptive steps')
   end subroutine effect_without_bounds

   !> No bounds are derived for them: not even a step in which next to nothing happens counts as certified, in either
   !> form, the first or a later one. Without them every step is.
   subroutine nothing_derived(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']
      integer, parameter :: n_cases = 12, steps = 5
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=40) :: label
      integer :: i, form
      do i = 0, n_cases
         problem => underived(i, status)
         do form = 1, 2
            write (label, '("case ",i0,", ",a)') i, solvers(form)
            state = problem%start
            if (status%ok()) call integrate(problem%system, integrator_settings_t(formulation=solvers(form)), state, &
                                            run_plan_t(time_step=1e-3_wp, end_time=steps*1e-3_wp), status, &
                                            summary=summary)
            call check(error, status%ok(), trim(label)//': '//trim(status%message))
            call check(error, int(summary%uncertified_steps), merge(steps, 0, i > 0), trim(label))
         end do
      end do
   end subroutine nothing_derived

   !> A satellite under a force that stands still, and from the first case on with one thing more.
   function underived(i, status) result(problem)
      integer, intent(in) :: i
      type(status_t), intent(out) :: status
      type(problem_t), pointer :: problem
      real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp]
      type(controller_t) :: controller
      type(orbit_t) :: orbit
      problem => new_problem()
      orbit = orbit_t(path_of(0.0_wp), inertial=i /= 9)
      if (i > 9) orbit = orbit_t(path_of(0.3_wp))
      call make_body(diagonal(moments), problem%system%body, status)
      associate (effects => problem%system%effects, body => problem%system%body)
         call effects%add(orbit)
         call effects%add(force_t(point, push))
         if (i == 1 .or. i == 2) call add_wheel(problem%system, wheel_t(name='wheel', axis=x, inertia=1e-3_wp), status)
         controller = controller_t(name='controller', attitude_gain=1e-6_wp*diagonal(moments), &
                                 rate_gain=1e-6_wp*diagonal(moments), gain=1.0_wp, field=1e-5_wp*x)
         if (i == 2) controller%by = BY_WHEELS
         if (i == 2 .or. i == 4 .or. i == 6) controller%sample = 1.0_wp
         if (i >= 5 .and. i <= 7) controller%by = BY_MAGNETORQUERS
         if (i == 6 .or. i == 7) controller%law = DETUMBLING
         controller%follows_earth = i == 7
         if (i == 7) call effects%add(earth_field_t(0*x, field_along(orbit)))
         if (i >= 2 .and. i <= 7) call add_controller(problem%system, controller, status)
         if (i >= 8 .and. i <= 10) call effects%add(earth_field_t(magnet, field_along(orbit)))
         if (i == 11) call effects%add(moving_force_t(point, push_along(orbit)))
         if (i == 12) call effects%add(orbital_gradient_t(body, orbit%path))
      end associate
      problem%start = make_state(problem%system, [0.8_wp, 0.0_wp, 0.6_wp, 0.0_wp], rotating)
   end function underived

   subroutine free_body_is_certified(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_summary_t) :: fixed, chosen
      call take(box(), run_plan_t(time_step=0.3_wp, end_time=9.0_wp), fixed)
      call check(error, fixed%steps == 30 .and. fixed%uncertified_steps == 0, 'fixed steps')
      call take(box(), run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-5_wp)), chosen)
      call check(error, chosen%steps > 5 .and. chosen%uncertified_steps == 0, 'adaptive steps')
   end subroutine free_body_is_certified

   !> Rows at intervals shorter than the steps are reached by a branch.
   subroutine rows_count_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_summary_t) :: without, with
      call take(unbounded(), run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-5_wp)), without)
      call take(unbounded(), run_plan_t(end_time=2.0_wp, interval=1e-3_wp, &
                                        goal=run_goal_t(local_tolerance=1e-5_wp)), with)
      call check(error, with%steps == without%steps .and. with%uncertified_steps == without%uncertified_steps)
   end subroutine rows_count_nothing

   !> A run by order 4 of the eight equations.
   subroutine take(problem, plan, summary)
      type(problem_t), intent(in) :: problem
      type(run_plan_t), intent(in) :: plan
      type(run_summary_t), intent(out) :: summary
      type(keeper_t) :: keeper
      type(state_t) :: state
      type(status_t) :: status
      state = problem%start
      call integrate(problem%system, integrator_settings_t(order=4), state, plan, status, keeper, summary)
      if (.not. status%ok()) summary%steps = -1
   end subroutine take

   subroutine resumed_runs_agree(error)
      type(error_type), allocatable, intent(out) :: error
      call check_resumed(error, run_plan_t(time_step=0.05_wp, end_time=2.0_wp))
      call check_resumed(error, run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-5_wp)))
   end subroutine resumed_runs_agree

   !> A run that ends after seven steps and goes on counts what one without interruption does.
   subroutine check_resumed(error, plan)
      type(error_type), allocatable, intent(inout) :: error
      type(run_plan_t), intent(in) :: plan
      type(problem_t), pointer :: problem
      type(run_plan_t) :: limited
      type(run_summary_t) :: whole
      class(run_t), allocatable :: begun, resumed
      type(keeper_t) :: keeper
      type(byte_archive_t) :: archive
      type(status_t) :: status
      allocate (begun, resumed)
      problem => unbounded()
      call take(problem, plan, whole)
      limited = plan
      limited%max_steps = 7_long
      keeper%saves_at_step_limit = .true.
      call begun%begin(problem%system, integrator_settings_t(order=4), problem%start, limited, status)
      if (status%ok()) call begun%run_to_end(problem%system, status, keeper)
      call check(error, status%code == NUTATE_STEP_LIMIT .and. allocated(keeper%archive), 'no archive')
      if (allocated(error)) return
      call archive%begin_reading(keeper%archive)
      call resumed%begin(problem%system, integrator_settings_t(order=4), problem%start, plan, status)
      if (status%ok()) call resumed%resume(archive, status)
      if (status%ok()) call resumed%run_to_end(problem%system, status, keeper)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, begun%summary%uncertified_steps > 0 .and. whole%uncertified_steps == whole%steps, &
                 'nothing to count')
      call check(error, resumed%summary%uncertified_steps == whole%uncertified_steps, 'the count of the resumed run')
   end subroutine check_resumed

end submodule test_uncertified
