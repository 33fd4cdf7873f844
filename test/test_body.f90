!> Inertia: shapes, parallel axis, principal axes, and what is refused with which reason.
submodule(suites_of_runs) test_body
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_body, only: body_t, diagonal, make_body, make_shape_body, parallel_axis
   use nutate_kinds, only: wp, eps, pi
   use nutate_quaternion, only: rotation_matrix
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, status_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_body
      testsuite = [ &
                  new_unittest("shapes have the moments of mechanics books", shapes_have_the_moments_of_books), &
                  new_unittest("density times volume is mass", density_times_volume_is_mass), &
                  new_unittest("parallel axis rule moves the tensor", parallel_axis_rule_moves_the_tensor), &
                  new_unittest("a diagonal tensor keeps its axes", diagonal_tensor_keeps_its_axes), &
                  new_unittest("principal axes of a rotated tensor are found", rotated_tensor_is_diagonalised), &
                  new_unittest("inverse inertia is the inverse", inverse_inertia_is_the_inverse), &
                  new_unittest("plates, spheres and needles are bodies", plates_spheres_and_needles_are_bodies), &
                  new_unittest("impossible inertias are refused by name", impossible_inertias_are_refused), &
                  new_unittest("triangle check can be waived", triangle_check_can_be_waived), &
                  new_unittest("triangle check is relative to the body", triangle_check_is_relative), &
                  new_unittest("idealised top is noticed", idealised_top_is_noticed), &
                  new_unittest("bad masses and sizes are refused", bad_masses_and_sizes_are_refused)]
   end procedure collect_body

   subroutine shapes_have_the_moments_of_books(error)
      type(error_type), allocatable, intent(out) :: error
      call check_shape('box', [4.0_wp, 1.0_wp, 2.0_wp], [5.0_wp, 20.0_wp, 17.0_wp])
      call check_shape('cylinder', [2.0_wp, 3.0_wp], [21.0_wp, 21.0_wp, 24.0_wp])
      call check_shape('cone', [1.0_wp, 2.0_wp], [3.6_wp, 3.6_wp, 3.6_wp])
      call check_shape('sphere', [5.0_wp], [120.0_wp, 120.0_wp, 120.0_wp])
      call check_shape('ellipsoid', [1.0_wp, 2.0_wp, 3.0_wp], [31.2_wp, 24.0_wp, 12.0_wp])

   contains

      !> Mass 12 kg.
      subroutine check_shape(shape, lengths, moments)
         character(len=*), intent(in) :: shape
         real(wp), intent(in) :: lengths(:), moments(3)
         type(body_t) :: body
         type(status_t) :: status
         call make_shape_body(shape, lengths, body, status, mass=12.0_wp)
         call check(error, status%ok(), shape//": "//trim(status%message))
         call check_close(error, body%moments, moments, 4*eps*maxval(moments), shape)
      end subroutine check_shape

   end subroutine shapes_have_the_moments_of_books

   subroutine density_times_volume_is_mass(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_shape_body('cone', [0.05_wp, 0.1_wp], body, status, density=2700.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
      call check_close(error, body%mass, 2700*pi*0.05_wp**2*0.1_wp/3, 4*eps, "mass")
      ! The top of the paper's reference [3], about its tip.
      call check_close(error, body%moments, [0.00450622196249286_wp, 0.00450622196249286_wp, 0.000530143760293278_wp], &
                       1e-17_wp, "moments about the tip")
   end subroutine density_times_volume_is_mass

   subroutine parallel_axis_rule_moves_the_tensor(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      real(wp) :: expected(3, 3)
      call make_body(diagonal([2.0_wp, 3.0_wp, 4.0_wp]), body, status, mass=2.0_wp, &
                     center_of_mass=[1.0_wp, 2.0_wp, -3.0_wp], about_center_of_mass=.true.)
      expected = reshape([28.0_wp, -4.0_wp, 6.0_wp, -4.0_wp, 23.0_wp, 12.0_wp, 6.0_wp, 12.0_wp, 14.0_wp], [3, 3])
      call check_close(error, pack(body%inertia, .true.), pack(expected, .true.), 32*eps)
      call check_close(error, pack(parallel_axis(2.0_wp, [0.0_wp, 0.0_wp, 3.0_wp]), .true.), &
                       pack(diagonal([18.0_wp, 18.0_wp, 0.0_wp]), .true.), 0.0_wp)
   end subroutine parallel_axis_rule_moves_the_tensor

   subroutine diagonal_tensor_keeps_its_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_body(diagonal([3.0_wp, 1.0_wp, 2.5_wp]), body, status)
      call check_close(error, body%moments, [3.0_wp, 1.0_wp, 2.5_wp], 0.0_wp)
      call check_close(error, pack(body%axes, .true.), pack(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), .true.), 0.0_wp)
   end subroutine diagonal_tensor_keeps_its_axes

   subroutine rotated_tensor_is_diagonalised(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      real(wp) :: turn(3, 3), moments(3)
      ! Rotation by 0.3 rad about an axis: each principal axis stays nearest to its body axis.
      turn = rotation_matrix([cos(0.15_wp), sin(0.15_wp)*[1.0_wp, 2.0_wp, 2.0_wp]/3])
      moments = [7.0_wp, 5.0_wp, 6.0_wp]
      call make_body(matmul(turn, matmul(diagonal(moments), transpose(turn))), body, status)
      call check_close(error, body%moments, moments, 32*eps)
      call check_close(error, pack(body%axes, .true.), pack(turn, .true.), 64*eps, "axes, right-handed")
   end subroutine rotated_tensor_is_diagonalised

   subroutine inverse_inertia_is_the_inverse(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      real(wp) :: tensor(3, 3)
      tensor = reshape([4.0_wp, 1.0_wp, -0.5_wp, 1.0_wp, 5.0_wp, 0.25_wp, -0.5_wp, 0.25_wp, 6.0_wp], [3, 3])
      call make_body(1e-46_wp*tensor, body, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check_close(error, pack(matmul(body%inverse_inertia, body%inertia), .true.), &
                       pack(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), .true.), 16*eps)
      call check(error, all(body%inverse_inertia == transpose(body%inverse_inertia)), "not symmetric to the last digit")
   end subroutine inverse_inertia_is_the_inverse

   subroutine plates_spheres_and_needles_are_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(error, [1.0_wp, 2.0_wp, 3.0_wp], 0, "plate")
      call expect(error, [0.1_wp, 0.2_wp, 0.3_wp], 0, "plate in rounded numbers")
      call expect(error, [1.0_wp, 1.0_wp, 1.0_wp], 0, "sphere")
      call expect(error, [1.0_wp, 1.0_wp, 1e-12_wp], 0, "needle")
   end subroutine plates_spheres_and_needles_are_bodies

   subroutine impossible_inertias_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      real(wp) :: tensor(3, 3)
      call expect(error, [1.0_wp, 1.0_wp, 0.0_wp], NUTATE_BAD_BODY, "infinitely thin rod")
      call expect(error, [0.0_wp, 0.0_wp, 0.0_wp], NUTATE_BAD_BODY, "not positive definite")
      call expect(error, [1.0_wp, -1.0_wp, 1.0_wp], NUTATE_BAD_BODY, "not positive definite")
      call expect(error, [1.0_wp, 1.0_wp, 2.001_wp], NUTATE_BAD_BODY, "exceeds the sum of the other two")
      tensor = diagonal([1.0_wp, 1.0_wp, 1.0_wp])
      tensor(1, 2) = 0.5_wp
      call make_body(tensor, body, status)
      call check(error, index(status%message, "not symmetric") > 0, trim(status%message))
      tensor(2, 1) = 0.5_wp
      tensor(1, 2) = 1.5_wp
      tensor(2, 1) = 1.5_wp
      call make_body(tensor, body, status)
      call check(error, index(status%message, "not positive definite") > 0, trim(status%message))
      tensor(3, 3) = huge(1.0_wp)
      tensor(3, 3) = ieee_value(1.0_wp, ieee_quiet_nan)
      call make_body(tensor, body, status)
      call check(error, index(status%message, "not finite") > 0, trim(status%message))
   end subroutine impossible_inertias_are_refused

   !> A diagonal tensor gives this code, and a message that contains this text where it is refused.
   subroutine expect(error, moments, code, text)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: moments(3)
      integer, intent(in) :: code
      character(len=*), intent(in) :: text
      type(body_t) :: body
      type(status_t) :: status
      call make_body(diagonal(moments), body, status)
      call check(error, status%code == code, text//": "//trim(status%message))
      if (allocated(error) .or. code == 0) return
      call check(error, index(status%message, text) > 0, "wrong reason: "//trim(status%message))
   end subroutine expect

   subroutine triangle_check_can_be_waived(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_body(diagonal([0.345_wp, 0.653_wp, 1.0_wp]), body, status, check_triangle=.false.)
      call check(error, status%ok() .and. body%breaks_triangle, "not accepted, or not noted")
   end subroutine triangle_check_can_be_waived

   subroutine triangle_check_is_relative(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(error, 1e-46_wp*[1.0_wp, 1.0_wp, 2.001_wp], NUTATE_BAD_BODY, "exceeds the sum of the other two")
      call expect(error, 1e37_wp*[0.1_wp, 0.2_wp, 0.3_wp], 0, "plate")
   end subroutine triangle_check_is_relative

   subroutine idealised_top_is_noticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      ! About the tip (5, 5, 1), but m l² = 20 exceeds 5: no body about its centre of mass.
      call make_body(diagonal([5.0_wp, 5.0_wp, 1.0_wp]), body, status, mass=20.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call check(error, status%ok() .and. body%idealised, "not accepted, or not noted")
      if (allocated(error)) return
      call make_shape_body('cone', [1.0_wp, 1.0_wp], body, status, mass=1.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.75_wp])
      call check(error, status%ok() .and. .not. body%idealised, "a cone is a real body")
   end subroutine idealised_top_is_noticed

   subroutine bad_masses_and_sizes_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_shape_body('sphere', [1.0_wp], body, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call make_shape_body('sphere', [1.0_wp], body, status, mass=1.0_wp, density=1.0_wp)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call make_shape_body('sphere', [1.0_wp, 2.0_wp], body, status, mass=1.0_wp)
      call check(error, trim(status%subject), 'size')
      call make_shape_body('pyramid', [1.0_wp], body, status, mass=1.0_wp)
      call check(error, trim(status%subject), 'shape')
      call check(error, index(status%message, 'box, cylinder, cone, sphere, ellipsoid') > 0, status%message)
      call make_shape_body('sphere', [-1.0_wp], body, status, mass=1.0_wp)
      call check(error, trim(status%subject), 'size')
      call make_shape_body('sphere', [1.0_wp], body, status, mass=-1.0_wp)
      call check(error, trim(status%subject), 'mass')
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), body, status, center_of_mass=[1.0_wp, 0.0_wp, 0.0_wp], &
                     about_center_of_mass=.true.)
      call check(error, trim(status%subject), 'mass')
   end subroutine bad_masses_and_sizes_are_refused

end submodule test_body
