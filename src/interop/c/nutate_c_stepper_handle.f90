!> Type behind the handles of steppers in the C interface.
module nutate_c_stepper_handle
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_int, c_ptr
   use nutate_c_found, only: found_events_t
   use nutate_c_handles, only: conclude, found, handle_t, has_mark, is_taken, null_argument, open_slot, report, &
      STEPPER_MARK
   use nutate_c_polls, only: poll_t
   use nutate_chaos, only: chaos_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_variation, only: variation_t
   use nutate_columns, only: columns_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event_list, only: event_list_t
   use nutate_keys, only: group_t, name_length
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   use nutate_run, only: run_t, system_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_stepper, only: stepper_t
   use nutate_propagated, only: propagated_t
   implicit none
   private

   public :: stepper_handle_t, lacks_attitude, left_out, unprepare, get_propagated, set_propagated, set_chaos
   !> Procedures that all functions with a stepper need.
   public :: conclude, found, is_taken, null_argument, open_slot, report, STEPPER_MARK

   !> Message about an attitude that is not known.
   character(len=*), parameter :: left_out = 'the steps leave out the attitude'

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

   interface found
      module procedure found_stepper
   end interface found

contains

   logical function found_stepper(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(stepper_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [STEPPER_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_stepper

   !> Stores a state.
   pure subroutine set_start(self, state)
      class(start_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      self%t = state%t
      self%q = state%q
      self%p = state%p
      self%wheel_momentum = state%wheel_momentum
   end subroutine set_start

   !> Returns the state that was set.
   pure type(state_t) function state_of_start(self) result(state)
      class(start_t), intent(in) :: self
      state%t = self%t
      state%q = self%q
      state%p = self%p
      state%wheel_momentum = self%wheel_momentum
   end function state_of_start

   !> Returns true if steps since the state was set have left out the attitude, so that it is not known.
   pure logical function lacks_attitude(handle)
      type(stepper_handle_t), intent(in) :: handle
      lacks_attitude = .not. handle%run%requested%attitude .and. abs(handle%run%state%t - handle%first%t) > 0.0_wp
   end function lacks_attitude

   !> Returns the quantities that the runs of a stepper propagate.
   subroutine get_propagated(handle, propagated)
      type(stepper_handle_t), intent(in) :: handle
      type(propagated_t), intent(out) :: propagated
      if (allocated(handle%propagated)) then
         propagated = handle%propagated
      else
         allocate (propagated%names(0), propagated%sigma(0))
      end if
   end subroutine get_propagated

   !> Sets the quantities that the runs of a stepper propagate.
   subroutine set_propagated(handle, propagated)
      type(stepper_handle_t), intent(inout) :: handle
      type(propagated_t), intent(in) :: propagated
      if (allocated(handle%propagated)) deallocate (handle%propagated)
      if (size(propagated%names) > 0 .or. propagated%exponents > 0) handle%propagated = propagated
   end subroutine set_propagated

   !> Sets the chaos indicators that the runs of a stepper compute.
   subroutine set_chaos(handle, chaos)
      type(stepper_handle_t), intent(inout) :: handle
      type(chaos_settings_t), intent(in) :: chaos
      if (allocated(handle%chaos)) deallocate (handle%chaos)
      if (chaos%exponents > 0) handle%chaos = chaos
   end subroutine set_chaos

   !> Lets the next step or run prepare the method of a stepper from settings and state.
   subroutine unprepare(handle)
      type(stepper_handle_t), intent(inout) :: handle
      handle%plain = .false.
      call handle%run%release()
      if (allocated(handle%run%stepper)) call move_alloc(handle%run%stepper, handle%run%spare)
      if (allocated(handle%inside)) deallocate (handle%inside)
   end subroutine unprepare

end module nutate_c_stepper_handle
