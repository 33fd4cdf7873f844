!> The three equations of a step in reduced form, for states with q·p = 0 and |q| = 1.
!>
!> A step rotates the body by the Cayley map c = (1+b)∘(1-b)⁻¹, b = ¼Δt Ω̄. With the mean momentum `L̄ = (4/Δt)Jb + h`,
!> β = |b|², and the torque τ̄ in the frame of mid step, the change of momentum `R(c½)L1 - R(c½)ᵀL0 = Δt τ̄` reads
!>
!>     G(b) = (1-β)(L̄ - L0) + 2b×L̄ - ½Δt((1+β)τ̄ - 2b(b·τ̄)) = 0,
!>
!> whose free part is the implicit midpoint rule of Euler's equations with the step Δt/(1-β). These are the eight
!> equations of `nutate_eight_equations`, the discrete (9a) and (11) of Nielsen & Krenk (2012), on the constraints (2)
!> and (5): the same root, with three unknowns instead of eight. The projection of (11) is that τ̄ alone enters, and no
!> scalar part beside it.
!>
!> In space axes that rotate (`nutate_frame_turn`) β-d replaces β, and forces are those of the r of b, by which
!> attitudes rotate.
!>
!> The equations are solved in units of 4s/Δt, s the largest diagonal entry of J, in which L̄ is (J/s)b + hΔt/4s:
!> numbers of order 1 for any body.
module nutate_reduced_equations
   use nutate_cayley, only: measure_turn
   use nutate_kinds, only: wp
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_effect_list, only: effect_list_t
   use nutate_frame_turn, only: frame_turn_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_product
   use nutate_small_products, only: times_columns, times_vector
   use nutate_sphere_steps, only: prepare_spheres, sphere_steps_t
   use nutate_state, only: add_increment, add_rotated, state_t
   use nutate_system, only: inertia_at, inverse_inertia_at, system_t
   use nutate_wheel_steps, only: prepare_wheels, wheel_steps_t
   implicit none
   private

   public :: reduced_equations_t

   !> Largest momentum or torque in the units of the step: no step is accepted with larger ones, whose products would
   !> overflow.
   real(wp), parameter :: greatest = 1e40_wp
   !> Largest d of rotating space axes at which F'' and the adjugate of F' of a free body change by no more than 2 %.
   real(wp), parameter :: slow_frame = 0.01_wp

   !> One step's equations F(b) = 0, F = (Δt/4s) G.
   type :: reduced_equations_t
      !> Length of the step, s.
      real(wp) :: dt = 0.0_wp
      !> 4/Δt, 1/s.
      real(wp) :: rate = 0.0_wp
      !> u = q0/|q0|, body→space at the start of the step; shape (4). The norm matters: with q0 as u, the round-off of
      !> |q0| would make the momentum drift in proportion to the number of steps.
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> |q0|²
      real(wp) :: square = 1.0_wp
      !> ½u*∘p0 = [round-off of q·p, L0], kg m²/s.
      real(wp) :: half_momentum(4) = 0.0_wp
      !> Δt/4s, and L0 and h times it, h that of rotors and, with friction, a share of that of wheels; shape (3).
      real(wp) :: scale = 0.0_wp, momentum(3) = 0.0_wp, rotor(3) = 0.0_wp
      !> J/s, with the part that the friction of wheels adds; shape (3,3). Determinant of J/s for a very short step.
      real(wp) :: inertia(3, 3) = 0.0_wp, unloaded = 1.0_wp
      !> J⁻¹ of the middle of the step, kg⁻¹ m⁻²; shape (3,3).
      real(wp) :: inverse(3, 3) = 0.0_wp
      !> That middle, s.
      real(wp) :: middle = 0.0_wp
      !> ½Δt²/4s, and the effects' part of the Jacobian; shape (3,3).
      real(wp) :: weight = 0.0_wp, by_forces(3, 3) = 0.0_wp
      !> Values at the last b: L̄, L̄ - L0, in the units of the step, and β (β-d if the space axes rotate); τ̄ of the
      !> last F, N m; shape (3).
      real(wp) :: mean(3) = 0.0_wp, change(3) = 0.0_wp, beta = 0.0_wp, torque(3) = 0.0_wp
      !> Largest torque that is admissible, N m, and whether one was larger since the start of the step.
      real(wp) :: torque_limit = 0.0_wp
      logical :: too_strong = .false.
      type(discrete_forces_t) :: forces
      !> Rotation of the space axes during the step; there are forces in them.
      type(frame_turn_t) :: turn
      logical :: is_relative = .false.
      !> Without forces F is a cubic polynomial of b, whose coefficients are nearly those in non-rotating axes.
      logical :: is_cubic = .false.
      !> Wheels, and inner spheres, in the step; not allocated if there are none.
      type(wheel_steps_t), allocatable :: wheels
      type(sphere_steps_t), allocatable :: spheres
   contains
      !> Stores the effects of a system.
      procedure :: prepare
      !> Sets the step's length.
      procedure :: set_step
      !> Starts a step from a state.
      procedure :: start
      !> Returns true if the momenta are of a size that a step can follow.
      procedure :: is_in_scale
      !> Returns the b of a step with constant momentum.
      procedure :: explicit_guess
      !> Sets the b at which the derivative is computed.
      procedure :: set_point
      !> Computes F(b), the discrete (9a) and (11) on the constraint manifold.
      procedure :: residual
      !> Computes ∂F/∂b.
      procedure :: jacobian
      !> Computes the effects' part of ∂F/∂b.
      procedure :: linearize_forces
      !> Computes the inverse of ∂F/∂b with the effects' part as it is, and its determinant.
      procedure :: invert
      !> Computes the work of the torques.
      procedure :: get_work
      !> Returns Ω̄ of a step.
      procedure :: mean_rate
      !> Moves the state to the end of the step.
      procedure :: finish
      procedure :: finish_in_frame
      !> Moves inner spheres to the end of the step, before the state.
      procedure :: finish_spheres
   end type reduced_equations_t

contains

   !> Stores the effects of a system.
   pure subroutine prepare(self, effects)
      class(reduced_equations_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      call self%forces%prepare(effects, .true.)
      call prepare_wheels(effects, self%wheels)
      call prepare_spheres(effects, self%spheres)
      self%dt = 0.0_wp
   end subroutine prepare

   !> Sets the step's length, and the inertia.
   pure subroutine set_step(self, system, dt, middle)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: dt
      !> Middle of the step, s, for an inertia that varies.
      real(wp), intent(in), optional :: middle
      real(wp) :: largest
      associate (j => system%body%inertia)
         largest = max(j(1, 1), j(2, 2), j(3, 3))
         self%inertia = j/largest
      end associate
      associate (moments => system%body%moments)
         self%unloaded = (moments(1)/largest)*(moments(2)/largest)*(moments(3)/largest)
      end associate
      self%inverse = system%body%inverse_inertia
      if (present(middle)) call set_inertia(self, system, middle, largest)
      self%dt = dt
      self%rate = 4/dt
      self%scale = 0.25_wp*dt/largest
      self%weight = 0.5_wp*dt*self%scale
      ! Steps end on the times of torques, which can be as close to each other as numbers are.
      self%torque_limit = greatest/max(self%weight, 1e-250_wp)
      self%rotor = self%scale*system%effects%rotor_momentum
      call self%turn%prepare(system%effects)
      self%is_relative = self%turn%there .and. self%forces%active
      self%is_cubic = .not. self%forces%active .and. .not. allocated(self%wheels) .and. &
                      (0.25_wp*dt)**2*dot_product(self%turn%rate, self%turn%rate) <= slow_frame
      if (allocated(self%spheres)) call self%spheres%set_step(system%effects, dt)
      if (.not. allocated(self%wheels)) return
      call self%wheels%set_step(system%effects, dt)
      self%inertia = self%inertia + self%wheels%coupling/largest
   end subroutine set_step

   !> Sets the inertia of a time.
   pure subroutine set_inertia(self, system, t, largest)
      type(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Time, s.
      real(wp), intent(in) :: t
      !> Largest element of the inertia, kg m².
      real(wp), intent(out) :: largest
      real(wp) :: j(3, 3)
      j = inertia_at(system, t)
      largest = max(j(1, 1), j(2, 2), j(3, 3))
      j = j/largest
      self%inertia = j
      self%inverse = inverse_inertia_at(system, t)
      self%middle = t
      self%unloaded = dot_product(j(:, 1), cross(j(:, 2), j(:, 3)))
   end subroutine set_inertia

   !> Starts a step from a state.
   pure subroutine start(self, system, state, window_time)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Time that decides which torques act, s; default: the middle of the step.
      real(wp), intent(in), optional :: window_time
      self%square = dot_product(state%q, state%q)
      ! 1/|q| to the last digit if |q|² - 1 is below 1e-8.
      self%frame = (0.5_wp*(3 - self%square))*state%q
      self%half_momentum = 0.5_wp*quat_product(quat_conjugate(self%frame), state%p)
      self%momentum = self%scale*self%half_momentum(2:4)
      self%too_strong = .false.
      if (allocated(self%spheres)) then
         call self%spheres%start(system%effects, state, self%frame, self%forces%pull, self%forces%drag)
         self%momentum = self%scale*(self%half_momentum(2:4) - self%spheres%inner)
      end if
      if (allocated(self%wheels)) then
         call self%wheels%start(system%effects, state, window_time)
         self%rotor = self%scale*(system%effects%rotor_momentum + self%wheels%rotor)
      end if
      if (self%forces%active) &
         call self%forces%start(system%effects, state%t + 0.5_wp*self%dt, self%frame, 1.0_wp, window_time)
      if (.not. self%turn%there) return
      if (system%effects%n_potentials > 0) then
         call self%turn%begin(self%dt, self%frame, self%forces%columns)
      else
         call self%turn%begin(self%dt, self%frame)
      end if
   end subroutine start

   !> Returns true if the momenta are of a size that a step can follow.
   pure logical function is_in_scale(self)
      class(reduced_equations_t), intent(in) :: self
      is_in_scale = max(maxval(abs(self%momentum)), maxval(abs(self%rotor))) <= greatest
      if (allocated(self%wheels)) is_in_scale = is_in_scale .and. self%wheels%is_short
      if (allocated(self%spheres)) is_in_scale = is_in_scale .and. self%spheres%is_short
   end function is_in_scale

   !> Returns b = ¼Δt J⁻¹(L0 - h) of a step with constant momentum; shape (3).
   pure function explicit_guess(self, system) result(b)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp) :: b(3)
      real(wp) :: inner(3)
      inner = system%effects%rotor_momentum
      if (allocated(self%wheels)) inner = inner + self%wheels%first
      if (allocated(self%spheres)) inner = inner + self%spheres%inner
      b = (0.25_wp*self%dt)*times_vector(self%inverse, self%half_momentum(2:4) - inner)
   end function explicit_guess

   !> Computes the mean momentum of a rotation, for F and its derivative.
   pure subroutine set_point(self, b)
      class(reduced_equations_t), intent(inout) :: self
      real(wp), intent(in) :: b(3)
      self%mean = times_vector(self%inertia, b) + self%rotor
      self%change = self%mean - self%momentum
      self%beta = dot_product(b, b) - self%turn%square
   end subroutine set_point

   !> Computes F(b) = (Δt/4s) G(b); shape (3). Stores the torque. A torque that is too large is left out.
   pure subroutine residual(self, system, b, f)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: f(3)
      real(wp) :: tau(3)
      call set_point(self, b)
      f = (1 - self%beta)*self%change + 2*cross(b, self%mean)
      if (.not. self%forces%active) return
      if (self%is_relative) then
         call add_torque_in_frame(self, system, b, f)
         return
      end if
      call self%forces%turn(system%effects, b, self%rate, self%torque)
      if (max(abs(self%torque(1)), abs(self%torque(2)), abs(self%torque(3))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      tau = self%weight*self%torque
      f = f - (1 + self%beta)*tau + (2*dot_product(b, tau))*b
   end subroutine residual

   !> Adds the torque's part if the space axes rotate, -½Δt((1+ρ)τ̄ - 2r(b·τ̄)), in units of the step.
   pure subroutine add_torque_in_frame(self, system, b, f)
      type(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(inout) :: f(3)
      real(wp) :: r(3), tau(3), stretch
      call self%turn%get_relative(b, self%beta, r, stretch)
      if (self%forces%in_fields) then
         ! With 1 + ρ available this saves a call, which is most of the cost of rotating axes.
         call self%forces%turn_in_fields(r, stretch, self%torque)
      else
         call self%forces%turn(system%effects, r, self%rate, self%torque)
      end if
      if (max(abs(self%torque(1)), abs(self%torque(2)), abs(self%torque(3))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      tau = self%weight*self%torque
      f = f - stretch*tau + (2*(b(1)*tau(1) + b(2)*tau(2) + b(3)*tau(3)))*r
   end subroutine add_torque_in_frame

   !> Computes ∂F/∂b, the Jacobian; shape (3,3).
   pure subroutine jacobian(self, system, b, matrix)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: matrix(3, 3)
      call self%set_point(b)
      if (self%forces%active) call self%linearize_forces(system, b)
      call add_free_part(self, b, matrix)
   end subroutine jacobian

   !> Computes the derivative of -½Δt((1+β)τ̄ - 2b(b·τ̄)) at b, and stores it until the next call.
   pure subroutine linearize_forces(self, system, b)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp) :: tau(3), by_b(3, 3), column(3), beta
      integer :: j
      if (self%is_relative) then
         call linearize_in_frame(self, system, b)
         return
      end if
      call self%forces%linearize_turn(system%effects, b, self%rate, tau, by_b)
      if (max(maxval(abs(tau)), maxval(abs(by_b))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      beta = dot_product(b, b)
      do j = 1, 3
         column = (1 + beta)*by_b(:, j) + (2*b(j))*tau - (2*(dot_product(b, by_b(:, j)) + tau(j)))*b
         column(j) = column(j) - 2*dot_product(b, tau)
         self%by_forces(:, j) = -self%weight*column
      end do
   end subroutine linearize_forces

   !> Computes the derivative of -½Δt((1+ρ)τ̄ - 2r(b·τ̄)) at b.
   pure subroutine linearize_in_frame(self, system, b)
      type(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp) :: r(3), tau(3), by_b(3, 3), r_by_b(3, 3), column(3), along, factor
      integer :: j
      r = self%turn%to_relative(b)
      r_by_b = self%turn%relative_by_absolute(b, r)
      call self%forces%linearize_turn(system%effects, r, self%rate, tau, by_b)
      by_b = times_columns(by_b, r_by_b)
      if (max(maxval(abs(tau)), maxval(abs(by_b))) > self%torque_limit) then
         self%too_strong = .true.
         return
      end if
      along = 2*dot_product(b, tau)
      factor = 1 + dot_product(r, r)
      do j = 1, 3
         column = factor*by_b(:, j) + (2*dot_product(r, r_by_b(:, j)))*tau &
                  - (2*(dot_product(b, by_b(:, j)) + tau(j)))*r - along*r_by_b(:, j)
         self%by_forces(:, j) = -self%weight*column
      end do
   end subroutine linearize_in_frame

   !> Computes ∂F/∂b: the derivative of (1-β)(L̄ - L0) + 2b×L̄ and the effects' part.
   pure subroutine add_free_part(self, b, matrix)
      type(reduced_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: matrix(3, 3)
      real(wp) :: n(3), rest
      integer :: j
      rest = 1 - self%beta
      do j = 1, 3
         n = self%inertia(:, j)
         matrix(:, j) = self%by_forces(:, j) + (rest*n + 2*(cross(b, n) - b(j)*self%change))
      end do
      call add_cross_of_mean(self%mean, matrix)
   end subroutine add_free_part

   !> Adds to a matrix the derivative of 2 b×m with respect to b at constant m.
   pure subroutine add_cross_of_mean(m, matrix)
      real(wp), intent(in) :: m(3)
      real(wp), intent(inout) :: matrix(3, 3)
      real(wp) :: twice(3)
      twice = 2*m
      matrix(2, 1) = matrix(2, 1) - twice(3)
      matrix(3, 1) = matrix(3, 1) + twice(2)
      matrix(1, 2) = matrix(1, 2) + twice(3)
      matrix(3, 2) = matrix(3, 2) - twice(1)
      matrix(1, 3) = matrix(1, 3) - twice(2)
      matrix(2, 3) = matrix(2, 3) + twice(1)
   end subroutine add_cross_of_mean

   !> Computes the inverse of ∂F/∂b at the last b, from its adjugate, with the effects' part of the last
   !> `linearize_forces`; none if the determinant is zero.
   pure subroutine invert(self, b, rows, determinant)
      class(reduced_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      !> Rows of the inverse; shape (3, row).
      real(wp), intent(out) :: rows(3, 3)
      real(wp), intent(out) :: determinant
      real(wp) :: m(3, 3)
      call add_free_part(self, b, m)
      rows(:, 1) = cross(m(:, 2), m(:, 3))
      rows(:, 2) = cross(m(:, 3), m(:, 1))
      rows(:, 3) = cross(m(:, 1), m(:, 2))
      determinant = dot_product(rows(:, 1), m(:, 1))
      if (abs(determinant) > tiny(1.0_wp)) rows = (1/determinant)*rows
   end subroutine invert

   !> Returns Ω̄ of the step whose root is b, body axes, rad/s; shape (3).
   pure function mean_rate(self, b) result(omega)
      class(reduced_equations_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      real(wp) :: omega(3)
      omega = self%rate*b
   end function mean_rate

   !> Computes the work of each torque in the step whose root is b.
   pure subroutine get_work(self, system, b, work)
      class(reduced_equations_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      !> Work, J; shape (number of torques).
      real(wp), intent(inout) :: work(:)
      real(wp) :: r(3)
      r = b
      if (self%is_relative) r = self%turn%to_relative(b)
      call self%forces%get_work(system%effects, self%dt, [1.0_wp, r]/(1 + dot_product(r, r)), self%rate*r, work)
   end subroutine get_work

   !> Moves inner spheres to the end of the step whose root is b, and leaves in τ̄, unless the space axes rotate, the
   !> torque of the other effects alone: the spheres keep the total momentum.
   pure subroutine finish_spheres(self, system, b, state, work)
      class(reduced_equations_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      type(state_t), intent(inout) :: state
      !> Work, J; shape (n_works).
      real(wp), intent(inout) :: work(:)
      if (self%turn%there) then
         call self%spheres%finish(system%effects, self%turn%to_relative(b), state, work)
      else
         call self%spheres%finish(system%effects, b, state, work)
         self%forces%has_spheres = .false.
         call self%forces%turn(system%effects, b, self%rate, self%torque)
         self%forces%has_spheres = .true.
      end if
   end subroutine finish_spheres

   !> Moves the state to the end of the step whose root is b, q1 = q0∘c and p1 = p0∘c + Δt f, f the force of the
   !> effects. Both are sums of increments, kept with their compensation.
   pure subroutine finish(self, b, attitude, state)
      class(reduced_equations_t), intent(in) :: self
      !> Root; if there are effects, the last b at which F was evaluated.
      real(wp), intent(in) :: b(3)
      !> The attitude is moved too.
      logical, intent(in) :: attitude
      type(state_t), intent(inout) :: state
      real(wp) :: c(4), impulse(4), beta, factor, excess
      call measure_turn(b, beta, factor, excess)
      if (attitude) then
         c(1) = -beta
         c(2:4) = b
         impulse = 0.0_wp
         if (self%forces%active) impulse = quat_product(self%frame, mid_impulse(self, b, factor))
         ! The increments of a rotation are computed from q and p, so that only their own rounding remains: the momentum
         ! in body axes would add all of its rounding. The factor comes last, since its rounding is included in
         ! `excess`.
         call add_rotated(factor*quat_product(state%q, c), excess, state%q, state%q_compensation)
         call add_rotated(factor*quat_product(state%p, c) + impulse, excess, state%p, state%p_compensation)
      else
         impulse(1) = 0.0_wp
         impulse(2:4) = 2*momentum_change(self, b, beta, factor)
         call add_increment(state%p, state%p_compensation, quat_product(self%frame, impulse))
      end if
      state%t = state%t + self%dt
   end subroutine finish

   !> Moves the state to the end of the step if the space axes rotate: q1 = q0∘c, and p1 = 2 q1∘L1 as an increment,
   !> 2u∘((c - 1)∘L1 + ΔL), less the rounding error of q·p.
   pure subroutine finish_in_frame(self, b, state)
      class(reduced_equations_t), intent(in) :: self
      !> Root; if there are effects, the last b at which F was evaluated.
      real(wp), intent(in) :: b(3)
      type(state_t), intent(inout) :: state
      real(wp) :: r(3), c(4), impulse(3), square, factor, excess
      impulse = 0.0_wp
      if (self%is_relative) impulse = self%dt*self%torque
      r = self%turn%to_relative(b)
      call measure_turn(r, square, factor, excess)
      c(1) = -square
      c(2:4) = r
      call add_rotated(factor*quat_product(state%q, c), excess, state%q, state%q_compensation)
      if (allocated(self%spheres)) then
         c = self%half_momentum
         c(2:4) = c(2:4) - self%spheres%inner
         c = self%turn%momentum_increment(b, r, square, factor, c, impulse) + self%spheres%spin
      else
         c = self%turn%momentum_increment(b, r, square, factor, self%half_momentum, impulse)
      end if
      call add_increment(state%p, state%p_compensation, 2*quat_product(self%frame, c))
      state%t = state%t + self%dt
   end subroutine finish_in_frame

   !> Returns Δt·2c½∘τ̄∘c½ = 2Δt [-2b·τ̄, (1+β)τ̄ - 2b(b·τ̄)]/(1+β), in the frame at the start; shape (4).
   pure function mid_impulse(self, b, factor) result(impulse)
      type(reduced_equations_t), intent(in) :: self
      !> b and 2/(1+β).
      real(wp), intent(in) :: b(3), factor
      real(wp) :: impulse(4)
      impulse(2:4) = (2*self%dt)*self%torque
      impulse(1) = -factor*dot_product(b, impulse(2:4))
      impulse(2:4) = impulse(2:4) + impulse(1)*b
   end function mid_impulse

   !> Returns L1 - L0 = (R(c)ᵀ - 1)L0 + Δt R(c½)ᵀτ̄, each in the body axes at its time: the increment of a step that
   !> does not move the attitude; shape (3).
   pure function momentum_change(self, b, beta, factor) result(change)
      type(reduced_equations_t), intent(in) :: self
      !> b, β and 2/(1+β).
      real(wp), intent(in) :: b(3), beta, factor
      real(wp) :: change(3), x(3)
      x = cross(b, self%half_momentum(2:4))
      change = (factor*factor)*(2*cross(b, x) - (1 - beta)*x)
      if (.not. self%forces%active) return
      x = (0.5_wp*self%dt*factor)*self%torque
      change = change + ((1 - beta)*x - 2*cross(b, x) + (2*dot_product(b, x))*b)
   end function momentum_change

end module nutate_reduced_equations
