!> Indicators of chaos: against exact rates, the columns themselves, and the values of integrable and chaotic motions.
submodule(suites_of_effects) test_chaos
   use nutate_byte_archive, only: byte_archive_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_variation, only: variation_t
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_kinds, only: wp, pi
   use nutate_run, only: integrate, run_record_t, run_summary_t, run_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STOPPED
   use test_tangent_runs, only: sensitivity_recorder_t
   use test_support, only: check, check_below, check_close, draws_fewer, error_type, in_turn, new_unittest, &
      one_in, test_failed
   implicit none

   character, parameter :: lf = achar(10)
   character(len=*), parameter :: field = "&dipole field = 0, 0, -1, moment ="
   character(len=*), parameter :: attitude = "&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity ="
   character(len=*), parameter :: top_a = "&body inertia = 3, 2, 1 /"//lf//attitude//" 0.4, -0.3, 0.5 /"//lf// &
                                  field//" 1, 0.3, 0.5 /"//lf
   character(len=*), parameter :: lagrange = "&body inertia = 1, 1, 0.5 /"//lf//attitude//" 0.4, -0.3, 2 /"//lf// &
                                  field//" 0, 0, 1 /"//lf
   character(len=*), parameter :: hyperion = "&body inertia = 0.5, 0.764033333333333, 1 /"//lf// &
                                  "&initial angular_velocity = 0, 0, 1 /"//lf// &
                                  "&orbit semi_major_axis = 1, mu = 1, eccentricity = 0.1 /"//lf// &
                                  "&gravity_gradient /"//lf

   !> Logarithms of the length of the first column at each step.
   type, extends(sensitivity_recorder_t) :: length_recorder_t
      integer :: rows = 0
      real(wp) :: scale = 1.0_wp
      real(wp) :: time(2001) = 0.0_wp, length(2001) = 0.0_wp
   contains
      procedure :: observe => record_length
   end type length_recorder_t

contains

   module procedure collect_chaos
      testsuite = [ &
                  new_unittest("the exponent of the unstable axis is the exact rate", test_unstable_axis), &
                  new_unittest("six exponents come in pairs and have the sum zero", test_spectrum), &
                  new_unittest("exponents of long runs come in pairs with every method", test_long_runs), &
                  new_unittest("indicators are those of a column without normalisation", test_direct), &
                  new_unittest("the growth in the plane of Hyperion is that of the reference", test_plane), &
                  new_unittest("the mean MEGNO of regular motions is 2", test_regular), &
                  new_unittest("Hyperion has the exponent of the reference", test_hyperion), &
                  new_unittest("a damped body has the rates of its decay", test_decay), &
                  new_unittest("the summary of a run in one call has them", test_integrate), &
                  new_unittest("checkpoints hold the indicators", test_resume), &
                  new_unittest("the sense of time does not matter to a sign", test_backward)]
   end procedure collect_chaos

   !> Begins the run of a scene.
   subroutine begin(text, scene, run, error)
      character(len=*), intent(in) :: text
      type(scene_t), intent(inout) :: scene
      type(run_t), intent(inout) :: run
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(text, 'chaos.nml', scene, status, message)
      if (.not. status%ok()) then
         call test_failed(error, message)
         return
      end if
      call run%begin(scene%system, scene%integrator, scene%initial, scene%plan, status)
      if (status%ok()) call run%set_events(scene%events, scene%system, status)
      if (status%ok()) call run%follow_chaos(scene%chaos, scene%system, status)
      call check(error, status%ok(), trim(status%message))
   end subroutine begin

   !> Runs a scene to its end.
   subroutine go(text, run, error)
      character(len=*), intent(in) :: text
      type(run_t), intent(inout) :: run
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      allocate (scene)
      call begin(text, scene, run, error)
      if (allocated(error)) return
      call run%run_to_end(scene%system, status)
      call check(error, status%ok(), trim(status%message))
   end subroutine go

   !> A body that spins about its middle axis: λ = Ω √((J2 - J3)(J3 - J1)/(J1 J2)) = 6/s, the first row of an exact
   !> solution: after the columns have rotated in, between two times, nothing but the error of the steps is left.
   subroutine test_unstable_axis(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(run_t), allocatable :: run
      type(status_t) :: status
      real(wp) :: before(6), rates(6)
      allocate (run, scene)
      call begin("&body inertia = 5, 20, 17 /&initial angular_velocity = 0, 0, 10 /"// &
                 "&integrator formulation = 'reduced', order = 8, time_step = 0.01, end_time = 20 /"// &
                 "&chaos exponents = 6, every = 4 /", scene, run, error)
      if (allocated(error)) return
      call run%run_to(scene%system, 10.0_wp, status)
      call check(error, status%ok(), trim(status%message))
      before = run%summary%chaos%lyapunov()
      call run%run_to(scene%system, 20.0_wp, status)
      call check(error, status%ok(), trim(status%message))
      rates = 2*run%summary%chaos%lyapunov() - before
      call check_close(error, rates(1), 6.0_wp, 1e-9_wp, 'largest')
      call check_close(error, rates(6), -6.0_wp, 1e-9_wp, 'smallest')
      ! The rotation about the axis grows linearly: ln 2 from 10 s to 20 s, and its pair falls.
      call check_below(error, maxval(abs(rates(2:5))), 0.2_wp, 'others')
      call check_below(error, abs(sum(rates)), 1e-10_wp, 'sum')
   end subroutine test_unstable_axis

   !> The chaotic top: the sum follows the volume, which steps of order 8 keep to 1e-13 each; the pairs differ by what a
   !> finite time leaves, some units over t.
   subroutine test_spectrum(error)
      type(error_type), allocatable, intent(out) :: error
      class(run_t), allocatable :: run
      real(wp) :: rates(6), duration
      integer :: i
      character(len=8) :: digits
      allocate (run)
      duration = merge(500.0_wp, 2e4_wp, draws_fewer())
      write (digits, '(i0)') nint(duration)
      call go(top_a//"&integrator formulation = 'reduced', order = 8, time_step = 0.1, end_time = "//trim(digits)// &
              " /&chaos exponents = 6, every = 10 /", run, error)
      if (allocated(error)) return
      rates = run%summary%chaos%lyapunov()
      call check_close(error, rates(1), 0.1488_wp, merge(0.05_wp, 0.015_wp, draws_fewer()), 'largest')
      call check_below(error, abs(sum(rates)), 1e-11_wp, 'sum')
      do i = 1, 3
         call check_below(error, abs(rates(i) + rates(7 - i)), 20/duration, 'pair')
      end do
      call check_below(error, maxval(abs(rates(2:5))), 20/duration, 'zeros')
   end subroutine test_spectrum

   !> Chaotic tops, over e-foldings in which round-off of the start would grow by a hundred orders of magnitude.
   subroutine test_long_runs(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: methods(4) = [character(len=36) :: "'rk8'", "'dop853'", "'taylor'", &
         "'nielsen_krenk', order = 8"]
      class(run_t), allocatable :: run
      real(wp) :: rates(6), duration
      integer :: tops, i, k, m
      character(len=40) :: numbers, end_time
      tops = merge(1, 10, draws_fewer())
      duration = merge(merge(2e3_wp, 1e4_wp, one_in() > 3), 1e5_wp, draws_fewer())
      write (end_time, '(es9.1)') duration
      allocate (run)
      do i = 1, tops
         do m = 1, size(methods)
            if (.not. in_turn(m - 1)) cycle
            write (numbers, '(f4.2,", 0.1, 0.4, force = 1, ",f4.2,", -1")') 0.18_wp + 0.02_wp*i, 2.1_wp - 0.1_wp*i
            call go("&body inertia = 2, 1.5, 1 /"//lf//attitude//" 0.4, -0.3, 2 /"//lf// &
                    "&force axes = 'space', body_point = "//numbers//" /"//lf//"&integrator method = "// &
                    trim(methods(m))//", time_step = 0.1, end_time = "//trim(end_time)// &
                    " /&chaos exponents = 6, every = 5 /", run, error)
            if (allocated(error)) return
            rates = run%summary%chaos%lyapunov()
            call check(error, rates(1)*duration > merge(140, 700, one_in() > 3), 'the top is not chaotic')
            do k = 1, 3
               call check_below(error, abs(rates(k) + rates(7 - k)), 1e-3_wp, trim(methods(m))//': pair')
            end do
         end do
      end do
   end subroutine test_long_runs

   subroutine record_length(self, system, state, record, status)
      class(length_recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (self%rows == size(self%time)) return
      self%rows = self%rows + 1
      self%time(self%rows) = state%t
      self%length(self%rows) = log(norm2([self%tangent%theta(1, :), self%tangent%momentum(1, :)/self%scale]))
   end subroutine record_length

   !> Growth, MEGNO and FLI from the rows of a column that nothing normalises: the same to round-off of 1e3 steps, with
   !> a column that grows by e^17.
   subroutine test_direct(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: steps(3) = [character(len=110) :: &
         "&integrator formulation = 'reduced', order = 4, time_step = 0.1, end_time = 100 /", &
         "&integrator method = 'rk8', conserve = .true., time_step = 0.1, end_time = 100 /", &
         "&integrator method = 'nielsen_krenk', order = 4, conserve = .true., time_step = 0.1, end_time = 100 /"]
      real(wp), parameter :: vector(6) = [0.0_wp, 1.0_wp, -2.0_wp, 0.5_wp, 0.0_wp, 1.0_wp]
      integer :: i
      do i = 1, size(steps)
         call compare_direct(top_a//trim(steps(i)), vector, error)
      end do
      ! Samples at switches are others; the growth is not.
      call compare_direct("&body inertia = 3, 2, 1 /"//attitude//" 0.4, -0.3, 0.5 /"// &
                          "&dipole name = 'magnet', field = 0, 0, -1, moment = 1, 0.3, 0.5 /"// &
                          "&event when = 'q1', crosses = 0, switch = 'magnet toggle' /"// &
                          trim(steps(1)), vector, error, switches=.true.)
   end subroutine test_direct

   subroutine compare_direct(text, vector, error, switches)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: vector(6)
      type(error_type), allocatable, intent(inout) :: error
      !> Events switch effects.
      logical, intent(in), optional :: switches
      class(scene_t), allocatable :: scene
      class(run_t), allocatable :: run, direct
      type(status_t) :: status
      type(length_recorder_t) :: recorder
      type(variation_t) :: column
      real(wp) :: x(6), weighted, area, dt
      integer :: k
      allocate (run, direct, scene)
      call begin(text//"&chaos vector = 0, 1, -2, 0.5, 0, 1 /", scene, run, error)
      if (allocated(error)) return
      call run%run_to_end(scene%system, status)
      recorder%wants_tangent = .true.
      recorder%scale = norm2(body_momentum(scene%initial))
      x = vector/norm2(vector)
      column%attitude = x(:3)
      column%angular_velocity = matmul(scene%system%body%inverse_inertia, recorder%scale*x(4:))
      call direct%begin(scene%system, scene%integrator, scene%initial, scene%plan, status)
      if (status%ok()) call direct%set_events(scene%events, scene%system, status)
      if (status%ok()) call direct%differentiate([column], scene%system, status)
      if (status%ok()) call direct%run_to_end(scene%system, status, recorder)
      call check(error, status%ok(), trim(status%message))
      weighted = 0.0_wp
      area = 0.0_wp
      associate (t => recorder%time, length => recorder%length, n => recorder%rows)
         do k = 2, n
            dt = t(k) - t(k - 1)
            weighted = weighted + (t(k) - 0.5_wp*dt)*(length(k) - length(k - 1))
            area = area + 2*weighted/t(k)*dt
         end do
         call check(error, n, 1001, 'rows')
         call check(error, all(abs(run%state%q - direct%state%q) <= 0.0_wp), 'the states differ')
         call check_close(error, run%summary%chaos%lyapunov(), [length(n)/t(n)], &
                          merge(1e-9_wp, 1e-11_wp, present(switches)), 'exponent')
         if (present(switches)) then
            call check(error, run%events%watched(1)%number > 3, 'there are no switches')
            return
         end if
         call check_close(error, run%summary%chaos%megno(), area/t(n), 1e-9_wp, 'megno')
         call check_close(error, run%summary%chaos%fli(), maxval(length(2:n)), 1e-9_wp, 'fli')
         call check(error, run%summary%chaos%fli() > 10.0_wp, 'the motion is not chaotic')
      end associate
   end subroutine compare_direct

   !> The block of the reference in the plane, at t = 20π.
   subroutine test_plane(error)
      type(error_type), allocatable, intent(out) :: error
      class(run_t), allocatable :: run
      real(wp), parameter :: block(2, 2) = reshape([1.97133441322189_wp, -14.6968289014612_wp, &
                                                    -3.47435450653777_wp, 26.4095190427470_wp], [2, 2])
      real(wp) :: rates(1)
      allocate (run)
      call go(hyperion//"&integrator method = 'rk8', time_step = 0.0628318530717958648, "// &
              "end_time = 62.8318530717958648 /"// &
              "&chaos vector = 0, 0, 1, 0, 0, 1, momentum_scale = 1, every = 8 /", run, error)
      if (allocated(error)) return
      rates = run%summary%chaos%lyapunov()
      call check_close(error, rates(1)*20*pi, log(norm2(matmul(block, [1.0_wp, 1.0_wp]))/sqrt(2.0_wp)), 1e-9_wp, &
                       'growth')
      call check_close(error, run%summary%chaos%time, 20*pi, 1e-12_wp, 'time')
   end subroutine test_plane

   !> Integrable motions: |λ| falls as ln t/t, the mean MEGNO goes to 2; its values at 1e4 s are those of the reference.
   subroutine test_regular(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: tangent = "&chaos vector = 1, 0.5, -0.3, 0.7, -0.2, 0.4 /", &
         long = " end_time = 1e4 /"//tangent
      call expect_regular(lagrange//"&integrator formulation = 'reduced', order = 4, time_step = 0.1, "// &
                          "end_time = 1000 /"//tangent, 1.2e-2_wp, 2.0_wp, 0.05_wp, 'Lagrange, short', error)
      if (draws_fewer()) return
      call expect_regular(lagrange//"&integrator formulation = 'reduced', order = 4, time_step = 0.1,"//long, &
                          1.1e-3_wp, 2.003_wp, 0.02_wp, 'Lagrange', error)
      call expect_regular("&body inertia = 2, 2, 1 /"//attitude//" 0.4, -0.3, 1.2 /"//field//" 1, 0, 0 /"// &
                          "&integrator formulation = 'reduced', order = 4, time_step = 0.1,"//long, 1.1e-3_wp, &
                          1.984_wp, 0.02_wp, 'Kovalevskaya', error)
      call expect_regular("&body inertia = 4, 4, 1 /"//attitude//" 0.4, -0.3, -1.9555555555555555 /"// &
                          field//" 1, 0, 0 /"// &
                          "&integrator formulation = 'reduced', order = 4, time_step = 0.1,"//long, 1.1e-3_wp, &
                          2.007_wp, 0.02_wp, 'Goryachev-Chaplygin', error)
      call expect_regular("&body inertia = 5, 20, 17 /&initial angular_velocity = 3, 1, 5 /"// &
                          "&integrator formulation = 'reduced', order = 4, time_step = 0.02,"//long, 1.1e-3_wp, &
                          1.999_wp, 0.02_wp, 'free body', error)
   end subroutine test_regular

   subroutine expect_regular(text, rate, megno, off, name, error)
      character(len=*), intent(in) :: text, name
      !> Bound of the exponent, 1/s; mean MEGNO and how far it may be off.
      real(wp), intent(in) :: rate, megno, off
      type(error_type), allocatable, intent(inout) :: error
      class(run_t), allocatable :: run
      allocate (run)
      call go(text, run, error)
      if (allocated(error)) return
      call check_below(error, maxval(abs(run%summary%chaos%lyapunov())), rate, name//': exponent')
      call check_close(error, run%summary%chaos%megno(), megno, off, name//': megno')
   end subroutine expect_regular

   !> 0.119 ± 0.0015 n in the plane; 1e4 revolutions scatter by 0.005, 300 by 0.02.
   subroutine test_hyperion(error)
      type(error_type), allocatable, intent(out) :: error
      class(run_t), allocatable :: run
      real(wp) :: rates(1)
      character(len=*), parameter :: plane = "&chaos vector = 0, 0, 1, 0, 0, 1 /"
      allocate (run)
      if (draws_fewer()) then
         call go(hyperion//"&integrator method = 'rk8', time_step = 0.25, end_time = 1885 /"//plane, run, error)
      else
         call go(hyperion//"&integrator method = 'rk8', time_step = 0.125, end_time = 62832 /"//plane, run, error)
      end if
      if (allocated(error)) return
      rates = run%summary%chaos%lyapunov()
      call check_close(error, rates(1), 0.119_wp, merge(0.04_wp, 0.01_wp, draws_fewer()), 'exponent')
      ! In a chaotic motion Y grows as λt, its mean as λt/2.
      call check_close(error, run%summary%chaos%megno()/run%summary%chaos%time, 0.5_wp*rates(1), 0.1_wp*rates(1), &
                       'slope of megno')
   end subroutine test_hyperion

   !> A damped sphere: δL falls with c/J, the attitude stays.
   subroutine test_decay(error)
      type(error_type), allocatable, intent(out) :: error
      class(run_t), allocatable :: run
      real(wp) :: rates(6)
      allocate (run)
      call go("&body inertia = 2, 2, 2 /&initial angular_velocity = 0.1, 0.2, 0.3 /&damping coefficient = 1, 1, 1 /"// &
              "&integrator order = 4, time_step = 0.05, end_time = 40 /&chaos exponents = 6 /", run, error)
      if (allocated(error)) return
      rates = run%summary%chaos%lyapunov()
      call check_close(error, sum(rates), -1.5_wp, 1e-5_wp, 'sum of a damped body: -c/J for each axis')
      call check_close(error, rates(4:6), [-0.5_wp, -0.5_wp, -0.5_wp], 0.1_wp, 'damped')
      call check_close(error, rates(1:3), [0.0_wp, 0.0_wp, 0.0_wp], 0.1_wp, 'attitude')
   end subroutine test_decay

   !> The indicators of a run in one call, by its arguments, and of one without.
   subroutine test_integrate(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(run_t), allocatable :: run, other
      type(state_t) :: state
      type(run_summary_t) :: summary, plain
      type(status_t) :: status
      allocate (run, other, scene)
      call go(top_a//"&integrator formulation = 'reduced', time_step = 0.05, end_time = 20 /&chaos exponents = 6 /", &
              run, error)
      if (allocated(error)) return
      call begin(top_a//"&integrator formulation = 'reduced', time_step = 0.05, end_time = 20 /", scene, other, error)
      state = scene%initial
      call integrate(scene%system, scene%integrator, state, scene%plan, status, summary=summary, &
                     chaos=chaos_settings_t(exponents=6))
      call check(error, status%ok(), trim(status%message))
      if (.not. allocated(summary%chaos)) call test_failed(error, 'no indicators')
      if (allocated(error)) return
      call check(error, all(abs(summary%chaos%lyapunov() - run%summary%chaos%lyapunov()) <= 0.0_wp), 'exponents differ')
      call check(error, abs(summary%chaos%fli() - run%summary%chaos%fli()) <= 0.0_wp, 'fli differs')
      state = scene%initial
      call integrate(scene%system, scene%integrator, state, scene%plan, status, summary=plain)
      call check(error, .not. allocated(plain%chaos), 'indicators that nothing asks for')
   end subroutine test_integrate

   !> A run that was interrupted ends with the same bits.
   subroutine test_resume(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: text = top_a//"&integrator formulation = 'reduced', time_step = 0.01, "// &
         "end_time = 60 /&chaos exponents = 6, every = 7 /"
      class(scene_t), allocatable :: scene
      class(run_t), allocatable :: whole, first, second
      type(length_recorder_t) :: recorder
      type(byte_archive_t) :: archive
      type(status_t) :: status
      allocate (whole, first, second, scene)
      call go(text, whole, error)
      call begin(text, scene, first, error)
      if (allocated(error)) return
      recorder%wants_tangent = .true.
      recorder%stops_at = 3
      call first%run_to_end(scene%system, status, recorder)
      call check(error, status%code, NUTATE_STOPPED, trim(status%message))
      if (.not. allocated(recorder%archive)) call test_failed(error, 'no checkpoint')
      if (allocated(error)) return
      call begin(text, scene, second, error)
      call archive%begin_reading(recorder%archive)
      call second%resume(archive, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, all(abs(second%summary%chaos%lyapunov() - first%summary%chaos%lyapunov()) <= 0.0_wp), &
                 'taken up otherwise')
      call second%run_to_end(scene%system, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, all(abs(second%summary%chaos%lyapunov() - whole%summary%chaos%lyapunov()) <= 0.0_wp), &
                 'exponents differ')
      call check(error, abs(second%summary%chaos%megno() - whole%summary%chaos%megno()) <= 0.0_wp, 'megno differs')
      call check(error, abs(second%summary%chaos%fli() - whole%summary%chaos%fli()) <= 0.0_wp, 'fli differs')
   end subroutine test_resume

   !> Backward the damped sphere grows.
   subroutine test_backward(error)
      type(error_type), allocatable, intent(out) :: error
      class(run_t), allocatable :: run
      allocate (run)
      call go("&body inertia = 2, 2, 2 /&initial angular_velocity = 0.1, 0.2, 0.3 /&damping coefficient = 1, 1, 1 /"// &
              "&integrator order = 4, time_step = -0.05, end_time = -20 /&chaos /", run, error)
      if (allocated(error)) return
      call check_close(error, run%summary%chaos%lyapunov(), [0.5_wp], 0.1_wp, 'exponent')
      call check_close(error, run%summary%chaos%time, 20.0_wp, 1e-12_wp, 'time')
   end subroutine test_backward

end submodule test_chaos
