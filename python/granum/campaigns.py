"""Campaigns: many runs of a case, over the values of its variables.

>>> import granum
>>> case = granum.Case(grains={"count": 60})
>>> campaign = granum.Campaign(case, "study", friction=(0.1, 0.8), n=8)
>>> len(campaign)
8
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, SupportsIndex

from ._granum import Case, Dataset, Run, Table, _CampaignFolder
from ._script import script
from .errors import CaseError, Error, Mistake

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Campaign", "Variable", "choice", "expression", "linear", "log"]


class Variable(NamedTuple):
    """What a variable of a campaign is, as a table `[[variable]]` of a plan: `linear`, `log`, `choice` and `expression` make one."""

    key: str | Sequence[str] | None = None
    """The key of the case that takes its value, or several; by default the one with its name."""
    between: tuple[Any, Any] | None = None
    """The ends of a range, with units where they have some."""
    scale: Literal["linear", "log"] = "linear"
    """Whether equal differences or equal ratios are equally likely."""
    values: Sequence[Any] | None = None
    """The values of a choice."""
    expression: str | None = None
    """Other variables with operators, from which its value follows."""
    levels: int | None = None
    """Number of values of a range in a full factorial design."""
    step: Any = None
    """Its numbers are multiples of this."""

    def _table(self, name: str, case: Case) -> dict[str, Any]:
        # As in a plan, a variable of a key has the last part of it as its name.
        found: dict[str, Any] = {"name": name.rsplit(".", 1)[-1]}
        key = _key(name, case) if self.key is None and self.expression is None else self.key
        if isinstance(key, str):
            found["key"] = key
        elif key is not None:
            found["keys"] = list(key)
        if self.between is not None:
            found["from"], found["to"] = self.between
            if self.scale != "linear":
                found["scale"] = self.scale
        return {**found, "values": self.values, "expression": self.expression, "levels": self.levels, "step": self.step}


def linear(low: Any, high: Any, *, key: str | Sequence[str] | None = None, levels: int | None = None, step: Any = None) -> Variable:
    """A range in which equal differences are equally likely; a tuple of two stands for it as well."""
    return Variable(key, (low, high), "linear", levels=levels, step=step)


def log(low: Any, high: Any, *, key: str | Sequence[str] | None = None, levels: int | None = None, step: Any = None) -> Variable:
    """A range in which equal ratios are equally likely: `granum.log("50 kPa", "400 kPa")`."""
    return Variable(key, (low, high), "log", levels=levels, step=step)


def choice(values: Sequence[Any], *, key: str | Sequence[str] | None = None) -> Variable:
    """One of several values; a list stands for it as well."""
    return Variable(key, values=values)


def expression(text: str, *, key: str | Sequence[str] | None = None) -> Variable:
    """A value that follows from those of other variables: `granum.campaigns.expression("0.5 * friction", key="preparation.friction")`."""
    return Variable(key, expression=text)


def _key(name: str, case: Case) -> str | None:
    """The key for which the name of a variable stands: itself, that of the material, or the only one that ends with it."""
    keys = case.keys()
    ends = [key for key in keys if key == name or key.endswith("." + name)]
    material = f"grains.material.{name}"
    if material in ends or len(ends) == 1:
        return material if material in ends else ends[0]
    remedy = f'say which key it stands for: {name}=granum.linear(LOW, HIGH, key="preparation.mean_stress")'
    message = f"the variable {name} could stand for the key {' or '.join(ends)}"
    if not ends:
        near = difflib.get_close_matches(name, sorted({key.rpartition(".")[2] for key in keys}), 1)
        message = f"the variable {name} stands for no key of the case" + "".join(f"; did you mean {other}?" for other in near)
    raise CaseError(f"{message}; {remedy}", [Mistake(message, key=name, remedy=remedy)])


def _variable(value: Any) -> Variable:
    if isinstance(value, Variable):
        return value
    if isinstance(value, tuple) and len(value) == 2:
        return linear(*value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return choice(value)
    if hasattr(value, "tolist") and not isinstance(value, str):
        return choice(value.tolist())
    raise TypeError(f"a variable is a range (low, high), a list of values or a granum.campaigns.Variable, not {type(value).__name__}")


class Campaign:
    """The runs of a case over the values of variables, in a folder, as the program's command `granum campaign` carries them out.

    Each keyword is a variable: a range `(low, high)`, `granum.log(low, high)`, or a list of values. Its name stands for the key of the
    material with that name, or for the only key of the case that ends with it; `key=` of `granum.linear`, `granum.log` and
    `granum.campaigns.choice` says another one, or several. `variables` takes the same as a mapping.

    `n` is the number of points of a `design` that is drawn (`"sobol"`, `"latin-hypercube"`); `"full-factorial"` has all combinations.
    `replicates` are runs of each point that differ in the seed of their samples. `constraints`, `accept` and `keep` are those of a plan,
    and `set` has keys that all runs have. The same arguments give the same runs, with the same names, as the same plan.

    Nothing is written before `run`. Raises `granum.CaseError` with all mistakes of the plan.
    """

    def __init__(
        self,
        case: Case | Mapping[str, Any] | str | PathLike[str],
        out: str | PathLike[str],
        *,
        n: int | None = None,
        design: Literal["sobol", "latin-hypercube", "full-factorial"] | None = None,
        seed: int | None = None,
        replicates: int | None = None,
        sample_seeds: Literal["same", "different"] | None = None,
        constraints: Sequence[str] | None = None,
        accept: Sequence[str] | None = None,
        keep: Literal["folders", "dataset"] | None = None,
        set: Mapping[str, Any] | None = None,
        variables: Mapping[str, Any] | None = None,
        **named: Any,
    ) -> None:
        if not isinstance(case, Case):
            case = Case.from_dict(case) if isinstance(case, Mapping) else Case.read(case)
        twice = sorted({**(variables or {})}.keys() & named.keys())
        if twice:
            raise TypeError(f"{', '.join(twice)} is given twice: in variables and as a keyword")
        tables = [_variable(value)._table(name, case) for name, value in {**(variables or {}), **named}.items()]
        if design is None:
            design = "sobol" if n is not None else "full-factorial"
        plan = {
            "constraints": constraints,
            "accept": accept,
            "keep": keep,
            "set": set,
            "design": {"kind": design, "points": n, "seed": seed, "replicates": replicates, "sample_seeds": sample_seeds},
            "variable": tables or None,
        }
        self._folder = _CampaignFolder(case, plan, out)

    @classmethod
    def open(cls, folder: str | PathLike[str]) -> Campaign:
        """The campaign in a folder, also while another process carries it out."""
        campaign = cls.__new__(cls)
        campaign._folder = _CampaignFolder.open(folder)
        return campaign

    @property
    def path(self) -> Path:
        """The folder."""
        return self._folder.path

    @property
    def case(self) -> Case:
        """The base case."""
        return self._folder.case

    @property
    def plan(self) -> str:
        """The text of the plan."""
        return self._folder.plan

    @property
    def names(self) -> list[str]:
        """The names of the runs in the order of the plan."""
        return self._folder.names

    @property
    def is_done(self) -> bool:
        """True if every run is finished or failed."""
        return self._folder.is_done

    @property
    def remarks(self) -> dict[str, str]:
        """Why runs failed, and the checks that finished runs did not pass, by the name of the run."""
        return self._folder.remarks

    def case_of(self, name: str) -> Case:
        """The case of a run."""
        return self._folder.case_of(name)

    def table(self) -> Table:
        """The runs with the values of their variables and with their states, a row for each."""
        return self._folder.table()

    def run(
        self,
        *,
        workers: SupportsIndex | None = None,
        stop_after: Any = None,
        again: bool = False,
        force: bool = False,
        on_progress: Callable[[dict[str, Any]], object] | None = None,
    ) -> Campaign:
        """Carries out all runs that are not finished, each in a process of its own, and writes the data set. Returns the campaign.

        `workers` runs go on at once, by default as many as there are processors. After `stop_after` (seconds, or a text with a unit), on
        Ctrl-C, or if `on_progress` returns `False`, all runs end in good order, and the same call goes on. Runs that failed because of their
        case are tried again with `again`. With `force` folders of other cases or versions are replaced.
        """
        program = script()
        if program is None:
            raise Error("a campaign starts the script `granum` for each run, and it was not installed with this package; install it with pip")
        self._folder.carry_out(program, workers=workers, stop_after=stop_after, again=again, force=force, on_progress=on_progress)
        return self

    def dataset(self) -> Dataset:
        """The data set of the finished runs, from which surrogates learn."""
        return Dataset.read(self.path)

    def __getitem__(self, name: str) -> Run:
        """The run of a name."""
        return self._folder.run(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def _repr_html_(self) -> str:
        from ._plots import of_campaign

        return of_campaign(self)

    def __repr__(self) -> str:
        return repr(self._folder)

    def __reduce__(self) -> Any:
        if not (self.path / "campaign.json").exists():
            raise TypeError("a campaign that has not begun cannot be pickled: its folder is made by run()")
        return Campaign.open, (self.path.absolute(),)
