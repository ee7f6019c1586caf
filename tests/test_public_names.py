"""`import fidmap` as the documents show it."""

from __future__ import annotations

import subprocess
import sys

import fidmap


def test_every_public_name_is_there() -> None:
    for name in fidmap.__all__:
        assert getattr(fidmap, name) is not None


def test_evaluate_stays_the_function_whatever_was_imported_first() -> None:
    """The module fidmap.evaluate used to take the function's place as soon as anything imported it."""
    code = "import fidmap; fidmap.evaluate_points; import fidmap.study.jobs; assert callable(fidmap.evaluate)"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert callable(fidmap.evaluate)


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, fidmap; assert 'numpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_scoring_does_not_wait_for_all_of_scipy() -> None:
    """scipy.stats and the parts that only it needs take half a second to load."""
    code = "import sys, fidmap; fidmap.evaluate; assert 'scipy.stats' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
