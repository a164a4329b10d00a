"""Strata of `equator_errors`: ordinary vehicles, special speeds of the equations, and their neighbourhoods.

Source: Loginov, Tkachenko, Chelnokov 2013; the special speeds are zeros of what (10), (17) and the formulas
below (23) divide by or take the root of.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from functools import cache
from typing import Any

from sinsdata.tiers.strata.declaration import Draw, Keys, Stratum, decimal_text, sampling
from sinsref.arithmetic import MpArithmetic, Number
from sinsref.earth import EQUATORIAL_GRAVITY, ROTATION_RATE, SEMI_MAJOR_AXIS
from sinsref.equator import EquatorModel
from sinsref.equator_modes import modes
from sinsref.exact import ExactNumber

#: Magnitudes of ordinary errors: velocity (m/s), height (m), angle (rad).
_VELOCITY, _HEIGHT, _ANGLE = ("0.001", "1"), ("0.1", "100"), ("1e-8", "1e-5")
_ERRORS = (_VELOCITY, _VELOCITY, _VELOCITY, _HEIGHT, _ANGLE, _ANGLE)
_NAMES = ("dv_north", "dv_up", "dv_east", "d_height", "d_latitude", "d_longitude")

#: Exact expressions at zero height, where gravity is the printed constant.
_RADIUS, _RATE, _GRAVITY = SEMI_MAJOR_AXIS.text, ROTATION_RATE.text, EQUATORIAL_GRAVITY.text
_LIMIT = f"{_RADIUS}*(sqrt({_RATE}*{_RATE} + {_GRAVITY}/{_RADIUS}) - {_RATE})"
_WEST_LIMIT = f"-{_RADIUS}*(sqrt({_RATE}*{_RATE} + {_GRAVITY}/{_RADIUS}) + {_RATE})"
_SCHULER = f"{_RADIUS}*(sqrt({_GRAVITY}/{_RADIUS}) - {_RATE})"
_WEST_SCHULER = f"-{_RADIUS}*(sqrt({_GRAVITY}/{_RADIUS}) + {_RATE})"
_REST = f"-{_RATE}*{_RADIUS}"
_NO_CORIOLIS = f"-2*{_RATE}*{_RADIUS}"


def _errors(draw: Draw) -> list[str]:
    return [draw.signed(name, *bounds) for name, bounds in zip(_NAMES, _ERRORS, strict=True)]


def _case(draw: Draw, v_east: str, height: str, sampled: Keys, **more: Any) -> Keys:
    return {"v_east": v_east, "height": height, **sampled, "initial_errors": _errors(draw), **more}


def _tilt(draw: Draw, orthogonal: bool) -> dict[str, Any]:
    """Return a misalignment of 1e-7 to 1e-3: of a small rotation, or with nine elements of their own."""
    if orthogonal:
        x, y, z = (draw.signed(f"rotation_{axis}", "1e-7", "1e-3") for axis in "xyz")
        matrix = [["0", _negative(z), y], [z, "0", _negative(x)], [_negative(y), x, "0"]]
    else:
        matrix = [[draw.signed(f"l{i}{j}", "1e-7", "1e-3") for j in (1, 2, 3)] for i in (1, 2, 3)]
    return {"misalignment": matrix, "inertial_longitude": draw.uniform("inertial_longitude", "-3.14", "3.14")}


def _negative(text: str) -> str:
    return text[1:] if text.startswith("-") else f"-{text}"


@cache
def _root(condition: str, near: str) -> Decimal:
    """Return the speed at zero height where a quantity vanishes, to 30 digits, by the secant method."""
    with MpArithmetic(60) as ar:

        def discriminant(model: EquatorModel) -> Number:
            return model.p * model.p + model.q * 4

        def detuning(model: EquatorModel) -> Number:
            forcing = model.frame_rate * model.frame_rate * 4
            return forcing * forcing - model.p * forcing - model.q

        quantity = {"discriminant": discriminant, "detuning": detuning}[condition]
        height = ExactNumber(0)
        root = ar.context.findroot(lambda v: quantity(EquatorModel.at(ar, v, height)), ar.number(near))
        return Decimal(ar.context.nstr(root, 30))


#: Places to look for the equal roots, rho1 = rho2, and for 2 omega_N = +-mu: east and west, m/s.
_EQUAL_ROOTS = (("discriminant", "7941.57"), ("discriminant", "-8873"))
_DETUNING = (("detuning", "3644.26"), ("detuning", "-4574.21"))


def _neighbour(draw: Draw, centres: Sequence[str], furthest: int, nearest: int) -> str:
    """Return a special speed itself for the first indices, then speeds beside it, nearer from case to case.

    The offsets, on either side, fall decade by decade from 10**furthest to 10**nearest m/s, and begin anew.
    """
    centre = centres[draw.index % len(centres)]
    step = draw.index // len(centres)
    if step == 0:
        return centre
    exponent = furthest - (step - 1) % (furthest - nearest)
    return f"{centre} + {draw.signed('offset', f'1e{exponent - 1}', f'1e{exponent}')}"


def _ship(draw: Draw) -> Keys:
    return _case(draw, draw.uniform("v_east", "-20", "20"), "0", sampling("20", draw.integer("samples", 180, 720)))


def _aircraft(draw: Draw) -> Keys:
    speed = draw.choice("direction", ("", "-")) + draw.uniform("v_east", "60", "600")
    height = draw.uniform("height", "100", "15000")
    return _case(draw, speed, height, sampling("10", draw.integer("samples", 360, 1800)))


def _missile(draw: Draw) -> Keys:
    west = draw.choice("direction", (False, True))
    speed = draw.uniform("v_east", "-7500", "-1000") if west else draw.uniform("v_east", "1000", "6500")
    height = draw.log_uniform("height", "1e4", "4e5")
    return _case(draw, speed, height, sampling("10", draw.integer("samples", 60, 360)))


def _single_error(draw: Draw) -> Keys:
    place = draw.index % 6
    errors = ["0"] * 6
    errors[place] = draw.signed(_NAMES[place], *_ERRORS[place])
    speed = draw.uniform("v_east", "-600", "600")
    return _case(draw, speed, "5000", sampling("60", 120), initial_errors=errors)


def _stability_limit(draw: Draw) -> Keys:
    return _case(draw, _neighbour(draw, (_LIMIT, _WEST_LIMIT), 1, -9), "0", sampling("600", 12))


def _beyond_limit(draw: Draw) -> Keys:
    low, high = draw.choice("region", (("7450", "7940"), ("7945", "12000"), ("-8870", "-8380"), ("-12000", "-8880")))
    return _case(draw, draw.uniform("v_east", low, high), "0", sampling("60", 60))


def _vanishing_frame_rate(draw: Draw) -> Keys:
    return _case(draw, _neighbour(draw, (_REST,), 1, -12), "0", sampling("600", 12))


def _vanishing_coriolis_rate(draw: Draw) -> Keys:
    return _case(draw, _neighbour(draw, (_NO_CORIOLIS,), 0, -6), "0", sampling("600", 12))


def _equal_roots(draw: Draw) -> Keys:
    centres = [decimal_text(_root(*place)) for place in _EQUAL_ROOTS]
    return _case(draw, _neighbour(draw, centres, 0, -6), "0", sampling("600", 12))


def _schuler_resonance(draw: Draw) -> Keys:
    speed = _neighbour(draw, (_SCHULER, _WEST_SCHULER), 0, -5)
    return _case(draw, speed, "0", sampling("600", 12), **_tilt(draw, orthogonal=False))


def _double_rate_resonance(draw: Draw) -> Keys:
    speed = _neighbour(draw, [decimal_text(_root(*place)) for place in _DETUNING], 0, -5)
    return _case(draw, speed, "0", sampling("600", 12), **_tilt(draw, orthogonal=False))


def _misalignment(draw: Draw) -> Keys:
    tilt = _tilt(draw, orthogonal=draw.index % 2 == 0)
    height = draw.uniform("height", "0", "15000")
    return _case(draw, draw.uniform("v_east", "-600", "600"), height, sampling("120", 30), **tilt)


def _long_duration(draw: Draw) -> Keys:
    samples = draw.integer("hours", 12, 24) * 12
    height = draw.uniform("height", "0", "12000")
    return _case(draw, draw.uniform("v_east", "-300", "300"), height, sampling("300", samples))


def _cancellation(draw: Draw) -> Keys:
    """Return initial errors on the decaying exponential, rounded to 3 digits more from case to case."""
    speed, height, digits = draw.uniform("v_east", "-600", "600"), "10000", 3 + 3 * (draw.index % 6)
    with MpArithmetic(60) as ar:
        model = EquatorModel.at(ar, ExactNumber(speed), ExactNumber(height))
        m = modes(ar, model)
        decaying = (-m.beta3, m.alpha3_growing, ar.number(1), -m.alpha6)
        up, east, high, longitude = (ar.context.nstr(10 * x, digits) for x in decaying)
    return _case(draw, speed, height, sampling("60", 120), initial_errors=["0", up, east, high, "0", longitude])


def _extreme_errors(draw: Draw) -> Keys:
    errors = [draw.signed(name, "1e-20", "1e20") for name in _NAMES]
    speed = draw.uniform("v_east", "-600", "600")
    return _case(draw, speed, "5000", sampling("60", 60), initial_errors=errors)


def _heights(draw: Draw) -> Keys:
    below = draw.index % 3 == 0
    height = draw.uniform("height", "-11000", "-10") if below else draw.log_uniform("height", "1e5", "4e7")
    return _case(draw, draw.uniform("v_east", "-600", "600"), height, sampling("60", 120))


def _epochs(draw: Draw) -> Keys:
    dense = draw.index % 2 == 0
    interval = draw.log_uniform("interval", "1e-4", "0.1") if dense else draw.log_uniform("interval", "1000", "10000")
    sampled = sampling(interval, draw.integer("samples", 200, 400) if dense else draw.integer("samples", 1, 5))
    return _case(draw, draw.uniform("v_east", "-600", "600"), "5000", sampled)


#: 200 cases.
EQUATOR_STRATA: tuple[Stratum, ...] = (
    Stratum("ship", 12, "Within 20 m/s at height 0, 1 to 4 h, every 20 s.", _ship),
    Stratum("aircraft", 20, "60 to 600 m/s east or west at 0.1 to 15 km, 1 to 5 h, every 10 s.", _aircraft),
    Stratum(
        "missile", 12, "1 to 6.5 km/s east or 1 to 7.5 km/s west at 10 to 400 km, up to 1 h, every 10 s.", _missile
    ),
    Stratum("single_error", 12, "One initial error at a time, within 600 m/s, 2 h.", _single_error, 3),
    Stratum(
        "stability_limit",
        24,
        "Both speeds at which the specific force vanishes, exactly, then 10 m/s to 1e-9 m/s beside them, 2 h.",
        _stability_limit,
        15,
    ),
    Stratum(
        "beyond_limit", 8, "Speeds without a real growing mode: two oscillations, or complex roots.", _beyond_limit
    ),
    Stratum(
        "vanishing_frame_rate",
        16,
        "omega_N = 0 exactly (at rest in inertial space), then 10 m/s to 1e-12 m/s beside it, 2 h.",
        _vanishing_frame_rate,
        9,
    ),
    Stratum(
        "vanishing_coriolis_rate",
        8,
        "2 u + v/R = 0 exactly, then 1 m/s to 1e-6 m/s beside it, 2 h.",
        _vanishing_coriolis_rate,
    ),
    Stratum(
        "equal_roots",
        16,
        "rho1 = rho2 to 30 digits, east and west, then 1 m/s to 1e-6 m/s beside it, 2 h.",
        _equal_roots,
    ),
    Stratum(
        "schuler_resonance",
        12,
        "omega_N = +-omega exactly, with misalignment, then 1 m/s to 1e-5 m/s beside it, 2 h.",
        _schuler_resonance,
    ),
    Stratum(
        "double_rate_resonance",
        12,
        "2 omega_N = +-mu to 30 digits, with misalignment, then 1 m/s to 1e-5 m/s beside it, 2 h.",
        _double_rate_resonance,
        6,
    ),
    Stratum("misalignment", 14, "Misalignment of 1e-7 to 1e-3, of rotations and of any matrices, 1 h.", _misalignment),
    Stratum("long_duration", 10, "12 to 24 h, within 300 m/s, every 5 min.", _long_duration),
    Stratum(
        "cancellation",
        6,
        "Errors of the decaying exponential, rounded to 3 to 18 digits: they fall, and grow again sooner or later.",
        _cancellation,
    ),
    Stratum("extreme_errors", 6, "Initial errors of 1e-20 to 1e20 side by side.", _extreme_errors),
    Stratum("heights", 6, "11 km below the ellipsoid up to 40,000 km above it.", _heights),
    Stratum("epochs", 6, "Epochs 0.1 ms to 0.1 s apart, or 17 min to 2.8 h apart.", _epochs, 3),
)
