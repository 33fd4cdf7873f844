!> Checks of bodies whose inertia varies with time.
module nutate_varying_inertia
   use nutate_body, only: body_t, whole_body
   use nutate_kinds, only: wp
   use nutate_small_products, only: is_positive
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   use nutate_system, only: inertia_at, system_t
   implicit none
   private

   public :: check_change, check_inertia_at, inertia_deviation

   !> Subdivisions of the time between two breaks, after which tensors that are not certified are rejected.
   integer, parameter :: most_halvings = 24
   !> Excess of the triangle rule, relative to half the trace, up to which a tensor is valid.
   real(wp), parameter :: triangle_tolerance = 1e-12_wp
   !> Types of faults.
   integer, parameter :: NO_FAULT = 0, NOT_POSITIVE = 1, NO_TRIANGLE = 2

contains

   !> Checks the inertia at a time. Errors: `NUTATE_BAD_BODY` if it is not positive definite.
   pure subroutine check_inertia_at(system, t, status)
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: t
      type(status_t), intent(inout) :: status
      if (.not. is_positive(inertia_at(system, t))) &
         status = fail(NUTATE_BAD_BODY, 'the inertia is not positive definite at all times of the step')
   end subroutine check_inertia_at

   !> Checks the body between two times: they lie in its tables, and the inertia is that of a rigid body. Errors:
   !> `NUTATE_BAD_ARGUMENT`, `NUTATE_BAD_BODY`.
   pure subroutine check_change(system, start, end_time, status)
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: start, end_time
      type(status_t), intent(inout) :: status
      real(wp) :: first, last
      integer :: i
      do i = 1, system%effects%n_torques
         associate (change => system%effects%torques(i)%item)
            if (.not. (change%changes_inertia .or. change%moves_center) .or. any(change%own_ends())) cycle
            call change%window(first, last)
            if (min(start, end_time) >= first .and. max(start, end_time) <= last) cycle
            status = fail(NUTATE_BAD_ARGUMENT, trim(merge('the start', 'end_time ', start < first .or. start > last)) &
                          //' is outside of the table of the '// &
                          trim(merge('centre of mass', 'inertia       ', change%moves_center))//' (expected '// &
                          time_text(first)//' to '//time_text(last)//' s)', 'end_time')
            return
         end associate
      end do
      call check_inertia(system, start, end_time, status)
   end subroutine check_change

   !> Returns the text of a time, s, to six decimals, without zeros at its end.
   pure function time_text(t) result(text)
      real(wp), intent(in) :: t
      character(len=:), allocatable :: text
      character(len=16) :: word
      write (word, '(f16.6)') t
      if (abs(t) >= 1e6_wp .or. (abs(t) < 1e-3_wp .and. abs(t) > 0.0_wp)) write (word, '(es14.6)') t
      text = trim(adjustl(word))
      if (index(text, 'E') > 0) return
      text = text(:verify(text, '0', back=.true.))
      if (text(len(text):) == '.') text = text(:len(text) - 1)
   end function time_text

   !> Checks the inertia between two times: between two breaks it is a polynomial, whose corners in Bernstein's basis
   !> prove that it is positive definite and, unless the body admits all moments, obeys the triangle rule, after
   !> subdivision if need be. Errors: `NUTATE_BAD_BODY` with a time at which it does not.
   pure subroutine check_inertia(system, start, end_time, status)
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: start, end_time
      type(status_t), intent(inout) :: status
      type(body_t) :: whole
      real(wp) :: t, next, sense, corners(3, 3, 0:3)
      integer :: fault
      character(len=16) :: word
      character(len=:), allocatable :: words
      if (.not. system%effects%varies) return
      whole = whole_body(system%body)
      sense = sign(1.0_wp, end_time - start)
      t = start
      fault = NO_FAULT
      do
         next = sense*min(sense*system%effects%next_break(t, sense), sense*end_time)
         corners = corners_of(system, t, next)
         call find_fault(system%body%inertia, whole%inertia, .not. system%body%admits_all, corners, most_halvings, t, &
                         next, fault)
         if (fault /= NO_FAULT .or. .not. sense*next < sense*end_time) exit
         t = next
      end do
      if (fault == NO_FAULT) return
      write (word, '(f14.6)') t
      if (abs(t) >= 1e6_wp .or. abs(t) < 1e-3_wp) write (word, '(es12.5)') t
      words = ' is not positive definite'
      if (fault == NO_TRIANGLE) words = ' is that of no rigid body: one moment exceeds the sum of the other two,'
      status = fail(NUTATE_BAD_BODY, 'the inertia'//words//' at t = '//trim(adjustl(word))//' s', 'tensor')
   end subroutine check_inertia

   !> Returns the largest distance of the inertia in a time from a tensor, in the norm of Frobenius, or a number above
   !> it; kg m².
   pure real(wp) function inertia_deviation(system, start, span, tensor) result(deviation)
      type(system_t), intent(in) :: system
      !> Start of the time, and its length, which may be negative, s.
      real(wp), intent(in) :: start, span
      !> kg m²; shape (3,3).
      real(wp), intent(in) :: tensor(3, 3)
      real(wp) :: t, next, sense, corners(3, 3, 0:3)
      integer :: i
      sense = sign(1.0_wp, span)
      t = start
      deviation = 0.0_wp
      do
         next = sense*min(sense*system%effects%next_break(t, sense), sense*(start + span))
         corners = corners_of(system, t, next)
         deviation = maxval([deviation, (norm2(system%body%inertia + corners(:, :, i) - tensor), i=0, 3)])
         if (.not. sense*next < sense*(start + span)) return
         t = next
      end do
   end function inertia_deviation

   !> Returns the corners in Bernstein's basis of the change of the inertia between two times without a break, kg m².
   pure function corners_of(system, t, next) result(corners)
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: t, next
      real(wp) :: corners(3, 3, 0:3)
      real(wp) :: time
      integer :: i
      do i = 0, 3
         time = t + (i/3.0_wp)*(next - t)
         corners(:, :, i) = system%effects%inertia_term(0, time, time, 1.0_wp)
      end do
      corners = in_bernstein(corners)
   end function corners_of

   !> Returns the corners in Bernstein's basis of a polynomial of degree 3 from its values at the times 0, 1/3, 2/3, 1.
   pure function in_bernstein(values) result(corners)
      real(wp), intent(in) :: values(3, 3, 0:3)
      real(wp) :: corners(3, 3, 0:3)
      corners(:, :, 0) = values(:, :, 0)
      corners(:, :, 1) = (-5*values(:, :, 0) + 18*values(:, :, 1) - 9*values(:, :, 2) + 2*values(:, :, 3))/6
      corners(:, :, 2) = (2*values(:, :, 0) - 9*values(:, :, 1) + 18*values(:, :, 2) - 5*values(:, :, 3))/6
      corners(:, :, 3) = values(:, :, 3)
   end function in_bernstein

   !> Finds the first fault of the inertia between two times.
   pure recursive subroutine find_fault(inertia, whole, check_triangle, corners, halvings, t, next, fault)
      !> J at t = 0, without and with the inertia of wheels about their axes, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3), whole(3, 3)
      logical, intent(in) :: check_triangle
      !> Corners of the change of J in Bernstein's basis, kg m².
      real(wp), intent(in) :: corners(3, 3, 0:3)
      !> Number of times that the interval may still be halved.
      integer, intent(in) :: halvings
      !> Time at which the interval begins, s; time of the fault on exit, if there is one.
      real(wp), intent(inout) :: t
      !> Time at which the interval ends, s.
      real(wp), intent(in) :: next
      integer, intent(out) :: fault
      real(wp) :: middle, left(3, 3, 0:3), right(3, 3, 0:3)
      integer :: faults(0:3), i
      do i = 0, 3
         faults(i) = fault_of(inertia + corners(:, :, i), whole + corners(:, :, i), check_triangle)
      end do
      fault = faults(0)
      if (fault /= NO_FAULT .or. all(faults == NO_FAULT)) return
      if (halvings == 0) then
         t = next
         fault = maxval(faults)
         return
      end if
      middle = t + 0.5_wp*(next - t)
      call halve(corners, left, right)
      call find_fault(inertia, whole, check_triangle, left, halvings - 1, t, middle, fault)
      if (fault /= NO_FAULT) return
      t = middle
      call find_fault(inertia, whole, check_triangle, right, halvings - 1, t, next, fault)
   end subroutine find_fault

   !> Computes the corners of both halves of a polynomial, by the scheme of de Casteljau.
   pure subroutine halve(corners, left, right)
      real(wp), intent(in) :: corners(3, 3, 0:3)
      real(wp), intent(out) :: left(3, 3, 0:3), right(3, 3, 0:3)
      integer :: i, k
      right = corners
      do k = 0, 3
         left(:, :, k) = right(:, :, 0)
         do i = 0, 2 - k
            right(:, :, i) = 0.5_wp*(right(:, :, i) + right(:, :, i + 1))
         end do
      end do
   end subroutine halve

   !> Returns the fault of an inertia.
   pure integer function fault_of(inertia, whole, check_triangle) result(fault)
      !> Without and with the inertia of wheels about their axes, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3), whole(3, 3)
      logical, intent(in) :: check_triangle
      real(wp) :: rest(3, 3), half
      integer :: i
      fault = NO_FAULT
      if (.not. is_positive(inertia)) then
         fault = NOT_POSITIVE
      else if (check_triangle) then
         half = 0.5_wp*(whole(1, 1) + whole(2, 2) + whole(3, 3))
         ! The tensor of the masses' second moments, ½ tr(J) - J, is positive definite.
         rest = -whole
         do i = 1, 3
            rest(i, i) = rest(i, i) + (1 + triangle_tolerance)*half
         end do
         if (.not. is_positive(rest)) fault = NO_TRIANGLE
      end if
   end function fault_of

end module nutate_varying_inertia
