!> C interface: steppers, their settings and their state. The functions are documented in `include/nutate_stepper.h`.
module nutate_c_stepper
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_ptr, c_size_t
   use nutate_body, only: body_t, whole_body
   use nutate_c_effects, only: add_failure, report_failures_to
   use nutate_c_handles, only: copy_system, found, system_handle_t
   use nutate_c_scene_handle, only: found, scene_handle_t
   use nutate_c_stepper_handle, only: conclude, found, get_propagated, is_taken, null_argument, open_slot, report, &
      set_chaos, set_propagated, stepper_handle_t, unprepare, STEPPER_MARK
   use nutate_c_settings, only: get_key, prepare, set_key, set_number
   use nutate_c_text, only: lock_texts, copy_text, text_to_c, unlock_texts
   use nutate_variation, only: variation_t
   use nutate_effect_list, only: effect_list_t
   use nutate_free_variations, only: free_variations, shows_derivatives
   use nutate_hamiltonian, only: body_momentum, conserved_energy, make_state, system_t
   use nutate_keys, only: first_group, name_length
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, in_words, greatest_number
   use nutate_progress, only: start_run
   use nutate_quaternion, only: quat_normalized
   use nutate_range, only: check_attitude, check_motion
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: scene_t
   use nutate_scene_error, only: error_line, scene_error_t
   use nutate_small_products, only: symmetric_inverse
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_BAD_SCENE, &
      NUTATE_NO_MEMORY, NUTATE_OK
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_propagated, only: propagated_t
   implicit none
   private

   public :: nutate_stepper_create, nutate_stepper_create_scene, nutate_stepper_destroy, nutate_stepper_set, &
      nutate_stepper_get, nutate_stepper_set_time_step, nutate_stepper_prepare, nutate_stepper_set_state, &
      nutate_stepper_set_canonical
   public :: find_variations, start_handle, set_scene

   !> Sets of columns of a stepper that is not made from a scene.
   character(len=name_length), parameter :: usual_sets(4) = [character(len=name_length) :: &
                                                             'quaternion', 'angular_velocity', 'energy', 'constraints']

contains

   integer(c_int) function nutate_stepper_create(system, stepper, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, stepper, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(system_handle_t), pointer :: from
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      slot => open_slot(stepper)
      if (.not. associated(slot)) then
         status = null_argument('stepper')
      else if (.not. found(system, from)) then
         status = fail(NUTATE_BAD_HANDLE, 'system is NULL, destroyed or not a system')
      else
         call start_handle(handle, status)
         if (status%ok()) then
            call copy_system(from%system, handle%system, c_loc(handle%failure))
            call store_start(handle, make_state(handle%system, handle%run%state%q, [0.0_wp, 0.0_wp, 0.0_wp]), &
                            usual_sets, status)
            call finish_handle(slot, handle, status)
         end if
      end if
      code = report(status, message, size)
   end function nutate_stepper_create

   integer(c_int) function nutate_stepper_create_scene(scene, stepper, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, stepper, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(scene_handle_t), pointer :: from
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      slot => open_slot(stepper)
      if (.not. associated(slot)) then
         status = null_argument('stepper')
      else if (.not. found(scene, from)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else
         call start_handle(handle, status)
         if (status%ok()) then
            call set_scene(handle, from, from%scene%output%columns, status)
            call finish_handle(slot, handle, status)
         end if
      end if
      code = report(status, message, size)
   end function nutate_stepper_create_scene

   integer(c_int) function nutate_stepper_destroy(stepper) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      type(stepper_handle_t), pointer :: handle
      type(c_ptr) :: taken
      if (.not. is_taken(stepper, STEPPER_MARK, taken, code)) return
      call c_f_pointer(taken, handle)
      deallocate (handle)
   end function nutate_stepper_destroy

   integer(c_int) function nutate_stepper_set(stepper, key, value) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, key, value
      character(len=:), allocatable :: name, text
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (c_associated(key) .and. c_associated(value)) then
         call copy_text(key, name)
         call copy_text(value, text)
         call set_key(handle, name, text, status)
      else
         status = null_argument('key or value')
      end if
      code = conclude(handle, status)
   end function nutate_stepper_set

   integer(c_int) function nutate_stepper_get(stepper, key, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, key, buffer
      integer(c_size_t), intent(in), value :: size
      character(len=:), allocatable :: name
      type(stepper_handle_t), pointer :: handle
      character(len=len(handle%run%summary%choice)) :: value
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      call copy_text(key, name)
      call get_key(handle, name, value, status)
      code = conclude(handle, status)
      if (code == NUTATE_OK) code = text_to_c(trim(value), buffer, size)
   end function nutate_stepper_get

   integer(c_int) function nutate_stepper_set_time_step(stepper, time_step) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: time_step
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      call set_number(handle, 'time_step', time_step, status)
      code = conclude(handle, status)
   end function nutate_stepper_set_time_step

   integer(c_int) function nutate_stepper_prepare(stepper) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      call prepare(handle, status)
      code = conclude(handle, status)
   end function nutate_stepper_prepare

   integer(c_int) function nutate_stepper_set_state(stepper, t, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: t
      real(c_double), intent(in), optional :: q(4), omega(3)
      type(stepper_handle_t), pointer :: handle
      type(state_t) :: state
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. (present(q) .and. present(omega))) then
         status = null_argument('q or omega')
      else
         call check_numbers(t, q, omega, status)
         if (status%ok()) then
            state = make_state(handle%system, quat_normalized(q), omega, t)
            call replace_state(handle, state, status)
         end if
      end if
      code = conclude(handle, status)
   end function nutate_stepper_set_state

   integer(c_int) function nutate_stepper_set_canonical(stepper, t, q, p) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: t
      real(c_double), intent(in), optional :: q(4), p(4)
      type(stepper_handle_t), pointer :: handle
      type(state_t) :: state
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. (present(q) .and. present(p))) then
         status = null_argument('q or p')
      else
         call check_numbers(t, q, p, status)
         if (status%ok()) then
            state = state_of(handle%system, t, q, p)
            if (abs(dot_product(q, p)) > attitude_tolerance*maxval(abs(p))) then
               status = fail(NUTATE_BAD_ARGUMENT, 'q.p is not 0 to within '//in_words(attitude_tolerance)// &
                             ' of |p|', 'p')
            else
               call replace_state(handle, state, status)
            end if
         end if
      end if
      code = conclude(handle, status)
   end function nutate_stepper_set_canonical

   !> Returns the state for a momentum, with wheels and inner spheres at their given speeds: (Jᵣ + Σ Jw ssᵀ)Ω = L - h -
   !> Σ Jw ω s, the components of spheres among the wheels.
   pure type(state_t) function state_of(system, t, q, p) result(state)
      type(system_t), intent(in) :: system
      !> Time, s; attitude and conjugate momentum, kg m²/s; shape (4).
      real(wp), intent(in) :: t, q(4), p(4)
      type(body_t) :: whole
      real(wp) :: omega(3), loaded(3, 3), inverse(3, 3)
      integer :: i
      state%t = t
      state%q = q
      state%p = p
      if (system%effects%n_wheels == 0) return
      whole = whole_body(system%body)
      associate (wheels => system%effects%wheels)
         inverse = whole%inverse_inertia
         if (system%effects%n_spheres > 0 .or. system%effects%varies) then
            loaded = whole%inertia
            do i = 1, size(wheels)
               associate (axis => wheels(i)%component)
                  if (axis > 0) loaded(axis, axis) = loaded(axis, axis) + wheels(i)%inertia
               end associate
            end do
            if (system%effects%varies) loaded = loaded + system%effects%inertia_term(0, t, t, 1.0_wp)
            inverse = symmetric_inverse(loaded)
         end if
         omega = matmul(inverse, body_momentum(state) - &
                        system%effects%inner_momentum([(wheels(i)%inertia*wheels(i)%speed, i=1, size(wheels))]))
         do i = 1, size(wheels)
            state%wheel_momentum(i) = wheels(i)%inertia*(wheels(i)%speed + dot_product(wheels(i)%axis, omega))
         end do
      end associate
   end function state_of

   !> Makes an empty stepper. Errors: `NUTATE_NO_MEMORY`.
   subroutine start_handle(handle, status)
      type(stepper_handle_t), pointer, intent(out) :: handle
      type(status_t), intent(out) :: status
      integer :: failed
      allocate (handle, stat=failed)
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for a stepper')
         return
      end if
      allocate (handle%group%settings(0))
      handle%group%name = 'integrator'
   end subroutine start_handle

   !> Stores a stepper in its slot, or frees it if making it failed.
   subroutine finish_handle(slot, handle, status)
      type(c_ptr), intent(inout) :: slot
      type(stepper_handle_t), pointer, intent(inout) :: handle
      type(status_t), intent(in) :: status
      if (status%ok()) then
         handle%mark = STEPPER_MARK
         slot = c_loc(handle)
      else
         deallocate (handle)
      end if
   end subroutine finish_handle

   !> Sets system, initial state and settings of a scene, and the quantities that its runs propagate.
   subroutine set_scene(handle, from, sets, status)
      type(stepper_handle_t), intent(inout), target :: handle
      type(scene_handle_t), intent(in) :: from
      !> Names of sets of columns.
      character(len=*), intent(in) :: sets(:)
      type(status_t), intent(out) :: status
      type(propagated_t) :: propagated
      call copy_system(from%scene%system, handle%system, c_loc(handle%failure))
      handle%run%requested = from%scene%integrator
      handle%run%summary%settings = handle%run%requested
      handle%plan = from%scene%plan
      handle%events = from%scene%events
      handle%group = first_group(from%scene%groups, 'integrator')
      propagated = from%scene%propagated()
      call set_propagated(handle, propagated)
      call set_chaos(handle, from%scene%chaos)
      call store_start(handle, from%scene%initial, sets, status)
      if (status%ok() .and. shows_derivatives(sets)) call find_variations(from%scene, handle, status)
   end subroutine set_scene

   !> Finds the sensitivities with respect to the parameters of a scene. Errors: `NUTATE_BAD_SCENE` if one does not
   !> exist.
   subroutine find_variations(scene, handle, status)
      type(scene_t), intent(in) :: scene
      !> Stepper; keeps its sensitivities if there is an error.
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      type(variation_t), allocatable :: variations(:)
      type(scene_error_t) :: error
      call lock_texts()
      call free_variations(scene, variations, error)
      if (error%raised) status = fail(NUTATE_BAD_SCENE, error_line(scene%file, error))
      call unlock_texts()
      if (status%ok()) call move_alloc(variations, handle%variations)
   end subroutine find_variations

   !> Stores the initial state and the sets of columns.
   subroutine store_start(handle, state, sets, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(state_t), intent(in) :: state
      character(len=*), intent(in) :: sets(:)
      type(status_t), intent(out) :: status
      type(propagated_t) :: propagated
      handle%sets = sets
      call get_propagated(handle, propagated)
      call lock_texts()
      call handle%columns%choose(handle%sets, status, effects=handle%system%effects, propagated=propagated)
      handle%names = handle%columns%header()
      call unlock_texts()
      if (status%ok()) call replace_state(handle, state, status)
   end subroutine store_start

   !> Tests time, attitude and the other numbers of a state. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_numbers(t, q, other, status)
      real(wp), intent(in) :: t, q(4), other(:)
      type(status_t), intent(out) :: status
      if (is_moderate(t) .and. all(is_moderate(other))) then
         call check_attitude(q, status)
      else
         status = fail(NUTATE_BAD_ARGUMENT, 'the state is not finite or too large (expected numbers up to '// &
                       in_words(greatest_number)//')')
      end if
   end subroutine check_numbers

   !> Replaces the present state. Energy and work are counted from the new one, the effects are switched as they were
   !> given, and no value is held. Errors: those of `set_state`.
   subroutine replace_state(handle, state, status)
      type(stepper_handle_t), intent(inout), target :: handle
      type(state_t), intent(in) :: state
      type(status_t), intent(out) :: status
      type(effect_list_t), allocatable :: switched
      if (allocated(handle%given)) then
         allocate (switched, source=handle%system%effects)
         handle%system%effects = handle%given
         handle%is_valid = .false.
         call report_failures_to(handle%system%effects, c_loc(handle%failure))
      end if
      call set_state(handle, state, status)
      if (allocated(switched) .and. .not. status%ok()) handle%system%effects = switched
   end subroutine replace_state

   !> Sets a state. Errors: `NUTATE_BAD_ARGUMENT` if momentum or energy is too large; those of callbacks.
   subroutine set_state(handle, state, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(state_t), intent(in) :: state
      type(status_t), intent(out) :: status
      type(integrator_settings_t) :: settings
      character(len=len(handle%run%summary%choice)) :: choice
      real(wp) :: energy, inverse_j0
      call check_motion(handle%system, state, status)
      if (.not. status%ok()) return
      inverse_j0 = handle%run%requested%inverse_auxiliary_inertia
      handle%failure = 0
      energy = conserved_energy(handle%system, state, inverse_j0)
      call add_failure(handle%failure, status)
      if (.not. status%ok()) return
      call handle%first%set(state)
      handle%first_energy = energy
      settings = handle%run%summary%settings
      choice = handle%run%summary%choice
      call start_run(handle%run%progress_t, handle%system%effects, state, run_plan_t(), status)
      handle%run%summary%settings = settings
      handle%run%summary%choice = choice
      call unprepare(handle)
      if (allocated(handle%run%spare)) handle%run%spare%keeps_system = handle%is_valid
      call handle%columns%start(handle%system, state, inverse_j0, handle%plan%time_step < 0.0_wp)
   end subroutine set_state

end module nutate_c_stepper
