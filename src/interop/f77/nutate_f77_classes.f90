!> The work array of the FORTRAN 77 routines for many bodies: the classes, as NUBSET has made them. It holds plain
!> numbers, no addresses: a copy is as good as the original.
!>
!> WORK(1): its length; (2): a mark; (3): IFRAME + 4 NT, NT threads; (4): number of classes; then the classes.
module nutate_f77_classes
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_bodies, only: make_classes, move_bodies, movement_t
   use nutate_bodies_drift, only: body_class_t
   use nutate_body, only: body_t, make_body
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate, is_step
   use nutate_status, only: status_t
   implicit none
   private

   public :: classes_length, fill_classes, find_bad_work, find_bad_move, move_by_work, set_threads, most_threads

   !> Bits of the second number of an array that NUBSET has filled: `NUBODY 1` in ASCII.
   integer(int64), parameter :: mark = int(z'4E55424F44592031', int64)
   !> Count of numbers before the classes, and in a class.
   integer, parameter :: head = 4, class_size = 23
   !> Number of frames that WORK(3) has room for; one thread; largest number of threads, more than any program has.
   integer, parameter :: frames = 4, one_thread = 1, most_threads = 4096

contains

   !> Returns the length of the array for a number of classes.
   pure integer function classes_length(n)
      integer, intent(in) :: n
      classes_length = head + class_size*n
   end function classes_length

   !> Fills the array. Finds the number of the argument of NUBSET that is wrong, AJ or IFRAME; 0 if none is.
   subroutine fill_classes(tensors, frame, work, bad)
      !> Inertia tensors, body axes, kg m²; shape (3, 3, number of classes).
      real(wp), intent(in) :: tensors(:, :, :)
      integer, intent(in) :: frame
      !> Work array; shape (`classes_length` of the number of classes).
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: bad
      type(body_t), allocatable :: bodies(:)
      type(body_class_t), pointer :: classes(:)
      type(body_class_t), allocatable :: made(:)
      type(status_t) :: status
      integer :: i
      allocate (bodies(size(tensors, 3)), made(size(tensors, 3)))
      bad = 2
      do i = 1, size(bodies)
         if (.not. all(is_moderate(tensors(:, :, i)))) return
         call make_body(tensors(:, :, i), bodies(i), status)
         if (.not. status%ok()) return
      end do
      call make_classes(bodies, frame, made, status)
      if (status%subject == 'frame') bad = 3
      if (.not. status%ok()) return
      bad = 0
      work(1:head) = [real(size(work), wp), transfer(mark, 0.0_wp), real(frame + frames*one_thread, wp), &
                      real(size(bodies), wp)]
      call c_f_pointer(c_loc(work(head + 1)), classes, [size(bodies)])
      classes = made
   end subroutine fill_classes

   !> Returns the number of the first of N, DT, MBAD, WORK, LWORK that is wrong, as an argument of NUBODY; 0 if none is.
   pure integer function find_bad_move(n, dt, most, work, lwork) result(bad)
      integer, intent(in) :: n, most, lwork
      real(wp), intent(in) :: dt, work(*)
      bad = 0
      if (n < 0) then
         bad = 1
      else if (.not. is_step(dt)) then
         bad = 2
      else if (most < 0) then
         bad = 7
      else
         bad = find_bad_work(work, lwork)
         if (bad > 0) bad = bad + 9
      end if
   end function find_bad_move

   !> Returns 1 if WORK was not filled by NUBSET, 2 if LWORK is too small, 0 if nothing is wrong.
   pure integer function find_bad_work(work, lwork) result(bad)
      integer, intent(in) :: lwork
      real(wp), intent(in) :: work(*)
      bad = 0
      if (lwork < head) then
         bad = 2
      else if (transfer(work(2), 0_int64) /= mark) then
         bad = 1
      else if (lwork < int(work(1))) then
         bad = 2
      end if
   end function find_bad_work

   !> Sets how many threads share the bodies of a call.
   pure subroutine set_threads(threads, work)
      !> Number of threads; 0: that of OpenMP.
      integer, intent(in) :: threads
      !> Work array, filled by `fill_classes`.
      real(wp), intent(inout) :: work(*)
      work(3) = real(modulo(int(work(3)), frames) + frames*threads, wp)
   end subroutine set_threads

   !> Moves bodies, and lists those that failed.
   subroutine move_by_work(what, n, class_of, q, l, torque, bad, n_bad, work, info)
      type(movement_t), intent(in) :: what
      integer, intent(in) :: n
      !> Class of each body; shape (n); all bodies are of the first class if it begins with 0.
      integer, intent(in), contiguous :: class_of(:)
      real(wp), intent(inout) :: q(4, n), l(3, n)
      real(wp), intent(in), contiguous :: torque(:, :)
      integer, intent(inout) :: bad(:)
      integer, intent(out) :: n_bad, info
      real(wp), intent(in), target, contiguous :: work(:)
      type(body_class_t), pointer :: classes(:)
      type(movement_t) :: whole
      integer, allocatable :: failed(:)
      type(status_t) :: status
      call c_f_pointer(c_loc(work(head + 1)), classes, [int(work(4))])
      whole = movement_t(what%dt, what%kicks, what%drifts, .false., modulo(int(work(3)), frames), &
                         int(work(3))/frames)
      if (n > 0) whole%classed = class_of(1) /= 0
      call move_bodies(classes, whole, n, q, l, torque, class_of, failed, status)
      info = status%code
      n_bad = size(failed)
      bad(1:min(n_bad, size(bad))) = failed(1:min(n_bad, size(bad)))
   end subroutine move_by_work

end module nutate_f77_classes
