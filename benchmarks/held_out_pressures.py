"""
Repeat the table of docs/hardware.md on seals with one pressure held out after the other.

`python -m benchmarks.held_out_pressures` fits each seal at three pressures, validates it at the
fourth, and writes the table into the page.
"""

import itertools
import math
from typing import NamedTuple

from benchmarks.hardware import ROOT, put
from pneu_rig_ros.diagnosis.answer.improvement import signal_tables
from pneu_rig_ros.diagnosis.result import answer
from pneu_rig_ros.diagnosis.workflow import diagnose
from pneu_rig_ros.executor import Executor, open_executor

DATA = ROOT.parent / 'shared' / 'data' / 'seal_friction'
SYSTEMS = ROOT / 'config' / 'systems'
SEALS = ('NAPN', 'KDN', 'O-ring257')
REPEATABILITY = {1: 0.27, 3: 0.52, 5: 0.82, 7: 0.92}
"""Pressure [bar] -> standard deviation of half a loop of O-ring257 over three runs [N]."""
HEAD = (
    '| seal | held out | given [N] | improved [N] | repeatability [N] | closed | named |',
    '| --- | --- | --- | --- | --- | --- | --- |',
)


class Row(NamedTuple):
    """
    One diagnosis.

    :param pressure: held out [bar]
    :param before, after: RMSE of the force at that pressure [N]
    """

    seal: str
    pressure: int
    before: float
    after: float
    named: str

    @property
    def text(self) -> str:
        """The line of the table."""
        floor = REPEATABILITY[self.pressure]
        names = ', '.join(f'`{name}`' for name in self.named.split())
        return (
            f'| {self.seal} | {self.pressure} bar | {self.before:.2f} | {self.after:.2f} | '
            f'{floor:.2f} | {closed([self])} | {names} |'
        )


def closed(rows: list[Row]) -> str:
    """Return the share of what is above the repeatability that is closed (root of squares)."""
    before = sum(_above(row.before, row.pressure) for row in rows)
    after = sum(_above(row.after, row.pressure) for row in rows)
    if before == 0.0:
        return '-'  # nothing was above it
    share = 1.0 - math.sqrt(after / before)
    return f'{100.0 * share:.0f} %' if share > 0.0 else 'none'


def _above(rmse: float, pressure: int) -> float:
    return max(rmse**2 - REPEATABILITY[pressure] ** 2, 0.0)


def diagnosed(seal: str, pressure: int, executor: Executor) -> Row:
    """Return the diagnosis of a seal at all pressures but one [bar]."""
    files = {each: DATA / f'{seal}_{each}bar.csv' for each in REPEATABILITY}
    diagnosis = diagnose(
        [file for each, file in files.items() if each != pressure],
        SYSTEMS / f'seal_{seal}.yaml',
        [files[pressure]],
        mapping=SYSTEMS / 'seal_friction.map.yaml',
        executor=executor,
    )
    data = answer(diagnosis)
    names = [each['name'] for each in data['effects']] or [data['verdict']]
    force = signal_tables(diagnosis.given, diagnosis.improved, diagnosis.held_out)['signals']
    return Row(seal, pressure, force['force']['before'], force['force']['after'], ' '.join(names))


def main() -> None:
    """Diagnose, and write the table into the page."""
    rows = []
    with open_executor(None) as executor:
        for seal, pressure in itertools.product(SEALS, REPEATABILITY):
            rows.append(diagnosed(seal, pressure, executor))
            print(rows[-1].text, flush=True)
    lines = [*HEAD, *(row.text for row in rows)]
    for seal in SEALS:
        own = [row for row in rows if row.seal == seal]
        lines.append(f'| {seal} | all | | | | {closed(own)} | |')
    put('held_out_pressures', '\n'.join(lines))


if __name__ == '__main__':
    main()
