!> C interface: systems and their effects. The functions are documented in `include/nutate_system.h`.
module nutate_c_system
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_funptr, c_int, c_int64_t, c_loc, &
      c_null_ptr, c_ptr, c_size_t
   use nutate_admissible, only: admits, ANY_DIRECTION
   use nutate_body, only: body_t, whole_body
   use nutate_c_effects, only: c_curved_potential_t, c_potential_t, c_torque_t
   use nutate_c_groups, only: build_system, make_body_of
   use nutate_c_handles, only: conclude, copy_system, found, is_taken, null_argument, open_slot, report, &
      system_handle_t, SYSTEM_MARK
   use nutate_c_text, only: lock_texts, copy_text, unlock_texts
   use nutate_effect_list, only: effect_list_t
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp
   use nutate_limits, only: greatest_number, in_words, least_size
   use nutate_shapes, only: shape_kinds
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   use nutate_system, only: system_t
   implicit none
   private

   public :: nutate_system_create_moments, nutate_system_create_tensor, nutate_system_create_shape, &
      nutate_system_parse, nutate_system_copy, nutate_system_destroy, nutate_system_body, nutate_system_add_groups, &
      nutate_system_add_potential, nutate_system_add_user_torque
   public :: keep_system, add_callback_potential, add_callback_torque, given

contains

   integer(c_int) function nutate_system_create_moments(moments, mass, center_of_mass, about_center, system, message, &
                                                        size) result(code) bind(C)
      real(c_double), intent(in), optional :: moments(3), center_of_mass(3)
      real(c_double), intent(in), value :: mass
      integer(c_int), intent(in), value :: about_center
      type(c_ptr), intent(in), value :: system, message
      integer(c_size_t), intent(in), value :: size
      type(group_t) :: group
      call group%put('inertia', moments)
      call put_rest(group, mass, center_of_mass, about_center)
      code = create(group, present(moments), 'moments', system, message, size)
   end function nutate_system_create_moments

   integer(c_int) function nutate_system_create_tensor(tensor, mass, center_of_mass, about_center, system, message, &
                                                       size) result(code) bind(C)
      real(c_double), intent(in), optional :: tensor(6), center_of_mass(3)
      real(c_double), intent(in), value :: mass
      integer(c_int), intent(in), value :: about_center
      type(c_ptr), intent(in), value :: system, message
      integer(c_size_t), intent(in), value :: size
      type(group_t) :: group
      call group%put('inertia_tensor', tensor)
      call put_rest(group, mass, center_of_mass, about_center)
      code = create(group, present(tensor), 'tensor', system, message, size)
   end function nutate_system_create_tensor

   integer(c_int) function nutate_system_create_shape(shape, lengths, n_lengths, mass, density, center_of_mass, &
                                                      system, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: shape, lengths
      integer(c_size_t), intent(in), value :: n_lengths, size
      real(c_double), intent(in), value :: mass, density
      real(c_double), intent(in), optional :: center_of_mass(3)
      type(c_ptr), intent(in), value :: system, message
      type(group_t) :: group
      character(len=:), allocatable :: name
      real(c_double), pointer :: numbers(:)
      integer(c_size_t) :: n
      logical :: complete
      complete = c_associated(shape) .and. c_associated(lengths)
      if (complete) then
         ! No shape has more lengths than the maximum of `sizes`; one more shows that there are too many. A size of C
         ! beyond the greatest integer is negative here.
         n = maxval(shape_kinds%sizes) + 1
         if (n_lengths >= 0) n = min(n, n_lengths)
         call c_f_pointer(lengths, numbers, [n])
         call copy_text(shape, name)
         call group%put('shape', name)
         call group%put('size', numbers)
      end if
      if (given(mass)) call group%put('mass', [mass])
      if (given(density)) call group%put('density', [density])
      call group%put('center_of_mass', center_of_mass)
      code = create(group, complete, 'shape or lengths', system, message, size)
   end function nutate_system_create_shape

   integer(c_int) function nutate_system_parse(text, system, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: text, system, message
      integer(c_size_t), intent(in), value :: size
      character(len=:), allocatable :: content, whole
      type(c_ptr), pointer :: slot
      type(system_t) :: built
      type(status_t) :: status
      slot => open_slot(system)
      if (.not. associated(slot)) then
         status = null_argument('system')
      else if (.not. c_associated(text)) then
         status = null_argument('text')
      else
         call copy_text(text, content)
         call lock_texts()
         call build_system(content, .true., built, status, whole)
         call unlock_texts()
         if (status%ok()) call keep_system(built, slot, status)
      end if
      code = report(status, message, size, whole)
   end function nutate_system_parse

   integer(c_int) function nutate_system_copy(system, copy, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, copy, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      slot => open_slot(copy)
      if (.not. associated(slot)) then
         status = null_argument('copy')
      else if (.not. found(system, handle)) then
         status = fail(NUTATE_BAD_HANDLE, 'system is NULL, destroyed or not a system')
      else
         call keep_system(handle%system, slot, status)
      end if
      code = report(status, message, size)
   end function nutate_system_copy

   integer(c_int) function nutate_system_destroy(system) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      type(system_handle_t), pointer :: handle
      type(c_ptr) :: taken
      if (.not. is_taken(system, SYSTEM_MARK, taken, code)) return
      call c_f_pointer(taken, handle)
      deallocate (handle)
   end function nutate_system_destroy

   integer(c_int) function nutate_system_body(system, inertia, mass, center_of_mass) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(inout), optional :: inertia(3, 3), mass, center_of_mass(3)
      type(system_handle_t), pointer :: handle
      type(body_t) :: whole
      if (.not. found(system, handle, code)) return
      code = NUTATE_OK
      ! The tensor is symmetric: rows are columns.
      if (present(inertia)) then
         whole = whole_body(handle%system%body)
         inertia = whole%inertia
      end if
      if (present(mass)) mass = handle%system%body%mass
      if (present(center_of_mass)) center_of_mass = handle%system%body%center_of_mass
   end function nutate_system_body

   integer(c_int) function nutate_system_add_groups(system, text) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, text
      character(len=:), allocatable :: content
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      if (c_associated(text)) then
         call copy_text(text, content)
         call lock_texts()
         call build_system(content, .false., handle%system, status, handle%text)
         call unlock_texts()
      else
         status = null_argument('text')
      end if
      code = conclude(handle, status)
   end function nutate_system_add_groups

   integer(c_int) function nutate_system_add_potential(system, direction, potential, hessian, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, user
      real(c_double), intent(in), optional :: direction(3)
      type(c_funptr), intent(in), value :: potential, hessian
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      call add_callback_potential(handle%system%effects, direction, potential, hessian, user, status)
      code = conclude(handle, status)
   end function nutate_system_add_potential

   integer(c_int) function nutate_system_add_user_torque(system, torque, user) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, user
      type(c_funptr), intent(in), value :: torque
      type(system_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      call add_callback_torque(handle%system%effects, torque, user, status)
      code = conclude(handle, status)
   end function nutate_system_add_user_torque

   !> Returns true if a number is given: not zero. NaN is treated as given, and is rejected later.
   pure logical function given(x)
      real(wp), intent(in) :: x
      given = iand(transfer(x, 1_c_int64_t), huge(1_c_int64_t)) /= 0
   end function given

   !> Puts mass, centre of mass and reference point of an inertia into a group.
   subroutine put_rest(group, mass, center_of_mass, about_center)
      type(group_t), intent(inout) :: group
      real(wp), intent(in) :: mass
      real(wp), intent(in), optional :: center_of_mass(3)
      integer(c_int), intent(in) :: about_center
      if (given(mass)) call group%put('mass', [mass])
      call group%put('center_of_mass', center_of_mass)
      if (about_center /= 0) call group%put('inertia_about', 'center_of_mass')
   end subroutine put_rest

   !> Makes the body that a group describes and its handle.
   integer(c_int) function create(group, complete, missing, system, message, size) result(code)
      type(group_t), intent(inout) :: group
      !> True if no required argument is null; name of these arguments, for the error message.
      logical, intent(in) :: complete
      character(len=*), intent(in) :: missing
      type(c_ptr), intent(in) :: system, message
      integer(c_size_t), intent(in) :: size
      type(c_ptr), pointer :: slot
      type(system_t) :: built
      type(status_t) :: status
      group%name = 'body'
      slot => open_slot(system)
      if (.not. associated(slot)) then
         status = null_argument('system')
      else if (.not. complete) then
         status = null_argument(missing)
      else
         call lock_texts()
         call make_body_of(group, built, status)
         call unlock_texts()
         if (status%ok()) call keep_system(built, slot, status)
      end if
      code = report(status, message, size)
   end function create

   !> Makes the handle of a system. Errors: `NUTATE_NO_MEMORY`.
   subroutine keep_system(system, slot, status)
      type(system_t), intent(in) :: system
      type(c_ptr), intent(inout) :: slot
      type(status_t), intent(out) :: status
      type(system_handle_t), pointer :: handle
      integer :: failed
      allocate (handle, stat=failed)
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for a system')
         return
      end if
      call copy_system(system, handle%system, c_null_ptr)
      handle%mark = SYSTEM_MARK
      slot = c_loc(handle)
   end subroutine keep_system

   !> Adds a potential by callbacks. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine add_callback_potential(effects, direction, potential, hessian, user, status)
      type(effect_list_t), intent(inout) :: effects
      real(wp), intent(in), optional :: direction(3)
      type(c_funptr), intent(in) :: potential, hessian
      type(c_ptr), intent(in) :: user
      type(status_t), intent(out) :: status
      if (.not. present(direction)) then
         status = null_argument('direction')
      else if (.not. c_associated(potential)) then
         status = null_argument('potential')
      else if (.not. admits(ANY_DIRECTION, direction)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the direction is too short, too long or not finite (expected a '// &
                       'component of '//in_words(least_size, greatest_number)//' in size)', 'direction')
      else if (c_associated(hessian)) then
         call effects%add(c_curved_potential_t(name='callback', direction=direction, function=potential, user=user, &
                                               second=hessian))
      else
         call effects%add(c_potential_t(name='callback', direction=direction, function=potential, user=user))
      end if
   end subroutine add_callback_potential

   !> Adds a torque by a callback. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine add_callback_torque(effects, torque, user, status)
      type(effect_list_t), intent(inout) :: effects
      type(c_funptr), intent(in) :: torque
      type(c_ptr), intent(in) :: user
      type(status_t), intent(out) :: status
      if (c_associated(torque)) then
         call effects%add(c_torque_t(name='callback', function=torque, user=user))
      else
         status = null_argument('torque')
      end if
   end subroutine add_callback_torque

end module nutate_c_system
