"""Hook of MkDocs: the pages keep their places in the repository, so that their links hold there and on the site.

MkDocs reads one folder, but the papers, the cards of the datasets and the examples lie beside the code. The API
reference has a page for each module, made from its docstrings.
"""

import ast
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
PAGES = ("*.md", "docs/*.md", "docs/*.svg", "reference/papers/*.md", "datasets/cards/*.md", "examples/*", "LICENSE*")
PACKAGES = {"sinsref": "reference", "sinsdata": "datasets", "sinsbench": "bench"}
#: Not of use from outside: adapters to foreign packages, the entries of worker processes.
LEFT_OUT = ("sinsbench.peers.adapters", "sinsbench.subjects.worker", "sinsbench.subjects.isolated")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Return the files of the theme, the pages of the repository with what they lead to, and the reference."""
    modules = {name: summary for package in PACKAGES for name, summary in _modules(package)}
    pages = {path.relative_to(ROOT).as_posix(): path for pattern in PAGES for path in ROOT.glob(pattern)}
    made = {f"api/{name}.md": f"---\ntitle: {name}\n---\n\n::: {name}\n" for name in modules}
    made["api/index.md"] = _index(modules)
    return Files(
        [
            *(file for file in files if file.src_dir != config.docs_dir),
            *(File.generated(config, name, abs_src_path=str(path)) for name, path in pages.items() if path.is_file()),
            *(File.generated(config, name, content=text) for name, text in made.items()),
        ]
    )


def _modules(package: str) -> list[tuple[str, str]]:
    """Return name and first line of the docstring of every module that holds more than this line."""
    room = ROOT / PACKAGES[package]
    found = []
    for path in sorted((room / package).rglob("*.py")):
        name = ".".join(path.relative_to(room).with_suffix("").parts).removesuffix(".__init__")
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if len(tree.body) > 1 and not name.startswith(LEFT_OUT):
            found.append((name, (ast.get_docstring(tree) or "").split("\n")[0]))
    return found


def _index(modules: dict[str, str]) -> str:
    lines = ["# API reference"]
    for package in PACKAGES:
        lines += ["", f"## {package}", "", "| module | |", "|---|---|"]
        own = (name for name in modules if name.partition(".")[0] == package)
        lines += [f"| [{name}]({name}.md) | {modules[name]} |" for name in own]
    return "\n".join(lines)
