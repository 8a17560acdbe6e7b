"""The WebSocket of the live page: what it takes, what it refuses, what a page gets."""

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import aiohttp
import pytest
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor

from pneu_rig_ros.nodes.embedding import embedded
from pneu_rig_ros.nodes.live import History, LiveNode
from pneu_rig_ros.records.cdr_encoding import pack_string
from pneu_rig_ros.records.description import describe
from pneu_rig_ros.rig import load_configuration
from pneu_rig_ros.web.server import serve

from .bystander import Bystander, until

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


MARKUP = '</script><img src=x onerror=alert(1)><b>$&</b>'


def test_names_and_reasons_from_topics_and_services_are_text(
    bystander: Bystander, open_page: Callable[[str], Any]
) -> None:
    def refuse(_: object, response: SetParameters.Response) -> SetParameters.Response:
        response.results = [SetParametersResult(reason=MARKUP)]
        return response

    bystander.create_service(SetParameters, 'plant/set_parameters', refuse)
    executor = SingleThreadedExecutor(context=bystander.context)
    executor.add_node(bystander)
    with served() as address:
        rig = replace(load_configuration('cylinder_2'), name=MARKUP)
        bystander.speak('rig_description')(pack_string(describe(rig)))
        page = open_page(address)

        def shows(name: str, text: str) -> bool:
            executor.spin_once(timeout_sec=0.05)
            page.wait_for_timeout(50)
            return text in page.locator(f'#{name}').inner_text()

        until(lambda: shows('name', MARKUP) and page.locator('#supply').is_enabled())
        page.locator('#supply').fill('5')
        until(lambda: shows('notice', MARKUP))
        assert page.locator('b, img').count() == 0
        page.close()
    executor.shutdown()


@pytest.fixture(scope='module')
def node_page() -> Iterator[str]:
    """Serve the page of a live node where no rig runs; yield its address."""
    with served('nobody') as address:
        yield address


@contextmanager
def served(namespace: str = '') -> Iterator[str]:
    """Serve the page of a live node; yield its address."""
    ended = threading.Event()
    with embedded(LiveNode, namespace) as (node, run), serve(node, 0) as address:
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
