!> Derivatives of the closed solution of a free body with respect to its initial state and its moments.
!>
!> With the solution L = (C cn, σC√r sn, A dn)(u), u = u₀ + νt, in its axes c, b, a, Λ its derivative by C at fixed u
!> and |L|, and R = R(q0*∘q1):
!>
!>     ∂L1/∂L0 maps   L̇0/C → L̇1/C,   L0 → L1 + tL̇1,   Λ(u0) → Λ(u1) - t(C/A²)L̇1
!>     θ1 = Rᵀθ0 + [L1×(RᵀδL0 - δL1) + t(Ω0·δL0)L1]/|L|²
!>
!> so that no integral of the third kind is differentiated. If Ω is constant, δL1 = exp(Nt)δL0, N = [L]×J⁻¹ - [Ω]×,
!> N³ = sN. A moment at fixed L0: L1 by the derivatives of C, r, A, m, ν and u₀, and
!>
!>     θ1 = [-L1×δL1 - ½(∫Ω² dt + tΩ(0)²)L1]/|L|²
!>
!> Other changes of J rotate the principal axes.
module nutate_exact_tangent
   use nutate_carlson, only: carlson_rj
   use nutate_elliptic_phase, only: elliptic_phase_t
   use nutate_exact_free, only: free_body_t, free_motion_t, motion_of
   use nutate_kinds, only: wp
   use nutate_principal_frame, only: identity_frame
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body
   implicit none
   private

   public :: exact_tangent_t

   !> The derivative of a solution at one time; matrices in body axes, shape (3,3).
   type :: exact_tangent_t
      private
      type(free_motion_t) :: solution
      !> t, s; L0, L1, N m s; R(q0*∘q1)ᵀ.
      real(wp) :: t = 0.0_wp, first(3) = 0.0_wp, last(3) = 0.0_wp, back(3, 3) = 0.0_wp
      !> ∂L1/∂L0, and ∂θ1/∂L0, (N m s)⁻¹.
      real(wp), public :: by_momentum(3, 3) = 0.0_wp, turn(3, 3) = 0.0_wp
      !> ∫exp(Nt) dt for a constant rate, and whether the rate is nearly constant: next to an unstable axis, differences
      !> of elliptic functions would leave no digits of the sensitivity to a moment.
      logical :: near = .false.
      real(wp) :: integral(3, 3) = 0.0_wp
      !> sn, cn, dn at the start and at the time, with their signs; S = ∫sn²/dn² up to each of them, and D = ∫sn²
      !> between.
      type(elliptic_phase_t) :: phase(2)
      real(wp) :: s(2) = 0.0_wp, d = 0.0_wp
   contains
      !> Sets solution and time.
      procedure :: set
      !> Propagates a sensitivity from the start.
      procedure :: of_start
      !> Computes the part of a change of the inertia at fixed L0.
      procedure :: of_inertia
   end type exact_tangent_t

   !> Least relative difference of principal moments, over the greatest, at which a change of J rotates their axes.
   real(wp), parameter :: least_gap = 1e-6_wp
   !> Largest relative departure from a constant rate at which sensitivities to moments treat it as constant.
   real(wp), parameter :: nearly_steady = 1e-8_wp

contains

   !> Sets solution and time.
   pure subroutine set(self, solution, t)
      class(exact_tangent_t), intent(inout) :: self
      !> Solution after `prepare`.
      type(free_body_t), intent(in) :: solution
      !> Time, s, of either sign.
      real(wp), intent(in) :: t
      real(wp) :: q(4), c(4)
      integer :: i
      self%solution = motion_of(solution)
      self%t = t
      self%first = self%solution%momentum0
      call solution%evaluate(t, q, self%last)
      c = quat_product(quat_conjugate(self%solution%q0), q)
      do i = 1, 3
         self%back(:, i) = rotate_to_body(c, identity_frame(:, i))
      end do
      call set_steady(self)
      if (.not. self%solution%steady) then
         call set_phases(self)
         call set_moving(self)
      end if
      call set_turn(self)
   end subroutine set

   !> Computes exp(Nt) for a constant rate, and whether the rate is so nearly constant that it stays so.
   pure subroutine set_steady(self)
      class(exact_tangent_t), intent(inout) :: self
      real(wp) :: n(3, 3), square(3, 3), inverse(3, 3), s, x, first, second, third
      integer :: i
      associate (axes => self%solution%axes, omega => self%solution%omega0)
         do i = 1, 3
            inverse(:, i) = matmul(axes, axes(i, :)/self%solution%moments)
         end do
         do i = 1, 3
            n(:, i) = cross(self%first, inverse(:, i)) - cross(omega, identity_frame(:, i))
         end do
      end associate
      square = matmul(n, n)
      s = 0.5_wp*(square(1, 1) + square(2, 2) + square(3, 3))
      x = sqrt(abs(s))*abs(self%t)
      if (abs(x) < 1e-3_wp) then
         first = self%t*(1 + s*self%t**2/6)
         second = 0.5_wp*self%t**2*(1 + s*self%t**2/12)
         third = self%t**3/6
      else if (s > 0.0_wp) then
         first = sign(sinh(x)/sqrt(s), self%t)
         second = 2*sinh(0.5_wp*x)**2/s
      else
         first = sign(1.0_wp, self%t)*sin(x)/sqrt(-s)
         second = -2*sin(0.5_wp*x)**2/s
      end if
      if (abs(x) >= 1e-3_wp) third = (first - self%t)/s
      self%by_momentum = identity_frame + first*n + second*square
      associate (omega => self%solution%omega0)
         self%near = norm2(cross(self%first, omega))*(1 + norm2(omega)*abs(self%t))*exp(merge(min(x, 50.0_wp), 0.0_wp, &
                     s > 0.0_wp)) <= nearly_steady*norm2(self%first)*norm2(omega)
      end associate
      self%integral = self%t*identity_frame + second*n + third*square
   end subroutine set_steady

   !> Computes the phases at both ends, and the integrals.
   pure subroutine set_phases(self)
      class(exact_tangent_t), intent(inout) :: self
      real(wp) :: of_quarter(2), d(2)
      integer :: i
      associate (clock => self%solution%clock)
         of_quarter = 0.0_wp
         if (clock%m1 > 0.0_wp) of_quarter = [carlson_rj(0.0_wp, 1.0_wp, clock%m1, clock%m1), &
                                              carlson_rj(0.0_wp, clock%m1, 1.0_wp, 1.0_wp)]/3
         do i = 1, 2
            self%phase(i) = clock%phase(merge(0.0_wp, self%t, i == 1))
            associate (p => self%phase(i))
               self%s(i) = p%sn**3*carlson_rj(p%cn**2, 1.0_wp, p%dn**2, p%dn**2)/3 + 2*p%half_periods*of_quarter(1)
               d(i) = p%sn**3*carlson_rj(p%cn**2, p%dn**2, 1.0_wp, 1.0_wp)/3 + 2*p%half_periods*of_quarter(2)
               p%sn = p%parity*p%sn
               p%cn = p%parity*p%cn
            end associate
         end do
         self%d = d(2) - d(1)
      end associate
   end subroutine set_phases

   !> Computes ∂L1/∂L0 from three vectors at both ends, in units of |L|.
   pure subroutine set_moving(self)
      class(exact_tangent_t), intent(inout) :: self
      real(wp) :: vectors(3, 3, 2), rate(3), inverse(3, 3)
      integer :: i
      associate (x => self%solution%amplitude)
         do i = 1, 2
            associate (p => self%phase(i))
               vectors(:, 1, i) = rate_of(self, i)
               vectors(:, 2, i) = x*[p%cn, p%sn, p%dn]
               vectors(:, 3, i) = slope_of(self, i)
            end associate
         end do
         rate = x(1)*vectors(:, 1, 2)
         vectors(:, 2, 2) = vectors(:, 2, 2) + self%t*rate
         vectors(:, 3, 2) = vectors(:, 3, 2) - (self%t*x(1)/x(3)**2)*rate
      end associate
      inverse = inverse_of(vectors(:, :, 1))
      associate (frame => self%solution%frame)
         self%by_momentum = matmul(matmul(frame, vectors(:, :, 2)), matmul(inverse, transpose(frame)))
      end associate
   end subroutine set_moving

   !> Returns L̇/C of an end, axes c, b, a, |L| = 1; shape (3).
   pure function rate_of(self, i) result(rate)
      class(exact_tangent_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp) :: rate(3)
      associate (p => self%phase(i), x => self%solution%amplitude, root => self%solution%root_ratio)
         rate = self%solution%clock%rate*[-p%sn*p%dn, self%solution%sense/root*p%cn*p%dn, &
                                          -excess(self)*(x(1)/x(3))*p%sn*p%cn]
      end associate
   end function rate_of

   !> Returns r - 1.
   pure real(wp) function excess(self)
      class(exact_tangent_t), intent(in) :: self
      excess = self%solution%winding%weight*self%solution%amplitude(3)/self%solution%winding%ratio
   end function excess

   !> Returns ∂sn/∂m, ∂cn/∂m and ∂dn/∂m at fixed u of an end; shape (3).
   pure function by_parameter(self, i) result(by)
      class(exact_tangent_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp) :: by(3)
      real(wp) :: turn
      associate (p => self%phase(i))
         turn = -0.5_wp*p%dn*self%s(i)
         by(1) = p%cn*turn
         by(2) = -p%sn*turn
         by(3) = -(p%sn**2 + 2*(1 - self%solution%clock%m1)*p%sn*p%cn*turn)/(2*p%dn)
      end associate
   end function by_parameter

   !> Returns Λ of an end, axes c, b, a; shape (3).
   pure function slope_of(self, i) result(slope)
      class(exact_tangent_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp) :: slope(3)
      real(wp) :: by(3), by_c
      by = by_parameter(self, i)
      associate (p => self%phase(i), x => self%solution%amplitude)
         by_c = 2*excess(self)*x(1)/x(3)**4
         slope(1) = p%cn + x(1)*by(2)*by_c
         slope(2) = (self%solution%sense/self%solution%root_ratio)*(p%sn + x(1)*by(1)*by_c)
         slope(3) = -(x(1)/x(3))*p%dn + x(3)*by(3)*by_c
      end associate
   end function slope_of

   !> Returns the inverse of a matrix by its adjugate.
   pure function inverse_of(a) result(b)
      real(wp), intent(in) :: a(3, 3)
      real(wp) :: b(3, 3)
      b(1, :) = cross(a(:, 2), a(:, 3))
      b(2, :) = cross(a(:, 3), a(:, 1))
      b(3, :) = cross(a(:, 1), a(:, 2))
      b = b/dot_product(a(:, 1), b(1, :))
   end function inverse_of

   !> Computes ∂θ1/∂L0.
   pure subroutine set_turn(self)
      class(exact_tangent_t), intent(inout) :: self
      real(wp) :: square
      integer :: i
      square = dot_product(self%last, self%last)
      if (.not. square > tiny(1.0_wp)) then
         ! At rest: θ̇ = J⁻¹δL.
         do i = 1, 3
            self%turn(:, i) = self%t*matmul(self%solution%axes, self%solution%axes(i, :)/self%solution%moments)
         end do
         return
      end if
      do i = 1, 3
         self%turn(:, i) = (cross(self%last, self%back(:, i) - self%by_momentum(:, i)) &
                            + (self%t*self%solution%omega0(i))*self%last)/square
      end do
   end subroutine set_turn

   !> Propagates a sensitivity from the start: θ and δL, body axes.
   pure subroutine of_start(self, theta, momentum)
      class(exact_tangent_t), intent(in) :: self
      !> θ, rad; δL, N m s; shape (3).
      real(wp), intent(inout) :: theta(3), momentum(3)
      theta = matmul(self%back, theta) + matmul(self%turn, momentum)
      momentum = matmul(self%by_momentum, momentum)
   end subroutine of_start

   !> Computes the part of a change of the inertia at fixed L0.
   pure subroutine of_inertia(self, change, theta, momentum, possible)
      class(exact_tangent_t), intent(in) :: self
      !> δJ, body axes, kg m²; shape (3,3).
      real(wp), intent(in) :: change(3, 3)
      !> Parts of θ and δL; shape (3).
      real(wp), intent(out) :: theta(3), momentum(3)
      !> False if the change rotates principal axes of equal moments.
      logical, intent(out) :: possible
      real(wp) :: principal(3, 3), turn(3), old(3), gap
      integer :: i, j, k
      associate (axes => self%solution%axes, moments => self%solution%moments)
         principal = matmul(transpose(axes), matmul(change, axes))
         possible = .true.
         do k = 1, 3
            i = 1 + modulo(k, 3)
            j = 1 + modulo(k + 1, 3)
            ! Products of inertia that are only rounding are treated as zero.
            turn(k) = 0.0_wp
            if (abs(principal(j, i)) <= 1e-14_wp*maxval(abs(change))) cycle
            gap = moments(i) - moments(j)
            if (.not. abs(gap) > least_gap*maxval(moments)) possible = .false.
            if (.not. possible) return
            turn(k) = principal(j, i)/gap
         end do
         turn = matmul(axes, turn)
         theta = turn
         old = -cross(turn, self%first)
         momentum = old
         call self%of_start(theta, momentum)
         theta = theta - turn
         momentum = momentum + cross(turn, self%last)
         do k = 1, 3
            call add_moment(self, k, principal(k, k), theta, momentum)
         end do
      end associate
   end subroutine of_inertia

   !> Adds the part of a change of one principal moment.
   pure subroutine add_moment(self, k, change, theta, momentum)
      class(exact_tangent_t), intent(in) :: self
      !> Index of the moment; its change, kg m².
      integer, intent(in) :: k
      real(wp), intent(in) :: change
      real(wp), intent(inout) :: theta(3), momentum(3)
      real(wp) :: own(3), square, work, rate
      square = dot_product(self%last, self%last)
      if (.not. (abs(change) > 0.0_wp .and. square > tiny(1.0_wp))) return
      associate (axis => self%solution%axes(:, k), moment => self%solution%moments(k))
         rate = dot_product(axis, self%first)/moment
         if (self%near) then
            own = -(rate/moment)*matmul(self%integral, cross(self%first, axis))
            work = rate**2*self%t
         else
            call differentiate(self, axis, moment, own, work)
         end if
      end associate
      momentum = momentum + change*own
      theta = theta + change*(-cross(self%last, own) - 0.5_wp*(work + self%t*rate**2)*self%last)/square
   end subroutine add_moment

   !> Computes ∂L1 with respect to one principal moment at fixed L0, and ∫Ω² dt of its axis.
   pure subroutine differentiate(self, axis, moment, own, work)
      class(exact_tangent_t), intent(in) :: self
      !> Axis, body axes; moment, kg m².
      real(wp), intent(in) :: axis(3), moment
      real(wp), intent(out) :: own(3), work
      real(wp) :: inverse(3), of_inverse(3), p, q, of_p, of_q, r, of_r, of_ratio, of_c, of_a, of_m, of_nu, of_u, by(3)
      real(wp) :: along(3)
      integer :: i, place
      associate (s => self%solution, x => self%solution%amplitude, first => self%phase(1), last => self%phase(2))
         along = matmul(axis, s%frame)
         place = maxloc(abs(along), 1)
         do i = 1, 3
            inverse(i) = dot_product(matmul(s%frame(:, i), s%axes)**2, 1/s%moments)
         end do
         of_inverse = 0.0_wp
         of_inverse(place) = -1/moment**2
         p = inverse(1) - inverse(3)
         q = inverse(2) - inverse(3)
         of_p = of_inverse(1) - of_inverse(3)
         of_q = of_inverse(2) - of_inverse(3)
         r = 1/s%winding%ratio
         of_r = (of_p - r*of_q)/q
         of_ratio = -of_r/r**2
         of_c = 0.5_wp*x(1)*r*first%sn**2*of_ratio
         of_a = -0.5_wp*x(2)**2*first%sn**2*of_ratio/x(3)
         of_m = of_r*(x(1)/x(3))**2 + 2*excess(self)*x(1)*of_c/x(3)**2 - 2*(1 - s%clock%m1)*of_a/x(3)
         of_nu = s%clock%rate*(of_a/x(3) + 0.5_wp*(of_p/p + of_q/q))
         of_u = 0.5_wp*first%sn*first%cn*r*of_ratio/first%dn + 0.5_wp*self%s(1)*of_m
         by = by_parameter(self, 2)
         own = [of_c*last%cn + x(1)*by(2)*of_m, &
                s%sense*(of_c/s%root_ratio + 0.5_wp*x(1)*of_r*s%root_ratio)*last%sn + x(2)*by(1)*of_m, &
                of_a*last%dn + x(3)*by(3)*of_m]
         own = own + (x(1)*(of_u + self%t*of_nu)/s%clock%rate)*rate_of(self, 2)
         own = s%momentum*matmul(s%frame, own)
         work = self%d
         if (place == 1) work = s%clock%rate*self%t - work
         if (place == 3) work = s%clock%rate*self%t - (1 - s%clock%m1)*work
         work = (s%momentum*x(place)/moment)**2*work/s%clock%rate
      end associate
   end subroutine differentiate

end module nutate_exact_tangent
