"""&frame: the attitude of a message as a frame that columns and events refer to."""
import math
import os
import re
import unittest

from support import CommandLineTest
from test_export import angle, slerp

LABELS = "epoch = '2029-04-13T21:46:12.75', time_system = 'TDB', space_frame = 'ICRF'"
# Tumbles with up to 5.8 rad/s; 8 s.
TARGET = f"""&scene {LABELS}, object = 'TARGET' /
&body inertia = 0.64, 0.97, 1.0 /
&initial quaternion = 0.6, 0.0, 0.8, 0.0, angular_velocity = 1.2, 0.1, 5.6 /
&integrator accuracy = 1e-11, end_time = 8 /
&output interval = 0.0625, columns = 'quaternion', 'angular_velocity' /
"""
CHASER = f"""&scene {LABELS}, object = 'CHASER' /
&body inertia = 1.0, 1.2, 1.5 /
&initial quaternion = 0.0, 0.6, 0.0, -0.8, angular_velocity = -0.3, 0.2, 0.7 /
&frame attitude = 'target.aem' /
&integrator accuracy = 1e-11, end_time = 8 /
&output interval = 0.0625, columns = 'quaternion', 'frame1' /
"""
EPS = 2.0**-52


def product(a, b):
    return [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]]


def relative(frame, q):
    """The attitude q as seen from a frame."""
    return product([frame[0], -frame[1], -frame[2], -frame[3]], q)


def message(records, system="TDB", frame="ICRF", kind="QUATERNION", version="2.0", extra=()):
    """An AEM with these lines of data."""
    return "\n".join((f"CCSDS_AEM_VERS = {version}", "META_START", "OBJECT_NAME = TARGET", "OBJECT_ID = X", f"REF_FRAME_A = {frame}",
                      "REF_FRAME_B = SC_BODY_1", f"TIME_SYSTEM = {system}", f"ATTITUDE_TYPE = {kind}", *extra, "META_STOP", "DATA_START",
                      *records, "DATA_STOP", ""))


class FrameTest(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("target.nml", TARGET)
        self.write("chaser.nml", CHASER)

    def make_message(self, interval, *options, name="target.aem"):
        """Runs the target and exports its rows."""
        self.succeed("run", "target.nml", "--quiet", "--set", f"output.interval={interval}", "--output", "sparse.csv")
        self.succeed("export", "sparse.csv", "--scene", "target.nml", "--aem", name, *options)

    def angles_of_own(self, interval):
        """Angles of the target relative to its own message, at quarters of its intervals."""
        self.succeed("run", "target.nml", "--quiet", "--set", "frame.attitude='target.aem'", "--set", f"output.interval={interval / 4}",
                     "--set", "output.columns='frame1'")
        header, rows = self.history("target.csv")
        self.assertEqual(header, ["t", "frame1_q0", "frame1_q1", "frame1_q2", "frame1_q3", "frame1_angle"])
        for row in rows:
            # By the vector: the scalar has lost half of the digits.
            self.assertAlmostEqual(row[5], 2 * math.asin(math.hypot(*row[2:5])), delta=4 * EPS)
        return [row[5] for row in rows]


class Attitudes(FrameTest):
    def test_a_run_is_at_rest_in_the_frame_of_its_own_message_but_for_the_interpolation(self):
        largest = []
        for interval in (0.0625, 0.03125):
            self.make_message(interval)
            angles = self.angles_of_own(interval)
            self.assertLess(max(angles[::4]), 1e-11 + 8 * EPS)
            largest.append(max(angles))
            # h^4/384 of the fourth derivative of the rotation vector, which has the size of the fourth power of the rate.
            self.assertLess(largest[-1], (interval * 5.8)**4 / 384)
        self.assertGreater(largest[0], 1e-8)
        self.assertAlmostEqual(largest[0] / largest[1], 16, delta=1)

    def test_without_rates_the_frame_turns_at_a_constant_one(self):
        largest = []
        for interval in (0.125, 0.0625):
            self.make_message(interval, "--aem-version", "1.0")
            largest.append(max(self.angles_of_own(interval)))
            self.assertLess(largest[-1], interval**2 * 5.8**2 / 8)
        self.assertAlmostEqual(largest[0] / largest[1], 4, delta=0.3)

    def test_columns_are_the_attitude_seen_from_the_message(self):
        for version in ("2.0", "1.0"):
            self.make_message(0.125, "--aem-version", version)
            nodes = [row[1:5] for row in self.history("sparse.csv")[1]]
            self.succeed("run", "target.nml", "--quiet")
            exact = [row[1:5] for row in self.history("target.csv")[1]]
            self.succeed("run", "chaser.nml", "--quiet")
            rows = self.history("chaser.csv")[1]
            self.assertEqual(len(rows), 129)
            before = rows[0][5:9]
            for i, row in enumerate(rows):
                frame, bound = (nodes[i // 2], 8 * EPS) if i % 2 == 0 else \
                    (slerp(nodes[i // 2], nodes[i // 2 + 1], 0.5), 16 * EPS) if version == "1.0" else (exact[i], 1e-3)
                expected = relative(frame, row[1:5])
                self.assertLess(angle(row[5:9], expected), bound)
                self.assertAlmostEqual(row[9], 2 * math.acos(min(1.0, abs(expected[0]))), delta=max(bound, 1e-7))
                # The sign does not jump.
                self.assertGreater(sum(a * b for a, b in zip(before, row[5:9])), 0.8)
                before = row[5:9]

    def test_a_frame_moves_nothing(self):
        self.make_message(0.125)
        self.write("alone.nml", CHASER.replace("&frame attitude = 'target.aem' /\n", "").replace(", 'frame1'", ""))
        self.succeed("run", "alone.nml", "--quiet")
        plain = self.read("alone.csv")
        for columns in ("'quaternion'", "'quaternion','frame1'"):
            self.succeed("run", "chaser.nml", "--quiet", "--set", f"output.columns={columns}")
            lines = [line.split(",")[:5] for line in self.read("chaser.csv").splitlines()]
            self.assertEqual(lines, [line.split(",") for line in plain.splitlines()])

    def test_axes_that_rotate(self):
        self.write("target.nml", TARGET.replace("accuracy = 1e-11", "time_step = 0.0078125, order = 8, formulation = 'reduced'")
                   .replace("'ICRF'", "'LAB'") + "&rotating_frame rate = 0.2, -0.3, 0.9 /\n")
        largest = []
        for interval in (0.0625, 0.03125):
            self.make_message(interval)
            largest.append(max(self.angles_of_own(interval)))
        self.assertAlmostEqual(largest[0] / largest[1], 16, delta=1)

    def test_ecliptic_axes_are_equatorial_in_the_message(self):
        self.write("target.nml", TARGET.replace("'ICRF'", "'ECLIPJ2000'"))
        self.make_message(0.0625)
        self.assertIn("REF_FRAME_A = EME2000", self.read("target.aem"))
        self.assertLess(max(self.angles_of_own(0.0625)), 1e-4)

    def test_backward_in_time(self):
        self.make_message(0.125)
        self.write("back.nml", CHASER.replace("12.75", "20.75").replace("end_time = 8", "end_time = -8"))
        self.succeed("run", "back.nml", "--quiet")
        frames = [row[1:5] for row in self.history("sparse.csv")[1]]
        for row, frame in zip(self.history("back.csv")[1][::2], reversed(frames)):
            self.assertLess(angle(row[5:9], relative(frame, row[1:5])), 8 * EPS)

    def test_degrees_and_several_frames(self):
        self.make_message(0.125)
        self.make_message(0.0625, name="plan.aem")
        self.write("chaser.nml", CHASER + "&frame attitude = 'plan.aem' /\n")
        self.succeed("run", "chaser.nml", "--quiet", "--set", "output.columns='frame2','frame1'", "--set", "output.degrees=.true.")
        header, rows = self.history("chaser.csv")
        self.assertEqual(header[5:7] + header[-1:], ["frame1_angle_deg", "frame2_q0", "frame2_angle_deg"])
        for row in rows[::2]:
            self.assertAlmostEqual(row[5], row[10], delta=1e-9)
            self.assertAlmostEqual(math.cos(math.radians(row[5]) / 2), abs(row[1]), delta=4 * EPS)


# A sphere at rest; the frame turns at 1 rad/s about z, its records every 0.5 rad.
REST = """&scene epoch = '2020-01-01T00:00:37', time_system = 'TAI' /
&body inertia = 1, 1, 1 /
&initial angular_velocity = 0, 0, 0 /
&frame attitude = 'rotating.aem' /
"""


def rotating(last=200, interval=0.5, rates=True, system="TAI", start="2020-01-01T00:00:37"):
    """A message of a frame that turns at 1 rad/s about z, for less than an hour."""
    hour, minute, second = (float(part) for part in start[11:].split(":"))
    lines = []
    for i in range(last + 1):
        t = i * interval
        m, s = divmod(60 * minute + second + t, 60)
        lines.append(f"{start[:11]}{int(hour):02d}:{int(m):02d}:{s:09.6f} 0 0 {math.sin(t / 2)!r} {math.cos(t / 2)!r}"
                     + f" 0 0 {math.degrees(1)!r}" * rates)
    return message(lines, system, kind="QUATERNION/ANGVEL" if rates else "QUATERNION", extra=("ANGVEL_FRAME = REF_FRAME_B",) * rates)


def conjugate(q):
    return [q[0], -q[1], -q[2], -q[3]]


class Rates(FrameTest):
    """The same motion by each type of rates."""

    def columns(self, text):
        self.write("target.aem", text)
        self.succeed("run", "chaser.nml", "--quiet", "--set", "output.columns=frame1")
        return self.history("chaser.csv")[1]

    def test_rates_of_every_type_give_the_same_frame(self):
        self.make_message(0.25)
        given = self.read("target.aem").splitlines()
        lines = [line.split() for line in given[given.index("DATA_START") + 1:given.index("DATA_STOP")]]
        records = [(line[0], [float(x) for x in line[4:5] + line[1:4]], [0.0] + [float(x) for x in line[5:]]) for line in lines]
        expected = self.columns(self.read("target.aem"))
        without = self.columns(message([" ".join(line[:5]) for line in lines]))
        self.assertGreater(max(abs(a - b) for x, y in zip(expected, without) for a, b in zip(x, y)), 1e-3)

        def text(q, first):
            return " ".join(repr(x) for x in (q if first else q[1:] + q[:1]))

        for version, direction, first in (("2.0", "", False), ("1.0", "A2B", False), ("1.0", "A2B", True), ("1.0", "B2A", True)):
            kind = f"QUATERNION_TYPE = {'FIRST' if first else 'LAST'}"
            extra = (f"ATTITUDE_DIR = {direction}", kind) if direction else ()
            turn = conjugate if direction == "B2A" else list
            rows = []
            for date, q, omega in records:
                rate = [math.radians(x) / 2 for x in product(q, omega)]
                rows.append(f"{date} {text(turn(q), first)} {text(turn(rate), first)}")
            derivative = message(rows, version=version, kind="QUATERNION/DERIVATIVE", extra=extra)
            found = {"derivative": derivative}
            for axes in ("REF_FRAME_A", "REF_FRAME_B") if direction else ():
                rows = []
                for date, q, omega in records:
                    rate = product(product(q, omega), conjugate(q)) if axes == "REF_FRAME_A" else omega
                    sign = -1 if direction == "B2A" else 1
                    rows.append(f"{date} {text(turn(q), first)} " + " ".join(repr(sign * x) for x in rate[1:]))
                found[axes] = message(rows, version=version, kind="QUATERNION/RATE", extra=(*extra, f"RATE_FRAME = {axes}"))
            for name, content in found.items():
                for row, wanted in zip(self.columns(content), expected):
                    for a, b in zip(row, wanted):
                        self.assertAlmostEqual(a, b, delta=1e-9, msg=(version, direction, name))

    def test_rates_that_say_something_else_are_rejected(self):
        records = ["2029-04-13T21:46:12.7 0 0 0 1 0 0 1", "2029-04-13T23:46:12.7 0 0 0 1 0 0 1"]
        first = ("ATTITUDE_DIR = A2B", "QUATERNION_TYPE = LAST")
        for version, extra, says in (("2.0", ("RATE_FRAME = REF_FRAME_B",), "'QUATERNION/RATE' is one of version 1.0 (expected QUATERNION/ANGVEL)"),
                                     ("1.0", first, "RATE_FRAME is absent or unknown (expected REF_FRAME_A or REF_FRAME_B)"),
                                     ("1.0", (*first, "RATE_FRAME = REF_FRAME_B", "EULER_ROT_SEQ = 313"), "rates of Euler angles are not read")):
            self.write("target.aem", message(records, version=version, kind="QUATERNION/RATE", extra=extra))
            self.fail_with(2, "check", "chaser.nml", says=("target.aem:", says))

    def test_a_fast_record_at_either_end_may_be_half_a_turn_away(self):
        # From rest to 54 deg/s in 8 s the frame turns by 216 degrees, not by the 144 of the shorter way back.
        rows = ["0 0 0 1 0 0 0", "0 0 0.9510565162951535 -0.3090169943749474 0 0 54"]
        for order in (rows, rows[::-1]):
            self.write("target.aem", message([f"2029-04-13T21:46:{s} {row}" for s, row in zip(("12.75", "20.75"), order)],
                                             kind="QUATERNION/ANGVEL", extra=("ANGVEL_FRAME = REF_FRAME_B",)))
            self.fail_with(2, "check", "chaser.nml", says=("target.aem:", "the next record is half a turn or more away"))


class Events(FrameTest):
    def events(self, text):
        self.write("rest.nml", REST + text)
        self.succeed("run", "rest.nml", "--quiet")
        return [(float(line.split(",")[0]), line.split(",")[1]) for line in self.read("rest.events.csv").splitlines()[1:]]

    def test_every_crossing_of_an_angle_is_found_however_long_the_steps(self):
        # At rest a step may be as long as the run: 32 half turns of the frame.
        for rates in (True, False):
            self.write("rotating.aem", rotating(rates=rates))
            for steps in ("method = 'exact', time_step = 100, end_time = 100", "method = 'taylor', time_step = 50, end_time = 100",
                          "accuracy = 1e-9, end_time = 100", "method = 'rk4', time_step = 1, end_time = 100"):
                found = self.events("&event when = 'frame1_angle', crosses = 1 /\n&event when = 'frame1_q3', crosses = 0 /\n"
                                    f"&integrator {steps} /\n&output interval = 100 /\n")
                expected = sorted(2 * math.pi * k + side for k in range(17) for side in (1, -1) if 0 < 2 * math.pi * k + side < 100)
                times = [t for t, name in found if name == "frame1_angle"]
                self.assertEqual(len(times), len(expected), (rates, steps))
                for time, wanted in zip(times, expected):
                    self.assertAlmostEqual(time, wanted, delta=1e-10)
                times = [t for t, name in found if name == "frame1_q3"]
                self.assertEqual(len(times), 15)
                for k, time in enumerate(times):
                    self.assertAlmostEqual(time, 2 * math.pi * (k + 1), delta=1e-10)

    def test_extrema_of_the_angle_are_at_half_turns(self):
        self.write("rotating.aem", rotating())
        found = self.events("&event when = 'frame1_angle', extremum = 'maximum' /\n&integrator accuracy = 1e-9, end_time = 100 /\n"
                            "&output interval = 1 /\n")
        self.assertEqual(len(found), 16)
        for k, (time, _) in enumerate(found):
            self.assertAlmostEqual(time, (2 * k + 1) * math.pi, delta=1e-9)

    def test_an_event_stops_and_switches(self):
        self.write("rotating.aem", rotating())
        found = self.events("&torque name = 'jet', body = 0, 0, 1, on = .false. /\n"
                            "&event when = 'frame1_angle', crosses = 1.5, direction = 1, switch = 'jet on' /\n"
                            "&event name = 'met', when = 'frame1_angle', crosses = 1.0, direction = -1, stop = .true. /\n"
                            "&integrator local_tolerance = 1e-12, end_time = 100 /\n&output columns = 'frame1' /\n")
        # From 1.5 s on the body has rotated by (t - 1.5)^2/2: t - (t - 1.5)^2/2 is 1 for the second time.
        self.assertAlmostEqual(found[0][0], 1.5, delta=1e-10)
        self.assertAlmostEqual(found[-1][0], 2.5 + math.sqrt(2.5**2 - 1.5**2 - 2), delta=1e-9)
        self.assertAlmostEqual(self.history("rest.csv")[1][-1][5], 1.0, delta=1e-9)


class Times(FrameTest):
    def rows_with(self, text):
        self.write("rotating.aem", text)
        self.write("rest.nml", REST + "&integrator time_step = 0.25, end_time = 50 /\n&output columns = 'frame1' /\n")
        self.succeed("run", "rest.nml", "--quiet")
        return self.history("rest.csv")[1]

    def test_other_time_systems_are_converted(self):
        for system, start in (("TAI", "2020-01-01T00:00:37"), ("UTC", "2020-01-01T00:00:00"), ("TT", "2020-01-01T00:01:09.184")):
            for row in self.rows_with(rotating(system=system, start=start)):
                # Days from J2000 are known to 1e-7 s.
                self.assertLess(angle(row[1:5], [math.cos(row[0] / 2), 0, 0, -math.sin(row[0] / 2)]), 1e-12 if system == "TAI" else 4e-7)

    def test_a_record_before_and_the_last_one_count(self):
        rows = self.rows_with(rotating(last=124, start="2020-01-01T00:00:25"))
        for row in rows:
            self.assertLess(angle(row[1:5], [math.cos(row[0] / 2 + 6), 0, 0, -math.sin(row[0] / 2 + 6)]), 1e-12)
        for last, text in ((123, "rest.nml:5: end_time is outside of the records of 'rotating.aem' (expected -12 to 49.5 s)"),
                           (10, "rest.nml:4: the records of 'rotating.aem' go from -12 to -7 s (expected records that contain t = 0)")):
            self.write("rotating.aem", rotating(last=last, start="2020-01-01T00:00:25"))
            self.fail_with(2, "run", "rest.nml", says=(text,))
            self.fail_with(2, "check", "rest.nml", says=(text,))

    def test_messages_that_are_none_are_refused_with_file_and_line(self):
        self.rows_with(rotating())
        good = self.read("rotating.aem")
        for bad, text in ((good.replace("TIME_SYSTEM = TAI", "TIME_SYSTEM = GPS"), "rotating.aem:10: TIME_SYSTEM 'GPS' is not supported"),
                          (good.replace("2020-01-01T00:00:38.000000 0 0 ", "2020-01-01T00:00:38.000000 0 0 nan "),
                           "rotating.aem:14: 'nan' is not a number"),
                          (good.replace("DATA_STOP\n", ""), "the message ends too early"),
                          ("t,q0\n0,1\n", "rotating.aem:1: 't,q0' is out of place"), ("", "not an attitude ephemeris message")):
            self.assertNotEqual(bad, good)
            self.write("rotating.aem", bad)
            self.fail_with(2, "run", "rest.nml", says=(text,))
        self.write("rotating.aem", good)
        self.fail_with(2, "run", "rest.nml", "--set", "scene.space_frame='EME2000'", says=("REF_FRAME_A of rotating.aem is 'ICRF'",))
        self.fail_with(2, "run", "rest.nml", "--unset", "scene.epoch", "--unset", "scene.time_system",
                       says=("rest.nml:4: the records of rotating.aem have dates", "expected epoch and time_system of &scene"))

    def test_axes_that_rotate_are_not_inertial(self):
        self.rows_with(rotating())
        good = self.read("rotating.aem")
        scene = self.read("rest.nml")
        orbit, lab = "&orbit altitude = 500e3 /\n", "&rotating_frame rate = 0, 0, 0.5 /\n"
        for group, frame, says in ((orbit, "LVLH", "names axes that rotate"), (orbit.replace(" /", ", frame = 'lvlh' /"), "RSW_ROTATING", "rotate"),
                                   (orbit, "ITRF-97", "rotate"), (lab, "ICRF", "the space axes rotate, and REF_FRAME_A of rotating.aem")):
            self.write("rotating.aem", good.replace("REF_FRAME_A = ICRF", "REF_FRAME_A = " + frame))
            self.write("rest.nml", scene + group)
            self.fail_with(2, "run", "rest.nml", says=("rest.nml:4: ", f"'{frame}'", says))
        for group, frame in ((orbit, "TNW_INERTIAL"), (lab, "LVLH"), ("", "ITRF-97")):
            self.write("rotating.aem", good.replace("REF_FRAME_A = ICRF", "REF_FRAME_A = " + frame))
            self.write("rest.nml", scene + group)
            self.succeed("check", "rest.nml")

    def test_names_of_frames_in_any_case(self):
        small = {"ICRF": "icrf", "object = ": "body_frame = 'panel', object = "}
        for name in ("target.nml", "chaser.nml"):
            text = self.read(name)
            for old, new in small.items():
                text = text.replace(old, new)
            self.write(name, text)
        self.make_message(0.0625)
        self.succeed("check", "chaser.nml")
        self.write("fit.nml", self.read("chaser.nml") + "&free key = 'initial.attitude' /\n"
                   "&measurement file = 'target.aem', columns = 'q0', 'q1', 'q2', 'q3' /\n")
        self.succeed("check", "fit.nml")

    def test_the_message_is_not_written_over(self):
        self.rows_with(rotating())
        self.fail_with(2, "run", "rest.nml", "--output", "rotating.aem", says=("rotating.aem",))
        self.assertEqual(self.read("rotating.aem"), rotating())

    def test_check_names_the_message(self):
        self.rows_with(rotating())
        page = self.succeed("check", "rest.nml").stdout
        self.assertIn("attitude of rotating.aem, 201 records from 0 to 100 s, with rates\n", page)
        self.assertIn("torque-free rigid body", page)


class Parts(FrameTest):
    def test_a_resumed_run_has_the_same_bytes(self):
        self.make_message(0.125)
        self.write("chaser.nml", CHASER.replace("accuracy = 1e-11", "time_step = 0.0625") + "&damping coefficient = 0.1, 0.1, 0.1 /\n"
                   "&event when = 'frame1_angle', crosses = 1.5 /\n&event when = 'frame1_q2', extremum = 'both' /\n")
        for method in ("nielsen_krenk", "dop853", "taylor"):
            setting = ("--set", f"integrator.method={method}")
            self.succeed("run", "chaser.nml", "--quiet", "--output", "whole.csv", *setting)
            self.assertGreater(self.read("whole.events.csv").count("\n"), 5)
            for limit in (1, 50, 127):
                self.fail_with(3, "run", "chaser.nml", "--output", "part.csv", "--checkpoint", "ck", "--max-steps", str(limit), *setting,
                               says=["to continue: --resume ck"])
                self.succeed("run", "chaser.nml", "--resume", "ck", *setting)
                self.assertEqual(self.read("part.csv"), self.read("whole.csv"))
                self.assertEqual(self.read("part.events.csv"), self.read("whole.events.csv"))
        # Another message is another scene.
        self.fail_with(3, "run", "chaser.nml", "--output", "part.csv", "--checkpoint", "ck", "--max-steps", "9")
        self.make_message(0.25)
        self.fail_with(2, "run", "chaser.nml", "--resume", "ck", says=["ck"])

    def test_members_of_a_sweep_see_the_frame(self):
        self.make_message(0.125)
        ends = [row[1:5] for row in self.history("sparse.csv")[1]]
        sweep = "&ensemble members = 8, rows = 'final' /\n&vary key = '{}', distribution = 'uniform', low = {}, high = {} /\n"
        for key, low, high in (("initial.angular_velocity.1", -1, 1), ("body.inertia.1", 0.9, 1.1), ("damping.coefficient.1", 0, 1)):
            self.write("chaser.nml", CHASER + "&damping coefficient = 0.1, 0.1, 0.1 /\n" + sweep.format(key, low, high))
            self.succeed("sweep", "chaser.nml", "--quiet", "--output", "rows.npy", "--csv", "rows.csv")
            header, *rows = [line.split(",") for line in self.read("rows.csv").splitlines()]
            first = header.index("q0")
            self.assertEqual(header[first + 4:first + 9], ["frame1_q0", "frame1_q1", "frame1_q2", "frame1_q3", "frame1_angle"])
            self.assertEqual(len(rows), 8)
            self.assertEqual(len({row[first] for row in rows}), 8)
            for row in rows:
                values = [float(field) for field in row[first:first + 8]]
                self.assertLess(angle(values[4:], relative(ends[-1], values[:4])), 8 * EPS)

    def test_a_member_that_goes_beyond_the_message_is_refused(self):
        self.make_message(0.125)
        self.write("chaser.nml", CHASER.replace("accuracy = 1e-11", "time_step = 0.0625") + "&ensemble members = 4 /\n"
                   "&vary key = 'integrator.end_time', distribution = 'grid', low = 6, high = 12, points = 4 /\n")
        self.succeed("sweep", "chaser.nml", "--quiet", "--output", "rows.npy", "--csv", "rows.csv")
        self.assertEqual([line.split(",")[1] for line in self.read("rows.csv").splitlines()[1:]], ["0", "0", "7", "7"])
        self.fail_with(3, "sweep", "chaser.nml", "--member", "3", says=["member 3: end_time is outside of the records of 'target.aem'"])

    def test_a_fitted_scene_finds_its_frame_from_any_folder(self):
        self.make_message(0.125)
        self.succeed("run", "chaser.nml", "--quiet", "--output", "measured.csv")
        self.write("chaser.nml", CHASER.replace("0.7 /", "0.69 /").replace("accuracy = 1e-11", "local_tolerance = 1e-11") + "&free key = 'initial.angular_velocity.3' /\n"
                   "&measurement file = 'measured.csv', columns = 'q0', 'q1', 'q2', 'q3', sigma = 1e-3 /\n")
        os.mkdir(self.path("one"))
        for output in ("fit.nml", "one/fit.nml"):
            self.succeed("fit", "chaser.nml", "--quiet", "--output", output)
            self.assertIn(" of ", self.succeed("check", output).stdout)
            self.succeed("run", output, "--quiet", "--output", "fitted.csv", "--set", "output.columns='quaternion','frame1'")
            for row, truth in zip(self.history("fitted.csv")[1], self.history("measured.csv")[1]):
                self.assertLess(angle(row[5:9], truth[5:9]), 1e-8)

    def test_the_angle_from_a_frame_is_measured(self):
        self.make_message(0.125)
        self.succeed("run", "chaser.nml", "--quiet", "--set", "output.columns='frame1'", "--output", "angle.csv")
        rows = [(row[0], row[5]) for row in self.history("angle.csv")[1] if 0.02 < row[5] < 3.12]
        self.assertGreater(len(rows), 50)
        self.write("angle.csv", "t,frame1_angle\n" + "".join(f"{t!r},{x!r}\n" for t, x in rows))
        self.write("fit.nml", CHASER.split("&output")[0].replace("-0.3, 0.2, 0.7", "-0.31, 0.19, 0.705")
                   + "&free key = 'initial.angular_velocity' /\n&measurement file = 'angle.csv', columns = 'frame1_angle', sigma = 1e-6 /\n")
        page = self.succeed("fit", "fit.nml").stdout
        fitted = re.findall(r"initial\.angular_velocity\.\d +(\S+) ±", page)
        for value, truth in zip(fitted, (-0.3, 0.2, 0.7), strict=True):
            self.assertAlmostEqual(float(value), truth, delta=1e-7)

    def test_the_folder_of_the_scene_is_where_names_begin(self):
        self.make_message(0.125)
        os.mkdir(self.path("one"))
        os.rename(self.path("target.aem"), self.path("one/target.aem"))
        os.rename(self.path("chaser.nml"), self.path("one/chaser.nml"))
        self.succeed("run", "one/chaser.nml", "--quiet")
        self.assertIn("attitude of target.aem, 65 records", self.succeed("check", "one/chaser.nml").stdout)


if __name__ == "__main__":
    unittest.main()
