!> The clock of a motion that elliptic functions describe, and the angles of the third kind that go with it.
!>
!> An argument u = u₀ + rate t is split into complete half periods 2K and a rest |u| <= K. Angles are integrated once
!> over a half period and multiplied by their number; only the rest is integrated for each time. So a million periods
!> cost as much as one and lose only the rounding of their number. Both u₀ and the rest are kept as distances from the
!> nearer of the zeros of sn and cn: there, where angles change fast, they stay exact.
module nutate_elliptic_phase
   use nutate_carlson, only: carlson_rf, carlson_rj
   use nutate_elliptic, only: elliptic_k, jacobi
   use nutate_kinds, only: wp, pi
   implicit none
   private

   public :: elliptic_clock_t, elliptic_phase_t, winding_t, pole_integral

   !> Complementary parameter below which the motion is treated as the separatrix, whose period is infinite: it would
   !> stay at its saddle for more than 300 e-folding times.
   real(wp), parameter :: least_m1 = 1.0e-280_wp
   !> Ratio below which it is treated as zero: R_J requires more than the smallest numbers.
   real(wp), parameter :: least_ratio = 1.0e-300_wp

   !> Phase of the motion at a time.
   type :: elliptic_phase_t
      !> Number of complete half periods 2K passed.
      real(wp) :: half_periods = 0.0_wp
      !> Factor of sn and cn, (-1)^half_periods.
      real(wp) :: parity = 1.0_wp
      !> Jacobi's functions of the rest of the argument, -K <= u <= K: cn >= 0, dn >= 0.
      real(wp) :: sn = 0.0_wp, cn = 1.0_wp, dn = 1.0_wp
   end type elliptic_phase_t

   !> Clock of the motion, which gives the phase at a time.
   type :: elliptic_clock_t
      !> du/dt (rad/s), > 0.
      real(wp) :: rate = 0.0_wp
      !> Argument at t = 0 is origin K + start, |start| <= K/2; origin is -1, 0 or 1.
      real(wp) :: origin = 0.0_wp, start = 0.0_wp
      !> Complementary parameter; 0 on the separatrix.
      real(wp) :: m1 = 1.0_wp
      !> K; `huge` on the separatrix.
      real(wp) :: quarter = pi/2
   contains
      !> Sets the clock from the functions at t = 0.
      procedure :: set => set_clock
      !> Returns the phase at time t.
      procedure :: phase => phase_at
      !> Returns the period 4K/rate (s); `huge` on the separatrix.
      procedure :: period => period_of
   end type elliptic_clock_t

   !> The angle (weight/√ρ) ∫₀^u cn² / (cn² + sn²/ρ) du, weight² = (1 - ρ)(1 - m1 ρ), 0 <= ρ <= 1.
   !>
   !> The integrand peaks at sn = 0 and as ρ -> 0 becomes a jump by π per half period. By the interchange theorem of
   !> R_J (DLMF 19.21.12) the angle is atan(weight sn cn / (√ρ dn)) + √m1 weight P(m1 ρ), P the pole integral: two
   !> terms of one sign, the first of which is the jump.
   type :: winding_t
      !> ρ, 0 <= ρ <= 1.
      real(wp) :: ratio = 1.0_wp
      !> √((1 - ρ)(1 - m1 ρ)).
      real(wp) :: weight = 0.0_wp
      !> Complementary parameter.
      real(wp) :: m1 = 1.0_wp
      !> Angle from u = 0 to K (rad).
      real(wp) :: quarter = 0.0_wp
   contains
      !> Sets the constants.
      procedure :: set => set_winding
      !> Returns the angle from u = 0 to a phase (rad).
      procedure :: angle => winding_angle
   end type winding_t

contains

   !> Sets the clock from the functions at t = 0, cn >= 0 and dn >= 0; sn may have either sign.
   pure subroutine set_clock(self, rate, m1, sn, cn, dn)
      class(elliptic_clock_t), intent(inout) :: self
      !> du/dt (rad/s), > 0.
      real(wp), intent(in) :: rate
      !> Complementary parameter, >= 0.
      real(wp), intent(in) :: m1
      real(wp), intent(in) :: sn, cn, dn
      self%rate = rate
      self%m1 = m1
      if (m1 < least_m1) self%m1 = 0
      self%quarter = elliptic_k(self%m1)
      self%origin = 0
      if (dn**2 < sqrt(self%m1)) then
         ! Past the middle of the quarter period: the distance from K.
         self%origin = sign(1.0_wp, sn)
         self%start = -self%origin*(cn/dn)*carlson_rf((sn/dn)**2*self%m1, self%m1/dn**2, 1.0_wp)
      else if (dn < 1.0e-8_wp) then
         ! R_F(cn², dn², 1) if the squares would underflow.
         self%start = sign(log(4/max(cn + dn, tiny(1.0_wp))), sn)
      else
         self%start = sn*carlson_rf(cn**2, dn**2, 1.0_wp)
      end if
   end subroutine set_clock

   !> Returns the phase at time t.
   pure type(elliptic_phase_t) function phase_at(self, t) result(phase)
      class(elliptic_clock_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      real(wp) :: u, quarters, k1
      u = self%start + self%rate*t
      if (self%m1 <= 0) then
         call jacobi(u, 0.0_wp, phase%sn, phase%cn, phase%dn)
         return
      end if
      quarters = anint(u/self%quarter)
      u = u - quarters*self%quarter
      quarters = quarters + self%origin
      call jacobi(u, self%m1, phase%sn, phase%cn, phase%dn)
      if (abs(mod(quarters, 2.0_wp)) > 0.5_wp) then
         ! A quarter period on: sn, cn, dn become cn/dn, -k' sn/dn, k'/dn; the nearer half period is counted.
         k1 = sqrt(self%m1)
         quarters = quarters + sign(1.0_wp, phase%sn)
         phase = elliptic_phase_t(sn=sign(phase%cn/phase%dn, -phase%sn), cn=k1*abs(phase%sn)/phase%dn, dn=k1/phase%dn)
      end if
      phase%half_periods = quarters/2
      if (abs(mod(phase%half_periods, 2.0_wp)) > 0.5_wp) phase%parity = -1
   end function phase_at

   !> Returns the period 4K/rate (s); `huge` on the separatrix.
   pure real(wp) function period_of(self) result(period)
      class(elliptic_clock_t), intent(in) :: self
      period = huge(1.0_wp)
      if (self%m1 > 0) period = 4*self%quarter/self%rate
   end function period_of

   !> Sets the constants of a winding.
   pure subroutine set_winding(self, ratio, weight, m1)
      class(winding_t), intent(inout) :: self
      !> ρ, 0 <= ρ <= 1.
      real(wp), intent(in) :: ratio
      !> √((1 - ρ)(1 - m1 ρ)); the caller computes 1 - ρ without cancellation.
      real(wp), intent(in) :: weight
      !> Complementary parameter of the clock.
      real(wp), intent(in) :: m1
      self%ratio = ratio
      self%weight = weight
      self%m1 = m1
      self%quarter = 0
      if (m1 > 0) self%quarter = sqrt(m1)*weight*pole_integral(0.0_wp, sqrt(m1), 1.0_wp, m1*ratio)
   end subroutine set_winding

   !> Returns the angle from u = 0 to a phase (rad).
   pure real(wp) function winding_angle(self, phase) result(angle)
      class(winding_t), intent(in) :: self
      type(elliptic_phase_t), intent(in) :: phase
      real(wp) :: x, y
      ! On the separatrix cn = dn, and both vanish far out.
      y = self%weight*phase%sn
      x = sqrt(self%ratio)
      if (self%m1 > 0) then
         y = y*phase%cn
         x = x*phase%dn
      end if
      angle = 0
      if (abs(y) > 0) angle = atan2(y, x)
      if (self%m1 <= 0) return
      angle = angle + sqrt(self%m1)*self%weight*pole_integral(phase%cn, phase%dn, phase%sn, self%m1*self%ratio)
      angle = angle + 2*self%quarter*phase%half_periods
   end function winding_angle

   !> Returns P = ∫₀^u √x sn² du / (cn² + x sn²) = √x sn³/3 · R_J(cn², dn², 1, cn² + x sn²), |u| <= K.
   !>
   !> P stays bounded for x -> 0: 0 inside, π/(2 dn) at cn = 0.
   pure real(wp) function pole_integral(cn, dn, sn, x) result(p)
      !> Jacobi's functions of u, cn >= 0 and dn > 0.
      real(wp), intent(in) :: cn, dn, sn
      !> 0 <= x <= 1.
      real(wp), intent(in) :: x
      if (x < least_ratio) then
         p = 0
         if (cn <= 0) p = sign(pi/(2*dn), sn)
      else
         p = sqrt(x)*sn**3/3*carlson_rj(cn**2, dn**2, 1.0_wp, cn**2 + x*sn**2)
      end if
   end function pole_integral

end module nutate_elliptic_phase
