!> Computes rows of members in memory, in the calling thread or in several threads.
module nutate_member_rows
   use, intrinsic :: iso_c_binding, only: c_int
   use nutate_forks, only: has_threads, may_start_threads
   use nutate_kinds, only: wp, long
   use nutate_member_run, only: member_run_t
   use nutate_row_layout, only: row_layout_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_STOPPED
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_text_lock, only: lock_texts, unlock_texts
   implicit none
   private

   public :: run_members, fill_rows, run_share

   !> Largest number of members that a thread takes at a time: small, so that threads end together.
   integer(long), parameter :: largest_share = 64
   !> Least number of shares of each thread.
   integer(long), parameter :: usual_shares = 8
   !> Time between two polls of a thread that has no more members, s.
   real(wp), parameter :: usual_pause = 0.01_wp

   interface
      !> Suspends the calling thread (POSIX).
      integer(c_int) function usleep(microseconds) bind(c, name='usleep')
         import :: c_int
         implicit none
         integer(c_int), value :: microseconds
      end function usleep
   end interface

contains

   !> Runs members in the calling thread and returns their rows. Errors: `NUTATE_BAD_ARGUMENT` for members that the
   !> ensemble does not have, and for an unknown set of columns.
   subroutine run_members(scene, layout, first, last, fields, status)
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      !> Row layout of the scene.
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last
      !> Shape (fields, members).
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(status_t), intent(out) :: status
      type(sweep_watcher_t), target :: nobody
      if (first < 1 .or. last > scene%ensemble%members) then
         status = fail(NUTATE_BAD_ARGUMENT, 'members are out of range (expected 1 to the number of members)', 'first')
         return
      end if
      allocate (fields(layout%width(), last - first + 1))
      call fill_rows(scene, layout, first, last, 1, nobody, fields, status)
   end subroutine run_members

   !> Runs members and fills their rows, which do not depend on the threads that run them.
   !>
   !> Errors: `NUTATE_STOPPED` if the watcher wants the end; `NUTATE_BAD_ARGUMENT` for threads in a library built
   !> without them, and for an unknown set of columns. Rows are then filled in part.
   subroutine fill_rows(scene, layout, first, last, threads, watcher, fields, status)
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      !> Row layout of the scene.
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last
      !> Largest number of threads; 1: the calling thread, and no parallel region is entered.
      integer, intent(in) :: threads
      !> Watcher that every thread polls for a request to stop.
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
      ! A single member is run by the calling thread, which may be the only one that receives a request to stop.
      workers = int(max(min(int(threads, long), last - first + 1), 1_long))
      if (workers > 1) workers = merge(workers, 1, may_start_threads())
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

   !> Polls the watcher while others run the last members: the calling thread may be the only one that receives a
   !> request to stop.
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

   !> Takes shares of the members until there are none; called by each thread.
   subroutine run_shares(scene, layout, first, last, share, next, watcher, fields, failure)
      type(scene_t), intent(in) :: scene
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: first, last, share
      !> Next member to run; shared.
      integer(long), intent(inout) :: next
      class(sweep_watcher_t), intent(in), target :: watcher
      integer(long), intent(inout) :: fields(:, :)
      !> First failure; shared.
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

   !> Runs members and fills their rows. Errors: `NUTATE_STOPPED` if the watcher wants the end.
   subroutine run_share(runner, scene, first, last, fields, status)
      !> Prepared runner.
      type(member_run_t), intent(inout) :: runner
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      !> Shape (fields, members).
      integer(long), intent(inout) :: fields(:, :)
      type(status_t), intent(out) :: status
      logical :: done(last - first + 1)
      integer(long) :: k
      call runner%run_tops(scene, first, fields, done, status)
      if (.not. status%ok()) return
      do k = first, last
         if (done(k - first + 1)) cycle
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
      !> Time to wait, s; below 1.
      real(wp), intent(in) :: seconds
      if (usleep(int(1e6_wp*seconds, c_int)) /= 0) return
   end subroutine pause_thread

end module nutate_member_rows
