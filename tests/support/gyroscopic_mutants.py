"""The modules of the gyroscopic subjects as plain Python, and defects planted in one statement of theirs at a time."""

import ast
import copy
from functools import cache, partial
from types import ModuleType, SimpleNamespace

import numpy as np

from mutants import is_seen, load, source
from sinsbench.instrumentation import rebuilt_kernels
from sinsbench.mutants.planting import TermPlanter
from sinsbench.subjects.gyroscopic import equations, stepping
from sinsbench.subjects.outcome import OutcomeError


@cache
def plain_kernels():
    """The kernels as plain Python functions, and a decorator that compiles nothing."""
    module = ModuleType("plain_kernels")
    vars(module).update(rebuilt_kernels(), compiled=lambda function: function)
    return module


def plain(module, replaced=None):
    """A module of its own, with nothing in it compiled; its imports see the `replaced` modules."""
    return load(source(module), module, {"sinsbench.subjects.kernels": plain_kernels(), **(replaced or {})})


@cache
def plain_stepping():
    """The drivers of fixed step with nothing compiled: compiled code checks no index, and a mutant asks for any."""
    right_hand_sides = plain(equations)
    right_hand_sides.math = SimpleNamespace(sqrt=np.sqrt, sin=np.sin, cos=np.cos, pi=np.pi)  # NaN, as compiled code has
    module = plain(stepping, {equations.__name__: right_hand_sides})
    module.function_pointer = lambda name, condition=False: getattr(right_hand_sides, name)
    module.compiled_run = module.FIXED_STEP.__getitem__
    return module


def name_of(statement):
    """What a statement defines, '' for other statements."""
    if isinstance(statement, ast.Assign | ast.AnnAssign):
        target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
        return target.id if isinstance(target, ast.Name) else ""
    return statement.name if isinstance(statement, ast.FunctionDef) else ""


def tolerated(holds, name, module):
    """Whether `holds`, which a mutant that refuses to run does not."""
    try:
        return holds(module, name)
    except OutcomeError:
        return False


def unseen(original, holds, left_out=(), replaced=None):
    """Places of the defects in a module that `holds(module, name)` does not see, and how many were planted.

    A defect is planted in functions and assignments except those `left_out`; the module is loaded once, its
    definitions from the changed one on are made again.
    """
    module = plain(original, replaced)
    assert holds(module, "")
    body = [statement for statement in source(original).body if name_of(statement) not in ("", "__all__")]
    right, found, count = dict(vars(module)), [], 0
    for position, statement in enumerate(body):
        name = name_of(statement)
        if name in left_out:
            continue
        later = [other for other in body[position + 1 :] if not isinstance(other, ast.FunctionDef)]
        listing = TermPlanter()
        listing.visit(copy.deepcopy(statement))
        count += listing.count

        def mutant(target, statement=statement, later=later):
            changed = ast.Module([TermPlanter(target).visit(copy.deepcopy(statement)), *later], [])
            exec(compile(ast.fix_missing_locations(changed), module.__name__, "exec"), vars(module))
            return module

        for target, place in enumerate(listing.places):
            before, _, after = place.rpartition(" -> ")
            if before.endswith(f": {after}"):  # an exchange of two equal arguments
                continue
            if not is_seen(partial(mutant, target), partial(tolerated, holds, name)):
                found.append(place)
            vars(module).update(right)
    return found, count
