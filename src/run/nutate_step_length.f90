!> The length of a step from the estimated error of the step before: the elementary controller, which keeps the length
!> unless another one gains enough.
module nutate_step_length
   use nutate_kinds, only: wp, eps
   implicit none
   private

   public :: most_growth, step_length_t

   !> The next step, and what is known of the estimates of its error.
   type :: step_length_t
      !> The next step to try, s, positive.
      real(wp) :: next = 0.0_wp
      !> Order of the method.
      integer :: order = 2
      !> Estimates go as this power of the step.
      integer :: power = 3
      !> An estimate below this is round-off, rad.
      real(wp) :: round_off = 0.0_wp
   contains
      procedure :: set_up
      procedure :: growth
      procedure :: keeps
      procedure :: shrinkage
      procedure :: adapt
   end type step_length_t

   ! "Costs" below: instructions of a run on six scenes, by orders 4 and 8 and dop853, to tolerances of 1e-4 and 1e-8.

   !> Fraction of the growth allowed by the estimate that is used. 0.7 costs 9 % more; 0.95 costs the same on average,
   !> but up to a third more if steps are then rejected.
   real(wp), parameter :: safety = 0.85_wp
   !> A step changes only if it can grow by the first or must shrink to less than the second: another length needs
   !> another Jacobian and has no predictor. To change it always costs 7 % on average, to wait for 1.5 up to 13 %.
   real(wp), parameter :: worth_while = 1.15_wp, still_fits = 0.95_wp
   !> Bounds on the change of the step at a time, beyond which the estimate is extrapolated too far.
   real(wp), parameter :: most_growth = 3.0_wp, most_shrinkage = 0.2_wp
   !> Largest rotation in a step, rad: not quite half a revolution, beyond which two wrong results could agree by
   !> chance. The rotation is known only after the step, which may have gone beyond by `turn_margin`; `sure_shrinkage`
   !> brings it below again.
   real(wp), parameter :: largest_turn = 3.0_wp, turn_margin = 1.2_wp, sure_shrinkage = 0.8_wp
   !> Differences of the whole and the halves, rad: the rounding of two attitudes; of the steps that lead to them, with
   !> their projections.
   real(wp), parameter :: noise = 2*eps, doubtful = 16*eps

contains

   !> Sets up the lengths for a method.
   pure subroutine set_up(self, order, estimate_power)
      class(step_length_t), intent(inout) :: self
      !> Order of the method, and the power of the step as which its own estimate goes; 0: it has none.
      integer, intent(in) :: order, estimate_power
      self%order = order
      self%power = order + 1
      if (estimate_power > 0) self%power = estimate_power
      self%round_off = max(eps, doubtful/(2.0_wp**max(order, 1) - 1))
   end subroutine set_up

   !> Returns the factor by which the step could grow: its error goes as its length to the order plus one, the error
   !> over its length as its length to the order.
   pure real(wp) function growth(self, per_length, allowed, error)
      class(step_length_t), intent(in) :: self
      !> The goal is an error over the length of the step.
      logical, intent(in) :: per_length
      !> Allowed error of the step, and estimated error, rad.
      real(wp), intent(in) :: allowed, error
      real(wp) :: exponent
      exponent = 1.0_wp/(self%power - merge(1, 0, per_length))
      growth = min(most_growth, &
                   safety*(max(allowed, self%round_off)/max(error, noise/(2.0_wp**self%order - 1)))**exponent)
   end function growth

   !> Returns true if a step is good enough to be kept.
   elemental logical function keeps(self, allowed, error, turn)
      class(step_length_t), intent(in) :: self
      !> Allowed error, estimated error, and rotation of the body at the rate of the step's end, rad.
      real(wp), intent(in) :: allowed, error, turn
      keeps = error <= max(allowed, self%round_off) .and. turn <= turn_margin*largest_turn
   end function keeps

   !> Returns the factor by which a step that was not kept is shortened.
   elemental real(wp) function shrinkage(self, growth)
      class(step_length_t), intent(in) :: self
      !> Factor of growth that the estimate of the error allows.
      real(wp), intent(in) :: growth
      shrinkage = max(most_shrinkage, min(sure_shrinkage, growth))
   end function shrinkage

   !> Chooses the next step after one that was kept.
   pure subroutine adapt(self, step, growth, turn)
      class(step_length_t), intent(inout) :: self
      !> Length of the step, s, the factor by which it could grow, and the rotation in it, rad.
      real(wp), intent(in) :: step, growth, turn
      ! A step that was shortened to end at a given time is no reason against longer ones.
      if (step < self%next .and. growth >= 1.0_wp) return
      if (growth >= worth_while .or. growth < still_fits) self%next = step*growth
      if (self%next*turn > step*largest_turn) self%next = step*largest_turn/turn
   end subroutine adapt

end module nutate_step_length
