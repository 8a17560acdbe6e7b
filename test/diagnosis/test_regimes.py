"""Effects show in the regimes that they declare."""

from pathlib import Path

import numpy as np

from pneu_rig_ros.diagnosis.causes.candidate_pool import pool
from pneu_rig_ros.diagnosis.residuals.windows import windows_of
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import Regime

from .runs import configured, data_of, measured, system_of

INSTROKE_TO_THE_END = ((-0.34, 3.0), (0.0, 1.0), (-0.5, 4.0), (0.0, 1.0), (0.45, 2.0))


def test_effects_show_where_they_declare_and_nowhere_else(tmp_path: Path) -> None:
    """By more than the noise, at the strongest of their starts, in a run with all regimes."""
    labels = {regime.label for regime in Regime}
    system = system_of(tmp_path, configured('cylinder_1'))
    run = measured(
        system, 'run', configured('cylinder_1', initial_position=0.01), INSTROKE_TO_THE_END
    )
    data = data_of(system.hypothesis, run)
    given = windows_of(data, system.hypothesis)
    seen = {str(regime) for windows in given for regime in windows.regime}
    assert seen == labels - {Regime.PRESLIDING.label}
    effects = [each for each in pool(system, [run])[0] if each.is_effect]
    shown, elsewhere = [], {}
    for effect in effects:
        with_effect = windows_of(data, effect.apply(system.hypothesis, effect.starts[-1]))
        changes: dict[str, list[float]] = {}
        for before, after in zip(given, with_effect, strict=True):
            change = (after.residual - before.residual) / before.deviation
            for regime, value in zip(before.regime, change, strict=True):
                changes.setdefault(str(regime), []).append(float(value))
        where = {name for name, each in changes.items() if np.mean(np.square(each)) > 1.0}
        declared = {regime.label for regime in library.load(effect.name).regimes}
        if where:
            shown.append(effect.name)
        if where - declared:
            elsewhere[effect.name] = where - declared
    assert elsewhere == {}
    assert len(shown) > 20
