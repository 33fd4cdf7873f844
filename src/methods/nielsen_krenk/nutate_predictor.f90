!> The predictor of implicit steps: the unknowns of the last steps continued by a polynomial.
module nutate_predictor
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: predictor_t, most_unknowns

   !> Largest number of unknowns of a step, and of steps that the polynomial uses: six cost the 8×8 system 6 to 11 %
   !> less than four (`bench_step`); more would extrapolate round-off.
   integer, parameter :: most_unknowns = 8, most_steps = 6
   !> Value of the polynomial through m equidistant points at the next one: column m holds the weights of the last, the
   !> last but one, ..., (-1)ᵏ (m over k+1).
   real(wp), parameter :: weights(most_steps, most_steps) = reshape([ &
      1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      2.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.0_wp, -3.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      4.0_wp, -6.0_wp, 4.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, &
      5.0_wp, -10.0_wp, 10.0_wp, -5.0_wp, 1.0_wp, 0.0_wp, &
      6.0_wp, -15.0_wp, 20.0_wp, -15.0_wp, 6.0_wp, -1.0_wp], [most_steps, most_steps])

   !> The last steps, all of one length.
   type :: predictor_t
      !> Number of steps known.
      integer :: known = 0
      !> Length of these steps, s.
      real(wp) :: dt = 0.0_wp
      !> The unknowns predicted for the present step.
      real(wp) :: guess(most_unknowns) = 0.0_wp
      !> Number of unknowns of a step.
      integer, private :: unknowns = most_unknowns
      !> Unknowns of the last steps, the latest first.
      real(wp), private :: past(most_steps, most_unknowns) = 0.0_wp
   contains
      procedure :: set_up
      !> Predicts a step of a given length.
      procedure :: predict
      !> Stores the unknowns of a step that was done.
      procedure :: remember
      !> Forgets all but the last few steps.
      procedure :: forget
      !> Changes the unit of some unknowns.
      procedure :: change_unit
      !> Writes or reads the values of the last steps.
      procedure :: transfer
      !> Write the values of the last steps as numbers, and read them.
      procedure :: put
      procedure :: take
   end type predictor_t

contains

   subroutine set_up(self, unknowns)
      class(predictor_t), intent(inout) :: self
      !> Number of unknowns of a step, at most 8.
      integer, intent(in) :: unknowns
      self%unknowns = unknowns
      self%known = 0
      self%dt = 0.0_wp
      self%guess = 0.0_wp
      self%past = 0.0_wp
   end subroutine set_up

   !> Predicts a step; at least one must be known. If its length differs from that of the last steps, only the last
   !> increment is used: in proportion.
   pure subroutine predict(self, dt)
      class(predictor_t), intent(inout) :: self
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      integer :: i
      if (dt /= self%dt) then
         self%past(1, :) = (dt/self%dt)*self%past(1, :)
         self%known = 1
         self%dt = dt
      end if
      do i = 1, self%unknowns
         self%guess(i) = continued(weights(:, self%known), self%past(:, i))
      end do
   end subroutine predict

   !> Returns Σ wₖ xₖ.
   pure real(wp) function continued(w, x)
      real(wp), intent(in) :: w(most_steps), x(most_steps)
      continued = (w(1)*x(1) + w(3)*x(3) + w(5)*x(5)) + (w(2)*x(2) + w(4)*x(4) + w(6)*x(6))
   end function continued

   !> Stores the unknowns of a step that was done.
   pure subroutine remember(self, dt, z)
      class(predictor_t), intent(inout) :: self
      !> Length of the step last predicted, s.
      real(wp), intent(in) :: dt
      real(wp), intent(in) :: z(most_unknowns)
      integer :: i
      self%dt = dt
      self%known = min(self%known + 1, most_steps)
      do i = 1, self%unknowns
         self%past(2:, i) = self%past(:most_steps - 1, i)
         self%past(1, i) = z(i)
      end do
   end subroutine remember

   !> Forgets all but the last few steps.
   pure subroutine forget(self, kept)
      class(predictor_t), intent(inout) :: self
      !> Number of steps to keep.
      integer, intent(in) :: kept
      self%known = min(self%known, kept)
   end subroutine forget

   !> Changes the unit of the unknowns from `first` on.
   pure subroutine change_unit(self, first, factor)
      class(predictor_t), intent(inout) :: self
      integer, intent(in) :: first
      !> Old unit over new.
      real(wp), intent(in) :: factor
      integer :: i
      do i = first, self%unknowns
         self%past(:, i) = factor*self%past(:, i)
      end do
   end subroutine change_unit

   !> Writes or reads the values of the last steps.
   subroutine transfer(self, archive)
      class(predictor_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%known)
      call archive%transfer(self%dt)
      call archive%transfer(self%past(:, 1:self%unknowns))
   end subroutine transfer

   !> Writes the values of the last steps as numbers.
   pure subroutine put(self, room, numbers, used)
      class(predictor_t), intent(in) :: self
      integer, intent(in) :: room
      real(wp), intent(inout) :: numbers(room)
      !> Numbers in use before and after.
      integer, intent(inout) :: used
      integer :: i
      numbers(used + 1) = real(self%known, wp)
      numbers(used + 2) = self%dt
      used = used + 2
      do i = 1, self%unknowns
         numbers(used + 1:used + most_steps) = self%past(:, i)
         used = used + most_steps
      end do
   end subroutine put

   !> Reads the values of the last steps from numbers.
   pure subroutine take(self, room, numbers, used)
      class(predictor_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in) :: numbers(room)
      !> Numbers read before and after.
      integer, intent(inout) :: used
      integer :: i
      self%known = int(numbers(used + 1))
      self%dt = numbers(used + 2)
      used = used + 2
      do i = 1, self%unknowns
         self%past(:, i) = numbers(used + 1:used + most_steps)
         used = used + most_steps
      end do
   end subroutine take

end module nutate_predictor
