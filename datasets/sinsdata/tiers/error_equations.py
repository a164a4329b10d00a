"""The cases of `error_equations`: the paper's vehicles and errors on other tracks, and declared strata.

Everything is written down; no case is drawn at random. Source of vehicles and initial errors: Loginov, Tkachenko,
Chelnokov 2013, section 6, eq. (24).
"""

from __future__ import annotations

from functools import cache

from sinsdata.cases.error_equations import ErrorEquationCase

#: The initial errors (24): m/s, m/s, m/s, m, rad, rad.
PAPER_ERRORS = ("0.01", "0.01", "0.01", "1", "1.57e-7", "1.57e-7")

_LATITUDE = "pi/4"


def error_equation_paper_cases() -> tuple[ErrorEquationCase, ...]:
    """Return the paper's fighter and ship with the paper's initial errors, one hour on four tracks from 45 degrees."""
    return tuple(
        _case(
            f"{vehicle}_{motion}",
            motion,
            (_LATITUDE, height, speed),
            ("3600", "60"),
            **({} if motion in ("parallel", "meridian") else {"heading": "pi/4"}),
            **({"climb_rate": climb, "turn_rate": "pi/1800"} if motion == "climbing_turn" else {}),
        )
        for vehicle, speed, height, climb in (("fighter", "600", "10000", "1"), ("ship", "10", "0", "0"))
        for motion in ("parallel", "meridian", "great_circle", "climbing_turn")
    )


#: Stratum -> its rule.
ERROR_EQUATION_STRATA = {
    "near_equator": "latitude 0, 1e-6 rad, and tracks that cross the equator",
    "near_pole": "0.002 to 0.05 rad from a pole",
    "fast": "1000 to 2000 m/s",
    "slow": "at rest and 0.1 m/s",
    "sharp_turn": "turn rates of 0.03 to 0.1 rad/s, centripetal acceleration 5 to 15 m/s^2",
    "climb": "climb rates of -50 and 300 m/s",
    "error_size": "initial errors (24) times 1e-9 to 100: the error of the linear theory spans 22 decades",
    "long": "two hours: errors grow 3e5 times",
}


#: Cases of the tier ``short``.
ERROR_EQUATION_SHORT = ("polar_parallel", "slow_sharp_turn")


@cache
def error_equation_standard_cases() -> tuple[tuple[ErrorEquationCase, str], ...]:
    """Return the cases of the tier `standard`, each with its stratum (`ERROR_EQUATION_STRATA`)."""
    hour, half, minutes = ("3600", "60"), ("1800", "60"), ("600", "20")
    fighter = (_LATITUDE, "10000", "600")
    turn = {"heading": "pi/3", "climb_rate": "2"}
    listed: dict[str, list[ErrorEquationCase]] = {
        "near_equator": [
            _case("on_the_equator", "parallel", ("0", "10000", "600"), half),
            _case("beside_the_equator", "parallel", ("1e-6", "0", "-250"), half),
            _case("south_across", "meridian", ("0.02", "5000", "-250"), half),
            _case("great_circle_across", "great_circle", ("-0.05", "10000", "300"), half, heading="pi/6"),
        ],
        "near_pole": [
            _case("polar_parallel", "parallel", ("pi/2 - 0.002", "0", "5"), minutes),
            _case("polar_great_circle", "great_circle", ("0.02 - pi/2", "0", "20"), minutes, heading="1"),
            _case("towards_the_pole", "meridian", ("pi/2 - 0.05", "3000", "100"), minutes),
        ],
        "fast": [
            _case("fast_great_circle", "great_circle", ("0.3", "30000", "2000"), half, heading="1.2"),
            _case("fast_south", "meridian", ("0.9", "20000", "-1000"), half),
        ],
        "slow": [
            _case("at_rest", "parallel", ("1", "0", "0"), hour),
            _case("drifting", "great_circle", ("-0.7", "0", "0.1"), hour, heading="-2"),
        ],
        "sharp_turn": [
            _case("slow_sharp_turn", "climbing_turn", ("0.8", "500", "50"), ("120", "5"), turn_rate="0.1", **turn),
            _case("fast_sharp_turn", "climbing_turn", ("-0.8", "5000", "500"), ("120", "5"), turn_rate="-0.03", **turn),
        ],
        "climb": [
            _case(
                "steep_climb", "climbing_turn", ("0.6", "0", "300"), minutes,
                heading="pi/2", climb_rate="300", turn_rate="1e-4",
            ),
            _case(
                "steep_descent", "climbing_turn", ("-0.6", "30000", "200"), minutes,
                heading="0", climb_rate="-50", turn_rate="-1e-3",
            ),
        ],
        "error_size": [
            _case(f"errors_times_1e{power}", "great_circle", fighter, half, power, heading="pi/4")
            for power in ("-9", "-6", "-3", "-1", "1", "2")
        ],
        "long": [_case("two_hours", "parallel", (_LATITUDE, "0", "10"), ("7200", "60"), "-3")],
    }  # fmt: skip
    return tuple((case, stratum) for stratum in ERROR_EQUATION_STRATA for case in listed[stratum])


def _case(
    name: str, motion: str, start: tuple[str, str, str], sampling: tuple[str, str], power: str = "0", **own: str
) -> ErrorEquationCase:
    """Return a case with the errors (24) times a power of ten."""
    latitude, height, speed = start
    duration, interval = sampling
    errors = [error if power == "0" else f"{error}*1e{power}" for error in PAPER_ERRORS]
    given = {"latitude": latitude, "longitude": "0.5", "height": height, "speed": speed, **own}
    sampled = {"duration": duration, "interval": interval, "initial_errors": errors}
    return ErrorEquationCase.from_mapping({"name": name, "motion": motion, **given, **sampled})
