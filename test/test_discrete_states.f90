!> States of the discrete algorithm, from 45-digit arithmetic, reproduced to round-off.
submodule(suites_of_runs) test_discrete_states
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: box, precessing_top, problem_t, solve
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   !> The state after so many steps.
   type :: row_t
      integer :: steps
      real(wp) :: q(4), p(4)
   end type row_t

   !> Box, Δt = 0.1 s.
   type(row_t), parameter :: box_rows(3) = [ &
      row_t(1, &
             [0.88234192993503872463_wp, 0.0052426937111681156713_wp, &
              0.0016776417535563145739_wp, 0.47057668701212644853_wp], &
             [-160.00131627783416062_wp, 0.31194373372589176951_wp, &
              1.3119391747850328797_wp, 299.99793381966672269_wp]), &
      row_t(10, &
             [0.047246468158228959433_wp, -0.12735414795773963647_wp, &
              -0.88519217684170166203_wp, -0.44495337093091135498_wp], &
             [151.41150026446760033_wp, 301.01258659433679405_wp, &
              -42.855456934700565044_wp, 15.178606996956144545_wp]), &
      row_t(30, &
             [-0.13773830279556123565_wp, -0.013746929084911565479_wp, &
              0.11501326878536233341_wp, -0.98367226751954265852_wp], &
             [334.46231788572941546_wp, -39.242249689818754595_wp, &
              -3.6902836213503896045_wp, -46.716009681705457789_wp])]

   !> Precessing top, Δt = 0.001 s.
   type(row_t), parameter :: top_rows(3) = [ &
      row_t(1, &
             [0.86373384740295166542_wp, 0.49901448277106450733_wp, &
              -0.031378293382297827567_wp, 0.062958633559155450657_wp], &
             [-0.012223773117381599101_wp, -0.00043398518326808754385_wp, &
              -0.0069313096793715345698_wp, 0.16768405238104961174_wp]), &
      row_t(10, &
             [0.64670707571058797017_wp, 0.40461257925338582404_wp, &
              -0.29375804136511066503_wp, 0.57599030553397020342_wp], &
             [-0.11183072636863641741_wp, -0.0040651603789981869016_wp, &
              -0.0056307393841544617872_wp, 0.12554458188408788562_wp]), &
      row_t(100, &
             [0.47263990743121885673_wp, 0.50046195106689338152_wp, &
              0.0017268410243317468576_wp, 0.72535947740262136149_wp], &
             [-0.140955460679269303_wp, 0.00017531908052262378944_wp, &
              -0.0069378508409525608525_wp, 0.091741292416853463196_wp])]

contains

   module procedure collect_discrete_states
      testsuite = [ &
                  new_unittest("box, J0 = 10 max J", box_with_finite_j0), &
                  new_unittest("box, J0 infinite", box_with_infinite_j0), &
                  new_unittest("precessing top, J0 = 10 J1", top_with_finite_j0), &
                  new_unittest("precessing top, J0 infinite", top_with_infinite_j0)]
   end procedure collect_discrete_states

   subroutine box_with_finite_j0(error)
      type(error_type), allocatable, intent(out) :: error
      call compare(error, box(), 0.1_wp, 1/200.0_wp, box_rows, 1e-11_wp)
   end subroutine box_with_finite_j0

   subroutine box_with_infinite_j0(error)
      type(error_type), allocatable, intent(out) :: error
      call compare(error, box(), 0.1_wp, 0.0_wp, box_rows, 1e-11_wp)
   end subroutine box_with_infinite_j0

   subroutine top_with_finite_j0(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: top
      top => precessing_top()
      call compare(error, top, 0.001_wp, 0.1_wp/top%system%body%moments(1), top_rows, 1e-13_wp)
   end subroutine top_with_finite_j0

   subroutine top_with_infinite_j0(error)
      type(error_type), allocatable, intent(out) :: error
      call compare(error, precessing_top(), 0.001_wp, 0.0_wp, top_rows, 1e-13_wp)
   end subroutine top_with_infinite_j0

   !> Relative differences of q and p at each row: 1e-13, and `last` at the last row, up to which an unstable motion has
   !> amplified the round-off.
   subroutine compare(error, problem, dt, inverse_j0, rows, last)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt, inverse_j0, last
      type(row_t), intent(in) :: rows(:)
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: tolerance
      integer :: i
      do i = 1, size(rows)
         call solve(problem, dt, rows(i)%steps, state, status, inverse_j0)
         call check(error, status%ok(), trim(status%message))
         tolerance = 1e-13_wp
         if (i == size(rows)) tolerance = last
         call check_close(error, state%q, rows(i)%q, tolerance, "q")
         call check_close(error, state%p, rows(i)%p, tolerance*norm2(rows(i)%p), "p")
      end do
   end subroutine compare

end submodule test_discrete_states
