!> The conserving step in reduced form: three equations in the step's turn, closed-form Newton, no LAPACK.
!>
!> The same trajectory as the 8×8 system to round-off. Where nothing depends on the attitude it can be left out: then
!> only the body momentum is integrated.
module nutate_reduced
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_continuation, only: continuation_t, is_continued, is_surely_true
   use nutate_kinds, only: wp, eps
   use nutate_newton, only: attitude_noise, has_converged, patience, too_slow
   use nutate_range, only: check_start, check_system
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH, NUTATE_SINGULAR
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: reduced_t

   !> Largest |qᵀq - 1| and |qᵀp|/|p| of a state that counts as on the constraint manifold.
   real(wp), parameter :: on_manifold = 1e-9_wp
   !> Largest |qᵀq - 1| that a state can have come to since.
   real(wp), parameter :: near_manifold = 1e-8_wp
   !> Iterations of a step above which the next one starts with new derivatives of the effects, and a cautious guess.
   integer, parameter :: many = 4
   !> Who allows fewer iterations gets no walk: it takes some that converge.
   integer, parameter :: fewest = 8
   !> Increment of b above which the free part of the Jacobian, cheap as it is, is taken anew.
   real(wp), parameter :: coarse = 1e-6_wp
   !> Bound of the second derivative of the free F, by which the rate of convergence is known beforehand.
   real(wp), parameter :: curvature = 200.0_wp
   !> The turn of a step on the branch of the true motion is below 1: guesses that are longer by this factor have gone
   !> astray.
   real(wp), parameter :: astray = 1e3_wp
   !> Determinants below are those of singular systems.
   real(wp), parameter :: least_determinant = 1e-150_wp
   !> The first guess continues the b of this many steps by a polynomial: column m holds the weights of the last, the
   !> last but one, ... where m steps are known, (-1)^k (m over k+1).
   integer, parameter :: memory = 6
   real(wp), parameter :: continuation(memory, memory) = reshape([ &
      1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      2.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.0_wp, -3.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      4.0_wp, -6.0_wp, 4.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, &
      5.0_wp, -10.0_wp, 10.0_wp, -5.0_wp, 1.0_wp, 0.0_wp, &
      6.0_wp, -15.0_wp, 20.0_wp, -15.0_wp, 6.0_wp, -1.0_wp], [memory, memory])

   !> The 3×3 stepper. `step` allocates nothing.
   type, extends(stepper_t) :: reduced_t
      private
      type(integrator_settings_t) :: settings
      type(reduced_equations_t) :: equations
      !> The effects' derivatives are worth keeping.
      logical :: fresh = .false.
      !> Rows of the Jacobian's inverse, shape (3, row), and its determinant.
      real(wp) :: rows(3, 3) = 0.0_wp, determinant = 0.0_wp
      !> b of the last steps, the latest first; how many of these columns are known.
      real(wp) :: past(3, memory) = 0.0_wp
      integer :: known = 0
      !> The next step is the first since `prepare`.
      logical :: untested = .true.
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: transfer
   end type reduced_t

contains

   !> Errors: `NUTATE_BAD_ARGUMENT` where the settings switch the projection off: the reduced form has it built in;
   !> those of `check_system`.
   subroutine set_up(self, system, settings, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. settings%projection) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the reduced form cannot leave the projection out', 'projection')
         return
      end if
      call check_system(system, status)
      if (.not. status%ok()) return
      self%settings = settings
      call self%equations%forces%prepare(system%effects, .true.)
      self%equations%dt = 0.0_wp
      self%fresh = .false.
      self%known = 0
      self%untested = .true.
   end subroutine set_up

   !> One step. Errors, with the state as it was: `NUTATE_BAD_ARGUMENT` for a first state off the constraint manifold;
   !> `NUTATE_NOT_CONVERGED`, `NUTATE_SINGULAR`, `NUTATE_NOT_FINITE`; `NUTATE_OFF_BRANCH` where the branch of roots that
   !> continues the true motion from short steps ends before this one.
   subroutine advance(self, system, state, dt, window_time, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: b(3), guess(3), last

      self%continued = 0
      if (self%untested) call test_start(self, system, state, dt, status)
      if (status%code /= 0) return
      last = 0.0_wp
      if (dt /= self%equations%dt) then
         call change_step(self, system, dt)
      else if (self%known > 0) then
         last = self%determinant
      end if
      call self%equations%start(system, state, window_time)
      if (.not. (abs(self%equations%square - 1) <= near_manifold .and. abs(state%t + dt) <= huge(dt))) then
         call refuse_state(self, status)
         return
      end if
      if (self%known > 1) then
         call continue_steps(self%past, continuation(:, self%known), b)
      else
         call begin(self, system, b, status)
      end if
      if (status%code == 0) then
         guess = b
         call find_root(self, system, b, status)
         if (status%code == 0) then
            if (.not. (is_trusted(self, b) .or. &
                       is_continued(norm2(b), self%determinant, last, maxval(abs(b - guess))))) &
               status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
         end if
         if (status%code /= 0 .and. self%settings%max_iterations >= fewest) &
            call continue_to_root(self, system, state, dt, window_time, b, status)
      end if
      status%iterations = self%iterations
      status%residual = self%residual
      if (status%code /= 0) then
         self%fresh = .false.
         self%known = 0
         return
      end if
      if (system%effects%n_torques > 0) call self%equations%get_work(system, b, self%work)
      call self%equations%finish(b, self%settings%attitude, state)
      call remember(b, self%past)
      self%known = min(self%known + 1, memory)
      if (self%iterations > many) then
         ! The guess was bad: a polynomial of high degree leads astray, in the end to another root.
         self%known = min(self%known, 3)
         self%fresh = .false.
      end if
   end subroutine advance

   !> Newton's iteration, and from another guess where that fails.
   subroutine find_root(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: b(3)
      type(status_t), intent(inout) :: status
      integer :: spent
      call iterate(self, system, b, status)
      if (status%code == NUTATE_NOT_CONVERGED .and. self%known == 0 .and. self%equations%forces%active) then
         ! A stiff force may hold the body where it is.
         spent = self%iterations
         status = status_t()
         b = 0.0_wp
         self%fresh = .false.
         call iterate(self, system, b, status)
         self%iterations = self%iterations + spent
      end if
   end subroutine find_root

   !> True if the root is surely that of the true motion.
   pure logical function is_trusted(self, b)
      class(reduced_t), intent(in) :: self
      real(wp), intent(in) :: b(3)
      is_trusted = is_surely_true(sqrt(b(1)**2 + b(2)**2 + b(3)**2), self%determinant/self%equations%unloaded, &
                                  self%equations%forces%active, self%equations%forces%by_attitude)
   end function is_trusted

   !> Follows the branch of the true motion from short steps to this one. Success leaves its root in b.
   subroutine continue_to_root(self, system, state, dt, window_time, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s, and the time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      real(wp), intent(out) :: b(3)
      !> On entry: why the root found at once will not do; it stays where the branch ends.
      type(status_t), intent(inout) :: status
      type(continuation_t) :: walk
      type(status_t) :: trial
      real(wp) :: root(3), guess(3), change(3), determinant
      integer :: iterations
      logical :: found
      iterations = self%iterations
      root = 0.0_wp
      call walk%start(norm2(self%equations%first_guess(system)))
      do while (walk%goes_on())
         call self%equations%set_step(system, walk%next*dt)
         call self%equations%start(system, state, window_time)
         self%fresh = .false.
         if (walk%reached > 0.0_wp) then
            guess = root + walk%secant()*change
         else
            guess = self%equations%first_guess(system)
         end if
         b = guess
         trial = status_t()
         call iterate(self, system, b, trial)
         iterations = iterations + self%iterations
         found = trial%code == 0
         determinant = self%determinant/self%equations%unloaded
         if (found .and. walk%reached > 0.0_wp) then
            found = walk%keeps_to(norm2(b), determinant, maxval(abs(b - guess)))
         else if (found) then
            found = is_trusted(self, b)
         end if
         call walk%judge(found, norm2(b - root), determinant)
         if (.not. found) cycle
         change = b - root
         root = b
      end do
      self%iterations = iterations
      self%continued = walk%tried
      if (walk%reached >= 1.0_wp) status = status_t()
   end subroutine continue_to_root

   !> Takes another length of the step; of the past, only the last turn still says something.
   pure subroutine change_step(self, system, dt)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      if (self%known > 0) self%past(:, 1) = (dt/self%equations%dt)*self%past(:, 1)
      self%known = min(self%known, 1)
      call self%equations%set_step(system, dt)
      self%fresh = .false.
   end subroutine change_step

   !> The guess where at most one step is known. Refuses momenta that no step of this length can follow.
   subroutine begin(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: b(3)
      type(status_t), intent(inout) :: status
      real(wp) :: length
      self%iterations = 0
      if (self%known > 0) then
         b = self%past(:, 1)
      else
         b = self%equations%first_guess(system)
      end if
      length = maxval(abs(b))
      if (length > astray) b = b*(astray/length)
      if (.not. self%equations%is_in_scale()) &
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
   end subroutine begin

   !> The polynomial through the last steps: b = Σₖ weightsₖ pastₖ.
   pure subroutine continue_steps(past, weights, b)
      real(wp), intent(in) :: past(3, memory), weights(memory)
      real(wp), intent(out) :: b(3)
      integer :: i
      do i = 1, 3
         b(i) = (past(i, 1)*weights(1) + past(i, 2)*weights(2) + past(i, 3)*weights(3)) &
                + (past(i, 4)*weights(4) + past(i, 5)*weights(5) + past(i, 6)*weights(6))
      end do
   end subroutine continue_steps

   !> Puts the b of a step before those of the earlier ones.
   pure subroutine remember(b, past)
      real(wp), intent(in) :: b(3)
      real(wp), intent(inout) :: past(3, memory)
      integer :: i, k
      do i = 1, 3
         do k = memory, 2, -1
            past(i, k) = past(i, k - 1)
         end do
         past(i, 1) = b(i)
      end do
   end subroutine remember

   !> Refuses a state that is not a rotating body's, or beyond all scales.
   subroutine test_start(self, system, state, dt, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      call check_start(system, state, dt, status)
      if (status%code /= 0) return
      if (.not. (abs(dot_product(state%q, state%q) - 1) <= on_manifold .and. &
                 abs(dot_product(state%q, state%p)) <= on_manifold*norm2(state%p))) then
         status = fail(NUTATE_BAD_ARGUMENT, "the reduced form needs |q| = 1 and q.p = 0 "// &
                       "(linear_solver = 'lapack' does not)")
         return
      end if
      self%untested = .false.
   end subroutine test_start

   !> A state that was broken since the last step.
   subroutine refuse_state(self, status)
      class(reduced_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is no unit quaternion any more, or the time is not finite')
      self%fresh = .false.
      self%known = 0
   end subroutine refuse_state

   !> Newton's iteration from the guess b to the root.
   subroutine iterate(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: b(3)
      type(status_t), intent(inout) :: status
      real(wp) :: f(3), d(3), change, previous, length, moved
      integer :: i, k, stalled

      previous = huge(1.0_wp)
      change = previous
      moved = 0.0_wp
      stalled = 0
      do k = 1, self%settings%max_iterations
         self%iterations = k
         if (change > coarse) then
            call renew(self, system, b, status)
            if (status%code /= 0) return
            moved = 0.0_wp
         end if
         call self%equations%residual(system, b, f)
         if (self%equations%too_strong) exit
         do i = 1, 3
            d(i) = self%rows(1, i)*f(1) + self%rows(2, i)*f(2) + self%rows(3, i)*f(3)
            b(i) = b(i) - d(i)
         end do
         change = max(abs(d(1)), abs(d(2)), abs(d(3)))
         length = max(abs(b(1)), abs(b(2)), abs(b(3)))
         if (.not. length <= astray) exit
         moved = moved + change
         if (change > 0.5_wp*previous .and. change <= attitude_noise) stalled = stalled + 1
         if (is_done(self, change, previous, moved, length) .or. &
             (stalled >= patience .and. self%settings%tolerance <= 0.0_wp)) then
            self%residual = 0.0_wp
            if (length > 0.0_wp) self%residual = change/length
            ! The last step of the iteration must not leave the torque behind: a stiff one goes far in a small step.
            if (self%equations%forces%active) then
               if (change*max(1.0_wp, maxval(abs(self%equations%by_forces))) > 4*eps*length) &
                  call self%equations%residual(system, b, f)
            end if
            return
         end if
         if (change > too_slow*previous) self%fresh = .false.
         previous = change
      end do
      if (.not. all(ieee_is_finite(b))) then
         status = fail(NUTATE_NOT_FINITE, 'the step gave a number that is not finite')
      else
         status = fail(NUTATE_NOT_CONVERGED, 'the Newton iteration of the step did not converge')
      end if
   end subroutine iterate

   !> True if a further increment would change nothing. Without effects F is a cubic polynomial whose derivative changes
   !> by less than `curvature` times the way from where the Jacobian was taken: this bounds the next increment.
   pure logical function is_done(self, change, previous, moved, length)
      type(reduced_t), intent(in) :: self
      !> Largest entry of the present and of the previous increment, of the way since the Jacobian, and of b.
      real(wp), intent(in) :: change, previous, moved, length
      is_done = .false.
      if (self%settings%tolerance <= 0.0_wp .and. .not. self%equations%forces%active) &
         is_done = curvature*moved*change <= (0.5_wp*eps)*length*self%determinant
      if (.not. is_done) is_done = has_converged(change, previous, length, self%settings%tolerance)
   end function is_done

   !> A new Jacobian at b; the effects' part of it only if it is no longer worth keeping.
   subroutine renew(self, system, b, status)
      type(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      type(status_t), intent(inout) :: status
      if (self%equations%forces%active .and. .not. self%fresh) call self%equations%linearize_forces(system, b)
      if (self%equations%too_strong) then
         status = fail(NUTATE_OFF_BRANCH, 'the effects are too strong for a step of this length')
         return
      end if
      self%fresh = .true.
      call self%equations%invert(b, self%rows, self%determinant)
      if (.not. abs(self%determinant) > least_determinant) &
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
   end subroutine renew

   !> Length of the step, derivatives of the effects, past turns; the Jacobian is taken anew in every step.
   subroutine transfer(self, system, archive)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(archive_t), intent(inout) :: archive
      real(wp) :: dt
      dt = self%equations%dt
      call archive%transfer(self%untested)
      call archive%transfer(dt)
      call archive%transfer(self%fresh)
      call archive%transfer(self%determinant)
      call archive%transfer(self%equations%by_forces)
      call archive%transfer(self%past)
      call archive%transfer(self%known)
      if (archive%is_reading() .and. abs(dt) > 0.0_wp) call self%equations%set_step(system, dt)
   end subroutine transfer

end module nutate_reduced
