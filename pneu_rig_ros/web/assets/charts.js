// Charts stacked over one time axis: one cursor, one zoom, y axes that fit what is in view.
'use strict';

const CHART_HEIGHT = 128;
const AXIS_WIDTH = 58;
const PAD = 0.1; // of the span of the y axis
const ZOOM_STEP = 1.25;
const LEAST_SPAN = 0.01; // s
const BLUE = '#1f5a94';
const ORANGE = '#b65408';

class ChartStack {
  /**
   * @param root     element to fill
   * @param panels   [{ title, least, lines: [[name, label, colour, scale, digits]] }]; `least` is the
   *                 smallest span of the y axis, so that noise alone does not fill a chart
   * @param options  onCursor(time [s]), onZoom(from, to [s]), onGrab(), onReset(), beneath(chart, index),
   *                 above(chart, index): drawn before and after the curves
   */
  constructor(root, panels, options = {}) {
    this.options = options;
    this.whole = [0, 1];
    this.range = [0, 1];
    this.time = 0;
    this.charts = panels.map((panel, index) => this._chart(root, panel, index, panels.length));
    new ResizeObserver(() => this._fit(root)).observe(root);
  }

  /** Set the columns of each panel, [time, series ...], and the time that the whole covers. */
  setData(columns, from, to) {
    this.whole = [from, to];
    this.charts.forEach((chart, index) => chart.setData(columns[index], false));
  }

  /** Show from .. to [s], moved into what there is. */
  zoom(from, to) {
    const [first, last] = this.whole;
    const span = Math.min(Math.max(to - from, LEAST_SPAN), last - first);
    const start = Math.min(Math.max(from, first), last - span);
    this.show(start, start + span);
    this.options.onZoom?.(...this.range);
  }

  /** Show from .. to [s] as it is. */
  show(from, to) {
    this.range = [from, to];
    for (const chart of this.charts) chart.setScale('x', { min: from, max: to });
    queueMicrotask(() => this._place()); // the charts take over their scales in a microtask too
  }

  reset() {
    this.zoom(...this.whole);
    this.options.onReset?.();
  }

  /** Move the cursor of all charts to a time [s]. */
  cursorTo(time) {
    this.time = Math.min(Math.max(time, this.whole[0]), this.whole[1]);
    this._place();
    this.options.onCursor?.(this.time);
  }

  _place() {
    const [from, to] = this.range;
    for (const chart of this.charts) {
      const seen = this.time >= from && this.time <= to;
      chart.setCursor({ left: seen ? chart.valToPos(this.time, 'x') : -10, top: 0 }, false);
    }
  }

  _chart(root, panel, index, count) {
    const box = root.appendChild(document.createElement('div'));
    box.className = 'chart';
    const last = index === count - 1;
    const grid = { stroke: '#e4e6ea', width: 1 };
    const ticks = { stroke: '#c9ced8', size: 4 };
    const font = '12px system-ui, "Liberation Sans", sans-serif';
    const options = {
      width: Math.max(root.clientWidth, 200),
      height: CHART_HEIGHT + (last ? 36 : 0),
      scales: {
        x: { time: false },
        y: { range: (_, low, high) => padded(low, high, panel.least) },
      },
      series: [
        {},
        ...panel.lines.map(([, label, stroke, , digits]) => ({
          label,
          stroke,
          width: 1.25,
          points: { show: false },
          value: (_, value) => (value == null ? '–' : value.toFixed(digits)),
        })),
      ],
      axes: [
        {
          size: last ? 28 : 8, grid, ticks: last ? ticks : { show: false }, font, stroke: '#3c4048',
          label: last ? 'time [s]' : undefined, labelSize: 18, labelFont: font,
          values: last ? undefined : (_, splits) => splits.map(() => ''),
        },
        { size: AXIS_WIDTH, grid, ticks, font, stroke: '#3c4048', label: panel.title, labelSize: 18, labelFont: font },
      ],
      cursor: {
        y: false,
        drag: { x: true, y: false, setScale: false },
        bind: { mouseleave: () => null, dblclick: () => () => { this.reset(); } },
      },
      hooks: {
        setSelect: [(chart) => this._selected(chart)],
        drawClear: [(chart) => this.options.beneath?.(chart, index)],
        draw: [(chart) => this.options.above?.(chart, index)],
      },
    };
    const empty = [[], ...panel.lines.map(() => [])];
    const chart = new uPlot(options, empty, box);
    chart.over.addEventListener('mousedown', () => this.options.onGrab?.());
    chart.over.addEventListener('mousemove', (event) => this.cursorTo(chart.posToVal(event.offsetX, 'x')));
    chart.over.addEventListener('wheel', (event) => this._wheel(chart, event), { passive: false });
    return chart;
  }

  _selected(chart) {
    const { left, width } = chart.select;
    if (width > 3) this.zoom(chart.posToVal(left, 'x'), chart.posToVal(left + width, 'x'));
    chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  /** Ctrl and wheel zoom about the cursor, Shift and wheel move; the bare wheel scrolls the page. */
  _wheel(chart, event) {
    const [from, to] = this.range;
    if (event.ctrlKey || event.metaKey) {
      const about = chart.posToVal(event.offsetX, 'x');
      const factor = ZOOM_STEP ** Math.sign(event.deltaY);
      this.zoom(about - (about - from) * factor, about + (to - about) * factor);
    } else if (event.shiftKey || event.deltaX) {
      const step = (0.1 * (to - from)) * Math.sign(event.deltaX || event.deltaY);
      this.zoom(from + step, to + step);
    } else {
      return;
    }
    event.preventDefault();
  }

  _fit(root) {
    for (const chart of this.charts) {
      if (chart.width !== root.clientWidth) chart.setSize({ width: root.clientWidth, height: chart.height });
    }
    queueMicrotask(() => this._place());
  }
}

/** Return the ends of a y axis for values from low to high, `least` apart or more. */
function padded(low, high, least) {
  if (low == null || high == null) return [0, least];
  const span = Math.max(high - low, least);
  const middle = (low + high) / 2;
  return [middle - span * (0.5 + PAD), middle + span * (0.5 + PAD)];
}
