"""What `help` and notebooks show is what the stubs say."""

import inspect

import copy_docstrings
import granum._granum
import pytest


@pytest.mark.parametrize("owner, name, text", list(copy_docstrings.docstrings()))
def test_the_compiled_docstrings_are_those_of_the_stubs(owner: str | None, name: str, text: str) -> None:
    of = granum._granum if owner is None else getattr(granum._granum, owner)
    shown = inspect.getdoc(getattr(of, name) if name else of)
    assert shown == inspect.cleandoc(text), "python python/tools/copy_docstrings.py copies them"
