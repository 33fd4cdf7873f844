!> The z-x-z Euler angles: both ways, at and near the poles, followed over turns, and their rates.
submodule(suites_of_runs) test_euler
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_attitude, only: angular_velocity_from_euler_rates, euler_from_quat, euler_of_motion, follow_euler, &
      quat_from_euler, &
                              unwrap_angle
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: attitude_distance, quat_conjugate, quat_exp, quat_product, rotate_to_body, &
                                rotate_to_space
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

   !> Number of random samples where a test takes any.
   integer, parameter :: samples = 200
   real(wp), parameter :: one(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e1(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e3(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   module procedure collect_euler
      testsuite = [ &
                  new_unittest("Euler angles are rotations about z, x and z", euler_angles_are_z_x_z), &
                  new_unittest("Euler angles place the axes", euler_angles_place_the_axes), &
                  new_unittest("Euler angles come back, close to the poles too", euler_angles_come_back), &
                  new_unittest("Euler angles are in their ranges", euler_angles_are_in_their_ranges), &
                  new_unittest("at the poles the spin is zero", spin_is_zero_at_poles), &
                  new_unittest("a motion from a pole starts with the angles it goes on with", motion_starts_at_pole), &
                  new_unittest("unwrapping takes the nearest revolution", unwrapping_takes_the_nearest_turn), &
                  new_unittest("angles are followed over many revolutions", angles_are_followed_on), &
                  new_unittest("at the poles the spin is kept when following", spin_is_kept_at_poles), &
                  new_unittest("through a pole the angles jump by half a turn", angles_jump_through_a_pole), &
                  new_unittest("through a pole what is defined is continuous", sums_continue_through_poles), &
                  new_unittest("a spin of nearly a turn a step is followed", fast_spin_is_followed), &
                  new_unittest("Euler rates give the angular velocity", euler_rates_give_angular_velocity), &
                  new_unittest("Euler rates agree with differences", euler_rates_agree_with_differences)]
   end procedure collect_euler

   !> Checks that at θ = 0 and π the angles and their rates, given in any way, are found again from attitude and angular
   !> velocity.
   subroutine motion_starts_at_pole(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(3), phi, theta, psi, q(4), omega(3)
      integer :: n
      seed = 35
      do n = 1, samples
         a = pi*random_vector(seed)
         ! θ grows from 0, or falls from π.
         theta = merge(0.0_wp, pi, modulo(n, 2) == 0)
         omega = angular_velocity_from_euler_rates(theta, a(2), a(3), merge(0.3_wp, -0.3_wp, theta < 1), 2.0_wp)
         q = quat_from_euler(a(1), theta, a(2))
         call euler_of_motion(q, omega, phi, theta, psi)
         call check_close(error, quat_from_euler(phi, theta, psi), sign(1.0_wp, dot_product(q, quat_from_euler(phi, &
                          theta, psi)))*q, 8*eps)
         call check_close(error, [cos(phi), sin(phi), cos(psi), sin(psi)], [cos(a(1)), sin(a(1)), cos(a(2)), &
                                                                            sin(a(2))], 32*eps)
      end do
      ! A body that does not leave the pole at once.
      call euler_of_motion(quat_exp(0.4_wp*e3), 5*e3, phi, theta, psi)
      call check_close(error, [phi, theta, psi], [0.8_wp, 0.0_wp, 0.0_wp], 4*eps)
   end subroutine motion_starts_at_pole

   subroutine euler_angles_are_z_x_z(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(3), expected(4)
      integer :: n
      seed = 34
      do n = 1, samples
         a = pi*random_vector(seed)
         expected = quat_product(quat_product(quat_exp(a(1)/2*e3), quat_exp(a(2)/2*e1)), quat_exp(a(3)/2*e3))
         call check_close(error, quat_from_euler(a(1), a(2), a(3)), expected, 4*eps)
      end do
   end subroutine euler_angles_are_z_x_z

   subroutine euler_angles_place_the_axes(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: phi = 0.7_wp, theta = 2.1_wp, psi = -1.9_wp
      real(wp) :: q(4)
      q = quat_from_euler(phi, theta, psi)
      call check_close(error, rotate_to_space(q, e3), &
                       [sin(phi)*sin(theta), -cos(phi)*sin(theta), cos(theta)], 4*eps, "body axis 3 in space")
      call check_close(error, rotate_to_body(q, e3), &
                       [sin(psi)*sin(theta), cos(psi)*sin(theta), cos(theta)], 4*eps, "space axis 3 in the body")
      call check_close(error, rotate_to_space(q, [cos(psi), -sin(psi), 0.0_wp]), &
                       [cos(phi), sin(phi), 0.0_wp], 4*eps, "line of nodes")
   end subroutine euler_angles_place_the_axes

   subroutine euler_angles_come_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: turns(6) = [-3.1_wp, -1.6_wp, -0.1_wp, 0.0_wp, 1.5_wp, 3.1_wp]
      real(wp), parameter :: tilts(7) = [1.0e-14_wp, 1.0e-12_wp, 1.0e-6_wp, 1.0_wp, 2.0_wp, pi - 1.0e-6_wp, &
                                         pi - 1.0e-12_wp]
      real(wp) :: q(4), phi, theta, psi
      integer :: i, j, k
      do i = 1, size(turns)
         do j = 1, size(tilts)
            do k = 1, size(turns)
               q = quat_from_euler(turns(i), tilts(j), turns(k))
               call euler_from_quat(q, phi, theta, psi)
               call check_close(error, theta, tilts(j), 2*eps*tilts(j), "θ")
               call check_close(error, [phi, psi], [turns(i), turns(k)], 8*eps, "φ, ψ")
               call euler_from_quat(-3*q, phi, theta, psi)
               call check_close(error, [phi, theta, psi], [turns(i), tilts(j), turns(k)], 8*eps, "sign and length of q")
            end do
         end do
      end do
   end subroutine euler_angles_come_back

   subroutine euler_angles_are_in_their_ranges(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), phi, theta, psi
      integer :: i, j
      seed = 35
      do i = 1, samples
         ! Multiples of 45 degrees put the angles on the ends of their ranges.
         q = random_unit_quaternion(seed)
         if (i > samples/2) q = anint(2*q)
         if (i == samples) q = 0
         call euler_from_quat(q, phi, theta, psi)
         call check(error, phi > -pi .and. phi <= pi .and. psi > -pi .and. psi <= pi, "φ or ψ out of (-π, π]")
         call check(error, theta >= 0 .and. theta <= pi, "θ out of [0, π]")
         if (i == samples) q = one
         call check_below(error, attitude_distance(quat_from_euler(phi, theta, psi), q), 8*eps, "attitude")
      end do
      do j = -1, 1, 2
         call euler_from_quat(j*[1.0_wp, 0.0_wp, 0.0_wp, -0.0_wp], phi, theta, psi)
         call check_close(error, [phi, theta, psi], [0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, "identity")
         call euler_from_quat(j*[0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], phi, theta, psi)
         call check_close(error, [phi, theta, psi], [pi, 0.0_wp, 0.0_wp], 0.0_wp, "half a turn about 3")
      end do
   end subroutine euler_angles_are_in_their_ranges

   subroutine spin_is_zero_at_poles(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: phi_0 = 0.8_wp, psi_0 = 1.3_wp
      real(wp) :: phi, theta, psi
      call euler_from_quat(quat_from_euler(phi_0, 0.0_wp, psi_0), phi, theta, psi)
      call check_close(error, [phi, theta, psi], [phi_0 + psi_0, 0.0_wp, 0.0_wp], 4*eps, "θ = 0")
      call euler_from_quat(quat_from_euler(phi_0, pi, psi_0), phi, theta, psi)
      call check_close(error, [phi, theta, psi], [phi_0 - psi_0, pi, 0.0_wp], 4*eps, "θ = π")
      ! 2.9 + 1.3 is past π.
      call euler_from_quat(quat_from_euler(2.9_wp, 0.0_wp, psi_0), phi, theta, psi)
      call check_close(error, [phi, theta, psi], [4.2_wp - 2*pi, 0.0_wp, 0.0_wp], 8*eps, "θ = 0, past π")
      call euler_from_quat([0.0_wp, 0.6_wp, -0.8_wp, 0.0_wp], phi, theta, psi)
      call check_close(error, [phi, theta, psi], [2*atan2(-0.8_wp, 0.6_wp), pi, 0.0_wp], 2*eps, "exactly θ = π")
      ! Round-off beside a pole says nothing about φ and ψ separately.
      call euler_from_quat([0.8_wp, -eps/2, eps/2, 0.6_wp], phi, theta, psi)
      call check_close(error, [phi, psi], [2*atan2(0.6_wp, 0.8_wp), 0.0_wp], 2*eps, "round-off")
      call check_close(error, theta, sqrt(2.0_wp)*eps, 4*eps*eps, "θ beside the pole")
   end subroutine spin_is_zero_at_poles

   subroutine unwrapping_takes_the_nearest_turn(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, unwrap_angle([10.0_wp, -10.0_wp, 0.0_wp, 3.0_wp, 3.0_wp], &
                                           [10.0_wp - 4*pi, 4*pi - 9.5_wp, 1.0_wp, -3.0_wp, 3.1_wp]), &
                       [10.0_wp, -9.5_wp, 1.0_wp, 2*pi - 3.0_wp, 3.1_wp], 16*eps)
      call check_close(error, unwrap_angle(2*pi*1.0e10_wp, 0.5_wp), 2*pi*1.0e10_wp + 0.5_wp, 2*pi*1.0e10_wp*eps, "many")
   end subroutine unwrapping_takes_the_nearest_turn

   subroutine angles_are_followed_on(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: t, phi, theta, psi, phi_t, theta_t, psi_t
      integer :: n
      phi = 0
      psi = 0
      do n = 1, 300
         t = 0.1_wp*n
         phi_t = 3*t + 0.5_wp*sin(7*t)
         theta_t = 1 + 0.9_wp*sin(t)
         psi_t = -8*t
         call follow_euler(quat_from_euler(phi_t, theta_t, psi_t), phi, theta, psi)
         ! Half an ulp of the largest angle, 240, is 64 eps, and enters from the sum and the reduction.
         call check_close(error, [phi, theta, psi], [phi_t, theta_t, psi_t], 4*64*eps)
      end do
   end subroutine angles_are_followed_on

   subroutine spin_is_kept_at_poles(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: phi, theta, psi
      phi = 6.0_wp
      psi = 12.5_wp
      call follow_euler(-quat_exp(0.5_wp*e3), phi, theta, psi)
      ! φ + ψ is 1 and whole turns.
      call check_close(error, [phi, theta, psi], [1 - 12.5_wp + 6*pi, 0.0_wp, 12.5_wp], 32*eps, "θ = 0")
      phi = 6.0_wp
      call follow_euler(-quat_product(quat_exp(0.5_wp*e3), [0.0_wp, e1]), phi, theta, psi)
      ! φ - ψ is 1 and whole turns.
      call check_close(error, [phi, theta, psi], [1 + 12.5_wp - 2*pi, pi, 12.5_wp], 32*eps, "θ = π")
   end subroutine spin_is_kept_at_poles

   subroutine angles_jump_through_a_pole(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: q(4), phi, theta, psi, phi_before, psi_before
      integer :: n
      phi = 0
      psi = 0
      phi_before = 0
      psi_before = 0
      do n = 4, -4, -1
         q = quat_from_euler(0.3_wp, 0.1_wp*n, 0.2_wp)
         call follow_euler(q, phi, theta, psi)
         call check_close(error, theta, 0.1_wp*abs(n), eps, "θ")
         call check_below(error, attitude_distance(quat_from_euler(phi, theta, psi), q), 16*eps, "attitude")
         if (n == -1) then
            call check_close(error, abs([phi - phi_before, psi - psi_before]), [pi, pi], 16*eps, "jump")
         else if (n < 4) then
            call check_close(error, [phi, psi], [phi_before, psi_before], 16*eps, "no jump elsewhere")
         end if
         if (allocated(error)) return
         phi_before = phi
         psi_before = psi
      end do
   end subroutine angles_jump_through_a_pole

   !> φ+ψ at θ = 0 and φ-ψ at θ = π, straight through and past the pole at a distance of round-off.
   subroutine sums_continue_through_poles(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), aside(3), phi, theta, psi
      integer :: n, i, pole
      seed = 38
      do i = 1, samples
         pole = mod(i, 2)
         aside = 8*eps*random_vector(seed)
         phi = 0.3_wp
         psi = 0.2_wp
         do n = 4, -4, -1
            q = quat_product(quat_exp(aside), quat_from_euler(0.3_wp, pole*pi + 0.1_wp*n, 0.2_wp))
            call follow_euler(q, phi, theta, psi)
            ! Beside the pole the turn by `aside` adds nothing to the sum, away from it 8 eps/θ.
            call check_close(error, merge(phi - psi, phi + psi, pole == 1), merge(0.1_wp, 0.5_wp, pole == 1), &
                             1000*eps, "what is defined")
         end do
      end do
   end subroutine sums_continue_through_poles

   subroutine fast_spin_is_followed(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: step = 6.0_wp, tilts(3) = [1e-9_wp, 0.01_wp, 2.0_wp]
      real(wp) :: phi, theta, psi
      integer :: n, i
      do i = 1, size(tilts)
         phi = 0
         psi = 0
         do n = 1, 100
            call follow_euler(quat_from_euler(0.1_wp*n, tilts(i), step*n), phi, theta, psi)
            call check_close(error, [phi, psi], [0.1_wp*n, step*n], 600*8*eps, "φ, ψ")
         end do
      end do
   end subroutine fast_spin_is_followed

   subroutine euler_rates_give_angular_velocity(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(3), rate(3), expected(3)
      integer :: n
      seed = 36
      do n = 1, samples
         a = pi*random_vector(seed)
         rate = random_vector(seed)
         ! Each rate about its own axis: space axis 3, line of nodes, body axis 3.
         expected = rate(1)*rotate_to_body(quat_from_euler(a(1), a(2), a(3)), e3) &
                    + rate(2)*rotate_to_body(quat_exp(a(3)/2*e3), e1) + rate(3)*e3
         call check_close(error, angular_velocity_from_euler_rates(a(2), a(3), rate(1), rate(2), rate(3)), expected, &
                          8*eps)
      end do
   end subroutine euler_rates_give_angular_velocity

   subroutine euler_rates_agree_with_differences(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 2.0_wp**(-16)
      integer(int64) :: seed
      real(wp) :: a(3), rate(3), ahead(3), behind(3), q_dot(4), omega(4)
      integer :: n
      seed = 37
      do n = 1, 20
         a = pi*random_vector(seed)
         rate = random_vector(seed)
         ahead = a + h*rate
         behind = a - h*rate
         q_dot = (quat_from_euler(ahead(1), ahead(2), ahead(3)) &
                  - quat_from_euler(behind(1), behind(2), behind(3)))/(2*h)
         ! Ω = 2 q*∘q'
         omega = 2*quat_product(quat_conjugate(quat_from_euler(a(1), a(2), a(3))), q_dot)
         call check_close(error, omega(2:4), &
                          angular_velocity_from_euler_rates(a(2), a(3), rate(1), rate(2), rate(3)), 2*h**2)
      end do
   end subroutine euler_rates_agree_with_differences

end submodule test_euler
