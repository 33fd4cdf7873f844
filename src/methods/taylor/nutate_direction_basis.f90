!> Orthonormal basis of the directions of effects in space, by the Gram-Schmidt method.
module nutate_direction_basis
   use nutate_effect, only: GENERAL_SERIES, LINEAR_SERIES, SPACE_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: parallel
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross
   implicit none
   private

   public :: choose_basis

contains

   !> Computes a basis of the directions by the Gram-Schmidt method, completed to a right-handed one.
   pure subroutine choose_basis(effects, basis, rank)
      type(effect_list_t), intent(in) :: effects
      !> Basis vectors as columns, space axes; the first `rank` of them span the directions; shape (3,3).
      real(wp), intent(inout) :: basis(3, 3)
      integer, intent(out) :: rank
      integer :: i, kind
      rank = 0
      do kind = LINEAR_SERIES, GENERAL_SERIES
         do i = 1, effects%n_potentials
            associate (potential => effects%potentials(i)%item)
               if (potential%series_kind() == kind) call add_direction(basis, rank, potential%direction)
               if (potential%moves) call add_all_directions(basis, rank)
            end associate
         end do
      end do
      do i = 1, effects%n_torques
         call add_direction(basis, rank, effects%torques(i)%item%series_direction())
         if (effects%torques(i)%item%series_kind() == SPACE_SERIES .or. effects%torques(i)%item%moves) &
            call add_all_directions(basis, rank)
      end do
      associate (e => basis)
         if (rank == 0) e(:, 1) = [0.0_wp, 0.0_wp, 1.0_wp]
         if (rank < 2) then
            e(:, 2) = 0.0_wp
            e(minloc(abs(e(:, 1)), 1), 2) = 1.0_wp
            e(:, 2) = cross(e(:, 2), e(:, 1))
            e(:, 2) = e(:, 2)/norm2(e(:, 2))
         end if
         e(:, 3) = cross(e(:, 1), e(:, 2))
      end associate
   end subroutine choose_basis

   !> Extends a basis to all of space.
   pure subroutine add_all_directions(basis, rank)
      !> Basis vectors as columns, space axes, of which `rank` are set; shape (3,3).
      real(wp), intent(inout) :: basis(3, 3)
      integer, intent(inout) :: rank
      integer :: i
      do i = 1, 3
         call add_direction(basis, rank, merge(1.0_wp, 0.0_wp, [1, 2, 3] == i))
      end do
   end subroutine add_all_directions

   !> Adds a direction to a basis, unless it lies in its span.
   pure subroutine add_direction(basis, rank, direction)
      !> Basis vectors as columns, space axes, of which `rank` are set; shape (3,3).
      real(wp), intent(inout) :: basis(3, 3)
      integer, intent(inout) :: rank
      !> Direction, space axes; shape (3).
      real(wp), intent(in) :: direction(3)
      real(wp) :: rest(3), scale
      integer :: i, pass
      scale = maxval(abs(direction))
      if (rank == 3 .or. scale <= 0.0_wp) return
      rest = direction/scale
      scale = norm2(rest)
      do pass = 1, 2
         do i = 1, rank
            rest = rest - dot_product(rest, basis(:, i))*basis(:, i)
         end do
      end do
      if (norm2(rest) <= parallel*scale) return
      rank = rank + 1
      basis(:, rank) = rest/norm2(rest)
   end subroutine add_direction

end module nutate_direction_basis
