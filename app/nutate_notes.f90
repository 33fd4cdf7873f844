!> Notes about a scene that limit the trust in its results.
module nutate_notes
   use nutate_body, only: body_t, whole_body
   use nutate_decimal, only: rounded_text
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp
   use nutate_scene, only: scene_t
   implicit none
   private

   public :: note_t, add_note, scene_notes

   !> Relative difference of two moments below which they cause a note, unless they are equal: it may be rounded input.
   real(wp), parameter :: nearly_equal = 1e-6_wp
   !> Cosine of the angle to an axis, 26 degrees, below which a rotation is not near the axis.
   real(wp), parameter :: near_axis = 0.9_wp
   !> Rotations of the body in a step that cause a note, rad: at |b| = 1 at the latest, no step follows the rotation;
   !> from a radian on, order 2 is off by 2 % of the phase and more.
   real(wp), parameter :: too_long = 4.0_wp, long = 1.0_wp
   !> Growth rates below this fraction of the rotation rate do not show in a run.
   real(wp), parameter :: slow_growth = 1e-3_wp

   type :: note_t
      character(len=:), allocatable :: text
   end type note_t

contains

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
      else if (turn >= long) then
         call add_note(notes, 'the first step turns the body by '//rounded_text(turn, 3)// &
                  ' rad: the invariants are conserved, but the phase is not accurate')
      end if
      call note_symmetry(scene%system%body, notes)
      ! Potentials and rotors can make any axis stable.
      associate (effects => scene%system%effects)
         if (effects%n_potentials + effects%n_rotors == 0) call note_instability(scene, omega, notes)
      end associate
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
