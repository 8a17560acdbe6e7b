"""`pneu-rig effects`: the library of optional physical effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import output

if TYPE_CHECKING:
    from pneu_rig_ros.model.effect import Effect


@click.command(
    short_help='The optional physical effects and their parameters',
    epilog='\b\nExamples:\n'
    '  pneu-rig effects\n'
    '  pneu-rig effects --json | jq .supply_droop.parameters\n'
    '\b\nAn effect is switched on in the YAML file of a rig:\n'
    '  effects: {supply_droop: {resistance: 2e9 Pa*s/kg}}\n',
)
@click.option('--json', 'as_json', is_flag=True, help='print plain data for scripts')
def effects(as_json: bool) -> None:
    """
    List what the model can add to the paper's equations.

    Each effect with the balance it enters, the regimes of motion in which it shows, its source,
    and its parameters: unit, range, and the null value with which it vanishes. A few complete a
    friction law that lacks them; the laws are named there. At the end come the terms with which a
    diagnosis describes what no effect explains: they are no causes.
    """
    from pneu_rig_ros.model import effects as library

    data = {name: plain(library.load(name)) for name in library.names()}
    if as_json:
        output.print_json(data)
    else:
        _print(data)


def plain(effect: Effect) -> dict[str, Any]:
    """Return what an effect declares, as plain data."""
    from pneu_rig_ros.model.quantity import Quantity, specifications

    parameters = {
        name: {
            'unit': spec.unit,
            'low': spec.low,
            'high': spec.high,
            'null': getattr(effect.null, name),
            'description': spec.description,
        }
        for name, spec in specifications(effect.parameters).items()
        if isinstance(spec, Quantity)
    }
    return {
        'title': effect.title,
        'balance': effect.balance.name.lower(),
        'regimes': [regime.label for regime in effect.regimes],
        'describes': effect.describes,
        'source': effect.source,
        'states': list(effect.states),
        'laws': list(effect.laws),
        'drivers': list(effect.drivers),
        'parameters': parameters,
        'probes': [probe._asdict() for probe in effect.probes],
    }


def _print(data: dict[str, dict[str, Any]]) -> None:
    """Print the effects, and below them what only describes."""
    terms = {name: effect for name, effect in data.items() if effect['describes']}
    _print_table('effect', {name: data[name] for name in data if name not in terms})
    terminal = output.console()
    terminal.print()
    terminal.print('Descriptions of what has no name: no causes', style='bold')
    _print_table('description', terms)


def _print_table(head: str, data: dict[str, dict[str, Any]]) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, show_lines=True)
    table.add_column(head, no_wrap=True)
    table.add_column('balance', no_wrap=True)
    table.add_column('what it is')
    for name, effect in data.items():
        regimes, source = ', '.join(effect['regimes']), effect['source']
        parameters = ''.join(f'\n{_line(*item)}' for item in effect['parameters'].items())
        laws = f'for the laws: {", ".join(effect["laws"])}\n' if effect['laws'] else ''
        about = Text(f'{effect["title"]}{parameters}\nshows in: {regimes}\n{laws}')
        table.add_row(name, effect['balance'].replace('_', ' '), about.append(source, 'dim'))
    output.print_table(table)


def _line(name: str, parameter: dict[str, Any]) -> str:
    """Return one parameter as a line."""
    low, high, null = (f'{parameter[key]:g}' for key in ('low', 'high', 'null'))
    unit = '' if parameter['unit'] == '-' else f' {parameter["unit"]}'
    return f'{name}: {parameter["description"]}; {low} to {high}{unit}, null {null}'
