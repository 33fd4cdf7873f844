!> The conserving correction: puts the state that a step of any method reached back onto the invariants of the run.
!>
!> In this order: `q` is normalised; the conserved components of the space momentum `l` take their stored values; then
!> the excess `ΔH = H - (H₀ + work)` is removed by the smallest move along which it falls. The moves that leave the
!> conserved components of l alone are
!>
!> * a turn of the attitude by the body rotation vector δ at fixed l: `dH = -δ·L̇`, `L̇ = L×Ω + τ`, τ the torque of the
!>   potentials;
!> * where not all of l is conserved, a change ΔL of the momentum: `dH = Ω⊥·ΔL`, Ω⊥ = Ω, or Ω without its component
!>   along γ = Rᵀn where l·n is conserved.
!>
!> The smallest in `|δ|² + |ΔL|²/S²`, `S = 2T/|Ω|`, is `δ = cL̇`, `ΔL = -cS²Ω⊥`, `c = ΔH/(|L̇|² + S²|Ω⊥|²)`. Newton's
!> iteration repeats it. The turn alone would do for a free body; a pendulum has L̇ = 0 at the bottom of each swing,
!> where only its momentum can make up for an error of the energy.
!>
!> **Limits.** H is stationary at relative equilibria: there the move becomes long for a ΔH that is nothing but
!> round-off. Excesses up to `dead_band` of the energy's scale are left as they are, those up to `doubtful` are
!> corrected by short moves only. Beyond it a move of more than 0.1 rad means that the step was too long.
!>
!> **Targets.** H₀ + work and l are those of the first state, not of the last, so that nothing adds up over a long run.
!> A stepper is also handed states that it did not return last: rejected steps are tried again, halves follow the
!> whole, rows between steps branch off. All of them lie on the same invariants, to round-off, and so keep the targets
!> (or, where torques did work, those of the step before); a state that does not starts anew from its own.
module nutate_conserve
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: conserved_momentum, ALL_COMPONENTS, ALONG_AXIS, NO_COMPONENT, ONLY_LENGTH
   use nutate_kinds, only: wp, eps
   use nutate_linear_potential, only: linear_potential_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_OFF_BRANCH
   use nutate_system, only: system_t
   implicit none
   private

   public :: correction_t

   !> Parts of the energy's scale: an excess below the first is round-off of H, up to the second it may be.
   real(wp), parameter :: dead_band = 4*eps, doubtful = 32*eps
   !> Squares of moves, rad²: the longest at all; the longest for a doubtful excess; the longest after which the rest of
   !> the excess, which goes as the square of the move, is round-off.
   real(wp), parameter :: longest = 1e-2_wp, longest_doubtful = eps, negligible = 1e-17_wp
   !> Moves at most: at a double root of H an excess falls by four each time.
   integer, parameter :: most_moves = 24
   !> |qᵀq - 1| up to which the first term of 1/|q| is exact.
   real(wp), parameter :: nearly_unit = 1e-8_wp

   !> A state as the correction sees it.
   type :: point_t
      !> Attitude; shape (4).
      real(wp) :: q(4)
      !> L, body axes, N m s; shape (3).
      real(wp) :: momentum(3)
      !> Rᵀ; shape (3,3).
      real(wp) :: to_body(3, 3)
      !> Ω, rad/s, and L̇ at fixed space momentum, N m, body axes; shape (3).
      real(wp) :: omega(3), rate(3)
      !> 2T, H and T + Σ|U|, J.
      real(wp) :: twice_kinetic, energy, size
   end type point_t

   !> Invariants that states are put back to.
   type :: target_t
      !> H₀ + work and the digits its sum cannot hold, J.
      real(wp) :: energy = 0.0_wp, energy_carry = 0.0_wp
      !> l, space axes, N m s; shape (3).
      real(wp) :: momentum(3) = 0.0_wp
      !> The conserved part of it: l·n, or |l|, N m s.
      real(wp) :: component = 0.0_wp
   end type target_t

   !> The correction of one run.
   type :: correction_t
      private
      !> From the plan: the conserved components of l (`nutate_invariants`) and n, space axes; shape (3).
      integer :: components = ALL_COMPONENTS
      real(wp) :: axis(3) = 0.0_wp
      !> There is an attitude to turn; the momentum may change; J is diagonal; there are rotors.
      logical :: attitude = .true., pushes = .false., diagonal = .true., has_rotor = .false.
      !> J⁻¹, kg⁻¹ m⁻²; shape (3,3); h, body axes, and |h|, N m s; shape (3).
      real(wp) :: inverse_inertia(3, 3) = 0.0_wp, rotor(3) = 0.0_wp, rotor_length = 0.0_wp
      !> Potentials linear in a direction: m, body axes, and n, space axes; shape (3, number of them).
      real(wp), allocatable :: moment(:, :), direction(:, :)
      !> Which potentials of the system are not linear.
      integer, allocatable :: others(:)
      !> Largest T + Σ|U| so far, J; the largest of it and |L̇|, and a power of two next to its inverse.
      real(wp) :: size = 0.0_wp, largest = 0.0_wp, unit = 1.0_wp
      !> The targets at the last state, and those before its step.
      type(target_t) :: now, before
      !> The last state corrected: one that differs is compared with the targets.
      real(wp) :: last_q(4) = 0.0_wp, last_p(4) = 0.0_wp
      logical :: started = .false.
   contains
      !> Takes the invariants that a system has.
      procedure :: prepare
      !> Takes the invariants' values from a state.
      procedure :: start
      !> Makes sure that the targets are those of the state from which a step starts.
      procedure :: follow
      !> Corrects the state that the step reached.
      procedure :: correct
   end type correction_t

contains

   !> Takes the invariants that a system has. To be called before the first step and after every change of the system.
   pure subroutine prepare(self, system, attitude)
      class(correction_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The attitude is integrated; else the states have none, and of l only the length is conserved.
      logical, intent(in) :: attitude
      call conserved_momentum(system%effects, self%components, self%axis)
      if (.not. attitude .and. self%components == ALL_COMPONENTS) self%components = ONLY_LENGTH
      self%attitude = attitude
      self%pushes = self%components == ALONG_AXIS .or. self%components == NO_COMPONENT
      self%inverse_inertia = system%body%inverse_inertia
      self%diagonal = .not. any(abs([self%inverse_inertia(1, 2), self%inverse_inertia(1, 3), &
                                     self%inverse_inertia(2, 3)]) > 0.0_wp)
      self%has_rotor = system%effects%n_rotors > 0
      self%rotor = system%effects%rotor_momentum
      self%rotor_length = norm2(self%rotor)
      self%started = .false.
      call sort_potentials(self, system%effects)
   end subroutine prepare

   !> Separates the potentials that are linear in a direction, which need no call, from the others.
   pure subroutine sort_potentials(self, effects)
      class(correction_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      logical :: is_linear(effects%n_potentials)
      integer :: i, n
      is_linear = .false.
      do i = 1, effects%n_potentials
         select type (potential => effects%potentials(i)%item)
         class is (linear_potential_t)
            is_linear(i) = .true.
         end select
      end do
      if (allocated(self%others)) deallocate (self%others, self%moment, self%direction)
      allocate (self%others(count(.not. is_linear)))
      allocate (self%moment(3, count(is_linear)), self%direction(3, count(is_linear)))
      self%others = pack([(i, i=1, effects%n_potentials)],.not. is_linear)
      n = 0
      do i = 1, effects%n_potentials
         select type (potential => effects%potentials(i)%item)
         class is (linear_potential_t)
            n = n + 1
            self%moment(:, n) = potential%moment
            self%direction(:, n) = potential%direction
         end select
      end do
   end subroutine sort_potentials

   !> Takes the invariants' values from a state.
   pure subroutine start(self, system, state)
      class(correction_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(point_t) :: point
      type(target_t) :: first
      call read_state(self, state, point)
      call evaluate(self, system, point)
      first%energy = point%energy
      first%momentum = matmul(point%momentum, point%to_body)
      first%component = component_of(self, point)
      self%now = first
      self%before = first
      self%size = 0.0_wp
      self%largest = 0.0_wp
      self%unit = 1.0_wp
      call note_size(self, point)
      self%last_q = state%q
      self%last_p = state%p
      self%started = .true.
   end subroutine start

   !> Makes sure that the targets are those of the state from which a step starts: the last one corrected, another one
   !> on the same invariants, or a new one.
   pure subroutine follow(self, system, state)
      class(correction_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(point_t) :: point
      if (.not. self%started) then
         call self%start(system, state)
         return
      end if
      associate (q => state%q, p => state%p, a => self%last_q, b => self%last_p)
         if (.not. max(abs(q(1) - a(1)), abs(q(2) - a(2)), abs(q(3) - a(3)), abs(q(4) - a(4)), abs(p(1) - b(1)), &
                       abs(p(2) - b(2)), abs(p(3) - b(3)), abs(p(4) - b(4))) > 0.0_wp) return
      end associate
      call read_state(self, state, point)
      call evaluate(self, system, point)
      if (.not. is_on(self, point, self%now)) then
         if (is_on(self, point, self%before)) then
            self%now = self%before
         else
            call self%start(system, state)
         end if
      end if
   end subroutine follow

   !> True for a point whose invariants are those of a target, to round-off.
   pure logical function is_on(self, point, target)
      class(correction_t), intent(in) :: self
      type(point_t), intent(in) :: point
      type(target_t), intent(in) :: target
      real(wp) :: error
      is_on = abs(point%energy - target%energy) <= doubtful*max(self%size, point%size)
      select case (self%components)
      case (ALL_COMPONENTS)
         error = norm2(matmul(point%momentum, point%to_body) - target%momentum)
      case (NO_COMPONENT)
         error = 0.0_wp
      case default
         error = abs(component_of(self, point) - target%component)
      end select
      is_on = is_on .and. error <= doubtful*norm2(point%momentum)
   end function is_on

   !> l·n where that is conserved, else |l|.
   pure real(wp) function component_of(self, point)
      class(correction_t), intent(in) :: self
      type(point_t), intent(in) :: point
      if (self%components == ALONG_AXIS) then
         component_of = dot_product(point%momentum, matmul(point%to_body, self%axis))
      else
         component_of = norm2(point%momentum)
      end if
   end function component_of

   !> Corrects a state. Called after `follow` with the state from which the step started. Errors, with the state and
   !> the targets as they were: `NUTATE_OFF_BRANCH` for a step so long that it takes a move of more than 0.1 rad.
   pure subroutine correct(self, system, state, work, status)
      class(correction_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Work of all torques in the step, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      type(point_t) :: point
      type(target_t) :: next
      real(wp) :: scales(3)
      logical :: reached

      scales = [self%size, self%largest, self%unit]
      call read_state(self, state, point)
      call set_momentum(self, point)
      next = self%now
      if (abs(work) > 0.0_wp) call add_increment(next%energy, next%energy_carry, work)
      call set_energy(self, system, next, point, reached)
      if (.not. reached) then
         self%size = scales(1)
         self%largest = scales(2)
         self%unit = scales(3)
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long: the energy it lost cannot be restored nearby')
         return
      end if
      self%before = self%now
      self%now = next
      call write_state(self, point, state)
      self%last_q = state%q
      self%last_p = state%p
   end subroutine correct

   !> Moves a point to the target's energy.
   pure subroutine set_energy(self, system, target, point, reached)
      class(correction_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(target_t), intent(in) :: target
      type(point_t), intent(inout) :: point
      !> False if that is too far.
      logical, intent(out) :: reached
      real(wp) :: excess, square, slope(3), push, steepness
      integer :: i

      reached = .true.
      do i = 1, most_moves
         call evaluate(self, system, point)
         call note_size(self, point)
         excess = (point%energy - target%energy) - target%energy_carry
         if (abs(excess) <= dead_band*self%size) return
         call get_slope(self, point, slope, push, steepness)
         square = (self%unit*excess)**2
         if (abs(excess) <= doubtful*self%size) then
            if (.not. square < longest_doubtful*steepness) return
         else if (.not. square < longest*steepness) then
            exit
         end if
         call move(self, self%unit*excess/steepness, slope, push, point)
         if (square <= negligible*steepness) return
      end do
      reached = .false.
   end subroutine set_energy

   !> The direction in which the energy falls, in units of 1/`unit`.
   pure subroutine get_slope(self, point, slope, push, steepness)
      class(correction_t), intent(in) :: self
      type(point_t), intent(in) :: point
      !> L̇; shape (3).
      real(wp), intent(out) :: slope(3)
      !> S² times the unit and a factor of dimension 1/energy: ΔL = -c push Ω⊥, s² N m.
      real(wp), intent(out) :: push
      !> |L̇|² + S²|Ω⊥|².
      real(wp), intent(out) :: steepness
      real(wp) :: square, kinetic, along
      slope = self%unit*point%rate
      steepness = slope(1)*slope(1) + slope(2)*slope(2) + slope(3)*slope(3)
      push = 0.0_wp
      if (.not. self%pushes) return
      associate (w => point%omega)
         square = w(1)*w(1) + w(2)*w(2) + w(3)*w(3)
         if (square <= tiny(1.0_wp)/eps) return
         kinetic = self%unit*point%twice_kinetic
         push = kinetic*(point%twice_kinetic/square)
         along = 0.0_wp
         if (self%components == ALONG_AXIS) along = dot_product(w, matmul(point%to_body, self%axis))**2
         steepness = steepness + kinetic*((kinetic/square)*max(square - along, 0.0_wp))
      end associate
   end subroutine get_slope

   !> Turns the attitude by δ = c·slope at fixed l, by Cayley's map, and changes the momentum by ΔL = -c·push·Ω⊥.
   pure subroutine move(self, c, slope, push, point)
      class(correction_t), intent(in) :: self
      real(wp), intent(in) :: c, slope(3), push
      type(point_t), intent(inout) :: point
      real(wp) :: b(3), gamma(3), change(3), u(3), scalar, factor
      b = (0.5_wp*c)*slope
      if (self%pushes) then
         change = point%omega
         if (self%components == ALONG_AXIS) then
            gamma = matmul(point%to_body, self%axis)
            change = change - dot_product(change, gamma)*gamma
         end if
         point%momentum = point%momentum - (c*push)*change
      end if
      factor = b(1)*b(1) + b(2)*b(2) + b(3)*b(3)
      ! R(c)ᵀL = L + 2/(1+|b|²) (L×b + (L×b)×b)
      scalar = 2/(1 + factor)
      associate (l => point%momentum)
         u(1) = l(2)*b(3) - l(3)*b(2)
         u(2) = l(3)*b(1) - l(1)*b(3)
         u(3) = l(1)*b(2) - l(2)*b(1)
         change(1) = u(1) + u(2)*b(3) - u(3)*b(2)
         change(2) = u(2) + u(3)*b(1) - u(1)*b(3)
         change(3) = u(3) + u(1)*b(2) - u(2)*b(1)
      end associate
      point%momentum = point%momentum + scalar*change
      if (.not. self%attitude) return
      scalar = 1/sqrt(1 + factor)
      b = scalar*b
      associate (q => point%q)
         point%q = [scalar*q(1) - q(2)*b(1) - q(3)*b(2) - q(4)*b(3), &
                    scalar*q(2) + q(1)*b(1) + q(3)*b(3) - q(4)*b(2), &
                    scalar*q(3) + q(1)*b(2) + q(4)*b(1) - q(2)*b(3), &
                    scalar*q(4) + q(1)*b(3) + q(2)*b(2) - q(3)*b(1)]
      end associate
      call set_rows(point)
      if (self%components == ALL_COMPONENTS) call set_momentum(self, point)
   end subroutine move

   !> q normalised, L, and Rᵀ.
   pure subroutine read_state(self, state, point)
      class(correction_t), intent(in) :: self
      type(state_t), intent(in) :: state
      type(point_t), intent(out) :: point
      real(wp) :: square, half
      associate (q => state%q, p => state%p)
         square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
         half = 0.5_wp/square
         point%momentum(1) = half*(q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3))
         point%momentum(2) = half*(q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4))
         point%momentum(3) = half*(q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2))
         if (abs(square - 1) <= nearly_unit) then
            point%q = (1.5_wp - 0.5_wp*square)*q
         else
            point%q = (1/sqrt(square))*q
         end if
      end associate
      call set_rows(point)
   end subroutine read_state

   !> Rᵀ of a unit quaternion.
   pure subroutine set_rows(point)
      type(point_t), intent(inout) :: point
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

   !> Gives the conserved components of the momentum their stored values.
   pure subroutine set_momentum(self, point)
      class(correction_t), intent(in) :: self
      type(point_t), intent(inout) :: point
      real(wp) :: gamma(3), length
      select case (self%components)
      case (ALL_COMPONENTS)
         associate (l => self%now%momentum)
            point%momentum = point%to_body(:, 1)*l(1) + point%to_body(:, 2)*l(2) + point%to_body(:, 3)*l(3)
         end associate
      case (ALONG_AXIS)
         associate (n => self%axis, l => point%momentum)
            gamma = point%to_body(:, 1)*n(1) + point%to_body(:, 2)*n(2) + point%to_body(:, 3)*n(3)
            point%momentum = l + (self%now%component - (l(1)*gamma(1) + l(2)*gamma(2) + l(3)*gamma(3)))*gamma
         end associate
      case (ONLY_LENGTH)
         length = norm2(point%momentum)
         if (length > 0.0_wp) point%momentum = (self%now%component/length)*point%momentum
      case default
         return
      end select
   end subroutine set_momentum

   !> Ω, L̇, T, H and the size of its terms.
   pure subroutine evaluate(self, system, point)
      class(correction_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(point_t), intent(inout) :: point
      real(wp) :: x(3)
      associate (l => point%momentum, w => point%omega, inverse => self%inverse_inertia)
         x = l - self%rotor
         if (self%diagonal) then
            w(1) = inverse(1, 1)*x(1)
            w(2) = inverse(2, 2)*x(2)
            w(3) = inverse(3, 3)*x(3)
         else
            w = inverse(:, 1)*x(1) + inverse(:, 2)*x(2) + inverse(:, 3)*x(3)
         end if
         point%twice_kinetic = x(1)*w(1) + x(2)*w(2) + x(3)*w(3)
         point%energy = 0.5_wp*point%twice_kinetic
         point%size = point%energy
         if (self%has_rotor) point%size = point%size + self%rotor_length*sqrt(w(1)*w(1) + w(2)*w(2) + w(3)*w(3))
         point%rate(1) = l(2)*w(3) - l(3)*w(2)
         point%rate(2) = l(3)*w(1) - l(1)*w(3)
         point%rate(3) = l(1)*w(2) - l(2)*w(1)
      end associate
      if (.not. self%attitude) then
         if (self%pushes) point%rate = 0.0_wp
         return
      end if
      if (size(self%moment, 2) > 0) call add_linear(self, point)
      if (size(self%others) > 0) call add_others(self, system%effects, point)
   end subroutine evaluate

   !> Adds U = -m·γ and m×γ of the linear potentials.
   pure subroutine add_linear(self, point)
      class(correction_t), intent(in) :: self
      type(point_t), intent(inout) :: point
      real(wp) :: gamma(3), energy
      integer :: i
      do i = 1, size(self%moment, 2)
         associate (m => self%moment(:, i), n => self%direction(:, i))
            gamma = point%to_body(:, 1)*n(1) + point%to_body(:, 2)*n(2) + point%to_body(:, 3)*n(3)
            energy = -(m(1)*gamma(1) + m(2)*gamma(2) + m(3)*gamma(3))
            point%energy = point%energy + energy
            point%size = point%size + abs(energy)
            point%rate(1) = point%rate(1) + (m(2)*gamma(3) - m(3)*gamma(2))
            point%rate(2) = point%rate(2) + (m(3)*gamma(1) - m(1)*gamma(3))
            point%rate(3) = point%rate(3) + (m(1)*gamma(2) - m(2)*gamma(1))
         end associate
      end do
   end subroutine add_linear

   !> Adds U and γ×∇U of the other potentials.
   pure subroutine add_others(self, effects, point)
      class(correction_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(point_t), intent(inout) :: point
      real(wp) :: gamma(3), slope(3), energy
      integer :: i
      do i = 1, size(self%others)
         associate (potential => effects%potentials(self%others(i))%item)
            gamma = point%to_body(:, 1)*potential%direction(1) + point%to_body(:, 2)*potential%direction(2) &
                    + point%to_body(:, 3)*potential%direction(3)
            energy = potential%energy(gamma)
            slope = potential%gradient(gamma)
         end associate
         point%energy = point%energy + energy
         point%size = point%size + abs(energy)
         point%rate(1) = point%rate(1) + (gamma(2)*slope(3) - gamma(3)*slope(2))
         point%rate(2) = point%rate(2) + (gamma(3)*slope(1) - gamma(1)*slope(3))
         point%rate(3) = point%rate(3) + (gamma(1)*slope(2) - gamma(2)*slope(1))
      end do
   end subroutine add_others

   !> Keeps the largest energies seen, and a unit in which no square overflows.
   pure subroutine note_size(self, point)
      class(correction_t), intent(inout) :: self
      type(point_t), intent(in) :: point
      real(wp) :: largest
      self%size = max(self%size, point%size)
      largest = max(point%size, abs(point%rate(1)), abs(point%rate(2)), abs(point%rate(3)))
      if (largest <= self%largest) return
      self%largest = largest
      self%unit = scale(1.0_wp, -max(exponent(largest), -1000))
   end subroutine note_size

   !> q, and p = 2 q∘[0, L].
   pure subroutine write_state(self, point, state)
      class(correction_t), intent(in) :: self
      type(point_t), intent(in) :: point
      type(state_t), intent(inout) :: state
      real(wp) :: double(3)
      if (self%attitude) state%q = point%q
      double = 2*point%momentum
      associate (q => state%q)
         state%p(1) = -(q(2)*double(1) + q(3)*double(2) + q(4)*double(3))
         state%p(2) = q(1)*double(1) + q(3)*double(3) - q(4)*double(2)
         state%p(3) = q(1)*double(2) + q(4)*double(1) - q(2)*double(3)
         state%p(4) = q(1)*double(3) + q(2)*double(2) - q(3)*double(1)
      end associate
      state%q_carry = 0.0_wp
      state%p_carry = 0.0_wp
   end subroutine write_state

end module nutate_conserve
