!> The exact top of Lagrange: against 40-digit values, against its own equations and against the free body.
submodule(suites_of_runs) test_exact_top
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_exact_free, only: free_body_t
   use nutate_exact_top, only: lagrange_top_t
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body, rotate_to_space, rotation_matrix
   use nutate_status, only: status_t
   use test_exact_top_reference, only: fastest, moments, prepared, random_sample, rows, sample_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit, &
                           random_unit_quaternion
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: vertical(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   !> The cone of the paper's tops about its tip.
   real(wp), parameter :: cone_j1 = 0.00450622196249286_wp, cone_j3 = 0.000530143760293278_wp
   real(wp), parameter :: cone_mgl = 0.520071028847705_wp

contains

   module procedure collect_exact_top
      testsuite = [ &
         new_unittest("steady precession of the literature", steady_precession_of_the_literature), &
         new_unittest("mean rates of the fast top", mean_rates_of_the_fast_top), &
         new_unittest("heavy top of Brüls, Cardona and Arnold", heavy_top_of_bruls), &
         new_unittest("heavy top of Simo and Wong", heavy_top_of_simo), &
         new_unittest("40-digit values are met in every limit", reference_values_are_met), &
         new_unittest("energy and momenta hold at any time", invariants_hold_at_any_time), &
         new_unittest("the equations of motion are satisfied", equations_of_motion_are_satisfied), &
         new_unittest("a restart continues the motion, backwards too", a_restart_continues_the_motion), &
         new_unittest("the mean rates are those of the motion", mean_rates_are_those_of_the_motion), &
         new_unittest("without gravity it is the free body", without_gravity_it_is_the_free_body), &
         new_unittest("axes and vertical may point anywhere", axes_and_vertical_may_point_anywhere)]
   end procedure collect_exact_top

   !> Energy, momentum about the vertical and about the axis.
   pure function invariants(sample, q, momentum) result(values)
      type(sample_t), intent(in) :: sample
      real(wp), intent(in) :: q(4), momentum(3)
      real(wp) :: values(3), gamma(3)
      gamma = rotate_to_body(q, vertical)
      values(1) = 0.5_wp*sum(momentum**2/moments(sample)) + sample%mgl*gamma(3)
      values(2) = dot_product(momentum, gamma)
      values(3) = momentum(3)
   end function invariants

   subroutine steady_precession_of_the_literature(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      real(wp) :: q(4), momentum(3), precession, spin
      top = prepared(sample_t(cone_j1, cone_j3, cone_mgl, [cos(pi/6), sin(pi/6), 0.0_wp, 0.0_wp], &
         [0.0_wp, 10*cone_j1*sin(pi/3), 140.6_wp*cone_j3]))
      call top%evaluate(1.0_wp, q, momentum)
      call check_close(error, q, [-0.74129324557326555_wp, 0.49974636690044272_wp, 0.015923842809073599_wp, &
         -0.44775475884400627_wp], 1.0e-13_wp, "q(1)")
      call check_close(error, top%tilt(123.0_wp), pi/3, 1.0e-14_wp, "tilt")
      call top%mean_rates(precession, spin)
      call check_close(error, [precession, spin], [10.0_wp, 135.6_wp], 1.0e-12_wp, "rates")
   end subroutine steady_precession_of_the_literature

   subroutine mean_rates_of_the_fast_top(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      real(wp) :: precession, spin
      top = prepared(sample_t(cone_j1, cone_j3, cone_mgl, [cos(pi/6), sin(pi/6), 0.0_wp, 0.0_wp], &
         [0.0_wp, 0.0_wp, 200*cone_j3]))
      call top%mean_rates(precession, spin)
      call check_close(error, [precession, 2*pi/top%nutation_period(), spin], &
         [4.998774_wp, 21.546497_wp, 199.008543_wp], 5.0e-7_wp, "precession, nutation, spin")
      ! The top starts at its highest point; half a nutation later it is at its lowest.
      call check_below(error, top%tilt(0.0_wp), top%tilt(top%nutation_period()/2))
   end subroutine mean_rates_of_the_fast_top

   subroutine heavy_top_of_bruls(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(status_t) :: status
      ! 15 kg at (0, 1, 0): the axis is body axis 2, the moments are those about the pivot.
      real(wp), parameter :: moments(3) = [15.234375_wp, 0.46875_wp, 15.234375_wp]
      real(wp), parameter :: axes(3, 3) = reshape([0, 0, 1, 1, 0, 0, 0, 1, 0]*1.0_wp, [3, 3])
      real(wp), parameter :: times(3) = [0.2_wp, 1.0_wp, 2.0_wp]
      real(wp), parameter :: expected(4, 3) = reshape([ &
         -0.708279152974312562_wp, 0.438781088126581897_wp, 0.545728396145417673_wp, 0.0893997528240050105_wp, &
         0.732943980679663718_wp, -0.278285719337612679_wp, 0.531824611334162618_wp, -0.320176142736249281_wp, &
         0.122947135041533467_wp, -0.491079892550027015_wp, 0.350430030343620962_wp, -0.787986887550485669_wp], [4, 3])
      real(wp) :: q(4), momentum(3)
      integer :: i
      call top%prepare(moments(1), moments(2), 15*9.81_wp, identity, moments*[0.0_wp, 150.0_wp, -4.61538_wp], status, &
         axes)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      do i = 1, size(times)
         call top%evaluate(times(i), q, momentum)
         call check_close(error, q, expected(:, i), 2*eps*150*(1 + times(i)))
      end do
      ! The published figure of this problem: the rate about space axis 2 at t = 2.
      associate (omega => rotate_to_space(q, momentum/moments))
         call check_close(error, omega(2), -106.163804143124448_wp, 1.0e-11_wp, "space rate")
      end associate
   end subroutine heavy_top_of_bruls

   subroutine heavy_top_of_simo(error)
      type(error_type), allocatable, intent(out) :: error
      type(sample_t) :: sample
      type(lagrange_top_t) :: top
      real(wp) :: q(4), momentum(3), values(3)
      sample = sample_t(5.0_wp, 1.0_wp, 20.0_wp, [cos(0.025_wp), sin(0.025_wp), 0.0_wp, 0.0_wp], &
         50*vertical)
      top = prepared(sample)
      call top%evaluate(10.0_wp, q, momentum)
      call check_close(error, q, [0.2438016485933435_wp, 0.0195997964216783492_wp, -0.0187249229592649203_wp, &
         -0.96944622408030772_wp], 1.0e-13_wp, "q(10)")
      values = invariants(sample, q, momentum)
      call check_close(error, values(1), 1269.97500520789932_wp, 1.0e-12_wp, "H")
   end subroutine heavy_top_of_simo

   subroutine reference_values_are_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(sample_t) :: sample
      real(wp) :: q(4), momentum(3), tolerance
      character(len=6) :: label
      integer :: i
      do i = 1, size(rows, 2)
         sample = sample_t(rows(1, i), rows(2, i), rows(3, i), rows(4:7, i), rows(8:10, i))
         top = prepared(sample)
         call top%evaluate(rows(11, i), q, momentum)
         ! One rounding per radian rotated, times what an unstable motion makes of it.
         tolerance = eps*(2 + fastest(sample)*abs(rows(11, i)))*rows(12, i)
         write (label, '("row ",i0)') i
         call check_close(error, q, rows(13:16, i), tolerance, label)
         call check_close(error, momentum, rows(17:19, i), tolerance*norm2(rows(17:19, i)), label)
      end do
   end subroutine reference_values_are_met

   subroutine invariants_hold_at_any_time(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(sample_t) :: sample
      integer(int64) :: seed
      real(wp) :: q(4), momentum(3), t, scales(3)
      integer :: i
      seed = 815_int64
      do i = 1, 500
         sample = random_sample(seed)
         top = prepared(sample)
         t = (random_unit(seed) - 0.5_wp)*10.0_wp**(8*random_unit(seed))
         call top%evaluate(t, q, momentum)
         call check_close(error, norm2(q), 1.0_wp, 4*eps, "norm")
         scales(2:3) = norm2(momentum) + norm2(sample%momentum)
         scales(1) = scales(2)**2/min(sample%j1, sample%j3) + abs(sample%mgl)
         call check_close(error, invariants(sample, q, momentum)/scales, &
            invariants(sample, sample%q0, sample%momentum)/scales, 8*eps, "energy and momenta")
      end do
   end subroutine invariants_hold_at_any_time

   subroutine equations_of_motion_are_satisfied(error)
      type(error_type), allocatable, intent(out) :: error
      ! Central differences of order 8: h**8 of truncation against eps/h of round-off.
      real(wp), parameter :: weight(4) = [4.0_wp/5, -1.0_wp/5, 4.0_wp/105, -1.0_wp/280], h = 0.02_wp
      type(lagrange_top_t) :: top
      type(sample_t) :: sample
      integer(int64) :: seed
      real(wp) :: t, step, q(4), momentum(3), ahead(4), behind(4), l_ahead(3), l_behind(3), q_dot(4), l_dot(3), omega(3)
      integer :: i, k
      seed = 1788_int64
      do i = 1, 100
         sample = random_sample(seed)
         top = prepared(sample)
         t = 20*(random_unit(seed) - 0.5_wp)
         step = h/fastest(sample)
         q_dot = 0
         l_dot = 0
         do k = 1, size(weight)
            call top%evaluate(t + k*step, ahead, l_ahead)
            call top%evaluate(t - k*step, behind, l_behind)
            q_dot = q_dot + weight(k)*(ahead - behind)/step
            l_dot = l_dot + weight(k)*(l_ahead - l_behind)/step
         end do
         call top%evaluate(t, q, momentum)
         omega = momentum/moments(sample)
         call check_close(error, q_dot, 0.5_wp*quat_product(q, [0.0_wp, omega]), 5.0e-11_wp, "kinematics")
         call check_close(error, l_dot, cross(momentum, omega) + cross(rotate_to_body(q, vertical), &
            [0.0_wp, 0.0_wp, sample%mgl]), 5.0e-11_wp, "Euler's equations with gravity")
      end do
   end subroutine equations_of_motion_are_satisfied

   subroutine a_restart_continues_the_motion(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top, again
      type(sample_t) :: sample, later
      integer(int64) :: seed
      real(wp) :: t1, t2, q(4), momentum(3), expected(4), l_expected(3), tolerance
      integer :: i
      seed = 4_int64
      do i = 1, 300
         sample = random_sample(seed)
         later = sample
         top = prepared(sample)
         t1 = 6*(random_unit(seed) - 0.5_wp)
         t2 = 6*(random_unit(seed) - 0.5_wp)
         if (mod(i, 2) == 0) t2 = -t1
         call top%evaluate(t1, later%q0, later%momentum)
         again = prepared(later)
         call again%evaluate(t2, q, momentum)
         call top%evaluate(t1 + t2, expected, l_expected)
         ! An unstable motion amplifies round-off on the way.
         tolerance = 50*eps*(2 + fastest(sample)*(abs(t1) + abs(t2)))
         call check_close(error, q, expected, tolerance, "attitude")
         call check_close(error, momentum, l_expected, tolerance*norm2(l_expected), "momentum")
         if (mod(i, 2) == 0) call check_close(error, q, sample%q0, tolerance, "there and back")
      end do
   end subroutine a_restart_continues_the_motion

   !> After a nutation the top is where it was but for a turn about the vertical and one about its axis.
   subroutine mean_rates_are_those_of_the_motion(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(sample_t) :: sample
      integer(int64) :: seed
      real(wp) :: q(4), momentum(3), precession, spin, turn(2), period
      integer :: i
      seed = 1834_int64
      do i = 1, 200
         sample = random_sample(seed)
         top = prepared(sample)
         period = top%nutation_period()
         call top%mean_rates(precession, spin)
         turn = [precession, spin]*period/2
         call top%evaluate(period, q, momentum)
         call check_close(error, q, quat_product(quat_product([cos(turn(1)), sin(turn(1))*vertical], sample%q0), &
            [cos(turn(2)), sin(turn(2))*vertical]), 40*eps*(2 + fastest(sample)*period))
      end do
   end subroutine mean_rates_are_those_of_the_motion

   subroutine without_gravity_it_is_the_free_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(free_body_t) :: body
      type(status_t) :: status
      type(sample_t) :: sample
      integer(int64) :: seed
      real(wp) :: q(4), momentum(3), expected(4), l_expected(3)
      integer :: i
      seed = 64_int64
      do i = 1, 100
         sample = random_sample(seed)
         sample%mgl = 0
         top = prepared(sample)
         call body%prepare(moments(sample), sample%q0, sample%momentum, status)
         call top%evaluate(-9.0_wp, q, momentum)
         call body%evaluate(-9.0_wp, expected, l_expected)
         call check_close(error, q, expected, 2*eps*(2 + 9*fastest(sample)), "attitude")
         call check_close(error, momentum, l_expected, 4*eps*(2 + 9*fastest(sample))*norm2(momentum), "momentum")
      end do
   end subroutine without_gravity_it_is_the_free_body

   subroutine axes_and_vertical_may_point_anywhere(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top, general
      type(sample_t) :: sample
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: w(4), s(4), axes(3, 3), q(4), momentum(3), q_general(4), l_general(3)
      integer :: i
      seed = 27_int64
      do i = 1, 60
         sample = random_sample(seed)
         w = random_unit_quaternion(seed)
         s = random_unit_quaternion(seed)
         axes = rotation_matrix(w)
         top = prepared(sample)
         if (mod(i, 2) == 0) axes(:, 1) = -axes(:, 1)
         call general%prepare(sample%j1, sample%j3, sample%mgl, &
            quat_product(s, quat_product(sample%q0, quat_conjugate(w))), &
            rotate_to_space(w, sample%momentum), status, axes, 5*rotate_to_space(s, vertical))
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         call top%evaluate(4.0_wp, q, momentum)
         call general%evaluate(4.0_wp, q_general, l_general)
         call check_close(error, q_general, quat_product(s, quat_product(q, quat_conjugate(w))), 500*eps, "attitude")
         call check_close(error, l_general, rotate_to_space(w, momentum), 500*eps*norm2(momentum), "momentum")
      end do
   end subroutine axes_and_vertical_may_point_anywhere

end submodule test_exact_top
