"""BibTeX of the benchmark and of the papers behind datasets and subjects."""

from __future__ import annotations

from collections.abc import Sequence

from sinsbench import __version__
from sinsbench.cli.errors import UsageError
from sinsbench.subjects.registry import BUILT_IN

_SOFTWARE = f"""@software{{sinsbench,
  title = {{sinsbench: ground truth and honest scores for the numerical algorithms of strapdown inertial navigation}},
  author = {{{{The sinsbench developers}}}},
  version = {{{__version__}}}
}}"""

_PAPERS = {
    "loginov2013": """@article{loginov2013,
  author = {Loginov, M. Yu. and Tkachenko, M. G. and Chelnokov, Yu. N.},
  title = {Analytical Solution of Linear Differential Error Equations of Strapdown Inertial Navigation System,
           Functioning in the Normal Geographic Reference Frame, for the Case of an Object,
           Following the Geographical Equator},
  journal = {Izv. Saratov Univ. Math. Mech. Inform.},
  volume = {13},
  number = {1},
  pages = {69--84},
  year = {2013},
  doi = {10.18500/1816-9791-2013-13-1-1-69-84}
}""",
    "lebedev1989": """@article{lebedev1989,
  author = {Lebedev, D. V. and Panov, A. P.},
  title = {Synthesis of high-accuracy algorithms for determining the apparent velocity of a rigid body},
  note = {In Russian},
  year = {1989}
}""",
    "chelnokov1991": """@article{chelnokov1991,
  author = {Chelnokov, Yu. N.},
  title = {Determination of the position and orientation of moving objects from the readings of strapdown {INS} sensors
           by on-board solution of the quaternion equations of motion of gyroscopic systems},
  journal = {Izv. AN SSSR, Mekhanika Tverdogo Tela},
  number = {4},
  note = {In Russian},
  year = {1991}
}""",
    "sokolov2024": """@article{sokolov2024,
  author = {Sokolov, S. V. and Pogorelov, V. A. and Reshetnikova, I. V.},
  title = {Nonlinear stochastic estimation of the navigation parameters of the antenna of a mobile radio engineering
           complex by inertial-satellite measurements},
  note = {In Russian},
  year = {2024}
}""",
}
_OF_DATASET = {
    "equator_errors": "loginov2013",
    "error_equations": "loginov2013",
    "dual_precession": "lebedev1989",
    "gyro_systems": "chelnokov1991",
    "mast_antenna": "sokolov2024",
}


def citations(names: Sequence[str]) -> list[str]:
    """Return BibTeX entries for names of papers, datasets or subjects, the benchmark first; all papers without a name.

    Raises
    ------
    UsageError
        For a name that is none of these.
    """
    wanted: dict[str, None] = {}
    for name in names or _PAPERS:
        dataset = BUILT_IN[name].dataset if name in BUILT_IN else name
        paper = _OF_DATASET.get(str(dataset), name)
        if paper not in _PAPERS:
            known = [*_PAPERS, *_OF_DATASET, *BUILT_IN]
            raise UsageError(f"nothing to cite by the name {name!r}; admissible: {', '.join(known)}")
        wanted[paper] = None
    return [_SOFTWARE, *(_PAPERS[paper] for paper in wanted)]
