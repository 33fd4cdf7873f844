!> The turn of space axes in a step of a motion that does not know of it (`follows_rotating_axes`): free bodies, and
!> potentials that are symmetric about the rate ω.
!>
!> Such a step is taken in axes that stand still, as cheap and as long as there; then the state is turned back by ωΔt,
!> exactly. What the step keeps in these axes, T + V, l·ω and |l|, stays, and with it H - ω·l.
module nutate_axes_turn
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: greatest_turn
   implicit none
   private

   public :: axes_turn_t, rotated

   !> The turn of one length of step.
   type :: axes_turn_t
      !> The motion of the system does not know of the turn; all else is without meaning if it does.
      logical :: there = .false.
      !> Length of step for which the turn was computed last, s, and d, what its quaternion is more than 1; shape (4).
      real(wp) :: length = 0.0_wp, change(4) = 0.0_wp
      !> |ω|, rad/s, and -ω over it; shape (3).
      real(wp), private :: rate = 0.0_wp, axis(3) = 0.0_wp
   contains
      !> Looks whether the motion knows of the turn.
      procedure :: prepare
      !> Sets the length of a step.
      procedure :: set_length
   end type axes_turn_t

contains

   !> Looks whether the motion knows of the turn.
   pure subroutine prepare(self, effects, attitude)
      class(axes_turn_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> The states have an attitude.
      logical, intent(in) :: attitude
      self%there = follows_rotating_axes(effects) .and. attitude
      self%length = 0.0_wp
      self%change = 0.0_wp
      if (.not. self%there) return
      self%rate = norm2(effects%frame_rate)
      self%axis = -effects%frame_rate/self%rate
   end subroutine prepare

   !> Sets the length of a step: the quaternion c = 1 + d of the turn, -ω̂ sin x its vector, x = ½|ω|Δt. The length of
   !> c depends on the vector as it is rounded, so that turns of one length do not stretch what they turn.
   pure subroutine set_length(self, dt, possible)
      class(axes_turn_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      !> False, with the length as it was, where the axes turn so far that the digits of the turn are lost.
      logical, intent(out) :: possible
      real(wp) :: angle, square
      angle = self%rate*dt
      possible = abs(angle) <= greatest_turn
      if (.not. possible) return
      ! Beyond half a turn vice versa, to the opposite quaternion.
      angle = angle - (2*pi)*anint(angle/(2*pi))
      self%change(2:4) = sin(0.5_wp*angle)*self%axis
      square = min(dot_product(self%change(2:4), self%change(2:4)), 1.0_wp)
      self%change(1) = -square/(1 + sqrt(1 - square))
      self%length = dt
   end subroutine set_length

   !> d∘x: all that a frame costs; shape (4).
   pure function rotated(d, x)
      real(wp), intent(in) :: d(4), x(4)
      real(wp) :: rotated(4)
      rotated(1) = d(1)*x(1) - d(2)*x(2) - d(3)*x(3) - d(4)*x(4)
      rotated(2) = d(1)*x(2) + d(2)*x(1) + d(3)*x(4) - d(4)*x(3)
      rotated(3) = d(1)*x(3) + d(3)*x(1) + d(4)*x(2) - d(2)*x(4)
      rotated(4) = d(1)*x(4) + d(4)*x(1) + d(2)*x(3) - d(3)*x(2)
   end function rotated

end module nutate_axes_turn
