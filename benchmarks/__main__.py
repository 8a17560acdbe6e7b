"""Run the benchmarks, keep the figures in ``results.json`` and in docs/benchmarks.md."""

import argparse
import datetime
import json
import os
import platform
from pathlib import Path

from rich.progress import Progress

from benchmarks import live, offline, page

RESULTS = Path(__file__).with_name('results.json')


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
    page.update(results)
    print(page.table(results))


def machine() -> str:
    """Return processor, number of cores, system and Python in a line."""
    path = Path('/proc/cpuinfo')
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.split(':', 1)[1].strip() for line in lines if 'model name' in line]
    return (
        f'{names[0] if names else platform.machine()}, {os.cpu_count()} cores, '
        f'{platform.system()}, Python {platform.python_version()}'
    )


if __name__ == '__main__':
    main()
