!> Randomised stress test of many bodies: any moments, units and steps, against the exact motion and backwards.
submodule(suites_of_runs) test_bodies_attack
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_bodies, only: bodies_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: attitude_distance, quat_norm, rotate_to_body, rotate_to_space
   use nutate_status, only: status_t
   use test_support, only: check, check_below, draws_fewer, error_type, new_unittest, random_unit, &
      random_unit_quaternion, random_vector
   implicit none

   !> Bodies of one call.
   integer, parameter :: n = 1000

   !> Random data of the bodies.
   type :: draw_t
      real(wp) :: moments(3, n) = 0.0_wp, q(4, n) = 0.0_wp, l(3, n) = 0.0_wp, torque(3, n) = 0.0_wp, dt = 0.0_wp
      !> Δt|Ω|, and Δt(|l| + |Δt τ|)/J: ε of it is the rotation that a rounding of l makes of the thinnest needle.
      real(wp) :: turn(n) = 0.0_wp, stiffness(n) = 0.0_wp
   end type draw_t

contains

   module procedure collect_bodies_attack
      testsuite = [ &
         new_unittest("random drifts are those of the exact motion", random_drifts_are_exact), &
         new_unittest("random steps are reversed", random_steps_are_reversed)]
   end procedure collect_bodies_attack

   !> Calls to make, each with other bodies.
   integer function calls()
      calls = merge(20, 200, draws_fewer())
   end function calls

   !> Bodies of any shape, symmetric, nearly so, flat and needles; moments of 1e-47 to 1e38 kg m²; Δt|Ω| to 30 rad.
   subroutine draw(seed, drawn, classes)
      integer(int64), intent(inout) :: seed
      type(draw_t), intent(inout) :: drawn
      type(body_t), intent(out) :: classes(n)
      type(status_t) :: status
      real(wp) :: r(3), rate(3), unit
      integer :: i
      unit = 10.0_wp**(85*random_unit(seed) - 47)
      drawn%dt = sign(10.0_wp**(20*random_unit(seed) - 12), random_unit(seed) - 0.5_wp)
      do i = 1, n
         r = abs(random_vector(seed))
         select case (int(6*random_unit(seed)))
         case (0)
            r(2) = r(1)
         case (1)
            r(2) = r(1)*(1 + 10.0_wp**(-16*random_unit(seed)))
         case (2)
            r(3) = 0.0_wp
         case (3)
            r(1:2) = r(1:2)*10.0_wp**(-10*random_unit(seed))
         case default
         end select
         r = cshift([r(2) + r(3), r(3) + r(1), r(1) + r(2)]*unit, int(3*random_unit(seed)))
         call make_body(diagonal(r), classes(i), status)
         rate = random_vector(seed)*10.0_wp**(-6*abs(random_vector(seed))*merge(0, 1, random_unit(seed) < 0.5_wp))
         drawn%turn(i) = 10.0_wp**(9.5_wp*random_unit(seed) - 8)
         rate = rate*(drawn%turn(i)/abs(drawn%dt)/norm2(rate))
         drawn%moments(:, i) = r
         drawn%q(:, i) = random_unit_quaternion(seed)
         drawn%l(:, i) = rotate_to_space(drawn%q(:, i), r*rate)
         drawn%torque(:, i) = rotate_to_space(drawn%q(:, i), 0.1_wp*r*random_vector(seed)*(drawn%turn(i)/drawn%dt**2))
         drawn%stiffness(i) = abs(drawn%dt)*(norm2(drawn%l(:, i)) + norm2(drawn%dt*drawn%torque(:, i)))/minval(r)
      end do
   end subroutine draw

   subroutine random_drifts_are_exact(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(draw_t), allocatable :: drawn
      type(body_t), allocatable :: classes(:)
      type(free_body_t) :: exact
      type(status_t) :: status
      real(wp) :: q(4, n), l(3, n), q1(4), momentum(3), rounding
      integer(int64) :: seed
      integer :: i, k
      allocate (drawn, classes(n))
      seed = 31_int64
      do k = 1, calls()
         call draw(seed, drawn, classes)
         call bodies%set_up(classes, status)
         q = drawn%q
         l = drawn%l
         call bodies%drift(drawn%dt, q, l, status, [(i, i=1, n)])
         call check(error, status%ok(), status%message)
         call check(error, all(abs(l - drawn%l) <= 0.0_wp), 'l has changed')
         do i = 1, n
            call exact%prepare(drawn%moments(:, i), drawn%q(:, i), rotate_to_body(drawn%q(:, i), drawn%l(:, i)), status)
            call exact%evaluate(drawn%dt, q1, momentum)
            ! Rounding of the momentum by ε turns a needle the further the thinner it is.
            rounding = 10*eps*(1 + drawn%turn(i) + drawn%stiffness(i))
            call check_below(error, attitude_distance(q(:, i), q1), rounding*(1 + drawn%turn(i)) + &
                             0.03_wp*min(drawn%turn(i), 1.0_wp)**5, 'attitude')
            call check_below(error, abs(energy(drawn, i, q(:, i))/energy(drawn, i, drawn%q(:, i)) - 1), rounding + &
                             20*eps*maxval(drawn%moments(:, i))/minval(drawn%moments(:, i)), 'energy')
            call check_below(error, abs(quat_norm(q(:, i)) - 1), 3*eps, '|q|')
         end do
      end do
   end subroutine random_drifts_are_exact

   !> Kinetic energy of a body, J.
   pure real(wp) function energy(drawn, i, q)
      type(draw_t), intent(in) :: drawn
      integer, intent(in) :: i
      real(wp), intent(in) :: q(4)
      energy = 0.5_wp*sum((rotate_to_body(q, drawn%l(:, i))/sqrt(drawn%moments(:, i)))**2)
   end function energy

   subroutine random_steps_are_reversed(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(draw_t), allocatable :: drawn
      type(body_t), allocatable :: classes(:)
      type(status_t) :: status
      real(wp) :: q(4, n), l(3, n)
      integer(int64) :: seed
      integer :: i, k
      allocate (drawn, classes(n))
      seed = 32_int64
      do k = 1, calls()
         call draw(seed, drawn, classes)
         call bodies%set_up(classes, status)
         q = drawn%q
         l = drawn%l
         call bodies%step(drawn%dt, q, l, drawn%torque, status, [(i, i=1, n)])
         call check(error, status%ok(), status%message)
         call bodies%drift(-drawn%dt, q, l, status, [(i, i=1, n)])
         call bodies%kick(-drawn%dt, q, l, drawn%torque, status, [(i, i=1, n)])
         call check(error, status%ok(), status%message)
         do i = 1, n
            call check_below(error, attitude_distance(q(:, i), drawn%q(:, i)), &
                             100*eps*(1 + drawn%turn(i) + drawn%stiffness(i))*(1 + drawn%turn(i)), 'attitude')
            call check_below(error, norm2(l(:, i) - drawn%l(:, i)), 2*eps*(norm2(drawn%l(:, i)) + &
                             norm2(drawn%l(:, i) + drawn%dt*drawn%torque(:, i))), 'l')
         end do
      end do
   end subroutine random_steps_are_reversed

end submodule test_bodies_attack
