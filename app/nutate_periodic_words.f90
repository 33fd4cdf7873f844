!> Periodic motion on which a scene starts, in the words of `check` and of the summary of a run.
module nutate_periodic_words
   use nutate_console, only: page_t, plural, vector_text
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp, long
   use nutate_periodic_start, only: on_circle, periodic_start_t
   implicit none
   private

   public :: add_periodic

contains

   !> Adds the result of Newton's method: the free librations by the multipliers, stability, condition, families.
   subroutine add_periodic(page, start)
      type(page_t), intent(inout) :: page
      !> Periodic initial state; nothing is added if it has no revolutions.
      type(periodic_start_t), intent(in) :: start
      if (start%revolutions == 0) return
      call page%item('periodic motion', 'closes to '//rounded_text(start%defect, 2)//' rad and mean motions, after '// &
                     plural(int(start%revolutions, long), 'revolution'))
      associate (frequencies => start%free_frequencies())
         if (size(frequencies) > 0) call page%item('  free librations', 'k ± f mean motions, k whole, f = '// &
                                                  vector_text(frequencies))
      end associate
      call page%item('  multipliers', multipliers_text(start))
      call page%item('  condition', rounded_text(start%condition, 2)//' of the map minus 1')
      if (start%n_families > 0) call page%item('  family', 'one of many periodic motions: the map minus 1 is '// &
         'singular in '//plural(int(start%n_families, long), 'direction')//', which the smallest correction left alone')
   end subroutine add_periodic

   !> Returns in words the stability that the multipliers imply.
   function multipliers_text(start) result(text)
      type(periodic_start_t), intent(in) :: start
      character(len=:), allocatable :: text
      if (start%growth() > 1 + on_circle) then
         text = 'unstable: deviations grow by '//rounded_text(start%growth())//' in a revolution'
      else
         text = 'all of modulus 1: stable to first order'
      end if
   end function multipliers_text

end module nutate_periodic_words
