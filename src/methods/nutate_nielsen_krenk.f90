!> The conserving step of Nielsen & Krenk (2012): eight equations in q and p, Newton's method with the analytic
!> Jacobian, LAPACK.
!>
!> The inverse of the Jacobian is kept as long as the iteration converges fast with it, over many steps if need be; the
!> first guess continues the increments of the last steps. By default the iteration goes on until the increments stop
!> falling, since every digit left on the table is a drift of the invariants.
module nutate_nielsen_krenk
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_continuation, only: continuation_t, is_continued, is_surely_true
   use nutate_effect, only: are_in_range
   use nutate_kinds, only: wp
   use nutate_lapack, only: dgetrf, dgetrs, handle_info
   use nutate_newton, only: attitude_noise, continue_steps, degree, has_converged, patience, remember, too_slow
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_range, only: check_start, check_system
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, &
      NUTATE_OFF_BRANCH
   use nutate_eight_equations, only: eight_equations_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: nielsen_krenk_t

   !> Iterations of a step above which the next one starts with a new Jacobian: it costs about as much as 15 iterations.
   integer, parameter :: many = 7
   !> Who allows fewer iterations gets no walk: it takes some that converge.
   integer, parameter :: fewest = 8
   !> Most iterations from a guess of a walk, which is near the root or of no use.
   integer, parameter :: near = 12
   !> A step longer than this many times the unit sphere's radius has gone astray. Where a stiff force acts, momentum
   !> may be far off on the way.
   real(wp), parameter :: astray = 1e3_wp, far_off = 1e100_wp
   !> Units of momentum above which |p| has outgrown its unit.
   real(wp), parameter :: outgrown = 64.0_wp
   !> Least units of momentum, whose inverse would leave the range of numbers: in kg m²/s, and over the momentum that
   !> turns the body by 1 rad in a step.
   real(wp), parameter :: least_unit = 1e-150_wp, least_share = 1e-100_wp
   !> Turns in a step, rad, and entries of the Jacobian that are larger belong to no step that could be taken; their
   !> products would overflow.
   real(wp), parameter :: greatest_turn = 1e40_wp, greatest_entry = 1e140_wp
   !> Bound of the exponent of the determinant.
   integer, parameter :: largest_power = 500

   !> The 8×8 stepper. `step` allocates nothing.
   type, extends(stepper_t) :: nielsen_krenk_t
      private
      type(integrator_settings_t) :: settings
      type(eight_equations_t) :: equations
      !> Inverse of a Jacobian, and its determinant, 1 for a very short step; of a large one, the sign and a bound.
      real(wp) :: inverse(8, 8) = 0.0_wp, determinant = 0.0_wp
      !> Step to which the inverse belongs, s; 0: there is none that is worth keeping.
      real(wp) :: inverse_dt = 0.0_wp
      !> Increments (Δx, Δy) of the last step and their backward differences; how many of these columns are known.
      real(wp) :: differences(8, 0:degree) = 0.0_wp
      integer :: known = 0
      !> Step of the increments, s.
      real(wp) :: last_dt = 0.0_wp
      !> The next step is the first since `prepare`.
      logical :: untested = .true.
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: transfer
   end type nielsen_krenk_t

contains

   !> Errors: `NUTATE_BAD_ARGUMENT` where projection is switched off with an infinite J0, or J0 is not positive; those
   !> of `check_system`.
   subroutine set_up(self, system, settings, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. settings%projection .and. settings%inverse_auxiliary_inertia <= 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'without projection the auxiliary inertia must be finite', 'projection')
         return
      end if
      if (.not. are_in_range([settings%inverse_auxiliary_inertia]) .or. &
          settings%inverse_auxiliary_inertia < 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the auxiliary inertia is not positive, or beyond all scales', &
                       'auxiliary_inertia')
         return
      end if
      call check_system(system, status)
      if (.not. status%ok()) return
      self%untested = .true.
      self%settings = settings
      call self%equations%forces%prepare(system%effects, settings%projection)
      self%inverse_dt = 0.0_wp
      self%known = 0
   end subroutine set_up

   !> One step. Errors, with the state as it was: `NUTATE_NOT_CONVERGED`, `NUTATE_SINGULAR`, `NUTATE_NOT_FINITE`;
   !> `NUTATE_OFF_BRANCH` where the branch of roots that continues the true motion from short steps ends before.
   subroutine advance(self, system, state, dt, window_time, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: z(8), guessed(8), a(4), last

      self%continued = 0
      if (self%untested) then
         call check_start(system, state, dt, status)
         if (status%code /= 0) return
         self%untested = .false.
      end if
      last = 0.0_wp
      if (self%known > 0 .and. dt == self%last_dt) last = self%determinant
      self%iterations = 0
      call test_state(state, dt, status)
      if (status%code == 0) then
         call self%equations%start(system, state, dt, window_time)
         if (dt /= self%inverse_dt .or. maxval(abs(state%p)) > outgrown*self%equations%unit) &
            call choose_unit(self, system, state, dt, window_time, status)
      end if
      if (status%code == 0) then
         call find_root(self, system, dt, z, guessed, status)
         if (status%code == 0) then
            a = self%equations%mean_rate(z)
            if (.not. is_trusted(self, turn_of(self, a))) then
               if (.not. is_continued(turn_of(self, a), self%determinant, last, maxval(abs(z - guessed)))) &
                  status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
            end if
         end if
         if (status%code /= 0 .and. self%settings%max_iterations >= fewest) &
            call continue_to_root(self, system, state, dt, window_time, z, a, status)
      end if
      status%iterations = self%iterations
      status%residual = self%residual
      if (status%code /= 0) then
         self%inverse_dt = 0.0_wp
         self%known = 0
         return
      end if
      call accept(self, system, state, dt, z, a)
   end subroutine advance

   !> |b|, b = ⅛Δt J⁻¹(w̄ - 2h): the tangent of a quarter of the turn.
   pure real(wp) function turn_of(self, a)
      class(nielsen_krenk_t), intent(in) :: self
      !> J⁻¹(w̄ - 2h), rad/s.
      real(wp), intent(in) :: a(4)
      turn_of = abs(0.125_wp*self%equations%dt)*sqrt(a(2)**2 + a(3)**2 + a(4)**2)
   end function turn_of

   !> True if the root is surely that of the true motion.
   pure logical function is_trusted(self, turn)
      class(nielsen_krenk_t), intent(in) :: self
      !> |b|
      real(wp), intent(in) :: turn
      is_trusted = is_surely_true(turn, self%determinant, self%equations%forces%active, &
                                  self%equations%forces%by_attitude)
   end function is_trusted

   !> Follows the branch of the true motion from short steps to this one. Success leaves its root in z.
   subroutine continue_to_root(self, system, state, dt, window_time, z, a, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s, and the time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      real(wp), intent(out) :: z(8)
      !> The rate that belongs to z.
      real(wp), intent(inout) :: a(4)
      !> On entry: why the root found at once will not do; it stays where the branch ends.
      type(status_t), intent(inout) :: status
      type(continuation_t) :: walk
      type(status_t) :: trial
      real(wp) :: root(8), guess(8), change(8), determinant
      integer :: iterations
      logical :: found
      iterations = self%iterations
      self%known = 0
      root = 0.0_wp
      call walk%start(turn_of(self, self%equations%mean_rate(root)))
      do while (walk%goes_on())
         call self%equations%start(system, state, walk%next*dt, window_time)
         if (walk%reached > 0.0_wp) then
            guess = root + walk%secant()*change
         else
            call first_guess(self, guess)
         end if
         z = guess
         trial = status_t()
         self%inverse_dt = 0.0_wp
         call iterate(self, system, z, trial, near)
         iterations = iterations + self%iterations
         ! The determinant counts at the root itself.
         if (trial%code == 0) call factorize(self, system, z, trial)
         found = trial%code == 0
         determinant = self%determinant
         if (found) a = self%equations%mean_rate(z)
         if (found .and. walk%reached > 0.0_wp) then
            found = walk%keeps_to(turn_of(self, a), determinant, maxval(abs(z - guess)))
         else if (found) then
            found = is_trusted(self, turn_of(self, a))
         end if
         call walk%judge(found, 0.5_wp*norm2(z(1:4) - root(1:4)), determinant)
         if (.not. found) cycle
         change = z - root
         root = z
      end do
      self%iterations = iterations
      self%continued = walk%tried
      if (walk%reached >= 1.0_wp) status = status_t()
   end subroutine continue_to_root

   !> Moves the state by the increments that the root z stands for, and remembers z.
   subroutine accept(self, system, state, dt, z, a)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> s; the root; the rate a that belongs to it.
      real(wp), intent(in) :: dt, z(8), a(4)
      real(wp) :: dq(4), dp(4), excess
      if (system%effects%n_torques > 0) call self%equations%forces%get_work( &
         system%effects, dt, self%equations%x0 + 0.5_wp*z(1:4), 0.5_wp*a(2:4), self%work)
      call self%equations%increments(state, z, a, dq, dp, excess)
      ! Before the sums, whose rounding leaves carries that are zero on the average: the next step does not see them.
      state%q_compensation = state%q_compensation - excess*(state%q + dq)
      state%p_compensation = state%p_compensation - excess*(state%p + dp)
      call add_increment(state%q, state%q_compensation, dq)
      call add_increment(state%p, state%p_compensation, dp)
      call self%equations%make_tangent(state)
      state%t = state%t + dt
      if (dt /= self%last_dt) self%known = 0
      self%last_dt = dt
      call remember(8, z, self%differences, self%known)
      if (self%iterations > many) self%inverse_dt = 0.0_wp
   end subroutine accept

   !> The root of the step's equations.
   subroutine find_root(self, system, dt, z, guessed, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      real(wp), intent(out) :: z(8)
      !> The guess that continues the last steps.
      real(wp), intent(out) :: guessed(8)
      type(status_t), intent(inout) :: status
      integer :: spent
      call guess(self, dt, z)
      guessed = z
      call iterate(self, system, z, status)
      if (status%code == NUTATE_NOT_CONVERGED .and. self%known == 0 .and. self%equations%forces%active) then
         ! A stiff force may hold the body where it is.
         spent = self%iterations
         status = status_t()
         z = 0.0_wp
         self%inverse_dt = 0.0_wp
         call iterate(self, system, z, status)
         self%iterations = self%iterations + spent
      end if
   end subroutine find_root

   !> Refuses an attitude that is far from the unit sphere, as it can become without projection, and times that are not
   !> finite.
   pure subroutine test_state(state, dt, status)
      type(state_t), intent(in) :: state
      !> s
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      real(wp) :: norm
      norm = maxval(abs(state%q))
      if (.not. (norm > 1/astray .and. norm < astray)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is far from a unit quaternion')
      else if (.not. abs(state%t + dt) <= huge(dt)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is not finite')
      end if
   end subroutine test_state

   !> Takes as unit of momentum the power of two next to the largest of |p| and the change of p in a step by the forces
   !> on a body at rest: those that oppose its motion change p by no more than |p|. For a body at rest without forces,
   !> the momentum that turns it by about 1 rad in a step. Called when the factors belong to another step, have been
   !> dropped, or |p| has outgrown its unit. Errors: `NUTATE_OFF_BRANCH` where the body turns beyond all scales in a
   !> step.
   pure subroutine choose_unit(self, system, state, dt, window_time, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> s, and the time that decides which torques act, s.
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp), parameter :: at_rest(3) = 0.0_wp, at_start(8) = 0.0_wp
      real(wp) :: size, old, natural, s(4)
      size = maxval(abs(state%p))
      natural = maxval(system%body%moments)/max(abs(dt), tiny(1.0_wp))
      if (self%equations%forces%active) then
         call self%equations%forces%evaluate(system%effects, self%equations%x0, self%equations%x0, at_rest, s)
         size = max(size, 2*abs(dt)*maxval(abs(s)))
      end if
      if (size <= 0.0_wp) size = natural
      size = max(size, least_share*natural, least_unit)
      old = self%equations%unit
      call self%equations%set_unit(system, self%settings%inverse_auxiliary_inertia, 2.0_wp**exponent(size))
      call self%equations%start(system, state, dt, window_time)
      if (.not. max(maxval(abs(self%equations%inverse_inertia)), self%equations%inverse_j0, &
                    maxval(abs(self%equations%mean_rate(at_start))))*abs(dt) <= greatest_turn) &
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
      self%differences(5:8, :) = self%differences(5:8, :)*(old/self%equations%unit)
      self%inverse_dt = 0.0_wp
   end subroutine choose_unit

   !> First guess: the last increments continued, else `first_guess`.
   pure subroutine guess(self, dt, z)
      class(nielsen_krenk_t), intent(in) :: self
      real(wp), intent(in) :: dt
      real(wp), intent(out) :: z(8)
      if (self%known == 0) then
         call first_guess(self, z)
      else if (dt /= self%last_dt) then
         z = (dt/self%last_dt)*self%differences(:, 0)
      else
         call continue_steps(8, self%differences, self%known, z)
      end if
   end subroutine guess

   !> The rates at the start of the step.
   pure subroutine first_guess(self, z)
      class(nielsen_krenk_t), intent(in) :: self
      real(wp), intent(out) :: z(8)
      real(wp) :: a(4)
      z = 0.0_wp
      a = (0.25_wp*self%equations%dt)*self%equations%mean_rate(z)
      z(1:4) = quat_product(self%equations%x0, a)
      z(5:8) = -quat_product(self%equations%y0, quat_conjugate(a))
   end subroutine first_guess

   !> Newton's iteration from the guess z to the root.
   subroutine iterate(self, system, z, status, limit)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: z(8)
      type(status_t), intent(inout) :: status
      !> Most iterations, if fewer than the settings allow.
      integer, intent(in), optional :: limit
      real(wp) :: r(8), d(8), change, previous, length
      integer :: j, k, stalled, most

      most = self%settings%max_iterations
      if (present(limit)) most = min(most, limit)
      previous = huge(1.0_wp)
      stalled = 0
      do k = 1, most
         self%iterations = k
         if (self%inverse_dt /= self%equations%dt) then
            call factorize(self, system, z, status)
            if (status%code /= 0) return
         end if
         call self%equations%residual(system, z, r)
         d = self%inverse(:, 1)*r(1)
         do j = 2, 8
            d = d + self%inverse(:, j)*r(j)
         end do
         z = z - d
         change = maxval(abs(d))
         length = maxval(abs(z))
         if (.not. (maxval(abs(z(1:4))) <= astray .and. length <= far_off)) exit
         self%residual = 0.0_wp
         if (length > 0.0_wp) self%residual = change/length
         if (has_converged(change, previous, length, self%settings%tolerance)) return
         if (change > 0.5_wp*previous .and. maxval(abs(d(1:4))) <= attitude_noise) stalled = stalled + 1
         if (stalled >= patience .and. self%settings%tolerance <= 0.0_wp) return
         if (change > too_slow*previous) self%inverse_dt = 0.0_wp
         previous = change
      end do
      if (.not. ieee_is_finite(sum(z))) then
         status = fail(NUTATE_NOT_FINITE, 'the step gave a number that is not finite')
      else
         status = fail(NUTATE_NOT_CONVERGED, 'the Newton iteration of the step did not converge')
      end if
   end subroutine iterate

   !> A new Jacobian at z, its inverse from the LU factors, and the sign of its determinant.
   subroutine factorize(self, system, z, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: z(8)
      type(status_t), intent(inout) :: status
      real(wp) :: lu(8, 8)
      integer :: pivots(8), info, i, power
      call self%equations%jacobian(system, z, lu)
      if (.not. maxval(abs(lu)) <= greatest_entry) then
         status = fail(NUTATE_OFF_BRANCH, 'the effects are too strong for a step of this length')
         return
      end if
      call dgetrf(8, 8, lu, 8, pivots, info)
      if (info /= 0) then
         status = handle_info('dgetrf', info)
         return
      end if
      ! In units of a small momentum the factors are of all sizes, but not their product.
      self%determinant = 1.0_wp
      power = 0
      do i = 1, 8
         if (pivots(i) /= i) self%determinant = -self%determinant
         self%determinant = self%determinant*fraction(lu(i, i))
         power = power + exponent(lu(i, i))
      end do
      self%determinant = scale(self%determinant, max(-largest_power, min(largest_power, power)))
      self%inverse = 0.0_wp
      do i = 1, 8
         self%inverse(i, i) = 1.0_wp
      end do
      call dgetrs('N', 8, 8, lu, 8, pivots, self%inverse, 8, info)
      self%inverse_dt = self%equations%dt
   end subroutine factorize

   !> Unit of momentum, inverse of the Jacobian with its step, increments of the last steps.
   subroutine transfer(self, system, archive)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%untested)
      call archive%transfer(self%equations%unit)
      call archive%transfer(self%inverse)
      call archive%transfer(self%determinant)
      call archive%transfer(self%inverse_dt)
      call archive%transfer(self%differences)
      call archive%transfer(self%known)
      call archive%transfer(self%last_dt)
      if (archive%is_reading()) &
         call self%equations%set_unit(system, self%settings%inverse_auxiliary_inertia, self%equations%unit)
   end subroutine transfer

end module nutate_nielsen_krenk
