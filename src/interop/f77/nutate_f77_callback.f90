!> Potentials and torques that a FORTRAN 77 program computes in subroutines of its own.
!>
!> They are declared pure, since the effects of the library are: the library may call them as often as it likes, in any
!> order. Numbers that are not finite do not reach the equations: they are noted, and count as zero.
module nutate_f77_callback
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_effect, only: potential_t, torque_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: f77_potential, f77_torque, fault_t, f77_potential_t, f77_torque_t

   abstract interface
      !> POT: U(γ), J, and ∇U, body axes.
      pure subroutine f77_potential(gamma, u, du, iuser, ruser)
         import :: wp
         !> γ = R(q)ᵀn, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
         real(wp), intent(out) :: u, du(3)
         !> The program's own; shapes are its affair.
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine f77_potential

      !> TOR: τ(t, q, Ω), body axes, N m.
      pure subroutine f77_torque(t, q, omega, tau, iuser, ruser)
         import :: wp
         !> s.
         real(wp), intent(in) :: t
         !> Attitude, unit quaternion, body→space; shape (4).
         real(wp), intent(in) :: q(4)
         !> Ω, body axes, rad/s; shape (3).
         real(wp), intent(in) :: omega(3)
         real(wp), intent(out) :: tau(3)
         !> The program's own; shapes are its affair.
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine f77_torque
   end interface

   !> What a callback that goes wrong sets to 1; the effects are constant in a step, so that it lies outside of them.
   type :: fault_t
      integer, pointer :: raised => null()
   end type fault_t

   !> U(γ) of a program.
   type, extends(potential_t) :: f77_potential_t
      procedure(f77_potential), pointer, nopass :: ask => null()
      integer, pointer, contiguous :: iuser(:) => null()
      real(wp), pointer, contiguous :: ruser(:) => null()
      type(fault_t) :: fault
   contains
      procedure :: energy
      procedure :: gradient
   end type f77_potential_t

   !> τ(t, q, Ω) of a program.
   type, extends(torque_t) :: f77_torque_t
      procedure(f77_torque), pointer, nopass :: ask => null()
      integer, pointer, contiguous :: iuser(:) => null()
      real(wp), pointer, contiguous :: ruser(:) => null()
      type(fault_t) :: fault
   contains
      procedure :: torque
   end type f77_torque_t

contains

   pure real(wp) function energy(self, gamma)
      class(f77_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: slope(3)
      call self%ask(gamma, energy, slope, self%iuser, self%ruser)
      if (ieee_is_finite(energy)) return
      call raise(self%fault)
      energy = 0.0_wp
   end function energy

   pure function gradient(self, gamma)
      class(f77_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      real(wp) :: u
      call self%ask(gamma, u, gradient, self%iuser, self%ruser)
      if (all(ieee_is_finite(gradient))) return
      call raise(self%fault)
      gradient = 0.0_wp
   end function gradient

   pure function torque(self, t, q, omega) result(tau)
      class(f77_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      call self%ask(t, q, omega, tau, self%iuser, self%ruser)
      if (all(ieee_is_finite(tau))) return
      call raise(self%fault)
      tau = 0.0_wp
   end function torque

   !> Notes a number that is not finite. The flag is passed by value: a pure procedure may set what such a copy points
   !> to.
   pure subroutine raise(fault)
      type(fault_t), value :: fault
      fault%raised = 1
   end subroutine raise

end module nutate_f77_callback
