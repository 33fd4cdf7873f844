!> Traits that an effect may have (`effect_t%has`).
module nutate_effect_traits
   implicit none
   private

   !> The field of the Earth, and an effect that acts in it.
   integer, parameter, public :: IS_EARTH_FIELD = 1, FOLLOWS_EARTH_FIELD = 2
   !> A controller, one with a target, and one whose command is a moment of magnetorquers.
   integer, parameter, public :: IS_CONTROLLER = 3, IS_POINTING = 4, LIMITS_MOMENT = 5
   !> A controller whose torque the motors of wheels give, and one that acts at all times by these motors, which then
   !> have its parameters.
   integer, parameter, public :: DRIVES_WHEELS = 6, LENDS_PARAMETERS = 7
   !> A motor that a law drives at all times, and a law that jumps with the sign of e₀ at all times.
   integer, parameter, public :: IS_LAW = 8, JUMPS_WITH_SIGN = 9

end module nutate_effect_traits
