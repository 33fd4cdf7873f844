!> Sensitivities of runs: at rows inside of steps, by adaptive steps, from checkpoints on; and what is refused.
module test_tangent_runs
   use nutate_body, only: diagonal, make_body
   use nutate_byte_archive, only: byte_archive_t
   use nutate_sensitivity_projection, only: kept_steps
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_controller, only: controller_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_run, only: run_record_t, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STOPPED
   use nutate_tangent, only: tangent_t
   use test_problems, only: body_momentum, box, forced_body, make_state, new_system, problem_t, system_t
   use test_stopping_observer, only: stopping_observer_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_tangent_runs, sensitivity_recorder_t

   !> Keeps the columns of rows, and the checkpoint of one poll, at which it ends the run.
   type, extends(stopping_observer_t) :: sensitivity_recorder_t
      integer :: n = 0
      real(wp) :: t(100) = 0.0_wp, theta(100) = 0.0_wp, momentum(100) = 0.0_wp
   contains
      procedure :: observe => record_sensitivities
   end type sensitivity_recorder_t

   type(integrator_settings_t), parameter :: of_order_four = &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=4)

contains

   subroutine collect_tangent_runs(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("rows inside steps have columns of their own", sensitivities_inside), &
                  new_unittest("adaptive steps propagate sensitivities too", propagate_adaptive), &
                  new_unittest("adaptive steps keep columns to the tolerance", keep_tolerance), &
                  new_unittest("checkpoints hold columns", resume_sensitivities), &
                  new_unittest("what has no derivative is refused by name", refuse)]
   end subroutine collect_tangent_runs

   !> The columns of these tests: two of the start, one of the body.
   function columns_of() result(columns)
      type(variation_t) :: columns(3)
      columns = [attitude_variation(1), rate_variation(2), inertia_variation(1, 3)]
   end function columns_of

   subroutine record_sensitivities(self, system, state, record, status)
      class(sensitivity_recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (self%n == size(self%t)) return
      self%n = self%n + 1
      self%t(self%n) = state%t
      self%theta(self%n) = self%tangent%theta(1, 2)
      self%momentum(self%n) = self%tangent%momentum(3, 1)
   end subroutine record_sensitivities

   !> A row inside of the third step: two whole steps and a part of one.
   subroutine sensitivities_inside(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      class(run_t), allocatable :: run
      type(sensitivity_recorder_t) :: recorder
      type(status_t) :: status
      type(tangent_t) :: tangent
      type(state_t) :: state, before
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: lengths(3) = [0.1_wp, 0.1_wp, 0.037_wp]
      integer :: i
      allocate (run)
      problem => forced_body()
      plan%time_step = 0.1_wp
      plan%end_time = 0.5_wp
      plan%times = [0.0_wp, 0.03_wp, 0.237_wp, 0.3_wp, 0.5_wp]
      recorder%wants_tangent = .true.
      call run%begin(problem%system, of_order_four, problem%start, plan, status)
      call run%differentiate(columns_of(), problem%system, status)
      if (status%ok()) call run%run_to_end(problem%system, status, recorder)
      call check(error, status%ok(), trim(status%message))
      call check(error, recorder%n, 5, 'rows')
      if (allocated(error)) return
      state = problem%start
      call make_stepper(problem%system, of_order_four, stepper, status)
      call tangent%begin(problem%system, state, columns_of(), status)
      do i = 1, 3
         before = state
         ! The middle of the whole step decides which torques act.
         call stepper%advance(problem%system, state, lengths(i), before%t + 0.05_wp, status)
         call stepper%propagate(problem%system, before, state, lengths(i), before%t + 0.05_wp, tangent, status)
         call check(error, status%ok(), trim(status%message))
      end do
      call check_close(error, recorder%theta(3), tangent%theta(1, 2), 1e-13_wp, 'theta inside')
      call check_close(error, recorder%momentum(3), tangent%momentum(3, 1), 1e-12_wp, 'momentum inside')
      call check_close(error, recorder%theta(5), run%tangent%theta(1, 2), 1e-15_wp, 'theta at the end')
      call check(error, abs(recorder%theta(1)) <= 0.0_wp, 'theta at the start')
   end subroutine sensitivities_inside

   !> Steps of an error: columns agree with those of short steps of order 8, rows inside included.
   subroutine propagate_adaptive(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      class(run_t), allocatable :: run, reference
      type(sensitivity_recorder_t) :: recorder, expected
      type(integrator_settings_t) :: best
      type(status_t) :: status
      integer :: i
      allocate (run, reference)
      problem => forced_body()
      plan%end_time = 1.0_wp
      plan%times = [0.1_wp, 0.33_wp, 0.77_wp, 1.0_wp]
      plan%goal%local_tolerance = 1e-9_wp
      recorder%wants_tangent = .true.
      call run%begin(problem%system, of_order_four, problem%start, plan, status)
      if (status%ok()) call run%differentiate(columns_of(), problem%system, status)
      if (status%ok()) call run%run_to_end(problem%system, status, recorder)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      plan%goal%local_tolerance = 0.0_wp
      plan%time_step = 0.01_wp
      expected%wants_tangent = .true.
      best = of_order_four
      best%order = 8
      call reference%begin(problem%system, best, problem%start, plan, status)
      if (status%ok()) call reference%differentiate(columns_of(), problem%system, status)
      if (status%ok()) call reference%run_to_end(problem%system, status, expected)
      call check(error, status%ok(), trim(status%message))
      call check(error, recorder%n, 4, 'rows')
      do i = 1, 4
         call check_close(error, recorder%theta(i), expected%theta(i), 1e-6_wp, 'theta')
         call check_close(error, recorder%momentum(i), expected%momentum(i), 1e-5_wp, 'momentum')
      end do
   end subroutine propagate_adaptive

   !> A box that turns about its middle axis, by explicit methods and series: the motion alone allows steps in which
   !> columns, which grow e-fold in a sixth of a second, are followed badly or not at all.
   subroutine keep_tolerance(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: names(4) = [character(len=8) :: 'taylor', 'dop853', 'rk8', 'rk4']
      real(wp), parameter :: tolerances(3) = [1e-4_wp, 1e-7_wp, 1e-10_wp]
      class(run_t), allocatable :: run, bare, exact
      type(run_plan_t) :: plan
      type(system_t), pointer :: system
      type(state_t) :: start
      type(status_t) :: status
      real(wp) :: off
      integer :: i, m
      system => new_system()
      allocate (run, bare, exact)
      call make_body(diagonal([5.0_wp, 20.0_wp, 17.0_wp]), system%body, status)
      start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 10.0_wp])
      plan%end_time = 2.0_wp
      plan%goal%local_tolerance = 1e-10_wp
      call follow(exact, 'exact', .true.)
      do m = 1, size(names)
         do i = 1, merge(2, 3, names(m) == 'rk4')
            plan%goal%local_tolerance = tolerances(i)
            call follow(run, names(m), .true.)
            call follow(bare, names(m), .false.)
            if (allocated(error)) return
            off = exact%tangent%relative(run%tangent%theta - exact%tangent%theta, run%tangent%momentum - &
                                         exact%tangent%momentum, norm2(body_momentum(start)))
            call check_below(error, off, tolerances(i)*run%summary%parts, trim(names(m))//': columns')
            call check(error, run%summary%parts > bare%summary%parts .or. m > 2 .and. run%summary%parts >= &
                       bare%summary%parts, trim(names(m))//': shorter steps')
         end do
      end do

   contains

      subroutine follow(run, method, differentiated)
         type(run_t), intent(out) :: run
         character(len=*), intent(in) :: method
         logical, intent(in) :: differentiated
         call run%begin(system, integrator_settings_t(method=method), start, plan, status)
         if (status%ok() .and. differentiated) call run%differentiate(columns_of(), system, status)
         if (status%ok()) call run%run_to_end(system, status)
         call check(error, status%ok(), trim(method)//': '//trim(status%message))
      end subroutine follow

   end subroutine keep_tolerance

   !> A run from its checkpoint on ends with the columns of one that was not interrupted, bit by bit: of adaptive steps,
   !> and of so many fixed ones that round-off is removed from the columns.
   subroutine resume_sensitivities(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      plan%end_time = 1.0_wp
      plan%goal%local_tolerance = 1e-8_wp
      call resume_one(error, forced_body(), plan)
      if (allocated(error)) return
      plan = run_plan_t(end_time=1.0_wp, time_step=1.0_wp/(5*kept_steps))
      call resume_one(error, box(), plan)
   end subroutine resume_sensitivities

   !> Checks the resumption of a run of one body.
   subroutine resume_one(error, problem, plan)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(run_plan_t), intent(in) :: plan
      class(run_t), allocatable :: whole, broken, resumed
      type(sensitivity_recorder_t) :: recorder
      type(byte_archive_t) :: archive
      type(status_t) :: status
      allocate (whole, broken, resumed)
      recorder%wants_tangent = .true.
      call begin(whole)
      if (status%ok()) call whole%run_to_end(problem%system, status, recorder)
      call check(error, status%ok(), trim(status%message))
      recorder%stops_at = recorder%polls/2
      recorder%polls = 0
      call begin(broken)
      if (status%ok()) call broken%run_to_end(problem%system, status, recorder)
      call check(error, status%code, NUTATE_STOPPED, 'the run is stopped')
      call check(error, allocated(recorder%archive), 'a checkpoint is kept')
      if (allocated(error)) return
      call archive%begin_reading(recorder%archive)
      call begin(resumed)
      if (status%ok()) call resumed%resume(archive, status)
      if (status%ok()) call resumed%run_to_end(problem%system, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, maxval(abs(resumed%tangent%theta - whole%tangent%theta)) <= 0.0_wp, 'theta')
      call check(error, maxval(abs(resumed%tangent%momentum - whole%tangent%momentum)) <= 0.0_wp, 'momentum')

   contains

      subroutine begin(run)
         type(run_t), intent(inout) :: run
         call run%begin(problem%system, of_order_four, problem%start, plan, status)
         if (status%ok()) call run%differentiate(columns_of(), problem%system, status)
      end subroutine begin

   end subroutine resume_one

   !> A controller that samples, a rate of axes that stand still, columns that a run does not carry, steps without the
   !> projection.
   subroutine refuse(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(tangent_t) :: tangent
      class(run_t), allocatable :: run
      type(run_plan_t) :: plan
      type(integrator_settings_t) :: settings
      type(status_t) :: status
      type(system_t) :: sampled
      type(state_t) :: state
      type(variation_t) :: frame
      allocate (run)
      problem => forced_body()
      sampled = problem%system
      call sampled%effects%add(controller_t(name='controller', sample=0.1_wp))
      call tangent%begin(sampled, problem%start, columns_of(), status)
      call check(error, index(status%message, 'a controller that samples') > 0, trim(status%message))
      plan%time_step = 0.1_wp
      plan%end_time = 0.5_wp
      frame%name = 'rotating_frame.rate'
      frame%frame = [0.0_wp, 0.0_wp, 1.0_wp]
      call run%begin(problem%system, of_order_four, problem%start, plan, status)
      if (status%ok()) call run%differentiate([frame], problem%system, status)
      call check(error, index(status%message, 'only where they turn') > 0, 'frame: '//trim(status%message))
      call check(error, .not. allocated(run%tangent), 'no columns where they are refused')
      run%keeps_dense_output = .true.
      call run%run_steps(problem%system, 2_long, status)
      call check(error, status%ok(), 'a run without columns: '//trim(status%message))
      call run%state_at(problem%system, 0.15_wp, state, status, tangent)
      call check(error, index(status%message, 'propagates no sensitivities') > 0, 'state_at: '//trim(status%message))
      settings = integrator_settings_t(method='nielsen_krenk', formulation='full', projection=.false., &
                                       inverse_auxiliary_inertia=1.0_wp)
      call run%begin(problem%system, settings, problem%start, plan, status)
      if (status%ok()) call run%differentiate(columns_of(), problem%system, status)
      if (status%ok()) call run%run_to_end(problem%system, status)
      call check(error, index(status%message, 'the projection') > 0, trim(status%message))
   end subroutine refuse

end module test_tangent_runs
