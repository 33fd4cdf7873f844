!> Progress and summary of a sweep, and the workers that run its members.
module nutate_sweep_report
   use nutate_scene_loading, only: add_space_axes
   use nutate_console, only: count_text, page_t, plural, say_error, show_page, vector_text, EXIT_OUTPUT, EXIT_RUN
   use nutate_contraction, only: arithmetic_in_words
   use nutate_decimal, only: rounded_text
   use nutate_ensemble_plan, only: ensemble_plan_t, varied_key_t, CASES, GRID, NORMAL, ROTATION
   use nutate_files, only: STANDARD_ERROR
   use nutate_kinds, only: long, wp
   use nutate_member, only: member_t
   use nutate_printable, only: printable_path
   use nutate_row_layout, only: row_layout_t
   use nutate_run_watcher, only: progress_bar_t, caught_signal
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_sweep, only: sweep_t
   use nutate_sweep_csv, only: add_up
   use nutate_sweep_listing, only: status_in_words
   use nutate_sweep_sums, only: sweep_sums_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_table, only: table_t
   implicit none
   private

   public :: sweep_workers_t, sweep_progress_t, add_ensemble, show_summary

   type :: sweep_workers_t
      !> Name of the program in messages.
      character(len=12) :: program = 'nutate'
      integer :: threads = 1
   contains
      !> Returns the number of members that run at once.
      procedure :: count => count_workers
      !> Runs the members that are not done yet.
      procedure :: go
   end type sweep_workers_t

   type, extends(sweep_watcher_t) :: sweep_progress_t
      type(progress_bar_t) :: bar
      !> Number of members that were done at the start.
      integer(long) :: before = -1
      integer(long), private :: started = 0, rate = 1
   contains
      !> Starts the clock.
      procedure :: start
      !> Returns the wall time since the start, s.
      procedure :: seconds
      procedure :: wants_end
      procedure :: report
   end type sweep_progress_t

contains

   !> Returns the number of members that run at once.
   integer function count_workers(self)
      class(sweep_workers_t), intent(in) :: self
      count_workers = self%threads
   end function count_workers

   !> Runs the members that are not done yet. Errors: those of `sweep%go`.
   subroutine go(self, sweep, scene, watcher, status)
      class(sweep_workers_t), intent(inout) :: self
      !> Sweep, open.
      type(sweep_t), intent(inout), target :: sweep
      !> Scene with which the sweep was opened.
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout), target :: watcher
      type(status_t), intent(out) :: status
      call sweep%go(scene, self%threads, watcher, status)
   end subroutine go

   !> Starts the clock.
   subroutine start(self, wanted)
      class(sweep_progress_t), intent(inout) :: self
      !> True if a progress bar is wanted.
      logical, intent(in) :: wanted
      call system_clock(self%started, self%rate)
      call self%bar%start(wanted)
   end subroutine start

   !> Returns the wall time since the start, s.
   real(wp) function seconds(self)
      class(sweep_progress_t), intent(in) :: self
      integer(long) :: now
      call system_clock(now)
      seconds = real(now - self%started, wp)/real(self%rate, wp)
   end function seconds

   logical function wants_end(self)
      class(sweep_progress_t), intent(in) :: self
      wants_end = caught_signal() /= 0
   end function wants_end

   subroutine report(self, done, members)
      class(sweep_progress_t), intent(inout) :: self
      integer(long), intent(in) :: done, members
      integer(long) :: now
      if (self%before < 0) self%before = done
      call system_clock(now)
      call self%bar%update(real(done, wp)/real(members, wp), now)
   end subroutine report

   !> Adds the number of members, the varied quantities, and the file of the results.
   subroutine add_ensemble(page, plan)
      type(page_t), intent(inout) :: page
      !> Plan of an active ensemble.
      type(ensemble_plan_t), intent(in) :: plan
      integer :: i
      call page%line('ensemble (nutate sweep)')
      call page%item('members', count_text(plan%members)//', seed '//count_text(plan%seed)// &
                     trim(merge(', latin sampling', repeat(' ', 16), plan%latin)))
      do i = 1, size(plan%variations)
         associate (variation => plan%variations(i))
            call page%item(merge('varied', '      ', i == 1), names_of(plan, variation)//': '//law_of(variation))
         end associate
      end do
      if (plan%keeps_rows) then
         call page%item('rows', printable_path(plan%file))
      else
         call page%item('mean and counts', printable_path(plan%file))
      end if
   end subroutine add_ensemble

   !> Returns the names of the quantities that are drawn together.
   pure function names_of(plan, variation) result(text)
      type(ensemble_plan_t), intent(in) :: plan
      type(varied_key_t), intent(in) :: variation
      character(len=:), allocatable :: text
      integer :: i
      text = trim(plan%targets(variation%first)%name)
      do i = variation%first + 1, min(variation%first + variation%n - 1, variation%first + 5)
         text = text//', '//trim(plan%targets(i)%name)
      end do
      if (variation%n > 6) text = text//', ...'
   end function names_of

   !> Returns the distribution of a variation in words.
   pure function law_of(variation) result(text)
      type(varied_key_t), intent(in) :: variation
      character(len=:), allocatable :: text
      real(wp) :: deviation(variation%n)
      integer :: i
      select case (variation%distribution)
      case (CASES)
         text = 'from the table, '//plural(size(variation%cases, 2, long), 'line')
      case (ROTATION)
         text = 'uniform over all rotations'
      case (NORMAL)
         do i = 1, variation%n
            deviation(i) = norm2(variation%factor(i, :))
         end do
         text = 'normal, '//vector_text(variation%low)//' +- '//vector_text(deviation)
      case (GRID)
         text = 'grid, '//vector_text(variation%low)//' to '//vector_text(variation%high)//' by '// &
                vector_text(real(variation%points, wp))
      case default
         text = 'uniform, '//vector_text(variation%low)//' to '//vector_text(variation%high)
      end select
   end function law_of

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
      real(wp) :: seconds
      integer(long) :: first_failed
      integer :: shown
      first_failed = 0
      if (scene%ensemble%keeps_rows) then
         call add_up(name, layout, members, sums, first_failed, status)
      else if (present(sweep)) then
         sums = sweep%sums
      end if
      if (.not. status%ok()) then
         call say_error('nutate: '//printable_path(name)//': '//trim(status%message), exit_code, EXIT_OUTPUT)
         return
      end if
      if (sums%codes(0) == 0) exit_code = EXIT_RUN
      if (quiet .and. exit_code == 0) return
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_space_axes(page, scene)
      if (present(watcher)) then
         seconds = max(watcher%seconds(), 1e-9_wp)
         call page%item('wall time', rounded_text(seconds, 3)//' s, '// &
                        rounded_text(real(members - max(watcher%before, 0_long), wp)/seconds, 3)//' members a second')
      end if
      call add_members()
      call add_fields()
      call page%item('arithmetic', arithmetic_in_words())
      call page%item(merge('rows', 'mean', scene%ensemble%keeps_rows), &
                     plural(int(layout%width(), long), 'field')//' in '//printable_path(name))
      call show_page(page, STANDARD_ERROR, shown)

   contains

      !> Adds the number of members with each status, and the first that failed.
      subroutine add_members()
         type(member_t) :: member
         type(status_t) :: status
         integer :: i
         call page%item('members', plural(sum(sums%codes), 'member')//' of '//count_text(scene%ensemble%members))
         do i = 0, size(sums%codes) - 1
            if (sums%codes(i) > 0) call page%item('  status '//count_text(i), &
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
      subroutine add_fields()
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

   end subroutine show_summary

end module nutate_sweep_report
