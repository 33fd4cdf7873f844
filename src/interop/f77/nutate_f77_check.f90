!> Tests of the arguments of the FORTRAN 77 routines: each finds the first that is wrong.
module nutate_f77_check
   use nutate_admissible, only: admits, ANY_DIRECTION, ANY_VALUE, NON_NEGATIVE, POSITIVE_OR_INFINITE
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_keys
   use nutate_f77_prepared, only: f77_body_t
   use nutate_f77_work, only: continues, is_work, setup_t
   use nutate_gravity, only: gravity_keys, gravity_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate, is_step, is_unit, manifold_tolerance
   use nutate_quaternion, only: cross
   use nutate_range, only: check_motion, check_step
   use nutate_rotor, only: rotor_keys
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: is_attitude, is_rotation, is_motion, check_setup, find_bad_bound, find_bad_form, find_bad_step, work_fault

contains

   !> Returns true for a quaternion of unit length, |qᵀq - 1| within the tolerance of a state; none is normalised
   !> here.
   pure logical function is_attitude(q)
      !> Quaternion; shape (4).
      real(wp), intent(in) :: q(4)
      is_attitude = is_unit(q, 0.5_wp*manifold_tolerance)
   end function is_attitude

   !> Returns true for an orthogonal matrix of determinant 1.
   pure logical function is_rotation(r)
      !> Matrix; shape (3,3).
      real(wp), intent(in) :: r(3, 3)
      is_rotation = .false.
      if (.not. all(is_moderate(r))) return
      if (maxval(abs(matmul(transpose(r), r) - diagonal([1.0_wp, 1.0_wp, 1.0_wp]))) > manifold_tolerance) return
      is_rotation = dot_product(cross(r(:, 1), r(:, 2)), r(:, 3)) > 0.0_wp
   end function is_rotation

   !> Returns true for a state that `check_motion` accepts.
   logical function is_motion(system, state)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(status_t) :: status
      call check_motion(system, state, status)
      is_motion = status%ok()
   end function is_motion

   !> Returns INFO for the argument WORK: 0 if NUINIT has filled it and it is long enough, -number if NUINIT has not
   !> filled it, -(number + 1), the argument LWORK, if it is too short.
   pure integer function work_fault(work, lwork, number) result(info)
      real(wp), intent(in) :: work(*)
      integer, intent(in) :: lwork
      !> Number of the argument WORK; LWORK is the next.
      integer, intent(in) :: number
      info = -number
      if (.not. is_work(work, lwork)) return
      info = merge(-number - 1, 0, lwork < int(work(1)))
   end function work_fault

   !> Finds the number of the argument of NUINIT that is wrong, 0 if none is; sets body and 1/J0.
   pure subroutine check_setup(setup, tensor, j0, bad)
      type(setup_t), intent(inout) :: setup
      !> Inertia tensor, body axes, kg m²; J0, kg m².
      real(wp), intent(in) :: tensor(3, 3), j0
      integer, intent(out) :: bad
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
   end subroutine check_setup

   !> Returns the number of the first of IFORM, IORDER and ICALL that is wrong, 0 if none is.
   pure integer function find_bad_form(setup) result(bad)
      type(setup_t), intent(in) :: setup
      bad = 0
      if (all(setup%solver /= [1, 2])) then
         bad = 8
      else if (all(setup%order /= [2, 4, 6, 8])) then
         bad = 9
      else if (setup%callbacks < 0 .or. setup%callbacks > 3) then
         bad = 10
      end if
   end function find_bad_form

   !> Returns the number of the first bound that is wrong, 0 if none is.
   pure integer function find_bad_bound(bounds) result(bad)
      !> Bounds; shape (any).
      real(wp), intent(in) :: bounds(:)
      do bad = 1, size(bounds)
         if (.not. admits(NON_NEGATIVE, bounds(bad:bad))) return
      end do
      bad = 0
   end function find_bad_bound

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

   !> Returns the number of the first of N, DT, T, Q, P that is wrong, 0 if none is. The results of the last call are
   !> not tested.
   integer function find_bad_step(n, dt, t, q, p, body, work) result(bad)
      integer, intent(in) :: n
      real(wp), intent(in) :: dt, t, q(4), p(4)
      !> Body of `work`.
      type(f77_body_t), intent(in) :: body
      !> Work array from NUINIT.
      real(wp), intent(in) :: work(*)
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
   end function find_bad_step

end module nutate_f77_check
