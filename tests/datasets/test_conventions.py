"""Tables of the input conventions: against formulas written out, and against each other."""

from fractions import Fraction
from hashlib import sha256
from itertools import groupby, pairwise

import mpmath
import numpy as np
import pytest

from sinsdata.cases import DualPrecessionCase
from sinsdata.truth.conventions import CONVENTIONS, QUANTA, TABLES, known_convention
from sinsdata.truth.irregular import PERIOD, arrived, arrived_count, shifts
from sinsdata.truth.sampling import sample
from sinsref.arithmetic import MpArithmetic
from sinsref.exact import ExactNumber
from sinsref.rounding import RoundingTally

MP = mpmath.MPContext()
MP.dps = 70
H = MP.mpf("0.01")


def case_of(**changed):
    given = {
        "name": "general", "spin_rate": "2*pi", "precession_ratio": "0.5", "nutation": "pi/18", "spin_rate_dual": 10,
        "nutation_dual": 100, "initial_velocity": (20, 35, 40), "interval": "0.01", "duration": 10,
    }  # fmt: skip
    return DualPrecessionCase(**(given | changed))


CASE = case_of()
WRAPPING = case_of(duration=170, precession_ratio="-0.75")  # 17,000 samples: more than one block


def rows_of(name, case=CASE, first=0, count=None):
    table = TABLES[name]
    blocks = list(table.blocks(case, first, table.rows(case) - first if count is None else count, RoundingTally()))
    return {
        field: np.concatenate([getattr(block, field) for block in blocks])
        for field in ("index", "time", "time_lo", "high", "low")
    }


def exact(rows):
    """The pairs as numbers of fifty digits and more: (n, w) objects."""
    return np.vectorize(MP.mpf, otypes=[object])(rows["high"]) + np.vectorize(MP.mpf, otypes=[object])(rows["low"])


def written_out(t):
    """Rates (4.1), (4.3) of CASE at a time, and their integrals since 0, which close section 4."""
    nu, eps, th, nu0, th0 = 2 * MP.pi, MP.mpf("0.5"), MP.pi / 18, 10, 100
    s, c, sn, cn = MP.sin(th), MP.cos(th), MP.sin(nu * t), MP.cos(nu * t)
    swing, drift = eps * (nu * th0 * c + nu0 * s), eps * nu * nu0 * t * s
    rates = [
        eps * nu * s * sn, eps * nu * s * cn, nu * (1 + eps * c),
        swing * sn + drift * cn, swing * cn - drift * sn, nu0 * (1 + eps * c) - eps * nu * th0 * s,
    ]  # fmt: skip
    integrals = [
        -eps * s * (cn - 1), eps * s * sn, nu * (1 + eps * c) * t,
        eps * (nu0 * s * t * sn - th0 * c * (cn - 1)), eps * (nu0 * s * t * cn + th0 * c * sn),
        (nu0 * (1 + eps * c) - eps * nu * th0 * s) * t,
    ]  # fmt: skip
    return np.array(rates), np.array(integrals)


def close(found, expected, tolerance="1e-30"):
    """Whether pairs hold the values to their stated accuracy; exact zeros of the formulas are met by zeros."""
    return all(
        abs(x - y) <= MP.mpf(tolerance) * abs(y) or (x == 0 and abs(y) < MP.mpf("1e-60"))
        for x, y in zip(np.ravel(found), np.ravel(expected), strict=True)
    )


SOME = (0, 1, 2, 24, 49, 500, 998)


def test_rates_and_their_integrals_are_the_printed_formulas():
    rates, integrals = exact(rows_of("rates")), exact(rows_of("accumulated"))
    assert len(rates) == len(integrals) == 1001
    for k in SOME:
        expected = written_out(H * k)
        assert close(rates[k], expected[0])
        assert close(integrals[k], expected[1])


def test_increments_are_differences_of_accumulated_and_multiples_of_means():
    integrals, increments, means = (exact(rows_of(name)) for name in ("accumulated", "increments", "mean_rates"))
    # Differences of pairs lose what the integrals have gained on the increments: at most 10 s / 0.01 s and a digit.
    scale = np.abs(integrals).max(axis=0)
    assert (np.abs(integrals[1:] - integrals[:-1] - increments) <= 1e-30 * scale).all()
    assert close(means * H, increments, "1e-29")


def test_resolved_increments_turn_with_the_sample():
    """Both have the same norm, and the means of both differ from the increment by terms of the second order in h."""
    resolved, increments = exact(rows_of("resolved")), exact(rows_of("increments"))
    start, end = resolved[:, :3], resolved[:, 3:]
    assert close((start**2).sum(axis=1), (end**2).sum(axis=1), "1e-28")
    turn = np.cross(increments[:, :3], increments[:, 3:])
    size = np.abs(increments[:, 3:]).max() * np.abs(increments[:, :3]).max()
    # v_end = v - p x v / 2 + ..., v_start = v + p x v / 2 + ..., with p = 0.094 rad a sample.
    assert np.abs(start - end - turn).max() < 0.1 * size
    assert np.abs(start - end).max() > 0.3 * size


@pytest.mark.parametrize("name", TABLES)
def test_rows_agree_with_mpmath(name):
    rows, ar = rows_of(name), MpArithmetic(70)
    table = TABLES[name]
    assert len(rows["high"]) == table.rows(CASE)
    assert rows["index"][0] == table.first_sample
    assert rows["index"][-1] == CASE.samples
    for row in (0, 1, 2, 24, 49, 500, len(rows["high"]) - 1):
        time, *values = table.exact_row(ar, CASE, row)
        assert float(time) == rows["time"][row]
        pairs = [ar.number(x) + ar.number(y) for x, y in zip(rows["high"][row], rows["low"][row], strict=True)]
        assert close(pairs, values)


@pytest.mark.parametrize("name", TABLES)
def test_a_part_of_a_table_is_the_same_as_in_the_whole(name):
    whole = rows_of(name, WRAPPING)
    for first, count in ((0, 1), (16380, 10), (len(whole["high"]) - 3, 3)):
        part = rows_of(name, WRAPPING, first, count)
        for field, values in part.items():
            assert np.array_equal(values, whole[field][first : first + count])


def test_samples_off_the_grid():
    rows = rows_of("nonuniform")
    # Times t_k = h (k + j_k), with j_k drawn here anew.
    parts = [int.from_bytes(sha256(f"nonuniform {k}".encode()).digest()[:8]) % 769 - 384 for k in range(1001)]
    parts[0] = parts[-1] = 0
    times = [H * (1024 * k + part) / 1024 for k, part in enumerate(parts)]
    assert len(set(parts)) > 400
    values = exact(rows)
    for k in (1, 2, 3, 25, 500, 999, 1000):
        assert float(times[k]) == rows["time"][k - 1]
        increment = written_out(times[k])[1] - written_out(times[k - 1])[1]
        assert close(values[k - 1], [times[k] - times[k - 1], *increment])
    lengths = rows["high"][:, 0]
    assert lengths.min() >= 0.01 / 4
    assert lengths.max() <= 0.01 * 7 / 4
    assert lengths.std() > 0.002


def test_the_shifts_repeat():
    epochs = np.arange(1, 200)
    samples = 3 * PERIOD
    assert np.array_equal(shifts(samples, epochs), shifts(samples, epochs + PERIOD))
    assert shifts(samples, np.array([0, samples])).tolist() == [0, 0]
    assert shifts(samples, np.array([PERIOD])) == shifts(samples + 1, np.array([2 * PERIOD]))


def lost_samples(samples):
    """Numbers of the samples that are lost, sample by sample from the rule."""
    draws = [int.from_bytes(sha256(f"dropped {k}".encode()).digest()[:8]) for k in range(PERIOD)]
    lost = set()
    for k, draw in enumerate(draws):
        if draw % 128 == 0:
            lost |= {(k + i) % PERIOD for i in range(1 + (draw >> 8) % 4)}
    return {n for n in range(2, samples) if (n - 1) % PERIOD in lost}


def test_samples_that_never_arrive():
    lost = lost_samples(PERIOD + 1000)
    for samples in (1, 2, 1000, max(n for n in lost if n < 1000), PERIOD, PERIOD + 1, PERIOD + 1000):
        expected = [n for n in range(1, samples + 1) if n not in lost or n in (1, samples)]
        assert arrived_count(samples) == len(expected)
        assert arrived(samples, np.arange(len(expected))).tolist() == expected
    assert 0.017 < len(lost) / (PERIOD + 1000) < 0.021
    ordered = sorted(lost)
    runs = [len(list(run)) for _, run in groupby(enumerate(ordered), lambda pair: pair[1] - pair[0])]
    assert {1, 2, 3, 4} <= set(runs)
    assert max(runs) <= 8  # two bursts may touch


def test_what_arrives_are_increments():
    arriving, whole = rows_of("dropped"), rows_of("increments")
    kept = arriving["index"] - 1
    assert 0.97 < len(kept) / 1000 < 0.99
    for field in ("time", "time_lo", "high", "low"):
        assert np.array_equal(arriving[field], whole[field][kept])


def test_quantised_increments_add_up_to_the_integrals_within_half_a_quantum():
    rows, integrals = rows_of("quantised", WRAPPING), rows_of("accumulated", WRAPPING)
    counts = rows["high"] / QUANTA
    assert np.array_equal(counts, np.rint(counts))
    assert not rows["low"].any()
    sums = np.cumsum(counts, axis=0)
    # The pairs of the integrals stand within 1e-16 of half a quantum at the nearest here: binary64 decides.
    beyond = np.abs(integrals["high"][1:] / QUANTA - sums)
    assert beyond.max() <= 0.5
    assert beyond.max() > 0.499
    assert np.array_equal(rows["time"], integrals["time"][1:])


def counts_of(samples, **parameters):
    """Accumulated counts of the third gyro for a body that spins about an axis at rest."""
    still = {"precession_ratio": 0, "nutation": 0, "spin_rate_dual": 0, "nutation_dual": 0, "interval": 1}
    rows = rows_of("quantised", case_of(**(still | {"duration": samples} | parameters)))
    assert not rows["low"].any()
    return np.cumsum(rows["high"][:, 2] * 2**20).tolist()


HALF = "(1/2097152)"  # half a quantum of the gyros, rad


@pytest.mark.parametrize(
    ("rate", "expected"),
    [
        (HALF, [0, 1, 2, 2, 2, 3, 4, 4]),  # ties go to the even count
        (f"{HALF}*sqrt(2)*sqrt(2)/2", [0, 1, 2, 2, 2, 3, 4, 4]),  # no precision tells it from a tie
        (f"-{HALF}", [0, -1, -2, -2, -2, -3, -4, -4]),
        (f"{HALF}*(1 + 1e-25)", [1, 1, 2, 2, 3, 3, 4, 4]),  # the rest decides
        (f"{HALF}*(1 - 1e-25)", [0, 1, 1, 2, 2, 3, 3, 4]),
        (f"{HALF}*(1 + 1e-25*1e-25*1e-25)", [1, 1, 2, 2, 3, 3, 4, 4]),  # a rest too small to be stored does
        (f"{HALF}*(1 - 1e-25*1e-25*1e-25)", [0, 1, 1, 2, 2, 3, 3, 4]),
    ],
)
def test_counts_half_way(rate, expected):
    assert counts_of(8, spin_rate=rate) == expected


def test_counts_beyond_binary64():
    """1e13/3 rad a sample are 3.5e18 counts, no binary64: the pair holds them exactly."""
    case = case_of(
        spin_rate="1e13/3", precession_ratio=0, nutation=0, spin_rate_dual=0, nutation_dual=0, interval=1, duration=4
    )
    rows = rows_of("quantised", case)
    counts = [round(Fraction(10**13, 3) * k * 2**20) for k in range(5)]
    found = [
        (Fraction(x) + Fraction(y)) * 2**20
        for x, y in zip(rows["high"][:, 2].tolist(), rows["low"][:, 2].tolist(), strict=True)
    ]
    assert found == [b - a for a, b in pairwise(counts)]


def test_names_of_conventions():
    assert known_convention("rates") is CONVENTIONS["rates"]
    with pytest.raises(ValueError, match=r"no input convention 'rate'; admissible: increments, rates, mean_rates, .*"):
        known_convention("rate")
    for convention in CONVENTIONS.values():
        for table, stem in (convention.first, convention.second):
            assert stem in TABLES[table].vectors


@pytest.mark.parametrize("name", CONVENTIONS)
def test_sampled_motions_hold_the_columns_of_their_tables(name):
    motion = sample(CASE, Fraction(1, 2), ExactNumber("0.1"), name)
    fine = case_of(interval="0.01/2")
    for (table, stem), value, rest in zip(
        (motion.convention.first, motion.convention.second),
        (motion.first, motion.second),
        (motion.first_lo, motion.second_lo),
        strict=True,
    ):
        rows = rows_of(table, fine)
        last = rows["high"].shape[1] - 3 * (1 - TABLES[table].vectors.index(stem))
        assert np.array_equal(value, rows["high"][:, last - 3 : last])
        assert np.array_equal(rest, rows["low"][:, last - 3 : last])
        assert np.array_equal(motion.end_times[1:], rows["time"][-len(motion.ends) + 1 :])
    assert (motion.interval, motion.samples, motion.ends[0], motion.ends[-1]) == (0.005, 2000, 0, 2000)
    assert motion.interval_lo == float(MP.mpf("0.005") - MP.mpf(0.005))
    assert len(motion.angle) == 2000
    assert np.array_equal(motion.checkpoints, np.arange(101) * 20)
    if name == "nonuniform":
        assert np.array_equal(motion.time, motion.end_times[motion.checkpoints])
        assert np.array_equal(motion.angle, motion.first)
    else:
        assert motion.time == pytest.approx(np.arange(101) * 0.1, rel=1e-15)
