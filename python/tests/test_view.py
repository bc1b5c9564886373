"""The view of grains in three dimensions: its page, and a picture of it from a browser without a screen and without a network."""

import base64
import json
import os
import pathlib
import re
import shutil
import subprocess
from typing import Any

import granum
import numpy as np
import numpy.typing as npt
import pytest

BROWSER = os.environ.get("GRANUM_CHROMIUM") or next(
    filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"])), None
)


def content(view: granum.View) -> dict[str, Any]:
    """What the page was given to show."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', view.html, flags=re.S)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_a_page_holds_the_grains_and_the_forces(tested: granum.Run) -> None:
    assembly = tested.snapshot()
    data = content(granum.view(tested))
    assert (data["count"], data["contacts"]) == (60, len(assembly.contacts))
    grains = np.frombuffer(base64.b64decode(data["grains"]), "<u2").reshape(60, 5) / 65535
    places = np.array(data["origin"]) + grains[:, :3] * np.array(data["box"])
    assert np.abs(places - assembly.positions).max() < 1e-4 * assembly.cell.max()
    assert np.allclose(grains[:, 3] * data["largest"], assembly.radii, rtol=1e-4)
    tubes = np.frombuffer(base64.b64decode(data["forces"]), [("place", "<u2", 3), ("branch", "<i2", 3), ("force", "<i2", 2)])
    order = np.argsort(-np.abs(assembly.normal_forces), kind="stable")
    assert np.allclose(tubes["force"][:, 0] / 32767, assembly.normal_forces[order] / assembly.normal_forces.max(), atol=1e-4)
    assert np.allclose(tubes["branch"] / 32767 * data["longest"], assembly.branches[order], atol=1e-4 * data["longest"])
    chains = assembly.force_chains()
    assert chains and tubes["force"][:, 1].astype(bool).sum() == sum(len(chain) - 1 for chain in chains)


def test_a_grain_is_shown_with_all_of_its_spheres_in_one_colour(tmp_path: pathlib.Path) -> None:
    (tmp_path / "case.toml").write_text(
        '[grains]\ncount = 60\n[grains.shape]\nkind = "dimer"\n[preparation]\nsolid_fraction = "none"\nunbalanced_force = 0.05\n'
        "[shear]\ndeviator_strain = 0.01\ninertial_number = 0.01\n[recording]\nstates = 4\n"
    )
    assembly = granum.run(granum.Case.read(tmp_path / "case.toml")).snapshot()
    assert len(assembly.radii) == 60 and np.bincount(assembly.piece_grains).tolist() == [2] * 60
    data = content(granum.view(assembly, colour=np.arange(60)))
    grains = np.frombuffer(base64.b64decode(data["grains"]), "<u2").reshape(120, 5) / 65535
    places = np.array(data["origin"]) + grains[:, :3] * np.array(data["box"])
    spheres = assembly.positions[assembly.piece_grains] + assembly.piece_arms
    assert np.abs(places - spheres).max() < 1e-4 * assembly.cell.max()
    assert np.allclose(grains[:, 3] * data["largest"], assembly.piece_radii, rtol=1e-4)
    assert np.allclose(grains[:, 4], assembly.piece_grains / 59, atol=1e-4)
    # A dimer has its least moment of inertia about its axis, which its orientation turns to where its spheres are.
    assert np.allclose(np.linalg.norm(assembly.orientations, axis=1), 1)
    least = assembly.moments_of_inertia.argmin(axis=1)
    w, axis = assembly.orientations[:, :1], assembly.orientations[:, 1:]
    long = np.eye(3)[least]
    twice = 2 * np.cross(axis, long)
    long = long + w * twice + np.cross(axis, twice)
    arms = assembly.piece_arms[::2]
    along = np.abs((arms * long).sum(axis=1))
    assert np.allclose(along, np.linalg.norm(arms, axis=1), rtol=1e-9)


def test_spheres_have_the_orientation_and_the_inertia_of_spheres(tested: granum.Run) -> None:
    assembly = tested.snapshot()
    assert assembly.orientations.tolist() == [[1, 0, 0, 0]] * len(assembly.radii)
    assert np.allclose(assembly.moments_of_inertia.T, 0.4 * assembly.masses * assembly.radii**2)


def test_force_chains_are_those_that_the_sensor_counts(tested: granum.Run) -> None:
    assembly = tested.snapshot()
    chains, measured = assembly.force_chains(), assembly.measure()
    assert len(chains) == measured["force_chains"] and max(map(len, chains)) == measured["longest_chain"]
    touching = {frozenset(pair) for pair in assembly.contacts.tolist()}
    assert all(frozenset(pair) in touching for chain in chains for pair in zip(chain.tolist(), chain.tolist()[1:]))


def test_a_page_is_small_and_needs_nothing_from_elsewhere(tested: granum.Run) -> None:
    page, bare = (granum.view(tested, strongest=strongest).html for strongest in (6000, 0))
    assert not re.search(r"https?:|src=|@import|url\(|import\(|fetch\(", page)
    contacts = len(tested.snapshot().contacts)
    per_contact, per_grain = 16 * 4 / 3, 10 * 4 / 3
    # Beside the contacts the page has a sentence that says what the tubes are.
    assert abs(len(page) - len(bare) - per_contact * contacts) < 250
    assert len(bare) + per_grain * 10_000 + per_contact * 6000 < 300_000


def test_a_notebook_shows_it_and_a_file_keeps_it(tested: granum.Run, tmp_path: pathlib.Path) -> None:
    view = granum.view(tested, title="</script><b>__DATA__ & \"more\"")
    assert "<iframe srcdoc=" in view._repr_html_() and "<b>__DATA__" not in view.html and view.html.count("</script>") == 2
    view.write(tmp_path / "view.html")
    assert (tmp_path / "view.html").read_text(encoding="utf-8") == view.html
    with pytest.raises(granum.FileError, match="force=True"):
        view.write(tmp_path / "view.html")
    view.write(tmp_path / "view.html", force=True)
    with pytest.raises(granum.FileError):
        view.write(tmp_path / "missing" / "view.html")


@pytest.mark.parametrize("colour", ["radius", "speed", "spin", "coordination", "chain_length", np.arange(60)])
def test_grains_have_a_colour(tested: granum.Run, colour: str | npt.NDArray[np.int64]) -> None:
    data = content(granum.view(tested.simulation(), colour=colour))
    shades = np.frombuffer(base64.b64decode(data["grains"]), "<u2").reshape(60, 5)[:, 4]
    # All grains of this sample have one radius.
    assert (shades.min(), shades.max()) == ((32768, 32768) if isinstance(colour, str) and colour == "radius" else (0, 65535))


def test_a_sample_without_contacts_is_shown(tested: granum.Run) -> None:
    simulation = tested.simulation()
    simulation.control(strain_rate={"xx": -1e3, "yy": -1e3, "zz": -1e3})
    simulation.advance(3000)
    assert content(granum.view(simulation))["contacts"] == 0


def test_what_cannot_be_shown_is_refused(tested: granum.Run) -> None:
    with pytest.raises(TypeError, match="is shown, not int"):
        granum.view(3)  # type: ignore[arg-type]
    colours: list[Any] = ["colour", np.zeros(3), np.full(60, np.nan)]
    for colour in colours:
        with pytest.raises(granum.CaseError, match="colour"):
            granum.view(tested, colour=colour)
    for opacity in [-0.1, 2.0, float("nan")]:
        with pytest.raises(granum.CaseError, match="opacity"):
            granum.view(tested, opacity=opacity)
    with pytest.raises(KeyError, match="did you mean end"):
        granum.view(tested, snapshot="ends")


def picture(view: granum.View, folder: pathlib.Path) -> npt.NDArray[np.float64]:
    """The right part of a picture of the page, beside the panel, from a browser that finds no other computer."""
    page, image = folder / "view.html", folder / "view.png"
    view.write(page, force=True)
    line = [
        str(BROWSER), "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
        "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}", "--window-size=900,600",
        "--virtual-time-budget=8000", f"--screenshot={image}", page.as_uri(),
    ]  # fmt: skip
    subprocess.run(line, check=True, capture_output=True, timeout=120)
    pixels: npt.NDArray[np.float64] = pytest.importorskip("matplotlib.image").imread(image)[:, 240:, :3]
    return pixels


@pytest.mark.skipif(BROWSER is None, reason="there is no Chromium here; GRANUM_CHROMIUM names one")
def test_a_browser_shows_grains_forces_and_chains(tested: granum.Run, tmp_path: pathlib.Path) -> None:
    def share(where: npt.NDArray[np.bool_]) -> float:
        return float(where.mean())

    def orange(pixels: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        red, green, blue = np.moveaxis(pixels, -1, 0)
        found: npt.NDArray[np.bool_] = (red > 0.5) & (green > 0.25) & (green < 0.75) & (blue < 0.25)
        return found

    def is_drawn(pixels: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        found: npt.NDArray[np.bool_] = np.abs(pixels - pixels[0, -1]).max(axis=-1) > 0.03
        return found

    grains = picture(granum.view(tested, opacity=1.0, forces=False, colour=np.zeros(60)), tmp_path)
    both = picture(granum.view(tested), tmp_path)
    chains = picture(granum.view(tested, opacity=0.0, chains=True), tmp_path)
    # Opaque grains cover the middle of the picture, which chains alone leave mostly free.
    middle = (slice(200, 400), slice(230, 430))
    assert share(is_drawn(grains[middle])) > 0.9 and share(is_drawn(chains[middle])) < 0.6
    assert share(orange(grains)) < 1e-3 and share(orange(chains)) > 0.005 and share(orange(both)) > 0.005
    # Grains of the same value have the middle of the colours, seen in light and shade.
    red, green, blue = grains[middle].mean(axis=(0, 1))
    assert green > red and blue > red
    assert share(is_drawn(both)) > share(is_drawn(chains))
