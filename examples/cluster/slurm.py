"""Tracks clips with workers that SLURM starts, one core each; needs dask-jobqueue.

python examples/cluster/slurm.py 20 clips/*.mp4 -o runs --renderer cpu

The first word is the number of jobs, the others are those of `abs-engine track`. A job that ends,
or is cancelled, is submitted again as long as there is work. Account, queue and the like come from
~/.config/dask/jobqueue.yaml. With WORKERS=local the jobs run right here.
"""

import os
import sys

import dask
from dask_jobqueue import SLURMCluster
from dask_jobqueue.local import LocalCluster

from abs_engine.cli import main

if __name__ == "__main__":
    jobs, *words = sys.argv[1:]
    here = os.environ.get("WORKERS") == "local"
    kind, more = (LocalCluster, {}) if here else (SLURMCluster, {"walltime": "04:00:00"})
    # Of a worker that starts again, longer than Dask's 15 s: else its job is cancelled meanwhile.
    dask.config.set({"distributed.deploy.lost-worker-timeout": "3 minutes"})
    with kind(cores=1, processes=1, memory="4GB", **more) as cluster:
        cluster.adapt(minimum_jobs=int(jobs), maximum_jobs=int(jobs))
        sys.exit(main(["track", *words, "--scheduler", cluster.scheduler_address]))
