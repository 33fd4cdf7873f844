!> A run: steps from a state to an end time, an observer shown the rows asked for, and what it took.
module nutate_run
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp, eps, long
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, &
      NUTATE_SINGULAR, NUTATE_STEP_LIMIT
   use nutate_stepper, only: stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: run_plan_t, run_record_t, run_summary_t, observer_t, integrate, count_steps, check_resumed
   ! The parts of `integrate`, for those who keep a run under way between calls.
   public :: progress_t, begin, advance

   !> A time within this fraction of a step of a step's end is that end.
   real(wp), parameter :: same_time = 1e-9_wp
   !> A step that fails is cut into up to 2**deepest_cut parts.
   integer, parameter :: deepest_cut = 10
   !> Lengths tried on walks beyond which, and beyond ten times the steps allowed, a step is not cut further: such a run
   !> has failed, and does not go on from an archive.
   integer(long), parameter :: spare_tries = 1000
   character(len=*), parameter :: too_many_steps = 'the run needs more steps than were allowed'
   !> Steps between two calls of the observer's `poll`.
   integer(long), parameter :: poll_every = 1024

   !> How far to go, and how often to show the state.
   type :: run_plan_t
      !> Nominal step, s; of the sign of the way to go.
      real(wp) :: time_step = 0.0_wp
      !> s.
      real(wp) :: end_time = 0.0_wp
      !> Nominal steps between the rows shown to the observer.
      integer(long) :: every = 1
      !> A run that needs more steps (lengths tried on walks counted), or more rows between its steps, ends there.
      integer(long) :: max_steps = huge(1_long)
      !> Nominal steps of this length that earlier runs have done, and their first time, s: those of this run then end
      !> where those of a single one would.
      integer(long) :: steps_before = 0
      real(wp) :: first_time = 0.0_wp
      !> Nominal steps to do; negative: as many as lead to the end time.
      integer(long) :: steps = -1
   end type run_plan_t

   !> What belongs to a row beside the state.
   type :: run_record_t
      !> Nominal steps done.
      integer(long) :: step = 0
      !> Newton iterations of the last nominal step, and its largest last relative increment.
      integer :: iterations = 0
      real(wp) :: residual = 0.0_wp
      !> Work of all torques so far, J.
      real(wp) :: work = 0.0_wp
      !> Lengths tried so far on walks to roots (`nutate_continuation`): each counts as a step where steps are limited.
      integer(long) :: continued = 0
   contains
      !> Shows its values to an archive.
      procedure :: transfer => transfer_record
   end type run_record_t

   !> What a run took.
   type :: run_summary_t
      !> Nominal steps done.
      integer(long) :: steps = 0
      !> Nominal steps that had to be cut into parts because they failed.
      integer(long) :: cut_steps = 0
      !> Steps of the method, parts included.
      integer(long) :: parts = 0
      !> Newton iterations, all and the most in one nominal step.
      integer(long) :: iterations = 0
      integer :: most_iterations = 0
      !> Work of each torque, J; shape (number of torques).
      real(wp), allocatable :: work(:)
   contains
      !> Shows its values to an archive.
      procedure :: transfer => transfer_summary
   end type run_summary_t

   !> Someone who is shown the rows of a run.
   type, abstract :: observer_t
      !> `watch` is to be called.
      logical :: sees_every_step = .false.
      !> `keep` is to be called where a run ends at `max_steps`.
      logical :: keeps_archives = .false.
      !> `keep` is to be called after the first row, or after the `poll` that sets this.
      logical :: wants_archive = .false.
   contains
      !> Called with the first state, every `every` steps, and with the last state.
      procedure(observe_row), deferred :: observe
      !> Called now and then, rows or not: the place for a progress bar or a request to stop.
      procedure :: poll => ignore_poll
      !> Called after every step, and after every part of one that is cut, before `observe`, if `sees_every_step`: for
      !> what must be followed from step to step.
      procedure :: watch => ignore_watch
      !> Called with all that the run needs to go on from where it is, in an archive; after the rows of that moment.
      procedure :: keep => ignore_archive
   end type observer_t

   abstract interface
      !> A status that is not `NUTATE_OK` ends the run with it.
      subroutine observe_row(self, system, state, record, status)
         import :: observer_t, system_t, state_t, run_record_t, status_t
         class(observer_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         type(run_record_t), intent(in) :: record
         type(status_t), intent(out) :: status
      end subroutine observe_row
   end interface

   !> A run under way.
   type :: progress_t
      !> First time of the run and of the present nominal step, s.
      real(wp) :: t_first = 0.0_wp
      !> Times inside the run at which steps must end, in the order they are reached, s; the next one.
      real(wp), allocatable :: breaks(:)
      integer :: next_break = 1
      !> Digits of the work that its sum cannot hold, J.
      real(wp), allocatable :: work_compensation(:)
      !> Limit of the number of steps.
      integer(long) :: most_steps = huge(1_long)
   contains
      !> Shows to an archive what changes on the way.
      procedure :: transfer => transfer_progress
   end type progress_t

contains

   !> Integrates from `state` to the plan's end time. The k-th step ends at t0 + kΔt, computed as such; the last one,
   !> shortened if need be, ends exactly at `end_time`. A step that fails is cut into parts as short as need be.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a step that leads away from the end, or for an archive of another run;
   !> `NUTATE_STEP_LIMIT`; what the observer returned; why a step failed in its shortest part. `state` is then the last
   !> state reached.
   subroutine integrate(system, stepper, state, plan, observer, summary, status, resumed)
      type(system_t), intent(in) :: system
      !> Prepared for `system`.
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      type(run_plan_t), intent(in) :: plan
      class(observer_t), intent(inout) :: observer
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      !> What `keep` was given when this run, from the same `state` on, was under way: it goes on from there.
      class(archive_t), intent(inout), optional :: resumed
      type(progress_t) :: progress
      type(run_record_t) :: record
      integer(long) :: n_steps

      call begin(system%effects, state%t, plan, progress, summary, status)
      if (.not. status%ok()) return
      n_steps = plan%steps
      if (n_steps < 0) n_steps = count_steps(state%t, plan)
      if (present(resumed)) then
         call transfer_run(resumed, stepper, state, progress, summary, record)
         call check_resumed(resumed, status)
      else
         call observer%observe(system, state, record, status)
      end if
      if (observer%wants_archive .and. status%ok()) &
         call offer(stepper, state, progress, summary, record, observer, status)
      do while (status%code == 0 .and. summary%steps < n_steps)
         if (summary%parts + record%continued >= plan%max_steps) then
            status = fail(NUTATE_STEP_LIMIT, too_many_steps)
            exit
         end if
         call advance(system, stepper, state, plan, progress, summary, record, summary%steps + 1 == n_steps, status, &
                      observer)
         if (status%code /= 0) exit
         if (observer%sees_every_step) call observer%watch(state)
         if (mod(summary%steps, plan%every) == 0 .or. summary%steps == n_steps) then
            record%work = sum(summary%work)
            call observer%observe(system, state, record, status)
         end if
         if (mod(summary%steps, poll_every) == 0 .and. status%code == 0) then
            call observer%poll(real(summary%steps, wp)/real(n_steps, wp), status)
            if (observer%wants_archive) call offer(stepper, state, progress, summary, record, observer, status)
         end if
      end do
      if (status%code == NUTATE_STEP_LIMIT .and. observer%keeps_archives) &
         call offer(stepper, state, progress, summary, record, observer, status)
   end subroutine integrate

   !> Puts the run in an archive and shows it to the observer.
   subroutine offer(stepper, state, progress, summary, record, observer, status)
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      class(observer_t), intent(inout) :: observer
      !> Why the run ends, if it does; what the observer returned otherwise.
      type(status_t), intent(inout) :: status
      type(byte_archive_t) :: archive
      type(status_t) :: kept
      call archive%begin_writing()
      call transfer_run(archive, stepper, state, progress, summary, record)
      observer%wants_archive = .false.
      call observer%keep(archive, kept)
      if (status%ok()) status = kept
   end subroutine offer

   !> All that changes in a run.
   subroutine transfer_run(archive, stepper, state, progress, summary, record)
      class(archive_t), intent(inout) :: archive
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      call state%transfer(archive)
      call stepper%transfer(archive)
      call progress%transfer(archive)
      call summary%transfer(archive)
      call record%transfer(archive)
   end subroutine transfer_run

   !> `NUTATE_BAD_ARGUMENT` where an archive did not hold what the run asked of it.
   subroutine check_resumed(archive, status)
      class(archive_t), intent(in) :: archive
      type(status_t), intent(inout) :: status
      if (archive%problem() /= '') &
         status = fail(NUTATE_BAD_ARGUMENT, 'the archive cannot be resumed: '//archive%problem())
   end subroutine check_resumed

   !> Shows to an archive what changes on the way.
   subroutine transfer_progress(self, archive)
      class(progress_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%next_break)
      call archive%transfer(self%work_compensation)
   end subroutine transfer_progress

   !> Shows its values to an archive.
   subroutine transfer_record(self, archive)
      class(run_record_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%step)
      call archive%transfer(self%iterations)
      call archive%transfer(self%residual)
      call archive%transfer(self%work)
      call archive%transfer(self%continued)
   end subroutine transfer_record

   !> Shows its values to an archive.
   subroutine transfer_summary(self, archive)
      !> Its `work` allocated.
      class(run_summary_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%steps)
      call archive%transfer(self%cut_steps)
      call archive%transfer(self%parts)
      call archive%transfer(self%iterations)
      call archive%transfer(self%most_iterations)
      call archive%transfer(self%work)
   end subroutine transfer_summary

   !> Number of nominal steps from a time to the plan's end, the shortened last one included; for more than can be
   !> counted, the largest count there is.
   pure integer(long) function count_steps(t, plan) result(n)
      !> s.
      real(wp), intent(in) :: t
      type(run_plan_t), intent(in) :: plan
      real(wp) :: ratio
      ratio = (plan%end_time - t)/plan%time_step
      if (ratio >= real(huge(n), wp)) then
         n = huge(n)
      else
         n = int(ratio, long)
         if (ratio - real(n, wp) > same_time + time_noise(t, plan)/abs(plan%time_step)) n = n + 1
      end if
   end function count_steps

   !> What rounding makes of a time of the run, s: far from zero more than `same_time` of a step, and no step's length.
   pure real(wp) function time_noise(t, plan)
      !> s
      real(wp), intent(in) :: t
      type(run_plan_t), intent(in) :: plan
      time_noise = min(4*eps*max(abs(t), abs(plan%end_time)), 0.25_wp*abs(plan%time_step))
   end function time_noise

   !> Tests the plan and finds the times on which steps must end.
   subroutine begin(effects, t, plan, progress, summary, status)
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: t
      type(run_plan_t), intent(in) :: plan
      type(progress_t), intent(out) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(status_t), intent(out) :: status
      if (plan%every < 1 .or. plan%time_step == 0.0_wp .or. &
          (plan%end_time - t)*sign(1.0_wp, plan%time_step) < 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time step does not lead to the end time')
         return
      end if
      allocate (summary%work(effects%n_torques), progress%work_compensation(effects%n_torques), source=0.0_wp)
      progress%t_first = t
      progress%most_steps = plan%max_steps
      if (plan%steps_before > 0) progress%t_first = plan%first_time
      progress%breaks = effects%breaks_between(t, plan%end_time)
   end subroutine begin

   !> One nominal step: in one piece, or in several where times lie inside it on which steps must end.
   subroutine advance(system, stepper, state, plan, progress, summary, record, is_last, status, observer)
      type(system_t), intent(in) :: system
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      type(run_plan_t), intent(in) :: plan
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      logical, intent(in) :: is_last
      !> Success on entry: what is passed down is not set to success again in every call.
      type(status_t), intent(inout) :: status
      !> Watches parts.
      class(observer_t), intent(inout), optional :: observer
      real(wp) :: t_end, margin, length
      logical :: cut

      t_end = progress%t_first + real(plan%steps_before + summary%steps + 1, wp)*plan%time_step
      if (is_last) t_end = plan%end_time
      margin = same_time*abs(plan%time_step) + time_noise(state%t, plan)
      record%iterations = 0
      record%residual = 0.0_wp
      cut = .false.
      do while (progress%next_break <= size(progress%breaks))
         associate (next => progress%breaks(progress%next_break))
            if ((t_end - next)*sign(1.0_wp, plan%time_step) <= margin) exit
            if (abs(next - state%t) > margin) &
               call travel(system, stepper, state, next - state%t, next, progress, summary, record, cut, status, &
                           observer)
         end associate
         progress%next_break = progress%next_break + 1
         if (status%code /= 0) return
         call show_part(state, observer)
      end do
      length = t_end - state%t
      if (abs(length - plan%time_step) <= margin) length = plan%time_step
      call travel(system, stepper, state, length, t_end, progress, summary, record, cut, status, observer)
      if (status%code /= 0) return
      summary%steps = summary%steps + 1
      if (cut) summary%cut_steps = summary%cut_steps + 1
      summary%iterations = summary%iterations + record%iterations
      summary%most_iterations = max(summary%most_iterations, record%iterations)
      record%step = summary%steps
   end subroutine advance

   !> Moves the state by `length` to the time `t_end`: in one step, or in parts where that fails.
   subroutine travel(system, stepper, state, length, t_end, progress, summary, record, cut, status, observer)
      type(system_t), intent(in) :: system
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: length, t_end
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      logical, intent(inout) :: cut
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer

      call stepper%step(system, state, length, status)
      record%continued = record%continued + stepper%continued
      if (status%code /= 0) then
         ! A step that failed has forgotten the steps before it, and guesses afresh: that may do.
         record%iterations = record%iterations + stepper%iterations
         call stepper%step(system, state, length, status)
         record%continued = record%continued + stepper%continued
      end if
      if (status%code == 0) then
         call count_part(stepper, progress, summary, record)
      else
         record%iterations = record%iterations + stepper%iterations
         call travel_in_parts(system, stepper, state, length, progress, summary, record, cut, status, observer)
         if (status%code /= 0) return
      end if
      state%t = t_end
   end subroutine travel

   !> Moves the state by `length` in halves, quarters, ..., whatever part of it does not fail.
   subroutine travel_in_parts(system, stepper, state, length, progress, summary, record, cut, status, observer)
      type(system_t), intent(in) :: system
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: length
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      logical, intent(inout) :: cut
      !> On entry: why the step failed in one piece.
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      integer :: level, done
      character(len=12) :: parts
      real(wp) :: t_start

      t_start = state%t
      level = 0
      done = 0
      do
         if (status%code == 0) then
            done = done + 1
            state%t = t_start + length*(real(done, wp)/2**level)
            call count_part(stepper, progress, summary, record)
            if (done == 2**level) return
            call show_part(state, observer)
         else
            if (all(status%code /= [NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR])) return
            if (level == deepest_cut) then
               write (parts, '(i0)') 2**deepest_cut
               status%message = trim(status%message)//', even cut into '//trim(parts)//' parts'
               return
            end if
            cut = .true.
            level = level + 1
            done = 2*done
         end if
         if (record%continued > spare_tries .and. record%continued/10 > progress%most_steps) then
            status = fail(NUTATE_NOT_CONVERGED, 'the step took more tries than were allowed')
            return
         end if
         call stepper%step(system, state, length/2**level, status)
         record%continued = record%continued + stepper%continued
         if (status%code /= 0) record%iterations = record%iterations + stepper%iterations
      end do
   end subroutine travel_in_parts

   !> Shows a state inside a nominal step to who sees every step.
   subroutine show_part(state, observer)
      type(state_t), intent(in) :: state
      class(observer_t), intent(inout), optional :: observer
      if (.not. present(observer)) return
      if (observer%sees_every_step) call observer%watch(state)
   end subroutine show_part

   !> Accounts for a step of the method that succeeded.
   subroutine count_part(stepper, progress, summary, record)
      class(stepper_t), intent(in) :: stepper
      type(progress_t), intent(inout) :: progress
      type(run_summary_t), intent(inout) :: summary
      type(run_record_t), intent(inout) :: record
      integer :: i
      summary%parts = summary%parts + 1
      record%iterations = record%iterations + stepper%iterations
      record%residual = max(record%residual, stepper%residual)
      do i = 1, size(stepper%work)
         call add_increment(summary%work(i), progress%work_compensation(i), stepper%work(i))
      end do
   end subroutine count_part

   !> Does nothing.
   subroutine ignore_poll(self, fraction, status)
      class(observer_t), intent(inout) :: self
      !> How much of the run is done, 0 to 1.
      real(wp), intent(in) :: fraction
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_poll

   !> Does nothing.
   subroutine ignore_watch(self, state)
      class(observer_t), intent(inout) :: self
      type(state_t), intent(in) :: state
   end subroutine ignore_watch

   !> Does nothing.
   subroutine ignore_archive(self, archive, status)
      class(observer_t), intent(inout) :: self
      !> To be given to the run that goes on.
      type(byte_archive_t), intent(inout) :: archive
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_archive

end module nutate_run
