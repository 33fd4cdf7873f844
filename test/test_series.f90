!> Power series: the recurrences against closed forms, and the torque of every effect against what it is called with.
submodule(suites_of_methods) test_series
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: potential_t, torque_t, GENERAL_SERIES, LINEAR_SERIES, NO_SERIES, SPACE_SERIES, TIME_SERIES
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross, quat_exp, quat_product, rotate_to_body
   use nutate_power_series, only: cosine_term, highest_order, inverses, power_term, product_term
   use nutate_spring, only: spring_t
   use nutate_status, only: status_t
   use test_effect_samples, only: effect_samples_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   !> A turn about an axis fixed in the body, rad per unit of time, and where it starts.
   real(wp), parameter :: rate(3) = [0.3_wp, -0.5_wp, 0.4_wp], start(4) = [0.5_wp, -0.1_wp, 0.7_wp, -0.5_wp]
   !> Times at which a series is compared with the function.
   real(wp), parameter :: times(3) = [-0.5_wp, 0.25_wp, 0.45_wp]
   !> Start, s, and unit of time, s, of the series.
   real(wp), parameter :: t_start = 1.3_wp, time_unit = 0.5_wp

contains

   module procedure collect_series
      testsuite = [ &
                  new_unittest("products, powers and cosines have their known coefficients", known_coefficients), &
                  new_unittest("every effect is the sum of its series", every_effect_is_its_series), &
                  new_unittest("weight and dipole", linear_potentials), &
                  new_unittest("gravity gradient", gravity_gradient_series), &
                  new_unittest("springs: without and with rest length, far and near the anchor", spring_series), &
                  new_unittest("damping", damping_series), &
                  new_unittest("torques fixed in body and space, harmonic in time", applied_torque_series)]
   end procedure collect_series

   !> 1/(1 - s)² and 1/√(1 - s) from 1 - s; cos(a + bs).
   subroutine known_coefficients(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), dimension(0:highest_order) :: base, geometric, root, wave
      real(wp) :: expected
      integer :: k
      base = 0.0_wp
      base(0:1) = [1.0_wp, -1.0_wp]
      geometric = 1.0_wp
      root = 0.0_wp
      root(0) = 1.0_wp
      wave = 0.0_wp
      expected = 1.0_wp
      do k = 0, highest_order
         call check_close(error, product_term(k, geometric, geometric), real(k + 1, wp), 0.0_wp, "product")
         wave(k) = cosine_term(k, 0.4_wp, 1.5_wp, wave)
         call check_close(error, wave(k), cos(0.4_wp + k*acos(0.0_wp))*1.5_wp**k/gamma(real(k + 1, wp)), 8*eps, &
                          "cosine")
         if (k == 0) cycle
         root(k) = power_term(k, -0.5_wp, base, root)
         expected = expected*(2*k - 1)/(2*k)
         call check_close(error, root(k), expected, 8*eps, "root")
      end do
   end subroutine known_coefficients

   !> R(q)ᵀn after a time.
   function rotated(n, s) result(gamma)
      real(wp), intent(in) :: n(3), s
      real(wp) :: gamma(3)
      gamma = rotate_to_body(attitude(s), n)
   end function rotated

   function attitude(s) result(q)
      real(wp), intent(in) :: s
      real(wp) :: q(4)
      q = quat_product(start/norm2(start), quat_exp(0.5_wp*s*rate))
   end function attitude

   !> Series of R(q)ᵀn: γ' = γ×rate.
   function rotated_series(n) result(gamma)
      real(wp), intent(in) :: n(3)
      real(wp) :: gamma(3, 0:highest_order)
      integer :: k
      gamma(:, 0) = rotated(n, 0.0_wp)
      do k = 0, highest_order - 1
         gamma(:, k + 1) = inverses(k + 1)*cross(gamma(:, k), rate)
      end do
   end function rotated_series

   !> Σ termsₖ sᵏ
   pure function total(terms, s) result(value)
      real(wp), intent(in) :: terms(3, 0:highest_order), s
      real(wp) :: value(3)
      integer :: k
      value = terms(:, highest_order)
      do k = highest_order - 1, 0, -1
         value = value*s + terms(:, k)
      end do
   end function total

   !> The series sums up to γ×∇U along the turn.
   subroutine check_potential(error, potential, label)
      type(error_type), allocatable, intent(inout) :: error
      class(potential_t), intent(in) :: potential
      character(len=*), intent(in) :: label
      real(wp), dimension(3, 0:highest_order) :: gamma, terms
      real(wp) :: auxiliary(0:highest_order, potential%auxiliary_series()), expected(3), now(3)
      integer :: k
      if (allocated(error)) return
      gamma = rotated_series(potential%direction)
      do k = 0, highest_order
         if (potential%series_kind() == LINEAR_SERIES) then
            terms(:, k) = cross(potential%series_moment(), gamma(:, k))
         else
            call potential%series_torque(k, gamma(:, 0:k), auxiliary, terms(:, k))
         end if
      end do
      do k = 1, size(times)
         now = rotated(potential%direction, times(k))
         expected = cross(now, potential%gradient(now))
         call check_close(error, total(terms, times(k)), expected, 64*eps*(1 + norm2(expected)), label)
      end do
   end subroutine check_potential

   !> Checks every kind of effect that a scene can name, if it has a series.
   subroutine every_effect_is_its_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      integer :: i
      call samples%load(error)
      do i = 1, samples%n_items
         if (allocated(error)) return
         if (samples%items(i)%effect%series_kind() == NO_SERIES) cycle
         select type (effect => samples%items(i)%effect)
         class is (potential_t)
            call check_potential(error, effect, trim(effect%name))
         class is (torque_t)
            call check_torque(error, effect, trim(effect%name))
         end select
      end do
   end subroutine every_effect_is_its_series

   subroutine linear_potentials(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_body(diagonal([2.0_wp, 3.0_wp, 4.0_wp]), body, status, mass=2.0_wp, &
                     center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
      call check_potential(error, gravity_t(body, [1.0_wp, -2.0_wp, -9.0_wp]), 'gravity')
      call check_potential(error, dipole_t([0.5_wp, -1.0_wp, 2.0_wp], [1.0_wp, 0.5_wp, -0.3_wp]), 'dipole')
   end subroutine linear_potentials

   subroutine gravity_gradient_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     body, status)
      call check_potential(error, gravity_gradient_t(body, [2.0_wp, 2.0_wp, -1.0_wp], 0.4_wp), 'gravity gradient')
   end subroutine gravity_gradient_series

   !> The last spring's anchor lies on the sphere on which its end moves.
   subroutine spring_series(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: x(3) = [0.4_wp, 0.1_wp, -0.6_wp]
      call check_potential(error, spring_t(x, [0.5_wp, 1.0_wp, -0.8_wp], 5.0_wp), 'no rest length')
      call check_potential(error, spring_t(x, [1.5_wp, 2.0_wp, -0.8_wp], 5.0_wp, 0.7_wp), 'far')
      call check_potential(error, spring_t(x, -norm2(x)*[0.6_wp, 0.8_wp, 0.0_wp], 5.0_wp, 0.7_wp), 'near')
   end subroutine spring_series

   !> The series sums up to τ(t, q, Ω) along the turn, with a rate that is a polynomial of time.
   subroutine check_torque(error, torque, label)
      type(error_type), allocatable, intent(inout) :: error
      class(torque_t), intent(in) :: torque
      character(len=*), intent(in) :: label
      real(wp), dimension(3, 0:highest_order) :: omega, gamma, terms
      real(wp) :: auxiliary(0:highest_order, torque%auxiliary_series()), expected(3), actual(3)
      integer :: k
      if (allocated(error)) return
      gamma = rotated_series(torque%series_direction())
      if (torque%moves) gamma = moved_series(torque)
      omega = 0.0_wp
      omega(:, 0) = [1.0_wp, -2.0_wp, 3.0_wp]
      omega(:, 1) = [0.5_wp, 0.25_wp, -0.125_wp]
      omega(:, 3) = [-0.25_wp, 1.0_wp, 0.5_wp]
      do k = 0, highest_order
         if (torque%series_kind() == LINEAR_SERIES) then
            terms(:, k) = matmul(torque%series_drag(), omega(:, k))
         else
            call torque%series_torque(k, t_start, time_unit, omega(:, 0:k), gamma(:, 0:k), auxiliary, terms(:, k))
         end if
      end do
      do k = 1, size(times)
         expected = torque%torque(t_start + time_unit*times(k), attitude(times(k)), total(omega, times(k)))
         actual = total(terms, times(k))
         if (torque%series_kind() == SPACE_SERIES) actual = rotate_to_body(attitude(times(k)), actual)
         call check_close(error, actual, expected, 64*eps*(1 + norm2(expected)), label)
      end do
   end subroutine check_torque

   !> γ = R(q)ᵀn of a direction that moves: the product of the series of both.
   function moved_series(torque) result(gamma)
      class(torque_t), intent(in) :: torque
      real(wp), dimension(3, 0:highest_order) :: gamma, n, row
      integer :: i, j, k
      call torque%direction_series(t_start, time_unit, n)
      gamma = 0.0_wp
      do i = 1, 3
         row = rotated_series(merge(1.0_wp, 0.0_wp, [1, 2, 3] == i))
         do k = 0, highest_order
            do j = 0, k
               gamma(:, k) = gamma(:, k) + row(:, k - j)*n(i, j)
            end do
         end do
      end do
   end function moved_series

   subroutine damping_series(error)
      type(error_type), allocatable, intent(out) :: error
      call check_torque(error, damping_t([0.1_wp, 0.2_wp, 0.3_wp]), 'damping')
   end subroutine damping_series

   subroutine applied_torque_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(applied_torque_t) :: torque
      torque%amplitude = [0.5_wp, 1.0_wp, -1.0_wp]
      call check_torque(error, torque, 'constant')
      torque%frequency = 0.7_wp
      torque%phase = 0.4_wp
      call check_torque(error, torque, 'harmonic')
      call check(error, torque%series_kind(), TIME_SERIES)
      call check_all_at_once(error, torque)
      torque%in_space = .true.
      call check_torque(error, torque, 'harmonic in space')
      call check(error, torque%series_kind(), GENERAL_SERIES)
   end subroutine applied_torque_series

   !> The series as a whole is that of the coefficients one by one.
   subroutine check_all_at_once(error, torque)
      type(error_type), allocatable, intent(inout) :: error
      class(torque_t), intent(in) :: torque
      real(wp) :: one(0:highest_order, 2), all(0:highest_order, 2), tau(3), series(3, 0:8)
      real(wp), parameter :: none(3, 0:8) = 0.0_wp
      integer :: k
      call torque%time_series(0.3_wp, 0.7_wp, all, series)
      do k = 0, 8
         call torque%series_torque(k, 0.3_wp, 0.7_wp, none(:, 0:k), none(:, 0:k), one, tau)
         call check_close(error, series(:, k), tau, 0.0_wp, 'torque')
         call check_close(error, [all(k, 1)], [one(k, 1)], 0.0_wp, 'cosine')
      end do
   end subroutine check_all_at_once

end submodule test_series
