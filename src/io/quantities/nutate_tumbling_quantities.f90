!> The tumbling elements that a motion would keep if it were free from now on, as columns and quantities of events.
module nutate_tumbling_quantities
   use nutate_hamiltonian, only: body_momentum, space_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_quantity, only: quantity_t, has_edges, two_values, GREEN, NAVY, NEEDS_NO_ROTOR, OF_TUMBLING, VERMILION
   use nutate_quaternion, only: cross, rotate_to_space
   use nutate_small_products, only: vector_length
   use nutate_state, only: state_t
   use nutate_tumbling, only: tumbling_elements, tumbling_t
   implicit none
   private

   public :: tumbling_value, tumbling_values, tumbling_rate

   !> Kind: one case evaluates all components.
   integer, parameter, public :: Q_TUMBLING = OF_TUMBLING

   !> Tumbling elements.
   type(quantity_t), parameter, public :: tumbling_quantities(*) = [ &
      quantity_t('tumbling', 'energy_ratio', Q_TUMBLING, '', 'E/E₀', 26, NAVY, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, symbols='E/E_0'), &
      quantity_t('tumbling', 'short_axis_mode', Q_TUMBLING, '', 'short-axis mode', 27, NAVY, '', two_values, &
                 two_values, needs=NEEDS_NO_ROTOR, first=2, symbols='mode'), &
      quantity_t('tumbling', 'precession_period_short', Q_TUMBLING, 's', 'periods of precession and rotation', 29, &
                 VERMILION, no_measurement=has_edges, needs=NEEDS_NO_ROTOR, first=3, symbols='short axis'), &
      quantity_t('tumbling', 'precession_period_long', Q_TUMBLING, 's', 'periods of precession and rotation', 29, &
                 GREEN, no_measurement=has_edges, needs=NEEDS_NO_ROTOR, first=4, symbols='long axis'), &
      quantity_t('tumbling', 'rotation_period', Q_TUMBLING, 's', 'periods of precession and rotation', 29, NAVY, &
                 no_measurement=has_edges, needs=NEEDS_NO_ROTOR, first=5, symbols='rotation'), &
      quantity_t('tumbling', 'pole_longitude', Q_TUMBLING, 'rad', 'pole', 30, VERMILION, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, is_periodic=.true., first=6, symbols='longitude'), &
      quantity_t('tumbling', 'pole_latitude', Q_TUMBLING, 'rad', 'pole', 30, NAVY, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, first=7, symbols='latitude'), &
      quantity_t('tumbling', 'sense', Q_TUMBLING, '', 'sense', 28, NAVY, '', two_values, two_values, &
                 needs=NEEDS_NO_ROTOR, first=8)]

   !> Number of columns, and positions of the pole's longitude and latitude and of the sense among them.
   integer, parameter :: tumbling_width = 8
   integer, parameter :: LONGITUDE = 6, LATITUDE = 7, SENSE = 8

contains

   !> Returns E/E₀, 1 in the short-axis mode or 0, P_φ of the short and the long axis and P_ψ, s, longitude and latitude
   !> of the angular momentum in space axes, rad, and 1 or -1 for the sense about the axis of the mode; shape (8).
   pure function tumbling_values(system, state) result(values)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(tumbling_width), l(3)
      type(tumbling_t) :: elements
      elements = tumbling_elements(system%body%moments, matmul(body_momentum(state), system%body%axes))
      values(:LONGITUDE - 1) = numbers_of(elements)
      l = space_momentum(state)
      values(LONGITUDE:LATITUDE) = [atan2(l(2), l(1)), atan2(l(3), hypot(l(1), l(2)))]
      values(SENSE) = merge(-1.0_wp, 1.0_wp, elements%is_negative)
   end function tumbling_values

   !> Returns one of `tumbling_values` along a motion.
   pure real(wp) function tumbling_value(column, system, motion) result(x)
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: values(tumbling_width)
      values = tumbling_values(system, motion%state)
      x = values(column)
   end function tumbling_value

   !> Returns the columns before those of the pole for an angular momentum; shape (5).
   pure function elements_of(system, momentum) result(values)
      type(system_t), intent(in) :: system
      !> Angular momentum, body axes, N m s; shape (3).
      real(wp), intent(in) :: momentum(3)
      real(wp) :: values(LONGITUDE - 1)
      values = numbers_of(tumbling_elements(system%body%moments, matmul(momentum, system%body%axes)))
   end function elements_of

   !> Returns the columns before those of the pole for tumbling elements; shape (5).
   pure function numbers_of(elements) result(values)
      type(tumbling_t), intent(in) :: elements
      real(wp) :: values(LONGITUDE - 1)
      values = [elements%energy_ratio, merge(1.0_wp, 0.0_wp, elements%is_short_axis), elements%precession_short, &
                elements%precession_long, elements%rotation]
   end function numbers_of

   !> Returns the rate of one of the columns along the motion: for the pole in closed form, for the others by central
   !> differences of sixth order along the change of the momentum that changes them: by the torque and, if there are
   !> rotors, also by the rotation.
   pure real(wp) function tumbling_rate(column, system, motion) result(rate)
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp), parameter :: part = 1e-3_wp, weights(3) = [45.0_wp/60, -9.0_wp/60, 1.0_wp/60]
      real(wp) :: torque(3), l(3), l_rate(3), before(LONGITUDE - 1), after(LONGITUDE - 1), span, across
      integer :: i
      torque = motion%potential_torque + motion%torque
      rate = 0.0_wp
      if (column >= LONGITUDE) then
         l = rotate_to_space(motion%state%q, motion%momentum)
         l_rate = rotate_to_space(motion%state%q, torque + cross(motion%momentum, motion%omega - motion%relative))
         across = l(1)**2 + l(2)**2
         if (.not. across > 0.0_wp) return
         rate = (l(1)*l_rate(2) - l(2)*l_rate(1))/across
         if (column == LATITUDE) &
            rate = (l_rate(3)*sqrt(across) - l(3)*(l(1)*l_rate(1) + l(2)*l_rate(2))/sqrt(across))/(across + l(3)**2)
         return
      end if
      if (system%effects%n_rotors > 0) torque = torque + cross(motion%momentum, motion%omega)
      if (.not. vector_length(torque) > 0.0_wp) return
      span = part*vector_length(motion%momentum)/vector_length(torque)
      do i = 1, size(weights)
         before = elements_of(system, motion%momentum - i*span*torque)
         after = elements_of(system, motion%momentum + i*span*torque)
         rate = rate + weights(i)*(after(column) - before(column))/span
      end do
   end function tumbling_rate

end module nutate_tumbling_quantities
