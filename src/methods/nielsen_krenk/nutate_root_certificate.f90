!> Proof that a root of the step's equations is the true one, the one that continues the motion from Δt = 0.
!>
!> A stage of length s, in the Cayley vector b = ¼s Ω̄, with β = |b|² and b0 = ¼s J⁻¹(L0 - h): t from 0 to 1 is the part
!> of the stage that has passed, and
!>
!>     Ψ(b,t) = (1-β)(b - t b0) + 2J⁻¹(b×(Jb + t s h/4)) - t²(s²/8) J⁻¹τ̂ + t(s/2) J⁻¹τ̂_D = 0
!>
!> is the equation of `nutate_reduced_equations` times J⁻¹: τ̂ of the torque at mid step, τ̂_D of torques that resist
!> the rotation. Written as b = Φ(b), it is a contraction of the ball |b| ≤ ρ into itself if
!>
!>     E(ρ) = (κρ² + gρ + F)/(1-ρ²),   |b0| + E(ρ) ≤ ρ,   θ(ρ) = (2κρ + g + P)/(1-ρ²) + 2ρE/(1-ρ²) < 1,
!>
!> F and P the bounds of what the effects do and of its derivative (`nutate_effect_bounds`), κ that of the gyroscopic
!> term and g that of rotors. All of them grow with t: so for each part of the stage there is one root in the ball, and
!> the branch that starts at b = 0 never leaves it. That root is the true one. If E admits a smaller ball than θ, the
!> root is the only one in the larger ball too.
!>
!> If the space axes rotate, by δ = ¼s|ω|, 1-β+t²d replaces 1-β (d = δ²), and the body rotates by r = b - tδ̄ against
!> them: τ̂ = (1+|r|²)τ̄ - 2r(b·τ̄) at the attitude of r, |r| ≤ ρ + δ. In that larger ball the effects bound their part
!> of it, (1+|r|²)τ̄ - 2r(r·τ̄), and by it τ̄ and its derivative, of which 2r(tδ̄·τ̄) is made; a change of b changes r
!> by at most 1/(1-2δ) times as much.
!>
!> Inner spheres exert the torque R(c½)ᵀD - KΩ̄ (`nutate_sphere_steps`). Its first part enters as (1-β)D - 2b×D, at most
!> (1+β)|D|, the second as t(s/2)(1-β)KJ⁻¹b: with M = 1 + t(s/2)KJ⁻¹, ‖M⁻¹‖ ≤ 1 for s > 0, b = M⁻¹Φ(b) holds without
!> it. tK and t|D| grow with t.
!>
!> An inertia J(t) = Jᵣ(1+E) that varies in the stage, ‖E‖ ≤ ε, multiplies bounds for Jᵣ by μ = 1/(1-ε), and |b0| by
!> (1+ε)μ; 2ε is added to κ.
module nutate_root_certificate
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_effect_bounds, only: add_bounds, effect_bounds_t, linear_map_t, map_of, spectral_norm, times_cross
   use nutate_kinds, only: wp
   use nutate_limits, only: most_spheres
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: vector_length
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: inertia_at, system_t
   use nutate_varying_inertia, only: inertia_deviation
   implicit none
   private

   public :: root_certificate_t, all_bounds_t

   !> Values of ρ: the finer the grid, the nearer to the largest b0 that can be certified; beyond the last, no body has
   !> θ < 1. The small ones are for the first part of a step of needles, whose κ is large.
   real(wp), parameter :: radii(23) = [ &
                          1e-6_wp, 1e-5_wp, 1e-4_wp, 1e-3_wp, 2.5e-3_wp, 5e-3_wp, 0.01_wp, 0.02_wp, 0.04_wp, 0.06_wp, &
                          0.08_wp, 0.1_wp, 0.125_wp, 0.15_wp, 0.175_wp, 0.2_wp, 0.225_wp, 0.25_wp, 0.275_wp, 0.3_wp, &
                          0.325_wp, 0.35_wp, 0.37_wp]
   !> Largest distance between γ at two attitudes, over |n|.
   real(wp), parameter :: anywhere = 2.0_wp
   !> Bounds beyond this prove nothing, and their products would overflow.
   real(wp), parameter :: greatest_bound = 1e150_wp
   !> Norm of the effects' part of the Jacobian above which they dominate the step: its branch would take more Newton-
   !> Kantorovich tubes than are worth their time.
   real(wp), parameter :: dominating = 300.0_wp
   !> Factor from one part of a stage to the next shorter one, in the search for one that can be certified at once.
   real(wp), parameter :: shorter = 0.8_wp
   integer, parameter :: most_parts = 200
   !> Largest δ of rotating space axes with which effects are bounded in the balls of b and r.
   real(wp), parameter :: largest_frame_turn = 0.25_wp
   !> Largest ε for which the bounds of one Jᵣ are used, and least ε from which nothing is certified.
   real(wp), parameter :: usual_deviation = 0.02_wp, largest_deviation = 0.5_wp
   !> The bound of the rate of a sphere is above the rate by the first factor at least, and below it by the second at
   !> most.
   real(wp), parameter :: spare = 1.1_wp, lowest = 0.8_wp

   !> Bounds of all effects in a ball that decide whether it can be certified.
   type, private :: ball_bounds_t
      !> Bounds of J⁻¹τ̂ and its derivative by b, and separately those of the part that resists the rotation.
      real(wp) :: force = 0.0_wp, slope = 0.0_wp, drag = 0.0_wp, drag_slope = 0.0_wp
   end type ball_bounds_t

   !> Bounds of all effects for each radius, available for the `known` smallest ones.
   type :: all_bounds_t
      private
      integer :: known = 0
      type(ball_bounds_t) :: balls(size(radii)) = ball_bounds_t()
   end type all_bounds_t

   !> Bounds by which the steps of a system can be certified.
   type :: root_certificate_t
      !> Each effect that acts has bounds, and they do not dominate the step.
      logical :: followable = .false.
      !> Length of the stage, s, to which `near` belongs: a root with |b|² below is the true one.
      real(wp) :: length = 0.0_wp, near = 0.0_wp
      !> Times between which no torque starts or stops to act, s.
      real(wp) :: steady_from = -huge(1.0_wp), steady_to = huge(1.0_wp)
      !> κ, and ‖J⁻¹[h]×‖, 1/s.
      real(wp) :: gyration = 0.0_wp, rotor_rate = 0.0_wp
      !> The torques that act in the step; shape (number of torques).
      logical, allocatable :: acts(:)
      !> J⁻¹; the identity map, if the space axes rotate.
      type(linear_map_t), private :: inverse
      type(linear_map_t), allocatable, private :: identity
      !> |ω| of rotating space axes, rad/s.
      real(wp), private :: frame_rate = 0.0_wp
      !> Bounds of all effects for each radius at any attitude. Not allocated if there are neither effects nor rotating
      !> space axes.
      type(all_bounds_t), allocatable, private :: everywhere
      !> γ of each potential at the start of the stage that `holds_here` set last; shape (3, number of potentials).
      real(wp), allocatable, private :: gamma(:, :)
      !> Largest |b0| and largest |b| of a root that is the true one.
      real(wp), private :: reach = -1.0_wp, radius = 0.0_wp
      !> Number of inner spheres; c, N m s, I, kg m², and a bound of |h|/I + |ω|, rad/s; shape (most_spheres).
      integer, private :: n_spheres = 0
      real(wp), private :: friction(most_spheres) = 0.0_wp, inertia(most_spheres) = 1.0_wp, &
         pull(most_spheres) = 0.0_wp
      !> The inertia varies; Jᵣ, kg m²; shape (3,3); ε.
      logical, private :: varies = .false.
      real(wp), private :: reference(3, 3) = 0.0_wp, deviation = 0.0_wp
   contains
      !> Sets a system.
      procedure :: set_up
      !> Returns true if there are bounds that depend on the attitude at the start of a stage, for `holds_here`.
      procedure :: has_bounds
      !> Returns true if the root is certified to be the true one.
      procedure :: holds
      !> Sets the state at the start of a stage, and finds whether the root is then certified.
      procedure :: holds_here
      !> Finds the longest part of a stage whose root lies in a ball that contains no other.
      procedure :: first_part
      !> Computes bounds of all effects in a stage from the state set last.
      procedure :: bounds_of
      !> Adds the bounds of inner spheres in the rest of a stage.
      procedure :: add_spheres
   end type root_certificate_t

contains

   !> Sets a system: bounds at any attitude.
   pure subroutine set_up(self, system)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      associate (effects => system%effects, inverse => system%body%inverse_inertia)
         self%inverse = map_of(inverse, system%body%axes)
         self%n_spheres = effects%n_spheres
         self%pull = -1.0_wp
         self%varies = effects%varies
         self%reference = system%body%inertia
         self%deviation = merge(usual_deviation, 0.0_wp, effects%varies)
         self%frame_rate = vector_length(effects%frame_rate)
         if (allocated(self%identity)) deallocate (self%identity)
         if (self%frame_rate > 0.0_wp) &
            allocate (self%identity, source=map_of(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), system%body%axes))
         self%gyration = gyration_of(system%body%moments)
         self%rotor_rate = spectral_norm(times_cross(inverse, effects%rotor_momentum))
         if (allocated(self%acts)) deallocate (self%acts)
         allocate (self%acts(effects%n_torques), source=.true.)
         if (allocated(self%gamma)) deallocate (self%gamma)
         allocate (self%gamma(3, effects%n_potentials), source=0.0_wp)
         if (allocated(self%everywhere)) deallocate (self%everywhere)
         if (effects%n_potentials + effects%n_torques > 0 .or. self%frame_rate > 0.0_wp) &
            allocate (self%everywhere)
      end associate
      ! The torques that act are known only in a step.
      self%steady_from = huge(1.0_wp)
      self%steady_to = -huge(1.0_wp)
   end subroutine set_up

   !> Returns true if there are bounds that depend on the attitude at the start of a stage.
   pure logical function has_bounds(self)
      class(root_certificate_t), intent(in) :: self
      has_bounds = allocated(self%everywhere)
   end function has_bounds

   !> Returns true if the root is certified to be the true one for any attitude at the start of the stage.
   logical function holds(self, system, state, dt, window_time, start, root)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the stage; used for inner spheres and an inertia that varies.
      type(state_t), intent(in) :: state
      !> Length of the stage, and time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      !> |b0| and |b|.
      real(wp), intent(in) :: start, root
      real(wp) :: near
      if (.not. (window_time > self%steady_from .and. window_time < self%steady_to)) &
         call store_windows(self, system, window_time)
      if (self%n_spheres > 0) call store_spheres(self, system, state)
      if (self%varies) call store_inertia(self, system, state%t, dt)
      if (dt /= self%length) then
         if (self%frame_rate > 0.0_wp) call bound_everywhere(self, system, dt)
         self%length = dt
         call find_ball(self, dt, self%reach, self%radius, near, self%everywhere)
         self%near = max(near, 0.0_wp)**2
      end if
      holds = is_within(self, start, self%reach) .and. root <= self%radius
   end function holds

   !> Returns true if |b0| of all parts of the stage is within reach.
   elemental logical function is_within(self, start, reach)
      class(root_certificate_t), intent(in) :: self
      !> |b0| of the stage, and the reach for Jᵣ.
      real(wp), intent(in) :: start, reach
      is_within = start <= reach
      if (self%varies) is_within = start*((1 + self%deviation)/(1 - self%deviation)) <= reach
   end function is_within

   !> Stores the friction of the spheres and bounds of their rates. Bounds that change end those of a length.
   pure subroutine store_spheres(self, system, state)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: rate
      integer :: i, k
      do i = 1, self%n_spheres
         k = system%effects%n_reaction_wheels + 3*i
         associate (sphere => system%effects%wheels(k))
            rate = vector_length(state%wheel_momentum(k - 2:k))/sphere%inertia + self%frame_rate
            if (rate <= self%pull(i) .and. rate >= lowest*self%pull(i) .and. &
                .not. abs(sphere%friction - self%friction(i)) > 0.0_wp) cycle
            self%friction(i) = sphere%friction
            self%inertia(i) = sphere%inertia
            self%pull(i) = spare*rate
            self%length = 0.0_wp
         end associate
      end do
   end subroutine store_spheres

   !> Stores another Jᵣ if the inertia of a stage is too far from the last one.
   pure subroutine store_inertia(self, system, t, dt)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Start of the stage, and its length, s.
      real(wp), intent(in) :: t, dt
      type(body_t) :: body
      type(status_t) :: status
      real(wp) :: deviation
      deviation = self%inverse%norm*inertia_deviation(system, t, 0.5_wp*dt, self%reference)
      if (deviation <= usual_deviation) return
      self%reference = inertia_at(system, t + 0.25_wp*dt)
      call make_body(self%reference, body, status, check_triangle=.false.)
      self%deviation = 1.0_wp
      if (status%ok()) then
         self%inverse = map_of(body%inverse_inertia, body%axes)
         self%gyration = gyration_of(body%moments)
         self%rotor_rate = spectral_norm(times_cross(body%inverse_inertia, system%effects%rotor_momentum))
         self%deviation = max(usual_deviation, &
                              self%inverse%norm*inertia_deviation(system, t, 0.5_wp*dt, self%reference))
      end if
      self%deviation = min(self%deviation, largest_deviation)
      call bound_everywhere(self, system, dt)
   end subroutine store_inertia

   !> Sets the state at the start of a stage. `certified` is true if the bounds that belong to its attitude certify the
   !> root.
   pure subroutine holds_here(self, system, state, dt, start, root, certified, here)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the stage.
      type(state_t), intent(in) :: state
      !> Length of the stage, s.
      real(wp), intent(in) :: dt
      !> |b0| and |b|; the second huge if no root is known.
      real(wp), intent(in) :: start, root
      logical, intent(out) :: certified
      !> Bounds of all effects for each radius, in a stage from that state; present if there are any.
      type(all_bounds_t), intent(inout), optional :: here
      real(wp) :: reach, radius, near
      integer :: i
      do i = 1, system%effects%n_potentials
         self%gamma(:, i) = rotate_to_body(state%q, system%effects%potentials(i)%item%direction)
      end do
      if (present(here)) call bound_balls(self, system, 0.0_wp, dt, here)
      call find_ball(self, dt, reach, radius, near, here)
      certified = is_within(self, start, reach) .and. root <= radius
      ! Tubes are derived for non-rotating space axes and a constant inertia.
      self%followable = .not. (self%frame_rate > 0.0_wp .or. self%varies)
      if (self%followable .and. present(here)) &
         self%followable = here%known > 0 .and. strength_of(here%balls(1), dt) <= dominating
   end subroutine holds_here

   !> Finds the longest part of a stage from the state set last, among the powers of 0.8, whose root lies in a ball that
   !> contains no other; 0 if there is none.
   pure subroutine first_part(self, dt, start, part, radius, here)
      class(root_certificate_t), intent(in) :: self
      !> Length of the stage, s, and |b0|.
      real(wp), intent(in) :: dt, start
      real(wp), intent(out) :: part
      !> Upper bound of the root's |b|.
      real(wp), intent(out) :: radius
      !> Bounds from `holds_here`.
      type(all_bounds_t), intent(in), optional :: here
      real(wp) :: reach, near
      integer :: i
      part = 1.0_wp
      do i = 1, most_parts
         call find_ball(self, part*dt, reach, radius, near, here)
         if (part*start <= reach) return
         part = shorter*part
      end do
      part = 0.0_wp
   end subroutine first_part

   !> Finds the largest |b0| and |b| for which the root of a stage is certified, and the |b| up to which it is for any
   !> b0; the first and the last are negative if none is.
   pure subroutine find_ball(self, dt, reach, radius, near, bounds)
      class(root_certificate_t), intent(in) :: self
      !> Length of the stage, s.
      real(wp), intent(in) :: dt
      real(wp), intent(out) :: reach, radius, near
      !> Bounds of all effects; absent if nothing acts.
      type(all_bounds_t), intent(in), optional :: bounds
      type(ball_bounds_t) :: ball
      real(wp) :: rotor, rest, excess, contraction, force, slope, gyration, stretch
      integer :: k, known
      reach = -1.0_wp
      near = -1.0_wp
      radius = 0.0_wp
      if (.not. self%deviation < largest_deviation) return
      stretch = 1/(1 - self%deviation)
      gyration = self%gyration + 2*self%deviation
      force = 0.0_wp
      slope = 0.0_wp
      rotor = 0.5_wp*abs(dt)*self%rotor_rate
      known = size(radii)
      if (present(bounds)) known = bounds%known
      do k = 1, known
         if (present(bounds)) ball = bounds%balls(k)
         associate (rho => radii(k))
            rest = 1/(1 - rho*rho)
            if (self%n_spheres > 0) call bound_spheres(self, dt, rho, force, slope)
            excess = stretch*(rho*(gyration*rho + rotor) + weighted(ball%force, ball%drag, dt) + force)*rest
            contraction = (stretch*(2*gyration*rho + rotor + weighted(ball%slope, ball%drag_slope, dt) + slope) &
                           + 2*rho*excess)*rest
            if (.not. contraction < 1.0_wp) exit
            radius = rho
            reach = max(reach, rho - excess)
            near = max(near, rho - 2*excess)
         end associate
      end do
   end subroutine find_ball

   !> Bounds the part of inner spheres in b and its derivative with respect to b, for Jᵣ.
   pure subroutine bound_spheres(self, dt, rho, force, slope)
      class(root_certificate_t), intent(in) :: self
      !> Length of the stage, s, and ρ.
      real(wp), intent(in) :: dt, rho
      real(wp), intent(out) :: force, slope
      real(wp) :: pull, drag, radius, delta, drag_force, drag_slope
      integer :: i
      pull = 0.0_wp
      drag = 0.0_wp
      do i = 1, self%n_spheres
         ! (s/2)κj and |s|p/4.
         associate (half => 0.5_wp*abs(dt)*self%friction(i)/(1 + 0.5_wp*dt*self%friction(i)/self%inertia(i)) &
                    *self%inverse%norm)
            drag = drag + half
            pull = pull + min(half, greatest_bound)*min(0.25_wp*abs(dt)*self%pull(i), greatest_bound)
         end associate
      end do
      delta = 0.25_wp*abs(dt)*self%frame_rate
      radius = rho + delta
      force = (1 + radius*radius)*pull
      slope = 2*sqrt(1 + radius*radius)*pull
      if (delta > 0.0_wp) call widen(radius, delta, 1.0_wp, (force), (slope), force, slope)
      if (dt > 0.0_wp .and. .not. delta > 0.0_wp) return
      drag_force = radius*drag
      drag_slope = drag
      if (delta > 0.0_wp) call widen(radius, delta, 1.0_wp, radius*drag, drag, drag_force, drag_slope)
      force = force + drag_force
      slope = slope + drag_slope
   end subroutine bound_spheres

   !> Adds the bounds of inner spheres in a stage from a part of it on: κ falls along a stage with s > 0 and grows along
   !> one with s < 0. The second derivative of tκ by t enters as a force.
   pure subroutine add_spheres(self, norm, dt, part, radius, bounds)
      class(root_certificate_t), intent(in) :: self
      !> ‖A‖, length of the stage, s, part that is reached, and ρ.
      real(wp), intent(in) :: norm, dt, part, radius
      type(effect_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t) :: one
      real(wp) :: share, drag, rate
      integer :: i
      do i = 1, self%n_spheres
         share = 1/(1 + 0.5_wp*merge(part*dt, dt, dt > 0.0_wp)*self%friction(i)/self%inertia(i))
         drag = norm*share*self%friction(i)
         rate = share*self%friction(i)/self%inertia(i)
         one%force = (1 + radius*radius)*drag*self%pull(i)
         one%slope = 2*sqrt(1 + radius*radius)*drag*self%pull(i)
         one%curvature = 2*drag*self%pull(i)
         one%change = rate*one%force
         one%change_slope = rate*one%slope
         one%change_rate = 2*rate*one%change
         one%force = one%force + 2*rate*share*drag*radius
         one%drag_slope = max(1.0_wp, 3*radius*radius - 1)*max(1.0_wp, share)*drag
         one%drag_curvature = 6*radius*drag
         call add_bounds(bounds, one)
      end do
   end subroutine add_spheres

   !> Returns s²/8 times the bound of forces that do not resist the rotation plus s/2 times the bound of those that do.
   elemental real(wp) function weighted(force, drag, dt)
      real(wp), intent(in) :: force, drag, dt
      weighted = 0.125_wp*dt*dt*force + 0.5_wp*abs(dt)*drag
   end function weighted

   !> Returns a bound of the norm of the effects' part of the Jacobian.
   elemental real(wp) function strength_of(bounds, dt) result(strength)
      type(ball_bounds_t), intent(in) :: bounds
      real(wp), intent(in) :: dt
      strength = weighted(bounds%slope, bounds%drag_slope, dt)
   end function strength_of

   !> Bounds of all effects for each radius at any attitude.
   pure subroutine bound_everywhere(self, system, dt)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Length of the stage, s; used if the space axes rotate.
      real(wp), intent(in) :: dt
      integer :: i
      do i = 1, system%effects%n_potentials
         self%gamma(:, i) = system%effects%potentials(i)%item%direction
      end do
      if (allocated(self%everywhere)) call bound_balls(self, system, anywhere, dt, self%everywhere)
      self%length = 0.0_wp
   end subroutine bound_everywhere

   !> Computes the bounds of all effects for each radius, up to the first for which there are none.
   pure subroutine bound_balls(self, system, slack, dt, bounds)
      class(root_certificate_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> Largest error of γ at the start, over |n|; length of the stage, s.
      real(wp), intent(in) :: slack, dt
      type(all_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t) :: ball
      integer :: i
      bounds%known = 0
      do i = 1, size(radii)
         call bound_stage(self, system, radii(i), slack, dt, ball)
         if (.not. ball%known) exit
         bounds%known = i
         bounds%balls(i) = ball_bounds_t(force=ball%force, slope=ball%slope, drag=ball%drag, drag_slope=ball%drag_slope)
      end do
   end subroutine bound_balls

   !> Computes bounds of J⁻¹τ̂ of all effects that act, in a stage from the state set last.
   pure subroutine bound_stage(self, system, radius, slack, dt, bounds)
      class(root_certificate_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> ρ, and largest error of γ at the start, over |n|.
      real(wp), intent(in) :: radius, slack
      !> Length of the stage, s.
      real(wp), intent(in) :: dt
      type(effect_bounds_t), intent(out) :: bounds
      type(effect_bounds_t) :: plain
      real(wp) :: delta
      if (.not. self%frame_rate > 0.0_wp) then
         call self%bounds_of(system, self%inverse, radius, slack, bounds)
         return
      end if
      delta = 0.25_wp*abs(dt)*self%frame_rate
      bounds%known = delta <= largest_frame_turn
      if (.not. bounds%known) return
      call self%bounds_of(system, self%inverse, radius + delta, slack, bounds)
      call self%bounds_of(system, self%identity, radius + delta, slack, plain)
      bounds%known = bounds%known .and. plain%known
      if (.not. bounds%known) return
      call widen(radius + delta, delta, self%inverse%norm, plain%force, plain%slope, bounds%force, bounds%slope)
      call widen(radius + delta, delta, self%inverse%norm, plain%drag, plain%drag_slope, bounds%drag, bounds%drag_slope)
   end subroutine bound_stage

   !> Computes bounds of J⁻¹τ̂ and of its derivative by b from those by r without the term 2r(tδ̄·τ̄). The vector
   !> (1+|r|²)τ̄ - 2r(r·τ̄) is no shorter than (1-|r|²)|τ̄|, which bounds τ̄ and its derivative.
   elemental subroutine widen(radius, delta, inverse, plain_force, plain_slope, force, slope)
      !> Bound of |r|, δ, and ‖J⁻¹‖.
      real(wp), intent(in) :: radius, delta, inverse
      !> Bounds of (1+|r|²)τ̄ - 2r(r·τ̄) and of its derivative with respect to r.
      real(wp), intent(in) :: plain_force, plain_slope
      !> Bounds of J⁻¹((1+|r|²)τ̄ - 2r(r·τ̄)) and of its derivative by r on entry, of J⁻¹τ̂ and its derivative by b on
      !> exit.
      real(wp), intent(inout) :: force, slope
      real(wp) :: torque, change
      torque = plain_force/(1 - radius*radius)
      change = (plain_slope + 6*radius*torque)/(1 - radius*radius)
      force = force + inverse*(2*radius*delta*torque)
      slope = (slope + inverse*(delta*(2 + 4*radius)*torque + 2*radius*delta*change))/(1 - 2*delta)
   end subroutine widen

   !> Computes bounds of all effects that act, in a stage from the state set last.
   pure subroutine bounds_of(self, system, map, radius, slack, bounds)
      class(root_certificate_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> A
      type(linear_map_t), intent(in) :: map
      !> ρ, and largest error of γ at the start, over |n|.
      real(wp), intent(in) :: radius, slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp), parameter :: none(3) = 0.0_wp
      type(effect_bounds_t) :: one
      integer :: i
      do i = 1, system%effects%n_potentials
         associate (potential => system%effects%potentials(i)%item)
            call potential%bound(map, radius, self%gamma(:, i), slack, one)
            one%known = one%known .and. .not. potential%varies
         end associate
         call add_bounds(bounds, one)
      end do
      do i = 1, system%effects%n_torques
         if (.not. self%acts(i)) cycle
         call system%effects%torques(i)%item%bound(map, radius, none, slack, one)
         call add_bounds(bounds, one)
      end do
      bounds%known = bounds%known .and. max(bounds%force, bounds%slope, bounds%curvature, bounds%drag, &
                                            bounds%drag_slope, bounds%drag_curvature) < greatest_bound
   end subroutine bounds_of

   !> Notes which torques act, and between which times these and no others do.
   pure subroutine store_windows(self, system, window_time)
      class(root_certificate_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Length of the stage, s.
      real(wp), intent(in) :: window_time
      real(wp) :: window(2)
      integer :: i, k
      self%steady_from = -huge(1.0_wp)
      self%steady_to = huge(1.0_wp)
      do i = 1, system%effects%n_torques
         associate (torque => system%effects%torques(i)%item)
            self%acts(i) = torque%acts_at(window_time)
            call torque%window(window(1), window(2))
         end associate
         do k = 1, 2
            if (window(k) <= window_time) self%steady_from = max(self%steady_from, window(k))
            if (window(k) >= window_time) self%steady_to = min(self%steady_to, window(k))
         end do
      end do
      call bound_everywhere(self, system, 0.0_wp)
   end subroutine store_windows

   !> Returns κ, for which |2J⁻¹(b×Jb)| ≤ κ|b|²: with α_i = |J_k - J_l|/J_i and x_i = b_i²/|b|² its square is the
   !> largest value of 4(α1²x2x3 + α2²x3x1 + α3²x1x2), x1 + x2 + x3 = 1, on an edge or inside.
   pure real(wp) function gyration_of(moments) result(kappa)
      !> Principal moments, kg m²; shape (3).
      real(wp), intent(in) :: moments(3)
      real(wp) :: c(3), scale, x(3), below
      integer :: i, k, l
      do i = 1, 3
         k = 1 + modulo(i, 3)
         l = 1 + modulo(i + 1, 3)
         c(i) = abs(moments(k)/moments(i) - moments(l)/moments(i))
      end do
      scale = maxval(c)
      kappa = 0.0_wp
      if (.not. scale > 0.0_wp) return
      c = (c/scale)**2
      ! On an edge x_k = x_l = ½; inside, the gradient is along (1, 1, 1).
      kappa = 1.0_wp
      below = 2*(c(1)*c(2) + c(2)*c(3) + c(3)*c(1)) - sum(c*c)
      if (below > 0.0_wp) then
         x = [c(1)*(c(2) + c(3) - c(1)), c(2)*(c(3) + c(1) - c(2)), c(3)*(c(1) + c(2) - c(3))]/below
         if (all(x > 0.0_wp)) kappa = max(kappa, 4*(c(1)*x(2)*x(3) + c(2)*x(3)*x(1) + c(3)*x(1)*x(2)))
      end if
      kappa = scale*sqrt(kappa)
   end function gyration_of

end module nutate_root_certificate
