!> Many bodies whose torques the calling program computes: one call moves all of them by a step.
!>
!> A step is a kick by the torque and a torque-free drift. The drift keeps the kinetic energy of each body to
!> round-off, and its space momentum to the last bit (`nutate_bodies_drift`); the kick changes the momentum by exactly
!> Δt τ. Both are reversible; the kick is symplectic, the drift up to terms of Δt⁵. Steps are of order 2, and the energy
!> of interacting bodies does not drift.
!>
!>     call torques(q, torque)
!>     call bodies%kick(-0.5_wp*dt, q, l, torque, status)      ! l goes half a step behind q, once
!>     do i = 1, n
!>        call bodies%step(dt, q, l, torque, status)           ! l to the next middle, then q to the next end
!>        call torques(q, torque)
!>     end do
!>     call bodies%kick(0.5_wp*dt, q, l, torque, status)       ! l catches up with q
!>
!> A drift whose root is not certified, one of more than some half radian, is replaced by the exact motion. Bodies need
!> no memory between calls. A body with invalid numbers keeps its state, and is listed in `failed`.
module nutate_bodies
   !$ use omp_lib, only: omp_get_max_threads
   use nutate_bodies_drift, only: body_class_t, drift_lanes_t, make_class, put_class
   use nutate_body, only: body_t
   use nutate_drift_avx2, only: drift_by_avx2 => drift_lanes, enter_by_avx2 => enter_lanes, leave_by_avx2 => leave_lanes
   use nutate_drift_sse2, only: drift_by_sse2 => drift_lanes, enter_by_sse2 => enter_lanes, leave_by_sse2 => leave_lanes
   use nutate_exact_free, only: free_body_t
   !$ use nutate_forks, only: may_start_threads
   use nutate_kinds, only: wp, long
   use nutate_lane_width, only: lanes
   use nutate_limits, only: greatest_number, greatest_turn, is_step, manifold_tolerance
   use nutate_principal_frame, only: identity_frame
   use nutate_quaternion, only: rotate_to_body
   use nutate_simd, only: has_avx2
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_NOT_FINITE
   implicit none
   private

   public :: bodies_t, SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE
   public :: move_bodies, movement_t, make_classes

   !> Meaning of `l`: the angular momentum in space axes, with torques in space axes; the angular momentum in body axes,
   !> with torques in body axes; the angular velocity in body axes, with torques in body axes.
   integer, parameter :: SPACE_MOMENTUM = 0, BODY_MOMENTUM = 1, BODY_RATE = 2

   !> Number of bodies after which threads meet, to list the failed ones; number of bodies below which one thread is
   !> faster.
   integer, parameter :: group = 16384, few = 2048
   !> Values for absent arguments.
   real(wp), parameter :: no_torque(3, 0) = reshape([real(wp) ::], [3, 0])
   integer, parameter :: one_class(0) = [integer ::]
   !> Largest ratio of the moments that the exact motion admits.
   real(wp), parameter :: widest_ratio = 1e60_wp

   !> Bodies of one or several classes. Several threads must not use one object at the same time.
   type :: bodies_t
      !> Threads that share the bodies of a call; 0: those of OpenMP (`OMP_NUM_THREADS`). Results are bitwise identical
      !> for any number of threads.
      integer :: threads = 1
      !> Bodies that kept their state in the last call, in ascending order; shape (number of them).
      integer, allocatable :: failed(:)
      type(body_class_t), allocatable, private :: classes(:)
      integer, private :: frame = SPACE_MOMENTUM
   contains
      !> Sets the classes.
      procedure :: set_up
      !> Changes the momenta by an impulse, then moves the bodies by a drift.
      procedure :: step
      !> Changes the momenta alone.
      procedure :: kick
      !> Moves the bodies without torques.
      procedure :: drift
   end type bodies_t

   !> Settings of one call.
   type :: movement_t
      !> Time step, s.
      real(wp) :: dt = 0.0_wp
      logical :: kicks = .false., drifts = .false.
      !> True if each body has a class of its own; else all have the first.
      logical :: classed = .false.
      integer :: frame = SPACE_MOMENTUM, threads = 1
      !> Number of the first class and of the first body: 0 in C.
      integer :: first_number = 1
      !> True if the principal axes of a class are not its body axes.
      logical, private :: rotated = .false.
      !> True if the processor has AVX2.
      logical, private :: avx2 = .false.
   end type movement_t

   !> Lanes of a thread, and the class of the body in each; 0 if there was none yet.
   type, private :: lane_buffer_t
      type(drift_lanes_t) :: lanes
      integer :: held(lanes)
   end type lane_buffer_t

contains

   !> Sets the classes and the meaning of `l`.
   !>
   !> Errors: `NUTATE_BAD_BODY`: a class was not made by `make_body` or `make_shape_body`, or its moments differ by more
   !> than 1e60; `NUTATE_BAD_ARGUMENT`: no class, or no such frame.
   subroutine set_up(self, classes, status, frame)
      class(bodies_t), intent(inout) :: self
      !> Bodies of the classes; shape (number of classes).
      type(body_t), intent(in) :: classes(:)
      type(status_t), intent(out) :: status
      !> `SPACE_MOMENTUM` (default), `BODY_MOMENTUM` or `BODY_RATE`.
      integer, intent(in), optional :: frame
      type(body_class_t), allocatable :: made(:)
      integer :: chosen
      chosen = SPACE_MOMENTUM
      if (present(frame)) chosen = frame
      allocate (made(size(classes)))
      call make_classes(classes, chosen, made, status)
      if (.not. status%ok()) return
      call move_alloc(made, self%classes)
      self%frame = chosen
   end subroutine set_up

   !> Makes classes of bodies, and tests a frame.
   !>
   !> Errors: those of `set_up`.
   pure subroutine make_classes(bodies, frame, classes, status)
      !> Bodies of the classes; shape (number of classes).
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: frame
      type(body_class_t), intent(inout) :: classes(:)
      type(status_t), intent(out) :: status
      integer :: i
      if (size(bodies) < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'there is no class (expected 1 or more)', 'classes')
      else if (all(frame /= [SPACE_MOMENTUM, BODY_MOMENTUM, BODY_RATE])) then
         status = fail(NUTATE_BAD_ARGUMENT, 'no such frame (expected SPACE_MOMENTUM, BODY_MOMENTUM or BODY_RATE)', &
                       'frame')
      end if
      do i = 1, size(bodies)
         if (minval(bodies(i)%moments) > 0.0_wp) then
            if (maxval(bodies(i)%moments)/widest_ratio <= minval(bodies(i)%moments)) cycle
         end if
         status = fail(NUTATE_BAD_BODY, 'principal moments must be positive and within a factor of 1e60', 'classes')
      end do
      if (.not. status%ok()) return
      do i = 1, size(bodies)
         classes(i) = make_class(bodies(i)%moments, bodies(i)%axes)
      end do
   end subroutine make_classes

   !> Moves all bodies by a step: `l` by Δt τ, then `q` by a drift with the new `l`.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT`: `dt` is out of its range, a shape is wrong, or the object is not set up; nothing
   !> has changed. `NUTATE_NOT_FINITE`: the bodies in `failed` have kept their state, all others have moved. A body
   !> fails if a number is not finite or beyond 1e100, |q| is not 1 to 5e-10, it has no class, or it rotates by more
   !> than 1e8 rad.
   subroutine step(self, dt, q, l, torque, status, class_of)
      class(bodies_t), intent(inout) :: self
      !> Time step, s; of either sign, not zero.
      real(wp), intent(in) :: dt
      !> Attitudes, unit quaternions, body to space; shape (4, n).
      real(wp), intent(inout), contiguous :: q(:, :)
      !> Angular momenta half a step behind, kg m²/s, or angular velocities, rad/s; shape (3, n).
      real(wp), intent(inout), contiguous :: l(:, :)
      !> Torques at `q`, N m, in the axes of `l`; shape (3, n).
      real(wp), intent(in), contiguous :: torque(:, :)
      type(status_t), intent(out) :: status
      !> Class of each body; default: the first; shape (n).
      integer, intent(in), contiguous, optional :: class_of(:)
      call move(self, movement_t(dt, .true., .true.), q, l, torque, status, class_of)
   end subroutine step

   !> Changes the momenta by Δt τ, or the angular velocities by Δt J⁻¹τ.
   !>
   !> Errors: those of `step`.
   subroutine kick(self, dt, q, l, torque, status, class_of)
      class(bodies_t), intent(inout) :: self
      !> Time step, s; of either sign, not zero.
      real(wp), intent(in) :: dt
      !> Attitudes, unchanged; a body without a valid one fails as in `step`; shape (4, n).
      real(wp), intent(inout), contiguous :: q(:, :)
      !> Angular momenta, kg m²/s, or angular velocities, rad/s; shape (3, n).
      real(wp), intent(inout), contiguous :: l(:, :)
      !> Torques, N m, in the axes of `l`; shape (3, n).
      real(wp), intent(in), contiguous :: torque(:, :)
      type(status_t), intent(out) :: status
      !> Class of each body; default: the first; shape (n).
      integer, intent(in), contiguous, optional :: class_of(:)
      call move(self, movement_t(dt, .true., .false.), q, l, torque, status, class_of)
   end subroutine kick

   !> Moves the bodies without torques.
   !>
   !> Errors: those of `step`.
   subroutine drift(self, dt, q, l, status, class_of)
      class(bodies_t), intent(inout) :: self
      !> Time step, s; of either sign, not zero.
      real(wp), intent(in) :: dt
      !> Attitudes, unit quaternions, body to space; shape (4, n).
      real(wp), intent(inout), contiguous :: q(:, :)
      !> Angular momenta, kg m²/s, unchanged in space axes, or angular velocities, rad/s; shape (3, n).
      real(wp), intent(inout), contiguous :: l(:, :)
      type(status_t), intent(out) :: status
      !> Class of each body; default: the first; shape (n).
      integer, intent(in), contiguous, optional :: class_of(:)
      call move(self, movement_t(dt, .false., .true.), q, l, no_torque, status, class_of)
   end subroutine drift

   !> Tests the shapes of a call and performs it.
   subroutine move(self, what, q, l, torque, status, class_of)
      type(bodies_t), intent(inout) :: self
      type(movement_t), intent(in) :: what
      real(wp), intent(inout), contiguous :: q(:, :), l(:, :)
      real(wp), intent(in), contiguous :: torque(:, :)
      type(status_t), intent(out) :: status
      integer, intent(in), contiguous, optional :: class_of(:)
      type(movement_t) :: whole
      integer :: n
      n = size(q, 2)
      whole = what
      whole%frame = self%frame
      whole%threads = self%threads
      whole%classed = present(class_of)
      if (.not. allocated(self%classes)) status = fail(NUTATE_BAD_ARGUMENT, 'the bodies are not set up', 'classes')
      if (size(q, 1) /= 4 .or. any(shape(l) /= [3, n])) &
         status = fail(NUTATE_BAD_ARGUMENT, 'wrong shapes (expected q(4,n) and l(3,n))', 'q')
      if (what%kicks) then
         if (any(shape(torque) /= [3, n])) &
            status = fail(NUTATE_BAD_ARGUMENT, 'wrong shape (expected torque(3,n))', 'torque')
      end if
      if (present(class_of)) then
         if (size(class_of) /= n) status = fail(NUTATE_BAD_ARGUMENT, 'wrong shape (expected class_of(n))', 'class_of')
      end if
      if (.not. status%ok()) then
         self%failed = [integer ::]
      else if (present(class_of)) then
         call move_bodies(self%classes, whole, n, q, l, torque, class_of, self%failed, status)
      else
         call move_bodies(self%classes, whole, n, q, l, torque, one_class, self%failed, status)
      end if
   end subroutine move

   !> Moves bodies, a group of them by all threads at a time, and lists those that failed.
   !>
   !> Errors: those of `step`.
   subroutine move_bodies(classes, what, n, q, l, torque, class_of, failed, status)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      integer, intent(in) :: n
      !> Attitudes and `l` of all bodies; shapes (4, n) and (3, n).
      real(wp), intent(inout) :: q(4, n), l(3, n)
      !> Torques, read with kicks; shape (3, n).
      real(wp), intent(in), contiguous :: torque(:, :)
      !> Class of each body, read if each body has a class of its own; shape (n).
      integer, intent(in), contiguous :: class_of(:)
      !> Bodies that failed, in ascending order.
      integer, intent(inout), allocatable :: failed(:)
      type(status_t), intent(out) :: status
      type(movement_t) :: whole
      type(lane_buffer_t) :: buffer
      logical :: bad(group)
      integer :: start, last, k, n_bad, threads, i
      failed = [integer ::]
      if (.not. is_step(what%dt)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the step is out of its range (expected 1e-50 to 1e50 s of either sign)', &
                       'dt')
         return
      end if
      whole = what
      whole%rotated = any([(any(abs(classes(i)%axes - identity_frame) > 0.0_wp), i=1, size(classes))])
      whole%avx2 = has_avx2()
      threads = what%threads
      !$ if (threads < 1) threads = omp_get_max_threads()
      !$ if (threads > 1 .and. n >= few) threads = merge(threads, 1, may_start_threads())
      last = 0
      do while (last < n)
         start = last + 1
         last = start + min(group, n - start + 1) - 1
         n_bad = 0
         !$omp parallel if (n >= few) num_threads(threads) default(shared) private(buffer, k) reduction(+:n_bad)
         buffer%held = 0
         !$omp do schedule(static)
         do k = 0, (last - start)/lanes
            call move_lanes(classes, whole, buffer, start + k*lanes, min(last - start - k*lanes + 1, lanes), n, q, l, &
                            torque, class_of, bad(k*lanes + 1:(k + 1)*lanes))
            n_bad = n_bad + count(bad(k*lanes + 1:(k + 1)*lanes))
         end do
         !$omp end do
         !$omp end parallel
         if (n_bad > 0) &
            failed = [failed, pack([(start - 1 + i, i=1, last - start + 1)], bad(1:last - start + 1))]
      end do
      if (size(failed) > 0) status = describe_failures(failed(1) - 1 + what%first_number, size(failed), n)
   end subroutine move_bodies

   !> Returns the status of a call in which bodies failed.
   pure type(status_t) function describe_failures(first, n_failed, n) result(status)
      !> Number of the first failed body, count of failed bodies, and count of all bodies.
      integer, intent(in) :: first, n_failed, n
      character(len=80) :: text
      write (text, '(i0,a,i0,a,i0)') n_failed, ' of ', n, ' bodies kept their state, the first is ', first
      status = fail(NUTATE_NOT_FINITE, trim(text)//' (expected numbers up to 1e100, |q| = 1 to 5e-10, a class that '// &
                    'exists, at most 1e8 rad in the step)', 'q')
   end function describe_failures

   !> Moves some bodies, at most one for each lane.
   subroutine move_lanes(classes, what, buffer, first, several, n, q, l, torque, class_of, bad)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      !> First body to be moved, count of bodies to be moved, and count of all bodies.
      integer, intent(in) :: first, several, n
      real(wp), intent(inout) :: q(4, n), l(3, n)
      real(wp), intent(in), contiguous :: torque(:, :)
      integer, intent(in), contiguous :: class_of(:)
      !> True for bodies that keep their state; shape (lanes).
      logical, intent(out) :: bad(lanes)
      logical :: full
      bad = .false.
      full = several == lanes
      if (full) call load_all(classes, what, buffer, first, n, q, l, torque, class_of, full)
      if (.not. full) call load_each(classes, what, buffer, first, several, n, q, l, torque, class_of, bad)
      call enter(what, buffer%lanes)
      if (.not. are_within(3*lanes, buffer%lanes%momentum, greatest_number)) &
         call reject_momenta(classes, what, buffer, bad)
      if (what%drifts) then
         call drift_all(what, buffer%lanes)
         if (sum(buffer%lanes%certified) < lanes - 0.5_wp) &
            call move_doubtful(classes, what, buffer, first, several, q, bad)
      end if
      call leave(what, buffer%lanes)
      if (full .and. .not. any(bad)) then
         call store_all(buffer%lanes, what%drifts, first, n, q, l)
      else
         call store_each(buffer%lanes, what%drifts, first, several, n, q, l, bad)
      end if
   end subroutine move_lanes

   !> Converts loaded values to momenta of a drift, with the instructions that the processor has.
   pure subroutine enter(what, block)
      type(movement_t), intent(in) :: what
      type(drift_lanes_t), intent(inout) :: block
      logical :: in_space, rates
      in_space = what%frame == SPACE_MOMENTUM
      rates = what%frame == BODY_RATE
      if (what%avx2) then
         call enter_by_avx2(block, in_space, rates, what%rotated, what%kicks, what%dt)
      else
         call enter_by_sse2(block, in_space, rates, what%rotated, what%kicks, what%dt)
      end if
   end subroutine enter

   !> Moves all lanes, with the instructions that the processor has.
   pure subroutine drift_all(what, block)
      type(movement_t), intent(in) :: what
      type(drift_lanes_t), intent(inout) :: block
      if (what%avx2) then
         call drift_by_avx2(block, what%frame == SPACE_MOMENTUM, what%rotated)
      else
         call drift_by_sse2(block, what%frame == SPACE_MOMENTUM, what%rotated)
      end if
   end subroutine drift_all

   !> Converts momenta to the stored values, with the instructions that the processor has.
   pure subroutine leave(what, block)
      type(movement_t), intent(in) :: what
      type(drift_lanes_t), intent(inout) :: block
      if (what%frame == SPACE_MOMENTUM) return
      if (what%avx2) then
         call leave_by_avx2(block, what%frame == BODY_RATE, what%rotated)
      else
         call leave_by_sse2(block, what%frame == BODY_RATE, what%rotated)
      end if
   end subroutine leave

   !> Fills lanes whose momenta after the impulse are beyond 1e100 with a body at rest, and marks them as bad.
   pure subroutine reject_momenta(classes, what, buffer, bad)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      logical, intent(inout) :: bad(lanes)
      integer :: i
      do i = 1, lanes
         if (are_within(3, buffer%lanes%momentum(i, :), greatest_number)) cycle
         bad(i) = .true.
         call rest(classes, what, buffer, i)
      end do
   end subroutine reject_momenta

   !> Fills all lanes with bodies. `fine` is false if one of them has invalid numbers.
   pure subroutine load_all(classes, what, buffer, first, n, q, l, torque, class_of, fine)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: first, n
      real(wp), intent(in) :: q(4, n), l(3, n)
      real(wp), intent(in), contiguous :: torque(:, :)
      integer, intent(in), contiguous :: class_of(:)
      logical, intent(out) :: fine
      real(wp) :: lack
      integer :: lane, j, number
      fine = are_within(4*lanes, q(:, first:first + lanes - 1), 2.0_wp) .and. &
             are_within(3*lanes, l(:, first:first + lanes - 1), greatest_number)
      if (fine .and. what%kicks) fine = are_within(3*lanes, torque(:, first:first + lanes - 1), greatest_number)
      if (.not. fine) return
      number = 1
      do lane = 1, lanes
         if (what%classed) then
            number = class_of(first + lane - 1) + 1 - what%first_number
            fine = number >= 1 .and. number <= size(classes)
            if (.not. fine) return
         end if
         if (buffer%held(lane) == number) cycle
         call put_class(buffer%lanes, lane, classes(number), what%dt)
         buffer%held(lane) = number
      end do
      do lane = 1, lanes
         j = first + lane - 1
         lack = 1 - (q(1, j)*q(1, j) + q(2, j)*q(2, j) + q(3, j)*q(3, j) + q(4, j)*q(4, j))
         if (abs(lack) > manifold_tolerance) fine = .false.
         buffer%lanes%q(lane, :) = q(:, j)
         buffer%lanes%momentum(lane, :) = l(:, j)
      end do
      if (.not. what%kicks) return
      do lane = 1, lanes
         buffer%lanes%torque(lane, :) = torque(:, first + lane - 1)
      end do
   end subroutine load_all

   !> Writes all lanes back.
   pure subroutine store_all(block, drifted, first, n, q, l)
      type(drift_lanes_t), intent(in) :: block
      !> True if the attitudes have changed.
      logical, intent(in) :: drifted
      integer, intent(in) :: first, n
      real(wp), intent(inout) :: q(4, n), l(3, n)
      integer :: lane
      do lane = 1, lanes
         if (drifted) q(:, first + lane - 1) = block%q(lane, :)
         l(:, first + lane - 1) = block%momentum(lane, :)
      end do
   end subroutine store_all

   !> Fills lanes one by one; a body with invalid numbers is replaced by a body at rest.
   pure subroutine load_each(classes, what, buffer, first, several, n, q, l, torque, class_of, bad)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: first, several, n
      real(wp), intent(in) :: q(4, n), l(3, n)
      real(wp), intent(in), contiguous :: torque(:, :)
      integer, intent(in), contiguous :: class_of(:)
      logical, intent(inout) :: bad(lanes)
      real(wp) :: pull(3)
      integer :: i, j, number
      pull = 0.0_wp
      number = 1
      do i = 1, several
         j = first + i - 1
         if (what%classed) number = class_of(j) + 1 - what%first_number
         if (what%kicks) pull = torque(:, j)
         call load(classes, what, buffer, i, number, q(:, j), l(:, j), pull, bad(i))
         if (bad(i)) call rest(classes, what, buffer, i)
      end do
      do i = several + 1, lanes
         call rest(classes, what, buffer, i)
      end do
   end subroutine load_each

   !> Writes lanes back one by one, except those of bodies that keep their state.
   pure subroutine store_each(block, drifted, first, several, n, q, l, bad)
      type(drift_lanes_t), intent(in) :: block
      !> True if the attitudes have changed.
      logical, intent(in) :: drifted
      integer, intent(in) :: first, several, n
      real(wp), intent(inout) :: q(4, n), l(3, n)
      logical, intent(in) :: bad(lanes)
      integer :: i
      do i = 1, several
         if (bad(i)) cycle
         if (drifted) q(:, first + i - 1) = block%q(i, :)
         l(:, first + i - 1) = block%momentum(i, :)
      end do
   end subroutine store_each

   !> Moves the bodies whose drift is not certified along their exact motion.
   subroutine move_doubtful(classes, what, buffer, first, several, q, bad)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: first, several
      !> Attitudes before the step; shape (4, n).
      real(wp), intent(in), contiguous :: q(:, :)
      logical, intent(inout) :: bad(lanes)
      integer :: i
      do i = 1, several
         if (bad(i) .or. buffer%lanes%certified(i) > 0.5_wp) cycle
         call move_exactly(classes(buffer%held(i)), what, q(:, first + i - 1), buffer%lanes%q(i, :), &
                           buffer%lanes%momentum(i, :), bad(i))
      end do
   end subroutine move_doubtful

   !> Fills a lane with a body at rest.
   pure subroutine rest(classes, what, buffer, lane)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: lane
      logical :: bad
      call load(classes, what, buffer, lane, 1, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
                [0.0_wp, 0.0_wp, 0.0_wp], bad)
   end subroutine rest

   !> Puts a body into a lane; `bad` if its numbers are invalid.
   pure subroutine load(classes, what, buffer, lane, number, q, l, torque, bad)
      type(body_class_t), intent(in), contiguous :: classes(:)
      type(movement_t), intent(in) :: what
      type(lane_buffer_t), intent(inout) :: buffer
      integer, intent(in) :: lane, number
      real(wp), intent(in) :: q(4), l(3), torque(3)
      logical, intent(out) :: bad
      real(wp) :: lack
      bad = .true.
      if (number < 1 .or. number > size(classes)) return
      if (.not. is_within(q, l, torque)) return
      lack = 1 - (q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
      if (abs(lack) > manifold_tolerance) return
      if (buffer%held(lane) /= number) then
         call put_class(buffer%lanes, lane, classes(number), what%dt)
         buffer%held(lane) = number
      end if
      buffer%lanes%q(lane, :) = q
      buffer%lanes%momentum(lane, :) = l
      buffer%lanes%torque(lane, :) = torque
      bad = .false.
   end subroutine load

   !> Moves a body along its exact motion.
   subroutine move_exactly(made, what, start, q, momentum, bad)
      type(body_class_t), intent(in) :: made
      type(movement_t), intent(in) :: what
      !> Attitude before the step.
      real(wp), intent(in) :: start(4)
      !> Attitude after the step.
      real(wp), intent(inout) :: q(4)
      !> Momentum before and after the step: space axes, or principal axes.
      real(wp), intent(inout) :: momentum(3)
      logical, intent(out) :: bad
      type(free_body_t) :: motion
      type(status_t) :: status
      real(wp) :: rotating(3)
      if (what%frame == SPACE_MOMENTUM) then
         rotating = rotate_to_body(start, momentum)
      else
         rotating = matmul(made%axes, momentum)
      end if
      bad = norm2(matmul(rotating, made%axes)/made%moments)*abs(what%dt) > greatest_turn
      if (bad) return
      call motion%prepare(made%moments, start, rotating, status, made%axes)
      bad = .not. status%ok()
      if (bad) return
      call motion%evaluate(what%dt, q, rotating)
      if (what%frame /= SPACE_MOMENTUM) momentum = matmul(rotating, made%axes)
   end subroutine move_exactly

   !> Returns true if all numbers are finite and at most 1e100. Bits are compared, since comparisons with NaN set off
   !> traps.
   pure logical function is_within(q, l, torque)
      real(wp), intent(in) :: q(4), l(3), torque(3)
      integer(long), parameter :: most = transfer(greatest_number, 1_long)
      integer(long) :: worst
      worst = max(magnitude(q(1)), magnitude(q(2)), magnitude(q(3)), magnitude(q(4)), magnitude(l(1)), &
                  magnitude(l(2)), magnitude(l(3)), magnitude(torque(1)), magnitude(torque(2)), magnitude(torque(3)))
      is_within = worst <= most
   end function is_within

   !> Returns true if many numbers are finite and at most a limit, in a loop of vector instructions: the sign of a
   !> difference of bits decides.
   pure logical function are_within(n, numbers, limit)
      integer, intent(in) :: n
      real(wp), intent(in) :: numbers(n), limit
      integer(long) :: most, signs
      integer :: i
      most = transfer(limit, 1_long)
      signs = 0_long
      do i = 1, n
         signs = ior(signs, most - iand(transfer(numbers(i), 1_long), huge(1_long)))
      end do
      are_within = signs >= 0_long
   end function are_within

   !> Returns the bits of |x|, which are in the order of the numbers.
   pure integer(long) function magnitude(x)
      real(wp), intent(in) :: x
      magnitude = iand(transfer(x, 1_long), huge(1_long))
   end function magnitude

end module nutate_bodies
