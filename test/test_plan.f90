!> Parts of the integrator that a scene selects: only those that its effects and its output require.
submodule(suites_of_runs) test_plan
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, NO_COMPONENT, ONLY_LENGTH, conserved_momentum, invariants_t
   use nutate_kinds, only: wp
   use nutate_methods, only: equations_of, make_stepper, stepper_t
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_reduced, only: reduced_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   character(len=*), parameter :: newline = new_line('a')
   !> A scene but for its effects and its columns.
   character(len=*), parameter :: frame = &
                                  "&body inertia = 1, 2, 2.5, mass = 2, center_of_mass = 0, 0, 0.1 /"//newline// &
                                  "&initial angular_velocity = 1, 2, 3 /"//newline// &
                                  "&integrator time_step = 0.01, end_time = 1 /"//newline

contains

   module procedure collect_plan
      testsuite = [ &
                  new_unittest("attitude only where something depends on it", attitude_only_where_needed), &
                  new_unittest("without attitude three equations are solved", three_equations_without_attitude), &
                  new_unittest("invariants follow from the effects", invariants_follow_from_the_effects)]
   end procedure collect_plan

   subroutine attitude_only_where_needed(error)
      type(error_type), allocatable, intent(out) :: error
      call expect("&output /", .true.)
      call expect("&output columns = 'angular_velocity', 'angular_momentum', 'energy', 'solver' /", .false.)
      call expect("&output columns = 'angular_velocity' /"//newline//"&damping coefficient = 1, 1, 1 /", .false.)
      call expect("&output columns = 'energy' /"//newline//"&torque body = 1, 1, 1 /"//newline// &
                  "&rotor momentum = 1, 0, 0 /", .false.)
      call expect("&output columns = 'energy' /"//newline//"&torque space = 1, 1, 1 /", .true.)
      call expect("&output columns = 'energy' /"//newline//"&gravity /", .true.)
      call expect("&output columns = 'energy', 'constraints' /", .true.)
      call expect("&output columns = 'energy', 'euler' /", .true.)
      call expect("&output columns = 'angular_velocity_space' /", .true.)

   contains

      subroutine expect(rest, attitude)
         character(len=*), intent(in) :: rest
         logical, intent(in) :: attitude
         class(scene_t), allocatable :: scene
      allocate (scene)
         call read_text(error, rest, scene)
         if (allocated(error)) return
         call check(error, scene%integrator%attitude .eqv. attitude, rest)
      end subroutine expect

   end subroutine attitude_only_where_needed

   subroutine three_equations_without_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      allocate (scene)
      call read_text(error, "&output columns = 'energy' /", scene)
      if (allocated(error)) return
      call make_stepper(scene%system, scene%integrator, stepper, status)
      select type (stepper)
      type is (reduced_t)
         call check(error, index(equations_of(scene%integrator), '3 equations') == 1, "not said to be three")
      class default
         call check(error, .false., "another stepper")
      end select
      call read_text(error, "&output /", scene)
      call make_stepper(scene%system, scene%integrator, stepper, status)
      select type (stepper)
      type is (nielsen_krenk_t)
         call check(error, index(equations_of(scene%integrator), '8 equations') == 1, "not said to be eight")
      class default
         call check(error, .false., "another stepper")
      end select
   end subroutine three_equations_without_attitude

   subroutine invariants_follow_from_the_effects(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: none(3) = 0.0_wp
      class(scene_t), allocatable :: scene
      type(invariants_t) :: invariants
      allocate (scene)
      call expect("&rotor momentum = 1, 2, 3 /", ALL_COMPONENTS, none)
      call expect("&gravity acceleration = 0, 3, -4 /", ALONG_AXIS, [0.0_wp, 0.6_wp, -0.8_wp])
      call expect("&gravity /"//newline//"&dipole moment = 1, 2, 3, field = 0, 0, 7 /", ALONG_AXIS, &
                  [0.0_wp, 0.0_wp, -1.0_wp])
      call expect("&gravity /"//newline//"&dipole moment = 1, 2, 3, field = 1, 0, 7 /", NO_COMPONENT, none)
      call expect("&gravity acceleration = 0, 0, 0 /", ALL_COMPONENTS, none)
      call expect("&damping coefficient = 1, 1, 1 /", NO_COMPONENT, none)
      call read_text(error, "&output columns = 'energy' /", scene)
      call invariants%start(scene%system, scene%initial, attitude=scene%integrator%attitude)
      call check(error, invariants%components, ONLY_LENGTH)

   contains

      subroutine expect(effects, components, axis)
         character(len=*), intent(in) :: effects
         integer, intent(in) :: components
         real(wp), intent(in) :: axis(3)
         integer :: found
         real(wp) :: direction(3)
         call read_text(error, effects, scene)
         if (allocated(error)) return
         call conserved_momentum(scene%system%effects, found, direction)
         call check(error, found == components, effects)
         call check_close(error, direction, axis, 1e-15_wp, effects)
      end subroutine expect

   end subroutine invariants_follow_from_the_effects

   !> The scene of the frame and the rest.
   subroutine read_text(error, rest, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: rest
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(frame//rest//newline, 'plan.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read_text

end submodule test_plan
