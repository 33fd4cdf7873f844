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
   use nutate_kinds, only: wp, eps, pi
   use nutate_principal_frame, only: check_frame, handedness, identity_frame, time_horizon, rotated
   use nutate_quaternion, only: attitude_distance, quat_conjugate, quat_exp, quat_norm, quat_normalized, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   implicit none
   private

   public :: free_body_t, free_motion_t, motion_of

   !> Ratio of the moments beyond which products of them could overflow.
   real(wp), parameter :: widest_ratio = 1.0e60_wp
   !> Binary exponent of the fastest rotation and of the greatest momentum that are admitted: 2¹²³ are left for
   !> factors.
   integer, parameter :: fastest_power = 900
   !> Rounding error of every datum and every angle in the estimate of the error: that of some ten operations on the way
   !> from the data to the rates. Twice the value that 2000 random bodies need (`make accuracy CASE=exact`).
   real(wp), parameter :: rounding = 2*eps
   !> Relative change of a datum whose response is scaled to that of a rounding: rounding hides no part of a larger
   !> change; limit of the response up to which it is scaled (rad).
   real(wp), parameter :: probe = 16*eps, too_far = 0.1_wp

   !> A body, its initial state, and the constants of its motion that are differentiated (`nutate_exact_tangent`).
   type :: free_motion_t
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
      !> √ρ = C/B as a ratio of the moments alone.
      real(wp) :: root_ratio = 1.0_wp
      type(elliptic_clock_t) :: clock
      type(winding_t) :: winding
      !> Moments and axes as they were given.
      real(wp) :: moments(3) = 1.0_wp, axes(3, 3) = identity_frame
   end type free_motion_t

   !> The solution for a body and its initial state.
   type :: free_body_t
      private
      type(free_motion_t) :: motion
      !> |l| / J_b, the linear part of the precession (rad/s).
      real(wp) :: precession = 0.0_wp
      !> Winding at t = 0 (rad).
      real(wp) :: winding0 = 0.0_wp
      !> Conjugate of the solution's quaternion at t = 0.
      real(wp) :: start(4) = 0.0_wp
      !> Times beyond +-horizon are treated as the horizon (s).
      real(wp) :: horizon = huge(1.0_wp)
   contains
      !> Sets body and initial state.
      procedure :: prepare
      !> Computes attitude and body momentum at a time.
      procedure :: evaluate
      !> Returns the period of the body momentum (s).
      procedure :: period
      !> Estimates the error of the attitude at a time.
      procedure :: round_off
   end type free_body_t

contains

   !> Sets body and initial state.
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
      self%motion%moments = moments
      self%motion%axes = principal
      self%motion%q0 = quat_normalized(q0)
      self%motion%momentum0 = momentum0
      component = matmul(transpose(principal), momentum0)
      self%motion%omega0 = matmul(principal, component/moments)
      self%motion%momentum = norm2(momentum0)
      self%horizon = time_horizon(exponent(self%motion%momentum) - exponent(minval(moments)))
      self%motion%steady = .not. self%motion%momentum > 0
      if (self%motion%steady) return
      ! Scaled first: numbers too small for all their digits still have a direction.
      component = scale(component, -exponent(maxval(abs(component))))
      call solve(self, moments, component/norm2(component), principal)
   end subroutine prepare

   !> Computes attitude and body momentum at a time.
   pure subroutine evaluate(self, t, q, momentum)
      class(free_body_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      !> Attitude, body -> space; a unit quaternion, continuous in t, with the sign of the initial one at t = 0.
      real(wp), intent(out) :: q(4)
      !> Angular momentum in body axes (kg m²/s).
      real(wp), intent(out) :: momentum(3)
      type(elliptic_phase_t) :: phase
      real(wp) :: time, direction(3), precession
      time = max(-self%horizon, min(t, self%horizon))
      if (self%motion%steady) then
         q = quat_product(self%motion%q0, quat_exp(0.5_wp*time*self%motion%omega0))
         momentum = self%motion%momentum0
         return
      end if
      phase = self%motion%clock%phase(time)
      direction = self%motion%amplitude*[phase%parity*phase%cn, phase%parity*phase%sn, phase%dn]
      precession = self%precession*time + self%motion%sense*(self%motion%winding%angle(phase) - self%winding0)
      q = rotated(self%motion%q0, self%motion%frame, &
                 quat_product(self%start, attitude(self, phase, direction, precession)))
      momentum = self%motion%momentum*matmul(self%motion%frame, direction)
   end subroutine evaluate

   !> Returns body, initial state and constants of a solution.
   pure type(free_motion_t) function motion_of(solution)
      !> Solution after `prepare`.
      type(free_body_t), intent(in) :: solution
      motion_of = solution%motion
   end function motion_of

   !> Returns the period of the body momentum (s): `huge` on the separatrix, 0 if the momentum is constant.
   pure real(wp) function period(self)
      class(free_body_t), intent(in) :: self
      period = 0
      if (.not. self%motion%steady) period = self%motion%clock%period()
   end function period

   !> Estimates the error of the attitude at a time that round-off makes (rad), π if no digit is left.
   !>
   !> Angles that grow with time, φ = rate·t, have the relative error of a rounding. The rates, the period and the
   !> distance from the separatrix have errors from the rounding of each datum: neighbouring solutions, each with one
   !> datum a little larger, give their effect at this time.
   pure real(wp) function round_off(self, t)
      class(free_body_t), intent(in) :: self
      !> Time (s), of either sign.
      real(wp), intent(in) :: t
      type(elliptic_phase_t) :: phase
      real(wp) :: q(4), momentum(3), moments(3), start(3)
      integer :: i
      call self%evaluate(t, q, momentum)
      if (self%motion%steady) then
         round_off = norm2(self%motion%omega0)*abs(t)
      else
         phase = self%motion%clock%phase(max(-self%horizon, min(t, self%horizon)))
         round_off = self%precession*abs(t) + abs(self%motion%winding%angle(phase) - self%winding0)
      end if
      round_off = rounding*(1 + round_off)
      do i = 1, 3
         moments = self%motion%moments
         start = self%motion%momentum0
         moments(i) = moments(i) + probe*merge(moments(i), maxval(moments), is_exact(self))
         call add_response(self, moments, start, t, q, round_off)
         start(i) = start(i) + probe*merge(start(i), norm2(start), is_exact(self))
         call add_response(self, self%motion%moments, start, t, q, round_off)
      end do
      round_off = min(round_off, pi)
   end function round_off

   !> Returns true if the principal components of the momentum are the data themselves: no product has rounded them.
   pure logical function is_exact(self)
      class(free_body_t), intent(in) :: self
      is_exact = all(abs(self%motion%axes - identity_frame) <= 0.0_wp) .and. count(abs(self%motion%q0) > 0.0_wp) == 1
   end function is_exact

   !> Adds the distance of a neighbouring solution from an attitude.
   pure subroutine add_response(self, moments, momentum0, t, q, total)
      class(free_body_t), intent(in) :: self
      !> Moments and body momentum at t = 0 of the neighbouring solution.
      real(wp), intent(in) :: moments(3), momentum0(3)
      !> Time, s; attitude of this solution at that time.
      real(wp), intent(in) :: t, q(4)
      !> Sum of the distances, rad.
      real(wp), intent(inout) :: total
      type(free_body_t) :: beside
      type(status_t) :: status
      real(wp) :: other(4), momentum(3), distance
      call beside%prepare(moments, self%motion%q0, momentum0, status, self%motion%axes)
      if (.not. status%ok()) return
      call beside%evaluate(t, other, momentum)
      distance = attitude_distance(q, other)
      total = total + merge(distance, distance*(rounding/probe), distance > too_far)
   end subroutine add_response

   !> Computes the constants of the motion for momentum > 0.
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
      ! Scaled by a power of two: the differences of the moments stay exact.
      power = exponent(maxval(moments))
      j = scale(moments, -power)
      rate = scale(self%motion%momentum, -power)
      call choose_axes(j, n, order)
      j = j(order)
      self%motion%steady = is_steady(j, n(order))
      if (self%motion%steady) return
      self%motion%sense = sign(1.0_wp, j(3) - j(2))
      signs = sign(1.0_wp, n(order))
      do i = 1, 3
         self%motion%frame(:, i) = signs(i)*principal(:, order(i))
      end do
      ! The sign of axis b is not free: the frame is right-handed.
      signs(2) = handedness(self%motion%frame)
      self%motion%frame(:, 2) = signs(2)*self%motion%frame(:, 2)
      call solve_ordered(self, j, abs(n(order)), signs(2), rate)
   end subroutine solve

   !> Computes the constants of the motion in the axes c, b, a.
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
      self%motion%root_ratio = sqrt(ratio)
      a = hypot(n(3), sqrt((cb/ca)*(j(3)/j(2)))*n(2))
      c = hypot(n(1), self%motion%root_ratio*n(2))
      y = sqrt((cb/ba)*(j(3)/j(1)))*n(1)
      m1 = max(0.0_wp, ((n(3) - y)/a)*((n(3) + y)/a))
      self%motion%amplitude = [c, self%motion%sense*c/self%motion%root_ratio, a]
      self%precession = rate/j(2)
      call self%motion%clock%set(a*rate*sqrt(ba*ca/(j(1)*j(2)))/j(3), m1, &
         self%motion%sense*sign_b*self%motion%root_ratio*n(2)/c, n(1)/c, n(3)/a)
      call self%motion%winding%set(ratio, (cb/ca)*(j(3)/j(2))/a, self%motion%clock%m1)
      phase = self%motion%clock%phase(0.0_wp)
      self%winding0 = self%motion%winding%angle(phase)
      self%start = quat_conjugate(attitude(self, phase, &
         self%motion%amplitude*[phase%parity*phase%cn, phase%parity*phase%sn, phase%dn], 0.0_wp))
   end subroutine solve_ordered

   !> Returns the quaternion of the axes c, b, a in a space frame whose third axis is l: precession, tilt, self rotation
   !> χ.
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
      chi = self%motion%sense*(atan2(phase%sn, self%motion%root_ratio*phase%cn) + pi*mod(phase%half_periods, 4.0_wp))
      ch = sqrt((1 + direction(3))/2)
      sh = hypot(direction(1), direction(2))/(2*ch)
      half_phi = cmplx(cos(precession/2), sin(precession/2), wp)
      half_chi = cmplx(cos(chi/2), sin(chi/2), wp)
      associate (minus => ch*half_phi*conjg(half_chi), plus => sh*half_phi*half_chi)
         g = [real(minus, wp), aimag(plus), -real(plus, wp), aimag(minus)]
      end associate
   end function attitude

   !> Finds the axes c, b, a: b has the middle moment, a is the side of the separatrix on which the momentum lies.
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
      order = merge([most, middle, least], [least, middle, most], about_least)
   end subroutine choose_axes

   !> Returns true if Euler's equations give no change: L × Ω = 0.
   pure logical function is_steady(j, n)
      !> Moments and direction of the momentum in the axes c, b, a.
      real(wp), intent(in) :: j(3), n(3)
      is_steady = .not. (abs((j(2) - j(3))*(n(2)*n(3))) > 0 .or. abs((j(3) - j(1))*(n(3)*n(1))) > 0 &
         .or. abs((j(1) - j(2))*(n(1)*n(2))) > 0)
   end function is_steady

   !> Rejects data that are not those of a body or of a state.
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
