"""Units of columns: `#` is a number, `*` any rest. Written by tools/lint/quantities.py."""

UNITS = (
    ("1",
     "q0 q1 q2 q3 norm_error iterations step_residual lvlh_q0 lvlh_q1 lvlh_q2 lvlh_q3 eclipse "
     "controller#_saturations energy_ratio short_axis_mode sense frame#_q0 frame#_q1 frame#_q2 frame#_q3 "
     "megno fli"),
    ("N m s",
     "p0 p1 p2 p3 L1 L2 L3 l_x l_y l_z orthogonality wheel#_momentum"),
    ("rad/s",
     "omega1 omega2 omega3 omega_x omega_y omega_z angular_speed lvlh_omega1 lvlh_omega2 lvlh_omega3 "
     "wheel#_speed sigma_omega#"),
    ("rad",
     "phi theta psi roll pitch yaw true_anomaly sun_angle euler_#_1 euler_#_2 euler_#_3 pointing_error# "
     "pole_longitude pole_latitude frame#_angle sigma_rotation#"),
    ("J",
     "kinetic potential total work energy_residual jacobi time_dependent_work wheel#_motor_work "
     "wheel#_friction_work"),
    ("m",
     "orbit_x orbit_y orbit_z orbit_radius shadow_depth"),
    ("m/s",
     "orbit_speed"),
    ("N m or A m2",
     "controller#_commanded1 controller#_commanded2 controller#_commanded3 controller#_applied1 "
     "controller#_applied2 controller#_applied3"),
    ("T",
     "B1 B2 B3"),
    ("s",
     "precession_period_short precession_period_long rotation_period"),
    ("1/s",
     "lyapunov lyapunov#"),
    ("J",
     "energy_* work_*"),
    ("rad per unit",
     "d_rotation#/d_*"),
    ("rad/s per unit",
     "d_omega#/d_*"),
    ("N m s per unit",
     "d_wheel#_momentum/d_*"),
    ("1",
     "covariance_*"),
)
