!> The derivatives of each effect: discrete gradients that close the energy, and what Newton's method needs.
submodule(suites_of_effects) test_effect_gradients
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: potential_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: rotate_to_body
   use nutate_spring, only: spring_t
   use nutate_system, only: system_t
   use test_effect_samples, only: effect_samples_t, quartic_t, sample_body
   use test_jacobian, only: check_jacobian
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

contains

   module procedure collect_effect_gradients
      testsuite = [ &
                  new_unittest("discrete gradients close the energy", discrete_gradients_close_the_energy), &
                  new_unittest("discrete gradients close where spring ends meet", gradient_closes_where_ends_meet), &
                  new_unittest("second derivatives match differences", second_derivatives_match_differences), &
                  new_unittest("a spring of no length has finite derivatives", spring_of_no_length_is_finite), &
                  new_unittest("Jacobian of each effect", jacobian_of_each_effect), &
                  new_unittest("Jacobian of all effects together", jacobian_of_all_effects)]
   end procedure collect_effect_gradients

   !> Checks ends from 1 to 1e-16 apart. The scale is the largest term of U, with γ up to 2.
   subroutine discrete_gradients_close_the_energy(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      real(wp), parameter :: n(3) = [0.6_wp, -0.5_wp, 0.9_wp], x(3) = [0.4_wp, 0.1_wp, -0.6_wp]
      type(quartic_t) :: quartic
      integer :: sign
      system => sample_body()
      do sign = -1, 1
         call check_closure(error, dipole_t(sign*[0.5_wp, -1.0_wp, 2.0_wp], n), 3.0_wp, "dipole")
         call check_closure(error, gravity_t(system%body, sign*9.0_wp*n), 20.0_wp, "gravity")
         call check_closure(error, gravity_gradient_t(system%body, n, 0.4_wp*sign), 10.0_wp, "gravity gradient")
         call check_closure(error, spring_t(x, n, 5.0_wp*sign), 20.0_wp, "spring without rest length")
         call check_closure(error, spring_t(x, n, 5.0_wp*sign, 0.7_wp), 20.0_wp, "spring")
         call check_closure(error, spring_t(1.002_wp*n, n, 5.0_wp*sign, 0.7_wp), 20.0_wp, "spring whose ends can meet")
      end do
      quartic%direction = n
      call check_closure(error, quartic, 10.0_wp, "user's potential")
   end subroutine discrete_gradients_close_the_energy

   !> |∇̄U·Δγ - ΔU| <= 8ε scale at random ends of the length of the potential's direction.
   subroutine check_closure(error, potential, scale, label)
      type(error_type), allocatable, intent(inout) :: error
      class(potential_t), intent(in) :: potential
      real(wp), intent(in) :: scale
      character(len=*), intent(in) :: label
      integer(int64) :: seed
      real(wp) :: q(4), gamma0(3), gamma1(3), closure
      integer :: i, k
      seed = 99_int64
      do k = 0, 16
         do i = 1, 20
            q = random_unit_quaternion(seed)
            gamma0 = rotate_to_body(q, potential%direction)
            q(2:4) = q(2:4) + 10.0_wp**(-k)*random_vector(seed)
            gamma1 = rotate_to_body(q/norm2(q), potential%direction)
            closure = dot_product(potential%discrete_gradient(gamma0, gamma1), gamma1 - gamma0) &
                      - (potential%energy(gamma1) - potential%energy(gamma0))
            call check_below(error, abs(closure), 8*eps*scale, label)
         end do
      end do
   end subroutine check_closure

   !> Checks the point itself, the way to it and past it, down to the last digit.
   subroutine gradient_closes_where_ends_meet(error)
      type(error_type), allocatable, intent(out) :: error
      type(spring_t) :: spring
      real(wp), parameter :: x(3) = [0.6_wp, -0.5_wp, 0.9_wp], away(3) = [0.5_wp, 0.6_wp, 0.0_wp]
      real(wp) :: gamma0(3), gamma1(3), closure
      integer :: i, k, j
      do i = 0, 1
         spring = spring_t(x, x, 5.0_wp, 0.7_wp*i)
         do k = 0, 18
            do j = -1, 1
               gamma0 = x + 10.0_wp**(-k)*away
               gamma1 = x + 10.0_wp**(-k)*j*[-0.3_wp, 0.6_wp, 0.5_wp]
               closure = dot_product(spring%discrete_gradient(gamma0, gamma1), gamma1 - gamma0) &
                         - (spring%energy(gamma1) - spring%energy(gamma0))
               call check_below(error, abs(closure), 64*eps, "closure")
            end do
         end do
      end do
   end subroutine gradient_closes_where_ends_meet

   subroutine second_derivatives_match_differences(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(quartic_t) :: quartic
      real(wp), parameter :: n(3) = [0.6_wp, -0.5_wp, 0.9_wp], x(3) = [0.4_wp, 0.1_wp, -0.6_wp]
      system => sample_body()
      call check_derivatives(error, gravity_t(system%body, n), "gravity")
      call check_derivatives(error, dipole_t(x, n), "dipole")
      call check_derivatives(error, gravity_gradient_t(system%body, n, -0.4_wp), "gravity gradient")
      call check_derivatives(error, spring_t(x, n, 3.0_wp), "spring without rest length")
      call check_derivatives(error, spring_t(x, n, -3.0_wp, 0.7_wp), "spring")
      call check_derivatives(error, spring_t(1.002_wp*n, n, 3.0_wp, 0.7_wp), "spring whose ends can meet")
      call check_derivatives(error, quartic, "user's potential")
   end subroutine second_derivatives_match_differences

   !> ∇U, its derivative, and that of ∇̄U by γ1 against central differences.
   subroutine check_derivatives(error, potential, label)
      type(error_type), allocatable, intent(inout) :: error
      class(potential_t), intent(in) :: potential
      character(len=*), intent(in) :: label
      real(wp), parameter :: gamma0(3) = [0.3_wp, 0.8_wp, -0.7_wp], gamma1(3) = [-0.2_wp, 0.9_wp, 0.4_wp]
      real(wp) :: h, shift(3), slope(3), hessian(3, 3), mixed(3, 3), between(3), by_start(3, 3), by_end(3, 3)
      integer :: i
      h = eps**(1.0_wp/3)
      slope = potential%gradient(gamma1)
      hessian = potential%hessian(gamma1)
      mixed = potential%discrete_hessian(gamma0, gamma1)
      call potential%linearize(gamma0, gamma1, between, by_start, by_end)
      call check_close(error, between, potential%discrete_gradient(gamma0, gamma1), 4*eps*norm2(between), &
                       label//", discrete gradient with its derivatives")
      call check_below(error, maxval(abs(by_end - mixed)), 8*eps*maxval(abs(mixed)), &
                       label//", derivative with respect to the end")
      call check_below(error, maxval(abs(by_start - potential%discrete_hessian(gamma1, gamma0))), &
                       8*eps*maxval(abs(by_start)), label//", derivative with respect to the start")
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         call check_close(error, slope(i), &
                          (potential%energy(gamma1 + shift) - potential%energy(gamma1 - shift))/(2*h), 5e-9_wp, &
                          label//", gradient")
         call check_close(error, hessian(:, i), &
                          (potential%gradient(gamma1 + shift) - potential%gradient(gamma1 - shift))/(2*h), 5e-9_wp, &
                          label//", Hessian")
         call check_close(error, mixed(:, i), (potential%discrete_gradient(gamma0, gamma1 + shift) &
                                               - potential%discrete_gradient(gamma0, gamma1 - shift))/(2*h), 5e-9_wp, &
                          label//", derivative of the discrete gradient")
         call check_close(error, by_start(:, i), (potential%discrete_gradient(gamma0 + shift, gamma1) &
                                                  - potential%discrete_gradient(gamma0 - shift, gamma1))/(2*h), &
                          5e-9_wp, label//", derivative of the discrete gradient by the start")
      end do
   end subroutine check_derivatives

   !> No direction, no force from the rest length; nothing overflows next to it.
   subroutine spring_of_no_length_is_finite(error)
      type(error_type), allocatable, intent(out) :: error
      type(spring_t) :: spring
      real(wp), parameter :: x(3) = [0.6_wp, -0.5_wp, 0.9_wp], none(3) = 0.0_wp
      real(wp) :: point(3)
      integer :: k
      spring = spring_t(x, x, 5.0_wp, 0.7_wp)
      call check_close(error, spring%gradient(x), none, 0.0_wp, "gradient")
      call check_close(error, pack(spring%discrete_hessian(x, x), .true.), [2.5_wp, none, 2.5_wp, none, 2.5_wp], &
                       0.0_wp, "derivative")
      spring = spring_t(x, x, 5.0_wp)
      call check_close(error, spring%energy(x), 0.0_wp, 4*eps, "energy")
      spring = spring_t(none, none, 5.0_wp, 1e3_wp)
      do k = 0, 320, 20
         point = 10.0_wp**(-k/2)*(10.0_wp**(-(k + 1)/2)*[1.0_wp, 0.0_wp, 0.0_wp])
         call check_below(error, norm2(spring%gradient(point)), 5000*(1 + 4*eps) + 5, "force next to the anchor")
         call check(error, all(abs(spring%hessian(point)) < huge(1.0_wp)), "second derivatives next to the anchor")
      end do
   end subroutine spring_of_no_length_is_finite

   subroutine jacobian_of_each_effect(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(system_t), pointer :: system
      integer :: k
      call samples%load(error)
      if (allocated(error)) return
      do k = 1, size(samples%names)
         system => sample_body()
         call samples%add(system, k)
         call check_jacobian(error, system, 0.0_wp, .true.)
         if (allocated(error)) then
            error%message = trim(samples%names(k))//": "//error%message
            return
         end if
         call check_jacobian(error, system, 0.3_wp, .false.)
      end do
   end subroutine jacobian_of_each_effect

   subroutine jacobian_of_all_effects(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(system_t), pointer :: system
      integer :: k
      call samples%load(error)
      if (allocated(error)) return
      system => sample_body()
      do k = 1, size(samples%names)
         call samples%add(system, k)
      end do
      call check_jacobian(error, system, 0.3_wp, .true.)
   end subroutine jacobian_of_all_effects

end submodule test_effect_gradients
