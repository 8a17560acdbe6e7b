"""The text on rig_description is the configuration, and gives a bag its custom data."""

from pneu_rig_ros.records.description import bag_metadata, describe, git_revision
from pneu_rig_ros.rig import configuration_from_yaml, load_configuration


def test_description_loads_back_unchanged() -> None:
    configuration = load_configuration('cylinder_3', seed=5, supply_pressure=6e5)
    assert configuration_from_yaml(describe(configuration), 'test') == configuration


def test_metadata_name_the_run() -> None:
    configuration = load_configuration('cylinder_3', seed=5, friction='lugre')
    text = describe(configuration)
    metadata = bag_metadata(text)
    assert metadata['configuration'] == text
    assert metadata['cylinder'] == 'cylinder_3'
    assert metadata['friction_model'] == 'lugre'
    assert metadata['seed'] == '5'
    assert metadata['git_revision'] == git_revision()


def test_foreign_text_gives_unknown() -> None:
    assert set(bag_metadata('').values()) == {'', 'unknown'}
    assert bag_metadata('friction: [')['friction_model'] == 'unknown'
