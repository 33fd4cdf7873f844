!> Rates of an explicit method at one stage, and their derivatives, for the tangent of a step.
!>
!> The rates are `k = Δt ẏ` with y = [q, L, W, h]: q and L as in `nutate_rigid_rates`, W the work of torques, motors and
!> friction, h the momenta of wheels and inner spheres. With the change a = ΔtδΩ of the angle and the rotation vector
!> θ = 2 vec(q*∘δq)/|q|² of the attitude, their derivative is `δk = (∂k/∂a)a + Θθ + ...`, a = ΔtJ⁻¹(δL - Σ s δh - ...).
module nutate_stage_rates
   use nutate_variation, only: reshaping_term, variation_t, OF_POTENTIAL, OF_TORQUE, OF_WHEEL
   use nutate_hamiltonian, only: body_direction, inverse_inertia_at, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_rigid_rates, only: rigid_rates_t
   use nutate_small_products, only: deviator, skew, times_vector
   use nutate_wheel, only: friction_change, axis_change
   implicit none
   private

   public :: stage_rates_t, most_numbers

   !> Largest number of components of y.
   integer, parameter :: most_numbers = 8 + most_inner

   !> One stage.
   type :: stage_rates_t
      !> Components of y; there are works; torques are those at |q| = 1 times |q|²; the attitude is integrated.
      integer :: n = 7
      logical :: works = .false., homogeneous = .false., attitude = .true.
      !> ΔtJ⁻¹; shape (3,3).
      real(wp) :: to_angle(3, 3) = 0.0_wp
      !> k and ∂k/∂y; shapes (n), (n, n).
      real(wp) :: rate(most_numbers) = 0.0_wp, jacobian(most_numbers, most_numbers) = 0.0_wp
      !> Time, s; attitude of unit length, body→space; |q|²; Ω absolute and relative to the space axes, rad/s.
      real(wp), private :: t = 0.0_wp, q(4) = 0.0_wp, square = 1.0_wp, omega(3) = 0.0_wp, relative(3) = 0.0_wp
      !> ∂k/∂a, its part by the relative rate, and Θ; shape (n, 3). Torque, N m; shape (3).
      real(wp), private :: by_angle(most_numbers, 3) = 0.0_wp, by_relative(most_numbers, 3) = 0.0_wp
      real(wp), private :: by_turn(most_numbers, 3) = 0.0_wp, torque(3) = 0.0_wp
      !> Δt times the power of torques and wheels, J; u and ω of each wheel, N m and rad/s, and time at which u was
      !> evaluated, s.
      real(wp), private :: drive(most_inner) = 0.0_wp, speed(most_inner) = 0.0_wp, asked(most_inner) = 0.0_wp
   contains
      !> Evaluates a stage.
      procedure :: evaluate
      !> Computes the change of k by the parameters of a sensitivity.
      procedure :: own_change
      !> Adds the change of k by what a sensitivity changes of potentials that vary with the body.
      procedure :: add_reshaped
   end type stage_rates_t

contains

   !> Evaluates a stage.
   subroutine evaluate(self, rates, system, fraction, y)
      class(stage_rates_t), intent(inout) :: self
      !> Rates begun with the step.
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      !> Time from the start of the step over Δt; y; shape (n).
      real(wp), intent(in) :: fraction, y(:)
      real(wp) :: inner(3), angle(3), rotating(3)
      integer :: i
      self%t = rates%t + fraction*rates%dt
      self%square = y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4)
      self%q = y(1:4)/sqrt(self%square)
      inner = y(5:7) - system%effects%rotor_momentum
      do i = 1, rates%n_wheels
         inner = inner - y(8 + i)*system%effects%wheels(i)%axis
      end do
      self%omega = times_vector(inverse_inertia_at(system, self%t), inner)
      if (rates%varies) self%to_angle = rates%dt*inverse_inertia_at(system, self%t)
      angle = times_vector(self%to_angle, inner)
      self%relative = self%omega
      rotating = 0.0_wp
      if (system%effects%frame_turns) rotating = rotate_to_body(self%q, system%effects%frame_rate)
      if (system%effects%frame_turns) self%relative = self%omega - rotating
      call set_kinematics(self, rates, angle, y)
      self%torque = 0.0_wp
      if (rates%forced) then
         call add_potentials(self, rates, system)
         call add_torques(self, rates, system)
         do i = 1, rates%n_wheels
            call add_wheel(self, rates, system, i, y(8 + i))
         end do
         do i = 9 + system%effects%n_reaction_wheels, self%n, 3
            self%rate(i:i + 2) = self%rate(i:i + 2) + cross(y(i:i + 2), angle)
            self%by_angle(i:i + 2, :) = self%by_angle(i:i + 2, :) + skew(y(i:i + 2))
         end do
         if (system%effects%frame_turns) then
            do i = 5, self%n
               self%by_turn(i, :) = self%by_turn(i, :) - rates%dt*cross(self%by_relative(i, :), rotating)
            end do
         end if
         self%by_angle(5:self%n, :) = self%by_angle(5:self%n, :) + self%by_relative(5:self%n, :)
      end if
      call fill_jacobian(self, rates, angle, y)
      if (rates%n_wheels > 0) call fill_inner(self, rates, system, angle)
   end subroutine evaluate

   !> Fills the part of ∂k/∂y by the momenta of wheels and inner spheres.
   pure subroutine fill_inner(self, rates, system, angle)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      !> ΔtΩ; shape (3).
      real(wp), intent(in) :: angle(3)
      integer :: i, j
      do i = 1, rates%n_wheels
         do j = 1, self%n
            self%jacobian(j, 8 + i) = self%jacobian(j, 8 + i) - dot_product( &
                             self%by_angle(j, :), times_vector(self%to_angle, system%effects%wheels(i)%axis))
         end do
         associate (wheel => system%effects%wheels(i), m => self%jacobian)
            m(8 + i, 8 + i) = m(8 + i, 8 + i) - rates%dt*wheel%friction/wheel%inertia
            m(8, 8 + i) = m(8, 8 + i) + rates%dt*(self%drive(i) - 2*wheel%friction*self%speed(i))/wheel%inertia
         end associate
      end do
      do i = 9 + system%effects%n_reaction_wheels, self%n, 3
         self%jacobian(i:i + 2, i:i + 2) = self%jacobian(i:i + 2, i:i + 2) - skew(angle)
      end do
   end subroutine fill_inner

   !> Sets k of attitude and momentum without forces, and its derivatives with respect to the angle; all others are set
   !> to zero.
   pure subroutine set_kinematics(self, rates, angle, y)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      !> ΔtΩ; shape (3); y; shape (n).
      real(wp), intent(in) :: angle(3), y(:)
      real(wp) :: less(3), more(3)
      associate (k => self%rate, b => self%by_angle)
         less = 0.5_wp*angle
         more = less
         if (rates%frame_turns) then
            less = less - rates%frame_turn
            more = more + rates%frame_turn
         end if
         k(1) = -(y(2)*less(1) + y(3)*less(2) + y(4)*less(3))
         k(2) = y(1)*less(1) + y(3)*more(3) - y(4)*more(2)
         k(3) = y(1)*less(2) + y(4)*more(1) - y(2)*more(3)
         k(4) = y(1)*less(3) + y(2)*more(2) - y(3)*more(1)
         k(5) = y(6)*angle(3) - y(7)*angle(2)
         k(6) = y(7)*angle(1) - y(5)*angle(3)
         k(7) = y(5)*angle(2) - y(6)*angle(1)
         if (self%n > 7) k(8:self%n) = 0.0_wp
         b(1:4, 1) = 0.5_wp*[-y(2), y(1), y(4), -y(3)]
         b(1:4, 2) = 0.5_wp*[-y(3), -y(4), y(1), y(2)]
         b(1:4, 3) = 0.5_wp*[-y(4), y(3), -y(2), y(1)]
         b(5:7, 1) = [0.0_wp, y(7), -y(6)]
         b(5:7, 2) = [-y(7), 0.0_wp, y(5)]
         b(5:7, 3) = [y(6), -y(5), 0.0_wp]
         if (self%n > 7) b(8:self%n, :) = 0.0_wp
         if (.not. self%attitude) k(1:4) = 0.0_wp
         if (.not. self%attitude) b(1:4, :) = 0.0_wp
      end associate
      if (.not. rates%forced) return
      self%by_turn(5:self%n, :) = 0.0_wp
      self%by_relative(5:self%n, :) = 0.0_wp
   end subroutine set_kinematics

   !> Adds τ = γ×∇U of the potentials, δγ = γ×θ.
   pure subroutine add_potentials(self, rates, system)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      real(wp) :: gamma(3), slope(3), tau(3), change(3), curvature(3, 3), along
      integer :: i, j
      logical :: linear
      tau = 0.0_wp
      do i = 1, system%effects%n_potentials
         gamma = body_direction(system%effects, i, self%q, self%t)
         associate (potential => system%effects%potentials(i)%item, by_turn => self%by_turn)
            linear = potential%is_linear()
            slope = potential%gradient(gamma)
            if (potential%varies .or. .not. linear) curvature = potential%hessian(gamma)
            if (potential%varies) call reshape_slope(self, system, i, gamma, slope, curvature)
            tau = tau + cross(gamma, slope)
            along = dot_product(slope, gamma)
            do j = 1, 3
               by_turn(5:7, j) = by_turn(5:7, j) - (rates%dt*slope(j))*gamma
               by_turn(4 + j, j) = by_turn(4 + j, j) + rates%dt*along
               if (linear) cycle
               change = 0.0_wp
               change(modulo(j, 3) + 1) = gamma(modulo(j + 1, 3) + 1)
               change(modulo(j + 1, 3) + 1) = -gamma(modulo(j, 3) + 1)
               by_turn(5:7, j) = by_turn(5:7, j) + rates%dt*cross(gamma, times_vector(curvature, change))
            end do
         end associate
      end do
      self%torque = self%torque + tau
      self%rate(5:7) = self%rate(5:7) + rates%dt*tau
   end subroutine add_potentials

   !> Adds to ∇U and the Hessian what changes of the body add.
   pure subroutine reshape_slope(self, system, i, gamma, slope, curvature)
      use nutate_reshaped_potential, only: potential_term
      type(stage_rates_t), intent(in) :: self
      type(system_t), intent(in) :: system
      integer, intent(in) :: i
      real(wp), intent(in) :: gamma(3)
      real(wp), intent(inout) :: slope(3), curvature(3, 3)
      real(wp) :: stiffness(3, 3), push(3)
      call potential_term(system%effects, i, 0, self%t, self%t, 1.0_wp, stiffness, push)
      slope = slope + push + times_vector(deviator(stiffness), gamma)
      curvature = curvature + deviator(stiffness)
   end subroutine reshape_slope

   !> Adds the torques that act, and their work.
   subroutine add_torques(self, rates, system)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      real(wp) :: tau(3), rotation(3, 3), by_rate(3, 3), t
      integer :: i
      do i = 1, system%effects%n_torques
         if (.not. rates%acts(i)) cycle
         t = min(max(self%t, rates%window(1, i)), rates%window(2, i))
         associate (torque => system%effects%torques(i)%item)
            tau = torque%torque(t, self%q, self%relative)
            call torque%derivatives(t, self%q, self%relative, rotation, by_rate)
         end associate
         self%torque = self%torque + tau
         self%rate(5:7) = self%rate(5:7) + rates%dt*tau
         self%rate(8) = self%rate(8) + rates%dt*dot_product(self%relative, tau)
         self%by_turn(5:7, :) = self%by_turn(5:7, :) + rates%dt*rotation
         self%by_turn(8, :) = self%by_turn(8, :) + rates%dt*matmul(self%relative, rotation)
         self%by_relative(5:7, :) = self%by_relative(5:7, :) + by_rate
         self%by_relative(8, :) = self%by_relative(8, :) + tau + matmul(self%relative, by_rate)
      end do
   end subroutine add_torques

   !> Adds a wheel, ḣ = u - cω, ω = h/Jw - s·Ω, and its work.
   subroutine add_wheel(self, rates, system, i, momentum)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      integer, intent(in) :: i
      !> h, N m s.
      real(wp), intent(in) :: momentum
      real(wp) :: drive, speed, slope, rotation(3, 3), by_rate(3, 3)
      associate (wheel => system%effects%wheels(i), dt => rates%dt)
         speed = wheel%speed_of(momentum, self%omega)
         drive = 0.0_wp
         self%asked(i) = min(max(self%t, rates%wheels%window(1, i)), rates%wheels%window(2, i))
         if (rates%wheels%driven(i)) drive = wheel%drive(self%asked(i), self%q, self%relative)
         if (rates%wheels%driven(i) .and. allocated(wheel%motor)) then
            call wheel%motor%derivatives(self%asked(i), self%q, self%relative, rotation, by_rate)
            self%by_turn(8 + i, :) = dt*rotation(1, :)
            self%by_turn(8, :) = self%by_turn(8, :) + (dt*speed)*rotation(1, :)
            self%by_relative(8 + i, :) = by_rate(1, :)
            self%by_relative(8, :) = self%by_relative(8, :) + speed*by_rate(1, :)
         end if
         slope = drive - 2*wheel%friction*speed
         self%rate(8 + i) = dt*(drive - wheel%friction*speed)
         self%rate(8) = self%rate(8) + self%rate(8 + i)*speed
         self%by_angle(8 + i, :) = wheel%friction*wheel%axis
         self%by_angle(8, :) = self%by_angle(8, :) - slope*wheel%axis
         self%drive(i) = drive
         self%speed(i) = speed
      end associate
   end subroutine add_wheel

   !> Fills ∂k/∂y without the contribution of wheels to Ω.
   pure subroutine fill_jacobian(self, rates, angle, y)
      type(stage_rates_t), intent(inout) :: self
      type(rigid_rates_t), intent(in) :: rates
      !> ΔtΩ; shape (3); y; shape (n).
      real(wp), intent(in) :: angle(3), y(:)
      real(wp) :: less(3), more(3), factor, pull(3)
      integer :: i, j
      associate (m => self%jacobian, b => self%by_angle, a => self%to_angle, n => self%n)
         less = 0.5_wp*angle
         more = less
         if (rates%frame_turns) less = less - rates%frame_turn
         if (rates%frame_turns) more = more + rates%frame_turn
         if (.not. self%attitude) less = 0.0_wp
         if (.not. self%attitude) more = 0.0_wp
         m(1:4, 1) = [0.0_wp, less(1), less(2), less(3)]
         m(1:4, 2) = [-less(1), 0.0_wp, -more(3), more(2)]
         m(1:4, 3) = [-less(2), more(3), 0.0_wp, -more(1)]
         m(1:4, 4) = [-less(3), -more(2), more(1), 0.0_wp]
         do j = 1, 3
            do i = 1, n
               m(i, 4 + j) = b(i, 1)*a(1, j) + b(i, 2)*a(2, j) + b(i, 3)*a(3, j)
            end do
         end do
         m(5, 6) = m(5, 6) + angle(3)
         m(5, 7) = m(5, 7) - angle(2)
         m(6, 7) = m(6, 7) + angle(1)
         m(6, 5) = m(6, 5) - angle(3)
         m(7, 5) = m(7, 5) + angle(2)
         m(7, 6) = m(7, 6) - angle(1)
         if (n > 7) m(1:n, 8:n) = 0.0_wp
         if (.not. rates%forced) then
            m(5:n, 1:4) = 0.0_wp
            return
         end if
         factor = 2/self%square
         if (self%homogeneous) factor = 2.0_wp
         associate (t => self%by_turn)
            do i = 5, n
               m(i, 1) = -factor*(t(i, 1)*y(2) + t(i, 2)*y(3) + t(i, 3)*y(4))
               m(i, 2) = factor*(t(i, 1)*y(1) - t(i, 2)*y(4) + t(i, 3)*y(3))
               m(i, 3) = factor*(t(i, 1)*y(4) + t(i, 2)*y(1) - t(i, 3)*y(2))
               m(i, 4) = factor*(-t(i, 1)*y(3) + t(i, 2)*y(2) + t(i, 3)*y(1))
            end do
         end associate
         if (.not. self%homogeneous) return
         pull = rates%dt*self%torque
         do j = 1, 4
            m(5:7, j) = m(5:7, j) + (2*y(j))*pull
         end do
         self%rate(5:7) = self%rate(5:7) + (self%square - 1)*pull
      end associate
   end subroutine fill_jacobian

   !> Computes the change of k at fixed y by the parameters of a sensitivity; shape (n).
   subroutine own_change(self, rates, system, variation, inertia, y, change)
      class(stage_rates_t), intent(in) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      type(variation_t), intent(in) :: variation
      !> δJ without parts that rotate freely, kg m², shape (3,3); y, shape (n).
      real(wp), intent(in) :: inertia(3, 3), y(:)
      real(wp), intent(out) :: change(:)
      real(wp) :: inner(3), angle(3), turn(3), torque(3), working(3), axis(3), speed, drive
      integer :: i, j, m
      inner = times_vector(inertia, self%omega) + variation%rotor
      torque = 0.0_wp
      working = frame_change(self, rates, system, variation%frame)
      change = 0.0_wp
      if (allocated(variation%effects)) then
         do m = 1, size(variation%effects)
            associate (item => variation%effects(m), c => variation%effects(m)%change)
               select case (item%kind)
               case (OF_TORQUE)
                  if (.not. rates%acts(item%place)) cycle
                  i = item%place
                  working = working + system%effects%torques(i)%item%torque_change( &
                            c, min(max(self%t, rates%window(1, i)), rates%window(2, i)), self%q, self%relative)
               case (OF_POTENTIAL)
                  do i = 1, system%effects%n_potentials
                     if (system%effects%potentials(i)%place == item%place) &
                        torque = torque + potential_change(self, system, i, c)
                  end do
               case (OF_WHEEL)
                  i = item%place
                  associate (wheel => system%effects%wheels(i), h => y(8 + i))
                     axis = axis_change(wheel, c)
                     inner = inner + h*axis
                     speed = -h*c(4)/wheel%inertia**2 - dot_product(axis, self%omega)
                     drive = 0.0_wp
                     if (rates%wheels%driven(i)) drive = wheel%drive_change(c, self%asked(i), self%q, self%relative)
                     drive = drive - friction_change(wheel, c)*self%speed(i)
                     change(8 + i) = change(8 + i) + rates%dt*(drive - wheel%friction*speed)
                     change(8) = change(8) + rates%dt*(drive*self%speed(i) + (self%drive(i) - 2*wheel%friction &
                                                                              *self%speed(i))*speed)
                  end associate
               case default
                  continue
               end select
            end associate
         end do
      end if
      torque = torque + working
      if (self%homogeneous) torque = self%square*torque
      change(5:7) = change(5:7) + rates%dt*torque
      if (self%n > 7) change(8) = change(8) + rates%dt*dot_product(self%relative, working)
      angle = -times_vector(self%to_angle, inner)
      do j = 1, 3
         change = change + angle(j)*self%by_angle(1:self%n, j)
      end do
      if (.not. any(abs(variation%frame) > 0.0_wp)) return
      turn = rates%dt*rotate_to_body(self%q, variation%frame)
      if (rates%frame_turns) call turn_frame(0.5_wp*turn, y, change)
      if (rates%forced) change(5:) = change(5:) - matmul(self%by_relative(5:self%n, :), turn)
   end subroutine own_change

   !> Returns the change of the torques with the rate of the space axes, at a fixed rate relative to them, N m;
   !> shape (3).
   pure function frame_change(self, rates, system, change) result(torque)
      type(stage_rates_t), intent(in) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      !> rad/s; shape (3).
      real(wp), intent(in) :: change(3)
      real(wp) :: torque(3)
      integer :: i
      torque = 0.0_wp
      if (.not. any(abs(change) > 0.0_wp)) return
      do i = 1, system%effects%n_torques
         if (rates%acts(i)) torque = torque + system%effects%torques(i)%item%frame_change( &
                       change, min(max(self%t, rates%window(1, i)), rates%window(2, i)), self%q, self%relative)
      end do
   end function frame_change

   !> Adds -φ∘q = -q∘Rᵀφ.
   pure subroutine turn_frame(turn, y, change)
      !> Rᵀφ, shape (3); y.
      real(wp), intent(in) :: turn(3), y(:)
      real(wp), intent(inout) :: change(:)
      change(1) = change(1) + (y(2)*turn(1) + y(3)*turn(2) + y(4)*turn(3))
      change(2:4) = change(2:4) - (y(1)*turn + cross(y(2:4), turn))
   end subroutine turn_frame

   !> Returns the change of the torque of one potential by a change of its parameters, N m; shape (3).
   pure function potential_change(self, system, i, change) result(torque)
      type(stage_rates_t), intent(in) :: self
      type(system_t), intent(in) :: system
      integer, intent(in) :: i
      real(wp), intent(in) :: change(:)
      real(wp) :: torque(3)
      real(wp) :: gamma(3), moved(3), slope(3), curvature(3, 3)
      gamma = body_direction(system%effects, i, self%q, self%t)
      associate (potential => system%effects%potentials(i)%item)
         torque = cross(gamma, potential%gradient_change(change, gamma, gamma))
         moved = potential%direction_change(change, self%t)
         if (.not. any(abs(moved) > 0.0_wp)) return
         moved = rotate_to_body(self%q, moved)
         slope = potential%gradient(gamma)
         curvature = potential%hessian(gamma)
         if (potential%varies) call reshape_slope(self, system, i, gamma, slope, curvature)
         torque = torque + cross(moved, slope) + cross(gamma, times_vector(curvature, moved))
      end associate
   end function potential_change

   !> Adds the change of k by what a sensitivity changes of potentials that vary with the body, γ×(δEγ - δe).
   subroutine add_reshaped(self, rates, system, variation, inertia, change)
      class(stage_rates_t), intent(in) :: self
      type(rigid_rates_t), intent(in) :: rates
      type(system_t), intent(in) :: system
      type(variation_t), intent(in) :: variation
      !> δJ without parts that rotate freely, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      real(wp), intent(inout) :: change(:)
      real(wp) :: gamma(3), slope(3), stiffness(3, 3), torque(3)
      integer :: i
      torque = 0.0_wp
      do i = 1, system%effects%n_potentials
         if (.not. system%effects%potentials(i)%item%varies) cycle
         gamma = body_direction(system%effects, i, self%q, self%t)
         call reshaping_term(variation, system%effects, i, 0, self%t, self%t, 1.0_wp, inertia, stiffness, slope)
         torque = torque + cross(gamma, times_vector(stiffness, gamma) + slope)
      end do
      if (self%homogeneous) torque = self%square*torque
      change(5:7) = change(5:7) + rates%dt*torque
   end subroutine add_reshaped

end module nutate_stage_rates
