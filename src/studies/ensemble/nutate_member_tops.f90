!> Members of an ensemble that are tops, which `nutate_tops` runs several at a time: which ones, and their states.
module nutate_member_tops
   use nutate_attitude, only: quat_from_matrix, quat_to_third_axis
   use nutate_axial_frame, only: axial_frame_t
   use nutate_hamiltonian, only: angular_velocity, make_state
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tops, only: top_t
   implicit none
   private

   public :: find_top, state_of_top

   !> Largest energy, J, and moment, kg m², whose squares and quotients are far from overflow; 1 over it is the least.
   real(wp), parameter :: widest = 1e60_wp

contains

   !> Finds the top that a member is: an asymmetric body in a single potential that is linear in a fixed direction.
   subroutine find_top(system, start, top, is_top)
      !> System and first state of the member.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      !> Its end time is not set.
      type(top_t), intent(out) :: top
      logical, intent(out) :: is_top
      type(axial_frame_t) :: axial
      real(wp) :: length, energy
      is_top = .false.
      associate (body => system%body, effects => system%effects)
         if (effects%n_potentials /= 1 .or. effects%n_off + effects%n_torques + effects%n_rotors > 0) return
         if (effects%frame_turns .or. effects%moves .or. effects%varies .or. effects%on_orbit) return
         call axial%recognise(system)
         if (axial%axis > 0) return
         select type (potential => effects%potentials(1)%item)
         class is (linear_potential_t)
            length = norm2(potential%direction)
            if (.not. length > 0.0_wp) return
            top%moments = body%moments
            ! e is along the direction or opposite to it.
            top%moment = sign(length, potential%direction(3))*matmul(potential%moment, body%axes)
            top%omega = matmul(angular_velocity(system, start), body%axes)
            top%q = quat_product(quat_to_third_axis(potential%direction/length), &
                                 quat_product(start%q, quat_from_matrix(body%axes)))
            top%q = top%q/norm2(top%q)
            energy = norm2(top%moment) + dot_product(top%moments, top%omega**2)
            is_top = all([energy, minval(top%moments)] > 1/widest) .and. all([energy, maxval(top%moments)] < widest)
         end select
      end associate
      top%t = start%t
   end subroutine find_top

   !> Returns the state of a member after the run of its top.
   type(state_t) function state_of_top(system, top) result(state)
      !> System of the member.
      type(system_t), intent(in) :: system
      type(top_t), intent(in) :: top
      real(wp) :: direction(3), q(4)
      direction = system%effects%potentials(1)%item%direction
      q = quat_product(quat_conjugate(quat_to_third_axis(direction/norm2(direction))), &
                       quat_product(top%q, quat_conjugate(quat_from_matrix(system%body%axes))))
      state = make_state(system, q/norm2(q), matmul(system%body%axes, top%omega), top%t)
   end function state_of_top

end module nutate_member_tops
