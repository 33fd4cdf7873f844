!> The equations of motion near a state, linearised: ẋ and ∂ẋ/∂x of x = (θ, Ω, ω), θ a rotation vector of the body from
!> the attitude of the state, q∘exp(½θ), Ω its angular velocity, both in body axes, ω the speeds of the wheels relative
!> to the body. The derivatives are those that explicit methods use for sensitivities (`nutate_stage_rates`).
module nutate_linear_rates
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_product
   use nutate_rigid_rates, only: begin_step, n_rates, prepare_rates, rigid_rates_t
   use nutate_small_products, only: times_vector
   use nutate_stage_rates, only: most_numbers, stage_rates_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_NOT_FINITE
   implicit none
   private

   public :: linearize_rates, input_matrix, to_velocities

contains

   !> Computes ẋ and ∂ẋ/∂x. Errors: `NUTATE_NOT_FINITE` if they cannot be represented.
   subroutine linearize_rates(system, state, rates, matrix, status)
      type(system_t), intent(in) :: system
      !> State about which to linearise; the effects act as they do at its time.
      type(state_t), intent(in) :: state
      !> ẋ, whose θ̇ is 0, since θ is relative to the motion; shape (6 + wheels).
      real(wp), intent(out) :: rates(:)
      !> ∂ẋ/∂x; shape (6 + wheels, 6 + wheels).
      real(wp), intent(out) :: matrix(:, :)
      type(status_t), intent(out) :: status
      type(rigid_rates_t) :: rigid
      type(stage_rates_t) :: stage
      real(wp) :: y(most_numbers), dt
      integer :: n_wheels
      n_wheels = system%effects%n_wheels
      ! The space axes rotate by less than 1 rad in a step of this length.
      dt = 1/(1 + norm2(system%effects%frame_rate))
      call prepare_rates(rigid, system, .true., .false.)
      call begin_step(rigid, system, state, dt, state%t, y(1:n_rates))
      y(n_rates + 1:n_rates + n_wheels) = state%wheel_momentum(:n_wheels)
      stage%works = system%effects%n_torques + n_wheels > 0
      stage%n = merge(n_rates, n_rates - 1, stage%works) + n_wheels
      stage%to_angle = rigid%to_angle
      call stage%evaluate(rigid, system, 0.0_wp, y)
      rates = 0.0_wp
      rates(4:6) = stage%rate(5:7)/dt
      rates(7:) = stage%rate(9:8 + n_wheels)/dt
      call read_columns(system, stage, y(1:4), angular_velocity(system, state), dt, matrix)
      call to_velocities(system, rates)
      if (rigid%failure == 0 .and. all(abs(rates) <= huge(1.0_wp)) .and. all(abs(matrix) <= huge(1.0_wp))) return
      status = fail(NUTATE_NOT_FINITE, 'the linearised motion cannot be represented by numbers')
   end subroutine linearize_rates

   !> Computes ∂ẋ/∂x from the derivatives of L̇ and ḣ by q, L and h, and θ̇ = θ×Ω + δΩ.
   subroutine read_columns(system, stage, q, omega, dt, matrix)
      type(system_t), intent(in) :: system
      !> Stage rates, evaluated.
      type(stage_rates_t), intent(in) :: stage
      !> Attitude, shape (4); Ω, body axes, rad/s, shape (3); length of the step, s.
      real(wp), intent(in) :: q(4), omega(3), dt
      real(wp), intent(out) :: matrix(:, :)
      real(wp) :: unit(3), change(most_numbers)
      integer :: i, k, n_wheels
      n_wheels = system%effects%n_wheels
      matrix = 0.0_wp
      do k = 1, 6 + n_wheels
         change = 0.0_wp
         unit = 0.0_wp
         if (k <= 6) unit(modulo(k - 1, 3) + 1) = 1.0_wp
         if (k <= 3) then
            change(1:4) = 0.5_wp*quat_product(q, [0.0_wp, unit])
            matrix(1:3, k) = cross(unit, omega)
         else
            if (k <= 6) then
               change(5:7) = times_vector(system%body%inertia, unit)
               matrix(1:3, k) = unit
            end if
            do i = 1, n_wheels
               associate (wheel => system%effects%wheels(i))
                  change(8 + i) = wheel%inertia*dot_product(wheel%axis, unit)
                  if (k == 6 + i) change(8 + i) = wheel%inertia
                  change(5:7) = change(5:7) + change(8 + i)*wheel%axis
               end associate
            end do
         end if
         associate (by => stage%jacobian(:stage%n, :stage%n), c => change(:stage%n))
            matrix(4:6, k) = matmul(by(5:7, :), c)/dt
            if (n_wheels > 0) matrix(7:, k) = matmul(by(9:, :), c)/dt
         end associate
         call to_velocities(system, matrix(:, k))
      end do
   end subroutine read_columns

   !> Changes the rates, or changes, of L and of the wheels' momenta into those of Ω and of the wheels' speeds.
   pure subroutine to_velocities(system, x)
      type(system_t), intent(in) :: system
      !> (θ, L, h) on entry, (θ, Ω, ω) on return; shape (6 + wheels).
      real(wp), intent(inout) :: x(:)
      integer :: i
      do i = 1, system%effects%n_wheels
         x(4:6) = x(4:6) - x(6 + i)*system%effects%wheels(i)%axis
      end do
      x(4:6) = times_vector(system%body%inverse_inertia, x(4:6))
      do i = 1, system%effects%n_wheels
         associate (wheel => system%effects%wheels(i))
            x(6 + i) = x(6 + i)/wheel%inertia - dot_product(wheel%axis, x(4:6))
         end associate
      end do
   end subroutine to_velocities

   !> Computes ∂ẋ/∂u: torques about the body axes, then the motors of some wheels.
   pure subroutine input_matrix(system, motors, matrix)
      type(system_t), intent(in) :: system
      !> Indices of the wheels of the motors; shape (motors).
      integer, intent(in) :: motors(:)
      !> Shape (6 + wheels, 3 + motors).
      real(wp), intent(out) :: matrix(:, :)
      integer :: k
      matrix = 0.0_wp
      do k = 1, 3
         matrix(3 + k, k) = 1.0_wp
      end do
      do k = 1, size(motors)
         matrix(6 + motors(k), 3 + k) = 1.0_wp
      end do
      do k = 1, 3 + size(motors)
         call to_velocities(system, matrix(:, k))
      end do
   end subroutine input_matrix

end module nutate_linear_rates
