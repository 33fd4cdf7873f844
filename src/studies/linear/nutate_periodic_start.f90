!> Periodic motions of bodies in spin-orbit resonance, by shooting: the forced librations without the free ones.
!>
!> In the resonance p a body rotates by 2πp about the normal of its orbit in a revolution, p a multiple of ½, since half
!> a rotation leaves gravity gradients unchanged. With z the normal and P the period, the initial state is a root of
!>
!>     log((Rz(2πp)∘q(0))*∘q(P)) = 0,   Ω(P) - Ω(0) = 0:
!>
!> six equations in the rotation x of q(0)∘exp(½x) and the change of Ω(0). The Jacobian of Newton's method, M - I,
!> follows from the sensitivities of the run.
module nutate_periodic_start
   use nutate_kinds, only: wp, long
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: periodic_start_t, find_periodic_start

   !> Error of a step, rad, and limit of steps in a revolution.
   real(wp), parameter :: step_error = 1e-15_wp
   integer(long), parameter :: most_steps = 5000
   !> Limits of the iteration; the longest change, rad and mean motions, for which the map is treated as linear.
   integer, parameter :: most_iterations = 30
   real(wp), parameter :: longest_change = 0.1_wp
   !> A defect below this that no longer falls is due to rounding.
   real(wp), parameter :: settled = 1e-11_wp
   !> Singular values of M - I below this, relative to the largest, belong to families of periodic motions: the smallest
   !> correction leaves these directions alone.
   real(wp), parameter :: negligible = 1e-12_wp
   !> Rounding moves multipliers by less, by its square root if two of them coincide: multipliers nearer to the unit
   !> circle, or to 1, are treated as being there.
   real(wp), parameter, public :: on_circle = 1e-6_wp
   !> From this ratio of singular values on, a free libration that comes round in a revolution is named as the cause if
   !> the iteration fails.
   real(wp), parameter :: ill_conditioned = 1e6_wp

   !> A periodic motion at t = 0.
   type :: periodic_start_t
      !> Unit quaternion, body→space; shape (4). Ω, body axes, rad/s; shape (3).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], omega(3) = 0.0_wp
      !> M, the derivative of rotation and Ω/n after a revolution by those at the start, body axes; its eigenvalues are
      !> the multipliers exp(2πi·frequency/n). Shape (6, 6).
      real(wp) :: monodromy(6, 6) = 0.0_wp
      complex(wp) :: multipliers(6) = (0.0_wp, 0.0_wp)
      !> Ratio of the largest to the smallest singular value of M - I that is not negligible; number of negligible ones.
      real(wp) :: condition = 1.0_wp
      integer :: n_families = 0
      !> Largest number of the equations, rad and mean motions; revolutions computed.
      real(wp) :: defect = huge(1.0_wp)
      integer :: revolutions = 0
   contains
      !> Frequencies of the free librations, in units of the mean motion, without their whole numbers.
      procedure :: free_frequencies
      !> Returns the largest modulus of a multiplier.
      procedure :: growth
   end type periodic_start_t

   interface

      !> Finds the periodic motion of a spin-orbit resonance, from the axis of the least moment along the periapsis,
      !> that of the largest along the normal, and Ω = pn.
      !>
      !> Errors: `NUTATE_BAD_ARGUMENT` unless the body moves on one closed orbit in inertial axes, and has no wheels; if
      !> the motion has no derivative; if the iteration finds no periodic motion.
      module subroutine find_periodic_start(system, turns, start, status)
         type(system_t), intent(in) :: system
         !> p, rotations of the body in a revolution, a multiple of ½.
         real(wp), intent(in) :: turns
         type(periodic_start_t), intent(out) :: start
         type(status_t), intent(out) :: status
      end subroutine find_periodic_start

      !> Returns the frequencies of the free librations, in units of the mean motion: f in 0 to ½ of the multipliers
      !> exp(±2πif) on the unit circle other than 1, largest first. A libration has a frequency k ± f, k whole. Shape
      !> (0 to 3).
      pure module function free_frequencies(self) result(frequencies)
         class(periodic_start_t), intent(in) :: self
         real(wp), allocatable :: frequencies(:)
      end function free_frequencies

      !> Returns the largest modulus of a multiplier: the factor by which a deviation can grow in a revolution.
      pure real(wp) module function growth(self)
         class(periodic_start_t), intent(in) :: self
      end function growth

   end interface

end module nutate_periodic_start
