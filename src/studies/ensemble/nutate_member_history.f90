!> Runs one member of an ensemble with its whole history, as `nutate run` would write it. The row is bitwise identical
!> to that of the ensemble; that of a top, which the ensemble runs with others, differs from the history by the error of
!> the integration.
module nutate_member_history
   use nutate_event_history, only: event_history_t, events_name
   use nutate_history, only: history_t
   use nutate_kinds, only: wp, long
   use nutate_member_run, only: member_run_t
   use nutate_row_layout, only: row_layout_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, NUTATE_IO
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: write_member

contains

   !> Runs a member and writes its history, and its events if the scene has any. A member that does not reach its end
   !> leaves its rows in the partial file; a member that the scene rejects has none.
   !>
   !> Errors: `NUTATE_IO`; `NUTATE_STOPPED` if the sweep is to end.
   subroutine write_member(scene, layout, number, name, sweep, fields, reason, status)
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      !> Row layout of the scene.
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: number
      !> Path of the history.
      character(len=*), intent(in) :: name
      class(sweep_watcher_t), intent(in) :: sweep
      !> Row of the member; shape (fields).
      integer(long), intent(out) :: fields(:)
      !> Reason why the member did not reach its end.
      type(status_t), intent(out) :: reason
      type(status_t), intent(out) :: status
      type(member_run_t) :: runner
      type(history_t), allocatable, target :: history
      type(event_history_t), allocatable, target :: events
      integer(long) :: row(size(fields), 1)
      logical :: done(1)

      fields = 0
      call runner%prepare(scene, layout, status, sweep)
      if (.not. status%ok()) return
      call runner%member%set_values(scene%ensemble, number, reason)
      if (reason%ok()) call open_files(runner%member%scene, name, history, events, status)
      if (status%ok()) call runner%row(scene, number, fields, status, reason, history, events)
      if (status%ok() .and. reason%ok()) then
         call runner%run_tops(scene, number, row, done, status)
         if (done(1)) fields = row(:, 1)
      end if
      call close_files(history, events, reason, status)
      if (status%code == NUTATE_IO) status%message = 'cannot write '//name//': '//trim(status%message)
   end subroutine write_member

   !> Opens the files of a member. Errors: `NUTATE_IO`.
   subroutine open_files(scene, name, history, events, status)
      !> Scene of the member.
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      type(history_t), allocatable, intent(inout) :: history
      !> File of the events; not allocated if the scene has none.
      type(event_history_t), allocatable, intent(inout) :: events
      type(status_t), intent(inout) :: status
      allocate (history)
      associate (j0 => scene%integrator%inverse_auxiliary_inertia)
         call history%open(name, scene%output%columns, scene%system, scene%initial, j0, status, scene%output%degrees, &
                           scene%output%digits, scene%plan%end_time < 0.0_wp, scene%output%epoch)
      end associate
      if (.not. status%ok() .or. scene%events%count() == 0 .or. events_name(name) == '') return
      allocate (events)
      call events%open(events_name(name), history, status)
   end subroutine open_files

   !> Gives the files their names if the member reached its end. Errors: `NUTATE_IO`.
   subroutine close_files(history, events, reason, status)
      type(history_t), allocatable, intent(inout) :: history
      type(event_history_t), allocatable, intent(inout) :: events
      type(status_t), intent(in) :: reason
      type(status_t), intent(inout) :: status
      type(status_t) :: outcome
      outcome = reason
      if (.not. status%ok()) outcome = status
      if (allocated(events)) call events%file%close(outcome)
      if (allocated(history)) call history%file%close(outcome)
      if (reason%ok()) status = outcome
   end subroutine close_files

end module nutate_member_history
