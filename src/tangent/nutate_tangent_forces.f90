!> The effects of one step of the conserving scheme and their derivatives, seen from mid step: what a step's tangent
!> needs of them.
!>
!> With γm = Rh γ0, γ̄ = γm/(1+ρ), Rh = R(c½)ᵀ, a rotation φ of the body at mid step at fixed r changes τ̄ = γ̄×g by
!> (γ̄×φ)×g + γ̄×(H0Rhᵀ + H1Rh)(γm×φ), and a change δr by that of φ = Nδr at the middle, N = 2(1 - [r]×)/(1+ρ), by
!> γ̄×H1·4Rh(γm×δr)/(1+ρ) at the end, and by -2τ̄(r·δr)/(1+ρ), since γ̄ is of the length of the mean.
module nutate_tangent_forces
   use nutate_column, only: column_t, OF_POTENTIAL, OF_TORQUE
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_product, rotate_to_body
   use nutate_small_products, only: times_columns, times_vector
   implicit none
   private

   public :: forces_tangent_t, half_turn_back, across

   !> Of one step.
   type :: forces_tangent_t
      !> r and 4/Δt.
      real(wp) :: r(3) = 0.0_wp, rate = 0.0_wp
      !> 1/(1+ρ), Rh and Rh - 1; shape (3,3).
      real(wp) :: shrink = 1.0_wp, half(3, 3) = 0.0_wp, swing(3, 3) = 0.0_wp
      !> τ̄ and its derivatives by φ and r; the same of the torques alone; shapes (3), (3,3).
      real(wp) :: torque(3) = 0.0_wp, by_mid(3, 3) = 0.0_wp, by_r(3, 3) = 0.0_wp
      real(wp) :: working(3) = 0.0_wp, working_by_mid(3, 3) = 0.0_wp, working_by_r(3, 3) = 0.0_wp
   contains
      !> Sets the step.
      procedure :: set
      !> Change of τ̄ by a column's parameters.
      procedure :: own_change
   end type forces_tangent_t

contains

   !> Sets the step that turns the body by the Cayley map of r.
   pure subroutine set(self, effects, forces, r, rate)
      class(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Started with the step.
      type(discrete_forces_t), intent(in) :: forces
      !> Shape (3), and 4/Δt, 1/s.
      real(wp), intent(in) :: r(3), rate
      real(wp) :: own(3)
      integer :: i, j
      self%r = r
      self%rate = rate
      self%shrink = 1/(1 + (r(1)*r(1) + r(2)*r(2) + r(3)*r(3)))
      call half_turn_back(r, self%shrink, self%half, self%swing)
      if (.not. forces%active) return
      self%torque = 0.0_wp
      self%by_mid = 0.0_wp
      do i = 1, effects%n_potentials
         call add_potential(self, effects, forces, i)
      end do
      own = (-2*self%shrink)*self%torque
      if (effects%n_torques > 0) then
         call set_torques(self, effects, forces)
         self%torque = self%torque + self%working
         self%by_mid = self%by_mid + self%working_by_mid
      end if
      self%by_r = turned_columns(self%by_mid, r, 2*self%shrink)
      do j = 1, 3
         self%by_r(:, j) = self%by_r(:, j) + r(j)*own
      end do
      if (effects%n_torques > 0) then
         self%by_r = self%by_r + self%working_by_r
         self%working_by_r = self%working_by_r + turned_columns(self%working_by_mid, r, 2*self%shrink)
      end if
      do i = 1, effects%n_potentials
         if (.not. forces%is_linear(i)) call add_curvature(self, effects, i, forces%gamma0(:, i))
      end do
   end subroutine set

   !> A matrix times N; shape (3,3).
   pure function turned_columns(a, r, factor) result(product)
      real(wp), intent(in) :: a(3, 3), r(3)
      !> 2/(1+ρ).
      real(wp), intent(in) :: factor
      real(wp) :: product(3, 3), v(3)
      integer :: i
      v = factor*r
      do i = 1, 3
         product(i, 1) = factor*a(i, 1) + (v(2)*a(i, 3) - v(3)*a(i, 2))
         product(i, 2) = factor*a(i, 2) + (v(3)*a(i, 1) - v(1)*a(i, 3))
         product(i, 3) = factor*a(i, 3) + (v(1)*a(i, 2) - v(2)*a(i, 1))
      end do
   end function turned_columns

   !> Rh = 1 + 2(rrᵀ - ρ1 - [r]×)/(1+ρ), and Rh - 1, to its own digits; shape (3,3).
   pure subroutine half_turn_back(r, shrink, half, swing)
      !> Shape (3), and 1/(1+ρ).
      real(wp), intent(in) :: r(3), shrink
      real(wp), intent(out) :: half(3, 3), swing(3, 3)
      real(wp) :: v(3)
      integer :: i
      v = (2*shrink)*r
      swing(1, 1) = -(v(2)*r(2) + v(3)*r(3))
      swing(2, 2) = -(v(3)*r(3) + v(1)*r(1))
      swing(3, 3) = -(v(1)*r(1) + v(2)*r(2))
      swing(1, 2) = v(1)*r(2) + v(3)
      swing(2, 1) = v(1)*r(2) - v(3)
      swing(1, 3) = v(1)*r(3) - v(2)
      swing(3, 1) = v(1)*r(3) + v(2)
      swing(2, 3) = v(2)*r(3) + v(1)
      swing(3, 2) = v(2)*r(3) - v(1)
      half = swing
      do i = 1, 3
         half(i, i) = 1 + swing(i, i)
      end do
   end subroutine half_turn_back

   !> Adds one potential, without what the change of its discrete gradient makes.
   pure subroutine add_potential(self, effects, forces, i)
      type(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      integer, intent(in) :: i
      real(wp) :: mean(3), gradient(3), along
      integer :: j
      mean = times_vector(self%half, forces%gamma0(:, i))
      if (forces%is_linear(i)) then
         gradient = forces%slope(:, i)
      else
         gradient = effects%potentials(i)%item%discrete_gradient(forces%gamma0(:, i), times_vector(self%half, mean))
      end if
      mean = self%shrink*mean
      self%torque = self%torque + across(mean, gradient)
      along = mean(1)*gradient(1) + mean(2)*gradient(2) + mean(3)*gradient(3)
      do j = 1, 3
         self%by_mid(:, j) = self%by_mid(:, j) - gradient(j)*mean
         self%by_mid(j, j) = self%by_mid(j, j) + along
      end do
   end subroutine add_potential

   !> Adds what the change of the discrete gradient makes.
   pure subroutine add_curvature(self, effects, i, start)
      type(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: i
      !> γ0; shape (3).
      real(wp), intent(in) :: start(3)
      real(wp) :: middle(3), end(3), mean(3), by_start(3, 3), by_end(3, 3), part(3, 3), half_back(3, 3)
      middle = times_vector(self%half, start)
      end = times_vector(self%half, middle)
      mean = self%shrink*middle
      associate (potential => effects%potentials(i)%item)
         ! Discrete gradients are symmetric in their ends.
         by_start = potential%discrete_hessian(end, start)
         by_end = potential%discrete_hessian(start, end)
      end associate
      half_back = transpose(self%half)
      part = between(mean, times_columns(by_end, self%half), middle)
      self%by_r = self%by_r + (4*self%shrink)*part
      self%by_mid = self%by_mid + part + between(mean, times_columns(by_start, half_back), middle)
   end subroutine add_curvature

   !> [a]× K [b]×; shape (3,3).
   pure function between(a, k, b) result(product)
      real(wp), intent(in) :: a(3), k(3, 3), b(3)
      real(wp) :: product(3, 3)
      product(:, 1) = across(a, b(3)*k(:, 2) - b(2)*k(:, 3))
      product(:, 2) = across(a, b(1)*k(:, 3) - b(3)*k(:, 1))
      product(:, 3) = across(a, b(2)*k(:, 1) - b(1)*k(:, 2))
   end function between

   !> Sets the torques; of their derivative by r the part of the rate alone.
   pure subroutine set_torques(self, effects, forces)
      type(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      real(wp) :: attitude(4), rotation(3, 3), by_rate(3, 3)
      integer :: i
      self%working = 0.0_wp
      self%working_by_mid = 0.0_wp
      self%working_by_r = 0.0_wp
      attitude = mid_attitude(self, forces)
      do i = 1, effects%n_torques
         if (.not. forces%acts(i)) cycle
         associate (torque => effects%torques(i)%item)
            self%working = self%working + torque%torque(forces%t, attitude, self%rate*self%r)
            call torque%derivatives(forces%t, attitude, self%rate*self%r, rotation, by_rate)
         end associate
         self%working_by_mid = self%working_by_mid + rotation
         self%working_by_r = self%working_by_r + self%rate*by_rate
      end do
   end subroutine set_torques

   !> u∘(1+r)/|1+r|: attitude at mid step, body→space; shape (4).
   pure function mid_attitude(self, forces) result(q)
      type(forces_tangent_t), intent(in) :: self
      type(discrete_forces_t), intent(in) :: forces
      real(wp) :: q(4)
      q = sqrt(self%shrink)*quat_product(forces%frame, [1.0_wp, self%r])
   end function mid_attitude

   !> Change of τ̄ by the parameters of a column, at fixed r and attitude of the start; that of the torques alone. N m;
   !> shape (3).
   pure subroutine own_change(self, effects, forces, column, torque, working)
      class(forces_tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      type(column_t), intent(in) :: column
      real(wp), intent(out) :: torque(3), working(3)
      integer :: i, m
      torque = 0.0_wp
      working = 0.0_wp
      if (.not. allocated(column%effects)) return
      do m = 1, size(column%effects)
         associate (item => column%effects(m))
            if (item%kind == OF_TORQUE) then
               if (.not. forces%acts(item%place)) cycle
               working = working + effects%torques(item%place)%item%torque_change( &
                         item%change, forces%t, mid_attitude(self, forces), self%rate*self%r)
            else if (item%kind == OF_POTENTIAL) then
               do i = 1, effects%n_potentials
                  if (effects%potentials(i)%place == item%place) &
                     torque = torque + potential_change(self, effects, forces, i, item%change)
               end do
            end if
         end associate
      end do
      torque = torque + working
   end subroutine own_change

   !> Change of the torque of one potential: of its gradient, and of n with all that depends on it.
   pure function potential_change(self, effects, forces, i, change) result(torque)
      type(forces_tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      integer, intent(in) :: i
      real(wp), intent(in) :: change(:)
      real(wp) :: torque(3)
      real(wp) :: mean(3), end(3), moved(3), moved_mean(3), moved_end(3), gradient(3), by_change(3)
      associate (potential => effects%potentials(i)%item, start => forces%gamma0(:, i))
         mean = times_vector(self%half, start)
         end = times_vector(self%half, mean)
         mean = self%shrink*mean
         by_change = potential%gradient_change(change, start, end)
         torque = across(mean, by_change)
         moved = potential%direction_change(change, forces%t)
         if (.not. any(abs(moved) > 0.0_wp)) return
         moved = rotate_to_body(forces%frame, moved)
         moved_mean = times_vector(self%half, moved)
         moved_end = times_vector(self%half, moved_mean)
         gradient = potential%discrete_gradient(start, end)
         by_change = times_vector(potential%discrete_hessian(end, start), moved) &
                     + times_vector(potential%discrete_hessian(start, end), moved_end)
         torque = torque + across(self%shrink*moved_mean, gradient) + across(mean, by_change)
      end associate
   end function potential_change

   !> a×b; here, so that it is compiled into its callers; shape (3).
   pure function across(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function across

end module nutate_tangent_forces
