!> What an effect is: the abstract types that every physical effect extends, one file each.
!>
!> A **potential** is a function `U(γ)` of the body components `γ = R(q)ᵀ n` of a direction `n` fixed in space. It
!> supplies `U` and `∇U`; the discrete gradient ∇̄U that conserves energy and the momentum about `n` is derived from
!> them here. It is the finite derivative of the potential that the step of Nielsen & Krenk (2012) asks for: ∂V*/∂q =
!> γ'(q̄)ᵀ∇̄U has Δq·∂V*/∂q = ΔV (`nutate_discrete_forces`). A **torque** acts in body axes and does work. A **rotor**
!> adds a constant body momentum.
!>
!> An effect may supply the power series in time of its torque, from the series of γ and Ω: then the method 'taylor' can
!> integrate with it. All series are in `s = (t - t₀)/time_unit`; coefficient k is asked for when the coefficients 0..k
!> of what it depends on are there, k = 0, 1, 2, ... in turn.
!>
!> An effect may bound what it does in a step: then the root of a step can be proved to be the true one.
module nutate_effect
   use nutate_effect_bounds, only: bounds_of_potential, bounds_of_torque, effect_bounds_t, linear_map_t
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: quat_product
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: effect_t, given_bounds_t, potential_t, torque_t, rotor_t
   public :: turning_of
   public :: NO_SERIES, LINEAR_SERIES, GENERAL_SERIES, SPACE_SERIES

   !> How an effect supplies the power series in time of its torque: not at all; as a constant times the series of γ
   !> or Ω; coefficient by coefficient; the same in space axes, of a torque that depends on time alone there.
   integer, parameter :: NO_SERIES = 0, LINEAR_SERIES = 1, GENERAL_SERIES = 2, SPACE_SERIES = 3

   !> What the writer of an effect knows of it, for proofs: of a potential the largest |∇U|, ‖∇²U‖ and norm of the third
   !> derivative for all γ up to |n| long; of a torque that depends on attitude and time alone the largest |τ|,
   !> ‖∂τ/∂θ‖ (θ a small rotation) and norm of the second derivative along a rotation, N m, at all times.
   type :: given_bounds_t
      logical :: known = .false.
      real(wp) :: first = 0.0_wp, second = 0.0_wp, third = 0.0_wp
      !> Of a torque: each derivative by time is bounded by this times what is differentiated, 1/s.
      real(wp) :: rate = 0.0_wp
   end type given_bounds_t

   !> Anything a scene can contain beside the body.
   type, abstract :: effect_t
      !> Name of the effect: the scene's group name for the built-in ones.
      character(len=24) :: name = ''
      !> What switches call this one; blank: nothing does.
      character(len=24) :: label = ''
      !> It acts; one that does not costs nothing. A rotor always acts.
      logical :: on = .true.
      !> Bounds, where they are known and `bound` is not overridden.
      type(given_bounds_t) :: given = given_bounds_t()
   contains
      !> `NO_SERIES` unless overridden, `LINEAR_SERIES`, `GENERAL_SERIES`, or `SPACE_SERIES` of a torque.
      procedure :: series_kind => no_kind
      !> Number of auxiliary series, scalar ones that a general series is computed from; 0 unless overridden.
      procedure :: auxiliary_series => no_auxiliary
      !> The effect's numbers, its energy (J), torque (N m) and momentum (N m s) are finite and of a size that can be
      !> computed with, at every attitude; `.true.` unless overridden.
      procedure :: is_moderate => not_judged
      !> Bounds of the torque in a step and of its derivatives; those that are given unless overridden.
      procedure :: bound => not_bounded
      !> A body axis is one of symmetry of the effect, exactly; `.false.` unless overridden.
      procedure :: has_axis => no_axis
   end type effect_t

   !> V(q) = U(γ), γ = R(q)ᵀ n, the V of equation (8) of Nielsen & Krenk (2012).
   type, abstract, extends(effect_t) :: potential_t
      !> n: a vector fixed in space, of whatever length and unit the potential is written in.
      real(wp) :: direction(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> n moves, `direction` is that of t = 0; a bound of the rate, 1/s.
      logical :: moves = .false.
      real(wp) :: pace = 0.0_wp
   contains
      !> n at a time, ∂V/∂t at fixed attitude, and the series of n in time; constant unless overridden.
      procedure :: direction_at => fixed_direction
      procedure :: power => no_power
      procedure :: direction_series => fixed_series
      !> U(γ), J.
      procedure(potential_energy), deferred :: energy
      !> ∇U(γ): derivative by the body components γ.
      procedure(potential_gradient), deferred :: gradient
      !> Matrix of second derivatives of U; by differences of the gradient unless overridden.
      procedure :: hessian => difference_hessian
      !> Discrete gradient: ∇̄U(γ0, γ1) with ∇̄U·(γ1 - γ0) = U(γ1) - U(γ0); Gonzalez's (1996) unless overridden.
      procedure :: discrete_gradient => gonzalez_gradient
      !> ∂∇̄U/∂γ1; that of Gonzalez's unless overridden.
      procedure :: discrete_hessian => gonzalez_hessian
      procedure :: bound => bound_potential
      !> m of a linear series: the torque γ×∇U is m×γ; body axes.
      procedure :: series_moment => no_moment
      !> Coefficient of a general series of γ×∇U.
      procedure :: series_torque => no_potential_torque
   end type potential_t

   !> A torque in body axes, with or without a source of energy.
   type, abstract, extends(effect_t) :: torque_t
   contains
      !> τ(t, q, Ω), body axes, N m.
      procedure(body_torque), deferred :: torque
      !> ∂τ/∂θ (θ a small body rotation) and ∂τ/∂Ω; by differences unless overridden.
      procedure :: derivatives => difference_derivatives
      !> The torque acts from one time to another, s; steps end on them. Outside of it `torque` is not called.
      procedure :: window => always
      !> The torque acts at a time.
      procedure :: acts_at
      !> Times about a moment between which the torque, at fixed attitude and rate, is one smooth function of time; all
      !> times unless overridden. In a step about that moment it is asked at no others.
      procedure :: piece => one_piece
      !> The next time at which the torque starts, stops or goes from one piece to another; steps end on it. The ends of
      !> the window unless overridden.
      procedure :: next_break => next_end
      procedure :: bound => bound_torque
      !> ∂τ/∂t at fixed attitude and rate; by differences unless overridden. Asked only of a torque whose `bound` says
      !> that it changes.
      procedure :: time_derivative => difference_in_time
      !> The torque depends on the attitude; `.true.` unless overridden.
      procedure :: needs_attitude => attitude_needed
      !> D of a linear series: τ = DΩ; body axes, N m s.
      procedure :: series_drag => no_drag
      !> n, space axes, where the torque depends on γ = R(q)ᵀn; zero: it does not.
      procedure :: series_direction => no_direction
      !> Coefficient of a general series of τ; of a series in space axes, there.
      procedure :: series_torque => no_torque
   end type torque_t

   !> A rotor of constant momentum along body axes: L = JΩ + h, T = ½(L-h)ᵀJ⁻¹(L-h).
   type, extends(effect_t) :: rotor_t
      !> h, body axes, N m s.
      real(wp) :: momentum(3) = 0.0_wp
   contains
      procedure :: series_kind => constant_series
      procedure :: is_moderate => rotor_is_moderate
   end type rotor_t

   abstract interface
      !> U(γ), J.
      pure real(wp) function potential_energy(self, gamma)
         import :: potential_t, wp
         class(potential_t), intent(in) :: self
         !> γ, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
      end function potential_energy

      !> ∇U(γ), body axes; shape (3).
      pure function potential_gradient(self, gamma) result(gradient)
         import :: potential_t, wp
         class(potential_t), intent(in) :: self
         !> γ, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
         real(wp) :: gradient(3)
      end function potential_gradient

      !> τ, body axes, N m; shape (3).
      pure function body_torque(self, t, q, omega) result(tau)
         import :: torque_t, wp
         class(torque_t), intent(in) :: self
         !> s.
         real(wp), intent(in) :: t
         !> Attitude, unit quaternion, body→space; shape (4).
         real(wp), intent(in) :: q(4)
         !> Ω, body axes, rad/s; shape (3).
         real(wp), intent(in) :: omega(3)
         real(wp) :: tau(3)
      end function body_torque
   end interface

contains

   !> n at a time, s; shape (3).
   pure function fixed_direction(self, t) result(n)
      class(potential_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%direction
   end function fixed_direction

   !> ∂V/∂t at a time, W.
   pure real(wp) function no_power(self, q, t)
      class(potential_t), intent(in) :: self
      !> Unit quaternion, body→space, shape (4); s.
      real(wp), intent(in) :: q(4), t
      no_power = 0.0_wp
   end function no_power

   !> Coefficients of n from a time on.
   pure subroutine fixed_series(self, t, time_unit, n)
      class(potential_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t, time_unit
      !> Space axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      n = 0.0_wp
      n(:, 0) = self%direction
   end subroutine fixed_series

   pure logical function not_judged(self)
      class(effect_t), intent(in) :: self
      not_judged = .true.
   end function not_judged

   !> True where the effect's torque in axes that turn with the body is the same function of γ, Ω and t in all axes that
   !> differ from them by a turn about the axis, and its potential the same function of γ.
   pure logical function no_axis(self, axis)
      class(effect_t), intent(in) :: self
      !> Body axis: 1, 2 or 3.
      integer, intent(in) :: axis
      no_axis = .false.
   end function no_axis

   !> An effect of which nothing is known.
   pure subroutine not_bounded(self, map, radius, gamma, slack, bounds)
      class(effect_t), intent(in) :: self
      !> A, from body components.
      type(linear_map_t), intent(in) :: map
      !> ρ: the bounds hold for |b| ≤ ρ.
      real(wp), intent(in) :: radius
      !> γ = Rᵀn of a potential at the start of the step, body axes; shape (3). The bounds hold wherever γ at the
      !> start is no farther from it than `slack` times |n|: at every attitude for a slack of 2.
      real(wp), intent(in) :: gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = .false.
   end subroutine not_bounded

   !> A potential with Gonzalez's discrete gradient, by the bounds that are given.
   pure subroutine bound_potential(self, map, radius, gamma, slack, bounds)
      class(potential_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      associate (given => self%given)
         bounds%known = given%known
         if (given%known) bounds = bounds_of_potential(map, radius, vector_length(self%direction), given%first, &
                                                       given%second, given%third)
      end associate
   end subroutine bound_potential

   !> A torque by the bounds that are given.
   pure subroutine bound_torque(self, map, radius, gamma, slack, bounds)
      class(torque_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      associate (given => self%given)
         bounds%known = given%known
         if (given%known) &
            bounds = bounds_of_torque(map, radius, given%first, given%second, given%third, given%rate)
      end associate
   end subroutine bound_torque

   pure logical function rotor_is_moderate(self)
      class(rotor_t), intent(in) :: self
      rotor_is_moderate = all(is_moderate(self%momentum))
   end function rotor_is_moderate

   !> Central differences of ∇U with steps of ε^(1/3) of |γ|, where their error and round-off are alike: exact to
   !> round-off for quadratic U.
   pure function difference_hessian(self, gamma) result(hessian)
      class(potential_t), intent(in) :: self
      !> γ, body axes; shape (3).
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      real(wp) :: h, shift(3)
      integer :: i
      h = eps**(1.0_wp/3)*norm2(gamma)
      if (h == 0.0_wp) h = eps**(1.0_wp/3)
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         hessian(:, i) = (self%gradient(gamma + shift) - self%gradient(gamma - shift))/(2*h)
      end do
   end function difference_hessian

   !> ∇U(γ̄) + ((ΔU - ∇U(γ̄)·Δγ)/|Δγ|²) Δγ (Gonzalez 1996, eq. 3.2), γ̄ the mean of the ends: the discrete gradient of
   !> any U. Where Δγ is so short that its second term would be noise, ∇U(γ̄) alone closes to round-off.
   pure function gonzalez_gradient(self, gamma0, gamma1) result(gradient)
      class(potential_t), intent(in) :: self
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      real(wp) :: delta(3)
      delta = gamma1 - gamma0
      gradient = self%gradient(0.5_wp*(gamma0 + gamma1))
      if (is_short(delta, gamma0)) return
      gradient = gradient + ((self%energy(gamma1) - self%energy(gamma0) - dot_product(gradient, delta)) &
                             /dot_product(delta, delta))*delta
   end function gonzalez_gradient

   !> Derivative of `gonzalez_gradient` by γ1.
   pure function gonzalez_hessian(self, gamma0, gamma1) result(hessian)
      class(potential_t), intent(in) :: self
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      !> ∂∇̄Uᵢ/∂γ1ⱼ
      real(wp) :: hessian(3, 3)
      real(wp) :: delta(3), middle(3), slope(3), square, defect
      integer :: i, j
      delta = gamma1 - gamma0
      hessian = 0.5_wp*self%hessian(0.5_wp*(gamma0 + gamma1))
      if (is_short(delta, gamma0)) return
      middle = self%gradient(0.5_wp*(gamma0 + gamma1))
      square = dot_product(delta, delta)
      defect = (self%energy(gamma1) - self%energy(gamma0) - dot_product(middle, delta))/square
      slope = (self%gradient(gamma1) - middle - matmul(delta, hessian))/square - (2*defect/square)*delta
      do j = 1, 3
         do i = 1, 3
            hessian(i, j) = hessian(i, j) + delta(i)*slope(j)
         end do
         hessian(j, j) = hessian(j, j) + defect
      end do
   end function gonzalez_hessian

   !> |Δγ| < ε^(1/3) |γ|: ΔU - ∇U(γ̄)·Δγ, of third order in Δγ, is round-off of U.
   pure logical function is_short(delta, gamma)
      real(wp), intent(in) :: delta(3), gamma(3)
      is_short = dot_product(delta, delta) <= eps**(2.0_wp/3)*dot_product(gamma, gamma)
   end function is_short

   !> Central differences of τ. The steps suit a torque that varies over angles of order 1 and rates of order |Ω|.
   pure subroutine difference_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(torque_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> ∂τ/∂θ, θ a rotation vector in body axes: q → q∘exp(θ/2).
      real(wp), intent(out) :: by_rotation(3, 3)
      !> ∂τ/∂Ω, body axes.
      real(wp), intent(out) :: by_rate(3, 3)
      real(wp) :: h, shift(3)
      integer :: i
      by_rotation = 0.0_wp
      h = eps**(1.0_wp/3)
      if (self%needs_attitude()) then
         do i = 1, 3
            shift = 0.0_wp
            shift(i) = 0.5_wp*h
            by_rotation(:, i) = (self%torque(t, turned(q, shift), omega) &
                                 - self%torque(t, turned(q, -shift), omega))/(2*h)
         end do
      end if
      h = h*max(norm2(omega), 1.0_wp)
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         by_rate(:, i) = (self%torque(t, q, omega + shift) - self%torque(t, q, omega - shift))/(2*h)
      end do
   end subroutine difference_derivatives

   !> Central difference of τ over ε^(1/3) of a time in which it may change much.
   pure function difference_in_time(self, t, q, omega, span) result(derivative)
      class(torque_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> s; not 0.
      real(wp), intent(in) :: span
      !> Body axes, N m/s; shape (3).
      real(wp) :: derivative(3)
      real(wp) :: h
      h = eps**(1.0_wp/3)*span
      derivative = (self%torque(t + h, q, omega) - self%torque(t - h, q, omega))/(2*h)
   end function difference_in_time

   !> q∘(1, half) normalised: q turned by about the small body rotation 2 half.
   pure function turned(q, half) result(r)
      real(wp), intent(in) :: q(4), half(3)
      real(wp) :: r(4)
      r = quat_product(q, [1.0_wp, half])
      r = r/norm2(r)
   end function turned

   !> ∂τ/∂θ of a torque fixed in space: δ(R(q)ᵀν) = (R(q)ᵀν)×δθ.
   pure function turning_of(tau) result(by_rotation)
      !> R(q)ᵀν, body axes, N m; shape (3).
      real(wp), intent(in) :: tau(3)
      real(wp) :: by_rotation(3, 3)
      by_rotation(:, 1) = [0.0_wp, tau(3), -tau(2)]
      by_rotation(:, 2) = [-tau(3), 0.0_wp, tau(1)]
      by_rotation(:, 3) = [tau(2), -tau(1), 0.0_wp]
   end function turning_of

   !> The torque acts at all times.
   pure subroutine always(self, start, stop)
      class(torque_t), intent(in) :: self
      !> s.
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine always

   !> True inside the window and on its ends, for a torque that is on.
   pure logical function acts_at(self, t)
      class(torque_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      real(wp) :: start, stop
      call self%window(start, stop)
      acts_at = t >= start .and. t <= stop .and. self%on
   end function acts_at

   !> All times.
   pure subroutine one_piece(self, moment, start, stop)
      class(torque_t), intent(in) :: self
      !> A time inside of a step, s.
      real(wp), intent(in) :: moment
      !> s.
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine one_piece

   !> The first end of the window behind a time; beyond all times where there is none.
   pure real(wp) function next_end(self, t, sense) result(next)
      class(torque_t), intent(in) :: self
      !> s, and which way time goes: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: ends(2)
      integer :: i
      call self%window(ends(1), ends(2))
      next = sense*huge(next)
      do i = 1, 2
         ! No differences: they could overflow.
         if (sense*ends(i) > sense*t .and. sense*ends(i) < sense*next) next = ends(i)
      end do
   end function next_end

   pure logical function attitude_needed(self)
      class(torque_t), intent(in) :: self
      attitude_needed = .true.
   end function attitude_needed

   pure integer function no_kind(self)
      class(effect_t), intent(in) :: self
      no_kind = NO_SERIES
   end function no_kind

   !> A constant momentum needs nothing.
   pure integer function constant_series(self)
      class(rotor_t), intent(in) :: self
      constant_series = LINEAR_SERIES
   end function constant_series

   pure integer function no_auxiliary(self)
      class(effect_t), intent(in) :: self
      no_auxiliary = 0
   end function no_auxiliary

   pure function no_moment(self) result(moment)
      class(potential_t), intent(in) :: self
      real(wp) :: moment(3)
      moment = 0.0_wp
   end function no_moment

   pure function no_drag(self) result(drag)
      class(torque_t), intent(in) :: self
      real(wp) :: drag(3, 3)
      drag = 0.0_wp
   end function no_drag

   pure function no_direction(self) result(direction)
      class(torque_t), intent(in) :: self
      real(wp) :: direction(3)
      direction = 0.0_wp
   end function no_direction

   !> Coefficient k of γ×∇U.
   pure subroutine no_potential_torque(self, k, gamma, auxiliary, tau)
      class(potential_t), intent(in) :: self
      integer, intent(in) :: k
      !> Coefficients 0..k of γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Coefficients 0..k-1 of the auxiliary series on entry, 0..k on exit; shape (0:highest_order,
      !> auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      tau = 0.0_wp
   end subroutine no_potential_torque

   !> Coefficient k of τ.
   pure subroutine no_torque(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(torque_t), intent(in) :: self
      integer, intent(in) :: k
      !> t₀ and the unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Coefficients 0..k of Ω and of γ, body axes; shape (3, 0:k). γ is zero where there is no `series_direction`.
      real(wp), intent(in) :: omega(3, 0:k), gamma(3, 0:k)
      !> Coefficients 0..k-1 of the auxiliary series on entry, 0..k on exit; shape (0:highest_order,
      !> auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      tau = 0.0_wp
   end subroutine no_torque

end module nutate_effect
