!> Residuals of measurements, model less measured over the standard deviation, and their derivatives by the motion.
module nutate_fit_residuals
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_columns, only: columns_t
   use nutate_fit_variations, only: places, weights
   use nutate_fit_model, only: move_state
   use nutate_fit_plan, only: measurement_t, ATTITUDES, DIRECTIONS
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_observer, only: run_record_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_normalized, quat_product, rotate_to_body
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: residuals_t, inverse_right_jacobian, right_jacobian

   !> Change of a state, in angle and relative to its momentum, by which a column is differentiated.
   real(wp), parameter :: small_change = 1e-3_wp
   !> Angle below which the last term of the inverse right Jacobian is its limit, 1/12.
   real(wp), parameter :: small_angle = 1e-4_wp

   !> The residuals of one group of measurements.
   type :: residuals_t
      type(measurement_t) :: measurement
      type(columns_t), private :: columns
      real(wp), private :: inverse_j0 = 0.0_wp
      !> Row of the columns; shape (width of the row).
      real(wp), allocatable, private :: row(:)
   contains
      !> Prepares for a measurement of a system.
      procedure :: prepare
      !> Returns the columns of a row by the model.
      procedure :: model
      !> Computes the residuals of a row, and their derivatives.
      procedure :: evaluate
   end type residuals_t

contains

   !> Prepares for a measurement of a system. Errors: those of `choose`.
   subroutine prepare(self, measurement, system, inverse_j0, status)
      class(residuals_t), intent(inout) :: self
      type(measurement_t), intent(in) :: measurement
      type(system_t), intent(in) :: system
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      type(status_t), intent(out) :: status
      self%measurement = measurement
      self%inverse_j0 = inverse_j0
      if (.not. allocated(measurement%sets)) return
      call self%columns%choose(measurement%sets, status, measurement%degrees, system%effects)
      allocate (self%row(self%columns%width))
   end subroutine prepare

   !> Returns the columns of a row by the model; shape (columns).
   function model(self, system, state) result(values)
      class(residuals_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(size(self%measurement%columns))
      type(run_record_t) :: record
      select case (self%measurement%kind)
      case (ATTITUDES)
         values = quat_normalized(state%q)
      case (DIRECTIONS)
         values = rotate_to_body(quat_normalized(state%q), self%measurement%direction)
      case default
         call self%columns%start(system, state, self%inverse_j0)
         call self%columns%evaluate(system, state, record, self%row)
         values = self%row(self%measurement%places)
      end select
   end function model

   !> Computes the residuals of a row, and their derivatives by parameters, some of which change the system.
   subroutine evaluate(self, i, system, systems, weights, changes_system, state, sensitivities, residuals, jacobian)
      class(residuals_t), intent(inout) :: self
      !> Index of the row.
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      !> Systems at the points of the stencil of each parameter; shape (points, parameters).
      type(system_t), intent(in) :: systems(:, :)
      !> Weights of the points; shape (points, parameters).
      real(wp), intent(in) :: weights(:, :)
      !> True for a parameter on which the system depends; shape (parameters).
      logical, intent(in) :: changes_system(:)
      type(state_t), intent(in) :: state
      !> Derivative of the state; shape (6 + wheels, parameters).
      real(wp), intent(in) :: sensitivities(:, :)
      !> Residuals and their derivatives; shape (residuals of a row) and (residuals of a row, parameters).
      real(wp), intent(out) :: residuals(:), jacobian(:, :)
      real(wp) :: e(3), gamma(3), values(size(self%measurement%columns))
      integer :: k
      associate (measured => self%measurement%rows(:, i), sigma => self%measurement%sigma)
         select case (self%measurement%kind)
         case (ATTITUDES)
            e = rotation_vector_from_quat(quat_product(quat_conjugate(measured), quat_normalized(state%q)))
            residuals = e
            jacobian = matmul(inverse_right_jacobian(e), sensitivities(1:3, :))
         case (DIRECTIONS)
            gamma = rotate_to_body(quat_normalized(state%q), self%measurement%direction)
            residuals = gamma - measured
            do k = 1, size(sensitivities, 2)
               jacobian(:, k) = cross(gamma, sensitivities(1:3, k))
            end do
         case default
            values = self%model(system, state)
            residuals = wrapped(values - measured, self%measurement%turns)
            do k = 1, size(sensitivities, 2)
               jacobian(:, k) = slope(self, system, state, values, sensitivities(:, k))
               if (changes_system(k)) &
                  jacobian(:, k) = jacobian(:, k) + slope_of_system(self, systems(:, k), weights(:, k), state, values)
            end do
         end select
         residuals = residuals/sigma
         do k = 1, size(jacobian, 2)
            jacobian(:, k) = jacobian(:, k)/sigma
         end do
      end associate
   end subroutine evaluate

   !> Returns the derivative of the columns along a change of the state; shape (columns).
   function slope(self, system, state, values, change)
      class(residuals_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Columns of the state.
      real(wp), intent(in) :: values(:), change(:)
      real(wp) :: slope(size(values))
      type(state_t) :: moved
      real(wp) :: size_of_change, step
      integer :: k
      slope = 0.0_wp
      size_of_change = norm2(change(1:3))
      if (norm2(body_momentum(state)) > 0.0_wp) &
         size_of_change = size_of_change + norm2(change(4:6))/norm2(body_momentum(state))
      step = 1.0_wp
      if (size_of_change > 0.0_wp) step = small_change/size_of_change
      if (all(abs(change) <= 0.0_wp)) return
      moved = state
      do k = 1, size(places)
         call move_state(state, places(k)*step*change, moved)
         slope = slope + weights(k)/step*wrapped(self%model(system, moved) - values, self%measurement%turns)
      end do
   end function slope

   !> Returns the derivative of the columns by a parameter of the system, with the state fixed; shape (columns).
   function slope_of_system(self, systems, weights, state, values) result(slope)
      class(residuals_t), intent(inout) :: self
      !> Systems at the points of the stencil.
      type(system_t), intent(in) :: systems(:)
      real(wp), intent(in) :: weights(:)
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: values(:)
      real(wp) :: slope(size(values))
      integer :: k
      slope = 0.0_wp
      do k = 1, size(systems)
         slope = slope + weights(k)*wrapped(self%model(systems(k), state) - values, self%measurement%turns)
      end do
   end function slope_of_system

   !> Returns differences of angles without whole revolutions.
   elemental real(wp) function wrapped(difference, turn)
      real(wp), intent(in) :: difference
      !> Revolution in the unit of the angle; 0 if the difference is no angle.
      real(wp), intent(in) :: turn
      wrapped = difference
      if (turn > 0.0_wp) wrapped = difference - turn*anint(difference/turn)
   end function wrapped

   !> Computes J_r⁻¹(e), by which log(q_obs*∘q) changes if q rotates in body axes; shape (3, 3).
   pure function inverse_right_jacobian(e) result(matrix)
      !> Rotation vector, rad.
      real(wp), intent(in) :: e(3)
      real(wp) :: matrix(3, 3), angle, factor, skew(3, 3)
      skew = reshape([0.0_wp, e(3), -e(2), -e(3), 0.0_wp, e(1), e(2), -e(1), 0.0_wp], [3, 3])
      angle = norm2(e)
      factor = 1/12.0_wp
      if (angle > small_angle) factor = (1 - 0.5_wp*angle/tan(0.5_wp*angle))/angle**2
      matrix = 0.5_wp*skew + factor*matmul(skew, skew)
      matrix(1, 1) = matrix(1, 1) + 1
      matrix(2, 2) = matrix(2, 2) + 1
      matrix(3, 3) = matrix(3, 3) + 1
   end function inverse_right_jacobian

   !> Computes J_r(e), the rotation in body axes that a change of a rotation vector makes; shape (3, 3).
   pure function right_jacobian(e) result(matrix)
      !> Rotation vector, rad; shape (3).
      real(wp), intent(in) :: e(3)
      real(wp) :: matrix(3, 3), angle, first, second, unit(3)
      !> Angle below which the next terms of the series are rounding.
      real(wp), parameter :: series_angle = 1e-2_wp
      integer :: i
      angle = norm2(e)
      if (angle < series_angle) then
         first = 0.5_wp - angle**2/24 + angle**4/720
         second = 1/6.0_wp - angle**2/120 + angle**4/5040
      else
         first = 2*sin(angle/2)**2/angle**2
         second = (angle - sin(angle))/angle**3
      end if
      do i = 1, 3
         unit = 0.0_wp
         unit(i) = 1.0_wp
         matrix(:, i) = unit - first*cross(e, unit) + second*cross(e, cross(e, unit))
      end do
   end function right_jacobian

end module nutate_fit_residuals
