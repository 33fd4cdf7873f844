!> Sensitivities: the derivative of a motion by its initial state and by parameters, propagated along a run.
!>
!> Sensitivity k is the change (θ, δL), and δh of each wheel, of the state per unit of `variations(k)`, in the chart
!>
!>     q → q∘exp(½θ),   L → L + δL,
!>
!> θ and δL in body axes. It is the derivative of the map that the method computes, not a second method for the
!> variational equations: differences of two runs converge to it, and what a step conserves its tangent conserves too
!> (`nutate_tangent_rows`). The first index of all arrays is the sensitivity.
!>
!> **Calls.** A program describes sensitivities (`nutate_variation`) and gives them to a run, `run%differentiate` after
!> `begin`; `begin` here makes the tangent of the first state. When the run accepts a step of the method,
!> `policy%propagate` calls `stepper%propagate` for each `advance` of the step; output points inside steps use a copy.
!> States depend on sensitivities only if these shorten adaptive steps (`nutate_error_control`).
!>
!> **Requirements of an override of `stepper_t%propagate_step`**: move `theta`, `momentum` and `wheels` from the state
!> `before` to the state `after`, which `advance` has just computed from it: the data that `advance` left in the stepper
!> may be used, and must not change. For parametric sensitivities (`parametric` holds their indices) add the effect of
!> their changes in the step: `inertia` is the change of the body without freely rotating parts, `variations(k)%rotor`,
!> `%frame`, `%effects` are the others; effects supply their own derivatives (`direction_change`, `gradient_change`,
!> `torque_change`). `work` gains the change of the work of torques, motors and friction. Methods that project move the
!> sensitivities to the targets `energy` and `space_momentum`, the values of the rows at the start. For methods that
!> conserve by themselves, and report it (`conserves`), `propagate` removes round-off of these rows every so many steps
!> (`nutate_sensitivity_projection`).
module nutate_tangent
   use nutate_archive, only: archive_t
   use nutate_variation, only: variation_t, OF_POTENTIAL, OF_WHEEL
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, body_direction, body_momentum, frame_rate_of, potential_torque, &
      space_momentum
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_normalized, rotate_to_body, rotate_to_space
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: tangent_t, check_effects

   !> Sensitivities at a state of a run.
   type :: tangent_t
      !> Number of sensitivities.
      integer :: n = 0
      !> Change by which each sensitivity is the derivative; shape (n).
      type(variation_t), allocatable :: variations(:)
      !> θ, rad, and δL, N m s, body axes, per unit of the sensitivity's parameter; shape (n, 3).
      real(wp), allocatable :: theta(:, :), momentum(:, :)
      !> δh of each wheel, N m s; shape (n, n_wheels).
      real(wp), allocatable :: wheels(:, :)
      !> Change of all works since the start, J; shape (n).
      real(wp), allocatable :: work(:)
      !> The rows of the energy and of l, with the parameters' own part, at the start: J, N m s, space axes; shape (n),
      !> (n, 3).
      real(wp), allocatable :: energy(:), space_momentum(:, :)
      !> Indices of the sensitivities that change a parameter; shape (n_parametric). Change of J without freely rotating
      !> parts by each of them, kg m²; shape (3, 3, n_parametric).
      integer, allocatable :: parametric(:)
      real(wp), allocatable :: inertia(:, :, :)
      !> Steps since round-off was last removed from what the sensitivities conserve (`stepper_t%propagate`).
      integer :: steps = 0
      !> True if sensitivities change the times at which torques or motors start or stop: `nutate_window_edges` moves
      !> sensitivities over these times.
      logical :: moves_windows = .false.
      !> Estimated error of the last step of a method that has an estimate, of the sensitivity for which it is largest
      !> and relative to it (`relative`); else zero. Not in checkpoint data.
      real(wp) :: error = 0.0_wp
      !> Work space of steps; shape (n, 3).
      real(wp), allocatable :: mid(:, :), turn(:, :), change(:, :), mean(:, :), shift(:, :)
      !> Work space of steps, for an even number of sensitivities; shape (n, 6) or (n + 1, 6).
      real(wp), allocatable :: even(:, :)
      !> Work space of steps, for wheels; shape (n, n_wheels).
      real(wp), allocatable :: inner(:, :)
   contains
      !> Makes the sensitivities of an initial state.
      procedure :: begin
      !> Sets the sensitivities at a later state.
      procedure :: resume
      !> Returns the change of the rates.
      procedure :: rates
      !> Returns the change of the momentum of rotors and wheels in the body, for one sensitivity.
      procedure :: inner_change
      !> Returns the size of a change of the sensitivities, relative to them.
      procedure :: relative
      !> Return the change of the energy, which potentials conserve, and of l.
      procedure :: energy_row
      procedure :: momentum_row
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer
   end type tangent_t

contains

   !> Makes the sensitivities of an initial state. Errors: `NUTATE_BAD_ARGUMENT` if there are none, and for effects
   !> without a derivative.
   subroutine begin(self, system, state, variations, status)
      class(tangent_t), intent(out) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Variations of the sensitivities; shape (n).
      type(variation_t), intent(in) :: variations(:)
      type(status_t), intent(out) :: status
      integer :: k, m
      call check_effects(system%effects, status)
      if (status%ok() .and. size(variations) == 0) status = fail(NUTATE_BAD_ARGUMENT, &
         'there are no sensitivities to propagate')
      do k = 1, size(variations)
         if (status%ok() .and. any(abs(variations(k)%frame) > 0.0_wp) .and. .not. system%effects%frame_turns) &
            status = fail(NUTATE_BAD_ARGUMENT, 'the rate of the space axes has a derivative only where they turn '// &
                          '(expected a rotating_frame with a rate)', variations(k)%name)
      end do
      if (.not. status%ok()) return
      self%n = size(variations)
      self%variations = variations
      allocate (self%theta(self%n, 3), self%momentum(self%n, 3), self%wheels(self%n, system%effects%n_wheels), &
                self%work(self%n), self%energy(self%n), self%space_momentum(self%n, 3), self%mid(self%n, 3), &
                self%turn(self%n, 3), self%change(self%n, 3), self%mean(self%n, 3), self%shift(self%n, 3), &
                self%even(self%n + modulo(self%n, 2), 6), &
                self%inner(self%n, system%effects%n_wheels), source=0.0_wp)
      do k = 1, self%n
         call self%variations(k)%follow_body(system%effects)
         call self%variations(k)%follow_orbits(system%effects, status)
      end do
      if (.not. status%ok()) return
      self%moves_windows = any([(allocated(self%variations(k)%windows), k=1, self%n)])
      self%parametric = pack([(k, k=1, self%n)], [(self%variations(k)%is_parametric(), k=1, self%n)])
      allocate (self%inertia(3, 3, size(self%parametric)))
      do m = 1, size(self%parametric)
         self%inertia(:, :, m) = inertia_change(system%effects, self%variations(self%parametric(m)))
      end do
      call start_sensitivities(self, system, state)
      self%energy = self%energy_row(system, state)
      self%space_momentum = self%momentum_row(state)
   end subroutine begin

   !> Sets θ, δL and δh at the initial state; for parameters, with fixed Ω0 and speeds of the wheels.
   subroutine start_sensitivities(self, system, state)
      class(tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: omega(3), speed, change(3), inertia(3, 3)
      integer :: i, k, m
      omega = angular_velocity(system, state)
      do k = 1, self%n
         associate (variation => self%variations(k))
            self%theta(k, :) = variation%attitude
            change = times_vector(system%body%inertia, variation%angular_velocity)
            do i = 1, system%effects%n_wheels
               associate (wheel => system%effects%wheels(i))
                  self%wheels(k, i) = wheel%inertia*dot_product(wheel%axis, variation%angular_velocity)
               end associate
            end do
            self%momentum(k, :) = change
         end associate
      end do
      do m = 1, size(self%parametric)
         k = self%parametric(m)
         inertia = self%inertia(:, :, m)
         self%momentum(k, :) = self%momentum(k, :) + times_vector(inertia, omega)
         associate (variation => self%variations(k))
            if (.not. allocated(variation%effects)) cycle
            do i = 1, size(variation%effects)
               associate (item => variation%effects(i))
                  if (item%kind /= OF_WHEEL) cycle
                  associate (wheel => system%effects%wheels(item%place), c => item%change)
                     speed = wheel%speed_of(state%wheel_momentum(item%place), omega)
                     self%wheels(k, item%place) = self%wheels(k, item%place) &
                        + c(4)*(speed + dot_product(wheel%axis, omega)) &
                        + wheel%inertia*(c(5) + dot_product(wheel%axis_change(c), omega))
                  end associate
               end associate
            end do
         end associate
      end do
      do k = 1, self%n
         self%momentum(k, :) = self%momentum(k, :) + self%inner_change(system%effects, state, k)
      end do
   end subroutine start_sensitivities

   !> Sets the sensitivities at a later state of a motion without wheels, from `theta` and `rates` there. The targets of
   !> the conserved rows are set to their values at this state.
   subroutine resume(self, system, state, theta, rates)
      !> Tangent after `begin`.
      class(tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> θ, rad, and δΩ, rad/s, body axes, per unit of the sensitivity's parameter; shape (n, 3).
      real(wp), intent(in) :: theta(:, :), rates(:, :)
      integer :: k, m
      self%theta = theta
      do k = 1, self%n
         self%momentum(k, :) = times_vector(system%body%inertia, rates(k, :)) &
                               + self%inner_change(system%effects, state, k)
      end do
      do m = 1, size(self%parametric)
         k = self%parametric(m)
         self%momentum(k, :) = self%momentum(k, :) &
                               + times_vector(self%inertia(:, :, m), angular_velocity(system, state))
      end do
      self%energy = self%energy_row(system, state)
      self%space_momentum = self%momentum_row(state)
   end subroutine resume

   !> Returns the change of the momentum of rotors and wheels in the body, axes of wheels included, N m s, body axes;
   !> shape (3).
   pure function inner_change(self, effects, state, k) result(change)
      class(tangent_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> Index of the sensitivity.
      integer, intent(in) :: k
      real(wp) :: change(3)
      integer :: i
      change = self%variations(k)%rotor
      do i = 1, effects%n_wheels
         change = change + self%wheels(k, i)*effects%wheels(i)%axis
      end do
      if (.not. allocated(self%variations(k)%effects)) return
      do i = 1, size(self%variations(k)%effects)
         associate (item => self%variations(k)%effects(i))
            if (item%kind == OF_WHEEL) change = change + &
               state%wheel_momentum(item%place)*effects%wheels(item%place)%axis_change(item%change)
         end associate
      end do
   end function inner_change

   !> Returns the change of Jᵣ = J - Σ Jw ssᵀ, without freely rotating parts; shape (3,3).
   pure function inertia_change(effects, variation) result(change)
      type(effect_list_t), intent(in) :: effects
      type(variation_t), intent(in) :: variation
      real(wp) :: change(3, 3)
      real(wp) :: axis(3)
      integer :: i, j
      change = variation%inertia
      if (.not. allocated(variation%effects)) return
      do i = 1, size(variation%effects)
         if (variation%effects(i)%kind /= OF_WHEEL) cycle
         associate (wheel => effects%wheels(variation%effects(i)%place), c => variation%effects(i)%change)
            axis = wheel%axis_change(c)
            do j = 1, 3
               change(:, j) = change(:, j) - (c(4)*wheel%axis(j) + wheel%inertia*axis(j))*wheel%axis &
                              - (wheel%inertia*wheel%axis(j))*axis
            end do
         end associate
      end do
   end function inertia_change

   !> Returns δΩ = J⁻¹(δL - δh - δJΩ), body axes; shape (n, 3).
   pure function rates(self, system, state) result(change)
      class(tangent_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: change(self%n, 3)
      real(wp) :: omega(3), own(3, self%n)
      integer :: k, m
      omega = angular_velocity(system, state)
      own = 0.0_wp
      do m = 1, size(self%parametric)
         own(:, self%parametric(m)) = times_vector(self%inertia(:, :, m), omega)
      end do
      do k = 1, self%n
         change(k, :) = times_vector(system%body%inverse_inertia, &
                                     self%momentum(k, :) - self%inner_change(system%effects, state, k) - own(:, k))
      end do
   end function rates

   !> Returns by how much sensitivities change, each relative to its own size, √(θ² + δL²/|L|²); the largest of all.
   pure real(wp) function relative(self, theta, momentum, scale)
      class(tangent_t), intent(in) :: self
      !> Changes of θ, rad, and of δL, N m s; shape (n, 3).
      real(wp), intent(in) :: theta(:, :), momentum(:, :)
      !> |L|, N m s.
      real(wp), intent(in) :: scale
      real(wp) :: weight, square, change
      integer :: k
      weight = 0.0_wp
      if (scale*scale > tiny(1.0_wp)) weight = 1/(scale*scale)
      relative = 0.0_wp
      do k = 1, self%n
         square = sum(self%theta(k, :)**2) + weight*sum(self%momentum(k, :)**2)
         change = sum(theta(k, :)**2) + weight*sum(momentum(k, :)**2)
         if (square > tiny(1.0_wp)) relative = max(relative, sqrt(change/square))
      end do
   end function relative

   !> Returns dH·X with the change of H by the parameters at fixed q, L and h, J; of H - ω·l if the space axes rotate.
   !> Potentials conserve this row, torques change it by `work`; shape (n).
   pure function energy_row(self, system, state) result(change)
      class(tangent_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: change(self%n)
      real(wp), dimension(3) :: omega, momentum, torque, by_theta, by_momentum, rotating
      integer :: i, k, m
      omega = angular_velocity(system, state)
      momentum = body_momentum(state)
      torque = potential_torque(system%effects, state%q, state%t)
      rotating = frame_rate_of(system%effects, state%q)
      by_theta = -torque - cross(momentum, rotating)
      by_momentum = omega - rotating
      do k = 1, self%n
         change(k) = dot_product(by_theta, self%theta(k, :)) + dot_product(by_momentum, self%momentum(k, :))
         do i = 1, system%effects%n_wheels
            change(k) = change(k) + system%effects%wheels(i)%speed_of(state%wheel_momentum(i), omega)*self%wheels(k, i)
         end do
      end do
      do m = 1, size(self%parametric)
         k = self%parametric(m)
         change(k) = change(k) - 0.5_wp*dot_product(omega, times_vector(self%inertia(:, :, m), omega)) &
                     - dot_product(omega, self%variations(k)%rotor) &
                     - dot_product(space_momentum(state), self%variations(k)%frame) &
                     + effects_energy(system%effects, state, self%variations(k), omega)
      end do
   end function energy_row

   !> Returns ∂H by the parameters of effects at fixed q, L and h, without the change of the inertia, J.
   pure real(wp) function effects_energy(effects, state, variation, omega) result(change)
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      type(variation_t), intent(in) :: variation
      !> Ω
      real(wp), intent(in) :: omega(3)
      real(wp) :: gamma(3)
      integer :: i, m
      change = 0.0_wp
      if (.not. allocated(variation%effects)) return
      do m = 1, size(variation%effects)
         associate (item => variation%effects(m), c => variation%effects(m)%change)
            if (item%kind == OF_WHEEL) then
               associate (h => state%wheel_momentum(item%place), wheel => effects%wheels(item%place))
                  change = change - h*dot_product(omega, wheel%axis_change(c)) - 0.5_wp*c(4)*(h/wheel%inertia)**2
               end associate
            end if
            if (item%kind /= OF_POTENTIAL) cycle
            do i = 1, effects%n_potentials
               if (effects%potentials(i)%place /= item%place) cycle
               gamma = body_direction(effects, i, state%q, state%t)
               associate (potential => effects%potentials(i)%item)
                  change = change + potential%energy_change(c, gamma) + dot_product( &
                           potential%gradient(gamma), rotate_to_body(state%q, potential%direction_change(c, state%t)))
               end associate
            end do
         end associate
      end do
   end function effects_energy

   !> Returns δl = R(δL + θ×L), space axes, N m s: conserved without forces; in a field along n, its component along n
   !> is conserved; shape (n, 3).
   pure function momentum_row(self, state) result(change)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: state
      real(wp) :: change(self%n, 3)
      real(wp) :: q(4), momentum(3)
      integer :: k
      q = quat_normalized(state%q)
      momentum = body_momentum(state)
      do k = 1, self%n
         change(k, :) = rotate_to_space(q, self%momentum(k, :) + cross(self%theta(k, :), momentum))
      end do
   end function momentum_row

   !> Checks that the effects have derivatives by the state. Errors: `NUTATE_BAD_ARGUMENT` for effects that have none.
   subroutine check_effects(effects, status)
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      integer :: i
      do i = 1, effects%n_torques
         associate (torque => effects%torques(i)%item)
            if (torque%sample > 0.0_wp) status = fail(NUTATE_BAD_ARGUMENT, &
               'a controller that samples has no derivative (expected one without sample)', torque%name)
         end associate
      end do
   end subroutine check_effects

   !> Writes or reads its values in checkpoint data.
   subroutine transfer(self, archive)
      !> Tangent begun with the same sensitivities.
      class(tangent_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 1, 3
         call archive%transfer(self%theta(:, i))
         call archive%transfer(self%momentum(:, i))
         call archive%transfer(self%space_momentum(:, i))
      end do
      do i = 1, size(self%wheels, 2)
         call archive%transfer(self%wheels(:, i))
      end do
      call archive%transfer(self%work)
      call archive%transfer(self%energy)
      call archive%transfer(self%steps)
   end subroutine transfer

end module nutate_tangent
