import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from rcc_sim.diagnose.causes.profile import Profile, overlap
from rcc_sim.diagnose.causes.strengths import (
    RELIEF,
    SIZES,
    Prior,
    freed,
    likeliest,
    prior_of,
    smooth,
    windows,
)
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.noise.strips import Strips
from rcc_sim.diagnose.noise.whitener import fit_whitener, lag_edges, weights


@given(knots=st.integers(2, 40), seed=st.integers(0, 99))
def test_windows_sum_to_one_everywhere(knots, seed):
    x = np.random.default_rng(seed).uniform(-3, 7, 200)
    H = windows(x, np.linspace(-2, 6, knots))
    assert H.sum(axis=1) == pytest.approx(1)
    assert H.toarray().min() >= 0


def linear_case(truth, noise, rng, rows=3000):
    x = np.linspace(0, 1, rows)
    A = windows(x, np.linspace(0, 1, len(truth)))
    r = -(A @ truth) + noise * rng.normal(size=rows)
    J = np.ones((rows, 1))
    return freed(Strips.of(A.toarray()), r, J, np.array([1e-6]), np.zeros(1))[:2]


def test_a_profile_is_found_with_its_band_and_nothing_where_there_is_none():
    rng = np.random.default_rng(4)
    truth = np.sin(np.linspace(0, 6, 20))
    evidence, value, sd, _ = likeliest(*linear_case(truth, 1.0, rng), Prior(smooth(20)))
    assert evidence > 100
    assert np.mean(np.abs(value - truth) < 2.6 * sd) > 0.9
    none, flat, *_ = likeliest(*linear_case(0 * truth, 1.0, rng), Prior(smooth(20)))
    assert none < 5
    assert np.abs(flat).max() < 0.5


def test_a_hill_hangs_together_and_a_rough_road_does_not():
    rng = np.random.default_rng(6)
    hill = np.sin(np.linspace(0, 9, 60))
    for truth, sign in ((hill, 1), (rng.permutation(hill), -1)):
        M, b = linear_case(truth, 1.0, rng)
        apart, _, _, _ = likeliest(M, b, Prior(np.eye(60)))
        hangs = likeliest(M, b, Prior(smooth(60)))[0] - apart
        assert sign * hangs > 3


@pytest.mark.parametrize("held", [None, np.array([0.5, 1.0, 1.0, 1.0, 0.5]) * 4])
def test_the_evidence_is_the_marginal_likelihood_of_both_priors(held):
    """Against the density of r itself: N(0, A P^-1 A' + I) to N(0, I)."""
    rng = np.random.default_rng(7)
    A = rng.normal(size=(30, 5))
    r = rng.normal(size=30) * 3
    for shape in (smooth(5), np.eye(5)):
        evidence, *_ = likeliest(A.T @ A, -A.T @ r, Prior(shape, held))
        unit = 1 / np.sqrt(np.trace(A.T @ A) / 5)
        sums = np.zeros((5, 5)) if held is None else np.outer(held, held)
        each = [
            multivariate_normal(cov=np.eye(30) + A @ C @ A.T).logpdf(r)
            for C in (np.linalg.inv(shape / (s * unit) ** 2 + sums) for s in SIZES)
        ]
        none = multivariate_normal(cov=np.eye(30)).logpdf(r)
        assert evidence == pytest.approx(max(each) - none, abs=1e-6)


@pytest.mark.parametrize("length", [500.0, 20e3, 100e3])
def test_a_slope_goes_up_no_further_than_the_country_does(length):
    """Hills on 1 % of slope, all knots off together by 0.8 %: two tell the mean."""
    knots = np.linspace(0.0, length, 20)
    prior = prior_of("effects.road_grade.slope", "distance_m", knots)
    told = np.linalg.inv(np.eye(20) * 0.002**2 + np.full((20, 20), 0.008**2))
    hills = 0.01 + 0.03 * np.sin(np.linspace(0.0, 6 * np.pi, 20))
    _, value, _, mean_sd = likeliest(told, told @ hills, prior)
    _, free, _, free_sd = likeliest(told, told @ hills, Prior(smooth(20)))
    kept = 1 / (1 + (free_sd * length / RELIEF) ** 2)
    assert value.mean() / free.mean() == pytest.approx(kept, abs=0.03)
    assert mean_sd == pytest.approx(free_sd * np.sqrt(kept), rel=0.1)
    assert np.std(value) == pytest.approx(np.std(free), rel=0.05)
    assert prior_of("effects.road_grade.slope", "time_s", knots).held is None


def test_what_a_free_knob_can_do_is_no_profile():
    rng = np.random.default_rng(5)
    x = np.linspace(0, 1, 3000)
    A = windows(x, np.linspace(0, 1, 10))
    r = 3.0 + rng.normal(size=3000)
    free = np.array([np.inf])
    M, b, _ = freed(Strips.of(A.toarray()), r, np.ones((3000, 1)), free, np.zeros(1))
    assert likeliest(M, b, Prior(smooth(10)))[0] < 5


def test_the_mean_of_a_profile_is_told_with_what_all_knots_have_in_common():
    """Against draws; knots taken as independent say too little."""
    rng = np.random.default_rng(9)
    x = np.linspace(0, 1, 2000)
    A = windows(x, np.linspace(0, 1, 12))
    J = 1.0 + 0.2 * rng.normal(size=(2000, 1))  # a knob that lifts all knots alike
    strips = Strips.of(A.toarray())
    means = []
    for _ in range(300):
        r = -(A @ np.ones(12)) - J[:, 0] * 0.3 * rng.normal() + rng.normal(size=2000)
        M, b, _ = freed(strips, r, J, np.array([0.3]), np.zeros(1))
        _, value, sd, mean_sd = likeliest(M, b, Prior(smooth(12)))
        means.append(value.mean())
    assert mean_sd == pytest.approx(np.std(means), rel=0.25)
    assert np.sqrt(np.mean(sd**2) / len(sd)) < 0.7 * mean_sd


@given(
    at=st.lists(st.floats(0, 100), min_size=2, max_size=30, unique=True),
    seed=st.integers(0, 99),
)
def test_mean_and_rms_of_a_profile_are_over_the_drive(at, seed):
    knots = np.sort(np.round(at, 3))
    assume(np.diff(knots).min() > 0)
    value = np.random.default_rng(seed).normal(size=len(knots))
    profile = Profile("key", "time_s", knots, value, 0 * value, 0.0)
    x = (np.arange(200_000) + 0.5) / 200_000 * (knots[-1] - knots[0]) + knots[0]
    assert profile.mean == pytest.approx(profile.at(x).mean(), abs=1e-4)
    assert profile.raised(2.0).mean == pytest.approx(profile.mean + 2.0)
    flat = profile.raised(0.0).plus(profile.raised(0.0))
    assert flat.mean == pytest.approx(2 * profile.mean)
    level = Profile("key", "time_s", knots, np.full(len(knots), -3.0), value, 0.0)
    assert level.rms == pytest.approx(3.0)


def test_overlap_is_one_for_the_same_tracks_and_none_apart():
    a, b = np.array([0.25, 0.75, 0.0]), np.array([0.0, 0.0, 1.0])
    assert overlap(a, a) == pytest.approx(1)
    assert overlap(a, b) == 0
    more, less = np.array([0.5, 0.3, 0.2, 0.0]), np.array([0.2, 0.3, 0.5, 0.0])
    assert 0.9 < overlap(more, less) < 1.0


@pytest.mark.parametrize("left", [1e-2, 1e-4, 1e-6, 1e-8])
def test_strengths_that_knobs_take_up_all_but_whole_are_still_weighed(left):
    """As by least squares of all together, the priors of the knobs as rows."""
    rng = np.random.default_rng(0)
    J, sd = rng.standard_normal((400, 5)), np.full(5, 1e4)
    A = J @ rng.standard_normal((5, 20)) + left * rng.standard_normal((400, 20))
    M, b, _ = freed(Strips.of(A), rng.standard_normal(400), J, sd, np.zeros(5))
    stacked = np.vstack([J, np.diag(1 / sd)])
    Q = np.linalg.qr(stacked)[0]
    rest = np.vstack([A, np.zeros((5, 20))])
    for _ in range(2):
        rest -= Q @ (Q.T @ rest)
    assert np.trace(M) == pytest.approx(np.sum(rest**2), rel=1e-4)
    assert np.isfinite(likeliest(M, b, Prior(smooth(20)))[0])


@pytest.mark.parametrize("hidden", [1e-2, 1.0])
def test_what_others_say_of_the_knobs_counts_as_further_rows_do(hidden):
    rng = np.random.default_rng(2)
    J, sd = rng.standard_normal((300, 4)), np.array([0.5, 2.0, np.inf, np.inf])
    A = J @ rng.standard_normal((4, 6)) + hidden * rng.standard_normal((300, 6))
    r, off = rng.standard_normal(300), np.array([0.1, -1.0, 0.0, 0.0])
    R, s = rng.standard_normal((5, 4)) / 10, rng.standard_normal(5)
    apart = freed(Strips.of(A), r, J, sd, off, (R, s))
    stacked = Strips.of(np.vstack([A, np.zeros((5, 6))]))
    whole = freed(stacked, np.append(r, s), np.vstack([J, R]), sd, off)
    for one, other in zip(apart[:2], whole[:2], strict=True):
        assert one == pytest.approx(other, rel=1e-9)
    assert apart[2](np.ones(6)) == pytest.approx(whole[2](np.ones(6)), rel=1e-9)


def test_a_track_tells_of_the_knobs_what_its_weighed_rows_do():
    rng = np.random.default_rng(1)
    e, signal = rng.standard_normal((2, 500))
    noise = fit_whitener(e, rng.random(500) > 0.1, [], lag_edges(100, 1.0, 500))
    knobs = Knob("a", 0.0, 1.0), Knob("b", 0.0, 1.0)
    signals = [[signal], [e + np.roll(signal, 1)]]
    fit = Fit({"a": 0.0, "b": 0.0}, knobs, 0.0, 0.0, [noise], [e], signals=signals)
    R, s = fit.told_by(0)

    def squares(x):
        return weights(noise(e)) @ noise(e + sum(map(np.multiply, x, signals))[0]) ** 2

    for x in rng.standard_normal((3, 2)):
        told = np.sum((R @ x + s) ** 2) - np.sum(s**2)
        assert told == pytest.approx(squares(x) - squares([0.0, 0.0]), rel=1e-9)


@pytest.mark.parametrize("along", ["time", "a coordinate that comes back"])
def test_windows_are_whitened_as_whole_signals_are(along):
    rng = np.random.default_rng(3)
    n, t = 3000, np.arange(3000) / 100
    valid = rng.random(n) > 0.1
    e = np.convolve(rng.standard_normal(n), np.ones(30), "same")
    noise = fit_whitener(e, valid, [1 + t], lag_edges(100, 3.0, n))
    assert noise.memory.any()
    x = t if along == "time" else np.sin(t)
    H, signal = windows(x, np.linspace(x.min(), x.max(), 25)), 1 + np.cos(t)
    whole = noise(signal[:, None] * H.toarray())
    assert noise.through(signal, H).toarray() == pytest.approx(whole, abs=1e-9)
