"""
Make the bags of one trial: ``python -m blind.make_bags --effect supply_droop --out DIR``.

Run in the folder ``test``. DIR gets fit_1 to fit_4, verify_1, verify_2 and model.yaml;
DIR.truth.yaml beside it says what was hidden. ``blind.make_trial`` makes the trials themselves.
"""

import zlib
from pathlib import Path

import click
import yaml

from pneu_rig_ros.scenarios.hidden import CYLINDERS, EFFECTS, STRENGTHS, Secret, hide

from .rig import make_bags, visibility
from .sensors import CALIBRATED, drawn_gains
from .settings import settings
from .trials import join


def pairs(texts: tuple[str, ...]) -> dict[str, float | str]:
    """Return section.key -> value from 'section.key=value'."""
    split = (text.split('=', 1) for text in texts)
    return {name: yaml.safe_load(value) for name, value in split}


@click.command()
@click.option('--effect', 'effects', multiple=True, type=click.Choice(EFFECTS))
@click.option('--truth', multiple=True, help='section.key=value of the true rig only')
@click.option('--model', multiple=True, help='section.key=value of the model only')
@click.option('--cylinder', type=click.Choice(['1', '2', '3']), default='1')
@click.option('--strength', type=click.Choice(STRENGTHS), default='medium')
@click.option('--noise', default=1.0, help='multiple of the noise of the rig')
@click.option('--gains', is_flag=True, help='sensors wrong within their accuracy class')
@click.option('--seed', default=1)
@click.option('--out', type=click.Path(path_type=Path), required=True)
def main(
    effects: tuple[str, ...],
    truth: tuple[str, ...],
    model: tuple[str, ...],
    cylinder: str,
    strength: str,
    noise: float,
    gains: bool,
    seed: int,
    out: Path,
) -> None:
    """Make bags with effects hidden in them; with none: a rig that is as the model says."""
    name = CYLINDERS[int(cylinder) - 1]
    friction = settings(name)['friction']
    secret = join(*(hide(effect, name, strength, friction) for effect in effects))
    secret = join(secret, Secret({}, pairs(truth), pairs(model)))
    seed = zlib.crc32(f'{name} {effects} {strength} {noise} {seed}'.encode())
    slopes = drawn_gains(seed) if gains else CALIBRATED
    made = make_bags(out, name, secret, noise, seed, slopes)
    seen = visibility(name, secret, noise)
    answer = {**secret._asdict(), 'gains': list(slopes), 'visibility': seen}
    out.with_name(f'{out.name}.truth.yaml').write_text(yaml.safe_dump(answer, sort_keys=False))
    bags = f'{" ".join(map(str, made.fit))} --verify {" ".join(map(str, made.verify))}'
    click.echo(f'pneu-rig diagnose {bags} --model {made.model} --out {out}/answer')


if __name__ == '__main__':
    main()
