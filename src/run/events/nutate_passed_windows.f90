!> Moves the sensitivities of a run over the times at which torques and motors start and stop. Steps end there; a step
!> that ends so near to such a time that no further step was made for it is treated as ending there.
module nutate_passed_windows
   use nutate_kinds, only: wp
   use nutate_progress, only: progress_t, sense_of
   use nutate_run_plan, only: step_margin
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_window_edges, only: cross_window_edges
   implicit none
   private

   public :: begin_windows, pass_windows, pass_windows_inside

contains

   !> Moves the sensitivities of a run over torques and motors that start or stop just where the sensitivities begin.
   subroutine begin_windows(progress, system)
      !> Run whose sensitivities have begun.
      type(progress_t), intent(inout) :: progress
      type(system_t), intent(in) :: system
      real(wp) :: sense, t, margin
      real(wp), allocatable :: change(:)
      if (.not. progress%tangent%moves_windows) return
      t = progress%state%t
      sense = sense_of(progress)
      margin = margin_at(progress, t)
      call cross_window_edges(system, progress%state, [t - sense*max(margin, spacing(t)), t + sense*margin], sense, &
                              progress%tangent, change)
      call note_change(progress, change)
   end subroutine begin_windows

   !> Moves the sensitivities of a run over torques and motors that started or stopped in the last step.
   subroutine pass_windows(progress, system, since)
      !> Run at the end of the step, with its sensitivities.
      type(progress_t), intent(inout) :: progress
      type(system_t), intent(in) :: system
      !> Start of the step, s.
      real(wp), intent(in) :: since
      real(wp), allocatable :: change(:)
      if (.not. progress%tangent%moves_windows) return
      progress%windows_since = since
      call cross_window_edges(system, progress%state, behind(progress, [since, progress%state%t]), &
                              sense_of(progress), progress%tangent, change)
      call note_change(progress, change)
   end subroutine pass_windows

   !> Moves sensitivities at a time inside the last step over torques and motors that started or stopped since the start
   !> of the step: only at the end of the step.
   subroutine pass_windows_inside(progress, system, state, tangent)
      !> Run at the end of the step.
      type(progress_t), intent(in) :: progress
      type(system_t), intent(in) :: system
      !> State at the time inside the step.
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      real(wp), allocatable :: change(:)
      if (.not. tangent%moves_windows .or. abs(state%t - progress%state%t) > 0.0_wp) return
      call cross_window_edges(system, state, behind(progress, [progress%windows_since, state%t]), &
                              sense_of(progress), tangent, change)
   end subroutine pass_windows_inside

   !> Stores the derivative of the time at which a torque starts or stops: it is that of every jump there.
   subroutine note_change(progress, change)
      type(progress_t), intent(inout) :: progress
      !> Derivative of the time of the last start or stop by each sensitivity; not allocated: there was none.
      real(wp), allocatable, intent(inout) :: change(:)
      if (.not. (allocated(change) .and. allocated(progress%events))) return
      progress%events%switch_time = progress%state%t
      call move_alloc(change, progress%events%switch_change)
   end subroutine note_change

   !> Returns the times up to which starts and stops are passed, s; shape (2).
   pure function behind(progress, times) result(passed)
      type(progress_t), intent(in) :: progress
      real(wp), intent(in) :: times(2)
      real(wp) :: passed(2)
      integer :: i
      passed = times + sense_of(progress)*[(margin_at(progress, times(i)), i=1, 2)]
   end function behind

   !> Returns the distance from the end of a step, s, within which a start or stop is passed with the step.
   pure real(wp) function margin_at(progress, t) result(margin)
      type(progress_t), intent(in) :: progress
      !> Time, s.
      real(wp), intent(in) :: t
      margin = 0.0_wp
      if (progress%n_steps >= 0) margin = step_margin(t, progress%plan%end_time, progress%plan%time_step)
   end function margin_at

end module nutate_passed_windows
