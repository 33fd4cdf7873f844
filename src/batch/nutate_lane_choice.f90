!> Choices lane by lane. In loops of their own: gfortran moves what is computed for one side of a `merge` alone under
!> a condition, and leaves such a loop scalar.
module nutate_lane_choice
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: choose_lanes, replace_lanes

contains

   !> Other numbers in some lanes.
   pure subroutine choose_lanes(chosen, new, x)
      !> 1: yes; shape (lanes).
      real(wp), intent(in) :: chosen(lanes), new(lanes)
      real(wp), intent(inout) :: x(lanes)
      real(wp) :: a, b
      integer :: i
      do i = 1, lanes
         a = new(i)
         b = x(i)
         x(i) = merge(a, b, chosen(i) > 0.5_wp)
      end do
   end subroutine choose_lanes

   !> One number in the lanes that are not kept.
   pure subroutine replace_lanes(kept, number, x)
      !> 1: kept; shape (lanes).
      real(wp), intent(in) :: kept(lanes), number
      real(wp), intent(inout) :: x(lanes)
      real(wp) :: a, b
      integer :: i
      b = number
      do i = 1, lanes
         a = x(i)
         x(i) = merge(a, b, kept(i) > 0.5_wp)
      end do
   end subroutine replace_lanes

end module nutate_lane_choice
