!> The answer of a work-precision study: what some accuracies cost, in sentences.
module nutate_cost_answer
   use nutate_console, only: page_t
   use nutate_cost_names, only: method_label
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp
   use nutate_methods, only: family_of, methods
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

   !> A sentence for every accuracy.
   subroutine add_answer(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      integer :: i
      if (.not. study%reference%known()) return
      call page%line('')
      do i = 1, size(tolerances)
         call add_wrapped(page, sentence(study, tolerances(i)))
      end do
   end subroutine add_answer

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
         if (methods(m)%order < 1 .or. any(family_of(methods(:m - 1)) == family_of(methods(m)))) cycle
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
