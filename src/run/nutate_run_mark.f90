!> A run as it was before a step of the method, to which it can be taken back.
module nutate_run_mark
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_progress, only: progress_t, total_work, way_t
   use nutate_state, only: state_t
   implicit none
   private

   public :: mark_t, mark_progress, go_back

   !> A run as it was before a step of the method.
   type :: mark_t
      type(state_t) :: state = state_t()
      type(run_record_t) :: record = run_record_t()
      type(way_t) :: way = way_t()
      integer(long) :: steps = 0, subdivided_steps = 0, parts = 0, iterations = 0, uncertified_steps = 0
      !> s.
      real(wp) :: next_break = 0.0_wp
      !> J; shape (number of torques).
      real(wp), allocatable :: work(:), work_compensation(:)
      real(wp) :: total = 0.0_wp
   end type mark_t

contains

   !> Notes how a run is before a step.
   subroutine mark_progress(progress, mark)
      type(progress_t), intent(in) :: progress
      type(mark_t), intent(inout) :: mark
      mark%state = progress%state
      mark%record = progress%record
      mark%way = progress%way
      mark%steps = progress%summary%steps
      mark%subdivided_steps = progress%summary%subdivided_steps
      mark%parts = progress%summary%parts
      mark%iterations = progress%summary%iterations
      mark%uncertified_steps = progress%summary%uncertified_steps
      mark%next_break = progress%next_break
      if (.not. allocated(mark%work)) allocate (mark%work(size(progress%summary%work)), &
                                                mark%work_compensation(size(progress%summary%work)))
      mark%work(:) = progress%summary%work
      mark%work_compensation(:) = progress%work_compensation
      mark%total = total_work(progress%summary)
   end subroutine mark_progress

   !> Restores a run to where it was.
   subroutine go_back(mark, progress)
      type(mark_t), intent(in) :: mark
      type(progress_t), intent(inout) :: progress
      progress%state = mark%state
      progress%record = mark%record
      progress%way = mark%way
      progress%summary%steps = mark%steps
      progress%summary%subdivided_steps = mark%subdivided_steps
      progress%summary%parts = mark%parts
      progress%summary%iterations = mark%iterations
      progress%summary%uncertified_steps = mark%uncertified_steps
      progress%next_break = mark%next_break
      progress%summary%work(:) = mark%work
      progress%work_compensation(:) = mark%work_compensation
   end subroutine go_back

end module nutate_run_mark
