!> Polynomials in Bernstein's form on [0, 1]: the coefficients bound the polynomial, and their changes of sign count its
!> roots from above, by an even number too many at most (Descartes' rule).
module nutate_bernstein
   use nutate_kinds, only: wp
   implicit none
   private

   public :: bernstein_t, through_five, value_at

   !> Highest degree.
   integer, parameter, public :: degree = 9

   !> Polynomial Σ c(j) binomial(n, j) xʲ(1-x)ⁿ⁻ʲ.
   type :: bernstein_t
      !> Degree n.
      integer :: degree = 0
      !> Coefficients; those beyond n have no meaning.
      real(wp) :: c(0:degree) = 0.0_wp
   contains
      !> Returns the number of changes of sign of the coefficients.
      procedure, non_overridable :: changes
      !> Returns a bound on the values in [0, 1].
      procedure, non_overridable :: greatest
      !> Computes the coefficients of the polynomial on both halves of [0, 1].
      procedure, non_overridable :: halve
      !> Returns a root of a polynomial whose values at the ends have different signs.
      procedure, non_overridable :: root
   end type bernstein_t

contains

   !> Returns the polynomial of least degree with values and derivatives at equal distances, the first at 0, the last at
   !> 1: by Newton's divided differences, each point twice.
   pure function through_five(values, slopes) result(polynomial)
      !> Up to five values and derivatives; shape (m).
      real(wp), intent(in) :: values(:), slopes(:)
      type(bernstein_t) :: polynomial
      real(wp) :: x(0:degree), table(0:degree)
      integer :: i, k, n
      n = 2*size(values) - 1
      do i = 0, n
         x(i) = real(i/2, wp)/real(size(values) - 1, wp)
         table(i) = values(1 + i/2)
      end do
      do k = 1, n
         do i = n, k, -1
            if (k == 1 .and. mod(i, 2) == 1) then
               table(i) = slopes(1 + i/2)
            else
               table(i) = (table(i) - table(i - 1))/(x(i) - x(i - k))
            end if
         end do
      end do
      polynomial%degree = 0
      polynomial%c(0) = table(n)
      do k = n - 1, 0, -1
         call multiply(polynomial, x(k))
         polynomial%c(0:polynomial%degree) = polynomial%c(0:polynomial%degree) + table(k)
      end do
   end function through_five

   !> Multiplies by x - place.
   pure subroutine multiply(polynomial, place)
      type(bernstein_t), intent(inout) :: polynomial
      real(wp), intent(in) :: place
      real(wp) :: before, c
      integer :: j, n
      n = polynomial%degree + 1
      before = 0.0_wp
      do j = 0, n
         c = 0.0_wp
         if (j < n) c = polynomial%c(j)
         polynomial%c(j) = (real(j, wp)*(1 - place)*before - real(n - j, wp)*place*c)/real(n, wp)
         before = c
      end do
      polynomial%degree = n
   end subroutine multiply

   !> Computes value and derivative (de Casteljau).
   pure subroutine value_at(polynomial, x, f, slope)
      type(bernstein_t), intent(in) :: polynomial
      real(wp), intent(in) :: x
      real(wp), intent(out) :: f, slope
      real(wp) :: c(0:degree)
      integer :: j, k
      c = polynomial%c
      slope = 0.0_wp
      do k = polynomial%degree, 1, -1
         if (k == 1) slope = polynomial%degree*(c(1) - c(0))
         do j = 0, k - 1
            c(j) = (1 - x)*c(j) + x*c(j + 1)
         end do
      end do
      f = c(0)
   end subroutine value_at

   pure integer function changes(self)
      class(bernstein_t), intent(in) :: self
      integer :: j
      logical :: above, is_above
      changes = 0
      above = self%c(0) > 0.0_wp
      do j = 1, self%degree
         if (.not. abs(self%c(j)) > 0.0_wp) cycle
         is_above = self%c(j) > 0.0_wp
         if (is_above .neqv. above) changes = changes + 1
         above = is_above
      end do
   end function changes

   pure real(wp) function greatest(self)
      class(bernstein_t), intent(in) :: self
      greatest = maxval(abs(self%c(0:self%degree)))
   end function greatest

   pure subroutine halve(self, left, right)
      class(bernstein_t), intent(in) :: self
      !> Polynomial on [0, ½] and on [½, 1].
      type(bernstein_t), intent(out) :: left, right
      integer :: j, k
      left%degree = self%degree
      right%degree = self%degree
      right%c = self%c
      do k = 0, self%degree
         left%c(k) = right%c(0)
         do j = 0, self%degree - k - 1
            right%c(j) = 0.5_wp*(right%c(j) + right%c(j + 1))
         end do
      end do
   end subroutine halve

   !> Returns a root by Newton's iteration in a bracket; 40 steps halve it to 1e-12 at worst.
   pure real(wp) function root(self)
      class(bernstein_t), intent(in) :: self
      real(wp) :: low, high, f, slope, next
      integer :: i
      low = 0.0_wp
      high = 1.0_wp
      root = 0.5_wp
      do i = 1, 40
         call value_at(self, root, f, slope)
         if ((f > 0.0_wp) .eqv. (self%c(0) > 0.0_wp)) then
            low = root
         else
            high = root
         end if
         next = 0.5_wp*(low + high)
         if (abs(slope)*(high - low) > abs(f)) next = root - f/slope
         if (.not. (next > low .and. next < high)) next = 0.5_wp*(low + high)
         if (abs(next - root) <= 1e-14_wp) return
         root = next
      end do
   end function root

end module nutate_bernstein
