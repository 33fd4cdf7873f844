!> Layout of a member's row: its fields, all of 8 bytes.
module nutate_row_layout
   use nutate_kinds, only: wp, long
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
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

   interface

      !> Returns the number of fields.
      pure integer module function width(self)
         class(row_layout_t), intent(in) :: self
      end function width

      !> Makes the layout of the result rows of a scene with an ensemble. Errors: `NUTATE_BAD_ARGUMENT` for an unknown
      !> set of columns, and for a scene without an ensemble.
      module subroutine make_layout(scene, layout, status)
         type(scene_t), intent(in) :: scene
         type(row_layout_t), intent(out) :: layout
         type(status_t), intent(out) :: status
      end subroutine make_layout

      !> Returns a number as a field.
      elemental integer(long) module function bits_of(x)
         real(wp), intent(in) :: x
      end function bits_of

      !> Returns a field as a number.
      elemental real(wp) module function real_of(bits)
         integer(long), intent(in) :: bits
      end function real_of

   end interface

end module nutate_row_layout
