"""Every block of Python in the book and in README runs, from the first to the last."""

import pathlib
import re
import warnings

import granum
import pytest

ROOT = pathlib.Path(__file__).parent.parent.parent
PAGES = ["docs/src/python.md", "README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_run(page: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("sklearn")
    pytest.importorskip("matplotlib").use("Agg")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), flags=re.S)
    assert blocks
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", granum.RunWarning)
        for block in blocks:
            exec(compile(block, page, "exec"), names)


def test_the_docstrings_run() -> None:
    import doctest

    for module in [granum, granum.surrogates]:
        found = doctest.testmod(module)
        assert found.failed == 0 and found.attempted > 1, module
