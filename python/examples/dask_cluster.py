"""The runs of a campaign over a cluster of Dask, from which a worker is lost.

Here the cluster is two processes of this machine; with `Client("tcp://scheduler:8786")` it is any that Dask knows. Each run has a folder that all
workers see. If a worker is lost, Dask gives its runs to another one, which goes on from their last checkpoints, to the same bits.
"""

import os
import pathlib
import signal
import tempfile
import time

import granum
from distributed import Client, LocalCluster

CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 10},
)


def carry_out(case: granum.Case, folder: str) -> tuple[str, bool]:
    """Carries out the run of a case, or goes on with one whose worker was lost. Returns the digest of its results, and whether it went on."""
    begun = (pathlib.Path(folder) / "run.json").exists()
    # One thread each: the workers share the processors. A checkpoint every half second, for runs that take a few.
    run = granum.resume(folder, threads=1) if begun else granum.run(case, out=folder, threads=1, checkpoint_every="0.5 s", force=True)
    return run.digest(), begun


def lose_a_worker(client: Client, folder: pathlib.Path) -> None:
    """Kills a worker in the middle of a run, as a computer that fails would."""
    processes = client.run(os.getpid)
    while True:
        for worker, names in client.processing().items():
            if names and (folder / names[0] / "run.json").exists():
                os.kill(processes[worker], signal.SIGKILL)
                return
        time.sleep(0.05)


def main() -> None:
    """Compares runs over the cluster with those of the campaign."""
    with tempfile.TemporaryDirectory() as kept:
        folder = pathlib.Path(kept)
        campaign = granum.Campaign(CASE, folder / "study", friction=[0.1, 0.2, 0.3, 0.4])
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            cases = [campaign.case_of(name) for name in campaign.names]
            folders = [str(folder / "dask" / name) for name in campaign.names]
            # The keys are the names of the runs.
            futures = client.map(carry_out, cases, folders, key=campaign.names)
            lose_a_worker(client, folder / "dask")
            found = client.gather(futures)
        print(f"a worker was killed; {len(found)} runs are finished, {sum(begun for _, begun in found)} of them went on in another worker")
        campaign.run(workers=2)
        print("the bits of the campaign:", [digest for digest, _ in found] == [campaign[name].digest() for name in campaign.names])


if __name__ == "__main__":
    main()
