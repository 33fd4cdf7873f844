!> A rigid body: its inertia about the reference point, mass and centre of mass, validated once.
module nutate_body
   use nutate_kinds, only: wp
   use nutate_status, only: status_t
   implicit none
   private

   public :: body_t, make_body, make_shape_body, diagonal, parallel_axis, without, symmetric, whole_body

   !> Tolerance of the triangle rule: excess of a moment over the sum of the other two, relative to the largest moment,
   !> up to which a body is valid. It admits flat plates given with rounded numbers.
   real(wp), parameter :: triangle_tolerance = 1e-12_wp

   !> A rigid body as the equations of motion need it. Made by `make_body` or `make_shape_body`.
   type :: body_t
      !> J about the reference point, body axes, kg m²; without the inertia of wheels about their axes.
      real(wp) :: inertia(3, 3) = 0.0_wp
      !> J⁻¹, exactly symmetric, kg⁻¹ m⁻².
      real(wp) :: inverse_inertia(3, 3) = 0.0_wp
      !> Principal moments, kg m², in the order of the nearest body axes.
      real(wp) :: moments(3) = 0.0_wp
      !> Principal axes as columns, body axes, right-handed; the unit matrix for a diagonal tensor.
      real(wp) :: axes(3, 3) = 0.0_wp
      !> Mass, kg; only with `has_mass`.
      real(wp) :: mass = 0.0_wp
      !> The mass is known.
      logical :: has_mass = .false.
      !> Centre of mass from the reference point, body axes, m.
      real(wp) :: center_of_mass(3) = 0.0_wp
      !> The moments about the reference point break the triangle rule (admitted by `check_triangle = .false.`).
      logical :: breaks_triangle = .false.
      !> Moments of no rigid body are admitted (`check_triangle = .false.`).
      logical :: admits_all = .false.
      !> The tensor about the centre of mass is not that of any rigid body: idealised tops.
      logical :: idealised = .false.
      !> J with the wheels locked, kg m², which gravity acts on; equal to `inertia` without wheels.
      real(wp), private :: locked(3, 3) = 0.0_wp
   end type body_t

   interface

      !> Makes a body from its inertia tensor.
      !>
      !> Errors: `NUTATE_BAD_BODY` with the reason: not finite, not symmetric, not positive definite (a moment that
      !> vanishes: an infinitely thin rod), a moment larger than the sum of the other two, moments not within 1e-100 to
      !> 1e100 kg m². `NUTATE_BAD_ARGUMENT`: mass not within 1e-100 to 1e100 kg, centre of mass not finite or beyond
      !> 1e100 m, a shift requested without a mass.
      pure module subroutine make_body(tensor, body, status, mass, center_of_mass, about_center_of_mass, check_triangle)
         !> Inertia tensor, body axes, kg m².
         real(wp), intent(in) :: tensor(3, 3)
         type(body_t), intent(out) :: body
         type(status_t), intent(out) :: status
         !> Mass, kg.
         real(wp), intent(in), optional :: mass
         !> Centre of mass from the reference point, body axes, m; default: the reference point.
         real(wp), intent(in), optional :: center_of_mass(3)
         !> The tensor refers to the centre of mass and is moved to the reference point; default: it refers to the
         !> latter.
         logical, intent(in), optional :: about_center_of_mass
         !> `.false.` admits moments that break the triangle rule; default `.true.`.
         logical, intent(in), optional :: check_triangle
      end subroutine make_body

      !> Computes the body without the inertia of wheels about their axes, whose rotation has the momentum L - Σ s h.
      !> Errors: `NUTATE_BAD_BODY` if the wheels have more inertia than the body.
      pure module subroutine without(body, spinning, rest, status)
         type(body_t), intent(in) :: body
         !> Inertia of the wheels about their axes, Σ Jw ssᵀ, body axes, kg m².
         real(wp), intent(in) :: spinning(3, 3)
         type(body_t), intent(out) :: rest
         type(status_t), intent(out) :: status
      end subroutine without

      !> Returns the body with its wheels locked.
      pure type(body_t) module function whole_body(body) result(whole)
         type(body_t), intent(in) :: body
      end function whole_body

      !> Makes a homogeneous body of a named shape, from its mass or its density.
      !>
      !> Errors: those of `make_body`; `NUTATE_BAD_ARGUMENT` for an unknown shape, a wrong number of lengths, a length
      !> that is not positive, or not exactly one of mass and density.
      pure module subroutine make_shape_body(shape, lengths, body, status, mass, density, center_of_mass)
         !> 'box', 'cylinder', 'cone', 'sphere' or 'ellipsoid'.
         character(len=*), intent(in) :: shape
         !> Lengths of the shape, m, see `shape_kinds`.
         real(wp), intent(in) :: lengths(:)
         type(body_t), intent(out) :: body
         type(status_t), intent(out) :: status
         !> Mass, kg.
         real(wp), intent(in), optional :: mass
         !> Density, kg m⁻³.
         real(wp), intent(in), optional :: density
         !> Centre of mass from the reference point, body axes, m.
         real(wp), intent(in), optional :: center_of_mass(3)
      end subroutine make_shape_body

      !> Returns m (|c|² I - c cᵀ), which moves a tensor from the centre of mass to a point at -c from it.
      pure module function parallel_axis(mass, c) result(shift)
         !> Mass, kg.
         real(wp), intent(in) :: mass
         !> Centre of mass from the point, body axes, m.
         real(wp), intent(in) :: c(3)
         real(wp) :: shift(3, 3)
      end function parallel_axis

      !> Returns the diagonal matrix of three numbers.
      pure module function diagonal(d) result(matrix)
         real(wp), intent(in) :: d(3)
         real(wp) :: matrix(3, 3)
      end function diagonal

      !> Returns the symmetric matrix of six numbers: 11, 22, 33, 12, 13, 23.
      pure module function symmetric(d) result(matrix)
         real(wp), intent(in) :: d(6)
         real(wp) :: matrix(3, 3)
      end function symmetric

   end interface

end module nutate_body
