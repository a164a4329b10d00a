"""Copies of the modules that make up a subject: plain Python, with statements that can be exchanged one at a time.

The originals are not touched. Nothing is compiled to machine code: a defect costs the time to interpret a few steps,
not that of a compiler, and binary64 arithmetic is the same in both.
"""

import ast
import contextlib
import functools
import sys
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from types import CodeType, FunctionType, ModuleType
from typing import Any

from sinsbench.mutants.interpretation import PACKAGE, Interpreter, Place, Source, Transform, is_compiled, plain_source
from sinsbench.subjects.loading import LoadedSubject, SubjectError

__all__ = ["Replica", "UnendingError"]

_MOST_TURNS = 50
"""How many times the turns of the right subject a mutant may take before it counts as one without an end."""


class UnendingError(RuntimeError):
    """A mutant goes on and on: it took many times the turns of what it is a mutant of."""


def _module_of(loaded: LoadedSubject) -> str:
    if loaded.subject.dataset is not None:
        return loaded.subject.target.partition(":")[0]
    name = getattr(loaded.function, "__module__", None) or type(loaded.function).__module__
    if not getattr(sys.modules.get(name), "__file__", "").endswith(".py"):
        raise SubjectError(f"{loaded.subject.name}: defects are planted in Python source, and there is none")
    return str(name)


class Replica:
    """A subject made anew from its source.

    Parameters
    ----------
    loaded : LoadedSubject
        The subject: a built-in one is copied with all modules of `sinsbench.subjects` that it imports, a user's with
        its own module alone.
    transform : callable, optional
        Applied to a copy of every top-level statement.
    compiled : bool, default False
        Copy only the module of the subject, and leave all that it imports as it is: the kernels compiled.
    **names
        Further global names of all modules.

    Raises
    ------
    SubjectError
        If the subject has no Python source.
    """

    def __init__(
        self, loaded: LoadedSubject, transform: Transform | None = None, *, compiled: bool = False, **names: Any
    ) -> None:
        self._compiled = compiled
        self._root = _module_of(loaded)
        self._attribute = loaded.subject.target.rpartition(":")[2]
        self._sources: dict[str, Source] = {}
        self._turns, self._limit = 0, 0
        self._names = {"__tick__": self._tick, "__numba__": Interpreter(), **names}
        self._collect(self._root, transform)
        self.modules = self._load({})

    def _collect(self, name: str, transform: Transform | None, below: tuple[str, ...] = ()) -> None:
        source = Source(name, transform) if transform else plain_source(name)
        for imported in source.imported() if self._root.startswith(PACKAGE) else ():
            if imported not in self._sources and imported not in (*below, name):
                self._collect(imported, transform, (*below, name))
        self._sources[name] = source  # after what it imports: the order of loading

    def _tick(self) -> None:
        self._turns += 1
        if self._limit and self._turns > self._limit:
            raise UnendingError("it does not come to an end")

    def limit(self, turns: int) -> None:
        """Stop mutants that take many times as many turns as the right subject did."""
        self._limit = turns * _MOST_TURNS

    @property
    def turns(self) -> int:
        """Turns of loops and calls of functions since the last call of the subject began."""
        return self._turns

    @property
    def statements(self) -> Mapping[Place, ast.stmt]:
        """The top-level statements of all modules, as they were before `transform`."""
        return {
            Place(name, position): node
            for name, source in self._sources.items()
            for position, node in enumerate(source.plain)
        }

    def _load(self, changed: Mapping[Place, CodeType]) -> dict[str, ModuleType]:
        modules: dict[str, ModuleType] = {}
        self._turns = 0
        with contextlib.ExitStack() as stack:
            for name, source in self._sources.items():
                modules[name] = module = ModuleType(name)
                module.__dict__.update(__file__=source.original.__file__, **self._names, **source.exceptions)
                stack.enter_context(_in_place({name: module}))
                if self._compiled and name != self._root:
                    module.__dict__.update(source.original.__dict__)
                    continue
                for position, code in enumerate(source.codes):
                    other = changed.get(Place(name, position))
                    exec(code if other is None else other, module.__dict__)
        return modules

    def function(self, modules: Mapping[str, ModuleType] | None = None) -> Callable[..., Any]:
        """Return the callable of the subject."""
        used = self.modules if modules is None else modules
        self._turns = 0  # those of a mutant before this one do not count
        function: Any = used[self._root]
        for part in self._attribute.split("."):
            function = getattr(function, part)

        @functools.wraps(function)
        def call(*arguments: Any, **keywords: Any) -> Any:
            self._turns = 0
            with _in_place(used):
                return function(*arguments, **keywords)

        return call

    @contextlib.contextmanager
    def exchanged(self, place: Place, statement: ast.stmt) -> Iterator[Callable[..., Any]]:
        """Yield the callable of a subject in which one statement is another, which changes when it is compiled."""
        code = self._sources[place.module].code(statement)
        function = self._exchangeable.get(place)
        if function is None:
            yield self.function(self._load({place: code}))
            return
        # Whoever holds the function, and under whatever name, holds the changed one.
        before = function.__code__
        function.__code__ = next(x for x in code.co_consts if isinstance(x, CodeType) and x.co_name == before.co_name)
        try:
            yield self.function()
        finally:
            function.__code__ = before

    @contextlib.contextmanager
    def intercepted(self, parameters: Container[str], change: Callable[[str, Any], Any]) -> Iterator[None]:
        """Give kernels that are called from outside ``change(name, value)`` in place of some of their arguments.

        Parameters
        ----------
        parameters : container of str
            Names of the parameters.
        change : callable
        """
        inside = False

        def intercepting(kernel: FunctionType, names: Sequence[str]) -> Callable[..., Any]:
            def call(*arguments: Any) -> Any:
                nonlocal inside
                if inside:
                    return kernel(*arguments)
                inside = True
                try:
                    given = zip(names, arguments, strict=True)
                    return kernel(*(change(name, x) if name in parameters else x for name, x in given))
                finally:
                    inside = False

            return call

        calls: dict[int, Callable[..., Any]] = {}
        for place, node in self.statements.items():
            if is_compiled(node) and any(x.arg in parameters for x in node.args.args):
                kernel = self.modules[place.module].__dict__[node.name]
                calls[id(kernel)] = intercepting(kernel, [x.arg for x in node.args.args])
        before = [
            (module.__dict__, name, value)
            for module in self.modules.values()
            for name, value in module.__dict__.items()
            if id(value) in calls
        ]
        try:
            for namespace, name, value in before:
                namespace[name] = calls[id(value)]
            yield
        finally:
            for namespace, name, value in before:
                namespace[name] = value

    @functools.cached_property
    def _exchangeable(self) -> dict[Place, FunctionType]:
        """Functions that nothing has used while the modules were loaded: exchanging their code changes all there is."""
        used = self.reachable(
            place
            for place, node in self.statements.items()
            if not isinstance(node, ast.FunctionDef | ast.Import | ast.ImportFrom)
        )
        result = {}
        for place, node in self.statements.items():
            function = self.modules[place.module].__dict__.get(getattr(node, "name", ""))
            if (
                isinstance(node, ast.FunctionDef)
                and (place not in used or is_compiled(node))  # no kernel runs before it is called for
                and isinstance(function, FunctionType)
                and function.__code__.co_name == node.name
                and function.__module__ == place.module
                and not hasattr(function, "__wrapped__")
            ):
                result[place] = function
        return result

    @functools.cached_property
    def _bindings(self) -> dict[str, dict[str, Place]]:
        """Module -> name -> the statement that gives it its value."""
        result: dict[str, dict[str, Place]] = {name: {} for name in self._sources}
        for place, node in self.statements.items():
            for name in _bound_names(node):
                result[place.module][name] = place
            if isinstance(node, ast.ImportFrom) and node.module in result:
                other = result[node.module]
                for alias in node.names:
                    if alias.name in other:
                        result[place.module][alias.asname or alias.name] = other[alias.name]
        return result

    def reachable(self, roots: Iterable[Place] | None = None) -> set[Place]:
        """Return the statements that some statements rest on by name; by default those that the subject rests on."""
        if roots is None:
            roots = [self._bindings[self._root][self._attribute.partition(".")[0]]]
        reached: set[Place] = set()
        waiting = list(roots)
        while waiting:
            place = waiting.pop()
            if place in reached:
                continue
            reached.add(place)
            bindings = self._bindings[place.module]
            names = {x.id for x in ast.walk(self.statements[place]) if isinstance(x, ast.Name)}
            waiting += [bindings[name] for name in names if name in bindings]
        return reached


def _bound_names(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [x.id for target in targets for x in ast.walk(target) if isinstance(x, ast.Name)]


@contextlib.contextmanager
def _in_place(modules: Mapping[str, ModuleType]) -> Iterator[None]:
    """Let imports find copies, for the time of a ``with`` block."""
    absent = object()
    before = {name: sys.modules.get(name) for name in modules}
    package = sys.modules[PACKAGE]
    attributes = {name: getattr(package, name, absent) for name in (x.rpartition(".")[2] for x in modules)}
    try:
        for name, module in modules.items():
            sys.modules[name] = module
            if name.startswith(f"{PACKAGE}."):
                setattr(package, name.rpartition(".")[2], module)
        yield
    finally:
        for name, original in before.items():
            if original is None:
                del sys.modules[name]
            else:
                sys.modules[name] = original
        for name, value in attributes.items():
            if value is not absent:
                setattr(package, name, value)
            elif hasattr(package, name):
                delattr(package, name)
