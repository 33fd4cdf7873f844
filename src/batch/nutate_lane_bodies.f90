!> Bodies that are moved together, each in a lane: what a method is to those who run them.
module nutate_lane_bodies
   use nutate_lane_width, only: lanes
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: lane_bodies_t

   !> The bodies.
   type, abstract :: lane_bodies_t
      !> The lane has a body, which has not been given up.
      logical :: taken(lanes) = .false.
   contains
      !> Puts a body into a lane.
      procedure(put_body), deferred :: put
      !> One step of all bodies.
      procedure(step_bodies), deferred :: step
      !> Makes the bodies fit to be seen; one that cannot be is given up. The steps that follow do not notice.
      procedure :: look => leave_bodies
      !> Where a body is.
      procedure(get_body), deferred :: get
   end type lane_bodies_t

   abstract interface
      !> Puts a body into a lane, before the first step; it is not `taken` where lanes do not know what acts on it, or
      !> its numbers are out of a lane's range.
      subroutine put_body(self, lane, system, state)
         import :: lane_bodies_t, system_t, state_t
         !> Set up.
         class(lane_bodies_t), intent(inout) :: self
         !> 1 to `lanes`.
         integer, intent(in) :: lane
         !> One that lanes can move.
         type(system_t), intent(in) :: system
         !> |q| = 1 and q·p = 0.
         type(state_t), intent(in) :: state
      end subroutine put_body

      pure subroutine step_bodies(self)
         import :: lane_bodies_t
         class(lane_bodies_t), intent(inout) :: self
      end subroutine step_bodies

      !> As it is to be seen where `look` was called after the last step. Its time is not touched.
      pure subroutine get_body(self, lane, state)
         import :: lane_bodies_t, state_t
         class(lane_bodies_t), intent(in) :: self
         !> 1 to `lanes`, taken.
         integer, intent(in) :: lane
         type(state_t), intent(inout) :: state
      end subroutine get_body
   end interface

contains

   !> For methods whose steps leave bodies as they are to be seen.
   pure subroutine leave_bodies(self)
      class(lane_bodies_t), intent(inout) :: self
   end subroutine leave_bodies

end module nutate_lane_bodies
