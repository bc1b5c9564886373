"""Reports, figures, and what a notebook shows."""

import pathlib
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser

import granum
import numpy as np
import pytest

LABORATORY = pathlib.Path(__file__).parent.parent.parent / "data" / "lab" / "karlsruhe-fine-sand-drained.csv"


class Open(HTMLParser):
    """The text of a page, after which no element is open."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.attributes: dict[str, str | None] = {}
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "br", "img", "link"):
            self.open.append(tag)
        self.attributes.update(attrs)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_report_of_a_run_is_that_of_the_program(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    from test_run import granum_program

    run = granum.run(case, out=tmp_path / "run")
    granum_program("report", tmp_path / "run", "--out", tmp_path / "program.html")
    page = run.report(tmp_path / "page.html")
    assert page == (tmp_path / "page.html").read_text(encoding="utf-8") == (tmp_path / "program.html").read_text(encoding="utf-8")
    run.report(tmp_path / "folder")
    assert list((tmp_path / "folder" / "figures").glob("*.svg"))
    with pytest.raises(granum.FileError, match="force=True"):
        run.report(tmp_path / "page.html")
    assert "quality checks" in tested.report()


def test_a_notebook_shows_runs_samples_cases_and_tables(case: granum.Case, tested: granum.Run) -> None:
    sample = granum.prepare(case)
    for shown, word in [(tested, "quality checks passed"), (sample, "Preparation")]:
        frame = Open(shown._repr_html_())
        page = frame.attributes["srcdoc"]
        assert page is not None and word in Open(page).text and "prefers-color-scheme: dark" in page
        assert "http://" not in page.replace("http://www.w3.org", "") and "https://" not in page
        assert len(page) < 500_000
    text = Open(case._repr_html_()).text
    assert "grains.count" in text and "60" in text and "contact.damping" not in text
    table = Open(tested.series._repr_html_()).text
    assert "mean_stress (Pa)" in table
    assert "1000 rows" in Open(granum.Table({"x": np.arange(1000)})._repr_html_()).text
    everything = case.table()
    assert set(everything["key"]) == set(case.keys()) and not everything["is_default"][list(everything["key"]).index("grains.count")]


def test_a_notebook_shows_campaigns_data_sets_and_surrogates(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    campaign = granum.Campaign(case, tmp_path / "a & b", friction=[0.2, 0.3])
    text = Open(campaign._repr_html_()).text
    assert "2 runs" in text and "a & b" in text and campaign.names[0] in text and "friction" in text
    rough = granum.run(case.with_values({"grains.material.friction": 0.7}))
    data = granum.Dataset({"usual": tested, "rough": rough})
    text = Open(data._repr_html_()).text
    assert "2 runs" in text and "rough" in text and "grains.material.friction" in text and "grains.count" not in text
    surrogate = granum.surrogates.fit(data, "deviator_strain", "mean_stress", method="ridge")
    text = Open(surrogate._repr_html_()).text
    assert "ridge" in text and "deviator_strain" in text and "Pa" in text
    sand = granum.surrogates.load("sand")
    text = Open(sand._repr_html_()).text
    assert "rolling_friction" in text and "required" in text and sand.limits[0] in text


def test_columns_are_drawn(tested: granum.Run) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = tested.plot("stress_ratio")
    assert axes.get_xlabel() == "deviator strain" and axes.get_ylabel() == "stress ratio"
    assert np.array_equal(axes.lines[0].get_ydata(), tested.series["stress_ratio"])
    assert tested.plot(["mean_stress", "deviator_stress"], x="time", axes=axes, color="k") is axes
    assert len(axes.lines) == 3 and axes.lines[1].get_color() == "k"
    assert axes.get_ylabel() == "Pa"
    mixed = tested.plot(["mean_stress", "stress_ratio"])
    assert [text.get_text() for text in mixed.get_legend().get_texts()] == ["mean stress (Pa)", "stress ratio"]
    with pytest.raises(KeyError, match="did you mean stress_ratio"):
        tested.plot("stress_rato")


def test_runs_are_compared_with_a_laboratory_and_with_each_other(tested: granum.Run) -> None:
    tests = granum.laboratory(LABORATORY)
    name = next(iter(tests))
    assert tests[name].units["deviator_stress"] == "Pa" and tests[name]["axial_strain"].max() > 0.01
    comparison = granum.compare({"mine": tested}, {name: tests[name]})
    (found,) = comparison.errors
    assert (found["run"], found["test"]) == ("mine", name) and 0 < found["up_to"] < 0.02 and found["deviator_stress"] > 0
    residuals = comparison.residuals
    assert set(residuals["run"]) == {"mine"} and residuals["axial_strain"].max() <= found["up_to"]
    assert ElementTree.fromstring(comparison._repr_svg_().encode()).tag.endswith("svg")
    assert set(comparison.runs) == {"mine"} and set(comparison.tests) == {name}
    assert len(granum.compare(tested, LABORATORY).errors) == len(tests)
    same = granum.compare([tested, tested])
    assert [error["deviator_stress"] for error in same.errors] == [0.0] and same.errors[0]["run"] == "run 2"
    with pytest.raises(granum.CaseError, match="positive or negative"):
        granum.laboratory(LABORATORY, compression="up")
    with pytest.raises(granum.CaseError, match="axial_strain"):
        granum.compare(tested, {"other": granum.Table({"x": [1.0]})})
