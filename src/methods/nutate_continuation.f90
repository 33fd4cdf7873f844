!> The branch of the true motion: which root of a long step continues the motion from short steps.
!>
!> The equations of a step have other roots, which conserve everything too. With |b| < 1 and a positive determinant of
!> the Jacobian a root can still be a wrong one. So a root that is not surely the right one is found again by walking to
!> it: the step grows from a short one to its length, each root the guess for the next.
module nutate_continuation
   use nutate_kinds, only: wp
   implicit none
   private

   public :: continuation_t, is_surely_true, is_continued

   !> |b|, b = ¼Δt Ω̄, below which a root with a positive determinant is the true one. On a free body's axis the branch
   !> ends where λΔt/2 = 1 - |b|², and the growth rate λ is below |Ω| by the triangle rule: at |b| = √2 - 1 at the
   !> earliest. Off the axes it ends later (2e5 bodies drawn at random: the nearest wrong root has |b| = 0.446).
   real(wp), parameter :: surely_true = 0.41_wp
   !> A determinant within this factor of that of a very short step: the effects do not dominate the step. Damping makes
   !> it large and brings no other root near, forces that depend on the attitude do.
   real(wp), parameter :: mild = 4.0_wp
   !> |b| from which a root is refused. At |b| = 1, half a turn, the reduced equations are solved by what is no step.
   real(wp), parameter :: longest = 0.98_wp
   !> Largest change of an unknown from guess to root that is no jump to another root.
   real(wp), parameter :: farthest_jump = 0.05_wp
   !> Change of b that the walk aims at from one length to the next, part of the whole step below which it gives up,
   !> and most lengths tried.
   real(wp), parameter :: pace = 0.06_wp, shortest = 1e-3_wp, first_shortest = 1e-15_wp
   integer, parameter :: most_lengths = 250

   !> A walk along the branch, in parts of the step's length.
   type :: continuation_t
      !> Part of the step whose root is known; part to try next.
      real(wp) :: reached = 0.0_wp, next = 0.0_wp
      !> Part before the one reached; the determinant of the root reached.
      real(wp), private :: before = 0.0_wp, determinant = 1.0_wp
      !> Growth of the step that is tried.
      real(wp), private :: stride = 0.0_wp
      !> Lengths tried so far.
      integer :: tried = 0
   contains
      !> Starts a walk.
      procedure :: start
      !> How much of the last change of the unknowns to add to the last root for the next guess.
      procedure :: secant
      !> The root found is on the branch.
      procedure :: keeps_to
      !> There is a length to try.
      procedure :: goes_on
      !> Takes the outcome of a trial.
      procedure :: judge
   end type continuation_t

contains

   !> True if a root needs no walk to be known as the true one.
   pure logical function is_surely_true(turn, determinant, forced, by_attitude)
      !> |b|
      real(wp), intent(in) :: turn
      !> Determinant of the Jacobian over that of a very short step.
      real(wp), intent(in) :: determinant
      !> There are effects; some depend on the attitude.
      logical, intent(in) :: forced, by_attitude
      is_surely_true = turn < surely_true .and. determinant > 0.0_wp
      if (is_surely_true .and. forced) is_surely_true = determinant*mild > 1.0_wp
      if (is_surely_true .and. by_attitude) is_surely_true = determinant < mild
   end function is_surely_true

   !> True if a root continues that of the last step, which was true: in a step that effects dominate.
   pure logical function is_continued(turn, determinant, last_determinant, jump)
      !> |b|
      real(wp), intent(in) :: turn
      !> Determinant of the Jacobian, and that of the last step of the same length; 0 where there is none.
      real(wp), intent(in) :: determinant, last_determinant
      !> Largest distance of an unknown from the guess that continues the last steps.
      real(wp), intent(in) :: jump
      is_continued = turn < surely_true .and. jump < farthest_jump .and. determinant > 0.5_wp*last_determinant .and. &
                     determinant < 2*last_determinant
   end function is_continued

   !> Starts at a length whose root is surely the true one.
   pure subroutine start(self, turn)
      class(continuation_t), intent(inout) :: self
      !> |b| of the whole step if its rate stayed that of the start.
      real(wp), intent(in) :: turn
      self%reached = 0.0_wp
      self%before = 0.0_wp
      self%determinant = 1.0_wp
      self%tried = 0
      self%stride = 1.0_wp
      if (turn > 0.8_wp*surely_true) self%stride = 0.8_wp*surely_true/turn
      self%next = self%stride
   end subroutine start

   !> True unless the whole step is reached or the branch has ended.
   pure logical function goes_on(self)
      class(continuation_t), intent(in) :: self
      goes_on = self%reached < 1.0_wp .and. self%tried < most_lengths .and. &
                self%stride > shortest*min(1.0_wp, max(self%reached, first_shortest/shortest))
   end function goes_on

   !> How much of the last change of the unknowns to add to the last root for the next guess; the first root is
   !> reached from none.
   pure real(wp) function secant(self)
      class(continuation_t), intent(in) :: self
      secant = (self%next - self%reached)/(self%reached - self%before)
   end function secant

   !> True if a root can be no other than the continued one: near the guess, the nearer the closer to the end of the
   !> branch, and the determinant changed by no more than a factor of two.
   pure logical function keeps_to(self, turn, determinant, jump)
      class(continuation_t), intent(in) :: self
      !> |b| of the root, its determinant over that of a very short step, and its largest distance from the guess.
      real(wp), intent(in) :: turn, determinant, jump
      keeps_to = turn < longest .and. determinant > 0.5_wp*self%determinant .and. determinant < 2*self%determinant &
                 .and. jump < farthest_jump*min(1.0_wp, self%determinant)
   end function keeps_to

   !> Goes on from the length tried, or tries a shorter one.
   pure subroutine judge(self, found, change, determinant)
      class(continuation_t), intent(inout) :: self
      !> The root belongs to the branch.
      logical, intent(in) :: found
      !> Change of b since the last root.
      real(wp), intent(in) :: change
      !> Of the root, over that of a very short step.
      real(wp), intent(in) :: determinant
      self%tried = self%tried + 1
      if (found) then
         if (self%reached > 0.0_wp) then
            self%stride = self%stride*max(0.5_wp, min(2.0_wp, pace/max(change, 0.1_wp*pace)))
         else
            self%stride = min(self%stride, pace/surely_true*self%next)
         end if
         self%before = self%reached
         self%reached = self%next
         self%determinant = determinant
      else
         self%stride = 0.5_wp*self%stride
      end if
      self%next = self%reached + self%stride
      if (self%next > 1.0_wp - 0.1_wp*self%stride) self%next = 1.0_wp
   end subroutine judge

end module nutate_continuation
