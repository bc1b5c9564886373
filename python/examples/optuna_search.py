"""The friction at which a sample is as strong as it should be: optuna proposes, granum tests."""

import granum
import optuna

WANTED = 0.6
"""The ratio q/p that the second half of the test should have in the mean."""
CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 10},
)


def main() -> None:
    """Searches and prints the best."""

    def miss(trial: optuna.Trial) -> float:
        friction = trial.suggest_float("friction", 0.02, 0.3)
        ratios = granum.run(CASE.with_values({"grains.material.friction": friction})).series["stress_ratio"]
        return abs(float(ratios[len(ratios) // 2 :].mean()) - WANTED)

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=1))
    study.optimize(miss, n_trials=10)
    print(f"friction {study.best_params['friction']:.3f}: the ratio is missed by {study.best_value:.4f}")


if __name__ == "__main__":
    main()
