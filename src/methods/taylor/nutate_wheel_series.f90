!> The momenta of wheels as power series in time, in addition to those of the motion: ḣ = u - cω, ω = h/Jw - s·Ω, with
!> h×Ω of inner spheres. All series are in `s = (t - t₀)/time_unit`.
module nutate_wheel_series
   use nutate_effect, only: LINEAR_SERIES, NO_SERIES, SPACE_SERIES, TIME_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   use nutate_power_series, only: highest_order, inverses, series_group_t
   use nutate_quaternion, only: cross
   use nutate_series_sum, only: sum_series
   use nutate_series_tail, only: series_tail_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: add_speeds, wheel_series_t

   !> The wheels of a system.
   type :: wheel_series_t
      !> Number of wheels.
      integer :: n = 0
      !> Start of the series for the motors, inside the piece of each, and unit of time, s.
      real(wp), private :: t = 0.0_wp, time_unit = 1.0_wp
      !> h at the start, N m s, and whether the motor acts; shape (most_inner).
      real(wp), private :: first(most_inner) = 0.0_wp
      logical, private :: driven(most_inner) = .false.
      !> Axes, body axes, shape (3, n).
      real(wp), allocatable, private :: axes(:, :)
      !> A lane for the motor of each wheel and one for its friction. h, N m s, of the wheel; ω, rad/s; torques u and
      !> -cω, N m, and their works in units of time, W; shape (lane, 0:highest_order, groups of lanes).
      real(wp), allocatable, dimension(:, :, :) :: momentum, speeds, torques, works
      !> Constants of each lane: axis, 1/Jw, kg⁻¹ m⁻², and c, N m s; shape (lane, 5, groups).
      real(wp), allocatable :: constants(:, :, :)
      !> Auxiliary series of each motor; shape (number of wheels).
      type(series_group_t), allocatable, private :: auxiliary(:)
      !> True for motors that depend on time alone, and for those that act and depend on the motion; shape (n).
      logical, allocatable, private :: is_timed(:), is_led(:)
      !> True if there are only reaction wheels, and no motor depends on the motion.
      logical :: asks_no_effect = .false.
      !> Ω, rad/s, and γ as arguments of motors; shape (3, 0:highest_order).
      real(wp), allocatable, private :: omega(:, :), gamma(:, :)
   contains
      !> Stores the wheels of a system.
      procedure :: prepare
      !> Sets the start of a series.
      procedure :: set_start
      !> Returns true if the series starts from a state, with the same motors.
      procedure :: is_start
      !> Starts a series.
      procedure :: start
      !> Returns a coefficient of Σ s h.
      procedure :: term
      !> Adds the coefficients that follow from one of Ω.
      procedure :: add_term
      !> Return a coefficient of h, of ω, and compute one of the change of a motor's torque by a change of its
      !> parameters.
      procedure :: momentum_term
      procedure :: speed_term
      procedure :: drive_change
      !> Computes the gains of the wheels up to a time.
      procedure :: evaluate
   end type wheel_series_t

contains

   !> Stores the wheels of a system. Errors: `NUTATE_BAD_ARGUMENT` for a motor without series.
   subroutine prepare(self, effects, status)
      class(wheel_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(inout) :: status
      integer :: i, j, lane, group
      self%n = effects%n_wheels
      if (allocated(self%axes)) deallocate (self%axes, self%constants, self%momentum, self%speeds, self%torques, &
                                            self%works, self%auxiliary, self%omega, self%gamma, &
                                            self%is_timed, self%is_led)
      if (self%n == 0) return
      allocate (self%axes(3, self%n), self%omega(3, 0:highest_order), self%gamma(3, 0:highest_order), source=0.0_wp)
      group = (self%n + 1)/2
      allocate (self%momentum(4, 0:highest_order, group), self%speeds(4, 0:highest_order, group), &
                self%torques(4, 0:highest_order, group), self%works(4, 0:highest_order, group), &
                self%constants(4, 5, group), source=0.0_wp)
      allocate (self%auxiliary(self%n))
      allocate (self%is_timed(self%n), self%is_led(self%n), source=.false.)
      self%asks_no_effect = effects%n_reaction_wheels == self%n
      do i = 1, self%n
         associate (wheel => effects%wheels(i))
            self%axes(:, i) = wheel%axis
            call find_lane(i, lane, group)
            do j = lane, lane + 1
               self%constants(j, :, group) = [wheel%axis, 1/wheel%inertia, wheel%friction]
            end do
            if (.not. allocated(wheel%motor)) cycle
            if (any(wheel%motor%series_kind() == [NO_SERIES, LINEAR_SERIES, SPACE_SERIES])) then
               status = fail(NUTATE_BAD_ARGUMENT, "the motor '"//trim(wheel%motor%name)// &
                             "' has no series (expected method = 'dop853' with conserve = .true.)", 'method')
               return
            end if
            self%is_timed(i) = wheel%motor%series_kind() == TIME_SERIES
            self%asks_no_effect = self%asks_no_effect .and. self%is_timed(i)
            allocate (self%auxiliary(i)%values(0:highest_order, wheel%motor%auxiliary_series()), source=0.0_wp)
         end associate
      end do
   end subroutine prepare

   !> Sets the start of a series.
   pure subroutine set_start(self, state, driven)
      class(wheel_series_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      !> The motor acts; shape (most_inner).
      logical, intent(in) :: driven(most_inner)
      self%first(:self%n) = state%wheel_momentum(:self%n)
      self%driven(:self%n) = driven(:self%n)
   end subroutine set_start

   !> Returns true if the series starts from a state, with the same motors.
   pure logical function is_start(self, effects, state, window_time)
      class(wheel_series_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> Time that decides which motors act, s.
      real(wp), intent(in) :: window_time
      integer :: i
      is_start = .true.
      do i = 1, self%n
         if (abs(state%wheel_momentum(i) - self%first(i)) > 0.0_wp) is_start = .false.
         if (self%driven(i) .neqv. effects%wheels(i)%is_driven(window_time)) is_start = .false.
      end do
   end function is_start

   !> Starts a series from the values of `set_start`, with the torques of motors that depend on time alone.
   pure subroutine start(self, effects, t, time_unit, order)
      class(wheel_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Start for the motors and unit of time, s.
      real(wp), intent(in) :: t, time_unit
      !> Highest coefficient.
      integer, intent(in) :: order
      real(wp) :: tau(3, 0:highest_order)
      integer :: i, lane, group
      self%t = t
      self%time_unit = time_unit
      do i = 1, self%n
         call find_lane(i, lane, group)
         self%momentum(lane:lane + 1, 0, group) = self%first(i)
         self%torques(lane, :order, group) = 0.0_wp
         self%is_led(i) = .false.
         if (.not. self%driven(i)) cycle
         if (self%is_timed(i)) then
            call effects%wheels(i)%motor%time_series(t, time_unit, self%auxiliary(i)%values, tau(:, :order))
            self%torques(lane, :order, group) = tau(1, :order)
         else if (.not. allocated(effects%wheels(i)%motor)) then
            self%torques(lane, 0, group) = effects%wheels(i)%command
         else
            self%is_led(i) = .true.
         end if
      end do
   end subroutine start

   !> Finds the lane of the motor of a wheel, before that of its friction, and its group.
   pure subroutine find_lane(i, lane, group)
      integer, intent(in) :: i
      integer, intent(out) :: lane, group
      lane = 1 + 2*iand(i - 1, 1)
      group = (i + 1)/2
   end subroutine find_lane

   !> Returns coefficient k of Σ s h, N m s, body axes; shape (3).
   pure function term(self, k)
      class(wheel_series_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp) :: term(3)
      integer :: i
      term = 0.0_wp
      do i = 1, self%n
         term = term + self%momentum(1 + 2*iand(i - 1, 1), k, (i + 1)/2)*self%axes(:, i)
      end do
   end function term

   !> Adds coefficient k of speed and torques, and k + 1 of h, from coefficient k of Ω.
   pure subroutine add_term(self, effects, k, omega)
      class(wheel_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      !> Body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      real(wp) :: tau(3), drive
      integer :: i, j, lane, group
      self%omega(:, k) = omega
      do i = 1, self%n
         if (.not. self%is_led(i)) cycle
         call find_lane(i, lane, group)
         call add_drive(self, effects, i, k, drive)
         self%torques(lane, k, group) = drive
      end do
      call add_speeds(size(self%speeds, 3), k, self%time_unit, omega, self%constants, self%speeds, self%torques, &
                      self%momentum)
      if (k == highest_order .or. effects%n_reaction_wheels == self%n) return
      do i = effects%n_reaction_wheels + 1, self%n, 3
         tau = 0.0_wp
         do j = 0, k
            tau = tau + cross([self%momentum_term(j, i), self%momentum_term(j, i + 1), self%momentum_term(j, i + 2)], &
                              self%omega(:, k - j))
         end do
         do j = 1, 3
            call find_lane(i + j - 1, lane, group)
            self%momentum(lane:lane + 1, k + 1, group) = self%momentum(lane:lane + 1, k + 1, group) &
                                                         + (self%time_unit*inverses(k + 1))*tau(j)
         end do
      end do
   end subroutine add_term

   !> Adds coefficient k of the speeds and of the torques of friction, and k + 1 of h, of two wheels at once. Arrays of
   !> explicit shape have constant strides.
   pure subroutine add_speeds(groups, k, time_unit, omega, constants, speeds, torques, momentum)
      integer, intent(in) :: groups, k
      !> s; coefficient k of Ω, body axes, rad/s.
      real(wp), intent(in) :: time_unit, omega(3)
      !> Axis, 1/Jw and c of each lane.
      real(wp), intent(in) :: constants(4, 5, groups)
      !> rad/s and N m, those of motors up to k, and h, N m s.
      real(wp), dimension(4, 0:highest_order, groups), intent(inout) :: speeds, torques, momentum
      real(wp) :: speed, factor
      integer :: g, i
      factor = time_unit*inverses(k + 1)
      do g = 1, groups
         do i = 1, 4
            speed = constants(i, 4, g)*momentum(i, k, g) - (constants(i, 1, g)*omega(1) &
                                                            + constants(i, 2, g)*omega(2) + constants(i, 3, g)*omega(3))
            speeds(i, k, g) = speed
         end do
         torques(2, k, g) = -constants(2, 5, g)*speeds(2, k, g)
         torques(4, k, g) = -constants(4, 5, g)*speeds(4, k, g)
         if (k == highest_order) cycle
         momentum(1:2, k + 1, g) = factor*(torques(1, k, g) + torques(2, k, g))
         momentum(3:4, k + 1, g) = factor*(torques(3, k, g) + torques(4, k, g))
      end do
   end subroutine add_speeds

   !> Computes coefficient k of the torque of a motor that depends on the motion.
   pure subroutine add_drive(self, effects, i, k, drive)
      class(wheel_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index of the wheel; coefficient.
      integer, intent(in) :: i, k
      !> N m.
      real(wp), intent(out) :: drive
      real(wp) :: tau(3)
      call effects%wheels(i)%motor%series_torque(k, self%t, self%time_unit, self%omega(:, 0:k), self%gamma(:, 0:k), &
                                                 self%auxiliary(i)%values, tau)
      drive = tau(1)
   end subroutine add_drive

   !> Returns coefficient k of h of a wheel, N m s.
   pure real(wp) function momentum_term(self, k, i) result(term)
      class(wheel_series_t), intent(in) :: self
      integer, intent(in) :: k, i
      integer :: lane, group
      call find_lane(i, lane, group)
      term = self%momentum(lane, k, group)
   end function momentum_term

   !> Returns coefficient k of ω of a wheel, rad/s.
   pure real(wp) function speed_term(self, k, i) result(term)
      class(wheel_series_t), intent(in) :: self
      integer, intent(in) :: k, i
      integer :: lane, group
      call find_lane(i, lane, group)
      term = self%speeds(lane, k, group)
   end function speed_term

   !> Computes coefficient k of the change of u; called after `add_term`, k = 0, 1, 2, ... in turn.
   pure subroutine drive_change(self, effects, i, change, k, drive, known)
      class(wheel_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index of the wheel.
      integer, intent(in) :: i
      !> Change of the wheel's `parameters`.
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      !> N m.
      real(wp), intent(out) :: drive
      logical, intent(out) :: known
      real(wp) :: tau(3), derivative(3, 3)
      drive = 0.0_wp
      known = .true.
      if (.not. self%driven(i) .or. size(change) < 9) return
      associate (motor => effects%wheels(i)%motor)
         call motor%series_derivative(k, self%t, self%time_unit, self%auxiliary(i)%values, derivative, known)
         if (.not. known) return
         call motor%series_change([change(7), 0.0_wp, 0.0_wp, change(8:9)], k, self%t, self%time_unit, &
                                  self%gamma(:, 0:k), self%auxiliary(i)%values, tau, known)
      end associate
      drive = tau(1)
   end subroutine drive_change

   !> Computes the gains of the wheels from the start of the series to a time, and the work of motors and friction: term
   !> by term, and the tail.
   pure subroutine evaluate(self, order, s, tail, gain, work, error, of_works)
      class(wheel_series_t), intent(in) :: self
      !> Highest coefficient.
      integer, intent(in) :: order
      !> Time, in units.
      real(wp), intent(in) :: s
      !> Tail of the series of the motion.
      type(series_tail_t), intent(in) :: tail
      !> Gains, N m s, shape (most_inner), and works, J, shape (2, most_inner).
      real(wp), intent(inout) :: gain(most_inner), work(2, most_inner)
      !> Possible truncation errors of each gain, N m s, shape (most_inner), and of all works together, J.
      real(wp), intent(inout) :: error(most_inner)
      real(wp), intent(out) :: of_works
      real(wp) :: weights(2), last(4), gains(4), works(4), off(4)
      integer :: i, k, lane, group, wheel
      call tail%weights(order, s, weights(1), weights(2))
      of_works = 0.0_wp
      do i = 1, self%n, 2
         group = (i + 1)/2
         call sum_series(order, s, self%momentum(:, :, group), weights, gains)
         call tail%sum_energies(order, s, self%works(:, :, group), works, off)
         do lane = 1, merge(4, 2, i < self%n)
            of_works = of_works + abs(self%time_unit)*off(lane)
            work(1 + iand(lane - 1, 1), i + (lane - 1)/2) = self%time_unit*works(lane)
         end do
         do wheel = i, min(i + 1, self%n)
            lane = 1 + 2*(wheel - i)
            last = 0.0_wp
            do k = 1, min(4, order)
               last(k) = self%momentum(lane, order + 1 - k, group)
            end do
            gain(wheel) = gains(lane)
            error(wheel) = tail%error_of(order, s, last)
         end do
      end do
   end subroutine evaluate

end module nutate_wheel_series
