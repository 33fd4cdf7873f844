!> C interface: many bodies with torques of the program. The functions are documented in `include/nutate_bodies.h`.
module nutate_c_bodies
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_ptr, c_size_t
   use nutate_bodies, only: make_classes, move_bodies, movement_t
   use nutate_body, only: body_t
   use nutate_c_handles, only: bodies_handle_t, conclude, found, is_taken, null_argument, open_slot, report, &
      system_handle_t, BODIES_MARK
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   implicit none
   private

   public :: nutate_bodies_create, nutate_bodies_destroy, nutate_bodies_set_threads, nutate_bodies_step, &
      nutate_bodies_kick, nutate_bodies_drift, nutate_bodies_failed

   !> Largest numbers of classes and of threads, more than any program has.
   integer(c_size_t), parameter :: most_classes = 2_c_size_t**30
   integer(c_int), parameter :: most_threads = 4096

contains

   integer(c_int) function nutate_bodies_create(classes, n_classes, frame, bodies, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: classes, bodies, message
      integer(c_size_t), intent(in), value :: n_classes, size
      integer(c_int), intent(in), value :: frame
      type(c_ptr), pointer :: slot, systems(:)
      type(bodies_handle_t), pointer :: handle
      type(status_t) :: status
      integer :: failed
      slot => open_slot(bodies)
      if (.not. associated(slot)) then
         status = null_argument('bodies')
      else if (.not. c_associated(classes)) then
         status = null_argument('classes')
      else if (n_classes < 1 .or. n_classes > most_classes) then
         status = fail(NUTATE_BAD_ARGUMENT, 'wrong number of classes (expected 1 to 1073741824)', 'n_classes')
      end if
      if (status%ok()) then
         call c_f_pointer(classes, systems, [n_classes])
         allocate (handle, stat=failed)
         if (failed /= 0) then
            status = fail(NUTATE_NO_MEMORY, 'not enough memory for bodies')
         else
            call fill(handle, systems, frame, status)
            if (.not. status%ok()) deallocate (handle)
         end if
      end if
      if (status%ok()) slot = c_loc(handle)
      code = report(status, message, size)
   end function nutate_bodies_create

   !> Sets the classes of a handle.
   subroutine fill(handle, systems, frame, status)
      type(bodies_handle_t), intent(inout) :: handle
      type(c_ptr), intent(in) :: systems(:)
      integer(c_int), intent(in) :: frame
      type(status_t), intent(out) :: status
      type(system_handle_t), pointer :: system
      type(body_t), allocatable :: classes(:)
      integer :: i
      allocate (classes(size(systems)), handle%classes(size(systems)), handle%failed(0))
      do i = 1, size(systems)
         if (.not. found(systems(i), system)) then
            status = fail(NUTATE_BAD_HANDLE, 'a class is NULL, destroyed or not a system')
            return
         end if
         associate (effects => system%system%effects)
            if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors > 0 .or. &
                effects%n_wheels > 0 .or. effects%frame_turns) then
               status = fail(NUTATE_BAD_ARGUMENT, 'a class has effects (expected the body alone)', 'classes')
               return
            end if
         end associate
         classes(i) = system%system%body
      end do
      call make_classes(classes, int(frame), handle%classes, status)
      handle%mark = BODIES_MARK
      handle%what%frame = frame
      handle%what%first_number = 0
   end subroutine fill

   integer(c_int) function nutate_bodies_destroy(bodies) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies
      type(bodies_handle_t), pointer :: handle
      type(c_ptr) :: taken
      if (.not. is_taken(bodies, BODIES_MARK, taken, code)) return
      call c_f_pointer(taken, handle)
      deallocate (handle)
   end function nutate_bodies_destroy

   integer(c_int) function nutate_bodies_set_threads(bodies, threads) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies
      integer(c_int), intent(in), value :: threads
      type(bodies_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(bodies, handle, code)) return
      if (threads < 0 .or. threads > most_threads) then
         status = fail(NUTATE_BAD_ARGUMENT, 'threads are out of range (expected 0 to 4096)', 'threads')
      else
         handle%what%threads = threads
      end if
      code = conclude(handle, status)
   end function nutate_bodies_set_threads

   integer(c_int) function nutate_bodies_step(bodies, n, class_of, dt, q, l, torque) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies, class_of, q, l, torque
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), value :: dt
      code = move(bodies, movement_t(dt, .true., .true.), n, class_of, q, l, torque)
   end function nutate_bodies_step

   integer(c_int) function nutate_bodies_kick(bodies, n, class_of, dt, q, l, torque) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies, class_of, q, l, torque
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), value :: dt
      code = move(bodies, movement_t(dt, .true., .false.), n, class_of, q, l, torque)
   end function nutate_bodies_kick

   integer(c_int) function nutate_bodies_drift(bodies, n, class_of, dt, q, l) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies, class_of, q, l
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), value :: dt
      code = move(bodies, movement_t(dt, .false., .true.), n, class_of, q, l, l)
   end function nutate_bodies_drift

   integer(c_int) function nutate_bodies_failed(bodies, most, failed, n_failed) result(code) bind(C)
      type(c_ptr), intent(in), value :: bodies, failed
      integer(c_size_t), intent(in), value :: most
      integer(c_size_t), intent(inout), optional :: n_failed
      type(bodies_handle_t), pointer :: handle
      integer(c_size_t), pointer :: places(:)
      if (.not. found(bodies, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (most < 0 .or. (most > 0 .and. .not. c_associated(failed))) return
      code = NUTATE_OK
      if (present(n_failed)) n_failed = size(handle%failed)
      if (most < 1) return
      call c_f_pointer(failed, places, [min(most, size(handle%failed, kind=c_size_t))])
      places = handle%failed(1:size(places)) - 1
   end function nutate_bodies_failed

   !> Tests the arguments of a call and performs it.
   integer(c_int) function move(bodies, what, n, class_of, q, l, torque) result(code)
      type(c_ptr), intent(in) :: bodies, class_of, q, l, torque
      type(movement_t), intent(in) :: what
      integer(c_size_t), intent(in) :: n
      type(bodies_handle_t), pointer :: handle
      type(movement_t) :: whole
      type(status_t) :: status
      real(c_double), pointer, contiguous :: attitudes(:, :), momenta(:, :), torques(:, :)
      integer(c_int), pointer, contiguous :: numbers(:)
      integer(c_int), target :: none(0)
      real(c_double), target :: no_attitude(4, 0), no_momentum(3, 0)
      if (.not. found(bodies, handle, code)) return
      if (size(handle%failed) > 0) handle%failed = [integer ::]
      if (n < 0 .or. n > huge(0)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'too many bodies (expected at most 2147483647)', 'n')
      else if (n > 0 .and. .not. (c_associated(q) .and. c_associated(l) .and. c_associated(torque))) then
         status = null_argument('q, l or torque')
      else
         attitudes => no_attitude
         momenta => no_momentum
         torques => no_momentum
         if (n > 0) then
            call c_f_pointer(q, attitudes, [4_c_size_t, n])
            call c_f_pointer(l, momenta, [3_c_size_t, n])
            call c_f_pointer(torque, torques, [3_c_size_t, n])
         end if
         whole = movement_t(what%dt, what%kicks, what%drifts, c_associated(class_of), handle%what%frame, &
                            handle%what%threads, handle%what%first_number)
         numbers => none
         if (whole%classed) call c_f_pointer(class_of, numbers, [n])
         call move_bodies(handle%classes, whole, int(n), attitudes, momenta, torques, numbers, handle%failed, status)
      end if
      code = conclude(handle, status)
   end function move

end module nutate_c_bodies
