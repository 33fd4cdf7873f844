!> C interface: scenes. The functions are documented in `include/nutate_scene.h`.
module nutate_c_scene
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_funptr, c_int, c_int64_t, c_loc, &
      c_ptr, c_size_t
   use nutate_c_scene_handle, only: conclude, found, is_taken, null_argument, open_slot, report, scene_handle_t, &
      SCENE_MARK
   use nutate_c_system, only: add_callback_potential, add_callback_torque, keep_system
   use nutate_c_text, only: lock_texts, message_to_c, copy_text, text_to_c, unlock_texts
   use nutate_hamiltonian, only: angular_velocity
   use nutate_equilibria, only: equilibria_t
   use nutate_linearization, only: linearization_t
   use nutate_linearization_json, only: json_of, json_of_equilibria
   use nutate_scene, only: parse_scene, read_scene
   use nutate_scene_linearization, only: linearize_scene, scene_equilibria
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   implicit none
   private

   public :: nutate_scene_read, nutate_scene_parse, nutate_scene_destroy, nutate_scene_get_title, &
      nutate_scene_get_plan, nutate_scene_get_initial, nutate_scene_add_potential, nutate_scene_add_user_torque, &
      nutate_scene_bound_potential, nutate_scene_bound_torque, nutate_scene_system, nutate_scene_linearize, &
      nutate_scene_equilibria

contains

   integer(c_int) function nutate_scene_read(path, overrides, n_overrides, scene, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: path, overrides, scene, message
      integer(c_size_t), intent(in), value :: n_overrides, size
      code = load(path, path, .true., overrides, n_overrides, scene, message, size)
   end function nutate_scene_read

   integer(c_int) function nutate_scene_parse(text, name, overrides, n_overrides, scene, message, size) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: text, name, overrides, scene, message
      integer(c_size_t), intent(in), value :: n_overrides, size
      code = load(text, name, .false., overrides, n_overrides, scene, message, size)
   end function nutate_scene_parse

   integer(c_int) function nutate_scene_destroy(scene) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      type(scene_handle_t), pointer :: handle
      type(c_ptr) :: taken
      if (.not. is_taken(scene, SCENE_MARK, taken, code)) return
      call c_f_pointer(taken, handle)
      deallocate (handle)
   end function nutate_scene_destroy

   integer(c_int) function nutate_scene_get_title(scene, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, buffer
      integer(c_size_t), intent(in), value :: size
      type(scene_handle_t), pointer :: handle
      if (found(scene, handle, code)) code = text_to_c(handle%scene%title, buffer, size)
   end function nutate_scene_get_title

   integer(c_int) function nutate_scene_get_plan(scene, time_step, end_time, every) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(inout), optional :: time_step, end_time
      integer(c_int64_t), intent(inout), optional :: every
      type(scene_handle_t), pointer :: handle
      if (.not. found(scene, handle, code)) return
      code = NUTATE_OK
      if (present(time_step)) time_step = handle%scene%plan%time_step
      if (present(end_time)) end_time = handle%scene%plan%end_time
      if (present(every)) every = handle%scene%plan%every
   end function nutate_scene_get_plan

   integer(c_int) function nutate_scene_get_initial(scene, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(inout), optional :: q(4), omega(3)
      type(scene_handle_t), pointer :: handle
      if (.not. found(scene, handle, code)) return
      code = NUTATE_OK
      if (present(q)) q = handle%scene%initial%q
      if (present(omega)) omega = angular_velocity(handle%scene%system, handle%scene%initial)
   end function nutate_scene_get_initial

   integer(c_int) function nutate_scene_add_potential(scene, direction, potential, hessian, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, user
      real(c_double), intent(in), optional :: direction(3)
      type(c_funptr), intent(in), value :: potential, hessian
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call add_callback_potential(handle%scene%system%effects, direction, potential, hessian, user, status)
      code = end_adding(handle, status)
   end function nutate_scene_add_potential

   integer(c_int) function nutate_scene_add_user_torque(scene, torque, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, user
      type(c_funptr), intent(in), value :: torque
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call add_callback_torque(handle%scene%system%effects, torque, user, status)
      code = end_adding(handle, status)
   end function nutate_scene_add_user_torque

   integer(c_int) function nutate_scene_bound_potential(scene, gradient, hessian, third) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(in), value :: gradient, hessian, third
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call handle%scene%system%effects%bound_potential(gradient, hessian, third, status)
      code = conclude(handle, status)
   end function nutate_scene_bound_potential

   integer(c_int) function nutate_scene_bound_torque(scene, torque, by_rotation, second, rate) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(in), value :: torque, by_rotation, second, rate
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call handle%scene%system%effects%bound_torque(torque, by_rotation, second, rate, status)
      code = conclude(handle, status)
   end function nutate_scene_bound_torque

   integer(c_int) function nutate_scene_system(scene, system, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, system, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      slot => open_slot(system)
      if (.not. associated(slot)) then
         status = null_argument('system')
      else if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else
         call keep_system(handle%scene%system, slot, status)
      end if
      code = report(status, message, size)
   end function nutate_scene_system

   integer(c_int) function nutate_scene_linearize(scene, period, json, json_size, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, json, message
      real(c_double), intent(in), value :: period
      integer(c_size_t), intent(in), value :: json_size, size
      type(scene_handle_t), pointer :: handle
      type(linearization_t) :: linear
      type(status_t) :: status
      if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else if (.not. c_associated(json)) then
         status = null_argument('json')
      else if (.not. abs(period) <= 1e15_c_double) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the period is out of its range (expected up to 1e15 s)', 'period')
      else
         call linearize_scene(handle%scene, period, linear, status)
         if (status%ok()) status%code = text_to_c(json_of(linear), json, json_size)
      end if
      code = report(status, message, size)
   end function nutate_scene_linearize

   integer(c_int) function nutate_scene_equilibria(scene, json, json_size, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, json, message
      integer(c_size_t), intent(in), value :: json_size, size
      type(scene_handle_t), pointer :: handle
      type(equilibria_t) :: equilibria
      type(status_t) :: status
      if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else if (.not. c_associated(json)) then
         status = null_argument('json')
      else
         call scene_equilibria(handle%scene, equilibria, status)
         if (status%ok()) status%code = text_to_c(json_of_equilibria(equilibria), json, json_size)
      end if
      code = report(status, message, size)
   end function nutate_scene_equilibria

   !> Finishes adding an effect to a scene: requests the attitude, on which callbacks may depend, and deletes the
   !> prepared fit.
   integer(c_int) function end_adding(handle, status) result(code)
      type(scene_handle_t), intent(inout) :: handle
      type(status_t), intent(in) :: status
      if (status%ok()) handle%scene%integrator%attitude = .true.
      if (allocated(handle%fit)) deallocate (handle%fit)
      code = conclude(handle, status)
   end function end_adding

   !> Reads a scene from a file or from a string and makes its handle.
   integer(c_int) function load(source, name, is_file, overrides, n_overrides, scene, message, size) result(code)
      !> Path or string, and name of the scene.
      type(c_ptr), intent(in) :: source, name
      logical, intent(in) :: is_file
      type(c_ptr), intent(in) :: overrides, scene, message
      integer(c_size_t), intent(in) :: n_overrides, size
      type(c_ptr), pointer :: slot
      type(scene_handle_t), pointer :: handle
      character(len=:), allocatable :: settings(:), text, called, content
      type(status_t) :: status
      integer :: failed

      slot => open_slot(scene)
      if (.not. associated(slot)) status = null_argument('scene')
      if (.not. c_associated(source)) status = null_argument('path or text')
      if (status%ok()) call read_overrides(overrides, n_overrides, settings, status)
      if (status%ok()) then
         allocate (handle, stat=failed)
         if (failed /= 0) status = fail(NUTATE_NO_MEMORY, 'not enough memory for a scene')
      end if
      text = trim(status%message)
      if (status%ok()) then
         called = 'scene'
         if (c_associated(name)) call copy_text(name, called)
         call copy_text(source, content)
         call lock_texts()
         if (is_file) then
            call read_scene(called, handle%scene, status, text, settings)
         else
            call parse_scene(content, called, handle%scene, status, text, settings)
         end if
         call unlock_texts()
         if (status%ok()) then
            handle%mark = SCENE_MARK
            slot = c_loc(handle)
         else
            deallocate (handle)
         end if
      end if
      call message_to_c(text, message, size)
      code = status%code
   end function load

   !> Returns the overrides as strings of one length. Errors: `NUTATE_BAD_ARGUMENT` if one of them, or the array, is
   !> null.
   subroutine read_overrides(overrides, n, texts, status)
      !> Overrides as `char *[n]`.
      type(c_ptr), intent(in) :: overrides
      integer(c_size_t), intent(in) :: n
      character(len=:), allocatable, intent(out) :: texts(:)
      type(status_t), intent(out) :: status
      type(c_ptr), pointer :: list(:)
      character(len=:), allocatable :: text
      integer :: i, longest
      !> Largest number of overrides, more than any scene has settings.
      integer, parameter :: most = 10000

      if (n < 0 .or. n > most) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the number of overrides is out of its range', 'n_overrides')
      else if (n > 0 .and. .not. c_associated(overrides)) then
         status = null_argument('overrides')
      end if
      if (.not. status%ok() .or. n == 0) then
         allocate (character(len=1) :: texts(0))
         return
      end if
      call c_f_pointer(overrides, list, [n])
      longest = 1
      do i = 1, int(n)
         if (.not. c_associated(list(i))) status = null_argument('overrides[i]')
         call copy_text(list(i), text)
         longest = max(longest, len(text))
      end do
      allocate (character(len=longest) :: texts(n))
      do i = 1, int(n)
         call copy_text(list(i), text)
         texts(i) = text
      end do
   end subroutine read_overrides

end module nutate_c_scene
