!> Between the first and the last row of a run nothing is allocated, by whatever method and with whatever effects.
module test_heap
   use, intrinsic :: iso_c_binding, only: c_long_long
   use, intrinsic :: iso_fortran_env, only: compiler_version
   use nutate_kinds, only: wp
   use nutate_methods, only: methods
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: run_summary_t
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use test_shipped_scenes, only: scene_names
   use test_support, only: check, error_type, new_unittest, skip_test, test_failed, unittest_type
   implicit none
   private

   public :: collect_heap

   !> How many allocations there were between the first row and the last.
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
   end interface

contains

   subroutine collect_heap(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("fixed steps allocate nothing", fixed_steps_allocate_nothing), &
                  new_unittest("steps subdivided allocate nothing", subdivided_steps_allocate_nothing), &
                  new_unittest("controlled steps allocate nothing", controlled_steps_allocate_nothing), &
                  new_unittest("without attitude nothing is allocated", no_attitude_allocates_nothing)]
   end subroutine collect_heap

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
      type(scene_t) :: scene
      integer :: i
      call demand_counter(error)
      do i = 1, size(names)
         if (.not. allocated(error)) call load(error, names(i), scene, "output.columns='angular_velocity'")
         if (allocated(error)) return
         call check(error, .not. scene%integrator%attitude, trim(names(i))//' integrates the attitude')
         if (.not. allocated(error)) call try_methods(error, scene, 1.0_wp, .false.)
         if (.not. allocated(error)) call try_methods(error, scene, 1.0_wp, .true.)
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
      type(scene_t), intent(out) :: scene
      character(len=*), intent(in) :: override
      type(status_t) :: status
      character(len=:), allocatable :: message
      call read_scene('scenes/'//trim(name)//'.nml', scene, status, message, [override])
      call check(error, status%ok(), message)
   end subroutine load

   subroutine try_every_scene(error, factor, controlled)
      type(error_type), allocatable, intent(inout) :: error
      !> On the scene's time step.
      real(wp), intent(in) :: factor
      logical, intent(in) :: controlled
      type(scene_t) :: scene
      integer :: i
      call demand_counter(error)
      do i = 1, size(scene_names)
         if (.not. allocated(error)) call load(error, scene_names(i), scene, "scene.title='allocations'")
         if (.not. allocated(error)) call try_methods(error, scene, factor, controlled)
      end do
   end subroutine try_every_scene

   !> Runs a scene with every method that can.
   subroutine try_methods(error, scene, factor, controlled)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(inout) :: scene
      real(wp), intent(in) :: factor
      logical, intent(in) :: controlled
      integer :: row
      logical :: is_free
      associate (effects => scene%system%effects)
         is_free = effects%n_potentials + effects%n_torques + effects%n_rotors == 0
      end associate
      do row = 1, size(methods)
         if (methods(row)%name == 'exact' .and. (controlled .or. .not. is_free)) cycle
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

end module test_heap
