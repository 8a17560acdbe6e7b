"""`pneu-rig compare`: a measured bag against a model or another bag."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pneu_rig_ros.cli import options, output
from pneu_rig_ros.errors import RigError

if TYPE_CHECKING:
    from pneu_rig_ros.analysis.comparison import Comparison


@click.command(
    epilog=options.examples(
        'pneu-rig compare runs/measured --model cylinder_2',
        'pneu-rig compare runs/measured --model improved.yaml --out comparison.html',
        'pneu-rig compare runs/monday --model runs/tuesday --json | jq .signals.position',
    ),
)
@click.argument('measured', type=options.PATH)
@click.option(
    '--model',
    required=True,
    metavar='NAME|FILE|BAG',
    help='a cylinder, a YAML file of your own, or another bag',
)
@options.seconds_option(
    '--shift', help='delay of the second bag [s]  [default: aligned by the onset of the command]'
)
@options.out_file(help='write an HTML page')
@options.output_options
def compare(
    measured: Path, model: str, shift: float | None, out: Path | None, as_json: bool, quiet: bool
) -> None:
    """
    Compare a measured bag with a model or another bag.

    The model starts at the state where the bag starts and gets its conditions and recorded
    voltages; two bags are aligned by the onset of the command. Prints the error of each signal,
    in its unit and in multiples of the sensor noise, and the stick-slip cycles of both.
    """
    from pneu_rig_ros.analysis.comparison import compare_with_bag, compare_with_model
    from pneu_rig_ros.records import is_bag

    if is_bag(Path(model)):
        comparison = compare_with_bag(measured, model, shift)
    elif shift is not None:
        raise RigError('--shift is for two bags; a model starts with the bag')
    else:
        comparison = compare_with_model(measured, options.load(model, {}), model)
    files = {'page': out} if out else {}
    if out:
        from pneu_rig_ros.report.comparison_page import FIGURES, write_page

        with output.progress_bar('figures', FIGURES, quiet=quiet) as progress:
            write_page(out, comparison, progress)
    if as_json:
        output.print_json({**comparison.to_dict(), **files})
    elif not quiet:
        _print(comparison, files)


def _print(comparison: Comparison, files: dict[str, Path]) -> None:
    from pneu_rig_ros.report.comparison_page import (
        SIGNAL_HEADS,
        condition_texts,
        event_rows,
        ratio_note,
        signal_rows,
    )

    output.print_table(SIGNAL_HEADS, signal_rows(comparison))
    output.console().print()
    output.print_table(('', '>measured', f'>{comparison.second}'), event_rows(comparison))
    output.console().print()
    note = ratio_note(comparison)
    output.print_values(
        {
            'measured': comparison.measured.recording.name,
            comparison.second: comparison.simulated.recording.name,
            'conditions': ',\n'.join(condition_texts(comparison)) or output.UNKNOWN,
            **({'RMSE / noise': note} if note else {}),
            **({'shifted by': f'{-comparison.shift:.3f} s'} if comparison.shift else {}),
            **files,
        }
    )
