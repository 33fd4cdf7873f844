!> Chooses rows so that interpolation by a rotation at a constant rate, as in readers, keeps to an attitude error.
!>
!> The given rows and their rates define the motion between them (`between_rows`). Each interval is first twice as long
!> as the one before, and halved as long as it rotates the body by more than a radian, or the rotation at a constant
!> rate departs from the motion by more than 0.9 of the error at one of its quarters or at a row inside it. That
!> departure is h²|Ω̇|/8 at its largest, near the middle.
module nutate_resampling
   use nutate_attitude_between, only: constant_rate
   use nutate_attitude_rows, only: attitude_rows_t, between_rows
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp
   use nutate_quaternion, only: attitude_distance
   implicit none
   private

   public :: resample

   !> Largest rotation between two rows, rad; part of the error that is used at the quarters; part of the error that the
   !> motion between the given rows may have.
   real(wp), parameter :: largest_turn = 1.0_wp, margin = 0.9_wp, share = 0.1_wp
   !> Largest rotation between two of the given rows, rad.
   real(wp), parameter :: too_far = 6000.0_wp
   !> Largest number of rows; more are a mistake.
   integer, parameter :: most_rows = 20000000

contains

   !> Chooses rows for an attitude error.
   pure subroutine resample(rows, error, chosen, problem)
      !> Rows with rates.
      type(attitude_rows_t), intent(in) :: rows
      !> Attitude error, rad.
      real(wp), intent(in) :: error
      type(attitude_rows_t), intent(out) :: chosen
      !> Reason why rows cannot be chosen; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      real(wp), allocatable :: t(:), longer(:)
      real(wp) :: own, from, to, length
      integer :: n, place, last

      problem = ''
      n = rows%count()
      if (.not. allocated(rows%omega)) then
         problem = 'there are no angular velocities (expected columns omega1, omega2, omega3)'
      else if (n < 3) then
         problem = 'there are too few rows to tell what lies between them (expected 3 or more)'
      end if
      if (problem /= '') return
      if (maxval(norm2(rows%omega, dim=1))*maxval(rows%t(2:) - rows%t(:n - 1)) > too_far) then
         problem = 'the rows are too far apart: between two of them the body turns by more than 6000 rad (expected '// &
                   'rows at shorter intervals)'
         return
      end if
      own = error_between(rows)
      if (own > share*error) then
         problem = 'the rows are too far apart for an error of '//rounded_text(error, 3)// &
                   ' rad: what they tell of the motion between them errs by '//rounded_text(own, 3)// &
                   ' rad, more than a tenth of it (expected rows at shorter intervals, or an error from '// &
                   rounded_text(1.01_wp*own/share, 3)//' rad)'
         return
      end if
      allocate (t(1024))
      t(1) = rows%t(1)
      last = 1
      place = 1
      from = rows%t(1)
      length = rows%t(n) - rows%t(1)
      do while (from < rows%t(n) .and. last < most_rows)
         call end_interval(rows, error, from, place, length, to)
         if (last == size(t)) then
            allocate (longer(2*last))
            longer(:last) = t
            call move_alloc(longer, t)
         end if
         last = last + 1
         t(last) = to
         from = to
      end do
      if (last >= most_rows) then
         problem = 'an error of '//rounded_text(error, 3)//' rad needs more than 2e7 rows (expected a larger error)'
         return
      end if
      call evaluate(rows, t(:last), chosen)
   end subroutine resample

   !> Returns the largest error of the motion between the rows, rad, from the distance of each row to the curve that
   !> joins the row before it and the second one after it. Rates that are not those of the attitudes show there too.
   pure real(wp) function error_between(rows) result(largest)
      type(attitude_rows_t), intent(in) :: rows
      real(wp) :: q(4), omega(3), longest, x, whole, least
      !> Share of the longest interval below which two rows are too close to show the error.
      real(wp), parameter :: closest = 1e-6_wp
      integer :: i, k
      largest = 0.0_wp
      do i = 2, rows%count() - 1
         k = min(i + 2, rows%count())
         call between_rows(rows, i - 1, k, rows%t(i), q, omega)
         longest = maxval(rows%t(i:k) - rows%t(i - 1:k - 1))
         x = rows%t(i) - rows%t(i - 1)
         whole = rows%t(k) - rows%t(i - 1)
         ! The error is x²(h-x)²/24 of the fourth derivative there, h⁴/384 in the longest of the intervals.
         least = closest*longest
         largest = max(largest, (longest/max(x, least))**2*(longest/max(whole - x, least))**2/16* &
                       attitude_distance(q, rows%q(:, i)))
      end do
   end function error_between

   !> Finds the end of the next interval, s: twice the length of the one before, or halved until it keeps to the error.
   pure subroutine end_interval(rows, error, from, place, length, to)
      type(attitude_rows_t), intent(in) :: rows
      real(wp), intent(in) :: error
      !> Start of the interval, s.
      real(wp), intent(in) :: from
      !> Index of the last row not behind the start; moved on.
      integer, intent(inout) :: place
      !> Length of the interval before, on return of this one, s.
      real(wp), intent(inout) :: length
      real(wp), intent(out) :: to
      call move_on(rows, from, place)
      length = 2*length
      do
         to = min(from + length, rows%t(rows%count()))
         if (keeps(rows, error, from, to, place)) exit
         length = 0.5_wp*min(length, to - from)
         if (from + 0.25_wp*length <= from) exit
      end do
   end subroutine end_interval

   !> Moves the index on to the last row not behind a time that is not the last one.
   pure subroutine move_on(rows, t, place)
      type(attitude_rows_t), intent(in) :: rows
      real(wp), intent(in) :: t
      integer, intent(inout) :: place
      do while (place < rows%count() - 1)
         if (rows%t(place + 1) > t) exit
         place = place + 1
      end do
   end subroutine move_on

   !> Returns true if a rotation at a constant rate keeps to the error.
   pure logical function keeps(rows, error, from, to, place)
      type(attitude_rows_t), intent(in) :: rows
      real(wp), intent(in) :: error, from, to
      !> Index of the last row not behind `from`.
      integer, intent(in) :: place
      real(wp) :: ends(4, 5), omega(3), s
      integer :: i, quarter
      keeps = .false.
      do quarter = 1, 5
         call attitude_at(rows, from + 0.25_wp*(quarter - 1)*(to - from), place, ends(:, quarter), omega)
         if (norm2(omega)*(to - from) > largest_turn) return
      end do
      do quarter = 2, 4
         if (attitude_distance(ends(:, quarter), constant_rate(ends(:, 1), ends(:, 5), 0.25_wp*(quarter - 1))) > &
             margin*error) return
      end do
      do i = place + 1, rows%count()
         if (rows%t(i) >= to) exit
         s = (rows%t(i) - from)/(to - from)
         if (attitude_distance(rows%q(:, i), constant_rate(ends(:, 1), ends(:, 5), s)) > margin*error) return
      end do
      keeps = .true.
   end function keeps

   !> Computes attitude and angular velocity at a time.
   pure subroutine attitude_at(rows, t, place, q, omega)
      type(attitude_rows_t), intent(in) :: rows
      real(wp), intent(in) :: t
      !> Index of a row not behind the time.
      integer, intent(in) :: place
      real(wp), intent(out) :: q(4), omega(3)
      integer :: i
      i = place
      call move_on(rows, t, i)
      call between_rows(rows, i, i + 1, t, q, omega)
   end subroutine attitude_at

   !> Evaluates rows at chosen times.
   pure subroutine evaluate(rows, t, chosen)
      type(attitude_rows_t), intent(in) :: rows
      !> Times, s, ascending.
      real(wp), intent(in) :: t(:)
      type(attitude_rows_t), intent(out) :: chosen
      integer :: i, place
      chosen%labels = rows%labels
      chosen%rotates = rows%rotates
      chosen%on_orbit = rows%on_orbit
      chosen%t = t
      allocate (chosen%q(4, size(t)), chosen%omega(3, size(t)))
      place = 1
      do i = 1, size(t)
         call move_on(rows, t(i), place)
         call attitude_at(rows, t(i), place, chosen%q(:, i), chosen%omega(:, i))
      end do
   end subroutine evaluate

end module nutate_resampling
