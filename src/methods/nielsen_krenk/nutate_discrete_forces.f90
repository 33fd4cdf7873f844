!> Effects in one step of the conserving scheme: their generalised force at mid step and its derivatives.
!>
!> A step is seen from the frame `u` of its start: q = u∘x, so that x0 = (|q0|, 0, 0, 0). Every effect then enters as a
!> body quantity `s = [s0, τ]` at mid step with the force `f = 2 x̄∘s/|x̄|²`, whose work in the step is exactly Δt Ω̄·τ.
!>
!> **Finite derivative of the potential.** With γ(x) = R(x)ᵀn, quadratic in x, and a discrete gradient ∇̄U·Δγ = ΔU, the
!> derivative ∂V*/∂x = γ'(x̄)ᵀ∇̄U has Δx·∂V*/∂x = ΔV exactly. Since `γ'(x̄)ᵀg = 2 x̄∘[γ·g, g×γ]/|x̄|²`, its force
!> -∂V*/∂x is that of s = [-γ(x̄)·∇̄U, γ(x̄)×∇̄U].
!>
!> **Projection**, equation (11) of Nielsen & Krenk (2012). I - x̄x̄ᵀ/x̄ᵀx̄ removes the part of a force along x̄. In f
!> this part is the scalar part of s, and nothing else: the projection is the *absence* of a scalar part, s = [0, τ]
!> instead of s = [-γ(x̄)·∇̄U, τ]. No projector is ever multiplied; `self%projection` suppresses the scalar part in
!> `evaluate` and `add_potential_derivative`.
module nutate_discrete_forces
   use nutate_effect, only: LINEAR_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_conjugate, quat_left_matrix, quat_product, rotate_to_body, &
      rotation_matrix
   use nutate_small_products, only: deviator, times_columns, times_vector
   implicit none
   private

   public :: discrete_forces_t

   !> Part of ∇U at mid step that changes of the body since t = 0 add, without the part that exerts no torque: Eγ + g;
   !> shapes (3,3, number of potentials) and (3, number of potentials).
   type :: potential_changes_t
      real(wp), allocatable :: stiffness(:, :, :), push(:, :)
   end type potential_changes_t

   !> The effects of one step, with the data that do not change during its iteration.
   type :: discrete_forces_t
      !> There is an effect that exerts a force; one that depends on the rate: a torque or an inner sphere.
      logical :: active = .false., follows_rate = .false.
      !> At least one of them depends on the attitude.
      logical :: by_attitude = .false.
      !> The projection (11): s has no scalar part. Without it potentials have a force along q too.
      logical :: projection = .true.
      !> Middle of the step, s.
      real(wp) :: t = 0.0_wp
      !> u, body→space at the start of the step; shape (4).
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> R(u)ᵀ n of each potential; shape (3, number of potentials).
      real(wp), allocatable :: direction(:, :)
      !> γ at the start of the step; shape (3, number of potentials).
      real(wp), allocatable :: gamma0(:, :)
      !> ∇U of potentials for which it is constant, and which potentials these are; `turn` does not evaluate them. Shape
      !> (3, number of potentials) and (number of potentials).
      real(wp), allocatable :: slope(:, :)
      logical, allocatable :: is_linear(:)
      !> Some potentials vary with the body; their changes, not allocated if none does.
      logical :: reshapes = .false.
      type(potential_changes_t), allocatable :: changes
      !> All effects are potentials with constant ∇U; R(u), shape (3,3), if there are potentials.
      logical :: in_fields = .false.
      real(wp) :: columns(3, 3) = 0.0_wp
      !> There are inner spheres, whose torque is R(c½)ᵀD - KΩ̄ (`nutate_sphere_steps`); D, N m, seen from u, shape (3),
      !> and K, N m s, set at the start of a step.
      logical :: has_spheres = .false.
      real(wp) :: pull(3) = 0.0_wp, drag = 0.0_wp
      !> The torque acts in this step; shape (number of torques). Not allocated if there are no torques.
      logical, allocatable :: acts(:)
   contains
      !> Allocates the arrays for the effects of a system.
      procedure :: prepare
      !> Starts a step.
      procedure :: start
      !> Adds to a discrete gradient, and its derivatives, what changes of the body add.
      procedure :: add_changes
      !> Computes s = [s0, τ] for an end of the step.
      procedure :: evaluate
      !> Computes s and its derivatives.
      procedure :: linearize
      !> Computes τ of a step that rotates a unit attitude by a Cayley map.
      procedure :: turn
      !> Computes τ as `turn` does, if all effects are uniform fields.
      procedure :: turn_in_fields
      !> Computes τ as `turn` does, and its derivatives.
      procedure :: linearize_turn
      !> Computes the part of the torque that is proportional to the rate, and the rate of change of the torque with
      !> time.
      procedure :: split_turn
      !> Computes the work of each torque in the step.
      procedure :: get_work
      !> Moves the allocated arrays to another variable.
      procedure :: move_to
   end type discrete_forces_t

contains

   !> Allocates the arrays for the effects of a system.
   pure subroutine prepare(self, effects, projection)
      class(discrete_forces_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      logical, intent(in) :: projection
      integer :: i
      self%has_spheres = effects%n_spheres > 0
      self%follows_rate = effects%n_torques > 0 .or. self%has_spheres
      self%active = effects%n_potentials > 0 .or. self%follows_rate
      self%by_attitude = effects%needs_attitude()
      self%projection = projection
      self%in_fields = .false.
      if (allocated(self%acts)) deallocate (self%acts)
      if (effects%n_torques > 0) allocate (self%acts(effects%n_torques), source=.true.)
      if (allocated(self%direction)) deallocate (self%direction, self%gamma0, self%slope, self%is_linear)
      if (allocated(self%changes)) deallocate (self%changes)
      self%reshapes = effects%n_potentials > 0 .and. effects%reshapes
      if (self%reshapes) then
         allocate (self%changes)
         allocate (self%changes%stiffness(3, 3, effects%n_potentials), self%changes%push(3, effects%n_potentials), &
                   source=0.0_wp)
      end if
      if (effects%n_potentials == 0) return
      allocate (self%direction(3, effects%n_potentials), self%gamma0(3, effects%n_potentials), &
                self%slope(3, effects%n_potentials), source=0.0_wp)
      allocate (self%is_linear(effects%n_potentials), source=.false.)
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            self%is_linear(i) = potential%is_linear()
            if (self%is_linear(i)) self%slope(:, i) = -potential%series_moment()
         end associate
      end do
      self%in_fields = effects%n_torques == 0 .and. all(self%is_linear) .and. .not. self%has_spheres
   end subroutine prepare

   !> Moves the allocated arrays to another variable, without a copy; they must be moved back.
   pure subroutine move_to(self, other)
      class(discrete_forces_t), intent(inout) :: self
      type(discrete_forces_t), intent(inout) :: other
      other%active = self%active
      other%follows_rate = self%follows_rate
      other%by_attitude = self%by_attitude
      other%has_spheres = self%has_spheres
      other%projection = self%projection
      other%in_fields = self%in_fields
      other%reshapes = self%reshapes
      if (allocated(self%changes)) call move_alloc(self%changes, other%changes)
      if (allocated(self%acts)) call move_alloc(self%acts, other%acts)
      if (.not. allocated(self%direction)) return
      call move_alloc(self%direction, other%direction)
      call move_alloc(self%gamma0, other%gamma0)
      call move_alloc(self%slope, other%slope)
      call move_alloc(self%is_linear, other%is_linear)
   end subroutine move_to

   !> Starts a step at the attitude q0 = |q0| u.
   pure subroutine start(self, effects, t, frame, norm, window_time)
      class(discrete_forces_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Middle of the step, s.
      real(wp), intent(in) :: t
      !> u, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: frame(4)
      !> Norm |q0|.
      real(wp), intent(in) :: norm
      !> Time that decides which torques act, s; default: `t`.
      real(wp), intent(in), optional :: window_time
      real(wp) :: moment, square, n(3)
      integer :: i, j
      moment = t
      if (present(window_time)) moment = window_time
      do i = 1, effects%n_torques
         self%acts(i) = effects%torques(i)%item%acts_at(moment)
      end do
      self%t = t
      self%frame = frame
      if (effects%n_potentials == 0) return
      self%columns = rotation_matrix(frame)
      square = norm*norm
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item, columns => self%columns)
            n = potential%direction
            if (potential%moves) n = potential%direction_at(t)
            do j = 1, 3
               self%direction(j, i) = columns(1, j)*n(1) + columns(2, j)*n(2) + columns(3, j)*n(3)
               self%gamma0(j, i) = square*self%direction(j, i)
            end do
         end associate
      end do
      if (self%reshapes) call reshape_potentials(self, effects)
   end subroutine start

   !> Computes what changes of the body add to the potentials at mid step.
   pure subroutine reshape_potentials(self, effects)
      use nutate_reshaped_potential, only: potential_term
      class(discrete_forces_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (.not. potential%varies) cycle
            call potential_term(effects, i, 0, self%t, self%t, 1.0_wp, self%changes%stiffness(:, :, i), &
                                self%changes%push(:, i))
            self%changes%stiffness(:, :, i) = deviator(self%changes%stiffness(:, :, i))
            if (self%is_linear(i)) self%slope(:, i) = self%changes%push(:, i) - potential%series_moment()
         end associate
      end do
   end subroutine reshape_potentials

   !> Adds to a discrete gradient what changes of the body add, and to its derivatives by both ends, which are equal.
   pure subroutine add_changes(self, i, gamma0, gamma1, gradient, hessian)
      class(discrete_forces_t), intent(in) :: self
      !> Index of the potential.
      integer, intent(in) :: i
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp), intent(inout) :: gradient(3)
      real(wp), intent(inout), optional :: hessian(3, 3)
      gradient = gradient + self%changes%push(:, i) + &
                 times_vector(self%changes%stiffness(:, :, i), 0.5_wp*(gamma0 + gamma1))
      if (present(hessian)) hessian = hessian + 0.5_wp*self%changes%stiffness(:, :, i)
   end subroutine add_changes

   !> Computes s = [s0, τ] for a step that ends at x1. τ is the sum of γ(x̄)×∇̄U(γ0, γ1), the finite derivatives of the
   !> potentials, and of the torques at t̄, x̄/|x̄|, Ω̄. s0 = 0 is the projection (11); without it s0 = -Σ γ(x̄)·∇̄U.
   pure subroutine evaluate(self, effects, x1, xm, omega, s)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> End and mean of the step, start frame; shape (4).
      real(wp), intent(in) :: x1(4), xm(4)
      !> Ω̄, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> [s0, τ], body axes, N m; shape (4).
      real(wp), intent(out) :: s(4)
      real(wp) :: gamma(3), gradient(3), attitude(4)
      integer :: i
      s = 0.0_wp
      if (self%reshapes) then
         call add_reshaped(self, effects, x1, xm, s)
      else
         do i = 1, effects%n_potentials
            gamma = rotate_to_body(xm, self%direction(:, i))
            gradient = effects%potentials(i)%item%discrete_gradient(self%gamma0(:, i), &
                                                                    rotate_to_body(x1, self%direction(:, i)))
            s(2:4) = s(2:4) + cross(gamma, gradient)
            if (.not. self%projection) s(1) = s(1) - dot_product(gamma, gradient)
         end do
      end if
      if (.not. self%follows_rate) return
      if (self%has_spheres) s(2:4) = s(2:4) + rotate_to_body(xm, self%pull)/dot_product(xm, xm) - self%drag*omega
      attitude = mid_attitude(self%frame, xm)
      do i = 1, effects%n_torques
         if (self%acts(i)) s(2:4) = s(2:4) + effects%torques(i)%item%torque(self%t, attitude, omega)
      end do
   end subroutine evaluate

   !> Adds the potentials to s as `evaluate` does, with what changes of the body add: a test of each potential would
   !> slow down those of other bodies.
   pure subroutine add_reshaped(self, effects, x1, xm, s)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: x1(4), xm(4)
      real(wp), intent(inout) :: s(4)
      real(wp) :: gamma(3), gradient(3)
      integer :: i
      do i = 1, effects%n_potentials
         gamma = rotate_to_body(xm, self%direction(:, i))
         gradient = reshaped_gradient(self, effects, i, rotate_to_body(x1, self%direction(:, i)))
         s(2:4) = s(2:4) + cross(gamma, gradient)
         if (.not. self%projection) s(1) = s(1) - dot_product(gamma, gradient)
      end do
   end subroutine add_reshaped

   !> Returns ∇̄U of a potential with what changes of the body add; shape (3).
   pure function reshaped_gradient(self, effects, i, gamma1) result(gradient)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> γ at the end of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma1(3)
      real(wp) :: gradient(3)
      gradient = effects%potentials(i)%item%discrete_gradient(self%gamma0(:, i), gamma1)
      call self%add_changes(i, self%gamma0(:, i), gamma1, gradient)
   end function reshaped_gradient

   !> Computes s, ∂s/∂x1 (x̄ moving with x1, Ω̄ fixed) and ∂τ/∂Ω̄.
   pure subroutine linearize(self, effects, x1, xm, omega, s, by_x, by_rate)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> End and mean of the step, start frame; shape (4).
      real(wp), intent(in) :: x1(4), xm(4)
      !> Ω̄, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> [s0, τ], body axes, N m; shape (4).
      real(wp), intent(out) :: s(4)
      !> ∂s/∂x1; shape (4,4).
      real(wp), intent(out) :: by_x(4, 4)
      !> ∂τ/∂Ω̄; shape (3,3).
      real(wp), intent(out) :: by_rate(3, 3)
      real(wp) :: attitude(4), rotation(3, 3), rate(3, 3), angle_by_x(4, 4), pull(3)
      integer :: i, j
      call self%evaluate(effects, x1, xm, omega, s)
      by_x = 0.0_wp
      by_rate = 0.0_wp
      do i = 1, effects%n_potentials
         call add_potential_derivative(self, effects, i, x1, xm, by_x)
      end do
      if (.not. self%follows_rate) return
      ! The small rotation of x̄ + ½δx against x̄ is θ = vec(x̄*∘δx)/|x̄|², body axes.
      angle_by_x = quat_left_matrix(quat_conjugate(xm))/dot_product(xm, xm)
      if (self%has_spheres) then
         pull = rotate_to_body(xm, self%pull)/dot_product(xm, xm)
         do j = 1, 4
            by_x(2:4, j) = by_x(2:4, j) + cross(pull, angle_by_x(2:4, j))
         end do
         do j = 1, 3
            by_rate(j, j) = by_rate(j, j) - self%drag
         end do
      end if
      if (effects%n_torques == 0) return
      attitude = mid_attitude(self%frame, xm)
      do i = 1, effects%n_torques
         if (.not. self%acts(i)) cycle
         call effects%torques(i)%item%derivatives(self%t, attitude, omega, rotation, rate)
         do j = 1, 4
            by_x(2:4, j) = by_x(2:4, j) + times_vector(rotation, angle_by_x(2:4, j))
         end do
         by_rate = by_rate + rate
      end do
   end subroutine linearize

   !> Adds ∂[-γ̄·∇̄U, γ̄×∇̄U]/∂x1 of one potential, of the scalar part only without projection; γ'(x)δ = 2 vec(x*∘n∘δ).
   pure subroutine add_potential_derivative(self, effects, i, x1, xm, by_x)
      type(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: i
      real(wp), intent(in) :: x1(4), xm(4)
      real(wp), intent(inout) :: by_x(4, 4)
      real(wp) :: n(4), gamma(3), gamma1(3), gradient(3), hessian(3, 3), at_mean(4, 4), at_end(4, 4), slope(3)
      integer :: j
      n = [0.0_wp, self%direction(1, i), self%direction(2, i), self%direction(3, i)]
      gamma = rotate_to_body(xm, n(2:4))
      gamma1 = rotate_to_body(x1, n(2:4))
      associate (potential => effects%potentials(i)%item)
         gradient = potential%discrete_gradient(self%gamma0(:, i), gamma1)
         hessian = potential%discrete_hessian(self%gamma0(:, i), gamma1)
      end associate
      if (self%reshapes) call self%add_changes(i, self%gamma0(:, i), gamma1, gradient, hessian)
      at_mean = quat_left_matrix(quat_product(quat_conjugate(xm), n))
      at_end = 2*quat_left_matrix(quat_product(quat_conjugate(x1), n))
      do j = 1, 4
         slope = times_vector(hessian, at_end(2:4, j))
         by_x(2:4, j) = by_x(2:4, j) + cross(at_mean(2:4, j), gradient) + cross(gamma, slope)
         if (.not. self%projection) &
            by_x(1, j) = by_x(1, j) - dot_product(at_mean(2:4, j), gradient) - dot_product(gamma, slope)
      end do
   end subroutine add_potential_derivative

   !> Computes τ at mid step for the rotation c = (1+b)∘(1-b)⁻¹ of a unit attitude: the result of `evaluate` for x1 = c,
   !> x̄ = (1+b)/(1+|b|²), always projected.
   pure subroutine turn(self, effects, b, rate, tau)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> b = ¼Δt Ω̄; shape (3).
      real(wp), intent(in) :: b(3)
      !> 4/Δt, 1/s.
      real(wp), intent(in) :: rate
      !> τ, body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      real(wp) :: middle(3), gradient(3), attitude(4), shrink, square, t1, t2, t3
      integer :: i
      shrink = 1/(1 + b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
      square = shrink*shrink
      if (self%reshapes) then
         call turn_reshaped(self, effects, b, square, tau)
      else
         t1 = 0.0_wp
         t2 = 0.0_wp
         t3 = 0.0_wp
         do i = 1, effects%n_potentials
            middle = rotated_back(b, self%direction(:, i))
            if (self%is_linear(i)) then
               gradient = self%slope(:, i)
            else
               gradient = effects%potentials(i)%item%discrete_gradient(self%gamma0(:, i), &
                                                                       square*rotated_back(b, middle))
            end if
            t1 = t1 + square*(middle(2)*gradient(3) - middle(3)*gradient(2))
            t2 = t2 + square*(middle(3)*gradient(1) - middle(1)*gradient(3))
            t3 = t3 + square*(middle(1)*gradient(2) - middle(2)*gradient(1))
         end do
         tau(1) = t1
         tau(2) = t2
         tau(3) = t3
      end if
      if (.not. self%follows_rate) return
      if (self%has_spheres) tau = tau + (shrink*rotated_back(b, self%pull) - (self%drag*rate)*b)
      attitude = half_rotated(self%frame, b, shrink)
      do i = 1, effects%n_torques
         if (self%acts(i)) tau = tau + effects%torques(i)%item%torque(self%t, attitude, rate*b)
      end do
   end subroutine turn

   !> Computes τ as `turn` does, up to rounding, if all effects are potentials that are linear in a direction.
   pure subroutine turn_in_fields(self, b, stretch, tau)
      class(discrete_forces_t), intent(in) :: self
      !> b = ¼Δt Ω̄, shape (3), and 1 + |b|².
      real(wp), intent(in) :: b(3), stretch
      !> τ, body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      call sum_fields(size(self%slope, 2), self%direction, self%slope, b, stretch, tau)
   end subroutine turn_in_fields

   !> Adds τ of the potentials as `turn` does, with what changes of the body add.
   pure subroutine turn_reshaped(self, effects, b, square, tau)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> b = ¼Δt Ω̄, shape (3), and 1/(1+|b|²)².
      real(wp), intent(in) :: b(3), square
      real(wp), intent(out) :: tau(3)
      real(wp) :: middle(3), gradient(3)
      integer :: i
      tau = 0.0_wp
      do i = 1, effects%n_potentials
         middle = rotated_back(b, self%direction(:, i))
         if (self%is_linear(i)) then
            gradient = self%slope(:, i)
         else
            gradient = reshaped_gradient(self, effects, i, square*rotated_back(b, middle))
         end if
         tau = tau + square*cross_of(middle, gradient)
      end do
   end subroutine turn_reshaped

   !> Computes τ as `turn_in_fields` does, from directions and gradients.
   pure subroutine sum_fields(n_fields, direction, gradient, b, stretch, tau)
      integer, intent(in) :: n_fields
      !> R(u)ᵀn and ∇U; shape (3, n_fields).
      real(wp), intent(in) :: direction(3, n_fields), gradient(3, n_fields)
      !> b and 1 + |b|² as in `turn_in_fields`.
      real(wp), intent(in) :: b(3), stretch
      real(wp), intent(out) :: tau(3)
      real(wp) :: along, x, y, z, t1, t2, t3, shrink
      integer :: i
      t1 = 0.0_wp
      t2 = 0.0_wp
      t3 = 0.0_wp
      ! For one or two fields the preparation of vector instructions costs more than it saves.
      !GCC$ novector
      do i = 1, n_fields
         associate (n => direction(:, i), g => gradient(:, i))
            along = b(1)*n(1) + b(2)*n(2) + b(3)*n(3)
            x = (2 - stretch)*n(1) + 2*(along*b(1) + (n(2)*b(3) - n(3)*b(2)))
            y = (2 - stretch)*n(2) + 2*(along*b(2) + (n(3)*b(1) - n(1)*b(3)))
            z = (2 - stretch)*n(3) + 2*(along*b(3) + (n(1)*b(2) - n(2)*b(1)))
            t1 = t1 + (y*g(3) - z*g(2))
            t2 = t2 + (z*g(1) - x*g(3))
            t3 = t3 + (x*g(2) - y*g(1))
         end associate
      end do
      shrink = 1/(stretch*stretch)
      tau(1) = shrink*t1
      tau(2) = shrink*t2
      tau(3) = shrink*t3
   end subroutine sum_fields

   !> Computes τ as `turn` does, and ∂τ/∂b. A change δb rotates the attitude at mid step by θ = 2(δb - b×δb)/(1+|b|²) in
   !> body axes there, and the attitude at the end by θ + R(c½)ᵀθ, and scales x̄.
   pure subroutine linearize_turn(self, effects, b, rate, tau, by_b)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> b = ¼Δt Ω̄; shape (3).
      real(wp), intent(in) :: b(3)
      !> 4/Δt, 1/s.
      real(wp), intent(in) :: rate
      !> τ, body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      !> ∂τ/∂b; shape (3,3).
      real(wp), intent(out) :: by_b(3, 3)
      real(wp) :: shrink, turns(3, 3), attitude(4), rotation(3, 3), by_rate(3, 3), pull(3)
      integer :: i, j
      shrink = 1/(1 + dot_product(b, b))
      do j = 1, 3
         turns(:, j) = 0.0_wp
         turns(j, j) = 1.0_wp
         turns(:, j) = (2*shrink)*(turns(:, j) - cross_of(b, turns(:, j)))
      end do
      tau = 0.0_wp
      by_b = 0.0_wp
      do i = 1, effects%n_potentials
         call add_rotated_potential(self, effects, i, b, turns, tau, by_b)
      end do
      if (self%has_spheres) then
         pull = shrink*rotated_back(b, self%pull)
         tau = tau + pull - (self%drag*rate)*b
         do j = 1, 3
            by_b(:, j) = by_b(:, j) + cross_of(pull, turns(:, j))
            by_b(j, j) = by_b(j, j) - self%drag*rate
         end do
      end if
      if (effects%n_torques == 0) return
      attitude = half_rotated(self%frame, b, shrink)
      do i = 1, effects%n_torques
         if (.not. self%acts(i)) cycle
         tau = tau + effects%torques(i)%item%torque(self%t, attitude, rate*b)
         call effects%torques(i)%item%derivatives(self%t, attitude, rate*b, rotation, by_rate)
         by_b = by_b + times_columns(rotation, turns) + rate*by_rate
      end do
   end subroutine linearize_turn

   !> Adds τ of one potential and its derivative with respect to b.
   pure subroutine add_rotated_potential(self, effects, i, b, turns, tau, by_b)
      type(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: i
      !> b, and the rotations θ of the attitude at mid step by its three components; shape (3,3).
      real(wp), intent(in) :: b(3), turns(3, 3)
      real(wp), intent(inout) :: tau(3), by_b(3, 3)
      real(wp) :: middle(3), end(3), gradient(3), hessian(3, 3), own(3), shrink
      integer :: j
      shrink = 1/(1 + dot_product(b, b))
      middle = shrink*rotated_back(b, self%direction(:, i))
      end = shrink*rotated_back(b, middle)
      gradient = effects%potentials(i)%item%discrete_gradient(self%gamma0(:, i), end)
      hessian = effects%potentials(i)%item%discrete_hessian(self%gamma0(:, i), end)
      if (self%reshapes) call self%add_changes(i, self%gamma0(:, i), end, gradient, hessian)
      own = shrink*cross_of(middle, gradient)
      tau = tau + own
      do j = 1, 3
         by_b(:, j) = by_b(:, j) - (2*shrink*b(j))*own + shrink*( &
                      cross_of(cross_of(middle, turns(:, j)), gradient) &
                      + cross_of(middle, times_vector(hessian, cross_of(end, turns(:, j) &
                                                                        + shrink*rotated_back(b, turns(:, j))))))
      end do
   end subroutine add_rotated_potential

   !> Computes the part of τ of `turn` that is proportional to the rate, and ∂τ/∂t at fixed attitude and rate.
   pure subroutine split_turn(self, effects, b, rate, span, drag, change)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> b = ¼Δt Ω̄; shape (3).
      real(wp), intent(in) :: b(3)
      !> 4/Δt, 1/s, and a time that is long for the changes of the torques, s.
      real(wp), intent(in) :: rate, span
      !> Drag, body axes, N m; ∂τ/∂t, body axes, N m/s; shape (3).
      real(wp), intent(out) :: drag(3), change(3)
      real(wp) :: attitude(4)
      integer :: i
      drag = 0.0_wp
      change = 0.0_wp
      if (effects%n_torques == 0) return
      attitude = half_rotated(self%frame, b, 1/(1 + dot_product(b, b)))
      do i = 1, effects%n_torques
         if (.not. self%acts(i)) cycle
         associate (torque => effects%torques(i)%item)
            if (torque%series_kind() == LINEAR_SERIES) then
               drag = drag + times_vector(torque%series_drag(), rate*b)
            else
               change = change + torque%time_derivative(self%t, attitude, rate*b, span)
            end if
         end associate
      end do
   end subroutine split_turn

   !> Computes Δt Ω̄·τ of each torque: the work it does in the step, to round-off.
   pure subroutine get_work(self, effects, dt, xm, omega, work)
      class(discrete_forces_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      !> Mean of the step, start frame; shape (4).
      real(wp), intent(in) :: xm(4)
      !> Ω̄, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> Work, J; shape (number of torques).
      real(wp), intent(inout) :: work(:)
      real(wp) :: attitude(4)
      integer :: i
      attitude = mid_attitude(self%frame, xm)
      do i = 1, effects%n_torques
         work(i) = 0.0_wp
         if (self%acts(i)) work(i) = dt*dot_product(omega, effects%torques(i)%item%torque(self%t, attitude, omega))
      end do
   end subroutine get_work

   !> Returns u∘x̄/|x̄|: attitude at mid step, body→space.
   pure function mid_attitude(frame, xm) result(q)
      real(wp), intent(in) :: frame(4), xm(4)
      real(wp) :: q(4)
      q = quat_product(frame, xm)/norm2(xm)
   end function mid_attitude

   !> Returns vec((1-b)∘v∘(1+b)): v rotated back by half the step's rotation, times 1+|b|².
   pure function rotated_back(b, v) result(r)
      real(wp), intent(in) :: b(3), v(3)
      real(wp) :: r(3)
      r = (1 - (b(1)*b(1) + b(2)*b(2) + b(3)*b(3)))*v + (2*(b(1)*v(1) + b(2)*v(2) + b(3)*v(3)))*b - 2*cross_of(b, v)
   end function rotated_back

   !> Returns u∘(1+b)/|1+b|: attitude at mid step, body→space; shrink = 1/|1+b|².
   pure function half_rotated(u, b, shrink) result(q)
      real(wp), intent(in) :: u(4), b(3), shrink
      real(wp) :: q(4)
      q(1) = u(1) - u(2)*b(1) - u(3)*b(2) - u(4)*b(3)
      q(2:4) = u(2:4) + u(1)*b + cross_of(u(2:4), b)
      q = sqrt(shrink)*q
   end function half_rotated

   !> Returns a×b, where a call of `cross` would cost more than the product.
   pure function cross_of(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross_of

end module nutate_discrete_forces
