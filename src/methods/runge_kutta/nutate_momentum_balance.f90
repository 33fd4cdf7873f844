!> The momentum in space by its balance, l = l₀ + ∫ Rτ dt, with the stages and weights of a Runge-Kutta method.
module nutate_momentum_balance
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotate_to_body, rotate_to_space
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: momentum_balance_t

   !> Largest number of stages.
   integer, parameter :: most_stages = 12

   !> The balance of one step.
   type :: momentum_balance_t
      !> l at the start of the step, and ∫ Rτ dt so far, N m s; shape (3).
      real(wp), private :: first(3) = 0.0_wp, impulse(3) = 0.0_wp
      !> ΔtRτ of the stages with a weight so far, N m s, shape (3, most_stages), and number of all stages so far.
      real(wp), private :: pushes(3, most_stages) = 0.0_wp
      integer, private :: stages = 0
   contains
      !> Starts a step.
      procedure :: start
      !> Adds a stage.
      procedure :: add
      !> Computes the excess of the balance at the end of the step, and its possible error.
      procedure :: tell
   end type momentum_balance_t

contains

   !> Starts a step.
   pure subroutine start(self, q, momentum)
      class(momentum_balance_t), intent(inout) :: self
      !> Attitude, |q| nearly 1, shape (4); L, body axes, N m s, shape (3).
      real(wp), intent(in) :: q(4), momentum(3)
      self%first = rotate_to_space(q, momentum)/dot_product(q, q)
      self%impulse = 0.0_wp
      self%stages = 0
   end subroutine start

   !> Adds a stage, if it has a weight.
   pure subroutine add(self, q, square, weight, dt, tau)
      class(momentum_balance_t), intent(inout) :: self
      !> Attitude, shape (4), and |q|²; weight of the stage; step, s; torque, body axes, N m, shape (3).
      real(wp), intent(in) :: q(4), square, weight, dt, tau(3)
      real(wp) :: over, push1, push2, push3, u1, u2, u3
      self%stages = self%stages + 1
      if (.not. abs(weight)*square > tiny(1.0_wp)) return
      push1 = dt*tau(1)
      push2 = dt*tau(2)
      push3 = dt*tau(3)
      ! Rx = x + 2(su + v×u)/|q|², u = v×x, q = [s, v]
      over = 2/square
      u1 = over*(q(3)*push3 - q(4)*push2)
      u2 = over*(q(4)*push1 - q(2)*push3)
      u3 = over*(q(2)*push2 - q(3)*push1)
      push1 = push1 + (q(1)*u1 + (q(3)*u3 - q(4)*u2))
      push2 = push2 + (q(1)*u2 + (q(4)*u1 - q(2)*u3))
      push3 = push3 + (q(1)*u3 + (q(2)*u2 - q(3)*u1))
      associate (push => self%pushes(:, self%stages))
         push(1) = push1
         push(2) = push2
         push(3) = push3
         self%impulse(1) = self%impulse(1) + weight*push1
         self%impulse(2) = self%impulse(2) + weight*push2
         self%impulse(3) = self%impulse(3) + weight*push3
      end associate
   end subroutine add

   !> Computes the excess of the balance over the momentum at the end of the step, and its possible error, in body axes.
   pure subroutine tell(self, q, momentum, weights, error)
      class(momentum_balance_t), intent(in) :: self
      !> Attitude at the end, |q| nearly 1, shape (4); L, body axes, N m s, shape (3).
      real(wp), intent(in) :: q(4), momentum(3)
      !> Weights of the stages in the estimate; shape (stages). Zero if they are zero in the step itself.
      real(wp), intent(in) :: weights(:)
      type(step_error_t), intent(inout) :: error
      real(wp) :: square, off(3)
      integer :: i
      square = dot_product(q, q)
      error%balance = rotate_to_body(q, self%first + self%impulse)/square - momentum
      off = 0.0_wp
      do i = 1, size(weights)
         off(1) = off(1) + weights(i)*self%pushes(1, i)
         off(2) = off(2) + weights(i)*self%pushes(2, i)
         off(3) = off(3) + weights(i)*self%pushes(3, i)
      end do
      error%of_balance = rotate_to_body(q, off)/square
   end subroutine tell

end module nutate_momentum_balance
