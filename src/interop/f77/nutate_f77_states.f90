! States and invariants for FORTRAN 77: external subroutines, see nutate_f77_steps.f90 for what they have in common.

!> NUSETP converts an angular velocity to the conjugate momentum that NUSTEP uses.
subroutine nusetp(q, omega, p, work, lwork, info)
   use nutate_f77_prepared, only: f77_body_t, find_body, let_go
   use nutate_f77_check, only: is_attitude, is_motion, work_fault
   use nutate_hamiltonian, only: make_state
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_state, only: state_t
   implicit none
   !> (input) Attitude, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q(4)
   !> (input) Angular velocity, body axes, rad/s; dimension (3).
   real(wp), intent(in) :: omega(3)
   !> (output) Conjugate momentum, kg m²/s; dimension (4).
   real(wp), intent(inout) :: p(4)
   !> (input) From NUINIT; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(f77_body_t), pointer :: body
   type(state_t) :: state
   info = 0
   if (.not. is_attitude(q)) then
      info = -1
   else if (.not. all(is_moderate(omega))) then
      info = -2
   else
      info = work_fault(work, lwork, 4)
   end if
   if (info /= 0) return
   body => find_body(work)
   state = make_state(body%system, q, omega)
   if (is_motion(body%system, state)) then
      p = state%p
   else
      info = -2
   end if
   call let_go(body)
end subroutine nusetp

!> NUOMEG converts a conjugate momentum to the angular velocity.
subroutine nuomeg(q, p, omega, work, lwork, info)
   use nutate_f77_prepared, only: f77_body_t, find_body, let_go
   use nutate_f77_check, only: is_attitude, work_fault
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_state, only: state_t
   implicit none
   !> (input) Attitude, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q(4)
   !> (input) Conjugate momentum, kg m²/s; dimension (4).
   real(wp), intent(in) :: p(4)
   !> (output) Angular velocity, body axes, rad/s; dimension (3).
   real(wp), intent(inout) :: omega(3)
   !> (input) From NUINIT; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(f77_body_t), pointer :: body
   info = 0
   if (.not. is_attitude(q)) then
      info = -1
   else if (.not. all(is_moderate(p))) then
      info = -2
   else
      info = work_fault(work, lwork, 4)
   end if
   if (info /= 0) return
   body => find_body(work)
   omega = angular_velocity(body%system, state_t(q=q, p=p))
   call let_go(body)
end subroutine nuomeg

!> NUINV computes energy, angular momentum and the constraints.
subroutine nuinv(q, p, pot, iuser, ruser, e, al, c, work, lwork, info)
   use nutate_f77_interfaces, only: f77_potential
   use nutate_f77_prepared, only: f77_body_t, find_body, let_go
   use nutate_f77_check, only: is_attitude, work_fault
   use nutate_f77_stepping, only: find_invariants
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_state, only: state_t
   implicit none
   !> (input) Attitude, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q(4)
   !> (input) Conjugate momentum, kg m²/s; dimension (4).
   real(wp), intent(in) :: p(4)
   !> (input) As for NUSTEP.
   procedure(f77_potential) :: pot
   !> (input) User data, passed to POT; any dimension.
   integer, intent(in) :: iuser(*)
   !> (input) User data, passed to POT; any dimension.
   real(wp), intent(in) :: ruser(*)
   !> (output) Kinetic, potential and total energy, J; dimension (3).
   real(wp), intent(inout) :: e(3)
   !> (output) Angular momentum in body axes (first column) and in space axes (second), N m s; dimension (3,2).
   real(wp), intent(inout) :: al(3, 2)
   !> (output) |Q| and Q·P, 1 and 0 kg m²/s in the exact motion; dimension (2).
   real(wp), intent(inout) :: c(2)
   !> (input) From NUINIT; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong; 4: POT returned a number that is not finite.
   integer, intent(out) :: info
   type(f77_body_t), pointer :: body
   info = 0
   if (.not. is_attitude(q)) then
      info = -1
   else if (.not. all(is_moderate(p))) then
      info = -2
   else
      info = work_fault(work, lwork, 9)
   end if
   if (info /= 0) return
   body => find_body(work)
   call body%set_potential(pot, iuser, ruser)
   call find_invariants(body, state_t(q=q, p=p), e, al, c, info)
   call let_go(body)
end subroutine nuinv
