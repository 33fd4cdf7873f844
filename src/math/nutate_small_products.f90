!> Products of matrices of three rows, the length of a vector, and tests for alignment with an axis. The compiler's
!> `matmul` puts its result on the heap wherever it is not simply assigned, which a step must not do.
module nutate_small_products
   use nutate_kinds, only: wp
   implicit none
   private

   public :: skew, times_vector, times_columns, multiply, add_multiple, add_outer, vector_length, lies_along, &
      is_symmetric_about, is_positive, symmetric_inverse, deviator

contains

   !> Returns [v]×, the matrix of v×; shape (3,3).
   pure function skew(v) result(matrix)
      real(wp), intent(in) :: v(3)
      real(wp) :: matrix(3, 3)
      matrix(:, 1) = [0.0_wp, v(3), -v(2)]
      matrix(:, 2) = [-v(3), 0.0_wp, v(1)]
      matrix(:, 3) = [v(2), -v(1), 0.0_wp]
   end function skew

   !> Returns A v; shape (3).
   pure function times_vector(a, v) result(product)
      real(wp), intent(in) :: a(3, 3), v(3)
      real(wp) :: product(3)
      product(1) = a(1, 1)*v(1) + a(1, 2)*v(2) + a(1, 3)*v(3)
      product(2) = a(2, 1)*v(1) + a(2, 2)*v(2) + a(2, 3)*v(3)
      product(3) = a(3, 1)*v(1) + a(3, 2)*v(2) + a(3, 3)*v(3)
   end function times_vector

   !> Returns A B; shape (3,3).
   pure function times_columns(a, b) result(product)
      real(wp), intent(in) :: a(3, 3), b(3, 3)
      real(wp) :: product(3, 3)
      integer :: j
      do j = 1, 3
         product(:, j) = times_vector(a, b(:, j))
      end do
   end function times_columns

   !> Computes A B, all elements written out: for matrices that are used as soon as they are made. The processor stalls
   !> if numbers that it stored one by one are read as a vector before they have reached the memory.
   pure subroutine multiply(a, b, product)
      real(wp), intent(in) :: a(3, 3), b(3, 3)
      real(wp), intent(out) :: product(3, 3)
      product(1, 1) = a(1, 1)*b(1, 1) + a(1, 2)*b(2, 1) + a(1, 3)*b(3, 1)
      product(2, 1) = a(2, 1)*b(1, 1) + a(2, 2)*b(2, 1) + a(2, 3)*b(3, 1)
      product(3, 1) = a(3, 1)*b(1, 1) + a(3, 2)*b(2, 1) + a(3, 3)*b(3, 1)
      product(1, 2) = a(1, 1)*b(1, 2) + a(1, 2)*b(2, 2) + a(1, 3)*b(3, 2)
      product(2, 2) = a(2, 1)*b(1, 2) + a(2, 2)*b(2, 2) + a(2, 3)*b(3, 2)
      product(3, 2) = a(3, 1)*b(1, 2) + a(3, 2)*b(2, 2) + a(3, 3)*b(3, 2)
      product(1, 3) = a(1, 1)*b(1, 3) + a(1, 2)*b(2, 3) + a(1, 3)*b(3, 3)
      product(2, 3) = a(2, 1)*b(1, 3) + a(2, 2)*b(2, 3) + a(2, 3)*b(3, 3)
      product(3, 3) = a(3, 1)*b(1, 3) + a(3, 2)*b(2, 3) + a(3, 3)*b(3, 3)
   end subroutine multiply

   !> Adds a multiple of a matrix, all elements written out as in `multiply`.
   pure subroutine add_multiple(factor, matrix, sum)
      real(wp), intent(in) :: factor, matrix(3, 3)
      real(wp), intent(inout) :: sum(3, 3)
      sum(1, 1) = sum(1, 1) + factor*matrix(1, 1)
      sum(2, 1) = sum(2, 1) + factor*matrix(2, 1)
      sum(3, 1) = sum(3, 1) + factor*matrix(3, 1)
      sum(1, 2) = sum(1, 2) + factor*matrix(1, 2)
      sum(2, 2) = sum(2, 2) + factor*matrix(2, 2)
      sum(3, 2) = sum(3, 2) + factor*matrix(3, 2)
      sum(1, 3) = sum(1, 3) + factor*matrix(1, 3)
      sum(2, 3) = sum(2, 3) + factor*matrix(2, 3)
      sum(3, 3) = sum(3, 3) + factor*matrix(3, 3)
   end subroutine add_multiple

   !> Adds a multiple of abᵀ.
   pure subroutine add_outer(factor, a, b, sum)
      real(wp), intent(in) :: factor, a(3), b(3)
      real(wp), intent(inout) :: sum(3, 3)
      sum(1, 1) = sum(1, 1) + factor*(a(1)*b(1))
      sum(2, 1) = sum(2, 1) + factor*(a(2)*b(1))
      sum(3, 1) = sum(3, 1) + factor*(a(3)*b(1))
      sum(1, 2) = sum(1, 2) + factor*(a(1)*b(2))
      sum(2, 2) = sum(2, 2) + factor*(a(2)*b(2))
      sum(3, 2) = sum(3, 2) + factor*(a(3)*b(2))
      sum(1, 3) = sum(1, 3) + factor*(a(1)*b(3))
      sum(2, 3) = sum(2, 3) + factor*(a(2)*b(3))
      sum(3, 3) = sum(3, 3) + factor*(a(3)*b(3))
   end subroutine add_outer

   !> Returns true if a symmetric matrix is positive definite: its leading minors are, each relative to the diagonal.
   pure logical function is_positive(a)
      real(wp), intent(in) :: a(3, 3)
      real(wp) :: b(3, 3), d(3), minor
      integer :: i, j
      d = [a(1, 1), a(2, 2), a(3, 3)]
      is_positive = all(d > 0.0_wp)
      if (.not. is_positive) return
      do j = 1, 3
         do i = 1, 3
            b(i, j) = a(i, j)/(sqrt(d(i))*sqrt(d(j)))
         end do
      end do
      minor = 1 - b(1, 2)**2
      is_positive = minor > 0.0_wp .and. &
                    minor - b(1, 3)**2 - b(2, 3)**2 + 2*b(1, 2)*b(1, 3)*b(2, 3) > 0.0_wp
   end function is_positive

   !> Returns the inverse of a positive definite matrix, symmetric to the last digit; shape (3,3).
   pure function symmetric_inverse(a) result(inverse)
      real(wp), intent(in) :: a(3, 3)
      real(wp) :: inverse(3, 3)
      real(wp) :: root, rest, first(2), last(2), b(3)
      ! By the inverse of the block of the first two axes: no product of three elements, which could overflow.
      root = a(1, 2)/a(1, 1)
      rest = a(2, 2) - root*a(1, 2)
      first = [1/a(1, 1) + root*(root/rest), -root/rest]
      last = [first(2), 1/rest]
      b(1:2) = a(1, 3)*first + a(2, 3)*last
      b(3) = 1/(a(3, 3) - (a(1, 3)*b(1) + a(2, 3)*b(2)))
      inverse(1, 1) = first(1) + b(1)*(b(1)*b(3))
      inverse(2, 2) = last(2) + b(2)*(b(2)*b(3))
      inverse(3, 3) = b(3)
      inverse(1, 2) = first(2) + b(1)*(b(2)*b(3))
      inverse(1, 3) = -b(1)*b(3)
      inverse(2, 3) = -b(2)*b(3)
      inverse(2, 1) = inverse(1, 2)
      inverse(3, 1) = inverse(1, 3)
      inverse(3, 2) = inverse(2, 3)
   end function symmetric_inverse

   !> Returns a matrix less its isotropic part; shape (3,3).
   pure function deviator(a) result(rest)
      real(wp), intent(in) :: a(3, 3)
      real(wp) :: rest(3, 3)
      real(wp) :: mean
      integer :: i
      mean = (a(1, 1) + a(2, 2) + a(3, 3))/3
      rest = a
      do i = 1, 3
         rest(i, i) = rest(i, i) - mean
      end do
   end function deviator

   !> Returns |v|: the same digits in any unit of a power of two, where `norm2` rounds differently above and below 1.
   !> For components whose squares neither overflow nor underflow.
   pure real(wp) function vector_length(v)
      real(wp), intent(in) :: v(3)
      vector_length = sqrt(v(1)*v(1) + v(2)*v(2) + v(3)*v(3))
   end function vector_length

   !> Returns true if all components of a vector but the one along an axis are zero.
   pure logical function lies_along(v, axis)
      real(wp), intent(in) :: v(3)
      !> 1, 2 or 3.
      integer, intent(in) :: axis
      lies_along = .not. (abs(v(1 + modulo(axis, 3))) > 0.0_wp .or. abs(v(1 + modulo(axis + 1, 3))) > 0.0_wp)
   end function lies_along

   !> Returns true if a matrix is diagonal and its elements across an axis are equal, to the last bit: a rotation about
   !> the axis does not change it.
   pure logical function is_symmetric_about(a, axis)
      real(wp), intent(in) :: a(3, 3)
      !> 1, 2 or 3.
      integer, intent(in) :: axis
      integer :: i, j
      i = 1 + modulo(axis, 3)
      j = 1 + modulo(axis + 1, 3)
      is_symmetric_about = lies_along(a(:, axis), axis) .and. lies_along(a(:, i), i) .and. &
                           lies_along(a(:, j), j) .and. .not. abs(a(i, i) - a(j, j)) > 0.0_wp
   end function is_symmetric_about

end module nutate_small_products
