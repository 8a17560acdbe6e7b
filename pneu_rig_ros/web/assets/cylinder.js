// The cylinder as a drawing, and the table of values beside it.
'use strict';

const CHAMBER_COLOURS = [BLUE, ORANGE];

/** The piston is where it is, the chambers are the darker the higher their pressure. */
class CylinderDrawing {
  /**
   * @param svg   element to fill
   * @param rig   { stroke, bore, rod_diameter [m], atmospheric_pressure, supply_pressure [Pa],
   *              intake_voltage, exhaust_voltage [V] }
   */
  constructor(svg, rig) {
    this.rig = rig;
    const stroke = 1000 * rig.stroke;
    // Tall enough to be read: along the axis it is to scale, across it is not.
    this.bore = Math.max(1000 * rig.bore, 0.34 * stroke);
    this.rod = (this.bore * rig.rod_diameter) / rig.bore;
    this.piston = 0.1 * stroke;
    this.unit = stroke / 200; // of line widths and letters
    svg.replaceChildren();
    svg.classList.add('cylinder');
    this._draw(svg, stroke);
  }

  /** Show a state: position [m], pressures [Pa], voltages [V] of the valves; null is not known. */
  show({ position, pressure_1, pressure_2, voltage_1, voltage_2 }) {
    const stroke = 1000 * this.rig.stroke;
    const x = Math.min(Math.max(1000 * (position ?? 0), 0), stroke);
    const right = stroke + this.piston;
    this.moving.setAttribute('transform', `translate(${x} 0)`);
    this.moving.dataset.position = x.toFixed(3);
    set(this.chambers[0], { x: 0, width: x });
    set(this.chambers[1], { x: x + this.piston, width: right - x - this.piston });
    [pressure_1, pressure_2].forEach((pressure, index) => {
      this.chambers[index].setAttribute('fill-opacity', this._shade(pressure));
      this.texts[index].textContent = pressure == null ? '' : `p${'₁₂'[index]} ${(pressure / 1e5).toFixed(2)} bar`;
    });
    [voltage_1, voltage_2].forEach((voltage, index) => this._valve(this.valves[index], voltage));
    this.pointer.textContent = `${x.toFixed(1)} mm`;
    const reach = 30 * this.unit; // half the width of the text, and more
    this.pointer.setAttribute('x', Math.max(x, reach - 8 * this.unit));
    this.mark.setAttribute('transform', `translate(${x} 0)`);
  }

  _shade(pressure) {
    const { atmospheric_pressure: ambient, supply_pressure: supply } = this.rig;
    const share = ((pressure ?? ambient) - ambient) / Math.max(supply - ambient, 1);
    return 0.06 + 0.74 * Math.min(Math.max(share, 0), 1);
  }

  _valve(arrow, voltage) {
    const { intake_voltage: fills, exhaust_voltage: empties } = this.rig;
    const state = voltage == null ? '' : voltage > fills ? 'fills' : voltage < empties ? 'empties' : 'shut';
    arrow.dataset.state = state;
    const tall = 16 * this.unit;
    const half = 5 * this.unit;
    const up = `M 0 ${-tall} L ${half} ${-tall + 1.6 * half} H ${-half} Z M 0 ${-tall} V 0`;
    const down = `M 0 0 L ${half} ${-1.6 * half} H ${-half} Z M 0 ${-tall} V 0`;
    const bar = `M ${-half} ${-0.4 * half} H ${half}`;
    arrow.setAttribute('d', { fills: down, empties: up, shut: bar, '': '' }[state]);
  }

  _draw(svg, stroke) {
    const { bore, rod, piston, unit } = this;
    const right = stroke + piston;
    const wall = 3.5 * unit;
    const port = bore / 2 + wall;
    const base = bore / 2 + wall;
    const end = right + stroke + 0.12 * stroke;
    const box = [-8 * unit, -port - 24 * unit, end + 12 * unit, port + base + 66 * unit];
    svg.setAttribute('viewBox', box.join(' '));
    const part = (name, attributes, parent = svg) => set(
      parent.appendChild(document.createElementNS('http://www.w3.org/2000/svg', name)), attributes);
    this.chambers = CHAMBER_COLOURS.map((fill) => part('rect', { y: -bore / 2, height: bore, fill }));
    const tube = { fill: '#6d7584' };
    part('rect', { x: -wall, y: -port, width: right + 2 * wall, height: wall, ...tube });
    part('rect', { x: -wall, y: bore / 2, width: right + 2 * wall, height: wall, ...tube });
    part('rect', { x: -wall, y: -port, width: wall, height: 2 * port, ...tube });
    part('rect', { x: right, y: -port, width: wall, height: port - rod / 2, ...tube });
    part('rect', { x: right, y: rod / 2, width: wall, height: port - rod / 2, ...tube });
    this.moving = part('g', {});
    const metal = { fill: '#c4cad4', stroke: '#565d6a', 'stroke-width': 0.8 * unit };
    part('rect', { x: piston, y: -rod / 2, width: stroke + 0.12 * stroke, height: rod, ...metal }, this.moving);
    part('rect', { x: 0, y: -bore / 2, width: piston, height: bore, ...metal, fill: '#8d96a6' }, this.moving);
    for (const at of [0.25, 0.75]) {
      const seal = { y: -bore / 2, width: 0.12 * piston, height: bore, fill: '#31353d' };
      part('rect', { x: (at - 0.06) * piston, ...seal }, this.moving);
    }
    this.valves = [0.06 * stroke, right - 0.06 * stroke].map((x, index) => {
      part('rect', { x: x - 3 * unit, y: -port, width: 6 * unit, height: wall, fill: CHAMBER_COLOURS[index], 'fill-opacity': 0.5 });
      return part('path', { transform: `translate(${x} ${-port - 3 * unit})`, fill: CHAMBER_COLOURS[index],
        stroke: CHAMBER_COLOURS[index], 'stroke-width': 2 * unit });
    });
    const letters = { 'font-size': 13 * unit, 'font-weight': 600, y: -port - 7 * unit };
    this.texts = [
      part('text', { x: 0.06 * stroke + 9 * unit, ...letters, fill: CHAMBER_COLOURS[0] }),
      part('text', { x: right - 0.06 * stroke - 9 * unit, ...letters, fill: CHAMBER_COLOURS[1], 'text-anchor': 'end' }),
    ];
    this._ruler(part, stroke, base);
  }

  _ruler(part, stroke, base) {
    const { unit } = this;
    const line = { stroke: '#8a8f98', 'stroke-width': 0.8 * unit };
    const y = base + 5 * unit;
    part('path', { d: `M 0 ${y} H ${stroke}`, ...line });
    const step = stroke > 260 ? 100 : stroke > 120 ? 50 : stroke / 4;
    const letters = { 'font-size': 11 * unit, fill: '#5b6270', 'text-anchor': 'middle', y: y + 16 * unit };
    for (let x = 0; x <= stroke + 1e-6; x += step) {
      part('path', { d: `M ${x} ${y} v ${4 * unit}`, ...line });
      part('text', { x, ...letters }).textContent = `${Math.round(x)}`;
    }
    this.mark = part('path', { d: `M 0 ${y} l ${3.4 * unit} ${-5.5 * unit} h ${-6.8 * unit} z`, fill: '#20242b' });
    this.pointer = part('text', { ...letters, 'font-size': 13 * unit, 'font-weight': 600, fill: '#20242b', y: y + 32 * unit });
  }
}

/** Set attributes of an element and return it. */
function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

const READINGS = {
  time: ['time', 's', 1, 3],
  position: ['position', 'mm', 1e3, 2],
  velocity: ['velocity', 'mm/s', 1e3, 1],
  pressure_1: ['pressure p₁, cap end, absolute', 'bar', 1e-5, 3],
  pressure_2: ['pressure p₂, rod end, absolute', 'bar', 1e-5, 3],
  friction: ['friction force', 'N', 1, 1],
  u: ['command u', 'V', 1, 3],
  voltage_1: ['valve 1', 'V', 1, 3],
  voltage_2: ['valve 2', 'V', 1, 3],
};

class Readings {
  /** @param table  element to fill; @param names  keys of READINGS, in SI units */
  constructor(table, names) {
    this.cells = {};
    for (const name of names) {
      const [label, unit] = READINGS[name];
      const row = table.insertRow();
      row.insertCell().textContent = label;
      this.cells[name] = row.insertCell();
      this.cells[name].className = 'number';
      this.cells[name].dataset.reading = name;
      row.insertCell().textContent = unit;
    }
  }

  /** Show values in SI units; null is not known. */
  show(values) {
    for (const [name, cell] of Object.entries(this.cells)) {
      const [, , scale, digits] = READINGS[name];
      const value = values[name];
      cell.textContent = value == null || Number.isNaN(value) ? '–' : (scale * value).toFixed(digits);
    }
  }
}
