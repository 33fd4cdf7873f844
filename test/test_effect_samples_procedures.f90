!> Bodies of the procedures whose interfaces are in `test_effect_samples`.
submodule(test_effect_samples) test_effect_samples_procedures
   use nutate_body, only: diagonal, make_body
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_orbital_effects, only: build_on_orbit, goes_by_orbit
   use nutate_scene, only: read_scene, scene_t
   use nutate_status, only: status_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: new_problem, new_system
   implicit none

contains

   module procedure sample_body
      type(status_t) :: status
      system => new_system()
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
   end procedure sample_body

   module procedure spinner
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, rate])
   end procedure spinner

   module procedure load
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
   end procedure load

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

   module procedure add
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
   end procedure add

end submodule test_effect_samples_procedures
