!> The motion of a rigid body as power series in time: body momentum, and directions fixed in space as the body sees
!> them.
!>
!>     L̇ = L×Ω + τ,   ĖE = E×Ω,   Ω = J⁻¹(L - h),   E = R(q)ᵀe
!>
!> Everything turns against the body alike, so that L and the rows E are lanes of one product with Ω: two lanes make a
!> pair, which is what a vector unit takes at a time. Two or three rows are the attitude, and cost less than the series of
!> q; without torque L itself is one of them, and one pair does.
!>
!> A top, a body of diagonal inertia under one linear potential, needs neither the third row nor L: with Euler's equations
!> in Ω, three products replace six.
!>
!> In a coefficient the products with the newest coefficients come last: those before do not wait for them.
module nutate_rigid_series
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross
   use nutate_series, only: highest_order, inverses
   use nutate_series_torques, only: series_torques_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: rigid_series_t

   !> Coefficients of a body's turn that grow faster than this to the power of their index overflow sooner or later.
   real(wp), parameter :: steepest = 1e4_wp

   !> Series of one step.
   type :: rigid_series_t
      !> Lanes (L, E1) and (E2, E3); body axes; shape (2, 3, 0:highest_order).
      real(wp) :: lanes_1(2, 3, 0:highest_order) = 0.0_wp, lanes_2(2, 3, 0:highest_order) = 0.0_wp
      !> Ω times the unit of time; shape (3, 0:highest_order).
      real(wp) :: turn(3, 0:highest_order) = 0.0_wp
      !> Lanes (E1, E2) of a top; shape (2, 3, 0:highest_order).
      real(wp), private :: rows(2, 3, 0:highest_order) = 0.0_wp
      !> The series are those of a top; else pairs of lanes in use.
      logical :: is_top = .false.
      integer :: n_pairs = 2
      !> Highest coefficient.
      integer :: order = 0
      !> Moments over the unit of time, and L at the start, of a top; shape (3).
      real(wp), private :: inertia(3) = 0.0_wp, momentum(3) = 0.0_wp
      !> Start and unit of time, s; the unit is negative backwards in time.
      real(wp) :: t = 0.0_wp, unit = 1.0_wp
      type(series_torques_t) :: torques
   contains
      !> Computes the coefficients.
      procedure :: expand
      !> Finds out which equations do.
      procedure :: choose_equations
      !> Momentum and rows at a time.
      procedure :: evaluate
      !> Size of a coefficient.
      procedure :: size_of
      procedure :: momentum_square
   end type rigid_series_t

contains

   !> Finds out which equations do for a system.
   pure subroutine choose_equations(self, system)
      class(rigid_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      associate (j => system%body%inverse_inertia)
         self%is_top = .not. any(abs([j(2, 1), j(3, 1), j(3, 2), system%effects%rotor_momentum]) > 0.0_wp)
      end associate
      self%is_top = self%is_top .and. self%torques%n_moments == 1 .and. .not. self%torques%has_more
      self%n_pairs = 2
   end subroutine choose_equations

   !> Computes the coefficients from the values at the start.
   pure subroutine expand(self, system, acts, momentum, rows, converges)
      !> `order`, `t` and `unit` are set.
      class(rigid_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      !> L, N m s, and the rows as columns; body axes; shapes (3), (3,3).
      real(wp), intent(in) :: momentum(3), rows(3, 3)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      if (self%is_top) then
         call expand_top(self, system, momentum, rows, converges)
      else
         call expand_pairs(self, system, acts, momentum, rows, converges)
      end if
   end subroutine expand

   !> Ω and two rows of a top: (ΔtΩ₁)' = (J₂ - J₃)/J₁ Ω₂Ω₃ + Δt (m×E1)₁/J₁ ...
   pure subroutine expand_top(self, system, momentum, rows, converges)
      class(rigid_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: momentum(3), rows(3, 3)
      logical, intent(out) :: converges
      real(wp), dimension(2) :: e1, e2, e3, s1, s2, s3
      real(wp) :: w1, w2, w3, p1, p2, p3, c(3), m(3, 3), bound
      integer :: k, j

      associate (inverse => system%body%inverse_inertia, inertia => system%body%inertia, m0 => self%torques%moments)
         w1 = self%unit*inverse(1, 1)*momentum(1)
         w2 = self%unit*inverse(2, 2)*momentum(2)
         w3 = self%unit*inverse(3, 3)*momentum(3)
         c = [inverse(1, 1)*(inertia(2, 2) - inertia(3, 3)), inverse(2, 2)*(inertia(3, 3) - inertia(1, 1)), &
              inverse(3, 3)*(inertia(1, 1) - inertia(2, 2))]
         do j = 1, 3
            m(:, j) = (self%unit*inverse(j, j))*(self%unit*m0(:, 1))
         end do
      end associate
      e1 = rows(1, 1:2)
      e2 = rows(2, 1:2)
      e3 = rows(3, 1:2)
      bound = steepest
      associate (w => self%turn, e => self%rows)
         do k = 0, self%order - 1
            w(1, k) = w1
            w(2, k) = w2
            w(3, k) = w3
            e(:, 1, k) = e1
            e(:, 2, k) = e2
            e(:, 3, k) = e3
            converges = max(abs(w1), abs(w2), abs(w3)) <= bound
            if (.not. converges) return
            bound = bound*steepest
            s1 = 0.0_wp
            s2 = 0.0_wp
            s3 = 0.0_wp
            p1 = 0.0_wp
            p2 = 0.0_wp
            p3 = 0.0_wp
            do j = 1, k - 1
               p1 = p1 + w(2, j)*w(3, k - j)
               p2 = p2 + w(3, j)*w(1, k - j)
               p3 = p3 + w(1, j)*w(2, k - j)
               s1 = s1 + (e(:, 2, j)*w(3, k - j) - e(:, 3, j)*w(2, k - j))
               s2 = s2 + (e(:, 3, j)*w(1, k - j) - e(:, 1, j)*w(3, k - j))
               s3 = s3 + (e(:, 1, j)*w(2, k - j) - e(:, 2, j)*w(1, k - j))
            end do
            s1 = s1 + (e(:, 2, 0)*w3 - e(:, 3, 0)*w2)
            s2 = s2 + (e(:, 3, 0)*w1 - e(:, 1, 0)*w3)
            s3 = s3 + (e(:, 1, 0)*w2 - e(:, 2, 0)*w1)
            p1 = p1 + w(2, 0)*w3
            p2 = p2 + w(3, 0)*w1
            p3 = p3 + w(1, 0)*w2
            if (k > 0) then
               s1 = s1 + (e2*w(3, 0) - e3*w(2, 0))
               s2 = s2 + (e3*w(1, 0) - e1*w(3, 0))
               s3 = s3 + (e1*w(2, 0) - e2*w(1, 0))
               p1 = p1 + w2*w(3, 0)
               p2 = p2 + w3*w(1, 0)
               p3 = p3 + w1*w(2, 0)
            end if
            w1 = inverses(k + 1)*(c(1)*p1 + (m(2, 1)*e3(1) - m(3, 1)*e2(1)))
            w2 = inverses(k + 1)*(c(2)*p2 + (m(3, 2)*e1(1) - m(1, 2)*e3(1)))
            w3 = inverses(k + 1)*(c(3)*p3 + (m(1, 3)*e2(1) - m(2, 3)*e1(1)))
            e1 = inverses(k + 1)*s1
            e2 = inverses(k + 1)*s2
            e3 = inverses(k + 1)*s3
         end do
         w(1, self%order) = w1
         w(2, self%order) = w2
         w(3, self%order) = w3
         e(:, 1, self%order) = e1
         e(:, 2, self%order) = e2
         e(:, 3, self%order) = e3
      end associate
      self%inertia = [system%body%inertia(1, 1), system%body%inertia(2, 2), system%body%inertia(3, 3)]/self%unit
      self%momentum = momentum
   end subroutine expand_top

   !> Momentum and rows as pairs of lanes.
   pure subroutine expand_pairs(self, system, acts, momentum, rows, converges)
      class(rigid_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(in) :: acts(:)
      real(wp), intent(in) :: momentum(3), rows(3, 3)
      logical, intent(out) :: converges
      real(wp), dimension(2) :: a1, a2, a3, b1, b2, b3, s1, s2, s3
      real(wp) :: turns(3, 3), moments(3, 3), tau(3), w1, w2, w3, v1, v2, v3, bound
      logical :: diagonal, forced, two
      integer :: k, j

      turns = self%unit*system%body%inverse_inertia
      diagonal = .not. any(abs([turns(2, 1), turns(3, 1), turns(3, 2)]) > 0.0_wp)
      moments = self%unit*self%torques%moments
      forced = self%torques%n_moments > 1 .or. self%torques%has_more
      two = self%n_pairs > 1
      a1 = [momentum(1), rows(1, 1)]
      a2 = [momentum(2), rows(2, 1)]
      a3 = [momentum(3), rows(3, 1)]
      b1 = [rows(1, 2), rows(1, 3)]
      b2 = [rows(2, 2), rows(2, 3)]
      b3 = [rows(3, 2), rows(3, 3)]
      tau = 0.0_wp
      bound = steepest
      associate (a => self%lanes_1, b => self%lanes_2, w => self%turn, h => system%effects%rotor_momentum)
         do k = 0, self%order - 1
            a(:, 1, k) = a1
            a(:, 2, k) = a2
            a(:, 3, k) = a3
            w1 = a1(1)
            w2 = a2(1)
            w3 = a3(1)
            if (k == 0) then
               w1 = w1 - h(1)
               w2 = w2 - h(2)
               w3 = w3 - h(3)
            end if
            if (diagonal) then
               w1 = turns(1, 1)*w1
               w2 = turns(2, 2)*w2
               w3 = turns(3, 3)*w3
            else
               v1 = turns(1, 1)*w1 + turns(1, 2)*w2 + turns(1, 3)*w3
               v2 = turns(2, 1)*w1 + turns(2, 2)*w2 + turns(2, 3)*w3
               w3 = turns(3, 1)*w1 + turns(3, 2)*w2 + turns(3, 3)*w3
               w1 = v1
               w2 = v2
            end if
            w(1, k) = w1
            w(2, k) = w2
            w(3, k) = w3
            converges = max(abs(w1), abs(w2), abs(w3)) <= bound
            if (.not. converges) return
            bound = bound*steepest

            s1 = 0.0_wp
            s2 = 0.0_wp
            s3 = 0.0_wp
            do j = 1, k - 1
               s1 = s1 + (a(:, 2, j)*w(3, k - j) - a(:, 3, j)*w(2, k - j))
               s2 = s2 + (a(:, 3, j)*w(1, k - j) - a(:, 1, j)*w(3, k - j))
               s3 = s3 + (a(:, 1, j)*w(2, k - j) - a(:, 2, j)*w(1, k - j))
            end do
            if (k > 0) then
               s1 = s1 + (a2*w(3, 0) - a3*w(2, 0))
               s2 = s2 + (a3*w(1, 0) - a1*w(3, 0))
               s3 = s3 + (a1*w(2, 0) - a2*w(1, 0))
            end if
            s1 = s1 + (a(:, 2, 0)*w3 - a(:, 3, 0)*w2)
            s2 = s2 + (a(:, 3, 0)*w1 - a(:, 1, 0)*w3)
            s3 = s3 + (a(:, 1, 0)*w2 - a(:, 2, 0)*w1)
            tau(1) = moments(2, 1)*a3(2) - moments(3, 1)*a2(2)
            tau(2) = moments(3, 1)*a1(2) - moments(1, 1)*a3(2)
            tau(3) = moments(1, 1)*a2(2) - moments(2, 1)*a1(2)
            if (two) then
               b(:, 1, k) = b1
               b(:, 2, k) = b2
               b(:, 3, k) = b3
            end if
            if (forced) call add_more(self, system%effects, k, acts, moments, tau)
            a1 = inverses(k + 1)*(s1 + [tau(1), 0.0_wp])
            a2 = inverses(k + 1)*(s2 + [tau(2), 0.0_wp])
            a3 = inverses(k + 1)*(s3 + [tau(3), 0.0_wp])
            if (.not. two) cycle

            s1 = 0.0_wp
            s2 = 0.0_wp
            s3 = 0.0_wp
            do j = 1, k - 1
               s1 = s1 + (b(:, 2, j)*w(3, k - j) - b(:, 3, j)*w(2, k - j))
               s2 = s2 + (b(:, 3, j)*w(1, k - j) - b(:, 1, j)*w(3, k - j))
               s3 = s3 + (b(:, 1, j)*w(2, k - j) - b(:, 2, j)*w(1, k - j))
            end do
            if (k > 0) then
               s1 = s1 + (b2*w(3, 0) - b3*w(2, 0))
               s2 = s2 + (b3*w(1, 0) - b1*w(3, 0))
               s3 = s3 + (b1*w(2, 0) - b2*w(1, 0))
            end if
            b1 = inverses(k + 1)*(s1 + (b(:, 2, 0)*w3 - b(:, 3, 0)*w2))
            b2 = inverses(k + 1)*(s2 + (b(:, 3, 0)*w1 - b(:, 1, 0)*w3))
            b3 = inverses(k + 1)*(s3 + (b(:, 1, 0)*w2 - b(:, 2, 0)*w1))
         end do
         a(:, 1, self%order) = a1
         a(:, 2, self%order) = a2
         a(:, 3, self%order) = a3
         b(:, 1, self%order) = b1
         b(:, 2, self%order) = b2
         b(:, 3, self%order) = b3
      end associate
   end subroutine expand_pairs

   !> Adds m×E.
   pure subroutine add_moment(moment, row, tau)
      real(wp), intent(in) :: moment(3), row(3)
      real(wp), intent(inout) :: tau(3)
      tau(1) = tau(1) + (moment(2)*row(3) - moment(3)*row(2))
      tau(2) = tau(2) + (moment(3)*row(1) - moment(1)*row(3))
      tau(3) = tau(3) + (moment(1)*row(2) - moment(2)*row(1))
   end subroutine add_moment

   !> Adds coefficient k of the torque that is not linear in the first row, times the unit of time.
   pure subroutine add_more(self, effects, k, acts, moments, tau)
      class(rigid_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      logical, intent(in) :: acts(:)
      !> Of the linear potentials, times the unit of time.
      real(wp), intent(in) :: moments(3, 3)
      real(wp), intent(inout) :: tau(3)
      real(wp) :: rows(3, 3), more(3)
      integer :: i
      rows(:, 1) = self%lanes_1(2, :, k)
      rows(:, 2) = self%lanes_2(1, :, k)
      rows(:, 3) = self%lanes_2(2, :, k)
      do i = 2, self%torques%n_moments
         call add_moment(moments(:, i), rows(:, i), tau)
      end do
      if (.not. self%torques%has_more) return
      more = 0.0_wp
      call self%torques%add_terms(effects, k, self%t, self%unit, acts, self%turn(:, k)/self%unit, rows, more)
      tau = tau + self%unit*more
   end subroutine add_more

   !> Momentum and rows at a time from the start; even and odd powers apart, which halves the chain.
   pure subroutine evaluate(self, s, momentum, rows)
      class(rigid_series_t), intent(in) :: self
      !> In units of time.
      real(wp), intent(in) :: s
      !> N m s and (one, or an orthonormal frame of three) rows as columns; body axes; shapes (3), (3,3).
      real(wp), intent(out) :: momentum(3), rows(3, 3)
      real(wp) :: values(2, 3), change(3)
      if (self%is_top) then
         call sum_turns(self%order, s, self%turn, change)
         momentum = self%momentum + self%inertia*change
         call sum_series(self%order, s, self%rows, values)
         rows(:, 1) = values(1, :)
         rows(:, 2) = values(2, :)
         rows(:, 3) = cross(rows(:, 1), rows(:, 2))
         return
      end if
      call sum_series(self%order, s, self%lanes_1, values)
      momentum = values(1, :)
      rows(:, 1) = values(2, :)
      if (self%n_pairs == 1) return
      call sum_series(self%order, s, self%lanes_2, values)
      rows(:, 2) = values(1, :)
      rows(:, 3) = values(2, :)
   end subroutine evaluate

   !> Σ lanesₖ sᵏ
   pure subroutine sum_series(order, s, lanes, values)
      integer, intent(in) :: order
      real(wp), intent(in) :: s
      real(wp), intent(in) :: lanes(6, 0:*)
      real(wp), intent(out) :: values(6)
      real(wp) :: even(6), odd(6), square
      integer :: k, last
      square = s*s
      last = 2*(order/2)
      even = lanes(:, last)
      odd = 0.0_wp
      if (order > last) odd = lanes(:, order)
      do k = last - 2, 0, -2
         odd = odd*square + lanes(:, k + 1)
         even = even*square + lanes(:, k)
      end do
      values = even + s*odd
   end subroutine sum_series

   !> Σ turnₖ sᵏ without the first term.
   pure subroutine sum_turns(order, s, turn, change)
      integer, intent(in) :: order
      real(wp), intent(in) :: s, turn(3, 0:*)
      real(wp), intent(out) :: change(3)
      integer :: k
      change = turn(:, order)
      do k = order - 1, 1, -1
         change = change*s + turn(:, k)
      end do
      change = change*s
   end subroutine sum_turns

   !> √(|Lₖ|²/scale² + ½Σ|Eₖ|²), squared: size of a coefficient, as an angle.
   pure real(wp) function size_of(self, k, inverse_square) result(square)
      class(rigid_series_t), intent(in) :: self
      integer, intent(in) :: k
      !> 1/scale² of the momentum.
      real(wp), intent(in) :: inverse_square
      real(wp) :: rows
      if (self%is_top) then
         rows = 0.5_wp*sum(self%rows(:, :, k)**2)
      else if (self%n_pairs == 1) then
         rows = sum(self%lanes_1(2, :, k)**2)
      else
         rows = 0.5_wp*(sum(self%lanes_1(2, :, k)**2) + sum(self%lanes_2(:, :, k)**2))
      end if
      square = inverse_square*self%momentum_square(k) + rows
   end function size_of

   !> |Lₖ|², (N m s)².
   pure real(wp) function momentum_square(self, k) result(square)
      class(rigid_series_t), intent(in) :: self
      integer, intent(in) :: k
      if (self%is_top) then
         square = (self%inertia(1)*self%turn(1, k))**2 + (self%inertia(2)*self%turn(2, k))**2 &
                  + (self%inertia(3)*self%turn(3, k))**2
      else
         square = self%lanes_1(1, 1, k)**2 + self%lanes_1(1, 2, k)**2 + self%lanes_1(1, 3, k)**2
      end if
   end function momentum_square

end module nutate_rigid_series
