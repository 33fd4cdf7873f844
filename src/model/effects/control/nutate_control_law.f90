!> Control laws: torques that follow from attitude and rate, to point a body or to stop its tumbling.
!>
!> **Pointing**, the quaternion law of Wie, Weiss and Arapostathis (1989): with e = q_t*∘q, the attitude relative to the
!> target,
!>
!>     τ = -K sgn(e₀) e_v - D Ω
!>
!> K and D are the gains times the inertia of the body, or times the unit matrix; e₀ = 0 is treated as positive. With
!> wheels, their motors give -τ, shared by the pseudo-inverse of the axes. With magnetorquers, the body has the moment
!> m = B×τ/|B|² in the field B, which gives the part of τ across B.
!>
!> **Detumbling**, B-dot: m = -k Ḃ, Ḃ = B×Ω + R(q)ᵀ∂b/∂t the change of the field B = R(q)ᵀb in body axes, the same in
!> space axes of any rotation. With sampling, Ḃ is the difference of the last two samples of B over the time between
!> them, and zero at the first sample.
!>
!> The field is constant in space axes, or is that of the Earth along an orbit.
module nutate_control_law
   use nutate_effect, only: torque_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t, change_by_axis, change_by_orbit, rate_change_by_orbit, &
      with_axis
   use nutate_kepler_orbit, only: axes_change
   use nutate_kinds, only: wp
   use nutate_orbit, only: orbit_t, axes_rate_change
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body
   use nutate_small_products, only: times_vector
   implicit none
   private

   public :: control_law_t

   !> Control laws, and the actuators by which they act.
   integer, parameter, public :: POINTING = 1, DETUMBLING = 2
   integer, parameter, public :: BY_TORQUE = 1, BY_WHEELS = 2, BY_MAGNETORQUERS = 3

   !> A law with its gains, its target and its field.
   type, abstract, extends(torque_t) :: control_law_t
      !> `POINTING` or `DETUMBLING`; `BY_TORQUE`, `BY_WHEELS` or `BY_MAGNETORQUERS`: only magnetorquers detumble.
      integer :: law = POINTING, by = BY_TORQUE
      !> Target attitude q_t, body→space, unit quaternion; shape (4). If `follows_orbit`, body→LVLH frame: the LVLH
      !> frame of the orbit of the body replaces the space axes (`follow_orbit`).
      real(wp) :: target(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      logical :: follows_orbit = .false.
      type(orbit_t) :: orbit = orbit_t()
      !> K, N m, and D, N m s, body axes; shape (3,3).
      real(wp) :: attitude_gain(3, 3) = 0.0_wp, rate_gain(3, 3) = 0.0_wp
      !> k, A m² s/T.
      real(wp) :: gain = 0.0_wp
      !> Field b, space axes, T; shape (3). If `follows_earth`, the field of the Earth replaces it (`follow`).
      real(wp) :: field(3) = 0.0_wp
      logical :: follows_earth = .false.
      type(geomagnetic_field_t) :: earth = geomagnetic_field_t()
   contains
      !> Uses the field of the Earth for the magnetorquers.
      procedure :: follow
      !> Refers the target to the LVLH frame.
      procedure :: follow_orbit
      !> Return the commanded torque, and its change by a change of `parameters`.
      procedure, non_overridable :: law_torque
      procedure, non_overridable :: law_change
      procedure :: command
      procedure :: error_scalar, error_angle
      !> Returns the magnetic field in body axes.
      procedure, non_overridable :: field_at
      !> Returns a command with the saturated components set to the limit.
      procedure, non_overridable :: cut_off
      !> Computes the derivatives of the torque by one small rotation, and by one component of Ω.
      procedure, non_overridable :: differentiate
      procedure :: torque_change => controlling_change
   end type control_law_t

contains

   !> Uses the field of the Earth for the magnetorquers, instead of the fixed `field`.
   pure subroutine follow(self, earth)
      class(control_law_t), intent(inout) :: self
      !> Field of the Earth along the orbit, in the space axes of the scene.
      type(geomagnetic_field_t), intent(in) :: earth
      self%follows_earth = .true.
      self%earth = earth
      self%moves = .true.
      self%pace = earth%pace()
   end subroutine follow

   !> Refers the target to the LVLH frame of an orbit. Nothing changes if the space axes are the LVLH frame.
   pure subroutine follow_orbit(self, orbit)
      class(control_law_t), intent(inout) :: self
      type(orbit_t), intent(in) :: orbit
      self%follows_orbit = .not. orbit%is_frame
      self%orbit = orbit
   end subroutine follow_orbit

   !> Returns the magnetic field B in body axes, T; shape (3).
   pure function field_at(self, t, q) result(b)
      class(control_law_t), intent(in) :: self
      !> Time, s; attitude, unit quaternion, body→space, shape (4).
      real(wp), intent(in) :: t, q(4)
      real(wp) :: b(3)
      b = self%field
      if (self%follows_earth) b = self%earth%at(t)
      b = rotate_to_body(q, b)
   end function field_at

   !> Computes B in body axes, and the part of its rate by which it changes in the space axes: Ḃ = B×Ω + R(q)ᵀ∂b/∂t.
   pure subroutine find_field(self, t, q, b, drift)
      class(control_law_t), intent(in) :: self
      !> Time and attitude as in `law_torque`.
      real(wp), intent(in) :: t, q(4)
      !> B, T, and R(q)ᵀ∂b/∂t, T/s, body axes; shapes (3).
      real(wp), intent(out) :: b(3), drift(3)
      b = self%field
      drift = 0.0_wp
      if (self%follows_earth) then
         call self%earth%find(t, b, drift)
         drift = rotate_to_body(q, drift)
      end if
      b = rotate_to_body(q, b)
   end subroutine find_field

   !> Returns the torque that the control law commands, before the limit, body axes, N m; shape (3): -K sgn(e₀) e_v - D
   !> Ω, or m×B with m = -k Ḃ. Source: Wie, Weiss and Arapostathis (1989) for pointing; B-dot for detumbling.
   pure function law_torque(self, t, q, omega) result(tau)
      class(control_law_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω relative to the space axes, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: tau(3), b(3), drift(3)
      if (self%law == DETUMBLING) then
         call find_field(self, t, q, b, drift)
         tau = -self%gain*cross(cross(b, omega) + drift, b)
      else
         tau = pointing_torque(self, t, q, omega)
         if (self%by == BY_MAGNETORQUERS) tau = across(self%field_at(t, q), tau)
      end if
   end function law_torque

   !> Returns the command to which the limit applies: the torque, N m, or the moment of the magnetorquers, A m²; body
   !> axes, shape (3).
   pure function command(self, t, q, omega)
      class(control_law_t), intent(in) :: self
      !> Time, attitude and Ω as in `law_torque`.
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: command(3), b(3), drift(3)
      if (self%by /= BY_MAGNETORQUERS) then
         command = self%law_torque(t, q, omega)
      else if (self%law == DETUMBLING) then
         call find_field(self, t, q, b, drift)
         command = -self%gain*(cross(b, omega) + drift)
      else
         command = moment_for(self%field_at(t, q), self%law_torque(t, q, omega))
      end if
   end function command

   !> Returns B×τ/|B|², or zero without a field; shape (3).
   pure function moment_for(b, tau) result(moment)
      real(wp), intent(in) :: b(3), tau(3)
      real(wp) :: moment(3), size
      moment = 0.0_wp
      size = maxval(abs(b))
      if (size > 0.0_wp) moment = cross(b/size, tau)/(size*dot_product(b/size, b/size))
   end function moment_for

   !> Returns -K sgn(e₀) e_v - D Ω, with Ω relative to the axes of the target.
   pure function pointing_torque(self, t, q, omega) result(tau)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3), e(4)
      e = error_of(self, t, q)
      tau = -times_vector(self%attitude_gain, e(2:4)) - times_vector(self%rate_gain, omega - rate_of_target(self, t, q))
   end function pointing_torque

   !> Returns e₀ with its own sign.
   pure real(wp) function error_scalar(self, t, q)
      class(control_law_t), intent(in) :: self
      !> Time, s; attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: t, q(4)
      real(wp) :: e(4)
      e = seen_from_target(self, t, q)
      error_scalar = e(1)
   end function error_scalar

   !> Returns the angle of the rotation from the target to the attitude, 0 to π, rad.
   pure real(wp) function error_angle(self, t, q)
      class(control_law_t), intent(in) :: self
      !> Time and attitude as in `error_scalar`.
      real(wp), intent(in) :: t, q(4)
      real(wp) :: e(4)
      e = seen_from_target(self, t, q)
      error_angle = 2*atan2(norm2(e(2:4)), abs(e(1)))
   end function error_angle

   !> Returns q_t*∘q, the attitude relative to the target; shape (4).
   pure function seen_from_target(self, t, q) result(e)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4)
      real(wp) :: e(4), target(4)
      target = self%target
      if (self%follows_orbit) target = quat_product(self%orbit%axes(t), target)
      e = quat_product(quat_conjugate(target), q)
   end function seen_from_target

   !> Returns sgn(e₀) e; shape (4).
   pure function error_of(self, t, q) result(e)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4)
      real(wp) :: e(4)
      e = seen_from_target(self, t, q)
      if (self%sense /= 0) then
         e = self%sense*e
      else if (e(1) < 0.0_wp) then
         e = -e
      end if
   end function error_of

   !> Returns the rate of the target relative to the space axes, body axes, rad/s; shape (3).
   pure function rate_of_target(self, t, q) result(rate)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4)
      real(wp) :: rate(3)
      rate = 0.0_wp
      if (self%follows_orbit) rate = rotate_to_body(q, self%orbit%axes_rate(t))
   end function rate_of_target

   !> Returns the part of a vector across b, or zero if b is zero; shape (3).
   pure function across(b, v) result(part)
      real(wp), intent(in) :: b(3), v(3)
      real(wp) :: part(3), unit(3)
      part = 0.0_wp
      if (.not. maxval(abs(b)) > 0.0_wp) return
      unit = b/maxval(abs(b))
      part = v - (dot_product(unit, v)/dot_product(unit, unit))*unit
   end function across

   !> Returns a torque or moment with the saturated components set to the limit; shape (3).
   pure function cut_off(self, amount) result(cut)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: amount(3)
      real(wp) :: cut(3)
      cut = amount
      where (self%saturated /= 0) cut = self%saturated*self%limit
   end function cut_off

   !> Computes the derivatives of a torque that acts at all times by one small rotation θ of the body, which changes e_v
   !> by ½(e₀θ + e_v×θ) and B by B×θ, and by one component of Ω.
   pure subroutine differentiate(self, t, q, omega, b, theta, by_rotation, by_rate)
      class(control_law_t), intent(in) :: self
      !> Time, s; attitude, unit quaternion, body→space, and Ω, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: t, q(4), omega(3)
      !> B, body axes, T; unit vector along θ and along the component of Ω; shape (3).
      real(wp), intent(in) :: b(3), theta(3)
      !> Derivatives by the rotation, N m, and by the rate, N m s; body axes; shape (3).
      real(wp), intent(out) :: by_rotation(3), by_rate(3)
      real(wp) :: field(3), drift(3)
      if (any(self%saturated /= 0)) then
         call differentiate_cut(self, t, q, omega, b, theta, by_rotation, by_rate)
      else if (self%law == DETUMBLING) then
         call find_field(self, t, q, field, drift)
         by_rotation = -self%gain*(cross(rate_by_rotation(field, drift, omega, theta), b) + &
                                   cross(cross(field, omega) + drift, cross(b, theta)))
         by_rate = -self%gain*cross(cross(b, theta), b)
      else
         call differentiate_pointing(self, t, q, omega, b, theta, by_rotation, by_rate)
      end if
   end subroutine differentiate

   !> Returns the change of Ḃ by a small rotation of the body; shape (3).
   pure function rate_by_rotation(b, drift, omega, theta) result(change)
      !> B and R(q)ᵀ∂b/∂t as in `find_field`, Ω as in `law_torque`; unit vector along the rotation.
      real(wp), intent(in) :: b(3), drift(3), omega(3), theta(3)
      real(wp) :: change(3)
      change = cross(cross(b, theta), omega) + cross(drift, theta)
   end function rate_by_rotation

   !> Computes the derivatives of the quaternion law by one small rotation, and by one component of Ω.
   pure subroutine differentiate_pointing(self, t, q, omega, b, theta, by_rotation, by_rate)
      class(control_law_t), intent(in) :: self
      !> B, body axes, T, shape (3); unit vector along the rotation and along the component of Ω.
      real(wp), intent(in) :: t, q(4), omega(3), b(3), theta(3)
      real(wp), intent(out) :: by_rotation(3), by_rate(3)
      real(wp) :: tau(3), unit(3), change(3)
      by_rotation = change_by_rotation(self, t, q, theta)
      by_rate = -times_vector(self%rate_gain, theta)
      if (self%by /= BY_MAGNETORQUERS) return
      by_rotation = across(b, by_rotation)
      by_rate = across(b, by_rate)
      if (.not. maxval(abs(b)) > 0.0_wp) return
      unit = b/maxval(abs(b))
      unit = unit/norm2(unit)
      change = cross(unit, theta)
      tau = pointing_torque(self, t, q, omega)
      by_rotation = by_rotation - dot_product(unit, tau)*change - dot_product(change, tau)*unit
   end subroutine differentiate_pointing

   !> Returns the change of `pointing_torque` by a small rotation; the rate of the target, r, changes by r×θ.
   pure function change_by_rotation(self, t, q, theta) result(change)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), theta(3)
      real(wp) :: change(3), e(4)
      e = error_of(self, t, q)
      change = -0.5_wp*times_vector(self%attitude_gain, e(1)*theta + cross(e(2:4), theta))
      if (self%follows_orbit) &
         change = change + times_vector(self%rate_gain, cross(rate_of_target(self, t, q), theta))
   end function change_by_rotation

   !> Computes the derivatives of a torque, or of m×B, if components of it, or of m, are at the limit and do not change.
   pure subroutine differentiate_cut(self, t, q, omega, b, theta, by_rotation, by_rate)
      class(control_law_t), intent(in) :: self
      !> B, body axes, T, shape (3); unit vector along the rotation and along the component of Ω.
      real(wp), intent(in) :: t, q(4), omega(3), b(3), theta(3)
      real(wp), intent(out) :: by_rotation(3), by_rate(3)
      real(wp) :: rotated(3), field(3), drift(3)
      rotated = cross(b, theta)
      if (self%law == DETUMBLING) then
         call find_field(self, t, q, field, drift)
         by_rotation = -self%gain*rate_by_rotation(field, drift, omega, theta)
         by_rate = -self%gain*rotated
      else
         by_rotation = change_by_rotation(self, t, q, theta)
         by_rate = -times_vector(self%rate_gain, theta)
         if (self%by == BY_MAGNETORQUERS) then
            ! |B| does not change; in B×τ/|B|² both B and τ do.
            by_rotation = moment_for(b, by_rotation)
            if (maxval(abs(b)) > 0.0_wp) by_rotation = by_rotation + &
               cross(rotated/norm2(b), pointing_torque(self, t, q, omega)/norm2(b))
            by_rate = moment_for(b, by_rate)
         end if
      end if
      where (self%saturated /= 0)
         by_rotation = 0.0_wp
         by_rate = 0.0_wp
      end where
      if (self%by /= BY_MAGNETORQUERS) return
      by_rotation = cross(by_rotation, b) + cross(self%cut_off(self%command(t, q, omega)), rotated)
      by_rate = cross(by_rate, b)
   end subroutine differentiate_cut

   !> Returns the change of the torque on the body; saturated components change with the limit.
   pure function controlling_change(self, change, t, q, omega) result(tau)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3), b(3), moved(3), moment(3)
      tau = 0.0_wp
      if (self%by == BY_WHEELS .or. self%sample > 0.0_wp) return
      if (.not. any(self%saturated /= 0)) then
         tau = self%law_change(change, t, q, omega)
      else if (self%by == BY_TORQUE) then
         tau = cut_change(self, self%law_change(change, t, q, omega), change(23))
      else
         b = self%field_at(t, q)
         moved = field_change(self, change, t, q)
         moment = moment_change(self, change, t, q, omega, b, moved)
         tau = cross(cut_change(self, moment, change(23)), b) + &
               cross(self%cut_off(self%command(t, q, omega)), moved)
      end if
   end function controlling_change

   !> Returns the change of a command, in which saturated components change with the limit; shape (3).
   pure function cut_change(self, amount, limit) result(cut)
      class(control_law_t), intent(in) :: self
      !> Change of the command, shape (3), and of the limit.
      real(wp), intent(in) :: amount(3), limit
      real(wp) :: cut(3)
      cut = amount
      where (self%saturated /= 0) cut = self%saturated*limit
   end function cut_change

   !> Returns the change of `law_torque`, body axes, N m; shape (3).
   pure function law_change(self, change, t, q, omega) result(tau)
      class(control_law_t), intent(in) :: self
      !> Change of `parameters`; other arguments as in `law_torque`.
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3), b(3), moved(3)
      if (self%by /= BY_MAGNETORQUERS) then
         tau = pointing_change(self, change, t, q, omega)
         return
      end if
      b = self%field_at(t, q)
      moved = field_change(self, change, t, q)
      tau = cross(moment_change(self, change, t, q, omega, b, moved), b) + cross(self%command(t, q, omega), moved)
   end function law_change

   !> Returns the change of the moment, -k Ḃ or B×τ/|B|², before the limit, or zero without a field; shape (3).
   pure function moment_change(self, change, t, q, omega, b, moved) result(moment)
      class(control_law_t), intent(in) :: self
      !> B and its change, T; shape (3).
      real(wp), intent(in) :: change(:), t, q(4), omega(3), b(3), moved(3)
      real(wp) :: moment(3), tau(3), field(3), drift(3), size_of
      if (self%law == DETUMBLING) then
         call find_field(self, t, q, field, drift)
         moment = -change(19)*(cross(b, omega) + drift) - self%gain*rate_change(self, change, t, q, omega)
         return
      end if
      moment = 0.0_wp
      size_of = norm2(b)
      if (.not. size_of > 0.0_wp) return
      tau = pointing_torque(self, t, q, omega)
      moment = moment_for(b, pointing_change(self, change, t, q, omega)) + cross(moved/size_of, tau/size_of) &
               - (2*dot_product(b/size_of, moved/size_of))*moment_for(b, tau)
   end function moment_change

   !> Returns the change of B in body axes, T; shape (3).
   pure function field_change(self, change, t, q) result(b)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4)
      real(wp) :: b(3)
      b = change(20:22)
      if (self%follows_earth) b = change_by_orbit(self%earth, change(24:), t) + &
                                  change_by_axis(self%earth, change(31:33), change(34), t)
      b = rotate_to_body(q, b)
   end function field_change

   !> Returns the change of Ḃ in body axes, T/s; shape (3).
   pure function rate_change(self, change, t, q, omega) result(rate)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: rate(3)
      type(geomagnetic_field_t) :: other
      rate = cross(field_change(self, change, t, q), omega)
      if (.not. self%follows_earth) return
      other = with_axis(self%earth, change(31:33), change(34))
      rate = rate + rotate_to_body(q, rate_change_by_orbit(self%earth, change(24:), t) + other%rate_at(t))
   end function rate_change

   !> Returns -δK sgn(e₀) e_v - δD Ω; if the target rotates by φ, body axes, e_v changes by -½(e₀φ + e_v×φ).
   pure function pointing_change(self, change, t, q, omega) result(tau)
      class(control_law_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3), e(4), turn(3)
      e = error_of(self, t, q)
      tau = -times_vector(reshape(change(1:9), [3, 3]), e(2:4)) &
            - times_vector(reshape(change(10:18), [3, 3]), omega - rate_of_target(self, t, q))
      if (.not. self%follows_orbit) return
      turn = rotate_to_body(q, axes_change(self%orbit%path, change(24:), t))
      tau = tau + 0.5_wp*times_vector(self%attitude_gain, e(1)*turn + cross(e(2:4), turn)) + &
            times_vector(self%rate_gain, rotate_to_body(q, axes_rate_change(self%orbit, change(24:), t)))
   end function pointing_change

end module nutate_control_law
