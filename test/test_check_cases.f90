!> Check cases 10A and 10B of the NASA Engineering and Safety Center (NASA/TM-2015-218675) as JEOD has them: the gravity
!> gradient on a long cylinder on a circular orbit. Numbers of two methods in 128-bit arithmetic.
submodule(suites_of_effects) test_check_cases
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, pi
   use nutate_periodic_start, only: find_periodic_start, periodic_start_t
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   character, parameter :: nl = new_line('a')
   !> Mean motion, rad/s.
   real(wp), parameter :: mean_motion = 0.0011369078529289871_wp
   !> 1000 kg, 12 m long, 1 m in radius; a spherical Earth.
   character(len=*), parameter :: cylinder = '&body inertia = 500.0, 12250.0, 12250.0 /'//nl// &
      "&orbit semi_major_axis = 6756095.0, frame = 'lvlh' /"//nl//'&gravity_gradient /'//nl

   !> t, the attitude in the LVLH frame, Ω2, Ω3; Ω1 stays.
   real(wp), parameter :: omega1 = -1.984177793105603e-05_wp
   real(wp), parameter :: case_10a(7, 4) = reshape([ &
      600.0_wp, 0.7194419393815384_wp, 0.0001917050359229728_wp, 0.6945465801103467_wp, 0.002882215316699578_wp, &
      -0.0009828028737645809_wp, -4.029531611761019e-05_wp, &
      3600.0_wp, 0.7309045724934126_wp, -0.02357918166414719_wp, 0.6817883701816931_wp, 0.01967603581165482_wp, &
      -0.001031237681779574_wp, -0.0001007294919531874_wp, &
      14400.0_wp, 0.6746597213015703_wp, -0.08831877448183007_wp, 0.7253031489142182_wp, 0.1047348877043107_wp, &
      -0.001002120776779925_wp, -0.000308779637059417_wp, &
      28800.0_wp, 0.6933292149560277_wp, -0.1965545847447972_wp, 0.6670678718650391_wp, 0.1888950746570871_wp, &
      -0.001075275770224725_wp, -0.0007088567190357103_wp], [7, 4])
   real(wp), parameter :: case_10b(7, 2) = reshape([ &
      600.0_wp, 0.6900135514053427_wp, 0.0002215795587781857_wp, 0.7237880997488715_wp, 0.003469357491410394_wp, &
      -0.000912328719676459_wp, -3.958029237280174e-05_wp, &
      28800.0_wp, 0.7181212929138288_wp, -0.2042288769354876_wp, 0.6400112106782583_wp, 0.1815985261382661_wp, &
      -0.001030730672601492_wp, -0.0006821076766417492_wp], [7, 2])

contains

   module procedure collect_check_cases
      testsuite = [ &
                  new_unittest("case 10A, at rest in the LVLH frame", at_rest), &
                  new_unittest("case 10B, with a pitch rate", with_rate), &
                  new_unittest("swings in the plane have their elliptic periods", swings), &
                  new_unittest("small swings in the plane and across it", small_swings)]
   end procedure collect_check_cases

   !> Pitch of 85°, then a yaw of 1° about the new axis.
   subroutine at_rest(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, '3*0.0', case_10a)
   end subroutine at_rest

   subroutine with_rate(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, '0.0, 0.00017453292519943296, 0.0', case_10b)
   end subroutine with_rate

   !> Runs a case by the series and by order 8.
   subroutine check_case(error, rate, table)
      type(error_type), allocatable, intent(inout) :: error
      !> Relative to the LVLH frame, body axes, rad/s.
      character(len=*), intent(in) :: rate
      real(wp), intent(in) :: table(:, :)
      character(len=*), parameter :: methods(2) = [character(len=60) :: &
         "method = 'taylor', local_tolerance = 1e-15", "formulation = 'reduced', order = 8, time_step = 60.0"]
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: omega(3)
      integer :: i, k
      allocate (scene)
      do k = 1, size(methods)
         call read_case(error, 'quaternion = 0.7372492635482824, 0.005895561929111876, 0.6755644832106784, '// &
                        '0.006433876851820143, angular_velocity = '//rate, trim(methods(k)), scene)
         if (allocated(error)) return
         state = scene%initial
         do i = 1, size(table, 2)
            scene%plan%end_time = table(1, i)
            call integrate(scene%system, scene%integrator, state, scene%plan, status)
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            call check_close(error, sign(1.0_wp, dot_product(state%q, table(2:5, i)))*state%q, table(2:5, i), &
                 1e-11_wp, &
                             'attitude')
            omega = angular_velocity(scene%system, state)
            call check_close(error, omega/mean_motion, [omega1, table(6:7, i)]/mean_motion, 1e-11_wp, 'rate')
         end do
      end do
   end subroutine check_case

   subroutine read_case(error, start, method, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: start, method
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(cylinder//'&initial '//start//", attitude_from = 'lvlh', rate_from = 'lvlh' /"//nl// &
                       '&integrator '//method//', end_time = 28800.0 /', 's.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read_case

   !> A quarter of the period of a pendulum from the greatest angle to the vertical, and back after a whole one.
   subroutine swings(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: angles(3) = [1.0_wp, 5.0_wp, 12.0_wp], periods(3) = [3258.1881530463132_wp, &
                                                                                 3264.1535339990787_wp, &
                                                                                      3294.0306677687689_wp]
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      character(len=80) :: start
      real(wp) :: pitch
      integer :: i, k
      allocate (scene)
      do i = 1, size(angles)
         write (start, '("roll_pitch_yaw = 0.0, ", es23.16, ", 0.0, angular_velocity = 3*0.0")') &
            (90 - angles(i))*pi/180
         call read_case(error, trim(start), "method = 'taylor', local_tolerance = 1e-15", scene)
         if (allocated(error)) return
         state = scene%initial
         do k = 1, 4
            scene%plan%end_time = k*periods(i)/4
            call integrate(scene%system, scene%integrator, state, scene%plan, status)
            call check(error, status%ok(), trim(status%message))
            pitch = 2*atan2(state%q(3), state%q(1))
            call check_close(error, pitch, pi/2 + (mod(k, 2) - 1)*(k - 3)*angles(i)*pi/180, 1e-12_wp, 'pitch')
         end do
      end do
   end subroutine swings

   !> The multipliers of the equilibrium with the long axis to the centre: exp(±iωP) of both swings, and 1 twice, of
   !> the rotation about the long axis. JEOD's 2821.46 s across the plane hold for a body that cannot yaw.
   subroutine small_swings(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: in_plane = 3257.9400294036904_wp, across = 2806.5697607408_wp
      class(scene_t), allocatable :: scene
      type(periodic_start_t) :: start
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene('&body inertia = 500.0, 12250.0, 12250.0 /'//nl// &
                       "&orbit semi_major_axis = 6756095.0 /"//nl//'&gravity_gradient /'//nl// &
                       "&initial resonance = '1:1' /"//nl//'&integrator time_step = 10.0, end_time = 10.0 /', 's.nml', &
                       scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call find_periodic_start(scene%system, 1.0_wp, start, status)
      call check(error, status%ok(), trim(status%message))
      associate (m => start%monodromy, period => 2*pi/mean_motion)
         call check_close(error, m(3, 3) + m(6, 6), 2*cos(2*pi*period/in_plane), 1e-10_wp, 'in the plane')
         call check_close(error, m(1, 1) + m(2, 2) + m(4, 4) + m(5, 5), 2 + 2*cos(2*pi*period/across), 1e-10_wp, &
                          'across')
      end associate
   end subroutine small_swings

end submodule test_check_cases
