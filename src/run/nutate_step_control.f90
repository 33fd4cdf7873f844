!> Runs with steps chosen by their error: by the method itself before the step, where it can; else by its own estimate
!> after it, where it has one; else by Richardson's from a whole step against two halves.
!>
!> The halves are what is kept, so every invariant of the method is kept too. Rows between the ends of steps are
!> computed by the method, where it knows its states there, else by a branch: two shorter steps of the same method from
!> the start of the step, which keep the invariants and leave the run as it is.
module nutate_step_control
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: make_stepper, method_of, method_t
   use nutate_quaternion, only: attitude_distance, quat_norm
   use nutate_run, only: check_resumed, observer_t, run_plan_t, run_record_t, run_summary_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_STEP_LIMIT
   use nutate_stepper, only: dense_stepper_t, integrator_settings_t, step_goal_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: control_settings_t, integrate_controlled

   !> Part of the growth that the estimate allows which is taken.
   real(wp), parameter :: safety = 0.85_wp
   !> Bounds on the change of the step at a time; it grows only if it can by `worth_while`, since another step needs
   !> another Jacobian.
   real(wp), parameter :: most_growth = 3.0_wp, worth_while = 1.15_wp, most_shrinkage = 0.2_wp
   !> Differences between the whole and the halves below the first are noise, and up to the second may be, rad.
   real(wp), parameter :: noise = 2*eps, doubtful = 8*eps
   !> Largest turn in a step, rad: after a longer one the two results could agree by chance.
   real(wp), parameter :: largest_turn = 3.0_wp
   !> Shortest step over the length of the run.
   real(wp), parameter :: shortest = 1e-13_wp

   !> What the steps must keep to; one of the first three is set.
   type :: control_settings_t
      !> Attitude error at the end time, rad: to be turned into an `error_rate` by `find_error_rate`.
      real(wp) :: accuracy = 0.0_wp
      !> Error of a step, rad.
      real(wp) :: local_tolerance = 0.0_wp
      !> Error of a step over its length, rad/s.
      real(wp) :: error_rate = 0.0_wp
      !> Time between rows, s; 0: a row every so many steps.
      real(wp) :: interval = 0.0_wp
      !> Estimated attitude error at the end time, rad; from `find_error_rate`.
      real(wp) :: estimate = 0.0_wp
   contains
      !> True if steps are chosen by their error.
      procedure :: active
   end type control_settings_t

   !> A controlled run under way.
   type :: controller_t
      type(control_settings_t) :: goal
      type(run_plan_t) :: plan
      type(method_t) :: method
      !> Estimates go as this power of the step.
      integer :: power = 3
      !> An estimate below this is round-off, rad.
      real(wp) :: round_off = 0.0_wp
      !> The whole step, its halves (or the only one), and branches for rows; each with its own memory, where needed.
      class(stepper_t), allocatable :: whole, half, branch
      type(run_record_t) :: record
      !> Work of each torque in the step tried, J; shape (number of torques).
      real(wp), allocatable :: work(:)
      !> Largest |L| seen, kg m²/s.
      real(wp) :: momentum_scale = 0.0_wp
      !> The next step to try, s, positive.
      real(wp) :: step = 0.0_wp
      !> Longest step that may be chosen after one that failed, s.
      real(wp) :: longest = huge(1.0_wp)
      !> +1 forward, -1 backward in time.
      real(wp) :: sense = 1.0_wp
      !> Digits of the time that its sum cannot hold, s: without them the steps would not add up to the run.
      real(wp) :: t_compensation = 0.0_wp
      !> First time of the run, s, and rows at intervals so far.
      real(wp) :: t_first = 0.0_wp
      integer(long) :: rows = 0
      !> Times on which steps must end, in the order they are reached, s; the next one.
      real(wp), allocatable :: ends(:)
      integer :: next_end = 1
   contains
      procedure :: begin
      procedure :: reach
      procedure :: try
      procedure :: go_whole
      procedure :: go_halves
      procedure :: reject
      procedure :: adapt
      procedure :: growth
      procedure :: estimate
      procedure :: show
      procedure :: show_between
      procedure :: transfer => transfer_controller
      procedure :: offer
   end type controller_t

contains

   !> True if steps are chosen by their error.
   elemental logical function active(self)
      class(control_settings_t), intent(in) :: self
      active = self%accuracy > 0.0_wp .or. self%local_tolerance > 0.0_wp .or. self%error_rate > 0.0_wp
   end function active

   !> Integrates from `state` to the plan's end time with steps that keep to the goal's `error_rate` or
   !> `local_tolerance`. Rows come every so many steps, or at the goal's `interval`.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` where the goal has neither, or for an archive of another run, and those of the
   !> method; `NUTATE_NOT_CONVERGED` where no step is short enough; `NUTATE_STEP_LIMIT`; what the observer returned.
   !> `state` is then the last one reached.
   subroutine integrate_controlled(system, settings, goal, state, plan, observer, summary, status, resumed)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(control_settings_t), intent(in) :: goal
      type(state_t), intent(inout) :: state
      !> Its `time_step` does not count.
      type(run_plan_t), intent(in) :: plan
      class(observer_t), intent(inout) :: observer
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      !> What the observer's `keep` was given when this run, from the same `state` on, was under way: it goes on from
      !> there.
      class(archive_t), intent(inout), optional :: resumed
      type(controller_t) :: control

      control%goal = goal
      control%plan = plan
      allocate (summary%work(system%effects%n_torques), control%work(system%effects%n_torques), source=0.0_wp)
      call control%begin(system, settings, state, status)
      if (.not. status%ok()) return
      control%ends = [system%effects%breaks_between(state%t, plan%end_time), plan%end_time]
      if (present(resumed)) then
         call control%transfer(resumed, state, summary)
         call check_resumed(resumed, status)
      else
         call observer%observe(system, state, control%record, status)
      end if
      if (observer%wants_archive .and. status%ok()) call control%offer(state, observer, summary, status)
      do while (status%ok() .and. control%next_end <= size(control%ends))
         call control%reach(system, state, control%ends(control%next_end), observer, summary, status)
         control%next_end = control%next_end + 1
      end do
   end subroutine integrate_controlled

   !> Prepares the steppers and the first step.
   subroutine begin(self, system, settings, state, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: state
      type(status_t), intent(out) :: status
      real(wp) :: rate

      self%method = method_of(settings)
      if (self%goal%error_rate <= 0.0_wp .and. self%goal%local_tolerance <= 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a controlled run needs a tolerance')
         return
      end if
      call make_stepper(system, settings, self%half, status)
      if (.not. status%ok()) return
      if (self%method%estimate_power == 0 .and. .not. self%method%dense) &
         call make_stepper(system, settings, self%whole, status)
      if (self%goal%interval > 0.0_wp .and. .not. self%method%dense .and. status%ok()) &
         call make_stepper(system, settings, self%branch, status)
      self%power = self%method%order + 1
      if (self%method%estimate_power > 0) self%power = self%method%estimate_power
      self%round_off = max(0.5_wp*eps, doubtful/(2.0_wp**max(self%method%order, 1) - 1))
      self%t_first = state%t
      self%sense = sign(1.0_wp, self%plan%end_time - state%t)
      self%momentum_scale = length_of(body_momentum(state))
      rate = length_of(angular_velocity(system, state))
      self%step = 0.1_wp*abs(self%plan%end_time - state%t)
      if (rate*self%step > 0.1_wp) self%step = 0.1_wp/rate
   end subroutine begin

   !> Steps until a time on which a step must end.
   subroutine reach(self, system, state, t_end, observer, summary, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: t_end
      class(observer_t), intent(inout) :: observer
      type(run_summary_t), intent(inout) :: summary
      type(status_t), intent(inout) :: status
      type(state_t) :: start
      real(wp) :: rest, step, work
      logical :: accepted

      do while (abs(t_end - state%t) > 0.0_wp)
         if (summary%parts + self%record%continued >= self%plan%max_steps) then
            status = fail(NUTATE_STEP_LIMIT, 'the run needs more steps than were allowed')
            if (observer%keeps_archives) call self%offer(state, observer, summary, status)
            return
         end if
         select type (method => self%half)
         class is (dense_stepper_t)
            call method%choose_step(system, state, step_goal_t(self%goal%local_tolerance, self%goal%error_rate, t_end), &
                                    self%step, status)
            if (.not. status%ok()) return
            self%step = min(self%step, self%longest)
         end select
         ! What is left is not left over for a tiny step: less than two steps are halved.
         rest = abs((t_end - state%t) - self%t_compensation)
         step = self%step
         if (rest < 2*step) step = 0.5_wp*rest
         if (rest <= self%step) step = rest
         start = state
         work = sum(summary%work)
         call self%try(system, state, step, summary, accepted, status)
         self%longest = merge(huge(self%longest), self%step, accepted)
         if (status%ok() .and. accepted) then
            if (step >= rest) then
               state%t = t_end
               self%t_compensation = 0.0_wp
            end if
            call self%show(system, start, work, state, observer, summary, status)
            if (observer%wants_archive) call self%offer(state, observer, summary, status)
         end if
         if (.not. status%ok()) return
      end do
   end subroutine reach

   !> One step; it is kept if the estimate of its error allows.
   subroutine try(self, system, state, step, summary, accepted, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Length to try, s, positive.
      real(wp), intent(in) :: step
      type(run_summary_t), intent(inout) :: summary
      logical, intent(out) :: accepted
      !> Success on entry: what is passed down is not set to success again in every call.
      type(status_t), intent(inout) :: status
      type(state_t) :: next
      real(wp) :: error, allowed, turn

      next = state
      self%record%iterations = 0
      if (self%method%estimate_power > 0 .or. self%method%dense) then
         call self%go_whole(system, next, step, error, status)
      else
         call self%go_halves(system, next, step, error, status)
      end if
      accepted = status%ok()
      if (.not. accepted) then
         call self%reject(0.5_wp*step, summary, status)
         return
      end if
      if (.not. self%method%dense) then
         turn = step*length_of(angular_velocity(system, next))
         allowed = self%goal%local_tolerance
         if (self%goal%error_rate > 0.0_wp) allowed = self%goal%error_rate*step
         accepted = (error <= max(allowed, self%round_off)) .and. turn <= 1.2_wp*largest_turn
         if (.not. accepted) then
            call self%reject(step*max(most_shrinkage, min(0.8_wp, self%growth(allowed, error))), summary, status)
            return
         end if
      end if
      next%t = state%t
      state = next
      call add_increment(state%t, self%t_compensation, self%sense*step)
      summary%parts = summary%parts + 1
      summary%steps = summary%steps + 1
      summary%work(:) = summary%work + self%work
      summary%iterations = summary%iterations + self%record%iterations
      summary%most_iterations = max(summary%most_iterations, self%record%iterations)
      if (.not. self%method%dense) call self%adapt(step, self%growth(allowed, error), turn)
   end subroutine try

   !> One step by a method that estimates its errors.
   subroutine go_whole(self, system, state, step, error, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> s, positive.
      real(wp), intent(in) :: step
      !> rad.
      real(wp), intent(out) :: error
      type(status_t), intent(inout) :: status
      call take_part(self%half, system, state, self%sense*step, state%t + 0.5_wp*self%sense*step, self%record, status)
      self%work(:) = self%half%work
      error = self%half%error_estimate
   end subroutine go_whole

   !> One step by two halves, and as a whole for the estimate of their error.
   subroutine go_halves(self, system, state, step, error, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> s, positive.
      real(wp), intent(in) :: step
      !> rad.
      real(wp), intent(out) :: error
      type(status_t), intent(inout) :: status
      type(state_t) :: once
      real(wp) :: middle
      middle = state%t + 0.5_wp*self%sense*step
      once = state
      error = 0.0_wp
      call take_part(self%whole, system, once, self%sense*step, middle, self%record, status)
      if (status%ok()) call take_part(self%half, system, state, 0.5_wp*self%sense*step, middle, self%record, status)
      self%work(:) = self%half%work
      if (status%ok()) call take_part(self%half, system, state, 0.5_wp*self%sense*step, middle, self%record, status)
      self%work(:) = self%work + self%half%work
      if (status%ok()) error = self%estimate(once, state)
   end subroutine go_halves

   !> A step of one of the steppers, as a part of a step with the given middle.
   subroutine take_part(stepper, system, state, dt, middle, record, status)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, middle
      type(run_record_t), intent(inout) :: record
      type(status_t), intent(inout) :: status
      call stepper%advance(system, state, dt, middle, status)
      record%continued = record%continued + stepper%continued
      record%iterations = record%iterations + stepper%iterations
      record%residual = stepper%residual
   end subroutine take_part

   !> |v|, the same digits in whatever unit; `norm2` rounds differently above and below 1.
   pure real(wp) function length_of(v)
      real(wp), intent(in) :: v(3)
      length_of = quat_norm([0.0_wp, v])
   end function length_of

   !> Error of the halves, rad: of the attitude, and of the momentum relative to its largest size.
   real(wp) function estimate(self, once, twice)
      class(controller_t), intent(inout) :: self
      type(state_t), intent(in) :: once, twice
      real(wp) :: change(3)
      self%momentum_scale = max(self%momentum_scale, length_of(body_momentum(twice)))
      change = body_momentum(once) - body_momentum(twice)
      estimate = attitude_distance(once%q, twice%q)
      if (self%momentum_scale > 0.0_wp) estimate = max(estimate, length_of(change)/self%momentum_scale)
      estimate = estimate/(2.0_wp**self%method%order - 1)
   end function estimate

   !> Factor by which the step could grow: its error goes as its length to the order plus one, the error over its
   !> length as its length to the order.
   pure real(wp) function growth(self, allowed, error)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: allowed, error
      real(wp) :: exponent
      exponent = 1.0_wp/self%power
      if (self%goal%error_rate > 0.0_wp) exponent = 1.0_wp/(self%power - 1)
      growth = min(most_growth, safety*(max(allowed, self%round_off) &
                                        /max(error, noise/(2.0_wp**self%method%order - 1)))**exponent)
   end function growth

   !> The next step after one that was kept.
   pure subroutine adapt(self, step, factor, turn)
      class(controller_t), intent(inout) :: self
      real(wp), intent(in) :: step, factor, turn
      ! A step shortened to end somewhere says nothing against longer ones.
      if (step < self%step .and. factor >= 1.0_wp) return
      if (factor >= worth_while .or. factor < 0.95_wp) self%step = step*factor
      if (self%step*turn > step*largest_turn) self%step = step*largest_turn/turn
   end subroutine adapt

   !> Shortens the step to try again. Errors: `NUTATE_NOT_CONVERGED` where it cannot be shortened.
   subroutine reject(self, step, summary, status)
      class(controller_t), intent(inout) :: self
      !> The next length to try, s.
      real(wp), intent(in) :: step
      type(run_summary_t), intent(inout) :: summary
      !> Success where there is a next try.
      type(status_t), intent(inout) :: status
      type(status_t) :: success
      summary%cut_steps = summary%cut_steps + 1
      self%step = step
      if (step < shortest*abs(self%plan%end_time - self%t_first)) then
         status = fail(NUTATE_NOT_CONVERGED, 'no step is short enough for the accuracy asked for')
      else
         status = success
      end if
   end subroutine reject

   !> Shows the rows that a step brought: those at intervals inside it, and its end where that is one.
   subroutine show(self, system, start, work, state, observer, summary, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State and work of all torques before the step, J.
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: work
      !> State after it.
      type(state_t), intent(in) :: state
      class(observer_t), intent(inout) :: observer
      type(run_summary_t), intent(in) :: summary
      type(status_t), intent(inout) :: status
      real(wp) :: t
      logical :: is_row

      self%record%step = summary%steps
      if (observer%sees_every_step) call observer%watch(state)
      is_row = .not. abs(self%plan%end_time - state%t) > 0.0_wp
      if (self%goal%interval > 0.0_wp) then
         do
            t = self%t_first + self%sense*self%goal%interval*real(self%rows + 1, wp)
            ! A row within 1e-9 of an interval of the end is the last row.
            if (self%sense*(t - state%t) > 0.0_wp .or. .not. status%ok() .or. &
                self%sense*(self%plan%end_time - t) <= 1e-9_wp*self%goal%interval) exit
            self%rows = self%rows + 1
            if (self%rows > self%plan%max_steps) then
               status = fail(NUTATE_STEP_LIMIT, 'the run needs more rows than steps were allowed')
               exit
            end if
            call self%show_between(system, start, work, t, 0.5_wp*(start%t + state%t), observer, status)
         end do
      else
         is_row = is_row .or. modulo(summary%steps, self%plan%every) == 0
      end if
      self%record%work = sum(summary%work)
      if (status%ok() .and. is_row) call observer%observe(system, state, self%record, status)
      if (status%ok()) call observer%poll((state%t - self%t_first)/(self%plan%end_time - self%t_first), status)
   end subroutine show

   !> Shows the state at a time inside a step, reached by two steps of a branch.
   subroutine show_between(self, system, start, work, t, middle, observer, status)
      class(controller_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: work, t, middle
      class(observer_t), intent(inout) :: observer
      type(status_t), intent(inout) :: status
      type(state_t) :: between
      type(run_record_t) :: row
      integer :: i
      real(wp) :: since
      between = start
      row = self%record
      row%work = work
      select type (method => self%half)
      class is (dense_stepper_t)
         call method%state_at(system, t, between, since, status)
         if (.not. status%ok()) return
         row%work = work + since
         call observer%observe(system, between, row, status)
         return
      end select
      do i = 1, 2
         if (.not. abs(t - start%t) > 0.0_wp) exit
         call take_part(self%branch, system, between, 0.5_wp*(t - start%t), middle, row, status)
         if (.not. status%ok()) return
         row%work = row%work + sum(self%branch%work)
      end do
      between%t = t
      row%iterations = self%record%iterations
      row%residual = self%record%residual
      call observer%observe(system, between, row, status)
   end subroutine show_between

   !> Puts the run in an archive and shows it to the observer.
   subroutine offer(self, state, observer, summary, status)
      class(controller_t), intent(inout) :: self
      type(state_t), intent(inout) :: state
      class(observer_t), intent(inout) :: observer
      type(run_summary_t), intent(inout) :: summary
      !> Why the run ends, if it does; what the observer returned otherwise.
      type(status_t), intent(inout) :: status
      type(byte_archive_t) :: archive
      type(status_t) :: kept
      call archive%begin_writing()
      call self%transfer(archive, state, summary)
      observer%wants_archive = .false.
      call observer%keep(archive, kept)
      if (status%ok()) status = kept
   end subroutine offer

   !> All that changes in a run, shown to an archive.
   subroutine transfer_controller(self, archive, state, summary)
      class(controller_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      type(state_t), intent(inout) :: state
      type(run_summary_t), intent(inout) :: summary
      call state%transfer(archive)
      call summary%transfer(archive)
      call self%record%transfer(archive)
      call self%half%transfer(archive)
      if (allocated(self%whole)) call self%whole%transfer(archive)
      if (allocated(self%branch)) call self%branch%transfer(archive)
      call archive%transfer(self%momentum_scale)
      call archive%transfer(self%step)
      call archive%transfer(self%longest)
      call archive%transfer(self%t_compensation)
      call archive%transfer(self%rows)
      call archive%transfer(self%next_end)
   end subroutine transfer_controller

end module nutate_step_control
