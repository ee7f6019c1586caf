"""Runs jobs on several processes and hands results over in the order of the jobs."""

from __future__ import annotations

import signal
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

AHEAD = 4  # jobs handed out per process: none waits for work, and few results wait for an earlier one


def run(
    jobs: Sequence[Job], work: Callable[[Job], Result], died: Callable[[Job], Result], workers: int
) -> Iterator[Result]:
    """Results of `work`, one per job, in the order of the jobs.

    A process that dies (killed for its memory, say) takes its pool along: the jobs under way then run again, each in
    a process of its own, and only the one that dies again is reported by `died`. A new pool takes the rest.

    Args:
        jobs: picklable values.
        work: a function that raises only for faults of ours.
        died: makes the result of a job whose process died.
        workers: number of processes; 1 works in this one.
    """
    if workers <= 1 or len(jobs) <= 1:
        yield from map(work, jobs)
        return
    waiting = deque(jobs)
    while waiting:
        for job, future in (yield from _pooled(waiting, work, min(workers, len(waiting)))):
            yield _alone(job, work, died) if future.exception() else future.result()


def _pooled(
    waiting: deque[Job], work: Callable[[Job], Result], workers: int
) -> Generator[Result, None, Sequence[tuple[Job, Future[Result]]]]:
    """Work until nothing is waiting or a process dies; returns the jobs that were handed out then."""
    under_way: deque[tuple[Job, Future[Result]]] = deque()
    pool = _pool(workers)
    try:
        while waiting or under_way:
            while waiting and len(under_way) < AHEAD * workers:
                under_way.append((waiting[0], pool.submit(work, waiting[0])))
                waiting.popleft()
            result = under_way[0][1].result()
            under_way.popleft()
            yield result
    except BrokenProcessPool:
        return under_way
    finally:
        pool.shutdown(cancel_futures=True)
    return ()


def _alone(job: Job, work: Callable[[Job], Result], died: Callable[[Job], Result]) -> Result:
    """One job in a process of its own."""
    with _pool(1) as pool:
        try:
            return pool.submit(work, job).result()
        except BrokenProcessPool:
            return died(job)


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_stop_quietly)


def _stop_quietly() -> None:
    """Ctrl-C ends a worker at once and without a traceback; the main process says what there is to say."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
