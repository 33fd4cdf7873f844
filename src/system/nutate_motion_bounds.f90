!> Bounds of a motion over a time: how fast a body can turn and be turned, whatever its attitude.
!>
!> With S² = 2T = ΩᵀJΩ the torques τ change S by no more than |τ|/√J₁, J₁ the least moment; and S bounds Ω and all that
!> Euler's equations make of it. They hold for the exact motion: whoever relies on them for a computed one leaves a
!> margin for its errors.
module nutate_motion_bounds
   use nutate_effect_bounds, only: effect_bounds_t, map_of
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_small_products, only: vector_length
   use nutate_system, only: system_t
   implicit none
   private

   public :: motion_bounds_t, speed_bounds_t, bound_motion

   !> What is known of a system.
   type :: motion_bounds_t
      !> All of its effects have bounds; the others are without meaning else.
      logical :: known = .false.
      !> Greatest torque of the potentials and of all effects but drag, N m; and drag over |Ω|, N m s.
      real(wp) :: potential_torque = 0.0_wp, torque = 0.0_wp, drag = 0.0_wp
      !> Rate of change of the torque that changes fastest with time, 1/s.
      real(wp) :: frequency = 0.0_wp
      !> Roots of the least and the greatest moment, √(kg m²).
      real(wp) :: least_root = 1.0_wp, greatest_root = 1.0_wp
      !> h, body axes, N m s, and its length; shape (3).
      real(wp) :: rotor(3) = 0.0_wp, rotor_size = 0.0_wp
      !> |JΩ×Ω| over S²; √(J⁻¹)ᵢᵢ, and the lengths of the rows of J⁻¹, shape (3).
      real(wp) :: gyration = 0.0_wp, root_inverse(3) = 0.0_wp, rows(3) = 0.0_wp
   contains
      !> What holds over a time.
      procedure :: within
   end type motion_bounds_t

   !> What holds over a time.
   type :: speed_bounds_t
      !> The numbers are of a size that can be computed with; they are without meaning else.
      logical :: known = .false.
      !> S, √J; |Ω|, rad/s; the torque of the potentials and of all effects, N m; |L|, N m s, and |L̇|, body axes, N m.
      real(wp) :: root_energy = 0.0_wp, speed = 0.0_wp, potential_torque = 0.0_wp, torque = 0.0_wp, &
         momentum = 0.0_wp, momentum_rate = 0.0_wp
      !> |Ω| about each axis, rad/s; lengths of the rows of J⁻¹, kg⁻¹ m⁻²; shape (3).
      real(wp) :: axis_speeds(3) = 0.0_wp, rows(3) = 0.0_wp
   end type speed_bounds_t

   !> Squares of what is greater may not be numbers.
   real(wp), parameter :: most = 1e60_wp

contains

   !> The bounds of a system as it is, with the effects that are on.
   pure function bound_motion(system) result(bounds)
      type(system_t), intent(in) :: system
      type(motion_bounds_t) :: bounds
      real(wp), parameter :: unit(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
                                                   0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      !> In the step of length zero, at every attitude.
      real(wp), parameter :: radius = 0.0_wp, slack = 2.0_wp
      type(effect_bounds_t) :: bound, total
      integer :: i
      associate (effects => system%effects, body => system%body)
         do i = 1, effects%n_potentials
            associate (potential => effects%potentials(i)%item)
               call potential%bound(map_of(unit, body%axes), radius, potential%direction, slack, bound)
            end associate
            call total%add(bound)
         end do
         bounds%potential_torque = total%force
         do i = 1, effects%n_torques
            if (.not. effects%torques(i)%item%on) cycle
            call effects%torques(i)%item%bound(map_of(unit, body%axes), radius, unit(:, 1), slack, bound)
            call total%add(bound)
            if (bound%force > 1/most .and. bound%change_rate < most) &
               bounds%frequency = max(bounds%frequency, sqrt(bound%change_rate/bound%force))
         end do
         ! What is seen from space axes that turn moves with them.
         bounds%known = total%known .and. .not. effects%frame_turns
         bounds%torque = total%force
         bounds%drag = total%drag_slope
         bounds%rotor = effects%rotor_momentum
         bounds%rotor_size = vector_length(bounds%rotor)
         bounds%least_root = sqrt(minval(body%moments))
         bounds%greatest_root = sqrt(maxval(body%moments))
         bounds%gyration = gyration_of(body%moments)
         do i = 1, 3
            bounds%root_inverse(i) = sqrt(body%inverse_inertia(i, i))
            bounds%rows(i) = vector_length(body%inverse_inertia(:, i))
         end do
      end associate
   end function bound_motion

   !> Greatest |JΩ×Ω| where ΩᵀJΩ = 1: with the shares x, y, z of that one in the three axes, its component about the
   !> first is 2c√(yz), c = |J₂ - J₃|/(2√(J₂J₃)); the sum of the squares is no more than 4/3 of the greatest c².
   pure real(wp) function gyration_of(moments) result(greatest)
      !> kg m²; shape (3).
      real(wp), intent(in) :: moments(3)
      integer :: i, j, k
      greatest = 0.0_wp
      do i = 1, 3
         j = 1 + modulo(i, 3)
         k = 1 + modulo(i + 1, 3)
         greatest = max(greatest, abs(moments(j) - moments(k))/(2*sqrt(moments(j))*sqrt(moments(k))))
      end do
      greatest = sqrt(4.0_wp/3)*greatest
   end function gyration_of

   !> What holds from a motion on, for a time.
   pure function within(self, motion, time) result(speeds)
      class(motion_bounds_t), intent(in) :: self
      type(motion_t), intent(in) :: motion
      !> s, not negative.
      real(wp), intent(in) :: time
      type(speed_bounds_t) :: speeds
      associate (s => speeds%root_energy, speed => speeds%speed)
         s = sqrt(max(dot_product(motion%omega, motion%momentum - self%rotor), 0.0_wp))
         if (self%torque > 0.0_wp) s = s + self%torque*time/self%least_root
         if (self%drag > 0.0_wp) s = s*exp(min(self%drag*time/self%least_root**2, 100.0_wp))
         speeds%known = self%known .and. s < most .and. s < most*self%least_root
         if (.not. speeds%known) return
         speed = s/self%least_root
         speeds%potential_torque = self%potential_torque
         speeds%torque = self%torque + self%drag*speed
         speeds%momentum = min(s*self%greatest_root + self%rotor_size, &
                               vector_length(motion%momentum) + speeds%torque*time)
         speeds%momentum_rate = self%gyration*s*s + self%rotor_size*speed + speeds%torque
         speeds%axis_speeds = s*self%root_inverse
         speeds%rows = self%rows
      end associate
   end function within

end module nutate_motion_bounds
