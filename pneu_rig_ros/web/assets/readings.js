// The table of values beside the cylinder.
'use strict';

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
