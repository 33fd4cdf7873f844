!> The effects that are active: sorted once by what the equations need of them, so that what is absent is never asked.
module nutate_effect_list
   use nutate_effect, only: effect_t, potential_t, torque_t, rotor_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: effect_list_t, potential_slot_t, torque_slot_t

   !> Holds one potential.
   type :: potential_slot_t
      class(potential_t), allocatable :: item
   end type potential_slot_t

   !> Holds one torque.
   type :: torque_slot_t
      class(torque_t), allocatable :: item
   end type torque_slot_t

   !> All active effects. Several of a kind add up.
   type :: effect_list_t
      !> Number of potentials in use.
      integer :: n_potentials = 0
      !> Number of torques in use.
      integer :: n_torques = 0
      !> Number of rotors added.
      integer :: n_rotors = 0
      type(potential_slot_t), allocatable :: potentials(:)
      type(torque_slot_t), allocatable :: torques(:)
      !> h: sum of the rotors' momenta, body axes, N m s; shape (3).
      real(wp) :: rotor_momentum(3) = 0.0_wp
   contains
      !> Adds a copy of an effect.
      procedure :: add
      !> True if the motion depends on the attitude.
      procedure :: needs_attitude
      !> Times between two times at which a torque starts or stops.
      procedure :: find_breaks
   end type effect_list_t

contains

   !> Adds a copy of an effect: of a `potential_t`, `torque_t` or `rotor_t`, or any extension of these.
   subroutine add(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(effect_t), intent(in) :: effect
      select type (effect)
      class is (potential_t)
         call add_potential(self, effect)
      class is (torque_t)
         call add_torque(self, effect)
      class is (rotor_t)
         self%n_rotors = self%n_rotors + 1
         self%rotor_momentum = self%rotor_momentum + effect%momentum
      end select
   end subroutine add

   !> True if there is a potential, or a torque that depends on the attitude.
   pure logical function needs_attitude(self)
      class(effect_list_t), intent(in) :: self
      integer :: i
      needs_attitude = self%n_potentials > 0
      do i = 1, self%n_torques
         if (self%torques(i)%item%needs_attitude()) needs_attitude = .true.
      end do
   end function needs_attitude

   !> Times between two times at which a torque starts or stops, in the order in which they are reached.
   pure subroutine find_breaks(self, t_first, t_last, breaks)
      class(effect_list_t), intent(in) :: self
      !> s; the last may come before the first.
      real(wp), intent(in) :: t_first, t_last
      !> s; shape (any).
      real(wp), allocatable, intent(out) :: breaks(:)
      real(wp) :: window(2), earliest
      integer :: i, k
      allocate (breaks(0))
      do i = 1, self%n_torques
         call self%torques(i)%item%window(window(1), window(2))
         breaks = [breaks, pack(window, window > min(t_first, t_last) .and. window < max(t_first, t_last))]
      end do
      do i = 1, size(breaks) - 1
         k = i - 1 + minloc(sign(1.0_wp, t_last - t_first)*breaks(i:), 1)
         earliest = breaks(k)
         breaks(k) = breaks(i)
         breaks(i) = earliest
      end do
   end subroutine find_breaks

   subroutine add_potential(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(potential_t), intent(in) :: effect
      type(potential_slot_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%n_potentials + 1))
      do i = 1, self%n_potentials
         call move_alloc(self%potentials(i)%item, grown(i)%item)
      end do
      allocate (grown(self%n_potentials + 1)%item, source=effect)
      call move_alloc(grown, self%potentials)
      self%n_potentials = self%n_potentials + 1
   end subroutine add_potential

   subroutine add_torque(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(torque_t), intent(in) :: effect
      type(torque_slot_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%n_torques + 1))
      do i = 1, self%n_torques
         call move_alloc(self%torques(i)%item, grown(i)%item)
      end do
      allocate (grown(self%n_torques + 1)%item, source=effect)
      call move_alloc(grown, self%torques)
      self%n_torques = self%n_torques + 1
   end subroutine add_torque

end module nutate_effect_list
