!> Resumption from an archive, bitwise identical to an uninterrupted run: steppers of every row of the table of methods,
!> runs with fixed steps and with adaptive steps.
module test_resume
   use nutate_applied_torque, only: applied_torque_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: integrator_settings_t, make_stepper, method_t, methods, stepper_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, run_record_t, run_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_STEP_LIMIT, NUTATE_STOPPED, status_t
   use test_problems, only: box, bruls_top, forced_body, problem_t, system_t, total_energy
   use test_stopping_observer, only: stopping_observer_t
   use test_support, only: check, check_close, error_type, in_turn, new_unittest, one_in, test_failed, unittest_type
   implicit none
   private
   public :: collect_resume, check_balance, check_run, check_stepper, label_of, run_steps, settings_of

   !> Keeps all rows as bytes, and the last archive with the rows until then.
   type, extends(stopping_observer_t) :: recorder_t
      character(len=:), allocatable :: rows
      integer :: rows_kept = 0
      !> Steps that had to be subdivided.
      integer(long) :: subdivided_steps = 0
   contains
      procedure :: observe => record_row
      procedure :: save_checkpoint => keep_archive
   end type recorder_t

   !> A method that does not say what it remembers.
   type, extends(stepper_t) :: forgetful_t
   contains
      procedure :: set_up => prepare_nothing
      procedure :: advance => step_nowhere
   end type forgetful_t

contains

   subroutine collect_resume(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("steppers of all methods go on bit for bit", steppers_go_on), &
                  new_unittest("so they do after other lengths and failures", steppers_go_on_after_trouble), &
                  new_unittest("so they do without attitude", steppers_go_on_without_attitude), &
                  new_unittest("runs of all methods go on bit for bit", runs_go_on), &
                  new_unittest("so they do with windows of torques", runs_go_on_with_windows), &
                  new_unittest("so they do with subdivided steps", runs_go_on_with_subdivided_steps), &
                  new_unittest("controlled runs of all methods go on bit for bit", controlled_runs_go_on), &
                  new_unittest("so they do with rows at intervals, backwards", controlled_runs_go_on_with_intervals), &
                  new_unittest("a poll can ask for an archive and stop", a_poll_can_ask_and_stop), &
                  new_unittest("runs by a stepper that is lent go on", lent_steppers_go_on), &
                  new_unittest("an archive of another run is refused", another_run_is_refused), &
                  new_unittest("a method that does not list what it remembers is refused", forgetful_refused)]
   end subroutine collect_resume

   !> The bytes of a state and a record.
   function bytes_of(state, record) result(bytes)
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      character(len=:), allocatable :: bytes
      type(byte_archive_t) :: archive
      type(state_t) :: a_state
      type(run_record_t) :: a_record
      a_state = state
      a_record = record
      call archive%begin_writing()
      call a_state%transfer(archive)
      call a_state%transfer_wheels(archive)
      call a_record%transfer(archive)
      bytes = archive%content()
   end function bytes_of

   !> The bytes of all that a stepper shows to an archive.
   function remembered_by(stepper) result(bytes)
      class(stepper_t), intent(inout) :: stepper
      character(len=:), allocatable :: bytes
      type(byte_archive_t) :: archive
      call archive%begin_writing()
      call stepper%transfer(archive)
      bytes = archive%content()
      if (archive%problem() /= '') bytes = ''
   end function remembered_by

   subroutine keep_archive(self, archive, status)
      class(recorder_t), intent(inout) :: self
      type(byte_archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      self%archive = archive%content()
      if (.not. allocated(self%rows)) self%rows = ''
      self%rows_kept = len(self%rows)
   end subroutine keep_archive

   subroutine record_row(self, system, state, record, status)
      class(recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. allocated(self%rows)) self%rows = ''
      self%rows = self%rows//bytes_of(state, record)
   end subroutine record_row

   !> Runs with fixed steps to an end.
   subroutine run_steps(error, problem, settings, step, end_time, state, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> s.
      real(wp), intent(in) :: step, end_time
      type(state_t), intent(out) :: state
      character(len=*), intent(in) :: label
      type(status_t) :: status
      state = problem%start
      call integrate(problem%system, settings, state, run_plan_t(time_step=step, end_time=end_time), status)
      call check(error, status%ok(), label//': '//trim(status%message))
   end subroutine run_steps

   !> Checks the energy less the works of conserving methods, after a thousand steps of 0.05 s.
   subroutine check_balance(error, problem, method, state)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(method_t), intent(in) :: method
      type(state_t), intent(out) :: state
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      real(wp) :: energy, work
      integer :: n
      energy = total_energy(problem%system, problem%start)
      call make_stepper(problem%system, settings_of(method), stepper, status)
      call check(error, status%ok(), trim(status%message))
      state = problem%start
      work = 0.0_wp
      do n = 1, 1000
         if (allocated(error)) return
         call stepper%step(problem%system, state, 0.05_wp, status)
         call check(error, status%ok(), label_of(method)//': '//trim(status%message))
         work = work + sum(stepper%work)
      end do
      call check_close(error, total_energy(problem%system, state) - work, energy, 300*eps*energy + 100*eps, &
                       label_of(method)//', energy')
   end subroutine check_balance

   !> Settings of a row of the table of methods; implicit steps of order 4 with the projection.
   pure type(integrator_settings_t) function settings_of(method) result(settings)
      type(method_t), intent(in) :: method
      settings%method = method%name
      settings%formulation = method%formulation
      settings%order = method%order
      settings%conserve = method%projected .or. method%can_project .and. method%order == 4
   end function settings_of

   function label_of(method) result(label)
      type(method_t), intent(in) :: method
      character(len=:), allocatable :: label
      label = trim(method%name)//": "//trim(method%equations)
   end function label_of

   !> A problem that a method can solve: with every kind of effect, or free.
   function problem_for(method) result(problem)
      type(method_t), intent(in) :: method
      type(problem_t), pointer :: problem
      problem => forced_body()
      if (method%name == 'exact') problem => box()
   end function problem_for

   !> `first` and then `rest` steps, with and without a change of steppers in between, end on the same bits.
   subroutine check_stepper(error, problem, settings, first, rest, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> Lengths of the steps, s.
      real(wp), intent(in) :: first(:), rest(:)
      character(len=*), intent(in) :: label
      class(stepper_t), allocatable :: stepper, fresh
      type(state_t) :: state, other
      type(status_t) :: status
      type(byte_archive_t) :: archive
      integer :: i
      call make_stepper(problem%system, settings, stepper, status)
      call make_stepper(problem%system, settings, fresh, status)
      call check(error, status%ok(), label)
      if (allocated(error)) return
      state = problem%start
      do i = 1, size(first)
         call stepper%step(problem%system, state, first(i), status)
      end do
      other = state
      call archive%begin_reading(remembered_by(stepper))
      call fresh%transfer(archive)
      call check(error, archive%problem() == '', label//": "//archive%problem())
      do i = 1, size(rest)
         if (allocated(error)) return
         call stepper%step(problem%system, state, rest(i), status)
         call fresh%step(problem%system, other, rest(i), status)
         call check(error, bytes_of(state, run_record_t()) == bytes_of(other, run_record_t()) .and. &
                    remembered_by(stepper) == remembered_by(fresh), label)
      end do
   end subroutine check_stepper

   subroutine steppers_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: moments(5) = [0, 1, 2, 5, 20]
      type(problem_t), pointer :: problem
      integer :: m, i, k
      do m = 1, size(methods)
         do k = 1, merge(1, 3, methods(m)%name == 'exact')
            problem => problem_for(methods(m))
            if (k == 2) problem => box()
            if (k > 1) call problem%system%effects%add(rotating_frame_t(rate=[0.3_wp, -0.5_wp, 0.4_wp]))
            do i = 1, size(moments)
               call check_stepper(error, problem, settings_of(methods(m)), &
                                  spread(0.01_wp, 1, moments(i)), spread(0.01_wp, 1, 12), label_of(methods(m)))
            end do
         end do
      end do
   end subroutine steppers_go_on

   !> Lengths that change before and after, and steps that are too long to be taken.
   subroutine steppers_go_on_after_trouble(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: first(7) = [0.01_wp, 0.01_wp, 50.0_wp, 0.01_wp, 0.01_wp, 0.01_wp, 0.02_wp]
      real(wp), parameter :: rest(6) = [0.02_wp, 0.02_wp, 0.015_wp, 60.0_wp, 0.015_wp, 0.015_wp]
      integer :: m, n
      do m = 1, size(methods)
         do n = 1, size(first)
            call check_stepper(error, problem_for(methods(m)), settings_of(methods(m)), first(1:n), rest, &
                               label_of(methods(m)))
         end do
      end do
   end subroutine steppers_go_on_after_trouble

   subroutine steppers_go_on_without_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t) :: settings
      integer :: m
      do m = 1, size(methods)
         settings = settings_of(methods(m))
         settings%attitude = .false.
         call check_stepper(error, box(), settings, spread(0.01_wp, 1, 5), spread(0.01_wp, 1, 5), &
                            label_of(methods(m)))
      end do
   end subroutine steppers_go_on_without_attitude

   !> One run, from an archive or from its start.
   subroutine run(problem, settings, plan, recorder, outcome, status, archived)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(recorder_t), intent(inout) :: recorder
      !> The bytes of the last state and of the summary.
      character(len=:), allocatable, intent(out) :: outcome
      type(status_t), intent(out) :: status
      character(len=*), intent(in), optional :: archived
      type(byte_archive_t) :: resumed, account
      class(run_t), allocatable :: a_run
      allocate (a_run)
      call a_run%begin(problem%system, settings, problem%start, plan, status)
      if (present(archived)) then
         call resumed%begin_reading(archived)
         call a_run%resume(resumed, status)
      end if
      if (status%ok()) call a_run%run_to_end(problem%system, status, recorder)
      outcome = outcome_of(a_run)
      recorder%subdivided_steps = a_run%summary%subdivided_steps
   end subroutine run

   !> The bytes of the last state of a run and of its summary.
   function outcome_of(run) result(bytes)
      type(run_t), intent(inout) :: run
      character(len=:), allocatable :: bytes
      type(byte_archive_t) :: account
      call account%begin_writing()
      call run%state%transfer(account)
      call run%state%transfer_wheels(account)
      call run%summary%transfer(account)
      bytes = account%content()
   end function outcome_of

   !> A run that stops again and again, and a copy of it, end as one that does not.
   subroutine check_stops(error, problem, settings, plan, stops, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> Plan with nominal steps; it ends with the last of them.
      type(run_plan_t), intent(in) :: plan
      !> Steps between two stops.
      integer, intent(in) :: stops(:)
      character(len=*), intent(in) :: label
      type(recorder_t) :: whole
      type(run_plan_t) :: endless
      class(run_t), allocatable :: run_1, run_2
      type(status_t) :: status
      character(len=:), allocatable :: wanted
      integer :: i
      if (allocated(error)) return
      call run(problem, settings, plan, whole, wanted, status)
      endless = run_plan_t(time_step=plan%time_step)
      allocate (run_1)
      call run_1%begin(problem%system, settings, problem%start, endless, status)
      do i = 1, size(stops)
         if (status%ok()) call run_1%run_steps(problem%system, int(stops(i), long), status)
         if (i == size(stops)/2) allocate (run_2, source=run_1)
      end do
      if (status%ok()) call run_1%run_to(problem%system, plan%end_time, status)
      call check(error, status%ok(), label//": "//trim(status%message))
      if (allocated(error)) return
      call check(error, outcome_of(run_1) == wanted, label//": stops leave a trace")
      ! The copy must not point to the run that is deallocated.
      deallocate (run_1)
      call run_2%run_to(problem%system, plan%end_time, status)
      call check(error, status%ok() .and. outcome_of(run_2) == wanted, label//": the copy goes another way")
   end subroutine check_stops

   !> A run that ends at a number of steps and goes on from there has the rows, the last state and the summary of one
   !> that was never interrupted.
   subroutine check_run(error, problem, settings, plan, limits, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      !> Numbers of steps to interrupt the run at; some of them, or with NUTATE_ONE_IN=1 all.
      integer, intent(in) :: limits(:)
      character(len=*), intent(in) :: label
      type(recorder_t) :: whole, begun, resumed
      type(run_plan_t) :: limited
      type(status_t) :: status
      character(len=:), allocatable :: wanted, outcome
      integer :: i
      call run(problem, settings, plan, whole, wanted, status)
      call check(error, status%ok(), label//": "//trim(status%message))
      do i = 1, size(limits), one_in()
         if (allocated(error)) return
         limited = plan
         limited%max_steps = limits(i)
         begun = recorder_t()
         begun%saves_at_step_limit = .true.
         call run(problem, settings, limited, begun, outcome, status)
         call check(error, status%code == NUTATE_STEP_LIMIT .and. allocated(begun%archive), label//": no limit reached")
         if (allocated(error)) return
         resumed = recorder_t()
         resumed%rows = begun%rows(1:begun%rows_kept)
         call run(problem, settings, plan, resumed, outcome, status, begun%archive)
         call check(error, status%ok(), label//": "//trim(status%message))
         call check(error, resumed%rows == whole%rows, label//": rows")
         call check(error, outcome == wanted, label//": last state or summary")
      end do
   end subroutine check_run

   subroutine runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: m
      do m = 1, size(methods)
         call check_run(error, problem_for(methods(m)), settings_of(methods(m)), &
                        run_plan_t(time_step=0.01_wp, end_time=0.403_wp, every=3_long), [1, 2, 5, 12, 39, 40], &
                        label_of(methods(m)))
         call check_stops(error, problem_for(methods(m)), settings_of(methods(m)), &
                          run_plan_t(time_step=0.01_wp, end_time=0.403_wp), [1, 2, 5, 0, 12, 3], label_of(methods(m)))
      end do
   end subroutine runs_go_on

   !> The top of Brüls with torques that start and stop between the ends of steps.
   function windowed_top() result(problem)
      type(problem_t), pointer :: problem
      problem => bruls_top()
      associate (effects => problem%system%effects)
         call effects%add(applied_torque_t(name='torque', amplitude=[3.0_wp, 0.0_wp, 1.0_wp], frequency=7.0_wp, &
                                           start=0.0103_wp, stop=0.0287_wp))
         call effects%add(applied_torque_t(name='torque', amplitude=[0.0_wp, -2.0_wp, 0.0_wp], in_space=.true., &
                                           start=0.0152_wp))
      end associate
   end function windowed_top

   subroutine runs_go_on_with_windows(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: limits(*) = [1, 9, 10, 11, 12, 16, 17, 18, 30, 31, 32, 40]
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         call check_run(error, windowed_top(), settings_of(methods(m)), &
                        run_plan_t(time_step=0.001_wp, end_time=0.045_wp), limits, &
                        label_of(methods(m)))
         call check_stops(error, windowed_top(), settings_of(methods(m)), &
                          run_plan_t(time_step=0.001_wp, end_time=0.045_wp), [10, 1, 4, 1, 13, 1], label_of(methods(m)))
      end do
   end subroutine runs_go_on_with_windows

   !> The box with steps that it cannot follow.
   subroutine runs_go_on_with_subdivided_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t), parameter :: plan = run_plan_t(time_step=0.6_wp, end_time=12.0_wp)
      type(recorder_t) :: recorder
      type(status_t) :: status
      character(len=:), allocatable :: outcome
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%name /= 'nielsen_krenk') cycle
         call run(box(), settings_of(methods(m)), plan, recorder, outcome, status)
         call check(error, recorder%subdivided_steps > 0, trim(methods(m)%equations)//": no step is subdivided")
         call check_run(error, box(), settings_of(methods(m)), plan, [1, 2, 3, 7, 12, 19], trim(methods(m)%equations))
         call check_stops(error, box(), settings_of(methods(m)), plan, [1, 2, 3, 7], trim(methods(m)%equations))
      end do
   end subroutine runs_go_on_with_subdivided_steps

   subroutine controlled_runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%order < 1 .or. .not. in_turn(m)) cycle
         call check_run(error, windowed_top(), settings_of(methods(m)), &
                        run_plan_t(end_time=0.15_wp, goal=run_goal_t(local_tolerance=1e-7_wp)), [1, 2, 3, 5, 8], &
                        label_of(methods(m)))
         call check_run(error, forced_body(), settings_of(methods(m)), &
                        run_plan_t(end_time=3.0_wp, every=2_long, goal=run_goal_t(error_rate=1e-6_wp)), [1, 2, 4], &
                        label_of(methods(m)))
      end do
   end subroutine controlled_runs_go_on

   subroutine controlled_runs_go_on_with_intervals(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t), parameter :: goal = run_goal_t(local_tolerance=1e-6_wp)
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%order < 1) cycle
         call check_run(error, windowed_top(), settings_of(methods(m)), &
                        run_plan_t(end_time=0.06_wp, interval=0.013_wp, goal=goal), [1, 2, 3, 6], label_of(methods(m)))
         call check_run(error, forced_body(), settings_of(methods(m)), &
                        run_plan_t(end_time=-1.0_wp, interval=0.27_wp, goal=goal), [1, 2, 3], label_of(methods(m)))
      end do
   end subroutine controlled_runs_go_on_with_intervals

   !> The archive of a poll holds the rows before it, and the run ends with the poll's status. The results of trial runs
   !> are in the archive.
   subroutine a_poll_can_ask_and_stop(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t), parameter :: goals(3) = [run_goal_t(), run_goal_t(local_tolerance=1e-8_wp), &
                                                 run_goal_t(accuracy=1e-5_wp)]
      type(integrator_settings_t), parameter :: settings = integrator_settings_t(formulation='reduced')
      type(run_plan_t) :: plan
      type(recorder_t) :: whole, begun, resumed
      type(status_t) :: status
      character(len=:), allocatable :: wanted, outcome
      integer :: i
      plan = run_plan_t(time_step=0.001_wp, end_time=4.0_wp, every=7_long)
      do i = 1, size(goals)
         plan%goal = goals(i)
         whole = recorder_t()
         call run(forced_body(), settings, plan, whole, wanted, status)
         begun = recorder_t()
         begun%stops_at = 3
         call run(forced_body(), settings, plan, begun, outcome, status)
         call check(error, status%code == NUTATE_STOPPED .and. allocated(begun%archive), "stopped")
         if (allocated(error)) return
         resumed = recorder_t()
         resumed%rows = begun%rows
         call run(forced_body(), settings, plan, resumed, outcome, status, begun%archive)
         call check(error, resumed%rows == whole%rows .and. outcome == wanted)
      end do
   end subroutine a_poll_can_ask_and_stop

   !> An archive of another method, another problem, or with a part missing.
   subroutine another_run_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t), parameter :: plan = run_plan_t(time_step=0.01_wp, end_time=1.0_wp)
      type(integrator_settings_t), parameter :: reduced = integrator_settings_t(formulation='reduced')
      type(recorder_t) :: recorder
      type(status_t) :: status
      character(len=:), allocatable :: outcome
      type(run_plan_t) :: limited, chosen
      limited = plan
      limited%max_steps = 5
      recorder%saves_at_step_limit = .true.
      call run(forced_body(), integrator_settings_t(), limited, recorder, outcome, status)
      call run(forced_body(), reduced, plan, recorder, outcome, status, recorder%archive)
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "another method")
      call run(box(), integrator_settings_t(), plan, recorder, outcome, status, recorder%archive)
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "another problem")
      call run(forced_body(), integrator_settings_t(), plan, recorder, outcome, status, &
               recorder%archive(1:len(recorder%archive) - 1))
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "cut short")
      chosen = plan
      chosen%goal%local_tolerance = 1e-3_wp
      call run(forced_body(), integrator_settings_t(), chosen, recorder, outcome, status, recorder%archive)
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "fixed steps for steps by their error")
      chosen%max_steps = 5
      call run(forced_body(), integrator_settings_t(order=2), chosen, recorder, outcome, status)
      call run(forced_body(), integrator_settings_t(), plan, recorder, outcome, status, recorder%archive)
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "steps by their error for fixed steps")
   end subroutine another_run_is_refused

   !> A run by a stepper that stays the program's, as one of a method of its own: interrupted, it goes on with another
   !> one that was prepared in the same way.
   subroutine lent_steppers_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t), parameter :: settings = integrator_settings_t(formulation='reduced')
      class(stepper_t), allocatable, target :: first, second
      type(problem_t), pointer :: problem
      type(recorder_t) :: whole, begun, resumed
      type(byte_archive_t) :: archive
      type(run_plan_t) :: plan
      class(run_t), allocatable :: run_1, run_2
      type(status_t) :: status
      character(len=:), allocatable :: wanted
      allocate (run_1, run_2)
      problem => forced_body()
      plan = run_plan_t(time_step=0.01_wp, end_time=0.5_wp)
      call run(problem, settings, plan, whole, wanted, status)
      call make_stepper(problem%system, settings, first, status)
      call make_stepper(problem%system, settings, second, status)
      begun%saves_at_step_limit = .true.
      plan%max_steps = 20
      call run_1%begin(problem%system, first, problem%start, plan, status)
      call run_1%run_to_end(problem%system, status, begun)
      call check(error, status%code, NUTATE_STEP_LIMIT)
      plan%max_steps = huge(plan%max_steps)
      resumed%rows = begun%rows
      call run_2%begin(problem%system, second, problem%start, plan, status)
      call archive%begin_reading(begun%archive)
      call run_2%resume(archive, status)
      if (status%ok()) call run_2%run_to_end(problem%system, status, resumed)
      call check(error, status%ok() .and. resumed%rows == whole%rows, trim(status%message))
      if (allocated(error)) return
      plan%goal%local_tolerance = 1e-8_wp
      call run_2%begin(problem%system, second, problem%start, plan, status)
      call check(error, status%code == NUTATE_BAD_ARGUMENT, "steps by their error from one stepper")
   end subroutine lent_steppers_go_on

   subroutine forgetful_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(forgetful_t) :: stepper
      type(byte_archive_t) :: archive
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => box()
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      call archive%begin_writing()
      call stepper%transfer(archive)
      if (archive%problem() == '') call test_failed(error, "the archive says nothing")
   end subroutine forgetful_refused

   subroutine prepare_nothing(self, system, settings, status)
      class(forgetful_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
   end subroutine prepare_nothing

   subroutine step_nowhere(self, system, state, dt, window_time, status)
      class(forgetful_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      state%t = state%t + dt
   end subroutine step_nowhere

end module test_resume
