!> The FORTRAN 77 routines that move a body, against the library.
submodule(suites_of_interfaces) test_f77
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use nutate_kinds, only: eps, wp
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_NOT_FINITE, status_t
   use test_f77_routines, only: nufram, nuinv, nuncer, nuomeg, nurun, nusetp, nustat, nustep, nutext, potnan, potspr, &
      tormot, tornan
   use test_f77_twins, only: forced_twin, iuser, most, plain, row_keeper_t, run_library, start, top_twin, twin_of, &
      twin_t
   use test_problems, only: angular_velocity, body_momentum, box, kinetic_energy, make_state, space_momentum, &
      total_energy
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_f77
      testsuite = [ &
                  new_unittest("F77 box has the digits of the library", box_has_the_digits), &
                  new_unittest("F77 heavy top has the digits of the library", top_has_the_digits), &
                  new_unittest("F77 forced body has the digits of the library", forced_has_the_digits), &
                  new_unittest("F77 finite J0 has the digits of the library", finite_j0_has_the_digits), &
                  new_unittest("F77 space axes that turn have the digits of the library", frame_has_the_digits), &
                  new_unittest("F77 frame finds the wrong argument", frame_finds_wrong), &
                  new_unittest("F77 steps one by one have the digits of all at once", one_by_one_is_all_at_once), &
                  new_unittest("F77 rows have the digits of the library", rows_have_the_digits), &
                  new_unittest("F77 interleaved motions do not disturb each other", interleaved_motions_are_alone), &
                  new_unittest("F77 copy of WORK goes on like the original", copy_goes_on), &
                  new_unittest("F77 changed state begins anew", changed_state_begins_anew), &
                  new_unittest("F77 steps lead back in time", steps_lead_back), &
                  new_unittest("F77 work of the torques is the change of energy", work_is_change_of_energy), &
                  new_unittest("F77 step that is too long changes nothing", long_step_changes_nothing), &
                  new_unittest("F77 callback without a number is told", callback_without_number_is_told), &
                  new_unittest("F77 states and invariants are the library's", states_are_the_librarys)]
   end procedure collect_f77

   !> A forced body, and one that is free but for a potential, in space axes that turn about any axis and about the
   !> direction of the potential: the digits are the library's, and the Jacobi integral of the others, by what NUINV
   !> gives, is kept.
   subroutine frame_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: dt = 0.02_wp
      type(twin_t) :: twin
      type(row_keeper_t) :: keeper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work(most), t, q(4), p(4), e(3), al(3, 2), c(2), jacobi(2), w(3)
      integer :: info, i, iform
      do iform = 1, 2
         do i = 1, 3
            twin = forced_twin(iform, merge(4, 2, i == 1))
            if (i > 1) call leave_potential(twin)
            w = [0.1_wp, -0.2_wp, 0.3_wp]
            if (i == 3) w = 0.3_wp*twin%dn
            call twin%problem%system%effects%add(rotating_frame_t(rate=w))
            call run_library(twin, dt, 30, 30, state, keeper, status)
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            call start(twin, work, most, t, q, p, info)
            call nufram(w, work, most, info)
            call check(error, info, 0, 'NUFRAM')
            if (allocated(error)) return
            call nuinv(q, p, potspr, iuser, plain, e, al, c, work, most, info)
            jacobi(1) = e(3) - dot_product(w, al(:, 2))
            call nustep(10, dt, t, q, p, potspr, tormot, iuser, plain, work, most, info)
            call nustep(20, dt, t, q, p, potspr, tormot, iuser, plain, work, most, info)
            call check(error, info, 0, 'NUSTEP')
            call check(error, all(abs([q - state%q, p - state%p]) <= 0.0_wp), 'other digits than the library')
            if (i == 1) cycle
            call nuinv(q, p, potspr, iuser, plain, e, al, c, work, most, info)
            jacobi(2) = e(3) - dot_product(w, al(:, 2))
            call check_close(error, jacobi(2), jacobi(1), 100*eps*(abs(e(1)) + abs(e(2))), 'Jacobi integral')
         end do
      end do
   end subroutine frame_has_the_digits

   !> Removes the torques.
   subroutine leave_potential(twin)
      type(twin_t), intent(inout) :: twin
      twin%d = 0.0_wp
      twin%icall = 1
      deallocate (twin%problem%system%effects%torques)
      twin%problem%system%effects%n_torques = 0
   end subroutine leave_potential

   subroutine frame_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), t, q(4), p(4), w(3)
      integer :: info(5)
      w = 0.1_wp
      call start(forced_twin(1, 2), work, most, t, q, p, info(1))
      w(2) = ieee_value(w(2), ieee_quiet_nan)
      call nufram(w, work, most, info(1))
      w = 0.1_wp
      call nufram(w, work, 20, info(2))
      call nufram(w, work, most, info(3))
      call nustep(1, 0.01_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info(4))
      call nufram(w, work, most, info(4))
      work = 0.0_wp
      call nufram(w, work, most, info(5))
      call check(error, all(info == [-1, -3, 0, -2, -2]), 'NUFRAM tells other arguments')
   end subroutine frame_finds_wrong

   !> Checks that after n steps in calls of `length` steps the state is the library's to the last digit.
   subroutine compare(error, twin, dt, n, length)
      type(error_type), allocatable, intent(inout) :: error
      type(twin_t), intent(in) :: twin
      real(wp), intent(in) :: dt
      integer, intent(in) :: n, length
      real(wp) :: work(most), t, q(4), p(4)
      type(state_t) :: state
      type(row_keeper_t) :: keeper
      type(status_t) :: status
      integer :: info, i
      call run_library(twin, dt, n, n, state, keeper, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call start(twin, work, most, t, q, p, info)
      call check(error, info, 0, 'NUINIT')
      if (allocated(error)) return
      do i = 1, n, length
         call nustep(min(length, n - i + 1), dt, t, q, p, potspr, tormot, iuser, plain, work, most, info)
         call check(error, info, 0, 'NUSTEP')
      end do
      call check_close(error, [t, q, p], [state%t, state%q, state%p], 0.0_wp)
   end subroutine compare

   subroutine box_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: iform, iorder
      do iform = 1, 2
         do iorder = 2, 8, 2
            call compare(error, twin_of(box(), iform, iorder), 0.01_wp, 150, 150)
         end do
      end do
   end subroutine box_has_the_digits

   subroutine top_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: iform, iorder
      do iform = 1, 2
         do iorder = 2, 8, 2
            call compare(error, top_twin(iform, iorder), 2e-3_wp, 100, 100)
         end do
      end do
   end subroutine top_has_the_digits

   subroutine forced_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: iform, iorder
      do iform = 1, 2
         do iorder = 2, 8, 2
            call compare(error, forced_twin(iform, iorder), 0.013_wp, 100, 100)
         end do
      end do
   end subroutine forced_has_the_digits

   subroutine finite_j0_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      twin = top_twin(2, 4)
      twin%aj0 = 0.5_wp
      twin%settings%inverse_auxiliary_inertia = 2.0_wp
      call compare(error, twin, 2e-3_wp, 100, 7)
   end subroutine finite_j0_has_the_digits

   subroutine one_by_one_is_all_at_once(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: iform, iorder
      do iform = 1, 2
         do iorder = 2, 4, 2
            call compare(error, twin_of(box(), iform, iorder), 0.01_wp, 150, 1)
            call compare(error, top_twin(iform, iorder), 2e-3_wp, 100, 1)
            call compare(error, forced_twin(iform, iorder), 0.013_wp, 100, 1)
            call compare(error, forced_twin(iform, iorder), -0.013_wp, 100, 13)
         end do
      end do
   end subroutine one_by_one_is_all_at_once

   subroutine rows_have_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      type(row_keeper_t) :: keeper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work(most), t, q(4), p(4), rows(12, 40)
      integer :: info, nrows, istat(3)
      twin = forced_twin(1, 4)
      call run_library(twin, 0.013_wp, 100, 7, state, keeper, status)
      call start(twin, work, most, t, q, p, info)
      call nurun(100, 0.013_wp, t, q, p, potspr, tormot, iuser, plain, 7, rows, 16, nrows, work, most, info)
      call check(error, info, 0)
      call check(error, nrows, 16)
      call check(error, keeper%n, 16)
      if (.not. allocated(error)) call check_close(error, reshape(rows(:, 1:16), [192]), &
                                                   reshape(keeper%rows(:, 1:16), [192]), 0.0_wp)
      call check_close(error, [t, q, p], [state%t, state%q, state%p], 0.0_wp)
      call nustat(istat, t, work, most, info)
      call check(error, istat(1) == 100 .and. istat(2) >= 1000 .and. istat(3) == 0)
      ! No step with a user-defined potential without bounds is certified.
      call nuncer(nrows, work, most, info)
      call check(error, info == 0 .and. nrows == 100, 'NUNCER')
   end subroutine rows_have_the_digits

   subroutine interleaved_motions_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin(2)
      real(wp) :: work(most, 2), t(2), q(4, 2), p(4, 2), dt(2)
      type(state_t) :: state
      type(row_keeper_t) :: keeper
      type(status_t) :: status
      integer :: info, i, k
      twin(1) = top_twin(1, 2)
      twin(2) = forced_twin(2, 4)
      dt = [2e-3_wp, 0.01_wp]
      do k = 1, 2
         call start(twin(k), work(:, k), most, t(k), q(:, k), p(:, k), info)
      end do
      do i = 1, 20
         do k = 1, 2
            call nustep(3, dt(k), t(k), q(:, k), p(:, k), potspr, tormot, iuser, plain, work(:, k), most, info)
         end do
      end do
      do k = 1, 2
         call run_library(twin(k), dt(k), 60, 60, state, keeper, status)
         call check_close(error, [t(k), q(:, k), p(:, k)], [state%t, state%q, state%p], 0.0_wp)
      end do
   end subroutine interleaved_motions_are_alone

   subroutine copy_goes_on(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), copy(most), t(2), q(4, 2), p(4, 2)
      integer :: info, i
      call start(top_twin(1, 4), work, most, t(1), q(:, 1), p(:, 1), info)
      call nustep(20, 2e-3_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
      copy = work
      t(2) = t(1)
      q(:, 2) = q(:, 1)
      p(:, 2) = p(:, 1)
      do i = 1, 5
         call nustep(4, 2e-3_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
      end do
      work = -1.0_wp
      call nustep(20, 2e-3_wp, t(2), q(:, 2), p(:, 2), potspr, tormot, iuser, plain, copy, most, info)
      call check(error, info, 0)
      call check_close(error, [t(2), q(:, 2), p(:, 2)], [t(1), q(:, 1), p(:, 1)], 0.0_wp)
   end subroutine copy_goes_on

   !> Checks that data of another motion in WORK leave no trace.
   subroutine changed_state_begins_anew(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), fresh(most), t(2), q(4, 2), p(4, 2)
      integer :: info, iform
      do iform = 1, 2
         twin = forced_twin(iform, 2)
         call start(twin, work, most, t(1), q(:, 1), p(:, 1), info)
         call start(twin, fresh, most, t(2), q(:, 2), p(:, 2), info)
         call nustep(20, 0.01_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
         t(1) = t(2)
         q(:, 1) = q(:, 2)
         p(:, 1) = p(:, 2)
         call nustep(20, 0.013_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
         call nustep(20, 0.013_wp, t(2), q(:, 2), p(:, 2), potspr, tormot, iuser, plain, fresh, most, info)
         call check_close(error, [t(2), q(:, 2), p(:, 2)], [t(1), q(:, 1), p(:, 1)], 0.0_wp)
      end do
   end subroutine changed_state_begins_anew

   subroutine steps_lead_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), t, q(4), p(4)
      integer :: info
      twin = forced_twin(1, 2)
      twin%d = 0.0_wp
      call start(twin, work, most, t, q, p, info)
      call nustep(60, 0.01_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
      call nustep(60, -0.01_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
      call check(error, info, 0)
      call check_close(error, [t, q, p/10], [twin%problem%start%t, twin%problem%start%q, twin%problem%start%p/10], &
                       1e3_wp*eps)
   end subroutine steps_lead_back

   subroutine work_is_change_of_energy(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: work(most), t, q(4), p(4), before(3), after(3), al(3, 2), c(2), w
      integer :: info, istat(3)
      call start(forced_twin(2, 2), work, most, t, q, p, info)
      call nuinv(q, p, potspr, iuser, plain, before, al, c, work, most, info)
      call nustep(77, 0.01_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
      call nuinv(q, p, potspr, iuser, plain, after, al, c, work, most, info)
      call nustat(istat, w, work, most, info)
      call check(error, info, 0)
      call check(error, abs(w) > 0.01_wp)
      call check_close(error, w, after(3) - before(3), 64*eps*abs(before(3)))
   end subroutine work_is_change_of_energy

   subroutine long_step_changes_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), copy(most), t, q(4), p(4), rows(12, 9)
      character(len=72) :: text
      integer :: info, iform, nrows
      do iform = 1, 2
         twin = top_twin(iform, 2)
         call start(twin, work, most, t, q, p, info)
         copy = work
         call nustep(3, 1e3_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
         call check(error, info == 1 .or. info == 2, 'a step of 1000 s was taken')
         call check_close(error, [t, q, p, work], [twin%problem%start%t, twin%problem%start%q, twin%problem%start%p, &
                          copy], 0.0_wp)
         call nutext(info, text)
         call check(error, len_trim(text) > 20 .and. index(text, 'subdivided') > 0, text)
         call nurun(3, 1e3_wp, t, q, p, potspr, tormot, iuser, plain, 1, rows, 9, nrows, work, most, info)
         call check(error, info > 0 .and. nrows == 1)
      end do
   end subroutine long_step_changes_nothing

   subroutine callback_without_number_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), copy(most), t, q(4), p(4), ruser(7), e(3), al(3, 2), c(2), bad(2)
      integer :: info, iform, i
      bad = [ieee_value(0.0_wp, ieee_quiet_nan), ieee_value(0.0_wp, ieee_positive_inf)]
      ruser = plain
      do iform = 1, 2
         do i = 1, 2
            ruser(7) = bad(i)
            twin = forced_twin(iform, 2*i)
            call start(twin, work, most, t, q, p, info)
            copy = work
            call nustep(20, 0.01_wp, t, q, p, potspr, tornan, iuser, ruser, work, most, info)
            call check(error, info, NUTATE_NOT_FINITE, 'torque')
            call check_close(error, [t, q, p, work], [twin%problem%start%t, twin%problem%start%q, &
                             twin%problem%start%p, copy], 0.0_wp)
            call nustep(20, 0.01_wp, t, q, p, potnan, tormot, [3, i - 1], ruser, work, most, info)
            call check(error, info, NUTATE_NOT_FINITE, 'potential')
         end do
      end do
      call nuinv(q, p, potnan, [3, 0], ruser, e, al, c, work, most, info)
      call check(error, info, NUTATE_NOT_FINITE, 'energy')
   end subroutine callback_without_number_is_told

   subroutine states_are_the_librarys(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      type(state_t) :: state
      real(wp) :: work(most), t, q(4), p(4), omega(3), e(3), al(3, 2), c(2)
      integer :: info
      twin = forced_twin(2, 2)
      call start(twin, work, most, t, q, p, info)
      associate (system => twin%problem%system)
         state = make_state(system, q, [0.3_wp, 0.7_wp, -1.1_wp])
         call nusetp(q, [0.3_wp, 0.7_wp, -1.1_wp], p, work, most, info)
         call check_close(error, p, state%p, 0.0_wp, 'P')
         call nuomeg(q, p, omega, work, most, info)
         call check_close(error, omega, angular_velocity(system, state), 0.0_wp, 'OMEGA')
         call nuinv(q, p, potspr, iuser, plain, e, al, c, work, most, info)
         call check_close(error, [e(1), e(3), al(:, 1), al(:, 2)], [kinetic_energy(system, state), &
                          total_energy(system, state), body_momentum(state), space_momentum(state)], 0.0_wp)
         call check_close(error, [e(2), c], [e(3) - e(1), 1.0_wp, 0.0_wp], 16*eps)
      end associate
   end subroutine states_are_the_librarys

end submodule test_f77
