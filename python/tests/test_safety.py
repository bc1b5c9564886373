"""Nothing that Python can pass makes the process fail: wrong types and values are exceptions, and memory does not grow."""

import copy
import multiprocessing
import os
import pickle
import random
import subprocess
import sys
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
    objects = [granum.Case(), tested, tested.series, assembly, simulation, granum.surrogates.load("sand")]
    found: list[Callable[..., Any]] = [
        granum.Case, granum.Case.from_dict, granum.Case.from_toml, granum.Case.read, granum.Table, granum.Table.read, granum.measure,
        granum.open, granum.resume, granum.run, granum.surrogates.load, granum.CaseError,
    ]  # fmt: skip
    for one in objects:
        names = [name for name in dir(one) if not name.startswith("_") or name in ("__getitem__", "__contains__", "__eq__", "__deepcopy__")]
        found += [value for name in names if name not in ("advance", "write") and callable(value := getattr(one, name))]
    return found


def test_wrong_arguments_of_every_function_are_exceptions(tested: granum.Run, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    chance = random.Random(1)
    raised = 0
    for function in functions(tested):
        for _ in range(60):
            arguments = [chance.choice(WRONG) for _ in range(chance.randint(1, 3))]
            words = chance.choice([{}, {}, {chance.choice(["name", "case", "radii", "cell", "level", "threads"]): chance.choice(WRONG)}])
            if function is granum.run and isinstance(arguments[0], dict):
                continue
            try:
                function(*arguments, **words)
            except granum.InternalError as error:
                pytest.fail(f"{function} {arguments} {words}: {error}")
            except Exception:
                raised += 1
    assert raised > 1000
    # A simulation is whole after all that.
    assert tested.simulation().step > 0


def test_numbers_of_steps_that_are_none_are_refused(tested: granum.Run) -> None:
    simulation = tested.simulation()
    for wrong in [-1, 1.5, "3", None, 2**70]:
        with pytest.raises((TypeError, OverflowError)):
            simulation.advance(wrong)  # type: ignore[arg-type]
    simulation.advance(0)


def test_what_cannot_be_copied_or_pickled_says_so(tested: granum.Run) -> None:
    with pytest.raises(TypeError, match="pickled"):
        pickle.dumps(tested.simulation())
    assert copy.deepcopy(tested.simulation()).step == tested.simulation().step


def _of_child(queue: Any) -> None:
    from conftest import SMALL

    try:
        queue.put(list(granum.run(granum.Case(**SMALL)).series["stress_ratio"]))
    except granum.Error as error:
        queue.put(str(error))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_is_told_to_spawn_and_a_spawned_one_works(tested: granum.Run) -> None:
    for method in ["fork", "spawn"]:
        context: Any = multiprocessing.get_context(method)
        queue = context.Queue()
        child = context.Process(target=_of_child, args=(queue,))
        child.start()
        answer = queue.get(timeout=120)
        child.join()
        if method == "fork":
            assert "spawn" in answer
        else:
            assert answer == list(tested.series["stress_ratio"])


def test_memory_does_not_grow_over_many_runs(case: granum.Case) -> None:
    resource = pytest.importorskip("resource")
    short = case.with_values({"shear.deviator_strain": 0.001, "recording.states": 1, "preparation.unbalanced_force": 0.1})
    sample = granum.prepare(short)

    def used() -> int:
        for _ in range(15):
            granum.run(short, sample).snapshot().measure()
        return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    used()
    before = used()
    # Kilobytes: more than the noise of an allocator would be a leak.
    assert max(used() for _ in range(3)) - before < 4_000


def test_the_import_is_quick_and_takes_nothing_but_granum() -> None:
    program = "import sys, granum; print(' '.join(n for n in sys.modules if n in ('numpy', 'pandas', 'polars', 'pyarrow', 'pint')))"
    found = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == ""
