"""What the paper says of the strokes of Fig. 4-6 and 11-13, at the captions' operating points."""

import itertools
from collections.abc import Iterator

import numpy as np

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.claims.experiments import (
    CAPTIONS,
    CYLINDERS,
    INTERVAL,
    Laboratory,
    Stroke,
    medians,
    middle,
)
from pneu_rig_ros.claims.findings import (
    Finding,
    at_least,
    at_most,
    falls,
    gradual,
    numbers,
    require_at_least,
)

RLG, DWELL = 'revised_lugre', 'revised_lugre_dwell'


VISIBLE_CREEP = 0.5e-3
"""
A sticking phase with more travel than this creeps [m].

Seven steps of the position sensor; a bristle of 1e5 N/m bends by 0.2 mm under F_smax.
"""
MOSTLY_AT_REST = 'at rest at least half of the time from the first to the last slip'


def stroke_texts(laboratory: Laboratory) -> Iterator[str]:
    """Yield each of the strokes of Fig. 4-6 in a line."""
    for stroke in laboratory.captions():
        law = stroke.plant.model.friction
        added_mass = law.viscous_coefficient * law.fluid_time_constant  # by the term of Eq. 9
        yield (
            f'{stroke.experiment.cylinder}: {stroke.count} cycles, '
            f'at rest {stroke.rest_share():.0%} of the time from the first to the last slip, '
            f'median dwell {stroke.median_dwell:.2f} s, slip {stroke.median_slip:.1f} mm, '
            f'travel while sticking {1e3 * middle(stroke.column("creep")):.2f} mm; '
            f'added mass {added_mass:.1f} kg'
        )


def cylinder_1(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 1 (Fig. 4)."""
    stroke = laboratory.perform(CAPTIONS['cylinder_1'])
    peaks, waits = stroke.column('peak_friction'), stroke.column('dwell')
    first = float(peaks[0]) if len(peaks) else np.nan
    longest = float(waits.max(initial=0.0))
    pressures, lows = pressure_peaks(stroke)
    slipping = pressures[:-1]
    drops = float(np.mean(slipping - lows > 0.1 * slipping)) if len(lows) else 0.0
    shorter = at_most(waits[1:].max(), waits[0]) if len(waits) > 1 else np.nan
    near_15 = 1.0 - abs(first - 15.0) / 1.5
    says_long = 'dwell of several seconds (at least 2 s)'
    says_drops = 'driving pressure drops in at least 90 % of the slips'
    yield Finding('first friction peak 15 N within 10 %', f'{first:.1f} N', near_15)
    yield require_at_least('at least four cycles', stroke.count, 4, 'd')
    yield Finding(says_long, f'{longest:.2f} s', at_least(longest, 2.0))
    yield require_at_least(MOSTLY_AT_REST, stroke.rest_share(), 0.5)
    yield require_at_least(says_drops, drops, 0.9)
    yield Finding('later dwells shorter than the first', numbers(waits) + ' s', shorter)
    yield Finding('dwells progressively shorter', numbers(waits) + ' s', falls(waits[1:]))
    yield Finding('peaks progressively smaller', numbers(peaks, '.1f') + ' N', falls(peaks[1:]))


def cylinder_2(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 2 (Fig. 5)."""
    strokes = laboratory.perform_all([CAPTIONS[name] for name in CYLINDERS[:2]])
    waits, steps = medians(strokes)
    shorter, smaller = at_most(waits[1], waits[0]), at_most(steps[1], steps[0])
    yield require_at_least('stick-slip, at least five cycles', strokes[1].count, 5, 'd')
    yield require_at_least(MOSTLY_AT_REST, strokes[1].rest_share(), 0.5)
    yield Finding('median dwell shorter than of cylinder 1', numbers(waits) + ' s', shorter)
    yield Finding('median slip smaller than of cylinder 1', numbers(steps) + ' mm', smaller)


def cylinder_3(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 3 (Fig. 6)."""
    strokes = laboratory.perform_all(CAPTIONS.values())
    counts = [stroke.count for stroke in strokes]
    waits, steps = medians(strokes[1:])
    pressures = [pressure_peaks(stroke) for stroke in strokes]
    rises = [middle(peaks[1:] - lows) / 1e3 for peaks, lows in pressures]
    more = at_least(counts[2], 2 * max(1, *counts[:2]))
    shorter, smaller = at_most(waits[1], 0.5 * waits[0]), at_most(steps[1], 0.25 * steps[0])
    lower = at_most(rises[2], min(rises[:2]))
    says_dwell = 'median dwell very short (under half of cylinder 2)'
    says_slip = 'median slip extremely small (under a quarter of cylinder 2)'
    says_rise = 'moves after a smaller rise of p1 than cylinder 1 and 2'
    says_reach = 'stops over at least 80 % of the stroke'
    yield Finding('at least twice the cycles of cylinder 1 and 2', numbers(counts, 'd'), more)
    yield Finding(says_dwell, numbers(waits) + ' s', shorter)
    yield Finding(says_slip, numbers(steps) + ' mm', smaller)
    yield Finding(says_rise, numbers(rises, '.1f') + ' kPa', lower)
    yield require_at_least(says_reach, strokes[2].reach, 0.8)


def constant_static_friction(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 8 (Fig. 11-13): RLG against dwell-dependent static friction."""
    for name, old, new in _both_laws(laboratory):
        peaks = new.column('peak_friction')
        gap = abs(old.count - new.count) / max(new.count, 1)
        says = f'{name}: RLG has another number of cycles (by over a quarter)'
        persists = f'{name}: with Eq. 16 stick-slip persists to 80 % of the stroke'
        attenuates = f'{name}: and attenuates (falling peaks after the first, as in 1)'
        yield Finding(says, f'{old.count} against {new.count}', at_least(gap, 0.25))
        yield require_at_least(persists, new.reach, 0.8)
        yield Finding(attenuates, numbers(peaks, '.1f') + ' N', falls(peaks[1:]))


def creep(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 11 (Fig. 5): creep in some sticking phases of cylinder 2, none in general."""
    for stroke in laboratory.captions():
        name, phases = stroke.experiment.cylinder, stroke.column('creep')
        share = float(np.mean(phases > VISIBLE_CREEP)) if len(phases) else np.nan
        text = f'{share:.0%}' if share == share else 'no cycles'
        if name == 'cylinder_2':
            says = f'{name}: over 0.5 mm of creep in one to half of the sticking phases'
            margin = at_most(share, 0.5) if share > 0.0 else -1.0
        else:
            says = f'{name}: in at most a tenth of them'
            margin = at_most(share, 0.1)
        yield Finding(says, text, margin)


def first_cycles(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 14 (Fig. 11-13): RLG gets the first one or two cycles, not the later ones."""
    keys = ('breakaway_time', 'peak_friction', 'slip')
    for name, old, new in _both_laws(laboratory):
        text, off = 'no cycles', np.nan
        if old.cycles and new.cycles:
            pairs = ((getattr(s.cycles[0], key) for s in (old, new)) for key in keys)
            off = max(abs(constant / growing - 1.0) for constant, growing in pairs)
            text = f'{off:.0%}'
        waits = [middle(stroke.column('dwell', 2)) for stroke in (old, new)]
        later = at_least(abs(waits[0] / waits[1] - 1.0), 0.2)
        says = f'{name}: first breakaway, peak and slip within 20 % of those with Eq. 16'
        says_later = f'{name}: median dwell from the third cycle on off by over 20 %'
        yield Finding(says, text, at_most(off, 0.2))
        yield Finding(says_later, numbers(waits) + ' s', later)


def evolution(laboratory: Laboratory) -> Iterator[Finding]:
    """Statement 15 (Fig. 11-13): dwells, pressure and friction peaks vary gradually."""
    for name, old, new in _both_laws(laboratory):
        columns = new.column('dwell'), pressure_peaks(new)[0], new.column('peak_friction')
        trends = [gradual(values[1:]) for values in columns]
        change = [
            abs(falls(stroke.column('peak_friction'))) if stroke.count >= 3 else 0.0
            for stroke in (old, new)
        ]
        says = (
            f'{name}: dwells, pressure and friction peaks follow the number of the cycle'
            ' (correlation at least 0.7)'
        )
        says_change = f'{name}: friction peaks change at least twice as much as with RLG'
        more = at_least(change[1], max(2.0 * change[0], 0.01))
        yield Finding(says, numbers(trends), at_least(min(trends), 0.7))
        yield Finding(says_change, numbers(change, '.0%'), more)


def _both_laws(laboratory: Laboratory) -> Iterator[tuple[str, Stroke, Stroke]]:
    """Yield each cylinder, and its strokes with RLG and with Eq. 16."""
    strokes = laboratory.captions(RLG), laboratory.captions(DWELL)
    yield from zip(laboratory.cylinders, *strokes, strict=True)


def pressure_peaks(stroke: Stroke) -> tuple[Floats, Floats]:
    """Return p1 above the atmosphere [Pa]: at n breakaways, and n - 1 lowest between them."""
    begins = np.rint(stroke.column('breakaway_time') / INTERVAL).astype(np.intp)
    pressure = stroke.run.pressure_1 - stroke.plant.model.gas.atmospheric_pressure
    lows = [pressure[a:b].min() for a, b in itertools.pairwise(begins)]
    return pressure[begins], np.array(lows)
