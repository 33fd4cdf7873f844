!> Sums of quantities of the table as quantities of events, with their rates in closed form.
module nutate_column_event
   use nutate_event, only: CROSSING, event_t, find_family, most_parts, part_t
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: is_moderate
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quantities, only: component_of, find_quantity, quantities
   use nutate_quantity, only: AS_EVENT
   use nutate_quantity_motion, only: fastest_rate, greatest_value, quantity_rate, quantity_size, quantity_value
   use nutate_system, only: system_t
   implicit none
   private

   public :: column_event_t

   !> Largest number of columns of an event.
   integer, parameter, public :: most_columns = most_parts

   !> A sum of columns with weights.
   type, extends(event_t) :: column_event_t
      !> Names of the columns; blank: no more.
      character(len=24) :: columns(most_columns) = ''
      real(wp) :: weights(most_columns) = 1.0_wp
      !> Number of columns, their positions in the table, and the component of each, once `place` has been called.
      integer, private :: n = 0
      integer, private :: places(most_columns) = 0, components(most_columns) = 0
   contains
      !> Finds the columns by their names, once instead of in every step; a run calls it by `complete`.
      procedure :: place
      procedure :: complete => complete_columns
      procedure :: value => sum_of_columns
      procedure :: rate => rate_of_sum
      procedure :: parts => parts_of_sum
      procedure :: magnitude => size_of_sum
      procedure :: is_out_of_reach => sum_is_out_of_reach
   end type column_event_t

contains

   !> Finds the columns by their names. An unknown name is treated as no column.
   pure subroutine place(self)
      class(column_event_t), intent(inout) :: self
      integer :: i, at
      self%n = 0
      do i = 1, most_columns
         if (self%columns(i) == '') return
         at = find_quantity(self%columns(i), AS_EVENT)
         if (at == 0) return
         self%n = i
         self%places(i) = at
         self%components(i) = component_of(quantities(at), self%columns(i))
      end do
   end subroutine place

   !> Finds the columns; the reason names the first that is unknown.
   subroutine complete_columns(self, problem)
      class(column_event_t), intent(inout) :: self
      character(len=:), allocatable, intent(out) :: problem
      problem = ''
      call self%place()
      if (.not. all(is_moderate(self%weights))) problem = 'a weight is not finite or too large (expected up to 1e100)'
      if (self%n == most_columns) return
      if (self%columns(self%n + 1) /= '') then
         problem = "no column for events is called '"//trim(self%columns(self%n + 1))// &
                   "' (expected a name such as omega1)"
      else if (self%n == 0) then
         problem = 'columns is empty (expected the name of a column)'
      end if
   end subroutine complete_columns

   !> Returns Σ weights × columns, unit of the columns.
   pure real(wp) function sum_of_columns(self, system, motion) result(g)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      g = 0.0_wp
      do i = 1, self%n
         g = g + self%weights(i)*quantity_value(quantities(self%places(i)), self%components(i), system, motion)
      end do
   end function sum_of_columns

   !> Returns the time derivative of the sum.
   pure real(wp) function rate_of_sum(self, system, motion) result(rate)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      rate = 0.0_wp
      do i = 1, self%n
         rate = rate + self%weights(i)*rate_of_column(self, i, system, motion)
      end do
   end function rate_of_sum

   !> Returns the rate of a column, by differences if the table says so.
   pure real(wp) function rate_of_column(self, i, system, motion) result(rate)
      class(column_event_t), intent(in) :: self
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      type(column_event_t) :: one
      real(wp) :: values(3), rates(3)
      if (.not. quantities(self%places(i))%by_differences) then
         rate = quantity_rate(quantities(self%places(i)), self%components(i), system, motion)
         return
      end if
      one%n = 1
      one%places(1) = self%places(i)
      one%components(1) = self%components(i)
      call find_family(one, system, motion, values, rates)
      rate = rates(1)
   end function rate_of_column

   !> Returns each weighted column with its rate, so that angles are followed one by one.
   pure subroutine parts_of_sum(self, system, motion, parts)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      type(part_t), intent(out) :: parts(most_parts)
      integer :: i
      do i = 1, self%n
         associate (weight => self%weights(i), at => self%places(i), component => self%components(i))
            parts(i)%value = weight*quantity_value(quantities(at), component, system, motion)
            parts(i)%rate = weight*rate_of_column(self, i, system, motion)
            if (quantities(at)%is_periodic .and. .not. quantities(at)%is_continuous) parts(i)%wrap = 2*pi*abs(weight)
         end associate
      end do
   end subroutine parts_of_sum

   !> Returns Σ |weights| × size of the columns.
   pure real(wp) function size_of_sum(self, system, motion) result(magnitude)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      magnitude = 0.0_wp
      do i = 1, self%n
         magnitude = magnitude + abs(self%weights(i))* &
                     quantity_size(quantities(self%places(i)), self%components(i), system, motion)
      end do
   end function size_of_sum

   !> Returns true if the bounds of the motion keep the sum from reaching its value for a time. A margin of a quarter
   !> covers the errors of a computed motion.
   pure logical function sum_is_out_of_reach(self, speeds, f, time) result(stays)
      class(column_event_t), intent(in) :: self
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), intent(in) :: f, time
      real(wp), parameter :: margin = 1.25_wp
      real(wp) :: fastest, range, rate, value
      integer :: i
      stays = .false.
      if (self%kind /= CROSSING) return
      fastest = 0.0_wp
      do i = 1, self%n
         rate = fastest_rate(quantities(self%places(i)), self%components(i), speeds)
         ! No bound is known, for example for an angle that jumps at the poles.
         if (rate < 0.0_wp) return
         fastest = fastest + abs(self%weights(i))*rate
      end do
      stays = abs(f) > margin*fastest*time
      if (stays .or. self%period > 0.0_wp) return
      range = 0.0_wp
      do i = 1, self%n
         value = greatest_value(quantities(self%places(i)), self%components(i), speeds)
         if (value < 0.0_wp) return
         range = range + abs(self%weights(i))*value
      end do
      stays = abs(self%level) > range
   end function sum_is_out_of_reach

end module nutate_column_event
