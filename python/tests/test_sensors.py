"""Sensors of Python in runs and by hand, and paths that a function steers."""

import pathlib
import threading
from typing import Any

import granum
import numpy as np
import numpy.typing as npt
import pytest

Reals = npt.NDArray[np.float64]


def speeds(assembly: granum.Assembly) -> dict[str, Any]:
    """The largest fluctuating speed, and all of them."""
    found = np.sqrt((assembly.velocities**2).sum(axis=1))
    return {"largest_speed": found.max(), "speeds": found, "grains_seen": len(found)}


def gain(assembly: granum.Assembly, before: Reals) -> tuple[dict[str, float], list[float]]:
    """Contacts that came since the last observation."""
    contacts = len(assembly.contacts)
    return {"contact_gain": contacts - before[0] if len(before) else 0.0}, [contacts, assembly.time]


SPEEDS = granum.Sensor(
    "speeds",
    speeds,
    {"largest_speed": granum.SensorColumn("m/s", "largest speed of a grain", "largest"), "grains_seen": "1"},
    {"speeds": granum.Bins("speed", "m/s", width=1e-4, largest=2e-3)},
)
GAIN = granum.Sensor("gain", gain, {"contact_gain": "1"}, remembers=True)


def test_a_sensor_is_recorded_with_the_rest(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    seen: list[dict[str, float]] = []
    run = granum.run(case, sensors=[SPEEDS, GAIN, "void_ratio"], on_state=seen.append, out=tmp_path / "run")
    series = run.series
    assert [name for name in series.columns if name not in tested.series.columns] == [
        "largest_speed", "grains_seen", "contact_gain", "void_ratio", "speeds_below", "speeds_above",
    ]  # fmt: skip
    # The sensors change nothing else.
    assert all(np.array_equal(series[name], tested.series[name]) for name in tested.series.columns)
    assert series.units["largest_speed"] == "m/s" and set(series["grains_seen"]) == {60.0}
    assert np.array_equal([state["largest_speed"] for state in seen], series["largest_speed"]) and series["largest_speed"].min() > 0
    # The last state ends with the run.
    table = run.table("speeds")
    assert {"state", "speed", "bin_width", "count", "probability_density"} <= set(table.columns) and table.units["speed"] == "m/s"
    counted = np.bincount(table["state"].astype(int), table["count"]) + series["speeds_below"] + series["speeds_above"]
    assert np.array_equal(counted, 60 * series["observations"])
    memory = granum.run(case, sensors=[SPEEDS, GAIN, "void_ratio"], threads=2)
    assert memory.series == series and memory.table("speeds") == table
    # Whoever opens the folder reads it, with or without the sensors.
    opened = granum.open(tmp_path / "run")
    assert opened.series == series and "speeds" in opened.tables and opened.case["recording.sensors"] == '["speeds", "gain", "void_ratio"]'
    assert opened.report().startswith("<!DOCTYPE html>")
    data = granum.Dataset([run])
    assert np.array_equal(data["largest_speed"], series["largest_speed"])


def test_an_observation_shows_the_assembly_of_its_state(case: granum.Case) -> None:
    kept: list[granum.Assembly] = []

    def keep(assembly: granum.Assembly) -> float:
        kept.append(assembly)
        return float(assembly.strain[2, 2])

    once = case.with_values({"recording.observations_per_state": 1})
    run = granum.run(once, sensors=[granum.Sensor("keeper", keep, {"vertical_strain": "1"})])
    assert np.array_equal(run.series["vertical_strain"], [assembly.strain[2, 2] for assembly in kept])
    coordination = [assembly.measure()["coordination_number"] for assembly in kept]
    assert np.array_equal(run.series["coordination_number"], coordination) and len(set(coordination)) > 1


def test_observations_are_reduced_as_a_column_says(case: granum.Case) -> None:
    calls = iter(range(10_000))

    def count(_: granum.Assembly) -> dict[str, float]:
        return dict.fromkeys(columns, next(calls))

    columns = {
        "mean_call": granum.SensorColumn(),
        "rms_call": granum.SensorColumn(averaging="root-mean-square"),
        "last_call": granum.SensorColumn(averaging="largest"),
    }
    series = granum.run(case, sensors=[granum.Sensor("calls", count, columns)]).series
    ends = np.cumsum(series["observations"])
    for k, observations in enumerate(series["observations"]):
        here = np.arange(ends[k] - observations, ends[k])
        assert series["mean_call"][k] == here.mean() and series["last_call"][k] == here[-1]
        assert np.isclose(series["rms_call"][k], np.sqrt((here**2).mean()), rtol=1e-14)
    assert series["observations"].max() > 1


def test_a_run_with_a_sensor_that_remembers_is_resumed_to_the_same_bits(case: granum.Case, tmp_path: pathlib.Path) -> None:
    whole = granum.run(case, sensors=[GAIN], out=tmp_path / "whole")
    assert np.any(whole.series["contact_gain"])
    broken = granum.run(case, sensors=[GAIN], out=tmp_path / "broken", on_state=lambda values: values["state"] < 2)
    assert broken.status == "interrupted"
    with pytest.raises(granum.CaseError, match="gain"):
        granum.resume(broken)
    assert granum.resume(broken, sensors=[GAIN]).digest() == whole.digest()


def test_what_a_sensor_raises_is_raised_and_the_run_can_be_resumed(case: granum.Case, tmp_path: pathlib.Path) -> None:
    whole = granum.run(case, sensors=[GAIN], out=tmp_path / "whole")
    calls = 0

    def fails(assembly: granum.Assembly, before: Reals) -> tuple[dict[str, float], list[float]]:
        nonlocal calls
        calls += 1
        if calls == 12:
            raise ZeroDivisionError("in a sensor of the user")
        return gain(assembly, before)

    with pytest.raises(ZeroDivisionError, match="of the user"):
        granum.run(case, sensors=[GAIN._replace(measure=fails)])
    calls = 0
    with pytest.raises(ZeroDivisionError, match="of the user"):
        granum.run(case, sensors=[GAIN._replace(measure=fails)], out=tmp_path / "run", checkpoint_every=0.01)
    assert granum.open(tmp_path / "run").status == "interrupted"
    assert granum.resume(tmp_path / "run", sensors=[GAIN]).digest() == whole.digest()


@pytest.mark.parametrize(
    ("sensor", "message"),
    [
        (SPEEDS._replace(name="fabric"), "already another of this name"),
        (SPEEDS._replace(name="two words"), "not a word"),
        (SPEEDS._replace(columns={"mean_stress": "Pa"}), "in use with another meaning"),
        (SPEEDS._replace(columns={"a": granum.SensorColumn(averaging="median")}), "mean, root-mean-square or largest"),  # type: ignore[arg-type]
        (SPEEDS._replace(histograms={"forces": granum.Bins("force")}), "in use with another meaning"),
        (SPEEDS._replace(histograms={"speeds": granum.Bins("speed", width=0.0)}), "the width is positive"),
        (SPEEDS._replace(histograms={"speeds": granum.Bins("speed", smallest=2.0)}), "the range rises"),
    ],
)
def test_declarations_that_cannot_be_are_refused(case: granum.Case, sensor: granum.Sensor, message: str) -> None:
    with pytest.raises(granum.CaseError, match=message):
        granum.run(case, sensors=[sensor])


@pytest.mark.parametrize(
    ("answer", "error", "message"),
    [
        (lambda _: None, TypeError, "NoneType, not a dict"),
        (lambda _: {"largest_speed": 1.0}, TypeError, "no grains_seen"),
        (lambda _: {"largest_speed": 1.0, "grains_seen": 1.0, "speeds": [], "other": 1}, TypeError, "other, which is none of its columns"),
        (lambda _: {"largest_speed": "fast", "grains_seen": 1.0, "speeds": []}, TypeError, "str for largest_speed, not a number"),
        (lambda _: {"largest_speed": np.nan, "grains_seen": 1.0, "speeds": []}, granum.CaseError, "NaN, which is not finite"),
        (lambda _: {"largest_speed": 1.0, "grains_seen": 1.0, "speeds": ["a"]}, granum.CaseError, "real numbers are needed"),
    ],
)
def test_answers_that_cannot_be_are_refused(case: granum.Case, answer: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        granum.run(case, sensors=[SPEEDS._replace(measure=answer)])


def test_what_is_no_sensor_is_refused(case: granum.Case) -> None:
    wrong_lists: list[Any] = [3, "speeds", SPEEDS, [3], [None]]
    for wrong in wrong_lists:
        with pytest.raises(TypeError, match="a list of granum.Sensor"):
            granum.run(case, sensors=wrong)
    with pytest.raises(granum.CaseError, match='there is no sensor "void_ration"; did you mean void_ratio') as caught:
        granum.run(case, sensors=["void_ration"])
    assert (caught.value.key, caught.value.value) == ("recording.sensors", "void_ration")
    with pytest.raises(granum.CaseError, match='there is no sensor "fabrik"') as caught:
        granum.run(case.with_values({"recording.sensors": ["coordination", "fabrik"]}))
    assert (caught.value.value, caught.value.remedy) == ("fabrik", "did you mean fabric?")
    with pytest.raises(TypeError, match="no pair"):
        granum.run(case, sensors=[GAIN._replace(measure=lambda assembly, before: 1.0)])


def test_a_recorder_records_what_is_done_by_hand(tested: granum.Run) -> None:
    simulation = tested.simulation()
    recorder = granum.Recorder(sensors=["void_ratio", SPEEDS, GAIN])
    simulation.control(strain_rate={"zz": 20.0}, mean_stress=20e3, rate_limit=100.0)
    measured: list[float] = []
    for _ in range(4):
        recorder.record(simulation)
        measured.append(simulation.assembly().measure()["stress_ratio"])
        simulation.advance(50)
    series = recorder.series
    assert len(recorder) == len(series) == 4 and np.array_equal(series["state"], range(4))
    assert np.array_equal(series["stress_ratio"], measured) and np.any(series["contact_gain"])
    assert series["largest_speed"].min() > 0 and {"forces", "speeds"} <= set(recorder.tables)
    assert len(recorder.table("speeds")) == 4 * 20
    with pytest.raises(KeyError, match="did you mean speeds"):
        recorder.table("speed")
    with pytest.raises(TypeError, match="Simulation or a granum.Assembly"):
        recorder.record(tested)  # type: ignore[arg-type]
    assert granum.Dataset({"by hand": series}).runs == ["by hand"]


def test_a_recorder_is_whole_after_a_sensor_has_raised(tested: granum.Run) -> None:
    answers: list[Any] = [1.0, None, 3.0]
    recorder = granum.Recorder(sensors=[GAIN, granum.Sensor("moody", lambda _: answers[len(recorder)], {"mood": "1"})])
    other = granum.Recorder(sensors=[GAIN])
    assembly = tested.snapshot()
    # A sensor is called while the recorder records, and is told so.
    with pytest.raises(granum.RunError, match="is recording a state"):
        recorder.record(assembly)
    answers_given = iter(answers)
    recorder = granum.Recorder(sensors=[GAIN, granum.Sensor("moody", lambda _: next(answers_given), {"mood": "1"})])
    recorder.record(assembly)
    with pytest.raises(TypeError, match="NoneType"):
        recorder.record(assembly)
    recorder.record(assembly)
    other.record(assembly)
    other.record(assembly)
    assert np.array_equal(recorder.series["mood"], [1.0, 3.0])
    assert np.array_equal(recorder.series["contact_gain"], other.series["contact_gain"])


def test_a_function_steers_a_simulation(tested: granum.Run) -> None:
    def path(simulation: granum.Simulation) -> dict[str, Any] | None:
        if simulation.strain[2, 2] > 0.004:
            return None
        # Less and less confined as it is compressed.
        pressure = 20e3 * (1 - 50 * max(0.0, simulation.strain[2, 2]))
        return {"strain_rate": {"zz": 20.0}, "stress": {"xx": pressure, "yy": pressure}, "rate_limit": 200.0}

    def steered(every: int) -> tuple[granum.Simulation, granum.Recorder, int]:
        simulation, recorder = tested.simulation(), granum.Recorder()
        simulation.control(strain_rate={}, mean_stress=20e3, rate_limit=100.0)
        simulation.advance(500)
        return simulation, recorder, simulation.follow(path, every=every, recorder=recorder, states_every=2)

    simulation, recorder, steps = steered(20)
    series = recorder.series
    assert steps % 20 == 0 and 0.004 < simulation.strain[2, 2] < 0.0045
    assert len(series) == steps // 40 + 1
    # The servo holds what the function asks for.
    fall = series["stress_xx"][-1] / series["stress_xx"][1] if "stress_xx" in series else simulation.stress[0, 0] / 20e3
    assert 0.6 < fall < 0.95
    again, _, more = steered(20)
    assert more == steps and np.array_equal(again.assembly().positions, simulation.assembly().positions)


def test_a_path_that_raises_or_returns_nonsense_leaves_a_whole_simulation(tested: granum.Run) -> None:
    simulation = tested.simulation()
    begin, calls = simulation.step, 0

    def fails(simulation: granum.Simulation) -> dict[str, Any]:
        nonlocal calls
        calls += 1
        if calls > 3:
            raise ZeroDivisionError("of the path")
        return {"strain_rate": {"zz": 1.0}}

    with pytest.raises(ZeroDivisionError, match="of the path"):
        simulation.follow(fails, every=7)
    assert simulation.step == begin + 21
    for answer, error in [(3, TypeError), ({"strain": {}}, TypeError), ({"stress": {"zz": float("nan")}}, granum.CaseError)]:
        with pytest.raises(error):
            simulation.follow(lambda _, answer=answer: answer, every=5)  # type: ignore[misc]
    for every in [0, -1]:
        with pytest.raises(granum.CaseError, match="every"):
            simulation.follow(fails, every=every)
    assert simulation.step == begin + 21
    assert simulation.follow(lambda _: {}, every=10, most_steps=25) == 25 and simulation.step == begin + 46


def test_sensors_in_several_threads_do_not_wait_for_each_other(case: granum.Case) -> None:
    found: list[granum.Run] = []
    threads = [threading.Thread(target=lambda: found.append(granum.run(case, sensors=[SPEEDS], threads=1)), daemon=True) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert len(found) == 3 and all(run.series == found[0].series for run in found)


def test_a_list_of_stages_is_the_test(case: granum.Case, tmp_path: pathlib.Path) -> None:
    stages: list[Any] = [
        {"path": "drained-triaxial", "axial_strain": "0.3 %", "inertial_number": 0.01, "states": 2},
        {"path": "undrained-triaxial", "axial_strain": "0.6 %", "inertial_number": 0.01, "states": 3},
    ]
    run = granum.run(case, path=stages)
    assert list(run.series["stage"]) == [1, 1, 1, 2, 2, 2, 2]
    # As a case that has them from the beginning, with what `[shear]` says about the sample.
    assert run.case == case.with_stages(stages)
    assert case.with_path("drained-triaxial", axial_strain="0.3 %", inertial_number=0.01, states=2) == case.with_stages(stages[:1])
    text = case.with_stages(stages).to_toml()
    assert granum.run(granum.Case.from_toml(text)).series == run.series
    misspelt: Any = {"path": "drained-triaxal"}
    with pytest.raises(granum.CaseError, match="stage") as caught:
        granum.run(case, path=[misspelt])
    assert "drained-triaxial" in str(caught.value)
    for nothing in ([], 3, [3]):
        with pytest.raises((granum.CaseError, TypeError)):
            case.with_stages(nothing)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="axial_strain with a list of stages"):
        granum.run(case, path=stages, axial_strain=0.1)
    with pytest.raises(TypeError, match="follow"):
        granum.run(case, path=lambda simulation: None)  # type: ignore[arg-type]
