!> Which vector instructions a kernel may use, asked at run time: a kernel is compiled once for every x86-64 processor
!> and once for those with AVX2, by the same text and to the same bits.
module nutate_simd
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none
   private

   public :: has_avx2

   interface
      integer(c_int) function nutate_has_avx2() bind(C)
         import :: c_int
      end function nutate_has_avx2
   end interface

contains

   !> True if the processor has AVX2 and the environment variable `NUTATE_SIMD` does not say `sse2`, by which the two
   !> kernels can be compared on one machine.
   logical function has_avx2()
      has_avx2 = nutate_has_avx2() /= 0
   end function has_avx2

end module nutate_simd
