!> Motor of a wheel by which a controller acts at all times: it gives its share of the commanded torque.
!>
!> If this share reaches the limit of the motor's torque, the torque stays at the limit until the law commands less. If
!> the wheel reaches the limit of its speed, the motor brakes but does not push. Runs locate these moments.
module nutate_controlled_motor
   use nutate_effect, only: parameter_t, torque_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   use nutate_controller, only: controller_t
   use nutate_effect_traits, only: IS_LAW
   implicit none
   private

   public :: controlled_motor_t

   !> Motor whose torque is component 1.
   type, extends(torque_t) :: controlled_motor_t
      type(controller_t) :: controller = controller_t()
      !> Index of the wheel.
      integer :: wheel = 1
   contains
      procedure :: torque => motor_torque
      procedure :: window => motor_window
      procedure :: parameters => motor_parameters
      procedure :: torque_change => motor_change
      procedure :: follows => motor_follows
      procedure :: thin_table => thin_paths
      procedure :: command
      procedure :: n_limited => one_component
      procedure :: has => has_trait
      procedure :: hold_sense => hold_sense_of_law
      procedure :: shift => shift_law
      procedure :: own_window => no_window_of_its_own
   end type controlled_motor_t

contains

   !> Returns the torque that the control law commands from this motor, before its limit, N m.
   pure function command(self, t, q, omega)
      class(controlled_motor_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space, and Ω relative to the space axes, body axes, rad/s; shapes (4), (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: command(3)
      command = [dot_product(self%controller%share(:, self%wheel), self%controller%law_torque(t, q, omega)), &
                 0.0_wp, 0.0_wp]
   end function command

   pure integer function one_component(self)
      class(controlled_motor_t), intent(in) :: self
      one_component = 1
   end function one_component

   pure logical function has_trait(self, trait)
      class(controlled_motor_t), intent(in) :: self
      integer, intent(in) :: trait
      has_trait = trait == IS_LAW
   end function has_trait

   pure subroutine hold_sense_of_law(self, sense)
      class(controlled_motor_t), intent(inout) :: self
      integer, intent(in) :: sense
      self%sense = sense
      self%controller%sense = sense
   end subroutine hold_sense_of_law

   logical function shift_law(self, change)
      class(controlled_motor_t), intent(inout) :: self
      real(wp), intent(in) :: change(:)
      shift_law = self%controller%shift(change)
   end function shift_law

   !> Returns all times: `start` and `stop` are parameters of the controller.
   pure subroutine no_window_of_its_own(self, start, stop)
      class(controlled_motor_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine no_window_of_its_own

   pure function motor_torque(self, t, q, omega) result(tau)
      class(controlled_motor_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (self%blocked) return
      if (self%saturated(1) /= 0) then
         tau(1) = self%saturated(1)*self%limit
      else
         tau = self%command(t, q, omega)
      end if
   end function motor_torque

   pure subroutine motor_window(self, start, stop)
      class(controlled_motor_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%controller%start
      stop = self%controller%stop
   end subroutine motor_window

   !> Returns the parameters of the controller.
   pure function motor_parameters(self) result(list)
      class(controlled_motor_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = self%controller%parameters()
   end function motor_parameters

   pure function motor_change(self, change, t, q, omega) result(tau)
      class(controlled_motor_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (self%blocked .or. self%saturated(1) /= 0) return
      tau(1) = dot_product(self%controller%share(:, self%wheel), self%controller%law_change(change, t, q, omega))
   end function motor_change

   pure logical function motor_follows(self, path)
      class(controlled_motor_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      motor_follows = self%controller%follows(path)
   end function motor_follows

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_paths(self)
      class(controlled_motor_t), intent(inout) :: self
      call self%controller%thin_table()
   end subroutine thin_paths

end module nutate_controlled_motor
