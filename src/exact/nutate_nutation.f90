!> The cubic of Lagrange's top: the range of the tilt and the elliptic functions in it.
!>
!> ż² = (e - κz)(1 - z²) - (b - a z)², z = cos θ, κ >= 0. Every root is computed as a distance from a point that lies
!> between it and its neighbour: from the initial z₀, from z = 1 and from z = -1. The cubic is expanded there, with
!> coefficients from the initial state without cancellation. Any unit of time.
module nutate_nutation
   use nutate_elliptic_phase, only: elliptic_phase_t
   use nutate_kinds, only: wp, pi, eps
   implicit none
   private

   public :: start_t, nutation_t

   !> κ / (a² + ω²) below which the third root is too far away to be of use: it lies at about the inverse.
   real(wp), parameter :: weak_gravity = 0.1_wp
   !> Size of a coefficient below which a root is zero: eighteen decades above the smallest number it has all digits.
   real(wp), parameter :: smallest = 1.0e-290_wp

   !> Initial state of a top, in its own frame.
   type :: start_t
      !> 2 m g l / J₁ and J₃Ω₃/J₁.
      real(wp) :: kappa = 0.0_wp, a = 0.0_wp
      !> Square of the angular velocity across the axis.
      real(wp) :: square = 0.0_wp
      !> b - a z = Ω₁γ₁ + Ω₂γ₂.
      real(wp) :: g = 0.0_wp
      !> 1 - z and 1 + z.
      real(wp) :: zeta = 0.0_wp, xi = 2.0_wp
      !> ż and z̈.
      real(wp) :: speed = 0.0_wp, acceleration = 0.0_wp
      !> Phases of cos θ/2 exp(i(φ + ψ)/2) and sin θ/2 exp(i(φ - ψ)/2) in a suitable space frame; for a vertical axis
      !> those of the moment after the start.
      real(wp) :: phase(2) = 0.0_wp
   contains
      !> Sets the initial state.
      procedure :: set => set_start
      !> Returns true if the tilt is constant.
      procedure :: is_steady
   end type start_t

   !> Nutation in elliptic functions: z = z₁ cn² u + z₂ sn² u with u̇ = `u_rate`.
   type :: nutation_t
      !> 1 - z and 1 + z at u = 0 (lowest) and u = K (highest point of the axis).
      real(wp) :: zeta(2) = 0.0_wp, xi(2) = 0.0_wp
      !> z₂ - z₁, > 0.
      real(wp) :: range = 0.0_wp
      !> u̇ and the complementary parameter (z₃ - z₂)/(z₃ - z₁).
      real(wp) :: u_rate = 0.0_wp, m1 = 1.0_wp
      !> Jacobi's functions at the start.
      real(wp) :: sn0 = 0.0_wp, cn0 = 1.0_wp, dn0 = 1.0_wp
      !> √((z₃ - 1)/(z₃ - z₁)) and √((z₃ + 1)/(z₃ - z₁)).
      real(wp) :: d_minus = 0.0_wp, d_plus = 1.0_wp
      !> Signs of b - a and b + a.
      real(wp) :: sign_zeta = 1.0_wp, sign_xi = 1.0_wp
   contains
      !> Computes range and parameters from the initial state.
      procedure :: set => set_nutation
      !> Returns ż at a phase.
      procedure :: speed => nutation_speed
      !> Returns b - a z at a tilt.
      procedure :: node_rate
   end type nutation_t

contains

   !> Sets the initial state.
   pure subroutine set_start(self, kappa, a, omega, gamma)
      class(start_t), intent(inout) :: self
      !> 2 m g l / J₁ >= 0 and J₃Ω₃/J₁.
      real(wp), intent(in) :: kappa, a
      !> Angular velocity across the axis and unit vector of the vertical, in the frame of the top.
      real(wp), intent(in) :: omega(2), gamma(3)
      real(wp) :: across
      self%kappa = kappa
      self%a = a
      self%square = dot_product(omega, omega)
      self%g = dot_product(omega, gamma(1:2))
      across = dot_product(gamma(1:2), gamma(1:2))
      self%zeta = 1 - gamma(3)
      self%xi = 1 + gamma(3)
      if (gamma(3) > 0) then
         self%zeta = across/self%xi
      else
         self%xi = across/self%zeta
      end if
      self%speed = gamma(1)*omega(2) - gamma(2)*omega(1)
      self%acceleration = a*self%g - kappa*across/2 - gamma(3)*self%square
      self%phase = 0
      if (self%zeta > 0 .and. self%xi > 0) then
         self%phase(2) = atan2(gamma(2), gamma(1)) - pi/2
      else if (.not. self%square > 0) then
         self%phase = 0
      else if (self%xi > 0) then
         self%phase(2) = atan2(omega(2), omega(1))
      else
         self%phase(1) = atan2(omega(2), -omega(1))
      end if
   end subroutine set_start

   !> Returns true if the tilt is constant.
   pure logical function is_steady(self)
      class(start_t), intent(in) :: self
      is_steady = self%speed**2 < smallest .and. abs(self%acceleration) < smallest
   end function is_steady

   !> Computes range and parameters from the initial state.
   pure subroutine set_nutation(self, start)
      class(nutation_t), intent(inout) :: self
      !> Initial state; not steady.
      type(start_t), intent(in) :: start
      real(wp) :: lower, upper, outer, s, at_start(0:3), at_top(0:3), at_bottom(0:3)
      call expand(start, at_start, at_top, at_bottom)
      lower = root_towards(at_start, -start%xi)
      upper = root_towards(at_start, start%zeta)
      self%zeta(2) = start%zeta - upper
      self%xi(1) = start%xi + lower
      ! An end of the range next to the vertical is more accurate when computed from there.
      if (self%zeta(2) < start%zeta/4) then
         self%zeta(2) = root_towards(at_top, start%zeta)
         upper = start%zeta - self%zeta(2)
      end if
      if (self%xi(1) < start%xi/4) then
         self%xi(1) = root_towards(at_bottom, start%xi)
         lower = self%xi(1) - start%xi
      end if
      self%range = upper - lower
      self%zeta(1) = self%zeta(2) + self%range
      self%xi(2) = self%xi(1) + self%range
      ! s = κ(z₃ - z₁), outer = κ(z₃ - 1)
      if (start%kappa <= weak_gravity*(start%a**2 + start%square)) then
         s = -at_start(2) - start%kappa*(2*lower + upper)
         outer = s - start%kappa*self%zeta(1)
         self%m1 = 1 - start%kappa*self%range/s
      else
         outer = -start%kappa*root_towards(at_top, -(abs(at_start(2))/start%kappa + 6))
         s = outer + start%kappa*self%zeta(1)
         self%m1 = (outer + start%kappa*self%zeta(2))/s
      end if
      self%u_rate = sqrt(s)/2
      self%d_minus = sqrt(max(outer, 0.0_wp)/s)
      self%d_plus = sqrt((outer + 2*start%kappa)/s)
      self%sign_zeta = sign(1.0_wp, start%g - start%a*start%zeta)
      self%sign_xi = sign(1.0_wp, start%g + start%a*start%xi)
      self%sn0 = sign(sqrt(-lower/self%range), start%speed)
      self%cn0 = sqrt(upper/self%range)
      self%dn0 = sqrt(self%m1 + (start%kappa*self%range/s)*self%cn0**2)
   end subroutine set_nutation

   !> Computes the cubic as ż² about the initial z, and as -ż² in 1 - z and in 1 + z; coefficients of rising powers.
   pure subroutine expand(start, at_start, at_top, at_bottom)
      type(start_t), intent(in) :: start
      real(wp), intent(out) :: at_start(0:3), at_top(0:3), at_bottom(0:3)
      real(wp) :: difference, e
      at_start = [start%speed**2, 2*start%acceleration, &
         2*start%kappa*(start%xi - start%zeta)/2 - start%square - start%a**2, start%kappa]
      ! b - a and e - κ.
      difference = start%g - start%a*start%zeta
      e = start%square - start%kappa*start%zeta
      at_top = [difference**2, 2*(start%a*difference - e), start%a**2 + e - 2*start%kappa, start%kappa]
      ! b + a and e + κ.
      difference = start%g + start%a*start%xi
      e = start%square + start%kappa*start%xi
      at_bottom = [difference**2, -2*(start%a*difference + e), start%a**2 + e + 2*start%kappa, -start%kappa]
   end subroutine expand

   !> Returns the root nearest to zero, on the side of `bound`, of a real-rooted cubic: >= 0 at zero and <= 0 at
   !> `bound`.
   !>
   !> Laguerre's method converges to it monotonically from any point between it and zero; the geometric search for such
   !> a point keeps roots of all magnitudes equally cheap and equally accurate.
   pure real(wp) function root_towards(c, bound) result(x)
      !> Coefficients of rising powers.
      real(wp), intent(in) :: c(0:3)
      !> Bound beyond the root, and before the next one.
      real(wp), intent(in) :: bound
      !> Halvings of the exponent range and Laguerre steps at most.
      integer, parameter :: most_halvings = 1100, most_steps = 100
      real(wp) :: p(0:3), step, value, slope, root
      integer :: i
      p = c
      if (p(0) < smallest) then
         x = 0
         if (p(1)*bound <= 0) return
         ! Zero itself is the other root: divide by it.
         p = [c(1), c(2), c(3), 0.0_wp]*sign(1.0_wp, bound)
      end if
      x = bound
      do i = 1, most_halvings
         ! Not from the bound itself: it may be the next root.
         x = x/2
         if (evaluated(p, x) > 0 .or. .not. abs(x) > 0) exit
      end do
      do i = 1, most_steps
         value = evaluated(p, x)
         if (value <= 0) return
         slope = p(1) + x*(2*p(2) + x*3*p(3))
         root = sqrt(max(0.0_wp, 4*slope**2 - 6*value*(2*p(2) + 6*p(3)*x)))
         step = slope - sign(root, bound)
         if (.not. step*bound < 0) return
         step = -3*value/step
         if (abs(x + step) > abs(bound)) step = bound - x
         x = x + step
         if (abs(step) <= eps*abs(x)/4) return
      end do
   end function root_towards

   !> Returns the value of a cubic.
   pure real(wp) function evaluated(c, x)
      real(wp), intent(in) :: c(0:3), x
      evaluated = c(0) + x*(c(1) + x*(c(2) + x*c(3)))
   end function evaluated

   !> Returns ż at a phase.
   pure real(wp) function nutation_speed(self, phase) result(speed)
      class(nutation_t), intent(in) :: self
      type(elliptic_phase_t), intent(in) :: phase
      speed = 2*self%u_rate*self%range*phase%sn*phase%cn*phase%dn
   end function nutation_speed

   !> Returns b - a z at a tilt, from b ∓ a as the roots give them, so that its zeros are those of 1 ∓ z.
   pure real(wp) function node_rate(self, a, zeta, xi)
      class(nutation_t), intent(in) :: self
      !> J₃Ω₃/J₁.
      real(wp), intent(in) :: a
      !> 1 - z and 1 + z.
      real(wp), intent(in) :: zeta, xi
      if (zeta < xi) then
         node_rate = self%sign_zeta*2*self%u_rate*self%d_minus*sqrt(self%zeta(1)*self%zeta(2)) + a*zeta
      else
         node_rate = self%sign_xi*2*self%u_rate*self%d_plus*sqrt(self%xi(1)*self%xi(2)) - a*xi
      end if
   end function node_rate

end module nutate_nutation
