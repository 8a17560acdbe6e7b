"""The layouts for PlotJuggler and Foxglove: every name is a field of a topic of the rig."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

from pneu_rig_ros.records.cdr_encoding import typestore
from pneu_rig_ros.records.topics import PISTON, TOPICS, topic_named

CONFIG = Path(__file__).resolve().parents[1] / 'config'
FOXGLOVE = json.loads((CONFIG / 'foxglove_layout.json').read_text())
JUGGLERS = {
    name: ElementTree.parse(CONFIG / f'{name}.xml').getroot()
    for name in ('plotjuggler_layout', 'plotjuggler_shadow_layout')
}
"""Layouts of PlotJuggler: of a rig alone, and of a rig with its shadow."""


def curves(name: str) -> list[str]:
    return [curve.attrib['name'] for curve in JUGGLERS[name].iter('curve')]


def paths() -> list[str]:
    panels = FOXGLOVE['configById'].values()
    return [path['value'] for panel in panels for path in panel.get('paths', ())]


def fields(topic: str) -> set[str]:
    definition = typestore().fielddefs[TOPICS[topic].type]
    return {name for name, _ in definition[1]}


@pytest.mark.parametrize('curve', [curve for name in JUGGLERS for curve in curves(name)])
def test_plotjuggler_curves_are_fields_of_topics(curve: str) -> None:
    # PlotJuggler writes a joint's values as TOPIC/JOINT/FIELD
    topic, field = curve.removesuffix(']').rsplit('/', 1)
    joint = topic.endswith(f'/{PISTON}')
    topic = topic.removesuffix(f'/{PISTON}').removeprefix('/')
    assert topic in TOPICS
    assert field.split('[')[0] in fields(topic)
    assert joint == (TOPICS[topic].type == 'sensor_msgs/msg/JointState')


def test_plotjuggler_finds_every_curve_in_a_bag_of_the_rig_alone() -> None:
    # it warns of those that a bag lacks, and then shows none of them
    own = {topic for topic in TOPICS if not topic.startswith(('predicted/', 'residual/'))}
    for curve in curves('plotjuggler_layout'):
        assert any(curve.startswith(f'/{topic}/') for topic in own - {'reference'})


@pytest.mark.parametrize('path', paths())
def test_foxglove_paths_are_fields_of_topics(path: str) -> None:
    match = re.fullmatch(r'/([\w/]+)\.(\w+)(\[[\d:]+\])?', path)
    assert match is not None
    assert match[1] in TOPICS
    assert match[2] in fields(match[1])


def links() -> set[str]:
    robot = ElementTree.parse(CONFIG / 'cylinder.urdf.xml').getroot()
    return {link.attrib['name'] for link in robot.findall('link')}


def leaves(layout: Any) -> Iterator[str]:
    if isinstance(layout, str):
        yield layout
    else:
        assert layout['direction'] in ('row', 'column')
        yield from leaves(layout['first'])
        yield from leaves(layout['second'])


def test_foxglove_titles_say_the_unit_of_a_plot() -> None:
    for name, panel in FOXGLOVE['configById'].items():
        if name.startswith('Plot!'):
            # each of the two programs reads a key of its own
            assert panel['foxglovePanelTitle'] == panel['lichtblickPanelTitle']
            assert panel['foxglovePanelTitle'].endswith(f' [{panel["yAxisLabel"]}]')


def test_foxglove_shows_each_panel_once() -> None:
    shown = list(leaves(FOXGLOVE['layout']))
    assert sorted(shown) == sorted(FOXGLOVE['configById'])


def test_foxglove_shows_the_cylinder_and_the_diagnostics() -> None:
    panels = FOXGLOVE['configById']
    robot = panels['3D!cylinder']['layers']['cylinder']
    assert (robot['layerId'], robot['sourceType']) == ('foxglove.Urdf', 'topic')
    assert topic_named(robot['topic']) == TOPICS['robot_description']
    # Lichtblick moves a URDF by transforms alone: a script of the layout makes them
    script = FOXGLOVE['userNodes']['piston']['sourceCode']
    assert set(re.findall(r'"/(\w+)"', script)) == {'joint_states'}
    joint = (
        ElementTree.parse(CONFIG / 'cylinder.urdf.xml').getroot().find(f'joint[@name="{PISTON}"]')
    )
    assert joint is not None
    frames = {'parent': joint.find('parent'), 'child': joint.find('child')}
    for side, link in frames.items():
        assert link is not None
        assert f'{side}_frame_id: "{link.attrib["link"]}"' in script
    assert panels['DiagnosticSummary!nodes']['topicToRender'] in TOPICS
    hidden = {
        name for name, axes in panels['3D!cylinder']['transforms'].items() if not axes['visible']
    }
    assert hidden == {f'frame:{link}' for link in links()}


def test_rviz_shows_the_cylinder() -> None:
    manager = yaml.safe_load((CONFIG / 'rig.rviz').read_text())['Visualization Manager']
    assert manager['Global Options']['Fixed Frame'] in links()
    shown = {display['Class'].rpartition('/')[2]: display for display in manager['Displays']}
    topic = shown['RobotModel']['Description Topic']
    assert topic_named(topic['Value']) == TOPICS['robot_description']
    # published once: whoever comes later hears of it only so
    assert topic['Durability Policy'] == 'Transient Local'


def test_plotjuggler_tabs_have_as_many_plots_as_they_say() -> None:
    for splitter in (one for root in JUGGLERS.values() for one in root.iter('DockSplitter')):
        plots = splitter.findall('DockArea')
        assert int(splitter.attrib['count']) == len(plots) == len(splitter.findall('*/plot'))
        sizes = [float(size) for size in splitter.attrib['sizes'].split(';')]
        assert len(sizes) == len(plots)
        assert sum(sizes) == pytest.approx(1.0)
