!> Surface of a body as triangles: its shape, or the box that has its inertia.
module nutate_surface
   use nutate_body, only: body_t, diagonal, parallel_axis, whole_body
   use nutate_kinds, only: wp, pi
   use nutate_lapack, only: symmetric_eigen
   use nutate_quaternion, only: cross
   use nutate_status, only: status_t
   implicit none
   private

   public :: surface_t, surface_of

   !> A surface of triangles.
   type :: surface_t
      !> Points in body axes, m; shape (3, points).
      real(wp), allocatable :: points(:, :)
      !> Points of each triangle, counted from 0, counterclockwise seen from outside; shape (3, triangles).
      integer, allocatable :: corners(:, :)
   end type surface_t

   !> Number of points around an axis.
   integer, parameter :: around = 32
   !> Shortest edge of a plate relative to its longest.
   real(wp), parameter :: thinnest = 1e-2_wp

contains

   !> Returns the surface of a body.
   function surface_of(body, shape, size) result(surface)
      type(body_t), intent(in) :: body
      !> Name of the body's shape, and its lengths, m; blank: the box of its inertia.
      character(len=*), intent(in) :: shape
      real(wp), intent(in) :: size(:)
      type(surface_t) :: surface
      integer :: i
      select case (shape)
      case ('box')
         surface = box(size)
      case ('cylinder')
         surface = rotated_profile(size(1)*[0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp], &
                                  size(2)*[-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp])
      case ('cone')
         surface = rotated_profile(size(1)*[0.0_wp, 1.0_wp, 0.0_wp], size(2)*[-0.75_wp, 0.25_wp, 0.25_wp])
      case ('sphere')
         surface = ellipsoid(spread(size(1), 1, 3))
      case ('ellipsoid')
         surface = ellipsoid(size)
      case default
         surface = inertia_box(body)
      end select
      do i = 1, ubound(surface%points, 2)
         surface%points(:, i) = surface%points(:, i) + body%center_of_mass
      end do
   end function surface_of

   !> Returns a box with its edges along the axes.
   pure function box(edges) result(surface)
      !> Edges, m; shape (3).
      real(wp), intent(in) :: edges(:)
      type(surface_t) :: surface
      integer :: i
      allocate (surface%points(3, 8))
      do i = 0, 7
         surface%points(:, i + 1) = 0.5_wp*edges*(2*[iand(i, 1), iand(i, 2)/2, iand(i, 4)/4] - 1)
      end do
      surface%corners = reshape([0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, &
                                 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6], [3, 12])
   end function box

   !> Returns the surface of a profile that is rotated about axis 3.
   pure function rotated_profile(radii, heights) result(surface)
      !> Radii and heights, from below, m; shape (points of the profile).
      real(wp), intent(in) :: radii(:), heights(:)
      type(surface_t) :: surface
      real(wp) :: angle
      integer :: i, k, a, b, n
      allocate (surface%points(3, around*size(radii)), surface%corners(3, 2*around*(size(radii) - 1)))
      n = 0
      do i = 1, size(radii)
         ! Vector functions are avoided: their last digits differ from those of the scalar ones.
         !GCC$ novector
         do k = 0, around - 1
            angle = 2*pi*k/around
            surface%points(:, around*(i - 1) + k + 1) = [radii(i)*cos(angle), radii(i)*sin(angle), heights(i)]
            if (i == size(radii)) cycle
            a = around*(i - 1) + k
            b = around*(i - 1) + modulo(k + 1, around)
            surface%corners(:, n + 1) = [a, b, a + around]
            surface%corners(:, n + 2) = [b, b + around, a + around]
            n = n + 2
         end do
      end do
   end function rotated_profile

   !> Returns an ellipsoid with its semi-axes along the axes.
   pure function ellipsoid(axes) result(surface)
      !> Semi-axes, m; shape (3).
      real(wp), intent(in) :: axes(:)
      type(surface_t) :: surface
      real(wp) :: radii(0:around/2), heights(0:around/2)
      integer :: i
      !GCC$ novector
      do i = 0, around/2
         radii(i) = sin(pi*i/(around/2))
         heights(i) = -cos(pi*i/(around/2))
      end do
      surface = rotated_profile(radii, heights)
      do i = 1, size(surface%points, 2)
         surface%points(:, i) = axes*surface%points(:, i)
      end do
   end function ellipsoid

   !> Returns the homogeneous box with the inertia of a body about its centre of mass; its longest edge is 1 if the mass
   !> is not known, since forms do not depend on it.
   function inertia_box(body) result(surface)
      type(body_t), intent(in) :: body
      type(surface_t) :: surface
      type(body_t) :: whole
      type(status_t) :: status
      real(wp) :: central(3, 3), moments(3), axes(3, 3), squares(3), edges(3), scale
      integer :: i
      whole = whole_body(body)
      central = whole%inertia - parallel_axis(whole%mass, whole%center_of_mass)
      scale = maxval(abs(central))
      axes = diagonal([1.0_wp, 1.0_wp, 1.0_wp])
      edges = 1.0_wp
      squares = 0.0_wp
      if (scale > 0.0_wp) then
         call symmetric_eigen(central/scale, moments, axes, status)
         squares = max(0.5_wp*sum(moments) - moments, 0.0_wp)
      end if
      ! Moments that no body has give no edges: these stay 1.
      if (maxval(squares) > 0.0_wp) then
         edges = sqrt(max(squares/maxval(squares), thinnest**2))
         if (whole%has_mass) edges = edges*(sqrt(12*maxval(squares))*sqrt(scale)/sqrt(whole%mass))
      end if
      surface = box(edges)
      if (dot_product(cross(axes(:, 1), axes(:, 2)), axes(:, 3)) < 0.0_wp) axes(:, 3) = -axes(:, 3)
      do i = 1, size(surface%points, 2)
         surface%points(:, i) = matmul(axes, surface%points(:, i))
      end do
   end function inertia_box

end module nutate_surface
