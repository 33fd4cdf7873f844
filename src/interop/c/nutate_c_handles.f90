!> What stands behind the opaque handles of the C interface.
!>
!> Every handle begins with a number that tells its kind; it is cleared when the handle is destroyed, so that one that
!> is used afterwards, or that is of another kind, is recognised.
module nutate_c_handles
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_int, c_int64_t, c_null_ptr, c_ptr, c_size_t
   use nutate_bodies, only: movement_t
   use nutate_bodies_drift, only: body_class_t
   use nutate_c_effects, only: report_failures_to
   use nutate_c_found, only: found_events_t
   use nutate_c_polls, only: poll_t
   use nutate_c_text, only: message_to_c
   use nutate_chaos, only: chaos_settings_t, chaos_t
   use nutate_variation, only: variation_t
   use nutate_columns, only: columns_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event_tracker, only: event_list_t
   use nutate_fit_problem, only: fit_problem_t
   use nutate_keys, only: group_t, name_length
   use nutate_kinds, only: wp, long
   use nutate_limits, only: most_wheels
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   use nutate_stepper, only: stepper_t
   use nutate_system, only: system_t
   use nutate_propagated_columns, only: propagated_t
   implicit none
   private

   public :: handle_t, system_handle_t, scene_handle_t, stepper_handle_t, history_handle_t, bodies_handle_t
   public :: SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK
   public :: found, destroy, open_slot, copy_system, null_argument, report, whole_message, conclude, make_room
   public :: unprepare, get_propagated, set_propagated, set_chaos

   !> Marks of the kinds.
   integer(c_int64_t), parameter :: SYSTEM_MARK = 7811887110843601971_c_int64_t, &
                                    SCENE_MARK = 7811887110843601972_c_int64_t, &
                                    STEPPER_MARK = 7811887110843601973_c_int64_t, &
                                    HISTORY_MARK = 7811887110843601974_c_int64_t, &
                                    BODIES_MARK = 7811887110843601975_c_int64_t

   !> What every handle begins with.
   type :: handle_t
      !> One of the marks.
      integer(c_int64_t) :: mark = 0
      !> What the last call came to.
      type(status_t) :: status
      !> The whole text of an error whose status may have lost the middle.
      character(len=:), allocatable :: text
   end type handle_t

   !> A body and what acts on it.
   type, extends(handle_t) :: system_handle_t
      type(system_t) :: system
   end type system_handle_t

   !> A scene.
   type, extends(handle_t) :: scene_handle_t
      type(scene_t) :: scene
      !> The poll callback of its runs.
      type(poll_t) :: poll
      !> The residuals of its fit, once they were asked for.
      type(fit_problem_t), allocatable :: fit
   end type scene_handle_t

   !> The rows of a run.
   type, extends(handle_t) :: history_handle_t
      !> Names of the columns, comma separated.
      character(len=:), allocatable :: names
      integer :: width = 0
      integer(c_size_t) :: rows = 0
      !> Steps of the run in which a root was accepted without certification.
      integer(long) :: uncertified_steps = 0
      !> `estimate` and `round_off` of a run with an accuracy, and that, rad.
      real(wp) :: error(2) = 0.0_wp, accuracy = 0.0_wp
      !> Shape (width, room for rows).
      real(wp), allocatable :: values(:, :)
      type(found_events_t) :: found
      !> Indicators of chaos, where the run followed any.
      type(chaos_t), allocatable :: indicators
   end type history_handle_t

   !> Classes of many bodies.
   type, extends(handle_t) :: bodies_handle_t
      type(body_class_t), allocatable :: classes(:)
      !> Frame, threads and the number of the first class and body.
      type(movement_t) :: what = movement_t()
      !> Bodies that failed in the last call, counted from 1.
      integer, allocatable :: failed(:)
   end type bodies_handle_t

   !> A state as it was set, without what steps add to a `state_t`: it needs a fifth of the memory.
   type :: start_t
      private
      !> s; attitude and momentum, shape (4); momenta of the wheels.
      real(wp) :: t = 0.0_wp, q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], p(4) = 0.0_wp
      real(wp) :: wheel_momentum(most_wheels) = 0.0_wp
   contains
      procedure :: set => set_start
      procedure :: state => state_of_start
   end type start_t

   !> A run of a system, which single steps can go on with.
   type, extends(handle_t) :: stepper_handle_t
      !> A step of `tested_dt` needs nothing but the method's step, and its works counted: there is no callback or angle
      !> to follow, and no run has been there since.
      logical :: plain = .false.
      !> There are works to count.
      logical :: works = .false.
      !> The settings are to be read from `group`: what was set, as a scene's `&integrator`.
      logical :: stale = .false.
      type(group_t) :: group
      !> The step that was found admissible last, s; 0: none.
      real(wp) :: tested_dt = 0.0_wp
      !> With what is switched on, and held, now.
      type(system_t) :: system
      !> The present state, and all that has led to it since it was set. Its stepper is that of single steps and of
      !> nominal ones; where there is none, the settings have to be taken first.
      type(run_t) :: run
      !> Performs steps again, for `nutate_stepper_dense_output`; made where it is needed.
      class(stepper_t), allocatable :: inside
      !> The nominal step, or the goal, of its runs.
      type(run_plan_t) :: plan
      !> Status and what the callback returned, of a callback that failed; shape (2).
      integer(c_int) :: failure(2) = 0
      !> The poll callback of runs.
      type(poll_t) :: poll
      !> The state that was set: energy and work count from there. Its total energy, J.
      type(start_t) :: first
      real(wp) :: first_energy = 0.0_wp
      !> What runs look for, and what the last one found.
      type(event_list_t) :: events
      type(found_events_t), allocatable :: found
      !> The effects as they were when the state was set, where something has been switched, or held, since.
      type(effect_list_t), allocatable :: given
      character(len=name_length), allocatable :: sets(:)
      type(columns_t) :: columns
      !> Names of the columns, comma separated.
      character(len=:), allocatable :: names
      !> What runs propagate, if anything: the sensitivities by free numbers, where columns show them; indicators of
      !> chaos, and those of the last run.
      type(propagated_t), allocatable :: propagated
      type(variation_t), allocatable :: variations(:)
      type(chaos_settings_t), allocatable :: chaos
      type(chaos_t), allocatable :: indicators
   end type stepper_handle_t

   !> Points to the handle at an address and returns true, if it is one of the pointer's kind. The code becomes
   !> `NUTATE_BAD_HANDLE`, which the caller replaces.
   interface found
      module procedure found_system, found_scene, found_stepper, found_history, found_bodies, found_any
   end interface found

contains

   !> Returns true for the address of a handle of one of the kinds.
   logical function has_mark(address, marks, code)
      type(c_ptr), intent(in) :: address
      integer(c_int64_t), intent(in) :: marks(:)
      integer(c_int), intent(out), optional :: code
      type(handle_t), pointer :: handle
      if (present(code)) code = NUTATE_BAD_HANDLE
      has_mark = c_associated(address)
      if (.not. has_mark) return
      call c_f_pointer(address, handle)
      has_mark = any(handle%mark == marks)
   end function has_mark

   logical function found_system(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(system_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SYSTEM_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_system

   logical function found_scene(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(scene_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SCENE_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_scene

   logical function found_stepper(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(stepper_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [STEPPER_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_stepper

   logical function found_history(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(history_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [HISTORY_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_history

   logical function found_bodies(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(bodies_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_bodies

   !> What all handles begin with, for a handle of any kind.
   logical function found_any(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_any

   !> Frees the handle in a place of C, and sets that to null. Does nothing where it is null already. Errors:
   !> `NUTATE_BAD_ARGUMENT` for no place, `NUTATE_BAD_HANDLE` for a handle of another kind.
   integer(c_int) function destroy(address, mark) result(code)
      type(c_ptr), intent(in) :: address
      integer(c_int64_t), intent(in) :: mark
      type(c_ptr), pointer :: slot
      type(handle_t), pointer :: handle
      type(system_handle_t), pointer :: system
      type(scene_handle_t), pointer :: scene
      type(stepper_handle_t), pointer :: stepper
      type(history_handle_t), pointer :: history
      type(bodies_handle_t), pointer :: bodies
      code = NUTATE_BAD_ARGUMENT
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      code = NUTATE_OK
      if (.not. c_associated(slot)) return
      if (.not. has_mark(slot, [mark], code)) return
      call c_f_pointer(slot, handle)
      call erase_mark(handle%mark)
      if (mark == SYSTEM_MARK) then
         call c_f_pointer(slot, system)
         deallocate (system)
      else if (mark == SCENE_MARK) then
         call c_f_pointer(slot, scene)
         deallocate (scene)
      else if (mark == STEPPER_MARK) then
         call c_f_pointer(slot, stepper)
         deallocate (stepper)
      else if (mark == HISTORY_MARK) then
         call c_f_pointer(slot, history)
         deallocate (history)
      else
         call c_f_pointer(slot, bodies)
         deallocate (bodies)
      end if
      slot = c_null_ptr
      code = NUTATE_OK
   end function destroy

   !> The place where C keeps a handle, set to null; null where there is none.
   function open_slot(address) result(slot)
      !> Of type `nutate_...**`.
      type(c_ptr), intent(in) :: address
      type(c_ptr), pointer :: slot
      slot => null()
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      slot = c_null_ptr
   end function open_slot

   !> Clears the mark of a handle that is about to be freed, in memory and not only in the eyes of the compiler.
   subroutine erase_mark(mark)
      integer(c_int64_t), intent(inout), volatile :: mark
      mark = 0
   end subroutine erase_mark

   !> A copy of a system, whose callbacks report their failures to a cell.
   subroutine copy_system(from, to, cell)
      type(system_t), intent(in) :: from
      type(system_t), intent(inout) :: to
      !> Two `int`, or null.
      type(c_ptr), intent(in) :: cell
      to%body = from%body
      call to%effects%append(from%effects)
      call report_failures_to(to%effects, cell)
   end subroutine copy_system

   !> Keeps a state.
   pure subroutine set_start(self, state)
      class(start_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      self%t = state%t
      self%q = state%q
      self%p = state%p
      self%wheel_momentum = state%wheel_momentum
   end subroutine set_start

   !> The state that was set.
   pure type(state_t) function state_of_start(self) result(state)
      class(start_t), intent(in) :: self
      state%t = self%t
      state%q = self%q
      state%p = self%p
      state%wheel_momentum = self%wheel_momentum
   end function state_of_start

   !> Gives what the runs of a stepper propagate.
   subroutine get_propagated(handle, propagated)
      type(stepper_handle_t), intent(in) :: handle
      type(propagated_t), intent(out) :: propagated
      if (allocated(handle%propagated)) then
         propagated = handle%propagated
      else
         allocate (propagated%names(0), propagated%sigma(0))
      end if
   end subroutine get_propagated

   !> Sets what the runs of a stepper propagate.
   subroutine set_propagated(handle, propagated)
      type(stepper_handle_t), intent(inout) :: handle
      type(propagated_t), intent(in) :: propagated
      if (allocated(handle%propagated)) deallocate (handle%propagated)
      if (size(propagated%names) > 0 .or. propagated%exponents > 0) handle%propagated = propagated
   end subroutine set_propagated

   !> Sets the indicators of chaos that the runs of a stepper follow.
   subroutine set_chaos(handle, chaos)
      type(stepper_handle_t), intent(inout) :: handle
      type(chaos_settings_t), intent(in) :: chaos
      if (allocated(handle%chaos)) deallocate (handle%chaos)
      if (chaos%exponents > 0) handle%chaos = chaos
   end subroutine set_chaos

   !> Makes a stepper forget its method: the next step or run takes its settings and state anew.
   subroutine unprepare(handle)
      type(stepper_handle_t), intent(inout) :: handle
      handle%plain = .false.
      call handle%run%release()
      if (allocated(handle%run%stepper)) deallocate (handle%run%stepper)
      if (allocated(handle%inside)) deallocate (handle%inside)
   end subroutine unprepare

   !> Room for one more row in a history. Errors: `NUTATE_NO_MEMORY`.
   subroutine make_room(history, status)
      type(history_handle_t), intent(inout) :: history
      type(status_t), intent(inout) :: status
      real(wp), allocatable :: grown(:, :)
      integer(c_size_t), parameter :: first_room = 1024
      integer :: failed
      if (.not. allocated(history%values)) allocate (history%values(history%width, 0))
      if (history%rows < size(history%values, 2, c_size_t)) return
      allocate (grown(history%width, max(first_room, 2*history%rows)), stat=failed)
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for so many rows')
         return
      end if
      grown(:, 1:history%rows) = history%values
      call move_alloc(grown, history%values)
   end subroutine make_room

   !> The status of an argument that is null and must not be.
   pure function null_argument(name) result(status)
      character(len=*), intent(in) :: name
      type(status_t) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'the argument '//name//' is NULL', name)
   end function null_argument

   !> Keeps a status in a handle and gives its code.
   integer(c_int) function conclude(handle, status) result(code)
      class(handle_t), intent(inout) :: handle
      type(status_t), intent(in) :: status
      handle%status = status
      code = status%code
   end function conclude

   !> Writes the message of a status into a buffer and gives its code.
   integer(c_int) function report(status, buffer, size, whole) result(code)
      type(status_t), intent(in) :: status
      type(c_ptr), intent(in) :: buffer
      integer(c_size_t), intent(in) :: size
      !> A text that may be that of the status, whole.
      character(len=:), allocatable, intent(in), optional :: whole
      if (present(whole)) then
         call message_to_c(whole_message(status, whole), buffer, size)
      else
         call message_to_c(status%message, buffer, size)
      end if
      code = status%code
   end function report

   !> The message of a status: a text in whose place it stands, if it does so for one.
   pure function whole_message(status, whole) result(message)
      type(status_t), intent(in) :: status
      character(len=:), allocatable, intent(in) :: whole
      character(len=:), allocatable :: message
      type(status_t) :: short
      message = trim(status%message)
      if (status%ok() .or. .not. allocated(whole)) return
      short = fail(status%code, whole)
      if (short%message == status%message) message = whole
   end function whole_message

end module nutate_c_handles
