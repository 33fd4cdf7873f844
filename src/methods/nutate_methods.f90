!> The integration methods a scene can name: one line each. A new method is a file of its own, a line of the table here,
!> and a `use` and a case of `make_stepper` in `nutate_method_steppers`.
module nutate_methods
   use nutate_power_series, only: fixed_step_order
   use nutate_status, only: status_t
   use nutate_stepper, only: dense_stepper_t, integrator_settings_t, stepper_t, system_t
   implicit none
   private

   !> Types of the arguments of `make_stepper`, which its callers need.
   public :: dense_stepper_t, integrator_settings_t, stepper_t, system_t
   public :: method_t, methods, make_stepper, compose_stepper, default_settings, equations_of, family_of, row_of, &
      leaves_attitude_out, method_of, with_defaults

   !> One method: its names in scene files and messages, and its properties.
   type :: method_t
      character(len=24) :: name
      !> Formulation; blank for a method without one, of which there is a single row.
      character(len=24) :: formulation
      !> Order of the method; 0 for the exact solution.
      integer :: order
      !> Number of solutions of the equations in a step, or of their evaluations.
      integer :: stages
      !> Equations that are solved or evaluated.
      character(len=40) :: equations
      !> The state is projected onto the invariants.
      logical :: projected = .false.
      !> The estimate of its error that a step gives falls as this power of the step; 0: there is none.
      integer :: estimate_power = 0
      !> The method computes the length of a step before the step, and the states inside (`dense_stepper_t`).
      logical :: dense = .false.
      !> The method keeps energy and conserved momentum to round-off at any step.
      logical :: conserving = .true.
      !> The method conserves by itself, to the round-off of its steps, which adds up: it can be projected as well,
      !> without another row for that.
      logical :: can_project = .false.
      !> Fixed steps from one projection to the next, without torques and while errors are small. A projection needs
      !> 0.06 to 0.15 µs, half of a specialised step. With 8, energy and momentum are as good as with 1; with long steps
      !> on the unstable axis of a box the attitude error is up to six times as large, with 4 hardly larger. If there is
      !> only round-off to remove, 32 is enough.
      integer :: spacing = 4
      !> The method integrates free bodies and tops in special variables (`nutate_specialised_motion`), with long steps.
      logical :: specialised = .false.
   end type method_t

   character(len=*), parameter :: eight = '8 equations in q and p (LAPACK)', &
      three = '3 equations in the turn of the step', explicit = '7 explicit equations in q and L', &
      series = 'power series of momentum and attitude', closed = 'the closed solution of a free body'

   !> All combinations of method, formulation, order and projection; the first row of each method is its default.
   type(method_t), parameter :: methods(*) = [ &
      method_t('nielsen_krenk', 'full', 2, 1, eight, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'full', 4, 5, eight, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'full', 6, 9, eight, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'full', 8, 17, eight, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'reduced', 2, 1, three, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'reduced', 4, 5, three, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'reduced', 6, 9, three, can_project=.true., spacing=32), &
      method_t('nielsen_krenk', 'reduced', 8, 17, three, can_project=.true., spacing=32), &
      method_t('rk4', '', 4, 4, explicit, conserving=.false.), &
      method_t('rk4', '', 4, 4, explicit, projected=.true.), &
      method_t('rk8', '', 8, 12, explicit, projected=.true., spacing=8, specialised=.true.), &
      method_t('rk8', '', 8, 12, explicit, conserving=.false., specialised=.true.), &
      method_t('dop853', '', 8, 12, explicit, estimate_power=8, conserving=.false.), &
      method_t('dop853', '', 8, 12, explicit, projected=.true., estimate_power=8), &
      method_t('taylor', '', fixed_step_order, 1, series, projected=.true., dense=.true.), &
      method_t('taylor', '', fixed_step_order, 1, series, dense=.true., conserving=.false.), &
      method_t('exact', '', 0, 1, closed, dense=.true.)]

   interface

      !> Makes a stepper of the method that the settings name, prepared for a system; an existing stepper of the same
      !> parts is prepared anew instead. Without attitude it is the reduced form for either formulation: the body
      !> momentum has three equations.
      !>
      !> Errors, with no stepper: `NUTATE_BAD_ARGUMENT` for a combination that does not exist, and those of the method's
      !> `prepare`.
      module subroutine make_stepper(system, settings, stepper, status)
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         class(stepper_t), allocatable, intent(inout) :: stepper
         type(status_t), intent(out) :: status
      end subroutine make_stepper

      !> Replaces a stepper of order 2 by its composition, not yet prepared. Errors: those of `compose`.
      module subroutine compose_stepper(order, stepper, status)
         !> Order of the composition: 4, 6 or 8.
         integer, intent(in) :: order
         class(stepper_t), allocatable, intent(inout) :: stepper
         type(status_t), intent(out) :: status
      end subroutine compose_stepper

   end interface

contains

   !> Returns the common name of rows that differ only in order and formulation, with `+conserve` for a method with the
   !> projection onto the invariants.
   elemental function family_of(method) result(name)
      type(method_t), intent(in) :: method
      character(len=32) :: name
      name = method%name
      if (method%projected) name = trim(name)//'+conserve'
   end function family_of

   !> Returns the default settings of a method: those of its first row in the table.
   pure type(integrator_settings_t) function default_settings(method) result(settings)
      !> Name of the method.
      character(len=*), intent(in) :: method
      integer :: i
      settings%method = method
      do i = 1, size(methods)
         ! Strings of equal length are compared without a call.
         if (methods(i)%name /= settings%method) cycle
         settings%order = methods(i)%order
         settings%formulation = methods(i)%formulation
         settings%conserve = methods(i)%projected
         exit
      end do
   end function default_settings

   !> Returns the settings with their defaults: the method is `nielsen_krenk`; order and formulation are those of the
   !> method's first row.
   pure type(integrator_settings_t) function with_defaults(settings) result(complete)
      type(integrator_settings_t), intent(in) :: settings
      type(integrator_settings_t) :: usual
      complete = settings
      if (complete%method == '') complete%method = 'nielsen_krenk'
      usual = default_settings(complete%method)
      if (complete%order == 0) complete%order = usual%order
      if (complete%formulation == '') complete%formulation = usual%formulation
   end function with_defaults

   !> Returns the row of the table that the settings select; 0 if there is none. Order and formulation are used if the
   !> method has several.
   pure integer function row_of(settings)
      !> Settings with their defaults.
      type(integrator_settings_t), intent(in) :: settings
      integer :: i
      row_of = 0
      do i = 1, size(methods)
         if (methods(i)%name /= settings%method) cycle
         if ((methods(i)%projected .neqv. settings%conserve) .and. .not. methods(i)%can_project) cycle
         if (methods(i)%formulation == '' .or. (methods(i)%formulation == settings%formulation .and. &
                                                  methods(i)%order == settings%order)) row_of = i
      end do
   end function row_of

   !> Returns the row of the table that the settings select, with the requested order of a series; of order 0 and
   !> without a name if there is none.
   pure type(method_t) function method_of(settings) result(method)
      type(integrator_settings_t), intent(in) :: settings
      integer :: row
      row = row_of(with_defaults(settings))
      method = method_t('', '', 0, 0, '')
      if (row > 0) method = methods(row)
      if (row > 0) method%projected = settings%conserve
      if (settings%method == 'taylor' .and. settings%series_order > 0) method%order = settings%series_order
   end function method_of

   !> Returns in words what a step with these settings solves.
   pure function equations_of(settings) result(text)
      type(integrator_settings_t), intent(in) :: settings
      character(len=:), allocatable :: text
      type(method_t) :: method
      character(len=12) :: stages
      method = method_of(settings)
      text = trim(method%equations)
      write (stages, '(i0)') method%stages
      if (method%stages > 1) text = text//', '//trim(stages)//' stages'
      if (method%projected) text = text//', projection onto the invariants'
      if (leaves_attitude_out(with_defaults(settings))) &
         text = '3 equations for the body momentum; nothing depends on the attitude, which is left out'
   end function equations_of

   !> Returns true if the body momentum alone is integrated.
   pure logical function leaves_attitude_out(settings)
      type(integrator_settings_t), intent(in) :: settings
      leaves_attitude_out = .not. settings%attitude .and. settings%method == 'nielsen_krenk'
   end function leaves_attitude_out

end module nutate_methods
