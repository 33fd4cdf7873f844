!> Outcome of a call. The library never prints and never stops: it returns a `status_t`.
module nutate_status
   use nutate_kinds, only: wp
   implicit none
   private

   public :: status_t, fail
   public :: NUTATE_OK, NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR, NUTATE_NOT_FINITE
   public :: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_BAD_SCENE, NUTATE_IO, NUTATE_STEP_LIMIT
   public :: NUTATE_BAD_HANDLE, NUTATE_CALLBACK, NUTATE_TRUNCATED, NUTATE_NO_MEMORY, NUTATE_STOPPED

   !> Success.
   integer, parameter :: NUTATE_OK = 0
   !> The Newton iteration of a step did not converge.
   integer, parameter :: NUTATE_NOT_CONVERGED = 1
   !> The iteration converged to a root that does not continue the true motion: the step is too long.
   integer, parameter :: NUTATE_OFF_BRANCH = 2
   !> The linear system of a step is singular.
   integer, parameter :: NUTATE_SINGULAR = 3
   !> A number that is not finite appeared.
   integer, parameter :: NUTATE_NOT_FINITE = 4
   !> An argument is out of its range.
   integer, parameter :: NUTATE_BAD_ARGUMENT = 5
   !> The inertia is not that of a rigid body.
   integer, parameter :: NUTATE_BAD_BODY = 6
   !> A scene file has an entry that cannot be understood or simulated.
   integer, parameter :: NUTATE_BAD_SCENE = 7
   !> A file could not be read or written.
   integer, parameter :: NUTATE_IO = 8
   !> The run would need more steps than allowed.
   integer, parameter :: NUTATE_STEP_LIMIT = 9
   !> The argument of a C program is not a handle of the required kind.
   integer, parameter :: NUTATE_BAD_HANDLE = 10
   !> A C program's callback reported a failure.
   integer, parameter :: NUTATE_CALLBACK = 11
   !> A string did not fit into its buffer and was cut.
   integer, parameter :: NUTATE_TRUNCATED = 12
   !> Memory ran out.
   integer, parameter :: NUTATE_NO_MEMORY = 13
   !> An observer requested the end of a run.
   integer, parameter :: NUTATE_STOPPED = 14

   !> Outcome of a call.
   type :: status_t
      !> One of the `NUTATE_...` codes.
      integer :: code = NUTATE_OK
      !> Newton iterations used, if the call iterates.
      integer :: iterations = 0
      !> Size of the last Newton increment relative to the step's own increment (dimensionless).
      real(wp) :: residual = 0.0_wp
      !> Name of the argument or scene key with the error; blank if there is none.
      character(len=24) :: subject = ''
      !> One line for the user; blank on success. The length makes a status of 256 bytes, as much as compilers clear
      !> without a loop: every step clears one.
      character(len=216) :: message = ''
   contains
      !> Returns true if the call succeeded.
      procedure, non_overridable :: ok
   end type status_t

contains

   !> Returns true if the status is `NUTATE_OK`.
   elemental logical function ok(self)
      class(status_t), intent(in) :: self
      ok = self%code == NUTATE_OK
   end function ok

   !> Returns a status that reports a failure: its code and one line of text.
   pure function fail(code, message, subject) result(status)
      !> One of the `NUTATE_...` codes other than `NUTATE_OK`.
      integer, intent(in) :: code
      !> Description of the error and of the expected value; a text that is too long loses its middle.
      character(len=*), intent(in) :: message
      !> Name of the argument or scene key with the error.
      character(len=*), intent(in), optional :: subject
      type(status_t) :: status
      status%code = code
      status%message = message
      if (len_trim(message) > len(status%message)) status%message = shortened(message, len(status%message))
      if (present(subject)) status%subject = subject
   end function fail

   !> Returns a long text without its middle, cut between words, since its end often has the main point.
   pure function shortened(text, length) result(short)
      character(len=*), intent(in) :: text
      integer, intent(in) :: length
      character(len=length) :: short
      character(len=*), parameter :: gap = ' ... '
      integer :: n, head, tail, blank
      n = len_trim(text)
      tail = length/3
      head = length - len(gap) - tail
      blank = index(text(1:head + 1), ' ', back=.true.)
      if (blank > head/2) head = blank - 1
      blank = index(text(n - tail:n), ' ')
      if (blank > 0 .and. blank < tail/2) tail = tail + 1 - blank
      short = text(1:head)//gap//text(n - tail + 1:n)
   end function shortened

end module nutate_status
