!> Products of vectors and quaternions of several bodies at once: one body a lane.
module nutate_lane_vectors
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: cross_lanes, find_full_rates, multiply_lanes, turn_back, write_momenta

contains

   !> a×b.
   pure subroutine cross_lanes(a, b, c)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: a(lanes, 3), b(lanes, 3)
      real(wp), intent(out) :: c(lanes, 3)
      integer :: i
      do i = 1, lanes
         c(i, 1) = a(i, 2)*b(i, 3) - a(i, 3)*b(i, 2)
         c(i, 2) = a(i, 3)*b(i, 1) - a(i, 1)*b(i, 3)
         c(i, 3) = a(i, 1)*b(i, 2) - a(i, 2)*b(i, 1)
      end do
   end subroutine cross_lanes

   !> ΔtJ⁻¹x, or J⁻¹x.
   pure subroutine find_full_rates(to_angle, x, w)
      !> Shapes (lanes, 3, 3) and (lanes, 3).
      real(wp), intent(in) :: to_angle(lanes, 3, 3), x(lanes, 3)
      real(wp), intent(out) :: w(lanes, 3)
      integer :: i
      do i = 1, lanes
         w(i, 1) = to_angle(i, 1, 1)*x(i, 1) + to_angle(i, 1, 2)*x(i, 2) + to_angle(i, 1, 3)*x(i, 3)
         w(i, 2) = to_angle(i, 2, 1)*x(i, 1) + to_angle(i, 2, 2)*x(i, 2) + to_angle(i, 2, 3)*x(i, 3)
         w(i, 3) = to_angle(i, 3, 1)*x(i, 1) + to_angle(i, 3, 2)*x(i, 2) + to_angle(i, 3, 3)*x(i, 3)
      end do
   end subroutine find_full_rates

   !> a∘b; shape (lanes, 4).
   pure subroutine multiply_lanes(a, b, product)
      real(wp), intent(in) :: a(lanes, 4), b(lanes, 4)
      real(wp), intent(out) :: product(lanes, 4)
      integer :: i
      do i = 1, lanes
         product(i, 1) = a(i, 1)*b(i, 1) - a(i, 2)*b(i, 2) - a(i, 3)*b(i, 3) - a(i, 4)*b(i, 4)
         product(i, 2) = a(i, 1)*b(i, 2) + a(i, 2)*b(i, 1) + a(i, 3)*b(i, 4) - a(i, 4)*b(i, 3)
         product(i, 3) = a(i, 1)*b(i, 3) - a(i, 2)*b(i, 4) + a(i, 3)*b(i, 1) + a(i, 4)*b(i, 2)
         product(i, 4) = a(i, 1)*b(i, 4) + a(i, 2)*b(i, 3) - a(i, 3)*b(i, 2) + a(i, 4)*b(i, 1)
      end do
   end subroutine multiply_lanes

   !> Rᵀl, or Rᵀn, of unit quaternions.
   pure subroutine turn_back(q, target, turned)
      !> Shapes (lanes, 4) and (lanes, 3).
      real(wp), intent(in) :: q(lanes, 4), target(lanes, 3)
      real(wp), intent(out) :: turned(lanes, 3)
      real(wp) :: r11, r22, r33, r12, r21, r13, r31, r23, r32
      integer :: i
      do i = 1, lanes
         r11 = 1 - 2*(q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4))
         r22 = 1 - 2*(q(i, 2)*q(i, 2) + q(i, 4)*q(i, 4))
         r33 = 1 - 2*(q(i, 2)*q(i, 2) + q(i, 3)*q(i, 3))
         r12 = 2*(q(i, 2)*q(i, 3) + q(i, 1)*q(i, 4))
         r21 = 2*(q(i, 2)*q(i, 3) - q(i, 1)*q(i, 4))
         r13 = 2*(q(i, 2)*q(i, 4) - q(i, 1)*q(i, 3))
         r31 = 2*(q(i, 2)*q(i, 4) + q(i, 1)*q(i, 3))
         r23 = 2*(q(i, 3)*q(i, 4) + q(i, 1)*q(i, 2))
         r32 = 2*(q(i, 3)*q(i, 4) - q(i, 1)*q(i, 2))
         turned(i, 1) = r11*target(i, 1) + r12*target(i, 2) + r13*target(i, 3)
         turned(i, 2) = r21*target(i, 1) + r22*target(i, 2) + r23*target(i, 3)
         turned(i, 3) = r31*target(i, 1) + r32*target(i, 2) + r33*target(i, 3)
      end do
   end subroutine turn_back

   !> p = 2 q∘[0, L].
   pure subroutine write_momenta(q, momentum, p)
      !> L, body axes; shape (lanes, 3).
      real(wp), intent(in) :: q(lanes, 4), momentum(lanes, 3)
      real(wp), intent(out) :: p(lanes, 4)
      real(wp) :: l1, l2, l3
      integer :: i
      do i = 1, lanes
         l1 = 2*momentum(i, 1)
         l2 = 2*momentum(i, 2)
         l3 = 2*momentum(i, 3)
         p(i, 1) = -(q(i, 2)*l1 + q(i, 3)*l2 + q(i, 4)*l3)
         p(i, 2) = q(i, 1)*l1 + q(i, 3)*l3 - q(i, 4)*l2
         p(i, 3) = q(i, 1)*l2 + q(i, 4)*l1 - q(i, 2)*l3
         p(i, 4) = q(i, 1)*l3 + q(i, 2)*l2 - q(i, 3)*l1
      end do
   end subroutine write_momenta

end module nutate_lane_vectors
