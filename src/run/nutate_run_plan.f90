!> Plan of a run: time step or accuracy goal, end time, output points.
module nutate_run_plan
   use nutate_kinds, only: wp, eps, long
   use nutate_limits, only: same_time
   implicit none
   private

   public :: run_plan_t, run_goal_t, count_steps, step_margin

   !> Accuracy goal of adaptive steps; one of these is set, or none for fixed steps.
   type :: run_goal_t
      !> Attitude error at the end time, rad: trial runs turn it into a `local_tolerance`.
      real(wp) :: accuracy = 0.0_wp
      !> Error of a step, rad.
      real(wp) :: local_tolerance = 0.0_wp
      !> Error of a step over its length, rad/s.
      real(wp) :: error_rate = 0.0_wp
   contains
      !> Returns true if steps are adaptive.
      procedure :: active
   end type run_goal_t

   !> Steps, end time and output points of a run.
   type :: run_plan_t
      !> Fixed step, s; negative to integrate backward. Not used if the goal is active.
      real(wp) :: time_step = 0.0_wp
      !> End time, s; huge: not yet set.
      real(wp) :: end_time = huge(1.0_wp)
      !> Steps between output points.
      integer(long) :: every = 1
      !> Limit of steps (those of continuation in Δt included) and of output points at intervals; the run ends there.
      integer(long) :: max_steps = huge(1_long)
      !> Fixed steps of this length done before the run, and their first time, s: the steps of this run then end where
      !> those of a single run would.
      integer(long) :: steps_before = 0
      real(wp) :: first_time = 0.0_wp
      !> Number of fixed steps; negative: up to the end time.
      integer(long) :: steps = -1
      !> Time between output points, s, for adaptive steps; 0: every `every` steps.
      real(wp) :: interval = 0.0_wp
      !> Times of the output points, s, in the order of the run; if allocated, there are no others. Shape (any).
      real(wp), allocatable :: times(:)
      type(run_goal_t) :: goal = run_goal_t()
   end type run_plan_t

contains

   !> Returns true if steps are adaptive.
   elemental logical function active(self)
      class(run_goal_t), intent(in) :: self
      active = self%accuracy > 0.0_wp .or. self%local_tolerance > 0.0_wp .or. self%error_rate > 0.0_wp
   end function active

   !> Returns the number of nominal steps from a time to the plan's end, the shortened last one included; for more than
   !> can be counted, the largest count there is.
   pure integer(long) function count_steps(t, plan) result(n)
      !> Time to count from, s.
      real(wp), intent(in) :: t
      type(run_plan_t), intent(in) :: plan
      real(wp) :: ratio
      ratio = (plan%end_time - t)/plan%time_step
      if (ratio >= real(huge(n), wp)) then
         n = huge(n)
      else
         n = int(ratio, long)
         if (ratio - real(n, wp) > same_time + time_noise(t, plan%end_time, plan%time_step)/abs(plan%time_step)) &
            n = n + 1
      end if
   end function count_steps

   !> Returns the rounding error of a time of the run, s: far from zero more than `same_time` of a step, but less than a
   !> step.
   pure real(wp) function time_noise(t, end_time, time_step)
      !> Time, end of the run, and nominal length, s.
      real(wp), intent(in) :: t, end_time, time_step
      time_noise = min(4*eps*max(abs(t), abs(end_time)), 0.25_wp*abs(time_step))
   end function time_noise

   !> Returns the largest difference, s, from the nominal length at which a length is still treated as nominal.
   pure real(wp) function step_margin(t, end_time, time_step)
      !> Start of the step, end of the run, and nominal length, s.
      real(wp), intent(in) :: t, end_time, time_step
      step_margin = same_time*abs(time_step) + time_noise(t, end_time, time_step)
   end function step_margin

end module nutate_run_plan
