"""The best emulator that AutoEmulate finds for the principal components of whole curves, judged as `curves.py` judges scikit-learn's process.

    python3 benches/peers/surrogates/with_autoemulate.py data/families/sand/drained,data/families/sand/drained-further data/families/sand/unseen 48 96 191

AutoEmulate compares its emulators by cross-validation over the training runs and tunes each (`ITERATIONS` tries); the best is asked. Inputs and curves
are those of `curves.py`; of the components the first three are taken, since all count equally in the score by which AutoEmulate chooses, and those beyond are
mostly scatter. Needs autoemulate (with PyTorch), numpy, pandas, pyarrow and scikit-learn.
"""

import numpy as np
from autoemulate import AutoEmulate
from curves import columns, main
from sklearn.preprocessing import StandardScaler

ITERATIONS, SEED, COMPONENTS = 5, 1, 3


class Best:
    def __init__(self, inputs, curves):
        self.scaler = StandardScaler().fit(columns(inputs))
        self.mean = curves.mean(axis=0)
        _, _, directions = np.linalg.svd(curves - self.mean, full_matrices=False)
        self.directions = directions[:COMPONENTS]
        weights = (curves - self.mean) @ self.directions.T
        self.scale = weights.std(axis=0)
        found = AutoEmulate(
            self.scaler.transform(columns(inputs)).astype("float32"),
            (weights / self.scale).astype("float32"),
            n_iter=ITERATIONS,
            random_seed=SEED,
            log_level="error",
            show_progress_bar=False,
        )
        best = found.best_result()
        print(f"  {best.model_name}", end="", flush=True)
        self.model = best.model

    def predict(self, inputs):
        import torch

        rows = torch.tensor(self.scaler.transform(columns(inputs)), dtype=torch.float32)
        weights = self.model.predict_mean(rows).detach().numpy()
        return self.mean + (weights * self.scale) @ self.directions


if __name__ == "__main__":
    main(Best)
