"use strict";

(() => {
  const get = (id) => document.getElementById(id);
  const scenes = JSON.parse(get("data").textContent);
  const sides = ["a", "b"].map((side, k) => ({ side, data: scenes[k], viewer: null })).filter(({ data }) => data);
  const sliders = [..."xyz"].map((axis) => get(`pose-${axis}`));
  const degrees = (rad) => (rad * 180) / Math.PI;
  const least = (...values) => values.reduce((a, b) => a.map((v, k) => Math.min(v, b[k])));
  const most = (...values) => values.reduce((a, b) => a.map((v, k) => Math.max(v, b[k])));
  const ends = ({ cube: { half_mm: half, bottom_mm: bottom, centre_x_mm: x } }) => [
    [x - half, -half, bottom], [x + half, half, bottom + 2 * half],
  ];
  if (sides.length === 0) {
    document.body.dataset.ready = "no model";
    return;
  }
  // the box about both cubes
  const low = least(...sides.map(({ data }) => ends(data)[0]));
  const high = most(...sides.map(({ data }) => ends(data)[1]));
  // the middle of what both cubes share
  const [from, to] = [most(...sides.map(({ data }) => ends(data)[0])), least(...sides.map(({ data }) => ends(data)[1]))];
  let at = from.every((v, k) => v <= to[k]) ? from.map((v, k) => (v + to[k]) / 2) : sides[0].data.home_mm;

  const ROWS = [
    ["conditioning", (f) => told(f.kappa, 4)],
    ["torque for the required force, N m", (f) => told(Math.max(...f.torque), 4)],
    ["effective mass, kg", (f) => told(f.effective_mass, 4)],
    ["friction, N", (f) => told(f.friction, 4)],
    ["position step, mm", (f) => told(f.position_step, 3)],
    ["shoulders, deg", (f) => f.shoulder.map((v) => degrees(v).toFixed(1)).join(", ")],
  ];

  function live() {
    const found = ["a", "b"].map((side) => {
      const known = sides.find((one) => one.side === side);
      return known && known.reached ? Delta.figures(known.data.mechanism, at) : null;
    });
    const body = get("live").tBodies[0];
    body.replaceChildren();
    for (const [words, value] of ROWS) {
      const line = body.insertRow();
      element(line, "th", "", words).scope = "row";
      for (const figures of found) element(line, "td", "n", figures ? value(figures) : "–");
    }
  }

  // Moves both handles to a position within the box about both cubes; a machine that does not reach it stays.
  function move(wanted) {
    at = most(low, least(high, wanted));
    sliders.forEach((slider, k) => {
      slider.value = at[k];
      get(`told-${"xyz"[k]}`).textContent = at[k].toFixed(1);
    });
    for (const one of sides) {
      const [from, to] = ends(one.data);
      one.reached = Delta.reachable(one.data.mechanism, at);
      if (one.reached) one.viewer?.place(at);
      const within = at.every((v, k) => v >= from[k] - 1e-6 && v <= to[k] + 1e-6);
      if (one.viewer) get(`message-${one.side}`).textContent = one.reached ? (within ? "" : "outside its cube") : "out of its reach";
    }
    live();
  }

  // Gives the other machine the camera of one that was turned.
  function follow(leader) {
    for (const { viewer } of sides) {
      if (!viewer || viewer === leader) continue;
      viewer.camera.position.copy(leader.camera.position);
      viewer.camera.quaternion.copy(leader.camera.quaternion);
      viewer.camera.fov = leader.camera.fov;
      viewer.controls.target.copy(leader.controls.target);
      viewer.controls.maxDistance = leader.controls.maxDistance;
      viewer.clip();
      viewer.draw();
    }
  }

  function look(view) {
    const [first] = sides;
    first.viewer.look(view);
    follow(first.viewer);
  }

  sliders.forEach((slider, k) => {
    [slider.min, slider.max] = [low[k], high[k]];
    slider.addEventListener("input", () => move(at.map((v, axis) => (axis === k ? Number(slider.value) : v))));
  });
  for (const button of document.querySelectorAll("button[data-view]")) {
    button.addEventListener("click", () => look(button.dataset.view));
  }
  get("apart").addEventListener("input", (event) => {
    get("told-apart").textContent = `${event.target.value} %`;
    for (const { viewer } of sides) viewer.explode(Number(event.target.value) / 100);
  });
  get("apart").addEventListener("change", () => look("iso"));

  move(at);
  try {
    for (const one of sides) {
      const bytes = Uint8Array.from(atob(get(`model-${one.side}`).textContent), (c) => c.charCodeAt(0));
      one.viewer = new Viewer(get(`view-${one.side}`), one.data, bytes.buffer);
    }
  } catch (error) {
    for (const { side } of sides) get(`message-${side}`).textContent = "This browser draws no 3D here (WebGL).";
    document.body.dataset.ready = "no model";
    return;
  }
  Promise.all(sides.map(({ viewer }) => viewer.ready)).then(() => {
    const framed = sides.flatMap(({ viewer }) => viewer.reach);
    for (const { viewer } of sides) {
      viewer.reach = framed;
      viewer.fit();
      viewer.look("iso");
    }
    for (const { viewer } of sides) {
      viewer.controls.addEventListener("change", () => follow(viewer));
      new Grip(viewer, move);
      new ResizeObserver(() => viewer.fit()).observe(viewer.canvas);
    }
    move(at);
    document.body.dataset.ready = "model";
  });
})();
