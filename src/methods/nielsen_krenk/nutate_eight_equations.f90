!> The eight equations of one step and their analytic Jacobian.
!>
!> They are the finite increments of the Hamiltonian (8) of Nielsen & Krenk (2012), the discrete form of (9a) and (11),
!> which has no number there: the increment of a symmetric quadratic form is twice the increment of one factor times the
!> mean of the other. With w̄ = ½(w0 + w1), the mean of the two values of w(q,p) = Q(q)ᵀp, and a = J⁻¹w̄:
!>
!>     q1 - q0 =  ¼Δt Q(q̄) a                                             (9a)
!>     p1 - p0 = -¼Δt Q(p̄) C a - Δt (I - q̄q̄ᵀ/q̄ᵀq̄) ∂V*/∂q + Δt f          (11)
!>
!> The projection (11) is in `nutate_discrete_forces`: its forces 2q̄∘[0, τ]/|q̄|² have no scalar part.
!>
!> With q = u∘x, p = μ u∘y the equations for x and y are the same for any unit quaternion u: the scheme is symmetric
!> under rotations of space. u is the attitude at the start of the step and μ the power of two nearest |p|, so that
!>
!> * all eight unknowns are of order one, for a molecule as for a planet, and no digit depends on the units;
!> * increments, Jacobian and its LU factors vary only as fast as the body-frame motion, and serve for later steps.
!>
!> Space axes that rotate add -½Δt ω∘q̄ and -½Δt ω∘p̄ to the two (`nutate_frame_turn`).
module nutate_eight_equations
   use nutate_archive, only: archive_t
   use nutate_cayley, only: measure_turn
   use nutate_kinds, only: wp, eps
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_frame_turn, only: frame_turn_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_left_matrix, quat_product, quat_right_matrix, &
      quat_vector_product, rotate_to_body, vector_quat_product
   use nutate_small_products, only: times_vector
   use nutate_sphere_steps, only: sphere_steps_t
   use nutate_state, only: state_t
   use nutate_system, only: inertia_at, inverse_inertia_at, system_t
   use nutate_wheel_steps, only: wheel_steps_t
   implicit none
   private

   public :: eight_equations_t

   !> Largest q·p over |q||p| that is treated as rounding of zero: steps leave up to 4ε, a state that is given may have
   !> some more.
   real(wp), parameter :: product_noise = 64*eps

   !> C = diag(1, -1, -1, -1), the conjugation.
   real(wp), parameter :: conjugation(4) = [1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp]

   !> One step's equations R(z) = 0 in z = (Δx, Δy).
   type :: eight_equations_t
      !> Length of the step, s.
      real(wp) :: dt = 0.0_wp
      !> u = q0/|q0|, body→space; shape (4).
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> μ, the unit of momentum, kg m²/s; inertia and rotor are those of the system, in this unit.
      real(wp) :: momentum_unit = 1.0_wp
      logical :: scaled = .false.
      !> x0 = (|q0|, 0, 0, 0), y0 = u*∘p0/μ and w0 = x0*∘y0; shape (4).
      real(wp) :: x0(4) = 0.0_wp, y0(4) = 0.0_wp, w0(4) = 0.0_wp
      !> True if p is tangent to the unit sphere at q but for rounding, and the forces are projected: then (5), q·p = 0,
      !> continues to hold.
      logical :: is_tangent = .false.
      !> μ J⁻¹, 1/s; shape (3,3), and μ/J0, 1/s.
      real(wp) :: inverse_inertia(3, 3) = 0.0_wp, inverse_j0 = 0.0_wp
      !> Middle of the step, s, for an inertia that varies.
      real(wp) :: middle = 0.0_wp
      !> 2h/μ, h that of rotors and, with friction, a share of that of wheels; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      type(discrete_forces_t) :: forces
      !> Rotation of the space axes during the step.
      type(frame_turn_t) :: turn
      !> Wheels, and inner spheres, in the step; not allocated if there are none.
      type(wheel_steps_t), allocatable :: wheels
      type(sphere_steps_t), allocatable :: spheres
   contains
      !> Chooses the unit of momentum.
      procedure :: set_momentum_unit
      !> Starts a step from a state.
      procedure :: start
      !> Computes R(z).
      procedure :: residual
      !> Computes ∂R/∂z.
      procedure :: jacobian
      !> Returns the factor from w̄ to the rotation.
      procedure :: gain
      !> Returns a = J⁻¹w̄ at the end of the step that z gives.
      procedure :: mean_rate
      !> Returns the z of a step with constant rates, those at its start.
      procedure :: explicit_increments
      !> Returns the z of a step that rotates the body by a Cayley map.
      procedure :: increments_of
      !> Returns the rate relative to rotating space axes.
      procedure :: relative_rate
      !> Returns the r by which a step rotates the body.
      procedure :: turn_of
      !> Computes the increments of q and p at the root.
      procedure :: increments
      !> Returns true if the step is short enough for the friction of the wheels.
      procedure :: is_short
      !> Subtracts the rounding error of q·p.
      procedure :: make_tangent
      !> Writes or reads the data kept between steps.
      procedure :: transfer
   end type eight_equations_t

contains

   !> Sets the unit of momentum, a power of two, and the inertia in it; for the step's length if wheels have friction.
   pure subroutine set_momentum_unit(self, system, inverse_j0, momentum_unit)
      class(eight_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      !> μ, kg m²/s; a power of two.
      real(wp), intent(in) :: momentum_unit
      self%momentum_unit = momentum_unit
      self%scaled = .true.
      self%inverse_inertia = system%body%inverse_inertia
      if (system%effects%varies) self%inverse_inertia = inverse_inertia_at(system, self%middle)
      if (allocated(self%wheels)) then
         call self%wheels%set_step(system%effects, self%dt)
         call self%wheels%add_to_inverse(system%effects, self%inverse_inertia)
      end if
      if (allocated(self%spheres)) call self%spheres%set_step(system%effects, self%dt)
      self%inverse_inertia = momentum_unit*self%inverse_inertia
      self%inverse_j0 = momentum_unit*inverse_j0
      self%rotor = 2*system%effects%rotor_momentum/momentum_unit
      call self%turn%prepare(system%effects)
   end subroutine set_momentum_unit

   !> Starts a step of `dt` seconds from a state.
   pure subroutine start(self, system, state, dt, window_time)
      class(eight_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      !> Time that decides which torques act, s; default: the middle of the step.
      real(wp), intent(in), optional :: window_time
      real(wp) :: norm, inner
      norm = norm2(state%q)
      inner = 0.0_wp
      self%dt = dt
      self%frame = state%q/norm
      self%x0 = [norm, 0.0_wp, 0.0_wp, 0.0_wp]
      self%y0 = quat_product(quat_conjugate(self%frame), state%p)/self%momentum_unit
      if (allocated(self%spheres)) then
         call self%spheres%start(system%effects, state, self%frame, self%forces%pull, self%forces%drag)
         self%y0(2:4) = self%y0(2:4) - (2*norm/self%momentum_unit)*self%spheres%inner
         inner = (2/self%momentum_unit)*maxval(abs(self%spheres%inner))
      end if
      self%w0 = norm*self%y0
      self%is_tangent = self%forces%projection .and. abs(self%w0(1)) <= product_noise* &
                        (max(abs(self%w0(2)), abs(self%w0(3)), abs(self%w0(4))) + inner)
      if (allocated(self%wheels)) then
         call self%wheels%start(system%effects, state, window_time)
         self%rotor = 2*(system%effects%rotor_momentum + self%wheels%rotor)/self%momentum_unit
      end if
      if (self%forces%active) call self%forces%start(system%effects, state%t + 0.5_wp*dt, self%frame, norm, window_time)
      if (.not. self%turn%there) return
      if (system%effects%n_potentials > 0) then
         call self%turn%begin(dt, self%frame, self%forces%columns)
      else
         call self%turn%begin(dt, self%frame)
      end if
   end subroutine start

   !> Returns ⅛Δt times the largest entry of J⁻¹, in units of momentum.
   pure real(wp) function gain(self)
      class(eight_equations_t), intent(in) :: self
      gain = 0.125_wp*abs(self%dt)*max(self%inverse_inertia(1, 1), self%inverse_inertia(2, 2), &
                                       self%inverse_inertia(3, 3))
   end function gain

   !> Returns a = J⁻¹(w̄ - 2h) = [w̄₀/J0, 2Ω̄], rad/s, w̄ = ½(w0 + w1) the mean of w at the two ends (not w of the
   !> means); shape (4).
   pure function mean_rate(self, z) result(a)
      class(eight_equations_t), intent(in) :: self
      !> (Δx, Δy); shape (8).
      real(wp), intent(in) :: z(8)
      real(wp) :: a(4), w(4)
      w = 0.5_wp*(self%w0 + quat_product(quat_conjugate(self%x0 + z(1:4)), self%y0 + z(5:8)))
      w(2:4) = w(2:4) - self%rotor
      a(1) = self%inverse_j0*w(1)
      a(2:4) = self%inverse_inertia(:, 1)*w(2) + self%inverse_inertia(:, 2)*w(3) + self%inverse_inertia(:, 3)*w(4)
   end function mean_rate

   !> Returns the z of a step with constant rates, those at its start: Δx = ¼Δt x0∘a0, Δy = -¼Δt y0∘Ca0; shape (8).
   pure function explicit_increments(self) result(z)
      class(eight_equations_t), intent(in) :: self
      real(wp) :: z(8), a(4)
      z = 0.0_wp
      a = (0.25_wp*self%dt)*self%mean_rate(z)
      z(1:4) = quat_product(self%x0, a)
      z(5:8) = -quat_product(self%y0, conjugation*a)
      if (.not. self%turn%there) return
      z = -z
      call add_frame(self%turn, self%x0, self%y0, z)
      z = -z
   end function explicit_increments

   !> Returns the z of a step that rotates the body by the Cayley map of b, on the constraint manifold: x1 = x0∘c, and w
   !> at the end from the mean w̄ = 2(4/Δt Jb + h); shape (8).
   pure function increments_of(self, system, b) result(z)
      class(eight_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> b = ¼Δt Ω̄, body axes; shape (3).
      real(wp), intent(in) :: b(3)
      real(wp) :: z(8), c(4), w(4), coupling(3, 3)
      coupling = 0.0_wp
      if (allocated(self%wheels)) coupling = self%wheels%coupling
      c(2:4) = b
      if (self%turn%there) c(2:4) = self%turn%to_relative(b)
      c(1) = -dot_product(c(2:4), c(2:4))
      z(1:4) = (2*self%x0(1)/(1 - c(1)))*c
      w(1) = self%w0(1)
      w(2:4) = (16/(self%dt*self%momentum_unit))*times_vector(inertia_at(system, self%middle) + coupling, b) &
               + 2*self%rotor - self%w0(2:4)
      c = self%x0 + z(1:4)
      z(5:8) = quat_product(c, w)/dot_product(c, c) - self%y0
   end function increments_of

   !> Computes R(z) = (Δx - ¼Δt x̄∘a, Δy + ¼Δt ȳ∘Ca - Δt f/μ), f = 2x̄∘s/|x̄|²: the discrete (9a) and (11). s = [0, τ]
   !> without scalar part is the projection of (11).
   pure subroutine residual(self, system, z, r)
      class(eight_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> (Δx, Δy); shape (8).
      real(wp), intent(in) :: z(8)
      real(wp), intent(out) :: r(8)
      real(wp) :: a(4), xm(4), s(4), omega(3)
      a = self%mean_rate(z)
      xm = self%x0 + 0.5_wp*z(1:4)
      if (self%turn%there) then
         call self%turn%add_turns((0.25_wp*self%dt)*a, xm, self%y0 + 0.5_wp*z(5:8), z, r)
      else
         r(1:4) = z(1:4) - (0.25_wp*self%dt)*quat_product(xm, a)
         r(5:8) = z(5:8) + (0.25_wp*self%dt)*quat_product(self%y0 + 0.5_wp*z(5:8), conjugation*a)
      end if
      if (.not. self%forces%active) return
      omega = 0.0_wp
      if (self%forces%follows_rate) omega = 0.5_wp*a(2:4)
      if (self%forces%follows_rate .and. self%turn%there) omega = omega - frame_rate(self, xm)
      call self%forces%evaluate(system%effects, self%x0 + z(1:4), xm, omega, s)
      r(5:8) = r(5:8) - (2*self%dt/(self%momentum_unit*dot_product(xm, xm)))*quat_product(xm, s)
   end subroutine residual

   !> Adds ½Δt R(u)ᵀω∘x̄ and ½Δt R(u)ᵀω∘ȳ: the part of the rotating space axes in the residual.
   pure subroutine add_frame(turn, xm, ym, r)
      type(frame_turn_t), intent(in) :: turn
      !> x̄ and ȳ; shape (4).
      real(wp), intent(in) :: xm(4), ym(4)
      !> Residual; shape (8).
      real(wp), intent(inout) :: r(8)
      real(wp) :: a, b, c
      a = 2*turn%start(1)
      b = 2*turn%start(2)
      c = 2*turn%start(3)
      r(1) = r(1) - (a*xm(2) + b*xm(3) + c*xm(4))
      r(2) = r(2) + (a*xm(1) + b*xm(4) - c*xm(3))
      r(3) = r(3) + (b*xm(1) + c*xm(2) - a*xm(4))
      r(4) = r(4) + (c*xm(1) + a*xm(3) - b*xm(2))
      r(5) = r(5) - (a*ym(2) + b*ym(3) + c*ym(4))
      r(6) = r(6) + (a*ym(1) + b*ym(4) - c*ym(3))
      r(7) = r(7) + (b*ym(1) + c*ym(2) - a*ym(4))
      r(8) = r(8) + (c*ym(1) + a*ym(3) - b*ym(2))
   end subroutine add_frame

   !> Returns R(x̄)ᵀω/|x̄|²: the rate of the space axes in the step, body axes, rad/s; shape (3).
   pure function frame_rate(self, xm) result(rate)
      type(eight_equations_t), intent(in) :: self
      !> x̄; shape (4).
      real(wp), intent(in) :: xm(4)
      real(wp) :: rate(3)
      rate = (4/(self%dt*dot_product(xm, xm)))*rotate_to_body(xm, self%turn%start)
   end function frame_rate

   !> Returns Ω̄ relative to the space axes at a root, body axes, rad/s, which torques depend on; shape (3).
   pure function relative_rate(self, z, a) result(omega)
      class(eight_equations_t), intent(in) :: self
      !> Root, shape (8), and the a that belongs to it, shape (4).
      real(wp), intent(in) :: z(8), a(4)
      real(wp) :: omega(3)
      omega = 0.5_wp*a(2:4)
      if (self%turn%there) omega = omega - frame_rate(self, self%x0 + 0.5_wp*z(1:4))
   end function relative_rate

   !> Returns the r that belongs to the b of a step; shape (3).
   pure function turn_of(self, b) result(r)
      class(eight_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      real(wp) :: r(3)
      r = b
      if (self%turn%there) r = self%turn%to_relative(b)
   end function turn_of

   !> Computes the increments q1 - q0 and p1 - p0 at the root. The free motion follows from its a alone: with α = ⅛Δt a
   !> and κ = Cα the equations of the step are q1∘(1-α) = q0∘(1+α) and p1∘(1+κ) = p0∘(1-κ) + Δt f. If it followed from
   !> z, seen from u, it would include the rounding of |u|, and |p| would drift in proportion to the number of steps.
   !> The impulse Δt f is the part of z beyond the free motion: if it were evaluated from a, a damping much stronger
   !> than the inertia would amplify the rounding of a. Projected forces have no part along x̄ and leave w₀ = q·p as it
   !> is: with a finite J0, the rounding of z in both would make the norm drift.
   pure subroutine increments(self, state, z, a, dq, dp, excess)
      class(eight_equations_t), intent(in) :: self
      !> State at the start of the step.
      type(state_t), intent(in) :: state
      !> Root, shape (8), and the a that belongs to it, shape (4).
      real(wp), intent(in) :: z(8), a(4)
      !> q1 - q0 and p1 - p0, the latter in kg m²/s; shape (4).
      real(wp), intent(out) :: dq(4), dp(4)
      !> Relative excess of the lengths of q1 and p1 that these increments cause.
      real(wp), intent(out) :: excess
      real(wp) :: alpha(4), cayley(4), beta, q_factor, p_factor, impulse(4), xm(4)
      alpha = (0.125_wp*self%dt)*a
      if (self%forces%projection) alpha(1) = (0.125_wp*self%dt*self%inverse_j0)*self%w0(1)
      if (self%turn%there) then
         call get_increments_in_frame(self, state, z, alpha, dq, dp)
         excess = 0.0_wp
         return
      end if
      if (self%is_tangent) then
         alpha(1) = 0.0_wp
         call measure_turn(alpha(2:4), beta, q_factor, excess)
         p_factor = q_factor
      else
         beta = alpha(2)**2 + alpha(3)**2 + alpha(4)**2
         q_factor = 2/((1 - alpha(1))**2 + beta)
         p_factor = 2/((1 + alpha(1))**2 + beta)
         excess = 0.0_wp
      end if
      cayley = [alpha(1)*(1 - alpha(1)) - beta, alpha(2:4)]
      dq = q_factor*quat_product(state%q, cayley)
      cayley(1) = -alpha(1)*(1 + alpha(1)) - beta
      dp = quat_product(state%p, cayley)
      if (self%forces%active) then
         impulse = z(5:8) + 2*quat_product(self%y0 + 0.5_wp*z(5:8), conjugation*alpha)
         if (self%forces%projection) then
            xm = self%x0 + 0.5_wp*z(1:4)
            impulse = impulse - (dot_product(xm, impulse)/dot_product(xm, xm))*xm
            ! The spheres keep the total momentum.
            if (allocated(self%spheres)) impulse = impulse - &
               (2*self%dt/(self%momentum_unit*dot_product(xm, xm)))*quat_vector_product(xm, self%spheres%torque)
         end if
         impulse = quat_product(impulse, [1 + alpha(1), alpha(2:4)])
         dp = dp + (0.5_wp*self%momentum_unit)*quat_product(self%frame, impulse)
      end if
      dp = p_factor*dp
   end subroutine increments

   !> Computes the increments q1 - q0 and p1 - p0 if the space axes rotate. On the constraint manifold this is a
   !> rotation by r, with the impulse Δtτ̄ = ½vec(x̄*∘Δtf).
   pure subroutine get_increments_in_frame(self, state, z, alpha, dq, dp)
      type(eight_equations_t), intent(in) :: self
      type(state_t), intent(in) :: state
      !> Root, shape (8), and ⅛Δt a, shape (4).
      real(wp), intent(in) :: z(8), alpha(4)
      real(wp), intent(out) :: dq(4), dp(4)
      real(wp) :: impulse(4), xm(4), ym(4), r(3), square, factor, excess
      impulse = 0.0_wp
      if (self%forces%active) then
         xm = self%x0 + 0.5_wp*z(1:4)
         ym = self%y0 + 0.5_wp*z(5:8)
         ! The impulse includes the rounding of the residual, so that it has no part of the free motion.
         call self%turn%add_momentum_turns(2*alpha, ym, z(5:8), impulse)
         if (self%forces%projection) impulse = impulse - (dot_product(xm, impulse)/dot_product(xm, xm))*xm
      end if
      if (.not. self%is_tangent) then
         call solve_in_frame(self, state, alpha, impulse, dq, dp)
         return
      end if
      r = self%turn%to_relative(alpha(2:4))
      call measure_turn(r, square, factor, excess)
      dq = factor*quat_product(state%q, [-square, r])
      dq = dq - excess*(state%q + dq)
      ! On the manifold y is 2L over |q0|μ.
      if (self%forces%active) impulse = (1/self%x0(1))*quat_product(quat_conjugate(xm), impulse)
      ym = self%turn%momentum_increment(alpha(2:4), r, square, factor, self%y0, impulse(2:4))
      dp = self%momentum_unit*quat_product(self%frame, ym)
      if (allocated(self%spheres)) dp = dp + 2*quat_product(self%frame, self%spheres%spin)
   end subroutine get_increments_in_frame

   !> Computes the increments off the manifold: with K x = x∘b - δ∘x and α = [α₀, b] they are q1 - q0 = (1 - α₀ - K)⁻¹
   !> 2(α₀ + K)q0 and p1 - p0 = (1 + α₀ - K)⁻¹(2(K - α₀)p0 + Δt f).
   pure subroutine solve_in_frame(self, state, alpha, impulse, dq, dp)
      type(eight_equations_t), intent(in) :: self
      type(state_t), intent(in) :: state
      !> ⅛Δt a, and Δt f, seen from u, in units of momentum; shape (4).
      real(wp), intent(in) :: alpha(4), impulse(4)
      real(wp), intent(out) :: dq(4), dp(4)
      real(wp) :: delta(3)
      delta = (0.25_wp*self%dt)*self%turn%rate
      dq = solved(1 - alpha(1), 2*(alpha(1)*state%q + rotated(state%q)))
      dp = solved(1 + alpha(1), 2*(rotated(state%p) - alpha(1)*state%p) + &
                  self%momentum_unit*quat_product(self%frame, impulse))

   contains

      !> Returns K x; shape (4).
      pure function rotated(x) result(k)
         real(wp), intent(in) :: x(4)
         real(wp) :: k(4)
         k = quat_vector_product(x, alpha(2:4)) - vector_quat_product(delta, x)
      end function rotated

      !> Returns (m - K)⁻¹x = (m + K)((m² + β + d)x - 2δ∘x∘b)/((m² + β + d)² - 4βd); shape (4).
      pure function solved(m, x) result(y)
         real(wp), intent(in) :: m, x(4)
         real(wp) :: y(4), size, beta
         beta = dot_product(alpha(2:4), alpha(2:4))
         size = m*m + beta + self%turn%square
         y = size*x - 2*quat_vector_product(vector_quat_product(delta, x), alpha(2:4))
         y = (m*y + rotated(y))/(size*size - 4*beta*self%turn%square)
      end function solved

   end subroutine solve_in_frame

   !> Returns true if the step is short enough for the friction of wheels and inner spheres.
   pure logical function is_short(self)
      class(eight_equations_t), intent(in) :: self
      is_short = .true.
      if (allocated(self%wheels)) is_short = self%wheels%is_short
      if (allocated(self%spheres)) is_short = is_short .and. self%spheres%is_short
   end function is_short

   !> Subtracts the rounding of the last steps in q·p from the increment of p: 1e-16 of |p|, which changes neither the
   !> angular momentum nor the energy, but accumulates from step to step, and with a finite J0 changes |q|. A rotation
   !> keeps q·p, so that at the end of the step this part lies along q1. In rotating axes, `momentum_increment` has
   !> already subtracted it.
   pure subroutine make_tangent(self, q1, dp)
      class(eight_equations_t), intent(in) :: self
      !> q at the end of the step; shape (4).
      real(wp), intent(in) :: q1(4)
      !> p1 - p0, kg m²/s; shape (4).
      real(wp), intent(inout) :: dp(4)
      if (self%turn%there .or. .not. self%is_tangent) return
      dp = dp - (self%w0(1)*self%momentum_unit/dot_product(q1, q1))*q1
   end subroutine make_tangent

   !> Computes ∂R/∂z, the Jacobian of the discrete (9a) and (11); shape (8,8).
   pure subroutine jacobian(self, system, z, matrix)
      class(eight_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> (Δx, Δy); shape (8).
      real(wp), intent(in) :: z(8)
      real(wp), intent(out) :: matrix(8, 8)
      real(wp) :: a(4), by_z(4, 8), xm(4), ym(4)
      integer :: i
      a = self%mean_rate(z)
      xm = self%x0 + 0.5_wp*z(1:4)
      ym = self%y0 + 0.5_wp*z(5:8)
      by_z = rate_derivative(self, z)
      do i = 1, 8
         matrix(1:4, i) = -(0.25_wp*self%dt)*quat_product(xm, by_z(:, i))
      end do
      matrix(1:4, 1:4) = matrix(1:4, 1:4) - (0.125_wp*self%dt)*quat_right_matrix(a)
      do i = 1, 8
         matrix(5:8, i) = (0.25_wp*self%dt)*quat_product(ym, conjugation*by_z(:, i))
      end do
      matrix(5:8, 5:8) = matrix(5:8, 5:8) + (0.125_wp*self%dt)*quat_right_matrix(conjugation*a)
      do i = 1, 8
         matrix(i, i) = matrix(i, i) + 1
      end do
      if (self%turn%there) then
         matrix(1:4, 1:4) = matrix(1:4, 1:4) + quat_left_matrix([0.0_wp, self%turn%start])
         matrix(5:8, 5:8) = matrix(5:8, 5:8) + quat_left_matrix([0.0_wp, self%turn%start])
      end if
      if (self%forces%active) call add_forces(self, system, z, xm, a, by_z, matrix)
   end subroutine jacobian

   !> Returns ∂a/∂z = ½ J⁻¹ [R(y1)C, Q(x1)ᵀ], from w1 = x1*∘y1; shape (4,8).
   pure function rate_derivative(self, z) result(by_z)
      class(eight_equations_t), intent(in) :: self
      real(wp), intent(in) :: z(8)
      real(wp) :: by_z(4, 8), by_w(4, 8)
      integer :: i
      by_w(:, 1:4) = quat_right_matrix(self%y0 + z(5:8))
      by_w(:, 2:4) = -by_w(:, 2:4)
      by_w(:, 5:8) = quat_left_matrix(quat_conjugate(self%x0 + z(1:4)))
      do i = 1, 8
         by_z(1, i) = 0.5_wp*self%inverse_j0*by_w(1, i)
         by_z(2:4, i) = 0.5_wp*times_vector(self%inverse_inertia, by_w(2:4, i))
      end do
   end function rate_derivative

   !> Adds -Δt/μ ∂f/∂z to the lower half, f = 2x̄∘s/|x̄|².
   pure subroutine add_forces(self, system, z, xm, a, by_z, matrix)
      class(eight_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: z(8), xm(4), a(4), by_z(4, 8)
      real(wp), intent(inout) :: matrix(8, 8)
      real(wp) :: s(4), by_x(4, 4), by_rate(3, 3), factor, square, image(4), column(4), omega(3)
      integer :: i
      omega = 0.5_wp*a(2:4)
      if (self%turn%there) omega = omega - frame_rate(self, xm)
      call self%forces%linearize(system%effects, self%x0 + z(1:4), xm, omega, s, by_x, by_rate)
      if (self%turn%there) call add_frame_rate(self, xm, by_rate, by_x)
      square = dot_product(xm, xm)
      factor = 2*self%dt/(self%momentum_unit*square)
      image = quat_product(xm, s)/square
      matrix(5:8, 1:4) = matrix(5:8, 1:4) - (0.5_wp*factor)*quat_right_matrix(s)
      do i = 1, 4
         matrix(5:8, i) = matrix(5:8, i) + factor*(xm(i)*image - quat_product(xm, by_x(:, i)))
      end do
      do i = 1, 8
         column(1) = 0.0_wp
         column(2:4) = 0.5_wp*times_vector(by_rate, by_z(2:4, i))
         matrix(5:8, i) = matrix(5:8, i) - factor*quat_product(xm, column)
      end do
   end subroutine add_forces

   !> Adds to ∂s/∂x1 the part of the rate of the space axes in body axes, R(x̄)ᵀω/|x̄|². Torques depend on Ω̄ less that
   !> rate: a change δx of x1 rotates it by θ = vec(x̄*∘δx)/|x̄|².
   pure subroutine add_frame_rate(self, xm, by_rate, by_x)
      type(eight_equations_t), intent(in) :: self
      real(wp), intent(in) :: xm(4), by_rate(3, 3)
      real(wp), intent(inout) :: by_x(4, 4)
      real(wp) :: turns(4, 4), rate(3)
      integer :: j
      rate = frame_rate(self, xm)
      turns = quat_left_matrix(quat_conjugate(xm))/dot_product(xm, xm)
      do j = 1, 4
         by_x(2:4, j) = by_x(2:4, j) - times_vector(by_rate, cross(rate, turns(2:4, j)))
      end do
   end subroutine add_frame_rate

   !> Writes or reads the data kept between steps: the unit of momentum. Quantities in this unit must be set again.
   subroutine transfer(self, archive)
      class(eight_equations_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%momentum_unit)
      self%scaled = self%scaled .and. .not. archive%is_reading()
   end subroutine transfer

end module nutate_eight_equations
