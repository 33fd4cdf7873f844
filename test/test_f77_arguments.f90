!> The FORTRAN 77 routines that move a body, against every wrong argument.
submodule(suites_of_interfaces) test_f77_arguments
   use, intrinsic :: iso_fortran_env, only: int64
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_kinds, only: wp
   use test_f77_routines, only: nuinv, nuomeg, nuncer, nurun, nusetp, nustat, nustep, potspr, tormot
   use test_f77_twins, only: forced_twin, iuser, most, plain, start, top_twin, twin_t
   use test_support, only: check, error_type, new_unittest
   implicit none

contains

   module procedure collect_f77_arguments
      testsuite = [ &
                  new_unittest("F77 length of WORK is told", length_is_told), &
                  new_unittest("F77 NUINIT finds the wrong argument", init_finds_wrong), &
                  new_unittest("F77 NUSTEP finds the wrong argument", step_finds_wrong), &
                  new_unittest("F77 NURUN, NUSTAT and NUNCER find the wrong argument", run_finds_wrong), &
                  new_unittest("F77 states find the wrong argument", states_find_wrong)]
   end procedure collect_f77_arguments

   !> The length that a query gives will do, one less will not, and nothing is touched beyond it.
   subroutine length_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin, empty
      real(wp) :: work(most), t, q(4), p(4)
      integer :: info, iform, iorder, n
      do iform = 1, 2
         do iorder = 2, 8, 2
            twin = top_twin(iform, iorder)
            call start(twin, work, -1, t, q, p, info)
            n = nint(work(1))
            call check(error, info == 0 .and. n > 100 .and. n < most)
            if (allocated(error)) return
            empty = twin
            empty%aj = 0.0_wp
            empty%g = ieee_value(0.0_wp, ieee_quiet_nan)
            call start(empty, work, -1, t, q, p, info)
            call check(error, info == 0 .and. nint(work(1)) == n, 'a query before there is a body')
            if (allocated(error)) return
            empty%iorder = 3
            call start(empty, work, -1, t, q, p, info)
            call check(error, info == -9 .and. work(1) == 0.0_wp, 'a query for an order that does not exist')
            call start(twin, work, n - 1, t, q, p, info)
            call check(error, info, -12)
            call start(twin, work, n, t, q, p, info)
            work(n + 1:) = 7.0_wp
            call nustep(5, 2e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, n - 1, info)
            call check(error, info, -11)
            call nustep(5, 2e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, n, info)
            call check(error, info == 0 .and. all(work(n + 1:) == 7.0_wp))
         end do
      end do
   end subroutine length_is_told

   subroutine init_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin, good
      integer, parameter :: expected(18) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 1, 1, 2, 7, 8, 1, 10]
      real(wp) :: work(most), t, q(4), p(4), nan
      integer :: info, i
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      good = top_twin(1, 2)
      do i = 1, 18
         twin = good
         select case (i)
         case (1); twin%aj(2, 1) = nan
         case (2); twin%aj0 = nan
         case (3); twin%h(3) = nan
         case (4); twin%cm(1) = nan
         case (5); twin%g(2) = nan
         case (6); twin%d(3) = 1e200_wp
         case (7); twin%dn(1) = nan
         case (8); twin%iform = 3
         case (9); twin%iorder = 3
         case (10); twin%icall = 4
         case (11); twin%aj(3, 3) = -1.0_wp
         case (12); twin%aj(1, 2) = 1.0_wp
         case (13); twin%aj = 0.0_wp
         case (14); twin%aj0 = 1e-200_wp
         case (15)
            twin%dn = 0.0_wp
            twin%icall = 1
         case (16); twin%iform = 0
         case (17); twin%aj = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 4.0_wp], [3, 3])
         case default; twin%icall = -1
         end select
         call start(twin, work, most, t, q, p, info)
         call check(error, -info, expected(i))
         call check(error, all(work == 0.0_wp), 'WORK was touched')
      end do
      call start(good, work, 0, t, q, p, info)
      call check(error, info, -12)
   end subroutine init_finds_wrong

   subroutine step_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: expected(14) = [1, 2, 2, 2, 3, 4, 4, 5, 5, 10, 11, 10, 5, 10]
      real(wp) :: work(most), t, q(4), p(4), dt, nan, before(most)
      integer :: info, i, n, lwork
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      do i = 1, size(expected)
         call start(top_twin(1, 2), work, most, t, q, p, info)
         n = 1
         dt = 1e-3_wp
         lwork = most
         select case (i)
         case (1); n = -1
         case (2); dt = 0.0_wp
         case (3); dt = nan
         case (4); dt = 1e300_wp
         case (5); t = nan
         case (6); q(2) = 1e-4_wp
         case (7); q(3) = nan
         case (8); p(3) = nan
         case (9); p = p + q
         case (10); work = nan
         case (11); lwork = 100
         case (12); lwork = -1
         case (13); p = 1e30_wp*p
         ! The mark of an earlier version, `NUTATE 1` in ASCII.
         case default; work(2) = transfer(int(z'4E55544154452031', int64), 0.0_wp)
         end select
         before = work
         call nustep(n, dt, t, q, p, potspr, tormot, iuser, plain, work, lwork, info)
         call check(error, info, -expected(i))
         call check(error, all(transfer(work, n, 2*most) == transfer(before, n, 2*most)))
      end do
      call start(top_twin(1, 2), work, most, t, q, p, info)
      call nustep(0, 1e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
      call check(error, info, 0, 'no steps')
   end subroutine step_finds_wrong

   subroutine run_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: expected(11) = [1, 2, 3, 4, 5, 10, 12, 14, 15, 12, 0]
      real(wp) :: work(most), t, q(4), p(4), dt, rows(12, 9), w
      integer :: info, i, n, k, mrows, lwork, nrows, istat(3)
      do i = 1, size(expected)
         call start(top_twin(1, 2), work, most, t, q, p, info)
         n = 8
         dt = 1e-3_wp
         k = 3
         mrows = 4
         lwork = most
         nrows = 0
         select case (i)
         case (1); n = -1
         case (2); dt = 0.0_wp
         case (3); t = 1e200_wp
         case (4); q = 2*q
         case (5); p = 1e200_wp*p
         case (6); k = 0
         case (7); mrows = 3
         case (8); work = 0.0_wp
         case (9); lwork = 90
         case (10)
            n = huge(n)
            k = 1
         case default; n = 9
         end select
         call nurun(n, dt, t, q, p, potspr, tormot, iuser, plain, k, rows, mrows, nrows, work, lwork, info)
         call check(error, info, -expected(i))
         call check(error, nrows, merge(4, 0, i == 11))
      end do
      call nustat(istat, w, work, 90, info)
      call check(error, info, -4)
      call nustat(istat, w, 0*work, most, info)
      call check(error, info, -3)
      call nuncer(n, work, 90, info)
      call check(error, info, -3)
      call nuncer(n, 0*work, most, info)
      call check(error, info, -2)
   end subroutine run_finds_wrong

   subroutine states_find_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), t, q(4), p(4), omega(3), e(3), al(3, 2), c(2), nan
      integer :: info(12)
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      call start(forced_twin(2, 2), work, most, t, q, p, info(1))
      omega = 1.0_wp
      call nusetp(2*q, omega, p, work, most, info(1))
      call nusetp(q, nan*omega, p, work, most, info(2))
      call nusetp(q, omega, p, spread(0.0_wp, 1, most), most, info(3))
      call nusetp(q, omega, p, work, 99, info(4))
      call nuomeg(nan*q, p, omega, work, most, info(5))
      call nuomeg(q, nan*p, omega, work, most, info(6))
      call nuomeg(q, p, omega, spread(0.0_wp, 1, most), most, info(7))
      call nuomeg(q, p, omega, work, 99, info(8))
      call nuinv(0*q, p, potspr, iuser, plain, e, al, c, work, most, info(9))
      call nuinv(q, 1e200_wp*p, potspr, iuser, plain, e, al, c, work, most, info(10))
      call nuinv(q, p, potspr, iuser, plain, e, al, c, spread(0.0_wp, 1, most), most, info(11))
      call nuinv(q, p, potspr, iuser, plain, e, al, c, work, 99, info(12))
      call check(error, all(info(:12) == -[1, 2, 4, 5, 1, 2, 4, 5, 1, 2, 9, 10]))
   end subroutine states_find_wrong

end submodule test_f77_arguments
