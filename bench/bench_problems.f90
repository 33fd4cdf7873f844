!> Problems that the benchmarks of accuracy integrate.
module bench_problems
   use, intrinsic :: iso_fortran_env, only: error_unit
   use nutate, only: make_body, make_state, read_scene, scene_t, status_t, wp
   use nutate_body, only: diagonal
   use nutate_linear_potential, only: linear_potential_t
   use nutate_reference, only: reference_t
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: fastest_rate, problem_t
   implicit none
   private

   public :: asymmetric_top, scene_problem, find_reference

contains

   !> Sets J = 0.345, 0.653, 1; L = 1.8, 0.4, -0.9; attitude rotated by 0.3 rad about axis 1; m g l = 1.
   subroutine asymmetric_top(problem)
      type(problem_t), intent(inout) :: problem
      real(wp), parameter :: moments(3) = [0.345_wp, 0.653_wp, 1.0_wp], momentum(3) = [1.8_wp, 0.4_wp, -0.9_wp]
      type(linear_potential_t) :: weight
      type(status_t) :: status
      call make_body(diagonal(moments), problem%system%body, status, check_triangle=.false.)
      weight%name = 'weight'
      weight%direction = [0.0_wp, 0.0_wp, -1.0_wp]
      weight%moment = [0.0_wp, 0.0_wp, 1.0_wp]
      call problem%system%effects%add(weight)
      problem%start = make_state(problem%system, [cos(0.15_wp), sin(0.15_wp), 0.0_wp, 0.0_wp], momentum/moments)
   end subroutine asymmetric_top

   !> Reads body, effects and initial state of a scene of the folder `scenes`.
   subroutine scene_problem(name, problem)
      character(len=*), intent(in) :: name
      type(problem_t), intent(inout) :: problem
      type(scene_t) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call read_scene('scenes/'//name//'.nml', scene, status, message)
      if (.not. status%ok()) then
         write (error_unit, '(a)') message
         error stop
      end if
      problem%system = scene%system
      problem%start = scene%initial
   end subroutine scene_problem

   !> Computes the reference attitude at the end.
   subroutine find_reference(problem, reference)
      type(problem_t), intent(in) :: problem
      type(reference_t), intent(inout) :: reference
      type(study_budget_t) :: budget
      type(status_t) :: status
      real(wp) :: rate
      call budget%start()
      budget%limit = 10.0_wp
      call fastest_rate(problem, 1, rate, status)
      call reference%begin(problem, rate)
      do while (.not. reference%settled)
         call reference%refine(problem, budget)
      end do
   end subroutine find_reference

end module bench_problems
