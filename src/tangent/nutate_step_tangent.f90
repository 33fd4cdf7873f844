!> The tangent of one step of the conserving scheme: one 3×3 solve with the step's own Jacobian, for both forms of the
!> equations.
!>
!> The b of the step is a root of G (`nutate_reduced_equations`), with the r by which the body turns in space axes that
!> turn (`nutate_frame_turn`; r = b where they stand still). A change of b, at the root with A = ∂G/∂b, β = |b|²,
!> ρ = |r|², d = |δ|², δ̄ = b - r, δL̄ and δτ̄ at fixed b, φ = Rhθ0:
!>
!>     Aδb = (1-β+d)(δL0 - δL̄) - 2b×δL̄ - Be - Cδτ̄
!>     δr  = Dδb + e,   D = (1 + [δ̄]×N)⁻¹,   e = -Dδ̄×φ
!>     θ1  = Rh(φ + 4δr/(1+ρ)),   δL1 = 2((4/Δt)Jδb + δL̄) - δL0
!>     C   = -½Δt((1+ρ)1 - 2rbᵀ),   B = -½Δt(2τ̄rᵀ - 2(b·τ̄)1) + C ∂τ̄/∂r
!>     A   = (1-β+d)(4/Δt)J + 2[b]×(4/Δt)J - 2(L̄-L0)bᵀ - 2[L̄]× + Δt rτ̄ᵀ + BD
!>
!> Every part of A is taken at the root: what Newton keeps from earlier steps is not good enough. δL1 is L̄ = ½(L0 + L1)
!> = (4/Δt)Jb + h differentiated. Solved is for y, half of what δL gains, so that only the gain is rounded: with M =
!> (Δt/4)AJ⁻¹ = 1-β+d + R,
!>
!>     My = -R(δL0 - δL̄) - 2b×δL̄ - Be - Cδτ̄,   δb = (Δt/4)J⁻¹(δL0 + y - δL̄),   δL1 = δL0 + 2y
!>
!> Equations are multiplied by Δt/4s as those of the step are, s a size of J.
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
      type(forces_tangent_t), private :: forces
      !> Δt/4s; J/s with what wheels carry, and its inverse; shape (3,3).
      real(wp), private :: scale = 0.0_wp, inertia(3, 3) = 0.0_wp, inverse_inertia(3, 3) = 0.0_wp
      !> M⁻¹; B and C times Δt/4s; D and ∂e/∂φ; shape (3,3).
      real(wp), private :: inverse(3, 3) = 0.0_wp, by_relative(3, 3) = 0.0_wp, by_torque(3, 3) = 0.0_wp
      real(wp), private :: by_absolute(3, 3) = 0.0_wp, by_turn(3, 3) = 0.0_wp
      !> y by δL0, by φ, and δb by δL̄; shape (3,3).
      real(wp), private :: by_momentum(3, 3) = 0.0_wp, by_mid(3, 3) = 0.0_wp, turn_by_mean(3, 3) = 0.0_wp
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
      !> Present where there are wheels.
      type(wheel_steps_t), intent(in), optional :: wheels
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      real(wp) :: largest, r(3)
      logical :: plain
      largest = max(system%body%inertia(1, 1), system%body%inertia(2, 2), system%body%inertia(3, 3))
      self%scale = 0.25_wp*self%dt/largest
      self%inertia = (1/largest)*system%body%inertia
      self%inverse_inertia = system%body%inverse_inertia
      if (present(wheels)) then
         self%inertia = self%inertia + wheels%carried/largest
         call wheels%add_to_inverse(system%effects, self%inverse_inertia)
      end if
      self%inverse_inertia = largest*self%inverse_inertia
      r = self%b
      if (turn%there) r = turn%to_relative(self%b)
      call self%forces%set(system%effects, forces, r, 4/self%dt)
      call set_matrices(self, forces%active, turn, status)
      if (status%code /= 0) return
      plain = .not. (turn%there .or. present(wheels) .or. size(tangent%parametric) > 0)
      if (plain .and. .not. forces%active) then
         call move_free(self, tangent%n, tangent%theta, tangent%momentum)
      else if (plain) then
         if (system%effects%n_torques > 0) &
            call add_plain_work(self, tangent%n, tangent%theta, tangent%momentum, tangent%work)
         call move_plain(self, tangent%n, tangent%theta, tangent%momentum)
      else
         call move_extended(self, system, forces, turn, wheels, tangent)
      end if
   end subroutine carry

   !> Moves columns with all that parameters, wheels, torques and axes that turn bring with them.
   subroutine move_extended(self, system, forces, turn, wheels, tangent)
      type(conserving_step_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      !> Present where there are wheels.
      type(wheel_steps_t), intent(in), optional :: wheels
      type(tangent_t), intent(inout) :: tangent
      logical :: extended
      integer :: i
      call find_changes(self, tangent%n, forces%active .or. turn%there, tangent%theta, tangent%momentum, tangent%mid, &
                        tangent%change)
      extended = present(wheels) .or. size(tangent%parametric) > 0
      if (extended .or. turn%there) tangent%shift = 0.0_wp
      if (extended) then
         tangent%mean = 0.0_wp
         do i = 1, system%effects%n_wheels
            call begin_wheel(system%effects%wheels(i)%axis, wheels%share(i), tangent%wheels(:, i), &
                             tangent%inner(:, i), tangent%mean)
         end do
         do i = 1, size(tangent%parametric)
            call add_parameters(self, system, forces, turn, wheels, tangent, i)
         end do
         call change_by_mean(self, tangent%n, tangent%mean, tangent%change)
         tangent%turn = tangent%momentum + tangent%change - tangent%mean
      else
         tangent%turn = tangent%momentum + tangent%change
      end if
      call turn_columns(self%turn_by_mean, tangent%n, tangent%turn)
      do i = 1, system%effects%n_wheels
         call finish_wheel(self, system%effects%wheels(i), wheels, i, tangent)
      end do
      tangent%momentum = tangent%momentum + 2*tangent%change
      if (turn%there) then
         call shift_columns(self, tangent%n, tangent%mid, tangent%turn, tangent%shift)
         tangent%turn = tangent%shift
      end if
      if (system%effects%n_torques > 0) call add_work(self%forces, tangent%n, tangent%mid, tangent%turn, tangent%work)
      tangent%theta = tangent%mid + (4*self%forces%shrink)*tangent%turn
      tangent%turn = tangent%theta
      call turn_columns(self%forces%swing, tangent%n, tangent%turn)
      tangent%theta = tangent%theta + tangent%turn
   end subroutine move_extended

   !> M⁻¹ with all that it is made of, and the matrices of the columns.
   pure subroutine set_matrices(self, active, turn, status)
      type(conserving_step_t), intent(inout) :: self
      !> There are effects with a force.
      logical, intent(in) :: active
      type(frame_turn_t), intent(in) :: turn
      type(status_t), intent(inout) :: status
      real(wp) :: s(3, 3), m(3, 3), mean(3), change(3), twice(3), rest, factor
      integer :: j
      associate (b => self%b)
         rest = 1 - (b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
         if (turn%there) rest = rest + turn%square
         mean = times_vector(self%inertia, b) + self%scale*self%rotor
         change = 2*(self%scale*self%momentum - mean)
         do j = 1, 3
            s(:, j) = b(j)*change
         end do
         call add_cross(-2*mean, s)
         if (turn%there) call set_frame(self, turn)
         if (active) call add_forces(self, turn%there, s)
         call times_inverse_inertia(self%inverse_inertia, s)
         twice = 2*b
         call add_cross(twice, s)
      end associate
      m = s
      do j = 1, 3
         m(j, j) = m(j, j) + rest
      end do
      call invert(m, self%inverse, status)
      if (status%code /= 0) return
      self%by_momentum = -times_columns(self%inverse, s)
      self%turn_by_mean = self%scale*self%inverse_inertia
      if (.not. (active .or. turn%there)) return
      m = 0.0_wp
      if (active) call times_force_factor(self, self%forces%by_mid, m)
      if (turn%there) m = m + times_columns(self%by_relative, self%by_turn)
      factor = -1/self%scale
      m = factor*m
      self%by_mid = times_columns(self%inverse, m)
   end subroutine set_matrices

   !> A matrix times J⁻¹, which has no elements off the diagonal in principal axes.
   pure subroutine times_inverse_inertia(inverse, matrix)
      real(wp), intent(in) :: inverse(3, 3)
      real(wp), intent(inout) :: matrix(3, 3)
      integer :: j
      if (abs(inverse(1, 2)) + abs(inverse(1, 3)) + abs(inverse(2, 3)) > 0.0_wp) then
         matrix = times_columns(matrix, inverse)
      else
         do j = 1, 3
            matrix(:, j) = inverse(j, j)*matrix(:, j)
         end do
      end if
   end subroutine times_inverse_inertia

   !> Adds [v]× to a matrix.
   pure subroutine add_cross(v, matrix)
      real(wp), intent(in) :: v(3)
      real(wp), intent(inout) :: matrix(3, 3)
      matrix(2, 1) = matrix(2, 1) + v(3)
      matrix(3, 1) = matrix(3, 1) - v(2)
      matrix(1, 2) = matrix(1, 2) - v(3)
      matrix(3, 2) = matrix(3, 2) + v(1)
      matrix(1, 3) = matrix(1, 3) + v(2)
      matrix(2, 3) = matrix(2, 3) - v(1)
   end subroutine add_cross

   !> The inverse from the adjugate. Errors: `NUTATE_SINGULAR`.
   pure subroutine invert(m, inverse, status)
      real(wp), intent(in) :: m(3, 3)
      real(wp), intent(out) :: inverse(3, 3)
      type(status_t), intent(inout) :: status
      real(wp) :: rows(3, 3), determinant
      rows(:, 1) = across(m(:, 2), m(:, 3))
      rows(:, 2) = across(m(:, 3), m(:, 1))
      rows(:, 3) = across(m(:, 1), m(:, 2))
      determinant = rows(1, 1)*m(1, 1) + rows(2, 1)*m(2, 1) + rows(3, 1)*m(3, 1)
      if (.not. abs(determinant) > least_determinant) then
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
      else
         inverse = (1/determinant)*transpose(rows)
      end if
   end subroutine invert

   !> D and ∂e/∂φ = -D[δ̄]×.
   pure subroutine set_frame(self, turn)
      type(conserving_step_t), intent(inout) :: self
      type(frame_turn_t), intent(in) :: turn
      self%by_absolute = turn%relative_by_absolute(self%b, self%forces%r)
      self%by_turn = 0.0_wp
      call add_cross(self%forces%r - self%b, self%by_turn)
      self%by_turn = times_columns(self%by_absolute, self%by_turn)
      self%by_relative = 0.0_wp
   end subroutine set_frame

   !> Adds Δt rτ̄ᵀ + BD to S, and sets B; in units of the step.
   pure subroutine add_forces(self, relative, s)
      type(conserving_step_t), intent(inout) :: self
      !> D is not 1.
      logical, intent(in) :: relative
      real(wp), intent(inout) :: s(3, 3)
      real(wp) :: along, tau(3), by_relative(3, 3)
      integer :: j
      associate (b => self%b, r => self%forces%r)
         tau = (self%dt*self%scale)*self%forces%torque
         along = b(1)*tau(1) + b(2)*tau(2) + b(3)*tau(3)
         call times_force_factor(self, self%forces%by_r, by_relative)
         do j = 1, 3
            by_relative(:, j) = by_relative(:, j) - r(j)*tau
            by_relative(j, j) = by_relative(j, j) + along
            s(:, j) = s(:, j) + tau(j)*r
         end do
      end associate
      self%by_relative = by_relative
      if (relative) by_relative = times_columns(by_relative, self%by_absolute)
      s = s + by_relative
   end subroutine add_forces

   !> C times a matrix, in units of the step: -½Δt((1+ρ)X - 2r(bᵀX)).
   pure subroutine times_force_factor(self, x, product)
      type(conserving_step_t), intent(in) :: self
      real(wp), intent(in) :: x(3, 3)
      real(wp), intent(out) :: product(3, 3)
      real(wp) :: weight, straight, along
      integer :: j
      weight = self%dt*self%scale
      straight = -0.5_wp*weight/self%forces%shrink
      do j = 1, 3
         along = weight*(self%b(1)*x(1, j) + self%b(2)*x(2, j) + self%b(3)*x(3, j))
         product(1, j) = straight*x(1, j) + along*self%forces%r(1)
         product(2, j) = straight*x(2, j) + along*self%forces%r(2)
         product(3, j) = straight*x(3, j) + along*self%forces%r(3)
      end do
   end subroutine times_force_factor

   !> Columns of a free body, all at once: φ, y, δL̄, θ1 and δL1.
   pure subroutine move_free(self, n, theta, momentum)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(inout) :: theta(n, 3), momentum(n, 3)
      real(wp) :: h(3, 3), w(3, 3), g(3, 3), x, y, z, a, b, c
      integer :: i
      w = self%by_momentum
      ! θ1 = Rh²θ0 + 4Rh δb/(1+ρ), of the turn what it adds: then only that is rounded.
      h = 2*self%forces%swing + times_columns(self%forces%swing, self%forces%swing)
      g = (4*self%forces%shrink)*times_columns(self%forces%half, self%turn_by_mean)
      do i = 1, n
         x = w(1, 1)*momentum(i, 1) + w(1, 2)*momentum(i, 2) + w(1, 3)*momentum(i, 3)
         y = w(2, 1)*momentum(i, 1) + w(2, 2)*momentum(i, 2) + w(2, 3)*momentum(i, 3)
         z = w(3, 1)*momentum(i, 1) + w(3, 2)*momentum(i, 2) + w(3, 3)*momentum(i, 3)
         a = momentum(i, 1) + x
         b = momentum(i, 2) + y
         c = momentum(i, 3) + z
         momentum(i, 1) = a + x
         momentum(i, 2) = b + y
         momentum(i, 3) = c + z
         x = theta(i, 1)
         y = theta(i, 2)
         z = theta(i, 3)
         theta(i, 1) = x + ((h(1, 1)*x + h(1, 2)*y + h(1, 3)*z) + (g(1, 1)*a + g(1, 2)*b + g(1, 3)*c))
         theta(i, 2) = y + ((h(2, 1)*x + h(2, 2)*y + h(2, 3)*z) + (g(2, 1)*a + g(2, 2)*b + g(2, 3)*c))
         theta(i, 3) = z + ((h(3, 1)*x + h(3, 2)*y + h(3, 3)*z) + (g(3, 1)*a + g(3, 2)*b + g(3, 3)*c))
      end do
   end subroutine move_free

   !> The same under potentials and torques.
   pure subroutine move_plain(self, n, theta, momentum)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(inout) :: theta(n, 3), momentum(n, 3)
      real(wp) :: h(3, 3), w(3, 3), p(3, 3), g(3, 3), x, y, z, a, b, c, u, v, t
      integer :: i
      h = self%forces%swing
      w = self%by_momentum
      p = self%by_mid
      g = (4*self%forces%shrink)*self%turn_by_mean
      do i = 1, n
         a = theta(i, 1)
         b = theta(i, 2)
         c = theta(i, 3)
         x = a + (h(1, 1)*a + h(1, 2)*b + h(1, 3)*c)
         y = b + (h(2, 1)*a + h(2, 2)*b + h(2, 3)*c)
         z = c + (h(3, 1)*a + h(3, 2)*b + h(3, 3)*c)
         a = momentum(i, 1)
         b = momentum(i, 2)
         c = momentum(i, 3)
         u = (p(1, 1)*x + p(1, 2)*y + p(1, 3)*z) + (w(1, 1)*a + w(1, 2)*b + w(1, 3)*c)
         v = (p(2, 1)*x + p(2, 2)*y + p(2, 3)*z) + (w(2, 1)*a + w(2, 2)*b + w(2, 3)*c)
         t = (p(3, 1)*x + p(3, 2)*y + p(3, 3)*z) + (w(3, 1)*a + w(3, 2)*b + w(3, 3)*c)
         a = a + u
         b = b + v
         c = c + t
         momentum(i, 1) = a + u
         momentum(i, 2) = b + v
         momentum(i, 3) = c + t
         u = x + (g(1, 1)*a + g(1, 2)*b + g(1, 3)*c)
         v = y + (g(2, 1)*a + g(2, 2)*b + g(2, 3)*c)
         t = z + (g(3, 1)*a + g(3, 2)*b + g(3, 3)*c)
         theta(i, 1) = u + (h(1, 1)*u + h(1, 2)*v + h(1, 3)*t)
         theta(i, 2) = v + (h(2, 1)*u + h(2, 2)*v + h(2, 3)*t)
         theta(i, 3) = t + (h(3, 1)*u + h(3, 2)*v + h(3, 3)*t)
      end do
   end subroutine move_plain

   !> Change of the work of the torques by such columns, before they are moved: 4r·τ as rows by θ0 and δL0.
   pure subroutine add_plain_work(self, n, theta, momentum, work)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shapes (n,3), (n).
      real(wp), intent(in) :: theta(n, 3), momentum(n, 3)
      real(wp), intent(inout) :: work(n)
      real(wp) :: by_mid(3), by_turn(3), by_theta(3), by_momentum(3)
      integer :: i
      call find_work_rows(self%forces, by_mid, by_turn)
      by_turn = row_times(by_turn, self%turn_by_mean)
      by_mid = by_mid + row_times(by_turn, self%by_mid)
      by_theta = by_mid + row_times(by_mid, self%forces%swing)
      by_momentum = by_turn + row_times(by_turn, self%by_momentum)
      do i = 1, n
         work(i) = work(i) + (by_theta(1)*theta(i, 1) + by_theta(2)*theta(i, 2) + by_theta(3)*theta(i, 3)) &
                   + (by_momentum(1)*momentum(i, 1) + by_momentum(2)*momentum(i, 2) + by_momentum(3)*momentum(i, 3))
      end do
   end subroutine add_plain_work

   !> A row times a matrix; shape (3).
   pure function row_times(row, m) result(product)
      real(wp), intent(in) :: row(3), m(3, 3)
      real(wp) :: product(3)
      integer :: j
      do j = 1, 3
         product(j) = row(1)*m(1, j) + row(2)*m(2, j) + row(3)*m(3, j)
      end do
   end function row_times

   !> φ and y of columns without parameters of their own.
   pure subroutine find_changes(self, n, turned, theta, momentum, mid, change)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> y depends on φ.
      logical, intent(in) :: turned
      !> Shape (n,3).
      real(wp), intent(in) :: theta(n, 3), momentum(n, 3)
      real(wp), intent(out) :: mid(n, 3), change(n, 3)
      integer :: i, j
      associate (h => self%forces%swing, w => self%by_momentum, p => self%by_mid)
         do j = 1, 3
            do i = 1, n
               mid(i, j) = theta(i, j) + (h(j, 1)*theta(i, 1) + h(j, 2)*theta(i, 2) + h(j, 3)*theta(i, 3))
               change(i, j) = w(j, 1)*momentum(i, 1) + w(j, 2)*momentum(i, 2) + w(j, 3)*momentum(i, 3)
            end do
         end do
         if (.not. turned) return
         do j = 1, 3
            do i = 1, n
               change(i, j) = change(i, j) + (p(j, 1)*mid(i, 1) + p(j, 2)*mid(i, 2) + p(j, 3)*mid(i, 3))
            end do
         end do
      end associate
   end subroutine find_changes

   !> A matrix times each column, in place.
   pure subroutine turn_columns(m, n, columns)
      real(wp), intent(in) :: m(3, 3)
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(inout) :: columns(n, 3)
      real(wp) :: x, y, z
      integer :: i
      do i = 1, n
         x = columns(i, 1)
         y = columns(i, 2)
         z = columns(i, 3)
         columns(i, 1) = m(1, 1)*x + m(1, 2)*y + m(1, 3)*z
         columns(i, 2) = m(2, 1)*x + m(2, 2)*y + m(2, 3)*z
         columns(i, 3) = m(3, 1)*x + m(3, 2)*y + m(3, 3)*z
      end do
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

   !> What a column's parameters do in the step: δL̄ at fixed b, y and δr, and what they change of the works.
   subroutine add_parameters(self, system, forces, turn, wheels, tangent, m)
      class(conserving_step_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      type(wheel_steps_t), intent(in), optional :: wheels
      type(tangent_t), intent(inout) :: tangent
      !> Which of the parametric columns.
      integer, intent(in) :: m
      real(wp) :: mean(3), rhs(3), torque(3), working(3), shift(3)
      integer :: k
      k = tangent%parametric(m)
      associate (column => tangent%columns(k), b => self%b, rate => self%forces%rate)
         mean = rate*times_vector(tangent%inertia(:, :, m), b) + column%rotor
         if (present(wheels)) call add_wheel_parameters(self, system%effects%wheels, wheels, column, mean, &
                                                     tangent%inner(k, :), tangent%work(k))
         rhs = 0.0_wp
         if (forces%active) then
            call self%forces%own_change(system%effects, forces, column, torque, working)
            rhs = (0.5_wp*self%dt*self%scale)*(torque/self%forces%shrink - (2*dot_product(b, torque))*self%forces%r)
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
         tangent%change(k, :) = tangent%change(k, :) + times_vector(self%inverse, rhs)/self%scale
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
      ! Motors that follow attitude and rate have no such steps.
      real(wp), parameter :: unturned(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], at_rest(3) = 0.0_wp
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
            if (steps%drives(i)) drive = wheel%drive_change(c, steps%asked(i), unturned, at_rest)
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

   !> Adds to y what δL̄ at fixed b makes of it: M⁻¹(R δL̄ - 2b×δL̄).
   pure subroutine change_by_mean(self, n, mean, change)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mean(n, 3)
      real(wp), intent(inout) :: change(n, 3)
      real(wp) :: m(3, 3)
      integer :: i, j
      m = 0.0_wp
      call add_cross(-2*self%b, m)
      m = times_columns(self%inverse, m) - self%by_momentum
      do j = 1, 3
         do i = 1, n
            change(i, j) = change(i, j) + (m(j, 1)*mean(i, 1) + m(j, 2)*mean(i, 2) + m(j, 3)*mean(i, 3))
         end do
      end do
   end subroutine change_by_mean

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
      call find_work_rows(forces, a, c)
      do i = 1, n
         work(i) = work(i) + (a(1)*mid(i, 1) + a(2)*mid(i, 2) + a(3)*mid(i, 3)) &
                   + (c(1)*shift(i, 1) + c(2)*shift(i, 2) + c(3)*shift(i, 3))
      end do
   end subroutine add_work

   !> Its derivatives by φ and by δr; shape (3).
   pure subroutine find_work_rows(forces, by_mid, by_turn)
      type(forces_tangent_t), intent(in) :: forces
      real(wp), intent(out) :: by_mid(3), by_turn(3)
      integer :: i
      do i = 1, 3
         by_mid(i) = 4*dot_product(forces%r, forces%working_by_mid(:, i))
         by_turn(i) = 4*(forces%working(i) + dot_product(forces%r, forces%working_by_r(:, i)))
      end do
   end subroutine find_work_rows

end module nutate_step_tangent
