!> The tangent of a step of any explicit Runge-Kutta method: the variational equations with the same stages, which is
!> the exact derivative of the step.
!>
!> Inside the step the attitude has the four numbers δq, since stages are not normalised: δq = ½q∘θ at the start,
!> θ = 2 vec(q*∘δq)/|q|² at the end. The rates of a stage and their derivatives by all of y (`nutate_stage_rates`) are
!> evaluated once for all sensitivities.
module nutate_stage_tangent
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_product, rotate_to_body, rotate_to_space
   use nutate_rigid_rates, only: begin_step, n_rates, rigid_rates_t
   use nutate_specialised_stages, only: steady_ratio
   use nutate_stage_rates, only: most_numbers, stage_rates_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: stage_tangent_t, stage_weights_t, add_weighted

   !> Largest number of stages.
   integer, parameter :: most_stages = 12

   !> The weights of a method that are not zero.
   type :: stage_weights_t
      !> In each stage from the second on, and last in the step: number of weights, their stages, and the weights;
      !> shapes (2:stages+1), (most_stages, 2:stages+1).
      integer :: counts(2:most_stages + 1) = 0, which(most_stages, 2:most_stages + 1) = 0
      real(wp) :: w(most_stages, 2:most_stages + 1) = 0.0_wp
   contains
      !> Lists the weights of a method that are not zero.
      procedure :: list
   end type stage_weights_t

   !> The coefficients of a method, and the sensitivities inside a step.
   type :: stage_tangent_t
      private
      type(stage_weights_t) :: weights
      !> Times of the stages over Δt; shape (stages).
      real(wp), allocatable :: times(:)
      type(stage_rates_t) :: stage
      !> Weights of the errors of the two estimates, as for dop853; allocated if there are any; shape (stages, 2).
      real(wp), allocatable :: estimates(:, :)
      !> Axis about which the body rotates in the axes of the step, 0: none; Δt(1/J₃ - 1/J₃'), kg⁻¹ m⁻² s
      !> (`nutate_specialised_motion`). y(8) is its angle then.
      integer :: axis = 0
      real(wp) :: slip = 0.0_wp
      !> A stage of such a top in its own axes, to which parameters belong: y, and the rotation of the body.
      type(stage_rates_t) :: rotated_stage
      real(wp) :: rotated(8) = 0.0_wp, spin(4) = 0.0_wp
      !> k of the stages and y at the start of the step, of the motion; shapes (numbers, stages), (numbers).
      real(wp), allocatable :: rate(:, :)
      real(wp) :: first(most_numbers) = 0.0_wp
      !> Sensitivities at the start of the step and in a stage, and their rates in all stages; shapes (n, numbers),
      !> (n, numbers, stages).
      real(wp), allocatable :: start(:, :), point(:, :), rates(:, :, :)
   contains
      !> Sets the coefficients.
      procedure :: set
      !> Moves sensitivities over a step.
      procedure :: propagate
   end type stage_tangent_t

contains

   !> Sets the coefficients of a method.
   pure subroutine set(self, a, b, c, estimates)
      class(stage_tangent_t), intent(inout) :: self
      !> aᵢⱼ as a(j, i - 1), i from the second stage on; bᵢ; cᵢ.
      real(wp), intent(in) :: a(:, :), b(:), c(:)
      !> Weights of the errors of two estimates, the second a hundredfold that of a lower order; shape (stages, 2).
      real(wp), intent(in), optional :: estimates(:, :)
      call self%weights%list(a, b)
      self%times = c
      if (present(estimates)) self%estimates = estimates
   end subroutine set

   !> Moves sensitivities over a step in y = [q, L, W, h].
   subroutine propagate(self, rates, system, before, dt, window_time, tangent, homogeneous, axis)
      class(stage_tangent_t), intent(inout) :: self
      !> Rates that are prepared.
      type(rigid_rates_t), intent(inout) :: rates
      type(system_t), intent(in) :: system
      !> State at the start of the step, which succeeded.
      type(state_t), intent(in) :: before
      !> Length of the step and time that decides which torques act, as for the step, s.
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      !> True if torques are those at |q| = 1 times |q|²; default false.
      logical, intent(in), optional :: homogeneous
      !> Axis of a symmetric top whose step uses another J₃, 1 to 3; default 0, none.
      integer, intent(in), optional :: axis
      real(wp) :: y(n_rates), x(most_numbers)
      integer :: i, j, m
      call begin_step(rates, system, before, dt, window_time, y)
      associate (stage => self%stage)
         stage%works = system%effects%n_torques + rates%n_wheels > 0
         stage%n = merge(8, 7, stage%works) + rates%n_wheels
         stage%homogeneous = .false.
         if (present(homogeneous)) stage%homogeneous = homogeneous
         stage%attitude = rates%attitude
         stage%to_angle = rates%to_angle
         self%axis = 0
         if (present(axis)) self%axis = axis
      end associate
      if (self%axis > 0) call begin_spin(self, rates)
      m = self%stage%n
      call make_room(self, tangent%n, m)
      self%first(1:8) = y
      self%first(9:m) = before%wheel_momentum(:rates%n_wheels)
      call start_sensitivities(self, tangent%n, y(1:4), tangent%theta, tangent%momentum, self%start)
      if (m > 7) self%start(:, 8) = 0.0_wp
      if (m > 8) self%start(:, 9:m) = tangent%wheels(:, :m - 8)
      x = self%first
      self%point(:, :) = self%start
      do i = 1, size(self%times)
         if (i > 1) call take_argument(self, tangent%n*m, i, x)
         call self%stage%evaluate(rates, system, self%times(i), x(1:m))
         self%rate(:, i) = self%stage%rate(1:m)
         if (self%axis > 0) self%stage%jacobian(8, 4 + self%axis) = self%slip
         call multiply(tangent%n, m, self%stage%jacobian, self%point, self%rates(:, :, i))
         if (self%axis > 0 .and. size(tangent%parametric) > 0) call turn_stage(self, rates, system, x(1:m), i)
         do j = 1, size(tangent%parametric)
            call add_own(self, rates, system, tangent, j, x(1:m), i)
         end do
      end do
      call take_argument(self, tangent%n*m, size(self%times) + 1, x)
      call finish_sensitivities(tangent%n, m, x(1:4), self%point, tangent%theta, tangent%momentum)
      call estimate_error(self, x(5:7), tangent)
      if (self%stage%works) tangent%work = tangent%work + self%point(:, 8)
      if (self%axis > 0) call end_spin(self, x(5:7), tangent)
      do i = 1, rates%n_wheels
         tangent%wheels(:, i) = self%point(:, 8 + i)
      end do
   end subroutine propagate

   !> Estimates the error of the sensitivities at the end of a step as for the motion: |e|²/√(|e|² + |e'|²), each
   !> relative to the size of its sensitivity. It is zero if the method has no estimates.
   pure subroutine estimate_error(self, momentum, tangent)
      type(stage_tangent_t), intent(in) :: self
      !> L at the end; shape (3).
      real(wp), intent(in) :: momentum(3)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: off(7, 2), squares(2), weight, size_of
      integer :: i, k, m
      tangent%error = 0.0_wp
      if (.not. allocated(self%estimates)) return
      weight = max(sum(self%first(5:7)**2), sum(momentum**2))
      if (weight > tiny(1.0_wp)) weight = 1/weight
      do k = 1, tangent%n
         do m = 1, 2
            off(:, m) = 0.0_wp
            do i = 1, size(self%times)
               off(:, m) = off(:, m) + self%estimates(i, m)*self%rates(k, 1:7, i)
            end do
            squares(m) = 4*sum(off(1:4, m)**2) + weight*sum(off(5:7, m)**2)
         end do
         size_of = sum(tangent%theta(k, :)**2) + weight*sum(tangent%momentum(k, :)**2)
         if (.not. (size_of > tiny(1.0_wp) .and. squares(1) > 0.0_wp)) cycle
         tangent%error = max(tangent%error, squares(1)/sqrt(size_of*(squares(1) + squares(2))))
      end do
   end subroutine estimate_error

   !> Starts a step in the axes in which the body rotates about its axis of symmetry.
   pure subroutine begin_spin(self, rates)
      type(stage_tangent_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      real(wp) :: across
      integer :: i
      across = rates%to_angle(modulo(self%axis, 3) + 1, modulo(self%axis, 3) + 1)
      self%stage%to_angle = 0.0_wp
      do i = 1, 3
         self%stage%to_angle(i, i) = across
      end do
      self%stage%to_angle(self%axis, self%axis) = across/steady_ratio
      self%slip = rates%to_angle(self%axis, self%axis) - across/steady_ratio
      self%stage%n = 8
   end subroutine begin_spin

   !> Returns the rotation of the body in that frame up to a part of the step, as a quaternion; shape (4).
   pure function spin_until(self, part, momentum) result(s)
      type(stage_tangent_t), intent(in) :: self
      !> Part of the step; L; shape (3).
      real(wp), intent(in) :: part, momentum(3)
      real(wp) :: s(4), turn(3)
      turn = 0.0_wp
      turn(self%axis) = 0.5_wp*part*self%slip*momentum(self%axis)
      s = quat_exp(turn)
   end function spin_until

   !> Converts sensitivities to the axes of the body, which has rotated.
   pure subroutine end_spin(self, momentum, tangent)
      type(stage_tangent_t), intent(in) :: self
      !> L at the end, in the frame; shape (3).
      real(wp), intent(in) :: momentum(3)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: s(4), turn(3), rotated(3)
      integer :: k
      s = spin_until(self, 1.0_wp, momentum)
      rotated = rotate_to_body(s, momentum)
      do k = 1, tangent%n
         turn = 0.0_wp
         turn(self%axis) = self%point(k, 8)
         tangent%theta(k, :) = rotate_to_body(s, tangent%theta(k, :)) + turn
         tangent%momentum(k, :) = rotate_to_body(s, tangent%momentum(k, :)) + cross(rotated, turn)
      end do
   end subroutine end_spin

   !> Allocates the sensitivities.
   pure subroutine make_room(self, n, m)
      type(stage_tangent_t), intent(inout) :: self
      !> Number of sensitivities, and of components of each.
      integer, intent(in) :: n, m
      if (allocated(self%start)) then
         if (size(self%start, 1) == n .and. size(self%start, 2) == m) return
         deallocate (self%start, self%point, self%rates, self%rate)
      end if
      allocate (self%start(n, m), self%point(n, m), self%rates(n, m, size(self%times)), self%rate(m, size(self%times)))
   end subroutine make_room

   !> Sets δq = ½q∘θ, |q| nearly 1, and δL.
   pure subroutine start_sensitivities(self, n, q, theta, momentum, start)
      type(stage_tangent_t), intent(in) :: self
      integer, intent(in) :: n
      real(wp), intent(in) :: q(4)
      !> Shape (n,3).
      real(wp), intent(in) :: theta(n, 3), momentum(n, 3)
      real(wp), intent(inout) :: start(n, self%stage%n)
      real(wp) :: half(4)
      integer :: k
      half = 0.5_wp*q
      do k = 1, n
         start(k, 1) = -(half(2)*theta(k, 1) + half(3)*theta(k, 2) + half(4)*theta(k, 3))
         start(k, 2) = half(1)*theta(k, 1) + half(3)*theta(k, 3) - half(4)*theta(k, 2)
         start(k, 3) = half(1)*theta(k, 2) + half(4)*theta(k, 1) - half(2)*theta(k, 3)
         start(k, 4) = half(1)*theta(k, 3) + half(2)*theta(k, 2) - half(3)*theta(k, 1)
         start(k, 5) = momentum(k, 1)
         start(k, 6) = momentum(k, 2)
         start(k, 7) = momentum(k, 3)
      end do
   end subroutine start_sensitivities

   !> Computes the argument of a stage, or the end of the step, of the motion and of the sensitivities.
   pure subroutine take_argument(self, length, i, x)
      type(stage_tangent_t), intent(inout) :: self
      !> Number of components of all sensitivities; index of the stage.
      integer, intent(in) :: length, i
      real(wp), intent(inout) :: x(most_numbers)
      integer :: j
      x(1:self%stage%n) = self%first(1:self%stage%n)
      associate (count => self%weights%counts(i), which => self%weights%which(:, i), w => self%weights%w(:, i))
         do j = 1, count
            x(1:self%stage%n) = x(1:self%stage%n) + w(j)*self%rate(:, which(j))
         end do
         call add_weighted(length, size(self%times), count, which, w, self%start, self%rates, self%point)
      end associate
   end subroutine take_argument

   !> Lists the weights of a method that are not zero.
   pure subroutine list(self, a, b)
      class(stage_weights_t), intent(inout) :: self
      !> Coefficients aᵢⱼ as a(j, i - 1) and bᵢ, as in `set`.
      real(wp), intent(in) :: a(:, :), b(:)
      real(wp) :: weights(most_stages)
      integer :: i, j
      do i = 2, size(b) + 1
         weights = 0.0_wp
         if (i <= size(b)) then
            weights(:i - 1) = a(:i - 1, i - 1)
         else
            weights(:size(b)) = b
         end if
         self%counts(i) = 0
         do j = 1, size(b)
            if (.not. abs(weights(j)) > 0.0_wp) cycle
            self%counts(i) = self%counts(i) + 1
            self%which(self%counts(i), i) = j
            self%w(self%counts(i), i) = weights(j)
         end do
      end do
   end subroutine list

   !> Computes start + Σ w(j) rates(:, which(j)), four at a time.
   pure subroutine add_weighted(length, stages, count, which, w, start, rates, point)
      integer, intent(in) :: length, stages, count, which(most_stages)
      real(wp), intent(in) :: w(most_stages), start(length), rates(length, stages)
      real(wp), intent(out) :: point(length)
      integer :: j, first
      first = modulo(count, 4)
      select case (first)
      case (1)
         point = start + w(1)*rates(:, which(1))
      case (2)
         point = start + w(1)*rates(:, which(1)) + w(2)*rates(:, which(2))
      case (3)
         point = start + w(1)*rates(:, which(1)) + w(2)*rates(:, which(2)) + w(3)*rates(:, which(3))
      case default
         point = start
      end select
      do j = first + 1, count, 4
         point = point + w(j)*rates(:, which(j)) + w(j + 1)*rates(:, which(j + 1)) &
                 + w(j + 2)*rates(:, which(j + 2)) + w(j + 3)*rates(:, which(j + 3))
      end do
   end subroutine add_weighted

   !> Computes δk of sensitivities from the derivative of a stage.
   pure subroutine multiply(n, m, a, x, rate)
      !> Number of sensitivities, and of components of each.
      integer, intent(in) :: n, m
      !> ∂k/∂y
      real(wp), intent(in) :: a(most_numbers, most_numbers)
      !> Shape (n, m).
      real(wp), intent(in) :: x(n, m)
      real(wp), intent(out) :: rate(n, m)
      integer :: i, j
      ! The derivative of δk with respect to δq has no diagonal.
      rate(:, 1) = a(1, 2)*x(:, 2) + a(1, 3)*x(:, 3) + a(1, 4)*x(:, 4) + a(1, 5)*x(:, 5) + a(1, 6)*x(:, 6) &
                   + a(1, 7)*x(:, 7)
      rate(:, 2) = a(2, 1)*x(:, 1) + a(2, 3)*x(:, 3) + a(2, 4)*x(:, 4) + a(2, 5)*x(:, 5) + a(2, 6)*x(:, 6) &
                   + a(2, 7)*x(:, 7)
      rate(:, 3) = a(3, 1)*x(:, 1) + a(3, 2)*x(:, 2) + a(3, 4)*x(:, 4) + a(3, 5)*x(:, 5) + a(3, 6)*x(:, 6) &
                   + a(3, 7)*x(:, 7)
      rate(:, 4) = a(4, 1)*x(:, 1) + a(4, 2)*x(:, 2) + a(4, 3)*x(:, 3) + a(4, 5)*x(:, 5) + a(4, 6)*x(:, 6) &
                   + a(4, 7)*x(:, 7)
      do i = 5, m
         rate(:, i) = a(i, 1)*x(:, 1) + a(i, 2)*x(:, 2) + a(i, 3)*x(:, 3) + a(i, 4)*x(:, 4) + a(i, 5)*x(:, 5) &
                      + a(i, 6)*x(:, 6) + a(i, 7)*x(:, 7)
      end do
      do j = 9, m
         do i = 1, m
            rate(:, i) = rate(:, i) + a(i, j)*x(:, j)
         end do
      end do
   end subroutine multiply

   !> Evaluates a stage of a top in body axes.
   subroutine turn_stage(self, rates, system, y, i)
      type(stage_tangent_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: y(:)
      !> Index of the stage.
      integer, intent(in) :: i
      self%spin = spin_until(self, self%times(i), y(5:7))
      self%rotated = y
      self%rotated(1:4) = quat_product(y(1:4), self%spin)
      self%rotated(5:7) = rotate_to_body(self%spin, y(5:7))
      self%rotated_stage%n = 8
      self%rotated_stage%homogeneous = self%stage%homogeneous
      self%rotated_stage%to_angle = rates%to_angle
      call self%rotated_stage%evaluate(rates, system, self%times(i), self%rotated)
   end subroutine turn_stage

   !> Adds the effect of the parameters of a sensitivity in a stage.
   subroutine add_own(self, rates, system, tangent, m, y, i)
      type(stage_tangent_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      type(tangent_t), intent(in) :: tangent
      !> Index among the parametric sensitivities, and index of the stage.
      integer, intent(in) :: m, i
      real(wp), intent(in) :: y(:)
      real(wp) :: change(size(y)), inertia(3, 3)
      integer :: k
      k = tangent%parametric(m)
      if (self%axis == 0) then
         inertia = tangent%inertia_of(system%effects, m, rates%t + self%times(i)*rates%dt)
         call self%stage%own_change(rates, system, tangent%variations(k), inertia, y, change)
         if (system%effects%reshapes) &
            call self%stage%add_reshaped(rates, system, tangent%variations(k), inertia, change)
      else
         call self%rotated_stage%own_change(rates, system, tangent%variations(k), tangent%inertia(:, :, m), &
            self%rotated, &
                                           change)
         change(1:4) = quat_product(change(1:4), quat_conjugate(self%spin))
         change(5:7) = rotate_to_space(self%spin, change(5:7))
      end if
      self%rates(k, :, i) = self%rates(k, :, i) + change
   end subroutine add_own

   !> Computes θ = 2 vec(q*∘δq)/|q|² and δL.
   pure subroutine finish_sensitivities(n, m, q, point, theta, momentum)
      !> Number of sensitivities, and of components of each.
      integer, intent(in) :: n, m
      real(wp), intent(in) :: q(4)
      real(wp), intent(in) :: point(n, m)
      !> Shape (n,3).
      real(wp), intent(out) :: theta(n, 3), momentum(n, 3)
      real(wp) :: g(4)
      integer :: k
      g = (2/(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)))*q
      do k = 1, n
         theta(k, 1) = g(1)*point(k, 2) - g(2)*point(k, 1) - g(3)*point(k, 4) + g(4)*point(k, 3)
         theta(k, 2) = g(1)*point(k, 3) - g(3)*point(k, 1) - g(4)*point(k, 2) + g(2)*point(k, 4)
         theta(k, 3) = g(1)*point(k, 4) - g(4)*point(k, 1) - g(2)*point(k, 3) + g(3)*point(k, 2)
         momentum(k, 1) = point(k, 5)
         momentum(k, 2) = point(k, 6)
         momentum(k, 3) = point(k, 7)
      end do
   end subroutine finish_sensitivities

end module nutate_stage_tangent
