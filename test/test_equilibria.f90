!> All equilibria of gyrostats on a circular orbit: numbers and indices against 1200 starts of an independent program,
!> the attitudes against the equations of Gutnik and Sarychev.
submodule(suites_of_effects) test_equilibria
   use nutate_equilibria, only: equilibria_t, find_equilibria
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_scene, only: parse_scene, scene_t
   use nutate_scene_linearization, only: linearize_scene, scene_equilibria
   use nutate_linearization, only: linearization_t
   use nutate_hamiltonian, only: frame_rate_of, make_state
   use nutate_status, only: status_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   character, parameter :: lf = new_line('a')
   character(len=*), parameter :: body = '&body inertia = 3.0, 4.0, 2.0 /'//lf, &
      orbit = "&orbit semi_major_axis = 1.0, mu = 1.0, frame = 'lvlh' /"//lf//'&gravity_gradient /'//lf
   real(wp), parameter :: moments(3) = [3.0_wp, 4.0_wp, 2.0_wp]

contains

   module procedure collect_equilibria
      testsuite = [ &
                  new_unittest("gyrostats have 24 to 8 equilibria", test_numbers), &
                  new_unittest("they satisfy the equations of rest", test_equations), &
                  new_unittest("growth is that of the linearised motion", test_growth), &
                  new_unittest("units change nothing", test_units), &
                  new_unittest("wheels are rotors with an inertia", test_wheels), &
                  new_unittest("what has no isolated equilibria is refused", test_refusals)]
   end procedure collect_equilibria

   subroutine find(text, found, error, scene)
      character(len=*), intent(in) :: text
      type(equilibria_t), intent(out) :: found
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(text//'&initial angular_velocity = 0.0, 0.0, 0.0 /'//lf// &
                       '&integrator time_step = 0.1, end_time = 1.0 /', 's.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call scene_equilibria(scene, found, status)
      call check(error, status%ok(), trim(status%message))
   end subroutine find

   function rotor(momentum) result(text)
      real(wp), intent(in) :: momentum(3)
      character(len=120) :: text
      write (text, '("&rotor momentum = ", 3(f6.3, :, ", "))') momentum
      text = trim(text)//' /'//lf
   end function rotor

   subroutine test_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: momenta(3, 6) = reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.1_wp, 0.2_wp, 0.15_wp, &
                                                      0.3_wp, 0.5_wp, 0.4_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
                                                      1.0_wp, 1.5_wp, 1.0_wp, 3.0_wp, 5.0_wp, 4.0_wp], [3, 6])
      integer, parameter :: by_index(0:3, 6) = reshape([4, 8, 8, 4, 4, 8, 8, 4, 2, 6, 6, 2, 2, 6, 8, 4, 2, 4, 4, 2, &
                                                        2, 2, 2, 2], [4, 6])
      type(equilibria_t) :: found
      class(scene_t), allocatable :: scene
      integer :: i, k
      allocate (scene)
      do i = 1, size(momenta, 2)
         call find(body//orbit//rotor(momenta(:, i)), found, error, scene)
         if (allocated(error)) return
         call check(error, size(found%items), sum(by_index(:, i)))
         do k = 0, 3
            call check(error, found%number_of(k), by_index(k, i))
         end do
         call check(error, found%balanced, 'balanced')
         call check(error, all(found%items(2:)%energy >= found%items(:size(found%items) - 1)%energy - 1e-12_wp), &
                    'by energy')
         call check(error, all(.not. pack(found%items%growth, found%items%index == 0) > 0.0_wp), 'minima are stable')
         call check(error, all(pack(found%items%growth, modulo(found%items%index, 2) == 1 .and. &
                                    .not. found%items%degenerate) > 0.01_wp), &
                    'an odd number of negative directions is unstable (Thomson and Tait)')
      end do
   end subroutine test_numbers

   !> 3 g×Jg = b×(Jb - h), with b and g the normal and the vertical in body axes, and W of the reference.
   subroutine test_equations(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h(3) = [0.3_wp, 0.5_wp, 0.4_wp]
      type(equilibria_t) :: found
      class(scene_t), allocatable :: scene
      real(wp) :: b(3), g(3), w, offset
      integer :: i
      allocate (scene)
      call find(body//orbit//rotor(h), found, error, scene)
      if (allocated(error)) return
      do i = 1, size(found%items)
         b = rotate_to_body(found%items(i)%q, [0.0_wp, 1.0_wp, 0.0_wp])
         g = rotate_to_body(found%items(i)%q, [0.0_wp, 0.0_wp, 1.0_wp])
         call check_close(error, 3*cross(g, moments*g), cross(b, moments*b - h), 1e-13_wp, 'at rest')
         w = 1.5_wp*sum(moments*g**2) - 0.5_wp*sum(moments*b**2) + dot_product(h, b)
         if (i == 1) offset = found%items(1)%energy - w
         call check_close(error, found%items(i)%energy - w, offset, 1e-13_wp, 'energy')
      end do
   end subroutine test_equations

   !> At every equilibrium the scene starts at rest in the orbit's axes and is linearised.
   subroutine test_growth(error)
      type(error_type), allocatable, intent(out) :: error
      type(equilibria_t) :: found
      class(scene_t), allocatable :: scene
      type(linearization_t) :: linear
      type(status_t) :: status
      integer :: i, n_degenerate
      allocate (scene)
      call find(body//orbit//rotor([0.0_wp, 1.0_wp, 0.0_wp]), found, error, scene)
      if (allocated(error)) return
      n_degenerate = 0
      do i = 1, size(found%items)
         scene%initial = make_state(scene%system, found%items(i)%q, &
                                    frame_rate_of(scene%system%effects, found%items(i)%q))
         call linearize_scene(scene, 0.0_wp, linear, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         call check_below(error, linear%residual, 1e-12_wp, 'residual')
         n_degenerate = n_degenerate + merge(1, 0, found%items(i)%degenerate)
         ! A double eigenvalue 0 would be split to the root of rounding.
         if (found%items(i)%degenerate) cycle
         call check_close(error, found%items(i)%growth, maxval(real(linear%eigenvalues, wp)), 1e-6_wp, 'growth')
      end do
      ! J2 - h = J1: where the rotor lies along the normal and axis 1 forward, two pairs have just met.
      call check(error, n_degenerate, 2)
   end subroutine test_growth

   !> The satellite in SI units has the attitudes of the one with n = 1.
   subroutine test_units(error)
      type(error_type), allocatable, intent(out) :: error
      type(equilibria_t) :: plain, found
      class(scene_t), allocatable :: scene
      real(wp) :: rate
      integer :: i
      character(len=120) :: momentum
      allocate (scene)
      call find(body//orbit//rotor([0.3_wp, 0.5_wp, 0.4_wp]), plain, error, scene)
      if (allocated(error)) return
      rate = sqrt(3.986004418e14_wp/7e6_wp**3)
      write (momentum, '("&rotor momentum = ", 3(es23.16, :, ", "))') 100*rate*[0.3_wp, 0.5_wp, 0.4_wp]
      call find('&body inertia = 300.0, 400.0, 200.0 /'//lf//'&orbit semi_major_axis = 7e6 /'//lf// &
                '&gravity_gradient /'//lf//trim(momentum)//' /'//lf, found, error, scene)
      if (allocated(error)) return
      call check(error, size(found%items), size(plain%items))
      if (allocated(error)) return
      do i = 1, size(plain%items)
         call check_close(error, found%items(i)%q, plain%items(i)%q, 1e-9_wp, 'attitude')
         call check_close(error, found%items(i)%growth/rate, plain%items(i)%growth, 1e-9_wp, 'growth')
      end do
   end subroutine test_units

   !> J of the scene has the wheels locked: their speeds are those against the body.
   subroutine test_wheels(error)
      type(error_type), allocatable, intent(out) :: error
      type(equilibria_t) :: rotors, wheels
      class(scene_t), allocatable :: scene
      integer :: i
      allocate (scene)
      call find(body//orbit//rotor([0.3_wp, 0.5_wp, 0.4_wp]), rotors, error, scene)
      if (allocated(error)) return
      call find(body//orbit//'&wheel axis = 1.0, 0.0, 0.0, inertia = 0.1, speed = 3.0 /'//lf// &
                '&wheel axis = 0.0, 1.0, 0.0, inertia = 0.2, speed = 2.5 /'//lf// &
                '&rotor momentum = 0.0, 0.0, 0.4 /'//lf, wheels, error, scene)
      if (allocated(error)) return
      call check(error, size(wheels%items), size(rotors%items))
      if (allocated(error)) return
      do i = 1, size(rotors%items)
         call check_close(error, wheels%items(i)%q, rotors%items(i)%q, 1e-12_wp, 'attitude')
         call check(error, wheels%items(i)%index, rotors%items(i)%index)
      end do
   end subroutine test_wheels

   subroutine test_refusals(error)
      type(error_type), allocatable, intent(out) :: error
      call refuse('&body inertia = 3.0, 3.0, 2.0 /'//lf//orbit, 'not isolated')
      call refuse('&body inertia = 3.0, 3.0, 3.0 /'//lf//orbit, 'not isolated')
      call refuse(body//'&dipole moment = 1.0, 2.0, 3.0, field = 0.0, 0.0, 1.0 /'//lf, 'not isolated')
      call refuse(body, 'no potential')
      call refuse(body//orbit//'&torque body = 0.0, 0.0, 1.0 /'//lf, 'no torques')
      call refuse(body//'&orbit semi_major_axis = 1.0, mu = 1.0, eccentricity = 0.1 /'//lf//'&gravity_gradient /'//lf, &
                  'depend on the time')
      call refuse(body//orbit//'&wheel axis = 1.0, 0.0, 0.0, inertia = 0.1, friction = 1e-3 /'//lf, 'free wheels')

   contains

      subroutine refuse(text, words)
         character(len=*), intent(in) :: text, words
         class(scene_t), allocatable :: scene
         type(equilibria_t) :: found
         type(status_t) :: status
         character(len=:), allocatable :: message
      allocate (scene)
         call parse_scene(text//'&initial angular_velocity = 0.0, 0.0, 0.0 /'//lf// &
                          '&integrator time_step = 0.1, end_time = 1.0 /', 's.nml', scene, status, message)
         call check(error, status%ok(), message)
         call find_equilibria(scene%system, spread(0.0_wp, 1, scene%system%effects%n_wheels), found, status)
         call check(error, .not. status%ok() .and. index(status%message, words) > 0, words//': '//trim(status%message))
      end subroutine refuse

   end subroutine test_refusals

end submodule test_equilibria
