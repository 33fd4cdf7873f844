"""nutate.view: web pages of motions. Looked at in a headless Chromium, where there is one."""

import base64
import html
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

import nutate
from nutate import shapes
from test_nutate import BOX, SCENES

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SIZE = 1000, 700


def find_browser():
    """A browser that starts: Ubuntu's package is none where there is no snap."""
    for name in BROWSERS:
        path = shutil.which(name)
        if path and subprocess.run([path, "--version"], capture_output=True, timeout=600).returncode == 0:
            return path
    return None


def browse(browser, page, *options):
    """What a browser says of a page, its standard output and what came to its console."""
    with tempfile.TemporaryDirectory() as profile:
        ran = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
                              "--hide-scrollbars", f"--window-size={SIZE[0]},{SIZE[1]}",
                              "--enable-logging=stderr", "--disable-dev-shm-usage",
                              "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={profile}", *options, f"file://{page}"],
                             capture_output=True, text=True, timeout=600)
    console = re.findall(r":(?:INFO|WARNING|ERROR):CONSOLE.*", ran.stderr)
    return ran.stdout, console


def read_png(path):
    """Pixels of a PNG of 8 bits, shape (height, width, 3)."""
    with open(path, "rb") as file:
        data = file.read()
    place, packed, head = 8, b"", None
    while place < len(data):
        size, = struct.unpack(">I", data[place:place + 4])
        kind, body = data[place + 4:place + 8], data[place + 8:place + 8 + size]
        head = struct.unpack(">IIBBBBB", body) if kind == b"IHDR" else head
        packed += body if kind == b"IDAT" else b""
        place += size + 12
    width, height, _, colour = head[:4]
    channels = {2: 3, 6: 4}[colour]
    rows = np.frombuffer(zlib.decompress(packed), dtype=np.uint8).reshape(height, 1 + width * channels)
    image = np.zeros((height + 1, width + 1, channels), dtype=np.int64)
    for y in range(height):
        image[y + 1, 1:] = unfiltered(rows[y, 0], rows[y, 1:].reshape(width, channels).astype(np.int64), image[y])
    return image[1:, 1:, :3]


def unfiltered(kind, line, above):
    """A line of a PNG; `above` has a pixel of zeros before its first."""
    if kind == 0:
        return line
    if kind == 2:
        return (line + above[1:]) % 256
    found = np.zeros_like(above)
    for x in range(len(line)):
        left, up, corner = found[x], above[x + 1], above[x]
        if kind == 1:
            guess = left
        elif kind == 3:
            guess = (left + up) // 2
        else:
            p = left + up - corner
            distances = np.stack([np.abs(p - left), np.abs(p - up), np.abs(p - corner)])
            guess = np.choose(np.argmin(distances, axis=0), (left, up, corner))
        found[x + 1] = (line[x] + guess) % 256
    return found[1:]


def is_like(image, colour, near=40):
    """Pixels of a colour in any light: those whose hue is near."""
    wanted = np.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)], dtype=float)
    length = np.linalg.norm(image, axis=-1)
    along = image @ wanted / np.maximum(length, 1) / np.linalg.norm(wanted)
    return (along > np.cos(near / 300)) & (length > 60) & (np.ptp(image, axis=-1) > 30)


def held(page):
    """What a page holds: the motion, and its rows as columns."""
    motion = json.loads(re.search(r"<script>const motion = (.*);\n", page.text)[1])
    rows = {name: np.frombuffer(base64.b64decode(text), dtype="<f4").astype(float) for name, text in motion["rows"].items()}
    return motion, rows


def turns(rows):
    """Angles between the attitudes of two frames, rad."""
    q = np.stack([rows[f"q{i}"] for i in range(4)], axis=-1)
    q /= np.linalg.norm(q, axis=1)[:, None]
    return 4 * np.arcsin(np.linalg.norm(q[1:] - np.sign(np.sum(q[1:] * q[:-1], axis=1))[:, None] * q[:-1], axis=1) / 2)


def scene(name):
    return os.path.join(SCENES, f"{name}.nml")


class PageTest(unittest.TestCase):
    """What pages hold."""

    def test_a_page_needs_nothing_but_itself(self):
        page = nutate.view(BOX, None, "integrator.end_time=2")
        self.assertNotRegex(re.sub(r"<script>.*?</script>", "", page.text, flags=re.DOTALL), r"https?://")
        self.assertNotIn("<script src", page.text)
        self.assertIn("Free box on its intermediate axis", page.text)
        self.assertIn("<iframe srcdoc=", page._repr_html_())
        self.assertIn("MB", repr(page))
        self.assertLess(len(page.text), 200000)

    def test_texts_of_a_scene_cannot_become_marks_of_the_page(self):
        title, name = "</script><script>alert(1)</script> & <!--", "a</script><b>"
        page = nutate.view(nutate.Scene(text=f"""&scene title = '{title}' / &body inertia = 5, 20, 17 /
            &initial angular_velocity = 0.1, 0, 10 / &event name = '{name}', when = 'omega3', crosses = 0 /
            &integrator accuracy = 1e-6, end_time = 2 /"""))
        self.assertEqual([event["name"] for event in held(page)[0]["events"]], [name])
        data = re.search(r"<script>const motion = (.*);\n", page.text)[1]
        self.assertNotRegex(data, "[<>&]")
        self.assertEqual(page.text.count("<script>"), 1)
        self.assertIn(html.escape(title), page.text)

    def test_frames_are_near_however_few_rows_are_written(self):
        for name, *overrides in (("thrown_book",), ("separation",), ("dual_spin",), ("spring_gyroscope",), ("slowing_plate",),
                                 ("box", "output.every=1000"), ("compass", "output.times=1,50"), ("intermediate_axis",),
                                 ("gyrostat", "integrator.method=taylor", "-integrator.time_step",
                                  "integrator.local_tolerance=1e-6"),
                                 ("box", "integrator.time_step=-0.01", "integrator.end_time=-2")):
            with self.subTest(name, overrides=overrides):
                motion, rows = held(nutate.view(scene(name), None, *overrides))
                self.assertLess(np.max(turns(rows)), 0.3)
                end = nutate.Scene(scene(name), *overrides).plan[1]
                if motion["overview"] is None:
                    self.assertAlmostEqual(rows["t"][-1] / end, 1, places=6)
        solution = nutate.solve(nutate.System(moments=(5, 20, 17)), omega0=(0.1, 0, 10), t_span=(0, 6), t_eval=(0, 6))
        self.assertLess(np.max(turns(held(solution.view())[1])), 0.3)

    def test_frames_show_the_motion_itself(self):
        _, rows = held(nutate.view(BOX, None, "output.every=500"))
        exact = nutate.solve(nutate.Scene(BOX), accuracy=1e-8)
        q = exact.sol(np.minimum(rows["t"], exact.t[-1]))[0]
        shown = np.stack([rows[f"q{i}"] for i in range(4)], axis=-1)
        early = rows["t"] < 2
        self.assertLess(np.max(1 - np.abs(np.sum(q * shown, axis=1))[early]), 1e-3)

    def test_of_a_long_motion_the_beginning_is_animated(self):
        page = nutate.view(BOX, None, "integrator.end_time=400")
        motion, rows = held(page)
        self.assertLess(np.max(turns(rows)), 0.3)
        self.assertLessEqual(len(rows["t"]), 8001)
        self.assertLess(rows["t"][-1], 399)
        self.assertRegex(page.text, r"Of 400 s the animation shows \d+(\.\d+)? s, from t = 0 s on")
        self.assertAlmostEqual(np.frombuffer(base64.b64decode(motion["overview"]["t"]), dtype="<f4")[-1], 400, places=3)

    def test_the_animation_begins_anywhere(self):
        for source in (BOX, nutate.solve(nutate.Scene(BOX), t_span=(0, 400), accuracy=1e-6)):
            overrides = ("integrator.end_time=400",) if source is BOX else ()
            page = nutate.view(source, None, *overrides, start=150.0)
            motion, rows = held(page)
            self.assertAlmostEqual(rows["t"][0], 150, places=4)
            self.assertLess(np.max(turns(rows)), 0.3)
            self.assertIn("from t = 150 s on", page.text)
            self.assertRaises(nutate.NutateValueError, nutate.view, source, None, *overrides, start=500.0)
        history = nutate.run(BOX)
        _, rows = held(nutate.view(history, nutate.System(scene=nutate.Scene(BOX)), start=15))
        self.assertAlmostEqual(rows["t"][0], 15, places=5)

    def test_the_angles_of_axis_3_are_drawn(self):
        motion, rows = held(nutate.view(os.path.join(SCENES, "fast_top.nml"), None, "integrator.end_time=0.2"))
        exact = nutate.euler_from_quat(np.stack([rows[f"q{i}"] for i in range(4)], axis=-1))
        np.testing.assert_allclose(np.stack([rows["phi"], rows["theta"]], axis=-1), exact[:, :2], atol=1e-4)
        self.assertEqual([panel["label"] for panel in motion["panels"]][1], "Euler angles (rad)")

    def test_an_assumed_shape_is_named(self):
        moved = {"omega0": (0.1, 0, 3), "t_span": (0, 1)}
        for moments, name in (((2, 2, 2), "sphere"), ((1, 1, 1.9), "disc"), ((2, 0.3, 2), "cylinder"), ((5, 20, 17), "box")):
            page = nutate.solve(nutate.System(moments=moments), **moved).view()
            self.assertIn(f"The shape is assumed: a {name} with the moments of inertia", page.text)
        self.assertNotIn("assumed", nutate.view(BOX).text.split("<script>")[0])

    def test_rows_that_are_far_apart_are_not_passed_off_as_a_motion(self):
        box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
        stepper = nutate.Stepper(box, time_step=0.01)
        stepper.set_state((1, 0, 0, 0), (0.1, 0, 10))
        rows = stepper.run(100)
        self.assertNotIn("is not known", nutate.view(rows, box).text)
        self.assertIn("is not known", nutate.view({name: values[::50] for name, values in rows.items()}, box).text)

    def test_what_is_followed(self):
        for name, path in (("heavy_top", "the centre of mass"), ("slowing_plate", "the symmetry axis"), ("box", "axis 3"),
                           ("thrown_book", "axis 2"), ("gyrocompass", "axis 2")):
            self.assertEqual(held(nutate.view(scene(name), None, "integrator.end_time=2"))[0]["path"]["name"], path, name)

    def test_the_momentum_of_a_rotor_is_shown_with_columns_that_lack_it(self):
        gyrostat = nutate.System(moments=(5, 20, 17))
        gyrostat.add("rotor", momentum=(0, 0, 60))
        solution = nutate.solve(gyrostat, omega0=(0.1, 0, 10), t_span=(0, 1))
        rows = {name: values for name, values in solution.columns.items() if re.fullmatch(r"t|q\d|omega\d", name)}
        _, shown = held(nutate.view(rows, gyrostat))
        for name in ("l_x", "l_y", "l_z"):
            np.testing.assert_allclose(shown[name], solution.columns[name], atol=1e-4)

    def test_the_momentum_of_columns_that_lack_it(self):
        """The momentum follows from L or from the inertia at the time of a row; with wheels it is unknown."""
        wheels, growing = nutate.System(moments=(5, 20, 17)), nutate.System(text="&body inertia = 5, 20, 17 / &inertia_rate tensor = 1, 2, 1 /")
        wheels.add_wheel((0, 0, 1), 0.5, 10, torque=0.5)
        fluid = nutate.System(moments=(5, 20, 17))
        fluid.add("inner_sphere", inertia=0.5, damping=1.0, angular_velocity=(0, 0, 3))
        for body, lacks in ((wheels, True), (fluid, True), (growing, False)):
            columns = nutate.solve(body, omega0=(0.1, 0, 2), t_span=(0, 2)).columns
            few = {name: values for name, values in columns.items() if re.fullmatch(r"t|q\d|omega\d", name)}
            q, momentum = (np.stack([columns[name] for name in names], axis=-1)
                           for names in (("q0", "q1", "q2", "q3"), ("l_x", "l_y", "l_z")))
            rows = [{**few, **dict(zip(("L1", "L2", "L3"), nutate.rotate_to_body(q, momentum).T))}]
            if lacks:
                with self.assertRaisesRegex(nutate.NutateValueError, "the rows lack the angular momentum.*expected the columns of"):
                    nutate.view(few, body)
            else:
                rows.append(few)
            for each in rows:
                _, shown = held(nutate.view(each, body))
                for name in ("l_x", "l_y", "l_z"):
                    np.testing.assert_allclose(shown[name], columns[name], atol=1e-4)

    def test_columns_are_checked(self):
        class Twice(dict):
            def __iter__(self):
                return iter([*super().keys(), "omega1"])

        class Degrees(np.ndarray):
            attrs = {"units": "deg/s"}

        body = nutate.System(moments=(5, 20, 17))
        columns = nutate.solve(body, omega0=(0.1, 0, 2), t_span=(0, 2)).columns
        for use in (lambda rows: nutate.view(rows, body), lambda rows: nutate.plot(rows, "omega1")):
            with self.assertRaisesRegex(nutate.NutateValueError, "there are two columns 'omega1'"):
                use(Twice(columns))
            with self.assertRaisesRegex(nutate.NutateValueError, "column omega1 has the unit 'deg/s'"):
                use({**columns, "omega1": columns["omega1"].view(Degrees)})

    def test_real_time_is_kept_where_it_can_be_watched(self):
        self.assertEqual(held(nutate.view(BOX))[0]["factor"], 1)
        self.assertLess(held(nutate.view(scene("heavy_top")))[0]["factor"], 0.1)
        self.assertGreater(held(nutate.view(scene("earth_pointing")))[0]["factor"], 100)
        for page in (nutate.view(BOX), nutate.view(scene("heavy_top"))):
            motion = held(page)[0]
            self.assertIn(1, motion["factors"])
            self.assertIn(motion["factor"], motion["factors"])

    def test_events_wheels_and_orbits_are_shown(self):
        motion, _ = held(nutate.view(scene("intermediate_axis"), None, "integrator.end_time=2"))
        self.assertEqual([event["name"] for event in motion["events"]], ["flip", "turned over"])
        self.assertAlmostEqual(motion["events"][0]["t"], 0.96640948, places=5)
        motion, rows = held(nutate.view(scene("dual_spin"), None, "integrator.end_time=50"))
        self.assertEqual(motion["wheels"], [[1, 0, 0]])
        self.assertGreater(rows["wheel1_speed"][-1], 9)
        motion, rows = held(nutate.view(scene("earth_pointing")))
        self.assertIn("LVLH angles (rad)", [panel["label"] for panel in motion["panels"]])
        self.assertIn("lvlh_q0", rows)
        wheels = nutate.System(moments=(5, 20, 17))
        wheels.add_wheel((0, 0, 2), 0.01)
        wheels.add("wheel", axis=(0, 1, 0), inertia=0.01)
        self.assertEqual([axis.tolist() for axis in shapes.wheel_axes(wheels)], [[0, 0, 2], [0, 1, 0]])
        self.assertEqual(len(held(nutate.solve(wheels, omega0=(0.1, 0, 1), t_span=(0, 1)).view())[0]["wheels"]), 2)

    def test_whatever_moved_can_be_shown(self):
        box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
        solution = nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 2))
        stepper = nutate.Stepper(box, time_step=0.01)
        stepper.set_state((1, 0, 0, 0), (0.1, 0, 10))
        for page in (nutate.view(solution), solution.view(title="<&>"), nutate.view(nutate.Scene(BOX)),
                     nutate.view(stepper.run(100), box), nutate.view(nutate.solve(box, omega0=(0, 0, 0), t_span=(0, 1)))):
            self.assertGreater(len(held(page)[1]["t"]), 99)
        self.assertIn("&lt;&amp;&gt;", solution.view(title="<&>").text)
        for wrong in (lambda: nutate.view(stepper.run(100)), lambda: nutate.view({"t": np.arange(3.0)}, box)):
            with self.assertRaises(nutate.NutateError):
                wrong()

    def test_the_program_writes_one(self):
        path = os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"]
        with tempfile.TemporaryDirectory() as folder:
            def run(*arguments):
                return subprocess.run([os.environ["NUTATE"], "view", *arguments], cwd=folder, capture_output=True, text=True,
                                      env={**os.environ, "PATH": path})

            if subprocess.run(["python3", "-c", "import nutate"], env={**os.environ, "PATH": path},
                              capture_output=True).returncode:
                self.skipTest("this Python is not called python3")
            self.assertEqual(run(BOX).returncode, 0)
            ran = run(os.path.join(SCENES, "heavy_top.nml"), "--output", "it's.html", "--set", "integrator.end_time=0.1",
                      "--unset=scene.title")
            self.assertEqual((ran.returncode, ran.stdout, ran.stderr), (0, "", ""))
            self.assertEqual(sorted(os.listdir(folder)), ["box.html", "it's.html"])
            for status, says, arguments in ((2, "absent.nml", ["absent.nml"]), (2, "--set: unknown group 'boddy'", [BOX, "--set", "boddy.mass=1"]),
                                            (2, "--unset: unknown key 'foo'", [BOX, "--unset", "body.foo"]),
                                            (4, "cannot write no/a.html", [BOX, "--output", "no/a.html"])):
                ran = run(*arguments)
                self.assertEqual((ran.returncode, ran.stderr.count("\n")), (status, 1), ran.stderr)
                self.assertIn(says, ran.stderr)
            page = subprocess.run([os.environ["NUTATE"], "view", BOX, "--output", "-"], cwd=folder, capture_output=True,
                                  env={**os.environ, "PATH": path, "LC_ALL": "C", "PYTHONIOENCODING": "ascii"}).stdout
            with open(os.path.join(folder, "box.html"), "rb") as file:
                self.assertEqual(page, file.read())

    def test_a_page_goes_where_its_name_leads(self):
        page = nutate.view(BOX, None, "integrator.end_time=1")
        with tempfile.TemporaryDirectory() as folder:
            link, target, pipe, long = (os.path.join(folder, name) for name in ("link", "real", "pipe", "é" * 125 + ".html"))
            os.symlink("real", link)
            os.mkfifo(pipe)
            for path in (link, long, target):
                page.save(path)
                with open(path, encoding="utf-8") as file:
                    self.assertEqual(file.read(), page.text)
            self.assertEqual(os.readlink(link), "real")
            with subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE) as reader:
                page.save(pipe)
                self.assertEqual(reader.communicate()[0].decode(), page.text)
            before = sorted(os.listdir(folder))
            os.mkdir(os.path.join(folder, "kept"))
            with self.assertRaises(IsADirectoryError):
                page.save(os.path.join(folder, "kept"))
            with self.assertRaises(OSError):
                page.save("/dev/full")
            self.assertEqual(sorted(os.listdir(folder)), sorted([*before, "kept"]))


class ShapeTest(unittest.TestCase):
    """What bodies look like."""

    def test_shapes_are_those_that_were_given(self):
        expected = {"box": 4 * np.sqrt(21) / 8, "precessing_top": None, "gravity_gradient_satellite": None}
        for name, size in expected.items():
            scene = nutate.Scene(os.path.join(SCENES, f"{name}.nml"))
            surface, assumed = shapes.surface_of(nutate.System(scene=scene), scene)
            self.assertTrue(np.all(surface.corners < len(surface.points)))
            self.assertEqual(len(surface.colours), len(surface.corners))
            if size:
                self.assertAlmostEqual(surface.size, size)
        scene = nutate.Scene(BOX, "body.shape=cylinder", "body.size=1,3")
        surface, assumed = shapes.surface_of(nutate.System(scene=scene), scene)
        self.assertAlmostEqual(np.ptp(surface.points[:, 2]), 3)
        self.assertAlmostEqual(np.linalg.norm(surface.points[:, :2], axis=1).max(), 1)
        cone, assumed = shapes.surface_of(nutate.System(shape="cone", size=(1, 4), mass=1, center_of_mass=(0, 0, 3)))
        self.assertAlmostEqual(cone.points[:, 2].min(), 0)

    def test_symmetric_bodies_are_spheres_discs_and_cylinders(self):
        for shape, size in (("cylinder", (1.0, 0.2)), ("cylinder", (0.3, 4.0))):
            given = nutate.System(shape=shape, size=size, mass=3)
            for axes in (np.eye(3), nutate.matrix_from_quat((0.5, 0.5, 0.5, 0.5))):
                tensor = nutate.System(tensor=axes @ given.inertia @ axes.T, mass=3, center_of_mass=(0, 0, 0))
                surface, _ = shapes.surface_of(tensor)
                along = surface.points @ axes[:, 2]
                self.assertAlmostEqual(np.ptp(along), size[1])
                self.assertAlmostEqual(np.linalg.norm(surface.points - np.outer(along, axes[:, 2]), axis=1).max(), size[0])
        ball, name = shapes.surface_of(nutate.System(moments=(0.4, 0.4, 0.4), mass=1))
        self.assertEqual((name, round(ball.size, 9)), ("sphere", 1.0))

    def test_other_bodies_are_the_box_of_their_inertia(self):
        edges, q = np.array([4.0, 1.0, 2.0]), np.array([0.5, 0.5, 0.5, 0.5])
        box = nutate.System(shape="box", size=edges, mass=12)
        rotation = nutate.matrix_from_quat(q)
        turned = nutate.System(tensor=rotation @ box.inertia @ rotation.T, mass=12, center_of_mass=(0, 0, 0))
        for system in (turned, nutate.System(moments=(5, 20, 17), mass=12)):
            self.assertAlmostEqual(shapes.surface_of(system)[0].size, np.linalg.norm(edges) / 2)
        plate, assumed = shapes.surface_of(nutate.System(moments=(1, 1, 2)))
        self.assertGreater(np.ptp(plate.points[:, 2]), 0)


class BrowserTest(unittest.TestCase):
    """What a browser without a network shows."""

    @classmethod
    def setUpClass(cls):
        cls.browser = find_browser()
        if cls.browser is None:
            raise unittest.SkipTest("there is no Chromium")

    def test_a_body_is_seen(self):
        box = nutate.System(shape="box", size=(4, 1, 2), mass=12)
        page = nutate.view(nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 6)), begin=0.4)
        with tempfile.TemporaryDirectory() as folder:
            path, picture = os.path.join(folder, "box.html"), os.path.join(folder, "box.png")
            page.save(path)
            _, console = browse(self.browser, path, "--virtual-time-budget=20000", f"--screenshot={picture}")
            self.assertEqual(console, [])
            image = read_png(picture)
            kept = os.environ.get("NUTATE_VIEW_PICTURE")
            if kept:
                shutil.copy(picture, kept)
        body = image[60:420, :600]
        self.assertGreater(sum(np.count_nonzero(is_like(body, colour)) for colour in shapes.FACES), 3000)
        self.assertGreater(np.count_nonzero(is_like(image[60:420, 600:], "#b9d3e8")), 3000)
        self.assertGreater(np.count_nonzero(is_like(image[440:], "#d55e00")), 100)

    def test_a_ball_on_a_long_wire_is_seen(self):
        pendulum = nutate.Scene(text="&body shape = 'sphere', size = 0.1, mass = 28.0, center_of_mass = 0.0, 0.0, -67.0 /\n"
                                "&gravity acceleration = 0.0, 0.0, -9.81 /\n&initial axis = 1.0, 0.0, 0.0, angle = 0.1, "
                                "angular_velocity = 0.0, 0.0, 0.0 /\n&integrator order = 4, time_step = 0.1, end_time = 20.0 /\n")
        with tempfile.TemporaryDirectory() as folder:
            path, picture = os.path.join(folder, "ball.html"), os.path.join(folder, "ball.png")
            nutate.view(pendulum).save(path)
            _, console = browse(self.browser, path, "--virtual-time-budget=20000", f"--screenshot={picture}")
            self.assertEqual(console, [])
            body = read_png(picture)[60:420, :600]
        self.assertGreater(sum(np.count_nonzero(is_like(body, colour)) for colour in shapes.SECTORS[:3]), 500)

    def test_it_plays(self):
        box = nutate.System(moments=(5, 20, 17), mass=12)
        page = nutate.view(nutate.solve(box, omega0=(0.1, 0, 10), t_span=(0, 6)), play=True)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "box.html")
            page.save(path)
            # Whether a frame comes before the page is written out is a race that the first try may lose.
            for budget in range(8000, 48000, 4000):
                text, console = browse(self.browser, path, f"--virtual-time-budget={budget}", "--dump-dom")
                self.assertEqual(console, [])
                shown = re.search(r'id="nutate-time">t = ([-.e\d]+) s<', text)
                if shown and float(shown.group(1)) != 0.0:
                    break
        self.assertIn('data-nutate="drawn"', text)
        self.assertNotEqual(float(shown.group(1)), 0.0)


if __name__ == "__main__":
    unittest.main()
