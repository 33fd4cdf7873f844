!> Indices of a list.
module nutate_indices
   implicit none
   private

   public :: find_indices

contains

   !> Finds the indices where a mask is true, in ascending order: `pack` of all indices, without its temporary lists.
   pure subroutine find_indices(mask, indices)
      logical, intent(in) :: mask(:)
      !> Allocated anew.
      integer, allocatable, intent(inout) :: indices(:)
      integer :: i, k
      if (allocated(indices)) deallocate (indices)
      allocate (indices(count(mask)))
      k = 0
      do i = 1, size(mask)
         if (.not. mask(i)) cycle
         k = k + 1
         indices(k) = i
      end do
   end subroutine find_indices

end module nutate_indices
