!> Every scene that comes along: both solvers give one trajectory, and the accuracy asked for is the one that comes out.
module test_shipped_scenes
   use nutate_method_choice, only: choose_method, AUTOMATIC_METHOD
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, scene_names, &
                           unittest_type
   implicit none
   private

   public :: collect_shipped_scenes

   !> Keeps the largest departure of the invariants.
   type, extends(observer_t) :: guard_t
      logical :: started = .false.
      type(invariants_t) :: invariants
   contains
      procedure :: observe => guard_row
   end type guard_t

contains

   subroutine collect_shipped_scenes(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("full and reduced agree over 1000 steps", solvers_agree), &
                  new_unittest("orders 4, 6, 8 with all effects", orders_with_all_effects), &
                  new_unittest("accuracy asked for is met on every scene", accuracy_is_met_on_every_scene)]
   end subroutine collect_shipped_scenes

   subroutine guard_row(self, system, state, record, status)
      class(guard_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. self%started) call self%invariants%start(system, state)
      self%started = .true.
      call self%invariants%measure(system, state, record%work)
   end subroutine guard_row

   !> A scene from the folder of scenes.
   subroutine load(error, name, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call read_scene('scenes/'//trim(name)//'.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine load

   subroutine solvers_agree(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(state_t) :: a, b
      real(wp) :: tolerance
      integer :: i
      allocate (scene)
      do i = 1, size(scene_names)
         call load(error, scene_names(i), scene)
         if (allocated(error)) return
         call march(error, scene, 'full', 2, scene%plan%time_step, 1000, a)
         if (allocated(error)) return
         call march(error, scene, 'reduced', 2, scene%plan%time_step, 1000, b)
         if (allocated(error)) return
         tolerance = 1e-11_wp
         ! The instability of the box amplifies round-off.
         if (scene_names(i) == 'box') tolerance = 1e-9_wp
         call check_close(error, b%q, a%q, tolerance, trim(scene_names(i)))
      end do
   end subroutine solvers_agree

   !> The state after n steps.
   subroutine march(error, scene, solver, order, dt, n, state)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: solver
      integer, intent(in) :: order, n
      real(wp), intent(in) :: dt
      type(state_t), intent(out) :: state
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      integer :: i
      state = scene%initial
      call make_stepper(scene%system, integrator_settings_t(formulation=solver, order=order), stepper, status)
      do i = 1, n
         if (status%ok()) call stepper%step(scene%system, state, dt, status)
      end do
      call check(error, status%ok(), scene%name//': '//trim(status%message))
   end subroutine march

   !> Checks orders before the windowed torque of the scene starts at 2.005 s. The errors lie between 1e-3 and 1e-13.
   subroutine orders_with_all_effects(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=7), parameter :: solvers(2) = ['full   ', 'reduced']
      integer, parameter :: steps(3) = [40, 20, 11]
      real(wp), parameter :: end_time = 2.0_wp
      class(scene_t), allocatable :: scene
      type(state_t) :: reference, state
      real(wp) :: errors(2)
      integer :: i, k, solver
      allocate (scene)
      call load(error, 'all_effects', scene)
      if (allocated(error)) return
      call march(error, scene, 'reduced', 8, end_time/200, 200, reference)
      do solver = 1, 2
         do i = 1, 3
            do k = 1, 2
               if (.not. allocated(error)) &
                  call march(error, scene, solvers(solver), 2 + 2*i, end_time/(k*steps(i)), k*steps(i), state)
               errors(k) = attitude_distance(state%q, reference%q)
            end do
            call check(error, errors(1) < 1e-3_wp .and. errors(2) > 1e-13_wp, "errors are out of the range that shows")
            call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(2 + 2*i, wp), &
                             merge(0.4_wp, 0.2_wp, i == 3), "order")
         end do
      end do
   end subroutine orders_with_all_effects

   !> Order 8, the Taylor series and what is chosen from 1e-4 to 1e-12 against dop853: the error that comes out is below
   !> the accuracy. Down to 1e4 times ε per radian rotated: the motions amplify the round-off of dop853 that far (on
   !> all_effects, its runs with 345 and 4000 steps differ by 5e-11, those of order 8 with 333, 1000 and 4000 by 5e-13).
   subroutine accuracy_is_met_on_every_scene(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp) :: reference(4), q(4), finest, accuracy
      integer :: i, exponent
      character(len=48) :: label
      allocate (scene)
      do i = 1, size(scene_names)
         call load(error, scene_names(i), scene)
         if (allocated(error)) return
         finest = 1e4_wp*eps*norm2(angular_velocity(scene%system, scene%initial))*scene%plan%end_time
         call solve(error, scene, 'dop853', max(1e-13_wp, 1e-3_wp*finest), reference)
         do exponent = 4, 12, 2
            if (allocated(error)) return
            accuracy = 10.0_wp**(-exponent)
            if (accuracy < finest) exit
            write (label, '(a,", accuracy 1e-",i0)') trim(scene_names(i)), exponent
            call solve(error, scene, AUTOMATIC_METHOD, accuracy, q)
            if (allocated(error)) return
            call check_below(error, attitude_distance(q, reference), accuracy, 'auto, '//label)
            if (mod(exponent, 4) /= 0 .or. .not. in_turn(i + exponent/4)) cycle
            call solve(error, scene, 'nielsen_krenk', accuracy, q)
            if (allocated(error)) return
            call check_below(error, attitude_distance(q, reference), accuracy, label)
            call solve(error, scene, 'taylor', accuracy, q)
            if (allocated(error)) return
            call check_below(error, attitude_distance(q, reference), accuracy, 'taylor, '//label)
         end do
      end do
   end subroutine accuracy_is_met_on_every_scene

   !> The attitude at the end of a scene by steps for an accuracy; the invariants of the conserving method are checked.
   subroutine solve(error, scene, method, accuracy, q)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: method
      !> rad.
      real(wp), intent(in) :: accuracy
      real(wp), intent(out) :: q(4)
      type(integrator_settings_t) :: settings
      character(len=:), allocatable :: reason
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(guard_t) :: guard
      type(status_t) :: status
      settings = integrator_settings_t(method=method, order=8, formulation='reduced', conserve=method == 'taylor')
      if (method == AUTOMATIC_METHOD) call choose_method(scene%system, scene%initial, scene%plan%end_time, &
                                                         accuracy, settings, reason)
      plan%end_time = scene%plan%end_time
      plan%every = 50
      state = scene%initial
      plan%goal%accuracy = accuracy
      call integrate(scene%system, settings, state, plan, status, guard, summary)
      q = state%q
      call check(error, status%ok(), scene%name//': '//trim(status%message))
      if (allocated(error) .or. method == 'dop853') return
      call check_below(error, max(guard%invariants%energy_error(), guard%invariants%momentum_error()), &
                       merge(1e-14_wp*sqrt(real(summary%steps, wp)), 1e-12_wp, method /= 'nielsen_krenk'), &
                       scene%name//': invariants')
   end subroutine solve

end module test_shipped_scenes
