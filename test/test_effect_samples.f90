!> A sample of every effect that a scene can name, as test/effect_samples.nml gives it: all inclined to each other, on a
!> body without any symmetry; and a simple body for one effect alone.
module test_effect_samples
   use nutate_body, only: diagonal, make_body
   use nutate_effect, only: effect_t, potential_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_kinds, only: wp
   use nutate_orbital_effects, only: build_on_orbit, goes_by_orbit
   use nutate_scene, only: read_scene, scene_t
   use nutate_status, only: status_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
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

contains

   !> A full tensor with mass and an offset centre of mass, no effects yet.
   type(system_t) function sample_body() result(system)
      type(status_t) :: status
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
   end function sample_body

   !> A body of given principal moments that spins about its axis 3.
   type(problem_t) function spinner(moments, rate) result(problem)
      real(wp), intent(in) :: moments(3), rate
      type(status_t) :: status
      call make_body(diagonal(moments), problem%system%body, status)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, rate])
   end function spinner

   !> Reads the samples from the files. Fails where a kind of the catalogue is in none of them.
   subroutine load(self, error)
      class(effect_samples_t), intent(out) :: self
      type(error_type), allocatable, intent(inout) :: error
      type(effect_kind_t), allocatable :: kinds(:)
      integer :: k
      allocate (kinds, source=effect_kinds())
      allocate (self%names(size(kinds)), self%items(64), self%potentials(0))
      do k = 1, size(kinds)
         self%names(k) = kinds(k)%group%name
      end do
      call read_samples(self, kinds, 'test/effect_samples.nml', error)
      if (.not. allocated(error)) call read_samples(self, kinds, 'test/orbit_samples.nml', error)
      if (.not. allocated(error)) call read_samples(self, kinds, 'test/inertia_samples.nml', error)
      do k = 1, size(kinds)
         if (allocated(error)) return
         call check(error, any(self%items(:self%n_items)%kind == k), 'no sample of &'//trim(self%names(k)))
      end do
   end subroutine load

   !> Reads the samples of a file.
   subroutine read_samples(self, kinds, file, error)
      class(effect_samples_t), intent(inout) :: self
      type(effect_kind_t), intent(in) :: kinds(:)
      character(len=*), intent(in) :: file
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i, k
      allocate (scene)
      call read_scene(file, scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      do k = 1, size(kinds)
         do i = 1, size(scene%groups)
            if (scene%groups(i)%name /= self%names(k)) cycle
            if (any(self%potentials == k)) exit
            associate (sample => self%items(self%n_items + 1))
               if (scene%system%effects%on_orbit .and. goes_by_orbit(scene%groups(i))) then
                  call build_on_orbit(scene%groups(i), scene%system%effects%orbit, scene%system%body, sample%effect, &
                                      status)
               else
                  call kinds(k)%build(scene%groups(i), scene%system%body, sample%effect, status)
               end if
               sample%kind = k
               select type (effect => sample%effect)
               class is (potential_t)
                  if (.not. effect%moves) self%potentials = [self%potentials, k]
               end select
            end associate
            self%n_items = self%n_items + 1
         end do
      end do
   end subroutine read_samples

   !> Adds the samples of kind `k` to a system; along `n` instead of its own direction, for a potential, where given.
   subroutine add(self, system, k, n)
      class(effect_samples_t), intent(in) :: self
      type(system_t), intent(inout) :: system
      integer, intent(in) :: k
      !> Space axes; shape (3).
      real(wp), intent(in), optional :: n(3)
      class(effect_t), allocatable :: effect
      type(status_t) :: status
      integer :: i
      do i = 1, self%n_items
         if (self%items(i)%kind /= k) cycle
         ! An assignment would not do: gfortran 12 gives the new type the memory of the old one.
         if (allocated(effect)) deallocate (effect)
         allocate (effect, source=self%items(i)%effect)
         if (present(n)) then
            select type (effect)
            class is (potential_t)
               effect%direction = ((-1)**k*norm2(effect%direction)/norm2(n))*n
            end select
         end if
         select type (effect)
         type is (wheel_t)
            call add_wheel(system, effect, status)
         class default
            call system%effects%add(effect)
         end select
      end do
   end subroutine add

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
