!> The subroutines that a FORTRAN 77 program can supply.
!>
!> They are declared pure, since the effects of the library are: the library may call them any number of times, in any
!> order. This module uses no module that uses the IEEE modules: gfortran would save the state of the processor in every
!> procedure that names the interfaces, NUSTEP among them.
module nutate_f77_interfaces
   use nutate_kinds, only: wp
   implicit none
   private

   public :: f77_potential, f77_torque

   abstract interface
      !> POT computes U(γ), J, and ∇U, body axes.
      pure subroutine f77_potential(gamma, u, du, iuser, ruser)
         import :: wp
         !> γ = R(q)ᵀn, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
         real(wp), intent(out) :: u, du(3)
         !> User data of the program, of any shape.
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine f77_potential

      !> TOR computes τ(t, q, Ω), body axes, N m.
      pure subroutine f77_torque(t, q, omega, tau, iuser, ruser)
         import :: wp
         !> Time, s.
         real(wp), intent(in) :: t
         !> Attitude, unit quaternion, body→space; shape (4).
         real(wp), intent(in) :: q(4)
         !> Absolute Ω, body axes, rad/s; shape (3).
         real(wp), intent(in) :: omega(3)
         real(wp), intent(out) :: tau(3)
         !> User data of the program, of any shape.
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine f77_torque
   end interface

end module nutate_f77_interfaces
