!> Choice of vector instructions at run time: a kernel is compiled once for every x86-64 processor and once for those
!> with AVX2, from the same source and with bitwise identical results.
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

   !> Returns true if the processor has AVX2 and the environment variable `NUTATE_SIMD` is not `sse2`. With this
   !> variable the two kernels can be compared on one machine.
   logical function has_avx2()
      has_avx2 = nutate_has_avx2() /= 0
   end function has_avx2

end module nutate_simd
