!> Progress of a run: its state, its costs, and everything else that changes on the way except the steppers.
module nutate_progress
   use nutate_archive, only: archive_t
   use nutate_chaos, only: chaos_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event_tracker, only: event_tracker_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_run_plan, only: run_plan_t
   use nutate_summary, only: run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: progress_t, run_point_t, way_t, few_rows
   public :: start_run, take_back, sense_of, is_over, fraction_done, count_works, count_part, count_step, &
      end_of_step, conclude_run, total_work, put_works, add_works, transfer_progress, watch_limits

   !> Rows at intervals, and times that an event happens, that are never too many, however few steps are allowed: the
   !> rows that scenes have by default.
   integer(long), parameter :: few_rows = 1000_long

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

   interface

      !> Starts a run from a plan that was checked, and a first state. Errors: those of `check_attitude`.
      module subroutine start_run(self, effects, state, plan, status)
         type(progress_t), intent(inout) :: self
         type(effect_list_t), intent(in) :: effects
         type(state_t), intent(in) :: state
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
      end subroutine start_run

      !> Lets a run look for the events of limits, samples and control laws that jump, and for no others. Errors: those
      !> of the tracker.
      module subroutine watch_limits(self, system, status)
         !> Run that was started.
         type(progress_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(inout) :: status
      end subroutine watch_limits

      !> Takes a run back to where it was; the largest number of iterations includes those of the steps taken back.
      module subroutine take_back(self, mark)
         type(progress_t), intent(inout) :: self
         type(run_point_t), intent(in) :: mark
      end subroutine take_back

      !> Returns true at the end of the run.
      pure logical module function is_over(self)
         type(progress_t), intent(in) :: self
      end function is_over

      !> Returns the direction of time in the run: 1 or -1.
      pure real(wp) module function sense_of(self) result(sense)
         type(progress_t), intent(in) :: self
      end function sense_of

      !> Returns the fraction of the run that is done, 0 to 1.
      pure real(wp) module function fraction_done(self)
         !> Run that is not over at its start.
         type(progress_t), intent(in) :: self
      end function fraction_done

      !> Returns the time at which a nominal step ends, s, unless it is the last one and shorter.
      pure real(wp) module function end_of_step(self, step) result(t)
         type(progress_t), intent(in) :: self
         !> Number of steps done then.
         integer(long), intent(in) :: step
      end function end_of_step

      !> Accounts for a step of the method that succeeded.
      module subroutine count_part(self, stepper)
         type(progress_t), intent(inout) :: self
         class(stepper_t), intent(in) :: stepper
      end subroutine count_part

      !> Adds the works of the last step of a method.
      module subroutine count_works(self, stepper)
         type(progress_t), intent(inout) :: self
         class(stepper_t), intent(in) :: stepper
      end subroutine count_works

      !> Accounts for a whole step, its parts counted already.
      module subroutine count_step(self)
         type(progress_t), intent(inout) :: self
      end subroutine count_step

      !> Returns the work of all torques, and of switched potentials, J.
      pure real(wp) module function total_work(self)
         type(run_summary_t), intent(in) :: self
      end function total_work

      !> Puts the works so far into a record.
      pure module subroutine put_works(self, record)
         type(run_summary_t), intent(in) :: self
         type(run_record_t), intent(inout) :: record
      end subroutine put_works

      !> Adds works to those of a record, if it has them; not to their sum.
      pure module subroutine add_works(record, works)
         type(run_record_t), intent(inout) :: record
         !> J; shape (n_works).
         real(wp), intent(in) :: works(:)
      end subroutine add_works

      !> Returns state and summary at the end of a run.
      module subroutine conclude_run(self, state, summary)
         type(progress_t), intent(inout) :: self
         !> State of the run; unchanged if the run has not been started.
         type(state_t), intent(inout) :: state
         type(run_summary_t), intent(out), optional :: summary
      end subroutine conclude_run

      !> Writes or reads everything that changes on the way in checkpoint data.
      module subroutine transfer_progress(self, archive)
         !> Run that was started with the same plan and first state.
         type(progress_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_progress

   end interface

end module nutate_progress
