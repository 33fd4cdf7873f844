!> Tests of the arguments of the FORTRAN 77 routines: each finds the first that is wrong.
module nutate_f77_check
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_body, only: diagonal, make_body
   use nutate_f77_work, only: get_place, get_setup, is_work, place_t, setup_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_norm
   use nutate_status, only: status_t
   implicit none
   private

   public :: is_usable, is_attitude, is_rotation, check_setup, find_bad_step, is_ready

   !> Largest number that is taken, in SI units: its square and that of a product of two can be computed.
   real(wp), parameter :: largest = 1e100_wp
   !> Largest |qᵀq - 1| of a quaternion that is meant to be an attitude, and largest |q·p|/|p| that counts as zero.
   real(wp), parameter :: unit_tolerance = 1e-9_wp

contains

   !> Finite, and not so large that its square is not.
   elemental logical function is_usable(x)
      real(wp), intent(in) :: x
      is_usable = .false.
      if (ieee_is_finite(x)) is_usable = abs(x) <= largest
   end function is_usable

   !> A quaternion of unit length.
   pure logical function is_attitude(q)
      !> Shape (4).
      real(wp), intent(in) :: q(4)
      is_attitude = .false.
      if (all(is_usable(q))) is_attitude = abs(quat_norm(q)**2 - 1) <= unit_tolerance
   end function is_attitude

   !> An orthogonal matrix of determinant 1.
   pure logical function is_rotation(r)
      !> Shape (3,3).
      real(wp), intent(in) :: r(3, 3)
      is_rotation = .false.
      if (.not. all(is_usable(r))) return
      if (maxval(abs(matmul(transpose(r), r) - diagonal([1.0_wp, 1.0_wp, 1.0_wp]))) > unit_tolerance) return
      is_rotation = dot_product(cross(r(:, 1), r(:, 2)), r(:, 3)) > 0.0_wp
   end function is_rotation

   !> The array holds what NUINIT wrote, in the length that it needs. 0, 1 if it is not that of NUINIT, 2 if too short.
   pure integer function is_ready(work, lwork)
      real(wp), intent(in) :: work(*)
      integer, intent(in) :: lwork
      is_ready = 1
      if (.not. is_work(work, lwork)) return
      is_ready = 0
      if (lwork < int(work(1))) is_ready = 2
   end function is_ready

   !> The number of the argument of NUINIT that is wrong, 0 if none is; sets body and 1/J0.
   pure subroutine check_setup(setup, tensor, j0, bad)
      type(setup_t), intent(inout) :: setup
      !> Inertia tensor, body axes, kg m²; J0, kg m².
      real(wp), intent(in) :: tensor(3, 3), j0
      integer, intent(out) :: bad
      type(status_t) :: status
      bad = 0
      if (.not. all(is_usable(tensor))) then
         bad = 1
      else if (maxval(abs(tensor)) < 1/largest) then
         bad = 1
      else if (.not. is_usable(j0)) then
         bad = 2
      else if (j0 > 0.0_wp .and. j0 < 1/largest) then
         bad = 2
      else if (.not. all(is_usable(setup%rotor))) then
         bad = 3
      else if (.not. all(is_usable(setup%moment))) then
         bad = 4
      else if (.not. all(is_usable(setup%gravity))) then
         bad = 5
      else if (.not. all(is_usable(setup%damping))) then
         bad = 6
      else if (.not. all(is_usable(setup%direction))) then
         bad = 7
      else if (mod(setup%callbacks, 2) == 1 .and. all(setup%direction == 0.0_wp)) then
         bad = 7
      else if (all(setup%solver /= [1, 2])) then
         bad = 8
      else if (all(setup%order /= [2, 4, 6, 8])) then
         bad = 9
      else if (setup%callbacks < 0 .or. setup%callbacks > 3) then
         bad = 10
      end if
      if (bad /= 0) return
      if (j0 > 0.0_wp) setup%inverse_j0 = 1/j0
      call make_body(tensor, setup%body, status, check_triangle=.false.)
      if (.not. status%ok()) bad = 1
   end subroutine check_setup

   !> The number of the first of N, DT, T, Q, P that is wrong, 0 if none is. What the last call left is not tested.
   integer function find_bad_step(n, dt, t, q, p, work) result(bad)
      integer, intent(in) :: n
      real(wp), intent(in) :: dt, t, q(4), p(4)
      !> From NUINIT, whole.
      real(wp), intent(in), target, contiguous :: work(:)
      type(setup_t) :: setup
      type(place_t) :: place
      bad = 0
      call get_place(work, place)
      if (n < 0) then
         bad = 1
      else if (.not. is_usable(dt)) then
         bad = 2
      else if (abs(dt) < 1/largest) then
         bad = 2
      else if (place%continues_at(t, q, p)) then
         bad = 0
      else if (.not. is_usable(t)) then
         bad = 3
      else if (.not. is_attitude(q)) then
         bad = 4
      else if (.not. all(is_usable(p))) then
         bad = 5
      else
         call get_setup(work, setup)
         ! The reduced form has no q·p.
         if (setup%solver == 1 .and. abs(dot_product(q, p)) > unit_tolerance*norm2(p)) bad = 5
      end if
   end function find_bad_step

end module nutate_f77_check
