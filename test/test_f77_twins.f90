!> Problems as the library and as the FORTRAN 77 routines have them.
module test_f77_twins
   use nutate_damping, only: damping_t
   use nutate_effect, only: potential_t, torque_t
   use nutate_kinds, only: long, wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_f77_routines, only: nuinit
   use test_problems, only: angular_velocity, bruls_top, forced_body, make_state, problem_t, space_momentum, system_t, &
      total_energy
   implicit none
   private

   public :: twin_t, row_keeper_t, twin_of, top_twin, forced_twin, start, run_library, most, iuser, plain

   !> Effects of the library that compute the same as POTSPR and TORMOT.
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
      integer :: iform = 1, iorder = 2, icall = 0
   end type twin_t

   !> Keeps the rows of a run.
   type, extends(observer_t) :: row_keeper_t
      real(wp) :: rows(12, 200) = 0.0_wp
      integer :: n = 0
   contains
      procedure :: observe => keep_row
   end type row_keeper_t

   !> Longest WORK of the tests: order 8 of the eight equations.
   integer, parameter :: most = 2200
   integer, parameter :: iuser(2) = [3, 0]
   !> Stiffness, weight; motor: strength, rate, friction; time and value of what spoils a motion.
   real(wp), parameter :: plain(7) = [3.0_wp, 2.0_wp, 0.7_wp, 1.3_wp, 0.2_wp, 0.35_wp, 0.0_wp]

contains

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
      real(wp) :: tau(3), rate(3)
      tau = 0.0_wp
      rate = self%absolute_rate(q, omega)
      tau(self%axis) = self%strength*cos(self%rate*t) - self%friction*rate(self%axis)
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
   type(twin_t) function twin_of(problem, iform, iorder) result(twin)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: iform, iorder
      twin%problem = problem
      twin%iform = iform
      twin%iorder = iorder
      twin%settings%order = iorder
      if (iform == 1) twin%settings%formulation = 'reduced'
      twin%aj = problem%system%body%inertia
      twin%cm = problem%system%body%mass*problem%system%body%center_of_mass
   end function twin_of

   !> Brüls' heavy top.
   type(twin_t) function top_twin(iform, iorder) result(twin)
      integer, intent(in) :: iform, iorder
      twin = twin_of(bruls_top(), iform, iorder)
      twin%g = [0.0_wp, 0.0_wp, -9.81_wp]
   end function top_twin

   !> A full tensor with a rotor under a potential, damping and a torque that depends on time.
   type(twin_t) function forced_twin(iform, iorder, friction) result(twin)
      integer, intent(in) :: iform, iorder
      !> Friction of the motor, N m s; by default that of `plain`.
      real(wp), intent(in), optional :: friction
      type(problem_t), pointer :: problem
      type(rotor_t) :: rotor
      type(spring_in_height_t) :: spring
      real(wp) :: resistance
      resistance = plain(5)
      if (present(friction)) resistance = friction
      problem => forced_body()
      twin = twin_of(problem, iform, iorder)
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
         call effects%add(motor_t(axis=iuser(1), strength=plain(3), rate=plain(4), friction=resistance))
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
      call nuinit(twin%aj, twin%aj0, twin%h, twin%cm, twin%g, twin%d, twin%dn, twin%iform, twin%iorder, twin%icall, &
                  work, lwork, info)
      t = twin%problem%start%t
      q = twin%problem%start%q
      p = twin%problem%start%p
   end subroutine start

   !> The library's motion, with the rows of `keeper`.
   subroutine run_library(twin, dt, n, every, state, keeper, status, uncertified)
      type(twin_t), intent(in) :: twin
      real(wp), intent(in) :: dt
      integer, intent(in) :: n, every
      type(state_t), intent(out) :: state
      type(row_keeper_t), intent(inout) :: keeper
      type(status_t), intent(out) :: status
      !> Steps that are not certified.
      integer, intent(out), optional :: uncertified
      class(stepper_t), allocatable :: stepper
      type(run_summary_t) :: summary
      state = twin%problem%start
      call make_stepper(twin%problem%system, twin%settings, stepper, status)
      if (status%ok()) call integrate(twin%problem%system, stepper, state, &
                                      run_plan_t(time_step=dt, end_time=state%t + n*dt, every=int(every, long)), &
                                      status, keeper, summary)
      if (present(uncertified)) uncertified = int(summary%uncertified_steps)
   end subroutine run_library

end module test_f77_twins
