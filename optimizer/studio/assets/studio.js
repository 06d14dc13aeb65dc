"use strict";

(() => {
  const get = (id) => document.getElementById(id);
  const scene = new Scene(get("view"));
  const knobs = new Map(); // field -> {knob, box, range, output, check, price}
  let socket = null;
  let viewer = "";
  let seq = 0;
  let hello = null;
  let state = null; // values and hardware as the studio has them
  let answered = null;
  let detailed = null;
  let held = ""; // field of the slider that is being moved: what comes from elsewhere leaves it alone
  let solids = null;
  let parts = { state: "" };
  let build = { state: "idle" };
  const answers = []; // times in ms between setting and answer, of the last ones

  const EURO = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

  function node(parent, name, cls, text) {
    const made = document.createElement(name);
    if (cls) made.className = cls;
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  }

  function told(value, step) {
    const decimals = Math.max(0, Math.min(4, -Math.floor(Math.log10(step) + 1e-9)));
    return value.toFixed(decimals);
  }

  // Settings are sent at most once in SEND_MS, with the newest value of each field.
  const SEND_MS = 60;
  let waiting = null;
  let later = 0; // timer of the next sending
  let last = -Infinity; // time of the last sending

  function set(message) {
    waiting = waiting
      ? { values: { ...waiting.values, ...message.values }, hardware: { ...waiting.hardware, ...message.hardware }, rest: message.rest }
      : { values: {}, hardware: {}, ...message };
    if (message.rest) flush();
    else if (!later) later = setTimeout(flush, Math.max(0, last + SEND_MS - performance.now()));
    verdict();
  }

  function flush() {
    clearTimeout(later);
    later = 0;
    if (!waiting || socket?.readyState !== WebSocket.OPEN) return;
    seq += 1;
    last = performance.now();
    sent.set(seq, last);
    send({ type: "set", seq, ...waiting });
    waiting = null;
  }

  const sent = new Map();

  function send(message) {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
    else say("error", "not connected: what is set here is kept, and sent once the studio is there again");
  }

  function say(kind, text) {
    get("said").textContent = text;
    get("said").className = kind;
    get("said").hidden = !text;
    clearTimeout(say.timer);
    if (kind !== "error") say.timer = setTimeout(() => (get("said").hidden = true), 6000);
  }

  // Sliders.
  function slider(knob) {
    const box = node(get("sliders"), "div", "knob");
    const row = node(box, "div", "row");
    const label = node(row, "label");
    const id = `knob-${knob.field}`;
    let check = null;
    if (knob.optional) {
      check = node(label, "input");
      check.type = "checkbox";
      check.setAttribute("aria-label", `limit ${knob.words}`);
    }
    const words = node(label, "span", "", knob.words);
    if (!check) label.htmlFor = id;
    else words.title = `without the tick: ${knob.without}`;
    const output = node(row, "output");
    const range = node(box, "input");
    Object.assign(range, { type: "range", id, min: knob.low, max: knob.high, step: knob.step });
    range.setAttribute("aria-label", knob.words);
    const price = node(box, "p", "price");
    const own = { knob, box, range, output, check, price };
    const show = () => write(own, Number(range.value));
    range.addEventListener("input", () => {
      held = knob.field;
      if (check) check.checked = true;
      show();
      set({ values: { [knob.field]: Number(range.value) }, rest: false });
    });
    range.addEventListener("change", () => {
      held = "";
      set({ values: { [knob.field]: Number(range.value) }, rest: true });
    });
    check?.addEventListener("change", () => {
      const value = check.checked ? Number(range.value) : null;
      write(own, value);
      set({ values: { [knob.field]: value }, rest: true });
    });
    knobs.set(knob.field, own);
  }

  function write({ knob, box, range, output, check }, value) {
    box.classList.toggle("off", value === null);
    if (check) check.checked = value !== null;
    range.value = value ?? knob.start;
    range.setAttribute("aria-valuetext", value === null ? knob.without : `${value} ${knob.unit}`);
    output.textContent = value === null ? knob.without : `${told(value, knob.step)} ${knob.unit}`;
  }

  function hardware(own) {
    if (document.activeElement !== get("motor") || !held) get("motor").value = `${own.motor}|${own.drive}`;
    get("ratio-knob").hidden = own.drive !== "capstan" || hello.ratio.low === hello.ratio.high;
    if (held !== "ratio") get("ratio").value = own.ratio;
    if (held !== "width") get("width").value = own.width_mm;
    get("ratio-value").textContent = `${Number(get("ratio").value).toFixed(2)} : 1`;
    get("width-value").textContent = `${Number(get("width").value).toFixed(1)} mm`;
    get("placed").checked = own.placed;
    get("placed-field").hidden = !hello.placeable;
  }

  function begin(message) {
    hello = message;
    get("name").textContent = message.name;
    get("file").textContent = message.file;
    document.title = `${message.name}: studio`;
    get("sliders").replaceChildren();
    knobs.clear();
    message.knobs.forEach(slider);
    get("motor").replaceChildren();
    for (const one of message.motors) {
      const option = node(get("motor"), "option", "", one.words);
      option.value = `${one.motor}|${one.drive}`;
    }
    Object.assign(get("ratio"), { min: message.ratio.low, max: message.ratio.high });
    Object.assign(get("width"), { min: message.width.low, max: message.width.high });
    get("goal").textContent = { cube_side: "largest cube", effective_mass: "least effective mass", outline: "smallest outline", cost: "smallest, and so cheapest, machine" }[message.goal];
    if (message.notes.length) say("", message.notes.join("; "));
  }

  function take(message) {
    state = message;
    const mine = message.by[0] === viewer && message.by[1] < seq; // older than what was moved since
    for (const [field, own] of knobs) {
      if (!mine && field !== held && !(waiting && field in waiting.values)) write(own, message.values[field] ?? null);
    }
    if (!mine) hardware(message.hardware);
    get("saved").textContent = message.saved ? "saved" : "not saved";
    get("save").disabled = message.saved;
    verdict();
  }

  // What was found.
  function current(message) {
    return message && !waiting && (message.by[0] !== viewer || message.by[1] === seq);
  }

  function verdict() {
    status();
    const chip = get("verdict");
    const fresh = current(answered);
    const none = answered?.type === "nothing";
    get("big").classList.toggle("stale", !fresh || none);
    for (const own of knobs.values()) own.price.classList.toggle("stale", !fresh || !current(detailed));
    get("price-ratio").classList.toggle("stale", !fresh || !current(detailed));
    let [kind, text] = ["about", "moving: solving"];
    if (fresh && none) [kind, text] = answered.state === "none" ? ["none", "no lengths found with this hardware"] : ["about", "none near the last lengths"];
    else if (fresh && answered.state === "proved") [kind, text] = ["proved", "proved over the whole cube"];
    else if (fresh && answered.state === "open") [kind, text] = ["open", `not proved: ${answered.open.join(", ")}`];
    else if (fresh) [kind, text] = ["about", "about; proof follows at rest"];
    if (!answered) [kind, text] = ["waiting", "looking for the first lengths"];
    chip.className = `chip ${kind}`;
    chip.textContent = text;
    get("about").textContent = answered && !none && kind !== "proved" ? "about" : "";
    document.body.dataset.state = fresh ? answered.state : "waiting";
    document.body.dataset.seq = String(answered?.by[0] === viewer ? answered.by[1] : 0);
  }

  function show(message) {
    answered = message;
    if (message.by[0] === viewer && sent.has(message.by[1])) {
      answers.push({ seq: message.by[1], state: message.state, ms: performance.now() - sent.get(message.by[1]), took: message.took_ms });
    }
    if (message.type === "answer") {
      const least = hello.goal !== "cube_side";
      const [w, d] = message.outline_mm;
      const mass = hello.goal === "effective_mass";
      get("value").textContent = mass ? message.size.toFixed(3) : least ? `${Math.round(w)} × ${Math.round(d)}` : message.side_mm.toFixed(1);
      get("unit").textContent = mass ? "kg" : "mm";
      const cube = least ? `cube ${message.side_mm.toFixed(1)} mm · ` : "";
      get("under").textContent = `${cube}outline ${Math.round(w)} × ${Math.round(d)} mm · about ${EURO.format(message.price_EUR)} EUR`;
      scene.set(message);
      binding(message);
      table(get("lengths"), Object.entries(message.lengths).map(([name, value]) => [name.replace(/_(mm|deg)$/, "").replaceAll("_", " "), `${value.toFixed(name.endsWith("deg") ? 2 : 3)} ${name.endsWith("deg") ? "deg" : "mm"}`]));
      get("relief").hidden = true;
      document.body.dataset.side = String(message.side_mm);
    }
    verdict();
  }

  function table(box, rows) {
    box.replaceChildren();
    for (const [words, value] of rows) {
      const row = box.insertRow();
      row.insertCell().textContent = words;
      const cell = row.insertCell();
      cell.className = "n";
      cell.textContent = value;
    }
  }

  function binding({ binding: rows, explained }) {
    const box = get("binding");
    box.replaceChildren();
    box.classList.toggle("stale", !explained);
    const most = Math.max(...rows.map((one) => one.gain_mm), 1e-9);
    for (const { words, gain_mm: gain } of rows) {
      const row = node(box, "div", "bind");
      node(row, "span", "", words);
      node(row, "b", "", `${gain.toFixed(2)} mm`);
      const bar = node(row, "progress");
      bar.max = most;
      bar.value = gain;
      bar.setAttribute("aria-hidden", "true");
    }
  }

  function price(box, found, knob) {
    box.replaceChildren();
    if (found === undefined) return;
    if (found === null) {
      box.textContent = knob?.field === "feel.stiffness_min_N_mm" ? "checked with the parts, at rest" : "";
      return;
    }
    const sign = found.step < 0 ? "−" : "+";
    const unit = knob ? knob.unit : "";
    const change = `${sign}${Number(Math.abs(found.step).toPrecision(3))} ${unit}`.trim();
    if (Math.abs(found.gain) < 0.005 * (found.unit.startsWith("kg") ? 0.01 : 1)) {
      box.textContent = "does not bind";
      return;
    }
    const better = found.gain > 0 ? "+" : "−";
    box.append(`${change}: `);
    node(box, "b", "", `${found.unit === "mm of cube" ? better : found.gain > 0 ? "−" : "+"}${Number(Math.abs(found.gain).toPrecision(2))} ${found.unit}`);
  }

  function details(message) {
    detailed = message;
    table(get("figures"), message.figures.map(({ words, value, unit }) => [words, `${value} ${unit}`]));
    for (const [field, own] of knobs) price(own.price, state?.values[field] === null ? undefined : message.prices[field], own.knob);
    price(get("price-ratio"), message.prices["hardware.capstan_ratio"], null);
    verdict();
  }

  // Fronts and other hardware.
  const boxes = new Map();

  function front({ name, words, unit, points, here }) {
    if (!boxes.has(name)) boxes.set(name, node(get("fronts"), "div", "chart"));
    Charts.draw(boxes.get(name), { title: `cube, mm, against ${words}`, unit, points, here });
  }

  function others({ rows, here }) {
    const least = hello.goal !== "cube_side";
    const cube = (row) => (least ? row.outline_mm[0] : row.side_mm);
    const choose = (row) => () => {
      const { motor, drive, ratio, width_mm, placed } = row;
      set({ hardware: { motor, drive, ratio, width_mm, placed }, rest: true });
    };
    const words = (row) => `${row.motor}${row.drive === "capstan" ? `, ${row.ratio} : 1` : ", direct"}`;
    Charts.draw(get("cost"), {
      title: `${least ? "outline width" : "cube"}, mm, against cost`,
      unit: "EUR",
      here: [here.price_EUR, cube(here)],
      picks: rows.map((row) => ({ at: [row.price_EUR, cube(row)], words: `${words(row)}: ${cube(row)} mm, ${EURO.format(row.price_EUR)} EUR`, take: choose(row) })),
    });
    get("cost").className = "chart";
    get("others").replaceChildren();
    for (const row of rows) {
      const line = get("others").insertRow();
      line.insertCell().textContent = words(row);
      for (const text of [`${row.estimated ? "≈ " : ""}${cube(row).toFixed(1)} mm`, `${EURO.format(row.price_EUR)} EUR`]) {
        const cell = line.insertCell();
        cell.className = "n";
        cell.textContent = text;
      }
      line.classList.toggle("now", row.motor === here.motor && row.drive === here.drive);
      line.addEventListener("click", choose(row));
    }
  }

  function relief({ rows, done }) {
    const box = get("relief");
    box.hidden = false;
    box.replaceChildren();
    node(box, "p", "", rows.length ? "Each of these alone would give a machine:" : done ? "No single limit, eased up to four times, gives a machine: several have to give." : "Looking for a limit that would be enough to give …");
    for (const { field, words, value, unit } of rows) {
      const button = node(box, "button", "", `${words} ${value} ${unit}`.trim());
      button.type = "button";
      button.addEventListener("click", () => {
        const own = knobs.get(field);
        write(own, value);
        set({ values: { [field]: value }, rest: true });
      });
    }
  }

  // Solids of the last machine, and the build.
  async function machine(message) {
    const files = get("downloads");
    files.replaceChildren();
    message.files.forEach(({ name, words, bytes }, k) => {
      const link = node(files, "a", k ? "" : "first", `${words} · ${bytes > 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.ceil(bytes / 1e3)} kB`}`);
      link.href = `machine/${name}`;
      if (/\.(html|pdf)$/.test(name)) link.target = "_blank";
      link.rel = "noopener";
    });
    get("building").hidden = false;
    try {
      const answer = await fetch(`machine/assembly.glb?${message.stamp}`);
      if (!answer.ok) throw new Error(answer.status);
      await scene.load(message.scene, await answer.arrayBuffer());
    } catch {
      say("error", "the last machine's solids could not be loaded");
      return;
    }
    solids = message;
    if (build.state === "idle") get("build-state").textContent = `last machine, built ${message.built}`;
    get("solids-field").hidden = false;
    if (message.new) {
      get("show-body").checked = false;
      scene.shown.body = false;
    }
    scene.look();
    status();
  }

  let doing = "";

  function status() {
    const words = [];
    if (doing) words.push(doing);
    else if (build.state === "running") words.push(`building: ${step(build)}`);
    const about = { looking: "parts: looking", passed: "parts pass in closed form", refused: `parts: ${parts.text}` }[parts.state];
    get("parts").hidden = !about || !current(answered) || !["proved", "open"].includes(answered.state);
    get("parts").textContent = about ?? "";
    get("parts").className = `chip ${{ looking: "about", passed: "proved", refused: "open" }[parts.state] ?? ""}`;
    if (solids && scene.shown.solids) {
      words.push(`solids: machine built ${solids.built}${build.state === "running" ? ", in view until the new one stands" : ""}`);
    }
    get("doing").textContent = words.join(" · ");
    get("doing").classList.toggle("busy", doing !== "" || build.state === "running");
  }

  // The step that a build is at, and the share of its time, or of its steps, that is over; null where none is known.
  function step({ at, now }) {
    return at.step ? `step ${at.step} of ${at.of}, ${at.name}` : now;
  }

  function share({ at, took_s: took }) {
    if (at.left_s !== undefined) return took / (took + at.left_s);
    return at.total ? (at.step - 1 + at.done / at.total) / at.of : null;
  }

  const minutes = (s) => (s < 90 ? `${Math.max(5, 5 * Math.round(s / 5))} s` : `${Math.round(s / 60)} min`);

  function built(message) {
    build = message;
    const [on, box] = [message.state === "running" || message.state === "stopping", get("building")];
    if (message.state === "idle") {
      get("stop").hidden = true;
      get("bar").hidden = true;
      return;
    }
    box.hidden = false;
    get("bar").hidden = false;
    get("stop").hidden = !on;
    get("build").disabled = on;
    get("build-state").textContent = message.state;
    get("build-state").className = `chip ${on ? "running" : message.state === "built" ? "built" : "failed"}`;
    get("build-time").textContent = `${Math.round(message.took_s)} s`;
    const over = on ? share(message) : 1;
    get("bar").className = over === null ? "running" : on ? "" : message.state === "built" ? "done" : "over";
    get("bar").firstElementChild.style.width = over === null ? "" : `${100 * over}%`;
    const side = message.facts.cube_side_mm;
    const won = message.state === "built" && side ? `cube ${side.toFixed(2)} mm, ${message.facts.motor} at ${message.facts.ratio}:1, all checks pass` : "";
    get("build-now").textContent = on ? message.verdict || step(message) : won || message.verdict || message.error || message.now;
    const { left_s: left, best } = message.at;
    const more = [best && `best so far ${best}`, left !== undefined && `about ${minutes(left)} left`, message.now];
    get("build-doing").textContent = on ? more.filter(Boolean).join(" · ") : "";
    get("build-lines").replaceChildren();
    for (const line of [...message.lines].reverse()) node(get("build-lines"), "li", "", line);
    status();
  }

  // Connection.
  const receivers = {
    you: (message) => (viewer = message.viewer),
    hello: begin,
    state: take,
    answer: show,
    nothing: show,
    details,
    front,
    hardware: others,
    relief,
    parts: (message) => {
      parts = message;
      status();
    },
    doing: (message) => {
      doing = message.text;
      status();
    },
    solids: machine,
    build: built,
    say: (message) => {
      if (message.kind === "error" && message.by[0] && message.by[0] !== viewer) return;
      say(message.kind, message.text);
      if (message.kind === "error" && state) take(state);
    },
  };

  function connect() {
    socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[?#].*$/, ""), "delta-studio");
    socket.addEventListener("message", ({ data }) => {
      const message = JSON.parse(data);
      receivers[message.type]?.(message);
    });
    socket.addEventListener("open", () => {
      document.body.dataset.ready = "connected";
      get("said").hidden = true;
      flush();
    });
    socket.addEventListener("close", () => {
      document.body.dataset.ready = "";
      say("error", "the studio has ended, or cannot be reached: what you set stays here");
      setTimeout(connect, 2000);
    });
  }

  get("ratio").addEventListener("input", () => {
    held = "ratio";
    get("ratio-value").textContent = `${Number(get("ratio").value).toFixed(2)} : 1`;
    set({ hardware: { ratio: Number(get("ratio").value) }, rest: false });
  });
  get("width").addEventListener("input", () => {
    held = "width";
    get("width-value").textContent = `${Number(get("width").value).toFixed(1)} mm`;
    set({ hardware: { width_mm: Number(get("width").value) }, rest: false });
  });
  for (const [id, name] of [["ratio", "ratio"], ["width", "width_mm"]]) {
    get(id).addEventListener("change", () => {
      held = "";
      set({ hardware: { [name]: Number(get(id).value) }, rest: true });
    });
  }
  get("motor").addEventListener("change", () => {
    const [motor, drive] = get("motor").value.split("|");
    set({ hardware: { motor, drive }, rest: true });
  });
  get("placed").addEventListener("change", () => set({ hardware: { placed: get("placed").checked }, rest: true }));
  get("save").addEventListener("click", () => send({ type: "save" }));
  get("reset").addEventListener("click", () => send({ type: "reset" }));
  get("build").addEventListener("click", () => send({ type: "build" }));
  get("stop").addEventListener("click", () => send({ type: "stop" }));
  for (const name of ["body", "solids", "cube"]) {
    get(`show-${name}`).addEventListener("change", (event) => {
      scene.shown[name] = event.target.checked;
      scene.look();
      status();
    });
  }
  get("moving").addEventListener("change", (event) => scene.move(event.target.checked));
  setInterval(() => {
    if (build.state === "running" && build.took_s !== undefined) get("build-time").textContent = `${Math.round((build.took_s += 1))} s`;
  }, 1000);
  window.studio = { answers, state: () => ({ answered, detailed, state, build, seq }) }; // for who tests the page
  scene.begin().then(connect);
})();
