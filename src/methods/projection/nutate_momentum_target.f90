!> The conserved components of the space momentum `l` of a run: stores their initial values and restores them in a
!> state.
module nutate_momentum_target
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, ONLY_LENGTH
   use nutate_kinds, only: wp
   use nutate_projection_point, only: projection_point_t
   use nutate_quaternion, only: quat_exp, rotate_to_body
   implicit none
   private

   public :: momentum_target_t

   !> The values of one run. Each call names the components that are conserved, as in `nutate_invariants`.
   type :: momentum_target_t
      !> l, space axes, N m s, shape (3); its component l·n, or else |l|, N m s.
      real(wp) :: momentum(3) = 0.0_wp, component = 0.0_wp
   contains
      !> Stores the values of a point.
      procedure :: set
      !> Rotates l as seen from rotating space axes after some time.
      procedure :: turn
      !> Restores the values in a point.
      procedure :: put
   end type momentum_target_t

contains

   !> Stores the values of a point.
   pure subroutine set(self, components, point)
      class(momentum_target_t), intent(inout) :: self
      integer, intent(in) :: components
      type(projection_point_t), intent(in) :: point
      self%momentum = matmul(point%momentum, point%to_body)
      if (components == ALONG_AXIS) then
         self%component = dot_product(point%momentum, point%gamma)
      else
         self%component = norm2(point%momentum)
      end if
   end subroutine set

   !> Rotates l as seen from rotating space axes after some time: exactly, by -ωt.
   pure subroutine turn(self, frame_rate, since)
      class(momentum_target_t), intent(inout) :: self
      !> ω, rad/s, space axes, shape (3); time, s.
      real(wp), intent(in) :: frame_rate(3), since
      self%momentum = rotate_to_body(quat_exp((0.5_wp*since)*frame_rate), self%momentum)
   end subroutine turn

   !> Restores the values in a point.
   pure subroutine put(self, components, point)
      class(momentum_target_t), intent(in) :: self
      integer, intent(in) :: components
      type(projection_point_t), intent(inout) :: point
      real(wp) :: length
      select case (components)
      case (ALL_COMPONENTS)
         associate (l => self%momentum)
            point%momentum = point%to_body(:, 1)*l(1) + point%to_body(:, 2)*l(2) + point%to_body(:, 3)*l(3)
         end associate
      case (ALONG_AXIS)
         associate (l => point%momentum, gamma => point%gamma)
            l = l + (self%component - (l(1)*gamma(1) + l(2)*gamma(2) + l(3)*gamma(3)))*gamma
         end associate
      case (ONLY_LENGTH)
         length = norm2(point%momentum)
         if (length > 0.0_wp) point%momentum = (self%component/length)*point%momentum
      case default
         return
      end select
   end subroutine put

end module nutate_momentum_target
