!> Initial guesses of fits: the numbers of the scene, those that the data give without a fit, and random ones.
!>
!> The order of the moments of inertia matters most: a fit that starts with a wrong order does not recover.
module nutate_fit_starts
   use nutate_attitude, only: quat_from_rotation_vector, rotation_vector_from_quat
   use nutate_control, only: needs_control
   use nutate_fit_model, only: motion_at_t
   use nutate_fit_plan, only: measurement_t, ATTITUDES, VALUES
   use nutate_fit_problem, only: fit_problem_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, long, pi
   use nutate_lapack, only: symmetric_eigen
   use nutate_normal_quantile, only: normal_quantile
   use nutate_philox, only: uniform_of
   use nutate_quaternion, only: quat_conjugate, quat_normalized, quat_product
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: start_t, collect_starts, move_start, first_turn

   !> One initial guess.
   type :: start_t
      !> Parameters; components of the attitude are 0. Shape (parameters).
      real(wp), allocatable :: x(:)
      !> Attitude as the scene gives it.
      real(wp) :: attitude(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      real(wp) :: chi_squared = huge(1.0_wp)
   end type start_t

   !> Rotation of the body in the first arc, rad.
   real(wp), parameter :: first_turn = 1.5_wp
   !> Rotation of the body in a window of rates, rad: long enough that noise does not hide the change of the rates,
   !> short enough for sums in place of integrals.
   real(wp), parameter :: window_turn = 1.0_wp
   !> Range of the logarithm of a ratio of moments.
   real(wp), parameter :: log_range = 2.3_wp
   !> Number of draws of one initial guess; number of tries until ratios obey the triangle inequality.
   integer, parameter :: draws = 1000, most_tries = 200
   character(len=*), parameter :: rates(3) = ['omega1', 'omega2', 'omega3']

contains

   !> Collects all initial guesses of a fit, that of the scene first. If the data begin long after t = 0, the guesses
   !> are states at the first measurement, if possible: `problem%model` runs from there.
   subroutine collect_starts(problem, scene, starts)
      !> Prepared problem.
      type(fit_problem_t), intent(inout) :: problem
      type(scene_t), intent(in) :: scene
      type(start_t), allocatable, intent(out) :: starts(:)
      type(start_t) :: own, estimate, other
      real(wp) :: beside(3)
      type(status_t) :: status
      integer :: i, base
      logical :: found
      own%x = [problem%model%values, spread(0.0_wp, 1, size(problem%names) - problem%n_free)]
      own%attitude = problem%model%plan%attitude
      call find_first_time(problem, scene)
      if (abs(problem%first_time) > 0.0_wp .and. can_move(problem, scene)) &
         call move_start(problem, scene, problem%first_time, own, status)
      allocate (starts(0))
      call append(starts, own)
      base = 1
      if (problem%model%plan%starts_from_data) then
         estimate = own
         call start_at_data(problem, scene, estimate, beside, found)
         if (found) then
            call append(starts, estimate)
            base = 2
            ! Between two attitudes there may have been one revolution more, forwards or backwards.
            do i = -1, 1, 2
               if (.not. norm2(beside) > 0.0_wp) exit
               other = estimate
               call put_rate(problem, scene, rate_of(problem, scene, estimate) + i*beside, other, found)
               if (found) call append(starts, other)
            end do
         end if
      end if
      do i = 1, problem%model%plan%starts
         other = starts(base)
         call draw_start(problem, scene, i, other)
         call append(starts, other)
      end do
   end subroutine collect_starts

   !> Finds the time at which arcs begin: t = 0, unless the body rotates far before the first measurement.
   subroutine find_first_time(problem, scene)
      type(fit_problem_t), intent(inout) :: problem
      type(scene_t), intent(in) :: scene
      real(wp) :: rate
      integer :: i
      rate = norm2(angular_velocity(scene%system, scene%initial))
      do i = 1, size(problem%residuals)
         associate (measurement => problem%residuals(i)%measurement)
            if (all_rates(measurement)) rate = max(rate, norm2(measured_rates(measurement, 1)))
         end associate
      end do
      if (rate*abs(problem%times(1)) > first_turn) problem%first_time = problem%times(1)
   end subroutine find_first_time

   !> Returns true if the state at any time can replace the one at t = 0: rate and attitude are free as a whole, or
   !> nothing requires the attitude, and neither wheels nor switches have states of their own.
   logical function can_move(problem, scene) result(can)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      integer :: i
      associate (effects => scene%system%effects, free => problem%model%plan%free)
         can = effects%n_wheels == 0 .and. .not. needs_control(effects) .and. &
               all([(scene%events%slots(i)%item%action == 0, i=1, scene%events%count())]) .and. &
               all(parameters_of(problem, 'initial.angular_velocity') > 0) .and. has_body_rates(scene) .and. &
               .not. gives(scene, 'attitude_from', 'lvlh')
         if (.not. problem%model%plan%has_attitude) can = can .and. .not. effects%needs_attitude() .and. &
            all([(all_rates(problem%residuals(i)%measurement), i=1, size(problem%residuals))])
         do i = 1, size(free)
            if (index(free(i)%name, 'initial.') /= 1) cycle
            can = can .and. .not. free(i)%sigma > 0.0_wp .and. min(-free(i)%low, free(i)%high) >= huge(1.0_wp) .and. &
                  (free(i)%component > 0 .or. index(free(i)%name, 'initial.angular_velocity') == 1)
         end do
      end associate
   end function can_move

   !> Moves an initial guess, a state at the initial time of runs, to another time, which becomes the initial time of
   !> runs; `can_move` holds. Errors: those of the run there; nothing has changed then.
   subroutine move_start(problem, scene, time, start, status)
      type(fit_problem_t), intent(inout) :: problem
      type(scene_t), intent(in) :: scene
      !> New initial time, s.
      real(wp), intent(in) :: time
      type(start_t), intent(inout) :: start
      type(status_t), intent(out) :: status
      type(motion_at_t) :: motion
      logical :: done
      problem%model%plan%attitude = start%attitude
      call problem%model%set_values(start%x(:problem%n_free), status)
      if (status%ok()) call problem%model%states_at([time], motion, status)
      if (.not. status%ok()) return
      if (problem%model%plan%has_attitude) start%attitude = quat_normalized(motion%states(1)%q)
      where (problem%model%plan%free%component > 0) start%x(:problem%n_free) = 0.0_wp
      call put_rate(problem, scene, angular_velocity(problem%model%scene%system, motion%states(1)), start, done)
      call problem%model%set_origin(time)
   end subroutine move_start

   !> Adds an initial guess. An array constructor of such types would lose memory with gfortran 12.
   subroutine append(starts, start)
      type(start_t), allocatable, intent(inout) :: starts(:)
      type(start_t), intent(in) :: start
      type(start_t), allocatable :: longer(:)
      integer :: n
      n = size(starts)
      allocate (longer(n + 1))
      longer(:n) = starts
      longer(n + 1) = start
      call move_alloc(longer, starts)
   end subroutine append

   !> Estimates rate and attitude at the initial time, and ratios of moments, from the data without a fit.
   subroutine start_at_data(problem, scene, start, beside, found)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      type(start_t), intent(inout) :: start
      !> Change of the rate by one revolution more between the first two attitudes, rad/s; else 0.
      real(wp), intent(out) :: beside(3)
      !> True if the data give an estimate.
      logical, intent(out) :: found
      logical :: gives
      integer :: i
      beside = 0.0_wp
      found = .false.
      do i = 1, size(problem%residuals)
         associate (measurement => problem%residuals(i)%measurement)
            if (measurement%kind == ATTITUDES .and. size(measurement%times) > 1) then
               call start_at_attitudes(problem, scene, measurement, start, beside, gives)
               found = found .or. gives
            else if (all_rates(measurement)) then
               call put_rate(problem, scene, measured_rates(measurement, 1), start, gives)
               found = found .or. gives
               if (gives) beside = 0.0_wp
               call start_at_rates(problem, scene, measurement, start, gives)
               found = found .or. gives
            end if
         end associate
      end do
   end subroutine start_at_data

   !> Sets the first attitude, and the mean rate to the next one at another time.
   subroutine start_at_attitudes(problem, scene, measurement, start, beside, found)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      type(measurement_t), intent(in) :: measurement
      type(start_t), intent(inout) :: start
      real(wp), intent(inout) :: beside(3)
      logical, intent(out) :: found
      real(wp) :: turn(3), interval, q(4)
      integer :: next
      found = .false.
      next = findloc(abs(measurement%times - measurement%times(1)) > 0.0_wp, .true., dim=1)
      if (next == 0) return
      interval = measurement%times(next) - measurement%times(1)
      turn = rotation_vector_from_quat(quat_product(quat_conjugate(measurement%rows(:, 1)), measurement%rows(:, next)))
      found = problem%model%plan%has_attitude
      if (found) then
         q = quat_product(measurement%rows(:, 1), quat_from_rotation_vector( &
                          -(measurement%times(1) - problem%model%origin)/interval*turn))
         if (scene%system%effects%on_orbit .and. gives(scene, 'attitude_from', 'lvlh')) &
            q = quat_product(quat_conjugate(scene%system%effects%orbit%axes(0.0_wp)), q)
         start%attitude = q
      end if
      call put_rate(problem, scene, turn/interval, start, found)
      if (found .and. norm2(turn) > 0.0_wp) beside = 2*pi*turn/(norm2(turn)*interval)
   end subroutine start_at_attitudes

   !> Returns true if a key of `&initial` has a value.
   pure logical function gives(scene, key, value)
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: key, value
      integer :: i
      i = findloc(scene%groups%name == 'initial', .true., dim=1)
      gives = scene%groups(i)%text(key, '') == value
   end function gives

   !> Returns the indices of the parameters that are the three numbers of a key; 0 for one that is not free. Shape (3).
   pure function parameters_of(problem, key) result(which)
      type(fit_problem_t), intent(in) :: problem
      character(len=*), intent(in) :: key
      integer :: which(3), k
      which = [(findloc(problem%names, key//'.'//achar(iachar('0') + k), dim=1), k=1, 3)]
   end function parameters_of

   !> Sets the rate of an initial guess, unless the rate is not free, or not given as inertial rate in body axes.
   subroutine put_rate(problem, scene, rate, start, done)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      !> Inertial rate, body axes, rad/s.
      real(wp), intent(in) :: rate(3)
      type(start_t), intent(inout) :: start
      logical, intent(out) :: done
      integer :: which(3)
      which = parameters_of(problem, 'initial.angular_velocity')
      done = all(which > 0) .and. has_body_rates(scene)
      if (done) start%x(which) = rate/problem%model%plan%angle_unit
   end subroutine put_rate

   !> Returns true if the scene gives the inertial rate in body axes.
   pure logical function has_body_rates(scene)
      type(scene_t), intent(in) :: scene
      has_body_rates = .not. (gives(scene, 'frame', 'space') .or. gives(scene, 'rate_from', 'frame') .or. &
                              gives(scene, 'rate_from', 'lvlh'))
   end function has_body_rates

   !> Returns the rate of an initial guess, rad/s; 0 if the rate is not free.
   pure function rate_of(problem, scene, start) result(rate)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      type(start_t), intent(in) :: start
      real(wp) :: rate(3)
      integer :: which(3)
      rate = 0.0_wp
      which = parameters_of(problem, 'initial.angular_velocity')
      if (all(which > 0)) rate = start%x(which)*problem%model%plan%angle_unit
   end function rate_of

   !> Returns true if the three body components of the rate were measured.
   pure logical function all_rates(measurement)
      type(measurement_t), intent(in) :: measurement
      integer :: k
      all_rates = measurement%kind == VALUES .and. all([(place_of(measurement, k) > 0, k=1, 3)])
   end function all_rates

   !> Returns the column of a component of the rate; 0: not measured.
   pure integer function place_of(measurement, k)
      type(measurement_t), intent(in) :: measurement
      integer, intent(in) :: k
      place_of = findloc(measurement%columns, rates(k), dim=1)
      if (place_of == 0) place_of = findloc(measurement%columns, rates(k)//'_deg', dim=1)
   end function place_of

   !> Returns the rates of a row, rad/s; shape (3).
   pure function measured_rates(measurement, i) result(rate)
      type(measurement_t), intent(in) :: measurement
      integer, intent(in) :: i
      real(wp) :: rate(3)
      integer :: k
      rate = [(measurement%rows(place_of(measurement, k), i), k=1, 3)]
      if (measurement%degrees) rate = rate*pi/180
   end function measured_rates

   !> Estimates the moments of a free body from J ΔΩ + ∫Ω×JΩ dt = 0 over windows, which is linear in J.
   subroutine start_at_rates(problem, scene, measurement, start, found)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      type(measurement_t), intent(in) :: measurement
      type(start_t), intent(inout) :: start
      logical, intent(out) :: found
      real(wp) :: matrix(3, 3), values(3), vectors(3, 3), moments(3)
      type(status_t) :: status
      associate (effects => scene%system%effects)
         found = any(parameters_of(problem, 'body.inertia') > 0) .and. &
                 effects%n_potentials + effects%n_torques + effects%n_rotors + effects%n_off == 0
      end associate
      if (.not. found) return
      matrix = 0.0_wp
      call add_windows(measurement, matrix)
      call symmetric_eigen(matrix, values, vectors, status)
      moments = vectors(:, 1)*sign(1.0_wp, sum(vectors(:, 1)))
      found = status%ok() .and. obeys_triangle(moments)
      if (found) call put_ratios(problem, scene, moments, start)
   end subroutine start_at_rates

   !> Adds AᵀA of the equations A J = 0 of all windows.
   subroutine add_windows(measurement, matrix)
      type(measurement_t), intent(in) :: measurement
      real(wp), intent(inout) :: matrix(3, 3)
      real(wp) :: first(3), before(3), now(3), products(3), change(3), rows(3, 3), turn, step
      integer :: i
      first = measured_rates(measurement, 1)
      before = first
      products = 0.0_wp
      turn = 0.0_wp
      do i = 2, size(measurement%times)
         now = measured_rates(measurement, i)
         step = measurement%times(i) - measurement%times(i - 1)
         products = products + 0.5_wp*step*(before([2, 3, 1])*before([3, 1, 2]) + now([2, 3, 1])*now([3, 1, 2]))
         turn = turn + 0.5_wp*abs(step)*(norm2(before) + norm2(now))
         before = now
         if (turn < window_turn) cycle
         change = now - first
         rows(1, :) = [change(1), -products(1), products(1)]
         rows(2, :) = [products(2), change(2), -products(2)]
         rows(3, :) = [-products(3), products(3), change(3)]
         matrix = matrix + matmul(transpose(rows), rows)
         first = now
         products = 0.0_wp
         turn = 0.0_wp
      end do
   end subroutine add_windows

   pure logical function obeys_triangle(moments)
      real(wp), intent(in) :: moments(3)
      obeys_triangle = all(moments > 0.0_wp) .and. 2*maxval(moments) < sum(moments)
   end function obeys_triangle

   !> Sets the moments to given ratios. Moments that are not free keep their values; if all are free, their sum is kept.
   subroutine put_ratios(problem, scene, ratios, start)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      real(wp), intent(in) :: ratios(3)
      type(start_t), intent(inout) :: start
      real(wp) :: own(3), scaled(3)
      integer :: which(3), i, held
      which = parameters_of(problem, 'body.inertia')
      i = findloc(scene%groups%name == 'body', .true., dim=1)
      own = scene%groups(i)%vector('inertia', [1.0_wp, 1.0_wp, 1.0_wp])
      held = findloc(which, 0, dim=1)
      scaled = ratios*sum(own)/sum(ratios)
      if (held > 0) scaled = ratios*own(held)/ratios(held)
      do i = 1, 3
         if (which(i) > 0) start%x(which(i)) = scaled(i)
      end do
   end subroutine put_ratios

   !> Draws a random initial guess: ratios of moments log-uniform if they obey the triangle inequality, parameters with
   !> bounds uniform between these, parameters with a standard deviation normal.
   subroutine draw_start(problem, scene, number, start)
      type(fit_problem_t), intent(in) :: problem
      type(scene_t), intent(in) :: scene
      !> Number of the initial guess.
      integer, intent(in) :: number
      type(start_t), intent(inout) :: start
      real(wp) :: ratios(3), u
      integer :: i, k
      if (any(parameters_of(problem, 'body.inertia') > 0)) then
         do k = 1, most_tries
            ratios = [(exp(log_range*(2*draw(problem, number, 2*k + i) - 1)), i=0, 1), 1.0_wp]
            if (obeys_triangle(ratios)) exit
         end do
         if (obeys_triangle(ratios)) call put_ratios(problem, scene, ratios, start)
      end if
      do i = 1, problem%n_free
         associate (free => problem%model%plan%free(i))
            if (free%component > 0 .or. any(parameters_of(problem, 'body.inertia') == i)) cycle
            u = draw(problem, number, draws + i)
            if (free%sigma > 0.0_wp) then
               start%x(i) = problem%known_values(i) + free%sigma*normal_quantile(u)
            else if (max(abs(free%low), abs(free%high)) < huge(u)) then
               start%x(i) = free%low + u*(free%high - free%low)
            end if
         end associate
      end do
   end subroutine draw_start

   pure real(wp) function draw(problem, number, which)
      type(fit_problem_t), intent(in) :: problem
      integer, intent(in) :: number, which
      draw = uniform_of(problem%model%plan%seed, int(number, long), which)
   end function draw

end module nutate_fit_starts
