"""The notebooks run, and give the texts that are kept in their files."""

import pytest
import run_notebooks


@pytest.mark.parametrize("name", run_notebooks.names())
def test_a_notebook_gives_what_its_file_keeps(name: str) -> None:
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    pytest.importorskip("sklearn")
    assert run_notebooks.check(name) == []


def test_there_are_six_of_them() -> None:
    assert len(run_notebooks.names()) == 7
