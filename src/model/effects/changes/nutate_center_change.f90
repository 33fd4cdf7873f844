!> A centre of mass that moves in the body with time, by a table. The potential of gravity about a pivot then depends on
!> time, V = -m g·R(q)c(t).
module nutate_center_change
   use nutate_effect, only: torque_t, LINEAR_SERIES
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_piecewise, only: clamped_term, interval_around, next_point, piecewise_t
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: make_body_curve
   implicit none
   private

   public :: center_change_t, make_tabulated_center

   !> Path of the centre of mass; it exerts no torque by itself. `make_tabulated_center` makes one.
   type, extends(torque_t) :: center_change_t
      !> Position in body axes, m.
      type(piecewise_t) :: curve
   contains
      !> Returns the centre of mass at a time.
      procedure :: center_at
      procedure :: torque => no_torque
      procedure :: derivatives => no_derivatives
      procedure :: is_valid => path_is_valid
      procedure :: needs_attitude => never_needed
      procedure :: window => path_window
      procedure :: own_ends => no_own_ends
      procedure :: piece => path_piece
      procedure :: next_break => path_break
      procedure :: series_kind => linear_kind
      !> Returns a coefficient of the power series of the displacement since t = 0.
      procedure :: displacement_term
   end type center_change_t

contains

   !> Makes the path that a table describes: straight lines or a natural spline between its times, the nearest end
   !> outside of them. The body is made with the centre of mass at t = 0, `center_at(0.0_wp)`. Errors: those of
   !> `make_body_curve`.
   subroutine make_tabulated_center(times, positions, change, status, at, spline)
      !> Times, s; shape (n).
      real(wp), intent(in) :: times(:)
      !> Centre of mass, body axes, m; shape (3, n).
      real(wp), intent(in) :: positions(:, :)
      type(center_change_t), intent(inout) :: change
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 for none.
      integer, intent(out) :: at
      !> A cubic spline, not linear interpolation; default `.false.`.
      logical, intent(in), optional :: spline
      logical :: smooth
      smooth = .false.
      if (present(spline)) smooth = spline
      change%name = 'center_of_mass_table'
      change%moves_center = .true.
      change%is_internal = .true.
      call make_body_curve(times, positions, smooth, 'the centre of mass', 'center_of_mass_table', change%curve, &
                           status, at)
   end subroutine make_tabulated_center

   !> Returns the centre of mass at a time, body axes, m; shape (3).
   pure function center_at(self, t) result(center)
      class(center_change_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: center(3)
      center = clamped_term(self%curve, 0, t, t, 1.0_wp)
   end function center_at

   !> Returns coefficient j of the power series of the displacement since t = 0, body axes, m; shape (3): the j-th
   !> derivative times unitʲ/j!.
   pure function displacement_term(self, j, t, moment, unit) result(term)
      class(center_change_t), intent(in) :: self
      integer, intent(in) :: j
      !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: term(3)
      term = clamped_term(self%curve, j, t, moment, unit)
      if (j == 0) term = term - self%center_at(0.0_wp)
   end function displacement_term

   !> Returns zero.
   pure function no_torque(self, t, q, omega) result(tau)
      class(center_change_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
   end function no_torque

   !> Computes zeros.
   pure subroutine no_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(center_change_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
   end subroutine no_derivatives

   !> Returns true if the positions can be computed with.
   pure logical function path_is_valid(self)
      class(center_change_t), intent(in) :: self
      path_is_valid = self%curve%n > 0
      if (path_is_valid) path_is_valid = all(is_moderate(self%curve%c)) .and. all(is_moderate(self%curve%x))
   end function path_is_valid

   !> Returns false.
   pure logical function never_needed(self)
      class(center_change_t), intent(in) :: self
      never_needed = .false.
   end function never_needed

   !> Returns the times of the table, s.
   pure subroutine path_window(self, start, stop)
      class(center_change_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%curve%x(0)
      stop = self%curve%x(self%curve%n)
   end subroutine path_window

   !> Returns false: there are no derivatives with respect to the ends of the window.
   pure function no_own_ends(self) result(own)
      class(center_change_t), intent(in) :: self
      logical :: own(2)
      own = .false.
   end function no_own_ends

   !> Returns the interval around a time in which the path is one polynomial, s.
   pure subroutine path_piece(self, moment, start, stop)
      class(center_change_t), intent(in) :: self
      real(wp), intent(in) :: moment
      real(wp), intent(out) :: start, stop
      call interval_around(self%curve, moment, start, stop)
   end subroutine path_piece

   !> Returns the next time of the table, s.
   pure real(wp) function path_break(self, t, sense) result(next)
      class(center_change_t), intent(in) :: self
      real(wp), intent(in) :: t, sense
      next = next_point(self%curve, t, sense)
   end function path_break

   !> Returns `LINEAR_SERIES`: the torque is zero times Ω.
   pure integer function linear_kind(self)
      class(center_change_t), intent(in) :: self
      linear_kind = LINEAR_SERIES
   end function linear_kind

end module nutate_center_change
