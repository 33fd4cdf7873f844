!> Runs members of an ensemble, tops several at a time, and fills their rows. A row depends on scene, seed and member
!> alone.
module nutate_member_run
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_columns, only: columns_t
   use nutate_event_history, only: event_history_t
   use nutate_history, only: history_t
   use nutate_kinds, only: wp, long
   use nutate_member, only: member_t
   use nutate_member_tops, only: find_top, state_of_top
   use nutate_member_watcher, only: poll_stride, member_watcher_t, sweep_asker_t
   use nutate_progress, only: put_works
   use nutate_row_layout, only: bits_of, row_layout_t
   use nutate_run, only: run_record_t, run_t, system_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_IO, NUTATE_STOPPED
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_text_lock, only: lock_texts, unlock_texts
   use nutate_tops, only: top_t, tops_t
   implicit none
   private

   public :: member_run_t

   !> Largest local tolerance of tops that are run together, rad: beyond it their series are of low orders.
   real(wp), parameter :: loosest = 1e-3_wp
   !> Steps of tops between two polls: some milliseconds.
   integer, parameter :: steps_between_polls = 1024

   !> Runner of members; each thread has its own.
   type :: member_run_t
      type(member_t) :: member
      type(row_layout_t) :: layout
      type(member_watcher_t) :: watcher
      !> Run of the last member, whose stepper serves the next one.
      type(run_t), private :: run
   contains
      !> Prepares for a scene with an ensemble.
      procedure :: prepare
      !> Runs a member and fills its row.
      procedure :: row
      !> Runs several members at a time, if they are tops.
      procedure :: run_tops
   end type member_run_t

contains

   !> Prepares for a scene with an ensemble. Errors: a set of columns that does not exist.
   subroutine prepare(self, scene, layout, status, sweep)
      class(member_run_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      !> Row layout of the scene.
      type(row_layout_t), intent(in) :: layout
      type(status_t), intent(out) :: status
      !> Watcher that the runs poll.
      class(sweep_watcher_t), intent(in), target, optional :: sweep
      call lock_texts()
      self%layout = layout
      call self%member%prepare(scene)
      call self%watcher%columns%choose(scene%output%columns, status, scene%output%degrees, scene%system%effects)
      call unlock_texts()
      if (present(sweep)) self%watcher%sweep => sweep
   end subroutine prepare

   !> Runs a member and fills its row, which also reports failures of the run and drawn values that the scene rejects.
   !>
   !> Errors: `NUTATE_STOPPED` if the sweep is to end, and then there is no row; errors of the history.
   subroutine row(self, scene, number, fields, status, reason, history, events)
      !> Prepared runner.
      class(member_run_t), intent(inout) :: self
      !> Scene of the ensemble.
      type(scene_t), intent(in) :: scene
      !> Number of the member, from 1 to the number of members.
      integer(long), intent(in) :: number
      !> Shape (fields).
      integer(long), intent(out) :: fields(:)
      type(status_t), intent(out) :: status
      !> Reason why the member did not reach its end.
      type(status_t), intent(out), optional :: reason
      !> History, open for the member; not used if the scene rejects it.
      type(history_t), intent(in), target, optional :: history
      type(event_history_t), intent(in), target, optional :: events
      type(status_t) :: outcome, failure
      integer(long) :: blank(size(fields))

      nullify (self%watcher%history, self%watcher%events)
      if (present(history)) self%watcher%history => history
      if (present(events)) self%watcher%events => events
      call begin_row(self, scene, number, fields, outcome)
      blank = fields
      if (outcome%ok()) then
         if (associated(self%watcher%sweep)) call self%watcher%sweep%prepare(self%member%scene%system%effects)
         call go(self, self%run, fields, outcome)
         if (associated(self%watcher%sweep)) call self%watcher%sweep%check(failure)
         if (.not. failure%ok()) then
            outcome = failure
            fields = blank
         end if
      end if
      call end_row(self, number, outcome, fields)
      if (outcome%code == NUTATE_STOPPED .or. outcome%code == NUTATE_IO) status = outcome
      if (present(reason)) reason = outcome
   end subroutine row

   !> Sets the values of a member, and blanks its row.
   subroutine begin_row(self, scene, number, fields, outcome)
      class(member_run_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: number
      integer(long), intent(out) :: fields(:)
      !> Error of a drawn value that the scene rejects.
      type(status_t), intent(out) :: outcome
      real(wp) :: absent
      call lock_texts()
      call self%member%set_values(scene%ensemble, number, outcome)
      call unlock_texts()
      absent = ieee_value(absent, ieee_quiet_nan)
      fields = bits_of(absent)
      where (self%layout%is_whole) fields = 0
   end subroutine begin_row

   !> Writes the number of a member, its outcome and its values into the row.
   subroutine end_row(self, number, outcome, fields)
      class(member_run_t), intent(in) :: self
      integer(long), intent(in) :: number
      type(status_t), intent(in) :: outcome
      integer(long), intent(inout) :: fields(:)
      fields(1) = number
      fields(2) = outcome%code
      fields(3:self%layout%values) = bits_of(self%member%values)
   end subroutine end_row

   !> Runs those of some members that are tops, and fills their rows: the others are left to `row`, and so are tops that
   !> do not arrive. Errors: `NUTATE_STOPPED` if the sweep is to end.
   subroutine run_tops(self, scene, first, fields, done, status)
      !> Prepared runner.
      class(member_run_t), intent(inout) :: self
      !> Scene of the ensemble.
      type(scene_t), intent(in) :: scene
      !> Number of the first member.
      integer(long), intent(in) :: first
      !> Shape (fields, members).
      integer(long), intent(inout) :: fields(:, :)
      !> True for the rows that are filled; shape (members).
      logical, intent(out) :: done(:)
      type(status_t), intent(out) :: status
      type(tops_t) :: tops
      integer :: who(size(done)), i, n
      logical :: is_top
      done = .false.
      if (.not. may_be_tops(scene, self%watcher%columns)) return
      allocate (tops%tops(size(done)))
      n = 0
      do i = 1, size(done)
         call begin_row(self, scene, first + i - 1, fields(:, i), status)
         is_top = status%ok()
         associate (one => self%member%scene, top => tops%tops(n + 1))
            if (is_top) is_top = may_be_tops(one, self%watcher%columns) .and. &
                                 one%plan%max_steps == scene%plan%max_steps .and. &
                                 abs(one%plan%goal%local_tolerance - scene%plan%goal%local_tolerance) <= 0.0_wp
            if (is_top) call find_top(one%system, one%initial, top, is_top)
            if (is_top) top%end_time = one%plan%end_time
         end associate
         if (.not. is_top) cycle
         n = n + 1
         who(n) = i
      end do
      status = status_t()
      tops%tops = tops%tops(:n)
      tops%max_steps = scene%plan%max_steps
      call tops%begin(scene%plan%goal%local_tolerance)
      do while (tops%running > 0)
         call tops%perform_steps(steps_between_polls)
         call self%watcher%poll(0.0_wp, status)
         if (.not. status%ok()) return
      end do
      do i = 1, n
         done(who(i)) = tops%tops(i)%arrived
         if (done(who(i))) call note_top(self, scene, first + who(i) - 1, tops%tops(i), fields(:, who(i)))
      end do
   end subroutine run_tops

   !> Returns true if nothing but the states at the ends of runs by Taylor series with a `local_tolerance` is asked for.
   logical function may_be_tops(scene, columns)
      !> Scene of an ensemble, or of a member.
      type(scene_t), intent(in) :: scene
      !> Columns of its rows.
      type(columns_t), intent(in) :: columns
      associate (settings => scene%integrator, goal => scene%plan%goal)
         may_be_tops = settings%method == 'taylor' .and. settings%conserve .and. settings%attitude .and. &
                       settings%series_order == 0 .and. settings%max_step >= huge(1.0_wp) .and. &
                       goal%local_tolerance > 0.0_wp .and. goal%local_tolerance <= loosest .and. &
                       goal%accuracy <= 0.0_wp .and. goal%error_rate <= 0.0_wp
      end associate
      may_be_tops = may_be_tops .and. scene%events%count() == 0 .and. scene%chaos%exponents == 0 .and. &
                    .not. (columns%follows_steps .or. columns%shows_commands .or. columns%differentiates)
   end function may_be_tops

   !> Fills the row of a top that has arrived.
   subroutine note_top(self, scene, number, top, fields)
      class(member_run_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: number
      type(top_t), intent(in) :: top
      integer(long), intent(out) :: fields(:)
      type(status_t) :: outcome
      type(state_t) :: state
      type(run_record_t) :: record
      real(wp) :: columns(self%layout%columns - self%layout%values)
      call begin_row(self, scene, number, fields, outcome)
      call begin_measures(self%watcher, self%member%scene)
      state = state_of_top(self%member%scene%system, top)
      record%step = top%steps
      associate (invariants => self%watcher%invariants)
         call invariants%measure(self%member%scene%system, state)
         invariants%worst_energy = max(invariants%worst_energy, top%energy_error)
         invariants%worst_momentum = max(invariants%worst_momentum, top%momentum_error)
      end associate
      call self%watcher%columns%evaluate(self%member%scene%system, state, record, columns)
      call put_end(self, columns, fields)
      call end_row(self, number, outcome, fields)
   end subroutine note_top

   !> Runs the member whose values have been set.
   subroutine go(self, run, fields, outcome)
      class(member_run_t), intent(inout) :: self
      type(run_t), intent(inout) :: run
      integer(long), intent(inout) :: fields(:)
      type(status_t), intent(out) :: outcome
      type(run_plan_t) :: plan
      associate (scene => self%member%scene, watcher => self%watcher)
         watcher%stride = poll_stride(scene)
         plan = scene%plan
         if (.not. associated(watcher%history)) plan%every = max(plan%every, watcher%stride)
         call run%begin(scene%system, scene%integrator, scene%initial, plan, outcome)
         if (outcome%ok()) call run%set_events(scene%events, scene%system, outcome)
         if (outcome%ok()) call run%follow_chaos(scene%chaos, scene%system, outcome)
         if (.not. outcome%ok()) return
         call begin_measures(watcher, scene)
         watcher%wants_works = watcher%columns%needs_works
         if (allocated(watcher%last_row)) deallocate (watcher%last_row)
         if (watcher%columns%shows_commands) allocate (watcher%last_row(watcher%columns%width), source=0.0_wp)
         watcher%observes_every_step = watcher%columns%follows_steps .or. associated(watcher%history)
         watcher%rows_at_steps = scene%output%by_default .and. .not. associated(watcher%history)
         call go_to_end(watcher, run, scene%system, outcome)
      end associate
      call note_end(self, run, outcome%ok(), fields)
   end subroutine go

   !> Begins to measure the columns and invariants of a member.
   subroutine begin_measures(watcher, scene)
      type(member_watcher_t), intent(inout) :: watcher
      type(scene_t), intent(in) :: scene
      associate (j0 => scene%integrator%inverse_auxiliary_inertia)
         call watcher%columns%start(scene%system, scene%initial, j0, scene%plan%end_time < 0.0_wp)
         call watcher%invariants%start(scene%system, scene%initial, j0, scene%integrator%attitude)
      end associate
   end subroutine begin_measures

   !> Runs to the end. If only the ends of steps are observed, the last trial run is used as the run.
   subroutine go_to_end(watcher, run, system, outcome)
      type(member_watcher_t), intent(inout) :: watcher
      type(run_t), intent(inout) :: run
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: outcome
      type(sweep_asker_t) :: asker
      asker%sweep => watcher%sweep
      watcher%begins_anew = watcher%rows_at_steps .and. .not. (watcher%observes_every_step .or. allocated(run%events))
      if (.not. watcher%begins_anew) then
         call run%find_steps(system, outcome, asker)
      else
         watcher%at_start = watcher%invariants
         call run%find_steps(system, outcome, asker, watcher)
         if (.not. outcome%ok()) watcher%invariants = watcher%at_start
      end if
      if (outcome%ok() .and. run%summary%steps == 0) call run%run_to_end(system, outcome, watcher)
   end subroutine go_to_end

   !> Writes the end of a run into the row.
   subroutine note_end(self, run, arrived, fields)
      class(member_run_t), intent(inout) :: self
      type(run_t), intent(in) :: run
      !> True if the run reached its end, which is measured whatever the stride is.
      logical, intent(in) :: arrived
      integer(long), intent(inout) :: fields(:)
      type(run_record_t) :: record
      real(wp) :: columns(self%layout%columns - self%layout%values)
      integer :: i, at
      record = run%record
      call put_works(run%summary, record)
      if (allocated(run%events)) then
         call evaluate_end(run%events%system)
      else
         call evaluate_end(self%member%scene%system)
      end if
      call put_end(self, columns, fields)
      if (allocated(run%summary%chaos)) then
         associate (chaos => run%summary%chaos)
            fields(self%layout%events + 1:) = bits_of([chaos%lyapunov(), chaos%megno(), chaos%fli()])
         end associate
      end if
      if (.not. allocated(run%events)) return
      do i = 1, run%events%n_asked
         at = self%layout%errors + 2*i - 1
         fields(at) = run%events%watched(i)%number
         if (fields(at) > 0) fields(at + 1) = bits_of(run%events%watched(i)%first_time)
      end do
   contains
      !> Evaluates the columns, and measures the invariants if the watcher may not have done so in the last row.
      subroutine evaluate_end(system)
         type(system_t), intent(in) :: system
         if (arrived .and. allocated(self%watcher%last_row)) then
            columns = self%watcher%last_row
         else
            call self%watcher%columns%evaluate(system, run%state, record, columns)
         end if
         if (arrived .and. self%watcher%stride > 1) &
            call self%watcher%invariants%measure(system, run%state, record%work)
      end subroutine evaluate_end
   end subroutine note_end

   !> Writes columns, and the errors of the invariants, into the row.
   subroutine put_end(self, columns, fields)
      class(member_run_t), intent(in) :: self
      real(wp), intent(in) :: columns(:)
      integer(long), intent(inout) :: fields(:)
      fields(self%layout%values + 1:self%layout%columns) = bits_of(columns)
      fields(self%layout%columns + 1) = bits_of(self%watcher%invariants%energy_error())
      fields(self%layout%columns + 2) = bits_of(self%watcher%invariants%momentum_error())
   end subroutine put_end

end module nutate_member_run
