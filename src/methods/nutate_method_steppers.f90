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
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_taylor_stepper, only: taylor_t
   use nutate_rotated_stepper, only: rotated_stepper_t
   implicit none

contains

   module procedure make_stepper
      type(integrator_settings_t) :: complete
      type(method_t) :: method
      type(lvlh_view_t) :: view
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
      if (complete%method == 'nielsen_krenk' .and. complete%attitude .and. follows_rotating_axes(system%effects)) &
         call turn_stepper(stepper)
      if (complete%conserve .and. complete%method /= 'taylor') call project_stepper(method%spacing, stepper)
      if (.not. status%ok()) return
      stepper%conserves = method%can_project .and. .not. complete%conserve
      call view%prepare(system)
      if (view%exists .and. complete%attitude .and. .not. complete%in_space_axes) call step_in_lvlh(stepper)
      call stepper%prepare(system, complete, status)
   end procedure make_stepper

   module procedure get_stepper
      if (allocated(stepper)) then
         call stepper%prepare(system, settings, status)
      else
         call make_stepper(system, settings, stepper, status)
      end if
   end procedure get_stepper

   !> Puts a stepper with the turn of space axes that its motion does not know of in its place.
   subroutine turn_stepper(stepper)
      class(stepper_t), allocatable, intent(inout) :: stepper
      type(rotated_stepper_t), allocatable :: rotated
      allocate (rotated)
      call rotated%wrap(stepper)
      call move_alloc(rotated, stepper)
   end subroutine turn_stepper

   !> Puts a stepper that works in the LVLH frame in its place.
   subroutine step_in_lvlh(stepper)
      class(stepper_t), allocatable, intent(inout) :: stepper
      type(lvlh_stepper_t), allocatable :: wrapped
      allocate (wrapped)
      call wrapped%wrap(stepper)
      call move_alloc(wrapped, stepper)
   end subroutine step_in_lvlh

   !> Puts a stepper with the projection onto the invariants in its place.
   subroutine project_stepper(spacing, stepper)
      !> Steps to a projection.
      integer, intent(in) :: spacing
      class(stepper_t), allocatable, intent(inout) :: stepper
      type(projected_stepper_t), allocatable :: projected
      allocate (projected)
      call projected%wrap(stepper, spacing)
      call move_alloc(projected, stepper)
   end subroutine project_stepper

   module procedure compose_stepper
      type(composition_t), allocatable :: composition
      allocate (composition)
      call composition%compose(stepper, order, status)
      call move_alloc(composition, stepper)
   end procedure compose_stepper

end submodule nutate_method_steppers
