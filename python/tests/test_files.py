"""Files of other programs: what granum reads and writes of them is what the program does."""

import importlib
import importlib.util
import json
import pathlib
import subprocess
import sys
import types
import warnings
from typing import Any

import granum
import numpy as np
import pytest

FILES = pathlib.Path(__file__).parent.parent.parent / "crates" / "granum-io" / "tests" / "results"
LAMMPS = [FILES / "lammps" / "grains.dump", FILES / "lammps" / "contacts.dump"]
COLUMNS = "index,patom1,patom2,fx,fy,fz,p1,p2,p3,p10,p11,p12"


def program(*words: Any) -> Any:
    """What the program answers."""
    done = subprocess.run([sys.executable, "-m", "granum", *map(str, words), "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def stress(assembly: granum.Assembly) -> Any:
    """Stress, Pa, of the forces of the contacts."""
    return -(assembly.branches.T @ assembly.forces) / assembly.volume


def test_a_run_of_lammps_has_the_stress_that_lammps_wrote() -> None:
    instants = granum.read(*LAMMPS, columns={str(LAMMPS[1]): COLUMNS.split(",")})
    pressure = np.loadtxt(FILES / "lammps" / "pressure.txt")
    assert [instant.step for instant in instants] == pressure[:, 0].astype(int).tolist()
    for instant, line in zip(instants, pressure):
        assert np.allclose(stress(instant).diagonal(), line[1:4], rtol=1e-12)
    # Arrays of one instant, the instant and all of them give the same values as the program does.
    last = instants[-1]
    series = granum.measure(instants)
    alone = granum.measure(last)
    told = program("measure", *LAMMPS, "--columns", f"{LAMMPS[1]}={COLUMNS}")["values"]
    assert set(series.columns) == set(told) and len(series) == len(instants) == 3
    assert all(np.array_equal(series[name], told[name]) for name in told)
    assert series.units["mean_stress"] == "Pa" and all(alone[name] == series[name][-1] for name in alone if name in told)
    arrays = granum.measure(last.positions, last.radii, last.contacts, last.forces, last.cell)
    assert np.isclose(arrays["mean_stress"], alone["mean_stress"], rtol=1e-12)


def test_what_a_file_does_not_have_is_not_invented() -> None:
    (instant,) = granum.read(LAMMPS[0])[-1:]
    assert "cell" in instant.parts and "time" not in instant.parts and "normal forces" not in instant.parts
    # Contacts follow from places and radii, forces do not.
    assert len(instant.contacts) == len(instant.overlaps) > 0
    for name in ("velocities", "time", "forces", "sliding"):
        with pytest.raises(AttributeError, match="these data have no .*; they have cell, positions, radii"):
            getattr(instant, name)
        assert not hasattr(instant, name)
    assert "velocity_x" not in instant.grains_table() and "radius" in instant.grains_table()
    with pytest.raises(granum.RunError, match=r"no .*granum\.measure"):
        granum.Recorder().record(instant)
    # Its time follows from its step, if someone knows how long a step is.
    (timed,) = granum.read(LAMMPS[0], time_step="2 us")[-1:]
    assert timed.time == pytest.approx(2e-6 * timed.step)
    assert granum.view(instant).html.count(f"{len(instant.contacts)} contacts without forces") == 1


def test_spheres_of_a_molecule_are_one_grain_or_several(tmp_path: pathlib.Path) -> None:
    # A dump of two molecules of two overlapping spheres each.
    rows = ["1 1 1 0.3 0.3 0.3 0.1 1.0", "2 1 1 0.4 0.3 0.3 0.1 1.0", "3 2 1 0.7 0.7 0.7 0.1 1.0", "4 2 1 0.8 0.7 0.7 0.1 1.0"]
    bounds = "ITEM: BOX BOUNDS pp pp pp\n" + "0 1\n" * 3
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n4\n{bounds}ITEM: ATOMS id mol type x y z radius mass\n"
    (tmp_path / "grains.dump").write_text(head + "\n".join(rows) + "\n")

    def read(**words: bool) -> granum.Assembly:
        (instant,) = granum.read(tmp_path / "grains.dump", **words)  # type: ignore[arg-type]
        return instant

    assert len(read().radii) == 2 and np.bincount(read().piece_grains).tolist() == [2, 2]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert len(read(separate_spheres=True).radii) == 4
    assert any("each is taken as a grain of its own" in str(one.message) for one in told)
    union, total = read().masses, read(masses_add_up=True).masses
    # The spheres overlap, so that their union is lighter.
    assert np.allclose(total, 2.0) and (union < 1.9).all() and (union > 1.5).all()


@pytest.mark.parametrize(
    "files",
    [
        ["yade/packing.txt"],
        ["liggghts/grains.dump"],
        ["mercury/box.data", "mercury/box.fstat"],
        ["liggghts/grains-6000.vtp", "liggghts/contacts-6000.vtp", "liggghts/grains-boundingBox_6000.vtr"],
        ["yade/spheres.vtk", "yade/contacts.vtk", "yade/cell.vtk"],
    ],
)
def test_files_of_each_program_are_measured_as_the_program_does(files: list[str]) -> None:
    paths = [FILES / file for file in files]
    found = granum.read(*paths)
    assert "positions" in found[0].parts and len(found[0].radii) > 1
    measured: Any = granum.measure(found) if len(found) > 1 else granum.measure(found[0])
    told = program("measure", *paths)["values"]
    assert set(measured) == set(told)
    assert all(np.array_equal(measured[name], told[name]) for name in told)


def test_a_packing_touches_where_grains_overlap(tested: granum.Run, tmp_path: pathlib.Path) -> None:
    path = tmp_path / "packing.csv"
    granum.write(path, tested.snapshot())
    (alone,) = granum.read(path)
    assert "overlaps" in alone.parts and "normal forces" not in alone.parts
    assert len(alone.contacts) > 60 and np.allclose(np.sort(alone.radii), np.sort(tested.snapshot().radii), rtol=1e-12)
    smooth = tested.case.with_values({"grains.material.friction": 0})
    (loaded,) = granum.read(path, case=smooth)
    assert np.array_equal(loaded.positions, alone.positions) and loaded.normal_forces.max() > 0
    smooth_toml = tmp_path / "smooth.toml"
    smooth_toml.write_text(smooth.to_toml())
    assert program("measure", path, "--case", smooth_toml)["values"] == loaded.measure()


@pytest.mark.parametrize("name", ["grains.vtp", "grains.xyz", "grains.gsd", "grains.data", "grains.parquet", "grains.csv"])
def test_what_is_written_is_read_again(tested: granum.Run, tmp_path: pathlib.Path, name: str) -> None:
    assembly, path = tested.snapshot(), tmp_path / name
    granum.write(path, assembly)
    extra: dict[str, Any] = {"cell": assembly.cell} if name in ("grains.parquet", "grains.vtp") else {}
    (found,) = granum.read(path, **extra)
    rtol = 1e-6 if name == "grains.gsd" else 1e-12
    # A corner of a periodic cell may be at another place, and formats have single precision.
    assert np.allclose(found.radii, assembly.radii, rtol=rtol)
    shift = (found.positions + found.origin - assembly.positions) / np.diag(assembly.cell)
    shift -= shift[0]
    assert np.abs(shift - np.round(shift)).max() < 1e-5
    with pytest.raises(granum.FileError, match="force=True"):
        granum.write(path, assembly)
    granum.write(path, assembly, force=True)


def test_instants_tables_and_runs_are_written(tested: granum.Run, tmp_path: pathlib.Path) -> None:
    simulation = tested.simulation()
    instants = [simulation.assembly()]
    simulation.advance(20)
    instants.append(simulation.assembly())
    granum.write(tmp_path / "two.xyz", instants)
    assert len(granum.read(tmp_path / "two.xyz")) == 2
    with pytest.raises(granum.FileError, match="holds one instant, and these are 2"):
        granum.write(tmp_path / "two.vtp", instants)
    granum.write(tmp_path / "series.csv", tested)
    granum.write(tmp_path / "table.csv", tested.series)
    assert (tmp_path / "series.csv").read_bytes() == (tmp_path / "table.csv").read_bytes()
    granum.write(tmp_path / "spheres", tested, format="lammps-data")
    assert len(granum.read(tmp_path / "spheres")[0].radii) == 60
    with pytest.raises(granum.FileError, match="no format that granum writes is called"):
        granum.write(tmp_path / "x", tested, format="word")
    with pytest.raises(granum.FileError, match="it must end in"):
        granum.write(tmp_path / "x.doc", tested)
    wrong: Any = 3
    with pytest.raises(TypeError, match="a run or a table is written, not int"):
        granum.write(tmp_path / "x.vtp", wrong)


def test_a_table_of_contacts_is_held_against_its_grains(tmp_path: pathlib.Path) -> None:
    grains, contacts = tmp_path / "grains.csv", tmp_path / "contacts.csv"
    grains.write_text("x,y,z,radius,vx,vy,vz\n2,5,5,1,0,0,0\n3.95,5,5,1,0,0,0\n6.5,5,5,1,0,0,0\n")
    contacts.write_text("first,second,force_x,force_y,force_z\n1,2,-3,0,0\n2,1,3,0,0\n2,3,0,0,0\n")
    (pair,) = granum.read(grains, contacts)
    assert pair.normal_forces.tolist() == [3.0]
    assert ["1 row repeats" in pair.remarks[0], "1 pair of 2" in pair.remarks[1]] == [True, True]
    contacts.write_text("first,second,force_x,force_y,force_z\n1,2,3,0,0\n")
    with pytest.raises(granum.FileError, match="every pair that overlaps is in tension"):
        granum.read(grains, contacts)
    (turned,) = granum.read(grains, contacts, contact_forces="reversed")
    assert turned.normal_forces.tolist() == [3.0]
    with pytest.warns(granum.RunWarning, match="the forces count as they are"):
        (pulled,) = granum.read(grains, contacts, contact_forces="as-given")
    assert pulled.normal_forces.tolist() == [-3.0]
    wrong: Any = "right"
    with pytest.raises(granum.CaseError, match="possible are first and sum"):
        granum.read(grains, contacts, repeated_pairs=wrong)


def test_arrays_of_anyone_become_an_assembly(tmp_path: pathlib.Path) -> None:
    positions, radii = [[2.0, 5, 5], [3.95, 5, 5]], [1.0, 1.0]
    pair = granum.Assembly(positions, radii, [[0, 1]], [[-3.0, 0, 0]], [10, 10, 10])
    assert pair.normal_forces.tolist() == [3.0] and pair.volume == 1000.0
    assert pair.measure() == granum.measure(positions, radii, [[0, 1]], [[-3.0, 0, 0]], [10, 10, 10])
    granum.write(tmp_path / "pair.csv", pair)
    assert granum.read(tmp_path / "pair.csv")[0].contacts.tolist() == [[0, 1]]
    with pytest.raises(granum.FileError, match="has no cell"):
        granum.write(tmp_path / "bare.csv", granum.Assembly(positions, radii))
    assert granum.Assembly(positions, radii).parts == ["positions", "radii", "contacts", "overlaps"]
    granum.write(tmp_path / "pair.parquet", pair)
    assert granum.Table.read(tmp_path / "pair.parquet").columns == ["id", "position_x", "position_y", "position_z", "radius"]
    # The metadata of the file hold the cell.
    again = granum.read(tmp_path / "pair.parquet")[0]
    assert np.array_equal(again.cell, pair.cell) and again.measure()["solid_fraction"] == pair.measure()["solid_fraction"]
    with pytest.raises(granum.CaseError, match="there are no grains"):
        granum.Assembly(np.empty((0, 3)), [])


def test_mistakes_are_those_of_the_program(tmp_path: pathlib.Path) -> None:
    with pytest.raises(granum.FileError, match="missing.dump"):
        granum.read(tmp_path / "missing.dump")
    with pytest.raises(TypeError, match="needs the name of a file"):
        granum.read()
    with pytest.raises(granum.CaseError, match="is a folder; granum.open"):
        granum.read(tmp_path)
    with pytest.raises(granum.CaseError, match="none of the files") as caught:
        granum.read(LAMMPS[0], columns={"other": ["x"]})
    assert caught.value.key == "columns"
    wrong: list[dict[str, Any]] = [{"density": -1}, {"time_step": "0 s"}, {"density": "3 m"}, {"cell": "2 mm"}, {"cell": 3}, {"cell": ["2 mm", "2 mm", "2 s"]}]
    for keywords in wrong:
        with pytest.raises(granum.CaseError) as caught:
            granum.read(LAMMPS[0], **keywords)
        assert caught.value.key == next(iter(keywords))
    (tmp_path / "table.csv").write_text("id,position_x,position_y,position_z,radius\n1,1,1,1,0.5\n2,1.9,1,1,0.5\n")
    (found,) = granum.read(tmp_path / "table.csv", cell=["300 cm", 3, "3 m"])
    assert found.cell.tolist() == [[3, 0, 0], [0, 3, 0], [0, 0, 3]]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> granum.Campaign:
    """Four drained tests, of two frictions and two pressures."""
    from conftest import SMALL

    case = granum.Case(**{**SMALL, "shear": {"inertial_number": 0.01}}).with_path("drained-triaxial", axial_strain=0.01, states=6)
    loose = [f"{name} < 1" for name in (
        "inertial_number", "unbalanced_force", "servo_error_rms", "servo_error_largest", "mean_stress_lost", "largest_overlap", "energy_gap",
    )]  # fmt: skip
    study = granum.Campaign(
        case, tmp_path_factory.mktemp("campaign") / "study", friction=[0.2, 0.4],
        pressure=granum.campaigns.choice(["50 kPa", "100 kPa"], key="preparation.mean_stress"), accept=loose,
    )  # fmt: skip
    return study.run()


def test_the_layout_of_grainlearning_is_written_and_read(campaign: granum.Campaign, tmp_path: pathlib.Path) -> None:
    pytest.importorskip("h5py")
    path = tmp_path / "study.hdf5"
    granum.grainlearning.write(path, campaign)
    data = granum.grainlearning.read(path)
    assert len(data.runs) == 4 and data.runs[0] == "100000/drained/1"
    own, key = campaign.dataset(), ["grains.material.friction", "preparation.mean_stress"]
    # Runs are in the order of their pressures, and as long as the shortest one.
    of_own = {tuple(own.values(key)[own.groups == k][0]): own.groups == k for k in range(4)}
    assert len(of_own) == 4 and {"axial_strain", "void_ratio", "mean_stress", "deviator_stress"} <= set(data.columns)
    for k in range(4):
        rows = data.groups == k
        same = of_own[tuple(data.values(key)[rows][0])]
        for name in data.columns:
            if name in own:
                # Stresses were kept in MPa.
                assert np.allclose(data[name][rows], own[name][same][: rows.sum()], rtol=1e-15, atol=0), name
    assert data.units["mean_stress"] == "Pa"
    with pytest.raises(granum.FileError, match="force=True"):
        granum.grainlearning.write(path, campaign)
    with pytest.raises(granum.FileError, match="neither a campaign nor its data set"):
        granum.grainlearning.write(tmp_path / "other.hdf5", tmp_path)
    (tmp_path / "text.hdf5").write_text("no HDF5")
    with pytest.raises(granum.FileError, match="layout of GrainLearning"):
        granum.grainlearning.read(tmp_path / "text.hdf5")


@pytest.mark.filterwarnings("ignore:No .* specified in config")
def test_grainlearning_itself_reads_it(campaign: granum.Campaign, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("grainlearning", reason="GrainLearning needs NumPy 1 and has an environment of its own in scripts/python")
    pytest.importorskip("h5py")
    granum.grainlearning.write(tmp_path / "study.hdf5", campaign)
    preprocessor = reader(monkeypatch)
    config = {"raw_data": str(tmp_path / "study.hdf5"), "train_frac": 0.5, "val_frac": 0.25, "window_size": 2, "window_step": 1, "add_e0": True}
    reads = preprocessor.PreprocessorTriaxialCompression(**config)
    import h5py  # type: ignore[import-untyped]

    with h5py.File(tmp_path / "study.hdf5") as file:
        inputs, outputs, contacts = reads._merge_datasets(file)
    contacts = reads._add_e0_to_contacts(contacts, outputs)
    states = inputs.shape[1]
    assert inputs.shape == (4, states, 3) and outputs.shape[:2] == (4, states) and states > 2
    # Friction, pressure in MPa, 1 for drained, and the void ratio at the start.
    assert sorted(map(tuple, contacts[:, :3].round(12))) == [(0.2, 0.05, 1), (0.2, 0.1, 1), (0.4, 0.05, 1), (0.4, 0.1, 1)]
    data = granum.grainlearning.read(tmp_path / "study.hdf5")
    assert np.array_equal(contacts[:, 3], data["void_ratio"].reshape(4, states)[:, 0])
    assert np.array_equal(inputs.reshape(-1, 3), data.values(["axial_strain", "lateral_strain_2", "lateral_strain_3"]))
    if hasattr(preprocessor.tf, "gather"):
        splits, about = reads.prepare_datasets()
        assert set(splits) == {"train", "val", "test"} and about["num_params"] == 4


def reader(monkeypatch: pytest.MonkeyPatch) -> Any:
    """GrainLearning's module that reads the layout. TensorFlow, which learns from it and is large, is replaced where it is not installed."""
    if importlib.util.find_spec("tensorflow") is None:
        absent: Any = types.ModuleType("tensorflow")
        absent.data = types.SimpleNamespace(Dataset=object)
        absent.keras = types.SimpleNamespace(Model=object)
        monkeypatch.setitem(sys.modules, "tensorflow", absent)
    folder = pathlib.Path(str(importlib.import_module("grainlearning").__file__)).parent / "rnn"
    package = types.ModuleType("grainlearning.rnn")
    package.__path__ = [str(folder)]
    monkeypatch.setitem(sys.modules, "grainlearning.rnn", package)
    return importlib.import_module("grainlearning.rnn.preprocessor")
