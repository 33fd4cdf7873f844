!> Steps of the series that are chosen by a tolerance err by no more than a few of it, where torques do work and the
!> state is projected onto the energy that this leaves, too.
submodule(suites_of_methods) test_step_tolerance
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, long
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: body_momentum, box, forced_body, make_state, new_system, problem_t, simo_top, system_t, &
      wheeled_body
   use test_support, only: check, error_type, new_unittest, random_unit_quaternion, random_vector
   implicit none

   type(integrator_settings_t), parameter :: series = integrator_settings_t( &
                                             method='taylor', order=0, formulation='', conserve=.true.)

   !> Repeats the last step in forty parts, and keeps the largest error over the tolerance.
   type, extends(observer_t) :: assessor_t
      type(state_t) :: before = state_t()
      real(wp) :: tolerance = 0.0_wp, worst = 0.0_wp
      logical :: begun = .false.
   contains
      procedure :: observe => assess_step
   end type assessor_t

contains

   module procedure collect_step_tolerance
      testsuite = [ &
                  new_unittest("free bodies and tops", without_torques), &
                  new_unittest("torques, springs and rotors", with_torques), &
                  new_unittest("wheels with motors and friction", with_wheels), &
                  new_unittest("moons on ellipses", with_eccentric_orbits)]
   end procedure collect_step_tolerance

   subroutine assess_step(self, system, state, record, status)
      class(assessor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      integer, parameter :: parts = 40
      type(state_t) :: fine
      real(wp) :: wanted(3)
      if (self%begun .and. abs(state%t - self%before%t) > 0.0_wp) then
         fine = self%before
         call integrate(system, series, fine, run_plan_t(time_step=(state%t - fine%t)/parts, end_time=state%t), status)
         if (.not. status%ok()) return
         wanted = body_momentum(fine)
         self%worst = max(self%worst, attitude_distance(fine%q, state%q)/self%tolerance, &
                          norm2(body_momentum(state) - wanted)/(norm2(wanted)*self%tolerance))
      end if
      self%begun = .true.
      self%before = state
   end subroutine assess_step

   !> Ten random motions at three tolerances.
   subroutine assess(error, system, rate, end_time)
      type(error_type), allocatable, intent(inout) :: error
      type(system_t), intent(in) :: system
      !> Rate of the motions, rad/s; end time, s.
      real(wp), intent(in) :: rate, end_time
      !> Error of a step over the tolerance, of which a third is the aim.
      real(wp), parameter :: bound = 3.0_wp
      type(assessor_t) :: assessor
      type(state_t) :: state
      type(status_t) :: status
      integer(int64) :: seed
      character(len=80) :: label
      real(wp) :: q(4), direction(3)
      integer :: i, exponent
      seed = 20260_int64
      do i = 1, 10
         q = random_unit_quaternion(seed)
         direction = random_vector(seed)
         direction = direction/norm2(direction)
         do exponent = 6, 12, 3
            state = make_state(system, q, rate*direction)
            assessor = assessor_t(tolerance=10.0_wp**(-exponent))
            call integrate(system, series, state, run_plan_t(goal=run_goal_t( &
                  local_tolerance=assessor%tolerance), end_time=end_time, every=1_long), status, assessor)
            write (label, '("motion ",i0,", 1e-",i0,": ",es9.2," tolerances")') i, exponent, assessor%worst
            call check(error, status%ok() .and. assessor%worst <= bound, trim(label)//' '//trim(status%message))
         end do
      end do
   end subroutine assess

   subroutine without_torques(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => box()
      call assess(error, problem%system, 5.0_wp, 5.0_wp)
      problem => simo_top()
      call assess(error, problem%system, 30.0_wp, 1.0_wp)
   end subroutine without_torques

   subroutine with_torques(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => forced_body()
      call assess(error, problem%system, 3.0_wp, 3.0_wp)
   end subroutine with_torques

   subroutine with_wheels(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => wheeled_body()
      call assess(error, problem%system, 3.0_wp, 2.0_wp)
   end subroutine with_wheels

   subroutine with_eccentric_orbits(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(status_t) :: status
      system => new_system()
      call make_body(diagonal([0.6_wp, 0.6_wp + 0.7921_wp/3, 1.0_wp]), system%body, status)
      call system%effects%add(orbital_gradient_t(system%body, kepler_orbit_t(eccentricity=0.1_wp)))
      call assess(error, system, 2.3_wp, 5.0_wp)
   end subroutine with_eccentric_orbits

end submodule test_step_tolerance
