!> What a tangent column is the derivative by: a direction in the space of starts and parameters. A key of a scene that
!> changes several of them (the mass of a shape, say) is one column with all of them in it.
module nutate_column
   use nutate_any_effect, only: effect_t, parameter_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: column_t, effect_change_t, attitude_column, rate_column, inertia_column
   public :: OF_POTENTIAL, OF_TORQUE, OF_WHEEL

   !> In which list of the effects one stands.
   integer, parameter :: OF_POTENTIAL = 1, OF_TORQUE = 2, OF_WHEEL = 3

   !> A change of the parameters of one effect.
   type :: effect_change_t
      integer :: kind = 0
      !> The `place` of a potential, the index of a torque or wheel.
      integer :: place = 0
      !> In the order of the effect's `parameters`.
      real(wp), allocatable :: change(:)
   end type effect_change_t

   !> The change of the start and of the parameters that a unit of the column stands for. Where a parameter changes, the
   !> start keeps its rates, Ω0 and those of the wheels.
   type :: column_t
      !> For messages and files.
      character(len=64) :: name = ''
      !> Start: rotation vector of the attitude, body axes, q → q∘exp(½θ); Ω0, body axes, 1/s; shape (3).
      real(wp) :: attitude(3) = 0.0_wp, angular_velocity(3) = 0.0_wp
      !> Body: J with its wheels locked, symmetric, kg m², shape (3,3); mass times centre of mass, kg m, shape (3).
      !> Effects that depend on them change too.
      real(wp) :: inertia(3, 3) = 0.0_wp, mass_moment(3) = 0.0_wp
      !> Momentum of the rotors, body axes, N m s, and the rate of the space axes, in these, rad/s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp, frame(3) = 0.0_wp
      !> Parameters of effects.
      type(effect_change_t), allocatable :: effects(:)
   contains
      !> Adds a parameter of an effect.
      procedure :: add
      !> Adds what follows from the body.
      procedure :: follow_body
      !> It changes a parameter.
      procedure :: is_parametric
   end type column_t

contains

   !> Returns the column of a rotation of the start about a body axis.
   pure type(column_t) function attitude_column(axis) result(column)
      !> 1, 2 or 3.
      integer, intent(in) :: axis
      column%name = 'initial.attitude.'//digit(axis)
      column%attitude(axis) = 1.0_wp
   end function attitude_column

   !> Returns the column of a component of Ω0.
   pure type(column_t) function rate_column(axis) result(column)
      !> 1, 2 or 3.
      integer, intent(in) :: axis
      column%name = 'initial.angular_velocity.'//digit(axis)
      column%angular_velocity(axis) = 1.0_wp
   end function rate_column

   !> Returns the column of a component of the inertia, of both where it is off the diagonal.
   pure type(column_t) function inertia_column(i, j) result(column)
      !> 1, 2 or 3.
      integer, intent(in) :: i, j
      column%name = 'body.inertia.'//digit(i)//digit(j)
      column%inertia(i, j) = 1.0_wp
      column%inertia(j, i) = 1.0_wp
   end function inertia_column

   pure character(len=1) function digit(i)
      integer, intent(in) :: i
      write (digit, '(i1)') i
   end function digit

   !> Adds a change of a parameter of an effect. Errors: `NUTATE_BAD_ARGUMENT` where there is no such effect, and where
   !> it has no parameter of that name and size.
   subroutine add(self, effects, effect, number, parameter, change, status)
      class(column_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Name of the effect.
      character(len=*), intent(in) :: effect
      !> Which of those of that name: potentials in the order in which they were added, then torques, then wheels.
      integer, intent(in) :: number
      !> Name of the parameter.
      character(len=*), intent(in) :: parameter
      !> As many numbers as it has.
      real(wp), intent(in) :: change(:)
      type(status_t), intent(out) :: status
      integer :: i, place, found
      found = 0
      do place = 1, effects%n_potentials + effects%n_off
         do i = 1, effects%n_potentials + effects%n_off
            if (effects%potentials(i)%place == place) call look_at(effects%potentials(i)%item, OF_POTENTIAL, place)
         end do
      end do
      do i = 1, effects%n_torques
         call look_at(effects%torques(i)%item, OF_TORQUE, i)
      end do
      do i = 1, effects%n_wheels
         call look_at(effects%wheels(i), OF_WHEEL, i)
      end do
      if (number < 1 .or. found < number) &
         status = fail(NUTATE_BAD_ARGUMENT, 'there is no effect '//trim(effect)//' to differentiate by')

   contains

      subroutine look_at(item, kind, place)
         class(effect_t), intent(in) :: item
         integer, intent(in) :: kind, place
         if (item%name /= effect) return
         found = found + 1
         if (found /= number) return
         if (.not. changes(self, item, kind, place, parameter, change)) &
            status = fail(NUTATE_BAD_ARGUMENT, 'the effect '//trim(effect)//' has no derivative by '//parameter// &
                          ' (expected '//trim(names_of(item))//')')
      end subroutine look_at

   end subroutine add

   !> Adds a change to those of an effect; false where the effect has no derivative by that name.
   logical function changes(self, effect, kind, place, parameter, change)
      type(column_t), intent(inout) :: self
      class(effect_t), intent(in) :: effect
      integer, intent(in) :: kind, place
      character(len=*), intent(in) :: parameter
      real(wp), intent(in) :: change(:)
      type(parameter_t), allocatable :: list(:)
      type(effect_change_t) :: one
      integer :: i, first
      changes = .false.
      list = effect%parameters()
      first = 1
      do i = 1, size(list)
         if (list(i)%name /= '' .and. list(i)%name == parameter .and. list(i)%size == size(change)) then
            one%kind = kind
            one%place = place
            allocate (one%change(sum(list%size)), source=0.0_wp)
            one%change(first:first + size(change) - 1) = change
            call append(self, one)
            changes = .true.
            return
         end if
         first = first + list(i)%size
      end do
   end function changes

   !> The parameters of an effect with their sizes, for messages.
   function names_of(effect) result(names)
      class(effect_t), intent(in) :: effect
      character(len=96) :: names
      type(parameter_t), allocatable :: list(:)
      integer :: i
      names = ''
      list = effect%parameters()
      do i = 1, size(list)
         if (list(i)%name == '') cycle
         if (names /= '') names = trim(names)//','
         names = trim(names)//' '//list(i)%name
         if (list(i)%size > 1) names = trim(names)//'('//digit(list(i)%size)//')'
      end do
      names = adjustl(names)
      if (names == '') names = 'another effect'
   end function names_of

   subroutine append(self, one)
      type(column_t), intent(inout) :: self
      type(effect_change_t), intent(in) :: one
      type(effect_change_t), allocatable :: grown(:)
      integer :: i, n
      n = 0
      if (allocated(self%effects)) n = size(self%effects)
      do i = 1, n
         if (self%effects(i)%kind /= one%kind .or. self%effects(i)%place /= one%place) cycle
         self%effects(i)%change = self%effects(i)%change + one%change
         return
      end do
      allocate (grown(n + 1))
      do i = 1, n
         grown(i) = self%effects(i)
      end do
      grown(n + 1) = one
      call move_alloc(grown, self%effects)
   end subroutine append

   !> Adds the changes of effects that follow from those of the body.
   subroutine follow_body(self, effects)
      class(column_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i
      logical :: there
      do i = 1, effects%n_potentials + effects%n_off
         associate (slot => effects%potentials(i))
            if (any(abs(self%inertia) > 0.0_wp)) &
               there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'inertia', reshape(self%inertia, [9]))
            if (any(abs(self%mass_moment) > 0.0_wp)) &
               there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'mass_moment', self%mass_moment)
         end associate
      end do
   end subroutine follow_body

   !> True for a column that changes more than the start.
   pure logical function is_parametric(self)
      class(column_t), intent(in) :: self
      is_parametric = any(abs(self%inertia) > 0.0_wp) .or. any(abs(self%rotor) > 0.0_wp) .or. &
                      any(abs(self%frame) > 0.0_wp) .or. allocated(self%effects)
   end function is_parametric

end module nutate_column
