"""Sensors of one's own: functions of all grains and contacts whose values are recorded with those of granum's sensors.

>>> import granum
>>> def measure(assembly):
...     speeds = (assembly.velocities**2).sum(axis=1) ** 0.5
...     return {"largest_speed": speeds.max(), "speeds": speeds}
>>> sensor = granum.Sensor("speeds", measure, {"largest_speed": "m/s"}, {"speeds": granum.Bins("speed", "m/s", width=0.01, largest=1.0)})
>>> sensor.columns
{'largest_speed': 'm/s'}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

__all__ = ["Bins", "SensorColumn", "Sensor"]


class SensorColumn(NamedTuple):
    """A column of the series to which a sensor gives a number."""

    unit: str = "1"
    """Its unit; `1` for a pure number."""
    meaning: str = ""
    """What it is, in one line."""
    averaging: Literal["mean", "root-mean-square", "largest"] = "mean"
    """How the observations around a recorded state are reduced to one value."""


class Bins(NamedTuple):
    """The bins of a histogram: all of one width, with one edge at zero."""

    quantity: str
    """What is counted: the name of the column of the centres of the bins."""
    unit: str = "1"
    """Its unit; `1` for a pure number."""
    width: float = 0.1
    """Width of a bin."""
    smallest: float = 0.0
    """Smallest value with a bin of its own. The range is rounded outward to whole bins."""
    largest: float = 1.0
    """Largest value with a bin of its own."""


class Sensor(NamedTuple):
    """A sensor: `granum.run(..., sensors=[...])` and `granum.Recorder` record it with the rest."""

    name: str
    """Its name, a word that no sensor of granum has."""
    measure: Callable[..., Any]
    """Called with a `granum.Assembly` at each observation. It returns a dict with a finite number for each column, and for each histogram an
    array of the values to count, which may be empty; not-a-numbers are not counted. A sensor of one column alone may return the number.

    A sensor that remembers is called with the array that it returned the last time as well, empty at first, and returns a pair: the dict and
    the numbers to remember. They are part of the checkpoint of a run, so that it is resumed to the same bits.
    """
    columns: Mapping[str, str | SensorColumn]
    """Its columns by name, each with its unit or as a `SensorColumn`. The names are words that no other column has."""
    histograms: Mapping[str, Bins] = {}
    """Its histograms by name: each is a table of the run, and the series has the numbers of values outside its bins."""
    remembers: bool = False
    """Whether it compares an observation with the one before."""
    meaning: str = ""
    """What it measures, in one line."""
