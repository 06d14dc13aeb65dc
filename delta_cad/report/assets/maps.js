"use strict";

// Maps over slices of the cube: one row a figure, one picture a slice.
class Maps {
  // data: as `fields.maps`; told(text) while a place is pointed at; chosen(position) when it is pressed.
  constructor(home, data, told, chosen) {
    this.data = data;
    this.rows = data.maps.map((map) => new MapRow(home, data, map, told, chosen));
  }

  // ownScales: each slice has a colour scale of its own, in place of one over all slices of a figure.
  draw(ownScales) {
    for (const row of this.rows) row.draw(ownScales);
  }
}

class MapRow {
  constructor(home, data, map, told, chosen) {
    this.map = map;
    this.x = map.x_mm;
    this.y = map.y_mm;
    const row = element(home, "section", "map");
    const title = element(row, "h3", "", map.unit ? `${map.words}, ${map.unit}` : map.words);
    if (map.limit !== null) element(title, "small", "", ` required ${map.upper ? "≤" : "≥"} ${map.limit}`);
    element(row, "p", "note", map.note);
    const key = element(row, "p", "scale");
    this.good = element(key, "span", "");
    element(key, "i", "");
    this.bad = element(key, "span", "");
    const slices = element(row, "div", "slices");
    const known = map.values.map((slice) => slice.map((line) => line.map((v) => v ?? NaN))); // none at a singularity
    const flat = known.flat(2).filter(Number.isFinite);
    this.range = [Math.min(...flat), Math.max(...flat)];
    this.marks = 0;
    this.worst = map.upper ? this.range[1] : this.range[0];
    this.slices = known.map((values, k) => {
      const figure = element(slices, "figure", "");
      const frame = element(figure, "div", "slice");
      const canvas = element(frame, "canvas", "");
      canvas.width = canvas.height = SIZE;
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", `${map.words} at z = ${data.z_mm[k]} mm`);
      const at = (event) => this.place(canvas, event);
      const words = (event) => {
        const [i, j] = at(event);
        const where = `${this.x[i].toFixed(1)}, ${this.y[j].toFixed(1)}, ${data.z_mm[k].toFixed(1)} mm`;
        const value = Number.isFinite(values[j][i]) ? values[j][i] : "without bound";
        told(event, `${map.words} ${value} ${map.unit}`, where, ...(map.names ? [map.names[map.pairs[k][j][i]]] : []));
      };
      canvas.addEventListener("pointermove", words);
      canvas.addEventListener("pointerleave", (event) => told(event, ""));
      canvas.addEventListener("click", (event) => {
        const [i, j] = at(event);
        chosen([this.x[i], this.y[j], data.z_mm[k]]);
      });
      this.mark(frame, values);
      const scale = element(figure, "figcaption", "");
      return { values, canvas, scale, z: data.z_mm[k] };
    });
  }

  place(canvas, event) {
    const box = canvas.getBoundingClientRect();
    const n = this.x.length - 1;
    const share = (v) => Math.min(n, Math.max(0, Math.round(v * n)));
    return [share((event.clientX - box.left) / box.width), share(1 - (event.clientY - box.top) / box.height)];
  }

  draw(ownScales) {
    const ends = this.map.upper ? this.range : [this.range[1], this.range[0]];
    [this.good.textContent, this.bad.textContent] = ownScales ? ["best in the slice", "worst in the slice"] : ends.map((v) => told(v));
    for (const { values, canvas, scale, z } of this.slices) {
      const own = values.flat().filter(Number.isFinite);
      const found = [Math.min(...own), Math.max(...own)];
      const [low, high] = ownScales ? found : this.range;
      const context = canvas.getContext("2d");
      const image = context.createImageData(SIZE, SIZE);
      const step = (this.x.length - 1) / (SIZE - 1);
      for (let row = 0; row < SIZE; row++) {
        for (let column = 0; column < SIZE; column++) {
          const value = between(values, column * step, (SIZE - 1 - row) * step);
          const share = high > low ? (value - low) / (high - low) : 0;
          image.data.set(colourOf(this.map.upper ? share : 1 - share), 4 * (row * SIZE + column));
        }
      }
      context.putImageData(image, 0, 0);
      scale.textContent = `z ${z.toFixed(1)}: ${told(found[0])} to ${told(found[1])}`;
    }
  }

  // Marks the worst value of all slices where it lies; where many places share it, the first of them.
  mark(frame, values) {
    const n = this.x.length - 1;
    values.forEach((line, j) => line.forEach((value, i) => {
      if (value !== this.worst || this.marks++ >= MOST_MARKS) return;
      const cross = element(frame, "span", "worst", "×");
      cross.style.left = `${4 + (92 * i) / n}%`;
      cross.style.top = `${4 + 92 * (1 - j / n)}%`;
    }));
  }
}

const MOST_MARKS = 6; // of a symmetric machine's equal places
const SIZE = 65; // pixels along an edge of a slice; the browser smooths what it enlarges

function told(value, digits = 3) {
  return value === null ? "" : String(Number(value.toPrecision(digits)));
}

function element(home, tag, kind, text = "") {
  const one = document.createElement(tag);
  if (kind) one.className = kind;
  if (text) one.textContent = text;
  home.append(one);
  return one;
}

// Value between four samples.
function between(values, x, y) {
  const i = Math.min(values.length - 2, Math.floor(x));
  const j = Math.min(values.length - 2, Math.floor(y));
  const [u, v] = [x - i, y - j];
  const low = values[j][i] * (1 - u) + values[j][i + 1] * u;
  const high = values[j + 1][i] * (1 - u) + values[j + 1][i + 1] * u;
  return low * (1 - v) + high * v;
}

// Colours of `viridis` (CC0), of which people who see red and green alike can tell all; bright is bad.
const STEPS = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99],
  [170, 220, 50], [253, 231, 37],
];

function colourOf(share) {
  if (!Number.isFinite(share)) return [128, 128, 128, 255];
  const at = Math.min(1, Math.max(0, share)) * (STEPS.length - 1);
  const k = Math.min(STEPS.length - 2, Math.floor(at));
  return [...STEPS[k].map((c, i) => c + (STEPS[k + 1][i] - c) * (at - k)), 255];
}
