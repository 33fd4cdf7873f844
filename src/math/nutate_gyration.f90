!> The term h×Ω of the momenta of inner spheres in body axes (`nutate_inner_sphere`).
module nutate_gyration
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross
   implicit none
   private

   public :: add_gyration

contains

   !> Adds h×Ω to the rates of the momenta of inner spheres, three numbers of each.
   pure subroutine add_gyration(momenta, omega, rates)
      !> h, N m s, shape (any multiple of 3); Ω, body axes, rad/s, shape (3), or a multiple of it.
      real(wp), intent(in) :: momenta(:), omega(3)
      !> ḣ, N m, or the same multiple of it; shape of the momenta.
      real(wp), intent(inout) :: rates(:)
      integer :: i
      do i = 1, size(momenta), 3
         rates(i:i + 2) = rates(i:i + 2) + cross(momenta(i:i + 2), omega)
      end do
   end subroutine add_gyration

end module nutate_gyration
