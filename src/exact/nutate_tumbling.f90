!> Tumbling elements of a free triaxial body (mode, periods, energy and pole), computed from a state and vice versa.
!>
!> Moments J_l < J_i < J_s of the long, intermediate and short axis, D = 2T, E₀ = L²/2J_s. With a = L² - D J_l,
!> b = D J_s - L², c = L² - D J_i the short-axis mode has c > 0, and of its elliptic functions
!>
!>     m = (J_i-J_l) b/((J_s-J_i) a),   1-m = (J_s-J_l) c/((J_s-J_i) a),   λ² = (J_s-J_i) a/(J_l J_i J_s);
!>
!> the long-axis mode has them with l and s, a and b exchanged and -c for c. The body rotates in itself with the period
!> P_ψ = 4K(m)/λ; its short axis precesses about L with the mean rate, ν = J_s(J_i-J_l)/(J_l(J_s-J_i)),
!>
!>     2π/P_φ = L/J_s + L (J_s-J_l)/(J_s J_l) Π(-ν|m)/K(m)
!>
!> in the short-axis mode, and the long one with l and s exchanged in the other; 1/P_φ,short = 1/P_φ,long + 1/P_ψ.
!> N. H. Samarasinha, M. F. A'Hearn, Icarus 93 (1991) 194; M. Kaasalainen, A&A 376 (2001) 302.
module nutate_tumbling
   use nutate_attitude, only: quat_from_matrix
   use nutate_carlson, only: carlson_rf, carlson_rj
   use nutate_elliptic, only: jacobi
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_normalized, quat_product, rotate_to_space
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: tumbling_t, tumbling_elements, tumbling_state, tumbling_start, tumbling_start_t, infinite_period

   !> Value for an infinite period, s: its square is finite, so that means of output points can be computed.
   real(wp), parameter :: infinite_period = 1e100_wp

   !> Elements of a motion.
   type :: tumbling_t
      !> The short-axis mode; else the long-axis mode.
      logical :: is_short_axis = .true.
      !> Negative rotation about the axis of the mode, short or long, whose component of Ω keeps its sign.
      logical :: is_negative = .false.
      !> Energy ratio E/E₀.
      real(wp) :: energy_ratio = 1.0_wp
      !> P_φ of the short and the long axis, P_ψ, s.
      real(wp) :: precession_short = infinite_period, precession_long = infinite_period, rotation = infinite_period
   end type tumbling_t

   !> Initial state by elements.
   type :: tumbling_start_t
      !> The mode; the axis, short or long, whose precession period and angle are given.
      logical :: is_short_axis = .true., period_of_short = .true.
      !> Negative rotation about the axis of the mode.
      logical :: is_negative = .false.
      !> P_φ, s; P_ψ, s, or, if that is 0, E/E₀.
      real(wp) :: precession_period = 0.0_wp, rotation_period = 0.0_wp, energy_ratio = 0.0_wp
      !> Longitude and latitude of the angular momentum, and precession angle of the axis about it, rad.
      real(wp) :: pole(2) = 0.0_wp, angle = 0.0_wp
      !> Time, in P_ψ, since Ω_i was 0 and Ω of the other axis, that of the other mode, was positive.
      real(wp) :: phase = 0.0_wp
   end type tumbling_start_t

contains

   !> Computes the elements of a state, as if the body were free from now on.
   pure type(tumbling_t) function tumbling_elements(moments, momentum) result(elements)
      !> Principal moments, in any order, kg m², and L along these axes, N m s; shape (3).
      real(wp), intent(in) :: moments(3), momentum(3)
      real(wp) :: j(3), unit(3), square(3), abc(3), size
      integer :: order(3)
      size = maxval(abs(momentum))
      if (.not. size > 0.0_wp) return
      unit = momentum/size
      order = order_of(moments)
      j = moments(order)
      square = unit(order)**2/dot_product(unit, unit)
      abc = invariants_of(j, square)
      elements = elements_of(j, abc(1), abc(2), abc(3), size*norm2(unit))
      elements%is_negative = unit(order(merge(3, 1, elements%is_short_axis))) < 0.0_wp
   end function tumbling_elements

   !> Returns a, b, c over L².
   pure function invariants_of(j, square) result(abc)
      !> J_l, J_i, J_s, kg m²; squares of the unit vector of L along these axes; shapes (3).
      real(wp), intent(in) :: j(3), square(3)
      real(wp) :: abc(3)
      abc = [square(2)*((j(2) - j(1))/j(2)) + square(3)*((j(3) - j(1))/j(3)), &
             square(1)*((j(3) - j(1))/j(1)) + square(2)*((j(3) - j(2))/j(2)), &
             square(3)*((j(3) - j(2))/j(3)) - square(1)*((j(2) - j(1))/j(1))]
   end function invariants_of

   !> Returns the indices of the long, intermediate and short axis; shape (3).
   pure function order_of(moments) result(order)
      real(wp), intent(in) :: moments(3)
      integer :: order(3)
      order(1) = minloc(moments, dim=1)
      order(3) = 1 + mod(order(1), 3)
      order(2) = 6 - order(1) - order(3)
      if (moments(order(2)) > moments(order(3))) order = order([1, 3, 2])
   end function order_of

   !> Computes the elements from a, b, c over L², and L.
   pure type(tumbling_t) function elements_of(j, a, b, c, length) result(elements)
      !> J_l, J_i, J_s, kg m²; shape (3).
      real(wp), intent(in) :: j(3)
      !> a, b, c over L², dimensionless; L, N m s.
      real(wp), intent(in) :: a, b, c, length
      elements%is_short_axis = c >= 0.0_wp
      elements%energy_ratio = 1 + b
      if (elements%is_short_axis) then
         call find_periods([j(1), j(2), j(3)], a, c, length, elements%rotation, elements%precession_short)
         elements%precession_long = beat(elements%precession_short, -elements%rotation)
      else
         call find_periods([j(3), j(2), j(1)], b, -c, length, elements%rotation, elements%precession_long)
         elements%precession_short = beat(elements%precession_long, elements%rotation)
      end if
   end function elements_of

   !> Returns P of 1/P = 1/P₁ + 1/P₂, s.
   pure real(wp) function beat(first, second)
      real(wp), intent(in) :: first, second
      real(wp) :: rate
      rate = 1/first + 1/second
      beat = infinite_period
      if (abs(rate) > 1/infinite_period) beat = 1/rate
   end function beat

   !> Computes P_ψ, and P_φ of the axis of the mode.
   pure subroutine find_periods(j, a, c, length, rotation, precession)
      !> Moments of the other extreme axis, the intermediate and that of the mode; shape (3).
      real(wp), intent(in) :: j(3)
      !> a, c or b, -c, over L²; L, N m s.
      real(wp), intent(in) :: a, c, length
      !> Periods P_ψ and P_φ, s.
      real(wp), intent(out) :: rotation, precession
      real(wp) :: m1, k, third, nu, lambda
      rotation = infinite_period
      precession = 2*pi*(j(3)/length)
      ! A body of two equal moments about its axis of symmetry, or of three equal moments.
      if (.not. (abs(j(3) - j(2)) > 0.0_wp .and. a > 0.0_wp)) return
      m1 = min(1.0_wp, max((abs(j(3) - j(1))*c)/(abs(j(3) - j(2))*a), 0.0_wp))
      lambda = (length/j(3))*sqrt((abs(j(3) - j(2))/j(2))*(a*(j(3)/j(1))))
      nu = (j(3)/j(1))*(abs(j(2) - j(1))/abs(j(3) - j(2)))
      if (m1 > tiny(1.0_wp)) then
         k = carlson_rf(0.0_wp, m1, 1.0_wp)
         if (lambda > 4*k/infinite_period) rotation = 4*k/lambda
         ! Π(-ν|m) as a sum of positive terms: ν is large for nearly symmetric bodies.
         third = 1/(1 + nu) + (m1*(nu/(1 + nu))/(1 + nu)/3)*(carlson_rj(0.0_wp, m1, 1.0_wp, m1/(1 + nu))/k)
      else
         ! Ratio Π/K of infinite integrals.
         third = 1/(1 + nu)
      end if
      precession = 2*pi/(length/j(3) + (length/j(3))*((j(3) - j(1))/j(1))*third)
   end subroutine find_periods

   !> Computes attitude and body momentum of an initial state by elements.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a body that is not triaxial, and for periods or an energy that the mode does not
   !> have; the subject is the key of the scene.
   subroutine tumbling_state(moments, axes, start, q, omega, status)
      !> Principal moments, kg m², and axes as columns, body axes, right-handed; shapes (3), (3,3).
      real(wp), intent(in) :: moments(3), axes(3, 3)
      type(tumbling_start_t), intent(in) :: start
      !> Unit quaternion, body→space; Ω, body axes, rad/s; shapes (4), (3).
      real(wp), intent(out) :: q(4), omega(3)
      type(status_t), intent(out) :: status
      real(wp) :: j(3), frame(3, 3), share, length, rates(3)
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      omega = 0.0_wp
      j = moments(order_of(moments))
      if (.not. (j(1) < j(2) .and. j(2) < j(3))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'tumbling elements need a triaxial body (expected three different '// &
                       'moments)', 'tumbling')
         return
      end if
      call find_share(j, start, share, status)
      if (.not. status%ok()) return
      length = 2*pi/(start%precession_period*rate_of(j, start, share))
      rates = rates_of(j, start%is_short_axis, share, length, start%phase)
      if (start%is_negative) rates = mirrored(rates, start%is_short_axis)
      frame = right_handed(axes(:, order_of(moments)))
      omega = matmul(frame, rates)
      q = quat_product(attitude_of_pole(start%pole), about(3, start%angle))
      q = quat_normalized(quat_product(q, attitude_to_momentum(frame, j*rates, start%period_of_short)))
   end subroutine tumbling_state

   !> Returns the elements of an initial state: P_φ and angle are those of the axis of the mode.
   pure type(tumbling_start_t) function tumbling_start(moments, axes, q, omega) result(start)
      !> Arguments as in `tumbling_state`; the body is triaxial and rotates.
      real(wp), intent(in) :: moments(3), axes(3, 3), q(4), omega(3)
      type(tumbling_t) :: elements
      real(wp) :: j(3), frame(3, 3), rates(3), l(3), turn(4)
      j = moments(order_of(moments))
      frame = right_handed(axes(:, order_of(moments)))
      rates = matmul(omega, frame)
      elements = tumbling_elements(j, j*rates)
      start%is_short_axis = elements%is_short_axis
      start%period_of_short = elements%is_short_axis
      start%is_negative = elements%is_negative
      start%precession_period = merge(elements%precession_short, elements%precession_long, elements%is_short_axis)
      start%rotation_period = elements%rotation
      start%energy_ratio = elements%energy_ratio
      l = rotate_to_space(q, matmul(frame, j*rates))
      start%pole = [angle_of(l(2), l(1)), angle_of(l(3), hypot(l(1), l(2)))]
      turn = quat_product(quat_conjugate(attitude_of_pole(start%pole)), &
                          quat_product(q, quat_conjugate(attitude_to_momentum(frame, j*rates, elements%is_short_axis))))
      ! A quaternion and its negative are the same rotation; the angle is between -π and π.
      start%angle = 2*angle_of(sign(1.0_wp, turn(1))*turn(4), abs(turn(1)))
      if (elements%is_negative) rates = mirrored(rates, elements%is_short_axis)
      start%phase = phase_of(j, elements%is_short_axis, rates)
   end function tumbling_start

   !> Returns the angle of a point of the plane, rad; 0 for the origin.
   pure real(wp) function angle_of(y, x) result(angle)
      real(wp), intent(in) :: y, x
      angle = 0.0_wp
      if (abs(x) + abs(y) > 0.0_wp) angle = atan2(y, x)
   end function angle_of

   !> Returns the same motion rotated by 180° about the other extreme axis: with the other sense about that of the mode.
   pure function mirrored(rates, is_short_axis) result(other)
      !> Ω along the long, intermediate and short axis; shape (3).
      real(wp), intent(in) :: rates(3)
      logical, intent(in) :: is_short_axis
      real(wp) :: other(3)
      other = -rates
      if (is_short_axis) other(1) = rates(1)
      if (.not. is_short_axis) other(3) = rates(3)
   end function mirrored

   !> Returns the long, intermediate and short axis, the second with the sign that makes them right-handed; shape (3,3).
   pure function right_handed(axes) result(frame)
      real(wp), intent(in) :: axes(3, 3)
      real(wp) :: frame(3, 3)
      frame = axes
      frame(:, 2) = cross(frame(:, 3), frame(:, 1))
   end function right_handed

   !> Returns Rz(λ+90°) Rx(90°-β), whose third axis is the pole; shape (4).
   pure function attitude_of_pole(pole) result(q)
      !> Longitude and latitude, rad.
      real(wp), intent(in) :: pole(2)
      real(wp) :: q(4)
      q = quat_product(about(3, pole(1) + 0.5_wp*pi), about(1, 0.5_wp*pi - pole(2)))
   end function attitude_of_pole

   !> Returns Rx(θ) Rz(ψ) from body axes, whose third axis is along the momentum; shape (4).
   pure function attitude_to_momentum(frame, momentum, of_short) result(q)
      !> Long, intermediate and short axis as columns, body axes; L along them, N m s; shapes (3,3), (3).
      real(wp), intent(in) :: frame(3, 3), momentum(3)
      !> θ and ψ are Euler angles of the short axis; else of the long one.
      logical, intent(in) :: of_short
      real(wp) :: q(4), l(3)
      integer :: order(3)
      order = merge([1, 2, 3], [2, 3, 1], of_short)
      l = momentum(order)
      q = quat_product(about(1, angle_of(hypot(l(1), l(2)), l(3))), about(3, angle_of(l(1), l(2))))
      q = quat_product(q, quat_conjugate(quat_from_matrix(frame(:, order))))
   end function attitude_to_momentum

   !> Returns the phase of a motion of positive sense: the inverse of `rates_of`, -1/2 to 1/2.
   pure real(wp) function phase_of(j, is_short_axis, rates) result(phase)
      real(wp), intent(in) :: j(3)
      logical, intent(in) :: is_short_axis
      !> Ω along the long, intermediate and short axis; shape (3).
      real(wp), intent(in) :: rates(3)
      real(wp) :: abc(3), amplitude, m1, k, u
      abc = invariants_of(j, (j*rates/norm2(j*rates))**2)
      m1 = complement(j, is_short_axis, abc(1), abc(2), abc(3))
      if (is_short_axis) amplitude = angle_of(rates(2)*sqrt(j(2)*(j(3) - j(2))), rates(1)*sqrt(j(1)*(j(3) - j(1))))
      if (.not. is_short_axis) &
         amplitude = angle_of(rates(2)*sqrt(j(2)*(j(2) - j(1))), rates(3)*sqrt(j(3)*(j(3) - j(1))))
      phase = 0.0_wp
      ! A motion on the separatrix has no period.
      if (.not. m1 > tiny(1.0_wp)) return
      k = carlson_rf(0.0_wp, m1, 1.0_wp)
      u = sin(amplitude)*carlson_rf(cos(amplitude)**2, cos(amplitude)**2 + m1*sin(amplitude)**2, 1.0_wp)
      if (cos(amplitude) < 0.0_wp) u = sign(2*k, amplitude) - u
      phase = u/(4*k)
   end function phase_of

   !> Returns 1-m of the elliptic functions of a motion.
   pure real(wp) function complement(j, is_short_axis, a, b, c) result(m1)
      real(wp), intent(in) :: j(3)
      logical, intent(in) :: is_short_axis
      !> a, b, c over L².
      real(wp), intent(in) :: a, b, c
      m1 = (j(3) - j(1))*abs(c)
      if (is_short_axis) m1 = m1/((j(3) - j(2))*a)
      if (.not. is_short_axis) m1 = m1/((j(2) - j(1))*b)
      m1 = min(m1, 1.0_wp)
   end function complement

   !> Returns the rotation about a coordinate axis, as a unit quaternion; shape (4).
   pure function about(axis, angle) result(q)
      integer, intent(in) :: axis
      !> rad.
      real(wp), intent(in) :: angle
      real(wp) :: q(4), half(3)
      half = 0.0_wp
      half(axis) = 0.5_wp*angle
      q = quat_exp(half)
   end function about

   !> Returns Ω along the long, intermediate and short axis at a phase, rad/s; shape (3).
   pure function rates_of(j, is_short_axis, share, length, phase) result(rates)
      real(wp), intent(in) :: j(3)
      logical, intent(in) :: is_short_axis
      !> Share as in `find_share`; L, N m s; phase in periods.
      real(wp), intent(in) :: share, length, phase
      real(wp) :: rates(3), a, b, c, m1, sn, cn, dn, u
      call split(j, is_short_axis, share, a, b, c)
      m1 = complement(j, is_short_axis, a, b, c)
      u = 4*carlson_rf(0.0_wp, m1, 1.0_wp)*(phase - anint(phase))
      call jacobi(u, m1, sn, cn, dn)
      rates = length*sqrt([b/(j(1)*(j(3) - j(1))), merge(b/(j(2)*(j(3) - j(2))), a/(j(2)*(j(2) - j(1))), &
           is_short_axis), &
                           a/(j(3)*(j(3) - j(1)))])
      rates = rates*merge([cn, sn, dn], [dn, sn, cn], is_short_axis)
   end function rates_of

   !> Returns a, b, c of L = 1 at a share of the way from pure rotation to the separatrix.
   pure subroutine split(j, is_short_axis, share, a, b, c)
      real(wp), intent(in) :: j(3)
      logical, intent(in) :: is_short_axis
      real(wp), intent(in) :: share
      real(wp), intent(out) :: a, b, c
      if (is_short_axis) then
         b = share*((j(3) - j(2))/j(2))
         c = (1 - share)*((j(3) - j(2))/j(3))
         a = ((j(3) - j(1)) - b*j(1))/j(3)
      else
         a = share*((j(2) - j(1))/j(2))
         c = -(1 - share)*((j(2) - j(1))/j(1))
         b = ((j(3) - j(1)) - a*j(3))/j(1)
      end if
   end subroutine split

   !> Finds the share of the way from pure rotation, 0, to the separatrix, 1, along which the energy is linear. Errors:
   !> those of `tumbling_state`.
   subroutine find_share(j, start, share, status)
      real(wp), intent(in) :: j(3)
      type(tumbling_start_t), intent(in) :: start
      real(wp), intent(out) :: share
      type(status_t), intent(out) :: status
      integer, parameter :: halvings = 60
      real(wp) :: low, high, wanted
      integer :: i
      share = 0.0_wp
      if (.not. start%rotation_period > 0.0_wp) then
         ! E/E₀ from 1 to J_s/J_i, or from J_s/J_l down to it.
         share = (start%energy_ratio - 1)/(j(3)/j(2) - 1)
         if (.not. start%is_short_axis) share = (j(3)/j(1) - start%energy_ratio)/(j(3)/j(1) - j(3)/j(2))
         if (.not. (share >= 0.0_wp .and. share < 1.0_wp)) status = fail(NUTATE_BAD_ARGUMENT, &
            'energy_ratio is out of range ('//bounds_in_words(j, start%is_short_axis)//')', 'energy_ratio')
         return
      end if
      wanted = start%rotation_period/start%precession_period
      if (ratio_of(j, start, 0.0_wp) >= wanted) then
         status = fail(NUTATE_BAD_ARGUMENT, &
              'rotation_period is too short for this body and mode (expected more than '// &
                       number_in_words(ratio_of(j, start, 0.0_wp))//' precession periods)', 'rotation_period')
         return
      end if
      low = 0.0_wp
      high = 1.0_wp
      do i = 1, halvings
         share = 0.5_wp*(low + high)
         if (ratio_of(j, start, share) < wanted) then
            low = share
         else
            high = share
         end if
      end do
      if (.not. high < 1.0_wp) status = fail(NUTATE_BAD_ARGUMENT, &
           'rotation_period is too long for this body (expected '// &
                                             'less: next to the separatrix nothing tells periods apart)', &
                                                  'rotation_period')
   end subroutine find_share

   pure function bounds_in_words(j, is_short_axis) result(words)
      real(wp), intent(in) :: j(3)
      logical, intent(in) :: is_short_axis
      character(len=:), allocatable :: words
      if (is_short_axis) then
         words = 'expected 1 to less than '//number_in_words(j(3)/j(2))
      else
         words = 'expected more than '//number_in_words(j(3)/j(2))//', up to '//number_in_words(j(3)/j(1))
      end if
   end function bounds_in_words

   pure function number_in_words(x) result(words)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: words
      character(len=24) :: text
      write (text, '(g0.6)') x
      words = trim(adjustl(text))
   end function number_in_words

   !> Returns P_ψ/P_φ of the requested axis.
   pure real(wp) function ratio_of(j, start, share) result(ratio)
      real(wp), intent(in) :: j(3), share
      type(tumbling_start_t), intent(in) :: start
      type(tumbling_t) :: elements
      elements = elements_at(j, start%is_short_axis, share)
      ratio = infinite_period
      if (elements%rotation < infinite_period) ratio = elements%rotation*rate_of(j, start, share)/(2*pi)
   end function ratio_of

   !> Returns 2π/P_φ of the requested axis for L = 1, rad/s.
   pure real(wp) function rate_of(j, start, share) result(rate)
      real(wp), intent(in) :: j(3), share
      type(tumbling_start_t), intent(in) :: start
      type(tumbling_t) :: elements
      elements = elements_at(j, start%is_short_axis, share)
      rate = 2*pi/merge(elements%precession_short, elements%precession_long, start%period_of_short)
   end function rate_of

   pure type(tumbling_t) function elements_at(j, is_short_axis, share) result(elements)
      real(wp), intent(in) :: j(3), share
      logical, intent(in) :: is_short_axis
      real(wp) :: a, b, c
      call split(j, is_short_axis, share, a, b, c)
      if (is_short_axis) c = abs(c)
      elements = elements_of(j, a, b, c, 1.0_wp)
   end function elements_at

end module nutate_tumbling
