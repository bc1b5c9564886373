"""Tables of granum as objects of other packages, each of which is imported where it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._granum import Table


def to_pandas(table: Table) -> Any:
    """A DataFrame with the units and the meanings of its columns in `attrs`."""
    import pandas  # type: ignore[import-untyped]

    frame = pandas.DataFrame(table.to_dict(), copy=False)
    frame.attrs["units"] = table.units
    frame.attrs["descriptions"] = table.descriptions
    return frame


def to_polars(table: Table) -> Any:
    """A DataFrame of polars, whose columns of real numbers are those of the table."""
    import polars

    return polars.DataFrame(table)


def _attributes(table: Table, name: str) -> dict[str, str]:
    found = {"units": table.units[name] or "1"}
    description = table.descriptions.get(name)
    if description:
        found["description"] = description
    return found


def to_xarray(table: Table) -> Any:
    """A Dataset with units and meanings as attributes; of a histogram with the dimensions `row` of the states and that of the bins."""
    import numpy
    import xarray

    if {"bin_width", "count", "probability_density"} <= set(table.columns):
        return _histogram(table)
    variables = {name: ("row", table[name], _attributes(table, name)) for name in table.columns}
    keys = [name for name in ("stage", "state", "run") if name in variables]
    coordinates = {name: variables.pop(name) for name in keys}
    return xarray.Dataset(variables, coords={"row": numpy.arange(len(table)), **coordinates})


def to_torch(values: Any) -> Any:
    """A tensor that shares the memory of an array of NumPy, and must not be written to if the array must not."""
    import importlib
    import warnings

    try:
        torch = importlib.import_module("torch")
    except ImportError as error:
        raise ImportError("tensors need torch: pip install torch") from error
    with warnings.catch_warnings():
        # What torch says of an array that is not to be written to is said in the description of `Dataset.tensor`.
        warnings.filterwarnings("ignore", message=".*not writable.*", category=UserWarning)
        return torch.from_numpy(values)


def _histogram(table: Table) -> Any:
    """The bins of all states side by side: a bin that a state does not have is empty."""
    import numpy
    import xarray

    places = {name: place for place, name in enumerate(table.columns)}
    quantity = table.columns[places["bin_width"] - 1]
    keys = [name for name in table.columns if places[name] < places[quantity]]
    of_states, first, state = numpy.unique(
        numpy.column_stack([table[name] for name in keys if name in ("stage", "state")]), axis=0, return_index=True, return_inverse=True
    )
    centres, bin_ = numpy.unique(table[quantity], return_inverse=True)
    variables: dict[str, Any] = {}
    for name in ("count", "probability_density"):
        values = numpy.zeros((len(of_states), len(centres)))
        values[state.ravel(), bin_.ravel()] = table[name]
        variables[name] = (("row", quantity), values, _attributes(table, name))
    variables["bin_width"] = ("row", table["bin_width"][first], _attributes(table, "bin_width"))
    coordinates: dict[str, Any] = {name: ("row", table[name][first], _attributes(table, name)) for name in keys}
    coordinates["row"] = numpy.arange(len(of_states))
    coordinates[quantity] = (quantity, centres, _attributes(table, quantity))
    return xarray.Dataset(variables, coords=coordinates)
