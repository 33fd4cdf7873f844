!> The torque of potentials as power series in time, of several bodies at once: one body a lane, each with its own
!> numbers.
!>
!> The arithmetic is that of `add_torque` in `nutate_motion_series`: linear potentials are merged into moments on the
!> three rows `R(q)ᵀeᵢ`; a gravity gradient adds the products of γ and Aγ, γ a sum of the rows.
module nutate_lane_torque_series
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   use nutate_power_series, only: highest_order
   use nutate_system, only: system_t
   use nutate_torque_series, only: torque_series_t
   implicit none
   private

   public :: lane_torques_t, gradient_series_t, set_up_torques, rest_torques, put_torques, add_torques

   !> What acts on each body.
   type :: lane_torques_t
      private
      !> Δt, s.
      real(wp) :: dt = 0.0_wp
      !> How many rows linear potentials act along, in any lane; moments times Δt as columns, shape (lanes, 3, 3).
      integer :: n_moments = 0
      real(wp) :: moments(lanes, 3, 3) = 0.0_wp
      !> There is a gravity gradient, in all lanes; its direction in the basis, and A, J; shapes (lanes, 3) and
      !> (lanes, 3, 3).
      logical :: has_gradient = .false.
      real(wp) :: components(lanes, 3) = 0.0_wp, stiffness(lanes, 3, 3) = 0.0_wp
   end type lane_torques_t

   !> γ and Aγ in a step. No component has a first value: they would be set at every step.
   type :: gradient_series_t
      private
      real(wp) :: gamma(lanes, 3, 0:highest_order), slope(lanes, 3, 0:highest_order)
   end type gradient_series_t

contains

   !> For bodies that are to come.
   pure subroutine set_up_torques(self, dt)
      type(lane_torques_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      self%dt = dt
      self%n_moments = 0
   end subroutine set_up_torques

   !> A body on which nothing acts.
   pure subroutine rest_torques(self, lane)
      type(lane_torques_t), intent(inout) :: self
      integer, intent(in) :: lane
      self%moments(lane, :, :) = 0.0_wp
      self%components(lane, :) = 0.0_wp
      self%stiffness(lane, :, :) = 0.0_wp
   end subroutine rest_torques

   !> Stores what acts on a body.
   pure subroutine put_torques(self, lane, is_first, system, torques, bound, fits)
      type(lane_torques_t), intent(inout) :: self
      integer, intent(in) :: lane
      !> The body is the first one, which says whether there is a gravity gradient.
      logical, intent(in) :: is_first
      !> Lanes know its potentials.
      type(system_t), intent(in) :: system
      !> Prepared for it.
      type(torque_series_t), intent(in) :: torques
      !> The torque times Δt is no larger, N m s.
      real(wp), intent(out) :: bound
      !> False: the other bodies have a gradient and this one none, or vice versa; or there are several.
      logical, intent(out) :: fits
      integer :: i, n
      n = 0
      do i = 1, system%effects%n_potentials
         select type (potential => system%effects%potentials(i)%item)
         class is (gravity_gradient_t)
            n = n + 1
            self%stiffness(lane, :, :) = potential%stiffness
         end select
      end do
      if (is_first) self%has_gradient = n > 0
      fits = n <= 1 .and. (self%has_gradient .eqv. n > 0)
      if (n > 0) self%components(lane, :) = torques%components(:, 1)
      self%moments(lane, :, :) = self%dt*torques%moments
      self%n_moments = max(self%n_moments, torques%n_moments)
      bound = sum(abs(self%moments(lane, :, :))) + abs(self%dt)*sum(abs(self%stiffness(lane, :, :)))
   end subroutine put_torques

   !> Adds coefficient k of the torque times Δt.
   pure subroutine add_torques(self, k, rows, gradient, sums)
      type(lane_torques_t), intent(in) :: self
      integer, intent(in) :: k
      !> The rows up to coefficient k; shape (lanes, 3, 0:highest_order, 3).
      real(wp), intent(in) :: rows(lanes, 3, 0:highest_order, 3)
      !> The series up to coefficient k - 1; on exit with k.
      type(gradient_series_t), intent(inout) :: gradient
      !> Shape (lanes, 3).
      real(wp), intent(inout) :: sums(lanes, 3)
      real(wp) :: tau(lanes, 3), more(lanes, 3)
      integer :: i
      tau = 0.0_wp
      do i = 1, self%n_moments
         call add_moment(self%moments(:, :, i), rows(:, :, k, i), tau)
      end do
      if (self%has_gradient) then
         call see_gradient(self%components, self%stiffness, rows(:, :, k, 1), rows(:, :, k, 2), rows(:, :, k, 3), &
                           gradient%gamma(:, :, k), gradient%slope(:, :, k))
         call multiply_series(k, gradient%gamma, gradient%slope, more)
         call add_lanes(self%dt, more, tau)
      end if
      call add_lanes(1.0_wp, tau, sums)
   end subroutine add_torques

   !> Adds m×E.
   pure subroutine add_moment(moment, e, tau)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: moment(lanes, 3), e(lanes, 3)
      real(wp), intent(inout) :: tau(lanes, 3)
      integer :: i
      do i = 1, lanes
         tau(i, 1) = tau(i, 1) + (moment(i, 2)*e(i, 3) - moment(i, 3)*e(i, 2))
         tau(i, 2) = tau(i, 2) + (moment(i, 3)*e(i, 1) - moment(i, 1)*e(i, 3))
         tau(i, 3) = tau(i, 3) + (moment(i, 1)*e(i, 2) - moment(i, 2)*e(i, 1))
      end do
   end subroutine add_moment

   !> γ and Aγ.
   pure subroutine see_gradient(components, stiffness, e1, e2, e3, gamma, slope)
      !> Of the direction, A, and the rows; shapes (lanes, 3) and (lanes, 3, 3).
      real(wp), intent(in) :: components(lanes, 3), stiffness(lanes, 3, 3), e1(lanes, 3), e2(lanes, 3), e3(lanes, 3)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: gamma(lanes, 3), slope(lanes, 3)
      real(wp) :: g1, g2, g3
      integer :: i
      do i = 1, lanes
         g1 = e1(i, 1)*components(i, 1) + e2(i, 1)*components(i, 2) + e3(i, 1)*components(i, 3)
         g2 = e1(i, 2)*components(i, 1) + e2(i, 2)*components(i, 2) + e3(i, 2)*components(i, 3)
         g3 = e1(i, 3)*components(i, 1) + e2(i, 3)*components(i, 2) + e3(i, 3)*components(i, 3)
         gamma(i, 1) = g1
         gamma(i, 2) = g2
         gamma(i, 3) = g3
         slope(i, 1) = stiffness(i, 1, 1)*g1 + stiffness(i, 1, 2)*g2 + stiffness(i, 1, 3)*g3
         slope(i, 2) = stiffness(i, 2, 1)*g1 + stiffness(i, 2, 2)*g2 + stiffness(i, 2, 3)*g3
         slope(i, 3) = stiffness(i, 3, 1)*g1 + stiffness(i, 3, 2)*g2 + stiffness(i, 3, 3)*g3
      end do
   end subroutine see_gradient

   !> Coefficient k of γ×Aγ. The loop over products is left at its end, as in `nutate_lane_row_series`.
   pure subroutine multiply_series(k, gamma, slope, product)
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(lanes, 3, 0:highest_order), slope(lanes, 3, 0:highest_order)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: product(lanes, 3)
      real(wp) :: s1, s2, s3
      integer :: i, j
      do i = 1, lanes
         s1 = 0.0_wp
         s2 = 0.0_wp
         s3 = 0.0_wp
         j = 0
         do
            s1 = s1 + (gamma(i, 2, j)*slope(i, 3, k - j) - gamma(i, 3, j)*slope(i, 2, k - j))
            s2 = s2 + (gamma(i, 3, j)*slope(i, 1, k - j) - gamma(i, 1, j)*slope(i, 3, k - j))
            s3 = s3 + (gamma(i, 1, j)*slope(i, 2, k - j) - gamma(i, 2, j)*slope(i, 1, k - j))
            j = j + 1
            if (j > k) exit
         end do
         product(i, 1) = s1
         product(i, 2) = s2
         product(i, 3) = s3
      end do
   end subroutine multiply_series

   !> Adds a multiple.
   pure subroutine add_lanes(factor, x, sums)
      real(wp), intent(in) :: factor
      !> Shape (lanes, 3).
      real(wp), intent(in) :: x(lanes, 3)
      real(wp), intent(inout) :: sums(lanes, 3)
      integer :: i
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + factor*x(i, 1)
         sums(i, 2) = sums(i, 2) + factor*x(i, 2)
         sums(i, 3) = sums(i, 3) + factor*x(i, 3)
      end do
   end subroutine add_lanes

end module nutate_lane_torque_series
