"""Waves over the position: the wavelength is found, and the description repeats the force."""

from pathlib import Path

import numpy as np
import pytest

from pneu_rig_ros.diagnosis.residuals.whitening import whitener
from pneu_rig_ros.diagnosis.residuals.windows import SLIDING, Windows
from pneu_rig_ros.diagnosis.search.empirical import SHORTEST, dominant_wavelengths

from .parts import BENCH, bench_run
from .runs import diagnosed


def windows(span: float, length: float, seed: int) -> Windows:
    """Return windows of the force at random places, with a wave of 1 N in noise of 1 N."""
    rng = np.random.default_rng(seed)
    position, zeros = 0.05 + rng.uniform(0.0, span, 400), np.zeros(400)
    wave = np.sin(2.0 * np.pi * position / length + rng.uniform(0.0, 6.0)) + 0.5
    names = np.full(400, SLIDING)
    ones = np.ones(400)
    return Windows(
        'force',
        'run',
        zeros,
        ones,
        names,
        names,
        {'position': position},
        wave + rng.normal(0.0, 1.0, 400),
        wave,
        whitener(np.ones(400, dtype=np.bool_), [], ones),
        ones,
    )


@pytest.mark.parametrize('length', [0.006, 0.013, 0.05])
@pytest.mark.parametrize('seed', range(3))
def test_wavelength_is_found_in_noise(length: float, seed: int) -> None:
    (found,) = dominant_wavelengths([windows(0.2, length, seed)])
    # one part in four of a wave less or more over the whole way
    assert found == pytest.approx(length, rel=0.5 * length / 0.2)


def test_no_wave_is_sought_where_two_do_not_fit() -> None:
    assert dominant_wavelengths([windows(1.5 * SHORTEST, 0.01, 0)]) == []
    assert dominant_wavelengths([]) == []


@pytest.mark.long
@pytest.mark.timeout(600)
def test_force_that_repeats_along_the_stroke_is_described_as_a_wave(tmp_path: Path) -> None:
    runs = []
    for i, gauge in enumerate((1e5, 1e5, 1e5)):
        signals = bench_run(i, gauge, 0.0)
        signals['force'] += 0.8 * np.sin(2.0 * np.pi * signals['position'] / 0.012)
        runs.append(signals)
    found = diagnosed(tmp_path, BENCH, runs, 0.01, fitted=2)
    assert found.verdict == 'unknown'
    assert found.unknown is not None
    wave, values = found.unknown.explanation.parts[0], found.unknown.explanation.values[0]
    assert wave.name == 'empirical_force_wave'
    own = dict(zip([c.name for c in wave.coordinates], values, strict=True))
    assert own['wavelength'] == pytest.approx(0.012, rel=0.01)
    # the bench pushes against it
    assert own['sine'] == pytest.approx(-0.8, rel=0.05)
    assert abs(own['cosine']) < 0.05
    assert found.unknown.gap_left < 0.1
