"""A process that reads damaged files, and what becomes of each."""

from __future__ import annotations

import multiprocessing
import os
import time
import traceback
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from fidmap.model import FidmapError
from fuzz.mutate import mutated
from fuzz.seeds import Seed, seeds

MOST_SECONDS, MOST_BYTES = 10.0, 1 << 30
WALL_SECONDS = 60.0


def damaged(seed: Seed, number: int, all_seeds: list[Seed]) -> bytes:
    """The input of a number; number 0 is the seed itself."""
    if number == 0:
        return seed.data
    rng = np.random.default_rng([number, *seed.name.encode()])
    return mutated(seed.data, [other.data for other in all_seeds], rng)


def attempt(seed: Seed, path: Path) -> tuple[str, str]:
    """What becomes of one input: 'read', 'refused' or 'fault', with what to show of it."""
    started = time.process_time()
    _reset_peak()
    try:
        seed.read(path)
        outcome, text = "read", ""
    except FidmapError as error:
        outcome, text = ("refused", str(error)) if "\n" not in str(error) else ("fault", f"lines: {error!r}")
    except BaseException:  # a panic of a library in Rust is no Exception
        outcome, text = "fault", traceback.format_exc()
    if (took := time.process_time() - started) > MOST_SECONDS:
        return "fault", f"took {took:.1f} s; {text}"
    if (peak := _peak()) > MOST_BYTES:
        return "fault", f"took {peak >> 20} MB; {text}"
    return outcome, text


def _reset_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _peak() -> int:
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return 1024 * int(line.split()[1])


def _work(pipe: Connection, folder: Path) -> None:
    """Take (name, number) from the pipe, read that input, and say what became of it."""
    all_seeds = seeds(folder)
    by_name = {seed.name: seed for seed in all_seeds}
    words = folder / "stderr"
    os.dup2(os.open(words, os.O_WRONLY | os.O_CREAT | os.O_APPEND), 2)
    while (job := pipe.recv()) is not None:
        name, number = job
        seed = by_name[name]
        path = seed.place(folder)
        path.write_bytes(damaged(seed, number, all_seeds))
        outcome, text = attempt(seed, path)
        if said := words.read_text(errors="replace"):
            outcome, text = "fault", f"wrote to stderr: {said[:500]}; {text}"
            os.truncate(words, 0)
        pipe.send((outcome, text))


class Worker:
    """A process that reads inputs; another one takes its place when it dies or hangs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._start()

    def _start(self) -> None:
        ours, theirs = multiprocessing.Pipe()
        self.pipe = ours
        context = multiprocessing.get_context("spawn")
        self.process = context.Process(target=_work, args=(theirs, self.folder), daemon=True)
        self.process.start()
        theirs.close()

    def run(self, name: str, number: int) -> tuple[str, str]:
        """What became of one input."""
        self.pipe.send((name, number))
        try:
            if self.pipe.poll(WALL_SECONDS):
                result: tuple[str, str] = self.pipe.recv()
                return result
            self.process.kill()
            what = f"hung for {WALL_SECONDS:g} s"
        except (EOFError, OSError):
            self.process.join()
            what = f"the process died ({self.process.exitcode})"
        self._start()
        return "fault", what

    def stop(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
