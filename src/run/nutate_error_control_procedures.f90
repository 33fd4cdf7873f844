!> Bodies of the procedures whose interfaces are in `nutate_error_control`.
submodule(nutate_error_control) nutate_error_control_procedures
   use nutate_disturbance, only: disturb_state
   use nutate_hamiltonian, only: angular_velocity, body_momentum
   use nutate_kinds, only: long
   use nutate_methods, only: make_stepper, method_of
   use nutate_progress, only: add_works, count_step, put_works
   use nutate_quaternion, only: attitude_distance, quat_norm
   use nutate_step_subdivision, only: go_inside
   use nutate_step_length, only: most_growth
   use nutate_state, only: add_increment
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED
   use nutate_stepper, only: step_goal_t
   implicit none

contains

   module procedure begin
      type(integrator_settings_t) :: own
      real(wp) :: rate, duration
      logical :: rows_inside
      duration = progress%plan%end_time - progress%state%t
      if (.not. allocated(self%work)) then
         self%method = method_of(settings)
         self%is_dense = self%method%dense
         if (.not. settings%max_step < huge(1.0_wp)) &
            call self%equal%recognise(system, settings, progress%state, duration, progress%plan%goal%accuracy)
      end if
      own = settings
      self%max_step = settings%max_step
      own%project_each = .not. self%equal%suit
      rows_inside = progress%plan%interval > 0.0_wp .or. allocated(progress%plan%times) .or. progress%keeps_dense_output
      if (allocated(self%work) .and. self%equal%suit) rows_inside = rows_inside .or. self%half%keeps_steps
      call make_stepper(system, own, self%half, status)
      if (.not. status%ok()) return
      if (self%method%estimate_power == 0 .and. .not. (self%method%dense .or. self%equal%suit)) &
         call make_stepper(system, own, self%whole, status)
      if (rows_inside .and. self%equal%suit) call self%half%keep_steps()
      if (rows_inside .and. .not. (self%method%dense .or. self%equal%suit) .and. status%ok()) &
         call make_stepper(system, own, self%branch, status)
      if (allocated(self%probe) .and. status%ok()) call make_stepper(system, own, self%probe, status)
      if (allocated(self%work)) deallocate (self%work)
      allocate (self%work(system%effects%n_works()), source=0.0_wp)
      self%longest = huge(self%longest)
      self%last_cut = progress%state%t
      self%has_cuts = .false.
      self%between_cuts = 0.0_wp
      self%t_compensation = 0.0_wp
      self%noise = noise_t()
      self%probed = .false.
      self%repeatable = .false.
      self%sense = sign(1.0_wp, duration)
      self%momentum_scale = size_of_momentum(progress%state)
      rate = length_of(angular_velocity(system, progress%state))
      call self%length%set_up(self%method%order, self%method%estimate_power)
      self%length%next = first_part*abs(duration)
      if (rate*self%length%next > first_turn) self%length%next = first_turn/rate
   end procedure begin

   module procedure disturb
      if (self%method%projected) then
         call self%half%disturb(noise)
         if (allocated(self%whole)) call self%whole%disturb(noise)
      else if (.not. self%method%conserving) then
         self%noise = noise
      end if
   end procedure disturb

   module procedure advance
      real(wp) :: t_end, rest, step
      logical :: accepted, is_last

      if (.not. self%sense*(progress%next_break - progress%state%t) > 0.0_wp) &
         progress%next_break = system%effects%next_break(progress%state%t, self%sense)
      t_end = progress%plan%end_time
      if (self%sense*(t_end - progress%next_break) > 0.0_wp) t_end = progress%next_break
      if (self%half%chooses_steps()) then
         call self%half%choose_step(system, progress%state, goal_of(progress, t_end, observer), self%length%next, &
                                    status)
         if (.not. status%ok()) return
         self%length%next = min(self%length%next, self%longest)
      end if
      if (self%equal%suit) call self%equal%divide(progress%plan%goal%local_tolerance, self%length%next)
      ! No tiny step is left for the end: a rest of less than two steps is halved.
      rest = abs((t_end - progress%state%t) - self%t_compensation)
      step = min(self%length%next, reach_of(self, progress%state%t), self%max_step)
      is_last = rest <= merge(1.5_wp, 1.0_wp, self%equal%suit)*step
      if (rest < 2*step .and. .not. self%equal%suit) step = 0.5_wp*rest
      if (is_last) step = rest
      ! Time and step must not round to a time beyond the end, where user-defined torques may be undefined.
      if (is_last .and. self%sense*((progress%state%t + self%sense*step) - t_end) > 0.0_wp) &
         step = nearest(abs(t_end - progress%state%t), -1.0_wp)
      call self%start%copy_from(progress%state, system%effects%n_wheels, .true.)
      self%repeatable = .true.
      self%probed = .false.
      if (allocated(progress%record%works)) self%before = progress%record
      call put_works(progress%summary, self%before)
      if (allocated(progress%tangent)) self%trial = progress%tangent
      self%longest = huge(self%longest)
      call try(self, system, progress, step, accepted, status)
      if (.not. accepted) self%longest = self%length%next
      if (status%ok() .and. accepted .and. is_last) then
         progress%state%t = t_end
         self%t_compensation = 0.0_wp
      end if
   end procedure advance

   !> Returns the longest step that is worth while at a time, s: it grows from step to step without such events.
   pure real(wp) function reach_of(self, t) result(reach)
      class(error_control_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      reach = huge(reach)
      if (self%has_cuts .and. .not. self%equal%suit) &
         reach = reach_over_cuts*max(sum(self%between_cuts)/cuts_kept, abs(t - self%last_cut))
   end function reach_of

   module procedure project_for_output
      call self%half%project_for_output(system, state)
   end procedure project_for_output

   !> Returns the goal of the next step.
   type(step_goal_t) function goal_of(progress, t_end, observer) result(goal)
      type(progress_t), intent(in) :: progress
      !> Time at which the step must end at the latest, s.
      real(wp), intent(in) :: t_end
      class(observer_t), intent(in), optional :: observer
      associate (plan => progress%plan)
         goal%tolerance = plan%goal%local_tolerance
         goal%rate = plan%goal%error_rate
         goal%end_time = t_end
         goal%seen = allocated(progress%events)
         if (.not. present(observer)) return
         goal%seen = goal%seen .or. observer%observes_every_step .or. &
                     (plan%interval <= 0.0_wp .and. .not. allocated(plan%times) .and. plan%every < huge(plan%every))
         if (plan%interval > 0.0_wp) goal%longest = rows_in_a_step*plan%interval
         if (.not. allocated(plan%times)) return
         if (progress%rows < size(plan%times)) goal%longest = &
            abs(plan%times(min(progress%rows + rows_in_a_step, size(plan%times, kind=long))) - progress%state%t)
      end associate
   end function goal_of

   !> Tries one step of a length.
   subroutine try(self, system, progress, step, accepted, status)
      class(error_control_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      !> Length to try, s, positive.
      real(wp), intent(in) :: step
      logical, intent(out) :: accepted
      type(status_t), intent(inout) :: status
      real(wp) :: error, middle
      call self%next%copy_from(progress%state, system%effects%n_wheels, .true.)
      middle = progress%state%t + 0.5_wp*self%sense*step
      progress%record%iterations = 0
      progress%record%uncertified = 0
      if (allocated(self%whole)) then
         call go_halves(self, system, progress%record, step, error, status)
      else
         if (self%half%keeps_steps) call self%half%mark_step(self%next, self%sense*step, middle)
         call perform_part(self%half, system, self%next, self%sense*step, middle, progress%record, status, self%trial)
         self%work(:) = self%half%work
         error = self%half%error_estimate
         if (allocated(self%trial)) error = max(error, self%trial%error)
      end if
      if (.not. status%ok()) then
         accepted = .false.
         ! No shorter step helps if the method does not support the system.
         if (status%code == NUTATE_BAD_ARGUMENT .and. status%subject == 'method') return
         if (.not. self%equal%suit) call reject(0.5_wp*step)
      else if (self%equal%suit .or. self%method%dense .and. .not. error > 0.0_wp) then
         accepted = .true.
         call accept()
      else
         call accept_or_reject(error)
      end if

   contains

      !> Keeps a step if the estimate of its error allows, and chooses the next one.
      subroutine accept_or_reject(error)
         !> Error of the step, rad.
         real(wp), intent(in) :: error
         real(wp) :: allowed, turn, growth
         turn = 0.0_wp
         if (.not. self%method%dense) turn = step*length_of(angular_velocity(system, self%next))
         associate (goal => progress%plan%goal)
            allowed = goal%local_tolerance
            if (goal%error_rate > 0.0_wp) allowed = goal%error_rate*step
            growth = self%length%growth(goal%error_rate > 0.0_wp, allowed, error)
         end associate
         accepted = self%length%keeps(allowed, error, turn)
         if (accepted) then
            call accept()
            if (self%method%dense) then
               ! The motion chooses the next step, the sensitivities may shorten it.
               if (growth < most_growth) self%longest = step*growth
            else
               call self%length%adapt(step, growth, turn)
            end if
         else
            call reject(step*self%length%shrinkage(growth))
         end if
      end subroutine accept_or_reject

      !> Keeps a step.
      subroutine accept()
         real(wp) :: t
         t = progress%state%t
         call progress%state%copy_from(self%next, system%effects%n_wheels, .true.)
         if (self%noise%amplitude > 0.0_wp) call disturb_state(self%noise, progress%state)
         call add_increment(t, self%t_compensation, self%sense*step)
         progress%state%t = t
         progress%summary%parts = progress%summary%parts + 1
         progress%summary%work(:) = progress%summary%work + self%work
         call count_step(progress)
      end subroutine accept

      !> Shortens the step to try again. Errors: `NUTATE_NOT_CONVERGED` if it cannot be shortened.
      subroutine reject(step)
         !> The next length to try, s.
         real(wp), intent(in) :: step
         progress%summary%subdivided_steps = progress%summary%subdivided_steps + 1
         self%length%next = step
         status = status_t()
         if (step < shortest*abs(progress%plan%end_time - progress%t_first)) &
            status = fail(NUTATE_NOT_CONVERGED, 'no step is short enough for the requested accuracy')
      end subroutine reject

   end subroutine try

   !> Takes one step by two halves, and as a whole for the estimate of their error.
   subroutine go_halves(self, system, record, step, error, status)
      class(error_control_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(run_record_t), intent(inout) :: record
      !> Length of the step, s, positive.
      real(wp), intent(in) :: step
      !> Error of the halves, rad.
      real(wp), intent(out) :: error
      type(status_t), intent(inout) :: status
      type(state_t) :: once
      real(wp) :: middle, moved
      middle = self%next%t + 0.5_wp*self%sense*step
      once = self%next
      error = 0.0_wp
      if (allocated(self%trial) .and. (.not. self%method%can_project)) self%once = self%trial
      call perform_part(self%whole, system, once, self%sense*step, middle, record, status, self%once)
      if (status%ok()) &
         call perform_part(self%half, system, self%next, 0.5_wp*self%sense*step, middle, record, status, self%trial)
      self%work(:) = self%half%work
      moved = self%whole%moved_by_round_off + self%half%moved_by_round_off
      if (status%ok()) &
         call perform_part(self%half, system, self%next, 0.5_wp*self%sense*step, middle, record, status, self%trial)
      self%work(:) = self%work + self%half%work
      moved = moved + self%half%moved_by_round_off
      if (status%ok()) error = estimate(self, once, moved)
      if (status%ok() .and. allocated(self%once)) &
         error = max(error, self%trial%relative(self%once%theta - self%trial%theta, self%once%momentum - &
                               self%trial%momentum, self%momentum_scale)/(2.0_wp**self%method%order - 1))
   end subroutine go_halves

   !> Takes a step of one of the steppers, as a part of a step with the given middle, with sensitivities if there are
   !> any.
   subroutine perform_part(stepper, system, state, dt, middle, record, status, tangent)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, middle
      type(run_record_t), intent(inout) :: record
      type(status_t), intent(inout) :: status
      type(tangent_t), intent(inout), optional :: tangent
      if (present(tangent)) then
         call advance_tangent(stepper, system, state, dt, middle, status, tangent)
      else
         call stepper%advance(system, state, dt, middle, status)
      end if
      record%continued = record%continued + stepper%continued
      record%iterations = record%iterations + stepper%iterations
      ! A whole step shows how good the halves are: its root is treated like theirs.
      record%uncertified = record%uncertified + stepper%uncertified
      record%residual = stepper%residual
   end subroutine perform_part

   !> Takes a step of a stepper with sensitivities.
   subroutine advance_tangent(stepper, system, state, dt, middle, status, tangent)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, middle
      type(status_t), intent(inout) :: status
      type(tangent_t), intent(inout) :: tangent
      type(state_t) :: before
      before = state
      call stepper%advance(system, state, dt, middle, status)
      if (status%code == 0) call stepper%propagate(system, before, state, dt, middle, tangent, status)
   end subroutine advance_tangent

   !> Returns |v|, the same digits in whatever unit; `norm2` rounds differently above and below 1.
   pure real(wp) function length_of(v)
      real(wp), intent(in) :: v(3)
      length_of = quat_norm([0.0_wp, v])
   end function length_of

   !> Returns the largest of |L| and the momenta of wheels and inner spheres, kg m²/s: a motion that motors have started
   !> from rest keeps L = 0, and round-off in its place has no size.
   pure real(wp) function size_of_momentum(state)
      type(state_t), intent(in) :: state
      size_of_momentum = max(length_of(body_momentum(state)), maxval(abs(state%wheel_momentum)))
   end function size_of_momentum

   !> Returns the error of the halves, rad: of the attitude, and of the momentum relative to its largest size. Changes
   !> by round-off of the energy are no part of it, since shorter steps would not make them smaller.
   real(wp) function estimate(self, once, moved)
      class(error_control_t), intent(inout) :: self
      !> State after the whole step.
      type(state_t), intent(in) :: once
      !> Change of the states by their projections, rad.
      real(wp), intent(in) :: moved
      real(wp) :: change(3)
      self%momentum_scale = max(self%momentum_scale, size_of_momentum(self%next))
      change = body_momentum(once) - body_momentum(self%next)
      estimate = attitude_distance(once%q, self%next%q)
      if (self%momentum_scale > 0.0_wp) estimate = max(estimate, length_of(change)/self%momentum_scale)
      estimate = max(0.0_wp, estimate - moved)/(2.0_wp**self%method%order - 1)
   end function estimate

   module procedure state_inside
      real(wp) :: work, since, each(size(self%work))
      work = self%before%work
      since = 0.0_wp
      each = 0.0_wp
      state = self%start
      if (self%method%dense .or. self%equal%suit) then
         if (.not. present(before) .or. abs(t - state%t) >= least_time) &
            call evaluate_dense(self, system, progress, t, state, since, each, status, tangent)
      else if (abs(t - state%t) >= least_time .and. .not. present(before)) then
         call go_inside(self%branch, system, 2, t, progress%state%t, state, work, status, each, tangent)
      else if (abs(t - state%t) >= least_time) then
         if (.not. self%probed) call self%probe%forget_steps()
         self%probed = .true.
         call go_inside(self%probe, system, merge(2, 1, allocated(self%whole)), t, progress%state%t, state, since, &
                        status, each, tangent)
      end if
      if (.not. present(record)) return
      record = progress%record
      if (allocated(record%works)) record%works(:) = self%before%works
      record%work = work
      if (status%code /= 0) return
      record%work = work + since
      call add_works(record, each)
   end procedure state_inside

   module procedure is_evaluable
      is_evaluable = self%repeatable .and. self%sense*(t - self%start%t) >= 0.0_wp .and. &
                     self%sense*(end_time - t) >= 0.0_wp .and. &
                     (self%method%dense .or. self%equal%suit .or. allocated(self%branch))
   end procedure is_evaluable

   !> Evaluates the state at a time inside the last step by the method.
   subroutine evaluate_dense(self, system, progress, t, state, since, each, status, tangent)
      class(error_control_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(in) :: progress
      !> Time inside the step, s.
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      !> Work since the start of the step, J: of all torques, and of each; shape (n_works).
      real(wp), intent(out) :: since, each(:)
      type(status_t), intent(inout) :: status
      type(tangent_t), intent(inout), optional :: tangent
      call self%half%state_at(system, t, state, since, status, each)
      if (status%code /= 0 .or. .not. present(tangent)) return
      if (self%half%keeps_steps) then
         call self%half%propagate_inside(system, state, tangent, status)
      else
         call self%half%propagate(system, self%start, state, t - self%start%t, &
                                  0.5_wp*(self%start%t + progress%state%t), tangent, status)
      end if
   end subroutine evaluate_dense

   module procedure expect_events
      self%evaluates_cheaply = self%method%dense
      if (self%equal%suit) then
         call self%half%keep_steps()
      else if (.not. self%method%dense) then
         call make_stepper(system, self%half%prepared_with, self%probe, status)
      end if
   end procedure expect_events

   module procedure retake
      real(wp) :: length, error
      length = t_end - progress%state%t
      call self%next%copy_from(progress%state, system%effects%n_wheels, .true.)
      progress%record%iterations = 0
      progress%record%uncertified = 0
      call self%half%forget_steps()
      if (allocated(progress%tangent)) self%trial = progress%tangent
      if (allocated(self%whole)) then
         call self%whole%forget_steps()
         call go_halves(self, system, progress%record, abs(length), error, status)
      else
         call perform_part(self%half, system, self%next, length, self%next%t + 0.5_wp*length, progress%record, &
                           status, self%trial)
         self%work(:) = self%half%work
      end if
      if (status%code /= 0) return
      self%next%t = t_end
      call progress%state%copy_from(self%next, system%effects%n_wheels, .true.)
      progress%summary%parts = progress%summary%parts + 1
      progress%summary%work(:) = progress%summary%work + self%work
      self%t_compensation = 0.0_wp
      self%between_cuts = eoshift(self%between_cuts, -1, abs(t_end - self%last_cut))
      self%last_cut = t_end
      self%has_cuts = .true.
   end procedure retake

   module procedure propagate
      progress%tangent = self%trial
   end procedure propagate

   module procedure renew
      self%repeatable = .false.
      call self%half%renew(system, status)
      if (allocated(self%whole) .and. status%ok()) call self%whole%renew(system, status)
      if (allocated(self%branch) .and. status%ok()) call self%branch%renew(system, status)
      if (allocated(self%probe) .and. status%ok()) call self%probe%renew(system, status)
   end procedure renew

   module procedure update_commands
      self%repeatable = .false.
      call self%half%update_commands()
      if (allocated(self%whole)) call self%whole%update_commands()
      if (allocated(self%branch)) call self%branch%update_commands()
   end procedure update_commands

   module procedure transfer_control
      call archive%expect('error control')
      call self%half%transfer(archive)
      if (allocated(self%whole)) call self%whole%transfer(archive)
      if (allocated(self%branch)) call self%branch%transfer(archive)
      if (allocated(self%probe)) call self%probe%transfer(archive)
      call archive%transfer(self%momentum_scale)
      call archive%transfer(self%length%next)
      call archive%transfer(self%longest)
      call archive%transfer(self%t_compensation)
      call archive%transfer(self%last_cut)
      call archive%transfer(self%between_cuts)
      call archive%transfer(self%has_cuts)
   end procedure transfer_control

end submodule nutate_error_control_procedures
