!> What a run costs and what it is good for: wall time of repeated integrations, errors from a pass of their own.
module nutate_run_cost
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_quaternion, only: attitude_distance
   use nutate_reference, only: reference_t
   use nutate_run, only: run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: follower_t, problem_t, run_once, run_to_tolerance, settings_of
   implicit none
   private

   public :: run_cost_t, measure_cost, median

   !> Integrations that are timed: at least, at most.
   integer, parameter :: fewest_samples = 3, most_samples = 501

   !> Share of the steps that may be cut.
   real(wp), parameter :: most_cut = 0.1_wp

   !> One method at one step.
   type :: run_cost_t
      !> Row of `methods`.
      integer :: method = 0
      !> s; the mean where steps were chosen.
      real(wp) :: time_step = 0.0_wp
      !> Error for which each step was chosen, rad; 0 where all have one length.
      real(wp) :: tolerance = 0.0_wp
      !> Nominal steps; those among them that had to be cut into parts; steps of the method, parts included.
      integer(long) :: steps = 0, cut_steps = 0, parts = 0
      !> Integrations timed, and their median wall time, s.
      integer :: samples = 0
      real(wp) :: seconds = 0.0_wp
      !> Distance from the reference's attitude at the end, rad; negative where there is no reference.
      real(wp) :: attitude_error = -1.0_wp
      !> Worst error of the conserved momentum over |l|, and of the energy account over T + |V|, over all steps.
      real(wp) :: momentum_error = 0.0_wp, energy_error = 0.0_wp
      !> Worst |qᵀq - 1| over all steps.
      real(wp) :: norm_error = 0.0_wp
      !> Newton iterations of a nominal step, mean.
      real(wp) :: iterations = 0.0_wp
   contains
      !> Wall time of a nominal step, ns.
      procedure :: nanoseconds
      !> Too many steps had to be cut for the run to stand for its step.
      procedure :: is_cut_up
   end type run_cost_t

contains

   !> Wall time of a nominal step, ns.
   pure real(wp) function nanoseconds(self)
      class(run_cost_t), intent(in) :: self
      nanoseconds = 1e9_wp*self%seconds/max(real(self%steps, wp), 1.0_wp)
   end function nanoseconds

   !> Too many steps had to be cut for the run to stand for its step.
   pure logical function is_cut_up(self)
      class(run_cost_t), intent(in) :: self
      is_cut_up = real(self%cut_steps, wp) > most_cut*real(self%steps, wp)
   end function is_cut_up

   !> Measures a run: first its errors, then its time, so that the one does not disturb the other. The time of a run
   !> that is cut up is not measured.
   !>
   !> Errors: those of `make_stepper` and `integrate`; `NUTATE_STEP_LIMIT` where the time is over.
   subroutine measure_cost(problem, reference, sample_seconds, clock, deadline, cost, status)
      type(problem_t), intent(in) :: problem
      type(reference_t), intent(in) :: reference
      !> Integrations are repeated until they have taken so long, s.
      real(wp), intent(in) :: sample_seconds
      type(stopwatch_t), intent(in) :: clock
      !> Reading of the clock at which all must be over, s.
      real(wp), intent(in) :: deadline
      !> Its `method` and `time_step`, or `tolerance`, say what to run.
      type(run_cost_t), intent(inout) :: cost
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper

      call make_stepper(problem%system, settings_of(problem%settings, cost%method), stepper, status)
      if (.not. status%ok()) return
      call measure_errors(problem, reference, stepper, clock, deadline, cost, status)
      if (.not. status%ok() .or. cost%is_cut_up()) return
      call measure_time(problem, stepper, sample_seconds, clock, deadline, cost, status)
   end subroutine measure_cost

   !> Steps, iterations and errors.
   subroutine measure_errors(problem, reference, stepper, clock, deadline, cost, status)
      type(problem_t), intent(in) :: problem
      type(reference_t), intent(in) :: reference
      class(stepper_t), intent(inout) :: stepper
      type(stopwatch_t), intent(in) :: clock
      real(wp), intent(in) :: deadline
      type(run_cost_t), intent(inout) :: cost
      type(status_t), intent(out) :: status
      type(follower_t) :: follower
      type(state_t) :: state
      type(run_summary_t) :: summary
      real(wp) :: seconds

      follower%clock = clock
      follower%deadline = deadline
      follower%measures = .true.
      call follower%invariants%start(problem%system, problem%start, problem%settings%inverse_auxiliary_inertia)
      call run(problem, stepper, cost, follower, state, summary, seconds, status)
      if (.not. status%ok()) return
      cost%steps = summary%steps
      if (cost%tolerance > 0.0_wp) cost%time_step = problem%duration()/max(real(summary%steps, wp), 1.0_wp)
      cost%cut_steps = summary%cut_steps
      cost%parts = summary%parts
      cost%iterations = real(summary%iterations, wp)/max(real(summary%steps, wp), 1.0_wp)
      if (reference%known()) cost%attitude_error = attitude_distance(state%q, reference%q)
      cost%momentum_error = follower%invariants%momentum_error()
      cost%energy_error = follower%invariants%energy_error()
      cost%norm_error = follower%invariants%norm_error
   end subroutine measure_errors

   !> Median wall time of integrations from the start to the end. Each has a stepper that is prepared anew, so that all
   !> do the same work; preparing is not part of the time.
   subroutine measure_time(problem, stepper, sample_seconds, clock, deadline, cost, status)
      type(problem_t), intent(in) :: problem
      class(stepper_t), intent(inout) :: stepper
      real(wp), intent(in) :: sample_seconds
      type(stopwatch_t), intent(in) :: clock
      real(wp), intent(in) :: deadline
      type(run_cost_t), intent(inout) :: cost
      type(status_t), intent(out) :: status
      type(follower_t) :: follower
      type(state_t) :: state
      type(run_summary_t) :: summary
      real(wp) :: samples(most_samples), spent

      follower%clock = clock
      follower%deadline = deadline
      spent = 0.0_wp
      cost%samples = 0
      do while (cost%samples < most_samples)
         call stepper%prepare(problem%system, settings_of(problem%settings, cost%method), status)
         if (.not. status%ok()) return
         call run(problem, stepper, cost, follower, state, summary, samples(cost%samples + 1), status)
         if (.not. status%ok()) return
         cost%samples = cost%samples + 1
         spent = spent + samples(cost%samples)
         if (cost%samples >= fewest_samples .and. spent >= sample_seconds) exit
      end do
      cost%seconds = median(samples(1:cost%samples))
   end subroutine measure_time

   !> One integration, at the step or to the tolerance asked for.
   subroutine run(problem, stepper, cost, follower, state, summary, seconds, status)
      type(problem_t), intent(in) :: problem
      !> Prepared; used for steps of one length.
      class(stepper_t), intent(inout) :: stepper
      type(run_cost_t), intent(in) :: cost
      type(follower_t), intent(inout) :: follower
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      real(wp), intent(out) :: seconds
      type(status_t), intent(out) :: status
      if (cost%tolerance > 0.0_wp) then
         call run_to_tolerance(problem, settings_of(problem%settings, cost%method), cost%tolerance, follower, state, &
                               summary, seconds, status)
      else
         call run_once(problem, stepper, cost%time_step, follower, state, summary, seconds, status)
      end if
   end subroutine run

   !> The middle one of some values, or the mean of the two in the middle.
   pure real(wp) function median(values)
      !> At least one; shape (any).
      real(wp), intent(in) :: values(:)
      real(wp) :: sorted(size(values)), value
      integer :: i, k
      sorted = values
      do i = 2, size(sorted)
         value = sorted(i)
         k = i - 1
         do while (k > 0)
            if (sorted(k) <= value) exit
            sorted(k + 1) = sorted(k)
            k = k - 1
         end do
         sorted(k + 1) = value
      end do
      k = size(sorted)
      median = 0.5_wp*(sorted((k + 1)/2) + sorted(k/2 + 1))
   end function median

end module nutate_run_cost
