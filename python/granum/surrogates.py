"""Surrogates of tests that are ready to use.

>>> import granum
>>> sand = granum.surrogates.load("sand")
>>> sand.name
'sand'
"""

from ._granum import Family, families

__all__ = ["Family", "families", "load"]


def load(name: str, path: str | None = None) -> Family:
    """The family of tests of that name with its fitted surrogate, along a path, or its first one; `families()` lists both."""
    return Family(name, path)
