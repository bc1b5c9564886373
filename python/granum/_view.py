"""A view of grains, forces, force chains, bonds and cracks in three dimensions: one page that needs neither a server nor the network."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from ._granum import Assembly, Run, Simulation, view_colours, view_page
from .errors import CaseError, FileError, Mistake

if TYPE_CHECKING:
    import numpy.typing as npt


class View:
    """Grains, forces, force chains, bonds and cracks at one moment: `granum.view` makes it, and a notebook shows it.

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
    cracks: bool = True,
    strongest: int = 6000,
) -> View:
    """Shows grains, contact forces, force chains (Peters et al. 2005), bonds and cracks in three dimensions, as `granum view` does.

    `of` is an assembly, a simulation as it is now, or a run, of which a `snapshot` is shown, by default that at the end. `colour` is `radius`,
    `speed` (fluctuating velocity), `spin`, `coordination` (contacts of a grain), `chain_length` (grains of the chain of a grain), `bonds`,
    `fragment` (mass of the bonded grains over that of the largest fragment), or an array with a number for each grain. The width of a force is
    proportional to it; forces of chains are orange, tension is blue. `chains` shows the forces of chains alone, which a switch of the page does
    as well. Bonds that ruptured are discs across them (`cracks`), red by tension and violet by shear. Of more contacts than `strongest` those with
    the largest forces are shown, so that the page stays below 300 kB for up to ten thousand grains.
    """
    if isinstance(of, Run):
        of = of.snapshot(snapshot)
    elif isinstance(of, Simulation):
        of = of.assembly()
    if not isinstance(of, Assembly):
        raise TypeError(f"a granum.Run, a granum.Simulation or a granum.Assembly is shown, not {type(of).__name__}")
    if not 0 <= opacity <= 1:
        raise _wrong("opacity", opacity, f"{opacity} is not between 0 and 1", "0 shows no grains, 1 hides what is behind them")
    name, values = _colour(of, colour)
    page = view_page(
        of, title=title, colour=name, values=values, opacity=opacity, forces=bool(forces), chains=bool(chains), cracks=bool(cracks), strongest=strongest
    )
    return View(page)


def _wrong(key: str, value: object, message: str, remedy: str) -> CaseError:
    return CaseError(f"{key}: {message}; {remedy}", [Mistake(message=message, key=key, value=str(value), remedy=remedy)])


def _colour(of: Assembly, colour: str | npt.ArrayLike) -> tuple[str, list[float] | None]:
    """The name of a quantity of grains, or a value for each grain."""
    import numpy as np

    if isinstance(colour, str):
        names = view_colours()
        if colour not in names:
            raise _wrong("colour", colour, f"{colour!r} is not known", f"there are {', '.join(names)}, and arrays with a number for each grain")
        return colour, None
    values = np.asarray(colour, dtype=float)
    grains = len(of.radii)
    if values.shape != (grains,) or not np.isfinite(values).all():
        raise _wrong("colour", values.shape, f"an array of the shape {values.shape}", f"give a finite number for each of the {grains} grains")
    return "", values.tolist()
