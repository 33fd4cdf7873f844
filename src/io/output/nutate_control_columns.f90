!> Columns of controllers and of the magnetic field in which they act.
module nutate_control_columns
   use nutate_dipole, only: dipole_t
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: relative_rate
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_normalized, rotate_to_body
   use nutate_controlled_motor, only: controlled_motor_t
   use nutate_controller, only: controller_t, BY_MAGNETORQUERS, BY_WHEELS, POINTING
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: controller_values, field_in_body, has_controller, has_field, pointing_error

contains

   !> Commanded and applied torque, N m, or moment of magnetorquers, A m², body axes, and how often a component of it,
   !> or the torque of a motor, has come to its limit; shape (7). Zeros for a controller that does not exist, and for
   !> the commands of one that does not act.
   pure function controller_values(n, system, state) result(values)
      !> Which controller, in the order of the scene.
      integer, intent(in) :: n
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(7), q(4), rate(3)
      integer :: place
      logical :: acts
      values = 0.0_wp
      place = place_of(system%effects, n)
      if (place == 0) return
      q = quat_normalized(state%q)
      rate = relative_rate(system, state)
      select type (controller => system%effects%torques(place)%item)
      class is (controller_t)
         acts = controller%on .and. state%t >= controller%start .and. state%t <= controller%stop
         if (controller%sample > 0.0_wp) then
            values(1:3) = controller%commanded
         else if (acts) then
            values(1:3) = controller%command(state%t, q, rate)
         end if
         values(7) = saturations_of(controller, system%effects, state%t)
         if (controller%by == BY_WHEELS) then
            values(4:6) = torque_by_wheels(controller, system%effects, state%t, q, rate)
         else if (controller%sample > 0.0_wp) then
            values(4:6) = controller%held
         else if (acts) then
            values(4:6) = values(1:3)
            where (controller%saturated /= 0) values(4:6) = controller%saturated*controller%limit
         end if
      end select
   end function controller_values

   !> Torque that the motors give the body for a controller, N m, body axes; shape (3). Of several controllers that a
   !> motor cannot give all that they ask for together, each gets the same part of it.
   pure function torque_by_wheels(controller, effects, t, q, rate) result(torque)
      class(controller_t), intent(in) :: controller
      type(effect_list_t), intent(in) :: effects
      !> s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω against the space axes, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), rate(3)
      real(wp) :: torque(3), u, asked
      integer :: i
      torque = 0.0_wp
      do i = 1, effects%n_wheels
         associate (wheel => effects%wheels(i))
            if (.not. wheel%is_driven(t)) cycle
            u = wheel%drive(t, q, rate)
            if (controller%sample > 0.0_wp) then
               asked = command_of_all(effects, i)
               ! Cut off, it is less; else it stays as it is, to the last digit.
               if (abs(u) < abs(asked)) then
                  u = controller%held_by_wheels(i)*(u/asked)
               else
                  u = controller%held_by_wheels(i)
               end if
            end if
            torque = torque - u*wheel%axis
         end associate
      end do
   end function torque_by_wheels

   !> What all sampled controllers ask of a motor, N m.
   pure real(wp) function command_of_all(effects, wheel) result(command)
      type(effect_list_t), intent(in) :: effects
      !> Which wheel.
      integer, intent(in) :: wheel
      integer :: i
      command = 0.0_wp
      do i = 1, effects%n_torques
         select type (controller => effects%torques(i)%item)
         class is (controller_t)
            command = command + controller%held_by_wheels(wheel)
         end select
      end do
   end function command_of_all

   !> How often a component, or the torque of a motor, has come to its limit.
   pure integer function saturations_of(controller, effects, t) result(number)
      class(controller_t), intent(in) :: controller
      type(effect_list_t), intent(in) :: effects
      !> s.
      real(wp), intent(in) :: t
      real(wp) :: start, stop
      integer :: i
      number = 0
      if (controller%by /= BY_WHEELS) then
         number = controller%saturations%number
         if (.not. controller%sample > 0.0_wp) number = controller%saturations%number_at( &
            t, controller%saturated, controller%on, controller%start, controller%stop)
         return
      end if
      do i = 1, effects%n_wheels
         associate (wheel => effects%wheels(i))
            if (.not. allocated(wheel%motor)) then
               number = number + wheel%saturations%number
               cycle
            end if
            select type (motor => wheel%motor)
            class is (controlled_motor_t)
               call motor%window(start, stop)
               number = number + wheel%saturations%number_at(t, [motor%saturated, 0, 0], motor%on, start, stop)
            end select
         end associate
      end do
   end function saturations_of

   !> Angle from the target of a controller, rad; 0 for one that does not exist.
   pure real(wp) function pointing_error(n, system, state) result(angle)
      !> Which controller, in the order of the scene.
      integer, intent(in) :: n
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      integer :: place
      angle = 0.0_wp
      place = place_of(system%effects, n)
      if (place == 0) return
      select type (controller => system%effects%torques(place)%item)
      class is (controller_t)
         angle = controller%error_angle(state%t, quat_normalized(state%q))
      end select
   end function pointing_error

   !> The magnetic field, body axes, T; shape (3): that of the Earth, or of the first magnetorquers that have one of
   !> their own, or of the first dipole.
   pure function field_in_body(effects, state) result(b)
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      real(wp) :: b(3)
      logical :: found
      call find_still_field(effects, b, found)
      if (effects%in_earth_field) b = effects%earth_field%at(state%t)
      b = rotate_to_body(quat_normalized(state%q), b)
   end function field_in_body

   !> The field that stands still in space axes, T; shape (3).
   pure subroutine find_still_field(effects, b, found)
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(out) :: b(3)
      logical, intent(out) :: found
      integer :: i
      b = 0.0_wp
      found = .false.
      do i = 1, effects%n_torques
         if (found) return
         select type (controller => effects%torques(i)%item)
         class is (controller_t)
            found = controller%by == BY_MAGNETORQUERS .and. .not. controller%follows_earth
            if (found) b = controller%field
         end select
      end do
      do i = 1, effects%n_potentials + effects%n_off
         if (found) return
         select type (dipole => effects%potentials(i)%item)
         class is (dipole_t)
            found = .true.
            b = dipole%direction
         end select
      end do
   end subroutine find_still_field

   !> True if there is a magnetic field.
   pure logical function has_field(effects)
      type(effect_list_t), intent(in) :: effects
      real(wp) :: b(3)
      call find_still_field(effects, b, has_field)
      has_field = has_field .or. effects%in_earth_field
   end function has_field

   !> True if there is a controller of a number, one that points where that is asked for.
   pure logical function has_controller(n, points, effects) result(has)
      integer, intent(in) :: n
      logical, intent(in) :: points
      type(effect_list_t), intent(in) :: effects
      integer :: place
      place = place_of(effects, n)
      has = place > 0
      if (.not. (has .and. points)) return
      select type (controller => effects%torques(place)%item)
      class is (controller_t)
         has = controller%law == POINTING
      end select
   end function has_controller

   !> Which torque the n-th controller is; 0 where there is none.
   pure integer function place_of(effects, n) result(place)
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: n
      integer :: i, k
      place = 0
      k = 0
      do i = 1, effects%n_torques
         select type (controller => effects%torques(i)%item)
         class is (controller_t)
            k = k + 1
            if (k == n) place = i
         end select
      end do
   end function place_of

end module nutate_control_columns
