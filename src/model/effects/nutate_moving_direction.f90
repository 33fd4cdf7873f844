!> Vectors that move with an orbit, in the space axes of a scene: one that is fixed in the LVLH frame or in inertial
!> axes (`nutate_lvlh_vector`), the magnetic field of the Earth (`nutate_geomagnetic_field`).
module nutate_moving_direction
   use nutate_effect_base, only: parameter_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: moving_direction_t

   !> A vector n(t) and the path with which it moves.
   type, abstract :: moving_direction_t
      type(kepler_orbit_t) :: path = kepler_orbit_t()
   contains
      !> Return n and its rate at a time.
      procedure(vector_at), deferred :: at
      procedure(vector_at), deferred :: rate_at
      !> Computes the power series of n.
      procedure(vector_series), deferred :: series
      !> Returns the parameters by which n can be differentiated; the elements of the orbit come last.
      procedure(list_of_numbers), deferred :: parameters
      !> Return the change of n by a change of `parameters`, and compute its power series.
      procedure(change_of_vector), deferred :: change_at
      procedure(series_of_change), deferred :: change_series
      !> Return bounds of |n|, and of the rate of its direction, 1/s.
      procedure(bound_of_vector), deferred :: greatest
      procedure(bound_of_vector), deferred :: pace
      !> Returns true if n and its rate are of a size that can be computed with.
      procedure(validity), deferred :: is_valid
   end type moving_direction_t

   abstract interface
      !> Returns a vector at a time, in the space axes of the scene; shape (3).
      pure function vector_at(self, t) result(v)
         import :: moving_direction_t, wp
         class(moving_direction_t), intent(in) :: self
         !> Time, s.
         real(wp), intent(in) :: t
         real(wp) :: v(3)
      end function vector_at

      !> Computes the coefficients of the power series of a vector about a time, in the space axes of the scene.
      pure subroutine vector_series(self, t, time_unit, v)
         import :: moving_direction_t, wp
         class(moving_direction_t), intent(in) :: self
         !> Time t₀ and time unit of the series, s.
         real(wp), intent(in) :: t, time_unit
         !> Shape (3, 0:order).
         real(wp), intent(out) :: v(:, 0:)
      end subroutine vector_series

      pure function list_of_numbers(self) result(list)
         import :: moving_direction_t, parameter_t
         class(moving_direction_t), intent(in) :: self
         type(parameter_t), allocatable :: list(:)
      end function list_of_numbers

      !> Returns the change of a vector at a time, in the space axes of the scene; shape (3).
      pure function change_of_vector(self, change, t) result(v)
         import :: moving_direction_t, wp
         class(moving_direction_t), intent(in) :: self
         !> Change of `parameters`; time, s.
         real(wp), intent(in) :: change(:), t
         real(wp) :: v(3)
      end function change_of_vector

      !> Computes the coefficients of the power series of the change about a time.
      pure subroutine series_of_change(self, change, t, time_unit, v)
         import :: moving_direction_t, wp
         class(moving_direction_t), intent(in) :: self
         !> Change of `parameters`; time t₀ and time unit of the series, s.
         real(wp), intent(in) :: change(:), t, time_unit
         !> Shape (3, 0:order).
         real(wp), intent(out) :: v(:, 0:)
      end subroutine series_of_change

      pure real(wp) function bound_of_vector(self)
         import :: moving_direction_t, wp
         class(moving_direction_t), intent(in) :: self
      end function bound_of_vector

      pure logical function validity(self) result(valid)
         import :: moving_direction_t
         class(moving_direction_t), intent(in) :: self
      end function validity
   end interface

end module nutate_moving_direction
