"""The parts of the nodes that need no ROS graph."""

import itertools
import time

import pytest

from pneu_rig_ros.nodes.samples import SimulatedTime, TimeSynchronizer
from pneu_rig_ros.nodes.timing import PeriodicTimer, TickErrors
from pneu_rig_ros.nodes.topics import SequenceNumbers


def test_synchronizer_combines_by_stamp_whatever_the_order_of_arrival():
    synchronizer = TimeSynchronizer(3)
    first, second, third = synchronizer.queues
    first.extend([(1, 10.0), (2, 20.0)])
    second.append((1, 11.0))
    assert list(synchronizer.complete()) == []
    third.extend([(1, 12.0), (2, 22.0)])
    assert list(synchronizer.complete()) == [(1, [10.0, 11.0, 12.0])]
    second.append((2, 21.0))
    assert list(synchronizer.complete()) == [(2, [20.0, 21.0, 22.0])]
    assert synchronizer.dropped == 0


@pytest.mark.parametrize('holes', [(1, 5, 6), (3, 3, 3), (2, 4, 9)])
def test_synchronizer_drops_incomplete_stamps_and_goes_on(holes):
    synchronizer = TimeSynchronizer(3)
    for queue, hole in zip(synchronizer.queues, holes, strict=True):
        queue.extend((stamp, float(stamp)) for stamp in range(10) if stamp != hole)
    joined = [stamp for stamp, _ in synchronizer.complete()]
    # Nothing follows stamp 9, so that one whose other parts are missing still waits.
    assert joined == [stamp for stamp in range(10) if stamp not in holes]
    waiting = sum(map(len, synchronizer.queues))
    assert synchronizer.dropped + waiting == 3 * (10 - len(joined)) - 3


@pytest.mark.parametrize('lacking', [(), (0,), (2,), (0, 1)])
@pytest.mark.parametrize('together', [True, False])
def test_synchronizer_follows_stamps_that_jump_back(lacking, together):
    """A killed plant may have sent a part of its last sample only; the next one starts at 0."""
    synchronizer, joined = TimeSynchronizer(3), []
    for stamp in [1000, 1001, 1002, *range(10)]:
        for number, queue in enumerate(synchronizer.queues):
            if stamp != 1002 or number not in lacking:
                queue.append((stamp, 0.0))
        if not together:
            joined += [stamp for stamp, _ in synchronizer.complete()]
    joined += [stamp for stamp, _ in synchronizer.complete()]
    begun = [1000, 1001] if lacking else [1000, 1001, 1002]
    assert joined[: len(begun)] == begun
    assert joined[len(begun) :][-9:] == list(range(1, 10))


def test_simulated_time_gives_the_stamp_of_the_last_sample_before():
    # sent:     100   200   300
    # stamp:     0     7     14
    simulated_time = SimulatedTime()
    for sent, stamp in ((100, 0), (200, 7), (300, 14)):
        simulated_time.add_sample(sent, stamp)
    sent = [50, 100, 150, 199, 200, 299, 300]
    assert [simulated_time.at(t) for t in sent] == [0, 0, 0, 0, 7, 7, 14]
    assert [simulated_time.is_known(t) for t in (50, 300, 301)] == [True, True, False]
    simulated_time.discard_before(250)
    assert [simulated_time.at(t) for t in (250, 299, 300)] == [7, 7, 14]


def test_an_empty_simulated_time_knows_nothing():
    assert not SimulatedTime().is_known(0)
    assert SimulatedTime().at(5) == 0


def test_losses_are_gaps_but_not_restarts_or_pauses():
    numbers = SequenceNumbers()
    for number in (5, 6, 9, 10, 1, 2):
        numbers.add(number)
    assert numbers.lost == 2
    numbers.resume()
    numbers.add(100)
    assert numbers.lost == 2
    assert not numbers.alternating


def test_publishers_that_alternate_lose_nothing():
    numbers = SequenceNumbers()
    for number in range(2000, 3000):
        numbers.add(number)
        if number % 3 == 0:
            numbers.add((number - 2000) // 3 + 1)
    assert numbers.alternating
    assert numbers.lost == 0
    numbers.add(3002)
    assert numbers.lost == 2


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


def test_timer_catches_up_late_ticks_without_skipping():
    period = 2_000_000
    timer = PeriodicTimer(period)
    begin = time.monotonic_ns()
    timer.wait()
    busy_until = time.monotonic_ns() + 10 * period
    while time.monotonic_ns() < busy_until:
        pass
    for _ in range(20):
        timer.wait()
    assert time.monotonic_ns() - begin >= 21 * period
    assert timer.errors.count == 21
    assert timer.errors.late >= 8  # those of the busy time follow at once: a new start has one


def test_timer_never_ticks_early():
    timer = PeriodicTimer(200_000)
    times = []
    for _ in range(50):
        timer.wait()
        times.append(time.monotonic_ns())
    # The deadlines are equally spaced, the first one before the first tick.
    assert all(t >= times[0] - 10**9 for t in times)
    late = [t - i * 200_000 for i, t in enumerate(times)]
    assert min(b - a for a, b in itertools.pairwise(times)) >= 0
    assert min(late) > times[0] - timer.errors.max_ns - 200_000
