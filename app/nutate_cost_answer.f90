!> The answer of a cost study: what some accuracies cost, in sentences.
module nutate_cost_answer
   use nutate_console, only: page_t
   use nutate_cost_names, only: method_label
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp
   use nutate_step_ladder, only: step_ladder_t
   use nutate_methods, only: family_of, methods
   use nutate_accuracy_price, only: price_of, accuracy_price_t
   use nutate_reference, only: reference_t
   implicit none
   private

   public :: add_answer

   !> Attitude errors that are asked about, rad.
   real(wp), parameter :: tolerances(4) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp]
   !> Longest line.
   integer, parameter :: line_width = 98

contains

   !> A sentence for every accuracy.
   subroutine add_answer(page, reference, ladder, end_time)
      type(page_t), intent(inout) :: page
      type(reference_t), intent(in) :: reference
      type(step_ladder_t), intent(in) :: ladder
      !> s.
      real(wp), intent(in) :: end_time
      integer :: i
      if (.not. reference%known()) return
      call page%line('')
      do i = 1, size(tolerances)
         call add_wrapped(page, sentence(reference, ladder, tolerances(i), end_time))
      end do
   end subroutine add_answer

   !> What one accuracy costs.
   function sentence(reference, ladder, tolerance, end_time) result(text)
      type(reference_t), intent(in) :: reference
      type(step_ladder_t), intent(in) :: ladder
      !> rad.
      real(wp), intent(in) :: tolerance
      !> s.
      real(wp), intent(in) :: end_time
      character(len=:), allocatable :: text
      type(accuracy_price_t) :: price
      integer :: m
      logical :: first

      text = rounded_text(tolerance, 2)//' rad at t = '//rounded_text(end_time)//' s'
      if (tolerance < reference%uncertainty) then
         text = text//' cannot be told from the reference, which is known to '// &
                rounded_text(reference%uncertainty, 2)//' rad.'
         return
      end if
      first = .true.
      do m = 1, size(methods)
         if (methods(m)%order < 1 .or. any(family_of(methods(:m - 1)) == family_of(methods(m)))) cycle
         price = cheapest(ladder, family_of(methods(m)), tolerance)
         if (.not. first) text = text//';'
         if (price%reached) then
            text = text//price_text(price, first)
         else if (first) then
            text = text//' is reached by no '//trim(family_of(methods(m)))//' run here'
         else
            text = text//' '//trim(family_of(methods(m)))//' does not get there'
         end if
         first = .false.
      end do
      text = text//'.'
   end function sentence

   !> The least price among the rows of a method.
   function cheapest(ladder, family, tolerance) result(best)
      type(step_ladder_t), intent(in) :: ladder
      !> `family_of` its rows.
      character(len=*), intent(in) :: family
      !> rad.
      real(wp), intent(in) :: tolerance
      type(accuracy_price_t) :: best, price
      integer :: m
      do m = 1, size(methods)
         if (family_of(methods(m)) /= family .or. methods(m)%order < 1) cycle
         price = price_of(ladder%runs_of(m), methods(m)%order, tolerance)
         if (price%reached .and. price%seconds < best%seconds) best = price
      end do
   end function cheapest

   !> A price in words.
   function price_text(price, first) result(text)
      type(accuracy_price_t), intent(in) :: price
      !> It is the first of the sentence.
      logical, intent(in) :: first
      character(len=:), allocatable :: text, cost
      cost = rounded_text(1e3_wp*price%seconds, 2)//' ms'
      if (first) then
         text = ' costs '//cost//' with '//method_label(price%method)//','
      else
         text = ' '//method_label(price%method)//' needs '//cost//' with'
      end if
      if (price%tolerance > 0.0_wp) then
         text = text//' local_tolerance = '//rounded_text(price%tolerance, 2)
      else
         text = text//' time_step = '//rounded_text(price%time_step, 2)
      end if
      text = text//', energy kept to '//rounded_text(price%energy_error, 1)
   end function price_text

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
