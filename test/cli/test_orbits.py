"""Orbits: their columns in both units, their events, what check and summary say, members, and runs that go on."""
import math
import re
import sys
import unittest

from support import ORBIT_COLUMNS, TUMBLING_COLUMNS, CommandLineTest

BODY = "&body inertia = 90.0, 100.0, 40.0 /\n"
SCENE = BODY + """&orbit altitude = 500e3, inclination = 97.4, raan = 40, mean_anomaly = 10, degrees = .true. /
&gravity_gradient /
&initial roll_pitch_yaw = 0, 30, 0, degrees = .true., attitude_from = 'lvlh', angular_velocity = 0, 0, 0, rate_from = 'lvlh' /
&integrator order = 6, time_step = 20.0, end_time = 6500.0 /
&output columns = 'quaternion', 'lvlh_attitude', 'orbit', 'energy', 'jacobi' /
&event when = 'pitch', crosses = 0.0 /
&event name = 'periapsis', when = 'true_anomaly', crosses = 0.0 /
"""
MOVING = BODY + """&orbit semi_major_axis = 1e7, eccentricity = 0.3, inclination = 60, raan = 30, argument_of_periapsis = 45,
   degrees = .true. /
&gravity_gradient /
&damping coefficient = 1e-5, 2e-5, 1e-5 /
&initial axis = 1, 1, 1, angle = 0.7, angular_velocity = 1e-3, -5e-4, 8e-4 /
&integrator time_step = 40.0, end_time = 20000.0 /
&output columns = 'quaternion', 'energy', 'lvlh_attitude', 'time_dependent_work', every = 5 /
"""
# A body passes the Earth, and the Sun attracts it too.
FLYBY = BODY.replace("90.0, 100.0, 40.0", "0.64, 0.97, 1.0") + """&orbit name = 'earth', periapsis_distance = 38e6, periapsis_time = 20000,
   eccentricity = 4.25, inclination = 160, raan = 150, argument_of_periapsis = 30, degrees = .true. /
&orbit name = 'sun', mu = 1.32712440018e20, semi_major_axis = 1.496e11, frame = 'inertial' /
&gravity_gradient /
&initial angular_velocity = 1.3e-5, 0.0, 5.6e-5 /
&integrator time_step = 200.0, end_time = 40000.0 /
&output columns = 'quaternion', 'orbit', 'energy', 'lvlh_attitude', 'energies', 'time_dependent_work', every = 5 /
&event name = 'nearest', when = 'orbit_radius', extremum = 'minimum' /
"""
# The pitch of a pendulum let go at 30 degrees passes 0 at (2j+1) K/w: 20 digits of elliptic integrals.
ZEROS = [1243.612203959228267295, 3730.836611877684801886, 6218.061019796141336476]
PERIOD = 5676.9780285258586712


class Orbits(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("orbit.nml", SCENE)

    def test_columns_have_their_names(self):
        self.succeed("run", "orbit.nml", "--quiet")
        header, rows = self.history("orbit.csv")
        self.assertEqual(header[11:], ORBIT_COLUMNS["lvlh_attitude"] + ORBIT_COLUMNS["orbit"])
        for row in rows:
            t, pitch, place = row[0], row[12], row[18:21]
            # Roll and yaw stay where they are.
            self.assertLess(abs(row[11]) + abs(row[13]), 1e-14)
            self.assertAlmostEqual(pitch, 2 * math.atan2(row[16], row[14]), delta=1e-14)
            self.assertAlmostEqual(math.dist(place, (0, 0, 0)), row[21], delta=1e-7)
            self.assertEqual(row[21], 6878137.0)
            self.assertAlmostEqual(row[22], math.radians(10) + 2 * math.pi * t / PERIOD, delta=1e-13)
            self.assertLess(abs(row[9]), 4e-15 * row[7])
        # A tenth of a revolution after the node it has gone north by sin(i).
        self.assertAlmostEqual(rows[0][20], 6878137.0 * math.sin(math.radians(10)) * math.sin(math.radians(97.4)), delta=1e-6)

    def test_degrees_are_those_of_angles(self):
        self.succeed("run", "orbit.nml", "--quiet")
        self.succeed("run", "orbit.nml", "--quiet", "--set", "output.degrees=.true.", "--output", "degrees.csv")
        names, degrees = self.history("degrees.csv")
        self.assertEqual(names[11:14], ["roll_deg", "pitch_deg", "yaw_deg"])
        self.assertEqual(names[14:], ORBIT_COLUMNS["lvlh_attitude"][3:] + ORBIT_COLUMNS["orbit"][:4] + ["true_anomaly_deg"])
        radians = self.history("orbit.csv")[1]
        self.assertAlmostEqual(degrees[5][12], math.degrees(radians[5][12]), delta=1e-13)
        self.assertAlmostEqual(degrees[5][22], math.degrees(radians[5][22]), delta=1e-12)
        self.assertEqual(degrees[5][14:22], radians[5][14:22])

    def test_events_find_pitch_and_periapsis(self):
        self.succeed("run", "orbit.nml", "--quiet", "--set", "integrator.order=8")
        with open(self.path("orbit.events.csv"), encoding="utf-8") as file:
            events = [line.split(",") for line in file.read().splitlines()[1:]]
        found = [float(event[0]) for event in events if event[1] == "pitch"]
        self.assertEqual(len(found), len(ZEROS))
        for time, expected in zip(found, ZEROS):
            self.assertAlmostEqual(time, expected, delta=1e-8)
        periapses = [float(event[0]) for event in events if event[1] == "periapsis"]
        self.assertEqual(len(periapses), 1)
        self.assertAlmostEqual(periapses[0], PERIOD * 350 / 360, delta=1e-9)

    def test_check_says_where_it_comes_from(self):
        text = self.succeed("check", "orbit.nml").stdout
        self.assertIn("direction = that of &orbit (default)", text)
        self.assertIn("mu = 3.986004418e14 (default)", text)
        self.assertIn("energy              changes by the work of time-dependent potentials alone", text)
        self.assertIn("axes of steps       LVLH frame, where all effects are constant", text)
        text = self.succeed("check", "orbit.nml", "--set", "orbit.frame=lvlh").stdout
        self.assertIn("T + V - omega.l     conserved", text)
        self.assertNotIn("axes of steps", text)
        self.assertNotIn("would turn once", text)
        self.assertIn("is more than a turn", self.succeed("check", "orbit.nml", "--set", "initial.degrees=.false.").stdout)

    def test_inertial_axes_show_the_same_attitude(self):
        free = SCENE.replace("&gravity_gradient /\n", "").replace("angular_velocity = 0, 0, 0", "angular_velocity = 1, 2, -3")
        self.write("free.nml", free)
        for frame in ("lvlh", "inertial"):
            self.succeed("run", "free.nml", "--quiet", "--output", frame + ".csv", "--set", f"orbit.frame={frame}", "--set",
                         "integrator.order=8", "--set", "integrator.time_step=0.25", "--set", "integrator.end_time=50")
        ours, theirs = self.history("lvlh.csv")[1], self.history("inertial.csv")[1]
        for a, b in zip(ours[::20], theirs[::20]):
            for x, y in zip(a[11:23], b[11:23]):
                self.assertAlmostEqual(x, y, delta=1e-9 * max(1, abs(x)))

    def test_an_eccentric_orbit_is_shown(self):
        self.write("ellipse.nml", BODY + "&orbit semi_major_axis = 1e7, eccentricity = 0.3 /\n&initial angular_velocity = 0, 0, 0, "
                   "attitude_from = 'lvlh', rate_from = 'lvlh' /\n&integrator time_step = 10, end_time = 10000 /\n"
                   "&output columns = 'angular_velocity', 'orbit' /\n&event when = 'orbit_radius', extremum = 'maximum' /\n")
        self.succeed("run", "ellipse.nml", "--quiet")
        rows = self.history("ellipse.csv")[1]
        # At the periapsis: r = a (1 - e), v / r of the rate.
        self.assertAlmostEqual(rows[0][7], 7e6, delta=1e-8)
        self.assertAlmostEqual(rows[0][2], -math.sqrt(3.986004418e14 * 1e7 * 0.91) / 49e12, delta=1e-17)
        with open(self.path("ellipse.events.csv"), encoding="utf-8") as file:
            apogee = float(file.read().splitlines()[1].split(",")[0])
        self.assertAlmostEqual(apogee, math.pi * math.sqrt(1e21 / 3.986004418e14), delta=1e-5)

    def test_a_gradient_that_moves_has_its_account(self):
        self.write("moving.nml", MOVING)
        for settings in (["integrator.order=2"], ["integrator.order=8", "integrator.formulation=reduced"],
                         ["integrator.method=taylor"], ["integrator.method=dop853", "integrator.conserve=.true."]):
            done = self.succeed("run", "moving.nml", *(word for setting in settings for word in ("--set", setting)))
            self.assertIn("work of time-dependent potentials", done.stderr)
            header, rows = self.history("moving.csv")
            self.assertEqual(header[-1], "time_dependent_work")
            total, work, residual, moving = (header.index(name) for name in ("total", "work", "energy_residual", "time_dependent_work"))
            for row in rows:
                self.assertAlmostEqual(row[total] - rows[0][total] - row[work] - row[moving], row[residual], delta=1e-18)
                self.assertLess(abs(row[residual]), 1e-16)
            # Damping dissipates; the time-dependent potential adds and removes energy.
            self.assertLess(rows[-1][work], 0.0)
            self.assertGreater(max(abs(row[moving]) for row in rows), 1e-5)
        text = self.succeed("check", "moving.nml").stdout
        self.assertIn("changes by the work of torques and time-dependent potentials alone", text)
        self.fail_with(2, "run", "moving.nml", "--set", "integrator.method=exact", says=("free bodies only",))

    def test_runs_with_a_gradient_that_moves_go_on(self):
        self.write("moving.nml", MOVING)
        for name, method in (("step", "nielsen_krenk"), ("series", "taylor"), ("steps", "dop853")):
            arguments = ["moving.nml", "--quiet", "--set", f"integrator.method={method}"]
            self.succeed("run", *arguments, "--output", name + ".whole.csv")
            self.fail_with(3, "run", *arguments, "--output", name + ".csv", "--checkpoint", "p.ck", "--max-steps", "100")
            self.succeed("run", *arguments, "--output", name + ".csv", "--resume", "p.ck")
            self.assertEqual(self.read(name + ".whole.csv"), self.read(name + ".csv"))

    def test_a_flyby_is_shown(self):
        self.write("flyby.nml", FLYBY)
        for method in ("nielsen_krenk", "taylor", "dop853"):
            self.succeed("run", "flyby.nml", "--quiet", "--set", f"integrator.method={method}")
            header, rows = self.history("flyby.csv")
            at = header.index
            self.assertEqual(header[-3:], ["time_dependent_work", "energy_gravity_gradient1", "energy_gravity_gradient2"])
            # Kinetic energy and potential grow by ten times at the passage: what is rounded there stays.
            largest = max(row[at("kinetic")] + abs(row[at("potential")]) for row in rows)
            for row in rows:
                self.assertLess(abs(row[at("energy_residual")]), 4e-15 * largest)
                self.assertAlmostEqual(row[at("energy_gravity_gradient1")] + row[at("energy_gravity_gradient2")], row[at("potential")],
                                       delta=1e-24)
            self.assertAlmostEqual(rows[20][at("orbit_radius")], 38e6, delta=1e-7)
            self.assertAlmostEqual(rows[20][at("true_anomaly")], 0.0, delta=1e-15)
            self.assertAlmostEqual(rows[0][at("true_anomaly")], -rows[40][at("true_anomaly")], delta=1e-14)
            with open(self.path("flyby.events.csv"), encoding="utf-8") as file:
                events = file.read().splitlines()[1:]
            self.assertEqual(len(events), 1)
            self.assertAlmostEqual(float(events[0].split(",")[0]), 20000.0, delta=1e-4)

    def test_check_shows_the_default_of_the_passage_where_it_counts(self):
        self.write("flyby.nml", FLYBY.replace("periapsis_time = 20000,", ""))
        self.assertEqual(self.succeed("check", "flyby.nml").stdout.count("periapsis_time = 0 (default)"), 1)
        self.assertNotIn("periapsis_time", self.succeed("check", "orbit.nml").stdout)

    def test_flybys_go_on(self):
        self.write("flyby.nml", FLYBY)
        for name, method in (("step", "nielsen_krenk"), ("series", "taylor")):
            arguments = ["flyby.nml", "--quiet", "--set", f"integrator.method={method}"]
            self.succeed("run", *arguments, "--output", name + ".whole.csv")
            self.fail_with(3, "run", *arguments, "--output", name + ".csv", "--checkpoint", "p.ck", "--max-steps", "90")
            self.succeed("run", *arguments, "--output", name + ".csv", "--resume", "p.ck")
            self.assertEqual(self.read(name + ".whole.csv"), self.read(name + ".csv"))

    def track(self, name, lines=41, velocities=True):
        """The path of FLYBY by the Earth as a table, from the columns of a run; its velocities are none."""
        self.write("track.nml", FLYBY.replace("every = 5", "every = 1").replace("&gravity_gradient /", "").replace("'energies', ", ""))
        self.succeed("run", "track.nml", "--quiet", "--set", f"integrator.time_step={40000 / (lines - 1)}")
        header, rows = self.history("track.csv")
        at = header.index("orbit_x")
        text = "t (s),x (m),y (m),z (m)" + (",vx (m/s),vy (m/s),vz (m/s)" if velocities else "") + "\n"
        for row in rows:
            text += ",".join(repr(x) for x in [row[0], *row[at:at + 3]])
            if velocities:
                text += ",1,2,3"
            text += "\n"
        self.write(name, text)
        return text

    def test_a_table_takes_the_place_of_elements(self):
        self.track("positions.csv", 401, False)
        self.write("flyby.nml", FLYBY)
        self.succeed("run", "flyby.nml", "--quiet")
        header, expected = self.history("flyby.csv")
        start = FLYBY.index("&orbit name = 'earth'")
        table = FLYBY[:start] + "&orbit name = 'earth', table = 'positions.csv' /\n" + FLYBY[FLYBY.index("&orbit name = 'sun'"):]
        self.write("table.nml", table)
        for method in ("nielsen_krenk", "taylor", "dop853"):
            self.succeed("run", "table.nml", "--quiet", "--set", f"integrator.method={method}")
            names, rows = self.history("table.csv")
            self.assertEqual(names, header)
            for row, other in zip(rows, expected):
                # At most a rounding in each of the 200 steps of a method that does not conserve.
                roundings = 200 if method == "dop853" else 20
                self.assertLess(abs(row[header.index("energy_residual")]), roundings * sys.float_info.epsilon * row[header.index("kinetic")])
                # Natural splines through lines every 100 s are worst at the ends.
                if method == "nielsen_krenk":
                    self.assertAlmostEqual(row[header.index("q1")], other[header.index("q1")], delta=1e-6)
                    self.assertAlmostEqual(row[header.index("roll")], other[header.index("roll")], delta=1e-4)
                self.assertAlmostEqual(row[header.index("true_anomaly")], other[header.index("true_anomaly")], delta=1e-4)

    def test_runs_on_a_table_go_on(self):
        self.track("positions.csv", 41, False)
        self.write("table.nml", BODY + "&orbit table = 'positions.csv' /\n&gravity_gradient /\n&initial angular_velocity = 1e-5, 0, 6e-5 /\n"
                   "&integrator time_step = 300, end_time = 40000 /\n")
        for method in ("nielsen_krenk", "taylor", "dop853"):
            arguments = ["table.nml", "--quiet", "--set", f"integrator.method={method}"]
            self.succeed("run", *arguments, "--output", "whole.csv")
            self.fail_with(3, "run", *arguments, "--output", "part.csv", "--checkpoint", "p.ck", "--max-steps", "60")
            self.succeed("run", *arguments, "--output", "part.csv", "--resume", "p.ck")
            self.assertEqual(self.read("whole.csv"), self.read("part.csv"))
        self.write("positions.csv", self.read("positions.csv").replace("\n20000.0,", "\n20000.5,"))
        self.fail_with(2, "run", *arguments, "--output", "part.csv", "--resume", "p.ck")

    def test_what_is_wrong_with_a_table_has_its_line(self):
        positions = self.track("positions.csv", velocities=False)
        text = self.track("good.csv")
        scene = BODY + "&orbit table = 'track.csv' /\n&gravity_gradient /\n&initial angular_velocity = 1e-5, 0, 6e-5 /\n" \
            "&integrator time_step = 300, end_time = 40000 /\n"
        self.write("table.nml", scene)
        lines = text.splitlines()
        for number, line, says in ((1, "t (s),x (m),y (m)", "wrong number of columns"), (1, lines[0].replace("(m)", "(km)"), "lacks the unit (m)"),
                                   (4, lines[2], "the time does not increase"), (5, lines[4].replace(",1,2,3", ",1,2"), "wrong number of values"),
                                   (6, lines[5].split(",")[0] + ",0,0,0,1,2,3", "a position is out of range"),
                                   (7, lines[6].replace(",1,2,3", ",1e30,0,0"), "a velocity is out of range"),
                                   (8, ",".join([lines[7].split(",")[0], *(str(-float(x)) for x in lines[6].split(",")[1:4]), "1,2,3"]), "too close to the centre")):
            self.write("track.csv", "\n".join(lines[:number - 1] + [line] + lines[number:]) + "\n")
            self.fail_with(2, "run", "table.nml", says=(f"track.csv:{number}: ", says))
        text = positions
        self.write("track.csv", text)
        self.fail_with(2, "run", "table.nml", "--set", "integrator.end_time=50000", says=("end_time is outside of the table of &orbit",))
        self.write("track.csv", text.replace("\n0.0,", "\n-1.0,").replace("\n0,", "\n-1,"))
        for old, new, says in (("track.csv' ", "track.csv', raan = 1 ", "table and raan exclude each other"),
                               ("track.csv' ", "absent.csv' ", "cannot be read"),
                               ("track.csv' ", "track.csv', frame = 'lvlh' ", "the LVLH frame of a table")):
            self.write("other.nml", scene.replace(old, new))
            self.fail_with(2, "run", "other.nml", says=("other.nml:2: ", says))
        self.write("force.nml", scene + "&force body_point = 1, 0, 0, force = 0, 1, 0, axes = 'lvlh' /\n")
        self.fail_with(2, "run", "force.nml", says=("axes = 'lvlh' with a table",))
        self.write("event.nml", scene + "&event when = 'true_anomaly', crosses = 0 /\n")
        self.fail_with(2, "run", "event.nml", says=("an event of 'true_anomaly' with a table",))

    def test_members_have_orbits_of_their_own(self):
        self.write("many.nml", FLYBY + "&ensemble members = 3, file = 'many.npy' /\n&vary key = 'orbit.1.periapsis_distance', "
                   "distribution = 'grid', low = 30e6, high = 50e6, points = 3 /\n")
        self.succeed("sweep", "many.nml", "--quiet", "--csv", "many.csv")
        self.write("flyby.nml", FLYBY)
        self.succeed("run", "flyby.nml", "--quiet", "--set", "orbit.1.periapsis_distance=50e6")
        header, rows = self.history("many.csv")
        names, last = self.history("flyby.csv")
        for name in ("q0", "q1", "orbit_radius"):
            self.assertEqual(rows[2][header.index(name)], last[-1][names.index(name)])
        self.assertNotEqual(rows[0][header.index("q1")], rows[2][header.index("q1")])

    def test_the_estimated_error_contains_that_of_the_table(self):
        scene = BODY.replace("90.0, 100.0, 40.0", "0.64, 0.97, 1.0") + """&orbit %s /
&gravity_gradient /
&initial angular_velocity = 1.3e-5, 0.0, 5.6e-5 /
&integrator accuracy = 1e-6, end_time = 172800 /
&output columns = 'quaternion', %s /
"""
        elements = "periapsis_distance = 3.8e7, eccentricity = 4.2, periapsis_time = 86400"
        self.write("path.nml", scene % (elements, "'orbit', interval = 400"))
        self.succeed("run", "path.nml", "--quiet", "--set", "integrator.accuracy=1e-12")
        rows = self.history("path.csv")[1]
        for interval, keys, most in ((400, "", 1.1), (1200, "", 2), (3600, "", 20), (7200, "", 20), (1200, ", interpolation = 'quintic'", 100),
                                     (7200, ", interpolation = 'quintic'", 100)):
            # The bound is 2^p - 1 times the error if the lines are too far apart for the order p of the interpolation to show.
            heads = ["t (s)", "x (m)", "y (m)", "z (m)"] + ["vx (m/s)", "vy (m/s)", "vz (m/s)"] * bool(keys)
            lines = [",".join(heads)]
            for row in rows:
                if row[0] % interval > 1e-6:
                    continue
                numbers = [row[0], *row[5:8]]
                if keys:
                    speed = math.sqrt(3.986004418e14 / (3.8e7 * 5.2))
                    numbers += [-speed * math.sin(row[9]), speed * (4.2 + math.cos(row[9])), 0.0]
                lines.append(",".join(map(repr, numbers)))
            self.write("path.csv", "\n".join(lines) + "\n")
            self.write("table.nml", scene % (f"table = 'path.csv'{keys}", "times = 172800"))
            said = self.succeed("run", "table.nml", "--set", "integrator.accuracy=1e-9").stderr
            estimate = float(re.search("estimated error +([0-9.E-]+) rad", said)[1])
            last = self.history("table.csv")[1][-1][1:5]
            error = 2 * min(math.dist(last, rows[-1][1:5]), math.dist([-x for x in last], rows[-1][1:5]))
            self.assertGreater(estimate, 0.9 * error, (interval, keys))
            self.assertLess(estimate, most * error + 2e-9, (interval, keys))
            note = "is not attainable: the distance of the lines in the table of the orbit contributes"
            self.assertEqual(note in said, estimate > 1e-9, said)
            if interval == 400:
                self.assertNotIn("not attainable", self.succeed("run", "table.nml").stderr)

    def test_a_start_is_put_back_from_the_elements_that_check_prints(self):
        scene = "&body inertia = 3.0836, 3.235, 1.0 /\n&initial euler = 145.498, 65.865, 241.524, angular_velocity = %s, " \
            "degrees = .true. /\n&integrator time_step = 1.0, end_time = 1.0 /\n&output columns = 'quaternion', " \
            "'angular_velocity', 'tumbling' /\n"
        number = r"(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)"
        for rates, mode, axis, sense in (("14.51, 33.529, -98.709", "lam", "long", "negative"),
                                         ("14.51, 33.529, 98.709", "lam", "long", "positive"),
                                         ("14.51, -93.529, 8.709", "sam", "short", "negative"),
                                         ("14.51, 93.529, -8.709", "sam", "short", "positive")):
            self.write("given.nml", scene % rates)
            text = self.succeed("check", "given.nml").stdout
            period, phase = re.search(f"rotation +period {number} s, phase {number}\n", text).groups()
            precession = re.search(f"{number} s of the {axis} axis", text)[1]
            pole = re.search(f"longitude {number} rad, latitude {number} rad", text).groups()
            angle = re.search(f"angle +{number} rad of the {axis} axis", text)[1]
            self.assertRegex(text, f"sense +{sense} about the {axis} axis")
            self.write("back.nml", scene.replace("euler = 145.498, 65.865, 241.524, angular_velocity = %s, degrees = .true.",
                                                 f"tumbling = '{mode}', sense = '{sense}', period_axis = '{axis}', "
                                                 f"precession_period = {precession}, rotation_period = {period}, "
                                                 f"rotation_phase = {phase}, precession_angle = {angle}, "
                                                 f"pole = {pole[0]}, {pole[1]}"))
            rows = []
            for name in ("given", "back"):
                self.succeed("run", name + ".nml", "--quiet")
                rows.append(self.history(name + ".csv")[1][0])
            sign = math.copysign(1.0, sum(a * b for a, b in zip(rows[0][1:5], rows[1][1:5])))
            for k, (given, back) in enumerate(zip(*rows)):
                self.assertAlmostEqual(back * (sign if 1 <= k <= 4 else 1.0) / given if given else 1.0, 1.0, delta=1e-7)
            self.assertEqual(rows[1][-1], 1.0 if sense == "positive" else -1.0)
            self.fail_with(2, "check", "back.nml", "--set", "initial.sense=right", says=("--set: 'right' is not available for sense "
                                                                                           "(expected 'positive', 'negative')",))

    def test_tumbling_elements_are_shown(self):
        self.write("tumbling.nml", "&body inertia = 0.64, 0.97, 1.0 /\n&initial tumbling = 'sam', precession_period = 98587.692, "
                   "period_axis = 'short', rotation_period = 951040.8, pole = 275, -85, degrees = .true. /\n"
                   "&integrator accuracy = 1e-10, end_time = 172800 /\n&output columns = 'tumbling', times = 0, 86400, 172800 /\n")
        text = self.succeed("check", "tumbling.nml").stdout
        self.assertIn("short-axis mode, E/E0 = 1.012027369", text)
        self.assertRegex(text, "sense +positive about the short axis")
        self.assertIn("period 98587.692 s of the short axis, 109989.5309 s of the long axis", text)
        self.succeed("run", "tumbling.nml", "--quiet")
        header, rows = self.history("tumbling.csv")
        self.assertEqual(header[1:], TUMBLING_COLUMNS["tumbling"])
        for row in rows:
            for value, expected in zip(row[1:], (1.0120273690693611, 1.0, 98587.692, 109989.53090782045, 951040.8, math.radians(-85),
                                                 math.radians(-85), 1.0)):
                self.assertAlmostEqual(value / expected, 1.0, delta=1e-12)
        # The Earth changes them; the mode changes where E/E0 is Js/Ji.
        flyby = FLYBY[:FLYBY.index("&initial")] + "&initial tumbling = 'lam', precession_period = 98587.692, period_axis = 'long', " \
            "energy_ratio = 1.045, pole = 275, -85, degrees = .true. /\n&integrator method = 'taylor', local_tolerance = 1e-12, " \
            "end_time = 40000 /\n&output columns = 'tumbling' /\n&event name = 'mode', when = 'energy_ratio', crosses = " \
            "1.0309278350515463 /\n&event name = 'slowest', when = 'precession_period_short', extremum = 'maximum' /\n"
        self.write("flyby.nml", flyby)
        self.succeed("run", "flyby.nml", "--quiet")
        header, rows = self.history("flyby.csv")
        modes = sum(a[2] != b[2] for a, b in zip(rows, rows[1:]))
        events = [line.split(",") for line in self.read("flyby.events.csv").splitlines()[1:]]
        crossings = [event for event in events if event[1] == "mode"]
        self.assertGreater(modes, 0)
        self.assertEqual(len(crossings), modes)
        for event in crossings:
            self.assertAlmostEqual(float(event[3]), 1.0309278350515463, delta=1e-13)
        self.fail_with(2, "run", "flyby.nml", "--set", "rotor.momentum=0,0,1", says=("tumbling elements of a body with a rotor",))

    def test_resonances_start_without_free_librations(self):
        scene = BODY.replace("90.0, 100.0, 40.0", "0.9995, 0.999703, 1.0") + "&orbit mu = 1, semi_major_axis = 1, eccentricity = 0.2056 /\n" \
            "&gravity_gradient /\n&initial resonance = '3:2' /\n&integrator method = 'taylor', local_tolerance = 1e-14, " \
            "end_time = 25.132741228718345 /\n&output columns = 'angular_velocity', times = 0, 6.283185307179586, 25.132741228718345 /\n"
        self.write("mercury.nml", scene)
        self.succeed("run", "mercury.nml", "--quiet")
        for row in self.history("mercury.csv")[1]:
            self.assertAlmostEqual(row[3], 1.500129574985608999697, delta=1e-13)
        text = self.succeed("check", "mercury.nml").stdout
        self.assertRegex(text, r"periodic motion +periodic to \S+ \(rad, and rad/s over n\); found after [3-5] revolutions")
        self.assertRegex(text, r"free librations +frequencies \(k ± f\) n for integer k, f = 0\.4995\d+, 0\.0199652, 0\.00095\d+")
        self.assertRegex(text, r"multipliers +all of modulus 1: stable to first order")
        self.assertRegex(text, r"condition +2500, of M - I")
        self.assertNotIn("family", text)
        self.assertRegex(self.succeed("run", "mercury.nml").stderr, r"condition +2500, of M - I")
        hyperion = ("--set", "body.inertia=0.5,0.764033333333333,1", "--set", "orbit.eccentricity=0.1", "--set", "initial.resonance='1:1'")
        self.assertRegex(self.succeed("check", "mercury.nml", *hyperion).stdout, r"unstable: deviations grow by 1\.88104 in a revolution")
        # A free libration with the mean motion, 3 (J2 - J1)/J3 = 1, on a circular orbit.
        resonant = ("--set", "body.inertia=0.6,0.93333333333333333,1", "--set", "orbit.eccentricity=0", "--set", "orbit.frame='inertial'",
                    "--set", "initial.resonance='1:1'")
        self.assertRegex(self.succeed("check", "mercury.nml", *resonant).stdout, r"family +.*singular in 2 directions")
        self.write("both.nml", scene.replace("'3:2'", "'3:2', angular_velocity = 0, 0, 1"))
        self.fail_with(2, "run", "both.nml", says=("both.nml:", "resonance", "angular_velocity"))
        self.write("open.nml", scene.replace("semi_major_axis = 1, eccentricity = 0.2056", "periapsis_distance = 1, eccentricity = 1.5"))
        self.fail_with(2, "run", "open.nml", says=("open.nml:", "resonance: the orbit is not closed"))
        # Too stiff a spring to follow for a revolution.
        self.write("stiff.nml", scene + "&spring stiffness = 1e30, anchor = 0, 0, 1, body_point = 1, 0, 0 /\n")
        self.fail_with(2, "run", "stiff.nml", says=("stiff.nml:", "resonance"))

    def test_resonances_are_swept_resumed_and_costed(self):
        scene = BODY.replace("90.0, 100.0, 40.0", "0.3615, 0.4265, 0.5024") + "&orbit mu = 1, semi_major_axis = 1, eccentricity = 0.0151 /\n" \
            "&gravity_gradient /\n&initial resonance = '1:1' /\n&integrator order = 4, time_step = 0.1, end_time = 12.5 /\n" \
            "&output columns = 'quaternion', 'angular_velocity' /\n"
        self.write("moons.nml", scene + "&ensemble members = 3, file = 'moons.npy' /\n"
                   "&vary key = 'orbit.eccentricity', distribution = 'grid', low = 0.01, high = 0.05, points = 3 /\n")
        self.succeed("sweep", "moons.nml", "--quiet", "--csv", "moons.csv")
        self.write("moon.nml", scene)
        self.succeed("run", "moon.nml", "--quiet", "--set", "orbit.eccentricity=0.05")
        header, rows = self.history("moons.csv")
        names, last = self.history("moon.csv")
        for name in names[1:]:
            self.assertEqual(rows[2][header.index(name)], last[-1][names.index(name)])
        self.assertNotEqual(rows[0][header.index("omega3")], rows[2][header.index("omega3")])
        self.fail_with(3, "run", "moon.nml", "--quiet", "--output", "part.csv", "--checkpoint", "m.ck", "--max-steps", "60",
                       "--set", "orbit.eccentricity=0.05")
        self.succeed("run", "moon.nml", "--quiet", "--output", "part.csv", "--resume", "m.ck", "--set", "orbit.eccentricity=0.05")
        self.assertEqual(self.read("part.csv"), self.read("moon.csv"))
        self.assertRegex(self.succeed("cost", "moon.nml", "--evaluations", "100000").stdout, r"agree to \S+ rad: 1[0-9] digits")

    def test_gravity_of_third_degree_reads_points(self):
        points = ((1, 0.12, 0, 0), (2, 0, 0.09, 0), (3, -0.02, -0.03, 0.08), (4, -0.015, -0.0225, -0.06))
        scene = BODY.replace("90.0, 100.0, 40.0", "0.05, 0.06, 0.075") + "&orbit mu = 1, periapsis_distance = 1, eccentricity = 1.5, " \
            "periapsis_time = 4 /\n&gravity_gradient /\n&third_degree {} /\n&initial angular_velocity = 0.2, -0.1, 0.5 /\n" \
            "&integrator time_step = 0.1, end_time = 8 /\n&output columns = 'quaternion', 'energy', 'energies' /\n"
        self.write("inline.nml", scene.format("points = " + ", ".join(str(x) for point in points for x in point)))
        lines = ["mass (kg),x (m),y (m),z (m)", *(",".join(str(x) for x in point) for point in points)]
        self.write("points.csv", "\n".join(lines) + "\n")
        self.write("file.nml", scene.format("table = 'points.csv'"))
        for method in ("nielsen_krenk", "taylor", "dop853"):
            for name in ("inline", "file"):
                self.succeed("run", name + ".nml", "--quiet", "--set", f"integrator.method={method}", "--set",
                             f"integrator.conserve=.{'true' if method != 'nielsen_krenk' else 'false'}.")
            self.assertEqual(self.read("inline.csv"), self.read("file.csv"))
            header, rows = self.history("file.csv")
            self.assertIn("energy_third_degree", header)
            for row in rows:
                self.assertLess(abs(row[header.index("energy_residual")]), 4e-16)
        self.succeed("run", "file.nml", "--quiet", "--output", "whole.csv")
        self.fail_with(3, "run", "file.nml", "--quiet", "--output", "part.csv", "--checkpoint", "p.ck", "--max-steps", "30")
        self.succeed("run", "file.nml", "--quiet", "--output", "part.csv", "--resume", "p.ck")
        self.assertEqual(self.read("whole.csv"), self.read("part.csv"))
        for number, line, says in ((1, lines[0].replace("kg", "g"), "lacks the unit (kg)"), (3, "0,0,0.09,0", "the mass of a point"),
                                   (4, "3,1e30,0,0", "the position of a point"), (5, "4,0,0", "wrong number of values")):
            self.write("points.csv", "\n".join(lines[:number - 1] + [line] + lines[number:]) + "\n")
            self.fail_with(2, "run", "file.nml", says=(f"points.csv:{number}: ", says))
        self.write("points.csv", lines[0] + "\n")
        self.fail_with(2, "run", "file.nml", says=("points.csv:1: there is no point",))

    def test_auto_takes_the_series(self):
        self.write("auto.nml", MOVING.replace("time_step = 40.0", "accuracy = 1e-9"))
        self.assertIn("taylor", self.succeed("check", "auto.nml").stdout)
        self.succeed("run", "auto.nml", "--quiet")

    def test_interrupted_runs_go_on(self):
        self.succeed("run", "orbit.nml", "--quiet", "--output", "whole.csv")
        self.fail_with(3, "run", "orbit.nml", "--quiet", "--output", "part.csv", "--checkpoint", "p.ck", "--max-steps", "100")
        self.succeed("run", "orbit.nml", "--quiet", "--output", "part.csv", "--resume", "p.ck")
        for end in (".csv", ".events.csv"):
            self.assertEqual(self.read("whole" + end), self.read("part" + end))

    def test_members_keep_the_rate_of_the_orbit(self):
        self.write("many.nml", SCENE + "&ensemble members = 2, file = 'many.npy' /\n&vary key = 'initial.angular_velocity.1', "
                   "distribution = 'normal', sigma = 0.0 /\n")
        self.succeed("run", "orbit.nml", "--quiet")
        self.succeed("sweep", "many.nml", "--quiet", "--member", "1", "--output", "member.csv")
        self.assertEqual(self.history("member.csv"), self.history("orbit.csv"))


if __name__ == "__main__":
    unittest.main()
