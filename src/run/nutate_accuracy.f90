!> From the attitude error that is asked for at the end of a run to the error that its steps may make.
!>
!> Local errors grow on the way, by a factor that depends on the motion: pilot runs measure it. Each has a smaller
!> error rate than the one before; the difference of their ends is the error of the coarser one, and in proportion to
!> the rates that of the finer. The rate is then lowered in proportion until the estimate meets the accuracy.
module nutate_accuracy
   use nutate_step_control, only: control_settings_t, integrate_controlled
   use nutate_kinds, only: wp, long
   use nutate_methods, only: method_of, method_t, order_of
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: observer_t, run_plan_t, run_record_t, run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: find_error_rate

   !> The estimate is to come to this part of the accuracy.
   real(wp), parameter :: aim = 0.4_wp
   !> The same for a method that chooses its order too: its error does not follow the rate as closely, and costs less.
   real(wp), parameter :: careful_aim = 0.1_wp
   !> An error of the coarser pilot above this is no small perturbation: it measures nothing, rad.
   real(wp), parameter :: largest_useful = 0.1_wp
   !> Error that the first pilot aims at, at most, rad.
   real(wp), parameter :: coarsest = 1e-4_wp
   !> Pilots whose errors differ by less than this factor cannot be told apart.
   real(wp), parameter :: least_gain = 2.0_wp
   !> Least and greatest ratio of the error rates of consecutive pilots.
   real(wp), parameter :: least_ratio = 10.0_wp, greatest_ratio = 1e4_wp
   !> Pilots at most.
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

   !> Looks away: pilots have no rows.
   type, extends(observer_t) :: blind_t
   contains
      procedure :: observe => ignore_row
   end type blind_t

contains

   !> The error rate that makes the attitude error at the end time about `goal%accuracy`, and an estimate of that error.
   !> Where round-off or instability keep the accuracy out of reach the estimate stays above it. A method without an
   !> error needs no pilots.
   !>
   !> Errors: those of the pilot runs, and what the observer returned.
   subroutine find_error_rate(system, settings, start, plan, goal, status, observer)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: start
      type(run_plan_t), intent(in) :: plan
      !> `accuracy` on entry; `error_rate` and `estimate` are set.
      type(control_settings_t), intent(inout) :: goal
      type(status_t), intent(out) :: status
      !> Shown the first and the last state of each pilot run; its `poll` can end the search.
      class(observer_t), intent(inout), optional :: observer
      type(pilot_t) :: coarse, fine
      real(wp) :: difference, gain, least, target, fall
      logical :: chooses
      integer :: i

      call ask_method(settings, fall, chooses)
      if (order_of(settings) < 1) then
         goal%error_rate = goal%accuracy/abs(plan%end_time - start%t)
         goal%estimate = 0.0_wp
         return
      end if
      target = merge(careful_aim, aim, chooses)*goal%accuracy
      least = huge(1.0_wp)
      goal%estimate = huge(1.0_wp)
      coarse%rate = max(goal%accuracy, coarsest)/abs(plan%end_time - start%t)
      call coarse%run(system, settings, start, plan, goal, status, observer)
      fine%rate = coarse%rate/least_ratio
      do i = 1, most_pilots
         if (status%ok()) call fine%run(system, settings, start, plan, goal, status, observer)
         if (.not. status%ok()) return
         difference = attitude_distance(coarse%q, fine%q)
         ! Steps that the rate no longer changes are at round-off, and the estimate before is the one that holds.
         if (chooses .and. i > 1 .and. .not. difference > 0.0_wp) exit
         ! The error falls with the steps, not always with the rate: the longest turn may have limited the steps of
         ! both.
         gain = (coarse%rate/fine%rate)**fall
         if (.not. chooses) gain = min(gain, (real(fine%steps, wp)/real(coarse%steps, wp))**order_of(settings))
         if (gain < least_gain) then
            fine%rate = fine%rate/least_ratio
            cycle
         end if
         goal%estimate = difference/(gain - 1)
         goal%error_rate = fine%rate
         if (difference <= largest_useful) then
            if (goal%estimate <= target) exit
            ! Where a finer rate no longer lowers the difference it is round-off.
            if (difference >= least) exit
            least = difference
            gain = min(greatest_ratio, max(least_ratio, 1.5_wp*goal%estimate/target))
         else
            gain = least_ratio
         end if
         coarse = fine
         fine%rate = coarse%rate/gain
      end do
      if (goal%error_rate <= 0.0_wp) then
         ! No two pilots could be told apart: what they differ by is all that is known.
         goal%error_rate = fine%rate
         goal%estimate = difference
         return
      end if
      if (goal%estimate < target .and. difference <= largest_useful) call relax(coarse, fine, difference, target, goal)
   end subroutine find_error_rate

   !> What the error does as the error rate falls.
   subroutine ask_method(settings, power, chooses)
      type(integrator_settings_t), intent(in) :: settings
      !> Power of the error rate that the error goes as: 1, and more where a method's own estimate is of lower order
      !> than the method.
      real(wp), intent(out) :: power
      !> The method chooses its steps, and its order with them: their number tells nothing of the error.
      logical, intent(out) :: chooses
      type(method_t) :: method
      method = method_of(settings)
      power = 1.0_wp
      if (method%estimate_power > 0) power = real(method%order, wp)/real(method%estimate_power - 1, wp)
      chooses = method%dense
   end subroutine ask_method

   !> A finer rate than necessary was found: back towards that of the coarser pilot.
   subroutine relax(coarse, fine, difference, target, goal)
      type(pilot_t), intent(in) :: coarse, fine
      !> Attitude error of the coarser pilot, rad, and the one wanted.
      real(wp), intent(in) :: difference, target
      type(control_settings_t), intent(inout) :: goal
      real(wp) :: factor
      factor = coarse%rate/fine%rate
      if (difference > target) factor = min(factor, target/goal%estimate)
      goal%error_rate = factor*fine%rate
      goal%estimate = min(difference, factor*goal%estimate)
   end subroutine relax

   !> Runs a pilot of a rate.
   subroutine run_pilot(self, system, settings, start, plan, goal, status, observer)
      class(pilot_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: start
      type(run_plan_t), intent(in) :: plan
      type(control_settings_t), intent(in) :: goal
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      type(control_settings_t) :: own
      type(run_plan_t) :: end_only
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(blind_t) :: nobody
      own = goal
      own%error_rate = self%rate
      own%interval = 0.0_wp
      end_only = plan
      end_only%every = huge(plan%every)
      state = start
      if (present(observer)) then
         call integrate_controlled(system, settings, own, state, end_only, observer, summary, status)
      else
         call integrate_controlled(system, settings, own, state, end_only, nobody, summary, status)
      end if
      self%q = state%q
      self%steps = max(summary%steps, 1_long)
   end subroutine run_pilot

   subroutine ignore_row(self, system, state, record, status)
      class(blind_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
   end subroutine ignore_row

end module nutate_accuracy
