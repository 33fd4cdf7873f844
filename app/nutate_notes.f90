!> Notes about a scene that limit the trust in its results, and the steps and rows to expect of its run.
module nutate_notes
   use nutate_body, only: body_t, whole_body
   use nutate_columns, only: columns_t
   use nutate_console, only: plural
   use nutate_decimal, only: rounded_text
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: long, wp
   use nutate_printable, only: printable_path
   use nutate_run, only: run_t
   use nutate_run_plan, only: count_steps
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: known_steps, rows_of, most_rows, too_many_rows, expectation_text, size_text, history_bytes, note_t, &
             add_note, scene_notes

   !> Limits of the rows and bytes of a history whose scene has neither `every` nor `interval`.
   integer(long), parameter :: greatest_rows = 1000000
   real(wp), parameter :: greatest_size = 1e8_wp
   !> Characters that a number takes in a history, its comma included.
   real(wp), parameter :: usual_field = 19.0_wp
   !> Characters of a date, its comma included.
   real(wp), parameter :: date_field = 27.0_wp

   !> Relative difference of two moments below which they cause a note, unless they are equal: it may be rounded input.
   real(wp), parameter :: nearly_equal = 1e-6_wp
   !> Cosine of the angle to an axis, 26 degrees, below which a rotation is not near the axis.
   real(wp), parameter :: near_axis = 0.9_wp
   !> Rotations of the body in a step that cause a note, rad: at |b| = 1 at the latest, no step follows the rotation;
   !> from a radian on, order 2 is off by 2 % of the phase and more.
   real(wp), parameter :: too_long = 4.0_wp, large = 1.0_wp
   !> Growth rates below this fraction of the rotation rate do not show in a run.
   real(wp), parameter :: slow_growth = 1e-3_wp

   type :: note_t
      character(len=:), allocatable :: text
   end type note_t

contains

   !> Returns the number of steps to come; negative if it is unknown before the run is over.
   integer(long) function known_steps(scene, run) result(steps)
      type(scene_t), intent(in) :: scene
      !> Run that has begun and found its steps.
      type(run_t), intent(in) :: run
      if (.not. scene%plan%goal%active()) then
         steps = count_steps(scene%initial%t, scene%plan)
      else
         steps = -1
         if (run%expected_steps > 0) steps = run%expected_steps
      end if
   end function known_steps

   !> Returns the rows of a history of so many steps; negative if they depend on an unknown number of steps.
   pure integer(long) function rows_of(scene, steps) result(rows)
      type(scene_t), intent(in) :: scene
      !> Number of steps; negative if unknown.
      integer(long), intent(in) :: steps
      associate (plan => scene%plan)
         rows = -1
         if (allocated(plan%times)) then
            rows = size(plan%times, kind=long)
         else if (plan%interval > 0.0_wp) then
            rows = 1 + ceiling(abs(plan%end_time)/plan%interval*(1 - epsilon(1.0_wp)), long)
         else if (steps >= 0) then
            rows = 1 + steps/plan%every + min(modulo(steps, plan%every), 1_long)
         end if
      end associate
   end function rows_of

   !> Returns the size of a history, bytes.
   real(wp) function history_bytes(scene, rows)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: rows
      type(columns_t) :: columns
      type(status_t) :: status
      call columns%choose(scene%output%columns, status, effects=scene%system%effects, propagated=scene%propagated())
      history_bytes = usual_field*real(rows, wp)*real(columns%width, wp)
      if (scene%output%epoch%is_set()) history_bytes = history_bytes + date_field*real(rows, wp)
   end function history_bytes

   !> Returns the most rows that may be written: any number if `every`, `interval` or times are given.
   integer(long) function most_rows(scene)
      type(scene_t), intent(in) :: scene
      integer :: i
      most_rows = min(greatest_rows, int(greatest_size/history_bytes(scene, 1_long), long))
      do i = 1, size(scene%groups)
         if (scene%groups(i)%name /= 'output') cycle
         if (scene%groups(i)%has('every') .or. scene%groups(i)%has('interval') .or. allocated(scene%plan%times)) &
            most_rows = huge(most_rows)
      end do
   end function most_rows

   !> Returns why a history of so many rows is rejected, and what to write instead.
   function too_many_rows(scene, rows) result(text)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: rows
      character(len=:), allocatable :: text
      integer(long) :: every
      every = 10_long**ceiling(log10(real(rows, wp)/1e4_wp))
      text = plural(rows, 'row')//', about '//size_text(history_bytes(scene, rows))// &
             ', more than is written by default (expected every = '//rounded_text(real(every, wp))// &
             ' in &output; every = 1 for all of them)'
   end function too_many_rows

   !> Returns the expected steps and rows if trial runs have found them; blank otherwise.
   function expectation_text(scene, run) result(text)
      type(scene_t), intent(in) :: scene
      !> Run that has begun and found its steps.
      type(run_t), intent(in) :: run
      character(len=:), allocatable :: text
      integer(long) :: steps, rows
      text = ''
      steps = run%expected_steps
      if (steps < 1) return
      rows = rows_of(scene, steps)
      text = printable_path(scene%file)//': '//plural(steps, 'step')//', '//plural(rows, 'row')//', about '// &
             size_text(history_bytes(scene, rows))//' to expect'
   end function expectation_text

   !> Returns a number of bytes for people.
   pure function size_text(bytes) result(text)
      real(wp), intent(in) :: bytes
      character(len=:), allocatable :: text
      if (bytes < 1e6_wp) then
         text = rounded_text(max(1.0_wp, anint(bytes/1e3_wp)), 2)//' kB'
      else if (bytes < 1e9_wp) then
         text = rounded_text(bytes/1e6_wp, 2)//' MB'
      else
         text = rounded_text(bytes/1e9_wp, 2)//' GB'
      end if
   end function size_text

   !> Collects the notes on the body alone.
   subroutine body_notes(body, notes)
      type(body_t), intent(in) :: body
      type(note_t), allocatable, intent(out) :: notes(:)
      allocate (notes(0))
      if (body%breaks_triangle) &
         call add_note(notes, 'no rigid body has these moments: one exceeds the sum of the other two')
      if (body%idealised) &
         call add_note(notes, 'no rigid body has these moments about its centre of mass: an idealised top')
   end subroutine body_notes

   !> Collects the notes on body, initial state and step.
   subroutine scene_notes(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(out) :: notes(:)
      real(wp) :: omega(3), turn
      call body_notes(whole_body(scene%system%body), notes)
      omega = angular_velocity(scene%system, scene%initial)
      turn = abs(scene%plan%time_step)*norm2(omega)
      if (turn >= too_long) then
         call add_note(notes, 'the first step turns the body by '//rounded_text(turn, 3)// &
                  ' rad: most steps of 4 rad or more are too long to follow the motion and will be subdivided')
      else if (turn >= large) then
         call add_note(notes, 'the first step turns the body by '//rounded_text(turn, 3)// &
                  ' rad: the invariants are conserved, but the phase is not accurate')
      end if
      call note_symmetry(scene%system%body, notes)
      ! Potentials and rotors can make any axis stable.
      if (scene%system%effects%n_potentials + scene%system%effects%n_rotors == 0) &
         call note_instability(scene, omega, notes)
   end subroutine scene_notes

   !> Notes a body that is symmetric up to a difference that may be rounding of its input.
   subroutine note_symmetry(body, notes)
      type(body_t), intent(in) :: body
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: gaps(3)
      gaps = abs(body%moments - cshift(body%moments, 1))/maxval(body%moments)
      if (any(gaps > 0.0_wp .and. gaps < nearly_equal)) &
         call add_note(notes, 'two moments of inertia differ by only '// &
                       rounded_text(minval(gaps, mask=gaps > 0.0_wp), 3)//' of the largest: nearly symmetric')
   end subroutine note_symmetry

   !> Notes a free rotation near the intermediate axis: perturbations grow as exp(λt), λ² = Ω²(J₂-J₁)(J₃-J₂)/(J₁J₃),
   !> and a step leaves the true motion if λΔt/2 > 1 - |b|², |b| = Δt|Ω|/4.
   subroutine note_instability(scene, omega, notes)
      type(scene_t), intent(in) :: scene
      !> Angular velocity Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: least, middle, most, rate, growth
      integer :: k

      associate (body => scene%system%body)
         least = minval(body%moments)
         most = maxval(body%moments)
         k = 6 - minloc(body%moments, 1) - maxloc(body%moments, 1)
         if (k < 1 .or. k > 3) return
         middle = body%moments(k)
         rate = norm2(omega)
         if (abs(dot_product(body%axes(:, k), omega)) <= near_axis*rate) return
         growth = rate*sqrt((1 - least/middle)*(middle/least)*(1 - middle/most))
         if (growth <= slow_growth*rate) return
      end associate
      call add_note(notes, 'rotation near the intermediate axis: small differences grow tenfold every '// &
               rounded_text(log(10.0_wp)/growth, 3)//' s')
      if (0.5_wp*growth*abs(scene%plan%time_step) > 1 - (0.25_wp*rate*scene%plan%time_step)**2) &
         call add_note(notes, 'the step is too long to resolve this instability and will be subdivided')
   end subroutine note_instability

   !> Adds a note to others.
   subroutine add_note(notes, text)
      type(note_t), allocatable, intent(inout) :: notes(:)
      character(len=*), intent(in) :: text
      type(note_t), allocatable :: longer(:)
      integer :: i, n
      ! There is no array constructor here: gfortran loses the components of its elements.
      n = size(notes)
      allocate (longer(n + 1))
      do i = 1, n
         call move_alloc(notes(i)%text, longer(i)%text)
      end do
      longer(n + 1)%text = text
      call move_alloc(longer, notes)
   end subroutine add_note

end module nutate_notes
