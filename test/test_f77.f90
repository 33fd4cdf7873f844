!> The FORTRAN 77 routines that move a body, against the library and against every wrong argument.
module test_f77
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use nutate_damping, only: damping_t
   use nutate_effect, only: potential_t, rotor_t, torque_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, kinetic_energy, make_state, space_momentum, &
      total_energy
   use nutate_kinds, only: eps, long, wp
   use nutate_methods, only: make_stepper
   use nutate_run, only: integrate, observer_t, run_plan_t, run_record_t, run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_NOT_FINITE, status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use test_f77_routines, only: nuinit, nuinv, nuomeg, nurun, nusetp, nustat, nustep, nutext, potnan, potspr, tormot, &
      tornan
   use test_problems, only: box, bruls_top, forced_body, problem_t
   use test_support, only: check_close
   use testdrive, only: check, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_f77

   !> What POTSPR and TORMOT compute, as effects of the library.
   type, extends(potential_t) :: spring_in_height_t
      real(wp) :: stiffness = 0.0_wp, weight = 0.0_wp
   contains
      procedure :: energy => height_energy
      procedure :: gradient => height_gradient
   end type spring_in_height_t
   type, extends(torque_t) :: motor_t
      integer :: axis = 1
      real(wp) :: strength = 0.0_wp, rate = 0.0_wp, friction = 0.0_wp
   contains
      procedure :: torque => motor_torque
   end type motor_t

   !> A problem as the library and as NUINIT have it.
   type :: twin_t
      type(problem_t) :: problem
      type(integrator_settings_t) :: settings
      real(wp) :: aj(3, 3) = 0.0_wp, aj0 = 0.0_wp, h(3) = 0.0_wp, cm(3) = 0.0_wp, g(3) = 0.0_wp, d(3) = 0.0_wp
      real(wp) :: dn(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      integer :: isolv = 1, iorder = 2, icall = 0
   end type twin_t

   !> Keeps the rows of a run.
   type, extends(observer_t) :: row_keeper_t
      real(wp) :: rows(12, 200) = 0.0_wp
      integer :: n = 0
   contains
      procedure :: observe => keep_row
   end type row_keeper_t

   !> Longest WORK of the tests: order 8 of the eight equations.
   integer, parameter :: most = 2000
   integer, parameter :: iuser(2) = [3, 0]
   !> Stiffness, weight; motor: strength, rate, friction; time and value of what spoils a motion.
   real(wp), parameter :: plain(7) = [3.0_wp, 2.0_wp, 0.7_wp, 1.3_wp, 0.2_wp, 0.35_wp, 0.0_wp]

contains

   subroutine collect_f77(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("F77 box has the digits of the library", box_has_the_digits), &
                  new_unittest("F77 heavy top has the digits of the library", top_has_the_digits), &
                  new_unittest("F77 forced body has the digits of the library", forced_has_the_digits), &
                  new_unittest("F77 finite J0 has the digits of the library", finite_j0_has_the_digits), &
                  new_unittest("F77 steps one by one have the digits of all at once", one_by_one_is_all_at_once), &
                  new_unittest("F77 rows have the digits of the library", rows_have_the_digits), &
                  new_unittest("F77 interleaved motions do not disturb each other", interleaved_motions_are_alone), &
                  new_unittest("F77 copy of WORK goes on like the original", copy_goes_on), &
                  new_unittest("F77 changed state begins anew", changed_state_begins_anew), &
                  new_unittest("F77 steps lead back in time", steps_lead_back), &
                  new_unittest("F77 work of the torques is the change of energy", work_is_change_of_energy), &
                  new_unittest("F77 step that is too long changes nothing", long_step_changes_nothing), &
                  new_unittest("F77 callback without a number is told", callback_without_number_is_told), &
                  new_unittest("F77 length of WORK is told", length_is_told), &
                  new_unittest("F77 NUINIT finds the wrong argument", init_finds_wrong), &
                  new_unittest("F77 NUSTEP finds the wrong argument", step_finds_wrong), &
                  new_unittest("F77 NURUN and NUSTAT find the wrong argument", run_finds_wrong), &
                  new_unittest("F77 states and invariants are the library's", states_are_the_librarys), &
                  new_unittest("F77 states find the wrong argument", states_find_wrong)]
   end subroutine collect_f77

   pure real(wp) function height_energy(self, gamma) result(u)
      class(spring_in_height_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      u = 0.5_wp*self%stiffness*gamma(3)*gamma(3) + self%weight*gamma(3)
   end function height_energy

   pure function height_gradient(self, gamma) result(gradient)
      class(spring_in_height_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [0.0_wp, 0.0_wp, self%stiffness*gamma(3) + self%weight]
   end function height_gradient

   pure function motor_torque(self, t, q, omega) result(tau)
      class(motor_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      tau(self%axis) = self%strength*cos(self%rate*t) - self%friction*omega(self%axis)
   end function motor_torque

   subroutine keep_row(self, system, state, record, status)
      class(row_keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%n = self%n + 1
      self%rows(:, self%n) = [state%t, state%q, angular_velocity(system, state), space_momentum(state), &
                              total_energy(system, state)]
   end subroutine keep_row

   !> A problem with the given solver, 1 reduced or 2 LAPACK.
   type(twin_t) function twin_of(problem, isolv, iorder) result(twin)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: isolv, iorder
      twin%problem = problem
      twin%isolv = isolv
      twin%iorder = iorder
      twin%settings%order = iorder
      if (isolv == 1) twin%settings%linear_solver = 'reduced'
      twin%aj = problem%system%body%inertia
      twin%cm = problem%system%body%mass*problem%system%body%center_of_mass
   end function twin_of

   !> Brüls' heavy top.
   type(twin_t) function top_twin(isolv, iorder) result(twin)
      integer, intent(in) :: isolv, iorder
      twin = twin_of(bruls_top(), isolv, iorder)
      twin%g = [0.0_wp, 0.0_wp, -9.81_wp]
   end function top_twin

   !> A full tensor with a rotor under a potential, damping and a torque that depends on time.
   type(twin_t) function forced_twin(isolv, iorder) result(twin)
      integer, intent(in) :: isolv, iorder
      type(problem_t) :: problem
      type(rotor_t) :: rotor
      type(spring_in_height_t) :: spring
      problem = forced_body()
      twin = twin_of(problem, isolv, iorder)
      twin%cm = 0.0_wp
      twin%h = [1.0_wp, 2.0_wp, -1.0_wp]
      twin%d = [0.01_wp, 0.02_wp, 0.03_wp]
      twin%dn = [0.0_wp, 0.6_wp, 0.8_wp]
      twin%icall = 3
      deallocate (twin%problem%system%effects%potentials, twin%problem%system%effects%torques)
      associate (effects => twin%problem%system%effects)
         effects%n_potentials = 0
         effects%n_torques = 0
         effects%rotor_momentum = 0.0_wp
         rotor%momentum = twin%h
         call effects%add(rotor)
         spring%direction = twin%dn
         spring%stiffness = plain(1)
         spring%weight = plain(2)
         call effects%add(spring)
         call effects%add(damping_t(twin%d))
         call effects%add(motor_t(axis=iuser(1), strength=plain(3), rate=plain(4), friction=plain(5)))
      end associate
      twin%problem%start = make_state(twin%problem%system, problem%start%q, [1.0_wp, -2.0_wp, 3.0_wp], 0.25_wp)
   end function forced_twin

   subroutine start(twin, work, lwork, t, q, p, info)
      type(twin_t), intent(in) :: twin
      real(wp), intent(out) :: work(most)
      integer, intent(in) :: lwork
      real(wp), intent(out) :: t, q(4), p(4)
      integer, intent(out) :: info
      work = 0.0_wp
      call nuinit(twin%aj, twin%aj0, twin%h, twin%cm, twin%g, twin%d, twin%dn, twin%isolv, twin%iorder, twin%icall, &
                  work, lwork, info)
      t = twin%problem%start%t
      q = twin%problem%start%q
      p = twin%problem%start%p
   end subroutine start

   !> The library's motion, with the rows of `keeper`.
   subroutine run_library(twin, dt, n, every, state, keeper, status)
      type(twin_t), intent(in) :: twin
      real(wp), intent(in) :: dt
      integer, intent(in) :: n, every
      type(state_t), intent(out) :: state
      type(row_keeper_t), intent(inout) :: keeper
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper
      type(run_summary_t) :: summary
      state = twin%problem%start
      call make_stepper(twin%problem%system, twin%settings, stepper, status)
      if (status%ok()) call integrate(twin%problem%system, stepper, state, &
                                      run_plan_t(time_step=dt, end_time=state%t + n*dt, every=int(every, long)), &
                                      keeper, summary, status)
   end subroutine run_library

   !> After n steps in calls of `length` steps the state is the library's to the last digit.
   subroutine compare(error, twin, dt, n, length)
      type(error_type), allocatable, intent(out) :: error
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
         if (allocated(error)) return
      end do
      call check_close(error, [t, q, p], [state%t, state%q, state%p], 0.0_wp)
   end subroutine compare

   subroutine box_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: isolv, iorder
      do isolv = 1, 2
         do iorder = 2, 8, 2
            call compare(error, twin_of(box(), isolv, iorder), 0.01_wp, 150, 150)
            if (allocated(error)) return
         end do
      end do
   end subroutine box_has_the_digits

   subroutine top_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: isolv, iorder
      do isolv = 1, 2
         do iorder = 2, 8, 2
            call compare(error, top_twin(isolv, iorder), 2e-3_wp, 100, 100)
            if (allocated(error)) return
         end do
      end do
   end subroutine top_has_the_digits

   subroutine forced_has_the_digits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: isolv, iorder
      do isolv = 1, 2
         do iorder = 2, 8, 2
            call compare(error, forced_twin(isolv, iorder), 0.013_wp, 100, 100)
            if (allocated(error)) return
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
      integer :: isolv, iorder
      do isolv = 1, 2
         do iorder = 2, 4, 2
            call compare(error, twin_of(box(), isolv, iorder), 0.01_wp, 150, 1)
            if (.not. allocated(error)) call compare(error, top_twin(isolv, iorder), 2e-3_wp, 100, 1)
            if (.not. allocated(error)) call compare(error, forced_twin(isolv, iorder), 0.013_wp, 100, 1)
            if (.not. allocated(error)) call compare(error, forced_twin(isolv, iorder), -0.013_wp, 100, 13)
            if (allocated(error)) return
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
      if (.not. allocated(error)) call check(error, nrows, 16)
      if (.not. allocated(error)) call check(error, keeper%n, 16)
      if (.not. allocated(error)) call check_close(error, reshape(rows(:, 1:16), [192]), &
                                                   reshape(keeper%rows(:, 1:16), [192]), 0.0_wp)
      if (.not. allocated(error)) call check_close(error, [t, q, p], [state%t, state%q, state%p], 0.0_wp)
      call nustat(istat, t, work, most, info)
      if (.not. allocated(error)) call check(error, istat(1) == 100 .and. istat(2) >= 1000 .and. istat(3) == 0)
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
         if (allocated(error)) return
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
      if (.not. allocated(error)) call check_close(error, [t(2), q(:, 2), p(:, 2)], [t(1), q(:, 1), p(:, 1)], 0.0_wp)
   end subroutine copy_goes_on

   !> What WORK remembers of another motion leaves no trace.
   subroutine changed_state_begins_anew(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), fresh(most), t(2), q(4, 2), p(4, 2)
      integer :: info, isolv
      do isolv = 1, 2
         twin = forced_twin(isolv, 2)
         call start(twin, work, most, t(1), q(:, 1), p(:, 1), info)
         call start(twin, fresh, most, t(2), q(:, 2), p(:, 2), info)
         call nustep(20, 0.01_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
         t(1) = t(2)
         q(:, 1) = q(:, 2)
         p(:, 1) = p(:, 2)
         call nustep(20, 0.013_wp, t(1), q(:, 1), p(:, 1), potspr, tormot, iuser, plain, work, most, info)
         call nustep(20, 0.013_wp, t(2), q(:, 2), p(:, 2), potspr, tormot, iuser, plain, fresh, most, info)
         call check_close(error, [t(2), q(:, 2), p(:, 2)], [t(1), q(:, 1), p(:, 1)], 0.0_wp)
         if (allocated(error)) return
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
      if (.not. allocated(error)) &
         call check_close(error, [t, q, p/10], [twin%problem%start%t, twin%problem%start%q, &
                                                twin%problem%start%p/10], 1e3_wp*eps)
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
      if (.not. allocated(error)) call check(error, abs(w) > 0.01_wp)
      if (.not. allocated(error)) call check_close(error, w, after(3) - before(3), 64*eps*abs(before(3)))
   end subroutine work_is_change_of_energy

   subroutine long_step_changes_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), copy(most), t, q(4), p(4), rows(12, 9)
      character(len=72) :: text
      integer :: info, isolv, nrows
      do isolv = 1, 2
         twin = top_twin(isolv, 2)
         call start(twin, work, most, t, q, p, info)
         copy = work
         call nustep(3, 1e3_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
         call check(error, info == 1 .or. info == 2, 'a step of 1000 s was taken')
         if (.not. allocated(error)) call check_close(error, [t, q, p, work], &
                                   [twin%problem%start%t, twin%problem%start%q, twin%problem%start%p, copy], 0.0_wp)
         if (allocated(error)) return
         call nutext(info, text)
         call check(error, len_trim(text) > 20 .and. index(text, 'cut into parts') > 0, text)
         if (allocated(error)) return
         call nurun(3, 1e3_wp, t, q, p, potspr, tormot, iuser, plain, 1, rows, 9, nrows, work, most, info)
         call check(error, info > 0 .and. nrows == 1)
         if (allocated(error)) return
      end do
   end subroutine long_step_changes_nothing

   subroutine callback_without_number_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), copy(most), t, q(4), p(4), ruser(7), e(3), al(3, 2), c(2), bad(2)
      integer :: info, isolv, i
      bad = [ieee_value(0.0_wp, ieee_quiet_nan), ieee_value(0.0_wp, ieee_positive_inf)]
      ruser = plain
      do isolv = 1, 2
         do i = 1, 2
            ruser(7) = bad(i)
            twin = forced_twin(isolv, 2*i)
            call start(twin, work, most, t, q, p, info)
            copy = work
            call nustep(20, 0.01_wp, t, q, p, potspr, tornan, iuser, ruser, work, most, info)
            call check(error, info, NUTATE_NOT_FINITE, 'torque')
            if (.not. allocated(error)) call check_close(error, [t, q, p, work], &
                                   [twin%problem%start%t, twin%problem%start%q, twin%problem%start%p, copy], 0.0_wp)
            if (allocated(error)) return
            call nustep(20, 0.01_wp, t, q, p, potnan, tormot, [3, i - 1], ruser, work, most, info)
            call check(error, info, NUTATE_NOT_FINITE, 'potential')
            if (allocated(error)) return
         end do
      end do
      call nuinv(q, p, potnan, [3, 0], ruser, e, al, c, work, most, info)
      call check(error, info, NUTATE_NOT_FINITE, 'energy')
   end subroutine callback_without_number_is_told

   !> The length that a query gives will do, one less will not, and nothing is touched beyond it.
   subroutine length_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin
      real(wp) :: work(most), t, q(4), p(4)
      integer :: info, isolv, iorder, n
      do isolv = 1, 2
         do iorder = 2, 8, 2
            twin = top_twin(isolv, iorder)
            call start(twin, work, -1, t, q, p, info)
            n = nint(work(1))
            call check(error, info == 0 .and. n > 100 .and. n < most)
            if (allocated(error)) return
            call start(twin, work, n - 1, t, q, p, info)
            call check(error, info, -12)
            if (allocated(error)) return
            call start(twin, work, n, t, q, p, info)
            work(n + 1:) = 7.0_wp
            call nustep(5, 2e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, n - 1, info)
            call check(error, info, -11)
            if (allocated(error)) return
            call nustep(5, 2e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, n, info)
            call check(error, info == 0 .and. all(work(n + 1:) == 7.0_wp))
            if (allocated(error)) return
         end do
      end do
   end subroutine length_is_told

   subroutine init_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      type(twin_t) :: twin, good
      integer, parameter :: expected(17) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 1, 1, 2, 7, 8, 10]
      real(wp) :: work(most), t, q(4), p(4), nan
      integer :: info, i
      nan = ieee_value(0.0_wp, ieee_quiet_nan)
      good = top_twin(1, 2)
      do i = 1, 17
         twin = good
         select case (i)
         case (1); twin%aj(2, 1) = nan
         case (2); twin%aj0 = nan
         case (3); twin%h(3) = nan
         case (4); twin%cm(1) = nan
         case (5); twin%g(2) = nan
         case (6); twin%d(3) = 1e200_wp
         case (7); twin%dn(1) = nan
         case (8); twin%isolv = 3
         case (9); twin%iorder = 3
         case (10); twin%icall = 4
         case (11); twin%aj(3, 3) = -1.0_wp
         case (12); twin%aj(1, 2) = 1.0_wp
         case (13); twin%aj = 0.0_wp
         case (14); twin%aj0 = 1e-200_wp
         case (15)
            twin%dn = 0.0_wp
            twin%icall = 1
         case (16); twin%isolv = 0
         case default; twin%icall = -1
         end select
         call start(twin, work, most, t, q, p, info)
         call check(error, -info, expected(i))
         if (.not. allocated(error)) call check(error, all(work == 0.0_wp), 'WORK was touched')
         if (allocated(error)) return
      end do
      call start(good, work, 0, t, q, p, info)
      call check(error, info, -12)
   end subroutine init_finds_wrong

   subroutine step_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: expected(12) = [1, 2, 2, 2, 3, 4, 4, 5, 5, 10, 11, 10]
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
         case default; lwork = -1
         end select
         before = work
         call nustep(n, dt, t, q, p, potspr, tormot, iuser, plain, work, lwork, info)
         call check(error, info, -expected(i))
         if (.not. allocated(error)) call check(error, all(transfer(work, n, 2*most) == transfer(before, n, 2*most)))
         if (allocated(error)) return
      end do
      call start(top_twin(1, 2), work, most, t, q, p, info)
      call nustep(0, 1e-3_wp, t, q, p, potspr, tormot, iuser, plain, work, most, info)
      call check(error, info, 0, 'no steps')
   end subroutine step_finds_wrong

   subroutine run_finds_wrong(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: expected(10) = [1, 2, 3, 4, 5, 10, 12, 14, 15, 0]
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
         case default; n = 9
         end select
         call nurun(n, dt, t, q, p, potspr, tormot, iuser, plain, k, rows, mrows, nrows, work, lwork, info)
         call check(error, info, -expected(i))
         if (.not. allocated(error)) call check(error, nrows, merge(4, 0, i == 10))
         if (allocated(error)) return
      end do
      call nustat(istat, w, work, 90, info)
      call check(error, info, -4)
      call nustat(istat, w, 0*work, most, info)
      if (.not. allocated(error)) call check(error, info, -3)
   end subroutine run_finds_wrong

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
         if (.not. allocated(error)) call check_close(error, omega, angular_velocity(system, state), 0.0_wp, 'OMEGA')
         call nuinv(q, p, potspr, iuser, plain, e, al, c, work, most, info)
         if (.not. allocated(error)) call check_close(error, [e(1), e(3), al(:, 1), al(:, 2)], &
             [kinetic_energy(system, state), total_energy(system, state), body_momentum(state), &
              space_momentum(state)], 0.0_wp)
         if (.not. allocated(error)) call check_close(error, [e(2), c], [e(3) - e(1), 1.0_wp, 0.0_wp], 16*eps)
      end associate
   end subroutine states_are_the_librarys

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

end module test_f77
