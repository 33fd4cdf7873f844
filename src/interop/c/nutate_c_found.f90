!> The events that a run of a C program has found.
module nutate_c_found
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int64_t, c_ptr, c_size_t
   use nutate_archive, only: archive_t
   use nutate_c_text, only: text_to_c
   use nutate_event, only: event_t
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp, long
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NO_MEMORY, NUTATE_OK
   implicit none
   private

   public :: found_events_t, found_t

   !> Number of events in the first allocation.
   integer(c_size_t), parameter :: first_room = 64

   !> One event.
   type :: found_t
      character(len=24) :: name = ''
      !> Number of the occurrence of the event, from 1.
      integer(long) :: number = 0
      !> Time, s; attitude; Ω, body axes, rad/s.
      real(wp) :: t = 0.0_wp, q(4) = 0.0_wp, omega(3) = 0.0_wp
   end type found_t

   !> Events in the order of time.
   type :: found_events_t
      integer(c_size_t) :: n = 0
      type(found_t), allocatable :: items(:)
   contains
      !> Appends an event.
      procedure :: put
      !> Return the number of events, and one event, to C.
      procedure :: give_count
      procedure :: give
      procedure :: transfer
   end type found_events_t

contains

   !> Writes or reads all events in checkpoint data. Errors: `NUTATE_NO_MEMORY`.
   subroutine transfer(self, archive, status)
      class(found_events_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: name
      integer(long) :: n, i
      n = self%n
      call archive%transfer(n)
      if (archive%is_reading()) then
         self%n = 0
         if (allocated(self%items)) deallocate (self%items)
         if (n < 0) call archive%spoil()
         if (.not. archive%is_whole()) return
      end if
      do i = 1, n
         ! The number may be damaged: room is made for events that are there.
         if (archive%is_reading()) call make_room(self, status)
         if (.not. status%ok()) return
         self%n = max(self%n, i)
         associate (item => self%items(i))
            name = item%name
            call archive%transfer(name)
            item%name = name
            call archive%transfer(item%number)
            call archive%transfer(item%t)
            call archive%transfer(item%q)
            call archive%transfer(item%omega)
         end associate
         if (.not. archive%is_whole()) return
      end do
   end subroutine transfer

   !> Appends an event. Errors: `NUTATE_NO_MEMORY`.
   subroutine put(self, system, event, number, state, status)
      class(found_events_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(status_t), intent(inout) :: status
      call make_room(self, status)
      if (.not. status%ok()) return
      self%n = self%n + 1
      self%items(self%n) = found_t(event%name, number, state%t, state%q, angular_velocity(system, state))
   end subroutine put

   !> Makes room for one more event. Errors: `NUTATE_NO_MEMORY`.
   subroutine make_room(self, status)
      type(found_events_t), intent(inout) :: self
      type(status_t), intent(inout) :: status
      type(found_t), allocatable :: grown(:)
      integer :: failed
      if (.not. allocated(self%items)) allocate (self%items(first_room))
      if (self%n < size(self%items, kind=c_size_t)) return
      allocate (grown(2*self%n), stat=failed)
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for so many events')
         return
      end if
      grown(1:self%n) = self%items
      call move_alloc(grown, self%items)
   end subroutine make_room

   !> Returns the number of events to C. Status: `NUTATE_BAD_ARGUMENT` for a null pointer.
   integer(c_int) function give_count(self, n) result(code)
      class(found_events_t), intent(in) :: self
      integer(c_size_t), intent(inout), optional :: n
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(n)) return
      n = self%n
      code = NUTATE_OK
   end function give_count

   !> Returns one event to C. Status: `NUTATE_BAD_ARGUMENT` for an event that does not exist.
   integer(c_int) function give(self, i, name, size, number, t, q, omega) result(code)
      class(found_events_t), intent(in) :: self
      !> Index of the event, from 0.
      integer(c_size_t), intent(in) :: i
      !> Buffer for the name; may be null with a size of 0.
      type(c_ptr), intent(in) :: name
      integer(c_size_t), intent(in) :: size
      integer(c_int64_t), intent(inout), optional :: number
      real(c_double), intent(inout), optional :: t, q(4), omega(3)
      code = NUTATE_BAD_ARGUMENT
      if (i < 0 .or. i >= self%n) return
      code = NUTATE_OK
      associate (item => self%items(i + 1))
         if (present(number)) number = item%number
         if (present(t)) t = item%t
         if (present(q)) q = item%q
         if (present(omega)) omega = item%omega
         if (size /= 0) code = text_to_c(trim(item%name), name, size)
      end associate
   end function give

end module nutate_c_found
