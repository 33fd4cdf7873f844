!> Potentials and torques that a FORTRAN 77 program computes in user-defined subroutines.
!>
!> Numbers that are not finite or exceed 1e100 are replaced by zero in the equations, and the failure is recorded.
module nutate_f77_callback
   use nutate_effect, only: potential_t, torque_t
   use nutate_f77_interfaces, only: f77_potential, f77_torque
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   implicit none
   private

   public :: failure_t, f77_call_t, f77_potential_t, f77_torque_t

   !> Subroutines and user data of a call. Effects point to them: steppers have copies of the effects.
   type :: f77_call_t
      procedure(f77_potential), pointer, nopass :: pot => null()
      procedure(f77_torque), pointer, nopass :: tor => null()
      integer, pointer, contiguous :: iuser(:) => null()
      real(wp), pointer, contiguous :: ruser(:) => null()
   end type f77_call_t

   !> Holds the flag that a failed callback sets to 1. The flag is not in the effects, which are constant in a step.
   type :: failure_t
      integer, pointer :: noted => null()
   end type failure_t

   !> Potential U(γ) of a program.
   type, extends(potential_t) :: f77_potential_t
      type(f77_call_t), pointer :: now => null()
      type(failure_t) :: failure
   contains
      procedure :: energy
      procedure :: gradient
   end type f77_potential_t

   !> Torque τ(t, q, Ω) of a program, Ω absolute.
   type, extends(torque_t) :: f77_torque_t
      type(f77_call_t), pointer :: now => null()
      type(failure_t) :: failure
   contains
      procedure :: torque
   end type f77_torque_t

contains

   pure real(wp) function energy(self, gamma)
      class(f77_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: slope(3)
      call self%now%pot(gamma, energy, slope, self%now%iuser, self%now%ruser)
      if (is_moderate(energy)) return
      call note(self%failure)
      energy = 0.0_wp
   end function energy

   pure function gradient(self, gamma)
      class(f77_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      real(wp) :: u
      call self%now%pot(gamma, u, gradient, self%now%iuser, self%now%ruser)
      if (all(is_moderate(gradient))) return
      call note(self%failure)
      gradient = 0.0_wp
   end function gradient

   pure function torque(self, t, q, omega) result(tau)
      class(f77_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      call self%now%tor(t, q, self%absolute_rate(q, omega), tau, self%now%iuser, self%now%ruser)
      if (all(is_moderate(tau))) return
      call note(self%failure)
      tau = 0.0_wp
   end function torque

   !> Records a failure, passed by value: a pure procedure may set the target of such a copy.
   pure subroutine note(failure)
      type(failure_t), value :: failure
      failure%noted = 1
   end subroutine note

end module nutate_f77_callback
