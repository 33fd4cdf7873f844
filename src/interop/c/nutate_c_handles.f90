!> Types behind the opaque handles of the C interface.
!>
!> Every handle begins with a mark of its kind. The mark is cleared when the handle is destroyed, so that a destroyed
!> handle, or one of another kind, is recognised.
module nutate_c_handles
   use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_ptr, c_size_t
   use nutate_bodies, only: movement_t
   use nutate_bodies_drift, only: body_class_t
   use nutate_c_found, only: found_events_t
   use nutate_c_polls, only: poll_t
   use nutate_chaos, only: chaos_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_variation, only: variation_t
   use nutate_columns, only: columns_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event_list, only: event_list_t
   use nutate_fit_problem, only: fit_problem_t
   use nutate_keys, only: group_t, name_length
   use nutate_kinds, only: wp, long
   use nutate_limits, only: most_inner
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   use nutate_propagated, only: propagated_t
   implicit none
   private

   public :: handle_t, system_handle_t, scene_handle_t, stepper_handle_t, history_handle_t, bodies_handle_t
   public :: SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK
   public :: found, destroy, open_slot, copy_system, null_argument, report, whole_message, conclude, make_room
   public :: unprepare, get_propagated, set_propagated, set_chaos

   !> Marks of the kinds of handles.
   integer(c_int64_t), parameter :: SYSTEM_MARK = 7811887110843601971_c_int64_t, &
                                    SCENE_MARK = 7811887110843601972_c_int64_t, &
                                    STEPPER_MARK = 7811887110843601973_c_int64_t, &
                                    HISTORY_MARK = 7811887110843601974_c_int64_t, &
                                    BODIES_MARK = 7811887110843601975_c_int64_t

   !> Common part of all handles, at their beginning.
   type :: handle_t
      !> Mark of the kind.
      integer(c_int64_t) :: mark = 0
      !> Status of the last call.
      type(status_t) :: status
      !> Complete message of an error; that of the status may lack its middle.
      character(len=:), allocatable :: text
   end type handle_t

   !> A body and the effects on it.
   type, extends(handle_t) :: system_handle_t
      type(system_t) :: system
   end type system_handle_t

   type, extends(handle_t) :: scene_handle_t
      type(scene_t) :: scene
      !> The poll callback of its runs.
      type(poll_t) :: poll
      !> Residuals of the fit of the scene; allocated when they are first requested.
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
      !> `estimate` and `round_off` of a run with an accuracy, and this accuracy, rad.
      real(wp) :: error(2) = 0.0_wp, accuracy = 0.0_wp
      !> Rows; shape (width, room for rows).
      real(wp), allocatable :: values(:, :)
      type(found_events_t) :: found
      !> Chaos indicators, if the run computed any.
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

   !> State as it was set, without the components that steps add to a `state_t`: it needs a fifth of the memory.
   type, private :: start_t
      private
      !> Time, s; attitude and momentum, shape (4); momenta of the wheels.
      real(wp) :: t = 0.0_wp, q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], p(4) = 0.0_wp
      real(wp) :: wheel_momentum(most_inner) = 0.0_wp
   contains
      procedure :: set => set_start
      procedure :: state => state_of_start
   end type start_t

   !> A run of a system, which single steps can continue.
   type, extends(handle_t) :: stepper_handle_t
      !> True if a step of `tested_dt` needs only the method's step and the count of its work: there is no callback and
      !> no angle to follow, and no run has been made since.
      logical :: plain = .false.
      !> True if there is work to count.
      logical :: works = .false.
      !> True if the settings must be read from `group`, which has the keys that were set, as in `&integrator` of a
      !> scene.
      logical :: stale = .false.
      !> True if a method has been prepared with these settings and for these effects.
      logical :: is_valid = .false.
      type(group_t) :: group
      !> Length of the last step that was admissible, s; 0: none.
      real(wp) :: tested_dt = 0.0_wp
      !> System with the effects that are on now, and the values that are held now.
      type(system_t) :: system
      !> Present state, and the run since a state was set. The stepper of the run performs single and nominal steps; if
      !> it is not allocated, the settings must be read first.
      type(run_t) :: run
      !> Stepper that repeats steps for `nutate_stepper_dense_output`; allocated when it is first needed.
      class(stepper_t), allocatable :: inside
      !> Nominal step, or goal, of the runs.
      type(run_plan_t) :: plan
      !> Status of a callback that failed, and the value that it returned; shape (2).
      integer(c_int) :: failure(2) = 0
      !> The poll callback of runs.
      type(poll_t) :: poll
      !> State that was set, from which energy and work are counted; total energy of this state, J.
      type(start_t) :: first
      real(wp) :: first_energy = 0.0_wp
      !> Events that runs search for, and the events that the last run found.
      type(event_list_t) :: events
      type(found_events_t), allocatable :: found
      !> Effects as they were when the state was set; allocated if any was switched, or a value held, since.
      type(effect_list_t), allocatable :: given
      character(len=name_length), allocatable :: sets(:)
      type(columns_t) :: columns
      !> Names of the columns, comma separated.
      character(len=:), allocatable :: names
      !> Quantities that runs propagate, if any: names; sensitivities with respect to parameters, if columns show them;
      !> settings of the chaos indicators; chaos indicators of the last run.
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

   interface

      logical module function found_system(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(system_handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_system

      logical module function found_scene(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(scene_handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_scene

      logical module function found_stepper(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(stepper_handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_stepper

      logical module function found_history(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(history_handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_history

      logical module function found_bodies(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(bodies_handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_bodies

      !> Finds a handle of any kind; the pointer gives access to the common part of all handles.
      logical module function found_any(address, handle, code) result(is_found)
         type(c_ptr), intent(in) :: address
         type(handle_t), pointer, intent(inout) :: handle
         integer(c_int), intent(out), optional :: code
      end function found_any

      !> Frees the handle in a variable of C, and sets the variable to null. Does nothing if it is null already. Errors:
      !> `NUTATE_BAD_ARGUMENT` for no variable, `NUTATE_BAD_HANDLE` for a handle of another kind.
      integer(c_int) module function destroy(address, mark) result(code)
         type(c_ptr), intent(in) :: address
         integer(c_int64_t), intent(in) :: mark
      end function destroy

      !> Returns the variable in which C keeps a handle, set to null; null if there is no variable.
      module function open_slot(address) result(slot)
         !> Address of the variable, of type `nutate_...**`.
         type(c_ptr), intent(in) :: address
         type(c_ptr), pointer :: slot
      end function open_slot

      !> Copies a system; the callbacks of the copy report their failures to a cell.
      module subroutine copy_system(from, to, cell)
         type(system_t), intent(in) :: from
         type(system_t), intent(inout) :: to
         !> Address of two `int`, or null.
         type(c_ptr), intent(in) :: cell
      end subroutine copy_system

      !> Stores a state.
      pure module subroutine set_start(self, state)
         class(start_t), intent(inout) :: self
         type(state_t), intent(in) :: state
      end subroutine set_start

      !> Returns the state that was set.
      pure type(state_t) module function state_of_start(self) result(state)
         class(start_t), intent(in) :: self
      end function state_of_start

      !> Returns the quantities that the runs of a stepper propagate.
      module subroutine get_propagated(handle, propagated)
         type(stepper_handle_t), intent(in) :: handle
         type(propagated_t), intent(out) :: propagated
      end subroutine get_propagated

      !> Sets the quantities that the runs of a stepper propagate.
      module subroutine set_propagated(handle, propagated)
         type(stepper_handle_t), intent(inout) :: handle
         type(propagated_t), intent(in) :: propagated
      end subroutine set_propagated

      !> Sets the chaos indicators that the runs of a stepper compute.
      module subroutine set_chaos(handle, chaos)
         type(stepper_handle_t), intent(inout) :: handle
         type(chaos_settings_t), intent(in) :: chaos
      end subroutine set_chaos

      !> Deletes the method of a stepper: the next step or run prepares it from settings and state.
      module subroutine unprepare(handle)
         type(stepper_handle_t), intent(inout) :: handle
      end subroutine unprepare

      !> Makes room for one more row in a history. Errors: `NUTATE_NO_MEMORY`.
      module subroutine make_room(history, status)
         type(history_handle_t), intent(inout) :: history
         type(status_t), intent(inout) :: status
      end subroutine make_room

      !> Returns the status for an argument that is null and must not be.
      pure module function null_argument(name) result(status)
         character(len=*), intent(in) :: name
         type(status_t) :: status
      end function null_argument

      !> Stores a status in a handle and returns its code.
      integer(c_int) module function conclude(handle, status) result(code)
         class(handle_t), intent(inout) :: handle
         type(status_t), intent(in) :: status
      end function conclude

      !> Writes the message of a status into a buffer and returns its code.
      integer(c_int) module function report(status, buffer, size, whole) result(code)
         type(status_t), intent(in) :: status
         type(c_ptr), intent(in) :: buffer
         integer(c_size_t), intent(in) :: size
         !> Complete message, which is used if the status has its shortened form.
         character(len=:), allocatable, intent(in), optional :: whole
      end function report

      !> Returns the message of a status, or the complete message if the status has its shortened form.
      pure module function whole_message(status, whole) result(message)
         type(status_t), intent(in) :: status
         character(len=:), allocatable, intent(in) :: whole
         character(len=:), allocatable :: message
      end function whole_message

   end interface

end module nutate_c_handles
