"""How quantities differ between recordings: variances by marginal likelihood, shrunk values."""

import numpy as np
import pytest
from scipy.stats import norm

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.diagnosis.answer.random_effects import Information, Marginal, random_effects

NOISE = 0.02
"""Standard deviation of a value that one recording shows [-]."""
RECORDINGS = 8
SPREAD = 0.1
"""Standard deviation between recordings [-]: of half of it one draw in twenty shows nothing."""
DIFFERENT = norm.ppf((np.arange(RECORDINGS) + 0.5) / RECORDINGS)
DIFFERENT *= SPREAD / DIFFERENT.std(ddof=1)


def observed(values: Floats, rng: np.random.Generator, alike: float = 0.0) -> Information:
    """Return the information in recordings with these values, shape (recordings, k)."""
    size, residuals, changes = 400, [], []
    for row in values:
        change = rng.standard_normal((size, row.size)) / (NOISE * np.sqrt(size))
        change[:, -1] = alike * change[:, 0] + np.sqrt(1.0 - alike**2) * change[:, -1]
        residuals.append(rng.standard_normal(size) - change @ row)
        changes.append(change)
    return Information.of(residuals, changes)


def test_likelihood_is_that_of_normal_values_with_a_common_mean() -> None:
    """Against the density of the values that single recordings show, up to a constant."""
    data = observed(np.array([[0.03], [-0.05], [0.08]]), np.random.default_rng(1))
    own = data.curvatures[:, 0, 0]
    shown = data.gradients[:, 0] / own

    def density(variance: float) -> float:
        covariance = np.diag(1.0 / own + variance) + 0.1**2  # the common mean before the data
        return float(
            -0.5 * shown @ np.linalg.solve(covariance, shown)
            - 0.5 * np.linalg.slogdet(covariance)[1]
        )

    for variance in (0.0, 1e-3, 0.1):
        gain = Marginal.of(data, np.array([variance])).log_likelihood
        gain -= Marginal.of(data, np.array([1e-2])).log_likelihood
        assert gain == pytest.approx(density(variance) - density(1e-2), rel=1e-6)


def test_quantities_that_do_not_differ_have_no_spread() -> None:
    rng, alike = np.random.default_rng(2), np.full((RECORDINGS, 3), 0.02)
    found = [random_effects(observed(alike, rng)).spreads.any() for _ in range(60)]
    assert np.sum(found) <= 6  # three tests at 1 % each: two draws in a thousand have more


def test_spread_of_one_quantity_is_found_and_its_values_shrink_towards_the_mean() -> None:
    rng = np.random.default_rng(3)
    values = np.zeros((RECORDINGS, 2))
    values[:, 0] = DIFFERENT
    found = random_effects(observed(values, rng))
    assert found.spreads[0] == pytest.approx(SPREAD, rel=0.4)
    assert found.spreads[1] == 0.0
    off = (found.values[:, 0] - values[:, 0]) / found.deviations[:, 0]
    assert np.abs(off).max() < 4.0
    assert np.ptp(found.values[:, 0]) < np.ptp(values[:, 0]) + 4.0 * NOISE


def test_recording_like_the_model_is_rarely_significant_beside_others_that_are_not() -> None:
    rng, p_values = np.random.default_rng(6), []
    for _ in range(60):
        values = 0.1 + 0.05 * rng.standard_normal((RECORDINGS, 1))
        values[0] = 0.0
        found = random_effects(observed(values, rng))
        if found.spreads.any():
            p_values.append(found.p_values[0, 0])
    assert len(p_values) > 40
    assert np.mean(np.array(p_values) < 0.05) < 0.15  # of 5 %: one draw in a hundred has more


def test_one_of_two_quantities_that_act_alike_is_kept() -> None:
    rng = np.random.default_rng(4)
    values = np.zeros((RECORDINGS, 2))
    values[:, 0] = DIFFERENT
    found = random_effects(observed(values, rng, alike=0.9))
    assert found.spreads[0] > 0.05
    assert found.spreads[1] == 0.0


def test_quantity_that_a_recording_hardly_shows_is_not_determined() -> None:
    data = observed(np.zeros((RECORDINGS, 2)), np.random.default_rng(5))
    weak = Information(data.gradients * [1.0, 0.1], data.curvatures * [[1.0, 0.1], [0.1, 0.01]])
    assert weak.determined.tolist() == [True, False]
    assert weak.only(weak.determined).gradients.shape == (RECORDINGS, 1)
