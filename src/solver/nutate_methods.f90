!> The integration methods a scene can name: one line each. A new method is its own file and a line here.
module nutate_methods
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: method_t, methods, make_stepper

   !> One method, as scene files and messages speak of it.
   type :: method_t
      character(len=24) :: name
      character(len=24) :: linear_solver
      integer :: order
      !> What is solved in a step.
      character(len=64) :: equations
   end type method_t

   !> Every combination of method, linear solver and order that there is.
   type(method_t), parameter :: methods(1) = [ &
      method_t('nielsen_krenk', 'lapack', 2, '8 equations in q and p (LAPACK)')]

contains

   !> A stepper of the method that the settings name, prepared for a system.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a combination that does not exist, and those of the method's `prepare`.
   subroutine make_stepper(system, settings, stepper, status)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      class(stepper_t), allocatable, intent(out) :: stepper
      type(status_t), intent(out) :: status
      if (.not. any(methods%name == settings%method .and. methods%linear_solver == settings%linear_solver .and. &
                    methods%order == settings%order)) then
         status = fail(NUTATE_BAD_ARGUMENT, "no method '"//trim(settings%method)//"' of this order and solver", &
                       'method')
         return
      end if
      allocate (nielsen_krenk_t :: stepper)
      call stepper%prepare(system, settings, status)
   end subroutine make_stepper

end module nutate_methods
