"""Bodies whose inertia varies: what runs print, tables and their errors, sweeps and fits."""
import re
import unittest

from support import CommandLineTest, in_turn

TABLE = "t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,1.5,2,2.5\n2,1.6,2.4,2.9\n4,1.7,2.6,3\n6,1.7,3,3.4\n"
REST = """&initial angular_velocity = 0.3, 0.1, 1.2 /
&integrator method = 'nielsen_krenk', order = 8, formulation = 'reduced', time_step = 0.05, end_time = 5.0 /
&output columns = 'angular_velocity', 'angular_momentum_space', 'energy', 'time_dependent_work' /
"""
BOOM = "&body inertia_table = 'table.csv' /\n" + REST
RATE = "&body inertia = 1.5, 2.0, 2.5 /\n&inertia_rate tensor = 0.05, 0.2, 0.2, start = 1.0, stop = 4.0 /\n" + REST


class VaryingInertia(CommandLineTest):
    def setUp(self):
        super().setUp()
        self.write("table.csv", TABLE)
        self.write("boom.nml", BOOM)
        self.write("rate.nml", RATE)

    def test_momentum_stays_and_the_balance_closes(self):
        for name in ("boom", "rate"):
            page = self.succeed("run", f"{name}.nml").stderr
            self.assertIn("work of time-dependent inertia", page)
            # Masses that stay exert no torque.
            self.assertNotIn("work of inertia_", page)
            _, rows = self.history(f"{name}.csv")
            for row in rows:
                for component in (4, 5, 6):
                    self.assertAlmostEqual(row[component], rows[0][component], delta=1e-14)
                self.assertLess(abs(row[11]), 1e-14)
                self.assertAlmostEqual(row[9] - row[12], rows[0][9], delta=1e-14)
            self.assertLess(rows[-1][12], -0.1)

    def test_every_method_ends_at_the_same_rate(self):
        self.succeed("run", "boom.nml", "--quiet")
        expected = self.history("boom.csv")[1][-1][1:4]
        for method in ("rk8", "dop853", "taylor"):
            settings = (f"integrator.method={method}", "integrator.conserve=.true.", "integrator.time_step=0.02")
            self.succeed("run", "boom.nml", "--quiet", "--output", f"{method}.csv", "--unset", "integrator.order", "--unset",
                         "integrator.formulation", *(word for setting in settings for word in ("--set", setting)))
            for value, other in zip(self.history(f"{method}.csv")[1][-1][1:4], expected):
                self.assertAlmostEqual(value, other, delta=1e-12)

    def test_check_tells_what_varies(self):
        page = self.succeed("check", "boom.nml").stdout
        for text in ("varies with time: the moments are those of t = 0, the centre of mass stays", "but the change of the inertia"):
            self.assertIn(text, page)
        page = self.succeed("check", "rate.nml", "--set", "inertia_rate.mass_leaves=.true.").stdout
        self.assertIn("varies with time as mass leaves: the moments", page)

    def test_errors_name_line_and_time(self):
        self.write("table.csv", TABLE.replace("4,1.7,2.6,3\n", "4,1.7,2.6,4.4\n"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:4: no rigid body has the principal moments",))
        self.write("table.csv", TABLE.replace("J3 (kg m2)", "J3"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:1:", "lacks the unit (kg m2)"))
        self.write("table.csv", TABLE.replace("2,1.6", "0,1.6"))
        self.fail_with(2, "check", "boom.nml", says=("table.csv:3: the time repeats",))
        self.write("table.csv", TABLE)
        self.fail_with(2, "check", "boom.nml", "--set", "integrator.end_time=7",
                       says=("end_time is outside of the table of the inertia (expected 0 to 6 s)",))
        self.fail_with(2, "check", "rate.nml", "--set", "inertia_rate.tensor=0,0,1", says=("at t = 2.000000 s",))
        self.fail_with(2, "check", "rate.nml", "--set", "output.columns='tumbling'", says=("a constant inertia",))
        self.fail_with(2, "run", "rate.nml", "--set", "integrator.method='exact'", "--unset", "integrator.order", "--unset",
                       "integrator.formulation", says=("method 'exact' has no solution for an inertia that varies",))
        self.fail_with(2, "linearize", "rate.nml", says=("the inertia varies with time",))

    def derivative(self, key, scene, *settings):
        """Rates and their derivative with respect to a key, as written and as a difference of two runs."""
        columns = [f"omega{i}" for i in (1, 2, 3)]
        self.succeed("run", scene, "--quiet", "--output", "whole.csv", *settings)
        header, rows = self.history("whole.csv")
        written = [rows[-1][i] for i, name in enumerate(header) if name.startswith("d_omega")]
        value = float(re.search(re.escape(key.split(".")[1]) + r" = ([-.0-9]+)", self.read(scene))[1])
        ends = []
        for part in (-1e-4, 1e-4):
            self.succeed("run", scene, "--quiet", "--output", f"part{part}.csv", *settings, "--set", f"{key}={value + part!r}")
            header, rows = self.history(f"part{part}.csv")
            ends.append([rows[-1][header.index(name)] for name in columns])
        return written, [(b - a)/2e-4 for a, b in zip(*ends)]

    def test_derivatives_by_start_and_stop_are_those_of_differences(self):
        # In the gravity gradient the potential changes with the inertia.
        cases = ((leaves, gradient, key) for leaves, gradient in ((".false.", ""), (".true.", ""), (".false.", "&gravity_gradient direction = 1, 2, 2, strength = 0.5 /\n"),
                                 (".true.", "&orbit semi_major_axis = 7, mu = 100 /\n&gravity_gradient /\n"))
                 for key in ("inertia_rate.start", "inertia_rate.stop"))
        for turn, (leaves, gradient, key) in enumerate(cases):
            self.write("moved.nml", "&body inertia = 2, 3, 4 /\n&initial angular_velocity = 0.4, 0.3, 1.5 /\n"
                       f"&inertia_rate tensor = 0.1, 0.2, 0.3, start = 1.0, stop = 3.3, mass_leaves = {leaves} /\n{gradient}&free key = '{key}' /\n"
                       "&integrator end_time = 4.5 /\n&output times = 4.5, columns = 'angular_velocity', 'sensitivities' /\n")
            for number, settings in enumerate((("method='dop853'", "local_tolerance=1e-12"), ("method='rk8'", "time_step=0.05"),
                                               ("method='taylor'", "local_tolerance=1e-12"),
                                               ("method='nielsen_krenk'", "order=8", "time_step=0.02"),
                                               ("method='nielsen_krenk'", "order=8", "formulation='reduced'", "time_step=0.02")), turn):
                if not in_turn(number):
                    continue
                written, expected = self.derivative(key, "moved.nml", *(word for setting in settings
                                                                        for word in ("--set", f"integrator.{setting}")))
                self.assertGreater(max(map(abs, written)), 0.01)
                for value, other in zip(written, expected):
                    self.assertAlmostEqual(value, other, delta=2e-7, msg=f"{key} {leaves} {gradient} {settings}")

    def test_the_rates_of_a_free_rocket_do_not_depend_on_the_axes(self):
        self.write("rocket.nml", "&body inertia = 2, 3, 4 /\n&initial angular_velocity = 0.4, 0.3, 1.5 /\n"
                   "&rotating_frame rate = 0.1, 0.2, -0.1 /\n&inertia_rate tensor = 0.1, 0.2, 0.3, mass_leaves = .true. /\n"
                   "&free key = 'rotating_frame.rate.2' /\n&integrator end_time = 4.5 /\n"
                   "&output times = 4.5, columns = 'angular_velocity', 'sensitivities' /\n")
        for settings in (("method='dop853'", "local_tolerance=1e-12"), ("method='nielsen_krenk'", "order=8", "time_step=0.02")):
            self.succeed("run", "rocket.nml", "--quiet", "--output", f"rocket{len(settings[1])}.csv",
                         *(word for setting in settings for word in ("--set", f"integrator.{setting}")))
            header, rows = self.history(f"rocket{len(settings[1])}.csv")
            for i, name in enumerate(header):
                if name.startswith("d_omega"):
                    self.assertAlmostEqual(rows[-1][i], 0, delta=1e-11)

    def test_columns_in_another_order_are_refused(self):
        for names in ("J22 (kg m2),J11 (kg m2),J33 (kg m2)", "z (kg m2),y (kg m2),x (kg m2)"):
            self.write("table.csv", TABLE.replace("J1 (kg m2),J2 (kg m2),J3 (kg m2)", names))
            self.fail_with(2, "check", "boom.nml", says=("table.csv:1: the components are not in order (expected those of the axes",))
        six = "t (s),11 (kg m2),12 (kg m2),13 (kg m2),22 (kg m2),23 (kg m2),33 (kg m2)\n0,1,0,0,1,0,1\n6,1,0,0,1,0,1\n"
        self.write("table.csv", six)
        self.fail_with(2, "check", "boom.nml", says=("(expected 11, 22, 33, 12, 13, 23)",))
        self.write("table.csv", six.replace("12 (kg m2),13 (kg m2),22 (kg m2),23 (kg m2),33", "22 (kg m2),33 (kg m2),12 (kg m2),31 (kg m2),23"))
        self.fail_with(2, "check", "boom.nml", says=("not positive definite",))
        self.write("table.csv", six.replace("11 (", "Ixx_cm (").replace("12 (", "Iyy_cm (").replace("13 (", "Izz_cm (").replace("22 (", "Ixy_cm (")
                   .replace("23 (", "Iyz_cm (").replace("33 (", "Izx_cm ("))
        self.fail_with(2, "check", "boom.nml", says=("(expected 11, 22, 33, 12, 13, 23)",))

    def test_headers_of_torques_and_paths(self):
        self.write("torque.nml", "&body inertia = 1, 2, 2.5 /\n&initial angular_velocity = 1, 0, 0 /\n&torque table = 't.csv' /\n"
                   "&integrator time_step = 0.1, end_time = 1 /\n")
        self.write("orbit.nml", "&body inertia = 1, 2, 2.5 /\n&initial angular_velocity = 1, 0, 0 /\n&orbit table = 'p.csv' /\n"
                   "&integrator time_step = 0.1, end_time = 1 /\n&gravity_gradient /\n")

        def check(scene, names, says, *options):
            names = names.split(",")
            self.write("t.csv", "t (s)," + ",".join(f"{name} (N m)" for name in names) + "\n0,1,2,3\n1,1,2,3\n")
            self.write("p.csv", "t (s)," + ",".join(f"{name} (m)" for name in names) + "".join(f"\n{t},7e6,{7e3 * t},0" for t in range(4)) + "\n")
            with self.subTest(names, scene=scene):
                if says:
                    self.fail_with(2, "check", scene, *options, says=(".csv:1: " + says,))
                else:
                    self.succeed("check", scene, *options)

        order = "the components are not in order (expected those of the axes 1, 2, 3)"
        for names in ("z_body,y_body,x_body", "z torque,y torque,x torque", "yaw,pitch,roll", "tau2,tau1,tau0", "Tz1,Ty1,Tx1", "T[3],T[2],T[1]",
                      "x,y,y", "x,x,x", "x,z,w", "z.,y.,x."):
            check("torque.nml", names, order)
        for names in ("x_body,y_body,z_body", "roll,pitch,yaw", "roll,pitch,spin", "tau0,tau1,tau2", "T1x,T1y,T1z", ",,", "torque,torque,torque",
                      "x in spacecraft axes,y in spacecraft axes,z in spacecraft axes", "body and not space x,y,z"):
            check("torque.nml", names, "")
        space = ("--set", "torque.axes=space")
        for names in ("x_space,y_space,z_space", "tau_X_ECI,tau_Y_ECI,tau_Z_ECI", "inertial x,inertial y,inertial z",
                      "T_ENU_x,T_ENU_y,T_ENU_z", "x_eclipj2000,y_eclipj2000,z_eclipj2000"):
            check("torque.nml", names, f"'{names.split(',')[0]}' names other axes (expected components along body axes)")
            check("torque.nml", names, "", *space)
        check("torque.nml", "x_body,y_body,z_body", "'x_body' names other axes (expected components along space axes)", *space)
        # The space axes are what orbit and rotating frame make them, wherever these stand in the scene.
        for frame, rest in (("LVLH", "&orbit altitude = 5e5, frame = 'lvlh' /"), ("inertial", "&orbit altitude = 5e5 /"),
                            ("rotating", "&rotating_frame rate = 0, 0, 1e-4 /"), ("space", "&rotating_frame rate = 0, 0, 1e-4, on = .false. /")):
            self.write(f"{frame}.nml", self.read("torque.nml") + rest + "\n")
            for name, wrong in (("space", ()), ("inertial", ("LVLH", "rotating")), ("J2000", ("LVLH", "rotating")),
                                ("TEME", ("LVLH", "rotating")), ("LVLH", ("inertial", "space")), ("VVLH", ("inertial", "space")),
                                ("ECEF", ("LVLH", "inertial", "space")), ("NED", ("LVLH", "inertial")), ("RTN", ("LVLH", "inertial", "space"))):
                says = f"'Tx_{name}' names other axes (expected components along {frame} axes)" if frame in wrong else ""
                check(f"{frame}.nml", f"Tx_{name},Ty_{name},Tz_{name}", says, *space)
        check("orbit.nml", "x_ECEF,y_ECEF,z_ECEF", "'x_ECEF' names other axes (expected components along inertial axes)")
        check("orbit.nml", "x_ECI,y_ECI,z_ECI", "")

    def test_a_sweep_of_rates(self):
        self.write("sweep.nml", RATE + "&ensemble members = 3, seed = 1 /\n"
                   "&vary key = 'inertia_rate.tensor.3', distribution = 'uniform', low = 0.1, high = 0.2 /\n")
        self.succeed("sweep", "sweep.nml", "--quiet", "--csv", "sweep.csv")
        header, rows = self.history("sweep.csv")
        self.assertEqual(len(rows), 3)
        # The inertia at the end is that of the member: l = (J + 3 K) omega about axis 3.
        rate, omega = header.index("inertia_rate.tensor.3"), header.index("omega3")
        self.assertEqual(len({row[omega] for row in rows}), 3)
        self.assertEqual([row[omega] for row in sorted(rows, key=lambda row: row[rate])], sorted((row[omega] for row in rows), reverse=True))

    def test_a_boom_deploys_in_the_gravity_gradient(self):
        orbit = "&orbit altitude = 500e3, inclination = 0.9{} /\n&gravity_gradient /\n"
        scene = ("&body inertia_table = 'long.csv', inertia_interpolation = 'cubic' /\n{}&initial angular_velocity = 1e-3, 2e-3, 3e-3, attitude_from = 'lvlh', rate_from = 'lvlh' /\n"
                 "&integrator end_time = 6000.0{} /\n&output columns = 'energy', 'time_dependent_work', 'lvlh_attitude', every = 100 /\n")
        self.write("long.csv", "t (s),J1 (kg m2),J2 (kg m2),J3 (kg m2)\n0,20,25,30\n1000,25,90,95\n3000,25,190,195\n6000,25,190,195\n")
        method = ", method = 'nielsen_krenk', order = {}, formulation = 'reduced', time_step = 10.0"
        self.write("boom.nml", scene.format(orbit.format(""), method.format(2)))
        page = self.succeed("run", "boom.nml").stderr
        self.assertIn("work of dependence on time", page)
        residual = float(re.search(r"energy residual +(\S+)", page)[1])
        self.assertLess(residual, 1e-14)
        self.succeed("run", "boom.nml", "--quiet", "--set", "integrator.order=8", "--output", "order8.csv")
        expected = self.history("order8.csv")[1][-1]
        # In LVLH axes the gradient stands, and roll, pitch and yaw are the same.
        for name, frame, settings in (("lvlh", ", frame = 'lvlh'", method.format(8)), ("series", "", ", accuracy = 1e-9"),
                                      ("lvlh_series", ", frame = 'lvlh'", ", method = 'taylor', conserve = .true., time_step = 10.0"),
                                      ("explicit", "", ", method = 'dop853', conserve = .true., time_step = 10.0")):
            self.write(f"{name}.nml", scene.format(orbit.format(frame), settings))
            self.succeed("run", f"{name}.nml", "--quiet")
            last = self.history(f"{name}.csv")[1][-1]
            for value, other in zip(last[6:9], expected[6:9]):
                self.assertAlmostEqual(value, other, delta=2e-9, msg=name)

    def test_a_centre_of_mass_moves(self):
        self.write("center.csv", "t (s),x (m),y (m),z (m)\n0,0,0,0.1\n2,0,0,0.3\n6,0,0,0.2\n")
        scene = ("&body inertia = 2, 2, 1, mass = 3, center_of_mass_table = 'center.csv' /\n&gravity acceleration = 0, 0, -10 /\n"
                 "&initial angular_velocity = 0, 0, 40 /\n&integrator time_step = 0.05, end_time = 2.0 /\n"
                 "&output columns = 'energy', 'time_dependent_work', 'works' /\n")
        self.write("rise.nml", scene)
        page = self.succeed("run", "rise.nml").stderr
        # m g h = 3 kg, 10 m/s2, 0.2 m.
        self.assertRegex(page, r"work of time-dependent potentials +6 J")
        self.assertNotIn("work of center", page)
        # The natural spline through these lines is z = 0.215625 m at 1 s; the straight line is 0.2 m.
        for way, work in (("linear", "3"), ("cubic", "3.46875")):
            page = self.succeed("run", "rise.nml", "--set", f"body.center_of_mass_interpolation='{way}'", "--set", "integrator.end_time=1").stderr
            self.assertRegex(page, rf"work of time-dependent potentials +{work} J", way)
        page = self.succeed("check", "rise.nml").stdout
        self.assertIn("0, 0, 0.1 m, at t = 0: it moves by a table", page)
        self.fail_with(2, "check", "rise.nml", "--set", "integrator.end_time=7",
                       says=("end_time is outside of the table of the centre of mass (expected 0 to 6 s)",))
        self.fail_with(2, "run", "rise.nml", "--set", "integrator.method='exact'", says=("method 'exact' solves free bodies only",))
        self.fail_with(2, "check", "rise.nml", "--set", "body.center_of_mass=0,0,1", says=("exclude each other",))
        self.fail_with(2, "check", "rise.nml", "--set", "body.inertia_about='center_of_mass'", says=("the centre of mass moves",))
        self.write("free.nml", scene.replace("&gravity acceleration = 0, 0, -10 /\n", ""))
        self.fail_with(2, "check", "free.nml", says=("free.nml:1:", "nothing in the scene depends on the centre of mass"))
        self.write("fuel.nml", scene.replace("inertia = 2, 2, 1", "inertia_table = 'table.csv', mass_leaves = .true."))
        self.fail_with(2, "check", "fuel.nml", says=("the weight of a body whose centre of mass moves needs a constant mass",))
        self.write("both.nml", scene.replace("inertia = 2, 2, 1", "inertia_table = 'table.csv'"))
        self.succeed("run", "both.nml", "--quiet")
        self.write("center.csv", "t (s),x (m),y (m),z\n0,0,0,0.1\n2,0,0,0.3\n")
        self.fail_with(2, "check", "rise.nml", says=("center.csv:1:", "lacks the unit (m)"))
        self.write("center.csv", "t (s),x (m),y (m),z (m)\n1,0,0,0.1\n2,0,0,0.3\n")
        self.fail_with(2, "check", "rise.nml", says=("center.csv:2: the table of the centre of mass lacks t = 0",))

    def test_a_fit_finds_rates_and_scale_in_noise(self):
        for name, key, truth, near in (("rate", "inertia_rate.tensor.3", 0.2, "inertia_rate.tensor=0.05,0.2,0.15"),
                                       ("boom", "body.inertia_scale", 1.0, "body.inertia_scale=1.02")):
            scene = self.read(f"{name}.nml").replace("'table.csv'", "'table.csv', inertia_scale = 1")
            # The rates of a free body do not depend on the scale.
            scene += "&gravity acceleration = 0, 0, -1 /\n"
            scene = scene.replace("&body ", "&body mass = 1.0, center_of_mass = 0.0, 0.0, 0.3, ")
            self.find_in_noise(scene, {key: truth}, "--set", near, sigma=0.001)

    def test_derivatives_of_a_body_with_both_tables_are_those_of_differences(self):
        self.write("center.csv", "t (s),x (m),y (m),z (m)\n0,0,0,0.1\n2,0.1,0,0.3\n6,0,0.1,0.2\n")
        for turn, key in enumerate(("body.inertia_scale", "body.mass", "orbit.mu", "orbit.inclination")):
            self.write("both.nml", "&body inertia_table = 'table.csv', inertia_scale = 1.1, mass = 3, center_of_mass_table = 'center.csv' /\n"
                       "&gravity acceleration = 0, 0, -2 /\n&orbit semi_major_axis = 7, eccentricity = 0.2, inclination = 0.4, mu = 100 /\n&gravity_gradient /\n"
                       f"&initial angular_velocity = 0.4, 0.3, 1.5 /\n&free key = '{key}' /\n"
                       "&integrator end_time = 4.5 /\n&output times = 4.5, columns = 'angular_velocity', 'sensitivities' /\n")
            for number, (method, step) in enumerate((("dop853", "local_tolerance=1e-12"), ("taylor", "local_tolerance=1e-12"),
                                                     ("nielsen_krenk", "order=8"), ("rk4", "time_step=0.01")), turn):
                if not in_turn(number):
                    continue
                settings = ["--set", f"integrator.method='{method}'", "--set", f"integrator.{step}"]
                settings += ["--set", "integrator.time_step=0.02"] if method == "nielsen_krenk" else []
                written, expected = self.derivative(key, "both.nml", *settings)
                self.assertGreater(max(map(abs, written)), 0.001)
                for value, other in zip(written, expected):
                    self.assertAlmostEqual(value, other, delta=2e-7, msg=f"{key} {method}")

    def test_a_fit_finds_mass_and_gravity_of_a_body_that_changes(self):
        self.write("center.csv", "t (s),x (m),y (m),z (m)\n0,0,0,0.1\n2,0.1,0,0.3\n6,0,0.1,0.2\n")
        scene = BOOM.replace("'table.csv'", "'table.csv', inertia_scale = 1, mass = 1, center_of_mass_table = 'center.csv'")
        self.find_in_noise(scene + "&gravity acceleration = 0, 0, -1 /\n", {"body.mass": 1.0}, "--set", "body.mass=1.1", sigma=0.001)
        orbit = "&orbit semi_major_axis = 7, eccentricity = 0.2, mu = 100 /\n&gravity_gradient /\n"
        self.find_in_noise(RATE + orbit, {"orbit.mu": 100.0, "inertia_rate.tensor.3": 0.2}, "--set", "orbit.mu=105",
                           "--set", "inertia_rate.tensor=0.05,0.2,0.15", "--set", "integrator.method='taylor'", "--unset", "integrator.order",
                           "--unset", "integrator.formulation", sigma=0.001)


if __name__ == "__main__":
    unittest.main()
