!> A frame that is read from a file: its attitude at some times, and between them. Columns and events refer to it; it
!> does not act on the body.
module nutate_moving_frame
   use nutate_attitude_between, only: cubic_between, shorter_log
   use nutate_kinds, only: wp
   use nutate_limits, only: half_turn
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_norm, quat_normalized, quat_product, rotate_to_body
   implicit none
   private

   public :: moving_frame_t, make_frame
   public :: angle_rate, find_frame, has_time, quaternion_rate, see_from_frame

   !> Largest extension of a frame beyond its ends, s: beyond the rounding of dates.
   real(wp), parameter :: longest_slack = 1e-6_wp

   !> A frame; `make_frame` makes one.
   type :: moving_frame_t
      !> Times, s, ascending; shape (n), n at least 2.
      real(wp), allocatable :: t(:)
      !> Unit quaternions, frame to space, scalar first, without jumps of the sign; shape (4, n).
      real(wp), allocatable :: q(:, :)
      !> Angular velocity of the frame relative to the space axes, axes of the frame, rad/s; shape (3, n). Not allocated
      !> if rates are not known: they are then constant between two times.
      real(wp), allocatable :: omega(:, :)
      !> Largest rate at these times, rad/s; no rate between them is much greater.
      real(wp) :: fastest = 0.0_wp
      !> Rotation vector from each attitude to the next, axes of the frame, rad; shape (3, n - 1).
      real(wp), allocatable, private :: turn(:, :)
   end type moving_frame_t

contains

   !> Makes a frame from attitudes at two or more times.
   pure subroutine make_frame(numbers, frame, far)
      !> Times t, s, ascending; quaternions of any length, frame to space; and angular velocities, if they are known;
      !> shape (5 or 8, n).
      real(wp), intent(in) :: numbers(:, :)
      type(moving_frame_t), intent(out) :: frame
      !> Index of the first attitude from which the next is half a revolution or more away; 0: none.
      integer, intent(out) :: far
      real(wp) :: h, angle, rate
      integer :: i, n
      n = size(numbers, 2)
      frame%t = numbers(1, :)
      frame%q = numbers(2:5, :)
      if (size(numbers, 1) > 5) frame%omega = numbers(6:8, :)
      allocate (frame%turn(3, n - 1))
      far = 0
      do i = 1, n
         frame%q(:, i) = quat_normalized(frame%q(:, i))
         if (i == 1) cycle
         if (dot_product(frame%q(:, i - 1), frame%q(:, i)) < 0.0_wp) frame%q(:, i) = -frame%q(:, i)
         h = frame%t(i) - frame%t(i - 1)
         frame%turn(:, i - 1) = 2*shorter_log(quat_product(quat_conjugate(frame%q(:, i - 1)), frame%q(:, i)))
         angle = norm2(frame%turn(:, i - 1))
         rate = angle/h
         if (allocated(frame%omega)) then
            rate = max(rate, norm2(frame%omega(:, i - 1)), norm2(frame%omega(:, i)))
            angle = max(angle, h*rate)
         end if
         frame%fastest = max(frame%fastest, rate)
         if (angle >= half_turn .and. far == 0) far = i - 1
      end do
   end subroutine make_frame

   !> Returns true for a time at which the attitude is known.
   pure logical function has_time(self, t)
      type(moving_frame_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      has_time = t >= self%t(1) - slack(self, 1) .and. t <= self%t(size(self%t)) + slack(self, size(self%t) - 1)
   end function has_time

   !> Returns how far beyond one of its ends a frame is extended, s.
   pure real(wp) function slack(frame, i)
      type(moving_frame_t), intent(in) :: frame
      !> Index of the first time of the interval at this end.
      integer, intent(in) :: i
      slack = min(longest_slack, frame%t(i + 1) - frame%t(i))
   end function slack

   !> Computes attitude and angular velocity at a time. With angular velocities the rotation vector from one known
   !> attitude to the next is a cubic polynomial that has both; without them the rate is constant. Beyond its ends the
   !> frame does not rotate.
   pure subroutine find_frame(self, t, q, omega)
      type(moving_frame_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Unit quaternion, frame to space; rad/s, axes of the frame.
      real(wp), intent(out) :: q(4), omega(3)
      real(wp) :: h, s
      integer :: i
      i = place_of(self%t, t)
      h = self%t(i + 1) - self%t(i)
      s = (min(max(t, self%t(i) - slack(self, i)), self%t(i + 1) + slack(self, i)) - self%t(i))/h
      if (allocated(self%omega)) then
         call cubic_between(self%q(:, i), self%turn(:, i), self%omega(:, i), self%omega(:, i + 1), h, s, q, omega)
      else
         q = quat_normalized(quat_product(self%q(:, i), quat_exp(0.5_wp*s*self%turn(:, i))))
         omega = self%turn(:, i)/h
      end if
      if (.not. has_time(self, t)) omega = 0.0_wp
   end subroutine find_frame

   !> Returns the interval of a time: the first or the last one for a time beyond the ends.
   pure integer function place_of(times, t) result(i)
      real(wp), intent(in) :: times(:), t
      integer :: last, middle
      i = 1
      last = size(times)
      do while (last - i > 1)
         middle = i + (last - i)/2
         if (t >= times(middle)) then
            i = middle
         else
            last = middle
         end if
      end do
   end function place_of

   !> Computes an attitude relative to the frame, a quaternion from body axes to those of the frame, and its angle.
   pure subroutine see_from_frame(self, t, q, from_frame, angle)
      type(moving_frame_t), intent(in) :: self
      !> Time, s; attitude, body to space, shape (4).
      real(wp), intent(in) :: t, q(4)
      !> Quaternion of the length of q, body axes to frame; angle, rad, 0 to π.
      real(wp), intent(out) :: from_frame(4), angle
      real(wp) :: axes(4), omega(3)
      call find_frame(self, t, axes, omega)
      from_frame = quat_product(quat_conjugate(axes), q)
      angle = 2*atan2(norm2(from_frame(2:4)), abs(from_frame(1)))
   end subroutine see_from_frame

   !> Returns the rate of the angle of an attitude relative to the frame, rad/s. An angle of zero grows.
   pure real(wp) function angle_rate(self, t, q, omega) result(rate)
      type(moving_frame_t), intent(in) :: self
      !> Time, s; attitude, body to space, shape (4); angular velocity relative to the space axes, body axes, rad/s,
      !> shape (3).
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: from_frame(4), spin(3), sine
      call see(self, t, q, omega, from_frame, spin)
      sine = norm2(from_frame(2:4))
      rate = norm2(spin)
      if (sine > 0.0_wp) rate = sign(1.0_wp, from_frame(1))*dot_product(spin, from_frame(2:4)/sine)
   end function angle_rate

   !> Returns the rate of the quaternion of an attitude relative to the frame, 1/s; shape (4).
   pure function quaternion_rate(self, t, q, omega) result(rate)
      type(moving_frame_t), intent(in) :: self
      !> Time, attitude and angular velocity as in `angle_rate`.
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: rate(4), from_frame(4), spin(3)
      call see(self, t, q, omega, from_frame, spin)
      rate = quat_product(from_frame, [0.0_wp, 0.5_wp*spin])
   end function quaternion_rate

   !> Computes the attitude relative to the frame, and the angular velocity relative to it, body axes, rad/s.
   pure subroutine see(frame, t, q, omega, from_frame, spin)
      type(moving_frame_t), intent(in) :: frame
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: from_frame(4), spin(3)
      real(wp) :: axes(4), axes_rate(3)
      call find_frame(frame, t, axes, axes_rate)
      from_frame = quat_product(quat_conjugate(axes), q)
      spin = omega - rotate_to_body((1/quat_norm(q))*from_frame, axes_rate)
   end subroutine see

end module nutate_moving_frame
