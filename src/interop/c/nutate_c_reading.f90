!> C interface: the state of a stepper. The functions are documented in `include/nutate_stepper.h`.
module nutate_c_reading
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int64_t, c_ptr, c_size_t
   use nutate_attitude, only: euler_from_quat
   use nutate_c_effects, only: add_failure
   use nutate_c_stepper_handle, only: conclude, found, get_propagated, lacks_attitude, left_out, null_argument, &
      stepper_handle_t, unprepare
   use nutate_c_rows, only: present_record
   use nutate_c_text, only: lock_texts, nth_name, copy_text, text_to_c, unlock_texts
   use nutate_columns, only: columns_t, need_attitude
   use nutate_free_variations, only: shows_derivatives
   use nutate_hamiltonian, only: angular_velocity, body_momentum, kinetic_energy, potential_energy, space_momentum
   use nutate_invariants, only: conserved_momentum
   use nutate_keys, only: name_length
   use nutate_kinds, only: wp
   use nutate_progress, only: total_work
   use nutate_quaternion, only: quat_normalized, rotate_to_space, rotation_matrix
   use nutate_spelling, only: split_list
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OK
   use nutate_propagated, only: propagated_t
   implicit none
   private

   public :: find_readable
   public :: nutate_stepper_time, nutate_stepper_quaternion, nutate_stepper_conjugate_momentum, &
      nutate_stepper_angular_velocity, nutate_stepper_angular_velocity_space, nutate_stepper_angular_momentum, &
      nutate_stepper_angular_momentum_space, nutate_stepper_matrix, nutate_stepper_euler, nutate_stepper_energy, &
      nutate_stepper_constraints, nutate_stepper_conserved, nutate_stepper_solver, nutate_stepper_uncertified, &
      nutate_stepper_accuracy
   public :: nutate_stepper_set_columns, nutate_stepper_width, nutate_stepper_column, nutate_stepper_column_names, &
      nutate_stepper_row, choose_columns

contains

   integer(c_int) function nutate_stepper_time(stepper, t) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: t
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(t), .false., handle, code)
      if (code == NUTATE_OK) t = handle%run%state%t
   end function nutate_stepper_time

   integer(c_int) function nutate_stepper_quaternion(stepper, q) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: q(4)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(q), .true., handle, code)
      if (code == NUTATE_OK) q = handle%run%state%q
   end function nutate_stepper_quaternion

   integer(c_int) function nutate_stepper_conjugate_momentum(stepper, p) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: p(4)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(p), .true., handle, code)
      if (code == NUTATE_OK) p = handle%run%state%p
   end function nutate_stepper_conjugate_momentum

   integer(c_int) function nutate_stepper_angular_velocity(stepper, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: omega(3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(omega), .false., handle, code)
      if (code == NUTATE_OK) omega = angular_velocity(handle%system, handle%run%state)
   end function nutate_stepper_angular_velocity

   integer(c_int) function nutate_stepper_angular_velocity_space(stepper, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: omega(3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(omega), .true., handle, code)
      if (code == NUTATE_OK) omega = rotate_to_space(quat_normalized(handle%run%state%q), &
                                                     angular_velocity(handle%system, handle%run%state))
   end function nutate_stepper_angular_velocity_space

   integer(c_int) function nutate_stepper_angular_momentum(stepper, momentum) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: momentum(3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(momentum), .false., handle, code)
      if (code == NUTATE_OK) momentum = body_momentum(handle%run%state)
   end function nutate_stepper_angular_momentum

   integer(c_int) function nutate_stepper_angular_momentum_space(stepper, momentum) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: momentum(3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(momentum), .true., handle, code)
      if (code == NUTATE_OK) momentum = space_momentum(handle%run%state)
   end function nutate_stepper_angular_momentum_space

   integer(c_int) function nutate_stepper_matrix(stepper, r) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      !> Rotation matrix, body to space, as C's r[3][3]: the transpose of this array.
      real(c_double), intent(inout), optional :: r(3, 3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(r), .true., handle, code)
      if (code == NUTATE_OK) r = transpose(rotation_matrix(quat_normalized(handle%run%state%q)))
   end function nutate_stepper_matrix

   integer(c_int) function nutate_stepper_euler(stepper, angles) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: angles(3)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(angles), .true., handle, code)
      if (code == NUTATE_OK) call euler_from_quat(handle%run%state%q, angles(1), angles(2), angles(3))
   end function nutate_stepper_euler

   integer(c_int) function nutate_stepper_energy(stepper, energy) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: energy(5)
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      real(wp) :: kinetic, potential, frame, work
      call find_readable(stepper, present(energy), .false., handle, code)
      if (code /= NUTATE_OK) return
      handle%failure = 0
      kinetic = kinetic_energy(handle%system, handle%run%state, handle%run%requested%inverse_auxiliary_inertia)
      potential = potential_energy(handle%system%effects, handle%run%state%q, handle%run%state%t)
      frame = dot_product(handle%system%effects%frame_rate, space_momentum(handle%run%state))
      work = total_work(handle%run%summary)
      call add_failure(handle%failure, status)
      if (status%ok()) energy = [kinetic, potential, kinetic + potential, work - handle%run%state%time_dependent_work, &
                                 kinetic + potential - frame - handle%first_energy - work]
      code = conclude(handle, status)
   end function nutate_stepper_energy

   integer(c_int) function nutate_stepper_constraints(stepper, constraints) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: constraints(2)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(constraints), .true., handle, code)
      if (code == NUTATE_OK) constraints = [dot_product(handle%run%state%q, handle%run%state%q) - 1, &
                                            dot_product(handle%run%state%q, handle%run%state%p)]
   end function nutate_stepper_constraints

   integer(c_int) function nutate_stepper_conserved(stepper, components, axis) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_int), intent(inout), optional :: components
      real(c_double), intent(inout), optional :: axis(3)
      type(stepper_handle_t), pointer :: handle
      integer :: which
      real(wp) :: along(3)
      call find_readable(stepper, present(components), .false., handle, code)
      if (code /= NUTATE_OK) return
      call conserved_momentum(handle%system%effects, which, along)
      components = which
      if (present(axis)) axis = along
   end function nutate_stepper_conserved

   integer(c_int) function nutate_stepper_accuracy(stepper, error) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: error(2)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(error), .false., handle, code)
      if (code == NUTATE_OK) error = [handle%run%summary%estimate, handle%run%summary%round_off]
   end function nutate_stepper_accuracy

   integer(c_int) function nutate_stepper_solver(stepper, iterations, residual) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_int), intent(inout), optional :: iterations
      real(c_double), intent(inout), optional :: residual
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, .true., .false., handle, code)
      if (code /= NUTATE_OK) return
      if (present(iterations)) iterations = 0
      if (present(residual)) residual = 0.0_wp
      if (.not. allocated(handle%run%stepper)) return
      if (present(iterations)) iterations = handle%run%stepper%iterations
      if (present(residual)) residual = handle%run%stepper%residual
   end function nutate_stepper_solver

   integer(c_int) function nutate_stepper_uncertified(stepper, steps) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_int64_t), intent(inout), optional :: steps
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(steps), .false., handle, code)
      if (code /= NUTATE_OK) return
      steps = handle%run%summary%uncertified_steps
   end function nutate_stepper_uncertified

   integer(c_int) function nutate_stepper_set_columns(stepper, sets) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, sets
      type(stepper_handle_t), pointer :: handle
      character(len=:), allocatable :: list
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      call copy_text(sets, list)
      if (list == '') then
         status = fail(NUTATE_BAD_ARGUMENT, 'no set of columns is given', 'sets')
      else
         call choose_columns(handle, adjustl(split_list(list)), status)
      end if
      code = conclude(handle, status)
   end function nutate_stepper_set_columns

   integer(c_int) function nutate_stepper_width(stepper, width) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(inout), optional :: width
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(width), .false., handle, code)
      if (code == NUTATE_OK) width = handle%columns%width
   end function nutate_stepper_width

   integer(c_int) function nutate_stepper_column(stepper, column, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, buffer
      integer(c_size_t), intent(in), value :: column, size
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, .true., .false., handle, code)
      if (code /= NUTATE_OK) return
      code = NUTATE_BAD_ARGUMENT
      if (column < 0 .or. column >= handle%columns%width) return
      code = text_to_c(trim(nth_name(handle%names, int(column) + 1)), buffer, size)
   end function nutate_stepper_column

   integer(c_int) function nutate_stepper_column_names(stepper, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, buffer
      integer(c_size_t), intent(in), value :: size
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, .true., .false., handle, code)
      if (code == NUTATE_OK) code = text_to_c(handle%names, buffer, size)
   end function nutate_stepper_column_names

   integer(c_int) function nutate_stepper_row(stepper, row, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(in), value :: size
      real(c_double), intent(inout), optional :: row(*)
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      associate (width => handle%columns%width)
         if (.not. present(row)) then
            status = null_argument('row')
         else if (size >= 0 .and. size < width) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the array for the row is too small', 'size')
         else if (handle%columns%differentiates) then
            status = fail(NUTATE_BAD_ARGUMENT, 'only runs have columns of what they propagate (expected other '// &
                          'columns, or a run)', 'row')
         else
            handle%failure = 0
            call handle%columns%evaluate(handle%system, handle%run%state, present_record(handle), row(1:width))
            call add_failure(handle%failure, status)
         end if
      end associate
      code = conclude(handle, status)
   end function nutate_stepper_row

   !> Finds a stepper that can be read.
   subroutine find_readable(stepper, complete, needs_attitude, handle, code)
      type(c_ptr), intent(in) :: stepper
      !> True if no required argument is null.
      logical, intent(in) :: complete
      !> True if the attitude is to be read.
      logical, intent(in) :: needs_attitude
      type(stepper_handle_t), pointer, intent(out) :: handle
      !> Status code: `NUTATE_BAD_HANDLE`; `NUTATE_BAD_ARGUMENT` for a null argument, or an attitude that is not
      !> integrated.
      integer(c_int), intent(out) :: code
      if (.not. found(stepper, handle, code)) return
      code = NUTATE_OK
      if (.not. complete) then
         code = conclude(handle, null_argument('an argument'))
      else if (needs_attitude .and. .not. handle%run%summary%settings%attitude) then
         code = conclude(handle, fail(NUTATE_BAD_ARGUMENT, left_out//', which no column shows (expected a column '// &
                                      'such as quaternion before the first step)'))
      end if
   end subroutine find_readable

   !> Selects the sets of columns. Errors: those of `choose` of the columns, those of callbacks; `NUTATE_BAD_ARGUMENT`
   !> for columns of derivatives without sensitivities.
   subroutine choose_columns(handle, sets, status)
      type(stepper_handle_t), intent(inout) :: handle
      !> Names of the sets.
      character(len=*), intent(in) :: sets(:)
      type(status_t), intent(out) :: status
      character(len=name_length), allocatable :: chosen(:)
      character(len=:), allocatable :: names
      type(columns_t) :: columns
      type(propagated_t) :: propagated
      chosen = sets
      call get_propagated(handle, propagated)
      call lock_texts()
      call columns%choose(chosen, status, effects=handle%system%effects, propagated=propagated)
      if (status%ok()) names = columns%header()
      call unlock_texts()
      if (status%ok() .and. shows_derivatives(chosen) .and. .not. allocated(handle%variations)) &
         status = fail(NUTATE_BAD_ARGUMENT, 'nothing says by what runs differentiate (expected '// &
                       'nutate_stepper_differentiate)', 'sets')
      if (status%ok() .and. need_attitude(chosen) .and. lacks_attitude(handle)) &
         status = fail(NUTATE_BAD_ARGUMENT, left_out//' (expected these columns before the first step, or a new '// &
                       'state)', 'sets')
      if (.not. status%ok()) return
      handle%failure = 0
      call columns%start(handle%system, handle%first%state(), handle%run%requested%inverse_auxiliary_inertia, &
                         handle%plan%time_step < 0.0_wp)
      call add_failure(handle%failure, status)
      if (.not. status%ok()) return
      if (columns%follows_steps) call columns%follow(handle%run%state)
      handle%columns = columns
      handle%sets = chosen
      handle%names = names
      if (need_attitude(chosen)) handle%run%requested%attitude = .true.
      handle%run%summary%settings%attitude = handle%run%requested%attitude
      call unprepare(handle)
   end subroutine choose_columns

end module nutate_c_reading
