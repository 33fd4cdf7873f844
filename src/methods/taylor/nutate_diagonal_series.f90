!> Power series of bodies of diagonal inertia without rotors, by Euler's equations in Ω: the free body and the top.
!>
!> `w = Ω·time_unit`; with `cᵢ = (Jⱼ - Jₖ)/Jᵢ`: `w₁' = c₁w₂w₃`, and so on. In a coefficient the products with the newest
!> coefficients come last: those before do not wait for them.
module nutate_diagonal_series
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   implicit none
   private

   public :: expand_free, expand_top, expand_axial_top, steepest_growth

   !> Coefficients of Ω that grow faster than this to the power of their index belong to a unit of time far longer than
   !> any step; up to there products of two at the highest order stay below 1e224.
   real(wp), parameter :: steepest_growth = 1e4_wp

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

   !> A top: w and two rows E, the first of which is that of the potential, `w₁' = c₁w₂w₃ + (m₁×E)₁`, ...
   pure subroutine expand_top(order, c, moments, w, rows, converges)
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; shape (3).
      real(wp), intent(in) :: c(3)
      !> The potential's moment times time_unit²/Jᵢ in column i; shape (3,3).
      real(wp), intent(in) :: moments(3, 3)
      !> Coefficient 0 on entry, all on exit; shapes (3, 0:highest_order) and (2, 3, 0:highest_order).
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp), dimension(2) :: e1, e2, e3, s1, s2, s3
      real(wp) :: w1, w2, w3, p(3), bound
      integer :: k
      w1 = w(1, 0)
      w2 = w(2, 0)
      w3 = w(3, 0)
      e1 = rows(:, 1, 0)
      e2 = rows(:, 2, 0)
      e3 = rows(:, 3, 0)
      bound = steepest_growth
      do k = 0, order
         converges = max(abs(w1), abs(w2), abs(w3)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         w(3, k) = w3
         rows(:, 1, k) = e1
         rows(:, 2, k) = e2
         rows(:, 3, k) = e3
         if (k == order) exit
         call add_inner(k, w, rows, p, s1, s2, s3)
         s1 = s1 + (rows(:, 2, 0)*w3 - rows(:, 3, 0)*w2)
         s2 = s2 + (rows(:, 3, 0)*w1 - rows(:, 1, 0)*w3)
         s3 = s3 + (rows(:, 1, 0)*w2 - rows(:, 2, 0)*w1)
         p = p + [w(2, 0)*w3, w(3, 0)*w1, w(1, 0)*w2]
         if (k > 0) then
            s1 = s1 + (e2*w(3, 0) - e3*w(2, 0))
            s2 = s2 + (e3*w(1, 0) - e1*w(3, 0))
            s3 = s3 + (e1*w(2, 0) - e2*w(1, 0))
            p = p + [w2*w(3, 0), w3*w(1, 0), w1*w(2, 0)]
         end if
         w1 = inverses(k + 1)*(c(1)*p(1) + (moments(2, 1)*e3(1) - moments(3, 1)*e2(1)))
         w2 = inverses(k + 1)*(c(2)*p(2) + (moments(3, 2)*e1(1) - moments(1, 2)*e3(1)))
         w3 = inverses(k + 1)*(c(3)*p(3) + (moments(1, 3)*e2(1) - moments(2, 3)*e1(1)))
         e1 = inverses(k + 1)*s1
         e2 = inverses(k + 1)*s2
         e3 = inverses(k + 1)*s3
      end do
   end subroutine expand_top

   !> The products of coefficient k that do without the coefficients 0 and k: w₂w₃, ... and E×w.
   pure subroutine add_inner(k, w, rows, p, s1, s2, s3)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      real(wp), intent(out) :: p(3), s1(2), s2(2), s3(2)
      real(wp) :: p1, p2, p3
      integer :: j
      s1 = 0.0_wp
      s2 = 0.0_wp
      s3 = 0.0_wp
      p1 = 0.0_wp
      p2 = 0.0_wp
      p3 = 0.0_wp
      do j = 1, k - 1
         p1 = p1 + w(2, j)*w(3, k - j)
         p2 = p2 + w(3, j)*w(1, k - j)
         p3 = p3 + w(1, j)*w(2, k - j)
         s1 = s1 + (rows(:, 2, j)*w(3, k - j) - rows(:, 3, j)*w(2, k - j))
         s2 = s2 + (rows(:, 3, j)*w(1, k - j) - rows(:, 1, j)*w(3, k - j))
         s3 = s3 + (rows(:, 1, j)*w(2, k - j) - rows(:, 2, j)*w(1, k - j))
      end do
      p = [p1, p2, p3]
   end subroutine add_inner

   !> A symmetric top in the axial frame, components with the axis last: w = L/J₁·time_unit, of which the last component
   !> is constant, and two rows E, the first of which is that of the potential: w₁' = -gE₂, w₂' = gE₁, E' = E×w.
   pure subroutine expand_axial_top(order, g, w, rows, converges)
      integer, intent(in) :: order
      !> Moment of the potential along the axis, over J₁, times the square of the unit of time.
      real(wp), intent(in) :: g
      !> Coefficient 0 on entry, all on exit; shapes (3, 0:highest_order), (2, 3, 0:highest_order).
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp), dimension(2) :: e1, e2, e3, s1, s2, s3
      real(wp) :: w1, w2, w3, bound
      integer :: k, j
      w1 = w(1, 0)
      w2 = w(2, 0)
      w3 = w(3, 0)
      e1 = rows(:, 1, 0)
      e2 = rows(:, 2, 0)
      e3 = rows(:, 3, 0)
      bound = steepest_growth
      do k = 0, order
         converges = max(abs(w1), abs(w2)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         if (k > 0) w(3, k) = 0.0_wp
         rows(:, 1, k) = e1
         rows(:, 2, k) = e2
         rows(:, 3, k) = e3
         if (k == order) exit
         s1 = e2*w3
         s2 = -e1*w3
         s3 = 0.0_wp
         do j = 0, k
            s1 = s1 - rows(:, 3, j)*w(2, k - j)
            s2 = s2 + rows(:, 3, j)*w(1, k - j)
            s3 = s3 + (rows(:, 1, j)*w(2, k - j) - rows(:, 2, j)*w(1, k - j))
         end do
         w1 = -(g*inverses(k + 1))*e2(1)
         w2 = (g*inverses(k + 1))*e1(1)
         e1 = inverses(k + 1)*s1
         e2 = inverses(k + 1)*s2
         e3 = inverses(k + 1)*s3
      end do
   end subroutine expand_axial_top

end module nutate_diagonal_series
