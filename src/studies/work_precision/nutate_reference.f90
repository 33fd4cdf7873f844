!> The reference attitude for errors: exact if there is a closed solution, else the one on which two independent methods
!> agree.
!>
!> The agreed attitude comes from halving the step of both until their difference stops falling. The remaining
!> difference is the uncertainty of the attitude: neither method can hide an error of its own behind the other.
module nutate_reference
   use nutate_disturbance, only: disturb_problem
   use nutate_exact_motion, only: find_exact_attitude, EXACT_FREE_BODY, EXACT_TOP, NOT_EXACT
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_noise, only: noise_t
   use nutate_quaternion, only: attitude_distance
   use nutate_status, only: status_t
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: run_monitor_t, outcome_t, problem_t, run_once, settings_of
   implicit none
   private

   public :: reference_t, reference_methods, NO_REFERENCE, EXACT_FREE_BODY, EXACT_TOP, AGREED

   !> Kinds of reference beside the closed solutions: none, and agreement of two methods.
   integer, parameter :: NO_REFERENCE = NOT_EXACT, AGREED = 3

   !> An attitude known no better than this is no reference, rad: a study is about errors of 1e-4 and less.
   real(wp), parameter :: useless = 1e-3_wp
   !> Rotation in the first, longest step, rad: methods of order 8 begin to agree there.
   real(wp), parameter :: first_turn = 1.0_wp
   !> No attitude is known better than this, rad: round-off of q and of its distance from another.
   real(wp), parameter :: finest = 4*eps
   !> Relative sizes of disturbances, and the round-off that they stand for: that of data, by ½ε each.
   real(wp), parameter :: disturbances(2) = [1e-6_wp, 1e-9_wp], amplified = eps
   !> Levels, each with half the step of the one before, without improvement that end the search: one can be an
   !> accident. The most levels: 2⁻²³ rad is below any step at which round-off takes over.
   integer, parameter :: patience = 2, most_levels = 24

   type :: reference_t
      !> `NO_REFERENCE`, `EXACT_FREE_BODY`, `EXACT_TOP` or `AGREED`.
      integer :: kind = NO_REFERENCE
      !> Attitude at the end; shape (4).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Uncertainty of the attitude, rad.
      real(wp) :: uncertainty = huge(1.0_wp)
      !> Rows of `methods` that agree, and the step at which they agree best, s.
      integer :: pair(2) = 0
      real(wp) :: time_step = 0.0_wp
      !> True if nothing is left to be tried.
      logical :: settled = .false.
      !> Differences of the two methods at every step tried, rad; how many.
      real(wp), private :: gaps(most_levels) = 0.0_wp
      integer, private :: levels = 0
      !> Levels since the best, and the amount that the last one spent, s or evaluations.
      integer, private :: stale = 0
      real(wp), private :: last_spent = 0.0_wp
   contains
      !> Looks for a closed solution.
      procedure :: begin
      !> Tries the next step, if the budget allows.
      procedure :: refine
      !> Returns true if the attitude is known.
      procedure :: known
   end type reference_t

contains

   !> Looks for a closed solution. The solution is accurate to round-off, as amplified by the motion.
   subroutine begin(self, problem, rate)
      class(reference_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      !> Largest |Ω| of the motion, rad/s.
      real(wp), intent(in) :: rate
      real(wp) :: steps
      call find_exact_attitude(problem, self%kind, self%q)
      self%settled = self%kind /= NOT_EXACT
      if (self%settled) then
         self%uncertainty = finest + eps*rate*abs(problem%duration())
         call amplify_round_off(self, problem)
         return
      end if
      call reference_methods(self%pair(1), self%pair(2))
      steps = max(16.0_wp, aint(rate*abs(problem%duration())/first_turn) + 1)
      self%time_step = problem%duration()/steps
      self%levels = 0
   end subroutine begin

   !> Returns two rows of `methods` that have as little in common as possible: the highest order of the default method,
   !> and the highest order of another one as it is, without correction; another order of the same, if nothing better is
   !> there.
   pure subroutine reference_methods(first, second)
      integer, intent(out) :: first, second
      integer :: i, rank, best
      first = 1
      do i = 1, size(methods)
         if (methods(i)%name /= methods(1)%name) cycle
         if (methods(i)%order >= methods(first)%order) first = i
      end do
      second = first
      best = 0
      do i = 1, size(methods)
         if (methods(i)%order < 1 .or. methods(i)%projected .or. methods(i)%dense) cycle
         if (methods(i)%name == methods(first)%name .and. methods(i)%order == methods(first)%order) cycle
         rank = 2*methods(i)%order
         if (methods(i)%name /= methods(first)%name) rank = rank + 1
         if (rank < best) cycle
         best = rank
         second = i
      end do
   end subroutine reference_methods

   !> Tries the next step, if it is expected to end within the budget; otherwise, and if nothing is gained any more, the
   !> reference is settled.
   subroutine refine(self, problem, budget)
      class(reference_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      type(study_budget_t), intent(inout) :: budget
      type(status_t) :: status
      real(wp) :: time_step, q(4, 2), begun
      integer :: i

      begun = budget%spent()
      if (self%levels == most_levels .or. begun + 2*self%last_spent > budget%limit) then
         call settle(self, .false., problem, budget)
         return
      end if
      time_step = self%time_step
      if (self%levels > 0) time_step = time_step/2
      do i = 1, 2
         call end_attitude(problem, self%pair(i), time_step, budget, q(:, i), status)
         if (.not. status%ok()) then
            call settle(self, .false., problem, budget)
            return
         end if
      end do
      self%last_spent = budget%spent() - begun
      call compare_level(self, time_step, q, problem, budget)
   end subroutine refine

   !> Compares the attitudes of both methods at a step.
   subroutine compare_level(self, time_step, q, problem, budget)
      class(reference_t), intent(inout) :: self
      !> Time step, s.
      real(wp), intent(in) :: time_step
      !> Attitudes of both methods; shape (4, 2).
      real(wp), intent(in) :: q(4, 2)
      type(problem_t), intent(in) :: problem
      type(study_budget_t), intent(inout) :: budget
      real(wp) :: gap
      gap = attitude_distance(q(:, 1), q(:, 2))
      self%levels = self%levels + 1
      self%gaps(self%levels) = gap
      self%time_step = time_step
      self%stale = self%stale + 1
      if (gap < self%uncertainty) then
         if (gap < 0.5_wp*self%uncertainty) self%stale = 0
         self%uncertainty = gap
         self%q = q(:, 1)
      end if
      if (self%stale >= patience .and. self%uncertainty < useless) call settle(self, .true., problem, budget)
   end subroutine compare_level

   !> Decides how well the attitude is known.
   subroutine settle(self, by_round_off, problem, budget)
      class(reference_t), intent(inout) :: self
      !> True if the difference does not fall any more: then the smallest difference was small by accident.
      logical, intent(in) :: by_round_off
      type(problem_t), intent(in) :: problem
      type(study_budget_t), intent(inout) :: budget
      self%settled = .true.
      if (by_round_off) self%uncertainty = maxval(self%gaps(self%levels - patience:self%levels))
      self%uncertainty = max(self%uncertainty, finest)
      if (self%uncertainty <= useless) call amplify_round_off(self, problem, budget)
      if (self%uncertainty <= useless) self%kind = AGREED
   end subroutine settle

   !> Estimates amplified round-off. The attitude is known no better than data and initial state, which are rounded: a
   !> neighbouring motion, off by η, shows how the motion amplifies round-off. η need not be small: the distance of the
   !> ends then grows more slowly, so that the smaller of two η is used too.
   subroutine amplify_round_off(self, problem, budget)
      class(reference_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      !> Budget, needed if there is no closed solution.
      type(study_budget_t), intent(inout), optional :: budget
      type(problem_t) :: beside
      type(noise_t) :: noise
      type(status_t) :: status
      real(wp) :: q(4)
      integer :: i, kind
      do i = 1, size(disturbances)
         beside = problem
         noise%amplitude = disturbances(i)
         call disturb_problem(noise, beside%system, beside%start)
         if (present(budget)) then
            call end_attitude(beside, self%pair(2), self%time_step, budget, q, status)
            if (.not. status%ok()) cycle
         else
            call find_exact_attitude(beside, kind, q)
            if (kind == NOT_EXACT) cycle
         end if
         self%uncertainty = max(self%uncertainty, amplified*attitude_distance(q, self%q)/disturbances(i))
      end do
   end subroutine amplify_round_off

   !> Returns true if the attitude is known.
   pure logical function known(self)
      class(reference_t), intent(in) :: self
      known = self%kind /= NO_REFERENCE
   end function known

   !> Computes the attitude at the end of a problem by a method, with settings of its own.
   subroutine end_attitude(problem, method, time_step, budget, q, status)
      type(problem_t), intent(in) :: problem
      !> Row of `methods`.
      integer, intent(in) :: method
      !> Time step, s.
      real(wp), intent(in) :: time_step
      type(study_budget_t), intent(inout) :: budget
      real(wp), intent(out) :: q(4)
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper
      type(run_monitor_t) :: monitor
      type(outcome_t) :: outcome
      q = problem%start%q
      call make_stepper(problem%system, settings_of(integrator_settings_t(), method), stepper, status)
      if (.not. status%ok()) return
      monitor%budget = budget
      monitor%stages = methods(method)%stages
      call run_once(problem, stepper, time_step, monitor, outcome, status)
      budget%evaluations = monitor%budget%evaluations
      q = outcome%state%q
   end subroutine end_attitude

end module nutate_reference
