!> What all effects have in common: names and switches, and what is asked of each one.
module nutate_any_effect
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   implicit none
   private

   public :: effect_t, given_bounds_t, rotor_t
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

   !> A rotor of constant momentum along body axes: L = JΩ + h, T = ½(L-h)ᵀJ⁻¹(L-h).
   type, extends(effect_t) :: rotor_t
      !> h, body axes, N m s.
      real(wp) :: momentum(3) = 0.0_wp
   contains
      procedure :: series_kind => constant_series
      procedure :: is_moderate => rotor_is_moderate
   end type rotor_t

contains

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

   !> An effect of any kind.
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

   pure logical function rotor_is_moderate(self)
      class(rotor_t), intent(in) :: self
      rotor_is_moderate = all(is_moderate(self%momentum))
   end function rotor_is_moderate

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

end module nutate_any_effect
