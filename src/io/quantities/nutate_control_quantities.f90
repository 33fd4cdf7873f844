!> Quantities of controllers and of the magnetic field in which they act.
module nutate_control_quantities
   use nutate_effect_list, only: effect_list_t, command_of_wheel
   use nutate_effect_traits, only: DRIVES_WHEELS, IS_CONTROLLER, IS_POINTING
   use nutate_hamiltonian, only: relative_rate, system_t
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_quantity, only: quantity_t, counts, is_sampled, NEEDS_CONTROLLER, NEEDS_FIELD, NEEDS_TARGET, OF_CONTROL
   use nutate_quaternion, only: quat_normalized, rotate_to_body
   use nutate_state, only: state_t
   use nutate_torque, only: torque_t, n_saturations
   implicit none
   private

   public :: control_value, controller_values, field_in_body, has_controller, has_field
   public :: Q_CONTROLLER, Q_FIELD

   !> Kinds: one case evaluates all components of a kind. `Q_CONTROLLER` is only a column; the rates of the others are
   !> differences.
   enum, bind(c)
      enumerator :: Q_CONTROLLER = OF_CONTROL, Q_POINTING_ERROR, Q_FIELD
   end enum

   !> Index of the implied loops of entries.
   integer :: i

   !> Quantities of controllers, by their numbers, and the magnetic field.
   type(quantity_t), parameter, public :: control_quantities(*) = [ &
      [(quantity_t('controller#', 'controller#_commanded1,controller#_commanded2,controller#_commanded3', &
                   Q_CONTROLLER, 'N m or A m²', 'controller #, commanded', 14, '', 'body', is_sampled, is_sampled, &
                   needs=NEEDS_CONTROLLER, number=i, symbols='axis 1,axis 2,axis 3'), &
        quantity_t('controller#', 'controller#_applied1,controller#_applied2,controller#_applied3', Q_CONTROLLER, &
                   'N m or A m²', 'controller #, applied', 15, '', 'body', is_sampled, is_sampled, &
                   needs=NEEDS_CONTROLLER, number=i, first=4, symbols='axis 1,axis 2,axis 3'), &
        quantity_t('controller#', 'controller#_saturations', Q_CONTROLLER, '', 'saturations', 16, '', '', counts, &
                   counts, needs=NEEDS_CONTROLLER, number=i, first=7, symbols='controller #'), i=1, 6)], &
      [(quantity_t('pointing_error#', 'pointing_error#', Q_POINTING_ERROR, 'rad', 'pointing error', 9, &
                   needs=NEEDS_TARGET, number=i, by_differences=.true., symbols='controller #'), i=1, 6)], &
      quantity_t('magnetic_field', 'B1,B2,B3', Q_FIELD, 'T', 'magnetic field B', 17, '', 'body', needs=NEEDS_FIELD, &
                 by_differences=.true., symbols='B_1,B_2,B_3')]

contains

   !> Returns the value of a component of a quantity; 0 if the controller does not exist.
   pure real(wp) function control_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: b(3)
      if (quantity%kind == Q_POINTING_ERROR) then
         x = pointing_error(quantity%number, system, motion%state)
      else
         b = field_in_body(system%effects, motion%state)
         x = b(component)
      end if
   end function control_value

   !> Returns commanded and applied torque, N m, or moment of magnetorquers, A m², body axes, and how often a component
   !> of it, or the torque of a motor, has reached its limit; shape (7). Zeros for a controller that does not exist, and
   !> for the commands of one that does not act.
   pure function controller_values(n, system, state) result(values)
      !> Number of the controller, in the order of the scene.
      integer, intent(in) :: n
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(7), q(4), rate(3)
      integer :: place
      values = 0.0_wp
      place = place_of(system%effects, n)
      if (place == 0) return
      q = quat_normalized(state%q)
      rate = relative_rate(system, state)
      associate (controller => system%effects%torques(place)%item)
         values(1:6) = controller%commands_at(state%t, q, rate)
         values(7) = saturations_of(controller, system%effects, state%t)
         if (controller%has(DRIVES_WHEELS)) values(4:6) = torque_by_wheels(controller, system%effects, state%t, q, rate)
      end associate
   end function controller_values

   !> Returns the torque of the motors on the body for a controller, N m, body axes; shape (3). If a motor cannot give
   !> all that several controllers command together, each receives the same part of its command.
   pure function torque_by_wheels(controller, effects, t, q, rate) result(torque)
      class(torque_t), intent(in) :: controller
      type(effect_list_t), intent(in) :: effects
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω against the space axes, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), rate(3)
      real(wp) :: torque(3), u, asked
      integer :: i
      torque = 0.0_wp
      do i = 1, effects%n_reaction_wheels
         associate (wheel => effects%wheels(i))
            if (.not. wheel%is_driven(t)) cycle
            u = wheel%drive(t, q, rate)
            if (controller%sample > 0.0_wp) then
               asked = command_of_wheel(effects, i)
               ! The command is scaled only if the motor limits it; otherwise it is bitwise identical.
               if (abs(u) < abs(asked)) then
                  u = controller%wheel_command(i)*(u/asked)
               else
                  u = controller%wheel_command(i)
               end if
            end if
            torque = torque - u*wheel%axis
         end associate
      end do
   end function torque_by_wheels

   !> Returns how often a component, or the torque of a motor, has reached its limit.
   pure integer function saturations_of(controller, effects, t) result(number)
      class(torque_t), intent(in) :: controller
      type(effect_list_t), intent(in) :: effects
      !> Time, s.
      real(wp), intent(in) :: t
      integer :: i
      number = n_saturations(controller, t)
      if (.not. controller%has(DRIVES_WHEELS)) return
      do i = 1, effects%n_reaction_wheels
         associate (wheel => effects%wheels(i))
            if (.not. allocated(wheel%motor)) then
               number = number + wheel%saturations%number
            else
               number = number + n_saturations(wheel%motor, t)
            end if
         end associate
      end do
   end function saturations_of

   !> Returns the angle from the target of a controller, rad; 0 if the controller does not exist.
   pure real(wp) function pointing_error(n, system, state) result(angle)
      !> Number of the controller, in the order of the scene.
      integer, intent(in) :: n
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      integer :: place
      angle = 0.0_wp
      place = place_of(system%effects, n)
      if (place == 0) return
      angle = system%effects%torques(place)%item%error_angle(state%t, quat_normalized(state%q))
   end function pointing_error

   !> Returns the magnetic field, body axes, T; shape (3): the field of the Earth, else that of the first magnetorquers
   !> with a field in the scene, else that of the first dipole.
   pure function field_in_body(effects, state) result(b)
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      real(wp) :: b(3)
      logical :: found
      call find_still_field(effects, b, found)
      if (effects%in_earth_field) b = effects%earth_field%direction_at(state%t)
      b = rotate_to_body(quat_normalized(state%q), b)
   end function field_in_body

   !> Finds the magnetic field that is constant in space axes, T; shape (3).
   pure subroutine find_still_field(effects, b, found)
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(out) :: b(3)
      logical, intent(out) :: found
      integer :: i
      b = 0.0_wp
      found = .false.
      do i = 1, effects%n_torques
         if (.not. found) call effects%torques(i)%item%own_field(b, found)
      end do
      do i = 1, effects%n_potentials + effects%n_off
         if (.not. found) call effects%potentials(i)%item%own_field(b, found)
      end do
   end subroutine find_still_field

   !> Returns true if there is a magnetic field.
   pure logical function has_field(effects)
      type(effect_list_t), intent(in) :: effects
      real(wp) :: b(3)
      call find_still_field(effects, b, has_field)
      has_field = has_field .or. effects%in_earth_field
   end function has_field

   !> Returns true if the n-th controller exists and, if `points`, has a target.
   pure logical function has_controller(n, points, effects) result(has)
      integer, intent(in) :: n
      logical, intent(in) :: points
      type(effect_list_t), intent(in) :: effects
      integer :: place
      place = place_of(effects, n)
      has = place > 0
      if (has .and. points) has = effects%torques(place)%item%has(IS_POINTING)
   end function has_controller

   !> Returns the position of the n-th controller among the torques; 0 if there is none.
   pure integer function place_of(effects, n) result(place)
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: n
      integer :: i, k
      place = findloc([(count([(effects%torques(k)%item%has(IS_CONTROLLER), k=1, i)]), i=1, effects%n_torques)], n, &
                      dim=1)
   end function place_of

end module nutate_control_quantities
