!> Bare methods that the library is measured against: the best explicit methods as one would write them for a single
!> problem, in q and Ω, without a check of anything, and with nothing conserved.
!>
!> The problem is a body with diagonal inertia and one uniform field along the third space axis. The coefficients are
!> those of DOP853.
module bare_methods
   use nutate, only: wp
   use nutate_order_eight, only: a, b, b3, e5
   implicit none
   private

   public :: bare_problem_t, run_rk8, run_dop853

   !> J⁻¹ and the factors of Euler's equations; m times the field over J, by axis; shapes (3).
   type :: bare_problem_t
      real(wp) :: inverse(3) = 1.0_wp, euler(3) = 0.0_wp
      !> m of the torque m×γ, N m; γ is the third row of R; shape (3).
      real(wp) :: moment(3) = 0.0_wp
      logical :: heavy = .false.
      !> q and Ω at the start; shape (7).
      real(wp) :: start(7) = 0.0_wp
      !> s.
      real(wp) :: end_time = 0.0_wp
   end type bare_problem_t

   !> The step controller of DOP853: order of its estimate, safety, least and most change of the step.
   real(wp), parameter :: power = 1.0_wp/8, safety = 0.9_wp, least = 1.0_wp/3, most = 6.0_wp

contains

   !> Computes q̇ = ½ q∘Ω, Ω̇ = J⁻¹(JΩ×Ω + m×γ).
   pure subroutine get_rate(problem, y, rate)
      type(bare_problem_t), intent(in) :: problem
      !> Shape (7).
      real(wp), intent(in) :: y(7)
      real(wp), intent(out) :: rate(7)
      real(wp) :: g1, g2, g3
      rate(1) = -0.5_wp*(y(2)*y(5) + y(3)*y(6) + y(4)*y(7))
      rate(2) = 0.5_wp*(y(1)*y(5) + y(3)*y(7) - y(4)*y(6))
      rate(3) = 0.5_wp*(y(1)*y(6) + y(4)*y(5) - y(2)*y(7))
      rate(4) = 0.5_wp*(y(1)*y(7) + y(2)*y(6) - y(3)*y(5))
      rate(5) = problem%euler(1)*y(6)*y(7)
      rate(6) = problem%euler(2)*y(7)*y(5)
      rate(7) = problem%euler(3)*y(5)*y(6)
      if (.not. problem%heavy) return
      g1 = 2*(y(2)*y(4) - y(1)*y(3))
      g2 = 2*(y(3)*y(4) + y(1)*y(2))
      g3 = y(1)*y(1) - y(2)*y(2) - y(3)*y(3) + y(4)*y(4)
      rate(5) = rate(5) + problem%inverse(1)*(problem%moment(2)*g3 - problem%moment(3)*g2)
      rate(6) = rate(6) + problem%inverse(2)*(problem%moment(3)*g1 - problem%moment(1)*g3)
      rate(7) = rate(7) + problem%inverse(3)*(problem%moment(1)*g2 - problem%moment(2)*g1)
   end subroutine get_rate

   !> Computes the rates of the stages after the first; shape (7, 12).
   pure subroutine get_stages(problem, h, y, k)
      type(bare_problem_t), intent(in) :: problem
      !> s.
      real(wp), intent(in) :: h, y(7)
      real(wp), intent(inout) :: k(7, 12)
      call get_rate(problem, y + h*(a(1, 2)*k(:, 1)), k(:, 2))
      call get_rate(problem, y + h*(a(1, 3)*k(:, 1) + a(2, 3)*k(:, 2)), k(:, 3))
      call get_rate(problem, y + h*(a(1, 4)*k(:, 1) + a(3, 4)*k(:, 3)), k(:, 4))
      call get_rate(problem, y + h*(a(1, 5)*k(:, 1) + a(3, 5)*k(:, 3) + a(4, 5)*k(:, 4)), k(:, 5))
      call get_rate(problem, y + h*(a(1, 6)*k(:, 1) + a(4, 6)*k(:, 4) + a(5, 6)*k(:, 5)), k(:, 6))
      call get_rate(problem, y + h*(a(1, 7)*k(:, 1) + a(4, 7)*k(:, 4) + a(5, 7)*k(:, 5) + a(6, 7)*k(:, 6)), k(:, 7))
      call get_rate(problem, y + h*(a(1, 8)*k(:, 1) + a(4, 8)*k(:, 4) + a(5, 8)*k(:, 5) + a(6, 8)*k(:, 6) &
                                    + a(7, 8)*k(:, 7)), k(:, 8))
      call get_rate(problem, y + h*(a(1, 9)*k(:, 1) + a(4, 9)*k(:, 4) + a(5, 9)*k(:, 5) + a(6, 9)*k(:, 6) &
                                    + a(7, 9)*k(:, 7) + a(8, 9)*k(:, 8)), k(:, 9))
      call get_rate(problem, y + h*(a(1, 10)*k(:, 1) + a(4, 10)*k(:, 4) + a(5, 10)*k(:, 5) + a(6, 10)*k(:, 6) &
                                    + a(7, 10)*k(:, 7) + a(8, 10)*k(:, 8) + a(9, 10)*k(:, 9)), k(:, 10))
      call get_rate(problem, y + h*(a(1, 11)*k(:, 1) + a(4, 11)*k(:, 4) + a(5, 11)*k(:, 5) + a(6, 11)*k(:, 6) &
                                    + a(7, 11)*k(:, 7) + a(8, 11)*k(:, 8) + a(9, 11)*k(:, 9) &
                                    + a(10, 11)*k(:, 10)), k(:, 11))
      call get_rate(problem, y + h*(a(1, 12)*k(:, 1) + a(4, 12)*k(:, 4) + a(5, 12)*k(:, 5) + a(6, 12)*k(:, 6) &
                                    + a(7, 12)*k(:, 7) + a(8, 12)*k(:, 8) + a(9, 12)*k(:, 9) &
                                    + a(10, 12)*k(:, 10) + a(11, 12)*k(:, 11)), k(:, 12))
   end subroutine get_stages

   pure function weighted(k) result(slope)
      real(wp), intent(in) :: k(7, 12)
      real(wp) :: slope(7)
      slope = b(1)*k(:, 1) + b(6)*k(:, 6) + b(7)*k(:, 7) + b(8)*k(:, 8) + b(9)*k(:, 9) + b(10)*k(:, 10) &
              + b(11)*k(:, 11) + b(12)*k(:, 12)
   end function weighted

   !> Performs n fixed steps to the end; q is normalised in each.
   pure subroutine run_rk8(problem, n, y)
      type(bare_problem_t), intent(in) :: problem
      integer, intent(in) :: n
      !> State at the end, q and Ω; shape (7).
      real(wp), intent(out) :: y(7)
      real(wp) :: k(7, 12), h
      integer :: i
      h = problem%end_time/n
      y = problem%start
      do i = 1, n
         call get_rate(problem, y, k(:, 1))
         call get_stages(problem, h, y, k)
         y = y + h*weighted(k)
         y(1:4) = y(1:4)/sqrt(y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4))
      end do
   end subroutine run_rk8

   !> Performs steps chosen by the estimates of orders 5 and 3, as DOP853 does.
   pure subroutine run_dop853(problem, tolerance, y, steps)
      type(bare_problem_t), intent(in) :: problem
      !> Tolerance: absolute for q, and relative for Ω.
      real(wp), intent(in) :: tolerance
      real(wp), intent(out) :: y(7)
      !> Number of steps, accepted and rejected.
      integer, intent(out) :: steps
      real(wp) :: k(7, 12), next(7), slope(7), scale(7), h, t, error, fifth, third
      t = 0.0_wp
      y = problem%start
      steps = 0
      call get_rate(problem, y, k(:, 1))
      h = 0.1_wp/norm2(y(5:7))
      do while (t < problem%end_time)
         h = min(h, problem%end_time - t)
         call get_stages(problem, h, y, k)
         slope = weighted(k)
         next = y + h*slope
         scale = tolerance + tolerance*max(abs(y), abs(next))
         fifth = sum(((e5(1)*k(:, 1) + e5(6)*k(:, 6) + e5(7)*k(:, 7) + e5(8)*k(:, 8) + e5(9)*k(:, 9) &
                       + e5(10)*k(:, 10) + e5(11)*k(:, 11) + e5(12)*k(:, 12))/scale)**2)
         third = sum(((slope - b3(1)*k(:, 1) - b3(2)*k(:, 9) - b3(3)*k(:, 12))/scale)**2)
         error = h*fifth/sqrt(7*(fifth + 0.01_wp*third) + tiny(1.0_wp))
         steps = steps + 1
         if (error <= 1.0_wp) then
            t = t + h
            y = next
            call get_rate(problem, y, k(:, 1))
         end if
         h = h*min(most, max(least, safety/max(error, 1e-10_wp)**power))
      end do
      y(1:4) = y(1:4)/norm2(y(1:4))
   end subroutine run_dop853

end module bare_methods
