!> Description of an ensemble, in words.
module nutate_ensemble_words
   use nutate_console, only: count_text, page_t, plural, vector_text
   use nutate_ensemble_plan, only: ensemble_plan_t, varied_key_t, CASES, GRID, NORMAL, ROTATION
   use nutate_kinds, only: wp, long
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: add_ensemble

contains

   !> Adds the number of members, the varied quantities, and the file of the results.
   subroutine add_ensemble(page, plan)
      type(page_t), intent(inout) :: page
      !> Plan of an active ensemble.
      type(ensemble_plan_t), intent(in) :: plan
      integer :: i
      call page%line('ensemble (nutate sweep)')
      call page%item('members', count_text(plan%members)//', seed '//count_text(plan%seed)// &
                     trim(merge(', latin sampling', repeat(' ', 16), plan%latin)))
      do i = 1, size(plan%variations)
         associate (variation => plan%variations(i))
            call page%item(merge('varied', '      ', i == 1), names_of(plan, variation)//': '//law_of(variation))
         end associate
      end do
      if (plan%keeps_rows) then
         call page%item('rows', printable_path(plan%file))
      else
         call page%item('mean and counts', printable_path(plan%file))
      end if
   end subroutine add_ensemble

   !> Returns the names of the quantities that are drawn together.
   pure function names_of(plan, variation) result(text)
      type(ensemble_plan_t), intent(in) :: plan
      type(varied_key_t), intent(in) :: variation
      character(len=:), allocatable :: text
      integer :: i
      text = trim(plan%targets(variation%first)%name)
      do i = variation%first + 1, min(variation%first + variation%n - 1, variation%first + 5)
         text = text//', '//trim(plan%targets(i)%name)
      end do
      if (variation%n > 6) text = text//', ...'
   end function names_of

   !> Returns the distribution of a variation in words.
   pure function law_of(variation) result(text)
      type(varied_key_t), intent(in) :: variation
      character(len=:), allocatable :: text
      real(wp) :: deviation(variation%n)
      integer :: i
      select case (variation%distribution)
      case (CASES)
         text = 'from the table, '//plural(size(variation%cases, 2, long), 'line')
      case (ROTATION)
         text = 'uniform over all rotations'
      case (NORMAL)
         do i = 1, variation%n
            deviation(i) = norm2(variation%factor(i, :))
         end do
         text = 'normal, '//vector_text(variation%low)//' +- '//vector_text(deviation)
      case (GRID)
         text = 'grid, '//vector_text(variation%low)//' to '//vector_text(variation%high)//' by '// &
                vector_text(real(variation%points, wp))
      case default
         text = 'uniform, '//vector_text(variation%low)//' to '//vector_text(variation%high)
      end select
   end function law_of

end module nutate_ensemble_words
