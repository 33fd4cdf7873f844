!> Disturbs a motion: the effect of errors of its data and of its initial state shows how it amplifies round-off.
module nutate_disturbance
   use nutate_hamiltonian, only: angular_velocity, body_momentum, make_state, system_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_quaternion, only: quat_norm, quat_product
   use nutate_small_products, only: is_symmetric_about
   use nutate_state, only: state_t
   implicit none
   private

   public :: disturb_problem, disturb_state

contains

   !> Adds noise η to a system and a state: to J⁻¹ and the principal moments, to the attitude (rad), and to the angular
   !> velocity, relative to its size and in any direction.
   pure subroutine disturb_problem(noise, system, state)
      type(noise_t), intent(inout) :: noise
      type(system_t), intent(inout) :: system
      type(state_t), intent(inout) :: state
      real(wp) :: turn(3), change(3), omega(3), q(4), part(3, 3)
      type(state_t) :: wheels
      integer :: i
      call noise%vector(turn)
      call noise%vector(change)
      do i = 1, 3
         call noise%vector(part(:, i))
      end do
      omega = angular_velocity(system, state)
      omega = omega + (noise%amplitude*norm2(omega)/norm2(change))*change
      q = quat_product(state%q, [1.0_wp, 0.5_wp*turn])
      wheels = state
      state = make_state(system, q/quat_norm(q), omega, state%t, [(system%effects%wheels(i)%speed_of( &
                         wheels%wheel_momentum(i), omega), i=1, system%effects%n_wheels)])
      state%wheel_work = wheels%wheel_work
      state%time_dependent_work = wheels%time_dependent_work
      state%time_dependent_until = wheels%time_dependent_until
      part = 0.5_wp*(part + transpose(part))
      call keep_symmetry(system%body%inverse_inertia, part)
      system%body%inverse_inertia = (1 + part)*system%body%inverse_inertia
      ! Mounted wheels tell whether the inertia is theirs.
      if (system%effects%varies .and. system%effects%n_wheels == 0) system%body%inertia = (1 - part)*system%body%inertia
      do i = 1, 3
         system%body%moments(i) = (1 - part(i, i))*system%body%moments(i)
      end do
   end subroutine disturb_problem

   !> Adds noise η to a state: a rotation by η about each axis, η|L| to each component of L.
   pure subroutine disturb_state(noise, state)
      type(noise_t), intent(inout) :: noise
      type(state_t), intent(inout) :: state
      real(wp) :: turn(3), change(3), momentum(3)
      call noise%vector(turn)
      call noise%vector(change)
      momentum = body_momentum(state)
      momentum = momentum + quat_norm([0.0_wp, momentum])*change
      state%q = quat_product(state%q, [1.0_wp, 0.5_wp*turn])
      state%q = state%q/quat_norm(state%q)
      state%p = 2*quat_product(state%q, [0.0_wp, momentum])
   end subroutine disturb_state

   !> Makes the noise of equal moments equal: a symmetric body stays symmetric, so methods that exploit the symmetry
   !> still do.
   pure subroutine keep_symmetry(inverse_inertia, part)
      real(wp), intent(in) :: inverse_inertia(3, 3)
      !> Relative noise; shape (3,3).
      real(wp), intent(inout) :: part(3, 3)
      integer :: axis, i, j
      do axis = 1, 3
         if (.not. is_symmetric_about(inverse_inertia, axis)) cycle
         i = 1 + modulo(axis, 3)
         j = 1 + modulo(axis + 1, 3)
         part(j, j) = part(i, i)
      end do
   end subroutine keep_symmetry

end module nutate_disturbance
