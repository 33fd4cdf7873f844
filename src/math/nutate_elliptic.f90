!> The complete elliptic integral of the first kind and Jacobi's elliptic functions.
!>
!> The parameter is the complementary one, m1 = 1 - m = k'²: next to the separatrix (m -> 1) nothing can be computed
!> from m, and next to m = 0 nothing is lost by 1 - m. All routines accept m1 from 0 to 1, both included; m1 > 1
!> (negative m) is admissible too.
module nutate_elliptic
   use nutate_kinds, only: wp, pi
   implicit none
   private

   public :: elliptic_k, jacobi

   !> Steps of the arithmetic-geometric mean at most: m1 = 1e-308 needs 13.
   integer, parameter :: most_means = 20
   !> Rest π - `pi` of the rounding of `pi`.
   real(wp), parameter :: pi_tail = 1.2246467991473532e-16_wp

contains

   !> Returns the complete integral of the first kind K(m) = ∫₀^{π/2} dφ / √(1 - m sin²φ).
   !>
   !> For m1 = 0, where K is infinite, the result is `huge`.
   pure real(wp) function elliptic_k(m1) result(k)
      !> 1 - m, >= 0.
      real(wp), intent(in) :: m1
      real(wp) :: a(0:most_means), b(0:most_means)
      integer :: n
      k = huge(1.0_wp)
      if (m1 <= 0) return
      call means(m1, a, b, n)
      k = pi/(2*a(n))
   end function elliptic_k

   !> Computes Jacobi's sn, cn and dn by the arithmetic-geometric mean.
   !>
   !> With aₙ, bₙ the means that start from 1 and √m1, Gauss's transformation leaves ∫ dφ / Δ, Δ² = a² cos²φ + b² sin²φ,
   !> unchanged from one pair to the next, which ends at φ = a u. Back from there, with κ = cot φ,
   !> κₙ = κₙ₊₁ Δₙ₊₁ / aₙ and Δₙ = aₙ (aₙ₊₁ κₙ₊₁² + bₙ) / (aₙ₊₁ κₙ₊₁² + aₙ): products and positive sums only, so that
   !> cn and dn keep their digits where they are exponentially small.
   pure subroutine jacobi(u, m1, sn, cn, dn)
      !> Argument; the error of the results grows like one rounding of `u`.
      real(wp), intent(in) :: u
      !> 1 - m, >= 0.
      real(wp), intent(in) :: m1
      real(wp), intent(out) :: sn, cn, dn
      real(wp) :: a(0:most_means), b(0:most_means), phi, half_periods, cot, delta, square
      integer :: i, n
      if (m1 <= 0) then
         call hyperbolic(u, sn, cn, dn)
         return
      end if
      call means(m1, a, b, n)
      phi = a(n)*u
      half_periods = anint(phi/pi)
      phi = (phi - half_periods*pi) - half_periods*pi_tail
      if (abs(phi) < 1.0e-9_wp*a(n)) then
         sn = phi/a(n)
         cn = 1
         dn = 1
      else
         cot = cos(phi)/sin(phi)
         delta = a(n)
         do i = n - 1, 0, -1
            square = a(i + 1)*cot**2
            cot = cot*(delta/a(i))
            delta = a(i)*((square + b(i))/(square + a(i)))
         end do
         sn = sign(1/sqrt(1 + cot**2), phi)
         cn = abs(cot*sn)
         dn = delta
      end if
      if (is_odd(half_periods)) then
         sn = -sn
         cn = -cn
      end if
   end subroutine jacobi

   !> Computes the limit m = 1: tanh and sech, without overflow for any u.
   pure subroutine hyperbolic(u, sn, cn, dn)
      real(wp), intent(in) :: u
      real(wp), intent(out) :: sn, cn, dn
      real(wp) :: e
      e = exp(-abs(u))
      sn = tanh(u)
      cn = 2*e/(1 + e**2)
      dn = cn
   end subroutine hyperbolic

   !> Computes the arithmetic-geometric means of 1 and √m1; `a(n)` is their common limit.
   pure subroutine means(m1, a, b, n)
      !> m1 > 0.
      real(wp), intent(in) :: m1
      real(wp), intent(out) :: a(0:most_means), b(0:most_means)
      integer, intent(out) :: n
      a(0) = 1
      b(0) = sqrt(m1)
      do n = 1, most_means
         a(n) = (a(n - 1) + b(n - 1))/2
         b(n) = sqrt(a(n - 1)*b(n - 1))
         ! The next difference is the square of this one: below round-off.
         if (abs(a(n - 1) - b(n - 1)) <= 1.0e-8_wp*a(n - 1)) return
      end do
      n = most_means
   end subroutine means

   !> Returns true if an integer is odd.
   pure logical function is_odd(n)
      real(wp), intent(in) :: n
      is_odd = abs(mod(n, 2.0_wp)) > 0.5_wp
   end function is_odd

end module nutate_elliptic
