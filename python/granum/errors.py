"""The exceptions and warnings of granum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Mistake(NamedTuple):
    """One mistake in a case or a file."""

    message: str
    """What is wrong."""
    key: str | None = None
    """The key, such as `grains.count`, where the mistake is at one."""
    value: str | None = None
    """The value as it was given."""
    remedy: str | None = None
    """What would be right, where there is a suggestion."""
    file: str | None = None
    """The file, where the case comes from one."""
    line: int | None = None
    """The line of the file, from 1."""
    column: int | None = None
    """The column in the line, from 1."""


class Error(Exception):
    """Any error of granum."""


class CaseError(Error, ValueError):
    """A value that a case, a path or a function cannot take. All mistakes of a case are reported at once."""

    def __init__(self, message: str, mistakes: Sequence[Mistake] = ()) -> None:
        super().__init__(message)
        self.message = message
        """All mistakes with what would be right."""
        self.mistakes = tuple(mistakes)
        """Each mistake."""

    def __reduce__(self) -> tuple[type[CaseError], tuple[str, tuple[Mistake, ...]]]:
        return type(self), (self.message, self.mistakes)

    @property
    def key(self) -> str | None:
        """The key of the first mistake."""
        return self.mistakes[0].key if self.mistakes else None

    @property
    def value(self) -> str | None:
        """The value of the first mistake."""
        return self.mistakes[0].value if self.mistakes else None

    @property
    def remedy(self) -> str | None:
        """What would be right instead of the first mistake."""
        return self.mistakes[0].remedy if self.mistakes else None


class FileError(Error):
    """A file or folder that cannot be read or written, is damaged, exists already, or is in use by another process."""


class RunError(Error):
    """A preparation or a test that failed; the message has its advice."""


class InternalError(Error, RuntimeError):
    """A mistake of granum itself; please report it."""


class RunWarning(UserWarning):
    """Something that a user should know about a run, and that does not end it."""
