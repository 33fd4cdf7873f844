!> The projection onto the invariants: moves the state after a step of any method back onto the invariants of the run.
!>
!> In this order: `q` is normalised; the conserved components of the space momentum `l` take their stored values; then
!> the excess `ΔH = H - (H₀ + work)` is removed by the smallest move along which it falls. The moves that leave the
!> conserved components of l alone are
!>
!> * a rotation of the attitude by the body rotation vector δ at fixed l: `dH = -δ·L̇`, `L̇ = L×Ω + τ`, τ the torque of
!>   the potentials;
!> * where not all of l is conserved, a change ΔL of the momentum: `dH = Ω⊥·ΔL`, Ω⊥ = Ω, or Ω without its component
!>   along γ = Rᵀn where l·n is conserved.
!> * of wheels with friction, or driven by what the body does, a change Δh of their momenta at fixed L: `dH = Σ ω Δh`,
!>   ω their speeds.
!>
!> The smallest in `|δ|² + |ΔL|²/S² + |Δh|²/Sw²`, `S = 2T/|Ω|`, `Sw² = (Σ Jw ω²)²/Σω²`, is `δ = cL̇`, `ΔL = -cS²Ω⊥`,
!> `Δh = -cSw²ω`, `c = ΔH/(|L̇|² + S²|Ω⊥|² + Sw²Σω²)`; Newton's iteration repeats it. A pendulum has L̇ = 0 at the
!> bottom of each swing, where only its momentum can make up for an error of the energy.
!>
!> **Rotating space axes**, at ω. H - ω·l replaces H, Ω - Rᵀω replaces Ω in ΔL; only the component of l along ω can be
!> conserved. The l of a free body rotates by -ω in these axes: it is rotated, exactly, not restored.
!>
!> **Limits.** H is stationary at relative equilibria: there a ΔH of round-off would require a long move. Excesses up to
!> `round_off` of the energy's scale are left alone, those up to `doubtful` are removed by short moves only. Above it, a
!> move of more than 0.1 rad means that the step was too long, unless the excess is within the possible round-off of the
!> balance: damping has then brought the body so near to rest that no state nearby has the energy of the balance. The
!> state is then left alone, its energy becomes that of the balance, and the difference is added to the works.
!>
!> **Targets.** H₀ + work and l are those of the first state, not of the last, so that nothing accumulates over a long
!> run. They are stored in the balance of the state, together with the attitude and momentum to which they belong: a
!> rejected step is repeated with those of its start. A state that was set from outside starts with its own values.
module nutate_invariant_projection
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_disturbance, only: disturb_state
   use nutate_effect_list, only: effect_list_t
   use nutate_energy_balance, only: energy_scale_t, energy_sum_t
   use nutate_projection_point, only: projection_plan_t, evaluate, get_slope, projection_point_t, read_point, &
      set_gamma, set_rows, slope_t, set_attitude, set_momentum, times, write_state
   use nutate_invariants, only: ALL_COMPONENTS, NO_COMPONENT
   use nutate_kinds, only: wp, eps
   use nutate_momentum_target, only: momentum_target_t
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_OFF_BRANCH
   use nutate_system, only: system_t
   use nutate_error_weighting, only: balance_momentum, divide_excess, step_error_t
   implicit none
   private

   public :: invariant_projection_t
   public :: round_off, doubtful, longest, longest_doubtful, negligible, most_moves

   !> Parts of the energy's scale. Evaluating H rounds some eight times, by ½ε each: an excess below the first is zero.
   !> Two evaluations, with l restored in between, differ by several times that: up to the second an excess may be
   !> round-off, and up to twice that if both ends of a step have it. If damping has brought a body nearly to rest,
   !> round-off of the balance is below the fourth.
   real(wp), parameter :: round_off = 4*eps, doubtful = 16*eps, alike = 32*eps, in_balance = 64*eps
   !> Squares of moves, rad². The longest of all, 0.1 rad: a step with such an error does not follow the motion. The
   !> longest for a doubtful excess, 64 ε rad: a state that would need more is next to an equilibrium, where H is
   !> stationary and does not determine the attitude; a longer move would turn a round-off of ε into an error of √ε. The
   !> longest after which the rest of the excess, which goes as the square of the move, is below ε/16.
   real(wp), parameter :: longest = 1e-2_wp, longest_doubtful = (64*eps)**2, negligible = 1e-17_wp
   !> Round-off ε that noise of 1 stands for, inverse: noise of 4ε is what evaluating H makes.
   real(wp), parameter :: noise_unit = 0.25_wp/eps
   !> Largest number of moves: at a double root of H each reduces the excess by a factor of four, 2e14 in all.
   integer, parameter :: most_moves = 24

   !> The projection of the states of one system.
   type :: invariant_projection_t
      private
      type(projection_plan_t) :: plan
      !> Scale of the energies of the present state, and the conserved components of l.
      type(energy_scale_t) :: scale
      type(momentum_target_t) :: target
      !> Noise that trial runs add to every state before it is projected, and to its energy, as part of `size`.
      type(noise_t) :: noise
      real(wp) :: kick = 0.0_wp
      !> Move of the last state due to round-off of the energy, rad: up to √ε if H is nearly stationary.
      real(wp), public :: moved_by_round_off = 0.0_wp
   contains
      !> Finds the invariants that a system has.
      procedure :: prepare
      !> Starts the balance of a state from its own invariants.
      procedure :: start
      !> Adds the noise of a trial run.
      procedure :: disturb
      !> Adds the noise to a state that is not projected.
      procedure :: shake_state
      !> Gives the state from which a step starts its balance.
      procedure :: follow
      !> Projects the state at the end of a step, or inside it.
      procedure :: project
   end type invariant_projection_t

contains

   !> Finds the invariants that a system has. To be called before the first step and after every change of the system.
   pure subroutine prepare(self, system, attitude, compensated)
      class(invariant_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> True if the attitude is integrated; otherwise the states have none, and only |l| is conserved.
      logical, intent(in) :: attitude
      !> True if states are compensated sums, and stay so if possible.
      logical, intent(in) :: compensated
      call self%plan%prepare(system, attitude)
      self%plan%compensated = compensated .and. attitude .and. self%plan%pushes
      self%noise = noise_t()
      self%kick = 0.0_wp
      self%moved_by_round_off = 0.0_wp
   end subroutine prepare

   !> Starts the balance of a state from its own invariants.
   pure subroutine start(self, system, state)
      class(invariant_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      type(projection_point_t) :: point
      call read_point(self%plan, system%effects, state, point)
      call self%target%set(self%plan%components, point)
      self%scale = energy_scale_t()
      call note_size(self, point)
      state%balance%open = .true.
      state%balance%projected = .false.
      state%balance%count = 0
      state%balance%interval = 1
      state%balance%momentum = self%target%momentum
      state%balance%momentum_time = state%t
      state%balance%component = self%target%component
      call settle(self, energy_sum_t(point%energy, 0.0_wp), state)
   end subroutine start

   !> Makes the balance belong to a state, with an energy.
   pure subroutine settle(self, energy, state)
      class(invariant_projection_t), intent(in) :: self
      type(energy_sum_t), intent(in) :: energy
      type(state_t), intent(inout) :: state
      state%balance%energy = energy
      state%balance%scale = self%scale
      if (self%plan%has_wheels) state%balance%wheels(:self%plan%wheels%n) = &
         state%wheel_momentum(:self%plan%wheels%n)
      call state%balance_here()
   end subroutine settle

   !> Adds the noise of a trial run: from now on states are those of a machine with this round-off in every step, and so
   !> are the limits of the projection.
   pure subroutine disturb(self, noise)
      class(invariant_projection_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      self%noise = noise
   end subroutine disturb

   !> Adds noise η to a point: η/2 to each component of q, η|L| to each of L, η to its energy.
   pure subroutine shake(self, point)
      class(invariant_projection_t), intent(inout) :: self
      type(projection_point_t), intent(inout) :: point
      real(wp) :: q(4), momentum(3)
      call self%noise%vector(q)
      call self%noise%vector(momentum)
      call self%noise%next(self%kick)
      if (self%plan%attitude) then
         q = point%q + 0.5_wp*q
         point%q = (1/norm2(q))*q
         call set_rows(point)
      end if
      if (self%plan%components /= ALL_COMPONENTS) point%momentum = point%momentum + norm2(point%momentum)*momentum
   end subroutine shake

   !> Adds noise, if there is one, to a state that is not projected.
   pure subroutine shake_state(self, state)
      class(invariant_projection_t), intent(inout) :: self
      type(state_t), intent(inout) :: state
      if (self%noise%amplitude > 0.0_wp .and. self%plan%attitude) call disturb_state(self%noise, state)
   end subroutine shake_state

   !> Gives the state from which a step starts its balance: one that belongs to another state starts anew.
   pure subroutine follow(self, system, state)
      class(invariant_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      logical :: known
      known = state%is_balanced()
      if (known .and. self%plan%has_wheels) known = sum(abs( &
         state%wheel_momentum(:self%plan%wheels%n) - state%balance%wheels(:self%plan%wheels%n))) <= 0.0_wp
      if (known) return
      if (.not. ieee_is_finite(sum(state%q) + sum(state%p))) return
      call self%start(system, state)
   end subroutine follow

   !> Projects a state, which has the balance of the one from which the step started. Errors, with the state unchanged:
   !> `NUTATE_OFF_BRANCH` for a step so long that it needs a move of more than 0.1 rad.
   pure subroutine project(self, system, state, work, status, error, given)
      class(invariant_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Work of all torques in the step, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Estimated error of the step; zero, or absent, if works err no more than the state. Only with `given`.
      type(step_error_t), intent(in), optional :: error
      !> Amount to add to the work, J; unchanged if there is none.
      real(wp), intent(inout), optional :: given
      type(projection_point_t) :: point
      type(energy_sum_t) :: energy, booked
      type(step_error_t) :: known
      real(wp) :: share
      logical :: reached, undetermined
      call set_targets(self, state)
      if (self%plan%has_wheels) call self%plan%set_wheels(system%effects, state)
      call self%plan%set_time(system%effects, state%t)
      call set_point(self, state, point)
      energy = state%balance%energy
      if (abs(work) > 0.0_wp) call add_increment(energy%energy, energy%compensation, work)
      booked = energy
      if (present(error)) then
         known = error
         call balance(self, known, point)
         share = 0.0_wp
         call set_energy(self, system%effects, energy, point, reached, undetermined, known, share)
         if (reached) given = share
      else
         call set_energy(self, system%effects, energy, point, reached, undetermined)
      end if
      if (undetermined) then
         call set_point(self, state, point)
         call evaluate(self%plan, system%effects, point)
         energy = energy_sum_t(point%energy, 0.0_wp)
         if (present(given)) given = (energy%energy - booked%energy) - booked%compensation
      end if
      if (reached .or. undetermined) then
         call write_state(self%plan, point, state)
         ! Errors of works can lead a state far off the balance, with an energy that the motion never has.
         if (present(given)) self%scale%size = max(state%balance%scale%size, point%size)
         call settle(self, energy, state)
      else
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long: its energy error is too large')
      end if
   end subroutine project

   !> Sets scale and targets to those of the balance of a state.
   pure subroutine set_targets(self, state)
      class(invariant_projection_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      self%scale = state%balance%scale
      self%target%momentum = state%balance%momentum
      self%target%component = state%balance%component
      if (self%plan%turns_momentum) call self%target%turn(self%plan%frame_rate, state%t - state%balance%momentum_time)
   end subroutine set_targets

   !> Sets the point of a state, with the conserved components of its momentum at their stored values.
   pure subroutine set_point(self, state, point)
      class(invariant_projection_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      type(projection_point_t), intent(out) :: point
      call set_attitude(state, point)
      if (self%plan%components /= ALL_COMPONENTS) call set_momentum(state, point)
      if (self%plan%compensated) point%first_q = point%q
      if (self%plan%compensated) point%first_momentum = point%momentum
      if (self%noise%amplitude > 0.0_wp) call shake(self, point)
      call set_gamma(self%plan, point)
      call self%target%put(self%plan%components, point)
   end subroutine set_point

   !> Moves a point to the energy of a balance, or both to an energy between theirs.
   pure subroutine set_energy(self, effects, target, point, reached, undetermined, error, given)
      class(invariant_projection_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(energy_sum_t), intent(inout) :: target
      type(projection_point_t), intent(inout) :: point
      !> `reached` is false if that energy is too far away; `undetermined` is true if it is, although the excess is
      !> small.
      logical, intent(out) :: reached, undetermined
      !> Estimated error of the step; amount by which the balance was moved, J: unchanged if it was not moved.
      type(step_error_t), intent(in), optional :: error
      real(wp), intent(inout), optional :: given
      type(slope_t) :: slope
      real(wp) :: excess, first, square, unit, push
      integer :: i
      reached = .true.
      undetermined = .false.
      unit = max(1.0_wp, self%noise%amplitude*noise_unit)
      self%moved_by_round_off = 0.0_wp
      push = 1.0_wp
      do i = 1, most_moves
         call evaluate(self%plan, effects, point)
         call note_size(self, point)
         excess = point%energy - target%energy + self%kick*self%scale%size
         if (i == 1) first = abs(excess)
         if (abs(excess) <= round_off*self%scale%size) return
         call get_slope(self%plan, self%scale%to_order_one, point, slope)
         excess = self%scale%to_order_one*excess
         if (i == 1 .and. present(error)) then
            call divide_excess(self%plan, error, point, slope, alike*unit, self%scale%size, self%scale%to_order_one, &
                               excess, given, push)
            if (abs(given) > 0.0_wp) call add_increment(target%energy, target%compensation, given)
         end if
         square = excess*excess
         if (.not. square < longest_doubtful*unit*unit*slope%steepness) then
            if (abs(excess) <= doubtful*unit*(self%scale%to_order_one*self%scale%size)) return
            if (.not. square < longest*slope%steepness) exit
            if (i == 1 .and. abs(excess) <= alike*unit*(self%scale%to_order_one*self%scale%size)) &
               self%moved_by_round_off = abs(excess)/sqrt(slope%steepness)
         end if
         if (abs(push - 1) > 0.0_wp) call slope%weigh_push(push)
         excess = excess/slope%steepness
         if (square <= negligible*slope%steepness) then
            call move_little(self, excess, slope, point)
            if (self%plan%moves_wheels) call self%plan%move_wheels(effects, excess, slope)
            return
         end if
         if (self%plan%moves_wheels) call self%plan%move_wheels(effects, excess, slope)
         call move(self, excess, slope, point)
      end do
      reached = .false.
      undetermined = first <= in_balance*unit*self%scale%size
   end subroutine set_energy

   !> Moves a point towards the balance of its momentum, if not all of it is conserved.
   pure subroutine balance(self, error, point)
      class(invariant_projection_t), intent(in) :: self
      type(step_error_t), intent(inout) :: error
      type(projection_point_t), intent(inout) :: point
      if (.not. self%plan%pushes) return
      call balance_momentum(error, alike*max(1.0_wp, self%noise%amplitude*noise_unit), point%momentum)
      if (self%plan%components /= NO_COMPONENT) call self%target%put(self%plan%components, point)
   end subroutine balance

   !> Moves a point by c down a slope: the attitude by δ = cL̇ at fixed l, by the Cayley map, and L by ΔL =
   !> -c·inertia·Ω⊥.
   pure subroutine move(self, c, slope, point)
      class(invariant_projection_t), intent(in) :: self
      real(wp), intent(in) :: c
      type(slope_t), intent(in) :: slope
      type(projection_point_t), intent(inout) :: point
      real(wp) :: b(3), factor
      b = (0.5_wp*c)*slope%rotation
      factor = 1 + (b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
      if (self%plan%pushes) point%momentum = point%momentum - (c*slope%inertia)*slope%omega
      if (self%plan%components /= ALL_COMPONENTS) call rotate_back(b, factor, point%momentum)
      if (.not. self%plan%attitude) return
      point%q = (1/sqrt(factor))*(point%q + times(point%q, b))
      call set_rows(point)
      call set_gamma(self%plan, point)
      if (self%plan%components == ALL_COMPONENTS) call self%target%put(self%plan%components, point)
   end subroutine move

   !> Computes R(c)ᵀL = L + u + u×b, u = 2 L×b/(1 + |b|²), with c = (1 + b)/√(1 + |b|²).
   pure subroutine rotate_back(b, factor, momentum)
      !> b, and 1 + |b|²; shape (3).
      real(wp), intent(in) :: b(3), factor
      !> Shape (3).
      real(wp), intent(inout) :: momentum(3)
      real(wp) :: u(3)
      u = (2/factor)*across(momentum, b)
      momentum = momentum + (u + across(u, b))
   end subroutine rotate_back

   !> Performs the last move, so short that its square is round-off; only q and L are needed afterwards.
   pure subroutine move_little(self, c, slope, point)
      class(invariant_projection_t), intent(in) :: self
      real(wp), intent(in) :: c
      type(slope_t), intent(in) :: slope
      type(projection_point_t), intent(inout) :: point
      if (self%plan%attitude) point%q = point%q + times(point%q, (0.5_wp*c)*slope%rotation)
      if (self%plan%pushes) point%momentum = point%momentum - (c*slope%inertia)*slope%omega
      if (self%plan%components == ALL_COMPONENTS) then
         call set_rows(point)
         call self%target%put(self%plan%components, point)
      else
         point%momentum = point%momentum + across(point%momentum, c*slope%rotation)
      end if
   end subroutine move_little

   !> Returns a×b; in this file so that it is inlined into its callers.
   pure function across(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function across

   !> Stores the largest energies so far, and the power of two with which no square overflows.
   pure subroutine note_size(self, point)
      class(invariant_projection_t), intent(inout) :: self
      type(projection_point_t), intent(in) :: point
      real(wp) :: largest
      self%scale%size = max(self%scale%size, point%size)
      largest = max(point%size, abs(point%rate(1)), abs(point%rate(2)), abs(point%rate(3)))
      if (largest <= self%scale%largest) return
      self%scale%largest = largest
      self%scale%to_order_one = scale(1.0_wp, -max(exponent(largest), -1000))
   end subroutine note_size

end module nutate_invariant_projection
