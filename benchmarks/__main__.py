"""Run the benchmarks, keep the figures in ``results.json`` and in docs/benchmarks.md."""

import argparse
import datetime
import json
import os
import platform
from pathlib import Path
from typing import Any

from rich.progress import Progress

from benchmarks import live, offline

RESULTS = Path(__file__).with_name('results.json')
PAGE = Path(__file__).resolve().parents[1] / 'docs' / 'benchmarks.md'
BEGIN, END = '<!-- figures: make bench -->', '<!-- end of figures -->'
TABLE = """\
| figure | measured | wanted |
| --- | --- | --- |
| simulated seconds per second, slowest of the three strokes, at 1e-4 of full scale \
| {realtime_factor:.0f} | at least 300 |
| times the best of LSODA, Radau and CVODE at the same error \
| {speedup_vs_best_peer:.1f} | at least 10 |
| growth of the cost with the length of the stroke, exponent (that of the evaluations of the \
equations) | {length[exponent]:.2f} ({length[evaluations_exponent]:.2f}) | at most 1 |
| live over DDS, four processes, 60 s: rate [Hz] | {live[rate_hz]:.3f} | 862.07 |
| missed ticks, lost samples | {live[missed]}, {live[lost]} | 0, 0 |
| p99 of the tick error [ms] | {live[tick_error_p99_ms]:.3f} | under 1.16 |
| the same with real-time priority [ms] | {urgent} | under 0.2 |
| processor time of all four [% of one core] | {live[cpu_percent]:.0f} | under 90 |
| the same composed in one process (`rig`) | {live[composed_cpu_percent]:.0f} | under 50 |
| highest rate at which nothing is lost [Hz] | {live[max_rate_hz]:.0f} | at least 2500 |

{origin}."""


def main() -> None:
    """Run what was asked for, by default everything; figures not measured again are kept."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=__doc__)
    parser.add_argument('part', nargs='?', choices=('offline', 'live'), help='only this part')
    parser.add_argument('--seconds', type=float, default=60.0, help='length of the live runs')
    arguments = parser.parse_args()
    results = json.loads(RESULTS.read_text())
    origin = {'date': datetime.date.today().isoformat(), 'machine': machine()}
    if arguments.part in (None, 'offline'):
        with Progress(transient=True) as progress:
            results.update(offline.run(progress), **origin)
    if arguments.part in (None, 'live'):
        results['live'] = {**live.run(seconds=arguments.seconds), **origin}
    RESULTS.write_text(json.dumps(results, indent=2) + '\n')
    update(results)
    print(table(results))


def machine() -> str:
    """Return processor, number of cores, system and Python in a line."""
    path = Path('/proc/cpuinfo')
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(':', 1)[1].strip() for line in lines if 'model name' in line]
    return (
        f'{names[0] if names else platform.machine()}, {os.cpu_count()} cores, '
        f'{platform.system()}, Python {platform.python_version()}'
    )


def table(results: dict[str, Any]) -> str:
    """Return the table in Markdown, with the machine and the date."""
    live = results['live']
    urgent = live.get('realtime_tick_error_p99_ms')  # not every machine permits the priority
    offline, online = (f'{part["machine"]}, {part["date"]}' for part in (results, live))
    return TABLE.format(
        **results,
        urgent='not permitted' if urgent is None else f'{urgent:.3f}',
        origin=offline if offline == online else f'{offline}; live: {online}',
    )


def update(results: dict[str, Any]) -> None:
    """Write the table between its marks in the page."""
    text = PAGE.read_text()
    head, rest = text.split(BEGIN)
    tail = rest.split(END)[1]
    PAGE.write_text(f'{head}{BEGIN}\n{table(results)}\n{END}{tail}')


if __name__ == '__main__':
    main()
