!> A sample of every effect that a scene can name, as test/effect_samples.nml gives it: all inclined to each other, on a
!> body without any symmetry; and a simple body for one effect alone.
module test_effect_samples
   use nutate_effect, only: effect_t, potential_t
   use nutate_kinds, only: wp
   use test_problems, only: make_state, problem_t, system_t
   use test_support, only: check, error_type
   implicit none
   private

   public :: effect_samples_t, sample_body, quartic_t, spinner

   !> One effect, and which kind it is of.
   type :: sample_t
      class(effect_t), allocatable :: effect
      integer :: kind = 0
   end type sample_t

   !> Samples of all kinds: of a potential one, of other effects as many as the file has.
   type :: effect_samples_t
      !> Names of the kinds, as in the catalogue; shape (number of kinds).
      character(len=24), allocatable :: names(:)
      !> Indices of the kinds that are potentials of a direction at rest; shape (number of potentials).
      integer, allocatable :: potentials(:)
      type(sample_t), allocatable :: items(:)
      !> Number of samples.
      integer :: n_items = 0
   contains
      !> Reads the samples from the file.
      procedure :: load
      !> Adds the samples of a kind to a system.
      procedure :: add
      !> Position of a kind.
      procedure :: position
      !> True for kinds that exclude each other.
      procedure :: is_excluded
   end type effect_samples_t

   !> U = γ1⁴ - 2γ1γ2γ3 + 3γ2²: given by U and ∇U alone.
   type, extends(potential_t) :: quartic_t
   contains
      procedure :: energy => quartic_energy
      procedure :: gradient => quartic_gradient
   end type quartic_t

   interface

      !> A full tensor with mass and an offset centre of mass, no effects yet.
      module function sample_body() result(system)
         type(system_t), pointer :: system
      end function sample_body

      !> A body of given principal moments that spins about its axis 3.
      module function spinner(moments, rate) result(problem)
         real(wp), intent(in) :: moments(3), rate
         type(problem_t), pointer :: problem
      end function spinner

      !> Reads the samples from the files; an error if an effect of the catalogue has none.
      module subroutine load(self, error)
         class(effect_samples_t), intent(out) :: self
         type(error_type), allocatable, intent(inout) :: error
      end subroutine load

      !> Adds the samples of kind `k` to a system; along `n` instead of its own direction, for a potential, where given.
      module subroutine add(self, system, k, n)
         class(effect_samples_t), intent(in) :: self
         type(system_t), intent(inout) :: system
         integer, intent(in) :: k
         !> Space axes; shape (3).
         real(wp), intent(in), optional :: n(3)
      end subroutine add

   end interface

contains

   !> Position of a kind among the names; 0 where there is none.
   pure integer function position(self, name)
      class(effect_samples_t), intent(in) :: self
      character(len=*), intent(in) :: name
      position = findloc(self%names == name, .true., dim=1)
   end function position

   !> True for a combination of kinds with a varying inertia and an effect that depends on the inertia.
   pure logical function is_excluded(self, combination)
      class(effect_samples_t), intent(in) :: self
      !> Bits of the kinds.
      integer, intent(in) :: combination
      is_excluded = btest(combination, self%position('inertia_rate') - 1) .and. &
                    btest(combination, self%position('gravity_gradient') - 1)
   end function is_excluded

   pure real(wp) function quartic_energy(self, gamma)
      class(quartic_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      quartic_energy = gamma(1)**4 - 2*gamma(1)*gamma(2)*gamma(3) + 3*gamma(2)**2
   end function quartic_energy

   pure function quartic_gradient(self, gamma) result(gradient)
      class(quartic_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [4*gamma(1)**3 - 2*gamma(2)*gamma(3), 6*gamma(2) - 2*gamma(1)*gamma(3), -2*gamma(1)*gamma(2)]
   end function quartic_gradient

end module test_effect_samples
