"""Attitudes for other programs: calendar time, AEM, glTF and SPICE CK, read back by other packages where these are installed."""

import base64
import importlib
import json
import os
import pathlib
import re
import tempfile
import unittest
import unittest.mock

import numpy as np

import nutate

# A tumbler whose times, a quarter of a second apart, are exact in every form of time.
SCENE = """&scene title = 'Tumbler', epoch = '2029-04-13T21:46:12.75', time_system = 'TDB', object = 'APOPHIS', object_id = '2004-MN4',
   space_frame = 'ICRF', body_frame = 'SC_BODY_1' /
&body inertia = 0.64, 0.97, 1.0 /
&initial quaternion = 0.6, 0.0, 0.8, 0.0, angular_velocity = 1.2, 0.1, 5.6 /
&integrator accuracy = 1e-10, end_time = 24.75 /
"""
ROWS = 100
EPS = np.finfo(float).eps


def package(name):
    """A package that a test needs; the test is skipped where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise unittest.SkipTest(f"{name} is not installed") from None


class Folder(unittest.TestCase):
    """Each test works in a folder of its own, with the motion of the scene at 100 times."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.solution = nutate.solve(nutate.Scene(text=SCENE), t_eval=np.arange(ROWS) / 4)

    def path(self, name):
        return str(self.folder / name)

    def assert_same_attitudes(self, matrices, tolerance):
        """Matrices take space components to body components, as R(q) transposed."""
        for matrix, q in zip(matrices, self.solution.q):
            np.testing.assert_allclose(matrix, nutate.matrix_from_quat(q).T, rtol=0, atol=tolerance)


class Calendar(unittest.TestCase):
    def test_dates_have_the_digits_of_the_time(self):
        self.assertEqual(nutate.date("2029-04-13T21:46:12.7", "TDB", 0.1), "2029-04-13T21:46:12.8")
        self.assertEqual(nutate.date("2029-04-13", "TT", 1e-15), "2029-04-13T00:00:00.000000000000001")
        self.assertEqual(nutate.date("2000-02-28T23:59:59", "TAI", 1.0), "2000-02-29T00:00:00")
        self.assertEqual(nutate.date("2029-103T21:46:12.7", "TDB", -86400.0), "2029-04-12T21:46:12.7")

    def test_utc_has_leap_seconds_and_others_have_none(self):
        self.assertEqual(nutate.date("2016-12-31T23:59:59.5", "UTC", 1.25), "2016-12-31T23:59:60.75")
        self.assertEqual(nutate.date("2016-12-31T23:59:59.5", "UTC", 1.5), "2017-01-01T00:00:00")
        self.assertEqual(nutate.date("2017-01-01", "UTC", -0.5), "2016-12-31T23:59:60.5")
        self.assertEqual(nutate.date("2016-12-31T23:59:59.5", "TAI", 1.25), "2017-01-01T00:00:00.75")
        # Twelve leap seconds from 1980 to 1997.
        self.assertEqual(nutate.date("1980-01-01", "UTC", 86400.0 * 6575 + 12), "1998-01-01T00:00:00")

    def test_tdb_of_all_systems(self):
        self.assertEqual(nutate.tdb("2000-01-01T12:00:00", "TDB", 3.5), 3.5)
        # TT = TAI + 32.184 s; TDB - TT is within 1.7 ms.
        np.testing.assert_allclose(nutate.tdb("2000-01-01T12:00:00", "TT", [0.0, 1.0]), [0.0, 1.0], atol=1.7e-3)
        self.assertAlmostEqual(nutate.tdb("2000-01-01T12:00:00", "TAI", 0.0) - nutate.tdb("2000-01-01T12:00:00", "TT", 0.0), 32.184, 7)
        self.assertAlmostEqual(nutate.tdb("2020-01-01", "UTC", 0.0) - nutate.tdb("2020-01-01", "TAI", 0.0), 37.0, 6)

    def test_tdb_is_that_of_spice(self):
        spice = package("spiceypy")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "leap.tls")
            seconds = [(10 + i, date) for i, date in enumerate(LEAP_DATES)]
            with open(path, "w", encoding="ascii") as file:
                file.write("KPL/LSK\n\\begindata\nDELTET/DELTA_T_A = 32.184\nDELTET/K = 1.657D-3\nDELTET/EB = 1.671D-2\n"
                           "DELTET/M = ( 6.239996D0 1.99096871D-7 )\nDELTET/DELTA_AT = (\n"
                           + "\n".join(f"{count}, @{date}" for count, date in seconds) + " )\n\\begintext\n")
            spice.furnsh(path)
            try:
                for date in ("1972-07-01T00:00:00", "1998-12-31T23:59:60.5", "2016-12-31T23:59:59.25", "2025-06-01T12:00:00"):
                    self.assertAlmostEqual(float(nutate.tdb(date, "UTC", 0.0)), spice.str2et(date), delta=3e-7, msg=date)
            finally:
                spice.unload(path)

    def test_z_is_utc(self):
        self.assertEqual(nutate.date("2029-04-13T21:46:12Z", "UTC", 1.0), "2029-04-13T21:46:13")

    def test_what_is_no_date_is_refused(self):
        for epoch, system in (("2029-13-01", "TDB"), ("2029-02-29", "TDB"), ("yesterday", "UTC"), ("1971-12-31", "UTC"),
                              ("2029-04-13T24:00:00", "TDB"), ("2029-04-13T21:46:60", "TDB"), ("2015-12-31T23:59:60", "UTC"),
                              ("1582-12-31", "TT"), ("2029-04-13T21:46:12Z", "TT"), ("2029-04-13", "GPS"), ("2029-04-13", ""), ("2029-366", "TT")):
            with self.assertRaisesRegex(nutate.NutateValueError, "is not a date", msg=epoch):
                nutate.date(epoch, system, 0.0)
        with self.assertRaisesRegex(nutate.NutateValueError, "leaves the calendar"):
            nutate.tdb("2029-04-13", "TDB", [0.0, 1e300])


LEAP_DATES = """1972-JAN-1 1972-JUL-1 1973-JAN-1 1974-JAN-1 1975-JAN-1 1976-JAN-1 1977-JAN-1 1978-JAN-1 1979-JAN-1 1980-JAN-1 1981-JUL-1
1982-JUL-1 1983-JUL-1 1985-JUL-1 1988-JAN-1 1990-JAN-1 1991-JAN-1 1992-JUL-1 1993-JUL-1 1994-JUL-1 1996-JAN-1 1997-JUL-1 1999-JAN-1
2006-JAN-1 2009-JAN-1 2012-JUL-1 2015-JUL-1 2017-JAN-1""".split()


class Messages(Folder):
    def test_an_aem_is_read_back(self):
        self.solution.to_aem(self.path("a.aem"))
        rows = nutate.read_aem(self.path("a.aem"))
        np.testing.assert_allclose(rows.q, self.solution.q, rtol=0, atol=2 * EPS)
        np.testing.assert_allclose(rows.omega, self.solution.omega, rtol=4 * EPS)
        np.testing.assert_array_equal(rows.t, self.solution.t)
        self.assertEqual((rows.epoch, rows.time_system, rows.object, rows.object_id, rows.space_frame, rows.body_frame),
                         ("2029-04-13T21:46:12.75", "TDB", "APOPHIS", "2004-MN4", "ICRF", "SC_BODY_1"))

    def test_version_1_has_attitudes_alone(self):
        self.solution.to_aem(self.path("a.aem"), version="1.0", object="it's")
        rows = nutate.read_aem(self.path("a.aem"))
        np.testing.assert_allclose(rows.q, self.solution.q, rtol=0, atol=2 * EPS)
        self.assertIsNone(rows.omega)
        self.assertEqual(rows.object, "it's")

    def frame_of(self, every, **options):
        """The motion of the scene as a message with records this far apart, s."""
        solution = nutate.solve(nutate.Scene(text=SCENE), t_eval=np.arange(round(24.75 / every) + 1) * every, dense_output=True)
        solution.to_aem(self.path("f.aem"), **options)
        return solution, nutate.read_aem(self.path("f.aem"))

    def test_a_message_is_a_frame_with_continuous_rates(self):
        errors = []
        times = np.linspace(0.01, 24.7, 997)
        for every in (1 / 16, 1 / 32):
            solution, rows = self.frame_of(every)
            q, omega = rows.at(times)
            exact_q, exact_omega = solution.sol(times)
            relative = rows.relative(times, exact_q)
            errors.append((np.max(2 * np.linalg.norm(relative[:, 1:], axis=1)), np.max(np.abs(omega - exact_omega))))
            np.testing.assert_allclose(np.abs(np.sum(q * exact_q, axis=1)), np.sqrt(1 - np.sum(relative[:, 1:]**2, axis=1)), atol=4 * EPS)
            # At the records the frame is that of the message, from both sides.
            for side in (-1e-12, 1e-12):
                found = rows.at(rows.t[1:-1] + side)
                np.testing.assert_allclose(np.abs(np.sum(found[0] * rows.q[1:-1], axis=1)), 1, atol=4 * EPS)
                np.testing.assert_allclose(found[1], rows.omega[1:-1], atol=1e-9)
        # Fourth order of the attitude, third of the rate.
        self.assertLess(errors[0][0], 1e-4)
        self.assertTrue(14 < errors[0][0] / errors[1][0] < 18, errors)
        self.assertTrue(7 < errors[0][1] / errors[1][1] < 9, errors)

    def test_the_rate_of_a_frame_is_that_of_its_attitude(self):
        for version in ("2.0", "1.0"):
            _, rows = self.frame_of(1 / 16, version=version)
            times, h = np.linspace(0.013, 24.6, 211), 1e-5
            inside = np.abs((times * 16 + 0.5) % 1 - 0.5) > 1e-3
            times = times[inside]
            after = rows.relative(times - h, rows.at(times + h)[0])
            np.testing.assert_allclose(after[:, 1:] / h, rows.at(times)[1], atol=1e-8)

    def test_without_rates_a_frame_turns_at_a_constant_one(self):
        solution, rows = self.frame_of(1 / 16, version="1.0")
        times = rows.t[:-1] + 1 / 32
        exact, _ = solution.sol(times)
        errors = 2 * np.linalg.norm(rows.relative(times, exact)[:, 1:], axis=1)
        _, before = solution.sol(times - 1e-4)
        _, after = solution.sol(times + 1e-4)
        bound = np.linalg.norm(after - before, axis=1) / 2e-4 / 16**2 / 8
        np.testing.assert_allclose(errors, bound, rtol=0.05, atol=1e-4 * bound.max())

    def test_columns_of_a_scene_are_those_of_relative(self):
        times = np.linspace(0, 6, 101)
        for version in ("2.0", "1.0"):
            _, rows = self.frame_of(1 / 16, version=version)
            text = SCENE.replace("24.75", "6").replace("5.6", "-2") + f"&frame attitude = '{self.path('f.aem')}' /\n"
            with nutate.Scene(text=text + "&output columns = 'quaternion', 'frame1', times = " + ", ".join(map(str, times)) + " /\n") as scene:
                found = scene.run()
            expected = rows.relative(times, np.stack([found[f"q{i}"] for i in range(4)], axis=-1))
            relative = np.stack([found[f"frame1_q{i}"] for i in range(4)], axis=-1)
            sign = np.where(relative[:, :1] < 0, -1, 1)
            np.testing.assert_allclose(sign * relative, expected, rtol=0, atol=16 * EPS)
            np.testing.assert_allclose(found["frame1_angle"], 2 * np.arctan2(np.linalg.norm(expected[:, 1:], axis=1), expected[:, 0]),
                                       rtol=0, atol=16 * EPS)
            # No sign jumps but that of the message would show.
            self.assertTrue(np.all(np.sum(relative[1:] * relative[:-1], axis=1) > 0.8))

    def test_relative_rejects_labels_in_another_order(self):
        class Table(list):
            columns = ["q1", "q2", "q3", "q0"]

        rows = self.frame_of(1 / 16)[1]
        with self.assertRaisesRegex(nutate.NutateValueError, "q has components in the order q1, q2, q3, q0"):
            rows.relative(rows.t[:1], Table(rows.q[:1].tolist()))

    def test_a_run_beyond_the_records_ends(self):
        _, rows = self.frame_of(1 / 16)
        scene = nutate.Scene(text=SCENE.replace("24.75", "6") + f"&frame attitude = '{self.path('f.aem')}' /\n")
        with self.assertRaisesRegex(nutate.NutateValueError, "end_time is outside of the records"):
            nutate.Scene(text=SCENE.replace("24.75", "25") + f"&frame attitude = '{self.path('f.aem')}' /\n")
        stepper = nutate.Stepper(scene)
        stepper.set_columns("frame1")
        self.assertLess(np.max(stepper.run_to(6.0, interval=0.5)["frame1_angle"]), 1e-3)
        with self.assertRaisesRegex(nutate.NutateError, "not finite"):
            stepper.run_to(30.0, interval=0.5)
        with self.assertRaisesRegex(nutate.NutateError, "&frame is not allowed here"):
            nutate.System(moments=(1, 2, 2.5)).add("frame", attitude=self.path("f.aem"))

    def test_times_of_a_frame_may_count_from_a_date(self):
        solution, rows = self.frame_of(1 / 16)
        np.testing.assert_allclose(rows.relative(2.0, solution.q[16], "2029-04-13T21:46:11.75", "TDB")[1:], 0, atol=3e-6)
        with self.assertRaisesRegex(nutate.NutateValueError, "outside of the records"):
            rows.at([1.0, 25.0])
        with self.assertRaisesRegex(nutate.NutateValueError, "is not a date"):
            rows.at(0.0, "soon")
        with self.assertRaisesRegex(nutate.NutateValueError, r"t has shape \(1, 2\)"):
            rows.at([[0.0, 1.0]])
        _, rows = self.frame_of(0.45)
        rows.t = 2 * rows.t
        with self.assertRaisesRegex(nutate.NutateValueError, "half a turn or more apart 0.0 s"):
            rows.at(0.1)

    def test_brahe_reads_version_2(self):
        ccsds = package("brahe.ccsds")
        self.solution.to_aem(self.path("a.aem"))
        segment = ccsds.AEM.from_file(self.path("a.aem")).segments[0]
        self.assertEqual((len(segment.states), segment.object_id, segment.ref_frame_a, segment.ref_frame_b, str(segment.time_system)),
                         (ROWS, "2004-MN4", "ICRF", "SC_BODY_1", "TDB"))
        self.assert_same_attitudes([state.quaternion.to_rotation_matrix().to_matrix() for state in segment.states], 1e-12)
        np.testing.assert_allclose([state.angular_velocity for state in segment.states], self.solution.omega, rtol=0, atol=1e-14)
        for state, t in zip(segment.states, self.solution.t):
            # Differences of epochs are good to some 1e-9 s there.
            self.assertAlmostEqual(state.epoch - segment.states[0].epoch, t, delta=1e-8)

    def test_ccsds_ndm_reads_version_1(self):
        package("ccsds_ndm")
        from ccsds_ndm.ndm_io import NdmIo
        self.solution.to_aem(self.path("a.aem"), version="1.0")
        message = NdmIo().from_path(self.path("a.aem"))
        segment = message.body.segment[0]
        states = [state.quaternion_state for state in segment.data.attitude_state]
        self.assertEqual(len(states), ROWS)
        for state, q in zip(states, self.solution.q):
            found = state.quaternion
            np.testing.assert_allclose([float(x) for x in (found.qc, found.q1, found.q2, found.q3)], q, rtol=0, atol=1e-12)

    def test_ecliptic_axes_are_turned_to_the_equator(self):
        self.solution.to_aem(self.path("a.aem"), space_frame="ECLIPJ2000")
        rows = nutate.read_aem(self.path("a.aem"))
        self.assertEqual(rows.space_frame, "EME2000")
        angle = np.deg2rad(84381.448 / 3600)
        turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
        for q, original in zip(rows.q, self.solution.q):
            np.testing.assert_allclose(nutate.matrix_from_quat(q), turn @ nutate.matrix_from_quat(original), rtol=0, atol=8 * EPS)

    def test_rates_are_relative_to_axes_that_turn(self):
        system = nutate.System(moments=(1, 2, 2.5))
        system.add("rotating_frame", rate=(0.0, 0.3, 0.4))
        solution = nutate.solve(system, omega0=(0.1, 0.5, 0.2), t_span=(0, 3), accuracy=1e-10, t_eval=np.arange(31) / 10)
        solution.to_aem(self.path("a.aem"), epoch="2029-04-13", time_system="TAI", space_frame="LAB")
        rows = nutate.read_aem(self.path("a.aem"))
        q, omega = rows.q, rows.omega
        # Central differences of the attitude, with an error of h^2/6 of the third derivative.
        dq = (q[2:] - q[:-2]) / 0.2
        for k, rate in enumerate(dq):
            conjugate = q[k + 1] * np.array([1, -1, -1, -1])
            np.testing.assert_allclose(2 * nutate.quat_product(conjugate, rate)[1:], omega[k + 1], rtol=0, atol=1e-3)

    def test_lvlh_axes_become_inertial(self):
        text = """&scene epoch = '2026-03-20T12:00:00', time_system = 'UTC', object = 'SAT', space_frame = 'J2000' /
            &body inertia = 0.12, 0.1, 0.04 / &gravity_gradient /
            &initial attitude_from = 'lvlh', rate_from = 'lvlh', angular_velocity = 3*0.0 /
            &orbit altitude = 500e3, inclination = 97.4, raan = 30, degrees = .true., frame = 'lvlh' /
            &integrator accuracy = 1e-8, end_time = 1000 / &output interval = 500 /"""
        found = {}
        for frame in ("lvlh", "inertial"):
            for error in (0.0, 1e-3):
                solution = nutate.solve(nutate.Scene(text=text.replace("'lvlh' /\n            &integrator", f"'{frame}' /\n            &integrator")))
                solution.to_aem(self.path("a.aem"), error=error)
                found[frame, error] = nutate.read_aem(self.path("a.aem"))
            np.testing.assert_allclose(found[frame, 0.0].q[0], [0.693399, 0.226708, -0.669779, 0.138555], rtol=0, atol=1e-6)
            np.testing.assert_allclose(np.degrees(found[frame, 0.0].omega[0]), [0, -0.063414, 0], rtol=0, atol=1e-6)
            np.testing.assert_allclose(solution.system.space_axes([0.0, 100.0])[0],
                                       [0.693399, 0.226708, -0.669779, 0.138555] if frame == "lvlh" else [1, 0, 0, 0], rtol=0, atol=1e-6)
        for error in (0.0, 1e-3):
            one, other = found["lvlh", error], found["inertial", error]
            self.assertEqual(len(one.t), len(other.t))
            np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-6)
        solution = nutate.solve(nutate.Scene(text=text))
        for name in ("LVLH", "rsw_rotating"):
            with self.assertRaisesRegex(nutate.NutateValueError, f"space_frame='{name}' names axes that rotate"):
                solution.to_aem(self.path("a.aem"), space_frame=name)
        solution.to_aem(self.path("a.aem"), space_frame="LVLH_INERTIAL")
        with self.assertRaisesRegex(nutate.NutateValueError, "vice versa"):
            solution.to_aem(self.path("a.aem"), space_frame="SC_BODY_1", body_frame="ARM")

    def test_inertial_axes_do_not_rotate(self):
        system = nutate.System(text="&body inertia = 1, 2, 2.5 / &rotating_frame latitude = 1 /")
        solution = nutate.solve(system, omega0=(0, 1, 0.1), t_span=(0, 1))
        with self.assertRaisesRegex(nutate.NutateValueError, "the space axes rotate, and space_frame='J2000' names inertial axes"):
            solution.to_aem(self.path("a.aem"), epoch="2029-04-13", time_system="TDB", space_frame="J2000")
        with self.assertRaises(nutate.NutateValueError):
            system.space_axes(0.0)

    def test_what_is_missing_is_named(self):
        solution = nutate.solve(nutate.System(moments=(1, 2, 2.5)), omega0=(0, 1, 0), t_span=(0, 1))
        with self.assertRaisesRegex(nutate.NutateValueError, "the date of t = 0 .expected epoch"):
            solution.to_aem(self.path("a.aem"))
        with self.assertRaisesRegex(nutate.NutateValueError, "space_frame"):
            solution.to_aem(self.path("a.aem"), epoch="2029-04-13", time_system="TDB")
        with self.assertRaisesRegex(nutate.NutateValueError, "facts:1: 'soon' is not a date"):
            solution.to_aem(self.path("a.aem"), epoch="soon", time_system="TDB", space_frame="ICRF")
        with self.assertRaisesRegex(nutate.NutateValueError, "version of AEM"):
            self.solution.to_aem(self.path("a.aem"), version="3.0")
        with self.assertRaises(nutate.NutateOSError):
            self.solution.to_aem(self.path("none/a.aem"))
        self.assertEqual(os.listdir(self.folder), [])

    def test_backward_motions_are_written_forward(self):
        solution = nutate.solve(nutate.System(moments=(1, 2, 2.5)), omega0=(0, 1, 0.1), t_span=(0, -2), t_eval=[0, -1, -2])
        solution.to_aem(self.path("a.aem"), epoch="2029-04-13", time_system="TDB", space_frame="ICRF")
        rows = nutate.read_aem(self.path("a.aem"))
        self.assertEqual(rows.epoch, "2029-04-12T23:59:58")
        np.testing.assert_allclose(rows.q, solution.q[::-1], rtol=0, atol=2 * EPS)


class Reading(Folder):
    """AEM files of other programs."""

    HEAD = "CCSDS_AEM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = TEST\n"
    META = ("META_START\nOBJECT_NAME = A\nOBJECT_ID = B\nREF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1\nTIME_SYSTEM = UTC\n"
            "ATTITUDE_TYPE = QUATERNION/ANGVEL\nANGVEL_FRAME = REF_FRAME_A\nMETA_STOP\n")
    DATA = "DATA_START\nCOMMENT none\n2026-001T00:00:00Z 0 0.6 0 0.8 0 90 90\r\n\n2026-01-01T00:00:02 0 0 0 1 0 0 0\nDATA_STOP\n"

    def read(self, text):
        with open(self.path("a.aem"), "w", encoding="utf-8", newline="") as file:
            file.write(text)
        return nutate.read_aem(self.path("a.aem"))

    def test_rates_in_space_axes_and_dates_of_both_formats(self):
        rows = self.read(self.HEAD + self.META + self.DATA)
        np.testing.assert_array_equal(rows.t, [0, 2])
        np.testing.assert_array_equal(rows.q, [[0.8, 0, 0.6, 0], [1, 0, 0, 0]])
        # R(q) transposed times (0, 90, 90) deg/s, q turning by 2 atan(0.75) about y.
        np.testing.assert_allclose(rows.omega[0], np.deg2rad([-0.96 * 90, 90, 0.28 * 90]), rtol=4 * EPS)

    def test_leap_seconds_count(self):
        data = ("DATA_START\n2016-12-31T23:59:59 0 0 0 1 0 0 0\n2016-12-31T23:59:60 0 0 0 1 0 0 0\n"
                "2017-01-01T00:00:00.25 0 0 0 1 0 0 0\nDATA_STOP\n")
        np.testing.assert_array_equal(self.read(self.HEAD + self.META + data).t, [0, 1, 2.25])

    def test_direction_and_order_of_version_1(self):
        for direction, kind, values, expected in (("A2B", "LAST", "0 0.6 0 0.8", (0.8, 0, 0.6, 0)), ("A2B", "FIRST", "0.8 0 0.6 0", (0.8, 0, 0.6, 0)),
                                                  ("B2A", "LAST", "0 0.6 0 0.8", (0.8, 0, -0.6, 0))):
            meta = (self.META.replace("/ANGVEL", "").replace("ANGVEL_FRAME = REF_FRAME_A", f"ATTITUDE_DIR = {direction}\nQUATERNION_TYPE = {kind}"))
            rows = self.read(self.HEAD.replace("2.0", "1.0") + meta + f"DATA_START\n2026-01-01T00:00:00 {values}\nDATA_STOP\n")
            np.testing.assert_array_equal(rows.q[0], expected)

    def test_there_is_no_attitude_between_segments(self):
        plain = self.META.replace("/ANGVEL", "").replace("ANGVEL_FRAME = REF_FRAME_A\n", "")

        def segment(*records):
            return plain + "DATA_START\n" + "".join(f"2026-01-01T00:00:{s:02} {q}\n" for s, q in records) + "DATA_STOP\n"

        still, turned = "0 0 0 1", "0 0.7071067811865476 0 0.7071067811865476"
        rows = self.read(self.HEAD + segment((0, still), (1, still)) + segment((1, turned), (2, turned)))
        np.testing.assert_array_equal((rows.t, rows.segment), ([0, 1, 1, 2], [1, 1, 2, 2]))
        np.testing.assert_allclose(rows.at([0.5, 1.5])[0], [[1, 0, 0, 0], [0.5**0.5, 0, 0.5**0.5, 0]], atol=4 * EPS)
        rows = self.read(self.HEAD + segment((0, still), (1, still)) + segment((3, still), (4, still)))
        np.testing.assert_allclose(rows.at([0.0, 1.0, 3.0, 4.0])[0], [[1, 0, 0, 0]] * 4)
        with self.assertRaisesRegex(nutate.NutateValueError, "t is between two segments of the message .2.0 s"):
            rows.at(2.0)
        # A segment that goes on with the last record of the one before is no other motion.
        rows = self.read(self.HEAD + segment((0, still), (1, turned)) + segment((1, turned), (2, still)))
        np.testing.assert_array_equal((rows.t, rows.segment), ([0, 1, 2], [1, 1, 1]))

    def test_a_fast_record_at_either_end_may_be_half_a_turn_away(self):
        # From rest to 432 deg/s in a second the body turns by 216 degrees, not by the 144 of the shorter way back.
        rows = ["0 0 0 1 0 0 0", "0 0 0.9510565162951535 -0.3090169943749474 0 0 432"]
        for order in (rows, rows[::-1]):
            data = "DATA_START\n" + "".join(f"2026-01-01T00:00:0{s} {row}\n" for s, row in enumerate(order)) + "DATA_STOP\n"
            with self.assertRaisesRegex(nutate.NutateValueError, "half a turn or more apart 0.0 s"):
                self.read(self.HEAD + self.META + data).at(0.5)

    def test_a_spacecraft_as_the_first_frame_is_read_by_its_direction(self):
        straight = self.read(self.HEAD + self.META + self.DATA)
        other = self.META.replace("REF_FRAME_A = ICRF\nREF_FRAME_B = SC_BODY_1", "REF_FRAME_A = SC_BODY_1\nREF_FRAME_B = ICRF")
        # From the body to space, and the rates of the space axes against the body in space axes.
        data = self.DATA.replace("0 0.6 0 0.8 0 90 90", "0 -0.6 0 0.8 0 -90 -90")
        rows = self.read(self.HEAD + other.replace("ANGVEL_FRAME = REF_FRAME_A", "ANGVEL_FRAME = REF_FRAME_B") + data)
        self.assertEqual((rows.space_frame, rows.body_frame), ("ICRF", "SC_BODY_1"))
        np.testing.assert_allclose(rows.q, straight.q, atol=2 * EPS)
        np.testing.assert_allclose(rows.omega, straight.omega, atol=4 * EPS)
        for a, b in (("MYSAT", "B1950"), ("MYSAT", "TEMEOFDATE"), ("MYSAT", "VNC_INERTIAL"), ("MYSAT", "DTRF2014"), ("AST_1", "MYSPACE"),
                     ("ACC_2", "MYSPACE"), ("ESA_1", "MYSPACE")):
            rows = self.read(self.HEAD + other.replace("SC_BODY_1", a).replace("ICRF", b) + data)
            self.assertEqual((rows.space_frame, rows.body_frame), (b, a))

    def test_values_in_lower_case_and_useable_times(self):
        lower = self.META.replace("ICRF", "icrf").replace("UTC", "utc").replace("QUATERNION/ANGVEL", "quaternion/angvel").replace(
            "= REF_FRAME_A", "= ref_frame_a").replace("META_STOP", "USEABLE_START_TIME = 2026-01-01T00:00:01\nMETA_STOP")
        rows = self.read(self.HEAD + lower + self.DATA)
        self.assertEqual((rows.space_frame, rows.time_system, rows.epoch), ("ICRF", "UTC", "2026-01-01T00:00:02"))
        np.testing.assert_array_equal(rows.q, [[1, 0, 0, 0]])

    def test_the_sign_of_a_frame_does_not_jump(self):
        data = "DATA_START\n" + "".join(f"2026-01-01T00:00:{s:02} 0 0 {sign * float(np.sin(s / 4))!r} {sign * float(np.cos(s / 4))!r} 0 0 28.64788975654116\n"
                                        for s, sign in ((0, 1), (1, -1), (2, 1), (3, -1))) + "DATA_STOP\n"
        q, _ = self.read(self.HEAD + self.META + data).at(np.linspace(0, 3, 301))
        self.assertLess(np.max(np.abs(np.diff(q, axis=0))), 0.01)

    def test_what_is_wrong_is_named_with_its_line(self):
        whole = self.HEAD + self.META + self.DATA
        for old, new, says in (
                ("CCSDS_AEM_VERS = 2.0\n", "", "a.aem:1: not an attitude ephemeris message"),
                ("CCSDS_AEM_VERS = 2.0\n", "<?xml version='1.0'?>\n", "a.aem:1: XML is not supported"),
                ("CCSDS_AEM_VERS = 2.0", "CCSDS_AEM_VERS = 3.0", "a.aem:1: version '3.0' is not known"),
                ("ATTITUDE_TYPE", "ATITUDE_TYPE", "a.aem:10: unknown keyword 'ATITUDE_TYPE' .nearest: ATTITUDE_TYPE"),
                ("QUATERNION/ANGVEL", "EULER_ANGLE", "a.aem:12: ATTITUDE_TYPE 'EULER_ANGLE' is not supported"),
                ("TIME_SYSTEM = UTC", "TIME_SYSTEM = GPS", "a.aem:12: TIME_SYSTEM 'GPS' is not supported"),
                ("TIME_SYSTEM = UTC\n", "", "a.aem:11: the metadata lack TIME_SYSTEM"),
                ("ANGVEL_FRAME = REF_FRAME_A", "ANGVEL_FRAME = THERE", "a.aem:12: ANGVEL_FRAME is absent or unknown"),
                ("ANGVEL_FRAME = REF_FRAME_A", "ATTITUDE_DIR = A2B", "a.aem:12: version 2.0 has neither"),
                ("OBJECT_ID = B", "OBJECT_NAME = B", "a.aem:6: OBJECT_NAME is given twice"),
                ("OBJECT_ID = B", "OBJECT_ID", "a.aem:6: 'OBJECT_ID' is out of place"),
                ("OBJECT_ID = B", "OBJECT_ID =", "a.aem:6: OBJECT_ID has no value"),
                ("META_STOP\n", "", "a.aem:12: DATA_START is out of place .expected META_STOP"),
                ("DATA_STOP\n", "", "a.aem:17: the message ends too early"),
                ("0 0.6 0 0.8", "0 0.6 0 0.9", "a.aem:15: the quaternion is not of unit norm"),
                ("0 0.6 0 0.8", "0 0.6 x 0.8", "a.aem:15: 'x' is not a number"),
                ("0.8 0 90 90", "0.8 0 90", "a.aem:15: wrong number of values in this record .expected a date and 7 numbers"),
                ("0.8 0 90 90", "0.8 0 90 1e300", "a.aem:15: '1e300' is too large"),
                ("0.8 0 90 90", "0.8 0 90 Infinity", "a.aem:15: 'Infinity' is too large"),
                ("2026-001T00:00:00Z", "2026-001T00:00", "a.aem:15: '2026-001T00:00' has no time of day"),
                ("2026-001T00:00:00Z", "2026-01-01T00:00:02", "a.aem:17: the date is not after that of the record before"),
                (whole, "", "a.aem:1: not an attitude ephemeris message")):
            with self.assertRaisesRegex(nutate.NutateValueError, says, msg=new):
                self.read(whole.replace(old, new))
        with self.assertRaisesRegex(nutate.NutateOSError, "none.aem: cannot be read"):
            nutate.read_aem(self.path("none.aem"))


def buffers(path):
    """Times and rotations of a glTF file, as its accessors have them; and the points and corners of the mesh."""
    with open(path, encoding="ascii") as file:
        document = json.load(file)
    data = base64.b64decode(document["buffers"][0]["uri"].split(",", 1)[1])
    assert len(data) == document["buffers"][0]["byteLength"]
    found = []
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        kind, width = {5126: "<f4", 5123: "<u2"}[accessor["componentType"]], {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        found.append(np.frombuffer(data, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width))
    return document, found


class Animations(Folder):
    def test_rows_and_box_of_inertia(self):
        self.solution.to_gltf(self.path("a.gltf"), speed=2.0)
        document, (times, rotations, points, corners) = buffers(self.path("a.gltf"))
        np.testing.assert_allclose(times[:, 0], self.solution.t / 2, rtol=1e-7)
        np.testing.assert_allclose(np.abs(np.sum(rotations * np.roll(self.solution.q, -1, 1), axis=1)), 1, rtol=0, atol=1e-6)
        # Neighbours on one half of the sphere: viewers need not know that q and -q are one attitude.
        self.assertTrue(np.all(np.sum(rotations[1:] * rotations[:-1], axis=1) > 0))
        self.assertEqual(document["nodes"][1]["name"], "APOPHIS")
        self.assertEqual(document["accessors"][0]["max"], [12.375])
        # The box has moments in the ratio of the body's.
        edges = np.ptp(points, axis=0).astype(float)
        moments = np.array([edges[1]**2 + edges[2]**2, edges[2]**2 + edges[0]**2, edges[0]**2 + edges[1]**2])
        np.testing.assert_allclose(moments / moments[2], [0.64, 0.97, 1.0], rtol=1e-6)
        self.assert_closed(points, corners)

    def assert_closed(self, points, corners):
        """The triangles enclose a positive volume, seen from outside counterclockwise: by the divergence theorem their fluxes add
        up, and their areas as vectors cancel."""
        a, b, c = (points[corners.reshape(-1, 3)[:, k]].astype(float) for k in range(3))
        areas = np.cross(b - a, c - a) / 2
        np.testing.assert_allclose(areas.sum(axis=0), 0, atol=1e-5 * np.abs(areas).sum())
        self.assertGreater(np.sum(areas * (a + b + c)) / 9, 0)

    def test_shapes(self):
        for shape, size, volume in (("box", (1, 2, 3), 6), ("cylinder", (1, 2), 2 * np.pi), ("cone", (1, 3), np.pi),
                                    ("sphere", (2,), 32 / 3 * np.pi), ("ellipsoid", (1, 2, 3), 8 * np.pi)):
            system = nutate.System(shape=shape, size=size, mass=2.0, center_of_mass=(0, 0, 1))
            nutate.solve(system, omega0=(0.1, 0.2, 1), t_span=(0, 1)).to_gltf(self.path("a.gltf"), object='a "b"')
            _, (_, _, points, corners) = buffers(self.path("a.gltf"))
            self.assert_closed(points, corners)
            a, b, c = (points[corners.reshape(-1, 3)[:, k]].astype(float) - (0, 0, 1) for k in range(3))
            # Of 32 sides around, a circle loses 0.6 % of its area, a sphere a little more.
            self.assertAlmostEqual(np.sum(a * np.cross(b, c)) / 6 / volume, 1, delta=0.02, msg=shape)

    def test_pygltflib_reads_it(self):
        pygltflib = package("pygltflib")
        self.solution.to_gltf(self.path("a.gltf"))
        file = pygltflib.GLTF2().load(self.path("a.gltf"))
        sampler = file.animations[0].samplers[file.animations[0].channels[0].sampler]
        self.assertEqual((file.animations[0].channels[0].target.path, sampler.interpolation), ("rotation", "LINEAR"))
        values = []
        for number, width in ((sampler.input, 1), (sampler.output, 4)):
            accessor = file.accessors[number]
            view = file.bufferViews[accessor.bufferView]
            data = file.get_data_from_buffer_uri(file.buffers[view.buffer].uri)
            values.append(np.frombuffer(data, "<f4", accessor.count * width, view.byteOffset).reshape(-1, width))
        self.assertEqual(len(values[0]), ROWS)
        np.testing.assert_allclose(values[0][:, 0], self.solution.t, rtol=1e-7)
        self.assert_same_attitudes([nutate.matrix_from_quat(nutate.quat_normalized(np.roll(q.astype(float), 1))).T for q in values[1]], 1e-6)
        parent = file.nodes[0]
        # The parent takes z, which is up, to y.
        turn = nutate.matrix_from_quat(np.roll(parent.rotation, 1))
        np.testing.assert_allclose(turn @ [0, 0, 1], [0, 1, 0], rtol=0, atol=4 * EPS)
        self.assertEqual(parent.children, [file.animations[0].channels[0].target.node])


class Kernels(Folder):
    def test_spice_has_the_attitudes(self):
        spice = package("spiceypy")
        paths = self.solution.to_spice_ck(self.path("a.bc"))
        for path in paths:
            spice.furnsh(path)
        try:
            times = nutate.tdb("2029-04-13T21:46:12.75", "TDB", self.solution.t)
            self.assert_same_attitudes([spice.pxform("J2000", "SC_BODY_1", time) for time in times], 1e-12)
            for time, omega in zip(times, self.solution.omega):
                # Derivative of the matrix from the body to space: R [omega]x.
                matrix = spice.sxform("SC_BODY_1", "J2000", time)
                rate = matrix[:3, :3].T @ matrix[3:, :3]
                np.testing.assert_allclose([rate[2, 1], rate[0, 2], rate[1, 0]], omega, rtol=0, atol=1e-12)
        finally:
            spice.kclear()

    def test_epochs_before_j2000(self):
        spice = package("spiceypy")
        paths = self.solution.to_spice_ck(self.path("a.bc"), epoch="1992-12-08", time_system="TDB", space_frame="ECLIPJ2000")
        for path in paths:
            spice.furnsh(path)
        try:
            times = nutate.tdb("1992-12-08", "TDB", self.solution.t)
            self.assert_same_attitudes([spice.pxform("ECLIPJ2000", "SC_BODY_1", time) for time in times], 1e-12)
        finally:
            spice.kclear()

    def test_what_spice_cannot_have_is_refused(self):
        package("spiceypy")
        with self.assertRaisesRegex(nutate.NutateValueError, "SPICE has no frame 'NOWHERE'"):
            self.solution.to_spice_ck(self.path("a.bc"), space_frame="nowhere")
        with self.assertRaisesRegex(nutate.NutateValueError, "is no name of SPICE"):
            self.solution.to_spice_ck(self.path("a.bc"), body_frame="a b")
        with open(self.path("a.tsc"), "w", encoding="ascii") as file:
            file.write("mine")
        with self.assertRaisesRegex(nutate.NutateValueError, "a.tsc exists and is not a kernel"):
            self.solution.to_spice_ck(self.path("a.bc"))
        self.assertEqual(os.listdir(self.folder), ["a.tsc"])

    def test_without_spiceypy_the_error_says_so(self):
        with unittest.mock.patch.dict("sys.modules", {"spiceypy": None}):
            with self.assertRaisesRegex(ImportError, "needs the package spiceypy"):
                self.solution.to_spice_ck(self.path("a.bc"))


class Resampling(Folder):
    def test_a_constant_rate_between_the_rows_keeps_to_the_error(self):
        from nutate.exchange import constant_rate, distances, resampled
        counts = []
        for error in (1e-2, 1e-3, 1e-4):
            times = resampled(self.solution.sol, error)
            counts.append(len(times))
            self.assertEqual((times[0], times[-1]), (0.0, 24.75))
            q, omega = self.solution.sol(times)
            worst = 0.0
            for s in np.linspace(0.02, 0.98, 25):
                inside = times[:-1] + s * np.diff(times)
                between = constant_rate(q[:-1], q[1:], np.full(len(inside), s))
                worst = max(worst, float(np.max(distances(self.solution.sol(inside)[0], between))))
            self.assertLessEqual(worst, error)
            # h^2 |dOmega/dt|/8: halving leaves it between a fifth of the error and all of it somewhere.
            self.assertGreater(worst, error / 5)
        # Rows grow as the root of the error; where 1e-2 is not limited by a turn of a radian.
        self.assertAlmostEqual(counts[2] / counts[1], 10**0.5, delta=1.2)

    def test_files_have_the_chosen_rows(self):
        self.solution.to_aem(self.path("a.aem"), error=1e-3)
        rows = nutate.read_aem(self.path("a.aem"))
        q, omega = self.solution.sol(rows.t)
        self.assertGreater(len(rows.t), ROWS)
        np.testing.assert_allclose(rows.q, q, rtol=0, atol=2 * EPS)
        np.testing.assert_allclose(rows.omega, omega, rtol=0, atol=1e-14)
        self.assertIn("within 0.001 rad", pathlib.Path(self.path("a.aem")).read_text(encoding="ascii"))

    def test_ends_of_steps_are_not_exported_as_they_are(self):
        from nutate.exchange import constant_rate, distances
        solution = nutate.solve(nutate.Scene(text=SCENE), accuracy=1e-10)
        solution.to_aem(self.path("a.aem"))
        rows = nutate.read_aem(self.path("a.aem"))
        middle = (rows.t[:-1] + rows.t[1:]) / 2
        between = constant_rate(rows.q[:-1], rows.q[1:], np.full(len(middle), 0.5))
        self.assertLessEqual(np.max(distances(solution.sol(middle)[0], between)), 1e-5)

    def test_rows_half_a_turn_apart_are_rejected(self):
        solution = nutate.solve(nutate.Scene(text=SCENE), t_eval=np.arange(0.0, 24.0, 4.0))
        for write in (solution.to_aem, solution.to_gltf):
            with self.assertRaisesRegex(nutate.NutateValueError, "turns by half a turn or more from the row at t = 0.0 s"):
                write(self.path("far"))

    def test_it_needs_dense_output(self):
        solution = nutate.solve(nutate.Scene(text=SCENE), t_eval=[0, 1], dense_output=False)
        with self.assertRaisesRegex(nutate.NutateValueError, "dense output"):
            solution.to_aem(self.path("a.aem"), error=1e-3)
        with self.assertRaisesRegex(nutate.NutateValueError, "1e-12 to 1 rad"):
            self.solution.to_gltf(self.path("a.gltf"), error=-1.0)


class Scenes(Folder):
    def test_labels(self):
        labels = nutate.Scene(text=SCENE).labels
        self.assertEqual(labels, {"epoch": "2029-04-13T21:46:12.75", "time_system": "TDB", "object": "APOPHIS", "object_id": "2004-MN4",
                                  "space_frame": "ICRF", "body_frame": "SC_BODY_1"})
        self.assertEqual(set(nutate.Scene(text=re.sub("(?s)&scene.*?/\n", "", SCENE, count=1)).labels.values()), {""})

    def test_files_of_rows_have_dates_on_request(self):
        scene = nutate.Scene(text=SCENE + "&output interval = 0.25, calendar = .true. /\n&event name = 'x', when = 'omega1', crosses = 0 /\n")
        scene.write(self.path("a.csv"))
        lines = pathlib.Path(self.path("a.csv")).read_text(encoding="ascii").splitlines()
        self.assertTrue(lines[0].startswith("t,date,q0,"))
        self.assertTrue(lines[2].startswith("0.25,2029-04-13T21:46:13,"))
        events = pathlib.Path(self.path("a.events.csv")).read_text(encoding="ascii").splitlines()
        self.assertTrue(events[0].startswith("t,event,number,date,q0"))
        t, date = float(events[1].split(",")[0]), events[1].split(",")[3]
        self.assertEqual(date, nutate.date("2029-04-13T21:46:12.75", "TDB", t))
        # In memory there are numbers alone.
        self.assertNotIn("date", scene.run())


if __name__ == "__main__":
    unittest.main()
