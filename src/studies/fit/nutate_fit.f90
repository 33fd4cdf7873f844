!> Fits a scene to measurements: from several initial guesses, along growing arcs of the data, to the least sum of
!> squares.
module nutate_fit
   use nutate_fit_problem, only: fit_problem_t
   use nutate_kinds, only: wp
   use nutate_least_squares, only: least_squares_result_t
   use nutate_observer, only: observer_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: fit_t, fit_scene

   !> A fitted scene.
   type :: fit_t
      !> Problem at the solution.
      type(fit_problem_t) :: problem
      type(least_squares_result_t) :: result
      !> Number of initial guesses tried, and index of the one that led to the solution.
      integer :: starts = 0, best = 0
      logical :: sigma_is_known = .true.
   contains
      !> Returns true if sigma is known and noise of this size hardly ever leaves such residuals.
      procedure :: exceeds_noise
   end type fit_t

   !> Residuals in the first arc for each parameter.
   integer, parameter :: residuals_per_parameter = 2
   !> Standard deviation of the weak prior of moments on short arcs, relative to their values in the initial guess.
   real(wp), parameter :: weak_share = 0.5_wp
   !> Share of the data from which on biases are free: on shorter arcs they replace any motion.
   real(wp), parameter :: free_biases = 0.1_wp
   !> Probability that the χ² of data with normal noise is below the quantile beyond which a fit is reported.
   real(wp), parameter :: noise_share = 0.9999_wp
   !> Largest number of initial guesses that are continued after the first arc.
   integer, parameter :: most_kept = 4
   !> Iterations on an arc that is not the last, and tolerance there, in standard errors.
   integer, parameter :: iterations_of_arc = 30
   real(wp), parameter :: tolerance_of_arc = 1e-3_wp

   interface

      !> Fits the free parameters of a scene to its measurements.
      !>
      !> Errors: `NUTATE_BAD_ARGUMENT` for a scene that has nothing to fit or whose motion has no derivative, and for
      !> fewer measurements than parameters; `NUTATE_NOT_CONVERGED`, and `NUTATE_STOPPED` if the runs together exceed
      !> `max_steps` of the scene's plan: the fit is then the best found; errors of the runs and of `observer`.
      module subroutine fit_scene(scene, fit, status, observer)
         type(scene_t), intent(in) :: scene
         type(fit_t), intent(out) :: fit
         type(status_t), intent(out) :: status
         !> Polled before and in each run; a failure with `NUTATE_STOPPED` ends the fit. Must exist as long as `fit`.
         class(observer_t), intent(inout), target, optional :: observer
      end subroutine fit_scene

      pure logical module function exceeds_noise(self) result(exceeds)
         class(fit_t), intent(in) :: self
      end function exceeds_noise

   end interface

end module nutate_fit
