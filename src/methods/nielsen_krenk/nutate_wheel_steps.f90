!> The reaction wheels of a body in one step of the conserving scheme.
!>
!> A bar is the mean of the ends. With the motor's torque ū at mid step and the friction c,
!>
!>     h1 - h0 = Δt(ū - cω̄),   ω̄ = h̄/Jw - s·Ω̄
!>
!> the work of motor and friction is exactly Δt ūω̄ and -Δt cω̄². h̄ is linear in Ω̄,
!>
!>     h̄ = σ(h0 + ½Δtū) + κ s·Ω̄,   κ = ½Δt cσ,   σ = 1/(1 + ½Δt c/Jw)
!>
!> so that wheels bring no unknowns: in a step the body has the inertia `Jᵣ + Σ κ ssᵀ` and the rotor `Σ σ(h0 + ½Δtū)s`.
module nutate_wheel_steps
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_wheels
   use nutate_small_products, only: times_vector
   use nutate_state, only: add_increment, state_t
   implicit none
   private

   public :: wheel_steps_t, prepare_wheels

   !> Least value of 1 + ½Δt c/Jw: in a longer step back in time, friction would drive the wheel through a singularity.
   real(wp), parameter :: least_divisor = 0.1_wp

   !> The wheels of one step; not used if there are none.
   type :: wheel_steps_t
      !> Number of wheels; at least one of them has friction.
      integer :: n = 0
      logical :: rubs = .false.
      !> Length of the step for which the components below hold, s; it is short enough for the friction.
      real(wp) :: dt = 0.0_wp
      logical :: is_short = .true.
      !> Σ κ ssᵀ, kg m², body axes; shape (3,3).
      real(wp) :: coupling(3, 3) = 0.0_wp
      !> Σ s h0 and Σ σ(h0 + ½Δtū)s, N m s, body axes; shape (3).
      real(wp) :: first(3) = 0.0_wp, rotor(3) = 0.0_wp
      !> σ; h0, N m s; ū, N m; time at which the motor was evaluated, s, and whether it was; shape (most_wheels).
      real(wp) :: share(most_wheels) = 1.0_wp, start_momentum(most_wheels) = 0.0_wp, drive(most_wheels) = 0.0_wp, &
         asked(most_wheels) = 0.0_wp
      logical :: drives(most_wheels) = .false.
   contains
      !> Sets the length of a step.
      procedure :: set_step
      !> Starts a step.
      procedure :: start
      !> Adds the inertia that the wheels couple to the body, in the inverse of the inertia.
      procedure :: add_to_inverse
      !> Moves the wheels to the end of the step, with their work.
      procedure :: finish
   end type wheel_steps_t

contains

   !> Stores the wheels of a system; not allocated if there are neither wheels nor spheres.
   pure subroutine prepare_wheels(effects, wheels)
      type(effect_list_t), intent(in) :: effects
      type(wheel_steps_t), allocatable, intent(out) :: wheels
      if (effects%n_wheels == 0) return
      allocate (wheels)
      wheels%n = effects%n_reaction_wheels
      wheels%rubs = any(effects%wheels(:wheels%n)%friction > 0.0_wp)
   end subroutine prepare_wheels

   !> Sets the length of a step, s.
   pure subroutine set_step(self, effects, dt)
      class(wheel_steps_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: dt
      real(wp) :: divisor, coupling
      integer :: i, k
      self%dt = dt
      self%is_short = .true.
      self%coupling = 0.0_wp
      do i = 1, self%n
         associate (wheel => effects%wheels(i))
            divisor = 1 + 0.5_wp*dt*(wheel%friction/wheel%inertia)
            if (.not. divisor > least_divisor) then
               self%is_short = .false.
               divisor = 1.0_wp
            end if
            self%share(i) = 1/divisor
            coupling = 0.5_wp*dt*wheel%friction*self%share(i)
            do k = 1, 3
               self%coupling(:, k) = self%coupling(:, k) + (coupling*wheel%axis(k))*wheel%axis
            end do
         end associate
      end do
   end subroutine set_step

   !> Starts a step of the length set by `set_step`.
   pure subroutine start(self, effects, state, window_time)
      class(wheel_steps_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> Time that decides which motors act, s; default: the middle of the step.
      real(wp), intent(in), optional :: window_time
      real(wp), parameter :: at_rest(3) = 0.0_wp
      real(wp) :: middle, moment, window(2)
      integer :: i
      middle = state%t + 0.5_wp*self%dt
      moment = middle
      if (present(window_time)) moment = window_time
      self%first = 0.0_wp
      self%rotor = 0.0_wp
      do i = 1, self%n
         associate (wheel => effects%wheels(i), h => state%wheel_momentum(i))
            self%drive(i) = 0.0_wp
            self%drives(i) = wheel%is_driven(moment)
            if (self%drives(i)) then
               window = wheel%drive_window(moment)
               self%asked(i) = min(max(middle, window(1)), window(2))
               self%drive(i) = wheel%drive(self%asked(i), state%q, at_rest)
            end if
            self%start_momentum(i) = h
            self%first = self%first + h*wheel%axis
            self%rotor = self%rotor + (self%share(i)*(h + 0.5_wp*self%dt*self%drive(i)))*wheel%axis
         end associate
      end do
   end subroutine start

   !> Computes (J + Σ κ ssᵀ)⁻¹ from J⁻¹, wheel by wheel (Sherman and Morrison).
   pure subroutine add_to_inverse(self, effects, inverse)
      class(wheel_steps_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> J⁻¹ on entry, the result on return, kg⁻¹ m⁻²; shape (3,3).
      real(wp), intent(inout) :: inverse(3, 3)
      real(wp) :: rotated(3), coupling
      integer :: i, k
      if (.not. self%rubs) return
      do i = 1, self%n
         associate (wheel => effects%wheels(i))
            coupling = 0.5_wp*self%dt*wheel%friction*self%share(i)
            rotated = times_vector(inverse, wheel%axis)
            coupling = coupling/(1 + coupling*dot_product(wheel%axis, rotated))
            do k = 1, 3
               inverse(:, k) = inverse(:, k) - (coupling*rotated(k))*rotated
            end do
         end associate
      end do
   end subroutine add_to_inverse

   !> Moves the wheels to the end of the step. ω̄ = σ(h0/Jw + ½Δtū/Jw - s·Ω̄) loses no digits to strong friction.
   pure subroutine finish(self, effects, omega, state, work)
      class(wheel_steps_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> Ω̄, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      type(state_t), intent(inout) :: state
      !> Work of every effect that does work, J; shape (n_works); only the work of the wheels is set.
      real(wp), intent(inout) :: work(:)
      real(wp) :: speed, done(2)
      integer :: i, last
      last = effects%n_torques
      do i = 1, self%n
         associate (wheel => effects%wheels(i), u => self%drive(i))
            speed = self%share(i)*((self%start_momentum(i) + 0.5_wp*self%dt*u)/wheel%inertia &
                                   - dot_product(wheel%axis, omega))
            call add_increment(state%wheel_momentum(i), state%wheel_compensation(i), &
                               self%dt*(u - wheel%friction*speed))
            done = [self%dt*(u*speed), -self%dt*(wheel%friction*speed)*speed]
            state%wheel_work(:, i) = state%wheel_work(:, i) + done
            work(last + 1:last + 2) = done
            last = last + 2
         end associate
      end do
   end subroutine finish

end module nutate_wheel_steps
