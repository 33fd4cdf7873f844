!> A constant force at a point of the body: V = -F·(R x), as of weight in another direction. Fixed in space axes, or in
!> axes that turn against these: those of an orbit seen from inertial ones, or inertial axes seen from an orbit.
module nutate_force
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_effect, only: parameter_t
   use nutate_kepler_orbit, only: kepler_orbit_t, n_elements
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_linear_potential, only: linear_potential_t
   use nutate_moving_linear, only: moving_linear_t
   implicit none
   private

   public :: force_t, moving_force_t

   !> U(γ) = -x·γ with γ = R(q)ᵀF.
   type, extends(linear_potential_t) :: force_t
   end type force_t

   !> The same with F(t).
   type, extends(moving_linear_t) :: moving_force_t
      type(lvlh_vector_t) :: force = lvlh_vector_t()
   contains
      procedure :: direction_at => direction_of_force
      procedure :: direction_rate => rate_of_force
      procedure :: direction_series => series_of_force
      procedure :: is_valid => force_is_valid
      procedure :: parameters => parameters_of_force
      procedure :: direction_change => change_of_force
      procedure :: direction_change_series => change_of_series
      procedure :: follows => force_follows
      procedure :: thin_table => thin_path
   end type moving_force_t

   !> A force at a point.
   interface force_t
      module procedure new_force
   end interface force_t

   !> A force that turns, at a point.
   interface moving_force_t
      module procedure new_moving_force
   end interface moving_force_t

contains

   !> Makes the potential -x·R(q)ᵀF of a constant force at a point of the body.
   pure function new_force(body_point, force) result(effect)
      !> x, body axes, m; shape (3).
      real(wp), intent(in) :: body_point(3)
      !> F, space axes, N; shape (3).
      real(wp), intent(in) :: force(3)
      type(force_t) :: effect
      effect%name = 'force'
      effect%moment = body_point
      effect%direction = force
   end function new_force

   !> Makes the potential of a force with rotating direction at a point of the body.
   pure function new_moving_force(body_point, force) result(effect)
      !> x, body axes, m; shape (3).
      real(wp), intent(in) :: body_point(3)
      !> F, N, as the space axes of the scene see it.
      type(lvlh_vector_t), intent(in) :: force
      type(moving_force_t) :: effect
      effect%name = 'force'
      effect%moment = body_point
      effect%force = force
      effect%moves = .true.
      effect%direction = 0.0_wp
      if (.not. effect%is_valid()) return
      effect%pace = force%path%fastest_turn()
      effect%direction = force%at(0.0_wp)
   end function new_moving_force

   !> Returns F at a time, space axes, N; shape (3).
   pure function direction_of_force(self, t) result(n)
      class(moving_force_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%force%at(t)
   end function direction_of_force

   pure function change_of_force(self, change, t) result(n)
      class(moving_force_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = self%force%change_at(change(4:6), t) + self%force%change_by_orbit(change(7:), t)
   end function change_of_force

   pure subroutine change_of_series(self, change, t, time_unit, n, known)
      class(moving_force_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      known = .true.
      call self%force%change_series(change(4:6), change(7:), t, time_unit, n)
   end subroutine change_of_series

   !> x, F, and the orbit.
   pure function parameters_of_force(self) result(list)
      class(moving_force_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [self%linear_potential_t%parameters(), parameter_t('orbit', n_elements)]
   end function parameters_of_force

   pure logical function force_follows(self, path)
      class(moving_force_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      force_follows = self%force%path%equals(path)
   end function force_follows

   !> Returns Ḟ at a time, space axes, N/s; shape (3).
   pure function rate_of_force(self, t) result(rate)
      class(moving_force_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: rate(3)
      rate = self%force%rate_at(t)
   end function rate_of_force

   !> Computes the coefficients of the power series of F about a time, space axes, N.
   pure subroutine series_of_force(self, t, time_unit, n)
      class(moving_force_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      call self%force%series(t, time_unit, n)
   end subroutine series_of_force

   !> Returns true if |x||F|, the largest energy and torque, and this times the rate of the orbit, the largest power,
   !> can be computed with.
   pure logical function force_is_valid(self) result(valid)
      class(moving_force_t), intent(in) :: self
      valid = all(is_moderate(self%moment)) .and. self%force%is_valid()
      if (valid) valid = is_moderate(norm2(self%moment))
      if (valid) valid = is_moderate(norm2(self%moment)*norm2(self%force%vector))
      if (valid) valid = is_moderate(norm2(self%moment)*norm2(self%force%vector)*self%force%path%fastest_turn())
   end function force_is_valid

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(moving_force_t), intent(inout) :: self
      call self%force%path%thin_table()
   end subroutine thin_path

end module nutate_force
