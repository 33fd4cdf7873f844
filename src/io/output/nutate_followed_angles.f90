!> Euler angles of any of the twelve sequences, followed from state to state so that no revolution is lost.
!>
!> A sequence of the axes i, j, k means R = R_i(α) R_j(β) R_k(γ): rotations about the axes of the body, the first one
!> last. Every sequence is that of z-x-z in other axes, so that one set of formulas serves all. With l the axis that is
!> neither i nor j, and e = 1 if i, j, l are in cyclic order, else -1, the axes j, e·l, i of both space and body are
!> right-handed and replace 1, 2, 3. In these axes i-j-i is z-x-z, and i-j-l, which ends in a rotation by e·γ about
!> axis 2, is z-x-z in a body rotated by π/2 about axis 1 before, with the angles α, β + π/2, -e·γ:
!> R₂(eγ) = R₁(π/2) R₃(-eγ) R₁(-π/2).
module nutate_followed_angles
   use nutate_archive, only: archive_t
   use nutate_attitude, only: euler_of_motion, follow_euler, quat_from_euler
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: quat_product
   implicit none
   private

   public :: followed_angles_t

   !> The angles of a sequence, including complete revolutions.
   type :: followed_angles_t
      private
      !> The axes j, l, i that replace 1, 2, 3, and the sign e of the second.
      integer :: axes(3) = [1, 2, 3], sense = 1
      !> True if the last axis is the first again.
      logical :: proper = .true.
      !> Angles of z-x-z in those axes, rad.
      real(wp) :: phi = 0.0_wp, theta = 0.0_wp, psi = 0.0_wp
      !> Sign of the quaternion of these angles: 1 if it is that of the body, -1 if it is the negative.
      real(wp) :: side = 1.0_wp
   contains
      !> Starts with the first state.
      procedure :: start
      !> Follows the next state.
      procedure :: follow
      !> Returns the three angles.
      procedure :: angles
      !> Writes or reads the angles in checkpoint data.
      procedure :: transfer
   end type followed_angles_t

contains

   !> Starts with the first state. At a pole, where the angles are not unique, the procedure chooses the angles from
   !> which the motion continues.
   pure subroutine start(self, sequence, q, omega)
      class(followed_angles_t), intent(inout) :: self
      !> The axes as three digits, neighbours different, such as `313` or `321`.
      character(len=*), intent(in) :: sequence
      !> Attitude, body to space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Angular velocity in the direction of the motion to come, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      real(wp) :: rate(3)
      integer :: first, second
      first = index('123', sequence(1:1))
      second = index('123', sequence(2:2))
      self%axes = [second, 6 - first - second, first]
      self%sense = merge(1, -1, modulo(second - first, 3) == 1)
      self%proper = sequence(3:3) == sequence(1:1)
      rate = omega(self%axes)*[1, self%sense, 1]
      if (.not. self%proper) rate = [rate(1), rate(3), -rate(2)]
      call euler_of_motion(in_own_axes(self, q), rate, self%phi, self%theta, self%psi)
      self%side = sign(1.0_wp, dot_product(in_own_axes(self, q), quat_from_euler(self%phi, self%theta, self%psi)))
   end subroutine start

   !> Follows the next state: revolutions about the first and the last axis are counted if the state before was less
   !> than a revolution away.
   pure subroutine follow(self, q)
      class(followed_angles_t), intent(inout) :: self
      !> Attitude, body to space, of the sign that continues the one before; shape (4).
      real(wp), intent(in) :: q(4)
      call follow_euler(self%side*in_own_axes(self, q), self%phi, self%theta, self%psi)
   end subroutine follow

   !> Returns the three angles, rad, in the order of the sequence; shape (3). The second is in [0, π] if the last axis
   !> is the first, else in [-π/2, π/2].
   pure function angles(self)
      class(followed_angles_t), intent(in) :: self
      real(wp) :: angles(3)
      angles = [self%phi, self%theta, self%psi]
      if (.not. self%proper) angles = [self%phi, self%theta - 0.5_wp*pi, -self%sense*self%psi]
   end function angles

   !> Returns the attitude in the axes of z-x-z; shape (4).
   pure function in_own_axes(self, q) result(own)
      class(followed_angles_t), intent(in) :: self
      real(wp), intent(in) :: q(4)
      real(wp) :: own(4)
      own = [q(1), q(1 + self%axes)*[1, self%sense, 1]]
      if (.not. self%proper) own = quat_product(own, sqrt(0.5_wp)*[1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp])
   end function in_own_axes

   !> Writes or reads the angles in checkpoint data; `start` sets the other components.
   subroutine transfer(self, archive)
      class(followed_angles_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%phi)
      call archive%transfer(self%theta)
      call archive%transfer(self%psi)
   end subroutine transfer

end module nutate_followed_angles
