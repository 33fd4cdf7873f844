!> The implicit step, for any form of its equations: prediction, modified Newton iteration, acceptance of the root,
!> proof that it is that of the true motion (`nutate_root_proof`), or continuation in Δt if there is no proof.
!>
!> The unknowns are predicted by continuing the increments of the last steps. The iteration is the modified (chord)
!> Newton method: the expensive part of the Jacobian is kept as long as the iteration converges fast with it, over many
!> steps if possible. By default the iteration goes on until the increments stop falling, since every digit that is not
!> resolved becomes a drift of the invariants. A form of the equations adds its mathematics: start, increment, Jacobian,
!> update.
module nutate_implicit_step
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_continuation, only: continuation_t, root_acceptance_t, root_t
   use nutate_hamiltonian, only: system_t, time_dependent_work
   use nutate_kinds, only: wp, eps
   use nutate_predictor, only: most_unknowns, predictor_t
   use nutate_range, only: check_start, check_system
   use nutate_root_proof, only: BEYOND_PROOF, CERTIFIED, root_proof_t
   use nutate_small_products, only: vector_length
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH
   use nutate_stepper, only: stepper_t
   use nutate_varying_inertia, only: check_inertia_at
   implicit none
   private

   public :: implicit_stepper_t, increment_t, most_cancellation, most_unknowns, usual_cancellation

   !> Factor per iteration above which increments fall too slowly: a new Jacobian, with quadratic convergence, is then
   !> cheaper than the remaining iterations to round-off.
   real(wp), parameter :: too_slow = 0.1_wp
   !> A force that varies steeply with the attitude is as uncertain as the attitude's own round-off makes it, however
   !> short the step: increments of the attitude (rad) at this level, a rounding of each of some 16 products, that
   !> failed to fall so many times (not by chance) are that noise.
   real(wp), parameter :: attitude_noise = 16*eps
   integer, parameter :: most_stalls = 3
   !> Number of steps that the predictor keeps after one that it predicted badly: a polynomial of higher degree would
   !> extrapolate the bad step, in the end to another root.
   integer, parameter :: kept_after_surprise = 3
   !> Largest number of iterations from a prediction of a continuation, which is near the root or of no use. There is no
   !> continuation if a step is allowed fewer iterations than the second.
   integer, parameter :: near = 12, fewest = 8

   character(len=*), parameter :: too_long = 'the step is too long to follow the motion', &
                                  no_convergence = 'the Newton iteration of the step did not converge'

   !> Relative increment that is round-off of the residual: of a sum and a product.
   real(wp), parameter :: round_off = 2*eps
   !> Relative increment below which an iteration that no longer falls has reached round-off, of sums whose terms may be
   !> so many times the result.
   real(wp), parameter :: usual_cancellation = 1e4_wp
   !> Factor between terms and result above which the root of a needle has lost so many digits of the rotation about it
   !> that its energy is no longer kept to round-off.
   real(wp), parameter :: most_cancellation = 1e6_wp

   !> Size of a Newton increment, and reasons to end the iteration.
   type :: increment_t
      !> Largest entry of the increment, and of the unknowns.
      real(wp) :: size = huge(1.0_wp), length = 0.0_wp
      !> Largest entry of the part of the increment that is the attitude's, rad of half the turn.
      real(wp) :: attitude = 0.0_wp
      !> The unknowns left all bounds.
      logical :: diverged = .false.
      !> A bound says that no further increment would change anything.
      logical :: is_last = .false.
   end type increment_t

   !> A step whose unknowns solve equations; a form of them adds its mathematics. `advance` allocates nothing.
   type, abstract, extends(stepper_t) :: implicit_stepper_t
      type(predictor_t) :: predictor
      type(root_proof_t) :: proof
      type(root_acceptance_t) :: acceptance
      !> Determinant of the Jacobian last computed, over that of a very short step.
      real(wp) :: determinant = 0.0_wp
      !> Step to which the kept part of the Jacobian belongs, s; 0: there is none that is worth keeping.
      real(wp) :: kept_dt = 0.0_wp
      !> Largest ratio of terms to result in the equations linearized last.
      real(wp) :: cancellation = usual_cancellation
      !> True if the stage that was started is on the constraint manifold and stays there, as the proof of a root
      !> assumes.
      logical :: on_manifold = .true.
      !> The next step is the first since `prepare`.
      logical :: untested = .true.
      !> Iterations of a step above which the next one starts with a new Jacobian.
      integer, private :: slow = 0
   contains
      !> Sets the state and the length of a step. Rejects states that the form cannot move.
      procedure(start_equations), deferred :: start
      !> Chooses units for a step that was started and for which no Jacobian was kept.
      procedure(choose_units), deferred :: scale_unknowns
      !> Computes the unknowns of a step with the rates of its start.
      procedure(extrapolate), deferred :: explicit_guess
      !> Computes one increment of the modified Newton iteration.
      procedure(correct_unknowns), deferred :: correct
      !> Computes a new Jacobian, with its determinant.
      procedure(linearize_equations), deferred :: linearize
      !> Computes b0 = ¼Δt J⁻¹(L0 - h), the b of a step with constant momentum.
      procedure(find_start_vector), deferred :: get_start_vector
      !> Computes the unknowns that belong to a b.
      procedure(find_unknowns), deferred :: unknowns_of
      !> Computes the b of a root: the vector of its Cayley map.
      procedure(find_cayley_vector), deferred :: get_cayley_vector
      !> Moves the state to the end of the step.
      procedure(move_state), deferred :: finish
      !> Writes or reads the data that the form keeps beside unknowns.
      procedure(transfer_more), deferred :: transfer_form
      !> Writes the data of `transfer_form` as numbers, and reads them.
      procedure(put_numbers), deferred :: put_form
      procedure(take_numbers), deferred :: take_form
      !> Starts anew with a system; to be called by the form's `set_up`.
      procedure, non_overridable :: begin
      procedure :: advance
      procedure :: transfer
      procedure :: put_memory
      procedure :: take_memory
      procedure :: forget_steps
   end type implicit_stepper_t

   abstract interface
      !> Errors: `NUTATE_BAD_ARGUMENT`.
      subroutine start_equations(self, system, state, dt, window_time, status)
         import :: implicit_stepper_t, system_t, state_t, status_t, wp
         class(implicit_stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> Length of the step, and time that decides which torques act, s.
         real(wp), intent(in) :: dt, window_time
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine start_equations

      !> Errors: `NUTATE_OFF_BRANCH` if the rotation in the step exceeds all bounds.
      subroutine choose_units(self, system, state, dt, window_time, status)
         import :: implicit_stepper_t, system_t, state_t, status_t, wp
         class(implicit_stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         real(wp), intent(in) :: dt, window_time
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine choose_units

      subroutine extrapolate(self, system, z)
         import :: implicit_stepper_t, system_t, most_unknowns, wp
         class(implicit_stepper_t), intent(in) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(out) :: z(most_unknowns)
      end subroutine extrapolate

      !> Errors: `NUTATE_SINGULAR`, `NUTATE_OFF_BRANCH` for effects too strong for the step.
      subroutine correct_unknowns(self, system, z, increment, status)
         import :: implicit_stepper_t, system_t, increment_t, status_t, most_unknowns, wp
         class(implicit_stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(inout) :: z(most_unknowns)
         !> The previous one on entry.
         type(increment_t), intent(inout) :: increment
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine correct_unknowns

      !> Errors as for `correct`.
      subroutine linearize_equations(self, system, z, status)
         import :: implicit_stepper_t, system_t, status_t, most_unknowns, wp
         class(implicit_stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(in) :: z(most_unknowns)
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine linearize_equations

      pure subroutine find_cayley_vector(self, z, b)
         import :: implicit_stepper_t, most_unknowns, wp
         class(implicit_stepper_t), intent(inout) :: self
         real(wp), intent(in) :: z(most_unknowns)
         !> b = ¼Δt Ω̄, body axes; shape (3).
         real(wp), intent(out) :: b(3)
      end subroutine find_cayley_vector

      pure subroutine find_start_vector(self, system, b)
         import :: implicit_stepper_t, system_t, wp
         class(implicit_stepper_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> Body axes; shape (3).
         real(wp), intent(out) :: b(3)
      end subroutine find_start_vector

      pure subroutine find_unknowns(self, system, b, z)
         import :: implicit_stepper_t, system_t, most_unknowns, wp
         class(implicit_stepper_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> b = ¼Δt Ω̄, body axes; shape (3).
         real(wp), intent(in) :: b(3)
         real(wp), intent(out) :: z(most_unknowns)
      end subroutine find_unknowns

      subroutine move_state(self, system, state, dt, z)
         import :: implicit_stepper_t, system_t, state_t, most_unknowns, wp
         class(implicit_stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
         real(wp), intent(in) :: dt
         !> Root for which `get_cayley_vector` was called last.
         real(wp), intent(in) :: z(most_unknowns)
      end subroutine move_state

      subroutine transfer_more(self, archive)
         import :: implicit_stepper_t, archive_t
         class(implicit_stepper_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_more

      !> Writes or reads numbers; `used` is the number in use, before and after.
      subroutine put_numbers(self, room, numbers, used)
         import :: implicit_stepper_t, wp
         class(implicit_stepper_t), intent(inout) :: self
         integer, intent(in) :: room
         real(wp), intent(inout) :: numbers(room)
         integer, intent(inout) :: used
      end subroutine put_numbers

      subroutine take_numbers(self, room, numbers, used)
         import :: implicit_stepper_t, wp
         class(implicit_stepper_t), intent(inout) :: self
         integer, intent(in) :: room
         real(wp), intent(in) :: numbers(room)
         integer, intent(inout) :: used
      end subroutine take_numbers
   end interface

contains

   !> Starts anew with a system. Errors: those of `check_system`.
   subroutine begin(self, system, unknowns, slow, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Number of unknowns.
      integer, intent(in) :: unknowns
      !> Iterations of a step above which the next one starts with a new Jacobian.
      integer, intent(in) :: slow
      type(status_t), intent(inout) :: status
      call check_system(system, status)
      if (status%ok() .and. system%effects%feeds_back_to_wheels()) status = fail( &
         NUTATE_BAD_ARGUMENT, 'a continuous controller drives wheels (expected sample in it, or method = '// &
                                                       "'dop853' with conserve = .true.)", 'method')
      if (.not. status%ok()) return
      self%slow = slow
      self%untested = .true.
      self%kept_dt = 0.0_wp
      self%determinant = 0.0_wp
      call self%predictor%set_up(unknowns)
      call self%acceptance%set_up(system)
      call self%proof%set_up(system)
   end subroutine begin

   !> Performs one step. Errors, with the state unchanged: `NUTATE_BAD_ARGUMENT` for a state that the form cannot move;
   !> `NUTATE_NOT_CONVERGED`, `NUTATE_SINGULAR`, `NUTATE_NOT_FINITE`; `NUTATE_OFF_BRANCH` if the branch of roots that
   !> continues the true motion from short steps ends before this one.
   subroutine advance(self, system, state, dt, window_time, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: z(most_unknowns)
      self%iterations = 0
      self%continued = 0
      self%uncertified = 0
      if (self%untested) call check_start(system, state, dt, status)
      if (system%effects%varies .and. status%code == 0) call check_inertia_at(system, state%t + dt, status)
      if (status%code == 0) call self%start(system, state, dt, window_time, status)
      if (status%code == 0 .and. dt /= self%kept_dt) &
         call self%scale_unknowns(system, state, dt, window_time, status)
      if (status%code == 0) call find_true_root(self, system, state, dt, window_time, z, status)
      status%iterations = self%iterations
      status%residual = self%residual
      if (status%code /= 0) then
         self%kept_dt = 0.0_wp
         call self%predictor%forget(0)
         return
      end if
      self%untested = .false.
      if (system%effects%depends_on_time) then
         call finish_time_dependent(self, system, state, dt, z)
      else
         call self%finish(system, state, dt, z)
      end if
      call self%predictor%remember(dt, z)
      if (self%iterations > self%slow) then
         call self%predictor%forget(kept_after_surprise)
         self%kept_dt = 0.0_wp
      end if
   end subroutine advance

   !> Moves the state, and adds the work of the dependence on time.
   subroutine finish_time_dependent(self, system, state, dt, z)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, z(most_unknowns)
      type(state_t) :: before
      before = state
      call self%finish(system, state, dt, z)
      self%work(size(self%work)) = time_dependent_work(system, before, state, dt)
      state%time_dependent_work = state%time_dependent_work + self%work(size(self%work))
      state%time_dependent_until = state%t
   end subroutine finish_time_dependent

   !> Finds the root that continues the true motion: certified, or by a rule if nothing can be certified. Errors: those
   !> of `iterate`; `NUTATE_OFF_BRANCH`.
   subroutine find_true_root(self, system, state, dt, window_time, z, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      real(wp), intent(out) :: z(most_unknowns)
      type(status_t), intent(inout) :: status
      real(wp) :: start(3), b(3), last
      integer :: verdict
      last = 0.0_wp
      if (dt == self%predictor%dt .and. self%predictor%known > 0) last = self%determinant
      call find_root(self, system, dt, z, status)
      b = huge(1.0_wp)
      if (status%code == 0) then
         call self%get_cayley_vector(z, b)
         ! Most steps end here: a call would cost up to 2 % of them.
         if (dt == self%proof%length .and. window_time > self%proof%from .and. window_time < self%proof%to .and. &
             self%on_manifold) then
            if (b(1)*b(1) + b(2)*b(2) + b(3)*b(3) < self%proof%near .and. self%determinant > 0.0_wp) return
         end if
      end if
      verdict = BEYOND_PROOF
      if (self%on_manifold .and. self%proof%applies) then
         call self%get_start_vector(system, start)
         if (self%proof%holds(system, state, dt, window_time, start, b, self%determinant)) return
         if (self%prepared_with%max_iterations >= fewest) &
            call self%proof%certify(system, state, dt, window_time, start, b, verdict)
         self%continued = self%proof%tried
      end if
      select case (verdict)
      case (CERTIFIED)
         if (status%code == 0 .and. self%proof%is_root(b)) return
         call use_followed_root(self, system, z, status)
      case (BEYOND_PROOF)
         self%uncertified = 1
         call use_likely_root(self, system, state, dt, window_time, last, b, z, status)
      case default
         status = fail(NUTATE_OFF_BRANCH, too_long)
      end select
   end subroutine find_true_root

   !> Finds the root next to the prediction. Errors: those of `iterate`.
   subroutine find_root(self, system, dt, z, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      real(wp), intent(out) :: z(most_unknowns)
      type(status_t), intent(inout) :: status
      if (self%predictor%known > 0) then
         call self%predictor%predict(dt)
      else
         call self%explicit_guess(system, self%predictor%guess)
      end if
      z = self%predictor%guess
      call iterate(self, system, z, self%prepared_with%max_iterations, status)
      if (status%code == NUTATE_NOT_CONVERGED .and. self%predictor%known == 0 .and. self%acceptance%forced) then
         ! A stiff force may hold the body where it is.
         status = status_t()
         z = 0.0_wp
         self%kept_dt = 0.0_wp
         call iterate(self, system, z, self%prepared_with%max_iterations, status)
      end if
   end subroutine find_root

   !> Uses the root to which the branch was followed. Errors: those of `iterate`; `NUTATE_OFF_BRANCH`.
   subroutine use_followed_root(self, system, z, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: z(most_unknowns)
      type(status_t), intent(inout) :: status
      real(wp) :: b(3)
      status = status_t()
      call self%unknowns_of(system, self%proof%b, z)
      self%kept_dt = 0.0_wp
      call iterate(self, system, z, self%prepared_with%max_iterations, status, known=.true.)
      if (status%code /= 0) return
      call self%get_cayley_vector(z, b)
      if (.not. self%proof%is_root(b)) status = fail(NUTATE_OFF_BRANCH, too_long)
      if (self%cancellation > most_cancellation) status = fail(NUTATE_NOT_CONVERGED, no_convergence)
   end subroutine use_followed_root

   !> Uses the root found if it is near that of a short step or continues that of the last step; otherwise that of a
   !> continuation in Δt. Errors: those of `iterate`; `NUTATE_OFF_BRANCH`.
   subroutine use_likely_root(self, system, state, dt, window_time, last, b, z, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      !> Determinant of the last step of the same length, 0 if there is none; b of the root found.
      real(wp), intent(in) :: last, b(3)
      !> Root found, on entry.
      real(wp), intent(inout) :: z(most_unknowns)
      !> Status of the search for this root.
      type(status_t), intent(inout) :: status
      type(root_t) :: root
      if (status%code == 0) then
         root%turn = vector_length(b)
         root%determinant = self%determinant
         if (self%acceptance%accepts(root)) return
         root%jump = maxval(abs(z - self%predictor%guess))
         if (self%acceptance%continues(root, last)) return
         status = fail(NUTATE_OFF_BRANCH, too_long)
      end if
      if (self%prepared_with%max_iterations >= fewest) &
         call continue_to_root(self, system, state, dt, window_time, z, status)
   end subroutine use_likely_root

   !> Follows the branch of the true motion from short steps to this one. On success z is its root.
   subroutine continue_to_root(self, system, state, dt, window_time, z, status)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      real(wp), intent(out) :: z(most_unknowns)
      !> On entry the reason why the root found directly is rejected; unchanged if the branch ends.
      type(status_t), intent(inout) :: status
      type(continuation_t) :: path
      real(wp) :: last(most_unknowns), change(most_unknowns), b(3), last_b(3)
      logical :: found
      last = 0.0_wp
      last_b = 0.0_wp
      change = 0.0_wp
      path = self%acceptance%begin(system, state, dt)
      do while (path%goes_on())
         call try_length(path%next*dt)
         if (.not. found) cycle
         change = z - last
         last = z
         last_b = b
      end do
      self%continued = self%continued + path%tried
      if (path%reached >= 1.0_wp) status = status_t()

   contains

      !> Finds the root of a shorter step, and whether it is on the branch.
      subroutine try_length(length)
         !> Length of the shorter step, s.
         real(wp), intent(in) :: length
         real(wp) :: predicted(most_unknowns)
         type(root_t) :: root
         type(status_t) :: trial
         call self%start(system, state, length, window_time, trial)
         if (path%reached > 0.0_wp) then
            predicted = last + path%secant()*change
         else
            call self%explicit_guess(system, predicted)
         end if
         z = predicted
         self%kept_dt = 0.0_wp
         call iterate(self, system, z, min(near, self%prepared_with%max_iterations), trial)
         ! The determinant is needed at the root itself.
         if (trial%code == 0) call self%linearize(system, z, trial)
         found = trial%code == 0
         if (found) then
            call self%get_cayley_vector(z, b)
            root = root_t(vector_length(b), self%determinant, maxval(abs(z - predicted)))
         else
            ! The result of a failed search need not be finite.
            b = last_b
         end if
         if (found .and. path%reached > 0.0_wp) then
            found = path%keeps_to(root)
         else if (found) then
            found = self%acceptance%accepts(root)
         end if
         call path%record_trial(found, vector_length(b - last_b), self%determinant)
      end subroutine try_length

   end subroutine continue_to_root

   !> Performs the modified Newton iteration from the prediction z to a root. Errors: those of an increment;
   !> `NUTATE_NOT_CONVERGED`, `NUTATE_NOT_FINITE`.
   subroutine iterate(self, system, z, most, status, known)
      class(implicit_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: z(most_unknowns)
      !> Largest number of iterations.
      integer, intent(in) :: most
      type(status_t), intent(inout) :: status
      !> True if z is the root up to a round-off that the form determines; default `.false.`.
      logical, intent(in), optional :: known
      type(increment_t) :: increment
      real(wp) :: previous
      integer :: k, stalls
      logical :: to_noise

      stalls = 0
      to_noise = .false.
      if (present(known)) to_noise = known
      do k = 1, most
         self%iterations = self%iterations + 1
         previous = increment%size
         call self%correct(system, z, increment, status)
         if (status%code /= 0) return
         if (increment%diverged) exit
         if (increment%is_last) exit
         if (has_converged(increment, previous, self%prepared_with%tolerance, &
                           merge(self%cancellation, usual_cancellation, to_noise))) exit
         if (increment%size > too_slow*previous) then
            if (increment%size > 0.5_wp*previous .and. increment%attitude <= attitude_noise) stalls = stalls + 1
            if (stalls >= most_stalls .and. self%prepared_with%tolerance <= 0.0_wp) exit
            self%kept_dt = 0.0_wp
         end if
      end do
      self%residual = 0.0_wp
      if (increment%length > 0.0_wp) self%residual = increment%size/increment%length
      if (k <= most .and. .not. increment%diverged) return
      if (.not. ieee_is_finite(sum(z))) then
         status = fail(NUTATE_NOT_FINITE, 'the step gave a number that is not finite')
      else
         status = fail(NUTATE_NOT_CONVERGED, no_convergence)
      end if
   end subroutine iterate

   !> Returns true if a further increment would change nothing: the present one is below the tolerance, or, by default,
   !> so close to round-off that even at the slowest rate the next is below it, or the increments stopped falling at
   !> that level. The rate at which they fell so far holds only for the directions seen so far: relying on it makes the
   !> energy drift.
   pure logical function has_converged(increment, previous, tolerance, cancellation)
      type(increment_t), intent(in) :: increment
      !> Largest entry of the previous increment.
      real(wp), intent(in) :: previous
      !> 0: until the increment stops falling.
      real(wp), intent(in) :: tolerance
      !> Largest ratio of terms to result in the equations.
      real(wp), intent(in) :: cancellation
      associate (size => increment%size, length => increment%length)
         if (tolerance > 0.0_wp) then
            has_converged = size <= tolerance*length
         else
            has_converged = size <= round_off*length .or. (size > 0.5_wp*previous .and. size <= cancellation*eps*length)
         end if
      end associate
   end function has_converged

   !> Discards predictions and Jacobian: the next step starts without them.
   subroutine forget_steps(self)
      class(implicit_stepper_t), intent(inout) :: self
      self%kept_dt = 0.0_wp
      call self%predictor%forget(0)
   end subroutine forget_steps

   !> Writes or reads the data that the stepper keeps of its steps.
   subroutine transfer(self, archive)
      class(implicit_stepper_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%untested)
      call archive%transfer(self%determinant)
      call archive%transfer(self%kept_dt)
      call self%predictor%transfer(archive)
      call self%transfer_form(archive)
   end subroutine transfer

   !> Writes the data of `transfer` as numbers.
   recursive subroutine put_memory(self, room, numbers, used)
      class(implicit_stepper_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(inout), target :: numbers(room)
      integer, intent(inout) :: used
      numbers(used + 1) = merge(1.0_wp, 0.0_wp, self%untested)
      numbers(used + 2) = self%determinant
      numbers(used + 3) = self%kept_dt
      used = used + 3
      call self%predictor%put(room, numbers, used)
      call self%put_form(room, numbers, used)
   end subroutine put_memory

   !> Reads the data of `transfer` from numbers.
   recursive subroutine take_memory(self, room, numbers, used)
      class(implicit_stepper_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in), target :: numbers(room)
      integer, intent(inout) :: used
      self%untested = numbers(used + 1) > 0.5_wp
      self%determinant = numbers(used + 2)
      self%kept_dt = numbers(used + 3)
      used = used + 3
      call self%predictor%take(room, numbers, used)
      call self%take_form(room, numbers, used)
   end subroutine take_memory

end module nutate_implicit_step
