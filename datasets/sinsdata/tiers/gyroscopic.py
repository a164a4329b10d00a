"""The cases of `gyro_systems`: test motions of the paper's claims, and declared strata.

The paper prints no motion; those of the tier ``paper`` are the ones on which its claims are judged: rest on the
rotating Earth, great circle, parallel, manoeuvre, varying speed, near-stop, two families in which the speed goes to
zero, and the manoeuvre at varying altitude. Everything is written down; no case is drawn at random.
"""

from __future__ import annotations

from collections import Counter
from functools import cache

from sinsdata.cases.gyroscopic import GyroCase

#: Latitude and longitude of the manoeuvre: 50 deg + 1.5 deg sin, 30 deg + 0.002 deg/s t + 1 deg sin.
_MANOEUVRE = {
    "motion": "track",
    "latitude": "5*pi/18 + pi/120*sin(2*pi*t/3000)",
    "longitude": "pi/6 + pi/90000*t + pi/180*sin(2*pi*t/4500)",
}
_CIRCLE = {"motion": "great_circle", "latitude": "pi/4", "longitude": "pi/6", "course": "pi/3"}
_PARALLEL = {"motion": "parallel", "latitude": "11*pi/36", "longitude": "pi/6"}
#: Scales of the two families.
_SCALES = ("1", "0.5", "0.25", "0.125")
_HOURS, _MINUTES = {"duration": "7200", "interval": "1"}, {"duration": "7200", "interval": "10"}


def _near_stop(slowest: str, instant: str) -> dict[str, str]:
    """Return a motion east that decelerates by 0.2 m/s^2, turns at an instant and goes back, drifting north."""
    since = f"(t - {instant})"
    return {
        "motion": "track",
        "latitude": f"pi/180 + {slowest}*{since}/6371000",
        "longitude": f"pi/6 + 0.1*{since}*{since}/6371000",
        "rotation_rate": "0",
    }


@cache
def gyro_paper_cases() -> tuple[GyroCase, ...]:
    """Return the tier ``paper``: T0 to T5, T3 at varying altitude, TE and TP at four scales."""
    return tuple(
        GyroCase.from_mapping({"name": name, **_HOURS, **given})
        for name, given in (
            ("T0", {**_PARALLEL, "speed": "0"}),
            ("T1", {**_CIRCLE, "speed": "300"}),
            ("T2", {**_PARALLEL, "speed": "250"}),
            ("T3", _MANOEUVRE),
            ("T4", {**_CIRCLE, "speed": "300 + 100*sin(2*pi*t/1800)"}),
            ("T5", {**_near_stop("0.05", "1800"), "duration": "3600"}),
            ("T3_altitude", {**_MANOEUVRE, "altitude": "5000 - 5000*cos(2*pi*t/3600)"}),
            *((f"TE_{scale}", {**_MINUTES, **_equator(scale)}) for scale in _SCALES),
            *((f"TP_{scale}", {**_MINUTES, **_slow_parallel(scale)}) for scale in _SCALES),
        )
    )


def _equator(scale: str) -> dict[str, str]:
    """Return 2 degrees of latitude and 0.004 deg/s of longitude about the equator of a sphere at rest, scaled."""
    return {
        "motion": "track",
        "latitude": f"{scale}*pi/90*sin(2*pi*t/3000)",
        "longitude": f"{scale}*(pi/45000*t + pi/90*sin(2*pi*t/4500))",
        "rotation_rate": "0",
    }


def _slow_parallel(scale: str) -> dict[str, str]:
    """Return an absolute speed of 600 m/s along the parallel 45 degrees, scaled."""
    return {
        "motion": "parallel",
        "latitude": "pi/4",
        "longitude": "0",
        "speed": f"600*{scale}",
        "rotation_rate": "0",
    }


#: Stratum -> its rule.
GYRO_STRATA = {
    "latitude": "parallels at 0.01, 30, 80 and 89.5 degrees, and a great circle across the equator",
    "near_pole": "a great circle and a track that pass a pole within 0.5 degrees",
    "speed": "great circles at 1, 30, 1000, 3000 and 7000 m/s absolute speed",
    "near_stop": "the absolute speed passes 1, 0.1 and 0.01 m/s",
    "manoeuvre": "tracks that swing with periods of 60 to 600 s, lateral acceleration of 0.3 to 7 m/s^2",
    "attitude": "pitch of 85 degrees, rolls of 0.5 rad/s, and a level vehicle along its path",
    "altitude": "constant 10 km, a climb at 10 m/s, oscillations of 2 km",
    "duration": "12 and 24 hours",
}
#: Cases of the tier ``short``.
GYRO_SHORT = ("manoeuvre_120", "stop_0.1", "climbing")


@cache
def gyro_standard_cases() -> tuple[tuple[GyroCase, str], ...]:
    """Return the cases of the tier ``standard``, each with its stratum (`GYRO_STRATA`)."""
    hour, minutes = {"duration": "3600", "interval": "4"}, {"duration": "600", "interval": "3"}
    parallel = {"motion": "parallel", "longitude": "1", "speed": "200"}
    listed = {
        "latitude": {
            **{
                f"parallel_{degrees}": {**parallel, **hour, "latitude": f"{degrees}*pi/180"}
                for degrees in ("0.01", "30", "80", "89.5")
            },
            "across_the_equator": {**_CIRCLE, **hour, "latitude": "-0.05", "speed": "300"},
        },
        "near_pole": {
            "circle_by_the_pole": {**_CIRCLE, **hour, "latitude": "1.5", "course": "0.1", "speed": "250"},
            "track_by_the_pole": {
                **hour, "motion": "track", "latitude": "pi/2 - 0.008 - 1e-9*t*t", "longitude": "0.001*t",
            },
        },
        "speed": {
            f"speed_{speed}": {**_CIRCLE, **hour, "speed": speed} for speed in ("1", "30", "1000", "3000", "7000")
        },
        "near_stop": {f"stop_{slowest}": {**_near_stop(slowest, "300"), **minutes} for slowest in ("1", "0.1", "0.01")},
        "manoeuvre": {
            f"manoeuvre_{period}": {
                **minutes,
                "motion": "track",
                "latitude": f"0.9 + {amplitude}*sin(2*pi*t/{period})",
                "longitude": "0.0001*t",
            }
            for period, amplitude in (("60", "1e-4"), ("120", "1e-4"), ("300", "1e-4"), ("600", "5e-4"))
        },
        "attitude": {
            "steep_pitch": {**_MANOEUVRE, **hour, "pitch": "17*pi/36*sin(2*pi*t/900)"},
            "rolling": {**_MANOEUVRE, **minutes, "roll": "0.5*t"},
            "level_along_the_path": {
                **parallel, **hour, "latitude": "0.6", "heading": "pi/2", "pitch": "0", "roll": "0",
            },
        },
        "altitude": {
            "at_10_km": {**_CIRCLE, **hour, "speed": "250", "altitude": "10000"},
            "climbing": {**_MANOEUVRE, **minutes, "altitude": "10*t"},
            "heaving": {**_MANOEUVRE, **hour, "altitude": "2000*sin(2*pi*t/400)"},
        },
        "duration": {
            "twelve_hours": {**_MANOEUVRE, "duration": "43200", "interval": "60"},
            "a_day_at_rest": {**_PARALLEL, "speed": "0", "duration": "86400", "interval": "120"},
        },
    }  # fmt: skip
    return tuple(
        (GyroCase.from_mapping({"name": name, **given}), stratum)
        for stratum in GYRO_STRATA
        for name, given in listed[stratum].items()
    )


def gyro_strata() -> tuple[tuple[str, int, str], ...]:
    """Return the strata: name, number of cases, rule."""
    counts = Counter(stratum for _, stratum in gyro_standard_cases())
    return tuple((name, counts[name], rule) for name, rule in GYRO_STRATA.items())
