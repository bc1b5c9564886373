"""A surrogate as an ONNX file, evaluated by onnxruntime without granum: one without memory, and one with a memory, step by step."""

from typing import Any

import granum
import numpy as np
import onnxruntime


def curve(friction: float) -> granum.Table:
    """A made-up test."""
    strain = np.linspace(0.0, 0.1, 30)
    ratio = friction * (1 - np.exp(-50 * strain)) + 1e-3 * np.sin(300 * strain)
    return granum.Table({"axial_strain": strain, "friction": np.full(30, friction), "stress_ratio": ratio})


data = granum.Dataset({f"run {k}": curve(0.2 + 0.1 * k) for k in range(6)})
inputs = np.column_stack([np.linspace(0.0, 0.1, 20), np.full(20, 0.45)])

for method in ["feed-forward", "recurrent"]:
    surrogate = granum.surrogates.fit(data, ["friction"], "stress_ratio", coordinate="axial_strain", method=method)
    surrogate.export_onnx(f"{method}.onnx")

# ANCHOR: columns
session = onnxruntime.InferenceSession("feed-forward.onnx")
# Each column is a table of doubles with one column and a row for each state.
asked = {"axial_strain": inputs[:, [0]], "friction": inputs[:, [1]]}
found: Any = session.run(["predicted_stress_ratio", "lower_stress_ratio", "upper_stress_ratio", "outside"], asked)
mean, lower, upper, outside = map(np.asarray, found)
# ANCHOR_END: columns
print(f"stress ratio at the end {mean[-1, 0]:.4f} ({lower[-1, 0]:.4f} to {upper[-1, 0]:.4f}), {int(outside.sum())} states outside")

# ANCHOR: steps
session = onnxruntime.InferenceSession("recurrent.onnx")
memory = np.zeros((1, next(own.shape[1] for own in session.get_inputs() if own.name == "memory")))
answers = []
for step, (strain, friction) in enumerate(inputs):
    asked = {
        "axial_strain": np.array([[strain]]),
        "friction": np.array([[friction]]),
        "memory": memory,
        # 1 for the first state of a test, whose memory is made from its inputs.
        "begins": np.array([[float(step == 0)]]),
    }
    answer, memory = map(np.asarray, session.run(["predicted_stress_ratio", "next_memory"], asked))
    answers.append(answer[0, 0])
# ANCHOR_END: steps
exact = surrogate.predict(inputs, runs=np.zeros(20))["outputs"]["stress_ratio"]["mean"]
print("the predictions of granum:", np.allclose(answers, exact, rtol=1e-6))
