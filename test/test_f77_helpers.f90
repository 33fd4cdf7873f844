!> The FORTRAN 77 routines that take no steps: attitudes, the exact free motion, messages.
submodule(suites_of_interfaces) test_f77_helpers
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_attitude, only: quat_from_euler
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: eps, wp
   use nutate_quaternion, only: rotation_matrix
   use nutate_status, only: NUTATE_STEP_LIMIT, status_t
   use test_f77_routines, only: nue2q, nufree, num2q, nuq2e, nuq2m, nutext, nuwhy
   use test_problems, only: forced_body, problem_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: rotated(4) = [0.1_wp, -0.5_wp, 0.7_wp, 0.5_wp]

contains

   module procedure collect_f77_helpers
      testsuite = [ &
                  new_unittest("F77 matrix there and back", matrix_there_and_back), &
                  new_unittest("F77 Euler angles there and back", euler_there_and_back), &
                  new_unittest("F77 attitudes find the wrong argument", attitudes_find_wrong), &
                  new_unittest("F77 free motion is the exact one", free_motion_is_exact), &
                  new_unittest("F77 free motion finds the wrong argument", free_motion_finds_wrong), &
                  new_unittest("F77 every INFO has its text", every_info_has_its_text), &
                  new_unittest("F77 wrong arguments are named", wrong_arguments_are_named)]
   end procedure collect_f77_helpers

   subroutine matrix_there_and_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: r(3, 3), q(4)
      integer :: info(2)
      q = 0.0_wp
      r = 0.0_wp
      call nuq2m(rotated, r, info(1))
      call num2q(r, q, info(2))
      call check(error, all(info == 0))
      call check(error, all(r == rotation_matrix(rotated)))
      call check_close(error, q, rotated, 4*eps)
   end subroutine matrix_there_and_back

   subroutine euler_there_and_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: angles(3), q(4)
      integer :: info(2)
      angles = 0.0_wp
      q = 0.0_wp
      call nue2q(0.3_wp, 1.2_wp, -2.1_wp, q, info(1))
      call nuq2e(q, angles(1), angles(2), angles(3), info(2))
      call check(error, all(info == 0))
      call check_close(error, q, quat_from_euler(0.3_wp, 1.2_wp, -2.1_wp), 0.0_wp)
      call check_close(error, angles, [0.3_wp, 1.2_wp, -2.1_wp], 8*eps)
   end subroutine euler_there_and_back

   !> A wrong argument is told and nothing written.
   subroutine attitudes_find_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: r(3, 3), q(4), a(3), nan
      integer :: info(10)
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      r = 5.0_wp
      q = 5.0_wp
      a = 5.0_wp
      call nuq2m(2*rotated, r, info(1))
      call nuq2m(nan*rotated, r, info(2))
      call num2q(2*rotation_matrix(rotated), q, info(3))
      call num2q(-rotation_matrix(rotated), q, info(4))
      call num2q(nan*rotation_matrix(rotated), q, info(5))
      call nuq2e(0*rotated, a(1), a(2), a(3), info(6))
      call nuq2e(1e300_wp*rotated, a(1), a(2), a(3), info(7))
      call nue2q(nan, 0.0_wp, 0.0_wp, q, info(8))
      call nue2q(0.0_wp, nan, 0.0_wp, q, info(9))
      call nue2q(0.0_wp, 0.0_wp, nan, q, info(10))
      call check(error, all(info == [-1, -1, -1, -1, -1, -1, -1, -1, -2, -3]))
      call check(error, all(r == 5.0_wp) .and. all(q == 5.0_wp) .and. all(a == 5.0_wp))
   end subroutine attitudes_find_wrong

   subroutine free_motion_is_exact(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      type(status_t) :: status
      real(wp), parameter :: t(3) = [0.0_wp, 1.7_wp, -4.0_wp], start(3) = [0.2_wp, 3.0_wp, -0.4_wp]
      real(wp) :: q(4, 3), omega(3, 3), expected(4), momentum(3)
      integer :: info, i
      q = 0.0_wp
      omega = 0.0_wp
      problem => forced_body()
      associate (body => problem%system%body)
         call nufree(body%inertia, rotated, start, 3, t, q, omega, info)
         call check(error, info, 0)
         call solution%prepare(body%moments, rotated, matmul(body%inertia, start), status, body%axes)
         do i = 1, 3
            call solution%evaluate(t(i), expected, momentum)
            call check_close(error, q(:, i), expected, 0.0_wp)
            call check_close(error, matmul(body%inertia, omega(:, i)), momentum, 64*eps*norm2(momentum))
         end do
         call check_close(error, omega(:, 1), start, 64*eps)
      end associate
   end subroutine free_motion_is_exact

   subroutine free_motion_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(wp), parameter :: one(3) = 1.0_wp
      real(wp) :: q(4, 1), omega(3, 1), nan
      integer :: info(6)
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      problem => forced_body()
      q = 5.0_wp
      omega = 5.0_wp
      associate (aj => problem%system%body%inertia)
         call nufree(-aj, rotated, one, 1, [1.0_wp], q, omega, info(1))
         call nufree(aj, 2*rotated, one, 1, [1.0_wp], q, omega, info(2))
         call nufree(aj, rotated, nan*one, 1, [1.0_wp], q, omega, info(3))
         call nufree(aj, rotated, one, -1, [1.0_wp], q, omega, info(4))
         call nufree(aj, rotated, one, 1, [nan], q, omega, info(5))
         call nufree(aj, rotated, one, 0, [nan], q, omega, info(6))
      end associate
      call check(error, all(info == [-1, -2, -3, -4, -5, 0]))
      call check(error, all(q == 5.0_wp) .and. all(omega == 5.0_wp))
   end subroutine free_motion_finds_wrong

   subroutine every_info_has_its_text(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=72) :: text, unknown
      character(len=4) :: short
      integer :: info
      call nutext(1000, unknown)
      do info = 1, NUTATE_STEP_LIMIT
         call nutext(info, text)
         ! Scenes and files have no INFO.
         if (info /= 7 .and. info /= 8) call check(error, text /= unknown .and. text /= '' .and. text(72:) == '')
      end do
      call nutext(0, text)
      call check(error, text, 'success')
      call nutext(-12, text)
      call check(error, text, 'argument number 12 is wrong')
      call nutext(-huge(info) - 1, text)
      call check(error, text, 'argument number 2147483648 is wrong')
      call nutext(0, short)
      call check(error, short, 'succ')
   end subroutine every_info_has_its_text

   subroutine wrong_arguments_are_named(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=72) :: text, other
      call nuwhy('NUSTEP', -2, text)
      call check(error, text, 'argument number 2 of NUSTEP, DT, is wrong')
      call nuwhy('nurun', -16, text)
      call check(error, text, 'argument number 16 of nurun, INFO, is wrong')
      call nuwhy('NUSTEP', -13, text)
      call check(error, text, 'argument number 13 is wrong')
      call nuwhy('NUNONE', -1, text)
      call check(error, text, 'argument number 1 is wrong')
      call nuwhy('NUSTEP', -huge(1) - 1, text)
      call check(error, text, 'argument number 2147483648 is wrong')
      call nuwhy('NUSTEP', 1, text)
      call nutext(1, other)
      call check(error, text, other)
   end subroutine wrong_arguments_are_named

end submodule test_f77_helpers
