!> A work-precision study of a problem: error and run time of every method.
!>
!> Every method is run at level 0, then at level 1, and so on: each level has half the step of the one before, or, for
!> methods that choose their steps, a tenth of its tolerance. A method ends if a further level does not help any more,
!> and if its next run would take more than its share of the budget left.
module nutate_work_precision
   use nutate_kinds, only: wp
   use nutate_methods, only: methods
   use nutate_reference, only: reference_methods, reference_t
   use nutate_status, only: status_t, NUTATE_STEP_LIMIT, NUTATE_STOPPED
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: fastest_rate, specialised_rate, problem_t
   use nutate_work_point, only: measure_point, work_point_t
   implicit none
   private

   public :: work_precision_t, longest_step, UNDER_WAY, ROUND_OFF, OUT_OF_BUDGET, REFUSED, LAST_LEVEL

   !> State of a method: under way; at round-off; at the end of the budget; refused by the method; at the last level.
   integer, parameter :: UNDER_WAY = 0, ROUND_OFF = 1, OUT_OF_BUDGET = 2, REFUSED = 3, LAST_LEVEL = 4

   !> Share of the budget that the reference may take: most scenes need less, and without one there are no errors.
   real(wp), parameter :: reference_share = 0.3_wp
   !> Rotation in the longest step, rad: the conserving step has its limit there (docs/explanation/scheme.md), explicit
   !> steps have it before; for `rk8` in special variables, by their rate.
   real(wp), parameter :: longest_turn = 4.0_wp
   !> Largest error of the steps that a method chooses, rad: with larger ones such a method takes its longest step.
   real(wp), parameter :: loosest = 1e-2_wp
   !> Levels, with and without a reference: 2⁻²³ of 4 rad brings even order 2 to round-off; if errors do not show when
   !> to stop, two decades of steps show the times and the invariants.
   integer, parameter :: most_levels = 24, levels_without_reference = 8
   !> A level that makes the error smaller by less than this factor is no gain (order 2 gains 4); so many of them end a
   !> method, since one may be an accident, where the error has been below `converging`, rad: above it, errors of
   !> steps that are too long may rise before they fall. Levels whose tolerance exceeds
   !> the error are not among them: something else limited their steps.
   real(wp), parameter :: gain = 0.7_wp, converging = 1e-2_wp
   integer, parameter :: patience = 2
   !> Share of the budget for which a run is repeated: 14 methods at some 10 levels then spend a tenth on it.
   real(wp), parameter :: sample_share = 7e-4_wp
   !> A run may take so many times its method's share: the cost of a first run is not known, and must not use up the
   !> shares of the other methods.
   real(wp), parameter :: overdraft = 1.5_wp

   type :: work_precision_t
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(study_budget_t) :: budget
      !> Largest |Ω| of the motion, rad/s.
      real(wp) :: rate = 0.0_wp
      !> All runs, in the order made; shape (number of runs).
      type(work_point_t), allocatable :: points(:)
      !> State of each method, `UNDER_WAY`, ...; shape (rows of `methods`).
      integer :: ending(size(methods)) = UNDER_WAY
      !> Status with which each method was rejected, or else of its last run that failed; shape (rows of `methods`).
      type(status_t) :: refusal(size(methods))
      logical :: done = .false.
      !> Step of level 0, by method, s.
      real(wp), private :: first_step(size(methods)) = 0.0_wp
      !> Row of `methods` to be run next, and its level.
      integer, private :: method = 1, level = 0
      !> By method: best error, rad; levels without gain; amount spent on the last level, s or evaluations.
      real(wp), private :: best(size(methods)) = huge(1.0_wp), spent(size(methods)) = 0.0_wp
      integer, private :: stale(size(methods)) = 0
   contains
      !> Starts the study of a problem.
      procedure :: begin
      !> Does the next part of the study: a level of the reference, or a run.
      procedure :: advance
      !> Returns the runs of a method, longest step first.
      procedure :: points_of
   end type work_precision_t

contains

   !> Starts the study of a problem: looks for the fastest rotation and for a closed solution.
   subroutine begin(self, problem, time_step, budget)
      class(work_precision_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      !> A step that is to be among those of the study, s; 0 for none.
      real(wp), intent(in) :: time_step
      !> Budget with its limit set.
      type(study_budget_t), intent(in) :: budget
      type(study_budget_t) :: part
      type(status_t) :: status
      integer :: first, second
      self%problem = problem
      self%budget = budget
      call self%budget%start()
      call reference_methods(first, second)
      ! Errors of the trial run are reported by the runs themselves.
      part = reference_budget(self)
      call fastest_rate(problem, first, self%rate, status, part)
      self%budget%evaluations = part%evaluations
      call self%reference%begin(problem, self%rate)
      self%first_step = longest_step(problem%duration(), self%rate, time_step)
      where (methods%specialised) self%first_step = longest_step(problem%duration(), min(self%rate, &
         specialised_rate(problem)), &
                                                          time_step)
      allocate (self%points(0))
   end subroutine begin

   !> Does the next part of the study: a level of the reference until that is settled, then a run.
   subroutine advance(self)
      class(work_precision_t), intent(inout) :: self
      type(study_budget_t) :: part
      if (self%reference%settled) then
         call run_next(self)
         self%done = .not. any(self%ending == UNDER_WAY)
      else
         part = reference_budget(self)
         call self%reference%refine(self%problem, part)
         self%budget%evaluations = part%evaluations
      end if
   end subroutine advance

   !> Returns the budget with the share that the reference may take, the trial run before it included.
   pure type(study_budget_t) function reference_budget(self) result(part)
      class(work_precision_t), intent(in) :: self
      part = self%budget%limited_to(reference_share*self%budget%limit)
   end function reference_budget

   !> Returns the longest step of a study, s: a power of two times a given one, if there is one, else a part of the
   !> whole time.
   pure real(wp) function longest_step(duration, rate, time_step)
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> Largest |Ω| of the motion, rad/s.
      real(wp), intent(in) :: rate
      !> Given step, s; of the sign of the duration, or 0 for none.
      real(wp), intent(in) :: time_step
      real(wp) :: longest
      longest = abs(duration)
      if (longest*rate > longest_turn) longest = longest_turn/rate
      if (abs(time_step) > 0.0_wp) then
         longest_step = scale(time_step, floor(log(longest/abs(time_step))/log(2.0_wp)))
      else
         longest_step = duration/(aint(0.999_wp*abs(duration)/longest) + 1)
      end if
   end function longest_step

   !> Makes the next run, if it is expected to end within its share of the budget, and moves on.
   subroutine run_next(self)
      class(work_precision_t), intent(inout) :: self
      type(work_point_t) :: point
      type(study_budget_t) :: part
      type(status_t) :: status
      real(wp) :: begun, share

      if (self%ending(self%method) == UNDER_WAY) then
         begun = self%budget%spent()
         share = (self%budget%limit - begun)/real(count(self%ending(self%method:) == UNDER_WAY), wp)
         if (share <= 2*self%spent(self%method)) then
            self%ending(self%method) = OUT_OF_BUDGET
         else
            point%method = self%method
            point%time_step = scale(self%first_step(self%method), -self%level)
            if (methods(self%method)%dense) point%tolerance = loosest*0.1_wp**self%level
            part = self%budget%limited_to(begun + overdraft*share)
            call measure_point(self%problem, self%reference, sample_share*self%budget%limit, part, point, status)
            self%budget%evaluations = part%evaluations
            self%spent(self%method) = self%budget%spent() - begun
            call store_point(self, point, status)
         end if
      end if
      self%method = self%method + 1
      if (self%method > size(methods)) then
         self%method = 1
         self%level = self%level + 1
      end if
   end subroutine run_next

   !> Keeps a run and finds out whether its method goes on. Steps that are too long to be taken at all are passed over.
   subroutine store_point(self, point, status)
      class(work_precision_t), intent(inout) :: self
      type(work_point_t), intent(in) :: point
      !> Status of the run.
      type(status_t), intent(in) :: status
      integer :: levels

      if (status%code == NUTATE_STOPPED) return
      levels = most_levels
      if (.not. self%reference%known()) levels = levels_without_reference
      ! The closed solution has no steps to be shortened.
      if (methods(point%method)%order < 1) levels = 1
      associate (m => point%method)
         if (status%ok() .and. .not. point%is_subdivided()) then
            self%points = [self%points, point]
            if (self%reference%known()) then
               if (no_gain(self, point)) self%ending(m) = ROUND_OFF
            end if
         else if (status%code == NUTATE_STEP_LIMIT) then
            self%ending(m) = OUT_OF_BUDGET
         else if (.not. status%ok()) then
            self%refusal(m) = status
            if (self%level + 1 == levels .or. status%subject /= '') self%ending(m) = REFUSED
         end if
         if (self%ending(m) == UNDER_WAY .and. self%level + 1 == levels) self%ending(m) = LAST_LEVEL
      end associate
   end subroutine store_point

   !> Records the error of a run; returns true if shorter steps of its method are not worthwhile.
   logical function no_gain(self, point)
      class(work_precision_t), intent(inout) :: self
      type(work_point_t), intent(in) :: point
      associate (m => point%method, error => max(point%attitude_error, self%reference%uncertainty))
         self%stale(m) = self%stale(m) + 1
         if (error < gain*self%best(m) .or. point%tolerance > error) self%stale(m) = 0
         self%best(m) = min(self%best(m), error)
         no_gain = self%stale(m) >= patience .and. self%best(m) < converging
      end associate
   end function no_gain

   !> Returns the runs of a method, longest step first.
   pure function points_of(self, method) result(points)
      class(work_precision_t), intent(in) :: self
      !> Row of `methods`.
      integer, intent(in) :: method
      type(work_point_t), allocatable :: points(:)
      points = pack(self%points, self%points%method == method)
   end function points_of

end module nutate_work_precision
