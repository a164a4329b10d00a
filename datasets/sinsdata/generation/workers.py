"""Who computes the shards: this process, a pool of processes, or a cluster."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from importlib import import_module
from itertools import islice
from multiprocessing.connection import wait as wait_for
from time import sleep
from typing import Any, TypeAlias
from urllib.parse import urlsplit

from sinsdata.generation.destination import Destination
from sinsdata.generation.shards import ShardReceipt, complete
from sinsdata.generation.specification import ShardTask

#: ``report(rows)``: so many rows more are done.
Report: TypeAlias = Callable[[int], None]
#: Shards in order of their completion.
Results: TypeAlias = Iterator[tuple[ShardTask, ShardReceipt]]

#: Tasks that wait, for each worker: enough to keep it busy, few enough to keep them out of memory.
_AHEAD = 2
#: Times that a pool is made anew after the death of a worker, with no shard finished in between.
_REVIVALS = 3
#: Seconds between two looks whether the end of a process is on record.
_REAPED = 1e-3
#: Seconds in which a scheduler must answer, and in which it must have a worker.
_ANSWER, _FIRST_WORKER = 5, 60
_KEPT = "what is finished is kept, and the same command goes on from there"


class WorkerError(RuntimeError):
    """Workers are lost or cannot be reached; the message says which and what to do."""


def check_workers(workers: int, scheduler: str | None) -> None:
    """Check who is to compute, before anything is done.

    Raises
    ------
    WorkerError
        If both processes and a scheduler are asked for, or an address is not of the form ``scheme://host:port``.
    """
    if scheduler is None:
        return
    if workers > 1:
        raise WorkerError("--workers and --scheduler exclude one another: a cluster has its own workers")
    try:
        parts = urlsplit(scheduler)
        sound = parts.scheme in ("tcp", "tls", "ws", "wss") and bool(parts.hostname and parts.port)
    except ValueError:  # of a port that is no number, or too large
        sound = False
    if not sound:
        raise WorkerError(
            f"{scheduler!r} is not the address of a scheduler: it must be scheme://host:port with the scheme tcp, tls, "
            "ws or wss, such as tcp://127.0.0.1:8786"
        )


def here(tasks: Iterable[ShardTask], place: Destination, report: Report) -> Results:
    """Compute shards in this process, one after the other."""
    for task in tasks:
        yield task, complete(task, place, report)


def pool(tasks: Iterable[ShardTask], place: Destination, report: Report, workers: int) -> Results:
    """Compute shards on several processes of this machine.

    A worker that dies, of a signal or for want of memory, is replaced and its shard computed again.

    Raises
    ------
    WorkerError
        If workers die again and again.
    """
    queue, revivals = iter(tasks), 0
    again: list[ShardTask] = []
    while True:
        executor = _executor(workers)
        open_tasks: dict[Future[ShardReceipt], ShardTask] = {}
        try:
            while True:
                while len(open_tasks) < workers * _AHEAD:
                    task = again.pop() if again else next(queue, None)
                    if task is None:
                        break
                    try:
                        open_tasks[executor.submit(complete, task, place)] = task
                    except BrokenProcessPool:  # a worker has died since the last result: the task was not taken
                        again.append(task)
                        raise
                if not open_tasks:
                    return
                finished, _ = wait(open_tasks, return_when=FIRST_COMPLETED)
                for future in finished:
                    receipt = future.result()
                    task = open_tasks.pop(future)
                    revivals = 0
                    report(task.rows * len(task.tables))
                    yield task, receipt
        except BrokenProcessPool:
            revivals += 1
            again += open_tasks.values()
            if revivals > _REVIVALS:
                raise WorkerError(
                    f"workers died {revivals} times in a row, for want of memory perhaps; {_KEPT}"
                ) from None
        finally:
            _stop(executor)


def _executor(workers: int) -> ProcessPoolExecutor:
    # Started afresh and not forked: forked copies of threads and locks of numerical libraries may hang.
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=follow_parent)


def _stop(executor: ProcessPoolExecutor) -> None:
    """End a pool now: also after an interrupt no worker goes on in the background."""
    processes: list[Any] = list((executor._processes or {}).values())
    for process in processes:
        process.terminate()
    executor.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.join()
        # The pool's own thread may have waited for the same child: join then returns before the exit is on record.
        while process.is_alive():
            sleep(_REAPED)


def follow_parent() -> None:
    """Leave interrupts to the parent process, and end when it ends, even if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)


def cluster(tasks: Iterable[ShardTask], place: Destination, report: Report, address: str) -> Results:
    """Compute shards on a Dask cluster, whose workers need this package and a place that all of them reach.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tcp://127.0.0.1:8786``.

    Raises
    ------
    WorkerError
        If Dask is not installed, the scheduler does not answer, has no worker, or is lost, or a shard lost several
        workers.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise WorkerError("a cluster needs the extra `cluster`: pip install 'sinsbench[cluster]'") from None
    try:
        client = distributed.Client(address, timeout=_ANSWER, set_as_default=False)
    # TypeError: of tls and wss, without certificates.
    except (OSError, ValueError, TypeError) as error:
        raise WorkerError(f"{address}: no Dask scheduler answers: {error}") from None
    try:
        with client:
            try:
                client.wait_for_workers(1, timeout=_FIRST_WORKER)
            except TimeoutError:
                raise WorkerError(f"{address}: the scheduler has had no worker for {_FIRST_WORKER} s") from None
            yield from _shared_out(client, distributed.as_completed(loop=client.loop), tasks, place, report)
    except distributed.KilledWorker as error:
        raise WorkerError(f"{error}; {_KEPT}") from None
    except (distributed.comm.CommClosedError, asyncio.CancelledError, CancelledError):
        raise WorkerError(f"{address}: the scheduler is gone; {_KEPT}") from None


def _shared_out(client: Any, running: Any, tasks: Iterable[ShardTask], place: Destination, report: Report) -> Results:
    queue = iter(tasks)
    open_tasks: dict[Any, ShardTask] = {}

    def fill() -> None:
        # Asked each time: workers come and go.
        room = max(1, sum(client.ncores().values())) * _AHEAD - len(open_tasks)
        for task in islice(queue, max(room, 0)):
            future = client.submit(complete, task, place, pure=False)
            open_tasks[future] = task
            running.add(future)

    fill()
    for future in running:
        receipt = future.result()
        task = open_tasks.pop(future)
        report(task.rows * len(task.tables))
        yield task, receipt
        fill()
