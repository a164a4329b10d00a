"""The mast's estimators on short motions: consistent, quick to settle, shaken by faults, clear about refusals."""

import dataclasses
import functools

import numpy as np
import pytest

from mast_motion import errors, simulated
from sinsbench.subjects.mast import catalogue, continuous, relinearised, subjects
from sinsbench.subjects.mast.contract import BreakdownError, StabilityError
from sinsbench.subjects.mast.running import is_positive
from sinsbench.subjects.outcome import OutcomeError

SEEDS = range(1000, 1008)
#: Errors that are known: the twist of lambda is exact at the start and takes part in nothing.
KNOWN = [*range(14), 15, 16]
BLOCKS = {"navigation": list(range(9)), "antenna": [9, 10, 11], "mast": [12, 13, 15, 16], "all": KNOWN}
#: What is printed for the range loses the covariance at once.
BROKEN = ("cekf_printed", "cekf_printed_313")
FIELDS = ("mu", "longitude", "latitude", "velocity", "height", "eta", "lambda", "mast_rate")


def nees(run, result, block):
    e, p = errors(run, result)[:, block], result["covariance"][:, block][:, :, block]
    return np.einsum("ti,ti->t", e, np.linalg.solve(p, e[..., None])[..., 0])


@functools.cache
def estimated(name, seed, scale=1.0):
    """A run of 10 s and what an estimator makes of it."""
    run = simulated(10.0, seed, seed, scale=scale)
    return run, getattr(subjects, name)(run.inputs, run.start)


def mean_nees(name, block="all"):
    """Mean over eight seeds at every second of 10 s."""
    return np.mean([nees(*estimated(name, seed), BLOCKS[block]) for seed in SEEDS], axis=0)


def test_the_relinearised_filter_is_consistent():
    """From 3 s on the mean of eight joint NEES stays within its 99.9 % band, that of chi^2/8 for 128 degrees."""
    mean = mean_nees("relinearised_az")
    assert (mean[3:] > 9.9).all()
    assert (mean[3:] < 23.2).all()


@pytest.mark.parametrize("block", ["navigation", "antenna", "mast"])
def test_the_discrete_filter_without_constraint_is_consistent_by_block(block):
    """99.9 % bands of the mean of eight at the end of 10 s, for 9, 3 and 4 degrees of freedom."""
    low, high = {"navigation": (4.7, 14.8), "antenna": (0.7, 6.9), "mast": (1.2, 8.2)}[block]
    assert low < mean_nees("mekf_nu", block)[-1] < high


def test_going_back_to_the_start_settles_antenna_and_mast_sooner():
    """After 5 s the inflated constraint has counted little: in full weight it leaves about half of the errors."""
    for block in (slice(9, 12), slice(12, 14)):
        sizes = []
        for name in ("relinearised_az", "mekf_nu_az"):
            found = [errors(*estimated(name, seed))[5, block] for seed in SEEDS]
            sizes.append(np.sqrt(np.mean(np.square(found))))
        assert sizes[0] < 0.7 * sizes[1]


def test_windows_lead_to_the_same_trajectory(monkeypatch):
    """Greatest posterior probability does not depend on the way there: to a thousandth of a standard deviation."""
    run = simulated(4.0)
    monkeypatch.setattr(relinearised, "SETTLED", 1e-6)
    ends = []
    for windows in ((4.0,), (1.0, 2.0, 4.0)):
        monkeypatch.setattr(relinearised, "WINDOWS", windows)
        ends.append(subjects.relinearised_az(run.inputs, run.start))
    deviations = np.sqrt(np.diagonal(ends[0]["covariance"][-1]))[KNOWN]
    difference = (errors(run, ends[0]) - errors(run, ends[1]))[-1, KNOWN]
    assert np.abs(difference / deviations).max() < 1e-3
    assert ends[0]["nis"][-1] == pytest.approx(ends[1]["nis"][-1], rel=1e-6)


@pytest.fixture(scope="module")
def longer():
    return simulated(20.0)


def nis_rate(result, since=10):
    """Normalised innovations squared over their degrees of freedom from a second on."""
    return np.diff(result["nis"])[since:].sum() / np.diff(result["nis_freedom"])[since:].sum()


@pytest.mark.parametrize(("name", "count"), [("relinearised_az", 12), ("mekf_nu", 11), ("mekf_eta", 11), ("cekf", 11)])
def test_innovations_are_those_of_a_right_model(longer, name, count):
    """1000 steps: the standard deviation of the mean is 0.013, four of them."""
    result = getattr(subjects, name)(longer.inputs, longer.start)
    assert abs(nis_rate(result) - 1) < 0.055
    assert result["nis_freedom"][-1] == 2000 * count


@pytest.mark.parametrize(
    "fault", ["gravity_twice", "earth_rate_twice", "vehicle_turn_ignored", "mast_sign", "turn_sign"]
)
def test_a_fault_in_the_filter_alone_shows_in_the_innovations(longer, fault):
    result = getattr(subjects, f"mekf_nu_az_{fault}")(longer.inputs, longer.start)
    assert nis_rate(result) > 2  # 75 standard deviations


def test_the_missing_derivative_matters_to_the_antenna_alone(longer):
    without, complete = (getattr(subjects, name)(longer.inputs, longer.start) for name in ("cekf", "cekf_complete"))
    difference = errors(longer, without)[-1] - errors(longer, complete)[-1]
    assert np.abs(difference[9:12]).max() > 1e-5
    assert np.abs(difference[:3]).max() < 1e-6


@pytest.mark.parametrize(
    ("name", "attitude"), [("cekf_printed", 0.5), ("cekf_printed_root", 0.5), ("cekf_repaired", 0.02)]
)
def test_the_printed_equations_fail_on_a_physical_motion(name, attitude):
    """Started within 0.006 rad, the vehicle's attitude is lost within two seconds."""
    run = simulated(3.0, satellites=1)
    result = getattr(subjects, name)(run.inputs, run.start)
    assert np.linalg.norm(errors(run, result)[2, :3]) > attitude
    assert nis_rate(result, 0) > 2


@pytest.mark.parametrize("name", [name for name in catalogue.SUBJECTS if name not in BROKEN])
def test_every_estimator_returns_what_the_contract_says(name):
    run = simulated(2.0, satellites=1)
    result = getattr(subjects, name)(run.inputs, run.start)
    assert result["time"].tolist() == [0, 1, 2]
    assert [result[field].shape for field in FIELDS] == [(3, 4), (3,), (3,), (3, 3), (3,), (3, 4), (3, 4), (3, 2)]
    assert result["covariance"].shape == (3, 17, 17)
    assert all(np.isfinite(values).all() for values in result.values())
    for name_of in ("mu", "eta", "lambda"):
        assert np.abs(np.linalg.norm(result[name_of], axis=1) - 1).max() < 1e-12
    again = getattr(subjects, name)(run.inputs, run.start)
    assert all(np.array_equal(result[key], again[key]) for key in result)


@pytest.mark.parametrize("name", ["cekf", "cekf_repaired", "mekf_eta", "mekf_nu_az_vehicle_turn_ignored"])
def test_the_first_row_is_the_start(name):
    run = simulated(1.0)
    result, start = getattr(subjects, name)(run.inputs, run.start), run.start
    for field in FIELDS:
        given = getattr(start, "lambda_" if field == "lambda" else field)
        assert np.allclose(result[field][0], given, rtol=0, atol=1e-15)
    deviations = np.sqrt(np.diagonal(result["covariance"][0]))
    assert np.allclose(deviations, start.deviations, rtol=1e-12, atol=1e-12)


def with_start(run, **changes):
    return dataclasses.replace(run.start, **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mu": np.array([2.0, 0, 0, 0])}, "mu has the norm 2"),
        ({"latitude": np.pi / 2}, "latitude = 1.57"),
        ({"height": np.nan}, "height = nan"),
        ({"deviations": -np.ones(17)}, r"deviations\[0\] is negative"),
        ({"deviations": np.ones(16)}, "deviations has shape 16"),
        ({"covariance": np.diag([*[1.0] * 16, -1.0])}, r"covariance\[16, 16\] = -1: negative variance"),
        ({"covariance": np.eye(17) + 2 * (np.eye(17, k=1) + np.eye(17, k=-1))}, "covariance is not positive"),
        ({"covariance": np.eye(17) + 0.5 * np.eye(17, k=1)}, "covariance is not symmetric"),
    ],
)
def test_a_start_that_cannot_be_is_refused(changes, message):
    run = simulated(1.0)
    with pytest.raises(ValueError, match=message):
        subjects.mekf_nu_az(run.inputs, with_start(run, **changes))


def spoilt(array, index, value):
    result = np.array(array)
    result[index] = value
    return result


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("rate1", lambda a: spoilt(a, (50, 1, 2), np.nan), r"rate1 is not finite, first at t = 0\.5 s"),
        ("range", lambda a: a[:-1], r"range has shape \(99, 3, 4\), expected \(100, 3, 4\)"),
        ("satellite_position", lambda a: spoilt(a, (3, 0, 0), np.inf), r"first at t = 0\.015 s"),
        ("time", lambda a: spoilt(a, 7, a[8]), "time: a step of 0.02 s at t = 0.06 s"),
        ("time", lambda a: a[:1], "time does not increase"),
        ("noise", lambda a: dataclasses.replace(a, range=0.0), r"noise\.range = 0\.0: a positive number"),
        ("constants", lambda a: a._replace(mast_length=0.0), "mast_length = 0.0: a positive number"),
    ],
)
def test_inputs_that_cannot_be_are_refused(field, change, message):
    run = simulated(1.0)
    with pytest.raises(ValueError, match=message):
        subjects.cekf(dataclasses.replace(run.inputs, **{field: change(getattr(run.inputs, field))}), run.start)


def wider(run):
    """5 m and 0.1 m/s at the start instead of 3 m and 0.05 m/s."""
    deviations = run.start.deviations.copy()
    deviations[[3, 4, 8]] *= 5 / 3
    deviations[5:8] *= 2
    return with_start(run, deviations=deviations)


def test_a_step_beyond_the_stability_bound_is_refused(monkeypatch):
    """And with good reason: without the refusal the covariance is lost within the first steps."""
    run = simulated(1.0)
    with pytest.raises(
        StabilityError, match=r"is 3\.3 at the start, stable below 2\.78.* 0\.843 times .* below 0\.00843 s"
    ):
        subjects.cekf(run.inputs, wider(run))
    monkeypatch.setattr(continuous, "BOUND", np.inf)
    with pytest.raises(BreakdownError, match=r"not finite.*, first at t = 0\.") as caught:
        subjects.cekf(run.inputs, wider(run))
    assert caught.value.time < 0.5
    assert len(caught.value.partial["time"]) == 1
    assert isinstance(caught.value, OutcomeError)


@pytest.mark.parametrize(
    ("variances", "coupling", "positive"),
    [((1.0, 4e-14), 1e-7, True), ((1.0, 4e-14), 3e-7, False), ((1.0, -1e-20), 0.0, False), ((1.0, 0.0), 0.0, True)],
)
def test_what_is_a_covariance(variances, coupling, positive):
    """Whatever the units; a variance of zero is known, one below is none."""
    covariance = np.diag(variances) + coupling * np.array([[0.0, 1.0], [1.0, 0.0]])
    assert is_positive(covariance, np.array([1.0, 1e-13])) is positive


@pytest.mark.parametrize("name", BROKEN)
def test_a_covariance_that_is_no_longer_positive_is_told(name):
    """Ranges of 2e7 m whose root is printed wrong: within two seconds the velocity is off by 500 m/s."""
    run = simulated(2.0)
    with pytest.raises(BreakdownError, match=r"positive.*, first at t = ") as caught:
        getattr(subjects, name)(run.inputs, run.start)
    assert np.linalg.norm(errors(run, caught.value.partial)[-1, 5:8]) > 100


@pytest.mark.parametrize("name", ["mekf_nu_az", "relinearised_az", "cekf"])
def test_a_run_that_overflows_says_when(name):
    run = simulated(3.0)
    inputs = dataclasses.replace(run.inputs, specific_force1=spoilt(run.inputs.specific_force1, 150, 1e200))
    with pytest.raises(BreakdownError) as caught:
        getattr(subjects, name)(inputs, run.start)
    assert caught.value.time == pytest.approx(1.5, abs=0.011)
    assert caught.value.partial["time"].tolist() == [0, 1]
    assert caught.value.status == "not finite"


def test_large_initial_errors_leave_only_the_relinearised_filter_consistent():
    """Ten times the initial errors, 0.1 rad of attitude among them: mean joint NEES of four at 10 s, for 16 degrees."""
    means = [
        np.mean([nees(*estimated(name, seed, 10.0), KNOWN)[-1] for seed in list(SEEDS)[:4]])
        for name in ("relinearised_az", "mekf_nu_az")
    ]
    assert 7.8 < means[0] < 27  # 99.9 % band of chi^2/4 for 64 degrees of freedom
    assert means[1] > 160


def test_names_are_known():
    assert set(dir(subjects)) == set(catalogue.SUBJECTS)
    with pytest.raises(AttributeError, match="no attribute 'kalman'"):
        _ = subjects.kalman
