"""The examples of docs/measured_data.md are understood as they stand."""

import re
from pathlib import Path

import yaml

from pneu_rig_ros.records.conditions import parse_conditions
from pneu_rig_ros.records.mapping import read_mapping
from pneu_rig_ros.records.recording import SIGNALS

PAGE = (Path(__file__).resolve().parents[2] / 'docs' / 'measured_data.md').read_text()
COLUMNS, COMMAS, CONDITIONS, TOPICS = re.findall(r'```yaml\n(.*?)```', PAGE, re.DOTALL)


def test_examples_of_mappings_and_conditions() -> None:
    assert set(read_mapping(yaml.safe_load(COLUMNS)).signals) <= set(SIGNALS)
    assert set(read_mapping(yaml.safe_load(COMMAS)).signals) == {'position', 'force'}
    assert read_mapping(yaml.safe_load(TOPICS)).of_bag
    assert parse_conditions(CONDITIONS, 'page')['supply_pressure'] == 501300.0


def test_every_signal_is_named() -> None:
    assert all(f'`{name}`' in PAGE for name in SIGNALS)
