!> The integration methods a scene can name: one line each. A new method is its own file and a line here.
module nutate_methods
   use nutate_composition, only: composition_t
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_reduced, only: reduced_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: method_t, methods, make_stepper, equations_of

   !> One method, as scene files and messages speak of it.
   type :: method_t
      character(len=24) :: name
      character(len=24) :: linear_solver
      integer :: order
      !> What is solved in a step.
      character(len=64) :: equations
   end type method_t

   !> Every combination of method, linear solver and order that there is.
   type(method_t), parameter :: methods(8) = [ &
      method_t('nielsen_krenk', 'lapack', 2, '8 equations in q and p (LAPACK)'), &
      method_t('nielsen_krenk', 'lapack', 4, '8 equations in q and p (LAPACK), 5 times'), &
      method_t('nielsen_krenk', 'lapack', 6, '8 equations in q and p (LAPACK), 9 times'), &
      method_t('nielsen_krenk', 'lapack', 8, '8 equations in q and p (LAPACK), 17 times'), &
      method_t('nielsen_krenk', 'reduced', 2, '3 equations in the turn of the step'), &
      method_t('nielsen_krenk', 'reduced', 4, '3 equations in the turn of the step, 5 times'), &
      method_t('nielsen_krenk', 'reduced', 6, '3 equations in the turn of the step, 9 times'), &
      method_t('nielsen_krenk', 'reduced', 8, '3 equations in the turn of the step, 17 times')]

contains

   !> What a step of these settings solves, in words.
   pure function equations_of(settings) result(text)
      type(integrator_settings_t), intent(in) :: settings
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(methods)
         if (methods(i)%name == settings%method .and. methods(i)%linear_solver == settings%linear_solver .and. &
             methods(i)%order == settings%order) text = trim(methods(i)%equations)
      end do
      if (.not. settings%attitude) &
         text = '3 equations for the body momentum; nothing depends on the attitude, which is left out'
   end function equations_of

   !> A stepper of the method that the settings name, prepared for a system. Without attitude it is the reduced form,
   !> whichever the solver: the body momentum has three equations.
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
      if (settings%linear_solver == 'reduced' .or. .not. settings%attitude) then
         allocate (reduced_t :: stepper)
      else
         allocate (nielsen_krenk_t :: stepper)
      end if
      if (settings%order > 2) call compose_stepper(settings%order, stepper, status)
      if (status%ok()) call stepper%prepare(system, settings, status)
   end subroutine make_stepper

   !> Puts the composition of a stepper in its place.
   subroutine compose_stepper(order, stepper, status)
      integer, intent(in) :: order
      class(stepper_t), allocatable, intent(inout) :: stepper
      type(status_t), intent(out) :: status
      type(composition_t), allocatable :: composition
      allocate (composition)
      call composition%compose(stepper, order, status)
      call move_alloc(composition, stepper)
   end subroutine compose_stepper

end module nutate_methods
