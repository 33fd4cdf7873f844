!> Potentials linear in a direction, U = -m·Rᵀn (weight, dipoles, constant fields), or quadratic
!> (`nutate_lane_gradients`), in a step in reduced form of several bodies at once: one body a lane, as in
!> `nutate_lane_step`, each with its own numbers.
!>
!> The arithmetic is that of `turn` and `linearize_turn` in `nutate_discrete_forces`, and of what
!> `nutate_reduced_equations` makes of them.
module nutate_lane_loads
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp, eps, long
   use nutate_lane_gradients, only: add_gradient_derivative, add_gradient_torque
   use nutate_lane_newton, only: iteration_t
   use nutate_lane_potentials, only: lane_potentials_t, make_room, put_potentials, rest_potentials
   use nutate_lane_vectors, only: cross_lanes
   use nutate_lane_width, only: lanes
   use nutate_reduced, only: coarse
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: lane_loads_t

   !> Potentials of each body.
   type, extends(lane_potentials_t) :: lane_loads_t
      !> τ̄ of the b that F was last asked for, N m; shape (lanes, 3).
      real(wp) :: torque(lanes, 3) = 0.0_wp
      !> Rᵀn of each at the start of the step; shape (lanes, 3, n).
      real(wp), allocatable, private :: direction(:, :, :)
   contains
      !> Makes room.
      procedure :: set_up
      !> A lane without potentials.
      procedure :: rest
      !> Takes those of a body, if they are like those of the others.
      procedure :: put
      !> Starts a step.
      procedure :: start
      !> Adds their part to F.
      procedure :: add_to_residuals
      !> Their part of the Jacobian.
      procedure :: linearize
      !> Brings the torque up to the root.
      procedure :: follow
      !> Their impulse.
      procedure :: find_impulse
   end type lane_loads_t

contains

   !> Makes room for potentials of each body.
   pure subroutine set_up(self, n)
      class(lane_loads_t), intent(inout) :: self
      integer, intent(in) :: n
      call make_room(self, n)
      if (allocated(self%direction)) deallocate (self%direction)
      allocate (self%direction(lanes, 3, n), source=0.0_wp)
      self%torque = 0.0_wp
   end subroutine set_up

   pure subroutine rest(self, lane)
      class(lane_loads_t), intent(inout) :: self
      integer, intent(in) :: lane
      call rest_potentials(self, lane)
      self%torque(lane, :) = 0.0_wp
   end subroutine rest

   !> Takes the potentials of a body, which are those of the other lanes but for their numbers, and bounds their torque.
   pure subroutine put(self, lane, effects, bound, fits)
      class(lane_loads_t), intent(inout) :: self
      integer, intent(in) :: lane
      !> Loads.
      type(effect_list_t), intent(in) :: effects
      !> N m.
      real(wp), intent(out) :: bound
      !> False: the body has others, and none is taken.
      logical, intent(out) :: fits
      integer :: i
      bound = 0.0_wp
      call put_potentials(self, lane, effects, [(i, i=1, effects%n_potentials)], fits)
      if (.not. fits) return
      do i = 1, self%n
         associate (length => vector_length(self%normal(lane, :, i)))
            if (self%is_quadratic(i)) then
               bound = bound + 3*maxval(abs(self%stiffness(lane, :, :, i)))*length**2
            else
               bound = bound + vector_length(self%slope(lane, :, i))*length
            end if
         end associate
      end do
   end subroutine put

   !> The directions as the bodies see them at the start of a step.
   pure subroutine start(self, frame)
      class(lane_loads_t), intent(inout) :: self
      !> u; shape (lanes, 4).
      real(wp), intent(in) :: frame(lanes, 4)
      real(wp) :: r(lanes, 3, 3), q00, q11, q22, q33
      integer :: i, k
      do i = 1, lanes
         q00 = frame(i, 1)*frame(i, 1)
         q11 = frame(i, 2)*frame(i, 2)
         q22 = frame(i, 3)*frame(i, 3)
         q33 = frame(i, 4)*frame(i, 4)
         r(i, 1, 1) = q00 + q11 - q22 - q33
         r(i, 2, 2) = q00 - q11 + q22 - q33
         r(i, 3, 3) = q00 - q11 - q22 + q33
         r(i, 2, 1) = 2*(frame(i, 2)*frame(i, 3) + frame(i, 1)*frame(i, 4))
         r(i, 1, 2) = 2*(frame(i, 2)*frame(i, 3) - frame(i, 1)*frame(i, 4))
         r(i, 1, 3) = 2*(frame(i, 2)*frame(i, 4) + frame(i, 1)*frame(i, 3))
         r(i, 3, 1) = 2*(frame(i, 2)*frame(i, 4) - frame(i, 1)*frame(i, 3))
         r(i, 3, 2) = 2*(frame(i, 3)*frame(i, 4) + frame(i, 1)*frame(i, 2))
         r(i, 2, 3) = 2*(frame(i, 3)*frame(i, 4) - frame(i, 1)*frame(i, 2))
      end do
      do k = 1, self%n
         call see(r, self%normal(:, :, k), self%direction(:, :, k))
      end do
   end subroutine start

   !> Rᵀn.
   pure subroutine see(r, normal, direction)
      !> Shapes (lanes, 3, 3) and (lanes, 3).
      real(wp), intent(in) :: r(lanes, 3, 3), normal(lanes, 3)
      real(wp), intent(out) :: direction(lanes, 3)
      integer :: i, j
      do i = 1, lanes
         do j = 1, 3
            direction(i, j) = r(i, 1, j)*normal(i, 1) + r(i, 2, j)*normal(i, 2) + r(i, 3, j)*normal(i, 3)
         end do
      end do
   end subroutine see

   !> Adds -½Δt((1+β)τ̄ - 2b(b·τ̄)) to F, in the units of the step, and keeps τ̄ of the lanes that are not done.
   pure subroutine add_to_residuals(self, weight, at)
      class(lane_loads_t), intent(inout) :: self
      !> ½Δt²/4s
      real(wp), intent(in) :: weight(lanes)
      type(iteration_t), intent(inout) :: at
      real(wp) :: torque(lanes, 3)
      if (at%has_done) then
         call find_torque(self, at%z, torque)
         call keep_lanes(at%done, torque, self%torque)
      else
         call find_torque(self, at%z, self%torque)
      end if
      call add_weighted(weight, at%z, self%torque, at%f)
   end subroutine add_to_residuals

   !> τ̄, body axes, N m; shape (lanes, 3).
   pure subroutine find_torque(self, b, torque)
      class(lane_loads_t), intent(in) :: self
      !> Shape (lanes, 3).
      real(wp), intent(in) :: b(lanes, 3)
      real(wp), intent(out) :: torque(lanes, 3)
      integer :: k
      torque = 0.0_wp
      do k = 1, self%n
         if (self%is_quadratic(k)) then
            call add_gradient_torque(b, self%direction(:, :, k), self%stiffness(:, :, :, k), torque)
         else
            call add_torque(b, self%direction(:, :, k), self%slope(:, :, k), torque)
         end if
      end do
   end subroutine find_torque

   !> Adds τ̄ of one linear potential.
   pure subroutine add_torque(b, v, slope, torque)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: b(lanes, 3), v(lanes, 3), slope(lanes, 3)
      real(wp), intent(inout) :: torque(lanes, 3)
      real(wp) :: shrink, square, rest, along, m1, m2, m3
      integer :: i
      do i = 1, lanes
         shrink = 1/(1 + b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         square = shrink*shrink
         rest = 1 - (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         along = 2*(b(i, 1)*v(i, 1) + b(i, 2)*v(i, 2) + b(i, 3)*v(i, 3))
         m1 = rest*v(i, 1) + along*b(i, 1) - 2*(b(i, 2)*v(i, 3) - b(i, 3)*v(i, 2))
         m2 = rest*v(i, 2) + along*b(i, 2) - 2*(b(i, 3)*v(i, 1) - b(i, 1)*v(i, 3))
         m3 = rest*v(i, 3) + along*b(i, 3) - 2*(b(i, 1)*v(i, 2) - b(i, 2)*v(i, 1))
         torque(i, 1) = torque(i, 1) + square*(m2*slope(i, 3) - m3*slope(i, 2))
         torque(i, 2) = torque(i, 2) + square*(m3*slope(i, 1) - m1*slope(i, 3))
         torque(i, 3) = torque(i, 3) + square*(m1*slope(i, 2) - m2*slope(i, 1))
      end do
   end subroutine add_torque

   !> Directions turned back by half the step's rotation, times 1+β.
   pure subroutine turn_back(b, v, middle)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: b(lanes, 3), v(lanes, 3)
      real(wp), intent(out) :: middle(lanes, 3)
      real(wp) :: rest, along
      integer :: i
      do i = 1, lanes
         rest = 1 - (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         along = 2*(b(i, 1)*v(i, 1) + b(i, 2)*v(i, 2) + b(i, 3)*v(i, 3))
         middle(i, 1) = rest*v(i, 1) + along*b(i, 1) - 2*(b(i, 2)*v(i, 3) - b(i, 3)*v(i, 2))
         middle(i, 2) = rest*v(i, 2) + along*b(i, 2) - 2*(b(i, 3)*v(i, 1) - b(i, 1)*v(i, 3))
         middle(i, 3) = rest*v(i, 3) + along*b(i, 3) - 2*(b(i, 1)*v(i, 2) - b(i, 2)*v(i, 1))
      end do
   end subroutine turn_back

   !> Adds factor a×c.
   pure subroutine add_cross(factor, a, c, sums)
      real(wp), intent(in) :: factor(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: a(lanes, 3), c(lanes, 3)
      real(wp), intent(inout) :: sums(lanes, 3)
      integer :: i
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + factor(i)*(a(i, 2)*c(i, 3) - a(i, 3)*c(i, 2))
         sums(i, 2) = sums(i, 2) + factor(i)*(a(i, 3)*c(i, 1) - a(i, 1)*c(i, 3))
         sums(i, 3) = sums(i, 3) + factor(i)*(a(i, 1)*c(i, 2) - a(i, 2)*c(i, 1))
      end do
   end subroutine add_cross

   !> Takes new vectors in the lanes that are not done.
   pure subroutine keep_lanes(done, new, x)
      real(wp), intent(in) :: done(lanes), new(lanes, 3)
      real(wp), intent(inout) :: x(lanes, 3)
      real(wp) :: a, b
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            a = new(i, k)
            b = x(i, k)
            x(i, k) = merge(a, b, done(i) < 0.5_wp)
         end do
      end do
   end subroutine keep_lanes

   !> Adds the torque's part to F.
   pure subroutine add_weighted(weight, b, torque, f)
      real(wp), intent(in) :: weight(lanes), b(lanes, 3), torque(lanes, 3)
      real(wp), intent(inout) :: f(lanes, 3)
      real(wp) :: t1, t2, t3, more, along
      integer :: i
      do i = 1, lanes
         t1 = weight(i)*torque(i, 1)
         t2 = weight(i)*torque(i, 2)
         t3 = weight(i)*torque(i, 3)
         more = 1 + (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         along = 2*(0.0_wp + b(i, 1)*t1 + b(i, 2)*t2 + b(i, 3)*t3)
         f(i, 1) = f(i, 1) - more*t1 + along*b(i, 1)
         f(i, 2) = f(i, 2) - more*t2 + along*b(i, 2)
         f(i, 3) = f(i, 3) - more*t3 + along*b(i, 3)
      end do
   end subroutine add_weighted

   !> The derivative of what `add_to_residuals` adds, in the lanes where none is kept and the last increment was coarse.
   pure subroutine linearize(self, weight, at, kept, by_forces, stiffness)
      class(lane_loads_t), intent(in) :: self
      !> ½Δt²/4s
      real(wp), intent(in) :: weight(lanes)
      type(iteration_t), intent(in) :: at
      !> 1: there is one that is worth keeping.
      real(wp), intent(inout) :: kept(lanes)
      !> Shape (lanes, 3, 3).
      real(wp), intent(inout) :: by_forces(lanes, 3, 3)
      !> The largest of its numbers, at least 1.
      real(wp), intent(inout) :: stiffness(lanes)
      real(wp) :: renewed(lanes), torque(lanes, 3), by_b(lanes, 3, 3), turns(lanes, 3, 3), shrink(lanes)
      integer(long) :: any_renewed
      integer :: i, k
      any_renewed = 0
      do i = 1, lanes
         renewed(i) = (0.5_wp - sign(0.5_wp, coarse - at%size(i)))*(1 - kept(i))
         any_renewed = ior(any_renewed, transfer(renewed(i), any_renewed))
      end do
      if (any_renewed == 0) return
      call find_turns(at%z, shrink, turns)
      torque = 0.0_wp
      by_b = 0.0_wp
      do k = 1, self%n
         if (self%is_quadratic(k)) then
            call add_gradient_derivative(shrink, at%z, turns, self%direction(:, :, k), self%stiffness(:, :, :, k), &
                                         torque, by_b)
         else
            call add_derivative(shrink, at%z, turns, self%direction(:, :, k), self%slope(:, :, k), torque, by_b)
         end if
      end do
      do k = 1, 3
         call add_column(weight, at%z, torque, renewed, k, by_b(:, :, k), by_forces(:, :, k))
      end do
      do i = 1, lanes
         kept(i) = merge(1.0_wp, kept(i), renewed(i) > 0.5_wp)
      end do
      do i = 1, lanes
         stiffness(i) = max(1.0_wp, abs(by_forces(i, 1, 1)), abs(by_forces(i, 2, 1)), abs(by_forces(i, 3, 1)), &
                            abs(by_forces(i, 1, 2)), abs(by_forces(i, 2, 2)), abs(by_forces(i, 3, 2)), &
                            abs(by_forces(i, 1, 3)), abs(by_forces(i, 2, 3)), abs(by_forces(i, 3, 3)))
      end do
   end subroutine linearize

   !> 1/(1+β), and the turns of the attitude at mid step by the components of b.
   pure subroutine find_turns(b, shrink, turns)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: b(lanes, 3)
      !> Shape (lanes, 3, component).
      real(wp), intent(out) :: shrink(lanes), turns(lanes, 3, 3)
      real(wp) :: twice
      integer :: i
      do i = 1, lanes
         shrink(i) = 1/(1 + (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3)))
         twice = 2*shrink(i)
         turns(i, 1, 1) = twice
         turns(i, 2, 1) = twice*(0.0_wp - b(i, 3))
         turns(i, 3, 1) = twice*(0.0_wp + b(i, 2))
         turns(i, 1, 2) = twice*(0.0_wp + b(i, 3))
         turns(i, 2, 2) = twice
         turns(i, 3, 2) = twice*(0.0_wp - b(i, 1))
         turns(i, 1, 3) = twice*(0.0_wp - b(i, 2))
         turns(i, 2, 3) = twice*(0.0_wp + b(i, 1))
         turns(i, 3, 3) = twice
      end do
   end subroutine find_turns

   !> Adds τ̄ of one linear potential and its derivative by b.
   pure subroutine add_derivative(shrink, b, turns, direction, slope, torque, by_b)
      !> Shapes (lanes), (lanes, 3) and (lanes, 3, 3).
      real(wp), intent(in) :: shrink(lanes), b(lanes, 3), turns(lanes, 3, 3), direction(lanes, 3), slope(lanes, 3)
      real(wp), intent(inout) :: torque(lanes, 3), by_b(lanes, 3, 3)
      real(wp) :: middle(lanes, 3), own(lanes, 3), across(lanes, 3)
      integer :: i, j, k
      call turn_back(b, direction, middle)
      do k = 1, 3
         do i = 1, lanes
            middle(i, k) = shrink(i)*middle(i, k)
         end do
      end do
      own = 0.0_wp
      call add_cross(shrink, middle, slope, own)
      torque = torque + own
      do j = 1, 3
         call cross_lanes(middle, turns(:, :, j), across)
         do k = 1, 3
            do i = 1, lanes
               by_b(i, k, j) = by_b(i, k, j) - (2*shrink(i)*b(i, j))*own(i, k)
            end do
         end do
         call add_cross(shrink, across, slope, by_b(:, :, j))
      end do
   end subroutine add_derivative

   !> A column of the forces' part of the Jacobian, in the lanes where it is renewed.
   pure subroutine add_column(weight, b, torque, renewed, j, by_b, by_forces)
      real(wp), intent(in) :: weight(lanes), b(lanes, 3), torque(lanes, 3), renewed(lanes)
      !> Which column.
      integer, intent(in) :: j
      !> ∂τ̄/∂bⱼ; shape (lanes, 3).
      real(wp), intent(in) :: by_b(lanes, 3)
      real(wp), intent(inout) :: by_forces(lanes, 3)
      real(wp) :: column(lanes, 3), more(lanes), along(lanes), projected(lanes)
      integer :: i, k
      do i = 1, lanes
         more(i) = 1 + (b(i, 1)*b(i, 1) + b(i, 2)*b(i, 2) + b(i, 3)*b(i, 3))
         along(i) = 2*(0.0_wp + b(i, 1)*torque(i, 1) + b(i, 2)*torque(i, 2) + b(i, 3)*torque(i, 3))
         projected(i) = 2*((0.0_wp + b(i, 1)*by_b(i, 1) + b(i, 2)*by_b(i, 2) + b(i, 3)*by_b(i, 3)) + torque(i, j))
      end do
      do k = 1, 3
         do i = 1, lanes
            column(i, k) = more(i)*by_b(i, k) + (2*b(i, j))*torque(i, k) - projected(i)*b(i, k)
         end do
      end do
      do i = 1, lanes
         column(i, j) = column(i, j) - along(i)
      end do
      do k = 1, 3
         do i = 1, lanes
            column(i, k) = -weight(i)*column(i, k)
         end do
      end do
      call keep_lanes(1 - renewed, column, by_forces)
   end subroutine add_column

   !> The torque of the root itself, in the lanes where the last increment left it behind.
   pure subroutine follow(self, at, stiffness)
      class(lane_loads_t), intent(inout) :: self
      type(iteration_t), intent(in) :: at
      !> The largest derivative of F by potentials, at least 1.
      real(wp), intent(in) :: stiffness(lanes)
      real(wp) :: near(lanes), torque(lanes, 3)
      integer(long) :: left_behind
      integer :: i
      left_behind = 0
      do i = 1, lanes
         near(i) = 0.5_wp + sign(0.5_wp, 4*eps*at%length(i) - at%size(i)*stiffness(i))
         left_behind = ior(left_behind, transfer(1 - near(i), left_behind))
      end do
      if (left_behind == 0) return
      call find_torque(self, at%z, torque)
      call keep_lanes(near, torque, self%torque)
   end subroutine follow

   !> The increment of p that is not its turn: u∘Δt 2c½∘τ̄∘c½.
   pure subroutine find_impulse(self, dt, frame, b, factor, impulse)
      class(lane_loads_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: dt
      !> u, b and 2/(1+β); shapes (lanes, 4), (lanes, 3) and (lanes).
      real(wp), intent(in) :: frame(lanes, 4), b(lanes, 3), factor(lanes)
      !> Shape (lanes, 4).
      real(wp), intent(out) :: impulse(lanes, 4)
      real(wp) :: w, x, y, z
      integer :: i
      do i = 1, lanes
         x = (2*dt)*self%torque(i, 1)
         y = (2*dt)*self%torque(i, 2)
         z = (2*dt)*self%torque(i, 3)
         w = -factor(i)*(0.0_wp + b(i, 1)*x + b(i, 2)*y + b(i, 3)*z)
         x = x + w*b(i, 1)
         y = y + w*b(i, 2)
         z = z + w*b(i, 3)
         impulse(i, 1) = frame(i, 1)*w - frame(i, 2)*x - frame(i, 3)*y - frame(i, 4)*z
         impulse(i, 2) = frame(i, 1)*x + frame(i, 2)*w + frame(i, 3)*z - frame(i, 4)*y
         impulse(i, 3) = frame(i, 1)*y - frame(i, 2)*z + frame(i, 3)*w + frame(i, 4)*x
         impulse(i, 4) = frame(i, 1)*z + frame(i, 2)*y - frame(i, 3)*x + frame(i, 4)*w
      end do
   end subroutine find_impulse

end module nutate_lane_loads
