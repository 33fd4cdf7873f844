!> The tangent of a step by power series: the variational equations of a rigid body in uniform fields, expanded with its
!> motion.
!>
!>     θ̇ = θ×Ω + δΩ,   δL̇ = δL×Ω + L×δΩ + Σ M×(E×θ),   δΩ = J⁻¹(δL - δh - δJΩ)
!>
!> for the torque Σ M×E of rows Ė = E×Ω, E = Rᵀe, fixed in space axes; where these turn at ω, Ė = E×(Ω - Rᵀω). It is
!> the derivative of the flow, to the accuracy of the series. Its poles are of one order more than those of the motion,
!> so that columns err by ten times as much at the same order: theirs is higher.
module nutate_series_tangent
   use nutate_column, only: OF_POTENTIAL
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: body_momentum
   use nutate_invariants, only: ALONG_AXIS, common_direction
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: series_tangent_t, has_series_tangent

   !> By how much the order of the columns is higher.
   integer, parameter :: more_orders = 4

   !> The series of one step, with the step as the unit of time.
   type :: series_tangent_t
      private
      integer :: order = 0, n_rows = 0
      !> ΔtJ⁻¹; shape (3,3).
      real(wp) :: to_angle(3, 3) = 0.0_wp
      !> e, space axes, M times Δt, N m s, and Δtω along e, of each row; shapes (3,3), (3).
      real(wp) :: rows(3, 3) = 0.0_wp, moments(3, 3) = 0.0_wp, turn(3) = 0.0_wp
      !> L, ΔtΩ, the same relative to the space axes, and E; shapes (3, 0:highest_order), (3, 3, 0:highest_order).
      real(wp) :: momentum(3, 0:highest_order) = 0.0_wp, angle(3, 0:highest_order) = 0.0_wp
      real(wp) :: relative(3, 0:highest_order) = 0.0_wp, row(3, 3, 0:highest_order) = 0.0_wp
      !> θ, δL and ΔtδΩ of the columns; shape (n, 3, 0:highest_order).
      real(wp), allocatable :: theta(:, :, :), of_momentum(:, :, :), of_angle(:, :, :)
   contains
      !> Moves tangent columns over a step.
      procedure :: carry
   end type series_tangent_t

contains

   !> True for the effects whose columns have a series: rotors, space axes that turn, and potentials linear in a
   !> direction that stands still.
   pure logical function has_series_tangent(effects) result(has)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has = effects%n_torques + effects%n_wheels == 0 .and. .not. effects%moves
      do i = 1, effects%n_potentials
         select type (potential => effects%potentials(i)%item)
         class is (linear_potential_t)
            cycle
         class default
            has = .false.
         end select
      end do
   end function has_series_tangent

   !> Moves tangent columns over a step.
   pure subroutine carry(self, system, before, dt, order, tangent)
      class(series_tangent_t), intent(inout) :: self
      !> With effects that have such series.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before
      !> s; order of the series of the motion.
      real(wp), intent(in) :: dt
      integer, intent(in) :: order
      type(tangent_t), intent(inout) :: tangent
      integer :: i, k
      self%order = min(order + more_orders, highest_order)
      self%to_angle = dt*system%body%inverse_inertia
      call set_rows(self, system, dt, tangent)
      do i = 1, self%n_rows
         self%row(:, i, 0) = rotate_to_body(before%q, self%rows(:, i))
      end do
      self%momentum(:, 0) = body_momentum(before)
      if (allocated(self%theta)) then
         if (size(self%theta, 1) /= tangent%n) deallocate (self%theta, self%of_momentum, self%of_angle)
      end if
      if (.not. allocated(self%theta)) &
         allocate (self%theta(tangent%n, 3, 0:highest_order), self%of_momentum(tangent%n, 3, 0:highest_order), &
                   self%of_angle(tangent%n, 3, 0:highest_order))
      self%theta(:, :, 0) = tangent%theta
      self%of_momentum(:, :, 0) = tangent%momentum
      do k = 0, self%order
         call add_angles(self, k, system, dt, tangent)
         if (k == self%order) exit
         call add_motion(self, k)
         call add_columns(self, k, tangent%n, self%theta, self%of_momentum, self%of_angle)
         do i = 1, size(tangent%parametric)
            call add_own(self, k, system, dt, tangent, i)
         end do
      end do
      tangent%theta = self%theta(:, :, self%order)
      tangent%momentum = self%of_momentum(:, :, self%order)
      do k = self%order - 1, 0, -1
         tangent%theta = tangent%theta + self%theta(:, :, k)
         tangent%momentum = tangent%momentum + self%of_momentum(:, :, k)
      end do
   end subroutine carry

   !> One row for potentials along one direction, three where columns or the turning of the axes need them.
   pure subroutine set_rows(self, system, dt, tangent)
      class(series_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      real(wp) :: axis(3)
      integer :: components, i, j
      self%rows = 0.0_wp
      self%moments = 0.0_wp
      self%turn = 0.0_wp
      call common_direction(system%effects, components, axis)
      self%n_rows = 3
      if (system%effects%n_potentials == 0 .and. .not. system%effects%frame_turns) self%n_rows = 0
      if (components == ALONG_AXIS .and. .not. system%effects%frame_turns .and. size(tangent%parametric) == 0) then
         self%n_rows = 1
         self%rows(:, 1) = axis
      else
         do i = 1, 3
            self%rows(i, i) = 1.0_wp
         end do
      end if
      if (system%effects%frame_turns) self%turn = dt*system%effects%frame_rate
      do i = 1, system%effects%n_potentials
         associate (potential => system%effects%potentials(i)%item)
            do j = 1, self%n_rows
               self%moments(:, j) = self%moments(:, j) + (dt*dot_product(potential%direction, self%rows(:, j)))* &
                                    potential%series_moment()
            end do
         end associate
      end do
   end subroutine set_rows

   !> Coefficient k of the rates.
   pure subroutine add_angles(self, k, system, dt, tangent)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      real(wp) :: inner(3), own(3)
      integer :: i, m
      inner = self%momentum(:, k)
      if (k == 0) inner = inner - system%effects%rotor_momentum
      self%angle(:, k) = times_vector(self%to_angle, inner)
      self%relative(:, k) = self%angle(:, k)
      do i = 1, self%n_rows
         self%relative(:, k) = self%relative(:, k) - self%turn(i)*self%row(:, i, k)
      end do
      associate (a => self%to_angle, x => self%of_momentum, y => self%of_angle)
         do i = 1, 3
            y(:, i, k) = a(i, 1)*x(:, 1, k) + a(i, 2)*x(:, 2, k) + a(i, 3)*x(:, 3, k)
         end do
         do m = 1, size(tangent%parametric)
            own = times_vector(tangent%inertia(:, :, m), self%angle(:, k))/dt
            if (k == 0) own = own + tangent%columns(tangent%parametric(m))%rotor
            i = tangent%parametric(m)
            y(i, :, k) = y(i, :, k) - times_vector(a, own)
         end do
      end associate
   end subroutine add_angles

   !> Coefficient k + 1 of L and of the rows.
   pure subroutine add_motion(self, k)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      real(wp) :: sum(3)
      integer :: i, j
      sum = 0.0_wp
      do j = 0, k
         sum = sum + cross(self%momentum(:, j), self%angle(:, k - j))
      end do
      do i = 1, self%n_rows
         sum = sum + cross(self%moments(:, i), self%row(:, i, k))
      end do
      self%momentum(:, k + 1) = inverses(k + 1)*sum
      do i = 1, self%n_rows
         sum = 0.0_wp
         do j = 0, k
            sum = sum + cross(self%row(:, i, j), self%relative(:, k - j))
         end do
         self%row(:, i, k + 1) = inverses(k + 1)*sum
      end do
   end subroutine add_motion

   !> Coefficient k + 1 of the columns.
   pure subroutine add_columns(self, k, n, theta, momentum, angle)
      class(series_tangent_t), intent(in) :: self
      integer, intent(in) :: k, n
      !> Shape (n, 3, 0:highest_order).
      real(wp), intent(inout) :: theta(n, 3, 0:highest_order), momentum(n, 3, 0:highest_order)
      real(wp), intent(in) :: angle(n, 3, 0:highest_order)
      real(wp) :: of_theta(n, 3), of_momentum(n, 3), of_row(n, 3)
      integer :: i, j
      of_theta = angle(:, :, k)
      of_momentum = 0.0_wp
      do j = 0, k
         call add_product(n, theta(:, :, j), self%angle(:, k - j), of_theta)
         call add_product(n, momentum(:, :, j), self%angle(:, k - j), of_momentum)
         call add_product(n, angle(:, :, j), -self%momentum(:, k - j), of_momentum)
      end do
      do i = 1, self%n_rows
         of_row = 0.0_wp
         do j = 0, k
            call add_product(n, theta(:, :, j), -self%row(:, i, k - j), of_row)
         end do
         call add_product(n, of_row, -self%moments(:, i), of_momentum)
      end do
      theta(:, :, k + 1) = inverses(k + 1)*of_theta
      momentum(:, :, k + 1) = inverses(k + 1)*of_momentum
   end subroutine add_columns

   !> Adds x×v of columns.
   pure subroutine add_product(n, x, v, sum)
      integer, intent(in) :: n
      real(wp), intent(in) :: x(n, 3), v(3)
      real(wp), intent(inout) :: sum(n, 3)
      integer :: i
      do i = 1, n
         sum(i, 1) = sum(i, 1) + (x(i, 2)*v(3) - x(i, 3)*v(2))
         sum(i, 2) = sum(i, 2) + (x(i, 3)*v(1) - x(i, 1)*v(3))
         sum(i, 3) = sum(i, 3) + (x(i, 1)*v(2) - x(i, 2)*v(1))
      end do
   end subroutine add_product

   !> Adds what parameters of fields and the rate of the axes do to coefficient k + 1.
   pure subroutine add_own(self, k, system, dt, tangent, m)
      class(series_tangent_t), intent(inout) :: self
      integer, intent(in) :: k
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(tangent_t), intent(in) :: tangent
      !> Which of the parametric columns.
      integer, intent(in) :: m
      real(wp) :: moment(3), slope(3), moved(3)
      integer :: c, e, i, p
      c = tangent%parametric(m)
      associate (column => tangent%columns(c), factor => dt*inverses(k + 1))
         do i = 1, self%n_rows
            self%theta(c, :, k + 1) = self%theta(c, :, k + 1) - (factor*column%frame(i))*self%row(:, i, k)
         end do
         if (.not. allocated(column%effects)) return
         do e = 1, size(column%effects)
            if (column%effects(e)%kind /= OF_POTENTIAL) cycle
            do p = 1, system%effects%n_potentials
               if (system%effects%potentials(p)%place /= column%effects(e)%place) cycle
               associate (potential => system%effects%potentials(p)%item, change => column%effects(e)%change)
                  slope = potential%gradient_change(change, self%row(:, 1, 0), self%row(:, 1, 0))
                  moved = potential%direction_change(change, 0.0_wp)
                  do i = 1, 3
                     moment = moved(i)*potential%series_moment() - potential%direction(i)*slope
                     self%of_momentum(c, :, k + 1) = self%of_momentum(c, :, k + 1) &
                                                     + factor*cross(moment, self%row(:, i, k))
                  end do
               end associate
            end do
         end do
      end associate
   end subroutine add_own

end module nutate_series_tangent
