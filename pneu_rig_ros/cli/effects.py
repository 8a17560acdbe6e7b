"""`pneu-rig effects`: the library of optional physical effects."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from pneu_rig_ros.cli import options, output

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.text import Text

    from pneu_rig_ros.model.effect import Effect


@click.command(
    epilog=options.examples(
        'pneu-rig effects',
        'pneu-rig effects --json | jq .supply_droop.parameters',
    )
    + '\b\nAn effect is switched on in the YAML file of a rig:\n'
    '  effects: {supply_droop: {resistance: 2e9 Pa*s/kg}}\n',
)
@options.json_option
def effects(as_json: bool) -> None:
    """
    List what the model can add to the paper's equations.

    Each effect is listed with the balance it enters, the regimes of motion in which it shows, its
    source, and its parameters: unit, range, and the null value with which it vanishes. Effects
    that complete a friction law name the laws. The empirical terms at the end describe what no
    effect explains; they are not physical causes.
    """
    from pneu_rig_ros.model import effects as library

    data = {name: to_dict(library.load(name)) for name in library.names()}
    if as_json:
        output.print_json(data)
        return
    heads = ('balance', 'description')
    output.print_table(('effect', *heads), _rows(data, describes=False), lines=True)
    output.console().print()
    output.console().print('Empirical terms, not physical causes', style='bold')
    output.print_table(('term', *heads), _rows(data, describes=True), lines=True)


def to_dict(effect: Effect) -> dict[str, Any]:
    """Return the declarations of an effect as a JSON-compatible dict."""
    from pneu_rig_ros.model.quantity import Quantity, specifications

    parameters = {
        name: {**asdict(spec), 'null': getattr(effect.null, name)}
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


def _rows(data: dict[str, dict[str, Any]], describes: bool) -> Iterator[tuple[str | Text, ...]]:
    """Yield name, balance and description of the effects that describe, or of the others."""
    from rich.text import Text

    for name, effect in data.items():
        if effect['describes'] is not describes:
            continue
        lines = [effect['title']]
        for key, parameter in effect['parameters'].items():
            low, high, null = (f'{parameter[bound]:g}' for bound in ('low', 'high', 'null'))
            unit = '' if parameter['unit'] == '-' else f' {parameter["unit"]}'
            text = parameter['description']
            lines.append(f'{key}: {text}; {low} to {high}{unit}, null {null}')
        lines.append(f'shows in: {", ".join(effect["regimes"])}')
        if effect['laws']:
            lines.append(f'for the laws: {", ".join(effect["laws"])}')
        description = Text('\n'.join(lines)).append(f'\n{effect["source"]}', 'dim')
        yield name, effect['balance'].replace('_', ' '), description
