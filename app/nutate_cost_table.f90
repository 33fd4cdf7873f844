!> The runs of a work-precision study as a table for people.
module nutate_cost_table
   use nutate_console, only: count_text, page_t
   use nutate_cost_names, only: hopeless, method_label
   use nutate_decimal, only: rounded_text
   use nutate_invariants, only: conserved_momentum, NO_COMPONENT
   use nutate_kinds, only: wp, long
   use nutate_methods, only: methods
   use nutate_reference, only: reference_t, AGREED, EXACT_FREE_BODY, EXACT_TOP
   use nutate_work_point, only: work_point_t
   use nutate_work_precision, only: work_precision_t, LAST_LEVEL, OUT_OF_TIME, REFUSED, ROUND_OFF
   implicit none
   private

   public :: add_reference, add_table

   !> Widths of the columns.
   integer, parameter :: widths(10) = [12, 10, 6, 10, 9, 8, 11, 10, 10, 10]
   !> Heads of the columns, in two lines.
   character(len=9), parameter :: heads(10, 2) = reshape( &
      [character(len=9) :: 'time_step', 'steps', 'cut', 'time', 'step', 'Newton', 'attitude', 'momentum', 'energy', &
       'norm', '/ s', '', '', '/ ms', '/ ns', '', '/ rad', '', '', ''], [10, 2])

contains

   !> What errors are taken from.
   subroutine add_reference(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      character(len=:), allocatable :: known
      associate (reference => study%reference, end_time => study%problem%end_time)
         known = ' to '//rounded_text(reference%uncertainty, 2)//' rad'
         select case (reference%kind)
         case (EXACT_FREE_BODY)
            call page%item('reference', 'the exact motion of a free body, good'//known)
         case (EXACT_TOP)
            call page%item('reference', "the exact motion of Lagrange's top, good"//known)
         case (AGREED)
            call page%item('reference', method_label(reference%pair(1))//' and '//method_label(reference%pair(2)))
            call page%item('', 'agree'//known//': '//digits_text(reference%uncertainty))
         case default
            call page%item('reference', 'none: '//method_label(reference%pair(1))//' and '// &
                           method_label(reference%pair(2)))
            if (reference%uncertainty < huge(1.0_wp)) then
               known = 'agree no better than'//known//' at t = '//rounded_text(end_time)//' s'
            else
               known = 'do not get to t = '//rounded_text(end_time)//' s in their time'
            end if
            call page%item('', known//'; attitude errors are not shown')
         end select
      end associate
   end subroutine add_reference

   !> Digits that an uncertainty leaves.
   pure function digits_text(uncertainty) result(text)
      !> rad.
      real(wp), intent(in) :: uncertainty
      character(len=:), allocatable :: text
      text = count_text(int(-log10(uncertainty), long))//' digits'
   end function digits_text

   !> All runs, method by method.
   subroutine add_table(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      type(work_point_t), allocatable :: points(:)
      integer :: m, components
      real(wp) :: axis(3)

      call conserved_momentum(study%problem%system%effects, components, axis)
      call page%line('')
      call page%line(row(heads(:, 1)))
      call page%line(row(heads(:, 2)))
      do m = 1, size(methods)
         if (methods(m)%order < 1) cycle
         points = study%points_of(m)
         call page%line(method_label(m)//ending_text(study, m, size(points)))
         call add_points(page, points, study%reference, components /= NO_COMPONENT)
      end do
   end subroutine add_table

   !> Why a method's runs end where they do.
   function ending_text(study, method, runs) result(text)
      type(work_precision_t), intent(in) :: study
      !> Row of `methods`, and the number of its runs.
      integer, intent(in) :: method, runs
      character(len=:), allocatable :: text
      select case (study%ending(method))
      case (ROUND_OFF)
         text = ', until shorter steps gain nothing'
      case (OUT_OF_TIME)
         text = ', as far as the time allows'
      case (LAST_LEVEL)
         text = ', as far as the ladder goes'
      case (REFUSED)
         text = ': not on this scene ('//trim(study%refusal(method)%message)//')'
      case default
         text = ''
      end select
      if (runs == 0 .and. study%ending(method) /= REFUSED) text = ': no run ended in time, or with steps this long'
   end function ending_text

   !> The runs of one method; of those that say nothing only the last.
   subroutine add_points(page, points, reference, has_momentum)
      type(page_t), intent(inout) :: page
      type(work_point_t), intent(in) :: points(:)
      type(reference_t), intent(in) :: reference
      !> A component of the momentum is conserved.
      logical, intent(in) :: has_momentum
      integer :: i
      do i = 1, size(points)
         if (reference%known() .and. i < size(points)) then
            if (points(i)%attitude_error > hopeless .and. points(i + 1)%attitude_error > hopeless) cycle
         end if
         call page%line(row(cells(points(i), reference, has_momentum)))
      end do
   end subroutine add_points

   !> The cells of a run; shape (10).
   pure function cells(point, reference, has_momentum) result(texts)
      type(work_point_t), intent(in) :: point
      type(reference_t), intent(in) :: reference
      logical, intent(in) :: has_momentum
      character(len=12) :: texts(10)
      texts(1) = rounded_text(point%time_step, 5)
      texts(2) = count_text(point%steps)
      texts(3) = ''
      if (point%cut_steps > 0) texts(3) = count_text(point%cut_steps)
      texts(4) = rounded_text(1e3_wp*point%seconds, 3)
      texts(5) = rounded_text(point%nanoseconds(), 3)
      texts(6) = rounded_text(point%iterations, 3)
      texts(7) = '-'
      if (reference%known()) then
         texts(7) = rounded_text(point%attitude_error, 2)
         if (point%attitude_error < reference%uncertainty) texts(7) = '<'//rounded_text(reference%uncertainty, 2)
      end if
      texts(8) = '-'
      if (has_momentum) texts(8) = rounded_text(point%momentum_error, 2)
      texts(9) = rounded_text(point%energy_error, 2)
      texts(10) = rounded_text(point%norm_error, 2)
   end function cells

   !> A line of the table.
   pure function row(texts) result(line)
      !> Shape (10).
      character(len=*), intent(in) :: texts(:)
      character(len=:), allocatable :: line
      integer :: i
      line = ''
      do i = 1, size(texts)
         line = line//repeat(' ', max(widths(i) - len_trim(texts(i)), 1))//trim(texts(i))
      end do
      line = trim(line)
   end function row

end module nutate_cost_table
