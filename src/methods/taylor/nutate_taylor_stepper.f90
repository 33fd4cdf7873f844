!> Taylor series: the motion in a step as a power series in time, whose order follows from the tolerance.
!>
!> The length of a step follows from the last coefficients before the step (À. Jorba, M. Zou, Experimental Mathematics
!> 14 (2005) 99), so that no step is rejected for its error, and the series gives the state at all times inside: dense
!> output. The projection onto the invariants follows the steps.
module nutate_taylor_stepper
   use nutate_archive, only: archive_t
   use nutate_sensitivity_projection, only: project_sensitivities
   use nutate_hamiltonian, only: moving_energy
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: most_inner
   use nutate_motion_series, only: AXIAL_TOP, FREE_BODY, motion_series_t, NO_ROWS, ROWS
   use nutate_noise, only: noise_t
   use nutate_power_series, only: fixed_step_order, highest_order, least_order
   use nutate_quaternion, only: quat_exp, quat_product
   use nutate_rigid_rates, only: begin_step, end_step, end_wheels, n_rates, prepare_rates, rigid_rates_t
   use nutate_row_change, only: add_change, get_change, row_change_t
   use nutate_series_tangent, only: series_tangent_t
   use nutate_spaced_projection, only: spaced_projection_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH
   use nutate_stepper, only: dense_stepper_t, integrator_settings_t, is_inside, outside, step_goal_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_error_weighting, only: book_share, step_error_t
   implicit none
   private

   public :: taylor_t, usual_interval

   !> Order for a tolerance: a part per binary digit (one per decimal digit) and a constant part. Up to this order the
   !> cost of a step grows more slowly than its length. `make bench BENCH=bench_series` shows the time of a run by
   !> order.
   real(wp), parameter :: order_per_digit = 0.3_wp, extra_order = 11.0_wp
   !> The same if no effect has an additional series: in linear potentials, under torques that are linear in Ω or depend
   !> on time alone, with wheels.
   real(wp), parameter :: simple_order_per_digit = 0.4_wp, simple_extra_order = 14.0_wp
   !> The same for free bodies, whose coefficients cost only a fifth of a step.
   real(wp), parameter :: free_order_per_digit = 0.6_wp, free_extra_order = 7.0_wp
   !> The same for tops in the axial frame, orders 20 to 26: coefficients there cost less than the rest of a step.
   real(wp), parameter :: axial_order_per_digit = 0.15_wp, axial_extra_order = 18.0_wp
   !> Fixed steps from one projection to the next; a projection costs a tenth to a fifth of a step. With 4, energy and
   !> momentum are as good as with 1. Adaptive steps are all projected: on the unstable axis of a box the others would
   !> exceed the tolerance.
   integer, parameter :: usual_interval = 4
   !> Longest step in units of time, used if all terms vanish, as for a body at rest.
   real(wp), parameter :: longest_reach = 1e9_wp
   !> Length of a step in units of time below which the size of the momentum is computed again, for the step: that of a
   !> whole unit may be far larger. One repetition suffices, since the length varies with the size to the power of 1/25.
   real(wp), parameter :: shortest_reach = 0.25_wp
   !> Largest number of units of time that are tried, each `shorter` than the one before: 72 decades.
   integer, parameter :: most_units = 60
   real(wp), parameter :: shorter = 0.0625_wp

   !> Stepper of the method. `step` allocates nothing. Between steps it keeps the data of the projection; all else is
   !> computed anew from the state.
   type, extends(dense_stepper_t) :: taylor_t
      private
      !> Settings: order (0: by the tolerance), projection, attitude.
      integer :: order = 0
      logical :: conserve = .true.
      logical :: attitude = .true.
      type(spaced_projection_t) :: projection
      type(rigid_rates_t) :: rates
      !> The series of the step under way or just done, the state it starts from and the torques that act.
      type(motion_series_t) :: series
      logical :: expanded = .false.
      type(state_t) :: first
      logical, allocatable :: acted(:)
      !> Rate of the space axes, rad/s, shape (3); true if they rotate and the series is that of non-rotating axes.
      real(wp) :: frame_rate(3) = 0.0_wp
      logical :: turns_free = .false.
      !> True if the state is a compensated sum: of a series of rows in body axes.
      logical :: compensated = .false.
      type(row_change_t) :: change = row_change_t()
      !> Time for which the rotation of the axes was computed last, s, and the quaternion of the inverse rotation; shape
      !> (4).
      real(wp) :: rotated_time = 0.0_wp, turn(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> State at the end of the step under way.
      type(state_t) :: next = state_t()
      type(series_tangent_t), allocatable :: tangent
   contains
      procedure :: disturb
      procedure :: set_up
      procedure :: advance
      procedure :: choose_step
      procedure :: project_for_output
      procedure :: state_at
      procedure :: update_commands
      procedure :: propagate_step
      procedure :: transfer
   end type taylor_t

contains

   !> Prepares the stepper. Errors: `NUTATE_BAD_ARGUMENT` for an effect without series, or an order that does not exist.
   subroutine set_up(self, system, settings, status)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (settings%series_order /= 0 .and. (settings%series_order < least_order .or. &
                                            settings%series_order > highest_order)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'series_order is not available', 'series_order')
         return
      end if
      if (.not. self%keeps_system) call prepare_series(self%series, system, status)
      if (.not. status%ok()) return
      if (.not. (self%keeps_system .and. (self%attitude .eqv. settings%attitude))) &
         call prepare_rates(self%rates, system, settings%attitude, .false.)
      if (allocated(self%tangent)) deallocate (self%tangent)
      self%order = settings%series_order
      self%conserve = settings%conserve
      self%attitude = settings%attitude
      self%expanded = .false.
      self%frame_rate = system%effects%frame_rate
      self%turns_free = follows_rotating_axes(system%effects) .or. system%effects%frame_turns .and. &
                        .not. (self%series%torques%has_more .or. self%series%torques%rank > 0)
      self%rotated_time = 0.0_wp
      self%turn = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      self%compensated = settings%attitude .and. .not. self%turns_free .and. is_compensated(self%series, system)
      call self%projection%prepare(system, settings%attitude, usual_interval, self%compensated)
      if (allocated(self%acted)) deallocate (self%acted)
      allocate (self%acted(system%effects%n_torques), source=.false.)
   end subroutine set_up

   !> Prepares the series for the effects of a system. Errors: `NUTATE_BAD_ARGUMENT` for an effect without series.
   subroutine prepare_series(series, system, status)
      type(motion_series_t), intent(inout) :: series
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      call series%torques%prepare(system%effects, status)
      if (.not. status%ok()) return
      if (allocated(series%wheels)) deallocate (series%wheels)
      if (system%effects%n_wheels > 0) then
         allocate (series%wheels)
         call series%wheels%prepare(system%effects, status)
         if (.not. status%ok()) return
      end if
      call series%prepare(system)
   end subroutine prepare_series

   !> Returns true for the series of three rows, or of the rotation, in body axes, if the space axes rotate or anything
   !> does work. Otherwise the sums over steps are plain.
   pure logical function is_compensated(series, system)
      type(motion_series_t), intent(in) :: series
      type(system_t), intent(in) :: system
      is_compensated = (series%best == ROWS .or. series%best == NO_ROWS) .and. series%axial%axis == 0
      if (is_compensated) is_compensated = system%effects%frame_turns .or. system%effects%n_works() > 0
   end function is_compensated

   !> Adds the noise of a trial run, for the states before their projection.
   subroutine disturb(self, noise)
      class(taylor_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%projection%disturb(noise)
   end subroutine disturb

   !> Discards the series, which depends on the earlier values.
   recursive subroutine update_commands(self)
      class(taylor_t), intent(inout) :: self
      self%expanded = .false.
   end subroutine update_commands

   !> Performs one step. Errors, with the state unchanged: `NUTATE_OFF_BRANCH` for a step so long that the series does
   !> not follow the motion, `NUTATE_NOT_FINITE`, `NUTATE_BAD_ARGUMENT` for a state off the constraint manifold.
   subroutine advance(self, system, state, dt, window_time, status)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: y(n_rates), done, given
      logical :: chosen, converges, restored
      converges = .true.
      call self%next%copy_from(state, self%rates%n_wheels, self%conserve)
      restored = .false.
      if (self%conserve) call self%projection%find_origin(self%next, restored)
      chosen = is_expanded(self, system, self%next, dt, window_time)
      if (.not. chosen) then
         call begin_step(self%rates, system, self%next, dt, window_time, y)
         self%series%order = merge(self%order, fixed_step_order, self%order > 0)
         if (self%rates%failure == 0) call expand_from(self, system, self%next, dt, y, converges)
         if (converges .and. size(self%work) > 0 .and. self%rates%failure == 0) converges = is_followed(self%series)
         self%expanded = self%expanded .and. converges
         if (.not. converges) self%rates%failure = NUTATE_OFF_BRANCH
      end if
      if (self%rates%failure == 0) then
         call self%series%tail%use_in_step(dt/self%series%time_unit)
         if (self%conserve) then
            if (.not. restored) call self%projection%begin_step(system, self%next)
            call self%first%balance%copy_from(self%next%balance, self%rates%n_wheels)
         end if
         call get_state(self, dt, y)
      end if
      call end_step(self%rates, y, self%next, status)
      if (status%code /= 0) return
      if (self%compensated) call apply_change(self, self%next)
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, self%next)
      if (size(self%work) > 0) call get_works(self, system, dt, self%next, self%work)
      if (self%conserve) then
         done = sum(abs(self%work))
         given = 0.0_wp
         if (done > 0.0_wp) then
            call estimate_error(self%series, dt/self%series%time_unit, self%step_error)
            call self%projection%end_step(system, self%next, chosen, sum(self%work), status, self%step_error, given)
            if (status%code /= 0) return
            if (abs(given) > 0.0_wp) call book_share(system%effects, given, done, self%work, self%next)
         else
            call self%projection%end_step(system, self%next, chosen, 0.0_wp, status, given=given)
            if (status%code /= 0) return
         end if
      end if
      call state%copy_from(self%next, self%rates%n_wheels, self%conserve)
   end subroutine advance

   !> Returns true if the last two terms of the series, differentiated twice, are no larger than the first. The limit is
   !> a vibration that advances in the step by 1.2 rad at order 4, 2.7 at order 8, 5.7 at order 16, with an error of 2 %
   !> per step. Beyond the limit any small vibration grows, and if torques do work, no conserved energy keeps it small.
   pure logical function is_followed(series)
      !> Series of L and three rows, or of L and the rotation, with the step as the unit of time.
      type(motion_series_t), intent(in) :: series
      real(wp) :: scale
      integer :: n
      n = series%order
      if (series%by_rotation) then
         scale = maxval(abs(series%lanes(1:3, 2, 0:2)))
      else
         scale = maxval(abs(series%lanes(1, :, 0:2)))
      end if
      if (scale > tiny(1.0_wp)) scale = 1/scale
      is_followed = max((n*(n - 1))*size_of(n), ((n - 1)*(n - 2))*size_of(n - 1)) <= max(size_of(1), 2*size_of(2))

   contains

      !> Returns the size of coefficient k, rad.
      pure real(wp) function size_of(k)
         integer, intent(in) :: k
         if (series%by_rotation) then
            size_of = max(scale*maxval(abs(series%lanes(1:3, 2, k))), 2*maxval(abs(series%lanes(:, 1, k))))
         else
            size_of = max(scale*maxval(abs(series%lanes(1, :, k))), maxval(abs(series%lanes(2:4, :, k))))
         end if
      end function size_of

   end function is_followed

   !> Chooses the length of the step that meets a goal.
   recursive subroutine choose_step(self, system, state, goal, step, status)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(step_goal_t), intent(in) :: goal
      !> Length of the step, s, positive; an estimate on entry.
      real(wp), intent(inout) :: step
      !> Success on entry.
      type(status_t), intent(inout) :: status
      real(wp) :: y(n_rates), time_unit, reach, rate
      logical :: converges
      integer :: i
      call self%next%copy_from(state, self%rates%n_wheels, self%conserve)
      if (self%conserve) call self%projection%find_origin(self%next)
      call begin_step(self%rates, system, self%next, goal%end_time - state%t, 0.5_wp*(state%t + goal%end_time), y)
      self%expanded = .false.
      ! The step will report an error of the state.
      if (self%rates%failure /= 0) return
      time_unit = sign(2.0_wp**exponent(step), goal%end_time - state%t)
      do i = 1, most_units
         self%series%order = order_for(self, goal, abs(time_unit))
         call expand_from(self, system, self%next, time_unit, y, converges)
         if (converges) exit
         time_unit = shorter*time_unit
      end do
      if (.not. converges) then
         status = fail(NUTATE_OFF_BRANCH, 'the series does not converge for any step')
         return
      end if
      reach = reach_of(self, goal, abs(time_unit))
      if (reach < shortest_reach) then
         call self%series%fit_tail(reach)
         reach = reach_of(self, goal, abs(time_unit))
      end if
      step = min(abs(time_unit)*reach, abs(goal%end_time - state%t))
      rate = maxval(abs(self%series%omega(:, 0)))/abs(time_unit)
      if (.not. self%turns_free) rate = rate + maxval(abs(self%frame_rate))
      if (rate*step > self%series%largest_turn()) step = self%series%largest_turn()/rate
   end subroutine choose_step

   !> Returns the order for a tolerance.
   pure integer function order_for(self, goal, time_unit) result(order)
      class(taylor_t), intent(in) :: self
      type(step_goal_t), intent(in) :: goal
      !> Approximate length of the step, s.
      real(wp), intent(in) :: time_unit
      real(wp) :: digits
      order = self%order
      if (order > 0) return
      digits = real(exponent(max(goal%tolerance, goal%rate*time_unit, eps)), wp)
      select case (self%series%best)
      case (FREE_BODY)
         order = nint(free_extra_order - free_order_per_digit*digits)
      case (AXIAL_TOP)
         order = nint(axial_extra_order - axial_order_per_digit*digits)
      case default
         order = nint(extra_order - order_per_digit*digits)
         if (self%series%torques%is_simple .or. .not. self%series%torques%has_more) &
            order = nint(simple_extra_order - simple_order_per_digit*digits)
      end select
      order = min(max(order, least_order), highest_order)
   end function order_for

   !> Returns the time, in units, at which the part of the last term that the recurrence of the tail does not predict
   !> has the size that the goal allows; if there is no recurrence, or it does not reach so far, the larger of the last
   !> two terms is used instead.
   pure real(wp) function reach_of(self, goal, time_unit) result(s)
      class(taylor_t), intent(in) :: self
      type(step_goal_t), intent(in) :: goal
      !> s.
      real(wp), intent(in) :: time_unit
      real(wp) :: allowed, exponent
      integer :: k, power
      allowed = 2*log(max(goal%tolerance, goal%rate*time_unit, 0.5_wp*eps))
      power = self%series%order
      if (goal%rate > 0.0_wp) power = power - 1
      s = 0.0_wp
      associate (tail => self%series%tail)
         if (tail%limit > 0.0_wp) then
            s = exp((allowed - log(tail%rest))/(2*power))
            if (s <= tail%limit) return
            s = tail%limit
         end if
         exponent = log(longest_reach)
         do k = 0, 1
            if (tail%squares(2 - k) > tiny(1.0_wp)) &
               exponent = min(exponent, (allowed - log(tail%squares(2 - k)))/(2*(power - k)))
         end do
      end associate
      s = max(s, exp(exponent))
   end function reach_of

   !> Returns true if the series of a chosen step starts from this state, with the same torques.
   logical function is_expanded(self, system, state, dt, window_time)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Length of the step, and time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      integer :: i
      is_expanded = self%expanded
      if (.not. is_expanded) return
      do i = 1, 4
         if (abs(state%q(i) - self%first%q(i)) > 0.0_wp .or. abs(state%p(i) - self%first%p(i)) > 0.0_wp) &
            is_expanded = .false.
      end do
      if (abs(state%t - self%first%t) > 0.0_wp) is_expanded = .false.
      if (self%rates%n_wheels > 0 .and. is_expanded) is_expanded = self%series%wheels%is_start( &
                                                    system%effects, state, window_time)
      do i = 1, size(self%acted)
         if (self%acted(i) .neqv. system%effects%torques(i)%item%acts_at(window_time)) &
            is_expanded = .false.
      end do
      self%rates%dt = dt
   end function is_expanded

   !> Expands the series from a state.
   subroutine expand_from(self, system, state, time_unit, y, converges)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s.
      real(wp), intent(in) :: time_unit
      !> [q, L, 0]; shape (n_rates).
      real(wp), intent(in) :: y(n_rates)
      logical, intent(out) :: converges
      integer :: i
      self%series%t = state%t
      self%series%time_unit = time_unit
      self%series%torques%moment = self%rates%moment
      if (self%rates%n_wheels > 0) call self%series%wheels%set_start(state, self%rates%wheels%driven)
      associate (start => self%series%torques%start)
         start = state%t
         ! At the end of a piece, or rounded beyond it, the step determines the piece.
         do i = 1, size(self%acted)
            if (self%rates%in_pieces(i) .and. self%rates%acts(i)) &
               start = min(max(start, self%rates%window(1, i)), self%rates%window(2, i))
         end do
         do i = 1, self%rates%n_wheels
            if (self%rates%wheels%driven(i)) &
               start = min(max(start, self%rates%wheels%window(1, i)), self%rates%wheels%window(2, i))
         end do
      end associate
      call self%series%expand(system, self%rates%acts, y(1:4), y(5:7), converges)
      if (converges) call self%series%fit_tail(1.0_wp)
      self%expanded = converges
      ! The balance of the state is not known before the step.
      call self%first%copy_from(state, self%rates%n_wheels, .not. self%conserve)
      do i = 1, size(self%acted)
         self%acted(i) = self%rates%acts(i)
      end do
   end subroutine expand_from

   !> Computes attitude and momentum at a time from the start of the series, and the gains of the wheels.
   subroutine get_state(self, time, y)
      class(taylor_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: time
      !> [q, L, 0]; shape (n_rates).
      real(wp), intent(out) :: y(n_rates)
      real(wp) :: rotation(4)
      if (self%compensated) then
         call get_change(self%series, time/self%series%time_unit, self%change)
         y(5:7) = self%change%momentum
         rotation = self%change%turn + [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      else
         call self%series%evaluate(time/self%series%time_unit, y(5:7), rotation)
      end if
      y(1:4) = self%first%q
      if (self%attitude) y(1:4) = quat_product(self%first%q, rotation)
      if (self%turns_free) then
         if (abs(time - self%rotated_time) > 0.0_wp) then
            self%rotated_time = time
            self%turn = quat_exp((-0.5_wp*time)*self%frame_rate)
         end if
         y(1:4) = quat_product(self%turn, y(1:4))
      end if
      y(8) = 0.0_wp
      self%step_error%work = 0.0_wp
      if (self%rates%n_wheels > 0) call self%series%wheels%evaluate( &
         self%series%order, time/self%series%time_unit, self%series%tail, self%rates%wheels%gain, &
         self%rates%wheels%work, self%step_error%wheels, self%step_error%work)
   end subroutine get_state

   !> Adds the change computed last to the state, instead of storing the rounded values.
   pure subroutine apply_change(self, state)
      class(taylor_t), intent(in) :: self
      type(state_t), intent(inout) :: state
      state%q = self%first%q
      state%p = self%first%p
      state%q_compensation = self%first%q_compensation
      state%p_compensation = self%first%p_compensation
      call add_change(self%change, state)
   end subroutine apply_change

   !> Computes the work of each torque, wheel and dependence on time from the start of the series to a time after it.
   !> Adds their possible error to that of the step.
   subroutine get_works(self, system, time, state, work)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: time
      !> State at that time; its work of the dependence on time is that of the start on entry.
      type(state_t), intent(inout) :: state
      !> J.
      real(wp), intent(inout) :: work(:)
      real(wp) :: of_time, error
      work = self%rates%work
      associate (torques => self%series%torques, n => size(self%acted))
         if (torques%n_lanes == 0) return
         of_time = 0.0_wp
         call torques%get_works(self%series%time_unit, time/self%series%time_unit, self%series%tail, work(1:n), &
                                of_time, error)
         self%step_error%work = self%step_error%work + error
         if (torques%n_lanes > n) call book_time_dependent_work(self, system, time, of_time, state, work(size(work)))
      end associate
   end subroutine get_works

   !> Adds the work of the dependence on time from the start of the series to a time after it: V1 - V0 + ∫ Ω·τ dt of the
   !> potentials that move, and ∫ -½ Ωᵀ(dJ/dt)Ω dt.
   subroutine book_time_dependent_work(self, system, time, of_torque, state, work)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Time, s; the integrals, J.
      real(wp), intent(in) :: time, of_torque
      !> State at that time; its work of time-dependent potentials is that of the start on entry.
      type(state_t), intent(inout) :: state
      !> J.
      real(wp), intent(out) :: work
      work = moving_energy(system%effects, state%q, self%first%t + time) &
             - moving_energy(system%effects, self%first%q, self%first%time_dependent_since(time)) + of_torque
      state%time_dependent_work = self%first%time_dependent_work + work
      state%time_dependent_until = self%first%t + time
   end subroutine book_time_dependent_work

   !> Computes the state at a time inside the last step, by its series. Errors: `NUTATE_BAD_ARGUMENT` if there is none,
   !> or the time is outside of it; those of the projection.
   subroutine state_at(self, system, t, state, work, status, works)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      real(wp) :: y(n_rates), time, given, done, each(size(self%work))
      integer :: i
      work = 0.0_wp
      if (present(works)) works = 0.0_wp
      if (.not. self%expanded .or. (self%keeps_steps .and. .not. is_inside(self, t))) then
         status = fail(NUTATE_BAD_ARGUMENT, outside)
         return
      end if
      state = self%first
      time = t - self%series%t
      self%rates%failure = 0
      call get_state(self, time, y)
      call end_step(self%rates, y, state, status)
      if (status%code /= 0) return
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, state)
      call get_works(self, system, time, state, each)
      do i = 1, size(each)
         work = work + each(i)
      end do
      state%t = t
      if (self%conserve) then
         state%balance%scale = self%next%balance%scale
         given = 0.0_wp
         done = sum(abs(each))
         if (done > 0.0_wp) then
            call estimate_error(self%series, time/self%series%time_unit, self%step_error)
            call self%projection%project_inside(system, state, work, status, self%step_error, given)
            if (abs(given) > 0.0_wp) call book_share(system%effects, given, done, each, state)
         else
            call self%projection%project_inside(system, state, work, status, given=given)
         end if
         work = work + given
      end if
      if (present(works)) works(:) = each
   end subroutine state_at

   !> Projects a copy of the state that the last step left.
   subroutine project_for_output(self, system, state)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      if (self%conserve) call self%projection%project_for_output(system, state)
   end subroutine project_for_output

   !> Moves sensitivities over a step by their series, and projects them if the state was projected. Works change like
   !> the energy, which the series conserves; if potentials move they are not needed, and are unchanged. Errors:
   !> `NUTATE_BAD_ARGUMENT` for effects without such series.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(taylor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(state_t) :: origin
      logical :: works, driven(most_inner)
      works = system%effects%n_works() > 0 .and. .not. system%effects%depends_on_time
      if (works) tangent%work = tangent%work - tangent%energy_row(system, before)
      origin = before
      call origin%restore_left()
      driven = .false.
      if (self%rates%n_wheels > 0) driven = self%rates%wheels%driven
      if (.not. allocated(self%tangent)) allocate (self%tangent)
      call self%tangent%propagate(system, origin, after, dt, self%series%torques%start, self%series%torques%moment, &
                                  self%series%order, self%acted, driven, tangent, status)
      if (works) tangent%work = tangent%work + tangent%energy_row(system, after)
      if (status%ok() .and. self%conserve .and. self%attitude .and. after%balance%count == 0) &
         call project_sensitivities(system, after, .false., tangent)
   end subroutine propagate_step

   !> Writes or reads the data that the projection keeps between steps; the series is computed anew from the state.
   subroutine transfer(self, archive)
      class(taylor_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%projection%transfer(archive)
      self%expanded = .false.
   end subroutine transfer

   !> Estimates the errors of attitude and momentum at a time.
   pure subroutine estimate_error(series, s, error)
      !> Series with its tail.
      type(motion_series_t), intent(in) :: series
      !> Time, in units of time.
      real(wp), intent(in) :: s
      type(step_error_t), intent(inout) :: error
      error%angle = series%tail%error_of_all(series%order, s)
      error%of_momentum = 0.0_wp
      if (series%scale > tiny(1.0_wp)) error%of_momentum = error%angle/series%scale
   end subroutine estimate_error

end module nutate_taylor_stepper
