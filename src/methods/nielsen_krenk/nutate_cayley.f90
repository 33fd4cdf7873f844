!> The Cayley map c = (1+b)∘(1-b)⁻¹ of a step, b = ¼Δt Ω̄, with more digits than double precision has.
module nutate_cayley
   use nutate_kinds, only: wp
   implicit none
   private

   public :: measure_turn

contains

   !> Computes β = |b|² and 2/(1+β), with which c - 1 = 2(b - β)/(1+β), and the relative excess of the length of this c:
   !> a part of ε, but in a steady spin the same part in every step. The digits lost by rounding are computed from
   !> products of halves, which are exact.
   pure subroutine measure_turn(b, beta, factor, excess)
      !> b, |b| below 1, as in every accepted step; shape (3).
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: beta, factor, excess
      !> Sums with this number are integer multiples of 2⁻²⁵, whose products have 50 digits after the point.
      real(wp), parameter :: coarse = 1.5_wp*2.0_wp**27
      real(wp) :: h1, h2, h3, high, low, lost, factor_half, beta_half, missing
      h1 = (b(1) + coarse) - coarse
      h2 = (b(2) + coarse) - coarse
      h3 = (b(3) + coarse) - coarse
      high = h1*h1 + h2*h2 + h3*h3
      low = (b(1) - h1)*(b(1) + h1) + (b(2) - h2)*(b(2) + h2) + (b(3) - h3)*(b(3) + h3)
      beta = high + low
      lost = (high - beta) + low
      factor = 2/(1 + beta)
      ! 2 - factor (1 + beta)
      factor_half = (factor + coarse) - coarse
      beta_half = (beta + coarse) - coarse
      missing = ((2 - factor) - factor_half*beta_half) - (factor_half*(beta - beta_half) + (factor - factor_half)*beta)
      excess = (0.5_wp*factor)*(factor*lost - beta*missing)
   end subroutine measure_turn

end module nutate_cayley
