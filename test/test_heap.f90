!> Between the first and the last row of a run nothing is allocated, by whatever method and with whatever effects; and
!> steppers of C are small.
submodule(suites_of_runs) test_heap
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_long_long, c_null_char, c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: compiler_version
   use nutate_c_stepper, only: nutate_stepper_create, nutate_stepper_destroy, nutate_stepper_set, &
      nutate_stepper_set_state
   use nutate_c_stepping, only: nutate_stepper_step
   use nutate_c_system, only: nutate_system_add_groups, nutate_system_create_moments, nutate_system_destroy
   use nutate_kinds, only: wp
   use nutate_methods, only: methods, system_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, error_type, in_turn, new_unittest, scene_names, skip_test, test_failed
   implicit none

   !> Number of allocations between the first row and the last.
   type, extends(observer_t) :: heap_watch_t
      logical :: started = .false.
      integer(c_long_long) :: first = 0, last = 0
   contains
      procedure :: observe => count_at_row
   end type heap_watch_t

   interface
      !> Allocations of this thread so far; always 0 where they cannot be counted.
      function count_allocations() bind(c, name='test_count_allocations') result(count)
         import :: c_long_long
         integer(c_long_long) :: count
      end function count_allocations

      !> Bytes of the heap in use; always 0 where they cannot be counted.
      function heap_in_use() bind(c, name='test_heap_in_use') result(bytes)
         import :: c_long_long
         integer(c_long_long) :: bytes
      end function heap_in_use
   end interface

contains

   module procedure collect_heap
      testsuite = [ &
                  new_unittest("fixed steps allocate nothing", fixed_steps_allocate_nothing), &
                  new_unittest("steps subdivided allocate nothing", subdivided_steps_allocate_nothing), &
                  new_unittest("controlled steps allocate nothing", controlled_steps_allocate_nothing), &
                  new_unittest("without attitude nothing is allocated", no_attitude_allocates_nothing), &
                  new_unittest("steppers are small", steppers_are_small)]
   end procedure collect_heap

   subroutine count_at_row(self, system, state, record, status)
      class(heap_watch_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%last = count_allocations()
      if (.not. self%started) self%first = self%last
      self%started = .true.
   end subroutine count_at_row

   subroutine fixed_steps_allocate_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      call try_every_scene(error, 1.0_wp, .false.)
   end subroutine fixed_steps_allocate_nothing

   !> Steps of about 5 rad, which the conserving method does not take in one piece.
   subroutine subdivided_steps_allocate_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      call try_every_scene(error, 60.0_wp, .false.)
   end subroutine subdivided_steps_allocate_nothing

   subroutine controlled_steps_allocate_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      call try_every_scene(error, 1.0_wp, .true.)
   end subroutine controlled_steps_allocate_nothing

   subroutine no_attitude_allocates_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: names(3) = [character(len=13) :: 'box', 'gyrostat', 'slowing_plate']
      class(scene_t), allocatable :: scene
      integer :: i
      allocate (scene)
      call demand_counter(error)
      do i = 1, size(names)
         if (.not. allocated(error)) call load(error, names(i), scene, "output.columns='angular_velocity'")
         if (allocated(error)) return
         call check(error, .not. scene%integrator%attitude, trim(names(i))//' integrates the attitude')
         if (.not. allocated(error)) call try_methods(error, scene, i, 1.0_wp, .false.)
         if (.not. allocated(error)) call try_methods(error, scene, i, 1.0_wp, .true.)
      end do
   end subroutine no_attitude_allocates_nothing

   !> Skips the test where allocations are not counted, and where the compiler puts the results of array expressions on
   !> the heap whatever the source says.
   subroutine demand_counter(error)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), allocatable :: probe(:)
      integer(c_long_long) :: before
      before = count_allocations()
      allocate (probe(100), source=real(before, wp))
      if (index(compiler_version(), 'flang') > 0) then
         call skip_test(error, "flang allocates the results of array expressions")
         return
      end if
      if (count_allocations() == before) call skip_test(error, "allocations cannot be counted here")
   end subroutine demand_counter

   subroutine load(error, name, scene, override)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      type(scene_t), intent(inout) :: scene
      character(len=*), intent(in) :: override
      type(status_t) :: status
      character(len=:), allocatable :: message
      call read_scene('scenes/'//trim(name)//'.nml', scene, status, message, [override])
      call check(error, status%ok(), message)
   end subroutine load

   subroutine try_every_scene(error, factor, controlled)
      type(error_type), allocatable, intent(inout) :: error
      !> Factor on the scene's time step.
      real(wp), intent(in) :: factor
      logical, intent(in) :: controlled
      class(scene_t), allocatable :: scene
      integer :: i
      allocate (scene)
      call demand_counter(error)
      do i = 1, size(scene_names)
         if (.not. allocated(error)) call load(error, scene_names(i), scene, "scene.title='allocations'")
         if (.not. allocated(error)) call try_methods(error, scene, i, factor, controlled)
      end do
   end subroutine try_every_scene

   !> Runs a scene with every method that can.
   subroutine try_methods(error, scene, number, factor, controlled)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(inout) :: scene
      !> Number of the scene: methods take turns from scene to scene.
      integer, intent(in) :: number
      real(wp), intent(in) :: factor
      logical, intent(in) :: controlled
      integer :: row
      logical :: is_free
      associate (effects => scene%system%effects)
         is_free = effects%n_potentials + effects%n_torques + effects%n_rotors == 0
      end associate
      do row = 1, size(methods)
         if (methods(row)%name == 'exact' .and. (controlled .or. .not. is_free)) cycle
         if (.not. in_turn(row + number)) cycle
         scene%integrator%method = methods(row)%name
         scene%integrator%formulation = methods(row)%formulation
         scene%integrator%order = methods(row)%order
         call try_run(error, scene, factor, controlled)
      end do
   end subroutine try_methods

   !> Runs a scene as its settings are and checks that nothing was allocated. A step that cannot be done ends the run,
   !> but must not allocate either.
   subroutine try_run(error, scene, factor, controlled)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(in) :: scene
      real(wp), intent(in) :: factor
      logical, intent(in) :: controlled
      type(heap_watch_t) :: watch
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=400) :: text
      state = scene%initial
      plan%time_step = factor*scene%plan%time_step
      plan%end_time = 40.5_wp*plan%time_step
      if (controlled) plan%goal%local_tolerance = 1e-8_wp
      call integrate(scene%system, scene%integrator, state, plan, status, watch, summary)
      write (text, '(a," of order ",i0," ",a," on ",a,": ",i0," allocations in ",i0," steps; ",a)') &
         trim(scene%integrator%method), scene%integrator%order, trim(scene%integrator%formulation), scene%name, &
         watch%last - watch%first, summary%steps, trim(status%message)
      if (summary%steps == 0 .or. watch%last > watch%first) call test_failed(error, trim(text))
   end subroutine try_run

   !> A stepper of C that has made a step needs less than 9.1 kB where no effect needs more, so that thousands of them
   !> stay in the cache; a series needs room for its coefficients.
   subroutine steppers_are_small(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: weight = '&gravity acceleration = 0, 0, -9.81 /', &
                                     damping = '&damping coefficient = 0.01, 0.01, 0.01 /'
      call demand_counter(error)
      if (.not. allocated(error) .and. heap_in_use() == 0) call skip_test(error, "the heap cannot be measured here")
      if (allocated(error)) return
      call check_size(error, '', 'nielsen_krenk', 'reduced', 8600)
      call check_size(error, '', 'nielsen_krenk', 'full', 8800)
      call check_size(error, '', 'rk4', '', 8500)
      call check_size(error, '', 'rk8', '', 9100)
      call check_size(error, '', 'dop853', '', 8500)
      call check_size(error, '', 'taylor', '', 17500)
      call check_size(error, weight, 'nielsen_krenk', 'reduced', 10500)
      call check_size(error, damping, 'nielsen_krenk', 'reduced', 10500)
      call check_size(error, weight, 'rk8', '', 9800)
      call check_size(error, damping, 'rk8', '', 9800)
   end subroutine steppers_are_small

   !> Checks the bytes of a stepper after a step, the mean of some. Those before may need what all of them share, and
   !> use up the free pieces of the heap, which may be a little too long.
   subroutine check_size(error, group, method, formulation, most)
      type(error_type), allocatable, intent(inout) :: error
      !> Group of the effect, blank: none; method; formulation, blank: that of the method.
      character(len=*), intent(in) :: group, method, formulation
      !> Bytes.
      integer, intent(in) :: most
      integer, parameter :: others = 100, number = 100
      !> Bytes that pieces of the heap may be longer in the mean: it depends on what was allocated before.
      integer, parameter :: slack = 64
      type(c_ptr), target :: system, steppers(others + number)
      integer(c_long_long) :: before, bytes
      integer(c_int) :: code
      character(len=200) :: text
      integer :: i
      system = c_null_ptr
      steppers = c_null_ptr
      code = nutate_system_create_moments([5.0_wp, 20.0_wp, 17.0_wp], 1.0_wp, [0.0_wp, 0.0_wp, 0.5_wp], 0, &
                                          c_loc(system), c_null_ptr, 0_c_size_t)
      if (group /= '') code = code + nutate_system_add_groups(system, text_to_c(group))
      before = 0
      do i = 1, others + number
         if (i == others + 1) before = heap_in_use()
         code = code + nutate_stepper_create(system, c_loc(steppers(i)), c_null_ptr, 0_c_size_t)
         code = code + nutate_stepper_set(steppers(i), text_to_c('method'), text_to_c(method))
         if (formulation /= '') code = code + nutate_stepper_set(steppers(i), text_to_c('formulation'), &
                                                                 text_to_c(formulation))
         code = code + nutate_stepper_set_state(steppers(i), 0.0_wp, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
                                                [0.1_wp, 0.0_wp, 10.0_wp])
         code = code + nutate_stepper_step(steppers(i), 0.01_wp)
      end do
      bytes = (heap_in_use() - before)/number
      do i = 1, others + number
         code = code + nutate_stepper_destroy(c_loc(steppers(i)))
      end do
      code = code + nutate_system_destroy(c_loc(system))
      write (text, '(i0," bytes of a stepper by ",3(a,1x),"(status ",i0,")")') bytes, method, formulation, group, code
      call check(error, code == 0 .and. bytes > 0 .and. bytes < most + slack, trim(text))
   end subroutine check_size

   !> The address of a text as C has it, until the next five are asked for.
   type(c_ptr) function text_to_c(text)
      character(len=*), intent(in) :: text
      character(kind=c_char), save, target :: texts(100, 5) = c_null_char
      integer, save :: last = 0
      integer :: i
      last = 1 + modulo(last, size(texts, 2))
      do i = 1, len(text)
         texts(i, last) = text(i:i)
      end do
      texts(len(text) + 1, last) = c_null_char
      text_to_c = c_loc(texts(1, last))
   end function text_to_c

end submodule test_heap
