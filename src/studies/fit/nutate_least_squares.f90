!> Nonlinear least squares by the method of Levenberg and Marquardt, with bounds, robust losses, standard errors, and a
!> statement of what the residuals do not determine.
!>
!> The columns of the Jacobian are scaled to length 1. The QR factors of the scaled Jacobian (LAPACK `dgeqrf`), and the
!> singular values of R, give the step for any λ, its length in standard errors, the covariance, and the directions that
!> change nothing; the normal equations, which square the condition number, are never formed.
module nutate_least_squares
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp, eps
   use nutate_lapack, only: dgeqrf, dgesvd, dormqr, handle_info
   use nutate_robust_loss, only: weigh
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_IO, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_STOPPED
   implicit none
   private

   public :: least_squares_problem_t, least_squares_result_t, least_squares_settings_t, minimize
   public :: UNKNOWN_BELOW, WEAK_BELOW

   !> Singular values of the scaled Jacobian, relative to the largest, below which a direction is not identifiable, and
   !> below which it is weakly determined.
   real(wp), parameter :: UNKNOWN_BELOW = 1e-10_wp, WEAK_BELOW = 1e-3_wp
   !> First damping; its factor after a step that fails, and divisor after one that succeeds; beyond the greatest no
   !> step is short enough.
   real(wp), parameter :: first_damping = 1e-3_wp, change = 10.0_wp, greatest_damping = 1e14_wp
   !> Remaining step below which a stalled iteration is treated as converged, in standard errors.
   real(wp), parameter :: near = 1e-3_wp
   !> A fit stalls if that many iterations reduce the sum by less than this share of the reduction that the linearised
   !> problem still predicts.
   integer, parameter :: stall_iterations = 20
   real(wp), parameter :: stall_share = 0.1_wp
   !> Least curvature of a loss relative to its slope while iterating.
   real(wp), parameter :: least_curvature = 0.1_wp
   !> A parameter that, changed by its usual size, changes the residuals by less than this share of the largest such
   !> change, changes them by rounding only.
   real(wp), parameter :: rounding = 1e-11_wp
   !> A parameter takes part in a direction if its component, with columns scaled, exceeds this share.
   real(wp), parameter :: share = 1e-5_wp

   !> A problem: residuals as a function of parameters.
   type, abstract :: least_squares_problem_t
      !> Loss of each residual, `LINEAR`, ... of `nutate_robust_loss`; not allocated: linear. Shape (residuals).
      integer, allocatable :: losses(:)
      !> Bounds; not allocated: none. Shape (parameters).
      real(wp), allocatable :: low(:), high(:)
      !> Usual size of each parameter, 0 if none is known: if a change by it changes the residuals by rounding only,
      !> they do not determine the parameter. Not allocated: none is known. Shape (parameters).
      real(wp), allocatable :: sizes(:)
      !> Number of residuals that the others determine.
      integer :: dependent = 0
   contains
      !> Computes residuals and Jacobian at given parameters.
      procedure(evaluate_residuals), deferred :: evaluate
      !> Receives the parameters of each accepted step; may change to another chart.
      procedure :: accept => keep_chart
   end type least_squares_problem_t

   abstract interface
      !> Computes residuals and Jacobian. A failure makes the step shorter; `NUTATE_STOPPED` and `NUTATE_IO` end the
      !> iteration.
      subroutine evaluate_residuals(self, x, residuals, jacobian, status)
         import :: least_squares_problem_t, status_t, wp
         class(least_squares_problem_t), intent(inout) :: self
         !> Shape (parameters).
         real(wp), intent(in) :: x(:)
         !> Residuals and Jacobian, divided by the standard deviations; shape (residuals) and (residuals, parameters).
         real(wp), allocatable, intent(inout) :: residuals(:), jacobian(:, :)
         type(status_t), intent(out) :: status
      end subroutine evaluate_residuals
   end interface

   !> Settings of the iteration.
   type :: least_squares_settings_t
      integer :: most_iterations = 200
      !> Remaining step below which the iteration ends, in standard errors.
      real(wp) :: tolerance = 1e-8_wp
      !> True if residuals are in units of their standard deviation; else the covariance is multiplied by χ² per degree
      !> of freedom.
      logical :: sigma_is_known = .true.
   end type least_squares_settings_t

   !> Result of a minimisation.
   type :: least_squares_result_t
      !> Parameters at the solution; shape (parameters).
      real(wp), allocatable :: x(:)
      !> Residuals and Jacobian at the solution, without losses; shape (residuals) and (residuals, parameters).
      real(wp), allocatable :: residuals(:), jacobian(:, :)
      !> Sum of the losses; sum of squares if they are linear.
      real(wp) :: chi_squared = huge(1.0_wp)
      !> Residuals less identifiable parameters that are not at a bound.
      integer :: degrees_of_freedom = 0
      integer :: iterations = 0, evaluations = 0
      !> Remaining step, in standard errors.
      real(wp) :: remaining = huge(1.0_wp)
      logical :: converged = .false.
      !> True for a parameter that a bound holds back; shape (parameters).
      logical, allocatable :: at_bound(:)
      !> True for a parameter that a direction changes which is not identifiable; shape (parameters).
      logical, allocatable :: unidentified(:)
      !> Covariance; zero in rows and columns of parameters at a bound and of those that are not identifiable; shape
      !> (parameters, parameters).
      real(wp), allocatable :: covariance(:, :)
      !> Singular values of the scaled Jacobian relative to the largest, and the change of the parameters for each,
      !> without parameters at a bound. Shape (directions) and (parameters, directions).
      real(wp), allocatable :: singular_values(:), directions(:, :)
   contains
      !> Returns the standard errors; 0 if there is none. Shape (parameters).
      procedure :: standard_errors
   end type least_squares_result_t

   !> The linearised problem in its singular vectors.
   type :: factors_t
      !> Indices of the parameters that can move; shape (moving).
      integer, allocatable :: moving(:)
      !> Lengths of the columns of the moving parameters; singular values of the scaled Jacobian; residuals along its
      !> left vectors. Shape (moving).
      real(wp), allocatable :: lengths(:), values(:), along(:)
      !> Right singular vectors as columns; shape (moving, moving).
      real(wp), allocatable :: vectors(:, :)
   contains
      procedure :: step
      procedure :: remaining
      procedure :: known
   end type factors_t

   !> An iterate: parameters with their residuals, and with the residuals weighed by the losses.
   type :: place_t
      real(wp), allocatable :: x(:), residuals(:), jacobian(:, :), weighed(:), weighed_jacobian(:, :)
      real(wp) :: cost = huge(1.0_wp)
   end type place_t

contains

   !> Does nothing.
   subroutine keep_chart(self, x)
      class(least_squares_problem_t), intent(inout) :: self
      !> Parameters; on return in the chart that holds from now on. Shape (parameters).
      real(wp), intent(inout) :: x(:)
   end subroutine keep_chart

   !> Minimises the sum of the losses of the squares of residuals.
   !>
   !> Errors: those of the problem at the initial guess; `NUTATE_BAD_ARGUMENT` for fewer residuals than parameters,
   !> `NUTATE_NOT_FINITE`; `NUTATE_NOT_CONVERGED` if the iterations do not suffice, the fit stalls or no step is short
   !> enough: the result is then the best iterate. Source: Levenberg (1944), Marquardt (1963); Moré (1978) for QR.
   subroutine minimize(problem, x, result, status, settings)
      class(least_squares_problem_t), intent(inout) :: problem
      !> Initial guess; shape (parameters).
      real(wp), intent(in) :: x(:)
      type(least_squares_result_t), intent(out) :: result
      type(status_t), intent(out) :: status
      type(least_squares_settings_t), intent(in), optional :: settings
      type(least_squares_settings_t) :: chosen
      type(status_t) :: factored
      type(place_t) :: here
      type(factors_t) :: factors
      real(wp) :: damping, earlier_cost

      if (present(settings)) chosen = settings
      here%x = within(problem, x)
      call evaluate_iterate(problem, here, result, status)
      if (.not. status%ok()) return
      if (size(here%residuals) < size(x)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'there are fewer residuals than parameters')
         return
      end if
      damping = first_damping
      earlier_cost = here%cost
      do
         call factorize(problem, here, factors, status)
         if (.not. status%ok()) exit
         result%remaining = factors%remaining()/scale_of(problem, chosen, here, factors)
         result%converged = result%remaining <= chosen%tolerance
         if (result%converged .or. result%iterations >= chosen%most_iterations) exit
         if (result%iterations > 0 .and. mod(result%iterations, stall_iterations) == 0) then
            if (earlier_cost - here%cost < stall_share*factors%remaining()**2) then
               status = fail(NUTATE_NOT_CONVERGED, 'the fit stalls: steps hardly reduce the sum (try another start)')
               exit
            end if
            earlier_cost = here%cost
         end if
         call advance(problem, factors, damping, here, result, status)
         if (.not. status%ok()) exit
         result%iterations = result%iterations + 1
      end do
      if (allocated(problem%losses)) then
         call apply_losses(problem, eps, here)
         call factorize(problem, here, factors, factored)
         if (status%ok()) status = factored
      end if
      call conclude(problem, here, factors, chosen, result)
      if (status%code == NUTATE_NOT_CONVERGED .and. &
          (result%remaining <= near .or. is_exact(problem, chosen, factors))) then
         ! Round-off of the residuals lets no step succeed.
         result%converged = .true.
         status = status_t()
      else if (status%ok() .and. .not. result%converged) then
         status = fail(NUTATE_NOT_CONVERGED, 'the fit needs more iterations')
      end if
   end subroutine minimize

   !> Returns the unit of the remaining step: 1, or the scatter of the residuals.
   pure real(wp) function scale_of(problem, settings, here, factors) result(scale)
      class(least_squares_problem_t), intent(in) :: problem
      type(least_squares_settings_t), intent(in) :: settings
      type(place_t), intent(in) :: here
      type(factors_t), intent(in) :: factors
      scale = 1.0_wp
      if (settings%sigma_is_known) return
      scale = sqrt(here%cost/max(1, freedom_of(problem, here, factors)))
      ! Keeps the unit above 0 for data without scatter.
      scale = max(scale, sqrt(tiny(scale)))
   end function scale_of

   !> Returns true for data without noise, whose scatter is round-off: the remaining step changes the residuals by a
   !> negligible share of what the usual sizes of the parameters change them by.
   pure logical function is_exact(problem, settings, factors)
      class(least_squares_problem_t), intent(in) :: problem
      type(least_squares_settings_t), intent(in) :: settings
      type(factors_t), intent(in) :: factors
      is_exact = .false.
      if (settings%sigma_is_known .or. .not. allocated(problem%sizes)) return
      is_exact = factors%remaining() <= rounding*maxval(problem%sizes(factors%moving)*factors%lengths)
   end function is_exact

   !> Returns the number of degrees of freedom.
   pure integer function freedom_of(problem, here, factors) result(freedom)
      class(least_squares_problem_t), intent(in) :: problem
      type(place_t), intent(in) :: here
      type(factors_t), intent(in) :: factors
      freedom = size(here%residuals) - problem%dependent - count(factors%known())
   end function freedom_of

   !> Returns the parameters, moved inside of the bounds.
   pure function within(problem, x) result(inside)
      class(least_squares_problem_t), intent(in) :: problem
      real(wp), intent(in) :: x(:)
      real(wp) :: inside(size(x))
      inside = x
      if (allocated(problem%low)) inside = max(inside, problem%low)
      if (allocated(problem%high)) inside = min(inside, problem%high)
   end function within

   !> Evaluates an iterate. Errors: those of the problem, and `NUTATE_NOT_FINITE`.
   subroutine evaluate_iterate(problem, here, result, status)
      class(least_squares_problem_t), intent(inout) :: problem
      type(place_t), intent(inout) :: here
      type(least_squares_result_t), intent(inout) :: result
      type(status_t), intent(out) :: status
      result%evaluations = result%evaluations + 1
      call problem%evaluate(here%x, here%residuals, here%jacobian, status)
      if (.not. status%ok()) return
      if (.not. (all(ieee_is_finite(here%residuals)) .and. all(ieee_is_finite(here%jacobian)))) then
         status = fail(NUTATE_NOT_FINITE, 'a residual or its derivative is not finite')
         return
      end if
      call apply_losses(problem, least_curvature, here)
   end subroutine evaluate_iterate

   !> Weighs the residuals of an iterate by the losses.
   subroutine apply_losses(problem, least, here)
      class(least_squares_problem_t), intent(in) :: problem
      !> Least curvature of losses relative to their slope.
      real(wp), intent(in) :: least
      type(place_t), intent(inout) :: here
      here%weighed = here%residuals
      here%weighed_jacobian = here%jacobian
      if (allocated(problem%losses)) then
         call weigh(problem%losses, least, here%weighed, here%weighed_jacobian, here%cost)
      else
         here%cost = sum(here%residuals**2)
      end if
   end subroutine apply_losses

   !> Performs one step. Errors: `NUTATE_NOT_CONVERGED` if no step reduces the sum; those that end the iteration.
   subroutine advance(problem, factors, damping, here, result, status)
      class(least_squares_problem_t), intent(inout) :: problem
      type(factors_t), intent(in) :: factors
      real(wp), intent(inout) :: damping
      type(place_t), intent(inout) :: here
      type(least_squares_result_t), intent(inout) :: result
      type(status_t), intent(out) :: status
      type(place_t) :: trial
      do while (damping <= greatest_damping)
         trial%x = here%x
         trial%x(factors%moving) = trial%x(factors%moving) + factors%step(damping)
         trial%x = within(problem, trial%x)
         call evaluate_iterate(problem, trial, result, status)
         if (status%code == NUTATE_STOPPED .or. status%code == NUTATE_IO) return
         if (status%ok() .and. trial%cost < here%cost) then
            here = trial
            call problem%accept(here%x)
            damping = damping/change
            return
         end if
         damping = damping*change
      end do
      status = fail(NUTATE_NOT_CONVERGED, 'no step reduces the residuals')
   end subroutine advance

   !> Factorises the linearised problem without the parameters that a bound holds back. Errors: those of LAPACK.
   subroutine factorize(problem, here, factors, status)
      class(least_squares_problem_t), intent(in) :: problem
      type(place_t), intent(in) :: here
      type(factors_t), intent(out) :: factors
      type(status_t), intent(out) :: status
      real(wp), allocatable :: a(:, :), b(:, :), r(:, :), u(:, :), tau(:), work(:), shares(:)
      integer :: i, m, n, info

      factors%moving = pack([(i, i=1, size(here%x))], .not. held(problem, here))
      n = size(factors%moving)
      m = size(here%weighed)
      a = here%weighed_jacobian(:, factors%moving)
      b = reshape(here%weighed, [m, 1])
      factors%lengths = norm2(a, dim=1)
      ! Usual sizes are used, not values: a fitted value may be zero, up to rounding, and known well.
      shares = 0*factors%lengths
      if (allocated(problem%sizes)) shares = problem%sizes(factors%moving)*factors%lengths
      do i = 1, n
         if (shares(i) > 0.0_wp .and. shares(i) <= rounding*maxval(shares)) a(:, i) = 0.0_wp
         if (maxval(abs(a(:, i))) <= 0.0_wp) factors%lengths(i) = 1.0_wp
         a(:, i) = a(:, i)/factors%lengths(i)
      end do
      allocate (factors%values(n), factors%vectors(n, n), factors%along(n), r(n, n), u(n, n), tau(n), work(64*(m + &
         n + 1)))
      if (n == 0) return
      call dgeqrf(m, n, a, m, tau, work, size(work), info)
      if (info == 0) call dormqr('L', 'T', m, 1, n, a, m, tau, b, m, work, size(work), info)
      r = 0.0_wp
      do i = 1, n
         r(:i, i) = a(:i, i)
      end do
      if (info == 0) call dgesvd('A', 'A', n, n, r, n, factors%values, u, n, factors%vectors, n, work, size(work), info)
      status = handle_info('dgesvd', info)
      factors%vectors = transpose(factors%vectors)
      factors%along = matmul(b(:n, 1), u)
   end subroutine factorize

   !> Returns true for parameters at a bound that the residuals push them against; shape (parameters).
   pure function held(problem, here)
      class(least_squares_problem_t), intent(in) :: problem
      type(place_t), intent(in) :: here
      logical :: held(size(here%x))
      real(wp) :: slope(size(here%x))
      held = .false.
      slope = matmul(here%weighed, here%weighed_jacobian)
      if (allocated(problem%low)) held = held .or. (here%x <= problem%low .and. slope >= 0.0_wp)
      if (allocated(problem%high)) held = held .or. (here%x >= problem%high .and. slope <= 0.0_wp)
   end function held

   !> Returns true for directions that the residuals determine; shape (moving).
   pure function known(self)
      class(factors_t), intent(in) :: self
      logical :: known(size(self%values))
      known = .true.
      if (size(known) > 0) known = self%values > UNKNOWN_BELOW*self%values(1)
   end function known

   !> Returns the step of a damping, without the directions that are not identifiable; shape (moving).
   pure function step(self, damping)
      class(factors_t), intent(in) :: self
      real(wp), intent(in) :: damping
      real(wp) :: step(size(self%values))
      logical :: known(size(self%values))
      known = self%known()
      step = 0.0_wp
      where (known) step = -self%values*self%along/(self%values**2 + damping)
      step = matmul(self%vectors, step)/self%lengths
   end function step

   !> Returns the length of the undamped step in standard errors.
   pure real(wp) function remaining(self)
      class(factors_t), intent(in) :: self
      remaining = norm2(pack(self%along, self%known()))
   end function remaining

   !> Returns the standard errors; 0 if there is none. Shape (parameters).
   pure function standard_errors(self) result(errors)
      class(least_squares_result_t), intent(in) :: self
      real(wp) :: errors(size(self%x))
      integer :: i
      errors = [(sqrt(self%covariance(i, i)), i=1, size(self%x))]
   end function standard_errors

   !> Fills the result from the last iterate.
   subroutine conclude(problem, here, factors, settings, result)
      class(least_squares_problem_t), intent(in) :: problem
      type(place_t), intent(in) :: here
      type(factors_t), intent(in) :: factors
      type(least_squares_settings_t), intent(in) :: settings
      type(least_squares_result_t), intent(inout) :: result
      real(wp) :: columns(size(here%x), size(factors%values)), scale
      logical :: ok(size(here%x))
      integer :: i, n
      n = size(here%x)
      result%x = here%x
      result%residuals = here%residuals
      result%jacobian = here%jacobian
      result%chi_squared = here%cost
      result%degrees_of_freedom = freedom_of(problem, here, factors)
      result%at_bound = spread(.true., 1, n)
      result%at_bound(factors%moving) = .false.
      allocate (result%covariance(n, n), source=0.0_wp)
      columns = 0.0_wp
      do i = 1, size(factors%moving)
         columns(factors%moving(i), :) = factors%vectors(i, :)/factors%lengths(i)
      end do
      result%directions = columns
      result%singular_values = factors%values
      if (size(factors%values) > 0) result%singular_values = factors%values/max(factors%values(1), tiny(1.0_wp))
      scale = 1.0_wp
      if (.not. settings%sigma_is_known) scale = here%cost/max(1, result%degrees_of_freedom)
      do i = 1, size(factors%values)
         if (result%singular_values(i) <= UNKNOWN_BELOW) cycle
         result%covariance = result%covariance + scale/factors%values(i)**2* &
                             spread(columns(:, i), 2, n)*spread(columns(:, i), 1, n)
      end do
      allocate (result%unidentified(n), source=.false.)
      do i = 1, size(factors%values)
         if (result%singular_values(i) > UNKNOWN_BELOW) cycle
         result%unidentified(factors%moving) = result%unidentified(factors%moving) .or. &
                                               abs(factors%vectors(:, i)) > share
      end do
      ok = .not. (result%unidentified .or. result%at_bound)
      where (.not. (spread(ok, 1, n) .and. spread(ok, 2, n))) result%covariance = 0.0_wp
   end subroutine conclude

end module nutate_least_squares
