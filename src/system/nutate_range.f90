!> What can be computed with: systems, settings and states whose numbers are finite and of a size that products of a
!> few of them leave in the range of numbers. Tested once, before the first step.
module nutate_range
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_effect, only: are_in_range
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   use nutate_system, only: system_t
   implicit none
   private

   public :: check_system, check_start

   !> Steps lie between these, s.
   real(wp), parameter :: shortest = 1e-50_wp, longest = 1e50_wp
   !> Bound of the angle that the body turns in a step, rad: with more than that a step says nothing.
   real(wp), parameter :: greatest_turn = 1e8_wp
   !> Norms of q that can be one, but for the error of its source.
   real(wp), parameter :: least_norm = 0.5_wp, greatest_norm = 2.0_wp
contains

   !> Errors: `NUTATE_BAD_BODY` for a body that was not made; `NUTATE_BAD_ARGUMENT` for an effect whose numbers are
   !> not finite or beyond 1e100 in SI units.
   pure subroutine check_system(system, status)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      integer :: i
      if (.not. all(system%body%moments > 0.0_wp)) then
         status = fail(NUTATE_BAD_BODY, 'the system has no body (expected one from make_body)', 'inertia')
         return
      end if
      associate (effects => system%effects)
         do i = 1, effects%n_potentials
            if (.not. effects%potentials(i)%item%in_range()) status = beyond(effects%potentials(i)%item%name)
         end do
         do i = 1, effects%n_torques
            if (.not. effects%torques(i)%item%in_range()) status = beyond(effects%torques(i)%item%name)
         end do
         if (.not. are_in_range(effects%rotor_momentum)) status = beyond('rotor')
      end associate
   end subroutine check_system

   pure type(status_t) function beyond(name)
      character(len=*), intent(in) :: name
      beyond = fail(NUTATE_BAD_ARGUMENT, 'the effect '//trim(name)//' is beyond all scales (expected finite '// &
                    'numbers below 1e100 in SI units)')
   end function beyond

   !> Errors: `NUTATE_BAD_ARGUMENT` for a state or a step that is not finite or of no sensible size.
   pure subroutine check_start(system, state, dt, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      real(wp) :: norm, momentum
      if (.not. (are_in_range([state%t, state%q, state%p]) .and. ieee_is_finite(dt))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the state or the step is not finite, or beyond all scales (expected '// &
                       'numbers below 1e100)')
         return
      end if
      norm = norm2(state%q)
      momentum = maxval(abs(state%p))
      if (norm < least_norm .or. norm > greatest_norm) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is no unit quaternion')
      else if (momentum > 0.0_wp .and. momentum < tiny(1.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the momentum has lost digits (expected 0, or above 2e-308 in SI units)')
      else if (abs(dt) < shortest .or. abs(dt) > longest) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the step is beyond all scales (expected 1e-50 to 1e50 s)')
      else if (abs(dt)*maxval(abs(angular_velocity(system, state))) > greatest_turn) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the body turns by more than 1e8 rad in the step (expected a shorter one)')
      end if
   end subroutine check_start

end module nutate_range
