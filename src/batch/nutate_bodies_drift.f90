!> The torque-free step of a batch of bodies: one body a SIMD lane, each with its own numbers.
!>
!> The step is the discrete Moser-Veselov map, with moments corrected so that its order is 4 (J. Moser, A. P. Veselov,
!> Commun. Math. Phys. 139 (1991) 217-243; E. Hairer, G. Vilmart, J. Phys. A 39 (2006) 13225-13235). With x = tan(½θ) n
!> of the rotation in the step and x0 = ½Δt J⁻¹L0,
!>
!>     x + J⁻¹(x×Jx) = (1 + |x|²) x0,   q1 = q0∘(1 + x)/√(1 + |x|²),   L1 = L0 - (4/Δt) (x×Jx)/(1 + |x|²).
!>
!> Space momentum and kinetic energy are exact. The equation is that of the reduced step but for the factor of x0. With
!> a constant J the map is symplectic, so that with kicks between the drifts the energy of interacting bodies does not
!> drift. In these equations J is J̃,
!>
!>     1/J̃_i = (1 + s)/J_i + d,   s = Δt²Σσ_iΩ_i²,   σ_1 = (J1² - J1J2 - J1J3 - 2J2J3)/(12 J2J3),
!>                                d = Δt²Σδ_iΩ_i²,   δ_1 = (J2 + J3 - J1)/(12 J2J3):
!>
!> s and d depend on the energy and |L| alone, which the step conserves, so that it stays reversible; but they depend on
!> the state, so that the step is symplectic up to terms of Δt⁵.
!>
!> Certificate. With g a bound of |J⁻¹(x×Jx)|/|x|², the second derivative is bounded by 2(|x0| + g). If 4|x0|(|x0| + g)
!> < 1, Newton's iteration converges to a root that is alone in |x| < 1/(2(|x0| + g)) (Newton and Kantorovich) and
!> continues x = 0 as Δt grows. This condition must hold at the end of the step too, so that the reverse step is
!> certified as well.
!>
!> Choices are written 0.5 + sign(0.5, a), 1 or 0 as a is positive or negative: gfortran leaves loops with several
!> `merge` scalar.
module nutate_bodies_drift
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: drift_lanes_t, body_class_t, make_class, put_class
   public :: most_chords, share, curvature, largest_correction

   !> Chord iterations after one of Newton: some ten are needed where the certificate ends.
   integer, parameter :: most_chords = 16
   !> 1/√3: Σ x_i²x_j² ≤ |x|⁴/3.
   real(wp), parameter :: share = 0.57735026918962577_wp
   !> Second derivatives of certified lanes are below this: |x0| < ½, g < 1 for bodies; others are tested at the end.
   real(wp), parameter :: curvature = 3.0_wp
   !> Part of the moments up to which they are corrected: steps of some half radian, whose error is then 1e-4.
   real(wp), parameter :: largest_correction = 0.1_wp

   !> A class of bodies, all reals: FORTRAN 77 programs hold it in their own array.
   type :: body_class_t
      !> Principal moments, kg m².
      real(wp) :: moments(3) = 1.0_wp
      !> Principal axes as columns, body axes.
      real(wp) :: axes(3, 3) = 0.0_wp
      !> Power of two next to the largest moment, kg m²; in that unit 1/J, 4σ and 4δ; shape (3).
      real(wp) :: unit = 1.0_wp, inverse(3) = 1.0_wp, stretch(3) = 0.0_wp, shift(3) = 0.0_wp
      !> |½ΔtΩ|² below which a drift is certified whatever its direction.
      real(wp) :: mild = 0.0_wp
   end type body_class_t

   !> Bodies in the lanes. Components have no default values, which would be set at every call.
   type :: drift_lanes_t
      !> Numbers of the body's class: J, kg m², and in its unit 1/J, 4σ, 4δ, shape (lanes, 3); principal axes, shape
      !> (lanes, row, column).
      real(wp) :: moments(lanes, 3), inverse(lanes, 3), stretch(lanes, 3), shift(lanes, 3), axes(lanes, 3, 3)
      !> ½Δt over the unit of the moments, and its inverse; `mild` of the class.
      real(wp) :: scale(lanes), unscale(lanes), mild(lanes)
      !> Attitude; shape (lanes, 4).
      real(wp) :: q(lanes, 4)
      !> Momentum: space axes, or principal axes; before and after the drift, `l` as the frame defines it; torque, N m,
      !> in the same axes; shape (lanes, 3).
      real(wp) :: momentum(lanes, 3), torque(lanes, 3)
      !> 1 if the step is certified, else 0.
      real(wp) :: certified(lanes)
      !> Momentum in principal axes times `scale`; (J3 - J2), (J1 - J3), (J2 - J1); these differences over J.
      real(wp) :: l(lanes, 3), gap(lanes, 3), twist(lanes, 3)
      !> x0, x; the inverse of the Jacobian.
      real(wp) :: start(lanes, 3), x(lanes, 3), rows(lanes, 3, 3)
      !> |last increment|², and its value when the Jacobian was computed; bound on 1/(2|x0|); 1 if x still changes.
      real(wp) :: change(lanes), moved(lanes), bound(lanes), moving(lanes)
      !> 1 if the certificate has to be computed.
      real(wp) :: doubtful(lanes)
   end type drift_lanes_t

contains

   !> Makes a class.
   !>
   !> `mild`: s + d ≤ 0.02 changes moments by 5 % at most, and their differences over moments by 11 %. Then |x0| ≤ μ,
   !> the root |x| ≤ 2μ, and |x0| at the end is ≤ μ(1 + 8gμ): the step is certified if 2μ(1 + 8gμ)(1 + g + ½g²) < 1.
   pure type(body_class_t) function make_class(moments, axes) result(made)
      !> Principal moments, kg m²; shape (3).
      real(wp), intent(in) :: moments(3)
      !> Principal axes as columns, body axes.
      real(wp), intent(in) :: axes(3, 3)
      real(wp) :: j(3), g, bound
      integer :: i, k, l
      g = 0.0_wp
      made%moments = moments
      made%unit = 2.0_wp**exponent(maxval(moments))
      j = moments/made%unit
      made%inverse = 1/j
      made%axes = axes
      do i = 1, 3
         k = 1 + modulo(i, 3)
         l = 1 + modulo(i + 1, 3)
         made%stretch(i) = ((j(i)/j(k))*((j(i) - j(k) - j(l))/j(l)) - 2)/3
         made%shift(i) = ((j(k) - j(i)) + j(l))/j(k)/j(l)/3
         g = max(g, abs(j(k) - j(l))/j(i))
      end do
      g = 1.11_wp*share*g
      bound = 1 + g*(1 + 0.5_wp*g)
      made%mild = min((0.98_wp/(bound + sqrt(bound*(bound + 16*g)))/1.05_wp)**2, &
                      0.02_wp/(maxval(abs(made%stretch)) + maxval(abs(made%shift))))
   end function make_class

   !> Fills a lane with the numbers of a class.
   pure subroutine put_class(self, lane, made, dt)
      type(drift_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(body_class_t), intent(in) :: made
      !> Time step, s, not zero.
      real(wp), intent(in) :: dt
      self%moments(lane, :) = made%moments
      self%inverse(lane, :) = made%inverse
      self%stretch(lane, :) = made%stretch
      self%shift(lane, :) = made%shift
      self%axes(lane, :, :) = made%axes
      self%scale(lane) = (0.5_wp*dt)/made%unit
      self%unscale(lane) = made%unit/(0.5_wp*dt)
      self%mild(lane) = made%mild
   end subroutine put_class

end module nutate_bodies_drift
