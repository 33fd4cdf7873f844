!> Power series in time as arrays of coefficients, for the Taylor method and the series of the effects.
!>
!> A series is `x(s) = Σ xₖ sᵏ`, `s = (t - t₀)/time_unit`; its coefficients stand in an array from index 0. Coefficient
!> k of a result needs the coefficients 0..k of the operands only, so that series can be continued one coefficient at a
!> time.
module nutate_power_series
   use nutate_kinds, only: wp
   implicit none
   private

   public :: fixed_step_order, highest_order, inverses, least_order, product_term, power_term, cosine_term
   public :: series_group_t

   !> Longest series: coefficients 0 to this. A tolerance at round-off requires about 24, a user may request some more.
   integer, parameter :: highest_order = 28
   !> Lowest order of a method: the last two terms, which choose the step, must lie beyond the first three, which give
   !> its scale.
   integer, parameter :: least_order = 4
   !> Default order of fixed steps: that of a tolerance of 1e-8, from where on the series pays.
   integer, parameter :: fixed_step_order = 16

   !> 1, 2, ...; shape (29).
   integer, parameter :: numbers(highest_order + 1) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, &
                                                       19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29]
   !> 1/k; shape (29).
   real(wp), parameter :: inverses(highest_order + 1) = 1.0_wp/numbers

   !> Several series.
   type :: series_group_t
      !> Coefficients; shape (0:highest_order, number of series).
      real(wp), allocatable :: values(:, :)
   end type series_group_t

contains

   !> Returns coefficient k of the product of two series: Σ aⱼ bₖ₋ⱼ.
   pure real(wp) function product_term(k, a, b) result(term)
      integer, intent(in) :: k
      !> Coefficients 0..k.
      real(wp), intent(in) :: a(0:k), b(0:k)
      integer :: j
      term = 0.0_wp
      do j = 0, k
         term = term + a(j)*b(k - j)
      end do
   end function product_term

   !> Returns coefficient k of u^α, k > 0, from u and the coefficients before: k u₀ pₖ = Σ (αj - k + j) uⱼ pₖ₋ⱼ, j =
   !> 1..k (L. Euler; D. Knuth, The Art of Computer Programming 2, 4.7).
   pure real(wp) function power_term(k, exponent, base, power) result(term)
      integer, intent(in) :: k
      !> α.
      real(wp), intent(in) :: exponent
      !> u, coefficients 0..k, u₀ not zero.
      real(wp), intent(in) :: base(0:k)
      !> u^α, coefficients 0..k-1.
      real(wp), intent(in) :: power(0:k - 1)
      integer :: j
      term = 0.0_wp
      do j = 1, k
         term = term + ((exponent + 1)*j - k)*base(j)*power(k - j)
      end do
      term = term*inverses(k)/base(0)
   end function power_term

   !> Returns coefficient k of cos(phase + rate s): rateᵏ cos(phase + kπ/2)/k!, from the one before the last.
   pure real(wp) function cosine_term(k, phase, rate, cosine) result(term)
      integer, intent(in) :: k
      !> rad, and rad per unit of time.
      real(wp), intent(in) :: phase, rate
      !> Coefficients 0..k-1.
      real(wp), intent(in) :: cosine(0:max(k - 1, 0))
      select case (k)
      case (0)
         term = cos(phase)
      case (1)
         term = -rate*sin(phase)
      case default
         term = -rate*rate*cosine(k - 2)*inverses(k)*inverses(k - 1)
      end select
   end function cosine_term

end module nutate_power_series
