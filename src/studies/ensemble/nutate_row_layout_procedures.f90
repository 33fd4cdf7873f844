!> Bodies of the procedures whose interfaces are in `nutate_row_layout`.
submodule(nutate_row_layout) nutate_row_layout_procedures
   use nutate_columns, only: columns_t
   use nutate_scene_events, only: plain_name
   use nutate_spelling, only: split_list
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_propagated_columns, only: lyapunov_names
   implicit none

contains

   module procedure width
      width = size(self%names)
   end procedure width

   module procedure make_layout
      type(columns_t) :: columns
      character(len=:), allocatable :: name
      integer :: i
      if (.not. allocated(scene%ensemble%targets)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the scene has no ensemble (expected one that was read, with &ensemble)', &
                       'scene')
         return
      end if
      call columns%choose(scene%output%columns, status, scene%output%degrees, scene%system%effects)
      if (.not. status%ok()) return
      layout%names = [character(len=field_length) :: 'member', 'status', scene%ensemble%targets%name]
      layout%values = size(layout%names)
      layout%names = [character(len=field_length) :: layout%names, split_list(columns%header())]
      layout%columns = size(layout%names)
      layout%names = [character(len=field_length) :: layout%names, 'largest_energy_residual', 'largest_momentum_error']
      layout%errors = size(layout%names)
      do i = 1, scene%events%count()
         name = trim(plain_name(scene%events%slots(i)%item%name))
         layout%names = [character(len=field_length) :: layout%names, name//'_count', name//'_first']
      end do
      layout%events = size(layout%names)
      if (scene%chaos%exponents > 0) &
         layout%names = [character(len=field_length) :: layout%names, lyapunov_names(scene%chaos%exponents), &
                         'megno', 'fli']
      layout%is_whole = [(i <= 2 .or. (i > layout%errors .and. i <= layout%events .and. &
                                       mod(i - layout%errors, 2) == 1), i=1, size(layout%names))]
   end procedure make_layout

   module procedure bits_of
      bits_of = transfer(x, bits_of)
   end procedure bits_of

   module procedure real_of
      real_of = transfer(bits, real_of)
   end procedure real_of

end submodule nutate_row_layout_procedures
