!> Quaternion algebra: products, their matrices, exponential, logarithm, Cayley map and the rotation of vectors.
!>
!> A quaternion is `q(4)` with the scalar first, `q = [q0, u]`: equation (1) of Nielsen & Krenk (2012). One of length 1,
!> equation (2), takes body components to space components: `v_space = vec(q∘v∘q*)`. The routines work on what they are
!> given and never normalise silently. Components have to be finite unless a routine says what it does with others.
module nutate_quaternion
   use nutate_finite, only: is_finite
   use nutate_kinds, only: wp, pi
   implicit none
   private

   public :: cross
   public :: quat_product, quat_vector_product, vector_quat_product, quat_conjugate, quat_norm, quat_normalized
   public :: quat_left_matrix, quat_right_matrix
   public :: quat_exp, quat_log, cayley_map
   public :: rotate_to_space, rotate_to_body, rotation_matrix
   public :: attitude_distance

   !> Components between these bounds can be squared and summed without underflow that matters and without overflow.
   real(wp), parameter :: square_low = 1.0e-140_wp, square_high = 1.0e150_wp

contains

   !> Returns the cross product `a×b` of two 3-vectors.
   pure function cross(a, b) result(c)
      !> Left factor, any unit. Shape: (3).
      real(wp), intent(in) :: a(3)
      !> Right factor, any unit, in the frame of `a`. Shape: (3).
      real(wp), intent(in) :: b(3)
      real(wp) :: c(3)
      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> Returns the Hamilton product `a∘b`; as attitudes, `a∘b` rotates by `b` first and by `a` after it.
   pure function quat_product(a, b) result(c)
      !> Left factor, scalar first. Shape: (4).
      real(wp), intent(in) :: a(4)
      !> Right factor, scalar first. Shape: (4).
      real(wp), intent(in) :: b(4)
      real(wp) :: c(4)
      c(1) = a(1)*b(1) - a(2)*b(2) - a(3)*b(3) - a(4)*b(4)
      c(2) = a(1)*b(2) + a(2)*b(1) + a(3)*b(4) - a(4)*b(3)
      c(3) = a(1)*b(3) - a(2)*b(4) + a(3)*b(1) + a(4)*b(2)
      c(4) = a(1)*b(4) + a(2)*b(3) - a(3)*b(2) + a(4)*b(1)
   end function quat_product

   !> Returns the Hamilton product `q∘v` with a vector, the quaternion [0, v].
   pure function quat_vector_product(q, v) result(c)
      !> Left factor, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Right factor, any unit. Shape: (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: c(4)
      c(1) = -(q(2)*v(1) + q(3)*v(2) + q(4)*v(3))
      c(2) = q(1)*v(1) + q(3)*v(3) - q(4)*v(2)
      c(3) = q(1)*v(2) + q(4)*v(1) - q(2)*v(3)
      c(4) = q(1)*v(3) + q(2)*v(2) - q(3)*v(1)
   end function quat_vector_product

   !> Returns the Hamilton product `v∘q` with a vector, the quaternion [0, v].
   pure function vector_quat_product(v, q) result(c)
      !> Left factor, any unit. Shape: (3).
      real(wp), intent(in) :: v(3)
      !> Right factor, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: c(4)
      c(1) = -(v(1)*q(2) + v(2)*q(3) + v(3)*q(4))
      c(2) = v(1)*q(1) + v(2)*q(4) - v(3)*q(3)
      c(3) = v(2)*q(1) + v(3)*q(2) - v(1)*q(4)
      c(4) = v(3)*q(1) + v(1)*q(3) - v(2)*q(2)
   end function vector_quat_product

   !> Returns the conjugate `q* = [q0, -u]`, the inverse of a unit quaternion.
   pure function quat_conjugate(q) result(c)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: c(4)
      c(1) = q(1)
      c(2) = -q(2)
      c(3) = -q(3)
      c(4) = -q(4)
   end function quat_conjugate

   !> Returns the Euclidean norm `|q|`, without overflow or underflow on the way; `huge(norm)` where it is larger than
   !> that.
   !>
   !> A NaN or an infinity among the components shows in the result and raises no exception.
   pure function quat_norm(q) result(norm)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: norm
      real(wp) :: largest
      integer :: k
      if (.not. all(is_finite(q))) then
         norm = abs(q(1)) + abs(q(2)) + abs(q(3)) + abs(q(4))
         return
      end if
      largest = max(abs(q(1)), abs(q(2)), abs(q(3)), abs(q(4)))
      if (largest > square_low .and. largest < square_high) then
         norm = sqrt(q(1)**2 + q(2)**2 + q(3)**2 + q(4)**2)
      else
         k = exponent(largest)
         norm = sqrt(scale(q(1), -k)**2 + scale(q(2), -k)**2 + scale(q(3), -k)**2 + scale(q(4), -k)**2)
         if (k + exponent(norm) <= maxexponent(norm)) then
            norm = scale(norm, k)
         else
            norm = huge(norm)
         end if
      end if
   end function quat_norm

   !> Returns the unit quaternion `q/|q|`. Zero and what is not finite have no direction and come back as they are.
   pure function quat_normalized(q) result(normalized)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: normalized(4)
      real(wp) :: norm, s(4)
      norm = quat_norm(q)
      normalized = q
      if (.not. is_finite(norm)) return
      if (norm > square_low .and. norm < square_high) then
         normalized = q/norm
      else if (norm > 0) then
         ! At the ends of the range the norm itself may be too coarse to divide by.
         s = scale(q, -exponent(maxval(abs(q))))
         normalized = s/sqrt(s(1)**2 + s(2)**2 + s(3)**2 + s(4)**2)
      end if
   end function quat_normalized

   !> Returns the matrix `Q(q)` of the product from the left, the paper's Q: `Q(q) x = q∘x`. Orthogonal for a unit
   !> quaternion; `Q(q)ᵀ = Q(q*)`.
   pure function quat_left_matrix(q) result(m)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: m(4, 4)
      m(1, 1) = q(1); m(1, 2) = -q(2); m(1, 3) = -q(3); m(1, 4) = -q(4)
      m(2, 1) = q(2); m(2, 2) = q(1); m(2, 3) = -q(4); m(2, 4) = q(3)
      m(3, 1) = q(3); m(3, 2) = q(4); m(3, 3) = q(1); m(3, 4) = -q(2)
      m(4, 1) = q(4); m(4, 2) = -q(3); m(4, 3) = q(2); m(4, 4) = q(1)
   end function quat_left_matrix

   !> Returns the matrix of the product from the right: `quat_right_matrix(q) x = x∘q`. It commutes with every `Q(r)`.
   pure function quat_right_matrix(q) result(m)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: m(4, 4)
      m(1, 1) = q(1); m(1, 2) = -q(2); m(1, 3) = -q(3); m(1, 4) = -q(4)
      m(2, 1) = q(2); m(2, 2) = q(1); m(2, 3) = q(4); m(2, 4) = -q(3)
      m(3, 1) = q(3); m(3, 2) = -q(4); m(3, 3) = q(1); m(3, 4) = q(2)
      m(4, 1) = q(4); m(4, 2) = q(3); m(4, 3) = -q(2); m(4, 4) = q(1)
   end function quat_right_matrix

   !> Returns the exponential of the pure quaternion `v`: `[cos|v|, v sin|v|/|v|]`, the rotation by the angle `2|v|`
   !> about `v`.
   pure function quat_exp(v) result(q)
      !> Half the rotation vector (rad). Shape: (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: q(4)
      real(wp) :: angle, sine
      angle = length(v)
      if (angle < 1.0e-4_wp) then
         ! Two terms of sin|v|/|v| leave |v|**4/120 < eps, and there is no division by a vanishing angle.
         sine = 1 - angle*angle/6
      else
         sine = sin(angle)/angle
      end if
      q(1) = cos(angle)
      q(2) = sine*v(1)
      q(3) = sine*v(2)
      q(4) = sine*v(3)
   end function quat_exp

   !> Returns the logarithm of the direction of `q`: the `v` with `0 <= |v| <= π` and `quat_exp(v) = q/|q|`.
   !>
   !> This is the plain inverse of `quat_exp`: `q` and `-q`, the same attitude, have different logarithms. For the
   !> shortest rotation give the one of the two with `q0 >= 0`. At `q = -1`, where every direction is right, `v` is
   !> along axis 1. The zero quaternion gives zero.
   pure function quat_log(q) result(v)
      !> Any quaternion, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: v(3)
      real(wp) :: sine, angle
      sine = length(q(2:4))
      if (sine <= 0) then
         v = 0
         if (q(1) < 0) v(1) = pi
      else
         angle = atan2(sine, q(1))
         ! The direction first: angle/sine would overflow close to q = -1.
         v(1) = angle*(q(2)/sine)
         v(2) = angle*(q(3)/sine)
         v(3) = angle*(q(4)/sine)
      end if
   end function quat_log

   !> Returns the Cayley map `c = (1+b)∘(1-b)⁻¹ = [1-|b|², 2b]/(1+|b|²)`: a unit quaternion, the rotation by `4
   !> atan|b|` about `b`.
   pure function cayley_map(b) result(c)
      !> Tangent of a quarter of the rotation angle along its axis (dimensionless). Shape: (3).
      real(wp), intent(in) :: b(3)
      real(wp) :: c(4)
      real(wp) :: square, factor
      if (max(abs(b(1)), abs(b(2)), abs(b(3))) > square_high) then
         ! The limit, to round-off, instead of the overflow of |b|².
         c(1) = -1
         c(2) = 0
         c(3) = 0
         c(4) = 0
      else
         square = b(1)*b(1) + b(2)*b(2) + b(3)*b(3)
         factor = 1/(1 + square)
         c(1) = (1 - square)*factor
         c(2) = 2*factor*b(1)
         c(3) = 2*factor*b(2)
         c(4) = 2*factor*b(3)
      end if
   end function cayley_map

   !> Returns the space components of a vector given in the body frame: `vec(q∘v∘q*) = R(q) v`.
   !>
   !> Homogeneous of degree two in `q`: for a quaternion that is not a unit one the result is the rotated vector times
   !> `|q|²`. The discrete derivatives rely on this; normalise first if only the rotation is wanted.
   pure function rotate_to_space(q, v) result(r)
      !> Attitude, body to space, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Vector in the body frame, any unit. Shape: (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: r(3)
      real(wp) :: d, w1, w2, w3
      ! q∘v = [-d, w]
      d = q(2)*v(1) + q(3)*v(2) + q(4)*v(3)
      w1 = q(1)*v(1) + q(3)*v(3) - q(4)*v(2)
      w2 = q(1)*v(2) + q(4)*v(1) - q(2)*v(3)
      w3 = q(1)*v(3) + q(2)*v(2) - q(3)*v(1)
      r(1) = q(1)*w1 + d*q(2) + q(3)*w3 - q(4)*w2
      r(2) = q(1)*w2 + d*q(3) + q(4)*w1 - q(2)*w3
      r(3) = q(1)*w3 + d*q(4) + q(2)*w2 - q(3)*w1
   end function rotate_to_space

   !> Returns the body components of a vector given in the space frame: `vec(q*∘v∘q) = R(q)ᵀ v`.
   !>
   !> Homogeneous of degree two in `q`, as `rotate_to_space` is.
   pure function rotate_to_body(q, v) result(r)
      !> Attitude, body to space, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Vector in the space frame, any unit. Shape: (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: r(3)
      real(wp) :: d, w1, w2, w3
      ! q*∘v = [d, w]
      d = q(2)*v(1) + q(3)*v(2) + q(4)*v(3)
      w1 = q(1)*v(1) - q(3)*v(3) + q(4)*v(2)
      w2 = q(1)*v(2) - q(4)*v(1) + q(2)*v(3)
      w3 = q(1)*v(3) - q(2)*v(2) + q(3)*v(1)
      r(1) = q(1)*w1 + d*q(2) - q(3)*w3 + q(4)*w2
      r(2) = q(1)*w2 + d*q(3) - q(4)*w1 + q(2)*w3
      r(3) = q(1)*w3 + d*q(4) - q(2)*w2 + q(3)*w1
   end function rotate_to_body

   !> Returns the matrix `R(q)` with `R(q) v = vec(q∘v∘q*)`; its columns are the space components of the body axes.
   !>
   !> Homogeneous of degree two in `q`: `|q|²` times a rotation matrix.
   pure function rotation_matrix(q) result(r)
      !> Attitude, body to space, scalar first. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: r(3, 3)
      real(wp) :: q00, q11, q22, q33
      q00 = q(1)*q(1)
      q11 = q(2)*q(2)
      q22 = q(3)*q(3)
      q33 = q(4)*q(4)
      r(1, 1) = q00 + q11 - q22 - q33
      r(2, 2) = q00 - q11 + q22 - q33
      r(3, 3) = q00 - q11 - q22 + q33
      r(2, 1) = 2*(q(2)*q(3) + q(1)*q(4))
      r(1, 2) = 2*(q(2)*q(3) - q(1)*q(4))
      r(1, 3) = 2*(q(2)*q(4) + q(1)*q(3))
      r(3, 1) = 2*(q(2)*q(4) - q(1)*q(3))
      r(3, 2) = 2*(q(3)*q(4) + q(1)*q(2))
      r(2, 3) = 2*(q(3)*q(4) - q(1)*q(2))
   end function rotation_matrix

   !> Returns the angle of the rotation that takes one attitude to the other (rad), in [0, π].
   !>
   !> The length and the sign of either quaternion do not matter. Two quaternions of equal length give a tiny distance
   !> to full relative accuracy. Without an attitude to speak of (a zero quaternion, a component that is not finite)
   !> the distance is π, so that a comparison with a tolerance fails.
   pure function attitude_distance(q1, q2) result(angle)
      !> First attitude, scalar first. Shape: (4).
      real(wp), intent(in) :: q1(4)
      !> Second attitude, scalar first. Shape: (4).
      real(wp), intent(in) :: q2(4)
      real(wp) :: angle
      real(wp) :: a(4), b(4), d(4), largest(2), dot
      integer :: ka, kb
      angle = pi
      if (.not. (all(is_finite(q1)) .and. all(is_finite(q2)))) return
      largest = [maxval(abs(q1)), maxval(abs(q2))]
      if (.not. all(largest > 0)) return
      ka = exponent(largest(1))
      kb = exponent(largest(2))
      ! Quaternions of nearly equal length keep their difference.
      if (abs(ka - kb) <= 1) kb = ka
      a = scale(q1, -ka)
      b = scale(q2, -kb)
      dot = a(1)*b(1) + a(2)*b(2) + a(3)*b(3) + a(4)*b(4)
      if (dot < 0) b = -b
      ! vec(a*∘b) = vec(a*∘(b-a)), and the difference of close numbers is exact.
      d = quat_product(quat_conjugate(a), b - a)
      angle = 2*atan2(length(d(2:4)), abs(dot))
   end function attitude_distance

   !> Returns the Euclidean length of a 3-vector, without intermediate overflow or underflow.
   pure function length(v)
      real(wp), intent(in) :: v(3)
      real(wp) :: length
      length = quat_norm([0.0_wp, v])
   end function length

end module nutate_quaternion
