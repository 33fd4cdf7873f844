!> Moves sensitivities by the matrices of a step (`nutate_step_tangent`): with y half of the gain of δL,
!>
!>     y = WδL0 + Pθ0,   δL1 = δL0 + 2y,   θ1 = θ0 + (Rh² - 1)θ0 + 4RhT(δL0 + y)/(1+ρ)
!>
!> Only the gains of δL and θ are rounded. Sensitivities are moved in pairs, for processors that multiply two numbers at
!> once; the result of one sensitivity does not depend on the other one.
module nutate_sensitivity_steps
   use nutate_kinds, only: wp
   implicit none
   private

   public :: move_pairs, rotate_sensitivities, set_product, set_products, add_products

contains

   !> Moves pairs of sensitivities.
   pure subroutine move_pairs(n, p, w, h, g, theta, momentum)
      !> Number of pairs.
      integer, intent(in) :: n
      !> Derivatives of y by θ0 and by δL0; Rh² - 1; 4RhT/(1+ρ).
      real(wp), intent(in) :: p(3, 3), w(3, 3), h(3, 3), g(3, 3)
      real(wp), intent(inout) :: theta(2, n, 3), momentum(2, n, 3)
      real(wp) :: x, y, z, a, b, c, u, v, t
      integer :: i, k
      do i = 1, n
         do k = 1, 2
            a = momentum(k, i, 1)
            b = momentum(k, i, 2)
            c = momentum(k, i, 3)
            x = theta(k, i, 1)
            y = theta(k, i, 2)
            z = theta(k, i, 3)
            u = (p(1, 1)*x + p(1, 2)*y + p(1, 3)*z) + (w(1, 1)*a + w(1, 2)*b + w(1, 3)*c)
            v = (p(2, 1)*x + p(2, 2)*y + p(2, 3)*z) + (w(2, 1)*a + w(2, 2)*b + w(2, 3)*c)
            t = (p(3, 1)*x + p(3, 2)*y + p(3, 3)*z) + (w(3, 1)*a + w(3, 2)*b + w(3, 3)*c)
            a = a + u
            b = b + v
            c = c + t
            momentum(k, i, 1) = a + u
            momentum(k, i, 2) = b + v
            momentum(k, i, 3) = c + t
            theta(k, i, 1) = x + ((h(1, 1)*x + h(1, 2)*y + h(1, 3)*z) + (g(1, 1)*a + g(1, 2)*b + g(1, 3)*c))
            theta(k, i, 2) = y + ((h(2, 1)*x + h(2, 2)*y + h(2, 3)*z) + (g(2, 1)*a + g(2, 2)*b + g(2, 3)*c))
            theta(k, i, 3) = z + ((h(3, 1)*x + h(3, 2)*y + h(3, 3)*z) + (g(3, 1)*a + g(3, 2)*b + g(3, 3)*c))
         end do
      end do
   end subroutine move_pairs

   !> Multiplies each sensitivity by a matrix, in place.
   pure subroutine rotate_sensitivities(m, n, sensitivities)
      real(wp), intent(in) :: m(3, 3)
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(inout) :: sensitivities(n, 3)
      real(wp) :: x, y, z
      integer :: i
      do i = 1, n
         x = sensitivities(i, 1)
         y = sensitivities(i, 2)
         z = sensitivities(i, 3)
         sensitivities(i, 1) = m(1, 1)*x + m(1, 2)*y + m(1, 3)*z
         sensitivities(i, 2) = m(2, 1)*x + m(2, 2)*y + m(2, 3)*z
         sensitivities(i, 3) = m(3, 1)*x + m(3, 2)*y + m(3, 3)*z
      end do
   end subroutine rotate_sensitivities

   !> Computes the product of a row with each sensitivity.
   pure subroutine set_product(n, row, sensitivities, products)
      integer, intent(in) :: n
      !> Shapes (3), (n,3), (n).
      real(wp), intent(in) :: row(3), sensitivities(n, 3)
      real(wp), intent(out) :: products(n)
      integer :: i
      do i = 1, n
         products(i) = row(1)*sensitivities(i, 1) + row(2)*sensitivities(i, 2) + row(3)*sensitivities(i, 3)
      end do
   end subroutine set_product

   !> Computes the sum of the products of two rows with each sensitivity.
   pure subroutine set_products(n, a, x, b, y, products)
      integer, intent(in) :: n
      !> Shapes (3), (n,3), (n).
      real(wp), intent(in) :: a(3), x(n, 3), b(3), y(n, 3)
      real(wp), intent(out) :: products(n)
      integer :: i
      do i = 1, n
         products(i) = (a(1)*x(i, 1) + a(2)*x(i, 2) + a(3)*x(i, 3)) + (b(1)*y(i, 1) + b(2)*y(i, 2) + b(3)*y(i, 3))
      end do
   end subroutine set_products

   !> Adds given products, and the product of another row with each sensitivity, in one sum.
   pure subroutine add_products(n, products, row, sensitivities, sums)
      integer, intent(in) :: n
      !> Shapes (n), (3), (n,3), (n).
      real(wp), intent(in) :: products(n), row(3), sensitivities(n, 3)
      real(wp), intent(inout) :: sums(n)
      integer :: i
      do i = 1, n
         sums(i) = sums(i) + (products(i) + (row(1)*sensitivities(i, 1) + row(2)*sensitivities(i, &
            2) + row(3)*sensitivities(i, 3)))
      end do
   end subroutine add_products

end module nutate_sensitivity_steps
