!> The predictor of implicit steps: the increments of the last steps continued by a polynomial.
module nutate_predictor
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: predictor_t, most_unknowns, highest_degree

   !> Most unknowns of a step, and the highest degree of the polynomial.
   integer, parameter :: most_unknowns = 8, highest_degree = 5

   !> The unknowns of the last steps, which were of one length.
   type :: predictor_t
      private
      !> Unknowns of a step, and degree of the polynomial through them.
      integer :: unknowns = most_unknowns, degree = highest_degree
      !> Steps known, at most degree + 1.
      integer, public :: known = 0
      !> Length of these steps, s.
      real(wp), public :: dt = 0.0_wp
      !> Unknowns of the last step and their backward differences of order 1, 2, ...; those beyond `unknowns` are zero.
      real(wp) :: differences(most_unknowns, 0:highest_degree) = 0.0_wp
   contains
      procedure :: set_up
      !> The polynomial through the last steps, continued by one.
      procedure :: predict
      !> Takes up the unknowns of a step that was done.
      procedure :: remember
      !> Forgets all but the last few steps.
      procedure :: forget
      !> Changes the unit of some unknowns.
      procedure :: change_unit
      !> Shows its values to an archive.
      procedure :: transfer
   end type predictor_t

contains

   subroutine set_up(self, unknowns, degree)
      class(predictor_t), intent(inout) :: self
      !> At most 8, and at most 5.
      integer, intent(in) :: unknowns, degree
      self%unknowns = unknowns
      self%degree = degree
      self%known = 0
      self%dt = 0.0_wp
      self%differences = 0.0_wp
   end subroutine set_up

   !> The polynomial through the last steps, which is the sum of the differences. For a step of another length only the
   !> last increment says something: in proportion.
   pure subroutine predict(self, dt, z)
      class(predictor_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      !> The unknowns; the present values are kept where no step is known.
      real(wp), intent(inout) :: z(most_unknowns)
      integer :: i, k
      if (self%known == 0) return
      if (dt /= self%dt) then
         self%differences(:, 0) = (dt/self%dt)*self%differences(:, 0)
         self%known = 1
         self%dt = dt
      end if
      ! Four at a time: what vector units take, whatever the number of unknowns.
      do i = 0, self%unknowns - 1, 4
         z(i + 1:i + 4) = self%differences(i + 1:i + 4, 0)
         do k = 1, self%known - 1
            z(i + 1:i + 4) = z(i + 1:i + 4) + self%differences(i + 1:i + 4, k)
         end do
      end do
   end subroutine predict

   !> Takes up the unknowns of a step that was done.
   pure subroutine remember(self, dt, z)
      class(predictor_t), intent(inout) :: self
      !> Of the step last predicted, s.
      real(wp), intent(in) :: dt
      real(wp), intent(in) :: z(most_unknowns)
      real(wp) :: new(4), old(4)
      integer :: i, k
      self%dt = dt
      self%known = min(self%known, self%degree) + 1
      do i = 0, self%unknowns - 1, 4
         new = z(i + 1:i + 4)
         do k = 0, self%known - 1
            old = self%differences(i + 1:i + 4, k)
            self%differences(i + 1:i + 4, k) = new
            new = new - old
         end do
      end do
   end subroutine remember

   !> Forgets all but the last few steps.
   pure subroutine forget(self, kept)
      class(predictor_t), intent(inout) :: self
      !> Steps to keep.
      integer, intent(in) :: kept
      self%known = min(self%known, kept)
   end subroutine forget

   !> Changes the unit of the unknowns from `first` on.
   pure subroutine change_unit(self, first, factor)
      class(predictor_t), intent(inout) :: self
      integer, intent(in) :: first
      !> Old unit over new.
      real(wp), intent(in) :: factor
      integer :: k
      do k = 0, highest_degree
         self%differences(first:, k) = factor*self%differences(first:, k)
      end do
   end subroutine change_unit

   !> Shows its values to an archive.
   subroutine transfer(self, archive)
      class(predictor_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%known)
      call archive%transfer(self%dt)
      call archive%transfer(self%differences(1:self%unknowns, 0:self%degree))
   end subroutine transfer

end module nutate_predictor
