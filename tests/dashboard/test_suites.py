"""The benchmark suites leave out no built-in method: what nobody times becomes slower unseen."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from sinsbench.subjects.gyroscopic.catalogue import SUBJECTS
from sinsbench.subjects.registry import BUILT_IN
from sinsdata.format.schema import DATASETS

SUITES = Path(__file__).resolve().parents[2] / "bench" / "suites"


@pytest.fixture(scope="module")
def timed() -> set[str]:
    """Return the parameters in the names of all benchmarks."""
    settings = ("python_files=bench_*.py", "python_functions=bench_* test_*", "addopts=--import-mode=importlib")
    plugins = ("hypothesispytest", "xdist", "cacheprovider")
    options = [*(x for one in settings for x in ("-o", one)), *(x for one in plugins for x in ("-p", f"no:{one}"))]
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", *options, str(SUITES)]
    # Without the settings of the run that this test is in: pytest-benchmark is off inside a worker of xdist.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    made = subprocess.run(command, cwd=SUITES.parents[1], env=environment, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stdout + made.stderr
    return set(re.findall(r"\[(.+)\]$", made.stdout, flags=re.MULTILINE))


@pytest.mark.parametrize("names", [BUILT_IN, SUBJECTS, DATASETS], ids=["methods", "gyroscopic systems", "datasets"])
def test_each_is_timed(timed: set[str], names: dict[str, object]) -> None:
    assert set(names) - timed == set()
