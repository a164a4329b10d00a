"""Independent parts of a run on several processes, results in the order of the parts."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from sinsdata.generation.workers import follow_parent

#: More processes would each load the compiler and the truth anew: memory for little time.
_PROCESSES = 2


@dataclass(frozen=True)
class Part:
    """A piece of work.

    Attributes
    ----------
    title : str
        For the progress bar.
    function : callable
        A function of a module.
    arguments : tuple
        What it is called with; must survive pickling.
    """

    title: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]


def run_parts(parts: Sequence[Part], report: Callable[[int, int, str], None], processes: int = _PROCESSES) -> list[Any]:
    """Run parts on several processes, where there are as many cores, and return their results in order.

    Parameters
    ----------
    parts : sequence of Part
        Long ones first: the processes then end together.
    report : callable
        ``report(done, total, what)`` after each part.
    processes : int, default 2
        At most.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    processes = min(processes, cores, len(parts))
    if processes < 2:
        results = []
        for number, part in enumerate(parts):
            report(number, len(parts), part.title)
            results.append(part.function(*part.arguments))
        return results
    # Started afresh and not forked: forked copies of threads and locks of numerical libraries may hang.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context, initializer=follow_parent) as pool:
        with _interrupts_held():
            futures = [pool.submit(part.function, *part.arguments) for part in parts]
        try:
            _wait(futures, parts, report)
        except BaseException:
            # Also after an interrupt no worker goes on in the background.
            for process in list(pool._processes.values()):
                process.terminate()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return [future.result() for future in futures]


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Let an interrupt wait, also for the processes that are started meanwhile: until they follow their parent."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _wait(futures: list[Future[Any]], parts: Sequence[Part], report: Callable[[int, int, str], None]) -> None:
    open_parts = dict(zip(futures, parts, strict=True))
    while open_parts:
        report(len(parts) - len(open_parts), len(parts), next(iter(open_parts.values())).title)
        finished, _ = wait(open_parts, return_when=FIRST_COMPLETED)
        for future in finished:
            future.result()
            del open_parts[future]
