"""What is so or not: the same bits on any number of workers, and after one was killed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pneu_rig_ros.executor import Executor, SerialExecutor, map_tasks, open_executor
from reliability.scale.tasks import recorded_strokes, strokes

Progress = Callable[[int], None]


def independence(tasks: int, workers: Sequence[int], progress: Progress) -> dict[str, Any]:
    """Carry out the same tasks in this process and on several numbers of others."""
    alone = [done.digest for done in map_tasks(SerialExecutor(), strokes, range(tasks))]
    progress(tasks)
    same = {}
    for index, count in enumerate(workers, start=1):
        with open_executor(count) as processes:
            results = map_tasks(processes, strokes, range(tasks))
        same[str(count)] = [done.digest for done in results] == alone
        progress((index + 1) * tasks)
    return {'tasks': tasks, 'workers': list(workers), 'same_bits': same}


def killed_worker(tasks: int, processes: Executor, progress: Progress) -> dict[str, Any]:
    """Have the worker of a task in the middle killed; count how often tasks are begun."""
    alone = [done.digest for done in map_tasks(SerialExecutor(), strokes, range(tasks))]
    fatal = tasks // 2
    with tempfile.TemporaryDirectory(prefix='pneu-rig-') as folder:
        journal = Path(folder) / 'journal'
        results = map_tasks(
            processes, recorded_strokes, range(tasks), journal, fatal, progress=progress
        )
        begun = [int(line) for line in journal.read_text().splitlines()]
    return {
        'tasks': tasks,
        'killed_while_doing': [fatal],
        'begun': len(begun),
        'done_again': sorted({number for number in begun if begun.count(number) > 1}),
        'same_bits': [done.digest for done in results] == alone,
    }
