!> Noise of a fixed seed: the rounding errors of a machine with fewer digits.
!>
!> Each run has its own state, so that runs are repeated to the last bit, side by side too.
module nutate_noise
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp
   implicit none
   private

   public :: noise_t

   !> Generator of the noise, and the size of its numbers.
   type :: noise_t
      !> Relative size of the noise; 0: there is none.
      real(wp) :: amplitude = 0.0_wp
      !> State of the generator, not 0.
      integer(int64) :: state = 88172645463325252_int64
   contains
      !> Computes the next number.
      procedure, non_overridable :: next
      !> Computes the next numbers of a vector.
      procedure, non_overridable :: vector
   end type noise_t

contains

   !> Computes the next number, uniform in ±amplitude: the xorshift generator of G. Marsaglia (2003), the same on every
   !> machine.
   pure subroutine next(self, x)
      class(noise_t), intent(inout) :: self
      real(wp), intent(out) :: x
      associate (s => self%state)
         s = ieor(s, ishft(s, 13))
         s = ieor(s, ishft(s, -7))
         s = ieor(s, ishft(s, 17))
         x = self%amplitude*(2.0_wp**(-52)*real(ishft(s, -11), wp) - 1)
      end associate
   end subroutine next

   !> Computes the next numbers, each uniform in ±amplitude.
   pure subroutine vector(self, v)
      class(noise_t), intent(inout) :: self
      !> Shape (any).
      real(wp), intent(out) :: v(:)
      integer :: i
      do i = 1, size(v)
         call self%next(v(i))
      end do
   end subroutine vector

end module nutate_noise
