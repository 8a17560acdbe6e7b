"""
What one would do without the workflow, on the same bags: three baselines.

Each gets the model, the bags of the fit and the same predictions and noise floors as the workflow,
and is judged like it by the gap above the noise that is left on the bags held out.

``refit``: all parameters of the model fitted, nothing added.
``sparse``: sparse regression (pysindy) of the residuals of the balances, the terms added as found.
``black box``: a small network (scikit-learn) that learns the gap of the predictions from signals.
"""

import numpy as np
from sklearn.neural_network import MLPRegressor
from sklearn.preprocessing import StandardScaler

from pneu_rig_ros.gap.candidates import parameters
from pneu_rig_ros.gap.diagnosis import Diagnosis
from pneu_rig_ros.gap.evidence import COLUMNS, Evidence
from pneu_rig_ros.gap.experiment import Experiment
from pneu_rig_ros.gap.fitting import Explanation, fit
from pneu_rig_ros.gap.hypothesis import Hypothesis
from pneu_rig_ros.gap.prediction import Mode, block_means, predict
from pneu_rig_ros.gap.shrink import gap_above_floor
from pneu_rig_ros.gap.terms import MOST_TERMS, regression, sparse_terms
from pneu_rig_ros.model import effects as library

MODES = (Mode.CHAMBERS, Mode.CYCLES)
ROUNDS = 20
LAYERS = (32, 32)
DESCRIPTIONS = ('described_flow',), ('described_friction', 'described_force')
"""Terms that the regression may use, in the gas and in the forces."""
CLIPPED = 30.0
"""Gaps of the training beyond so many noise floors are cut, or slips outweigh all else [-]."""


def left(hypothesis: Hypothesis, held: Evidence) -> float:
    """Return the gap above the noise, in floors: the mean over signals and predictions."""
    return float(np.mean(np.concatenate([gap_above_floor(hypothesis, held, m) for m in MODES])))


def cuts(diagnosis: Diagnosis) -> dict[str, float]:
    """Return baseline -> share of the gap above noise that it cuts on bags held out [-]."""
    given, fitted, held = diagnosis.given, diagnosis.fitted, diagnosis.held
    for evidence in (fitted, held):
        evidence.settle_floors(diagnosis.best, MODES)
    before = left(given, held)
    if before <= 0.0:
        return {}
    after = {
        'refit': left(refit(given, fitted), held),
        'sparse': left(sparse(given, fitted), held),
        'black box': black_box(given, fitted, held),
    }
    return {name: 1.0 - value / before for name, value in after.items()}


def refit(given: Hypothesis, fitted: Evidence) -> Hypothesis:
    """Return the model with all of its parameters fitted: those of the gas, then the others."""
    every = list(parameters(given))
    for mode in MODES:
        start = Explanation()
        for candidate in every:
            if mode in candidate.modes:
                start = start.plus(candidate, (candidate.was,))
        given = fit(given, start, fitted, (mode,), ROUNDS).explanation.apply(given)
    return given


def sparse(given: Hypothesis, fitted: Evidence) -> Hypothesis:
    """Return the model with the terms that regression finds in the residuals."""
    for names in DESCRIPTIONS:
        found = {name: _regressed(given, fitted, name) for name in names}
        best = min(found, key=lambda name: found[name][0])
        null = library.load(best).null
        given = given.with_effect(best, null._replace(**found[best][1]))
    return given


def _regressed(given: Hypothesis, fitted: Evidence, name: str) -> tuple[float, dict[str, float]]:
    """Return the share of the residual that is left, and the coefficients."""
    matrix, target = regression(given, fitted, name)
    terms = sparse_terms(matrix, target, name, MOST_TERMS)
    fields = library.load(name).parameters._fields
    explained = matrix @ np.array([terms.get(field, 0.0) for field in fields])
    return float(np.mean((target - explained) ** 2) / np.mean(target**2)), terms


def black_box(given: Hypothesis, fitted: Evidence, held: Evidence) -> float:
    """Return the gap above the noise that is left when a network has learnt the gap."""
    rest = []
    for mode in MODES:
        scaler = StandardScaler()
        network = MLPRegressor(
            hidden_layer_sizes=LAYERS, early_stopping=True, max_iter=1000, random_state=1
        )
        signals = np.concatenate([features(given, one, mode) for one in fitted.experiments])
        target = np.concatenate(fitted.gaps(given, mode)).clip(-CLIPPED, CLIPPED)
        network.fit(scaler.fit_transform(signals), target)
        unseen = np.concatenate([features(given, one, mode) for one in held.experiments])
        gap = np.concatenate(held.gaps(given, mode)) - network.predict(scaler.transform(unseen))
        excess = np.zeros(3)
        excess[list(COLUMNS[mode])] = np.maximum(np.mean(gap**2, axis=0) - 1.0, 0.0)
        rest.append(np.sqrt(excess)[list(COLUMNS[mode])])
    return float(np.mean(np.concatenate(rest)))


def features(given: Hypothesis, experiment: Experiment, mode: Mode) -> np.ndarray:
    """Return what the network sees of each block: the model's prediction and the set-up."""
    prediction = predict(given, experiment, mode)
    run, voltages = prediction.run, experiment.voltages
    constant = np.ones(len(voltages))
    operation = experiment.operation
    table = np.column_stack([
        prediction.readings, run.velocity, run.dwell_time, run.deflection, voltages,
        operation.supply_pressure * constant, operation.load_mass * constant,
    ])  # fmt: skip
    return block_means(table, experiment.block)
