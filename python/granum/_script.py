"""The script that starts the program of this package, which a campaign starts for each of its runs."""

from __future__ import annotations

import os

_NAME = "granum.exe" if os.name == "nt" else "granum"
_PACKAGE = os.path.dirname(os.path.abspath(__file__))


def script() -> str | None:
    """The script that was installed with this very package; `None` if it was installed without one. A script of the same name elsewhere may
    be of another version.
    """
    for place in _places():
        if os.path.isfile(place) and os.access(place, os.X_OK):
            return os.path.abspath(place)
    return None


def _places() -> list[str]:
    """Where the installation of this package says that the script is, and where `pip install --target` puts it, which does not say so."""
    from importlib import metadata

    found = []
    for installed in metadata.distributions(name="granum"):
        if os.path.realpath(str(installed.locate_file("granum"))) == os.path.realpath(_PACKAGE):
            found += [str(file.locate()) for file in installed.files or [] if file.name == _NAME]
    return [*found, os.path.join(os.path.dirname(_PACKAGE), "Scripts" if os.name == "nt" else "bin", _NAME)]
