!> What every run does around its steps, however they are chosen: limits, rows, polls and archives. And what it asks of
!> a policy, that chooses and takes the steps: by a fixed length (`nutate_fixed_steps`), by their error
!> (`nutate_error_control`).
module nutate_run_loop
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_kinds, only: wp, long
   use nutate_limits, only: same_time
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: fraction_done, is_over, progress_t, transfer_progress
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_STEP_LIMIT
   use nutate_system, only: system_t
   implicit none
   private

   public :: step_policy_t, drive, find_row, transfer_run

   !> A way to choose and take steps, with the steppers that it needs.
   type, abstract :: step_policy_t
      !> Steps between two calls of the observer's `poll`.
      integer(long) :: steps_per_poll = 1
   contains
      !> Moves a run by one step.
      procedure(move_on), deferred :: advance
      !> The state at a time inside the last step.
      procedure :: state_inside => refuse_state
      !> Shows to an archive what the next steps depend on.
      procedure(show_memory), deferred :: transfer
   end type step_policy_t

   abstract interface
      !> Moves a run by one step, and counts it; or finds that a step must be shorter, and counts none. Errors: why no
      !> step is possible, with the last state reached.
      subroutine move_on(self, system, progress, status, observer)
         import :: step_policy_t, system_t, progress_t, status_t, observer_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Not at its end.
         type(progress_t), intent(inout) :: progress
         !> Success on entry: what is passed down is not set to success again in every call.
         type(status_t), intent(inout) :: status
         !> Watches parts of steps.
         class(observer_t), intent(inout), optional :: observer
      end subroutine move_on

      subroutine show_memory(self, archive)
         import :: step_policy_t, archive_t
         class(step_policy_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine show_memory
   end interface

contains

   !> Takes a run from where it is to its end.
   !>
   !> Errors: those of the steps, `NUTATE_STEP_LIMIT`, and what the observer returned. The state is then the last one
   !> reached.
   subroutine drive(progress, policy, system, status, observer)
      !> Started, or resumed.
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(in) :: system
      !> Success on entry.
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      integer(long) :: steps, next_poll
      logical :: over, is_row

      if (present(observer)) call show_first(progress, policy, system, observer, status)
      next_poll = (progress%summary%steps/policy%steps_per_poll + 1)*policy%steps_per_poll
      over = is_over(progress)
      do while (status%code == 0 .and. .not. over)
         steps = progress%summary%steps
         if (progress%summary%parts + progress%record%continued >= progress%plan%max_steps) then
            status = fail(NUTATE_STEP_LIMIT, 'the run needs more steps than were allowed')
            if (present(observer)) then
               if (observer%keeps_archives) call offer(progress, policy, observer, status)
            end if
            return
         end if
         call policy%advance(system, progress, status, observer)
         if (status%code /= 0) return
         over = is_over(progress)
         if (.not. present(observer) .or. progress%summary%steps == steps) cycle
         is_row = over
         if (allocated(progress%plan%times)) then
            is_row = .false.
            call show_inside(progress, policy, system, observer, status)
         else if (progress%plan%interval > 0.0_wp) then
            call show_inside(progress, policy, system, observer, status)
         else if (mod(progress%summary%steps, progress%plan%every) == 0) then
            is_row = .true.
         end if
         if (observer%sees_every_step) call observer%watch(progress%state)
         if (is_row .and. status%code == 0) then
            progress%record%work = sum(progress%summary%work)
            call observer%observe(system, progress%state, progress%record, status)
         end if
         if (progress%summary%steps >= next_poll .and. status%code == 0) then
            next_poll = next_poll + policy%steps_per_poll
            call observer%poll(fraction_done(progress), status)
            if (observer%wants_archive) call offer(progress, policy, observer, status)
         end if
      end do
   end subroutine drive

   !> Shows the first row, unless the run goes on behind it, or it is none of those that are asked for.
   subroutine show_first(progress, policy, system, observer, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(in) :: system
      class(observer_t), intent(inout) :: observer
      type(status_t), intent(inout) :: status
      real(wp) :: t
      logical :: due
      due = .not. progress%resumed
      if (due .and. allocated(progress%plan%times)) then
         call find_row(progress, t, due)
         if (due) progress%rows = progress%rows + 1
      end if
      if (due) call observer%observe(system, progress%state, progress%record, status)
      if (observer%wants_archive .and. status%ok()) call offer(progress, policy, observer, status)
   end subroutine show_first

   !> The time of the next row at intervals or at times of the plan, and whether the run has reached it.
   pure subroutine find_row(progress, t, due)
      type(progress_t), intent(in) :: progress
      !> s; without meaning where no row is due.
      real(wp), intent(out) :: t
      logical, intent(out) :: due
      real(wp) :: sense
      associate (plan => progress%plan)
         sense = sign(1.0_wp, plan%end_time - progress%t_first)
         t = progress%state%t
         if (allocated(plan%times)) then
            due = progress%rows < size(plan%times)
            if (due) t = plan%times(progress%rows + 1)
         else
            t = progress%t_first + sense*plan%interval*real(progress%rows + 1, wp)
            due = sense*(plan%end_time - t) > same_time*plan%interval
         end if
         due = due .and. sense*(t - progress%state%t) <= 0.0_wp
      end associate
   end subroutine find_row

   !> Shows the rows at intervals, or at times of the plan, that lie inside the last step. Errors: `NUTATE_STEP_LIMIT`
   !> where there are more rows at intervals than steps are allowed; those of the method, and of the observer.
   subroutine show_inside(progress, policy, system, observer, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(system_t), intent(in) :: system
      class(observer_t), intent(inout) :: observer
      type(status_t), intent(inout) :: status
      type(state_t) :: state
      type(run_record_t) :: record
      real(wp) :: t
      logical :: due
      call find_row(progress, t, due)
      do while (due .and. status%code == 0)
         progress%rows = progress%rows + 1
         if (progress%rows > progress%plan%max_steps .and. .not. allocated(progress%plan%times)) then
            status = fail(NUTATE_STEP_LIMIT, 'the run needs more rows than steps were allowed')
            exit
         end if
         if (abs(t - progress%state%t) > 0.0_wp .or. .not. allocated(progress%plan%times)) then
            call policy%state_inside(system, progress, t, state, record, status)
         else
            state = progress%state
            record = progress%record
            record%work = sum(progress%summary%work)
         end if
         if (observer%sees_every_step .and. status%ok()) call observer%watch(state)
         if (status%ok()) call observer%observe(system, state, record, status)
         call find_row(progress, t, due)
      end do
   end subroutine show_inside

   !> Puts the run in an archive and shows it to the observer.
   subroutine offer(progress, policy, observer, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      class(observer_t), intent(inout) :: observer
      !> Why the run ends, if it does; what the observer returned otherwise.
      type(status_t), intent(inout) :: status
      type(byte_archive_t) :: archive
      type(status_t) :: kept
      call archive%begin_writing()
      call transfer_run(progress, policy, archive)
      observer%wants_archive = .false.
      call observer%keep(archive, kept)
      if (status%ok()) status = kept
   end subroutine offer

   !> Shows all that changes in a run to an archive.
   subroutine transfer_run(progress, policy, archive)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      class(archive_t), intent(inout) :: archive
      call transfer_progress(progress, archive)
      call policy%transfer(archive)
   end subroutine transfer_run

   !> Refuses: a policy that does not say so has no states inside its steps.
   subroutine refuse_state(self, system, progress, t, state, record, status)
      class(step_policy_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> At the end of the step.
      type(progress_t), intent(in) :: progress
      !> s.
      real(wp), intent(in) :: t
      type(state_t), intent(out) :: state
      !> What belongs to a row of that state.
      type(run_record_t), intent(out) :: record
      type(status_t), intent(inout) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'there are no states inside these steps')
   end subroutine refuse_state

end module nutate_run_loop
