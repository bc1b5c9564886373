"""Samples, tests, resuming, observers, threads, and the digests of the program."""

import copy
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time

import granum
import numpy as np
import pytest
from granum._script import script


def granum_program(*arguments: str | pathlib.Path) -> str:
    """The output of the command-line program."""
    line = [sys.executable, "-m", "granum", *map(str, arguments)]
    return subprocess.run(line, check=True, capture_output=True, text=True).stdout


def test_a_run_has_the_digest_of_the_program(case: granum.Case, tmp_path: pathlib.Path) -> None:
    run = granum.run(case, out=tmp_path / "python")
    (tmp_path / "case.toml").write_text(case.to_toml())
    granum_program("run", tmp_path / "case.toml", "--out", tmp_path / "program")
    program = granum.open(tmp_path / "program")
    assert run.digest() == program.digest()
    assert run.digest() in granum_program("digest", tmp_path / "program")
    assert run.series == program.series
    other = os.environ.get("GRANUM")
    if other:
        subprocess.run([other, "run", str(tmp_path / "case.toml"), "--out", str(tmp_path / "other")], check=True, capture_output=True)
        assert granum.open(tmp_path / "other").digest() == run.digest()


def test_memory_folder_threads_and_a_sample_of_its_own_give_the_same_bits(
    case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path
) -> None:
    sample = granum.prepare(case)
    assert (sample.kind, sample.status, tested.kind) == ("sample", "finished", "test")
    assert granum.run(case, sample).series == tested.series
    assert granum.run(case, sample.path, threads=3).series == tested.series
    folder = granum.run(case, sample, out=tmp_path / "run")
    assert folder.series == tested.series
    assert folder.path == tmp_path / "run" and tested.path is None
    assert folder.measures == tested.measures
    assert folder.table("forces") == tested.table("forces")
    assert np.array_equal(folder.snapshot().positions, tested.snapshot().positions)
    again = pickle.loads(pickle.dumps(folder))
    assert again.digest() == folder.digest() and again.case == case
    where = sample.path
    del sample
    assert where is not None and not where.exists()


def test_runs_go_on_in_threads_while_python_goes_on(case: granum.Case, tested: granum.Run) -> None:
    found: list[granum.Run] = []
    threads = [threading.Thread(target=lambda: found.append(granum.run(case, threads=1))) for _ in range(3)]
    for thread in threads:
        thread.start()
    beats = 0
    while any(thread.is_alive() for thread in threads):
        time.sleep(1e-3)
        beats += 1
    assert beats > 10
    assert all(run.series == tested.series for run in found) and len(found) == 3


def test_functions_are_called_with_states_and_progress(case: granum.Case, tested: granum.Run) -> None:
    states: list[float] = []
    told: list[dict[str, object]] = []

    def on_state(values: dict[str, float]) -> None:
        states.append(values["stress_ratio"])

    run = granum.run(case, on_state=on_state, on_progress=told.append)
    assert np.array_equal(states, run.series["stress_ratio"])
    assert run.series == tested.series
    assert told and set(told[0]) == {"activity", "part", "counted", "done", "of", "fraction", "values"}


def test_a_stopped_run_is_resumed_to_the_same_bits(case: granum.Case, tmp_path: pathlib.Path) -> None:
    whole = granum.run(case, out=tmp_path / "whole")
    broken = granum.run(case, out=tmp_path / "broken", on_state=lambda values: values["state"] < 2)
    assert broken.status == "interrupted" and len(broken.series) < len(whole.series)
    assert granum.resume(broken).digest() == whole.digest()
    assert granum.resume(tmp_path / "broken").status == "finished"


def test_what_a_function_raises_is_raised_after_a_stop_in_good_order(case: granum.Case, tmp_path: pathlib.Path) -> None:
    def fails(values: dict[str, float]) -> None:
        raise ZeroDivisionError("in a function of the user")

    with pytest.raises(ZeroDivisionError):
        granum.run(case, on_state=fails)
    with pytest.raises(ZeroDivisionError):
        granum.run(case, out=tmp_path / "run", on_state=fails)
    assert granum.open(tmp_path / "run").status == "interrupted"
    assert granum.resume(tmp_path / "run").status == "finished"


@pytest.mark.parametrize("activity", ["placing of the grains", "compaction"])
def test_what_a_function_raises_during_the_preparation_is_raised(case: granum.Case, tmp_path: pathlib.Path, activity: str) -> None:
    larger = case.with_values({"grains.count": 300})

    def fails(progress: dict[str, object]) -> None:
        if progress["activity"] == activity:
            raise ZeroDivisionError(activity)

    with pytest.raises(ZeroDivisionError, match=activity):
        granum.prepare(larger, on_progress=fails)
    with pytest.raises(ZeroDivisionError, match=activity):
        granum.run(larger, on_progress=fails)
    with pytest.raises(ZeroDivisionError, match=activity):
        granum.run(larger, on_progress=fails, out=tmp_path / "run")


def test_a_stop_while_grains_are_placed_is_told(case: granum.Case, tmp_path: pathlib.Path) -> None:
    with pytest.raises(granum.RunError, match="stopped"):
        granum.prepare(case, on_progress=lambda progress: False)
    with pytest.raises(granum.RunError, match="stopped"):
        granum.run(case, out=tmp_path / "run", on_progress=lambda progress: False)


def test_a_run_goes_on_without_the_temporary_folder_of_its_sample(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    sample = granum.prepare(case)
    where = sample.path
    stopped = granum.run(case, sample, out=tmp_path / "run", on_state=lambda values: False)
    assert stopped.status == "interrupted"
    del sample
    assert where is not None and not where.exists()
    assert granum.resume(stopped).series == tested.series


def test_a_sample_in_a_temporary_folder_is_resumed(case: granum.Case, tested: granum.Run) -> None:
    sample = granum.prepare(case, on_progress=lambda progress: progress["activity"] == "placing of the grains")
    assert sample.status == "interrupted"
    where = sample.path
    resumed = granum.resume(sample)
    del sample
    assert resumed.status == "finished" and where is not None and where.exists()
    assert granum.run(case, resumed).series == tested.series
    del resumed
    assert not where.exists()


def test_warnings_of_the_engine_are_warnings_of_python(case: granum.Case, tmp_path: pathlib.Path, capfd: pytest.CaptureFixture[str]) -> None:
    stopped = granum.run(case, out=tmp_path / "run", on_state=lambda values: values["state"] < 2)
    (tmp_path / "run" / "preparation.parquet").unlink()
    with pytest.warns(granum.RunWarning, match="preparation.parquet.*the run writes it again") as told:
        assert granum.resume(stopped).status == "finished"
    assert all(warning.filename == __file__ for warning in told)
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
def test_ctrl_c_stops_in_good_order(tmp_path: pathlib.Path) -> None:
    program = (
        "import signal, granum\n"
        # A process that was started in the background may have inherited that the signal is ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "case = granum.Case(grains={'count': 1000}, shear={'deviator_strain': 0.3})\n"
        "print('begins', flush=True)\n"
        f"granum.run(case, out={str(tmp_path / 'run')!r})\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "begins\n"
    deadline = time.monotonic() + 60
    while not (tmp_path / "run" / "run.json").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors and child.returncode != 0
    assert granum.open(tmp_path / "run").status == "interrupted"


def test_folders_in_the_way_and_wrong_arguments_are_refused(case: granum.Case, tmp_path: pathlib.Path) -> None:
    granum.run(case, out=tmp_path / "run")
    with pytest.raises(granum.FileError, match="force=True"):
        granum.run(case, out=tmp_path / "run")
    granum.run(case, out=tmp_path / "run", force=True)
    with pytest.raises(granum.FileError):
        granum.open(tmp_path / "missing")
    with pytest.raises(granum.FileError):
        granum.resume(tmp_path / "missing")
    for threads in [0, -1, 2**80]:
        with pytest.raises(granum.CaseError, match="threads.* between 1 and 4096"):
            granum.run(case, threads=threads)
    with pytest.raises(TypeError, match="threads: a whole number"):
        granum.run(case, threads=1.5)  # type: ignore[arg-type]
    with pytest.raises(granum.CaseError, match="checkpoint_every"):
        granum.run(case, checkpoint_every=-1.0)
    assert granum.run(case, threads=np.int64(1), checkpoint_every="1 min").status == "finished"
    with pytest.raises(TypeError, match="path="):
        granum.run(case, axial_strain=0.1)
    with pytest.raises(TypeError, match="sample"):
        granum.run(case, 3)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        granum.run(3)  # type: ignore[arg-type]


def test_a_run_in_memory_says_what_it_cannot_do(tested: granum.Run) -> None:
    with pytest.raises(granum.Error, match="out="):
        tested.digest()
    with pytest.raises(TypeError, match="out="):
        granum.resume(tested)
    with pytest.raises(TypeError, match="pickled"):
        pickle.dumps(tested)


def test_what_a_run_does_not_have_is_a_key_error_with_the_nearest(case: granum.Case, tested: granum.Run, tmp_path: pathlib.Path) -> None:
    for run in [tested, granum.run(case, out=tmp_path / "run")]:
        with pytest.raises(KeyError, match="did you mean series"):
            run.table("serie")
        with pytest.raises(KeyError, match="did you mean end"):
            run.snapshot("ends")


def test_a_simulation_is_advanced_by_hand_and_its_arrays_stay_as_they_were(tested: granum.Run) -> None:
    simulation = tested.simulation()
    before = simulation.assembly()
    positions = before.positions
    kept = positions.copy()
    other = copy.copy(simulation)
    simulation.control(strain_rate={"zz": 50.0}, mean_stress=20e3, rate_limit=100.0)
    simulation.advance(200)
    assert simulation.step == other.step + 200 and simulation.strain[2, 2] > before.strain[2, 2]
    assert np.array_equal(positions, kept)
    assert not np.array_equal(simulation.assembly().positions, kept)
    with pytest.raises(ValueError, match="read-only"):
        positions[0, 0] = 1.0
    other.control(strain_rate={"zz": 50.0}, mean_stress=20e3, rate_limit=100.0)
    other.advance(100)
    other.advance(100)
    assert np.array_equal(other.assembly().positions, simulation.assembly().positions)
    with pytest.raises(granum.CaseError, match="component"):
        simulation.control(stress={"zx1": 3.0})
    with pytest.raises(granum.CaseError, match="not both"):
        simulation.control(strain_rate={"zz": 1.0}, stress={"zz": 1e3})
    with pytest.raises(granum.CaseError, match="is a length"):
        simulation.control(mean_stress="3 mm")
    with pytest.raises(granum.CaseError, match="NaN is not finite"):
        simulation.control(stress={"zz": float("nan")})
    with pytest.raises(granum.CaseError, match="needs an axis"):
        simulation.control(stress={"xx": 1.0, "yy": 1.0, "zz": 1.0}, mean_stress="20 kPa")
    with pytest.raises(TypeError, match="zz: a number or a text"):
        simulation.control(stress={"zz": None})


def test_the_arrays_of_an_assembly_are_views_that_keep_it_alive(tested: granum.Run) -> None:
    simulation = tested.simulation()
    simulation.control(strain_rate={"xy": 50.0, "zz": 20.0}, rate_limit=100.0)
    simulation.advance(50)
    assembly = simulation.assembly()
    grains, contacts = assembly.grains_table(), assembly.contacts_table()
    assert np.array_equal(assembly.positions[:, 2], grains["position_z"]) and np.array_equal(assembly.radii, grains["radius"])
    assert np.array_equal(assembly.velocities[:, 0], grains["velocity_x"]) and assembly.spins.shape == (60, 3)
    assert np.array_equal(assembly.normal_forces, contacts["normal_force"]) and assembly.normals.shape == (len(contacts), 3)
    assert np.array_equal(assembly.sliding, contacts["sliding"])
    assert np.allclose(assembly.forces, assembly.tangential_forces - assembly.normal_forces[:, None] * assembly.normals, rtol=0, atol=1e-18)
    # One place in memory, read twice, and not a copy for each reading.
    assert np.shares_memory(assembly.positions, assembly.positions) and not np.shares_memory(assembly.forces, assembly.forces)
    views = [assembly.positions, assembly.radii, assembly.normals, assembly.overlaps, assembly.sliding]
    copies = [view.copy() for view in views]
    assert not any(view.flags.writeable for view in views)
    del assembly, grains, contacts
    simulation.advance(50)
    others = [tested.simulation().assembly() for _ in range(20)]
    assert all(np.array_equal(view, copied) for view, copied in zip(views, copies)) and len(others) == 20
    # Without contacts there is nothing to show.
    simulation.control(strain_rate={"xx": -1e3, "yy": -1e3, "zz": -1e3}, rate_limit=1.0)
    simulation.advance(3000)
    assert simulation.assembly().contacts.shape == (0, 2) and simulation.assembly().normals.shape == (0, 3)
    assert all(len(values) == 0 for values in simulation.history().values())


def test_the_history_of_the_contacts_is_that_of_the_laws(tested: granum.Run) -> None:
    simulation = tested.simulation()
    assembly, history = simulation.assembly(), simulation.history()
    contacts = len(assembly.contacts)
    assert {name: values.shape for name, values in history.items()} == {
        "tangential_vectors": (contacts, 3, 3),
        "tangential_scalars": (contacts, 2),
    }
    assert np.array_equal(history["tangential_vectors"][:, 0], assembly.tangential_forces) and np.any(assembly.tangential_forces)
    rolling = granum.Case(
        grains={"count": 60},
        contact={"normal": "luding", "tangential": "no-slip", "rolling": "elastic-plastic"},
        preparation={"solid_fraction": "none", "unbalanced_force": 0.05},
    )
    history = granum.prepare(rolling).simulation().history()
    assert {name: values.shape[1:] for name, values in history.items()} == {
        "normal_scalars": (3,),
        "tangential_vectors": (1, 3),
        "tangential_scalars": (1,),
        "rolling_vectors": (1, 3),
        "rolling_scalars": (1,),
    }
    assert history["normal_scalars"].min() > 0


def test_a_control_that_is_given_again_changes_nothing(tested: granum.Run) -> None:
    once, often = tested.simulation(), tested.simulation()
    for simulation in [once, often]:
        simulation.control(strain_rate={"zz": 50.0}, mean_stress=20e3, rate_limit=100.0)
    for _ in range(10):
        often.control(strain_rate={"zz": "50 1/s"}, mean_stress="20 kPa", rate_limit=100.0)
        often.advance(30)
    once.advance(300)
    assert np.array_equal(once.assembly().positions, often.assembly().positions)


def test_the_program_comes_with_the_package() -> None:
    assert granum_program("--version").strip() == f"granum {granum.__version__}"
    wrong = subprocess.run([sys.executable, "-m", "granum", "nonsense"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "unrecognized subcommand" in wrong.stderr
    missing = subprocess.run([sys.executable, "-m", "granum", "run", "missing.toml"], capture_output=True, text=True)
    assert missing.returncode == 1


def test_the_program_that_a_campaign_starts_is_that_of_the_package(tmp_path: pathlib.Path) -> None:
    found = script()
    assert found is not None and subprocess.run([found, "--version"], capture_output=True, text=True).stdout == f"granum {granum.__version__}\n"
    # Copied elsewhere without its script: that of the environment may be of another version.
    shutil.copytree(pathlib.Path(granum.__file__).parent, tmp_path / "granum")
    line = "import granum, granum._script; print(granum.__file__, granum._script.script())"

    def of_copy() -> list[str]:
        environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
        return subprocess.run([sys.executable, "-c", line], env=environment, check=True, capture_output=True, text=True).stdout.split()

    assert of_copy() == [str(tmp_path / "granum" / "__init__.py"), "None"]
    place = tmp_path / ("Scripts/granum.exe" if os.name == "nt" else "bin/granum")
    place.parent.mkdir()
    shutil.copy(found, place)
    assert of_copy()[1] == str(place)


def test_a_campaign_of_the_program_starts_its_runs(tmp_path: pathlib.Path) -> None:
    (tmp_path / "case.toml").write_text(
        "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n"
        "shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2\n"
    )
    (tmp_path / "plan.toml").write_text(
        "case = 'case.toml'\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'friction'\n"
        "key = 'grains.material.friction'\nvalues = [0.2, 0.4]\n"
    )
    granum_program("campaign", tmp_path / "plan.toml", "--out", tmp_path / "study")
    runs = [granum.open(record.parent) for record in (tmp_path / "study" / "tests").glob("*/run.json")]
    assert len(runs) == 2 and all(run.status == "finished" and len(run.series) == 3 for run in runs)


def test_bonds_and_cracks_are_arrays() -> None:
    case = granum.Case(
        grains={"count": 60, "material": {"interface_energy": 0}},
        preparation={"solid_fraction": "none", "unbalanced_force": 0.05},
        bonds=[{"modulus": "1 GPa", "tensile_strength": "10 kPa", "cohesion": "20 kPa", "largest_gap": 0.02}],
        shear={"deviator_strain": 0.03, "inertial_number": 0.01},
        recording={"states": 4},
    )
    run = granum.run(case)
    assembly = run.snapshot()
    made = len(assembly.bonds) + len(assembly.cracks)
    assert assembly.bonds.shape[1] == 2 and made > 100
    assert len(assembly.cracks) == run.series["bonds_broken_by_tension"][-1] + run.series["bonds_broken_by_shear"][-1] > 0
    assert np.allclose(np.linalg.norm(assembly.crack_normals, axis=1), 1)
    assert (assembly.crack_energies > 0).all() and assembly.crack_by_tension.any()
    assert assembly.bond_forces.shape == assembly.bond_normals.shape == (len(assembly.bonds), 3)
    assert (assembly.bond_utilisations < 1).all() and (assembly.bond_energies >= 0).all()
    inside = np.linalg.solve(assembly.cell, assembly.cracks.T)
    assert ((inside >= 0) & (inside < 1)).all()
