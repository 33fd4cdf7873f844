!> Integrable tops beyond Lagrange's: the fourth integral of Kovalevskaya and that of Goryachev and Chaplygin, which no
!> method here knows of, and 16 digits of their motions.
submodule(suites_of_effects) test_classical_tops
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: rotate_to_body
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, check_below, check_close, draws_fewer, error_type, new_unittest
   implicit none

   character, parameter :: nl = new_line('a')
   !> The moment of the dipole is (1, 0, 0), the field (0, 0, 1).
   character(len=*), parameter :: kovalevskaya = '&body inertia = 2.0, 2.0, 1.0 /'//nl// &
      '&initial quaternion = 0.8, 0.6, 0.0, 0.0, angular_velocity = 0.3, -0.5, 1.2 /'//nl, &
      goryachev_chaplygin = '&body inertia = 4.0, 4.0, 1.0 /'//nl// &
      '&initial quaternion = 0.8, 0.6, 0.0, 0.0, angular_velocity = 0.5, -0.07, 0.96 /'//nl

   abstract interface
      !> The fourth integral of a rate and the direction of the field, body axes.
      pure real(wp) function integral_of(omega, gamma)
         import :: wp
         real(wp), intent(in) :: omega(3), gamma(3)
      end function integral_of
   end interface

contains

   module procedure collect_classical_tops
      testsuite = [ &
                  new_unittest("Kovalevskaya's top", motion_of_kovalevskaya), &
                  new_unittest("the top of Goryachev and Chaplygin", motion_of_goryachev), &
                  new_unittest("Kovalevskaya's integral drifts by round-off", integral_of_kovalevskaya), &
                  new_unittest("Chaplygin's integral drifts by round-off", integral_of_goryachev)]
   end procedure collect_classical_tops

   pure real(wp) function kovalevskaya_integral(omega, gamma) result(k)
      real(wp), intent(in) :: omega(3), gamma(3)
      k = (omega(1)**2 - omega(2)**2 + gamma(1))**2 + (2*omega(1)*omega(2) + gamma(2))**2
   end function kovalevskaya_integral

   pure real(wp) function chaplygin_integral(omega, gamma) result(g)
      real(wp), intent(in) :: omega(3), gamma(3)
      g = omega(3)*(omega(1)**2 + omega(2)**2) + omega(1)*gamma(3)
   end function chaplygin_integral

   subroutine read_top(error, top, settings, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: top, settings
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(top//'&dipole moment = 1.0, 0.0, 0.0, field = 0.0, 0.0, 1.0 /'//nl//'&integrator '//settings// &
                       ', end_time = 20.0 /', 's.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read_top

   subroutine motion_of_kovalevskaya(error)
      type(error_type), allocatable, intent(out) :: error
      call check_motion(error, kovalevskaya, reshape([ &
         0.5234077294793439_wp, -0.6072673873144912_wp, -0.02424655345636298_wp, -0.5972292471664441_wp, &
         0.4524398226279543_wp, 1.199009461742076_wp, 0.5803651844262966_wp, &
         0.2830477476422388_wp, -0.9449708572303368_wp, -0.1367554262393558_wp, 0.0906201132978218_wp, &
         0.09779413878612736_wp, -0.3913154870499697_wp, 1.267642216457804_wp], [7, 2]))
   end subroutine motion_of_kovalevskaya

   subroutine motion_of_goryachev(error)
      type(error_type), allocatable, intent(out) :: error
      call check_motion(error, goryachev_chaplygin, reshape([ &
         0.1512358987663099_wp, -0.6635941566840519_wp, -0.6896788701663514_wp, -0.2472115575477681_wp, &
         0.1023236945803238_wp, 0.7682786836280707_wp, 0.7821255005518101_wp, &
         0.5229094690640181_wp, 0.4230897854291477_wp, -0.2901129018815057_wp, -0.6807313896028274_wp, &
         0.5387015348486249_wp, 0.1149944472706855_wp, 0.4269389622799929_wp], [7, 2]))
   end subroutine motion_of_goryachev

   !> The motion at t = 5 and 20.
   subroutine check_motion(error, top, table)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: top
      !> q, Ω; shape (7, 2).
      real(wp), intent(in) :: table(:, :)
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp), parameter :: times(2) = [5.0_wp, 20.0_wp]
      integer :: i
      allocate (scene)
      call read_top(error, top, "method = 'taylor', local_tolerance = 1e-15", scene)
      if (allocated(error)) return
      state = scene%initial
      do i = 1, 2
         scene%plan%end_time = times(i)
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, sign(1.0_wp, dot_product(state%q, table(:4, i)))*state%q, table(:4, i), 1e-12_wp, 'q')
         call check_close(error, angular_velocity(scene%system, state), table(5:, i), 1e-12_wp, 'omega')
      end do
   end subroutine check_motion

   subroutine integral_of_kovalevskaya(error)
      type(error_type), allocatable, intent(out) :: error
      call check_integral(error, kovalevskaya, kovalevskaya_integral, 0.4612_wp)
   end subroutine integral_of_kovalevskaya

   subroutine integral_of_goryachev(error)
      type(error_type), allocatable, intent(out) :: error
      call check_integral(error, goryachev_chaplygin, chaplygin_integral, 0.384704_wp)
   end subroutine integral_of_goryachev

   !> The integral at the start, and after every thousandth of 100 000 steps (`make test`: 5000).
   subroutine check_integral(error, top, integral, expected)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: top
      procedure(integral_of) :: integral
      real(wp), intent(in) :: expected
      real(wp), parameter :: step = 0.1_wp
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: largest
      integer :: i, n
      allocate (scene)
      call read_top(error, top, "method = 'taylor', time_step = 0.1", scene)
      if (allocated(error)) return
      state = scene%initial
      call check_close(error, value_at(), expected, 4*eps, 'at the start')
      n = merge(5, 100, draws_fewer())
      largest = 0.0_wp
      do i = 1, n
         scene%plan%end_time = 1000*step*i
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         largest = max(largest, abs(value_at() - expected))
      end do
      ! In each step a tenth of the rounding of a number of size 1; measured: a fiftieth.
      call check_below(error, largest, 100*eps*n, 'drift')

   contains

      real(wp) function value_at()
         value_at = integral(angular_velocity(scene%system, state), rotate_to_body(state%q, [0.0_wp, 0.0_wp, 1.0_wp]))
      end function value_at

   end subroutine check_integral

end submodule test_classical_tops
