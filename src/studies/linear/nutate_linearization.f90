!> Linearisation about an equilibrium, or about a periodic motion: ẋ = A x + B u, or x(T) = A x(0) + B u with inputs
!> that are constant for a period, whose A is the monodromy matrix and has the Floquet multipliers as its eigenvalues.
!>
!> x = (θ, Ω, ω): a rotation vector of the body from the motion, q∘exp(½θ), and the changes of the absolute angular
!> velocity, body axes, and of the speeds of the wheels relative to the body. u: torques about the body axes, and of
!> the motors.
!>
!> An equilibrium is a motion with constant Ω and ω with the same forces at all times: a body at rest in space or in
!> rotating axes, a steady rotation, a sleeping top.
module nutate_linearization
   use nutate_applied_torque, only: applied_torque_t
   use nutate_variation, only: attitude_variation, variation_t, rate_variation, OF_TORQUE, OF_WHEEL
   use nutate_control, only: needs_control
   use nutate_hamiltonian, only: angular_velocity, frame_rate_of, make_state, system_t
   use nutate_kinds, only: wp, pi
   use nutate_lapack, only: general_eigenvalues
   use nutate_linear_rates, only: input_matrix, linearize_rates
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_quaternion, only: quat_exp, quat_product
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_spelling, only: count_text
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_tangent, only: check_effects, tangent_t
   implicit none
   private

   public :: linearization_t, linearize_equilibrium, linearize_period, period_of_orbit

   !> A linearised motion.
   type :: linearization_t
      !> Period, s; 0: an equilibrium.
      real(wp) :: period = 0.0_wp
      !> A and B; shapes (states, states), (states, inputs).
      real(wp), allocatable :: a(:, :), b(:, :)
      !> Eigenvalues of A, 1/s about an equilibrium; shape (states).
      complex(wp), allocatable :: eigenvalues(:)
      character(len=12), allocatable :: states(:), inputs(:)
      character(len=5), allocatable :: state_units(:), input_units(:)
      !> Attitude, angular velocity, body axes, rad/s, and speeds of the wheels, rad/s, at the start.
      real(wp) :: q(4) = 0.0_wp, omega(3) = 0.0_wp
      real(wp), allocatable :: speeds(:)
      !> Deviation of the motion from an equilibrium, rad/s², or from a periodic motion, rad/s: the largest rate of
      !> change, or change, of angular velocity and speeds of wheels.
      real(wp) :: residual = 0.0_wp
      !> A period leads back to the start, and to the same forces.
      logical :: closes = .true.
      !> The rates among the states are absolute; else those relative to axes that rotate with the equilibrium, θ̇.
      logical :: absolute = .true.
   contains
      !> Changes the rates among the states to relative ones.
      procedure :: use_relative_rates
      !> Computes the gains with which a controller gives the feedback u = -Kx.
      procedure :: controller_gains
   end type linearization_t

   !> Share of the fastest rate of the motion, or of its square, up to which a residual is treated as 0: initial states
   !> are given with so many digits.
   real(wp), parameter :: tolerance = 1e-6_wp
   !> Parts of the time over which an equilibrium is followed, incommensurable with whatever is periodic in it.
   real(wp), parameter :: places(5) = [0.1459_wp, 0.3820_wp, 0.5279_wp, 0.7639_wp, 0.9098_wp]

contains

   !> Linearises about an equilibrium, on a circular orbit as seen from the LVLH frame. Errors: `NUTATE_BAD_ARGUMENT` if
   !> the start is no equilibrium, with the residual, and for effects without a derivative.
   subroutine linearize_equilibrium(system, start, end_time, result, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> Time up to which the forces have to stay the same, s; for a body that rotates in space, for one revolution.
      real(wp), intent(in) :: end_time
      type(linearization_t), intent(out) :: result
      type(status_t), intent(out) :: status
      type(system_t) :: seen
      type(state_t) :: inner
      type(state_t) :: state
      real(wp), allocatable :: rates(:), a(:, :)
      real(wp) :: pace, span, worst
      integer :: k
      logical :: constant
      call see_from_orbit(system, start, seen, inner)
      call describe(seen, inner, result, status)
      if (.not. status%ok()) return
      call input_matrix(seen, motors_of(seen), result%b)
      allocate (rates(size(result%states)), a(size(result%states), size(result%states)))
      call linearize_rates(seen, inner, rates, result%a, status)
      if (status%ok()) call general_eigenvalues(result%a, result%eigenvalues, status)
      if (.not. status%ok()) return
      result%residual = maxval(abs(rates))
      ! The fastest rate of the motion and of its linearisation, rad/s.
      pace = max(norm2(result%omega), maxval(abs(result%eigenvalues)))
      ! If nothing has a rate, a later residual may be more than the rounding at the start.
      if (result%residual > tolerance*pace**2 .and. pace > 0.0_wp) then
         status = refusal(result%residual)
         return
      end if
      span = turn_time(seen, inner, result%omega, pace)
      worst = start%t
      constant = .true.
      do k = 1, size(places)
         if (span > 0.0_wp) state = moved(seen, result, start%t, places(k)*span)
         if (.not. span > 0.0_wp) state = make_state(seen, result%q, result%omega, &
                                                     start%t + places(k)*(end_time - start%t), result%speeds)
         call linearize_rates(seen, state, rates, a, status)
         if (.not. status%ok()) return
         constant = constant .and. .not. differs(a, result%a, pace)
         if (maxval(abs(rates)) > result%residual) worst = state%t
         result%residual = max(result%residual, maxval(abs(rates)))
      end do
      if (result%residual > tolerance*pace**2) then
         status = refusal(result%residual, worst)
      else if (.not. constant) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the start is no equilibrium: the derivatives of the forces change '// &
                       'along the motion (expected constant ones, or a period to linearise over)')
      end if
      result%q = start%q
   end subroutine linearize_equilibrium

   !> Returns system and state as seen from the LVLH frame if they are on a circular orbit, else as they are.
   subroutine see_from_orbit(system, state, seen, inner)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(system_t), intent(out) :: seen
      type(state_t), intent(out) :: inner
      type(lvlh_view_t) :: view
      call view%prepare(system)
      if (view%exists) then
         seen = view%system
         call view%to_lvlh(state, inner)
      else
         seen = system
         inner = state
      end if
   end subroutine see_from_orbit

   !> Returns the error for a start that is no equilibrium.
   function refusal(residual, t) result(status)
      !> Angular acceleration, rad/s².
      real(wp), intent(in) :: residual
      !> Time of the residual, s; default: that of the start.
      real(wp), intent(in), optional :: t
      type(status_t) :: status
      character(len=10) :: size
      character(len=32) :: when
      write (size, '(es10.2)') residual
      when = ''
      if (present(t)) write (when, '(" at t = ",g0.5," s")') t
      status = fail(NUTATE_BAD_ARGUMENT, 'the start is no equilibrium: angular acceleration '//trim(adjustl(size))// &
                    ' rad/s^2'//trim(when)//' (expected 0, or a period to linearise over)')
   end function refusal

   !> Changes the rates among the states to those relative to axes that rotate with the equilibrium, such as the LVLH
   !> frame: δΩ + A₁₁θ = θ̇ in place of δΩ. Does nothing if they are relative. Errors: `NUTATE_BAD_ARGUMENT` for a
   !> period.
   subroutine use_relative_rates(self, status)
      class(linearization_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      real(wp) :: turn(3, 3)
      if (self%period > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'relative rates are not available over a period (expected an equilibrium)')
      end if
      if (.not. (self%absolute .and. status%ok())) return
      self%absolute = .false.
      turn = self%a(:3, :3)
      self%a(4:6, :) = self%a(4:6, :) + matmul(turn, self%a(:3, :))
      self%a(:, :3) = self%a(:, :3) - matmul(self%a(:, 4:6), turn)
   end subroutine use_relative_rates

   !> Computes the gain matrices of the quaternion law for the feedback u = -Kx about an equilibrium: the law has
   !> -½Kθ - Dθ̇ with θ̇ = A₁₁θ + δΩ, the rate relative to its target. So D = K_Ω, and its K is 2(K_θ - K_Ω A₁₁).
   !>
   !> The target has to be the attitude of the equilibrium, and to rotate with it: in space axes in which the body
   !> rests, or in the LVLH frame (`follows_orbit`).
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a period; for a K of another shape; and for one that uses the motors or the
   !> speeds of wheels, which the law does not.
   subroutine controller_gains(self, feedback, attitude_gain, rate_gain, status)
      class(linearization_t), intent(in) :: self
      !> K, SI units: torques about the body axes by states, shape (3, 6), or all inputs by all states.
      real(wp), intent(in) :: feedback(:, :)
      !> N m and N m s, body axes; shape (3,3).
      real(wp), intent(out) :: attitude_gain(3, 3), rate_gain(3, 3)
      type(status_t), intent(out) :: status
      logical :: known
      attitude_gain = 0.0_wp
      rate_gain = 0.0_wp
      known = all(shape(feedback) == [3, 6]) .or. all(shape(feedback) == shape(transpose(self%b)))
      if (self%period > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a controller has no gains for a motion over a period (expected an '// &
                       'equilibrium)')
      else if (.not. known) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the feedback has another shape (expected 3 rows and 6 columns, or as '// &
                       'many as inputs and states)')
      else if (any(abs(feedback(4:, :)) > 0.0_wp) .or. any(abs(feedback(:, 7:)) > 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the feedback uses motors or speeds of wheels (expected zeros there)')
      end if
      if (.not. status%ok()) return
      rate_gain = feedback(:3, 4:6)
      ! A₁₁ is zero for relative rates.
      attitude_gain = 2*(feedback(:3, :3) - matmul(rate_gain, self%a(:3, :3)))
   end subroutine controller_gains

   !> Returns the time of a revolution of the body in the space axes, s; 0 if it is at rest there.
   pure real(wp) function turn_time(system, start, omega, pace)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: omega(3), pace
      real(wp) :: rate
      rate = norm2(omega - frame_rate_of(system%effects, start%q))
      turn_time = 0.0_wp
      if (rate > tolerance*pace) turn_time = 2*pi/rate
   end function turn_time

   !> Returns the state after a time in which Ω and the speeds of the wheels are constant.
   pure type(state_t) function moved(system, linear, start, time) result(state)
      type(system_t), intent(in) :: system
      type(linearization_t), intent(in) :: linear
      !> Time of the start, and time since then, s.
      real(wp), intent(in) :: start, time
      real(wp) :: q(4)
      q = quat_product(linear%q, quat_exp((0.5_wp*time)*linear%omega))
      if (system%effects%frame_turns) q = quat_product(quat_exp((-0.5_wp*time)*system%effects%frame_rate), q)
      state = make_state(system, q, linear%omega, start + time, linear%speeds)
   end function moved

   !> Returns true if two linear motions differ: in their torques by a rotation, or by the velocities.
   pure logical function differs(a, other, pace)
      real(wp), intent(in) :: a(:, :), other(:, :), pace
      differs = any(abs(a(4:, :3) - other(4:, :3)) > tolerance*pace**2) .or. &
                any(abs(a(4:, 4:) - other(4:, 4:)) > tolerance*pace)
   end function differs

   !> Linearises a period of the motion, as the method of the run moves it, on a circular orbit as seen from the LVLH
   !> frame. If the period does not close, A is still the derivative of the end with respect to the initial state.
   !> Errors: those of the run; `NUTATE_BAD_ARGUMENT` for effects without a derivative.
   subroutine linearize_period(system, settings, start, plan, period, result, status)
      type(system_t), intent(in) :: system
      !> Settings of the run; if they leave the method open, or name the closed solution, the conserving scheme of order
      !> 8 is used.
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: start
      !> Plan whose steps are used.
      type(run_plan_t), intent(in) :: plan
      !> Period, s, positive.
      real(wp), intent(in) :: period
      type(linearization_t), intent(out) :: result
      type(status_t), intent(out) :: status
      type(system_t) :: seen, driven
      type(state_t) :: inner
      type(run_plan_t) :: one
      type(run_t) :: run
      if (needs_control(system%effects)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a linearised period supports neither limits nor samples (expected no '// &
                       'speed_limit in &wheel, no sample and no limits in &controller)')
         return
      end if
      call see_from_orbit(system, start, seen, inner)
      call describe(seen, inner, result, status)
      if (.not. status%ok()) return
      result%period = period
      one%goal = plan%goal
      one%max_steps = plan%max_steps
      one%end_time = start%t + period
      if (abs(plan%time_step) > 0.0_wp) one%time_step = period/max(1.0_wp, -aint(-period/abs(plan%time_step) + 1e-9_wp))
      driven = with_inputs(seen)
      call run%begin(driven, settings_for(settings), inner, one, status)
      if (status%ok()) call run%differentiate(variations_of(driven, motors_of(seen)), driven, status)
      if (status%ok()) call run%run_to_end(driven, status)
      if (status%ok()) call read_tangent(driven, run%state, run%tangent, result)
      if (status%ok()) call general_eigenvalues(result%a, result%eigenvalues, status)
      if (status%ok()) call close_period(seen, inner, run%state, result, status)
      result%q = start%q
   end subroutine linearize_period

   !> Returns settings with a method that has sensitivities and admits torques.
   pure type(integrator_settings_t) function settings_for(settings) result(chosen)
      type(integrator_settings_t), intent(in) :: settings
      chosen = settings
      chosen%attitude = .true.
      if (all(settings%method /= [character(len=24) :: '', 'auto', 'exact'])) return
      chosen%method = 'nielsen_krenk'
      if (chosen%order == 0) chosen%order = 8
      if (chosen%formulation == '') chosen%formulation = 'reduced'
   end function settings_for

   !> Returns a system with torques that are zero, so that there are derivatives with respect to them.
   function with_inputs(system) result(driven)
      type(system_t), intent(in) :: system
      type(system_t) :: driven
      type(applied_torque_t) :: input
      integer :: i
      driven = system
      input%name = 'torque'
      call driven%effects%add(input)
      input%name = 'motor'
      do i = 1, driven%effects%n_wheels
         associate (wheel => driven%effects%wheels(i))
            if (.not. allocated(wheel%motor)) allocate (wheel%motor, source=input)
         end associate
      end do
   end function with_inputs

   !> Returns a sensitivity for each state, and for each input.
   function variations_of(driven, motors) result(variations)
      !> System with inputs.
      type(system_t), intent(in) :: driven
      integer, intent(in) :: motors(:)
      type(variation_t), allocatable :: variations(:)
      integer :: i, n
      n = 6 + driven%effects%n_wheels
      allocate (variations(n + 3 + size(motors)))
      do i = 1, 3
         variations(i) = attitude_variation(i)
         variations(3 + i) = rate_variation(i)
         call change_effect(variations(n + i), OF_TORQUE, driven%effects%n_torques, 5, i)
      end do
      do i = 1, driven%effects%n_wheels
         call change_effect(variations(6 + i), OF_WHEEL, i, 6, 5)
      end do
      do i = 1, size(motors)
         call change_effect(variations(n + 3 + i), OF_WHEEL, motors(i), 9, 7)
      end do
   end function variations_of

   !> Makes a sensitivity of one number of an effect.
   subroutine change_effect(variation, kind, place, numbers, number)
      type(variation_t), intent(inout) :: variation
      !> Kind and index of the effect; how many numbers it has, and which one changes.
      integer, intent(in) :: kind, place, numbers, number
      allocate (variation%effects(1))
      variation%effects(1)%kind = kind
      variation%effects(1)%place = place
      allocate (variation%effects(1)%change(numbers), source=0.0_wp)
      variation%effects(1)%change(number) = 1.0_wp
   end subroutine change_effect

   !> Computes A and B at the end of a period.
   subroutine read_tangent(system, state, tangent, result)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(in) :: tangent
      type(linearization_t), intent(inout) :: result
      real(wp) :: x(size(result%states), tangent%n), omega(tangent%n, 3)
      integer :: i, n
      n = size(result%states)
      omega = tangent%rates(system, state)
      x(1:3, :) = transpose(tangent%theta)
      x(4:6, :) = transpose(omega)
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i))
            x(6 + i, :) = tangent%wheels(:, i)/wheel%inertia - matmul(omega, wheel%axis)
         end associate
      end do
      result%a = x(:, :n)
      result%b = x(:, n + 1:)
   end subroutine read_tangent

   !> Finds out whether a period leads back to the start: to its velocities, and to the same forces. If the forces do
   !> not depend on a rotation of the space axes, the body may have rotated with them.
   subroutine close_period(system, start, end, result, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start, end
      type(linearization_t), intent(inout) :: result
      type(status_t), intent(out) :: status
      real(wp), allocatable, dimension(:) :: first, last
      real(wp), allocatable, dimension(:, :) :: a, b
      complex(wp), allocatable :: values(:)
      type(state_t) :: clean
      real(wp) :: pace
      integer :: n
      n = size(result%states)
      allocate (first(n), last(n), a(n, n), b(n, n), values(n))
      ! Steps that end at rest leave a q·p that is not small compared with |p|.
      clean = make_state(system, end%q, angular_velocity(system, end), end%t, speeds_of(system, end))
      call linearize_rates(system, start, first, a, status)
      if (status%ok()) call linearize_rates(system, clean, last, b, status)
      if (status%ok()) call general_eigenvalues(a, values, status)
      if (.not. status%ok()) return
      associate (omega => angular_velocity(system, end))
         pace = max(norm2(result%omega), maxval(abs(values)))
         result%residual = max(maxval(abs(omega - result%omega)), &
                               maxval([0.0_wp, abs(speeds_of(system, end) - result%speeds)]))
      end associate
      result%closes = result%residual <= tolerance*pace .and. .not. differs(b, a, pace) .and. &
                      all(abs(last - first) <= tolerance*pace**2)
   end subroutine close_period

   !> Sets names, units and the start. Errors: `NUTATE_BAD_ARGUMENT` for effects without a derivative.
   subroutine describe(system, start, result, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      type(linearization_t), intent(inout) :: result
      type(status_t), intent(out) :: status
      integer, allocatable :: motors(:)
      integer :: i, n, m
      call check_effects(system%effects, status)
      if (status%ok() .and. system%effects%n_spheres > 0) status = fail( &
         NUTATE_BAD_ARGUMENT, 'inner spheres have no linear system (expected a body without them)', 'inner_sphere')
      if (status%ok() .and. system%effects%varies) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the inertia varies with time (expected no inertia_rate and inertia_table)')
      if (.not. status%ok()) return
      motors = motors_of(system)
      n = 6 + system%effects%n_wheels
      m = 3 + size(motors)
      allocate (result%states(n), result%state_units(n), result%inputs(m), result%input_units(m))
      allocate (result%a(n, n), result%b(n, m), source=0.0_wp)
      allocate (result%eigenvalues(n))
      result%eigenvalues = (0.0_wp, 0.0_wp)
      do i = 1, 3
         result%states(i) = 'theta'//count_text(i)
         result%states(3 + i) = 'omega'//count_text(i)
         result%inputs(i) = 'torque'//count_text(i)
      end do
      do i = 1, n - 6
         result%states(6 + i) = 'wheel'//count_text(i)//'_speed'
      end do
      do i = 1, size(motors)
         result%inputs(3 + i) = 'motor'//count_text(motors(i))
      end do
      result%state_units = 'rad/s'
      result%state_units(:3) = 'rad'
      result%input_units = 'N m'
      result%q = start%q
      result%omega = angular_velocity(system, start)
      result%speeds = speeds_of(system, start)
   end subroutine describe

   !> Returns the speeds of the wheels relative to the body, rad/s; shape (wheels).
   pure function speeds_of(system, state) result(speeds)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: speeds(system%effects%n_wheels)
      real(wp) :: omega(3)
      integer :: i
      omega = angular_velocity(system, state)
      do i = 1, size(speeds)
         speeds(i) = system%effects%wheels(i)%speed_of(state%wheel_momentum(i), omega)
      end do
   end function speeds_of

   !> Returns the wheels whose motor is an input: those without a motor, or with a constant torque.
   pure function motors_of(system) result(motors)
      type(system_t), intent(in) :: system
      integer, allocatable :: motors(:)
      logical :: is_input(system%effects%n_wheels)
      integer :: i
      do i = 1, size(is_input)
         is_input(i) = .not. allocated(system%effects%wheels(i)%motor)
         if (is_input(i)) cycle
         select type (motor => system%effects%wheels(i)%motor)
         class is (applied_torque_t)
            is_input(i) = .not. (abs(motor%frequency) > 0.0_wp .or. abs(motor%phase) > 0.0_wp .or. &
                                 motor%start > -huge(1.0_wp) .or. motor%stop < huge(1.0_wp))
         end select
      end do
      motors = pack([(i, i=1, size(is_input))], is_input)
   end function motors_of

   !> Returns the period of the orbit of the body, s; 0 if there is none.
   pure real(wp) function period_of_orbit(system) result(period)
      type(system_t), intent(in) :: system
      real(wp) :: rate
      period = 0.0_wp
      if (.not. system%effects%on_orbit) return
      rate = system%effects%orbit%path%mean_motion()
      if (rate > 0.0_wp) period = 2*pi/rate
   end function period_of_orbit

end module nutate_linearization
