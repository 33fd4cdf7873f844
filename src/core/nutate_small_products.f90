!> Products of matrices of three rows, and the length of a vector. The compiler's `matmul` puts its result on the heap
!> wherever it is not simply assigned, which a step must not do.
module nutate_small_products
   use nutate_kinds, only: wp
   implicit none
   private

   public :: times_vector, times_columns, vector_length

contains

   !> A v; shape (3).
   pure function times_vector(a, v) result(product)
      real(wp), intent(in) :: a(3, 3), v(3)
      real(wp) :: product(3)
      product(1) = a(1, 1)*v(1) + a(1, 2)*v(2) + a(1, 3)*v(3)
      product(2) = a(2, 1)*v(1) + a(2, 2)*v(2) + a(2, 3)*v(3)
      product(3) = a(3, 1)*v(1) + a(3, 2)*v(2) + a(3, 3)*v(3)
   end function times_vector

   !> A B; shape (3,3).
   pure function times_columns(a, b) result(product)
      real(wp), intent(in) :: a(3, 3), b(3, 3)
      real(wp) :: product(3, 3)
      integer :: j
      do j = 1, 3
         product(:, j) = times_vector(a, b(:, j))
      end do
   end function times_columns

   !> |v|: the same digits in whatever unit of a power of two, where `norm2` rounds differently above and below 1. For
   !> components whose squares are numbers.
   pure real(wp) function vector_length(v)
      real(wp), intent(in) :: v(3)
      vector_length = sqrt(v(1)*v(1) + v(2)*v(2) + v(3)*v(3))
   end function vector_length

end module nutate_small_products
