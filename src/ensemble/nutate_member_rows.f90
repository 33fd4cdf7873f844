!> Rows of members in memory, by the thread that calls or by several.
module nutate_member_rows
   use, intrinsic :: iso_c_binding, only: c_int
   use nutate_kinds, only: wp, long
   use nutate_member_run, only: member_run_t
   use nutate_row_layout, only: row_layout_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_STOPPED
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_text_lock, only: lock_texts, unlock_texts
   implicit none
   private

   public :: run_members, fill_rows, run_share, has_threads

   !> Members that a thread takes at a time, at most: few, so that threads end together.
   integer(long), parameter :: largest_share = 64
   !> Shares of each thread, at least.
   integer(long), parameter :: usual_shares = 8
   !> Time between two questions of a thread that has no more members, s.
   real(wp), parameter :: usual_pause = 0.01_wp

   interface
      !> Of POSIX.
      integer(c_int) function usleep(microseconds) bind(c, name='usleep')
         import :: c_int
         implicit none
         integer(c_int), value :: microseconds
      end function usleep
   end interface

contains

   !> The library was built with threads.
   pure logical function has_threads()
      has_threads = .false.
      !$ has_threads = .true.
   end function has_threads

   !> Runs members in the calling thread and returns their rows. Errors: `NUTATE_BAD_ARGUMENT` for an unknown set of
   !> columns.
   subroutine run_members(scene, layout, first, last, fields, status)
      !> With an ensemble.
      type(scene_t), intent(in) :: scene
      !> Of the scene.
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last
      !> Shape (fields, members).
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(status_t), intent(out) :: status
      type(sweep_watcher_t), target :: nobody
      allocate (fields(layout%width(), last - first + 1))
      call fill_rows(scene, layout, first, last, 1, nobody, fields, status)
   end subroutine run_members

   !> Runs members to their rows, which do not depend on who runs them.
   !>
   !> Errors: `NUTATE_STOPPED` where the watcher wants the end, `NUTATE_BAD_ARGUMENT` for threads of a library that has
   !> none, a set of columns that does not exist; rows are then filled in part.
   subroutine fill_rows(scene, layout, first, last, threads, watcher, fields, status)
      !> With an ensemble.
      type(scene_t), intent(in) :: scene
      !> Of the scene.
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last
      !> How many at most; 1: the one that calls, and no parallel region is entered.
      integer, intent(in) :: threads
      !> Asked whether to go on, by every thread.
      class(sweep_watcher_t), intent(in), target :: watcher
      !> Shape (fields, members).
      integer(long), intent(inout) :: fields(:, :)
      type(status_t), intent(out) :: status
      integer(long) :: share, next
      integer :: workers, at_work
      if (threads > 1 .and. .not. has_threads()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'this library was built without threads (expected 1)', 'threads')
         return
      end if
      ! A member alone is run by the thread that calls, which may be the only one that is told when it is to end.
      workers = int(max(min(int(threads, long), last - first + 1), 1_long))
      share = max(min((last - first + 1)/(usual_shares*workers), largest_share), 1_long)
      next = first
      if (workers > 1) then
         at_work = 0
         !$omp parallel num_threads(workers) default(shared)
         !$omp atomic
         at_work = at_work + 1
         !$omp barrier
         call run_shares(scene, layout, first, last, share, next, watcher, fields, status)
         !$omp atomic
         at_work = at_work - 1
         !$omp master
         call wait_for_others(watcher, at_work)
         !$omp end master
         !$omp end parallel
      else
         call run_shares(scene, layout, first, last, share, next, watcher, fields, status)
      end if
   end subroutine fill_rows

   !> Asks whether to go on while others run the last members: the thread that called may be the only one that receives
   !> it.
   subroutine wait_for_others(watcher, at_work)
      class(sweep_watcher_t), intent(in) :: watcher
      !> Threads with members to run; shared.
      integer, intent(inout) :: at_work
      integer :: others
      do
         !$omp atomic read
         others = at_work
         if (others == 0) exit
         if (watcher%wants_end()) exit
         call pause_thread(usual_pause)
      end do
   end subroutine wait_for_others

   !> What each thread does: takes shares of the members until there are none.
   subroutine run_shares(scene, layout, first, last, share, next, watcher, fields, failure)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last, share
      !> The next member; shared.
      integer(long), intent(inout) :: next
      class(sweep_watcher_t), intent(in), target :: watcher
      integer(long), intent(inout) :: fields(:, :)
      !> The first thing that went wrong; shared.
      type(status_t), intent(inout) :: failure
      type(member_run_t) :: runner
      type(status_t) :: status
      integer(long) :: from, to
      call runner%prepare(scene, layout, status, watcher)
      do while (status%ok())
         call lock_texts()
         from = next
         if (.not. failure%ok()) from = last + 1
         next = from + share
         call unlock_texts()
         if (from > last) exit
         to = min(from + share - 1, last)
         call run_share(runner, scene, from, to, fields(:, from - first + 1:to - first + 1), status)
      end do
      call lock_texts()
      if (failure%ok()) failure = status
      call unlock_texts()
   end subroutine run_shares

   !> Runs members to their rows. Errors: `NUTATE_STOPPED` where the watcher wants the end.
   subroutine run_share(runner, scene, first, last, fields, status)
      !> Prepared.
      type(member_run_t), intent(inout) :: runner
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      !> Shape (fields, members).
      integer(long), intent(inout) :: fields(:, :)
      type(status_t), intent(out) :: status
      integer(long) :: k
      do k = first, last
         call runner%row(scene, k, fields(:, k - first + 1), status)
         if (.not. status%ok()) return
         if (.not. associated(runner%watcher%sweep)) cycle
         if (.not. runner%watcher%sweep%wants_end()) cycle
         status = fail(NUTATE_STOPPED, 'the sweep was stopped')
         return
      end do
   end subroutine run_share

   !> Waits for some time, or until a signal comes, and lets other threads work.
   subroutine pause_thread(seconds)
      !> Below 1.
      real(wp), intent(in) :: seconds
      if (usleep(int(1e6_wp*seconds, c_int)) /= 0) return
   end subroutine pause_thread

end module nutate_member_rows
