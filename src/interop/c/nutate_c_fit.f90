!> C interface: fits of scenes, and their residuals. The functions are documented in `include/nutate_scene.h`.
module nutate_c_fit
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr, c_size_t
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_c_polls, only: trial_observer_t
   use nutate_c_scene_handle, only: conclude, found, null_argument, report, scene_handle_t
   use nutate_c_text, only: text_to_c
   use nutate_fit, only: fit_scene, fit_t
   use nutate_fit_problem, only: fit_problem_t
   use nutate_fit_warning, only: misfit_text
   use nutate_fit_residuals, only: inverse_right_jacobian, right_jacobian
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_robust_loss, only: loss_of, LINEAR
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NOT_CONVERGED, NUTATE_OK
   implicit none
   private

   public :: nutate_fit_size, nutate_fit_name, nutate_fit_start, nutate_fit_evaluate, nutate_fit_cost, nutate_fit_solve

contains

   integer(c_int) function nutate_fit_size(scene, parameters, residuals) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      integer(c_size_t), intent(inout), optional :: parameters, residuals
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call prepare(handle, status)
      if (status%ok()) then
         if (present(parameters)) parameters = size(handle%fit%names)
         if (present(residuals)) residuals = handle%fit%measured_in_arc() + &
            count(handle%fit%model%plan%free%sigma > 0.0_wp)
      end if
      code = conclude(handle, status)
   end function nutate_fit_size

   integer(c_int) function nutate_fit_name(scene, parameter, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, buffer
      integer(c_size_t), intent(in), value :: parameter, size
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(scene, handle, code)) return
      call prepare(handle, status)
      code = conclude(handle, status)
      if (.not. status%ok()) return
      code = NUTATE_BAD_ARGUMENT
      if (parameter < 0 .or. parameter >= ubound(handle%fit%names, 1)) return
      code = text_to_c(trim(handle%fit%names(parameter + 1)), buffer, size)
   end function nutate_fit_name

   integer(c_int) function nutate_fit_start(scene, x, low, high) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(inout), optional :: x(*), low(*), high(*)
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      integer :: n
      if (.not. found(scene, handle, code)) return
      call prepare(handle, status)
      if (status%ok()) then
         n = size(handle%fit%names)
         if (present(x)) x(:n) = 0.0_wp
         if (present(x)) x(:handle%fit%n_free) = handle%fit%known_values
         if (present(low)) low(:n) = handle%fit%low
         if (present(high)) high(:n) = handle%fit%high
      end if
      code = conclude(handle, status)
   end function nutate_fit_start

   integer(c_int) function nutate_fit_evaluate(scene, x, residuals, jacobian) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(in), optional :: x(*)
      real(c_double), intent(inout), optional :: residuals(*), jacobian(*)
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      real(wp), allocatable :: r(:), j(:, :)
      integer :: i, n
      if (.not. found(scene, handle, code)) return
      call prepare(handle, status)
      if (status%ok()) call evaluate_at(handle, x, r, j, status)
      if (status%ok()) then
         n = size(handle%fit%names)
         call by_vector(handle%fit, x(:n), j)
         if (present(residuals)) residuals(:size(r)) = r
         if (present(jacobian)) then
            do i = 1, size(r)
               jacobian((i - 1)*n + 1:i*n) = j(i, :)
            end do
         end if
      end if
      code = conclude(handle, status)
   end function nutate_fit_evaluate

   integer(c_int) function nutate_fit_cost(scene, x, cost) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene
      real(c_double), intent(in), optional :: x(*)
      real(c_double), intent(inout), optional :: cost
      type(scene_handle_t), pointer :: handle
      type(status_t) :: status
      real(wp), allocatable :: r(:), j(:, :)
      real(wp) :: rho(3)
      integer :: i
      if (.not. found(scene, handle, code)) return
      call prepare(handle, status)
      if (status%ok()) call evaluate_at(handle, x, r, j, status)
      if (status%ok() .and. present(cost)) then
         cost = 0.0_wp
         do i = 1, size(r)
            rho = loss_of(LINEAR, r(i)**2)
            if (allocated(handle%fit%losses)) rho = loss_of(handle%fit%losses(i), r(i)**2)
            cost = cost + 0.5_wp*rho(1)
         end do
      end if
      code = conclude(handle, status)
   end function nutate_fit_cost

   integer(c_int) function nutate_fit_solve(scene, x, covariance, converged, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, message
      real(c_double), intent(inout), optional :: x(*), covariance(*)
      integer(c_int), intent(inout), optional :: converged
      integer(c_size_t), intent(in), value :: size
      type(scene_handle_t), pointer :: handle
      type(fit_t) :: fit
      type(trial_observer_t), target :: observer
      type(status_t) :: status
      real(wp), allocatable :: values(:), errors(:, :)
      integer :: n
      if (.not. found(scene, handle)) then
         status = fail(NUTATE_BAD_HANDLE, 'scene is NULL, destroyed or not a scene')
      else
         observer%callback = handle%poll
         call fit_scene(handle%scene, fit, status, observer)
         if (fit%best > 0) then
            call to_vectors(fit, values, errors)
            n = ubound(values, 1)
            if (present(x)) x(:n) = values
            if (present(covariance)) covariance(:n*n) = reshape(errors, [n*n])
            if (status%ok() .and. fit%exceeds_noise()) status = fail(NUTATE_NOT_CONVERGED, misfit_text(fit))
            if (present(converged)) converged = merge(1, 0, status%ok())
            status%code = NUTATE_OK
         end if
      end if
      code = report(status, message, size)
   end function nutate_fit_solve

   !> Evaluates residuals and derivatives. Errors: `NUTATE_BAD_ARGUMENT` for an x that is missing or not finite; those
   !> of the problem.
   subroutine evaluate_at(handle, x, residuals, jacobian, status)
      type(scene_handle_t), intent(inout) :: handle
      real(c_double), intent(in), optional :: x(*)
      real(wp), allocatable, intent(inout) :: residuals(:), jacobian(:, :)
      type(status_t), intent(out) :: status
      integer :: n
      if (.not. present(x)) then
         status = null_argument('x')
         return
      end if
      n = size(handle%fit%names)
      if (.not. all(abs(x(:n)) <= huge(1.0_wp))) status = fail(NUTATE_BAD_ARGUMENT, 'x is not finite', 'x')
      if (status%ok()) call handle%fit%evaluate(x(:n), residuals, jacobian, status)
   end subroutine evaluate_at

   !> Prepares the problem of a scene, unless that has been done.
   subroutine prepare(handle, status)
      type(scene_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      if (allocated(handle%fit)) return
      if (.not. handle%scene%fit%active()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'there is nothing to fit (expected &free and &measurement)')
         return
      end if
      allocate (handle%fit)
      call handle%fit%prepare(handle%scene, status)
      if (.not. status%ok()) deallocate (handle%fit)
   end subroutine prepare

   !> Replaces the derivatives with respect to a further rotation by those with respect to the rotation vector of the
   !> attitude.
   subroutine by_vector(problem, x, jacobian)
      type(fit_problem_t), intent(in) :: problem
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: jacobian(:, :)
      integer, allocatable :: at(:)
      at = turns(problem)
      if (size(at) == 3) jacobian(:, at) = matmul(jacobian(:, at), right_jacobian(problem%model%plan%angle_unit*x(at)))
   end subroutine by_vector

   !> Returns the indices of the three attitude components among the parameters; none if the attitude is not free.
   pure function turns(problem) result(at)
      type(fit_problem_t), intent(in) :: problem
      integer, allocatable :: at(:)
      integer :: i
      associate (component => problem%model%plan%free%component)
         if (problem%model%plan%has_attitude) then
            at = [(findloc(component, i, dim=1), i=1, 3)]
         else
            allocate (at(0))
         end if
      end associate
   end function turns

   !> Returns the parameters of a fit and their covariance, its attitude as the rotation vector from that of the scene.
   subroutine to_vectors(fit, x, covariance)
      type(fit_t), intent(in) :: fit
      real(wp), allocatable, intent(out) :: x(:), covariance(:, :)
      real(wp) :: turn(3), matrix(3, 3)
      integer, allocatable :: at(:)
      x = fit%result%x
      covariance = fit%result%covariance
      at = turns(fit%problem)
      if (size(at) /= 3) return
      associate (plan => fit%problem%model%plan)
         turn = rotation_vector_from_quat(quat_product(quat_conjugate(fit%problem%known_attitude), plan%attitude))
         x(at) = turn/plan%angle_unit
      end associate
      matrix = inverse_right_jacobian(turn)
      covariance(at, :) = matmul(matrix, covariance(at, :))
      covariance(:, at) = matmul(covariance(:, at), transpose(matrix))
   end subroutine to_vectors

end module nutate_c_fit
