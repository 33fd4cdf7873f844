!> Torques that jump within a step: the implicit step cannot take them and says so; dop853 steps over them.
submodule(suites_of_runs) test_jumps
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_effect, only: torque_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, box, make_state, new_system, problem_t, system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Dry friction: τᵢ = -strength sign(Ωᵢ), 0 at rest, N m.
   type, extends(torque_t) :: dry_friction_t
      real(wp) :: strength = 0.5_wp
   contains
      procedure :: torque => friction_torque
   end type dry_friction_t

   !> Principal moments, kg m².
   real(wp), parameter :: moments(3) = [3.0_wp, 4.0_wp, 5.0_wp]

contains

   module procedure collect_jumps
      testsuite = [ &
                  new_unittest("a jump is named where the implicit step fails", jump_is_named), &
                  new_unittest("a jump is named where the projection fails", jump_is_named_by_the_projection), &
                  new_unittest("dop853 steps over jumps", dop853_steps_over_jumps), &
                  new_unittest("no jump is named where no effect can jump", no_jump_is_invented)]
   end procedure collect_jumps

   pure function friction_torque(self, t, q, omega) result(tau)
      class(dry_friction_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -self%strength*merge(sign(1.0_wp, omega), 0.0_wp, abs(omega) > 0.0_wp)
   end function friction_torque

   !> A body under dry friction, stopped by it after some seconds.
   subroutine set_up(name, system, state)
      !> The effect's.
      character(len=*), intent(in) :: name
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(status_t) :: status
      call make_body(diagonal(moments), system%body, status)
      call system%effects%add(dry_friction_t(name=name))
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, -0.2_wp, 0.3_wp])
   end subroutine set_up

   subroutine jump_is_named(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(2) = ['full   ', 'reduced'], names(2) = ['dry friction', '            '], &
                                     called(2) = ['dry friction', 'unnamed     ']
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      integer :: i, order
      system => new_system()
      do i = 1, size(solvers)
         do order = 2, 8, 2
            call set_up(trim(names(i)), system, state)
            call integrate(system, integrator_settings_t(formulation=solvers(i), order=order), state, &
                           run_plan_t(time_step=0.05_wp, end_time=20.0_wp), status)
            call check(error, status%code, NUTATE_NOT_CONVERGED, 'the step was taken')
            call check_words(error, status, called(i))
         end do
      end do
   end subroutine jump_is_named

   subroutine jump_is_named_by_the_projection(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      system => new_system()
      call set_up('a name of 24 characters_', system, state)
      settings = default_settings('dop853')
      settings%conserve = .true.
      call integrate(system, settings, state, run_plan_t(time_step=0.05_wp, end_time=20.0_wp), status)
      call check(error, status%code, NUTATE_OFF_BRANCH, 'the step was taken')
      call check_words(error, status, 'a name of 24 characters_')
   end subroutine jump_is_named_by_the_projection

   !> The message names the effect and what runs, and is not cut.
   subroutine check_words(error, status, effect)
      type(error_type), allocatable, intent(inout) :: error
      type(status_t), intent(in) :: status
      character(len=*), intent(in) :: effect
      call check(error, index(status%message, "effect '"//trim(effect)//"' jumps") > 0, status%message)
      call check(error, index(status%message, "'dop853'") > 0, status%message)
      call check(error, index(status%message, 'steps over jumps ') > 0, status%message)
   end subroutine check_words

   !> About its axis 3 the body loses strength/J₃ of angular velocity in a second, exactly, until it is stopped; then it
   !> moves by no more than the torque gives it in a step. So do the other axes, whose torques act by themselves.
   subroutine dop853_steps_over_jumps(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: dt = 0.05_wp, rate = 0.3_wp
      type(dry_friction_t) :: friction
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      system => new_system()
      call set_up('dry friction', system, state)
      call integrate(system, default_settings('dop853'), state, run_plan_t(time_step=dt, end_time=20.0_wp), status)
      call check(error, status%ok() .and. state%t == 20.0_wp, status%message)
      call check_below(error, maxval(moments*abs(angular_velocity(system, state))), 2*dt*friction%strength)
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, rate])
      call integrate(system, default_settings('dop853'), state, run_plan_t(time_step=dt, end_time=2.0_wp), status)
      call check(error, status%ok(), status%message)
      associate (omega => angular_velocity(system, state))
         call check_close(error, omega(3:3), [rate - 2*friction%strength/moments(3)], 64*eps*rate)
      end associate
   end subroutine dop853_steps_over_jumps

   !> Built-in effects, none at all, and an explicit method, whose steps are merely too long: the time step is named.
   subroutine no_jump_is_invented(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(system_t) :: system
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => box()
      do i = 1, 2
         system = problem%system
         state = problem%start
         if (i == 2) call system%effects%add(damping_t([1.0_wp, 1.0_wp, 1.0_wp]))
         call integrate(system, integrator_settings_t(), state, run_plan_t(time_step=1e6_wp, end_time=1e7_wp), status)
         call check(error, any(status%code == [NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH]), status%message)
         call check(error, index(status%message, 'jump') == 0 .and. index(status%message, 'the time step is') > 0, &
                    status%message)
      end do
   end subroutine no_jump_is_invented

end submodule test_jumps
