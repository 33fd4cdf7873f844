! Exact solutions for FORTRAN 77: external subroutines, see nutate_f77_steps.f90 for what they have in common.

!> NUFREE computes the exact motion of a torque-free body at N times, by elliptic functions.
subroutine nufree(aj, q0, omega0, n, t, q, omega, info)
   use nutate_exact_free, only: free_body_t
   use nutate_f77_check, only: check_setup, is_attitude, is_motion
   use nutate_f77_work, only: setup_t
   use nutate_hamiltonian, only: make_state, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_status, only: status_t
   implicit none
   !> (input) Inertia tensor about the fixed point, body axes, kg m²; dimension (3,3).
   real(wp), intent(in) :: aj(3, 3)
   !> (input) Attitude at time 0, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q0(4)
   !> (input) Angular velocity at time 0, body axes, rad/s; dimension (3).
   real(wp), intent(in) :: omega0(3)
   !> (input) Number of times, N >= 0.
   integer, intent(in) :: n
   !> (input) Times, s, in any order; dimension (N).
   real(wp), intent(in) :: t(*)
   !> (output) Attitudes; dimension (4,N).
   real(wp), intent(inout) :: q(4, *)
   !> (output) Angular velocities, body axes, rad/s; dimension (3,N).
   real(wp), intent(inout) :: omega(3, *)
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(setup_t) :: setup
   type(system_t) :: system
   type(free_body_t) :: solution
   type(status_t) :: status
   real(wp) :: momentum(3)
   integer :: i
   call check_setup(setup, aj, 0.0_wp, info)
   info = -info
   if (info /= 0) return
   system%body = setup%body
   if (.not. is_attitude(q0)) then
      info = -2
   else if (.not. all(is_moderate(omega0))) then
      info = -3
   else if (.not. is_motion(system, make_state(system, q0, omega0))) then
      info = -3
   else if (n < 0) then
      info = -4
   else if (.not. all(is_moderate(t(1:n)))) then
      info = -5
   end if
   if (info /= 0) return
   associate (body => setup%body)
      call solution%prepare(body%moments, q0, matmul(body%inertia, omega0), status, body%axes)
      info = status%code
      if (info /= 0) return
      do i = 1, n
         call solution%evaluate(t(i), q(:, i), momentum)
         omega(:, i) = matmul(body%inverse_inertia, momentum)
      end do
   end associate
end subroutine nufree
