"""The data file of published packages: complete, well formed, and its adapters import nothing they should not."""

import ast
import re
import sys
import tomllib
from pathlib import Path

import pytest

from sinsbench.peers.catalogue import (
    CATALOGUE,
    ENVIRONMENTS,
    METHODS,
    CatalogueError,
    packages,
    peers_of,
    read_catalogue,
)
from sinsbench.peers.subjects import loaded_peer, loaded_peers
from sinsbench.subjects.registry import BUILT_IN
from sinsdata.truth.conventions import CONVENTIONS

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "peers.md").read_text(encoding="utf-8")
PACKAGES = {package.distribution: package for package in packages()}
PEERS = {peer.name: (package, peer) for package in packages() for peer in package.subjects}
ADAPTERS = sorted(path for path in (CATALOGUE.parent / "adapters").glob("*.py") if path.name != "__init__.py")
OF_NUMPY_1 = {"qmt", "sophuspy"}


def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def functions(path):
    return {node.name: node for node in tree(path).body if isinstance(node, ast.FunctionDef)}


def imported(path):
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} is run by its path: a relative import fails"
            yield str(node.module).partition(".")[0]


def test_all_the_packages_are_there():
    asked_for = (
        "python-ins ahrs scipy numpy-quaternion quaternionic rowan pyquaternion scikit-kinematics vqf imufusion "
        "pytransform3d jaxlie gtsam pin qmt sophuspy smsfusion inu sidereon"
    )
    assert set(PACKAGES) == set(asked_for.split())
    assert {name for name, package in PACKAGES.items() if package.environment == "numpy1"} == OF_NUMPY_1


def test_the_extra_installs_those_that_run_with_the_numpy_of_today():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extra = {re.split(r"[<>=~!\[ ]", requirement)[0] for requirement in project["optional-dependencies"]["peers"]}
    assert extra == {name for name, package in PACKAGES.items() if package.environment == "current"} - {"scipy"}


@pytest.mark.parametrize("name", PEERS)
def test_a_subject_says_what_it_is_fed_and_where_that_is_documented(name):
    package, peer = PEERS[name]
    assert peer.takes in CONVENTIONS
    assert len(peer.convention) > 20
    assert package.documentation.startswith("https://")
    assert name.split(".")[0] in (*package.imports, package.distribution)
    assert name not in BUILT_IN
    file, _, function = package.target(peer).rpartition(":")
    found = {str(path): path for path in ADAPTERS}[file]
    arguments = [argument.arg for argument in functions(found)[function].args.args]
    assert arguments[2:] == ["interval", "attitude0", "velocity0"]
    assert arguments[:2] == (["angle", "velocity"] if peer.takes == "increments" else ["rate", "force"])


@pytest.mark.parametrize("path", ADAPTERS, ids=lambda path: path.stem)
def test_an_adapter_imports_its_package_and_numpy_alone(path):
    (package,) = [one for one in PACKAGES.values() if any(f"{path}:" in one.target(peer) for peer in one.subjects)]
    foreign = set(imported(path)) - set(sys.stdlib_module_names) - {"numpy"}
    assert foreign == set(package.imports)
    # Its folder comes first where its imports are looked for: it must not stand in the way of the package.
    assert path.stem not in {*package.imports, "numpy", *sys.stdlib_module_names}
    public = {name for name in functions(path) if not name.startswith("_")}
    assert public == {peer.adapter.partition(":")[2] for peer in package.subjects}


def test_subjects_are_made_of_them():
    made = loaded_peers()
    assert [one.subject.name for one in made] == list(PEERS)
    assert all(one.elsewhere and one.subject.samples_per_step == 1 for one in made)
    ins = loaded_peer("pyins.increments")
    assert ins is not None
    assert (ins.subject.takes, ins.subject.order, ins.subject.order_coning) == ("increments", 3, 4)
    assert loaded_peer("panov6") is None
    assert loaded_peer("ahrs") is None


def test_the_page_has_each_subject_and_each_method():
    lines = {line.split("|")[1].strip(): line for line in PAGE.splitlines() if line.startswith("| ")}
    for name, (_, peer) in PEERS.items():
        assert lines[name].split("|")[2].strip() == peer.method
    for name, meaning in METHODS.items():
        assert lines[name] == f"| {name} | {meaning} |"


def test_names_choose_subjects_and_packages_in_the_order_given():
    chosen = [peer.name for _, peer in peers_of(["vqf.VQF", "gtsam.Rot3", "ahrs"], packages())]
    assert chosen[:2] == ["vqf.VQF", "gtsam.Rot3"]
    assert chosen[2:] == [peer.name for peer in PACKAGES["ahrs"].subjects]
    with pytest.raises(CatalogueError, match=r"no package 'arhs'; admissible: scipy, "):
        peers_of(["arhs"], packages())


ENTRY = """
[[package]]
distribution = "good"
imports = ["good"]
environment = "current"
documentation = "https://good.invalid"
[[package.subject]]
name = "good.f"
adapter = "good_adapter:f"
takes = "increments"
method = "exponential"
convention = "none"
order = 2
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('environment = "current"', 'environment = "numpy0"', f"unknown environment .*{', '.join(ENVIRONMENTS)}"),
        ('method = "exponential"', 'method = "exp"', "good: unknown method 'exp' of good.f; admissible: exponential"),
        ("order = 2", "ordre = 2", "good: unknown key ordre; admissible: .*order"),
        ("order = 2", "", "good: .*missing.*'order'"),
        ('documentation = "https://good.invalid"', "", "good: .*missing.*'documentation'"),
        ("[[package]]", f"{ENTRY}[[package]]", "given twice: good.f"),
    ],
)
def test_what_is_wrong_in_a_data_file_is_said(tmp_path, old, new, message):
    path = tmp_path / "peers.toml"
    path.write_text(ENTRY)
    assert [package.distribution for package in read_catalogue(path)] == ["good"]
    path.write_text(ENTRY.replace(old, new, 1))
    with pytest.raises(CatalogueError, match=message):
        read_catalogue(path)
