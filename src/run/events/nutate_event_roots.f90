!> Roots of a function along a step: isolated, then found by Newton's iteration in a bracket.
!>
!> A step is known at its ends, by the function and its derivative. Between them it is evaluated only where a root can
!> be: the function can move away from its ends by about `|f'| + scale·turn²`, with the rotation of the body in the
!> step, `turn`, in radians. A part in which a root cannot be excluded is evaluated at its quarters. If the polynomial
!> of fifth degree through both ends and the middle agrees with the quarters to 1e-6, that of ninth degree through all
!> five positions is the function to 1e-12, and all of its roots are isolated by Bernstein's bounds
!> (`nutate_bernstein`). If it does not agree, the part is halved: down to an eighth of the step and to a radian, or as
!> far as a sixty-fourth if evaluation is cheap. There a change of sign is one root, and an extremum towards zero is
!> tested for a pair of them: a pair nearer to each other than that, off the extremum that the ends point to, can be
!> missed.
module nutate_event_roots
   use nutate_bernstein, only: bernstein_t, degree, through_five, value_at
   use nutate_kinds, only: wp, eps
   use nutate_status, only: status_t
   implicit none
   private

   public :: curve_t, node_t, find_first_root

   !> Largest numbers of halvings: down to a quarter of the step, which is evaluated at its quarters in turn; to a
   !> sixty-fourth if evaluation is cheap; further, to a sixty-fourth or, if it is cheap, to about a thousandth, while
   !> the body rotates by over a radian in a part.
   integer, parameter :: enough = 2, enough_cheap = 6, deepest = 6, deepest_cheap = 10
   real(wp), parameter :: great_turn = 1.0_wp
   !> Factor by which the reach of a function may exceed its estimate.
   real(wp), parameter :: safety = 2.0_wp
   !> Agreement of the quintic with the quarters, over the variation: the error of the polynomial of ninth degree is
   !> then some 1e-12; and what is below round-off of the function.
   real(wp), parameter :: agreement = 1e-6_wp, noise = 64*eps
   !> Two roots that leave less of the polynomial between them, over its variation, are looked for in the function.
   real(wp), parameter :: shallow = 1e-9_wp
   !> Largest number of halvings of a polynomial, beyond which its roots are not distinguished.
   integer, parameter :: most_halvings = 40
   !> Largest number of evaluations for a root and for an extremum; both usually need two to five.
   integer, parameter :: most_tries = 60, most_evaluations = 24
   !> An increment of Newton's iteration, in steps, the square of which is below round-off.
   real(wp), parameter :: last_increment = 1e-9_wp

   !> A function of the time s from the start of a step, in steps.
   type, abstract :: curve_t
      !> Evaluation costs much less than a step.
      logical :: is_cheap = .false.
   contains
      !> Evaluates the function and its derivative with respect to s.
      procedure(evaluate_curve), deferred :: evaluate
   end type curve_t

   !> Position on a curve.
   type :: node_t
      !> s; f; f'.
      real(wp) :: s = 0.0_wp, f = 0.0_wp, slope = 0.0_wp
      !> 1 or -1: the side of zero on which the curve is; after a root, the side of f just after it, whatever the sign
      !> of f at the root itself.
      integer :: side = 0
   end type node_t

   abstract interface
      subroutine evaluate_curve(self, s, f, slope, status)
         import :: curve_t, status_t, wp
         class(curve_t), intent(inout) :: self
         real(wp), intent(in) :: s
         real(wp), intent(out) :: f, slope
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine evaluate_curve
   end interface

contains

   !> Finds the first root after a node that changes the sign as wanted. Errors: those of the curve.
   subroutine find_first_root(curve, first, last, turn, scale, wanted, resolution, found, root, status)
      class(curve_t), intent(inout) :: curve
      !> Ends of the search, with their sides set.
      type(node_t), intent(in) :: first, last
      !> Rotation of the body in a step, rad; size of the variation of f.
      real(wp), intent(in) :: turn, scale
      !> 1: f grows through zero; -1: it falls; 0: either.
      integer, intent(in) :: wanted
      !> Round-off of s.
      real(wp), intent(in) :: resolution
      logical, intent(out) :: found
      !> First root; its side is that of f after it.
      type(node_t), intent(out) :: root
      !> Success on entry.
      type(status_t), intent(inout) :: status
      type(node_t) :: middle
      !> Round-off of s, at least that of 1.
      real(wp) :: finest
      !> Halvings of a part that no polynomial follows; their largest number, if the body rotates by many radians in the
      !> step.
      integer :: halvings, at_most
      found = .false.
      if (is_excluded(first, last)) return
      finest = max(resolution, eps)
      halvings = merge(enough_cheap, enough, curve%is_cheap)
      at_most = merge(deepest_cheap, deepest, curve%is_cheap)
      if (last%s - first%s <= 8*finest) then
         call search_piece(first, last)
      else
         middle%s = 0.5_wp*(first%s + last%s)
         call evaluate(middle, first%side)
         if (status%code == 0) call search_part(first, middle, last, 0)
      end if
      found = found .and. status%code == 0

   contains

      !> Returns true if there can be no root between two positions: both are farther from zero than the function can
      !> go.
      pure logical function is_excluded(a, b)
         type(node_t), intent(in) :: a, b
         real(wp) :: width, angle, reach, defect
         is_excluded = .false.
         if (a%side /= b%side) return
         width = b%s - a%s
         angle = width*turn
         ! Part of the change of f that the mean slope does not explain.
         defect = (b%f - a%f) - 0.5_wp*width*(a%slope + b%slope)
         reach = max(abs(a%slope), abs(b%slope))*width + scale*angle*angle + 2*abs(defect)
         is_excluded = min(abs(a%f), abs(b%f)) > safety*reach
      end function is_excluded

      !> Searches a part of the step, of which the ends and the middle are known.
      recursive subroutine search_part(a, middle, b, depth)
         type(node_t), intent(in) :: a, middle, b
         integer, intent(in) :: depth
         type(node_t) :: nodes(5)
         type(bernstein_t) :: polynomial
         real(wp) :: size
         integer :: i
         if (is_excluded(a, middle) .and. is_excluded(middle, b)) return
         nodes(1) = a
         nodes(3) = middle
         nodes(5) = b
         do i = 2, 4, 2
            nodes(i)%s = 0.5_wp*(nodes(i - 1)%s + nodes(i + 1)%s)
            call evaluate(nodes(i), a%side)
            if (status%code /= 0) return
         end do
         call fit(nodes, polynomial, size)
         if (size > 0.0_wp) then
            call search_polynomial(polynomial, size, a, b, 0)
         else if ((depth >= halvings .and. (b%s - a%s)*turn <= great_turn) .or. depth >= at_most) then
            do i = 1, 4
               if (.not. is_excluded(nodes(i), nodes(i + 1))) call search_piece(nodes(i), nodes(i + 1))
               if (found .or. status%code /= 0) return
            end do
         else
            call search_part(a, nodes(2), middle, depth + 1)
            if (found .or. status%code /= 0) return
            call search_part(middle, nodes(4), b, depth + 1)
         end if
      end subroutine search_part

      !> Searches a polynomial for the first change of sign that is wanted: Bernstein's coefficients bound it, and have
      !> as many changes of sign as it has roots, or an even number more.
      recursive subroutine search_polynomial(polynomial, size, a, b, depth)
         type(bernstein_t), intent(in) :: polynomial
         !> Size of the polynomial's variation.
         real(wp), intent(in) :: size
         !> Ends of the polynomial; only position and side are used.
         type(node_t), intent(in) :: a, b
         integer, intent(in) :: depth
         type(bernstein_t) :: left, right
         type(node_t) :: middle
         integer :: changes
         changes = polynomial%changes()
         if (changes == 0) return
         if (changes == 1 .or. depth >= most_halvings) then
            if (a%side == b%side) return
            if (wanted == 0 .or. wanted == b%side) call refine(a, b, a%s + polynomial%root()*(b%s - a%s))
            return
         end if
         if (a%side == b%side .and. polynomial%greatest() <= shallow*size) then
            call search_closely(a, b)
            return
         end if
         call polynomial%halve(left, right)
         middle%s = 0.5_wp*(a%s + b%s)
         middle%side = nint(sign(1.0_wp, right%c(0)))
         call search_polynomial(left, size, a, middle, depth + 1)
         if (found .or. status%code /= 0) return
         call search_polynomial(right, size, middle, b, depth + 1)
      end subroutine search_polynomial

      !> Searches a part in which the polynomial all but touches zero: there the function itself decides.
      subroutine search_closely(a, b)
         type(node_t), intent(in) :: a, b
         type(node_t) :: left, right
         left%s = a%s
         call evaluate(left, a%side)
         right%s = b%s
         if (status%code == 0) call evaluate(right, b%side)
         left%side = a%side
         right%side = b%side
         if (status%code == 0) call search_piece(left, right)
      end subroutine search_closely

      !> Searches a part that is not halved any more: one root if the sign changes, else none or two.
      subroutine search_piece(a, b)
         type(node_t), intent(in) :: a, b
         type(node_t) :: beyond
         logical :: crosses
         if (a%side /= b%side) then
            if (wanted == 0 .or. wanted == b%side) call refine(a, b, cubic_root(a, b))
         else if (a%side*a%slope < 0.0_wp .and. b%side*b%slope > 0.0_wp) then
            call evaluate_beyond(a, b, beyond, crosses)
            if (status%code /= 0 .or. .not. crosses) return
            if (wanted == 0 .or. wanted == beyond%side) then
               call refine(a, beyond, cubic_root(a, beyond))
            else
               call refine(beyond, b, cubic_root(beyond, b))
            end if
         end if
      end subroutine search_piece

      !> Looks for a position on the other side of zero, around the extremum between two positions on one side: by false
      !> position of the derivative, each time between the neighbours of the extremum (Illinois), until f is there, or
      !> as near to the extremum as f resolves.
      subroutine evaluate_beyond(a, b, beyond, crosses)
         type(node_t), intent(in) :: a, b
         type(node_t), intent(out) :: beyond
         logical, intent(out) :: crosses
         type(node_t) :: left, right
         real(wp) :: weights(2), gain
         integer :: i, last
         left = a
         right = b
         weights = 1.0_wp
         last = 0
         crosses = .false.
         do i = 1, most_evaluations
            associate (low => weights(1)*left%slope, high => weights(2)*right%slope)
               beyond%s = left%s - low*((right%s - left%s)/(high - low))
            end associate
            call evaluate(beyond, a%side)
            if (status%code /= 0) return
            crosses = beyond%side /= a%side
            if (crosses) return
            ! Largest change of f for which the tangents at both neighbours leave room.
            gain = min(abs(beyond%slope)*max(right%s - beyond%s, beyond%s - left%s), abs(left%f), abs(right%f))
            if (abs(beyond%f) > gain .or. right%s - left%s <= finest) return
            if (a%side*beyond%slope < 0.0_wp) then
               left = beyond
               weights = [1.0_wp, merge(0.5_wp*weights(2), 1.0_wp, last == 1)]
               last = 1
            else
               right = beyond
               weights = [merge(0.5_wp*weights(1), 1.0_wp, last == 2), 1.0_wp]
               last = 2
            end if
         end do
      end subroutine evaluate_beyond

      !> Finds the root between two positions on different sides: by Newton's iteration, halving the bracket if the
      !> iteration leaves it or is slow.
      subroutine refine(a, b, start)
         type(node_t), intent(in) :: a, b
         !> Position at which the root is likely to be.
         real(wp), intent(in) :: start
         type(node_t) :: left, right, trial
         real(wp) :: next, width
         integer :: i
         left = a
         right = b
         next = start
         do i = 1, most_tries
            width = right%s - left%s
            trial%s = next
            call evaluate(trial, b%side)
            if (status%code /= 0) return
            next = trial%s
            if (abs(trial%slope) > 0.0_wp) then
               next = trial%s - trial%f/trial%slope
            else if (abs(trial%f) > 0.0_wp) then
               next = b%s ! it jumps: halves find where
            end if
            if (trial%side == a%side) then
               left = trial
            else
               right = trial
            end if
            if (abs(next - trial%s) <= max(last_increment, finest) .and. next > a%s .and. next < b%s) exit
            if (right%s - left%s <= finest) then
               next = min(max(next, left%s), right%s)
               exit
            end if
            ! Newton's iteration is slower than halving, or leads nowhere.
            if (.not. (next > left%s .and. next < right%s) .or. (i > 3 .and. right%s - left%s > 0.5_wp*width)) &
               next = 0.5_wp*(left%s + right%s)
         end do
         found = .true.
         ! At a root that is nearly double the slope may be noise: it leads to the side after the root.
         root = node_t(s=min(max(next, a%s), b%s), slope=b%side*abs(trial%slope), side=b%side)
      end subroutine refine

      !> Evaluates the function at a position, and the side on which it is; at zero, the side on which it is going to
      !> be.
      subroutine evaluate(node, side)
         type(node_t), intent(inout) :: node
         !> The side of a zero without a slope.
         integer, intent(in) :: side
         call curve%evaluate(node%s, node%f, node%slope, status)
         node%side = side
         if (node%f > 0.0_wp) then
            node%side = 1
         else if (node%f < 0.0_wp) then
            node%side = -1
         else if (abs(node%slope) > 0.0_wp) then
            node%side = nint(sign(1.0_wp, node%slope))
         end if
      end subroutine evaluate

   end subroutine find_first_root

   !> Computes the polynomial of ninth degree through five positions at equal distances.
   pure subroutine fit(nodes, polynomial, size)
      !> Positions at equal distances; shape (5).
      type(node_t), intent(in) :: nodes(5)
      !> Polynomial, from 0 at the first to 1 at the last position.
      type(bernstein_t), intent(out) :: polynomial
      !> Size of the polynomial's variation; 0 if it does not follow the function.
      real(wp), intent(out) :: size
      type(bernstein_t) :: quintic
      real(wp) :: width, worst, f, slope, greatest
      integer :: i
      width = nodes(5)%s - nodes(1)%s
      quintic = through_five(nodes([1, 3, 5])%f, width*nodes([1, 3, 5])%slope)
      greatest = maxval(abs(nodes%f))
      size = maxval(nodes%f) - minval(nodes%f) + width*maxval(abs(nodes%slope))
      worst = 0.0_wp
      do i = 2, 4, 2
         call value_at(quintic, 0.25_wp*(i - 1), f, slope)
         worst = max(worst, abs(nodes(i)%f - f), 0.1_wp*abs(width*nodes(i)%slope - slope))
      end do
      if (worst > agreement*size + noise*greatest) then
         size = 0.0_wp
         return
      end if
      polynomial = through_five(nodes%f, width*nodes%slope)
      ! At a root the side is used, whatever the sign that rounding leaves.
      polynomial%c(0) = sign(max(abs(polynomial%c(0)), tiny(size)), real(nodes(1)%side, wp))
      polynomial%c(polynomial%degree) = sign(max(abs(polynomial%c(polynomial%degree)), tiny(size)), &
                                             real(nodes(5)%side, wp))
      size = max(size, tiny(size))
   end subroutine fit

   !> Returns a root of Hermite's cubic through two positions on different sides, found by halving.
   pure real(wp) function cubic_root(a, b) result(s)
      type(node_t), intent(in) :: a, b
      real(wp) :: low, high, x, f
      integer :: i
      low = 0.0_wp
      high = 1.0_wp
      do i = 1, 40
         x = 0.5_wp*(low + high)
         f = cubic(a, b, x)
         if (f*a%side > 0.0_wp) then
            low = x
         else
            high = x
         end if
      end do
      s = a%s + x*(b%s - a%s)
   end function cubic_root

   !> Returns Hermite's cubic at x, 0 at a and 1 at b.
   pure real(wp) function cubic(a, b, x) result(f)
      type(node_t), intent(in) :: a, b
      real(wp), intent(in) :: x
      real(wp) :: h, y
      h = b%s - a%s
      y = 1 - x
      f = y*y*((1 + 2*x)*a%f + x*h*a%slope) + x*x*((1 + 2*y)*b%f - y*h*b%slope)
   end function cubic

end module nutate_event_roots
