!> Bounds of the torque of an effect in a step, by which `nutate_root_certificate` certifies that a root of the step is
!> the true one.
!>
!> In a step with the Cayley vector b = ¼Δt Ω̄ the torque τ̄ at mid step enters as T(b) = (1+β)τ̄ - 2b(b·τ̄), β = |b|².
!> For every b with |b| ≤ ρ an effect bounds the length of A T(b), and the norms of its first and second derivative by
!> b, where A is a linear map: J⁻¹, or J⁻¹ followed by the inverse of a Jacobian. Bounds of several effects add up.
!> Every bound grows with ρ. Lengths are Euclidean, norms spectral.
module nutate_effect_bounds
   use nutate_kinds, only: wp, eps
   use nutate_small_products, only: times_columns, vector_length
   implicit none
   private

   public :: effect_bounds_t, linear_map_t, map_of
   public :: add_bounds, bounds_of_drag, bounds_of_linear, bounds_of_potential, bounds_of_torque
   public :: let_change, projection_part, projection_slope, projection_curvature, spectral_norm, times_cross

   !> Norm of the second derivative of 2bbᵀ/(1+β): it is 4 at b = 0 and less elsewhere.
   real(wp), parameter :: projection_curvature = 4.0_wp

   !> A linear map of body components.
   type :: linear_map_t
      !> A; shape (3,3).
      real(wp) :: matrix(3, 3) = 0.0_wp
      !> ‖A‖
      real(wp) :: norm = 0.0_wp
      !> Principal axes of the body as columns, body axes; shape (3,3).
      real(wp) :: axes(3, 3) = 0.0_wp
   end type linear_map_t

   !> Bounds in the ball |b| ≤ ρ.
   type :: effect_bounds_t
      !> True if the effect has bounds; else the other components have no meaning.
      logical :: known = .true.
      !> |A T|, and the norms of its first and second derivative by b, for all torques that do not resist the rotation.
      real(wp) :: force = 0.0_wp, slope = 0.0_wp, curvature = 0.0_wp
      !> |A T|, and the norms of its first and second derivative by b, for a torque -DΩ, with Db instead of τ̄.
      real(wp) :: drag = 0.0_wp, drag_slope = 0.0_wp, drag_curvature = 0.0_wp
      !> For a torque that changes with time: |A ∂T/∂t|, its slope, and |A ∂²T/∂t²|.
      real(wp) :: change = 0.0_wp, change_slope = 0.0_wp, change_rate = 0.0_wp
   end type effect_bounds_t

contains

   !> Adds the bounds of another effect.
   pure subroutine add_bounds(self, other)
      type(effect_bounds_t), intent(inout) :: self
      type(effect_bounds_t), intent(in) :: other
      self%known = self%known .and. other%known
      self%force = self%force + other%force
      self%slope = self%slope + other%slope
      self%curvature = self%curvature + other%curvature
      self%drag = self%drag + other%drag
      self%drag_slope = self%drag_slope + other%drag_slope
      self%drag_curvature = self%drag_curvature + other%drag_curvature
      self%change = self%change + other%change
      self%change_slope = self%change_slope + other%change_slope
      self%change_rate = self%change_rate + other%change_rate
   end subroutine add_bounds

   !> Makes a map from its matrix.
   pure type(linear_map_t) function map_of(matrix, axes) result(map)
      !> Matrix, shape (3,3); principal axes as columns, body axes; shape (3,3).
      real(wp), intent(in) :: matrix(3, 3), axes(3, 3)
      map%matrix = matrix
      map%norm = spectral_norm(matrix)
      map%axes = axes
   end function map_of

   !> Returns the bounds of a potential U = -m·γ, γ = Rᵀn: τ̄ is m×γ½/(1+β), γ½ = Rᵀn at mid step, and T is γ½×(-m)
   !> without its projection 2b(b·)/(1+β).
   pure type(effect_bounds_t) function bounds_of_linear(map, radius, moment, length) result(bounds)
      type(linear_map_t), intent(in) :: map
      !> ρ
      real(wp), intent(in) :: radius
      !> m, body axes; shape (3), and |n|.
      real(wp), intent(in) :: moment(3), length
      real(wp) :: direct, whole
      direct = spectral_norm(times_cross(map%matrix, moment))*length
      whole = map%norm*vector_length(moment)*length
      bounds%force = min(direct + projection_part(radius)*whole, whole)
      bounds%slope = 2*direct + projection_slope(radius)*whole
      bounds%curvature = 4*direct + projection_curvature*whole
   end function bounds_of_linear

   !> Returns the bounds of any potential of γ = Rᵀn whose derivatives are bounded for |γ| ≤ |n|, with Gonzalez's
   !> discrete gradient.
   !>
   !> With Δ = γ1 - γ0 and Π = ΔΔᵀ/|Δ|² that gradient is (I-Π)∇U(γ̄) + Π m, m the mean of ∇U along the way. So its
   !> length is at most √2 max|∇U|; with Taylor's formula under the integral its derivative by γ1 is bounded by
   !> ½max‖∇²U‖ + ¼|Δ|max‖∇³U‖, |Δ| ≤ 2|n|, and the second by 4/3 max‖∇³U‖.
   pure type(effect_bounds_t) function bounds_of_potential(map, radius, length, slope, curvature, third) result(bounds)
      type(linear_map_t), intent(in) :: map
      !> ρ
      real(wp), intent(in) :: radius
      !> |n|
      real(wp), intent(in) :: length
      !> Bounds of |∇U|, of ‖∇²U‖ and of the third derivative.
      real(wp), intent(in) :: slope, curvature, third
      real(wp) :: gradient, gradient_slope, gradient_curvature, torque, torque_slope, torque_curvature
      gradient = sqrt(2.0_wp)*slope
      gradient_slope = length*(0.5_wp*curvature + 0.5_wp*length*third)
      gradient_curvature = length*length*(4.0_wp/3)*third
      ! γ½×∇̄U: a change of b rotates γ½ by 2|δb| and γ1 by 4|δb| at most, in second order by 4 and 16 |δb|².
      torque = length*gradient
      torque_slope = length*(2*gradient + 4*gradient_slope)
      torque_curvature = length*(4*gradient + 32*gradient_slope + 16*gradient_curvature)
      bounds%force = map%norm*torque
      bounds%slope = map%norm*(torque_slope + projection_slope(radius)*torque)
      bounds%curvature = map%norm*(torque_curvature + 2*projection_slope(radius)*torque_slope &
                                   + projection_curvature*torque)
   end function bounds_of_potential

   !> Returns the bounds of any torque that depends on attitude and time alone, with bounded derivatives: T = (1+β)τ -
   !> 2b(b·τ) at the attitude of mid step, which a change of b rotates by 2|δb| at most, in second order by 1.6 |δb|²
   !> beside 4 |δb|² of its square.
   pure type(effect_bounds_t) function bounds_of_torque(map, radius, torque, slope, curvature, rate) result(bounds)
      type(linear_map_t), intent(in) :: map
      !> ρ
      real(wp), intent(in) :: radius
      !> Bounds of |τ|, N m, of ‖∂τ/∂θ‖ (θ a small rotation), and of the second derivative along a rotation.
      real(wp), intent(in) :: torque, slope, curvature
      !> Rate, 1/s: `rate` times a quantity bounds the time derivative of that quantity; 0: constant in time.
      real(wp), intent(in) :: rate
      real(wp) :: square
      square = 1 + radius*radius
      bounds%force = map%norm*square*torque
      bounds%slope = map%norm*(2*radius*torque + 2*square*slope)
      bounds%curvature = map%norm*(2*torque + 8*radius*slope + square*(4*curvature + 1.6_wp*slope))
      call let_change(bounds, rate)
   end function bounds_of_torque

   !> Sets the bounds of time derivatives from those of the torque: each derivative adds a factor `rate`.
   pure subroutine let_change(bounds, rate)
      type(effect_bounds_t), intent(inout) :: bounds
      !> Rate that bounds time derivatives, 1/s.
      real(wp), intent(in) :: rate
      bounds%change = rate*bounds%force
      bounds%change_slope = rate*bounds%slope
      bounds%change_rate = rate*bounds%change
   end subroutine let_change

   !> Returns the bounds of a torque -DΩ: with u = Db, (1+β)u - 2b(b·u) = u + b∘u∘b.
   pure type(effect_bounds_t) function bounds_of_drag(map, radius, drag) result(bounds)
      type(linear_map_t), intent(in) :: map
      !> ρ
      real(wp), intent(in) :: radius
      !> D, body axes, N m s; shape (3,3).
      real(wp), intent(in) :: drag(3, 3)
      real(wp) :: direct, whole
      direct = spectral_norm(times_columns(map%matrix, drag))
      whole = map%norm*spectral_norm(drag)
      bounds%drag = radius*(direct + radius*radius*whole)
      bounds%drag_slope = direct + 3*radius*radius*whole
      bounds%drag_curvature = 6*radius*whole
   end function bounds_of_drag

   !> Returns ‖2bbᵀ/(1+β)‖ at |b| = ρ.
   elemental real(wp) function projection_part(radius) result(bound)
      real(wp), intent(in) :: radius
      bound = 2*radius*radius/(1 + radius*radius)
   end function projection_part

   !> Returns a bound of the derivative of 2bbᵀ/(1+β).
   elemental real(wp) function projection_slope(radius) result(bound)
      real(wp), intent(in) :: radius
      bound = min(4*radius, 1.6_wp)
   end function projection_slope

   !> Returns A [v]×, [v]× the matrix of the product v×; shape (3,3).
   pure function times_cross(a, v) result(product)
      real(wp), intent(in) :: a(3, 3), v(3)
      real(wp) :: product(3, 3)
      product(:, 1) = a(:, 2)*v(3) - a(:, 3)*v(2)
      product(:, 2) = a(:, 3)*v(1) - a(:, 1)*v(3)
      product(:, 3) = a(:, 1)*v(2) - a(:, 2)*v(1)
   end function times_cross

   !> Returns ‖A‖: the root of the largest eigenvalue of AᵀA, by Cardano's formula, rounded upwards.
   pure real(wp) function spectral_norm(a) result(norm)
      real(wp), intent(in) :: a(3, 3)
      real(wp), parameter :: upwards = 1 + 64*eps
      real(wp) :: b(3, 3), s(3, 3), scale, mean, spread, half_determinant
      integer :: i, j
      norm = 0.0_wp
      scale = maxval(abs(a))
      if (.not. scale > tiny(scale)) return
      b = a/scale
      do j = 1, 3
         do i = 1, j
            s(i, j) = dot_product(b(:, i), b(:, j))
            s(j, i) = s(i, j)
         end do
      end do
      mean = (s(1, 1) + s(2, 2) + s(3, 3))/3
      do i = 1, 3
         s(i, i) = s(i, i) - mean
      end do
      spread = sqrt(sum(s*s)/6)
      if (spread > eps*mean) then
         s = s/spread
         half_determinant = 0.5_wp*(s(1, 1)*(s(2, 2)*s(3, 3) - s(2, 3)*s(3, 2)) &
                                    - s(1, 2)*(s(2, 1)*s(3, 3) - s(2, 3)*s(3, 1)) &
                                    + s(1, 3)*(s(2, 1)*s(3, 2) - s(2, 2)*s(3, 1)))
         mean = mean + 2*spread*cos(acos(max(-1.0_wp, min(1.0_wp, half_determinant)))/3)
      else
         mean = mean + 2*spread
      end if
      norm = scale*sqrt(mean)*upwards
   end function spectral_norm

end module nutate_effect_bounds
