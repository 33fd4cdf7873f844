"""Satellites: reaction wheels, orbits, controllers and rotating frames, in programs and in sweeps."""

import copy
import pickle
import unittest

import numpy as np

import nutate
from test_nutate import make_box

# One of each new kind, with all that a run remembers: samples, limits, events.
SCENES = [
    """&body inertia = 90, 100, 40 / &orbit altitude = 500e3 / &gravity_gradient /
    &initial roll_pitch_yaw = 0.1, -0.1, 0.2, angular_velocity = 3*0, attitude_from = 'lvlh', rate_from = 'lvlh' /
    &event when = 'roll', crosses = 0 / &output columns = 'quaternion', 'lvlh_attitude', 'energy', 'jacobi', 'energies' /
    &integrator time_step = 33.3, end_time = 3330, method = '{}' /""",
    """&body inertia = 90, 100, 40 / &orbit semi_major_axis = 1e7, eccentricity = 0.3 / &gravity_gradient /
    &initial angular_velocity = 1e-3, -5e-4, 8e-4 / &event when = 'true_anomaly', crosses = 1 /
    &output columns = 'quaternion', 'orbit', 'energy', 'time_dependent_work', 'energies', 'works' /
    &integrator time_step = 33.3, end_time = 3330, method = '{}' /""",
    """&body inertia = 90, 100, 40 / &initial angular_velocity = 0.02, -0.01, 0.03, axis = 1, 1, 0, angle = 0.5 /
    &wheel axis = 1, 0, 0, inertia = 0.05, torque_limit = 0.4, speed_limit = 20 / &wheel axis = 0, 1, 0, inertia = 0.05 /
    &wheel axis = 0, 0, 1, inertia = 0.05 / &rotating_frame rate = 1e-3, 0, 2e-3 /
    &controller law = 'quaternion', by = 'wheels', attitude_gain = 0.01, rate_gain = 0.12, sample = 0.37 /
    &output columns = 'quaternion', 'angular_velocity', 'energy', 'wheel1', 'wheel3', 'works' /
    &integrator time_step = 0.1, end_time = 10, method = '{}' /""",
]


def driven(*torques):
    """A body with a wheel that the program drives for a second by each torque, or by all of them in a table."""
    system = nutate.System(moments=(90, 100, 40))
    table = None
    if not torques:
        table = ([0, 1, 1, 2], [0.2, 0.2, -0.3, -0.3])
    system.add_wheel((1, 2, 2), 0.05, 30.0, friction=1e-3, table=table)
    stepper = nutate.Stepper(copy.copy(system), time_step=0.1, order=4)
    stepper.set_state(q=(1, 0, 0, 0), omega=(0.02, -0.01, 0.03))
    for torque in torques or (None, None):
        if torque is not None:
            stepper.set_motor(0, torque)
        stepper.run(10)
    return stepper


class SatellitesTest(unittest.TestCase):
    def test_limits_of_a_continuous_law_cost_a_bounded_number_of_evaluations(self):
        calls = {}
        for limit in (None, 0.2):
            system = nutate.System(moments=(0.042, 0.042, 0.0067))
            system.add("orbit", altitude=400e3, inclination=0.9)
            system.add("earth_field")
            system.add("controller", law="bdot", gain=5e4, **({} if limit is None else {"limit": limit}))
            calls[limit] = 0

            def count(t, q, omega, limit=limit):
                calls[limit] += 1
                return 0.0, 0.0, 0.0

            system.add_user_torque(count)
            nutate.solve(system, omega0=(3.5, 3.5, 3.5), t_span=(0, 20), method="dop853", local_tolerance=1e-8)
        # 250 times the moment reaches a limit or leaves it; the steps without limits are 150.
        self.assertLess(calls[0.2], 30*calls[None])

    def test_batches_that_are_pickled_have_the_bits_of_the_whole_run(self):
        for text in SCENES:
            for method in ("nielsen_krenk", "taylor", "rk8"):
                with nutate.Scene(text=text.format(method)) as scene:
                    whole = scene.run()
                    stepper, end = nutate.Stepper(scene), scene.plan[1]
                rows = [stepper.run(0, initial=True)]
                for n in (7, 20, 1, 40):
                    rows.append(stepper.run(n))
                    stepper = pickle.loads(pickle.dumps(stepper))
                # Its first row is the last one again.
                rows.append({name: column[1:] for name, column in stepper.run_to(end).items()})
                for name, column in whole.items():
                    np.testing.assert_array_equal(column, np.concatenate([part[name] for part in rows]), name)

    def test_works_of_each_effect_count_from_the_state_that_was_set(self):
        text = """&body inertia = 4, 5, 6 / &damping coefficient = 0.1, 0.2, 0.3 / &torque space = 1, -0.4, 1.6, frequency = 0.7 /
            &spring body_point = 0.4, 0.1, -0.6, anchor = 0.5, 1, -0.8, stiffness = 5, name = 'band' / {}
            &wheel axis = 1, 2, 2, inertia = 0.05, speed = 3, torque = 0.2, friction = 0.01 /
            &initial angular_velocity = 0.7, -1.1, 0.9 / &integrator method = '{}', time_step = 0.02, end_time = 2, {} /
            &output columns = 'energy', 'time_dependent_work', 'energies', 'works' /"""
        event = "&event when = 'omega1', crosses = 1, switch = 'band toggle' /"
        switched = 0
        for method, conserve in (("nielsen_krenk", ""), ("rk8", "conserve = .true."), ("taylor", "")):
            for events in ("", event):
                with nutate.Scene(text=text.format(events, method, conserve)) as scene:
                    stepper = nutate.Stepper(scene)
                rows = []
                if not events:
                    for _ in range(3):
                        stepper.step(0.02)
                        rows.append(stepper.row)
                for history in (stepper.run(7), stepper.run_to(stepper.time + 0.31), stepper.run(5),
                                stepper.run_to(stepper.time + 0.5, times=stepper.time + np.array([0.013, 0.2777, 0.5]))):
                    rows += [dict(zip(history, values)) for values in zip(*history.values())]
                rows += [stepper.row, copy.copy(stepper).row]
                for row in rows:
                    works = sum(value for name, value in row.items() if name.startswith("work_"))
                    self.assertAlmostEqual(works, row["work"] + row["time_dependent_work"], delta=1e-13)
                    self.assertAlmostEqual(row["energy_spring"], row["potential"], delta=1e-14)
                    self.assertLess(abs(row["energy_residual"]), 1e-12)
                self.assertEqual(rows[-1], rows[-2])
                self.assertNotEqual(rows[-1]["work_damping"], 0.0)
                switched += rows[-1]["work_switches"] != 0.0
                stepper.set_state(q=(1, 0, 0, 0), omega=(0.1, 0.2, 0.3))
                self.assertEqual([value for name, value in stepper.row.items() if name.startswith("work_")], [0.0] * 5)
        self.assertGreater(switched, 0)

    def test_a_program_drives_a_wheel_as_a_table_does(self):
        table, program = driven(), driven(0.2, -0.3)
        np.testing.assert_allclose(table.wheels[0], program.wheels[0], rtol=1e-13)
        self.assertAlmostEqual(program.energy[3], program.wheels[0].motor_work + program.wheels[0].friction_work, delta=1e-13)
        self.assertLess(abs(program.energy[4]), 1e-13)
        with self.assertRaises(nutate.NutateValueError):
            table.set_motor(0, 0.1)
        for wheel in (1, -2):
            with self.assertRaisesRegex(nutate.NutateValueError, f"wheel {wheel} does not exist"):
                program.set_motor(wheel, 0.1)
        program.set_motor(-1, 0.1)
        with self.assertRaisesRegex(nutate.NutateValueError, "the system has no wheels"):
            make_box().set_motor(0, 0.1)

    def test_an_inner_sphere_takes_the_energy_and_keeps_the_momentum(self):
        system = nutate.System(moments=(1.7, 1.1, 0.9))
        system.add("inner_sphere", inertia=0.3, damping=0.5, angular_velocity=(0.1, -0.2, 0.3))
        stepper = nutate.Stepper(system, order=8, time_step=0.1)
        stepper.set_state(q=(1, 0, 0, 0), omega=(0.02, 0.01, 2.0))
        stepper.set_columns("sphere1", "angular_momentum_space", "energy")
        first = stepper.row
        for _ in range(100):
            stepper.step(0.1)
        row, sphere = stepper.row, stepper.spheres[0]
        np.testing.assert_allclose(sphere.rate, [row[f"sphere1_rate{i}"] for i in (1, 2, 3)], atol=1e-14)
        np.testing.assert_allclose(sphere.momentum, [row[f"sphere1_momentum_{i}"] for i in "xyz"], atol=1e-14)
        self.assertAlmostEqual(sphere.energy, row["sphere1_energy"], delta=1e-15)
        self.assertAlmostEqual(sphere.friction_work, row["work"], delta=1e-14)
        self.assertLess(sphere.friction_work, -1e-2)
        np.testing.assert_allclose([row[f"l_{i}"] for i in "xyz"], [first[f"l_{i}"] for i in "xyz"], atol=1e-14)
        self.assertEqual(make_box().spheres, [])

    def test_gains_of_controllers_are_numbers_or_matrices(self):
        tensor = np.array([[90.0, 5.0, -3.0], [5.0, 100.0, 2.0], [-3.0, 2.0, 40.0]])
        ends = []
        for keys in ({"attitude_gain": 0.25, "rate_gain": 0.5},
                     {"attitude_gain": 0.25, "rate_gain": 0.5, "inertia": (90, 100, 40, 5, -3, 2)},
                     {"attitude_gain_matrix": 0.25 * tensor, "rate_gain_matrix": 0.5 * tensor},
                     {"attitude_gain": 0.25, "rate_gain": 0.5, "inertia": (90, 100, 40)}):
            system = nutate.System(tensor=tensor)
            system.add("controller", law="quaternion", sample=0.25, **keys)
            stepper = nutate.Stepper(system, time_step=0.1)
            stepper.set_state(q=(0, 1, 0, 0), omega=(0.02, -0.01, 0.03))
            stepper.run(40)
            ends.append([*stepper.quaternion, *stepper.angular_velocity])
        self.assertEqual(ends[1], ends[0])
        self.assertEqual(ends[2], ends[0])
        self.assertNotEqual(ends[3], ends[0])

    def test_columns_of_controllers_are_those_of_scenes(self):
        columns = ("controller1", "pointing_error1", "magnetic_field")
        text = """&body inertia = 90, 100, 40 / &initial angular_velocity = 0.02, -0.01, 0.03 /
            &controller law = 'quaternion', by = 'magnetorquers', field = 0.3, -0.2, 0.4, attitude_gain = 0.1, rate_gain = 0.12, sample = 0.5,
            limit = 3.0, target = 0.5, 0.5, 0.5, 0.5 / &output columns = 'controller1', 'pointing_error1', 'magnetic_field' /
            &integrator time_step = 0.25, end_time = 20, method = 'taylor' /"""
        with nutate.Scene(text=text) as scene:
            expected = scene.run()
        system = nutate.System(moments=(90, 100, 40))
        system.add("controller", law="quaternion", by="magnetorquers", field=(0.3, -0.2, 0.4), attitude_gain=0.1, rate_gain=0.12, sample=0.5,
                   limit=3.0, target=(0.5, 0.5, 0.5, 0.5))
        stepper = nutate.Stepper(system, time_step=0.25, method="taylor")
        stepper.set_state(q=(1, 0, 0, 0), omega=(0.02, -0.01, 0.03))
        stepper.set_columns(*columns)
        # A stepper takes its first sample behind its first row.
        parts = [stepper.run(33), stepper.run(47)]
        for name in expected:
            np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), expected[name][1:], name)
        self.assertGreater(expected["controller1_saturations"][-1], 1)

    def test_space_axes_are_inertial_unless_lvlh_is_asked_for(self):
        rows = {}
        for frame in ({}, {"frame": "inertial"}, {"frame": "lvlh"}):
            system = nutate.System(moments=(90, 100, 40))
            system.add("orbit", altitude=500e3, inclination=97.4, raan=30, degrees=True, **frame)
            system.add("gravity_gradient")
            start = nutate.quat_product(system.space_axes(0.0) * (1, -1, -1, -1), (0.5, 0.5, 0.5, 0.5))
            stepper = nutate.Stepper(system, method="taylor", time_step=20.0)
            stepper.set_state(q=start, omega=(1e-3, -5e-4, 8e-4))
            stepper.set_columns("lvlh_attitude", "angular_velocity", "quaternion")
            rows[str(frame)] = stepper.run(40)
        default, inertial, lvlh = rows.values()
        for name in default:
            np.testing.assert_array_equal(default[name], inertial[name])
            if not name.startswith("q"):
                np.testing.assert_allclose(lvlh[name], default[name], rtol=0, atol=1e-10, err_msg=name)
        self.assertGreater(np.abs(lvlh["q0"] - default["q0"]).max(), 0.1)

    def test_wheels_are_those_of_the_columns(self):
        system = nutate.System(moments=(90, 100, 40))
        system.add("orbit", altitude=500e3, inclination=97.4, degrees=True)
        system.add("gravity_gradient")
        system.add_wheel((0, 0, 1), 0.05, torque=0.2, frequency=0.1, start=0.5, speed_limit=np.inf)
        system.add_wheel((0, 1, 0), 0.05, 10.0)
        for motor in (dict(torque=1.0, table=([0, 1], [0, 1])), dict(phase=1.0), dict(frequency=1.0, table=([0, 1], [0, 1])), dict(start=0.5)):
            with self.assertRaises(nutate.NutateValueError):
                system.add_wheel((0, 1, 0), 0.05, **motor)
        stepper = nutate.Stepper(pickle.loads(pickle.dumps(system)), time_step=0.5)
        stepper.set_state(q=(1, 0, 0, 0), omega=(0, 0, 0))
        stepper.set_columns("wheel1", "wheel2", "jacobi", "orbit", "lvlh_attitude", "time_dependent_work")
        last = {name: column[-1] for name, column in stepper.run(20).items()}
        for i, wheel in enumerate(stepper.wheels, 1):
            self.assertEqual(tuple(wheel), tuple(last[f"wheel{i}_{name}"] for name in ("speed", "momentum", "motor_work", "friction_work")))
        self.assertGreater(abs(stepper.wheels[0].speed), 1.0)
        self.assertEqual(stepper.jacobi, last["jacobi"])
        self.assertEqual(stepper.time_dependent_work, last["time_dependent_work"])
        self.assertGreater(abs(stepper.time_dependent_work), 1e-10)
        position, anomaly = stepper.orbit
        self.assertEqual([*position, anomaly], [last[name] for name in ("orbit_x", "orbit_y", "orbit_z", "true_anomaly")])
        q, angles = stepper.lvlh_attitude
        self.assertEqual([*angles, *q], [last[name] for name in ("roll", "pitch", "yaw", "lvlh_q0", "lvlh_q1", "lvlh_q2", "lvlh_q3")])

    def test_a_wheel_with_a_wrong_motor_is_not_added(self):
        system = nutate.System(moments=(90, 100, 40))
        lines = ([0, 1], [0, 1])
        for motor in (dict(torque=2.0, torque_limit=1.0), dict(torque=1.0, start=np.nan), dict(table=lines, start=np.nan),
                      dict(table=lines, stop=np.nan), dict(table=lines, start=np.inf), dict(table=([1, 0], [0, 1])),
                      dict(table=lines, interpolation="none")):
            with self.subTest(motor), self.assertRaises(nutate.NutateValueError):
                system.add_wheel((0, 0, 1), 0.05, **motor)
            self.assertEqual(len(nutate.Stepper(system).wheels), 0, motor)
        system.add_wheel((0, 0, 1), 0.05, table=lines, start=0.25)
        self.assertEqual(repr(system).count("wheel"), 1)

    def test_the_field_of_the_earth_and_forces_are_those_of_scenes(self):
        def orbiting():
            system = nutate.System(moments=(0.02, 0.03, 0.04))
            system.add("orbit", altitude=500e3, inclination=1.2)
            return system

        ends = []
        for by_group in (False, True):
            system = orbiting()
            if by_group:
                system.add("earth_field", moment=(0, 0.02, 0.1), epoch_angle=0.7, coefficients=(0, 5e-6, -3e-5))
                system.add("force", body_point=(0, 0.1, 0.02), force=(-1e-5, 0, 0), axes="inertial")
                system.add("force", body_point=(0, 0.1, 0), force=(0, 0, 2e-5), axes="body", start=3.3, stop=40.0)
            else:
                system.add_earth_field((0, 0.02, 0.1), epoch_angle=0.7, coefficients=(0, 5e-6, -3e-5))
                system.add_force((0, 0.1, 0.02), (-1e-5, 0, 0), "inertial")
                system.add_force((0, 0.1, 0), (0, 0, 2e-5), "body", start=3.3, stop=40)
                self.assertIn("earth_field, force, force", repr(system))
                system = pickle.loads(pickle.dumps(system))
            stepper = nutate.Stepper(system, time_step=1.0)
            stepper.set_state(q=(1, 0, 0, 0), omega=(0.02, -0.01, 0.03))
            stepper.run(60)
            ends.append([*stepper.quaternion, *stepper.angular_velocity, stepper.time_dependent_work, *stepper.energy])
        self.assertEqual(ends[0], ends[1])
        self.assertNotEqual(ends[0][7], 0.0)

    def test_forces_and_fields_are_refused_by_name(self):
        system = nutate.System(moments=(0.02, 0.03, 0.04))
        for wrong in (lambda: system.add_earth_field(), lambda: system.add_force((0, 1, 0), (0, 0, 1), "lvlh"),
                      lambda: system.add_force((0, 1, 0), (0, 0, 1), "nowhere"), lambda: system.add_force((0, 1), (0, 0, 1)),
                      lambda: system.add_force((0, 1, 0), (0, 0, 1), start=2.0, stop=1.0)):
            with self.assertRaises(nutate.NutateValueError):
                wrong()

    def test_motors_that_start_a_body_from_rest_leave_steps_long(self):
        system = nutate.System(moments=(4, 4, 2.5))
        system.add("inner_sphere", inertia=0.5, damping=0.3)
        system.add_wheel(axis=(0, 0, 1), inertia=0.1, torque=0.2)
        solution = nutate.solve(system, omega0=(0, 0, 0), t_span=(0, 0.3), accuracy=None, method="nielsen_krenk", order=2, local_tolerance=1e-7)
        self.assertLess(solution.n_steps, 20)


if __name__ == "__main__":
    unittest.main()
