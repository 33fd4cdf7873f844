!> Ranks as workers of a sweep: rank 0 leads it, all others follow.
module nutate_rank_workers
   use nutate_cli, only: command_t
   use nutate_sweep_server, only: sweep_server_t
   use nutate_kinds, only: long
   use nutate_member_run, only: member_run_t
   use nutate_ranks, only: nap, ranks_t
   use nutate_run_watcher, only: caught_signal, watch_signals
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_SCENE, NUTATE_STOPPED
   use nutate_sweep, only: sweep_t
   use nutate_sweep_command, only: choose_members, read_ensemble
   use nutate_sweep_report, only: sweep_workers_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: rank_workers_t, follow

   !> Polls in vain before a rank lets others have its core.
   integer, parameter :: patience = 100

   !> Ranks as workers of a sweep.
   type, extends(sweep_workers_t) :: rank_workers_t
      type(ranks_t) :: ranks
      !> True if rank 0 has announced to the other ranks what there is to do.
      logical :: has_begun = .false.
   contains
      procedure :: count => count_workers
      procedure :: go
      !> Releases the other ranks, if there was nothing to do for them.
      procedure :: dismiss
   end type rank_workers_t

   !> Watcher that ends members on a signal.
   type, extends(sweep_watcher_t) :: signal_watcher_t
   contains
      procedure :: wants_end => signal_came
   end type signal_watcher_t

contains

   !> Returns the number of members that are run at once.
   integer function count_workers(self)
      class(rank_workers_t), intent(in) :: self
      count_workers = self%ranks%count
   end function count_workers

   !> Runs the chunks that are not done yet. Errors: those of `server%run`.
   subroutine go(self, sweep, scene, watcher, status)
      !> Workers of rank 0.
      class(rank_workers_t), intent(inout) :: self
      type(sweep_t), intent(inout), target :: sweep
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout), target :: watcher
      type(status_t), intent(out) :: status
      type(sweep_server_t), target :: server
      integer(long) :: numbers(2)
      numbers = [sweep%chunk, sweep%identity]
      call self%ranks%announce(numbers)
      self%has_begun = .true.
      server%ranks = self%ranks
      server%sweep => sweep
      server%watcher => watcher
      call server%run(scene, status)
   end subroutine go

   !> Releases the other ranks, if there was nothing to do for them.
   subroutine dismiss(self)
      !> Workers of rank 0.
      class(rank_workers_t), intent(inout) :: self
      integer(long) :: numbers(2)
      numbers = 0
      if (.not. self%has_begun) call self%ranks%announce(numbers)
      self%has_begun = .true.
   end subroutine dismiss

   !> Runs the chunks that rank 0 hands out; called by every other rank. Rank 0 reports the errors.
   subroutine follow(ranks, command)
      type(ranks_t), intent(in) :: ranks
      !> Command, the same as that of rank 0.
      type(command_t), intent(in) :: command
      type(scene_t) :: scene
      type(sweep_t), target :: sweep
      type(status_t) :: status, closing
      character(len=:), allocatable :: name, message
      integer(long), allocatable :: no_rows(:, :)
      integer(long) :: first, last, numbers(2)
      call ranks%announce(numbers)
      if (numbers(1) == 0) return
      call watch_signals()
      call read_ensemble(command, scene, message)
      if (message /= '') status = fail(NUTATE_BAD_SCENE, message)
      if (status%ok()) then
         call choose_members(command, scene, first, last, name)
         call sweep%join(scene, first, last, name, numbers(1), numbers(2), status)
      end if
      if (status%ok()) then
         call run_chunks(ranks, scene, sweep, status)
         call sweep%abandon(closing)
      end if
      if (.not. status%ok() .and. status%code /= NUTATE_STOPPED) call ranks%ask(0_long, no_rows, status)
   end subroutine follow

   !> Runs chunks until there are no more. Errors: `NUTATE_STOPPED` if a signal has come; `NUTATE_IO`.
   subroutine run_chunks(ranks, scene, sweep, status)
      type(ranks_t), intent(in) :: ranks
      type(scene_t), intent(in) :: scene
      !> Joined sweep.
      type(sweep_t), intent(inout), target :: sweep
      type(status_t), intent(out) :: status
      type(signal_watcher_t), target :: watcher
      type(member_run_t) :: runner
      integer(long), allocatable :: fields(:, :)
      integer(long) :: chunk
      chunk = 0
      call runner%prepare(scene, sweep%layout, status, watcher)
      do while (status%ok())
         if (allocated(fields) .and. sweep%keeps_rows) deallocate (fields)
         call ranks%ask(chunk, fields, status)
         call await_chunk(ranks, chunk, status)
         if (chunk == 0 .or. .not. status%ok()) exit
         call sweep%run_chunk(scene, runner, chunk, fields, status)
      end do
   end subroutine run_chunks

   !> Waits for the next chunk. Errors: `NUTATE_STOPPED` if a signal has come.
   subroutine await_chunk(ranks, chunk, status)
      type(ranks_t), intent(in) :: ranks
      !> Number of the chunk; 0: there are no more.
      integer(long), intent(out) :: chunk
      type(status_t), intent(inout) :: status
      logical :: there
      integer :: asked
      asked = 0
      do
         call ranks%listen(there, chunk)
         if (there) return
         if (caught_signal() /= 0) then
            status = fail(NUTATE_STOPPED, 'the sweep was stopped')
            return
         end if
         asked = asked + 1
         if (asked > patience) call nap()
      end do
   end subroutine await_chunk

   logical function signal_came(self)
      class(signal_watcher_t), intent(in) :: self
      signal_came = caught_signal() /= 0
   end function signal_came

end module nutate_rank_workers
