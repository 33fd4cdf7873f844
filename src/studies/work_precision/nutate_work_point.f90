!> A point of a work-precision diagram: one run of one method, its wall time from repeated integrations and its errors
!> from a separate integration; and the point between two runs at which the error has a given value.
module nutate_work_point
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper, methods, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_reference, only: reference_t
   use nutate_status, only: status_t
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: run_monitor_t, outcome_t, problem_t, run_once, run_to_tolerance, settings_of
   implicit none
   private

   public :: work_point_t, measure_point, point_at_error, point_within, median

   !> Integrations that are timed, at least and at most: a median of three is not moved by one that was disturbed; a
   !> run short enough to be repeated 501 times is known to a per cent by then.
   integer, parameter :: fewest_samples = 3, most_samples = 501

   !> Share of the steps that may be subdivided: with more the run is one at shorter steps than it says.
   real(wp), parameter :: most_subdivided = 0.1_wp

   !> Errors change sign as steps get shorter, and near there are small by accident. A run is treated as within an
   !> accuracy if the error of the next level, too, is within this many times the accuracy.
   real(wp), parameter :: confirmed = 4.0_wp

   !> One method at one step, or one tolerance of its steps.
   type :: work_point_t
      !> Row of `methods`; 0: there is no such point.
      integer :: method = 0
      !> Time step, s; the mean for adaptive steps.
      real(wp) :: time_step = 0.0_wp
      !> Error for which each step was chosen, rad; 0 if all have one length.
      real(wp) :: tolerance = 0.0_wp
      !> Nominal steps; those among them that had to be subdivided; steps of the method, parts included.
      integer(long) :: steps = 0, subdivided_steps = 0, parts = 0
      !> Integrations timed, and their median wall time, s.
      integer :: samples = 0
      real(wp) :: seconds = 0.0_wp
      !> Distance from the reference's attitude at the end, rad; negative if there is no reference.
      real(wp) :: attitude_error = -1.0_wp
      !> Worst error of the conserved momentum over |l|, and of the energy balance over T + |V|, over all steps.
      real(wp) :: momentum_error = 0.0_wp, energy_error = 0.0_wp
      !> Worst |qᵀq - 1| over all steps.
      real(wp) :: norm_error = 0.0_wp
      !> Newton iterations of a nominal step, mean.
      real(wp) :: iterations = 0.0_wp
   contains
      !> Returns true if there is such a point.
      procedure :: exists
      !> Returns the wall time of a nominal step, ns.
      procedure :: nanoseconds
      !> Returns true if too many steps had to be subdivided for the run to represent its step.
      procedure :: is_subdivided
   end type work_point_t

contains

   !> Returns true for a point that was measured or lies between two measured points.
   pure logical function exists(self)
      class(work_point_t), intent(in) :: self
      exists = self%method > 0
   end function exists

   !> Returns the wall time of a nominal step, ns.
   pure real(wp) function nanoseconds(self)
      class(work_point_t), intent(in) :: self
      nanoseconds = 1e9_wp*self%seconds/max(real(self%steps, wp), 1.0_wp)
   end function nanoseconds

   !> Returns true if too many steps had to be subdivided for the run to represent its step.
   pure logical function is_subdivided(self)
      class(work_point_t), intent(in) :: self
      is_subdivided = real(self%subdivided_steps, wp) > most_subdivided*real(self%steps, wp)
   end function is_subdivided

   !> Measures a run: first its errors, then its time, so that the one does not disturb the other. The time of a run
   !> with too many subdivided steps is not measured.
   !>
   !> Errors: those of `make_stepper` and `integrate`; `NUTATE_STEP_LIMIT` if the budget is used up.
   subroutine measure_point(problem, reference, sample, budget, point, status)
      type(problem_t), intent(in) :: problem
      type(reference_t), intent(in) :: reference
      !> Amount of the budget for which integrations are repeated, s or evaluations.
      real(wp), intent(in) :: sample
      !> Budget that limits the runs, which are added to it.
      type(study_budget_t), intent(inout) :: budget
      !> Point of which `method` and `time_step`, or `tolerance`, are given.
      type(work_point_t), intent(inout) :: point
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper

      call make_stepper(problem%system, settings_of(problem%settings, point%method), stepper, status)
      if (.not. status%ok()) return
      call measure_errors()
      if (.not. status%ok() .or. point%is_subdivided()) return
      call measure_time()

   contains

      !> Measures steps, iterations and errors.
      subroutine measure_errors()
         type(run_monitor_t) :: monitor
         type(outcome_t) :: outcome

         monitor%measures = .true.
         call monitor%invariants%start(problem%system, problem%start, problem%settings%inverse_auxiliary_inertia)
         call run(monitor, outcome)
         if (.not. status%ok()) return
         associate (summary => outcome%summary)
            point%steps = summary%steps
            if (point%tolerance > 0.0_wp) point%time_step = problem%duration()/max(real(summary%steps, wp), 1.0_wp)
            ! The closed solution gives the end without steps.
            if (methods(point%method)%order < 1) then
               point%steps = 1
               point%time_step = problem%duration()
            end if
            point%subdivided_steps = summary%subdivided_steps
            point%parts = summary%parts
            point%iterations = real(summary%iterations, wp)/max(real(summary%steps, wp), 1.0_wp)
         end associate
         if (reference%known()) point%attitude_error = attitude_distance(outcome%state%q, reference%q)
         point%momentum_error = monitor%invariants%momentum_error()
         point%energy_error = monitor%invariants%energy_error()
         point%norm_error = monitor%invariants%norm_error
      end subroutine measure_errors

      !> Measures the median wall time of integrations from the start to the end. Each has a stepper that is prepared
      !> anew, so that all do the same work; preparing is not part of the time.
      subroutine measure_time()
         type(run_monitor_t) :: monitor
         type(outcome_t) :: outcome
         real(wp) :: samples(most_samples), begun

         begun = budget%spent()
         point%samples = 0
         do while (point%samples < most_samples)
            call stepper%prepare(problem%system, settings_of(problem%settings, point%method), status)
            if (.not. status%ok()) return
            call run(monitor, outcome)
            if (.not. status%ok()) return
            samples(point%samples + 1) = outcome%seconds
            point%samples = point%samples + 1
            if (point%samples >= fewest_samples .and. budget%spent() - begun >= sample) exit
         end do
         point%seconds = median(samples(1:point%samples))
      end subroutine measure_time

      !> Performs one integration, at the given step or to the given tolerance, and adds it to the budget.
      subroutine run(monitor, outcome)
         type(run_monitor_t), intent(inout) :: monitor
         type(outcome_t), intent(out) :: outcome
         monitor%budget = budget
         monitor%stages = methods(point%method)%stages
         if (point%tolerance > 0.0_wp) then
            call run_to_tolerance(problem, settings_of(problem%settings, point%method), point%tolerance, monitor, &
                                  outcome, status)
         else
            call run_once(problem, stepper, point%time_step, monitor, outcome, status)
         end if
         budget%evaluations = monitor%budget%evaluations
      end subroutine run

   end subroutine measure_point

   !> Returns the point of a method's curve at an attitude error, by interpolation between the logarithms of errors,
   !> times and steps of two runs; none if the runs do not reach it. The error is assumed to fall no faster than the
   !> method's order, or the tolerance of its steps, implies: a longest step whose error means nothing must not make the
   !> next one look better than it is.
   pure function point_at_error(points, order, error) result(point)
      !> Points of one method, longest step first, with errors that are known; shape (any).
      type(work_point_t), intent(in) :: points(:)
      integer, intent(in) :: order
      !> Attitude error, rad.
      real(wp), intent(in) :: error
      type(work_point_t) :: point
      integer :: i
      real(wp) :: fraction, fall

      i = first_within(points, error)
      if (i == 0) return
      point = points(i)
      if (i == 1 .or. .not. point%attitude_error > 0.0_wp) return
      associate (long => points(i - 1), short => points(i))
         fall = real(order, wp)*log(long%time_step/short%time_step)
         if (short%tolerance > 0.0_wp) fall = log(long%tolerance/short%tolerance)
         fraction = log(error/short%attitude_error)/min(log(long%attitude_error/short%attitude_error), fall)
         fraction = min(max(fraction, 0.0_wp), 1.0_wp)
         point%tolerance = between(short%tolerance, long%tolerance, fraction)
         point%time_step = between(short%time_step, long%time_step, fraction)
         point%seconds = between(short%seconds, long%seconds, fraction)
         point%energy_error = between(short%energy_error, long%energy_error, fraction)
      end associate
   end function point_at_error

   !> Returns the first run whose error is within a given one, and not by accident: no point if there is none.
   pure function point_within(points, error) result(point)
      !> Points of one method, longest step first, with errors that are known; shape (any).
      type(work_point_t), intent(in) :: points(:)
      !> Attitude error, rad.
      real(wp), intent(in) :: error
      type(work_point_t) :: point
      integer :: i
      i = first_within(points, error)
      if (i > 0) point = points(i)
   end function point_within

   !> Returns a value between two on a logarithmic scale; the first if one of them has no logarithm.
   pure real(wp) function between(a, b, fraction)
      !> Values of the same sign.
      real(wp), intent(in) :: a, b
      !> Fraction of the way: 0 at a, 1 at b.
      real(wp), intent(in) :: fraction
      between = a
      if (abs(a) > 0.0_wp .and. abs(b) > 0.0_wp) between = a*(b/a)**fraction
   end function between

   !> Returns the index of the longest step whose error is within a given one, and not by accident; 0 if there is none.
   pure integer function first_within(points, error) result(i)
      type(work_point_t), intent(in) :: points(:)
      !> Attitude error, rad.
      real(wp), intent(in) :: error
      do i = 1, size(points)
         if (points(i)%attitude_error > error) cycle
         if (i == size(points)) return
         if (points(i + 1)%attitude_error <= confirmed*error) return
      end do
      i = 0
   end function first_within

   !> Returns the middle one of some values, or the mean of the two in the middle.
   pure real(wp) function median(values)
      !> At least one value; shape (any).
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

end module nutate_work_point
