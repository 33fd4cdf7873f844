! Messages for FORTRAN 77: external subroutines, see nutate_f77_steps.f90 for what the routines have in common.

!> NUTEXT returns the meaning of an INFO.
subroutine nutext(info, text)
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH, NUTATE_OK, NUTATE_SINGULAR, NUTATE_STEP_LIMIT
   implicit none
   !> (input) INFO of any other routine.
   integer, intent(in) :: info
   !> (output) One line, padded with blanks; 72 characters hold all of it.
   character(len=*), intent(inout) :: text
   character(len=12) :: number
   select case (info)
   case (:-1)
      write (number, '(i0)') info
      text = 'argument number '//trim(number(2:))//' is wrong'
   case (NUTATE_OK)
      text = 'success'
   case (NUTATE_NOT_CONVERGED)
      text = 'a step did not converge, even subdivided: is TOR or POT discontinuous?'
   case (NUTATE_OFF_BRANCH)
      text = 'a step is too long to follow the motion, even subdivided'
   case (NUTATE_SINGULAR)
      text = 'the linear system of a step is singular'
   case (NUTATE_NOT_FINITE)
      text = 'a number is not finite or beyond 1D100: see POT, TOR; in NUBODY, IBAD'
   case (NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY)
      text = 'body and state do not fit the method'
   case (NUTATE_STEP_LIMIT)
      text = 'more steps are needed than were allowed'
   case default
      text = 'no INFO has this value'
   end select
end subroutine nutext

!> NUWHY returns the meaning of the INFO of a routine, with the name of the argument that is wrong.
subroutine nuwhy(name, info, text)
   use nutate_f77_names, only: argument_name
   implicit none
   !> (input) The routine, such as 'NUSTEP'.
   character(len=*), intent(in) :: name
   !> (input) The INFO that it gave.
   integer, intent(in) :: info
   !> (output) One line, padded with blanks; 72 characters hold all of it.
   character(len=*), intent(inout) :: text
   interface
      subroutine nutext(info, text)
         implicit none
         integer, intent(in) :: info
         character(len=*), intent(inout) :: text
      end subroutine nutext
   end interface
   character(len=:), allocatable :: argument
   character(len=12) :: number
   argument = ''
   ! No routine has 100 arguments. The limit also keeps -info from overflowing.
   if (info < 0 .and. info > -100) argument = argument_name(name, -info)
   if (argument == '') then
      call nutext(info, text)
   else
      write (number, '(i0)') -info
      text = 'argument number '//trim(number)//' of '//trim(name)//', '//argument//', is wrong'
   end if
end subroutine nuwhy
