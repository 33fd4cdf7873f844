!> Chooses what the settings of a run leave open, method and order, and why. Every interface chooses here.
!>
!> The rules rest on the tables of docs/results/accuracy-costs.md, which `bench_choice` measures.
module nutate_method_choice
   use nutate_effect, only: effect_t, GENERAL_SERIES, LINEAR_SERIES, NO_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_equal_steps, only: equal_steps_t
   use nutate_exact_free, only: free_body_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_methods, only: default_settings, with_defaults
   use nutate_quaternion, only: quat_norm
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_integrator_settings, only: integrator_settings_t
   implicit none
   private

   public :: choose_settings, choose_with_tangent, choose_method, effect_without_series, AUTOMATIC_METHOD

   !> Name of a method that requests the choice.
   character(len=*), parameter :: AUTOMATIC_METHOD = 'auto'

   !> Accuracy at and below which the series is the cheapest for effects that are not linear, rad: in general, and on
   !> long motions in potentials. `make bench BENCH=bench_choice` and runs of 800 random scenes gave these numbers.
   real(wp), parameter :: series_pays = 1e-6_wp, pays_for_long = 1e-3_wp
   !> Accuracy down to which fixed steps cost less than the series on motions that suit them, rad.
   real(wp), parameter :: equal_pays = 0.99e-7_wp
   !> Rounding of times, over accuracy times duration, above which it affects the error estimates of Runge-Kutta
   !> methods.
   real(wp), parameter :: rounded = 1e-3_wp
   !> Rotation from start to end that makes a motion long, rad: the series is the cheapest at 140 to 400 rad, not at 50.
   real(wp), parameter :: long_turn = 100.0_wp
   !> Damping is strong if its least rate times the duration exceeds `strong_on_all_axes` over the fifth root of the
   !> accuracy, or its largest rate times the duration `strong_on_one_axis` over the square root. The body then follows
   !> the other effects, or turns about an axis without damping, and implicit steps of order 2 depend on that slow
   !> motion alone, while all others are limited to some 10 times the time in which damping stops the body. The first
   !> number of each is that for higher orders of the implicit step, the second that for the series.
   real(wp), parameter :: strong_on_all_axes(2) = [4.0_wp, 2e3_wp], strong_on_one_axis(2) = [3.0_wp, 3e4_wp]

   !> Accuracies below which orders 8, 6 and 4 of the implicit step cost less than lower ones, rad (`nutate cost`).
   real(wp), parameter :: order_8_pays = 1e-5_wp, order_6_pays = 1e-3_wp, order_4_pays = 1e-1_wp

contains

   !> Completes the settings of a run: with an accuracy or a local tolerance it chooses the method, unless a setting
   !> belongs to a particular one; with an accuracy it chooses the order; all else gets its default.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for `auto` without an accuracy or a tolerance, or beside what it chooses.
   subroutine choose_settings(system, state, duration, accuracy, local_tolerance, settings, choice, status)
      type(system_t), intent(in) :: system
      !> Initial state.
      type(state_t), intent(in) :: state
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> Required accuracy of the attitude at the end, and of each step, rad; 0 if none is required.
      real(wp), intent(in) :: accuracy, local_tolerance
      type(integrator_settings_t), intent(inout) :: settings
      !> Reason for the method, in a few words; blank if it was not chosen.
      character(len=*), intent(out) :: choice
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: reason
      real(wp) :: asked
      choice = ''
      asked = max(accuracy, local_tolerance)
      if (settings%method == '' .and. asked > 0.0_wp .and. .not. names_parts(settings)) &
         settings%method = AUTOMATIC_METHOD
      if (settings%method /= AUTOMATIC_METHOD) then
         if (settings%method == '') settings%method = 'nielsen_krenk'
         if (accuracy > 0.0_wp) call choose_order(system, duration, accuracy, settings)
         settings = with_defaults(settings)
      else if (.not. asked > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, "method 'auto' needs an accuracy or a local_tolerance to choose by", &
                       'method')
      else if (names_parts(settings)) then
         status = fail(NUTATE_BAD_ARGUMENT, "method 'auto' chooses order, series_order, formulation, conserve "// &
                       'and projection (expected a method by name with them)', 'method')
      else
         call choose_method(system, state, duration, asked, settings, reason, at_end=accuracy > 0.0_wp)
         choice = reason
      end if
   end subroutine choose_settings

   !> Chooses a method that has sensitivities if the settings leave it open: for a free body with adaptive steps the
   !> closed solution, if its system is given.
   pure subroutine choose_with_tangent(adaptive, settings, system, state)
      !> True if steps are adaptive.
      logical, intent(in) :: adaptive
      type(integrator_settings_t), intent(inout) :: settings
      type(system_t), intent(in), optional :: system
      !> Initial state; present with `system`.
      type(state_t), intent(in), optional :: state
      if (settings%method /= '' .and. settings%method /= AUTOMATIC_METHOD) return
      if (present(system) .and. adaptive .and. .not. names_parts(settings)) then
         if (has_closed_solution(system, state)) settings%method = 'exact'
         if (settings%method == 'exact') return
      end if
      settings%method = 'nielsen_krenk'
      if (settings%order == 0 .and. adaptive) settings%order = 8
      if (settings%formulation == '') settings%formulation = 'reduced'
   end subroutine choose_with_tangent

   !> Returns true if a setting belongs to a particular method.
   pure logical function names_parts(settings)
      type(integrator_settings_t), intent(in) :: settings
      names_parts = settings%order /= 0 .or. settings%series_order /= 0 .or. settings%formulation /= '' .or. &
                    settings%conserve .or. .not. settings%projection
   end function names_parts

   !> Chooses the order of the implicit step for an accuracy if it is open (0). It stays 2 if damping is strong: the
   !> stages of higher orders that go back in time would amplify the motion.
   pure subroutine choose_order(system, duration, accuracy, settings)
      type(system_t), intent(in) :: system
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> Accuracy, rad.
      real(wp), intent(in) :: accuracy
      type(integrator_settings_t), intent(inout) :: settings
      if (settings%order /= 0 .or. settings%method /= 'nielsen_krenk') return
      settings%order = 2
      if (damping_is_strong(system, duration, accuracy, .true.)) return
      if (accuracy <= order_4_pays) settings%order = 4
      if (accuracy <= order_6_pays) settings%order = 6
      if (accuracy <= order_8_pays) settings%order = 8
   end subroutine choose_order

   !> Chooses the method for an accuracy.
   subroutine choose_method(system, state, duration, accuracy, settings, reason, at_end)
      type(system_t), intent(in) :: system
      !> Initial state.
      type(state_t), intent(in) :: state
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> Attitude error at the end, or of each step, rad.
      real(wp), intent(in) :: accuracy
      !> Method, order, formulation and `conserve` are set; all else is kept.
      type(integrator_settings_t), intent(inout) :: settings
      !> Reason for the method, in a few words.
      character(len=:), allocatable, intent(out) :: reason
      !> True (default) if the accuracy is that of the end; otherwise it is that of each step, for which fixed steps
      !> cannot be found.
      logical, intent(in), optional :: at_end
      type(lvlh_view_t) :: view
      type(state_t) :: inner
      logical :: of_run
      of_run = .true.
      if (present(at_end)) of_run = at_end
      call view%prepare(system)
      if (view%exists .and. .not. settings%in_space_axes) then
         call view%to_lvlh(state, inner)
         call choose_for_axes(view%system, inner, duration, accuracy, of_run, settings, reason)
      else
         call choose_for_axes(system, state, duration, accuracy, of_run, settings, reason)
      end if
   end subroutine choose_method

   !> Chooses the method for the axes in which the steps are taken.
   subroutine choose_for_axes(system, state, duration, accuracy, of_run, settings, reason)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Duration, s; accuracy, rad.
      real(wp), intent(in) :: duration, accuracy
      !> True if the accuracy is that of the end.
      logical, intent(in) :: of_run
      type(integrator_settings_t), intent(inout) :: settings
      character(len=:), allocatable, intent(out) :: reason
      character(len=24) :: without_series

      without_series = effect_without_series(system%effects)
      if (has_closed_solution(system, state)) then
         call take('exact')
         reason = 'the motion of a free body has a closed solution'
      else if (damping_is_strong(system, duration, accuracy, .false.)) then
         call take('nielsen_krenk')
         settings%formulation = 'reduced'
         reason = 'strong damping makes all other steps shorter than the accuracy requires'
      else if (without_series /= '') then
         call take('dop853')
         settings%conserve = .true.
         reason = "effect '"//trim(without_series)//"' has no series; with the projection onto the invariants"
      else if (rounds_times()) then
         call take('taylor')
         reason = 'so far from t = 0 the times inside of a step are rounded, which a series does not use'
      else if (of_run .and. takes_equal_steps()) then
         call take('rk8')
         reason = 'equal steps are cheapest for short smooth motion in uniform fields'
      else if (all_linear(system%effects)) then
         call take('taylor')
         reason = 'the Taylor series costs least under linear effects'
      else if (system%effects%depends_on_time) then
         call take('taylor')
         reason = 'the Taylor series costs least if potentials or the inertia vary with time'
      else
         call choose_by_accuracy()
      end if

   contains

      !> Returns true if torques depend on times that are rounded too much for an accuracy: that rounding would dominate
      !> the error estimate of a Runge-Kutta method, whose steps would become ever shorter.
      pure logical function rounds_times()
         real(wp) :: latest
         latest = max(abs(state%t), abs(state%t + duration))
         rounds_times = (system%effects%n_torques > 0 .or. system%effects%depends_on_time) .and. &
                        spacing(latest) > rounded*accuracy*abs(duration) .and. abs(duration) > 0.0_wp
      end function rounds_times

      !> Returns true if fixed steps of rk8 cost less than the series.
      logical function takes_equal_steps()
         type(equal_steps_t) :: equal
         call equal%recognise(system, default_settings('rk8'), state, duration, accuracy)
         takes_equal_steps = equal%suit .and. system%effects%n_potentials > 0 .and. accuracy >= equal_pays
      end function takes_equal_steps

      !> Chooses the series or dop853, whichever costs less for an accuracy.
      subroutine choose_by_accuracy()
         real(wp) :: pays
         character(len=8) :: number
         pays = series_pays
         if (system%effects%n_potentials > 0 .and. .not. system%effects%frame_turns) then
            if (is_long()) pays = pays_for_long
         end if
         write (number, '("1e",i0)') nint(log10(pays))
         if (accuracy <= pays) then
            call take('taylor')
            reason = 'from '//trim(number)//' rad on the Taylor series costs least for such a motion'
         else
            call take('dop853')
            settings%conserve = .true.
            reason = 'cheaper than the Taylor series at this accuracy (threshold '//trim(number)//' rad)'
         end if
      end subroutine choose_by_accuracy

      !> Sets a method with its default order, formulation and `conserve`.
      subroutine take(method)
         character(len=*), intent(in) :: method
         type(integrator_settings_t) :: usual
         usual = default_settings(method)
         settings%method = usual%method
         settings%order = usual%order
         settings%formulation = usual%formulation
         settings%conserve = usual%conserve
         settings%series_order = 0
      end subroutine take

      !> Returns true if the body rotates, or could swing under linear potentials, by more than `long_turn`.
      pure logical function is_long()
         real(wp) :: rate, moment(3), length, arm
         integer :: i, axis
         is_long = .false.
         if (.not. abs(duration) > 0.0_wp) return
         ! Logarithms, since products of legal numbers could overflow.
         rate = quat_norm([0.0_wp, angular_velocity(system, state)])
         if (rate > 0.0_wp) is_long = log(rate) + log(abs(duration)) > log(long_turn)
         do i = 1, system%effects%n_potentials
            if (system%effects%potentials(i)%item%series_kind() /= LINEAR_SERIES) cycle
            moment = system%effects%potentials(i)%item%series_moment()
            length = quat_norm([0.0_wp, system%effects%potentials(i)%item%direction])
            if (.not. length > 0.0_wp) cycle
            do axis = 1, 3
               arm = quat_norm([0.0_wp, 0.0_wp, moment(mod(axis, 3) + 1), moment(mod(axis + 1, 3) + 1)])
               if (.not. arm > 0.0_wp) cycle
               rate = 0.5_wp*(log(length) + log(arm) + log(system%body%inverse_inertia(axis, axis)))
               is_long = is_long .or. rate + log(abs(duration)) > log(long_turn)
            end do
         end do
      end function is_long

   end subroutine choose_for_axes

   !> Returns the name of an effect without a series; blank if there is none.
   pure function effect_without_series(effects) result(name)
      type(effect_list_t), intent(in) :: effects
      character(len=24) :: name
      integer :: i
      name = ''
      do i = 1, effects%n_potentials + effects%n_off
         call note_missing_series(effects%potentials(i)%item, name)
      end do
      do i = 1, effects%n_torques
         call note_missing_series(effects%torques(i)%item, name)
      end do
   end function effect_without_series

   pure subroutine note_missing_series(effect, name)
      class(effect_t), intent(in) :: effect
      character(len=*), intent(inout) :: name
      if (effect%series_kind() /= NO_SERIES) return
      name = effect%name
      if (name == '') name = 'unnamed'
   end subroutine note_missing_series

   !> Returns true for a free body whose closed solution can be computed.
   pure logical function has_closed_solution(system, state)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(free_body_t) :: solution
      type(status_t) :: status
      associate (effects => system%effects, body => system%body)
         has_closed_solution = effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors == 0 .and. &
                               .not. (any(abs(effects%rotor_momentum) > 0.0_wp) .or. effects%frame_turns)
         if (.not. has_closed_solution) return
         call solution%prepare(body%moments, state%q, body_momentum(state), status, body%axes)
         has_closed_solution = status%ok()
      end associate
   end function has_closed_solution

   !> Returns true if damping is strong for higher orders of the implicit step, or for the series. For the series, the
   !> first criterion applies only if something drives the body: one that stops is followed in long steps.
   pure logical function damping_is_strong(system, duration, accuracy, implicit) result(strong)
      type(system_t), intent(in) :: system
      !> Duration, s; accuracy, rad.
      real(wp), intent(in) :: duration, accuracy
      !> True for higher orders of the implicit step, false for the series.
      logical, intent(in) :: implicit
      real(wp) :: drag(3, 3), rates(3)
      logical :: driven
      integer :: i, k, kind
      kind = merge(1, 2, implicit)
      rates = 0.0_wp
      associate (effects => system%effects, body => system%body)
         driven = implicit .or. effects%frame_turns .or. effects%n_potentials + effects%n_off + effects%n_wheels > 0
         do i = 1, effects%n_torques
            if (effects%torques(i)%item%series_kind() == LINEAR_SERIES) then
               drag = effects%torques(i)%item%series_drag()
               do k = 1, 3
                  rates(k) = rates(k) - dot_product(body%axes(:, k), matmul(drag, body%axes(:, k)))/body%moments(k)
               end do
            else
               driven = .true.
            end if
         end do
      end associate
      strong = driven .and. exceeds(minval(rates), strong_on_all_axes(kind)*accuracy**(-0.2_wp))
      if (.not. strong) strong = exceeds(maxval(rates), strong_on_one_axis(kind)/sqrt(accuracy))

   contains

      !> Returns true if a rate times the duration exceeds a bound, by logarithms: products of legal numbers could
      !> overflow.
      pure logical function exceeds(rate, bound)
         !> 1/s.
         real(wp), intent(in) :: rate, bound
         exceeds = rate > 0.0_wp .and. abs(duration) > 0.0_wp
         if (exceeds) exceeds = log(rate) + log(abs(duration)) > log(bound)
      end function exceeds

   end function damping_is_strong

   !> Returns true if no effect has a series of its own: potentials and torques are linear, or given by time alone, in
   !> body axes or by a table.
   pure logical function all_linear(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      all_linear = .not. any([(effects%potentials(i)%item%series_kind(), i=1, effects%n_potentials + effects%n_off), &
                              (effects%torques(i)%item%series_kind(), i=1, effects%n_torques)] == GENERAL_SERIES)
   end function all_linear

end module nutate_method_choice
