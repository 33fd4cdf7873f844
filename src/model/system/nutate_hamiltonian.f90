!> The Hamiltonian of a rigid body in quaternions and conjugate momenta, with its energies and torques.
!> Numbers in parentheses are those of the equations of Nielsen & Krenk (2012).
!>
!> `J = diag(J0, inertia)` is the extended inertia; only `1/J0` ever enters (`inverse_j0`, 0 for an infinite J0), so
!> that the physical body is its default.
module nutate_hamiltonian
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, is_unit, most_inner
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body, vector_quat_product
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   use nutate_system, only: inertia_at, inverse_inertia_at, system_t
   implicit none
   private

   !> Type of the arguments of all procedures here, which their callers need, and what belongs to it.
   public :: system_t, inertia_at, inverse_inertia_at
   public :: make_state, angular_velocity, body_momentum, space_momentum, bilinear_form
   public :: kinetic_energy, potential_energy, total_energy, conserved_energy, frame_rate_of, relative_rate
   public :: potential_torque, moving_energy, time_dependent_power, time_dependent_work, body_direction, energy_of, &
      inertia_power

contains

   !> Returns the state of a body with an attitude and an angular velocity: p = 2 q∘[0, L], which is (4) on the
   !> constraint (5), qᵀp = 0. Numbers that are not finite or beyond 1e100, a |q| that is not 1 to within 1e-6, and
   !> speeds of more or fewer wheels give a momentum that every stepper rejects.
   pure type(state_t) function make_state(system, q, omega, t, speeds) result(state)
      !> System whose inertia, rotors and wheels are used.
      type(system_t), intent(in) :: system
      !> Attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> Time, s; default 0.
      real(wp), intent(in), optional :: t
      !> Speeds of the wheels, and of the components of inner spheres, relative to the body, rad/s; shape (n_wheels);
      !> default: their initial speeds.
      real(wp), intent(in), optional :: speeds(:)
      integer :: i
      if (present(t)) state%t = t
      state%q = q
      state%p = huge(1.0_wp)
      if (.not. is_unit(q, attitude_tolerance)) return
      if (.not. all(is_moderate([omega, system%effects%rotor_momentum]))) return
      if (system%effects%n_wheels > most_inner) return
      if (present(speeds)) then
         if (size(speeds) /= system%effects%n_wheels) return
      end if
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i))
            state%wheel_momentum(i) = wheel%speed
            if (present(speeds)) state%wheel_momentum(i) = speeds(i)
            if (.not. is_moderate(state%wheel_momentum(i))) return
            state%wheel_momentum(i) = wheel%inertia*(state%wheel_momentum(i) + dot_product(wheel%axis, omega))
         end associate
      end do
      state%p = 2*quat_product(q, [0.0_wp, matmul(inertia_at(system, state%t), omega) + &
                                   system%effects%inner_momentum(state%wheel_momentum)])
   end function make_state

   !> Returns w(q,p) = Q(q)ᵀp = q*∘p = [q·p, 2L], bilinear in q and p: the factor in both forms of T in (6); shape (4).
   pure function bilinear_form(q, p) result(w)
      real(wp), intent(in) :: q(4), p(4)
      real(wp) :: w(4)
      w = quat_product(quat_conjugate(q), p)
   end function bilinear_form

   !> Returns L = JΩ + h = ½ vec(q*∘p), body axes, N m s; shape (3).
   pure function body_momentum(state) result(momentum)
      type(state_t), intent(in) :: state
      real(wp) :: momentum(3), w(4)
      w = bilinear_form(state%q, state%p)
      momentum = 0.5_wp*w(2:4)
   end function body_momentum

   !> Returns l = ½ vec(p∘q*), space axes, N m s; shape (3). Conserved without torque.
   pure function space_momentum(state) result(momentum)
      type(state_t), intent(in) :: state
      real(wp) :: momentum(3), w(4)
      w = quat_product(state%p, quat_conjugate(state%q))
      momentum = 0.5_wp*w(2:4)
   end function space_momentum

   !> Returns Ω = J⁻¹(L - h), body axes, rad/s; shape (3).
   pure function angular_velocity(system, state) result(omega)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: omega(3)
      omega = times_vector(inverse_inertia_at(system, state%t), &
                           body_momentum(state) - system%effects%inner_momentum(state%wheel_momentum))
   end function angular_velocity

   !> Returns Rᵀω: the rate of the space axes, body axes, rad/s; shape (3).
   pure function frame_rate_of(effects, q) result(rate)
      type(effect_list_t), intent(in) :: effects
      !> Attitude, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: rate(3)
      rate = 0.0_wp
      if (effects%frame_turns) rate = rotate_to_body(q, effects%frame_rate)/dot_product(q, q)
   end function frame_rate_of

   !> Returns Ω - Rᵀω, the rate at which the body rotates in the space axes, body axes, rad/s; Ω if these do not rotate;
   !> shape (3).
   pure function relative_rate(system, state) result(rate)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: rate(3)
      rate = angular_velocity(system, state)
      if (system%effects%frame_turns) rate = rate - frame_rate_of(system%effects, state%q)
   end function relative_rate

   !> Returns T of (3) and (6) as ⅛ (w - 2h)ᵀ J⁻¹ (w - 2h), w = w(q,p), h the momentum of rotors and wheels, and Σ
   !> h²/2Jw of the wheels, J.
   pure real(wp) function kinetic_energy(system, state, inverse_j0) result(energy)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻²; default 0.
      real(wp), intent(in), optional :: inverse_j0
      real(wp) :: w(4), u(3)
      w = bilinear_form(state%q, state%p)
      u = w(2:4) - 2*system%effects%inner_momentum(state%wheel_momentum)
      energy = 0.125_wp*dot_product(u, times_vector(inverse_inertia_at(system, state%t), u))
      if (system%effects%n_wheels > 0) energy = energy + system%effects%wheel_energy(state%wheel_momentum)
      if (present(inverse_j0)) energy = energy + 0.125_wp*inverse_j0*w(1)**2
   end function kinetic_energy

   !> Returns V(q) = Σ U(R(q)ᵀ n), J; R(q) the homogeneous quadratic form.
   pure real(wp) function potential_energy(effects, q, t) result(energy)
      type(effect_list_t), intent(in) :: effects
      !> Attitude, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Time at which time-dependent potentials are evaluated, s; default 0.
      real(wp), intent(in), optional :: t
      real(wp) :: time
      integer :: i
      energy = 0.0_wp
      time = 0.0_wp
      if (present(t)) time = t
      do i = 1, effects%n_potentials
         energy = energy + energy_of(effects, i, q, time)
      end do
   end function potential_energy

   !> Returns V of one potential, J.
   pure real(wp) function energy_of(effects, i, q, t) result(energy)
      use nutate_reshaped_potential, only: varying_energy
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> Attitude, body→space, shape (4); time, s.
      real(wp), intent(in) :: q(4), t
      real(wp) :: gamma(3)
      gamma = body_direction(effects, i, q, t)
      associate (potential => effects%potentials(i)%item)
         energy = potential%energy(gamma)
         if (potential%varies) energy = energy + varying_energy(effects, i, gamma, t)
      end associate
   end function energy_of

   !> Returns γ = R(q)ᵀn: the direction of a potential in body axes, with the length of q squared; shape (3).
   pure function body_direction(effects, i, q, t) result(gamma)
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> Attitude, body→space, shape (4); time, s.
      real(wp), intent(in) :: q(4), t
      real(wp) :: gamma(3)
      associate (potential => effects%potentials(i)%item)
         if (potential%moves) then
            gamma = rotate_to_body(q, potential%direction_at(t))
         else
            gamma = rotate_to_body(q, potential%direction)
         end if
      end associate
   end function body_direction

   !> Returns ∂V/∂t at fixed attitude, the power of time-dependent potentials, W.
   pure real(wp) function time_dependent_power(effects, q, t, moment) result(power)
      type(effect_list_t), intent(in) :: effects
      !> Unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Time, s.
      real(wp), intent(in) :: t
      !> Time inside of the step that begins, ends or contains `t`, s; default `t`.
      real(wp), intent(in), optional :: moment
      real(wp) :: inside
      integer :: i
      power = 0.0_wp
      inside = t
      if (present(moment)) inside = moment
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (potential%moves) power = power + potential%power(q, t)
            if (potential%varies) power = power + varying_power(effects, i, q, t, inside)
         end associate
      end do
   end function time_dependent_power

   !> Returns the power of what changes of the body add to a potential, W: ½γᵀĖγ - ė·γ, and (Eγ - e)·R(q)ᵀṅ if n moves.
   pure real(wp) function varying_power(effects, i, q, t, moment) result(power)
      use nutate_reshaped_potential, only: potential_term
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: i
      real(wp), intent(in) :: q(4), t, moment
      real(wp) :: stiffness(3, 3), slope(3), gamma(3), n(3, 0:1)
      gamma = body_direction(effects, i, q, t)
      call potential_term(effects, i, 1, t, moment, 1.0_wp, stiffness, slope)
      power = dot_product(gamma, 0.5_wp*times_vector(stiffness, gamma) + slope)
      associate (potential => effects%potentials(i)%item)
         if (.not. potential%moves) return
         call potential%direction_series(t, 1.0_wp, n)
      end associate
      call potential_term(effects, i, 0, t, moment, 1.0_wp, stiffness, slope)
      power = power + dot_product(times_vector(stiffness, gamma) + slope, rotate_to_body(q, n(:, 1)))
   end function varying_power

   !> Returns -½ Ωᵀ(dJ/dt)Ω, the power of a change of the inertia at fixed L, W.
   pure real(wp) function inertia_power(effects, omega, t, moment) result(power)
      type(effect_list_t), intent(in) :: effects
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> Time, s, and a time inside of the step that begins, ends or contains it, s.
      real(wp), intent(in) :: t, moment
      power = -0.5_wp*dot_product(omega, times_vector(effects%inertia_term(1, t, moment, 1.0_wp), omega))
   end function inertia_power

   !> Returns V of the time-dependent potentials alone, J.
   pure real(wp) function moving_energy(effects, q, t) result(energy)
      type(effect_list_t), intent(in) :: effects
      !> Attitude, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Time, s.
      real(wp), intent(in) :: t
      integer :: i
      energy = 0.0_wp
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (potential%moves .or. potential%varies) energy = energy + energy_of(effects, i, q, t)
         end associate
      end do
   end function moving_energy

   !> Returns the work of the dependence on time in a step of the conserving scheme: that of potentials, and that of the
   !> inertia.
   pure real(wp) function time_dependent_work(system, before, after, dt) result(work)
      type(system_t), intent(in) :: system
      !> States at the ends of the step.
      type(state_t), intent(in) :: before, after
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      work = 0.0_wp
      if (system%effects%moves) work = work_of_potentials(system%effects, before, after, dt)
      if (system%effects%varies) work = work + work_of_inertia(system, before, after, dt)
   end function time_dependent_work

   !> Returns the work of the inertia in a step of the conserving scheme, which has that of its middle: with u = L - h,
   !> T1 - T0 of the inertias at the ends, less ½(u0 + u1)ᵀ J⁻¹ (u1 - u0) of the middle. The first difference telescopes
   !> as that of potentials; the second is computed from all digits of the increments.
   pure real(wp) function work_of_inertia(system, before, after, dt) result(work)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt
      real(wp) :: dq(4), dp(4), w(4), change(3), u0(3), u1(3)
      dq = (after%q - before%q) + (after%q_compensation - before%q_compensation)
      dp = (after%p - before%p) + (after%p_compensation - before%p_compensation)
      w = bilinear_form(0.5_wp*(before%q + after%q), dp) + bilinear_form(dq, 0.5_wp*(before%p + after%p))
      change = 0.5_wp*w(2:4)
      if (system%effects%n_wheels > 0) change = change - (system%effects%inner_momentum( &
         (after%wheel_momentum - before%wheel_momentum) + (after%wheel_compensation - before%wheel_compensation)) &
         - system%effects%rotor_momentum)
      u0 = body_momentum(before) - system%effects%inner_momentum(before%wheel_momentum)
      u1 = body_momentum(after) - system%effects%inner_momentum(after%wheel_momentum)
      work = 0.5_wp*(dot_product(u1, times_vector(inverse_inertia_at(system, after%t), u1)) - &
                     dot_product(u0, times_vector(inverse_inertia_at(system, before%time_dependent_since(dt)), u0))) &
             - 0.5_wp*dot_product(u0 + u1, times_vector(inverse_inertia_at(system, before%t + 0.5_wp*dt), change))
   end function work_of_inertia

   !> Returns the work of time-dependent potentials in a step of the conserving scheme, which evaluates them at its
   !> middle t̄: V(q1, t1) - V(q0, t0) - (V(q1, t̄) - V(q0, t̄)), J. The first difference telescopes without rounding
   !> from step to step, from the time up to which the work is counted; the second is ∇̄U·Δγ, Δγ = 2 vec(q̄*∘n∘Δq), from
   !> all digits of the increment of q.
   pure real(wp) function work_of_potentials(effects, before, after, dt) result(work)
      use nutate_reshaped_potential, only: varying_gradient
      type(effect_list_t), intent(in) :: effects
      !> States at the ends of the step.
      type(state_t), intent(in) :: before, after
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      real(wp) :: middle, change(4), mean(4), n(3), gamma(4), start(3), end(3), gradient(3)
      integer :: i
      middle = before%t + 0.5_wp*dt
      change = (after%q - before%q) + (after%q_compensation - before%q_compensation)
      mean = 0.5_wp*(before%q + after%q)
      work = moving_energy(effects, after%q, after%t) - moving_energy(effects, before%q, &
                                                                      before%time_dependent_since(dt))
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (.not. (potential%moves .or. potential%varies)) cycle
            n = potential%direction_at(middle)
            gamma = quat_product(quat_conjugate(mean), vector_quat_product(n, change))
            start = rotate_to_body(before%q, n)
            end = rotate_to_body(after%q, n)
            gradient = potential%discrete_gradient(start, end)
            if (potential%varies) gradient = gradient + varying_gradient(effects, i, 0.5_wp*(start + end), middle)
            work = work - 2*dot_product(gamma(2:4), gradient)
         end associate
      end do
   end function work_of_potentials

   !> Returns H = T + V, J: equation (8) on the constraint (2), where the term of its multiplier λ vanishes.
   pure real(wp) function total_energy(system, state, inverse_j0) result(energy)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻²; default 0.
      real(wp), intent(in), optional :: inverse_j0
      energy = kinetic_energy(system, state, inverse_j0) + &
            potential_energy(system%effects, state%q, state%t)
   end function total_energy

   !> Returns the conserved energy, J: H, or, in rotating space axes, the Jacobi integral H - ω·l.
   pure real(wp) function conserved_energy(system, state, inverse_j0) result(energy)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻²; default 0.
      real(wp), intent(in), optional :: inverse_j0
      energy = total_energy(system, state, inverse_j0)
      if (system%effects%frame_turns) energy = energy - dot_product(system%effects%frame_rate, space_momentum(state))
   end function conserved_energy

   !> Returns τ = Σ γ×∇U: torque of the potentials, body axes, N m; shape (3).
   pure function potential_torque(effects, q, t) result(torque)
      use nutate_reshaped_potential, only: varying_gradient
      type(effect_list_t), intent(in) :: effects
      !> Attitude, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Time at which time-dependent potentials are evaluated, s; default 0.
      real(wp), intent(in), optional :: t
      real(wp) :: torque(3)
      real(wp) :: gamma(3), slope(3), time
      integer :: i
      torque = 0.0_wp
      time = 0.0_wp
      if (present(t)) time = t
      do i = 1, effects%n_potentials
         gamma = body_direction(effects, i, q, time)
         associate (potential => effects%potentials(i)%item)
            slope = potential%gradient(gamma)
            if (potential%varies) slope = slope + varying_gradient(effects, i, gamma, time)
         end associate
         torque = torque + cross(gamma, slope)
      end do
   end function potential_torque

end module nutate_hamiltonian
