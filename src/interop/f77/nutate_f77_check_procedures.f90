!> Bodies of the procedures whose interfaces are in `nutate_f77_check`.
submodule(nutate_f77_check) nutate_f77_check_procedures
   use nutate_admissible, only: admits, ANY_DIRECTION, ANY_VALUE, NON_NEGATIVE, POSITIVE_OR_INFINITE
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_keys
   use nutate_f77_work, only: continues, is_work
   use nutate_gravity, only: gravity_keys, gravity_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_limits, only: is_moderate, is_step, is_unit, manifold_tolerance
   use nutate_quaternion, only: cross
   use nutate_range, only: check_motion, check_step
   use nutate_rotor, only: rotor_keys
   use nutate_status, only: status_t
   implicit none

contains

   module procedure is_attitude
      is_attitude = is_unit(q, 0.5_wp*manifold_tolerance)
   end procedure is_attitude

   module procedure is_rotation
      is_rotation = .false.
      if (.not. all(is_moderate(r))) return
      if (maxval(abs(matmul(transpose(r), r) - diagonal([1.0_wp, 1.0_wp, 1.0_wp]))) > manifold_tolerance) return
      is_rotation = dot_product(cross(r(:, 1), r(:, 2)), r(:, 3)) > 0.0_wp
   end procedure is_rotation

   module procedure is_motion
      type(status_t) :: status
      call check_motion(system, state, status)
      is_motion = status%ok()
   end procedure is_motion

   module procedure work_fault
      info = -number
      if (.not. is_work(work, lwork)) return
      info = merge(-number - 1, 0, lwork < int(work(1)))
   end procedure work_fault

   module procedure check_setup
      type(status_t) :: status
      bad = 0
      if (.not. admits(ANY_VALUE, reshape(tensor, [9]))) then
         bad = 1
      else if (.not. (is_left_out(j0) .or. admits(POSITIVE_OR_INFINITE, [j0]))) then
         bad = 2
      else if (.not. admits(rotor_keys(1)%range, setup%rotor)) then
         bad = 3
      else if (.not. admits(ANY_VALUE, setup%moment)) then
         bad = 4
      else if (.not. admits(gravity_keys(1)%range, setup%gravity)) then
         bad = 5
      else if (.not. admits(damping_keys(1)%range, setup%damping)) then
         bad = 6
      else if (.not. admits(merge(ANY_DIRECTION, ANY_VALUE, mod(setup%callbacks, 2) == 1), setup%direction)) then
         bad = 7
      else
         bad = find_bad_form(setup)
      end if
      if (bad /= 0) return
      if (.not. is_moderate_weight(setup)) then
         bad = 5
         return
      end if
      if (j0 > 0.0_wp .and. j0 <= huge(j0)) setup%inverse_j0 = 1/j0
      call make_body(tensor, setup%body, status)
      if (.not. status%ok()) bad = 1
   end procedure check_setup

   module procedure find_bad_form
      bad = 0
      if (all(setup%solver /= [1, 2])) then
         bad = 8
      else if (all(setup%order /= [2, 4, 6, 8])) then
         bad = 9
      else if (setup%callbacks < 0 .or. setup%callbacks > 3) then
         bad = 10
      end if
   end procedure find_bad_form

   module procedure find_bad_bound
      do bad = 1, size(bounds)
         if (.not. admits(NON_NEGATIVE, bounds(bad:bad))) return
      end do
      bad = 0
   end procedure find_bad_bound

   !> Returns true if J0 <= 0, which stands for infinity.
   pure logical function is_left_out(j0)
      real(wp), intent(in) :: j0
      is_left_out = is_moderate(j0)
      if (is_left_out) is_left_out = j0 <= 0.0_wp
   end function is_left_out

   !> Returns true if energy and torque of gravity are within the limits.
   pure logical function is_moderate_weight(setup)
      type(setup_t), intent(in) :: setup
      type(gravity_t) :: gravity
      gravity%moment = setup%moment
      gravity%direction = setup%gravity
      is_moderate_weight = gravity%is_valid()
   end function is_moderate_weight

   module procedure find_bad_step
      type(status_t) :: status
      bad = 0
      if (n < 0) then
         bad = 1
      else if (.not. is_step(dt)) then
         bad = 2
      else if (continues(work, t, q, p)) then
         bad = 0
      else if (.not. is_moderate(t)) then
         bad = 3
      else if (.not. is_attitude(q)) then
         bad = 4
      else if (.not. all(is_moderate(p))) then
         bad = 5
      else
         ! The reduced formulation requires q·p = 0.
         if (body%setup%solver == 1 .and. abs(dot_product(q, p)) > manifold_tolerance*norm2(p)) bad = 5
         if (.not. is_motion(body%system, state_t(t=t, q=q, p=p))) bad = 5
         if (bad == 0) call check_step(body%system, state_t(t=t, q=q, p=p), dt, status)
         ! If the body rotates too far, the larger one of rate and step is wrong.
         if (bad == 0 .and. .not. status%ok()) bad = merge(2, 5, abs(dt) >= maxval(abs(angular_velocity(body%system, &
            state_t(t=t, q=q, p=p)))))
      end if
   end procedure find_bad_step

end submodule nutate_f77_check_procedures
