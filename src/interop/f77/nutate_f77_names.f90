!> Names of the arguments of the FORTRAN 77 routines, for messages. `tools/lint/f77_arguments.py` compares them with the
!> routines.
module nutate_f77_names
   implicit none
   private

   public :: argument_name

   !> A routine and its arguments, comma separated.
   type :: routine_t
      character(len=6) :: name
      character(len=72) :: arguments
   end type routine_t

   type(routine_t), parameter :: routines(*) = [ &
      routine_t('NUINIT', 'AJ,AJ0,H,CM,G,D,DN,IFORM,IORDER,ICALL,WORK,LWORK,INFO'), &
      routine_t('NUFRAM', 'W,WORK,LWORK,INFO'), &
      routine_t('NUSTEP', 'N,DT,T,Q,P,POT,TOR,IUSER,RUSER,WORK,LWORK,INFO'), &
      routine_t('NURUN ', 'N,DT,T,Q,P,POT,TOR,IUSER,RUSER,K,ROWS,MROWS,NROWS,WORK,LWORK,INFO'), &
      routine_t('NUSTAT', 'ISTAT,W,WORK,LWORK,INFO'), &
      routine_t('NUNCER', 'NUM,WORK,LWORK,INFO'), &
      routine_t('NUBPOT', 'BGRAD,BHESS,BTHIRD,WORK,LWORK,INFO'), &
      routine_t('NUBTOR', 'BTOR,BTURN,BSEC,BRATE,WORK,LWORK,INFO'), &
      routine_t('NUSETP', 'Q,OMEGA,P,WORK,LWORK,INFO'), &
      routine_t('NUOMEG', 'Q,P,OMEGA,WORK,LWORK,INFO'), &
      routine_t('NUINV ', 'Q,P,POT,IUSER,RUSER,E,AL,C,WORK,LWORK,INFO'), &
      routine_t('NUQ2M ', 'Q,R,INFO'), &
      routine_t('NUM2Q ', 'R,Q,INFO'), &
      routine_t('NUQ2E ', 'Q,PHI,THETA,PSI,INFO'), &
      routine_t('NUE2Q ', 'PHI,THETA,PSI,Q,INFO'), &
      routine_t('NUFREE', 'AJ,Q0,OMEGA0,N,T,Q,OMEGA,INFO'), &
      routine_t('NUBSET', 'NC,AJ,IFRAME,WORK,LWORK,INFO'), &
      routine_t('NUBTHR', 'NT,WORK,LWORK,INFO'), &
      routine_t('NUBODY', 'N,DT,IC,Q,AL,TOR,MBAD,IBAD,NBAD,WORK,LWORK,INFO'), &
      routine_t('NUBKIK', 'N,DT,IC,Q,AL,TOR,MBAD,IBAD,NBAD,WORK,LWORK,INFO'), &
      routine_t('NUBDRF', 'N,DT,IC,Q,AL,MBAD,IBAD,NBAD,WORK,LWORK,INFO')]

contains

   !> Returns the name of an argument; empty for a routine or an argument that does not exist.
   pure function argument_name(routine, number) result(name)
      !> Name of the routine, in upper or lower case.
      character(len=*), intent(in) :: routine
      !> Number of the argument, from 1.
      integer, intent(in) :: number
      character(len=:), allocatable :: name
      character(len=72) :: rest
      integer :: i, comma
      name = ''
      i = findloc(routines%name, upper(routine), dim=1)
      if (i == 0) return
      rest = routines(i)%arguments
      do i = 1, number
         comma = index(rest, ',')
         if (comma == 0) comma = len_trim(rest) + 1
         name = rest(1:comma - 1)
         rest = rest(comma + 1:)
      end do
   end function argument_name

   !> Returns a string in upper case.
   pure function upper(text)
      character(len=*), intent(in) :: text
      character(len=len(text)) :: upper
      integer :: i, place
      character(len=*), parameter :: small = 'abcdefghijklmnopqrstuvwxyz', great = 'ABCDEFGHIJKLMNOPQRSTUVWXYZ'
      upper = text
      do i = 1, len(text)
         place = index(small, text(i:i))
         if (place > 0) upper(i:i) = great(place:place)
      end do
   end function upper

end module nutate_f77_names
