!> The work array of the FORTRAN 77 routines: the set-up, the end of the last call, and the data that the method keeps
!> between steps. It holds plain numbers, no addresses: a copy is as good as the original.
!>
!> WORK(1): length of the array; (2): a mark; (3), (4): indices of the first numbers of the second and of the third
!> part; (5): a hash of the first part.
module nutate_f77_work
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_archive, only: archive_t
   use nutate_body, only: body_t
   use nutate_kinds, only: wp
   use nutate_number_archive, only: number_archive_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   implicit none
   private

   public :: AT_BEGUN, AT_STEPS, AT_DT, AT_FIRST_TIME, AT_T, AT_Q, AT_P, AT_Q_COMPENSATION, AT_P_COMPENSATION, &
      AT_WORK, AT_WORK_COMPENSATION, AT_ALL_STEPS, AT_ITERATIONS, AT_SUBDIVIDED, AT_UNCERTIFIED, AT_MARK, AT_CALL
   public :: setup_t, place_at, continues, count_work, is_work, fill_work, get_setup, has_setup, put_setup, setup_of, &
      get_memory, put_memory, count_memory, settings_of

   !> Set-up from NUINIT, and from NUFRAM, NUBPOT and NUBTOR after it.
   type :: setup_t
      !> Solver, 1: reduced form, 2: eight equations; order; callbacks in use, 0 to 3: POT counts 1, TOR counts 2.
      integer :: solver = 1, order = 2, callbacks = 0
      !> 1/J0, kg⁻¹ m⁻²; 0 for an infinite J0.
      real(wp) :: inverse_j0 = 0.0_wp
      !> g, space axes, m/s², and m c, body axes, kg m; shape (3).
      real(wp) :: gravity(3) = 0.0_wp, moment(3) = 0.0_wp
      !> Damping, body axes, N m s; shape (3).
      real(wp) :: damping(3) = 0.0_wp
      !> Momentum of the rotors, body axes, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      !> Direction n of POT, space axes; shape (3).
      real(wp) :: direction(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> Angular velocity of the space axes, in these axes, rad/s; shape (3).
      real(wp) :: frame_rate(3) = 0.0_wp
      type(body_t) :: body
      !> Bounds of POT and of TOR, as in `effect_t`.
      real(wp) :: potential_bounds(4) = -1.0_wp, torque_bounds(4) = -1.0_wp
   contains
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_setup
   end type setup_t

   !> Bits of the second number of an array that NUINIT has filled: `NUTATE 3` in ASCII.
   integer(int64), parameter :: mark = int(z'4E55544154452033', int64)
   !> Index of the first number of the first part, and count of numbers of the second part.
   integer, parameter :: setup_at = 6, place_size = 29
   !> Offsets of the values of the second part from the first one. Since NUINIT: work of damping and TOR, J, with the
   !> digits that this sum cannot hold, steps, Newton iterations, steps that had to be subdivided, steps with a root
   !> that is accepted without certification.
   integer, parameter :: AT_BEGUN = 0, AT_STEPS = 1, AT_DT = 2, AT_FIRST_TIME = 3, AT_T = 4, AT_Q = 5, AT_P = 9, &
                         AT_Q_COMPENSATION = 13, AT_P_COMPENSATION = 17, AT_WORK = 21, AT_WORK_COMPENSATION = 22, &
                         AT_ALL_STEPS = 23, AT_ITERATIONS = 24, AT_SUBDIVIDED = 25, AT_UNCERTIFIED = 26, AT_MARK = 27, &
                         AT_CALL = 28

contains

   !> Returns the count of numbers that the array must hold for a stepper.
   integer function count_work(stepper) result(n)
      class(stepper_t), intent(inout) :: stepper
      integer :: place_at, memory_at
      call find_parts(stepper, place_at, memory_at, n)
   end function count_work

   !> Finds the indices of the first numbers of the second and the third part, and the length of the array.
   subroutine find_parts(stepper, place_at, memory_at, n)
      class(stepper_t), intent(inout) :: stepper
      integer, intent(out) :: place_at, memory_at, n
      type(number_archive_t) :: archive
      type(setup_t) :: setup
      call archive%begin_counting()
      call setup%transfer(archive)
      place_at = setup_at + archive%count()
      memory_at = place_at + place_size
      call archive%begin_counting()
      call stepper%transfer(archive)
      n = memory_at - 1 + archive%count()
   end subroutine find_parts

   !> Makes the array ready for the first step.
   subroutine fill_work(setup, stepper, work)
      type(setup_t), intent(inout) :: setup
      class(stepper_t), intent(inout) :: stepper
      !> Work array; shape (`count_work` of the stepper).
      real(wp), intent(inout), target, contiguous :: work(:)
      integer :: place_at, memory_at, n
      call find_parts(stepper, place_at, memory_at, n)
      work = 0.0_wp
      work(1:4) = [real(n, wp), transfer(mark, 0.0_wp), real(place_at, wp), real(memory_at, wp)]
      call put_setup(setup, work)
   end subroutine fill_work

   !> Returns true if NUINIT has filled the array; false for any other numbers, whatever their bits.
   pure logical function is_work(work, n)
      integer, intent(in) :: n
      !> Work array; shape (n).
      real(wp), intent(in) :: work(*)
      is_work = .false.
      if (n >= setup_at) is_work = transfer(work(2), 0_int64) == mark
   end function is_work

   !> Reads the set-up.
   subroutine get_setup(work, setup)
      real(wp), intent(in), target :: work(*)
      type(setup_t), intent(inout) :: setup
      type(number_archive_t) :: archive
      call archive%begin_reading(setup_of(work))
      call setup%transfer(archive)
   end subroutine get_setup

   !> Returns true if the numbers of a set-up are those in an array.
   pure logical function has_setup(work, numbers)
      real(wp), intent(in) :: work(*)
      !> Numbers from `setup_of`.
      real(wp), intent(in) :: numbers(:)
      integer :: i
      has_setup = .false.
      do i = 1, size(numbers)
         if (work(setup_at - 1 + i) /= numbers(i)) return
      end do
      has_setup = .true.
   end function has_setup

   !> Writes a set-up and clears the mark: no prepared body has used the array with this set-up.
   subroutine put_setup(setup, work)
      type(setup_t), intent(inout) :: setup
      real(wp), intent(inout), target :: work(*)
      type(number_archive_t) :: archive
      call archive%begin_writing(setup_of(work))
      call setup%transfer(archive)
      work(5) = hash_of(setup_of(work))
      work(place_at(work) + AT_MARK) = 0.0_wp
   end subroutine put_setup

   !> Returns the numbers of the set-up in an array.
   function setup_of(work) result(numbers)
      real(wp), intent(in), target :: work(*)
      real(wp), pointer, contiguous :: numbers(:)
      numbers => work(setup_at:int(work(3)) - 1)
   end function setup_of

   !> Returns a hash of numbers, an integer below 2**32: Fowler, Noll and Vo's FNV-1a of their halves, the high digits
   !> folded onto the low ones.
   pure real(wp) function hash_of(numbers)
      real(wp), intent(in) :: numbers(:)
      integer(int64), parameter :: prime = 16777619_int64, low = int(z'FFFFFFFF', int64)
      integer(int64) :: hash, bits
      integer :: i, k
      hash = 2166136261_int64
      do i = 1, size(numbers)
         bits = transfer(numbers(i), 0_int64)
         do k = 0, 1
            hash = iand(ieor(hash, iand(shiftr(bits, 32*k), low))*prime, low)
            hash = ieor(hash, shiftr(hash, 15))
         end do
      end do
      hash_of = real(hash, wp)
   end function hash_of

   !> Returns the count of numbers of the third part.
   pure integer function count_memory(work) result(n)
      real(wp), intent(in) :: work(*)
      n = int(work(1)) - int(work(4)) + 1
   end function count_memory

   !> Returns the settings of a stepper for a set-up.
   pure type(integrator_settings_t) function settings_of(setup) result(settings)
      type(setup_t), intent(in) :: setup
      settings%order = setup%order
      settings%formulation = merge('reduced', 'full   ', setup%solver == 1)
      settings%inverse_auxiliary_inertia = setup%inverse_j0
   end function settings_of

   !> Returns the index of the first number of the second part.
   pure integer function place_at(work)
      real(wp), intent(in) :: work(*)
      place_at = int(work(3))
   end function place_at

   !> Returns true if a call starts at the end of the last one.
   pure logical function continues(work, t, q, p)
      real(wp), intent(in) :: work(*)
      !> Time, s; attitude and conjugate momentum, shape (4).
      real(wp), intent(in) :: t, q(4), p(4)
      integer :: k
      k = place_at(work)
      continues = work(k + AT_BEGUN) > 0.5_wp .and. t == work(k + AT_T) .and. &
                  all(q == work(k + AT_Q:k + AT_Q + 3)) .and. all(p == work(k + AT_P:k + AT_P + 3))
   end function continues

   !> Restores the data that a stepper keeps between steps, from the last call.
   subroutine get_memory(work, stepper)
      real(wp), intent(in), target :: work(*)
      !> Prepared stepper.
      class(stepper_t), intent(inout) :: stepper
      integer :: used
      used = int(work(4)) - 1
      call stepper%take_memory(int(work(1)), work, used)
   end subroutine get_memory

   !> Stores the data that a stepper keeps between steps.
   subroutine put_memory(stepper, work)
      class(stepper_t), intent(inout) :: stepper
      real(wp), intent(inout), target :: work(*)
      integer :: used
      used = int(work(4)) - 1
      call stepper%put_memory(int(work(1)), work, used)
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
      call archive%transfer(self%potential_bounds)
      call archive%transfer(self%torque_bounds)
   end subroutine transfer_setup

end module nutate_f77_work
