"""`./run fuzz [SECONDS] [WORD ...]`: damaged files to every reader, in a process of its own with 1 GB and 10 s each.

What counts as a fault: anything but a value or one sentence, a process that dies or writes to stderr, over 10 s of
work, over 1 GB of memory. Each input has a seed's name and a number; the same two give the same bytes again:

    python -m fuzz --one NAME NUMBER FILE      writes that input and reads it
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from fuzz.seeds import seeds
from fuzz.worker import Worker, attempt, damaged

DEFAULT_SECONDS = 60.0


def inputs(names: list[str], begin: int) -> Iterator[tuple[str, int]]:
    """Every seed unharmed, then all of them in turn with one number after the other."""
    yield from ((name, 0) for name in names)
    number = begin
    while True:
        yield from ((name, number) for name in names)
        number += 1


def main() -> int:
    """Run for some seconds and print what became of the inputs; exit 1 when there was a fault."""
    words = sys.argv[1:]
    if words[:1] == ["--one"]:
        return _one(words[1], int(words[2]), Path(words[3]))
    seconds = float(words.pop(0)) if words and words[0].replace(".", "", 1).isdigit() else DEFAULT_SECONDS
    begin = 1 + int(time.time()) % 1_000_000 * 1000  # other inputs every time
    tally: dict[str, Counter[str]] = {}
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        everything = [seed.name for seed in seeds(Path(folder))]
        names = [name for name in everything if not words or any(word.lower() in name.lower() for word in words)]
        if not names:
            sys.stderr.write(
                f"no kind of file has {' or '.join(words)} in its name; there are {', '.join(everything)}\n"
            )
            return 2
        worker = Worker(Path(folder))
        end = time.monotonic() + seconds
        for name, number in inputs(names, begin):
            if time.monotonic() > end:
                break
            outcome, text = worker.run(name, number)
            if number == 0 and outcome != "read":
                outcome, text = "fault", f"the seed itself is {outcome}: {text}"
            tally.setdefault(name, Counter())[outcome] += 1
            if outcome == "fault":
                faults.append(f"{name} {number}: {text}")
                sys.stderr.write(f"{faults[-1]}\n")
        worker.stop()
    return _report(tally, faults)


def _report(tally: dict[str, Counter[str]], faults: list[str]) -> int:
    for name, counts in tally.items():
        print(f"{name:32} {counts['read']:7} read {counts['refused']:7} refused {counts['fault']:5} faults")
    total = sum(counts.total() for counts in tally.values())
    print(f"{total} inputs to {len(tally)} kinds of files, {len(faults)} faults")
    return 1 if faults else 0


def _one(name: str, number: int, path: Path) -> int:
    """Make one input again and read it in this process."""
    with tempfile.TemporaryDirectory() as folder:
        all_seeds = seeds(Path(folder))
        seed = next(seed for seed in all_seeds if seed.name == name)
        path.write_bytes(damaged(seed, number, all_seeds))
        place = seed.place(Path(folder))
        place.write_bytes(path.read_bytes())
        outcome, text = attempt(seed, place)
    print(outcome, text)
    return 1 if outcome == "fault" else 0


if __name__ == "__main__":
    sys.exit(main())
