!> The search for one event in a step of the method: on which side of its level the function is at both ends, and the
!> roots between. A function with a period has a level at each multiple of it; between two of them it lies in a cell,
!> which it leaves by the one above or the one below.
module nutate_root_search
   use nutate_event, only: CROSSING, most_parts, part_t, SWITCH_TOGGLE
   use nutate_event_roots, only: find_first_root, node_t
   use nutate_event_tracker, only: watched_t
   use nutate_kinds, only: wp, eps
   use nutate_status, only: status_t
   use nutate_step_curve, only: step_curve_t
   implicit none
   private

   public :: root_search_t

   !> Round-off of a function, over its value; that of a derivative, and of one by differences (`second_rate`), over the
   !> size of the quantity in the time of a radian.
   real(wp), parameter :: noise = 16*eps, noise_of_rate = 64*eps, noise_of_second_rate = 1e-9_wp

   !> Distance from a level, over the variation or the period of the function, below which the function keeps its side
   !> if a step is cut: the shorter step may have led to the other side.
   real(wp), parameter :: at_level = 1e-6_wp

   !> The search for the next root of one event.
   type :: root_search_t
      type(step_curve_t) :: curve
      !> Both ends of the step; with a period, f is relative to the level of the event, and the sides have no meaning.
      type(node_t) :: first = node_t(), last = node_t()
      type(part_t) :: last_parts(most_parts) = part_t()
      real(wp) :: turn = 0.0_wp, scale = 0.0_wp, period = 0.0_wp
      !> For an extremum: the size of the quantity over the length of the step.
      real(wp) :: pace = 0.0_wp
      !> Direction of change of f along the step that is looked for: 1, -1 or 0, either.
      integer :: wanted = 0
      !> Value of the event's `near` at the start of the step.
      real(wp) :: near = 0.0_wp
      !> The function is zero all through the step but for round-off, or its levels are no farther from each other:
      !> there is nothing to find.
      logical :: is_flat = .false.
      logical :: found = .false.
      !> The root is where the function jumped over its level, at the start of the step.
      logical :: jumped = .false.
      type(node_t) :: root = node_t()
      !> The event has happened in the step, and the slope of the function there.
      logical :: has_passed = .false.
      real(wp) :: passed_slope = 0.0_wp
      !> Cells at the last event, after the root, and at the end; the level of the root, in periods.
      real(wp) :: cell = 0.0_wp, next_cell = 0.0_wp, last_cell = 0.0_wp, at = 0.0_wp
   contains
      !> Finds the sides at both ends; a jump of the function over a level is a root.
      procedure :: set_sides
      !> Looks for the next root after a position.
      procedure :: find_next
      !> Notes that the root has happened.
      procedure :: pass_root
      !> Notes the end of the step.
      procedure :: leave_step
      !> Notes where the step was cut.
      procedure :: leave_cut
   end type root_search_t

contains

   !> Finds the sides at both ends; a jump of the function over a level is a root.
   pure subroutine set_sides(self, watched, is_end)
      class(root_search_t), intent(inout) :: self
      type(watched_t), intent(inout) :: watched
      !> The run ends with the step: what comes to its level just there happens.
      logical, intent(in) :: is_end
      real(wp) :: least, sense
      integer :: side
      logical :: jumps
      self%found = .false.
      self%jumped = .false.
      self%has_passed = .false.
      self%at = 0.0_wp
      self%near = watched%near
      sense = merge(1.0_wp, -1.0_wp, is_end)
      self%period = 0.0_wp
      if (watched%event%kind == CROSSING) self%period = watched%event%period
      least = noise*(abs(watched%event%level) + self%scale)
      if (self%period > 0.0_wp) then
         call set_cells(self, watched, sense)
         self%is_flat = self%period <= noise*max(abs(self%first%f), abs(self%last%f), abs(watched%event%level))
      else
         jumps = watched%jumped .and. abs(self%first%f) > watched%near
         call leave_level(watched, self%first%f, self%first%slope)
         side = side_of(self%first, 1.0_wp)
         jumps = jumps .and. side*watched%side < 0
         if (watched%side == 0 .or. jumps) watched%side = side
         self%first%side = watched%side
         self%last%side = side_of(self%last, sense)
         if (self%last%side == 0) self%last%side = self%first%side
         if (self%first%side == 0) self%first%side = self%last%side
         self%is_flat = max(abs(self%first%f), abs(self%last%f), abs(self%first%slope), abs(self%last%slope)) <= least
         if (watched%event%kind /= CROSSING) self%is_flat = self%is_flat .or. &
            (max(abs(self%first%f), abs(self%last%f)) <= noise_of_rate*self%turn*self%pace .and. &
             max(abs(self%first%slope), abs(self%last%slope)) <= noise_of_second_rate*self%turn**2*self%pace)
         if (self%is_flat) self%last%side = self%first%side
         if (jumps) call note_jump(self, side)
      end if
      watched%jumped = .false.
   end subroutine set_sides

   !> Finds the cells at both ends, for a function with a period; a jump of the function over a level is a root.
   pure subroutine set_cells(self, watched, sense)
      class(root_search_t), intent(inout) :: self
      type(watched_t), intent(inout) :: watched
      !> Cell of a level at the end of the step: 1, the one just after; -1, the one just before.
      real(wp), intent(in) :: sense
      real(wp) :: cell
      logical :: jumps
      jumps = watched%jumped .and. abs(self%first%f - watched%at*self%period) > watched%near
      call leave_level(watched, self%first%f - watched%at*self%period, self%first%slope)
      cell = cell_of(self%first%f, self%first%slope, self%period, 1.0_wp, watched%cell)
      jumps = jumps .and. watched%side /= 0 .and. abs(cell - watched%cell) > 0.0_wp
      if (jumps) then
         self%at = merge(cell, cell + 1, cell > watched%cell)
         call note_jump(self, nint(sign(1.0_wp, cell - watched%cell)))
      end if
      if (watched%side == 0 .or. jumps) watched%cell = cell
      watched%side = 1
      self%cell = watched%cell
      self%next_cell = watched%cell
      self%last_cell = cell_of(self%last%f, self%last%slope, self%period, sense, watched%cell)
   end subroutine set_cells

   !> Notes that the function has jumped over a level at the start of the step.
   pure subroutine note_jump(self, side)
      class(root_search_t), intent(inout) :: self
      integer, intent(in) :: side
      self%found = self%wanted == 0 .or. self%wanted == side
      self%jumped = .true.
      self%root = self%first
      self%root%side = side
   end subroutine note_jump

   !> Finds the side of a function whose event ended the last step. A switch may have reversed the function, or moved
   !> it: the side is that to which it goes now, so that a function that only touches its level has no second event. If
   !> the event toggles, the side stays: a function that reverses switches again, endlessly without a dead band.
   pure subroutine leave_level(watched, f, slope)
      type(watched_t), intent(inout) :: watched
      !> Distance of the function from the level of the last event, and its slope, at the start of the next step.
      real(wp), intent(in) :: f, slope
      if (.not. watched%near > 0.0_wp) return
      if (watched%event%action == SWITCH_TOGGLE) then
         continue
      else if (abs(f) > watched%near) then
         watched%side = 0
      else if (abs(slope) > 0.0_wp) then
         watched%side = nint(sign(1.0_wp, slope))
         watched%cell = watched%at - merge(0.0_wp, 1.0_wp, slope > 0.0_wp)
      end if
      watched%near = 0.0_wp
   end subroutine leave_level

   !> Returns the side of zero on which a curve is; at zero, the side on which it is just after, or just before.
   pure integer function side_of(node, sense) result(side)
      type(node_t), intent(in) :: node
      !> 1: just after the position; -1: just before it.
      real(wp), intent(in) :: sense
      side = 0
      if (node%f > 0.0_wp .or. node%f < 0.0_wp) then
         side = nint(sign(1.0_wp, node%f))
      else if (abs(node%slope) > 0.0_wp) then
         side = nint(sign(1.0_wp, sense*node%slope))
      end if
   end function side_of

   !> Returns the cell of a value; at a level, the cell in which the curve is just after, or just before.
   pure real(wp) function cell_of(f, slope, period, sense, otherwise) result(cell)
      real(wp), intent(in) :: f, slope, period
      !> 1: just after the position; -1: just before it.
      real(wp), intent(in) :: sense
      !> Cell to return if neither f nor its slope determines it.
      real(wp), intent(in) :: otherwise
      cell = aint(f/period)
      if (f - cell*period < 0.0_wp) then
         cell = cell - 1
      else if (f - (cell + 1)*period >= 0.0_wp) then
         cell = cell + 1
      end if
      if (f - cell*period > 0.0_wp) return
      if (sense*slope < 0.0_wp) then
         cell = cell - 1
      else if (.not. abs(slope) > 0.0_wp .and. abs(otherwise - (cell - 1)) <= 0.0_wp) then
         cell = otherwise
      end if
   end function cell_of

   !> Looks for the next root after a position. Errors: those of the curve.
   subroutine find_next(self, from, resolution, status)
      class(root_search_t), intent(inout) :: self
      !> Start of the search; passed by value, since it may be the root found last.
      type(node_t), value :: from
      !> Round-off of a time, in steps.
      real(wp), intent(in) :: resolution
      type(status_t), intent(inout) :: status
      self%found = .false.
      self%jumped = .false.
      if (self%is_flat) return
      if (self%period > 0.0_wp) then
         call find_next_level(self, from, resolution, status)
      else
         self%curve%shift = 0.0_wp
         call find_first_root(self%curve, from, self%last, self%turn, self%scale, self%wanted, resolution, &
                              self%found, self%root, status)
      end if
   end subroutine find_next

   !> Finds the next root of a function with a period: cell by cell, up to a root with the wanted direction.
   subroutine find_next_level(self, from, resolution, status)
      class(root_search_t), intent(inout) :: self
      type(node_t), value :: from
      real(wp), intent(in) :: resolution
      type(status_t), intent(inout) :: status
      type(node_t) :: above, below, limit
      logical :: rises, falls
      do
         associate (cell => self%next_cell)
            limit = self%last
            limit%side = merge(1, -1, self%last_cell >= cell + 1)
            call find_at(self, cell + 1, from, -1, limit, resolution, rises, above, status)
            if (rises) limit = above
            limit%side = merge(1, -1, rises .or. self%last_cell >= cell)
            if (status%code == 0) call find_at(self, cell, from, 1, limit, resolution, falls, below, status)
            if (status%code /= 0) return
            if (.not. (rises .or. falls)) return
            self%root = merge_nodes(below, above, falls)
            self%at = merge(cell, cell + 1, falls)
            cell = cell + merge(-1, 1, falls)
            self%found = self%wanted == 0 .or. self%wanted == self%root%side
            if (self%found) return
            from = self%root
         end associate
      end do
   end subroutine find_next_level

   !> Returns node a if `first`, else node b.
   pure type(node_t) function merge_nodes(a, b, first) result(node)
      type(node_t), intent(in) :: a, b
      logical, intent(in) :: first
      node = b
      if (first) node = a
   end function merge_nodes

   !> Finds the first root at one level.
   subroutine find_at(self, level, from, side, to, resolution, found, root, status)
      class(root_search_t), intent(inout) :: self
      !> Level, in periods.
      real(wp), intent(in) :: level
      !> Ends of the search; f from the level of the event.
      type(node_t), intent(in) :: from, to
      !> Side of the level on which the function is at first.
      integer, intent(in) :: side
      real(wp), intent(in) :: resolution
      logical, intent(out) :: found
      !> Root; f from the level of the event.
      type(node_t), intent(out) :: root
      type(status_t), intent(inout) :: status
      type(node_t) :: a, b
      found = .false.
      if (to%s <= from%s) return
      self%curve%shift = level*self%period
      a = from
      a%f = a%f - self%curve%shift
      a%side = side
      b = to
      b%f = b%f - self%curve%shift
      call find_first_root(self%curve, a, b, self%turn, self%scale, 0, resolution, found, root, status)
      root%f = self%curve%shift
   end subroutine find_at

   !> Notes that the root has happened.
   pure subroutine pass_root(self)
      class(root_search_t), intent(inout) :: self
      self%first%side = self%root%side
      self%cell = self%next_cell
      self%has_passed = .true.
      self%passed_slope = self%root%slope
   end subroutine pass_root

   !> Notes the end of the step.
   pure subroutine leave_step(self, watched, length)
      class(root_search_t), intent(in) :: self
      type(watched_t), intent(inout) :: watched
      !> Length of the step, s.
      real(wp), intent(in) :: length
      watched%f = self%last%f
      watched%slope = self%last%slope/length
      watched%parts = self%last_parts
      watched%side = self%last%side
      if (.not. self%period > 0.0_wp) return
      watched%side = 1
      watched%cell = self%last_cell
      call subtract_periods(self, watched)
   end subroutine leave_step

   !> Subtracts whole periods that are whole revolutions, so that an angle keeps its digits however long it grows.
   pure subroutine subtract_periods(self, watched)
      class(root_search_t), intent(in) :: self
      type(watched_t), intent(inout) :: watched
      real(wp) :: periods, turns
      associate (part => watched%parts(1))
         if (.not. part%wrap > 0.0_wp .or. any(watched%parts(2:)%wrap > 0.0_wp)) return
         periods = aint(watched%f/self%period)
         if (.not. abs(periods) > 0.0_wp) return
         turns = self%period/part%wrap
         if (abs(turns - anint(turns)) > 4*eps*turns) return
         part%value = part%value - periods*self%period
         watched%f = watched%f - periods*self%period
         watched%cell = watched%cell - periods
      end associate
   end subroutine subtract_periods

   !> Notes where the step was cut, function and slope known there.
   pure subroutine leave_cut(self, watched, happened, slope_error, moved)
      class(root_search_t), intent(in) :: self
      type(watched_t), intent(inout) :: watched
      !> The event happened at the cut; the state at the cut is not that at the start of the step.
      logical, intent(in) :: happened, moved
      !> Error of the time of the event, in steps.
      real(wp), intent(in) :: slope_error
      real(wp) :: cell, near
      logical :: is_here
      watched%near = merge(0.0_wp, self%near, moved)
      watched%cell = self%cell
      watched%at = self%at
      near = max(4*abs(self%passed_slope)*slope_error + noise*(abs(watched%event%level) + self%scale), tiny(1.0_wp))
      is_here = happened
      ! Another event ends the step next to this one, which has happened inside of it.
      if (self%has_passed .and. .not. self%period > 0.0_wp) is_here = is_here .or. abs(watched%f) <= near
      if (is_here) then
         watched%side = self%first%side
         ! The step to the event is another one than that in which the event was found: its state errs, too.
         if (happened .and. moved .and. .not. self%jumped) near = max(near, 2*abs(watched%f - self%at*self%period))
         watched%near = near
      else if (self%period > 0.0_wp) then
         cell = cell_of(watched%f, watched%slope, self%period, 1.0_wp, self%cell)
         if (min(abs(watched%f - self%cell*self%period), abs(watched%f - (self%cell + 1)*self%period)) > &
             at_level*self%period) watched%cell = cell
      else
         watched%side = self%first%side
         if (abs(watched%f) > at_level*self%scale) watched%side = side_of(node_t(f=watched%f), 1.0_wp)
      end if
   end subroutine leave_cut

end module nutate_root_search
