!> Finds the error allowed in the steps of a run from the attitude error requested at its end.
!>
!> Errors of steps and round-off grow on the way by a factor that depends on the motion: trial runs measure it. Trial
!> run A has a larger tolerance than the run B and *noise* η in its data and in every step, a twentieth of that
!> tolerance, so that it contains errors of every kind, each in a random direction. The distance of its end from that of
!> B shows the effect of errors of B's size, and, with round-off ε instead of η, the part that remains however short the
!> steps are: the *floor*. Two ends can be close by coincidence: in doubt there are two such trial runs, and every
!> earlier run is used.
!>
!> The constants are measured: `make accuracy` runs random scenes against an oracle of higher precision and writes the
!> tables in docs/results/accuracy-costs.md. They describe the error behaviour of the methods: measure them again if it
!> changes.
module nutate_accuracy
   use nutate_effect_base, only: NO_SERIES
   use nutate_disturbance, only: disturb_problem
   use nutate_effect_list, only: effect_list_t, table_order
   use nutate_equal_steps, only: equal_steps_t
   use nutate_error_control, only: error_control_t
   use nutate_exact_stepper, only: round_off_of_exact
   use nutate_hamiltonian, only: body_momentum
   use nutate_kinds, only: wp, eps, long, pi
   use nutate_methods, only: method_of, method_t, system_t
   use nutate_noise, only: noise_t
   use nutate_observer, only: observer_t
   use nutate_progress, only: progress_t, start_run, watch_limits
   use nutate_quaternion, only: attitude_distance, quat_norm
   use nutate_run_loop, only: drive
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH, &
      NUTATE_STEP_LIMIT
   use nutate_integrator_settings, only: integrator_settings_t
   implicit none
   private

   public :: find_tolerance

   !> Dependence of the error of a method on the tolerance of its steps.
   type :: behaviour_t
      !> Accuracy over the tolerance of the first B.
      real(wp) :: caution
      !> Tolerance of the first A over that of B.
      real(wp) :: ratio
      !> Largest tolerances of A and of B: with larger ones A does not follow a growing motion, and runs are hardly
      !> shorter.
      real(wp) :: coarsest_a, coarsest_b
      !> Errors fall at least as the tolerance to this power.
      real(wp) :: power
      !> Round-off that steps make, in units of the response to noise of ½ε.
      real(wp) :: round_off
      !> Part of the accuracy above which a bound may be met by coincidence, because two ends are close. This does not
      !> happen with the series; errors of equal steps grow by terms of several orders, which can cancel in any bound.
      real(wp) :: only_just
   end type behaviour_t

   !> Behaviour of the series; of explicit steps of order 8, and of lower order, which pay more for a smaller tolerance;
   !> of implicit steps, whose errors go as their order p: `power` is multiplied by p/(p + 1); of fixed steps, whose
   !> tolerance is a measure of their number alone: A has two in five of those of B.
   type(behaviour_t), parameter :: &
      of_series = behaviour_t(caution=1e4_wp, ratio=1e3_wp, coarsest_a=1e-5_wp, coarsest_b=1e-8_wp, &
                              power=0.75_wp, round_off=8.0_wp, only_just=1.0_wp), &
      of_explicit = behaviour_t(caution=300.0_wp, ratio=300.0_wp, coarsest_a=1e-4_wp, coarsest_b=1e-6_wp, &
                                power=0.8_wp, round_off=6.0_wp, only_just=0.2_wp), &
      of_low_order = behaviour_t(caution=30.0_wp, ratio=100.0_wp, coarsest_a=1e-3_wp, coarsest_b=1e-4_wp, &
                                 power=0.8_wp, round_off=6.0_wp, only_just=0.2_wp), &
      of_halves = behaviour_t(caution=100.0_wp, ratio=100.0_wp, coarsest_a=1e-3_wp, coarsest_b=1e-4_wp, &
                              power=0.84_wp, round_off=5.0_wp, only_just=0.2_wp), &
      of_equal_steps = behaviour_t(caution=1.0_wp, ratio=3815.0_wp, coarsest_a=1.0_wp, coarsest_b=1.0_wp, &
                                   power=0.75_wp, round_off=6.0_wp, only_just=0.0_wp)

   !> Smallest useful tolerance, far below round-off.
   real(wp), parameter :: finest = 1e-17_wp
   !> Noise over the tolerance of its run.
   real(wp), parameter :: noise_part = 0.05_wp
   !> Largest distance between A and B that carries information, rad: beyond it their tolerances are divided by
   !> `much_finer`, unless that leads below `hopeless`. If a trial run with noise fails, they are divided by `finer`.
   real(wp), parameter :: too_far = 0.1_wp, much_finer = 1e3_wp, hopeless = 1e-15_wp, finer = 1e2_wp
   !> The difference of A and B times this over the gain from A to B bounds the error of B.
   real(wp), parameter :: margin = 1.5_wp
   !> Inverse of the largest gain that is trusted: from runs of fewer than `few_steps` steps; if the number of steps
   !> grew by a factor below `hardly_more`.
   integer(long), parameter :: few_steps = 6
   real(wp), parameter :: gain_of_few = 0.03_wp, gain_of_equals = 0.1_wp, hardly_more = 1.15_wp
   !> Tolerance of the second trial run over that of the first; largest tolerance of the second.
   real(wp), parameter :: other_ratio = 10.0_wp, coarsest_other = 1e-2_wp
   !> Tolerance of the second trial run over that of the first for the series: that run only measures the response to
   !> noise, and a coarse one costs half.
   real(wp), parameter :: other_ratio_of_series = 1e4_wp
   !> Factor by which the response to one draw of noise may be smaller than that to another by coincidence.
   real(wp), parameter :: by_accident = 50.0_wp
   !> Part of the accuracy above which a floor is measured twice, and the larger value is used.
   real(wp), parameter :: doubtful_floor = 1.0_wp/30.0_wp
   !> Number of steps beyond which errors are treated as additive: under torques the momentum grows by similar
   !> increments, whose rounding errors no longer cancel from step to step.
   real(wp), parameter :: cancelling_steps = 1000.0_wp
   !> Error of an attitude that is unknown, rad.
   real(wp), parameter :: unknown = pi
   !> Bounds that the floor alone keeps from being met are below this times the floor.
   real(wp), parameter :: about_floor = 1.5_wp
   !> The next tolerance aims at the accuracy over the first; errors go as tolerances to the second power; the change of
   !> the tolerance at a time.
   real(wp), parameter :: aim = 2.5_wp, usual_power = 0.9_wp, most_change = 1e-5_wp, least_change = 0.1_wp
   !> Part of the gain by the order of an interpolation which shows that its error follows the order.
   real(wp), parameter :: believed_order = 0.5_wp
   !> Largest number of steps of a trial run: runs of low order that would need hours end with a message after minutes.
   integer(long), parameter :: most_steps = 100000000_long
   !> Largest number of pairs of runs; of runs, with two trial runs for each pair.
   integer, parameter :: most_rounds = 9, most_runs = 3*most_rounds

   !> Data kept of a run.
   type :: trial_t
      !> Error allowed in a step, rad.
      real(wp) :: tolerance = 0.0_wp
      !> Noise η.
      real(wp) :: noise = 0.0_wp
      !> Attitude at the end; shape (4).
      real(wp) :: q(4) = 0.0_wp
      !> Largest angular momentum at its start and its end, N m s.
      real(wp) :: momentum = 0.0_wp
      integer(long) :: steps = 1
   end type trial_t

   !> State of the search: its settings, and the results of the runs so far.
   type :: search_t
      type(behaviour_t) :: behaviour
      type(method_t) :: method
      !> Attitude error allowed at the end, rad.
      real(wp) :: accuracy = 0.0_wp
      !> There are torques.
      logical :: drifts = .false.
      !> Rotation in the duration by a unit of angular momentum, rad/(N m s).
      real(wp) :: leverage = 0.0_wp
      !> Tolerances of A and B.
      real(wp) :: coarse = 0.0_wp, fine = 0.0_wp
      !> The runs so far; the last is B.
      type(trial_t) :: runs(most_runs)
      integer :: n = 0
      !> Trial runs with noise in the last pair.
      integer :: n_noisy = 0
      !> B is the first run after those with noise.
      logical :: first_pair = .true.
      !> Bound on the error of the last run, and the part of round-off in it, rad.
      real(wp) :: truncation = huge(1.0_wp), floor = 0.0_wp
   end type search_t

contains

   !> Finds the tolerance of steps with which the attitude error at the end time is at most the accuracy of the goal,
   !> and estimates that error. If round-off or instability keep the accuracy out of reach, the estimate and the part of
   !> round-off in it stay above the accuracy. A method without a truncation error needs no trial runs: its only error
   !> is that of round-off.
   !>
   !> Errors: those of the runs, and what the observers returned.
   subroutine find_tolerance(system, settings, progress, control, status, observer, last, trial_observer)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> Run at its start, not at its end. The `local_tolerance` of its goal, `estimate` and `round_off` of its summary
      !> and `expected_steps` are set.
      type(progress_t), intent(inout) :: progress
      !> Step policy begun for the run; its steppers perform the trial runs. Begin it again for the run itself.
      type(error_control_t), intent(inout) :: control
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Receives the first and the last state of each run; its `poll` can end the search.
      class(observer_t), intent(inout), optional :: observer
      !> Run with the tolerance that was found, at its end; without its output points.
      type(progress_t), intent(inout), optional :: last
      !> Receives the output points at steps of runs without noise, from the first state on; finally those of `last`.
      class(observer_t), intent(inout), optional :: trial_observer
      type(search_t) :: search
      type(progress_t) :: own
      logical :: fresh, at_limit
      search%method = method_of(settings)
      search%accuracy = progress%plan%goal%accuracy
      if (search%method%order < 1) then
         progress%plan%goal%local_tolerance = search%accuracy
         progress%summary%round_off = round_off_of_exact(system, progress%state, &
                                                         progress%plan%end_time - progress%state%t)
         progress%summary%estimate = progress%summary%round_off
         return
      end if
      call set_first_pair(search, control%equal)
      call compare_runs()
      if (.not. status%ok()) return
      progress%plan%goal%local_tolerance = search%fine
      progress%summary%estimate = max(search%truncation, search%floor)
      progress%summary%round_off = search%floor
      progress%expected_steps = own%summary%steps
      if (present(last)) last = own
      call add_table_error()

   contains

      !> Performs pairs of runs with smaller and smaller tolerances. Errors: those of the runs.
      subroutine compare_runs()
         logical :: done
         integer :: round
         search%drifts = system%effects%n_works() > 0
         search%leverage = abs(progress%plan%end_time - progress%state%t)/minval(system%body%moments)
         fresh = .true.
         do round = 1, most_rounds
            if (fresh) call run_noisy()
            if (status%ok()) call run_fine(round == 1)
            if (.not. status%ok()) return
            call measure_errors(search, fresh)
            if (at_limit) exit
            if (.not. fresh .and. is_doubtful(search)) then
               call run_other()
               if (.not. status%ok()) return
               call measure_errors(search, fresh)
            end if
            done = is_done(search)
            if (fresh) done = search%fine < much_finer*hopeless
            if (done .or. round == most_rounds) exit
            if (fresh) call refine_both(search, much_finer)
            if (.not. fresh) call refine(search)
         end do
      end subroutine compare_runs

      !> Performs the first trial run with noise; if it fails, again with smaller tolerances. Errors: those of a run for
      !> which shorter steps do not help.
      subroutine run_noisy()
         type(status_t) :: success
         do
            call run_trial(system, search%coarse, noise_part*search%coarse, own)
            if (.not. went_astray(status)) exit
            if (search%fine < finer*hopeless) return
            status = success
            call refine_both(search, finer)
         end do
         if (.not. status%ok()) return
         search%n_noisy = 1
         search%first_pair = .true.
      end subroutine run_noisy

      !> Runs B. If round-off keeps the error of a step above its tolerance, repeats it with larger tolerances, at most
      !> that of an earlier run. Errors: those of the run.
      subroutine run_fine(first)
         !> There is no earlier run without noise.
         logical, intent(in) :: first
         type(status_t) :: success
         real(wp) :: known
         call run_trial(system, search%fine, 0.0_wp, own, trial_observer)
         at_limit = went_astray(status) .and. .not. first
         if (.not. at_limit) return
         known = merge(much_finer*search%fine, search%coarse, fresh)
         do while (went_astray(status) .and. search%fine < known)
            status = success
            search%fine = min(known, finer*search%fine)
            call run_trial(system, search%fine, 0.0_wp, own, trial_observer)
         end do
      end subroutine run_fine

      !> Performs the second trial run with noise, and stores it before the last run. A failure of it does no harm.
      subroutine run_other()
         type(progress_t) :: other
         type(trial_t) :: before
         type(status_t) :: success
         real(wp) :: tolerance
         search%n_noisy = 2
         before = search%runs(search%n)
         tolerance = min(other_ratio_here(search)*search%coarse, coarsest_other)
         call run_trial(system, tolerance, noise_part*tolerance, other)
         if (status%ok()) then
            search%runs(search%n - 1) = search%runs(search%n)
            search%runs(search%n) = before
         else if (went_astray(status)) then
            status = success
         end if
      end subroutine run_other

      !> Adds the error of tables of orbits to the estimate, by runs with every second and every fourth line of them. If
      !> both differ as the order p of the interpolation predicts, half the lines make the error 2ᵖ times as large, so
      !> that the difference over 2ᵖ - 1 is the error; else the difference bounds it.
      subroutine add_table_error()
         type(progress_t) :: last_run
         type(system_t) :: thinned
         type(status_t) :: success
         real(wp) :: q(4), differences(2), gain
         integer :: i
         gain = 2.0_wp**table_order(system%effects)
         if (table_order(system%effects) == 0) return
         thinned = system
         differences = unknown
         do i = 1, 2
            call thinned%effects%thin_tables()
            q = search%runs(search%n)%q
            search%n = min(search%n, most_runs - 1)
            call run_trial(thinned, search%fine, 0.0_wp, last_run)
            if (.not. (status%ok() .or. went_astray(status))) return
            if (.not. status%ok()) exit
            differences(i) = attitude_distance(q, search%runs(search%n)%q)
         end do
         status = success
         progress%summary%table_error = differences(1)
         if (differences(2) >= believed_order*gain*differences(1)) &
            progress%summary%table_error = differences(1)/(gain - 1)
         progress%summary%estimate = progress%summary%estimate + progress%summary%table_error
      end subroutine add_table_error

      !> Performs a run with a tolerance, without output points. Errors: those of the run.
      subroutine run_trial(there, tolerance, noise, trial, watcher)
         type(system_t), intent(in) :: there
         !> Tolerance, rad, and noise η.
         real(wp), intent(in) :: tolerance, noise
         !> Progress of the trial run, at its end on exit.
         type(progress_t), intent(inout) :: trial
         !> Observer in place of `observer`, for runs without noise, with output points at steps.
         class(observer_t), intent(inout), optional :: watcher
         type(run_plan_t) :: plan
         plan = progress%plan
         plan%goal = run_goal_t(accuracy=search%accuracy, local_tolerance=tolerance)
         plan%interval = 0.0_wp
         if (allocated(plan%times)) deallocate (plan%times)
         if (.not. present(watcher)) plan%every = huge(plan%every)
         plan%max_steps = min(plan%max_steps, most_steps)
         if (noise > 0.0_wp) then
            call drive_noisy(noise_of(noise, search%n), plan, trial)
         else
            call start_run(trial, there%effects, progress%state, plan, status)
            if (status%ok()) call control%begin(there, settings, trial, status)
            if (status%ok()) call watch_limits(trial, there, status)
            if (status%ok() .and. present(watcher)) then
               call drive(trial, control, there, status, watcher)
            else if (status%ok()) then
               call drive(trial, control, there, status, observer)
            end if
         end if
         if (status%code == NUTATE_STEP_LIMIT) status = fail(NUTATE_STEP_LIMIT, needs_more(plan%max_steps))
         if (.not. status%ok()) return
         search%n = search%n + 1
         search%runs(search%n) = trial_t(tolerance, noise, trial%state%q, &
                                         max(momentum_of(progress%state), momentum_of(trial%state)), &
                                         max(trial%summary%steps, 1_long))
      end subroutine run_trial

      !> Performs a run with noise in its data, its initial state, its clock and its steps.
      subroutine drive_noisy(source, nominal, trial)
         type(noise_t), intent(in) :: source
         type(run_plan_t), intent(in) :: nominal
         type(progress_t), intent(inout) :: trial
         type(noise_t) :: noise
         type(system_t) :: noisy
         type(state_t) :: state
         type(run_plan_t) :: plan
         real(wp) :: shift
         noise = source
         noisy = system
         state = progress%state
         plan = nominal
         call disturb_problem(noise, noisy, state)
         ! Effects with given times act a little earlier or later; the duration is the same.
         call noise%next(shift)
         shift = shift*max(abs(state%t), abs(plan%end_time))
         if (has_user_torques(noisy%effects)) shift = 0.0_wp
         state%t = state%t + shift
         plan%end_time = plan%end_time + shift
         call start_run(trial, noisy%effects, state, plan, status)
         if (status%ok()) call control%begin(noisy, settings, trial, status)
         if (status%ok()) call watch_limits(trial, noisy, status)
         if (.not. status%ok()) return
         call control%disturb(noise)
         call drive(trial, control, noisy, status, observer)
      end subroutine drive_noisy

   end subroutine find_tolerance

   !> Sets the tolerances of the first pair of runs.
   pure subroutine set_first_pair(search, equal)
      type(search_t), intent(inout) :: search
      !> Fixed steps, if they suit.
      type(equal_steps_t), intent(in) :: equal
      search%behaviour = behaviour_of(search%method)
      if (equal%suit) search%behaviour = of_equal_steps
      associate (behaviour => search%behaviour)
         search%fine = max(finest, min(behaviour%coarsest_b, search%accuracy/behaviour%caution))
         if (equal%suit) search%fine = max(finest, equal%tolerance_for(search%accuracy))
         search%coarse = min(behaviour%coarsest_a, behaviour%ratio*search%fine)
      end associate
   end subroutine set_first_pair

   !> Returns the dependence of the error of a method on the tolerance.
   pure type(behaviour_t) function behaviour_of(method) result(behaviour)
      type(method_t), intent(in) :: method
      if (method%dense) then
         behaviour = of_series
      else if (method%estimate_power > 0) then
         behaviour = of_explicit
         if (method%order < 8) behaviour = of_low_order
      else
         behaviour = of_halves
         behaviour%power = behaviour%power*real(method%order, wp)/real(method%order + 1, wp)
      end if
   end function behaviour_of

   !> Returns the tolerance of the second trial run with noise over that of the first; a trial run that ends too far
   !> apart would be no second opinion.
   pure real(wp) function other_ratio_here(search) result(ratio)
      type(search_t), intent(in) :: search
      real(wp) :: distance
      distance = 0.0_wp
      if (search%n > 1) distance = attitude_distance(search%runs(search%n - 1)%q, search%runs(search%n)%q)
      ratio = merge(other_ratio_of_series, other_ratio, search%method%dense)
      if (distance*ratio*by_accident > too_far) ratio = max(1.0_wp, too_far/(by_accident*distance))
   end function other_ratio_here

   !> Returns true for failures that shorter steps may avoid.
   pure logical function went_astray(status)
      type(status_t), intent(in) :: status
      went_astray = any(status%code == [NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH])
   end function went_astray

   !> Makes both tolerances smaller.
   pure subroutine refine_both(search, factor)
      type(search_t), intent(inout) :: search
      real(wp), intent(in) :: factor
      search%fine = max(finest, search%fine/factor)
      search%coarse = search%coarse/factor
   end subroutine refine_both

   !> Sets the next, smaller tolerance of B.
   pure subroutine refine(search)
      type(search_t), intent(inout) :: search
      real(wp) :: factor, power
      power = usual_power
      if (search%method%estimate_power == 0 .and. .not. search%method%dense) &
         power = min(power, real(search%method%order, wp)/real(search%method%order + 1, wp))
      factor = (max(search%accuracy, search%floor)/(aim*search%truncation))**(1/power)
      search%first_pair = .false.
      search%coarse = search%fine
      search%fine = max(finest, search%fine*min(least_change, max(most_change, factor)))
   end subroutine refine

   !> Estimates the error of the last run from the earlier ones.
   pure subroutine measure_errors(search, astray)
      type(search_t), intent(inout) :: search
      !> The estimate failed: the runs of the pair are too far apart.
      logical, intent(out) :: astray
      real(wp) :: distance, response, more
      integer :: i
      search%truncation = 0.0_wp
      response = 0.0_wp
      astray = .true.
      associate (fine => search%runs(search%n))
         do i = 1, search%n - 1
            associate (run => search%runs(i))
               distance = attitude_distance(run%q, fine%q)
               more = real(fine%steps + 4, wp)
               if (search%method%projected .or. .not. search%method%conserving) more = more/real(run%steps + 4, wp)
               if (run%noise > 0.0_wp) response = max(response, sqrt(more)*distance/run%noise)
               if (distance >= too_far) cycle
               if (run%tolerance <= search%coarse) astray = .false.
               search%truncation = max(search%truncation, gain_of(search, run, fine)*distance)
            end associate
         end do
         if (search%drifts) response = response*max(1.0_wp, sqrt(real(fine%steps, wp)/cancelling_steps))
         search%floor = max(search%behaviour%round_off*0.5_wp*eps*response, eps*sqrt(real(fine%steps, wp)), &
                            error_of_rounded_momentum(search, fine))
      end associate
      if (astray) search%truncation = unknown
   end subroutine measure_errors

   !> Returns the attitude error of the rounding of q and p, rad. Each is stored to half an ε, so that the body momentum
   !> L = ½ q* p is known to ε |L| along every axis: about that of the least moment J the rate has the error ε |L|/J,
   !> however slowly the body rotates about it. The noise, which is relative to the rate, does not contain this error
   !> of a needle. A body that spins about its axis of greatest moment nutates instead, and errs less. The projection
   !> restores the rate after each step, and compensated sums keep it in conserving steps; in other methods the errors
   !> of the steps add up as a random walk.
   pure real(wp) function error_of_rounded_momentum(search, fine) result(error)
      type(search_t), intent(in) :: search
      !> Run without noise.
      type(trial_t), intent(in) :: fine
      error = eps*fine%momentum*search%leverage
      if (.not. (search%method%projected .or. search%method%conserving)) error = error*sqrt(real(fine%steps, wp))
      error = min(error, unknown)
   end function error_of_rounded_momentum

   !> Returns the size of the angular momentum of a state, N m s.
   pure real(wp) function momentum_of(state)
      type(state_t), intent(in) :: state
      momentum_of = quat_norm([0.0_wp, body_momentum(state)])
   end function momentum_of

   !> Returns a bound on the error of a run over its distance from a coarser one.
   pure real(wp) function gain_of(search, coarse, fine) result(gain)
      type(search_t), intent(in) :: search
      type(trial_t), intent(in) :: coarse, fine
      real(wp) :: equals
      gain = min(1.0_wp, margin*(fine%tolerance/coarse%tolerance)**search%behaviour%power)
      if (min(coarse%steps, fine%steps) < few_steps) gain = max(gain, gain_of_few)
      if (search%method%dense .or. real(fine%steps, wp) >= hardly_more*real(coarse%steps, wp)) return
      ! The errors of both runs are much alike, and cancel: the response to noise is left, and the errors of steps are
      ! below their tolerance.
      equals = gain_of_equals
      if (coarse%noise > 0.0_wp) equals = min(equals, fine%tolerance/coarse%noise)
      gain = max(gain, equals)
   end function gain_of

   !> Returns true if another trial run with noise is needed: for a floor that matters, and before a bound that the
   !> first pair only just meets is trusted, if the method has such accidents.
   pure logical function is_doubtful(search)
      type(search_t), intent(in) :: search
      is_doubtful = search%floor > doubtful_floor*search%accuracy
      if (search%first_pair) is_doubtful = is_doubtful .or. (search%truncation <= search%accuracy .and. &
                             search%truncation > search%behaviour%only_just*search%accuracy)
      is_doubtful = is_doubtful .and. search%n_noisy == 1
   end function is_doubtful

   !> Returns true if the accuracy is met, if only the floor prevents that, or at the smallest tolerance.
   pure logical function is_done(search)
      type(search_t), intent(in) :: search
      is_done = max(search%truncation, search%floor) <= search%accuracy .or. &
                (search%floor > search%accuracy .and. search%truncation <= about_floor*search%floor) .or. &
                search%fine <= finest
   end function is_done

   !> Returns the message for a trial run that ends at the limit of steps.
   pure function needs_more(limit) result(message)
      integer(long), intent(in) :: limit
      character(len=80) :: message
      write (message, '("the accuracy needs more than ",i0," steps of this method")') limit
   end function needs_more

   !> Returns noise with different random numbers for each run.
   pure type(noise_t) function noise_of(amplitude, draw) result(noise)
      real(wp), intent(in) :: amplitude
      !> Number of runs before.
      integer, intent(in) :: draw
      real(wp) :: x
      integer :: i
      noise%state = noise%state + draw
      do i = 1, 8
         call noise%next(x)
      end do
      noise%amplitude = amplitude
   end function noise_of

   !> Returns true if a torque may be user-defined: it may be defined from the start of the run to its end only.
   pure logical function has_user_torques(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_user_torques = any([(effects%torques(i)%item%series_kind() == NO_SERIES, i=1, effects%n_torques)])
   end function has_user_torques

end module nutate_accuracy
