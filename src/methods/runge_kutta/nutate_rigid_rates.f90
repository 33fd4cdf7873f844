!> The equations of motion as explicit methods integrate them: attitude and body momentum, with the work of the torques.
!>
!>     q̇ = ½ q∘Ω,   L̇ = L×Ω + τ(t,q,Ω),   Ω = J⁻¹(L - h),   Ẇᵢ = Ω·τᵢ
!>
!> If the space axes rotate at ω, Ω - Rᵀω replaces Ω in q̇, τ and Ẇ.
!>
!> A method integrates `y = [q, L, W]`, W = Σ Wᵢ from the start of the step, with `k = Δt ẏ`: with `Δt J⁻¹` in place of
!> J⁻¹ no stage multiplies by the step.
!>
!> Wheels have additional rows, ḣ = u - cω: a stage finds their momenta from the rates of the stages before, by the
!> method's coefficients. The momenta of inner spheres, with the term h×Ω, are rows like those of wheels.
module nutate_rigid_rates
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_gyration, only: add_gyration
   use nutate_hamiltonian, only: inertia_at, inertia_power, inverse_inertia_at, potential_torque, system_t, &
      time_dependent_power
   use nutate_kinds, only: wp
   use nutate_limits, only: manifold_tolerance, most_inner
   use nutate_momentum_balance, only: momentum_balance_t
   use nutate_quaternion, only: quat_vector_product, rotate_to_body
   use nutate_small_products, only: is_positive, times_vector
   use nutate_stage_potentials, only: stage_potentials_t
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: rigid_rates_t, prepare_rates, begin_step, read_state, get_rates, end_step, end_wheels, get_error, n_rates
   ! This procedure is public so that it is not inlined: as a part of `add_forces` it would slow down bodies without
   ! wheels.
   public :: turn_wheels

   !> Components of y.
   integer, parameter :: n_rates = 8
   !> Largest component of the angle ΔtΩ in a stage, and of the rotation of a frame in a step, rad: larger ones do not
   !> follow the motion, and overflow some stages later.
   real(wp), parameter :: largest_angle = 1e3_wp

   !> The wheels in a step.
   type, private :: wheel_stages_t
      !> Gain of each in the step, N m s, and work of motor and friction, J; shapes (most_inner), (2, most_inner).
      real(wp) :: gain(most_inner) = 0.0_wp, work(2, most_inner) = 0.0_wp
      !> True if the motor acts in this step; times between which it may be evaluated, s; shapes (most_inner), (2,
      !> most_inner).
      logical :: driven(most_inner) = .false.
      real(wp) :: window(2, most_inner) = 0.0_wp
      !> aᵢⱼ of the method as a(j, i); Δtḣ of the stages so far, shape (stages, most_inner); momentum at the start and
      !> in the stage, N m s, shape (most_inner); the stage.
      real(wp), allocatable, private :: a(:, :), turns(:, :)
      real(wp), private :: first_momentum(most_inner) = 0.0_wp, momentum(most_inner) = 0.0_wp
      integer, private :: stage = 0
   end type wheel_stages_t

   !> Data that stay the same during a step, and the work done in it.
   type :: rigid_rates_t
      !> Start and length of the step, s.
      real(wp) :: t = 0.0_wp, dt = 0.0_wp
      !> Δt J⁻¹, s kg⁻¹ m⁻², of the present stage if the inertia varies; shape (3,3).
      real(wp) :: to_angle(3, 3) = 0.0_wp
      !> h of the rotors and, in the present stage, of the wheels, body axes, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      !> Number of wheels, and their stages; not allocated if there are none.
      integer :: n_wheels = 0
      type(wheel_stages_t), allocatable :: wheels
      !> Integrate the attitude; else its rates are zero. The attitude is left out, the space axes rotate or the inertia
      !> varies (`general`).
      logical :: attitude = .true., general = .false.
      !> The space axes rotate; half of their rotation in the step, ½Δt ω, rad, in these axes; shape (3).
      logical :: frame_turns = .false.
      real(wp) :: frame_turn(3) = 0.0_wp
      !> There is an effect that exerts a force, or a wheel.
      logical :: forced = .false.
      !> True if a potential moves; the potentials, if none does.
      logical :: moves = .false.
      !> The inertia varies; energies depend on time, by that or by potentials; a time inside of the whole step, s.
      logical :: varies = .false., depends_on_time = .false.
      real(wp) :: moment = 0.0_wp
      !> The inertia is that of the present stage, if it varies; Ω there, body axes, rad/s; shape (3).
      logical, private :: is_at_stage = .false.
      real(wp), private :: omega(3) = 0.0_wp
      type(stage_potentials_t), private :: potentials
      !> First failure of a stage, as a `NUTATE_...` code; 0: none.
      integer :: failure = 0
      !> The torque acts in this step; shape (number of torques).
      logical, allocatable :: acts(:)
      !> Times between which a torque may be evaluated, s; shape (2, number of torques).
      real(wp), allocatable :: window(:, :)
      !> The torque is in pieces, and its window is the piece of the step; shape (number of torques).
      logical, allocatable :: in_pieces(:)
      !> ∫ Ω·τᵢ dt over the step, and the work of the wheels, J; shape (n_works).
      real(wp), allocatable :: work(:)
      !> True if the error of steps is required, in body axes.
      logical :: estimates = .false.
      !> Balance of l, for the error of steps; allocated if it is kept.
      type(momentum_balance_t), allocatable, private :: momentum_balance
   end type rigid_rates_t

contains

   !> Allocates for the effects of a system.
   pure subroutine prepare_rates(self, system, attitude, conserve, a)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Integrate the attitude.
      logical, intent(in) :: attitude
      !> True if the states will be projected onto the invariants: if there are works, errors are estimated for that.
      logical, intent(in) :: conserve
      !> Coefficients aᵢⱼ of a Runge-Kutta method as a(j, i - 1), i from the second stage on.
      real(wp), intent(in), optional :: a(:, :)
      integer :: i
      self%attitude = attitude
      self%frame_turns = system%effects%frame_turns
      self%varies = system%effects%varies
      self%general = self%frame_turns .or. .not. attitude .or. self%varies
      self%forced = system%effects%n_potentials + system%effects%n_works() > 0
      self%n_wheels = system%effects%n_wheels
      self%moves = system%effects%moves
      self%depends_on_time = system%effects%depends_on_time
      call self%potentials%prepare(system%effects)
      if (allocated(self%wheels)) deallocate (self%wheels)
      if (self%n_wheels > 0) allocate (self%wheels)
      if (self%n_wheels > 0 .and. present(a)) then
         allocate (self%wheels%a, source=a)
         allocate (self%wheels%turns(size(a, 2) + 1, most_inner), source=0.0_wp)
      end if
      self%estimates = conserve .and. system%effects%n_works() > 0
      if (allocated(self%momentum_balance)) deallocate (self%momentum_balance)
      if (self%estimates .and. present(a) .and. attitude .and. .not. self%frame_turns) allocate (self%momentum_balance)
      if (allocated(self%acts)) deallocate (self%acts, self%in_pieces, self%window, self%work)
      associate (n => system%effects%n_torques)
         allocate (self%acts(n), self%in_pieces(n), source=.false.)
         allocate (self%window(2, n), self%work(system%effects%n_works()), source=0.0_wp)
         do i = 1, n
            call system%effects%torques(i)%item%piece(0.0_wp, self%window(1, i), self%window(2, i))
            self%in_pieces(i) = self%window(2, i) < huge(1.0_wp)
         end do
      end associate
   end subroutine prepare_rates

   !> Starts a step. The momentum is the L of p = 2 q∘[0, L], independently of the round-off of |q|. A state that is not
   !> one of a rotating body is stored as a failure.
   pure subroutine begin_step(self, system, state, dt, window_time, y)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s.
      real(wp), intent(in) :: dt
      !> Time that decides which torques act, s.
      real(wp), intent(in) :: window_time
      !> [q, L, W]; shape (n_rates).
      real(wp), intent(out) :: y(n_rates)
      integer :: i
      self%to_angle = dt*system%body%inverse_inertia
      self%moment = window_time
      self%rotor = system%effects%rotor_momentum
      if (self%frame_turns) self%frame_turn = (0.5_wp*dt)*system%effects%frame_rate
      do i = 1, system%effects%n_torques
         associate (torque => system%effects%torques(i)%item)
            self%acts(i) = torque%acts_at(window_time)
            if (self%in_pieces(i)) then
               call torque%piece(window_time, self%window(1, i), self%window(2, i))
            else
               call torque%window(self%window(1, i), self%window(2, i))
            end if
         end associate
         self%work(i) = 0.0_wp
      end do
      if (self%depends_on_time) self%work(size(self%work)) = 0.0_wp
      if (self%n_wheels > 0) call begin_wheels(self, system, state, window_time)
      call read_state(self, state, dt, y)
      if (allocated(self%momentum_balance) .and. self%failure == 0) call self%momentum_balance%start(y(1:4), y(5:7))
      if (self%varies .and. self%failure == 0) then
         if (.not. (is_positive(inertia_at(system, state%t)) .and. is_positive(inertia_at(system, state%t + dt)))) &
            self%failure = NUTATE_BAD_BODY
      end if
      if (self%failure /= 0 .or. .not. self%frame_turns) return
      if (2*maxval(abs(self%frame_turn)) <= largest_angle) return
      self%failure = NUTATE_OFF_BRANCH
      self%frame_turn = 0.0_wp
   end subroutine begin_step

   !> Sets the wheels at the start of a step.
   pure subroutine begin_wheels(self, system, state, window_time)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Time that decides which motors act, s.
      real(wp), intent(in) :: window_time
      integer :: i
      self%rotor = system%effects%inner_momentum(state%wheel_momentum)
      self%wheels%stage = 0
      do i = 1, self%n_wheels
         self%wheels%first_momentum(i) = state%wheel_momentum(i)
         self%wheels%momentum(i) = state%wheel_momentum(i)
         self%wheels%gain(i) = 0.0_wp
         self%wheels%work(:, i) = 0.0_wp
         associate (wheel => system%effects%wheels(i))
            self%wheels%driven(i) = wheel%is_driven(window_time)
            if (self%wheels%driven(i)) self%wheels%window(:, i) = wheel%drive_window(window_time)
         end associate
      end do
   end subroutine begin_wheels

   !> Starts a step as `begin_step` does, for a method with its own rates, and without torques.
   pure subroutine read_state(self, state, dt, y)
      type(rigid_rates_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      !> s.
      real(wp), intent(in) :: dt
      !> [q, L, W]; shape (n_rates).
      real(wp), intent(out) :: y(n_rates)
      real(wp) :: square, half
      self%t = state%t
      self%dt = dt
      associate (q => state%q, p => state%p)
         square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
         call test_state(self, state%t + dt, p, square, q(1)*p(1) + q(2)*p(2) + q(3)*p(3) + q(4)*p(4))
         y = 0.0_wp
         if (self%failure /= 0) return
         half = 0.5_wp/square
         y(1:4) = q
         y(5) = half*(q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3))
         y(6) = half*(q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4))
         y(7) = half*(q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2))
      end associate
   end subroutine read_state

   !> Stores a failure if a state is not finite or off the constraint manifold.
   pure subroutine test_state(self, end_time, p, square, product)
      type(rigid_rates_t), intent(inout) :: self
      !> s
      real(wp), intent(in) :: end_time
      !> p, |q|² and q·p.
      real(wp), intent(in) :: p(4), square, product
      real(wp) :: length
      self%failure = 0
      length = p(1)*p(1) + p(2)*p(2) + p(3)*p(3) + p(4)*p(4)
      if (.not. (ieee_is_finite(square) .and. ieee_is_finite(length) .and. ieee_is_finite(end_time))) then
         self%failure = NUTATE_NOT_FINITE
      else if (abs(square - 1) > manifold_tolerance .or. product**2 > manifold_tolerance**2*length) then
         self%failure = NUTATE_BAD_ARGUMENT
      end if
   end subroutine test_state

   !> Computes k = Δt ẏ at a fraction of the step, and the share of this stage in the work. It is written out, since
   !> products of arrays would cost a free body a tenth more instructions. A failure of a stage is stored; its rates are
   !> then zero, so that later ones are finite.
   pure recursive subroutine get_rates(self, system, fraction, y, weight, k)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Time from the start of the step over Δt (dimensionless).
      real(wp), intent(in) :: fraction
      !> [q, L, W] of the stage, |q| not quite 1; shape (n_rates).
      real(wp), intent(in) :: y(n_rates)
      !> Weight of the stage in the method's quadrature.
      real(wp), intent(in) :: weight
      !> Shape (n_rates).
      real(wp), intent(out) :: k(n_rates)
      real(wp) :: x1, x2, x3, angle1, angle2, angle3
      if (self%general) then
         if (self%varies .and. .not. self%is_at_stage) then
            call get_varying_rates(self, system, fraction, y, weight, k)
         else
            call get_general_rates(self, system, fraction, y, weight, k)
         end if
         return
      end if
      x1 = y(5) - self%rotor(1)
      x2 = y(6) - self%rotor(2)
      x3 = y(7) - self%rotor(3)
      angle1 = self%to_angle(1, 1)*x1 + self%to_angle(1, 2)*x2 + self%to_angle(1, 3)*x3
      angle2 = self%to_angle(2, 1)*x1 + self%to_angle(2, 2)*x2 + self%to_angle(2, 3)*x3
      angle3 = self%to_angle(3, 1)*x1 + self%to_angle(3, 2)*x2 + self%to_angle(3, 3)*x3
      if (.not. max(abs(angle1), abs(angle2), abs(angle3)) <= largest_angle) then
         if (self%failure == 0) self%failure = NUTATE_OFF_BRANCH
         k = 0.0_wp
         return
      end if
      k(1) = -0.5_wp*(y(2)*angle1 + y(3)*angle2 + y(4)*angle3)
      k(2) = 0.5_wp*(y(1)*angle1 + y(3)*angle3 - y(4)*angle2)
      k(3) = 0.5_wp*(y(1)*angle2 + y(4)*angle1 - y(2)*angle3)
      k(4) = 0.5_wp*(y(1)*angle3 + y(2)*angle2 - y(3)*angle1)
      k(5) = y(6)*angle3 - y(7)*angle2
      k(6) = y(7)*angle1 - y(5)*angle3
      k(7) = y(5)*angle2 - y(6)*angle1
      k(8) = 0.0_wp
      if (self%forced) call add_forces(self, system, fraction, y, weight, k)
   end subroutine get_rates

   !> Computes the rates as `get_rates` does, without attitude, with an inertia that varies or in rotating space axes:
   !> ½ q∘Ω - ½ω∘q from the sums and differences of Ω and ω, with no more products than in fixed axes. The procedure
   !> is separate so that it does not slow down `get_rates`.
   pure subroutine get_general_rates(self, system, fraction, y, weight, k)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: fraction, y(n_rates), weight
      real(wp), intent(out) :: k(n_rates)
      real(wp) :: x(3), angle(3), less(3), more(3)
      integer :: i
      x = y(5:7) - self%rotor
      do i = 1, 3
         angle(i) = self%to_angle(i, 1)*x(1) + self%to_angle(i, 2)*x(2) + self%to_angle(i, 3)*x(3)
      end do
      if (.not. max(abs(angle(1)), abs(angle(2)), abs(angle(3))) <= largest_angle) then
         if (self%failure == 0) self%failure = NUTATE_OFF_BRANCH
         k = 0.0_wp
         return
      end if
      less = 0.5_wp*angle - self%frame_turn
      more = 0.5_wp*angle + self%frame_turn
      k(1) = -(y(2)*less(1) + y(3)*less(2) + y(4)*less(3))
      k(2) = y(1)*less(1) + y(3)*more(3) - y(4)*more(2)
      k(3) = y(1)*less(2) + y(4)*more(1) - y(2)*more(3)
      k(4) = y(1)*less(3) + y(2)*more(2) - y(3)*more(1)
      k(5) = y(6)*angle(3) - y(7)*angle(2)
      k(6) = y(7)*angle(1) - y(5)*angle(3)
      k(7) = y(5)*angle(2) - y(6)*angle(1)
      k(8) = 0.0_wp
      if (.not. self%attitude) k(1:4) = 0.0_wp
      if (self%forced) call add_forces(self, system, fraction, y, weight, k)
   end subroutine get_general_rates

   !> Computes the rates with the inertia of the stage, and the power of its change.
   pure recursive subroutine get_varying_rates(self, system, fraction, y, weight, k)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: fraction, y(n_rates), weight
      real(wp), intent(out) :: k(n_rates)
      real(wp) :: t, power
      t = self%t + fraction*self%dt
      self%to_angle = self%dt*inverse_inertia_at(system, t)
      self%omega = times_vector(self%to_angle, y(5:7) - self%rotor)/self%dt
      self%is_at_stage = .true.
      call get_rates(self, system, fraction, y, weight, k)
      self%is_at_stage = .false.
      if (self%failure /= 0) return
      power = inertia_power(system%effects, self%omega, t, self%moment)
      k(8) = k(8) + self%dt*power
      associate (work => self%work(size(self%work)))
         work = work + (weight*self%dt)*power
      end associate
   end subroutine get_varying_rates

   !> Adds Δtτ of all effects to the rates.
   pure subroutine add_forces(self, system, fraction, y, weight, k)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: fraction, y(n_rates), weight
      real(wp), intent(inout) :: k(n_rates)
      real(wp) :: tau(3), square
      square = y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4)
      tau = 0.0_wp
      if (square > tiny(1.0_wp)) then
         if (self%moves) then
            call add_moving(self, system, fraction, y(1:4)/sqrt(square), weight, tau, k(8))
         else if (system%effects%n_potentials > 0) then
            call self%potentials%add_torque(system%effects, y(1:4), square, tau)
         end if
         if (system%effects%n_torques > 0) &
            call add_torques(self, system, fraction, y, sqrt(square), weight, tau, k(8))
      end if
      if (self%n_wheels > 0) call turn_wheels(self, system, fraction, y, square, weight, k(8))
      if (ieee_is_finite(tau(1)) .and. ieee_is_finite(tau(2)) .and. ieee_is_finite(tau(3))) then
         k(5) = k(5) + self%dt*tau(1)
         k(6) = k(6) + self%dt*tau(2)
         k(7) = k(7) + self%dt*tau(3)
         if (allocated(self%momentum_balance)) call self%momentum_balance%add(y(1:4), square, weight, self%dt, tau)
      else
         self%failure = NUTATE_NOT_FINITE
      end if
   end subroutine add_forces

   !> Computes rates and work of the wheels in a stage, and their momenta in the next.
   pure subroutine turn_wheels(self, system, fraction, y, square, weight, gain)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Time of the stage as a fraction of the step; [q, L, W], |q|²; weight of the stage.
      real(wp), intent(in) :: fraction, y(n_rates), square, weight
      !> Δt times the power of all that does work, J.
      real(wp), intent(inout) :: gain
      real(wp) :: q(4), omega(3), relative(3), gyration(most_inner), drive, speed, rate, t
      integer :: i, j
      q = y(1:4)/sqrt(max(square, tiny(1.0_wp)))
      omega = times_vector(system%body%inverse_inertia, y(5:7) - self%rotor)
      if (self%varies) omega = self%omega
      relative = omega
      if (self%frame_turns) relative = omega - rotate_to_body(q, system%effects%frame_rate)
      associate (stages => self%wheels)
         stages%stage = stages%stage + 1
         do i = 1, self%n_wheels
            associate (wheel => system%effects%wheels(i))
               speed = wheel%speed_of(stages%momentum(i), omega)
               drive = 0.0_wp
               t = min(max(self%t + fraction*self%dt, stages%window(1, i)), stages%window(2, i))
               if (stages%driven(i)) drive = wheel%drive(t, q, relative)
               rate = drive - wheel%friction*speed
               stages%turns(stages%stage, i) = self%dt*rate
               gain = gain + self%dt*rate*speed
               stages%gain(i) = stages%gain(i) + weight*self%dt*rate
               stages%work(1, i) = stages%work(1, i) + weight*self%dt*drive*speed
               stages%work(2, i) = stages%work(2, i) - weight*self%dt*(wheel%friction*speed)*speed
            end associate
         end do
         if (system%effects%n_spheres > 0) then
            associate (first => system%effects%n_reaction_wheels + 1, last => self%n_wheels)
               gyration(first:last) = 0.0_wp
               call add_gyration(stages%momentum(first:last), self%dt*omega, gyration(first:last))
               stages%turns(stages%stage, first:last) = stages%turns(stages%stage, first:last) + gyration(first:last)
               stages%gain(first:last) = stages%gain(first:last) + weight*gyration(first:last)
            end associate
         end if
         if (stages%stage > size(stages%a, 2)) return
         do i = 1, self%n_wheels
            stages%momentum(i) = stages%first_momentum(i)
            do j = 1, stages%stage
               stages%momentum(i) = stages%momentum(i) + stages%a(j, stages%stage)*stages%turns(j, i)
            end do
         end do
         self%rotor = system%effects%inner_momentum(stages%momentum)
      end associate
   end subroutine turn_wheels

   !> Adds the torque of potentials, some of which move, and the work of these.
   pure subroutine add_moving(self, system, fraction, q, weight, tau, gain)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Time of the stage as a fraction of the step; unit quaternion, shape (4); weight of the stage.
      real(wp), intent(in) :: fraction, q(4), weight
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      !> Δt times the power of all that does work, J.
      real(wp), intent(inout) :: gain
      real(wp) :: t, power
      t = self%t + fraction*self%dt
      tau = tau + potential_torque(system%effects, q, t)
      power = time_dependent_power(system%effects, q, t, self%moment)
      gain = gain + self%dt*power
      associate (work => self%work(size(self%work)))
         work = work + (weight*self%dt)*power
      end associate
   end subroutine add_moving

   !> Adds the torques that act, each evaluated only within its window, and their work.
   pure subroutine add_torques(self, system, fraction, y, norm, weight, tau, gain)
      type(rigid_rates_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> [q, L, W] and |q|.
      real(wp), intent(in) :: fraction, y(n_rates), norm, weight
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      !> Δt times the power of all that does work, J.
      real(wp), intent(inout) :: gain
      real(wp) :: q(4), omega(3), one(3), t, power
      integer :: i
      q = y(1:4)/norm
      omega = times_vector(system%body%inverse_inertia, y(5:7) - self%rotor)
      if (self%varies) omega = self%omega
      if (system%effects%frame_turns) omega = omega - rotate_to_body(q, system%effects%frame_rate)
      do i = 1, system%effects%n_torques
         if (.not. self%acts(i)) cycle
         t = min(max(self%t + fraction*self%dt, self%window(1, i)), self%window(2, i))
         one = system%effects%torques(i)%item%torque(t, q, omega)
         tau = tau + one
         power = omega(1)*one(1) + omega(2)*one(2) + omega(3)*one(3)
         gain = gain + self%dt*power
         self%work(i) = self%work(i) + (weight*self%dt)*power
      end do
   end subroutine add_torques

   !> Moves a state to the end of a step except for its wheels: q normalised, p = 2 q∘[0, L]. Errors, with the state
   !> unchanged: `NUTATE_OFF_BRANCH` if a stage diverged; `NUTATE_NOT_FINITE`; `NUTATE_BAD_ARGUMENT` for a state off the
   !> constraint manifold.
   pure subroutine end_step(self, y, state, status)
      type(rigid_rates_t), intent(inout) :: self
      !> [q, L, W]; shape (n_rates).
      real(wp), intent(in) :: y(n_rates)
      type(state_t), intent(inout) :: state
      type(status_t), intent(inout) :: status
      real(wp) :: square
      square = y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4)
      if (self%failure == 0 .and. .not. (ieee_is_finite(square) .and. ieee_is_finite(y(5)) .and. ieee_is_finite(y(6)) &
                                         .and. ieee_is_finite(y(7)))) self%failure = NUTATE_NOT_FINITE
      if (self%failure == 0) then
         if (.not. square > tiny(1.0_wp)) self%failure = NUTATE_OFF_BRANCH
      end if
      if (self%failure /= 0) then
         call explain(self%failure, status)
         return
      end if
      if (self%attitude) state%q = (1/sqrt(square))*y(1:4)
      state%p = quat_vector_product(state%q, 2*y(5:7))
      state%q_compensation = 0.0_wp
      state%p_compensation = 0.0_wp
      if (self%depends_on_time) state%time_dependent_work = state%time_dependent_work + self%work(size(self%work))
      state%t = self%t + self%dt
   end subroutine end_step

   !> Moves the wheels of a state to the end of a step, after `end_step`, and stores their work with that of the
   !> torques.
   pure subroutine end_wheels(self, state)
      type(rigid_rates_t), intent(inout) :: self
      type(state_t), intent(inout) :: state
      integer :: i, last
      last = size(self%acts)
      do i = 1, self%n_wheels
         call add_increment(state%wheel_momentum(i), state%wheel_compensation(i), self%wheels%gain(i))
         state%wheel_work(:, i) = state%wheel_work(:, i) + self%wheels%work(:, i)
         self%work(last + 1:last + 2) = self%wheels%work(:, i)
         last = last + 2
      end do
   end subroutine end_wheels

   !> Converts the estimated error of y, for a step that has ended, to body axes.
   pure subroutine get_error(self, y, off, weights, error)
      type(rigid_rates_t), intent(in) :: self
      !> [q, L, W] at the end of the step, |q| nearly 1, and its estimated error; shape (n_rates).
      real(wp), intent(in) :: y(n_rates), off(n_rates)
      !> Weights of the rates of the stages in this error; shape (stages). Zero for stages whose weight in the step is
      !> zero.
      real(wp), intent(in) :: weights(:)
      type(step_error_t), intent(inout) :: error
      integer :: i
      associate (q => y(1:4), d => off(1:4))
         error%rotation(1) = 2*(q(1)*d(2) - q(2)*d(1) - q(3)*d(4) + q(4)*d(3))
         error%rotation(2) = 2*(q(1)*d(3) - q(3)*d(1) - q(4)*d(2) + q(2)*d(4))
         error%rotation(3) = 2*(q(1)*d(4) - q(4)*d(1) - q(2)*d(3) + q(3)*d(2))
      end associate
      error%momentum = off(5:7)
      error%work = off(8)
      error%balances = allocated(self%momentum_balance)
      if (error%balances) call self%momentum_balance%tell(y(1:4), y(5:7), weights, error)
      do i = 1, self%n_wheels
         error%wheels(i) = dot_product(self%wheels%turns(:, i), weights)
      end do
   end subroutine get_error

   !> Sets the status of a failed step.
   pure subroutine explain(failure, status)
      integer, intent(in) :: failure
      type(status_t), intent(inout) :: status
      select case (failure)
      case (NUTATE_BAD_ARGUMENT)
         status = fail(failure, 'the method needs |q| = 1 and q.p = 0')
      case (NUTATE_BAD_BODY)
         status = fail(failure, 'the inertia is not positive definite at all times of the step')
      case (NUTATE_OFF_BRANCH)
         status = fail(failure, 'the step is too long to follow the motion')
      case default
         status = fail(failure, 'the step gave a number that is not finite')
      end select
   end subroutine explain

end module nutate_rigid_rates
