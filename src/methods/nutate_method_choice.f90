!> `method = 'auto'`: which method an accuracy costs least with, and why.
!>
!> The rules are those of the tables in docs/accuracy.md, which `bench_choice` measures.
module nutate_method_choice
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, LINEAR_SERIES, NO_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_exact_free, only: free_body_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum
   use nutate_kinds, only: wp
   use nutate_methods, only: default_settings
   use nutate_quaternion, only: quat_norm
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: choose_method, choose_order, effect_without_series, AUTOMATIC_METHOD

   !> What scenes call the choice.
   character(len=*), parameter :: AUTOMATIC_METHOD = 'auto'

   !> Accuracy from which on the series is the cheapest, rad: in general, and for a fast top, a body that rotates many
   !> times under potentials that are linear in the directions. Read off the tables of `make bench BENCH=bench_choice`.
   real(wp), parameter :: series_pays = 1e-8_wp, series_pays_for_tops = 1e-2_wp
   !> Turn from start to end that makes a top fast, rad: in `bench_choice` the series wins at 280 to 400 rad, not at 50.
   real(wp), parameter :: fast_turn = 100.0_wp
   !> An explicit step is at most some 6 times the time in which damping stops the body; steps of order 2 number about
   !> 60 over the root of the accuracy, and cost as much as 8 explicit ones (docs/accuracy.md). Damping is strong where
   !> its rate times the time of the run exceeds 6·8·60 over that root.
   real(wp), parameter :: strong_damping = 3e3_wp

   !> Accuracies from which on orders 8, 6 and 4 of the implicit step cost less than lower ones, rad (docs/accuracy.md).
   real(wp), parameter :: order_8_pays = 1e-5_wp, order_6_pays = 1e-3_wp, order_4_pays = 1e-1_wp

contains

   !> The order of the implicit step for an accuracy, where it is open: 0. It stays 2 where damping is strong: the
   !> stages of higher orders that go back in time would drive.
   pure subroutine choose_order(system, duration, accuracy, settings)
      type(system_t), intent(in) :: system
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> rad.
      real(wp), intent(in) :: accuracy
      type(integrator_settings_t), intent(inout) :: settings
      if (settings%order /= 0 .or. settings%method /= 'nielsen_krenk') return
      settings%order = 2
      if (damping_is_strong(system, duration, accuracy)) return
      if (accuracy <= order_4_pays) settings%order = 4
      if (accuracy <= order_6_pays) settings%order = 6
      if (accuracy <= order_8_pays) settings%order = 8
   end subroutine choose_order

   !> The method for an accuracy.
   subroutine choose_method(system, state, duration, accuracy, settings, reason)
      type(system_t), intent(in) :: system
      !> The start.
      type(state_t), intent(in) :: state
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      !> Attitude error at the end, or of each step, rad.
      real(wp), intent(in) :: accuracy
      !> Method, order, solver and `conserve` are set; all else is kept.
      type(integrator_settings_t), intent(inout) :: settings
      !> Why, in a few words.
      character(len=:), allocatable, intent(out) :: reason
      character(len=24) :: without_series

      without_series = effect_without_series(system%effects)
      if (has_closed_solution(system, state)) then
         call take('exact', settings)
         reason = 'the motion of a free body has a closed solution'
      else if (damping_is_strong(system, duration, accuracy)) then
         call take('nielsen_krenk', settings)
         settings%linear_solver = 'reduced'
         reason = 'strong damping keeps explicit steps shorter than the accuracy asks for'
      else if (without_series /= '') then
         call take('dop853', settings)
         settings%conserve = .true.
         reason = "effect '"//trim(without_series)//"' has no series; with the projection onto the invariants"
      else if (accuracy <= series_pays) then
         call take('taylor', settings)
         reason = 'from 1e-8 rad on the series costs least'
      else if (is_fast_top(system, state, duration) .and. accuracy <= series_pays_for_tops) then
         call take('taylor', settings)
         reason = 'for many revolutions in a uniform field the series costs least'
      else
         call take('dop853', settings)
         settings%conserve = .true.
         reason = 'above 1e-8 rad, with the projection onto the invariants, it costs less than the series'
      end if
   end subroutine choose_method

   !> Sets a method with its own order, solver and `conserve`.
   pure subroutine take(method, settings)
      character(len=*), intent(in) :: method
      type(integrator_settings_t), intent(inout) :: settings
      type(integrator_settings_t) :: usual
      usual = default_settings(method)
      settings%method = usual%method
      settings%order = usual%order
      settings%linear_solver = usual%linear_solver
      settings%conserve = usual%conserve
      settings%series_order = 0
   end subroutine take

   !> Name of an effect that supplies no series; blank where all do.
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

   !> True for a free body whose closed solution can be computed.
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

   !> True where the rate of damping keeps explicit steps much shorter than the accuracy does.
   pure logical function damping_is_strong(system, duration, accuracy)
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: duration
      !> rad.
      real(wp), intent(in) :: accuracy
      real(wp) :: slowing(3, 3), rate
      integer :: i
      rate = 0.0_wp
      associate (effects => system%effects)
         do i = 1, effects%n_torques
            if (effects%torques(i)%item%series_kind() /= LINEAR_SERIES) cycle
            slowing = matmul(system%body%inverse_inertia, effects%torques(i)%item%series_drag())
            rate = rate - min(slowing(1, 1), slowing(2, 2), slowing(3, 3))
         end do
      end associate
      ! A logarithm, since products of legal numbers could overflow.
      damping_is_strong = rate > 0.0_wp .and. abs(duration) > 0.0_wp
      if (damping_is_strong) damping_is_strong = log(rate) + log(abs(duration)) + 0.5_wp*log(accuracy) > &
                                                 log(strong_damping)
   end function damping_is_strong

   !> True where all effects are linear potentials and the rate of the start makes the body a fast top.
   pure logical function is_fast_top(system, state, duration)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s.
      real(wp), intent(in) :: duration
      real(wp) :: rate
      integer :: i
      associate (effects => system%effects)
         is_fast_top = effects%n_potentials > 0 .and. effects%n_torques + effects%n_rotors == 0 .and. &
                       .not. effects%frame_turns
         do i = 1, effects%n_potentials + effects%n_off
            if (effects%potentials(i)%item%series_kind() /= LINEAR_SERIES) is_fast_top = .false.
         end do
      end associate
      rate = quat_norm([0.0_wp, angular_velocity(system, state)])
      is_fast_top = is_fast_top .and. rate > 0.0_wp .and. abs(duration) > 0.0_wp
      if (is_fast_top) is_fast_top = log(rate) + log(abs(duration)) > log(fast_turn)
   end function is_fast_top

end module nutate_method_choice
