!> Fixed steps for an accuracy at the end of a run: where the motion is smooth and cheap to follow, to estimate
!> the error of each step costs more than to find their number by trial runs.
!>
!> The motions are those of `nutate_specialised_motion`, the method is `rk8`. A step is taken to err by `C(ωh)⁹`, ω a
!> rate of the motion that is known beforehand; n such steps err by n times that. Measured on 300 random tops at 1e-3,
!> 1e-6 and 1e-9 rad: the number of steps that this leads to is right within a factor of 0.75 to 1.4 for nine of ten.
module nutate_equal_steps
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_specialised_motion, only: specialised_motion_t
   use nutate_state, only: state_t
   use nutate_integrator_settings, only: integrator_settings_t
   implicit none
   private

   public :: equal_steps_t

   !> Fixed steps.
   type :: equal_steps_t
      !> They suit the run.
      logical :: suit = .false.
      !> ω times the time of the run, rad.
      real(wp), private :: turn = 0.0_wp
      !> Time of the run, s, positive.
      real(wp), private :: duration = 0.0_wp
      !> The last tolerance asked for, rad, and the length of its steps, s.
      real(wp), private :: tolerance = 0.0_wp, length = 0.0_wp
   contains
      !> Finds out if they suit a run.
      procedure :: recognise
      !> How many there are for a tolerance, and how long they are.
      procedure :: number_for
      procedure :: divide
      !> The tolerance to begin with for an accuracy.
      procedure :: tolerance_for
   end type equal_steps_t

   !> Accuracies below this are left to other ways: noise as small as they need tells nothing about round-off.
   real(wp), parameter :: least_accuracy = 0.99e-10_wp
   !> Longer motions, ωT in rad, are left, too: errors no longer grow steadily with the steps, and two runs can be near
   !> each other by accident.
   real(wp), parameter :: most_turn = 200.0_wp
   !> C, and the power of the step.
   real(wp), parameter :: constant = 5e-10_wp
   integer, parameter :: power = 9
   !> The first tolerance is for a smaller error than the accuracy: by the bound's margin, and so that three of four
   !> runs meet it.
   real(wp), parameter :: caution = 12.0_wp
   !> Steps at least, and in the first run without noise: fewer cost no less, beside all else.
   real(wp), parameter :: least_number = 8.0_wp, first_number = 20.0_wp

contains

   !> Finds out if fixed steps suit a run: of `rk8`, for motions in its specialised variables.
   pure subroutine recognise(self, system, settings, state, duration, accuracy)
      class(equal_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> The start.
      type(state_t), intent(in) :: state
      !> s, of either sign.
      real(wp), intent(in) :: duration
      !> At the end, rad; 0 where none is asked for.
      real(wp), intent(in) :: accuracy
      type(specialised_motion_t) :: motion
      real(wp) :: pace
      self%duration = abs(duration)
      self%tolerance = 0.0_wp
      self%suit = settings%method == 'rk8' .and. settings%attitude .and. accuracy >= least_accuracy
      if (.not. self%suit) return
      call motion%prepare(system, settings%attitude)
      ! The rule for their number was measured in axes that stand still.
      self%suit = motion%possible .and. .not. system%effects%frame_turns
      if (.not. self%suit) return
      pace = motion%pace(body_momentum(state))
      self%suit = pace <= most_turn/max(1.0_wp, abs(duration))
      if (self%suit .or. abs(duration) <= 1.0_wp) self%turn = pace*abs(duration)
      self%suit = self%suit .or. (abs(duration) <= 1.0_wp .and. self%turn <= most_turn)
   end subroutine recognise

   !> How many steps err by a tolerance each.
   pure real(wp) function number_for(self, tolerance) result(n)
      class(equal_steps_t), intent(in) :: self
      !> rad a step.
      real(wp), intent(in) :: tolerance
      n = anint(max(least_number, self%turn*(constant/tolerance)**(1.0_wp/power)))
   end function number_for

   !> Sets the length of steps that err by a tolerance each.
   pure subroutine divide(self, tolerance, length)
      class(equal_steps_t), intent(inout) :: self
      !> rad a step.
      real(wp), intent(in) :: tolerance
      !> s, positive.
      real(wp), intent(out) :: length
      if (abs(tolerance - self%tolerance) > 0.0_wp) self%length = self%duration/self%number_for(tolerance)
      self%tolerance = tolerance
      length = self%length
   end subroutine divide

   !> The tolerance to begin with for an accuracy.
   pure real(wp) function tolerance_for(self, accuracy) result(tolerance)
      class(equal_steps_t), intent(in) :: self
      !> At the end, rad.
      real(wp), intent(in) :: accuracy
      real(wp) :: n
      n = max(first_number, self%turn*(caution*constant*self%turn/accuracy)**(1.0_wp/(power - 1)))
      tolerance = constant*(self%turn/n)**power
   end function tolerance_for

end module nutate_equal_steps
