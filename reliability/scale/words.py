"""The figures in words, for docs/reliability.md."""

from __future__ import annotations

from typing import Any


def words(found: dict[str, Any]) -> str:
    """Return the section on scale as Markdown."""
    head = '`python -m reliability scale` (`make scale`) measured, in one run:'
    lines = [head, '', *_table(found), '', *_projection(found), '', found['machine'] + '.']
    return '\n'.join(lines)


def _table(found: dict[str, Any]) -> list[str]:
    same, killed = found['independence'], found['killed_worker']
    counts = ', '.join(str(count) for count in same['workers'])
    again = ', '.join(str(number) for number in killed['done_again'])
    rows = [
        (f'{same["tasks"]} tasks in this process and on {counts} others: same in every bit',
         _yes(all(same['same_bits'].values())), 'yes'),
        (f'a worker of two killed halfway through {killed["tasks"]} tasks: results the same',
         _yes(killed['same_bits']), 'yes'),
        ('tasks that were begun once more', f'{again or "none"} (it was doing '
         f'{killed["killed_while_doing"][0]})', 'with what it had not handed over, 2 at most'),
        ('batch on 2 threads, times 1 thread (median, least to most)',
         _ratio(found['batch']), 'at least 1.8'),
        ('2 processes, times 1 (median, least to most)', _ratio(found['processes']), 'near 2'),
        ('2 processors, times 1, counting only: what the machine gave meanwhile',
         f'{found["machine_ratio"]:.2f}', ''),
    ]  # fmt: skip
    return ['| | measured | wanted |', '| --- | --- | --- |',
            *(f'| {" | ".join(row)} |' for row in rows)]  # fmt: skip


def _projection(found: dict[str, Any]) -> list[str]:
    many, cost, own = found['projection'], found['projection']['cost'], found['trials']
    return [
        'What a blind trial costs:',
        '',
        '| | [s] |',
        '| --- | --- |',
        f'| t: a trial on one core, mean of {own["count"]} (longest) | '
        f'{cost["task"]:.1f} ({cost["longest"]:.1f}) |',
        f'| l: a worker from one task to the next | {cost["latency"]:.4f} |',
        f'| o: processor time of scheduler and client, each task | {cost["overhead"]:.4f} |',
        f'| d: task and answer on their way | {cost["transfer"]:.6f} |',
        f'| start of a worker, to its first result | {cost["start"]:.1f} |',
        f'| compilation of the plants, once for each machine | {cost["compilation"]:.0f} |',
        '',
        'N trials on P cores take T = start + compilation + max(N (t + l) / P, N (o + d)) + '
        '(longest - t): workers and scheduler work at the same time, in the end all wait for the '
        f'last trial. For these {own["count"]} trials on 2 workers that have started it gives '
        f'{many["these_trials_s"]:.0f} s; {own["wall_s"]:.0f} s were measured.',
        '',
        f'**{many["trials"]:,} trials on {many["cores"]:,} cores of this kind: '
        f"{many['hours']:.1f} hours**, {many['efficiency']:.1%} of the cores' time in trials. "
        f'From {many["most_cores"]:,.0f} cores on the one scheduler decides. It is a projection: '
        'no more than the workers of one machine were run.',
    ]


def _ratio(pairs: dict[str, Any]) -> str:
    return f'{pairs["ratio"]:.2f} ({pairs["least"]:.2f} to {pairs["most"]:.2f})'


def _yes(value: bool) -> str:
    return 'yes' if value else '**no**'
