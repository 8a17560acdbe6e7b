"""Run the benchmarks, print their tables, and keep the figures in ``results.json``."""

import argparse
import datetime
import json
import os
import platform
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from benchmarks import live, offline, readme

RESULTS = Path(__file__).with_name('results.json')


def main() -> None:
    """Run what was asked for, by default everything; figures not measured again are kept."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks', description=__doc__)
    parser.add_argument('part', nargs='?', choices=('offline', 'live'), help='only this part')
    parser.add_argument('--seconds', type=float, default=60.0, help='length of the live runs')
    arguments = parser.parse_args()
    console = Console()
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    results.update(date=datetime.date.today().isoformat(), machine=machine())
    if arguments.part in (None, 'offline'):
        with Progress(console=console, transient=True) as progress:
            results.update(offline.run(progress))
    if arguments.part in (None, 'live'):
        results['live'] = live.run(seconds=arguments.seconds)
    report(results, console)
    RESULTS.write_text(json.dumps(results, indent=2) + '\n')
    if 'live' in results and 'strokes' in results:
        readme.update(results)
    console.print(f'figures are in {RESULTS} and in the README')


def machine() -> str:
    """Return processor, number of cores, system and Python in a line."""
    names = [line.split(':', 1)[1].strip() for line in cpu_lines() if 'model name' in line]
    name = names[0] if names else platform.machine()
    return (
        f'{name}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}'
    )


def cpu_lines() -> list[str]:
    """Return the lines of /proc/cpuinfo, none where there is no such file."""
    path = Path('/proc/cpuinfo')
    return path.read_text().splitlines() if path.exists() else []


def report(results: dict[str, Any], console: Console) -> None:
    """Print all tables."""
    console.print(f'[bold]{results["machine"]}, {results["date"]}')
    if 'strokes' in results:
        report_strokes(results, console)
        report_growth(results, console)
    if 'live' in results:
        table = Table('live figure', 'value', title='Live over DDS')
        for key, value in results['live'].items():
            table.add_row(key, in_words(value))
        console.print(table)


def in_words(value: object) -> str:
    """Return a figure as text."""
    if isinstance(value, dict):
        return ', '.join(f'{name} {in_words(figure)}' for name, figure in value.items())
    return f'{value:.4g}' if isinstance(value, float) else str(value)


def report_strokes(results: dict[str, Any], console: Console) -> None:
    """Print the comparison at equal error."""
    title = (
        f'25 s stick-slip stroke, largest error at most {results["error_wanted"]:g} of full scale'
    )
    table = Table(
        'cylinder', 'solver', 'tolerance', 'error', 'x real time', 'own / it', title=title
    )
    for name, rows in results['strokes'].items():
        for row in rows:
            ratio = rows[0]['factor'] / row['factor']
            table.add_row(
                name, row['solver'], f'{row["tolerance"]:.0e}', f'{row["error"]:.1e}',
                f'{row["factor"]:.0f}', f'{ratio:.1f}', end_section=row is rows[-1],
            )  # fmt: skip
    console.print(table)
    console.print(
        f'slowest stroke {results["realtime_factor"]:.0f} times real time, '
        f'at least {results["speedup_vs_best_peer"]:.1f} times the best peer'
    )


def report_growth(results: dict[str, Any], console: Console) -> None:
    """Print how cost grows with substep and length, and the memory."""
    substep = Table('longest substep (us)', 'ms per simulated s', title='Cost against substep')
    for row in results['substep']:
        substep.add_row(f'{row["substep_us"]:.0f}', f'{row["ms_per_s"]:.2f}')
    length = Table('stroke (s)', 'ms', title='Cost against stroke length')
    for row in results['length']['rows']:
        length.add_row(f'{row["duration_s"]:.0f}', f'{row["ms"]:.1f}')
    console.print(substep, length)
    memory = results['memory']
    console.print(
        f'cost grows with length to the power {results["length"]["exponent"]:.2f}; '
        f'{memory["bytes_per_sample"]} bytes a sample, {memory["growth_mb"]:.1f} MB more '
        f'after 50 strokes'
    )


if __name__ == '__main__':
    main()
