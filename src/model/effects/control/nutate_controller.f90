!> A controller: a control law (`nutate_control_law`) that acts continuously, or by samples, from start to stop.
!>
!> With a sampling period, the torque on the body, the torques of the motors or the moment, in body axes, are held from
!> one sample to the next: runs set them at each sample (`hold`).
module nutate_controller
   use nutate_archive, only: archive_t
   use nutate_control_law, only: control_law_t, BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING, POINTING
   use nutate_effect, only: GENERAL_SERIES, NO_SERIES, parameter_t
   use nutate_effect_traits, only: DRIVES_WHEELS, FOLLOWS_EARTH_FIELD, IS_CONTROLLER, IS_POINTING, JUMPS_WITH_SIGN, &
      LENDS_PARAMETERS, LIMITS_MOMENT
   use nutate_finite, only: is_nan
   use nutate_kepler_orbit, only: kepler_orbit_t, n_elements
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, is_unit, least_step, most_wheels
   use nutate_quaternion, only: cross
   use nutate_saturation_count, only: side_of_limit, note_saturation
   use nutate_torque, only: transfer_torque
   implicit none
   private

   public :: controller_t

   !> A controller that acts from start to stop.
   type, extends(control_law_t) :: controller_t
      !> Start and stop of the controller, s. Samples are taken an integer number of periods after the start, or after
      !> t = 0 without one.
      real(wp) :: start = -huge(1.0_wp), stop = huge(1.0_wp)
      !> Held values: torque, N m, or moment, A m², body axes, shape (3); torque of each motor, N m, shape
      !> (most_wheels).
      real(wp) :: held(3) = 0.0_wp, held_by_wheels(most_wheels) = 0.0_wp
      !> Command of the law at the last sample, before limits: torque, N m, or moment, A m², body axes; shape (3).
      real(wp) :: commanded(3) = 0.0_wp
      !> Number of samples of the field since B-dot was switched on, at most 2; their times, s, and B, body axes, T, the
      !> last one first.
      integer :: n_fields = 0
      real(wp) :: field_times(2) = 0.0_wp, fields(3, 2) = 0.0_wp
      !> The torque of motor i is share(:, i)·τ; set by `add_controller`; shape (3, most_wheels).
      real(wp) :: share(3, most_wheels) = 0.0_wp
   contains
      procedure :: torque => controlling_torque
      procedure :: derivatives => controlling_derivatives
      procedure :: window => controlling_window
      procedure :: next_break => controlling_break
      procedure :: series_kind => controller_series
      procedure :: series_direction => controller_direction
      procedure :: direction_series => series_of_field
      procedure :: series_torque => controller_series_torque
      procedure :: is_valid => controller_is_valid
      procedure :: parameters => controller_parameters
      procedure :: follows => controller_follows
      procedure :: shift
      procedure :: n_limited => limited_components
      procedure :: has => has_trait
      procedure :: own_field => field_of_magnetorquers
      procedure :: own_window => start_and_stop
      procedure :: wheel_command => held_command
      procedure :: commands_at
      procedure :: thin_table => thin_paths
      procedure :: transfer => transfer_controller
      !> Returns the time of the next sample.
      procedure :: next_sample
      procedure :: hold
   end type controller_t

contains

   !> Returns the torque of the control law, limited if runs found it at the limit, or the held torque, body axes, N m;
   !> zero for wheels, whose motors act inside the body.
   pure function controlling_torque(self, t, q, omega) result(tau)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      if (self%by == BY_WHEELS) then
         tau = 0.0_wp
      else if (.not. self%sample > 0.0_wp) then
         if (any(self%saturated /= 0)) then
            tau = self%cut_off(self%command(t, q, omega))
            if (self%by == BY_MAGNETORQUERS) tau = cross(tau, self%field_at(t, q))
         else
            tau = self%law_torque(t, q, omega)
         end if
      else if (self%by == BY_MAGNETORQUERS) then
         tau = cross(self%held, self%field_at(t, q))
      else
         tau = self%held
      end if
   end function controlling_torque

   !> Computes ∂τ/∂θ and ∂τ/∂Ω: a small rotation θ of the body changes e_v by ½(e₀θ + e_v×θ), and B by B×θ.
   pure subroutine controlling_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      real(wp) :: b(3), theta(3)
      integer :: i
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
      if (self%by == BY_WHEELS) return
      b = 0.0_wp
      if (self%by == BY_MAGNETORQUERS) b = self%field_at(t, q)
      do i = 1, 3
         theta = 0.0_wp
         theta(i) = 1.0_wp
         if (.not. self%sample > 0.0_wp) then
            call self%differentiate(t, q, omega, b, theta, by_rotation(:, i), by_rate(:, i))
         else if (self%by == BY_MAGNETORQUERS) then
            by_rotation(:, i) = cross(self%held, cross(b, theta))
         end if
      end do
   end subroutine controlling_derivatives

   !> Returns `start` and `stop`, s; an empty window for a controller of wheels, since there the motors act.
   pure subroutine controlling_window(self, start, stop)
      class(controller_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
      if (self%by /= BY_WHEELS) return
      start = huge(1.0_wp)
      stop = -huge(1.0_wp)
   end subroutine controlling_window

   !> Returns the next time at which the torque may jump: the next sample or an end of the window, s.
   pure real(wp) function controlling_break(self, t, sense) result(next)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: t, sense
      real(wp) :: ends(2)
      integer :: i
      next = self%next_sample(t, sense)
      ends = [self%start, self%stop]
      do i = 1, 2
         if (sense*ends(i) > sense*t .and. sense*ends(i) < sense*next) next = ends(i)
      end do
   end function controlling_break

   !> Returns the first sample after a time, s; huge if there is none, or none that differs from others in floating
   !> point.
   pure real(wp) function next_sample(self, t, sense) result(next)
      class(controller_t), intent(in) :: self
      !> Time, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: first, n
      next = sense*huge(next)
      if (.not. self%sample > 0.0_wp) return
      first = 0.0_wp
      if (self%start > -huge(first)) first = self%start
      n = (t - first)/self%sample
      if (.not. abs(n) < 1e15_wp) return
      ! Rounding may have moved the time of a sample in either direction.
      n = aint(n) - 2*sense
      do while (sense*(first + n*self%sample - t) <= 0.0_wp)
         n = n + sense
      end do
      if (self%sample > 4*spacing(max(abs(t), abs(first)))) next = first + n*self%sample
   end function next_sample

   !> Samples the control law and holds its command, limited component by component, until the next call; outside of the
   !> window it holds zero.
   pure subroutine hold(self, t, q, omega, moment)
      class(controller_t), intent(inout) :: self
      !> Time of the sample, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω relative to the space axes, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), omega(3)
      !> A time inside the interval that follows, s: it decides whether the window is open.
      real(wp), intent(in) :: moment
      if (.not. self%was_on) self%n_fields = 0
      self%was_on = self%on
      self%held = 0.0_wp
      self%held_by_wheels = 0.0_wp
      self%commanded = 0.0_wp
      if (.not. (self%on .and. moment >= self%start .and. moment <= self%stop)) then
         self%n_fields = 0
      else if (self%law == DETUMBLING) then
         call sample_field(self, t, self%field_at(t, q), moment - t)
         if (self%n_fields == 2) self%commanded = -self%gain*((self%fields(:, 1) - self%fields(:, 2))/ &
                                                              (self%field_times(1) - self%field_times(2)))
      else
         self%commanded = self%command(t, q, omega)
      end if
      if (self%by == BY_WHEELS) then
         self%held_by_wheels = matmul(self%commanded, self%share)
      else
         self%held = max(-self%limit, min(self%limit, self%commanded))
         call note_saturation(self%saturations, t, side_of_limit(self%commanded, self%limit), .true., t, t)
      end if
   end subroutine hold

   !> Stores a sample of the field. A second sample at the same time replaces the last one; a sample before the last
   !> one, or more than a period after it, is treated as the first.
   pure subroutine sample_field(self, t, field, ahead)
      class(controller_t), intent(inout) :: self
      !> Time of the sample, s; B, body axes, T, shape (3).
      real(wp), intent(in) :: t, field(3)
      !> Signed interval to a time inside what follows, s: times closer than half of it are treated as equal.
      real(wp), intent(in) :: ahead
      real(wp) :: elapsed, margin
      margin = 0.5_wp*abs(ahead)
      elapsed = sign(1.0_wp, ahead)*(t - self%field_times(1))
      if (elapsed < -margin .or. elapsed > self%sample + 2*margin) self%n_fields = 0
      if (self%n_fields == 0) then
         self%n_fields = 1
      else if (elapsed > margin) then
         self%n_fields = 2
         self%field_times(2) = self%field_times(1)
         self%fields(:, 2) = self%fields(:, 1)
      end if
      self%field_times(1) = t
      self%fields(:, 1) = field
   end subroutine sample_field

   !> Returns `GENERAL_SERIES` for a held command, `NO_SERIES` for a law that acts continuously, a feedback.
   pure integer function controller_series(self) result(kind)
      class(controller_t), intent(in) :: self
      kind = merge(GENERAL_SERIES, NO_SERIES, self%sample > 0.0_wp)
   end function controller_series

   !> Returns the field b of magnetorquers, space axes, T, at t = 0 if it moves; zero for other actuators.
   pure function controller_direction(self) result(direction)
      class(controller_t), intent(in) :: self
      real(wp) :: direction(3)
      direction = 0.0_wp
      if (self%by /= BY_MAGNETORQUERS) return
      direction = self%field
      if (self%follows_earth) direction = self%earth%at(0.0_wp)
   end function controller_direction

   !> Computes the coefficients of the power series of the field of the Earth, space axes, T.
   pure subroutine series_of_field(self, t, time_unit, n)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      call self%earth%series(t, time_unit, n)
   end subroutine series_of_field

   !> Computes coefficient k of the torque that is held: a constant torque, or m×B; body axes, N m.
   pure subroutine controller_series_torque(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(controller_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, omega(3, 0:k), gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      tau = 0.0_wp
      if (self%by == BY_MAGNETORQUERS) tau = cross(self%held, gamma(:, k))
      if (self%by == BY_TORQUE .and. k == 0) tau = self%held
   end subroutine controller_series_torque

   !> Returns true if gains, field, limit and period are of a size that can be computed with; `start` and `stop` need
   !> only be comparable.
   pure logical function controller_is_valid(self) result(valid)
      class(controller_t), intent(in) :: self
      real(wp) :: strongest
      integer :: i
      valid = is_unit(self%target, attitude_tolerance) .and. all(is_moderate(self%field)) .and. &
                 is_moderate(self%gain) .and. is_moderate(self%sample) .and. self%limit > 0.0_wp .and. &
                 .not. (is_nan(self%start) .or. is_nan(self%stop))
      if (valid) valid = .not. self%sample < 0.0_wp
      if (valid .and. self%sample > 0.0_wp) valid = self%sample >= least_step
      do i = 1, 3
         valid = valid .and. all(is_moderate(self%attitude_gain(:, i))) .and. &
                    all(is_moderate(self%rate_gain(:, i)))
      end do
      if (valid .and. self%follows_earth) valid = self%earth%is_valid()
      if (valid .and. self%follows_orbit) valid = self%orbit%is_valid()
      if (.not. valid .or. self%law /= DETUMBLING) return
      strongest = maxval(abs(self%field))
      if (self%follows_earth) strongest = self%earth%greatest()
      valid = strongest <= 1e50_wp
      if (valid) valid = is_moderate(self%gain*strongest**2)
      if (valid .and. self%follows_earth) valid = is_moderate(self%gain*(strongest*self%earth%pace()))
   end function controller_is_valid

   !> Returns K and D, column by column, k, b, the limit, the orbit of field and target, G and θ₀ of the field of the
   !> Earth; only parameters of the law have names.
   pure function controller_parameters(self) result(list)
      class(controller_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('attitude_gain_matrix', 9), parameter_t('rate_gain_matrix', 9), parameter_t('gain'), &
              parameter_t('field', 3), parameter_t('limit'), parameter_t('orbit', n_elements), &
              parameter_t('coefficients', 3), parameter_t('epoch_angle')]
      if (self%law == DETUMBLING) list(1:2)%name = ''
      if (self%law == POINTING) list(3)%name = ''
      if (self%by /= BY_MAGNETORQUERS .or. self%follows_earth) list(4)%name = ''
      if (self%by == BY_WHEELS .or. self%limit >= huge(self%limit)) list(5)%name = ''
      if (.not. self%follows_earth) list(7:8)%name = ''
   end function controller_parameters

   pure logical function controller_follows(self, path) result(follows)
      class(controller_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      follows = self%follows_earth .and. self%earth%path%equals(path)
      if (self%follows_orbit) follows = follows .or. self%orbit%path%equals(path)
   end function controller_follows

   !> Adds a change of `parameters`; returns true.
   logical function shift(self, change)
      class(controller_t), intent(inout) :: self
      real(wp), intent(in) :: change(:)
      shift = .true.
      self%attitude_gain = self%attitude_gain + reshape(change(1:9), [3, 3])
      self%rate_gain = self%rate_gain + reshape(change(10:18), [3, 3])
      self%gain = self%gain + change(19)
      self%field = self%field + change(20:22)
      if (self%limit < huge(self%limit)) self%limit = self%limit + change(23)
      if (self%follows_orbit) call self%orbit%shift(change(24:))
      if (.not. self%follows_earth) return
      call self%earth%path%shift(change(24:))
      self%earth%coefficients = self%earth%coefficients + change(31:33)
      self%earth%epoch_angle = self%earth%epoch_angle + change(34)
   end function shift

   !> Returns 3 if the limit applies to the components of a command that acts at all times; 0 for wheels, whose motors
   !> have their own limits, and for sampled commands.
   pure integer function limited_components(self) result(n)
      class(controller_t), intent(in) :: self
      n = merge(0, 3, self%by == BY_WHEELS .or. self%sample > 0.0_wp)
   end function limited_components

   pure logical function has_trait(self, trait) result(has)
      class(controller_t), intent(in) :: self
      integer, intent(in) :: trait
      select case (trait)
      case (IS_CONTROLLER)
         has = .true.
      case (IS_POINTING)
         has = self%law == POINTING
      case (JUMPS_WITH_SIGN)
         has = self%law == POINTING .and. .not. self%sample > 0.0_wp
      case (LIMITS_MOMENT)
         has = self%by == BY_MAGNETORQUERS
      case (DRIVES_WHEELS)
         has = self%by == BY_WHEELS
      case (LENDS_PARAMETERS)
         has = self%by == BY_WHEELS .and. .not. self%sample > 0.0_wp
      case (FOLLOWS_EARTH_FIELD)
         has = self%follows_earth
      case default
         has = .false.
      end select
   end function has_trait

   pure subroutine field_of_magnetorquers(self, field, found)
      class(controller_t), intent(in) :: self
      real(wp), intent(out) :: field(3)
      logical, intent(out) :: found
      found = self%by == BY_MAGNETORQUERS .and. .not. self%follows_earth
      field = 0.0_wp
      if (found) field = self%field
   end subroutine field_of_magnetorquers

   pure subroutine start_and_stop(self, start, stop)
      class(controller_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
   end subroutine start_and_stop

   pure real(wp) function held_command(self, wheel)
      class(controller_t), intent(in) :: self
      integer, intent(in) :: wheel
      held_command = self%held_by_wheels(wheel)
   end function held_command

   !> Returns the command, zero while the controller does not act, and the torque or moment that is applied.
   pure function commands_at(self, t, q, omega) result(commands)
      class(controller_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: commands(6)
      commands = 0.0_wp
      if (self%sample > 0.0_wp) then
         commands = [self%commanded, self%held]
      else if (self%on .and. t >= self%start .and. t <= self%stop) then
         commands(1:3) = self%command(t, q, omega)
         commands(4:6) = self%cut_off(commands(1:3))
      end if
   end function commands_at

   !> Leaves out every second line of the tables of orbits.
   subroutine thin_paths(self)
      class(controller_t), intent(inout) :: self
      call self%orbit%path%thin_table()
      call self%earth%path%thin_table()
   end subroutine thin_paths

   !> Writes or reads the values that the controller holds, and which of them are at a limit.
   subroutine transfer_controller(self, archive)
      class(controller_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call transfer_torque(self, archive)
      call archive%transfer(self%held)
      call archive%transfer(self%held_by_wheels)
      call archive%transfer(self%was_on)
      call archive%transfer(self%commanded)
      call archive%transfer(self%n_fields)
      call archive%transfer(self%field_times)
      call archive%transfer(self%fields)
   end subroutine transfer_controller

end module nutate_controller
