!> Listing beside a finished file of rows, for people and for merging: the scene that the rows belong to, their fields,
!> and the meaning of each status.
module nutate_sweep_listing
   use nutate_contraction, only: arithmetic_in_words
   use nutate_files, only: replace_file
   use nutate_kinds, only: long
   use nutate_printable, only: printable_path
   use nutate_row_layout, only: row_layout_t
   use nutate_scene, only: scene_t
   use nutate_spelling, only: count_text
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_BAD_SCENE, NUTATE_NOT_CONVERGED, &
      NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH, NUTATE_OK, NUTATE_SINGULAR, NUTATE_STEP_LIMIT
   use nutate_sweep_identity, only: identity_of
   use nutate_text_file, only: read_text_file
   use nutate_version, only: version
   implicit none
   private

   public :: write_listing, listing_fits, listing_name, status_in_words

   character(len=*), parameter :: suffix = '.txt', mark = 'identity '

   !> A status code and its meaning.
   type :: code_t
      integer :: code
      character(len=56) :: words
   end type code_t

   type(code_t), parameter :: codes(9) = [ &
      code_t(NUTATE_OK, 'reached its end'), &
      code_t(NUTATE_NOT_CONVERGED, 'the Newton iteration of a step did not converge'), &
      code_t(NUTATE_OFF_BRANCH, 'a step was too long to follow the motion'), &
      code_t(NUTATE_SINGULAR, 'the linear system of a step was singular'), &
      code_t(NUTATE_NOT_FINITE, 'a number was not finite'), &
      code_t(NUTATE_BAD_ARGUMENT, 'the run could not start'), &
      code_t(NUTATE_BAD_BODY, 'rejected: the inertia is not that of a rigid body'), &
      code_t(NUTATE_BAD_SCENE, 'rejected: numbers that the scene does not allow'), &
      code_t(NUTATE_STEP_LIMIT, 'more steps than allowed')]

contains

   !> Returns the meaning of a status code.
   pure function status_in_words(code) result(words)
      integer, intent(in) :: code
      character(len=:), allocatable :: words
      integer :: i
      words = 'it failed'
      i = findloc(codes%code, code, dim=1)
      if (i > 0) words = trim(codes(i)%words)
   end function status_in_words

   !> Writes the listing of a file of rows. Errors: `NUTATE_IO`.
   subroutine write_listing(scene, layout, first, last, name, status)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(in) :: layout
      !> First and last member.
      integer(long), intent(in) :: first, last
      !> Path of the file of rows.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      character, parameter :: line_feed = achar(10)
      character(len=:), allocatable :: text
      character(len=80) :: line
      integer :: i
      text = 'nutate '//version//', '//arithmetic_in_words()//line_feed// &
             'scene '//printable_path(scene%file)//': '//scene%title//line_feed// &
             'members '//count_text(first)//' to '//count_text(last)//' of '//count_text(scene%ensemble%members)// &
             ', seed '//count_text(scene%ensemble%seed)//line_feed
      text = text//identity_line(scene, first, last)//line_feed//line_feed//'status'//line_feed
      do i = 1, size(codes)
         write (line, '(i4,"  ",a)') codes(i)%code, trim(codes(i)%words)
         text = text//trim(line)//line_feed
      end do
      text = text//line_feed//'fields'//line_feed
      do i = 1, layout%width()
         write (line, '(i4)') i
         text = text//line(1:4)//'  '//merge('i8', 'f8', layout%is_whole(i))//'  '//trim(layout%names(i))//line_feed
      end do
      call replace_file(listing_name(name), text, status)
   end subroutine write_listing

   !> Returns the path of the listing of a file of rows.
   pure function listing_name(name) result(listing)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: listing
      listing = name//suffix
   end function listing_name

   !> Returns true if, by its listing, the file of rows of a name belongs to a scene and these members.
   logical function listing_fits(scene, first, last, name)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text, problem
      logical :: exists
      inquire (file=name, exist=exists)
      call read_text_file(listing_name(name), text, problem)
      listing_fits = exists .and. problem == '' .and. index(text, identity_line(scene, first, last)//achar(10)) > 0
   end function listing_fits

   function identity_line(scene, first, last) result(line)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      character(len=:), allocatable :: line
      character(len=16) :: digits
      write (digits, '(z16.16)') identity_of(scene, first, last)
      line = mark//digits
   end function identity_line

end module nutate_sweep_listing
