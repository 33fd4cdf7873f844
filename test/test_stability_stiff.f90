!> Stiff and soft: springs and damping far faster than the step, and springs where their force vanishes.
module test_stability_stiff
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_kinds, only: wp, long, eps
   use nutate_quaternion, only: rotate_to_space
   use nutate_observer, only: run_record_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, status_t
   use test_problems, only: angular_velocity, kinetic_energy, make_state, new_problem, problem_t, system_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: error_type, new_unittest, one_in, unittest_type
   implicit none
   private

   public :: collect_stability_stiff, stiff_cases

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], e1(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: moments(3) = [1.0_wp, 2.0_wp, 2.5_wp]

   !> Keeps how far body axis 1 went, the fastest rate, and by how much kinetic energy grew in a step.
   type, extends(meter_t) :: motion_meter_t
      !> Largest |R e₁ - e₁|, and largest |Ω|, rad/s.
      real(wp) :: swing = 0.0_wp, rate = 0.0_wp
      !> Kinetic energy of the last row, and its largest growth from row to row, J.
      real(wp) :: kinetic = huge(1.0_wp), growth_of_kinetic = -huge(1.0_wp)
   contains
      procedure :: note => note_motion
   end type motion_meter_t

contains

   subroutine collect_stability_stiff(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a spring of 1e12 N/m holds at any step", stiff_spring_holds), &
                  new_unittest("a spring whose ends meet keeps its energy", meeting_ends_keep_energy), &
                  new_unittest("a spring at rest stays, moved it swings", spring_at_rest_length), &
                  new_unittest("damping that overshoots takes energy", damping_takes_energy)]
   end subroutine collect_stability_stiff

   !> The cases, for `make stress`.
   function stiff_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [spring_case(), meeting_case(), rest_case(), damping_case()]
   end function stiff_cases

   type(stability_case_t) function spring_case() result(item)
      item%name = 'spring of 1e12 N/m'
      item%guards = 'steps of 1/10 to 1e4 of its period, a swing of 2e-7 rad beside a force of 1e11 N: '// &
                    'no convergence, or a motion that blows up'
      item%selected = EVERY_WAY
      item%run => run_spring
   end function spring_case

   type(stability_case_t) function meeting_case() result(item)
      item%name = 'spring of 1e12 N/m whose ends meet'
      item%guards = 'no rest length, ends 1e-7 m apart: a length computed from squares of order one has no digits'// &
                    ' there'
      item%selected = EVERY_WAY
      item%run => run_meeting
   end function meeting_case

   type(stability_case_t) function rest_case() result(item)
      item%name = 'spring at rest length, and with both ends in one point'
      item%guards = 'a force that vanishes, a force without a direction, and a length known to 1e-16 of which '// &
                    '1e-5 matters'
      item%selected = EVERY_WAY
      item%run => run_rest
   end function rest_case

   type(stability_case_t) function damping_case() result(item)
      item%name = 'damping that overshoots'
      item%guards = 'damping by up to 1e10 of the momentum in a step: energy must fall in every step, and the '// &
                    'balance must close'
      item%selected = EVERY_WAY
      item%run => run_damping
   end function damping_case

   subroutine stiff_spring_holds(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, spring_case())
   end subroutine stiff_spring_holds

   subroutine meeting_ends_keep_energy(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, meeting_case())
   end subroutine meeting_ends_keep_energy

   subroutine spring_at_rest_length(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, rest_case())
   end subroutine spring_at_rest_length

   subroutine damping_takes_energy(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, damping_case())
   end subroutine damping_takes_energy

   !> A body with a spring to its point (1, 0, 0).
   function sprung_body(anchor, stiffness, rest_length, omega, turn) result(problem)
      !> m; N/m; m; body axes, rad/s; half the angle about axis 3 at the start, rad.
      real(wp), intent(in) :: anchor(3), stiffness, rest_length, omega(3), turn
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call problem%system%effects%add(spring_t(e1, anchor, stiffness, rest_length))
      problem%start = make_state(problem%system, [cos(turn), 0.0_wp, 0.0_wp, sin(turn)], omega)
   end function sprung_body

   subroutine note_motion(self, system, state, record)
      class(motion_meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      real(wp) :: kinetic
      self%swing = max(self%swing, norm2(rotate_to_space(state%q, e1) - e1))
      self%rate = max(self%rate, norm2(angular_velocity(system, state)))
      kinetic = kinetic_energy(system, state)
      if (record%step > 0) self%growth_of_kinetic = max(self%growth_of_kinetic, kinetic - self%kinetic)
      self%kinetic = kinetic
   end subroutine note_motion

   !> Anchor at 1.2 m, rest length 0.1 m: axis 1 is held with 6e11 N m/rad, which makes periods of 8 and 9 µs.
   subroutine run_spring(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(motion_meter_t) :: meter, blank
      real(wp), parameter :: anchor(3) = [1.2_wp, 0.0_wp, 0.0_wp], omega(3) = [0.1_wp, 0.0_wp, 0.1_wp]
      real(wp), parameter :: steps(5) = [1e-6_wp, 1e-5_wp, 1e-4_wp, 1e-3_wp, 0.1_wp]
      integer(long) :: n
      integer :: i
      n = merge(100000_long, merge(200_long, 500_long, one_in() > 3), whole)
      if (whole .and. way%order > 2) n = 2000
      do i = 1, size(steps)
         meter = blank
         call follow(sprung_body(anchor, 1e12_wp, 0.1_wp, omega, 0.0_wp), way, steps(i), n, record, meter=meter)
         ! Amplitude Ω√(J/6e11), and no energy of more than the start's but for round-off of the 5e9 J.
         call record%require_below(meter%swing, 1.1_wp*0.1_wp*sqrt(2.5_wp/6e11_wp), 'swing of the axis')
         call record%require_below(meter%rate, 1.1_wp*norm2(omega), 'angular velocity')
      end do
      call record%require(record%subdivided_steps == 0, 'a step that suits the motion was subdivided')
      ! Released from 0.04 rad it would run at 9600 rad/s.
      call follow(sprung_body(anchor, 1e12_wp, 0.1_wp, [0.0_wp, 0.0_wp, 0.0_wp], 0.02_wp), way, 1e-3_wp, &
                  merge(200_long, 2_long, whole), record)
      call record%require(.not. record%refused, trim(record%outcome))
      call record%require_invariants(1e-11_wp)
   end subroutine run_spring

   !> V = ½k|x - γ|²: an amplitude d = Ω√(J/k) has digits down to eps/d, which makes an error 4 eps/d of energy a step.
   subroutine run_meeting(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(motion_meter_t) :: meter
      real(wp), parameter :: stiffness = 1e12_wp, omega(3) = [0.1_wp, 0.0_wp, 0.1_wp]
      real(wp) :: amplitude
      integer(long) :: n
      n = merge(100000_long, 1000_long, whole)
      amplitude = 0.1_wp*sqrt(2.5_wp/stiffness)
      call follow(sprung_body(e1, stiffness, 0.0_wp, omega, 0.0_wp), way, 0.01_wp, n, record, meter=meter)
      call record%require(.not. record%refused .and. record%subdivided_steps == 0, trim(record%outcome))
      call record%require_below(meter%swing, 1.1_wp*amplitude, 'swing of the axis')
      call record%require_below(record%energy, 4*eps/amplitude*sqrt(real(n, wp)), 'energy')
      call record%require_below(max(record%momentum, record%norm), 1e-11_wp, 'momentum and norm')
   end subroutine run_meeting

   !> Index of the median of three.
   pure integer function middle_of(values)
      real(wp), intent(in) :: values(3)
      middle_of = 6 - minloc(values, 1) - maxloc(values, 1, back=.true.)
   end function middle_of

   subroutine run_rest(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(motion_meter_t) :: meter, blank
      real(wp), parameter :: aside(3) = [0.0_wp, 1.0_wp, 0.0_wp], at_rest(3) = 0.0_wp
      real(wp), parameter :: slow(3) = [0.0_wp, 0.0_wp, 0.01_wp]
      type(record_t) :: swings(3)
      real(wp) :: amplitude
      integer(long) :: n, earlier
      integer :: i
      n = merge(100000_long, merge(300_long, 1000_long, one_in() > 3), whole)
      call follow(sprung_body(aside, 1e6_wp, sqrt(2.0_wp), at_rest, 0.0_wp), way, 0.01_wp, n, record, meter=meter)
      call record%require_below(meter%swing, 4*eps, 'swing of the spring at its rest length')
      meter = blank
      call follow(sprung_body(e1, 100.0_wp, 0.1_wp, at_rest, 0.0_wp), way, 0.01_wp, n, record, meter=meter)
      call record%require_below(meter%swing, 0.0_wp, 'swing of the spring with its ends in one point')
      meter = blank
      call follow(sprung_body(e1, 100.0_wp, 0.1_wp, slow, 0.0_wp), way, 0.01_wp, n, record, meter=meter)
      call record%require(meter%swing > 0.05_wp, 'the compressed spring did not push')
      call record%require_invariants(1e-11_wp)
      ! ℓ - l₀ = s/√2 for a swing by s, which k/2 and J₃ make 630 rad/s: a step is one period.
      amplitude = 0.01_wp*sqrt(2.5_wp/0.5e6_wp)
      earlier = record%subdivided_steps
      ! The rounding of the length walks at random: of three swings the one in the middle counts.
      do i = 1, 3
         meter = blank
         swings(i) = record
         call follow(sprung_body(aside, 1e6_wp, sqrt(2.0_wp), (1 + 0.01_wp*(i - 2))*slow, 0.0_wp), way, 0.01_wp, n, &
                     swings(i), meter=meter)
         call swings(i)%require_below(meter%swing, (1 + 0.01_wp*(i - 2))*1.1_wp*amplitude, &
                                      'swing about the rest length')
      end do
      record = swings(middle_of(swings%energy))
      call record%require_below(record%energy, 16*eps/amplitude*sqrt(real(n, wp)), 'energy about the rest length')
      call record%require(.not. record%refused, trim(record%outcome))
      if (way%order == 2) &
         call record%require(record%subdivided_steps == earlier, 'a step that suits the motion was subdivided')
   end subroutine run_rest

   function damped_body(coefficient, omega) result(problem)
      !> Body axes, N m s; rad/s.
      real(wp), intent(in) :: coefficient(3), omega(3)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call problem%system%effects%add(damping_t(coefficient))
      problem%start = make_state(problem%system, identity, omega)
   end function damped_body

   subroutine run_damping(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(motion_meter_t) :: meter, blank
      type(problem_t), pointer :: problem
      type(record_t) :: part
      real(wp), parameter :: coefficients(3, 3) = reshape([3e2_wp, 3e2_wp, 3e2_wp, 1e3_wp, 1e4_wp, 1e5_wp, &
                                                           1e12_wp, 1e13_wp, 1e12_wp], [3, 3])
      real(wp), parameter :: omega(3) = [1.0_wp, 2.0_wp, 3.0_wp]
      real(wp) :: energy
      integer :: i
      energy = 0.5_wp*dot_product(moments, omega**2)
      call record%show('of 3 dampings rejected', 0.0_wp)
      do i = 1, size(coefficients, 2)
         problem => damped_body(coefficients(:, i), omega)
         meter = blank
         part = record_t()
         call follow(problem, way, 0.01_wp, merge(10000_long, 100_long, whole), part, meter=meter)
         ! The remaining motion is round-off: its energy is the initial one times the square of round-off.
         call record%require_below(meter%growth_of_kinetic, energy*(16*eps)**2, 'growth of energy')
         ! The backward stages of a composition meet their pole: no part is short enough for the strongest.
         if (i == 3 .and. way%order > 2) then
            call record%require(any(part%code == [NUTATE_OFF_BRANCH, NUTATE_NOT_CONVERGED]), &
                                'a stage beyond its pole passed')
            record%outcome = 'damping by 1e10 of the momentum in a step: '//trim(part%outcome)
            call record%show('of 3 dampings rejected', 1.0_wp)
            part = record_t()
         else
            call record%require(.not. part%refused, trim(part%outcome))
            if (i < 3) call record%require(meter%kinetic < 0.4_wp*energy, 'energy stayed')
         end if
         call record%absorb(part)
      end do
      call record%require_invariants(3e-12_wp)
   end subroutine run_damping

end module test_stability_stiff
