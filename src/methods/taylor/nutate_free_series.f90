!> Power series of free bodies of diagonal inertia without rotors, by Euler's equations in Ω: four products, where L and
!> the rows have 24.
!>
!> `w = Ω·time_unit`; with `cᵢ = (Jⱼ - Jₖ)/Jᵢ`: `w₁' = c₁w₂w₃`, and so on. In a coefficient the products with the newest
!> coefficients come last: those before do not wait for them.
module nutate_free_series
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   use nutate_row_series, only: steepest_growth
   implicit none
   private

   public :: expand_free

contains

   !> A free body: w, and the angle θ about its momentum. With `u = L/|L|`, and u₀ its start, the attitude is
   !> `q₀∘exp(θu₀/2)∘m`, m the shortest rotation from u to u₀, and `θ' = (w·u₀ + w·u)/(1 + u·u₀)`, where w·u is
   !> constant.
   pure subroutine expand_free(order, c, inertia, axis, w, angle, converges)
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; moments over |L| and the unit of time; u₀; shape (3).
      real(wp), intent(in) :: c(3), inertia(3), axis(3)
      !> Coefficient 0 on entry, all on exit; shape (3, 0:highest_order).
      real(wp), intent(inout) :: w(3, 0:highest_order)
      !> θ, rad; shape (0:highest_order).
      real(wp), intent(out) :: angle(0:highest_order)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp) :: rate(0:highest_order), cosine(0:highest_order), w1, w2, w3, p1, p2, p3, p4, bound
      integer :: k, j
      w1 = w(1, 0)
      w2 = w(2, 0)
      w3 = w(3, 0)
      bound = steepest_growth
      angle(0) = 0.0_wp
      do k = 0, order
         converges = max(abs(w1), abs(w2), abs(w3)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         w(3, k) = w3
         if (k == order) exit
         cosine(k) = axis(1)*inertia(1)*w1 + axis(2)*inertia(2)*w2 + axis(3)*inertia(3)*w3
         rate(k) = axis(1)*w1 + axis(2)*w2 + axis(3)*w3
         p1 = 0.0_wp
         p2 = 0.0_wp
         p3 = 0.0_wp
         p4 = 0.0_wp
         do j = 1, k - 1
            p1 = p1 + w(2, j)*w(3, k - j)
            p2 = p2 + w(3, j)*w(1, k - j)
            p3 = p3 + w(1, j)*w(2, k - j)
            p4 = p4 + cosine(j)*rate(k - j)
         end do
         p1 = p1 + w(2, 0)*w3
         p2 = p2 + w(3, 0)*w1
         p3 = p3 + w(1, 0)*w2
         if (k > 0) then
            p1 = p1 + w2*w(3, 0)
            p2 = p2 + w3*w(1, 0)
            p3 = p3 + w1*w(2, 0)
            rate(k) = 0.5_wp*(rate(k) - (p4 + cosine(k)*rate(0)))
         end if
         angle(k + 1) = inverses(k + 1)*rate(k)
         w1 = inverses(k + 1)*(c(1)*p1)
         w2 = inverses(k + 1)*(c(2)*p2)
         w3 = inverses(k + 1)*(c(3)*p3)
      end do
   end subroutine expand_free

end module nutate_free_series
