"""The command-line program: `python -m granum` and the script `granum`."""

import os
import sys
import sysconfig

from ._granum import _program


def _script() -> str | None:
    """The script that starts the program, which a campaign starts for each of its runs."""
    name = "granum.exe" if os.name == "nt" else "granum"
    for place in (os.path.dirname(sys.executable), sysconfig.get_path("scripts")):
        path = os.path.join(place, name)
        if os.path.isfile(path):
            return os.path.abspath(path)
    return None


def main() -> int:
    """Runs the program with the arguments of this process and returns its exit status."""
    return _program(["granum", *sys.argv[1:]], _script())


if __name__ == "__main__":
    sys.exit(main())
