"""Data sets, surrogates and campaigns."""

import importlib
import pathlib
import pickle
import subprocess
import sys
from typing import Any

import granum
import numpy as np
import pytest
from conftest import SMALL


def curve(friction: float, rows: int = 30) -> granum.Table:
    """A curve of a made-up test."""
    strain = np.linspace(0.0, 0.1, rows)
    ratio = friction * (1 - np.exp(-50 * strain)) + 1e-3 * np.sin(300 * strain)
    return granum.Table({"arc_length": strain, "friction": np.full(rows, friction), "stress_ratio": ratio}, units={"stress_ratio": ""})


@pytest.fixture(scope="module")
def dataset() -> granum.Dataset:
    """Curves of made-up tests."""
    return granum.Dataset({f"run {k}": curve(0.2 + 0.1 * k) for k in range(6)})


def test_a_dataset_has_the_states_of_its_runs(dataset: granum.Dataset) -> None:
    assert dataset.runs == [f"run {k}" for k in range(6)] and len(dataset) == 180
    assert {"arc_length", "friction", "stress_ratio"} <= set(dataset.columns) == set(dataset) == set(dataset.keys())
    values = dataset.values(["friction", "arc_length"])
    assert values.shape == (180, 2) and np.array_equal(values[:, 0], dataset["friction"])
    assert np.array_equal(np.unique(dataset.groups), range(6)) and np.array_equal(dataset.groups == 2, values[:, 0] == 0.4)
    assert "friction" in dataset and "nothing" not in dataset
    assert len(dataset.table()) == 180 and len(dataset.runs_table()) == 6
    assert dataset.select("run 1").runs == ["run 1"] and dataset.select(["run 1"]) != dataset
    parts = dataset.split(unseen="run 0", stride=3)
    training, unseen, held_out = parts["training"], parts["unseen"], parts["held_out"]
    assert training is not None and unseen is not None and held_out is not None
    assert (len(training), len(held_out), len(unseen)) == (50, 100, 30)
    assert dataset.split(stride=1)["held_out"] is None
    with pytest.raises(KeyError, match="did you mean stress_ratio"):
        dataset["stress_rato"]
    with pytest.raises(KeyError, match="run 1"):
        dataset.select("run 10")
    with pytest.raises(granum.Error, match="did you mean run"):
        dataset.split(unseen=["run10"])
    with pytest.raises(granum.CaseError, match="stride"):
        dataset.split(stride=0)
    with pytest.raises(granum.Error, match="there is no run"):
        granum.Dataset([])
    with pytest.raises(TypeError, match="not int"):
        granum.Dataset([3])  # type: ignore[list-item]


def test_the_name_of_a_folder_is_no_list_of_runs() -> None:
    with pytest.raises(TypeError, match=r"granum\.Dataset\.read\(folder\)"):
        granum.Dataset("data/families/sand")


def test_a_tensor_has_the_memory_of_the_array(dataset: granum.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        torch = importlib.import_module("torch")
    except ImportError:
        # What is handed to torch, where it is not installed.
        monkeypatch.setitem(sys.modules, "torch", type("torch", (), {"from_numpy": staticmethod(lambda array: array)}))
        handed = dataset.tensor(["friction", "arc_length"])
        assert isinstance(handed, np.ndarray) and handed.flags.c_contiguous
        assert np.array_equal(handed, dataset.values(["friction", "arc_length"]))
        monkeypatch.setitem(sys.modules, "torch", None)
        with pytest.raises(ImportError, match="pip install torch"):
            dataset.tensor(["friction"])
        return
    tensor = dataset.tensor(["friction", "arc_length"])
    assert tensor.dtype == torch.float64 and np.array_equal(tensor.numpy(), dataset.values(["friction", "arc_length"]))


def test_runs_in_memory_and_in_folders_give_one_dataset(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    folder = granum.run(case, out=tmp_path / "run")
    both = granum.Dataset({"a": tested, "b": folder})
    assert np.array_equal(both.select("a")["stress_ratio"], both.select("b")["stress_ratio"])
    assert np.all(both["grains.material.friction"] == case["grains.material.friction"])
    assert both.categories["contact.normal"] == [case["contact.normal"]]
    assert granum.Dataset([folder]) == granum.Dataset([tmp_path / "run"]) == granum.Dataset({"run": str(tmp_path / "run")})
    with pytest.raises(granum.FileError):
        granum.Dataset([tmp_path / "missing"])
    with pytest.raises(granum.FileError, match="neither a data set nor a campaign"):
        granum.Dataset.read(tmp_path / "run")


@pytest.mark.parametrize("method", ["ridge", "feed-forward", "gaussian-process"])
def test_a_surrogate_learns_and_predicts_with_intervals(dataset: granum.Dataset, tmp_path: pathlib.Path, method: str) -> None:
    parts = dataset.split(unseen=["run 2"], stride=1)
    training, unseen = parts["training_runs"], parts["unseen"]
    assert training is not None and unseen is not None
    surrogate = granum.surrogates.fit(training, ["friction"], "stress_ratio", coordinate="arc_length", method=method, hidden=[8] if method == "feed-forward" else None)
    assert (surrogate.method, surrogate.inputs, surrogate.outputs) == (method, ["arc_length", "friction"], ["stress_ratio"])
    score = surrogate.score(unseen)
    assert score["states"] == 30 and score["relative_rmse"] < 0.1
    answer = surrogate.predict(unseen, level=0.9)
    found = answer["outputs"]["stress_ratio"]
    assert np.all(found["lower"] <= found["mean"]) and np.all(found["mean"] <= found["upper"]) and np.all(found["lower"][1:] < found["upper"][1:])
    assert np.all(found["standard_deviation"] >= 0)
    assert not answer["outside"].any()
    rows = unseen.values(surrogate.inputs)
    table = {name: unseen[name] for name in reversed(surrogate.inputs)}
    for same in [table, granum.Table(table), rows, np.asfortranarray(rows), rows.tolist()]:
        again = surrogate.predict(same, runs=np.zeros(30))
        assert np.array_equal(again["outputs"]["stress_ratio"]["upper"], found["upper"])
    assert np.allclose(surrogate.means(unseen)[:, 0], found["mean"], rtol=1e-12)
    assert surrogate.predict({"friction": [3.0], "arc_length": [0.0]})["outside"].all()
    surrogate.write(tmp_path / "surrogate.json")
    for same_surrogate in [granum.surrogates.read(tmp_path / "surrogate.json"), pickle.loads(pickle.dumps(surrogate))]:
        assert np.array_equal(same_surrogate.means(unseen), surrogate.means(unseen))
    with pytest.raises(granum.FileError, match="force=True"):
        surrogate.write(tmp_path / "surrogate.json")


@pytest.mark.parametrize(
    ("inputs", "word"),
    [
        ([[0.1]], "a row has 2 values"),
        ([0.1, 0.2], "the shape is"),
        ([[0.1, np.nan]], r"inputs\[0, 1\] is NaN"),
        ({"friction": [0.3]}, "arc_length"),
        ({"friction": [0.3], "arc_length": [np.nan]}, r"arc_length\[0\] is NaN"),
        ({"friction": [0.3], "arc_length": [0.1, 0.2]}, "rows"),
        ({"friction": ["a"], "arc_length": [0.1]}, "real numbers"),
    ],
)
def test_wrong_inputs_are_refused(dataset: granum.Dataset, inputs: Any, word: str) -> None:
    surrogate = granum.surrogates.fit(dataset, ["arc_length", "friction"], "stress_ratio", method="ridge")
    with pytest.raises((granum.CaseError, KeyError), match=word):
        surrogate.predict(inputs)
    with pytest.raises(granum.Error, match="between 0 and 1"):
        surrogate.predict([[0.1, 0.3]], level=1.5)


def test_a_fit_is_refused_stopped_and_told(dataset: granum.Dataset) -> None:
    assert "ridge" in granum.surrogates.methods()
    with pytest.raises(granum.Error, match="did you mean ridge"):
        granum.surrogates.fit(dataset, "friction", "stress_ratio", method="rigde")
    with pytest.raises(granum.Error, match="did you mean stress_ratio"):
        granum.surrogates.fit(dataset, "friction", "stress_rato")
    with pytest.raises(granum.CaseError, match="seed"):
        granum.surrogates.fit(dataset, "friction", "stress_ratio", seed=-1)

    def fails(progress: dict[str, Any]) -> None:
        raise ZeroDivisionError(progress["activity"])

    with pytest.raises(ZeroDivisionError, match="training"):
        granum.surrogates.fit(dataset, "friction", "stress_ratio", on_progress=fails)
    with pytest.raises(granum.RunError, match="stopped"):
        granum.surrogates.fit(dataset, "friction", "stress_ratio", on_progress=lambda progress: False)


@pytest.mark.filterwarnings("ignore:there is no data set:granum.RunWarning")
def test_a_campaign_is_that_of_the_program_and_gives_its_dataset(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("pandas")
    case = granum.Case(**{**SMALL, "recording": {"states": 4}})
    told: list[dict[str, Any]] = []
    pressure = granum.log("20 kPa", "80 kPa", key="preparation.mean_stress")
    campaign = granum.Campaign(case, tmp_path / "python", friction=(0.2, 0.6), pressure=pressure, n=3)
    assert len(campaign) == 3 and not (tmp_path / "python").exists() and not campaign.is_done
    assert "grains.material.friction" in campaign.plan
    table = campaign.table()
    assert list(table["status"]) == ["not begun"] * 3 and np.all((table["friction"] > 0.2) & (table["friction"] < 0.6))
    assert campaign.case_of(campaign.names[0])["grains.material.friction"] == table["friction"][0]
    with pytest.raises(TypeError, match="has not begun"):
        pickle.dumps(campaign)
    assert campaign.run(workers=2, on_progress=told.append) is campaign
    assert campaign.is_done and told and told[-1]["activity"] == "campaign"
    again = granum.Campaign.open(tmp_path / "python")
    assert again.names == campaign.names == pickle.loads(pickle.dumps(campaign)).names
    assert all(again[name].status == "finished" for name in again)
    with pytest.raises(KeyError, match="no run"):
        again["nothing"]
    # The same plan by the program: the same names, the same bits.
    (tmp_path / "case.toml").write_text(case.to_toml())
    (tmp_path / "plan.toml").write_text(campaign.plan)
    line = [sys.executable, "-m", "granum", "campaign", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "program")]
    subprocess.run(line, check=True, capture_output=True)
    program = granum.Campaign.open(tmp_path / "program")
    assert program.names == campaign.names
    assert [program[name].digest() for name in program] == [campaign[name].digest() for name in campaign]
    if campaign.remarks:
        with pytest.raises(granum.FileError, match="no data set"):
            campaign.dataset()
        checks = {check for remark in campaign.remarks.values() for check in remark.split(", ")}
        accepted = [f"{check} < 1e9" for check in checks]
        taken = granum.Campaign(case, tmp_path / "python", friction=(0.2, 0.6), pressure=pressure, n=3, accept=accepted)
        campaign = taken.run()
    dataset = campaign.dataset()
    assert len(dataset.runs) == 3 and sorted(dataset.runs) == sorted(campaign.names)


def test_mistakes_of_a_campaign_are_told(case: granum.Case, tmp_path: pathlib.Path) -> None:
    with pytest.raises(granum.CaseError, match="preparation.mean_stress or shear.mean_stress"):
        granum.Campaign(case, tmp_path / "study", mean_stress=(1e4, 1e5), n=2)
    with pytest.raises(granum.CaseError, match="the variable pressure stands for no key of the case") as caught:
        granum.Campaign(case, tmp_path / "study", pressure=(1e4, 1e5), n=2)
    assert caught.value.key == "pressure" and caught.value.remedy is not None
    with pytest.raises(granum.CaseError, match="fricton stands for no key of the case; did you mean friction"):
        granum.Campaign(case, tmp_path / "study", fricton=(0.1, 0.5), n=2)
    with pytest.raises(granum.CaseError, match="is a length"):
        granum.Campaign(case, tmp_path / "study", friction=("1 mm", "2 mm"), n=2)
    with pytest.raises(granum.CaseError, match="points"):
        granum.Campaign(case, tmp_path / "study", friction=(0.1, 0.2), n=-1)
    with pytest.raises(TypeError, match="not float"):
        granum.Campaign(case, tmp_path / "study", friction=0.3)
    with pytest.raises(TypeError, match="given twice"):
        granum.Campaign(case, tmp_path / "study", variables={"friction": (0.1, 0.2)}, friction=(0.1, 0.2))
    all_ = granum.Campaign(case, tmp_path / "study", friction=[0.1, 0.2], variables={"grains.count": [60, 70]})
    assert len(all_) == 4
    assert not (tmp_path / "study").exists()
    with pytest.raises(granum.FileError, match="not the folder of a campaign|cannot"):
        granum.Campaign.open(tmp_path)
    with pytest.raises(granum.CaseError, match="workers"):
        all_.run(workers=0)


@pytest.mark.filterwarnings("ignore:there is no data set:granum.RunWarning")
def test_a_campaign_stops_in_good_order_and_goes_on(case: granum.Case, tmp_path: pathlib.Path) -> None:
    campaign = granum.Campaign(case, tmp_path / "study", friction=[0.2, 0.3, 0.4])

    def fails(progress: dict[str, Any]) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        campaign.run(on_progress=fails)
    assert not campaign.is_done
    campaign.run(on_progress=lambda progress: False)
    assert not campaign.is_done
    assert campaign.run().is_done


def test_many_rows_are_predicted_as_each_of_them_alone() -> None:
    data = granum.Dataset({f"run {k}": curve(0.2 + 0.1 * k) for k in range(6)})
    surrogate = granum.surrogates.fit(data, ["arc_length", "friction"], "stress_ratio", method="ridge")
    chance = np.random.default_rng(1)
    # More than are predicted at once.
    rows = np.column_stack([chance.uniform(0, 0.1, 40_000), chance.uniform(0.1, 0.9, 40_000)])
    many = surrogate.predict(rows)
    assert np.array_equal(many["outputs"]["stress_ratio"]["mean"], surrogate.means(rows)[:, 0])
    for k in [0, 16_383, 16_384, 39_999]:
        alone = surrogate.predict(rows[k : k + 1])
        assert alone["outside"][0] == many["outside"][k]
        for name, values in alone["outputs"]["stress_ratio"].items():
            assert values[0] == many["outputs"]["stress_ratio"][name][k], name
