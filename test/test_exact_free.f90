!> The exact free body: against 40-digit values, in every limit, over a million periods, and against its own equations.
submodule(suites_of_runs) test_exact_free
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_product, rotate_to_space, rotation_matrix
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   use test_exact_free_reference, only: long_rows, long_start, short_rows
   use test_support, only: check, check_close, error_type, new_unittest, random_unit, random_unit_quaternion, &
                           random_vector
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_exact_free
      testsuite = [ &
         new_unittest("literature values are met", literature_values_are_met), &
         new_unittest("the paper's box has its period", the_papers_box_has_its_period), &
         new_unittest("40-digit values are met in every branch and limit", reference_values_are_met), &
         new_unittest("40-digit values are met after a million periods", a_million_periods_keep_the_phase), &
         new_unittest("the separatrix is hyperbolic from however far out", the_separatrix_is_hyperbolic), &
         new_unittest("energy, momentum and norm hold at any time", invariants_hold_at_any_time), &
         new_unittest("the equations of motion are satisfied", equations_of_motion_are_satisfied), &
         new_unittest("a restart continues the motion, backwards too", a_restart_continues_the_motion), &
         new_unittest("almost equal moments move like equal ones", almost_equal_moments_move_like_equal_ones), &
         new_unittest("steady rotations are steady", steady_rotations_are_steady), &
         new_unittest("the order of the axes does not matter", order_of_axes_does_not_matter), &
         new_unittest("principal axes may lie anywhere", principal_axes_may_lie_anywhere), &
         new_unittest("units do not matter", units_do_not_matter), &
         new_unittest("absurd times and states do no harm", absurd_times_and_states_do_no_harm), &
         new_unittest("what is not a body or a state is refused", bad_input_is_refused)]
   end procedure collect_exact_free

   !> A body that must be accepted; a refused one stays at rest, which fails the checks of its motion.
   subroutine prepared(body, moments, q0, momentum0)
      type(free_body_t), intent(out) :: body
      real(wp), intent(in) :: moments(3), q0(4), momentum0(3)
      type(status_t) :: status
      call body%prepare(moments, q0, momentum0, status)
   end subroutine prepared

   !> Fastest rate of a body (rad/s): the unit of turns.
   pure real(wp) function fastest(moments, momentum)
      real(wp), intent(in) :: moments(3), momentum(3)
      fastest = norm2(momentum)/minval(moments)
   end function fastest

   !> A body with moments in any order, now and then almost symmetric, and a momentum.
   subroutine random_body(seed, moments, momentum)
      integer(int64), intent(inout) :: seed
      real(wp), intent(out) :: moments(3), momentum(3)
      integer :: i
      do i = 1, 3
         moments(i) = 0.3_wp + random_unit(seed)
      end do
      if (random_unit(seed) < 0.3_wp) moments(2) = moments(1)*(1 + 1.0e-4_wp*random_unit(seed)**12)
      momentum = random_vector(seed)
   end subroutine random_body

   subroutine literature_values_are_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp) :: q(4), momentum(3), moments(3)
      call prepared(body, [0.6_wp, 0.8_wp, 1.0_wp], identity, [1.8_wp, 0.4_wp, -0.9_wp])
      call body%evaluate(10.0_wp, q, momentum)
      call check_close(error, q, [-0.736061364160793936_wp, -0.570786951240350733_wp, -0.299388571830790094_wp, &
         -0.206839086104673192_wp], 1.0e-13_wp, "rigid body of Hairer and Vilmart")
      call prepared(body, [0.345_wp, 0.653_wp, 1.0_wp], identity, [1.8_wp, 0.4_wp, -0.9_wp])
      call body%evaluate(10.0_wp, q, momentum)
      call check_close(error, q, [-0.590953130059877682_wp, 0.749777146603624299_wp, -0.27756735059869179_wp, &
         -0.107540663867132049_wp], 1.0e-13_wp, "water molecule of Hairer and Vilmart")
      moments = 10.0_wp/12*[0.97_wp, 0.82_wp, 0.17_wp]
      call prepared(body, moments, identity, moments*[0.1_wp, 5.0_wp, 0.1_wp])
      call body%evaluate(10.0_wp, q, momentum)
      call check_close(error, q, [0.22516456341395816_wp, -0.61992756249945249_wp, -0.27702915068719459_wp, &
         0.69874572364031014_wp], 1.0e-12_wp, "box of the simulator comparison")
   end subroutine literature_values_are_met

   subroutine the_papers_box_has_its_period(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp) :: q(4), momentum(3)
      call prepared(body, [5.0_wp, 20.0_wp, 17.0_wp], identity, [0.5_wp, 0.0_wp, 170.0_wp])
      call check_close(error, body%period()/2, 1.93282_wp, 1.0e-5_wp, "half period")
      call body%evaluate(body%period()/2, q, momentum)
      call check_close(error, momentum/170, [0.5_wp/170, 0.0_wp, -1.0_wp], 200*eps, "after half a period")
   end subroutine the_papers_box_has_its_period

   subroutine reference_values_are_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp) :: q(4), momentum(3), tolerance
      character(len=6) :: label
      integer :: i
      do i = 1, size(short_rows, 2)
         associate (moments => short_rows(1:3, i), start => short_rows(4:6, i), t => short_rows(7, i))
            call prepared(body, moments, identity, start)
            call body%evaluate(t, q, momentum)
            ! One rounding per radian rotated, times what an unstable motion makes of it.
            tolerance = eps*(2 + fastest(moments, start)*abs(t))*short_rows(8, i)
            write (label, '("row ",i0)') i
            call check_close(error, q, short_rows(9:12, i), tolerance, label)
            call check_close(error, momentum/norm2(start), short_rows(13:15, i)/norm2(start), tolerance, label)
         end associate
      end do
   end subroutine reference_values_are_met

   subroutine a_million_periods_keep_the_phase(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp) :: q(4), momentum(3), tolerance
      integer :: i
      do i = 1, size(long_rows, 2)
         associate (moments => long_start(1:3, i), start => long_start(4:6, i), t => long_rows(1, i))
            call prepared(body, moments, identity, start)
            tolerance = eps*fastest(moments, start)*abs(t)
            call check_close(error, 1.0e6_wp*body%period(), abs(t), 4*eps*abs(t), "period")
            call body%evaluate(t, q, momentum)
            call check_close(error, q, long_rows(2:5, i), tolerance, "attitude")
            call check_close(error, momentum/norm2(start), long_rows(6:8, i)/norm2(start), tolerance, "momentum")
            ! The phase may lose digits with the turns; the invariants may not.
            call check_close(error, rotate_to_space(q, momentum), start, 8*eps*norm2(start), "space momentum")
         end associate
      end do
   end subroutine a_million_periods_keep_the_phase

   !> J = 1, 3/2, 3 and L = (h, 1, h): L₂ = B tanh u, L₁ = L₃ = B sech u / √2, B = |L|, u̇ = B/3.
   subroutine the_separatrix_is_hyperbolic(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp) :: h, b, u, q(4), momentum(3), expected(3)
      integer :: i
      do i = 0, 400, 8
         h = 2.0_wp**(-i)
         b = sqrt(1 + 2*h**2)
         call prepared(body, [1.0_wp, 1.5_wp, 3.0_wp], identity, [h, 1.0_wp, h])
         ! The interval goes from next to one saddle to next to the other.
         u = -asinh(1/(sqrt(2.0_wp)*h))/2
         call body%evaluate(3*(u + 2*u)/b, q, momentum)
         expected = b*[1/(sqrt(2.0_wp)*cosh(u)), tanh(u), 1/(sqrt(2.0_wp)*cosh(u))]
         call check_close(error, momentum, expected, 4*eps*(1 + abs(u)), "momentum")
         call check_close(error, body%period(), huge(1.0_wp), 0.0_wp, "no period")
      end do
   end subroutine the_separatrix_is_hyperbolic

   subroutine invariants_hold_at_any_time(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      integer(int64) :: seed
      real(wp) :: moments(3), start(3), q0(4), q(4), momentum(3), t
      integer :: i
      seed = 4711_int64
      do i = 1, 500
         call random_body(seed, moments, start)
         q0 = random_unit_quaternion(seed)
         call prepared(body, moments, q0, start)
         t = (random_unit(seed) - 0.5_wp)*10.0_wp**(8*random_unit(seed))
         call body%evaluate(t, q, momentum)
         call check_close(error, norm2(q), 1.0_wp, 4*eps, "norm")
         call check_close(error, rotate_to_space(q, momentum), rotate_to_space(q0, start), 12*eps*norm2(start), "l")
         call check_close(error, sum(momentum**2/moments)/sum(start**2/moments), 1.0_wp, 12*eps, "energy")
      end do
   end subroutine invariants_hold_at_any_time

   subroutine equations_of_motion_are_satisfied(error)
      type(error_type), allocatable, intent(out) :: error
      ! Central differences of order 8: h**8 of truncation against eps/h of round-off.
      real(wp), parameter :: weight(4) = [4.0_wp/5, -1.0_wp/5, 4.0_wp/105, -1.0_wp/280], h = 0.02_wp
      type(free_body_t) :: body
      integer(int64) :: seed
      real(wp) :: moments(3), start(3), t, step, q(4), momentum(3), ahead(4), behind(4), l_ahead(3), l_behind(3)
      real(wp) :: q_dot(4), l_dot(3)
      integer :: i, k
      seed = 99_int64
      do i = 1, 100
         call random_body(seed, moments, start)
         call prepared(body, moments, random_unit_quaternion(seed), start)
         t = 20*(random_unit(seed) - 0.5_wp)
         step = h/fastest(moments, start)
         q_dot = 0
         l_dot = 0
         do k = 1, size(weight)
            call body%evaluate(t + k*step, ahead, l_ahead)
            call body%evaluate(t - k*step, behind, l_behind)
            q_dot = q_dot + weight(k)*(ahead - behind)/step
            l_dot = l_dot + weight(k)*(l_ahead - l_behind)/step
         end do
         call body%evaluate(t, q, momentum)
         associate (omega => momentum/moments)
            call check_close(error, l_dot, cross(momentum, omega), 1.0e-11_wp, "Euler's equations")
            call check_close(error, q_dot, 0.5_wp*quat_product(q, [0.0_wp, omega]), 1.0e-11_wp, "kinematics")
         end associate
      end do
   end subroutine equations_of_motion_are_satisfied

   subroutine a_restart_continues_the_motion(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body, again
      integer(int64) :: seed
      real(wp) :: moments(3), start(3), q0(4), t1, t2, q1(4), l1(3), q(4), momentum(3), expected(4), l_expected(3)
      integer :: i
      seed = 31337_int64
      do i = 1, 300
         call random_body(seed, moments, start)
         q0 = random_unit_quaternion(seed)
         call prepared(body, moments, q0, start)
         t1 = 6*(random_unit(seed) - 0.5_wp)
         t2 = 6*(random_unit(seed) - 0.5_wp)
         if (mod(i, 2) == 0) t2 = -t1
         call body%evaluate(t1, q1, l1)
         call prepared(again, moments, q1, l1)
         call again%evaluate(t2, q, momentum)
         call body%evaluate(t1 + t2, expected, l_expected)
         ! An unstable motion amplifies round-off by at most exp(|Ω| t) on the way.
         call check_close(error, q, expected, 400*eps, "attitude")
         call check_close(error, momentum, l_expected, 400*eps, "momentum")
         if (mod(i, 2) == 0) call check_close(error, q, q0, 400*eps, "there and back")
      end do
   end subroutine a_restart_continues_the_motion

   subroutine almost_equal_moments_move_like_equal_ones(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: gap = 4*eps, t = 1000, odd_moment(4) = [2.0_wp, 3.0_wp, 0.5_wp, 2.0_wp]
      type(free_body_t) :: equal, almost
      real(wp) :: q(4), momentum(3), expected(4), l_expected(3), moments(3)
      integer :: i, k
      do i = 1, 12
         ! Spheres, flat and long bodies; the odd axis, the sign of the gap and the momentum vary.
         k = 1 + mod(i, 3)
         moments = 2
         moments(k) = odd_moment(1 + (i - k)/3)
         call prepared(equal, moments, identity, [1.0_wp, 2.0_wp, -2.0_wp])
         moments(1 + mod(k, 3)) = 2*(1 + gap*(-1)**i)
         call prepared(almost, moments, identity, [1.0_wp, 2.0_wp, -2.0_wp])
         call equal%evaluate(t, expected, l_expected)
         call almost%evaluate(t, q, momentum)
         ! The gap itself turns the body by gap Ω t.
         call check_close(error, q, expected, 4*gap*fastest(moments, l_expected)*t, "attitude")
         call check_close(error, momentum, l_expected, 12*gap*fastest(moments, l_expected)*t, "momentum")
      end do
   end subroutine almost_equal_moments_move_like_equal_ones

   subroutine steady_rotations_are_steady(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      ! J and L: each principal axis, the middle one too; a sphere; the equator of a symmetric body; rest.
      real(wp), parameter :: rows(6, 7) = reshape([ &
         1.0_wp, 2.0_wp, 3.0_wp, 1.5_wp, 0.0_wp, 0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp, 0.0_wp, -1.5_wp, 0.0_wp, &
         1.0_wp, 2.0_wp, 3.0_wp, 0.0_wp, 0.0_wp, 1.5_wp, 2.0_wp, 2.0_wp, 2.0_wp, 1.0_wp, -2.0_wp, 3.0_wp, &
         2.0_wp, 2.0_wp, 3.0_wp, 1.0_wp, -2.0_wp, 0.0_wp, 2.0_wp, 1.0_wp, 2.0_wp, 3.0_wp, 0.0_wp, 1.0_wp, &
         1.0_wp, 2.0_wp, 3.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [6, 7])
      real(wp) :: q0(4), q(4), momentum(3)
      integer(int64) :: seed
      integer :: i
      seed = 8_int64
      do i = 1, size(rows, 2)
         associate (moments => rows(1:3, i), start => rows(4:6, i))
            q0 = random_unit_quaternion(seed)
            call prepared(body, moments, q0, start)
            call body%evaluate(-12.5_wp, q, momentum)
            call check_close(error, q, quat_product(q0, quat_exp(-6.25_wp*start/moments)), 8*eps, "attitude")
            call check_close(error, [momentum, body%period()], [start, 0.0_wp], 0.0_wp, "momentum")
         end associate
      end do
   end subroutine steady_rotations_are_steady

   subroutine order_of_axes_does_not_matter(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body, cycled
      integer(int64) :: seed
      real(wp) :: moments(3), start(3), q(4), momentum(3), q_cycled(4), l_cycled(3)
      integer :: i
      seed = 12_int64
      do i = 1, 60
         call random_body(seed, moments, start)
         call prepared(body, moments, identity, start)
         call prepared(cycled, cshift(moments, 1), identity, cshift(start, 1))
         call body%evaluate(7.0_wp, q, momentum)
         call cycled%evaluate(7.0_wp, q_cycled, l_cycled)
         call check_close(error, q_cycled, [q(1), cshift(q(2:4), 1)], 100*eps, "attitude")
         call check_close(error, l_cycled, cshift(momentum, 1), 100*eps, "momentum")
      end do
   end subroutine order_of_axes_does_not_matter

   subroutine principal_axes_may_lie_anywhere(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body, general
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: moments(3), start(3), w(4), axes(3, 3), q(4), momentum(3), q_general(4), l_general(3)
      integer :: i
      seed = 2718_int64
      do i = 1, 60
         call random_body(seed, moments, start)
         w = random_unit_quaternion(seed)
         axes = rotation_matrix(w)
         call prepared(body, moments, w, start)
         ! Every other case reverses one of the axes: a left-handed set.
         if (mod(i, 2) == 0) axes(:, 1 + mod(i, 3)) = -axes(:, 1 + mod(i, 3))
         call general%prepare(moments, identity, matmul(rotation_matrix(w), start), status, axes)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         call body%evaluate(-5.0_wp, q, momentum)
         call general%evaluate(-5.0_wp, q_general, l_general)
         call check_close(error, q_general, quat_product(q, quat_conjugate(w)), 100*eps, "attitude")
         call check_close(error, l_general, matmul(rotation_matrix(w), momentum), 100*eps, "momentum")
      end do
   end subroutine principal_axes_may_lie_anywhere

   subroutine units_do_not_matter(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: inertia = 2.0_wp**(-150), second = 2.0_wp**(-40)
      type(free_body_t) :: body, molecule
      real(wp) :: q(4), momentum(3), q_molecule(4), l_molecule(3)
      call prepared(body, [0.345_wp, 0.653_wp, 1.0_wp], identity, [1.8_wp, 0.4_wp, -0.9_wp])
      call prepared(molecule, inertia*[0.345_wp, 0.653_wp, 1.0_wp], identity, inertia/second*[1.8_wp, 0.4_wp, -0.9_wp])
      call body%evaluate(10.0_wp, q, momentum)
      call molecule%evaluate(10.0_wp*second, q_molecule, l_molecule)
      call check_close(error, [q_molecule, l_molecule*second/inertia], [q, momentum], 0.0_wp)
   end subroutine units_do_not_matter

   subroutine absurd_times_and_states_do_no_harm(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      real(wp), parameter :: times(6) = [0.0_wp, 1.0e-300_wp, 600.0_wp, -1.0e12_wp, 1.0e17_wp, -1.0e308_wp]
      real(wp), parameter :: starts(3, 5) = reshape([1.0e-160_wp, 1.0_wp, 1.0e-170_wp, 1.0e-200_wp, 1.0_wp, 0.0_wp, &
         1.0_wp, 1.0e-300_wp, 0.0_wp, 1.0e-310_wp, 1.0e-310_wp, 1.0e-320_wp, 1.0e200_wp, 1.0e200_wp, -1.0e200_wp], &
         [3, 5])
      real(wp) :: q(4), momentum(3), unit
      integer :: i, k
      do i = 1, size(starts, 2)
         call prepared(body, [1.0_wp, 2.0_wp, 3.0_wp], identity, starts(:, i))
         do k = 1, size(times)
            call body%evaluate(times(k), q, momentum)
            call check_close(error, norm2(q), 1.0_wp, 4*eps, "norm")
            unit = maxval(starts(:, i))
            call check_close(error, norm2(momentum/unit), norm2(starts(:, i)/unit), 1.0e-6_wp, "momentum, denormal too")
         end do
      end do
   end subroutine absurd_times_and_states_do_no_harm

   subroutine bad_input_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(free_body_t) :: body
      type(status_t) :: status
      real(wp), parameter :: ones(3) = 1
      call body%prepare([1.0_wp, 0.0_wp, 2.0_wp], identity, ones, status)
      call check(error, status%code, NUTATE_BAD_BODY, "a moment is zero")
      call body%prepare([1.0_wp, 1.0e-70_wp, 2.0_wp], identity, ones, status)
      call check(error, status%code, NUTATE_BAD_BODY, "moments too far apart")
      call body%prepare([1.0_wp, 1.5_wp, 2.0_wp], 0*identity, ones, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "no attitude")
      call body%prepare([1.0_wp, 1.5_wp, 2.0_wp], identity, 1.0e300_wp*ones, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "too much momentum")
      call body%prepare([1.0_wp, 1.5_wp, 2.0_wp], identity, ones, status, reshape(spread(ones, 2, 3), [3, 3]))
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "axes not orthonormal")
   end subroutine bad_input_is_refused

end submodule test_exact_free
