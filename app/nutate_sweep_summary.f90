!> Summary of a sweep, for people.
module nutate_sweep_summary
   use nutate_axes_words, only: add_space_axes
   use nutate_console, only: count_text, page_t, plural, say_error, show_page, EXIT_OUTPUT, EXIT_RUN
   use nutate_contraction, only: arithmetic_in_words
   use nutate_decimal, only: rounded_text
   use nutate_files, only: STANDARD_ERROR
   use nutate_kinds, only: wp, long
   use nutate_member, only: member_t
   use nutate_printable, only: printable_path
   use nutate_row_layout, only: row_layout_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_sweep, only: sweep_t
   use nutate_sweep_csv, only: add_up
   use nutate_sweep_listing, only: status_in_words
   use nutate_sweep_progress, only: sweep_progress_t
   use nutate_sweep_sums, only: sweep_sums_t
   use nutate_table, only: table_t
   implicit none
   private

   public :: show_summary

contains

   !> Adds up the rows and shows their summary. The exit code is `EXIT_RUN` if no member reached its end.
   subroutine show_summary(scene, layout, members, name, quiet, exit_code, watcher, sweep)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: members
      !> Path of the file.
      character(len=*), intent(in) :: name
      logical, intent(in) :: quiet
      integer, intent(inout) :: exit_code
      !> Watcher and sweep; present if members have been run.
      type(sweep_progress_t), intent(in), optional :: watcher
      type(sweep_t), intent(in), optional :: sweep
      type(sweep_sums_t) :: sums
      type(status_t) :: status
      type(page_t) :: page
      integer(long) :: first_failed
      integer :: shown
      first_failed = 0
      if (scene%ensemble%keeps_rows) then
         call add_up(name, layout, members, sums, first_failed, status)
      else if (present(sweep)) then
         sums = sweep%sums
      end if
      if (.not. status%ok()) then
         exit_code = EXIT_OUTPUT
         call say_error('nutate: '//printable_path(name)//': '//trim(status%message))
         return
      end if
      if (sums%codes(0) == 0) exit_code = EXIT_RUN
      if (quiet .and. exit_code == 0) return
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_space_axes(page, scene)
      if (present(watcher)) call add_time(page, members, watcher)
      call add_members(page, scene, sums, first_failed)
      call add_fields(page, layout, sums)
      call page%item('arithmetic', arithmetic_in_words())
      call page%item(merge('rows', 'mean', scene%ensemble%keeps_rows), &
                     plural(int(layout%width(), long), 'field')//' in '//printable_path(name))
      call show_page(page, STANDARD_ERROR, shown)
   end subroutine show_summary

   subroutine add_time(page, members, watcher)
      type(page_t), intent(inout) :: page
      integer(long), intent(in) :: members
      type(sweep_progress_t), intent(in) :: watcher
      real(wp) :: seconds
      seconds = max(watcher%seconds(), 1e-9_wp)
      call page%item('wall time', rounded_text(seconds, 3)//' s, '// &
                     rounded_text(real(members - max(watcher%before, 0_long), wp)/seconds, 3)//' members a second')
   end subroutine add_time

   !> Adds the number of members with each status, and the first that failed.
   subroutine add_members(page, scene, sums, first_failed)
      type(page_t), intent(inout) :: page
      type(scene_t), intent(in) :: scene
      type(sweep_sums_t), intent(in) :: sums
      integer(long), intent(in) :: first_failed
      type(member_t) :: member
      type(status_t) :: status
      integer :: i
      call page%item('members', plural(sum(sums%codes), 'member')//' of '//count_text(scene%ensemble%members))
      do i = 0, size(sums%codes) - 1
         if (sums%codes(i) > 0) call page%item('  status '//count_text(int(i, long)), &
                                               count_text(sums%codes(i))//': '//status_in_words(i))
      end do
      if (first_failed == 0) return
      call member%prepare(scene)
      call member%set_values(scene%ensemble, first_failed, status)
      if (status%ok()) then
         call page%item('  the first', 'member '//count_text(first_failed)//' (nutate sweep --member '// &
                        count_text(first_failed)//' shows it)')
      else
         call page%item('  the first', 'member '//count_text(first_failed)//': '//trim(status%message))
      end if
   end subroutine add_members

   !> Adds mean, deviation and extremes of every field.
   subroutine add_fields(page, layout, sums)
      type(page_t), intent(inout) :: page
      type(row_layout_t), intent(in) :: layout
      type(sweep_sums_t), intent(in) :: sums
      type(table_t) :: table
      integer :: i
      if (sums%codes(0) == 0) return
      table%indent = 4
      call table%add_column('field')
      call table%add_column('mean', digits=6)
      call table%add_column('deviation', digits=3)
      call table%add_column('least', digits=6)
      call table%add_column('greatest', digits=6)
      do i = 3, layout%width()
         if (sums%count(i) == 0) cycle
         call table%add_row()
         call table%put(layout%names(i))
         call table%put(sums%mean(i))
         call table%put(sums%deviation(i))
         call table%put(sums%least(i))
         call table%put(sums%greatest(i))
      end do
      call page%line(table%text())
   end subroutine add_fields

end module nutate_sweep_summary
