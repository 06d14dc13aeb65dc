"use strict";

// Small charts as SVG: a line of points against a limit, or points to press, with the present one among them.
const Charts = (() => {
  const WIDE = 300;
  const HIGH = 132;
  const [LEFT, RIGHT, TOP, BOTTOM] = [34, 12, 8, 20];

  function element(parent, name, attributes = {}, text = "") {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.textContent = text;
    parent.append(made);
    return made;
  }

  function range(values) {
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const room = high - low > 1e-9 ? 0.08 * (high - low) : 0.05 * Math.abs(high) || 1;
    return [low - room, high + room];
  }

  function round(low, high, most) {
    const decade = 10 ** Math.floor(Math.log10((high - low) / most));
    const step = [1, 2, 5, 10].map((k) => k * decade).find((one) => (high - low) / one <= most);
    const found = [];
    for (let k = Math.ceil(low / step); k <= Math.floor(high / step); k++) found.push(Number((k * step).toPrecision(10)));
    return found;
  }

  // {title, unit, points: [[x, y]], here: [x, y], picks: [{at: [x, y], words, take}]}
  function draw(box, { title, unit, points = [], here = null, picks = [] }) {
    box.replaceChildren();
    const heading = document.createElement("h3");
    heading.textContent = title;
    box.append(heading);
    const all = [...points, ...picks.map((one) => one.at), ...(here ? [here] : [])];
    if (!all.length) return;
    const [xs, ys] = [range(all.map((p) => p[0])), range(all.map((p) => p[1]))];
    const x = (v) => LEFT + ((v - xs[0]) / (xs[1] - xs[0])) * (WIDE - LEFT - RIGHT);
    const y = (v) => HIGH - BOTTOM - ((v - ys[0]) / (ys[1] - ys[0])) * (HIGH - BOTTOM - TOP);
    const svg = element(box, "svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "img", "aria-label": title });
    for (const v of round(...ys, 4)) {
      element(svg, "line", { class: "axis", x1: LEFT, x2: WIDE - RIGHT, y1: y(v), y2: y(v) });
      element(svg, "text", { x: LEFT - 4, y: y(v) + 3.5, "text-anchor": "end" }, String(v));
    }
    for (const v of round(...xs, 5)) {
      element(svg, "text", { x: x(v), y: HIGH - 6, "text-anchor": "middle" }, String(v));
    }
    element(svg, "text", { x: WIDE - 2, y: HIGH - 6, "text-anchor": "end" }, unit);
    if (points.length) {
      element(svg, "polyline", { class: "line", points: points.map((p) => `${x(p[0])},${y(p[1])}`).join(" ") });
      for (const p of points) element(svg, "circle", { class: "dot", cx: x(p[0]), cy: y(p[1]), r: 2.2 });
    }
    for (const { at, words, take } of picks) {
      const dot = element(svg, "circle", { class: "pick", cx: x(at[0]), cy: y(at[1]), r: 4.5 });
      element(dot, "title", {}, words);
      dot.addEventListener("click", take);
    }
    if (here) element(svg, "circle", { class: "here", cx: x(here[0]), cy: y(here[1]), r: 5.5 });
  }

  return { draw };
})();
