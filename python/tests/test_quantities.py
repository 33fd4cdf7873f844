"""Numbers with a unit, where plain ones are expected."""
import os
import unittest

import numpy as np

import nutate
from nutate._library import is_expected
from nutate._units import UNITS
from nutate.sweeps import columns_of
from test_nutate import BOX, make_box


class QuantityTest(unittest.TestCase):
    def refuse(self, pattern, use, value):
        with self.assertRaisesRegex(nutate.NutateValueError, pattern):
            use(value)

    def test_numbers_with_units(self):
        """As those of unyt and of pint, which `float` and lists turn into numbers."""
        class Quantity(np.ndarray):
            units = "ms"

        class Measure:
            units = "deg"

            def __float__(self):
                return 1.0

        box, scene = nutate.System(moments=(5, 20, 17)), nutate.Scene(BOX)
        wheels = nutate.System(moments=(5, 20, 17))
        wheels.add_wheel((0, 0, 1), 0.01)
        orbit = nutate.System(moments=(5, 20, 17))
        orbit.add("orbit", altitude=500e3)
        solution = nutate.solve(scene)
        wheel = {name: lambda one, name=name: box.add_wheel(**{"axis": (0, 0, 1), "inertia": 1, "torque": 1, name: one})
                 for name in ("inertia", "speed", "friction", "torque_limit", "speed_limit", "torque", "frequency", "phase", "start", "stop")}
        q, l, still = np.eye(4)[:1].copy(), np.ones((1, 3)), np.zeros((1, 3))
        uses = {
            **wheel,
            "mass": lambda one: nutate.System(shape="box", size=(4, 1, 2), mass=one),
            "density": lambda one: nutate.System(shape="box", size=(4, 1, 2), density=one),
            "mass of moments": lambda one: nutate.System(moments=(5, 20, 17), mass=one),
            "mass of tensor": lambda one: nutate.System(tensor=(5, 20, 17, 0, 0, 0), mass=one),
            "time_step": lambda one: make_box().set(time_step=one),
            "accuracy": lambda one: nutate.Stepper(box, accuracy=one),
            "max_step": lambda one: nutate.solve(box, omega0=(0, 0, 1), t_span=(0, 1), max_step=one),
            "time_step of solve": lambda one: nutate.solve(box, omega0=(0, 0, 1), t_span=(0, 1), time_step=one),
            "t": lambda one: make_box().set_state((1, 0, 0, 0), (0, 0, 1), t=one),
            "t of set_canonical": lambda one: make_box().set_canonical((1, 0, 0, 0), (0, 0, 0, 1), t=one),
            "dt": lambda one: make_box().step(one),
            "dt of steps": lambda one: make_box().steps(one, 3),
            "end_time": lambda one: make_box().run_to(one),
            "interval": lambda one: make_box().run_to(0.1, interval=one),
            "t of state_at": lambda one: make_box().state_at(one),
            "crosses": lambda one: make_box().add_event("omega3", crosses=one),
            "modulo": lambda one: make_box().add_event("psi", crosses=0, modulo=one),
            "torque of a motor": lambda one: nutate.Stepper(wheels).set_motor(0, one),
            "start of a force": lambda one: box.add_force((0, 0, 1), (1, 0, 0), start=one),
            "epoch_angle": lambda one: orbit.add_earth_field(epoch_angle=one),
            "dt of bodies": lambda one: nutate.Bodies(box).step(one, q, l, still),
            "period": lambda one: nutate.linearize(scene, period=one),
            "date": lambda one: nutate.date("2029-04-13", "TT", one),
            "speed of an animation": lambda one: solution.to_gltf(os.devnull, speed=one),
            "error": lambda one: solution.to_gltf(os.devnull, error=one),
            "start of an animation": lambda one: solution.view(start=one),
            "key": lambda one: box.add("damping", coefficient=(0, 0, one)),
            "moments": lambda one: nutate.System(moments=(1, one, 1)),
            "tensor": lambda one: nutate.System(tensor=[[one, 0, 0], [0, 1, 0], [0, 0, 1]]),
            "omega0": lambda one: nutate.solve(box, omega0=[0, 0, one], t_span=(0, 1)),
            "t_span": lambda one: nutate.solve(box, omega0=(0, 0, 1), t_span=(0, one)),
            "object": lambda one: nutate.solve(box, omega0=(0, 0, 1), t_span=np.array([0, one], dtype=object)),
            "column": lambda one: nutate.sweep(scene, table={"integrator.end_time": [0.1, one]}),
            "weights": lambda one: make_box().add_event(["omega1", "omega3"], crosses=0, weights=[1, one]),
        }
        for name, use in uses.items():
            for quantity in (np.array(1.0).view(Quantity), Measure()):
                with self.subTest(use=name, quantity=type(quantity).__name__):
                    self.refuse("has a unit", use, quantity)
        for kind, one in (("complex", np.complex128(1 + 1j)), ("calendar", np.timedelta64(1, "ns")), ("masked", np.ma.masked)):
            for use in (uses["t"], uses["time_step"], uses["omega0"]):
                self.refuse(kind + " values", use, one)

    def test_values_that_are_no_numbers(self):
        stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)))
        self.refuse("^dt is '0.1 s' \\(expected a number\\)", stepper.step, "0.1 s")
        self.refuse("^dt is 1000.*0 \\(expected a number\\)", stepper.step, 10**400)
        self.refuse("^t is b'x' ", stepper.state_at, b"x")
        self.refuse("^moments is .*expected numbers", lambda moments: nutate.System(moments=moments), (10**400, 1, 1))
        self.refuse("^omega is .*expected numbers", lambda omega: stepper.set_state((1, 0, 0, 0), omega), [10**400, 0, 0])

    def test_integers_that_c_cannot_hold(self):
        """ctypes would cut off the digits above 2**32 or 2**64 and go on with what is left."""
        body = nutate.System(moments=(5, 20, 17))
        stepper, bodies = nutate.Stepper(body, time_step=0.1), nutate.Bodies(body)
        q, l = np.tile([1.0, 0, 0, 0], (2, 1)), np.ones((2, 3))
        scene = nutate.Scene(text="&body inertia = 5, 20, 17 / &initial angular_velocity = 1, 2, 3 / &integrator time_step = 0.1, end_time = 1 / "
                                  "&ensemble members = 3 / &vary key = 'initial.angular_velocity.1', distribution = 'uniform', low = 1, high = 2 /")
        for more in (2**32, 2**64, 10**5000):
            if more > 2**32:
                self.refuse("^n is .*expected 0 to", lambda n: stepper.steps(0.1, n), more + 3)
                self.refuse("^n is .*expected 0 to", stepper.run, more + 3)
                self.refuse("^every is .*expected 1 to", lambda n: stepper.run(3, every=n), more + 1)
                self.refuse("^every is .*expected 1 to", lambda n: stepper.run_to(3, every=n), more + 1)
            self.refuse("^threads is .*expected 0 to", lambda n: nutate.Bodies(body, threads=n), more + 1)
            self.refuse("^threads is .*expected 1 to", lambda n: nutate.sweep(scene, threads=n), more + 1)
        for kind in (np.int64, np.uint64):
            with self.assertRaisesRegex(nutate.NutateError, "1 of 2 bodies"):
                bodies.drift(0.1, q, l, np.array([0, 2**32], kind))
            self.assertEqual(bodies.failed.tolist(), [1])
        for use in (lambda n: stepper.set(order=n), lambda n: body.add("torque", body=[n, 0, 0]), stepper.step, lambda n: nutate.System(moments=(n, 1, 1))):
            self.refuse("is too large to be written|expected numbers", use, 10**5000)
        for use in (lambda n: stepper.steps(0.1, n), stepper.run, lambda n: nutate.Bodies(body, threads=n), lambda n: nutate.sweep_chunk(scene, 1, n)):
            with self.assertRaises((TypeError, nutate.NutateValueError)):
                use(1.7)
        self.assertEqual(stepper.time, 0.0)

    def test_labels_of_components(self):
        """Labels as pandas (columns, or index of a row) and xarray have them."""
        class Table(list):
            columns = None

        class Row(np.ndarray):
            pass

        class Array(np.ndarray):
            dims = ("t", "component")

        def table(labels):
            made = Table([[1.0, 0.0, 0.0, 0.0]])
            made.columns = labels
            return made

        def row(labels):
            made = np.array([1.0, 0.0, 0.0, 0.0]).view(Row)
            made.index = labels
            return made

        def array(labels):
            made = np.array([[1.0, 0.0, 0.0, 0.0]]).view(Array)
            made.coords = {"component": np.array(labels)}
            return made

        stepper = nutate.Stepper(nutate.System(moments=(5, 20, 17)), time_step=0.1)
        for labelled in (table, row, array):
            for labels in (["qx", "qy", "qz", "qw"], ["q1", "q2", "q3", "q0"], ["x", "y", "z", "W"], ["q3", "q2", "q1", "q0"]):
                self.refuse("q has components in the order .*, .* scalar first", nutate.matrix_from_quat, labelled(labels))
            for labels in (["qw", "qx", "qy", "qz"], ["q0", "q1", "q2", "q3"], [0, 1, 2, 3], [1, 2, 3, 0], ["a", "b", "c", "d"], ["q1", "q2", "q3", "q4"]):
                nutate.matrix_from_quat(labelled(labels))
        self.refuse("q has components in the order x, y, z, w", lambda q: stepper.set_state(q, (0, 0, 1)), row("xyzw"))
        self.refuse("xyzw has components in the order w, x, y, z .*scalar last", lambda q: stepper.set_state(xyzw=q, omega=(0, 0, 1)), row("wxyz"))
        for labels in ("xyzw", [0, 1, 2, 3]):
            stepper.set_state(xyzw=row(labels), omega=(0, 0, 1))

    def test_units_in_attributes(self):
        """Attributes as xarray, pandas (by the names of columns) and h5py (bytes) have them."""
        class Labelled:
            def __init__(self, values, units, name=None, columns=None, key="units"):
                self.values, self.attrs, self.name = np.array(values), {key: units}, name
                if columns:
                    self.columns = columns

            def __array__(self, dtype=None, copy=None):
                return np.array(self.values, dtype)

            def __float__(self):
                return float(self.values)

            def __iter__(self):
                return iter(self.values)

        box = nutate.System(moments=(5, 20, 17))
        uses = {"omega0": lambda units, **more: nutate.solve(box, omega0=Labelled((0, 0, 1), units, **more), t_span=(0, 1)),
                "angle": lambda units, **more: nutate.quat_from_axis_angle((0, 0, 1), Labelled(1.0, units, **more)),
                "angles": lambda units, **more: nutate.quat_from_euler(Labelled((0, 0, 1), units, **more)),
                "t": lambda units, **more: nutate.Stepper(box).set_state((1, 0, 0, 0), (0, 0, 1), t=Labelled(1.0, units, **more)),
                "mass": lambda units, **more: nutate.System(moments=(5, 20, 17), mass=Labelled(1.0, units, **more)),
                "moments": lambda units, **more: nutate.System(moments=[1, 1, Labelled(1.0, units, **more)]),
                "coefficient": lambda units, **more: box.add("damping", coefficient=Labelled((1, 1, 1), units, **more)),
                "axis": lambda units, **more: nutate.System(moments=(5, 20, 17)).add_wheel(Labelled((0, 0, 1), units, **more), 0.01)}
        for name, use in uses.items():
            for units in ("deg", "deg/s", "°", "g", "rpm", "minutes", "min", "ms", "mrad", "km", "kN m", "furlong", "10 s", b"deg"):
                with self.subTest(use=name, units=units):
                    self.refuse(f"{name} has the unit '{units if isinstance(units, str) else units.decode()}'.*SI units", use, units)
            for key in ("unit", "Units"):
                self.refuse(f"{name} has the unit 'rpm'", lambda units: use(units, key=key), "rpm")
            self.refuse(f"{name} has the unit 'deg/s'", lambda units: use(units, name="b"), {"a": "s", "b": "deg/s"})
            self.refuse(f"{name} has the unit 'deg/s'", lambda units: use(units, columns=["a", "b"]), {"a": "s", "b": "deg/s"})
            use({"a": "deg", "b": "rad/s"}, name="b")
            use({"a": "deg"}, name="b")
            for units in ("", "1", "rad", "radians", "rad s-1", "rad s^-1", "rad/s", "1/s", "s", "seconds", "kg", "kg m2", "kg*m**2",
                          "N m s", "N·m", "N⋅m", "N m or A m2", "rad/s per unit", "dimensionless", b"rad/s", None, np.array(["rad/s"]),
                          "kilogram * meter ** 2", "meter ** 3 / second ** 2", "C m", "V/m", "W"):
                with self.subTest(use=name, units=units):
                    use(units)
        degrees = {"angles": lambda units: nutate.quat_from_euler(Labelled((0, 0, 90), units), degrees=True),
                   "angle": lambda units: nutate.quat_from_axis_angle((0, 0, 1), Labelled(90.0, units), degrees=True),
                   "rates": lambda units: nutate.omega_from_euler_rates((0, 0, 0), Labelled((0, 0, 90), units), degrees=True),
                   "inclination": lambda units: nutate.System(moments=(5, 20, 17)).add(
                       "orbit", altitude=Labelled(5e5, "m"), inclination=Labelled(90.0, units), degrees=True)}
        # Any unit may belong to what is only rotated, and to an axis; the group of a key in a sweep says what it is in.
        for units in ("km", "nT", "deg/s", "rad"):
            nutate.rotate_to_space((1, 0, 0, 0), Labelled((0, 0, 1), units))
            nutate.rotate_to_body((1, 0, 0, 0), Labelled((0, 0, 1), units))
            nutate.quat_from_axis_angle(Labelled((0, 0, 1), units), 1.0)
        for units in ("deg", "rad"):
            self.assertEqual(columns_of({"initial.euler.1": Labelled((0, 1), units)})[1].tolist(), [[0], [1]])
        self.refuse("has the unit 'rpm'", lambda units: columns_of({"initial.angular_velocity.1": Labelled((0, 1), units)}), "rpm")
        # Columns that the package exports itself.
        for unit, name in UNITS:
            self.assertTrue(is_expected(unit, False), name)
            if "rad" in unit:
                self.assertTrue(is_expected(unit.replace("rad", "deg"), True), name)
        for name, use in degrees.items():
            for units in ("deg", "degrees", "°", "deg/s", "deg s-1", "degrees per second", ""):
                with self.subTest(use=name, units=units):
                    use(units)
            for units in ("rad", "rad/s", "arcmin"):
                self.refuse(f"{name} has the unit '{units}'.*degrees", use, units)


if __name__ == "__main__":
    unittest.main()
