"""A box tumbling about its intermediate axis comes to spin about the axis of its largest moment: a torque of Python's own
takes its energy. Draws damped_box.png."""

import matplotlib
import numpy as np

import nutate

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def friction(t, q, omega):
    """Friction against the spin about axis 1, N m."""
    return np.array([-0.4 * omega[0], 0.0, 0.0])


box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
box.add_user_torque(friction)
stepper = nutate.Stepper(box, order=4, formulation="reduced", time_step=0.05)
stepper.set_columns("angular_velocity", "energy")
stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0, 3))
rows = stepper.run(4000, every=4)

figure, (rates, energies) = plt.subplots(2, sharex=True)
for i in (1, 2, 3):
    rates.plot(rows["t"], rows[f"omega{i}"], label=f"axis {i}")
rates.set_ylabel("angular velocity (rad/s)")
rates.legend()
energies.plot(rows["t"], rows["total"])
energies.set_ylabel("energy (J)")
energies.set_xlabel("t (s)")
figure.savefig("damped_box.png", dpi=150)

account = np.abs(rows["energy_residual"]).max() / rows["total"][0]
print(f"{rows['total'][0]:.6f} J at the start, {rows['total'][-1]:.6f} J at the end, account closed to {account:.1e}")
assert account < 1e-13, "the energy account is open"
assert rows["total"][-1] < rows["total"][0], "friction took no energy"
