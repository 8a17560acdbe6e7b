"""The WebSocket of the live page: what it takes, what it refuses, what a page gets."""

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import aiohttp
import pytest

from pneu_rig_ros.nodes.embedding import embedded
from pneu_rig_ros.nodes.live import History, LiveNode
from pneu_rig_ros.web.server import serve

pytestmark = pytest.mark.live


@pytest.mark.parametrize(
    ('message', 'told'),
    [
        ('junk', 'must be JSON'),
        ('[1]', 'one name with its value'),
        ('{"u": 2.6}', 'allowed are -2.5 to 2.5 V'),
        ('{"u": "fast"}', "'fast' is not a finite number"),
        ('{"u": NaN}', 'not a finite number'),
        ('{"u": true}', 'not a finite number'),
        ('{"supply_pressure": null}', 'not a finite number'),
        ('{"fly": 1}', "'fly': allowed are u, supply_pressure, reset"),
    ],
)
def test_wrong_commands_are_told_and_not_obeyed(node_page: str, message: str, told: str) -> None:
    answer, state = asyncio.run(ask(node_page, message, lambda m: 'error' in m))
    assert told in answer['error']
    assert state['held'] is None


def test_rig_without_a_plant_says_so(node_page: str) -> None:
    message = '{"supply_pressure": 6e5}'
    answer, _ = asyncio.run(ask(node_page, message, lambda m: m.get('state', {}).get('message')))
    assert 'not available' in answer['state']['message']
    assert answer['samples']['time'] == []


@pytest.fixture(scope='module')
def node_page() -> Iterator[str]:
    """Serve the page of a live node where no rig runs; yield its address."""
    ended = threading.Event()
    with embedded(LiveNode, 'nobody') as (node, run), serve(node, 0) as address:
        loop = threading.Thread(target=run, args=(lambda: not ended.is_set(),))
        loop.start()
        yield address
        ended.set()
        loop.join()


async def ask(
    address: str, message: str, wanted: Callable[[dict[str, Any]], Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Send a message; return the first answer that is wanted, and the state after it."""
    origin = address.rstrip('/')
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f'{address}socket', origin=origin) as connection,
    ):
        await connection.send_str(message)
        answer: dict[str, Any] = {}
        deadline = time.monotonic() + 20.0
        while not wanted(answer):
            assert time.monotonic() < deadline
            answer = json.loads((await connection.receive(10.0)).data)
        after: dict[str, Any] = {}
        while 'state' not in after:
            after = json.loads((await connection.receive(10.0)).data)
        return answer, after['state']


def test_history_gives_each_row_once_and_forgets_the_oldest() -> None:
    history = History(('time', 'value'), 3)
    assert history.since(0) == (0, {'time': [], 'value': []})
    history.extend([(0.0, 1.0), (1.0, None)])
    assert history.since(0) == (2, {'time': [0.0, 1.0], 'value': [1.0, None]})
    assert history.since(1) == (2, {'time': [1.0], 'value': [None]})
    history.extend([(2.0, 2.0), (3.0, 3.0)])
    assert history.since(0) == (4, {'time': [1.0, 2.0, 3.0], 'value': [None, 2.0, 3.0]})
    assert history.since(4) == (4, {'time': [], 'value': []})
