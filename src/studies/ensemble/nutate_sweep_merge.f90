!> Merges the files of several sweeps over parts of an ensemble: `NAME.A-B.npy` for members A to B.
module nutate_sweep_merge
   use nutate_files, only: output_file_t
   use nutate_folder, only: files_between
   use nutate_kinds, only: long
   use nutate_npy, only: npy_header
   use nutate_printable, only: printable_path
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_scene, only: scene_t
   use nutate_spelling, only: count_text
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_sweep_csv, only: npy_rows_t
   use nutate_sweep_listing, only: listing_fits, write_listing
   implicit none
   private

   public :: merge_parts, part_name, stem_of

   character(len=*), parameter :: ending = '.npy'
   integer, parameter :: word = 8

   !> First and last member of one file.
   type :: part_t
      integer(long) :: first = 0, last = 0
   end type part_t

contains

   !> Returns the name of the file of some members.
   pure function part_name(name, first, last) result(part)
      !> Name of the file of the whole ensemble.
      character(len=*), intent(in) :: name
      integer(long), intent(in) :: first, last
      character(len=:), allocatable :: part
      part = stem_of(name)//'.'//count_text(first)//'-'//count_text(last)//ending
   end function part_name

   !> Returns a name without `.npy`.
   pure function stem_of(name) result(stem)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem
      stem = name
      if (len(name) <= len(ending)) return
      if (name(len(name) - len(ending) + 1:) == ending) stem = name(:len(name) - len(ending))
   end function stem_of

   !> Merges the files of all members, and leaves them where they are.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for members that no file has, or that two have, and for files of another scene;
   !> `NUTATE_IO`.
   subroutine merge_parts(scene, name, parts, status)
      !> Scene with an ensemble whose rows are kept.
      type(scene_t), intent(in) :: scene
      !> Path of the complete file.
      character(len=*), intent(in) :: name
      !> Number of files that were found.
      integer, intent(out) :: parts
      type(status_t), intent(out) :: status
      type(part_t), allocatable :: found(:)
      type(row_layout_t) :: layout
      type(output_file_t) :: file
      character(len=:), allocatable :: header
      integer(long) :: offset
      integer :: i

      parts = 0
      call make_layout(scene, layout, status)
      if (.not. status%ok()) return
      call find_parts(scene, name, found, status)
      parts = size(found)
      if (.not. status%ok()) return
      header = npy_header(layout, scene%ensemble%members)
      offset = len(header)
      call file%open(name, status)
      if (status%ok()) call file%put_at(0_long, header, status)
      do i = 1, parts
         if (status%ok()) call copy_part(found(i), name, layout, file, offset, status)
      end do
      if (status%ok()) call write_listing(scene, layout, 1_long, scene%ensemble%members, name, status)
      if (status%ok()) call file%sync(status)
      call file%close(status)
   end subroutine merge_parts

   !> Finds the files of an ensemble, in the order of their members. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine find_parts(scene, name, parts, status)
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      type(part_t), allocatable, intent(out) :: parts(:)
      type(status_t), intent(out) :: status
      type(part_t) :: part
      character(len=:), allocatable :: middles(:)
      integer(long) :: next
      integer :: i, at
      middles = files_between(stem_of(name)//'.', ending)
      allocate (parts(0))
      do i = 1, size(middles)
         if (is_range(trim(middles(i)), part)) parts = [parts, part]
      end do
      next = 1
      do i = 1, size(parts)
         at = i - 1 + minloc(parts(i:)%first, dim=1)
         part = parts(at)
         parts(at) = parts(i)
         parts(i) = part
         if (part%first > next) exit
         if (part%first < next) then
            status = fail(NUTATE_BAD_ARGUMENT, 'member '//count_text(part%first)//' is in two files')
            return
         end if
         if (.not. listing_fits(scene, part%first, part%last, part_name(name, part%first, part%last))) then
            status = fail(NUTATE_BAD_ARGUMENT, printable_path(part_name(name, part%first, part%last))// &
                          ' belongs to another sweep')
            return
         end if
         next = part%last + 1
      end do
      if (next > scene%ensemble%members) return
      part%last = scene%ensemble%members
      if (i <= size(parts)) part%last = parts(i)%first - 1
      status = fail(NUTATE_BAD_ARGUMENT, 'members '//count_text(next)//' to '//count_text(part%last)// &
                    ' are in no file (expected '//printable_path(part_name(name, next, part%last))//')')
   end subroutine find_parts

   !> Returns true for a string of the form `A-B`, and reads the members A and B.
   logical function is_range(text, part)
      character(len=*), intent(in) :: text
      type(part_t), intent(out) :: part
      integer :: dash, error
      dash = index(text, '-')
      is_range = dash > 1 .and. dash < len(text) .and. len(text) < 24 .and. verify(text, '0123456789-') == 0 .and. &
                 index(text, '-', back=.true.) == dash
      if (.not. is_range) return
      read (text(:dash - 1), *, iostat=error) part%first
      if (error == 0) read (text(dash + 1:), *, iostat=error) part%last
      is_range = error == 0 .and. part%first >= 1 .and. part%last >= part%first
   end function is_range

   !> Copies the rows of a file to their position. Errors: `NUTATE_IO`.
   subroutine copy_part(part, name, layout, file, offset, status)
      type(part_t), intent(in) :: part
      character(len=*), intent(in) :: name
      type(row_layout_t), intent(in) :: layout
      type(output_file_t), intent(inout) :: file
      !> Number of bytes before the rows; on exit before the rows that follow them.
      integer(long), intent(inout) :: offset
      type(status_t), intent(out) :: status
      type(npy_rows_t) :: reader
      integer(long), allocatable :: fields(:, :)
      character(len=layout%width()*word) :: row
      integer :: i
      call reader%open(part_name(name, part%first, part%last), layout, part%last - part%first + 1, status)
      do while (status%ok())
         call reader%next(fields, status)
         if (.not. status%ok() .or. size(fields) == 0) exit
         do i = 1, size(fields, 2)
            row = transfer(fields(:, i), row)
            if (status%ok()) call file%put_at(offset, row, status)
            offset = offset + len(row)
         end do
      end do
      call reader%close()
      if (.not. status%ok()) status%message = printable_path(part_name(name, part%first, part%last))//': '// &
                                              trim(status%message)
   end subroutine copy_part

end module nutate_sweep_merge
