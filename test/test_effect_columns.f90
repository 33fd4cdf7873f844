!> Columns of each effect: works against the integral of their power, at rows between the ends of steps; their names.
submodule(suites_of_effects) test_effect_columns
   use nutate_applied_torque, only: applied_torque_t
   use nutate_columns, only: columns_t
   use nutate_damping, only: damping_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, forced_body, make_state, potential_energy, problem_t, system_t
   use test_support, only: check, check_below, error_type, new_unittest
   implicit none

   !> Intervals of the quadrature in a run of one second.
   integer, parameter :: intervals = 1024
   !> Torques, then motor and friction of each wheel, of `driven_body`.
   integer, parameter :: workers = 6

   !> Keeps works and powers.
   type, extends(observer_t) :: keeper_t
      type(columns_t) :: columns
      integer :: rows = 0
      real(wp) :: works(workers, 0:intervals) = 0.0_wp, powers(workers, 0:intervals) = 0.0_wp
      !> Largest difference of the columns from their sums, J.
      real(wp) :: energies_off = 0.0_wp, works_off = 0.0_wp
   contains
      procedure :: observe => keep_row
   end type keeper_t

contains

   module procedure collect_effect_columns
      testsuite = [ &
                  new_unittest("works are the integrals of their powers, inside steps too", works_are_integrals), &
                  new_unittest("effects of a kind are numbered, names are fit for a header", names_are_numbered), &
                  new_unittest("records have no works where nobody wants them", unwanted_works_are_absent)]
   end procedure collect_effect_columns

   !> Damping, two torques of the same kind and two wheels, one driven and both with friction.
   function driven_body() result(problem)
      type(problem_t), pointer :: problem
      type(wheel_t) :: wheel
      type(status_t) :: status
      problem => forced_body()
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp, speed=5.0_wp, friction=0.02_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp], frequency=0.8_wp))
      call add_wheel(problem%system, wheel, status)
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, &
                                             speed=-20.0_wp, friction=0.15_wp), status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -2.0_wp, 3.0_wp])
   end function driven_body

   subroutine keep_row(self, system, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: values(self%columns%width), omega(3), speed, drive(3)
      integer :: i, potentials
      call self%columns%evaluate(system, state, record, values)
      potentials = system%effects%n_potentials
      self%energies_off = max(self%energies_off, abs(sum(values(2:1 + potentials)) - &
                                                      potential_energy(system%effects, state%q, state%t)))
      self%works_off = max(self%works_off, abs(sum(values(2 + potentials:)) - record%work))
      if (self%rows > intervals) return
      self%works(:, self%rows) = values(2 + potentials:)
      omega = angular_velocity(system, state)
      do i = 1, system%effects%n_torques
         self%powers(i, self%rows) = dot_product(omega, &
                                                 system%effects%torques(i)%item%torque(state%t, state%q, omega))
      end do
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i), first => system%effects%n_torques + 2*i - 1)
            speed = wheel%speed_of(state%wheel_momentum(i), omega)
            drive = 0.0_wp
            if (allocated(wheel%motor)) drive = wheel%motor%torque(state%t, state%q, omega)
            self%powers(first, self%rows) = drive(1)*speed
            self%powers(first + 1, self%rows) = -wheel%friction*speed**2
         end associate
      end do
      self%rows = self%rows + 1
   end subroutine keep_row

   !> Simpson's rule over rows of which one in thirteen ends a step: its error is h⁴/180 times the fourth derivative of
   !> a power, some 1e4 W/s⁴ here.
   subroutine works_are_integrals(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=13), parameter :: names(*) = [character(len=13) :: 'taylor', 'dop853', 'rk8', 'nielsen_krenk']
      type(keeper_t), allocatable :: keeper
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: integral(workers), worst
      integer :: m, k, chosen
      problem => driven_body()
      do m = 1, size(names)
         do chosen = 0, 1
            settings = default_settings(trim(names(m)))
            settings%conserve = names(m) /= 'nielsen_krenk'
            if (names(m) == 'nielsen_krenk') settings%order = 8
            plan = run_plan_t(end_time=1.0_wp, time_step=13.0_wp/intervals)
            if (chosen == 1) plan%goal%local_tolerance = 1e-12_wp
            plan%times = [(real(k, wp)/intervals, k=0, intervals)]
            allocate (keeper)
            call keeper%columns%choose([character(len=24) :: 'energies', 'works'], status, &
                                       effects=problem%system%effects)
            call check(error, status%ok() .and. keeper%columns%header() == 't,energy_gravity,energy_spring,'// &
                       'work_damping,work_torque,work_motor1,work_friction1,work_motor2,work_friction2', &
                       trim(status%message)//keeper%columns%header())
            if (allocated(error)) return
            keeper%wants_works = keeper%columns%needs_works
            state = problem%start
            call integrate(problem%system, settings, state, plan, status, keeper)
            call check(error, status%ok() .and. keeper%rows == intervals + 1, trim(names(m))//': '//status%message)
            integral = 0.0_wp
            worst = 0.0_wp
            do k = 2, intervals, 2
               integral = integral + (keeper%powers(:, k - 2) + 4*keeper%powers(:, k - 1) + keeper%powers(:, k)) &
                          /(3*intervals)
               worst = max(worst, maxval(abs(keeper%works(:, k) - integral)))
            end do
            call check_below(error, worst, 1e-9_wp, trim(names(m))//': works')
            call check(error, all(abs(keeper%works(1:4, intervals)) > 1e-2_wp) .and. &
                       .not. any(abs(keeper%works(5, :)) > 0.0_wp), trim(names(m))//': what does no work')
            ! The bound allows for sums of some hundred steps of up to 100 J.
            call check_below(error, max(keeper%energies_off, keeper%works_off), 1e4_wp*eps, trim(names(m))//': sums')
            deallocate (keeper)
         end do
      end do
   end subroutine works_are_integrals

   subroutine names_are_numbered(error)
      type(error_type), allocatable, intent(out) :: error
      type(columns_t) :: columns
      type(effect_list_t) :: effects
      type(status_t) :: status
      call effects%add(damping_t(coefficient=[1.0_wp, 1.0_wp, 1.0_wp]))
      call effects%add(applied_torque_t(name='jet, left', amplitude=[1.0_wp, 0.0_wp, 0.0_wp]))
      call effects%add(applied_torque_t(name='torque', amplitude=[1.0_wp, 0.0_wp, 0.0_wp]))
      call effects%add(applied_torque_t(name='torque', amplitude=[1.0_wp, 0.0_wp, 0.0_wp]))
      call effects%add(applied_torque_t(amplitude=[1.0_wp, 0.0_wp, 0.0_wp]))
      call columns%choose([character(len=24) :: 'works'], status, effects=effects)
      call check(error, columns%header() == 't,work_damping,work_jet__left,work_torque1,work_torque2,work_effect', &
                 columns%header())
      call columns%choose([character(len=24) :: 'energies'], status, effects=effects)
      call check(error, .not. status%ok(), 'energies without a potential')
   end subroutine names_are_numbered

   subroutine unwanted_works_are_absent(error)
      type(error_type), allocatable, intent(out) :: error
      type(columns_t) :: columns
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: values(7)
      problem => driven_body()
      call columns%choose([character(len=24) :: 'works'], status, effects=problem%system%effects)
      values = 1.0_wp
      call columns%evaluate(problem%system, problem%start, run_record_t(work=1.0_wp), values)
      call check(error, .not. any(abs(values) > 0.0_wp), 'works before the run')
   end subroutine unwanted_works_are_absent

end submodule test_effect_columns
