"""The live page, in a browser: a running rig is shown, moves with the slider, and is let go."""

import http.client
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pneu_rig_ros.cli import main
from pneu_rig_ros.records.cdr_decoding import unpack_float64, unpack_joint_state, unpack_string
from pneu_rig_ros.records.cdr_encoding import pack_float64
from pneu_rig_ros.rig import Rig, configuration_from_yaml, load_configuration

from .bystander import DOMAIN, PATIENCE, Bystander, until

pytestmark = pytest.mark.live

CURVE = """
index => {
  const { ctx, bbox } = stack.charts[index];
  const { data } = ctx.getImageData(bbox.left, bbox.top, bbox.width, bbox.height);
  for (let k = 0; k < data.length; k += 4) {
    const [r, g, b] = data.subarray(k, k + 3);
    if (Math.abs(r - 31) + Math.abs(g - 90) + Math.abs(b - 148) < 40) return true;
  }
  return false;
}
"""
"""Whether the first curve of a chart is on the screen."""


class LiveRig:
    """`pneu-rig live --start` as its user runs it."""

    def __init__(self) -> None:
        command = [sys.executable, '-m', 'pneu_rig_ros.cli', 'live', '--port', '0']
        self.process = subprocess.Popen(
            [*command, '--start', 'cylinder_2'],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().split(' ')[0]

    @property
    def port(self) -> int:
        return int(self.address.rstrip('/').rsplit(':', 1)[1])

    def stop(self) -> str:
        """End it as an impatient user does; return what it had to say."""
        self.process.send_signal(signal.SIGINT)
        self.process.send_signal(signal.SIGINT)
        _, errors = self.process.communicate(timeout=30)
        return errors


@pytest.fixture(scope='module')
def rig() -> Iterator[LiveRig]:
    """Run a rig and its live page."""
    # The first step after a change compiles the model, which may take longer than PATIENCE.
    Rig(load_configuration('cylinder_2')).step(2.5, 2.5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.setenv('ROS_DOMAIN_ID', str(DOMAIN))
        live = LiveRig()
    yield live
    live.process.kill()
    live.process.communicate()


@pytest.fixture
def page(rig: LiveRig, open_page: Callable[[str], Any]) -> Any:
    """Open the page and wait for samples."""
    page = open_page(rig.address)
    shows(page, "element('state').classList.contains('good')")
    return page


def shows(page: Any, condition: str) -> None:
    """Wait for an expression to hold in a page, which works in between."""
    deadline = time.monotonic() + PATIENCE
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, f'not within {PATIENCE} s: {condition}'
        page.wait_for_timeout(50)


def value(name: str) -> str:
    """Return the expression of a value in the table beside the cylinder."""
    return f"Number(document.querySelector('[data-reading={name}]').textContent)"


def reading(page: Any, name: str) -> float:
    return page.evaluate(value(name))


def slide(page: Any, name: str, value: float) -> None:
    page.locator(f'#{name}').fill(f'{value:g}')


def newest(subscription: Any, decode: Callable[[bytes], Any]) -> Any:
    """Return what the newest of the waiting messages says, None if there is none."""
    messages = [decode(cdr) for cdr in subscription.take_all()]
    return messages[-1] if messages else None


def test_slider_moves_u_on_the_topic_and_the_piston(page: Any, bystander: Bystander) -> None:
    commands, samples = bystander.hear('u'), bystander.hear('joint_states')
    until(lambda: newest(samples, unpack_joint_state))
    assert commands.take() is None, 'published before the first command'
    before = reading(page, 'position')
    slide(page, 'u', 1.2)
    until(lambda: newest(commands, unpack_float64) == 1.2)
    until(lambda: (s := newest(samples, unpack_joint_state)) and s.position > 0.03 + before / 1e3)
    shows(page, f'{value("position")} > {before + 30.0}')
    shows(page, "document.querySelector('svg.cylinder g').dataset.position > 30")
    assert reading(page, 'u') == 1.2
    assert reading(page, 'voltage_1') == pytest.approx(3.7, abs=2e-3)
    assert page.locator('#u-text').inner_text() == '1.20 V'
    for chart in range(5):
        shows(page, f'({CURVE})({chart})')


def test_let_go_shuts_the_valves_and_leaves_u_to_others(page: Any, bystander: Bystander) -> None:
    commands = bystander.hear('u')
    slide(page, 'u', 0.5)
    until(lambda: newest(commands, unpack_float64) == 0.5)
    page.click('#leave')
    until(lambda: newest(commands, unpack_float64) == 0.0)
    shows(page, "element('u-text').textContent === 'not held'")
    list(commands.take_all())
    bystander.speak('u', 2)(pack_float64(0.1))
    after = page.evaluate('newest')
    shows(page, f'newest > {after} + 0.5')  # in which 25 commands would have come
    assert [unpack_float64(cdr) for cdr in commands.take_all()] == [0.1]
    shows(page, f'{value("u")} === 0.1')


def test_closed_page_lets_go(page: Any, bystander: Bystander) -> None:
    commands = bystander.hear('u')
    slide(page, 'u', -0.5)
    until(lambda: newest(commands, unpack_float64) == -0.5)
    page.close()
    until(lambda: newest(commands, unpack_float64) == 0.0)


def test_supply_slider_changes_the_plant(page: Any, bystander: Bystander) -> None:
    descriptions = bystander.hear('rig_description')
    shows(page, "!element('supply').disabled")
    for pressure in (6.5, 5.0):
        slide(page, 'supply', pressure)
        assert page.locator('#supply-text').inner_text() == f'{pressure:.2f} bar'

        def described(pressure: float = pressure) -> bool:
            text = newest(descriptions, unpack_string)
            known = text and configuration_from_yaml(text, 'test').model.operation.supply_pressure
            return known == pytest.approx(1e5 * pressure)

        until(described)
        supply = f'supply {pressure:.2f} bar abs'
        shows(page, f"element('facts').textContent.includes('{supply}')")


def test_zoom_freezes_and_double_click_goes_on(page: Any) -> None:
    shows(page, 'newest > 4')
    start = page.evaluate('newest')
    shows(page, f'newest > {start} + 0.5')
    box = page.locator('.u-over').nth(0).bounding_box()
    y = box['y'] + 30
    page.mouse.move(box['x'] + 0.6 * box['width'], y)
    page.mouse.down()
    page.mouse.move(box['x'] + 0.9 * box['width'], y, steps=3)
    page.mouse.up()
    frozen = page.evaluate('stack.range')
    assert frozen[1] - frozen[0] == pytest.approx(3.0, abs=0.05)
    assert page.locator('#freeze').inner_text() == 'Go on'
    later = page.evaluate('newest')
    shows(page, f'newest > {later} + 0.3')
    assert page.evaluate('stack.range') == frozen
    page.locator('.u-over').nth(0).dblclick()
    shows(page, 'stack.range[1] >= newest - 0.1')
    assert page.locator('#freeze').inner_text() == 'Freeze'


def test_reset_takes_the_piston_back(page: Any) -> None:
    start = 1e3 * load_configuration('cylinder_2').model.operation.initial_position
    slide(page, 'u', 1.0)
    shows(page, f'{value("position")} > {start + 20.0}')
    page.click('#shut')
    page.click('#reset')
    # 2 mm are more than the sensor is off
    shows(page, f'Math.abs({value("position")} - {start}) < 2')


def status(rig: LiveRig, path: str, **headers: str) -> int:
    connection = http.client.HTTPConnection('127.0.0.1', rig.port, timeout=10)
    connection.request('GET', path, headers=headers)
    return connection.getresponse().status


HANDSHAKE = {
    'Connection': 'Upgrade',
    'Upgrade': 'websocket',
    'Sec-WebSocket-Version': '13',
    'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==',
}


def test_only_the_page_itself_may_connect(rig: LiveRig) -> None:
    own = f'http://127.0.0.1:{rig.port}'
    assert status(rig, '/socket', **HANDSHAKE, Origin=own) == 101
    assert status(rig, '/socket', **HANDSHAKE) == 403
    for foreign in ('https://evil.example', 'null', 'http://127.0.0.1:1', f'{own}.evil.example'):
        assert status(rig, '/socket', **HANDSHAKE, Origin=foreign) == 403
    assert status(rig, '/') == 200
    # a name of another site that was made to point here
    assert status(rig, '/', Host=f'evil.example:{rig.port}') == 403
    with pytest.raises(OSError, match='refused'):
        socket.create_connection(('127.0.0.2', rig.port), timeout=10)


def test_page_in_a_port_that_is_taken_is_refused_in_one_line(
    rig: LiveRig, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(['live', '--port', str(rig.port)]) == 2
    told = [line for line in capfd.readouterr().err.splitlines() if 'error' in line]
    assert len(told) == 1
    assert f'port {rig.port}' in told[0]


def test_namespace_that_is_none_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(['live', '--namespace', 'a b']) == 2
    assert "namespace 'a b'" in capfd.readouterr().err


def test_ctrl_c_ends_page_and_nodes(rig: LiveRig, bystander: Bystander) -> None:
    samples = bystander.hear('joint_states')
    until(samples.take)
    errors = rig.stop()
    assert rig.process.returncode == 0, errors
    assert 'Traceback' not in errors
    with pytest.raises(OSError, match='refused'):
        socket.create_connection(('127.0.0.1', rig.port), timeout=10)
    until(lambda: bystander.count_publishers('/joint_states') == 0)
