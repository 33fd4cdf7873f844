!> Makes the steppers of the methods: only this submodule uses their types, so that no other module is compiled with all
!> of them.
submodule(nutate_methods) nutate_method_steppers
   use nutate_composition, only: composition_t
   use nutate_dop853, only: dop853_t
   use nutate_exact_stepper, only: exact_t
   use nutate_invariants, only: follows_rotating_axes
   use nutate_lvlh_stepper, only: lvlh_stepper_t
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_projected_stepper, only: projected_stepper_t
   use nutate_reduced, only: reduced_t
   use nutate_rk4, only: rk4_t
   use nutate_rk8, only: rk8_t
   use nutate_rotated_stepper, only: rotated_stepper_t
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_taylor_stepper, only: taylor_t
   implicit none

contains

   module procedure make_stepper
      type(integrator_settings_t) :: complete
      integer :: row, parts
      logical :: in_rotating_axes, in_lvlh_axes
      complete = with_defaults(settings)
      row = row_of(complete)
      if (row == 0) then
         if (allocated(stepper)) deallocate (stepper)
         status = fail(NUTATE_BAD_ARGUMENT, "no method '"//trim(complete%method)// &
                       "' of this order and formulation, with or without conserve as asked for", 'method')
         return
      end if
      call find_wrappers(system, complete, in_rotating_axes, in_lvlh_axes)
      ! One binary digit for each part besides the row of the method.
      parts = sum([row, 64, 128, 256, 512], &
                  mask=[.true., complete%conserve, complete%attitude, in_rotating_axes, in_lvlh_axes])
      if (allocated(stepper)) then
         if (stepper%parts /= parts) deallocate (stepper)
      end if
      if (.not. allocated(stepper)) then
         call put_together(complete, methods(row), in_rotating_axes, in_lvlh_axes, stepper, status)
         if (.not. status%ok()) then
            if (allocated(stepper)) deallocate (stepper)
            return
         end if
         stepper%parts = parts
      end if
      call stepper%prepare(system, complete, status)
      if (.not. status%ok()) deallocate (stepper)
   end procedure make_stepper

   !> Finds the axes in which a stepper performs its steps.
   subroutine find_wrappers(system, settings, in_rotating_axes, in_lvlh_axes)
      type(system_t), intent(in) :: system
      !> Settings with their defaults.
      type(integrator_settings_t), intent(in) :: settings
      !> True if steps are in fixed axes and states are rotated back (`nutate_rotated_stepper`); true if steps are in
      !> the LVLH axes of a circular orbit.
      logical, intent(out) :: in_rotating_axes, in_lvlh_axes
      type(lvlh_view_t) :: view
      in_rotating_axes = all(settings%method /= ['taylor', 'exact ']) .and. settings%attitude .and. &
                follows_rotating_axes(system%effects)
      in_lvlh_axes = settings%attitude .and. .not. settings%in_space_axes
      if (.not. in_lvlh_axes) return
      call view%prepare(system)
      in_lvlh_axes = view%exists
   end subroutine find_wrappers

   !> Composes a stepper, not yet prepared. Errors: those of `compose`.
   subroutine put_together(complete, method, in_rotating_axes, in_lvlh_axes, stepper, status)
      !> Settings with their defaults, and the row of the table that they select.
      type(integrator_settings_t), intent(in) :: complete
      type(method_t), intent(in) :: method
      logical, intent(in) :: in_rotating_axes, in_lvlh_axes
      class(stepper_t), allocatable, intent(out) :: stepper
      type(status_t), intent(inout) :: status
      type(projected_stepper_t), allocatable :: projected
      class(stepper_wrapper_t), allocatable :: wrapper
      select case (complete%method)
      case ('rk4')
         allocate (rk4_t :: stepper)
      case ('rk8')
         allocate (rk8_t :: stepper)
      case ('dop853')
         allocate (dop853_t :: stepper)
      case ('taylor')
         allocate (taylor_t :: stepper)
      case ('exact')
         allocate (exact_t :: stepper)
      case default
         if (complete%formulation == 'reduced' .or. leaves_attitude_out(complete)) then
            allocate (reduced_t :: stepper)
         else
            allocate (nielsen_krenk_t :: stepper)
         end if
         if (complete%order > 2) call compose_stepper(complete%order, stepper, status)
      end select
      if (in_rotating_axes) then
         allocate (rotated_stepper_t :: wrapper)
         call put_around(wrapper, stepper)
      end if
      if (complete%conserve .and. complete%method /= 'taylor') then
         allocate (projected)
         projected%spacing = method%spacing
         call move_alloc(projected, wrapper)
         call put_around(wrapper, stepper)
      end if
      if (.not. status%ok()) return
      stepper%conserves = method%can_project .and. .not. complete%conserve
      if (in_lvlh_axes) then
         allocate (lvlh_stepper_t :: wrapper)
         call put_around(wrapper, stepper)
      end if
   end subroutine put_together

   !> Replaces a stepper by a wrapper that contains it.
   subroutine put_around(wrapper, stepper)
      class(stepper_wrapper_t), allocatable, intent(inout) :: wrapper
      class(stepper_t), allocatable, intent(inout) :: stepper
      call wrapper%wrap(stepper)
      call move_alloc(wrapper, stepper)
   end subroutine put_around

   module procedure compose_stepper
      type(composition_t), allocatable :: composition
      allocate (composition)
      call composition%compose(stepper, order, status)
      call move_alloc(composition, stepper)
   end procedure compose_stepper

end submodule nutate_method_steppers
