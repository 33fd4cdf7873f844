!> The paper's statements: how long steps change periods of box and tops.
submodule(suites_of_runs) test_paper
   use nutate_kinds, only: wp, pi
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: rotate_to_space
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, box, fast_top, precessing_top, problem_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_paper
      testsuite = [ &
                  new_unittest("half period of the box at four steps", half_period_of_the_box), &
                  new_unittest("box period shrinks by 8 % from step 0.01 to 0.1", box_period_shrinks), &
                  new_unittest("precession of the steady top errs by second order", precession_of_steady_top), &
                  new_unittest("precession of the nutating top errs by second order", precession_of_nutating_top)]
   end procedure collect_paper

   subroutine half_period_of_the_box(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(4) = [0.1_wp, 0.05_wp, 0.025_wp, 0.01_wp]
      real(wp), parameter :: expected(4) = [1.7754_wp, 1.8937_wp, 1.9230_wp, 1.9313_wp]
      integer :: i
      do i = 1, 4
         call check_close(error, half_period(steps(i)), expected(i), 0.5e-4_wp, "half period")
      end do
   end subroutine half_period_of_the_box

   subroutine box_period_shrinks(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, 100*(1 - half_period(0.1_wp)/half_period(0.01_wp)), 8.07_wp, 0.005_wp, "per cent")
   end subroutine box_period_shrinks

   !> Mean time between zeros of Ω₃ over 20 s, each found by a polynomial of degree 5 through the six nearest steps.
   real(wp) function half_period(dt)
      real(wp), intent(in) :: dt
      type(problem_t), pointer :: problem
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: omega3(0:2000), omega(3), first, last
      integer :: i, n, crossings
      problem => box()
      state = problem%start
      n = nint(20/dt)
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      do i = 0, n
         omega = angular_velocity(problem%system, state)
         omega3(i) = omega(3)
         call stepper%step(problem%system, state, dt, status)
      end do
      crossings = 0
      first = 0.0_wp
      last = 0.0_wp
      do i = 2, n - 3
         if (omega3(i)*omega3(i + 1) > 0.0_wp) cycle
         last = dt*(i - 2 + zero_of_polynomial(omega3(i - 2:i + 3)))
         if (crossings == 0) first = last
         crossings = crossings + 1
      end do
      half_period = (last - first)/(crossings - 1)
   end function half_period

   !> Returns the zero of the polynomial through (0,y0), (1,y1), ..., (5,y5) between 2 and 3.
   real(wp) function zero_of_polynomial(y) result(x)
      real(wp), intent(in) :: y(0:5)
      real(wp) :: low, high
      integer :: i
      low = 2.0_wp
      high = 3.0_wp
      do i = 1, 50
         x = 0.5_wp*(low + high)
         if (lagrange(y, x)*y(2) > 0.0_wp) then
            low = x
         else
            high = x
         end if
      end do
   end function zero_of_polynomial

   !> Value at x of the polynomial through (0,y0), ..., (5,y5).
   real(wp) function lagrange(y, x)
      real(wp), intent(in) :: y(0:5), x
      real(wp) :: term
      integer :: i, j
      lagrange = 0.0_wp
      do i = 0, 5
         term = y(i)
         do j = 0, 5
            if (j /= i) term = term*(x - j)/(i - j)
         end do
         lagrange = lagrange + term
      end do
   end function lagrange

   subroutine precession_of_steady_top(error)
      type(error_type), allocatable, intent(out) :: error
      ! Exact by construction; the published factor on (Ω₃Δt)²/12 is 1.22.
      call check_precession(error, precessing_top(), 140.6_wp, 10.0_wp, 1.22_wp)
   end subroutine precession_of_steady_top

   subroutine precession_of_nutating_top(error)
      type(error_type), allocatable, intent(out) :: error
      ! Exact from Lagrange's solution by elliptic functions; factor 0.86.
      call check_precession(error, fast_top(), 200.0_wp, 4.998774_wp, 0.86_wp)
   end subroutine precession_of_nutating_top

   !> Relative period error factor·(Ω₃Δt)²/12 with the factor in [0.6, 1.6] and as published within 0.02, of order
   !> 2.00 ± 0.05.
   subroutine check_precession(error, problem, omega3, exact, factor)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: omega3, exact, factor
      real(wp) :: errors(3), dt, found
      integer :: i
      do i = 1, 3
         dt = 0.2_wp/omega3/2**(i - 1)
         errors(i) = exact/mean_precession(problem, dt) - 1
         found = 12*errors(i)/(omega3*dt)**2
         call check(error, abs(found) > 0.6_wp .and. abs(found) < 1.6_wp, "factor out of range")
         call check_close(error, abs(found), factor, 0.02_wp, "factor")
      end do
      call check_close(error, log(errors(1:2)/errors(2:3))/log(2.0_wp), [2.0_wp, 2.0_wp], 0.05_wp, "order")
   end subroutine check_precession

   !> Mean rate over 8 s at which the top's axis turns about the vertical, weighted by a window (1 - cos)² that
   !> suppresses nutation.
   real(wp) function mean_precession(problem, dt)
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: before(3), axis(3), weight, total
      integer :: i, n
      state = problem%start
      n = nint(8/dt)
      total = 0.0_wp
      mean_precession = 0.0_wp
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      axis = rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp])
      do i = 1, n
         before = axis
         call stepper%step(problem%system, state, dt, status)
         axis = rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp])
         weight = (1 - cos(2*pi*(i - 0.5_wp)/n))**2
         mean_precession = mean_precession + weight*atan2(before(1)*axis(2) - before(2)*axis(1), &
                                                          before(1)*axis(1) + before(2)*axis(2))
         total = total + weight*dt
      end do
      mean_precession = mean_precession/total
   end function mean_precession

end submodule test_paper
