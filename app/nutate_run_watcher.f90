!> What looks on while a scene is run: the history, the invariants for the summary, the progress bar.
module nutate_run_watcher
   use nutate_history, only: history_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_progress, only: progress_bar_t
   use nutate_run, only: observer_t, run_plan_t, run_record_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: run_watcher_t

   type, extends(observer_t) :: run_watcher_t
      type(history_t) :: history
      type(invariants_t) :: invariants
      type(progress_bar_t) :: progress
      !> The invariants are wanted.
      logical :: measures = .false.
      !> Clock counts spent on rows, and clock counts in a second.
      integer(long) :: row_counts = 0, rate = 1
      !> Time of the last row written, s.
      real(wp) :: last_row = 0.0_wp
      real(wp), private :: t_first = 0.0_wp, duration = 0.0_wp
   contains
      !> Takes the first state; the history must be open.
      procedure :: start
      procedure :: observe => take_row
      procedure :: poll => show_progress
      procedure :: watch => watch_step
   end type run_watcher_t

contains

   !> Takes the first state; the history must be open.
   subroutine start(self, system, state, plan, settings, quiet)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(integrator_settings_t), intent(in) :: settings
      !> No progress bar, no invariants.
      logical, intent(in) :: quiet
      self%sees_every_step = self%history%sees_every_step
      self%t_first = state%t
      self%duration = plan%end_time - state%t
      self%measures = .not. quiet
      if (self%measures) call self%invariants%start(system, state, settings%inverse_auxiliary_inertia, &
                                                      settings%attitude)
      call system_clock(count_rate=self%rate)
      call self%progress%start(wanted=.not. quiet)
   end subroutine start

   !> Writes a row and measures the invariants. Errors: those of the history.
   subroutine take_row(self, system, state, record, status)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      integer(long) :: before, after

      call system_clock(before)
      call self%history%observe(system, state, record, status)
      if (status%ok()) self%last_row = state%t
      if (self%measures .and. status%ok()) call self%invariants%measure(system, state, record%work)
      call system_clock(after)
      self%row_counts = self%row_counts + (after - before)
      if (abs(self%duration) > 0.0_wp) call self%progress%update((state%t - self%t_first)/self%duration, after)
   end subroutine take_row

   !> Shows the progress where rows are rare.
   subroutine show_progress(self, fraction, status)
      class(run_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      integer(long) :: now
      call system_clock(now)
      call self%progress%update(fraction, now)
   end subroutine show_progress

   !> Lets the history follow what it must.
   subroutine watch_step(self, state)
      class(run_watcher_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      call self%history%watch(state)
   end subroutine watch_step

end module nutate_run_watcher
