!> The work array of the FORTRAN 77 routines: what NUINIT was told, where the last call stopped, and what the method
!> remembers of its steps. Plain numbers, no addresses: a copy is as good as the original.
module nutate_f77_work
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: body_t
   use nutate_kinds, only: wp, long
   use nutate_state, only: state_t
   implicit none
   private

   public :: setup_t, place_t, work_size, is_work, goes_on, put_setup, get_setup, put_place, get_place, memory_at

   !> What NUINIT was told.
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
      type(body_t) :: body
   end type setup_t

   !> Where the last call stopped.
   type :: place_t
      !> A call has succeeded.
      logical :: begun = .false.
      !> Steps of one length since a first time; that length and time, s.
      integer(long) :: steps = 0
      real(wp) :: dt = 0.0_wp, first_time = 0.0_wp
      type(state_t) :: state
      !> Work of damping and TOR since NUINIT, J, and the digits that this sum cannot hold.
      real(wp) :: work = 0.0_wp, work_compensation = 0.0_wp
      !> Since NUINIT: steps, Newton iterations, steps that had to be cut into parts.
      integer(long) :: all_steps = 0, iterations = 0, cut_steps = 0
   end type place_t

   !> Bits of the second number of an array that NUINIT has filled: `NUTATE 1` in ASCII.
   integer(int64), parameter :: mark = int(z'4E55544154452031', int64)
   !> First numbers of the parts.
   integer, parameter :: setup_at = 3, body_at = 22, place_at = 52, state_at = 56, memory_at = 80

contains

   !> Numbers that the array must hold for a method that remembers `memory` of them.
   pure integer function work_size(memory)
      integer, intent(in) :: memory
      work_size = memory_at - 1 + memory
   end function work_size

   !> True if NUINIT has filled the array; false for any other numbers, whatever their bits.
   pure logical function is_work(work, n)
      integer, intent(in) :: n
      !> Shape (n).
      real(wp), intent(in) :: work(*)
      is_work = .false.
      if (n >= memory_at) is_work = transfer(work(2), 0_int64) == mark
   end function is_work

   !> True if a call starts where the last one stopped.
   pure logical function goes_on(work, t, q, p)
      real(wp), intent(in) :: work(*)
      !> s; attitude and conjugate momentum, shape (4).
      real(wp), intent(in) :: t, q(4), p(4)
      goes_on = work(place_at) > 0.5_wp .and. t == work(state_at) .and. &
                all(q == work(state_at + 1:state_at + 4)) .and. all(p == work(state_at + 5:state_at + 8))
   end function goes_on

   !> Writes the first part of the array.
   pure subroutine put_setup(setup, n, work)
      type(setup_t), intent(in) :: setup
      !> Numbers of the array in use.
      integer, intent(in) :: n
      real(wp), intent(inout) :: work(*)
      work(1) = real(n, wp)
      work(2) = transfer(mark, 0.0_wp)
      work(setup_at:setup_at + 3) = [real(setup%solver, wp), real(setup%order, wp), real(setup%callbacks, wp), &
                                     setup%inverse_j0]
      work(setup_at + 4:setup_at + 18) = [setup%gravity, setup%moment, setup%damping, setup%rotor, setup%direction]
      work(body_at:body_at + 8) = reshape(setup%body%inertia, [9])
      work(body_at + 9:body_at + 17) = reshape(setup%body%inverse_inertia, [9])
      work(body_at + 18:body_at + 26) = reshape(setup%body%axes, [9])
      work(body_at + 27:body_at + 29) = setup%body%moments
   end subroutine put_setup

   !> Reads the first part of the array.
   pure subroutine get_setup(work, setup)
      real(wp), intent(in) :: work(*)
      type(setup_t), intent(inout) :: setup
      integer :: i
      setup%solver = int(work(setup_at))
      setup%order = int(work(setup_at + 1))
      setup%callbacks = int(work(setup_at + 2))
      setup%inverse_j0 = work(setup_at + 3)
      setup%gravity = work(setup_at + 4:setup_at + 6)
      setup%moment = work(setup_at + 7:setup_at + 9)
      setup%damping = work(setup_at + 10:setup_at + 12)
      setup%rotor = work(setup_at + 13:setup_at + 15)
      setup%direction = work(setup_at + 16:setup_at + 18)
      do i = 1, 3
         setup%body%inertia(:, i) = work(body_at + 3*i - 3:body_at + 3*i - 1)
         setup%body%inverse_inertia(:, i) = work(body_at + 3*i + 6:body_at + 3*i + 8)
         setup%body%axes(:, i) = work(body_at + 3*i + 15:body_at + 3*i + 17)
      end do
      setup%body%moments = work(body_at + 27:body_at + 29)
   end subroutine get_setup

   !> Writes the second part of the array.
   pure subroutine put_place(place, work)
      type(place_t), intent(in) :: place
      real(wp), intent(inout) :: work(*)
      work(place_at) = merge(1.0_wp, 0.0_wp, place%begun)
      work(place_at + 1) = real(place%steps, wp)
      work(place_at + 2) = place%dt
      work(place_at + 3) = place%first_time
      work(state_at) = place%state%t
      work(state_at + 1:state_at + 4) = place%state%q
      work(state_at + 5:state_at + 8) = place%state%p
      work(state_at + 9:state_at + 12) = place%state%q_compensation
      work(state_at + 13:state_at + 16) = place%state%p_compensation
      work(state_at + 17) = place%work
      work(state_at + 18) = place%work_compensation
      work(state_at + 19) = real(place%all_steps, wp)
      work(state_at + 20) = real(place%iterations, wp)
      work(state_at + 21) = real(place%cut_steps, wp)
   end subroutine put_place

   !> Reads the second part of the array.
   pure subroutine get_place(work, place)
      real(wp), intent(in) :: work(*)
      type(place_t), intent(inout) :: place
      place%begun = work(place_at) > 0.5_wp
      place%steps = int(work(place_at + 1), long)
      place%dt = work(place_at + 2)
      place%first_time = work(place_at + 3)
      place%state%t = work(state_at)
      place%state%q = work(state_at + 1:state_at + 4)
      place%state%p = work(state_at + 5:state_at + 8)
      place%state%q_compensation = work(state_at + 9:state_at + 12)
      place%state%p_compensation = work(state_at + 13:state_at + 16)
      place%work = work(state_at + 17)
      place%work_compensation = work(state_at + 18)
      place%all_steps = int(work(state_at + 19), long)
      place%iterations = int(work(state_at + 20), long)
      place%cut_steps = int(work(state_at + 21), long)
   end subroutine get_place

end module nutate_f77_work
