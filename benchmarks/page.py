"""The table of measured figures in docs/benchmarks.md, written from ``results.json``."""

from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parents[1] / 'docs' / 'benchmarks.md'
BEGIN, END = '<!-- figures: make bench -->', '<!-- end of figures -->'


def table(results: dict[str, Any]) -> str:
    """Return the table in Markdown, with the machine and the date."""
    live = results['live']
    rows = [
        (
            'simulated seconds per second, slowest of the three strokes, at 1e-4 of full scale',
            f'{results["realtime_factor"]:.0f}',
            'at least 300',
        ),
        (
            'times the best of LSODA, Radau and CVODE at the same error',
            f'{results["speedup_vs_best_peer"]:.1f}',
            'at least 10',
        ),
        (
            'growth of the cost with the length of the stroke, exponent '
            '(that of the evaluations of the equations)',
            f'{results["length"]["exponent"]:.2f} '
            f'({results["length"]["evaluations_exponent"]:.2f})',
            'at most 1',
        ),
        ('live over DDS, four processes, 60 s: rate [Hz]', f'{live["rate_hz"]:.3f}', '862.07'),
        ('missed ticks, lost samples', f'{live["missed"]}, {live["lost"]}', '0, 0'),
        ('p99 of the tick error [ms]', f'{live["tick_error_p99_ms"]:.3f}', 'under 1.16'),
        (
            'the same with real-time priority [ms]',
            number(live.get('realtime_tick_error_p99_ms')),
            'under 0.2',
        ),
        ('processor time of all four [% of one core]', f'{live["cpu_percent"]:.0f}', 'under 90'),
        (
            'the same composed in one process (`rig`)',
            f'{live["composed_cpu_percent"]:.0f}',
            'under 50',
        ),
        (
            'highest rate at which nothing is lost [Hz]',
            f'{live["max_rate_hz"]:.0f}',
            'at least 2500',
        ),
    ]
    lines = ['| figure | measured | wanted |', '| --- | --- | --- |']
    lines += [f'| {what} | {value} | {wanted} |' for what, value, wanted in rows]
    offline, online = (f'{part["machine"]}, {part["date"]}' for part in (results, live))
    origin = offline if offline == online else f'{offline}; live: {online}'
    return '\n'.join([*lines, '', f'{origin}.'])


def number(value: float | None) -> str:
    """Return a figure that may be missing: not every machine permits real-time priority."""
    return 'not permitted' if value is None else f'{value:.3f}'


def update(results: dict[str, Any]) -> None:
    """Write the table between its marks in the page."""
    text = PAGE.read_text()
    head, rest = text.split(BEGIN)
    tail = rest.split(END)[1]
    PAGE.write_text(f'{head}{BEGIN}\n{table(results)}\n{END}{tail}')
