!> Long runs: the invariants stay at round-off over millions of steps.
module test_stability_long
   use nutate_kinds, only: wp, long
   use test_problems, only: box, fast_top, make_state, problem_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_long, long_cases

contains

   subroutine collect_stability_long(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("the box keeps everything in a long run", box_keeps_everything), &
                  new_unittest("with conserve nothing grows", projected_box_does_not_drift), &
                  new_unittest("a steady spin keeps everything in a long run", steady_spin_keeps_everything), &
                  new_unittest("the fast top keeps everything in a long run", top_keeps_everything)]
   end subroutine collect_stability_long

   !> The cases of this group.
   function long_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [box_case(), projected_case(), spin_case(), top_case()]
   end function long_cases

   type(stability_case_t) function box_case() result(item)
      item%name = 'box, 1e7 steps'
      item%guards = 'round-off that accumulates in proportion to the number of steps instead of its root'
      item%selected = EVERY_WAY
      item%run => run_box
   end function box_case

   type(stability_case_t) function projected_case() result(item)
      item%name = 'box with conserve, 1e8 steps'
      item%guards = 'round-off that accumulates in spite of the projection onto the invariants'
      item%selected = EVERY_WAY
      item%run => run_projected
   end function projected_case

   type(stability_case_t) function spin_case() result(item)
      item%name = 'steady spin, 1e7 steps'
      item%guards = 'rounding that is the same in every step, because every step is the same'
      item%selected = EVERY_WAY
      item%run => run_spin
   end function spin_case

   type(stability_case_t) function top_case() result(item)
      item%name = 'fast top, 1e6 steps'
      item%guards = 'the same with a potential: digits lost by the discrete gradient'
      item%selected = EVERY_WAY
      item%run => run_top
   end function top_case

   subroutine box_keeps_everything(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, box_case())
   end subroutine box_keeps_everything

   subroutine projected_box_does_not_drift(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, projected_case())
   end subroutine projected_box_does_not_drift

   subroutine steady_spin_keeps_everything(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, spin_case())
   end subroutine steady_spin_keeps_everything

   subroutine top_keeps_everything(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, top_case())
   end subroutine top_keeps_everything

   subroutine run_box(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_long(box(), way, 0.05_wp, merge(10000000_long, 20000_long, whole), record, &
                    merge(merge(1e-12_wp, 3e-13_wp, way%solver == 'full'), 3e-14_wp, whole))
   end subroutine run_box

   !> About the axis of the largest moment: what a step loses is nearly the same in the next.
   !> Round-off of q and L and of evaluating the energy from them, whatever the number of steps.
   subroutine run_projected(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(way_t) :: projected
      integer(long) :: steps
      projected = way
      projected%conserve = .true.
      steps = merge(100000000_long, 200000_long, whole)
      if (way%order > 2) steps = steps/10
      call follow(box(), projected, 0.01_wp, steps, record, every=steps/1000)
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(5e-15_wp)
   end subroutine run_projected

   subroutine run_spin(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      problem => box()
      problem%start = make_state(problem%system, problem%start%q, [0.0_wp, 10.0_wp, 0.0_wp])
      call run_long(problem, way, 0.05_wp, merge(10000000_long, 20000_long, whole), record, &
                    merge(2e-12_wp, 1e-13_wp, whole))
   end subroutine run_spin

   subroutine run_top(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      call run_long(fast_top(), way, 0.0025_wp, merge(1000000_long, 10000_long, whole), record, &
                    merge(merge(1e-12_wp, 3e-13_wp, way%solver == 'full'), 3e-14_wp, whole))
   end subroutine run_top

   subroutine run_long(problem, way, dt, n, record, bound)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      real(wp), intent(in) :: dt
      integer(long), intent(in) :: n
      type(record_t), intent(inout) :: record
      !> Bound of the errors of energy, momentum and norm.
      real(wp), intent(in) :: bound
      type(meter_t) :: meter
      integer(long) :: steps
      steps = n
      if (way%order > 2) steps = n/10
      call follow(problem, way, dt, steps, record, meter=meter, every=16_long)
      call record%require(.not. record%refused, trim(record%outcome))
      call record%show('growth exponent of errors', maxval(meter%growth()))
      call record%require_invariants(bound)
   end subroutine run_long

end module test_stability_long
