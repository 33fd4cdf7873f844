!> Whether this build keeps the arithmetic as written: a product and a sum made one rounding would let results depend on
!> the processor and on what was inlined where.
module nutate_contraction
   use nutate_kinds, only: wp
   implicit none
   private

   public :: is_fused, arithmetic_in_words

contains

   !> True if a product and a sum have become one rounding.
   logical function is_fused()
      ! Not known to the compiler, which would else do the sums itself.
      real(wp), volatile :: x
      real(wp) :: a, square
      x = 1.0_wp + 2.0_wp**(-30)
      a = x
      square = a*a - (1.0_wp + 2.0_wp**(-29))
      ! 2**-60 is left of the square where it was not rounded.
      is_fused = square > 0.0_wp
   end function is_fused

   !> The words for it.
   function arithmetic_in_words() result(words)
      character(len=:), allocatable :: words
      words = 'arithmetic as written, the same bits on every processor'
      if (is_fused()) words = 'products and sums fused: the bits depend on processor and compiler'
   end function arithmetic_in_words

end module nutate_contraction
