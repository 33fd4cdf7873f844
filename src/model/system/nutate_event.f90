!> Events: moments at which a quantity of the motion crosses a value, or has an extremum.
!>
!> A program extends `event_t` by the quantity; the components of `event_t` state the action on the event. Columns of a
!> history as quantities are `column_event_t`.
module nutate_event
   use nutate_kinds, only: wp, long
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: check_event, event_t, part_t, find_family, time_scale, second_rate
   public :: CROSSING, MAXIMUM, MINIMUM, EXTREMUM, SWITCH_ON, SWITCH_OFF, SWITCH_TOGGLE

   !> Kinds of an event: crossing of a value, or extremum of the quantity.
   integer, parameter :: CROSSING = 0, MAXIMUM = 1, MINIMUM = 2, EXTREMUM = 3
   !> Actions of an event on an effect.
   integer, parameter :: SWITCH_ON = 1, SWITCH_OFF = 2, SWITCH_TOGGLE = 3

   !> Part of the time of a radian over which differences of sixth order are taken: ε^(1/7), where their error and
   !> round-off are alike, 1e-13; and of central differences, ε^(1/3), 1e-10.
   real(wp), parameter :: wide = 5.8e-3_wp, narrow = 6.1e-6_wp

   !> Largest number of parts of a quantity.
   integer, parameter, public :: most_parts = 4

   !> One of the parts that sum to a quantity; its value is known up to multiples of `wrap`, 2π for an angle; 0: it is
   !> unique.
   type :: part_t
      real(wp) :: value = 0.0_wp, wrap = 0.0_wp
      !> Time derivative of the value.
      real(wp) :: rate = 0.0_wp
   end type part_t

   !> An event: a condition on a quantity of the motion that a run locates in time, and the action on it.
   type, abstract :: event_t
      character(len=24) :: name = ''
      !> `CROSSING`, `MAXIMUM`, `MINIMUM` or `EXTREMUM`, either of the two.
      integer :: kind = CROSSING
      !> The value that is crossed, unit of the quantity.
      real(wp) :: level = 0.0_wp
      !> Period of the quantity if positive, such as 2π for an angle. A wrap is no crossing: runs follow the quantity
      !> continuously.
      real(wp) :: period = 0.0_wp
      !> Direction of crossings: 1: only growing; -1: only falling; 0: both.
      integer :: direction = 0
      !> The run ends at the first occurrence, or at the `count`-th if `count` is positive.
      logical :: stop = .false.
      integer(long) :: count = 0
      !> Label of an effect, and its action: `SWITCH_ON`, `SWITCH_OFF` or `SWITCH_TOGGLE`; 0: none.
      character(len=24) :: effect = ''
      integer :: action = 0
   contains
      !> Completes a copy of the event before a run, and returns why the run cannot follow it, if so; does nothing
      !> unless overridden.
      procedure :: complete => leave_as_it_is
      !> Returns the quantity g.
      procedure(event_value), deferred :: value
      !> Returns ġ along the motion; by differences unless overridden.
      procedure :: rate => rate_by_differences
      !> Returns the parts of g with their rates, so that angles are followed one by one; g as a whole, which may jump
      !> by multiples of the period, unless overridden.
      procedure :: parts => one_part
      !> Returns the number of the family of quantities that are computed together, and the component that is g: events
      !> of one family differ in component, level and direction alone. 0, and 1, unless overridden: there is none.
      procedure :: family => no_family
      procedure :: component => first_component
      !> Returns the components of the family; g alone unless overridden.
      procedure :: family_values => own_value
      !> Returns the size of the terms of g, to which its round-off is relative; |g| unless overridden.
      procedure :: magnitude => own_size
      !> Returns true if the quantity cannot reach its value for a time, so that no search is needed; `.false.` unless
      !> overridden.
      procedure :: is_out_of_reach => not_known
      !> Returns the direction of change that is an event: 1, -1 or 0, either.
      procedure, non_overridable :: counted_direction
   end type event_t

   abstract interface
      !> Returns the quantity g, a smooth function of time and state.
      pure real(wp) function event_value(self, system, motion)
         import :: event_t, system_t, motion_t, wp
         class(event_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> State, Ω and L; its rates need not be set. |q| may differ from 1 by 1e-4.
         type(motion_t), intent(in) :: motion
      end function event_value
   end interface

   interface

      !> Returns an empty reason.
      module subroutine leave_as_it_is(self, problem)
         class(event_t), intent(inout) :: self
         character(len=:), allocatable, intent(out) :: problem
      end subroutine leave_as_it_is

      !> Completes an event and tests its settings. Errors: `NUTATE_BAD_ARGUMENT`.
      module subroutine check_event(event, status)
         class(event_t), intent(inout) :: event
         type(status_t), intent(inout) :: status
      end subroutine check_event

      !> Returns true if the quantity cannot reach its value for a time. Here: false, nothing is known.
      pure logical module function not_known(self, speeds, f, time)
         class(event_t), intent(in) :: self
         !> Bounds of the motion in that time.
         type(speed_bounds_t), intent(in) :: speeds
         !> Distance of the quantity from its value at the start, unit of the quantity.
         real(wp), intent(in) :: f
         !> s, positive.
         real(wp), intent(in) :: time
      end function not_known

      !> Returns g and ġ as the only part.
      pure module subroutine one_part(self, system, motion, parts)
         class(event_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
         !> Parts of the quantity; those that are not needed are zero.
         type(part_t), intent(out) :: parts(most_parts)
      end subroutine one_part

      !> Returns 0: the quantity is computed alone.
      pure integer module function no_family(self)
         class(event_t), intent(in) :: self
      end function no_family

      !> Returns 1.
      pure integer module function first_component(self)
         class(event_t), intent(in) :: self
      end function first_component

      !> Returns g as the only component; shape (3).
      pure module function own_value(self, system, motion) result(values)
         class(event_t), intent(in) :: self
         type(system_t), intent(in) :: system
         type(motion_t), intent(in) :: motion
         real(wp) :: values(3)
      end function own_value

      !> Returns |g|.
      pure real(wp) module function own_size(self, system, motion) result(magnitude)
         class(event_t), intent(in) :: self
         type(system_t), intent(in) :: system
         type(motion_t), intent(in) :: motion
      end function own_size

      !> Computes ġ by `family_rates`.
      pure real(wp) module function rate_by_differences(self, system, motion) result(rate)
         class(event_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
      end function rate_by_differences

      !> Computes the components of a family, and their rates.
      pure module subroutine find_family(event, system, motion, values, rates)
         class(event_t), intent(in) :: event
         type(system_t), intent(in) :: system
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
         real(wp), intent(out) :: values(3), rates(3)
      end subroutine find_family

      !> Computes g̈ along the motion, by central differences of ġ.
      pure real(wp) module function second_rate(event, system, window_time, motion) result(rate)
         class(event_t), intent(in) :: event
         type(system_t), intent(in) :: system
         !> Time that decides which torques act, s.
         real(wp), intent(in) :: window_time
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
      end function second_rate

      !> Returns the time of about a radian of rotation, or of change of the momentum, s; 1 if nothing moves.
      pure real(wp) module function time_scale(motion) result(scale)
         !> Motion with its rates.
         type(motion_t), intent(in) :: motion
      end function time_scale

      !> Returns the direction of change that is an event: of g for a crossing, of ġ for an extremum; 1, -1 or 0,
      !> either.
      pure integer module function counted_direction(self)
         class(event_t), intent(in) :: self
      end function counted_direction

   end interface

end module nutate_event
