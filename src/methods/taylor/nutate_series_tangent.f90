!> The tangent of a step by power series: the variational equations of a rigid body, expanded with its motion.
!>
!>     θ̇ = θ×Ω + δΩ,   δL̇ = δL×Ω + L×δΩ + (∂τ/∂θ)θ + D(δΩ - Rᵀω×θ),   δΩ = J⁻¹(δL - Σ s δh - δh - δJΩ)
!>
!> with the torque τ, its derivative by the rate D, and the rate ω of rotating space axes. The factors of the
!> sensitivities are one series of matrices, the same for all of them: it is computed once from the derivatives by γ
!> that the effects supply (`series_derivative`), ∂τ/∂θ = (∂τ/∂γ)[γ]×. The contributions of parameters are added
!> sensitivity by sensitivity.
!>
!> If the inertia varies, J⁻¹ is that of the start of the step, the terms J₁δΩ, J₂δΩ, ... of its series are part of u,
!> and mass that leaves adds the torque (dJ/dt)δΩ.
!>
!> Sensitivities to the initial state without wheels are linear in θ and δL of the start, so that only a basis of these
!> is expanded: six sensitivities, and three of δL for a free body, whose θ1 is that of the start, rotated, and what δL
!> adds.
!>
!> The result is the derivative of the flow, to the accuracy of the series. The poles of sensitivities are of one order
!> more than those of the motion, so that their error is ten times as large at the same order: their order is therefore
!> higher.
module nutate_series_tangent
   use nutate_variation, only: OF_POTENTIAL, OF_TORQUE, OF_WHEEL
   use nutate_sensitivity_series, only: add_lacking, add_rest, add_row, add_rotated, by_angle, by_momentum, &
      for_momentum, for_theta, lanes, n_factors, numbers, of_lack, of_momentum, of_theta, set_matrix, set_vector, &
      sum_block, sum_free
   use nutate_effect, only: torque_t
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: body_momentum
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body
   use nutate_small_products, only: skew, times_columns, times_vector, vector_length
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: inverse_inertia_at, system_t
   use nutate_tangent, only: tangent_t
   use nutate_torque_changes, only: torque_changes_t
   use nutate_wheel_series, only: wheel_series_t
   use nutate_wheel, only: friction_change, axis_change
   implicit none
   private

   public :: series_tangent_t

   !> Order of the sensitivities minus that of the motion.
   integer, parameter :: more_orders = 2

   !> The series of one step, with the step as the unit of time.
   type :: series_tangent_t
      private
      logical :: prepared = .false.
      !> Order of the series; number of rows on which a torque or a parameter depends.
      integer :: order = 0, n_rows = 0
      !> True if torques depend on the attitude; if these are only the moment of one row; if the space axes rotate; if
      !> the matrices of δL have no diagonal.
      logical :: rotated = .false., of_row = .false., frame_turns = .false., hollow = .false.
      !> Number of sensitivities in the basis of the start; 0 if each sensitivity is expanded.
      integer :: n_basis = 0
      !> ΔtJ⁻¹, its product with D, D, N m s; shape (3,3). Δtω along the rows; shape (3).
      real(wp) :: to_angle(3, 3) = 0.0_wp, damped(3, 3) = 0.0_wp, drag(3, 3) = 0.0_wp, turn(3) = 0.0_wp
      type(torque_changes_t) :: torques
      type(wheel_series_t) :: wheels
      !> The inertia varies; start of the step, s; jJⱼ of the mass that leaves, kg m²; shape (3,3,degree).
      logical :: varies = .false.
      real(wp) :: t = 0.0_wp, loss(3, 3, 3) = 0.0_wp
      !> L, ΔtΩ, the same relative to the space axes, and the rows E = Rᵀe of the basis of the torques; shapes
      !> (3, 0:highest_order), (3, 3, 0:highest_order).
      real(wp) :: momentum(3, 0:highest_order) = 0.0_wp, angle(3, 0:highest_order) = 0.0_wp
      real(wp) :: relative(3, 0:highest_order) = 0.0_wp, row(3, 3, 0:highest_order) = 0.0_wp
      !> The factors, the same in each lane; shape (lanes, n_factors, 0:highest_order).
      real(wp) :: factors(lanes, n_factors, 0:highest_order) = 0.0_wp
      !> The sensitivities that are expanded, shape (lanes, numbers, 0:highest_order, blocks); true for blocks that have
      !> a u, shape (blocks).
      real(wp), allocatable :: sensitivities(:, :, :, :)
      logical, allocatable :: lacking(:)
      !> Sums of the sensitivities that are expanded, and their last terms; shape (12, lanes*blocks).
      real(wp), allocatable :: ends(:, :)
      !> Coefficient k of δh of each wheel, and its sum; shape (n, n_wheels).
      real(wp), allocatable :: wheel(:, :), gain(:, :)
      !> Coefficients of δh and δΩ, as h×Ω of inner spheres needs them; shapes (n, n_wheels, 0:highest_order), (n, 3,
      !> 0:highest_order). Not allocated without inner spheres.
      real(wp), allocatable :: inner(:, :, :), rate(:, :, :)
   contains
      !> Moves sensitivities over a step.
      procedure :: propagate
   end type series_tangent_t

contains

   !> Moves sensitivities over a step. Errors, with the sensitivities as they were: `NUTATE_BAD_ARGUMENT` for an
   !> effect, or a change of its parameters, that has no series of its derivative.
   subroutine propagate(self, system, before, after, dt, start, moment, order, acts, driven, tangent, status)
      class(series_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> States at the start and at the end of the step.
      type(state_t), intent(in) :: before, after
      !> s; time for torques, in the piece of each; time in the piece of the inertia; order of the series of the motion.
      real(wp), intent(in) :: dt, start, moment
      integer, intent(in) :: order
      !> True for torques and motors that act; shapes (number of torques), (most_inner).
      logical, intent(in) :: acts(:), driven(most_inner)
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      character(len=24) :: unknown
      integer :: k, b, place
      if (.not. self%prepared) call self%torques%prepare(system%effects, status)
      if (.not. self%prepared .and. status%ok()) call self%wheels%prepare(system%effects, status)
      if (.not. status%ok()) return
      self%prepared = .true.
      unknown = ''
      self%order = min(order + more_orders, highest_order)
      self%n_rows = self%torques%rank
      if (system%effects%frame_turns .or. size(tangent%parametric) > 0) self%n_rows = 3
      call start_motion(self, system, before, dt, start, acts, driven)
      self%torques%moment = moment
      if (self%varies) call start_inertia(self, system%effects, dt, acts)
      call start_sensitivities(self, system%effects, tangent)
      call self%torques%expect_changes(system%effects, changes_in(tangent), size(tangent%parametric))
      do k = 0, self%order
         call add_rates(self, k, system, dt)
         if (k == self%order) exit
         call add_motion(self, k, system, dt, acts, unknown)
         if (size(tangent%parametric) + self%wheels%n > 0 .or. self%varies) call add_lacks(self, k, system, dt, tangent)
         do b = 1, size(self%lacking)
            call add_block(self, k, dt, self%lacking(b), self%sensitivities(:, :, :, b))
         end do
         if (self%wheels%n > 0) call add_wheels(self, k, system, dt, tangent, unknown)
         if (self%varies) call add_loss(self, k, dt)
         place = 0
         do b = 1, size(tangent%parametric)
            call add_own(self, k, system, dt, acts, tangent, b, place, unknown)
         end do
      end do
      if (unknown /= '') then
         status = fail(NUTATE_BAD_ARGUMENT, "method = 'taylor' has no sensitivities of "//trim(unknown)// &
                       ' (expected another method)', 'method')
         return
      end if
      call finish_sensitivities(self, quat_product(quat_conjugate(before%q), after%q), tangent)
   end subroutine propagate

   !> Sets coefficient 0 of the motion, and the constants of the step.
   pure subroutine start_motion(self, system, before, dt, start, acts, driven)
      class(series_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before
      real(wp), intent(in) :: dt, start
      logical, intent(in) :: acts(:), driven(most_inner)
      integer :: i
      self%varies = system%effects%varies
      self%t = before%t
      self%to_angle = dt*inverse_inertia_at(system, before%t)
      self%drag = 0.0_wp
      if (size(acts) > 0) self%drag = self%torques%total_drag(acts)
      self%damped = times_columns(self%drag, self%to_angle)
      self%frame_turns = system%effects%frame_turns
      self%rotated = system%effects%n_potentials + system%effects%n_torques > 0
      self%of_row = self%torques%n_moments == 1 .and. .not. self%torques%has_more
      associate (a => self%to_angle)
         self%hollow = abs(a(1, 2)) + abs(a(1, 3)) + abs(a(2, 3)) + maxval(abs(self%damped)) <= 0.0_wp
      end associate
      self%turn = dt*matmul(system%effects%frame_rate, self%torques%basis)
      self%torques%start = start
      self%torques%order = self%order
      if (self%wheels%n > 0) then
         call self%wheels%set_start(before, driven)
         call self%wheels%start(system%effects, start, dt, self%order)
      end if
      self%momentum(:, 0) = body_momentum(before)
      do i = 1, 3
         self%row(:, i, 0) = rotate_to_body(before%q, self%torques%basis(:, i))
      end do
   end subroutine start_motion

   !> Sets the coefficients of the inertia, and those of the mass that leaves.
   pure subroutine start_inertia(self, effects, dt, acts)
      class(series_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      integer :: i, j
      call self%torques%expand_inertia(effects, dt)
      self%loss = 0.0_wp
      do i = 1, size(acts)
         associate (item => effects%torques(i)%item)
            if (.not. (acts(i) .and. item%changes_inertia) .or. item%is_internal) cycle
            do j = 1, 3
               self%loss(:, :, j) = self%loss(:, :, j) &
                                    + j*item%inertia_term(j, self%torques%start, self%torques%start, dt)
            end do
         end associate
      end do
   end subroutine start_inertia

   !> Sets coefficient 0 of the sensitivities.
   pure subroutine start_sensitivities(self, effects, tangent)
      class(series_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(tangent_t), intent(in) :: tangent
      integer :: blocks, c, i, m
      m = size(tangent%parametric)
      self%n_basis = 6
      if (.not. (self%rotated .or. self%frame_turns)) self%n_basis = 3
      if (self%wheels%n > 0 .or. tangent%n - m <= self%n_basis) self%n_basis = 0
      blocks = (merge(self%n_basis + m, tangent%n, self%n_basis > 0) + lanes - 1)/lanes
      if (allocated(self%sensitivities)) then
         if (size(self%lacking) /= blocks .or. size(self%wheel, 1) /= tangent%n) &
            deallocate (self%sensitivities, self%lacking, self%ends, self%wheel, self%gain)
      end if
      if (.not. allocated(self%sensitivities)) then
         allocate (self%sensitivities(lanes, numbers, 0:highest_order, blocks), source=0.0_wp)
         allocate (self%lacking(blocks), self%ends(12, lanes*blocks), self%wheel(tangent%n, self%wheels%n), &
                   self%gain(tangent%n, self%wheels%n))
      end if
      self%lacking = self%wheels%n > 0 .or. self%varies
      do i = 1, m
         self%lacking((place_of(self, tangent, i) + lanes - 1)/lanes) = .true.
      end do
      if (self%n_basis > 0) then
         self%sensitivities(:, :of_lack, 0, :) = 0.0_wp
         do i = 1, self%n_basis
            self%sensitivities(1 + modulo(i - 1, lanes), of_lack - self%n_basis + i, 0, (i + lanes - 1)/lanes) = 1.0_wp
         end do
      else
         do c = 1, tangent%n
            call put(self, c, of_theta, 0, tangent%theta(c, :))
            call put(self, c, of_momentum, 0, tangent%momentum(c, :))
         end do
      end if
      self%wheel = tangent%wheels
      self%gain = 0.0_wp
      if (effects%n_spheres == 0) return
      if (allocated(self%inner)) deallocate (self%inner, self%rate)
      allocate (self%inner(tangent%n, self%wheels%n, 0:highest_order), self%rate(tangent%n, 3, 0:highest_order))
   end subroutine start_sensitivities

   !> Returns the number of changes of effects in all sensitivities.
   pure integer function changes_in(tangent) result(n)
      type(tangent_t), intent(in) :: tangent
      integer :: m
      n = 0
      do m = 1, size(tangent%parametric)
         associate (variation => tangent%variations(tangent%parametric(m)))
            if (allocated(variation%effects)) n = n + size(variation%effects)
         end associate
      end do
   end function changes_in

   !> Returns the index of a parametric sensitivity among those that are expanded. If there is a basis it begins as zero
   !> there.
   pure integer function place_of(self, tangent, m)
      class(series_tangent_t), intent(in) :: self
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: m
      place_of = tangent%parametric(m)
      if (self%n_basis > 0) place_of = self%n_basis + m
   end function place_of

   !> Adds coefficient k of the rates, and of the wheels.
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
      if (self%varies) inner = inner - self%torques%older_momentum(k, dt, self%angle)
      self%angle(:, k) = times_vector(self%to_angle, inner)
      if (self%wheels%n > 0) call self%wheels%add_term(system%effects, k, self%angle(:, k)/dt)
      self%relative(:, k) = self%angle(:, k)
      if (.not. self%frame_turns) return
      do i = 1, 3
         self%relative(:, k) = self%relative(:, k) - self%turn(i)*self%row(:, i, k)
      end do
   end subroutine add_rates

   !> Adds coefficient k of the factors, and k + 1 of L and of the rows.
   pure subroutine add_motion(self, k, system, dt, acts, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      character(len=*), intent(inout) :: unknown
      real(wp) :: tau(3), s1, s2, s3
      integer :: i, j
      tau = 0.0_wp
      if (self%rotated) then
         if (self%torques%has_more) then
            if (k == 0) call self%torques%begin(system%effects, dt, acts)
            call self%torques%move_directions(k, self%row(:, :, k))
            call self%torques%add_terms( &
               system%effects, k, self%torques%start, dt, acts, self%relative(:, k)/dt, self%row(:, :, k), tau)
         end if
         do i = 1, self%torques%n_moments
            tau = tau + cross(self%torques%moments(:, i), self%row(:, i, k))
         end do
         if (self%of_row) then
            call set_vector(self%factors(:, :, k), for_theta, self%row(:, 1, k))
         else
            call set_turn_matrix(self, k, system, dt, acts, unknown)
         end if
      end if
      call set_vector(self%factors(:, :, k), by_angle, self%angle(:, k))
      call set_vector(self%factors(:, :, k), by_momentum, self%momentum(:, k))
      call set_momentum_matrix(self, k, self%factors(:, :, k))
      s1 = dt*tau(1)
      s2 = dt*tau(2)
      s3 = dt*tau(3)
      associate (l => self%momentum, w => self%angle)
         do j = 0, k
            s1 = s1 + (l(2, j)*w(3, k - j) - l(3, j)*w(2, k - j))
            s2 = s2 + (l(3, j)*w(1, k - j) - l(1, j)*w(3, k - j))
            s3 = s3 + (l(1, j)*w(2, k - j) - l(2, j)*w(1, k - j))
         end do
      end associate
      self%momentum(:, k + 1) = inverses(k + 1)*[s1, s2, s3]
      call add_rows(self%n_rows, k, self%relative, self%row)
   end subroutine add_motion

   !> Sets the matrix of θ, Δt∂τ/∂θ, with the contribution of rotating axes.
   pure subroutine set_turn_matrix(self, k, system, dt, acts, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      character(len=*), intent(inout) :: unknown
      real(wp) :: matrix(3, 3)
      matrix = 0.0_wp
      call self%torques%add_derivatives(system%effects, k, dt, acts, self%row(:, :, k), matrix, unknown)
      matrix = dt*matrix
      if (self%frame_turns) &
         matrix = matrix - times_columns(self%drag, skew(self%angle(:, k) - self%relative(:, k)))
      call set_matrix(self%factors(:, :, k), for_theta, matrix)
   end subroutine set_turn_matrix

   !> Sets the matrix of δL, [L]×ΔtJ⁻¹ - [ΔtΩ]×, with the contribution of torques.
   pure subroutine set_momentum_matrix(self, k, f)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(inout) :: f(lanes, n_factors)
      real(wp) :: matrix(3, 3), l(3), w(3)
      l = self%momentum(:, k)
      w = self%angle(:, k)
      if (self%hollow) then
         associate (a => self%to_angle)
            f(:, 8) = l(3)*a(1, 1) - w(3)
            f(:, 9) = w(2) - l(2)*a(1, 1)
            f(:, 10) = w(3) - l(3)*a(2, 2)
            f(:, 12) = l(1)*a(2, 2) - w(1)
            f(:, 13) = l(2)*a(3, 3) - w(2)
            f(:, 14) = w(1) - l(1)*a(3, 3)
         end associate
      else
         matrix = times_columns(skew(l), self%to_angle) - skew(w)
         if (k == 0) matrix = matrix + self%damped
         call set_matrix(f, for_momentum, matrix)
      end if
   end subroutine set_momentum_matrix

   !> Adds coefficient k + 1 of the rows, E×Ω; zero for those that are not needed.
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

   !> Adds coefficient k of u = ΔtJ⁻¹(Σ s δh + δh + δJΩ + Σ δs h), with J₁δΩ, ... of an inertia that varies.
   pure subroutine add_lacks(self, k, system, dt, tangent)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      real(wp) :: inner(3, lanes*size(self%lacking)), own(3)
      integer :: c, i, m, place
      inner = 0.0_wp
      do c = 1, size(self%wheel, 1)
         do i = 1, self%wheels%n
            inner(:, c) = inner(:, c) + self%wheel(c, i)*system%effects%wheels(i)%axis
         end do
      end do
      do m = 1, size(tangent%parametric)
         c = tangent%parametric(m)
         own = times_vector(tangent%inertia_of(system%effects, m, self%t), self%angle(:, k)/dt)
         if (k == 0) own = own + tangent%variations(c)%rotor
         place = place_of(self, tangent, m)
         inner(:, place) = inner(:, place) + own
         if (.not. allocated(tangent%variations(c)%effects)) cycle
         do i = 1, size(tangent%variations(c)%effects)
            associate (item => tangent%variations(c)%effects(i))
               if (item%kind == OF_WHEEL) &
                  inner(:, place) = inner(:, place) + self%wheels%momentum_term(k, item%place)* &
                                    axis_change(system%effects%wheels(item%place), item%change)
               if (item%kind == OF_TORQUE) inner(:, place) = inner(:, place) + changed_momentum( &
                  self, system%effects%torques(item%place)%item, item%change, k, self%torques%moment, dt, .false.)
            end associate
         end do
      end do
      do place = 1, size(inner, 2)
         if (self%varies) then
            do i = 1, min(3, k)
               inner(:, place) = inner(:, place) &
                                 + times_vector(self%torques%inertia(:, :, i), rate_of(self, place, k - i, dt))
            end do
         end if
         if (self%lacking((place + lanes - 1)/lanes)) &
            call put(self, place, of_lack, k, times_vector(self%to_angle, inner(:, place)))
      end do
   end subroutine add_lacks

   !> Returns Σ wⱼ δJⱼ Ωₖ₋ⱼ over j > 0, N m s; shape (3): wⱼ = 1 for δJΩ, wⱼ = j for the change of Δt(dJ/dt)Ω.
   pure function changed_momentum(self, torque, change, k, moment, dt, by_time) result(momentum)
      class(series_tangent_t), intent(in) :: self
      class(torque_t), intent(in) :: torque
      real(wp), intent(in) :: change(:), moment, dt
      integer, intent(in) :: k
      logical, intent(in) :: by_time
      real(wp) :: momentum(3)
      integer :: j
      momentum = 0.0_wp
      do j = 1, min(3, k)
         momentum = momentum + times_vector(torque%inertia_derivative(change, j, self%torques%start, moment, dt), &
                                            (merge(j, 1, by_time)/dt)*self%angle(:, k - j))
      end do
   end function changed_momentum

   !> Returns coefficient k of δΩ of an expanded sensitivity, rad/s; shape (3).
   pure function rate_of(self, place, k, dt) result(rate)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: place, k
      real(wp), intent(in) :: dt
      real(wp) :: rate(3)
      rate = (times_vector(self%to_angle, get(self, place, of_momentum, k)) - get(self, place, of_lack, k))/dt
   end function rate_of

   !> Adds (dJ/dt)δΩ of the mass that leaves to coefficient k + 1 of δL.
   pure subroutine add_loss(self, k, dt)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: dt
      real(wp) :: sum(3)
      integer :: place, j
      if (.not. any(abs(self%loss) > 0.0_wp)) return
      do place = 1, lanes*size(self%lacking)
         sum = 0.0_wp
         do j = 1, min(3, k + 1)
            sum = sum + times_vector(self%loss(:, :, j), rate_of(self, place, k + 1 - j, dt))
         end do
         call put(self, place, of_momentum, k + 1, get(self, place, of_momentum, k + 1) + inverses(k + 1)*sum)
      end do
   end subroutine add_loss

   !> Returns three components of a coefficient of a sensitivity; shape (3).
   pure function get(self, variation, first, k) result(v)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: variation, first, k
      real(wp) :: v(3)
      integer :: i
      do i = 1, 3
         v(i) = self%sensitivities(1 + modulo(variation - 1, lanes), first + i, k, (variation + lanes - 1)/lanes)
      end do
   end function get

   !> Sets three components of a coefficient of a sensitivity.
   pure subroutine put(self, variation, first, k, v)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: variation, first, k
      real(wp), intent(in) :: v(3)
      integer :: i
      do i = 1, 3
         self%sensitivities(1 + modulo(variation - 1, lanes), first + i, k, (variation + lanes - 1)/lanes) = v(i)
      end do
   end subroutine put

   !> Adds coefficient k + 1 of θ and δL of a block, without the effect of parameters.
   pure subroutine add_block(self, k, dt, lacking, x)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: k
      !> s.
      real(wp), intent(in) :: dt
      !> True if the block has a u.
      logical, intent(in) :: lacking
      real(wp), intent(inout) :: x(lanes, numbers, 0:highest_order)
      real(wp) :: s(lanes, 6)
      integer :: j
      call sum_free(k, self%factors, x, s)
      if (.not. self%hollow) call add_rest(k, self%factors, self%to_angle, x, s)
      if (self%rotated .and. self%of_row) then
         call add_row(k, self%factors, dt*self%torques%moments(:, 1), x, s)
      else if (self%rotated) then
         call add_rotated(k, self%factors, x, s)
      end if
      do j = 1, 3
         s(:, j) = s(:, j) + self%to_angle(j, j)*x(:, 3 + j, k)
      end do
      if (lacking) call add_lacking(k, self%factors, self%drag, x, s)
      do j = 1, 6
         x(:, j, k + 1) = inverses(k + 1)*s(:, j)
      end do
   end subroutine add_block

   !> Adds coefficient k + 1 of δh, ḣ = u - cω, of all sensitivities, with the effect of parameters.
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
         rate = rate_of(self, c, k, dt)
         if (allocated(self%inner)) then
            self%inner(c, :, k) = self%wheel(c, :)
            self%rate(c, :, k) = rate
         end if
         do i = 1, self%wheels%n
            associate (wheel => system%effects%wheels(i))
               speed = wheel%speed_of(self%wheel(c, i), rate)
               drive = 0.0_wp
               if (allocated(tangent%variations(c)%effects)) then
                  do m = 1, size(tangent%variations(c)%effects)
                     associate (item => tangent%variations(c)%effects(m))
                        if (item%kind /= OF_WHEEL .or. item%place /= i) cycle
                        call self%wheels%drive_change(system%effects, i, item%change, k, drive, known)
                        if (.not. known) unknown = wheel%name
                        drive = drive - friction_change(wheel, item%change)*self%wheels%speed_term(k, i)
                        speed = speed - self%wheels%momentum_term(k, i)*item%change(4)/wheel%inertia**2 &
                                - dot_product(axis_change(wheel, item%change), self%angle(:, k)/dt)
                     end associate
                  end do
               end if
               self%wheel(c, i) = (dt*inverses(k + 1))*(drive - wheel%friction*speed)
            end associate
         end do
         if (allocated(self%inner)) call add_gyration(self, k, system%effects, dt, c)
         self%gain(c, :) = self%gain(c, :) + self%wheel(c, :)
      end do
   end subroutine add_wheels

   !> Adds δh×Ω + h×δΩ of inner spheres to coefficient k + 1 of δh of a sensitivity.
   pure subroutine add_gyration(self, k, effects, dt, c)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: dt
      !> Index of the sensitivity.
      integer, intent(in) :: c
      real(wp) :: sum(3)
      integer :: i, j, m
      do i = effects%n_reaction_wheels + 1, effects%n_wheels, 3
         sum = 0.0_wp
         do j = 0, k
            sum = sum + cross(self%inner(c, i:i + 2, j), self%angle(:, k - j)/dt) &
                  + cross([(self%wheels%momentum_term(j, m), m=i, i + 2)], self%rate(c, :, k - j))
         end do
         self%wheel(c, i:i + 2) = self%wheel(c, i:i + 2) + (dt*inverses(k + 1))*sum
      end do
   end subroutine add_gyration

   !> Adds the effect of parameters of torques, and of the rate of the axes, to coefficient k + 1 of θ and δL.
   pure subroutine add_own(self, k, system, dt, acts, tangent, m, place, unknown)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      logical, intent(in) :: acts(:)
      type(tangent_t), intent(in) :: tangent
      !> Index among the parametric sensitivities.
      integer, intent(in) :: m
      !> Number of changes of effects of the sensitivities before this one on entry, including it on exit.
      integer, intent(inout) :: place
      character(len=*), intent(inout) :: unknown
      real(wp) :: tau(3), one(3), rotating(3)
      integer :: c, e, p
      logical :: known
      c = tangent%parametric(m)
      tau = 0.0_wp
      rotating = 0.0_wp
      associate (variation => tangent%variations(c))
         if (self%frame_turns) rotating = times_vector(self%row(:, :, k), matmul(variation%frame, self%torques%basis))
         if (allocated(variation%effects)) then
            do e = 1, size(variation%effects)
               place = place + 1
               associate (item => variation%effects(e))
                  if (item%kind == OF_TORQUE) then
                     if (.not. acts(item%place)) cycle
                     associate (torque => system%effects%torques(item%place)%item)
                        if (torque%changes_inertia .and. .not. torque%is_internal) &
                           tau = tau + changed_momentum(self, torque, item%change, k + 1, self%torques%start, dt, &
                                                        .true.)/dt
                        if (torque%changes_inertia) cycle
                     end associate
                     call self%torques%torque_change(system%effects, item%place, item%change, place, k, self%order, &
                                                     dt, self%row(:, :, 0:k), one, known)
                     tau = tau + one
                     if (.not. known) unknown = system%effects%torques(item%place)%item%name
                  else if (item%kind == OF_POTENTIAL) then
                     do p = 1, system%effects%n_potentials
                        if (system%effects%potentials(p)%place /= item%place) cycle
                        call self%torques%potential_change(system%effects, p, item%change, place, k, self%order, &
                                                           dt, self%row(:, :, 0:k), one, known)
                        tau = tau + one
                        if (.not. known) unknown = system%effects%potentials(p)%item%name
                     end do
                  end if
               end associate
            end do
         end if
      end associate
      if (system%effects%reshapes) call self%torques%add_reshaped( &
         system%effects, tangent%variations(c), tangent%inertia_of(system%effects, m, self%t), m, k, dt, tau)
      tau = tau - times_vector(self%drag, rotating)
      c = place_of(self, tangent, m)
      call put(self, c, of_theta, k + 1, get(self, c, of_theta, k + 1) - (dt*inverses(k + 1))*rotating)
      call put(self, c, of_momentum, k + 1, get(self, c, of_momentum, k + 1) + (dt*inverses(k + 1))*tau)
   end subroutine add_own

   !> Sums the series, and computes the sensitivities from the basis. The last terms estimate the error.
   pure subroutine finish_sensitivities(self, turn, tangent)
      class(series_tangent_t), intent(inout) :: self
      !> Rotation of the body since the start, in its axes at the start; unit quaternion, shape (4).
      real(wp), intent(in) :: turn(4)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: rotated(3, 3), x(6), y(12)
      integer :: b, c, i
      do b = 1, size(self%lacking)
         call sum_block(self%order, self%sensitivities(:, :, :, b), self%ends(:, lanes*(b - 1) + 1:lanes*b))
      end do
      do i = 1, 3
         x(:3) = 0.0_wp
         x(i) = 1.0_wp
         rotated(:, i) = rotate_to_body(turn, x(:3))
      end do
      do c = 1, tangent%n
         x = [tangent%theta(c, 1), tangent%theta(c, 2), tangent%theta(c, 3), &
              tangent%momentum(c, 1), tangent%momentum(c, 2), tangent%momentum(c, 3)]
         y = 0.0_wp
         if (self%n_basis == 0) y = self%ends(:, c)
         do i = 1, self%n_basis
            y = y + x(6 - self%n_basis + i)*self%ends(:, i)
         end do
         if (self%n_basis == 3) y(:3) = y(:3) + times_vector(rotated, x(:3))
         call set_sensitivity(y, c, tangent)
      end do
      if (self%n_basis > 0) then
         do i = 1, size(tangent%parametric)
            call add_column(self%ends(:, self%n_basis + i), tangent%parametric(i), tangent)
         end do
      end if
      tangent%wheels = tangent%wheels + self%gain
      tangent%error = tangent%relative(tangent%mid, tangent%change, vector_length(self%momentum(:, 0)))
   end subroutine finish_sensitivities

   !> Sets θ and δL of a sensitivity, and its last terms in `mid` and `change`.
   pure subroutine set_sensitivity(y, c, tangent)
      real(wp), intent(in) :: y(12)
      integer, intent(in) :: c
      type(tangent_t), intent(inout) :: tangent
      integer :: i
      do i = 1, 3
         tangent%theta(c, i) = y(i)
         tangent%momentum(c, i) = y(3 + i)
         tangent%mid(c, i) = y(6 + i)
         tangent%change(c, i) = y(9 + i)
      end do
   end subroutine set_sensitivity

   !> Adds to θ and δL of a sensitivity, and to its last terms in `mid` and `change`.
   pure subroutine add_column(y, c, tangent)
      real(wp), intent(in) :: y(12)
      integer, intent(in) :: c
      type(tangent_t), intent(inout) :: tangent
      tangent%theta(c, :) = tangent%theta(c, :) + y(1:3)
      tangent%momentum(c, :) = tangent%momentum(c, :) + y(4:6)
      tangent%mid(c, :) = tangent%mid(c, :) + y(7:9)
      tangent%change(c, :) = tangent%change(c, :) + y(10:12)
   end subroutine add_column

end module nutate_series_tangent
