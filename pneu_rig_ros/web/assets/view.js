// The page of one bag: charts, the cylinder at the cursor's time, the cycles.
'use strict';

const bag = JSON.parse(document.getElementById('data').textContent);
const signals = Object.fromEntries(Object.entries(bag.signals).map(([name, text]) => [name, decoded(text)]));
const time = Float64Array.from(signals.position, (_, k) => k * bag.step);

/** Return the little-endian 32-bit floats of a base64 text. */
function decoded(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float64Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
}

/** Return the index of the sample at a time [s]. */
function indexAt(t) {
  return Math.min(Math.max(Math.round(t / bag.step), 0), time.length - 1);
}

// --- charts ---

const PANELS = [
  { title: 'position [mm]', least: 1, lines: [['position', 'x [mm]', BLUE, 1e3, 2]] },
  { title: 'velocity [mm/s]', least: 4, lines: [
    ['velocity', 'v of the rig [mm/s]', '#a9c3dc', 1e3, 1], ['velocity_fit', 'v over 46 ms [mm/s]', BLUE, 1e3, 1]] },
  { title: 'pressure [bar abs]', least: 0.05, lines: [
    ['pressure_1', 'p₁ [bar]', BLUE, 1e-5, 3], ['pressure_2', 'p₂ [bar]', ORANGE, 1e-5, 3]] },
  { title: 'friction [N]', least: 2, lines: [['friction', 'F_r [N]', BLUE, 1, 2]] },
  { title: 'valves [V]', least: 0.1, lines: [
    ['voltage_1', 'u₁ [V]', BLUE, 1, 3], ['voltage_2', 'u₂ [V]', ORANGE, 1, 3]] },
].map((panel) => ({ ...panel, lines: panel.lines.filter(([name]) => name in signals) }))
  .filter((panel) => panel.lines.length);

const stack = new ChartStack(document.getElementById('charts'), PANELS, {
  onCursor: showAt, onZoom: told, beneath: drawModes, above: drawBreakaways,
});

function told(from, to) {
  document.getElementById('range').textContent = `${from.toFixed(2)} to ${to.toFixed(2)} s`;
}

/** Draw the regimes of motion as a strip along the top of a chart. */
function drawModes(chart) {
  const { ctx } = chart;
  const { left, top, width } = chart.bbox;
  const height = 5 * devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  bag.regimes.forEach(([start, regime], k) => {
    const from = chart.valToPos(start, 'x', true);
    const to = chart.valToPos(bag.regimes[k + 1]?.[0] ?? bag.duration, 'x', true);
    if (to < left || from > left + width) return;
    ctx.fillStyle = REGIME_COLOURS[regime];
    ctx.fillRect(from, top, Math.max(to - from, 1), height);
  });
  ctx.restore();
}

/** Draw a line at each breakaway, its number on the first chart and its peak on that of friction. */
function drawBreakaways(chart, index) {
  const { ctx } = chart;
  const { left, top, width, height } = chart.bbox;
  const dot = devicePixelRatio;
  ctx.save();
  ctx.fillStyle = ctx.strokeStyle = REGIME_COLOURS[2];
  ctx.lineWidth = dot;
  ctx.font = `${11 * dot}px system-ui, "Liberation Sans", sans-serif`;
  let free = -Infinity;
  bag.cycles.forEach(({ breakaway_time: at, peak_friction: peak }, k) => {
    const x = chart.valToPos(at, 'x', true);
    if (x < left || x > left + width) return;
    ctx.globalAlpha = 0.35;
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + height);
    ctx.stroke();
    ctx.globalAlpha = 1;
    if (index === 0 && x > free) {
      ctx.fillText(k + 1, x + 3 * dot, top + 17 * dot);
      free = x + 22 * dot;
    }
    if (PANELS[index].lines[0][0] === 'friction' && peak != null) triangle(ctx, x, chart.valToPos(peak, 'y', true), dot);
  });
  ctx.restore();
}

function triangle(ctx, x, y, dot) {
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x - 4 * dot, y - 7 * dot);
  ctx.lineTo(x + 4 * dot, y - 7 * dot);
  ctx.fill();
}

// --- the cylinder and the values at the cursor ---

const REGIME_COLOURS = ['dwell', 'presliding', 'breakaway', 'sliding', 'end-stop'].map(
  (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
const drawing = bag.rig && new CylinderDrawing(document.querySelector('svg.cylinder'), bag.rig);
const swatch = Object.assign(document.createElement('span'), { className: 'swatch' });
const readings = new Readings(document.getElementById('readings'), [
  'time', 'position', 'velocity', 'pressure_1', 'pressure_2',
  ...['friction', 'voltage_1', 'voltage_2'].filter((name) => name in signals)]);

function showAt(t) {
  const k = indexAt(t);
  const values = Object.fromEntries(Object.entries(signals).map(([name, column]) => [name, column[k]]));
  drawing?.show(values);
  readings.show({ ...values, velocity: values.velocity_fit, time: t });
  document.getElementById('slider').value = t;
  const regime = regimeAt(t);
  swatch.style.background = REGIME_COLOURS[regime];
  document.getElementById('regime').replaceChildren(...(regime == null ? [] : [swatch, bag.regime_names[regime]]));
  markNear(t);
}

function regimeAt(t) {
  let regime = null;
  for (const [start, number] of bag.regimes) {
    if (start > t) break;
    regime = number;
  }
  return regime;
}

// --- the cycles ---

const rows = bag.cycles.map((cycle, k) => {
  const row = document.querySelector('.events tbody').insertRow();
  const numbers = [k + 1, cycle.breakaway_time.toFixed(3), cycle.dwell.toFixed(3), (1e3 * cycle.slip).toFixed(2),
    cycle.peak_friction == null ? '–' : cycle.peak_friction.toFixed(2)];
  for (const text of numbers) {
    const cell = row.insertCell();
    cell.className = 'number';
    cell.textContent = text;
  }
  row.tabIndex = 0;
  const go = () => { approach(cycle); };
  row.addEventListener('click', go);
  row.addEventListener('keydown', (event) => { if (event.key === 'Enter') go(); });
  return row;
});

/** Zoom to a cycle. */
function approach({ breakaway_time: at, dwell }) {
  const before = Math.max(0.25, 0.4 * dwell);
  stack.zoom(at - before, at + before);
  stack.cursorTo(at);
}

/** Mark the row of the cycle that a time belongs to: the last breakaway before it. */
function markNear(t) {
  const last = bag.cycles.findLastIndex((cycle) => cycle.breakaway_time <= t + 1e-9);
  rows.forEach((row, k) => row.classList.toggle('near', k === last));
}

// --- playing, keys ---

let playing = null; // the handle of the next frame
const play = document.getElementById('play');

function startOrStop() {
  if (playing !== null) return stop();
  play.textContent = 'Stop';
  const [from, to] = stack.range;
  if (stack.time < from || stack.time >= to - bag.step) stack.cursorTo(from);
  let before = performance.now();
  const frame = (now) => {
    const speed = Number(document.getElementById('speed').value);
    const next = stack.time + ((now - before) * speed) / 1000;
    before = now;
    stack.cursorTo(Math.min(next, to));
    if (next >= to) stop();
    else playing = requestAnimationFrame(frame);
  };
  playing = requestAnimationFrame(frame);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = null;
  play.textContent = 'Play';
}

play.addEventListener('click', startOrStop);
document.getElementById('whole').addEventListener('click', () => stack.reset());
document.getElementById('slider').addEventListener('input', (event) => stack.cursorTo(Number(event.target.value)));
document.addEventListener('keydown', (event) => {
  if (event.target.closest('input, select, button, tr') || event.ctrlKey || event.metaKey || event.altKey) return;
  const [from, to] = stack.range;
  const actions = {
    ' ': startOrStop,
    ArrowLeft: () => stack.cursorTo(stack.time - bag.step),
    ArrowRight: () => stack.cursorTo(stack.time + bag.step),
    '+': () => stack.zoom(stack.time - (stack.time - from) / 2, stack.time + (to - stack.time) / 2),
    '-': () => stack.zoom(from - (to - from) / 2, to + (to - from) / 2),
    0: () => stack.reset(),
  };
  if (event.key in actions) {
    event.preventDefault();
    actions[event.key]();
  }
});

stack.setData(
  PANELS.map(({ lines }) => [time, ...lines.map(([name, , , scale]) => signals[name].map((value) => scale * value))]),
  0, bag.duration);
stack.reset();
stack.cursorTo(bag.cycles[0]?.breakaway_time ?? 0);
