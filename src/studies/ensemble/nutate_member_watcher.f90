!> Observer of a member's run: it measures the invariants, follows angles, and passes rows and events to a history if
!> there is one.
module nutate_member_watcher
   use nutate_columns, only: columns_t
   use nutate_event, only: event_t
   use nutate_event_history, only: event_history_t
   use nutate_history, only: history_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_run_plan, only: count_steps
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: poll_stride, member_watcher_t, sweep_asker_t

   !> Number of times at which the invariants of a member are measured if the scene sets no output points: enough to
   !> detect a random walk of round-off, few enough to cost little beside the steps.
   integer(long), parameter :: usual_polls = 100

   !> Observer that ends runs, trial runs too, when the sweep is to end.
   type, extends(observer_t) :: sweep_asker_t
      !> Watcher of the sweep, or NULL.
      class(sweep_watcher_t), pointer :: sweep => null()
   contains
      procedure :: poll => ask_sweep
   end type sweep_asker_t

   type, extends(sweep_asker_t) :: member_watcher_t
      type(columns_t) :: columns
      type(invariants_t) :: invariants
      !> True if rows of several runs are observed, each of which begins with the invariants `at_start`.
      logical :: begins_anew = .false.
      type(invariants_t) :: at_start
      !> Steps between two measurements of the invariants.
      integer(long) :: stride = 1
      !> Last row; allocated only if `columns%shows_commands`, since commands change when the run ends on a sample.
      real(wp), allocatable :: last_row(:)
      !> Histories of rows and of events, or NULL.
      type(history_t), pointer :: history => null()
      type(event_history_t), pointer :: events => null()
   contains
      procedure :: observe => watch_row
      procedure :: observe_step => follow_state
      procedure :: observe_event => measure_event
   end type member_watcher_t

contains

   !> Returns the number of steps between two measurements of a member, beside the one at its last step; 1 if the scene
   !> sets its output points, or steps are adaptive. A history may have more rows.
   pure integer(long) function poll_stride(scene)
      type(scene_t), intent(in) :: scene
      poll_stride = 1
      if (scene%output%by_default .and. .not. scene%plan%goal%active()) &
         poll_stride = max(1_long, count_steps(scene%initial%t, scene%plan)/usual_polls)
   end function poll_stride

   subroutine watch_row(self, system, state, record, status)
      class(member_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (allocated(self%last_row)) call self%columns%evaluate(system, state, record, self%last_row)
      if (self%begins_anew .and. record%step == 0) self%invariants = self%at_start
      if (mod(record%step, self%stride) == 0) call self%invariants%measure(system, state, record%work)
      if (associated(self%history)) call self%history%observe(system, state, record, status)
   end subroutine watch_row

   !> Ends the run if a user-defined effect has failed, and with `NUTATE_STOPPED` if the sweep is to end.
   subroutine ask_sweep(self, fraction, status)
      class(sweep_asker_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      if (.not. associated(self%sweep)) return
      call self%sweep%check(status)
      if (self%sweep%wants_end()) status = fail(NUTATE_STOPPED, 'the sweep was stopped')
   end subroutine ask_sweep

   subroutine follow_state(self, state)
      class(member_watcher_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      if (self%columns%follows_steps) call self%columns%follow(state)
      if (associated(self%history)) call self%history%observe_step(state)
   end subroutine follow_state

   subroutine measure_event(self, system, event, which, number, state, record, status)
      class(member_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      call self%invariants%measure(system, state, record%work)
      if (.not. (associated(self%events) .and. associated(self%history))) return
      call self%events%write(self%history, system, trim(event%name), number, state, record, status)
   end subroutine measure_event

end module nutate_member_watcher
