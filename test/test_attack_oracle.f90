!> Oracle for the branch of the true motion of a step; it shares no equation with the library.
!>
!> A stage of length s has the root b of P(b, t) = 0 at t = 1, b = ¼sΩ̄, that grows out of b = 0 at t = 0:
!>
!>     P = (1 - β)(b - t b0) + 2J⁻¹(b×(Jb + ¼ts h)) - ⅛t²s² J⁻¹T + ½ts J⁻¹T_D,   b0 = ¼sΩ0, β = |b|²
!>     T = (1 + β)τ̄ - 2b(b·τ̄),   T_D = (1 + β)Db - 2b(b·Db)
!>
!> τ̄ is the torque at mid step without damping, in the frame there; D the coefficients of damping. A sphere with the
!> momentum l in space adds κR(q̄)ᵀl/I to τ̄, and κ = c/(1 + ½ts c/I) to D; J is that of the middle of the part ts, and
!> the rate of the inertia of mass that leaves is taken from D. The branch is
!> followed from t = 0 in increments so small that the Jacobian hardly changes in each, seen from the root before: then
!> no other root lies near.
module test_attack_oracle
   use nutate_kinds, only: wp, eps, pi
   use test_attack_case, only: attack_case_t, attack_effect_t, most_drawn_spheres, most_effects, GRADIENT, SPRING, &
      POLYNOMIAL, BODY_TORQUE, SPACE_TORQUE, DAMPING, FEEDBACK
   implicit none
   private

   public :: oracle_t, branch_t, REACHED, ENDED, LOST

   !> The branch goes on to the whole length; it ends before; it could not be followed.
   integer, parameter :: REACHED = 1, ENDED = 2, LOST = 3
   !> Step of the central differences of P, by b and by t.
   real(wp), parameter :: h_difference = 4e-6_wp
   !> Largest change of the Jacobian in an increment, ‖P_b(old)⁻¹P_b(new) - 1‖, and of b; over the fineness.
   real(wp), parameter :: largest_change = 0.2_wp, longest_way = 0.04_wp
   !> Increments of t: the first, the shortest, and most of them.
   real(wp), parameter :: first_increment = 0.02_wp, shortest_increment = 1e-9_wp
   integer, parameter :: most_increments = 20000
   !> |b| at which a stage has no step any more: half a turn.
   real(wp), parameter :: half_turn = 0.995_wp
   !> det P_b below which the end of the increments is that of the branch.
   real(wp), parameter :: nearly_singular = 0.05_wp

   !> Result of following a branch.
   type :: branch_t
      integer :: outcome = LOST
      !> The root at the end, body axes; shape (3).
      real(wp) :: b(3) = 0.0_wp
      !> Part of the length reached; largest |b| on the way; det P_b at the end; least 1/‖P_b⁻¹‖ on the way.
      real(wp) :: t = 0.0_wp, turn = 0.0_wp, determinant = 1.0_wp, stiffness = 1.0_wp
      integer :: increments = 0
   end type branch_t

   !> The equations of one stage.
   type :: oracle_t
      private
      real(wp) :: inertia(3, 3) = 0.0_wp, inverse(3, 3) = 0.0_wp
      !> s; ¼sΩ0; time of the start, s.
      real(wp) :: s = 0.0_wp, b0(3) = 0.0_wp, t0 = 0.0_wp
      real(wp) :: rotor(3) = 0.0_wp
      !> The case; momenta of its spheres at the start, body axes; the inertia varies; JΩ0 at the start, N m s.
      type(attack_case_t) :: item
      real(wp) :: spheres(3, most_drawn_spheres) = 0.0_wp
      logical :: varies = .false.
      real(wp) :: momentum(3) = 0.0_wp
      integer :: n_effects = 0
      type(attack_effect_t) :: effects(most_effects)
      !> n of each effect in the frame of the start; A of a gradient; c of a spring; the effect acts.
      real(wp) :: direction(3, most_effects) = 0.0_wp, stiffness(3, 3, most_effects) = 0.0_wp
      real(wp) :: closeness(most_effects) = 0.0_wp
      logical :: acts(most_effects) = .true.
   contains
      !> Sets a stage.
      procedure :: begin
      !> P
      procedure :: residual
      !> Follows the branch to the whole length.
      procedure :: follow
      !> Torques over those that the least moment balances at the rate of the start, at most: ‖T‖/(J_min Ω0²).
      procedure :: strength
   end type oracle_t

contains

   !> Sets a stage of a case: the state at its start, its length and the time that decides which torques act.
   pure subroutine begin(self, item, q, omega, t0, s, window_time, spheres)
      class(oracle_t), intent(inout) :: self
      type(attack_case_t), intent(in) :: item
      !> Body→space; body axes, rad/s.
      real(wp), intent(in) :: q(4), omega(3)
      !> s
      real(wp), intent(in) :: t0, s, window_time
      !> Momenta of the spheres, body axes, N m s.
      real(wp), intent(in), optional :: spheres(:)
      real(wp) :: middle, unit(4), x, a
      integer :: i, k
      self%inertia = item%inertia()
      self%inverse = inverse_of(self%inertia)
      self%s = s
      self%b0 = 0.25_wp*s*omega
      self%t0 = t0
      self%rotor = item%rotor
      self%item = item
      self%varies = any(abs(item%inertia_rate) > 0.0_wp)
      self%momentum = matmul(inertia_of(self, t0), omega)
      if (present(spheres)) self%spheres(:, :item%n_spheres) = reshape(spheres(:3*item%n_spheres), [3, item%n_spheres])
      self%n_effects = item%n_effects
      self%effects = item%effects
      unit = q/norm2(q)
      middle = sum(item%moments) - maxval(item%moments) - minval(item%moments)
      do i = 1, item%n_effects
         associate (effect => self%effects(i))
            self%direction(:, i) = rotated_back(unit(1), unit(2:4), effect%n)
            if (effect%kind == BODY_TORQUE) self%direction(:, i) = effect%n
            self%stiffness(:, :, i) = self%inertia
            do k = 1, 3
               self%stiffness(k, k, i) = self%stiffness(k, k, i) - middle
            end do
            self%stiffness(:, :, i) = 3*effect%strength*self%stiffness(:, :, i)
            x = norm2(effect%m)
            a = norm2(effect%n)
            self%closeness(i) = merge(1.0_wp, 0.0_wp, abs(x - a) <= 0.01_wp*a)
            self%acts(i) = window_time >= effect%start .and. window_time <= effect%stop
         end associate
      end do
   end subroutine begin

   !> P(b, t).
   pure function residual(self, b, t) result(p)
      class(oracle_t), intent(in) :: self
      real(wp), intent(in) :: b(3), t
      real(wp) :: p(3), tau(3), drag(3), beta, time, inertia(3, 3), inverse(3, 3), b0(3), kappa
      integer :: i
      beta = dot_product(b, b)
      tau = 0.0_wp
      drag = 0.0_wp
      time = self%t0 + 0.5_wp*t*self%s
      do i = 1, self%n_effects
         associate (effect => self%effects(i))
            select case (effect%kind)
            case (BODY_TORQUE, SPACE_TORQUE, FEEDBACK)
               if (self%acts(i)) tau = tau + cos(2*pi*effect%frequency*time + effect%phase)*torque_of(self, i, b)
            case (DAMPING)
               drag = drag + effect%m*b
            case default
               tau = tau + potential_torque(self, i, b)
            end select
         end associate
      end do
      inertia = self%inertia
      inverse = self%inverse
      b0 = self%b0
      if (self%varies) then
         inertia = inertia_of(self, time)
         inverse = inverse_of(inertia)
         b0 = 0.25_wp*self%s*matmul(inverse, self%momentum)
         if (self%item%mass_leaves) drag = drag - matmul(self%item%inertia_rate, b)
      end if
      do i = 1, self%item%n_spheres
         kappa = self%item%friction(i)/(1 + 0.5_wp*t*self%s*self%item%friction(i)/self%item%sphere_inertia(i))
         tau = tau + (kappa/self%item%sphere_inertia(i)/(1 + beta))*rotated_back(1.0_wp, b, self%spheres(:, i))
         drag = drag + kappa*b
      end do
      tau = (1 + beta)*tau - (2*dot_product(b, tau))*b
      drag = (1 + beta)*drag - (2*dot_product(b, drag))*b
      p = 2*cross(b, matmul(inertia, b) + (0.25_wp*t*self%s)*self%rotor) &
          - (0.125_wp*(t*self%s)**2)*tau + (0.5_wp*t*self%s)*drag
      p = (1 - beta)*(b - t*b0) + matmul(inverse, p)
   end function residual

   !> Inertia at a time, kg m²; shape (3,3).
   pure function inertia_of(self, t) result(inertia)
      class(oracle_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: inertia(3, 3)
      associate (item => self%item)
         inertia = self%inertia + (min(max(t, item%change_start), item%change_stop) - &
                                   min(max(0.0_wp, item%change_start), item%change_stop))*item%inertia_rate
      end associate
   end function inertia_of

   !> An applied torque, or that of the test's own, e(a·γ)γ, at mid step, its time left out.
   pure function torque_of(self, i, b) result(tau)
      class(oracle_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: b(3)
      real(wp) :: tau(3)
      tau = self%direction(:, i)
      if (self%effects(i)%kind == BODY_TORQUE) return
      tau = rotated_back(1.0_wp, b, tau)/(1 + dot_product(b, b))
      if (self%effects(i)%kind == FEEDBACK) tau = (self%effects(i)%strength*dot_product(self%effects(i)%m, tau))*tau
   end function torque_of

   !> γ(q̄)×∇̄U of a potential, γ0 and γ1 its direction in the body at the ends, γ(q̄) at the mean of the quaternions.
   pure function potential_torque(self, i, b) result(tau)
      class(oracle_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: b(3)
      real(wp) :: tau(3), first(3), last(3), middle(3), slope(3), half(3), shrink, l0, l1
      shrink = 1/(1 + dot_product(b, b))
      first = self%direction(:, i)
      half = shrink*rotated_back(1.0_wp, b, first)
      last = shrink*rotated_back(1.0_wp, b, half)
      middle = shrink*half
      associate (effect => self%effects(i))
         select case (effect%kind)
         case (GRADIENT)
            slope = matmul(self%stiffness(:, :, i), 0.5_wp*(first + last))
         case (SPRING)
            l0 = spring_length(effect, self%closeness(i), first)
            l1 = spring_length(effect, self%closeness(i), last)
            slope = effect%m - (0.5_wp*self%closeness(i))*(first + last)
            if (l0 + l1 > 0.0_wp) slope = (1 - 2*effect%rest_length/(l0 + l1))*slope
            slope = -effect%strength*slope
         case (POLYNOMIAL)
            slope = custom_slope(effect, first, last)
         case default
            slope = -effect%m
         end select
      end associate
      tau = cross(middle, slope)
   end function potential_torque

   !> ℓ² = |x|² + |a|² - 2x·γ + c(|γ|² - |a|²), which is |x - γ|² where the ends can meet (c = 1).
   pure real(wp) function spring_length(effect, closeness, gamma)
      type(attack_effect_t), intent(in) :: effect
      real(wp), intent(in) :: closeness, gamma(3)
      if (closeness > 0.0_wp) then
         spring_length = norm2(effect%m - gamma)
      else
         spring_length = sqrt(max(0.0_wp, sum(effect%m**2) + sum(effect%n**2) - 2*dot_product(effect%m, gamma)))
      end if
   end function spring_length

   !> Gonzalez's discrete gradient of e ((a·γ)³ - γ1γ2).
   pure function custom_slope(effect, first, last) result(slope)
      type(attack_effect_t), intent(in) :: effect
      real(wp), intent(in) :: first(3), last(3)
      real(wp) :: slope(3), mean(3), change(3), rise
      mean = 0.5_wp*(first + last)
      change = last - first
      slope = 3*dot_product(effect%m, mean)**2*effect%m - [mean(2), mean(1), 0.0_wp]
      if (sum(change**2) > eps**(2.0_wp/3)*sum(first**2)) then
         ! (a·γ)³ rises by a·Δγ(x² + xy + y²); the product's gradient at the mean is exact.
         associate (x => dot_product(effect%m, first), y => dot_product(effect%m, last))
            rise = (y - x)*(x*x + x*y + y*y - 0.75_wp*(x + y)**2)
         end associate
         slope = slope + (rise/sum(change**2))*change
      end if
      slope = effect%strength*slope
   end function custom_slope

   !> Follows the branch from t = 0 to 1 in increments of b and of the Jacobian that shrink with the fineness.
   pure subroutine follow(self, fineness, branch)
      class(oracle_t), intent(in) :: self
      !> 1, or more for smaller increments.
      real(wp), intent(in) :: fineness
      type(branch_t), intent(out) :: branch
      real(wp) :: jacobian(3, 3), inverse(3, 3), v(3), delta, change, way
      logical :: found
      jacobian = derivative_by_b(self, branch%b, 0.0_wp)
      inverse = inverse_of(jacobian)
      delta = first_increment/fineness
      do while (branch%t < 1.0_wp)
         branch%increments = branch%increments + 1
         v = -matmul(inverse, derivative_by_t(self, branch%b, branch%t))
         way = norm2(v)
         delta = min(delta, first_increment/fineness, longest_way/(fineness*max(way, tiny(way)**0.5_wp)))
         delta = min(delta, 1 - branch%t)
         do
            if (delta < shortest_increment .or. branch%increments > most_increments) then
               if (branch%determinant < nearly_singular .and. delta < shortest_increment) branch%outcome = ENDED
               return
            end if
            call find_increment(self, fineness, v, delta, branch, inverse, change, found)
            if (found) exit
            branch%increments = branch%increments + 1
            delta = 0.5_wp*delta
         end do
         if (branch%turn > half_turn) then
            branch%outcome = ENDED
            return
         end if
         delta = delta*max(0.5_wp, min(1.5_wp, 0.8_wp*(largest_change/fineness)/max(change, tiny(change)**0.5_wp)))
      end do
      branch%outcome = REACHED
   end subroutine follow

   !> One increment: tangent and two Newton iterations, which must contract; the Jacobian must hardly change.
   pure subroutine find_increment(self, fineness, v, delta, branch, inverse, change, found)
      class(oracle_t), intent(in) :: self
      real(wp), intent(in) :: fineness, v(3), delta
      type(branch_t), intent(inout) :: branch
      !> P_b⁻¹ at the root before, then at the new one.
      real(wp), intent(inout) :: inverse(3, 3)
      !> ‖P_b(old)⁻¹P_b(new) - 1‖
      real(wp), intent(out) :: change
      logical, intent(out) :: found
      real(wp) :: b(3), t, one(3), two(3), jacobian(3, 3), next(3, 3)
      found = .false.
      change = huge(change)
      t = branch%t + delta
      if (1 - t < 1e-3_wp*shortest_increment) t = 1.0_wp
      b = branch%b + delta*v
      jacobian = derivative_by_b(self, b, t)
      if (.not. distance_from_one(matmul(inverse, jacobian)) < largest_change/fineness) return
      one = -matmul(inverse_of(jacobian), self%residual(b, t))
      if (.not. norm2(one) < 0.25_wp*delta*norm2(v) + 1e-10_wp) return
      b = b + one
      jacobian = derivative_by_b(self, b, t)
      change = distance_from_one(matmul(inverse, jacobian))
      if (.not. change < largest_change/fineness) return
      next = inverse_of(jacobian)
      two = -matmul(next, self%residual(b, t))
      if (.not. norm2(two) < 0.1_wp*norm2(one) + 1e-9_wp) return
      found = .true.
      inverse = next
      branch%b = b + two
      branch%t = t
      branch%turn = max(branch%turn, norm2(branch%b))
      branch%determinant = determinant_of(jacobian)
      branch%stiffness = min(branch%stiffness, 1/norm2(next))
   end subroutine find_increment

   pure function derivative_by_b(self, b, t) result(matrix)
      class(oracle_t), intent(in) :: self
      real(wp), intent(in) :: b(3), t
      real(wp) :: matrix(3, 3), shift(3)
      integer :: i
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h_difference
         matrix(:, i) = (self%residual(b + shift, t) - self%residual(b - shift, t))/(2*h_difference)
      end do
   end function derivative_by_b

   pure function derivative_by_t(self, b, t) result(slope)
      class(oracle_t), intent(in) :: self
      real(wp), intent(in) :: b(3), t
      real(wp) :: slope(3)
      slope = (self%residual(b, t + h_difference) - self%residual(b, t - h_difference))/(2*h_difference)
   end function derivative_by_t

   !> The largest torques of all effects together, over J_min Ω0².
   pure real(wp) function strength(self)
      class(oracle_t), intent(in) :: self
      real(wp) :: omega, least
      integer :: i
      omega = 4*norm2(self%b0)/abs(self%s)
      least = 1/norm2(self%inverse)
      strength = 0.0_wp
      do i = 1, self%n_effects
         associate (effect => self%effects(i))
            select case (effect%kind)
            case (GRADIENT)
               strength = strength + norm2(self%stiffness(:, :, i))
            case (SPRING)
               strength = strength + effect%strength*norm2(effect%m)*norm2(effect%n)
            case (POLYNOMIAL)
               strength = strength + 4*effect%strength
            case (FEEDBACK)
               strength = strength + effect%strength
            case (BODY_TORQUE, SPACE_TORQUE)
               if (self%acts(i)) strength = strength + norm2(effect%n)
            case (DAMPING)
               strength = strength + maxval(abs(effect%m))*omega
            case default
               strength = strength + norm2(effect%m)*norm2(effect%n)
            end select
         end associate
      end do
      strength = strength/max(least*omega**2, tiny(omega)**0.5_wp)
   end function strength

   !> R(w + v)ᵀa for a quaternion of scalar w and vector v of any length.
   pure function rotated_back(w, v, a) result(r)
      real(wp), intent(in) :: w, v(3), a(3)
      real(wp) :: r(3)
      r = (w*w - dot_product(v, v))*a + (2*dot_product(v, a))*v - (2*w)*cross(v, a)
   end function rotated_back

   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   pure real(wp) function determinant_of(a)
      real(wp), intent(in) :: a(3, 3)
      determinant_of = dot_product(a(:, 1), cross(a(:, 2), a(:, 3)))
   end function determinant_of

   !> The inverse by cofactors; huge where there is none.
   pure function inverse_of(a) result(inverse)
      real(wp), intent(in) :: a(3, 3)
      real(wp), parameter :: least_determinant = 1e-60_wp
      real(wp) :: inverse(3, 3), determinant
      determinant = determinant_of(a)
      if (.not. abs(determinant) > least_determinant) determinant = least_determinant
      inverse(1, :) = cross(a(:, 2), a(:, 3))/determinant
      inverse(2, :) = cross(a(:, 3), a(:, 1))/determinant
      inverse(3, :) = cross(a(:, 1), a(:, 2))/determinant
   end function inverse_of

   !> Frobenius norm of a matrix less the unit matrix.
   pure real(wp) function distance_from_one(a)
      real(wp), intent(in) :: a(3, 3)
      distance_from_one = sqrt((a(1, 1) - 1)**2 + (a(2, 2) - 1)**2 + (a(3, 3) - 1)**2 + a(1, 2)**2 + a(1, 3)**2 &
                               + a(2, 1)**2 + a(2, 3)**2 + a(3, 1)**2 + a(3, 2)**2)
   end function distance_from_one

end module test_attack_oracle
