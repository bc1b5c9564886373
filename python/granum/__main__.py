"""The command-line program: `python -m granum` and the script `granum`."""

import sys

from ._granum import _program
from ._script import script


def main() -> int:
    """Runs the program with the arguments of this process and returns its exit status."""
    return _program(["granum", *sys.argv[1:]], script())


if __name__ == "__main__":
    sys.exit(main())
