!> Unstable axes, and bodies at the edge of what a body can be.
module test_stability_axes
   use nutate_body, only: diagonal, make_body
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: angular_velocity, box, make_state, new_problem, problem_t, system_t
   use test_stability_case, only: check_case, EVERY_WAY, number_text, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_axes, axis_cases

   !> Invariants over the shortened and the whole runs.
   real(wp), parameter :: bound = 3e-13_wp
   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   !> Watches how fast the body leaves axis 3, the unstable one.
   type, extends(meter_t) :: axis_meter_t
      !> |(Ω1, Ω2)|/|Ω| first above the one and the other of these.
      real(wp) :: low = 1e-6_wp, high = 1e-3_wp
      !> Times at which these tilts were reached, s; negative: not yet.
      real(wp) :: at_low = -1.0_wp, at_high = -1.0_wp
      real(wp) :: tilt_low = 0.0_wp, tilt_high = 0.0_wp
      !> Largest so far.
      real(wp) :: most = 0.0_wp
   contains
      procedure :: note => note_tilt
   end type axis_meter_t

contains

   subroutine collect_stability_axes(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("exactly on the unstable axis the box stays", box_stays_on_its_axis), &
                  new_unittest("off the unstable axis it leaves at the right rate", box_leaves_at_the_right_rate), &
                  new_unittest("the separatrix is kept to its energy", separatrix_is_kept), &
                  new_unittest("bodies with moments that coincide or add up", degenerate_bodies_are_kept), &
                  new_unittest("a needle is kept or refused", needle_is_kept_or_refused)]
   end subroutine collect_stability_axes

   !> The cases of this group.
   function axis_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [on_axis_case(), off_axis_case(), separatrix_case(), degenerate_case(), needle_case()]
   end function axis_cases

   type(stability_case_t) function on_axis_case() result(item)
      item%name = 'box exactly on its intermediate axis'
      item%guards = 'the scheme itself pushes a body off an unstable equilibrium'
      item%selected = EVERY_WAY
      item%run => run_on_axis
   end function on_axis_case

   type(stability_case_t) function off_axis_case() result(item)
      item%name = 'box 1e-300, 1e-16 and 1e-8 off its intermediate axis'
      item%guards = 'a wrong growth rate; noise in place of a small perturbation; products that underflow'
      item%selected = EVERY_WAY
      item%run => run_off_axis
   end function off_axis_case

   type(stability_case_t) function separatrix_case() result(item)
      item%name = 'separatrix of the box'
      item%guards = 'energy errors near the saddle put the motion on the wrong side'
      item%selected = EVERY_WAY
      item%run => run_separatrix
   end function separatrix_case

   type(stability_case_t) function degenerate_case() result(item)
      item%name = 'sphere, symmetric and nearly symmetric body, plate'
      item%guards = 'divisions by differences of moments'
      item%selected = EVERY_WAY
      item%run => run_degenerate
   end function degenerate_case

   type(stability_case_t) function needle_case() result(item)
      item%name = 'needle, J3/J1 = 1e-12'
      item%guards = 'moments twelve decades apart; where p cannot resolve the spin about the needle, a rejection'
      item%selected = EVERY_WAY
      item%run => run_needle
   end function needle_case

   subroutine box_stays_on_its_axis(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, on_axis_case())
   end subroutine box_stays_on_its_axis

   subroutine box_leaves_at_the_right_rate(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, off_axis_case())
   end subroutine box_leaves_at_the_right_rate

   subroutine separatrix_is_kept(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, separatrix_case())
   end subroutine separatrix_is_kept

   subroutine degenerate_bodies_are_kept(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, degenerate_case())
   end subroutine degenerate_bodies_are_kept

   subroutine needle_is_kept_or_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, needle_case())
   end subroutine needle_is_kept_or_refused

   !> The growth of the tilt, row by row.
   subroutine note_tilt(self, system, state, record)
      class(axis_meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      real(wp) :: omega(3), tilt
      omega = angular_velocity(system, state)
      tilt = norm2(omega(1:2))/norm2(omega)
      self%most = max(self%most, tilt)
      if (record%step == 0) return
      if (self%at_low < 0.0_wp .and. tilt > self%low) then
         self%at_low = state%t
         self%tilt_low = tilt
      end if
      if (self%at_high < 0.0_wp .and. tilt > self%high) then
         self%at_high = state%t
         self%tilt_high = tilt
      end if
   end subroutine note_tilt

   !> Rate at which the scheme of order 2 leaves axis 3 at a step, 1/s. With w = ½Δt/(1-|b|²) the step is the midpoint
   !> rule of Euler's equations of the length 2w, which multiplies by (1+λw)/(1-λw).
   pure real(wp) function scheme_rate(moments, omega, dt) result(rate)
      real(wp), intent(in) :: moments(3), omega, dt
      real(wp) :: growth, w
      growth = omega*sqrt((moments(3) - moments(1))*(moments(2) - moments(3))/(moments(1)*moments(2)))
      w = 0.5_wp*dt/(1 - (0.25_wp*dt*omega)**2)
      rate = log((1 + growth*w)/(1 - growth*w))/dt
   end function scheme_rate

   !> The axis is an equilibrium of the arithmetic too, as long as nothing is mixed into the other components.
   subroutine run_on_axis(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(axis_meter_t) :: meter
      problem => box()
      problem%start = make_state(problem%system, identity, [0.0_wp, 0.0_wp, 10.0_wp])
      call follow(problem, way, 0.01_wp, merge(100000_long, 500_long, whole), record, meter=meter)
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(bound)
      if (meter%at_high < 0.0_wp) then
         call record%show('tilt, rad', meter%most)
      else
         call assess_rate(problem, meter, 10.0_wp, 0.01_wp, way, record)
      end if
   end subroutine run_on_axis

   !> A small perturbation grows at the rate of the linearised scheme, or, from 1e-300, at least never faster.
   subroutine run_off_axis(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: sizes(3) = [1e-300_wp, 1e-16_wp, 1e-8_wp]
      real(wp), parameter :: dt = 0.05_wp
      type(problem_t), pointer :: problem
      type(axis_meter_t) :: meter, blank
      real(wp) :: rate, earliest
      integer :: i
      problem => box()
      rate = scheme_rate(problem%system%body%moments, 10.0_wp, dt)
      do i = 1, 3
         meter = blank
         problem%start = make_state(problem%system, identity, [sizes(i), 0.0_wp, 10.0_wp])
         call follow(problem, way, dt, merge(20000_long, merge(3000_long, 500_long, i == 1), whole), record, &
                     meter=meter)
         call record%require(.not. record%refused, trim(record%outcome))
         call record%require(meter%at_high > 0.0_wp, number_text(sizes(i))//' did not grow')
         call assess_rate(problem, meter, 10.0_wp, dt, way, record)
         ! The time is not before the perturbation, or round-off, can have grown as far; for 1e-8 not later either.
         earliest = log(meter%low/max(sizes(i), 1e-15_wp))/rate - 1
         call record%require(meter%at_low > earliest, number_text(sizes(i))//' grew too fast')
         if (i == 3) call record%require(meter%at_low < earliest + 2, '1e-8 grew too slowly')
      end do
      call record%require_invariants(bound)
   end subroutine run_off_axis

   !> Compares the growth between two tilts with the linearised scheme; order 8 with the exact rate.
   subroutine assess_rate(problem, meter, omega, dt, way, record)
      type(problem_t), intent(in) :: problem
      type(axis_meter_t), intent(in) :: meter
      real(wp), intent(in) :: omega, dt
      type(way_t), intent(in) :: way
      type(record_t), intent(inout) :: record
      real(wp) :: measured, expected
      measured = log(meter%tilt_high/meter%tilt_low)/(meter%at_high - meter%at_low)
      expected = scheme_rate(problem%system%body%moments, omega, dt)
      if (way%order == 8) expected = scheme_rate(problem%system%body%moments, omega, 1e-6_wp)
      call record%show('relative error of the growth rate', measured/expected - 1)
      call record%require_below(abs(measured/expected - 1), 2e-3_wp, 'error of the growth rate')
   end subroutine assess_rate

   !> A start on the separatrix, L²= 2TJ3, far from the saddle.
   subroutine run_separatrix(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      real(wp) :: ratio
      problem => box()
      associate (j => problem%system%body%moments)
         ratio = sqrt(j(1)*(j(3) - j(1))/(j(2)*(j(2) - j(3))))
      end associate
      problem%start = make_state(problem%system, identity, [5.0_wp, 5*ratio, 0.0_wp])
      call follow(problem, way, 0.02_wp, merge(100000_long, 1000_long, whole), record)
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(bound)
   end subroutine run_separatrix

   !> Runs each shape with a spin about an arbitrary axis.
   subroutine run_degenerate(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: moments(3, 4) = reshape([ &
         2.0_wp, 2.0_wp, 2.0_wp, &
         1.0_wp, 1.0_wp, 1.5_wp, &
         1.0_wp, 1.0_wp + 1e-15_wp, 1.5_wp, &
         1.0_wp, 2.0_wp, 3.0_wp], [3, 4])
      type(problem_t), pointer :: blank
      type(problem_t) :: problem
      type(status_t) :: status
      integer :: i
      blank => new_problem()
      do i = 1, size(moments, 2)
         problem = blank
         call make_body(diagonal(moments(:, i)), problem%system%body, status)
         call record%require(status%ok(), trim(status%message))
         if (.not. status%ok()) return
         problem%start = make_state(problem%system, identity, [1.0_wp, -2.0_wp, 3.0_wp])
         call follow(problem, way, 0.1_wp, merge(100000_long, 300_long, whole), record)
         call record%require(.not. record%refused, trim(record%outcome))
      end do
      call record%require_invariants(bound)
   end subroutine run_degenerate

   !> The spin about the needle's axis is 1e-12 of the momentum, four digits of it: the eight equations, which work with
   !> the momentum, may refuse; three equations in the turn do not.
   subroutine run_needle(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 1e-12_wp]), problem%system%body, status)
      call record%require(status%ok(), trim(status%message))
      if (.not. status%ok()) return
      problem%start = make_state(problem%system, identity, [1.0_wp, -2.0_wp, 3.0_wp])
      call follow(problem, way, 0.1_wp, merge(100000_long, 300_long, whole), record)
      call record%require(way%solver == 'full' .or. .not. record%refused, trim(record%outcome))
      call record%require_invariants(bound)
   end subroutine run_needle

end module test_stability_axes
