!> The torque-free step of a batch of bodies: one body a SIMD lane, each with its own numbers.
!>
!> It is the discrete Moser-Veselov map, with moments corrected so that its order is 4 (J. Moser, A. P. Veselov, Commun.
!> Math. Phys. 139 (1991) 217-243; E. Hairer, G. Vilmart, J. Phys. A 39 (2006) 13225-13235). With x = tan(½θ) n of the
!> rotation in the step and x0 = ½Δt J⁻¹L0,
!>
!>     x + J⁻¹(x×Jx) = (1 + |x|²) x0,   q1 = q0∘(1 + x)/√(1 + |x|²),   L1 = L0 - (4/Δt) (x×Jx)/(1 + |x|²).
!>
!> Space momentum and kinetic energy are exact. It is the equation of the reduced step but for the factor of x0. With a
!> constant J it is symplectic, so that with kicks between the drifts the energy of interacting bodies does not drift.
!> J there is J̃,
!>
!>     1/J̃_i = (1 + s)/J_i + d,   s = Δt²Σσ_iΩ_i²,   σ_1 = (J1² - J1J2 - J1J3 - 2J2J3)/(12 J2J3),
!>                                d = Δt²Σδ_iΩ_i²,   δ_1 = (J2 + J3 - J1)/(12 J2J3):
!>
!> s and d depend on the energy and |L| alone, which the step keeps, so that it stays reversible; but they depend on the
!> state, so that the step is symplectic up to terms of Δt⁵.
!>
!> Certificate. With g a bound of |J⁻¹(x×Jx)|/|x|², the second derivative is bounded by 2(|x0| + g). Where
!> 4|x0|(|x0| + g) < 1, Newton's iteration converges to a root that is alone in |x| < 1/(2(|x0| + g)) (Newton and
!> Kantorovich) and continues x = 0 as Δt grows. The same must hold at the end of the step, so that the way back is
!> certified too.
!>
!> Choices are written 0.5 + sign(0.5, a), 1 or 0 as a is positive or negative: gfortran leaves loops with several
!> `merge` scalar.
module nutate_bodies_drift
   use nutate_kinds, only: wp, eps
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: drift_lanes_t, body_class_t, make_class, put_class, drift_lanes

   !> Chord iterations after one of Newton: some ten are needed where the certificate ends.
   integer, parameter :: most_chords = 16
   !> 1/√3: Σ x_i²x_j² ≤ |x|⁴/3.
   real(wp), parameter :: share = 0.57735026918962577_wp
   !> Second derivatives of certified lanes are below this: |x0| < ½, g < 1 for bodies; others are tested at the end.
   real(wp), parameter :: curvature = 3.0_wp
   !> Part of the moments up to which they are corrected: steps of some half radian, whose error is then 1e-4.
   real(wp), parameter :: largest_correction = 0.1_wp

   !> A class of bodies, all reals: FORTRAN 77 programs hold it in an array of their own.
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

   !> Bodies under way. No component has a first value: they would be set at every call.
   type :: drift_lanes_t
      !> Of the body's class: 1/J, 4σ, 4δ; shape (lanes, 3). Principal axes; shape (lanes, row, column).
      real(wp) :: inverse(lanes, 3), stretch(lanes, 3), shift(lanes, 3), axes(lanes, 3, 3)
      !> ½Δt over the unit of the moments, and its inverse; `mild` of the class.
      real(wp) :: scale(lanes), unscale(lanes), mild(lanes)
      !> Attitude; shape (lanes, 4).
      real(wp) :: q(lanes, 4)
      !> Momentum: space axes, or principal axes; shape (lanes, 3).
      real(wp) :: momentum(lanes, 3)
      !> 1 where the step is certified, else 0.
      real(wp) :: certified(lanes)
      !> Momentum in principal axes times `scale`; the corrected 1/J; (J3 - J2), (J1 - J3), (J2 - J1); those over J.
      real(wp), private :: l(lanes, 3), corrected(lanes, 3), gap(lanes, 3), twist(lanes, 3)
      !> x0, x; the inverse of the Jacobian; |x0|² of the end.
      real(wp), private :: start(lanes, 3), x(lanes, 3), rows(lanes, 3, 3)
      !> |last increment|², that when the Jacobian was computed; bound on 1/(2|x0|); 1 where x still changes.
      real(wp), private :: change(lanes), moved(lanes), bound(lanes), moving(lanes)
      !> 1 where the certificate has to be computed.
      real(wp), private :: doubtful(lanes)
   end type drift_lanes_t

contains

   !> Makes a class.
   !>
   !> `mild`: s + d ≤ 0.02 changes moments by 5 % at most, and their differences over moments by 11 %. Then |x0| ≤ μ,
   !> the root |x| ≤ 2μ, and |x0| at the end is ≤ μ(1 + 8gμ): it is certified where 2μ(1 + 8gμ)(1 + g + ½g²) < 1.
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
      !> s, not zero.
      real(wp), intent(in) :: dt
      self%inverse(lane, :) = made%inverse
      self%stretch(lane, :) = made%stretch
      self%shift(lane, :) = made%shift
      self%axes(lane, :, :) = made%axes
      self%scale(lane) = (0.5_wp*dt)/made%unit
      self%unscale(lane) = made%unit/(0.5_wp*dt)
      self%mild(lane) = made%mild
   end subroutine put_class

   !> Moves attitude and momentum of all lanes. A lane that is not certified keeps its momentum; its attitude is
   !> undefined afterwards.
   pure subroutine drift_lanes(self, in_space, turned)
      type(drift_lanes_t), intent(inout) :: self
      !> The momentum is in space axes, where it is constant; else it is in principal axes.
      logical, intent(in) :: in_space
      !> The principal axes of a class are not its body axes.
      logical, intent(in) :: turned
      logical :: doubtful
      integer :: k
      if (in_space) then
         call find_momenta(self, turned)
      else
         call scale_momenta(self)
      end if
      call correct_moments(self)
      ! What is certified does not depend on the shortcut: it follows from the certificate.
      doubtful = sum(self%doubtful) > 0.5_wp
      if (doubtful) call certify(self)
      call predict(self)
      call iterate_by_newton(self)
      do k = 1, most_chords
         call find_moving(self)
         if (sum(self%moving) < 0.5_wp) exit
         call iterate_by_chords(self)
      end do
      if (doubtful .or. k > most_chords) call judge(self)
      if (.not. in_space) call move_momenta(self)
      if (turned) call turn_increments(self)
      call turn(self)
   end subroutine drift_lanes

   !> Computes the momentum in principal axes, Rᵀl, scaled.
   pure subroutine find_momenta(self, turned)
      type(drift_lanes_t), intent(inout) :: self
      logical, intent(in) :: turned
      real(wp) :: a, b, c, w, x, y, z
      integer :: i
      do i = 1, lanes
         w = self%q(i, 1)
         x = self%q(i, 2)
         y = self%q(i, 3)
         z = self%q(i, 4)
         ! 2 v×l, v the vector part.
         a = 2*(y*self%momentum(i, 3) - z*self%momentum(i, 2))
         b = 2*(z*self%momentum(i, 1) - x*self%momentum(i, 3))
         c = 2*(x*self%momentum(i, 2) - y*self%momentum(i, 1))
         self%l(i, 1) = self%scale(i)*(self%momentum(i, 1) - w*a + (y*c - z*b))
         self%l(i, 2) = self%scale(i)*(self%momentum(i, 2) - w*b + (z*a - x*c))
         self%l(i, 3) = self%scale(i)*(self%momentum(i, 3) - w*c + (x*b - y*a))
      end do
      if (.not. turned) return
      do i = 1, lanes
         a = self%l(i, 1)
         b = self%l(i, 2)
         c = self%l(i, 3)
         self%l(i, 1) = self%axes(i, 1, 1)*a + self%axes(i, 2, 1)*b + self%axes(i, 3, 1)*c
         self%l(i, 2) = self%axes(i, 1, 2)*a + self%axes(i, 2, 2)*b + self%axes(i, 3, 2)*c
         self%l(i, 3) = self%axes(i, 1, 3)*a + self%axes(i, 2, 3)*b + self%axes(i, 3, 3)*c
      end do
   end subroutine find_momenta

   !> Scales the momentum in principal axes.
   pure subroutine scale_momenta(self)
      type(drift_lanes_t), intent(inout) :: self
      integer :: i
      do i = 1, lanes
         self%l(i, 1) = self%scale(i)*self%momentum(i, 1)
         self%l(i, 2) = self%scale(i)*self%momentum(i, 2)
         self%l(i, 3) = self%scale(i)*self%momentum(i, 3)
      end do
   end subroutine scale_momenta

   !> Computes J̃ and x0; a lane that turns by radians in the step counts as a body at rest, not certified.
   pure subroutine correct_moments(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: l1, l2, l3, w1, w2, w3, s, d, slow, a1, a2, a3, ratio
      integer :: i
      do i = 1, lanes
         slow = (0.5_wp + sign(0.5_wp, 1 - abs(self%l(i, 1))))*(0.5_wp + sign(0.5_wp, 1 - abs(self%l(i, 2))))* &
                (0.5_wp + sign(0.5_wp, 1 - abs(self%l(i, 3))))
         l1 = slow*self%l(i, 1)
         l2 = slow*self%l(i, 2)
         l3 = slow*self%l(i, 3)
         ! ½ΔtΩ
         w1 = self%inverse(i, 1)*l1
         w2 = self%inverse(i, 2)*l2
         w3 = self%inverse(i, 3)*l3
         s = self%stretch(i, 1)*(w1*w1) + self%stretch(i, 2)*(w2*w2) + self%stretch(i, 3)*(w3*w3)
         d = self%shift(i, 1)*(w1*w1) + self%shift(i, 2)*(w2*w2) + self%shift(i, 3)*(w3*w3)
         slow = slow*(0.5_wp + sign(0.5_wp, largest_correction - (abs(s) + abs(d))))
         s = slow*s
         d = slow*d
         a1 = self%inverse(i, 1) + (self%inverse(i, 1)*s + d)
         a2 = self%inverse(i, 2) + (self%inverse(i, 2)*s + d)
         a3 = self%inverse(i, 3) + (self%inverse(i, 3)*s + d)
         ratio = (1 + s)/(a1*a2*a3)
         self%gap(i, 1) = ratio*a1*(self%inverse(i, 2) - self%inverse(i, 3))
         self%gap(i, 2) = ratio*a2*(self%inverse(i, 3) - self%inverse(i, 1))
         self%gap(i, 3) = ratio*a3*(self%inverse(i, 1) - self%inverse(i, 2))
         self%twist(i, 1) = a1*self%gap(i, 1)
         self%twist(i, 2) = a2*self%gap(i, 2)
         self%twist(i, 3) = a3*self%gap(i, 3)
         self%start(i, 1) = a1*l1
         self%start(i, 2) = a2*l2
         self%start(i, 3) = a3*l3
         self%certified(i) = slow
         self%doubtful(i) = 1 - slow*(0.5_wp + sign(0.5_wp, self%mild(i) - (w1*w1 + w2*w2 + w3*w3)))
      end do
   end subroutine correct_moments

   !> Certifies the root by |x0|: 4|x0|(|x0| + g) < 1 where 2|x0| < 1/(1 + g + ½g²), since √(1 + g²) ≤ 1 + ½g².
   pure subroutine certify(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: g, other, square, keep
      integer :: i
      do i = 1, lanes
         g = abs(self%twist(i, 1))
         other = abs(self%twist(i, 2))
         g = 0.5_wp*(g + other + abs(g - other))
         other = abs(self%twist(i, 3))
         g = share*(0.5_wp*(g + other + abs(g - other)))
         self%bound(i) = 1 + g*(1 + 0.5_wp*g)
         square = self%start(i, 1)**2 + self%start(i, 2)**2 + self%start(i, 3)**2
         keep = self%certified(i)*(0.5_wp + sign(0.5_wp, 1 - 4*square*self%bound(i)**2))
         self%certified(i) = keep
         self%start(i, 1) = keep*self%start(i, 1)
         self%start(i, 2) = keep*self%start(i, 2)
         self%start(i, 3) = keep*self%start(i, 3)
      end do
   end subroutine certify

   !> Predicts x by three iterations of x = (1 + |x|²)x0 - J⁻¹(x×Jx) from x0.
   pure subroutine predict(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3, y1, y2, y3, z1, z2, z3, square
      integer :: i
      do i = 1, lanes
         x1 = self%start(i, 1)
         x2 = self%start(i, 2)
         x3 = self%start(i, 3)
         square = 1 + (x1*x1 + x2*x2 + x3*x3)
         y1 = square*x1 - self%twist(i, 1)*(x2*x3)
         y2 = square*x2 - self%twist(i, 2)*(x3*x1)
         y3 = square*x3 - self%twist(i, 3)*(x1*x2)
         square = 1 + (y1*y1 + y2*y2 + y3*y3)
         z1 = square*x1 - self%twist(i, 1)*(y2*y3)
         z2 = square*x2 - self%twist(i, 2)*(y3*y1)
         z3 = square*x3 - self%twist(i, 3)*(y1*y2)
         square = 1 + (z1*z1 + z2*z2 + z3*z3)
         self%x(i, 1) = square*x1 - self%twist(i, 1)*(z2*z3)
         self%x(i, 2) = square*x2 - self%twist(i, 2)*(z3*z1)
         self%x(i, 3) = square*x3 - self%twist(i, 3)*(z1*z2)
      end do
   end subroutine predict

   !> An iteration by Newton: F' = 1 + J⁻¹(...) - 2 x0 xᵀ, inverted by its cofactors.
   pure subroutine iterate_by_newton(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3, t1, t2, t3, f1, f2, f3, square, inverse
      real(wp) :: a11, a12, a13, a21, a22, a23, a31, a32, a33, c11, c12, c13
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         t1 = self%twist(i, 1)
         t2 = self%twist(i, 2)
         t3 = self%twist(i, 3)
         square = 1 + (x1*x1 + x2*x2 + x3*x3)
         f1 = x1 + t1*(x2*x3) - square*self%start(i, 1)
         f2 = x2 + t2*(x3*x1) - square*self%start(i, 2)
         f3 = x3 + t3*(x1*x2) - square*self%start(i, 3)
         a11 = 1 - 2*self%start(i, 1)*x1
         a12 = t1*x3 - 2*self%start(i, 1)*x2
         a13 = t1*x2 - 2*self%start(i, 1)*x3
         a21 = t2*x3 - 2*self%start(i, 2)*x1
         a22 = 1 - 2*self%start(i, 2)*x2
         a23 = t2*x1 - 2*self%start(i, 2)*x3
         a31 = t3*x2 - 2*self%start(i, 3)*x1
         a32 = t3*x1 - 2*self%start(i, 3)*x2
         a33 = 1 - 2*self%start(i, 3)*x3
         c11 = a22*a33 - a23*a32
         c12 = a23*a31 - a21*a33
         c13 = a21*a32 - a22*a31
         inverse = 1/(a11*c11 + a12*c12 + a13*c13)
         self%rows(i, 1, 1) = inverse*c11
         self%rows(i, 2, 1) = inverse*c12
         self%rows(i, 3, 1) = inverse*c13
         self%rows(i, 1, 2) = inverse*(a13*a32 - a12*a33)
         self%rows(i, 2, 2) = inverse*(a11*a33 - a13*a31)
         self%rows(i, 3, 2) = inverse*(a12*a31 - a11*a32)
         self%rows(i, 1, 3) = inverse*(a12*a23 - a13*a22)
         self%rows(i, 2, 3) = inverse*(a13*a21 - a11*a23)
         self%rows(i, 3, 3) = inverse*(a11*a22 - a12*a21)
         x1 = self%rows(i, 1, 1)*f1 + self%rows(i, 1, 2)*f2 + self%rows(i, 1, 3)*f3
         x2 = self%rows(i, 2, 1)*f1 + self%rows(i, 2, 2)*f2 + self%rows(i, 2, 3)*f3
         x3 = self%rows(i, 3, 1)*f1 + self%rows(i, 3, 2)*f2 + self%rows(i, 3, 3)*f3
         self%x(i, 1) = self%x(i, 1) - x1
         self%x(i, 2) = self%x(i, 2) - x2
         self%x(i, 3) = self%x(i, 3) - x3
         self%change(i) = x1*x1 + x2*x2 + x3*x3
         self%moved(i) = self%change(i)
      end do
   end subroutine iterate_by_newton

   !> Marks the lanes whose next increment would still change x: its length is at most the curvature times the last one
   !> times the way since the Jacobian was computed. A lane alone decides, so that its bits depend on no other.
   pure subroutine find_moving(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp), parameter :: round_off = (0.25_wp*eps/curvature)**2
      integer :: i
      do i = 1, lanes
         self%moving(i) = 0.5_wp - sign(0.5_wp, round_off*(self%x(i, 1)**2 + self%x(i, 2)**2 + self%x(i, 3)**2) - &
                                        self%change(i)*self%moved(i))
      end do
   end subroutine find_moving

   !> An iteration with the Jacobian of the last one by Newton, of the lanes that still move.
   pure subroutine iterate_by_chords(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3, f1, f2, f3, d1, d2, d3, square
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         square = 1 + (x1*x1 + x2*x2 + x3*x3)
         f1 = x1 + self%twist(i, 1)*(x2*x3) - square*self%start(i, 1)
         f2 = x2 + self%twist(i, 2)*(x3*x1) - square*self%start(i, 2)
         f3 = x3 + self%twist(i, 3)*(x1*x2) - square*self%start(i, 3)
         d1 = self%moving(i)*(self%rows(i, 1, 1)*f1 + self%rows(i, 1, 2)*f2 + self%rows(i, 1, 3)*f3)
         d2 = self%moving(i)*(self%rows(i, 2, 1)*f1 + self%rows(i, 2, 2)*f2 + self%rows(i, 2, 3)*f3)
         d3 = self%moving(i)*(self%rows(i, 3, 1)*f1 + self%rows(i, 3, 2)*f2 + self%rows(i, 3, 3)*f3)
         self%x(i, 1) = x1 - d1
         self%x(i, 2) = x2 - d2
         self%x(i, 3) = x3 - d3
         self%change(i) = d1*d1 + d2*d2 + d3*d3
      end do
   end subroutine iterate_by_chords

   !> Leaves certified what has converged to the root alone in its ball and is certified at the end too.
   pure subroutine judge(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp), parameter :: round_off = (16*eps)**2
      real(wp) :: x1, x2, x3, y1, y2, y3, square, limit
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         square = x1*x1 + x2*x2 + x3*x3
         y1 = x1 - self%twist(i, 1)*(x2*x3)
         y2 = x2 - self%twist(i, 2)*(x3*x1)
         y3 = x3 - self%twist(i, 3)*(x1*x2)
         limit = self%bound(i)*self%bound(i)
         self%certified(i) = self%certified(i)*(0.5_wp + sign(0.5_wp, 1 - limit*square))* &
            (0.5_wp + sign(0.5_wp, (1 + square)**2 - 4*limit*(y1*y1 + y2*y2 + y3*y3)))* &
            (0.5_wp + sign(0.5_wp, round_off*square - self%moving(i)*self%change(i)))
      end do
   end subroutine judge

   !> L1 = L0 - (4/Δt) (x×Jx)/(1 + |x|²), principal axes; L0 where the lane is not certified.
   pure subroutine move_momenta(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3, factor
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         factor = self%certified(i)*(2*self%unscale(i)/(1 + (x1*x1 + x2*x2 + x3*x3)))
         self%momentum(i, 1) = self%momentum(i, 1) - factor*(self%gap(i, 1)*(x2*x3))
         self%momentum(i, 2) = self%momentum(i, 2) - factor*(self%gap(i, 2)*(x3*x1))
         self%momentum(i, 3) = self%momentum(i, 3) - factor*(self%gap(i, 3)*(x1*x2))
      end do
   end subroutine move_momenta

   !> Turns x from principal to body axes.
   pure subroutine turn_increments(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         self%x(i, 1) = self%axes(i, 1, 1)*x1 + self%axes(i, 1, 2)*x2 + self%axes(i, 1, 3)*x3
         self%x(i, 2) = self%axes(i, 2, 1)*x1 + self%axes(i, 2, 2)*x2 + self%axes(i, 2, 3)*x3
         self%x(i, 3) = self%axes(i, 3, 1)*x1 + self%axes(i, 3, 2)*x2 + self%axes(i, 3, 3)*x3
      end do
   end subroutine turn_increments

   !> q1 = q0 + q0∘(c - 1), c = (1 + x)/√(1 + |x|²): one rounding a component. What |q0| lacks of 1 goes with it.
   pure subroutine turn(self)
      type(drift_lanes_t), intent(inout) :: self
      real(wp) :: x1, x2, x3, w, x, y, z, square, root, inverse, c
      integer :: i
      do i = 1, lanes
         x1 = self%x(i, 1)
         x2 = self%x(i, 2)
         x3 = self%x(i, 3)
         w = self%q(i, 1)
         x = self%q(i, 2)
         y = self%q(i, 3)
         z = self%q(i, 4)
         square = x1*x1 + x2*x2 + x3*x3
         root = sqrt(1 + square)
         inverse = 1/(root*(1 + root))
         c = 0.5_wp*(1 - (w*w + x*x + y*y + z*z)) - square*inverse
         inverse = inverse*(1 + root)
         x1 = inverse*x1
         x2 = inverse*x2
         x3 = inverse*x3
         self%q(i, 1) = w + (c*w - (x*x1 + y*x2 + z*x3))
         self%q(i, 2) = x + (c*x + (w*x1 + (y*x3 - z*x2)))
         self%q(i, 3) = y + (c*y + (w*x2 + (z*x1 - x*x3)))
         self%q(i, 4) = z + (c*z + (w*x3 + (x*x2 - y*x1)))
      end do
   end subroutine turn

end module nutate_bodies_drift
