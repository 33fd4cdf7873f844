!> The non-spinning (Resal) frame of a symmetric body.
!>
!> The frame exists if two moments are equal, J₁ across the body axis a and Jₐ along it, and every effect is symmetric
!> about a. The axes coincide with those of the body at some time and then rotate at the rate `L/J₁`. In them
!>
!>     L' = τ,   γ' = γ×L/J₁,
!>
!> since `Ω - L/J₁` lies along a: the body rotates in the frame about its axis by the angle φ with the rate
!> `φ' = (Lₐ - h)/Jₐ - Lₐ/J₁`, with a rotor h along the axis. τ is the same function of γ, Ω and t as in body axes. No
!> products of Euler's are left, and no fast rotation: if Lₐ is constant φ grows evenly, and all else changes as slowly
!> as the axis moves.
module nutate_axial_frame
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_product
   use nutate_small_products, only: is_symmetric_about, lies_along
   use nutate_system, only: system_t
   implicit none
   private

   public :: axial_frame_t

   !> The frame of a system, if it has one.
   type :: axial_frame_t
      !> Body axis about which the body and all effects are symmetric: 1, 2 or 3; 0: there is none.
      integer :: axis = 0
      !> 1/J₁ and 1/Jₐ, kg⁻¹ m⁻²; h along the axis, N m s.
      real(wp) :: inverse_across = 0.0_wp, inverse_along = 0.0_wp, rotor = 0.0_wp
   contains
      !> Finds the axis of a system.
      procedure :: recognise
      !> Returns the rate at which the body rotates in the frame.
      procedure :: spin
      !> Returns the body components of a vector from its components in the frame.
      procedure :: to_body
      !> Returns the attitude of the body from that of the frame.
      procedure :: turn
   end type axial_frame_t

contains

   !> Finds the axis about which body and effects are symmetric, to the last bit: for a body that is only nearly
   !> symmetric, the frame would not give its motion. If there are several axes, the first one is used.
   pure subroutine recognise(self, system)
      class(axial_frame_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      integer :: axis
      self%axis = 0
      do axis = 1, 3
         if (.not. has_axis(system, axis)) cycle
         self%axis = axis
         self%inverse_along = system%body%inverse_inertia(axis, axis)
         self%inverse_across = system%body%inverse_inertia(1 + modulo(axis, 3), 1 + modulo(axis, 3))
         self%rotor = system%effects%rotor_momentum(axis)
         return
      end do
   end subroutine recognise

   !> Returns true if an axis is one of symmetry of the body and of every effect.
   pure logical function has_axis(system, axis)
      type(system_t), intent(in) :: system
      integer, intent(in) :: axis
      integer :: i
      associate (body => system%body, effects => system%effects)
         has_axis = is_symmetric_about(body%inverse_inertia, axis) .and. is_symmetric_about(body%inertia, axis) .and. &
                    lies_along(effects%rotor_momentum, axis) .and. effects%n_wheels == 0
         do i = 1, effects%n_potentials
            if (has_axis) has_axis = effects%potentials(i)%item%has_axis(axis) .and. .not. &
                                     effects%potentials(i)%item%varies
         end do
         do i = 1, effects%n_torques
            if (has_axis) has_axis = effects%torques(i)%item%has_axis(axis)
         end do
      end associate
   end function has_axis

   !> Returns φ', rad/s: (Lₐ - h)/Jₐ - Lₐ/J₁.
   pure real(wp) function spin(self, momentum)
      class(axial_frame_t), intent(in) :: self
      !> Lₐ, N m s.
      real(wp), intent(in) :: momentum
      spin = (momentum - self%rotor)*self%inverse_along - momentum*self%inverse_across
   end function spin

   !> Returns the body components of a vector; shape (3).
   pure function to_body(self, angle, v) result(rotated)
      class(axial_frame_t), intent(in) :: self
      !> φ, rad.
      real(wp), intent(in) :: angle
      !> Components in the frame; shape (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: rotated(3), c, s
      integer :: i, j
      i = 1 + modulo(self%axis, 3)
      j = 1 + modulo(self%axis + 1, 3)
      c = cos(angle)
      s = sin(angle)
      rotated(self%axis) = v(self%axis)
      rotated(i) = c*v(i) + s*v(j)
      rotated(j) = c*v(j) - s*v(i)
   end function to_body

   !> Returns q of the body: the attitude of the frame, rotated about the axis; shape (4).
   pure function turn(self, angle, q) result(rotated)
      class(axial_frame_t), intent(in) :: self
      !> φ, rad.
      real(wp), intent(in) :: angle
      !> Attitude of the frame, frame→space; shape (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: rotated(4), about(4)
      about = 0.0_wp
      about(1) = cos(0.5_wp*angle)
      about(1 + self%axis) = sin(0.5_wp*angle)
      rotated = quat_product(q, about)
   end function turn

end module nutate_axial_frame
