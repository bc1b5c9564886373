"""Figures of matplotlib, and pages for notebooks."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any, cast

from ._granum import Comparison, Dataset, Family, Run, Surrogate, Table, laboratory

if TYPE_CHECKING:
    from ._granum import Case
    from .campaigns import Campaign

_STRAINS = ("deviator_strain", "deviatoric_strain", "axial_strain", "arc_length", "time")
_HEIGHT = 480
"""Height of a page in a notebook, pixels."""


def named(runs: Run | Iterable[Run] | Mapping[str, Run]) -> dict[str, Run]:
    """Runs with names: those of their folders, or their numbers."""
    if isinstance(runs, Mapping):
        return dict(cast("Mapping[str, Run]", runs))
    found: dict[str, Run] = {}
    for number, run in enumerate([runs] if isinstance(runs, Run) else runs):
        name = run.path.name if run.path is not None else f"run {number + 1}"
        found[f"{name} ({number + 1})" if name in found else name] = run
    return found


def _label(table: Table, name: str) -> str:
    unit = table.units[name]
    return name.replace("_", " ") + (f" ({unit})" if unit else "")


def plot(run: Run, y: str | Iterable[str], x: str | None = None, axes: Any = None, **style: Any) -> Any:
    """Draws columns of the states of a run over another one."""
    series = run.series
    x = x or next((name for name in _STRAINS if name in series), "state")
    names = [y] if isinstance(y, str) else list(y)
    values = [series[name] for name in (x, *names)]
    if axes is None:
        from matplotlib import pyplot

        axes = pyplot.subplots()[1]
    units = {series.units[name] for name in names}
    for name, column in zip(names, values[1:]):
        # Columns of one unit have it at the axis, others each in the legend.
        text = _label(series, name) if len(units) > 1 else name.replace("_", " ")
        axes.plot(values[0], column, **{**({"label": text} if len(names) > 1 else {}), **style})
    axes.set_xlabel(_label(series, x))
    if len(names) == 1:
        axes.set_ylabel(_label(series, names[0]))
    else:
        if len(units) == 1 and (unit := units.pop()):
            axes.set_ylabel(unit)
        axes.legend()
    return axes


def compare(
    runs: Run | Iterable[Run] | Mapping[str, Run],
    tests: str | PathLike[str] | Mapping[str, Table] | None = None,
) -> Comparison:
    """Compares runs with the curves of a laboratory, or with each other, as the program's command `granum compare`.

    `tests` is the file of a laboratory, or what `granum.laboratory` gave for one, perhaps fewer of them. Without it the runs are compared with
    the first of them. The curves have engineering strains; a notebook shows their figure.
    """
    if tests is None:
        tests = {}
    elif not isinstance(tests, Mapping):
        tests = laboratory(tests)
    return Comparison(named(runs), tests)


def frame(page: str) -> str:
    """A page inside a notebook, whose styles it does not touch."""
    return f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: {_HEIGHT}px; border: 0" loading="lazy"></iframe>'


def _rows(rows: Iterable[Iterable[object]], head: Iterable[str]) -> str:
    def cell(value: object) -> str:
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        return f"<td>{html.escape(text)}</td>"

    body = "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in rows)
    return f"<table><thead><tr>{''.join(f'<th>{html.escape(name)}</th>' for name in head)}</tr></thead><tbody>{body}</tbody></table>"


def of_table(table: Table, most: int = 10) -> str:
    """The first rows of a table for a notebook."""
    names = [f"{name} ({unit})" if (unit := table.units[name]) else name for name in table.columns]
    columns = [table[name][:most].tolist() for name in table.columns]
    more = f"<p>{len(table)} rows</p>" if len(table) > most else ""
    return _rows(zip(*columns), names) + more


def of_case(case: Case) -> str:
    """What differs from the defaults, for a notebook."""
    table = case.table()
    rows = zip(*(table[name].tolist() for name in ("key", "value", "unit", "meaning", "is_default")))
    given = [row[:4] for row in rows if not row[4]]
    head = f"<p>a case with digest <code>{case.digest[:12]}</code>; all other keys have their defaults</p>"
    return head + _rows(given, ("key", "value", "unit", "meaning"))


def of_campaign(campaign: Campaign) -> str:
    """The runs of a campaign with their variables and states."""
    table = campaign.table()
    return f"<p>a campaign of {len(table)} runs in <code>{html.escape(str(campaign.path))}</code></p>" + of_table(table)


def of_dataset(data: Dataset) -> str:
    """The runs of a data set with their parameters."""
    head = f"<p>a data set of {len(data.runs)} runs, {len(data)} states and {len(data.columns)} columns</p>"
    # What all runs have alike says nothing of any of them.
    table = data.runs_table()
    columns = {name: table[name] for name in table.columns}
    differing = {name: values for name, values in columns.items() if len(set(values.tolist())) > 1}
    return head + of_table(Table(differing, {name: table.units[name] for name in differing}) if differing else table)


def of_surrogate(surrogate: Surrogate) -> str:
    """The inputs and outputs of a surrogate."""
    units = surrogate.units
    rows = [(name, kind, units[name]) for kind, names in (("input", surrogate.inputs), ("output", surrogate.outputs)) for name in names]
    memory = ", which remembers the states before" if surrogate.has_memory else ""
    return f"<p>a surrogate by the method <code>{html.escape(surrogate.method)}</code>{memory}</p>" + _rows(rows, ("column", "kind", "unit"))


def of_family(family: Family) -> str:
    """The inputs of a family, and what it cannot answer."""
    head = f"<p>{html.escape(family.title)}: a surrogate of {family.runs} runs along the path <code>{html.escape(family.path)}</code></p>"
    rows = [
        (name, about["meaning"], " to ".join(f"{end:.6g}" for end in about["range"]), "required" if about["required"] else "")
        for name, about in family.inputs.items()
    ]
    limits = "".join(f"<li>{html.escape(limit)}</li>" for limit in family.limits)
    return head + _rows(rows, ("input", "meaning", "range of the runs", "")) + f"<ul>{limits}</ul>"
