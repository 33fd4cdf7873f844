!> The work array of the FORTRAN 77 routines: what NUINIT was told, where the last call stopped, and what the method
!> remembers of its steps. Plain numbers, no addresses: a copy is as good as the original.
!>
!> WORK(1): its length; (2): a mark; (3), (4): the first numbers of the second and of the third part.
module nutate_f77_work
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_archive, only: archive_t
   use nutate_body, only: body_t
   use nutate_effect, only: given_bounds_t
   use nutate_kinds, only: wp, long
   use nutate_number_archive, only: number_archive_t
   use nutate_state, only: state_t
   use nutate_stepper, only: stepper_t
   implicit none
   private

   public :: setup_t, place_t, count_work, is_work, fill_work, get_setup, put_setup, get_place, put_place, &
      get_memory, put_memory

   !> What NUINIT was told, and NUFRAM, NUBPOT and NUBTOR after it.
   type :: setup_t
      !> 1: reduced form, 2: eight equations; order; 0 to 3: POT counts 1, TOR counts 2.
      integer :: solver = 1, order = 2, callbacks = 0
      !> 1/J0, kg⁻¹ m⁻²; 0 for an infinite J0.
      real(wp) :: inverse_j0 = 0.0_wp
      !> g, space axes, m/s², and m c, body axes, kg m; shape (3).
      real(wp) :: gravity(3) = 0.0_wp, moment(3) = 0.0_wp
      !> Damping, body axes, N m s; shape (3).
      real(wp) :: damping(3) = 0.0_wp
      !> Momentum of the rotors, body axes, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      !> n of POT, space axes; shape (3).
      real(wp) :: direction(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> Rate at which the space axes turn, in these axes, rad/s; shape (3).
      real(wp) :: frame_rate(3) = 0.0_wp
      type(body_t) :: body
      !> Of POT and of TOR.
      type(given_bounds_t) :: potential_bounds, torque_bounds
   contains
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_setup
   end type setup_t

   !> Where the last call stopped.
   type :: place_t
      !> A call has succeeded.
      logical :: begun = .false.
      !> Fixed steps since a first time; that length and time, s.
      integer(long) :: steps = 0
      real(wp) :: dt = 0.0_wp, first_time = 0.0_wp
      type(state_t) :: state
      !> Work of damping and TOR since NUINIT, J, and the digits that this sum cannot hold.
      real(wp) :: work = 0.0_wp, work_compensation = 0.0_wp
      !> Since NUINIT: steps, Newton iterations, steps that had to be subdivided, steps with a root that is taken
      !> for the true one without a proof.
      integer(long) :: all_steps = 0, iterations = 0, subdivided_steps = 0, uncertified_steps = 0
   contains
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_place
      !> True if a call starts where the last one stopped.
      procedure :: continues_at
   end type place_t

   !> Bits of the second number of an array that NUINIT has filled: `NUTATE 2` in ASCII.
   integer(int64), parameter :: mark = int(z'4E55544154452032', int64)
   !> First number of the first part.
   integer, parameter :: setup_at = 5

contains

   !> Numbers that the array must hold for a stepper.
   integer function count_work(stepper) result(n)
      class(stepper_t), intent(inout) :: stepper
      integer :: place_at, memory_at
      call find_parts(stepper, place_at, memory_at, n)
   end function count_work

   !> First numbers of the second and the third part, and the length of the array.
   subroutine find_parts(stepper, place_at, memory_at, n)
      class(stepper_t), intent(inout) :: stepper
      integer, intent(out) :: place_at, memory_at, n
      type(number_archive_t) :: archive
      type(setup_t) :: setup
      type(place_t) :: place
      call archive%begin_counting()
      call setup%transfer(archive)
      place_at = setup_at + archive%count()
      call place%transfer(archive)
      memory_at = setup_at + archive%count()
      call stepper%transfer(archive)
      n = setup_at - 1 + archive%count()
   end subroutine find_parts

   !> Makes the array ready for the first step.
   subroutine fill_work(setup, stepper, work)
      type(setup_t), intent(inout) :: setup
      class(stepper_t), intent(inout) :: stepper
      !> Shape (as `count_work` says).
      real(wp), intent(inout), target, contiguous :: work(:)
      type(number_archive_t) :: archive
      type(place_t) :: place
      integer :: place_at, memory_at, n
      call find_parts(stepper, place_at, memory_at, n)
      work = 0.0_wp
      work(1:4) = [real(n, wp), transfer(mark, 0.0_wp), real(place_at, wp), real(memory_at, wp)]
      call archive%begin_writing(work(setup_at:place_at - 1))
      call setup%transfer(archive)
      call put_place(place, work)
   end subroutine fill_work

   !> True if NUINIT has filled the array; false for any other numbers, whatever their bits.
   pure logical function is_work(work, n)
      integer, intent(in) :: n
      !> Shape (n).
      real(wp), intent(in) :: work(*)
      is_work = .false.
      if (n >= setup_at) is_work = transfer(work(2), 0_int64) == mark
   end function is_work

   !> Reads what NUINIT was told.
   subroutine get_setup(work, setup)
      real(wp), intent(in), target, contiguous :: work(:)
      type(setup_t), intent(inout) :: setup
      type(number_archive_t) :: archive
      call archive%begin_reading(work(setup_at:))
      call setup%transfer(archive)
   end subroutine get_setup

   !> Writes what was added to it.
   subroutine put_setup(setup, work)
      type(setup_t), intent(inout) :: setup
      real(wp), intent(inout), target, contiguous :: work(:)
      type(number_archive_t) :: archive
      call archive%begin_writing(work(setup_at:nint(work(3)) - 1))
      call setup%transfer(archive)
   end subroutine put_setup

   !> Reads where the last call stopped.
   subroutine get_place(work, place)
      real(wp), intent(in), target, contiguous :: work(:)
      type(place_t), intent(inout) :: place
      type(number_archive_t) :: archive
      call archive%begin_reading(work(nint(work(3)):))
      call place%transfer(archive)
   end subroutine get_place

   !> Writes where a call stopped.
   subroutine put_place(place, work)
      type(place_t), intent(inout) :: place
      real(wp), intent(inout), target, contiguous :: work(:)
      type(number_archive_t) :: archive
      call archive%begin_writing(work(nint(work(3)):))
      call place%transfer(archive)
   end subroutine put_place

   !> Gives a stepper what it remembers of the steps of the last call.
   subroutine get_memory(work, stepper)
      real(wp), intent(in), target, contiguous :: work(:)
      !> Prepared.
      class(stepper_t), intent(inout) :: stepper
      type(number_archive_t) :: archive
      call archive%begin_reading(work(nint(work(4)):))
      call stepper%transfer(archive)
   end subroutine get_memory

   !> Keeps what a stepper remembers of its steps.
   subroutine put_memory(stepper, work)
      class(stepper_t), intent(inout) :: stepper
      real(wp), intent(inout), target, contiguous :: work(:)
      type(number_archive_t) :: archive
      call archive%begin_writing(work(nint(work(4)):))
      call stepper%transfer(archive)
   end subroutine put_memory

   !> Writes or reads its values in checkpoint data.
   subroutine transfer_setup(self, archive)
      class(setup_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%solver)
      call archive%transfer(self%order)
      call archive%transfer(self%callbacks)
      call archive%transfer(self%inverse_j0)
      call archive%transfer(self%gravity)
      call archive%transfer(self%moment)
      call archive%transfer(self%damping)
      call archive%transfer(self%rotor)
      call archive%transfer(self%direction)
      call archive%transfer(self%frame_rate)
      call archive%transfer(self%body%inertia)
      call archive%transfer(self%body%inverse_inertia)
      call archive%transfer(self%body%axes)
      call archive%transfer(self%body%moments)
      call transfer_bounds(self%potential_bounds, archive)
      call transfer_bounds(self%torque_bounds, archive)
   end subroutine transfer_setup

   !> Writes or reads the values of bounds in checkpoint data.
   subroutine transfer_bounds(bounds, archive)
      type(given_bounds_t), intent(inout) :: bounds
      class(archive_t), intent(inout) :: archive
      call archive%transfer(bounds%known)
      call archive%transfer(bounds%first)
      call archive%transfer(bounds%second)
      call archive%transfer(bounds%third)
      call archive%transfer(bounds%rate)
   end subroutine transfer_bounds

   !> Writes or reads its values in checkpoint data.
   subroutine transfer_place(self, archive)
      class(place_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%begun)
      call archive%transfer(self%steps)
      call archive%transfer(self%dt)
      call archive%transfer(self%first_time)
      call self%state%transfer(archive)
      call archive%transfer(self%work)
      call archive%transfer(self%work_compensation)
      call archive%transfer(self%all_steps)
      call archive%transfer(self%iterations)
      call archive%transfer(self%subdivided_steps)
      call archive%transfer(self%uncertified_steps)
   end subroutine transfer_place

   !> True if a call starts where the last one stopped.
   pure logical function continues_at(self, t, q, p)
      class(place_t), intent(in) :: self
      !> s; attitude and conjugate momentum, shape (4).
      real(wp), intent(in) :: t, q(4), p(4)
      continues_at = self%begun .and. t == self%state%t .and. all(q == self%state%q) .and. all(p == self%state%p)
   end function continues_at

end module nutate_f77_work
