!> The loop that programs with many bodies have: Runge-Kutta of order 4 with angular velocities in body axes, the torque
!> of the step in body axes, into which it is rotated if it comes in space axes, and quaternions normalised after the
!> step.
module bodies_loop
   use nutate_kinds, only: wp
   implicit none
   private

   public :: rk4_loop

contains

   !> Moves n bodies by a step.
   subroutine rk4_loop(n, dt, j, q, omega, torque, in_space)
      integer, intent(in) :: n
      !> Step, s; principal moments, kg m².
      real(wp), intent(in) :: dt, j(3)
      !> Attitudes; angular velocities, body axes, rad/s; torques, N m.
      real(wp), intent(inout) :: q(4, n), omega(3, n)
      real(wp), intent(in) :: torque(3, n)
      !> True if the torques are in space axes, false if in body axes.
      logical, intent(in) :: in_space
      real(wp) :: y(7), k1(7), k2(7), k3(7), k4(7), tau(3), c(3), inverse(3), a(3)
      integer :: i
      inverse = 1/j
      c = [(j(2) - j(3))*inverse(1), (j(3) - j(1))*inverse(2), (j(1) - j(2))*inverse(3)]
      do i = 1, n
         y(1:4) = q(:, i)
         y(5:7) = omega(:, i)
         if (in_space) then
            a = 2*[y(3)*torque(3, i) - y(4)*torque(2, i), y(4)*torque(1, i) - y(2)*torque(3, i), &
                   y(2)*torque(2, i) - y(3)*torque(1, i)]
            tau = inverse*(torque(:, i) - y(1)*a + &
                           [y(3)*a(3) - y(4)*a(2), y(4)*a(1) - y(2)*a(3), y(2)*a(2) - y(3)*a(1)])
         else
            tau = inverse*torque(:, i)
         end if
         call rates(y, k1)
         call rates(y + 0.5_wp*dt*k1, k2)
         call rates(y + 0.5_wp*dt*k2, k3)
         call rates(y + dt*k3, k4)
         y = y + (dt/6)*(k1 + 2*(k2 + k3) + k4)
         q(:, i) = y(1:4)/sqrt(y(1)**2 + y(2)**2 + y(3)**2 + y(4)**2)
         omega(:, i) = y(5:7)
      end do

   contains

      pure subroutine rates(y, d)
         real(wp), intent(in) :: y(7)
         real(wp), intent(out) :: d(7)
         d(1) = -0.5_wp*(y(2)*y(5) + y(3)*y(6) + y(4)*y(7))
         d(2) = 0.5_wp*(y(1)*y(5) + y(3)*y(7) - y(4)*y(6))
         d(3) = 0.5_wp*(y(1)*y(6) + y(4)*y(5) - y(2)*y(7))
         d(4) = 0.5_wp*(y(1)*y(7) + y(2)*y(6) - y(3)*y(5))
         d(5) = tau(1) + c(1)*(y(6)*y(7))
         d(6) = tau(2) + c(2)*(y(7)*y(5))
         d(7) = tau(3) + c(3)*(y(5)*y(6))
      end subroutine rates

   end subroutine rk4_loop

end module bodies_loop
