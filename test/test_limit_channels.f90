!> One key of a scene with given numbers, by each way that it can reach the library: as text, by the function of C, by
!> the argument of a FORTRAN 77 routine. Each tells whether the numbers are taken: for a start that is, not for a run.
module test_limit_channels
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_funloc, c_int, c_int64_t, c_loc, &
      c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t
   use nutate_c_attitude, only: nutate_omega_from_euler_rates, nutate_quat_from_axis_angle, nutate_quat_from_euler
   use nutate_c_general, only: nutate_last_message
   use nutate_c_runs, only: nutate_stepper_count_rows, nutate_stepper_run_to
   use nutate_c_stepper, only: nutate_stepper_create, nutate_stepper_destroy, nutate_stepper_prepare, &
      nutate_stepper_set, nutate_stepper_set_state, nutate_stepper_set_time_step
   use nutate_c_stepping, only: nutate_stepper_step
   use nutate_c_system, only: nutate_system_create_moments, nutate_system_create_shape, nutate_system_create_tensor, &
      nutate_system_add_potential, nutate_system_destroy
   use nutate_c_system_effects, only: nutate_system_add_damping, nutate_system_add_dipole, nutate_system_add_gravity, &
      nutate_system_add_gravity_gradient, nutate_system_add_rotor, nutate_system_add_spring, nutate_system_add_torque
   use nutate_kinds, only: wp
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_OK
   use test_f77_routines, only: nue2q, nuinit, nuinv, nusetp, nustep, potnan, potspr, tormot
   implicit none
   private

   public :: setting_t, text_takes, c_takes, f77_takes, number_text
   public :: c_takes_direction, f77_takes_direction, f77_takes_energy

   !> A key with its numbers, and what the numbers of the others are where they differ from the usual.
   type :: setting_t
      character(len=24) :: group = '', key = ''
      real(wp) :: values(6) = 0.0_wp
      integer :: n = 1
      !> J of a sphere, kg m²; mass, kg; Ω, body axes, rad/s; time step, s.
      real(wp) :: inertia = 0.1_wp, mass = 1.0_wp, omega(3) = [0.0_wp, 0.0_wp, 0.5_wp], time_step = 0.01_wp
      !> Attitude at the start.
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Edge of the box, m; stiffness of the spring, N/m; field of the dipole, T.
      real(wp) :: edge = 1.0_wp, stiffness = 1.0_wp, field(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   end type setting_t

   real(wp), parameter :: origin(3) = 0.0_wp, &
                          top(3) = [0.0_wp, 0.0_wp, 0.25_wp], up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   real(wp), parameter :: plain(7) = 0.0_wp
   real(wp), parameter :: unit_tensor(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
                                                       1.0_wp], [3, 3])
   integer, parameter :: work_size = 2000, iuser(2) = [3, 0]

contains

   !> A number as a scene has it, with as many digits as read back exactly.
   function number_text(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      character(len=32) :: digits
      if (ieee_is_nan(x)) then
         digits = 'NaN'
      else if (.not. ieee_is_finite(x)) then
         digits = merge('Infinity ', '-Infinity', x > 0.0_wp)
      else
         write (digits, '(es26.16e3)') x
      end if
      text = trim(adjustl(digits))
   end function number_text

   function numbers_text(x) result(text)
      real(wp), intent(in) :: x(:)
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(x)
         text = text//' '//number_text(x(i))
      end do
   end function numbers_text

   !> ` key = numbers`, of the setting or the usual ones.
   function entry(setting, group, key, usual) result(text)
      type(setting_t), intent(in) :: setting
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: usual(:)
      character(len=:), allocatable :: text
      if (setting%group == group .and. setting%key == key) then
         text = ' '//key//' ='//numbers_text(setting%values(1:setting%n))
      else
         text = ' '//key//' ='//numbers_text(usual)
      end if
   end function entry

   !> True if a scene with the setting is accepted; `message` says why not.
   logical function text_takes(setting, message)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable, intent(out) :: message
      type(scene_t) :: scene
      type(status_t) :: status
      call parse_scene(body_text(setting)//initial_text(setting)//integrator_text(setting)//effect_text(setting), &
                       'a.nml', scene, status, message)
      text_takes = status%ok()
   end function text_takes

   function body_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      text = '&body'
      select case (merge(setting%key, repeat(' ', 24), setting%group == 'body'))
      case ('size', 'density')
         text = text//" shape = 'box'"//entry(setting, 'body', 'size', spread(setting%edge, 1, 3))
         if (setting%key == 'size') text = text//' mass = 1'
         if (setting%key == 'density') text = text//entry(setting, 'body', 'density', [1.0_wp])
      case ('inertia_tensor')
         text = text//entry(setting, 'body', 'inertia_tensor', plain(1:6))
      case default
         text = text//entry(setting, 'body', 'inertia', spread(setting%inertia, 1, 3))// &
                entry(setting, 'body', 'mass', [setting%mass])//entry(setting, 'body', 'center_of_mass', top)
      end select
      text = text//' /'//new_line('a')
   end function body_text

   function initial_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      text = '&initial'
      select case (merge(setting%key, repeat(' ', 24), setting%group == 'initial'))
      case ('quaternion')
         text = text//entry(setting, 'initial', 'quaternion', setting%q)
      case ('axis', 'angle')
         text = text//entry(setting, 'initial', 'axis', up)//entry(setting, 'initial', 'angle', [0.5_wp])
      case ('euler', 'euler_rates')
         text = text//entry(setting, 'initial', 'euler', origin)
      case default
         text = text//entry(setting, 'initial', 'quaternion', setting%q)
      end select
      if (setting%group == 'initial' .and. setting%key == 'euler_rates') then
         text = text//entry(setting, 'initial', 'euler_rates', setting%omega)
      else
         text = text//entry(setting, 'initial', 'angular_velocity', setting%omega)
      end if
      text = text//' /'//new_line('a')
   end function initial_text

   function integrator_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      real(wp) :: step, end_time
      text = '&integrator'
      step = setting%time_step
      if (setting%group == 'integrator' .and. setting%key == 'time_step') step = setting%values(1)
      end_time = 1.0_wp
      if (abs(step) > 1e-90_wp .and. abs(step) < 1e90_wp) end_time = 8*step
      if (setting%group == 'integrator') then
         select case (setting%key)
         case ('accuracy', 'local_tolerance')
            text = text//entry(setting, 'integrator', trim(setting%key), [0.5_wp])
         case ('tolerance', 'auxiliary_inertia')
            text = text//entry(setting, 'integrator', trim(setting%key), [0.5_wp])// &
                   entry(setting, 'integrator', 'time_step', [step])
         case default
            text = text//entry(setting, 'integrator', 'time_step', [step])
         end select
      else if (setting%group == 'output') then
         text = text//' accuracy = 1e-6'
      else
         text = text//entry(setting, 'integrator', 'time_step', [step])
      end if
      text = text//entry(setting, 'integrator', 'end_time', [end_time])//' /'//new_line('a')
   end function integrator_text

   function effect_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      character(len=:), allocatable :: group
      group = trim(setting%group)
      select case (group)
      case ('gravity')
         text = entry(setting, group, 'acceleration', up)
      case ('dipole')
         text = entry(setting, group, 'moment', up)//entry(setting, group, 'field', setting%field)
      case ('gravity_gradient')
         text = entry(setting, group, 'direction', up)//entry(setting, group, 'strength', [1.0_wp])
      case ('spring')
         text = entry(setting, group, 'body_point', top)//entry(setting, group, 'anchor', top)// &
                entry(setting, group, 'stiffness', [setting%stiffness])//entry(setting, group, 'rest_length', [0.25_wp])
      case ('damping')
         text = entry(setting, group, 'coefficient', up)
      case ('torque')
         text = entry(setting, group, merge('space', 'body ', setting%key == 'space'), up)
         if (all(setting%key /= ['body ', 'space'])) text = text//entry(setting, group, trim(setting%key), [0.0_wp])
      case ('rotor')
         text = entry(setting, group, 'momentum', up)
      case ('output')
         text = entry(setting, group, 'interval', [0.5_wp])
      case default
         text = ''
      end select
      if (text /= '') text = '&'//group//text//' /'//new_line('a')
   end function effect_text

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
         code = nutate_system_create_moments(numbers_of(setting, 'inertia', spread(setting%inertia, 1, 3)), &
                                             number_of(setting, 'mass', setting%mass), &
                                             numbers_of(setting, 'center_of_mass', top), 0, c_loc(system), &
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
         ! What is not given stays open: for C that is an infinity.
         window = [number_of(setting, 'start', -infinity()), number_of(setting, 'stop', infinity())]
         axes = merge('space', 'body ', setting%key == 'space')
         code = nutate_system_add_torque(system, numbers_of(setting, axes, up), &
                                         merge(1, 0, setting%key == 'space'), number_of(setting, 'frequency', 0.0_wp), &
                                         number_of(setting, 'phase', 0.0_wp), window(1), window(2))
      case ('rotor')
         code = nutate_system_add_rotor(system, numbers_of(setting, 'momentum', up))
      case default
         code = NUTATE_OK
      end select
   end function c_effect

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
         ! Of a setting, not of the state.
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

   !> True if the FORTRAN 77 routine with the argument takes it; `known` if there is one.
   logical function f77_takes(setting, known)
      type(setting_t), intent(in) :: setting
      logical, intent(out) :: known
      real(wp) :: aj(3, 3), aj0, h(3), cm(3), g(3), d(3), work(work_size), t, q(4), p(4), dt, omega(3)
      integer :: info, k
      known = .true.
      aj = 0.0_wp
      do k = 1, 3
         aj(k, k) = setting%inertia
      end do
      aj0 = 0.0_wp
      h = 0.0_wp
      d = 0.0_wp
      cm = setting%mass*top
      g = 0.0_wp
      dt = setting%time_step
      q = setting%q
      omega = setting%omega
      info = 0
      select case (trim(setting%group)//'.'//trim(setting%key))
      case ('body.inertia')
         do k = 1, 3
            aj(k, k) = setting%values(k)
         end do
      case ('body.inertia_tensor')
         associate (j => setting%values)
            aj = reshape([j(1), j(4), j(5), j(4), j(2), j(6), j(5), j(6), j(3)], [3, 3])
         end associate
      case ('integrator.auxiliary_inertia'); aj0 = setting%values(1)
      case ('rotor.momentum'); h = setting%values(1:3)
      case ('gravity.acceleration'); g = setting%values(1:3)
      case ('damping.coefficient'); d = setting%values(1:3)
      case ('initial.angular_velocity'); omega = setting%values(1:3)
      case ('initial.euler'); call nue2q(setting%values(1), setting%values(2), setting%values(3), q, info)
      case ('integrator.time_step'); dt = setting%values(1)
      case default; known = .false.
      end select
      if (info == 0) call nuinit(aj, aj0, h, cm, g, d, up, 2, 2, 0, work, work_size, info)
      if (info == 0) call nusetp(q, omega, p, work, work_size, info)
      t = 0.0_wp
      if (info == 0) call nustep(1, dt, t, q, p, potspr, tormot, iuser, plain, work, work_size, info)
      ! INFO > 0 is too late: the argument has been taken.
      f77_takes = info >= 0
   end function f77_takes

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

   !> True if NUINIT takes the direction of POT.
   logical function f77_takes_direction(direction)
      real(wp), intent(in) :: direction(3)
      real(wp) :: work(work_size)
      integer :: info
      call nuinit(unit_tensor, 0.0_wp, origin, origin, origin, origin, direction, 1, 2, 1, work, work_size, info)
      f77_takes_direction = info == 0
   end function f77_takes_direction

   !> True if NUINV takes the energy of POT.
   logical function f77_takes_energy(energy)
      real(wp), intent(in) :: energy
      real(wp) :: work(work_size), e(3), al(3, 2), c(2)
      integer :: info
      call nuinit(unit_tensor, 0.0_wp, origin, origin, origin, origin, up, 1, 2, 1, work, work_size, info)
      call nuinv([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], potnan, iuser, &
                 [plain(1:6), energy], e, al, c, work, work_size, info)
      f77_takes_energy = info == 0
   end function f77_takes_energy

end module test_limit_channels
