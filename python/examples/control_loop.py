"""A control loop at a fixed rate around `granum stream`: what sensors measure goes in, a prediction with its interval comes out.

    python control_loop.py MODEL.json [--granum PROGRAM] [--rate HZ] [--seconds S]

The sensors are made up: every input of the surrogate moves to and fro within the range of its training. The time from the writing of a line to the
reading of its answer is measured for every line, as a controller would see it.
"""

import argparse
import json
import math
import subprocess
import time

Ranges = dict[str, tuple[float, float]]


def ranges(path: str) -> Ranges:
    """The inputs of the surrogate of a file, with the ranges of their training where the file has them by themselves."""
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    names = [column["name"] for column in document["columns"]["inputs"]]
    content = document["content"]
    known = content.get("ranges")
    if known is None and "inputs" in content.get("networks", [{}])[0]:
        scalers = [column["scaler"] for column in content["networks"][0]["inputs"]]
        known = [[scaler["minimum"], scaler["maximum"]] for scaler in scalers]
    return {name: (low, high) for name, (low, high) in zip(names, known or [(0.0, 1.0)] * len(names))}


def measured(inputs: Ranges, step: int) -> dict[str, float]:
    """What the sensors say at a step."""
    moved = enumerate(inputs.items())
    return {name: low + (high - low) * (0.5 + 0.49 * math.sin(0.01 * step + k)) for k, (name, (low, high)) in moved}


def main() -> None:
    """Runs the loop and tells how long answers took."""
    arguments = argparse.ArgumentParser(description="A control loop around granum stream.")
    arguments.add_argument("model")
    arguments.add_argument("--granum", default="granum")
    arguments.add_argument("--rate", type=float, default=1000.0)
    arguments.add_argument("--seconds", type=float, default=10.0)
    given = arguments.parse_args()
    inputs, times = ranges(given.model), []
    command = [given.granum, "stream", given.model, "--latency"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1) as loop:
        assert loop.stdin and loop.stdout
        # The surrogate is read when the first answer is there.
        loop.stdin.write('{"reset": true}\n')
        loop.stdout.readline()
        begin = time.perf_counter()
        for step in range(int(given.rate * given.seconds)):
            wait = begin + step / given.rate - time.perf_counter()
            if wait > 0:
                time.sleep(wait)
            line = json.dumps({"sequence": step, **measured(inputs, step)}) + "\n"
            asked = time.perf_counter()
            loop.stdin.write(line)
            answer = json.loads(loop.stdout.readline())
            times.append(time.perf_counter() - asked)
            assert answer["sequence"] == step and "error" not in answer, answer
        loop.stdin.close()
    times.sort()
    median, most, nearly_all, largest = (1e6 * times[min(len(times) - 1, int(share * len(times)))] for share in (0.5, 0.99, 0.999, 1))
    print(f"{len(times)} lines at {given.rate:g} Hz, round trip in microseconds: median {median:.0f}, 99 % within {most:.0f}, ", end="")
    print(f"99.9 % within {nearly_all:.0f}, largest {largest:.0f}; {sum(own > 1 / given.rate for own in times)} later than the next beat")


if __name__ == "__main__":
    main()
