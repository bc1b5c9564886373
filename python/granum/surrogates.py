"""Surrogates of tests: ready to use, or fitted to a data set.

>>> import granum
>>> sand = granum.surrogates.load("sand")
>>> sand.name
'sand'
"""

from ._granum import Family, Surrogate, families, fit, methods

__all__ = ["Family", "Surrogate", "families", "fit", "load", "methods", "read"]

read = Surrogate.read
"""The surrogate of a file that `Surrogate.write` or `granum train` wrote."""


def load(name: str, path: str | None = None) -> Family:
    """The family of tests of that name with its fitted surrogate, along a path, or its first one; `families()` lists both."""
    return Family(name, path)
