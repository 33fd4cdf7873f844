!> Fixed steps for an accuracy at the end of a run: for smooth motions that are cheap to follow, estimating the error of
!> each step costs more than finding the number of steps by trial runs.
!>
!> The motions are those of `nutate_specialised_motion`, the method is `rk8`. The error of a step is estimated as
!> `C(ωh)⁹`, ω a rate of the motion that is known beforehand, and that of n steps as n times as much. Measured on 300
!> random tops at 1e-3, 1e-6 and 1e-9 rad: the number of steps found in this way is within 0.75 to 1.4 times the right
!> one for nine of ten.
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
      !> True if fixed steps suit the run.
      logical :: suit = .false.
      !> ω times the duration of the run, rad.
      real(wp), private :: turn = 0.0_wp
      !> Duration of the run, s, positive.
      real(wp), private :: duration = 0.0_wp
      !> Tolerance of the last call, rad, and length of its steps, s.
      real(wp), private :: tolerance = 0.0_wp, length = 0.0_wp
   contains
      !> Determines whether fixed steps suit a run.
      procedure :: recognise
      !> Return the number of steps for a tolerance, and set their length.
      procedure :: number_for
      procedure :: divide
      !> Returns the first tolerance for an accuracy.
      procedure :: tolerance_for
   end type equal_steps_t

   !> Least accuracy: for smaller ones the noise of trial runs would be too small to show the effect of round-off.
   real(wp), parameter :: least_accuracy = 0.99e-10_wp
   !> Longest motion, ωT in rad: for longer ones errors no longer grow steadily with the steps, and two runs can agree
   !> by coincidence.
   real(wp), parameter :: most_turn = 200.0_wp
   !> C, and the power of the step.
   real(wp), parameter :: constant = 5e-10_wp
   integer, parameter :: power = 9
   !> Accuracy over the error for which the first tolerance is chosen: the margin of the bound, and enough that three of
   !> four runs meet it.
   real(wp), parameter :: caution = 12.0_wp
   !> Least number of steps, and that in the first run without noise: fewer would hardly cost less.
   real(wp), parameter :: least_number = 8.0_wp, first_number = 20.0_wp

contains

   !> Determines whether fixed steps suit a run: those of `rk8`, for motions in its specialised variables.
   pure subroutine recognise(self, system, settings, state, duration, accuracy)
      class(equal_steps_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      !> Initial state.
      type(state_t), intent(in) :: state
      !> Duration, s, of either sign.
      real(wp), intent(in) :: duration
      !> Accuracy at the end, rad; 0 if none is requested.
      real(wp), intent(in) :: accuracy
      type(specialised_motion_t) :: motion
      real(wp) :: pace
      self%duration = abs(duration)
      self%tolerance = 0.0_wp
      self%suit = settings%method == 'rk8' .and. settings%attitude .and. accuracy >= least_accuracy
      if (.not. self%suit) return
      call motion%prepare(system, settings%attitude)
      ! The rule for their number was measured in non-rotating axes.
      self%suit = motion%possible .and. .not. system%effects%frame_turns
      if (.not. self%suit) return
      pace = motion%pace(body_momentum(state))
      self%suit = pace <= most_turn/max(1.0_wp, abs(duration))
      if (self%suit .or. abs(duration) <= 1.0_wp) self%turn = pace*abs(duration)
      self%suit = self%suit .or. (abs(duration) <= 1.0_wp .and. self%turn <= most_turn)
   end subroutine recognise

   !> Returns the number of steps with a given error each.
   pure real(wp) function number_for(self, tolerance) result(n)
      class(equal_steps_t), intent(in) :: self
      !> Error of a step, rad.
      real(wp), intent(in) :: tolerance
      n = anint(max(least_number, self%turn*(constant/tolerance)**(1.0_wp/power)))
   end function number_for

   !> Sets the length of steps with a given error each.
   pure subroutine divide(self, tolerance, length)
      class(equal_steps_t), intent(inout) :: self
      !> Error of a step, rad.
      real(wp), intent(in) :: tolerance
      !> Length of the steps, s, positive.
      real(wp), intent(out) :: length
      if (abs(tolerance - self%tolerance) > 0.0_wp) self%length = self%duration/self%number_for(tolerance)
      self%tolerance = tolerance
      length = self%length
   end subroutine divide

   !> Returns the first tolerance for an accuracy.
   pure real(wp) function tolerance_for(self, accuracy) result(tolerance)
      class(equal_steps_t), intent(in) :: self
      !> Accuracy at the end, rad.
      real(wp), intent(in) :: accuracy
      real(wp) :: n
      n = max(first_number, self%turn*(caution*constant*self%turn/accuracy)**(1.0_wp/(power - 1)))
      tolerance = constant*(self%turn/n)**power
   end function tolerance_for

end module nutate_equal_steps
