!> Continuation of the true root to a stage's length by Newton-Kantorovich tubes: each proves that the branch exists and
!> is alone in a neighbourhood over a part of the stage, so that no other root can be treated as it.
!>
!> Ψ(b,t) = 0 is the equation of `nutate_root_certificate`. From a root (b,t) the branch leaves along v = -B Ψ_t, B =
!> Ψ_b⁻¹. In the ball of radius r about b + (t'-t)v the chord iteration with B contracts for each t' up to t+δ if
!>
!>     a(½Qδ²) + x r + aK r² ≤ r,   x = a(K|v| + K_t)δ,   a = ‖B‖,
!>
!> with K, K_t and Q bounds of the second derivatives by b, by b and t, and along v. The bounds of the effects are taken
!> of B Ψ itself, not of Ψ, where that is less.
module nutate_branch_tubes
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t, map_of, spectral_norm
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_root_certificate, only: all_bounds_t, root_certificate_t
   use nutate_small_products, only: times_columns, times_vector, vector_length
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: branch_t

   !> |b| from which a root is rejected: at |b| = 1, half a revolution, the equations have a solution that is no step. A
   !> tube stays below the second, and reaches as far as the third from its root: farther away the bounds, of order |b|,
   !> would be no tighter than the tube is long.
   real(wp), parameter :: longest = 0.98_wp, outermost = 0.99_wp, widest = 0.15_wp
   !> Least reach of a tube; it is shortened down to this if effects have no bounds.
   real(wp), parameter :: narrowest = 1e-3_wp
   !> Shortest tube over the part reached, and largest number of tubes: with 60, 769 of 7789 hard branches end too
   !> early; the paper's box needs 173 for a step of 3 s.
   real(wp), parameter :: shortest = 1e-4_wp
   integer, parameter :: most_tubes = 300
   !> The longest tube that the bounds at its start admit is shortened by the first, since they grow along it; a radius
   !> stays inside the largest by the second.
   real(wp), parameter :: margin = 0.95_wp, inside = 0.999_wp
   !> Increment over |b| after which Newton's next one is near round-off, and most iterations: from within a tube it
   !> converges quadratically.
   real(wp), parameter :: converged = 1e-8_wp, at_rest = 1e-15_wp
   integer, parameter :: most_iterations = 10

   !> The branch of a stage, followed to a part of it.
   type :: branch_t
      !> Root at the part reached; shape (3).
      real(wp) :: b(3) = 0.0_wp
      !> Part of the stage that is reached.
      real(wp) :: part = 0.0_wp
      !> Number of lengths tried.
      integer :: tried = 0
      !> An effect has no bounds near the root reached: what follows cannot be certified.
      logical :: is_unbounded = .false.
      !> Step, s, b0, and |b0|.
      real(wp), private :: dt = 0.0_wp, start(3) = 0.0_wp, start_length = 0.0_wp
   contains
      !> Follows the branch of a stage from t = 0.
      procedure :: follow
   end type branch_t

   !> Data at the start of a tube.
   type, private :: tube_t
      !> v, b - t b0; shape (3), and lengths: |b|, |v|, |v - b0|, and c, how far the tube may reach.
      real(wp) :: direction(3) = 0.0_wp, change(3) = 0.0_wp
      real(wp) :: turn = 0.0_wp, speed = 0.0_wp, drift = 0.0_wp, reach = 0.0_wp
      !> a, and the bounds of B times the effects.
      real(wp) :: inverse = 0.0_wp
      type(effect_bounds_t) :: bounds = effect_bounds_t()
   end type tube_t

contains

   !> Follows the branch of a stage from t = 0; the whole stage is reached if `part` is 1 afterwards.
   subroutine follow(self, certificate, equations, system, state, dt, window_time, here)
      class(branch_t), intent(inout) :: self
      !> Certificate that was set to the state.
      type(root_certificate_t), intent(in) :: certificate
      !> Equations with forces prepared for the system; their step is changed.
      type(reduced_equations_t), intent(inout) :: equations
      type(system_t), intent(in) :: system
      !> State at the start of the stage.
      type(state_t), intent(in) :: state
      !> s, and the time that decides which torques act.
      real(wp), intent(in) :: dt, window_time
      !> Bounds from `holds_here` of the certificate.
      type(all_bounds_t), intent(in), optional :: here
      type(tube_t) :: tube
      real(wp) :: last, delta, radius
      logical :: found
      self%dt = dt
      call set_length(dt)
      self%start = equations%explicit_guess(system)
      self%start_length = vector_length(self%start)
      call certificate%first_part(dt, self%start_length, self%part, radius, here)
      if (.not. self%part > 0.0_wp) return
      self%b = self%part*self%start
      call find_root(self%part, 2*radius, found)
      if (.not. found .or. vector_length(self%b) > radius) then
         self%part = 0.0_wp
         return
      end if
      last = self%part
      do while (self%part < 1.0_wp)
         call begin_tube(found)
         if (.not. found) return
         delta = min(1 - self%part, 2*last)
         call pass_tube()
         if (.not. delta > 0.0_wp) return
         last = delta
      end do

   contains

      !> Sets a part of the stage's length.
      subroutine set_length(length)
         real(wp), intent(in) :: length
         call equations%set_step(system, length)
         call equations%start(system, state, window_time)
      end subroutine set_length

      !> Performs Newton's iteration from b at a part of the stage. `found` is true if it ends within a distance of
      !> where it began; otherwise b is unchanged.
      subroutine find_root(part, distance, found)
         real(wp), intent(in) :: part, distance
         logical, intent(out) :: found
         real(wp) :: b(3), f(3), d(3), rows(3, 3), determinant, length, last, enough
         integer :: i
         found = .false.
         last = huge(last)
         enough = converged
         if (part >= 1.0_wp) enough = eps
         self%tried = self%tried + 1
         call set_length(part*self%dt)
         b = self%b
         do i = 1, most_iterations
            call equations%residual(system, b, f)
            if (equations%forces%active) call equations%linearize_forces(system, b)
            call equations%invert(b, rows, determinant)
            if (equations%too_strong .or. .not. abs(determinant) > tiny(determinant)) return
            d = [dot_product(rows(:, 1), f), dot_product(rows(:, 2), f), dot_product(rows(:, 3), f)]
            b = b - d
            if (.not. vector_length(b - self%b) <= distance) return
            length = vector_length(d)
            ! At the end of the stage the iteration goes on until the increments stop falling.
            found = length <= enough*vector_length(b) .or. length <= at_rest .or. &
                    (length <= converged*vector_length(b) .and. length > 0.5_wp*last)
            if (found) exit
            last = length
         end do
         if (found) self%b = b
      end subroutine find_root

      !> Computes the tube of the root reached: direction of the branch and bounds. The equations are those of the part
      !> reached.
      subroutine begin_tube(regular)
         !> The branch goes on.
         logical, intent(out) :: regular
         type(linear_map_t) :: map
         real(wp) :: rows(3, 3), inverse(3, 3), determinant, f(3), largest
         integer :: i
         regular = .false.
         tube = tube_t()
         tube%turn = vector_length(self%b)
         if (tube%turn > longest) return
         call equations%residual(system, self%b, f)
         if (equations%forces%active) call equations%linearize_forces(system, self%b)
         call equations%invert(self%b, rows, determinant)
         if (equations%too_strong .or. .not. abs(determinant) > tiny(determinant)) return
         associate (j => system%body%inertia)
            largest = max(j(1, 1), j(2, 2), j(3, 3))
         end associate
         ! F = J P/s: B = F_b⁻¹ J/s, and B J⁻¹ = F_b⁻¹/s.
         do i = 1, 3
            inverse(i, :) = rows(:, i)
         end do
         map = map_of(inverse/largest, system%body%axes)
         tube%inverse = spectral_norm(times_columns(inverse, equations%inertia))
         tube%direction = branch_direction(map)
         tube%change = self%b - self%part*self%start
         tube%speed = vector_length(tube%direction)
         tube%drift = vector_length(tube%direction - self%start)
         tube%reach = min(widest, outermost - tube%turn)
         do while (tube%reach > narrowest)
            call certificate%bounds_of(system, map, tube%turn + tube%reach, 0.0_wp, tube%bounds)
            call certificate%add_spheres(map%norm, self%dt, self%part, tube%turn + tube%reach, tube%bounds)
            regular = tube%bounds%known
            if (regular) return
            tube%reach = 0.5_wp*tube%reach
         end do
         self%is_unbounded = .true.
      end subroutine begin_tube

      !> Returns v = -B Ψ_t, with Ψ_t = -(1-β)b0 + 2J⁻¹(b×sh/4) - (s²/8)J⁻¹(2tτ̂ + t²∂τ̂/∂t) + (s/2)J⁻¹τ̂_D. The
      !> equations hold the torque of the root.
      function branch_direction(map) result(v)
         !> B J⁻¹
         type(linear_map_t), intent(in) :: map
         real(wp) :: v(3)
         real(wp) :: drag(3), change(3), load(3)
         associate (b => self%b, dt => self%dt, t => self%part)
            load = times_vector(system%body%inertia, (1 - dot_product(b, b))*self%start) &
                   - (0.5_wp*dt)*cross(b, system%effects%rotor_momentum)
            if (equations%forces%active) then
               call equations%forces%split_turn(system%effects, b, equations%rate, dt, drag, change)
               if (allocated(equations%spheres)) call equations%spheres%split_turn(system%effects, b, drag, change)
               load = load + (0.125_wp*dt*dt*t)*entering(b, 2*equations%torque - drag + (0.5_wp*dt*t)*change)
            end if
            v = times_vector(map%matrix, load)
         end associate
      end function branch_direction

      !> Goes to the end of the longest tube that is certified, no longer than δ. δ is 0 if there is none.
      subroutine pass_tube()
         real(wp) :: radius, root(3), part
         logical :: found
         root = self%b
         do while (self%tried < most_tubes)
            call shorten(radius)
            if (.not. delta > 0.0_wp) return
            part = self%part + delta
            if (delta >= 1 - self%part) part = 1.0_wp
            self%b = root + delta*tube%direction
            call find_root(part, radius, found)
            if (found) then
               self%part = part
               return
            end if
            self%b = root
            delta = 0.5_wp*delta
         end do
         delta = 0.0_wp
      end subroutine pass_tube

      !> Shortens a tube until it is certified, and gives its radius at the end; δ is 0 if that would be too short.
      subroutine shorten(radius)
         real(wp), intent(out) :: radius
         real(wp) :: k, k_t, q, x, inner, outer, root
         radius = 0.0_wp
         do while (delta > shortest*self%part)
            call bound_derivatives(k, k_t, q)
            x = (k*tube%speed + k_t)*delta
            root = (1 - x)**2 - 2*k*q*delta*delta
            if (x >= 1.0_wp .or. root < 0.0_wp) then
               delta = min(0.7_wp*delta, margin/(k*tube%speed + k_t + sqrt(2*k*q)))
               cycle
            end if
            root = sqrt(root)
            inner = (1 - x - root)/(2*k)
            outer = (1 - x + root)/(2*k)
            radius = min(inside*outer, tube%reach - delta*tube%speed)
            if (radius > inner) return
            delta = 0.7_wp*delta
         end do
         delta = 0.0_wp
      end subroutine shorten

      !> Computes aK, aK_t and aQ of a tube of length δ.
      pure subroutine bound_derivatives(k, k_t, q)
         real(wp), intent(out) :: k, k_t, q
         real(wp) :: part, half, whole, distance
         part = self%part + delta
         half = 0.5_wp*abs(self%dt)
         whole = 0.5_wp*half*half
         distance = vector_length(tube%change) + delta*tube%drift + tube%reach
         associate (a => tube%inverse, bounds => tube%bounds)
            k = a*(2*distance + 4*(tube%turn + tube%reach) + 2*certificate%gyration) &
                + part*(part*whole*bounds%curvature + half*bounds%drag_curvature)
            k_t = a*(2*(tube%turn + tube%reach)*self%start_length + half*certificate%rotor_rate) &
                  + part*whole*(2*bounds%slope + part*half*bounds%change_slope) + half*bounds%drag_slope
            q = (k*tube%speed + 2*k_t)*tube%speed &
                + whole*(2*bounds%force + part*half*(4*bounds%change + part*half*bounds%change_rate))
         end associate
      end subroutine bound_derivatives

   end subroutine follow

   !> Returns T = (1+β)τ̄ - 2b(b·τ̄).
   pure function entering(b, tau) result(t)
      real(wp), intent(in) :: b(3), tau(3)
      real(wp) :: t(3)
      t = (1 + dot_product(b, b))*tau - (2*dot_product(b, tau))*b
   end function entering

end module nutate_branch_tubes
