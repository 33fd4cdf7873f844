"""Units of columns: `#` is a number, `*` any rest. Written by tools/lint/quantities.py."""

UNITS = (
    ("1", "q# norm_error iterations step_residual lvlh_q# eclipse controller#_saturations energy_ratio "
     "short_axis_mode sense frame#_q# megno fli"),
    ("N m s", "p# L# l_x l_y l_z orthogonality wheel#_momentum"),
    ("rad/s", "omega# omega_x omega_y omega_z angular_speed lvlh_omega# wheel#_speed sigma_omega#"),
    ("rad", "phi theta psi roll pitch yaw true_anomaly sun_angle euler_#_# pointing_error# pole_longitude "
     "pole_latitude frame#_angle sigma_rotation#"),
    ("J", "kinetic potential total work energy_residual jacobi time_dependent_work wheel#_motor_work "
     "wheel#_friction_work"),
    ("m", "orbit_x orbit_y orbit_z orbit_radius shadow_depth"),
    ("m/s", "orbit_speed"),
    ("N m or A m2", "controller#_commanded# controller#_applied#"),
    ("T", "B#"),
    ("s", "precession_period_short precession_period_long rotation_period"),
    ("1/s", "lyapunov lyapunov#"),
    ("J", "energy_* work_*"),
    ("rad per unit", "d_rotation#/d_*"),
    ("rad/s per unit", "d_omega#/d_*"),
    ("N m s per unit", "d_wheel#_momentum/d_*"),
    ("1", "covariance_*"),
)
