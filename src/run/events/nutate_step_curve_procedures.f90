!> Bodies of the procedures whose interfaces are in `nutate_step_curve`.
submodule(nutate_step_curve) nutate_step_curve_procedures
   use nutate_event, only: CROSSING
   use nutate_event_tracker, only: bring_near, check_parts
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_state, only: state_t
   implicit none

contains

   module procedure join
      type(anchor_t) :: b
      self%follows = any(last%wrap > 0.0_wp)
      if (.not. self%follows) return
      if (.not. allocated(self%anchors)) &
         allocate (self%anchors(1 + 2**merge(deepest_cheap, deepest, self%is_cheap)))
      associate (length => self%progress%state%t - self%mark%state%t)
         self%n = 1
         self%anchors(1) = anchor_t(parts=first)
         self%anchors(1)%parts%rate = first%rate*length
         b = anchor_t(s=1.0_wp, parts=last)
         b%parts%rate = last%rate*length
         call follow(self, b, turn, merge(deepest_cheap, deepest, self%is_cheap), status)
         last%value = self%anchors(self%n)%parts%value
      end associate
   end procedure join

   !> Follows the angles from the last anchor to a position, which becomes the last anchor.
   recursive subroutine follow(self, b, turn, halvings, status)
      class(step_curve_t), intent(inout) :: self
      !> Position whose revolutions are not known.
      type(anchor_t), value :: b
      !> Rotation of the body in the step, rad.
      real(wp), intent(in) :: turn
      !> Largest number of halvings.
      integer, intent(in) :: halvings
      type(status_t), intent(inout) :: status
      type(anchor_t) :: a, middle
      real(wp) :: width
      a = self%anchors(self%n)
      width = b%s - a%s
      call bring_near(b%parts, a%parts%value + (0.5_wp*width)*(a%parts%rate + b%parts%rate))
      if (halvings > 0 .and. .not. is_calm(a, b, turn)) then
         middle%s = 0.5_wp*(a%s + b%s)
         call evaluate_at(self, middle%s, middle%parts, status)
         if (status%code /= 0) return
         if (.not. leads_through(a, middle, b) .or. (self%is_cheap .and. turn*width > great_turn)) then
            call follow(self, middle, turn, halvings - 1, status)
            if (status%code == 0) call follow(self, b, turn, halvings - 1, status)
            return
         end if
         call bring_near(middle%parts, between(a, b, middle%s))
         self%n = self%n + 1
         self%anchors(self%n) = middle
      end if
      self%n = self%n + 1
      self%anchors(self%n) = b
   end subroutine follow

   !> Returns true if angles change by so little, and so steadily, that their revolutions are certain.
   pure logical function is_calm(a, b, turn)
      type(anchor_t), intent(in) :: a, b
      !> Rotation of the body in the step, rad.
      real(wp), intent(in) :: turn
      real(wp) :: width
      integer :: i
      width = b%s - a%s
      is_calm = turn*width <= small_turn
      do i = 1, most_parts
         associate (u => a%parts(i), v => b%parts(i))
            if (v%wrap > 0.0_wp) is_calm = is_calm .and. &
               width*max(abs(u%rate), abs(v%rate)) <= small_change*v%wrap .and. &
               abs(v%value - u%value - 0.5_wp*width*(u%rate + v%rate)) <= calm*v%wrap
         end associate
      end do
   end function is_calm

   !> Returns true if the cubic through two positions is right in the middle of them.
   pure logical function leads_through(a, middle, b)
      !> Both ends, and the middle, whose revolutions are not known.
      type(anchor_t), intent(in) :: a, middle, b
      real(wp) :: expected(most_parts), width, slope, off
      integer :: i
      width = b%s - a%s
      expected = between(a, b, middle%s)
      leads_through = .true.
      do i = 1, most_parts
         associate (u => a%parts(i), m => middle%parts(i), v => b%parts(i))
            if (.not. v%wrap > 0.0_wp) cycle
            off = m%value - expected(i)
            off = off - v%wrap*anint(off/v%wrap)
            slope = 1.5_wp*(v%value - u%value) - 0.25_wp*width*(u%rate + v%rate)
            leads_through = leads_through .and. max(abs(off), 0.1_wp*abs(width*m%rate - slope)) <= near*v%wrap
         end associate
      end do
   end function leads_through

   !> Returns Hermite's cubic between two positions; shape (most_parts).
   pure function between(a, b, s) result(values)
      type(anchor_t), intent(in) :: a, b
      real(wp), intent(in) :: s
      real(wp) :: values(most_parts)
      real(wp) :: x, y, width
      width = b%s - a%s
      x = (s - a%s)/width
      y = 1 - x
      values = y*y*((1 + 2*x)*a%parts%value + (x*width)*a%parts%rate) + &
               x*x*((1 + 2*y)*b%parts%value - (y*width)*b%parts%rate)
   end function between

   module procedure expect
      integer :: low, high, i
      low = 1
      high = self%n
      do while (high - low > 1)
         i = (low + high)/2
         if (self%anchors(i)%s <= s) then
            low = i
         else
            high = i
         end if
      end do
      values = between(self%anchors(low), self%anchors(high), s)
   end procedure expect

   module procedure evaluate
      type(part_t) :: parts(most_parts)
      f = 0.0_wp
      slope = 0.0_wp
      call evaluate_at(self, s, parts, status)
      if (status%code /= 0) return
      if (self%follows) call bring_near(parts, self%expect(s))
      f = sum(parts%value)
      associate (event => self%progress%events%watched(self%event)%event)
         if (event%kind == CROSSING) f = f - event%level
      end associate
      f = f - self%shift
      slope = sum(parts%rate)
   end procedure evaluate

   !> Evaluates the parts of the function at a position inside the step, and their derivatives by s; angles are not
   !> followed.
   subroutine evaluate_at(self, s, parts, status)
      class(step_curve_t), intent(inout) :: self
      real(wp), intent(in) :: s
      type(part_t), intent(out) :: parts(most_parts)
      type(status_t), intent(inout) :: status
      type(state_t) :: state
      type(motion_t) :: motion
      real(wp) :: start, length, window_time
      logical :: known
      start = self%mark%state%t
      length = self%progress%state%t - start
      window_time = start + 0.5_wp*length
      call self%progress%events%recall_place(s, motion, known)
      if (.not. known) then
         call self%policy%state_inside(self%system, self%progress, start + s*length, state, status, before=self%mark)
         if (status%code /= 0) return
         call find_motion(self%system, state, motion)
         call find_rates(self%system, window_time, motion)
         call self%progress%events%store_place(s, motion)
      end if
      call self%progress%events%evaluate(self%event, self%system, window_time, motion, parts)
      call check_parts(self%progress%events%watched(self%event)%event, parts, status)
      if (status%code /= 0) return
      parts%rate = parts%rate*length
   end subroutine evaluate_at

end submodule nutate_step_curve_procedures
