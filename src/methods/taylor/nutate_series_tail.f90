!> Remainder of a power series, from its last coefficients.
!>
!> All components of a motion have their singularities at the same complex times, so that far coefficients of all of
!> them follow one recurrence, that of the nearest pair of poles: `xₖ + αxₖ₋₁ + βxₖ₋₂ ≈ 0`. α and β that fit the last
!> coefficient best give the sum of all that would come after it, as a rational function:
!>
!>     Σₖ₎ₙ xₖsᵏ ≈ -sⁿ⁺¹ ((α + βs)xₙ + βxₙ₋₁)/(1 + αs + βs²)
!>
!> The error of the sum follows from how well the recurrence, fitted to the coefficient before, predicts the last one.
!>
!> **Energies** are products of two components, and have double poles where these have simple ones. The coefficients of
!> an energy follow the recurrence of the square, `(1 + αs + βs²)² = Σ cⱼsʲ`: `Σ cⱼxₖ₋ⱼ ≈ 0`. With that of the
!> components the tail of a work is wrong by a tenth, and so would be the energy to which a state is projected.
module nutate_series_tail
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   use nutate_series_sum, only: sum_series
   implicit none
   private

   public :: series_tail_t, add_products, most_parts, largest_part
   public :: least_denominator, largest_rest, same_direction, least, largest

   !> Largest number of components of a coefficient whose products are computed here: L and an angle, or Ω.
   integer, parameter :: most_parts = 4
   !> Least of `1 + αs + βs²` from the start to the end of a step: a pole nearer to it would spoil states inside.
   real(wp), parameter :: least_denominator = 0.3_wp
   !> Largest part of the last coefficient that a recurrence may leave unexplained.
   real(wp), parameter :: largest_rest = 0.5_wp
   !> Factor from the rest of the last coefficient to that of the sum, which all later coefficients and a denominator
   !> below 1 increase: 2.6 was observed for the box.
   real(wp), parameter :: margin = 3.0_wp
   !> Part of a square below which products of coefficients are rounding; square of the sine between two vectors below
   !> which only one of them is used; range of squares whose products are representable.
   real(wp), parameter :: rounding = 1e-14_wp, same_direction = 1e-10_wp, least = 1e-140_wp, largest = 1e140_wp

   !> Largest component of a coefficient whose square is representable.
   real(wp), parameter :: largest_part = 1e150_wp

   !> The recurrence of a series, in units of time.
   type :: series_tail_t
      !> |xₙ₋₁|², |xₙ|².
      real(wp) :: squares(2) = 0.0_wp
      real(wp), private :: alpha = 0.0_wp, beta = 0.0_wp
      !> Square of the rest that the recurrence left of the last coefficient when fitted to the one before, with a
      !> margin.
      real(wp) :: rest = 0.0_wp
      !> Largest time from the start up to which no pole is near; 0 if there is no recurrence.
      real(wp) :: limit = 0.0_wp
      !> True if the recurrence is used in the present step.
      logical, private :: used = .false.
   contains
      !> Fit the recurrence, to coefficients or by their products.
      procedure :: fit
      procedure :: fit_products
      !> Sets the tail to zero: the sums are exact.
      procedure :: leave
      !> Decides whether the tail is used in a step.
      procedure :: use_in_step
      !> Returns the weights of the last two coefficients in the tail.
      procedure :: weights
      procedure, private :: energy_weights
      procedure, private :: of_square
      !> Return the possible error of the sum of all components, and of one series.
      procedure :: error_of_all
      procedure :: error_of
      !> Sums series of energies.
      procedure :: sum_energies
   end type series_tail_t

contains

   !> Fits the recurrence to the last four coefficients.
   pure subroutine fit(self, n, x)
      class(series_tail_t), intent(inout) :: self
      !> Components of a coefficient, and coefficients, the last one first; shape (most_parts, 4).
      integer, intent(in) :: n
      real(wp), intent(in) :: x(most_parts, 4)
      real(wp) :: squares(4), next(3), second(2), largest
      squares = 0.0_wp
      next = 0.0_wp
      second = 0.0_wp
      largest = 0.0_wp
      call add_products(n, x, squares, next, second, largest)
      call self%fit_products(squares, next, second, largest)
   end subroutine fit

   !> Adds the scalar products of further components of the last four coefficients.
   pure subroutine add_products(n, x, squares, next, second, largest)
      !> Components of a coefficient, and coefficients, the last one first; shape (most_parts, 4).
      integer, intent(in) :: n
      real(wp), intent(in) :: x(most_parts, 4)
      !> Products as in `fit_products`; largest component.
      real(wp), intent(inout) :: squares(4), next(3), second(2), largest
      integer :: i
      largest = max(largest, maxval(abs(x(1:n, :))))
      if (.not. largest < largest_part) return
      do i = 1, n
         squares = squares + x(i, :)*x(i, :)
         next = next + x(i, 1:3)*x(i, 2:4)
         second = second + x(i, 1:2)*x(i, 3:4)
      end do
   end subroutine add_products

   !> Fits the recurrence by the scalar products of the last four coefficients.
   pure subroutine fit_products(self, s, next, second, largest_component)
      class(series_tail_t), intent(inout) :: self
      !> Products of the last coefficient, and of those before, with itself, the one before and the second before.
      real(wp), intent(in) :: s(4), next(3), second(2)
      !> Largest component of all; from `largest_part` on the products are not used.
      real(wp), intent(in) :: largest_component
      real(wp) :: alpha, beta
      self%used = .false.
      self%limit = 0.0_wp
      self%squares = largest_part**2
      if (.not. largest_component < largest_part) return
      self%squares = [s(2), s(1)]
      if (.not. (minval(s) > least .and. maxval(s) < largest)) return
      call solve(s(3), s(4), next(3), next(2), second(2), alpha, beta)
      self%rest = s(1) + alpha*(alpha*s(2) + 2*next(1)) + beta*(beta*s(3) + 2*second(1)) + 2*alpha*beta*next(2)
      if (.not. self%rest < largest_rest**2*s(1)) return
      self%rest = margin**2*max(rounding*s(1), self%rest)
      call solve(s(2), s(3), next(2), next(1), second(1), self%alpha, self%beta)
      self%limit = limit_of(self%alpha, self%beta)
   end subroutine fit_products

   !> Sets the tail to zero.
   pure subroutine leave(self)
      class(series_tail_t), intent(inout) :: self
      self%squares = 0.0_wp
      self%limit = 0.0_wp
      self%used = .false.
   end subroutine leave

   !> Computes the α and β that minimise |x₀ + αx₁ + βx₂|².
   pure subroutine solve(s1, s2, c12, c1, c2, alpha, beta)
      !> |x₁|², |x₂|², x₁·x₂, x₀·x₁, x₀·x₂.
      real(wp), intent(in) :: s1, s2, c12, c1, c2
      real(wp), intent(out) :: alpha, beta
      real(wp) :: area, inverse
      area = s1*s2 - c12*c12
      if (area > same_direction*(s1*s2)) then
         inverse = 1/area
         alpha = inverse*(c12*c2 - s2*c1)
         beta = inverse*(c12*c1 - s1*c2)
      else
         alpha = -c1/s1
         beta = 0.0_wp
      end if
   end subroutine solve

   !> Returns the first root of `1 + αs + βs² = least_denominator`.
   pure real(wp) function limit_of(alpha, beta) result(limit)
      real(wp), intent(in) :: alpha, beta
      real(wp) :: square
      limit = huge(1.0_wp)
      square = alpha*alpha - 4*beta*(1 - least_denominator)
      if (square < 0.0_wp .or. (alpha >= 0.0_wp .and. beta >= 0.0_wp)) return
      limit = 2*(1 - least_denominator)/(sqrt(square) - alpha)
   end function limit_of

   !> Decides whether the sum is used in a step: at all times of it, or at none.
   pure subroutine use_in_step(self, s)
      class(series_tail_t), intent(inout) :: self
      !> End of the step, in units of time.
      real(wp), intent(in) :: s
      self%used = s <= self%limit
   end subroutine use_in_step

   !> Computes the weights of the tail: the sum of all terms after coefficient n is `last` times it plus `before` times
   !> the one before.
   pure subroutine weights(self, order, s, last, before)
      class(series_tail_t), intent(in) :: self
      !> n.
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      real(wp), intent(out) :: last, before
      real(wp) :: power
      last = 0.0_wp
      before = 0.0_wp
      if (.not. self%used) return
      power = -power_of(s, order + 1)/(1 + s*(self%alpha + s*self%beta))
      last = power*(self%alpha + s*self%beta)
      before = power*self%beta
   end subroutine weights

   !> Computes the weights of the last four coefficients of an energy, the last one first, in the sum of all terms after
   !> coefficient n; shape (4).
   pure subroutine energy_weights(self, order, s, w)
      class(series_tail_t), intent(in) :: self
      !> n, at least 4.
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      real(wp), intent(out) :: w(4)
      real(wp) :: c(4), power, root
      w = 0.0_wp
      if (.not. self%used) return
      c = self%of_square()
      root = 1 + s*(self%alpha + s*self%beta)
      power = -power_of(s, order + 1)/(root*root)
      w(4) = power*c(4)
      w(3) = power*(c(3) + s*c(4))
      w(2) = power*(c(2) + s*(c(3) + s*c(4)))
      w(1) = power*(c(1) + s*(c(2) + s*(c(3) + s*c(4))))
   end subroutine energy_weights

   !> Returns the possible error of the sum of all components, |Σ|: what the recurrence leaves, or the larger of the
   !> last two terms.
   pure real(wp) function error_of_all(self, order, s) result(error)
      class(series_tail_t), intent(in) :: self
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      if (self%used) then
         error = sqrt(self%rest)*power_of(s, order)
      else
         error = max(sqrt(self%squares(2))*s, sqrt(self%squares(1)))*power_of(s, order - 1)
      end if
   end function error_of_all

   !> Returns the possible error of the sum of one series, from its own coefficients.
   pure real(wp) function error_of(self, order, s, x) result(error)
      class(series_tail_t), intent(in) :: self
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      !> The last coefficients, the last one first; shape (4).
      real(wp), intent(in) :: x(4)
      if (self%used) then
         error = margin*max(abs(x(1) + (self%alpha*x(2) + self%beta*x(3)))*s, &
                            abs(x(2) + (self%alpha*x(3) + self%beta*x(4))))*power_of(s, order - 1)
      else
         error = max(abs(x(1))*s, abs(x(2)))*power_of(s, order - 1)
      end if
   end function error_of

   !> Sums four series of energies from k = 1 on, with their tails, and estimates the error of each sum.
   pure subroutine sum_energies(self, order, s, x, sums, errors)
      class(series_tail_t), intent(in) :: self
      !> Highest coefficient.
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      !> Coefficients; shape (4, 0:highest_order).
      real(wp), intent(in) :: x(4, 0:highest_order)
      real(wp), intent(out) :: sums(4), errors(4)
      real(wp) :: last(4, 6), c(4), w(4), power
      integer :: k
      last = 0.0_wp
      do k = 1, min(6, order)
         last(:, k) = x(:, order + 1 - k)
      end do
      call self%energy_weights(order, s, w)
      call sum_series(order, s, x, w(1:2), sums)
      sums = sums + (w(3)*last(:, 3) + w(4)*last(:, 4))
      power = power_of(s, order - 1)
      if (self%used) then
         c = self%of_square()
         errors = (margin*power)*max( &
                  abs(last(:, 1) + (c(1)*last(:, 2) + c(2)*last(:, 3) + c(3)*last(:, 4) + c(4)*last(:, 5)))*s, &
                  abs(last(:, 2) + (c(1)*last(:, 3) + c(2)*last(:, 4) + c(3)*last(:, 5) + c(4)*last(:, 6))))
      else
         errors = power*max(abs(last(:, 1))*s, abs(last(:, 2)))
      end if
   end subroutine sum_energies

   !> Returns c₁ to c₄ of (1 + αs + βs²)²; shape (4).
   pure function of_square(self) result(c)
      class(series_tail_t), intent(in) :: self
      real(wp) :: c(4)
      associate (alpha => self%alpha, beta => self%beta)
         c = [2*alpha, alpha*alpha + 2*beta, 2*alpha*beta, beta*beta]
      end associate
   end function of_square

   !> Returns sⁿ, bitwise identical with every compiler.
   pure real(wp) function power_of(s, n) result(power)
      real(wp), intent(in) :: s
      !> Positive.
      integer, intent(in) :: n
      real(wp) :: square
      integer :: k
      power = s
      square = s
      k = n - 1
      do while (k > 0)
         if (mod(k, 2) == 1) power = power*square
         square = square*square
         k = k/2
      end do
   end function power_of

end module nutate_series_tail
