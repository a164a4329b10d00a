"""What certified rows cost in a file, beside a plain mpmath loop of the same closed form at 50 digits.

Both give pairs of binary64; only the certified ones are proved, and only they are written: Parquet, content hash and
hash of the file included. The loop computes what does not depend on time once, as a careful author would. The ratio of
the row rates of one run is in `extra_info`, and so are the rows: the cost of one does not grow with their number.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pyarrow.parquet as pq
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from sinsdata.cases import Case, DualPrecessionCase, EquatorCase
from sinsdata.generation.destination import destination
from sinsdata.generation.shards import complete
from sinsdata.generation.specification import Specification
from sinsref.arithmetic import BallArithmetic
from sinsref.equator import EquatorModel
from sinsref.exact import ExactNumber
from sinsref.taylor import integrate

DIGITS = 50
PLAIN_ROWS = 1000
REQUIRED_RATIO = 30
#: Of the equator: m/s three times, m, rad twice.
INITIAL_ERRORS = ["0.01", "0.01", "0.01", "1", "1.57e-7", "1.57e-7"]


def precession(rows: int) -> DualPrecessionCase:
    """Return variant 2 of Lebedev, Panov 1989 with eps = 1/2, sampled so that the table has so many rows."""
    return DualPrecessionCase.from_mapping(
        {
            "name": "variant2_general", "spin_rate": "2*pi", "precession_ratio": "1/2", "nutation": "pi/18",
            "spin_rate_dual": "10", "nutation_dual": "100", "initial_velocity": [100, 0, 0],
            "interval": f"100/{rows - 1}", "duration": "100",
        }
    )  # fmt: skip


def equator(rows: int) -> EquatorCase:
    """Return the fighter of Loginov, Tkachenko, Chelnokov 2013, sampled so that the table has so many rows."""
    return EquatorCase.from_mapping(
        {
            "name": "fighter", "v_east": 600, "height": 10000, "interval": f"7200/{rows - 1}", "duration": 7200,
            "initial_errors": INITIAL_ERRORS,
        }
    )  # fmt: skip


#: Takes a time, returns the values of a row.
PlainRow = Callable[[Any], Sequence[Any]]


def plain_precession(context: Any) -> PlainRow:
    """Return (4.4), (4.7) with the initial velocity, and the velocity in body axes, for C = 1."""
    mpf, cos_sin = context.mpf, context.cos_sin
    nu, eps, nu0, th0 = 2 * context.pi, mpf(1) / 2, mpf(10), mpf(100)
    (c, s), (cos_theta, sin_theta) = cos_sin(context.pi / 36), cos_sin(context.pi / 18)
    half_sum, half_difference = (1 + eps) * nu / 2, (1 - eps) * nu / 2

    def row(t: Any) -> Sequence[Any]:
        cos_sum, sin_sum = cos_sin(half_sum * t)
        cos_difference, sin_difference = cos_sin(half_difference * t)
        cos_turn, sin_turn = cos_sin(eps * nu * t)
        q0, q1, q2, q3 = c * cos_sum, s * cos_difference, -s * sin_difference, c * sin_sum
        x = nu0 * t * sin_theta * sin_turn + th0 * cos_turn + (100 - th0)
        y = -nu0 * t * sin_theta * cos_turn + th0 * sin_turn
        z = nu0 * t * (eps + cos_theta)
        # conj(Q) o W_I o Q, by the matrix of the rotation.
        body = (
            (1 - 2 * (q2 * q2 + q3 * q3)) * x + 2 * (q1 * q2 + q0 * q3) * y + 2 * (q1 * q3 - q0 * q2) * z,
            2 * (q1 * q2 - q0 * q3) * x + (1 - 2 * (q1 * q1 + q3 * q3)) * y + 2 * (q2 * q3 + q0 * q1) * z,
            2 * (q1 * q3 + q0 * q2) * x + 2 * (q2 * q3 - q0 * q1) * y + (1 - 2 * (q1 * q1 + q2 * q2)) * z,
        )
        return [q0, q1, q2, q3, x, y, z, *body]

    return row


def plain_equator(context: Any) -> PlainRow:
    """Return the general solution (16), with the constants (17) and C_i computed beforehand."""
    mpf, sqrt, exp, cos_sin = context.mpf, context.sqrt, context.exp, context.cos_sin
    u, a, v = mpf("7.29e-5"), mpf(6378245), mpf(600)
    R = a + 10000
    g = mpf("9.78049") * (a / R) ** 2
    turn, coriolis, force = u + v / R, 2 * u + v / R, g - 2 * u * v - v * v / R
    a24 = 2 * g / R - (v / R) ** 2
    p, q = 2 * turn * coriolis - a24 + force / R, (a24 + 2 * turn * v / R) * force / R
    rho1, rho2 = (sqrt(p * p + 4 * q) - p) / 2, (-sqrt(p * p + 4 * q) - p) / 2
    beta3, mu, w, s = sqrt(rho1), sqrt(-rho2), sqrt(g / R), sqrt(g * R)
    A3, A5 = (rho1 - a24) / (2 * turn), (rho2 - a24) / (2 * turn)
    A6, nu = -beta3 * (coriolis + A3) / force, -mu * (coriolis + A5) / force
    north, up, east, height, latitude, longitude = map(mpf, INITIAL_ERRORS)
    S, D = (east - A5 * height) / (A3 - A5), (mu * longitude - nu * up) / (mu * A6 - nu * beta3)
    c1, c2, c3, c4 = latitude, north / s, (S + D) / 2, (S - D) / 2
    c5, c6 = (A3 * height - east) / (A3 - A5), (A6 * up - beta3 * longitude) / (mu * A6 - nu * beta3)

    def row(t: Any) -> Sequence[Any]:
        cos_w, sin_w = cos_sin(w * t)
        cos_mu, sin_mu = cos_sin(mu * t)
        growing = exp(beta3 * t)
        rising, falling = c3 * growing, c4 / growing
        even, odd = rising + falling, rising - falling
        in_phase, quadrature = c5 * cos_mu + c6 * sin_mu, c6 * cos_mu - c5 * sin_mu
        return [
            s * (c2 * cos_w - c1 * sin_w),
            beta3 * odd + mu * quadrature,
            A3 * even + A5 * in_phase,
            even + in_phase,
            c1 * cos_w + c2 * sin_w,
            A6 * odd + nu * quadrature,
        ]

    return row


def pairs(row: PlainRow, context: Any, duration: int, rows: int) -> np.ndarray[Any, Any]:
    """Run the plain loop over some thousand epochs of the table: head and rest of each value."""
    out = []
    for k in range(0, rows - 1, (rows - 1) // PLAIN_ROWS):
        values = row(context.mpf(duration) * k / (rows - 1))
        heads = [float(x) for x in values]
        out.append([heads, [float(x - head) for x, head in zip(values, heads, strict=True)]])
    return np.array(out)


#: Dataset -> case, plain loop, duration in s.
CASES: dict[str, tuple[Callable[[int], Case], Callable[[Any], PlainRow], int]] = {
    "dual_precession": (precession, plain_precession, 100),
    "equator_errors": (equator, plain_equator, 7200),
}


def write_files(dataset: str, case: Case, folder: Path) -> list[Path]:
    """Write the files of the table ``truth`` as `sinsdata.generation.generate.generate` does, with all hashes."""
    specification = Specification(dataset, "bench", [case], ("truth",))
    place = destination(folder, dataset, "bench", specification.key)
    place.begin()
    tasks = [specification.task(shard) for shard in specification.shards]
    receipts = [complete(task, place) for task in tasks if task.tables == ("truth",)]
    place.leave()
    names = {file.file for receipt in receipts for file in receipt.files}
    return sorted(path for path in folder.rglob("*.parquet") if path.name in names)


@pytest.mark.parametrize("rows", [10_000, 100_000, 1_000_000])
@pytest.mark.parametrize("dataset", CASES)
def bench_certified_file(benchmark: Any, dataset: str, rows: int, tmp_path: Path) -> None:
    """One case, from its parameters to the files of its table ``truth``."""
    case_of, plain, duration = CASES[dataset]
    context = mpmath.MPContext()
    context.dps = DIGITS
    row = plain(context)
    plain_seconds: list[float] = []
    certified_seconds: list[float] = []
    tables: dict[str, Any] = {}

    def once() -> None:
        # One after the other in each round, so that a busy machine slows both.
        start = time.perf_counter()
        tables["plain"] = pairs(row, context, duration, rows)
        middle = time.perf_counter()
        # Each round in a folder of its own: files that are there would be kept.
        tables["certified"] = write_files(dataset, case_of(rows), tmp_path / str(len(plain_seconds)))
        certified_seconds.append((time.perf_counter() - middle) / rows)
        plain_seconds.append((middle - start) / len(tables["plain"]))

    write_files(dataset, case_of(100), tmp_path / "imports")
    benchmark.pedantic(once, rounds=7 if rows < 1_000_000 else 3)

    files = tables["certified"]
    values = [name for name in pq.read_schema(files[0]).names if name not in ("case", "sample", "time", "time_lo")]
    table = np.concatenate([np.stack(pq.read_table(file, columns=values).columns, axis=-1) for file in files])
    assert table.shape == (rows, 2 * tables["plain"].shape[2])
    stride = (rows - 1) // PLAIN_ROWS
    high, low = table[: rows - 1 : stride, 0::2], table[: rows - 1 : stride, 1::2]
    # Heads agree but where 50 digits end at an exact zero; rests to the digits that 50 leave.
    scale = np.abs(high).max(axis=0)
    assert (np.abs(high - tables["plain"][:, 0]) <= 1e-45 * scale).all()
    assert (np.abs(low - tables["plain"][:, 1]) <= 1e-32 * scale).all()

    ratios = [p / c for p, c in zip(plain_seconds, certified_seconds, strict=True)]
    benchmark.extra_info["rows"] = rows
    benchmark.extra_info["bytes_per_row"] = sum(file.stat().st_size for file in files) / rows
    for label, seconds in (("certified", certified_seconds), ("plain_mpmath", plain_seconds)):
        benchmark.extra_info[f"{label}_us_per_row_min"] = 1e6 * min(seconds)
        benchmark.extra_info[f"{label}_us_per_row_median"] = 1e6 * float(np.median(seconds))
    benchmark.extra_info["row_rate_ratio_min"] = min(ratios)
    benchmark.extra_info["row_rate_ratio_median"] = float(np.median(ratios))
    benchmark.extra_info["ratio_required"] = REQUIRED_RATIO


def bench_taylor_path(benchmark: BenchmarkFixture) -> None:
    """One hour of the homogeneous error equations by Taylor series, 50 digits proved by comparison elsewhere."""

    def run() -> None:
        with BallArithmetic(256) as ar:
            matrix = EquatorModel.at(ar, ExactNumber("600"), ExactNumber("10000")).matrix(ar)
            initial = [ar.number(x) for x in INITIAL_ERRORS]

            def field(_: Any, __: Any, x: Sequence[Any]) -> list[Any]:
                return [
                    sum((y * element for y, element in zip(x[1:], row[1:], strict=True)), x[0] * row[0])
                    for row in matrix
                ]

            integrate(ar, field, initial, ar.number(0), ar.number(3600), steps=12, order=50)

    benchmark(run)
