!> The ladder of a cost study: every method at one step, then at half of it, and so on; a method that chooses its steps
!> at one tolerance, then at a tenth of it. A method leaves where a shorter
!> step does not help any more, and where its next run would take more than its share of the time left.
module nutate_step_ladder
   use nutate_kinds, only: wp
   use nutate_methods, only: methods
   use nutate_reference, only: reference_t
   use nutate_run_cost, only: measure_cost, run_cost_t
   use nutate_status, only: status_t, NUTATE_STEP_LIMIT
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: problem_t
   implicit none
   private

   public :: step_ladder_t, CLIMBING, ROUND_OFF, OUT_OF_TIME, REFUSED, LAST_RUNG

   !> Where a method stands: under way; at round-off; at the end of the time; refused by the method; at the last rung.
   integer, parameter :: CLIMBING = 0, ROUND_OFF = 1, OUT_OF_TIME = 2, REFUSED = 3, LAST_RUNG = 4

   !> Turn in the longest step, rad.
   real(wp), parameter :: longest_turn = 4.0_wp
   !> Largest error of the steps that a method chooses, rad.
   real(wp), parameter :: loosest = 1e-2_wp
   !> Rungs, with and without a reference.
   integer, parameter :: most_rungs = 24, rungs_without_reference = 8
   !> A rung that makes the error smaller by less than this factor is no gain; so many of them end the ladder, where the
   !> error has been below this, rad.
   real(wp), parameter :: gain = 0.7_wp, converging = 1e-2_wp
   integer, parameter :: patience = 2
   !> Share of the whole time for which a run is repeated.
   real(wp), parameter :: sample_share = 7e-4_wp

   type :: step_ladder_t
      !> All runs, in the order made; shape (number of runs).
      type(run_cost_t), allocatable :: runs(:)
      !> `CLIMBING`, ...; shape (rows of `methods`).
      integer :: ending(size(methods)) = CLIMBING
      !> Why methods were refused; shape (rows of `methods`).
      type(status_t) :: refusal(size(methods))
      !> The longest step, s.
      real(wp) :: longest_step = 0.0_wp
      logical :: done = .false.
      !> Row of `methods` whose turn it is, and halvings of its step.
      integer, private :: method = 1, rung = 0
      !> By method: best error, rad; rungs without gain; wall time spent on the last rung, s.
      real(wp), private :: best(size(methods)) = huge(1.0_wp), spent(size(methods)) = 0.0_wp
      integer, private :: stale(size(methods)) = 0
   contains
      !> Chooses the longest step.
      procedure :: begin
      !> Makes the next run.
      procedure :: climb
      !> The runs of a method, longest step first.
      procedure :: runs_of
   end type step_ladder_t

contains

   !> Chooses the longest step: a power of two times the step that the user has in mind, if there is one.
   subroutine begin(self, problem, rate, time_step)
      class(step_ladder_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      !> Largest |Ω| of the motion, rad/s.
      real(wp), intent(in) :: rate
      !> The user's step, s; 0 for none.
      real(wp), intent(in) :: time_step
      real(wp) :: longest

      longest = abs(problem%duration())
      if (longest*rate > longest_turn) longest = longest_turn/rate
      if (abs(time_step) > 0.0_wp) then
         self%longest_step = scale(time_step, floor(log(longest/abs(time_step))/log(2.0_wp)))
      else
         self%longest_step = problem%duration()/(aint(0.999_wp*abs(problem%duration())/longest) + 1)
      end if
      allocate (self%runs(0))
      ! A method without an order has no step to choose.
      where (methods%order < 1) self%ending = REFUSED
      self%done = .not. any(self%ending == CLIMBING)
   end subroutine begin

   !> Makes the next run, if it can be expected to end in its share of the time, and moves on.
   subroutine climb(self, problem, reference, clock, deadline)
      class(step_ladder_t), intent(inout) :: self
      type(problem_t), intent(in) :: problem
      type(reference_t), intent(in) :: reference
      type(stopwatch_t), intent(in) :: clock
      !> Reading of the clock at which all must be over, s.
      real(wp), intent(in) :: deadline
      type(run_cost_t) :: cost
      type(status_t) :: status
      real(wp) :: begun, share

      if (self%ending(self%method) == CLIMBING) then
         begun = clock%seconds()
         share = (deadline - begun)/real(count(self%ending(self%method:) == CLIMBING), wp)
         if (share <= 2*self%spent(self%method)) then
            self%ending(self%method) = OUT_OF_TIME
         else
            cost%method = self%method
            cost%time_step = scale(self%longest_step, -self%rung)
            if (methods(self%method)%dense) cost%tolerance = loosest*0.1_wp**self%rung
            ! The cost of the first run is not known: it must not eat up the time of the other methods.
            call measure_cost(problem, reference, sample_share*deadline, clock, min(deadline, begun + 1.5_wp*share), &
                              cost, status)
            self%spent(self%method) = clock%seconds() - begun
            call take_run(self, cost, reference, status)
         end if
      end if
      self%method = self%method + 1
      if (self%method > size(methods)) then
         self%method = 1
         self%rung = self%rung + 1
      end if
      self%done = .not. any(self%ending == CLIMBING)
   end subroutine climb

   !> Keeps a run and finds out whether its method goes on. Steps that are too long to be taken at all are passed over.
   subroutine take_run(self, cost, reference, status)
      class(step_ladder_t), intent(inout) :: self
      type(run_cost_t), intent(in) :: cost
      type(reference_t), intent(in) :: reference
      !> What the run came to.
      type(status_t), intent(in) :: status
      integer :: rungs

      rungs = most_rungs
      if (.not. reference%known()) rungs = rungs_without_reference
      associate (m => cost%method)
         if (status%ok() .and. .not. cost%is_cut_up()) then
            self%runs = [self%runs, cost]
            if (reference%known() .and. no_gain(self, cost, reference%uncertainty)) self%ending(m) = ROUND_OFF
         else if (status%code == NUTATE_STEP_LIMIT) then
            self%ending(m) = OUT_OF_TIME
         else if (.not. status%ok() .and. (self%rung + 1 == rungs .or. status%subject /= '')) then
            self%ending(m) = REFUSED
            self%refusal(m) = status
         end if
         if (self%ending(m) == CLIMBING .and. self%rung + 1 == rungs) self%ending(m) = LAST_RUNG
      end associate
   end subroutine take_run

   !> Notes the error of a run; true if shorter steps of its method are not worth while.
   logical function no_gain(self, cost, uncertainty)
      class(step_ladder_t), intent(inout) :: self
      type(run_cost_t), intent(in) :: cost
      !> Of the reference, rad.
      real(wp), intent(in) :: uncertainty
      associate (m => cost%method, error => max(cost%attitude_error, uncertainty))
         self%stale(m) = self%stale(m) + 1
         if (error < gain*self%best(m)) self%stale(m) = 0
         self%best(m) = min(self%best(m), error)
         no_gain = self%stale(m) >= patience .and. self%best(m) < converging
      end associate
   end function no_gain

   !> The runs of a method, longest step first.
   pure function runs_of(self, method) result(runs)
      class(step_ladder_t), intent(in) :: self
      !> Row of `methods`.
      integer, intent(in) :: method
      type(run_cost_t), allocatable :: runs(:)
      runs = pack(self%runs, self%runs%method == method)
   end function runs_of

end module nutate_step_ladder
