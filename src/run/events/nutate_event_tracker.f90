!> The events of a run and the data kept of each from step to step: on which side of zero its function is, how often it
!> has happened, and when.
module nutate_event_tracker
   use nutate_archive, only: archive_t
   use nutate_event, only: event_t, most_parts, part_t
   use nutate_event_list, only: event_list_t
   use nutate_event_roots, only: node_t
   use nutate_kinds, only: wp, long
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: motion_bounds_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: event_tracker_t, watched_t, bring_near, check_parts

   !> Steps in which the variation of a function is not known yet.
   integer, parameter :: young = 32

   !> Largest number of steps for which one test excludes events: so few that the energy gained in them by a motion that
   !> does not conserve it exactly is within the margins.
   integer, parameter :: most_asleep = 1024

   !> Largest numbers of positions in a step, and of values of families, that are stored: the search for each event
   !> evaluates the same few.
   integer, parameter :: most_places = 64, most_recalled = 64

   !> Motion at a position in the step that is searched.
   type, private :: place_t
      !> Position, in steps.
      real(wp) :: s = 0.0_wp
      type(motion_t) :: motion = motion_t()
   end type place_t

   !> Values and rates of a family of quantities at a motion; the family is 0 in a slot that is empty.
   type, private :: recalled_t
      integer :: family = 0
      type(motion_t) :: motion = motion_t()
      real(wp) :: values(3) = 0.0_wp, rates(3) = 0.0_wp
   end type recalled_t

   !> One event under way.
   type :: watched_t
      class(event_t), allocatable :: event
      !> Number of times the event has happened.
      integer(long) :: number = 0
      !> First and last time of the event, s.
      real(wp) :: first_time = 0.0_wp, last_time = 0.0_wp
      !> Derivative of the last time by each sensitivity, s a unit of the sensitivity's parameter; shape (n). Not
      !> allocated: the time has no derivative, or there are no sensitivities.
      real(wp), allocatable :: time_change(:)
      !> Largest last increment of an iteration for a time, s.
      real(wp) :: worst = 0.0_wp
      !> Side of zero at the end of the last step, 1 or -1; 0: not known. With a period, and if the side is known, the
      !> function is between `cell` and `cell` + 1 periods; the last event was at `at` periods.
      integer :: side = 0
      real(wp) :: cell = 0.0_wp, at = 0.0_wp
      !> If the last step ended on the event: distance from zero that is treated as zero there, in the unit of the
      !> function, unless a switch has moved the function. 0: the step ended elsewhere.
      real(wp) :: near = 0.0_wp
      !> Function at the end of the last step, and its derivative by time; parts of the function, angles followed from
      !> the first step on.
      real(wp) :: f = 0.0_wp, slope = 0.0_wp
      type(part_t) :: parts(most_parts) = part_t()
      logical :: followed = .false.
      !> Failure for a quantity that was not finite between two steps, where zero is used instead.
      type(status_t) :: start_status
      !> The function has jumped since the last step, because torques have begun or ceased to act, or potentials were
      !> switched.
      logical :: jumped = .false.
      !> Range of the function over the ends of steps evaluated so far, and their number.
      real(wp) :: lowest = huge(1.0_wp), highest = -huge(1.0_wp)
      integer :: seen = 0
   end type watched_t

   !> All events of a run.
   type :: event_tracker_t
      !> Events that the program has set, followed by those of limits; number of the former.
      type(watched_t), allocatable :: watched(:)
      integer :: n_asked = 0
      !> The run is over.
      logical :: stopped = .false.
      !> Events whose switches are to be made, in this order, before the next step.
      integer, allocatable :: due(:)
      integer :: n_due = 0
      !> Switches since the last whole step.
      integer :: switches = 0
      !> Time of the last switch, s, and its derivative with respect to each sensitivity if there are any; shape (n).
      real(wp) :: switch_time = -huge(1.0_wp)
      real(wp), allocatable :: switch_change(:)
      !> Motion at the end of the last step, and the torques that acted in it; with functions and slopes of the events
      !> there, if `known`.
      type(motion_t) :: motion = motion_t()
      !> State at the start of the step that is searched, as the observer receives it.
      type(state_t) :: start = state_t()
      logical, allocatable :: acts(:)
      !> Start times of the pieces of the torques that acted, s.
      real(wp), allocatable :: pieces(:)
      logical :: known = .false.
      !> A motion has been noted.
      logical :: placed = .false.
      !> System as it is now, with switches made.
      type(system_t) :: system
      !> Time at which a controller takes its next sample, s; beyond all times if none does, or before the run has
      !> begun.
      real(wp) :: next_sample = huge(1.0_wp)
      !> No event can happen up to the time `wakes`, by bounds of the motion.
      logical :: asleep = .false.
      !> Number of steps without events found last, end of that time, s, and bounds of the motion.
      integer :: steps_asleep = 0
      real(wp) :: wakes = 0.0_wp
      type(motion_bounds_t) :: bounds = motion_bounds_t()
      !> The last positions in the step that is searched, and how many have been evaluated.
      type(place_t), private :: places(most_places) = place_t()
      integer, private :: n_places = 0
      !> Values that may be needed again, and the slot that was filled last.
      type(recalled_t), private :: recalled(most_recalled) = recalled_t()
      integer, private :: last_recalled = 0
   contains
      !> Returns, or stores, the motion at a position in a step.
      procedure, non_overridable :: recall_place
      procedure, non_overridable :: store_place
      procedure, non_overridable :: begin
      !> Sets how often events have happened in an earlier run.
      procedure, non_overridable :: remember
      !> Returns true if no event can happen up to a time.
      procedure, non_overridable :: sleeps_until
      !> Finds out for how long no event can happen.
      procedure, non_overridable :: fall_asleep
      !> Sets a system with other effects on.
      procedure, non_overridable :: set_system
      !> Stores the sides on which the quantities of limits are, as recorded in the system.
      procedure, non_overridable :: hold_sides
      !> Evaluates the parts of an event's function.
      procedure, non_overridable :: evaluate
      !> Evaluates functions and slopes at the start of a step.
      procedure, non_overridable :: open_step
      !> Notes functions and slopes at the position where a step was ended.
      procedure, non_overridable :: place
      !> Returns the size of the variation of a function.
      procedure, non_overridable :: variation
      procedure, non_overridable :: transfer
      !> Writes or reads the derivatives of times in checkpoint data.
      procedure, non_overridable :: transfer_changes
      !> Forgets the derivatives of times, for other sensitivities.
      procedure, non_overridable :: forget_changes
   end type event_tracker_t

   interface

      !> Sets events, system and first state. Errors: `NUTATE_BAD_ARGUMENT` for a switch of an effect that does not
      !> exist.
      module subroutine begin(self, events, system, state, status)
         class(event_tracker_t), intent(inout) :: self
         type(event_list_t), intent(in) :: events
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         type(status_t), intent(inout) :: status
      end subroutine begin

      !> Sets how often the first events have happened in an earlier run, and on which side they are.
      pure module subroutine remember(self, before)
         !> Tracker that has begun.
         class(event_tracker_t), intent(inout) :: self
         !> Tracker of the earlier run, with fewer events or more.
         type(event_tracker_t), intent(in) :: before
      end subroutine remember

      !> Sets a system with other effects on.
      module subroutine set_system(self, system)
         class(event_tracker_t), intent(inout) :: self
         type(system_t), intent(in) :: system
      end subroutine set_system

      !> Returns the motion at a position in the step, if it has been stored.
      pure module subroutine recall_place(self, s, motion, found)
         class(event_tracker_t), intent(in) :: self
         !> Position, in steps.
         real(wp), intent(in) :: s
         type(motion_t), intent(inout) :: motion
         logical, intent(out) :: found
      end subroutine recall_place

      !> Stores the motion at a position in the step, instead of the oldest.
      pure module subroutine store_place(self, s, motion)
         class(event_tracker_t), intent(inout) :: self
         !> Position, in steps.
         real(wp), intent(in) :: s
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
      end subroutine store_place

      !> Stores the sides on which the quantities of limits are, as recorded in the system. At its level, the round-off
      !> of a quantity does not determine the side: a command at its limit that is not found to leave it would stay
      !> there.
      pure module subroutine hold_sides(self)
         class(event_tracker_t), intent(inout) :: self
      end subroutine hold_sides

      !> Returns true if no event can happen up to a time.
      pure logical module function sleeps_until(self, t, sense)
         class(event_tracker_t), intent(in) :: self
         !> Time, s.
         real(wp), intent(in) :: t
         !> 1: forward in time; -1: backward.
         real(wp), intent(in) :: sense
      end function sleeps_until

      !> Finds out, between two steps, for how long no event can happen.
      module subroutine fall_asleep(self, t, step)
         !> Tracker whose functions and slopes are known.
         class(event_tracker_t), intent(inout) :: self
         !> Time, s.
         real(wp), intent(in) :: t
         !> Length of the steps, s.
         real(wp), intent(in) :: step
      end subroutine fall_asleep

      !> Evaluates the parts of an event's function at a motion, and their derivatives by time; angles are not followed.
      pure module subroutine evaluate(self, i, system, window_time, motion, parts)
         class(event_tracker_t), intent(inout) :: self
         !> Index of the event.
         integer, intent(in) :: i
         type(system_t), intent(in) :: system
         !> Time that decides which torques act, s.
         real(wp), intent(in) :: window_time
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
         type(part_t), intent(out) :: parts(most_parts)
      end subroutine evaluate

      !> Evaluates functions and slopes at the start of a step, as they are in it: they change if other torques act than
      !> in the last step.
      module subroutine open_step(self, system, state, window_time)
         class(event_tracker_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> Time that decides which torques act, s.
         real(wp), intent(in) :: window_time
      end subroutine open_step

      !> Notes functions and slopes at the position where a step was ended, as they are in the step.
      module subroutine place(self, system, state, window_time)
         class(event_tracker_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> State as the observer receives it.
         type(state_t), intent(in) :: state
         !> Time that decides which torques act, s.
         real(wp), intent(in) :: window_time
      end subroutine place

      !> Errors: `NUTATE_NOT_FINITE` for a quantity, or its rate, that is not finite.
      pure module subroutine check_parts(event, parts, status)
         class(event_t), intent(in) :: event
         type(part_t), intent(in) :: parts(most_parts)
         type(status_t), intent(inout) :: status
      end subroutine check_parts

      !> Brings parts that are known except for their wraps as near as possible to other values.
      pure module subroutine bring_near(parts, values)
         type(part_t), intent(inout) :: parts(most_parts)
         real(wp), intent(in) :: values(most_parts)
      end subroutine bring_near

      !> Returns the size of the variation of a function: its range so far, and that of an oscillation with the slopes
      !> of the step.
      pure real(wp) module function variation(self, i, last, turn)
         class(event_tracker_t), intent(in) :: self
         integer, intent(in) :: i
         !> The end of the step; slope by the time in steps.
         type(node_t), intent(in) :: last
         !> Rotation of the body in the step, rad.
         real(wp), intent(in) :: turn
      end function variation

      !> Writes or reads the data on which the next steps depend in checkpoint data.
      module subroutine transfer(self, archive)
         !> Tracker that has begun with the same events and system.
         class(event_tracker_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer

      !> Forgets the derivatives of times, for other sensitivities.
      pure module subroutine forget_changes(self)
         class(event_tracker_t), intent(inout) :: self
      end subroutine forget_changes

      !> Writes or reads the derivatives of times in checkpoint data.
      module subroutine transfer_changes(self, n, archive)
         !> Tracker that has begun with the same events and system.
         class(event_tracker_t), intent(inout) :: self
         !> Number of sensitivities.
         integer, intent(in) :: n
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_changes

   end interface

end module nutate_event_tracker
