!> From the attitude error that is asked for at the end of a run to the error that its steps may make.
!>
!> Local errors grow on the way, by a factor that depends on the motion: pilot runs measure it. Each has a smaller
!> error rate than the one before; the difference of their ends is the error of the coarser one, and in proportion to
!> the rates that of the finer. The rate is then lowered in proportion until the estimate meets the accuracy.
module nutate_accuracy
   use nutate_error_control, only: error_control_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: method_of, method_t
   use nutate_observer, only: observer_t
   use nutate_progress, only: progress_t, start_run
   use nutate_quaternion, only: attitude_distance
   use nutate_run_loop, only: drive
   use nutate_run_plan, only: run_plan_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: find_error_rate

   !> The estimate is to come to this part of the accuracy: it is good to a factor 2 (suite `control`).
   real(wp), parameter :: aim = 0.4_wp
   !> The same for a method that chooses its order too: its error does not follow the rate as closely (to a factor 4,
   !> suite `taylor`), and costs less.
   real(wp), parameter :: careful_aim = 0.1_wp
   !> An error of the coarser pilot above this is no small perturbation, to which errors are proportional: it measures
   !> nothing, rad.
   real(wp), parameter :: largest_useful = 0.1_wp
   !> Error that the first pilot aims at, at most, rad: one that is below `largest_useful` still where errors grow a
   !> thousandfold on the way.
   real(wp), parameter :: coarsest = 1e-4_wp
   !> Pilots whose errors differ by less than this factor cannot be told apart: of the difference of their ends, less
   !> than half is the error of the coarser one.
   real(wp), parameter :: least_gain = 2.0_wp
   !> Least and greatest ratio of the error rates of consecutive pilots: at the one, the finer pilot's own error is a
   !> tenth of the difference that is measured; beyond the other it would be extrapolated by more than four digits.
   real(wp), parameter :: least_ratio = 10.0_wp, greatest_ratio = 1e4_wp
   !> The next pilot aims below what the last one says is needed by this factor, so that it can be the last.
   real(wp), parameter :: ahead = 1.5_wp
   !> Pilots at most: from `coarsest` to round-off in steps of `least_ratio`.
   integer, parameter :: most_pilots = 12

   !> A run of one error rate.
   type :: pilot_t
      !> rad/s.
      real(wp) :: rate = 0.0_wp
      !> Attitude at the end time, body→space; shape (4).
      real(wp) :: q(4) = 0.0_wp
      !> Steps taken.
      integer(long) :: steps = 0
   contains
      procedure :: run => run_pilot
   end type pilot_t

contains

   !> The error rate that makes the attitude error at the end time about the accuracy of the goal, and an estimate of
   !> that error. Where round-off or instability keep the accuracy out of reach the estimate stays above it. A method
   !> without an error needs no pilots.
   !>
   !> Errors: those of the pilot runs, and what the observer returned.
   subroutine find_error_rate(system, settings, progress, status, observer)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> At its start, not its end. The `error_rate` of its goal and the `estimate` of its summary are set.
      type(progress_t), intent(inout) :: progress
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Shown the first and the last state of each pilot run; its `poll` can end the search.
      class(observer_t), intent(inout), optional :: observer
      type(pilot_t) :: coarse, fine
      type(method_t) :: method
      real(wp) :: accuracy, duration, difference, gain, least, target, rate, estimate
      integer :: i

      method = method_of(settings)
      accuracy = progress%plan%goal%accuracy
      duration = abs(progress%plan%end_time - progress%state%t)
      if (method%order < 1) progress%plan%goal%error_rate = accuracy/duration
      if (method%order < 1) return
      target = merge(careful_aim, aim, method%dense)*accuracy
      rate = 0.0_wp
      least = huge(least)
      estimate = huge(estimate)
      coarse%rate = max(accuracy, coarsest)/duration
      call coarse%run(system, settings, progress, status, observer)
      fine%rate = coarse%rate/least_ratio
      do i = 1, most_pilots
         if (status%ok()) call fine%run(system, settings, progress, status, observer)
         if (.not. status%ok()) return
         difference = attitude_distance(coarse%q, fine%q)
         ! Steps that the rate no longer changes are at round-off, and the estimate before is the one that holds.
         if (method%dense .and. i > 1 .and. .not. difference > 0.0_wp) exit
         gain = gain_of(method, coarse, fine)
         if (gain < least_gain) then
            fine%rate = fine%rate/least_ratio
            cycle
         end if
         estimate = difference/(gain - 1)
         rate = fine%rate
         gain = least_ratio
         if (difference <= largest_useful) then
            ! Where a finer rate no longer lowers the difference it is round-off.
            if (estimate <= target .or. difference >= least) exit
            least = difference
            gain = min(greatest_ratio, max(least_ratio, ahead*estimate/target))
         end if
         coarse = fine
         fine%rate = coarse%rate/gain
      end do
      if (rate <= 0.0_wp) then
         ! No two pilots could be told apart: what they differ by is all that is known.
         rate = fine%rate
         estimate = difference
      else if (estimate < target .and. difference <= largest_useful) then
         call relax(coarse%rate, fine%rate, difference, target, estimate)
         rate = fine%rate
      end if
      progress%plan%goal%error_rate = rate
      progress%summary%estimate = estimate
   end subroutine find_error_rate

   !> Error of the coarser pilot over that of the finer, as their rates say: in proportion, and more where a method's
   !> own estimate is of lower order than the method. But the longest turn may have limited the steps of both: then
   !> their numbers tell, unless the method chooses its order too.
   pure real(wp) function gain_of(method, coarse, fine) result(gain)
      type(method_t), intent(in) :: method
      type(pilot_t), intent(in) :: coarse, fine
      real(wp) :: power
      power = 1.0_wp
      if (method%estimate_power > 0) power = real(method%order, wp)/real(method%estimate_power - 1, wp)
      gain = (coarse%rate/fine%rate)**power
      if (.not. method%dense) gain = min(gain, (real(fine%steps, wp)/real(coarse%steps, wp))**method%order)
   end function gain_of

   !> A finer rate than necessary was found: back towards that of the coarser pilot.
   pure subroutine relax(coarse_rate, rate, difference, target, estimate)
      !> Rate of the coarser pilot and of the finer one, rad/s.
      real(wp), intent(in) :: coarse_rate
      real(wp), intent(inout) :: rate
      !> Attitude error of the coarser pilot, rad, and the one wanted.
      real(wp), intent(in) :: difference, target
      !> Error of the finer pilot, rad.
      real(wp), intent(inout) :: estimate
      real(wp) :: factor
      factor = coarse_rate/rate
      if (difference > target) factor = min(factor, target/estimate)
      rate = factor*rate
      estimate = min(difference, factor*estimate)
   end subroutine relax

   !> Runs a pilot of a rate.
   subroutine run_pilot(self, system, settings, progress, status, observer)
      class(pilot_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> The run to come, at its start.
      type(progress_t), intent(in) :: progress
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer
      type(progress_t) :: own
      type(error_control_t) :: control
      type(run_plan_t) :: plan
      plan = progress%plan
      plan%goal%error_rate = self%rate
      plan%interval = 0.0_wp
      plan%every = huge(plan%every)
      call start_run(own, system%effects, progress%state, plan, status)
      if (status%ok()) call control%begin(system, settings, own, status)
      if (status%ok()) call drive(own, control, system, status, observer)
      self%q = own%state%q
      self%steps = max(own%summary%steps, 1_long)
   end subroutine run_pilot

end module nutate_accuracy
