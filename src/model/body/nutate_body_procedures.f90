!> Bodies of the procedures whose interfaces are in `nutate_body`.
submodule(nutate_body) nutate_body_procedures
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: eps
   use nutate_lapack, only: symmetric_eigen
   use nutate_limits, only: greatest_length, greatest_number, is_moderate, least_length, least_size, in_words
   use nutate_shapes, only: measure_shape
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   implicit none

contains

   module procedure make_body
      logical :: move, check

      move = .false.
      if (present(about_center_of_mass)) move = about_center_of_mass
      check = .true.
      if (present(check_triangle)) check = check_triangle
      body%admits_all = .not. check
      call set_mass(body, status, mass, center_of_mass)
      if (.not. status%ok()) return
      if (move .and. .not. body%has_mass .and. any(body%center_of_mass /= 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'moving the inertia from the centre of mass needs the mass', 'mass')
         return
      end if
      body%inertia = tensor
      call check_tensor(body%inertia, status)
      if (.not. status%ok()) return
      if (move) body%inertia = body%inertia + parallel_axis(body%mass, body%center_of_mass)
      call find_principal_axes(body, status)
      if (.not. status%ok()) return
      call check_moments(body, check, status)
      if (.not. status%ok()) return
      call invert_inertia(body)
      body%locked = body%inertia
      if (body%has_mass) call check_center_tensor(body)
   end procedure make_body

   module procedure without
      rest = body
      rest%inertia = body%locked - spinning
      call find_principal_axes(rest, status)
      if (status%ok()) call check_moments(rest, .false., status)
      if (.not. status%ok()) then
         status = fail(NUTATE_BAD_BODY, 'the inertia of the wheels is not below that of the body '// &
                       '(expected that of the body with its wheels locked to be larger)', 'inertia')
         return
      end if
      call invert_inertia(rest)
   end procedure without

   module procedure whole_body
      type(status_t) :: status
      real(wp), parameter :: nothing(3, 3) = 0.0_wp
      whole = body
      if (any(abs(body%locked - body%inertia) > 0.0_wp)) call without(body, nothing, whole, status)
   end procedure whole_body

   module procedure make_shape_body
      real(wp) :: volume, gyration(3), m

      if (present(mass) .eqv. present(density)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a shape needs its mass or its density, one of the two', 'mass')
         return
      end if
      if (.not. all(ieee_is_finite(lengths))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a length is not a finite number', 'size')
      else if (any(lengths <= 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a length is not positive', 'size')
      else if (any(lengths < least_length .or. lengths > greatest_length)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a length is too large or too small (expected '// &
                       in_words(least_length, greatest_length)//' m)', 'size')
      else if (present(density)) then
         if (.not. ieee_is_finite(density)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the density is not a finite number', 'mass')
         else if (density < least_size .or. density > greatest_number) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the density is out of its range (expected '// &
                          in_words(least_size, greatest_number)//' kg/m3)', 'mass')
         end if
      end if
      if (.not. status%ok()) return
      call measure_shape(shape, lengths, volume, gyration, status)
      if (.not. status%ok()) return
      if (present(mass)) then
         m = mass
      else
         m = density*volume
      end if
      call set_mass(body, status, m)
      if (.not. status%ok()) return
      call make_body(diagonal(m*gyration), body, status, m, center_of_mass, about_center_of_mass=.true.)
   end procedure make_shape_body

   !> Returns the error that the moments are too large or too small.
   pure type(status_t) function wrong_size()
      wrong_size = fail(NUTATE_BAD_BODY, 'the inertia is too large or too small (expected principal moments of '// &
                        in_words(least_size, greatest_number)//' kg m2)', 'inertia')
   end function wrong_size

   !> Stores mass and centre of mass after testing them.
   pure subroutine set_mass(body, status, mass, center_of_mass)
      type(body_t), intent(inout) :: body
      type(status_t), intent(out) :: status
      real(wp), intent(in), optional :: mass, center_of_mass(3)
      if (present(mass)) then
         if (.not. ieee_is_finite(mass)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the mass is not a finite number', 'mass')
         else if (mass <= 0.0_wp) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the mass is not positive', 'mass')
         else if (mass < least_size .or. mass > greatest_number) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the mass is too large or too small (expected '// &
                          in_words(least_size, greatest_number)//' kg)', 'mass')
         end if
         if (.not. status%ok()) return
         body%mass = mass
         body%has_mass = .true.
      end if
      if (present(center_of_mass)) then
         if (.not. all(ieee_is_finite(center_of_mass))) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the centre of mass is not finite', 'center_of_mass')
         else if (.not. all(is_moderate(center_of_mass))) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the centre of mass is too far away (expected up to '// &
                          in_words(greatest_number)//' m)', 'center_of_mass')
         end if
         if (status%ok()) body%center_of_mass = center_of_mass
      end if
   end subroutine set_mass

   module procedure parallel_axis
      integer :: i, j
      do j = 1, 3
         do i = 1, 3
            shift(i, j) = -mass*c(i)*c(j)
         end do
      end do
      shift(1, 1) = mass*(c(2)**2 + c(3)**2)
      shift(2, 2) = mass*(c(3)**2 + c(1)**2)
      shift(3, 3) = mass*(c(1)**2 + c(2)**2)
   end procedure parallel_axis

   !> Checks that a tensor is finite and symmetric.
   pure subroutine check_tensor(tensor, status)
      real(wp), intent(in) :: tensor(3, 3)
      type(status_t), intent(out) :: status
      if (.not. all(ieee_is_finite(tensor))) then
         status = fail(NUTATE_BAD_BODY, 'the inertia is not finite', 'inertia')
      else if (.not. all(is_moderate(tensor))) then
         status = wrong_size()
      else if (maxval(abs(tensor - transpose(tensor))) > 8*eps*maxval(abs(tensor))) then
         status = fail(NUTATE_BAD_BODY, 'the inertia tensor is not symmetric', 'inertia')
      end if
   end subroutine check_tensor

   !> Computes the principal moments and axes; a diagonal tensor keeps its axes.
   pure subroutine find_principal_axes(body, status)
      type(body_t), intent(inout) :: body
      type(status_t), intent(out) :: status
      real(wp) :: scale, values(3), vectors(3, 3)
      integer :: order(3)

      body%inertia = 0.5_wp*(body%inertia + transpose(body%inertia))
      body%moments = [body%inertia(1, 1), body%inertia(2, 2), body%inertia(3, 3)]
      body%axes = diagonal([1.0_wp, 1.0_wp, 1.0_wp])
      if (all(body%inertia == diagonal(body%moments))) return
      ! A power of two, so that bodies in other units get the same digits.
      scale = 2.0_wp**exponent(maxval(abs(body%inertia)))
      call symmetric_eigen(body%inertia/scale, values, vectors, status)
      if (.not. status%ok()) return
      order = nearest_order(vectors)
      body%moments = scale*values(order)
      body%axes = right_handed(vectors(:, order))
   end subroutine find_principal_axes

   !> Returns the eigenvector nearest to each body axis: the permutation with the largest sum of squared cosines.
   pure function nearest_order(vectors) result(best)
      real(wp), intent(in) :: vectors(3, 3)
      integer :: best(3)
      integer, parameter :: orders(3, 6) = reshape([1, 2, 3, 2, 1, 3, 1, 3, 2, 3, 2, 1, 2, 3, 1, 3, 1, 2], [3, 6])
      real(wp) :: nearness, most
      integer :: k, i
      most = -1.0_wp
      best = orders(:, 1)
      do k = 1, 6
         nearness = 0.0_wp
         do i = 1, 3
            nearness = nearness + vectors(i, orders(i, k))**2
         end do
         if (nearness > most) then
            most = nearness
            best = orders(:, k)
         end if
      end do
   end function nearest_order

   !> Returns the columns rotated so that each points along its body axis and the three are right-handed.
   pure function right_handed(vectors) result(axes)
      real(wp), intent(in) :: vectors(3, 3)
      real(wp) :: axes(3, 3)
      real(wp) :: third(3)
      integer :: i
      do i = 1, 3
         axes(:, i) = sign(1.0_wp, vectors(i, i))*vectors(:, i)
      end do
      third = [axes(2, 1)*axes(3, 2) - axes(3, 1)*axes(2, 2), &
               axes(3, 1)*axes(1, 2) - axes(1, 1)*axes(3, 2), &
               axes(1, 1)*axes(2, 2) - axes(2, 1)*axes(1, 2)]
      if (dot_product(third, axes(:, 3)) < 0.0_wp) axes(:, 3) = -axes(:, 3)
   end function right_handed

   !> Checks that the moments are positive and those of a rigid body.
   pure subroutine check_moments(body, check_triangle, status)
      type(body_t), intent(inout) :: body
      logical, intent(in) :: check_triangle
      type(status_t), intent(out) :: status
      real(wp) :: largest
      character(len=120) :: text
      character(len=8) :: excess

      largest = maxval(body%moments)
      if (largest > greatest_number .or. (largest > 0.0_wp .and. largest < least_size)) then
         status = wrong_size()
      else if (largest <= 0.0_wp .or. any(body%moments < -8*eps*largest)) then
         status = fail(NUTATE_BAD_BODY, 'the inertia is not positive definite: every principal moment must be '// &
                       'positive', 'inertia')
      else if (any(body%moments <= 8*eps*largest)) then
         status = fail(NUTATE_BAD_BODY, 'a principal moment of inertia is zero: an infinitely thin rod has no '// &
                       'inertia about its axis, so its spin is undefined', 'inertia')
      else if (any(body%moments < least_size)) then
         status = wrong_size()
      end if
      if (.not. status%ok()) return
      body%breaks_triangle = triangle_excess(body%moments) > triangle_tolerance
      if (check_triangle .and. body%breaks_triangle) then
         write (text, '(3(1x,g0.6))') body%moments
         write (excess, '(es8.1)') triangle_excess(body%moments)
         status = fail(NUTATE_BAD_BODY, 'no rigid body has the principal moments'//trim(text)// &
                       ': one exceeds the sum of the other two by '//trim(adjustl(excess))//' of itself', 'inertia')
      end if
   end subroutine check_moments

   !> Returns the excess of the largest moment over the sum of the other two, over the largest; <= 0 for every rigid
   !> body.
   pure real(wp) function triangle_excess(moments)
      !> Principal moments, any order.
      real(wp), intent(in) :: moments(3)
      triangle_excess = 2.0_wp - sum(moments/maxval(moments))
   end function triangle_excess

   !> Computes J⁻¹ = A diag(1/Jᵢ) Aᵀ, each entry once so that the matrix is symmetric to the last digit.
   pure subroutine invert_inertia(body)
      type(body_t), intent(inout) :: body
      integer :: i, j
      do j = 1, 3
         do i = 1, j
            body%inverse_inertia(i, j) = sum(body%axes(i, :)*body%axes(j, :)/body%moments)
            body%inverse_inertia(j, i) = body%inverse_inertia(i, j)
         end do
      end do
   end subroutine invert_inertia

   !> Stores whether the tensor about the centre of mass is one that a body can have.
   pure subroutine check_center_tensor(body)
      type(body_t), intent(inout) :: body
      real(wp) :: central(3, 3), values(3), vectors(3, 3)
      type(status_t) :: status
      if (all(body%center_of_mass == 0.0_wp)) return
      central = body%inertia - parallel_axis(body%mass, body%center_of_mass)
      call symmetric_eigen(central/maxval(abs(body%inertia)), values, vectors, status)
      if (.not. status%ok()) return
      body%idealised = values(1) < -triangle_tolerance .or. values(1) + values(2) < values(3) - triangle_tolerance
   end subroutine check_center_tensor

   module procedure diagonal
      integer :: i
      matrix = 0.0_wp
      do i = 1, 3
         matrix(i, i) = d(i)
      end do
   end procedure diagonal

   module procedure symmetric
      matrix = reshape([d(1), d(4), d(5), d(4), d(2), d(6), d(5), d(6), d(3)], [3, 3])
   end procedure symmetric

end submodule nutate_body_procedures
