!> Changes of the torques of `nutate_torque_series` by changes of the parameters of effects, for sensitivities.
module nutate_torque_changes
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   use nutate_quaternion, only: cross
   use nutate_reshaped_series, only: degree, reshaped_series_t
   use nutate_small_products, only: deviator, times_vector
   use nutate_torque_series, only: torque_series_t
   use nutate_variation, only: reshaping_term, variation_t
   implicit none
   private

   public :: torque_changes_t

   !> Torques of a system, and the changes of their directions.
   type, extends(torque_series_t) :: torque_changes_t
      private
      !> Series of δn caused by changes of parameters, in the basis, and of R(q)ᵀδn, shape (3, 0:highest_order, any);
      !> true for those that are not zero, and for those that are known.
      real(wp), allocatable :: shift(:, :, :), shifted(:, :, :)
      logical, allocatable :: shifts(:), shift_known(:)
      !> Changes of the varying parts of potentials by each sensitivity; shape (any).
      type(reshaped_series_t), allocatable :: reshaped(:)
   contains
      !> Allocates the changes of parameters.
      procedure :: expect_changes
      !> Compute a coefficient of the change of the torque of one effect by changes of parameters.
      procedure :: potential_change
      procedure :: torque_change
      !> Adds a coefficient of the change of the torque of varying potentials by a sensitivity.
      procedure :: add_reshaped
   end type torque_changes_t

contains

   !> Allocates the changes of parameters of a number of effects by a number of sensitivities.
   pure subroutine expect_changes(self, effects, n, parametric)
      class(torque_changes_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: n, parametric
      if (effects%reshapes) call expect_reshaped(self, effects, parametric)
      if (allocated(self%shifts)) then
         if (size(self%shifts) == n) return
         deallocate (self%shift, self%shifted, self%shifts, self%shift_known)
      end if
      allocate (self%shift(3, 0:highest_order, n), self%shifted(3, 0:highest_order, n), source=0.0_wp)
      allocate (self%shifts(n), self%shift_known(n), source=.false.)
   end subroutine expect_changes

   !> Allocates the changes of the varying parts of potentials.
   pure subroutine expect_reshaped(self, effects, parametric)
      class(torque_changes_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Number of sensitivities that change a parameter.
      integer, intent(in) :: parametric
      integer :: m
      if (allocated(self%reshaped)) then
         if (size(self%reshaped) == parametric) return
         deallocate (self%reshaped)
      end if
      allocate (self%reshaped(parametric))
      do m = 1, parametric
         call self%reshaped(m)%prepare(effects)
      end do
   end subroutine expect_reshaped

   !> Computes coefficient k of the change of the torque of a potential by a change of its parameters; called after
   !> `add_derivatives`.
   pure subroutine potential_change(self, effects, i, change, place, k, order, time_unit, rows, tau, known)
      class(torque_changes_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index in the list.
      integer, intent(in) :: i
      real(wp), intent(in) :: change(:)
      !> Index among the expected changes; coefficient, and the highest one.
      integer, intent(in) :: place, k, order
      real(wp), intent(in) :: time_unit
      !> Coefficients 0..k of the rows R(q)ᵀeᵢ as columns; shape (3, 3, 0:k).
      real(wp), intent(in) :: rows(3, 3, 0:k)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp) :: gamma(3, 0:k), moved(3, 0:order), none(0:k, 0)
      integer :: j, n
      associate (potential => effects%potentials(i)%item)
         if (k == 0) then
            call potential%direction_change_series(change, self%start, time_unit, moved, self%shift_known(place))
            call keep_shift(self, place, moved)
         end if
         call turn_shift(self, place, k, rows)
         n = findloc(self%general(:self%n_general), i, 1)
         if (n > 0) then
            n = self%slot(n)
            call potential%series_change(change, k, self%gamma(:, 0:k, n), self%auxiliary(n)%values, tau, known)
            call add_shift(self, place, k, n, tau)
         else
            do j = 0, k
               gamma(:, j) = times_vector(rows(:, :, j), matmul(potential%direction, self%basis))
            end do
            call potential%series_change(change, k, gamma, none, tau, known)
            tau = tau + cross(potential%series_moment(), self%shifted(:, k, place))
         end if
      end associate
      known = known .and. self%shift_known(place)
   end subroutine potential_change

   !> Stores the series of the change of a direction.
   pure subroutine keep_shift(self, place, n)
      class(torque_changes_t), intent(inout) :: self
      integer, intent(in) :: place
      !> Space axes; shape (3, 0:order).
      real(wp), intent(in) :: n(:, 0:)
      self%shift(:, :ubound(n, 2), place) = matmul(transpose(self%basis), n)
      self%shifts(place) = any(abs(n) > 0.0_wp)
   end subroutine keep_shift

   !> Computes coefficient k of the change of a direction in body axes.
   pure subroutine turn_shift(self, place, k, rows)
      class(torque_changes_t), intent(inout) :: self
      integer, intent(in) :: place, k
      !> Coefficients 0..k of the rows R(q)ᵀeᵢ as columns.
      real(wp), intent(in) :: rows(3, 3, 0:k)
      real(wp) :: sum(3)
      integer :: j
      sum = 0.0_wp
      if (self%shifts(place)) then
         do j = 0, k
            if (any(abs(self%shift(:, j, place)) > 0.0_wp)) &
               sum = sum + times_vector(rows(:, :, k - j), self%shift(:, j, place))
         end do
      end if
      self%shifted(:, k, place) = sum
   end subroutine turn_shift

   !> Computes coefficient k of the change of a torque that acts by a change of its parameters; called after
   !> `add_derivatives`.
   pure subroutine torque_change(self, effects, i, change, place, k, order, time_unit, rows, tau, known)
      class(torque_changes_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index in the list.
      integer, intent(in) :: i
      real(wp), intent(in) :: change(:)
      !> Index among the expected changes; coefficient, and the highest one.
      integer, intent(in) :: place, k, order
      real(wp), intent(in) :: time_unit
      !> Coefficients 0..k of the rows R(q)ᵀeᵢ as columns; shape (3, 3, 0:k).
      real(wp), intent(in) :: rows(3, 3, 0:k)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp), parameter :: unturned(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      real(wp) :: moved(3, 0:order)
      integer :: n
      n = self%torque_slot(i)
      associate (torque => effects%torques(i)%item)
         known = n >= 0
         tau = 0.0_wp
         if (n == 0) tau = torque%torque_change(change, 0.0_wp, unturned, self%omega(:, k))
         if (n <= 0) return
         call torque%series_change(change, k, self%start, time_unit, self%gamma(:, 0:k, n), &
                                      self%auxiliary(n)%values, tau, known)
         if (k == 0) then
            call torque%direction_change_series(change, self%start, time_unit, moved)
            call keep_shift(self, place, moved)
         end if
         call turn_shift(self, place, k, rows)
         call add_shift(self, place, k, n, tau)
      end associate
   end subroutine torque_change

   !> Adds coefficient k of γ×(δEγ - δe) of the potentials that vary with the body.
   pure subroutine add_reshaped(self, effects, variation, inertia, m, k, time_unit, tau)
      class(torque_changes_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(variation_t), intent(in) :: variation
      !> Change of J at the start, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      !> Index among the sensitivities that change a parameter; coefficient.
      integer, intent(in) :: m, k
      real(wp), intent(in) :: time_unit
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      real(wp) :: one(3)
      integer :: i, j, n
      associate (series => self%reshaped(m))
         do n = 1, self%n_general
            i = self%general(n)
            if (.not. effects%potentials(i)%item%varies) cycle
            do j = 0, merge(degree, -1, k == 0)
               call reshaping_term(variation, effects, i, j, self%start, self%moment, time_unit, inertia, &
                                   series%stiffness(:, :, j, i), series%push(:, j, i))
               series%stiffness(:, :, j, i) = deviator(series%stiffness(:, :, j, i))
            end do
            call series%get_torque(i, k, self%gamma(:, 0:k, self%slot(n)), one)
            tau = tau + one
         end do
      end associate
   end subroutine add_reshaped

   !> Adds coefficient k of (∂τ/∂γ)R(q)ᵀδn of one slot.
   pure subroutine add_shift(self, place, k, n, tau)
      class(torque_changes_t), intent(in) :: self
      integer, intent(in) :: place, k, n
      real(wp), intent(inout) :: tau(3)
      integer :: j
      if (.not. self%shifts(place)) return
      do j = 0, k
         tau = tau + times_vector(self%derivative(:, :, k - j, n), self%shifted(:, j, place))
      end do
   end subroutine add_shift

end module nutate_torque_changes
