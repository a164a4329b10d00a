"""The cases of `mast_antenna`: the paper's scenario, and declared strata of seeds and stresses.

The paper gives one motion, one length of run and the noise of gyros and accelerometers. It says neither how many
satellites there are nor how well they are measured: the tier ``paper`` has one and four of them (N1, N4), each at three
grades (G1 to G3). Its six cases share their sensors.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import cache
from typing import Any

from sinsdata.cases.mast import FAULTS, MastCase

#: Grade -> standard deviations of range rates, m/s, and ranges, m.
GRADES = {"G1": ("0.1", "5"), "G2": ("0.01", "1"), "G3": ("0.001", "0.1")}
_RUN = {"duration": "1000", "interval": "0.01"}
_STRESS = {"duration": "100", "interval": "0.01"}
_BRIEF = {"duration": "1", "interval": "0.01"}
#: Amplitudes, rad/s, and frequencies, rad/s, of the mast's rates.
_AMPLITUDES, _FREQUENCIES = ("0.43", "0.3"), ("2.45", "2.7")
#: Changes of amplitude and frequency that the paper says cost less than 6 per cent: 50 and 80 per cent.
_CHANGES = ("0.2", "0.5", "1.5", "1.8")
#: What a fault adds, in units of the reading: a hundred times its noise, or thereabouts.
_SIZES = ("5e-6", "0.01", "5e-6", "0.01", "1", "50")


@cache
def mast_paper_cases() -> tuple[MastCase, ...]:
    """Return the tier ``paper``: N4_G1, which holds the sensors, and N4 and N1 at the other grades."""
    found: list[MastCase] = []
    for satellites in ("4", "1"):
        for grade, (range_rate_sd, range_sd) in GRADES.items():
            shared = {"run": found[0].name} if found else {}
            given = {"satellites_used": satellites, "range_rate_sd": range_rate_sd, "range_sd": range_sd, **shared}
            found.append(MastCase.from_mapping({"name": f"N{satellites}_{grade}", **_RUN, **given}))
    return tuple(found)


#: Stratum -> its rule.
MAST_STRATA = {
    "seed": "the paper's motion for 100 s, four satellites of grade G1: seeds 1000 to 1007 of data and initial errors",
    "initial_attitude": "initial errors of the attitudes of 0.1 rad, seeds 1000 to 1002",
    "step": "readings at 50 and 20 Hz",
    "mast_amplitude": "rates of the mast 20, 50, 150 and 180 per cent of the paper's",
    "mast_frequency": "frequencies of the mast 20, 50, 150 and 180 per cent of the paper's",
    "fault": "a bias of one reading from 50 s on, about a hundred times its noise",
    "motion": "at rest, east at 60 degrees of latitude, across the equator, climbing, turning; masts of 1 and 25 m",
    "brief": "1 s each: the paper's motion, one satellite of it, and a fast motion east with a fault",
}
#: Cases of the tier ``short``.
MAST_SHORT = ("brief_paper", "brief_one_satellite", "brief_fault")


def _rates(amplitude: str = "1", frequency: str = "1") -> dict[str, list[str]]:
    pairs = zip(_AMPLITUDES, _FREQUENCIES, strict=True)
    return {"mast_rate": [f"{amplitude}*{a}*cos({frequency}*{f}*t)" for a, f in pairs]}


def _seeded(number: int) -> dict[str, str]:
    return {"seed": str(number), "error_seed": str(number)}


@cache
def mast_standard_cases() -> tuple[tuple[MastCase, str], ...]:
    """Return the cases of the tier ``standard``, each with its stratum (`MAST_STRATA`)."""
    still = {"velocity_north": "0", "velocity_up": "0"}
    # Overhead in the middle of the Atlantic as over the paper's place: nodes and arguments moved with the vehicle.
    equator = [["pi/6", "0"], ["0", "pi/6"], ["pi/3", "-pi/6"], ["11*pi/60", "pi/18"]]
    listed: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
        "seed": {f"seed_{n}": {**_STRESS, **_seeded(n)} for n in range(1000, 1008)},
        "initial_attitude": {
            f"attitude_{n}": {**_STRESS, **_seeded(n), "attitude_error_sd": "0.1/sqrt(3)"} for n in range(1000, 1003)
        },
        "step": {f"step_{h}": {"duration": "100", "interval": h, **_seeded(1000)} for h in ("0.02", "0.05")},
        "mast_amplitude": {f"amplitude_{x}": {**_STRESS, **_seeded(1000), **_rates(amplitude=x)} for x in _CHANGES},
        "mast_frequency": {f"frequency_{x}": {**_STRESS, **_seeded(1000), **_rates(frequency=x)} for x in _CHANGES},
        "fault": {
            f"fault_{what}": {**_STRESS, **_seeded(1000), "fault": what, "fault_time": "50", "fault_size": size}
            for what, size in zip(FAULTS, _SIZES, strict=True)
        },
        "motion": {
            "at_rest": {**_STRESS, **still},
            "east": {**_STRESS, "latitude": "pi/3", "velocity_east": "250 + 10*sin(0.1*t)", "velocity_north": "0"},
            "across_the_equator": {**_STRESS, "latitude": "-0.0005", "satellites": equator},
            "climbing": {**_STRESS, "velocity_up": "10 + 3*sin(0.5*t)"},
            "turning": {**_STRESS, "angular_rate": ["0.02*sin(t)", "0.02*cos(t)", "0.3"]},
            "short_mast": {**_STRESS, "mast_length": "1"},
            "long_mast": {**_STRESS, "mast_length": "25", **_rates("0.5", "0.5")},
        },
        "brief": {
            "brief_paper": _BRIEF,
            "brief_one_satellite": {
                **_BRIEF, "run": "brief_paper", "satellites_used": "1", "range_rate_sd": "0.01", "range_sd": "1",
            },
            "brief_fault": {
                "duration": "1", "interval": "0.02", "latitude": "pi/3", "velocity_east": "1000 + 50*sin(3*t)",
                "vehicle_rotation": ["0.1", "-0.2", "0.3"], "mast_rotation": ["0.2", "-0.1", "0"],
                "fault": "range", "fault_time": "0.5", "fault_size": "50",
            },
        },
    }  # fmt: skip
    return tuple(
        (MastCase.from_mapping({"name": name, **given}), stratum)
        for stratum in MAST_STRATA
        for name, given in listed[stratum].items()
    )


def mast_strata() -> tuple[tuple[str, int, str], ...]:
    """Return the strata: name, number of cases, rule."""
    counts = Counter(stratum for _, stratum in mast_standard_cases())
    return tuple((name, counts[name], rule) for name, rule in MAST_STRATA.items())
