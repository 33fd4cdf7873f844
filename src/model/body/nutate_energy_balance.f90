!> The energy balance of a motion, which is stored with its state: the target values of the invariants, and the attitude
!> and momentum to which they apply. Only the projection onto the invariants reads and writes it.
module nutate_energy_balance
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   implicit none
   private

   public :: energy_balance_t, energy_scale_t, energy_sum_t

   !> An energy as a compensated sum, J.
   type :: energy_sum_t
      real(wp) :: energy = 0.0_wp, compensation = 0.0_wp
   end type energy_sum_t

   !> Largest T + Σ|U| so far, J; the largest of it and |L̇|, and the power of two that scales the latter to order one.
   type :: energy_scale_t
      real(wp) :: size = 0.0_wp, largest = 0.0_wp, to_order_one = 1.0_wp
   end type energy_scale_t

   !> The balance of one motion of one system. A state with a closed balance starts a new one in its next step.
   type :: energy_balance_t
      logical :: open = .false.
      !> The state is a projected copy of the one that the last step left (`left_q`, ...).
      logical :: projected = .false.
      !> Steps since the last projection, and from the last to the next one.
      integer :: count = 0, interval = 1
      !> H₀ + work.
      type(energy_sum_t) :: energy = energy_sum_t()
      type(energy_scale_t) :: scale = energy_scale_t()
      !> Conserved l, space axes, N m s, shape (3), at a time, s; its component l·n, or else |l|, N m s.
      real(wp) :: momentum(3) = 0.0_wp, momentum_time = 0.0_wp, component = 0.0_wp
      !> Attitude and momentum of the state that the balance belongs to, shape (4), and momenta of its wheels.
      real(wp) :: q(4) = 0.0_wp, p(4) = 0.0_wp, wheels(most_inner) = 0.0_wp
      !> Attitude and momentum that the last step left, and their compensations, if the state is a projected copy; shape
      !> (4).
      real(wp), dimension(4) :: left_q = 0.0_wp, left_p = 0.0_wp
      real(wp), dimension(4) :: left_q_compensation = 0.0_wp, left_p_compensation = 0.0_wp
   contains
      !> Copies another balance.
      procedure, non_overridable :: copy_from
      !> Writes or reads all values in checkpoint data.
      procedure, non_overridable :: transfer
   end type energy_balance_t

contains

   !> Copies another balance without the values that are not in use, which costs less than an assignment.
   pure subroutine copy_from(self, other, n_wheels)
      class(energy_balance_t), intent(inout) :: self
      type(energy_balance_t), intent(in) :: other
      !> Number of momenta of wheels and inner spheres.
      integer, intent(in) :: n_wheels
      self%open = other%open
      self%projected = other%projected
      self%count = other%count
      self%interval = other%interval
      self%energy = other%energy
      self%scale = other%scale
      self%momentum = other%momentum
      self%momentum_time = other%momentum_time
      self%component = other%component
      self%q = other%q
      self%p = other%p
      if (n_wheels > 0) self%wheels(:n_wheels) = other%wheels(:n_wheels)
      if (.not. other%projected) return
      self%left_q = other%left_q
      self%left_p = other%left_p
      self%left_q_compensation = other%left_q_compensation
      self%left_p_compensation = other%left_p_compensation
   end subroutine copy_from

   !> Writes or reads all values in checkpoint data.
   subroutine transfer(self, archive)
      class(energy_balance_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%open)
      call archive%transfer(self%projected)
      call archive%transfer(self%count)
      call archive%transfer(self%interval)
      call archive%transfer(self%energy%energy)
      call archive%transfer(self%energy%compensation)
      call archive%transfer(self%scale%size)
      call archive%transfer(self%scale%largest)
      call archive%transfer(self%scale%to_order_one)
      call archive%transfer(self%momentum)
      call archive%transfer(self%momentum_time)
      call archive%transfer(self%component)
      call archive%transfer(self%q)
      call archive%transfer(self%p)
      call archive%transfer(self%wheels)
      call archive%transfer(self%left_q)
      call archive%transfer(self%left_p)
      call archive%transfer(self%left_q_compensation)
      call archive%transfer(self%left_p_compensation)
   end subroutine transfer

end module nutate_energy_balance
