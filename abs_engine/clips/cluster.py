"""Workers: those of a local cluster, or of a scheduler that runs already."""

from __future__ import annotations

import atexit
import logging
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.clips.job import SCRATCH
from abs_engine.core.errors import ParameterError

if TYPE_CHECKING:
    from distributed import Client, LocalCluster
    from tornado.ioloop import IOLoop

_ANSWER = "20s"
_GONE = ("closed", "failed")
_OURS = signal.SIGINT, signal.SIGHUP
"""Signals that a terminal sends to all processes in it; the first one ends the others."""
_SETTINGS = {
    "distributed.scheduler.allowed-failures": 0,  # `many` decides what is tried again
    "distributed.worker.multiprocessing-method": "spawn",
    # Dask's 15 s are too few for a worker to start again on a busy machine; see `replace_lost`.
    "distributed.deploy.lost-worker-timeout": "3 minutes",
    # Without Dask's MALLOC_TRIM_THRESHOLD_, which costs a quarter of the time in page faults.
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1
    ),
}


@contextmanager
def local_workers(count: int, folder: Path) -> Iterator[Client]:
    """As many processes of this machine, each for one core; one that dies is replaced.

    Parameters
    ----------
    folder : Path
        Of the runs; a folder in it lasts as long as the workers.

    Raises
    ------
    ParameterError
        If Dask is not installed.
    OSError
        If the folder cannot be written.
    """
    _check_installed()
    import dask
    from distributed import Client

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # as it closes, too
    scratch = folder / SCRATCH
    shutil.rmtree(scratch, ignore_errors=True)  # of a command that was killed
    scratch.mkdir(exist_ok=True)
    try:
        with (
            dask.config.set({**_SETTINGS, "temporary-directory": str(scratch)}),
            _loop() as loop,
            _started(count, scratch, loop) as cluster,
            Client(cluster) as client,
        ):
            yield client
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


@contextmanager
def _loop() -> Iterator[IOLoop]:
    """A loop in a thread that takes none of `_OURS`, and so do the processes started there.

    Else each of them would complain of Ctrl-C and of a closed terminal.
    """
    from multiprocessing.resource_tracker import ensure_running

    from distributed.utils import LoopRunner

    runner = LoopRunner()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _OURS)
    try:
        runner.start()
        ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        yield runner.loop
    finally:
        runner.stop()


def _started(count: int, scratch: Path, loop: IOLoop) -> LocalCluster:
    """A cluster; if that is interrupted, its processes end with this one, without complaints."""
    from distributed import LocalCluster
    from distributed.deploy.spec import close_clusters

    try:
        return LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            local_directory=str(scratch),
            silence_logs=logging.CRITICAL,
            loop=loop,
        )
    except BaseException:
        atexit.unregister(close_clusters)  # which fails at one that has not started
        logging.getLogger("asyncio").setLevel(logging.CRITICAL)
        raise


def replace_lost(client: Client) -> None:
    """Start workers of a local cluster in place of those that Dask has given up.

    It gives up those that are killed while they start, or take too long to. Workers of another
    scheduler are its own affair.
    """
    cluster = client.cluster
    if cluster is None:
        return
    for name, worker in list(cluster.workers.items()):
        if worker.status.name in _GONE:
            cluster.workers.pop(name, None)
    cluster.scale(len(cluster.worker_spec))


@contextmanager
def workers_of(address: str) -> Iterator[Client]:
    """The workers of a scheduler.

    Raises
    ------
    ParameterError
        If Dask is not installed, or no scheduler answers.
    """
    _check_installed()
    from distributed import Client

    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # `many` says what it would
    try:
        client = Client(address, timeout=_ANSWER)
    except (OSError, ValueError) as error:
        raise ParameterError(
            f"no scheduler answers at {address}", "check the address, such as tcp://10.0.0.1:8786"
        ) from error
    with client:
        yield client


def _check_installed() -> None:
    try:
        import distributed
    except ImportError as error:
        raise ParameterError(
            "many clips need Dask distributed", "pip install 'abs-engine[clips]'"
        ) from error
    del distributed
