!> The runs of a work-precision study as a table for people.
module nutate_cost_table
   use nutate_console, only: count_text, page_t
   use nutate_cost_names, only: hopeless, method_label
   use nutate_decimal, only: rounded_text
   use nutate_invariants, only: conserved_momentum, NO_COMPONENT
   use nutate_kinds, only: wp, long
   use nutate_methods, only: methods
   use nutate_reference, only: reference_t, AGREED, EXACT_FREE_BODY, EXACT_TOP
   use nutate_table, only: number_text, table_t
   use nutate_work_point, only: work_point_t
   use nutate_work_precision, only: work_precision_t, LAST_LEVEL, OUT_OF_BUDGET, REFUSED, ROUND_OFF
   implicit none
   private

   public :: add_reference, add_table

contains

   !> Adds the reference of the errors.
   subroutine add_reference(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      character(len=:), allocatable :: known
      associate (reference => study%reference, end_time => study%problem%end_time)
         known = ' to '//number_text(reference%uncertainty, 2)//' rad'
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
               known = 'agree only'//known//' at t = '//rounded_text(end_time)//' s'
            else
               known = 'do not reach t = '//rounded_text(end_time)//' s within the budget'
            end if
            call page%item('', known//'; attitude errors are not shown')
         end select
      end associate
   end subroutine add_reference

   !> Returns in words the number of digits that an uncertainty leaves.
   pure function digits_text(uncertainty) result(text)
      !> Uncertainty, rad.
      real(wp), intent(in) :: uncertainty
      character(len=:), allocatable :: text
      text = count_text(int(-log10(uncertainty), long))//' digits'
   end function digits_text

   !> Adds all runs, method by method.
   subroutine add_table(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      type(work_point_t), allocatable :: points(:)
      type(table_t) :: table
      integer :: m, components
      real(wp) :: axis(3)

      call conserved_momentum(study%problem%system%effects, components, axis)
      call table%add_column('time_step', '/ s', digits=5)
      call table%add_column('steps', digits=1)
      call table%add_column('subdivided', digits=1)
      call table%add_column('time', '/ ms', digits=3)
      call table%add_column('step', '/ ns', digits=3)
      call table%add_column('Newton', digits=3)
      call table%add_column('attitude', '/ rad', digits=2)
      call table%add_column('momentum', digits=2)
      call table%add_column('energy', digits=2)
      call table%add_column('norm', digits=2)
      do m = 1, size(methods)
         points = study%points_of(m)
         if (methods(m)%order < 1 .and. size(points) == 0) cycle
         call table%add_line(method_label(m)//ending_text(study, m, size(points)))
         call add_points(table, points, study%reference, components /= NO_COMPONENT)
      end do
      call page%line('')
      call page%line(table%text())
   end subroutine add_table

   !> Returns the reason, in words, why there are no further runs of a method.
   function ending_text(study, method, runs) result(text)
      type(work_precision_t), intent(in) :: study
      !> Row of `methods`, and the number of its runs.
      integer, intent(in) :: method, runs
      character(len=:), allocatable :: text
      if (methods(method)%order < 1) then
         text = ', the closed solution'
         return
      end if
      select case (study%ending(method))
      case (ROUND_OFF)
         text = ', until shorter steps gain nothing'
      case (OUT_OF_BUDGET)
         text = ', as far as the budget allows'
      case (LAST_LEVEL)
         text = ', as far as the ladder goes'
      case (REFUSED)
         text = ': not applicable to this scene ('//trim(study%refusal(method)%message)//')'
      case default
         text = ', until the study was stopped'
      end select
      if (runs > 0 .or. study%ending(method) == REFUSED) return
      text = ': no run finished within the budget'
      if (.not. study%refusal(method)%ok()) text = ': no run finished ('//trim(study%refusal(method)%message)//')'
   end function ending_text

   !> Adds the runs of one method; of the runs with hopelessly long steps, only the last.
   subroutine add_points(table, points, reference, has_momentum)
      type(table_t), intent(inout) :: table
      type(work_point_t), intent(in) :: points(:)
      type(reference_t), intent(in) :: reference
      !> True if a component of the momentum is conserved.
      logical, intent(in) :: has_momentum
      integer :: i
      do i = 1, size(points)
         if (reference%known() .and. i < size(points)) then
            if (points(i)%attitude_error > hopeless .and. points(i + 1)%attitude_error > hopeless) cycle
         end if
         call add_run(table, points(i), reference, has_momentum)
      end do
   end subroutine add_points

   !> Adds the row of a run.
   subroutine add_run(table, point, reference, has_momentum)
      type(table_t), intent(inout) :: table
      type(work_point_t), intent(in) :: point
      type(reference_t), intent(in) :: reference
      logical, intent(in) :: has_momentum
      call table%add_row()
      call table%put(point%time_step)
      call table%put(count_text(point%steps))
      if (point%subdivided_steps > 0) then
         call table%put(count_text(point%subdivided_steps))
      else
         call table%put('')
      end if
      call table%put(1e3_wp*point%seconds)
      call table%put(point%nanoseconds())
      call table%put(point%iterations)
      if (.not. reference%known()) then
         call table%put('-')
      else if (point%attitude_error < reference%uncertainty) then
         call table%put(reference%uncertainty, before='<')
      else
         call table%put(point%attitude_error)
      end if
      if (has_momentum) then
         call table%put(point%momentum_error)
      else
         call table%put('-')
      end if
      call table%put(point%energy_error)
      call table%put(point%norm_error)
   end subroutine add_run

end module nutate_cost_table
