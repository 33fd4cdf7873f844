!> The function of an event along a step of the method, its angles followed continuously.
!>
!> An angle is known except for whole revolutions. The derivatives at two positions give the change between them, and
!> that determines the revolution, if the cubic through both is right at the position in the middle as well, in value
!> and derivative; if it is not, both halves are followed one after the other. Each position with known revolutions is
!> thus an anchor for those beside it.
module nutate_step_curve
   use nutate_event, only: most_parts, part_t
   use nutate_event_roots, only: curve_t
   use nutate_kinds, only: wp
   use nutate_progress, only: progress_t, run_point_t
   use nutate_status, only: status_t
   use nutate_step_policy, only: step_policy_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: step_curve_t

   !> Largest number of halvings of a step, with evaluations that cost much less than the step and with others; rotation
   !> of the body in a part, rad, above which cheap evaluations halve the part.
   integer, parameter :: deepest_cheap = 10, deepest = 6
   real(wp), parameter :: great_turn = 1.5_wp

   !> Largest error of the cubic in the middle, over the wrap.
   real(wp), parameter :: near = 0.01_wp
   !> Largest deviation of an angle from the change by its derivatives at both ends, and largest change, over the wrap,
   !> and largest rotation of the body, rad, in parts that need no evaluation in the middle.
   real(wp), parameter :: calm = 0.05_wp, small_change = 0.25_wp, small_turn = 1.0_wp

   !> Position in the step.
   type, private :: anchor_t
      !> Position, in steps.
      real(wp) :: s = 0.0_wp
      !> Parts of the function, with rates by s.
      type(part_t) :: parts(most_parts) = part_t()
   end type anchor_t

   !> The function of an event along the step.
   type, extends(curve_t) :: step_curve_t
      class(step_policy_t), pointer :: policy => null()
      type(system_t), pointer :: system => null()
      type(progress_t), pointer :: progress => null()
      type(run_point_t), pointer :: mark => null()
      !> Index of the event.
      integer :: event = 0
      !> Level that is looked for, relative to that of the event: whole periods.
      real(wp) :: shift = 0.0_wp
      !> Parts have wraps; if so, number of anchors, and the positions where the revolutions of the parts are known.
      logical :: follows = .false.
      integer :: n = 0
      type(anchor_t), allocatable :: anchors(:)
   contains
      !> Stores both ends of the step, and follows the angles from one to the other.
      procedure :: join
      procedure :: evaluate
      !> Returns the parts at a position, interpolated between the anchors.
      procedure :: expect
   end type step_curve_t

   interface

      !> Stores both ends of the step, and follows the angles from one to the other. Errors: those of the method.
      module subroutine join(self, first, last, turn, status)
         class(step_curve_t), intent(inout) :: self
         !> Parts at the start of the step, with rates by the time.
         type(part_t), intent(in) :: first(most_parts)
         !> Parts at the end of the step, with rates by the time; on return with the revolutions that follow from the
         !> first.
         type(part_t), intent(inout) :: last(most_parts)
         !> Rotation of the body in the step, rad.
         real(wp), intent(in) :: turn
         type(status_t), intent(inout) :: status
      end subroutine join

      !> Returns the parts at a position, interpolated between the anchors; shape (most_parts).
      pure module function expect(self, s) result(values)
         class(step_curve_t), intent(in) :: self
         real(wp), intent(in) :: s
         real(wp) :: values(most_parts)
      end function expect

      !> Evaluates the function of an event at a position inside the step, relative to the level that is looked for.
      module subroutine evaluate(self, s, f, slope, status)
         class(step_curve_t), intent(inout) :: self
         real(wp), intent(in) :: s
         real(wp), intent(out) :: f, slope
         type(status_t), intent(inout) :: status
      end subroutine evaluate

   end interface

end module nutate_step_curve
