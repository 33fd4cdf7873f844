!> The motion at an instant: a state, its rates, and the torques that cause them.
module nutate_motion
   use nutate_gyration, only: add_gyration
   use nutate_hamiltonian, only: body_direction, inertia_power, inverse_inertia_at, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   use nutate_quaternion, only: cross, quat_norm, quat_product, quat_vector_product, rotate_to_body
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   implicit none
   private

   public :: motion_t, find_motion, find_velocities, find_rates, renew_motion, displaced

   !> A state and its rates. Body axes; vectors of shape (3).
   type :: motion_t
      type(state_t) :: state = state_t()
      !> Ω, rad/s, and L = JΩ + h, N m s, h that of rotors and wheels.
      real(wp) :: omega(3) = 0.0_wp, momentum(3) = 0.0_wp
      !> Ω relative to the space axes, rad/s: Ω less the rate of rotating space axes.
      real(wp) :: relative(3) = 0.0_wp
      !> Set by `find_rates`: Ω̇, rad/s²; the torque of the potentials, and the sum of the torques, N m.
      real(wp) :: acceleration(3) = 0.0_wp, potential_torque(3) = 0.0_wp, torque(3) = 0.0_wp
      !> Set by `find_rates`: ḣ of each wheel, N m, shape (most_inner); power of motors and bearing friction, W.
      real(wp) :: wheel_rate(most_inner) = 0.0_wp, inner_power = 0.0_wp
      !> Set by `find_rates`: power of a change of the inertia, W.
      real(wp) :: inertia_power = 0.0_wp
   end type motion_t

contains

   !> Computes angular velocities and momentum of a state, independently of the round-off of |q|.
   pure subroutine find_motion(system, state, motion)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(motion_t), intent(inout) :: motion
      motion%state = state
      call find_velocities(system, state, motion%omega, motion%momentum, motion%relative)
   end subroutine find_motion

   !> Computes angular velocities and momentum of a state as `find_motion` does.
   pure subroutine find_velocities(system, state, omega, momentum, relative)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Ω, L and Ω relative to the space axes, as in `motion_t`; shape (3).
      real(wp), intent(out) :: omega(3), momentum(3), relative(3)
      real(wp) :: half
      associate (q => state%q, p => state%p)
         half = 0.5_wp/(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
         momentum(1) = half*(q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3))
         momentum(2) = half*(q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4))
         momentum(3) = half*(q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2))
         omega = times_vector(inverse_inertia_at(system, state%t), &
                              momentum - system%effects%inner_momentum(state%wheel_momentum))
         relative = omega
         if (system%effects%frame_turns) relative = omega - (2*half)*rotate_to_body(q, system%effects%frame_rate)
      end associate
   end subroutine find_velocities

   !> Computes the torques and the rates: J Ω̇ = L×Ω + τ - Σ s ḣ - J̇Ω.
   pure subroutine find_rates(system, window_time, motion)
      use nutate_reshaped_potential, only: varying_gradient
      type(system_t), intent(in) :: system
      !> Time that decides which torques act, s: inside the step that the state begins or ends.
      real(wp), intent(in) :: window_time
      !> Motion that `find_motion` computed.
      type(motion_t), intent(inout) :: motion
      real(wp) :: q(4), gamma(3), slope(3), start, stop, piece(2), inner(3)
      integer :: i
      motion%potential_torque = 0.0_wp
      motion%torque = 0.0_wp
      if (system%effects%n_potentials + system%effects%n_torques > 0) &
         q = (1/quat_norm(motion%state%q))*motion%state%q
      do i = 1, system%effects%n_potentials
         associate (potential => system%effects%potentials(i)%item)
            gamma = body_direction(system%effects, i, q, motion%state%t)
            slope = potential%gradient(gamma)
            if (potential%varies) slope = slope + varying_gradient(system%effects, i, gamma, motion%state%t)
            motion%potential_torque = motion%potential_torque + cross(gamma, slope)
         end associate
      end do
      do i = 1, system%effects%n_torques
         associate (torque => system%effects%torques(i)%item)
            if (.not. torque%acts_at(window_time)) cycle
            call torque%window(start, stop)
            call torque%piece(window_time, piece(1), piece(2))
            start = max(start, piece(1))
            stop = min(stop, piece(2))
            motion%torque = motion%torque + torque%torque(min(max(motion%state%t, start), stop), q, motion%relative)
         end associate
      end do
      inner = 0.0_wp
      if (system%effects%n_wheels > 0) call turn_wheels(system, window_time, motion, inner)
      motion%acceleration = cross(motion%momentum, motion%omega) + (motion%potential_torque + motion%torque) - inner
      motion%inertia_power = 0.0_wp
      if (system%effects%varies) then
         motion%acceleration = motion%acceleration - &
                               times_vector(system%effects%inertia_term(1, motion%state%t, window_time, 1.0_wp), &
                                            motion%omega)
         motion%inertia_power = inertia_power(system%effects, motion%omega, motion%state%t, window_time)
      end if
      motion%acceleration = times_vector(inverse_inertia_at(system, motion%state%t), motion%acceleration)
   end subroutine find_rates

   !> Computes velocities and rates of the state of a motion.
   pure subroutine renew_motion(system, window_time, motion)
      type(system_t), intent(in) :: system
      !> Time as in `find_rates`, s.
      real(wp), intent(in) :: window_time
      type(motion_t), intent(inout) :: motion
      call find_velocities(system, motion%state, motion%omega, motion%momentum, motion%relative)
      call find_rates(system, window_time, motion)
   end subroutine renew_motion

   !> Computes the rates ḣ = u - cω of wheels, with h×Ω of inner spheres, and Σ s ḣ.
   pure subroutine turn_wheels(system, window_time, motion, inner)
      type(system_t), intent(in) :: system
      !> Time that decides which motors act, s.
      real(wp), intent(in) :: window_time
      type(motion_t), intent(inout) :: motion
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: inner(3)
      real(wp) :: speed, window(2), q(4)
      integer :: i
      inner = 0.0_wp
      motion%inner_power = 0.0_wp
      q = (1/quat_norm(motion%state%q))*motion%state%q
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i), rate => motion%wheel_rate(i))
            speed = wheel%speed_of(motion%state%wheel_momentum(i), motion%omega)
            rate = -wheel%friction*speed
            if (wheel%is_driven(window_time)) then
               window = wheel%drive_window(window_time)
               rate = rate + wheel%drive(min(max(motion%state%t, window(1)), window(2)), q, motion%relative)
            end if
            motion%inner_power = motion%inner_power + rate*speed
         end associate
      end do
      associate (first => system%effects%n_reaction_wheels + 1, last => system%effects%n_wheels)
         call add_gyration(motion%state%wheel_momentum(first:last), motion%omega, motion%wheel_rate(first:last))
      end associate
      do i = 1, system%effects%n_wheels
         inner = inner + motion%wheel_rate(i)*system%effects%wheels(i)%axis
      end do
   end subroutine turn_wheels

   !> Returns the state a time later along the tangent of a motion: q + q̇h, L + L̇h, and the wheels likewise.
   pure type(state_t) function displaced(motion, h) result(state)
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      !> Time h, s.
      real(wp), intent(in) :: h
      real(wp) :: rate(3)
      rate = cross(motion%momentum, motion%omega) + (motion%potential_torque + motion%torque)
      state%t = motion%state%t + h
      state%wheel_momentum = motion%state%wheel_momentum + h*motion%wheel_rate
      state%q = motion%state%q + (0.5_wp*h)*quat_product(motion%state%q, [0.0_wp, motion%relative])
      ! The first-order change of p = 2 q∘[0, L].
      state%p = quat_vector_product(state%q, 2*(motion%momentum + h*rate))
   end function displaced

end module nutate_motion
