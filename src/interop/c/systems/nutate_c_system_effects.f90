!> C interface: the effects of a system. The functions are documented in `include/nutate_system.h`.
module nutate_c_system_effects
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use nutate_c_groups, only: add_effect_of
   use nutate_c_handles, only: conclude, found, system_handle_t
   use nutate_c_text, only: lock_texts, unlock_texts
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: nutate_system_add_gravity, nutate_system_add_dipole, nutate_system_add_gravity_gradient, &
      nutate_system_add_spring, nutate_system_add_damping, nutate_system_add_torque, nutate_system_add_rotor, &
      nutate_system_bound_potential, nutate_system_bound_torque
   public :: add, is_finite_or_bad

contains

   integer(c_int) function nutate_system_add_gravity(system, acceleration) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: acceleration(3)
      type(group_t) :: group
      call group%put('acceleration', acceleration)
      code = add(system, 'gravity', group, .not. present(acceleration))
   end function nutate_system_add_gravity

   integer(c_int) function nutate_system_add_dipole(system, moment, field) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: moment(3), field(3)
      type(group_t) :: group
      call group%put('moment', moment)
      call group%put('field', field)
      code = add(system, 'dipole', group, .not. (present(moment) .and. present(field)))
   end function nutate_system_add_dipole

   integer(c_int) function nutate_system_add_gravity_gradient(system, direction, strength) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: direction(3)
      real(c_double), intent(in), value :: strength
      type(group_t) :: group
      call group%put('direction', direction)
      call group%put('strength', [strength])
      code = add(system, 'gravity_gradient', group, .not. present(direction))
   end function nutate_system_add_gravity_gradient

   integer(c_int) function nutate_system_add_spring(system, body_point, anchor, stiffness, rest_length) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: body_point(3), anchor(3)
      real(c_double), intent(in), value :: stiffness, rest_length
      type(group_t) :: group
      call group%put('body_point', body_point)
      call group%put('anchor', anchor)
      call group%put('stiffness', [stiffness])
      call group%put('rest_length', [rest_length])
      code = add(system, 'spring', group, .not. (present(body_point) .and. present(anchor)))
   end function nutate_system_add_spring

   integer(c_int) function nutate_system_add_damping(system, coefficient) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: coefficient(3)
      type(group_t) :: group
      call group%put('coefficient', coefficient)
      code = add(system, 'damping', group, .not. present(coefficient))
   end function nutate_system_add_damping

   integer(c_int) function nutate_system_add_torque(system, torque, in_space, frequency, phase, start, stop) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: torque(3)
      integer(c_int), intent(in), value :: in_space
      real(c_double), intent(in), value :: frequency, phase, start, stop
      type(group_t) :: group
      if (in_space /= 0) then
         call group%put('space', torque)
      else
         call group%put('body', torque)
      end if
      call group%put('frequency', [frequency])
      call group%put('phase', [phase])
      if (is_finite_or_bad(-start)) call group%put('start', [start])
      if (is_finite_or_bad(stop)) call group%put('stop', [stop])
      code = add(system, 'torque', group, .not. present(torque))
   end function nutate_system_add_torque

   integer(c_int) function nutate_system_add_rotor(system, momentum) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: momentum(3)
      type(group_t) :: group
      call group%put('momentum', momentum)
      code = add(system, 'rotor', group, .not. present(momentum))
   end function nutate_system_add_rotor

   integer(c_int) function nutate_system_bound_potential(system, gradient, hessian, third) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), value :: gradient, hessian, third
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      call handle%system%effects%bound_potential(gradient, hessian, third, status)
      code = conclude(handle, status)
   end function nutate_system_bound_potential

   integer(c_int) function nutate_system_bound_torque(system, torque, by_rotation, second, rate) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), value :: torque, by_rotation, second, rate
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      call handle%system%effects%bound_torque(torque, by_rotation, second, rate, status)
      code = conclude(handle, status)
   end function nutate_system_bound_torque

   !> Returns false for +infinity, which stands for no limit; else true, for NaN too.
   pure logical function is_finite_or_bad(x)
      real(wp), intent(in) :: x
      is_finite_or_bad = ieee_is_nan(x)
      if (.not. is_finite_or_bad) is_finite_or_bad = x <= huge(x)
   end function is_finite_or_bad

   !> Adds the effect that a group describes.
   integer(c_int) function add(system, name, group, missing) result(code)
      type(c_ptr), intent(in) :: system
      character(len=*), intent(in) :: name
      type(group_t), intent(inout) :: group
      !> True if an argument is null.
      logical, intent(in) :: missing
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      group%name = name
      if (missing) then
         status = fail(NUTATE_BAD_ARGUMENT, name//': an argument is NULL')
      else if (name == 'rotating_frame' .and. handle%system%effects%frame_turns) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the space axes already rotate (expected one frame)')
      else
         call lock_texts()
         call add_effect_of(group, handle%system, status)
         call unlock_texts()
      end if
      code = conclude(handle, status)
   end function add

end module nutate_c_system_effects
