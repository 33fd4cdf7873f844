!> The tangent of one step of the conserving scheme: one 3×3 solve with the step's own Jacobian, for both forms of the
!> equations.
!>
!> The b of the step is a root of G (`nutate_reduced_equations`), with the r by which the body turns in space axes that
!> turn (`nutate_frame_turn`; r = b where they stand still). A change of b, at the root with A = ∂G/∂b, β = |b|²,
!> ρ = |r|², d = |δ|², δ̄ = b - r, δL̄ and δτ̄ at fixed b, φ = Rhθ0:
!>
!>     δb  = A⁻¹((1-β+d)(δL0 - δL̄) - 2b×δL̄ - Be - Cδτ̄)
!>     δr  = Dδb + e,   D = (1 + [δ̄]×N)⁻¹,   e = -Dδ̄×φ
!>     θ1  = Rh(φ + 4δr/(1+ρ)),   δL1 = 2((4/Δt)Jδb + δL̄) - δL0
!>     C   = -½Δt((1+ρ)1 - 2rbᵀ),   B = -½Δt(2τ̄rᵀ - 2(b·τ̄)1) + C ∂τ̄/∂r
!>     A   = (1-β+d)(4/Δt)J + 2[b]×(4/Δt)J - 2(L̄-L0)bᵀ - 2[L̄]× + Δt rτ̄ᵀ + BD
!>
!> Every part of A is taken at the root: what Newton keeps from earlier steps is not good enough. δL1 is L̄ = ½(L0 + L1)
!> = (4/Δt)Jb + h differentiated. Equations are multiplied by Δt/4s as those of the step are, s a size of J.
module nutate_step_tangent
   use nutate_column, only: column_t, OF_WHEEL
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_frame_turn, only: frame_turn_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: times_columns, times_vector
   use nutate_status, only: status_t, fail, NUTATE_SINGULAR
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_tangent_forces, only: across, forces_tangent_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_steps, only: wheel_steps_t
   implicit none
   private

   public :: conserving_step_t

   !> Determinants below are those of singular systems.
   real(wp), parameter :: least_determinant = 1e-150_wp

   !> One step and what its tangent is made of.
   type :: conserving_step_t
      !> Δt, s.
      real(wp) :: dt = 0.0_wp
      !> u, attitude at the start, body→space; shape (4).
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> b, dimensionless, and L0, N m s, body axes; shape (3).
      real(wp) :: b(3) = 0.0_wp, momentum(3) = 0.0_wp
      !> h of rotors, and of wheels at fixed b, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      !> s, kg m², Δt/4s, J/s with what wheels carry; shape (3,3).
      real(wp) :: size = 1.0_wp, scale = 0.0_wp, inertia(3, 3) = 0.0_wp
      type(forces_tangent_t), private :: forces
      !> 1-β+d; A⁻¹ and C times s/4 and 4s/Δt; D and ∂e/∂φ; shape (3,3).
      real(wp), private :: rest = 1.0_wp, inverse(3, 3) = 0.0_wp, by_torque(3, 3) = 0.0_wp
      real(wp), private :: by_absolute(3, 3) = 0.0_wp, by_turn(3, 3) = 0.0_wp, by_relative(3, 3) = 0.0_wp
   contains
      !> Moves tangent columns over the step.
      procedure :: carry
   end type conserving_step_t

contains

   !> Moves tangent columns over the step. Errors: `NUTATE_SINGULAR`, the columns as they were.
   subroutine carry(self, system, forces, turn, wheels, tangent, status)
      class(conserving_step_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Of the step, started.
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      type(wheel_steps_t), intent(in) :: wheels
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      real(wp) :: largest, r(3), by_mid(3, 3)
      logical :: extended
      integer :: i
      largest = max(system%body%inertia(1, 1), system%body%inertia(2, 2), system%body%inertia(3, 3))
      self%size = largest
      self%scale = 0.25_wp*self%dt/largest
      self%inertia = system%body%inertia/largest
      if (wheels%n > 0) self%inertia = self%inertia + wheels%carried/largest
      r = self%b
      if (turn%there) r = turn%to_relative(self%b)
      call self%forces%set(system%effects, forces, r, 4/self%dt)
      call set_inverse(self, forces%active, turn, status)
      if (status%code /= 0) return
      by_mid = 0.0_wp
      if (forces%active) by_mid = -times_columns(self%by_torque, self%forces%by_mid)
      if (turn%there) by_mid = by_mid - times_columns(self%by_relative, self%by_turn)
      do i = 1, 3
         by_mid(:, i) = times_vector(self%inverse, by_mid(:, i))
      end do
      call turn_columns(self, tangent%n, by_mid, tangent%theta, tangent%momentum, tangent%mid, tangent%turn)
      extended = wheels%n > 0 .or. size(tangent%parametric) > 0
      if (extended) then
         tangent%mean = 0.0_wp
         tangent%shift = 0.0_wp
         do i = 1, wheels%n
            call begin_wheel(system%effects%wheels(i)%axis, wheels%share(i), tangent%wheels(:, i), &
                             tangent%inner(:, i), tangent%mean)
         end do
         do i = 1, size(tangent%parametric)
            call add_parameters(self, system, forces, turn, wheels, tangent, i)
         end do
         call turn_by_mean(self, tangent%n, tangent%mean, tangent%turn)
         do i = 1, wheels%n
            call finish_wheel(self, system%effects%wheels(i), wheels, i, tangent)
         end do
      end if
      if (turn%there) then
         if (.not. extended) tangent%shift = 0.0_wp
         call shift_columns(self, tangent%n, tangent%mid, tangent%turn, tangent%shift)
         if (system%effects%n_torques > 0) &
            call add_work(self%forces, tangent%n, tangent%mid, tangent%shift, tangent%work)
         call finish_columns(self, tangent%n, tangent%mid, tangent%turn, tangent%shift, tangent%theta, &
                             tangent%momentum)
      else
         if (system%effects%n_torques > 0) &
            call add_work(self%forces, tangent%n, tangent%mid, tangent%turn, tangent%work)
         call finish_columns(self, tangent%n, tangent%mid, tangent%turn, tangent%turn, tangent%theta, &
                             tangent%momentum)
      end if
      if (extended) tangent%momentum = tangent%momentum + 2*tangent%mean
   end subroutine carry

   !> A⁻¹ with all that it is made of.
   pure subroutine set_inverse(self, active, turn, status)
      type(conserving_step_t), intent(inout) :: self
      !> There are effects with a force.
      logical, intent(in) :: active
      type(frame_turn_t), intent(in) :: turn
      type(status_t), intent(inout) :: status
      real(wp) :: m(3, 3), mean(3), change(3), n(3), rows(3, 3), determinant
      integer :: j
      associate (b => self%b, r => self%forces%r)
         self%rest = 1 - (b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
         if (turn%there) self%rest = self%rest + turn%square
         mean = times_vector(self%inertia, b) + self%scale*self%rotor
         change = mean - self%scale*self%momentum
         mean = 2*mean
         do j = 1, 3
            n = self%inertia(:, j)
            m(:, j) = self%rest*n + 2*(across(b, n) - b(j)*change)
         end do
         m(2, 1) = m(2, 1) - mean(3)
         m(3, 1) = m(3, 1) + mean(2)
         m(1, 2) = m(1, 2) + mean(3)
         m(3, 2) = m(3, 2) - mean(1)
         m(1, 3) = m(1, 3) - mean(2)
         m(2, 3) = m(2, 3) + mean(1)
         if (turn%there) call set_frame(self, turn)
         if (active) call add_forces(self, turn%there, m)
      end associate
      rows(:, 1) = across(m(:, 2), m(:, 3))
      rows(:, 2) = across(m(:, 3), m(:, 1))
      rows(:, 3) = across(m(:, 1), m(:, 2))
      determinant = rows(1, 1)*m(1, 1) + rows(2, 1)*m(2, 1) + rows(3, 1)*m(3, 1)
      if (.not. abs(determinant) > least_determinant) then
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
         return
      end if
      do j = 1, 3
         self%inverse(j, 1) = rows(1, j)/determinant
         self%inverse(j, 2) = rows(2, j)/determinant
         self%inverse(j, 3) = rows(3, j)/determinant
      end do
   end subroutine set_inverse

   !> D and ∂e/∂φ = -D[δ̄]×.
   pure subroutine set_frame(self, turn)
      type(conserving_step_t), intent(inout) :: self
      type(frame_turn_t), intent(in) :: turn
      real(wp) :: axis(3)
      integer :: j
      self%by_absolute = turn%relative_by_absolute(self%b, self%forces%r)
      axis = self%forces%r - self%b
      self%by_turn(:, 1) = [0.0_wp, axis(3), -axis(2)]
      self%by_turn(:, 2) = [-axis(3), 0.0_wp, axis(1)]
      self%by_turn(:, 3) = [axis(2), -axis(1), 0.0_wp]
      do j = 1, 3
         self%by_turn(:, j) = times_vector(self%by_absolute, self%by_turn(:, j))
      end do
      self%by_relative = 0.0_wp
   end subroutine set_frame

   !> Adds Δt rτ̄ᵀ + BD, and sets B and C; in units of the step.
   pure subroutine add_forces(self, relative, m)
      type(conserving_step_t), intent(inout) :: self
      !> D is not 1.
      logical, intent(in) :: relative
      real(wp), intent(inout) :: m(3, 3)
      real(wp) :: weight, along, tau(3), by_relative(3, 3)
      integer :: j
      weight = 0.5_wp*self%dt*self%scale
      associate (b => self%b, r => self%forces%r)
         tau = (2*weight)*self%forces%torque
         along = b(1)*tau(1) + b(2)*tau(2) + b(3)*tau(3)
         do j = 1, 3
            self%by_torque(:, j) = (2*weight*b(j))*r
            self%by_torque(j, j) = self%by_torque(j, j) - weight/self%forces%shrink
         end do
         by_relative = times_columns(self%by_torque, self%forces%by_r)
         do j = 1, 3
            by_relative(:, j) = by_relative(:, j) - r(j)*tau
            by_relative(j, j) = by_relative(j, j) + along
            m(:, j) = m(:, j) + tau(j)*r
         end do
      end associate
      self%by_relative = by_relative
      if (relative) by_relative = times_columns(by_relative, self%by_absolute)
      m = m + by_relative
   end subroutine add_forces

   !> φ and δb of columns without parameters of their own.
   pure subroutine turn_columns(self, n, by_mid, theta, momentum, mid, turn)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> ∂b/∂φ; shape (3,3).
      real(wp), intent(in) :: by_mid(3, 3)
      !> Shape (n,3).
      real(wp), intent(in) :: theta(n, 3), momentum(n, 3)
      real(wp), intent(out) :: mid(n, 3), turn(n, 3)
      real(wp) :: q(3, 3), x, y, z, u, v, w
      integer :: i
      q = (self%rest*self%scale)*self%inverse
      associate (h => self%forces%half, p => by_mid)
         do i = 1, n
            u = theta(i, 1)
            v = theta(i, 2)
            w = theta(i, 3)
            x = h(1, 1)*u + h(1, 2)*v + h(1, 3)*w
            y = h(2, 1)*u + h(2, 2)*v + h(2, 3)*w
            z = h(3, 1)*u + h(3, 2)*v + h(3, 3)*w
            mid(i, 1) = x
            mid(i, 2) = y
            mid(i, 3) = z
            u = momentum(i, 1)
            v = momentum(i, 2)
            w = momentum(i, 3)
            turn(i, 1) = (p(1, 1)*x + p(1, 2)*y + p(1, 3)*z) + (q(1, 1)*u + q(1, 2)*v + q(1, 3)*w)
            turn(i, 2) = (p(2, 1)*x + p(2, 2)*y + p(2, 3)*z) + (q(2, 1)*u + q(2, 2)*v + q(2, 3)*w)
            turn(i, 3) = (p(3, 1)*x + p(3, 2)*y + p(3, 3)*z) + (q(3, 1)*u + q(3, 2)*v + q(3, 3)*w)
         end do
      end associate
   end subroutine turn_columns

   !> δL̄ of a wheel at fixed b, from its momentum at the start alone.
   pure subroutine begin_wheel(axis, share, start, inner, mean)
      !> s, shape (3), and σ.
      real(wp), intent(in) :: axis(3), share
      !> δh0, and δh̄ at fixed b, N m s; shape (n).
      real(wp), intent(in) :: start(:)
      real(wp), intent(out) :: inner(:)
      !> Shape (n,3).
      real(wp), intent(inout) :: mean(:, :)
      integer :: j
      inner = share*start
      do j = 1, 3
         mean(:, j) = mean(:, j) + axis(j)*inner
      end do
   end subroutine begin_wheel

   !> What a column's parameters do in the step: δL̄, δb and δr at fixed start, and what they change of the works.
   subroutine add_parameters(self, system, forces, turn, wheels, tangent, m)
      class(conserving_step_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      type(wheel_steps_t), intent(in) :: wheels
      type(tangent_t), intent(inout) :: tangent
      !> Which of the parametric columns.
      integer, intent(in) :: m
      real(wp) :: mean(3), rhs(3), torque(3), working(3), shift(3)
      integer :: k
      k = tangent%parametric(m)
      associate (column => tangent%columns(k), b => self%b, rate => self%forces%rate)
         mean = rate*times_vector(tangent%inertia(:, :, m), b) + column%rotor
         if (wheels%n > 0) call add_wheel_parameters(self, system%effects%wheels, wheels, column, mean, &
                                                     tangent%inner(k, :), tangent%work(k))
         rhs = 0.0_wp
         if (forces%active) then
            call self%forces%own_change(system%effects, forces, column, torque, working)
            rhs = -times_vector(self%by_torque, torque)
            tangent%work(k) = tangent%work(k) + 4*dot_product(self%forces%r, working)
         end if
         if (turn%there) then
            shift = (-0.25_wp*self%dt)*times_vector(self%by_absolute, times_vector( &
                                               self%forces%half, rotate_to_body(self%frame, column%frame)))
            tangent%shift(k, :) = shift
            rhs = rhs - times_vector(self%by_relative, shift) &
                  - (2*(0.25_wp*self%dt)**2*dot_product(turn%rate, column%frame))* &
                  (times_vector(self%inertia, b) + self%scale*(self%rotor - self%momentum))
         end if
         tangent%turn(k, :) = tangent%turn(k, :) + times_vector(self%inverse, rhs)
         tangent%mean(k, :) = tangent%mean(k, :) + mean
      end associate
   end subroutine add_parameters

   !> What parameters of wheels and motors change of L̄, of their h̄ and of their works, at fixed b.
   pure subroutine add_wheel_parameters(self, wheels, steps, column, mean, inner, work)
      type(conserving_step_t), intent(in) :: self
      !> Shape (n_wheels).
      type(wheel_t), intent(in) :: wheels(:)
      type(wheel_steps_t), intent(in) :: steps
      type(column_t), intent(in) :: column
      real(wp), intent(inout) :: mean(3), inner(:), work
      real(wp) :: half, base, turned, share, carried, own, drive, speed, axis(3), moved
      integer :: i, m
      if (.not. allocated(column%effects)) return
      do m = 1, size(column%effects)
         if (column%effects(m)%kind /= OF_WHEEL) cycle
         i = column%effects(m)%place
         associate (wheel => wheels(i), c => column%effects(m)%change, sigma => steps%share(i))
            half = 0.5_wp*self%dt
            base = steps%start_momentum(i) + half*steps%drive(i)
            turned = self%forces%rate*dot_product(wheel%axis, self%b)
            share = -half*sigma**2*(c(6) - wheel%friction*c(4)/wheel%inertia)/wheel%inertia
            carried = half*(c(6)*sigma + wheel%friction*share)
            axis = wheel%axis_change(c)
            moved = self%forces%rate*dot_product(axis, self%b)
            drive = 0.0_wp
            if (steps%drives(i)) drive = wheel%drive_change(c, steps%asked(i))
            own = share*base + sigma*half*drive + carried*turned &
                  + half*wheel%friction*sigma*moved
            speed = sigma*(base/wheel%inertia - turned)
            inner(i) = inner(i) + own
            mean = mean + own*wheel%axis + (sigma*base + half*wheel%friction*sigma*turned)*axis
            work = work + self%dt*(drive - c(6)*speed)*speed &
                   - self%dt*(steps%drive(i) - 2*wheel%friction*speed)*( &
                   (sigma*base + half*wheel%friction*sigma*turned)*c(4)/wheel%inertia**2 + moved)
         end associate
      end do
   end subroutine add_wheel_parameters

   !> Adds to δb what δL̄ at fixed b makes of it.
   pure subroutine turn_by_mean(self, n, mean, turn)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mean(n, 3)
      real(wp), intent(inout) :: turn(n, 3)
      real(wp) :: m(3, 3), unit(3)
      integer :: i, j
      do j = 1, 3
         unit = 0.0_wp
         unit(j) = self%scale
         m(:, j) = times_vector(self%inverse, -self%rest*unit - 2*across(self%b, unit))
      end do
      do j = 1, 3
         do i = 1, n
            turn(i, j) = turn(i, j) + (m(j, 1)*mean(i, 1) + m(j, 2)*mean(i, 2) + m(j, 3)*mean(i, 3))
         end do
      end do
   end subroutine turn_by_mean

   !> δh1 of a wheel, and what it changes of the works of motor and friction.
   pure subroutine finish_wheel(self, wheel, steps, i, tangent)
      type(conserving_step_t), intent(in) :: self
      type(wheel_t), intent(in) :: wheel
      type(wheel_steps_t), intent(in) :: steps
      !> Its number.
      integer, intent(in) :: i
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: turned, inner, carried, speed, factor
      integer :: k
      carried = 0.5_wp*self%dt*wheel%friction*steps%share(i)
      speed = steps%share(i)*((steps%start_momentum(i) + 0.5_wp*self%dt*steps%drive(i))/wheel%inertia &
                              - self%forces%rate*dot_product(wheel%axis, self%b))
      factor = self%dt*(steps%drive(i) - 2*wheel%friction*speed)
      do k = 1, tangent%n
         turned = self%forces%rate*dot_product(wheel%axis, tangent%turn(k, :))
         inner = tangent%inner(k, i) + carried*turned
         tangent%work(k) = tangent%work(k) + factor*(inner/wheel%inertia - turned)
         tangent%wheels(k, i) = 2*inner - tangent%wheels(k, i)
      end do
   end subroutine finish_wheel

   !> δr of columns from φ and δb; on entry that of their own.
   pure subroutine shift_columns(self, n, mid, turn, shift)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mid(n, 3), turn(n, 3)
      real(wp), intent(inout) :: shift(n, 3)
      integer :: i, j
      associate (d => self%by_absolute, e => self%by_turn)
         do j = 1, 3
            do i = 1, n
               shift(i, j) = shift(i, j) + (d(j, 1)*turn(i, 1) + d(j, 2)*turn(i, 2) + d(j, 3)*turn(i, 3)) &
                             + (e(j, 1)*mid(i, 1) + e(j, 2)*mid(i, 2) + e(j, 3)*mid(i, 3))
            end do
         end do
      end associate
   end subroutine shift_columns

   !> Change of the work of the torques, 4r·τ.
   pure subroutine add_work(forces, n, mid, shift, work)
      type(forces_tangent_t), intent(in) :: forces
      integer, intent(in) :: n
      !> φ and δr; shape (n,3).
      real(wp), intent(in) :: mid(n, 3), shift(n, 3)
      !> Shape (n).
      real(wp), intent(inout) :: work(n)
      real(wp) :: a(3), c(3)
      integer :: i
      do i = 1, 3
         a(i) = 4*dot_product(forces%r, forces%working_by_mid(:, i))
         c(i) = 4*(forces%working(i) + dot_product(forces%r, forces%working_by_r(:, i)))
      end do
      do i = 1, n
         work(i) = work(i) + (a(1)*mid(i, 1) + a(2)*mid(i, 2) + a(3)*mid(i, 3)) &
                   + (c(1)*shift(i, 1) + c(2)*shift(i, 2) + c(3)*shift(i, 3))
      end do
   end subroutine add_work

   !> θ1 and δL1 from φ, δb and δr, without δL̄.
   pure subroutine finish_columns(self, n, mid, turn, shift, theta, momentum)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mid(n, 3), turn(n, 3), shift(n, 3)
      real(wp), intent(inout) :: theta(n, 3), momentum(n, 3)
      real(wp) :: k(3, 3), grow, x, y, z, u, v, w
      integer :: i
      k = (2/self%scale)*self%inertia
      grow = 4*self%forces%shrink
      associate (h => self%forces%half)
         do i = 1, n
            u = turn(i, 1)
            v = turn(i, 2)
            w = turn(i, 3)
            x = mid(i, 1) + grow*shift(i, 1)
            y = mid(i, 2) + grow*shift(i, 2)
            z = mid(i, 3) + grow*shift(i, 3)
            theta(i, 1) = h(1, 1)*x + h(1, 2)*y + h(1, 3)*z
            theta(i, 2) = h(2, 1)*x + h(2, 2)*y + h(2, 3)*z
            theta(i, 3) = h(3, 1)*x + h(3, 2)*y + h(3, 3)*z
            momentum(i, 1) = (k(1, 1)*u + k(1, 2)*v + k(1, 3)*w) - momentum(i, 1)
            momentum(i, 2) = (k(2, 1)*u + k(2, 2)*v + k(2, 3)*w) - momentum(i, 2)
            momentum(i, 3) = (k(3, 1)*u + k(3, 2)*v + k(3, 3)*w) - momentum(i, 3)
         end do
      end associate
   end subroutine finish_columns

end module nutate_step_tangent
