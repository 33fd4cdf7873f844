!> Bounds of a motion over a time: limits of the angular velocity and acceleration of a body, for any attitude.
!>
!> With S² = 2T = ΩᵀJΩ the torques τ change S by no more than |τ|/√J₁, J₁ the least moment; constant potentials change
!> S² by no more than twice their range. S bounds Ω and all terms of Euler's equations. In principal axes S and |L|
!> leave the polhodes a range about each axis. The gyroscopic torque about an axis is the product of the speeds about
!> the other two: zero if their moments are equal, and the spin of a symmetric top does not tilt its axis. All bounds
!> hold for the exact motion: a caller that applies them to a computed one leaves a margin for its errors.
module nutate_motion_bounds
   use nutate_body, only: body_t
   use nutate_effect, only: LINEAR_SERIES, potential_t, torque_t
   use nutate_effect_bounds, only: add_bounds, effect_bounds_t, linear_map_t, map_of, spectral_norm
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: most_inner
   use nutate_motion, only: motion_t
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: is_symmetric_about, lies_along, times_columns, times_vector, vector_length
   use nutate_system, only: system_t
   implicit none
   private

   public :: motion_bounds_t, speed_bounds_t, bound_motion

   !> Bounds of a system that hold for every motion.
   type :: motion_bounds_t
      !> All effects of the system have bounds; otherwise the other components have no meaning.
      logical :: known = .false.
      !> Greatest torque of the potentials, of all effects but drag, and of all but drag and potentials, N m; drag
      !> torque over |Ω|, N m s.
      real(wp) :: potential_torque = 0.0_wp, torque = 0.0_wp, applied_torque = 0.0_wp, drag = 0.0_wp
      !> Power of the drag |Ω·τ| over S², 1/s.
      real(wp) :: decay = 0.0_wp
      !> Greatest torque of the potentials that are not linear, N m.
      real(wp) :: curved_torque = 0.0_wp
      !> The potentials depend on the attitude alone; they do so, and the space axes do not rotate.
      logical :: potentials_stand = .true., energy_stands = .true.
      !> Fastest rate of change of a torque or a frame, 1/s; rate of rotation of the space axes, rad/s.
      real(wp) :: frequency = 0.0_wp, frame_speed = 0.0_wp
      !> Roots of the least and the greatest moment, √(kg m²).
      real(wp) :: least_root = 1.0_wp, greatest_root = 1.0_wp
      !> J, body axes, kg m², shape (3,3); h of the rotors, body axes, N m s, shape (3).
      real(wp) :: inertia(3, 3) = 0.0_wp, rotor(3) = 0.0_wp
      !> Number of wheels; u of each, N m, and 1/Jw; shape (most_inner). Sum of u about each body axis, N m; shape (3).
      integer :: n_wheels = 0
      real(wp), dimension(most_inner) :: drives = 0.0_wp, inverse_wheels = 0.0_wp
      real(wp) :: wheel_torques(3) = 0.0_wp
      !> |JΩ×Ω| over S²; √(J⁻¹)ᵢᵢ, and the lengths of the rows of J⁻¹, shape (3).
      real(wp) :: gyration = 0.0_wp, root_inverse(3) = 0.0_wp, rows(3) = 0.0_wp
      !> Torque of all effects but drag about each space axis, N m; shape (3).
      real(wp) :: space_torques(3) = 0.0_wp
      !> The body axes are principal axes, and the moments not too far from each other; otherwise the components below
      !> have no meaning.
      logical :: by_axes = .false.
      !> Moments, kg m²; torques about each body axis: of all effects but drag, of the potentials, N m, and of drag over
      !> |Ω|, N m s; shape (3).
      real(wp), dimension(3) :: moments = 1.0_wp, axis_torques = 0.0_wp, axis_potentials = 0.0_wp, axis_drags = 0.0_wp
      !> |Jⱼ - Jₖ|/Jᵢ; G/(G - Jᵢ) and K/(Jᵢ - K) with G the greatest and K the least moment, 0 if the difference is too
      !> small; shape (3).
      real(wp), dimension(3) :: products = 0.0_wp, below_greatest = 0.0_wp, above_least = 0.0_wp
      !> Axis of a symmetric body, with its rotor along it, without wheels; 0: none.
      integer :: axis = 0
   contains
      !> Returns the greatest increase of S² by the potentials.
      procedure, non_overridable :: room
      !> Returns bounds over a time.
      procedure, non_overridable :: within
   end type motion_bounds_t

   !> Bounds of a motion over a time.
   type :: speed_bounds_t
      !> The numbers are small enough to compute with; otherwise the other components have no meaning.
      logical :: known = .false.
      !> S, √J; |Ω|, rad/s; |L|, N m s.
      real(wp) :: root_energy = 0.0_wp, speed = 0.0_wp, momentum = 0.0_wp
      !> Torque of all effects, N m. Rates of the kinetic, of the potential and of the total energy and of the Jacobi
      !> integral, W; negative: not known.
      real(wp) :: torque = 0.0_wp, kinetic_rate = 0.0_wp, potential_rate = 0.0_wp, total_rate = 0.0_wp, &
         jacobi_rate = 0.0_wp
      !> |Ω| about each axis, rad/s, and across axis 3; |Ω̇|, rad/s², of each component and in all; |L| and |L̇| about
      !> each body axis, N m s and N m, and |l̇| about each space axis; shape (3).
      real(wp), dimension(3) :: axis_speeds = 0.0_wp, accelerations = 0.0_wp, axis_momenta = 0.0_wp, &
         axis_momentum_rates = 0.0_wp, space_torques = 0.0_wp
      real(wp) :: tilting = 0.0_wp, acceleration = 0.0_wp
      !> Rate of rotation of the space axes, rad/s, by which rates relative to them may be larger.
      real(wp) :: frame_speed = 0.0_wp
      !> |ḣ| of each wheel, N m, and rate of its speed, rad/s²; shape (most_inner).
      real(wp), dimension(most_inner) :: drives = 0.0_wp, wheel_rates = 0.0_wp
   end type speed_bounds_t

   !> Largest values: squares of larger ones may overflow, and so may products with larger ratios.
   real(wp), parameter :: most = 1e60_wp, most_ratio = 1e6_wp, most_exponent = 100.0_wp
   !> Margins for the errors of a computed motion: of S² and |L|² in their difference, and of the speed across an axis
   !> relative to the whole speed.
   real(wp), parameter :: slack_of_squares = 0.02_wp, slack_of_speed = 1e-3_wp

   !> Arguments of `bound` for a step of length zero, and for every attitude.
   real(wp), parameter :: at_once = 0.0_wp, any_attitude = 2.0_wp

contains

   !> Returns the bounds of a system in its present configuration, with the effects that are on.
   pure function bound_motion(system) result(bounds)
      type(system_t), intent(in) :: system
      type(motion_bounds_t) :: bounds
      type(effect_bounds_t) :: potentials, others
      type(linear_map_t) :: whole
      integer :: i
      associate (effects => system%effects, body => system%body)
         whole = map_of(onto([1, 2, 3]), body%axes)
         do i = 1, effects%n_potentials
            call add_potential(effects%potentials(i)%item, whole, bounds, potentials)
         end do
         do i = 1, effects%n_torques
            if (effects%torques(i)%item%on) call add_torque(effects%torques(i)%item, body, whole, bounds, others)
         end do
         call add_wheels(system, whole, bounds, others)
         bounds%known = potentials%known .and. others%known
         if (effects%frame_turns) bounds%frame_speed = vector_length(effects%frame_rate)
         bounds%frequency = maxval([bounds%frequency, (effects%frames(i)%fastest, i=1, effects%n_frames)])
         bounds%energy_stands = bounds%potentials_stand .and. .not. effects%frame_turns
         bounds%drag = others%drag_slope
         bounds%potential_torque = potentials%force
         ! Drag against rotating axes also acts on a body at rest, by no more than the drag times their rate.
         bounds%applied_torque = others%force + bounds%drag*bounds%frame_speed
         bounds%torque = bounds%potential_torque + bounds%applied_torque
         bounds%inertia = body%inertia
         bounds%rotor = effects%rotor_momentum
         bounds%moments = body%moments
         bounds%least_root = sqrt(minval(body%moments))
         bounds%greatest_root = sqrt(maxval(body%moments))
         bounds%gyration = gyration_of(body%moments)
         do i = 1, 3
            bounds%root_inverse(i) = sqrt(body%inverse_inertia(i, i))
            bounds%rows(i) = vector_length(body%inverse_inertia(:, i))
         end do
         if (bounds%known) call bound_axes(system, bounds)
      end associate
   end function bound_motion

   !> Adds a torque. The drag of a torque -DΩ has a power of no more than ‖√J⁻¹ D √J⁻¹‖ S².
   pure subroutine add_torque(torque, body, whole, bounds, total)
      class(torque_t), intent(in) :: torque
      type(body_t), intent(in) :: body
      type(linear_map_t), intent(in) :: whole
      type(motion_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t), intent(inout) :: total
      type(effect_bounds_t) :: bound
      real(wp) :: root(3, 3)
      call torque%bound(whole, at_once, whole%matrix(:, 1), any_attitude, bound)
      call add_bounds(total, bound)
      bounds%space_torques = bounds%space_torques + bound%force
      if (bound%force > 1/most .and. bound%change_rate < most) &
         bounds%frequency = max(bounds%frequency, sqrt(bound%change_rate/bound%force))
      if (.not. bound%drag_slope > 0.0_wp) return
      if (torque%series_kind() == LINEAR_SERIES) then
         root = inverse_root(body)
         bounds%decay = bounds%decay + spectral_norm(times_columns(root, times_columns(torque%series_drag(), root)))
      else
         bounds%decay = bounds%decay + bound%drag_slope/minval(body%moments)
      end if
   end subroutine add_torque

   !> Returns √J⁻¹, body axes, 1/√(kg m²); shape (3,3).
   pure function inverse_root(body) result(root)
      type(body_t), intent(in) :: body
      real(wp) :: root(3, 3)
      integer :: j, k
      root = 0.0_wp
      do k = 1, 3
         do j = 1, 3
            root(:, j) = root(:, j) + (body%axes(j, k)/sqrt(body%moments(k)))*body%axes(:, k)
         end do
      end do
   end function inverse_root

   !> Adds the torques of the wheels' motors on the body; they do not change the total momentum. Friction, which depends
   !> on the speeds of the wheels, has no bound here.
   pure subroutine add_wheels(system, whole, bounds, total)
      type(system_t), intent(in) :: system
      type(linear_map_t), intent(in) :: whole
      type(motion_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t), intent(inout) :: total
      type(effect_bounds_t) :: bound
      integer :: i
      bounds%n_wheels = system%effects%n_wheels
      do i = 1, bounds%n_wheels
         associate (wheel => system%effects%wheels(i))
            bound = effect_bounds_t(force=abs(wheel%command), known=.not. wheel%friction > 0.0_wp)
            if (allocated(wheel%motor)) call wheel%motor%bound(whole, at_once, wheel%axis, any_attitude, bound)
            bound%known = bound%known .and. .not. wheel%friction > 0.0_wp .and. .not. bound%drag_slope > 0.0_wp .and. &
                          wheel%component == 0
            call add_bounds(total, bound)
            bounds%drives(i) = bound%force
            bounds%inverse_wheels(i) = 1/wheel%inertia
            bounds%wheel_torques = bounds%wheel_torques + bound%force*abs(wheel%axis)
         end associate
      end do
   end subroutine add_wheels

   !> Adds a potential: it has no torque about its own direction.
   pure subroutine add_potential(potential, whole, bounds, total)
      class(potential_t), intent(in) :: potential
      type(linear_map_t), intent(in) :: whole
      type(motion_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t), intent(inout) :: total
      type(effect_bounds_t) :: bound
      integer :: k
      call potential%bound(whole, at_once, potential%direction, any_attitude, bound)
      bound%known = bound%known .and. .not. potential%varies
      call add_bounds(total, bound)
      bounds%potentials_stand = bounds%potentials_stand .and. .not. (potential%moves .or. potential%varies)
      if (potential%series_kind() /= LINEAR_SERIES) bounds%curved_torque = bounds%curved_torque + bound%force
      do k = 1, 3
         if (potential%moves .or. .not. lies_along(potential%direction, k)) &
            bounds%space_torques(k) = bounds%space_torques(k) + bound%force
      end do
   end subroutine add_potential

   !> Computes the bounds about each axis of a body whose body axes are principal axes.
   pure subroutine bound_axes(system, bounds)
      type(system_t), intent(in) :: system
      type(motion_bounds_t), intent(inout) :: bounds
      type(effect_bounds_t) :: bound
      type(linear_map_t) :: part
      real(wp) :: greatest, least
      integer :: i, k
      associate (body => system%body, effects => system%effects, moments => system%body%moments)
         greatest = maxval(moments)
         least = minval(moments)
         bounds%by_axes = greatest <= most_ratio*least .and. all([(lies_along(body%inertia(:, i), i), i=1, 3)])
         if (.not. bounds%by_axes) return
         do i = 1, 3
            part = map_of(onto([i]), body%axes)
            do k = 1, effects%n_potentials
               associate (potential => effects%potentials(k)%item)
                  if (potential%has_axis(i)) cycle
                  call potential%bound(part, at_once, potential%direction, any_attitude, bound)
               end associate
               bounds%axis_potentials(i) = bounds%axis_potentials(i) + bound%force
            end do
            bounds%axis_torques(i) = bounds%axis_potentials(i)
            do k = 1, effects%n_torques
               if (.not. effects%torques(k)%item%on) cycle
               call effects%torques(k)%item%bound(part, at_once, part%matrix(:, i), any_attitude, bound)
               bounds%axis_torques(i) = bounds%axis_torques(i) + bound%force
               bounds%axis_drags(i) = bounds%axis_drags(i) + bound%drag_slope
            end do
            bounds%axis_torques(i) = bounds%axis_torques(i) + bounds%wheel_torques(i) + &
                                     bounds%axis_drags(i)*bounds%frame_speed
            bounds%products(i) = abs(moments(1 + modulo(i, 3)) - moments(1 + modulo(i + 1, 3)))/moments(i)
            if (greatest - moments(i) > greatest/most_ratio) bounds%below_greatest(i) = greatest/(greatest - moments(i))
            if (moments(i) - least > least/most_ratio) bounds%above_least(i) = least/(moments(i) - least)
            if (is_symmetric_about(body%inertia, i) .and. lies_along(bounds%rotor, i) .and. &
                effects%n_wheels == 0 .and. bounds%axis == 0) bounds%axis = i
         end do
      end associate
   end subroutine bound_axes

   !> Returns the projection onto some of the axes; shape (3,3).
   pure function onto(axes) result(matrix)
      integer, intent(in) :: axes(:)
      real(wp) :: matrix(3, 3)
      integer :: i
      matrix = 0.0_wp
      do i = 1, size(axes)
         matrix(axes(i), axes(i)) = 1.0_wp
      end do
   end function onto

   !> Returns the greatest |JΩ×Ω| where ΩᵀJΩ = 1: with the shares x, y, z of ΩᵀJΩ in the three axes, its component about
   !> the first is 2c√(yz), c = |J₂ - J₃|/(2√(J₂J₃)); the sum of the squares is no more than 4/3 of the greatest c².
   pure real(wp) function gyration_of(moments) result(greatest)
      !> Principal moments, kg m²; shape (3).
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

   !> Returns the greatest increase of S² by the potentials from a motion on, J: twice their energy above its least
   !> value. This energy is known for a linear potential; for others it is no more than half a revolution against the
   !> greatest torque.
   pure real(wp) function room(self, system, motion)
      class(motion_bounds_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: moment(3), scale
      integer :: i
      room = huge(room)
      if (.not. (self%known .and. self%energy_stands)) return
      room = 2*pi*self%curved_torque
      associate (effects => system%effects, q => motion%state%q)
         if (effects%n_potentials > 0) scale = 1/(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
         do i = 1, effects%n_potentials
            associate (potential => effects%potentials(i)%item)
               if (potential%series_kind() /= LINEAR_SERIES) cycle
               moment = potential%series_moment()
               room = room + 2*max(vector_length(moment)*vector_length(potential%direction) - &
                                   scale*dot_product(moment, rotate_to_body(q, potential%direction)), 0.0_wp)
            end associate
         end do
      end associate
   end function room

   !> Returns bounds from a motion on, for a time, forward or backward. Torques F change S by no more than F/√J₁, and
   !> drag by no more than a part d of it in a unit of time, so that S grows by no more than the factor e^(dt) after
   !> Ft/√J₁ were added to it (Grönwall). |L| is no more than √J₃ S + |h|, and changes by no more than the torques.
   pure function within(self, motion, room, time) result(speeds)
      class(motion_bounds_t), intent(in) :: self
      type(motion_t), intent(in) :: motion
      !> Increase of S² that `room` returned, J.
      real(wp), intent(in) :: room
      !> Time, s, not negative.
      real(wp), intent(in) :: time
      type(speed_bounds_t) :: speeds
      real(wp) :: start, growth, exponent, spin(3), inner(3)
      associate (s => speeds%root_energy, speed => speeds%speed)
         spin = times_vector(self%inertia, motion%omega)
         start = sqrt(max(dot_product(motion%omega, spin), 0.0_wp))
         exponent = self%decay*time
         speeds%known = self%known .and. exponent < most_exponent
         if (.not. speeds%known) return
         growth = 1.0_wp
         if (exponent > 0.0_wp) growth = exp(exponent)
         s = growth*reached(self, start, time, room)
         speeds%known = s < most .and. s < most*self%least_root
         if (.not. speeds%known) return
         speed = s/self%least_root
         speeds%torque = self%torque + self%drag*speed
         inner = abs(self%rotor)
         if (self%n_wheels > 0) inner = abs(motion%momentum - spin) + self%wheel_torques*time
         speeds%momentum = min(s*self%greatest_root + vector_length(inner), &
                               vector_length(motion%momentum) + speeds%torque*time)
         if (self%by_axes) then
            call bound_by_axes(self, motion, inner, room, time, start, growth, speeds)
         else
            call bound_at_large(self, inner, speeds)
         end if
         speeds%frame_speed = self%frame_speed
         speeds%space_torques = self%space_torques + self%drag*(speed + self%frame_speed)
         if (self%n_wheels == 0) then
            call bound_energies(self, speeds)
         else
            speeds%drives = self%drives
            speeds%wheel_rates = self%inverse_wheels*self%drives + speeds%acceleration
            speeds%kinetic_rate = -1.0_wp
            speeds%total_rate = -1.0_wp
            speeds%jacobi_rate = -1.0_wp
         end if
         speeds%potential_rate = speeds%potential_rate + self%frame_speed*self%potential_torque
         if (.not. self%potentials_stand) speeds%potential_rate = -1.0_wp
      end associate
   end function within

   !> Bounds the rates of the energy and of the Jacobi integral H - ω·l, to which constant potentials add nothing. For
   !> the energy: the power Ω·τ of the torques, and ω·τ of the potentials in axes that rotate at ω. For the Jacobi
   !> integral: (Ω - ω)·τ.
   pure subroutine bound_energies(self, speeds)
      class(motion_bounds_t), intent(in) :: self
      type(speed_bounds_t), intent(inout) :: speeds
      real(wp) :: applied
      applied = self%applied_torque + self%drag*speeds%speed
      speeds%total_rate = speeds%speed*applied + self%frame_speed*self%potential_torque
      speeds%jacobi_rate = (speeds%speed + self%frame_speed)*applied
      if (self%potentials_stand) return
      speeds%total_rate = -1.0_wp
      speeds%jacobi_rate = -1.0_wp
   end subroutine bound_energies

   !> Returns an upper bound of √(2E) after a time, E a kinetic energy: it changes by no more than |τ|/√J₁. With U the
   !> potentials above their least value, √(2E + 2U) changes by no more than the other torques allow, and 2U is no more
   !> than `room` at first.
   pure real(wp) function reached(self, start, time, room) result(root)
      class(motion_bounds_t), intent(in) :: self
      !> Initial √(2E), √J.
      real(wp), intent(in) :: start
      !> Time, s.
      real(wp), intent(in) :: time
      !> Greatest increase of 2E by the potentials, J; huge: bounded by their torques alone.
      real(wp), intent(in) :: room
      root = start
      if (self%torque > 0.0_wp) root = start + self%torque*time/self%least_root
      if (room < most) root = min(root, sqrt(start*start + room) + self%applied_torque*time/self%least_root)
   end function reached

   !> Computes the bounds that follow from S in any axes: Ωᵢ = eᵢ·√J⁻¹(√JΩ), and JΩ̇ = L×Ω + τ with a part JΩ×Ω of L×Ω.
   pure subroutine bound_at_large(self, inner, speeds)
      class(motion_bounds_t), intent(in) :: self
      !> |h| of rotors and wheels, N m s; shape (3).
      real(wp), intent(in) :: inner(3)
      !> Bounds of which S, speed, torque and momentum are set.
      type(speed_bounds_t), intent(inout) :: speeds
      real(wp) :: momentum_rate
      associate (s => speeds%root_energy, speed => speeds%speed)
         momentum_rate = self%gyration*s*s + vector_length(inner)*speed + speeds%torque
         speeds%axis_speeds = s*self%root_inverse
         speeds%tilting = sqrt(speeds%axis_speeds(1)**2 + speeds%axis_speeds(2)**2)
         speeds%accelerations = self%rows*momentum_rate
         ! The norm of a matrix is no more than √3 times the longest of its rows.
         speeds%acceleration = 2*maxval(self%rows)*momentum_rate
         speeds%axis_momenta = speeds%momentum
         speeds%axis_momentum_rates = momentum_rate
         speeds%kinetic_rate = speed*speeds%torque
         speeds%potential_rate = speed*self%potential_torque
      end associate
   end subroutine bound_at_large

   !> Computes the bounds in principal axes: JᵢΩ̇ᵢ = (Jⱼ - Jₖ)ΩⱼΩₖ + (h×Ω)ᵢ + τᵢ, and 2√(JⱼJₖ)|ΩⱼΩₖ| ≤ S². In a
   !> symmetric body no gyroscopic torque does work on the rotation across its axis, whose energy has the bound of
   !> `reached`: with `room` for potentials without torque about the axis, otherwise with all that their torques can do.
   pure subroutine bound_by_axes(self, motion, inner, room, time, start, growth, speeds)
      class(motion_bounds_t), intent(in) :: self
      type(motion_t), intent(in) :: motion
      !> |h| of rotors and wheels, N m s; shape (3).
      real(wp), intent(in) :: inner(3)
      !> Greatest increase of S² by the potentials, J.
      real(wp), intent(in) :: room
      !> Time, s; S at first; its growth by drag.
      real(wp), intent(in) :: time, start, growth
      !> Bounds of which S, speed, torque and momentum are set.
      type(speed_bounds_t), intent(inout) :: speeds
      real(wp) :: across
      integer :: i, j, k
      associate (s => speeds%root_energy, w => speeds%axis_speeds, rate => speeds%accelerations, axis => self%axis)
         w = s*self%root_inverse
         if (.not. any(inner > 0.0_wp)) call bound_polhode(self, motion, time, start, growth, speeds)
         across = huge(across)
         if (axis > 0) then
            j = 1 + modulo(axis, 3)
            k = 1 + modulo(axis + 1, 3)
            across = reached(self, sqrt(self%moments(j)*(motion%omega(j)**2 + motion%omega(k)**2)), time, &
                             merge(huge(room), room, self%axis_potentials(axis) > 0.0_wp))
            ! Drag against the spin may accelerate the rotation across the axis.
            if (self%drag > 0.0_wp) across = across + self%drag*speeds%speed*time/self%least_root
            across = across*self%root_inverse(j) + slack_of_speed*speeds%speed
            w(j) = min(w(j), across)
            w(k) = min(w(k), across)
         end if
         do i = 1, 3
            j = 1 + modulo(i, 3)
            k = 1 + modulo(i + 1, 3)
            rate(i) = self%products(i)*min(w(j)*w(k), 0.5_wp*(s*self%root_inverse(j))*(s*self%root_inverse(k))) + &
                      (inner(j)*w(k) + inner(k)*w(j) + &
                       self%axis_torques(i) + self%axis_drags(i)*speeds%speed)/self%moments(i)
         end do
         w = min(w, abs(motion%omega) + rate*time + slack_of_speed*speeds%speed)
         speeds%speed = min(speeds%speed, sqrt(w(1)*w(1) + w(2)*w(2) + w(3)*w(3)))
         speeds%tilting = sqrt(w(1)*w(1) + w(2)*w(2))
         if (axis == 3) speeds%tilting = min(speeds%tilting, across)
         speeds%acceleration = sqrt(rate(1)*rate(1) + rate(2)*rate(2) + rate(3)*rate(3))
         speeds%axis_momenta = min(speeds%momentum, self%moments*w + inner)
         speeds%axis_momentum_rates = self%moments*rate + self%wheel_torques
         speeds%kinetic_rate = min(speeds%speed*speeds%torque, &
                                   dot_product(w, self%axis_torques + self%axis_drags*speeds%speed))
         speeds%potential_rate = min(speeds%speed*self%potential_torque, dot_product(w, self%axis_potentials))
      end associate
   end subroutine bound_by_axes

   !> Bounds the speed about each axis by S and |L|: Σ Jᵢ(c - Jᵢ)Ωᵢ² = cS² - |L|² has terms of one sign if c is the
   !> greatest moment, or the least, so that none is more than the sum. The bound requires the least S, which falls by
   !> no more than e^(-dt) and then Ft/√J₁, and the least |L|.
   pure subroutine bound_polhode(self, motion, time, start, growth, speeds)
      class(motion_bounds_t), intent(in) :: self
      type(motion_t), intent(in) :: motion
      !> Time, s; S at first; its growth by drag.
      real(wp), intent(in) :: time, start, growth
      !> Bounds of which S, speed, torque, momentum and speeds about the axes are set.
      type(speed_bounds_t), intent(inout) :: speeds
      real(wp) :: least_s, least_l, high, low
      integer :: i
      associate (s => speeds%root_energy, w => speeds%axis_speeds)
         least_s = max(start/growth - self%torque*time/self%least_root, 0.0_wp)
         least_l = max(vector_length(motion%momentum) - speeds%torque*time, 0.0_wp)
         ! Sums over the greatest moment, and over the least.
         high = max((1 + slack_of_squares)*s*s - (least_l/self%greatest_root)**2, 0.0_wp)
         low = max((1 + slack_of_squares)*(speeds%momentum/self%least_root)**2 - least_s*least_s, 0.0_wp)
         do i = 1, 3
            associate (below => self%below_greatest(i), above => self%above_least(i))
               if (below > 0.0_wp) w(i) = min(w(i), self%root_inverse(i)*sqrt(below*high))
               if (above > 0.0_wp) w(i) = min(w(i), self%root_inverse(i)*sqrt(above*low))
            end associate
         end do
      end associate
   end subroutine bound_polhode

end module nutate_motion_bounds
