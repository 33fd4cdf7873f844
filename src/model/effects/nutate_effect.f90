!> Abstract types that every physical effect extends, one file each.
!>
!> A **potential** is a function `U(γ)` of the body components `γ = R(q)ᵀ n` of a direction `n` fixed in space. It
!> supplies `U` and `∇U`; the discrete gradient ∇̄U that conserves energy and the momentum about `n` is derived from
!> them here. It is the finite derivative of the potential that the step of Nielsen & Krenk (2012) requires: ∂V*/∂q =
!> γ'(q̄)ᵀ∇̄U has Δq·∂V*/∂q = ΔV (`nutate_discrete_forces`). A **torque** acts in body axes and does work. A **rotor**
!> adds a constant body momentum (`nutate_rotor`).
!>
!> An effect may supply the power series in time of its torque, from the series of γ and Ω: then the method 'taylor' can
!> integrate with it. All series are in `s = (t - t₀)/time_unit`; coefficient k is computed when the coefficients 0..k
!> of its arguments are known, for k = 0, 1, 2, ... in turn.
!>
!> An effect may supply its derivatives by its parameters: then sensitivities (`nutate_tangent`) to them can be
!> propagated.
!>
!> An effect may bound its torque in a step: then the root of a step can be certified to be the true one.
module nutate_effect
   use nutate_effect_base, only: effect_t, parameter_t, &
      NO_SERIES, LINEAR_SERIES, GENERAL_SERIES, SPACE_SERIES, TIME_SERIES
   use nutate_potential, only: potential_t
   use nutate_torque, only: torque_t
   implicit none
   private

   public :: effect_t, parameter_t, potential_t, torque_t
   public :: NO_SERIES, LINEAR_SERIES, GENERAL_SERIES, SPACE_SERIES, TIME_SERIES

end module nutate_effect
