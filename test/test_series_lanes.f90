!> Bodies moved together by Taylor series, lane by lane: the bits of the scalar stepper, whoever stands beside.
module test_series_lanes
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: rotor_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_hamiltonian, only: kinetic_energy, make_state, space_momentum, total_energy
   use nutate_kinds, only: wp, eps, long
   use nutate_lane_width, only: lanes
   use nutate_methods, only: default_settings, make_stepper
   use nutate_philox, only: uniform_of
   use nutate_quaternion, only: quat_normalized
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use nutate_taylor_lanes, only: taylor_lanes_t
   use test_support, only: check, check_below, error_type, is_slow_build, new_unittest, test_failed, unittest_type
   implicit none
   private

   public :: collect_series_lanes

   !> Bodies without anything, and tops; both with an axis of symmetry; with a dipole and weight along one direction;
   !> pendulums in a plane, many of whose numbers are zeros; gyrostats; bodies whose axes are not principal ones,
   !> without and with a rotor; symmetric ones with a rotor along the axis, and tops of these; tops with any rotor and
   !> axes; tops with dipoles in other directions. Satellites in a gradient of gravity; with any rotor and axes; in a
   !> plane; with weight along the gradient, and with a dipole across it; symmetric ones with a rotor along the axis,
   !> and with such weight and dipole.
   integer :: i
   integer, parameter :: FREE = 0, TOP = 1, SYMMETRIC = 2, SYMMETRIC_TOP = 3, LOADED = 4, PENDULUM = 5, GYROSTAT = 6, &
      SKEW = 7, SKEW_GYROSTAT = 8, SPINNER = 9, SPINNING_TOP = 10, SKEW_TOP = 11, CROSSED_TOP = 12, &
      SATELLITE = 13, SKEW_SATELLITE = 14, PLANAR = 15, HANGING = 16, CROSSED = 17, &
      SPIN_STABLE = 18, SYMMETRIC_CROSSED = 19, last_kind = SYMMETRIC_CROSSED
   !> Kinds that have a closed solution, and no lane.
   logical, parameter :: is_free(FREE:last_kind) = [(any(i == [FREE, SYMMETRIC, SKEW]), i=FREE, last_kind)]
   !> Where weights point; of pendulums along an axis.
   real(wp), parameter :: down(3) = [0.6_wp, 0.0_wp, -0.8_wp]

contains

   subroutine collect_series_lanes(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("lanes have the bits of the scalar stepper, at every order and length", same_bits), &
                  new_unittest("spins about principal axes and slow bodies", special_bodies), &
                  new_unittest("bodies given up leave the others as they are", poisoned_lanes), &
                  new_unittest("symmetric bodies whose rotors make the series grow are given up", fast_rotors), &
                  new_unittest("bodies that are unlike the first are left out", unlike_bodies), &
                  new_unittest("steps of any length: what is taken is what the scalar stepper takes", long_steps), &
                  new_unittest("energy and momentum of each body over 20 000 steps", long_run)]
   end subroutine collect_series_lanes

   !> A body drawn at random, and its start.
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
      integer, parameter :: with_axis(6) = [SYMMETRIC, SYMMETRIC_TOP, SPINNER, SPINNING_TOP, SPIN_STABLE, &
                                            SYMMETRIC_CROSSED]
      real(wp) :: u(12), moments(3), tensor(3, 3)
      integer :: i
      u = [(uniform_of(6_long, int(number, long), i), i=1, 12)]
      moments = 10**(4*u(1) - 2)*(1 + 0.9_wp*u(2:4))
      if (any(kind == with_axis)) moments(1) = moments(3)
      tensor = diagonal(moments)
      if (any(kind == [SKEW, SKEW_GYROSTAT, SKEW_TOP, SKEW_SATELLITE])) then
         tensor(1, 2) = 0.05_wp*moments(1)*u(5)
         tensor(1, 3) = -0.05_wp*moments(1)*u(6)
         tensor(2, 1) = tensor(1, 2)
         tensor(3, 1) = tensor(1, 3)
      end if
      call make_body(tensor, system%body, status)
      if (.not. status%ok()) call test_failed(error, trim(status%message))
      system%body%mass = moments(1)
      system%body%center_of_mass = u(4:6) - 0.5_wp
      if (any(kind == with_axis)) system%body%center_of_mass = [0.0_wp, u(4), 0.0_wp]
      if (kind == PENDULUM) system%body%center_of_mass = [u(4), 0.0_wp, 0.0_wp]
      ! Slow bodies are not turned over by their weight within a step.
      if (kind == PENDULUM) then
         call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -rate*rate]))
      else if (any(kind == [TOP, SYMMETRIC_TOP, LOADED, SPINNING_TOP, SKEW_TOP, CROSSED_TOP, HANGING, &
                          SYMMETRIC_CROSSED])) then
         call system%effects%add(gravity_t(system%body, rate*rate*down))
      end if
      if (kind == LOADED) call system%effects%add(dipole_t(moments(1)*(u(6:8) - 0.5_wp), -rate*rate*down))
      if (any(kind == [SATELLITE, SKEW_SATELLITE, PLANAR, HANGING, CROSSED, SPIN_STABLE, SYMMETRIC_CROSSED])) &
         call system%effects%add(gravity_gradient_t(system%body, merge([0.0_wp, 0.0_wp, -1.0_wp], down, &
                                                                       kind == PLANAR), rate*rate))
      if (any(kind == [CROSSED_TOP, CROSSED])) &
         call system%effects%add(dipole_t(moments(1)*(u(6:8) - 0.5_wp), rate*rate*(u(8:10) - 0.5_wp)))
      if (kind == CROSSED_TOP) call system%effects%add(dipole_t(moments(1)*(u(7:9) - 0.5_wp), &
                                                                rate*rate*(u(3:5) - 0.5_wp)))
      if (kind == SYMMETRIC_CROSSED) call system%effects%add(dipole_t(moments(1)*[0.0_wp, u(6), 0.0_wp], &
                                                                      rate*rate*(u(8:10) - 0.5_wp)))
      if (any(kind == [GYROSTAT, SKEW_GYROSTAT, SKEW_TOP, SKEW_SATELLITE])) &
         call system%effects%add(rotor_t(name='rotor', momentum=rate*moments(1)*(u(3:5) - 0.5_wp)))
      if (any(kind == [SPINNER, SPINNING_TOP, SPIN_STABLE])) &
         call system%effects%add(rotor_t(name='rotor', momentum=rate*moments(1)*[0.0_wp, u(4) - 0.5_wp, 0.0_wp]))
      if (any(kind == [PENDULUM, PLANAR])) then
         state = make_state(system, quat_normalized([0.5_wp, 0.0_wp, u(8), 0.0_wp]), [0.0_wp, rate*u(10), 0.0_wp])
      else
         state = make_state(system, quat_normalized([u(8:10), 0.5_wp] - 0.5_wp + [0.1_wp, 0.0_wp, 0.0_wp, 0.5_wp]), &
                            rate*(2*u(10:12) - 1))
      end if
   end subroutine draw

   !> Performs the scalar steps of a body, and looks at it after some of them.
   subroutine run_scalar(order, system, dt, steps, state, seen, error)
      integer, intent(in) :: order, steps
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      !> As the last step leaves it.
      type(state_t), intent(inout) :: state
      !> As it is to be seen.
      type(state_t), intent(out) :: seen
      type(error_type), allocatable, intent(inout) :: error
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(status_t) :: status
      integer :: i
      settings = default_settings('taylor')
      settings%series_order = order
      call make_stepper(system, settings, stepper, status)
      do i = 1, steps
         if (status%ok()) call stepper%advance(system, state, dt, state%t + 0.5_wp*dt, status)
      end do
      if (.not. status%ok()) call test_failed(error, trim(status%message))
      seen = state
      call stepper%show(system, seen)
   end subroutine run_scalar

   pure logical function agree(a, b)
      type(state_t), intent(in) :: a, b
      agree = all(bits(a) == bits(b))
   end function agree

   pure function bits(state)
      type(state_t), intent(in) :: state
      integer(long) :: bits(16)
      bits = transfer([state%q, state%p, state%q_compensation, state%p_compensation], bits)
   end function bits

   !> Compares a lane with the scalar stepper.
   subroutine compare(bodies, lane, order, system, dt, steps, first, place, error)
      !> After so many steps, and before the last of these are looked at.
      type(taylor_lanes_t), intent(in) :: bodies
      integer, intent(in) :: lane, order, steps
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: dt
      type(state_t), intent(in) :: first
      character(len=*), intent(in) :: place
      type(error_type), allocatable, intent(inout) :: error
      type(taylor_lanes_t) :: looked
      type(state_t) :: state, scalar, seen
      scalar = first
      call run_scalar(order, system, dt, steps, scalar, seen, error)
      state = first
      call bodies%get(lane, state)
      call check(error, agree(state, scalar), place)
      looked = bodies
      call looked%look()
      call check(error, looked%taken(lane), place//': given up when it was looked at')
      call looked%get(lane, state)
      call check(error, agree(state, seen), place//', as it is seen')
   end subroutine compare

   subroutine same_bits(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: orders(6) = [0, 4, 7, 12, 20, 28]
      type(taylor_lanes_t) :: bodies
      type(system_t) :: systems(lanes)
      type(state_t) :: states(lanes)
      character(len=200) :: place
      integer :: block, i, k, n, kind, taken(FREE:last_kind), drawn(FREE:last_kind)
      taken = 0
      drawn = 0
      do block = 1, 12*(1 + last_kind)
         kind = mod(block/3, 1 + last_kind)
         ! Rows may end at any step from a projection to the next.
         n = merge(56, 200, is_slow_build()) + mod(block, 4)
         associate (order => orders(1 + mod(block, 6)))
            call bodies%set_up(order, 0.1_wp)
            ! From one lane that is used to all of them.
            do i = 1, 1 + mod(block, lanes)
               call draw(100*block + i, 0.05_wp*2**mod(block, 8), kind, systems(i), states(i), error)
               if (allocated(error)) return
               call bodies%put(i, systems(i), states(i))
            end do
            do k = 1, n
               call bodies%step()
               ! Not after the last one.
               if (mod(k, 9) == 0) call bodies%look()
            end do
            do i = 1, 1 + mod(block, lanes)
               drawn(kind) = drawn(kind) + 1
               if (.not. bodies%taken(i)) cycle
               taken(kind) = taken(kind) + 1
               write (place, '("block ",i0,", lane ",i0,", order ",i0,", kind ",i0)') block, i, order, kind
               call compare(bodies, i, order, systems(i), 0.1_wp, n, states(i), trim(place), error)
            end do
         end associate
      end do
      write (place, '("taken ",20i4," of ",20i4)') taken, drawn
      call check(error, all((10*taken > 5*drawn) .neqv. is_free) .and. all(taken == 0 .or. .not. is_free), place)
      drawn = merge(0, drawn, is_free)
      call check(error, 10*sum(taken) > 8*sum(drawn), place)
   end subroutine same_bits

   !> Series whose coefficients vanish, or are all but zero, have no recurrence.
   subroutine special_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: bodies
      type(system_t) :: system
      type(state_t) :: states(6)
      type(status_t) :: status
      real(wp), parameter :: rates(3, 6) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, &
                                                    0.0_wp, 0.0_wp, 2.0_wp, 1e-9_wp, 1.0_wp, 1e-12_wp, &
                                                    1e-20_wp, 1e-20_wp, 0.0_wp, 1e-160_wp, 1.0_wp, 1e-170_wp], [3, 6])
      integer :: i, k
      call make_body(diagonal([5.0_wp, 20.0_wp, 17.0_wp]), system%body, status)
      call system%effects%add(rotor_t(name='rotor', momentum=[0.0_wp, 1e-3_wp, 0.0_wp]))
      call bodies%set_up(0, 0.125_wp)
      do i = 1, 6
         states(i) = make_state(system, quat_normalized([1.0_wp, 2.0_wp, 3.0_wp, -1.0_wp]), rates(:, i))
         if (i <= lanes) call bodies%put(i, system, states(i))
      end do
      do k = 1, 50
         call bodies%step()
      end do
      do i = 1, min(6, lanes)
         call check(error, bodies%taken(i), 'taken')
         call compare(bodies, i, 0, system, 0.125_wp, 50, states(i), 'a body spinning about an axis', error)
      end do
   end subroutine special_bodies

   subroutine poisoned_lanes(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: alone, beside
      type(system_t) :: system, bad
      type(state_t) :: state, poison, a, b
      character(len=40) :: place
      integer, parameter :: kinds(9) = [GYROSTAT, TOP, SPINNER, SYMMETRIC_TOP, SKEW_GYROSTAT, SKEW_TOP, SATELLITE, &
                                     CROSSED, SPIN_STABLE]
      logical :: stays
      integer :: case, k, kind
      do case = 1, 63
         kind = kinds(1 + (case - 1)/7)
         call draw(7, 0.5_wp, kind, system, state, error)
         call draw(8, 0.5_wp, kind, bad, poison, error)
         if (allocated(error)) return
         select case (mod(case, 7))
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
         case (6)
            poison%p = 0.0_wp
         case default
            ! As long as no series can follow it, but the first tries to.
            call draw(9, merge(16.0_wp, 40.0_wp, kind >= SATELLITE), kind, bad, poison, error)
         end select
         call alone%set_up(0, 0.5_wp)
         call beside%set_up(0, 0.5_wp)
         call alone%put(lanes, system, state)
         do k = 1, lanes - 1
            call beside%put(k, bad, poison)
         end do
         call beside%put(lanes, system, state)
         call check(error, lanes == 1 .or. (any(beside%taken(:lanes - 1)) .eqv. any(mod(case, 7) == [0, 1, 6])), 'put')
         do k = 1, 200
            call alone%step()
            call beside%step()
         end do
         ! A top can start from rest, and bodies with an axis have a closed solution.
         stays = (mod(case, 7) == 6 .and. all(kind /= [GYROSTAT, SKEW_GYROSTAT])) .or. &
                 (mod(case, 7) == 0 .and. kind == SPINNER)
         write (place, '("case ",i0,": ",l1,1x,i0)') case, alone%taken(lanes), count(beside%taken)
         call check(error, alone%taken(lanes) .and. beside%taken(lanes) .and. &
                    count(beside%taken) == merge(lanes, 1, stays), place)
         call alone%get(lanes, a)
         call beside%get(lanes, b)
         call check(error, agree(a, b), 'a poisoned lane changes another one')
      end do
   end subroutine poisoned_lanes

   !> In the axial frame L turns the rows, however slowly the body turns: squares of their coefficients would leave the
   !> range of numbers, which strict builds do not let pass.
   subroutine fast_rotors(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: bodies
      type(system_t) :: system
      type(state_t) :: state
      integer :: i
      call bodies%set_up(0, 0.5_wp)
      do i = 1, lanes
         call draw(i, 0.1_wp, SYMMETRIC_CROSSED, system, state, error)
         if (allocated(error)) return
         call system%effects%add(rotor_t(name='rotor', momentum=[0.0_wp, 1e12_wp*system%body%moments(1), 0.0_wp]))
         state = make_state(system, state%q, [0.0_wp, 0.1_wp, 0.0_wp])
         call bodies%put(i, system, state)
      end do
      call check(error, all(bodies%taken), 'put')
      call bodies%step()
      call check(error, .not. any(bodies%taken), 'taken')
   end subroutine fast_rotors

   !> The first body says what the equations are, and what is conserved: each kind beside a satellite.
   subroutine unlike_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: alone, beside
      type(system_t) :: system, other
      type(state_t) :: state, start, a, b
      character(len=20) :: place
      integer :: k, kind
      if (lanes == 1) return
      call draw(1, 0.5_wp, SATELLITE, system, state, error)
      if (allocated(error)) return
      do kind = FREE, last_kind + 1
         call draw(2, 0.5_wp, min(kind, last_kind), other, start, error)
         if (allocated(error)) return
         ! After all kinds one with two gradients.
         if (kind > last_kind) call draw(2, 0.5_wp, SATELLITE, other, start, error)
         if (kind > last_kind) call other%effects%add(gravity_gradient_t(other%body, down, 0.1_wp))
         call alone%set_up(0, 0.5_wp)
         call alone%put(1, other, start)
         call check(error, alone%taken(1) .neqv. (kind > last_kind .or. is_free(min(kind, last_kind))), &
                    'the first one')
         call alone%set_up(0, 0.5_wp)
         call alone%put(1, system, state)
         beside = alone
         call beside%put(2, other, start)
         write (place, '("kind ",i0)') kind
         call check(error, alone%taken(1) .and. (beside%taken(2) .eqv. any(kind == [SATELLITE, PLANAR])), place)
         do k = 1, 20
            call alone%step()
            call beside%step()
         end do
         call alone%get(1, a)
         call beside%get(1, b)
         call check(error, agree(a, b), trim(place)//' changes a satellite')
      end do
   end subroutine unlike_bodies

   !> Rates from short steps to far too long ones.
   subroutine long_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: bodies
      type(system_t) :: system
      type(state_t) :: state
      character(len=80) :: place
      integer, parameter :: kinds(7) = [GYROSTAT, TOP, SYMMETRIC_TOP, SKEW_GYROSTAT, SKEW_SATELLITE, CROSSED, &
                                        SPIN_STABLE]
      integer :: i, k, kind, taken(7)
      taken = 0
      do kind = 1, 7
         do i = 1, 60
            call draw(i, 0.4_wp*1.1_wp**i, kinds(kind), system, state, error)
            if (allocated(error)) return
            call bodies%set_up(0, 0.5_wp)
            call bodies%put(1, system, state)
            do k = 1, 50
               call bodies%step()
            end do
            if (.not. bodies%taken(1)) cycle
            taken(kind) = taken(kind) + 1
            write (place, '("long step ",i0," of kind ",i0)') i, kinds(kind)
            call compare(bodies, 1, 0, system, 0.5_wp, 50, state, trim(place), error)
         end do
      end do
      write (place, '("steps are neither taken nor given up: ",7i4)') taken
      call check(error, all(taken > 10) .and. all(taken < 55), place)
   end subroutine long_steps

   !> Gyrostats, and tops, whose momentum about the vertical stays. Shorter than `make bench` runs them.
   subroutine long_run(error)
      type(error_type), allocatable, intent(out) :: error
      type(taylor_lanes_t) :: bodies
      type(system_t) :: systems(lanes)
      type(state_t) :: states(lanes), state
      real(wp) :: change(3), scale
      integer, parameter :: kinds(11) = [GYROSTAT, TOP, SPINNER, SYMMETRIC_TOP, SKEW_GYROSTAT, SPINNING_TOP, SKEW_TOP, &
                                      SKEW_SATELLITE, CROSSED, SPIN_STABLE, SYMMETRIC_CROSSED]
      integer :: i, k, n
      do n = 1, 11
         call bodies%set_up(0, 0.25_wp)
         do i = 1, lanes
            call draw(i, 0.5_wp, kinds(n), systems(i), states(i), error)
            if (allocated(error)) return
            call bodies%put(i, systems(i), states(i))
         end do
         do k = 1, merge(2000, 20000, is_slow_build())
            call bodies%step()
         end do
         call bodies%look()
         do i = 1, lanes
            call check(error, bodies%taken(i), 'taken')
            state = states(i)
            call bodies%get(i, state)
            ! The projection leaves what rounding of an evaluation makes: both ends have it.
            scale = kinetic_energy(systems(i), states(i)) + abs(total_energy(systems(i), states(i))) + &
                    kinetic_energy(systems(i), state)
            call check_below(error, abs(total_energy(systems(i), state) - total_energy(systems(i), states(i))), &
                             32*eps*scale, 'energy')
            change = space_momentum(state) - space_momentum(states(i))
            if (systems(i)%effects%n_potentials > 0) change = dot_product(change, down)*down
            if (any(kinds(n) == [CROSSED, SYMMETRIC_CROSSED])) change = 0.0_wp
            call check_below(error, norm2(change), 16*eps*(norm2(space_momentum(states(i))) &
                                                           + norm2(space_momentum(state))), 'momentum')
            call check_below(error, abs(dot_product(state%q, state%q) - 1), 4*eps, 'norm')
         end do
      end do
   end subroutine long_run

end module test_series_lanes
