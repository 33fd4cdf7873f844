"""nutate check, --help and --version."""
import re
import unittest

from support import (BOX, COLUMNS, CONTROL_COLUMNS, EFFECT_COLUMNS, FIELD_COLUMNS, FRAME_COLUMNS, FREE_COLUMNS, ORBIT_COLUMNS, POINTING_COLUMNS,
                     ROOT, SPHERE_COLUMNS, SUN_COLUMNS, TOP, TUMBLING_COLUMNS, WHEEL_COLUMNS, CommandLineTest)


class Check(CommandLineTest):
    def test_says_what_would_be_simulated_and_writes_nothing(self):
        done = self.succeed("check", "top.nml")
        self.assertEqual(done.stderr, "")
        for words in ("top.nml: top", "5, 5, 1 kg m^2", "1 kg\n", "0, 0, 1 m", "rotated by 0.5 rad about 1, 0, 0",
                      "0, 0, 50 rad/s in body axes", "  gravity             acceleration = 0, 0, -20\n",
                      "nielsen_krenk of order 2",
                      "8 equations in q and p", "200 of 0.005 s, to t = 1 s", "0.25 rad", "component along 0, 0, 1",
                      "unit norm", "top.csv", "201, one for each step", "t,q0,q1,q2,q3,omega1"):
            self.assertIn(words, done.stdout)
        self.assertEqual(self.names(), ["box.nml", "top.nml"])

    def test_a_key_that_the_method_does_not_use_is_noted(self):
        keys = {"max_iterations": "30", "tolerance": "1e-12", "auxiliary_inertia": "2", "projection": ".true."}
        for command in ("check", "run"):
            for key, value in keys.items():
                note = f"{key} has no effect with method rk4"
                set_key = ("--set", f"integrator.{key}={value}")
                done = self.succeed(command, "box.nml", "--set", "integrator.method=rk4", *set_key)
                self.assertEqual((done.stdout + done.stderr).count(note), 1)
                done = self.succeed(command, "box.nml", *set_key)
                self.assertNotIn("has no effect", done.stdout + done.stderr)

    def test_free_body(self):
        text = self.succeed("check", "box.nml").stdout
        for words in ("torque-free rigid body", "all components", "shape               box"):
            self.assertIn(words, text)

    def test_the_projection_onto_the_invariants_is_announced_and_summed_up(self):
        override = ("--set", "integrator.method='dop853'", "--set", "integrator.conserve=.true.")
        self.assertIn("12 stages, projection onto the invariants\n", self.succeed("check", "box.nml", *override).stdout)
        self.assertNotIn("projection", self.succeed("check", "box.nml", *override[:2]).stdout)
        self.assertIn("  projection          onto the invariants\n",
                      self.succeed("run", "box.nml", *override).stderr)
        self.assertNotIn("projection", self.succeed("run", "box.nml", *override[:2]).stderr)
        self.fail_with(2, "check", "box.nml", "--set", "integrator.method='exact'", "--set", "integrator.conserve=.true.",
                       says=("conserves by itself",))
        self.succeed("check", "box.nml", "--set", "integrator.conserve=.false.")
        self.assertIn("projection onto the invariants",
                      self.succeed("check", "box.nml", "--set", "integrator.conserve=.true.").stdout)

    def test_overrides_count(self):
        text = self.succeed("check", "box.nml", "--set", "output.every=20", "--set", "integrator.end_time=1").stdout
        self.assertIn("100 of 0.01 s, to t = 1 s", text)
        self.assertIn("6, one for every 20 steps", text)

    def test_a_length_of_steps_set_takes_the_place_of_the_file_s(self):
        text = self.succeed("check", "top.nml", "--set", "integrator.accuracy=1e-6").stdout
        self.assertNotIn("of 0.005 s", text)
        self.assertIn("1E-6 rad", text)
        self.write("rare.nml", TOP + "&output every = 50 /")
        text = self.succeed("check", "rare.nml", "--set", "integrator.local_tolerance=1e-6",
                            "--set", "output.interval=0.125").stdout
        self.assertIn("9, one every 0.125 s", text)
        self.assertNotIn("at most", text)
        text = self.succeed("check", "rare.nml", "--set", "integrator.local_tolerance=1e-6", "--set", "integrator.max_step=0.25").stdout
        self.assertIn("of at most 0.25 s each", text)
        # What was set on the command line stays.
        self.fail_with(2, "check", "box.nml", "--set", "integrator.accuracy=1e-6", "--set", "integrator.time_step=0.1",
                       says=("--set: accuracy and time_step in &integrator exclude each other",))

    def test_a_key_can_be_taken_out(self):
        self.write("offset.nml", TOP.replace("mass = 1.0,", "mass = 1.0, check_triangle = .true.,"))
        for arguments in (("--unset", "body.center_of_mass"), ("--unset=body.Center_of_mass",)):
            text = self.succeed("check", "offset.nml", *arguments, "--unset", "body.check_triangle").stdout
            self.assertIn("0, 0, 0 m\n", text)
        # One after the other; what is not there can be taken out.
        self.assertIn("0, 0, 2 m\n", self.succeed("check", "top.nml", "--unset", "body.center_of_mass",
                                                  "--set", "body.center_of_mass=0,0,2", "--unset", "scene.title").stdout)
        self.fail_with(2, "check", "top.nml", "--unset", "body.inertia", says=("top.nml:1: &body is incomplete",))
        self.fail_with(2, "check", "top.nml", "--unset", "body.mas", says=("--unset: unknown key 'mas'", "nearest: mass"))
        self.fail_with(2, "check", "top.nml", "--unset", "mass", says=("--unset: 'mass' is not a setting",))
        self.fail_with(2, "check", "top.nml", "--set=-body.mass", says=("--set '-body.mass' is not a setting",))

    def test_a_later_group_of_a_name_can_be_set(self):
        self.write("wheels.nml", BOX + "&wheel axis = 1,0,0, inertia = 0.1, friction = 0.25 /\n"
                   "&wheel axis = 0,1,0, inertia = 0.1, friction = 0.5 /\n")
        for override, expected in (("wheel.2.friction=0.375", ["0.25", "0.375"]), ("wheel.1.friction=0.375", ["0.375", "0.5"]),
                                   ("wheel.friction=0.375", ["0.375", "0.5"])):
            text = self.succeed("check", "wheels.nml", "--set", override).stdout
            self.assertEqual(re.findall(r"^  wheel .* friction = ([0-9.]+);", text, re.MULTILINE), expected)
        text = self.succeed("check", "wheels.nml", "--unset", "wheel.2.friction").stdout
        self.assertEqual(re.findall(r"^  wheel .* friction = ([0-9.]+)[; ]", text, re.MULTILINE), ["0.25", "0"])
        for option, value in (("--set", "=0.375"), ("--unset", "")):
            self.fail_with(2, "check", "wheels.nml", option, "wheel.3.friction" + value,
                           says=(f"{option}: the scene has no group &wheel number 3",))

    def test_texts_need_no_quotes_on_the_command_line(self):
        text = self.succeed("check", "box.nml", "--set", "output.file=it's here!.csv", "--set", "scene.title=a = b, c",
                            "--set", "output.columns=euler, energy", "--set", "integrator.method=dop853").stdout
        for words in ("it's here!.csv", "box.nml: a = b, c\n", "t,phi,theta,psi,kinetic", "12 stages"):
            self.assertIn(words, text)
        self.assertIn("t,phi,theta,psi,kinetic",
                      self.succeed("check", "box.nml", "--set", "output.columns='energy','euler'").stdout)
        self.fail_with(2, "check", "box.nml", "--set", "output.columns=euler,enegy",
                       says=("--set: 'enegy' is not available", "nearest: energy"))

    def test_rows_announced_are_rows_written(self):
        for every in (1, 7, 20, 1000):
            override = f"output.every={every}"
            text = self.succeed("check", "box.nml", "--set", override).stdout
            announced = int(text.split("  rows")[1].split(",")[0])
            self.succeed("run", "box.nml", "--quiet", "--set", override)
            self.assertEqual(announced, len(self.history("box.csv")[1]), every)

    def test_notes_warn(self):
        self.assertIn("intermediate axis", self.succeed("check", "box.nml").stdout)
        self.assertNotIn("notes", self.succeed("check", "top.nml").stdout)
        coarse = self.succeed("check", "top.nml", "--set", "integrator.time_step=0.05").stdout
        self.assertIn("2.5 rad", coarse.split("notes")[1])
        hopeless = self.succeed("check", "top.nml", "--set", "integrator.time_step=0.1").stdout
        self.assertIn("will be subdivided", hopeless.split("notes")[1])
        near = self.succeed("check", "top.nml", "--set", "body.inertia=5,5.0000001,1").stdout
        self.assertIn("nearly symmetric", near)

    def test_run_gives_the_notes_of_check(self):
        for scene, *settings in (("box.nml",), ("box.nml", "integrator.time_step=0.1"), ("top.nml", "integrator.time_step=0.05"),
                                 ("top.nml", "integrator.time_step=0.1"), ("top.nml", "body.inertia=5,5.0000001,1"),
                                 ("top.nml", "initial.angle=30"), ("top.nml",), 
                                 ("top.nml", "body.inertia=5,5,20", "body.check_triangle=.false.")):
            overrides = [word for setting in settings for word in ("--set", setting)]
            checked = self.succeed("check", scene, *overrides).stdout
            summary = self.succeed("run", scene, *overrides).stderr
            wanted = [line.strip() for line in checked.split("\nnotes\n")[1].splitlines()] if "\nnotes\n" in checked else []
            self.assertEqual([line[22:].strip() for line in summary.splitlines() if line.startswith("  note ")], wanted, settings)
        self.assertIn("the invariants are conserved, but the phase is not accurate",
                      self.succeed("run", "box.nml", "--set", "integrator.time_step=0.1").stderr)

    def warnings(self, scene, *settings):
        """What check and the summary of a run note: the same warnings."""
        overrides = [word for setting in settings for word in ("--set", setting)]
        checked = self.succeed("check", scene, *overrides).stdout
        summary = self.succeed("run", scene, *overrides).stderr
        for line in summary.splitlines():
            if line.startswith("  note "):
                self.assertIn(line[22:].strip(), checked)
        return " ".join(line[22:].strip() for line in summary.splitlines() if line.startswith("  note "))

    def test_slips_of_units_and_unstable_loops_are_noted(self):
        spin = "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 2 /\n&integrator time_step = 0.01, end_time = 100 /\n"
        for text, says in (
                ("&orbit altitude = 500, inclination = 97.4 /\n&gravity_gradient /\n", "an angle of 97.4 rad in inclination is more than a turn"),
                ("&orbit altitude = 500, inclination = 97.4 /\n&gravity_gradient /\n", "the altitude of the orbit is 500 m"),
                ("&controller law = 'quaternion', attitude_gain = 1, rate_gain = 10, sample = 0.3 /\n",
                 "a sampled controller is unstable: D*sample/J, D its matrix of rate gains, is 3 (expected less than 2)"),
                ("&output every = 200 /\n", "by half a turn or more between rows, which are 2 s apart")):
            with self.subTest(says):
                self.write("slip.nml", spin + text)
                self.assertIn(says, " ".join(self.succeed("check", "slip.nml").stdout.split()))
        self.write("good.nml", spin + "&controller law = 'quaternion', attitude_gain = 1, rate_gain = 3, sample = 0.3 /\n"
                   "&orbit altitude = 500e3, inclination = 1.7 /\n&gravity_gradient /\n&output every = 100 /\n")
        self.assertNotIn("note", self.succeed("check", "good.nml").stdout)

    def notes(self, scene, text):
        """What check notes on a scene."""
        self.write(scene, text)
        return " ".join(self.succeed("check", scene).stdout.partition("\nnotes\n")[2].split())

    def test_an_orbit_without_use_is_noted(self):
        spin = ("&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 2 /\n&integrator time_step = 0.01, end_time = 1 /\n"
                "&orbit altitude = 500e3 /\n")
        unused = "no effect, column, event, start or controller refers to &orbit (&gravity_gradient adds its gravity)"
        self.assertEqual(self.notes("unused.nml", spin), unused)
        self.assertEqual(self.notes("fixed.nml", spin + "&gravity_gradient direction = 0, 0, 1, strength = 1e-6 /\n"), unused)
        for use in ("&gravity_gradient /\n", "&output columns = 'eclipse' /\n", "&output columns = 'lvlh_attitude' /\n",
                    "&event when = 'orbit_radius', crosses = 7e6 /\n", "&event when = 'roll', crosses = 0.1 /\n", "&earth_field moment = 0, 0, 1 /\n",
                    "&controller law = 'quaternion', attitude_gain = 1, rate_gain = 3 /\n"):
            with self.subTest(use):
                text = spin.replace("500e3", "500e3, sun = 1, 0, 0") if "eclipse" in use else spin
                self.assertEqual(self.notes("used.nml", text + use), "")
        for start in ("attitude_from = 'lvlh'", "rate_from = 'lvlh'"):
            self.assertEqual(self.notes("start.nml", spin.replace("2 /", f"2, {start} /")), "")

    def test_wheels_that_do_not_span_three_axes_are_noted(self):
        spin = ("&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 0.1 /\n&integrator method = 'dop853', conserve = .true., "
                "time_step = 0.01, end_time = 1 /\n&controller law = 'quaternion', by = 'wheels', attitude_gain = 1, rate_gain = 1 /\n")
        wheels = [f"&wheel axis = {axis}, inertia = 1e-3 /\n" for axis in ("1, 0, 0", "0, 1, 0", "1, 1, 0", "0, 1, 1")]
        for sampled in ("", ", sample = 0.5"):
            scene = spin.replace("rate_gain = 1", "rate_gain = 1" + sampled)
            flat = self.notes("flat.nml", scene + "".join(wheels[:3]))
            self.assertIn("the wheels of a controller do not span three axes", flat)
            self.assertEqual(self.notes("full.nml", scene + "".join(wheels)), "")
        self.assertNotIn("span", self.succeed("check", "flat.nml", "--set", "controller.by='torque'").stdout)

    def test_a_centre_of_mass_that_nothing_holds_is_noted(self):
        spin = "&body inertia = 1, 1.2, 1.5, mass = 1, center_of_mass = 0, 0, 0.1 /\n&initial angular_velocity = 0, 0, 2 /\n" \
               "&integrator time_step = 0.01, end_time = 1 /\n"
        note = "nothing holds the body at its reference point: a free body rotates about its centre of mass"
        self.assertIn(note, self.notes("free.nml", spin))
        self.assertIn(note, self.notes("orbit.nml", spin + "&orbit altitude = 500e3 /\n&gravity_gradient /\n"))
        for pivot in ("&gravity /\n", "&spring body_point = 0, 0, 1, anchor = 0, 0, 2, stiffness = 1 /\n"):
            self.assertEqual(self.notes("pivot.nml", spin + pivot), "")
        self.assertEqual(self.notes("centred.nml", spin.replace("0, 0, 0.1", "0, 0, 0")), "")

    def test_a_member_number_that_looks_like_a_count_is_noted(self):
        spin = "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 2 /\n&integrator time_step = 0.01, end_time = 1 /\n" \
               "&vary key = 'initial.angular_velocity.3', distribution = 'normal', sigma = 0.1 /\n&ensemble members = 1000, histories = "
        self.assertEqual(self.notes("many.nml", spin + "500 /\n"),
                         "histories = 500 gives a history to member 500 alone: the key lists members")
        for few in ("7", "123", "10, 20"):
            self.assertEqual(self.notes("few.nml", spin + few + " /\n"), "")

    def test_rates_are_shown_in_both_units(self):
        self.write("spin.nml", "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 180 /\n"
                   "&integrator time_step = 1e-3, end_time = 0.01 /\n")
        self.assertIn("180 rad/s (1718.87 rpm) in all", self.succeed("check", "spin.nml").stdout)
        self.assertNotIn("given in deg/s", self.succeed("check", "spin.nml").stdout)
        self.assertIn("  initial rate        180 rad/s (1718.87 rpm)\n", self.succeed("run", "spin.nml").stderr)
        text = self.succeed("check", "spin.nml", "--set", "initial.degrees=.true.").stdout
        self.assertIn("3.14159 rad/s (30 rpm) in all\n                      given in deg/s, by degrees = .true.\n", text)

    def test_switches_of_effects_are_shown(self):
        spin = "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 2 /\n&integrator time_step = 0.01, end_time = 1 /\n"
        self.write("leaves.nml", spin + "&inertia_rate tensor = -0.1, -0.1, -0.1, mass_leaves = T /\n"
                   "&orbit altitude = 5e5, inclination = 97, degrees = .true. /\n&damping coefficient = 3*1, on = F /\n")
        text = self.succeed("check", "leaves.nml").stdout
        self.assertIn("-0.1, -0.1, -0.1; mass_leaves = .true.", text)
        self.assertIn("inclination = 97; degrees = .true.;", text)
        self.assertIn("coefficient = 1, 1, 1; off at the start\n", text)
        self.assertIn("-0.1; mass_leaves = .false.", self.succeed("check", "leaves.nml", "--set", "inertia_rate.mass_leaves=F").stdout)

    def test_orbits_are_shown_at_the_start(self):
        spin = "&body inertia = 1, 1.2, 1.5 /\n&initial angular_velocity = 0, 0, 2 /\n&integrator time_step = 0.01, end_time = 1 /\n"
        self.write("circle.nml", spin + "&orbit semi_major_axis = 8e6, mu = 8e14 /\n&gravity_gradient /\n")
        self.assertIn("  at t = 0: distance 8000 km, speed 10 km/s; period 5026.55 s\n", self.succeed("check", "circle.nml").stdout)
        self.write("ellipse.nml", spin + "&orbit periapsis_distance = 8e6, eccentricity = 0.44, mu = 8e14 /\n&gravity_gradient /\n")
        self.assertIn("  at t = 0: distance 8000 km, speed 12 km/s; period ", self.succeed("check", "ellipse.nml").stdout)
        self.write("track.csv", "t (s),x (m),y (m),z (m)\n" + "".join(f"{t},{7e6 + t},{7e3 * t},0\n" for t in range(9)))
        self.write("track.nml", spin + "&orbit table = 'track.csv' /\n&gravity_gradient /\n")
        text = self.succeed("check", "track.nml").stdout
        self.assertIn("  at t = 0: distance 7000 km, speed 7 km/s\n", text)
        self.assertNotIn("eccentricity", text)

    def test_likely_slips_are_noted(self):
        self.assertEqual(self.warnings("top.nml"), "")
        self.assertIn("an angle of 30 rad in angle is more than a turn: degrees = .true.",
                      self.warnings("top.nml", "initial.angle=30"))
        self.assertEqual(self.warnings("top.nml", "initial.angle=30", "initial.degrees=.true."), "")
        self.write("euler.nml", TOP.replace("axis = 1.0, 0.0, 0.0, angle = 0.5", "euler = 0.0, -20.0, 6.0"))
        self.assertIn("an angle of 20 rad in euler", self.warnings("euler.nml"))
        self.assertIn("&gravity has no effect", self.warnings("top.nml", "body.center_of_mass=0,0,0"))
        gradient = "&gravity_gradient direction = 0.0, 0.0, 1.0, strength = 1e-2 /\n"
        self.write("satellite.nml", TOP + gradient)
        self.assertIn("fixed in space: on a circular orbit it would turn once in 62.8 s",
                      self.warnings("satellite.nml", "integrator.end_time=2"))
        self.assertEqual(self.warnings("satellite.nml", "integrator.end_time=0.5"), "")
        self.write("twice.nml", TOP + "&torque body = 1.0, 0.0, 0.0, stop = 0.5 /\n&torque stop = 0.5, body = 1.0, 0.0, 0.0 /\n")
        self.assertEqual(self.warnings("twice.nml"), "a group &torque appears twice: its effect counts twice")
        self.assertEqual(self.warnings("twice.nml", "torque.stop=0.6"), "")
        self.write("often.nml", TOP + "&damping coefficient = 3*0.0 /\n&damping coefficient = 3*1.0 /\n" * 2000
                   + "&damping coefficient = -0.0, 2*0.0 /\n")
        checked = self.succeed("check", "often.nml").stdout
        self.assertIn("a group &damping appears 2001 times: its effect counts 2001 times\n", checked)
        self.assertIn("a group &damping appears 2000 times: its effect counts 2000 times\n", checked)
        self.assertEqual(checked.count("appears"), 2)

    def test_defaults_are_shown_as_numbers(self):
        self.write("plain.nml", TOP.replace("acceleration = 0.0, 0.0, -20.0 ", "")
                   + "&torque body = 1.0, 0.0, 0.0, phase = 0.5 /\n")
        text = self.succeed("check", "plain.nml").stdout
        self.assertIn("  gravity             acceleration = 0, 0, -9.80665 (default)\n", text)
        self.assertIn("  torque              body = 1, 0, 0; phase = 0.5; frequency = 0 (default)\n", text)

    def test_moments_of_no_body_are_said_to_be_such(self):
        self.write("odd.nml", TOP.replace("5.0, 5.0, 1.0", "1.0, 2.0, 4.0, check_triangle = .false."))
        self.assertIn("no rigid body", self.succeed("check", "odd.nml").stdout)
        self.assertIn("no rigid body", self.succeed("run", "odd.nml").stderr)


class Help(CommandLineTest):
    def test_help_names_all_commands(self):
        done = self.succeed("--help")
        self.assertEqual(done.stderr, "")
        for words in ("nutate run SCENE", "nutate check SCENE", "nutate SCENE", "--version", "Exit status"):
            self.assertIn(words, done.stdout)
        self.assertEqual(self.succeed("-h").stdout, done.stdout)

    def test_help_is_a_command_too(self):
        self.assertEqual(self.succeed("help").stdout, self.succeed("--help").stdout)
        for verb in ("run", "check", "cost"):
            self.assertEqual(self.succeed("help", verb).stdout, self.succeed(verb, "--help").stdout)
        self.fail_with(2, "help", "rum", says=("unknown command 'rum'", "nearest: run"))
        self.fail_with(2, "help", "run", "check", says=("unexpected argument 'check'",))

    def test_help_on_a_command_names_its_options(self):
        text = self.succeed("run", "--help").stdout
        for words in ("--output FILE", "--set GROUP.KEY=VALUE", "--quiet", "--max-steps N"):
            self.assertIn(words, text)
        for name, columns in {**COLUMNS, **ORBIT_COLUMNS, **SUN_COLUMNS, **WHEEL_COLUMNS, **EFFECT_COLUMNS}.items():
            self.assertIn(name, text)
            self.assertIn(",".join(columns), text)
        whole = re.sub(r",\n +", ",", text)
        for name, columns in {**SPHERE_COLUMNS, **CONTROL_COLUMNS, **POINTING_COLUMNS, **FIELD_COLUMNS, **TUMBLING_COLUMNS,
                              **FRAME_COLUMNS, **FREE_COLUMNS}.items():
            self.assertRegex(whole, rf"\n  {name} +" + ",".join(columns) + r"\n")
        self.assertNotIn("--output", self.succeed("check", "--help").stdout)
        self.assertEqual(self.succeed("run", "box.nml", "--help").stdout, text)

    def test_help_fits_a_wide_terminal(self):
        overview = self.succeed("--help").stdout
        verbs = re.findall(r"\n  nutate (\w+) [A-Z]+(?:\.csv)?  ", overview)
        self.assertIn("sweep", verbs)
        for text in (overview, *(self.succeed(verb, "--help").stdout for verb in verbs)):
            for line in text.splitlines():
                self.assertLessEqual(len(line), 110)

    def test_no_text_of_help_is_cut(self):
        with open(ROOT / "app" / "nutate_cli.f90", encoding="utf-8") as file:
            source = file.read()
        entries = re.findall(r"(verb|option)_t\(((?:[^()'&]|'[^']*'|&\n)*)\)", source)
        texts = [re.findall(r"'([^']*)'", words)[1 if kind == "verb" else 3] for kind, words in entries if words.startswith("'")]
        self.assertGreater(len(texts), 30)
        verbs = re.findall(r"verb_t\('(\w+)'", source)
        whole = "".join(self.succeed("help", verb).stdout for verb in verbs) + self.succeed("--help").stdout
        for text in texts:
            self.assertRegex(whole, re.escape(text) + "\n")

    def test_version(self):
        self.assertRegex(self.succeed("--version").stdout, r"^nutate \d+\.\d+\.\d+\narithmetic as written, .*\n$")

    def test_no_arguments_show_the_usage_on_standard_error(self):
        done = self.nutate()
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.stderr, self.succeed("--help").stdout)


if __name__ == "__main__":
    unittest.main()
