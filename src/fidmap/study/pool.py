"""Runs jobs on several processes and hands results over in the order of the jobs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def run(
    jobs: Sequence[Job], work: Callable[[Job], Result], died: Callable[[Job], Result], workers: int
) -> Iterator[Result]:
    """Results of `work`, one per job, in the order of the jobs.

    A worker that dies (killed for its memory, say) takes its pool along: every job without a result then runs again
    in a process of its own, and only the one that dies again is reported by `died`.

    Args:
        jobs: picklable values.
        work: a function that raises only for faults of ours.
        died: makes the result of a job whose process died.
        workers: number of processes; 1 works in this one.
    """
    if workers <= 1 or len(jobs) <= 1:
        yield from map(work, jobs)
        return
    context = get_context("spawn")
    with ProcessPoolExecutor(min(workers, len(jobs)), mp_context=context) as pool:
        futures = [pool.submit(work, job) for job in jobs]
        for job, future in zip(jobs, futures, strict=True):
            try:
                yield future.result()
            except BrokenProcessPool:
                yield _alone(job, work, died)


def _alone(job: Job, work: Callable[[Job], Result], died: Callable[[Job], Result]) -> Result:
    """One job in a process of its own."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        try:
            return pool.submit(work, job).result()
        except BrokenProcessPool:
            return died(job)
