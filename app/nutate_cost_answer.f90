!> The answer of a work-precision study: what some accuracies cost, in a table with what to write into the scene, and in
!> sentences below it.
module nutate_cost_answer
   use nutate_console, only: count_text, page_t
   use nutate_cost_names, only: method_label
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp, long
   use nutate_methods, only: default_settings, family_of, methods
   use nutate_stepper, only: integrator_settings_t
   use nutate_work_point, only: point_at_error, work_point_t
   use nutate_work_precision, only: work_precision_t
   implicit none
   private

   public :: add_answer

   !> Attitude errors that are asked about, rad.
   real(wp), parameter :: tolerances(4) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp]
   !> Longest line.
   integer, parameter :: line_width = 98

contains

   !> The table, and a sentence for every accuracy.
   subroutine add_answer(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      integer :: i
      if (.not. study%reference%known()) return
      call page%line('')
      call page%line(cells('accuracy', 'time', 'energy')//'&integrator, cheapest first')
      call page%line(cells('/ rad', '/ ms', ''))
      do i = 1, size(tolerances)
         call add_ranking(page, study, tolerances(i))
      end do
      call page%line('')
      do i = 1, size(tolerances)
         call add_wrapped(page, sentence(study, tolerances(i)))
      end do
   end subroutine add_answer

   !> Three cells of a line of the table.
   pure function cells(accuracy, time, energy) result(text)
      character(len=*), intent(in) :: accuracy, time, energy
      character(len=24) :: text
      text(1:8) = adjustr(accuracy//repeat(' ', 8 - len(accuracy)))
      text(9:16) = adjustr(time//repeat(' ', 8 - len(time)))
      text(17:22) = adjustr(energy//repeat(' ', 6 - len(energy)))
      text(23:24) = ''
   end function cells

   !> What one accuracy costs with each method, cheapest first.
   subroutine add_ranking(page, study, tolerance)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      !> rad.
      real(wp), intent(in) :: tolerance
      type(work_point_t) :: point
      integer :: m, i
      real(wp) :: seconds(size(methods))
      character(len=8) :: accuracy
      accuracy = rounded_text(tolerance, 2)
      seconds = -1.0_wp
      if (tolerance >= study%reference%uncertainty) then
         do m = 1, size(methods)
            if (.not. is_first_of_family(m)) cycle
            point = cheapest(study, family_of(methods(m)), tolerance)
            if (point%exists()) seconds(m) = point%seconds
         end do
      end if
      if (all(seconds < 0.0_wp)) call page%line(cells(trim(accuracy), '-', '')//'reached by no run here')
      do i = 1, count(seconds >= 0.0_wp)
         m = minloc(seconds, mask=seconds >= 0.0_wp, dim=1)
         point = cheapest(study, family_of(methods(m)), tolerance)
         call page%line(cells(trim(accuracy), rounded_text(1e3_wp*point%seconds, 2), &
                              rounded_text(point%energy_error, 1))//settings_text(point))
         seconds(m) = -1.0_wp
         accuracy = ''
      end do
   end subroutine add_ranking

   !> True for the first row of a method with an order.
   pure logical function is_first_of_family(m)
      !> Row of `methods`.
      integer, intent(in) :: m
      is_first_of_family = methods(m)%order >= 1 .and. .not. any(family_of(methods(:m - 1)) == family_of(methods(m)))
   end function is_first_of_family

   !> What to write into `&integrator` for the steps of a point.
   pure function settings_text(point) result(text)
      type(work_point_t), intent(in) :: point
      character(len=:), allocatable :: text
      type(integrator_settings_t) :: usual
      associate (method => methods(point%method))
         usual = default_settings(trim(method%name))
         text = 'method='''//trim(method%name)//''''
         if (usual%order /= method%order) text = text//', order='//count_text(int(method%order, long))
         if (usual%linear_solver /= method%linear_solver) &
            text = text//', linear_solver='''//trim(method%linear_solver)//''''
         if (usual%conserve .neqv. method%projected) &
            text = text//', conserve='//trim(merge('.true. ', '.false.', method%projected))
      end associate
      if (point%tolerance > 0.0_wp) then
         text = text//', local_tolerance='//rounded_text(point%tolerance, 2)
      else
         text = text//', time_step='//rounded_text(point%time_step, 2)
      end if
   end function settings_text

   !> What one accuracy costs.
   function sentence(study, tolerance) result(text)
      type(work_precision_t), intent(in) :: study
      !> rad.
      real(wp), intent(in) :: tolerance
      character(len=:), allocatable :: text
      type(work_point_t) :: point
      integer :: m
      logical :: first

      text = rounded_text(tolerance, 2)//' rad at t = '//rounded_text(study%problem%end_time)//' s'
      if (tolerance < study%reference%uncertainty) then
         text = text//' cannot be told from the reference, which is known to '// &
                rounded_text(study%reference%uncertainty, 2)//' rad.'
         return
      end if
      first = .true.
      do m = 1, size(methods)
         if (.not. is_first_of_family(m)) cycle
         point = cheapest(study, family_of(methods(m)), tolerance)
         if (.not. first) text = text//';'
         if (point%exists()) then
            text = text//point_text(point, first)
         else if (first) then
            text = text//' is reached by no '//trim(family_of(methods(m)))//' run here'
         else
            text = text//' '//trim(family_of(methods(m)))//' does not get there'
         end if
         first = .false.
      end do
      text = text//'.'
   end function sentence

   !> The fastest among the rows of a method.
   function cheapest(study, family, tolerance) result(best)
      type(work_precision_t), intent(in) :: study
      !> `family_of` its rows.
      character(len=*), intent(in) :: family
      !> rad.
      real(wp), intent(in) :: tolerance
      type(work_point_t) :: best, point
      integer :: m
      do m = 1, size(methods)
         if (family_of(methods(m)) /= family .or. methods(m)%order < 1) cycle
         point = point_at_error(study%points_of(m), methods(m)%order, tolerance)
         if (.not. point%exists()) cycle
         if (.not. best%exists() .or. point%seconds < best%seconds) best = point
      end do
   end function cheapest

   !> Time and setting of a point in words.
   function point_text(point, first) result(text)
      type(work_point_t), intent(in) :: point
      !> It is the first of the sentence.
      logical, intent(in) :: first
      character(len=:), allocatable :: text, cost
      cost = rounded_text(1e3_wp*point%seconds, 2)//' ms'
      if (first) then
         text = ' costs '//cost//' with '//method_label(point%method)//','
      else
         text = ' '//method_label(point%method)//' needs '//cost//' with'
      end if
      if (point%tolerance > 0.0_wp) then
         text = text//' local_tolerance = '//rounded_text(point%tolerance, 2)
      else
         text = text//' time_step = '//rounded_text(point%time_step, 2)
      end if
      text = text//', energy kept to '//rounded_text(point%energy_error, 1)
   end function point_text

   !> Adds a sentence in lines that are not too long, the later ones indented.
   subroutine add_wrapped(page, text)
      type(page_t), intent(inout) :: page
      character(len=*), intent(in) :: text
      integer :: first, last, indent
      first = 1
      indent = 0
      do while (len(text) - first + 1 > line_width - indent)
         last = first + index(text(first:first + line_width - indent), ' ', back=.true.) - 2
         call page%line(repeat(' ', indent)//text(first:last))
         first = last + 2
         indent = 3
      end do
      call page%line(repeat(' ', indent)//text(first:))
   end subroutine add_wrapped

end module nutate_cost_answer
