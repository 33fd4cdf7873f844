!> A constant force at a point of the body: V = -F·(R x), like weight in another direction. The force is fixed in space
!> axes, or in axes that rotate relative to these: the LVLH frame of an orbit in inertial axes, or inertial axes in the
!> LVLH frame.
module nutate_force
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_moving_linear, only: moving_linear_t
   implicit none
   private

   public :: force_t, moving_force_t

   !> U(γ) = -x·γ with γ = R(q)ᵀF.
   type, extends(linear_potential_t) :: force_t
   end type force_t

   !> U(γ) = -x·γ with γ = R(q)ᵀF(t).
   type, extends(moving_linear_t) :: moving_force_t
   end type moving_force_t

   !> Makes a force at a point.
   interface force_t
      module procedure new_force
   end interface force_t

   !> Makes a rotating force at a point.
   interface moving_force_t
      module procedure new_moving_force
   end interface moving_force_t

contains

   !> Makes the potential -x·R(q)ᵀF of a constant force at a point of the body.
   pure function new_force(body_point, force) result(effect)
      !> x, body axes, m; shape (3).
      real(wp), intent(in) :: body_point(3)
      !> F, space axes, N; shape (3).
      real(wp), intent(in) :: force(3)
      type(force_t) :: effect
      effect%name = 'force'
      effect%moment = body_point
      effect%direction = force
   end function new_force

   !> Makes the potential of a force with rotating direction at a point of the body.
   function new_moving_force(body_point, force) result(effect)
      !> x, body axes, m; shape (3).
      real(wp), intent(in) :: body_point(3)
      !> F, in the space axes of the scene, N.
      type(lvlh_vector_t), intent(in) :: force
      type(moving_force_t) :: effect
      call effect%set_up('force', body_point, force)
   end function new_moving_force

end module nutate_force
