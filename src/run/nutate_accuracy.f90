!> From the attitude error that is asked for at the end of a run to the error that its steps may make.
!>
!> What steps and round-off do on the way grows by a factor that belongs to the motion: pilot runs measure it. Pilot A has
!> a larger tolerance than the run B and *noise* η in every step, some twentieth of that tolerance, so that it is off by
!> errors of every kind, each in a direction of its own. How far it ends from B tells what errors of B's size come to,
!> and, with round-off ε in the place of η, what is left of it however short the steps are: the *floor*.
!>
!> The constants are measured: `make accuracy` runs random scenes against an oracle of higher precision and writes the
!> table in docs/accuracy.md. They belong to the error behaviour of the methods, and are to be measured anew where that
!> changes.
module nutate_accuracy
   use nutate_error_control, only: error_control_t
   use nutate_hamiltonian, only: angular_velocity, make_state
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: method_of, method_t
   use nutate_noise, only: noise_t
   use nutate_observer, only: observer_t
   use nutate_progress, only: progress_t, start_run
   use nutate_quaternion, only: attitude_distance, quat_norm, quat_product
   use nutate_run_loop, only: drive
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_status, only: status_t, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: find_tolerance

   !> How the error of a method follows the tolerance of its steps.
   type :: behaviour_t
      !> The first B has the accuracy over this as its tolerance.
      real(wp) :: caution
      !> Tolerance of the first A over that of B.
      real(wp) :: ratio
      !> Errors fall at least as the tolerance to this power.
      real(wp) :: power
      !> Round-off that steps make, in units of the response to noise of ½ε.
      real(wp) :: round_off
   end type behaviour_t

   !> Of the series; of explicit steps; of implicit ones, whose errors go as their order p: `power` is p/(p + 1) of it.
   type(behaviour_t), parameter :: of_series = behaviour_t(100.0_wp, 1e3_wp, 0.75_wp, 8.0_wp), &
                                   of_explicit = behaviour_t(30.0_wp, 100.0_wp, 0.8_wp, 6.0_wp), &
                                   of_halves = behaviour_t(100.0_wp, 100.0_wp, 0.84_wp, 5.0_wp)

   !> Tolerance of A and of B at most: a step that errs by more follows no motion. The smallest tolerance of use, far
   !> below round-off.
   real(wp), parameter :: coarsest_a = 1e-3_wp, coarsest_b = 1e-4_wp, finest = 1e-17_wp
   !> Noise over the tolerance of its run.
   real(wp), parameter :: noise_part = 0.05_wp
   !> A and B farther apart than this measure nothing, rad: their tolerances are then divided by `much_finer`, unless that
   !> leads below `hopeless`. Where a pilot with noise fails, by `finer`.
   real(wp), parameter :: too_far = 0.1_wp, much_finer = 1e3_wp, hopeless = 1e-15_wp, finer = 1e2_wp
   !> The difference of A and B times this over the gain from A to B bounds the error of B.
   real(wp), parameter :: margin = 1.5_wp
   !> The gain that is believed at most, as its inverse, from runs of fewer than `few_steps`; and where the steps grew by
   !> less than `hardly_more`.
   integer(long), parameter :: few_steps = 6
   real(wp), parameter :: gain_of_few = 0.03_wp, gain_of_equals = 0.1_wp, hardly_more = 1.15_wp
   !> A floor above this part of the accuracy is measured twice, and the larger counts.
   real(wp), parameter :: doubtful_floor = 1.0_wp/30.0_wp
   !> Bounds that the floor alone keeps from being met are below this times the floor.
   real(wp), parameter :: about_floor = 1.5_wp
   !> The next tolerance aims at the accuracy over the first; errors go as tolerances to the second power; the change of
   !> the tolerance at a time.
   real(wp), parameter :: aim = 2.5_wp, usual_power = 0.9_wp, most_change = 1e-5_wp, least_change = 0.1_wp
   !> Pairs of runs at most.
   integer, parameter :: most_rounds = 9

   !> A run of one tolerance.
   type :: pilot_t
      !> rad a step.
      real(wp) :: tolerance = 0.0_wp
      type(noise_t) :: noise
      !> At its end.
      type(progress_t) :: progress
   contains
      procedure :: run => run_pilot
      procedure :: steps => steps_of
   end type pilot_t

   !> What the runs so far tell.
   type :: search_t
      type(behaviour_t) :: behaviour
      type(method_t) :: method
      !> rad.
      real(wp) :: accuracy = 0.0_wp
      type(pilot_t) :: coarse, fine
      !> The pilots with noise, for the floor, and how many there are.
      type(pilot_t) :: noisy(2)
      integer :: n_noisy = 0
      !> Draws of noise so far: each has numbers of its own.
      integer :: draws = 0
      !> Bound on the error of the finer run, and the part of round-off in it, rad.
      real(wp) :: truncation = huge(1.0_wp), floor = 0.0_wp
   end type search_t

contains

   !> The tolerance of steps that makes the attitude error at the end time at most the accuracy of the goal, and a bound on
   !> that error. Where round-off or instability keep the accuracy out of reach, the bound and the part of round-off in it
   !> stay above the accuracy. A method without an error needs no pilots.
   !>
   !> Errors: those of the runs, and what the observer returned.
   subroutine find_tolerance(system, settings, progress, status, observer, last)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> At its start, not its end. The `local_tolerance` of its goal, `estimate` and `round_off` of its summary are set.
      type(progress_t), intent(inout) :: progress
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Shown the first and the last state of each run; its `poll` can end the search.
      class(observer_t), intent(inout), optional :: observer
      !> The end of a run with the tolerance that was found, rows apart.
      type(progress_t), intent(inout), optional :: last
      type(search_t) :: search
      logical :: fresh, done
      integer :: round

      search%method = method_of(settings)
      search%accuracy = progress%plan%goal%accuracy
      if (search%method%order < 1) progress%plan%goal%local_tolerance = search%accuracy
      if (search%method%order < 1) return
      search%behaviour = behaviour_of(search%method)
      search%fine%tolerance = max(finest, min(coarsest_b, search%accuracy/search%behaviour%caution))
      search%coarse%tolerance = min(coarsest_a, search%behaviour%ratio*search%fine%tolerance)
      fresh = .true.
      do round = 1, most_rounds
         if (fresh) call run_noisy(search, system, settings, progress, status, observer)
         if (status%ok()) call search%fine%run(system, settings, progress, status, observer)
         if (.not. status%ok()) return
         fresh = distance(search%coarse, search%fine) >= too_far
         if (fresh) then
            search%truncation = distance(search%coarse, search%fine)
            done = search%fine%tolerance < much_finer*hopeless
            if (.not. done) call refine_both(search, much_finer)
         else
            call judge(search, system, settings, progress, status, observer)
            if (.not. status%ok()) return
            done = is_done(search)
            if (.not. done .and. round < most_rounds) call refine(search)
         end if
         if (done) exit
      end do
      progress%plan%goal%local_tolerance = search%fine%tolerance
      progress%summary%estimate = max(search%truncation, search%floor)
      progress%summary%round_off = search%floor
      if (present(last)) last = search%fine%progress
   end subroutine find_tolerance

   !> How the error of a method follows the tolerance.
   pure type(behaviour_t) function behaviour_of(method) result(behaviour)
      type(method_t), intent(in) :: method
      if (method%dense) then
         behaviour = of_series
      else if (method%estimate_power > 0) then
         behaviour = of_explicit
      else
         behaviour = of_halves
         behaviour%power = behaviour%power*real(method%order, wp)/real(method%order + 1, wp)
      end if
   end function behaviour_of

   !> Runs the coarser pilot with noise; where it fails, one with smaller tolerances. Errors: those of a run that shorter
   !> steps do not help.
   subroutine run_noisy(search, system, settings, progress, status, observer)
      type(search_t), intent(inout) :: search
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(progress_t), intent(in) :: progress
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      type(status_t) :: success
      do
         call draw(search, search%coarse)
         call search%coarse%run(system, settings, progress, status, observer)
         search%n_noisy = 1
         search%noisy(1) = search%coarse
         if (all(status%code /= [NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH])) return
         if (search%fine%tolerance < finer*hopeless) return
         status = success
         call refine_both(search, finer)
      end do
   end subroutine run_noisy

   !> Gives a pilot noise with numbers of its own.
   pure subroutine draw(search, pilot)
      type(search_t), intent(inout) :: search
      type(pilot_t), intent(inout) :: pilot
      type(noise_t) :: noise
      real(wp) :: x
      integer :: i
      search%draws = search%draws + 1
      noise%state = noise%state + search%draws
      do i = 1, 8
         call noise%next(x)
      end do
      noise%amplitude = noise_part*pilot%tolerance
      pilot%noise = noise
   end subroutine draw

   !> Makes both tolerances smaller.
   pure subroutine refine_both(search, factor)
      type(search_t), intent(inout) :: search
      real(wp), intent(in) :: factor
      search%fine%tolerance = max(finest, search%fine%tolerance/factor)
      search%coarse%tolerance = min(search%coarse%tolerance, coarsest_a)/factor
   end subroutine refine_both

   !> What the last two runs tell of the error of the finer one. Errors: those of another pilot.
   subroutine judge(search, system, settings, progress, status, observer)
      type(search_t), intent(inout) :: search
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(progress_t), intent(in) :: progress
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      type(status_t) :: success
      search%truncation = gain_of(search)*distance(search%coarse, search%fine)
      search%floor = floor_of(search)
      if (search%floor <= doubtful_floor*search%accuracy .or. search%n_noisy > 1) return
      search%noisy(2) = search%noisy(1)
      call draw(search, search%noisy(2))
      call search%noisy(2)%run(system, settings, progress, status, observer)
      if (any(status%code == [NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH])) then
         status = success
      else if (status%ok()) then
         search%n_noisy = 2
         search%floor = floor_of(search)
      end if
   end subroutine judge

   !> Error of the finer run over the difference of both, with a margin.
   pure real(wp) function gain_of(search) result(gain)
      type(search_t), intent(in) :: search
      real(wp) :: ratio
      ratio = search%coarse%tolerance/search%fine%tolerance
      gain = min(1.0_wp, margin/ratio**search%behaviour%power)
      associate (coarse => search%coarse%steps(), fine => search%fine%steps())
         if (min(coarse, fine) < few_steps) gain = max(gain, gain_of_few)
         if (.not. search%method%dense .and. real(fine, wp) < hardly_more*real(coarse, wp)) gain = max(gain, gain_of_equals)
      end associate
   end function gain_of

   !> What round-off makes of the attitude at the end of the finer run, rad: the response to noise, with ½ε for η, and more
   !> the more steps there are. Implicit steps take part in the noise at the start only.
   pure real(wp) function floor_of(search) result(floor)
      type(search_t), intent(in) :: search
      real(wp) :: more, response
      integer :: i
      response = 0.0_wp
      more = real(search%fine%steps() + 4, wp)
      do i = 1, search%n_noisy
         associate (pilot => search%noisy(i))
            more = real(search%fine%steps() + 4, wp)
            if (search%method%projected .or. .not. search%method%conserving) more = more/real(pilot%steps() + 4, wp)
            response = max(response, sqrt(more)*distance(pilot, search%fine)/pilot%noise%amplitude)
         end associate
      end do
      floor = max(search%behaviour%round_off*0.5_wp*eps*response, eps*sqrt(real(search%fine%steps(), wp)))
   end function floor_of

   !> True where the accuracy is met, or where the floor is all that is left to keep it from being.
   pure logical function is_done(search)
      type(search_t), intent(in) :: search
      is_done = max(search%truncation, search%floor) <= search%accuracy .or. &
                (search%floor > search%accuracy .and. search%truncation <= about_floor*search%floor) .or. &
                search%fine%tolerance <= finest
   end function is_done

   !> The next, smaller tolerance; the finer run becomes the coarser one.
   pure subroutine refine(search)
      type(search_t), intent(inout) :: search
      real(wp) :: factor, power
      power = usual_power
      if (search%method%estimate_power == 0 .and. .not. search%method%dense) &
         power = min(power, real(search%method%order, wp)/real(search%method%order + 1, wp))
      factor = (max(search%accuracy, search%floor)/(aim*search%truncation))**(1/power)
      search%coarse = search%fine
      search%fine%tolerance = max(finest, search%fine%tolerance*min(least_change, max(most_change, factor)))
   end subroutine refine

   !> Angle between the ends of two runs, rad.
   pure real(wp) function distance(one, other)
      type(pilot_t), intent(in) :: one, other
      distance = attitude_distance(one%progress%state%q, other%progress%state%q)
   end function distance

   !> Steps that a run took.
   pure integer(long) function steps_of(self)
      class(pilot_t), intent(in) :: self
      steps_of = max(self%progress%summary%steps, 1_long)
   end function steps_of

   !> Runs a pilot, without rows.
   subroutine run_pilot(self, system, settings, progress, status, observer)
      class(pilot_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> The run to come, at its start.
      type(progress_t), intent(in) :: progress
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      type(error_control_t) :: control
      type(run_plan_t) :: plan
      plan = progress%plan
      plan%goal = run_goal_t(local_tolerance=self%tolerance)
      plan%interval = 0.0_wp
      plan%every = huge(plan%every)
      call start_run(self%progress, system%effects, progress%state, plan, status)
      if (self%noise%amplitude > 0.0_wp) call disturb_start(self, system)
      if (status%ok()) call control%begin(system, settings, self%progress, status)
      if (self%noise%amplitude > 0.0_wp .and. status%ok()) call control%disturb(self%noise)
      if (status%ok()) call drive(self%progress, control, system, status, observer)
   end subroutine run_pilot

   !> Moves the first attitude by η rad and the first angular velocity by η of its size, in directions of the noise.
   subroutine disturb_start(self, system)
      class(pilot_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp) :: turn(3), change(3), omega(3), q(4)
      call self%noise%vector(turn)
      call self%noise%vector(change)
      associate (state => self%progress%state)
         omega = angular_velocity(system, state)
         omega = omega + (self%noise%amplitude*norm2(omega)/norm2(change))*change
         q = quat_product(state%q, [1.0_wp, 0.5_wp*turn])
         state = make_state(system, q/quat_norm(q), omega, state%t)
      end associate
   end subroutine disturb_start

end module nutate_accuracy
