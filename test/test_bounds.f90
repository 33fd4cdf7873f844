!> Bounds of user-defined potentials and torques, by every way to give them: the list of effects, C, FORTRAN 77.
submodule(suites_of_methods) test_bounds
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only: c_double, c_funloc, c_int, c_int64_t, c_loc, c_null_char, c_null_funptr, &
      c_null_ptr, c_ptr, c_size_t
   use nutate_applied_torque, only: applied_torque_t
   use nutate_c_history, only: nutate_history_destroy, nutate_history_uncertified, nutate_scene_run
   use nutate_c_reading, only: nutate_stepper_conjugate_momentum, nutate_stepper_quaternion, nutate_stepper_uncertified
   use nutate_c_runs, only: nutate_stepper_run
   use nutate_c_scene, only: nutate_scene_add_potential, nutate_scene_add_user_torque, nutate_scene_bound_potential, &
      nutate_scene_bound_torque, nutate_scene_destroy, nutate_scene_parse, nutate_scene_system
   use nutate_c_stepper, only: nutate_stepper_create, nutate_stepper_destroy, nutate_stepper_set, &
      nutate_stepper_set_canonical, nutate_stepper_set_time_step
   use nutate_c_system, only: nutate_system_add_potential, nutate_system_add_user_torque, &
      nutate_system_create_tensor, nutate_system_destroy
   use nutate_c_system_effects, only: nutate_system_add_damping, nutate_system_add_gravity, nutate_system_add_rotor, &
      nutate_system_bound_potential, nutate_system_bound_torque
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_OK
   use test_attack_case, only: custom_potential_t, custom_torque_t
   use test_f77_routines, only: nubpot, nubtor, nuncer, nustep, potspr, tormot
   use test_f77_twins, only: forced_twin, iuser, most, plain, row_keeper_t, run_library, start, top_twin, twin_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   !> The motor of `plain` without friction: bounds are for torques that do not depend on Ω.
   real(wp), parameter :: smooth(7) = [plain(1:4), 0.0_wp, plain(6:7)]
   !> Bounds of the spring in height and of the motor: |γ| ≤ 1.
   real(wp), parameter :: spring_bounds(3) = [plain(1) + plain(2), plain(1), 0.0_wp], &
                          motor_bounds(4) = [plain(3), 0.0_wp, 0.0_wp, plain(4)]
   integer, parameter :: steps = 100
   real(wp), parameter :: dt = 0.013_wp

contains

   module procedure collect_bounds
      testsuite = [ &
                  new_unittest("bounds go to the effect of one's own added last", last_one_is_bound), &
                  new_unittest("effects of the library take no bounds", library_takes_none), &
                  new_unittest("bounds that are none are refused by name", bad_bounds_are_refused), &
                  new_unittest("bounds prove the same steps in Fortran, C and F77", all_ways_prove_alike), &
                  new_unittest("F77 bounds stay in WORK and change no digit", bounds_stay_in_work), &
                  new_unittest("F77 NUBPOT and NUBTOR find the wrong argument", f77_finds_wrong), &
                  new_unittest("C bounds without a callback, or bad ones, are refused", c_refuses), &
                  new_unittest("C bounds of a scene prove its runs", scenes_are_bound)]
   end procedure collect_bounds

   subroutine last_one_is_bound(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_list_t) :: effects
      type(status_t) :: status
      call effects%add(custom_potential_t(size=1.0_wp))
      call effects%add(custom_potential_t(size=2.0_wp))
      call effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1.0_wp, 0.0_wp]))
      call effects%add(custom_torque_t(size=1.0_wp))
      call effects%add(custom_torque_t(size=2.0_wp))
      call effects%add(damping_t([1.0_wp, 1.0_wp, 1.0_wp]))
      call effects%bound_potential(9.0_wp, 9.0_wp, 9.0_wp, status)
      call effects%bound_potential(1.0_wp, 2.0_wp, 3.0_wp, status)
      call check(error, status%ok(), trim(status%message))
      call effects%bound_torque(4.0_wp, 5.0_wp, 6.0_wp, 7.0_wp, status)
      call check(error, status%ok(), trim(status%message))
      associate (u => effects%potentials, tau => effects%torques)
         call check(error, all([u(1)%item%given, u(3)%item%given, tau(1)%item%given, tau(3)%item%given] < 0.0_wp), &
                    'an effect that was not meant')
         call check_close(error, [u(2)%item%given(:3), tau(2)%item%given], &
                          [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp, 7.0_wp], 0.0_wp)
      end associate
   end subroutine last_one_is_bound

   !> Also those that have no bounds: a spring whose ends can meet.
   subroutine library_takes_none(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_list_t) :: effects
      type(status_t) :: statuses(2)
      real(wp), parameter :: a(3) = [1.0_wp, 0.0_wp, 0.0_wp]
      call effects%bound_potential(1.0_wp, 1.0_wp, 1.0_wp, statuses(1))
      call effects%bound_torque(1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, statuses(2))
      call check(error, all(statuses%code == NUTATE_BAD_ARGUMENT), 'no effect')
      call effects%add(dipole_t(a, a))
      call effects%add(spring_t(a, a, 1.0_wp, 0.5_wp))
      call effects%add(spring_t(a, 2*a, 1.0_wp, 0.5_wp))
      call effects%add(damping_t(a))
      call effects%add(applied_torque_t(amplitude=a))
      call effects%bound_potential(1.0_wp, 1.0_wp, 1.0_wp, statuses(1))
      call effects%bound_torque(1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, statuses(2))
      call check(error, all(statuses%code == NUTATE_BAD_ARGUMENT), 'others')
      call check(error, all([effects%potentials(1)%item%given, effects%potentials(2)%item%given, &
                             effects%torques(1)%item%given] < 0.0_wp), 'bounds are left behind')
   end subroutine library_takes_none

   subroutine bad_bounds_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=11), parameter :: names(7) = [character(len=11) :: 'gradient', 'hessian', 'third', 'torque', &
                                                  'by_rotation', 'second', 'rate']
      type(effect_list_t) :: effects
      type(status_t) :: status
      real(wp) :: bad(5), values(7)
      integer :: i, k
      call effects%add(custom_potential_t(size=1.0_wp))
      call effects%add(custom_torque_t(size=1.0_wp))
      bad = bad_numbers()
      do k = 1, size(bad)
         do i = 1, size(names)
            values = 1.0_wp
            values(i) = bad(k)
            if (i <= 3) call effects%bound_potential(values(1), values(2), values(3), status)
            if (i > 3) call effects%bound_torque(values(4), values(5), values(6), values(7), status)
            call check(error, status%code == NUTATE_BAD_ARGUMENT .and. status%subject == names(i) .and. &
                       index(status%message, trim(names(i))) > 0, 'not refused by name: '//names(i))
         end do
      end do
      call check(error, all([effects%potentials(1)%item%given, effects%torques(1)%item%given] < 0.0_wp), 'kept')
      call effects%bound_potential(0.0_wp, 1e-300_wp, 1e100_wp, status)
      call check(error, status%ok(), 'the ends of the range')
   end subroutine bad_bounds_are_refused

   !> Returns numbers that no bound can be.
   function bad_numbers() result(bad)
      real(wp) :: bad(5)
      bad = [-1.0_wp, 1.001e100_wp, 1e-310_wp, ieee_value(0.0_wp, ieee_quiet_nan), &
             ieee_value(0.0_wp, ieee_positive_inf)]
   end function bad_numbers

   !> Checks bounds of both, of one, and of none, with both solvers: bitwise identical states and the same counts.
   subroutine all_ways_prove_alike(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: iform, given, counts(3)
      real(wp) :: ends(8, 3)
      do iform = 1, 2
         do given = 0, 3
            call count_by_library(iform, given, ends(:, 1), counts(1))
            call count_by_f77(iform, given, ends(:, 2), counts(2))
            call count_by_c(iform, given, ends(:, 3), counts(3))
            call check(error, counts(1), merge(0, steps, given == 3), 'Fortran')
            call check(error, counts(2), counts(1), 'F77')
            call check(error, counts(3), counts(1), 'C')
            call check_close(error, ends(:, 2), ends(:, 1), 0.0_wp)
            call check_close(error, ends(:, 3), ends(:, 1), 0.0_wp)
         end do
      end do
   end subroutine all_ways_prove_alike

   !> `given`: 1 counts for bounds of the potential, 2 of the torque.
   subroutine count_by_library(iform, given, end, uncertified)
      integer, intent(in) :: iform, given
      real(wp), intent(out) :: end(8)
      integer, intent(out) :: uncertified
      type(twin_t) :: twin
      type(state_t) :: state
      type(row_keeper_t) :: keeper
      type(status_t) :: status
      twin = forced_twin(iform, 4, friction=0.0_wp)
      associate (effects => twin%problem%system%effects, u => spring_bounds, tau => motor_bounds)
         if (mod(given, 2) == 1) call effects%bound_potential(u(1), u(2), u(3), status)
         if (given > 1) call effects%bound_torque(tau(1), tau(2), tau(3), tau(4), status)
      end associate
      call run_library(twin, dt, steps, steps, state, keeper, status, uncertified)
      if (.not. status%ok()) uncertified = -1
      end = [state%q, state%p]
   end subroutine count_by_library

   subroutine count_by_f77(iform, given, end, uncertified)
      integer, intent(in) :: iform, given
      real(wp), intent(out) :: end(8)
      integer, intent(out) :: uncertified
      real(wp) :: work(most), t, q(4), p(4)
      integer :: info(5)
      info = 0
      call start(forced_twin(iform, 4, friction=0.0_wp), work, most, t, q, p, info(1))
      associate (u => spring_bounds, tau => motor_bounds)
         if (mod(given, 2) == 1) call nubpot(u(1), u(2), u(3), work, most, info(2))
         if (given > 1) call nubtor(tau(1), tau(2), tau(3), tau(4), work, most, info(3))
      end associate
      call nustep(steps, dt, t, q, p, potspr, tormot, iuser, smooth, work, most, info(4))
      call nuncer(uncertified, work, most, info(5))
      if (any(info /= 0)) uncertified = -1
      end = [q, p]
   end subroutine count_by_f77

   subroutine count_by_c(iform, given, end, uncertified)
      integer, intent(in) :: iform, given
      real(wp), intent(out) :: end(8)
      integer, intent(out) :: uncertified
      type(twin_t) :: twin
      type(c_ptr), target :: system, stepper
      integer(c_int) :: codes(16)
      integer(c_int64_t) :: n
      twin = forced_twin(iform, 4, friction=0.0_wp)
      codes = NUTATE_OK
      n = -1
      associate (j => twin%aj, u => spring_bounds, tau => motor_bounds)
         codes(1) = nutate_system_create_tensor([j(1, 1), j(2, 2), j(3, 3), j(1, 2), j(1, 3), j(2, 3)], 0.0_wp, &
                                                about_center=0_c_int, system=c_loc(system), message=c_null_ptr, &
                                                size=0_c_size_t)
         codes(2) = nutate_system_add_rotor(system, twin%h)
         codes(3) = nutate_system_add_potential(system, twin%dn, c_funloc(spring_in_height), c_null_funptr, c_null_ptr)
         codes(4) = nutate_system_add_damping(system, twin%d)
         codes(5) = nutate_system_add_user_torque(system, c_funloc(motor), c_null_ptr)
         if (mod(given, 2) == 1) codes(6) = nutate_system_bound_potential(system, u(1), u(2), u(3))
         if (given > 1) codes(7) = nutate_system_bound_torque(system, tau(1), tau(2), tau(3), tau(4))
      end associate
      codes(8) = nutate_stepper_create(system, c_loc(stepper), c_null_ptr, 0_c_size_t)
      codes(9) = set(stepper, 'formulation', trim(merge('reduced', 'full   ', iform == 1)))
      codes(10) = set(stepper, 'order', '4')
      associate (first => twin%problem%start)
         codes(11) = nutate_stepper_set_canonical(stepper, first%t, first%q, first%p)
      end associate
      codes(12) = nutate_stepper_set_time_step(stepper, dt)
      codes(13) = nutate_stepper_run(stepper, int(steps, c_int64_t), 1_c_int64_t, c_null_ptr, 0_c_size_t)
      codes(14) = nutate_stepper_quaternion(stepper, end(1:4))
      codes(15) = nutate_stepper_conjugate_momentum(stepper, end(5:8))
      codes(16) = nutate_stepper_uncertified(stepper, n)
      uncertified = int(n)
      if (any(codes /= NUTATE_OK)) uncertified = -1
      codes(1) = nutate_stepper_destroy(c_loc(stepper))
      codes(2) = nutate_system_destroy(c_loc(system))
   end subroutine count_by_c

   integer(c_int) function set(stepper, key, value) result(code)
      type(c_ptr), intent(in) :: stepper
      character(len=*), intent(in) :: key, value
      character(len=:), allocatable, target :: name, text
      name = key//c_null_char
      text = value//c_null_char
      code = nutate_stepper_set(stepper, c_loc(name), c_loc(text))
   end function set

   !> `potspr` and `tormot` as callbacks of C.
   integer(c_int) function spring_in_height(gamma, user, energy, gradient) result(failed) bind(C)
      real(c_double), intent(in) :: gamma(3)
      type(c_ptr), intent(in), value :: user
      real(c_double), intent(out) :: energy, gradient(3)
      call potspr(gamma, energy, gradient, iuser, smooth)
      failed = 0
   end function spring_in_height

   integer(c_int) function motor(t, q, omega, user, tau) result(failed) bind(C)
      real(c_double), intent(in), value :: t
      real(c_double), intent(in) :: q(4), omega(3)
      type(c_ptr), intent(in), value :: user
      real(c_double), intent(out) :: tau(3)
      call tormot(t, q, omega, tau, iuser, smooth)
      failed = 0
   end function motor

   !> Bounds given between steps count from there on; what the method remembers of its steps stays.
   subroutine bounds_stay_in_work(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), copy(most), t, q(4), p(4), end(8)
      integer :: info(5), uncertified
      call count_by_f77(1, 0, end, uncertified)
      call start(forced_twin(1, 4, friction=0.0_wp), work, most, t, q, p, info(1))
      call nustep(steps/2, dt, t, q, p, potspr, tormot, iuser, smooth, work, most, info(2))
      associate (u => spring_bounds, tau => motor_bounds)
         call nubpot(u(1), u(2), u(3), work, most, info(3))
         call nubtor(tau(1), tau(2), tau(3), tau(4), work, most, info(4))
      end associate
      copy = work
      call nustep(steps/2, dt, t, q, p, potspr, tormot, iuser, smooth, copy, most, info(5))
      call check(error, all(info == 0), 'INFO')
      call nuncer(uncertified, copy, most, info(1))
      call check(error, uncertified, steps/2, 'steps not certified')
      call check_close(error, [q, p], end, 0.0_wp)
   end subroutine bounds_stay_in_work

   !> Checks each argument, and a WORK for bodies without POT, or TOR; WORK stays unchanged.
   subroutine f77_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), before(most), bad(5), t, q(4), p(4), x(4)
      integer :: info(7), i, k
      call start(forced_twin(1, 2), work, most, t, q, p, info(1))
      before = work
      bad = bad_numbers()
      do k = 1, size(bad)
         do i = 1, 4
            x = 1.0_wp
            x(i) = bad(k)
            call nubtor(x(1), x(2), x(3), x(4), work, most, info(i))
            if (i < 4) call nubpot(x(1), x(2), x(3), work, most, info(4 + i))
         end do
         call check(error, all(info == -[1, 2, 3, 4, 1, 2, 3]), 'numbers')
      end do
      call nubpot(x(1), x(2), x(3), work, 90, info(1))
      call nubtor(x(1), x(2), x(3), 1.0_wp, work, 90, info(2))
      call check(error, all(info(1:2) == -[5, 6]) .and. all(work == before), 'LWORK, or WORK was changed')
      work(2) = 0.0_wp
      call nubpot(x(1), x(2), x(3), work, most, info(1))
      call nubtor(x(1), x(2), x(3), 1.0_wp, work, most, info(2))
      call start(top_twin(1, 2), work, most, t, q, p, info(5))
      call nubpot(x(1), x(2), x(3), work, most, info(3))
      call nubtor(x(1), x(2), x(3), 1.0_wp, work, most, info(4))
      call check(error, all(info(1:4) == -[4, 5, 4, 5]), 'a WORK of another kind')
   end subroutine f77_finds_wrong

   subroutine c_refuses(error)
      type(error_type), allocatable, intent(out) :: error
      type(c_ptr), target :: system
      real(wp) :: bad(5), x(4)
      integer(c_int) :: codes(4)
      integer :: i, k
      codes(1) = nutate_system_create_tensor([3.0_wp, 4.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp, &
                                             about_center=0_c_int, system=c_loc(system), message=c_null_ptr, &
                                             size=0_c_size_t)
      codes(2) = nutate_system_add_gravity(system, [0.0_wp, 0.0_wp, 1.0_wp])
      codes(3) = nutate_system_add_damping(system, [1.0_wp, 1.0_wp, 1.0_wp])
      call check(error, all(codes(1:3) == NUTATE_OK))
      codes(1) = nutate_system_bound_potential(system, 1.0_wp, 1.0_wp, 1.0_wp)
      codes(2) = nutate_system_bound_torque(system, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp)
      call check(error, all(codes(1:2) == NUTATE_BAD_ARGUMENT), 'there is no callback')
      codes(1) = nutate_system_add_potential(system, [0.0_wp, 0.0_wp, 1.0_wp], c_funloc(spring_in_height), &
                                             c_null_funptr, c_null_ptr)
      codes(2) = nutate_system_add_user_torque(system, c_funloc(motor), c_null_ptr)
      bad = bad_numbers()
      do k = 1, size(bad)
         do i = 1, 4
            x = 1.0_wp
            x(i) = bad(k)
            codes(3) = NUTATE_BAD_ARGUMENT
            if (i < 4) codes(3) = nutate_system_bound_potential(system, x(1), x(2), x(3))
            codes(4) = nutate_system_bound_torque(system, x(1), x(2), x(3), x(4))
            call check(error, all(codes(3:4) == NUTATE_BAD_ARGUMENT), 'a bad bound')
         end do
      end do
      codes(3) = nutate_system_bound_potential(system, 1.0_wp, 0.0_wp, 0.0_wp)
      codes(4) = nutate_system_bound_torque(system, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      call check(error, all(codes == NUTATE_OK), 'good bounds')
      codes(1) = nutate_system_destroy(c_loc(system))
   end subroutine c_refuses

   !> Checks that no step of a scene with a callback of each kind is certified without bounds, and every one with them.
   !> The system that is made from the scene has its bounds.
   subroutine scenes_are_bound(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: text = '&body inertia = 3, 4, 2 / &initial angular_velocity = 0.5, -0.4, 2 / '// &
                                     '&integrator time_step = 0.01, end_time = 0.2 /'//c_null_char
      character(len=len(text)), target :: source
      type(c_ptr), target :: scene, system, stepper
      integer(c_int) :: codes(9)
      integer(c_int64_t) :: counts(3)
      source = text
      codes(1) = nutate_scene_parse(c_loc(source), c_null_ptr, c_null_ptr, 0_c_size_t, c_loc(scene), c_null_ptr, &
                                    0_c_size_t)
      codes(2) = nutate_scene_bound_potential(scene, 1.0_wp, 1.0_wp, 1.0_wp)
      codes(3) = nutate_scene_bound_torque(scene, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp)
      call check(error, all(codes(1:3) == [NUTATE_OK, NUTATE_BAD_ARGUMENT, NUTATE_BAD_ARGUMENT]), 'no callback')
      codes(1) = nutate_scene_add_potential(scene, [0.0_wp, 0.0_wp, 1.0_wp], c_funloc(spring_in_height), &
                                            c_null_funptr, c_null_ptr)
      codes(2) = nutate_scene_add_user_torque(scene, c_funloc(motor), c_null_ptr)
      counts(1) = run_scene(scene)
      associate (u => spring_bounds, tau => motor_bounds)
         codes(3) = nutate_scene_bound_potential(scene, u(1), u(2), u(3))
         codes(4) = nutate_scene_bound_torque(scene, tau(1), tau(2), tau(3), tau(4))
      end associate
      counts(2) = run_scene(scene)
      codes(5) = nutate_scene_system(scene, c_loc(system), c_null_ptr, 0_c_size_t)
      codes(6) = nutate_stepper_create(system, c_loc(stepper), c_null_ptr, 0_c_size_t)
      codes(7) = nutate_stepper_set_time_step(stepper, 0.01_wp)
      codes(8) = nutate_stepper_run(stepper, 5_c_int64_t, 1_c_int64_t, c_null_ptr, 0_c_size_t)
      codes(9) = nutate_stepper_uncertified(stepper, counts(3))
      call check(error, all(codes == NUTATE_OK), 'a function of C fails')
      call check(error, all(int(counts) == [20, 0, 0]), 'steps not certified')
      codes(1) = nutate_stepper_destroy(c_loc(stepper))
      codes(2) = nutate_system_destroy(c_loc(system))
      codes(3) = nutate_scene_destroy(c_loc(scene))
   end subroutine scenes_are_bound

   !> Steps of a run of a scene that are not certified; -1 where it fails.
   integer(c_int64_t) function run_scene(scene) result(uncertified)
      type(c_ptr), intent(in) :: scene
      type(c_ptr), target :: history
      integer(c_int) :: code
      uncertified = -1
      code = nutate_scene_run(scene, c_loc(history), c_null_ptr, 0_c_size_t)
      if (code == NUTATE_OK) code = nutate_history_uncertified(history, uncertified)
      code = nutate_history_destroy(c_loc(history))
   end function run_scene

end submodule test_bounds
