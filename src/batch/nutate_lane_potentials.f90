!> Potentials of several bodies at once: linear in a direction, U = -m·Rᵀn (weight, dipoles, constant fields), or
!> quadratic in one, U = ½γᵀAγ + U₀ with γ = Rᵀn (the gravity gradient): one body a lane, each with its own numbers.
module nutate_lane_potentials
   use nutate_effect_list, only: effect_list_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   use nutate_linear_potential, only: linear_potential_t
   implicit none
   private

   public :: lane_potentials_t, are_lane_potentials, make_room, rest_potentials, put_potentials

   !> Potentials of each body, of the same kinds in all lanes.
   type :: lane_potentials_t
      !> How many.
      integer :: n = 0
      !> No lane has any.
      logical :: is_empty = .true.
      !> Which are quadratic; shape (n).
      logical, allocatable :: is_quadratic(:)
      !> n of each, space axes, and ∇U = -m of linear ones; shape (lanes, 3, n).
      real(wp), allocatable :: normal(:, :, :), slope(:, :, :)
      !> A and U₀ of quadratic ones, J; shapes (lanes, 3, 3, n) and (lanes, n).
      real(wp), allocatable :: stiffness(:, :, :, :), offset(:, :)
   end type lane_potentials_t

contains

   !> True if lanes know all potentials of a system: linear or quadratic, of directions that stand still.
   pure logical function are_lane_potentials(effects) result(known)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      known = .not. effects%moves
      do i = 1, effects%n_potentials
         select type (potential => effects%potentials(i)%item)
         class is (linear_potential_t)
            if (potential%moves) known = .false.
         type is (gravity_gradient_t)
            if (potential%moves) known = .false.
         class default
            known = .false.
         end select
      end do
   end function are_lane_potentials

   !> Makes room for n potentials of each body.
   pure subroutine make_room(self, n)
      class(lane_potentials_t), intent(inout) :: self
      integer, intent(in) :: n
      self%n = n
      self%is_empty = .true.
      if (allocated(self%slope)) deallocate (self%slope, self%normal, self%stiffness, self%offset, self%is_quadratic)
      allocate (self%slope(lanes, 3, n), self%normal(lanes, 3, n), self%stiffness(lanes, 3, 3, n), source=0.0_wp)
      allocate (self%offset(lanes, n), source=0.0_wp)
      allocate (self%is_quadratic(n), source=.false.)
   end subroutine make_room

   !> A lane without potentials.
   pure subroutine rest_potentials(self, lane)
      class(lane_potentials_t), intent(inout) :: self
      integer, intent(in) :: lane
      self%slope(lane, :, :) = 0.0_wp
      self%normal(lane, :, :) = 0.0_wp
      self%stiffness(lane, :, :, :) = 0.0_wp
      self%offset(lane, :) = 0.0_wp
   end subroutine rest_potentials

   !> Stores the potentials of a body, which are those of the other lanes but for their numbers.
   pure subroutine put_potentials(self, lane, effects, which, fits)
      class(lane_potentials_t), intent(inout) :: self
      integer, intent(in) :: lane
      !> Lanes know its potentials.
      type(effect_list_t), intent(in) :: effects
      !> Those to be taken.
      integer, intent(in) :: which(:)
      !> False: the body has others than the other lanes, and none is taken.
      logical, intent(out) :: fits
      logical :: is_quadratic(size(which))
      integer :: i
      fits = size(which) == self%n
      if (.not. fits) return
      do i = 1, self%n
         select type (potential => effects%potentials(which(i))%item)
         type is (gravity_gradient_t)
            is_quadratic(i) = .true.
         class default
            is_quadratic(i) = .false.
         end select
      end do
      if (self%is_empty) self%is_quadratic = is_quadratic
      fits = all(is_quadratic .eqv. self%is_quadratic)
      if (.not. fits) return
      self%is_empty = .false.
      do i = 1, self%n
         select type (potential => effects%potentials(which(i))%item)
         class is (linear_potential_t)
            self%slope(lane, :, i) = -potential%moment
            self%normal(lane, :, i) = potential%direction
         type is (gravity_gradient_t)
            self%stiffness(lane, :, :, i) = potential%stiffness
            self%offset(lane, i) = potential%offset
            self%normal(lane, :, i) = potential%direction
         end select
      end do
   end subroutine put_potentials

end module nutate_lane_potentials
