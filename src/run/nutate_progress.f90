!> Progress of a run: its state, its costs, and everything else that changes on the way except the steppers.
module nutate_progress
   use nutate_archive, only: archive_t
   use nutate_chaos, only: chaos_t
   use nutate_control, only: is_watched
   use nutate_effect_list, only: effect_list_t
   use nutate_event_tracker, only: event_list_t, event_tracker_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_run_plan, only: run_plan_t
   use nutate_range, only: check_attitude
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: progress_t, run_point_t, run_summary_t, way_t, few_rows
   public :: start_run, take_back, sense_of, is_over, fraction_done, count_works, count_part, count_step, &
      end_of_step, conclude_run, total_work, put_works, add_works, transfer_progress, watch_limits

   !> Rows at intervals, and times that an event happens, that are never too many, however few steps are allowed: the
   !> rows that scenes have by default.
   integer(long), parameter :: few_rows = 1000_long

   !> Summary of a run.
   type :: run_summary_t
      !> Steps done, fixed or adaptive.
      integer(long) :: steps = 0
      !> Fixed steps that were subdivided because they failed; adaptive steps that were rejected.
      integer(long) :: subdivided_steps = 0
      !> Steps of the method, with the parts of subdivided steps.
      integer(long) :: parts = 0
      !> Newton iterations in total, and the largest number in one step.
      integer(long) :: iterations = 0
      integer :: most_iterations = 0
      !> Steps in which a root was accepted without certification (`nutate_continuation`).
      integer(long) :: uncertified_steps = 0
      !> Work of each torque, and of each wheel motor and friction, J; shape (n_works).
      real(wp), allocatable :: work(:)
      !> Change of energy by switching potentials on and off, J.
      real(wp) :: switch_work = 0.0_wp
      !> Estimated attitude error at the end time of a run with an accuracy, rad, from its trial runs; above the
      !> accuracy if that is not attainable; part of it due to round-off, whatever the steps.
      real(wp) :: estimate = 0.0_wp, round_off = 0.0_wp
      !> The part of the estimate due to the distance of the lines in tables of orbits, rad.
      real(wp) :: table_error = 0.0_wp
      !> Settings of the run, given or chosen; reason for the method, in a few words, if it was chosen.
      type(integrator_settings_t) :: settings = integrator_settings_t()
      character(len=112) :: choice = ''
      !> Indicators of chaos, if the run follows any, by the last of its sensitivities.
      type(chaos_t), allocatable :: chaos
   contains
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_summary
   end type run_summary_t

   !> Progress within a fixed step that is performed in parts.
   type :: way_t
      !> The step has begun.
      logical :: begun = .false.
      !> Number of parts at the end of the step, if none has to be subdivided.
      integer(long) :: parts = 0
      !> Level of a piece that failed and is subdivided into 2**level parts, 0: not subdivided; number of its parts
      !> done.
      integer :: level = 0, done = 0
      !> Start and length of the subdivided piece, s.
      real(wp) :: start = 0.0_wp, length = 0.0_wp
   end type way_t

   !> Everything that a step of the method changes: a copy of it takes the step back.
   type :: run_point_t
      !> Current state and record.
      type(state_t) :: state
      type(run_record_t) :: record
      type(run_summary_t) :: summary
      type(way_t) :: way
      !> The next time at which a step must end, since a torque starts or stops there or changes its law, s; beyond all
      !> times if there is none.
      real(wp) :: next_break = huge(1.0_wp)
      !> Compensation of the rounding of `summary%work`, J.
      real(wp), allocatable :: work_compensation(:)
   end type run_point_t

   !> Progress of a run.
   type, extends(run_point_t) :: progress_t
      !> The plan, with the local tolerance that trial runs have found.
      type(run_plan_t) :: plan
      !> First time of the run, s: fixed steps end at whole numbers of steps after it.
      real(wp) :: t_first = 0.0_wp
      !> Steps done at the end of the plan, negative if steps are adaptive; steps done before its first output point.
      integer(long) :: n_steps = -1, first_step = 0
      !> Number of steps of the whole run, if trial runs have found it; else 0.
      integer(long) :: expected_steps = 0
      !> Output points at intervals, or at times of the plan, so far.
      integer(long) :: rows = 0
      !> The run was resumed from checkpoint data, after its first output point.
      logical :: resumed = .false.
      !> Events, if the run has any.
      type(event_tracker_t), allocatable :: events
      !> Keep the start of the next step, for its dense output; and that of the last step when the run has stopped.
      logical :: keeps_starts = .true., keeps_dense_output = .false.
      !> Compensation of the rounding of `switch_work`, J.
      real(wp) :: switch_compensation = 0.0_wp
      !> Sensitivities, if the run propagates any, and those at the start of the last step.
      type(tangent_t), allocatable :: tangent, last_tangent
      !> Indicators of chaos, if the run follows any, at the start of the last step.
      type(chaos_t), allocatable :: last_chaos
      !> Start of the last step in which sensitivities may have passed the start or stop of a torque, s.
      real(wp) :: windows_since = 0.0_wp
      !> Length of the last step of a stepper, as requested from it, s.
      real(wp) :: last_length = 0.0_wp
   end type progress_t

contains

   !> Starts a run from a plan and a first state. Errors: `NUTATE_BAD_ARGUMENT`; those of `check_attitude`.
   subroutine start_run(self, effects, state, plan, status)
      type(progress_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      if (plan%every < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'rows are at least one step apart')
         return
      end if
      call check_attitude(state%q, status)
      if (.not. status%ok()) return
      self%plan = plan
      self%state = state
      self%record = run_record_t()
      self%summary = run_summary_t()
      self%t_first = state%t
      if (plan%steps_before > 0) self%t_first = plan%first_time
      self%n_steps = -1
      self%first_step = 0
      self%expected_steps = 0
      self%rows = 0
      self%resumed = .false.
      self%way = way_t()
      self%keeps_starts = .true.
      self%switch_compensation = 0.0_wp
      if (allocated(self%events)) deallocate (self%events)
      if (allocated(self%tangent)) deallocate (self%tangent, self%last_tangent)
      if (allocated(self%last_chaos)) deallocate (self%last_chaos)
      if (allocated(self%work_compensation)) deallocate (self%work_compensation)
      allocate (self%summary%work(effects%n_works()), self%work_compensation(effects%n_works()), source=0.0_wp)
      self%next_break = effects%next_break(state%t, sign(1.0_wp, plan%end_time - state%t))
   end subroutine start_run

   !> Lets a run look for the events of limits, samples and control laws that jump, and for no others. Errors: those of
   !> the tracker.
   subroutine watch_limits(self, system, status)
      !> Run that was started.
      type(progress_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      if (.not. is_watched(system%effects)) return
      allocate (self%events)
      call self%events%begin(event_list_t(), system, self%state, status)
   end subroutine watch_limits

   !> Takes a run back to where it was; the largest number of iterations includes those of the steps taken back.
   subroutine take_back(self, mark)
      type(progress_t), intent(inout) :: self
      type(run_point_t), intent(in) :: mark
      integer :: most_iterations
      most_iterations = self%summary%most_iterations
      self%run_point_t = mark
      self%summary%most_iterations = most_iterations
   end subroutine take_back

   !> Returns true at the end of the run.
   pure logical function is_over(self)
      type(progress_t), intent(in) :: self
      if (self%n_steps >= 0) then
         is_over = self%summary%steps >= self%n_steps
      else
         is_over = .not. abs(self%plan%end_time - self%state%t) > 0.0_wp
      end if
   end function is_over

   !> Returns the direction of time in the run: 1 or -1.
   pure real(wp) function sense_of(self) result(sense)
      type(progress_t), intent(in) :: self
      sense = sign(1.0_wp, self%plan%end_time - self%t_first)
   end function sense_of

   !> Returns the fraction of the run that is done, 0 to 1.
   pure real(wp) function fraction_done(self)
      !> Run that is not over at its start.
      type(progress_t), intent(in) :: self
      if (self%n_steps >= 0) then
         fraction_done = real(self%summary%steps - self%first_step, wp)/real(self%n_steps - self%first_step, wp)
      else
         fraction_done = (self%state%t - self%t_first)/(self%plan%end_time - self%t_first)
      end if
   end function fraction_done

   !> Returns the time at which a nominal step ends, s, unless it is the last one and shorter.
   pure real(wp) function end_of_step(self, step) result(t)
      type(progress_t), intent(in) :: self
      !> Number of steps done then.
      integer(long), intent(in) :: step
      t = self%t_first + real(self%plan%steps_before + step, wp)*self%plan%time_step
   end function end_of_step

   !> Accounts for a step of the method that succeeded.
   subroutine count_part(self, stepper)
      type(progress_t), intent(inout) :: self
      class(stepper_t), intent(in) :: stepper
      self%summary%parts = self%summary%parts + 1
      self%record%iterations = self%record%iterations + stepper%iterations
      self%record%uncertified = self%record%uncertified + stepper%uncertified
      self%record%residual = max(self%record%residual, stepper%residual)
      call count_works(self, stepper)
   end subroutine count_part

   !> Adds the works of the last step of a method.
   subroutine count_works(self, stepper)
      type(progress_t), intent(inout) :: self
      class(stepper_t), intent(in) :: stepper
      integer :: i
      do i = 1, size(stepper%work)
         call add_increment(self%summary%work(i), self%work_compensation(i), stepper%work(i))
      end do
   end subroutine count_works

   !> Accounts for a whole step, its parts counted already.
   subroutine count_step(self)
      type(progress_t), intent(inout) :: self
      self%summary%steps = self%summary%steps + 1
      self%summary%iterations = self%summary%iterations + self%record%iterations
      self%summary%most_iterations = max(self%summary%most_iterations, self%record%iterations)
      if (self%record%uncertified > 0) self%summary%uncertified_steps = self%summary%uncertified_steps + 1
      self%record%step = self%summary%steps
   end subroutine count_step

   !> Returns the work of all torques, and of switched potentials, J.
   pure real(wp) function total_work(self)
      type(run_summary_t), intent(in) :: self
      total_work = sum(self%work) + self%switch_work
   end function total_work

   !> Puts the works so far into a record.
   pure subroutine put_works(self, record)
      type(run_summary_t), intent(in) :: self
      type(run_record_t), intent(inout) :: record
      record%work = total_work(self)
      if (allocated(record%works)) record%works(:) = [self%work, self%switch_work]
   end subroutine put_works

   !> Adds works to those of a record, if it has them; not to their sum.
   pure subroutine add_works(record, works)
      type(run_record_t), intent(inout) :: record
      !> J; shape (n_works).
      real(wp), intent(in) :: works(:)
      if (allocated(record%works)) record%works(:size(works)) = record%works(:size(works)) + works
   end subroutine add_works

   !> Returns state and summary at the end of a run.
   subroutine conclude_run(self, state, summary)
      type(progress_t), intent(inout) :: self
      !> State of the run; unchanged if the run has not been started.
      type(state_t), intent(inout) :: state
      type(run_summary_t), intent(out), optional :: summary
      real(wp), allocatable :: work(:)
      if (.not. allocated(self%summary%work)) return
      state = self%state
      if (.not. present(summary)) return
      ! The work is moved: a copy of it would be one more allocation in every call of NUSTEP.
      call move_alloc(self%summary%work, work)
      summary = self%summary
      call move_alloc(work, summary%work)
   end subroutine conclude_run

   !> Writes or reads everything that changes on the way in checkpoint data.
   subroutine transfer_progress(self, archive)
      !> Run that was started with the same plan and first state.
      type(progress_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%state%transfer(archive)
      call self%state%transfer_wheels(archive)
      call self%state%balance%transfer(archive)
      call self%summary%transfer(archive)
      call self%record%transfer(archive)
      call archive%transfer(self%plan%goal%local_tolerance)
      call archive%transfer(self%next_break)
      call archive%transfer(self%work_compensation)
      call archive%transfer(self%rows)
      call archive%transfer(self%way%begun)
      call archive%transfer(self%way%parts)
      call archive%transfer(self%way%level)
      call archive%transfer(self%way%done)
      call archive%transfer(self%way%start)
      call archive%transfer(self%way%length)
      if (allocated(self%tangent)) call self%tangent%transfer(archive)
      if (allocated(self%summary%chaos)) call self%summary%chaos%transfer(archive)
      if (.not. allocated(self%events)) return
      call archive%transfer(self%summary%switch_work)
      call archive%transfer(self%switch_compensation)
      call self%events%transfer(archive)
      if (allocated(self%tangent)) call self%events%transfer_changes(self%tangent%n, archive)
   end subroutine transfer_progress

   !> Writes or reads its values in checkpoint data.
   subroutine transfer_summary(self, archive)
      !> Summary whose `work` is allocated.
      class(run_summary_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%steps)
      call archive%transfer(self%subdivided_steps)
      call archive%transfer(self%parts)
      call archive%transfer(self%iterations)
      call archive%transfer(self%most_iterations)
      call archive%transfer(self%uncertified_steps)
      call archive%transfer(self%work)
      call archive%transfer(self%estimate)
      call archive%transfer(self%round_off)
      call archive%transfer(self%table_error)
   end subroutine transfer_summary

end module nutate_progress
