!> What an event of a scene looks for, and what it does, in words.
module nutate_event_words
   use nutate_column_event, only: column_event_t, most_columns
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_event, only: CROSSING, event_t, MAXIMUM, MINIMUM, SWITCH_OFF, SWITCH_ON
   use nutate_kinds, only: wp
   implicit none
   private

   public :: event_text

contains

   !> `omega3 crosses 0, falling; ends the run`.
   function event_text(event) result(text)
      class(event_t), intent(in) :: event
      character(len=:), allocatable :: text
      text = ''
      select type (event)
      class is (column_event_t)
         text = columns_text(event)
      end select
      select case (event%kind)
      case (CROSSING)
         text = text//' crosses '//rounded_text(event%level)
         if (event%period > 0.0_wp) text = text//' modulo '//rounded_text(event%period)
         if (event%direction > 0) text = text//', growing'
         if (event%direction < 0) text = text//', falling'
      case (MAXIMUM)
         text = text//' has a maximum'
      case (MINIMUM)
         text = text//' has a minimum'
      case default
         text = text//' has an extremum'
      end select
      if (event%action == SWITCH_ON) text = text//"; switches '"//trim(event%effect)//"' on"
      if (event%action == SWITCH_OFF) text = text//"; switches '"//trim(event%effect)//"' off"
      if (event%action > max(SWITCH_ON, SWITCH_OFF)) text = text//"; switches '"//trim(event%effect)//"' over"
      if (event%count > 0) then
         text = text//'; ends the run at number '//count_text(event%count)
      else if (event%stop) then
         text = text//'; ends the run'
      end if
   end function event_text

   !> `psi + 2 omega3`.
   function columns_text(event) result(text)
      type(column_event_t), intent(in) :: event
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, most_columns
         if (event%columns(i) == '') exit
         if (i > 1) text = text//' + '
         if (abs(event%weights(i) - 1) > 0.0_wp) text = text//rounded_text(event%weights(i))//' '
         text = text//trim(event%columns(i))
      end do
   end function columns_text

end module nutate_event_words
