"""What a script of a finite-element program needs of granum's library: names for points, files of their states, messages.

    from granum_points import Library
    library = Library("target/release/libgranum_c.so", "granum-materials.toml")
"""
import ctypes
import os
import re


class Library:
    """The shared library; the finite-element program loads the same file, and with it the same states."""

    def __init__(self, path, configuration):
        self.path = os.path.abspath(path)
        self._library = ctypes.CDLL(self.path)
        self._library.granum_last_error.restype = ctypes.c_char_p
        self._library.granum_points_message.restype = ctypes.c_char_p
        self._call("granum_points_open", configuration)

    def _call(self, function, path):
        if getattr(self._library, function)(os.fspath(path).encode()) != 0:
            raise RuntimeError(self._library.granum_last_error().decode())

    def save(self, path):
        """Writes the states of all points; a host that writes a restart file calls it beside."""
        self._call("granum_points_save", path)

    def load(self, path):
        """Reads the states of all points, in place of those that there are."""
        self._call("granum_points_load", path)

    @property
    def message(self):
        """Why the library last answered with NaN."""
        return self._library.granum_points_message().decode()


def name_points_of_kratos(model_part, number_of_variables=5):
    """Gives each integration point a name of its own in its first state variable, before the first step: 1000 times the element plus the
    place of the point. A UMAT is not told its element in Kratos."""
    import KratosMultiphysics as K

    variable = K.KratosGlobals.GetVariable("STATE_VARIABLES")
    for element in model_part.Elements:
        count = len(element.CalculateOnIntegrationPoints(K.CAUCHY_STRESS_VECTOR, model_part.ProcessInfo))
        values = [K.Vector([1000.0 * element.Id + k + 1.0] + [0.0] * (number_of_variables - 1)) for k in range(count)]
        element.SetValuesOnIntegrationPoints(variable, values, count, model_part.ProcessInfo)


def configuration_with(path, folder, grains):
    """A copy of a configuration in a folder, whose cases have so many grains."""
    with open(path) as file:
        text = file.read()
    for case in re.findall(r'^case = "([^"]+)"', text, re.M):
        with open(os.path.join(os.path.dirname(path), case)) as file:
            changed = re.sub(r"^grains\.count = \d+", f"grains.count = {grains}", file.read(), flags=re.M)
        with open(os.path.join(folder, os.path.basename(case)), "w") as file:
            file.write(changed)
    # A surrogate is read where it lies.
    beside = os.path.abspath(os.path.dirname(path))
    text = re.sub(r'^surrogate = "([^"]+)"', lambda found: f'surrogate = "{os.path.normpath(os.path.join(beside, found[1]))}"', text, flags=re.M)
    copied = os.path.join(folder, "granum-materials.toml")
    with open(copied, "w") as file:
        file.write(text)
    return copied
