!> The step of Nielsen & Krenk (2012) in reduced form: three equations for the rotation in the step, Newton's method in
!> closed form, no LAPACK.
!>
!> The equations are the discrete (9a) and (11) of the paper on the constraints (2) and (5), in
!> `nutate_reduced_equations`; the projection is built in, since only a torque enters. The trajectory is that of the 8×8
!> system to round-off. If nothing depends on the attitude it can be left out: then only the body momentum is
!> integrated.
module nutate_reduced
   use nutate_archive, only: archive_t
   use nutate_implicit_step, only: implicit_stepper_t, increment_t, most_unknowns
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: manifold_tolerance
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH, NUTATE_SINGULAR
   use nutate_step_tangent, only: conserving_step_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: reduced_t

   !> Largest |qᵀq - 1| of a state after its start.
   real(wp), parameter :: near_manifold = 1e-8_wp
   !> Iterations of a step above which the next one starts with new derivatives of the effects.
   integer, parameter :: slow = 4
   !> Increment of b above which the free part of the Jacobian is computed anew: its change would then cost the next
   !> iteration digits, since the error after that is about the square of the increment.
   real(wp), parameter :: coarse = 1e-6_wp
   !> Bound of the sums of |adj(F') F''| without effects, in the units of the step: 163 is the largest of 1e5 bodies
   !> drawn at random, with |b| < 0.41 and rotors of up to five times the body's own momentum. By it the next increment
   !> is known beforehand.
   real(wp), parameter :: curvature = 200.0_wp
   !> Largest |b| of an iteration: on the branch of the true motion |b| is below 1, so that a b this much longer does
   !> not lead to a root.
   real(wp), parameter :: farthest = 1e3_wp
   !> Determinants below are those of singular systems: their inverse would leave the range of numbers.
   real(wp), parameter :: least_determinant = 1e-150_wp

   !> The 3×3 stepper, with b as its unknowns.
   type, extends(implicit_stepper_t) :: reduced_t
      private
      type(reduced_equations_t) :: equations
      !> Rows of the Jacobian's inverse, shape (3, row); its determinant.
      real(wp) :: rows(3, 3) = 0.0_wp, raw_determinant = 0.0_wp
      !> Distance that b has moved since the Jacobian was computed, and in the last increment.
      real(wp) :: moved = 0.0_wp, change = 0.0_wp
      !> b of the last step; shape (3). Data of its tangent, from the first `propagate_step` on.
      real(wp) :: root(3) = 0.0_wp
      type(conserving_step_t), allocatable :: last
   contains
      procedure :: set_up
      procedure :: start
      procedure :: scale_unknowns
      procedure :: explicit_guess
      procedure :: correct
      procedure :: linearize
      procedure :: get_start_vector
      procedure :: unknowns_of
      procedure :: get_cayley_vector
      procedure :: finish
      procedure :: transfer_form
      procedure :: propagate_step
      procedure :: put_form
      procedure :: take_form
   end type reduced_t

contains

   !> Prepares the stepper. Errors: `NUTATE_BAD_ARGUMENT` if the settings switch the projection off, which is built into
   !> the reduced form; those of `check_system`.
   subroutine set_up(self, system, settings, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. settings%projection) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the reduced formulation needs the projection', 'projection')
         return
      end if
      call self%begin(system, 3, slow, status)
      call self%equations%prepare(system%effects)
   end subroutine set_up

   !> Sets the equations of a step. Rejects a first state off the constraint manifold, and later ones that have left it.
   subroutine start(self, system, state, dt, window_time, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      if (system%effects%varies) then
         call self%equations%set_step(system, dt, state%t + 0.5_wp*dt)
      else if (dt /= self%equations%dt) then
         call self%equations%set_step(system, dt)
      end if
      call self%equations%start(system, state, window_time)
      if (self%untested) then
         if (.not. (abs(dot_product(state%q, state%q) - 1) <= manifold_tolerance .and. &
                    abs(dot_product(state%q, state%p)) <= manifold_tolerance*norm2(state%p))) &
            status = fail(NUTATE_BAD_ARGUMENT, "the reduced form needs |q| = 1 and q.p = 0 "// &
                          "(formulation = 'full' does not)")
      else if (.not. (abs(self%equations%square - 1) <= near_manifold .and. abs(state%t + dt) <= huge(dt))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is no longer a unit quaternion, or the time is not finite')
      end if
   end subroutine start

   !> Rejects momenta that no step of this length can follow; the equations have their own units.
   subroutine scale_unknowns(self, system, state, dt, window_time, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      if (.not. self%equations%is_in_scale()) &
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
   end subroutine scale_unknowns

   !> Computes the unknowns of a step that keeps the momentum of its start.
   subroutine explicit_guess(self, system, z)
      class(reduced_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: z(most_unknowns)
      real(wp) :: length
      z = 0.0_wp
      z(1:3) = self%equations%explicit_guess(system)
      length = maxval(abs(z))
      if (length > farthest) z = z*(farthest/length)
   end subroutine explicit_guess

   !> Computes one increment. The free part of the Jacobian is cheap: it is computed anew until the increments are
   !> small.
   subroutine correct(self, system, z, increment, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: z(most_unknowns)
      type(increment_t), intent(inout) :: increment
      type(status_t), intent(inout) :: status
      real(wp) :: f(3), d(3)
      integer :: i
      call self%equations%residual(system, z(1:3), f)
      increment%diverged = self%equations%too_strong
      if (increment%diverged) return
      if (increment%size > coarse) then
         call renew(self, system, z(1:3), status)
         if (status%code /= 0) return
         self%moved = 0.0_wp
      end if
      do i = 1, 3
         d(i) = self%rows(1, i)*f(1) + self%rows(2, i)*f(2) + self%rows(3, i)*f(3)
         z(i) = z(i) - d(i)
      end do
      increment%size = max(abs(d(1)), abs(d(2)), abs(d(3)))
      increment%attitude = increment%size
      increment%length = max(abs(z(1)), abs(z(2)), abs(z(3)))
      increment%diverged = .not. increment%length <= farthest
      self%moved = self%moved + increment%size
      self%change = increment%size
      ! F is a cubic polynomial: its second derivative bounds the next increment.
      if (self%prepared_with%tolerance <= 0.0_wp .and. self%equations%is_cubic) increment%is_last = &
         curvature*self%moved*increment%size <= (0.5_wp*eps)*increment%length*self%raw_determinant
   end subroutine correct

   !> Computes a new Jacobian at z.
   subroutine linearize(self, system, z, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: z(most_unknowns)
      type(status_t), intent(inout) :: status
      call self%equations%set_point(z(1:3))
      call renew(self, system, z(1:3), status)
   end subroutine linearize

   !> Computes a new Jacobian at the last b; the effects' part of it only if the old one is no longer worth keeping.
   subroutine renew(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      type(status_t), intent(inout) :: status
      if (self%equations%forces%active .and. self%kept_dt /= self%equations%dt) &
         call self%equations%linearize_forces(system, b)
      if (self%equations%too_strong) then
         status = fail(NUTATE_OFF_BRANCH, 'the effects are too strong for a step of this length')
         return
      end if
      self%kept_dt = self%equations%dt
      call self%equations%invert(b, self%rows, self%raw_determinant)
      self%determinant = self%raw_determinant/self%equations%unloaded
      if (.not. abs(self%raw_determinant) > least_determinant) &
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
   end subroutine renew

   pure subroutine get_start_vector(self, system, b)
      class(reduced_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: b(3)
      b = self%equations%explicit_guess(system)
   end subroutine get_start_vector

   pure subroutine unknowns_of(self, system, b, z)
      class(reduced_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: z(most_unknowns)
      z = 0.0_wp
      z(1:3) = b
   end subroutine unknowns_of

   pure subroutine get_cayley_vector(self, z, b)
      class(reduced_t), intent(inout) :: self
      real(wp), intent(in) :: z(most_unknowns)
      real(wp), intent(out) :: b(3)
      b = z(1:3)
   end subroutine get_cayley_vector

   !> Moves the state. The torque must be that after the last increment: a stiff one changes much in a small increment.
   subroutine finish(self, system, state, dt, z)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt
      real(wp), intent(in) :: z(most_unknowns)
      real(wp) :: f(3)
      self%root = z(1:3)
      if (self%equations%forces%active) then
         if (self%change*max(1.0_wp, maxval(abs(self%equations%by_forces))) > 4*eps*maxval(abs(z(1:3)))) &
            call self%equations%residual(system, z(1:3), f)
      end if
      if (system%effects%n_torques > 0) call self%equations%get_work(system, z(1:3), self%work)
      if (allocated(self%equations%spheres)) call self%equations%finish_spheres(system, z(1:3), state, self%work)
      if (self%equations%turn%there) then
         call self%equations%finish_in_frame(z(1:3), state)
      else
         call self%equations%finish(z(1:3), self%prepared_with%attitude, state)
      end if
      if (allocated(self%equations%wheels)) &
         call self%equations%wheels%finish(system%effects, self%equations%mean_rate(z(1:3)), state, self%work)
   end subroutine finish

   !> Moves sensitivities by the root of the last step. Errors: `NUTATE_BAD_ARGUMENT` if the attitude is not integrated.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%prepared_with%attitude) then
         status = fail(NUTATE_BAD_ARGUMENT, 'sensitivities need the attitude (expected attitude = .true.)', &
                       'attitude')
         return
      end if
      if (.not. allocated(self%last)) allocate (self%last)
      self%last%dt = self%equations%dt
      self%last%middle = self%equations%middle
      self%last%b = self%root
      self%last%frame = self%equations%frame
      self%last%momentum = self%equations%half_momentum(2:4)
      self%last%rotor = system%effects%rotor_momentum
      if (allocated(self%equations%wheels)) self%last%rotor = self%last%rotor + self%equations%wheels%rotor
      if (allocated(self%equations%spheres)) &
         self%last%momentum = self%last%momentum - self%equations%spheres%inner
      call self%last%propagate(system, self%equations%forces, self%equations%turn, self%equations%wheels, &
                           self%equations%spheres, tangent, status)
   end subroutine propagate_step

   !> Writes or reads the derivatives of the effects; what belongs to the length of the step is computed anew.
   subroutine transfer_form(self, archive)
      class(reduced_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%equations%by_forces)
      if (archive%is_reading()) self%equations%dt = 0.0_wp
   end subroutine transfer_form

   !> Writes the derivatives of the effects as numbers, if there are forces: the derivatives are zero otherwise, and
   !> stay.
   subroutine put_form(self, room, numbers, used)
      class(reduced_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(inout) :: numbers(room)
      integer, intent(inout) :: used
      if (self%equations%forces%active) numbers(used + 1:used + 9) = reshape(self%equations%by_forces, [9])
      used = used + 9
   end subroutine put_form

   !> Reads the derivatives of the effects from numbers. Values for the length of the step stay: it is that of the same
   !> system.
   subroutine take_form(self, room, numbers, used)
      class(reduced_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in) :: numbers(room)
      integer, intent(inout) :: used
      if (self%equations%forces%active) self%equations%by_forces = reshape(numbers(used + 1:used + 9), [3, 3])
      used = used + 9
   end subroutine take_form

end module nutate_reduced
