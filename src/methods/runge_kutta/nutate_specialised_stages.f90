!> The stages of the Runge-Kutta method of order 8 in the variables of `nutate_specialised_motion`; the constants of the
!> rates contain the step.
!>
!> A stage waits for the one before. The newest rates therefore go into the next stage directly, as numbers in
!> registers; the sum over the older ones, which are known early, is computed beforehand, from columns of even length
!> that vector instructions process as a whole.
module nutate_specialised_stages
   use nutate_kinds, only: wp
   use nutate_order_eight, only: a, b, n_stages
   use nutate_quaternion, only: quat_vector_product
   implicit none
   private

   public :: specialised_rates_t, steady_ratio, free_stages, heavy_stages, sensitivity_stages, evaluate_upright_stage, &
      evaluate_field_stage, &
      evaluate_rotating_stage, evaluate_rotating_field_stage

   !> Least 1 + u₀·u: the shortest rotation from u to u₀ must stay away from half a revolution, where it has no axis.
   real(wp), parameter :: least_cosine = 0.1_wp

   !> J₃'/J₁ of the equations of a symmetric top.
   real(wp), parameter :: steady_ratio = 1.5_wp

   !> The constants of the rates in uniform fields.
   type :: specialised_rates_t
      !> κ; shape (3).
      real(wp) :: kappa(3) = 0.0_wp
      !> τᵢ = Σ torque(i, j, k) R(k, j), of the equations' axes, N m; shape (3,3,3).
      real(wp) :: torque(3, 3, 3) = 0.0_wp
      !> ½Δt² torque/J, for off-diagonal R(k, j) without their factor 2; shape (3,3,3).
      real(wp) :: pull(3, 3, 3) = 0.0_wp
      !> φ = ½Δt ω of rotating space axes, in these axes, rad; shape (3).
      real(wp) :: frame_turn(3) = 0.0_wp
      !> Number of pairs of sensitivities that are propagated with the motion.
      integer :: pairs = 0
   end type specialised_rates_t

   abstract interface
      !> Computes the rates of a stage, and with them the argument of the next one: `sum + factor*rate`.
      pure subroutine stage_evaluator(self, y, sum, factor, rate, next)
         import :: specialised_rates_t, wp
         type(specialised_rates_t), intent(in) :: self
         !> [q, w, 0]; shape (8).
         real(wp), intent(in) :: y(8)
         !> Shape (8).
         real(wp), intent(in) :: sum(8), factor
         real(wp), intent(out) :: rate(8), next(8)
      end subroutine stage_evaluator
   end interface

   !> Evaluates a stage of a free body, or of sensitivities, under the name in the included text of the stages.
   interface evaluate_stage
      module procedure evaluate_free_stage, evaluate_sensitivity_stage
   end interface evaluate_stage

contains

   !> Computes the increments of w and of φ/2 in a step of a free body.
   pure subroutine free_stages(rates, start, axis, along, change, turn, followed)
      !> κ, the only constants of the rates; shape (3).
      real(wp), intent(in) :: rates(3)
      !> w at the start, u₀, and the vector whose product with w is u₀·u; shape (3).
      real(wp), intent(in) :: start(3), axis(3), along(3)
      real(wp), intent(out) :: change(4), turn
      !> False if u comes near to -u₀.
      logical, intent(out) :: followed
      real(wp) :: y(4), sum(4), k(4, n_stages), x(4, n_stages + 1), rate(5:n_stages), cosine(5:n_stages), constant
      integer :: i
      y(1:3) = start
      y(4) = 0.0_wp
      x(:, 1) = y
      include 'order_eight_stages.inc'
      change = x(:, n_stages + 1)
      constant = start(1)*axis(1) + start(2)*axis(2) + start(3)*axis(3)
      ! Stages 2 to 5 have no weight: the first is stored as the fifth, so that divisions are in pairs.
      x(:, 5) = x(:, 1)
      do i = 5, n_stages
         rate(i) = constant + (axis(1)*x(1, i) + axis(2)*x(2, i) + axis(3)*x(3, i))
         cosine(i) = 1 + (along(1)*x(1, i) + along(2)*x(2, i) + along(3)*x(3, i))
      end do
      followed = minval(cosine) >= least_cosine
      turn = 0.0_wp
      if (.not. followed) return
      rate = rate/cosine
      turn = b(1)*rate(5) + b(6)*rate(6) + b(7)*rate(7) + b(8)*rate(8) + b(9)*rate(9) + b(10)*rate(10) &
             + b(11)*rate(11) + b(12)*rate(12)
   end subroutine free_stages

   !> Computes the rates of a stage, wᵢ' = κᵢ wⱼwₖ, and with them the argument of the next one: `sum + factor*rate`.
   pure subroutine evaluate_free_stage(kappa, w, sum, factor, rate, next)
      !> κ; shape (3).
      real(wp), intent(in) :: kappa(3)
      !> w of the stage and sum of the next one, padded by a zero; shape (4); factor of the rate.
      real(wp), intent(in) :: w(4), sum(4), factor
      real(wp), intent(out) :: rate(4), next(4)
      real(wp) :: r1, r2, r3
      r1 = kappa(1)*w(2)*w(3)
      r2 = kappa(2)*w(3)*w(1)
      r3 = kappa(3)*w(1)*w(2)
      next(1) = sum(1) + factor*r1
      next(2) = sum(2) + factor*r2
      next(3) = sum(3) + factor*r3
      next(4) = 0.0_wp
      rate(1) = r1
      rate(2) = r2
      rate(3) = r3
      rate(4) = 0.0_wp
   end subroutine evaluate_free_stage

   !> Computes the increments of q and w in a step of a body in uniform fields.
   pure subroutine heavy_stages(evaluate_stage, rates, y, change)
      procedure(stage_evaluator) :: evaluate_stage
      type(specialised_rates_t), intent(in) :: rates
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shape (8).
      real(wp), intent(out) :: change(8)
      real(wp) :: k(8, n_stages), x(8, n_stages + 1), sum(8)
      x(:, 1) = y
      include 'order_eight_stages.inc'
      change(1:7) = x(1:7, n_stages + 1)
      change(8) = 0.0_wp
   end subroutine heavy_stages

   !> Computes the rates of a stage, and with them the argument of the next one: `sum + factor*rate`. γ is the third row
   !> of R(q), homogeneous in q: nothing is normalised.
   pure subroutine evaluate_upright_stage(self, y, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shape (8).
      real(wp), intent(in) :: sum(8), factor
      real(wp), intent(out) :: rate(8), next(8)
      real(wp) :: r1, r2, r3, r4, r5, r6, r7, g1, g2, g3
      r1 = -(y(2)*y(5) + y(3)*y(6) + y(4)*y(7))
      r2 = y(1)*y(5) + y(3)*y(7) - y(4)*y(6)
      r3 = y(1)*y(6) + y(4)*y(5) - y(2)*y(7)
      r4 = y(1)*y(7) + y(2)*y(6) - y(3)*y(5)
      g1 = y(2)*y(4) - y(1)*y(3)
      g2 = y(3)*y(4) + y(1)*y(2)
      g3 = (y(1)*y(1) + y(4)*y(4)) - (y(2)*y(2) + y(3)*y(3))
      associate (c => self%pull, kappa => self%kappa)
         r5 = kappa(1)*(y(6)*y(7)) + (c(1, 2, 3)*g2 + c(1, 3, 3)*g3)
         r6 = kappa(2)*(y(7)*y(5)) + (c(2, 1, 3)*g1 + c(2, 3, 3)*g3)
         r7 = kappa(3)*(y(5)*y(6)) + (c(3, 1, 3)*g1 + c(3, 2, 3)*g2)
      end associate
      rate(1) = r1
      rate(2) = r2
      rate(3) = r3
      rate(4) = r4
      rate(5) = r5
      rate(6) = r6
      rate(7) = r7
      rate(8) = 0.0_wp
      next(1) = sum(1) + factor*r1
      next(2) = sum(2) + factor*r2
      next(3) = sum(3) + factor*r3
      next(4) = sum(4) + factor*r4
      next(5) = sum(5) + factor*r5
      next(6) = sum(6) + factor*r6
      next(7) = sum(7) + factor*r7
   end subroutine evaluate_upright_stage

   !> Moves q and w and sensitivities over a step under one direction.
   pure subroutine sensitivity_stages(rates, n, y, k, x)
      type(specialised_rates_t), intent(in) :: rates
      !> Length of y.
      integer, intent(in) :: n
      !> [q, w, 0], and [δq, δw] of pairs of sensitivities, both numbers of a pair side by side; shape (8 + 14*pairs).
      real(wp), intent(inout) :: y(n)
      !> Work space of the stages: an automatic array would be on the heap.
      real(wp), intent(inout) :: k(n, n_stages), x(n, n_stages + 2)
      associate (sum => x(:, n_stages + 2))
         x(:, 1) = y
         include 'order_eight_stages.inc'
      end associate
      y = y + x(:, n_stages + 1)
   end subroutine sensitivity_stages

   !> Evaluates a stage as `evaluate_upright_stage` does, and the derivatives of its rates times the sensitivities.
   pure subroutine evaluate_sensitivity_stage(self, y, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0] and pairs of [δq, δw], as in `sensitivity_stages`; shape (8 + 14*pairs).
      real(wp), intent(in) :: y(8 + 14*self%pairs), sum(8 + 14*self%pairs), factor
      real(wp), intent(out) :: rate(8 + 14*self%pairs), next(8 + 14*self%pairs)
      integer :: j
      call evaluate_upright_stage(self, y, sum, factor, rate, next)
      next(8) = 0.0_wp
      do j = 9, size(y), 14
         call evaluate_pair(self, y, y(j), sum(j), factor, rate(j), next(j))
      end do
   end subroutine evaluate_sensitivity_stage

   !> Computes the derivatives of the rates of `evaluate_upright_stage` times two sensitivities.
   pure subroutine evaluate_pair(self, y, sensitivities, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shapes (2,7): δq in the first four, and δw.
      real(wp), intent(in) :: sensitivities(2, 7), sum(2, 7), factor
      real(wp), intent(out) :: rate(2, 7), next(2, 7)
      real(wp) :: g1(2), g2(2), g3(2)
      associate (q => y(1:4), w => y(5:7), c => self%pull, kappa => self%kappa, &
                 dq1 => sensitivities(:, 1), dq2 => sensitivities(:, 2), dq3 => sensitivities(:, 3), &
                    dq4 => sensitivities(:, 4), &
                 dw1 => sensitivities(:, 5), dw2 => sensitivities(:, 6), dw3 => sensitivities(:, 7))
         rate(:, 1) = -(w(1)*dq2 + w(2)*dq3 + w(3)*dq4) - (q(2)*dw1 + q(3)*dw2 + q(4)*dw3)
         rate(:, 2) = (w(1)*dq1 + w(3)*dq3 - w(2)*dq4) + (q(1)*dw1 + q(3)*dw3 - q(4)*dw2)
         rate(:, 3) = (w(2)*dq1 + w(1)*dq4 - w(3)*dq2) + (q(1)*dw2 + q(4)*dw1 - q(2)*dw3)
         rate(:, 4) = (w(3)*dq1 + w(2)*dq2 - w(1)*dq3) + (q(1)*dw3 + q(2)*dw2 - q(3)*dw1)
         g1 = (q(2)*dq4 + q(4)*dq2) - (q(1)*dq3 + q(3)*dq1)
         g2 = (q(3)*dq4 + q(4)*dq3) + (q(1)*dq2 + q(2)*dq1)
         g3 = 2*((q(1)*dq1 + q(4)*dq4) - (q(2)*dq2 + q(3)*dq3))
         rate(:, 5) = kappa(1)*(w(2)*dw3 + w(3)*dw2) + (c(1, 2, 3)*g2 + c(1, 3, 3)*g3)
         rate(:, 6) = kappa(2)*(w(3)*dw1 + w(1)*dw3) + (c(2, 1, 3)*g1 + c(2, 3, 3)*g3)
         rate(:, 7) = kappa(3)*(w(1)*dw2 + w(2)*dw1) + (c(3, 1, 3)*g1 + c(3, 2, 3)*g2)
      end associate
      next = sum + factor*rate
   end subroutine evaluate_pair

   !> Evaluates a stage as `evaluate_upright_stage` does, in rotating space axes, q' = q∘w - φ∘q: from the sums and
   !> differences of w and φ, with no more products.
   pure subroutine evaluate_rotating_stage(self, y, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shape (8).
      real(wp), intent(in) :: sum(8), factor
      real(wp), intent(out) :: rate(8), next(8)
      real(wp) :: r1, r2, r3, r4, r5, r6, r7, g1, g2, g3, less(3), more(3)
      associate (phi => self%frame_turn)
         less = [y(5) - phi(1), y(6) - phi(2), y(7) - phi(3)]
         more = [y(5) + phi(1), y(6) + phi(2), y(7) + phi(3)]
      end associate
      r1 = -(y(2)*less(1) + y(3)*less(2) + y(4)*less(3))
      r2 = y(1)*less(1) + y(3)*more(3) - y(4)*more(2)
      r3 = y(1)*less(2) + y(4)*more(1) - y(2)*more(3)
      r4 = y(1)*less(3) + y(2)*more(2) - y(3)*more(1)
      g1 = y(2)*y(4) - y(1)*y(3)
      g2 = y(3)*y(4) + y(1)*y(2)
      g3 = (y(1)*y(1) + y(4)*y(4)) - (y(2)*y(2) + y(3)*y(3))
      associate (c => self%pull, kappa => self%kappa)
         r5 = kappa(1)*(y(6)*y(7)) + (c(1, 2, 3)*g2 + c(1, 3, 3)*g3)
         r6 = kappa(2)*(y(7)*y(5)) + (c(2, 1, 3)*g1 + c(2, 3, 3)*g3)
         r7 = kappa(3)*(y(5)*y(6)) + (c(3, 1, 3)*g1 + c(3, 2, 3)*g2)
      end associate
      rate = [r1, r2, r3, r4, r5, r6, r7, 0.0_wp]
      next(1) = sum(1) + factor*r1
      next(2) = sum(2) + factor*r2
      next(3) = sum(3) + factor*r3
      next(4) = sum(4) + factor*r4
      next(5) = sum(5) + factor*r5
      next(6) = sum(6) + factor*r6
      next(7) = sum(7) + factor*r7
   end subroutine evaluate_rotating_stage

   !> Evaluates a stage as `evaluate_upright_stage` does, in fields of several directions, with all rows of R(q).
   pure subroutine evaluate_field_stage(self, y, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shape (8).
      real(wp), intent(in) :: sum(8), factor
      real(wp), intent(out) :: rate(8), next(8)
      real(wp) :: row(3, 3)
      integer :: k
      associate (q => y(1:4), w => y(5:7))
         rate(1:4) = quat_vector_product(q, w)
         rate(5) = self%kappa(1)*(w(2)*w(3))
         rate(6) = self%kappa(2)*(w(3)*w(1))
         rate(7) = self%kappa(3)*(w(1)*w(2))
         rate(8) = 0.0_wp
         row(1, 1) = (q(1)*q(1) + q(2)*q(2)) - (q(3)*q(3) + q(4)*q(4))
         row(2, 1) = q(2)*q(3) - q(1)*q(4)
         row(3, 1) = q(2)*q(4) + q(1)*q(3)
         row(1, 2) = q(2)*q(3) + q(1)*q(4)
         row(2, 2) = (q(1)*q(1) + q(3)*q(3)) - (q(2)*q(2) + q(4)*q(4))
         row(3, 2) = q(3)*q(4) - q(1)*q(2)
         row(1, 3) = q(2)*q(4) - q(1)*q(3)
         row(2, 3) = q(3)*q(4) + q(1)*q(2)
         row(3, 3) = (q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3))
      end associate
      do k = 1, 3
         associate (c => self%pull)
            rate(5) = rate(5) + (c(1, 2, k)*row(2, k) + c(1, 3, k)*row(3, k))
            rate(6) = rate(6) + (c(2, 1, k)*row(1, k) + c(2, 3, k)*row(3, k))
            rate(7) = rate(7) + (c(3, 1, k)*row(1, k) + c(3, 2, k)*row(2, k))
         end associate
      end do
      next = sum + factor*rate
   end subroutine evaluate_field_stage

   !> Evaluates a stage as `evaluate_field_stage` does, in rotating space axes.
   pure subroutine evaluate_rotating_field_stage(self, y, sum, factor, rate, next)
      type(specialised_rates_t), intent(in) :: self
      !> [q, w, 0]; shape (8).
      real(wp), intent(in) :: y(8)
      !> Shape (8).
      real(wp), intent(in) :: sum(8), factor
      real(wp), intent(out) :: rate(8), next(8)
      real(wp) :: q(4), turn(4)
      q = y(1:4)
      associate (phi => self%frame_turn)
         turn(1) = -(phi(1)*q(2) + phi(2)*q(3) + phi(3)*q(4))
         turn(2) = phi(1)*q(1) + phi(2)*q(4) - phi(3)*q(3)
         turn(3) = phi(2)*q(1) + phi(3)*q(2) - phi(1)*q(4)
         turn(4) = phi(3)*q(1) + phi(1)*q(3) - phi(2)*q(2)
      end associate
      call evaluate_field_stage(self, y, sum, factor, rate, next)
      rate(1:4) = rate(1:4) - turn
      next(1:4) = next(1:4) - factor*turn
   end subroutine evaluate_rotating_field_stage

end module nutate_specialised_stages
