!> The top where it is delicate: asleep, at the poles of Euler's angles, on the separatrix, at rest, and at the limits
!> of spin and gravity.
module test_stability_top
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_body, only: diagonal, make_body
   use nutate_columns, only: columns_t
   use nutate_exact_top, only: lagrange_top_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp, long, pi, eps
   use nutate_quaternion, only: attitude_distance
   use nutate_observer, only: run_record_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_steady_top, only: sleeping_spin
   use test_problems, only: body_momentum, make_state, new_problem, new_system, problem_t, system_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_top, top_cases

   !> Moments across and along the axis, kg m²; m g l under standard gravity, N m.
   real(wp), parameter :: j1 = 1.0_wp, j3 = 0.25_wp, mgl = 9.81_wp
   !> Rate at which the upright top without spin falls, 1/s.
   real(wp), parameter :: fall_rate = sqrt(mgl/j1)

   !> Keeps the tilt at two times, its bounds, and how far Euler's angles jumped.
   type, extends(meter_t) :: tilt_meter_t
      !> Rows at which the tilt is kept, and the tilts, rad.
      integer(long) :: marks(2) = -1_long
      real(wp) :: tilts(2) = 0.0_wp
      real(wp) :: least = pi, most = 0.0_wp
      !> Rows below and above the horizontal that followed one on the other side.
      integer(long) :: crossings = 0
      logical :: above = .true.
      !> Euler's angles as the columns have them, rad, and largest jump of what is defined of them over the turn of a
      !> step: of θ, and of φ+ψ where the axis points up, of φ-ψ where it points down.
      type(columns_t) :: columns
      real(wp) :: angles(3) = 0.0_wp, jump = 0.0_wp
      !> s
      real(wp) :: t = 0.0_wp
   contains
      procedure :: note => note_tilt
      procedure :: observe_step => watch_angles
   end type tilt_meter_t

contains

   subroutine collect_stability_top(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("an upright top sleeps or leaves at its rate", sleeping_top_sleeps_or_leaves), &
                  new_unittest("a swing through both poles keeps its angles", swing_through_poles), &
                  new_unittest("both sides of the separatrix are right", separatrix_has_two_sides), &
                  new_unittest("a start at rest stays or falls", start_at_rest), &
                  new_unittest("a top at 1e6 rad/s precesses", fastest_spin), &
                  new_unittest("no gravity, negative gravity, 1e6 g", every_gravity)]
   end subroutine collect_stability_top

   !> The cases, for `make stress`.
   function top_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [sleeping_case(), rate_case(), poles_case(), separatrix_case(), rest_case(), spin_case(), gravity_case()]
   end function top_cases

   type(stability_case_t) function sleeping_case() result(item)
      item%name = 'sleeping top, exactly upright'
      item%guards = 'an unstable equilibrium left because of round-off, a stable one that is disturbed; a tilt of '// &
                    '1e-300 that is lost'
      item%selected = EVERY_WAY
      item%run => run_sleeping
   end function sleeping_case

   type(stability_case_t) function rate_case() result(item)
      item%name = 'sleeping top below and above the critical spin'
      item%guards = 'a tilt of 1e-10 must grow at the rate of the linear theory, to the order of the scheme, or stay'
      item%selected = EVERY_WAY
      item%run => run_rate
   end function rate_case

   type(stability_case_t) function poles_case() result(item)
      item%name = 'top through both poles'
      item%guards = 'the axis swings exactly through both poles: Euler angles must stay finite, those that are '// &
                    'defined continuous'
      item%selected = EVERY_WAY
      item%run => run_poles
   end function poles_case

   type(stability_case_t) function separatrix_case() result(item)
      item%name = 'pendulum at its separatrix'
      item%guards = 'a pendulum thrown 1e-3 too slowly must turn back, 1e-3 too fast go over; exactly at the '// &
                    'limit it must not stay upright for ever'
      item%selected = EVERY_WAY
      item%run => run_separatrix
   end function separatrix_case

   type(stability_case_t) function rest_case() result(item)
      item%name = 'top at rest'
      item%guards = 'exactly upright or hanging it stays, tilted by 1e-300 or 1 rad it falls; momentum grows '// &
                    'through 300 decades'
      item%selected = EVERY_WAY
      item%run => run_rest
   end function rest_case

   type(stability_case_t) function spin_case() result(item)
      item%name = 'top at 1e6 rad/s'
      item%guards = 'a nutation of 1e-10 rad with a spin of 1 rad per step; steps of 1000 rad, which must be '// &
                    'subdivided'
      item%selected = EVERY_WAY
      item%run => run_spin
   end function spin_case

   type(stability_case_t) function gravity_case() result(item)
      item%name = 'top without gravity, under negative gravity, under 1e6 g'
      item%guards = 'a wrong sign or scale of the potential: the motion must be that of the closed solution'
      item%selected = EVERY_WAY
      item%run => run_gravity
   end function gravity_case

   subroutine sleeping_top_sleeps_or_leaves(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, sleeping_case())
      call check_case(error, rate_case())
   end subroutine sleeping_top_sleeps_or_leaves

   subroutine swing_through_poles(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, poles_case())
   end subroutine swing_through_poles

   subroutine separatrix_has_two_sides(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, separatrix_case())
   end subroutine separatrix_has_two_sides

   subroutine start_at_rest(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, rest_case())
   end subroutine start_at_rest

   subroutine fastest_spin(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, spin_case())
   end subroutine fastest_spin

   subroutine every_gravity(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, gravity_case())
   end subroutine every_gravity

   !> The top with its axis at an angle about space axis 1 from the vertical.
   function tilted_top(tilt, omega, gravity) result(problem)
      !> rad; body axes, rad/s; m/s².
      real(wp), intent(in) :: tilt, omega(3)
      real(wp), intent(in), optional :: gravity
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: g
      problem => new_problem()
      g = mgl
      if (present(gravity)) g = gravity
      call make_body(diagonal([j1, j1, j3]), problem%system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -g]))
      problem%start = make_state(problem%system, [cos(tilt/2), sin(tilt/2), 0.0_wp, 0.0_wp], omega)
   end function tilted_top

   !> Angle of body axis 3 from the vertical, rad.
   pure real(wp) function tilt_of(q)
      real(wp), intent(in) :: q(4)
      tilt_of = 2*atan2(hypot(q(2), q(3)), hypot(q(1), q(4)))
   end function tilt_of

   subroutine note_tilt(self, system, state, record)
      class(tilt_meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t) :: status
      real(wp) :: tilt, values(4)
      tilt = tilt_of(state%q)
      where (self%marks == record%step) self%tilts = tilt
      self%least = min(self%least, tilt)
      self%most = max(self%most, tilt)
      if (self%above .neqv. tilt < 0.5_wp*pi) self%crossings = self%crossings + 1
      self%above = tilt < 0.5_wp*pi
      if (record%step > 0) return
      self%observes_every_step = .true.
      call self%columns%choose(['euler'], status)
      call self%columns%start(system, state, self%inverse_j0)
      call self%columns%evaluate(system, state, record, values)
      self%angles = values(2:4)
      self%t = state%t
   end subroutine note_tilt

   !> Measures the rotation of the angles of the columns in a step, relative to that of the fastest rotation so far,
   !> |Ω|Δt: θ by |Ω|Δt, φ+ψ and φ-ψ each in its half of the sphere by twice that.
   subroutine watch_angles(self, state)
      class(tilt_meter_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      type(system_t), pointer :: none
      type(run_record_t) :: record
      real(wp) :: values(4), change(3), turn
      none => new_system()
      call self%columns%follow(state)
      call self%columns%evaluate(none, state, record, values)
      change = values(2:4) - self%angles
      turn = self%invariants%momentum_scale/j3*abs(state%t - self%t)
      if (turn > 1e-9_wp) then
         self%jump = max(self%jump, abs(change(2))/turn)
         if (max(values(3), self%angles(2)) < 0.5_wp*pi) self%jump = max(self%jump, abs(change(1) + change(3))/(2*turn))
         if (min(values(3), self%angles(2)) > 0.5_wp*pi) self%jump = max(self%jump, abs(change(1) - change(3))/(2*turn))
      end if
      if (.not. all(ieee_is_finite(values))) self%jump = huge(1.0_wp)
      self%angles = values(2:4)
      self%t = state%t
   end subroutine watch_angles

   subroutine run_sleeping(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter, blank
      real(wp), parameter :: spins(2) = [0.95_wp, 1.05_wp], tilts(2) = [0.0_wp, 1e-300_wp]
      integer(long) :: n
      integer :: i, k
      n = merge(100000_long, 1000_long, whole)
      do k = 1, size(tilts)
         do i = 1, size(spins)
            meter = blank
            ! The slow one would leave from 1e-300 after 700 times its time, 1 s.
            call follow(tilted_top(tilts(k), spins(i)*[0.0_wp, 0.0_wp, sleeping_spin(j1, j3, mgl)]), way, 0.01_wp, &
                        merge(n, min(n, 20000_long), tilts(k) <= 0.0_wp .or. i == 2), record, meter=meter)
            call record%require(.not. record%refused, trim(record%outcome))
            if (tilts(k) <= 0.0_wp) then
               call record%require_below(meter%most, 0.0_wp, 'tilt of the upright top')
            else
               call record%require(meter%least > 0.0_wp, 'a tilt of 1e-300 was lost')
               if (i == 1) call record%require(meter%most > 1e-298_wp, 'below the critical spin the top stood still')
               if (i == 2) call record%require_below(meter%most, 4e-300_wp, 'tilt above the critical spin')
            end if
         end do
      end do
      call record%require_invariants(1e-12_wp)
   end subroutine run_sleeping

   !> Below the critical spin, at f times it, small tilts grow as exp(λt), λ² = (1 - f²) m g l/J₁; above it they are
   !> multiplied by at most f/√(f² - 1).
   subroutine run_rate(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter, blank
      real(wp), parameter :: below = 0.8_wp, above = 1.05_wp, tilt = 1e-10_wp
      real(wp) :: error(2), dt, critical
      integer :: i
      critical = sleeping_spin(j1, j3, mgl)
      do i = 1, 2
         dt = 0.01_wp/i
         meter = blank
         meter%marks = [500_long*i, 800_long*i]
         call follow(tilted_top(tilt, [0.0_wp, 0.0_wp, below*critical]), way, dt, 800_long*i, record, meter=meter)
         error(i) = log(meter%tilts(2)/meter%tilts(1))/3.0_wp - fall_rate*sqrt(1 - below**2)
      end do
      if (way%order == 2) then
         call record%require_below(abs(error(1)), (0.01_wp*critical)**2, 'error of the growth rate')
         call record%require_below(abs(error(1)/error(2) - 4), 0.1_wp, 'halving the step, the error of the rate')
      else
         call record%require_below(maxval(abs(error)), 1e-5_wp, 'error of the growth rate')
      end if
      meter = blank
      call follow(tilted_top(tilt, [0.0_wp, 0.0_wp, above*critical]), way, 0.01_wp, &
                  merge(1000000_long, 3000_long, whole), record, meter=meter)
      call record%require_below(meter%most, 1.1_wp*tilt*above/sqrt(above**2 - 1), 'tilt above the critical spin')
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-12_wp)
      call record%show('error of the growth rate, 1/s', error(1))
   end subroutine run_rate

   subroutine run_poles(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter, blank
      ! Straight through both poles, and past them at 1e-9 rad and at some 0.05 rad by a little spin.
      real(wp), parameter :: spins(3) = [0.0_wp, 1e-8_wp, 0.5_wp]
      integer :: i
      real(wp) :: jump
      jump = 0.0_wp
      do i = 1, size(spins)
         meter = blank
         call follow(tilted_top(pi/3, [2.2_wp*fall_rate, 0.0_wp, spins(i)]), way, 0.003_wp, &
                     merge(300000_long, 1500_long, whole), record, meter=meter)
         call record%require(meter%least < 0.05_wp .and. meter%most > pi - 0.05_wp, 'the poles were not reached')
         jump = max(jump, meter%jump)
      end do
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_below(jump, 1.0_wp + 1e-6_wp, 'jump of the Euler angles over what the rotation allows')
      call record%require_invariants(1e-12_wp)
      call record%show('jump over what the rotation allows', jump)
   end subroutine run_poles

   subroutine run_separatrix(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter, blank
      real(wp), parameter :: factors(3) = [1 - 1e-3_wp, 1 + 1e-3_wp, 1.0_wp]
      integer(long) :: n, crossings(3)
      integer :: i
      n = merge(1000000_long, 10000_long, whole)
      do i = 1, size(factors)
         meter = blank
         meter%above = .false.
         call follow(tilted_top(pi, [2*factors(i)*fall_rate, 0.0_wp, 0.0_wp]), way, 0.01_wp, n, record, meter=meter)
         crossings(i) = meter%crossings
         ! Energy decides how near it comes: cos θ/2 = f at the turning point.
         if (i == 1) call record%require(meter%least >= 2*acos(factors(1))*(1 - 1e-9_wp), 'too slow, it went over')
         if (i == 2) call record%require(meter%least < 0.001_wp*fall_rate*4, 'too fast, it turned back')
         call record%require(meter%crossings >= 4, 'the pendulum stayed upright')
      end do
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-12_wp)
      call record%show('passages of the horizontal at the limit', real(crossings(3), wp))
   end subroutine run_separatrix

   subroutine run_rest(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter, blank
      real(wp), parameter :: dt = 0.01_wp, at_rest(3) = 0.0_wp
      real(wp) :: rate
      integer(long) :: n
      n = merge(100000_long, 1000_long, whole)
      meter = blank
      call follow(tilted_top(0.0_wp, at_rest), way, dt, n, record, meter=meter)
      call record%require_below(meter%most, 0.0_wp, 'tilt of the upright top')
      meter = blank
      call follow(tilted_top(pi, at_rest), way, dt, n, record, meter=meter)
      call record%require_below(pi - meter%least, 16*eps, 'tilt of the hanging top')
      meter = blank
      meter%marks = [1_long, 1_long]
      call follow(tilted_top(1.0_wp, at_rest), way, dt, n, record, meter=meter)
      call record%require_below(abs(meter%tilts(1) - 1 - 0.5_wp*(fall_rate*dt)**2*sin(1.0_wp)), (fall_rate*dt)**4, &
                                'tilt after the first step')
      call record%require(meter%most > pi - fall_rate*2*dt .and. meter%crossings > 2, 'the tilted top did not swing')
      ! The tilt goes from 1e-300 to some 1e-164, or through all decades and down.
      n = merge(100000_long, 10000_long, whole)
      meter = blank
      meter%marks = [1000_long, 10000_long]
      call follow(tilted_top(1e-300_wp, at_rest), way, dt, n, record, meter=meter)
      rate = log(meter%tilts(2)/meter%tilts(1))/90.0_wp
      call record%require_below(abs(rate - fall_rate), merge((fall_rate*dt)**2, 1e-6_wp, way%order == 2), &
                                'error of the rate of the fall')
      if (whole) call record%require(meter%crossings > 10, 'the top did not fall from 1e-300 rad')
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-12_wp)
      call record%show('error of the rate of the fall, 1/s', rate - fall_rate)
   end subroutine run_rest

   !> The axis of a fast top stays within 2 m g l J₁ sin θ/(J₃Ω₃)² of its tilt.
   subroutine run_spin(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(tilt_meter_t) :: meter
      type(problem_t), pointer :: problem
      real(wp), parameter :: tilt = 0.5_wp, spin = 1e6_wp
      integer(long) :: earlier
      real(wp) :: nutation
      problem => tilted_top(tilt, [0.0_wp, 0.0_wp, spin])
      nutation = 2*mgl*j1*sin(tilt)/(j3*spin)**2
      call follow(problem, way, 1e-6_wp, merge(1000000_long, 3000_long, whole), record, meter=meter)
      call record%require_below(max(meter%most - tilt, tilt - meter%least), 2*nutation + 1e-13_wp, 'nutation')
      earlier = record%subdivided_steps
      call record%require(earlier == 0, 'steps of 1 rad were subdivided')
      call follow(problem, way, 1e-3_wp, merge(100_long, 2_long, whole), record)
      call record%require(record%subdivided_steps - earlier == merge(100_long, 2_long, whole), &
                          'steps of 1000 rad were not subdivided')
      call record%require(.not. record%refused, trim(record%outcome))
      ! The parts of subdivided steps of 1000 rad turn by 3.9 rad, close to the end of the branch, where a root has
      ! lost a digit: 4e-17 in each of 25 600.
      call record%require_invariants(merge(5e-12_wp, 1e-12_wp, whole))
   end subroutine run_spin

   !> Compares with the closed solution; gravity and time in proportion, so that one step suits all.
   subroutine run_gravity(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: gravities(4) = [0.0_wp, -mgl, mgl, 1e6_wp*mgl]
      real(wp), parameter :: units(4) = [1.0_wp, 1.0_wp, 1.0_wp, 1e-3_wp]
      real(wp) :: coarse, fine, worst
      integer :: i
      integer(long) :: earlier
      worst = 0.0_wp
      do i = 1, size(gravities)
         call compare(way, gravities(i), units(i), 0.005_wp, 400_long, record, coarse)
         call compare(way, gravities(i), units(i), 0.0025_wp, 800_long, record, fine)
         worst = max(worst, coarse)
         if (way%order == 2) then
            call record%require_below(abs(coarse/fine - 4), 0.05_wp, 'halving the step, the error of the attitude')
            call record%require_below(coarse, 5e-3_wp, 'attitude')
         else
            call record%require_below(max(coarse, fine), 1e-11_wp, 'attitude')
         end if
      end do
      call record%require(record%subdivided_steps == 0 .and. .not. record%refused, 'a short step was subdivided')
      ! Steps of 30 rad: to be subdivided.
      earlier = record%subdivided_steps
      call follow(tilted_top(1.0_wp, [1.0_wp, 0.0_wp, 3.0_wp], 1e6_wp*mgl), way, 0.01_wp, &
                  merge(1000_long, 10_long, whole), record)
      call record%require(record%subdivided_steps > earlier .and. .not. record%refused, trim(record%outcome))
      call record%require_invariants(3e-12_wp)
      call record%show('attitude error, rad', worst)
   end subroutine run_gravity

   !> Distance from the closed solution after n steps of some units of time.
   subroutine compare(way, gravity, unit, dt, n, record, distance)
      type(way_t), intent(in) :: way
      !> m/s², s, in the unit.
      real(wp), intent(in) :: gravity, unit, dt
      integer(long), intent(in) :: n
      type(record_t), intent(inout) :: record
      !> rad
      real(wp), intent(out) :: distance
      type(problem_t), pointer :: problem
      type(lagrange_top_t) :: exact
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      problem => tilted_top(1.0_wp, [1.0_wp, 0.0_wp, 3.0_wp]/unit, gravity)
      call follow(problem, way, dt*unit, n, record, state=state)
      call exact%prepare(j1, j3, gravity, problem%start%q, body_momentum(problem%start), status)
      call exact%evaluate(state%t, q, momentum)
      distance = attitude_distance(state%q, q)
   end subroutine compare

end module test_stability_top
