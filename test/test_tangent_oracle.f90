!> The oracle of sensitivities: steps in 33 digits, from numbers that can be changed one by one, and central
!> differences of their ends. It shares no equation with the tangent: implicit stages are solved by Newton, explicit
!> ones evaluated, flows extrapolated (W. B. Gragg 1965; R. Bulirsch, J. Stoer 1966).
module test_tangent_oracle
   use nutate_kinds, only: wp
   use test_oracle, only: qp
   implicit none
   private

   public :: tangent_oracle_t, n_parameters, place, IMPLICIT_STAGES, RUNGE_KUTTA, FLOW
   public :: turn_at, momentum_at, inertia_at, rotor_at, moment_at, field_at, damping_at, point_at, anchor_at, &
      stiffness_at, length_at

   !> Parameters of a step: rotation of the initial state, L0, J (11, 22, 33, 12, 13, 23), h, m and field of a dipole,
   !> damping, body point, anchor, stiffness and rest length of a spring.
   integer, parameter :: n_parameters = 32
   integer, parameter :: turn_at = 0, momentum_at = 3, inertia_at = 6, rotor_at = 12, moment_at = 15, field_at = 18, &
                         damping_at = 21, point_at = 24, anchor_at = 27, stiffness_at = 30, length_at = 31
   integer, parameter :: place(2, 6) = reshape([1, 1, 2, 2, 3, 3, 1, 2, 1, 3, 2, 3], [2, 6])
   integer, parameter :: IMPLICIT_STAGES = 1, RUNGE_KUTTA = 2, FLOW = 3

   !> Shift of the differences.
   real(qp), parameter :: shift = 1e-11_qp
   !> Columns of the extrapolation, of n = 2, 4, 6, … steps each; turn of the body in one extrapolation, rad.
   integer, parameter :: columns = 12
   real(wp), parameter :: small_turn = 0.3_wp

   !> A step.
   type :: tangent_oracle_t
      !> `IMPLICIT_STAGES`, ...
      integer :: kind = IMPLICIT_STAGES
      !> Lengths over Δt of implicit stages; shape (stages).
      real(wp), allocatable :: lengths(:)
      !> aᵢⱼ as a(j, i - 1) from the second stage on, and bᵢ.
      real(wp), allocatable :: a(:, :), weights(:)
      real(qp), private :: x(n_parameters) = 0, q(4) = 0, dt = 0
      !> Root of each stage, and the inverse of its Jacobian; shape (3, stages) and (3, 3, stages).
      real(qp), allocatable, private :: b(:, :), inverse(:, :, :)
      !> The end: R and L.
      real(qp) :: rotation(3, 3) = 0, momentum(3) = 0
   contains
      !> Performs the step.
      procedure :: begin
      !> The derivative of its end by a parameter.
      procedure :: differ
   end type tangent_oracle_t

contains

   !> Performs the step: `rotation` and `momentum` are its end.
   subroutine begin(self, p, q, dt, ok)
      class(tangent_oracle_t), intent(inout) :: self
      real(wp), intent(in) :: p(n_parameters), q(4), dt
      !> The roots are found.
      logical, intent(out) :: ok
      self%x = real(p, qp)
      self%q = real(q, qp)
      self%dt = real(dt, qp)
      if (self%kind == IMPLICIT_STAGES) then
         if (allocated(self%b)) deallocate (self%b, self%inverse)
         allocate (self%b(3, size(self%lengths)), self%inverse(3, 3, size(self%lengths)), source=0.0_qp)
         call walk(self, self%x, .true., self%rotation, self%momentum, ok)
      else
         call step(self, self%x, self%rotation, self%momentum, ok)
      end if
   end subroutine begin

   !> A column by central differences, Ω0 held where J or h changes.
   subroutine differ(self, k, column, ok)
      class(tangent_oracle_t), intent(inout) :: self
      integer, intent(in) :: k
      !> θ and δL.
      real(qp), intent(out) :: column(6)
      logical, intent(out) :: ok
      real(qp) :: x(n_parameters), ends(3, 3, 2), l(3, 2), omega(3), turn(3, 3)
      integer :: i
      omega = solved(inertia_of(self%x), momentum_of(self%x) - self%x(rotor_at + 1:rotor_at + 3))
      do i = 1, 2
         x = self%x
         x(k) = x(k) + (3 - 2*i)*shift
         if (k > inertia_at .and. k <= moment_at) &
            x(momentum_at + 1:momentum_at + 3) = matmul(inertia_of(x), omega) + x(rotor_at + 1:rotor_at + 3)
         call step(self, x, ends(:, :, i), l(:, i), ok)
         if (.not. ok) return
      end do
      turn = matmul(transpose(ends(:, :, 2)), ends(:, :, 1))
      column(1:3) = [turn(3, 2) - turn(2, 3), turn(1, 3) - turn(3, 1), turn(2, 1) - turn(1, 2)]/(4*shift)
      column(4:6) = (l(:, 1) - l(:, 2))/(2*shift)
   end subroutine differ

   !> The step from changed parameters: R and L at its end.
   subroutine step(self, x, last, l, ok)
      class(tangent_oracle_t), intent(inout) :: self
      real(qp), intent(in) :: x(n_parameters)
      real(qp), intent(out) :: last(3, 3), l(3)
      logical, intent(out) :: ok
      real(qp) :: y(7)
      if (self%kind == IMPLICIT_STAGES) then
         call walk(self, x, .false., last, l, ok)
         return
      end if
      ok = .true.
      y(1:4) = times(self%q, [1.0_qp, x(turn_at + 1:turn_at + 3)/2])
      y(5:7) = momentum_of(x)
      if (self%kind == RUNGE_KUTTA) then
         call take_stages(self, x, y)
      else
         call follow_flow(x, self%dt, y)
      end if
      last = matrix_of(y(1:4))
      l = y(5:7)
   end subroutine step

   !> Implicit stages. The first walk finds the roots from b = ¼ΔtΩ, those after it go on from these with the same
   !> Jacobian.
   subroutine walk(self, x, is_first, last, l, ok)
      class(tangent_oracle_t), intent(inout) :: self
      real(qp), intent(in) :: x(n_parameters)
      logical, intent(in) :: is_first
      real(qp), intent(out) :: last(3, 3), l(3)
      logical, intent(out) :: ok
      real(qp) :: here(n_parameters), dt, h(3), b(3), tau(3), half(3, 3)
      integer :: i, k
      here = x
      last = matrix_of(times(self%q, [1.0_qp, x(turn_at + 1:turn_at + 3)/2]))
      do i = 1, size(self%lengths)
         dt = real(self%lengths(i), qp)*self%dt
         if (is_first) then
            b = (dt/4)*solved(inertia_of(here), momentum_of(here) - here(rotor_at + 1:rotor_at + 3))
         else
            b = self%b(:, i)
         end if
         do k = 1, 20
            if (is_first .and. k <= 4) self%inverse(:, :, i) = inverse_slope(here, last, dt, b)
            h = matmul(self%inverse(:, :, i), equations(here, last, dt, b, tau))
            b = b - h
            if (maxval(abs(h)) < 1e-31_qp .or. maxval(abs(b)) > 1e3_qp) exit
         end do
         ok = maxval(abs(h)) < 1e-29_qp
         if (.not. ok) return
         if (is_first) self%b(:, i) = b
         h = equations(here, last, dt, b, tau)
         half = matrix_of([1.0_qp, b])
         last = matmul(last, matmul(half, half))
         ! R(c½)L1 = R(c½)ᵀL0 + Δtτ̄.
         l = matmul(transpose(half), matmul(transpose(half), momentum_of(here)) + dt*tau)
         here(momentum_at + 1:momentum_at + 3) = l
      end do
   end subroutine walk

   !> (∂G/∂b)⁻¹
   function inverse_slope(x, first, dt, b) result(inverse)
      real(qp), intent(in) :: x(n_parameters), first(3, 3), dt, b(3)
      real(qp) :: inverse(3, 3)
      real(qp) :: slope(3, 3), h(3), tau(3)
      integer :: i
      do i = 1, 3
         h = 0
         h(i) = 1e-15_qp
         slope(:, i) = (equations(x, first, dt, b + h, tau) - equations(x, first, dt, b - h, tau))/2e-15_qp
      end do
      do i = 1, 3
         h = 0
         h(i) = 1
         inverse(:, i) = solved(slope, h)
      end do
   end function inverse_slope

   !> G(b), from R(c½)L1 - R(c½)ᵀL0 = Δtτ̄ and L1 = 2((4/Δt)Jb + h) - L0; and τ̄.
   function equations(x, first, dt, b, tau) result(g)
      real(qp), intent(in) :: x(n_parameters), first(3, 3), dt, b(3)
      real(qp), intent(out) :: tau(3)
      real(qp) :: g(3), half(3, 3), field(3), mid(3), ends(3, 2), length(2), slack
      integer :: i
      half = matrix_of([1.0_qp, b])
      mid = matmul(transpose(half), matmul(transpose(first), x(field_at + 1:field_at + 3)))/(1 + dot_product(b, b))
      tau = cross(x(moment_at + 1:moment_at + 3), mid) - x(damping_at + 1:damping_at + 3)*(4/dt)*b
      if (abs(x(stiffness_at + 1)) > 0) then
         associate (point => x(point_at + 1:point_at + 3))
            ends(:, 1) = matmul(transpose(first), x(anchor_at + 1:anchor_at + 3))
            field = matmul(transpose(half), ends(:, 1))
            ends(:, 2) = matmul(transpose(half), field)
            do i = 1, 2
               length(i) = sqrt(sum((point - ends(:, i))**2))
            end do
            slack = 1 - 2*x(length_at + 1)/sum(length)
            tau = tau + cross(x(stiffness_at + 1)*slack*point, field)/(1 + dot_product(b, b))
         end associate
      end if
      g = matmul(half, 2*((4/dt)*matmul(inertia_of(x), b) + x(rotor_at + 1:rotor_at + 3)) - momentum_of(x)) &
          - matmul(transpose(half), momentum_of(x)) - dt*tau
   end function equations

   !> A step of a Runge-Kutta method.
   subroutine take_stages(self, x, y)
      class(tangent_oracle_t), intent(in) :: self
      real(qp), intent(in) :: x(n_parameters)
      real(qp), intent(inout) :: y(7)
      real(qp) :: k(7, size(self%weights)), z(7)
      integer :: i, j
      do i = 1, size(self%weights)
         z = y
         do j = 1, i - 1
            z = z + self%dt*real(self%a(j, i - 1), qp)*k(:, j)
         end do
         k(:, i) = rates(x, z)
      end do
      do i = 1, size(self%weights)
         y = y + self%dt*real(self%weights(i), qp)*k(:, i)
      end do
   end subroutine take_stages

   !> The flow over a time.
   subroutine follow_flow(x, dt, y)
      real(qp), intent(in) :: x(n_parameters), dt
      real(qp), intent(inout) :: y(7)
      real(qp) :: table(7, columns), before(7), now(7), next(7), saved(7), h
      integer :: parts, i, j, k, n
      parts = 1 + int(real(norm2(solved(inertia_of(x), y(5:7) - x(rotor_at + 1:rotor_at + 3)))*abs(dt), wp)/small_turn)
      do i = 1, parts
         do j = 1, columns
            n = 2*j
            h = dt/(parts*n)
            before = y
            now = y + h*rates(x, y)
            do k = 2, n
               next = before + 2*h*rates(x, now)
               before = now
               now = next
            end do
            ! Aitken and Neville, in h².
            do k = 1, j - 1
               saved = table(:, k)
               table(:, k) = now
               now = now + (now - saved)/((real(j, qp)/(j - k))**2 - 1)
            end do
            table(:, j) = now
         end do
         y = table(:, columns)
      end do
   end subroutine follow_flow

   !> q̇ = ½ q∘Ω, L̇ = L×Ω + τ, with γ of the direction of q; shape (7).
   function rates(x, y)
      real(qp), intent(in) :: x(n_parameters), y(7)
      real(qp) :: rates(7)
      real(qp) :: omega(3), tau(3), turn(3, 3), gamma(3)
      omega = solved(inertia_of(x), y(5:7) - x(rotor_at + 1:rotor_at + 3))
      turn = transpose(matrix_of(y(1:4)))
      tau = cross(x(moment_at + 1:moment_at + 3), matmul(turn, x(field_at + 1:field_at + 3))) &
            - x(damping_at + 1:damping_at + 3)*omega
      if (abs(x(stiffness_at + 1)) > 0) then
         gamma = matmul(turn, x(anchor_at + 1:anchor_at + 3))
         associate (point => x(point_at + 1:point_at + 3))
            tau = tau + x(stiffness_at + 1)*(1 - x(length_at + 1)/sqrt(sum((point - gamma)**2)))*cross(point, gamma)
         end associate
      end if
      rates(1:4) = times(y(1:4), [0.0_qp, omega])/2
      rates(5:7) = cross(y(5:7), omega) + tau
   end function rates

   pure function momentum_of(x) result(l)
      real(qp), intent(in) :: x(n_parameters)
      real(qp) :: l(3)
      l = x(momentum_at + 1:momentum_at + 3)
   end function momentum_of

   pure function inertia_of(x) result(inertia)
      real(qp), intent(in) :: x(n_parameters)
      real(qp) :: inertia(3, 3)
      integer :: i
      do i = 1, 6
         inertia(place(1, i), place(2, i)) = x(inertia_at + i)
         inertia(place(2, i), place(1, i)) = x(inertia_at + i)
      end do
   end function inertia_of

   !> The rotation of a quaternion of any length; shape (3, 3).
   pure function matrix_of(q) result(r)
      real(qp), intent(in) :: q(4)
      real(qp) :: r(3, 3)
      integer :: j
      do j = 1, 3
         r(:, j) = 2*q(1 + j)*q(2:4)
         r(j, j) = r(j, j) + 2*q(1)**2 - sum(q**2)
      end do
      r(2, 1) = r(2, 1) + 2*q(1)*q(4)
      r(3, 1) = r(3, 1) - 2*q(1)*q(3)
      r(1, 2) = r(1, 2) - 2*q(1)*q(4)
      r(3, 2) = r(3, 2) + 2*q(1)*q(2)
      r(1, 3) = r(1, 3) + 2*q(1)*q(3)
      r(2, 3) = r(2, 3) - 2*q(1)*q(2)
      r = r/sum(q**2)
   end function matrix_of

   !> p∘q
   pure function times(p, q) result(product)
      real(qp), intent(in) :: p(4), q(4)
      real(qp) :: product(4)
      product(1) = p(1)*q(1) - dot_product(p(2:4), q(2:4))
      product(2:4) = p(1)*q(2:4) + q(1)*p(2:4) + cross(p(2:4), q(2:4))
   end function times

   pure function cross(a, b) result(c)
      real(qp), intent(in) :: a(3), b(3)
      real(qp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> A⁻¹v
   pure function solved(a, v) result(x)
      real(qp), intent(in) :: a(3, 3), v(3)
      real(qp) :: x(3), rows(3, 3)
      rows(:, 1) = cross(a(:, 2), a(:, 3))
      rows(:, 2) = cross(a(:, 3), a(:, 1))
      rows(:, 3) = cross(a(:, 1), a(:, 2))
      x = matmul(transpose(rows), v)/dot_product(rows(:, 1), a(:, 1))
   end function solved

end module test_tangent_oracle
