!> The effects of one step of the conserving scheme and their derivatives at mid step, as the tangent of the step needs
!> them.
!>
!> With γm = Rh γ0, γ̄ = γm/(1+ρ), Rh = R(c½)ᵀ, the parts of a change of τ̄ = γ̄×g are: X0φ = (γ̄×φ)×g of a rotation φ
!> of the body at mid step; S0θ0 = γ̄×H0(γ0×θ0) of the rotation at the start; E(φ + 4δr/(1+ρ)) = γ̄×H1(γ1×θ1) of that at
!> the end, θ1 = Rh(φ + 4δr/(1+ρ)). A change δr rotates mid step by Nδr, N = 2(1 - [r]×)/(1+ρ), and scales potentials by
!> -2(r·δr)/(1+ρ), since γ̄ is of the length of the mean.
module nutate_tangent_forces
   use nutate_variation, only: reshaping_term, variation_t, OF_POTENTIAL, OF_TORQUE
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: add_multiple, deviator, multiply, skew, times_vector
   implicit none
   private

   public :: forces_tangent_t, half_swing_back, full_swing_back

   !> Effects of one step, with their derivatives.
   type :: forces_tangent_t
      !> r; 4/Δt, 1/s; 1/(1+ρ).
      real(wp) :: r(3) = 0.0_wp, rate = 0.0_wp, shrink = 1.0_wp
      !> ½(1+ρ)Rh; shape (3,3).
      real(wp) :: back(3, 3) = 0.0_wp
      !> Δtτ̄ of all effects, and of the torques alone, N m s; shape (3).
      real(wp) :: impulse(3) = 0.0_wp, working(3) = 0.0_wp
      !> Δt X0 of all effects, Δt E and ½Δt(1+ρ)S0; shape (3,3).
      real(wp) :: by_mid(3, 3) = 0.0_wp, by_end(3, 3) = 0.0_wp, by_start(3, 3) = 0.0_wp
      !> Derivatives of the torques alone by a rotation and by the rate, N m and N m s; shape (3,3).
      real(wp) :: working_by_mid(3, 3) = 0.0_wp, working_by_rate(3, 3) = 0.0_wp
      !> True if torques act; true if they depend on the attitude; true if there are potentials whose discrete gradient
      !> depends on the ends.
      logical :: has_torques = .false., follows_attitude = .false., is_curved = .false.
   contains
      !> Sets the step.
      procedure :: set
      !> Computes the change of τ̄ by a sensitivity's parameters.
      procedure :: own_change
      !> Returns the change of τ̄ by what a sensitivity changes of potentials that vary with the body.
      procedure :: reshaped_change
   end type forces_tangent_t

contains

   !> Sets the step that rotates the body by the Cayley map of r.
   pure subroutine set(self, effects, forces, r, dt)
      class(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Forces started with the step.
      type(discrete_forces_t), intent(in) :: forces
      !> r, shape (3), and the time step, s.
      real(wp), intent(in) :: r(3), dt
      real(wp) :: square, rest
      integer :: i
      square = r(1)*r(1) + r(2)*r(2) + r(3)*r(3)
      rest = 0.5_wp*(1 - square)
      self%r = r
      self%rate = 4/dt
      self%shrink = 1/(1 + square)
      self%back(1, 1) = rest + r(1)*r(1)
      self%back(2, 1) = r(1)*r(2) - r(3)
      self%back(3, 1) = r(1)*r(3) + r(2)
      self%back(1, 2) = r(1)*r(2) + r(3)
      self%back(2, 2) = rest + r(2)*r(2)
      self%back(3, 2) = r(2)*r(3) - r(1)
      self%back(1, 3) = r(1)*r(3) - r(2)
      self%back(2, 3) = r(2)*r(3) + r(1)
      self%back(3, 3) = rest + r(3)*r(3)
      self%has_torques = .false.
      self%is_curved = .false.
      if (.not. forces%active) return
      self%impulse = 0.0_wp
      self%by_mid = 0.0_wp
      do i = 1, effects%n_potentials
         call add_potential(self, effects, forces, i, dt)
      end do
      if (effects%n_torques > 0) call add_torques(self, effects, forces, dt)
      if (forces%has_spheres) call add_spheres(self, forces, dt)
   end subroutine set

   !> Computes Rh - 1 to its own digits; shape (3,3).
   pure subroutine half_swing_back(r, shrink, swing)
      !> r, shape (3), and 1/(1+ρ).
      real(wp), intent(in) :: r(3), shrink
      real(wp), intent(out) :: swing(3, 3)
      real(wp) :: v(3)
      v = (2*shrink)*r
      call swing_back(r, v, v, swing)
   end subroutine half_swing_back

   !> Computes Rh² - 1 to its own digits; shape (3,3).
   pure subroutine full_swing_back(r, shrink, swing)
      !> r, shape (3), and 1/(1+ρ).
      real(wp), intent(in) :: r(3), shrink
      real(wp), intent(out) :: swing(3, 3)
      real(wp) :: v(3), w(3), x(3)
      v = (2*shrink)*r
      w = 2*v
      x = ((2 - 1/shrink)*shrink)*w
      call swing_back(v, w, x, swing)
   end subroutine full_swing_back

   !> Computes R - 1 of a rotation back by the unit quaternion (c, v): vwᵀ - (v·w)1 - [x]×, w = 2v, x = cw.
   pure subroutine swing_back(v, w, x, swing)
      real(wp), intent(in) :: v(3), w(3), x(3)
      real(wp), intent(out) :: swing(3, 3)
      swing(1, 1) = -(v(2)*w(2) + v(3)*w(3))
      swing(2, 1) = v(1)*w(2) - x(3)
      swing(3, 1) = v(1)*w(3) + x(2)
      swing(1, 2) = v(1)*w(2) + x(3)
      swing(2, 2) = -(v(3)*w(3) + v(1)*w(1))
      swing(3, 2) = v(2)*w(3) - x(1)
      swing(1, 3) = v(1)*w(3) - x(2)
      swing(2, 3) = v(2)*w(3) + x(1)
      swing(3, 3) = -(v(1)*w(1) + v(2)*w(2))
   end subroutine swing_back

   !> Adds one potential.
   pure subroutine add_potential(self, effects, forces, i, dt)
      type(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      integer, intent(in) :: i
      real(wp), intent(in) :: dt
      real(wp) :: middle(3), mean(3), gradient(3), end(3), by_start(3, 3), by_end(3, 3), part(3, 3), twice
      twice = 2*self%shrink
      ! This is γm over 2/(1+ρ).
      middle = times_vector(self%back, forces%gamma0(:, i))
      mean = (dt*self%shrink*twice)*middle
      if (forces%is_linear(i)) then
         gradient = forces%slope(:, i)
      else
         end = (twice*twice)*times_vector(self%back, middle)
         call effects%potentials(i)%item%linearize(forces%gamma0(:, i), end, gradient, by_start, by_end)
         if (forces%reshapes) then
            call forces%add_changes(i, forces%gamma0(:, i), end, gradient, by_end)
            by_start = by_start + 0.5_wp*forces%changes%stiffness(:, :, i)
         end if
         call multiply_between(twice*mean, by_end, end, part)
         mean = (dt*self%shrink)*middle
         if (.not. self%is_curved) then
            self%is_curved = .true.
            call multiply(part, self%back, self%by_end)
            call multiply_between(mean, by_start, forces%gamma0(:, i), self%by_start)
         else
            call multiply(part, self%back, by_end)
            call add_multiple(1.0_wp, by_end, self%by_end)
            call multiply_between(mean, by_start, forces%gamma0(:, i), part)
            call add_multiple(1.0_wp, part, self%by_start)
         end if
         mean = twice*mean
      end if
      call add_torque(mean, gradient, self%impulse, self%by_mid)
   end subroutine add_potential

   !> Adds m×g and its derivative (m×φ)×g.
   pure subroutine add_torque(m, g, torque, by_mid)
      real(wp), intent(in) :: m(3), g(3)
      real(wp), intent(inout) :: torque(3), by_mid(3, 3)
      torque(1) = torque(1) + (m(2)*g(3) - m(3)*g(2))
      torque(2) = torque(2) + (m(3)*g(1) - m(1)*g(3))
      torque(3) = torque(3) + (m(1)*g(2) - m(2)*g(1))
      by_mid(1, 1) = by_mid(1, 1) + (m(2)*g(2) + m(3)*g(3))
      by_mid(2, 1) = by_mid(2, 1) - m(2)*g(1)
      by_mid(3, 1) = by_mid(3, 1) - m(3)*g(1)
      by_mid(1, 2) = by_mid(1, 2) - m(1)*g(2)
      by_mid(2, 2) = by_mid(2, 2) + (m(3)*g(3) + m(1)*g(1))
      by_mid(3, 2) = by_mid(3, 2) - m(3)*g(2)
      by_mid(1, 3) = by_mid(1, 3) - m(1)*g(3)
      by_mid(2, 3) = by_mid(2, 3) - m(2)*g(3)
      by_mid(3, 3) = by_mid(3, 3) + (m(1)*g(1) + m(2)*g(2))
   end subroutine add_torque

   !> Computes [a]× K [b]×.
   pure subroutine multiply_between(a, k, b, product)
      real(wp), intent(in) :: a(3), k(3, 3), b(3)
      real(wp), intent(out) :: product(3, 3)
      real(wp) :: c(3)
      c(1) = b(3)*k(1, 2) - b(2)*k(1, 3)
      c(2) = b(3)*k(2, 2) - b(2)*k(2, 3)
      c(3) = b(3)*k(3, 2) - b(2)*k(3, 3)
      product(1, 1) = a(2)*c(3) - a(3)*c(2)
      product(2, 1) = a(3)*c(1) - a(1)*c(3)
      product(3, 1) = a(1)*c(2) - a(2)*c(1)
      c(1) = b(1)*k(1, 3) - b(3)*k(1, 1)
      c(2) = b(1)*k(2, 3) - b(3)*k(2, 1)
      c(3) = b(1)*k(3, 3) - b(3)*k(3, 1)
      product(1, 2) = a(2)*c(3) - a(3)*c(2)
      product(2, 2) = a(3)*c(1) - a(1)*c(3)
      product(3, 2) = a(1)*c(2) - a(2)*c(1)
      c(1) = b(2)*k(1, 1) - b(1)*k(1, 2)
      c(2) = b(2)*k(2, 1) - b(1)*k(2, 2)
      c(3) = b(2)*k(3, 1) - b(1)*k(3, 2)
      product(1, 3) = a(2)*c(3) - a(3)*c(2)
      product(2, 3) = a(3)*c(1) - a(1)*c(3)
      product(3, 3) = a(1)*c(2) - a(2)*c(1)
   end subroutine multiply_between

   !> Adds the torques.
   pure subroutine add_torques(self, effects, forces, dt)
      type(forces_tangent_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      real(wp), intent(in) :: dt
      real(wp) :: attitude(4), omega(3), one(3), rotation(3, 3), by_rate(3, 3)
      integer :: i
      self%working = 0.0_wp
      attitude = mid_attitude(self, forces)
      omega = self%rate*self%r
      do i = 1, effects%n_torques
         if (.not. forces%acts(i)) cycle
         associate (torque => effects%torques(i)%item)
            one = torque%torque(forces%t, attitude, omega)
            self%working(1) = self%working(1) + dt*one(1)
            self%working(2) = self%working(2) + dt*one(2)
            self%working(3) = self%working(3) + dt*one(3)
            if (.not. self%has_torques) then
               self%has_torques = .true.
               call torque%derivatives(forces%t, attitude, omega, self%working_by_mid, self%working_by_rate)
            else
               call torque%derivatives(forces%t, attitude, omega, rotation, by_rate)
               call add_multiple(1.0_wp, rotation, self%working_by_mid)
               call add_multiple(1.0_wp, by_rate, self%working_by_rate)
            end if
         end associate
      end do
      if (.not. self%has_torques) return
      self%impulse(1) = self%impulse(1) + self%working(1)
      self%impulse(2) = self%impulse(2) + self%working(2)
      self%impulse(3) = self%impulse(3) + self%working(3)
      associate (m => self%working_by_mid)
         self%follows_attitude = (abs(m(1, 1)) + abs(m(2, 2)) + abs(m(3, 3))) &
                                 + (abs(m(2, 1)) + abs(m(3, 1)) + abs(m(1, 2))) &
                                 + (abs(m(3, 2)) + abs(m(1, 3)) + abs(m(2, 3))) > 0.0_wp
      end associate
      if (self%follows_attitude) call add_multiple(dt, self%working_by_mid, self%by_mid)
   end subroutine add_torques

   !> Adds the torque of inner spheres, R(c½)ᵀD - KΩ̄.
   pure subroutine add_spheres(self, forces, dt)
      type(forces_tangent_t), intent(inout) :: self
      type(discrete_forces_t), intent(in) :: forces
      real(wp), intent(in) :: dt
      real(wp) :: pull(3), torque(3), cross_of_pull(3, 3)
      integer :: i
      if (.not. self%has_torques) then
         self%has_torques = .true.
         self%working = 0.0_wp
         self%working_by_mid = 0.0_wp
         self%working_by_rate = 0.0_wp
      end if
      self%follows_attitude = .true.
      pull = (2*self%shrink)*times_vector(self%back, forces%pull)
      torque = dt*(pull - (forces%drag*self%rate)*self%r)
      self%working = self%working + torque
      self%impulse = self%impulse + torque
      cross_of_pull = skew(pull)
      call add_multiple(1.0_wp, cross_of_pull, self%working_by_mid)
      call add_multiple(dt, cross_of_pull, self%by_mid)
      do i = 1, 3
         self%working_by_rate(i, i) = self%working_by_rate(i, i) - forces%drag
      end do
   end subroutine add_spheres

   !> Returns the attitude at mid step, u∘(1+r)/|1+r|, body→space; shape (4).
   pure function mid_attitude(self, forces) result(q)
      type(forces_tangent_t), intent(in) :: self
      type(discrete_forces_t), intent(in) :: forces
      real(wp) :: q(4)
      real(wp) :: length
      length = sqrt(self%shrink)
      associate (u => forces%frame, r => self%r)
         q(1) = length*(u(1) - u(2)*r(1) - u(3)*r(2) - u(4)*r(3))
         q(2) = length*(u(2) + u(1)*r(1) + (u(3)*r(3) - u(4)*r(2)))
         q(3) = length*(u(3) + u(1)*r(2) + (u(4)*r(1) - u(2)*r(3)))
         q(4) = length*(u(4) + u(1)*r(3) + (u(2)*r(2) - u(3)*r(1)))
      end associate
   end function mid_attitude

   !> Computes the change of τ̄ by the parameters of a sensitivity, at fixed r and attitude at the start of the step,
   !> and the part of the torques alone, N m; shape (3).
   pure subroutine own_change(self, effects, forces, variation, torque, working)
      class(forces_tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      type(variation_t), intent(in) :: variation
      real(wp), intent(out) :: torque(3), working(3)
      integer :: i, m
      torque = 0.0_wp
      working = 0.0_wp
      if (any(abs(variation%frame) > 0.0_wp)) then
         do i = 1, effects%n_torques
            if (forces%acts(i)) working = working + effects%torques(i)%item%frame_change( &
                                          variation%frame, forces%t, mid_attitude(self, forces), self%rate*self%r)
         end do
      end if
      if (.not. allocated(variation%effects)) then
         torque = working
         return
      end if
      do m = 1, size(variation%effects)
         associate (item => variation%effects(m))
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

   !> Returns the change of the torque of one potential by the changes of its gradient, and of n with all terms that
   !> depend on n.
   pure function potential_change(self, effects, forces, i, change) result(torque)
      type(forces_tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      integer, intent(in) :: i
      real(wp), intent(in) :: change(:)
      real(wp) :: torque(3)
      real(wp) :: mean(3), end(3), moved(3), moved_mean(3), moved_end(3), gradient(3), by_change(3)
      real(wp) :: half(3, 3), by_start(3, 3), by_end(3, 3)
      associate (potential => effects%potentials(i)%item, start => forces%gamma0(:, i))
         half = (2*self%shrink)*self%back
         mean = times_vector(half, start)
         end = times_vector(half, mean)
         mean = self%shrink*mean
         by_change = potential%gradient_change(change, start, end)
         torque = across(mean, by_change)
         moved = potential%direction_change(change, forces%t)
         if (.not. any(abs(moved) > 0.0_wp)) return
         moved = rotate_to_body(forces%frame, moved)
         moved_mean = times_vector(half, moved)
         moved_end = times_vector(half, moved_mean)
         call potential%linearize(start, end, gradient, by_start, by_end)
         if (forces%reshapes) then
            call forces%add_changes(i, start, end, gradient, by_end)
            by_start = by_start + 0.5_wp*forces%changes%stiffness(:, :, i)
         end if
         by_change = times_vector(by_start, moved) + times_vector(by_end, moved_end)
         torque = torque + across(self%shrink*moved_mean, gradient) + across(mean, by_change)
      end associate
   end function potential_change

   !> Returns the change of τ̄ by what a sensitivity changes of potentials that vary with the body, γ̄×(δEγ - δe) with
   !> the mean γ of the ends, N m; shape (3).
   pure function reshaped_change(self, effects, forces, variation, inertia) result(torque)
      class(forces_tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(in) :: forces
      type(variation_t), intent(in) :: variation
      !> Change of J at mid step, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      real(wp) :: torque(3)
      real(wp) :: half(3, 3), mean(3), stiffness(3, 3), slope(3)
      integer :: i
      torque = 0.0_wp
      half = (2*self%shrink)*self%back
      do i = 1, effects%n_potentials
         if (.not. effects%potentials(i)%item%varies) cycle
         call reshaping_term(variation, effects, i, 0, forces%t, forces%t, 1.0_wp, inertia, stiffness, slope)
         associate (start => forces%gamma0(:, i))
            mean = times_vector(half, start)
            slope = slope + times_vector(deviator(stiffness), 0.5_wp*(start + times_vector(half, mean)))
            torque = torque + across(self%shrink*mean, slope)
         end associate
      end do
   end function reshaped_change

   !> Returns a×b; defined here, so that it is inlined into its callers; shape (3).
   pure function across(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function across

end module nutate_tangent_forces
