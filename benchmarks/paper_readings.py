"""
What each open reading of the paper does: the default with one thing read in another way.

Prints a table in Markdown, the one of docs/decisions.md::

    python -m benchmarks.paper_readings
"""

from collections.abc import Iterator
from typing import Any

import click

from pneu_rig_ros.claims.experiments import CYLINDERS, Laboratory, Reading
from pneu_rig_ros.claims.statements import STATEMENTS, measure
from pneu_rig_ros.model.parameters import (
    FILM_PRINTED,
    FILM_RESTS_WITH_CLOCK,
    FOLLOWS_CLOCK,
    HELD_TO_NEXT_BREAKAWAY,
    LATCHED_AT_BREAKAWAY,
    Model,
)

ELEMENTS = 4
"""Of F(z), where it is not one spring: equal stiffness, slipping at 1, 2 and 3 N."""


def common(section: str, **fields: Any) -> Reading:
    """Return a reading with fields of a section that differ from the default."""
    return Reading('changed', {section: fields})


def own(section: str, **fields: Any) -> Reading:
    """Return a reading with ``value(model)`` for fields of a section, of each cylinder's own."""
    models = {name: Reading().model(name) for name in CYLINDERS}
    single = {
        name: {section: {key: value(model) for key, value in fields.items()}}
        for name, model in models.items()
    }
    return Reading('changed', {}, single)


def divided(model: Model) -> tuple[float, ...]:
    """Return the stiffness of each of several elements in F(z) [N/m]."""
    (stiffness,) = model.friction.element_stiffness
    return (stiffness / ELEMENTS,) * ELEMENTS


def changes() -> Iterator[tuple[str, str, Reading]]:
    """Yield the words or symbol of the paper, another way to read it, and the reading."""
    friction = 'friction'
    yield '-', 'the default', Reading()
    updated = '"updated according to Equation (16)"'
    for text, value in (
        ('F_s follows the clock', FOLLOWS_CLOCK),
        ('F_s latched for the slip', LATCHED_AT_BREAKAWAY),
        ('F_s held to the next breakaway', HELD_TO_NEXT_BREAKAWAY),
    ):
        yield updated, text, common(friction, static_friction_reading=value)
    yield 'K_V2 (u_i - u_m), Eq. 3', 'from u_n', common('valve', exhaust_zero_voltage=2.35)
    yield '"4 bar"', 'gauge', common('operation', supply_pressure=5e5)
    yield '(1 - h) F_s, Eq. 11', 'h as printed', common(friction, film_reading=FILM_PRINTED)
    yield (
        'v = 0, Eq. 13',
        'the same as in Eq. 16',
        common(friction, film_rest_reading=FILM_RESTS_WITH_CLOCK),
    )
    yield (
        'v = 0, Eq. 16',
        '0.5 and 0.7 mm/s for all',
        common(friction, stop_velocity=0.5e-3, start_velocity=0.7e-3),
    )
    yield 'T, Eq. 9', '0', common(friction, fluid_time_constant=0.0)
    yield 'T, Eq. 9', '0.02 s for all', common(friction, fluid_time_constant=0.02)
    limits = tuple(float(force) for force in range(1, ELEMENTS))
    yield (
        'F(z), Eq. 9',
        f'{ELEMENTS} elements',
        own(friction, element_stiffness=divided, element_limit=lambda _: limits),
    )
    yield 'memory time', '4.6 s for all', common(friction, memory_time=4.6)
    yield 'rest before the start', '386 s for all', common('operation', rest_time=386.0)
    for share in (0.0, 0.35):
        yield (
            'start of Fig. 4-6',
            f'{share:.0%} of the stroke',
            own('operation', initial_position=lambda model, s=share: s * model.cylinder.stroke),
        )
    yield (
        'chambers at the start',
        'both at 1.2 bar',
        common('operation', initial_pressure_1=1.2e5, initial_pressure_2=1.2e5),
    )
    yield 'R', '296.8 J/(kg K), nitrogen', common('gas', gas_constant=296.8)


@click.command()
def main() -> None:
    """Measure every statement under each reading."""
    click.echo('| of the paper | read as | fails | at rest, cylinder 1, 2, 3 |')
    click.echo('| --- ' * 4 + '|')
    for words, text, reading in changes():
        laboratory = Laboratory(reading)
        rows = [measure(laboratory, statement) for statement in STATEMENTS]
        fails = ', '.join(str(row.statement.number) for row in rows if not row.holds)
        rests = ', '.join(f'{stroke.rest_share():.0%}' for stroke in laboratory.captions())
        click.echo(f'| {words} | {text} | {fails or "none"} | {rests} |')


if __name__ == '__main__':
    main()
