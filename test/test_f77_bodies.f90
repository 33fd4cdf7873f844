!> Many bodies in FORTRAN 77: the bits of Fortran, failures, every wrong argument.
submodule(suites_of_interfaces) test_f77_bodies
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_bodies, only: bodies_t
   use nutate_bodies_drift, only: body_class_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_f77_classes, only: classes_length
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, NUTATE_NOT_FINITE
   use test_support, only: check, error_type, new_unittest, random_unit_quaternion, random_vector
   implicit none

   interface
      subroutine nubset(nc, aj, iframe, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: nc, iframe, lwork
         real(wp), intent(in) :: aj(3, 3, *)
         real(wp), intent(inout) :: work(*)
         integer, intent(out) :: info
      end subroutine nubset

      subroutine nubthr(nt, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: nt, lwork
         real(wp), intent(inout) :: work(*)
         integer, intent(out) :: info
      end subroutine nubthr

      subroutine nubody(n, dt, ic, q, al, tor, mbad, ibad, nbad, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: n, ic(*), mbad, lwork
         real(wp), intent(in) :: dt, tor(3, *), work(*)
         real(wp), intent(inout) :: q(4, *), al(3, *)
         integer, intent(inout) :: ibad(*), nbad
         integer, intent(out) :: info
      end subroutine nubody

      subroutine nubkik(n, dt, ic, q, al, tor, mbad, ibad, nbad, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: n, ic(*), mbad, lwork
         real(wp), intent(in) :: dt, tor(3, *), work(*)
         real(wp), intent(inout) :: q(4, *), al(3, *)
         integer, intent(inout) :: ibad(*), nbad
         integer, intent(out) :: info
      end subroutine nubkik

      subroutine nubdrf(n, dt, ic, q, al, mbad, ibad, nbad, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: n, ic(*), mbad, lwork
         real(wp), intent(in) :: dt, work(*)
         real(wp), intent(inout) :: q(4, *), al(3, *)
         integer, intent(inout) :: ibad(*), nbad
         integer, intent(out) :: info
      end subroutine nubdrf
   end interface

   integer, parameter :: n = 100, lwork = 50

contains

   module procedure collect_f77_bodies
      testsuite = [ &
         new_unittest("F77 bodies have the bits of Fortran", bodies_have_the_bits_of_fortran), &
         new_unittest("F77 bodies that fail are listed", bodies_that_fail_are_listed), &
         new_unittest("F77 bodies find the wrong argument", bodies_find_the_wrong_argument)]
   end procedure collect_f77_bodies

   !> Two classes, one with a tensor, and states.
   subroutine start(aj, ic, q, al, tor)
      real(wp), intent(out) :: aj(3, 3, 2), q(4, n), al(3, n), tor(3, n)
      integer, intent(out) :: ic(n)
      integer(int64) :: seed
      integer :: i
      seed = 41_int64
      aj(:, :, 1) = diagonal([1.0_wp, 2.0_wp, 2.5_wp])
      aj(:, :, 2) = diagonal([3.0_wp, 2.0_wp, 2.5_wp])
      aj(1, 2, 2) = 0.3_wp
      aj(2, 1, 2) = 0.3_wp
      do i = 1, n
         q(:, i) = random_unit_quaternion(seed)
         al(:, i) = random_vector(seed)
         tor(:, i) = random_vector(seed)
         ic(i) = 1 + modulo(i, 2)
      end do
   end subroutine start

   subroutine bodies_have_the_bits_of_fortran(error)
      type(error_type), allocatable, intent(out) :: error
      type(bodies_t) :: bodies
      type(body_t) :: classes(2)
      type(status_t) :: status
      real(wp) :: aj(3, 3, 2), q(4, n), al(3, n), tor(3, n), q1(4, n), l1(3, n), work(lwork)
      integer :: ic(n), info(3), nbad, ibad(1), frame
      call check(error, classes_length(1) - classes_length(0), storage_size(body_class_t())/storage_size(1.0_wp), &
                 'numbers of a class in WORK')
      do frame = 0, 2
         call start(aj, ic, q, al, tor)
         q1 = q
         l1 = al
         call make_body(aj(:, :, 1), classes(1), status)
         call make_body(aj(:, :, 2), classes(2), status)
         call bodies%set_up(classes, status, frame)
         call nubset(2, aj, frame, work, lwork, info(1))
         call nubthr(merge(0, 3, frame == 0), work, lwork, info(2))
         call check(error, all(info(1:2) == 0), 'NUBSET or NUBTHR')
         call bodies%step(0.1_wp, q1, l1, tor, status, ic)
         call nubody(n, 0.1_wp, ic, q, al, tor, 1, ibad, nbad, work, lwork, info(1))
         call bodies%drift(0.1_wp, q1, l1, status)
         call nubdrf(n, 0.1_wp, [0], q, al, 1, ibad, nbad, work, lwork, info(2))
         call bodies%kick(0.1_wp, q1, l1, tor, status, ic)
         call nubkik(n, 0.1_wp, ic, q, al, tor, 1, ibad, nbad, work, lwork, info(3))
         call check(error, all(info == 0) .and. nbad == 0, 'INFO')
         call check(error, all(abs(q - q1) <= 0.0_wp) .and. all(abs(al - l1) <= 0.0_wp), 'other bits')
      end do
   end subroutine bodies_have_the_bits_of_fortran

   subroutine bodies_that_fail_are_listed(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: aj(3, 3, 2), q(4, n), al(3, n), tor(3, n), q1(4, n), work(lwork)
      integer :: ic(n), info, nbad, ibad(3)
      call start(aj, ic, q, al, tor)
      call nubset(2, aj, 0, work, lwork, info)
      tor(1, 7) = ieee_value(1.0_wp, ieee_quiet_nan)
      q(:, 20) = 2*q(:, 20)
      ic(90) = 3
      q1 = q
      ibad = -1
      call nubody(n, 0.1_wp, ic, q, al, tor, 2, ibad, nbad, work, lwork, info)
      call check(error, info, NUTATE_NOT_FINITE)
      call check(error, nbad, 3)
      call check(error, all(ibad == [7, 20, -1]), 'IBAD')
      call check(error, all(abs(q(:, [7, 20, 90]) - q1(:, [7, 20, 90])) <= 0.0_wp), 'a state has changed')
      call check(error, all(maxval(abs(q(:, 21:89) - q1(:, 21:89)), 1) > 0.0_wp), 'the others stood still')
   end subroutine bodies_that_fail_are_listed

   subroutine bodies_find_the_wrong_argument(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: aj(3, 3, 2), q(4, n), al(3, n), tor(3, n), q1(4, n), work(lwork), blank(lwork)
      integer :: ic(n), info(5), nbad, ibad(1)
      call start(aj, ic, q, al, tor)
      q1 = q
      blank = 0.0_wp
      call nubset(0, aj, 0, work, lwork, info(1))
      call nubset(2, -aj, 0, work, lwork, info(2))
      call nubset(2, aj, 3, work, lwork, info(3))
      call nubset(2, aj, 0, work, lwork - 1, info(4))
      call nubset(2, aj, 0, work, lwork, info(5))
      call check(error, all(info == [-1, -2, -3, -5, 0]), 'NUBSET')
      call nubthr(-1, work, lwork, info(1))
      call nubthr(4097, work, lwork, info(2))
      call nubthr(2, blank, lwork, info(3))
      call nubthr(2, work, 49, info(4))
      call nubthr(2, work, lwork, info(5))
      call check(error, all(info == [-1, -1, -2, -3, 0]), 'NUBTHR')
      call nubset(1, reshape(diagonal([1.0_wp, 2.0_wp, 4.0_wp]), [3, 3, 1]), 0, work, lwork, info(1))
      call check(error, info(1), -2, 'moments of no body')
      call nubody(-1, 0.1_wp, ic, q, al, tor, 1, ibad, nbad, work, lwork, info(1))
      call nubody(n, 0.0_wp, ic, q, al, tor, 1, ibad, nbad, work, lwork, info(2))
      call nubody(n, 0.1_wp, ic, q, al, tor, -1, ibad, nbad, work, lwork, info(3))
      call nubody(n, 0.1_wp, ic, q, al, tor, 1, ibad, nbad, blank, lwork, info(4))
      call nubody(n, 0.1_wp, ic, q, al, tor, 1, ibad, nbad, work, 49, info(5))
      call check(error, all(info == [-1, -2, -7, -10, -11]), 'NUBODY')
      call nubkik(n, 0.1_wp, ic, q, al, tor, -1, ibad, nbad, work, lwork, info(1))
      call check(error, info(1), -7)
      call nubdrf(n, 0.1_wp, ic, q, al, -1, ibad, nbad, work, lwork, info(1))
      call nubdrf(n, 0.1_wp, ic, q, al, 1, ibad, nbad, blank, lwork, info(2))
      call nubdrf(n, 0.1_wp, ic, q, al, 1, ibad, nbad, work, 3, info(3))
      call check(error, all(info(1:3) == [-6, -9, -10]), 'NUBDRF')
      call check(error, all(abs(q - q1) <= 0.0_wp), 'a state has changed')
   end subroutine bodies_find_the_wrong_argument

end submodule test_f77_bodies
