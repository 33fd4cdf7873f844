!> Check of the build for fused arithmetic: a product and a sum rounded only once would let results depend on the
!> processor and on the inlining.
module nutate_contraction
   use nutate_kinds, only: wp
   implicit none
   private

   public :: is_fused, arithmetic_in_words

contains

   !> Returns true if a product and a sum are rounded only once.
   logical function is_fused()
      ! The compiler must not know the value, since it would otherwise compute the sums itself.
      real(wp), volatile :: x
      real(wp) :: a, square
      x = 1.0_wp + 2.0_wp**(-30)
      a = x
      square = a*a - (1.0_wp + 2.0_wp**(-29))
      ! The square exceeds the rounded one by 2**-60 if it was not rounded.
      is_fused = square > 0.0_wp
   end function is_fused

   !> Returns the arithmetic of the build in words.
   function arithmetic_in_words() result(words)
      character(len=:), allocatable :: words
      words = 'arithmetic as written, the same bits on every processor'
      if (is_fused()) words = 'products and sums fused: the bits depend on processor and compiler'
   end function arithmetic_in_words

end module nutate_contraction
