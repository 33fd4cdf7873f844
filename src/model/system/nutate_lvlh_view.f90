!> The motion of a body on a circular orbit as seen from the LVLH frame, where its space axes are inertial.
!>
!> In inertial axes the gravity of the orbit's centre is a time-dependent potential. In the LVLH frame, which rotates at
!> the constant rate ω = (0, -n, 0), it is constant: steps cost less, they can be certified, and the Jacobi integral
!> T + V - ω·l is conserved. Attitude and momentum differ by the rotation c(t) of the frame alone,
!>
!>     q = c∘q',   p = c∘p',   c = c(0)∘exp(½ω t),
!>
!> and the work of the time-dependent potential between two states is the change of ω·l.
module nutate_lvlh_view
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: space_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_orbit, only: orbit_t
   use nutate_potential, only: potential_t
   use nutate_quaternion, only: quat_conjugate, quat_normalized, quat_product, rotate_to_space
   use nutate_state, only: state_t
   implicit none
   private

   public :: lvlh_view_t

   !> The system as seen from the LVLH frame, and the conversion of states.
   type :: lvlh_view_t
      !> All effects are constant in the LVLH frame; if not, the other components have no meaning.
      logical :: exists = .false.
      !> Same body and effects in LVLH space axes.
      type(system_t) :: system
      !> Attitude of the LVLH frame at t = 0, unit quaternion, LVLH→inertial; shape (4).
      real(wp), private :: axes(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> ω in inertial axes, rad/s; shape (3).
      real(wp) :: rate(3) = 0.0_wp
      !> ½n, rad/s.
      real(wp), private :: half_rate = 0.0_wp
   contains
      !> Determines whether a system can be seen from the LVLH frame, and makes the view.
      procedure :: prepare
      !> Returns the attitude of the LVLH frame at a time.
      procedure :: axes_at
      !> Convert a state to LVLH axes, and one that a step left there to inertial axes.
      procedure :: to_lvlh
      procedure :: to_inertial
      !> Returns ω·l of a state in LVLH axes.
      procedure :: frame_energy
   end type lvlh_view_t

contains

   !> Determines whether a system can be seen from the LVLH frame, and makes the view: its space axes are inertial, its
   !> only orbit is a circle, and nothing acts but potentials of this orbit, rotors and wheels. Controllers are torques.
   subroutine prepare(self, system)
      class(lvlh_view_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      integer :: i
      self%exists = is_candidate(system%effects)
      if (.not. self%exists) return
      self%system = system
      associate (effects => self%system%effects)
         do i = 1, effects%n_potentials + effects%n_off
            call replace_potential(effects%potentials(i)%item, effects%orbit, self%exists)
            if (.not. self%exists) return
         end do
         effects%moves = .false.
         effects%depends_on_time = effects%varies
         call effects%add(orbit_in_lvlh(effects%orbit))
         self%axes = effects%orbit%path%axes(0.0_wp)
         self%rate = rotate_to_space(self%axes, effects%frame_rate)
         self%half_rate = -0.5_wp*effects%frame_rate(2)
      end associate
   end subroutine prepare

   !> Returns true if everything but the potentials permits the view.
   pure logical function is_candidate(effects)
      type(effect_list_t), intent(in) :: effects
      is_candidate = effects%moves .and. effects%on_orbit .and. effects%n_torques == 0 .and. .not. effects%frame_turns
      if (.not. is_candidate) return
      associate (path => effects%orbit%path)
         is_candidate = size(effects%orbits) == 1 .and. .not. (allocated(path%track) .or. path%eccentricity > 0.0_wp)
         if (is_candidate) is_candidate = path%mean_motion() > 0.0_wp
      end associate
   end function is_candidate

   !> Replaces a potential by the same potential as seen from the LVLH frame.
   subroutine replace_potential(item, orbit, possible)
      class(potential_t), allocatable, intent(inout) :: item
      type(orbit_t), intent(in) :: orbit
      logical, intent(out) :: possible
      class(potential_t), allocatable :: seen
      possible = item%follows(orbit%path)
      if (possible) call item%see_from_lvlh(seen)
      possible = allocated(seen)
      if (possible) call move_alloc(seen, item)
   end subroutine replace_potential

   !> Returns the same orbit with its LVLH frame as space axes.
   pure type(orbit_t) function orbit_in_lvlh(orbit) result(rotating)
      type(orbit_t), intent(in) :: orbit
      type(orbit_t) :: made
      made = orbit_t(orbit%path, inertial=.false.)
      rotating = orbit
      rotating%is_frame = made%is_frame
      rotating%rate = made%rate
   end function orbit_in_lvlh

   !> Returns c at a time, unit quaternion, LVLH→inertial, without jumps; shape (4).
   pure function axes_at(self, t) result(c)
      class(lvlh_view_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: c(4), cosine, sine
      cosine = cos(self%half_rate*t)
      sine = sin(self%half_rate*t)
      associate (a => self%axes)
         c = [cosine*a(1) + sine*a(3), cosine*a(2) + sine*a(4), cosine*a(3) - sine*a(1), cosine*a(4) - sine*a(2)]
      end associate
   end function axes_at

   !> Converts a state to LVLH axes: restores the one that the last step left there, if this is it, digit for digit.
   pure subroutine to_lvlh(self, state, inner)
      class(lvlh_view_t), intent(in) :: self
      !> Inertial axes.
      type(state_t), intent(in) :: state
      type(state_t), intent(inout) :: inner
      real(wp) :: back(4)
      call copy_common(self, state, inner)
      if (state%is_from_other_axes()) then
         inner%q = state%other_axes%q
         inner%p = state%other_axes%p
         inner%q_compensation = state%q_compensation
         inner%p_compensation = state%p_compensation
      else if (.not. (all(is_moderate(state%q)) .and. all(is_moderate(state%p)))) then
         ! This state is rejected by every stepper.
         inner%q = state%q
         inner%p = state%p
      else
         back = quat_conjugate(self%axes_at(state%t))
         inner%q = quat_normalized(quat_product(back, state%q))
         inner%p = quat_product(back, state%p)
         inner%q_compensation = 0.0_wp
         inner%p_compensation = 0.0_wp
      end if
   end subroutine to_lvlh

   !> Converts a state that a step left in LVLH axes to inertial axes.
   pure subroutine to_inertial(self, inner, state)
      class(lvlh_view_t), intent(in) :: self
      !> LVLH axes.
      type(state_t), intent(in) :: inner
      type(state_t), intent(inout) :: state
      real(wp) :: c(4)
      c = self%axes_at(inner%t)
      call copy_common(self, inner, state)
      state%q = quat_product(c, inner%q)
      state%p = quat_product(c, inner%p)
      call state%set_other_axes(inner)
   end subroutine to_inertial

   !> Copies the values of a state that are the same in all axes: time, wheels, work and balance.
   pure subroutine copy_common(self, state, copy)
      class(lvlh_view_t), intent(in) :: self
      type(state_t), intent(in) :: state
      type(state_t), intent(inout) :: copy
      copy%t = state%t
      copy%time_dependent_work = state%time_dependent_work
      copy%time_dependent_until = state%time_dependent_until
      if (state%balance%open .or. copy%balance%open) copy%balance = state%balance
      if (self%system%effects%n_wheels == 0) return
      copy%wheel_momentum = state%wheel_momentum
      copy%wheel_compensation = state%wheel_compensation
      copy%wheel_work = state%wheel_work
   end subroutine copy_common

   !> Returns ω·l, J.
   pure real(wp) function frame_energy(self, inner)
      class(lvlh_view_t), intent(in) :: self
      !> LVLH axes.
      type(state_t), intent(in) :: inner
      frame_energy = dot_product(self%system%effects%frame_rate, space_momentum(inner))
   end function frame_energy

end module nutate_lvlh_view
