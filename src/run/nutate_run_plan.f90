!> What is asked of a run: how long its steps are, or what they must keep to; where it ends; when rows are due.
module nutate_run_plan
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: run_plan_t, run_goal_t

   !> What steps that are chosen by their error must keep to; one of these is set, or none for fixed steps.
   type :: run_goal_t
      !> Attitude error at the end time, rad: trial runs turn it into a `local_tolerance`.
      real(wp) :: accuracy = 0.0_wp
      !> Error of a step, rad.
      real(wp) :: local_tolerance = 0.0_wp
      !> Error of a step over its length, rad/s.
      real(wp) :: error_rate = 0.0_wp
   contains
      !> True if steps are adaptive.
      procedure :: active
   end type run_goal_t

   !> How far to go, by which steps, and how often to show the state.
   type :: run_plan_t
      !> Nominal step, s; of the sign of the way to go. Without meaning where the goal is active.
      real(wp) :: time_step = 0.0_wp
      !> s; the greatest number: not known yet.
      real(wp) :: end_time = huge(1.0_wp)
      !> Steps between the rows shown to the observer.
      integer(long) :: every = 1
      !> A run that needs more steps (those of continuation in Δt counted), or more rows at intervals, ends there.
      integer(long) :: max_steps = huge(1_long)
      !> Nominal steps of this length that were done before those of the run, and their first time, s: those of this run
      !> then end where those of a single one would.
      integer(long) :: steps_before = 0
      real(wp) :: first_time = 0.0_wp
      !> Nominal steps to do; negative: as many as lead to the end time.
      integer(long) :: steps = -1
      !> Time between rows, s, where steps are adaptive; 0: a row every so many steps.
      real(wp) :: interval = 0.0_wp
      !> Times of the rows, s, in the order in which they are reached, from the first to the end time; where allocated,
      !> they are the only ones. Shape (any).
      real(wp), allocatable :: times(:)
      type(run_goal_t) :: goal = run_goal_t()
   end type run_plan_t

contains

   !> True if steps are adaptive.
   elemental logical function active(self)
      class(run_goal_t), intent(in) :: self
      active = self%accuracy > 0.0_wp .or. self%local_tolerance > 0.0_wp .or. self%error_rate > 0.0_wp
   end function active

end module nutate_run_plan
