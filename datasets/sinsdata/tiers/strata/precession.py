"""Strata of `dual_precession`: coning and general precession, and where integrators of increments are tried hardest.

Source: Lebedev, Panov 1989, section 4.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any

from sinsdata.tiers.strata.declaration import Draw, Keys, Stratum, sampling

#: Samples of every fourth case of a stratum: enough to see what happens, few enough for a first step.
_FEW = 64


def _sampled(draw: Draw, interval: str, samples: int) -> dict[str, str]:
    return sampling(interval, _FEW if draw.index % 4 == 3 else samples)


def _case(draw: Draw, **changes: Any) -> Keys:
    """Return a motion at a practical rate, 500 samples of 0.01 s, with some keys changed."""
    return {
        "spin_rate": draw.signed("spin_rate", "0.5", "20"),
        "precession_ratio": draw.signed("precession_ratio", "0.1", "3"),
        "nutation": draw.uniform("nutation", "0.02", "3.1"),
        "spin_rate_dual": draw.signed("spin_rate_dual", "0.1", "20"),
        "nutation_dual": draw.signed("nutation_dual", "0.1", "100"),
        "initial_velocity": [draw.signed(f"w_{axis}", "0.1", "100") for axis in "xyz"],
        **_sampled(draw, "0.01", 500),
        **changes,
    }


def _interval(draw: Draw, spin_rate: str, lowest: str, highest: str) -> str:
    """Return the interval h, to two digits, for which nu h is about log-uniform between two bounds."""
    phase = Decimal(draw.log_uniform("phase", lowest, highest))
    return f"{phase / abs(Decimal(spin_rate)):.1e}"


def _coning(draw: Draw) -> Keys:
    spin = f"2*pi*{draw.log_uniform('frequency', '0.5', '100')}"
    nutation = draw.log_uniform("nutation", "1e-4", "0.2")
    sampled = _sampled(draw, draw.choice("interval", ("0.001", "0.0025", "0.01")), 1000)
    return _case(draw, spin_rate=spin, precession_ratio="-1", nutation=nutation, **sampled)


def _general(draw: Draw) -> Keys:
    return _case(draw, **_sampled(draw, "0.01", 1000))


def _special_ratio(draw: Draw) -> Keys:
    centre, step = ("-1", "0", "1")[draw.index % 3], draw.index // 3
    if step == 0:
        return _case(draw, precession_ratio=centre)
    exponent = -2 * (step - 1)
    return _case(draw, precession_ratio=f"{centre} + {draw.signed('offset', f'1e{exponent - 2}', f'1e{exponent}')}")


def _small_nutation(draw: Draw) -> Keys:
    return _case(draw, nutation=draw.log_uniform("nutation", f"1e-{draw.index + 1}", f"1e-{draw.index}"))


def _near_pi(draw: Draw) -> Keys:
    return _case(draw, nutation=f"pi - {draw.log_uniform('nutation', f'1e-{draw.index + 1}', f'1e-{draw.index}')}")


def _flat_nutation(draw: Draw) -> Keys:
    return _case(draw, nutation=("0", "pi")[draw.index % 2])


def _slow_spin(draw: Draw) -> Keys:
    spin = draw.signed("spin_rate", "1e-8", "1e-4")
    return _case(draw, spin_rate=spin, **_sampled(draw, draw.choice("interval", ("0.01", "0.1", "1")), 500))


def _fast_spin(draw: Draw) -> Keys:
    spin = draw.signed("spin_rate", "100", "1e4")
    return _case(draw, spin_rate=spin, **_sampled(draw, _interval(draw, spin, "0.01", "1"), 500))


def _large_dual(draw: Draw) -> Keys:
    spin_dual, nutation_dual = (draw.signed(field, "1e3", "1e6") for field in ("spin_rate_dual", "nutation_dual"))
    return _case(draw, spin_rate_dual=spin_dual, nutation_dual=nutation_dual)


def _zero_dual(draw: Draw) -> Keys:
    still = {"initial_velocity": ["0", "0", "0"]} if draw.index % 2 else {}
    return _case(draw, spin_rate_dual="0", nutation_dual="0", **still)


def _one_dual(draw: Draw) -> Keys:
    return _case(draw, **{("spin_rate_dual", "nutation_dual")[draw.index % 2]: "0"})


def _fine_sampling(draw: Draw) -> Keys:
    spin = draw.signed("spin_rate", "0.5", "20")
    return _case(draw, spin_rate=spin, **_sampled(draw, _interval(draw, spin, "1e-6", "1e-3"), 1000))


def _coarse_sampling(draw: Draw) -> Keys:
    spin = draw.signed("spin_rate", "0.5", "20")
    return _case(draw, spin_rate=spin, **_sampled(draw, _interval(draw, spin, "0.5", "10"), 500))


def _long_duration(draw: Draw) -> Keys:
    spin, samples = draw.signed("spin_rate", "1e-4", "0.01"), 1440
    dual = {field: draw.signed(field, "1e-4", "0.01") for field in ("spin_rate_dual", "nutation_dual")}
    return _case(draw, spin_rate=spin, **dual, **sampling("60", samples))


def _initial_attitude(draw: Draw) -> Keys:
    # The square of a quaternion of integers over its norm: rational, of norm exactly 1.
    w, x, y, z = (draw.integer(f"q_{axis}", 1, 99) * draw.choice(f"sign_{axis}", (1, -1)) for axis in "wxyz")
    vector = x * x + y * y + z * z
    square = (w * w - vector, 2 * w * x, 2 * w * y, 2 * w * z)
    return _case(draw, initial_attitude=[f"{component}/{w * w + vector}" for component in square])


def _large_velocity(draw: Draw) -> Keys:
    return _case(draw, initial_velocity=[draw.signed(f"w_{axis}", "1e4", "1e7") for axis in "xyz"])


#: 200 cases. Unless the rule says otherwise: 0.5 to 20 rad/s, eps of either sign from 0.1 to 3, any nutation,
#: 500 samples of 0.01 s; every fourth case has 64 samples.
PRECESSION_STRATA: tuple[Stratum, ...] = (
    Stratum("coning", 18, "eps = -1, 0.5 to 100 Hz, half-angles of 1e-4 to 0.2 rad, 1, 2.5 or 10 ms.", _coning, 3),
    Stratum("general", 16, "Any precession at a practical rate, 1000 samples.", _general),
    Stratum(
        "special_ratio",
        24,
        "eps = -1, 0, 1 exactly, then beside them, two decades nearer from case to case, down to 1e-14.",
        _special_ratio,
        15,
    ),
    Stratum("small_nutation", 16, "Nutation of 1 to 1e-16 rad, a decade a case.", _small_nutation, 11),
    Stratum("near_pi_nutation", 12, "pi less 1 to 1e-12 rad, a decade a case.", _near_pi),
    Stratum("flat_nutation", 8, "Nutation exactly 0 or pi: the axis of rotation is fixed.", _flat_nutation),
    Stratum("slow_spin", 12, "1e-8 to 1e-4 rad/s, sampled every 0.01 to 1 s.", _slow_spin),
    Stratum("fast_spin", 12, "100 to 1e4 rad/s, nu h from 0.01 to 1.", _fast_spin, 3),
    Stratum("large_dual", 12, "Dual parts of 1e3 to 1e6 (m/s^2, m/s).", _large_dual),
    Stratum("zero_dual", 8, "No specific force; the apparent velocity is constant or zero.", _zero_dual),
    Stratum("one_dual", 8, "One of the two dual parts is zero.", _one_dual),
    Stratum("fine_sampling", 10, "nu h from 1e-6 to 1e-3, 1000 samples.", _fine_sampling),
    Stratum("coarse_sampling", 14, "nu h from 0.5 to 10: up to more than a turn a sample.", _coarse_sampling, 7),
    Stratum("long_duration", 10, "24 h at 1e-4 to 0.01 rad/s, every minute.", _long_duration),
    Stratum("initial_attitude", 12, "Rational unit quaternions as initial attitude.", _initial_attitude),
    Stratum("large_velocity", 8, "Initial velocity of 1e4 to 1e7 m/s an axis.", _large_velocity),
)
