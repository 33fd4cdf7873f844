!> Bodies moved together, lane by lane: the bits of the scalar stepper, whoever stands beside.
module test_lanes
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: rotor_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_hamiltonian, only: kinetic_energy, make_state, space_momentum, total_energy
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: make_stepper
   use nutate_philox, only: uniform_of
   use nutate_quaternion, only: quat_normalized
   use nutate_reduced_lanes, only: lanes, reduced_lanes_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use test_support, only: check_below
   use testdrive, only: check, error_type, new_unittest, test_failed, unittest_type
   implicit none
   private

   public :: collect_lanes

   !> Bodies without anything; with a rotor; tops; with rotor, weight and a dipole; pendulums in a plane, many of whose
   !> numbers are zeros; in a gradient of gravity; in one with a rotor and a dipole before it.
   integer, parameter :: FREE = 0, GYROSTAT = 1, TOP = 2, LOADED = 3, PENDULUM = 4, SATELLITE = 5, MAGNETIC = 6

contains

   subroutine collect_lanes(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("lanes have the bits of the scalar stepper, at every order", same_bits), &
                  new_unittest("bodies given up leave the others as they are", poisoned_lanes), &
                  new_unittest("a lane is given up rather than taken off the branch", long_steps), &
                  new_unittest("energy and momentum of each body over 50 000 steps", long_run)]
   end subroutine collect_lanes

   !> A body drawn at random, of no symmetry, its axes not principal ones, and its start.
   subroutine draw(number, rate, kind, system, state, error)
      integer, intent(in) :: number
      !> Angular velocity up to this, rad/s.
      real(wp), intent(in) :: rate
      !> `FREE`, ...
      integer, intent(in) :: kind
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      real(wp) :: u(12), tensor(3, 3), product
      integer :: i
      u = [(uniform_of(5_long, int(number, long), i), i=1, 12)]
      tensor = diagonal(10**(4*u(1) - 2)*(1 + 0.6_wp*u(2:4)))
      product = 0.05_wp*tensor(1, 1)*merge(0.0_wp, 1.0_wp, mod(number, 3) == 0)
      tensor(1, 2) = product*u(5)
      tensor(1, 3) = -product*u(6)
      tensor(2, 3) = product*u(7)
      tensor(2, 1) = tensor(1, 2)
      tensor(3, 1) = tensor(1, 3)
      tensor(3, 2) = tensor(2, 3)
      if (kind == PENDULUM) tensor = diagonal([tensor(1, 1), tensor(2, 2), tensor(3, 3)])
      call make_body(tensor, system%body, status)
      if (.not. status%ok()) call test_failed(error, trim(status%message))
      system%body%mass = tensor(1, 1)
      system%body%center_of_mass = merge([u(4), 0.0_wp, 0.0_wp], u(4:6) - 0.5_wp, kind == PENDULUM)
      if (any(kind == [GYROSTAT, LOADED, MAGNETIC])) &
         call system%effects%add(rotor_t(name='rotor', momentum=rate*tensor(1, 1)*(u(3:5) - 0.5_wp)))
      ! Slow bodies are not turned over by their weight within a step.
      if (any(kind == [TOP, LOADED, PENDULUM])) &
         call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -rate*rate]))
      if (any(kind == [LOADED, MAGNETIC])) &
         call system%effects%add(dipole_t(tensor(1, 1)*(u(6:8) - 0.5_wp), rate*rate*(u(1:3) - 0.5_wp)))
      if (kind >= SATELLITE) call system%effects%add(gravity_gradient_t(system%body, u(1:3) - 0.5_wp, rate*rate*u(9)))
      if (kind == PENDULUM) then
         state = make_state(system, quat_normalized([0.5_wp, 0.0_wp, u(8), 0.0_wp]), [0.0_wp, rate*u(10), 0.0_wp])
      else
         state = make_state(system, quat_normalized([u(8:10), 0.5_wp] - 0.5_wp + [0.1_wp, 0.0_wp, 0.0_wp, 0.5_wp]), &
                            rate*(2*u(10:12) - 1))
      end if
   end subroutine draw

   !> Empties the lanes for bodies of a kind.
   subroutine begin(bodies, order, dt, kind)
      type(reduced_lanes_t), intent(inout) :: bodies
      integer, intent(in) :: order, kind
      real(wp), intent(in) :: dt
      integer, parameter :: potentials(0:6) = [0, 0, 1, 2, 1, 1, 2]
      call bodies%set_up(order, dt, potentials(kind))
   end subroutine begin

   !> Takes the scalar steps of a body.
   subroutine take_scalar(order, system, dt, steps, state, error)
      integer, intent(in) :: order, steps
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(state_t), intent(inout) :: state
      type(error_type), allocatable, intent(inout) :: error
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      integer :: i
      call make_stepper(system, integrator_settings_t(order=order, linear_solver='reduced'), stepper, status)
      do i = 1, steps
         if (status%ok()) call stepper%advance(system, state, dt, state%t + 0.5_wp*dt, status)
      end do
      if (.not. status%ok()) call test_failed(error, trim(status%message))
   end subroutine take_scalar

   pure logical function agree(a, b)
      type(state_t), intent(in) :: a, b
      agree = all(bits(a) == bits(b))
   end function agree

   pure function bits(state)
      type(state_t), intent(in) :: state
      integer(long) :: bits(16)
      bits = transfer([state%q, state%p, state%q_compensation, state%p_compensation], bits)
   end function bits

   subroutine same_bits(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: orders(4) = [2, 4, 6, 8]
      type(reduced_lanes_t) :: bodies
      type(system_t) :: systems(lanes)
      type(state_t) :: states(lanes), state
      character(len=60) :: place
      integer :: block, i, k, n, kind, taken(FREE:MAGNETIC), drawn(FREE:MAGNETIC)
      taken = 0
      drawn = 0
      n = 400
      do block = 1, 56
         kind = block/8
         if (kind > MAGNETIC) kind = FREE
         associate (order => orders(1 + mod(block, 4)))
            call begin(bodies, order, 0.1_wp, kind)
            ! From one lane that is used to all of them.
            do i = 1, 1 + mod(block, lanes)
               call draw(100*block + i, 0.05_wp*2**mod(block, 8), kind, systems(i), states(i), error)
               if (allocated(error)) return
               call bodies%put(i, systems(i), states(i))
            end do
            do k = 1, n
               call bodies%step()
            end do
            do i = 1, 1 + mod(block, lanes)
               drawn(kind) = drawn(kind) + 1
               if (.not. bodies%taken(i)) cycle
               taken(kind) = taken(kind) + 1
               state = states(i)
               call take_scalar(order, systems(i), 0.1_wp, n, states(i), error)
               if (allocated(error)) return
               call bodies%get(i, state)
               write (place, '("block ",i0,", lane ",i0,", order ",i0,", kind ",i0)') block, i, order, kind
               call check(error, agree(state, states(i)), place)
               if (allocated(error)) return
            end do
         end associate
      end do
      call check(error, all(10*taken > 4*drawn) .and. 10*sum(taken) > 7*sum(drawn), 'too few bodies were taken')
   end subroutine same_bits

   subroutine poisoned_lanes(error)
      type(error_type), allocatable, intent(out) :: error
      type(reduced_lanes_t) :: alone, beside
      type(system_t) :: system, bad
      type(state_t) :: state, poison, a, b
      integer, parameter :: kinds(5) = [FREE, GYROSTAT, TOP, LOADED, MAGNETIC]
      integer :: case, k, kind
      do case = 1, 30
         kind = kinds(1 + (case - 1)/6)
         call draw(7, 0.1_wp, kind, system, state, error)
         call draw(8, 0.1_wp, kind, bad, poison, error)
         if (allocated(error)) return
         select case (mod(case, 6))
         case (1)
            poison%p = 1e4_wp*poison%p
         case (2)
            poison%q = 1.1_wp*poison%q
         case (3)
            poison%p(2) = huge(1.0_wp)
         case (4)
            poison%p = 1e-200_wp*poison%p
         case (5)
            poison%p(3) = ieee_value(1.0_wp, ieee_quiet_nan)
         case default
            ! As long as no step can follow it, but the first tries to.
            poison%p = 40*poison%p
         end select
         call begin(alone, 2, 0.5_wp, kind)
         call begin(beside, 2, 0.5_wp, kind)
         call alone%put(3, system, state)
         call beside%put(3, system, state)
         do k = 1, lanes
            if (k /= 3) call beside%put(k, bad, poison)
         end do
         do k = 1, 200
            call alone%step()
            call beside%step()
         end do
         call check(error, alone%taken(3) .and. count(beside%taken) == 1 .and. beside%taken(3), 'taken')
         if (allocated(error)) return
         call alone%get(3, a)
         call beside%get(3, b)
         call check(error, agree(a, b), 'a poisoned lane changes another one')
         if (allocated(error)) return
      end do
   end subroutine poisoned_lanes

   !> Rates from short steps to far too long ones: what is taken is what the scalar stepper takes.
   subroutine long_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(reduced_lanes_t) :: bodies
      type(system_t) :: system
      type(state_t) :: state, scalar
      integer :: i, k, taken
      taken = 0
      do i = 1, 120
         associate (kind => merge(FREE, TOP, i <= 60))
            call draw(i, 0.2_wp*1.1_wp**mod(i, 60), kind, system, state, error)
            if (allocated(error)) return
            call begin(bodies, 2, 0.5_wp, kind)
         end associate
         call bodies%put(1, system, state)
         do k = 1, 50
            call bodies%step()
         end do
         if (.not. bodies%taken(1)) cycle
         taken = taken + 1
         scalar = state
         call take_scalar(2, system, 0.5_wp, 50, scalar, error)
         if (allocated(error)) return
         call bodies%get(1, state)
         call check(error, agree(state, scalar), 'a long step that was taken')
         if (allocated(error)) return
      end do
      call check(error, taken > 20 .and. taken < 100, 'steps are neither taken nor given up')
   end subroutine long_steps

   !> Of the gradient of gravity, about which the momentum stays.
   pure function direction(system) result(n)
      type(system_t), intent(in) :: system
      real(wp) :: n(3)
      n = system%effects%potentials(1)%item%direction
   end function direction

   !> Free bodies; tops, whose momentum about the vertical stays; satellites, whose momentum about the direction of the
   !> gradient does. Shorter than `make bench` runs them.
   subroutine long_run(error)
      type(error_type), allocatable, intent(out) :: error
      type(reduced_lanes_t) :: bodies
      type(system_t) :: systems(lanes)
      type(state_t) :: states(lanes), state
      real(wp) :: energy, momentum(3), change(3)
      integer, parameter :: kinds(3) = [FREE, TOP, SATELLITE]
      integer :: i, k, kind, n
      do n = 1, 3
         kind = kinds(n)
         call begin(bodies, 2, 0.1_wp, kind)
         do i = 1, lanes
            call draw(i, 0.5_wp, kind, systems(i), states(i), error)
            if (allocated(error)) return
            call bodies%put(i, systems(i), states(i))
         end do
         do k = 1, 50000
            call bodies%step()
         end do
         call check(error, all(bodies%taken), 'taken')
         do i = 1, lanes
            if (allocated(error)) return
            state = states(i)
            call bodies%get(i, state)
            energy = total_energy(systems(i), states(i))
            momentum = space_momentum(states(i))
            change = space_momentum(state) - momentum
            if (kind == TOP) change(1:2) = 0.0_wp
            call check_below(error, abs(total_energy(systems(i), state) - energy), &
                             100*eps*kinetic_energy(systems(i), states(i)), 'energy')
            if (kind == SATELLITE) change = dot_product(change, direction(systems(i)))*direction(systems(i))
            if (allocated(error)) return
            call check_below(error, norm2(change), 100*eps*norm2(momentum), 'momentum')
            if (allocated(error)) return
            call check_below(error, abs(dot_product(state%q, state%q) - 1), 20*eps, 'norm')
         end do
      end do
   end subroutine long_run

end module test_lanes
