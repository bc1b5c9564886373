"""Executes the commands of a campaign with Dask: dask_jobs.py JOBS [ADDRESS OF A SCHEDULER]

JOBS has a command in each line, as `granum campaign PLAN --list-jobs` prints them. Without an address, workers are started on this machine.
"""
import shlex
import subprocess
import sys

from dask.distributed import Client, LocalCluster, as_completed


def execute(command):
    """Executes a command on a worker; returns its exit status and what it said."""
    done = subprocess.run(shlex.split(command), capture_output=True, text=True)
    return done.returncode, done.stderr


def main(jobs, address=None):
    with open(jobs) as lines:
        commands = [line.strip() for line in lines if line.strip()]
    # A run uses one thread; a worker has one run at a time.
    with Client(address or LocalCluster(threads_per_worker=1, dashboard_address=None)) as client:
        # Not pure: the same command does something else once its run is finished.
        running = {client.submit(execute, command, pure=False): command for command in commands}
        failed = 0
        for done in as_completed(running):
            status, said = done.result()
            if status != 0:
                failed += 1
                print(f"{running[done]}: exit status {status}: {said}", file=sys.stderr)
    print(f"{len(commands) - failed} of {len(commands)} runs finished")
    return failed


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) > 0)
