"""A trial's recordings, what is true of it, and how much it shows, whatever the system."""

from pathlib import Path
from typing import Any

from pneu_rig_ros.scenarios.hidden import true_parameters

from . import rig, systems
from .circumstances import WRONG
from .files import Files
from .forms import is_form
from .fresh import ONE_PRESSURE
from .runs import GASES, Truth, truth_of_runs
from .settings import settings
from .systems import SYSTEMS
from .trials import Trial

OF_A_RIG = (*GASES, 'force')
SECOND_PRESSURE = ('chamber_2/pressure',)


def balances(trial: Trial) -> tuple[str, ...]:
    """Return the balances that are open."""
    if trial.part in SYSTEMS:
        return SYSTEMS[trial.part].balances
    return GASES[:1] if trial.part == ONE_PRESSURE else OF_A_RIG


def make_files(folder: Path, trial: Trial) -> Files:
    """Record a trial into a folder that does not hold one yet."""
    if trial.part in SYSTEMS:
        return systems.make_files(folder, SYSTEMS[trial.part], trial.key, trial.secret)
    without = SECOND_PRESSURE if trial.part == ONE_PRESSURE else ()
    return rig.make_bags(
        folder,
        trial.cylinder,
        trial.secret,
        trial.noise,
        trial.seed,
        trial.gains,
        without,
        trial.circumstances,
    )


def truth(trial: Trial) -> Truth:
    """Return when the contribution of what is hidden exceeds the noise, in the bags of the fit."""
    if trial.part in SYSTEMS:
        runs = systems.fitted(SYSTEMS[trial.part], trial.key, trial.secret)
    else:
        runs = rig.runs(trial.cylinder, trial.secret, trial.noise, trial.circumstances)
    return truth_of_runs(runs, balances(trial))


def visibility(trial: Trial) -> float:
    """
    Return the largest change of a signal by what is hidden, in multiples of its noise.

    Of a strong cause among nuisances, by that cause alone.
    """
    if trial.part in SYSTEMS:
        return systems.visibility(SYSTEMS[trial.part], trial.key, trial.secret)
    if trial.part == 'nuisance':
        alone = {name: trial.secret.effects[name] for name in trial.names}
        return rig.visibility(trial.cylinder, trial.secret._replace(effects=alone), trial.noise)
    return rig.visibility(trial.cylinder, trial.secret, trial.noise, trial.circumstances)


def least_visibility(trial: Trial) -> float:
    """Return the change of a signal by the weakest of several effects, beside the others."""
    secret, rest = trial.secret, trial.secret.effects
    others = [{k: v for k, v in rest.items() if k != name} for name in trial.names]
    return min(rig.visibility(trial.cylinder, secret, trial.noise, known=own) for own in others)


def hidden_values(trial: Trial) -> dict[str, float]:
    """
    Return effect.parameter or section.name -> true value [SI] of what was hidden.

    A foreign form and a wrong condition have no parameter of the library.
    """
    friction = _model_of(trial)['friction']
    values: dict[str, float] = {}
    for name in trial.names:
        if is_form(name) or name in WRONG:
            continue
        if '.' in name:
            value = trial.secret.truth[name]
            values[name] = sum(value) if isinstance(value, list) else value
        else:
            own = true_parameters(name, trial.secret, friction)
            values |= {f'{name}.{parameter}': value for parameter, value in own.items()}
    return values


def _model_of(trial: Trial) -> dict[str, dict[str, Any]]:
    if trial.part in SYSTEMS:
        return systems.sizes(SYSTEMS[trial.part], trial.key)
    return settings(trial.cylinder)
