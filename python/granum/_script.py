"""The script that starts the program of this package, which a campaign starts for each of its runs."""

from __future__ import annotations

import os
import sys
import sysconfig

_NAME = "granum.exe" if os.name == "nt" else "granum"


def script() -> str | None:
    """The script that was installed with this very package; `None` if it was installed without one."""
    places = [*_recorded(), *(os.path.join(place, _NAME) for place in (os.path.dirname(sys.executable), sysconfig.get_path("scripts")))]
    for place in places:
        if os.path.isfile(place) and os.access(place, os.X_OK):
            return os.path.abspath(place)
    return None


def _recorded() -> list[str]:
    """Where the installation of this package says that the script is: the only place for those with `--user` or `--target`."""
    from importlib import metadata

    here = os.path.dirname(os.path.abspath(__file__))
    found = []
    for installed in metadata.distributions(name="granum"):
        if os.path.realpath(str(installed.locate_file("granum"))) == os.path.realpath(here):
            found += [str(file.locate()) for file in installed.files or [] if file.name == _NAME]
    return found
