!> C interface: events and tables of programs. The functions are documented in `include/nutate_events.h`.
module nutate_c_events
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_funptr, c_int, c_int64_t, c_loc, c_ptr, c_size_t
   use nutate_c_groups, only: parse_events, parse_table_keys
   use nutate_c_handles, only: found, history_handle_t, system_handle_t
   use nutate_c_stepper_handle, only: conclude, found, lacks_attitude, left_out, null_argument, stepper_handle_t, &
      unprepare
   use nutate_c_quantity, only: c_event_t
   use nutate_c_text, only: lock_texts, copy_text, unlock_texts
   use nutate_event, only: event_t
   use nutate_event_tracker, only: event_tracker_t
   use nutate_event_list, only: event_list_t
   use nutate_spelling, only: count_text
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE
   use nutate_tabulated_torque, only: tabulated_torque_t
   implicit none
   private

   public :: nutate_stepper_add_events, nutate_stepper_add_event, nutate_stepper_event_count, nutate_stepper_event, &
      nutate_history_event_count, nutate_history_event, nutate_system_add_table

contains

   integer(c_int) function nutate_stepper_add_events(stepper, groups) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, groups
      type(stepper_handle_t), pointer :: handle
      type(event_list_t) :: events
      type(status_t) :: status
      integer :: i
      if (.not. found(stepper, handle, code)) return
      call read_events(handle, groups, .true., events, status)
      if (status%ok()) then
         do i = 1, events%count()
            call handle%events%add(events%slots(i)%item)
         end do
         call need_attitude(handle)
         call renew_tracker(handle, status)
      end if
      code = conclude(handle, status)
   end function nutate_stepper_add_events

   integer(c_int) function nutate_stepper_add_event(stepper, quantity, user, group) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, user, group
      type(c_funptr), intent(in), value :: quantity
      type(stepper_handle_t), pointer :: handle
      type(event_list_t) :: events
      type(c_event_t) :: event
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. c_associated(quantity)) then
         status = null_argument('quantity')
      else
         call read_events(handle, group, .false., events, status)
         if (status%ok() .and. events%count() /= 1) &
            status = fail(NUTATE_BAD_SCENE, 'a quantity needs exactly one group &event', 'group')
      end if
      if (status%ok()) then
         call copy_options(events%slots(1)%item, event)
         event%function = quantity
         event%user = user
         event%failure = c_loc(handle%failure)
         call handle%events%add(event)
         call need_attitude(handle)
         call renew_tracker(handle, status)
      end if
      code = conclude(handle, status)
   end function nutate_stepper_add_event

   integer(c_int) function nutate_stepper_event_count(stepper, n) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(inout), optional :: n
      type(stepper_handle_t), pointer :: handle
      if (.not. found(stepper, handle, code)) return
      if (.not. allocated(handle%found)) allocate (handle%found)
      code = handle%found%give_count(n)
   end function nutate_stepper_event_count

   integer(c_int) function nutate_stepper_event(stepper, i, name, size, number, t, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, name
      integer(c_size_t), intent(in), value :: i, size
      integer(c_int64_t), intent(inout), optional :: number
      real(c_double), intent(inout), optional :: t, q(4), omega(3)
      type(stepper_handle_t), pointer :: handle
      if (.not. found(stepper, handle, code)) return
      if (.not. allocated(handle%found)) allocate (handle%found)
      code = handle%found%give(i, name, size, number, t, q, omega)
   end function nutate_stepper_event

   integer(c_int) function nutate_history_event_count(history, n) result(code) bind(C)
      type(c_ptr), intent(in), value :: history
      integer(c_size_t), intent(inout), optional :: n
      type(history_handle_t), pointer :: handle
      if (found(history, handle, code)) code = handle%found%give_count(n)
   end function nutate_history_event_count

   integer(c_int) function nutate_history_event(history, i, name, size, number, t, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: history, name
      integer(c_size_t), intent(in), value :: i, size
      integer(c_int64_t), intent(inout), optional :: number
      real(c_double), intent(inout), optional :: t, q(4), omega(3)
      type(history_handle_t), pointer :: handle
      if (found(history, handle, code)) code = handle%found%give(i, name, size, number, t, q, omega)
   end function nutate_history_event

   integer(c_int) function nutate_system_add_table(system, n, t, torque, keys) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, keys
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), optional :: t(n), torque(3, n)
      type(system_handle_t), pointer :: handle
      type(tabulated_torque_t) :: effect
      type(status_t) :: status
      character(len=:), allocatable :: text
      integer :: at
      if (.not. found(system, handle, code)) return
      if (.not. (present(t) .and. present(torque))) then
         code = conclude(handle, null_argument('t or torque'))
         return
      end if
      text = ''
      if (c_associated(keys)) call copy_text(keys, text)
      call lock_texts()
      call parse_table_keys(text, t, torque, effect, at, status)
      if (.not. status%ok() .and. at > 0) &
         status%message = 'line '//count_text(at)//' of the table: '//trim(status%message)
      call unlock_texts()
      if (status%ok()) call handle%system%effects%add(effect)
      code = conclude(handle, status)
   end function nutate_system_add_table

   !> Reads the events of a string. Errors: `NUTATE_BAD_ARGUMENT`, `NUTATE_BAD_SCENE`.
   subroutine read_events(handle, groups, with_columns, events, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(c_ptr), intent(in) :: groups
      !> True if the events name columns.
      logical, intent(in) :: with_columns
      type(event_list_t), intent(inout) :: events
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: text
      if (.not. c_associated(groups)) then
         status = null_argument('groups')
         return
      end if
      call copy_text(groups, text)
      call lock_texts()
      call parse_events(text, with_columns, handle%system%effects, handle%plan%goal%accuracy, events, status, &
                        handle%text)
      call unlock_texts()
      if (status%ok() .and. lacks_attitude(handle)) &
         status = fail(NUTATE_BAD_ARGUMENT, left_out//' (expected events before the first step, or a new '// &
                       'state)', 'groups')
   end subroutine read_events

   !> Copies the options of an event: all but its quantity.
   subroutine copy_options(from, event)
      class(event_t), intent(in) :: from
      type(c_event_t), intent(inout) :: event
      event%name = from%name
      event%kind = from%kind
      event%level = from%level
      event%period = from%period
      event%direction = from%direction
      event%stop = from%stop
      event%count = from%count
      event%effect = from%effect
      event%action = from%action
   end subroutine copy_options

   !> Begins the tracker anew with more events, with the record that the last run kept of the earlier events.
   subroutine renew_tracker(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(inout) :: status
      type(event_tracker_t), allocatable :: before
      if (.not. allocated(handle%run%events)) return
      call move_alloc(handle%run%events, before)
      allocate (handle%run%events)
      call handle%run%events%begin(handle%events, handle%system, handle%run%state, status)
      call handle%run%events%remember(before)
   end subroutine renew_tracker

   !> Requests the attitude, which events use.
   subroutine need_attitude(handle)
      type(stepper_handle_t), intent(inout) :: handle
      handle%run%requested%attitude = .true.
      if (handle%run%summary%settings%attitude) return
      handle%run%summary%settings%attitude = .true.
      call unprepare(handle)
   end subroutine need_attitude

end module nutate_c_events
