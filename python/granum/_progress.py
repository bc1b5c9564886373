"""A line of progress for a terminal or a notebook."""

from __future__ import annotations

import sys
from typing import Any, TextIO


class ProgressLine:
    """Shows the progress of a run in one line: `granum.run(case, on_progress=granum.ProgressLine())`.

    `file` is where it is written, by default standard error, which a notebook shows below its cell.
    """

    def __init__(self, file: TextIO | None = None) -> None:
        self._file = sys.stderr if file is None else file
        self._width = 0

    def __call__(self, progress: dict[str, Any]) -> None:
        """Writes the line for a state of the work."""
        done, fraction = progress["done"], progress["fraction"]
        parts = [str(progress["activity"])]
        if progress["part"]:
            parts.append(str(progress["part"]))
        parts.append(f"{done} {progress['counted']}")
        if fraction is not None:
            parts.append(f"{100 * fraction:.0f} %")
        line = "  ".join(parts)
        self._file.write("\r" + line.ljust(self._width))
        self._file.flush()
        self._width = len(line)
