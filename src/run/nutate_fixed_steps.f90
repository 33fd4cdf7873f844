!> Steps of one nominal length. The k-th ends at t0 + kΔt, computed as such; the last one, shortened if necessary, ends
!> exactly at the end time. A step that fails is subdivided as far as necessary.
module nutate_fixed_steps
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: add_works, count_part, count_step, end_of_step, progress_t, put_works, run_point_t, &
      way_t
   use nutate_step_subdivision, only: perform_next_part, try, try_piece
   use nutate_step_policy, only: step_policy_t
   use nutate_run_plan, only: count_steps, step_margin
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: fixed_steps_t

   !> Steps between two polls: a poll of the program takes about as long as the cheapest step (0.2 µs), so that they
   !> cost a thousandth of the time; and if each step took 1 ms, a request to stop would take effect within a second.
   integer(long), parameter :: poll_every = 1024

   !> Fixed steps.
   type, extends(step_policy_t) :: fixed_steps_t
      !> Stepper prepared for the system of the run. The owner of the stepper sets this pointer in each call: a copy of
      !> a run must not use the stepper of the original.
      class(stepper_t), pointer :: stepper => null()
   contains
      !> Counts the steps to the end of the plan.
      procedure :: begin
      procedure :: advance
      procedure :: project_for_output
      procedure :: state_inside
      procedure :: expect_events
      procedure :: retake
      procedure :: propagate
      procedure :: renew
      procedure :: update_commands
      procedure :: transfer => transfer_stepper
   end type fixed_steps_t

contains

   !> Counts the steps of a run. Errors: `NUTATE_BAD_ARGUMENT` for a step that leads away from the end.
   subroutine begin(self, progress, status)
      class(fixed_steps_t), intent(inout) :: self
      !> Run that was started.
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      self%steps_per_poll = poll_every
      associate (plan => progress%plan, t => progress%state%t)
         if (plan%goal%active()) then
            status = fail(NUTATE_BAD_ARGUMENT, 'adaptive steps are made from settings, not from a stepper')
            return
         end if
         if (plan%time_step == 0.0_wp .or. (plan%end_time - t)*sign(1.0_wp, plan%time_step) < 0.0_wp) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the time step does not lead to the end time')
            return
         end if
         ! A step may differ from this length by the rounding of times.
         self%longest_step = 1.01_wp*abs(plan%time_step)
         if (plan%steps >= 0) then
            progress%n_steps = progress%summary%steps + plan%steps
         else
            progress%n_steps = max(progress%summary%steps, count_steps(progress%t_first, plan) - plan%steps_before)
         end if
         if (allocated(plan%times) .or. progress%keeps_dense_output) call self%stepper%keep_steps()
      end associate
   end subroutine begin

   !> Takes one step of the method towards the end of a nominal step, which is counted there, or to a time inside it at
   !> which steps must end; if that fails, the first part of it that does not.
   subroutine advance(self, system, progress, status, observer)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      real(wp) :: dt, t_end, margin, target, length
      dt = progress%plan%time_step
      t_end = end_of_step(progress, progress%summary%steps + 1)
      if (progress%summary%steps + 1 == progress%n_steps) t_end = progress%plan%end_time
      margin = step_margin(progress%state%t, progress%plan%end_time, dt)
      if (.not. progress%way%begun) call begin_way(progress)
      target = next_end(system, progress, t_end, margin)
      if (progress%way%level == 0) then
         length = target - progress%state%t
         if (.not. abs(target - t_end) > 0.0_wp .and. abs(length - dt) <= margin) length = dt
         if (abs(length) > 0.0_wp) call try_piece(self%stepper, system, progress, length, status)
      else
         call perform_next_part(self%stepper, system, progress, status)
      end if
      if (status%code /= 0 .or. progress%way%level > 0) return
      progress%state%t = target
      if (abs(target - t_end) > 0.0_wp) then
         call pass_break(system, progress, margin)
         progress%way%parts = progress%way%parts + 1
      else
         if (progress%summary%parts > progress%way%parts) &
            progress%summary%subdivided_steps = progress%summary%subdivided_steps + 1
         progress%way%begun = .false.
         call count_step(progress)
      end if
   end subroutine advance

   !> Begins a nominal step.
   pure subroutine begin_way(progress)
      type(progress_t), intent(inout) :: progress
      progress%way = way_t(begun=.true., parts=progress%summary%parts + 1)
      progress%record%iterations = 0
      progress%record%residual = 0.0_wp
      progress%record%uncertified = 0
   end subroutine begin_way

   !> Returns the next time at which a step must end: that of a break inside the nominal step, or the end of that step.
   real(wp) function next_end(system, progress, t_end, margin) result(t)
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      !> End of the nominal step, and margin within which times coincide, s.
      real(wp), intent(in) :: t_end, margin
      real(wp) :: sense
      sense = sign(1.0_wp, progress%plan%time_step)
      t = t_end
      do while ((t_end - progress%next_break)*sense > margin)
         if ((progress%next_break - progress%state%t)*sense > margin) then
            t = progress%next_break
            return
         end if
         call pass_break(system, progress, margin)
      end do
   end function next_end

   !> Looks for the next time at which steps must end, which can be distinguished from the present one.
   subroutine pass_break(system, progress, margin)
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      !> Margin within which times coincide, s.
      real(wp), intent(in) :: margin
      real(wp) :: sense, passed
      sense = sign(1.0_wp, progress%plan%time_step)
      passed = progress%state%t + sense*margin
      if (sense*(progress%next_break - passed) > 0.0_wp .and. &
          sense*(progress%next_break - progress%state%t) <= margin) passed = progress%next_break
      progress%next_break = system%effects%next_break(passed, sense)
   end subroutine pass_break

   !> Lets the stepper keep the starts of its steps.
   subroutine expect_events(self, system, progress, status)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      call self%stepper%keep_steps()
      self%evaluates_cheaply = self%stepper%chooses_steps()
   end subroutine expect_events

   !> Repeats a part of the last step of the method; the rest of the nominal step is then a separate piece.
   subroutine retake(self, system, progress, t_end, status)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      real(wp), intent(in) :: t_end
      type(status_t), intent(inout) :: status
      if (.not. progress%way%begun) call begin_way(progress)
      progress%way%level = 0
      progress%way%parts = progress%way%parts + 1
      call self%stepper%forget_steps()
      call try(self%stepper, system, progress, t_end - progress%state%t, status)
      if (status%code /= 0) return
      call count_part(progress, self%stepper)
      progress%state%t = t_end
   end subroutine retake

   !> Moves the sensitivities over the last step of the method.
   subroutine propagate(self, system, before, progress, status)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before
      type(progress_t), intent(inout) :: progress
      type(status_t), intent(inout) :: status
      associate (length => progress%last_length)
         call self%stepper%propagate(system, before, progress%state, length, before%t + 0.5_wp*length, &
            progress%tangent, &
                                 status)
      end associate
   end subroutine propagate

   !> Prepares again for a system that has changed.
   subroutine renew(self, system, status)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      call self%stepper%renew(system, status)
   end subroutine renew

   !> Notes that torques and motors hold other values.
   subroutine update_commands(self)
      class(fixed_steps_t), intent(inout) :: self
      call self%stepper%update_commands()
   end subroutine update_commands

   !> Evaluates the state at a time inside the last step of the method. Errors: those of the stepper, which must keep
   !> the starts of its steps.
   subroutine state_inside(self, system, progress, t, state, status, record, tangent, before)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(progress_t), intent(in) :: progress
      !> Time inside the last step, s.
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      type(status_t), intent(inout) :: status
      type(run_record_t), intent(out), optional :: record
      type(tangent_t), intent(inout), optional :: tangent
      type(run_point_t), intent(in), optional :: before
      real(wp) :: since, each(size(self%stepper%work))
      call self%stepper%state_at(system, t, state, since, status, each)
      if (present(tangent) .and. status%code == 0) call self%stepper%propagate_inside(system, state, tangent, status)
      if (.not. present(record)) return
      record = progress%record
      if (present(before)) then
         call put_works(before%summary, record)
         record%work = record%work + since
         call add_works(record, each)
      else
         call put_works(progress%summary, record)
         record%work = (record%work - sum(self%stepper%work)) + since
         call add_works(record, each - self%stepper%work)
      end if
   end subroutine state_inside

   !> Projects the state at the end of the last step for output.
   subroutine project_for_output(self, system, state)
      class(fixed_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      call self%stepper%project_for_output(system, state)
   end subroutine project_for_output

   !> Writes or reads the memory of the stepper in checkpoint data, under the name of this policy.
   subroutine transfer_stepper(self, archive)
      class(fixed_steps_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%expect('fixed steps')
      call self%stepper%transfer(archive)
   end subroutine transfer_stepper

end module nutate_fixed_steps
