!> A system whose parameters have moved by a small part of a sensitivity: for derivatives of the functions of a system
!> by differences along the sensitivity. Changes of effects by their parameters are added to first order.
module nutate_moved_system
   use nutate_body, only: body_t, make_body
   use nutate_variation, only: change_at_start, OF_ORBIT, OF_POTENTIAL, OF_TORQUE, variation_t
   use nutate_kinds, only: wp, eps
   use nutate_potential, only: potential_t
   use nutate_quaternion, only: rotate_to_body
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_torque, only: torque_t
   use nutate_wheel, only: friction_change, wheel_t, axis_change, motor_change
   implicit none
   private

   public :: move_system

   !> A potential with a change of its parameters.
   type, extends(potential_t) :: moved_potential_t
      class(potential_t), allocatable :: base
      !> Change of the `parameters` of `base`.
      real(wp), allocatable :: change(:)
   contains
      procedure :: direction_at => moved_direction
      procedure :: power => moved_power
      procedure :: energy => moved_energy
      procedure :: gradient => moved_gradient
   end type moved_potential_t

   !> A torque with a change of its parameters.
   type, extends(torque_t) :: moved_torque_t
      class(torque_t), allocatable :: base
      !> Change of the `parameters` of `base`.
      real(wp), allocatable :: change(:)
   contains
      procedure :: torque => moved_torque
      procedure :: window => base_window
      procedure :: acts_at => base_acts_at
      procedure :: piece => base_piece
   end type moved_torque_t

contains

   !> Moves the parameters of a system by a part of those of a sensitivity.
   subroutine move_system(system, tangent, m, part, moved)
      type(system_t), intent(in) :: system
      type(tangent_t), intent(in) :: tangent
      !> Index of the parametric sensitivity.
      integer, intent(in) :: m
      !> Part, in units of the sensitivity's parameter; so small that the body remains possible.
      real(wp), intent(in) :: part
      type(system_t), intent(out) :: moved
      type(variation_t) :: variation
      integer :: i, j
      moved = system
      variation = tangent%variations(tangent%parametric(m))
      ! Starts and stops of rates of the inertia do not move.
      if (system%effects%reshapes) then
         variation%mass_moment = 0.0_wp
         variation%mass = 0.0_wp
         call variation%follow_body(system%effects, &
                                    tangent%inertia(:, :, m) - change_at_start(system%effects, variation))
      end if
      associate (effects => moved%effects)
         if (any(abs(tangent%inertia(:, :, m)) > 0.0_wp)) &
            call move_body(system%body, part*tangent%inertia(:, :, m), moved%body)
         effects%rotor_momentum = effects%rotor_momentum + part*variation%rotor
         call effects%turn_frame(part*variation%frame)
         if (.not. allocated(variation%effects)) return
         do i = 1, size(variation%effects)
            associate (item => variation%effects(i), change => part*variation%effects(i)%change)
               select case (item%kind)
               case (OF_POTENTIAL)
                  do j = 1, effects%n_potentials
                     if (effects%potentials(j)%place == item%place) &
                        call move_potential(effects%potentials(j)%item, change)
                  end do
               case (OF_TORQUE)
                  call move_torque(effects%torques(item%place)%item, change)
               case (OF_ORBIT)
                  call effects%orbits(item%place)%shift(change)
                  effects%orbit = effects%orbits(max(1, findloc(effects%orbits%is_main, .true., dim=1)))
               case default
                  call move_wheel(effects%wheels(item%place), change)
               end select
            end associate
         end do
      end associate
   end subroutine move_system

   !> Changes the inertia of a body.
   subroutine move_body(body, change, moved)
      type(body_t), intent(in) :: body
      !> Change of the inertia, kg m²; shape (3,3).
      real(wp), intent(in) :: change(3, 3)
      type(body_t), intent(inout) :: moved
      type(body_t) :: made
      type(status_t) :: status
      call make_body(body%inertia + change, made, status, check_triangle=.false.)
      moved%inertia = made%inertia
      moved%inverse_inertia = made%inverse_inertia
      moved%moments = made%moments
      moved%axes = made%axes
   end subroutine move_body

   subroutine move_potential(item, change)
      class(potential_t), allocatable, intent(inout) :: item
      real(wp), intent(in) :: change(:)
      type(moved_potential_t), allocatable :: moved
      real(wp) :: factors(2)
      allocate (moved)
      moved%moves = item%moves
      moved%pace = item%pace
      factors = item%factor_change(change)
      moved%by_inertia = item%by_inertia + factors(1)
      moved%by_center = item%by_center + factors(2)
      moved%varies = item%varies
      moved%direction = item%direction + item%direction_change(change, 0.0_wp)
      moved%change = change
      call move_alloc(item, moved%base)
      call move_alloc(moved, item)
   end subroutine move_potential

   subroutine move_torque(item, change)
      class(torque_t), allocatable, intent(inout) :: item
      real(wp), intent(in) :: change(:)
      type(moved_torque_t), allocatable :: moved
      ! Runs watch over a controller itself, not over a copy inside of another torque.
      if (item%shift(change)) return
      allocate (moved)
      moved%change = change
      call move_alloc(item, moved%base)
      call move_alloc(moved, item)
   end subroutine move_torque

   subroutine move_wheel(wheel, change)
      type(wheel_t), intent(inout) :: wheel
      real(wp), intent(in) :: change(:)
      wheel%axis = wheel%axis + axis_change(wheel, change)
      wheel%inertia = wheel%inertia + change(4)
      wheel%friction = wheel%friction + friction_change(wheel, change)
      if (size(change) > 6) call move_torque(wheel%motor, motor_change(wheel, change))
   end subroutine move_wheel

   pure function moved_direction(self, t) result(n)
      class(moved_potential_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%base%direction_at(t) + self%base%direction_change(self%change, t)
   end function moved_direction

   !> Returns the power by a central difference over ε^(1/3) of the time in which n moves by its own length: accurate to
   !> 1e-10.
   pure real(wp) function moved_power(self, q, t) result(power)
      class(moved_potential_t), intent(in) :: self
      real(wp), intent(in) :: q(4), t
      real(wp) :: h
      h = eps**(1.0_wp/3)
      if (self%pace > 0.0_wp) h = h/self%pace
      power = (self%energy(rotate_to_body(q, self%direction_at(t + h))) - &
               self%energy(rotate_to_body(q, self%direction_at(t - h))))/(2*h)
   end function moved_power

   pure real(wp) function moved_energy(self, gamma) result(energy)
      class(moved_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      energy = self%base%energy(gamma) + self%base%energy_change(self%change, gamma)
   end function moved_energy

   pure function moved_gradient(self, gamma) result(gradient)
      class(moved_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = self%base%gradient(gamma) + self%base%gradient_change(self%change, gamma, gamma)
   end function moved_gradient

   pure function moved_torque(self, t, q, omega) result(tau)
      class(moved_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = self%base%torque(t, q, omega) + self%base%torque_change(self%change, t, q, omega)
   end function moved_torque

   pure subroutine base_window(self, start, stop)
      class(moved_torque_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      call self%base%window(start, stop)
   end subroutine base_window

   pure logical function base_acts_at(self, t)
      class(moved_torque_t), intent(in) :: self
      real(wp), intent(in) :: t
      base_acts_at = self%base%acts_at(t)
   end function base_acts_at

   pure subroutine base_piece(self, moment, start, stop)
      class(moved_torque_t), intent(in) :: self
      real(wp), intent(in) :: moment
      real(wp), intent(out) :: start, stop
      call self%base%piece(moment, start, stop)
   end subroutine base_piece

end module nutate_moved_system
