!> The step of Nielsen & Krenk (2012) as eight equations in q and p: analytic Jacobian, LAPACK.
!>
!> Residual, Jacobian and update, the discrete (9a) and (11) of the paper, are in `nutate_eight_equations`; the
!> projection (11), the missing scalar part, is in `nutate_discrete_forces`.
module nutate_nielsen_krenk
   use nutate_archive, only: archive_t
   use nutate_eight_equations, only: eight_equations_t
   use nutate_implicit_step, only: implicit_stepper_t, increment_t, most_cancellation, most_unknowns, &
      usual_cancellation
   use nutate_kinds, only: wp
   use nutate_lapack, only: dgetrf, dgetrs, handle_info
   use nutate_limits, only: greatest_number, is_moderate, in_words, least_size
   use nutate_small_products, only: times_vector
   use nutate_sphere_steps, only: prepare_spheres
   use nutate_state, only: state_t, add_rotated
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH
   use nutate_step_tangent, only: conserving_step_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_wheel_steps, only: prepare_wheels
   implicit none
   private

   public :: nielsen_krenk_t

   !> Iterations of a step above which the next one starts with a new Jacobian, which costs about as much as 15
   !> iterations and halves their number.
   integer, parameter :: slow = 7
   !> Largest |q| and 1/|q|: an iteration that leaves this range does not lead to a root. Under a stiff force the
   !> momentum may be far off during the iteration, but not beyond what can be computed with.
   real(wp), parameter :: farthest = 1e3_wp
   !> Units of momentum above which |p| has outgrown its unit: the loss is then still within the last six bits.
   real(wp), parameter :: outgrown = 64.0_wp
   !> Least units of momentum; the inverse of smaller ones would leave the range of numbers: in kg m²/s, and over the
   !> momentum that rotates the body by 1 rad in a step.
   real(wp), parameter :: least_unit = 1e-150_wp, least_share = 1e-100_wp
   !> Largest rotation in a step, rad, and largest entry of the Jacobian of any step that can be accepted; products of
   !> larger ones (of eight entries in the determinant, scaled) would overflow.
   real(wp), parameter :: greatest_turn = 1e40_wp, greatest_entry = 1e140_wp
   !> |q| - 1, and ¼Δt times half the rate at which |q| grows, whose squares are round-off.
   real(wp), parameter :: near_manifold = 1e-8_wp
   !> Round-off of the residual: that of some thirty products in w̄, times the equations' gain, far larger than their
   !> sum for a needle; its increments have it times the inverse of the Jacobian.
   real(wp), parameter :: roundings = 32.0_wp
   !> Bound of the exponent of the determinant, within the range of numbers and of a product of two.
   integer, parameter :: largest_power = 500

   !> The 8×8 stepper, with the increments (Δx, Δy) of `nutate_eight_equations` as its unknowns.
   type, extends(implicit_stepper_t) :: nielsen_krenk_t
      private
      type(eight_equations_t) :: equations
      !> Inverse of the Jacobian for the step `kept_dt`.
      real(wp) :: inverse(8, 8) = 0.0_wp
      !> a = J⁻¹(w̄ - 2h) of the root last found, rad/s.
      real(wp) :: rate(4) = 0.0_wp
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
   end type nielsen_krenk_t

contains

   !> Prepares the stepper. Errors: `NUTATE_BAD_ARGUMENT` if projection is switched off with an infinite J0, or with
   !> `conserve`, or if J0 is not positive; those of `check_system`.
   subroutine set_up(self, system, settings, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. settings%projection .and. settings%inverse_auxiliary_inertia <= 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'without projection the auxiliary inertia must be finite', 'projection')
      else if (.not. settings%projection .and. system%effects%n_spheres > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'inner spheres need the projection (expected projection = .true.)', &
                       'projection')
      else if (.not. settings%projection .and. settings%conserve) then
         status = fail(NUTATE_BAD_ARGUMENT, 'conserve keeps |q| = 1 and needs the projection', 'projection')
      else if (.not. is_moderate(settings%inverse_auxiliary_inertia) .or. &
               settings%inverse_auxiliary_inertia < 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the auxiliary inertia is not positive, or not within '// &
                       in_words(least_size, greatest_number)//' kg m2', 'auxiliary_inertia')
      end if
      if (.not. status%ok()) return
      call self%begin(system, most_unknowns, slow, status)
      call self%equations%forces%prepare(system%effects, settings%projection)
      call prepare_wheels(system%effects, self%equations%wheels)
      call prepare_spheres(system%effects, self%equations%spheres)
      self%equations%scaled = .false.
   end subroutine set_up

   !> Sets the equations of a step. Rejects an attitude that is far from the unit sphere, as can happen without
   !> projection, and times that are not finite.
   subroutine start(self, system, state, dt, window_time, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: norm
      norm = maxval(abs(state%q))
      if (.not. (norm > 1/farthest .and. norm < farthest)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is far from a unit quaternion')
      else if (.not. abs(state%t + dt) <= huge(dt)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is not finite')
      else
         if (maxval(abs(state%p)) > outgrown*self%equations%momentum_unit) self%kept_dt = 0.0_wp
         if (allocated(self%equations%wheels)) then
            if (dt /= self%equations%wheels%dt) then
               self%equations%dt = dt
               self%equations%scaled = .false.
            end if
         end if
         if (system%effects%varies) then
            self%equations%middle = state%t + 0.5_wp*dt
            self%equations%scaled = .false.
         end if
         if (.not. self%equations%scaled) &
            call self%equations%set_momentum_unit(system, self%prepared_with%inverse_auxiliary_inertia, &
                                                   self%equations%momentum_unit)
         call self%equations%start(system, state, dt, window_time)
         self%on_manifold = stays_on_manifold(self%equations)
         if (allocated(self%equations%spheres) .and. .not. self%equations%is_tangent) status = fail( &
            NUTATE_BAD_ARGUMENT, 'inner spheres need q.p = 0')
      end if
   end subroutine start

   !> Returns true if |q| = 1 and |q| stays so: q·p = 0, or the auxiliary inertia is so large that it has no effect; and
   !> potentials are projected.
   pure logical function stays_on_manifold(equations)
      type(eight_equations_t), intent(in) :: equations
      stays_on_manifold = abs(equations%x0(1) - 1) <= near_manifold .and. equations%forces%projection .and. &
                          abs(0.125_wp*equations%dt*equations%inverse_j0*equations%w0(1)) <= near_manifold
   end function stays_on_manifold

   !> Sets the unit of momentum to the power of two next to the largest of |p| and the change of p in a step by the
   !> forces on a body at rest: those that oppose its motion change p by no more than |p|. For a body at rest without
   !> forces, it is the momentum that rotates it by about 1 rad in a step.
   subroutine scale_unknowns(self, system, state, dt, window_time, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
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
      old = self%equations%momentum_unit
      call self%equations%set_momentum_unit(system, self%prepared_with%inverse_auxiliary_inertia, &
                                            2.0_wp**exponent(size))
      call self%equations%start(system, state, dt, window_time)
      if (.not. (max(maxval(abs(self%equations%inverse_inertia)), self%equations%inverse_j0, &
                    maxval(abs(self%equations%mean_rate(at_start))))*abs(dt) <= greatest_turn .and. &
             self%equations%is_short())) &
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long to follow the motion')
      call self%predictor%change_unit(5, old/self%equations%momentum_unit)
      self%kept_dt = 0.0_wp
   end subroutine scale_unknowns

   !> Computes the unknowns of a step that keeps the rates of its start.
   subroutine explicit_guess(self, system, z)
      class(nielsen_krenk_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: z(most_unknowns)
      z = self%equations%explicit_increments()
   end subroutine explicit_guess

   !> Computes one increment with the stored inverse, or with a new one if none is worth keeping.
   subroutine correct(self, system, z, increment, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: z(most_unknowns)
      type(increment_t), intent(inout) :: increment
      type(status_t), intent(inout) :: status
      real(wp) :: r(8), d(8)
      integer :: j
      if (self%kept_dt /= self%equations%dt) then
         call self%linearize(system, z, status)
         if (status%code /= 0) return
      end if
      call self%equations%residual(system, z, r)
      d = (self%inverse(:, 1)*r(1) + self%inverse(:, 2)*r(2)) + (self%inverse(:, 3)*r(3) + self%inverse(:, 4)*r(4)) &
          + ((self%inverse(:, 5)*r(5) + self%inverse(:, 6)*r(6)) + (self%inverse(:, 7)*r(7) + self%inverse(:, 8)*r(8)))
      z = z - d
      increment%attitude = largest(d(1:4))
      increment%size = max(increment%attitude, largest(d(5:8)))
      increment%length = max(largest(z(1:4)), largest(z(5:8)))
      if (.not. increment%length <= farthest) &
         increment%diverged = .not. (maxval(abs(z(1:4))) <= farthest .and. increment%length <= greatest_number)
   end subroutine correct

   !> Returns max |vᵢ|.
   pure real(wp) function largest(v)
      real(wp), intent(in) :: v(4)
      largest = max(abs(v(1)), abs(v(2)), abs(v(3)), abs(v(4)))
   end function largest

   !> Computes a new Jacobian at z, its inverse from the LU factors, and its determinant, which is 1 for a very short
   !> step; of a large determinant only the sign and a bound.
   subroutine linearize(self, system, z, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: z(most_unknowns)
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
      self%kept_dt = self%equations%dt
      self%cancellation = roundings*max(1.0_wp, self%equations%gain())
      if (self%cancellation <= most_cancellation) self%cancellation = &
         min(most_cancellation, max(usual_cancellation, self%cancellation*maxval(abs(self%inverse))))
   end subroutine linearize

   pure subroutine get_start_vector(self, system, b)
      class(nielsen_krenk_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: b(3)
      b = (0.125_wp*self%equations%dt)*times_vector(self%equations%inverse_inertia, &
                                                    self%equations%w0(2:4) - self%equations%rotor)
   end subroutine get_start_vector

   pure subroutine unknowns_of(self, system, b, z)
      class(nielsen_krenk_t), intent(in) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: z(most_unknowns)
      z = self%equations%increments_of(system, b)
   end subroutine unknowns_of

   !> Computes b = ⅛Δt J⁻¹(w̄ - 2h).
   pure subroutine get_cayley_vector(self, z, b)
      class(nielsen_krenk_t), intent(inout) :: self
      real(wp), intent(in) :: z(most_unknowns)
      real(wp), intent(out) :: b(3)
      self%rate = self%equations%mean_rate(z)
      b = (0.125_wp*self%equations%dt)*self%rate(2:4)
   end subroutine get_cayley_vector

   !> Moves the state by the increments that belong to the root, by compensated summation.
   subroutine finish(self, system, state, dt, z)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt
      real(wp), intent(in) :: z(most_unknowns)
      real(wp) :: dq(4), dp(4), excess
      self%root = (0.125_wp*dt)*self%rate(2:4)
      if (system%effects%n_torques > 0) call self%equations%forces%get_work( &
         system%effects, dt, self%equations%x0 + 0.5_wp*z(1:4), self%equations%relative_rate(z, self%rate), self%work)
      if (allocated(self%equations%spheres)) &
         call self%equations%spheres%finish(system%effects, self%equations%turn_of(self%root), state, self%work)
      call self%equations%increments(state, z, self%rate, dq, dp, excess)
      call add_rotated(dq, excess, state%q, state%q_compensation)
      call self%equations%make_tangent(state%q, dp)
      call add_rotated(dp, excess, state%p, state%p_compensation)
      if (allocated(self%equations%wheels)) &
         call self%equations%wheels%finish(system%effects, 0.5_wp*self%rate(2:4), state, self%work)
      state%t = state%t + dt
   end subroutine finish

   !> Moves sensitivities by the root of the last step: on the constraint manifold that of the reduced form. Errors:
   !> `NUTATE_BAD_ARGUMENT` off the manifold, and if the attitude is not integrated.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(nielsen_krenk_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%prepared_with%attitude) then
         status = fail(NUTATE_BAD_ARGUMENT, 'sensitivities need the attitude (expected attitude = .true.)', &
                       'attitude')
      else if (.not. (self%on_manifold .and. (self%prepared_with%inverse_auxiliary_inertia <= 0.0_wp .or. &
                                              self%equations%is_tangent))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'sensitivities need |q| = 1, q.p = 0 and the projection', 'projection')
      end if
      if (status%code /= 0) return
      if (.not. allocated(self%last)) allocate (self%last)
      self%last%dt = self%equations%dt
      self%last%middle = self%equations%middle
      self%last%b = self%root
      self%last%frame = self%equations%frame
      self%last%momentum = (0.5_wp*self%equations%momentum_unit)*self%equations%w0(2:4)
      self%last%rotor = system%effects%rotor_momentum
      if (allocated(self%equations%wheels)) self%last%rotor = self%last%rotor + self%equations%wheels%rotor
      call self%last%propagate(system, self%equations%forces, self%equations%turn, self%equations%wheels, &
                           self%equations%spheres, tangent, status)
   end subroutine propagate_step

   !> Writes or reads the unit of momentum and the inverse of the Jacobian.
   subroutine transfer_form(self, archive)
      class(nielsen_krenk_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%equations%transfer(archive)
      call archive%transfer(self%inverse)
   end subroutine transfer_form

   !> Writes the unit of momentum and the inverse of the Jacobian as numbers.
   subroutine put_form(self, room, numbers, used)
      class(nielsen_krenk_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(inout) :: numbers(room)
      integer, intent(inout) :: used
      integer :: j
      numbers(used + 1) = self%equations%momentum_unit
      do j = 1, 8
         numbers(used + 8*j - 6:used + 8*j + 1) = self%inverse(:, j)
      end do
      used = used + 65
   end subroutine put_form

   !> Reads the unit of momentum and the inverse of the Jacobian from numbers. Values in this unit must be set again.
   subroutine take_form(self, room, numbers, used)
      class(nielsen_krenk_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in) :: numbers(room)
      integer, intent(inout) :: used
      integer :: j
      self%equations%momentum_unit = numbers(used + 1)
      self%equations%scaled = .false.
      do j = 1, 8
         self%inverse(:, j) = numbers(used + 8*j - 6:used + 8*j + 1)
      end do
      used = used + 65
   end subroutine take_form

end module nutate_nielsen_krenk
