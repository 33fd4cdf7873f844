!> Bodies of the procedures whose interfaces are in `nutate_fit`.
submodule(nutate_fit) nutate_fit_procedures
   use nutate_fit_starts, only: collect_starts, first_turn, move_start, start_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_least_squares, only: least_squares_settings_t, minimize
   use nutate_normal_quantile, only: normal_quantile
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_IO, NUTATE_STOPPED
   implicit none

contains

   module procedure fit_scene
      type(start_t), allocatable :: starts(:)
      type(status_t) :: outcome
      type(least_squares_result_t) :: result
      real(wp) :: attitude(4)
      integer, allocatable :: kept(:)
      integer :: i
      if (.not. scene%fit%active()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'there is nothing to fit (expected &free and &measurement)')
         return
      end if
      call fit%problem%prepare(scene, status)
      if (.not. status%ok()) return
      if (present(observer)) fit%problem%model%polled => observer
      fit%sigma_is_known = all(scene%fit%measurements%sigma_is_known)
      if (fit%problem%measured_in_arc() < size(fit%problem%names)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'there are fewer measurements than free parameters')
         return
      end if
      call collect_starts(fit%problem, scene, starts)
      fit%starts = size(starts)
      call choose_starts(fit, starts, kept, status)
      if (.not. status%ok()) return
      do i = 1, size(kept)
         call grow(fit, scene, starts(kept(i)), result, outcome)
         if (is_ended(outcome) .or. i == 1) status = outcome
         if (is_better(result, fit)) then
            fit%best = kept(i)
            fit%result = result
            attitude = starts(kept(i))%attitude
            status = outcome
            if (fit%sigma_is_known .and. is_noise(result)) exit
         end if
         if (is_ended(outcome)) exit
      end do
      if (fit%best == 0) return
      ! Sets the model to the solution.
      fit%problem%weak_sigma = 0.0_wp
      call fit%problem%set_arc(huge(1.0_wp))
      call fit%problem%model%set_origin(0.0_wp)
      fit%problem%model%plan%attitude = attitude
      call fit%problem%model%set_values(fit%result%x(:fit%problem%n_free), outcome)
   end procedure fit_scene

   !> Returns true for a failure that ends the whole fit.
   pure logical function is_ended(status)
      type(status_t), intent(in) :: status
      is_ended = status%code == NUTATE_STOPPED .or. status%code == NUTATE_IO
   end function is_ended

   !> Returns true if an initial guess led to a fit of the whole data, and to a better one than any before.
   pure logical function is_better(result, fit)
      type(least_squares_result_t), intent(in) :: result
      type(fit_t), intent(in) :: fit
      is_better = allocated(result%x)
      if (is_better .and. fit%best > 0) is_better = result%chi_squared < fit%result%chi_squared
   end function is_better

   !> Returns true if noise alone explains the residuals.
   pure logical function is_noise(result)
      type(least_squares_result_t), intent(in) :: result
      is_noise = result%converged .and. result%chi_squared <= noise_limit(result%degrees_of_freedom)
   end function is_noise

   module procedure exceeds_noise
      exceeds = .false.
      if (self%best == 0 .or. .not. self%sigma_is_known .or. self%result%degrees_of_freedom < 1) return
      exceeds = self%result%chi_squared > noise_limit(self%result%degrees_of_freedom)
   end procedure exceeds_noise

   !> Returns the χ² that normal noise exceeds in one of 10000 cases (E. B. Wilson, M. M. Hilferty, PNAS 17 (1931) 684).
   pure real(wp) function noise_limit(degrees_of_freedom) result(limit)
      integer, intent(in) :: degrees_of_freedom
      real(wp) :: freedom, spread
      freedom = real(max(1, degrees_of_freedom), wp)
      spread = 2/(9*freedom)
      limit = freedom*(1 - spread + normal_quantile(noise_share)*sqrt(spread))**3
   end function noise_limit

   !> Chooses the initial guesses to continue: if there are many, the best on the first arc.
   subroutine choose_starts(fit, starts, kept, status)
      type(fit_t), intent(inout) :: fit
      type(start_t), intent(inout) :: starts(:)
      integer, allocatable, intent(out) :: kept(:)
      type(status_t), intent(out) :: status
      type(least_squares_result_t) :: result
      logical :: waits(size(starts))
      integer :: i
      kept = [(i, i=1, size(starts))]
      if (size(starts) <= most_kept) return
      do i = 1, size(starts)
         call fit_arc(fit, starts(i), first_arc(fit, starts(i)), .false., .true., result, status)
         if (is_ended(status)) return
      end do
      status = status_t()
      waits = .true.
      kept = [integer ::]
      do while (size(kept) < most_kept)
         i = minloc(starts%chi_squared, dim=1, mask=waits)
         waits(i) = .false.
         kept = [kept, i]
      end do
   end subroutine choose_starts

   !> Fits growing arcs, up to the whole of the data; the whole from t = 0. Errors: those of `minimize`; there is no
   !> result if the fit ends on a shorter arc.
   subroutine grow(fit, scene, start, result, status)
      type(fit_t), intent(inout) :: fit
      type(scene_t), intent(in) :: scene
      type(start_t), intent(inout) :: start
      type(least_squares_result_t), intent(out) :: result
      type(status_t), intent(out) :: status
      type(least_squares_result_t) :: of_arc
      real(wp) :: length, whole, origin
      origin = fit%problem%model%origin
      call fit%problem%set_arc(huge(1.0_wp))
      whole = abs(fit%problem%times(size(fit%problem%times)) - fit%problem%first_time)
      length = first_arc(fit, start)
      do while (length < whole)
         call fit_arc(fit, start, length, .false., length < free_biases*whole, of_arc, status)
         if (is_ended(status)) return
         length = 2*length
      end do
      if (abs(origin) > 0.0_wp) then
         call fit_arc(fit, start, huge(1.0_wp), .false., .false., of_arc, status)
         if (is_ended(status)) return
         call move_start(fit%problem, scene, 0.0_wp, start, status)
         if (.not. status%ok()) return
      end if
      call fit_arc(fit, start, huge(1.0_wp), .true., .false., result, status)
      call fit%problem%model%set_origin(origin)
   end subroutine grow

   !> Returns the length of the first arc, from the time at which arcs begin, s.
   real(wp) function first_arc(fit, start) result(length)
      type(fit_t), intent(inout) :: fit
      type(start_t), intent(in) :: start
      type(status_t) :: status
      real(wp) :: rate
      integer :: i
      length = huge(length)
      if (.not. fit%problem%model%plan%grows) return
      associate (problem => fit%problem)
         call problem%set_arc(huge(1.0_wp))
         problem%model%plan%attitude = start%attitude
         call problem%model%set_values(start%x(:problem%n_free), status)
         if (.not. status%ok()) return
         rate = norm2(angular_velocity(problem%model%scene%system, problem%model%scene%initial))
         associate (times => abs(problem%times - problem%first_time))
            if (rate*times(size(times)) > first_turn) length = first_turn/rate
            do i = 1, size(times)
               if (times(i) < length) cycle
               call problem%set_arc(abs(problem%first_time) + times(i))
               if (problem%measured_in_arc() >= residuals_per_parameter*size(problem%names)) exit
            end do
            length = times(min(i, size(times)))
         end associate
      end associate
   end function first_arc

   !> Fits one arc from an initial guess, which becomes the solution. Errors: those of `minimize`.
   subroutine fit_arc(fit, start, length, is_last, holds_biases, result, status)
      type(fit_t), intent(inout) :: fit
      type(start_t), intent(inout) :: start
      !> Length of the arc, from the time at which arcs begin, s.
      real(wp), intent(in) :: length
      !> True for the whole of the data, fitted to the minimum.
      logical, intent(in) :: is_last
      !> True to hold biases at 0.
      logical, intent(in) :: holds_biases
      type(least_squares_result_t), intent(out) :: result
      type(status_t), intent(out) :: status
      type(least_squares_settings_t) :: settings
      integer :: i
      settings%sigma_is_known = fit%sigma_is_known
      associate (problem => fit%problem)
         problem%weak_sigma = 0.0_wp
         problem%low(problem%n_free + 1:) = merge(0.0_wp, -huge(1.0_wp), holds_biases)
         problem%high(problem%n_free + 1:) = merge(0.0_wp, huge(1.0_wp), holds_biases)
         if (.not. is_last) then
            settings%most_iterations = iterations_of_arc
            settings%tolerance = tolerance_of_arc
            problem%weak_values = start%x
            do i = 1, problem%n_free
               if (index(problem%names(i), 'body.inertia.') == 1) problem%weak_sigma(i) = weak_share*abs(start%x(i))
            end do
         end if
         call problem%set_arc(abs(problem%first_time) + length)
         problem%model%plan%attitude = start%attitude
         call minimize(problem, start%x, result, status, settings)
         if (.not. allocated(result%x)) return
         start%x = result%x
         start%attitude = problem%model%plan%attitude
         start%chi_squared = result%chi_squared
      end associate
   end subroutine fit_arc

end submodule nutate_fit_procedures
