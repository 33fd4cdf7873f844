!> Limits of the commands of controllers that act at all times, as events of a run: of the torque, of the moment of
!> magnetorquers, of the torque of motors. A component at its limit stays there until the control law requires less. A
!> motor whose wheel is at the limit of its speed is watched too: it gives no torque as long as the control law would
!> push the wheel further. With limits or without, a control law jumps when e₀ passes zero: between its zeros the sign
!> of e₀ is held.
module nutate_saturation
   use nutate_effect_list, only: effect_list_t
   use nutate_effect_traits, only: DRIVES_WHEELS, IS_CONTROLLER, JUMPS_WITH_SIGN, LENDS_PARAMETERS, LIMITS_MOMENT
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, eps
   use nutate_limit_event, only: limit_event_t, SWITCH_LIMIT
   use nutate_motion, only: find_motion, motion_t
   use nutate_quaternion, only: quat_normalized
   use nutate_saturation_count, only: side_of_limit
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_torque, only: torque_t, count_saturations_of => count_saturations
   implicit none
   private

   public :: add_saturations, can_jump, can_saturate, count_saturations, free_senses, note_saturations

   !> Distance of a command from its limit, over the limit, beyond which the command has jumped.
   real(wp), parameter :: near = 1e-3_wp

   !> Round-off of e₀, of unit quaternions.
   real(wp), parameter :: zero_scalar = 8*eps

   !> Event: the command of a control law reaches a limit or leaves it, or changes its sign.
   type, extends(limit_event_t) :: saturation_event_t
      !> Index of the torque in the system, and of its component; or 0, and the index of the wheel.
      integer :: torque = 0, place = 0
      !> 1: to the positive limit or from it; -1: to the negative limit or from it; 0: through zero.
      integer :: side = 0
   contains
      procedure :: value => asked_amount
      procedure :: family => driven_torque
      procedure :: component => axis_of_amount
      procedure :: family_values => asked_amounts
      procedure :: settle => settle_saturation
      procedure :: side_held => side_of_cut
   end type saturation_event_t

   !> Event: e₀ of a controller passes zero.
   type, extends(limit_event_t) :: turnover_event_t
      !> Index of the torque in the system.
      integer :: torque = 0
   contains
      procedure :: value => error_scalar
      procedure :: settle => settle_turnover
      procedure :: side_held => side_of_sense
   end type turnover_event_t

contains

   !> Returns true if a controller that acts at all times has a limit.
   pure logical function can_saturate(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      can_saturate = .false.
      do i = 1, effects%n_torques
         can_saturate = can_saturate .or. is_limited(effects%torques(i)%item)
      end do
      do i = 1, effects%n_wheels
         if (effects%wheels(i)%has_law()) can_saturate = can_saturate .or. is_limited(effects%wheels(i)%motor)
      end do
   end function can_saturate

   !> Returns true for a torque that a control law gives at all times, up to a limit.
   pure logical function is_limited(torque)
      class(torque_t), intent(in) :: torque
      is_limited = torque%n_limited() > 0 .and. torque%limit < huge(torque%limit)
   end function is_limited

   !> Adds to a list the events of all limits of commands: each of both limits is reached, or left; e₀ passes zero; for
   !> a wheel with a limit of its speed, the command of the control law passes zero.
   subroutine add_saturations(effects, events)
      type(effect_list_t), intent(in) :: effects
      type(event_list_t), intent(inout) :: events
      integer :: i, k
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%has(JUMPS_WITH_SIGN)) then
            do k = -1, 1, 2
               call events%add(turnover_event_t(words='zero of e0 of '//controller_words(effects, i), torque=i, &
                                                action=SWITCH_LIMIT, direction=k))
            end do
         end if
         if (.not. is_limited(effects%torques(i)%item)) cycle
         do k = 1, 3
            call add_sides(saturation_event_t(name=name_of(effects, i), words=controller_words(effects, i), torque=i, &
                                              place=k, action=SWITCH_LIMIT), effects%torques(i)%item%limit, events)
         end do
      end do
      do i = 1, effects%n_wheels
         if (.not. effects%wheels(i)%has_law()) cycle
         if (is_limited(effects%wheels(i)%motor)) &
            call add_sides(saturation_event_t(name='limit of motor', words=driver(effects), place=i, &
                                              action=SWITCH_LIMIT), effects%wheels(i)%motor%limit, events)
         if (.not. effects%wheels(i)%speed_limit < huge(1.0_wp)) cycle
         do k = -1, 1, 2
            call events%add(saturation_event_t(words='zero of the torque of '//driver(effects), place=i, &
                                               action=SWITCH_LIMIT, direction=k))
         end do
      end do
   end subroutine add_saturations

   !> Returns true if a control law that acts at all times jumps with the sign of e₀.
   pure logical function can_jump(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      can_jump = .false.
      do i = 1, effects%n_torques
         can_jump = can_jump .or. effects%torques(i)%item%has(JUMPS_WITH_SIGN)
      end do
   end function can_jump

   !> Lets the control laws follow the sign of e₀, for steps that no run watches.
   pure subroutine free_senses(effects)
      type(effect_list_t), intent(inout) :: effects
      integer :: i
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%has(JUMPS_WITH_SIGN)) call hold_sense(effects, i, 0)
      end do
   end subroutine free_senses

   !> Returns the name of the limit of a controller: that of a torque, or of a moment.
   pure function name_of(effects, i) result(name)
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: i
      character(len=15) :: name
      name = 'limit of torque'
      if (effects%torques(i)%item%has(LIMITS_MOMENT)) name = 'limit of moment'
   end function name_of

   !> Returns the description of a controller for messages: its name, or its number.
   pure function controller_words(effects, i) result(words)
      type(effect_list_t), intent(in) :: effects
      !> Index of its torque.
      integer, intent(in) :: i
      character(len=40) :: words
      integer :: k
      write (words, '(a,i0)') 'controller ', count([(effects%torques(k)%item%has(IS_CONTROLLER), k=1, i)])
      if (effects%torques(i)%item%label /= '') words = "controller '"//trim(effects%torques(i)%item%label)//"'"
   end function controller_words

   !> Returns the description of the controller that drives the motors at all times; there is at most one.
   pure function driver(effects) result(words)
      type(effect_list_t), intent(in) :: effects
      character(len=40) :: words
      integer :: i
      words = ''
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%has(LENDS_PARAMETERS)) words = controller_words(effects, i)
      end do
   end function driver

   !> Adds the events of a limit and of the negative limit: the command reaches it (an event with a name), or leaves it.
   subroutine add_sides(form, limit, events)
      type(saturation_event_t), intent(in) :: form
      real(wp), intent(in) :: limit
      type(event_list_t), intent(inout) :: events
      type(saturation_event_t) :: event
      integer :: side
      do side = -1, 1, 2
         event = form
         event%side = side
         event%level = side*limit
         event%direction = side
         write (event%name, '(a,i0)') trim(form%name)//' ', form%place
         event%words = trim(event%name)//' of '//form%words
         call events%add(event)
         event%direction = -side
         event%name = ''
         call events%add(event)
      end do
   end subroutine add_sides

   !> Returns the command of the control law.
   pure real(wp) function asked_amount(self, system, motion) result(amount)
      class(saturation_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: amounts(3)
      amounts = self%family_values(system, motion)
      amount = amounts(self%component())
   end function asked_amount

   !> Returns the index of the torque, or minus the index of the wheel.
   pure integer function driven_torque(self)
      class(saturation_event_t), intent(in) :: self
      driven_torque = merge(self%torque, -self%place, self%torque > 0)
   end function driven_torque

   !> Returns the component of the torque; 1 for the one of a motor.
   pure integer function axis_of_amount(self)
      class(saturation_event_t), intent(in) :: self
      axis_of_amount = merge(self%place, 1, self%torque > 0)
   end function axis_of_amount

   !> Returns all components of the command of the control law, or the one of a motor; shape (3).
   pure function asked_amounts(self, system, motion) result(amounts)
      class(saturation_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: amounts(3)
      associate (t => motion%state%t, q => quat_normalized(motion%state%q), rate => motion%relative)
         if (self%torque > 0) then
            amounts = system%effects%torques(self%torque)%item%command(t, q, rate)
         else
            amounts = system%effects%wheels(self%place)%motor%command(t, q, rate)
         end if
      end associate
   end function asked_amounts

   pure real(wp) function error_scalar(self, system, motion) result(scalar)
      class(turnover_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      scalar = system%effects%torques(self%torque)%item%error_scalar(motion%state%t, quat_normalized(motion%state%q))
   end function error_scalar

   !> Returns the side of its level on which a command is: of a limit, by whether the component is at it or within it;
   !> of zero, by whether a motor whose wheel is at the limit of its speed gives no torque or brakes.
   pure integer function side_of_cut(self, system) result(side)
      class(saturation_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      if (self%torque > 0) then
         side = side_of(system%effects%torques(self%torque)%item%saturated(self%place))
      else
         associate (motor => system%effects%wheels(self%place)%motor)
            side = side_of(motor%saturated(1))
            if (self%side == 0) side = merge(motor%at_limit, -motor%at_limit, motor%blocked)
         end associate
      end if

   contains

      pure integer function side_of(saturated)
         integer, intent(in) :: saturated
         side_of = merge(self%side, -self%side, saturated == self%side)
      end function side_of

   end function side_of_cut

   pure integer function side_of_sense(self, system) result(side)
      class(turnover_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      side = system%effects%torques(self%torque)%item%sense
   end function side_of_sense

   !> Holds the new sign of e₀, at which the control law jumps, and finds anew which commands are at a limit.
   pure subroutine settle_turnover(self, system, state)
      class(turnover_event_t), intent(in) :: self
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      call hold_sense(system%effects, self%torque, self%direction)
      call find_saturations(system, state)
   end subroutine settle_turnover

   !> Sets the sign of e₀ of a controller, and of the motors that it drives.
   pure subroutine hold_sense(effects, torque, sense)
      type(effect_list_t), intent(inout) :: effects
      !> Index of the torque of the controller.
      integer, intent(in) :: torque
      !> Sign of e₀, 1 or -1; 0: the control law follows e₀.
      integer, intent(in) :: sense
      integer :: i
      call effects%torques(torque)%item%hold_sense(sense)
      if (.not. effects%torques(torque)%item%has(DRIVES_WHEELS)) return
      do i = 1, effects%n_wheels
         if (effects%wheels(i)%has_law()) call effects%wheels(i)%motor%hold_sense(sense)
      end do
   end subroutine hold_sense

   !> Sets whether the command is at its limit, on whichever side of the limit round-off has put the event.
   pure subroutine settle_saturation(self, system, state)
      class(saturation_event_t), intent(in) :: self
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      type(motion_t) :: motion
      real(wp) :: amount
      call count_saturations(system%effects, state%t)
      call find_motion(system, state, motion)
      amount = self%value(system, motion)
      if (self%torque > 0) then
         associate (controller => system%effects%torques(self%torque)%item)
            controller%saturated(self%place) = cut_behind(self, amount, controller%limit)
         end associate
      else
         associate (motor => system%effects%wheels(self%place)%motor)
            if (self%side == 0) then
               motor%blocked = motor%at_limit*self%direction > 0
            else
               motor%saturated(1) = cut_behind(self, amount, motor%limit)
            end if
         end associate
      end if
      call count_saturations(system%effects, state%t)
   end subroutine settle_saturation

   !> Counts the commands at their limits, of control laws that act at all times; called before and after changes of
   !> limits and switches.
   pure subroutine count_saturations(effects, t)
      type(effect_list_t), intent(inout) :: effects
      !> Time, s.
      real(wp), intent(in) :: t
      integer :: i
      do i = 1, effects%n_torques
         call count_saturations_of(effects%torques(i)%item, t)
      end do
      do i = 1, effects%n_wheels
         if (effects%wheels(i)%has_law()) call count_saturations_of(effects%wheels(i)%motor, t)
      end do
   end subroutine count_saturations

   !> Returns the side on which a command is cut off after an event.
   pure integer function cut_behind(event, amount, limit) result(cut)
      class(saturation_event_t), intent(in) :: event
      real(wp), intent(in) :: amount, limit
      if (abs(amount - event%level) <= near*limit) then
         cut = merge(event%side, 0, event%direction == event%side)
      else
         cut = side_of_limit(amount, limit)
      end if
   end function cut_behind

   !> Finds out on which side of zero each e₀ is, and which commands are at, or beyond, their limits. The limits of
   !> wheels have to be known.
   pure subroutine note_saturations(system, state)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      integer :: i
      do i = 1, system%effects%n_torques
         if (system%effects%torques(i)%item%has(JUMPS_WITH_SIGN)) &
            call hold_sense(system%effects, i, sense_at(system, i, state))
      end do
      call find_saturations(system, state)
   end subroutine note_saturations

   !> Returns sgn(e₀) of a controller; if e₀ is zero but for round-off, half a revolution from the target, the sign of
   !> its rate.
   pure integer function sense_at(system, torque, state) result(sense)
      type(system_t), intent(in) :: system
      !> Index of the torque of the controller.
      integer, intent(in) :: torque
      type(state_t), intent(in) :: state
      type(turnover_event_t) :: turnover
      type(motion_t) :: motion
      real(wp) :: scalar
      turnover%torque = torque
      call find_motion(system, state, motion)
      scalar = turnover%value(system, motion)
      if (abs(scalar) <= zero_scalar) scalar = turnover%rate(system, motion)
      sense = merge(-1, 1, scalar < 0.0_wp)
   end function sense_at

   !> Finds out which commands are at, or beyond, their limits.
   pure subroutine find_saturations(system, state)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      type(motion_t) :: motion
      real(wp) :: q(4)
      integer :: i
      call count_saturations(system%effects, state%t)
      call find_motion(system, state, motion)
      q = quat_normalized(state%q)
      do i = 1, system%effects%n_torques
         if (is_limited(system%effects%torques(i)%item)) call find_sides(system%effects%torques(i)%item)
      end do
      do i = 1, system%effects%n_wheels
         if (system%effects%wheels(i)%has_law()) call find_sides(system%effects%wheels(i)%motor)
      end do
      call count_saturations(system%effects, state%t)

   contains

      pure subroutine find_sides(torque)
         class(torque_t), intent(inout) :: torque
         real(wp) :: command(3)
         command = torque%command(state%t, q, motion%relative)
         torque%saturated = side_of_limit(command, torque%limit)
         torque%blocked = torque%at_limit*command(1) > 0.0_wp
      end subroutine find_sides

   end subroutine find_saturations

end module nutate_saturation
