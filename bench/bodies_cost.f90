!> Cost of a step of many bodies, relative to a program's own Runge-Kutta loop: from Fortran, FORTRAN 77 and C, by the
!> number of bodies. Accuracy of the step: against Euler's equations, and the energy of two dipoles over 1e6 steps.
program bench_bodies
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr
   use bodies_loop, only: rk4_loop
   use nutate_bodies, only: BODY_RATE
   use nutate, only: body_t, bodies_t, integrator_settings_t, make_body, make_state, make_stepper, state_t, status_t, &
      stepper_t, system_t, wp
   use nutate_body, only: diagonal
   use nutate_quaternion, only: attitude_distance, cross, quat_product, rotate_to_body, rotate_to_space
   implicit none

   interface
      real(c_double) function bench_thread_seconds() bind(C)
         import :: c_double
      end function bench_thread_seconds
      type(c_ptr) function bench_bodies_create(moments) bind(C)
         import :: c_double, c_ptr
         real(c_double), intent(in) :: moments(3)
      end function bench_bodies_create
      integer(c_int) function bench_bodies_step(bodies, n, dt, q, l, torque) bind(C)
         import :: c_double, c_int, c_ptr
         type(c_ptr), intent(in), value :: bodies
         integer(c_int), intent(in), value :: n
         real(c_double), intent(in), value :: dt
         real(c_double), intent(inout) :: q(4, n), l(3, n)
         real(c_double), intent(in) :: torque(3, n)
      end function bench_bodies_step
      subroutine nubset(nc, aj, iframe, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: nc, iframe, lwork
         real(wp), intent(in) :: aj(3, 3, nc)
         real(wp), intent(inout) :: work(lwork)
         integer, intent(out) :: info
      end subroutine nubset
      subroutine nubody(n, dt, ic, q, al, tor, mbad, ibad, nbad, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: n, ic(1), mbad, lwork
         real(wp), intent(in) :: dt, tor(3, n), work(lwork)
         real(wp), intent(inout) :: q(4, n), al(3, n)
         integer, intent(inout) :: ibad(mbad), nbad
         integer, intent(out) :: info
      end subroutine nubody
   end interface

   !> One of several steppers.
   type :: box_t
      class(stepper_t), allocatable :: stepper
   end type box_t

   integer, parameter :: repeats = 31, lwork = 27
   real(wp), parameter :: j(3) = [1.0_wp, 2.0_wp, 2.5_wp]
   type(bodies_t) :: bodies, by_rate
   type(c_ptr) :: handle
   real(wp) :: work(lwork)
   integer :: i

   call set_up()
   write (*, '(a)') 'ns a body-step, one thread, medians; the ratio is to a Runge-Kutta loop, torques in the same axes'
   write (*, '(a)') '                                             space axes                          body axes'
   write (*, '(a)') '   bodies  RK4 loop   Fortran  ratio       F77  ratio         C  ratio  RK4 loop BODY_RATE  ratio'
   do i = 0, 6
      call compare(10**i)
   end do
   write (*, '(/,a)') 'a body by steps against Euler''s equations: error of the attitude after 10 s, rad'
   write (*, '(a)') '  dt |Omega|   steps      free    driven     RK4, free  RK4, driven'
   do i = 1, 5
      call compare_with_euler(50*2**i)
   end do
   write (*, '(/,a)') 'mean error of the energy of two dipoles in tenths of 1000000 steps of 0.05'
   call drift(.true., 'bodies_t')
   call drift(.false., 'kicks and reduced steps')

contains

   subroutine set_up()
      type(body_t) :: body(1)
      type(status_t) :: status
      integer :: info
      call make_body(diagonal(j), body(1), status)
      call bodies%set_up(body, status)
      call by_rate%set_up(body, status, BODY_RATE)
      handle = bench_bodies_create(j)
      call nubset(1, diagonal(j), 0, work, lwork, info)
      if (info /= 0 .or. .not. status%ok()) error stop 'the bodies are not set up'
   end subroutine set_up

   !> Draws bodies that rotate by some 0.1 rad a step.
   subroutine draw(n, q, l, omega, torque)
      integer, intent(in) :: n
      real(wp), intent(out) :: q(4, n), l(3, n), omega(3, n), torque(3, n)
      integer :: i
      do i = 1, n
         q(:, i) = sin([1.0_wp, 2.0_wp, 3.0_wp, 5.0_wp]*i)
         q(:, i) = q(:, i)/norm2(q(:, i))
         omega(:, i) = cos([1.0_wp, 2.0_wp, 3.0_wp]*i)
         l(:, i) = rotate_to_space(q(:, i), j*omega(:, i))
         torque(:, i) = 0.1_wp*sin([7.0_wp, 8.0_wp, 9.0_wp]*i)
      end do
   end subroutine draw

   !> Writes a line of the table of times; torques are reversed in every other step, so that no body spins up.
   subroutine compare(n)
      integer, intent(in) :: n
      integer, parameter :: ways = 6
      real(wp), allocatable :: q(:, :, :), l(:, :), omega(:, :), torque(:, :), momenta(:, :, :)
      real(wp) :: times(ways, repeats), start, median(ways)
      integer :: i, k, m
      allocate (q(4, n, ways), l(3, n), omega(3, n), torque(3, n), momenta(3, n, ways))
      call draw(n, q(:, :, 1), l, omega, torque)
      do k = 1, ways
         q(:, :, k) = q(:, :, 1)
         momenta(:, :, k) = l
         if (any(k == [1, 5, 6])) momenta(:, :, k) = omega
      end do
      ! In a millisecond the first step, which finds the arrays of other ways in the caches, would count too much.
      m = max(2, 400000/n)
      do i = 1, repeats
         do k = 1, ways
            start = bench_thread_seconds()
            call step_some(k, m, n, q(:, :, k), momenta(:, :, k), torque)
            times(k, i) = 1e9_wp*(bench_thread_seconds() - start)/(real(m, wp)*n)
         end do
      end do
      do k = 1, ways
         median(k) = middle(times(k, :))
      end do
      write (*, '(i9, f10.1, 3(f10.1, f7.2), 2f10.1, f7.2)') n, median(1), (median(k), median(k)/median(1), k=2, 4), &
         median(5:6), median(6)/median(5)
   end subroutine compare

   !> Moves bodies by m steps in one of the six ways.
   subroutine step_some(way, m, n, q, l, torque)
      integer, intent(in) :: way, m, n
      !> Momenta `l` in space axes or, for the ways by body axes, angular velocities.
      real(wp), intent(inout) :: q(4, n), l(3, n), torque(3, n)
      type(status_t) :: status
      integer :: step, info, nbad, ibad(1)
      do step = 1, m
         select case (way)
         case (1)
            call rk4_loop(n, 0.1_wp, j, q, l, torque, .true.)
         case (2)
            call bodies%step(0.1_wp, q, l, torque, status)
            if (.not. status%ok()) error stop 'a step failed'
         case (3)
            call nubody(n, 0.1_wp, [0], q, l, torque, 1, ibad, nbad, work, lwork, info)
            if (info /= 0) error stop 'NUBODY failed'
         case (5)
            call rk4_loop(n, 0.1_wp, j, q, l, torque, .false.)
         case (6)
            call by_rate%step(0.1_wp, q, l, torque, status)
            if (.not. status%ok()) error stop 'a step failed'
         case default
            if (bench_bodies_step(handle, n, 0.1_wp, q, l, torque) /= 0) error stop 'nutate_bodies_step failed'
         end select
         torque = -torque
      end do
   end subroutine step_some

   pure real(wp) function middle(times)
      real(wp), intent(in) :: times(:)
      integer :: i
      middle = 0.0_wp
      do i = 1, size(times)
         if (count(times < times(i)) <= size(times)/2 .and. count(times <= times(i)) > size(times)/2) middle = times(i)
      end do
   end function middle

   !> Compares the attitude of a body after 10 s, free or driven by a torque of 0.3 N m about space axis 3.
   subroutine compare_with_euler(n)
      integer, intent(in) :: n
      real(wp) :: dt, q(4, 1), l(3, 1), omega(3, 1), torque(3, 1), reference(4), errors(2, 2)
      integer :: way, step
      type(status_t) :: status
      dt = 10.0_wp/n
      do way = 1, 2
         torque(:, 1) = [0.0_wp, 0.0_wp, merge(0.0_wp, 0.3_wp, way == 1)]
         reference = euler_reference(torque(:, 1))
         call start(q, l, omega)
         call bodies%kick(-0.5_wp*dt, q, l, torque, status)
         do step = 1, n
            call bodies%step(dt, q, l, torque, status)
         end do
         errors(way, 1) = attitude_distance(q(:, 1), reference)
         call start(q, l, omega)
         do step = 1, n
            call rk4_loop(1, dt, j, q, omega, torque, .true.)
         end do
         errors(way, 2) = attitude_distance(q(:, 1), reference)
      end do
      write (*, '(f12.3, i8, 2es10.1, es14.1, es13.1)') dt*norm2([0.4_wp, 1.3_wp, -0.7_wp]/j), n, errors
   end subroutine compare_with_euler

   subroutine start(q, l, omega)
      real(wp), intent(out) :: q(4, 1), l(3, 1), omega(3, 1)
      q(:, 1) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      l(:, 1) = [0.4_wp, 1.3_wp, -0.7_wp]
      omega(:, 1) = l(:, 1)/j
   end subroutine start

   !> Solves Euler's equations and those of the attitude with the torque rotated at every stage, by 200,000 Runge-Kutta
   !> steps.
   function euler_reference(torque) result(q)
      real(wp), intent(in) :: torque(3)
      integer, parameter :: n = 200000
      real(wp), parameter :: dt = 10.0_wp/n
      real(wp) :: q(4), y(7), k1(7), k2(7), k3(7), k4(7)
      integer :: i
      y = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, [0.4_wp, 1.3_wp, -0.7_wp]/j]
      do i = 1, n
         k1 = rates(y, torque)
         k2 = rates(y + 0.5_wp*dt*k1, torque)
         k3 = rates(y + 0.5_wp*dt*k2, torque)
         k4 = rates(y + dt*k3, torque)
         y = y + (dt/6)*(k1 + 2*(k2 + k3) + k4)
      end do
      q = y(1:4)/norm2(y(1:4))
   end function euler_reference

   pure function rates(y, torque) result(d)
      real(wp), intent(in) :: y(7), torque(3)
      real(wp) :: d(7)
      d(1:4) = 0.5_wp*quat_product(y(1:4), [0.0_wp, y(5:7)])
      d(5:7) = (rotate_to_body(y(1:4), torque) - cross(y(5:7), j*y(5:7)))/j
   end function rates

   !> Writes means of the error of the energy of two dipoles on the x axis, moved by bodies or by kicks and reduced
   !> steps.
   subroutine drift(by_bodies, name)
      logical, intent(in) :: by_bodies
      character(len=*), intent(in) :: name
      integer, parameter :: n = 1000000
      real(wp), parameter :: dt = 0.05_wp
      real(wp), parameter :: inertia(3, 2) = reshape([1.0_wp, 2.0_wp, 2.5_wp, 1.5_wp, 0.9_wp, 1.8_wp], [3, 2])
      type(bodies_t) :: pair
      type(body_t) :: classes(2)
      type(system_t) :: systems(2)
      type(state_t) :: state
      type(integrator_settings_t) :: settings
      type(box_t) :: boxes(2)
      type(status_t) :: status
      real(wp) :: q(4, 2), l(3, 2), torque(3, 2), energy, first, means(10)
      integer :: i, k
      settings%formulation = 'reduced'
      do k = 1, 2
         call make_body(diagonal(inertia(:, k)), classes(k), status)
         systems(k)%body = classes(k)
         call make_stepper(systems(k), settings, boxes(k)%stepper, status)
      end do
      call pair%set_up(classes, status)
      q = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.6_wp, 0.0_wp, 0.8_wp, 0.0_wp], [4, 2])
      l = reshape([0.4_wp, 1.3_wp, -0.7_wp, -0.3_wp, 0.9_wp, 1.1_wp], [3, 2])
      call find_dipoles(q, torque, energy)
      first = energy + kinetic(q, l, inertia)
      call pair%kick(-0.5_wp*dt, q, l, torque, status, [1, 2])
      means = 0.0_wp
      do i = 1, n
         if (by_bodies) then
            call pair%step(dt, q, l, torque, status, [1, 2])
         else
            l = l + dt*torque
            do k = 1, 2
               state = make_state(systems(k), q(:, k), rotate_to_body(q(:, k), l(:, k))/inertia(:, k))
               call boxes(k)%stepper%step(systems(k), state, dt, status)
               q(:, k) = state%q/norm2(state%q)
            end do
         end if
         call find_dipoles(q, torque, energy)
         energy = energy + kinetic(q, l + 0.5_wp*dt*torque, inertia) - first
         k = 1 + (10*(i - 1))/n
         means(k) = means(k) + 10*energy/n
      end do
      write (*, '(2x, a, t28, 10es9.1)') name, means
   end subroutine drift

   pure subroutine find_dipoles(q, torque, energy)
      real(wp), intent(in) :: q(4, 2)
      real(wp), intent(out) :: torque(3, 2), energy
      real(wp), parameter :: dipole(3, 2) = reshape([0.0_wp, 0.6_wp, 0.8_wp, 1.0_wp, 0.2_wp, 0.0_wp], [3, 2])
      real(wp) :: moment(3, 2), field(3)
      integer :: i
      do i = 1, 2
         moment(:, i) = rotate_to_space(q(:, i), dipole(:, i))
      end do
      do i = 1, 2
         field = [2.0_wp, -1.0_wp, -1.0_wp]*moment(:, 3 - i)
         torque(:, i) = cross(moment(:, i), field)
      end do
      energy = -dot_product(moment(:, 2), field)
   end subroutine find_dipoles

   pure real(wp) function kinetic(q, l, inertia)
      real(wp), intent(in) :: q(4, 2), l(3, 2), inertia(3, 2)
      integer :: i
      kinetic = 0.0_wp
      do i = 1, 2
         kinetic = kinetic + 0.5_wp*sum(rotate_to_body(q(:, i), l(:, i))**2/inertia(:, i))
      end do
   end function kinetic

end program bench_bodies
