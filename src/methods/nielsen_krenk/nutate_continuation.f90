!> Selection of a root of a step if none can be certified to be the true one, and its continuation in Δt.
!>
!> The equations of a step have other roots, which conserve everything too. If effects dominate the step, or give no
!> bounds, `nutate_root_proof` has no proof. A root is then accepted if it is near enough to that of a short step, or
!> continues that of the last step; any other is found again by continuation: the step grows from a short one to its
!> length, each root the prediction for the next. The step is then treated as not certified: with |b| < 1 and a positive
!> determinant of the Jacobian a root can still be a wrong one.
module nutate_continuation
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_norm
   use nutate_state, only: state_t
   implicit none
   private

   public :: root_t, root_acceptance_t, continuation_t

   !> |b|, b = ¼Δt Ω̄, below which a root may be accepted: there the root of a free body with a positive determinant is
   !> the true one (`nutate_root_proof`).
   real(wp), parameter :: near = 0.41_wp
   !> Largest factor between a determinant and that of a very short step at which the effects do not dominate the step.
   !> Damping makes the determinant large without bringing another root near; forces that depend on the attitude do. No
   !> bound is certified with it: a factor of two in each direction is as far as a Jacobian can be treated as that of a
   !> short step.
   real(wp), parameter :: mild = 4.0_wp
   !> |b| from which a root is rejected. At |b| = 1, half a revolution, the reduced equations have a solution that is no
   !> step.
   real(wp), parameter :: longest = 0.98_wp
   !> Largest change of an unknown from prediction to root, in rad of half the rotation, that is no jump to another
   !> root: an eighth of `near`, the least distance seen between two roots of one step.
   real(wp), parameter :: farthest_jump = 0.05_wp
   !> Change of b that a continuation aims at from one length to the next: as far as the prediction by the secant is
   !> within `farthest_jump` where the branch bends with a radius of its own length.
   real(wp), parameter :: stride_aim = 0.06_wp
   !> Least part of the step by which a continuation must advance, and largest number of lengths tried: beyond these,
   !> the branch has ended. From a length without any rotation it starts with the second.
   real(wp), parameter :: shortest = 1e-3_wp, first_shortest = 1e-15_wp
   integer, parameter :: most_lengths = 250

   !> Properties of a root, in either form of the equations.
   type :: root_t
      !> |b|
      real(wp) :: turn = 0.0_wp
      !> Determinant of the Jacobian over that of a very short step.
      real(wp) :: determinant = 1.0_wp
      !> Largest distance of an unknown from its prediction, the attitude's and the momentum's over its size.
      real(wp) :: jump = 0.0_wp
   end type root_t

   !> Accepts or rejects roots from the system, the start of a step and its length.
   type :: root_acceptance_t
      !> There are effects; some depend on the attitude.
      logical :: forced = .false., by_attitude = .false.
   contains
      procedure :: set_up
      !> Returns true if the root is near that of a short step.
      procedure :: accepts
      !> Returns true if the root continues that of the last step.
      procedure :: continues
      !> Starts the continuation to a step.
      procedure :: begin
   end type root_acceptance_t

   !> A continuation in parts of the step's length.
   type :: continuation_t
      !> Part of the step whose root is known; part to try next.
      real(wp) :: reached = 0.0_wp, next = 0.0_wp
      !> Lengths tried so far.
      integer :: tried = 0
      !> Part before the one reached; the determinant of the root reached.
      real(wp), private :: before = 0.0_wp, determinant = 1.0_wp
      !> Growth of the step that is tried.
      real(wp), private :: stride = 1.0_wp
   contains
      !> Returns the multiple of the last change of the unknowns that the next prediction adds to the last root.
      procedure :: secant
      !> Returns true if the root found is on the branch.
      procedure :: keeps_to
      !> Returns true if there is a length to try.
      procedure :: goes_on
      !> Records the outcome of a trial.
      procedure :: record_trial
   end type continuation_t

contains

   pure subroutine set_up(self, system)
      class(root_acceptance_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      self%forced = system%effects%n_potentials + system%effects%n_torques + system%effects%n_wheels > 0
      self%by_attitude = system%effects%needs_attitude()
   end subroutine set_up

   !> Returns true if a root needs no continuation to be treated as the true one.
   pure logical function accepts(self, root)
      class(root_acceptance_t), intent(in) :: self
      type(root_t), intent(in) :: root
      accepts = root%turn < near .and. root%determinant > 0.0_wp
      if (accepts .and. self%forced) accepts = root%determinant*mild > 1.0_wp
      if (accepts .and. self%by_attitude) accepts = root%determinant < mild
   end function accepts

   !> Returns true if a root continues that of the last step, which was the true one, in a step that effects dominate.
   pure logical function continues(self, root, last_determinant)
      class(root_acceptance_t), intent(in) :: self
      type(root_t), intent(in) :: root
      !> Determinant of the last step of the same length; 0 if there is none.
      real(wp), intent(in) :: last_determinant
      continues = self%forced .and. root%turn < near .and. root%jump < farthest_jump .and. &
                  root%determinant > 0.5_wp*last_determinant .and. root%determinant < 2*last_determinant
   end function continues

   !> Starts the continuation to a step at a length whose root can be accepted. The length follows from b0 = ¼ΔtΩ0, the
   !> b of a step with the rate of its start.
   pure function begin(self, system, state, dt) result(path)
      class(root_acceptance_t), intent(in) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the step.
      type(state_t), intent(in) :: state
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      type(continuation_t) :: path
      real(wp) :: b0(4), turn
      b0(1) = 0.0_wp
      b0(2:4) = (0.25_wp*dt)*angular_velocity(system, state)
      turn = quat_norm(b0)
      ! The margin is for effects that speed the body up in the step.
      if (turn > 0.8_wp*near) path%stride = 0.8_wp*near/turn
      path%next = path%stride
   end function begin

   !> Returns true unless the whole step is reached or the branch has ended.
   pure logical function goes_on(self)
      class(continuation_t), intent(in) :: self
      goes_on = self%reached < 1.0_wp .and. self%tried < most_lengths .and. &
                self%stride > shortest*min(1.0_wp, max(self%reached, first_shortest/shortest))
   end function goes_on

   !> Returns the multiple of the last change of the unknowns that the next prediction adds to the last root; the first
   !> root has no predecessor.
   pure real(wp) function secant(self)
      class(continuation_t), intent(in) :: self
      secant = (self%next - self%reached)/(self%reached - self%before)
   end function secant

   !> Returns true if a root can only be the continued one: it is near its prediction, the nearer the closer the end of
   !> the branch is, and the determinant has changed by no more than a factor of two.
   pure logical function keeps_to(self, root)
      class(continuation_t), intent(in) :: self
      type(root_t), intent(in) :: root
      keeps_to = root%turn < longest .and. root%determinant > 0.5_wp*self%determinant .and. &
                 root%determinant < 2*self%determinant .and. root%jump < farthest_jump*min(1.0_wp, self%determinant)
   end function keeps_to

   !> Continues from the length tried, or sets a shorter one.
   pure subroutine record_trial(self, found, change, determinant)
      class(continuation_t), intent(inout) :: self
      !> The root belongs to the branch.
      logical, intent(in) :: found
      !> Change of b since the last root.
      real(wp), intent(in) :: change
      !> Determinant of the Jacobian at the root, over that of a very short step.
      real(wp), intent(in) :: determinant
      self%tried = self%tried + 1
      if (found) then
         if (self%reached > 0.0_wp) then
            self%stride = self%stride*max(0.5_wp, min(2.0_wp, stride_aim/max(change, 0.1_wp*stride_aim)))
         else
            self%stride = min(self%stride, stride_aim/near*self%next)
         end if
         self%before = self%reached
         self%reached = self%next
         self%determinant = determinant
      else
         self%stride = 0.5_wp*self%stride
      end if
      self%next = self%reached + self%stride
      if (self%next > 1.0_wp - 0.1_wp*self%stride) self%next = 1.0_wp
   end subroutine record_trial

end module nutate_continuation
