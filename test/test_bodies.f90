!> Many bodies with torques of the caller: what a step conserves, its order, which bodies fail, and its bits.
submodule(suites_of_runs) test_bodies
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_bodies, only: bodies_t, BODY_MOMENTUM, BODY_RATE, SPACE_MOMENTUM
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: attitude_distance, cross, quat_norm, rotate_to_body, rotate_to_space, rotation_matrix
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_NOT_FINITE
   use test_support, only: check, check_below, check_close, draws_fewer, error_type, new_unittest, random_unit, &
      random_unit_quaternion, random_vector
   implicit none

   !> Two dipoles beside each other on the x axis: moments of inertia, and dipole moments, body axes.
   real(wp), parameter :: inertia(3, 2) = reshape([1.0_wp, 2.0_wp, 2.5_wp, 1.5_wp, 0.9_wp, 1.8_wp], [3, 2])
   real(wp), parameter :: dipole(3, 2) = reshape([0.0_wp, 0.6_wp, 0.8_wp, 1.0_wp, 0.2_wp, 0.0_wp], [3, 2])

contains

   module procedure collect_bodies
      testsuite = [ &
         new_unittest("a drift keeps energy and momentum", a_drift_keeps_energy_and_momentum), &
         new_unittest("a drift is of order 4", a_drift_is_of_order_4), &
         new_unittest("a drift is symplectic up to the fifth power of the step", a_drift_is_almost_symplectic), &
         new_unittest("a step changes the momentum by its impulse", a_step_changes_the_momentum_by_its_impulse), &
         new_unittest("steps are of order 2", steps_are_of_order_2), &
         new_unittest("friction is of order 2 by the momentum of the attitude", friction_is_of_order_2), &
         new_unittest("the energy of two dipoles does not drift", energy_of_two_dipoles_does_not_drift), &
         new_unittest("1000 steps are reversed to round-off", steps_are_reversed_to_round_off), &
         new_unittest("no unit and no needle is out of reach", no_unit_is_out_of_reach), &
         new_unittest("long steps are exact", long_steps_are_exact), &
         new_unittest("body axes and angular velocities are the same motion", frames_are_the_same_motion), &
         new_unittest("an inertia tensor moves as its principal moments do", tensors_move_as_their_moments), &
         new_unittest("bodies that fail are listed and keep their state", bodies_that_fail_are_listed), &
         new_unittest("bits depend on no neighbour and no thread", bits_depend_on_no_neighbour), &
         new_unittest("wrong calls change nothing", wrong_calls_change_nothing)]
   end procedure collect_bodies

   !> Bodies of one class each.
   subroutine set_up(bodies, moments, frame)
      type(bodies_t), intent(inout) :: bodies
      !> Shape (3, number of classes).
      real(wp), intent(in) :: moments(:, :)
      integer, intent(in), optional :: frame
      type(body_t) :: classes(size(moments, 2))
      type(status_t) :: status
      integer :: i
      do i = 1, size(classes)
         call make_body(diagonal(moments(:, i)), classes(i), status)
      end do
      call bodies%set_up(classes, status, frame)
   end subroutine set_up

   !> Moments of a body that satisfies the triangle rule, now and then symmetric, flat or a needle.
   subroutine draw_moments(seed, moments)
      integer(int64), intent(inout) :: seed
      real(wp), intent(out) :: moments(3)
      real(wp) :: r(3)
      r = abs(random_vector(seed))
      select case (int(5*random_unit(seed)))
      case (0)
         r(2) = r(1)
      case (1)
         r(3) = 0.0_wp
      case (2)
         r(1:2) = r(1:2)*10.0_wp**(-8*random_unit(seed))
      case default
      end select
      moments = [r(2) + r(3), r(3) + r(1), r(1) + r(2)]
   end subroutine draw_moments

   !> Kinetic energy of a body by its space momentum.
   pure real(wp) function kinetic(moments, q, l)
      real(wp), intent(in) :: moments(3), q(4), l(3)
      real(wp) :: momentum(3)
      momentum = rotate_to_body(q, l)
      kinetic = 0.5_wp*sum(momentum**2/moments)
   end function kinetic

   subroutine a_drift_keeps_energy_and_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n = 50, steps = 1000
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: moments(3, n), q(4, n), l(3, n), l0(3, n), energy(n)
      integer(int64) :: seed
      integer :: i
      seed = 11_int64
      do i = 1, n
         call draw_moments(seed, moments(:, i))
         q(:, i) = random_unit_quaternion(seed)
         l(:, i) = rotate_to_space(q(:, i), moments(:, i)*random_vector(seed))
         energy(i) = kinetic(moments(:, i), q(:, i), l(:, i))
      end do
      call set_up(bodies, moments)
      l0 = l
      do i = 1, steps
         call bodies%drift(0.1_wp, q, l, status, [(i, i=1, n)])
      end do
      call check(error, status%ok(), status%message)
      call check(error, all(abs(l - l0) <= 0.0_wp), 'a drift changed l')
      do i = 1, n
         ! Round-off of L, in a needle's momentum along its axis too, which adds up as the square root.
         call check_close(error, kinetic(moments(:, i), q(:, i), l(:, i))/energy(i), 1.0_wp, &
                          2*eps*sqrt(real(steps, wp))*maxval(moments(:, i))/minval(moments(:, i)), 'energy')
         call check_close(error, quat_norm(q(:, i)), 1.0_wp, 2*eps, '|q|')
      end do
   end subroutine a_drift_keeps_energy_and_momentum

   subroutine a_drift_is_of_order_4(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3) = [1.0_wp, 2.0_wp, 2.5_wp], end_time = 4.0_wp
      type(bodies_t) :: bodies
      type(free_body_t) :: exact
      type(status_t) :: status
      real(wp) :: q(4, 1), l(3, 1), q1(4), momentum(3), distance(2)
      integer :: i, k, n
      call set_up(bodies, reshape(moments, [3, 1]))
      call exact%prepare(moments, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.4_wp, 1.3_wp, -0.7_wp], status)
      call exact%evaluate(end_time, q1, momentum)
      do k = 1, 2
         n = 20*2**k
         q(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         l(:, 1) = [0.4_wp, 1.3_wp, -0.7_wp]
         do i = 1, n
            call bodies%drift(end_time/n, q, l, status)
         end do
         distance(k) = attitude_distance(q(:, 1), q1)
      end do
      call check_close(error, distance(1)/distance(2), 16.0_wp, 0.5_wp, 'ratio of errors')
      call check_below(error, distance(2), 1e-6_wp, 'error')
   end subroutine a_drift_is_of_order_4

   subroutine a_drift_is_almost_symplectic(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: lost(2)
      lost = [lost_of_the_form(0.4_wp), lost_of_the_form(0.2_wp)]
      call check_close(error, lost(1)/lost(2), 32.0_wp, 1.5_wp, 'ratio of changes')
      call check_below(error, lost(1), 1e-4_wp, 'change of the symplectic form')
   end subroutine a_drift_is_almost_symplectic

   !> Largest change of ω(a, b) = ξ_a·δl_b - ξ_b·δl_a - l·(ξ_a×ξ_b) in a drift, for variations along the axes of space:
   !> rotations ξ of the attitude, and δl. By central differences.
   real(wp) function lost_of_the_form(dt) result(lost)
      real(wp), intent(in) :: dt
      real(wp), parameter :: change = 1e-5_wp, momentum(3) = [0.4_wp, 1.3_wp, -0.7_wp]
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: q(4, 12), l(3, 12), rotation(3, 6), impulse(3, 6), start(3, 6), rotated(4, 2), unit(3)
      integer :: i, k
      call set_up(bodies, inertia(:, 1:1))
      start = 0.0_wp
      impulse = 0.0_wp
      do i = 1, 6
         unit = 0.0_wp
         unit(1 + modulo(i - 1, 3)) = 1.0_wp
         do k = 1, 2
            q(:, 2*i - 2 + k) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
            l(:, 2*i - 2 + k) = momentum
            if (i < 4) then
               q(2:4, 2*i - 2 + k) = (3 - 2*k)*0.5_wp*change*unit
               q(:, 2*i - 2 + k) = q(:, 2*i - 2 + k)/norm2(q(:, 2*i - 2 + k))
               start(:, i) = unit
            else
               l(:, 2*i - 2 + k) = momentum + (3 - 2*k)*change*unit
               impulse(:, i) = unit
            end if
         end do
      end do
      call bodies%drift(dt, q, l, status)
      do i = 1, 6
         ! ξ = 2 δq∘q*, vector part.
         rotated = q(:, 2*i - 1:2*i)
         unit = cross(rotated(2:4, 2), rotated(2:4, 1)) + rotated(1, 2)*rotated(2:4, 1) - rotated(1, 1)*rotated(2:4, 2)
         rotation(:, i) = unit/change
      end do
      lost = 0.0_wp
      do i = 2, 6
         do k = 1, i - 1
            lost = max(lost, abs(form(rotation, i, k) - form(start, i, k)))
         end do
      end do

   contains

      pure real(wp) function form(turns, a, b)
         real(wp), intent(in) :: turns(3, 6)
         integer, intent(in) :: a, b
         form = dot_product(turns(:, a), impulse(:, b)) - dot_product(turns(:, b), impulse(:, a)) - &
                dot_product(momentum, cross(turns(:, a), turns(:, b)))
      end function form

   end function lost_of_the_form

   subroutine a_step_changes_the_momentum_by_its_impulse(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: q(4, 20), l(3, 20), torque(3, 20), expected(3, 20), kicked(3, 20), q0(4, 20)
      integer(int64) :: seed
      integer :: i
      seed = 12_int64
      do i = 1, 20
         q(:, i) = random_unit_quaternion(seed)
         l(:, i) = random_vector(seed)
         torque(:, i) = random_vector(seed)
      end do
      call set_up(bodies, inertia)
      expected = l + 0.1_wp*torque
      q0 = q
      kicked = l
      call bodies%kick(0.1_wp, q, kicked, torque, status)
      call check(error, all(abs(q - q0) <= 0.0_wp) .and. all(abs(kicked - expected) <= 0.0_wp), 'kick')
      call bodies%drift(0.1_wp, q0, kicked, status)
      call bodies%step(0.1_wp, q, l, torque, status)
      call check(error, all(abs(l - expected) <= 0.0_wp), 'step')
      call check(error, all(abs(q - q0) <= 0.0_wp), 'a step is a kick and a drift')
   end subroutine a_step_changes_the_momentum_by_its_impulse

   !> Torques of two dipoles on each other, space axes, and their energy.
   pure subroutine find_dipole_torques(q, torque, energy)
      real(wp), intent(in) :: q(4, 2)
      real(wp), intent(out) :: torque(3, 2), energy
      real(wp) :: moment(3, 2), field(3)
      integer :: i
      do i = 1, 2
         moment(:, i) = rotate_to_space(q(:, i), dipole(:, i))
      end do
      do i = 1, 2
         field = [2.0_wp, -1.0_wp, -1.0_wp]*moment(:, 3 - i)
         torque(:, i) = cross(moment(:, i), field)
      end do
      energy = -dot_product(moment(:, 2), field)
   end subroutine find_dipole_torques

   pure subroutine start_dipoles(q, l)
      real(wp), intent(out) :: q(4, 2), l(3, 2)
      q = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.6_wp, 0.0_wp, 0.8_wp, 0.0_wp], [4, 2])
      l = reshape([0.4_wp, 1.3_wp, -0.7_wp, -0.3_wp, 0.9_wp, 1.1_wp], [3, 2])
   end subroutine start_dipoles

   !> Moves the dipoles by n steps from a state with q and l at one time to another.
   subroutine move_dipoles(dt, n, q, l)
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      real(wp), intent(inout) :: q(4, 2), l(3, 2)
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: torque(3, 2), energy
      integer :: i
      call set_up(bodies, inertia)
      call find_dipole_torques(q, torque, energy)
      call bodies%kick(-0.5_wp*dt, q, l, torque, status, [1, 2])
      do i = 1, n
         call bodies%step(dt, q, l, torque, status, [1, 2])
         call find_dipole_torques(q, torque, energy)
      end do
      call bodies%kick(0.5_wp*dt, q, l, torque, status, [1, 2])
   end subroutine move_dipoles

   subroutine steps_are_of_order_2(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: q(4, 2, 4), l(3, 2)
      integer :: k
      do k = 1, 4
         call start_dipoles(q(:, :, k), l)
         call move_dipoles(2.0_wp/(50*2**k), 50*2**k, q(:, :, k), l)
      end do
      do k = 1, 2
         call check_close(error, maxval(abs(q(:, :, k) - q(:, :, k + 1)))/ &
                          maxval(abs(q(:, :, k + 1) - q(:, :, k + 2))), 4.0_wp, 0.05_wp, 'ratio of differences')
      end do
   end subroutine steps_are_of_order_2

   !> Largest and mean error of the energy, in ten parts of a run.
   subroutine measure_energy(dt, n, largest, means)
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      real(wp), intent(out) :: largest, means(10)
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: q(4, 2), l(3, 2), middle(3, 2), torque(3, 2), energy, first, difference
      integer :: i, k, part
      call set_up(bodies, inertia)
      call start_dipoles(q, l)
      call find_dipole_torques(q, torque, energy)
      first = energy + kinetic(inertia(:, 1), q(:, 1), l(:, 1)) + kinetic(inertia(:, 2), q(:, 2), l(:, 2))
      call bodies%kick(-0.5_wp*dt, q, l, torque, status, [1, 2])
      largest = 0.0_wp
      means = 0.0_wp
      do i = 1, n
         call bodies%step(dt, q, l, torque, status, [1, 2])
         call find_dipole_torques(q, torque, energy)
         middle = l + 0.5_wp*dt*torque
         do k = 1, 2
            energy = energy + kinetic(inertia(:, k), q(:, k), middle(:, k))
         end do
         difference = energy - first
         largest = max(largest, abs(difference))
         part = 1 + int((10*int(i - 1, int64))/n)
         means(part) = means(part) + 10*difference/n
      end do
   end subroutine measure_energy

   !> The motion is chaotic. If the drift is the reduced step, the means go to 2E-2.
   subroutine energy_of_two_dipoles_does_not_drift(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: coarse, fine, means(10)
      integer :: n
      n = merge(100000, 1000000, draws_fewer())
      call measure_energy(0.05_wp, n, coarse, means)
      call check_below(error, coarse, 5e-3_wp, 'largest error')
      call check_below(error, maxval(means) - minval(means), 0.05_wp*coarse, 'spread of the means')
      call measure_energy(0.01_wp, 1000, fine, means)
      call measure_energy(0.02_wp, 500, coarse, means)
      call check_close(error, coarse/fine, 4.0_wp, 0.05_wp, 'order of the energy')
   end subroutine energy_of_two_dipoles_does_not_drift

   subroutine steps_are_reversed_to_round_off(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: q(4, 2), l(3, 2), q0(4, 2), l0(3, 2)
      call start_dipoles(q0, l0)
      q = q0
      l = l0
      call move_dipoles(0.01_wp, 1000, q, l)
      call check(error, maxval(abs(q - q0)) > 0.1_wp, 'the bodies stood still')
      call move_dipoles(-0.01_wp, 1000, q, l)
      ! The motion multiplies a rounding by some tens over this time.
      call check_close(error, reshape(q, [8]), reshape(q0, [8]), 5000*eps, 'q')
      call check_close(error, reshape(l, [6]), reshape(l0, [6]), 5000*eps, 'l')
   end subroutine steps_are_reversed_to_round_off

   !> Powers of two for units of mass and time change no digit; moments of molecules and planets.
   subroutine no_unit_is_out_of_reach(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: moments(3, 3), unit, second, q(4, 3), l(3, 3), torque(3, 3), q1(4, 3)
      integer :: i, k, powers(3)
      powers = [0, -156, 126]
      moments = reshape([1.0_wp, 2.0_wp, 2.5_wp, 1e-9_wp, 1.0_wp, 1.0_wp, 2e-6_wp, 1.0_wp, 1.000001_wp], [3, 3])
      do k = 1, 3
         unit = 2.0_wp**powers(k)
         second = 2.0_wp**(powers(k)/4)
         ! In body axes: a torque across a needle would turn it about its axis at once.
         call set_up(bodies, moments*unit, BODY_MOMENTUM)
         do i = 1, 3
            q(:, i) = [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp]
            l(:, i) = moments(:, i)*[1.0_wp, 0.3_wp, -0.5_wp]*(unit/second)
            torque(:, i) = moments(:, i)*[-0.2_wp, 0.1_wp, 0.3_wp]*(unit/second**2)
         end do
         do i = 1, 100
            call bodies%step(0.1_wp*second, q, l, torque, status, [1, 2, 3])
         end do
         call check(error, status%ok(), status%message)
         if (k == 1) q1 = q
         call check(error, all(abs(q - q1) <= 0.0_wp), 'a power of two changed a digit')
      end do
   end subroutine no_unit_is_out_of_reach

   !> One long step against many short ones.
   subroutine long_steps_are_exact(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n = 40
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: moments(3, n), q(4, n), l(3, n), q1(4, n), rate(3)
      integer(int64) :: seed
      integer :: i, k, parts
      seed = 13_int64
      parts = merge(1400, 4000, draws_fewer())
      do i = 1, n
         moments(:, i) = 1 + random_vector(seed)/3
         q(:, i) = random_unit_quaternion(seed)
         rate = random_vector(seed)
         rate = rate*((1 + 8*random_unit(seed))/norm2(rate))
         l(:, i) = rotate_to_space(q(:, i), moments(:, i)*rate)
      end do
      call set_up(bodies, moments)
      q1 = q
      call bodies%drift(1.0_wp, q, l, status, [(i, i=1, n)])
      do k = 1, parts
         call bodies%drift(1.0_wp/parts, q1, l, status, [(i, i=1, n)])
      end do
      do i = 1, n
         call check_below(error, attitude_distance(q(:, i), q1(:, i)), 1e-9_wp*(4000.0_wp/parts)**4, 'attitude')
      end do
   end subroutine long_steps_are_exact

   !> Checks that the same bodies move alike by momenta in space axes, in body axes, and by angular velocities; short
   !> and long steps.
   subroutine frames_are_the_same_motion(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n = 20, frames(3) = [SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE]
      type(bodies_t) :: bodies(3)
      type(status_t) :: status
      real(wp) :: moments(3, n), q(4, n, 3), l(3, n, 3), torque(3, n, 3), spin
      integer(int64) :: seed
      integer :: i, k
      seed = 14_int64
      do i = 1, n
         call draw_moments(seed, moments(:, i))
         moments(:, i) = moments(:, i) + 0.5_wp
         q(:, i, 1) = random_unit_quaternion(seed)
         spin = 10.0_wp**(2*random_unit(seed) - 1)
         l(:, i, 3) = spin*random_vector(seed)
         l(:, i, 2) = moments(:, i)*l(:, i, 3)
         l(:, i, 1) = rotate_to_space(q(:, i, 1), l(:, i, 2))
         torque(:, i, 2) = random_vector(seed)
         torque(:, i, 1) = rotate_to_space(q(:, i, 1), torque(:, i, 2))
         torque(:, i, 3) = torque(:, i, 2)
         q(:, i, 2) = q(:, i, 1)
         q(:, i, 3) = q(:, i, 1)
      end do
      do k = 1, 3
         call set_up(bodies(k), moments, frames(k))
         call bodies(k)%step(0.2_wp, q(:, :, k), l(:, :, k), torque(:, :, k), status, [(i, i=1, n)])
         call check(error, status%ok(), status%message)
      end do
      do i = 1, n
         call check_close(error, q(:, i, 2), q(:, i, 1), 50*eps, 'q by body axes')
         call check_close(error, q(:, i, 3), q(:, i, 1), 50*eps, 'q by rates')
         call check_close(error, l(:, i, 2), rotate_to_body(q(:, i, 1), l(:, i, 1)), 50*eps*norm2(l(:, i, 1)), 'l')
         call check_close(error, l(:, i, 3)*moments(:, i), l(:, i, 2), 50*eps*norm2(l(:, i, 1)), 'rate')
      end do
   end subroutine frames_are_the_same_motion

   subroutine tensors_move_as_their_moments(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3) = [1.0_wp, 2.0_wp, 2.5_wp]
      integer, parameter :: frames(3) = [SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE]
      type(bodies_t) :: straight, tilted
      type(body_t) :: classes(2)
      type(status_t) :: status
      real(wp) :: tilt(3, 3), q(4, 2), l(3, 2), torque(3, 2), ql(3), qt(3)
      integer(int64) :: seed
      integer :: k, i
      seed = 15_int64
      do k = 1, 3
         tilt = rotation_matrix(random_unit_quaternion(seed))
         call make_body(matmul(tilt, matmul(diagonal(moments), transpose(tilt))), classes(1), status)
         call make_body(diagonal(moments), classes(2), status)
         call tilted%set_up(classes, status, frames(k))
         call set_up(straight, reshape(moments, [3, 1]), frames(k))
         ! Body axes of the tensor along those of space; the principal axes are those of the other body.
         do i = 1, 2
            q(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
            q(:, 2) = quat_of(tilt)
            ql = merge(0.3_wp, 30.0_wp, i == 1)*random_vector(seed)
            qt = random_vector(seed)
            l(:, 1) = ql
            torque(:, 1) = qt
            l(:, 2) = ql
            torque(:, 2) = qt
            if (frames(k) /= SPACE_MOMENTUM) then
               l(:, 2) = matmul(ql, tilt)
               torque(:, 2) = matmul(qt, tilt)
            end if
            call tilted%step(0.2_wp, q(:, 1:1), l(:, 1:1), torque(:, 1:1), status)
            call check(error, status%ok(), status%message)
            call straight%step(0.2_wp, q(:, 2:2), l(:, 2:2), torque(:, 2:2), status)
            call check_close(error, reshape(matmul(rotation_matrix(q(:, 1)), tilt), [9]), &
                             reshape(rotation_matrix(q(:, 2)), [9]), 100*eps, 'attitude')
            if (frames(k) /= SPACE_MOMENTUM) &
               call check_close(error, matmul(l(:, 1), tilt), l(:, 2), 200*eps*norm2(l(:, 2)), 'momentum')
         end do
      end do
   contains
      function quat_of(matrix) result(q)
         use nutate_attitude, only: quat_from_matrix
         real(wp), intent(in) :: matrix(3, 3)
         real(wp) :: q(4)
         q = quat_from_matrix(matrix)
      end function quat_of
   end subroutine tensors_move_as_their_moments

   subroutine bodies_that_fail_are_listed(error)
      type(error_type), allocatable, intent(out) :: error
      call list_the_failed(error, SPACE_MOMENTUM)
      call list_the_failed(error, BODY_MOMENTUM)
      call list_the_failed(error, BODY_RATE)
   end subroutine bodies_that_fail_are_listed

   subroutine list_the_failed(error, frame)
      type(error_type), allocatable, intent(inout) :: error
      integer, intent(in) :: frame
      integer, parameter :: n = 20000, broken(9) = [3, 16, 17, 33, 40, 5000, 16384, 16385, 20000]
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp), allocatable :: q(:, :), l(:, :), torque(:, :), q1(:, :), l1(:, :)
      integer, allocatable :: class_of(:)
      integer :: i
      allocate (q(4, n), l(3, n), torque(3, n), class_of(n))
      do i = 1, n
         q(:, i) = [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp]
         l(:, i) = [0.3_wp, 0.1_wp, -0.2_wp]
         torque(:, i) = [0.1_wp, 0.2_wp, 0.3_wp]
         class_of(i) = 1 + modulo(i, 2)
      end do
      call set_up(bodies, inertia, frame)
      q1 = q
      l1 = l
      call bodies%step(0.1_wp, q1, l1, torque, status, class_of)
      call check(error, status%ok() .and. size(bodies%failed) == 0, 'all move')
      torque(2, 3) = ieee_value(1.0_wp, ieee_quiet_nan)
      torque(1, 16) = ieee_value(1.0_wp, ieee_positive_inf)
      l(3, 17) = ieee_value(1.0_wp, ieee_quiet_nan)
      q(1, 33) = ieee_value(1.0_wp, ieee_quiet_nan)
      l(2, 40) = 9.9e99_wp
      torque(2, 40) = 9.9e99_wp
      q(:, 5000) = 0.50001_wp
      class_of(16384) = 3
      class_of(16385) = 0
      l(1, 20000) = 1e10_wp
      q1(:, broken) = q(:, broken)
      l1(:, broken) = l(:, broken)
      call bodies%step(0.1_wp, q, l, torque, status, class_of)
      call check(error, status%code, NUTATE_NOT_FINITE)
      call check(error, index(status%message, '9 of 20000 bodies kept their state, the first is 3 (expected') == 1, &
                 status%message)
      call check(error, size(bodies%failed), size(broken))
      if (allocated(error)) return
      call check(error, all(bodies%failed == broken), 'others failed')
      ! The bits are compared, since a NaN is not equal to any number.
      call check(error, all(transfer(q, [1_int64]) == transfer(q1, [1_int64])), 'q')
      call check(error, all(transfer(l, [1_int64]) == transfer(l1, [1_int64])), 'l')
   end subroutine list_the_failed

   !> Friction -c l, which the how-to guide passes in three ways: as it is, the mean over the kick, and evaluated twice.
   !> Exact: l exp(-ct).
   subroutine friction_is_of_order_2(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: coarse(3), fine(3)
      coarse = [friction_error(1, 40), friction_error(2, 40), friction_error(3, 40)]
      fine = [friction_error(1, 80), friction_error(2, 80), friction_error(3, 80)]
      call check_close(error, coarse/fine, [2.0_wp, 4.0_wp, 4.0_wp], 0.15_wp, 'errors by halved steps')
   end subroutine friction_is_of_order_2

   !> Error of the momentum after 2 s.
   real(wp) function friction_error(way, n)
      integer, intent(in) :: way
      !> Steps.
      integer, intent(in) :: n
      real(wp), parameter :: c = 0.5_wp, start(3) = [0.4_wp, 1.3_wp, -0.7_wp]
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp) :: dt, q(4, 1), l(3, 1)
      integer :: i
      dt = 2.0_wp/n
      call set_up(bodies, inertia)
      q(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      l(:, 1) = start
      call bodies%kick(-0.5_wp*dt, q, l, -c*l, status)
      do i = 1, n
         call bodies%step(dt, q, l, friction(l), status)
      end do
      call bodies%kick(0.5_wp*dt, q, l, friction(l), status)
      friction_error = norm2(l(:, 1) - start*exp(-2*c))
   contains
      function friction(l) result(torque)
         real(wp), intent(in) :: l(:, :)
         real(wp) :: torque(3, 1)
         select case (way)
         case (1)
            torque = -c*l
         case (2)
            torque = -c*l/(1 + c*dt/2)
         case default
            torque = -c*l
            torque = -c*(l + 0.5_wp*dt*torque)
         end select
      end function friction
   end function friction_error

   !> Bodies alone, among others and by several threads, fast and slow ones side by side.
   subroutine bits_depend_on_no_neighbour(error)
      type(error_type), allocatable, intent(out) :: error
      call compare_bits(error, SPACE_MOMENTUM)
      call compare_bits(error, BODY_MOMENTUM)
      call compare_bits(error, BODY_RATE)
   end subroutine bits_depend_on_no_neighbour

   subroutine compare_bits(error, frame)
      type(error_type), allocatable, intent(inout) :: error
      integer, intent(in) :: frame
      integer, parameter :: n = 5000
      type(bodies_t) :: bodies
      type(status_t) :: status
      real(wp), allocatable :: q(:, :, :), l(:, :, :), torque(:, :)
      integer :: class_of(n), i, k
      integer(int64) :: seed
      allocate (q(4, n, 0:4), l(3, n, 0:4), torque(3, n))
      seed = 16_int64
      do i = 1, n
         q(:, i, 0) = random_unit_quaternion(seed)
         l(:, i, 0) = random_vector(seed)*10.0_wp**(4*random_unit(seed) - 3)
         torque(:, i) = random_vector(seed)
         class_of(i) = 1 + int(2*random_unit(seed))
      end do
      call set_up(bodies, inertia, frame)
      do k = 1, 3
         bodies%threads = k
         q(:, :, k) = q(:, :, 0)
         l(:, :, k) = l(:, :, 0)
         call bodies%step(0.1_wp, q(:, :, k), l(:, :, k), torque, status, class_of)
         call check(error, status%ok(), status%message)
      end do
      q(:, :, 4) = q(:, :, 0)
      l(:, :, 4) = l(:, :, 0)
      do i = 1, n
         call bodies%step(0.1_wp, q(:, i:i, 4), l(:, i:i, 4), torque(:, i:i), status, class_of(i:i))
      end do
      do k = 2, 4
         call check(error, all(abs(q(:, :, k) - q(:, :, 1)) <= 0.0_wp) .and. &
                    all(abs(l(:, :, k) - l(:, :, 1)) <= 0.0_wp), 'other bits')
      end do
   end subroutine compare_bits

   subroutine wrong_calls_change_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(body_t) :: classes(1), none(0)
      type(status_t) :: status
      real(wp) :: q(4, 2), l(3, 2), q0(4, 2), torque(3, 2)
      call start_dipoles(q, l)
      q0 = q
      torque = 0.0_wp
      call bodies%step(0.1_wp, q, l, torque, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'not set up')
      call bodies%set_up(none, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'no class')
      call bodies%set_up(classes, status)
      call check(error, status%code, NUTATE_BAD_BODY, 'not made')
      call make_body(diagonal(inertia(:, 1)), classes(1), status)
      call bodies%set_up(classes, status, 3)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'frame')
      call bodies%set_up(classes, status)
      call check(error, status%ok(), status%message)
      call bodies%step(0.0_wp, q, l, torque, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'no step')
      call bodies%step(ieee_value(1.0_wp, ieee_quiet_nan), q, l, torque, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'NaN')
      call bodies%step(0.1_wp, q, l(:, 1:1), torque, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'shape of l')
      call bodies%step(0.1_wp, q, l, torque(:, 1:1), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'shape of torque')
      call bodies%drift(0.1_wp, q, l, status, [1])
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'shape of class_of')
      call check(error, all(abs(q - q0) <= 0.0_wp), 'q has changed')
      call bodies%drift(0.1_wp, q(:, 1:0), l(:, 1:0), status)
      call check(error, status%ok(), 'no bodies')
   end subroutine wrong_calls_change_nothing

end submodule test_bodies
