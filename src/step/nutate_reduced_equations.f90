!> The three equations of a step in reduced form, for states with q·p = 0 and |q| = 1.
!>
!> A step turns the body by the Cayley map c = (1+b)∘(1-b)⁻¹, b = ¼Δt Ω̄. With the mean momentum `L̄ = (4/Δt)Jb + h`,
!> β = |b|², and the torque τ̄ in the frame of mid step, the change of momentum `R(c½)L1 - R(c½)ᵀL0 = Δt τ̄` reads
!>
!>     G(b) = (1-β)(L̄ - L0) + 2b×L̄ - ½Δt((1+β)τ̄ - 2b(b·τ̄)) = 0,
!>
!> whose free part is the implicit midpoint rule of Euler's equations with the step Δt/(1-β). It is solved in units of
!> 4s/Δt, s the largest diagonal entry of J, in which L̄ is (J/s)b + hΔt/4s: numbers of order 1 whatever the body.
!>
!> What a step always does is written component by component here: compilers keep components in registers, but arrays
!> of three, and the arguments of a quaternion product in another file, in memory. It halves the time of a step.
module nutate_reduced_equations
   use nutate_cayley, only: measure_turn
   use nutate_kinds, only: wp
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: reduced_equations_t

   !> Momenta and torques in the units of the step that are larger belong to no step that could be taken; their
   !> products would overflow.
   real(wp), parameter :: greatest = 1e40_wp

   !> One step's equations F(b) = 0, F = (Δt/4s) G.
   type :: reduced_equations_t
      !> s.
      real(wp) :: dt = 0.0_wp
      !> 4/Δt, 1/s.
      real(wp) :: rate = 0.0_wp
      !> u = q0/|q0|, body→space at the start of the step; shape (4). The norm counts: q0 for u, wrong by the
      !> round-off that |q0| has gathered, would make the momentum drift in proportion to the number of steps.
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> |q0|²
      real(wp) :: square = 1.0_wp
      !> ½u*∘p0 = [round-off of q·p, L0], kg m²/s.
      real(wp) :: half_momentum(4) = 0.0_wp
      !> Δt/4s, and L0 and h times it; shape (3).
      real(wp) :: scale = 0.0_wp, momentum(3) = 0.0_wp, rotor(3) = 0.0_wp
      !> J/s; shape (3,3), and its determinant, that of a very short step.
      real(wp) :: inertia(3, 3) = 0.0_wp, unloaded = 1.0_wp
      !> ½Δt²/4s, and the effects' part of the Jacobian; shape (3,3).
      real(wp) :: weight = 0.0_wp, by_forces(3, 3) = 0.0_wp
      !> τ̄ at the last b for which F was asked, N m; shape (3).
      real(wp) :: torque(3) = 0.0_wp
      !> Largest torque that is admissible, N m, and whether one was larger since the start of the step.
      real(wp) :: torque_limit = 0.0_wp
      logical :: too_strong = .false.
      type(discrete_forces_t) :: forces
   contains
      !> Takes the step's length.
      procedure :: set_step
      !> Starts a step from a state.
      procedure :: start
      !> The momenta are of a size that a step can follow.
      procedure :: is_in_scale
      !> The b of a step in which the momentum stays.
      procedure :: explicit_guess
      !> F(b)
      procedure :: residual
      !> ∂F/∂b
      procedure :: jacobian
      !> The effects' part of ∂F/∂b.
      procedure :: linearize_forces
      !> Inverse of ∂F/∂b with the effects' part as it is, and its determinant.
      procedure :: invert
      !> Work of the torques.
      procedure :: get_work
      !> Moves the state to the end of the step.
      procedure :: finish
   end type reduced_equations_t

contains

   !> Takes the step's length, s.
   pure subroutine set_step(self, system, dt)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      real(wp) :: largest
      associate (j => system%body%inertia)
         largest = max(j(1, 1), j(2, 2), j(3, 3))
         self%inertia = j/largest
      end associate
      associate (moments => system%body%moments)
         self%unloaded = (moments(1)/largest)*(moments(2)/largest)*(moments(3)/largest)
      end associate
      self%dt = dt
      self%rate = 4/dt
      self%scale = 0.25_wp*dt/largest
      self%weight = 0.5_wp*dt*self%scale
      ! Steps end on the times of torques, which can be as close to each other as numbers are.
      self%torque_limit = greatest/max(self%weight, 1e-250_wp)
      self%rotor = self%scale*system%effects%rotor_momentum
   end subroutine set_step

   !> Starts a step from a state.
   pure subroutine start(self, system, state, window_time)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Time that decides which torques act, s; default: the middle of the step.
      real(wp), intent(in), optional :: window_time
      real(wp) :: half, u0, u1, u2, u3
      associate (q => state%q, p => state%p)
         ! 1/|q| to the last digit where |q|² - 1 is below 1e-8.
         self%square = q(1)**2 + q(2)**2 + q(3)**2 + q(4)**2
         half = 0.5_wp*(3 - self%square)
         u0 = half*q(1)
         u1 = half*q(2)
         u2 = half*q(3)
         u3 = half*q(4)
         self%half_momentum(1) = 0.5_wp*(u0*p(1) + u1*p(2) + u2*p(3) + u3*p(4))
         self%half_momentum(2) = 0.5_wp*(u0*p(2) - u1*p(1) - u2*p(4) + u3*p(3))
         self%half_momentum(3) = 0.5_wp*(u0*p(3) + u1*p(4) - u2*p(1) - u3*p(2))
         self%half_momentum(4) = 0.5_wp*(u0*p(4) - u1*p(3) + u2*p(2) - u3*p(1))
      end associate
      self%frame(1) = u0
      self%frame(2) = u1
      self%frame(3) = u2
      self%frame(4) = u3
      self%momentum = self%scale*self%half_momentum(2:4)
      self%too_strong = .false.
      if (self%forces%active) &
         call self%forces%start(system%effects, state%t + 0.5_wp*self%dt, self%frame, 1.0_wp, window_time)
   end subroutine start

   !> True if the momenta are of a size that a step can follow.
   pure logical function is_in_scale(self)
      class(reduced_equations_t), intent(in) :: self
      is_in_scale = max(maxval(abs(self%momentum)), maxval(abs(self%rotor))) <= greatest
   end function is_in_scale

   !> b = ¼Δt J⁻¹(L0 - h): the momentum of the start all through the step; shape (3).
   pure function explicit_guess(self, system) result(b)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp) :: b(3)
      b = (0.25_wp*self%dt)*times_vector(system%body%inverse_inertia, &
                                         self%half_momentum(2:4) - system%effects%rotor_momentum)
   end function explicit_guess

   !> F(b); shape (3). Keeps the torque. Without that of the torque where it is too strong.
   pure subroutine residual(self, system, b, f)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: f(3)
      real(wp) :: m1, m2, m3, t1, t2, t3, beta, along
      m1 = self%inertia(1, 1)*b(1) + self%inertia(1, 2)*b(2) + self%inertia(1, 3)*b(3) + self%rotor(1)
      m2 = self%inertia(2, 1)*b(1) + self%inertia(2, 2)*b(2) + self%inertia(2, 3)*b(3) + self%rotor(2)
      m3 = self%inertia(3, 1)*b(1) + self%inertia(3, 2)*b(2) + self%inertia(3, 3)*b(3) + self%rotor(3)
      beta = b(1)*b(1) + b(2)*b(2) + b(3)*b(3)
      f(1) = (1 - beta)*(m1 - self%momentum(1)) + 2*(b(2)*m3 - b(3)*m2)
      f(2) = (1 - beta)*(m2 - self%momentum(2)) + 2*(b(3)*m1 - b(1)*m3)
      f(3) = (1 - beta)*(m3 - self%momentum(3)) + 2*(b(1)*m2 - b(2)*m1)
      if (.not. self%forces%active) return
      call self%forces%turn(system%effects, b, self%rate, self%torque)
      if (max(abs(self%torque(1)), abs(self%torque(2)), abs(self%torque(3))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      t1 = self%weight*self%torque(1)
      t2 = self%weight*self%torque(2)
      t3 = self%weight*self%torque(3)
      along = 2*(b(1)*t1 + b(2)*t2 + b(3)*t3)
      f(1) = f(1) - (1 + beta)*t1 + along*b(1)
      f(2) = f(2) - (1 + beta)*t2 + along*b(2)
      f(3) = f(3) - (1 + beta)*t3 + along*b(3)
   end subroutine residual

   !> ∂F/∂b; shape (3,3).
   pure subroutine jacobian(self, system, b, matrix)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: matrix(3, 3)
      if (self%forces%active) call self%linearize_forces(system, b)
      call add_free_part(self, b, matrix)
   end subroutine jacobian

   !> The derivative of -½Δt((1+β)τ̄ - 2b(b·τ̄)) at b, kept until asked for again.
   pure subroutine linearize_forces(self, system, b)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp) :: tau(3), by_b(3, 3), column(3), beta
      integer :: j
      call self%forces%linearize_turn(system%effects, b, self%rate, tau, by_b)
      if (max(maxval(abs(tau)), maxval(abs(by_b))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      beta = dot(b, b)
      do j = 1, 3
         column = (1 + beta)*by_b(:, j) + (2*b(j))*tau - (2*(dot(b, by_b(:, j)) + tau(j)))*b
         column(j) = column(j) - 2*dot(b, tau)
         self%by_forces(:, j) = -self%weight*column
      end do
   end subroutine linearize_forces

   !> ∂F/∂b: the derivative of (1-β)(L̄ - L0) + 2b×L̄ and the effects' part.
   pure subroutine add_free_part(self, b, matrix)
      type(reduced_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: matrix(3, 3)
      real(wp) :: m1, m2, m3, c1, c2, c3, rest
      associate (n => self%inertia, e => self%by_forces)
         m1 = n(1, 1)*b(1) + n(1, 2)*b(2) + n(1, 3)*b(3) + self%rotor(1)
         m2 = n(2, 1)*b(1) + n(2, 2)*b(2) + n(2, 3)*b(3) + self%rotor(2)
         m3 = n(3, 1)*b(1) + n(3, 2)*b(2) + n(3, 3)*b(3) + self%rotor(3)
         c1 = m1 - self%momentum(1)
         c2 = m2 - self%momentum(2)
         c3 = m3 - self%momentum(3)
         rest = 1 - (b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
         matrix(1, 1) = rest*n(1, 1) + 2*(b(2)*n(3, 1) - b(3)*n(2, 1) - b(1)*c1) + e(1, 1)
         matrix(2, 1) = rest*n(2, 1) + 2*(b(3)*n(1, 1) - b(1)*n(3, 1) - b(1)*c2 - m3) + e(2, 1)
         matrix(3, 1) = rest*n(3, 1) + 2*(b(1)*n(2, 1) - b(2)*n(1, 1) - b(1)*c3 + m2) + e(3, 1)
         matrix(1, 2) = rest*n(1, 2) + 2*(b(2)*n(3, 2) - b(3)*n(2, 2) - b(2)*c1 + m3) + e(1, 2)
         matrix(2, 2) = rest*n(2, 2) + 2*(b(3)*n(1, 2) - b(1)*n(3, 2) - b(2)*c2) + e(2, 2)
         matrix(3, 2) = rest*n(3, 2) + 2*(b(1)*n(2, 2) - b(2)*n(1, 2) - b(2)*c3 - m1) + e(3, 2)
         matrix(1, 3) = rest*n(1, 3) + 2*(b(2)*n(3, 3) - b(3)*n(2, 3) - b(3)*c1 - m2) + e(1, 3)
         matrix(2, 3) = rest*n(2, 3) + 2*(b(3)*n(1, 3) - b(1)*n(3, 3) - b(3)*c2 + m1) + e(2, 3)
         matrix(3, 3) = rest*n(3, 3) + 2*(b(1)*n(2, 3) - b(2)*n(1, 3) - b(3)*c3) + e(3, 3)
      end associate
   end subroutine add_free_part

   !> Inverse of ∂F/∂b from its adjugate, with the effects' part as `linearize_forces` left it; none where the
   !> determinant vanishes.
   pure subroutine invert(self, b, rows, determinant)
      class(reduced_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      !> Rows of the inverse; shape (3, row).
      real(wp), intent(out) :: rows(3, 3)
      real(wp), intent(out) :: determinant
      real(wp) :: m(3, 3), factor
      integer :: i
      call add_free_part(self, b, m)
      rows(1, 1) = m(2, 2)*m(3, 3) - m(3, 2)*m(2, 3)
      rows(2, 1) = m(3, 2)*m(1, 3) - m(1, 2)*m(3, 3)
      rows(3, 1) = m(1, 2)*m(2, 3) - m(2, 2)*m(1, 3)
      rows(1, 2) = m(2, 3)*m(3, 1) - m(3, 3)*m(2, 1)
      rows(2, 2) = m(3, 3)*m(1, 1) - m(1, 3)*m(3, 1)
      rows(3, 2) = m(1, 3)*m(2, 1) - m(2, 3)*m(1, 1)
      rows(1, 3) = m(2, 1)*m(3, 2) - m(3, 1)*m(2, 2)
      rows(2, 3) = m(3, 1)*m(1, 2) - m(1, 1)*m(3, 2)
      rows(3, 3) = m(1, 1)*m(2, 2) - m(2, 1)*m(1, 2)
      determinant = rows(1, 1)*m(1, 1) + rows(2, 1)*m(2, 1) + rows(3, 1)*m(3, 1)
      if (.not. abs(determinant) > tiny(1.0_wp)) return
      factor = 1/determinant
      do i = 1, 3
         rows(1, i) = factor*rows(1, i)
         rows(2, i) = factor*rows(2, i)
         rows(3, i) = factor*rows(3, i)
      end do
   end subroutine invert

   !> Work of each torque in the step whose root is b.
   pure subroutine get_work(self, system, b, work)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      !> J; shape (number of torques).
      real(wp), intent(inout) :: work(:)
      call self%forces%get_work(system%effects, self%dt, [1.0_wp, b]/(1 + dot(b, b)), self%rate*b, work)
   end subroutine get_work

   !> Moves the state to the end of the step whose root is b: q1 = q0∘c, p1 = p0∘c + Δt f, the impulse of the effects.
   pure subroutine finish(self, b, attitude, state)
      class(reduced_equations_t), intent(in) :: self
      !> Root, for which F has been asked last if there are effects.
      real(wp), intent(in) :: b(3)
      !> Move the attitude too.
      logical, intent(in) :: attitude
      type(state_t), intent(inout) :: state
      real(wp) :: beta, factor, excess, e0, e1, e2, e3
      call measure_turn(b, beta, factor, excess)
      if (attitude) then
         call turn(b, beta, factor, state%q, e0, e1, e2, e3)
         call move(excess, e0, e1, e2, e3, state%q, state%q_compensation)
         call turn(b, beta, factor, state%p, e0, e1, e2, e3)
         if (self%forces%active) call add_impulse(self, b, factor, e0, e1, e2, e3)
         call move(excess, e0, e1, e2, e3, state%p, state%p_compensation)
      else
         call change_momentum(self, b, beta, factor, state)
      end if
      state%t = state%t + self%dt
   end subroutine finish

   !> e = x∘(c - 1): what a turn by c adds to a quaternion. Taken from q and p themselves, not from the momentum in body
   !> axes, whose rounding would count whole: so only the rounding of e does.
   pure subroutine turn(b, beta, factor, x, e0, e1, e2, e3)
      !> b, β and 2/(1+β).
      real(wp), intent(in) :: b(3), beta, factor, x(4)
      real(wp), intent(out) :: e0, e1, e2, e3
      e0 = -factor*(beta*x(1) + b(1)*x(2) + b(2)*x(3) + b(3)*x(4))
      e1 = factor*(b(1)*x(1) - beta*x(2) + b(3)*x(3) - b(2)*x(4))
      e2 = factor*(b(2)*x(1) - beta*x(3) + b(1)*x(4) - b(3)*x(2))
      e3 = factor*(b(3)*x(1) - beta*x(4) + b(2)*x(2) - b(1)*x(3))
   end subroutine turn

   !> Adds Δt f = 2Δt u∘c½∘τ̄∘c½, c½∘τ̄∘c½ = [-2b·τ̄, (1+β)τ̄ - 2b(b·τ̄)]/(1+β).
   pure subroutine add_impulse(self, b, factor, e0, e1, e2, e3)
      type(reduced_equations_t), intent(in) :: self
      !> b and 2/(1+β).
      real(wp), intent(in) :: b(3), factor
      real(wp), intent(inout) :: e0, e1, e2, e3
      real(wp) :: double, s0, s1, s2, s3
      double = 2*self%dt
      s1 = double*self%torque(1)
      s2 = double*self%torque(2)
      s3 = double*self%torque(3)
      s0 = -factor*(b(1)*s1 + b(2)*s2 + b(3)*s3)
      s1 = s1 + s0*b(1)
      s2 = s2 + s0*b(2)
      s3 = s3 + s0*b(3)
      associate (u => self%frame)
         e0 = e0 + (u(1)*s0 - u(2)*s1 - u(3)*s2 - u(4)*s3)
         e1 = e1 + (u(1)*s1 + u(2)*s0 + u(3)*s3 - u(4)*s2)
         e2 = e2 + (u(1)*s2 - u(2)*s3 + u(3)*s0 + u(4)*s1)
         e3 = e3 + (u(1)*s3 + u(2)*s2 - u(3)*s1 + u(4)*s0)
      end associate
   end subroutine add_impulse

   !> Adds e to a quaternion that c has turned, and takes away by how much c is too long: before the sum, whose rounding
   !> leaves a carry that is zero on the average, since the next step does not see the carry.
   pure subroutine move(excess, e0, e1, e2, e3, x, carry)
      real(wp), intent(in) :: excess, e0, e1, e2, e3
      real(wp), intent(inout) :: x(4), carry(4)
      carry(1) = carry(1) - excess*(x(1) + e0)
      carry(2) = carry(2) - excess*(x(2) + e1)
      carry(3) = carry(3) - excess*(x(3) + e2)
      carry(4) = carry(4) - excess*(x(4) + e3)
      call accumulate(x(1), carry(1), e0)
      call accumulate(x(2), carry(2), e1)
      call accumulate(x(3), carry(3), e2)
      call accumulate(x(4), carry(4), e3)
   end subroutine move

   !> p1 - p0 = 2u∘(L1 - L0), L1 - L0 = (R(c)ᵀ - 1)L0 + Δt R(c½)ᵀτ̄ in body axes, of the end and of the start: what is
   !> left where the attitude is left out.
   pure subroutine change_momentum(self, b, beta, factor, state)
      type(reduced_equations_t), intent(in) :: self
      !> b, β and 2/(1+β).
      real(wp), intent(in) :: b(3), beta, factor
      type(state_t), intent(inout) :: state
      real(wp) :: t1, t2, t3, d1, d2, d3, along
      associate (h => self%half_momentum)
         ! b×L0
         t1 = b(2)*h(4) - b(3)*h(3)
         t2 = b(3)*h(2) - b(1)*h(4)
         t3 = b(1)*h(3) - b(2)*h(2)
      end associate
      d1 = (factor*factor)*(2*(b(2)*t3 - b(3)*t2) - (1 - beta)*t1)
      d2 = (factor*factor)*(2*(b(3)*t1 - b(1)*t3) - (1 - beta)*t2)
      d3 = (factor*factor)*(2*(b(1)*t2 - b(2)*t1) - (1 - beta)*t3)
      if (self%forces%active) then
         t1 = (0.5_wp*self%dt*factor)*self%torque(1)
         t2 = (0.5_wp*self%dt*factor)*self%torque(2)
         t3 = (0.5_wp*self%dt*factor)*self%torque(3)
         along = 2*(b(1)*t1 + b(2)*t2 + b(3)*t3)
         d1 = d1 + (1 - beta)*t1 - 2*(b(2)*t3 - b(3)*t2) + along*b(1)
         d2 = d2 + (1 - beta)*t2 - 2*(b(3)*t1 - b(1)*t3) + along*b(2)
         d3 = d3 + (1 - beta)*t3 - 2*(b(1)*t2 - b(2)*t1) + along*b(3)
      end if
      associate (u => self%frame)
         call accumulate(state%p(1), state%p_compensation(1), -2*(u(2)*d1 + u(3)*d2 + u(4)*d3))
         call accumulate(state%p(2), state%p_compensation(2), 2*(u(1)*d1 + u(3)*d3 - u(4)*d2))
         call accumulate(state%p(3), state%p_compensation(3), 2*(u(1)*d2 - u(2)*d3 + u(4)*d1))
         call accumulate(state%p(4), state%p_compensation(4), 2*(u(1)*d3 + u(2)*d2 - u(3)*d1))
      end associate
   end subroutine change_momentum

   !> `add_increment` of `nutate_state`: compilers do not take it in from another file.
   pure subroutine accumulate(total, carry, increment)
      real(wp), intent(inout) :: total, carry
      real(wp), intent(in) :: increment
      real(wp) :: addend, rounded, part, lost
      addend = increment + carry
      lost = carry - (addend - increment)
      rounded = total + addend
      part = rounded - total
      carry = ((total - (rounded - part)) + (addend - part)) + lost
      total = rounded
   end subroutine accumulate

   !> a·b
   pure real(wp) function dot(a, b)
      real(wp), intent(in) :: a(3), b(3)
      dot = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
   end function dot

end module nutate_reduced_equations
