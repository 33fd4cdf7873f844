!> The budget of a work-precision study: wall time, or evaluations of the equations of motion.
!>
!> A budget in evaluations makes the same runs on every machine, however fast or busy it is: no decision of the study
!> then depends on a clock.
module nutate_study_budget
   use nutate_kinds, only: wp, long
   use nutate_stopwatch, only: stopwatch_t
   implicit none
   private

   public :: study_budget_t

   type :: study_budget_t
      !> Largest amount that may be spent: s, or evaluations.
      real(wp) :: limit = huge(1.0_wp)
      !> True for a budget in evaluations.
      logical :: is_in_evaluations = .false.
      !> Evaluations spent, counted for either kind: for each step of a method the evaluations or solutions of the
      !> equations that the table of methods gives (`stages`).
      integer(long) :: evaluations = 0
      !> Wall time since the study began.
      type(stopwatch_t) :: clock
   contains
      !> Starts to count from zero.
      procedure :: start
      !> Returns the amount spent, s or evaluations.
      procedure :: spent
      !> Returns the amount left, not negative, s or evaluations.
      procedure :: left
      !> Returns true once the wall time is used up. A budget in evaluations limits the steps of runs instead
      !> (`most_steps`).
      procedure :: time_is_over
      !> Returns the most steps that a run may take, at least one.
      procedure :: most_steps
      !> Adds a run to the evaluations spent.
      procedure :: count_run
      !> Returns a copy of the budget with a smaller limit.
      procedure :: limited_to
   end type study_budget_t

contains

   !> Starts to count from zero.
   subroutine start(self)
      class(study_budget_t), intent(inout) :: self
      self%evaluations = 0
      call self%clock%start()
   end subroutine start

   !> Returns the amount spent, s or evaluations.
   real(wp) function spent(self)
      class(study_budget_t), intent(in) :: self
      if (self%is_in_evaluations) then
         spent = real(self%evaluations, wp)
      else
         spent = self%clock%seconds()
      end if
   end function spent

   !> Returns the amount left, not negative, s or evaluations.
   real(wp) function left(self)
      class(study_budget_t), intent(in) :: self
      left = max(self%limit - self%spent(), 0.0_wp)
   end function left

   !> Returns true once the wall time is used up; false for a budget in evaluations, or without a limit: no clock is
   !> read then.
   logical function time_is_over(self)
      class(study_budget_t), intent(in) :: self
      time_is_over = .not. self%is_in_evaluations .and. self%limit < huge(1.0_wp)
      if (time_is_over) time_is_over = self%clock%seconds() > self%limit
   end function time_is_over

   !> Returns the most steps that a run may take, at least one; `huge` for a budget in wall time.
   integer(long) function most_steps(self, stages) result(steps)
      class(study_budget_t), intent(in) :: self
      !> Evaluations in a step.
      integer, intent(in) :: stages
      steps = huge(1_long)
      if (.not. self%is_in_evaluations) return
      if (self%left() < 0.5_wp*real(steps, wp)) steps = max(int(self%left(), long)/stages, 1_long)
   end function most_steps

   !> Adds a run to the evaluations spent. A run without steps is treated as one of a single step.
   subroutine count_run(self, steps, stages)
      class(study_budget_t), intent(inout) :: self
      !> Steps of the method, with parts of subdivided steps.
      integer(long), intent(in) :: steps
      !> Evaluations in a step.
      integer, intent(in) :: stages
      self%evaluations = self%evaluations + max(steps, 1_long)*stages
   end subroutine count_run

   !> Returns a copy of the budget, the amount spent included, with a smaller limit.
   pure type(study_budget_t) function limited_to(self, limit) result(part)
      class(study_budget_t), intent(in) :: self
      !> Limit, s or evaluations.
      real(wp), intent(in) :: limit
      part = self
      part%limit = min(self%limit, limit)
   end function limited_to

end module nutate_study_budget
