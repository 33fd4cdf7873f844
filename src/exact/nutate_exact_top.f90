!> The exact motion of Lagrange's top: a symmetric body, a fixed point on its axis, uniform gravity.
!>
!> With z = cos θ, a = J₃Ω₃/J₁, b = l_z/J₁, κ = 2 m g l/J₁, the tilt obeys ż² = (e - κz)(1 - z²) - (b - a z)², a cubic
!> with roots z₁ <= z₂ <= 1 <= z₃ (E. T. Whittaker, "A Treatise on the Analytical Dynamics of Particles and Rigid
!> Bodies", §71). Then z = z₁ cn² u + z₂ sn² u and u̇ = ½√(κ(z₃ - z₁)). Euler's angles are precession φ, tilt θ, spin ψ.
!> Only φ + ψ and φ - ψ are integrated, each of which needs one integral of the third kind and is smooth where the axis
!> passes the vertical: cos θ/2 exp(i(φ + ψ)/2) and sin θ/2 exp(i(φ - ψ)/2) are the quaternion.
!>
!> The roots are never subtracted from one another: each is found as a distance from a point next to it, from the cubic
!> expanded there (`nutate_nutation`). Steady precession, the sleeping top, its separatrix, pendulum motion through the
!> vertical and m g l = 0 are therefore no exceptions. For m g l < 0 the vertical is reversed.
module nutate_exact_top
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_elliptic_phase, only: elliptic_clock_t, elliptic_phase_t, pole_integral, winding_t
   use nutate_kinds, only: wp
   use nutate_nutation, only: nutation_t, start_t
   use nutate_principal_frame, only: check_frame, handedness, identity_frame, time_horizon, rotated
   use nutate_quaternion, only: quat_conjugate, quat_norm, quat_normalized, quat_product, rotate_to_body
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   implicit none
   private

   public :: lagrange_top_t

   !> Binary exponent of the fastest rate (rad/s) that is admitted: its square, and that of its inverse, stay in range.
   integer, parameter :: fastest_power = 400
   !> Value for sn or cn if the axis is exactly vertical, so that the limit is taken from one side; its square does not
   !> underflow.
   real(wp), parameter :: grazing = 1.0e-140_wp

   !> A top, its initial state, and the constants of its motion.
   type :: lagrange_top_t
      private
      !> Attitude at t = 0.
      real(wp) :: q0(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Columns: two transverse axes and the symmetry axis in the user's body axes, right-handed.
      real(wp) :: frame(3, 3) = identity_frame
      !> Moments across and along the symmetry axis (kg m²).
      real(wp) :: j1 = 1.0_wp, j3 = 1.0_wp
      !> Body rate about the symmetry axis (rad/s).
      real(wp) :: omega3 = 0.0_wp
      !> Sign of the vertical: -1 if it is reversed, else +1.
      real(wp) :: sense = 1.0_wp
      !> The tilt is constant.
      logical :: steady = .true.
      !> Initial state and shape of the nutation, rates in units of `rate_unit`.
      type(start_t) :: start
      type(nutation_t) :: nutation
      !> Unit of rates (rad/s), a power of two.
      real(wp) :: rate_unit = 1.0_wp
      type(elliptic_clock_t) :: clock
      !> Linear parts of (φ + ψ)/2 and (φ - ψ)/2 (rad/s).
      real(wp) :: rate(2) = 0.0_wp
      !> Periodic part of (φ + ψ)/2, and the factor and quarter period of that of (φ - ψ)/2.
      type(winding_t) :: winding
      real(wp) :: factor = 0.0_wp, quarter = 0.0_wp
      !> Phases (rad) that make the solution start at q0, and its conjugate quaternion there.
      real(wp) :: offset(2) = 0.0_wp, reference(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Times beyond +-horizon are treated as the horizon (s).
      real(wp) :: horizon = huge(1.0_wp)
   contains
      !> Sets top and initial state.
      procedure :: prepare
      !> Computes attitude and body momentum at a time.
      procedure :: evaluate
      !> Returns the tilt of the symmetry axis from the vertical at a time (rad).
      procedure :: tilt
      !> Returns the period of the tilt (s).
      procedure :: nutation_period
      !> Computes precession and spin rates averaged over the nutation.
      procedure :: mean_rates
   end type lagrange_top_t

contains

   !> Sets top and initial state.
   pure subroutine prepare(self, j1, j3, mgl, q0, momentum0, status, axes, up)
      class(lagrange_top_t), intent(inout) :: self
      !> Moments about the fixed point, across and along the symmetry axis (kg m²), > 0.
      real(wp), intent(in) :: j1, j3
      !> m g times the distance of the centre of mass from the fixed point along axis 3 (N m), of either sign:
      !> V = m g l cos θ.
      real(wp), intent(in) :: mgl
      !> Attitude at t = 0, body -> space; is normalised.
      real(wp), intent(in) :: q0(4)
      !> Angular momentum L = J Ω about the fixed point at t = 0 in body axes (kg m²/s).
      real(wp), intent(in) :: momentum0(3)
      !> `NUTATE_BAD_BODY`: moments not positive and finite; `NUTATE_BAD_ARGUMENT`: anything else out of range.
      type(status_t), intent(out) :: status
      !> Columns: axes 1, 2 and the symmetry axis 3 in the user's body axes; absent: the body axes.
      real(wp), intent(in), optional :: axes(3, 3)
      !> Direction of the upward vertical in space, of any length; absent: space axis 3.
      real(wp), intent(in), optional :: up(3)
      real(wp) :: vertical(3), gamma(3), omega(3)
      self%frame = identity_frame
      if (present(axes)) self%frame = axes
      vertical = identity_frame(:, 3)
      if (present(up)) vertical = up
      call check_input(j1, j3, [mgl, momentum0], [q0, vertical], self%frame, status)
      if (.not. status%ok()) return
      if (handedness(self%frame) < 0) self%frame(:, 2) = -self%frame(:, 2)
      self%q0 = quat_normalized(q0)
      self%j1 = j1
      self%j3 = j3
      self%sense = sign(1.0_wp, mgl)
      omega = matmul(transpose(self%frame), momentum0)/[j1, j1, j3]
      vertical = vertical/maxval(abs(vertical))
      gamma = self%sense*matmul(transpose(self%frame), rotate_to_body(self%q0, vertical/norm2(vertical)))
      call solve(self, 2*(abs(mgl)/j1), omega, gamma/norm2(gamma))
   end subroutine prepare

   !> Computes attitude and body momentum at a time.
   pure subroutine evaluate(self, t, q, momentum)
      class(lagrange_top_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      !> Attitude, body -> space; a unit quaternion.
      real(wp), intent(out) :: q(4)
      !> Angular momentum in body axes (kg m²/s).
      real(wp), intent(out) :: momentum(3)
      type(elliptic_phase_t) :: phase
      real(wp) :: angle(2), zeta, xi
      complex(wp) :: half(2), across
      call state(self, t, phase, angle, zeta, xi)
      half = half_angles(angle)
      q = rotated(self%q0, self%frame, quat_product(self%reference, quaternion(sqrt(xi/2), sqrt(zeta/2), half)))
      across = 0
      if (zeta > 0 .and. xi > 0) then
         ! Along and across the line of nodes: from ż and b - a z.
         across = cmplx(0.0_wp, self%start%g, wp)
         if (.not. self%steady) &
            across = cmplx(-self%nutation%speed(phase), self%nutation%node_rate(self%start%a, zeta, xi), wp)
         across = across/(sqrt(zeta)*sqrt(xi))
      end if
      ! With the same spin ψ as the quaternion: the momentum about the vertical is then right for all times.
      across = self%j1*self%rate_unit*across*conjg(half(2))**2
      momentum = matmul(self%frame, [real(across, wp), aimag(across), self%j3*self%omega3])
   end subroutine evaluate

   !> Returns the tilt of the symmetry axis from the upward vertical at a time (rad), 0 to π.
   pure real(wp) function tilt(self, t)
      class(lagrange_top_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      type(elliptic_phase_t) :: phase
      real(wp) :: angle(2), zeta, xi
      call state(self, t, phase, angle, zeta, xi)
      tilt = 2*atan2(sqrt(zeta), sqrt(xi))
      if (self%sense < 0) tilt = 2*atan2(sqrt(xi), sqrt(zeta))
   end function tilt

   !> Returns the period of the tilt (s): `huge` on the separatrix, 0 if the tilt is constant.
   pure real(wp) function nutation_period(self) result(period)
      class(lagrange_top_t), intent(in) :: self
      period = 0
      if (self%steady) return
      period = self%clock%period()
      if (self%clock%m1 > 0) period = period/2
   end function nutation_period

   !> Computes precession and spin rates averaged over the nutation: advance per nutation period / period.
   !>
   !> For an axis that passes exactly through the vertical, half a revolution of one sign or the other per passage is a
   !> convention; for an axis that stays vertical all of the rotation is called spin.
   pure subroutine mean_rates(self, precession, spin)
      class(lagrange_top_t), intent(in) :: self
      !> Mean φ̇ about the upward vertical (rad/s).
      real(wp), intent(out) :: precession
      !> Mean ψ̇ about the symmetry axis (rad/s).
      real(wp), intent(out) :: spin
      real(wp) :: half(2)
      half = self%rate
      if (.not. self%steady .and. self%clock%m1 > 0) half = half + 2*self%clock%rate* &
         ([self%nutation%sign_xi*self%winding%quarter, self%nutation%sign_zeta*self%quarter]/(2*self%clock%quarter))
      precession = self%sense*(half(1) + half(2))
      spin = half(1) - half(2)
      if (.not. self%steady) return
      if (self%start%zeta > 0 .and. self%start%xi > 0) return
      precession = 0
      spin = self%omega3
   end subroutine mean_rates

   !> Computes the constants of the motion.
   pure subroutine solve(self, kappa, omega, gamma)
      class(lagrange_top_t), intent(inout) :: self
      !> 2 m g l / J₁ (rad²/s²), >= 0.
      real(wp), intent(in) :: kappa
      !> Angular velocity (rad/s) and direction of the vertical, in the frame of the top.
      real(wp), intent(in) :: omega(3), gamma(3)
      real(wp) :: a, fastest
      self%omega3 = omega(3)
      a = (self%j3/self%j1)*omega(3)
      fastest = max(maxval(abs(omega)), abs(a), sqrt(kappa))
      self%horizon = time_horizon(exponent(fastest))
      fastest = max(maxval(abs(omega(1:2))), abs(a), sqrt(kappa))
      self%rate_unit = 1
      if (fastest > 0) self%rate_unit = scale(1.0_wp, max(exponent(fastest), -fastest_power))
      call self%start%set(kappa/self%rate_unit**2, a/self%rate_unit, omega(1:2)/self%rate_unit, gamma)
      self%steady = self%start%is_steady()
      self%reference = quat_conjugate(quaternion(sqrt(self%start%xi/2), sqrt(self%start%zeta/2), &
         half_angles(self%start%phase)))
      self%offset = self%start%phase
      if (self%steady) then
         self%rate = [omega(3), -omega(3)]/2
         if (self%start%xi > 0) self%rate(1) = self%rate(1) + self%rate_unit*self%start%g/(2*self%start%xi)
         if (self%start%zeta > 0) self%rate(2) = self%rate(2) + self%rate_unit*self%start%g/(2*self%start%zeta)
         return
      end if
      call self%nutation%set(self%start)
      call solve_angles(self)
   end subroutine solve

   !> Computes the clock and the angles of a motion with nutation.
   pure subroutine solve_angles(self)
      class(lagrange_top_t), intent(inout) :: self
      type(elliptic_phase_t) :: phase
      real(wp) :: u_rate
      associate (n => self%nutation, s => self%start)
         u_rate = n%u_rate*self%rate_unit
         call self%clock%set(u_rate, n%m1, n%sn0, n%cn0, n%dn0)
         call self%winding%set(n%xi(1)/n%xi(2), (n%range/n%xi(2))*n%d_plus, self%clock%m1)
         self%factor = n%d_minus*(n%range/n%zeta(1))
         self%quarter = 0
         if (self%clock%m1 > 0) self%quarter = self%factor* &
            pole_integral(0.0_wp, sqrt(self%clock%m1), 1.0_wp, n%zeta(2)/n%zeta(1))
         self%rate(1) = (self%omega3 - s%a*self%rate_unit)/2 + n%sign_xi*n%d_plus*sqrt(n%xi(1)/n%xi(2))*u_rate
         self%rate(2) = (s%a*self%rate_unit - self%omega3)/2 + n%sign_zeta*n%d_minus*sqrt(n%zeta(2)/n%zeta(1))*u_rate
         phase = self%clock%phase(0.0_wp)
         ! For a vertical axis the angles are those of the moment after t = 0.
         if (.not. s%zeta > 0) phase = elliptic_phase_t(1.0_wp, -1.0_wp, -1.0_wp, grazing, sqrt(self%clock%m1))
         if (.not. s%xi > 0) phase = elliptic_phase_t(0.0_wp, 1.0_wp, grazing, 1.0_wp, 1.0_wp)
         self%offset = s%phase - [n%sign_xi*self%winding%angle(phase), n%sign_zeta*node_angle(self, phase)]
      end associate
   end subroutine solve_angles

   !> Computes phase, angles and tilt at time t.
   pure subroutine state(self, t, phase, angle, zeta, xi)
      class(lagrange_top_t), intent(in) :: self
      real(wp), intent(in) :: t
      type(elliptic_phase_t), intent(out) :: phase
      !> (φ + ψ)/2 and (φ - ψ)/2 (rad).
      real(wp), intent(out) :: angle(2)
      !> 1 - cos θ and 1 + cos θ.
      real(wp), intent(out) :: zeta, xi
      real(wp) :: time
      time = max(-self%horizon, min(t, self%horizon))
      angle = self%rate*time + self%offset
      zeta = self%start%zeta
      xi = self%start%xi
      if (self%steady) return
      phase = self%clock%phase(time)
      phase%cn = max(phase%cn, grazing)
      phase%dn = max(phase%dn, grazing)
      phase%sn = sign(max(abs(phase%sn), grazing), phase%sn)
      associate (n => self%nutation)
         angle = angle + [n%sign_xi*self%winding%angle(phase), n%sign_zeta*node_angle(self, phase)]
         zeta = n%zeta(1)*phase%cn**2 + n%zeta(2)*phase%sn**2
         xi = n%xi(1)*phase%cn**2 + n%xi(2)*phase%sn**2
      end associate
   end subroutine state

   !> Returns the periodic part of (φ - ψ)/2 for b > a (rad); on the separatrix, where b = a, there is none.
   pure real(wp) function node_angle(self, phase) result(angle)
      class(lagrange_top_t), intent(in) :: self
      type(elliptic_phase_t), intent(in) :: phase
      angle = 0
      if (self%clock%m1 <= 0) return
      angle = self%factor*pole_integral(phase%cn, phase%dn, phase%sn, self%nutation%zeta(2)/self%nutation%zeta(1)) &
         + 2*self%quarter*phase%half_periods
   end function node_angle

   !> Returns exp(iφ/2) and exp(iψ/2) from the angles (φ + ψ)/2 and (φ - ψ)/2.
   pure function half_angles(angle) result(half)
      !> (φ + ψ)/2 and (φ - ψ)/2 (rad).
      real(wp), intent(in) :: angle(2)
      complex(wp) :: half(2)
      real(wp) :: phi, psi
      phi = (angle(1) + angle(2))/2
      psi = (angle(1) - angle(2))/2
      half = [cmplx(cos(phi), sin(phi), wp), cmplx(cos(psi), sin(psi), wp)]
   end function half_angles

   !> Returns the quaternion from cos θ/2, sin θ/2 and exp(iφ/2), exp(iψ/2).
   pure function quaternion(cosine, sine, half) result(q)
      real(wp), intent(in) :: cosine, sine
      complex(wp), intent(in) :: half(2)
      real(wp) :: q(4)
      complex(wp) :: sum, difference
      sum = cosine*half(1)*half(2)
      difference = sine*half(1)*conjg(half(2))
      q = [real(sum, wp), real(difference, wp), aimag(difference), aimag(sum)]
   end function quaternion

   !> Rejects data that are not those of a top or of a state.
   pure subroutine check_input(j1, j3, torque_momentum, attitude_up, axes, status)
      real(wp), intent(in) :: j1, j3
      !> m g l and the momentum.
      real(wp), intent(in) :: torque_momentum(4)
      !> Attitude and vertical.
      real(wp), intent(in) :: attitude_up(7)
      real(wp), intent(in) :: axes(3, 3)
      type(status_t), intent(out) :: status
      if (.not. (ieee_is_finite(j1) .and. ieee_is_finite(j3))) then
         status = fail(NUTATE_BAD_BODY, 'moments of inertia must be finite')
      else if (min(j1, j3) <= 0) then
         status = fail(NUTATE_BAD_BODY, 'moments of inertia must be positive')
      else if (scale(max(j1, j3), -fastest_power) > min(j1, j3)) then
         status = fail(NUTATE_BAD_BODY, 'moments of inertia differ too much')
      else if (.not. (all(ieee_is_finite(torque_momentum)) .and. all(ieee_is_finite(attitude_up)))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'torque, momentum, attitude and vertical must be finite')
      else if (scale(maxval(abs(torque_momentum)), -fastest_power) > min(j1, j3)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'torque or momentum is too large for its rates to be represented')
      else if (.not. quat_norm(attitude_up(1:4)) > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude quaternion is zero')
      else if (.not. maxval(abs(attitude_up(5:7))) > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the vertical has no direction')
      else
         call check_frame(axes, status)
      end if
   end subroutine check_input

end module nutate_exact_top
