!> Potentials and torques that a C program supplies.
!>
!> Callbacks are called from pure procedures: the program guarantees that their results depend on their arguments only.
!> Failures are kept in a cell of the run that called them (`status_of_failure`), not in the effect, so that runs of the
!> same system in several threads do not interfere.
module nutate_c_effects
   use, intrinsic :: iso_c_binding, only: c_double, c_funptr, c_int, c_null_funptr, c_null_ptr, c_ptr
   use nutate_effect, only: potential_t, torque_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate, in_words, greatest_number
   use nutate_quaternion, only: rotate_to_body
   use nutate_status, only: status_t, fail, NUTATE_CALLBACK, NUTATE_NOT_FINITE, NUTATE_OK
   implicit none
   private

   public :: c_potential_t, c_curved_potential_t, c_torque_t, report_failures_to, has_callbacks, &
      status_of_failure, add_failure, are_moderate

   !> Potential U(γ) with its gradient, from a callback `nutate_potential`.
   type, extends(potential_t) :: c_potential_t
      type(c_funptr) :: function = c_null_funptr
      !> User data, passed to the callback.
      type(c_ptr) :: user = c_null_ptr
      !> Address of two `int` for failures, or null: failures are not kept.
      type(c_ptr) :: failure = c_null_ptr
   contains
      procedure :: energy => called_energy
      procedure :: gradient => called_gradient
   end type c_potential_t

   !> Potential with second derivatives, from a callback `nutate_hessian`.
   type, extends(c_potential_t) :: c_curved_potential_t
      type(c_funptr) :: second = c_null_funptr
   contains
      procedure :: hessian => called_hessian
   end type c_curved_potential_t

   !> Torque τ(t, q, Ω) from a callback `nutate_torque`, Ω absolute.
   type, extends(torque_t) :: c_torque_t
      type(c_funptr) :: function = c_null_funptr
      !> User data, passed to the callback.
      type(c_ptr) :: user = c_null_ptr
      !> Address of two `int` for failures, or null: failures are not kept.
      type(c_ptr) :: failure = c_null_ptr
   contains
      procedure :: torque => called_torque
      procedure :: frame_change => called_frame_change
   end type c_torque_t

   interface
      pure subroutine call_potential(function, gamma, user, failure, energy, gradient) &
         bind(C, name='nutate_c_call_potential')
         import :: c_double, c_funptr, c_ptr
         type(c_funptr), intent(in), value :: function
         real(c_double), intent(in) :: gamma(3)
         type(c_ptr), intent(in), value :: user, failure
         real(c_double), intent(out) :: energy, gradient(3)
      end subroutine call_potential

      pure subroutine call_hessian(function, gamma, user, failure, hessian) bind(C, name='nutate_c_call_hessian')
         import :: c_double, c_funptr, c_ptr
         type(c_funptr), intent(in), value :: function
         real(c_double), intent(in) :: gamma(3)
         type(c_ptr), intent(in), value :: user, failure
         real(c_double), intent(out) :: hessian(3, 3)
      end subroutine call_hessian

      pure subroutine call_torque(function, t, q, omega, user, failure, tau) bind(C, name='nutate_c_call_torque')
         import :: c_double, c_funptr, c_ptr
         type(c_funptr), intent(in), value :: function
         real(c_double), intent(in), value :: t
         real(c_double), intent(in) :: q(4), omega(3)
         type(c_ptr), intent(in), value :: user, failure
         real(c_double), intent(out) :: tau(3)
      end subroutine call_torque
   end interface

contains

   !> Returns 1 if all numbers that a callback returned are finite and within the limits, else 0.
   pure integer(c_int) function are_moderate(n, numbers) bind(C, name='nutate_c_are_moderate')
      integer(c_int), intent(in), value :: n
      real(c_double), intent(in) :: numbers(n)
      are_moderate = merge(1, 0, all(is_moderate(numbers)))
   end function are_moderate

   pure real(wp) function called_energy(self, gamma)
      class(c_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      call call_potential(self%function, gamma, self%user, self%failure, called_energy, gradient)
   end function called_energy

   pure function called_gradient(self, gamma) result(gradient)
      class(c_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      real(wp) :: energy
      call call_potential(self%function, gamma, self%user, self%failure, energy, gradient)
   end function called_gradient

   pure function called_hessian(self, gamma) result(hessian)
      class(c_curved_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      call call_hessian(self%second, gamma, self%user, self%failure, hessian)
   end function called_hessian

   pure function called_torque(self, t, q, omega) result(tau)
      class(c_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      call call_torque(self%function, t, q, self%absolute_rate(q, omega), self%user, self%failure, tau)
   end function called_torque

   !> Returns the change of a torque, which depends on the absolute rate, by a change of the rate of the space axes.
   pure function called_frame_change(self, change, t, q, omega) result(tau)
      class(c_torque_t), intent(in) :: self
      real(wp), intent(in) :: change(3), t, q(4), omega(3)
      real(wp) :: tau(3), by_rotation(3, 3), by_rate(3, 3)
      call self%derivatives(t, q, omega, by_rotation, by_rate)
      tau = matmul(by_rate, rotate_to_body(q, change))
   end function called_frame_change

   !> Makes the callbacks among the effects report their failures to a cell.
   subroutine report_failures_to(effects, cell)
      type(effect_list_t), intent(inout) :: effects
      !> Address of two `int`, which must stay as long as the effects are used.
      type(c_ptr), intent(in) :: cell
      integer :: i
      do i = 1, effects%n_potentials + effects%n_off
         select type (item => effects%potentials(i)%item)
         class is (c_potential_t)
            item%failure = cell
         end select
      end do
      do i = 1, effects%n_torques
         select type (item => effects%torques(i)%item)
         class is (c_torque_t)
            item%failure = cell
         end select
      end do
   end subroutine report_failures_to

   !> Returns true if one of the effects is a callback.
   logical function has_callbacks(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_callbacks = .false.
      do i = 1, effects%n_potentials + effects%n_off
         select type (item => effects%potentials(i)%item)
         class is (c_potential_t)
            has_callbacks = .true.
         end select
      end do
      do i = 1, effects%n_torques
         select type (item => effects%torques(i)%item)
         class is (c_torque_t)
            has_callbacks = .true.
         end select
      end do
   end function has_callbacks

   !> Returns the status that a cell holds: `NUTATE_CALLBACK`, `NUTATE_NOT_FINITE`, or success.
   type(status_t) function status_of_failure(cell) result(status)
      !> Status of a callback, and the value that it returned; shape (2).
      integer(c_int), intent(in) :: cell(2)
      character(len=12) :: returned
      select case (cell(1))
      case (NUTATE_OK)
      case (NUTATE_CALLBACK)
         write (returned, '(i0)') cell(2)
         status = fail(NUTATE_CALLBACK, 'a callback reported a failure: it returned '//trim(returned))
      case default
         status = fail(NUTATE_NOT_FINITE, 'a callback gave a number that is not finite or exceeds '// &
                       in_words(greatest_number))
      end select
   end function status_of_failure

   !> Replaces a success by the status that a cell holds.
   subroutine add_failure(cell, status)
      !> Status of a callback, and the value that it returned; shape (2).
      integer(c_int), intent(in) :: cell(2)
      type(status_t), intent(inout) :: status
      if (status%code == NUTATE_OK .and. cell(1) /= NUTATE_OK) status = status_of_failure(cell)
   end subroutine add_failure

end module nutate_c_effects
