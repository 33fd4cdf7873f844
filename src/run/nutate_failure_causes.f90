!> Likely causes, in words, of the failure of a step that no shorter one can replace.
module nutate_failure_causes
   use nutate_method_choice, only: effect_without_series
   use nutate_projected_stepper, only: projected_stepper_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   implicit none
   private

   public :: add_jump, add_cause

contains

   !> Adds to a failure that an effect may jump, if there is one that could: effects with a power series in time do not,
   !> and all except user-defined ones have one.
   pure subroutine add_jump(system, status)
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      character(len=24) :: effect
      effect = effect_without_series(system%effects)
      if (effect == '') return
      status%message = trim(status%message)//"; perhaps effect '"//trim(effect)//"' jumps: method 'dop853' with a "// &
                       'fixed time_step, without conserve, steps over jumps'
   end subroutine add_jump

   !> Adds the likely cause to the failure of a step, and of all its parts.
   pure subroutine add_cause(stepper, system, status)
      !> Stepper that took the step.
      class(stepper_t), intent(in) :: stepper
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      character(len=len(status%message)) :: before
      before = status%message
      ! Newton's iteration needs forces without jumps, and so does the search for the energy that the work accounts for.
      if (stepper%iterations > 0 .or. is_projected(stepper)) call add_jump(system, status)
      if (status%message /= before) return
      status%message = trim(before)//': the time step is over 1000 times too long for the rotation or for an effect'
   end subroutine add_cause

   pure logical function is_projected(stepper)
      class(stepper_t), intent(in) :: stepper
      is_projected = .false.
      select type (stepper)
      class is (projected_stepper_t)
         is_projected = .true.
      end select
   end function is_projected

end module nutate_failure_causes
