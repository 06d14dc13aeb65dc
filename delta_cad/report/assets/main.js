"use strict";

(() => {
  const get = (id) => document.getElementById(id);
  const data = JSON.parse(get("data").textContent);
  const degrees = (rad) => (rad * 180) / Math.PI;
  const half = data.cube.half_mm;
  const middle = [data.cube.centre_x_mm, 0, data.cube.bottom_mm + half];
  const FAR_MM = 2 * (data.mechanism.upper_arm_mm + data.mechanism.forearm_mm); // beyond all that is reached
  const sliders = [..."xyz"].map((axis) => get(`pose-${axis}`));
  let viewer = null;
  let at = data.home_mm;

  // Figures at a pose, line by line.
  function live(pose) {
    const found = Delta.figures(data.mechanism, pose);
    const body = get("live").tBodies[0];
    body.replaceChildren();
    const row = (words, value) => {
      const line = body.insertRow();
      element(line, "th", "", words).scope = "row";
      element(line, "td", "n", value);
    };
    if (!found) {
      row("out of reach", "");
      return;
    }
    if (Math.max(...pose.map((v, k) => Math.abs(v - middle[k]))) > half + 1e-6) row("outside the cube", "not proved here");
    const three = (values, digits) => values.map((v) => degrees(v).toFixed(digits)).join(", ");
    row("shoulders", `${three(found.shoulder, 2)} deg`);
    row("rods' lean", `${three(found.lean, 2)} deg`);
    row("conditioning", told(found.kappa, 4));
    row(`torque for ${data.mechanism.force_N} N`, `${told(Math.max(...found.torque), 4)} N m`);
    row("effective mass", `${told(found.effective_mass, 4)} kg`);
    if (found.friction !== null) row("friction", `${told(found.friction, 4)} N`);
    if (found.position_step !== null) row("position step", `${told(found.position_step, 3)} mm`);
  }

  // Moves the machine to the position nearest to a wanted one: of the cube, or of all that the machine reaches.
  function move(wanted) {
    const kept = get("keep").checked ? clamped(wanted) : wanted;
    const within = Delta.toward(data.mechanism, middle, kept) ?? kept;
    sliders.forEach((slider, k) => {
      slider.min = Math.min(slider.min, within[k]);
      slider.max = Math.max(slider.max, within[k]);
      slider.value = within[k];
      get(`told-${"xyz"[k]}`).textContent = within[k].toFixed(1);
    });
    live(within);
    viewer?.place(within);
    at = within;
  }

  const clamped = (pose) => pose.map((v, k) => Math.min(middle[k] + half, Math.max(middle[k] - half, v)));

  // Lets the sliders go over the cube, or as far as the machine reaches from its middle.
  function limit() {
    sliders.forEach((slider, k) => {
      const end = (side) => middle.map((v, axis) => (axis === k ? v + side : v));
      const farthest = (side) => Delta.toward(data.mechanism, middle, end(side))?.[k] ?? middle[k];
      const sides = get("keep").checked ? [middle[k] - half, middle[k] + half] : [farthest(-FAR_MM), farthest(FAR_MM)];
      [slider.min, slider.max] = sides;
    });
    move(at);
  }

  sliders.forEach((slider, k) => {
    slider.addEventListener("input", () => move(at.map((v, axis) => (axis === k ? Number(slider.value) : v))));
  });
  get("keep").addEventListener("change", limit);
  get("home").addEventListener("click", () => move(middle));
  for (const button of document.querySelectorAll("button.show")) {
    button.addEventListener("click", () => {
      move(button.dataset.pose.split(",").map(Number));
      get("machine").scrollIntoView();
    });
  }

  get("apart").addEventListener("input", (event) => {
    const share = Number(event.target.value);
    get("told-apart").textContent = `${share} %`;
    viewer?.explode(share / 100);
  });
  get("apart").addEventListener("change", () => viewer?.look("iso"));
  const cut = () => {
    const axis = get("cut").value;
    get("cut-at").disabled = axis === "";
    const place = viewer?.cut(axis, Number(get("cut-at").value));
    get("told-cut").textContent = place === undefined ? "" : place.toFixed(1);
  };
  get("cut").addEventListener("change", cut);
  get("cut-at").addEventListener("input", cut);
  for (const name of ["cube", "outline"]) {
    get(`with-${name}`).addEventListener("change", (event) => viewer?.show(name, event.target.checked));
  }
  for (const button of document.querySelectorAll("button[data-view]")) {
    button.addEventListener("click", () => viewer?.look(button.dataset.view));
  }

  // Names beside the pointer.
  const tip = get("tip");
  function tell(event, ...lines) {
    tip.hidden = !lines[0];
    if (tip.hidden) return;
    tip.replaceChildren();
    lines.forEach((line, k) => element(tip, k ? "span" : "b", "", line));
    tip.style.left = `${Math.min(event.clientX + 14, window.innerWidth - tip.offsetWidth - 8)}px`;
    tip.style.top = `${Math.min(event.clientY + 14, window.innerHeight - tip.offsetHeight - 8)}px`;
  }

  function name(event) {
    const found = viewer?.hit(...viewer.pixel(event))?.part;
    if (!found) return tell(event, "");
    const part = data.parts[found.part];
    return tell(event, found.name, part.description, `${part.material}, ${part.mass_g} g, ${part.make ? "made" : "bought"}`);
  }
  get("view").addEventListener("pointermove", (event) => event.buttons || name(event));
  get("view").addEventListener("click", name);
  get("view").addEventListener("pointerleave", (event) => tell(event, ""));

  for (const line of document.querySelectorAll("#bom tr[data-part]")) {
    line.addEventListener("click", (event) => {
      if (event.target.closest("details, a")) return;
      const was = line.classList.contains("chosen");
      document.querySelectorAll("#bom tr.chosen").forEach((one) => one.classList.remove("chosen"));
      line.classList.toggle("chosen", !was);
      viewer?.mark((one) => !was && data.parts[one.part].number === line.dataset.part);
      if (!was) get("machine").scrollIntoView();
    });
  }
  for (const filter of document.querySelectorAll("input.filter")) {
    filter.addEventListener("input", () => {
      const sought = filter.value.toLowerCase();
      const table = get(filter.dataset.table);
      for (const line of table.querySelectorAll("tbody tr")) line.hidden = !line.textContent.toLowerCase().includes(sought);
      for (const kind of table.querySelectorAll("details.sum")) {
        kind.hidden = !kind.querySelector("tbody tr:not([hidden])");
        kind.open = sought !== "" && !kind.hidden;
      }
    });
  }

  get("theme").addEventListener("click", () => {
    const dark = document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === "dark"
      : window.matchMedia("(prefers-color-scheme: dark)").matches;
    document.documentElement.dataset.theme = dark ? "light" : "dark";
  });

  const home = get("maps");
  if (home) {
    const maps = new Maps(home, data.slices, tell, move);
    const scales = get("scales");
    scales.addEventListener("change", () => maps.draw(scales.value === "each"));
    maps.draw(false);
  }

  limit();
  const bytes = Uint8Array.from(atob(get("model").textContent), (c) => c.charCodeAt(0));
  try {
    viewer = new Viewer(get("view"), data, bytes.buffer);
  } catch (error) {
    get("message").textContent = "This browser draws no 3D here (WebGL); the folder views/ has pictures.";
    document.body.dataset.ready = "no model";
    return;
  }
  viewer.ready.then(() => {
    viewer.fit();
    viewer.look("iso");
    move(at);
    const rows = [...document.querySelectorAll("#bom tr[data-part]")];
    const drawn = rows.map((row) => [row, [...data.parts.keys()].filter((k) => data.parts[k].number === row.dataset.part)]);
    viewer.portraits(
      drawn.filter(([, pieces]) => pieces.length).map(([row, pieces]) => {
        const canvas = element(row.querySelector(".face"), "canvas", "");
        [canvas.width, canvas.height] = [160, 120];
        return [canvas, pieces];
      }),
    );
    const hint = get("hint");
    hint.hidden = false;
    new Grip(viewer, (position) => {
      hint.hidden = true;
      tip.hidden = true;
      move(position);
    });
    new ResizeObserver(() => viewer.fit()).observe(get("view"));
    get("message").remove();
    document.body.dataset.ready = "model";
  });
})();
