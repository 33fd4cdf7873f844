!> Steps from far too short to far too long: what is converged conserves, what cannot follow the motion is cut, and
!> refused when nothing helps.
module test_stability_large_steps
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR, status_t
   use test_problems, only: angular_velocity, box, fast_top, forced_body, march, problem_t
   use test_stability_branch, only: watched_t
   use test_stability_case, only: check_case, EVERY_WAY, number_text, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow
   use test_support, only: error_type, new_unittest, one_in, unittest_type
   implicit none
   private

   public :: collect_stability_large_steps, large_step_cases

   !> Δt|Ω| of the start: short steps, which follow the motion; long ones, perhaps subdivided; one that is hopeless.
   real(wp), parameter :: short_steps(9) = [1e-9_wp, 1e-7_wp, 1e-5_wp, 1e-4_wp, 1e-3_wp, 1e-2_wp, 0.1_wp, 0.3_wp, &
                                            1.0_wp]
   real(wp), parameter :: long_steps(6) = [2.0_wp, 3.0_wp, 5.0_wp, 10.0_wp, 30.0_wp, 100.0_wp]
   real(wp), parameter :: hopeless = 1e6_wp
   !> Bound of every invariant at every step.
   real(wp), parameter :: bound = 3e-13_wp

contains

   subroutine collect_stability_large_steps(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("the box at any step: right, cut or refused", box_at_any_step), &
                  new_unittest("the fast top at any step: right, cut or refused", top_at_any_step), &
                  new_unittest("a forced body at any step: right, cut or refused", forced_body_at_any_step), &
                  new_unittest("all effects at any step: right, cut or refused", effects_at_any_step)]
   end subroutine collect_stability_large_steps

   !> The cases of this group.
   function large_step_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [box_case(), top_case(), forced_case(), effects_case()]
   end function large_step_cases

   type(stability_case_t) function box_case() result(item)
      item%name = 'box, Δt|Ω| from 1e-9 to 1e6'
      item%guards = 'steps that freeze the state, wrong roots that conserve everything, subdivisions that break an '// &
                    'invariant; steps of 1e6 rad must be rejected with a reason'
      item%selected = EVERY_WAY
      item%run => run_box
   end function box_case

   type(stability_case_t) function top_case() result(item)
      item%name = 'fast top, Δt|Ω| from 1e-9 to 1e6'
      item%guards = 'the same under gravity'
      item%selected = EVERY_WAY
      item%run => run_top
   end function top_case

   type(stability_case_t) function forced_case() result(item)
      item%name = 'forced body, Δt|Ω| from 1e-9 to 1e6'
      item%guards = 'the same with a spring, damping, torque and rotor: the energy balance must close'
      item%selected = EVERY_WAY
      item%run => run_forced
   end function forced_case

   type(stability_case_t) function effects_case() result(item)
      item%name = 'all effects, Δt|Ω| from 1e-9 to 1e6'
      item%guards = 'the same with all effects, some of them twice, one with a time window'
      item%selected = EVERY_WAY
      item%run => run_effects
   end function effects_case

   subroutine box_at_any_step(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, box_case())
   end subroutine box_at_any_step

   subroutine top_at_any_step(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, top_case())
   end subroutine top_at_any_step

   subroutine forced_body_at_any_step(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, forced_case())
   end subroutine forced_body_at_any_step

   subroutine effects_at_any_step(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, effects_case())
   end subroutine effects_at_any_step

   subroutine run_box(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_all_lengths(box(), way, whole, .false., record)
   end subroutine run_box

   subroutine run_top(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_all_lengths(fast_top(), way, whole, one_in() > 3, record)
   end subroutine run_top

   subroutine run_forced(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_all_lengths(forced_body(), way, whole, .false., record)
   end subroutine run_forced

   subroutine run_effects(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call read_scene('scenes/all_effects.nml', scene, status, message)
      call record%require(status%ok(), message)
      if (status%ok()) call run_all_lengths(problem_t(scene%system, scene%initial), way, whole, .true., record)
   end subroutine run_effects

   !> A run at each length of the step, from the shortest.
   subroutine run_all_lengths(problem, way, whole, costly, record)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      !> The shortened form takes one step of each length only, of 10 rad at most.
      logical, intent(in) :: costly
      type(record_t), intent(inout) :: record
      type(record_t) :: trial
      real(wp) :: rate, first_length
      integer(long) :: n
      integer :: i
      rate = norm2(angular_velocity(problem%system, problem%start))
      do i = 1, size(short_steps)
         call follow_closely(problem, way, short_steps(i)/rate, merge(1000_long, 10_long, whole), record)
      end do
      call record%require(record%subdivided_steps == 0, 'a step of 1 rad and less was subdivided')
      first_length = 0.0_wp
      n = merge(50_long, merge(1_long, 5_long, costly), whole)
      do i = 1, merge(4, size(long_steps), costly .and. .not. whole)
         trial = record_t()
         call keep_to_branch(problem, way, long_steps(i)/rate, n, trial)
         call trial%require(.not. trial%refused, 'Δt|Ω| = '//number_text(long_steps(i))//': '//trim(trial%outcome))
         if (trial%subdivided_steps > 0 .and. first_length <= 0.0_wp) first_length = long_steps(i)
         call record%absorb(trial)
      end do
      call record%require_invariants(bound)
      call record%require(first_length > 0.0_wp, 'a step of 100 rad was not subdivided')
      trial = record_t()
      call follow(problem, way, hopeless/rate, 1_long, trial)
      call trial%require(trial%refused .and. trial%outcome /= '' .and. &
                        any(trial%code == [NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR]), &
                        'a hopeless step was not refused')
      call record%require(trial%passed, trim(trial%message))
      record%outcome = 'at 1e6 '//trial%outcome
      call record%show('first subdivided at Δt|Ω|', first_length)
   end subroutine run_all_lengths

   !> Steps short enough to follow the motion: near the solution of an explicit method of order 8, and not still.
   subroutine follow_closely(problem, way, dt, n, record)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      real(wp), intent(in) :: dt
      integer(long), intent(in) :: n
      type(record_t), intent(inout) :: record
      integer, parameter :: compared = 10
      class(stepper_t), allocatable :: other
      type(state_t) :: state, reference
      type(status_t) :: status
      real(wp) :: turn, allowed
      call follow(problem, way, dt, n, record)
      call follow(problem, way, dt, int(compared, long), record, state)
      call make_stepper(problem%system, integrator_settings_t(method='dop853'), other, status)
      reference = problem%start
      call march(problem%system, other, reference, dt/20, 20*compared, status)
      turn = dt*norm2(angular_velocity(problem%system, problem%start))
      ! The error of order 2 is some (Δt|Ω|)²/12 of the way; that of order 8 has a large constant.
      allowed = compared*turn*min(0.5_wp*turn**2, 0.5_wp) + 100*eps
      if (way%order == 8) allowed = compared*turn*min(1.0_wp, 10*turn**8) + 100*eps
      call record%require_below(attitude_distance(state%q, reference%q), allowed, 'attitude at Δt|Ω| = '// &
                                number_text(turn))
      call record%require(attitude_distance(state%q, problem%start%q) > 0.1_wp*turn, 'the body stood still')
   end subroutine follow_closely

   !> Steps as long as they come: those of order 2 are compared with the continuation of the motion from short steps.
   subroutine keep_to_branch(problem, way, dt, n, record)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      real(wp), intent(in) :: dt
      integer(long), intent(in) :: n
      type(record_t), intent(inout) :: record
      type(watched_t) :: watched
      if (way%order == 2) then
         call follow(problem, way, dt, n, record, stepper=watched)
         call record%require(watched%accepted > 0 .and. watched%off_branch == 0, &
                             'a wrong root was accepted at Δt = '//number_text(dt)//' s')
      else
         call follow(problem, way, dt, n, record)
      end if
   end subroutine keep_to_branch

end module test_stability_large_steps
