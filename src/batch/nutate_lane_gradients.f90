!> Potentials quadratic in a direction, U = ½γᵀAγ + U₀ with γ = Rᵀn (the gravity gradient), in a step in reduced form of
!> several bodies at once: one body a lane, as in `nutate_lane_step`, each with its own A and n.
!>
!> The arithmetic is that of `turn` and `linearize_turn` in `nutate_discrete_forces`, with the discrete gradient Aγ̄.
module nutate_lane_gradients
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: add_gradient_torque, add_gradient_derivative

contains

   !> Adds τ̄ of one potential.
   pure subroutine add_gradient_torque(b, v, stiffness, torque)
      !> b, and n as the bodies see it at the start of the step; shape (lanes, 3).
      real(wp), intent(in) :: b(lanes, 3), v(lanes, 3)
      !> A, J; shape (lanes, 3, 3).
      real(wp), intent(in) :: stiffness(lanes, 3, 3)
      !> N m; shape (lanes, 3).
      real(wp), intent(inout) :: torque(lanes, 3)
      real(wp) :: b1, b2, b3, shrink, square, rest, along, m1, m2, m3, e1, e2, e3, g1, g2, g3
      integer :: i
      do i = 1, lanes
         b1 = b(i, 1)
         b2 = b(i, 2)
         b3 = b(i, 3)
         shrink = 1/(1 + b1*b1 + b2*b2 + b3*b3)
         square = shrink*shrink
         rest = 1 - (b1*b1 + b2*b2 + b3*b3)
         along = 2*(b1*v(i, 1) + b2*v(i, 2) + b3*v(i, 3))
         m1 = rest*v(i, 1) + along*b1 - 2*(b2*v(i, 3) - b3*v(i, 2))
         m2 = rest*v(i, 2) + along*b2 - 2*(b3*v(i, 1) - b1*v(i, 3))
         m3 = rest*v(i, 3) + along*b3 - 2*(b1*v(i, 2) - b2*v(i, 1))
         along = 2*(b1*m1 + b2*m2 + b3*m3)
         e1 = 0.5_wp*(v(i, 1) + square*(rest*m1 + along*b1 - 2*(b2*m3 - b3*m2)))
         e2 = 0.5_wp*(v(i, 2) + square*(rest*m2 + along*b2 - 2*(b3*m1 - b1*m3)))
         e3 = 0.5_wp*(v(i, 3) + square*(rest*m3 + along*b3 - 2*(b1*m2 - b2*m1)))
         g1 = stiffness(i, 1, 1)*e1 + stiffness(i, 1, 2)*e2 + stiffness(i, 1, 3)*e3
         g2 = stiffness(i, 2, 1)*e1 + stiffness(i, 2, 2)*e2 + stiffness(i, 2, 3)*e3
         g3 = stiffness(i, 3, 1)*e1 + stiffness(i, 3, 2)*e2 + stiffness(i, 3, 3)*e3
         torque(i, 1) = torque(i, 1) + square*(m2*g3 - m3*g2)
         torque(i, 2) = torque(i, 2) + square*(m3*g1 - m1*g3)
         torque(i, 3) = torque(i, 3) + square*(m1*g2 - m2*g1)
      end do
   end subroutine add_gradient_torque

   !> Adds τ̄ of one potential and its derivative by b.
   pure subroutine add_gradient_derivative(shrink, b, turns, v, stiffness, torque, by_b)
      !> 1/(1+β), b, and the turns of the attitude at mid step by the components of b; shapes (lanes), (lanes, 3),
      !> (lanes, 3, component).
      real(wp), intent(in) :: shrink(lanes), b(lanes, 3), turns(lanes, 3, 3)
      !> As in `add_gradient_torque`.
      real(wp), intent(in) :: v(lanes, 3), stiffness(lanes, 3, 3)
      real(wp), intent(inout) :: torque(lanes, 3), by_b(lanes, 3, 3)
      real(wp) :: middle(lanes, 3), end(lanes, 3), gradient(lanes, 3), own(lanes, 3), turn_of_end(lanes, 3)
      integer :: i, j
      call turn_back(shrink, b, v, middle)
      call turn_back(shrink, b, middle, end)
      do i = 1, lanes
         do j = 1, 3
            gradient(i, j) = stiffness(i, j, 1)*(0.5_wp*(v(i, 1) + end(i, 1))) &
                             + stiffness(i, j, 2)*(0.5_wp*(v(i, 2) + end(i, 2))) &
                             + stiffness(i, j, 3)*(0.5_wp*(v(i, 3) + end(i, 3)))
         end do
         own(i, 1) = shrink(i)*(middle(i, 2)*gradient(i, 3) - middle(i, 3)*gradient(i, 2))
         own(i, 2) = shrink(i)*(middle(i, 3)*gradient(i, 1) - middle(i, 1)*gradient(i, 3))
         own(i, 3) = shrink(i)*(middle(i, 1)*gradient(i, 2) - middle(i, 2)*gradient(i, 1))
         torque(i, 1) = torque(i, 1) + own(i, 1)
         torque(i, 2) = torque(i, 2) + own(i, 2)
         torque(i, 3) = torque(i, 3) + own(i, 3)
      end do
      do j = 1, 3
         call turn_back(shrink, b, turns(:, :, j), turn_of_end)
         turn_of_end = turns(:, :, j) + turn_of_end
         call add_column(shrink, b(:, j), turns(:, :, j), turn_of_end, middle, end, stiffness, gradient, own, &
                         by_b(:, :, j))
      end do
   end subroutine add_gradient_derivative

   !> Directions turned back by half the step's rotation.
   pure subroutine turn_back(shrink, b, v, turned)
      !> As `add_gradient_derivative` has them.
      real(wp), intent(in) :: shrink(lanes), b(lanes, 3), v(lanes, 3)
      real(wp), intent(out) :: turned(lanes, 3)
      real(wp) :: rest, along
      integer :: i
      do i = 1, lanes
         rest = 1 - (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         along = 2*(b(i, 1)*v(i, 1) + b(i, 2)*v(i, 2) + b(i, 3)*v(i, 3))
         turned(i, 1) = shrink(i)*(rest*v(i, 1) + along*b(i, 1) - 2*(b(i, 2)*v(i, 3) - b(i, 3)*v(i, 2)))
         turned(i, 2) = shrink(i)*(rest*v(i, 2) + along*b(i, 2) - 2*(b(i, 3)*v(i, 1) - b(i, 1)*v(i, 3)))
         turned(i, 3) = shrink(i)*(rest*v(i, 3) + along*b(i, 3) - 2*(b(i, 1)*v(i, 2) - b(i, 2)*v(i, 1)))
      end do
   end subroutine turn_back

   !> Adds ∂τ̄/∂bⱼ: by the scale of x̄, the turn θ of γ at mid step, and that of γ at the end, of which the gradient
   !> takes half.
   pure subroutine add_column(shrink, b, turn, turn_of_end, middle, end, stiffness, gradient, own, by_b)
      !> 1/(1+β) and bⱼ.
      real(wp), intent(in) :: shrink(lanes), b(lanes)
      !> θ at mid step and at the end, γ there, A, Aγ̄ and τ̄; shapes (lanes, 3), (lanes, 3, 3).
      real(wp), dimension(lanes, 3), intent(in) :: turn, turn_of_end, middle, end, gradient, own
      real(wp), intent(in) :: stiffness(lanes, 3, 3)
      !> Shape (lanes, 3).
      real(wp), intent(inout) :: by_b(lanes, 3)
      real(wp) :: scale, a1, a2, a3, e1, e2, e3, h1, h2, h3
      integer :: i
      do i = 1, lanes
         a1 = middle(i, 2)*turn(i, 3) - middle(i, 3)*turn(i, 2)
         a2 = middle(i, 3)*turn(i, 1) - middle(i, 1)*turn(i, 3)
         a3 = middle(i, 1)*turn(i, 2) - middle(i, 2)*turn(i, 1)
         e1 = end(i, 2)*turn_of_end(i, 3) - end(i, 3)*turn_of_end(i, 2)
         e2 = end(i, 3)*turn_of_end(i, 1) - end(i, 1)*turn_of_end(i, 3)
         e3 = end(i, 1)*turn_of_end(i, 2) - end(i, 2)*turn_of_end(i, 1)
         h1 = (0.5_wp*stiffness(i, 1, 1))*e1 + (0.5_wp*stiffness(i, 1, 2))*e2 + (0.5_wp*stiffness(i, 1, 3))*e3
         h2 = (0.5_wp*stiffness(i, 2, 1))*e1 + (0.5_wp*stiffness(i, 2, 2))*e2 + (0.5_wp*stiffness(i, 2, 3))*e3
         h3 = (0.5_wp*stiffness(i, 3, 1))*e1 + (0.5_wp*stiffness(i, 3, 2))*e2 + (0.5_wp*stiffness(i, 3, 3))*e3
         scale = 2*shrink(i)*b(i)
         by_b(i, 1) = by_b(i, 1) - scale*own(i, 1) + shrink(i)*((a2*gradient(i, 3) - a3*gradient(i, 2)) &
                                                                + (middle(i, 2)*h3 - middle(i, 3)*h2))
         by_b(i, 2) = by_b(i, 2) - scale*own(i, 2) + shrink(i)*((a3*gradient(i, 1) - a1*gradient(i, 3)) &
                                                                + (middle(i, 3)*h1 - middle(i, 1)*h3))
         by_b(i, 3) = by_b(i, 3) - scale*own(i, 3) + shrink(i)*((a1*gradient(i, 2) - a2*gradient(i, 1)) &
                                                                + (middle(i, 1)*h2 - middle(i, 2)*h1))
      end do
   end subroutine add_column

end module nutate_lane_gradients
