!> How a step sees space axes that turn at a constant rate ω.
!>
!> In such a frame the discrete equations get two terms more, with δ = ¼Δt ω and b = ¼Δt Ω̄ of the absolute rate:
!>
!>     q1 - q0 = 2(q̄∘b - δ∘q̄),   p1 - p0 = 2(p̄∘b - δ∘p̄) + Δt f,
!>
!> which keep H - ω·l, |q| and q·p exactly. Seen from the body, with δ̄ = R(q̄)ᵀδ/|q̄|² the turn of the frame at mid step,
!> the first one is `q1 = q0∘c`, c the Cayley map of **r = b - δ̄**: the step turns the body as one of an inertial frame
!> does, by its rate against the frame. With β = |b|², d = |δ|², ρ = |r|², ΔL = L1 - L0, the second one is
!>
!>     (1-β+d) ΔL + 2b×(L0 + L1) = Δt((1+ρ)τ̄ - 2r(b·τ̄)),
!>
!> τ̄ the torque at the mid attitude of r. Everything here is seen from u, the attitude at the start of the step.
module nutate_frame_turn
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, rotate_to_body
   implicit none
   private

   public :: frame_turn_t

   !> The turn of the space axes in a step.
   type :: frame_turn_t
      !> They turn; all else is without meaning if they do not.
      logical :: there = .false.
      !> ω, space axes, rad/s; shape (3).
      real(wp) :: rate(3) = 0.0_wp
      !> R(u)ᵀδ; shape (3), and d = |δ|².
      real(wp) :: start(3) = 0.0_wp, square = 0.0_wp
   contains
      !> Takes the rate.
      procedure :: prepare
      !> Starts a step.
      procedure :: begin
      !> δ̄ of a step that turns the body by r.
      procedure :: middle
      !> ∂b/∂r.
      procedure :: absolute_by_relative
      !> r of a b.
      procedure :: to_relative
      !> L1 - L0.
      procedure :: momentum_change
   end type frame_turn_t

contains

   !> Takes the rate.
   pure subroutine prepare(self, effects)
      class(frame_turn_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      self%there = effects%frame_turns
      self%rate = effects%frame_rate
   end subroutine prepare

   !> Starts a step of `dt` seconds.
   pure subroutine begin(self, dt, frame)
      class(frame_turn_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      !> u, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: frame(4)
      self%start = (0.25_wp*dt)*rotate_to_body(frame, self%rate)
      self%square = (0.25_wp*dt)**2*dot_product(self%rate, self%rate)
   end subroutine begin

   !> δ̄ = R(c½)ᵀ R(u)ᵀδ of a step that turns the body by the Cayley map of r; shape (3).
   pure function middle(self, r, square) result(turn)
      class(frame_turn_t), intent(in) :: self
      !> r, shape (3), and |r|².
      real(wp), intent(in) :: r(3), square
      real(wp) :: turn(3)
      associate (v => self%start)
         turn = ((1 - square)*v + (2*(r(1)*v(1) + r(2)*v(2) + r(3)*v(3)))*r - 2*cross(r, v))/(1 + square)
      end associate
   end function middle

   !> ∂b/∂r, b = r + δ̄: a change δr turns the attitude at mid step by θ = 2(δr - r×δr)/(1+|r|²), and δ̄ by δ̄×θ; shape
   !> (3,3).
   pure function absolute_by_relative(self, r, turn) result(by_r)
      class(frame_turn_t), intent(in) :: self
      !> r, and its δ̄; shape (3).
      real(wp), intent(in) :: r(3), turn(3)
      real(wp) :: by_r(3, 3), e(3)
      integer :: j
      do j = 1, 3
         e = 0.0_wp
         e(j) = 1.0_wp
         by_r(:, j) = e + (2/(1 + dot_product(r, r)))*cross(turn, e - cross(r, e))
      end do
   end function absolute_by_relative

   !> r of a b: the vector of x̄ = ½(1 + u*∘q1) over its scalar part; shape (3).
   pure function to_relative(self, b) result(r)
      class(frame_turn_t), intent(in) :: self
      !> Shape (3).
      real(wp), intent(in) :: b(3)
      real(wp) :: r(3), beta
      beta = dot_product(b, b)
      associate (v => self%start, d => self%square)
         r = ((1 + beta - d)*b - (1 + d - beta)*v - 2*cross(v, b))/(1 + beta + d + 2*dot_product(v, b))
      end associate
   end function to_relative

   !> L1 - L0 in body axes, of the end and of the start: the solution of the second equation, of which b·ΔL = Δt b·τ̄;
   !> N m s; shape (3).
   pure function momentum_change(self, b, r, momentum, impulse) result(change)
      class(frame_turn_t), intent(in) :: self
      !> Shape (3).
      real(wp), intent(in) :: b(3), r(3)
      !> L0, and Δt τ̄, N m s; shape (3).
      real(wp), intent(in) :: momentum(3), impulse(3)
      real(wp) :: change(3), y(3), beta, rest, along
      beta = dot_product(b, b)
      rest = 1 - beta + self%square
      along = dot_product(b, impulse)
      y = (1 + dot_product(r, r))*impulse - (2*along)*r + 4*cross(momentum, b)
      change = (rest*y + 2*cross(y, b) + (4*along)*b)/(rest*rest + 4*beta)
   end function momentum_change

end module nutate_frame_turn
