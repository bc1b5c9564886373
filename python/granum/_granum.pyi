"""The library of granum, compiled."""

import pathlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, NoReturn, SupportsIndex, TypeAlias, final, overload

import numpy as np
import numpy.typing as npt

from . import keys
from .sensors import Sensor

_Path: TypeAlias = str | PathLike[str]
_Reals: TypeAlias = npt.NDArray[np.float64]
_Integers: TypeAlias = npt.NDArray[np.int64]
_Booleans: TypeAlias = npt.NDArray[np.bool_]

__all__ = [
    "Assembly",
    "Case",
    "Comparison",
    "Dataset",
    "Family",
    "MaterialPoint",
    "PointState",
    "Recorder",
    "Run",
    "Simulation",
    "Surrogate",
    "Table",
    "Values",
    "_CampaignFolder",
    "__version__",
    "_entered",
    "_forked",
    "_mistake",
    "_program",
    "_write_grainlearning",
    "families",
    "fit",
    "laboratory",
    "measure",
    "methods",
    "open",
    "pair",
    "paths",
    "prepare",
    "read",
    "resume",
    "run",
    "schema",
    "template",
    "view_colours",
    "view_page",
    "write",
]

__version__: str

@final
class Values:
    """Numbers of granum that NumPy shows without a copy."""

    @property
    def __array_interface__(self) -> dict[str, Any]: ...

@final
class Case:
    """A case: all the input that determines a result. It never changes; `with_values` and `with_path` give another.

    The keywords are the sections of a case file, each a dict of its keys (`granum.keys` has them with meaning, bounds and unit); `stages`,
    `materials`, `pairs` and `bonds` are the lists of tables `[[stage]]`, `[[material]]`, `[[pair]]` and `[[bond]]`. Keys that are left out have their defaults,
    and so has a key whose value is `None`. A value is a number in SI units, a text with a unit (`"0.2 mm"`), or a quantity of pint. Files that
    keywords name may lie anywhere; those of `from_dict`, `from_toml` and `read` in the folder of the case or below it.

    Raises `granum.CaseError` with all mistakes at once.
    """

    def __new__(
        cls,
        *,
        grains: keys.Grains = ...,
        contact: keys.Contact = ...,
        preparation: keys.Preparation = ...,
        shear: keys.Shear = ...,
        recording: keys.Recording = ...,
        numerics: keys.Numerics = ...,
        stages: Sequence[keys.Stage] = ...,
        materials: Sequence[keys.Material] = ...,
        pairs: Sequence[keys.Pair] = ...,
        bonds: Sequence[keys.Bond] = ...,
    ) -> Case: ...
    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any]) -> Case:
        """The case of a dict with the keys of a case file. Keys may be joined by dots: `{"grains.count": 2000}`."""

    @classmethod
    def from_toml(cls, text: str, name: str = "case.toml") -> Case:
        """The case of the text of a case file; `name` is the name of the file for messages."""

    @classmethod
    def read(cls, path: _Path, *, allow_outside: bool = False) -> Case:
        """Reads a case file. With `allow_outside` it may name files outside its own folder (histories, sieve curves)."""

    def to_toml(self) -> str:
        """The whole case as a case file in SI units, which is read back as the same case, bit for bit."""

    def to_dict(self) -> dict[str, Any]:
        """The same as a dict, in SI units."""

    @property
    def digest(self) -> str:
        """SHA-256 of all that determines a result: the same as the program gives."""

    def with_values(self, values: Mapping[str, Any]) -> Case:
        """The case with other values of some keys, by their full names: `case.with_values({"grains.count": 500})`. A parameter of the
        first stage is `stage.1.axial_strain`.
        """

    def with_path(self, path: str, **parameters: Any) -> Case:
        """The case with a named path as its test; `granum.paths()` has the paths with their parameters."""

    def with_stages(self, stages: Sequence[keys.Stage]) -> Case:
        """The case with these stages, one after the other, as its test; each is a dict with the keys of a table `[[stage]]`."""

    def keys(self) -> list[str]:
        """The names of all keys."""

    def table(self) -> Table:
        """Every key with its `value`, `unit` and `meaning`, and whether it has its default (`is_default`)."""

    def _repr_html_(self) -> str: ...

    def __getitem__(self, key: str, /) -> float | str | list[float]:
        """The value of a key in SI units."""

    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self, /) -> int: ...
    def __copy__(self) -> Case: ...
    def __deepcopy__(self, _memo: Any) -> Case: ...
    def __reduce__(self) -> Any: ...

@final
class Table:
    """A table of named columns, each with its unit. A column is a read-only array of NumPy, of real numbers without a copy.

    `columns` maps names to values of one length: numbers, truth values or words; it can also be a frame of pandas or polars. `units` gives
    SI units of some of them. Whatever reads Arrow takes a table as it is, without a copy of its real numbers: `polars.DataFrame(table)`,
    `pyarrow.table(table)`, DuckDB.
    """

    def __new__(cls, columns: Any, units: Mapping[str, str] | None = None) -> Table: ...
    @classmethod
    def read(cls, path: _Path) -> Table:
        """Reads a table from CSV or Parquet."""

    def write(self, path: _Path, *, force: bool = False) -> None:
        """Writes the table in the format of the name of the file (CSV, Parquet). With `force` an existing file is replaced."""

    @property
    def columns(self) -> list[str]:
        """The names of the columns."""

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each column; an empty text for a pure number."""

    @property
    def descriptions(self) -> dict[str, str]:
        """The meaning of each column that granum knows."""

    def keys(self) -> list[str]:
        """The names of the columns."""

    def to_dict(self) -> dict[str, npt.NDArray[Any]]:
        """The columns as arrays."""

    def to_pandas(self) -> Any:
        """A DataFrame of pandas, with the units in `attrs["units"]` and the meanings in `attrs["descriptions"]`."""

    def to_polars(self) -> Any:
        """A DataFrame of polars."""

    def to_xarray(self) -> Any:
        """A Dataset of xarray, with units and meanings as attributes of its variables. The table of a histogram gets the dimensions `row`,
        of the states, and that of its bins.
        """

    def _repr_html_(self) -> str: ...
    def __arrow_c_schema__(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...

    def __getitem__(self, name: str, /) -> npt.NDArray[Any]: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]
    def __reduce__(self) -> Any: ...

@final
class Assembly:
    """All grains and contacts at one moment, in the order of the ids of the grains. Every array is read-only and shows no later step.

    An assembly is a copy of what the engine keeps in another layout. Its arrays are views of it without a further copy, which keep all of it in
    memory: the distance from one grain to the next is that of all its data (`strides`). Only `ids`, `materials`, `contacts` and `forces` are
    arrays of their own.

    An assembly can be made of arrays of anyone, with the arguments of `granum.measure`, or read from files of other programs
    (`granum.read`). Of these only a part is known (`parts`); what is not raises `AttributeError`.
    """

    def __new__(
        cls,
        positions: npt.ArrayLike,
        radii: npt.ArrayLike,
        contacts: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
        cell: npt.ArrayLike | None = None,
    ) -> Assembly: ...
    @property
    def parts(self) -> list[str]:
        """The names of what is known: everything of a run of granum, and of files of another program what these have."""
    @property
    def remarks(self) -> list[str]:
        """What was set right in the data that were read, and what is doubtful in them, as sentences."""
    @property
    def origin(self) -> _Reals:
        """The corner of the cell in the file that was read, m; positions count from it."""
    @property
    def time(self) -> float:
        """Time since the start of the phase, s."""
    @property
    def step(self) -> int:
        """Steps since the start of the phase."""
    @property
    def volume(self) -> float:
        """Volume of the cell, m3."""
    @property
    def cell(self) -> _Reals:
        """Matrix of the periodic cell, whose columns are its edges, m."""
    @property
    def strain(self) -> _Reals:
        """Logarithmic strain since the start of the phase, compression positive."""
    @property
    def velocity_gradient(self) -> _Reals:
        """Velocity gradient of the cell, 1/s."""
    @property
    def ids(self) -> _Integers:
        """Ids of the grains, from 1."""
    @property
    def materials(self) -> _Integers:
        """Material of each grain, as an index of `material_names`."""
    @property
    def material_names(self) -> list[str]:
        """Names of the materials; empty if there is one."""
    @property
    def positions(self) -> _Reals:
        """Centres of the grains inside the cell, m: a row a grain."""
    @property
    def velocities(self) -> _Reals:
        """Fluctuating velocities of the grains, m/s: a row a grain."""
    @property
    def spins(self) -> _Reals:
        """Spins of the grains, rad/s: a row a grain."""
    @property
    def grain_forces(self) -> _Reals:
        """Sum of the contact forces on each grain, N."""
    @property
    def grain_torques(self) -> _Reals:
        """Sum of the contact torques on each grain, N m."""
    @property
    def radii(self) -> _Reals:
        """Radii of the grains, m; of a grain of several pieces that of the sphere of equal volume."""
    @property
    def masses(self) -> _Reals:
        """Masses of the grains, kg."""
    @property
    def orientations(self) -> _Reals:
        """Rotation of each grain from its principal axes to those of space, as a quaternion w, x, y, z: a row a grain, 1, 0, 0, 0 for a sphere."""
    @property
    def moments_of_inertia(self) -> _Reals:
        """Principal moments of inertia of each grain, kg m2: a row a grain."""
    @property
    def piece_grains(self) -> _Integers:
        """The grain of each sphere, as an index from 0. A grain has one sphere, or several that are fixed on it."""
    @property
    def piece_arms(self) -> _Reals:
        """From the centre of its grain to that of each sphere, m: a row a sphere."""
    @property
    def piece_radii(self) -> _Reals:
        """Radius of each sphere, m."""
    @property
    def bonds(self) -> _Integers:
        """Indices, from 0, of the two grains of each bond that holds: a row a bond, in the order of their numbers."""
    @property
    def bond_forces(self) -> _Reals:
        """Elastic force of each bond on its first grain, N."""
    @property
    def bond_normals(self) -> _Reals:
        """Unit vector along each bond, from the first grain to the second."""
    @property
    def bond_energies(self) -> _Reals:
        """Elastic energy of each bond, J."""
    @property
    def bond_utilisations(self) -> _Reals:
        """Ratio of load to strength of each bond: it ruptures at 1."""
    @property
    def cracks(self) -> _Reals:
        """Places of the cracks, which are the bonds that ruptured, in the order in which they did, m: a row a crack."""
    @property
    def crack_normals(self) -> _Reals:
        """Unit normal of each crack: the direction of the bond."""
    @property
    def crack_energies(self) -> _Reals:
        """Energy that was stored in each bond that ruptured, J."""
    @property
    def crack_by_tension(self) -> _Booleans:
        """True for each crack that opened by tension with bending, false for one by shear with twist."""
    @property
    def contacts(self) -> _Integers:
        """Indices, from 0, of the two grains of each contact: a row a contact."""
    @property
    def branches(self) -> _Reals:
        """Vector between the centres of the two grains of each contact, m."""
    @property
    def normals(self) -> _Reals:
        """Unit normal of each contact, from the first grain to the second."""
    @property
    def forces(self) -> _Reals:
        """Elastic force on the first grain of each contact, N."""
    @property
    def normal_forces(self) -> _Reals:
        """Elastic normal force of each contact, compression positive, N."""
    @property
    def tangential_forces(self) -> _Reals:
        """Elastic tangential force on the first grain of each contact, N."""
    @property
    def overlaps(self) -> _Reals:
        """Overlap of each contact, m."""
    @property
    def sliding(self) -> _Booleans:
        """True where the tangential force was at the friction limit in the last step."""
    def grains_table(self) -> Table:
        """All grains as a table, with units."""
    def contacts_table(self) -> Table:
        """All contacts as a table, with units."""
    def force_chains(self) -> list[_Integers]:
        """The force chains (Peters et al. 2005), as the sensor of that name counts them: for each the indices of its grains along it."""
    def measure(self) -> dict[str, float]:
        """The values of every sensor that one assembly suffices for, by column, in SI units."""

@final
class MaterialPoint:
    """A sample that is strained step by step: it answers with stress, stiffness and sensors. Its states are values: the same strain from the
    same state gives the same bits, and a state is never changed.

    `sample` is a simulation, as `granum.prepare(case).simulation()` gives one; it is copied. `inertial_number` is that of the straining,
    `relaxation` the number of steps for which the cell is held after an increment, over the last `averaging` of which the stress is a mean.
    An increment larger than `largest_increment`, `sqrt(2/3 e:e)`, is divided, or refused with `refuse_larger`. With `from_surrogate` a surrogate
    stands in place of the grains.
    """

    def __new__(
        cls,
        sample: Simulation,
        *,
        inertial_number: float | None = None,
        relaxation: int | None = None,
        averaging: int | None = None,
        largest_increment: float | None = None,
        refuse_larger: bool = False,
    ) -> MaterialPoint: ...
    @staticmethod
    def from_surrogate(
        surrogate: Surrogate | _Path,
        sample: Mapping[str, float] | None = None,
        *,
        largest_increment: float | None = None,
        refuse_larger: bool = False,
    ) -> MaterialPoint:
        """A point whose stress a surrogate predicts in place of grains, for example one of the methods `path-...`. `surrogate` is one, or the file of one.

        Its inputs are the six logarithmic strains since the start (`axial_strain`, `lateral_strain_2`, `lateral_strain_3`, `shear_strain_yz`,
        `shear_strain_zx`, `shear_strain_xy`), and `sample` has the values of its other inputs by name, in SI units. Its outputs are the six stresses
        (`stress_11`, `stress_22`, `stress_33`, `stress_23`, `stress_13`, `stress_12`), Pa, and any others but `volumetric_strain`, which a point prescribes
        (`PointState.value`). It needs a memory.

        The answer depends on how a path is cut: increments should be about as long as those between the training states. `largest_increment` and
        `refuse_larger` are as for a sample. `granum.CaseError` says what a surrogate or a sample lacks.
        """
    @staticmethod
    def hybrid(
        surrogate: Surrogate | _Path,
        simulation: Simulation,
        sample: Mapping[str, float] | None = None,
        *,
        largest_trusted_deviation: float = 0.1,
        keeps_stress: bool = False,
        inertial_number: float | None = None,
        relaxation: int | None = None,
        averaging: int | None = None,
        largest_increment: float | None = None,
    ) -> MaterialPoint:
        """A point that a surrogate answers for while it knows, and grains where it does not: where the standard deviation of a stress that it predicts is larger than
        `largest_trusted_deviation` of the mean stress, or an input or the path is outside of what it was trained on. The grains of `simulation` then follow the path of
        the state from the start on and answer from there; the stress changes by the error that the surrogate had. With `keeps_stress` they are then
        brought to the last stress of the surrogate, if they can carry it, so that the stress goes on. `PointState.is_live` tells who answered.

        `surrogate` and `sample` are as for `from_surrogate`; values of inputs `sample.X` that are not given are measured on the simulation, which is copied.
        """
    @property
    def start(self) -> PointState:
        """The state of the sample before any increment."""
    def advance(self, state: PointState, strain: npt.ArrayLike, *, rotation: npt.ArrayLike | None = None) -> PointState:
        """The state after an increment: a logarithmic strain of six components xx, yy, zz, yz, zx, xy, compression positive, shear strains as
        angles, after a `rotation` (3 x 3) of the sample, if there is one.
        """
    def advance_all(self, states: Sequence[PointState], strains: npt.ArrayLike, *, threads: int = 0) -> list[PointState]:
        """The states after increments of many states, rows of six components of strain, on up to `threads` threads (0: all of the machine),
        with the same bits on any number of them.
        """
    def at_stress(self, state: PointState, stress: npt.ArrayLike) -> PointState:
        """The state brought to a stress, Pa, of six components, compression positive: each is then within a thousandth of the largest."""
    def tangent(self, state: PointState, kind: str = "probes", *, probe_strain: float = 1e-5) -> _Reals:
        """The stiffness of a state (6 x 6), Pa: `d_sigma_i = C_ij d_eps_j`. `kind` is `affine`, `elastic`, `probes` (differences of answers
        to strains of `probe_strain`) or `secant`, as the chapter on finite elements explains.
        """

@final
class PointState:
    """A state of a material point. It is never changed."""

    @property
    def stress(self) -> _Reals:
        """Stress, Pa: xx, yy, zz, yz, zx, xy, compression positive."""
    @property
    def noise(self) -> _Reals:
        """Standard deviation of the stress over the steps of its mean, Pa, by the same components, in the axes of the cell; that of a surrogate is that
        of its prediction for a new sample, zero if it does not know it.
        """
    @property
    def mean_stress(self) -> float:
        """Mean stress, Pa."""
    @property
    def void_ratio(self) -> float | None:
        """Volume of the voids over that of the grains; `None` for a surrogate that neither predicts it nor has it as an input."""
    @property
    def ticket(self) -> int:
        """A whole number that stands for sample, controls and path; it is the same in every process."""
    @property
    def is_live(self) -> bool:
        """True if grains are behind the state, and not a surrogate."""
    def path(self, start: PointState) -> Table | None:
        """The path that led to this state of a hybrid point from its start, as a table: the six strains and the six stresses, a row for each part that was carried out. Where the
        state is live all stresses are those of the grains, so that it is a test from which a surrogate can learn. `None` for other points.
        """
    @property
    def outside(self) -> list[str]:
        """What is outside of what a surrogate was trained on, and then not to be trusted: names of inputs, and the length and the turns of the path.
        Nothing for grains.
        """
    def value(self, column: str) -> float | None:
        """The value of a column: a sensor of the grains, or an output of a surrogate; `None` if there is none of that name."""
    def measure(self) -> dict[str, float]:
        """The values of every sensor of one state, by column. `granum.RunError` for a surrogate, which has no grains."""

@final
class Simulation:
    """A simulation that is advanced by hand: `run.simulation()` gives the state at the end of a run. A copy (`copy.copy`) goes its own way."""

    def advance(self, steps: SupportsIndex) -> None:
        """Makes so many time steps. Other threads of Python go on meanwhile, and Ctrl-C ends it after a whole step."""

    def control(
        self,
        *,
        strain_rate: Mapping[str, keys.Quantity] | None = None,
        stress: Mapping[str, keys.Quantity] | None = None,
        mean_stress: keys.Quantity | None = None,
        rate_limit: keys.Quantity | None = None,
    ) -> None:
        """Controls the cell from here on. Components are `xx`, `yy`, `zz`, `yz`, `zx`, `xy`; what is not given is fixed.

        `strain_rate` are rates of strain in 1/s, compression positive, shear strains as angles. `stress` are stresses in Pa that a servo
        holds; `mean_stress`, Pa, is held by the axes that have neither. `rate_limit` bounds the rate, by default 1 1/s, that the servo
        adds. Each may have a unit, as in a case. A stress that was held by the same strain rates before is held on without a jump, also if
        its value changes: the servo does not begin anew.
        """

    def follow(
        self,
        path: Callable[[Simulation], dict[str, Any] | None],
        *,
        every: SupportsIndex,
        recorder: Recorder | None = None,
        states_every: int = 1,
        most_steps: SupportsIndex | None = None,
    ) -> int:
        """Lets a function steer: it is called with the simulation at once and after every so many steps (`every`, the control interval),
        and returns the arguments of `control` as a dict, or `None` at the end of the path. Returns the number of steps.

        `recorder` records the first state and that after every `states_every` intervals. At most `most_steps` steps are made. What the
        function raises ends the path; the simulation is then at the end of an interval.
        """

    def assembly(self) -> Assembly:
        """All grains and contacts as they are now: a copy, which shows no later step."""
    def history(self) -> dict[str, _Reals]:
        """What the contact laws keep of each contact, in the order of the contacts of `assembly()`, as copies.

        `tangential_vectors` (contacts, vectors, 3) are vectors in the plane of contact on the first grain, the first of which is the
        tangential force, N; `tangential_scalars` (contacts, scalars) what else that law keeps. `normal_scalars`, `rolling_vectors`,
        `rolling_scalars` and `adhesion_scalars` are those of the other laws. What no law keeps is left out. Units are those of the law.
        """
    @property
    def time(self) -> float:
        """Time since the start of the phase, s."""
    @property
    def step(self) -> int:
        """Steps since the start of the phase."""
    @property
    def time_step(self) -> float:
        """Time step, s."""
    @property
    def grains(self) -> int:
        """Number of grains."""
    @property
    def contacts(self) -> int:
        """Number of contacts."""
    @property
    def mean_stress(self) -> float:
        """Mean stress, Pa."""
    @property
    def solid_fraction(self) -> float:
        """Volume of the grains over that of the cell."""
    @property
    def unbalanced_force(self) -> float:
        """Mean resultant force on a grain over the mean contact force."""
    @property
    def stress(self) -> _Reals:
        """Stress, Pa, compression positive."""
    @property
    def strain(self) -> _Reals:
        """Logarithmic strain since the start of the phase, compression positive."""
    @property
    def cell(self) -> _Reals:
        """Matrix of the periodic cell, whose columns are its edges, m."""
    def __copy__(self) -> Simulation: ...
    def __deepcopy__(self, _memo: Any) -> Simulation: ...
    def __reduce__(self) -> Any: ...

@final
class Recorder:
    """Records states of a simulation that is advanced by hand, with every sensor that tests record.

    `case` gives the keys of `[recording]`: further sensors by name, their parameters and bins. `sensors` adds names of sensors and sensors of
    one's own.
    """

    def __new__(
        cls, case: Case | Mapping[str, Any] | _Path | None = None, *, sensors: Iterable[str | Sensor] | None = None
    ) -> Recorder: ...
    def record(self, of: Simulation | Assembly) -> None:
        """Records what a simulation, or an assembly, is like now as the next state, of one observation. A sensor that raises leaves the
        recorder as it was.
        """

    @property
    def series(self) -> Table:
        """The recorded states, a row a state."""
    @property
    def tables(self) -> list[str]:
        """The names of its tables: the series and the histograms of the sensors."""
    def table(self, name: str) -> Table:
        """The table of that name."""
    def __len__(self) -> int: ...

@final
class Run:
    """A run: a sample that `granum.prepare` made, or a test that `granum.run` carried out, in its folder or in memory."""

    @property
    def path(self) -> pathlib.Path | None:
        """The folder; `None` if the run is in memory."""
    @property
    def case(self) -> Case:
        """The case."""
    @property
    def kind(self) -> Literal["sample", "test"]:
        """What it is."""
    @property
    def status(self) -> Literal["running", "interrupted", "finished", "failed"]:
        """Its status."""
    @property
    def record(self) -> dict[str, Any]:
        """What the run says about itself, as its file `run.json`."""
    @property
    def measures(self) -> dict[str, float]:
        """Quantities that the run measured once, in SI units."""
    @property
    def quality(self) -> list[dict[str, Any]]:
        """The quality checks: `name`, `value`, `limit`, `passed`, and what to do if it did not pass (`advice`)."""
    @property
    def is_good(self) -> bool:
        """True if the run is finished and passed all quality checks."""
    @property
    def notes(self) -> list[str]:
        """Remarks of the run."""
    @property
    def tables(self) -> list[str]:
        """The names of its tables."""
    def table(self, name: str) -> Table:
        """The table of that name."""
    @property
    def series(self) -> Table:
        """The recorded states of a test, a row a state."""
    @property
    def snapshots(self) -> list[str]:
        """The names of its snapshots."""
    def snapshot(self, name: str | None = None) -> Assembly:
        """All grains and contacts at a snapshot; by default that at the end."""
    def simulation(self) -> Simulation:
        """The simulation as it was at the end of the run, or at its last checkpoint, to go on by hand."""
    def digest(self) -> str:
        """SHA-256 of all results of a run in a folder: the same as `granum digest` gives."""
    def report(self, out: _Path | None = None, *, force: bool = False) -> str:
        """The report of the run as the text of a self-contained page. With `out`, a file `.html` or a folder, it is also written."""
    def plot(self, y: str | Iterable[str], x: str | None = None, axes: Any = None, **style: Any) -> Any:
        """Draws columns of the states over another one, by default a strain, with matplotlib; returns the axes."""
    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> Any: ...

@final
class Comparison:
    """Runs over the curves of a laboratory, or over each other: `granum.compare` makes it. A notebook shows its figure."""

    def __new__(cls, runs: Mapping[str, Run], tests: Mapping[str, Table]) -> Comparison: ...
    @property
    def runs(self) -> dict[str, Table]:
        """The curves of each run in the measures of the laboratory: engineering strains, compression positive."""
    @property
    def tests(self) -> dict[str, Table]:
        """The curves of each test of the laboratory."""
    @property
    def errors(self) -> list[dict[str, Any]]:
        """The errors of each `run` against each `test`, or of the other runs against the first, `up_to` the largest axial strain that both
        have: root mean square of the `deviator_stress` over its largest value, of `volumetric_strain` and `void_ratio`, and the largest
        deviator stress over that of the test, minus one (`peak`).
        """
    @property
    def residuals(self) -> Table:
        """What the runs have more than the tests, reading by reading."""
    @property
    def svg(self) -> str:
        """The figure, as the program draws it."""
    def _repr_svg_(self) -> str: ...

def laboratory(path: _Path, *, columns: Mapping[str, str] | None = None, **conventions: str) -> dict[str, Table]:
    """The tests of a laboratory's file by name: `axial_strain`, `volumetric_strain`, `deviator_stress`, `mean_stress`, `void_ratio`.

    They are in SI units, compression positive, with engineering strains. `columns` maps known quantities to the columns that hold them:
    `{"axial_strain": "eps1 (%)"}`. `conventions` are those that comments of the file may state: `compression="negative"`,
    `strain="logarithmic"`, `stress="total"`, `deviator_stress="half"`, `bedding_strain="0.3 %"`.
    """


@final
class Dataset:
    """The states of runs, from which surrogates learn: a column for each quantity, a row for each state of each run. Keys of the case and
    measures of the sample are columns as well, the same in all rows of a run.

    `runs` are runs of granum, folders of runs or tables with a row for each state, or a mapping of names to them.
    """

    def __new__(cls, runs: Iterable[Run | Table | _Path] | Mapping[str, Run | Table | _Path]) -> Dataset: ...
    @classmethod
    def read(cls, folder: _Path) -> Dataset:
        """The data set of a campaign, or one in a folder of its own, whose files are compared with their sums."""

    @property
    def runs(self) -> list[str]:
        """The names of the runs."""
    @property
    def columns(self) -> list[str]:
        """The names of the columns of numbers that all runs have."""
    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each of them; an empty text for a pure number."""
    @property
    def categories(self) -> dict[str, list[str]]:
        """What has words instead of numbers, such as `contact.normal`, with its words."""
    @property
    def groups(self) -> _Integers:
        """The number of the run of each row, from 0: the groups of a cross-validation that leaves out whole runs."""
    @property
    def digest(self) -> str:
        """SHA-256 of names, units and the bits of all numbers."""
    def keys(self) -> list[str]:
        """The names of the columns."""
    def expand(self, names: str | Iterable[str]) -> list[str]:
        """The columns that names stand for: that of a histogram for its bins, that of a category for a column of each word."""
    def values(self, names: str | Iterable[str]) -> _Reals:
        """The values of columns, a row for each state; names as for `expand`."""
    def tensor(self, names: str | Iterable[str]) -> Any:
        """The values of columns as a tensor of torch, which has the memory of the array of `values` and no copy of it, and as that array must
        not be written to. Needs torch.
        """
    def table(self) -> Table:
        """All rows as a table, with the number of the run, from 1, in the column `run`."""
    def runs_table(self) -> Table:
        """The runs as a table with their parameters, a row for each."""
    def select(self, runs: str | Iterable[str]) -> Dataset:
        """The data set of some of the runs."""
    def split(
        self, *, unseen: str | Iterable[str] | None = None, stride: SupportsIndex | None = None, first_state: int = 0
    ) -> dict[str, Dataset | None]:
        """Parts for training and for judging: `unseen` runs; of the others every second (`stride`) state as `training` and the rest as
        `held_out`, and all their states as `training_runs`, for methods with memory. A part without states is `None`.
        """
    def _repr_html_(self) -> str: ...
    def __getitem__(self, name: str, /) -> _Reals: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]

@final
class Surrogate:
    """A surrogate: `granum.surrogates.fit` fits it, `granum.surrogates.read` reads it."""

    @classmethod
    def read(cls, path: _Path) -> Surrogate:
        """The surrogate of a file."""

    @classmethod
    def from_json(cls, text: str) -> Surrogate:
        """The surrogate of the text of such a file."""

    def to_json(self) -> str:
        """The text of its file."""
    def write(self, path: _Path, *, force: bool = False) -> None:
        """Writes its file, from which the program predicts as well."""
    def export_onnx(self, path: _Path, *, level: float = 0.9, force: bool = False) -> None:
        """Writes it as an ONNX file (opset 17), which other programs evaluate without granum.

        The inputs and outputs have the names of the columns, in physical units, as doubles with a row for each state: `predicted_NAME`, and where
        the surrogate provides them `standard_deviation_NAME`, `lower_NAME` and `upper_NAME`, and `outside`, which is 1 beyond the range of the
        training. A surrogate with memory is one step of it: `memory` is the `next_memory` of the state before, and where `begins` is 1 a run begins.
        `granum.Error` says which surrogates have no such form, and why.
        """

    @property
    def method(self) -> str:
        """The method by which it was fitted."""
    @property
    def inputs(self) -> list[str]:
        """The names of the inputs in order."""
    @property
    def outputs(self) -> list[str]:
        """The names of the outputs in order."""
    @property
    def units(self) -> dict[str, str]:
        """The SI units of inputs and outputs."""
    @property
    def has_memory(self) -> bool:
        """True if a prediction depends on the states of a run before it."""
    def predict(self, inputs: Any, *, level: float = 0.9, runs: npt.ArrayLike | None = None) -> dict[str, Any]:
        """Predicts states from a data set, from a table, dict or frame with the inputs as columns, or from an array of rows.

        The answer has `outputs`, with the `mean` of each, the ends `lower` and `upper` of the interval that should contain the share `level`
        of the observations of new runs, and the `standard_deviation` (NaN for a method without intervals); and `outside`, which is true
        for states beyond the range of the training. `runs` tells which run each row belongs to, for a surrogate with memory: rows with
        the same number that follow each other; without it each row is a run of its own.
        """

    def means(self, inputs: Any, *, runs: npt.ArrayLike | None = None) -> _Reals:
        """The means alone, which networks, regressions, trees and cascades give in less time: a row for each state, a column for each output."""

    def score(self, dataset: Dataset) -> dict[str, float]:
        """How well it predicts a data set: `relative_rmse`, `r2`, `rmse` and the number of `states`."""
    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> Any: ...

@final
class Family:
    """A family of tests with its fitted surrogate."""

    def __new__(cls, name: str, path: str | None = None) -> Family: ...
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def path(self) -> str:
        """The path of its tests."""
    @property
    def title(self) -> str:
        """What it is of."""
    @property
    def runs(self) -> int:
        """Number of the runs to which it was fitted."""
    @property
    def inputs(self) -> dict[str, dict[str, Any]]:
        """The inputs by name: `meaning`, whether it is `required`, and the `range` of the runs."""
    @property
    def limits(self) -> list[str]:
        """What it cannot answer."""
    def export_onnx(self, path: _Path, *, level: float = 0.9, force: bool = False) -> None:
        """Writes it as an ONNX file, which other programs evaluate without granum. The inputs are the coordinate and all inputs of the family, each of
        which must be given, and the outputs those of `Surrogate.export_onnx`: they are what `predict` says of such inputs at a point of the coordinate.
        """
    def predict(self, inputs: Mapping[str, keys.Quantity], *, level: float = 0.9) -> dict[str, Any]:
        """Predicts the curves of a test. Properties of the grains that are not given are integrated over their ranges; what is not given of the sample
        has typical values, whose uncertainty widens the intervals.

        The answer has `coordinate` and its `points`; `curves`, which has for each output its `mean` and the ends `lower` and `upper` of the
        interval of the given `level`; the `inputs` that were given, the `typical_inputs`, the ranges of the `integrated_inputs`, and the names of
        those `outside` the range of the runs; and as `unseen_combination` the names of two inputs that the runs do not have together, or `None`.
        """
    def _repr_html_(self) -> str: ...
    def __reduce__(self) -> Any: ...

def families() -> list[tuple[str, str]]:
    """The names and paths of the families whose surrogates come with granum."""

def methods() -> dict[str, str]:
    """The methods by which surrogates are fitted, with what they are."""

def fit(
    dataset: Dataset,
    inputs: str | Iterable[str],
    outputs: str | Iterable[str],
    *,
    method: str = "feed-forward",
    coordinate: str | None = None,
    seed: SupportsIndex | None = None,
    hidden: Sequence[int] | None = None,
    threads: SupportsIndex | None = None,
    on_progress: Callable[[dict[str, Any]], object] | None = None,
) -> Surrogate:
    """Fits a surrogate to all states of a data set; `methods()` lists the methods.

    `inputs` and `outputs` are columns, with the rules of `Dataset.expand`. `coordinate` is the input along which a test runs. `hidden` are
    the numbers of neurons of the hidden layers of networks. The result depends on the data set and `seed` (1), not on `threads`.
    `on_progress` is called as in `granum.run`.
    """

def view_colours() -> list[str]:
    """The quantities of grains by which a view colours them."""

def view_page(
    of: Assembly,
    *,
    title: str | None,
    colour: str,
    values: list[float] | None,
    opacity: float,
    forces: bool,
    chains: bool,
    cracks: bool,
    strongest: int,
) -> str:
    """The page that shows an assembly; grains are coloured by a quantity, or by values of which there is one for each."""

def schema() -> dict[str, Any]:
    """The JSON schema of a case file."""

def template() -> str:
    """A commented case file with every key."""

def paths() -> dict[str, dict[str, Any]]:
    """The named paths: what each does (`help`), and its `parameters` with their meanings."""

def prepare(
    case: Case | Mapping[str, Any] | _Path,
    *,
    packing: _Path | None = None,
    out: _Path | None = None,
    threads: SupportsIndex | None = None,
    checkpoint_every: keys.Quantity | None = None,
    on_progress: Callable[[dict[str, Any]], object] | None = None,
    force: bool = False,
) -> Run:
    """Prepares the sample of a case, in the folder `out` or, without one, in a temporary folder that lives as long as the run.

    `packing` is a file of grains that take the place of the random insertion. Results do not depend on `threads`. `checkpoint_every` are
    seconds. `on_progress` is called about ten times a second with a dict; if it returns `False`, the preparation stops in good order. With
    `force` a run that is in the folder is replaced. Ctrl-C stops in good order too, and `granum.resume` goes on, if there is a folder `out`.
    """

def run(
    case: Case | Mapping[str, Any] | _Path,
    sample: Run | _Path | None = None,
    *,
    path: str | Sequence[keys.Stage] | None = None,
    packing: _Path | None = None,
    out: _Path | None = None,
    threads: SupportsIndex | None = None,
    checkpoint_every: keys.Quantity | None = None,
    sensors: Iterable[str | Sensor] | None = None,
    on_state: Callable[[dict[str, float]], object] | None = None,
    on_progress: Callable[[dict[str, Any]], object] | None = None,
    force: bool = False,
    **parameters: Any,
) -> Run:
    """Carries out the test of a case, or a named `path` with its `parameters`, or a list of stages, in the folder `out` or in memory.

    `sample` is what `prepare` returned or the folder that it wrote; without it the sample is prepared first. `on_state` is called with the
    values of the columns of each state that is recorded; if it returns `False`, the test stops in good order. `sensors` are recorded with
    the rest, as those that `recording.sensors` names: names, and sensors of one's own (`granum.Sensor`). The other arguments are those of
    `prepare`. What `on_state` and `on_progress` raise is raised after the run was stopped in good order; what a sensor raises ends the run
    at its last checkpoint, from which `granum.resume` goes on.
    """

def resume(
    folder: Run | _Path,
    *,
    threads: SupportsIndex | None = None,
    checkpoint_every: keys.Quantity | None = None,
    sensors: Iterable[str | Sensor] | None = None,
    on_state: Callable[[dict[str, float]], object] | None = None,
    on_progress: Callable[[dict[str, Any]], object] | None = None,
) -> Run:
    """Continues a run that was interrupted or killed, to the bits of one that was not. A finished run is returned as it is.

    A run needs nothing outside its folder once it has begun: the sample from which it began may be gone. Sensors of one's own that the run
    records have to be given again as `sensors`.
    """

def open(folder: _Path) -> Run:
    """The run in a folder, also while another process writes it."""

@overload
def measure(
    positions: npt.ArrayLike,
    radii: npt.ArrayLike,
    contacts: npt.ArrayLike | None = None,
    forces: npt.ArrayLike | None = None,
    cell: npt.ArrayLike | None = None,
) -> dict[str, float]:
    """The values of every sensor for which arrays of anyone suffice, by column.

    `positions` are rows of three, `radii` one a grain, `contacts` rows of the indices, from 0, of two grains, `forces` the force on the
    first grain of each contact (without `contacts` grains that overlap touch), and `cell` three lengths of a periodic cell or the matrix whose columns are its edges. All in SI units, or
    in a consistent system of units.
    """

@overload
def measure(
    positions: Assembly, radii: None = None, contacts: None = None, forces: None = None, cell: None = None
) -> dict[str, float]:
    """The values of every sensor for which an assembly suffices, by column."""

@overload
def measure(
    positions: Sequence[Assembly], radii: None = None, contacts: None = None, forces: None = None, cell: None = None
) -> Table:
    """The values of every sensor for which several instants suffice, as a table with a row for each."""

def read(
    *paths: _Path,
    cell: npt.ArrayLike | Sequence[keys.Quantity] | None = None,
    density: keys.Quantity | None = None,
    time_step: keys.Quantity | None = None,
    columns: Mapping[str, Sequence[str]] | None = None,
    case: Case | Mapping[str, Any] | _Path | None = None,
    allow_outside: bool = False,
    pairs_apart: Literal["contacts", "no-contacts"] | None = None,
    missing_pairs: Literal["no-contacts", "without-force"] | None = None,
    contact_forces: Literal["as-given", "reversed"] | None = None,
    repeated_pairs: Literal["first", "sum"] | None = None,
    separate_spheres: bool = False,
    masses_add_up: bool = False,
) -> list[Assembly]:
    """Reads results of other programs, as `granum measure` does: an assembly for each instant.

    These are dumps and data files of LAMMPS and LIGGGHTS, texts and VTK of YADE, `.data`, `.fstat` and restart files of MercuryDPM, extended
    XYZ, GSD, packings, and tables (CSV, Parquet) of grains and of contacts. Files that belong together are joined. Everything is in SI units,
    or in a consistent system of units.

    What files do not say can be given: three lengths of a periodic `cell` or the matrix whose columns are its edges, the `density` of
    the grains, the `time_step` between numbered steps, and names of the `columns` of a file whose head has none of use, by the name of
    the file (`-` for what is to be passed over). Grains whose file has no contacts touch where they overlap; with a `case` the contact law
    gives the forces of a packing. With `allow_outside` a file may name files outside its own folder.

    A table of contacts is held against the grains beside it. What was set right is in `remarks` of the assembly; what is doubtful is also a
    `granum.RunWarning`. What cannot be decided is refused, until its owner says what pairs are that do not touch (`pairs_apart`: `"contacts"`
    or `"no-contacts"`), what pairs are that overlap and are missing (`missing_pairs`: `"no-contacts"` or `"without-force"`), what forces are
    that pull everywhere (`contact_forces`: `"as-given"` or `"reversed"`), and what rows of one pair with different forces are
    (`repeated_pairs`: `"first"` or `"sum"`).

    Spheres that a file puts into one molecule, clump or body are one grain, with `separate_spheres` each a grain of its own. The mass of such a grain
    is that of the union of its spheres, with `masses_add_up` the sum of theirs.
    """

def write(
    path: _Path, data: Assembly | Sequence[Assembly] | Run | Table, *, format: str | None = None, force: bool = False
) -> None:
    """Writes grains and contacts for other programs, as `granum export` does: VTP, extended XYZ, GSD, LAMMPS data, CSV and Parquet.

    The name of the file says the format, or `format` does (`"lammps-data"`). Several assemblies are instants of one file, where the format has
    them. As CSV an assembly is written as a packing and as Parquet as the table of its grains, with the cell in the metadata of the file, but neither
    time nor names of materials. A run is written as its series to these two, and otherwise as its last state. With `force` an existing file is replaced.
    """

def pair(
    path: Table | Mapping[str, Any] | _Path,
    case: Case | Mapping[str, Any] | _Path | None = None,
    *,
    normal: Callable[[float, list[float]], Any] | None = None,
    tangential: Callable[[list[float], list[float], float, float, list[float]], Any] | None = None,
) -> Table:
    """Moves two equal grains along a path and gives the forces between them, as `granum pair`.

    `path` has the columns `normal_approach` (the overlap) and `tangential_displacement`, m, or is a file with them; the answer is the same
    table with `normal_force` (N, compression positive), `tangential_force` (N, positive where it resists an increasing displacement) and
    `contact_radius` (m). Between rows the grains move along a straight line, in steps whose number is doubled until no force changes by more
    than 1e-5 of the largest of its kind. Laws and grains are those of the `case`.

    A law can be a function instead, for a pair alone. `normal(overlap, kept)` returns the normal force, N, or a dict with `force`, `radius` of
    the contact area (m; by default that of Hertz) and `kept`, at most four numbers that it is given in the next step, zero for a new
    contact. A pair touches where grains overlap or the force is not zero. `tangential(force, slip, normal_force, radius, kept)` is called
    while the pair touches, with the two components in the plane of contact of the force on the first grain, N, and of the displacement of the
    second grain in this step, m. It returns the two components of the new force, or a dict with `force` and `kept`, at most eight numbers.
    Each is called once a step, with steps before it repeated as they become finer.
    """

@final
class _CampaignFolder:
    def __new__(cls, case: Case, plan: Mapping[str, Any], folder: _Path) -> _CampaignFolder: ...
    @classmethod
    def open(cls, folder: _Path) -> _CampaignFolder: ...
    @property
    def path(self) -> pathlib.Path: ...
    @property
    def case(self) -> Case: ...
    @property
    def plan(self) -> str: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def is_done(self) -> bool: ...
    @property
    def remarks(self) -> dict[str, str]: ...
    def case_of(self, name: str) -> Case: ...
    def run(self, name: str) -> Run: ...
    def table(self) -> Table: ...
    def carry_out(
        self,
        program: _Path,
        *,
        workers: SupportsIndex | None = None,
        stop_after: Any = None,
        again: bool = False,
        force: bool = False,
        on_progress: Callable[[dict[str, Any]], object] | None = None,
    ) -> bool: ...

def _entered() -> None: ...
def _forked() -> None: ...
def _mistake(simulation: Simulation | None = None) -> NoReturn: ...
def _program(arguments: Sequence[str], starts: _Path | None = None) -> int: ...
def _write_grainlearning(path: _Path, folder: _Path, states: SupportsIndex | None = None, force: bool = False) -> list[str]: ...
