// The page of a running rig: samples in by a WebSocket, commands out.
'use strict';

const KEPT = 60; // s
const PANELS = [
  { stream: 'samples', title: 'position [mm]', least: 2, lines: [['position', 'x [mm]', BLUE, 1e3, 2]] },
  { stream: 'samples', title: 'velocity [mm/s]', least: 20, lines: [['velocity', 'v of the rig [mm/s]', BLUE, 1e3, 1]] },
  { stream: 'samples', title: 'pressure [bar abs]', least: 0.1, lines: [
    ['pressure_1', 'p₁ [bar]', BLUE, 1e-5, 3], ['pressure_2', 'p₂ [bar]', ORANGE, 1e-5, 3]] },
  { stream: 'friction', title: 'friction [N]', least: 10, lines: [['friction', 'F_r [N]', BLUE, 1, 2]] },
  { stream: 'samples', title: 'valves [V]', least: 0.2, lines: [
    ['voltage_1', 'u₁ [V]', BLUE, 1, 3], ['voltage_2', 'u₂ [V]', ORANGE, 1, 3]] },
];
const limits = JSON.parse(document.getElementById('data').textContent);
const element = (id) => document.getElementById(id);

// --- what has come: a column for each line, in its own unit, and the time ---

const stores = PANELS.map(({ lines }) => [[], ...lines.map(() => [])]);
let latest = {}; // newest values, SI units
let state = {};
let newest = 0;

function take(batch) {
  state = batch.state;
  if (batch.samples.time.length && batch.samples.time.at(-1) < newest) forget();
  PANELS.forEach(({ stream, lines }, index) => {
    const columns = batch[stream];
    const [time, ...values] = stores[index];
    append(time, columns.time, 1);
    lines.forEach(([name, , , scale], k) => append(values[k], columns[name], scale));
    const old = time.findIndex((t) => t >= time.at(-1) - KEPT);
    // Cutting moves all that is kept, so it is done seldom.
    if (old > time.length / 8) stores[index].forEach((column) => column.splice(0, old));
  });
  for (const columns of [batch.samples, batch.friction]) {
    for (const [name, column] of Object.entries(columns)) if (column.length) latest[name] = column.at(-1);
  }
  newest = batch.samples.time.at(-1) ?? newest;
  latest.time = newest;
}

function append(column, values, scale) {
  for (const value of values) column.push(value == null ? null : scale * value);
}

/** Begin anew, as the rig does. */
function forget() {
  for (const store of stores) for (const column of store) column.length = 0;
  latest = {};
  newest = 0;
}

// --- charts ---

let frozen = false;
const stack = new ChartStack(element('charts'), PANELS, {
  onZoom: () => freeze(true), onGrab: () => freeze(true), onReset: () => freeze(false),
});

/** Hold the charts still, or let them run on. What is held still is a copy: more comes all the while. */
function freeze(wanted) {
  if (wanted && !frozen) stack.setData(stores.map((store) => store.map((column) => column.slice())), ...stack.whole);
  frozen = wanted;
  element('freeze').textContent = frozen ? 'Go on' : 'Freeze';
  tellRange();
}

function tellRange() {
  const [from, to] = stack.range;
  element('range').textContent = frozen ? `frozen: ${from.toFixed(2)} to ${to.toFixed(2)} s` : `${newest.toFixed(1)} s`;
}

let drawn = true; // whether what has come is on the screen

function draw() {
  drawn = true;
  if (!frozen) {
    const span = Number(element('window').value);
    const to = Math.max(newest, span);
    stack.setData(stores, stores[0][0][0] ?? 0, to);
    stack.time = newest;
    stack.show(to - span, to);
    tellRange();
  }
  showState();
}

// --- the cylinder, values and state ---

const readings = new Readings(element('readings'), [
  'time', 'position', 'velocity', 'pressure_1', 'pressure_2', 'friction', 'u', 'voltage_1', 'voltage_2']);
let drawing = null;
let drawnRig = '';

function showState() {
  const { rig, rate, message, held, changeable } = state;
  const key = JSON.stringify(rig);
  if (rig && key !== drawnRig) {
    drawing = new CylinderDrawing(document.querySelector('svg.cylinder'), rig);
    drawnRig = key;
    element('name').textContent = rig.name.replaceAll('_', ' ');
    const supply = rig.supply_pressure / 1e5;
    element('facts').textContent = `supply ${supply.toFixed(2)} bar abs · load ${rig.load_mass} kg · stroke ${1000 * rig.stroke} mm`;
    follow(rig);
  }
  drawing?.show(latest);
  readings.show(latest);
  if (rate > 0) pill(`${rate.toFixed(0)} samples/s`, 'good');
  else if (newest > 0) pill('no samples any more', 'bad');
  else pill('waiting for samples', '');
  if (message !== undefined && message !== shown) {
    say((shown = message));
    if (rig) follow(rig);
  }
  element('leave').disabled = held == null;
  element('reset').disabled = element('supply').disabled = !changeable;
  element('u-text').textContent = held == null ? 'not held' : `${held.toFixed(2)} V`;
}

let shown = '';

function say(text) {
  element('notice').textContent = text;
}

function pill(text, kind) {
  element('state').textContent = text;
  element('state').className = `state ${kind}`;
}

// --- commands ---

let socket = null;

function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function command(u) {
  if (!Number.isFinite(u)) return;
  const within = Math.min(Math.max(u, -limits.full_command), limits.full_command);
  element('u').value = within;
  element('u-number').value = within.toFixed(2);
  say('');
  send({ u: within });
}

/** Show the supply pressure that the plant has, unless it is just being changed. */
function follow(rig) {
  const slider = element('supply');
  const [low, high] = state.supply_limits;
  slider.min = (low / 1e5).toFixed(2);
  slider.max = (high / 1e5).toFixed(2);
  if (document.activeElement !== slider || !slider.dataset.moving) slider.value = rig.supply_pressure / 1e5;
  tellSupply();
}

function tellSupply() {
  element('supply-text').textContent = `${Number(element('supply').value).toFixed(2)} bar`;
}

element('u').addEventListener('input', (event) => command(event.target.valueAsNumber));
element('u-number').addEventListener('change', (event) => command(event.target.valueAsNumber));
element('shut').addEventListener('click', () => command(0));
element('leave').addEventListener('click', () => { command(0); send({ u: null }); });
element('supply').addEventListener('input', (event) => { event.target.dataset.moving = 'yes'; tellSupply(); });
element('supply').addEventListener('change', (event) => {
  delete event.target.dataset.moving;
  say('');
  send({ supply_pressure: 1e5 * event.target.valueAsNumber });
});
element('reset').addEventListener('click', () => send({ reset: true }));
element('freeze').addEventListener('click', () => freeze(!frozen));
element('window').addEventListener('change', () => freeze(false));

// --- the connection ---

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.addEventListener('message', ({ data }) => {
    const message = JSON.parse(data);
    if ('error' in message) return say(message.error);
    take(message);
    if (drawn) requestAnimationFrame(draw);
    drawn = false;
  });
  socket.addEventListener('open', forget);
  socket.addEventListener('close', () => {
    pill('no connection', 'bad');
    element('u-text').textContent = 'not held';
    setTimeout(connect, 1000);
  });
}

connect();
