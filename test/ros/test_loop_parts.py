"""The parts of the nodes that need no ROS graph."""

import itertools
import time

import pytest

from pneu_rig_ros.nodes.joining import Joiner
from pneu_rig_ros.nodes.losses import Losses
from pneu_rig_ros.nodes.pacing import Metronome, TickErrors
from pneu_rig_ros.nodes.timeline import Timeline


def test_joiner_joins_by_stamp_whatever_the_order_of_arrival():
    joiner = Joiner(3)
    first, second, third = joiner.queues
    first.extend([(1, 10.0), (2, 20.0)])
    second.append((1, 11.0))
    assert list(joiner.joined()) == []
    third.extend([(1, 12.0), (2, 22.0)])
    assert list(joiner.joined()) == [(1, [10.0, 11.0, 12.0])]
    second.append((2, 21.0))
    assert list(joiner.joined()) == [(2, [20.0, 21.0, 22.0])]
    assert joiner.dropped == 0


@pytest.mark.parametrize('holes', [(1, 5, 6), (3, 3, 3), (2, 4, 9)])
def test_joiner_drops_incomplete_stamps_and_goes_on(holes):
    joiner = Joiner(3)
    for queue, hole in zip(joiner.queues, holes, strict=True):
        queue.extend((stamp, float(stamp)) for stamp in range(10) if stamp != hole)
    joined = [stamp for stamp, _ in joiner.joined()]
    # Nothing follows stamp 9, so that one whose other parts are missing still waits.
    assert joined == [stamp for stamp in range(10) if stamp not in holes]
    waiting = sum(map(len, joiner.queues))
    assert joiner.dropped + waiting == 3 * (10 - len(joined)) - 3


def test_timeline_gives_the_stamp_of_the_last_sample_before():
    # sent:     100   200   300
    # stamp:     0     7     14
    timeline = Timeline()
    for sent, stamp in ((100, 0), (200, 7), (300, 14)):
        timeline.mark(sent, stamp)
    sent = [50, 100, 150, 199, 200, 299, 300]
    assert [timeline.time_of(t) for t in sent] == [0, 0, 0, 0, 7, 7, 14]
    assert [timeline.knows(t) for t in (50, 300, 301)] == [True, True, False]
    timeline.forget_before(250)
    assert [timeline.time_of(t) for t in (250, 299, 300)] == [7, 7, 14]


def test_an_empty_timeline_knows_nothing():
    assert not Timeline().knows(0)
    assert Timeline().time_of(5) == 0


def test_losses_are_gaps_but_not_restarts_or_shared_topics():
    losses = Losses()
    for number in (5, 6, 9, 10, 1, 2):
        losses.note('position', number)
        losses.note('u', number)
    assert losses.total == 2


def test_tick_errors_have_exact_percentiles_and_maximum():
    errors = TickErrors()
    for microseconds in range(1, 101):
        errors.add(microseconds * 1000, period_ns=90_500)
    assert errors.percentile_ms(50) == pytest.approx(0.050)
    assert errors.percentile_ms(99) == pytest.approx(0.099)
    assert (errors.count, errors.late, errors.max_ns) == (100, 10, 100_000)


def test_tick_errors_beyond_the_histogram_show_the_maximum():
    errors = TickErrors()
    errors.add(10**9, period_ns=1)
    assert errors.percentile_ms(50) == 1e3


def test_metronome_catches_up_late_ticks_without_skipping():
    period = 2_000_000
    metronome = Metronome(period)
    metronome.wait()
    start = time.monotonic_ns()
    while time.monotonic_ns() < start + 10 * period:
        pass
    for _ in range(20):
        metronome.wait()
    elapsed = (time.monotonic_ns() - start) / period
    assert elapsed == pytest.approx(20, abs=5)
    assert metronome.errors.count == 21
    assert metronome.errors.late >= 8


def test_metronome_never_ticks_early():
    metronome = Metronome(200_000)
    times = []
    for _ in range(50):
        metronome.wait()
        times.append(time.monotonic_ns())
    # The deadlines are equally spaced, the first one before the first tick.
    assert all(t >= times[0] - 10**9 for t in times)
    late = [t - i * 200_000 for i, t in enumerate(times)]
    assert min(b - a for a, b in itertools.pairwise(times)) >= 0
    assert min(late) > times[0] - metronome.errors.max_ns - 200_000
