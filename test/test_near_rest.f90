!> Damping brings bodies to rest. There the energy is stationary, and round-off of it would move a projected state by
!> √ε: neither steps that are chosen by the difference of a whole and two halves, nor the search for an accuracy may
!> take that for an error which shorter steps make smaller.
submodule(suites_of_effects) test_near_rest
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: eps, long, wp
   use nutate_quaternion, only: attitude_distance
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: kinetic_energy, make_state, new_problem, problem_t, total_energy
   use test_support, only: check, error_type, new_unittest, random_unit_quaternion, random_vector, share_of
   implicit none

   !> Pendulums drawn at random; `make test` draws three.
   integer, parameter :: motions = 8
   !> End time, s. A rotation about the vertical is not damped out: the body comes to rest anywhere.
   real(wp), parameter :: end_time = 60.0_wp
   !> Data of the gyroscope: weight times its arm, J, momentum of its rotor, N m s.
   real(wp), parameter :: weight = 0.4905_wp, spin = 15.0_wp
   character(len=*), parameter :: methods(2) = ['rk4', 'rk8']

contains

   module procedure collect_near_rest
      testsuite = [ &
                  new_unittest("steps grow in number as the order says", steps_follow_tolerance), &
                  new_unittest("the search for an accuracy ends, and keeps it", accuracy_is_found), &
                  new_unittest("steps as long as a swing come to rest, on the account", long_steps_come_to_rest), &
                  new_unittest("tolerances below round-off take no more steps than round-off", steps_end_at_round_off)]
   end procedure collect_near_rest

   type(integrator_settings_t) function settings_of(method) result(settings)
      character(len=*), intent(in) :: method
      settings = integrator_settings_t(method=method, order=0, formulation='', conserve=.true.)
   end function settings_of

   !> A pendulum of random moments in a fluid, thrown at random. In `end_time` it loses all but 1e-10 of its energy.
   subroutine draw(seed, problem)
      integer(int64), intent(inout) :: seed
      type(problem_t), intent(inout) :: problem
      type(status_t) :: status
      real(wp) :: center(3)
      problem = new_problem()
      center = random_vector(seed)
      call make_body(diagonal([1.0_wp, 1.3_wp, 1.6_wp] + 0.2_wp*random_vector(seed)), problem%system%body, status, &
                     mass=1.0_wp, center_of_mass=0.5_wp*center/norm2(center))
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call problem%system%effects%add(damping_t([0.5_wp, 0.6_wp, 0.7_wp]))
      problem%start = make_state(problem%system, random_unit_quaternion(seed), random_vector(seed))
   end subroutine draw

   !> A tenth of the tolerance takes 1.6 times the steps of order 4, 1.3 times those of order 8; the account of the
   !> energy holds all the way.
   subroutine steps_follow_tolerance(error)
      type(error_type), allocatable, intent(out) :: error
      !> Growth of the number of steps tried by a tenth of the tolerance; the account in units of ε of the energy.
      real(wp), parameter :: most_growth = 2.0_wp, account = 128.0_wp
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer(int64) :: seed
      integer(long) :: tried
      character(len=100) :: label
      real(wp) :: residual, limit
      integer :: i, k, exponent
      problem => new_problem()
      do k = 1, size(methods)
         seed = 7_int64
         do i = 1, share_of(motions)
            call draw(seed, problem)
            limit = huge(limit)
            do exponent = 9, 14
               state = problem%start
               call integrate(problem%system, settings_of(methods(k)), state, run_plan_t( &
                              goal=run_goal_t(local_tolerance=10.0_wp**(-exponent)), end_time=end_time, &
                              max_steps=1000000_long), status, summary=summary)
               tried = summary%steps + summary%subdivided_steps
               residual = abs(total_energy(problem%system, state) - total_energy(problem%system, problem%start) - &
                              sum(summary%work))/(eps*energy_scale(problem))
               write (label, '(a,", motion ",i0,", 1e-",i0,": ",i0," steps, account ",f0.1," eps")') &
                  methods(k), i, exponent, tried, residual
               call check(error, status%ok() .and. real(tried, wp) <= limit .and. residual <= account, &
                          trim(label)//' '//trim(status%message))
               if (allocated(error)) return
               limit = most_growth*real(tried, wp)
            end do
         end do
      end do
   end subroutine steps_follow_tolerance

   !> Largest T + |V| of a pendulum, J: at the start T and V, V at most that of the weight on its arm.
   real(wp) function energy_scale(problem)
      type(problem_t), intent(in) :: problem
      energy_scale = kinetic_energy(problem%system, problem%start) + 9.81_wp*0.5_wp
   end function energy_scale

   !> The search ends with an accuracy that is kept, or says what it can do.
   subroutine accuracy_is_found(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(state_t) :: state, reference
      type(status_t) :: status
      integer(int64) :: seed
      character(len=120) :: label
      real(wp) :: accuracy, distance
      integer :: i, k, exponent
      problem => new_problem()
      seed = 8_int64
      do i = 1, share_of(motions)
         call draw(seed, problem)
         reference = problem%start
         call integrate(problem%system, settings_of('taylor'), reference, run_plan_t( &
                        goal=run_goal_t(local_tolerance=1e-15_wp), end_time=end_time), status)
         do k = 1, size(methods)
            do exponent = 6, 12, 2
               accuracy = 10.0_wp**(-exponent)
               state = problem%start
               call integrate(problem%system, settings_of(methods(k)), state, run_plan_t( &
                              goal=run_goal_t(accuracy=accuracy), end_time=end_time, max_steps=1000000_long), status, &
                              summary=summary)
               distance = attitude_distance(state%q, reference%q)
               write (label, '(a,", motion ",i0,", 1e-",i0,": error ",es8.1,", said ",es8.1,", ",i0," steps")') &
                  methods(k), i, exponent, distance, summary%estimate, summary%steps
               call check(error, status%ok() .and. distance <= max(accuracy, summary%estimate), &
                          trim(label)//' '//trim(status%message))
            end do
         end do
      end do
   end subroutine accuracy_is_found

   !> A pendulum with a fast rotor nods at 14 rad/s. Steps of up to four revolutions of that are subdivided; in their
   !> parts a nod that is a rounding must not grow, nor the energy balance lose work that cannot be removed. The work of
   !> damping is the energy lost. The balance may be out by 64 ε of the largest T + |V| that a step leads to before it
   !> is projected: the weight's, and ½(0.1|L|)²/J if it errs by the longest move, 0.1 rad.
   subroutine long_steps_come_to_rest(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: all_methods(4) = [character(len=6) :: 'rk4', 'rk8', 'dop853', 'taylor']
      real(wp), parameter :: steps(4) = [2.0_wp, 0.5_wp, 0.4_wp, 0.1_wp]
      real(wp), parameter :: account = 64*(weight + 0.5_wp*(0.1_wp*spin)**2)/weight
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=120) :: label
      real(wp) :: residual, rest
      integer :: i, k
      problem => new_problem()
      call hang_gyroscope(problem)
      do k = 1, size(all_methods)
         do i = 1, share_of(size(steps))
            state = problem%start
            call integrate(problem%system, settings_of(trim(all_methods(k))), state, &
                           run_plan_t(time_step=steps(i), end_time=2e4_wp), status, summary=summary)
            residual = (total_energy(problem%system, state) - total_energy(problem%system, problem%start) - &
                        sum(summary%work))/(eps*weight)
            rest = (total_energy(problem%system, state) + weight)/weight
            write (label, '(a,", step ",f0.1,": account ",f0.1," eps, above rest by ",es8.1)') &
               trim(all_methods(k)), steps(i), residual, rest
            call check(error, status%ok() .and. abs(residual) <= account .and. abs(rest) <= 1e-12_wp, &
                       trim(label)//' '//trim(status%message))
         end do
      end do
   end subroutine long_steps_come_to_rest

   !> A pendulum with a fast rotor across it, in a fluid.
   subroutine hang_gyroscope(problem)
      type(problem_t), intent(inout) :: problem
      type(status_t) :: status
      problem = new_problem()
      call make_body(diagonal([1.0_wp, 1.2_wp, 1.4_wp]), problem%system%body, status, mass=50.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, -weight/(50*9.81_wp)])
      call problem%system%effects%add(rotor_t(momentum=[0.0_wp, spin, 0.0_wp]))
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call problem%system%effects%add(damping_t([0.1_wp, 0.1_wp, 0.45_wp]))
      problem%start = make_state(problem%system, [0.9_wp, 0.1_wp, 0.3_wp, 0.3_wp], [0.0_wp, 0.0_wp, 0.0_wp])
   end subroutine hang_gyroscope

   !> Checks that steps are no shorter than round-off requires if a tolerance is below the rounding of a step: from
   !> 1e-15 to there takes 1.4 times as many at order 4.
   subroutine steps_end_at_round_off(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: explicit(3) = [character(len=6) :: 'rk4', 'rk8', 'dop853']
      real(wp), parameter :: tolerances(3) = [1e-15_wp, 1e-16_wp, 1e-20_wp], most_growth = 2.0_wp
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer(long) :: tried
      character(len=100) :: label
      real(wp) :: limit
      integer :: i, k
      problem => new_problem()
      call hang_gyroscope(problem)
      do k = 1, size(explicit)
         limit = huge(limit)
         do i = 1, size(tolerances)
            state = problem%start
            call integrate(problem%system, settings_of(trim(explicit(k))), state, run_plan_t( &
                           goal=run_goal_t(local_tolerance=tolerances(i)), end_time=600.0_wp, max_steps=200000_long), &
                           status, summary=summary)
            tried = summary%steps + summary%subdivided_steps
            write (label, '(a,", ",es8.1,": ",i0," steps")') trim(explicit(k)), tolerances(i), tried
            call check(error, status%ok() .and. real(tried, wp) <= limit, trim(label)//' '//trim(status%message))
            if (allocated(error)) return
            if (i == 1) limit = most_growth*real(tried, wp)
         end do
      end do
   end subroutine steps_end_at_round_off

end submodule test_near_rest
