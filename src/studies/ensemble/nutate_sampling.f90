!> The numbers in which a member of an ensemble differs, from the seed and its number alone.
module nutate_sampling
   use nutate_ensemble_plan, only: ensemble_plan_t, varied_key_t, CASES, GRID, NORMAL, ROTATION
   use nutate_keys, only: KEY_INTEGER
   use nutate_kinds, only: wp, long
   use nutate_normal_quantile, only: normal_quantile
   use nutate_permutation, only: permuted
   use nutate_philox, only: uniform_of
   implicit none
   private

   public :: draw_values

contains

   !> Draws the values of all targets of a member. Values of integer keys are rounded to the nearest integer.
   pure subroutine draw_values(plan, member, values)
      type(ensemble_plan_t), intent(in) :: plan
      !> Number of the member, 1 to `plan%members`.
      integer(long), intent(in) :: member
      !> Values of the targets; shape (targets).
      real(wp), intent(out) :: values(:)
      integer(long) :: place
      integer :: i, last
      place = member - 1
      do i = size(plan%variations), 1, -1
         associate (variation => plan%variations(i))
            last = variation%first + variation%n - 1
            if (variation%distribution == GRID) then
               call set_grid_values(variation, place, values(variation%first:last))
            else
               call draw(plan, variation, member, values(variation%first:last))
            end if
         end associate
      end do
      do i = 1, size(values)
         if (plan%targets(i)%key%kind == KEY_INTEGER) values(i) = anint(values(i))
      end do
   end subroutine draw_values

   !> Draws the values of one distribution that is no grid. The number of a draw is the index of its target.
   pure subroutine draw(plan, variation, member, values)
      type(ensemble_plan_t), intent(in) :: plan
      type(varied_key_t), intent(in) :: variation
      integer(long), intent(in) :: member
      !> Values drawn together; shape (numbers drawn together).
      real(wp), intent(out) :: values(:)
      real(wp) :: u(size(values))
      integer :: i, k
      if (variation%distribution == CASES) then
         values = variation%cases(:, member)
         return
      end if
      do i = 1, variation%n
         k = variation%first + i - 1
         u(i) = uniform_of(plan%seed, member, k)
         if (plan%latin) u(i) = (real(permuted(member, plan%members, plan%seed, k) - 1, wp) + u(i))/ &
                                real(plan%members, wp)
      end do
      select case (variation%distribution)
      case (NORMAL)
         u = normal_quantile(u)
         do i = 1, variation%n
            values(i) = variation%low(i) + sum(variation%factor(i, :i)*u(:i))
         end do
      case (ROTATION)
         ! Four normal deviates point in every direction alike.
         u = normal_quantile(u)
         values = u/sqrt(sum(u**2))
      case default
         values = variation%low + (variation%high - variation%low)*u
      end select
   end subroutine draw

   !> Sets the values at a position in a grid, the last target running fastest.
   pure subroutine set_grid_values(variation, place, values)
      type(varied_key_t), intent(in) :: variation
      !> Position in the grid, from 0 on; on exit, the position for the grids before this one.
      integer(long), intent(inout) :: place
      real(wp), intent(out) :: values(:)
      integer(long) :: at
      integer :: i
      do i = variation%n, 1, -1
         at = mod(place, int(variation%points(i), long))
         place = place/variation%points(i)
         values(i) = variation%low(i)
         if (at > 0) values(i) = variation%low(i) + (variation%high(i) - variation%low(i))* &
                                 (real(at, wp)/real(variation%points(i) - 1, wp))
         if (at > 0 .and. at == variation%points(i) - 1) values(i) = variation%high(i)
      end do
   end subroutine set_grid_values

end module nutate_sampling
