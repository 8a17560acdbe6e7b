"""
Make the files of one trial: ``python -m blind.make_trial fresh/3/valve_block --out DIR``.

Run in the folder ``test``. The trial is the first one whose key begins so, of those drawn from the
seed in the key, or of the matrix; DIR.truth.yaml tells what was hidden, and when it shows.
"""

from pathlib import Path

import click
import yaml

from . import cases
from .foreign_trials import FOREIGN_PARTS, drawn_foreign
from .fresh import FRESH, drawn
from .trials import Trial, matrix


def find(beginning: str) -> Trial:
    """Return the first trial whose key begins so."""
    words = beginning.split('/')
    if words[0] != FRESH or len(words) < 2:
        trials = matrix()
    elif len(words) > 2 and words[2] in FOREIGN_PARTS:
        trials = drawn_foreign(int(words[1]), (words[2],))
    else:
        trials = drawn(int(words[1]))
    chosen = next((trial for trial in trials if trial.key.startswith(beginning)), None)
    if chosen is None:
        raise click.BadParameter(f'{beginning}: begins no key, such as {trials[0].key}')
    return chosen


@click.command()
@click.argument('key')
@click.option('--out', type=click.Path(path_type=Path), required=True)
def main(key: str, out: Path) -> None:
    """Make the files of a trial and print the command that diagnoses them."""
    trial = find(key)
    files = cases.make_files(out, trial)
    intervals = {
        balance: {name: [list(span) for span in spans] for name, spans in recordings.items()}
        for balance, recordings in cases.truth(trial).items()
    }
    told = {
        'key': trial.key,
        'names': list(trial.names),
        'values': cases.hidden_values(trial),
        'visibility': cases.visibility(trial),
        'intervals': intervals,
    }
    out.with_name(f'{out.name}.truth.yaml').write_text(yaml.safe_dump(told, sort_keys=False))
    bags = f'{" ".join(map(str, files.fit))} --verify {" ".join(map(str, files.verify))}'
    mapping = f' --map {files.mapping}' if files.mapping else ''
    click.echo(f'pneu-rig diagnose {bags} --model {files.model}{mapping} --out {out}/answer')


if __name__ == '__main__':
    main()
