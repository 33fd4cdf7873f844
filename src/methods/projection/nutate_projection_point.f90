!> A state for the projection onto the invariants: attitude, momentum, energy and how fast the energy changes.
!>
!> The terms that a system has are sorted once: components are written out, and absent terms are not evaluated. Energies
!> are those of `nutate_hamiltonian`, to round-off.
module nutate_projection_point
   use nutate_effect, only: NO_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_indices, only: find_indices
   use nutate_invariants, only: conserved_momentum, ALL_COMPONENTS, ALONG_AXIS, NO_COMPONENT, ONLY_LENGTH
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: most_inner
   use nutate_quaternion, only: cross, times => quat_vector_product
   use nutate_small_products, only: symmetric_inverse, times_vector
   use nutate_state, only: add_increment, state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: projection_plan_t, projection_point_t, slope_t, get_slope, nearly_unit
   public :: read_point, set_attitude, set_momentum, set_rows, set_gamma, evaluate, times, write_state

   !> |qᵀq - 1| up to which the first term of 1/|q| is exact: the next one, 3/8 of its square, is below ε/4.
   real(wp), parameter :: nearly_unit = 1e-8_wp

   !> The wheels of a system.
   type, private :: planned_wheels_t
      !> Number of wheels, components of inner spheres among them.
      integer :: n = 0
      !> Momenta of the state set last, N m s; shape (most_inner).
      real(wp) :: momentum(most_inner) = 0.0_wp
      !> The momentum has errors, and takes part in moves; 1/Jw, kg⁻¹ m⁻², shape (most_inner), and the axis, body axes,
      !> shape (3, most_inner).
      logical :: moves(most_inner) = .false.
      real(wp) :: inverse_inertia(most_inner) = 0.0_wp, axis(3, most_inner) = 0.0_wp
   end type planned_wheels_t

   !> Terms of the energy and of the invariants of a system.
   type :: projection_plan_t
      !> The conserved components of l (`nutate_invariants`) and n, space axes; shape (3).
      integer :: components = ALL_COMPONENTS
      real(wp) :: axis(3) = 0.0_wp
      !> There is an attitude to rotate; the momentum may change; J is diagonal; there are rotors.
      logical :: attitude = .true., pushes = .false., diagonal = .true., has_rotor = .false.
      !> States are compensated sums: moves are added to them.
      logical :: compensated = .false.
      !> There are potentials linear in n itself; m of their sum U = -m·γ, body axes, J; shape (3).
      logical :: has_weight = .false.
      real(wp) :: weight(3) = 0.0_wp
      !> The system has other potentials; their indices.
      logical :: has_others = .false.
      integer, allocatable :: others(:)
      !> J⁻¹, kg⁻¹ m⁻²; shape (3,3); h, body axes, and |h|, N m s; shape (3).
      real(wp) :: inverse_inertia(3, 3) = 0.0_wp, rotor(3) = 0.0_wp, rotor_length = 0.0_wp
      !> The space axes rotate; the whole l of a free body then rotates in them by -ω; ω, rad/s; shape (3).
      logical :: turns = .false., turns_momentum = .false.
      real(wp) :: frame_rate(3) = 0.0_wp
      !> The inertia varies; that of the body at t = 0, kg m²; shape (3,3).
      logical :: varies = .false.
      real(wp) :: inertia(3, 3) = 0.0_wp
      !> There are potentials that move; the time of the state last taken, s.
      logical :: moves = .false.
      real(wp) :: t = 0.0_wp
      !> There are wheels, and h counts theirs; some take part in moves; their energy in the state last taken, J.
      logical :: has_wheels = .false., moves_wheels = .false.
      type(planned_wheels_t), allocatable :: wheels
      real(wp) :: wheel_energy = 0.0_wp
   contains
      procedure :: prepare
      !> Sets the time of a state.
      procedure :: set_time
      !> Copies the wheels of a state.
      procedure :: set_wheels
      !> Moves the wheels down a slope.
      procedure :: move_wheels
      !> Returns the energy of the wheels that do not move.
      procedure :: still_energy
   end type projection_plan_t

   !> A state for the projection onto the invariants.
   type :: projection_point_t
      !> Attitude; shape (4).
      real(wp) :: q(4)
      !> L, body axes, N m s; shape (3).
      real(wp) :: momentum(3)
      !> Both before they were moved; shapes (4), (3). Set if states are compensated sums.
      real(wp) :: first_q(4), first_momentum(3)
      !> Rᵀ; shape (3,3), and γ = Rᵀn, if l·n is conserved; shape (3).
      real(wp) :: to_body(3, 3), gamma(3)
      !> Ω, rad/s, and L̇ at fixed space momentum, N m, body axes; shape (3).
      real(wp) :: omega(3), rate(3)
      !> Ω - Rᵀω if the space axes rotate, rad/s, body axes; shape (3).
      real(wp) :: relative(3)
      !> 2T, H and T + Σ|U|, J, to which round-off of H is relative: with ½ Σ|xᵢ||J⁻¹ᵢⱼ||xⱼ|, x = L - h, for T if J is
      !> not diagonal, since its terms cancel on thin rods.
      real(wp) :: twice_kinetic, energy, size
   end type projection_point_t

   !> The direction in which the energy of a point falls. Energies are multiplied by a power of two.
   type :: slope_t
      !> L̇, body axes: the rotation vector is c times it; shape (3).
      real(wp) :: rotation(3)
      !> Ω⊥, rad/s, and what it is multiplied by, kg m²: ΔL = -c·inertia·Ω⊥; shape (3).
      real(wp) :: omega(3), inertia
      !> Change of the momentum of each wheel for c = -1; shape (most_inner).
      real(wp) :: wheels(most_inner)
      !> |L̇|² + S²|Ω⊥|² + Sw²Σω².
      real(wp) :: steepness
      !> S²|Ω⊥|² in it.
      real(wp) :: of_push
   contains
      !> Multiplies S² by a factor.
      procedure :: weigh_push
   end type slope_t

contains

   !> Sorts the terms of a system.
   pure subroutine prepare(self, system, attitude)
      class(projection_plan_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> True if the states have an attitude; otherwise only |l| is conserved.
      logical, intent(in) :: attitude
      call conserved_momentum(system%effects, self%components, self%axis)
      self%turns = system%effects%frame_turns
      self%frame_rate = system%effects%frame_rate
      self%turns_momentum = self%turns .and. &
                            system%effects%n_potentials + system%effects%n_off + system%effects%n_torques == 0
      if (self%turns_momentum) self%components = ALL_COMPONENTS
      if (.not. attitude .and. self%components == ALL_COMPONENTS) self%components = ONLY_LENGTH
      self%attitude = attitude
      self%pushes = self%components == ALONG_AXIS .or. self%components == NO_COMPONENT
      self%inverse_inertia = system%body%inverse_inertia
      self%inertia = system%body%inertia
      self%varies = system%effects%varies
      self%diagonal = .not. any(abs([self%inverse_inertia(1, 2), self%inverse_inertia(1, 3), &
                                     self%inverse_inertia(2, 3)]) > 0.0_wp) .and. .not. self%varies
      self%has_rotor = system%effects%n_rotors > 0
      self%has_wheels = system%effects%n_wheels > 0
      self%moves_wheels = .false.
      if (allocated(self%wheels)) deallocate (self%wheels)
      if (self%has_wheels) call sort_wheels(self, system%effects)
      self%moves = system%effects%moves
      self%wheel_energy = 0.0_wp
      self%rotor = system%effects%rotor_momentum
      self%rotor_length = norm2(self%rotor)
      call sort_potentials(self, system%effects)
   end subroutine prepare

   !> Finds the wheels whose momenta have errors: those with friction, those driven by feedback of the motion, and the
   !> components of inner spheres. The momentum of any other wheel is the integral of a known torque.
   pure subroutine sort_wheels(self, effects)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i
      allocate (self%wheels)
      self%wheels%n = effects%n_wheels
      do i = 1, effects%n_wheels
         associate (wheel => effects%wheels(i))
            self%wheels%moves(i) = wheel%friction > 0.0_wp .or. wheel%component > 0 .or. &
                                   wheel%series_kind() == NO_SERIES
            self%wheels%inverse_inertia(i) = 1/wheel%inertia
            self%wheels%axis(:, i) = wheel%axis
         end associate
      end do
      self%moves_wheels = any(self%wheels%moves)
   end subroutine sort_wheels

   !> Moves the wheels down a slope.
   pure subroutine move_wheels(self, effects, c, slope)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: c
      type(slope_t), intent(in) :: slope
      integer :: n
      n = effects%n_wheels
      self%wheels%momentum(:n) = self%wheels%momentum(:n) - c*slope%wheels(:n)
      self%rotor = effects%inner_momentum(self%wheels%momentum)
      self%rotor_length = norm2(self%rotor)
      self%wheel_energy = effects%wheel_energy(self%wheels%momentum)
   end subroutine move_wheels

   !> Returns the energy of the wheels that do not move, J, of the state set last.
   pure real(wp) function still_energy(self) result(energy)
      class(projection_plan_t), intent(in) :: self
      integer :: i
      energy = 0.0_wp
      if (.not. self%has_wheels) return
      do i = 1, self%wheels%n
         if (.not. self%wheels%moves(i)) &
            energy = energy + 0.5_wp*self%wheels%inverse_inertia(i)*self%wheels%momentum(i)**2
      end do
   end function still_energy

   !> Sets the time of a state, before it is converted to a point, and the inertia of that time.
   pure subroutine set_time(self, effects, t)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Time, s.
      real(wp), intent(in) :: t
      self%t = t
      if (self%varies) self%inverse_inertia = symmetric_inverse(self%inertia + effects%inertia_term(0, t, t, 1.0_wp))
   end subroutine set_time

   !> Copies the wheels of a state, before it is converted to a point.
   pure subroutine set_wheels(self, effects, state)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      self%wheels%momentum(:self%wheels%n) = state%wheel_momentum(:self%wheels%n)
      self%rotor = effects%inner_momentum(state%wheel_momentum)
      self%rotor_length = norm2(self%rotor)
      self%wheel_energy = effects%wheel_energy(state%wheel_momentum)
   end subroutine set_wheels

   !> Adds up the potentials that are linear in n, if l·n is conserved: they need no call and no γ of their own.
   pure subroutine sort_potentials(self, effects)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      logical :: is_other(effects%n_potentials)
      integer :: i
      self%weight = 0.0_wp
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            is_other(i) = self%components /= ALONG_AXIS .or. .not. potential%is_linear() .or. &
                          potential%varies
            if (.not. is_other(i)) &
               self%weight = self%weight + dot_product(potential%direction, self%axis)*potential%series_moment()
         end associate
      end do
      call find_indices(is_other, self%others)
      self%has_others = any(is_other)
      self%has_weight = .not. all(is_other)
   end subroutine sort_potentials

   !> Converts a state to a point, with its energy.
   pure subroutine read_point(self, effects, state, point)
      class(projection_plan_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      type(projection_point_t), intent(out) :: point
      if (self%has_wheels) call self%set_wheels(effects, state)
      call self%set_time(effects, state%t)
      call set_attitude(state, point)
      call set_momentum(state, point)
      call set_gamma(self, point)
      call evaluate(self, effects, point)
   end subroutine read_point

   !> Sets q, normalised, and Rᵀ.
   pure subroutine set_attitude(state, point)
      type(state_t), intent(in) :: state
      type(projection_point_t), intent(inout) :: point
      real(wp) :: square
      associate (q => state%q)
         square = (q(1)*q(1) + q(2)*q(2)) + (q(3)*q(3) + q(4)*q(4))
         if (abs(square - 1) <= nearly_unit) then
            point%q = (1.5_wp - 0.5_wp*square)*q
         else
            point%q = (1/sqrt(square))*q
         end if
      end associate
      call set_rows(point)
   end subroutine set_attitude

   !> Sets the L of p = 2 q∘[0, L], independently of the round-off of |q|.
   pure subroutine set_momentum(state, point)
      type(state_t), intent(in) :: state
      type(projection_point_t), intent(inout) :: point
      real(wp) :: half
      associate (q => state%q, p => state%p)
         half = 0.5_wp/((q(1)*q(1) + q(2)*q(2)) + (q(3)*q(3) + q(4)*q(4)))
         point%momentum(1) = half*(q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3))
         point%momentum(2) = half*(q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4))
         point%momentum(3) = half*(q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2))
      end associate
   end subroutine set_momentum

   !> Sets Rᵀ of a unit quaternion.
   pure subroutine set_rows(point)
      type(projection_point_t), intent(inout) :: point
      associate (q => point%q, rows => point%to_body)
         rows(1, 1) = 1 - 2*(q(3)*q(3) + q(4)*q(4))
         rows(2, 2) = 1 - 2*(q(2)*q(2) + q(4)*q(4))
         rows(3, 3) = 1 - 2*(q(2)*q(2) + q(3)*q(3))
         rows(1, 2) = 2*(q(2)*q(3) + q(1)*q(4))
         rows(2, 1) = 2*(q(2)*q(3) - q(1)*q(4))
         rows(1, 3) = 2*(q(2)*q(4) - q(1)*q(3))
         rows(3, 1) = 2*(q(2)*q(4) + q(1)*q(3))
         rows(2, 3) = 2*(q(3)*q(4) + q(1)*q(2))
         rows(3, 2) = 2*(q(3)*q(4) - q(1)*q(2))
      end associate
   end subroutine set_rows

   !> Sets γ = Rᵀn, if l·n is conserved.
   pure subroutine set_gamma(self, point)
      class(projection_plan_t), intent(in) :: self
      type(projection_point_t), intent(inout) :: point
      if (self%components == ALONG_AXIS) point%gamma = times_vector(point%to_body, self%axis)
   end subroutine set_gamma

   !> Computes Ω, L̇, T, H and the size of its terms.
   pure subroutine evaluate(self, effects, point)
      class(projection_plan_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(projection_point_t), intent(inout) :: point
      real(wp) :: x(3)
      associate (w => point%omega, inverse => self%inverse_inertia)
         x = point%momentum
         if (self%has_rotor) x = x - self%rotor
         if (self%diagonal) then
            w(1) = inverse(1, 1)*x(1)
            w(2) = inverse(2, 2)*x(2)
            w(3) = inverse(3, 3)*x(3)
         else
            w = times_vector(inverse, x)
         end if
         point%twice_kinetic = x(1)*w(1) + x(2)*w(2) + x(3)*w(3)
         point%energy = 0.5_wp*point%twice_kinetic
         point%size = point%energy
         if (.not. self%diagonal) point%size = 0.5_wp*sum(abs(x)*(abs(inverse(:, 1)*x(1)) + abs(inverse(:, 2)*x(2)) &
                                                                  + abs(inverse(:, 3)*x(3))))
         if (self%has_rotor) then
            point%size = point%size + self%rotor_length*sqrt(w(1)*w(1) + w(2)*w(2) + w(3)*w(3)) + self%wheel_energy
            point%energy = point%energy + self%wheel_energy
         end if
         point%rate = cross(point%momentum, w)
      end associate
      if (self%turns) call add_frame(self%frame_rate, point)
      if (self%has_weight) call add_weight(self%weight, point)
      if (self%has_others) call add_others(self, effects, point)
      if (.not. self%attitude .and. self%pushes) point%rate = 0.0_wp
   end subroutine evaluate

   !> Subtracts ω·l, and Rᵀω from Ω.
   pure subroutine add_frame(frame_rate, point)
      !> ω, space axes, rad/s; shape (3).
      real(wp), intent(in) :: frame_rate(3)
      type(projection_point_t), intent(inout) :: point
      real(wp) :: frame_in_body(3), energy
      frame_in_body = times_vector(point%to_body, frame_rate)
      energy = point%momentum(1)*frame_in_body(1) + point%momentum(2)*frame_in_body(2) + &
               point%momentum(3)*frame_in_body(3)
      point%energy = point%energy - energy
      point%size = point%size + abs(energy)
      point%relative = point%omega - frame_in_body
   end subroutine add_frame

   !> Adds U and γ×∇U.
   pure subroutine add_potential(energy, slope, gamma, point)
      !> U, J, and ∇U; shape (3).
      real(wp), intent(in) :: energy, slope(3)
      !> Shape (3).
      real(wp), intent(in) :: gamma(3)
      type(projection_point_t), intent(inout) :: point
      point%energy = point%energy + energy
      point%size = point%size + abs(energy)
      point%rate = point%rate + cross(gamma, slope)
   end subroutine add_potential

   !> Adds U = -m·γ and γ×∇U = m×γ of the potentials linear in n.
   pure subroutine add_weight(m, point)
      !> Shape (3).
      real(wp), intent(in) :: m(3)
      type(projection_point_t), intent(inout) :: point
      associate (gamma => point%gamma)
         call add_potential(-(m(1)*gamma(1) + m(2)*gamma(2) + m(3)*gamma(3)), -m, gamma, point)
      end associate
   end subroutine add_weight

   !> Adds U and γ×∇U of the other potentials.
   pure subroutine add_others(self, effects, point)
      use nutate_reshaped_potential, only: varying_energy, varying_gradient
      class(projection_plan_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(projection_point_t), intent(inout) :: point
      real(wp) :: gamma(3), slope(3), energy
      integer :: i
      do i = 1, size(self%others)
         associate (potential => effects%potentials(self%others(i))%item, rows => point%to_body)
            if (self%moves) then
               gamma = times_vector(rows, potential%direction_at(self%t))
            else
               gamma = times_vector(rows, potential%direction)
            end if
            slope = potential%gradient(gamma)
            energy = potential%energy(gamma)
            if (potential%varies) then
               slope = slope + varying_gradient(effects, self%others(i), gamma, self%t)
               energy = energy + varying_energy(effects, self%others(i), gamma, self%t)
            end if
            call add_potential(energy, slope, gamma, point)
         end associate
      end do
   end subroutine add_others

   !> Computes the direction in which the energy falls.
   pure subroutine get_slope(self, to_order_one, point, slope)
      class(projection_plan_t), intent(in) :: self
      !> A power of two that brings energies to order one.
      real(wp), intent(in) :: to_order_one
      type(projection_point_t), intent(in) :: point
      type(slope_t), intent(out) :: slope
      real(wp) :: square, kinetic, along
      slope%rotation = to_order_one*point%rate
      associate (x => slope%rotation)
         slope%steepness = x(1)*x(1) + x(2)*x(2) + x(3)*x(3)
      end associate
      slope%inertia = 0.0_wp
      slope%of_push = 0.0_wp
      slope%omega = point%omega
      if (self%moves_wheels) call add_wheels(self, to_order_one, point, slope)
      if (.not. self%pushes) return
      associate (w => slope%omega, gamma => point%gamma)
         square = w(1)*w(1) + w(2)*w(2) + w(3)*w(3)
         if (square <= tiny(1.0_wp)/eps) return
         kinetic = to_order_one*point%twice_kinetic
         slope%inertia = kinetic*(point%twice_kinetic/square)
         if (self%turns) w = point%relative
         if (self%components == ALONG_AXIS) then
            along = w(1)*gamma(1) + w(2)*gamma(2) + w(3)*gamma(3)
            w = w - along*gamma
            kinetic = kinetic*((w(1)*w(1) + w(2)*w(2) + w(3)*w(3))/square)*kinetic
         else if (self%turns) then
            kinetic = kinetic*((w(1)*w(1) + w(2)*w(2) + w(3)*w(3))/square)*kinetic
         else
            kinetic = kinetic*kinetic
         end if
         slope%of_push = kinetic
         slope%steepness = slope%steepness + kinetic
      end associate
   end subroutine get_slope

   !> Multiplies S² by a factor.
   pure subroutine weigh_push(self, factor)
      class(slope_t), intent(inout) :: self
      real(wp), intent(in) :: factor
      self%inertia = factor*self%inertia
      self%steepness = (self%steepness - self%of_push) + factor*self%of_push
      self%of_push = factor*self%of_push
   end subroutine weigh_push

   !> Adds the wheels to a slope: with the speeds ω = h/Jw - s·Ω, at fixed L `dH = ω dh`, Δh = -cSw²ω,
   !> Sw² = (Σ Jw ω²)²/Σω² over the wheels that move.
   pure subroutine add_wheels(self, to_order_one, point, slope)
      class(projection_plan_t), intent(in) :: self
      real(wp), intent(in) :: to_order_one
      type(projection_point_t), intent(in) :: point
      !> Slope, with the steepness of the rotation on entry.
      type(slope_t), intent(inout) :: slope
      real(wp) :: speed, square, energy
      integer :: i
      square = 0.0_wp
      energy = 0.0_wp
      slope%wheels(:self%wheels%n) = 0.0_wp
      do i = 1, self%wheels%n
         if (.not. self%wheels%moves(i)) cycle
         speed = self%wheels%inverse_inertia(i)*self%wheels%momentum(i) &
                 - dot_product(self%wheels%axis(:, i), point%omega)
         slope%wheels(i) = speed
         square = square + speed*speed
         energy = energy + speed*speed/self%wheels%inverse_inertia(i)
      end do
      if (square <= tiny(1.0_wp)/eps) then
         slope%wheels(:self%wheels%n) = 0.0_wp
         return
      end if
      energy = to_order_one*energy
      slope%wheels(:self%wheels%n) = (energy*(energy/(to_order_one*square)))*slope%wheels(:self%wheels%n)
      slope%steepness = slope%steepness + energy*energy
   end subroutine add_wheels

   !> Writes q, and p = 2 q∘[0, L], to the state.
   pure subroutine write_state(self, point, state)
      class(projection_plan_t), intent(in) :: self
      type(projection_point_t), intent(in) :: point
      type(state_t), intent(inout) :: state
      real(wp) :: moved
      integer :: i
      if (self%moves_wheels) then
         do i = 1, self%wheels%n
            moved = self%wheels%momentum(i) - state%wheel_momentum(i)
            if (abs(moved) > 0.0_wp) call add_increment(state%wheel_momentum(i), state%wheel_compensation(i), moved)
         end do
      end if
      if (self%compensated) then
         call add_moves(point, state)
         return
      end if
      if (self%attitude) state%q = point%q
      state%p = times(state%q, 2*point%momentum)
      state%q_compensation = 0.0_wp
      state%p_compensation = 0.0_wp
   end subroutine write_state

   !> Adds the moves of a point to its state.
   pure subroutine add_moves(point, state)
      type(projection_point_t), intent(in) :: point
      type(state_t), intent(inout) :: state
      real(wp) :: dq(4), dp(4)
      dq = point%q - point%first_q
      dp = times(dq, 2*point%momentum) + times(state%q, 2*(point%momentum - point%first_momentum))
      call add_increment(state%q, state%q_compensation, dq)
      call add_increment(state%p, state%p_compensation, dp)
   end subroutine add_moves

end module nutate_projection_point
