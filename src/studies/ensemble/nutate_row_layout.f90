!> Layout of a member's row: its fields, all of 8 bytes.
module nutate_row_layout
   use nutate_columns, only: columns_t
   use nutate_kinds, only: wp, long
   use nutate_scene, only: scene_t
   use nutate_scene_events, only: plain_name
   use nutate_spelling, only: split_list
   use nutate_status, only: status_t
   use nutate_propagated_columns, only: lyapunov_names
   implicit none
   private

   public :: row_layout_t, make_layout, bits_of, real_of

   !> Length of a field name.
   integer, parameter, public :: field_length = 96

   !> Fields of a result row, in order: member, status, the varied values, t, the columns of the scene, the largest
   !> energy residual and momentum error, count and first time of each event, indicators of chaos.
   type :: row_layout_t
      character(len=field_length), allocatable :: names(:)
      !> True for a 64-bit integer, false for a real.
      logical, allocatable :: is_whole(:)
      !> Index of the last varied value, of the last column, of the last error, of the last field of events.
      integer :: values = 0, columns = 0, errors = 0, events = 0
   contains
      !> Returns the number of fields.
      procedure :: width
   end type row_layout_t

contains

   !> Returns the number of fields.
   pure integer function width(self)
      class(row_layout_t), intent(in) :: self
      width = size(self%names)
   end function width

   !> Makes the layout of the result rows of a scene with an ensemble. Errors: `NUTATE_BAD_ARGUMENT` for an unknown set
   !> of columns.
   subroutine make_layout(scene, layout, status)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(out) :: layout
      type(status_t), intent(out) :: status
      type(columns_t) :: columns
      character(len=:), allocatable :: name
      integer :: i
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
   end subroutine make_layout

   !> Returns a number as a field.
   elemental integer(long) function bits_of(x)
      real(wp), intent(in) :: x
      bits_of = transfer(x, bits_of)
   end function bits_of

   !> Returns a field as a number.
   elemental real(wp) function real_of(bits)
      integer(long), intent(in) :: bits
      real_of = transfer(bits, real_of)
   end function real_of

end module nutate_row_layout
