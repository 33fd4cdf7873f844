!> Interface through which a program receives the output points and events of a run.
module nutate_observer
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_chaos, only: chaos_t
   use nutate_event, only: event_t
   use nutate_kinds, only: wp, long
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: observer_t, run_record_t

   !> Data of an output point besides the state.
   type :: run_record_t
      !> Steps done: fixed ones, or adaptive ones.
      integer(long) :: step = 0
      !> Newton iterations of the last step, and its largest last relative increment.
      integer :: iterations = 0
      real(wp) :: residual = 0.0_wp
      !> Stages of the last step, in all its parts, whose root is accepted without certification.
      integer :: uncertified = 0
      !> Work of all torques so far, J.
      real(wp) :: work = 0.0_wp
      !> Work of each effect so far, and last of switches, J; shape (n_works + 1). Allocated if the observer
      !> `wants_works`.
      real(wp), allocatable :: works(:)
      !> Step lengths tried so far by continuation in Δt (`nutate_continuation`): each counts towards a limit of steps.
      integer(long) :: continued = 0
   contains
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_record
   end type run_record_t

   !> Receives the output points of a run. Programs extend it.
   type, abstract :: observer_t
      !> Request calls of `observe_step`.
      logical :: observes_every_step = .false.
      !> Accept the ends of steps, which cost nothing, in place of output points at intervals. The steps stay the same.
      logical :: rows_at_steps = .false.
      !> Request `works` in the records.
      logical :: wants_works = .false.
      !> Request calls of `check_step`.
      logical :: checks_steps = .false.
      !> Request a call of `save_checkpoint` if a run ends at `max_steps`.
      logical :: saves_at_step_limit = .false.
      !> Request a call of `save_checkpoint` after the first output point, or after the `poll` that sets this.
      logical :: wants_checkpoint = .false.
      !> Request `tangent`, the sensitivities, for each output point and event of a run that propagates any; and
      !> `chaos`, the indicators up to the last sample, for each output point of a run that follows any.
      logical :: wants_tangent = .false.
      type(tangent_t), allocatable :: tangent
      type(chaos_t), allocatable :: chaos
      !> Derivative of the event's time by each sensitivity, s a unit of the sensitivity's parameter; shape (n). Set
      !> before `observe_event` if the run propagates sensitivities; not allocated if the quantity only touches its
      !> level.
      real(wp), allocatable :: time_change(:)
   contains
      !> Called with the first state, with each output point of the plan, and with the last state.
      procedure :: observe => ignore_row
      !> Called after every 1024 fixed steps, and after every adaptive step, or after every step if `checks_steps`,
      !> since callbacks may be slow: for a progress bar or a request to stop.
      procedure :: poll => ignore_poll
      !> Called after every step of the method, before it is used, if `checks_steps`: a failure takes the step back and
      !> ends the run. For callbacks that can fail.
      procedure :: check_step => accept_all
      !> Called after every step, and after every part of one that is subdivided or rotates the body far, before
      !> `observe`, if `observes_every_step`: for what must be followed from step to step.
      procedure :: observe_step => ignore_watch
      !> Called with each event, in the order of time, before `observe` is called at the end of its step.
      procedure :: observe_event => ignore_event
      !> Called with the checkpoint data from which the run can be continued, after the output points of that time.
      procedure :: save_checkpoint => ignore_archive
   end type observer_t

contains

   !> Writes or reads its values in checkpoint data.
   subroutine transfer_record(self, archive)
      class(run_record_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%step)
      call archive%transfer(self%iterations)
      call archive%transfer(self%residual)
      call archive%transfer(self%uncertified)
      call archive%transfer(self%work)
      call archive%transfer(self%continued)
   end subroutine transfer_record

   !> Does nothing by default. Override it to receive the output points.
   subroutine ignore_row(self, system, state, record, status)
      class(observer_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_row

   !> Does nothing by default. Override it for a progress bar or a request to stop.
   subroutine ignore_poll(self, fraction, status)
      class(observer_t), intent(inout) :: self
      !> Fraction of the run that is done, 0 to 1.
      real(wp), intent(in) :: fraction
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_poll

   !> Accepts the step by default.
   subroutine accept_all(self, status)
      class(observer_t), intent(inout) :: self
      type(status_t), intent(out) :: status
   end subroutine accept_all

   !> Does nothing by default.
   subroutine ignore_watch(self, state)
      class(observer_t), intent(inout) :: self
      type(state_t), intent(in) :: state
   end subroutine ignore_watch

   !> Does nothing by default. Override it to receive events.
   subroutine ignore_event(self, system, event, which, number, state, record, status)
      class(observer_t), intent(inout) :: self
      !> The system before the event switches effects.
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      !> Index of the event among those of the run.
      integer, intent(in) :: which
      !> Number of times the event has happened, this one included.
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(inout) :: status
   end subroutine ignore_event

   !> Does nothing by default. Override it to store checkpoint data.
   subroutine ignore_archive(self, archive, status)
      class(observer_t), intent(inout) :: self
      !> Checkpoint data; pass them to `resume` of a later run.
      type(byte_archive_t), intent(inout) :: archive
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_archive

end module nutate_observer
