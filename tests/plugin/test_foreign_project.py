"""A project of someone else's, the one of docs/plugin.md, in a folder of its own: the plugin comes with the package."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "plugin.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"```python\n# (\w+\.py)\n(.*?)```", PAGE, flags=re.DOTALL))
RIGHT, WRONG = "CONING = 2 / 3", "CONING = 0"
#: Hypothesis is no part of the project, and takes longer to load than all the rest.
OPTIONS = ("-p", "no:hypothesispytest", "-p", "no:cacheprovider", "-p", "no:xdist")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "pytest.ini").write_text("[pytest]\nfilterwarnings = error\n")
    return tmp_path


def run_pytest(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    # Nothing of the settings of the run that this test is in.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    command = [sys.executable, "-m", "pytest", *OPTIONS, *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_it_passes_and_its_scores_stand_beside_its_times(project: Path) -> None:
    made = run_pytest(project, "--benchmark-json=times.json")
    assert made.returncode == 0, made.stdout + made.stderr
    assert "4 passed" in made.stdout
    (benchmark,) = json.loads((project / "times.json").read_text())["benchmarks"]
    (scores,) = benchmark["extra_info"]["sins_scores"]
    assert scores["case"] == "variant2_coning"
    assert 0 < scores["drift_deg_per_h"] < 0.02


def test_it_fails_without_the_coning_term_and_says_by_how_much(project: Path) -> None:
    assert RIGHT in FILES["navigation.py"]
    (project / "navigation.py").write_text(FILES["navigation.py"].replace(RIGHT, WRONG))
    made = run_pytest(project, "test_navigation.py")
    assert made.returncode == 1
    assert "3 failed" in made.stdout
    (line,) = re.findall(r"```text\n(.*?)\n```", PAGE)
    assert line in made.stdout
    assert "integrate on mine at 0.02 s: observed_order is 1.99" in made.stdout
    # The place that is shown is the test's own line, not one of the plugin.
    assert "scores.py:" not in made.stdout


def test_a_run_without_the_fixtures_imports_the_plugin_alone(tmp_path: Path) -> None:
    (tmp_path / "test_modules.py").write_text(
        "import sys\n\n"
        "def test_modules():\n"
        "    ours = {name for name in sys.modules if name.partition('.')[0] in ('sinsbench', 'sinsdata', 'sinsref')}\n"
        "    assert ours == {'sinsbench', 'sinsbench.pytest_plugin'}\n"
        "    assert not {'numpy', 'numba', 'pandas', 'pyarrow', 'flint'} & sys.modules.keys()\n"
    )
    made = run_pytest(tmp_path, "-p", "no:benchmark")
    assert made.returncode == 0, made.stdout
