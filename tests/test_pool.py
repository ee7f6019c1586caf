"""The pool: results in the order of the jobs, and a process that dies costs only its own job."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fidmap.study import pool


def work(job: int) -> str:
    if job < 0:
        os._exit(9)
    return f"{job} done"


def died(job: int) -> str:
    return f"{job} died"


def never(job: int) -> str:
    raise AssertionError(job)


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_jobs(workers: int) -> None:
    """More jobs than are handed out ahead."""
    jobs = list(range(2 * pool.AHEAD + 3))
    assert list(pool.run(jobs, work, never, workers)) == [f"{job} done" for job in jobs]


def test_a_killed_process_costs_only_its_own_job() -> None:
    """Jobs before, beside and long after it have their results."""
    jobs = [0, -1, *range(1, 10)]
    assert list(pool.run(jobs, work, died, 2)) == ["0 done", "-1 died", *(f"{job} done" for job in range(1, 10))]


def test_no_jobs() -> None:
    assert list(pool.run([], work, died, 2)) == []


def test_an_own_bug_is_raised() -> None:
    with pytest.raises(AssertionError, match=r"^0$"):
        list(pool.run([0, 1, 2], never, died, 2))


SLEEPER = """
import os, signal, time
from fidmap.study import pool
def sleep(job):
    open(f"started{os.getpid()}", "w").close()
    time.sleep(60)
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    try:
        list(pool.run([0, 1, 2, 3], sleep, None, 2))
    except KeyboardInterrupt:
        print("stopped")
"""


def test_ctrl_c_ends_all_processes_at_once_and_quietly(tmp_path: Path) -> None:
    """A terminal sends the signal to all of them: no traceback of a worker, no waiting for what is under way."""
    (tmp_path / "sleeper.py").write_text(SLEEPER)
    with subprocess.Popen(
        [sys.executable, "sleeper.py"],
        cwd=tmp_path,
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while len(list(tmp_path.glob("started*"))) < 2:
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert (out, err) == ("stopped\n", "")
