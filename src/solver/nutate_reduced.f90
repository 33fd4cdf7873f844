!> The conserving step in reduced form: three equations in the step's turn, closed-form Newton, no LAPACK.
!>
!> The same trajectory as the 8×8 system to round-off. Where nothing depends on the attitude it can be left out: then
!> only the body momentum is integrated.
module nutate_reduced
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp
   use nutate_newton, only: continue_steps, degree, has_converged, remember, too_slow
   use nutate_quaternion, only: cross, quat_product
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH, NUTATE_SINGULAR
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: reduced_t

   !> Largest |qᵀq - 1| and |qᵀp|/|p| of a state that counts as on the constraint manifold.
   real(wp), parameter :: on_manifold = 1e-9_wp
   !> Iterations of a step above which the next one starts with a new Jacobian: it costs about as much as two
   !> iterations.
   integer, parameter :: many = 3

   !> The 3×3 stepper. `step` allocates nothing.
   type, extends(stepper_t) :: reduced_t
      private
      type(integrator_settings_t) :: settings
      type(reduced_equations_t) :: equations
      !> Inverse of a Jacobian, and whether its determinant is positive.
      real(wp) :: inverse(3, 3) = 0.0_wp
      logical :: positive = .false.
      !> The inverse is worth keeping.
      logical :: fresh = .false.
      !> b of the last step and its backward differences; how many of these columns are known.
      real(wp) :: differences(3, 0:degree) = 0.0_wp
      integer :: known = 0
      !> The next step is the first since `prepare`.
      logical :: untested = .true.
   contains
      procedure :: prepare
      procedure :: step
   end type reduced_t

contains

   !> Errors: `NUTATE_BAD_ARGUMENT` where the settings switch the projection off: the reduced form has it built in.
   subroutine prepare(self, system, settings, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(out) :: status
      if (.not. settings%projection) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the reduced form cannot leave the projection out', 'projection')
         return
      end if
      self%settings = settings
      call self%equations%forces%prepare(system%effects, .true.)
      self%equations%dt = 0.0_wp
      self%fresh = .false.
      self%known = 0
      self%untested = .true.
      if (allocated(self%work)) deallocate (self%work)
      allocate (self%work(system%effects%n_torques), source=0.0_wp)
   end subroutine prepare

   !> One step. Errors, with the state as it was: `NUTATE_BAD_ARGUMENT` for a first state off the constraint manifold;
   !> `NUTATE_NOT_CONVERGED`, `NUTATE_SINGULAR`, `NUTATE_NOT_FINITE`; `NUTATE_OFF_BRANCH` where |b| >= 1 or the
   !> determinant of the Jacobian is not positive: the root is not the continuation of the true motion from short steps.
   subroutine step(self, system, state, dt, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      real(wp) :: b(3), change(3), old_dt, decisive

      if (self%untested) call test_manifold(self, state, status)
      if (status%code /= 0) return
      old_dt = self%equations%dt
      if (dt /= old_dt) then
         call self%equations%set_step(system, dt)
         self%fresh = .false.
         if (self%known > 0) self%differences(:, 0) = (dt/old_dt)*self%differences(:, 0)
         self%known = min(self%known, 1)
      end if
      decisive = state%t + 0.5_wp*dt
      if (self%is_part) decisive = self%whole_middle
      call self%equations%start(system, state, decisive)
      if (self%known > 0) then
         call continue_steps(3, self%differences, self%known, b)
      else
         b = matmul(self%equations%to_turn, self%equations%momentum - self%equations%rotor)
      end if
      call iterate(self, system, b, status)
      if (status%code == 0 .and. .not. (self%positive .and. dot_product(b, b) < 1.0_wp)) &
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
      status%iterations = self%iterations
      status%residual = self%residual
      if (status%code /= 0) then
         self%fresh = .false.
         self%known = 0
         return
      end if
      call self%equations%finish(system, b, change, self%work)
      call accept(self, state, dt, b, change)
   end subroutine step

   !> Refuses a state that is not a rotating body's.
   subroutine test_manifold(self, state, status)
      class(reduced_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      type(status_t), intent(inout) :: status
      if (.not. (abs(dot_product(state%q, state%q) - 1) <= on_manifold .and. &
                 abs(dot_product(state%q, state%p)) <= on_manifold*norm2(state%p))) then
         status = fail(NUTATE_BAD_ARGUMENT, "the reduced form needs |q| = 1 and q.p = 0 "// &
                       "(linear_solver = 'lapack' does not)")
         return
      end if
      self%untested = .false.
   end subroutine test_manifold

   !> Moves the state: q1 - q0 = q0∘(c - 1), p1 - p0 = 2u∘((c - 1)∘L1 + L1 - L0), L1 with the scalar that p0 brought
   !> along; without attitude p1 - p0 = 2u∘(L1 - L0).
   pure subroutine accept(self, state, dt, b, change)
      class(reduced_t), intent(inout) :: self
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, b(3), change(3)
      real(wp) :: turn(4), push(4), beta
      push = [0.0_wp, change]
      if (self%settings%attitude) then
         beta = dot_product(b, b)
         turn = (2/(1 + beta))*[-beta, b]
         push = push + quat_product(turn, self%equations%half_momentum + push)
         call add_increment(state%q, state%q_carry, quat_product(state%q, turn))
      end if
      call add_increment(state%p, state%p_carry, 2*quat_product(self%equations%frame, push))
      state%t = state%t + dt
      call remember(3, b, self%differences, self%known)
      if (self%iterations > many) self%fresh = .false.
   end subroutine accept

   !> Newton's iteration from the guess b to the root.
   subroutine iterate(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: b(3)
      type(status_t), intent(inout) :: status
      real(wp) :: f(3), d(3), change, previous, length
      integer :: k

      previous = huge(1.0_wp)
      do k = 1, self%settings%max_iterations
         self%iterations = k
         if (.not. self%fresh) then
            call invert(self, system, b, status)
            if (status%code /= 0) return
         end if
         call self%equations%residual(system, b, f)
         d = self%inverse(:, 1)*f(1) + self%inverse(:, 2)*f(2) + self%inverse(:, 3)*f(3)
         b = b - d
         change = maxval(abs(d))
         length = maxval(abs(b))
         ! The turn of a step on the branch of the true motion is below 1.
         if (.not. length <= 1e3_wp) exit
         self%residual = 0.0_wp
         if (length > 0.0_wp) self%residual = change/length
         if (has_converged(change, previous, length, self%settings%tolerance)) return
         if (change > too_slow*previous) self%fresh = .false.
         previous = change
      end do
      if (.not. all(ieee_is_finite(b))) then
         status = fail(NUTATE_NOT_FINITE, 'the step gave a number that is not finite')
      else
         status = fail(NUTATE_NOT_CONVERGED, 'the Newton iteration of the step did not converge')
      end if
   end subroutine iterate

   !> A new Jacobian at b, its inverse from the adjugate, and the sign of its determinant.
   subroutine invert(self, system, b, status)
      class(reduced_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      type(status_t), intent(inout) :: status
      real(wp) :: matrix(3, 3), determinant
      call self%equations%jacobian(system, b, matrix)
      self%inverse(1, :) = cross(matrix(:, 2), matrix(:, 3))
      self%inverse(2, :) = cross(matrix(:, 3), matrix(:, 1))
      self%inverse(3, :) = cross(matrix(:, 1), matrix(:, 2))
      determinant = dot_product(self%inverse(1, :), matrix(:, 1))
      if (.not. abs(determinant) > tiny(1.0_wp)) then
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
         return
      end if
      self%inverse = self%inverse/determinant
      self%positive = determinant > 0.0_wp
      self%fresh = .true.
   end subroutine invert

end module nutate_reduced
