!> By how much truncation may have a series err: the motion, and the works that are integrated beside it.
!>
!> Coefficients of a work are those of a product, and where a motion dies out as exp(-rt) they are 2ⁿ times those of the
!> motion: the works then err most, and by far more than the energy that is left at the end of the step.
module nutate_series_error
   use nutate_kinds, only: wp
   use nutate_motion_series, only: motion_series_t
   use nutate_work_share, only: step_error_t
   implicit none
   private

   public :: add_work_of, take_error

contains

   !> Work of a torque from the start of a series to a time, or, one more, of the potentials that move; its error is
   !> added to that of the works.
   pure subroutine add_work_of(series, i, s, work, error)
      type(motion_series_t), intent(in) :: series
      !> Of the torque.
      integer, intent(in) :: i
      !> Time in units.
      real(wp), intent(in) :: s
      !> J.
      real(wp), intent(out) :: work
      type(step_error_t), intent(inout) :: error
      real(wp) :: off
      call series%torques%get_work(i, series%order, series%time_unit, s, series%tail, work, off)
      error%work = error%work + off
   end subroutine add_work_of

   !> By how much attitude and momentum may err at a time.
   pure subroutine take_error(series, s, error)
      !> With its tail.
      type(motion_series_t), intent(in) :: series
      !> In units.
      real(wp), intent(in) :: s
      type(step_error_t), intent(inout) :: error
      error%angle = series%tail%error_of_all(series%order, s)
      error%of_momentum = 0.0_wp
      if (series%scale > tiny(1.0_wp)) error%of_momentum = error%angle/series%scale
   end subroutine take_error

end module nutate_series_error
