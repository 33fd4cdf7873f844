!> Inner spheres in the tangent of one step of the conserving scheme (`nutate_sphere_steps`, `nutate_step_tangent`).
!>
!> Seen from u, the momentum of a sphere in space changes at the start by δl0 = δh0 + θ0×h0, and with the rotation φ of
!> the body at mid step, κ' and I' the changes of κ and I,
!>
!>     δτ̄ = κ(R(c½)ᵀd×φ + R(c½)ᵀδd - (4/Δt)δr) + (κ'/κ)τ̄,   d = Pl0/I - ω,   δd = Pδl0/I - Pl0 I'/I² - δω
!>     δl1 = P(Pδl0 - ΔtR(c½)(φ×τ̄ + δτ̄)),   δh1 = R(c)ᵀδl1 - θ1×h1
!>
!> The terms in φ and δr belong to the matrices of the step; the others are added to each sensitivity.
module nutate_sphere_tangent
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_sphere_steps, only: rotation_change, sphere_steps_t, turned_back
   use nutate_tangent, only: tangent_t
   use nutate_variation, only: variation_t, OF_WHEEL
   use nutate_wheel, only: friction_change
   implicit none
   private

   public :: begin_spheres, turn_spheres, finish_spheres

contains

   !> Makes δL that of the body without its spheres, and computes δτ̄ of all spheres at fixed r and attitude.
   pure subroutine begin_spheres(steps, effects, frame, r, tangent, torque)
      !> Spheres, moved to the end of the step.
      type(sphere_steps_t), intent(in) :: steps
      type(effect_list_t), intent(in) :: effects
      !> u, shape (4), and r, shape (3).
      real(wp), intent(in) :: frame(4), r(3)
      !> Sensitivities at the start; `inner` of the spheres becomes δl0.
      type(tangent_t), intent(inout) :: tangent
      !> N m, body axes at mid step; shape (n, 3).
      real(wp), intent(out) :: torque(:, :)
      integer :: i, j, k
      torque = 0.0_wp
      do k = 1, tangent%n
         do i = 1, steps%n
            j = steps%before + 3*i
            tangent%momentum(k, :) = tangent%momentum(k, :) - tangent%wheels(k, j - 2:j)
            tangent%inner(k, j - 2:j) = tangent%wheels(k, j - 2:j) + cross(tangent%theta(k, :), steps%first(:, i))
            torque(k, :) = torque(k, :) + own_change(steps, effects, i, frame, r, tangent%variations(k), &
                                                     tangent%inner(k, j - 2:j))
         end do
      end do
   end subroutine begin_spheres

   !> Returns δτ̄ of a sphere at fixed φ and r, N m; shape (3).
   pure function own_change(steps, effects, i, frame, r, variation, start) result(torque)
      type(sphere_steps_t), intent(in) :: steps
      type(effect_list_t), intent(in) :: effects
      !> Index of the sphere.
      integer, intent(in) :: i
      !> u, r and δl0; shapes (4), (3), (3).
      real(wp), intent(in) :: frame(4), r(3), start(3)
      type(variation_t), intent(in) :: variation
      real(wp) :: torque(3)
      real(wp) :: pull(3), inertia, damping
      call find_own(effects, steps%before + 3*i, variation, inertia, damping)
      associate (sphere => effects%wheels(steps%before + 3*i), sigma => steps%share(i))
         pull = held_change(steps, i, frame, variation, start)/sphere%inertia &
                - (inertia/sphere%inertia**2)*steps%held(:, i)
         if (steps%turns) pull = pull - rotate_to_body(frame, variation%frame)
         ! κ = c/(1 + ½Δt c/I)
         torque = steps%drag(i)*turned_back(r, pull) + sigma**2*( &
                  damping + 0.5_wp*steps%dt*(sphere%friction/sphere%inertia)**2*inertia)*steps%rate_of(i, r)
      end associate
   end function own_change

   !> Computes the changes of the inertia and of the damping of a sphere.
   pure subroutine find_own(effects, place, variation, inertia, damping)
      type(effect_list_t), intent(in) :: effects
      !> Index of the last component of the sphere.
      integer, intent(in) :: place
      type(variation_t), intent(in) :: variation
      !> kg m², N m s.
      real(wp), intent(out) :: inertia, damping
      integer :: m
      inertia = 0.0_wp
      damping = 0.0_wp
      if (.not. allocated(variation%effects)) return
      do m = 1, size(variation%effects)
         associate (item => variation%effects(m))
            if (item%kind /= OF_WHEEL .or. item%place /= place) cycle
            inertia = item%change(4)
            damping = friction_change(effects%wheels(place), item%change)
         end associate
      end do
   end subroutine find_own

   !> Returns δ(Pl0), seen from u, N m s; shape (3). P rotates by -½Δt ω.
   pure function held_change(steps, i, frame, variation, start) result(change)
      type(sphere_steps_t), intent(in) :: steps
      integer, intent(in) :: i
      real(wp), intent(in) :: frame(4), start(3)
      type(variation_t), intent(in) :: variation
      real(wp) :: change(3)
      change = start
      if (.not. steps%turns) return
      change = change + rotation_change(steps%half_turn, start)
      change = change + cross(turn_change(steps, frame, variation), steps%held(:, i))
   end function held_change

   !> Returns the rotation vector by which a change of ω changes P, P → exp([δ]×)P, seen from u; shape (3).
   pure function turn_change(steps, frame, variation) result(change)
      type(sphere_steps_t), intent(in) :: steps
      real(wp), intent(in) :: frame(4)
      type(variation_t), intent(in) :: variation
      real(wp) :: change(3)
      real(wp) :: v(3), angle, square, first, second
      change = 0.0_wp
      if (.not. any(abs(variation%frame) > 0.0_wp)) return
      v = (-0.5_wp*steps%dt)*steps%frame_rate
      change = (-0.5_wp*steps%dt)*rotate_to_body(frame, variation%frame)
      square = dot_product(v, v)
      angle = sqrt(square)
      first = 0.5_wp - square/24
      second = 1.0_wp/6 - square/120
      if (angle > 1e-3_wp) then
         first = (1 - cos(angle))/square
         second = (angle - sin(angle))/(square*angle)
      end if
      change = change + first*cross(v, change) + second*cross(v, cross(v, change))
   end function turn_change

   !> Computes δl1 of the spheres in `inner`; adds the change of -ω·(l1 - l0) to that of the works.
   pure subroutine turn_spheres(steps, effects, frame, r, tangent)
      type(sphere_steps_t), intent(in) :: steps
      type(effect_list_t), intent(in) :: effects
      !> u, shape (4), and r, shape (3).
      real(wp), intent(in) :: frame(4), r(3)
      !> `mid` holds the rotation at mid step at fixed r, `turn` holds δr.
      type(tangent_t), intent(inout) :: tangent
      real(wp), dimension(3) :: rate, torque, turn, phi, start, change, pull, last
      integer :: i, j, k
      do i = 1, steps%n
         j = steps%before + 3*i
         rate = steps%rate_of(i, r)
         torque = steps%drag(i)*rate
         pull = turned_back(r, steps%pull(:, i))
         last = turned_back(-r, turned_back(-r, steps%last(:, i)))
         do k = 1, tangent%n
            turn = tangent%turn(k, :)
            phi = tangent%mid(k, :) + (2/(1 + dot_product(r, r)))*(turn - cross(r, turn))
            start = tangent%inner(k, j - 2:j)
            change = own_change(steps, effects, i, frame, r, tangent%variations(k), start) &
                     + steps%drag(i)*(cross(pull, phi) - (4/steps%dt)*turn) + cross(phi, torque)
            change = held_change(steps, i, frame, tangent%variations(k), start) - steps%dt*turned_back(-r, change)
            if (steps%turns) then
               change = change + rotation_change(steps%half_turn, change)
               change = change + cross(turn_change(steps, frame, tangent%variations(k)), last)
               tangent%work(k) = tangent%work(k) - dot_product(steps%frame_rate, change - start) - dot_product( &
                                 rotate_to_body(frame, tangent%variations(k)%frame), last - steps%first(:, i))
            end if
            tangent%inner(k, j - 2:j) = change
         end do
      end do
   end subroutine turn_spheres

   !> Computes δh1 from δl1, makes δL that of the body with its spheres, and adds the change of the energy that the
   !> spheres gain to that of the works.
   pure subroutine finish_spheres(steps, effects, r, tangent)
      type(sphere_steps_t), intent(in) :: steps
      type(effect_list_t), intent(in) :: effects
      !> r; shape (3).
      real(wp), intent(in) :: r(3)
      !> Sensitivities with θ and δL at the end.
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: inertia, damping, change(3), before(3)
      integer :: i, j, k
      do i = 1, steps%n
         j = steps%before + 3*i
         associate (sphere => effects%wheels(j), first => steps%first(:, i), last => steps%last(:, i))
            do k = 1, tangent%n
               before = tangent%wheels(k, j - 2:j)
               change = turned_back(r, turned_back(r, tangent%inner(k, j - 2:j))) - cross(tangent%theta(k, :), last)
               tangent%wheels(k, j - 2:j) = change
               tangent%momentum(k, :) = tangent%momentum(k, :) + change
               call find_own(effects, j, tangent%variations(k), inertia, damping)
               tangent%work(k) = tangent%work(k) + (dot_product(last, change) - dot_product(first, before) &
                                                    - 0.5_wp*(inertia/sphere%inertia)*( &
                                                    dot_product(last, last) - dot_product(first, first)))/sphere%inertia
            end do
         end associate
      end do
   end subroutine finish_spheres

end module nutate_sphere_tangent
