"""The prototype beside the checkout on registration problems; runs in the peers' environment, which has numba.

    prototype_peer.py PROTOTYPE PROBLEMS ANSWERS

PROBLEMS is a JSON list of `fiducials`, `barrels` and `d_max`; ANSWERS gets the value, upper bound and CPU seconds of
each. The first one is solved once beforehand, unseen by the clock: numba compiles then.
"""

from __future__ import annotations

import json
import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path


def main() -> None:
    """Solve all problems in turn."""
    prototype, problems, answers = map(Path, sys.argv[1:])
    spec = spec_from_file_location("prototype", prototype)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    todo = json.loads(problems.read_text(encoding="utf-8"))
    found = []
    for one in [*todo[:1], *todo]:
        start = time.process_time()
        best = module.align(one["fiducials"], one["barrels"], dmax=one["d_max"])
        found.append([float(best["value"]), float(best["ub"]), time.process_time() - start])
    answers.write_text(json.dumps({"compiling": found[0][2] - found[1][2], "solved": found[1:]}), encoding="utf-8")


if __name__ == "__main__":
    main()
