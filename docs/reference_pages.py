"""
Writes the reference pages from the code: topics, nodes, configuration, effects, commands, modules.

`docs/conf.py` calls it, so that the pages of a build are never older than the code. By hand::

    python docs/reference_pages.py FOLDER
"""

import ast
import importlib
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click
import yaml

import pneu_rig_ros
from pneu_rig_ros.cli import command
from pneu_rig_ros.model import effects as library
from pneu_rig_ros.model.effect import Balance
from pneu_rig_ros.model.parameters import SECTIONS
from pneu_rig_ros.model.quantity import Choice, Quantity, QuantityList, specifications
from pneu_rig_ros.records.topics import TOPICS
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.rig.configuration import Sampling
from pneu_rig_ros.rig.sensors import Sensors

MADE = '<!-- made by docs/reference_pages.py from the code; do not edit -->'
NODES = {
    'plant': 'PlantNode',
    'valve_command': 'ValveCommandNode',
    'friction_estimator': 'FrictionEstimatorNode',
    'recorder': 'RecorderNode',
    'excitation': 'ExcitationNode',
    'position_controller': 'PositionControllerNode',
    'joint_command': 'JointCommandNode',
    'replay': 'ReplayNode',
    'shadow': 'ShadowNode',
}
Lines = Iterator[str]


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> Lines:
    """Yield the lines of a Markdown table."""
    yield ''
    for row in (heads, ['---'] * len(heads), *rows):
        yield f'| {" | ".join(str(cell).replace("|", chr(92) + "|") for cell in row)} |'
    yield ''


def bounds(low: float, high: float) -> str:
    """Return a range; empty where there is none."""
    return f'{low:g} to {high:g}' if math.isfinite(low) and math.isfinite(high) else ''


def topics() -> Lines:
    """Yield the page of the topics."""
    yield from ('# Topics', '', 'Names are relative to the namespace of the rig, but for those')
    yield 'that begin with `/`. Every rig has the first table; the second comes from nodes that'
    yield 'are started beside it. All are reliable; *kept* ones are transient local. Publishers of'
    yield 'others may be best effort. [Why some have no stamp](../design.md#messages).'
    for extra in (False, True):
        rows = [
            (f'`{t.name}`', f'`{t.type}`', t.content, t.when)
            for t in TOPICS.values()
            if t.extra == extra
        ]
        yield from table(('topic', 'type', 'content', 'published'), rows)


def node_parameters(name: str) -> list[Any]:
    """Return the parameters of a node, the shared ones first; for the plant of cylinder_2."""
    from pneu_rig_ros.nodes.plant import quantity_parameters

    node = getattr(importlib.import_module(f'pneu_rig_ros.nodes.{name}'), NODES[name])
    more = quantity_parameters(load_configuration('cylinder_2')) if name == 'plant' else ()
    return [*node.SHARED, *node.PARAMETERS, *more]


def nodes() -> Lines:
    """Yield the page of the nodes and their parameters."""
    from pneu_rig_ros.nodes.managed_node import ManagedNode

    yield from ('# Nodes and parameters', '', 'Given with `--ros-args -p NAME:=VALUE`, or all')
    yield 'together with `--params-file`: `config/nodes.yaml` holds every default. A wrong type'
    yield 'or a value out of range is refused. *At run time*: `ros2 param set` may change it.'
    yield 'The same as a schema, in the form of generate_parameter_library:'
    yield '{download}`parameters.yaml`.'
    for name, kind in NODES.items():
        node = getattr(importlib.import_module(f'pneu_rig_ros.nodes.{name}'), kind)
        yield from ('', f'## {name}', '', paragraph(node.__doc__))
        shared = len(node.SHARED)
        yield from table(PARAMETER_HEADS, map(_parameter_row, node_parameters(name)[shared:]))
        if name == 'plant':
            yield 'The last defaults are those of the cylinder, here of cylinder_2.'
    yield from ('', '## Of every node', '', 'Besides `use_sim_time`, which every ROS node has:')
    yield from table(PARAMETER_HEADS, map(_parameter_row, ManagedNode.SHARED))
    yield '`autostart` is of plant, valve_command, friction_estimator, recorder and shadow alone.'
    yield ''
    yield '`rig` runs plant, valve_command, friction_estimator and recorder in one process; its'
    yield 'nodes have the names and parameters above.'


PARAMETER_HEADS = ('parameter', 'default', 'unit', 'range', 'meaning', 'at run time')


def _parameter_row(p: Any) -> tuple[object, ...]:
    default = str(p.default).lower() if isinstance(p.default, bool) else repr(p.default)
    allowed = '; '.join(filter(None, (bounds(p.low, p.high), p.allowed)))
    changes = '' if p.read_only else 'yes'
    return f'`{p.name}`', f'`{default}`', p.unit, allowed, p.description, changes


def parameter_schema() -> str:
    """Return all parameters in the form of generate_parameter_library, as YAML."""
    nodes = {name: {p.name: _schema_entry(p) for p in node_parameters(name)} for name in NODES}
    return yaml.safe_dump(nodes, sort_keys=False, allow_unicode=True, width=99)


def _schema_entry(p: Any) -> dict[str, Any]:
    kind = type(p.default)
    entry = {
        'type': {bool: 'bool', int: 'int', float: 'double', str: 'string'}[kind],
        'default_value': p.default,
        'description': p.descriptor().description,
        'read_only': p.read_only,
    }
    if p.allowed:
        entry['additional_constraints'] = p.allowed
    if p.choices:
        entry['validation'] = {'one_of<>': [list(p.choices)]}
    elif math.isfinite(p.low) and math.isfinite(p.high):
        entry['validation'] = {'bounds<>': [kind(p.low), kind(p.high)]}
    return entry


def configuration() -> Lines:
    """Yield the page of the configuration file."""
    yield from (
        '# The configuration file',
        '',
        'The value of `cylinder`, `--cylinder` and `--model`:',
    )
    yield 'the name of a shipped cylinder or a YAML file. Sections that a file lacks come from'
    yield '`config/rig.yaml`; a section that it has must be complete. Every value carries its'
    yield 'unit, as in `stroke: 0.2 m`, and `-` for a pure number. Pressures are absolute.'
    for name, section in {**SECTIONS, 'sensors': Sensors, 'sampling': Sampling}.items():
        yield from ('', f'## {name}', '', paragraph(section.__doc__))
        yield from table(
            ('key', 'unit', 'range', 'meaning'),
            [(f'`{key}`', *_specification(spec)) for key, spec in specifications(section).items()],
        )
    yield from ('', '## effects', '', 'A mapping of effect to its parameters, see [](effects.md):')
    yield from ('', '```yaml', 'effects:', '  chamber_leak: {area_1: 2e-9 m^2, area_2: 0.0 m^2}')
    yield from ('```', '', 'Beside them an effect may have a')
    yield '[`shape`](../design.md#another-form-of-an-effect), a factor over one variable.'


def _specification(spec: Quantity | QuantityList | Choice) -> tuple[str, str, str]:
    if isinstance(spec, Choice):
        return 'name', ', '.join(f'`{name}`' for name in spec.names), spec.description
    if isinstance(spec, QuantityList):
        item = spec.item
        kind = f'list of up to {spec.longest}, {item.unit}'
        return kind, bounds(item.low, item.high), item.description
    return spec.unit, bounds(spec.low, spec.high), spec.description


def effects() -> Lines:
    """Yield the page of the effects."""
    yield from ('# Effects', '', 'What the model can add to the equations of the paper, switched')
    yield 'on in the [configuration file](configuration.md#effects). With its null values an'
    yield 'effect vanishes exactly. [](../add_effect.md) describes how to add one.'
    for balance in Balance:
        names = [n for n in library.names() if library.load(n).balance is balance]
        if names:
            yield from ('', f'## On {balance.name.lower().replace("_", " ")} [{balance.unit}]')
        for name in names:
            yield from _effect(name)


def _effect(name: str) -> Lines:
    effect = library.load(name)
    yield from ('', f'### {name}', '', f'{effect.title[:1].upper()}{effect.title[1:]}. Shows in')
    yield f'{", ".join(regime.label for regime in effect.regimes)}. Source: {effect.source}.'
    if effect.laws:
        yield f'Completes the friction law {" or ".join(f"`{law}`" for law in effect.laws)}.'
    if effect.drivers:
        yield f'May have a shape over {", ".join(f"`{name}`" for name in effect.drivers)}.'
    if effect.describes:
        yield 'An empirical term, not a physical cause: describes an unexplained residual.'
    rows = []
    for key, q in specifications(effect.parameters).items():
        null = f'{getattr(effect.null, key):g}'
        rows.append((f'`{key}`', q.unit, bounds(q.low, q.high), null, q.description))
    yield from table(('parameter', 'unit', 'range', 'null', 'meaning'), rows)


def commands() -> Lines:
    """Yield the page of the command line."""
    yield from (
        '# Commands',
        '',
        'The output of `pneu-rig COMMAND --help`. Errors are one line on stderr. `--json` prints',
        'plain data on stdout and nothing else; `--quiet` prints nothing but errors.',
        '',
        '| exit code | meaning |',
        '| --- | --- |',
        '| 0 | done, whatever the result: a diagnosis may find nothing, or something unknown |',
        '| 2 | an error in one line: what cannot be used, where, and what is allowed |',
        '| 1 | an error of the program, or the reader of its output (such as `head`) has gone |',
        '| 130 | interrupted by Ctrl-C or SIGTERM |',
    )
    for name, subcommand in sorted(command.commands.items()):
        parent = click.Context(command, info_name='pneu-rig', max_content_width=99)
        with click.Context(
            subcommand, info_name=name, parent=parent, max_content_width=99, terminal_width=99
        ) as context:
            yield from ('', f'## {name}', '', '```text', subcommand.get_help(context), '```')


def modules() -> Lines:
    """Yield the page of all modules, by folder, with the first line of their docstrings."""
    yield from ('# Modules', '', 'Every file of the package and what it contains.')
    root = Path(pneu_rig_ros.__file__).parent
    for folder in sorted({path.parent for path in root.rglob('*.py')}):
        package = ast.get_docstring(ast.parse((folder / '__init__.py').read_text())) or ''
        rows = []
        for path in sorted(folder.glob('[!_]*.py')):
            text = ast.get_docstring(ast.parse(path.read_text())) or ''
            rows.append((f'`{path.name}`', text.split('\n\n')[0].replace('\n', ' ')))
        name = folder.relative_to(root.parent).as_posix()
        yield from ('', f'## {name}', '', package.split('\n\n')[0])
        yield from table(('file', 'contains'), rows)


def paragraph(text: str | None) -> str:
    """Return a docstring without its indentation and parameter list."""
    lines = [line.strip() for line in (text or '').strip().splitlines()]
    return '\n'.join(line for line in lines if not line.startswith(':param')).replace('``', '`')


PAGES: dict[str, Callable[[], Lines]] = {
    'topics': topics,
    'nodes': nodes,
    'configuration': configuration,
    'effects': effects,
    'commands': commands,
    'modules': modules,
}


def write(folder: Path) -> None:
    """Write all pages into a folder; what has not changed is left alone, for faster builds."""
    folder.mkdir(exist_ok=True)
    texts = {'parameters.yaml': parameter_schema()}
    for name, page in PAGES.items():
        first, *rest = page()
        texts[f'{name}.md'] = '\n'.join([first, '', MADE, *rest, ''])
    for name, text in texts.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding='utf-8') != text:
            path.write_text(text, encoding='utf-8')


if __name__ == '__main__':
    write(Path(sys.argv[1]))
