!> Interpolation between vectors given at points of time: polynomials, one for each interval. Linear ones may jump where
!> two points have the same time; cubic ones are a spline (C. de Boor, A Practical Guide to Splines, 1978, IV), natural
!> at its ends or periodic, or, with derivatives, Hermite's; those of degree 5 have second derivatives too.
!>
!> In the interval k, from x(k-1) to x(k), the vector is c₀ + c₁s + c₂s² + ..., s = (x - x(k-1))/h, h its length: so
!> the size of the coefficients does not depend on the unit of time.
module nutate_piecewise
   use nutate_kinds, only: wp, eps
   use nutate_lapack, only: dptsv
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: piecewise_t, new_hermite, new_linear, new_spline
   public :: clamped_term, find_bounds, interval_around, interval_at, move_inside, next_point, taylor_term, value_at

   !> Least number of points of a periodic spline; its last point, which equals the first, is included.
   integer, parameter, public :: least_periodic = 4

   !> Distance by which a time at an end is moved into its interval, over the size of the times: beyond their rounding.
   real(wp), parameter :: inside = 4*eps

   !> A vector of three components as a function of time.
   type :: piecewise_t
      !> Number of intervals, and degree of the polynomials.
      integer :: n = 0, degree = 1
      !> Ends of the intervals, s, increasing; shape (0:n).
      real(wp), allocatable :: x(:)
      !> Coefficients cⱼ of each interval; shape (3, 0:degree, n).
      real(wp), allocatable :: c(:, :, :)
      !> Interval in which the j-th of n equal parts of the time range begins; shape (0:n).
      integer, allocatable, private :: starts(:)
      !> Number of equal parts in a second.
      real(wp), private :: density = 0.0_wp
   end type piecewise_t

contains

   !> Makes straight lines between the points; two points of the same time are a jump.
   pure function new_linear(times, values) result(curve)
      !> Times, s, not decreasing, the first below the last, no three alike; shape (any).
      real(wp), intent(in) :: times(:)
      !> Values at the times; shape (3, any).
      real(wp), intent(in) :: values(:, :)
      type(piecewise_t) :: curve
      integer :: i, n
      n = count(times(2:) > times(:size(times) - 1))
      curve%n = n
      curve%degree = 1
      allocate (curve%x(0:n), curve%c(3, 0:1, n))
      curve%x(0) = times(1)
      n = 0
      do i = 2, size(times)
         if (.not. times(i) > times(i - 1)) cycle
         n = n + 1
         curve%x(n) = times(i)
         curve%c(:, 0, n) = values(:, i - 1)
         curve%c(:, 1, n) = values(:, i) - values(:, i - 1)
      end do
      call prepare_search(curve)
   end function new_linear

   !> Makes a cubic spline through the points: natural, without curvature at its ends, or periodic.
   pure function new_spline(times, values, periodic) result(curve)
      !> Times, s, increasing; two at least, `least_periodic` for a periodic one. Shape (n).
      real(wp), intent(in) :: times(:)
      !> Values at the times; shape (3, n); of a periodic spline the last are the first.
      real(wp), intent(in) :: values(:, :)
      logical, intent(in) :: periodic
      type(piecewise_t) :: curve
      real(wp), allocatable :: curvature(:, :)
      real(wp) :: h, rise(3), m0(3), m1(3)
      integer :: k
      curve%n = size(times) - 1
      curve%degree = 3
      allocate (curve%x(0:curve%n), curve%c(3, 0:3, curve%n), curvature(0:curve%n, 3))
      curve%x(:) = times
      if (periodic) then
         call solve_periodic(times, values, curvature)
      else
         call solve_natural(times, values, curvature)
      end if
      do k = 1, curve%n
         h = times(k + 1) - times(k)
         rise = values(:, k + 1) - values(:, k)
         m0 = (h*curvature(k - 1, :))*h/6
         m1 = (h*curvature(k, :))*h/6
         curve%c(:, 0, k) = values(:, k)
         curve%c(:, 1, k) = rise - 2*m0 - m1
         curve%c(:, 2, k) = 3*m0
         curve%c(:, 3, k) = m1 - m0
      end do
      call prepare_search(curve)
   end function new_spline

   !> Computes Hermite's polynomials between points: of degree 3 from values and rates, of degree 5 from second
   !> derivatives too.
   pure function new_hermite(times, values, rates, second) result(curve)
      !> Times, s, increasing; two at least. Shape (n).
      real(wp), intent(in) :: times(:)
      !> Values, and their first and second derivatives with respect to time; shape (3, n).
      real(wp), intent(in) :: values(:, :), rates(:, :)
      real(wp), intent(in), optional :: second(:, :)
      type(piecewise_t) :: curve
      real(wp) :: h, d(3), m0(3), m1(3), a0(3), a1(3)
      integer :: k
      curve%n = size(times) - 1
      curve%degree = merge(5, 3, present(second))
      allocate (curve%x(0:curve%n), curve%c(3, 0:curve%degree, curve%n))
      curve%x(:) = times
      do k = 1, curve%n
         h = times(k + 1) - times(k)
         d = values(:, k + 1) - values(:, k)
         m0 = h*rates(:, k)
         m1 = h*rates(:, k + 1)
         curve%c(:, 0, k) = values(:, k)
         curve%c(:, 1, k) = m0
         if (present(second)) then
            a0 = 0.5_wp*(h*second(:, k))*h
            a1 = 0.5_wp*(h*second(:, k + 1))*h
            curve%c(:, 2, k) = a0
            curve%c(:, 3, k) = 10*d - 6*m0 - 4*m1 - 3*a0 + a1
            curve%c(:, 4, k) = -15*d + 8*m0 + 7*m1 + 3*a0 - 2*a1
            curve%c(:, 5, k) = 6*d - 3*(m0 + m1) - a0 + a1
         else
            curve%c(:, 2, k) = 3*d - 2*m0 - m1
            curve%c(:, 3, k) = m0 + m1 - 2*d
         end if
      end do
      call prepare_search(curve)
   end function new_hermite

   !> Computes the second derivatives of a natural spline at its points, from the continuity of the first: a definite
   !> tridiagonal system.
   pure subroutine solve_natural(times, values, curvature)
      real(wp), intent(in) :: times(:), values(:, :)
      !> Shape (0:size(times) - 1, 3).
      real(wp), intent(out) :: curvature(0:, :)
      real(wp), allocatable :: d(:), e(:), b(:, :)
      integer :: n, i, info
      curvature = 0.0_wp
      n = size(times) - 2
      if (n < 1) return
      allocate (d(n), e(n), b(n, 3))
      do i = 1, n
         d(i) = 2*(times(i + 2) - times(i))
         e(i) = times(i + 2) - times(i + 1)
         b(i, :) = bend(times(i:i + 2), values(:, i:i + 2))
      end do
      call dptsv(n, 3, d, e, b, n, info)
      curvature(1:n, :) = b
   end subroutine solve_natural

   !> Computes the second derivatives of a periodic spline at its points. The elements beside the diagonals are a matrix
   !> h wwᵀ, w = (1, 0, ..., 0, 1), which the formula of Sherman and Morrison removes from the definite tridiagonal
   !> rest.
   pure subroutine solve_periodic(times, values, curvature)
      real(wp), intent(in) :: times(:), values(:, :)
      !> Shape (0:size(times) - 1, 3).
      real(wp), intent(out) :: curvature(0:, :)
      real(wp), allocatable :: d(:), e(:), b(:, :)
      real(wp) :: last, share
      integer :: n, i, info
      n = size(times) - 1
      allocate (d(n), e(n), b(n, 4))
      last = times(n + 1) - times(n)
      do i = 1, n
         e(i) = times(i + 1) - times(i)
      end do
      d(1) = 2*e(1) + last
      b(1, 1:3) = bend([times(1) - last, times(1:2)], reshape([values(:, n), values(:, 1:2)], [3, 3]))
      do i = 2, n
         d(i) = 2*(e(i - 1) + e(i))
         b(i, 1:3) = bend(times(i - 1:i + 1), values(:, i - 1:i + 1))
      end do
      d(n) = d(n) - last
      b(:, 4) = 0.0_wp
      b([1, n], 4) = 1.0_wp
      call dptsv(n, 4, d, e, b, n, info)
      share = last/(1 + last*(b(1, 4) + b(n, 4)))
      do i = 1, 3
         curvature(0:n - 1, i) = b(:, i) - (share*(b(1, i) + b(n, i)))*b(:, 4)
      end do
      curvature(n, :) = curvature(0, :)
   end subroutine solve_periodic

   !> Returns 6 times the change of the mean slope from one interval to the next.
   pure function bend(times, values)
      !> Shapes (3), (3,3).
      real(wp), intent(in) :: times(3), values(3, 3)
      real(wp) :: bend(3)
      bend = 6*((values(:, 3) - values(:, 2))/(times(3) - times(2)) &
                - (values(:, 2) - values(:, 1))/(times(2) - times(1)))
   end function bend

   !> Finds the interval in which each of n equal parts of the time range begins. The interval of a time then follows
   !> immediately for evenly spaced points, and after a few bisections for others.
   pure subroutine prepare_search(self)
      type(piecewise_t), intent(inout) :: self
      integer :: j, k
      allocate (self%starts(0:self%n))
      self%density = self%n/(self%x(self%n) - self%x(0))
      k = 1
      do j = 0, self%n
         do while (k < self%n)
            if ((self%x(k) - self%x(0))*self%density > real(j, wp)) exit
            k = k + 1
         end do
         self%starts(j) = k
      end do
   end subroutine prepare_search

   !> Returns the interval of a time; the later one for a time between two, the nearest one outside of all.
   pure integer function interval_at(self, time) result(k)
      type(piecewise_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: time
      integer :: part, last, middle
      part = int(min(max((time - self%x(0))*self%density, 0.0_wp), real(self%n, wp)))
      ! One part earlier: if rounding puts the end of an interval on that of a part, the interval may begin there.
      k = self%starts(max(part - 1, 0))
      last = self%starts(min(part + 1, self%n))
      do while (k < last)
         middle = (k + last)/2
         if (time < self%x(middle)) then
            last = middle
         else
            k = middle + 1
         end if
      end do
   end function interval_at

   !> Computes the interval around a time, in which the vector is one polynomial, less the rounding of its ends.
   pure subroutine interval_around(self, moment, start, stop)
      type(piecewise_t), intent(in) :: self
      !> Time, and ends of the interval, s.
      real(wp), intent(in) :: moment
      real(wp), intent(out) :: start, stop
      integer :: k
      k = interval_at(self, moment)
      start = self%x(k - 1)
      stop = self%x(k)
      call move_inside(moment, start, stop)
   end subroutine interval_around

   !> Moves the ends of an interval inside by their rounding; onto a time in it, if nothing would be left.
   pure subroutine move_inside(moment, start, stop, terms)
      !> Time in the interval, and its ends, s.
      real(wp), intent(in) :: moment
      real(wp), intent(inout) :: start, stop
      !> Size of the times whose sums the ends are, s; default: none.
      real(wp), intent(in), optional :: terms
      real(wp) :: edge
      edge = max(abs(start), abs(stop))
      if (present(terms)) edge = max(edge, terms)
      edge = inside*edge
      if (stop - start > 2*edge) then
         start = start + edge
         stop = stop - edge
      else
         start = moment
         stop = moment
      end if
   end subroutine move_inside

   !> Returns the next end of an interval after a time, s; beyond all times if there is none.
   pure real(wp) function next_point(self, t, sense) result(next)
      type(piecewise_t), intent(in) :: self
      !> Time, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      integer :: k, way
      way = nint(sense)
      next = sense*huge(next)
      if (sense*(self%x(merge(self%n, 0, way > 0)) - t) <= 0.0_wp) return
      k = interval_at(self, t) - 1
      if (way < 0) k = k + 1
      do while (sense*(self%x(k) - t) <= 0.0_wp)
         k = k + way
      end do
      next = self%x(k)
   end function next_point

   !> Returns the vector at a time of an interval, by the polynomial of that interval.
   pure function value_at(self, k, time) result(value)
      type(piecewise_t), intent(in) :: self
      !> Interval.
      integer, intent(in) :: k
      !> Time, s.
      real(wp), intent(in) :: time
      real(wp) :: value(3)
      real(wp) :: s
      s = (time - self%x(k - 1))/(self%x(k) - self%x(k - 1))
      if (self%degree == 1) then
         value = self%c(:, 0, k) + s*self%c(:, 1, k)
      else if (self%degree > 3) then
         value = taylor_term(self, k, 0, time, 1.0_wp)
      else
         value = self%c(:, 0, k) + s*(self%c(:, 1, k) + s*(self%c(:, 2, k) + s*self%c(:, 3, k)))
      end if
   end function value_at

   !> Returns coefficient j of the power series about a time, in a unit of time: the j-th derivative times unitʲ/j!.
   pure function taylor_term(self, k, j, time, unit) result(term)
      type(piecewise_t), intent(in) :: self
      !> Interval, and index of the coefficient.
      integer, intent(in) :: k, j
      !> s
      real(wp), intent(in) :: time, unit
      real(wp) :: term(3)
      !> Binomial coefficients: of sⁱ by sʲ; column i.
      integer, parameter :: choose(0:5, 0:5) = reshape([1, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 2, 1, 0, 0, 0, &
                                                        1, 3, 3, 1, 0, 0, 1, 4, 6, 4, 1, 0, 1, 5, 10, 10, 5, 1], [6, 6])
      real(wp) :: h, s
      integer :: i
      term = 0.0_wp
      if (j > self%degree) return
      h = self%x(k) - self%x(k - 1)
      s = (time - self%x(k - 1))/h
      do i = self%degree, j, -1
         term = term*s + choose(j, i)*self%c(:, i, k)
      end do
      term = term*(unit/h)**j
   end function taylor_term

   !> Returns coefficient j of the power series about a time, as `taylor_term` does, of a curve that stays at its ends
   !> before and after them; shape (3).
   pure function clamped_term(self, j, t, moment, unit) result(term)
      type(piecewise_t), intent(in) :: self
      !> Index of the coefficient.
      integer, intent(in) :: j
      !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: term(3), time
      term = 0.0_wp
      if (j == 0) then
         time = min(max(t, self%x(0)), self%x(self%n))
         term = value_at(self, interval_at(self, time), time)
      else if (moment >= self%x(0) .and. moment <= self%x(self%n)) then
         term = taylor_term(self, interval_at(self, moment), j, t, unit)
      end if
   end function clamped_term

   !> Bounds of the length of the vector, of its first and of its second derivative, over all intervals, where
   !> their degree is 3 at most: the corners of the polynomials and of their derivatives in Bernstein's basis.
   pure subroutine find_bounds(self, bounds)
      type(piecewise_t), intent(in) :: self
      !> Units of the values over powers of s; shape (0:2).
      real(wp), intent(out) :: bounds(0:2)
      real(wp) :: b(3, 0:3), h
      integer :: k, j
      bounds = 0.0_wp
      do k = 1, self%n
         h = self%x(k) - self%x(k - 1)
         associate (c => self%c(:, :, k))
            b(:, 0) = c(:, 1)
            if (self%degree == 1) then
               b(:, 3) = b(:, 0) + c(:, 2)
               bounds(0) = max(bounds(0), length_of(b(:, 0)), length_of(b(:, 3)))
               bounds(1) = max(bounds(1), length_of(c(:, 2))/h)
               cycle
            end if
            b(:, 1) = b(:, 0) + c(:, 2)/3
            b(:, 2) = b(:, 1) + (c(:, 2) + c(:, 3))/3
            b(:, 3) = b(:, 0) + c(:, 2) + c(:, 3) + c(:, 4)
         end associate
         do j = 0, 3
            bounds(0) = max(bounds(0), length_of(b(:, j)))
            if (j < 3) bounds(1) = max(bounds(1), 3*length_of(b(:, j + 1) - b(:, j))/h)
            if (j < 2) bounds(2) = max(bounds(2), 6*(length_of(b(:, j + 2) - 2*b(:, j + 1) + b(:, j))/h)/h)
         end do
      end do
   end subroutine find_bounds

   !> Returns |v|, or 1e150 if a component is larger than that.
   pure real(wp) function length_of(v)
      real(wp), intent(in) :: v(3)
      real(wp), parameter :: longest = 1e150_wp
      length_of = longest
      if (maxval(abs(v)) < longest) length_of = vector_length(v)
   end function length_of

end module nutate_piecewise
