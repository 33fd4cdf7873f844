!> The three equations of a step in reduced form, for states with q·p = 0 and |q| = 1.
!>
!> A step turns the body by the Cayley map c = (1+b)∘(1-b)⁻¹, b = ¼Δt Ω̄. With the mean momentum `L̄ = (4/Δt)Jb + h`,
!> β = |b|², and the torque τ̄ in the frame of mid step, the change of momentum `R(c½)L1 - R(c½)ᵀL0 = Δt τ̄` reads
!>
!>     G(b) = (1-β)(L̄ - L0) + 2b×L̄ - ½Δt((1+β)τ̄ - 2b(b·τ̄)) = 0,
!>
!> whose free part is the implicit midpoint rule of Euler's equations with the step Δt/(1-β). It is solved as
!> F(b) = ¼Δt J⁻¹G(b), so that ∂F/∂b tends to one for short steps whatever the body.
module nutate_reduced_equations
   use nutate_kinds, only: wp
   use nutate_mid_forces, only: mid_forces_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_product
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: reduced_equations_t

   !> One step's equations F(b) = 0.
   type :: reduced_equations_t
      !> s.
      real(wp) :: dt = 0.0_wp
      !> u = q0/|q0|, body→space at the start of the step; shape (4). The norm counts: q0 for u, wrong by the
      !> round-off that |q0| has gathered, would make the momentum drift in proportion to the number of steps.
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> ½u*∘p0 = [round-off of q·p, L0], kg m²/s; its vector part, body axes.
      real(wp) :: half_momentum(4) = 0.0_wp, momentum(3) = 0.0_wp
      !> (4/Δt)J and ¼Δt J⁻¹; shape (3,3).
      real(wp) :: to_momentum(3, 3) = 0.0_wp, to_turn(3, 3) = 0.0_wp
      !> h, body axes; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      type(mid_forces_t) :: forces
   contains
      !> Takes the step's length.
      procedure :: set_step
      !> Starts a step from a state.
      procedure :: start
      !> F(b)
      procedure :: residual
      !> ∂F/∂b
      procedure :: jacobian
      !> L1 - L0 of the root, and the work of the torques.
      procedure :: finish
   end type reduced_equations_t

contains

   !> Takes the step's length, s.
   pure subroutine set_step(self, system, dt)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      self%dt = dt
      self%to_momentum = (4/dt)*system%body%inertia
      self%to_turn = (0.25_wp*dt)*system%body%inverse_inertia
      self%rotor = system%effects%rotor_momentum
   end subroutine set_step

   !> Starts a step from a state.
   pure subroutine start(self, system, state, decisive)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Time that decides which torques act, s; default: the middle of the step.
      real(wp), intent(in), optional :: decisive
      self%frame = state%q/norm2(state%q)
      self%half_momentum = 0.5_wp*quat_product(quat_conjugate(self%frame), state%p)
      self%momentum = self%half_momentum(2:4)
      if (self%forces%active) &
         call self%forces%start(system%effects, state%t + 0.5_wp*self%dt, self%frame, 1.0_wp, decisive)
   end subroutine start

   !> F(b) = ¼Δt J⁻¹ G(b); shape (3).
   pure subroutine residual(self, system, b, f)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: f(3)
      real(wp) :: mean(3), g(3), beta, s(4)
      beta = b(1)*b(1) + b(2)*b(2) + b(3)*b(3)
      mean = apply(self%to_momentum, b) + self%rotor
      g = (1 - beta)*(mean - self%momentum) + 2*cross(b, mean)
      if (self%forces%active) then
         call self%forces%evaluate(system%effects, cayley(b, beta), halfway(b, beta), (4/self%dt)*b, s)
         g = g - (0.5_wp*self%dt)*((1 + beta)*s(2:4) - (2*dot_product(b, s(2:4)))*b)
      end if
      f = apply(self%to_turn, g)
   end subroutine residual

   !> ∂F/∂b; shape (3,3).
   pure subroutine jacobian(self, system, b, matrix)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: matrix(3, 3)
      real(wp) :: mean(3), change(3), by_b(3, 3), beta, unit(3)
      integer :: j
      beta = dot_product(b, b)
      mean = apply(self%to_momentum, b) + self%rotor
      change = mean - self%momentum
      do j = 1, 3
         unit = 0.0_wp
         unit(j) = 1.0_wp
         by_b(:, j) = (1 - beta)*self%to_momentum(:, j) - (2*b(j))*change &
                      + 2*(cross(b, self%to_momentum(:, j)) + cross(unit, mean))
      end do
      if (self%forces%active) call add_forces(self, system, b, beta, by_b)
      do j = 1, 3
         matrix(:, j) = apply(self%to_turn, by_b(:, j))
      end do
   end subroutine jacobian

   !> Adds the derivative of -½Δt((1+β)τ̄ - 2b(b·τ̄)).
   pure subroutine add_forces(self, system, b, beta, by_b)
      type(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3), beta
      real(wp), intent(inout) :: by_b(3, 3)
      real(wp) :: s(4), by_x(4, 4), by_rate(3, 3), slope(4), tau(3), column(3), square
      integer :: j
      call self%forces%linearize(system%effects, cayley(b, beta), halfway(b, beta), (4/self%dt)*b, s, by_x, by_rate)
      tau = s(2:4)
      square = (1 + beta)**2
      do j = 1, 3
         ! ∂c/∂bⱼ
         slope = (-4*b(j)/square)*[1.0_wp, b]
         slope(j + 1) = slope(j + 1) + 2/(1 + beta)
         column = matmul(by_x(2:4, :), slope) + (4/self%dt)*by_rate(:, j)
         column = (1 + beta)*column + (2*b(j))*tau - (2*(dot_product(b, column) + tau(j)))*b
         column(j) = column(j) - 2*dot_product(b, tau)
         by_b(:, j) = by_b(:, j) - (0.5_wp*self%dt)*column
      end do
   end subroutine add_forces

   !> The momentum's change in body axes, L1 - L0 = (R(c)ᵀ - 1)L0 + Δt R(c½)ᵀτ̄, a rotation to the last digit without
   !> torque; and the work of each torque.
   pure subroutine finish(self, system, b, change, work)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> Root.
      real(wp), intent(in) :: b(3)
      !> L1 - L0, body axes of the end and of the start of the step, kg m²/s; shape (3).
      real(wp), intent(out) :: change(3)
      !> J; shape (number of torques).
      real(wp), intent(inout) :: work(:)
      real(wp) :: turned(3), beta, s(4), tau(3)
      beta = dot_product(b, b)
      turned = cross(b, self%momentum)
      change = (4/(1 + beta)**2)*(2*cross(b, turned) - (1 - beta)*turned)
      if (.not. self%forces%active) return
      call self%forces%evaluate(system%effects, cayley(b, beta), halfway(b, beta), (4/self%dt)*b, s)
      tau = s(2:4)
      change = change + (self%dt/(1 + beta))*((1 - beta)*tau - 2*cross(b, tau) + (2*dot_product(b, tau))*b)
      if (system%effects%n_torques > 0) call self%forces%get_work(system%effects, self%dt, halfway(b, beta), &
                                                                  (4/self%dt)*b, work)
   end subroutine finish

   !> c = (1 - β + 2b)/(1 + β); shape (4).
   pure function cayley(b, beta) result(c)
      real(wp), intent(in) :: b(3), beta
      real(wp) :: c(4)
      c(1) = (1 - beta)/(1 + beta)
      c(2:4) = (2/(1 + beta))*b
   end function cayley

   !> ½(1 + c) = (1 + b)/(1 + β): the mean of the step's ends; shape (4).
   pure function halfway(b, beta) result(x)
      real(wp), intent(in) :: b(3), beta
      real(wp) :: x(4)
      x = [1.0_wp, b]/(1 + beta)
   end function halfway

   !> A v
   pure function apply(a, v) result(image)
      real(wp), intent(in) :: a(3, 3), v(3)
      real(wp) :: image(3)
      image = a(:, 1)*v(1) + a(:, 2)*v(2) + a(:, 3)*v(3)
   end function apply

end module nutate_reduced_equations
