!> Steady precession and the sleeping top in closed form.
submodule(suites_of_runs) test_exact_steady
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_exact_top, only: lagrange_top_t
   use nutate_kinds, only: wp, pi, eps
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use nutate_steady_top, only: sleeping_spin, steady_precession
   use test_support, only: check, check_close, error_type, new_unittest, random_unit
   implicit none

contains

   module procedure collect_exact_steady
      testsuite = [ &
         new_unittest("the paper's top precesses at 10 rad/s", the_papers_top_precesses), &
         new_unittest("both rates satisfy the condition", both_rates_satisfy_the_condition), &
         new_unittest("a top started so keeps its tilt", a_top_started_so_keeps_its_tilt), &
         new_unittest("special cases have their limits", special_cases_have_their_limits), &
         new_unittest("a spin too slow is refused", a_spin_too_slow_is_refused), &
         new_unittest("the sleeping spin is critical", the_sleeping_spin_is_critical)]
   end procedure collect_exact_steady

   subroutine the_papers_top_precesses(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      real(wp), parameter :: j1 = 0.00450622196249286_wp, j3 = 0.000530143760293278_wp, mgl = 0.520071028847705_wp
      real(wp) :: slow, fast
      call steady_precession(j1, j3, mgl, pi/3, 140.6_wp, slow, fast, status)
      call check_close(error, slow, 10.0_wp, 1.0e-13_wp, "for the body rate")
   end subroutine the_papers_top_precesses

   subroutine both_rates_satisfy_the_condition(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: j(2), mgl, theta, rate, slow, fast, phi(2), terms(3)
      integer :: i, k
      seed = 3_int64
      do i = 1, 200
         j = 0.1_wp + [random_unit(seed), random_unit(seed)]
         mgl = random_unit(seed) - 0.5_wp
         theta = pi*random_unit(seed)
         rate = 200*(random_unit(seed) - 0.5_wp)
         call steady_precession(j(1), j(2), mgl, theta, rate, slow, fast, status)
         if (.not. status%ok()) cycle
         phi = [slow, fast]
         do k = 1, 2
            terms = [j(1)*phi(k)**2*cos(theta), -j(2)*rate*phi(k), mgl]
            call check_close(error, sum(terms)/maxval(abs(terms)), 0.0_wp, 8*eps)
         end do
      end do
   end subroutine both_rates_satisfy_the_condition

   subroutine a_top_started_so_keeps_its_tilt(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(status_t) :: status
      real(wp), parameter :: theta = 2.0_wp, j1 = 2.0_wp, j3 = 0.5_wp, mgl = -1.5_wp, omega3 = 7.0_wp
      real(wp) :: slow, fast, precession, spin
      integer :: i
      call steady_precession(j1, j3, mgl, theta, omega3, slow, fast, status)
      do i = 1, 2
         if (i == 2) slow = fast
         call top%prepare(j1, j3, mgl, [cos(theta/2), sin(theta/2), 0.0_wp, 0.0_wp], &
            [0.0_wp, j1*slow*sin(theta), j3*omega3], status)
         call check_close(error, top%tilt(17.0_wp), theta, 8*eps, "tilt")
         call top%mean_rates(precession, spin)
         call check_close(error, [precession, spin], [slow, omega3 - slow*cos(theta)], 40*eps*omega3, "rates")
      end do
   end subroutine a_top_started_so_keeps_its_tilt

   subroutine special_cases_have_their_limits(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      real(wp) :: slow, fast
      call steady_precession(2.0_wp, 1.0_wp, 3.0_wp, pi/2, 6.0_wp, slow, fast, status)
      call check_close(error, [slow, fast], [0.5_wp, huge(1.0_wp)], 4*eps, "horizontal axis")
      call steady_precession(2.0_wp, 1.0_wp, 0.0_wp, pi/3, 6.0_wp, slow, fast, status)
      call check_close(error, [slow, fast], [0.0_wp, 6.0_wp], 8*eps, "no gravity")
      call steady_precession(2.0_wp, 1.0_wp, 3.0_wp, 2*pi/3, 0.0_wp, slow, fast, status)
      call check_close(error, [slow, fast], sqrt(3.0_wp)*[1, -1], 8*eps, "spherical pendulum")
   end subroutine special_cases_have_their_limits

   subroutine a_spin_too_slow_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      real(wp) :: slow, fast
      call steady_precession(2.0_wp, 1.0_wp, 3.0_wp, pi/3, 3.46_wp, slow, fast, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "below 2√3 rad/s")
      call steady_precession(2.0_wp, 1.0_wp, 3.0_wp, pi/3, 3.47_wp, slow, fast, status)
      call check(error, status%ok(), "above 2√3 rad/s")
      call steady_precession(2.0_wp, 0.0_wp, 3.0_wp, pi/3, 5.0_wp, slow, fast, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "no moment")
      call steady_precession(2.0_wp, 1.0_wp, 1.0e200_wp, pi/3, 5.0_wp, slow, fast, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "too large to multiply")
   end subroutine a_spin_too_slow_is_refused

   subroutine the_sleeping_spin_is_critical(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      real(wp) :: slow, fast
      call check_close(error, sleeping_spin(2.0_wp, 0.5_wp, 2.0_wp), 8.0_wp, 8*eps)
      call check_close(error, sleeping_spin(2.0_wp, 0.5_wp, -2.0_wp), 0.0_wp, 0.0_wp, "hanging")
      ! At the critical spin the two precessions of the upright top meet.
      call steady_precession(2.0_wp, 0.5_wp, 2.0_wp, 0.0_wp, sleeping_spin(2.0_wp, 0.5_wp, 2.0_wp), slow, fast, status)
      call check_close(error, slow, fast, 1.0e-6_wp, "the rates meet")
   end subroutine the_sleeping_spin_is_critical

end submodule test_exact_steady
