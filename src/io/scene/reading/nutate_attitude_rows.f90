!> Attitudes by time, as other programs exchange them, and the motion between them.
module nutate_attitude_rows
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_attitude_between, only: cubic_between, shorter_log
   use nutate_decimal, only: rounded_text
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: half_turn
   use nutate_quaternion, only: attitude_distance, quat_conjugate, quat_norm, quat_product, rotate_to_body
   use nutate_scene_labels, only: labels_t
   implicit none
   private

   public :: attitude_rows_t, between_rows, gap_fault, is_unit, put_in_order, to_inertial_axes, turn_rates

   !> Attitudes by time.
   type :: attitude_rows_t
      !> Epoch of t = 0, names of body and axes.
      type(labels_t) :: labels
      !> s, ascending; shape (n).
      real(wp), allocatable :: t(:)
      !> Unit quaternions, body to space, scalar first; shape (4, n).
      real(wp), allocatable :: q(:, :)
      !> The space axes are those of a rotating frame, which inertial axes must not name.
      logical :: rotates = .false.
      !> The space axes are the inertial ones of an orbit, which rotating axes must not name.
      logical :: on_orbit = .false.
      !> Ω relative to the space axes, body axes, rad/s; shape (3, n). Not allocated if rates are not known.
      real(wp), allocatable :: omega(:, :)
      !> Number of the segment of each row, 1, 2, ..., between which there is no motion: a message may have gaps, and
      !> attitudes that jump; shape (n). Not allocated: one segment.
      integer, allocatable :: segments(:)
      !> Line of the file for each row; shape (n). Not allocated for rows that were not read from a file.
      integer, allocatable :: lines(:)
   contains
      !> Returns the number of rows.
      procedure :: count => count_rows
   end type attitude_rows_t

contains

   !> Returns the number of rows.
   pure integer function count_rows(self)
      class(attitude_rows_t), intent(in) :: self
      count_rows = 0
      if (allocated(self%t)) count_rows = size(self%t)
   end function count_rows

   !> Returns true for a quaternion whose norm is 1 up to a tolerance. No value of q raises a floating-point exception.
   pure logical function is_unit(q, tolerance)
      real(wp), intent(in) :: q(4), tolerance
      is_unit = .false.
      if (.not. all(ieee_is_finite(q))) return
      if (maxval(abs(q)) > 1 + tolerance) return
      is_unit = abs(quat_norm(q) - 1) <= tolerance
   end function is_unit

   !> Brings the rows of a run back in time into ascending order.
   pure subroutine put_in_order(rows)
      type(attitude_rows_t), intent(inout) :: rows
      integer :: n
      n = rows%count()
      if (n < 2) return
      if (rows%t(n) >= rows%t(1)) return
      rows%t = rows%t(n:1:-1)
      rows%q = rows%q(:, n:1:-1)
      if (allocated(rows%omega)) rows%omega = rows%omega(:, n:1:-1)
   end subroutine put_in_order

   !> Converts the rows of a run in the LVLH frame to inertial axes. Rows in a rotating frame, whose attitude is not
   !> known, stay in it, with rates relative to it.
   pure subroutine to_inertial_axes(rows, effects)
      type(attitude_rows_t), intent(inout) :: rows
      !> Effects of the run, which give the space axes.
      type(effect_list_t), intent(in) :: effects
      integer :: i
      rows%rotates = .not. effects%knows_space_axes()
      rows%on_orbit = effects%on_orbit
      if (rows%rotates) then
         call turn_rates(rows, effects%frame_rate)
      else if (effects%frame_turns) then
         do i = 1, rows%count()
            rows%q(:, i) = quat_product(effects%space_axes(rows%t(i)), rows%q(:, i))
         end do
      end if
   end subroutine to_inertial_axes

   !> Converts absolute angular velocities into those relative to rotating space axes.
   pure subroutine turn_rates(rows, rate)
      type(attitude_rows_t), intent(inout) :: rows
      !> Rate of the space axes, in these, rad/s; shape (3).
      real(wp), intent(in) :: rate(3)
      integer :: i
      if (.not. allocated(rows%omega) .or. all(abs(rate) <= 0.0_wp)) return
      do i = 1, rows%count()
         rows%omega(:, i) = rows%omega(:, i) - rotate_to_body(rows%q(:, i), rate)
      end do
   end subroutine turn_rates

   !> Returns what is wrong with rows that are half a turn or more apart, between which no interpolation holds; empty
   !> for others. Without rates only half a turn shows.
   pure function gap_fault(rows) result(problem)
      type(attitude_rows_t), intent(in) :: rows
      character(len=:), allocatable :: problem
      real(wp) :: h, turn
      integer :: i
      problem = ''
      do i = 1, rows%count() - 1
         h = rows%t(i + 1) - rows%t(i)
         turn = 0.0_wp
         if (allocated(rows%omega)) turn = h*max(norm2(rows%omega(:, i)), norm2(rows%omega(:, i + 1)))
         if (turn < pi .and. attitude_distance(rows%q(:, i), rows%q(:, i + 1)) < half_turn) cycle
         problem = 'the body turns by half a turn or more from one row to the next at t = '//rounded_text(rows%t(i), 6)
         if (turn < pi) then
            problem = problem//' s (expected rows closer together)'
         else
            problem = problem//' s (expected rows up to '//rounded_text(pi*h/turn, 3)//' s apart)'
         end if
         return
      end do
   end function gap_fault

   !> Computes attitude and angular velocity between two rows with rates: `cubic_between`.
   pure subroutine between_rows(rows, i, k, t, q, omega)
      type(attitude_rows_t), intent(in) :: rows
      !> Indices of the two rows.
      integer, intent(in) :: i, k
      !> Time between the times of these rows, s.
      real(wp), intent(in) :: t
      real(wp), intent(out) :: q(4), omega(3)
      real(wp) :: h, turn(3)
      h = rows%t(k) - rows%t(i)
      turn = turn_between(rows%q(:, i), rows%q(:, k), 0.5_wp*(h*rows%omega(:, i) + h*rows%omega(:, k)))
      call cubic_between(rows%q(:, i), turn, rows%omega(:, i), rows%omega(:, k), h, (t - rows%t(i))/h, q, omega)
   end subroutine between_rows

   !> Returns the rotation vector from one attitude to another, with the number of revolutions that is nearest to the
   !> expected rotation vector.
   pure function turn_between(q1, q2, expected) result(phi)
      real(wp), intent(in) :: q1(4), q2(4), expected(3)
      real(wp) :: phi(3), angle
      phi = 2*shorter_log(quat_product(quat_conjugate(q1), q2))
      angle = norm2(phi)
      if (angle > 0.0_wp) then
         phi = phi + phi/angle*2*pi*anint(dot_product(expected - phi, phi/angle)/(2*pi))
      else if (norm2(expected) > pi) then
         phi = expected/norm2(expected)*2*pi*anint(norm2(expected)/(2*pi))
      end if
   end function turn_between

end module nutate_attitude_rows
