!> Summary of a run: its steps, their cost, and what it reports at its end.
module nutate_summary
   use nutate_archive, only: archive_t
   use nutate_chaos, only: chaos_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: run_summary_t

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

contains

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

end module nutate_summary
