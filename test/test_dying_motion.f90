!> An accuracy is kept where friction and damping let the motion die out, or a part of it: there the energy that is left
!> is far below what the works may err by.
!>
!> `make test` runs the first cases and some that went wrong before, `make accuracy` all of them.
module test_dying_motion
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: eps, long, wp
   use nutate_method_choice, only: AUTOMATIC_METHOD, choose_method
   use nutate_methods, only: default_settings
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_STEP_LIMIT, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_problems, only: make_state, new_problem, new_system, problem_t, system_t
   use test_random_scenes, only: make_random_body, power_of_ten
   use test_support, only: check, check_below, error_type, new_unittest, random_unit, random_unit_quaternion, &
                           random_vector, share_of, skip_test, unittest_type
   implicit none
   private

   public :: collect_dying_motion, report_dying_motion

   !> The first two keep the accuracy without exception; of the others the bounds are those of `make accuracy`.
   character(len=6), parameter :: methods(4) = [character(len=6) :: 'taylor', 'auto', 'dop853', 'rk8']
   integer, parameter :: keeping = 2
   !> Cases in `make stress`, a third of them, and those of `make accuracy`; each is run by one method after the other.
   integer, parameter :: short = 60, all_cases = 500
   !> Error of a step of the oracle: far below all accuracies that are asked for.
   real(qp), parameter :: oracle_tolerance = 1e-20_qp
   integer(long), parameter :: most_steps = 300000_long

   !> A motion that dies out.
   type :: dying_t
      type(problem_t) :: problem
      !> End time, s.
      real(wp) :: end_time = 0.0_wp
      !> Requested accuracy, rad.
      real(wp) :: asked = 0.0_wp
      character(len=96) :: text = ''
   end type dying_t

   !> Results of the runs.
   type :: tally_t
      !> Counts. Misses: errors above the requested and the reported ones, of methods that promise the accuracy. Above 2
      !> and 10: errors above twice and ten times these, of the other methods.
      integer :: runs = 0, misses = 0, failed = 0, said_more = 0, above_2 = 0, above_10 = 0
      !> Largest true error of any run over the larger of the requested and the reported one.
      real(wp) :: worst = 0.0_wp
      !> The first run that missed.
      character(len=200) :: first = ''
   end type tally_t

contains

   subroutine collect_dying_motion(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a body that damping stops keeps its accuracy", damped_body), &
                  new_unittest("a damped body that a dipole moves holds the tolerance", driven_body), &
                  new_unittest("a wheel that friction stops has the closed form", stopping_wheel), &
                  new_unittest("a driven wheel beside one that stops", driven_wheel), &
                  new_unittest("random motions that die out keep their accuracy", random_motions)]
   end subroutine collect_dying_motion

   !> The body of which `taylor` said 8.9e-6 rad, and was off by 1.1e-3.
   subroutine damped_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(dying_t) :: item
      type(tally_t) :: tally
      type(status_t) :: status
      integer :: exponent
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      call make_body(diagonal([1.0_wp, 2.0_wp, 2.2_wp]), item%problem%system%body, status)
      call item%problem%system%effects%add(damping_t([2.0_wp, 3.8_wp, 6.0_wp]))
      item%problem%start = make_state(item%problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.2_wp, 0.3_wp])
      item%end_time = 20.0_wp
      do exponent = 3, 10
         item%asked = 10.0_wp**(-exponent)
         call assess(item, 'damped body', tally)
      end do
      call check(error, is_kept(tally) .and. tally%worst <= 1.0_wp, trim(tally%first))
   end subroutine damped_body

   !> Damping stops the start in some 1e-5 s, then a dipole moves the body slowly. The first unit of time is a thousand
   !> times too long: terms of its end made |L|, to which errors of the first step are relative, 1e7 times too large.
   subroutine driven_body(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: tolerances(5) = [1e-13_wp, 1e-5_wp, 1e-6_wp, 1e-7_wp, 1e-8_wp]
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(state_t) :: states(size(tolerances))
      type(status_t) :: status
      character(len=40) :: label
      integer :: i
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.5_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(damping_t([1.7e5_wp, 1.4e5_wp, 4e4_wp]))
      call problem%system%effects%add(dipole_t([0.1_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.5_wp, 0.0_wp]))
      settings = default_settings('taylor')
      states = make_state(problem%system, [0.8_wp, 0.6_wp, 0.0_wp, 0.0_wp], [1.0_wp, -8.0_wp, 3.0_wp])
      do i = 1, size(tolerances)
         call integrate(problem%system, settings, states(i), run_plan_t( &
                        goal=run_goal_t(local_tolerance=tolerances(i)), end_time=1.8_wp), status)
         write (label, '("tolerance ",es7.1)') tolerances(i)
         call check(error, status%ok(), trim(status%message))
         if (i > 1) call check_below(error, attitude_distance(states(i)%q, states(1)%q), tolerances(i), trim(label))
      end do
   end subroutine driven_body

   !> A wheel on the axis about which the body turns: friction takes ω = ω₀ exp(-ct(1/Jw + 1/Jr)), and the body turns by
   !> Ω₀t + ω₀(Jw/(Jw + Jr))(t - (1 - exp(-kt))/k). In chosen steps of 1e-9 rad, at rates k of 10 and 1e4 per second.
   subroutine stopping_wheel(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp], inertia = 0.1_wp, moment = 2.0_wp, speed = 20.0_wp, &
                             duration = 2.0_wp, rates(3) = [10.0_wp, 100.0_wp, 1e4_wp], tolerance = 1e-9_wp
      character(len=6), parameter :: explicit(3) = [character(len=6) :: 'taylor', 'dop853', 'rk8']
      type(system_t), pointer :: empty
      type(system_t) :: system
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      real(wp) :: k, angle, off
      character(len=80) :: label
      integer :: i, j
      empty => new_system()
      do i = 1, size(rates)
         system = empty
         call make_body(diagonal([3.0_wp, 4.0_wp, moment + inertia]), system%body, status)
         call add_wheel(system, wheel_t(name='wheel', axis=axis, inertia=inertia, speed=speed, &
                                        friction=rates(i)*inertia), status)
         k = rates(i)*inertia*(1/inertia + 1/moment)
         angle = 0.03_wp*duration + speed*(inertia/(inertia + moment))*(duration - (1 - exp(-k*duration))/k)
         do j = 1, size(explicit)
            settings = default_settings(trim(explicit(j)))
            settings%conserve = .true.
            state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 0.03_wp*axis)
            call integrate(system, settings, state, run_plan_t(goal=run_goal_t(local_tolerance=tolerance), &
                                                               end_time=duration, max_steps=most_steps), status)
            off = abs(2*(cos(0.5_wp*angle)*state%q(4) - sin(0.5_wp*angle)*state%q(1)))
            write (label, '(a,", ",es7.1," per second, error ",es8.1)') trim(explicit(j)), rates(i), off
            call check(error, status%ok() .and. off <= tolerance, trim(label)//' '//trim(status%message))
         end do
      end do
   end subroutine stopping_wheel

   !> A motor winds one wheel up to h = 97 N m s while friction stops another: over 12 800 steps the attitude is as good
   !> as rounding of h allows, √n ½ε h/J in Ω, for half the time. The like increments of h round alike: without
   !> the digits that its sum cannot hold it is off by 1.3e-10.
   subroutine driven_wheel(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=6), parameter :: explicit(3) = [character(len=6) :: 'taylor', 'dop853', 'rk8']
      integer, parameter :: steps = 12800
      real(wp), parameter :: end_time = 64.0_wp, &
                             bound = sqrt(12800.0_wp)*0.5_wp*eps*97.0_wp/4.0_wp*0.5_wp*end_time
      type(problem_t), pointer :: problem
      type(wheel_t) :: wheel
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      real(qp) :: q(4)
      character(len=80) :: label
      integer :: i
      problem => new_problem()
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), problem%system%body, status)
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp, speed=5.0_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp]))
      call add_wheel(problem%system, wheel, status)
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, &
                                             speed=-20.0_wp, friction=0.15_wp), status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -0.5_wp, 1.5_wp])
      call find_true_attitude(problem%system, problem%start, end_time, q, oracle_tolerance)
      do i = 1, size(explicit)
         settings = default_settings(trim(explicit(i)))
         settings%conserve = .true.
         state = problem%start
         call integrate(problem%system, settings, state, &
                        run_plan_t(time_step=end_time/steps, end_time=end_time), status)
         write (label, '(a,", error ",es8.1)') trim(explicit(i)), true_distance(q, state%q)
         call check(error, status%ok() .and. true_distance(q, state%q) <= bound, trim(label)//' '//trim(status%message))
      end do
   end subroutine driven_wheel

   !> The first cases of `make accuracy`.
   subroutine random_motions(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      call run_cases(1, share_of(short), tally)
      call check(error, is_kept(tally), verdict(tally))
      call check(error, 10*tally%said_more <= tally%runs, verdict(tally))
   end subroutine random_motions

   !> Runs all cases; or one, or those from one to another. Runs that missed are written to standard error.
   subroutine report_dying_motion(first, last, passed)
      !> Numbers of the first and the last case; both 0: all.
      integer, intent(in) :: first, last
      logical, intent(out) :: passed
      type(tally_t) :: tally
      passed = .true.
      if (.not. has_oracle) return
      call run_cases(max(first, 1), merge(last, all_cases, first > 0), tally, loud=.true.)
      call write_table(tally)
      passed = is_kept(tally)
   end subroutine report_dying_motion

   !> No miss, no error above ten times what was asked for or said, one in 200 above twice.
   pure logical function is_kept(tally)
      type(tally_t), intent(in) :: tally
      is_kept = tally%misses + tally%failed + tally%above_10 == 0 .and. 200*tally%above_2 <= tally%runs
   end function is_kept

   function verdict(tally) result(text)
      type(tally_t), intent(in) :: tally
      character(len=:), allocatable :: text
      character(len=400) :: line
      write (line, '(6(i0,a),es7.1,2a)') tally%runs, ' runs of motions that decay: ', tally%misses, &
         ' missed by `taylor` and `auto`; ', tally%above_2, ' above twice the estimate, ', tally%above_10, &
         ' above ten times by `dop853` and `rk8`; ', tally%failed, ' failed, ', tally%said_more, &
         ' out of reach; largest ', tally%worst, ' ', trim(tally%first)
      text = trim(line)
   end function verdict

   !> Writes the part of docs/results/accuracy-costs.md.
   subroutine write_table(tally)
      type(tally_t), intent(in) :: tally
      write (output_unit, '(a,/,a)') '| decaying motions | number |', '|---|---|'
      write (output_unit, '("| ",a," | ",i0," |")') 'runs', tally%runs, '`taylor`, `auto`: h > 1', tally%misses, &
         '`dop853`, `rk8`: h > 2', tally%above_2, 'h > 10', tally%above_10, 'failed', tally%failed, &
         'estimate above the accuracy', tally%said_more
      write (output_unit, '("| largest h | ",es7.1," |")') tally%worst
      if (tally%first /= '') write (output_unit, '(/,3a)') 'First run with h > 1: ', trim(tally%first), '.'
   end subroutine write_table

   !> Runs cases of consecutive numbers.
   subroutine run_cases(first, last, tally, loud)
      integer, intent(in) :: first, last
      type(tally_t), intent(out) :: tally
      !> Says what missed.
      logical, intent(in), optional :: loud
      type(dying_t) :: item
      character(len=40) :: label
      integer :: number, misses
      do number = first, last
         call draw(number, item)
         write (label, '("case ",i0)') number
         misses = tally%misses + tally%failed
         call assess(item, trim(label), tally, loud)
      end do
   end subroutine run_cases

   !> Runs a case by all methods.
   subroutine assess(item, label, tally, loud)
      type(dying_t), intent(in) :: item
      character(len=*), intent(in) :: label
      type(tally_t), intent(inout) :: tally
      logical, intent(in), optional :: loud
      type(integrator_settings_t) :: settings
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: reason
      character(len=200) :: line
      character(len=60) :: again
      real(qp) :: exact(4)
      real(wp) :: off, miss
      logical :: wrong
      integer :: i
      call find_true_attitude(item%problem%system, item%problem%start, item%end_time, exact, oracle_tolerance)
      do i = 1, size(methods)
         settings = default_settings(trim(methods(i)))
         if (methods(i) == AUTOMATIC_METHOD) then
            call choose_method(item%problem%system, item%problem%start, item%end_time, item%asked, settings, reason)
         else
            settings%conserve = .true.
         end if
         state = item%problem%start
         call integrate(item%problem%system, settings, state, run_plan_t( &
                        goal=run_goal_t(accuracy=item%asked), end_time=item%end_time, max_steps=most_steps), status, &
                        summary=summary)
         if (status%code == NUTATE_STEP_LIMIT) cycle
         off = true_distance(exact, state%q)
         miss = off/max(item%asked, summary%estimate)
         tally%runs = tally%runs + 1
         wrong = .not. (miss <= 1.0_wp .and. status%ok())
         if (.not. status%ok()) tally%failed = tally%failed + 1
         if (i <= keeping) then
            if (.not. miss <= 1.0_wp) tally%misses = tally%misses + 1
         else
            if (.not. miss <= 2.0_wp) tally%above_2 = tally%above_2 + 1
            if (.not. miss <= 10.0_wp) tally%above_10 = tally%above_10 + 1
         end if
         if (summary%estimate > item%asked) tally%said_more = tally%said_more + 1
         tally%worst = max(tally%worst, miss)
         if (.not. wrong) cycle
         write (line, '(3a,3(a,es8.1),4a)') label, ', ', trim(methods(i)), ': requested ', item%asked, &
            ', estimated ', summary%estimate, ', actual ', off, '; ', trim(item%text), ' ', trim(status%message)
         again = ''
         if (index(label, 'case ') == 1) again = '; again: tools/docs/accuracy.sh dying '//label(6:)
         if (tally%first == '') tally%first = line
         if (present(loud)) write (error_unit, '(3a)') trim(line), ' ', trim(again)
      end do
   end subroutine assess

   !> The case of a number: damping of rates that differ by up to ten between axes, with or without a weight, or wheels
   !> with friction, one of them beside a driven one. The slowest of it takes 1 to 300 times its own time in the run.
   subroutine draw(number, item)
      integer, intent(in) :: number
      type(dying_t), intent(inout) :: item
      type(body_t) :: body
      integer(int64) :: seed
      real(wp) :: inertia, rate, decay, chance
      integer :: i
      item = dying_t()
      seed = 15485863_int64*number + 32452843_int64
      do i = 1, 20
         chance = random_unit(seed)
      end do
      inertia = power_of_ten(seed, -3.0_wp, 3.0_wp)
      rate = power_of_ten(seed, -1.0_wp, 1.0_wp)
      item%end_time = power_of_ten(seed, 0.3_wp, 2.0_wp)/rate
      decay = power_of_ten(seed, 0.0_wp, 2.5_wp)/item%end_time
      item%asked = power_of_ten(seed, -10.0_wp, -3.0_wp)
      call make_random_body(seed, inertia, body, item%text)
      item%problem%system%body = body
      chance = random_unit(seed)
      if (chance < 0.7_wp) call add_damping(seed, decay, item)
      if (chance < 0.2_wp) call item%problem%system%effects%add(gravity_t(body, (rate**2*power_of_ten( &
                                                     seed, -1.0_wp, 1.0_wp))*random_vector(seed)))
      if (chance < 0.2_wp) item%text = trim(item%text)//', gravity'
      if (chance > 0.6_wp) call add_wheels(seed, rate, decay, item)
      item%problem%start = make_state(item%problem%system, random_unit_quaternion(seed), rate*random_vector(seed))
   end subroutine draw

   subroutine add_damping(seed, decay, item)
      integer(int64), intent(inout) :: seed
      !> 1/s.
      real(wp), intent(in) :: decay
      type(dying_t), intent(inout) :: item
      real(wp) :: coefficient(3)
      integer :: i
      associate (system => item%problem%system)
         do i = 1, 3
            coefficient(i) = decay*system%body%inertia(i, i)*power_of_ten(seed, -1.0_wp, 0.0_wp)
         end do
         call system%effects%add(damping_t(coefficient))
      end associate
      item%text = trim(item%text)//', damping'
   end subroutine add_damping

   !> One or two wheels, the first with friction, of a tenth to a thousandth of the body's least moment.
   subroutine add_wheels(seed, rate, decay, item)
      integer(int64), intent(inout) :: seed
      !> rad/s, 1/s.
      real(wp), intent(in) :: rate, decay
      type(dying_t), intent(inout) :: item
      type(wheel_t) :: wheel
      type(status_t) :: status
      real(wp) :: least
      least = minval(item%problem%system%body%moments)
      wheel = wheel_t(name='wheel', axis=random_vector(seed), inertia=least*power_of_ten(seed, -3.0_wp, -1.0_wp), &
                      speed=rate*power_of_ten(seed, 0.0_wp, 2.0_wp))
      wheel%axis = wheel%axis/norm2(wheel%axis)
      wheel%friction = decay*wheel%inertia
      call add_wheel(item%problem%system, wheel, status)
      item%text = trim(item%text)//', wheel with friction'
      if (random_unit(seed) < 0.5_wp .or. .not. status%ok()) return
      wheel%axis = random_vector(seed)
      wheel%axis = wheel%axis/norm2(wheel%axis)
      wheel%friction = 0.0_wp
      allocate (wheel%motor, source=applied_torque_t(amplitude=[wheel%inertia*rate*power_of_ten(seed, 0.0_wp, 2.0_wp)/ &
                                                                item%end_time, 0.0_wp, 0.0_wp]))
      call add_wheel(item%problem%system, wheel, status)
      item%text = trim(item%text)//', driven wheel'
   end subroutine add_wheels

end module test_dying_motion
