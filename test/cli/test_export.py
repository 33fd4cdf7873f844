"""nutate export HISTORY.csv, and dates of scenes and histories."""
import base64
import json
import math
import os
import random
import re
import struct
import subprocess
import unittest

from support import PATIENCE, CommandLineTest, share_of

TUMBLER = """&scene title = 'Tumbler', epoch = '2029-04-13T21:46:12.75', time_system = 'TDB', object = 'APOPHIS',
   object_id = '2004-MN4', space_frame = 'ICRF' /
&body inertia = 0.64, 0.97, 1.0 /
&initial quaternion = 0.6, 0.0, 0.8, 0.0, angular_velocity = 1.2, 0.1, 5.6 /
&integrator accuracy = 1e-10, end_time = 9.9 /
&output interval = 0.1 /
"""
LABELS = ("--set", "scene.epoch=2029-04-13T21:46:12.75", "--set", "scene.time_system=TDB", "--set", "scene.space_frame=ICRF")


def records(text):
    """Dates and numbers of an AEM."""
    lines = text[text.index("DATA_START\n") + 11:text.index("DATA_STOP")].splitlines()
    return [(line.split()[0], [float(word) for word in line.split()[1:]]) for line in lines]


def keywords(text):
    """The metadata of an AEM."""
    return dict(line.split(" = ", 1) for line in text.splitlines() if " = " in line)


def angle(a, b):
    """Angle between two attitudes, by the chord: the cosine would lose half of the digits."""
    sign = 1 if sum(x * y for x, y in zip(a, b)) >= 0 else -1
    return 4 * math.asin(min(1.0, math.sqrt(sum((x - sign * y)**2 for x, y in zip(a, b))) / 2))


def slerp(a, b, s):
    """Between two attitudes at a constant rate."""
    half = angle(a, b) / 2
    sign = 1 if sum(x * y for x, y in zip(a, b)) >= 0 else -1
    if half < 1e-12:
        return a
    return [(math.sin((1 - s) * half) * x + sign * math.sin(s * half) * y) / math.sin(half) for x, y in zip(a, b)]


def animation(text):
    """Times and rotations of a glTF file."""
    document = json.loads(text)
    data = base64.b64decode(document["buffers"][0]["uri"].split(",")[1])
    found = []
    for accessor, width in zip(document["accessors"][:2], (1, 4)):
        start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
        found.append(struct.unpack_from(f"<{accessor['count'] * width}f", data, start))
    return document, found[0], [found[1][4 * i:4 * i + 4] for i in range(len(found[0]))]

SATELLITE = """&scene epoch = '2026-03-20T12:00:00', time_system = 'UTC', object = 'SAT', space_frame = 'J2000' /
&body inertia = 0.12, 0.1, 0.04 /
&initial attitude_from = 'lvlh', rate_from = 'lvlh', angular_velocity = 3*0.0 /
&orbit altitude = 500e3, inclination = 97.4, raan = 30, degrees = .true. /
&gravity_gradient /
&integrator accuracy = 1e-10, end_time = 1000 /
&output interval = 100 /
"""


class Exports(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("tumbler.nml", TUMBLER)
        self.succeed("run", "tumbler.nml", "--quiet")
        self.rows = self.history("tumbler.csv")[1]

    def test_text_has_no_name_of_a_binary_gltf(self):
        for name in ("tumbler.glb", "T.GLB", ".glb"):
            self.fail_with(2, "export", "tumbler.csv", "--scene", "tumbler.nml", "--gltf", name,
                           says=(f"{name} is the name of a binary glTF (expected a name such as NAME.gltf)",))
            self.assertNotIn(name, self.names())
        self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--gltf", "glb")

    def test_rows_half_a_turn_apart_are_rejected(self):
        self.write("far.nml", TUMBLER)
        self.succeed("run", "far.nml", "--quiet", "--set", "output.interval=0.9")
        for kind in ("--aem", "--gltf"):
            self.fail_with(2, "export", "far.csv", "--scene", "far.nml", kind, "far.out",
                           says=("nutate: far.csv: the body turns by half a turn or more from one row to the next at t = 0 s",
                                 "(expected rows up to 0.5"))

    def test_rows_half_a_turn_apart_are_rejected_without_rates(self):
        # The second and third row are half a turn apart but for round-off, which has no sense.
        s = 0.5**0.5
        for rows in ("0,1,0,0,0\n1,0,0,1,0\n", f"0,1,0,0,0\n1,{s},{s},0,0\n2,{s},{-s},0,0\n", f"0,{s},{s},0,0\n1,{s - 1e-9},{-s},0,0\n",
                     "0,1,0,0,0,0,0,1\n1,0,0,0,1,0,0,1\n"):
            self.write("still.csv", "t,q0,q1,q2,q3" + ",omega1,omega2,omega3" * (rows.count(",") > 12) + "\n" + rows)
            for kind in ("--aem", "--gltf"):
                self.fail_with(2, "export", "still.csv", "--scene", "tumbler.nml", kind, "x.out",
                               says=("still.csv: the body turns by half a turn or more from one row to the next at t = ", "s (expected rows closer together)"))
        self.write("still.csv", "t,q0,q1,q2,q3\n0,1,0,0,0\n1,1e-5,1,0,0\n")
        self.succeed("export", "still.csv", "--scene", "tumbler.nml", "--aem", "x.out")

    def test_aem_has_every_attitude_and_says_what_it_means(self):
        self.assertEqual(self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "a.aem").stdout, "")
        text = self.read("a.aem")
        self.assertTrue(text.startswith("CCSDS_AEM_VERS = 2.0\n"))
        self.assertIn("COMMENT the quaternion turns coordinates of REF_FRAME_A into those of REF_FRAME_B; QC, its last component, is the scalar\n", text)
        found = keywords(text)
        self.assertEqual({key: found[key] for key in ("OBJECT_NAME", "OBJECT_ID", "REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM", "START_TIME",
                                                      "STOP_TIME", "ATTITUDE_TYPE", "ANGVEL_FRAME")},
                         {"OBJECT_NAME": "APOPHIS", "OBJECT_ID": "2004-MN4", "REF_FRAME_A": "ICRF", "REF_FRAME_B": "SC_BODY_1", "TIME_SYSTEM": "TDB",
                          "START_TIME": "2029-04-13T21:46:12.750000", "STOP_TIME": "2029-04-13T21:46:22.650000",
                          "ATTITUDE_TYPE": "QUATERNION/ANGVEL", "ANGVEL_FRAME": "REF_FRAME_B"})
        self.assertNotIn("ATTITUDE_DIR", found)
        lines = records(text)
        self.assertEqual(len(lines), 100)
        self.assertEqual(lines[1][0], "2029-04-13T21:46:12.850000")
        for (_, values), row in zip(lines, self.rows):
            for value, expected in zip(values, [*row[2:5], row[1], *(math.degrees(x) for x in row[5:8])]):
                self.assertAlmostEqual(value, expected, delta=1e-13)

    def test_version_1_states_direction_and_order(self):
        text = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-", "--aem-version", "1.0").stdout
        found = keywords(text)
        self.assertEqual((found["CCSDS_AEM_VERS"], found["ATTITUDE_DIR"], found["QUATERNION_TYPE"], found["ATTITUDE_TYPE"]),
                         ("1.0", "A2B", "LAST", "QUATERNION"))
        self.assertTrue(all(len(values) == 4 for _, values in records(text)))

    def test_no_scene_is_needed_where_options_say_the_rest(self):
        text = self.succeed("export", "tumbler.csv", *LABELS, "--aem", "-").stdout
        self.assertEqual(keywords(text)["OBJECT_NAME"], "tumbler")
        with_scene = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--set", "scene.object=tumbler", "--unset",
                                  "scene.object_id", "--aem", "-").stdout
        self.assertEqual(records(text), records(with_scene))
        for says, taken in (("date of t = 0", LABELS[4:]), ("space_frame", LABELS[:4])):
            self.fail_with(2, "export", "tumbler.csv", *taken, "--aem", "x.aem", says=("tumbler.csv", says))
        self.fail_with(2, "export", "tumbler.csv", "--gltf", "x.gltf", says=("glTF needs the body",))
        self.succeed("export", "tumbler.csv", "--gltf", "x.gltf", "--set", "body.inertia=1,2,2.5")

    def test_gltf_turns_the_body(self):
        self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--gltf", "a.gltf", "--speed", "2")
        document, times, rotations = animation(self.read("a.gltf"))
        self.assertEqual(len(times), 100)
        self.assertEqual(document["animations"][0]["channels"][0]["target"], {"node": 1, "path": "rotation"})
        for t, (x, y, z, w), row in zip(times, rotations, self.rows):
            self.assertAlmostEqual(t, row[0] / 2, delta=1e-6)
            self.assertLess(angle((w, x, y, z), row[1:5]), 1e-6)

    def test_rows_are_chosen_by_an_attitude_error(self):
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.interval=0.01")
        for error in ("1e-2", "1e-3"):
            text = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-", "--error", error).stdout
            self.assertIn(f"within {float(error):g} rad", text)
            lines = records(text)
            rows = self.history("tumbler.csv")[1]
            times = [seconds(date) for date, _ in lines]
            worst, place = 0.0, 0
            for row in rows:
                while place < len(times) - 2 and times[place + 1] <= row[0]:
                    place += 1
                first, last = lines[place][1][:4], lines[place + 1][1][:4]
                between = slerp(first, last, (row[0] - times[place]) / (times[place + 1] - times[place]))
                worst = max(worst, angle(between, [*row[2:5], row[1]]))
            self.assertLessEqual(worst, float(error))
            self.assertGreater(worst, float(error) / 6)
        self.succeed("run", "tumbler.nml", "--quiet")
        self.fail_with(2, "export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "x.aem", "--error", "1e-6",
                       says=("tumbler.csv: the rows are too far apart for an error of 1e-6 rad", "rad, more than a tenth of it (expected"))
        # The limit that the message names is the right one, and not far from the error that was rejected.
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.interval=0.02")
        tight = ("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "tight.aem", "--error")
        says = self.fail_with(2, *tight, "1e-8").stderr
        own, least = (float(re.search(words + r" (\S+) rad", says)[1]) for words in ("errs by", "an error from"))
        self.assertLess(own, 1e-8)
        self.assertAlmostEqual(least / own, 10, delta=0.2)
        self.succeed(*tight, str(least))

    def test_degrees_and_histories_without_rates(self):
        whole = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-").stdout
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.degrees=.true.", "--set", "output.columns=angular_velocity,quaternion",
                     "--set", "output.calendar=.true.")
        again = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-").stdout
        for (date, values), (other, expected) in zip(records(again), records(whole)):
            self.assertEqual(date, other)
            for value, wanted in zip(values, expected):
                self.assertAlmostEqual(value, wanted, delta=1e-12 * max(1, abs(wanted)))
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.columns=quaternion")
        text = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-").stdout
        self.assertEqual(keywords(text)["ATTITUDE_TYPE"], "QUATERNION")
        self.fail_with(2, "export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "x.aem", "--error", "1e-3", says=("omega1, omega2, omega3",))

    def test_units_of_headers_are_converted(self):
        whole = records(self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-").stdout)
        header, rows = self.history("tumbler.csv")
        self.assertEqual(header[:8], ["t", "q0", "q1", "q2", "q3", "omega1", "omega2", "omega3"])
        names = ["t (min)", *header[1:5], "omega1 (deg/s)", "omega2 [rpm]", '"omega3_deg (mrad/s)"']
        factors = [1 / 60, 1, 1, 1, 1, 180 / math.pi, 30 / math.pi, 1e3]
        self.write("units.csv", "\n".join([",".join(names), *(",".join(repr(x * f) for x, f in zip(row, factors)) for row in rows)]) + "\n")
        found = records(self.succeed("export", "units.csv", "--scene", "tumbler.nml", "--aem", "-").stdout)
        self.assertEqual(len(found), len(whole))
        for (date, values), (other, expected) in zip(found, whole):
            self.assertAlmostEqual(float(date[17:]), float(other[17:]), delta=2e-6)
            self.assertEqual(len(values), len(expected))
            for value, wanted in zip(values, expected):
                self.assertAlmostEqual(value, wanted, delta=1e-12 * max(1, abs(wanted)))

    def test_units_of_another_quantity_are_rejected(self):
        lines = self.read("tumbler.csv").splitlines()
        for before, after, says in (("omega2", "omega2 (deg)", "'omega2 (deg)' has an unknown unit (expected rad/s, mrad/s"),
                                    ("q1", "q1 (deg)", "'q1 (deg)' has a unit (expected none)"),
                                    ("t,", "t (years),", "t has an unknown unit (expected s, ms"),
                                    ("t,", "t (s),t (s),", "there are two columns 't'"),
                                    ("omega2", "omega1 (rad/s)", "there are two columns 'omega1'")):
            self.write("other.csv", "\n".join([lines[0].replace(before, after, 1), *lines[1:]]) + "\n")
            self.fail_with(2, "export", "other.csv", "--scene", "tumbler.nml", "--aem", "x.aem", says=("other.csv:1: " + says,))

    def test_rates_are_relative_to_axes_that_turn(self):
        self.write("lab.nml", TUMBLER.replace("'ICRF'", "'LAB'") + "&rotating_frame rate = 0, 0, 0.5 /\n")
        self.succeed("run", "lab.nml", "--quiet", "--set", "output.interval=0.01")
        lines = [values for _, values in records(self.succeed("export", "lab.csv", "--scene", "lab.nml", "--aem", "-").stdout)]
        for first, (x, y, z, w, *rate), last in zip(lines, lines[1:], lines[2:]):
            # Twice the conjugate times the derivative by central differences, whose error is h^2/6 of the third derivative.
            a, b, c, d = ((second - one) / 0.02 for one, second in zip(first[:4], last[:4]))
            found = (w * a - x * d - y * c + z * b, w * b - y * d - z * a + x * c, w * c - z * d - x * b + y * a)
            for value, wanted in zip(found, rate):
                self.assertAlmostEqual(2 * math.degrees(value), wanted, delta=0.3)

    def test_inertial_axes_do_not_rotate(self):
        self.write("lab.nml", TUMBLER + "&rotating_frame rate = 0, 0, 0.5 /\n")
        self.succeed("run", "lab.nml", "--quiet")
        for name in ("ICRF", "j2000", "ECLIPJ2000"):
            self.fail_with(2, "export", "lab.csv", "--scene", "lab.nml", "--aem", "-", "--set", f"scene.space_frame={name}",
                           says=("lab.csv: the space axes rotate", f"'{name}' names inertial axes"))
        self.fail_with(2, "export", "lab.csv", "--scene", "lab.nml", "--aem", "-", "--error", "0.1", says=("lab.csv: the space axes rotate",))

    def test_lvlh_axes_become_inertial(self):
        self.write("sat.nml", SATELLITE)
        texts = {}
        for frame in ("lvlh", "inertial"):
            options = ["--set", f"orbit.frame={frame}"]
            self.succeed("run", "sat.nml", "--quiet", *options)
            found = self.succeed("export", "sat.csv", "--scene", "sat.nml", *options, "--aem", "-").stdout
            self.assertEqual(keywords(found)["REF_FRAME_A"], "J2000")
            texts[frame] = records(found)
            # By spherical trigonometry: x along the velocity at the node, y against the normal, z to the centre.
            for value, expected in zip(texts[frame][0][1], (0.226708, -0.669779, 0.138555, 0.693399, 0, -0.063414, 0)):
                self.assertAlmostEqual(value, expected, delta=1e-6)
        self.assertEqual(len(texts["lvlh"]), 11)
        for (date, values), (other, expected) in zip(texts["lvlh"], texts["inertial"]):
            self.assertEqual(date, other)
            for value, wanted in zip(values, expected):
                self.assertAlmostEqual(value, wanted, delta=1e-8)

    def test_names_that_a_reader_takes_otherwise_are_rejected(self):
        self.write("sat.nml", SATELLITE)
        self.succeed("run", "sat.nml", "--quiet")
        for name in ("LVLH", "ITRF2014", "rsw_rotating"):
            self.fail_with(2, "export", "sat.csv", "--scene", "sat.nml", "--aem", "-", "--set", f"scene.space_frame={name}",
                           says=(f"space_frame = '{name}' names axes that rotate", "the attitudes are in inertial axes"))
        self.succeed("export", "sat.csv", "--scene", "sat.nml", "--aem", "-", "--set", "scene.space_frame=LVLH_INERTIAL")
        for space, body in (("SC_BODY_1", "ARM"), ("LAB", "RTN"), ("SENSOR_1", "ICRF")):
            self.fail_with(2, "export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-", "--set", f"scene.space_frame={space}",
                           "--set", f"scene.body_frame={body}", says=(f"'{space}'", f"'{body}'", "vice versa"))

    def test_messages_are_read_in_lvlh_axes(self):
        librating = SATELLITE.replace("attitude_from", "roll_pitch_yaw = 0.2, 0.1, -0.1, attitude_from")
        self.write("sat.nml", librating)
        self.succeed("run", "sat.nml", "--quiet", "--set", "orbit.frame=inertial", "--set", "output.interval=10")
        self.succeed("export", "sat.csv", "--scene", "sat.nml", "--set", "orbit.frame=inertial", "--aem", "sat.aem")
        lvlh = librating.replace("&orbit", "&orbit frame = 'lvlh',")
        self.write("twin.nml", lvlh + "&frame attitude = 'sat.aem' /\n&event when = 'frame2_angle', crosses = 0.1 /\n"
                   "&frame attitude = 'at_rest.aem' /\n")
        self.succeed("run", "sat.nml", "--quiet", "--output", "at_rest.csv", "--set", "orbit.frame=inertial",
                     "--set", "initial.roll_pitch_yaw=0,0,0", "--set", "output.interval=10")
        self.succeed("export", "at_rest.csv", "--scene", "sat.nml", "--set", "orbit.frame=inertial", "--aem", "at_rest.aem")
        self.succeed("run", "twin.nml", "--quiet", "--set", "output.columns=frame1,frame2")
        rows = self.history("twin.csv")[1]
        for row in rows:
            self.assertLess(row[5], 1e-7)
        # The event and the angle by the LVLH attitude agree.
        self.succeed("run", "twin.nml", "--quiet", "--set", "output.columns=frame2,lvlh_attitude")
        header, rows = self.history("twin.csv")
        scalar, angle_of = header.index("lvlh_q0"), header.index("frame2_angle")
        for row in rows:
            self.assertAlmostEqual(row[angle_of], 2 * math.acos(min(1.0, abs(row[scalar]))), delta=1e-7)
        self.assertGreater(len(self.read("twin.events.csv").splitlines()), 1)
        self.write("fit.nml", lvlh.replace("0.12, 0.1, 0.04", "0.13, 0.1, 0.04") +
                   "&free key = 'body.inertia.1' /\n&measurement file = 'sat.aem', columns = 'q0', 'q1', 'q2', 'q3', sigma = 1e-6 /\n")
        found = self.succeed("fit", "fit.nml", "--output", "found.nml").stdout
        self.assertRegex(found, r"body.inertia.1 +0\.1(2|19999)")

    def test_runs_back_in_time_go_forward(self):
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "integrator.end_time=-1")
        lines = records(self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--aem", "-").stdout)
        self.assertEqual((lines[0][0], lines[-1][0]), ("2029-04-13T21:46:11.750000", "2029-04-13T21:46:12.750000"))

    def test_ecliptic_axes_are_turned(self):
        text = self.succeed("export", "tumbler.csv", "--scene", "tumbler.nml", "--set", "scene.space_frame=ECLIPJ2000", "--aem", "-").stdout
        self.assertEqual(keywords(text)["REF_FRAME_A"], "EME2000")
        half = math.radians(84381.448 / 3600) / 2
        q0, q1, q2, q3 = self.rows[0][1:5]
        c, s = math.cos(half), math.sin(half)
        expected = [c * q1 + s * q0, c * q2 - s * q3, c * q3 + s * q2, c * q0 - s * q1]
        for value, wanted in zip(records(text)[0][1], expected):
            self.assertAlmostEqual(value, wanted, delta=1e-15)


def seconds(date):
    """Of the tests' minute."""
    return int(date[14:16]) * 60 + float(date[17:]) - 46 * 60 - 12.75


class Refusals(CommandLineTest):
    def test_of_the_command_line(self):
        self.succeed("run", "box.nml", "--quiet")
        for arguments, says in (((), "there is no history"), (("box.csv",), "no file to write (expected --aem FILE or --gltf FILE)"),
                                (("box.csv", "--aem"), "--aem needs a value"), (("box.csv", "--aem", ""), "--aem needs the name of a file"),
                                (("box.csv", "--aems", "x"), "unknown option '--aems' (nearest: --aem)"),
                                (("box.csv", "--aem", "a", "--quiet"), "nutate export has no option --quiet"),
                                (("box.csv", "--aem", "a", "--aem-version", "3.0"), "--aem-version '3.0' is not available (expected 2.0, 1.0)"),
                                (("box.csv", "--aem", "a", "--error", "0"), "--error '0' is out of its range (expected 1e-12 to 1 rad)"),
                                (("box.csv", "--aem", "a", "--error", "much"), "--error 'much' is out of its range"),
                                (("box.csv", "--gltf", "a", "--speed", "-1"), "--speed '-1' is out of its range"),
                                (("box.csv", "--aem", "a", "--set", "gravity.acceleration=1,0,0"), "--set: unknown group 'gravity' (expected scene, body)"),
                                (("box.csv", "--aem", "a", "--set", "scene.epok=1"), "--set: unknown key 'epok' in &scene"),
                                (("box.csv", "--aem", "a", "--set", "scene.epoch=soon", "--set", "scene.time_system=TDB"), "--set: 'soon' is not a date"),
                                (("box.csv", "--aem", "a", "--set", "scene.time_system=GMT"), "--set: 'GMT' is not available for time_system"),
                                (("box.csv", "--aem", "a", "--scene", "none.nml"), "none.nml: cannot be read"),
                                (("box.csv", "--aem", "x.aem", "--gltf", "x.aem"), "x.aem is where the attitudes go as AEM"),
                                (("box.csv", "--aem", "box.csv"), "box.csv is the history itself"),
                                (("box.csv", "--aem", "box.nml", "--scene", "box.nml"), "box.nml is the scene itself"),
                                (("none.csv", "--aem", "a"), "none.csv: cannot be read"), (("box", "--aem", "a"), "did you mean box.csv?")):
            with self.subTest(arguments):
                self.fail_with(2, "export", *arguments, says=(says,))
        self.fail_with(4, "export", "box.csv", *LABELS, "--aem", "no/a.aem", says=("cannot write no/a.aem",))
        self.assertEqual(self.names(), ["box.csv", "box.nml", "top.nml"])

    def test_files_of_another_kind_stay(self):
        self.succeed("run", "box.nml", "--quiet")
        self.write("notes.txt", "mine")
        self.fail_with(2, "export", "box.csv", *LABELS, "--aem", "notes.txt", says=("notes.txt exists and is not an AEM",))
        arguments = ("export", "box.csv", "--scene", "box.nml", *LABELS, "--aem", "a.aem", "--gltf", "a.gltf")
        self.succeed(*arguments)
        self.succeed(*arguments)
        self.fail_with(2, "export", "box.csv", *LABELS, "--aem", "a.gltf", says=("a.gltf is a glTF file, not an AEM",))
        self.fail_with(2, "export", "box.csv", "--scene", "box.nml", "--gltf", "a.aem", says=("a.aem is an AEM, not a glTF file",))
        self.fail_with(2, "run", "box.nml", "--output", "a.aem", says=("a.aem is an AEM, not a history",))
        self.assertEqual(self.read("notes.txt"), "mine")

    def test_what_is_no_history_of_attitudes(self):
        for name, (text, says) in {"no.csv": ("a,b\n1,2\n", "no.csv:1: not a history"), "empty.csv": ("", "empty.csv:1: not a history"),
                                   "rates.csv": ("t,omega1\n0,1\n", "rates.csv:1: there is no column q0"),
                                   "word.csv": ("t,q0,q1,q2,q3\n0,1,x,0,0\n", "word.csv:2: 'x' is not a number"),
                                   "short.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n1,1\n", "short.csv:3: 2 fields (expected 5)"),
                                   "norm.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n1,1,1,0,0\n", "norm.csv:3: the quaternion is not of unit norm"),
                                   "order.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n2,1,0,0,0\n1,1,0,0,0\n3,1,0,0,0\n", "order.csv:4: t is out of order"),
                                   "twice.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n0,1,0,0,0\n", "twice.csv:3: t is out of order"),
                                   "huge.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n1e300,1,0,0,0\n", "huge.csv:3: t is too large"),
                                   "far.csv": ("t,q0,q1,q2,q3\n0,1,0,0,0\n1e20,1,0,0,0\n", "far.csv: the rows leave the calendar"),
                                   "rate.csv": ("t,q0,q1,q2,q3,omega1,omega2,omega3\n0,1,0,0,0,Infinity,0,0\n", "rate.csv:2: an angular velocity is too large"),
                                   "none.csv": ("t,q0,q1,q2,q3\n", "none.csv: there are no rows")}.items():
            self.write(name, text)
            self.fail_with(2, "export", name, *LABELS, "--aem", "x.aem", says=(says,))
        self.assertNotIn("x.aem", self.names())

    def test_help(self):
        text = self.succeed("help", "export").stdout
        for words in ("nutate export HISTORY.csv [options]", "--aem FILE", "--gltf FILE", "--error RAD", "--scene SCENE", "(q1, q2, q3, q0)"):
            self.assertIn(words, text)
        self.assertTrue(all(len(line) <= 110 for line in text.splitlines()))
        self.assertIn("nutate export HISTORY.csv", self.succeed("--help").stdout)


class Fuzz(CommandLineTest):
    """Malformed histories and extreme groups: one line and status 2, or files."""

    CASES = share_of(300)

    def test_any_history_is_exported_or_refused_in_one_line(self):
        self.succeed("run", "box.nml", "--quiet", "--set", "output.interval=0.25")
        whole = self.read("box.csv").encode()
        statuses = [0, 0]
        for number in range(self.CASES):
            dice = random.Random(f"export {number}")
            data = whole
            for _ in range(dice.choice((0, 1, 1, 2, 5))):
                data = mutated(dice, data)
            with open(self.path("h.csv"), "wb") as file:
                file.write(data)
            overrides = list(LABELS)
            if dice.random() < 0.3:
                word = dice.choice(("", "'", "2029-02-30", "2016-12-31T23:59:60", "9999-12-31T23:59:59", "\u00e9", "a b", "1583-01-01", "x" * 200))
                overrides[1] = dice.choice(("scene.epoch=", "scene.object=", "scene.time_system=", "body.inertia=")) + word
            arguments = ["export", "h.csv", *overrides, "--set", "body.inertia=1,2,2.5", "--aem", "h.aem", "--gltf", "h.gltf"]
            if dice.random() < 0.5:
                arguments += ["--error", repr(10.0 ** dice.uniform(-12, 0))]
            done = subprocess.run([self.program, *arguments], cwd=self.folder, capture_output=True, timeout=PATIENCE, check=False)
            with self.subTest(number=number):
                self.assertIn(done.returncode, (0, 2), done.stderr)
                statuses[done.returncode // 2] += 1
                if done.returncode == 0:
                    self.assertEqual(done.stderr, b"")
                    self.assertNotRegex(self.read("h.aem").lower(), r"\bnan\b|infinity|[*]{2}")
                    json.loads(self.read("h.gltf"))
                else:
                    self.assertRegex(done.stderr, rb"\A[^\n]{10,}\n\Z")
                    self.assertNotRegex(done.stderr.lower(), rb"runtime error|backtrace")
        for count in statuses:
            self.assertGreater(count, self.CASES // 20, statuses)


def mutated(dice, data):
    """A history with a fault, mostly."""
    place = dice.randrange(len(data) + 1)
    way = dice.randrange(6)
    if way == 0:
        return data[:place]
    if way == 1:
        return data[:place] + bytes([dice.randrange(256)]) + data[place + 1:]
    if way == 2:
        return data[:place] + dice.choice((b",", b"\n", b'"', b"-", b"NaN", b"1e400", b"\r\n", b"\0", b"e9")) + data[place:]
    lines = data.split(b"\n")
    line = dice.randrange(len(lines))
    if way == 3:
        return b"\n".join(lines[:line] + lines[line:line + 1] + lines[line:])
    if way == 4:
        return b"\n".join(lines[:line] + lines[line + 1:])
    words = lines[line].split(b",")
    words[dice.randrange(len(words))] = dice.choice((b"0", b"1", b"-1", b"1e-300", b"1e99", b"", b"q0", b"0.5", b"t"))
    return b"\n".join([*lines[:line], b",".join(words), *lines[line + 1:]])


class Dates(CommandLineTest):
    def test_check_and_run_name_dates(self):
        self.write("tumbler.nml", TUMBLER)
        text = self.succeed("check", "tumbler.nml").stdout
        for pattern in (r"epoch +t = 0 at 2029-04-13T21:46:12.75 TDB, end at 2029-04-13T21:46:22.65\n", r"object +APOPHIS, 2004-MN4\n",
                        r"space axes +inertial, ICRF\n"):
            self.assertRegex(text, pattern)
        said = self.succeed("run", "tumbler.nml").stderr
        self.assertRegex(said, r"calendar time +2029-04-13T21:46:12.75 to 2029-04-13T21:46:22.65 TDB\n")
        self.assertNotIn("leap second", said)
        self.assertRegex(self.succeed("check", "tumbler.nml", "--set", "scene.time_system=UTC").stdout, "no leap second")
        self.assertNotIn("epoch", self.succeed("check", "box.nml").stdout)

    def test_rows_and_events_have_dates_on_request(self):
        self.write("tumbler.nml", TUMBLER + "&event name = 'a, b', when = 'omega1', crosses = 0 /\n")
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.calendar=.true.", "--set", "output.precision=6")
        lines = self.read("tumbler.csv").splitlines()
        self.assertTrue(lines[0].startswith("t,date,q0,"))
        self.assertTrue(lines[1].startswith("0,2029-04-13T21:46:12.75,0.6,"))
        self.assertTrue(lines[3].startswith("0.2,2029-04-13T21:46:12.95,"))
        events = self.read("tumbler.events.csv").splitlines()
        self.assertTrue(events[0].startswith("t,event,number,date,q0,"))
        self.assertRegex(events[1], r'^[0-9.]+,"a, b",1,2029-04-13T21:46:1[0-9.]+,')
        self.assertIn("t,date,q0", self.succeed("check", "tumbler.nml", "--set", "output.calendar=.true.").stdout)
        # A history with dates can be continued and drawn like others.
        self.fail_with(3, "run", "tumbler.nml", "--quiet", "--set", "output.calendar=.true.", "--max-steps", "20", "--checkpoint", "c",
                       "--every-seconds", "0", says=("tumbler.csv.partial",))
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.calendar=.true.", "--resume", "c")
        resumed = self.read("tumbler.csv")
        self.succeed("run", "tumbler.nml", "--quiet", "--set", "output.calendar=.true.")
        self.assertEqual(resumed, self.read("tumbler.csv"))

    def test_members_have_dates(self):
        self.write("tumbler.nml", TUMBLER.replace("interval = 0.1", "interval = 0.1, calendar = .true.")
                   + "&ensemble members = 2 /\n&vary key = 'initial.angular_velocity.1', distribution = 'uniform', low = 1, high = 2 /\n")
        self.succeed("sweep", "tumbler.nml", "--member", "2", "--quiet", "--output", "r.csv")
        self.assertTrue(self.read("r.csv").startswith("t,date,q0"))

    def test_what_is_wrong_is_named_with_its_line(self):
        for old, new, says in (("2029-04-13T21:46:12.75", "2029-02-29", "bad.nml:1: '2029-02-29' is no date of the Gregorian calendar"),
                               ("2029-04-13T21:46:12.75", "13.4.2029", "bad.nml:1: '13.4.2029' is not a date (expected one such as"),
                               ("2029-04-13T21:46:12.75", "2029-04-13T21:46", "bad.nml:1: '2029-04-13T21:46' has no time of day"),
                               ("2029-04-13T21:46:12.75", "2029-04-13T25:00:00", "impossible time of day"),
                               ("2029-04-13T21:46:12.75", "2029-04-13T21:46:12Z", "'2029-04-13T21:46:12Z' ends in Z, which stands for UTC"),
                               ("2029-04-13T21:46:12.75', time_system = 'TDB", "2015-12-31T23:59:60', time_system = 'UTC", "is no leap second"),
                               ("2029-04-13T21:46:12.75', time_system = 'TDB", "1960-01-01', time_system = 'UTC", "before 1972"),
                               (", time_system = 'TDB'", "", "bad.nml:1: an epoch needs its time system"),
                               ("'TDB'", "'TBD'", "bad.nml:1: 'TBD' is not available for time_system (expected 'TDB', 'TT', 'TAI', 'UTC'"),
                               ("'2004-MN4'", "' '", "bad.nml:2: object_id is blank"), ("'ICRF'", "'\u00e9'", "is not ASCII (expected a name of ASCII letters)"),
                               ("end_time = 9.9", "end_time = 1e15", "bad.nml:1: end_time leaves the calendar")):
            self.write("bad.nml", TUMBLER.replace(old, new))
            with self.subTest(new):
                self.fail_with(2, "check", "bad.nml", says=(says,))
        self.fail_with(2, "run", "box.nml", "--set", "output.calendar=.true.", says=("--set: calendar needs the date of t = 0",))


if __name__ == "__main__":
    unittest.main()
