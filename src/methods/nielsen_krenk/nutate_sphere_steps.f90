!> The inner spheres of a body in one step of the conserving scheme.
!>
!> Within a step L is the momentum of the body without its spheres. With l0 = R(u)h0 the momentum of a sphere at the
!> start in space, R(q̄) the attitude at mid step and κ = cσ, σ = 1/(1 + ½Δt c/I),
!>
!>     τ̄ = κ(R(q̄)ᵀl0/I - Ω̄),   l1 = l0 - Δt R(q̄)τ̄
!>
!> is the torque on the body, and the friction does exactly the work -Δt|τ̄|²/c. The spheres bring no unknowns, and
!> enter the equations of the step by two sums, a vector D and a number K: τ̄ = R(c½)ᵀD - KΩ̄, seen from u.
!>
!> If the space axes rotate at ω, l rotates in them by -½Δt ω before and after the impulse, a rotation P seen from u,
!> which keeps |l| and ω·l; Ω̄ is the absolute rate.
module nutate_sphere_steps
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_spheres
   use nutate_quaternion, only: cross, quat_exp, rotate_to_body
   use nutate_state, only: add_increment, state_t
   implicit none
   private

   public :: sphere_steps_t, prepare_spheres, turned_back, rotation_change

   !> Least value of 1 + ½Δt c/I: in a longer step back in time, friction would drive the sphere through a singularity.
   real(wp), parameter :: least_divisor = 0.1_wp

   !> The inner spheres in one step; not used if there are none.
   type :: sphere_steps_t
      !> Number of spheres; index of the last of the momenta before theirs.
      integer :: n = 0, before = 0
      !> Length of the step, s; it is short enough for the friction.
      real(wp) :: dt = 0.0_wp
      logical :: is_short = .true.
      !> σ and κ of each, N m s; shape (most_spheres).
      real(wp) :: share(most_spheres) = 1.0_wp, drag(most_spheres) = 0.0_wp
      !> h0 and h1, N m s, body axes; Pl0/I - ω, rad/s, and Pl0, N m s, seen from u; shape (3, most_spheres).
      real(wp) :: first(3, most_spheres) = 0.0_wp, last(3, most_spheres) = 0.0_wp
      real(wp) :: pull(3, most_spheres) = 0.0_wp, held(3, most_spheres) = 0.0_wp
      !> Σ h0, N m s, and Σ τ̄ at the root, N m; shape (3).
      real(wp) :: inner(3) = 0.0_wp, torque(3) = 0.0_wp
      !> Σ (c∘h1 - h0), seen from u, N m s; shape (4).
      real(wp) :: spin(4) = 0.0_wp
      !> The space axes rotate; ω, rad/s, and P as a quaternion, seen from u; shapes (3), (4).
      logical :: turns = .false.
      real(wp) :: frame_rate(3) = 0.0_wp, half_turn(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   contains
      !> Sets the length of a step.
      procedure :: set_step
      !> Starts a step.
      procedure :: start
      !> Returns the rate of a sphere from which its torque follows.
      procedure :: rate_of
      !> Adds the part of their torque that is proportional to the rate, and the derivative of their torque by time.
      procedure :: split_turn
      !> Moves the spheres to the end of the step, with their work.
      procedure :: finish
   end type sphere_steps_t

contains

   !> Stores the spheres of a system; not allocated if there are none.
   pure subroutine prepare_spheres(effects, spheres)
      type(effect_list_t), intent(in) :: effects
      type(sphere_steps_t), allocatable, intent(out) :: spheres
      if (effects%n_spheres == 0) return
      allocate (spheres)
      spheres%n = effects%n_spheres
      spheres%before = effects%n_reaction_wheels
      spheres%turns = effects%frame_turns
   end subroutine prepare_spheres

   !> Sets the length of a step, s.
   pure subroutine set_step(self, effects, dt)
      class(sphere_steps_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: dt
      real(wp) :: divisor
      integer :: i
      self%dt = dt
      self%is_short = .true.
      do i = 1, self%n
         associate (sphere => effects%wheels(self%before + 3*i))
            divisor = 1 + 0.5_wp*dt*(sphere%friction/sphere%inertia)
            if (.not. divisor > least_divisor) then
               self%is_short = .false.
               divisor = 1.0_wp
            end if
            self%share(i) = 1/divisor
            self%drag(i) = sphere%friction*self%share(i)
         end associate
      end do
   end subroutine set_step

   !> Starts a step of the length set by `set_step`.
   pure subroutine start(self, effects, state, frame, pull, drag)
      class(sphere_steps_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> u, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: frame(4)
      !> D, seen from u, N m, shape (3), and K, N m s.
      real(wp), intent(out) :: pull(3), drag
      integer :: i, k
      self%frame_rate = 0.0_wp
      if (self%turns) then
         self%frame_rate = rotate_to_body(frame, effects%frame_rate)
         self%half_turn = quat_exp((-0.25_wp*self%dt)*self%frame_rate)
      end if
      self%inner = 0.0_wp
      pull = 0.0_wp
      drag = 0.0_wp
      do i = 1, self%n
         k = self%before + 3*i
         self%first(:, i) = state%wheel_momentum(k - 2:k)
         self%inner = self%inner + self%first(:, i)
         self%held(:, i) = self%first(:, i)
         if (self%turns) self%held(:, i) = self%held(:, i) + rotation_change(self%half_turn, self%held(:, i))
         self%pull(:, i) = self%held(:, i)/effects%wheels(k)%inertia - self%frame_rate
         pull = pull + self%drag(i)*self%pull(:, i)
         drag = drag + self%drag(i)
      end do
   end subroutine start

   !> Returns τ̄/κ = R(c½)ᵀPl0/I - Ω̄ of a sphere, body axes at mid step, rad/s; shape (3).
   pure function rate_of(self, i, r) result(rate)
      class(sphere_steps_t), intent(in) :: self
      integer, intent(in) :: i
      !> r, by which the step rotates the body; shape (3).
      real(wp), intent(in) :: r(3)
      real(wp) :: rate(3)
      rate = turned_back(r, self%pull(:, i)) - (4/self%dt)*r
   end function rate_of

   !> Adds the part of τ̄ that is proportional to the rate, and ∂τ̄/∂t, t the middle of a step of twice its length, at
   !> fixed attitude and rate: ∂κ/∂t = -κ²/I.
   pure subroutine split_turn(self, effects, r, drag, change)
      class(sphere_steps_t), intent(in) :: self
      type(effect_list_t), intent(in) :: effects
      !> r, by which the step rotates the body; shape (3).
      real(wp), intent(in) :: r(3)
      !> Drag, body axes, N m; ∂τ̄/∂t, body axes, N m/s; shape (3).
      real(wp), intent(inout) :: drag(3), change(3)
      integer :: i
      do i = 1, self%n
         drag = drag - (4*self%drag(i)/self%dt)*r
         change = change - (self%drag(i)**2/effects%wheels(self%before + 3*i)%inertia)*self%rate_of(i, r)
      end do
   end subroutine split_turn

   !> Moves the spheres to the end of the step; all that depends on the state at its start is taken from `start`.
   pure subroutine finish(self, effects, r, state, work)
      class(sphere_steps_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> r, by which the step rotates the body; shape (3).
      real(wp), intent(in) :: r(3)
      type(state_t), intent(inout) :: state
      !> Work of every effect that does work, J; shape (n_works); only the work of the spheres is set.
      real(wp), intent(inout) :: work(:)
      real(wp) :: rate(3), tau(3), gain(3), held(3), change(3), done, factor, square
      integer :: i, k, m, place
      square = dot_product(r, r)
      factor = 2/(1 + square)
      self%torque = 0.0_wp
      self%spin = 0.0_wp
      do i = 1, self%n
         k = self%before + 3*i
         rate = self%rate_of(i, r)
         tau = self%drag(i)*rate
         self%torque = self%torque + tau
         ! Increments, so that their own rounding alone remains.
         gain = -self%dt*turned(r, tau)
         if (self%turns) then
            gain = gain + rotation_change(self%half_turn, self%first(:, i))
            gain = gain + rotation_change(self%half_turn, self%first(:, i) + gain)
         end if
         held = self%first(:, i) + gain
         self%spin(1) = self%spin(1) - factor*dot_product(r, held)
         self%spin(2:4) = self%spin(2:4) + gain + factor*(cross(held, r) - square*held)
         change = cross(r, held)
         change = gain + (factor*factor)*(2*cross(r, change) - (1 - square)*change)
         self%last(:, i) = self%first(:, i) + change
         do m = 1, 3
            place = k - 3 + m
            call add_increment(state%wheel_momentum(place), state%wheel_compensation(place), change(m))
            ! The mean speed relative to the body is σ times this rate.
            done = -self%dt*tau(m)*(self%share(i)*rate(m))
            state%wheel_work(2, place) = state%wheel_work(2, place) + done
            work(effects%n_torques + 2*place - 1:effects%n_torques + 2*place) = [0.0_wp, done]
         end do
      end do
   end subroutine finish

   !> Returns R(c½)ᵀv: v rotated back by half of the rotation of a step; shape (3).
   pure function turned_back(r, v) result(turned)
      !> r, and v, seen from the start; shape (3).
      real(wp), intent(in) :: r(3), v(3)
      real(wp) :: turned(3), square
      square = dot_product(r, r)
      turned = ((1 - square)*v + (2*dot_product(r, v))*r - 2*cross(r, v))/(1 + square)
   end function turned_back

   !> Returns R(c½)v; shape (3).
   pure function turned(r, v) result(image)
      real(wp), intent(in) :: r(3), v(3)
      real(wp) :: image(3)
      image = turned_back(-r, v)
   end function turned

   !> Returns R(q)v - v, to its own digits; shape (3).
   pure function rotation_change(q, v) result(change)
      !> Unit quaternion, shape (4), and v, shape (3).
      real(wp), intent(in) :: q(4), v(3)
      real(wp) :: change(3)
      change = cross(q(2:4), v)
      change = 2*(q(1)*change + cross(q(2:4), change))
   end function rotation_change

end module nutate_sphere_steps
