!> Bodies of the procedures whose interfaces are in `nutate_tangent`.
submodule(nutate_tangent) nutate_tangent_procedures
   use nutate_variation, only: added_inertia, change_at_start, OF_POTENTIAL, OF_TORQUE, OF_WHEEL
   use nutate_hamiltonian, only: angular_velocity, body_direction, body_momentum, frame_rate_of, inertia_at, &
      inverse_inertia_at, potential_torque
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: cross, quat_normalized, rotate_to_body, rotate_to_space
   use nutate_small_products, only: times_vector
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: speed_change, axis_change
   implicit none

contains

   module procedure begin
      integer :: k, m
      call check_effects(system%effects, status)
      if (status%ok() .and. size(variations) == 0) status = fail(NUTATE_BAD_ARGUMENT, &
         'there are no sensitivities to propagate')
      do k = 1, size(variations)
         associate (one => variations(k))
            if (status%ok() .and. .not. (all(is_moderate(one%inertia)) .and. all(is_moderate( &
                [one%attitude, one%angular_velocity, one%mass_moment, one%mass, one%rotor, one%frame])))) &
               status = fail(NUTATE_BAD_ARGUMENT, 'a change is not finite or too large, or is that of an axis that '// &
                             'does not exist (expected 1, 2 or 3)', one%name)
         end associate
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
         call self%variations(k)%follow_body(system%effects, self%variations(k)%inertia + added_inertia( &
                                             self%variations(k), system%effects, 0, 0.0_wp, 0.0_wp, 1.0_wp))
         call self%variations(k)%follow_orbits(system%effects, status)
      end do
      if (.not. status%ok()) return
      self%moves_windows = any([(allocated(self%variations(k)%windows), k=1, self%n)])
      self%parametric = pack([(k, k=1, self%n)], [(self%variations(k)%is_parametric(), k=1, self%n)])
      allocate (self%inertia(3, 3, size(self%parametric)))
      do m = 1, size(self%parametric)
         associate (variation => self%variations(self%parametric(m)))
            self%inertia(:, :, m) = change_at_start(system%effects, variation) + &
                                    change_by_edges(system%effects, variation, state%t)
         end associate
      end do
      call start_sensitivities(self, system, state)
      self%energy = self%energy_row(system, state)
      self%space_momentum = self%momentum_row(state)
   end procedure begin

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
            change = times_vector(inertia_at(system, state%t), variation%angular_velocity)
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
         inertia = self%inertia_of(system%effects, m, state%t)
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
                        + wheel%inertia*(speed_change(wheel, c) + dot_product(axis_change(wheel, c), omega))
                  end associate
               end associate
            end do
         end associate
      end do
      do k = 1, self%n
         self%momentum(k, :) = self%momentum(k, :) + inner_change(self, system%effects, state, k)
      end do
   end subroutine start_sensitivities

   module procedure resume
      integer :: k, m
      self%theta = theta
      do k = 1, self%n
         self%momentum(k, :) = times_vector(inertia_at(system, state%t), rates(k, :)) &
                               + inner_change(self, system%effects, state, k)
      end do
      do m = 1, size(self%parametric)
         k = self%parametric(m)
         self%momentum(k, :) = self%momentum(k, :) &
                               + times_vector(self%inertia_of(system%effects, m, state%t), &
                                              angular_velocity(system, state))
      end do
      self%energy = self%energy_row(system, state)
      self%space_momentum = self%momentum_row(state)
   end procedure resume

   module procedure inner_change
      integer :: i
      change = self%variations(k)%rotor
      do i = 1, effects%n_wheels
         change = change + self%wheels(k, i)*effects%wheels(i)%axis
      end do
      if (.not. allocated(self%variations(k)%effects)) return
      do i = 1, size(self%variations(k)%effects)
         associate (item => self%variations(k)%effects(i))
            if (item%kind == OF_WHEEL) change = change + &
               state%wheel_momentum(item%place)*axis_change(effects%wheels(item%place), item%change)
         end associate
      end do
   end procedure inner_change

   !> Returns the change of the inertia by starts and stops of its rates between t = 0 and another time; shape (3,3).
   pure function change_by_edges(effects, variation, t) result(change)
      type(effect_list_t), intent(in) :: effects
      type(variation_t), intent(in) :: variation
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: change(3, 3)
      real(wp) :: times(2), passed(2)
      integer :: i
      change = 0.0_wp
      if (.not. variation%moves_inertia) return
      do i = 1, size(variation%windows)
         associate (window => variation%windows(i))
            if (window%kind /= OF_TORQUE) cycle
            associate (item => effects%torques(window%place)%item)
               if (.not. item%changes_inertia) cycle
               call item%window(times(1), times(2))
               passed = merge(1, 0, t >= times) - merge(1, 0, 0.0_wp >= times)
               change = change + (passed(2)*window%change(2) - passed(1)*window%change(1))* &
                        item%inertia_term(1, times(1), times(1), 1.0_wp)
            end associate
         end associate
      end do
   end function change_by_edges

   module procedure inertia_of
      change = self%inertia(:, :, m)
      if (.not. effects%varies) return
      associate (variation => self%variations(self%parametric(m)))
         change = change + (added_inertia(variation, effects, 0, t, t, 1.0_wp) - &
                            added_inertia(variation, effects, 0, 0.0_wp, 0.0_wp, 1.0_wp))
      end associate
   end procedure inertia_of

   module procedure rates
      real(wp) :: omega(3), own(3, self%n), inverse(3, 3)
      integer :: k, m
      omega = angular_velocity(system, state)
      own = 0.0_wp
      do m = 1, size(self%parametric)
         own(:, self%parametric(m)) = times_vector(self%inertia_of(system%effects, m, state%t), omega)
      end do
      inverse = inverse_inertia_at(system, state%t)
      do k = 1, self%n
         change(k, :) = times_vector(inverse, self%momentum(k, :) - inner_change(self, system%effects, state, k) - &
                                     own(:, k))
      end do
   end procedure rates

   module procedure relative
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
   end procedure relative

   module procedure energy_row
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
         change(k) = change(k) - 0.5_wp*dot_product(omega, times_vector(self%inertia_of(system%effects, m, state%t), &
                                                                        omega)) &
                     - dot_product(omega, self%variations(k)%rotor) &
                     - dot_product(space_momentum(state), self%variations(k)%frame) &
                     + effects_energy(system%effects, state, self%variations(k), omega)
      end do
   end procedure energy_row

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
                  change = change - h*dot_product(omega, axis_change(wheel, c)) - 0.5_wp*c(4)*(h/wheel%inertia)**2
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

   module procedure momentum_row
      real(wp) :: q(4), momentum(3)
      integer :: k
      q = quat_normalized(state%q)
      momentum = body_momentum(state)
      do k = 1, self%n
         change(k, :) = rotate_to_space(q, self%momentum(k, :) + cross(self%theta(k, :), momentum))
      end do
   end procedure momentum_row

   module procedure check_effects
      integer :: i
      do i = 1, effects%n_torques
         associate (torque => effects%torques(i)%item)
            if (torque%sample > 0.0_wp) status = fail(NUTATE_BAD_ARGUMENT, &
               'a controller that samples has no derivative (expected one without sample)', torque%name)
         end associate
      end do
   end procedure check_effects

   module procedure transfer
      integer :: i, m
      do i = 1, 3
         call archive%transfer(self%theta(:, i))
         call archive%transfer(self%momentum(:, i))
         call archive%transfer(self%space_momentum(:, i))
         do m = 1, size(self%parametric)
            call archive%transfer(self%inertia(:, i, m))
         end do
      end do
      do i = 1, size(self%wheels, 2)
         call archive%transfer(self%wheels(:, i))
      end do
      call archive%transfer(self%work)
      call archive%transfer(self%energy)
      call archive%transfer(self%steps)
   end procedure transfer

end submodule nutate_tangent_procedures
