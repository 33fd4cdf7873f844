!> What a run shows to the program that wants to see it.
module nutate_observer
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_event, only: event_t
   use nutate_kinds, only: wp, long
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: observer_t, run_record_t

   !> What belongs to a row beside the state.
   type :: run_record_t
      !> Steps done: nominal ones, or those chosen by their error.
      integer(long) :: step = 0
      !> Newton iterations of the last step, and its largest last relative increment.
      integer :: iterations = 0
      real(wp) :: residual = 0.0_wp
      !> Stages of the last step, in all its parts, whose root is accepted without certification.
      integer :: uncertified = 0
      !> Work of all torques so far, J.
      real(wp) :: work = 0.0_wp
      !> The same of each that does work, and last of switches; shape (n_works + 1). Only where the observer wants it.
      real(wp), allocatable :: works(:)
      !> Lengths tried so far by continuation in Δt (`nutate_continuation`): each counts as a step where steps are
      !> limited.
      integer(long) :: continued = 0
   contains
      !> Shows its values to an archive.
      procedure :: transfer => transfer_record
   end type run_record_t

   !> Receives the rows of a run. A program extends it by what it does with them.
   type, abstract :: observer_t
      !> `watch` is to be called.
      logical :: sees_every_step = .false.
      !> Rows at intervals are not needed: the ends of steps, which cost nothing, are observed instead. Steps stay the
      !> same.
      logical :: rows_at_steps = .false.
      !> Records are to have `works`.
      logical :: wants_works = .false.
      !> `vet` is to be called.
      logical :: vets_steps = .false.
      !> `keep` is to be called where a run ends at `max_steps`.
      logical :: keeps_archives = .false.
      !> `keep` is to be called after the first row, or after the `poll` that sets this.
      logical :: wants_archive = .false.
   contains
      !> Called with the first state, with the rows that the plan asks for, and with the last state.
      procedure(observe_row), deferred :: observe
      !> Called after every 1024 nominal steps, and after every step chosen by its error, rows or not: the place for a
      !> progress bar or a request to stop.
      procedure :: poll => ignore_poll
      !> Called after every step of the method, before anything is made of it, if `vets_steps`: a failure takes the step
      !> back and ends the run. For callbacks that can fail.
      procedure :: vet => accept_all
      !> Called after every step, and after every part of one that is subdivided or turns the body far, before
      !> `observe`, if `sees_every_step`: for what must be followed from step to step.
      procedure :: watch => ignore_watch
      !> Called with each event, in the order of time, before the end of its step is shown.
      procedure :: show_event => ignore_event
      !> Called with all that the run needs to go on from where it is, in an archive; after the rows of that moment.
      procedure :: keep => ignore_archive
   end type observer_t

   abstract interface
      !> A status that is not `NUTATE_OK` ends the run with it.
      subroutine observe_row(self, system, state, record, status)
         import :: observer_t, system_t, state_t, run_record_t, status_t
         class(observer_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         type(run_record_t), intent(in) :: record
         type(status_t), intent(out) :: status
      end subroutine observe_row
   end interface

contains

   !> Shows its values to an archive.
   subroutine transfer_record(self, archive)
      class(run_record_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%step)
      call archive%transfer(self%iterations)
      call archive%transfer(self%residual)
      call archive%transfer(self%uncertified)
      call archive%transfer(self%work)
      call archive%transfer(self%continued)
   end subroutine transfer_record

   !> Does nothing.
   subroutine ignore_poll(self, fraction, status)
      class(observer_t), intent(inout) :: self
      !> How much of the run is done, 0 to 1.
      real(wp), intent(in) :: fraction
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_poll

   !> Finds nothing wrong.
   subroutine accept_all(self, status)
      class(observer_t), intent(inout) :: self
      type(status_t), intent(out) :: status
   end subroutine accept_all

   !> Does nothing.
   subroutine ignore_watch(self, state)
      class(observer_t), intent(inout) :: self
      type(state_t), intent(in) :: state
   end subroutine ignore_watch

   !> Does nothing.
   subroutine ignore_event(self, system, event, which, number, state, record, status)
      class(observer_t), intent(inout) :: self
      !> As it was until then, before switches.
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      !> Its place among the events of the run.
      integer, intent(in) :: which
      !> How often it has happened, this time included.
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(inout) :: status
   end subroutine ignore_event

   !> Does nothing.
   subroutine ignore_archive(self, archive, status)
      class(observer_t), intent(inout) :: self
      !> To be given to the run that goes on.
      type(byte_archive_t), intent(inout) :: archive
      !> A status that is not `NUTATE_OK` ends the run with it.
      type(status_t), intent(out) :: status
   end subroutine ignore_archive

end module nutate_observer
