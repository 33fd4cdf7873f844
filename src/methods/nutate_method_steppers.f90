!> Makes the steppers of the methods: their types are known here alone, so that no other module is compiled with all of
!> them.
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
      type(method_t) :: method
      type(lvlh_view_t) :: view
      type(projected_stepper_t), allocatable :: projected
      class(stepper_wrapper_t), allocatable :: wrapper
      complete = with_defaults(settings)
      method = method_of(settings)
      if (method%name == '') then
         status = fail(NUTATE_BAD_ARGUMENT, "no method '"//trim(complete%method)// &
                       "' of this order and formulation, with or without conserve as asked for", 'method')
         return
      end if
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
      if (all(complete%method /= ['taylor', 'exact ']) .and. complete%attitude .and. &
          follows_rotating_axes(system%effects)) then
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
      call view%prepare(system)
      if (view%exists .and. complete%attitude .and. .not. complete%in_space_axes) then
         allocate (lvlh_stepper_t :: wrapper)
         call put_around(wrapper, stepper)
      end if
      call stepper%prepare(system, complete, status)
   end procedure make_stepper

   module procedure get_stepper
      if (allocated(stepper)) then
         call stepper%prepare(system, settings, status)
      else
         call make_stepper(system, settings, stepper, status)
      end if
   end procedure get_stepper

   !> Puts a wrapper with a stepper inside in the stepper's place.
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
