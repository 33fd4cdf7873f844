!> One key of a scene with given numbers, as arguments of the functions of C: are they taken?
module test_limit_c
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_funloc, c_int, c_int64_t, c_loc, &
      c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t
   use nutate_c_attitude, only: nutate_omega_from_euler_rates, nutate_quat_from_axis_angle, nutate_quat_from_euler
   use nutate_c_general, only: nutate_last_message
   use nutate_c_runs, only: nutate_stepper_count_rows, nutate_stepper_run_to
   use nutate_c_stepper, only: nutate_stepper_create, nutate_stepper_destroy, nutate_stepper_prepare, &
      nutate_stepper_set, nutate_stepper_set_state, nutate_stepper_set_time_step
   use nutate_c_stepping, only: nutate_stepper_step
   use nutate_c_system, only: nutate_system_create_moments, nutate_system_create_shape, nutate_system_create_tensor, &
      nutate_system_add_groups, nutate_system_add_potential, nutate_system_destroy
   use nutate_c_system_effects, only: nutate_system_add_damping, nutate_system_add_dipole, nutate_system_add_gravity, &
      nutate_system_add_gravity_gradient, nutate_system_add_rotor, nutate_system_add_spring, nutate_system_add_torque
   use nutate_kinds, only: wp
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_OK
   use test_limit_text, only: effect_text, is_effect, number_text, origin, setting_t, top, up
   implicit none
   private

   public :: c_takes, c_takes_direction, c_takes_every

contains

   !> The numbers of a key, or the usual ones.
   function numbers_of(setting, key, usual) result(x)
      type(setting_t), intent(in) :: setting
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: usual(:)
      real(wp) :: x(size(usual))
      x = usual
      if (setting%key == key) x = setting%values(1:size(usual))
   end function numbers_of

   !> One number of a key, or the usual one.
   real(wp) function number_of(setting, key, usual)
      type(setting_t), intent(in) :: setting
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: usual
      number_of = usual
      if (setting%key == key) number_of = setting%values(1)
   end function number_of

   !> True if the functions of C that have the numbers as arguments take them; `message` says why not.
   logical function c_takes(setting, message)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable, intent(out) :: message
      type(c_ptr), target :: system, stepper
      character(kind=c_char), target :: buffer(512)
      integer(c_size_t) :: room
      integer :: code, ignored

      system = c_null_ptr
      stepper = c_null_ptr
      buffer = c_null_char
      code = c_body(setting, system, buffer)
      if (code == NUTATE_OK) then
         code = c_effect(setting, system)
         ignored = nutate_last_message(system, c_loc(buffer), size(buffer, kind=c_size_t))
      end if
      room = size(buffer, kind=c_size_t)
      if (code == NUTATE_OK) code = nutate_stepper_create(system, c_loc(stepper), c_loc(buffer), room)
      if (code == NUTATE_OK) then
         code = c_start(setting, stepper)
         ignored = nutate_last_message(stepper, c_loc(buffer), size(buffer, kind=c_size_t))
      end if
      c_takes = code == NUTATE_OK
      message = text_of(buffer)
      if (all(code /= [NUTATE_OK, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY])) message = 'of another kind: '//message
      ignored = nutate_stepper_destroy(c_loc(stepper)) + nutate_system_destroy(c_loc(system))
   end function c_takes

   function text_of(buffer) result(text)
      character(kind=c_char), intent(in) :: buffer(:)
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(buffer)
         if (buffer(i) == c_null_char) exit
         text = text//buffer(i)
      end do
   end function text_of

   integer function c_body(setting, system, buffer) result(code)
      type(setting_t), intent(in) :: setting
      type(c_ptr), intent(inout), target :: system
      character(kind=c_char), intent(inout), target :: buffer(:)
      character(kind=c_char), target :: box(4)
      real(wp), target :: size_of_box(3)
      integer(c_size_t) :: room
      type(setting_t) :: own
      room = size(buffer, kind=c_size_t)
      box = ['b', 'o', 'x', c_null_char]
      select case (merge(setting%key, repeat(' ', 24), setting%group == 'body'))
      case ('size')
         size_of_box = setting%values(1:3)
         code = nutate_system_create_shape(c_loc(box), c_loc(size_of_box), 3_c_size_t, 1.0_wp, 0.0_wp, &
                                           system=c_loc(system), message=c_loc(buffer), size=room)
      case ('density')
         size_of_box = setting%edge
         code = nutate_system_create_shape(c_loc(box), c_loc(size_of_box), 3_c_size_t, 0.0_wp, setting%values(1), &
                                           system=c_loc(system), message=c_loc(buffer), size=room)
      case ('inertia_tensor')
         code = nutate_system_create_tensor(setting%values, 0.0_wp, about_center=0, system=c_loc(system), &
                                            message=c_loc(buffer), size=room)
      case default
         ! A wheel has an inertia too.
         own = setting
         if (setting%group /= 'body') own%key = ''
         code = nutate_system_create_moments(numbers_of(own, 'inertia', spread(setting%inertia, 1, 3)), &
                                             number_of(own, 'mass', setting%mass), &
                                             numbers_of(own, 'center_of_mass', top), 0, c_loc(system), &
                                             c_loc(buffer), room)
      end select
   end function c_body

   integer function c_effect(setting, system) result(code)
      type(setting_t), intent(in) :: setting
      type(c_ptr), intent(in) :: system
      real(wp) :: window(2)
      character(len=5) :: axes
      select case (setting%group)
      case ('gravity')
         code = nutate_system_add_gravity(system, numbers_of(setting, 'acceleration', up))
      case ('dipole')
         code = nutate_system_add_dipole(system, numbers_of(setting, 'moment', up), &
                                         numbers_of(setting, 'field', setting%field))
      case ('gravity_gradient')
         code = nutate_system_add_gravity_gradient(system, numbers_of(setting, 'direction', up), &
                                                   number_of(setting, 'strength', 1.0_wp))
      case ('spring')
         code = nutate_system_add_spring(system, numbers_of(setting, 'body_point', top), &
                                         numbers_of(setting, 'anchor', top), &
                                         number_of(setting, 'stiffness', setting%stiffness), &
                                         number_of(setting, 'rest_length', 0.25_wp))
      case ('damping')
         code = nutate_system_add_damping(system, numbers_of(setting, 'coefficient', up))
      case ('torque')
         ! Times that are not given stay open: infinities for C.
         window = [number_of(setting, 'start', -infinity()), number_of(setting, 'stop', infinity())]
         axes = merge('space', 'body ', setting%key == 'space')
         code = nutate_system_add_torque(system, numbers_of(setting, axes, up), &
                                         merge(1, 0, setting%key == 'space'), number_of(setting, 'frequency', 0.0_wp), &
                                         number_of(setting, 'phase', 0.0_wp), window(1), window(2))
      case ('rotor')
         code = nutate_system_add_rotor(system, numbers_of(setting, 'momentum', up))
      case default
         code = NUTATE_OK
         if (is_effect(setting%group)) code = c_groups(effect_text(setting), system)
      end select
   end function c_effect

   !> Effects without a function of their own come as groups of a scene.
   integer function c_groups(text, system) result(code)
      character(len=*), intent(in) :: text
      type(c_ptr), intent(in) :: system
      character(kind=c_char), target :: characters(len(text) + 1)
      integer :: i
      characters = [(text(i:i), i=1, len(text)), c_null_char]
      code = nutate_system_add_groups(system, c_loc(characters))
   end function c_groups

   pure real(wp) function infinity()
      use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
      infinity = ieee_value(infinity, ieee_positive_inf)
   end function infinity

   !> State and settings, and for `time_step` and what moves a step.
   integer function c_start(setting, stepper) result(code)
      type(setting_t), intent(in) :: setting
      type(c_ptr), intent(in) :: stepper
      real(wp) :: q(4), omega(3)
      character(len=:), allocatable :: key
      integer(c_size_t) :: n
      key = ''
      if (any(setting%group == [character(len=10) :: 'initial', 'integrator', 'output'])) key = trim(setting%key)
      q = setting%q
      omega = setting%omega
      code = NUTATE_OK
      select case (key)
      case ('quaternion')
         q = setting%values(1:4)
      case ('axis', 'angle')
         code = nutate_quat_from_axis_angle(numbers_of(setting, 'axis', up), number_of(setting, 'angle', 0.5_wp), q)
      case ('euler')
         code = nutate_quat_from_euler(setting%values(1:3), q)
      case ('euler_rates')
         code = nutate_omega_from_euler_rates(origin, setting%values(1:3), omega)
      case ('angular_velocity')
         omega = setting%values(1:3)
      case default
         ! The key is one of a setting, not of the state.
      end select
      if (code == NUTATE_OK) code = nutate_stepper_set_state(stepper, 0.0_wp, q, omega)
      if (code /= NUTATE_OK) return
      select case (key)
      case ('accuracy', 'local_tolerance', 'tolerance', 'auxiliary_inertia')
         code = c_set(stepper, key, setting%values(1))
      case ('interval')
         code = c_set(stepper, 'accuracy', 1e-6_wp)
         if (code == NUTATE_OK) code = c_run_to(stepper, setting%values(1))
         return
      case default
         code = nutate_stepper_set_time_step(stepper, number_of(setting, 'time_step', setting%time_step))
      end select
      if (code == NUTATE_OK) code = nutate_stepper_prepare(stepper)
      if (key == 'end_time') then
         if (code == NUTATE_OK) code = nutate_stepper_count_rows(stepper, setting%values(1), 1_c_int64_t, n)
         return
      end if
      if (code == NUTATE_OK .and. all(key /= ['accuracy       ', 'local_tolerance', 'tolerance      '])) &
         code = refusal_of(nutate_stepper_step(stepper, number_of(setting, 'time_step', setting%time_step)))
   end function c_start

   !> A step that does not succeed has been begun: only a refusal counts.
   integer function refusal_of(code)
      integer, intent(in) :: code
      refusal_of = merge(code, NUTATE_OK, any(code == [NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY]))
   end function refusal_of

   !> A run with rows of an interval, short enough for any: the array has room for a few, and the run ends there.
   integer function c_run_to(stepper, interval) result(code)
      type(c_ptr), intent(in) :: stepper
      real(wp), intent(in) :: interval
      real(wp), target :: rows(15, 3)
      integer(c_size_t) :: n
      code = refusal_of(nutate_stepper_run_to(stepper, 0.08_wp, 1_c_int64_t, interval, c_loc(rows), 3_c_size_t, n))
   end function c_run_to

   integer function c_set(stepper, key, value) result(code)
      type(c_ptr), intent(in) :: stepper
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: value
      character(kind=c_char), target :: name(25), text(40)
      call to_c(key, name)
      call to_c(number_text(value), text)
      code = nutate_stepper_set(stepper, c_loc(name), c_loc(text))
   end function c_set

   subroutine to_c(text, bytes)
      character(len=*), intent(in) :: text
      character(kind=c_char), intent(out) :: bytes(:)
      integer :: i
      bytes = c_null_char
      do i = 1, len(text)
         bytes(i) = text(i:i)
      end do
   end subroutine to_c

   !> True if C takes a potential of its own along a direction.
   logical function c_takes_direction(direction)
      real(wp), intent(in) :: direction(3)
      type(c_ptr), target :: system
      integer :: code
      code = nutate_system_create_moments([1.0_wp, 1.0_wp, 1.0_wp], 0.0_wp, about_center=0, system=c_loc(system), &
                                          message=c_null_ptr, size=0_c_size_t)
      code = nutate_system_add_potential(system, direction, c_funloc(no_energy), c_null_funptr, c_null_ptr)
      c_takes_direction = code == NUTATE_OK
      code = nutate_system_destroy(c_loc(system))
   end function c_takes_direction

   !> A potential of C that does nothing.
   integer(c_int) function no_energy(gamma, user, energy, gradient) bind(C)
      real(c_double), intent(in) :: gamma(3)
      type(c_ptr), intent(in), value :: user
      real(c_double), intent(out) :: energy, gradient(3)
      energy = 0*gamma(1)
      gradient = 0.0_wp
      no_energy = merge(0, 1, .not. c_associated(user))
   end function no_energy

   !> True if C takes so many steps between rows.
   logical function c_takes_every(every)
      integer, intent(in) :: every
      type(c_ptr), target :: system, stepper
      integer(c_size_t) :: n
      integer :: code
      code = nutate_system_create_moments([1.0_wp, 1.0_wp, 1.0_wp], 0.0_wp, about_center=0, system=c_loc(system), &
                                          message=c_null_ptr, size=0_c_size_t)
      code = nutate_stepper_create(system, c_loc(stepper), c_null_ptr, 0_c_size_t)
      code = nutate_stepper_set_time_step(stepper, 0.1_wp)
      code = nutate_stepper_run_to(stepper, 1.0_wp, int(every, c_int64_t), 0.0_wp, c_null_ptr, 0_c_size_t, n)
      c_takes_every = code == NUTATE_OK
      code = nutate_stepper_destroy(c_loc(stepper)) + nutate_system_destroy(c_loc(system))
   end function c_takes_every

end module test_limit_c
