!> An oracle of higher precision for the attitude at the end of a motion: an integrator that shares nothing with the
!> library but the data of body and effects. Kind `qp` has 33 digits where the compiler has one.
!>
!> Extrapolation of the explicit midpoint rule (W. B. Gragg 1965; R. Bulirsch, J. Stoer 1966) to order 24, with steps
!> chosen by the last two columns. Roots and cosines are its own: not every compiler has them in that precision.
module test_oracle
   use nutate_applied_torque, only: applied_torque_t
   use nutate_center_change, only: center_change_t
   use nutate_damping, only: damping_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_inertia_change, only: inertia_change_t
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_piecewise, only: piecewise_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_wheel, only: wheel_t
   implicit none
   private

   public :: find_true_attitude, has_oracle, true_distance, qp

   integer, parameter :: precise = selected_real_kind(33)
   !> The precision of the oracle, that of the library where there is no higher one.
   integer, parameter :: qp = merge(precise, wp, precise > 0)
   logical, parameter :: has_oracle = precise > 0

   !> Columns of the extrapolation, of n = 2, 4, 6, … steps each: more would lose digits that a tolerance of 1e-30
   !> needs.
   integer, parameter :: columns = 12
   !> Error of a step, relative to |q| and |L|, unless a smaller one is asked for.
   real(qp), parameter :: usual_tolerance = 1e-25_qp
   real(qp), parameter :: pi = 3.14159265358979323846264338327950288_qp

   !> Data of a motion, in the precision of the oracle.
   type :: motion_t
      real(qp) :: inverse_inertia(3, 3), inertia(3, 3), rotor(3)
      !> A time inside of the part of the run, s.
      real(wp) :: moment = 0.0_wp
      !> Largest |L|, to which errors are relative.
      real(qp) :: momentum
      !> Error of a step.
      real(qp) :: tolerance = usual_tolerance
      !> The torque acts in this part of the run; shape (number of torques).
      logical, allocatable :: acts(:)
   end type motion_t

contains

   !> The attitude at the end time.
   subroutine find_true_attitude(system, start, end_time, q, tolerance)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> s.
      real(wp), intent(in) :: end_time
      !> Shape (4).
      real(qp), intent(out) :: q(4)
      !> Tolerance of a step.
      real(qp), intent(in), optional :: tolerance
      type(motion_t) :: motion
      real(wp) :: t, next, sense
      real(qp), allocatable :: y(:)
      real(qp) :: step
      integer :: k
      call prepare(motion, system, start, end_time - start%t, y)
      if (present(tolerance)) motion%tolerance = tolerance
      sense = sign(1.0_wp, end_time - start%t)
      allocate (motion%acts(system%effects%n_torques))
      t = start%t
      ! Short, so that nothing overflows: the next ones grow.
      step = 1e-3_qp*(real(end_time, qp) - real(t, qp))
      do while (abs(end_time - t) > 0.0_wp)
         next = system%effects%next_break(t, sense)
         if (sense*(next - end_time) > 0.0_wp) next = end_time
         motion%moment = 0.5_wp*(t + next)
         do k = 1, size(motion%acts)
            motion%acts(k) = system%effects%torques(k)%item%acts_at(0.5_wp*(t + next))
         end do
         call go(motion, system, real(t, qp), real(next, qp), step, y)
         t = next
      end do
      q = y(1:4)
   end subroutine find_true_attitude

   !> Angle between an attitude of the oracle and one of the library, rad.
   pure real(wp) function true_distance(exact, q)
      real(qp), intent(in) :: exact(4)
      real(wp), intent(in) :: q(4)
      real(qp) :: a(4), b(4)
      a = exact/root(sum(exact**2))
      b = real(q, qp)/root(sum(real(q, qp)**2))
      true_distance = 2*real(min(root(sum((a - b)**2)), root(sum((a + b)**2))), wp)
      ! |a - b| = 2 sin(φ/4).
      true_distance = 4*asin(min(1.0_wp, 0.25_wp*true_distance))
   end function true_distance

   !> Body, rotors and the first state.
   subroutine prepare(motion, system, start, duration, y)
      type(motion_t), intent(out) :: motion
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> s.
      real(wp), intent(in) :: duration
      !> q, L, h of each wheel.
      real(qp), allocatable, intent(out) :: y(:)
      real(qp) :: j(3, 3), q(4), p(4)
      j = real(system%body%inertia, qp)
      motion%inverse_inertia = inverse(j)
      motion%inertia = j
      motion%rotor = real(system%effects%rotor_momentum, qp)
      allocate (y(7 + system%effects%n_wheels))
      y(8:) = real(start%wheel_momentum(:system%effects%n_wheels), qp)
      q = real(start%q, qp)
      p = real(start%p, qp)
      y(5) = q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3)
      y(6) = q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4)
      y(7) = q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2)
      y(5:7) = y(5:7)/(2*sum(q**2))
      y(1:4) = q/root(sum(q**2))
      ! A body at rest is one that turns by a radian in the run, so that errors have a scale.
      motion%momentum = max(root(sum(y(5:7)**2)), real(maxval(system%body%moments)/abs(duration), qp))
   end subroutine prepare

   !> Inverse of a symmetric matrix.
   pure function inverse(a) result(b)
      real(qp), intent(in) :: a(3, 3)
      real(qp) :: b(3, 3)
      b(:, 1) = cross(a(:, 2), a(:, 3))
      b(:, 2) = cross(a(:, 3), a(:, 1))
      b(:, 3) = cross(a(:, 1), a(:, 2))
      b = transpose(b)/dot_product(a(:, 1), cross(a(:, 2), a(:, 3)))
   end function inverse

   pure function cross(a, b) result(c)
      real(qp), intent(in) :: a(3), b(3)
      real(qp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> Integrates over a part of the run in which the same torques act.
   subroutine go(motion, system, first, last, step, y)
      type(motion_t), intent(inout) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: first, last
      !> The next step to try, s.
      real(qp), intent(inout) :: step
      real(qp), intent(inout) :: y(:)
      real(qp) :: t, h, next(size(y)), error
      real(wp) :: factor
      logical :: is_last
      t = first
      do
         h = step
         is_last = abs(h) >= abs(last - t)
         if (is_last) h = last - t
         call take_step(motion, system, t, h, y, next, error)
         factor = 0.2_wp
         if (error <= 1e4_qp) factor = 0.9_wp*max(real(error, wp), 1e-6_wp)**(-1.0_wp/(2*columns - 1))
         if (error <= 1.0_qp) then
            y = next
            y(1:4) = y(1:4)/root(sum(y(1:4)**2))
            motion%momentum = max(motion%momentum, root(sum(y(5:7)**2)))
            if (is_last .and. factor < 1.0_wp) step = step*factor
            if (is_last) return
            t = t + h
         end if
         step = h*min(5.0_wp, factor)
      end do
   end subroutine go

   !> One step of extrapolation, and its error in units of the tolerance.
   subroutine take_step(motion, system, t, h, y, next, error)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: t, h
      real(qp), intent(in) :: y(:)
      real(qp), intent(out) :: next(:), error
      real(qp) :: table(size(y), columns), rate(size(y)), old(size(y)), scale
      integer :: k, j
      rate = rate_of(motion, system, t, y)
      do k = 1, columns
         next = midpoint(motion, system, t, h/(2*k), 2*k, y, rate)
         do j = 1, k - 1
            old = table(:, j)
            table(:, j) = next
            next = next + (next - old)*(real((k - j)**2, qp)/real(k**2 - (k - j)**2, qp))
         end do
         table(:, k) = next
      end do
      old = abs(next - table(:, columns - 1))
      scale = max(motion%momentum, maxval(abs(next(5:7))))
      error = maxval(old(1:4))/motion%tolerance
      error = max(error, maxval(old(5:))/(motion%tolerance*scale))
   end subroutine take_step

   !> n steps h of the explicit midpoint rule, the first one Euler's.
   function midpoint(motion, system, t, h, n, y, rate) result(now)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: t, h
      integer, intent(in) :: n
      !> Values at the start of the step, and their rate.
      real(qp), intent(in) :: y(:), rate(:)
      real(qp) :: now(size(y)), before(size(y)), next(size(y)), twice
      integer :: i
      before = y
      now = y + h*rate
      twice = 2*h
      do i = 1, n - 1
         next = before + twice*rate_of(motion, system, t + i*h, now)
         before = now
         now = next
      end do
   end function midpoint

   !> q̇ = ½ q∘Ω, L̇ = L×Ω + τ.
   function rate_of(motion, system, t, y) result(rate)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: t
      real(qp), intent(in) :: y(:)
      real(qp) :: rate(size(y)), omega(3), inner(3), change(3, 3)
      integer :: i
      inner = motion%rotor
      change = 0.0_qp
      do i = 1, system%effects%n_wheels
         inner = inner + y(7 + i)*real(system%effects%wheels(i)%axis, qp)
      end do
      if (system%effects%varies) then
         change = change_of(motion, system, t, 0)
         omega = matmul(inverse(motion%inertia + change), y(5:7) - inner)
      else
         omega = matmul(motion%inverse_inertia, y(5:7) - inner)
      end if
      associate (q => y(1:4), w => omega/2)
         rate(1) = -(q(2)*w(1) + q(3)*w(2) + q(4)*w(3))
         rate(2) = q(1)*w(1) + q(3)*w(3) - q(4)*w(2)
         rate(3) = q(1)*w(2) + q(4)*w(1) - q(2)*w(3)
         rate(4) = q(1)*w(3) + q(2)*w(2) - q(3)*w(1)
      end associate
      rate(5:7) = cross(y(5:7), omega)
      if (system%effects%n_potentials + system%effects%n_torques > 0) &
         rate(5:7) = rate(5:7) + torque_of(motion, system, t, y(1:4), omega, change)
      rate(8:) = 0.0_qp
      do i = 1, system%effects%n_wheels
         rate(7 + i) = wheel_torque(system%effects%wheels(i), t, y(7 + i), omega)
      end do
   end function rate_of

   !> Change of the inertia since t = 0, kg m², or its rate, kg m²/s; of one effect, if it is named.
   function change_of(motion, system, t, derivative, only) result(change)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: t
      !> 0 or 1.
      integer, intent(in) :: derivative
      integer, intent(in), optional :: only
      real(qp) :: change(3, 3), start, stop, six(6)
      integer :: i
      change = 0.0_qp
      do i = 1, system%effects%n_torques
         if (present(only)) then
            if (i /= only) cycle
         end if
         associate (torque => system%effects%torques(i)%item)
            select type (torque)
            type is (inertia_change_t)
               if (torque%is_table) then
                  six(1:3) = value_of(motion, t, torque%squares, derivative)
                  six(4:6) = 0.0_qp
                  if (allocated(torque%products%x)) &
                     six(4:6) = value_of(motion, t, torque%products, derivative)
                  change = change + real(torque%scale, qp)*reshape([six(1), six(4), six(5), six(4), six(2), six(6), &
                                                                   six(5), six(6), six(3)], [3, 3])
                  if (derivative == 0) change = change - real(torque%scale*torque%tabulated_at(0.0_wp), qp)
               else
                  start = real(torque%start, qp)
                  stop = real(torque%stop, qp)
                  if (derivative == 0) then
                     change = change + (min(max(t, start), stop) - min(max(0.0_qp, start), stop))*real(torque%rate, qp)
                  else if (motion%moment > torque%start .and. motion%moment < torque%stop) then
                     change = change + real(torque%rate, qp)
                  end if
               end if
            end select
         end associate
      end do
   end function change_of

   !> Displacement of the centre of mass since t = 0, m.
   function displacement_of(motion, system, t) result(displacement)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      !> s.
      real(qp), intent(in) :: t
      real(qp) :: displacement(3)
      integer :: i
      displacement = 0.0_qp
      do i = 1, system%effects%n_torques
         associate (torque => system%effects%torques(i)%item)
            select type (torque)
            type is (center_change_t)
               displacement = displacement + value_of(motion, t, torque%curve, 0) - real(torque%center_at(0.0_wp), qp)
            end select
         end associate
      end do
   end function displacement_of

   !> The polynomial of the interval, or its derivative.
   function value_of(motion, t, curve, derivative) result(value)
      type(motion_t), intent(in) :: motion
      !> s.
      real(qp), intent(in) :: t
      type(piecewise_t), intent(in) :: curve
      !> 0 or 1.
      integer, intent(in) :: derivative
      real(qp) :: value(3), s, h
      integer :: j, k
      k = 1
      do while (k < curve%n .and. motion%moment > curve%x(k))
         k = k + 1
      end do
      h = real(curve%x(k), qp) - real(curve%x(k - 1), qp)
      s = (t - real(curve%x(k - 1), qp))/h
      value = 0.0_qp
      do j = curve%degree, derivative, -1
         value = value*s + real(merge(j, 1, derivative == 1), qp)*real(curve%c(:, j, k), qp)
      end do
      if (derivative == 1) value = value/h
   end function value_of

   !> u - cω, ω = h/Jw - s·Ω; the motor acts at all times.
   real(qp) function wheel_torque(wheel, t, h, omega) result(torque)
      type(wheel_t), intent(in) :: wheel
      !> s, N m s.
      real(qp), intent(in) :: t, h
      real(qp), intent(in) :: omega(3)
      torque = -real(wheel%friction, qp)*(h/real(wheel%inertia, qp) - sum(real(wheel%axis, qp)*omega))
      if (.not. allocated(wheel%motor)) return
      select type (motor => wheel%motor)
      class is (applied_torque_t)
         torque = torque + harmonic(motor, t)*real(motor%amplitude(1), qp)
      class default
         error stop 'the oracle does not know this motor'
      end select
   end function wheel_torque

   !> Torque of all effects, body axes, N m.
   function torque_of(motion, system, t, q, omega, change) result(tau)
      type(motion_t), intent(in) :: motion
      type(system_t), intent(in) :: system
      real(qp), intent(in) :: t, q(4), omega(3)
      !> Change of the inertia since t = 0, kg m².
      real(qp), intent(in) :: change(3, 3)
      real(qp) :: tau(3), to_body(3, 3), gamma(3)
      integer :: i
      to_body = rows_of(q)
      tau = 0.0_qp
      do i = 1, system%effects%n_potentials
         associate (potential => system%effects%potentials(i)%item)
            gamma = to_space_of(potential%direction)
            select type (potential)
            class is (linear_potential_t)
               tau = tau + cross(real(potential%moment, qp) + real(potential%by_center, qp)* &
                                 displacement_of(motion, system, t), gamma)
            class is (gravity_gradient_t)
               tau = tau + cross(gamma, matmul(real(potential%stiffness, qp), gamma))
               if (system%effects%varies) tau = tau + 3*real(potential%strength, qp)*cross(gamma, matmul(change, gamma))
            class is (spring_t)
               tau = tau + spring_torque(potential, gamma)
            class default
               error stop 'the oracle does not know this potential'
            end select
         end associate
      end do
      do i = 1, system%effects%n_torques
         if (.not. motion%acts(i)) cycle
         associate (torque => system%effects%torques(i)%item)
            select type (torque)
            class is (damping_t)
               tau = tau - real(torque%coefficient, qp)*omega
            type is (center_change_t)
               cycle
            type is (inertia_change_t)
               if (torque%mass_leaves) tau = tau + matmul(change_of(motion, system, t, 1, i), omega)
            class is (applied_torque_t)
               if (torque%in_space) then
                  tau = tau + harmonic(torque, t)*to_space_of(torque%amplitude)
               else
                  tau = tau + harmonic(torque, t)*real(torque%amplitude, qp)
               end if
            class default
               error stop 'the oracle does not know this torque'
            end select
         end associate
      end do
   contains
      !> Body components of a vector fixed in space.
      function to_space_of(direction) result(gamma)
         real(wp), intent(in) :: direction(3)
         real(qp) :: gamma(3)
         gamma = matmul(to_body, real(direction, qp))
      end function to_space_of
   end function torque_of

   !> Rᵀ of a quaternion of about unit length, as if it had that length.
   pure function rows_of(q) result(rows)
      real(qp), intent(in) :: q(4)
      real(qp) :: rows(3, 3), d
      d = 2/sum(q**2)
      rows(1, 1) = 1 - d*(q(3)*q(3) + q(4)*q(4))
      rows(2, 2) = 1 - d*(q(2)*q(2) + q(4)*q(4))
      rows(3, 3) = 1 - d*(q(2)*q(2) + q(3)*q(3))
      rows(1, 2) = d*(q(2)*q(3) + q(1)*q(4))
      rows(2, 1) = d*(q(2)*q(3) - q(1)*q(4))
      rows(1, 3) = d*(q(2)*q(4) - q(1)*q(3))
      rows(3, 1) = d*(q(2)*q(4) + q(1)*q(3))
      rows(2, 3) = d*(q(3)*q(4) + q(1)*q(2))
      rows(3, 2) = d*(q(3)*q(4) - q(1)*q(2))
   end function rows_of

   !> x×F, F = k(1 - l₀/ℓ)(γ - x), ℓ = |γ - x|.
   pure function spring_torque(spring, gamma) result(tau)
      type(spring_t), intent(in) :: spring
      !> The anchor, body axes, m; shape (3).
      real(qp), intent(in) :: gamma(3)
      real(qp) :: tau(3), x(3)
      x = real(spring%body_point, qp)
      tau = real(spring%stiffness, qp)*(1 - real(spring%rest_length, qp)/root(sum((gamma - x)**2)))*cross(x, gamma)
   end function spring_torque

   !> cos(2πft + phase), by its series after halving the angle often enough.
   pure real(qp) function harmonic(torque, t) result(c)
      type(applied_torque_t), intent(in) :: torque
      !> s.
      real(qp), intent(in) :: t
      real(qp) :: turns, angle, term, square
      integer :: k
      turns = real(torque%frequency, qp)*t
      angle = 2*pi*(turns - nint(real(turns, wp))) + real(torque%phase, qp)
      angle = (angle - 2*pi*nint(real(angle/(2*pi), wp)))/8
      square = angle*angle
      c = 1.0_qp
      term = 1.0_qp
      do k = 2, 26, 2
         term = -term*square/(k*(k - 1))
         c = c + term
      end do
      do k = 1, 3
         c = 2*c*c - 1
      end do
   end function harmonic

   !> Square root, by Newton's iteration from that of the library's precision.
   pure real(qp) function root(x)
      real(qp), intent(in) :: x
      integer :: k
      root = real(sqrt(real(x, wp)), qp)
      if (.not. root > 0.0_qp) return
      do k = 1, 3
         root = (root + x/root)/2
      end do
   end function root

end module test_oracle
