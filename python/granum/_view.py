"""A view of grains, forces and force chains in three dimensions: one page that needs neither a server nor the network."""

from __future__ import annotations

import html
import os
from typing import TYPE_CHECKING, Any

from ._granum import Assembly, Run, Simulation
from .errors import CaseError, FileError, Mistake

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

_NAMED = ("radius", "speed", "spin", "coordination", "chain_length")


class View:
    """Grains, forces and force chains at one moment: `granum.view` makes it, and a notebook shows it.

    Drag turns it, the wheel brings it nearer; so do the arrow keys, plus and minus.
    """

    def __init__(self, page: str) -> None:
        self.html = page
        """The page, which holds all that it shows."""

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> None:
        """Writes the page. With `force` an existing file is replaced."""
        import pathlib

        path = pathlib.Path(path)
        if path.exists() and not force:
            raise FileError(f"{path} exists already; give force=True to replace it, or another name")
        try:
            path.write_text(self.html, encoding="utf-8")
        except OSError as error:
            raise FileError(f"{path}: {error}") from error

    def _repr_html_(self) -> str:
        from ._plots import frame

        return frame(self.html)

    def __repr__(self) -> str:
        return f"<granum.View of {len(self.html) // 1000} kB>"


def view(
    of: Run | Simulation | Assembly,
    *,
    snapshot: str | None = None,
    colour: str | npt.ArrayLike = "radius",
    title: str | None = None,
    opacity: float = 0.25,
    forces: bool = True,
    chains: bool = False,
    strongest: int = 6000,
) -> View:
    """Shows grains, contact forces and force chains (Peters et al. 2005) in three dimensions.

    `of` is an assembly, a simulation as it is now, or a run, of which a `snapshot` is shown, by default that at the end. `colour` is `radius`,
    `speed` (fluctuating velocity), `spin`, `coordination` (contacts of a grain), `chain_length` (grains of the chain of a grain), or an
    array with a number for each grain. The width of a force is proportional to it; forces of chains are orange, tension is
    blue. `chains` shows the forces of chains alone, which a switch of the page does as well. Of more contacts than `strongest` those with the
    largest forces are shown, so that the page stays below 300 kB for up to ten thousand grains.
    """
    import json
    import pathlib

    if isinstance(of, Run):
        of = of.snapshot(snapshot)
    elif isinstance(of, Simulation):
        of = of.assembly()
    if not isinstance(of, Assembly):
        raise TypeError(f"a granum.Run, a granum.Simulation or a granum.Assembly is shown, not {type(of).__name__}")
    data = _content(of, colour, opacity, forces, chains, strongest)
    text = pathlib.Path(__file__).with_name("view.html").read_text(encoding="utf-8")
    title = f"{len(of.radii)} grains" if title is None else title
    # In a script an end tag would end it.
    page = text.replace("__DATA__", json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"))
    return View(page.replace("__TITLE__", html.escape(title)))


def _wrong(key: str, value: object, message: str, remedy: str) -> CaseError:
    return CaseError(f"{key}: {message}; {remedy}", [Mistake(message=message, key=key, value=str(value), remedy=remedy)])


def _content(of: Assembly, colour: str | npt.ArrayLike, opacity: float, forces: bool, chains: bool, strongest: int) -> dict[str, Any]:
    """What the page shows: places as fractions of a box in whole numbers of 16 bits."""
    import numpy as np

    if not 0 <= opacity <= 1:
        raise _wrong("opacity", opacity, f"{opacity} is not between 0 and 1", "0 shows no grains, 1 hides what is behind them")
    # Of files of another program forces may be unknown: the grains are shown alone.
    has_forces = "normal forces" in of.parts
    found = of.force_chains() if has_forces else []
    name, values = _colours(of, colour, found)
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    shades = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
    # The spheres of a grain are shown where it is, also beyond the cell, and in its colour.
    spheres, radii = of.positions[of.piece_grains] + of.piece_arms, of.piece_radii
    if "cell" in of.parts:
        start, cell = np.zeros(3), of.cell
    else:
        # The box around all grains.
        start = (spheres - radii[:, None]).min(axis=0)
        cell = np.diag((spheres + radii[:, None]).max(axis=0) - start)
    # The cell may be inclined to either side: everything is placed in the box around it.
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) @ cell.T + start
    shown_places = np.concatenate([corners, spheres])
    origin = shown_places.min(axis=0)
    box = np.maximum(shown_places.max(axis=0) - origin, 1e-300)
    places = (of.positions - origin) / box
    largest = float(radii.max()) if len(radii) else 1.0
    grains = _bytes(np.column_stack([(spheres - origin) / box, radii / largest, shades[of.piece_grains]]), 65535, "<u2")

    pairs, normal_forces = (of.contacts, of.normal_forces) if has_forces else (np.empty((0, 2), np.int64), np.empty(0))
    shown = np.argsort(-np.abs(normal_forces), kind="stable")[: max(0, strongest)]
    linked = {frozenset(pair) for chain in found for pair in zip(chain.tolist(), chain.tolist()[1:])}
    of_chain = np.array([frozenset(pair) in linked for pair in pairs[shown].tolist()], dtype=float)
    branches = of.branches[shown] if has_forces else np.empty((0, 3))
    longest = float(np.abs(branches).max()) if len(shown) else 1.0
    most = float(np.abs(normal_forces).max()) if len(shown) else 1.0
    strength = normal_forces[shown] / (most or 1.0)
    tubes = np.empty(len(shown), dtype=[("place", "<u2", 3), ("branch", "<i2", 3), ("force", "<i2", 2)])
    tubes["place"] = np.round(np.clip(places[pairs[shown, 0]], 0, 1) * 65535)
    tubes["branch"] = np.round(branches / longest * 32767)
    tubes["force"] = np.round(np.column_stack([strength, of_chain]) * 32767)

    members = sum(len(chain) for chain in found)
    left_out = f"the {len(shown)} strongest of " if len(shown) < len(pairs) else ""
    note = f"{left_out}{len(pairs)} contacts, {len(found)} force chains of {members} grains"
    if len(shown):
        note += f"; tubes are as thick as their normal force, at most {most:.3g} N: grey to red in compression, blue in tension, orange in chains"
    if not has_forces and "contacts" in of.parts:
        note = f"{len(of.contacts)} contacts without forces"
    return {
        "count": len(radii),
        "grains": grains,
        "contacts": len(shown),
        "forces": _text(tubes.tobytes()),
        "cell": [[float(cell[row, edge]) for row in range(3)] for edge in range(3)],
        "origin": origin.tolist(),
        "box": box.tolist(),
        "largest": largest,
        "longest": longest,
        "width": 0.6 * (float(np.median(radii)) if len(radii) else 0.0),
        "opacity": opacity,
        "forces_shown": bool(forces),
        "chains_alone": bool(chains),
        "colour": name,
        "low": f"{low:.4g}",
        "high": f"{high:.4g}",
        "note": note,
    }


def _bytes(fractions: npt.NDArray[np.float64], scale: int, kind: str) -> str:
    import numpy as np

    return _text(np.round(np.clip(fractions, 0, 1) * scale).astype(kind).tobytes())


def _text(content: bytes) -> str:
    import base64

    return base64.b64encode(content).decode()


def _colours(of: Assembly, colour: str | npt.ArrayLike, chains: list[Any]) -> tuple[str, npt.NDArray[np.float64]]:
    """What grains are coloured by, with its unit, and the value of each grain."""
    import numpy as np

    grains = len(of.radii)
    if not isinstance(colour, str):
        values = np.asarray(colour, dtype=float)
        if values.shape != (grains,) or not np.isfinite(values).all():
            raise _wrong("colour", values.shape, f"an array of the shape {values.shape}", f"give a finite number for each of the {grains} grains")
        return "", values
    if colour == "radius":
        return "radius (m)", of.radii
    if colour == "speed":
        return "speed (m/s)", np.sqrt((of.velocities**2).sum(axis=1))
    if colour == "spin":
        return "spin (rad/s)", np.sqrt((of.spins**2).sum(axis=1))
    if colour == "coordination":
        return "contacts", np.bincount(of.contacts.ravel(), minlength=grains).astype(float)
    if colour == "chain_length":
        lengths = np.zeros(grains)
        for chain in chains:
            lengths[chain] = len(chain)
        return "grains of the chain", lengths
    raise _wrong("colour", colour, f"{colour!r} is not known", f"there are {', '.join(_NAMED)}, and arrays with a number for each grain")
