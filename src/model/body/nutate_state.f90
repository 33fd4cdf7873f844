!> The state of a rotating body: time, attitude and conjugate momentum, with the digits that rounding would lose, and
!> the compensated summation that keeps them.
module nutate_state
   use nutate_archive, only: archive_t
   use nutate_energy_balance, only: energy_balance_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_same_time, most_inner
   implicit none
   private

   public :: state_t, add_increment, add_rotated

   !> Attitude and momentum in the axes in which a stepper works, if these are not the space axes (`nutate_lvlh_view`).
   type, private :: other_axes_t
      !> There are such axes; if not, the other components have no meaning.
      logical :: exist = .false.
      !> Attitude and conjugate momentum; shape (4). Both have the compensations of the state.
      real(wp) :: q(4) = 0.0_wp, p(4) = 0.0_wp
      !> Attitude and momentum in space axes, shape (4), and time, s, of the state to which these axes belong.
      real(wp), private :: space_q(4) = 0.0_wp, space_p(4) = 0.0_wp, t = 0.0_wp
   end type other_axes_t

   !> A point in phase space. Made by `make_state`; moved by a stepper.
   type :: state_t
      !> s.
      real(wp) :: t = 0.0_wp
      !> Attitude q, unit quaternion, scalar first, body→space; shape (4).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Conjugate momentum p = 2 q∘[0, L], kg m²/s; shape (4).
      real(wp) :: p(4) = 0.0_wp
      !> Compensation of the rounding of q and p, added to the next increment (`add_increment`); shape (4).
      real(wp) :: q_compensation(4) = 0.0_wp, p_compensation(4) = 0.0_wp
      !> Absolute momentum of each wheel about its axis, N m s, and the compensation of its rounding; shape
      !> (most_inner).
      real(wp) :: wheel_momentum(most_inner) = 0.0_wp, wheel_compensation(most_inner) = 0.0_wp
      !> Work of the motor of each wheel, and of its friction, since the state was made, J; shape (2, most_inner).
      real(wp) :: wheel_work(2, most_inner) = 0.0_wp
      !> Work of time-dependent potentials since the state was made, J.
      real(wp) :: time_dependent_work = 0.0_wp
      !> Time up to which the work of time-dependent potentials is included, s; differs from `t` by a rounding if `t`
      !> was set to the end of a step.
      real(wp) :: time_dependent_until = -huge(1.0_wp)
      !> Target values of the invariants, for steppers that project onto them.
      type(energy_balance_t) :: balance = energy_balance_t()
      !> Copy of this state in the axes of the last step, bitwise as the step left it.
      type(other_axes_t) :: other_axes = other_axes_t()
   contains
      !> Stores the attitude and the momentum in other axes with the state.
      procedure, non_overridable :: set_other_axes
      !> Returns true if the stored attitude and momentum in other axes belong to the state.
      procedure, non_overridable :: is_from_other_axes
      !> Copies another state.
      procedure, non_overridable :: copy_from
      !> Returns true if the balance belongs to this state.
      procedure, non_overridable :: is_balanced
      !> Makes the balance belong to this state.
      procedure, non_overridable :: balance_here
      !> Restores the state that the last step left, if this is a projected copy of it.
      procedure, non_overridable :: restore_left
      !> Returns the time from which the work of time-dependent potentials counts in the next step.
      procedure, non_overridable :: time_dependent_since
      !> Writes or reads the state's own values in checkpoint data.
      procedure, non_overridable :: transfer => transfer_state
      !> Writes or reads the values of wheels, the work of time-dependent potentials, and the state in other axes.
      procedure, non_overridable :: transfer_wheels
   end type state_t

contains

   !> Returns true if the balance belongs to exactly this attitude and momentum.
   pure logical function is_balanced(self)
      class(state_t), intent(in) :: self
      real(wp) :: difference(4)
      is_balanced = self%balance%open
      if (.not. is_balanced) return
      difference = abs(self%q - self%balance%q) + abs(self%p - self%balance%p)
      is_balanced = (difference(1) + difference(2)) + (difference(3) + difference(4)) <= 0.0_wp
   end function is_balanced

   !> Marks the balance as belonging to this state.
   pure subroutine balance_here(self)
      class(state_t), intent(inout) :: self
      self%balance%q = self%q
      self%balance%p = self%p
   end subroutine balance_here

   !> Stores the attitude and the momentum in other axes with the state.
   pure subroutine set_other_axes(self, inner)
      !> Attitude and momentum in space axes.
      class(state_t), intent(inout) :: self
      !> Attitude and momentum of this state in other axes.
      type(state_t), intent(in) :: inner
      self%other_axes%exist = .true.
      self%other_axes%q = inner%q
      self%other_axes%p = inner%p
      self%q_compensation = inner%q_compensation
      self%p_compensation = inner%p_compensation
      self%other_axes%space_q = self%q
      self%other_axes%space_p = self%p
      self%other_axes%t = self%t
   end subroutine set_other_axes

   !> Returns true if the attitude and the momentum in other axes belong to exactly this state. The time may differ by
   !> the rounding of the end of a step.
   pure logical function is_from_other_axes(self)
      class(state_t), intent(in) :: self
      real(wp) :: difference(4)
      is_from_other_axes = self%other_axes%exist
      if (.not. is_from_other_axes) return
      difference = abs(self%q - self%other_axes%space_q) + abs(self%p - self%other_axes%space_p)
      is_from_other_axes = sum(difference) <= 0.0_wp .and. is_same_time(self%t, self%other_axes%t, 0.0_wp)
   end function is_from_other_axes

   !> Restores the state that the last step left, if this is a projected copy of it.
   pure subroutine restore_left(self)
      class(state_t), intent(inout) :: self
      if (.not. self%balance%projected) return
      if (.not. self%is_balanced()) return
      self%q = self%balance%left_q
      self%p = self%balance%left_p
      self%q_compensation = self%balance%left_q_compensation
      self%p_compensation = self%balance%left_p_compensation
      self%balance%projected = .false.
      call self%balance_here()
   end subroutine restore_left

   !> Returns the time from which the work of time-dependent potentials counts in the next step, s: the time up to which
   !> it is counted, unless the state was moved to another time. Otherwise work between the two times would be lost.
   pure real(wp) function time_dependent_since(self, dt)
      class(state_t), intent(in) :: self
      !> The step, s.
      real(wp), intent(in) :: dt
      time_dependent_since = self%t
      if (is_same_time(self%t, self%time_dependent_until, dt)) time_dependent_since = self%time_dependent_until
   end function time_dependent_since

   !> Copies another state; that costs less than an assignment.
   pure subroutine copy_from(self, other, n_wheels, balance)
      class(state_t), intent(inout) :: self
      type(state_t), intent(in) :: other
      !> Number of momenta of wheels and inner spheres; further ones are not copied.
      integer, intent(in) :: n_wheels
      !> The state has a balance; otherwise the values that belong to it are not copied.
      logical, intent(in) :: balance
      self%t = other%t
      self%q = other%q
      self%p = other%p
      self%q_compensation = other%q_compensation
      self%p_compensation = other%p_compensation
      self%time_dependent_work = other%time_dependent_work
      self%time_dependent_until = other%time_dependent_until
      if (other%other_axes%exist .or. self%other_axes%exist) self%other_axes = other%other_axes
      if (balance) call self%balance%copy_from(other%balance, n_wheels)
      if (n_wheels == 0) return
      self%wheel_momentum(:n_wheels) = other%wheel_momentum(:n_wheels)
      self%wheel_compensation(:n_wheels) = other%wheel_compensation(:n_wheels)
      self%wheel_work(:, :n_wheels) = other%wheel_work(:, :n_wheels)
   end subroutine copy_from

   !> Writes or reads time, attitude and momentum, with their compensations, in checkpoint data.
   subroutine transfer_state(self, archive)
      class(state_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%t)
      call archive%transfer(self%q)
      call archive%transfer(self%p)
      call archive%transfer(self%q_compensation)
      call archive%transfer(self%p_compensation)
   end subroutine transfer_state

   !> Writes or reads the values of wheels, the work of time-dependent potentials, and the state in other axes in
   !> checkpoint data.
   subroutine transfer_wheels(self, archive)
      class(state_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      call archive%transfer(self%wheel_momentum)
      call archive%transfer(self%wheel_compensation)
      do i = 1, most_inner
         call archive%transfer(self%wheel_work(:, i))
      end do
      call archive%transfer(self%time_dependent_work)
      call archive%transfer(self%time_dependent_until)
      call archive%transfer(self%other_axes%exist)
      if (.not. self%other_axes%exist) return
      call archive%transfer(self%other_axes%q)
      call archive%transfer(self%other_axes%p)
      call archive%transfer(self%other_axes%space_q)
      call archive%transfer(self%other_axes%space_p)
      call archive%transfer(self%other_axes%t)
   end subroutine transfer_wheels

   !> Adds an increment to a sum kept as `total + compensation`, by compensated summation.
   !>
   !> Kahan's summation (1965) with the error of each sum from Knuth's two-sum: the rounding error of a sum is added to
   !> the next increment. Two-sum gives this error exactly, whichever of sum and increment is larger, and the rounding
   !> error of increment + compensation is kept as well. So only the rounding of the compensation is lost: over many
   !> steps round-off grows like that of the increments, not of the sum. A part of the increment below its own last
   !> digit is not lost either, if it was put into the compensation.
   elemental subroutine add_increment(total, compensation, increment)
      real(wp), intent(inout) :: total, compensation
      real(wp), intent(in) :: increment
      real(wp) :: addend, rounded, part, lost
      addend = increment + compensation
      ! If the compensation is larger than the increment, the error of `lost` is below the last digit of the
      ! compensation.
      lost = compensation - (addend - increment)
      rounded = total + addend
      part = rounded - total
      compensation = ((total - (rounded - part)) + (addend - part)) + lost
      total = rounded
   end subroutine add_increment

   !> Adds the increment of a quaternion that was rotated, and subtracts the excess length that the rotation gave it.
   !> The subtraction comes before the sum, whose rounding leaves a compensation that is zero on average, since the next
   !> step does not include it.
   pure subroutine add_rotated(increment, excess, x, compensation)
      real(wp), intent(in) :: increment(4)
      !> Excess of the length of x, relative.
      real(wp), intent(in) :: excess
      real(wp), intent(inout) :: x(4), compensation(4)
      compensation = compensation - excess*(x + increment)
      call add_increment(x, compensation, increment)
   end subroutine add_rotated

end module nutate_state
