!> C interface: states inside steps of earlier runs. The functions are documented in `include/nutate_runs.h`.
module nutate_c_dense_output
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr, c_size_t
   use nutate_c_effects, only: add_failure, status_of_failure
   use nutate_c_stepper_handle, only: conclude, found, null_argument, stepper_handle_t
   use nutate_c_settings, only: prepare_if_needed
   use nutate_columns, only: columns_t
   use nutate_control, only: needs_control
   use nutate_free_variations, only: shows_indicators
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate, same_time
   use nutate_methods, only: make_stepper
   use nutate_observer, only: run_record_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, &
      NUTATE_SINGULAR
   use nutate_stepper, only: step_goal_t
   use nutate_tangent, only: tangent_t
   use nutate_window_edges, only: cross_window_edges
   implicit none
   private

   public :: nutate_stepper_dense_output

   !> Largest number of halvings of a step that fails.
   integer, parameter :: most_halvings = 10

contains

   integer(c_int) function nutate_stepper_dense_output(stepper, t, q, p, derivatives, dt, n, times, rows) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: stepper, derivatives, rows
      real(c_double), intent(in), value :: t, dt
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), optional :: q(4), p(4), times(n)
      type(stepper_handle_t), pointer :: handle
      real(c_double), pointer :: values(:, :), start(:, :)
      type(tangent_t) :: tangent
      type(state_t) :: state
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. (present(q) .and. present(p) .and. present(times) .and. c_associated(rows))) then
         code = conclude(handle, null_argument('q, p, times or rows'))
         return
      end if
      call get_ready(handle, status)
      if (status%ok() .and. .not. (is_moderate(t) .and. is_moderate(dt) .and. abs(dt) > 0.0_wp .and. &
                                   are_in_order(t, dt, times))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'dt is 0, or the times are not in order from t', 'times')
      if (status%ok()) then
         state%t = t
         state%q = q
         state%p = p
         call c_f_pointer(rows, values, [int(handle%columns%width, c_size_t), n])
         handle%failure = 0
         if (handle%columns%differentiates) then
            if (n > 0 .and. .not. c_associated(derivatives)) status = null_argument('derivatives')
            if (status%ok() .and. n > 0) then
               call c_f_pointer(derivatives, start, [6, size(handle%variations)])
               call tangent%begin(handle%system, state, handle%variations, status)
               if (status%ok()) call tangent%resume(handle%system, state, transpose(start(:3, :)), &
                                                    transpose(start(4:, :)))
            end if
         end if
         if (status%ok()) call evaluate_from(handle, state, dt, times, values, status, tangent)
         call add_failure(handle%failure, status)
      end if
      code = conclude(handle, status)
   end function nutate_stepper_dense_output

   !> Prepares the stepper that repeats steps. Errors: `NUTATE_BAD_ARGUMENT` if a state has more to it than attitude and
   !> momentum, or if columns are chaos indicators; those of `prepare`.
   subroutine get_ready(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      if (needs_control(handle%system%effects) .or. handle%system%effects%n_wheels > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, &
                       'q and p are not the whole state: there are wheels, or a controller '// &
                       'with a sample or limits (expected rows of a run at user-defined times)', 'stepper')
         return
      end if
      if (shows_indicators(handle%sets)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'indicators of chaos are those of a run (expected other columns)', &
                       'stepper')
         return
      end if
      call prepare_if_needed(handle, status)
      if (allocated(handle%inside) .or. .not. status%ok()) return
      call make_stepper(handle%system, handle%run%summary%settings, handle%inside, status)
      if (status%ok()) call handle%inside%keep_steps()
   end subroutine get_ready

   !> Returns true if a run from `t` reaches the times one after the other.
   pure logical function are_in_order(t, dt, times)
      !> Time of the state, time step and times of the rows, s.
      real(wp), intent(in) :: t, dt, times(:)
      real(wp) :: sense
      sense = sign(1.0_wp, dt)
      are_in_order = all(is_moderate(times)) .and. all(sense*(times(2:) - times(:size(times) - 1)) >= 0.0_wp)
      if (size(times) > 0) are_in_order = are_in_order .and. sense*(times(1) - t) >= 0.0_wp
   end function are_in_order

   !> Evaluates rows at times of the motion from a state. Errors: those of the steps.
   subroutine evaluate_from(handle, state, dt, times, rows, status, tangent)
      type(stepper_handle_t), intent(inout) :: handle
      type(state_t), intent(inout) :: state
      !> Length of whole steps and times of the rows, s.
      real(wp), intent(in) :: dt, times(:)
      !> Rows; shape (width, number of times).
      real(wp), intent(inout) :: rows(:, :)
      type(status_t), intent(inout) :: status
      !> Sensitivities at the state, if the rows show derivatives; overwritten.
      type(tangent_t), intent(inout) :: tangent
      type(columns_t) :: columns
      type(tangent_t) :: inside
      type(run_record_t) :: record
      type(state_t) :: there
      real(wp) :: since, before
      real(wp), dimension(size(handle%inside%work)) :: works, each
      integer :: i
      columns = handle%columns
      call columns%start(handle%system, state, handle%run%requested%inverse_auxiliary_inertia, dt < 0.0_wp)
      works = 0.0_wp
      i = 1
      do while (i <= size(times))
         before = state%t
         call take_step(handle, state, dt, status)
         if (status%code == 0 .and. .not. abs(state%t - before) > 0.0_wp .and. abs(times(i) - state%t) > 0.0_wp) &
            status = fail(NUTATE_BAD_ARGUMENT, 'dt is too short to change the time (expected a longer step)', 'dt')
         do while (i <= size(times))
            if (status%code /= 0) return
            if (sign(1.0_wp, dt)*(times(i) - state%t) > 0.0_wp) exit
            call handle%inside%state_at(handle%system, times(i), there, since, status, each)
            record%work = sum(works) + since
            record%works = [works + each, 0.0_wp]
            inside = tangent
            if (tangent%n > 0 .and. status%code == 0) &
               call handle%inside%propagate_inside(handle%system, there, inside, status)
            if (tangent%n > 0 .and. status%code == 0 .and. .not. abs(times(i) - state%t) > 0.0_wp) &
               call cross_windows(handle, there, dt, inside)
            if (status%code == 0) call columns%evaluate(handle%system, there, record, rows(:, i), inside)
            i = i + 1
         end do
         if (tangent%n > 0 .and. i <= size(times)) call propagate_on(handle, state, dt, tangent, status)
         works = works + handle%inside%work
      end do
   end subroutine evaluate_from

   !> Propagates sensitivities over the step that led to a state.
   subroutine propagate_on(handle, state, dt, tangent, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(state_t), intent(in) :: state
      !> Length of whole steps, s.
      real(wp), intent(in) :: dt
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      associate (stepper => handle%inside)
         call stepper%propagate(handle%system, stepper%last_start, state, state%t - stepper%last_start%t, &
                            stepper%last_window, tangent, status)
      end associate
      if (status%code == 0) call cross_windows(handle, state, dt, tangent)
   end subroutine propagate_on

   !> Propagates sensitivities at the end of a step across the torques that start or stop there.
   subroutine cross_windows(handle, state, dt, tangent)
      type(stepper_handle_t), intent(in) :: handle
      type(state_t), intent(in) :: state
      !> Length of whole steps, s.
      real(wp), intent(in) :: dt
      type(tangent_t), intent(inout) :: tangent
      real(wp), allocatable :: change(:)
      if (tangent%moves_windows) call cross_window_edges( &
         handle%system, state, [handle%inside%last_start%t, state%t] + same_time*dt, sign(1.0_wp, dt), tangent, change)
   end subroutine cross_windows

   !> Performs a step, shortened if a torque starts or stops before its end, if the method chooses so, or if it fails.
   subroutine take_step(handle, state, dt, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(state_t), intent(inout) :: state
      !> Length of whole steps, s.
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      real(wp) :: length, chosen, sense, margin, next_break
      integer :: i
      sense = sign(1.0_wp, dt)
      margin = same_time*abs(dt)
      length = dt
      next_break = handle%system%effects%next_break(state%t + sense*margin, sense)
      if (sense*(state%t + dt - next_break) > margin) length = next_break - state%t
      associate (goal => handle%plan%goal)
         chosen = abs(length)
         if (goal%active()) call handle%inside%choose_step(handle%system, state, step_goal_t( &
            tolerance=goal%local_tolerance, rate=goal%error_rate, end_time=state%t + length), chosen, status)
         if (chosen < abs(length)) length = sense*chosen
      end associate
      if (status%code /= 0) return
      do i = 0, most_halvings
         call handle%inside%step(handle%system, state, length, status)
         if (handle%failure(1) /= 0) status = status_of_failure(handle%failure)
         if (all(status%code /= [NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR])) return
         length = 0.5_wp*length
      end do
   end subroutine take_step

end module nutate_c_dense_output
