!> The motion of a rigid body in a step as four power series in time: the momentum, and three directions fixed in space,
!> in body axes.
!>
!>     L̇ = L×Ω + τ,   Ė = E×Ω,   Ω = J⁻¹(L - h),   E = R(q)ᵀe
!>
!> All four rotate against the body alike, so that they are the lanes of one product with Ω, as many as a vector
!> register of AVX2 holds. The equations of every system are these and terms linear in the lanes: tops, rotors, wheels
!> and rotating axes need no products of their own.
!>
!> If the space axes rotate at ω, E is fixed in them: `Ė = E×(Ω - Rᵀω)`, and Rᵀω is a sum of the three rows with
!> constant weights, so that `E×Rᵀω` needs no products.
!>
!> The rotation since the start replaces the rows where no torque depends on the attitude: `ċ = ½ c∘Ω`.
!>
!> If body and effects are symmetric about an axis, all is computed in the non-spinning (Resal) frame
!> (`nutate_axial_frame`): L/J₁ replaces Ω, `L' = τ`, and the angle of the body in that frame is one more series.
module nutate_row_series
   use nutate_axial_frame, only: axial_frame_t
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   use nutate_torque_series, only: torque_series_t
   use nutate_wheel_series, only: wheel_series_t
   implicit none
   private

   public :: row_series_t, steepest_growth

   !> Coefficients of Ω that grow faster than this to the power of their index belong to a unit of time far longer than
   !> any step; up to there products of two at the highest order stay below 1e224.
   real(wp), parameter :: steepest_growth = 1e4_wp

   !> Series of one step.
   type :: row_series_t
      !> Highest coefficient; set by the caller.
      integer :: order = 0
      !> True if no effect has to supply coefficients: for a rigid body in non-rotating space axes with linear
      !> potentials, and torques and motors that are linear in Ω or depend on time alone.
      logical :: asks_no_effect = .false.
      !> Start and unit of time, s; set by the caller; the latter is negative backwards in time.
      real(wp) :: t = 0.0_wp, time_unit = 1.0_wp
      !> L, N m s, and the rows E1, E2, E3; the caller sets coefficient 0; shape (lane, component, 0:highest_order).
      real(wp) :: lanes(4, 3, 0:highest_order) = 0.0_wp
      !> Rate of the axes used, Ω or L/J₁, times the unit of time; shape (3, 0:highest_order).
      real(wp) :: omega(3, 0:highest_order) = 0.0_wp
      !> Angle of the body in the axial frame, or about the momentum of a free body, rad; shape (0:highest_order).
      real(wp) :: angle(0:highest_order) = 0.0_wp
      type(torque_series_t) :: torques
      !> Momenta of the wheels, if there are any.
      type(wheel_series_t), allocatable :: wheels
      !> The axial frame, if there is one.
      type(axial_frame_t) :: axial
      !> True if no effect has to supply coefficients, and none depends on the attitude: the lanes are the rotation
      !> since the start, and after it L.
      logical :: by_rotation = .false.
      !> The rows rotate in space; components of their rate along them, rad/s; shape (3).
      logical :: frame_turns = .false.
      real(wp) :: frame_rate(3) = 0.0_wp
   end type row_series_t

end module nutate_row_series
