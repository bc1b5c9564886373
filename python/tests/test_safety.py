"""Nothing that Python can pass makes the process fail: wrong types and values are exceptions, and memory does not grow."""

import copy
import multiprocessing
import os
import pickle
import queue
import random
import subprocess
import sys
import threading
from typing import Any, Callable

import granum
import numpy as np
import pytest

WRONG: list[Any] = [
    None, True, -1, 0, 2**70, 3.5, float("nan"), float("inf"), "", "text", "\0", "ö\ud800", b"bytes", [], [1], [[]], {}, {"a": 1},
    {1: 2}, {"": {"": None}}, object(), Exception, lambda *_: None, np.array([]), np.array([[np.nan]]), np.zeros((0, 3)), np.zeros((3, 0)),
    np.zeros((2, 3), dtype="c16"), np.array(["a"]), np.array([object()]), np.broadcast_to(1.0, (2, 3)), np.asfortranarray(np.ones((4, 3))),
    np.ones(8)[::-2], np.datetime64("2026-01-01"), range(3), iter([1]), memoryview(b"ab"), granum, granum.Case,
]  # fmt: skip


def functions(tested: granum.Run) -> list[Callable[..., Any]]:
    """Every function and method that takes arguments, but for those that begin long work with few of them."""
    assembly, simulation = tested.snapshot(), tested.simulation()
    dataset = granum.Dataset([tested])
    surrogate = granum.surrogates.fit(dataset, "deviator_strain", "stress_ratio", method="ridge")
    campaign = granum.Campaign(granum.Case(), "study", friction=[0.2, 0.3])
    objects = [
        granum.Case(), tested, tested.series, assembly, simulation, granum.surrogates.load("sand"), dataset, surrogate, campaign,
        granum.compare(tested),
    ]  # fmt: skip
    found: list[Callable[..., Any]] = [
        granum.Case, granum.Case.from_dict, granum.Case.from_toml, granum.Case.read, granum.Table, granum.Table.read, granum.measure,
        granum.open, granum.resume, granum.run, granum.surrogates.load, granum.CaseError, granum.Dataset, granum.Dataset.read,
        granum.surrogates.fit, granum.surrogates.read, granum.Campaign, granum.Campaign.open, granum.compare, granum.laboratory, granum.log,
        granum.view, granum.Recorder, granum.pair, granum.Posterior, granum.read, granum.write, granum.Assembly,
        granum.grainlearning.read, granum.grainlearning.write, lambda *arguments, **words: granum.write("written.xyz", *arguments, **words),
        lambda *arguments, **words: granum.pair({"normal_approach": [1e-8], "tangential_displacement": [0.0]}, normal=arguments[0]),
        lambda *arguments, **words: granum.view(assembly, colour=arguments[0]), granum.Recorder().record,
        lambda *arguments, **words: granum.Recorder(sensors=[granum.Sensor(*arguments, **words)]).record(assembly),
        lambda *arguments, **words: granum.surrogates.fit(dataset, *arguments, method="ridge", **words),
        lambda *arguments, **words: granum.Campaign(granum.Case(), "study", friction=(0.1, 0.2), variables=arguments[0], **words),
    ]  # fmt: skip
    for one in objects:
        names = [name for name in dir(one) if not name.startswith("_") or name in ("__getitem__", "__contains__", "__eq__", "__deepcopy__")]
        left_out = ("advance", "write", "report") + (("run",) if one is campaign else ())
        found += [value for name in names if name not in left_out and callable(value := getattr(one, name))]
    return found


def test_wrong_arguments_of_every_function_are_exceptions(tested: granum.Run, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    chance = random.Random(1)
    raised = 0
    for function in functions(tested):
        for _ in range(60):
            arguments = [chance.choice(WRONG) for _ in range(chance.randint(1, 3))]
            named = chance.choice(["name", "case", "radii", "cell", "level", "threads", "n", "design", "seed", "runs", "hidden", "units"])
            words = chance.choice([{}, {}, {named: chance.choice(WRONG)}])
            if function is granum.run and isinstance(arguments[0], dict):
                continue
            try:
                function(*arguments, **words)
            except granum.InternalError as error:
                pytest.fail(f"{function} {arguments} {words}: {error}")
            except Exception:
                raised += 1
    assert raised > 2000
    # A simulation is whole after all that.
    assert tested.simulation().step > 0


def test_numbers_of_steps_that_are_none_are_refused(tested: granum.Run) -> None:
    simulation = tested.simulation()
    step = simulation.step
    for wrong in [1.5, "3", None, True]:
        with pytest.raises(TypeError, match="steps: a whole number is needed"):
            simulation.advance(wrong)  # type: ignore[arg-type]
    wrong_counts: list[Any] = [-1, 2**70, np.int64(-1)]
    for value in wrong_counts:
        with pytest.raises(granum.CaseError, match="is not between 0 and") as caught:
            simulation.advance(value)
        assert (caught.value.key, caught.value.value) == ("steps", str(value))
    simulation.advance(0)
    assert simulation.step == step
    simulation.advance(np.int64(2))
    assert simulation.step == step + 2


def test_what_cannot_be_copied_or_pickled_says_so(tested: granum.Run) -> None:
    with pytest.raises(TypeError, match="pickled"):
        pickle.dumps(tested.simulation())
    assert copy.deepcopy(tested.simulation()).step == tested.simulation().step


def _of_child(answers: Any) -> None:
    from conftest import SMALL

    try:
        answers.put(list(granum.run(granum.Case(**SMALL)).series["stress_ratio"]))
    except granum.Error as error:
        answers.put(str(error))


def _answer(method: str) -> Any:
    """What a process that is started like that finds."""
    context: Any = multiprocessing.get_context(method)
    answers = context.Queue()
    child = context.Process(target=_of_child, args=(answers,))
    child.start()
    answer = answers.get(timeout=120)
    child.join()
    return answer


@pytest.mark.parametrize("method", [method for method in ["fork", "spawn"] if method in multiprocessing.get_all_start_methods()])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_forked_and_spawned_processes_find_the_same_bits(tested: granum.Run, method: str) -> None:
    assert _answer(method) == list(tested.series["stress_ratio"])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_process_that_is_forked_during_a_run_is_told_to_spawn(case: granum.Case) -> None:
    answers: list[Any] = []

    def at_state(values: dict[str, float]) -> bool:
        answers.append(_answer("fork"))
        return False

    granum.run(case, on_state=at_state)
    assert len(answers) == 1 and "spawn" in answers[0]


def test_a_mistake_of_granum_is_an_exception_and_no_text(tested: granum.Run, capfd: pytest.CaptureFixture[str]) -> None:
    simulation = tested.simulation()
    for argument in [None, simulation]:
        with pytest.raises(granum.InternalError, match="on purpose at .*mistake.rs") as caught:
            granum._granum._mistake(argument)
        assert isinstance(caught.value, Exception)
    assert capfd.readouterr() == ("", "")
    for use in [lambda: simulation.step, lambda: simulation.advance(1), lambda: copy.copy(simulation), simulation.assembly]:
        with pytest.raises(granum.RunError, match="lost in a mistake"):
            use()
    assert tested.simulation().step > 0


def test_an_interpreter_beside_the_first_is_refused() -> None:
    """A subinterpreter would share what granum keeps for the whole process."""
    program = (
        "try: import _interpreters as interpreters\n"
        "except ImportError: import _xxsubinterpreters as interpreters\n"
        "import granum\n"
        "told = 'try: import granum\\nexcept ImportError as error: print(error, flush=True)\\nelse: print(\"imported\", flush=True)'\n"
        "interpreters.run_string(interpreters.create(), told)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    if "No module named '_xxsubinterpreters'" in done.stderr:
        pytest.skip("this Python has no module that makes interpreters")
    assert (done.returncode, done.stderr) == (0, "") and "interpreter" in done.stdout, done.stdout + done.stderr


def test_a_python_without_its_lock_is_refused() -> None:
    """As far as one that has it can show: the version of the others says that it is one."""
    program = "import sys; sys.version += ' free-threading build'\nimport granum"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and "ImportError: granum does not support free-threaded builds of CPython" in done.stderr, done.stderr


def test_several_threads_use_one_simulation_at_once(tested: granum.Run) -> None:
    simulation = tested.simulation()
    begin, answers = simulation.step, queue.SimpleQueue[bool]()

    def use() -> None:
        for _ in range(150):
            try:
                assert simulation.step >= begin and len(simulation.assembly().radii) == 60
                simulation.control(strain_rate={"zz": 1.0})
                simulation.advance(1)
                answers.put(True)
            except granum.RunError as error:
                assert "another thread" in str(error)
                answers.put(False)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=use, daemon=True) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
    finally:
        sys.setswitchinterval(before)
    assert not any(thread.is_alive() for thread in threads)
    made = [answers.get() for _ in range(answers.qsize())]
    assert len(made) == 600 and simulation.step == begin + sum(made)


def test_a_thread_that_outlives_the_interpreter_ends_without_a_word() -> None:
    program = (
        "import threading, time, granum\n"
        "case = granum.Case(grains={'count': 200}, shear={'deviator_strain': 0.3})\n"
        "told = threading.Event()\n"
        "run = lambda: granum.run(case, threads=1, on_progress=lambda progress: told.set())\n"
        "threading.Thread(target=run, daemon=True).start()\n"
        "assert told.wait(60)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_memory_does_not_grow_over_a_thousand_runs(case: granum.Case) -> None:
    resource = pytest.importorskip("resource")
    short = case.with_values({"shear.deviator_strain": 0.001, "recording.states": 1, "preparation.unbalanced_force": 0.1})
    sample = granum.prepare(short)

    def used() -> int:
        for _ in range(200):
            granum.run(short, sample, threads=1).snapshot().measure()
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    used()
    before = used()
    # Kilobytes: more than the noise of an allocator would be a leak.
    assert max(used() for _ in range(3)) - before < 4_000


def test_the_import_is_quick() -> None:
    resource = pytest.importorskip("resource")

    def seconds(program: str) -> float:
        """Processor time, since other programs may run as well."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", program], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return float(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)

    assert min(seconds("import granum") for _ in range(5)) - min(seconds("pass") for _ in range(5)) < 0.1


def test_the_import_takes_nothing_but_granum() -> None:
    program = "import sys, granum; print(' '.join(n for n in sys.modules if n in ('numpy', 'pandas', 'polars', 'pyarrow', 'pint', 'xarray', 'matplotlib')))"
    found = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == ""
