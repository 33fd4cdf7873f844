!> One key of a scene with given numbers, as text: is it taken? So do `test_limit_c` and `test_limit_f77` from their
!> languages; all tell whether the numbers are treated as a start, not for a run.
module test_limit_text
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_kinds, only: wp
   use nutate_limits, only: is_step
   use nutate_scene, only: parse_scene, read_scene, scene_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: setting_t, effect_text, is_effect, origin, top, up, number_text, text_takes, text_takes_every

   !> A key with its numbers, and what the numbers of the others are where they differ from the usual.
   type :: setting_t
      character(len=24) :: group = '', key = ''
      real(wp) :: values(10) = 0.0_wp
      integer :: n = 1
      !> J of a sphere, kg m²; mass, kg; Ω, body axes, rad/s; time step, s.
      real(wp) :: inertia = 0.1_wp, mass = 1.0_wp, omega(3) = [0.0_wp, 0.0_wp, 0.5_wp], time_step = 0.01_wp
      !> Attitude at the start.
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Edge of the box, m; stiffness of the spring, N/m; field of the dipole, T.
      real(wp) :: edge = 1.0_wp, stiffness = 1.0_wp, field(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   end type setting_t

   !> The usual points and directions of effects.
   real(wp), parameter :: origin(3) = 0.0_wp, top(3) = [0.0_wp, 0.0_wp, 0.25_wp], up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   real(wp), parameter :: usual_tensor(6) = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

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
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      allocate (scene)
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
      case ('inertia_scale')
         text = text//" inertia_table = 'test/inertia_table.csv'"//entry(setting, 'body', 'inertia_scale', [1.0_wp])
      case ('inertia_tensor')
         text = text//entry(setting, 'body', 'inertia_tensor', usual_tensor)
      case default
         if (is_tumbling(setting)) then
            text = text//' inertia = 1, 2, 2.5 /'//new_line('a')
            return
         end if
         text = text//entry(setting, 'body', 'inertia', spread(setting%inertia, 1, 3))// &
                entry(setting, 'body', 'mass', [setting%mass])//entry(setting, 'body', 'center_of_mass', top)
      end select
      text = text//' /'//new_line('a')
   end function body_text

   !> A key that goes with tumbling elements.
   pure logical function is_tumbling(setting)
      type(setting_t), intent(in) :: setting
      is_tumbling = setting%group == 'initial' .and. any(setting%key == [character(len=24) :: 'precession_period', &
         'rotation_period', 'energy_ratio', 'pole', 'precession_angle', 'rotation_phase'])
   end function is_tumbling

   !> The start by tumbling elements, with the key of the setting.
   function tumbling_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      text = "&initial tumbling = 'sam', period_axis = 'short'"//entry(setting, 'initial', 'precession_period', &
           [0.1_wp])// &
             entry(setting, 'initial', 'pole', [0.0_wp, 0.0_wp])
      if (setting%key == 'rotation_period') then
         text = text//entry(setting, 'initial', 'rotation_period', [1.0_wp])
      else
         text = text//entry(setting, 'initial', 'energy_ratio', [1.1_wp])
      end if
      if (setting%key == 'precession_angle' .or. setting%key == 'rotation_phase') &
         text = text//entry(setting, 'initial', trim(setting%key), [0.0_wp])
      text = text//' /'//new_line('a')
   end function tumbling_text

   function initial_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      if (is_tumbling(setting)) then
         text = tumbling_text(setting)
         return
      end if
      text = '&initial'
      select case (merge(setting%key, repeat(' ', 24), setting%group == 'initial'))
      case ('quaternion')
         text = text//entry(setting, 'initial', 'quaternion', setting%q)
      case ('axis', 'angle')
         text = text//entry(setting, 'initial', 'axis', up)//entry(setting, 'initial', 'angle', [0.5_wp])
      case ('roll_pitch_yaw')
         text = text//entry(setting, 'initial', 'roll_pitch_yaw', origin)
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
      if (is_step(step)) end_time = 8*step
      if (setting%group == 'integrator') then
         select case (setting%key)
         case ('accuracy', 'local_tolerance')
            text = text//entry(setting, 'integrator', trim(setting%key), [0.5_wp])
         case ('max_step')
            text = text//entry(setting, 'integrator', 'max_step', [1.0_wp])//' local_tolerance = 0.5'
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

   !> True for the group of an effect.
   logical function is_effect(group)
      character(len=*), intent(in) :: group
      type(effect_kind_t), allocatable :: kinds(:)
      integer :: i
      allocate (kinds, source=effect_kinds())
      is_effect = any([(kinds(i)%group%name == group, i=1, size(kinds))])
   end function is_effect

   !> The group of an effect as in test/effect_samples.nml, but for, or with, the key of the setting.
   function sample_text(setting, group) result(text)
      type(setting_t), intent(in) :: setting
      character(len=*), intent(in) :: group
      character(len=:), allocatable :: text, message
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      integer :: i, k
      allocate (scene)
      text = ''
      call read_scene('test/effect_samples.nml', scene, status, message)
      if (.not. status%ok()) return
      do i = 1, size(scene%groups)
         if (scene%groups(i)%name /= group) cycle
         if (.not. scene%groups(i)%has(trim(setting%key))) text = entry(setting, group, trim(setting%key), [0.0_wp])
         do k = 1, size(scene%groups(i)%settings)
            associate (known => scene%groups(i)%settings(k))
               ! Beside the limit of a speed torques are constant.
               if (setting%key == 'speed_limit' .and. known%name == 'frequency') cycle
               text = text//entry(setting, group, trim(known%name), known%values%number)
            end associate
         end do
         return
      end do
   end function sample_text

   !> The group of a setting of an effect, or of `&output`; empty for others.
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
      case ('inertia_rate')
         ! The change is after the run.
         text = entry(setting, group, 'tensor', usual_tensor)
         if (setting%key /= 'stop') text = text//entry(setting, group, 'start', [1.0_wp])
         if (setting%key == 'stop') text = text//entry(setting, group, 'stop', [0.0_wp])
      case ('rotor')
         text = entry(setting, group, 'momentum', up)
      case ('rotating_frame')
         text = entry(setting, group, trim(setting%key), [0.0_wp])
      case ('controller')
         text = controller_text(setting)
      case ('orbit')
         text = orbit_text(setting)
      case ('earth_field', 'third_degree')
         text = entry(setting, group, trim(setting%key), [0.0_wp])
      case ('force')
         text = entry(setting, group, 'body_point', top)//entry(setting, group, 'force', up)//" axes = 'space'"
         if (any(setting%key == ['start', 'stop '])) text = text//entry(setting, group, trim(setting%key), [0.0_wp])
      case ('event')
         text = " when = 'omega1'"//entry(setting, group, 'crosses', [0.5_wp])
         if (setting%key /= 'crosses') text = text//entry(setting, group, trim(setting%key), [1.0_wp])
      case ('vary')
         text = variation_text(setting)
      case ('free')
         text = " key = 'initial.angular_velocity.1'"//entry(setting, group, trim(setting%key), [0.0_wp])
      case ('measurement')
         text = measurement_text(setting)
      case ('chaos')
         text = entry(setting, group, trim(setting%key), [0.0_wp])
      case ('output')
         text = entry(setting, group, merge('times   ', 'interval', setting%key == 'times'), [0.5_wp])
      case default
         text = ''
         if (is_effect(group)) text = sample_text(setting, group)
      end select
      if (text /= '') text = '&'//group//text//' /'//new_line('a')
      if (group == 'earth_field' .or. group == 'third_degree') text = '&orbit semi_major_axis = 1e9 / '//text
      if (group == 'vary') text = '&ensemble members = 2 / '//text
   end function effect_text

   !> The keys of a controller: of B-dot for those that it alone has.
   function controller_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      character(len=*), parameter :: group = 'controller'
      select case (setting%key)
      case ('gain', 'field')
         ! The gain is so weak that the limit of the field is its own, not that of the torque.
         text = " law = 'bdot'"//entry(setting, group, 'gain', [0.25_wp])//entry(setting, group, 'field', up)
      case default
         text = " law = 'quaternion'"
         if (setting%key /= 'attitude_gain_matrix') text = text//entry(setting, group, 'attitude_gain', [0.5_wp])
         if (setting%key /= 'rate_gain_matrix') text = text//entry(setting, group, 'rate_gain', [0.5_wp])
         if (all(setting%key /= ['attitude_gain', 'rate_gain    '])) text = text// &
            entry(setting, group, trim(setting%key), [0.0_wp])
         if (setting%key == 'limit') text = text//' sample = 1'
      end select
   end function controller_text

   !> The keys of a group `&orbit`. Next to the mass of the Earth a small orbit turns too fast for a step.
   function orbit_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      character(len=*), parameter :: group = 'orbit'
      select case (setting%key)
      case ('altitude')
         text = entry(setting, group, 'altitude', [5e5_wp])
      case ('semi_major_axis')
         text = entry(setting, group, 'semi_major_axis', [7e6_wp])//' mu = 1e-100'
      case ('mu')
         text = ' semi_major_axis = 1e30'//entry(setting, group, 'mu', [1.0_wp])
      case ('shadow_radius')
         text = ' semi_major_axis = 7e6 sun = 0 0 1'//entry(setting, group, 'shadow_radius', [1.0_wp])
      case ('periapsis_distance')
         text = entry(setting, group, 'periapsis_distance', [7e6_wp])//' mu = 1e-100'
      case ('periapsis_time')
         text = ' periapsis_distance = 7e6 eccentricity = 2'//entry(setting, group, 'periapsis_time', [0.0_wp])
      case default
         text = ' semi_major_axis = 7e6'//entry(setting, group, trim(setting%key), [0.0_wp])
      end select
   end function orbit_text

   !> The keys of a group `&vary`, and an ensemble before it.
   function variation_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      text = " key = 'initial.angular_velocity.1', distribution ="
      select case (setting%key)
      case ('low')
         text = text//" 'uniform', high = 1e100"//entry(setting, 'vary', 'low', [0.0_wp])
      case ('high')
         text = text//" 'uniform', low = -1e100"//entry(setting, 'vary', 'high', [0.0_wp])
      case ('mean')
         text = text//" 'normal', sigma = 1.0"//entry(setting, 'vary', 'mean', [0.0_wp])
      case default
         text = text//" 'normal'"//entry(setting, 'vary', trim(setting%key), [0.0_wp])
      end select
   end function variation_text

   !> The keys of a group `&measurement`, and a file that it names.
   function measurement_text(setting) result(text)
      type(setting_t), intent(in) :: setting
      character(len=:), allocatable :: text
      character(len=*), parameter :: file = 'build/limit_rows.csv'
      integer :: unit
      open (newunit=unit, file=file, status='replace')
      write (unit, '(a)') 't,x,y,z', '0,0,0,1'
      close (unit)
      text = " file = '"//file//"', columns = 'x', 'y', 'z'"//entry(setting, 'measurement', 'direction', &
                                                                      [0.0_wp, 0.0_wp, 1.0_wp])
      if (setting%key == 'sigma') text = text//entry(setting, 'measurement', 'sigma', [1.0_wp])
   end function measurement_text

   !> True if a scene takes so many steps between rows.
   logical function text_takes_every(every)
      integer, intent(in) :: every
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=12) :: digits
      allocate (scene)
      write (digits, '(i0)') every
      call parse_scene(body_text(setting_t())//initial_text(setting_t())//integrator_text(setting_t())// &
                       '&output every = '//trim(digits)//' /', 'a.nml', scene, status, message)
      text_takes_every = status%ok()
   end function text_takes_every

end module test_limit_text
