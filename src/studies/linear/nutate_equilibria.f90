!> All attitudes in which a body with rotors and wheels rests in the space axes, which may rotate: on a circular orbit,
!> its relative equilibria. They are the critical points, over the rotations, of the effective potential
!>
!>     W = V - ½Ω·JΩ - h·Ω,   Ω = Rᵀω,
!>
!> with ω the rate of the space axes and h the momentum of rotors and wheels against the body. Newton's method solves L̇
!> = 0 from many attitudes; the derivatives are those of the linearised motion. By Morse's theory there are as many
!> critical points with an even as with an odd number of negative directions. If a direction is flat, W along its valley
!> decides; a constant W means a curve of equilibria.
module nutate_equilibria
   use nutate_attitude, only: quat_from_rotation_vector
   use nutate_hamiltonian, only: body_momentum, frame_rate_of, make_state, potential_energy, system_t
   use nutate_kinds, only: wp, pi
   use nutate_lapack, only: dgesv, general_eigenvalues, symmetric_eigen
   use nutate_linear_rates, only: linearize_rates
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_quaternion, only: attitude_distance, cross, quat_normalized, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: equilibria_t, equilibrium_t, find_equilibria

   !> An equilibrium.
   type :: equilibrium_t
      !> Unit quaternion whose first component that is not 0 is positive, body→space; shape (4).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> W, J.
      real(wp) :: energy = 0.0_wp
      !> Negative directions of W: 0 at a minimum, which is stable.
      integer :: index = 0
      !> A direction of W is flat to second order: equilibria part or vanish here. The attitude is good to 1e-5 rad.
      logical :: degenerate = .false.
      !> The largest real part of the eigenvalues of the linearised motion, 1/s; 0: stable to first order.
      real(wp) :: growth = 0.0_wp
   end type equilibrium_t

   !> The equilibria of a body, by W.
   type :: equilibria_t
      type(equilibrium_t), allocatable :: items(:)
      !> Attitudes are relative to the LVLH frame of the orbit; if not, to the space axes.
      logical :: in_lvlh = .false.
      !> There are as many equilibria of even as of odd index: none was missed alone.
      logical :: balanced = .false.
   contains
      !> Returns the number of equilibria of an index.
      procedure :: number_of
   end type equilibria_t

   !> Number of attitudes from which Newton's method starts; the second one is used if the first did not suffice.
   integer, parameter :: starts(2) = [1500, 12000]
   !> Limits of the iteration, and of the rotation in a step, rad.
   integer, parameter :: most_iterations = 60
   real(wp), parameter :: longest_turn = 0.3_wp
   !> A correction from which on Newton's method has converged, and distances of equilibria that are one, rad; the
   !> second ones of degenerate ones.
   real(wp), parameter :: settled = 1e-10_wp, same(2) = [1e-6_wp, 1e-2_wp]
   !> Shares of the largest derivative below which a torque, and a derivative, count as 0; and that of rounding in
   !> eigenvalues, of which it splits a double one by its root.
   real(wp), parameter :: at_rest = 1e-9_wp, flat = 1e-8_wp, indistinct(2) = [1e-6_wp, 1e-4_wp]
   !> A way along a flat direction, rad, and the share of the largest derivative by which W changes there at least.
   real(wp), parameter :: way = 0.1_wp, level = 1e-9_wp
   integer, parameter :: most_equilibria = 100

contains

   !> Finds all equilibria relative to the space axes or, if potentials depend on the time, to the LVLH frame of a
   !> circular orbit. Errors: `NUTATE_BAD_ARGUMENT` for effects that are no constant potentials, rotors or free wheels
   !> there, and if equilibria are not isolated.
   subroutine find_equilibria(system, speeds, found, status)
      type(system_t), intent(in) :: system
      !> Speeds of the wheels relative to the body, rad/s; shape (wheels).
      real(wp), intent(in) :: speeds(:)
      type(equilibria_t), intent(out) :: found
      type(status_t), intent(out) :: status
      type(lvlh_view_t) :: view
      type(system_t) :: seen
      type(equilibrium_t) :: list(most_equilibria), one
      !> Torque at rest, N m, and its derivative with respect to a rotation, N m/rad, body axes; the matrix of ẋ = A x.
      real(wp) :: torque(3), by_turn(3, 3)
      real(wp), allocatable :: a(:, :)
      integer :: n, i, pass
      call view%prepare(system)
      found%in_lvlh = view%exists .or. in_lvlh_axes(system)
      seen = system
      if (view%exists) seen = view%system
      call check_statics(seen, status)
      allocate (a(6 + seen%effects%n_wheels, 6 + seen%effects%n_wheels))
      n = 0
      do pass = 1, size(starts)
         do i = 0, starts(pass) - 1
            if (.not. status%ok()) return
            call solve(attitude_of(i, starts(pass)))
            if (.not. status%ok() .or. one%index < 0) cycle
            if (is_known(one, list(:n))) cycle
            n = n + 1
            if (n > most_equilibria) then
               status = fail(NUTATE_BAD_ARGUMENT, 'there are more than 100 equilibria (expected fewer)')
               return
            end if
            list(n) = one
         end do
         ! W has a minimum at least.
         if (n == 0) status = not_isolated()
         if (n == 0) return
         found%balanced = 2*count(modulo(list(:n)%index, 2) == 0) == n
         if (found%balanced) exit
      end do
      found%items = list(:n)
      call sort(found%items)

   contains

      !> Solves L̇ = 0 by Newton's method; the index is -1 if the iteration does not converge.
      subroutine solve(start)
         !> Attitude; shape (4).
         real(wp), intent(in) :: start(4)
         real(wp) :: factors(3, 3), turn(3, 1), largest, scale
         integer :: k, pivots(3), info
         one = equilibrium_t(q=start, index=-1)
         scale = 0.0_wp
         do k = 1, most_iterations
            call rest_torque(one%q)
            if (.not. status%ok()) return
            factors = by_turn
            turn(:, 1) = -torque
            scale = max(scale, maxval(abs(by_turn)))
            call dgesv(3, 1, factors, 3, pivots, turn, 3, info)
            if (info /= 0 .or. .not. maxval(abs(turn)) <= huge(1.0_wp)) exit
            largest = maxval(abs(turn))
            one%q = quat_normalized(quat_product(one%q, quat_from_rotation_vector( &
                    turn(:, 1)*min(1.0_wp, longest_turn/max(largest, tiny(largest))))))
            if (largest > settled) cycle
            call describe()
            return
         end do
         ! At rest, but the corrections do not vanish: a direction is flat.
         if (maxval(abs(torque)) <= at_rest*scale) call describe()
      end subroutine solve

      !> Computes L̇ of a body that rests in the space axes, its derivative by a rotation at the end of which the body
      !> rests too, and the linearised motion.
      subroutine rest_torque(q)
         real(wp), intent(in) :: q(4)
         real(wp) :: rates(size(a, 1)), omega(3), unit(3)
         integer :: k
         omega = frame_rate_of(seen%effects, q)
         call linearize_rates(seen, make_state(seen, q, omega, speeds=speeds), rates, a, status)
         torque = matmul(seen%body%inertia, rates(4:6))
         do k = 1, 3
            unit = 0.0_wp
            unit(k) = 1.0_wp
            by_turn(:, k) = matmul(seen%body%inertia, a(4:6, k) + matmul(a(4:6, 4:6), cross(omega, unit)))
         end do
      end subroutine rest_torque

      !> Computes energy, index and growth. Errors: `NUTATE_BAD_ARGUMENT` if W is constant in some direction.
      subroutine describe()
         complex(wp) :: eigenvalues(size(a, 1))
         real(wp) :: values(3), vectors(3, 3)
         integer :: k
         where (abs(one%q) < 4*epsilon(1.0_wp)) one%q = 0.0_wp
         if (one%q(findloc(abs(one%q) > 0.0_wp, .true., dim=1)) < 0.0_wp) one%q = -one%q
         call rest_torque(one%q)
         if (status%ok()) call symmetric_eigen(-0.5_wp*(by_turn + transpose(by_turn)), values, vectors, status)
         if (status%ok()) call general_eigenvalues(a, eigenvalues, status)
         if (.not. status%ok()) return
         one%energy = effective_potential(one%q)
         one%index = count(values < 0.0_wp)
         k = minloc(abs(values), dim=1)
         one%degenerate = abs(values(k)) <= flat*maxval(abs(values))
         if (one%degenerate) then
            one%index = count([values(:k - 1), values(k + 1:)] < 0.0_wp)
            call descend(k, values, vectors)
         end if
         one%growth = maxval(real(eigenvalues, wp))
         if (one%growth <= merge(indistinct(2), indistinct(1), one%degenerate)*maxval(abs(eigenvalues))) &
            one%growth = 0.0_wp
      end subroutine describe

      !> Adds 1 to the index if W falls along the valley of a flat direction, on which the torque across it vanishes.
      subroutine descend(k, values, vectors)
         !> The flat one of the directions of W; second derivatives in them, and the directions.
         integer, intent(in) :: k
         real(wp), intent(in) :: values(3), vectors(3, 3)
         real(wp) :: q(4), turn(3), change(2)
         integer :: side, i, pass
         do side = 1, 2
            q = quat_product(one%q, quat_from_rotation_vector((2*side - 3)*way*vectors(:, k)))
            do pass = 1, most_iterations
               call rest_torque(q)
               if (.not. status%ok()) return
               turn = 0.0_wp
               do i = 1, 3
                  if (i /= k .and. abs(values(i)) > flat*maxval(abs(values))) &
                     turn = turn + vectors(:, i)*dot_product(vectors(:, i), torque)/values(i)
               end do
               q = quat_normalized(quat_product(q, quat_from_rotation_vector(turn)))
            end do
            change(side) = effective_potential(q) - one%energy
         end do
         if (all(abs(change) <= level*maxval(abs(values)))) status = not_isolated()
         if (all(change < 0.0_wp)) one%index = one%index + 1
      end subroutine descend

      !> Returns W, J.
      pure real(wp) function effective_potential(q) result(w)
         real(wp), intent(in) :: q(4)
         real(wp) :: omega(3)
         omega = frame_rate_of(seen%effects, q)
         ! The sum of the momenta at rest and with Ω is JΩ + 2h, J with the wheels locked.
         w = potential_energy(seen%effects, q) - 0.5_wp*dot_product(omega, &
             body_momentum(make_state(seen, q, [0.0_wp, 0.0_wp, 0.0_wp], speeds=speeds)) + &
             body_momentum(make_state(seen, q, omega, speeds=speeds)))
      end function effective_potential

   end subroutine find_equilibria

   !> Returns true if the space axes are those of the LVLH frame.
   pure logical function in_lvlh_axes(system)
      type(system_t), intent(in) :: system
      in_lvlh_axes = .false.
      if (system%effects%on_orbit) in_lvlh_axes = system%effects%orbit%is_frame
   end function in_lvlh_axes

   !> Returns the number of equilibria of an index.
   pure integer function number_of(self, index)
      class(equilibria_t), intent(in) :: self
      integer, intent(in) :: index
      number_of = count(self%items%index == index)
   end function number_of

   !> Errors: `NUTATE_BAD_ARGUMENT` for effects whose equilibria do not follow from a potential.
   subroutine check_statics(system, status)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      integer :: i
      associate (effects => system%effects)
         if (effects%varies) then
            status = fail(NUTATE_BAD_ARGUMENT, 'nothing rests where the inertia depends on the time (expected no '// &
                          'inertia_rate and inertia_table)')
         else if (effects%moves) then
            status = fail(NUTATE_BAD_ARGUMENT, 'nothing rests where potentials depend on the time (expected '// &
                          'gravity gradients of one circular &orbit, fields that are fixed in the space axes)')
         else if (effects%n_torques > 0) then
            status = fail(NUTATE_BAD_ARGUMENT, 'equilibria are those of potentials (expected no torques and '// &
                          'controllers)')
         else if (effects%n_potentials == 0) then
            status = fail(NUTATE_BAD_ARGUMENT, 'no potential acts (expected one, such as &gravity_gradient)')
         end if
         if (effects%n_spheres > 0) status = fail( &
            NUTATE_BAD_ARGUMENT, 'equilibria are those of bodies without inner spheres (expected no &inner_sphere)')
         do i = 1, effects%n_reaction_wheels
            if (allocated(effects%wheels(i)%motor) .or. effects%wheels(i)%friction > 0.0_wp) status = fail( &
               NUTATE_BAD_ARGUMENT, 'equilibria are those of free wheels (expected no motor and no friction)')
         end do
      end associate
   end subroutine check_statics

   !> Spreads attitudes evenly over the rotations: a super-Fibonacci spiral (Alexa 2022, CVPR, eq. 14).
   pure function attitude_of(i, n) result(q)
      !> 0 to n - 1.
      integer, intent(in) :: i, n
      real(wp) :: q(4)
      real(wp), parameter :: phi = sqrt(2.0_wp), psi = 1.533751168755204288118041_wp
      real(wp) :: s, alpha, beta, inner, outer
      s = i + 0.5_wp
      alpha = 2*pi*modulo(s/phi, 1.0_wp)
      beta = 2*pi*modulo(s/psi, 1.0_wp)
      inner = sqrt(s/n)
      outer = sqrt(1 - s/n)
      q = [inner*sin(alpha), inner*cos(alpha), outer*sin(beta), outer*cos(beta)]
   end function attitude_of

   pure type(status_t) function not_isolated() result(status)
      status = fail(NUTATE_BAD_ARGUMENT, 'equilibria are not isolated: the effects do not feel some rotation '// &
                    '(expected three different moments of inertia, and several directions or a rotating frame)')
   end function not_isolated

   pure subroutine sort(list)
      type(equilibrium_t), intent(inout) :: list(:)
      type(equilibrium_t) :: one
      integer :: i, k
      do i = 2, size(list)
         one = list(i)
         do k = i - 1, 1, -1
            if (.not. precedes(one, list(k))) exit
            list(k + 1) = list(k)
         end do
         list(k + 1) = one
      end do
   end subroutine sort

   !> Returns true if an equilibrium comes before another: by energy, or by attitude if the energies are equal.
   pure logical function precedes(one, other)
      type(equilibrium_t), intent(in) :: one, other
      integer :: k
      precedes = one%energy < other%energy
      if (abs(one%energy - other%energy) > settled*(abs(one%energy) + abs(other%energy))) return
      do k = 1, 4
         precedes = one%q(k) > other%q(k)
         if (abs(one%q(k) - other%q(k)) > same(1)) return
      end do
   end function precedes

   pure logical function is_known(one, list)
      type(equilibrium_t), intent(in) :: one, list(:)
      integer :: i
      is_known = .true.
      do i = 1, size(list)
         if (attitude_distance(one%q, list(i)%q) < merge(same(2), same(1), one%degenerate)) return
      end do
      is_known = .false.
   end function is_known

end module nutate_equilibria
