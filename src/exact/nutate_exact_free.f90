!> The exact motion of a rigid body without torque.
!>
!> Euler's equations are solved by Jacobi's elliptic functions; the attitude follows from the constant space momentum l
!> and one angle, the precession about l, by an elliptic integral of the third kind (E. T. Whittaker, "A Treatise on
!> the Analytical Dynamics of Particles and Rigid Bodies", §69; R. van Zon, J. Schofield, J. Comput. Phys. 225 (2007)
!> 145-164 for the history of its numerics).
!>
!> Frame of the solution: the principal axes c, b, a, of which a is the extreme axis (least or greatest moment) whose
!> momentum never changes sign, b the intermediate and c the other extreme axis, with signs such that L_a > 0 and
!> L_c(0) >= 0. Then L_c = C cn u, L_b = σ B sn u, L_a = A dn u, σ = -1 for a the axis of least moment and +1 for that
!> of the greatest. The angle between l and a stays below 90 degrees, so that none of the formulas has a singular frame.
!> Everything is written in differences of the moments and in positive sums: equal and nearly equal moments, the
!> separatrix and its neighbourhood lose nothing but what the motion itself amplifies.
module nutate_exact_free
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_elliptic_phase, only: elliptic_clock_t, elliptic_phase_t, winding_t
   use nutate_kinds, only: wp, pi
   use nutate_principal_frame, only: check_frame, handedness, identity_frame, time_horizon, turned
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_norm, quat_normalized, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   implicit none
   private

   public :: free_body_t

   !> Ratio of the moments beyond which products of them could overflow.
   real(wp), parameter :: widest_ratio = 1.0e60_wp
   !> Binary exponent of the fastest rotation and of the greatest momentum that are admitted: 2¹²³ are left for
   !> factors.
   integer, parameter :: fastest_power = 900

   !> A body, its start, and the constants of its motion.
   type :: free_body_t
      private
      !> Attitude at t = 0.
      real(wp) :: q0(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Body momentum at t = 0 and the body angular velocity that goes with it.
      real(wp) :: momentum0(3) = 0.0_wp, omega0(3) = 0.0_wp
      !> The angular velocity is constant: sphere, rest, rotation about a principal axis.
      logical :: steady = .true.
      !> Columns: axes c, b, a of the solution in the user's body axes, right-handed.
      real(wp) :: frame(3, 3) = 0.0_wp
      !> |l|.
      real(wp) :: momentum = 0.0_wp
      !> C, σ B, A in units of |l|.
      real(wp) :: amplitude(3) = 0.0_wp
      !> σ.
      real(wp) :: sense = 1.0_wp
      !> |l| / J_b, the linear part of the precession (rad/s).
      real(wp) :: precession = 0.0_wp
      !> √ρ = C/B as a ratio of the moments alone.
      real(wp) :: root_ratio = 1.0_wp
      type(elliptic_clock_t) :: clock
      type(winding_t) :: winding
      !> Winding at t = 0 (rad).
      real(wp) :: winding0 = 0.0_wp
      !> Conjugate of the solution's quaternion at t = 0.
      real(wp) :: start(4) = 0.0_wp
      !> Times beyond +-horizon are taken as the horizon (s).
      real(wp) :: horizon = huge(1.0_wp)
   contains
      !> Set body and start.
      procedure :: prepare
      !> Attitude and body momentum at a time.
      procedure :: evaluate
      !> Period of the body momentum (s).
      procedure :: period
   end type free_body_t

contains

   !> Set body and start.
   pure subroutine prepare(self, moments, q0, momentum0, status, axes)
      class(free_body_t), intent(inout) :: self
      !> Principal moments of inertia (kg m²), all > 0, in any order; the triangle inequality is not required.
      real(wp), intent(in) :: moments(3)
      !> Attitude at t = 0, body -> space; is normalised.
      real(wp), intent(in) :: q0(4)
      !> Angular momentum L = J Ω at t = 0 in body axes (kg m²/s).
      real(wp), intent(in) :: momentum0(3)
      !> `NUTATE_BAD_BODY`: a moment is not positive and finite, or they differ by more than 1e60;
      !> `NUTATE_BAD_ARGUMENT`: no attitude, momentum not finite, axes not orthonormal.
      type(status_t), intent(out) :: status
      !> Columns: the principal axes in the user's body axes; absent: the body axes are the principal axes.
      real(wp), intent(in), optional :: axes(3, 3)
      real(wp) :: principal(3, 3), component(3)
      principal = identity_frame
      if (present(axes)) principal = axes
      call check_start(moments, q0, momentum0, principal, status)
      if (.not. status%ok()) return
      self%q0 = quat_normalized(q0)
      self%momentum0 = momentum0
      component = matmul(transpose(principal), momentum0)
      self%omega0 = matmul(principal, component/moments)
      self%momentum = norm2(momentum0)
      self%horizon = time_horizon(exponent(self%momentum) - exponent(minval(moments)))
      self%steady = .not. self%momentum > 0
      if (self%steady) return
      ! Scaled first: numbers too small for all their digits still have a direction.
      component = scale(component, -exponent(maxval(abs(component))))
      call solve(self, moments, component/norm2(component), principal)
   end subroutine prepare

   !> Attitude and body momentum at a time.
   pure subroutine evaluate(self, t, q, momentum)
      class(free_body_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      !> Attitude, body -> space; a unit quaternion, continuous in t and of the start's sign at t = 0.
      real(wp), intent(out) :: q(4)
      !> Angular momentum in body axes (kg m²/s).
      real(wp), intent(out) :: momentum(3)
      type(elliptic_phase_t) :: phase
      real(wp) :: time, direction(3), precession
      time = max(-self%horizon, min(t, self%horizon))
      if (self%steady) then
         q = quat_product(self%q0, quat_exp(0.5_wp*time*self%omega0))
         momentum = self%momentum0
         return
      end if
      phase = self%clock%phase(time)
      direction = self%amplitude*[phase%parity*phase%cn, phase%parity*phase%sn, phase%dn]
      precession = self%precession*time + self%sense*(self%winding%angle(phase) - self%winding0)
      q = turned(self%q0, self%frame, quat_product(self%start, attitude(self, phase, direction, precession)))
      momentum = self%momentum*matmul(self%frame, direction)
   end subroutine evaluate

   !> Period of the body momentum (s): `huge` on the separatrix, 0 where it is constant.
   pure real(wp) function period(self)
      class(free_body_t), intent(in) :: self
      period = 0
      if (.not. self%steady) period = self%clock%period()
   end function period

   !> Constants of the motion for momentum > 0.
   pure subroutine solve(self, moments, n, principal)
      class(free_body_t), intent(inout) :: self
      real(wp), intent(in) :: moments(3)
      !> L/|L| in principal axes.
      real(wp), intent(in) :: n(3)
      !> Columns: principal axes in body axes.
      real(wp), intent(in) :: principal(3, 3)
      integer :: order(3)
      real(wp) :: j(3), signs(3), rate
      integer :: i, power
      ! By a power of two: the differences of the moments stay exact.
      power = exponent(maxval(moments))
      j = scale(moments, -power)
      rate = scale(self%momentum, -power)
      call choose_axes(j, n, order)
      j = j(order)
      self%steady = is_steady(j, n(order))
      if (self%steady) return
      self%sense = sign(1.0_wp, j(3) - j(2))
      signs = sign(1.0_wp, n(order))
      do i = 1, 3
         self%frame(:, i) = signs(i)*principal(:, order(i))
      end do
      ! The sign of axis b is not free: the frame is right-handed.
      signs(2) = handedness(self%frame)
      self%frame(:, 2) = signs(2)*self%frame(:, 2)
      call solve_ordered(self, j, abs(n(order)), signs(2), rate)
   end subroutine solve

   !> Constants of the motion in the axes c, b, a.
   pure subroutine solve_ordered(self, j, n, sign_b, rate)
      class(free_body_t), intent(inout) :: self
      !> Moments of the axes c, b, a, in units of about the greatest.
      real(wp), intent(in) :: j(3)
      !> |L_c|, |L_b|, |L_a| at t = 0, in units of |L|.
      real(wp), intent(in) :: n(3)
      !> Sign of L_b at t = 0.
      real(wp), intent(in) :: sign_b
      !> |L| in units of J rad/s (rad/s).
      real(wp), intent(in) :: rate
      real(wp) :: ba, ca, cb, ratio, a, c, y, m1
      type(elliptic_phase_t) :: phase
      ba = abs(j(2) - j(3))
      ca = abs(j(1) - j(3))
      cb = abs(j(1) - j(2))
      ! ρ = α/β, 1 - ρ = γ/β with α, β, γ the differences of the 1/J: of a and b, a and c, b and c.
      ratio = (ba/ca)*(j(1)/j(2))
      self%root_ratio = sqrt(ratio)
      a = hypot(n(3), sqrt((cb/ca)*(j(3)/j(2)))*n(2))
      c = hypot(n(1), self%root_ratio*n(2))
      y = sqrt((cb/ba)*(j(3)/j(1)))*n(1)
      m1 = max(0.0_wp, ((n(3) - y)/a)*((n(3) + y)/a))
      self%amplitude = [c, self%sense*c/self%root_ratio, a]
      self%precession = rate/j(2)
      call self%clock%set(a*rate*sqrt(ba*ca/(j(1)*j(2)))/j(3), m1, &
         self%sense*sign_b*self%root_ratio*n(2)/c, n(1)/c, n(3)/a)
      call self%winding%set(ratio, (cb/ca)*(j(3)/j(2))/a, self%clock%m1)
      phase = self%clock%phase(0.0_wp)
      self%winding0 = self%winding%angle(phase)
      self%start = quat_conjugate(attitude(self, phase, &
         self%amplitude*[phase%parity*phase%cn, phase%parity*phase%sn, phase%dn], 0.0_wp))
   end subroutine solve_ordered

   !> Quaternion of the axes c, b, a in a space frame whose third axis is l: precession, tilt, self rotation χ.
   pure function attitude(self, phase, direction, precession) result(g)
      class(free_body_t), intent(in) :: self
      type(elliptic_phase_t), intent(in) :: phase
      !> L/|L| in the axes c, b, a.
      real(wp), intent(in) :: direction(3)
      !> Azimuth of the axis a about l (rad).
      real(wp), intent(in) :: precession
      real(wp) :: g(4), chi, ch, sh
      complex(wp) :: half_phi, half_chi
      ! L_b / L_c from the ratio of the amplitudes: defined, and smooth, where both vanish. Apart from the precession,
      ! which grows without bound, so that after any number of revolutions g still takes L to l.
      chi = self%sense*(atan2(phase%sn, self%root_ratio*phase%cn) + pi*mod(phase%half_periods, 4.0_wp))
      ch = sqrt((1 + direction(3))/2)
      sh = hypot(direction(1), direction(2))/(2*ch)
      half_phi = cmplx(cos(precession/2), sin(precession/2), wp)
      half_chi = cmplx(cos(chi/2), sin(chi/2), wp)
      associate (minus => ch*half_phi*conjg(half_chi), plus => sh*half_phi*half_chi)
         g = [real(minus, wp), aimag(plus), -real(plus, wp), aimag(minus)]
      end associate
   end function attitude

   !> The axes c, b, a: b has the middle moment, a is the side of the separatrix on which the momentum lies.
   pure subroutine choose_axes(j, n, order)
      !> Principal moments.
      real(wp), intent(in) :: j(3)
      !> Direction of the momentum in principal axes.
      real(wp), intent(in) :: n(3)
      !> Indices of c, b, a.
      integer, intent(out) :: order(3)
      integer :: least, middle, most
      logical :: about_least
      least = minloc(j, 1)
      most = 1 + mod(least, 3)
      middle = 1 + mod(most, 3)
      if (j(middle) > j(most)) then
         most = middle
         middle = 6 - least - most
      end if
      ! The sign of 2T J_b - L², without the difference of large terms.
      about_least = abs(n(least))*sqrt((j(middle) - j(least))*j(most)) >= &
         abs(n(most))*sqrt((j(most) - j(middle))*j(least))
      if (.not. j(middle) > j(least)) about_least = .false.
      if (about_least) then
         order = [most, middle, least]
      else
         order = [least, middle, most]
      end if
   end subroutine choose_axes

   !> True if Euler's equations give no change: L × Ω = 0.
   pure logical function is_steady(j, n)
      !> Moments and direction of the momentum in the axes c, b, a.
      real(wp), intent(in) :: j(3), n(3)
      is_steady = .not. (abs((j(2) - j(3))*(n(2)*n(3))) > 0 .or. abs((j(3) - j(1))*(n(3)*n(1))) > 0 &
         .or. abs((j(1) - j(2))*(n(1)*n(2))) > 0)
   end function is_steady

   !> Refuse what is not a body or not a state.
   pure subroutine check_start(moments, q0, momentum0, axes, status)
      real(wp), intent(in) :: moments(3), q0(4), momentum0(3), axes(3, 3)
      type(status_t), intent(out) :: status
      if (.not. all(ieee_is_finite(moments))) then
         status = fail(NUTATE_BAD_BODY, 'principal moments must be finite')
      else if (minval(moments) <= 0) then
         status = fail(NUTATE_BAD_BODY, 'principal moments must be positive')
      else if (maxval(moments)/widest_ratio > minval(moments)) then
         status = fail(NUTATE_BAD_BODY, 'principal moments differ by more than a factor of 1e60')
      else if (.not. (all(ieee_is_finite(q0)) .and. all(ieee_is_finite(momentum0)))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'attitude and momentum must be finite')
      else if (exponent(maxval(abs(momentum0))) > fastest_power .or. &
            scale(maxval(abs(momentum0)), -fastest_power) > minval(moments)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the momentum is too large for its square or its rates to be represented')
      else if (.not. quat_norm(q0) > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude quaternion is zero')
      else
         call check_frame(axes, status)
      end if
   end subroutine check_start

end module nutate_exact_free
