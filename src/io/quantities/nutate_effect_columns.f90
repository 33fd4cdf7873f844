!> The columns that a history has for each effect: the energy of each potential, the work of each effect that does work.
module nutate_effect_columns
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: energy_of
   use nutate_kinds, only: wp
   use nutate_observer, only: run_record_t
   use nutate_spelling, only: joined
   use nutate_state, only: state_t
   implicit none
   private

   public :: energy_headers, work_headers, energies_of, works_of

   !> Room for the name of an effect and a number.
   integer, parameter :: header_length = 34

contains

   !> Returns the names of the energy columns, `energy_gravity,energy_spring1,energy_spring2`: the potentials in the
   !> order in which they were added, on or off; empty if there is none.
   pure function energy_headers(effects) result(headers)
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: headers
      character(len=header_length) :: names(effects%n_potentials + effects%n_off)
      integer :: i
      do i = 1, size(names)
         names(effects%potentials(i)%place) = effects%potentials(i)%item%name
      end do
      headers = joined('energy_'//numbered(names))
   end function energy_headers

   !> Returns the names of the work columns, `work_damping,work_motor1,work_friction1`: torques, motor and friction of
   !> each wheel, friction of each inner sphere, the dependence on time, and the switches if potentials can be switched;
   !> empty if there is nothing.
   pure function work_headers(effects) result(headers)
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: headers
      character(len=header_length) :: names(effects%n_works() + 1)
      integer :: i, last
      last = effects%n_torques
      do i = 1, last
         names(i) = effects%torques(i)%item%name
      end do
      names(:last) = numbered(names(:last))
      do i = 1, effects%n_reaction_wheels
         write (names(last + 1), '("motor", i0)') i
         write (names(last + 2), '("friction", i0)') i
         last = last + 2
      end do
      do i = 1, effects%n_spheres
         last = last + 1
         write (names(last), '("sphere", i0)') i
      end do
      if (effects%depends_on_time) then
         last = last + 1
         names(last) = 'time_dependent'
      end if
      if (can_switch(effects)) then
         last = last + 1
         names(last) = 'switches'
      end if
      headers = joined('work_'//names(:last))
   end function work_headers

   !> Returns U of each potential, J, 0 for one that is off; shape (n).
   pure function energies_of(effects, state, n) result(energies)
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> Number of potentials.
      integer, intent(in) :: n
      real(wp) :: energies(n)
      integer :: i
      energies = 0.0_wp
      do i = 1, effects%n_potentials
         energies(effects%potentials(i)%place) = energy_of(effects, i, state%q, state%t)
      end do
   end function energies_of

   !> Returns the work values of a record, J; zeros before the run, when the record has none. Shape (n).
   pure function works_of(effects, record, n) result(works)
      type(effect_list_t), intent(in) :: effects
      type(run_record_t), intent(in) :: record
      !> Number of headers.
      integer, intent(in) :: n
      real(wp) :: works(n)
      integer :: fixed, i, last
      works = 0.0_wp
      if (.not. allocated(record%works)) return
      fixed = effects%n_torques + 2*effects%n_reaction_wheels
      works(:fixed) = record%works(:fixed)
      ! Each sphere has a motor, which does no work, and friction along each axis.
      last = fixed
      do i = 1, effects%n_spheres
         fixed = fixed + 1
         works(fixed) = sum(record%works(last + 1:last + 6))
         last = last + 6
      end do
      ! In a member of an ensemble, potentials that move in the scene can be constant.
      if (effects%depends_on_time .and. n > fixed) works(fixed + 1) = record%works(last + 1)
      if (can_switch(effects)) works(n) = record%works(size(record%works))
   end function works_of

   !> Returns true if events can switch a potential, which changes the energy at once.
   pure logical function can_switch(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      can_switch = any([(effects%potentials(i)%item%label /= '', i=1, effects%n_potentials + effects%n_off)])
   end function can_switch

   !> Returns names with numbers after those that occur several times, and without characters that the header of a table
   !> would have to mark; shape (that of `names`).
   pure function numbered(names) result(texts)
      character(len=*), intent(in) :: names(:)
      character(len=len(names)) :: texts(size(names)), plain(size(names))
      integer :: i
      plain = names
      do i = 1, size(names)
         if (plain(i) == '') plain(i) = 'effect'
         call make_plain(plain(i))
      end do
      texts = plain
      do i = 1, size(names)
         if (count(plain == plain(i)) > 1) write (texts(i), '(a, i0)') trim(plain(i)), count(plain(:i) == plain(i))
      end do
   end function numbered

   pure subroutine make_plain(name)
      character(len=*), intent(inout) :: name
      integer :: i
      character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_'
      do i = 1, len_trim(name)
         if (scan(name(i:i), letters) == 0) name(i:i) = '_'
      end do
   end subroutine make_plain

end module nutate_effect_columns
