!> Moves bodies of several shapes by steps of many lengths and prints the width of a SIMD batch and, to the last bit,
!> their states, for check-lanes.sh.
program bodies_bits
   use nutate_bodies, only: bodies_t, SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE
   use nutate_body, only: body_t, make_body
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   use nutate_status, only: status_t
   implicit none
   integer, parameter :: n = 1003, frames(3) = [SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE]
   real(wp), parameter :: tensors(3, 3, 3) = reshape([ &
      5.0_wp, 0.1_wp, 0.2_wp, 0.1_wp, 20.0_wp, -0.1_wp, 0.2_wp, -0.1_wp, 17.0_wp, &
      2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 3.0_wp, &
      1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1e-6_wp], [3, 3, 3])
   type(bodies_t) :: bodies
   type(body_t) :: classes(3)
   type(status_t) :: status
   real(wp) :: q(4, n), l(3, n), torque(3, n), dt
   integer :: class_of(n), frame, i, state

   do i = 1, size(classes)
      call make_body(tensors(:, :, i), classes(i), status)
      if (.not. status%ok()) error stop 1
   end do
   print '(i0, a)', lanes, ' lanes'
   class_of = [(1 + mod(i, 3), i=1, n)]
   state = 1
   do frame = 1, size(frames)
      call bodies%set_up(classes, status, frames(frame))
      call draw(q)
      do i = 1, n
         q(:, i) = q(:, i)/norm2(q(:, i))
      end do
      call draw(l)
      do i = 1, 24
         call draw(torque)
         ! From steps far below a radian to some that are not certified.
         dt = 1e-4_wp*1.5_wp**i
         call bodies%step(dt, q, l, torque, status, class_of)
         if (.not. status%ok()) error stop 2
      end do
      print '(4z17.16)', q
      print '(3z17.16)', l
   end do

contains

   !> Numbers of -1 to 1 by the generator of Park and Miller, which has the same ones everywhere.
   subroutine draw(x)
      real(wp), intent(out) :: x(:, :)
      integer :: j, k
      do k = 1, size(x, 2)
         do j = 1, size(x, 1)
            state = 16807*mod(state, 127773) - 2836*(state/127773)
            if (state <= 0) state = state + huge(state)
            x(j, k) = 2*(real(state, wp)/huge(state)) - 1
         end do
      end do
   end subroutine draw

end program bodies_bits
