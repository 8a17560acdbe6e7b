"""The live page of a rig: HTTP and a WebSocket, for browsers on this computer only."""

import asyncio
import contextlib
import json
import math
import socket
from collections.abc import Awaitable, Callable, Iterator, Mapping
from threading import Thread
from typing import Any, Protocol

from aiohttp import WSMsgType, web

from pneu_rig_ros.errors import RigError
from pneu_rig_ros.web import render

HOST = '127.0.0.1'
"""Never another: any client that reaches the page can move the rig."""

PERIOD = 0.04
"""Time between two batches of samples [s], short enough to look smooth."""

LARGEST_MESSAGE = 1024
"""Longest message that a page may send [byte]."""

FULL_COMMAND = 2.5
"""Command at which the valves saturate [V]."""

ENDING_TIME = 5.0
"""Time that the server has to start or to close its connections [s]."""

Columns = Mapping[str, list[float | None]]


class Stream(Protocol):
    """A stream of rows of values of which the last ones are kept."""

    def since(self, number: int) -> tuple[int, Columns]:
        """Return how many rows there have been, and those kept after the first `number`."""


class Rig(Protocol):
    """A running rig; called from the thread of the server."""

    @property
    def streams(self) -> Mapping[str, Stream]:
        """Name -> stream; each has a column `time` [s]."""

    def state(self) -> Mapping[str, Any]:
        """Return what the page shows besides the streams, as a JSON-compatible dict."""

    def command(self, u: float | None) -> None:
        """Hold the command u [V]; None sets u = 0 and then stops commanding."""

    def set_supply_pressure(self, pressure: float) -> None:
        """Request an absolute supply pressure [Pa]."""

    def reset(self) -> None:
        """Request the initial state."""


@contextlib.contextmanager
def serve(rig: Rig, port: int) -> Iterator[str]:
    """
    Serve the page of a rig while the block runs; yield its address.

    :param port: 0 for any that is free
    :raises RigError: when the port is taken
    """
    try:
        listener = socket.create_server((HOST, port))
    except (OSError, OverflowError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise RigError(f'port {port}: {reason}; choose another with --port') from None
    number = int(listener.getsockname()[1])
    loop = asyncio.new_event_loop()
    thread = Thread(target=loop.run_forever, name='web', daemon=True)
    thread.start()
    runner = web.AppRunner(
        LivePage(rig, number).application(), access_log=None, shutdown_timeout=1.0
    )
    try:
        asyncio.run_coroutine_threadsafe(_start(runner, listener), loop).result(ENDING_TIME)
        yield f'http://{HOST}:{number}/'
    finally:
        asyncio.run_coroutine_threadsafe(runner.cleanup(), loop).result(ENDING_TIME)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


async def _start(runner: web.AppRunner, listener: socket.socket) -> None:
    await runner.setup()
    await web.SockSite(runner, listener).start()


class LivePage:
    """
    The page and its WebSocket.

    A page of another site could otherwise command the rig through the user's browser. So a
    request with another Origin than this page, or another Host than this computer, is refused.
    """

    def __init__(self, rig: Rig, port: int) -> None:
        self._rig = rig
        self._hosts = {f'{name}:{port}' for name in (HOST, 'localhost')}
        self._origins = {f'http://{host}' for host in self._hosts}
        self._sockets: set[web.WebSocketResponse] = set()
        self._commander: web.WebSocketResponse | None = None

    def application(self) -> web.Application:
        """Return the web application."""
        application = web.Application(middlewares=[self._only_local])
        application.add_routes([web.get('/', self._page), web.get('/socket', self._socket)])
        application.on_shutdown.append(self._close)
        return application

    @web.middleware
    async def _only_local(
        self,
        request: web.Request,
        handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    ) -> web.StreamResponse:
        if request.host not in self._hosts:
            raise web.HTTPForbidden(text=f'host {request.host} is not this computer\n')
        return await handler(request)

    async def _page(self, _: web.Request) -> web.Response:
        limits = {'full_command': FULL_COMMAND}
        sockets = sorted(f'ws://{host}' for host in self._hosts)
        text = render('live.html', limits, sockets=sockets, **limits)
        headers = {'Cache-Control': 'no-store', 'X-Frame-Options': 'DENY'}
        return web.Response(text=text, content_type='text/html', headers=headers)

    async def _socket(self, request: web.Request) -> web.WebSocketResponse:
        origin = request.headers.get('Origin')
        if origin not in self._origins:
            raise web.HTTPForbidden(text=f'origin {origin} is not this page\n')
        # No compression: nothing leaves this computer, and a frame that is being compressed would
        # outlive its sender.
        connection = web.WebSocketResponse(
            heartbeat=10.0, compress=False, max_msg_size=LARGEST_MESSAGE
        )
        await connection.prepare(request)
        self._sockets.add(connection)
        sender = asyncio.create_task(self._send(connection))
        try:
            async for message in connection:
                if message.type is not WSMsgType.TEXT:
                    continue
                try:
                    self._execute(connection, message.data)
                except RigError as error:
                    await connection.send_str(json.dumps({'error': str(error)}))
        finally:
            sender.cancel()
            self._sockets.discard(connection)
            if self._commander is connection:  # a closed page commands no longer
                self._commander = None
                self._rig.command(None)
        return connection

    async def _send(self, connection: web.WebSocketResponse) -> None:
        """Send new samples periodically; a slow browser gets fewer and larger batches."""
        seen = dict.fromkeys(self._rig.streams, 0)
        with contextlib.suppress(ConnectionError):
            while True:
                batch: dict[str, Any] = {'state': self._rig.state()}
                for name, stream in self._rig.streams.items():
                    seen[name], batch[name] = stream.since(seen[name])
                await connection.send_str(json.dumps(batch, allow_nan=False))
                await asyncio.sleep(PERIOD)

    def _execute(self, connection: web.WebSocketResponse, text: str) -> None:
        """Execute a message such as {"u": 0.34}; RigError if it is not valid."""
        try:
            data = json.loads(text)
        except ValueError:
            raise RigError('a message must be JSON') from None
        if not isinstance(data, dict) or len(data) != 1:
            raise RigError('a message must be one name with its value')
        ((name, value),) = data.items()
        if name == 'u':
            u = None if value is None else _number(value, 'u')
            if u is not None and abs(u) > FULL_COMMAND:
                raise RigError(f'u {u:g} V: allowed are {-FULL_COMMAND:g} to {FULL_COMMAND:g} V')
            self._commander = None if u is None else connection
            self._rig.command(u)
        elif name == 'supply_pressure':
            self._rig.set_supply_pressure(_number(value, name))
        elif name == 'reset':
            self._rig.reset()
        else:
            raise RigError(f'{name!r}: allowed are u, supply_pressure, reset')

    async def _close(self, _: web.Application) -> None:
        for connection in list(self._sockets):
            await connection.close(code=1001, message=b'the live view has ended')


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise RigError(f'{name}: {value!r} is not a finite number')
    return float(value)
