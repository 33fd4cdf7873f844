!> The exact top of Lagrange where it is delicate: next to the vertical, on the separatrix, at the ends of the range.
submodule(suites_of_runs) test_exact_top_limits
   use nutate_exact_top, only: lagrange_top_t
   use nutate_kinds, only: wp, eps
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   use test_exact_top_reference, only: prepared, sample_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_exact_top_limits
      testsuite = [ &
         new_unittest("a start next to the vertical is exact", a_start_next_to_the_vertical_is_exact), &
         new_unittest("the separatrix of the pendulum is met", separatrix_of_the_pendulum_is_met), &
         new_unittest("a sleeping top sleeps, a slow one falls", a_sleeping_top_sleeps), &
         new_unittest("absurd times and states do no harm", absurd_times_and_states_do_no_harm), &
         new_unittest("what is not a top or a state is refused", bad_input_is_refused)]
   end procedure collect_exact_top_limits

   !> Checks initial states next to the vertical, where precession and spin swing by half a revolution in a moment;
   !> their sum and difference must not change.
   subroutine a_start_next_to_the_vertical_is_exact(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      real(wp), parameter :: start(3) = [1.0e-6_wp, 0.125_wp, 3.0_wp]
      real(wp) :: q(4), momentum(3), tilt
      integer :: i
      do i = 1, 30
         tilt = 10.0_wp**(-0.5_wp*i)
         top = prepared(sample_t(2.0_wp, 1.0_wp, 3.0_wp*(-1)**i, [1.0_wp, tilt, tilt/2, 0.0_wp], start))
         call top%evaluate(0.0_wp, q, momentum)
         call check_close(error, momentum, start, 4*eps, "momentum")
         call check_close(error, q(2:3)/q(1), [tilt, tilt/2], 4*eps*tilt, "attitude")
      end do
   end subroutine a_start_next_to_the_vertical_is_exact

   !> Thrown from the bottom so that it just reaches the top: tan(θ/2) = 1/sinh(t √(m g l/J₁)).
   subroutine separatrix_of_the_pendulum_is_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      real(wp), parameter :: hanging(4) = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      real(wp) :: t
      integer :: i
      top = prepared(sample_t(1.0_wp, 1.0_wp, 1.0_wp, hanging, [2.0_wp, 0.0_wp, 0.0_wp]))
      do i = -30, 30
         t = i
         call check_close(error, top%tilt(t), 2*atan2(1.0_wp, abs(sinh(t))), 4*eps)
      end do
      call check_close(error, top%nutation_period(), huge(1.0_wp), 0.0_wp)
   end subroutine separatrix_of_the_pendulum_is_met

   subroutine a_sleeping_top_sleeps(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      ! J₁ = 2, J₃ = 1, m g l = 2: critical at 4 rad/s.
      top = prepared(sample_t(2.0_wp, 1.0_wp, 2.0_wp, identity, [1.0e-6_wp, 0.0_wp, 4.5_wp]))
      call check_below(error, top%tilt(top%nutation_period()/2), 1.0e-6_wp, "above the critical spin")
      top = prepared(sample_t(2.0_wp, 1.0_wp, 2.0_wp, identity, [1.0e-6_wp, 0.0_wp, 3.5_wp]))
      call check_below(error, 0.5_wp, top%tilt(top%nutation_period()/2), "below it")
      top = prepared(sample_t(2.0_wp, 1.0_wp, 2.0_wp, identity, [0.0_wp, 0.0_wp, 3.5_wp]))
      call check_close(error, top%tilt(1.0e3_wp), 0.0_wp, 0.0_wp, "undisturbed it stays")
   end subroutine a_sleeping_top_sleeps

   subroutine absurd_times_and_states_do_no_harm(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      real(wp), parameter :: times(6) = [0.0_wp, 1.0e-300_wp, 600.0_wp, -1.0e12_wp, 1.0e17_wp, -1.0e308_wp]
      ! m g l, L: next to the unstable upright top, almost and completely at rest, next to no gravity, too much of it.
      real(wp), parameter :: starts(4, 7) = reshape([3.0_wp, 1.0e-160_wp, 0.0_wp, 1.0_wp, 3.0_wp, 1.0e-130_wp, 0.0_wp, &
         1.0_wp, 3.0_wp, 1.0e-310_wp, 0.0_wp, 1.0e-315_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0e-310_wp, 0.0_wp, &
         1.0e-310_wp, 1.0e-310_wp, 1.0e-300_wp, 2.0_wp, 1.0_wp, 1.0_wp, -1.0e100_wp, 1.0_wp, 1.0_wp, 1.0e-100_wp], &
         [4, 7])
      real(wp) :: q(4), momentum(3), rates(2)
      integer :: i, k
      do i = 1, size(starts, 2)
         top = prepared(sample_t(2.0_wp, 1.0_wp, starts(1, i), identity, starts(2:4, i)))
         call top%mean_rates(rates(1), rates(2))
         do k = 1, size(times)
            call top%evaluate(times(k), q, momentum)
            call check_close(error, norm2(q), 1.0_wp, 4*eps, "norm")
         end do
      end do
   end subroutine absurd_times_and_states_do_no_harm

   subroutine bad_input_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(lagrange_top_t) :: top
      type(status_t) :: status
      real(wp), parameter :: ones(3) = 1
      call top%prepare(0.0_wp, 1.0_wp, 1.0_wp, identity, ones, status)
      call check(error, status%code, NUTATE_BAD_BODY, "a moment is zero")
      call top%prepare(1.0_wp, 1.0e-300_wp, 1.0_wp, identity, ones, status)
      call check(error, status%code, NUTATE_BAD_BODY, "moments too far apart")
      call top%prepare(1.0_wp, 1.0_wp, 1.0_wp, 0*identity, ones, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "no attitude")
      call top%prepare(1.0_wp, 1.0_wp, 1.0e300_wp, identity, ones, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "too much gravity")
      call top%prepare(1.0_wp, 1.0_wp, 1.0_wp, identity, ones, status, up=0*ones)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "no vertical")
   end subroutine bad_input_is_refused

end submodule test_exact_top_limits
