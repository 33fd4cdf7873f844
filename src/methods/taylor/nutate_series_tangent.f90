!> The tangent of a step by power series: the variational equations of a rigid body, expanded with its motion.
!>
!>     θ̇ = θ×Ω + δΩ,   δL̇ = δL×Ω + L×δΩ + (∂τ/∂θ)θ + D(δΩ - Rᵀω×θ),   δΩ = J⁻¹(δL - Σ s δh - δh - δJΩ)
!>
!> with the torque τ, its derivative by the rate D, and the rate ω of space axes that turn. All that multiplies columns
!> is one series of matrices, the same for all of them: it is made once from the derivatives by γ that the effects know
!> (`series_derivative`), ∂τ/∂θ = (∂τ/∂γ)[γ]×. What parameters change is added column by column.
!>
!> It is the derivative of the flow, to the accuracy of the series. Its poles are of one order more than those of the
!> motion, so that columns err by ten times as much at the same order: theirs is higher.
module nutate_series_tangent
   use nutate_column, only: OF_POTENTIAL, OF_TORQUE, OF_WHEEL
   use nutate_hamiltonian, only: body_momentum
   use nutate_kinds, only: wp
   use nutate_limits, only: most_wheels
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_small_products, only: skew, times_columns, times_vector, vector_length
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_torque_series, only: torque_series_t
   use nutate_wheel_series, only: wheel_series_t
   implicit none
   private

   public :: series_tangent_t

   !> By how much the order of the columns is higher.
   integer, parameter :: more_orders = 2
   !> Columns that are computed together: those of the start, and whole vector instructions of any processor.
   integer, parameter :: lanes = 6
   !> Numbers of a column: θ, δL and u, by which ΔtδΩ is less than ΔtJ⁻¹δL; where each starts.
   integer, parameter :: of_theta = 0, of_momentum = 3, of_lack = 6, numbers = 9
   !> Factors in a coefficient: ΔtΩ, L, and the matrices of δL and of θ in δL̇; where each starts.
   integer, parameter :: by_angle = 0, by_momentum = 3, for_momentum = 6, for_theta = 15, n_factors = 24

   !> The series of one step, with the step as the unit of time.
   type :: series_tangent_t
      private
      logical :: prepared = .false.
      !> Of the series; rows of which a torque or a parameter depends.
      integer :: order = 0, n_rows = 0
      !> There are torques that depend on the attitude; the axes of space turn.
      logical :: turned = .false., frame_turns = .false.
      !> ΔtJ⁻¹, its product with D, D, N m s; shape (3,3). Δtω along the rows; shape (3).
      real(wp) :: to_angle(3, 3) = 0.0_wp, damped(3, 3) = 0.0_wp, drag(3, 3) = 0.0_wp, turn(3) = 0.0_wp
      type(torque_series_t) :: torques
      type(wheel_series_t) :: wheels
      !> L, ΔtΩ, the same relative to the space axes, and the rows E = Rᵀe of the basis of the torques; shapes
      !> (3, 0:highest_order), (3, 3, 0:highest_order).
      real(wp) :: momentum(3, 0:highest_order) = 0.0_wp, angle(3, 0:highest_order) = 0.0_wp
      real(wp) :: relative(3, 0:highest_order) = 0.0_wp, row(3, 3, 0:highest_order) = 0.0_wp
      !> The factors; shape (n_factors, 0:highest_order).
      real(wp) :: factors(n_factors, 0:highest_order) = 0.0_wp
      !> The columns, and which blocks have a u; shapes (lanes, numbers, 0:highest_order, blocks), (blocks).
      real(wp), allocatable :: columns(:, :, :, :)
      logical, allocatable :: lacking(:)
      !> Coefficient k of δh of each wheel, and its sum; shape (n, n_wheels).
      real(wp), allocatable :: wheel(:, :), gain(:, :)
   contains
      !> Forgets the effects of a system.
      procedure :: reset
      !> Moves tangent columns over a step.
      procedure :: carry
   end type series_tangent_t

contains

   !> Forgets the effects of a system, which have changed.
   pure subroutine reset(self)
      class(series_tangent_t), intent(inout) :: self
      self%prepared = .false.
   end subroutine reset

   !> Moves tangent columns over a step. Errors, with the columns as they were: `NUTATE_BAD_ARGUMENT` for an effect, or
   !> a change of its parameters, that has no series of its derivative.
   subroutine carry(self, system, before, dt, start, order, acts, driven, tangent, status)
      class(series_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before
      !> s; time for torques, in the piece of each; order of the series of the motion.
      real(wp), intent(in) :: dt, start
      integer, intent(in) :: order
      !> Which torques and motors act; shapes (number of torques), (most_wheels).
      logical, intent(in) :: acts(:), driven(most_wheels)
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      character(len=24) :: unknown
      integer :: k, b
      if (.not. self%prepared) call self%torques%prepare(system%effects, status)
      if (.not. self%prepared .and. status%ok()) call self%wheels%prepare(system%effects, status)
      if (.not. status%ok()) return
      self%prepared = .true.
      unknown = ''
      self%order = min(order + more_orders, highest_order)
      self%n_rows = self%torques%rank
      if (system%effects%frame_turns .or. size(tangent%parametric) > 0) self%n_rows = 3
      call start_motion(self, system, before, dt, start, acts, driven)
      call start_columns(self, tangent)
      do k = 0, self%order
         call add_rates(self, k, system, dt)
         if (k == self%order) exit
         call add_motion(self, k, system, dt, acts, unknown)
         if (size(tangent%parametric) + self%wheels%n > 0) call add_lacks(self, k, system, dt, tangent)
         do b = 1, size(self%lacking)
            call add_block(k, self%turned, self%lacking(b), self%factors, self%to_angle, self%drag, &
                           self%columns(:, :, :, b))
         end do
         if (self%wheels%n > 0) call add_wheels(self, k, system, dt, tangent, unknown)
         do b = 1, size(tangent%parametric)
            call add_own(self, k, system, dt, acts, tangent, b, unknown)
         end do
         if (unknown /= '') then
            status = fail(NUTATE_BAD_ARGUMENT, "method = 'taylor' has no tangent columns of "//trim(unknown)// &
                          ' (expected another method)', 'method')
            return
         end if
      end do
      call finish_columns(self, tangent)
   end subroutine carry

   !> Coefficient 0 of the motion, and the constants of the step.
   pure subroutine start_motion(self, system, before, dt, start, acts, driven)
      class(series_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before
      real(wp), intent(in) :: dt, start
      logical, intent(in) :: acts(:), driven(most_wheels)
      integer :: i
      self%to_angle = dt*system%body%inverse_inertia
      self%drag = 0.0_wp
      if (size(acts) > 0) self%drag = self%torques%total_drag(acts)
      self%damped = times_columns(self%drag, self%to_angle)
      self%frame_turns = system%effects%frame_turns
      self%turned = system%effects%n_potentials + system%effects%n_torques > 0
      self%turn = dt*matmul(system%effects%frame_rate, self%torques%basis)
      self%torques%start = start
      if (self%wheels%n > 0) then
         call self%wheels%set_start(before, driven)
         call self%wheels%start(start, dt)
      end if
      self%momentum(:, 0) = body_momentum(before)
      do i = 1, 3
         self%row(:, i, 0) = rotate_to_body(before%q, self%torques%basis(:, i))
      end do
   end subroutine start_motion

   !> Coefficient 0 of the columns.
   pure subroutine start_columns(self, tangent)
      class(series_tangent_t), intent(inout) :: self
      type(tangent_t), intent(in) :: tangent
      integer :: blocks, c, i
      blocks = (tangent%n + lanes - 1)/lanes
      if (allocated(self%columns)) then
         if (size(self%lacking) /= blocks .or. size(self%wheel, 1) /= tangent%n) &
            deallocate (self%columns, self%lacking, self%wheel, self%gain)
      end if
      if (.not. allocated(self%columns)) then
         allocate (self%columns(lanes, numbers, 0:highest_order, blocks), source=0.0_wp)
         allocate (self%lacking(blocks), self%wheel(tangent%n, self%wheels%n), self%gain(tangent%n, self%wheels%n))
      end if
      self%lacking = self%wheels%n > 0
      do i = 1, size(tangent%parametric)
         self%lacking((tangent%parametric(i) + lanes - 1)/lanes) = .true.
      end do
      do c = 1, tangent%n
         call put(self, c, of_theta, 0, tangent%theta(c, :))
         call put(self, c, of_momentum, 0, tangent%momentum(c, :))
      end do
      self%wheel = tangent%wheels
      self%gain = 0.0_wp
   end subroutine start_columns

   !> Coefficient k of the rates, and of the wheels.
   pure subroutine add_rates(self, k, system, dt)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      real(wp) :: inner(3)
      integer :: i
      inner = self%momentum(:, k)
      if (k == 0) inner = inner - system%effects%rotor_momentum
      if (self%wheels%n > 0) inner = inner - self%wheels%term(k)
      self%angle(:, k) = times_vector(self%to_angle, inner)
      if (self%wheels%n > 0) call self%wheels%add_term(system%effects, k, self%angle(:, k)/dt)
      self%relative(:, k) = self%angle(:, k)
      if (.not. self%frame_turns) return
      do i = 1, 3
         self%relative(:, k) = self%relative(:, k) - self%turn(i)*self%row(:, i, k)
      end do
   end subroutine add_rates

   !> Coefficient k of the factors, and k + 1 of L and of the rows.
   pure subroutine add_motion(self, k, system, dt, acts, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      character(len=*), intent(inout) :: unknown
      real(wp) :: tau(3), matrix(3, 3), sum(3)
      integer :: i, j
      matrix = 0.0_wp
      tau = 0.0_wp
      if (self%turned) then
         if (self%torques%has_more) call self%torques%add_terms( &
            system%effects, k, self%torques%start, dt, acts, self%relative(:, k)/dt, self%row(:, :, k), tau)
         do i = 1, self%torques%n_moments
            tau = tau + cross(self%torques%moments(:, i), self%row(:, i, k))
         end do
         call self%torques%add_derivatives(system%effects, k, dt, acts, self%row(:, :, k), matrix, unknown)
         matrix = dt*matrix
         if (self%frame_turns) &
            matrix = matrix - times_columns(self%drag, skew(self%angle(:, k) - self%relative(:, k)))
         self%factors(for_theta + 1:for_theta + 9, k) = [matrix(:, 1), matrix(:, 2), matrix(:, 3)]
      end if
      matrix = times_columns(skew(self%momentum(:, k)), self%to_angle) - skew(self%angle(:, k))
      if (k == 0) matrix = matrix + self%damped
      self%factors(for_momentum + 1:for_momentum + 9, k) = [matrix(:, 1), matrix(:, 2), matrix(:, 3)]
      self%factors(by_angle + 1:by_angle + 3, k) = self%angle(:, k)
      self%factors(by_momentum + 1:by_momentum + 3, k) = self%momentum(:, k)
      sum = dt*tau
      do j = 0, k
         associate (l => self%momentum, w => self%angle)
            sum(1) = sum(1) + (l(2, j)*w(3, k - j) - l(3, j)*w(2, k - j))
            sum(2) = sum(2) + (l(3, j)*w(1, k - j) - l(1, j)*w(3, k - j))
            sum(3) = sum(3) + (l(1, j)*w(2, k - j) - l(2, j)*w(1, k - j))
         end associate
      end do
      self%momentum(:, k + 1) = inverses(k + 1)*sum
      call add_rows(self%n_rows, k, self%relative, self%row)
   end subroutine add_motion

   !> Coefficient k + 1 of the rows, E×Ω; of those that are not needed zero.
   pure subroutine add_rows(n_rows, k, w, row)
      integer, intent(in) :: n_rows, k
      !> Δt times the rate relative to the space axes.
      real(wp), intent(in) :: w(3, 0:highest_order)
      real(wp), intent(inout) :: row(3, 3, 0:highest_order)
      real(wp) :: sum(3)
      integer :: i, j
      row(:, :, k + 1) = 0.0_wp
      do i = 1, n_rows
         sum = 0.0_wp
         do j = 0, k
            sum(1) = sum(1) + (row(2, i, j)*w(3, k - j) - row(3, i, j)*w(2, k - j))
            sum(2) = sum(2) + (row(3, i, j)*w(1, k - j) - row(1, i, j)*w(3, k - j))
            sum(3) = sum(3) + (row(1, i, j)*w(2, k - j) - row(2, i, j)*w(1, k - j))
         end do
         row(:, i, k + 1) = inverses(k + 1)*sum
      end do
   end subroutine add_rows

   !> Coefficient k of u = ΔtJ⁻¹(Σ s δh + δh + δJΩ + Σ δs h).
   pure subroutine add_lacks(self, k, system, dt, tangent)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      real(wp) :: inner(3, tangent%n), own(3)
      integer :: c, i, m
      inner = 0.0_wp
      do c = 1, tangent%n
         do i = 1, self%wheels%n
            inner(:, c) = inner(:, c) + self%wheel(c, i)*system%effects%wheels(i)%axis
         end do
      end do
      do m = 1, size(tangent%parametric)
         c = tangent%parametric(m)
         own = times_vector(tangent%inertia(:, :, m), self%angle(:, k)/dt)
         if (k == 0) own = own + tangent%columns(c)%rotor
         inner(:, c) = inner(:, c) + own
         if (.not. allocated(tangent%columns(c)%effects)) cycle
         do i = 1, size(tangent%columns(c)%effects)
            associate (item => tangent%columns(c)%effects(i))
               if (item%kind == OF_WHEEL) inner(:, c) = inner(:, c) + self%wheels%momentum_term(k, item%place)* &
                                                        system%effects%wheels(item%place)%axis_change(item%change)
            end associate
         end do
      end do
      do c = 1, tangent%n
         if (self%lacking((c + lanes - 1)/lanes)) &
            call put(self, c, of_lack, k, times_vector(self%to_angle, inner(:, c)))
      end do
   end subroutine add_lacks

   !> Three numbers of a coefficient of a column.
   pure function get(self, column, first, k) result(v)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: column, first, k
      real(wp) :: v(3)
      integer :: i
      do i = 1, 3
         v(i) = self%columns(1 + modulo(column - 1, lanes), first + i, k, (column + lanes - 1)/lanes)
      end do
   end function get

   !> Sets them.
   pure subroutine put(self, column, first, k, v)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: column, first, k
      real(wp), intent(in) :: v(3)
      integer :: i
      do i = 1, 3
         self%columns(1 + modulo(column - 1, lanes), first + i, k, (column + lanes - 1)/lanes) = v(i)
      end do
   end subroutine put

   !> Coefficient k + 1 of θ and δL of a block, without what parameters do.
   pure subroutine add_block(k, turned, lacking, f, to_angle, drag, x)
      integer, intent(in) :: k
      !> There are torques; there is a u.
      logical, intent(in) :: turned, lacking
      !> The factors; ΔtJ⁻¹ and D, shape (3,3).
      real(wp), intent(in) :: f(n_factors, 0:highest_order), to_angle(3, 3), drag(3, 3)
      real(wp), intent(inout) :: x(lanes, numbers, 0:highest_order)
      real(wp) :: s(lanes, 6)
      integer :: j
      s = 0.0_wp
      do j = 0, k
         call add_free(x(:, :, j), f(:, k - j), s)
         if (turned) call add_turned(x(:, :, j), f(:, k - j), s)
         if (lacking) call add_lacking(x(:, :, j), f(:, k - j), s)
      end do
      call add_rate(x(:, :, k), lacking, to_angle, drag, s)
      do j = 1, 6
         x(:, j, k + 1) = inverses(k + 1)*s(:, j)
      end do
   end subroutine add_block

   !> Adds ΔtδΩ, and what the torques make of u.
   pure subroutine add_rate(x, lacking, a, d, s)
      real(wp), intent(in) :: x(lanes, numbers)
      logical, intent(in) :: lacking
      !> ΔtJ⁻¹ and D; shape (3,3).
      real(wp), intent(in) :: a(3, 3), d(3, 3)
      real(wp), intent(inout) :: s(lanes, 6)
      integer :: i
      !GCC$ unroll 1
      do i = 1, lanes
         s(i, 1) = s(i, 1) + (a(1, 1)*x(i, 4) + a(1, 2)*x(i, 5) + a(1, 3)*x(i, 6))
         s(i, 2) = s(i, 2) + (a(2, 1)*x(i, 4) + a(2, 2)*x(i, 5) + a(2, 3)*x(i, 6))
         s(i, 3) = s(i, 3) + (a(3, 1)*x(i, 4) + a(3, 2)*x(i, 5) + a(3, 3)*x(i, 6))
      end do
      if (.not. lacking) return
      !GCC$ unroll 1
      do i = 1, lanes
         s(i, 1) = s(i, 1) - x(i, 7)
         s(i, 2) = s(i, 2) - x(i, 8)
         s(i, 3) = s(i, 3) - x(i, 9)
         s(i, 4) = s(i, 4) - (d(1, 1)*x(i, 7) + d(1, 2)*x(i, 8) + d(1, 3)*x(i, 9))
         s(i, 5) = s(i, 5) - (d(2, 1)*x(i, 7) + d(2, 2)*x(i, 8) + d(2, 3)*x(i, 9))
         s(i, 6) = s(i, 6) - (d(3, 1)*x(i, 7) + d(3, 2)*x(i, 8) + d(3, 3)*x(i, 9))
      end do
   end subroutine add_rate

   !> Adds θ×Ω, and the matrix of δL times it. A loop over lanes that the compiler unrolls early is not vectorised.
   pure subroutine add_free(x, f, s)
      real(wp), intent(in) :: x(lanes, numbers), f(n_factors)
      real(wp), intent(inout) :: s(lanes, 6)
      integer :: i
      !GCC$ unroll 1
      do i = 1, lanes
         s(i, 1) = s(i, 1) + (x(i, 2)*f(3) - x(i, 3)*f(2))
         s(i, 2) = s(i, 2) + (x(i, 3)*f(1) - x(i, 1)*f(3))
         s(i, 3) = s(i, 3) + (x(i, 1)*f(2) - x(i, 2)*f(1))
         s(i, 4) = s(i, 4) + (x(i, 4)*f(7) + x(i, 5)*f(10) + x(i, 6)*f(13))
         s(i, 5) = s(i, 5) + (x(i, 4)*f(8) + x(i, 5)*f(11) + x(i, 6)*f(14))
         s(i, 6) = s(i, 6) + (x(i, 4)*f(9) + x(i, 5)*f(12) + x(i, 6)*f(15))
      end do
   end subroutine add_free

   !> Adds the matrix of θ times it.
   pure subroutine add_turned(x, f, s)
      real(wp), intent(in) :: x(lanes, numbers), f(n_factors)
      real(wp), intent(inout) :: s(lanes, 6)
      integer :: i
      !GCC$ unroll 1
      do i = 1, lanes
         s(i, 4) = s(i, 4) + (x(i, 1)*f(16) + x(i, 2)*f(19) + x(i, 3)*f(22))
         s(i, 5) = s(i, 5) + (x(i, 1)*f(17) + x(i, 2)*f(20) + x(i, 3)*f(23))
         s(i, 6) = s(i, 6) + (x(i, 1)*f(18) + x(i, 2)*f(21) + x(i, 3)*f(24))
      end do
   end subroutine add_turned

   !> Adds u×L.
   pure subroutine add_lacking(x, f, s)
      real(wp), intent(in) :: x(lanes, numbers), f(n_factors)
      real(wp), intent(inout) :: s(lanes, 6)
      integer :: i
      !GCC$ unroll 1
      do i = 1, lanes
         s(i, 4) = s(i, 4) + (x(i, 8)*f(6) - x(i, 9)*f(5))
         s(i, 5) = s(i, 5) + (x(i, 9)*f(4) - x(i, 7)*f(6))
         s(i, 6) = s(i, 6) + (x(i, 7)*f(5) - x(i, 8)*f(4))
      end do
   end subroutine add_lacking

   !> Coefficient k + 1 of δh, ḣ = u - cω: of all columns, and of those of parameters what these change.
   pure subroutine add_wheels(self, k, system, dt, tangent, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      character(len=*), intent(inout) :: unknown
      real(wp) :: rate(3), drive, speed
      integer :: c, i, m
      logical :: known
      do c = 1, tangent%n
         rate = (times_vector(self%to_angle, get(self, c, of_momentum, k)) - get(self, c, of_lack, k))/dt
         do i = 1, self%wheels%n
            associate (wheel => system%effects%wheels(i))
               speed = wheel%speed_of(self%wheel(c, i), rate)
               drive = 0.0_wp
               if (allocated(tangent%columns(c)%effects)) then
                  do m = 1, size(tangent%columns(c)%effects)
                     associate (item => tangent%columns(c)%effects(m))
                        if (item%kind /= OF_WHEEL .or. item%place /= i) cycle
                        call self%wheels%drive_change(system%effects, i, item%change, k, drive, known)
                        if (.not. known) unknown = wheel%name
                        drive = drive - item%change(6)*self%wheels%speed_term(k, i)
                        speed = speed - self%wheels%momentum_term(k, i)*item%change(4)/wheel%inertia**2 &
                                - dot_product(wheel%axis_change(item%change), self%angle(:, k)/dt)
                     end associate
                  end do
               end if
               self%wheel(c, i) = (dt*inverses(k + 1))*(drive - wheel%friction*speed)
            end associate
            self%gain(c, i) = self%gain(c, i) + self%wheel(c, i)
         end do
      end do
   end subroutine add_wheels

   !> Adds what parameters of torques and the rate of the axes do to coefficient k + 1 of θ and δL.
   pure subroutine add_own(self, k, system, dt, acts, tangent, m, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      type(tangent_t), intent(in) :: tangent
      !> Which of the parametric columns.
      integer, intent(in) :: m
      character(len=*), intent(inout) :: unknown
      real(wp) :: tau(3), one(3), turning(3)
      integer :: c, e, p
      logical :: known
      c = tangent%parametric(m)
      tau = 0.0_wp
      turning = 0.0_wp
      associate (column => tangent%columns(c))
         if (self%frame_turns) turning = times_vector(self%row(:, :, k), matmul(column%frame, self%torques%basis))
         if (allocated(column%effects)) then
            do e = 1, size(column%effects)
               associate (item => column%effects(e))
                  if (item%kind == OF_TORQUE) then
                     if (.not. acts(item%place)) cycle
                     call self%torques%torque_change(system%effects, item%place, item%change, k, dt, &
                                                     self%row(:, :, 0:k), one, known)
                     tau = tau + one
                     if (.not. known) unknown = system%effects%torques(item%place)%item%name
                  else if (item%kind == OF_POTENTIAL) then
                     do p = 1, system%effects%n_potentials
                        if (system%effects%potentials(p)%place /= item%place) cycle
                        call self%torques%potential_change(system%effects, p, item%change, k, dt, &
                                                           self%row(:, :, 0:k), one, known)
                        tau = tau + one
                        if (.not. known) unknown = system%effects%potentials(p)%item%name
                     end do
                  end if
               end associate
            end do
         end if
      end associate
      tau = tau - times_vector(self%drag, turning)
      call put(self, c, of_theta, k + 1, get(self, c, of_theta, k + 1) - (dt*inverses(k + 1))*turning)
      call put(self, c, of_momentum, k + 1, get(self, c, of_momentum, k + 1) + (dt*inverses(k + 1))*tau)
   end subroutine add_own

   !> Sums the series, the smallest terms first. The last ones estimate the error.
   pure subroutine finish_columns(self, tangent)
      class(series_tangent_t), intent(in) :: self
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: theta(3), momentum(3), last(tangent%n, 3, 2)
      integer :: c, k
      do c = 1, tangent%n
         theta = get(self, c, of_theta, self%order)
         momentum = get(self, c, of_momentum, self%order)
         last(c, :, 1) = theta
         last(c, :, 2) = momentum
         do k = self%order - 1, 0, -1
            theta = theta + get(self, c, of_theta, k)
            momentum = momentum + get(self, c, of_momentum, k)
         end do
         tangent%theta(c, :) = theta
         tangent%momentum(c, :) = momentum
      end do
      tangent%wheels = tangent%wheels + self%gain
      tangent%error = tangent%relative(last(:, :, 1), last(:, :, 2), vector_length(self%momentum(:, 0)))
   end subroutine finish_columns

end module nutate_series_tangent
