!> Helpers that the suites of events share: quantities, an observer that keeps the events of a run, a compass needle.
module test_event_support
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_effect_list, only: effect_list_t
   use nutate_event, only: event_t
   use nutate_kinds, only: wp, long, pi
   use nutate_motion, only: motion_t
   use nutate_observer, only: observer_t, run_record_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: make_state, new_problem, problem_t, system_t, total_energy
   implicit none
   private

   public :: rate_event_t, tilt_event_t, angle_event_t, lost_event_t, keeper_t, compass, no_effects

   !> Most events and rows that a test keeps.
   integer, parameter :: room = 200, most_rows = 5000

   !> Ω of an axis, body axes, with its rate in closed form.
   type, extends(event_t) :: rate_event_t
      integer :: axis = 3
   contains
      procedure :: value => rate_of_axis
      procedure :: rate => acceleration_of_axis
   end type rate_event_t

   !> cos θ of axis 3, by differences.
   type, extends(event_t) :: tilt_event_t
   contains
      procedure :: value => cosine_of_tilt
   end type tilt_event_t

   !> Ω3 while it is above a value, and no number below.
   type, extends(event_t) :: lost_event_t
      !> rad/s.
      real(wp) :: least = 0.0_wp
   contains
      procedure :: value => rate_or_none
   end type lost_event_t

   !> The angle about axis 3, ±π.
   type, extends(event_t) :: angle_event_t
      !> Weight of Ω3 beside it, s.
      real(wp) :: lead = 0.0_wp
   contains
      procedure :: value => angle_and_rate
   end type angle_event_t

   !> Keeps what it is shown.
   type, extends(observer_t) :: keeper_t
      integer :: n = 0, rows = 0
      real(wp) :: times(room) = 0.0_wp
      integer :: which(room) = 0
      integer(long) :: numbers(room) = 0
      real(wp) :: energies(room) = 0.0_wp, works(room) = 0.0_wp
      !> States of the rows, and room for more; shape (0:any).
      type(state_t), allocatable :: states(:)
      real(wp) :: last_work = 0.0_wp
   contains
      procedure :: observe => keep_row
      procedure :: observe_event => keep_event
   end type keeper_t

contains

   pure real(wp) function rate_of_axis(self, system, motion) result(g)
      class(rate_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      g = motion%omega(self%axis)
   end function rate_of_axis

   pure real(wp) function acceleration_of_axis(self, system, motion) result(rate)
      class(rate_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      rate = motion%acceleration(self%axis)
   end function acceleration_of_axis

   pure real(wp) function cosine_of_tilt(self, system, motion) result(g)
      class(tilt_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      associate (q => motion%state%q)
         g = (q(1)**2 - q(2)**2 - q(3)**2 + q(4)**2)/dot_product(q, q)
      end associate
   end function cosine_of_tilt

   pure real(wp) function rate_or_none(self, system, motion) result(g)
      class(lost_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      g = motion%omega(3)
      if (g < self%least) g = ieee_value(g, ieee_quiet_nan)
   end function rate_or_none

   pure real(wp) function angle_and_rate(self, system, motion) result(g)
      class(angle_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      g = 2*atan2(motion%state%q(4), motion%state%q(1)) + self%lead*motion%omega(3)
   end function angle_and_rate

   subroutine keep_row(self, system, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      type(state_t), allocatable :: longer(:)
      if (.not. allocated(self%states)) allocate (self%states(0:127))
      if (self%rows > ubound(self%states, 1) .and. self%rows < most_rows) then
         allocate (longer(0:2*self%rows - 1))
         longer(:self%rows - 1) = self%states
         call move_alloc(longer, self%states)
      end if
      self%states(min(self%rows, ubound(self%states, 1))) = state
      self%rows = self%rows + 1
      self%last_work = record%work
   end subroutine keep_row

   subroutine keep_event(self, system, event, which, number, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      self%n = min(self%n + 1, room)
      self%times(self%n) = state%t
      self%which(self%n) = which
      self%numbers(self%n) = number
      self%energies(self%n) = total_energy(system, state)
      self%works(self%n) = record%work
   end subroutine keep_event

   !> A needle about axis 3 of the body, released at 150 degrees: ω0 = 2.378804133800210347603.
   function compass() result(problem)
      type(problem_t), pointer :: problem
      real(wp), parameter :: omega0 = 2.378804133800210347603_wp
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(dipole_t([omega0**2, 0.0_wp, 0.0_wp], [1.0_wp, 0.0_wp, 0.0_wp]))
      problem%start = make_state(problem%system, [cos(75*pi/180), 0.0_wp, 0.0_wp, sin(75*pi/180)], &
                                 [0.0_wp, 0.0_wp, 0.0_wp])
   end function compass

   !> No effects.
   function no_effects() result(effects)
      type(effect_list_t) :: effects
   end function no_effects

end module test_event_support
