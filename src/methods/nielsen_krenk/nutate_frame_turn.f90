!> Steps in space axes that rotate at a constant rate ω.
!>
!> In such a frame the discrete equations get two terms more, with δ = ¼Δt ω and b = ¼Δt Ω̄ of the absolute rate:
!>
!>     q1 - q0 = 2(q̄∘b - δ∘q̄),   p1 - p0 = 2(p̄∘b - δ∘p̄) + Δt f,
!>
!> which keep H - ω·l, |q| and q·p exactly. Seen from the body, with δ̄ = R(q̄)ᵀδ/|q̄|² the rotation of the frame at mid
!> step, the first one is `q1 = q0∘c`, c the Cayley map of **r = b - δ̄**: the step rotates the body as a step in
!> inertial axes does, by its rate relative to the frame. With β = |b|², d = |δ|², ρ = |r|², ΔL = L1 - L0, the second
!> one is
!>
!>     (1-β+d) ΔL + 2b×(L0 + L1) = Δt((1+ρ)τ̄ - 2r(b·τ̄)),
!>
!> τ̄ the torque at the mid attitude of r. Everything here is seen from u, the attitude at the start of the step.
module nutate_frame_turn
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotate_to_body
   implicit none
   private

   public :: frame_turn_t

   !> Rotation of the space axes in a step.
   type :: frame_turn_t
      !> The space axes rotate; otherwise the other components have no meaning.
      logical :: there = .false.
      !> ω, space axes, rad/s; shape (3).
      real(wp) :: rate(3) = 0.0_wp
      !> R(u)ᵀδ, and twice that; shape (3); d = |δ|².
      real(wp) :: start(3) = 0.0_wp, square = 0.0_wp
      real(wp), private :: twice(3) = 0.0_wp
      !> Length of the step, s, and δ of the step; shape (3).
      real(wp), private :: dt = 0.0_wp, delta(3) = 0.0_wp
   contains
      !> Sets the rate.
      procedure :: prepare
      !> Starts a step.
      procedure :: begin
      !> Returns the r that belongs to b.
      procedure :: to_relative
      !> Computes the r that belongs to b, and 1 + ρ.
      procedure :: get_relative
      !> Returns ∂r/∂b.
      procedure :: relative_by_absolute
      !> Add the free part of the eight equations, and of those for p alone.
      procedure :: add_turns
      procedure :: add_momentum_turns
      !> Returns the increment of the momentum.
      procedure :: momentum_increment
   end type frame_turn_t

contains

   !> Sets the rate.
   pure subroutine prepare(self, effects)
      class(frame_turn_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      self%there = effects%frame_turns
      self%rate = effects%frame_rate
      self%start = 0.0_wp
      self%square = 0.0_wp
      self%twice = 0.0_wp
      self%dt = 0.0_wp
      self%delta = 0.0_wp
   end subroutine prepare

   !> Starts a step of `dt` seconds.
   pure subroutine begin(self, dt, frame, columns)
      class(frame_turn_t), intent(inout) :: self
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      !> u, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: frame(4)
      !> R(u), if it is known; shape (3,3).
      real(wp), intent(in), optional :: columns(3, 3)
      integer :: i
      if (abs(dt - self%dt) > 0.0_wp) then
         self%delta = (0.25_wp*dt)*self%rate
         self%square = (0.25_wp*dt)**2*dot_product(self%rate, self%rate)
         self%dt = dt
      end if
      if (present(columns)) then
         do i = 1, 3
            self%start(i) = columns(1, i)*self%delta(1) + columns(2, i)*self%delta(2) + columns(3, i)*self%delta(3)
         end do
      else
         self%start = rotate_to_body(frame, self%delta)
      end if
      self%twice = 2*self%start
   end subroutine begin

   !> Returns ∂r/∂b, the inverse of ∂b/∂r: in b = r + δ̄ a change δr rotates the attitude at mid step by θ = 2(δr -
   !> r×δr)/(1+|r|²), and changes δ̄ by δ̄×θ; shape (3,3).
   pure function relative_by_absolute(self, b, r) result(by_b)
      class(frame_turn_t), intent(in) :: self
      !> b, and the r that belongs to it; shape (3).
      real(wp), intent(in) :: b(3), r(3)
      real(wp) :: by_b(3, 3), by_r(3, 3), rows(3, 3), along, v(3)
      integer :: j
      v = (2/(1 + dot_product(r, r)))*(b - r)
      along = 1 + dot_product(v, r)
      do j = 1, 3
         by_r(:, j) = -v(j)*r
         by_r(j, j) = by_r(j, j) + along
      end do
      by_r(2, 1) = by_r(2, 1) + v(3)
      by_r(3, 1) = by_r(3, 1) - v(2)
      by_r(1, 2) = by_r(1, 2) - v(3)
      by_r(3, 2) = by_r(3, 2) + v(1)
      by_r(1, 3) = by_r(1, 3) + v(2)
      by_r(2, 3) = by_r(2, 3) - v(1)
      rows(:, 1) = across(by_r(:, 2), by_r(:, 3))
      rows(:, 2) = across(by_r(:, 3), by_r(:, 1))
      rows(:, 3) = across(by_r(:, 1), by_r(:, 2))
      by_b = transpose(rows)/dot_product(rows(:, 1), by_r(:, 1))
   end function relative_by_absolute

   !> Returns the r that belongs to b: the vector of x̄ = ½(1 + u*∘q1) over its scalar part; shape (3).
   pure function to_relative(self, b) result(r)
      class(frame_turn_t), intent(in) :: self
      !> b; shape (3).
      real(wp), intent(in) :: b(3)
      real(wp) :: r(3), stretch
      call self%get_relative(b, (b(1)*b(1) + b(2)*b(2) + b(3)*b(3)) - self%square, r, stretch)
   end function to_relative

   !> Computes the r that belongs to b, and 1 + ρ = ((1+β-d)² + 4d)/(1 + β + d + 2 v·b), v = R(u)ᵀδ.
   pure subroutine get_relative(self, b, excess, r, stretch)
      class(frame_turn_t), intent(in) :: self
      !> b; shape (3), and β - d.
      real(wp), intent(in) :: b(3), excess
      !> r; shape (3), and 1 + ρ.
      real(wp), intent(out) :: r(3), stretch
      real(wp) :: shrink, of_b, of_v, twice
      associate (v => self%start, d => self%square)
         shrink = 1/((1 + excess) + 2*(d + (v(1)*b(1) + v(2)*b(2) + v(3)*b(3))))
         of_b = shrink*(1 + excess)
         of_v = shrink*(1 - excess)
         twice = 2*shrink
         r(1) = of_b*b(1) - of_v*v(1) - twice*(v(2)*b(3) - v(3)*b(2))
         r(2) = of_b*b(2) - of_v*v(2) - twice*(v(3)*b(1) - v(1)*b(3))
         r(3) = of_b*b(3) - of_v*v(3) - twice*(v(1)*b(2) - v(2)*b(1))
         stretch = of_b*(1 + excess) + (2*twice)*d
      end associate
   end subroutine get_relative

   !> Computes Δx - 2(x̄∘α - δ∘x̄) and Δy + 2(ȳ∘Cα + δ∘ȳ) with α = ⅛Δt a, in the sums and differences of α and δ: no
   !> more products than in non-rotating axes.
   pure subroutine add_turns(self, quarter, x, y, z, r)
      class(frame_turn_t), intent(in) :: self
      !> 2α, x̄ and ȳ; shape (4).
      real(wp), intent(in) :: quarter(4), x(4), y(4)
      !> (Δx, Δy); shape (8).
      real(wp), intent(in) :: z(8)
      real(wp), intent(out) :: r(8)
      real(wp) :: a, less(3), more(3)
      a = quarter(1)
      less = quarter(2:4) - self%twice
      more = quarter(2:4) + self%twice
      r(1) = z(1) - (a*x(1) - (x(2)*less(1) + x(3)*less(2) + x(4)*less(3)))
      r(2) = z(2) - (a*x(2) + (x(1)*less(1) + x(3)*more(3) - x(4)*more(2)))
      r(3) = z(3) - (a*x(3) + (x(1)*less(2) + x(4)*more(1) - x(2)*more(3)))
      r(4) = z(4) - (a*x(4) + (x(1)*less(3) + x(2)*more(2) - x(3)*more(1)))
      r(5) = z(5) + (a*y(1) + (y(2)*less(1) + y(3)*less(2) + y(4)*less(3)))
      r(6) = z(6) + (a*y(2) - (y(1)*less(1) + y(3)*more(3) - y(4)*more(2)))
      r(7) = z(7) + (a*y(3) - (y(1)*less(2) + y(4)*more(1) - y(2)*more(3)))
      r(8) = z(8) + (a*y(4) - (y(1)*less(3) + y(2)*more(2) - y(3)*more(1)))
   end subroutine add_turns

   !> Computes Δy + 2(ȳ∘Cα + δ∘ȳ).
   pure subroutine add_momentum_turns(self, quarter, y, z, r)
      class(frame_turn_t), intent(in) :: self
      !> 2α, ȳ and Δy; shape (4).
      real(wp), intent(in) :: quarter(4), y(4), z(4)
      real(wp), intent(out) :: r(4)
      real(wp) :: a, less(3), more(3)
      a = quarter(1)
      less = quarter(2:4) - self%twice
      more = quarter(2:4) + self%twice
      r(1) = z(1) + (a*y(1) + (y(2)*less(1) + y(3)*less(2) + y(4)*less(3)))
      r(2) = z(2) + (a*y(2) - (y(1)*less(1) + y(3)*more(3) - y(4)*more(2)))
      r(3) = z(3) + (a*y(3) - (y(1)*less(2) + y(4)*more(1) - y(2)*more(3)))
      r(4) = z(4) + (a*y(4) - (y(1)*less(3) + y(2)*more(2) - y(3)*more(1)))
   end subroutine add_momentum_turns

   !> Returns the increment of ½u*∘p in a step that rotates the body by r, on the constraint manifold: c∘L1 - L0, less
   !> the rounding error of q·p. c - 1 = 2(r - ρ)/(1+ρ), and L1 - L0 is the solution of the second equation, which gives
   !> b·ΔL = Δt b·τ̄; N m s; shape (4).
   pure function momentum_increment(self, b, r, square, factor, momentum, impulse) result(increment)
      class(frame_turn_t), intent(in) :: self
      !> b, r; shape (3), ρ and 2/(1+ρ).
      real(wp), intent(in) :: b(3), r(3), square, factor
      !> [rounding of q·p, L0], shape (4), and Δt τ̄, shape (3), N m s.
      real(wp), intent(in) :: momentum(4), impulse(3)
      real(wp) :: increment(4), change(3), y(3), last(3), beta, rest, along, shrink
      beta = b(1)*b(1) + b(2)*b(2) + b(3)*b(3)
      rest = 1 - beta + self%square
      along = 2*(b(1)*impulse(1) + b(2)*impulse(2) + b(3)*impulse(3))
      y = (1 + square)*impulse - along*r + 4*across(momentum(2:4), b)
      shrink = 1/(rest*rest + 4*beta)
      change = (shrink*rest)*y + (2*shrink)*(across(y, b) + along*b)
      last = momentum(2:4) + change
      increment(1) = -factor*(r(1)*last(1) + r(2)*last(2) + r(3)*last(3)) - momentum(1)
      increment(2:4) = change + factor*(across(r, last) - square*last)
   end function momentum_increment

   !> Returns a×b; here, so that it is compiled into its callers; shape (3).
   pure function across(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function across

end module nutate_frame_turn
