!> Sensitivities over many steps: what the steps conserve, their tangent conserves, for the columns of the start and
!> of every parameter.
module test_stability_columns
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_kinds, only: wp
   use nutate_spring, only: spring_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, box, make_state, new_problem, precessing_top, problem_t
   use test_random_scenes, only: make_random_scene, random_scene_t
   use test_stability_case, only: check_case, INFINITE_J0, ORDER_TWO, record_t, stability_case_t, way_t
   use test_support, only: error_type, new_unittest, unittest_type
   use test_tangent_identities, only: enrich, worst_defect
   implicit none
   private

   public :: collect_stability_columns, columns_cases

   !> Random scenes; part of them whose steps must all be possible.
   integer, parameter :: many = 15, few = 6
   real(wp), parameter :: most = 0.7_wp
   !> Bound of errors relative to |row||column|.
   real(wp), parameter :: bound = 1e-13_wp

contains

   subroutine collect_stability_columns(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("columns of box, top and spring keep the invariants", known_bodies), &
                  new_unittest("columns of random scenes keep the invariants", random_scenes), &
                  new_unittest("with conserve columns do not drift", projected_scenes)]
   end subroutine collect_stability_columns

   !> The cases of this group.
   function columns_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [known_case(), random_case(), projected_case()]
   end function columns_cases

   type(stability_case_t) function known_case() result(item)
      item%name = 'sensitivities of box, top and spring, 1e6 steps'
      item%guards = 'sensitivities that are not the derivative of the step, with respect to initial state or parameters'
      item%selected = INFINITE_J0
      item%run => run_known
   end function known_case

   type(stability_case_t) function random_case() result(item)
      item%name = 'sensitivities of random scenes, 1e6 steps'
      item%guards = 'the same with all effects, wheels and rotating frames'
      item%selected = INFINITE_J0 .and. ORDER_TWO
      item%run => run_random
   end function random_case

   type(stability_case_t) function projected_case() result(item)
      item%name = 'sensitivities with conserve, all these, 1e6 steps'
      item%guards = 'round-off of sensitivities that accumulates in spite of the projection'
      item%selected = INFINITE_J0 .and. ORDER_TWO
      item%run => run_projected
   end function projected_case

   subroutine known_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, known_case())
   end subroutine known_bodies

   subroutine random_scenes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, random_case())
   end subroutine random_scenes

   subroutine projected_scenes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, projected_case())
   end subroutine projected_scenes

   !> A tenth of the steps by order 8, which has 17 stages.
   pure integer(int64) function number_of_steps(way, whole) result(steps)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      steps = merge(1000000_int64, 2000_int64, whole)
      if (way%order > 2) steps = steps/10
   end function number_of_steps

   subroutine run_known(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_bodies(way, whole, record)
      call record%require_invariants(bound)
   end subroutine run_known

   !> Box, top and spring.
   subroutine run_bodies(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call follow(box(), way, 0.05_wp, number_of_steps(way, whole), [0.0_wp, 0.0_wp, 0.0_wp], .true., record)
      call follow(precessing_top(), way, 1e-3_wp, number_of_steps(way, whole), [0.0_wp, 0.0_wp, 1.0_wp], .true., record)
      call make_body(diagonal([2.0_wp, 1.5_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(spring_t([0.1_wp, 0.2_wp, 0.5_wp], [0.3_wp, -0.4_wp, 0.9_wp], 5.0_wp, 0.4_wp))
      problem%start = make_state(problem%system, [0.9_wp, -0.3_wp, 0.1_wp, 0.3_wp], [0.5_wp, 1.0_wp, 3.0_wp])
      call follow(problem, way, 0.1_wp, number_of_steps(way, whole), [0.0_wp, 0.0_wp, 0.0_wp], .false., record)
      call record%require(.not. record%refused, trim(record%outcome))
   end subroutine run_bodies

   subroutine run_random(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_scenes(way, whole, record)
      call record%require_invariants(bound)
   end subroutine run_random

   subroutine run_projected(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(way_t) :: projected
      projected = way
      projected%conserve = .true.
      call run_bodies(projected, whole, record)
      call run_scenes(projected, whole, record)
      call record%require_invariants(bound)
   end subroutine run_projected

   !> Random scenes. Some speed up until no step follows them: their part until then counts.
   subroutine run_scenes(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(random_scene_t) :: scene
      type(record_t) :: part
      real(wp) :: length
      integer :: i, n, done
      n = merge(many, few, whole)
      done = 0
      do i = 1, n
         call make_random_scene(i, scene)
         call enrich(scene, i)
         length = 0.3_wp/max(norm2(angular_velocity(scene%problem%system, scene%problem%start)), &
                             30/abs(scene%end_time))
         part = record_t()
         associate (effects => scene%problem%system%effects)
            call follow(scene%problem, way, length, number_of_steps(way, whole), [0.0_wp, 0.0_wp, 0.0_wp], &
                        effects%n_potentials + effects%n_torques == 0 .and. .not. effects%frame_turns, part)
         end associate
         if (.not. part%refused) done = done + 1
         part%refused = .false.
         call record%absorb(part)
      end do
      call record%require(done >= most*n, 'most of the scenes can be stepped')
      call record%show('scenes whose steps are all possible', real(done, wp))
   end subroutine run_scenes

   !> Follows the columns of a problem, and adds what came out.
   subroutine follow(problem, way, length, steps, axis, keeps_momentum, record)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      !> s.
      real(wp), intent(in) :: length
      integer(int64), intent(in) :: steps
      !> Along which momentum is kept; 0: all of it is. Shape (3).
      real(wp), intent(in) :: axis(3)
      logical, intent(in) :: keeps_momentum
      type(record_t), intent(inout) :: record
      type(integrator_settings_t) :: settings
      type(record_t) :: part
      type(status_t) :: status
      integer(int64) :: done
      settings = way%settings(problem%system)
      settings%method = 'nielsen_krenk'
      call worst_defect(problem%system, settings, problem%start, length, steps, axis, part%energy, part%momentum, &
                        status, done)
      if (.not. keeps_momentum) part%momentum = 0.0_wp
      part%steps = done
      part%refused = .not. status%ok()
      part%code = status%code
      part%outcome = status%message
      call record%absorb(part)
   end subroutine follow

end module test_stability_columns
