"use strict";
// Draws every element with data-plot from the numbers in #data, and again when a choice changes.

const body = document.body;
window.addEventListener("error", () => { body.dataset.errors = Number(body.dataset.errors) + 1; });

const data = JSON.parse(document.getElementById("data").textContent);
const [BLUE, ORANGE, GREEN, PINK, YELLOW, SKY, BLACK] = data.colours;
const GREY = "#8a939d", RULE = "#e6e9ed", INK = "#1b1f24";
// matplotlib's magma_r, which the figures use
const MAGMA = [[0, "#fcfdbf"], [0.1, "#fecf92"], [0.2, "#fe9f6d"], [0.3, "#f7705c"], [0.4,
  "#de4968"], [0.5, "#b5367a"], [0.6, "#8c2981"], [0.7, "#641a80"], [0.8, "#3b0f70"], [0.9,
  "#140e36"], [1, "#000004"]];
// the model as it came is orange, the final one blue
const MODEL = data.models && data.models.length > 1 ? [ORANGE, BLUE] : [BLUE];

const floats = packed => new Float32Array(Uint8Array.from(atob(packed), c => c.charCodeAt(0)).buffer);
const digits = (x, n = 3) => x === 0 ? "0" : Number(x.toPrecision(n)).toString().replaceAll("-", "−");
// 1, 2, 5 times powers of ten between two logarithms; the powers alone where those are many, and all digits where few
function decades(low, high) {
  const ticks = [], steps = high - low > 2.2 ? [1] : high - low > 1.2 ? [1, 3]
    : high - low > 0.6 ? [1, 2, 5] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  for (let e = Math.floor(low); e <= high; e++) for (const m of steps) {
    const v = Math.log10(m) + e;
    if (v >= low - 1e-6 && v <= high + 1e-6) ticks.push(v);
  }
  return ticks;
}
const power = v => digits(10 ** v, 1);
const narrow = () => window.innerWidth < 600;
// Plotly reads tags in text, and names come from files that somebody sent
const plain = text => String(text).replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
// in lines of about so many characters
function lines(text, most) {
  const wrapped = [];
  for (const word of String(text).split(" ")) {
    const last = wrapped.length - 1;
    if (last >= 0 && (wrapped[last] + " " + word).length <= most) wrapped[last] += " " + word;
    else wrapped.push(word);
  }
  return wrapped.map(plain).join("<br>");
}
const HOVER_NAME = "<extra>%{fullData.name}</extra>";
const MODELS = (data.models || []).map(plain);
// motions lie on one another: of two models the first is dashed
const dashOf = model => MODEL.length > 1 && model === 0 ? "5px,2px" : "solid";

const BAR = 30;
function layout(extra) {
  const axis = { gridcolor: RULE, zerolinecolor: "#c3cad2", linecolor: "#c3cad2", automargin: true,
    ticks: "outside", tickcolor: "#c3cad2", ticklen: 4 };
  const titled = value => value.title ? { title: { font: { size: 13 }, ...value.title } } : {};
  const base = {
    font: { family: "system-ui, -apple-system, Segoe UI, Roboto, Arial, sans-serif", size: 13, color: INK },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", height: 380,
    margin: { l: 60, r: 16, t: 12, b: 48 }, hovermode: "closest",
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: "#59636e", activecolor: BLUE },
  };
  for (const [key, value] of Object.entries(extra))
    base[key] = /^[xy]axis/.test(key) ? { ...axis, ...value, ...titled(value) } : value;
  // above the legend there is room for the tool bar
  base.margin = { ...base.margin, t: base.margin.t + BAR };
  base.height += BAR;
  return base;
}

// Each returns traces, layout, and the numbers behind them: { columns, rows }, for a spreadsheet.
const PLOTS = {
  falling() {
    const f = data.falling, last = f.names.length - 1;
    const line = (y, name, colour, dash) => ({ x: y.map((_, i) => i), y, name, mode: "lines+markers",
      line: { color: colour, width: 2.5, dash }, marker: { size: 9 }, text: f.names.map(plain),
      hovertemplate: "%{text}<br>%{y:.3g} mrad" + HOVER_NAME });
    const all = [...f.train, ...f.test, f.floor].filter(v => v > 0).map(Math.log10);
    const low = Math.min(...all) - 0.15, high = Math.max(...all) + 0.12, ticks = decades(low, high);
    const floor = { x: [-0.4, last + 0.4], y: [f.floor, f.floor], name: `noise floor, ${digits(f.floor)} mrad`, mode: "lines",
      line: { color: INK, width: 1.5, dash: "dash" }, hoverinfo: "skip" };
    return [[line(f.test, "test", BLUE), line(f.train, "training", SKY, "dot"), floor],
      layout({ height: 340, margin: { l: 60, r: 16, t: 24, b: 48 },
        xaxis: { range: [-0.4, last + 0.4], tickvals: f.names.map((_, i) => i), zeroline: false,
          ticktext: f.names.map(name => lines(name, narrow() ? 10 : 20)) },
        yaxis: { type: "log", title: { text: "RMS position error [mrad]" },
          range: [low, high], tickvals: ticks.map(v => 10 ** v), ticktext: ticks.map(power) } }),
      { columns: ["model", "test error [mrad]", "training error [mrad]", "noise floor [mrad]"],
        rows: f.names.map((name, i) => [name, f.test[i], f.train[i], f.floor]) }];
  },

  curve(_, element) {
    const c = data.curves[element.dataset.number];
    const at = floats(c.at), low = floats(c.low), high = floats(c.high);
    const edge = y => ({ x: at, y, mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false });
    return [[edge(low), { ...edge(high), fill: "tonexty", fillcolor: BLUE + "33", name: "95 % band", showlegend: true },
      { x: at, y: floats(c.torque), mode: "lines", name: "learned curve", line: { color: BLUE, width: 2.5 },
        hovertemplate: `%{x:.4g}<br>%{y:.4g}${c.torque_unit}` + HOVER_NAME }],
      layout({ height: 320, margin: { l: 60, r: 16, t: 24, b: 48 }, xaxis: { title: { text: plain(c.title) } },
        yaxis: { title: { text: c.torque_title }, zeroline: true } }),
      { columns: [c.title, c.torque_title, "95 % band from", "to"],
        rows: Array.from(at, (x, i) => [x, floats(c.torque)[i], low[i], high[i]]) }];
  },

  front(_, element) {
    const f = data.fronts[element.dataset.number], places = f.names.map((_, i) => i);
    const marks = (own, name, look) => ({ x: own.map(i => f.numbers[i]), y: own.map(i => f.error[i]), name, mode: "markers",
      cliponaxis: false, marker: { size: 10, color: GREY, ...look }, text: own.map(i => lines(f.names[i], 40)),
      hovertemplate: "%{text}<br>%{x} numbers, %{y:.3g} mrad" + HOVER_NAME });
    const others = places.filter(i => i !== f.adopted);
    const first = Math.min(...f.numbers) - 0.6, last = Math.max(...f.numbers) + 0.6;
    const level = (y, name, color, dash, width) => ({ x: [first, last], y: [y, y], name: `${name}, ${digits(y)} mrad`,
      mode: "lines", line: { color, dash, width }, hoverinfo: "skip" });
    const traces = [level(f.before, "before", ORANGE, "solid", 1.5), level(data.falling.floor, "noise floor", INK, "dash", 1.5)];
    if (f.best.length > 1) traces.push({ x: f.best.map(i => f.numbers[i]), y: f.best.map(i => f.error[i]), name: "best so far",
      mode: "lines", line: { color: GREY, width: 1.5, shape: "hv" }, hoverinfo: "skip" });
    traces.push(marks(others.filter(i => !f.simulated[i]), "linear model only", { symbol: "circle-open" }),
      marks(others.filter(i => f.simulated[i]), "simulated", { symbol: "circle" }));
    if (f.adopted !== null) traces.push(marks([f.adopted], "adopted", { symbol: "circle", color: BLUE, size: 14 }));
    else if (f.adopted_error) traces.push(level(f.adopted_error, "adopted", BLUE, "solid", 2.5));
    const shown = traces.filter(t => t.x.length), all = shown.flatMap(t => t.y).filter(v => v > 0).map(Math.log10);
    const low = Math.min(...all) - 0.15, high = Math.max(...all) + 0.12, ticks = decades(low, high);
    // on a narrow screen the legend has three lines
    return [shown, layout({ height: narrow() ? 400 : 340, margin: { l: 60, r: 16, t: narrow() ? 72 : 24, b: 48 },
      xaxis: { title: { text: "numbers fitted" }, range: [first, last], zeroline: false, tickformat: "d",
        ...(last - first < 12 ? { dtick: 1 } : {}) },
      yaxis: { type: "log", title: { text: narrow() ? "left-out error [mrad]" : "RMS error on what was left out [mrad]" },
        range: [low, high], tickvals: ticks.map(v => 10 ** v), ticktext: ticks.map(power) } }),
      { columns: ["set", "numbers", "error on what was left out [mrad]", "judged by", "adopted"],
        rows: places.map(i => [f.names[i], f.numbers[i], f.error[i], f.simulated[i] ? "simulation" : "linear model", i === f.adopted ? "yes" : "no"]) }];
  },

  ranking() {
    const given = data.ranking, entries = given.slice().reverse();
    const low = Math.max(-40, Math.min(0, ...entries.map(e => Math.min(e.improvement, e.ci95[0]))) - 4);
    // what lies left of the axis is drawn at its edge, with a mark of its own
    const off = e => e.improvement < low, inside = v => Math.max(v, low);
    const kinds = [
      ["ranked first", BLUE, "circle", e => e.kind === "best" && !off(e)],
      ["explains as well", YELLOW, "circle", e => e.kind === "tied" && !off(e)],
      ["other candidates", GREY, "circle", e => e.kind === "other" && !off(e)],
      ["by the linear model only", GREY, "circle-open", e => e.kind === "linear" && !off(e)],
      [`worse than ${digits(low)} %`, GREY, "triangle-left", off]];
    const traces = kinds.map(([name, color, symbol, belongs]) => {
      const own = entries.filter(belongs);
      return { name, mode: "markers", cliponaxis: false, y: own.map(e => entries.indexOf(e)), x: own.map(e => inside(e.improvement)),
        marker: { color, symbol, size: 10 },
        error_x: { type: "data", symmetric: false, color, thickness: 2, width: 4,
          array: own.map(e => Math.max(0, e.ci95[1] - inside(e.improvement))),
          arrayminus: own.map(e => Math.max(0, inside(e.improvement) - inside(e.ci95[0]))) },
        customdata: own.map(e => [e.improvement, e.ci95[0], e.ci95[1], plain(e.title)]),
        hovertemplate: "%{customdata[3]}<br>%{customdata[0]:.1f} % (%{customdata[1]:.1f} to %{customdata[2]:.1f})" + HOVER_NAME };
    }).filter(t => t.x.length);
    return [traces, layout({ height: 110 + 24 * entries.length, margin: { l: 60, r: 16, t: 34, b: 48 },
      xaxis: { title: { text: narrow() ? "fall of the left-out error [%]"
        : "fall of the error on what is left out [%], with 95 % interval" }, range: [low - 0.025 * (102 - low), 102], zeroline: true },
      yaxis: { tickvals: entries.map((_, i) => i), ticktext: entries.map(e => narrow() ? lines(e.title, 22) : plain(e.title)),
        range: [-0.7, entries.length - 0.3], ticks: "", zeroline: false, tickfont: { size: narrow() ? 11 : 13 } } }),
      { columns: ["effect", "fall of the error on what is left out [%]", "95 % interval from", "to", "kind"],
        rows: given.map(e => [e.title, e.improvement, ...e.ci95, e.kind]) }];
  },

  overlay(choice) {
    const o = data.overlays[choice.recording][choice.joint];
    const t = floats(o.time), measured = floats(o.measured), command = floats(o.command);
    const traces = [
      { x: t, y: command, name: "commanded", line: { color: GREY, width: 1, shape: "hv" } },
      { x: t, y: measured, name: "measured", line: { color: BLACK, width: 2 } }];
    const columns = ["time [s]", "commanded [rad]", "measured [rad]"], numbers = [t, command, measured];
    o.simulated.forEach((packed, i) => {
      const q = floats(packed), error = Array.from(measured, (v, k) => 1e3 * (v - q[k]));
      const look = { name: MODELS[i], legendgroup: i };
      traces.push({ ...look, x: t, y: q, line: { color: MODEL[i], width: 2, dash: dashOf(i) } });
      traces.push({ ...look, x: t, y: error, yaxis: "y2", showlegend: false,
        line: { color: MODEL[i], width: 1.5, dash: dashOf(i) }, hovertemplate: "%{x:.3f} s<br>%{y:.3g} mrad" + HOVER_NAME });
      columns.push(`${data.models[i]} [rad]`, `error of the ${data.models[i]} [mrad]`);
      numbers.push(q, error);
    });
    for (const trace of traces) {
      trace.mode = "lines";
      trace.hovertemplate ??= "%{x:.3f} s<br>%{y:.5f} rad" + HOVER_NAME;
    }
    return [traces, layout({ height: 520, margin: { l: 60, r: 16, t: 40, b: 48 },
      xaxis: { title: { text: "time [s]" }, anchor: "y2" },
      yaxis: { title: { text: "position [rad]" }, domain: [0.4, 1] },
      yaxis2: { title: { text: "error [mrad]" }, domain: [0, 0.33], zeroline: true } }),
      { columns, rows: Array.from(t, (_, k) => numbers.map(values => values[k])) }];
  },

  cells(choice, element) {
    const joint = Number(choice.joint), model = Number(element.dataset.model);
    const own = m => data.cells[m].filter(c => c[0] === joint);
    const [low, high] = data.cell_limits[joint].map(Math.log10);
    const list = i => [...new Set(own(model).map(c => c[i]))].sort((a, b) => a - b);
    const kp = list(1), kd = list(2);
    // as they are told above: gains that were computed have many digits
    const gain = v => String(Number(v.toPrecision(6)));
    const z = kd.map(() => kp.map(() => null)), text = kd.map(() => kp.map(() => ""));
    for (const [, p, d, v] of own(model)) {
      z[kd.indexOf(d)][kp.indexOf(p)] = v > 0 ? Math.log10(v) : low;
      text[kd.indexOf(d)][kp.indexOf(p)] = digits(v, 2);
    }
    const ticks = decades(low, high);
    return [[{ type: "heatmap", x: kp.map(gain), y: kd.map(gain), z, text, xgap: 1, ygap: 1,
      texttemplate: "%{text}", textfont: { size: 12 }, colorscale: MAGMA,
      zmin: low, zmax: high + 0.2 * (high - low), hoverongaps: false,
      hovertemplate: "Kp %{x}, Kd %{y}<br>%{text} mrad<extra></extra>",
      colorbar: { title: { text: "mrad", side: "top" }, thickness: 12, outlinewidth: 0, len: 1,
        tickvals: ticks, ticktext: ticks.map(power) } }],
      layout({ height: 130 + 40 * Math.max(4, kd.length), margin: { l: 50, r: 8, t: 34, b: 48 },
        title: { text: MODELS.length > 1 ? MODELS[model] : "", font: { size: 13 }, x: 0, xref: "paper", xanchor: "left",
          y: 1, yref: "paper", yanchor: "bottom", pad: { b: 8 } },
        xaxis: { type: "category", title: { text: "stiffness Kp [N·m/rad]" }, showgrid: false, ticks: "" },
        yaxis: { type: "category", title: { text: "damping Kd [N·m·s/rad]" }, showgrid: false, ticks: "" } }),
      { columns: ["model", "joint", "Kp [N·m/rad]", "Kd [N·m·s/rad]", "RMS error [mrad]"],
        rows: own(model).map(([j, ...rest]) => [data.models[model], j < 0 ? "all" : data.joints[j], ...rest]) }];
  },

  conditions(choice) {
    const joint = Number(choice.joint), condition = data.conditions[choice.condition];
    const key = choice.quantity, traces = [], rows = [];
    const across = condition.label + (condition.unit ? ` [${condition.unit}]` : "");
    const up = key === "error" ? "position error [mrad]" : "missing torque [N·m]";
    const extremes = [], sides = [];
    const middle = (values, part) => {
      const sorted = values.slice().sort(), last = sorted.length - 1;
      return [sorted[Math.floor(part * last)], sorted[Math.ceil((1 - part) * last)]];
    };
    data.clouds.forEach((clouds, i) => {
      const cloud = clouds[joint], over = cloud.over[condition.name];
      const y = floats(cloud[key]);
      const x = floats(over.x);
      extremes.push(...middle(y, 0.005));
      sides.push(...middle(x, 0.003));
      const spread = condition.name === "direction" ? x.map((v, k) => v + 0.36 * (((k * 0.618) % 1) - 0.5)) : x;
      const dots = { mode: "markers", name: MODELS[i] + ", samples", legendgroup: `samples ${i}`, hoverinfo: "skip" };
      traces.push({ ...dots, x: spread, y, showlegend: false, marker: { color: MODEL[i], size: 3.5, opacity: 0.22 } });
      // their mark in the legend, where so small and pale a dot could not be seen
      traces.push({ ...dots, x: [null], y: [null], marker: { color: MODEL[i], size: 6, opacity: 0.5 } });
      x.forEach((v, k) => rows.push([data.models[i] + ", sample", v, y[k]]));
    });
    data.clouds.forEach((clouds, i) => {
      const [x, y] = clouds[joint].over[condition.name][key].map(floats);
      traces.push({ x, y, mode: "lines+markers", name: MODELS[i] + ", mean",
        line: { color: MODEL[i], width: 2.5 }, marker: { size: 7, line: { color: "white", width: 1 } },
        hovertemplate: "%{x:.3g} " + condition.unit + "<br>%{y:.3g} " + (key === "error" ? "mrad" : "N·m") + HOVER_NAME });
      x.forEach((v, k) => rows.push([data.models[i] + ", mean", v, y[k]]));
    });
    const low = Math.min(...extremes), high = Math.max(...extremes), room = 0.06 * (high - low) || 1;
    const left = Math.min(...sides), right = Math.max(...sides), beside = 0.03 * (right - left) || 1;
    const named = condition.name === "direction"
      ? { tickvals: [-1, 0, 1], ticktext: ["negative", "at rest", "positive"], range: [-1.5, 1.5] }
      : { range: [left - beside, right + beside] };
    return [traces, layout({ height: 420, margin: { l: 60, r: 16, t: 36, b: 48 },
      xaxis: { title: { text: across }, zeroline: true, ...named },
      yaxis: { title: { text: up }, range: [low - room, high + room], zeroline: true } }),
      { columns: ["series", across, up], rows }];
  },

  spectrum(choice) {
    const traces = data.spectra.map((joints, i) => {
      const [x, y] = joints[choice.joint].map(floats);
      return { x, y, mode: "lines", name: MODELS[i], line: { color: MODEL[i], width: 2 },
        hovertemplate: "%{x:.3g} Hz<br>%{y:.3g} mrad/√Hz" + HOVER_NAME };
    });
    const rows = traces.flatMap((t, i) => Array.from(t.x, (f, k) => [data.models[i], f, t.y[k]]));
    if (data.noise_density) {
      const x = traces[0].x;
      traces.push({ x: [x[0], x[x.length - 1]], y: [data.noise_density, data.noise_density], mode: "lines",
        name: "noise floor", line: { color: INK, width: 1.5, dash: "dash" }, hoverinfo: "skip" });
    }
    const logs = key => traces.flatMap(t => Array.from(t[key])).filter(v => v > 0).map(Math.log10);
    const axis = (key, title) => {
      const values = logs(key), low = values.reduce((a, b) => Math.min(a, b)), high = values.reduce((a, b) => Math.max(a, b));
      const ticks = decades(low - 0.05, high + 0.05);
      return { type: "log", title: { text: title }, range: [low - 0.05, high + 0.05],
        tickvals: ticks.map(v => 10 ** v), ticktext: ticks.map(power) };
    };
    return [traces, layout({ height: 380, margin: { l: 60, r: 16, t: 36, b: 48 },
      xaxis: axis("x", "frequency [Hz]"), yaxis: axis("y", "position error [mrad/√Hz]") }),
      { columns: ["model", "frequency [Hz]", "position error [mrad/√Hz]"], rows }];
  },
};

function choiceFor(plot) {
  const choice = {};
  for (const select of document.querySelectorAll(`select[data-for="${plot}"]`)) choice[select.dataset.key] = select.value;
  return choice;
}
const drawn = new Set();
function draw(element) {
  const plot = element.dataset.plot;
  const [traces, arrangement] = PLOTS[plot](choiceFor(plot), element);
  const config = { responsive: true, displayModeBar: true, displaylogo: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: { format: "png", filename: plot, scale: 2 } };
  return Plotly.react(element, traces, arrangement, config).then(() => {
    drawn.add(element);
    body.dataset.plotsDrawn = drawn.size;
  });
}

function save(name, text, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: type + ";charset=utf-8" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
const quoted = value => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\n\r]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
};
const csv = ({ columns, rows }) => [columns, ...rows].map(row => row.map(quoted).join(",")).join("\n") + "\n";
for (const button of document.querySelectorAll("button.download"))
  button.addEventListener("click", () => save(button.dataset.file, data.files[button.dataset.file],
    button.dataset.file.endsWith(".json") ? "application/json" : "text/plain"));
for (const button of document.querySelectorAll("button.csv"))
  button.addEventListener("click", () => {
    const plots = [...button.closest("figure").querySelectorAll("[data-plot]")];
    const tables = plots.map(element => PLOTS[element.dataset.plot](choiceFor(element.dataset.plot), element)[2]);
    const name = plots[0].dataset.plot + (plots[0].dataset.number ?? "");
    save(`${name}.csv`, csv({ columns: tables[0].columns, rows: tables.flatMap(table => table.rows) }), "text/csv");
  });

const elements = [...document.querySelectorAll("[data-plot]")];
body.dataset.plots = elements.length;
elements.reduce((before, element) => before.then(() => draw(element)), Promise.resolve())
  .catch(error => { body.dataset.errors = Number(body.dataset.errors) + 1; console.error(error); });
for (const select of document.querySelectorAll("select[data-for]"))
  select.addEventListener("change", () => {
    for (const element of elements) if (element.dataset.plot === select.dataset.for) draw(element);
  });

// the contents show where the reader is
const links = new Map([...document.querySelectorAll("nav a")].map(link => [link.hash.slice(1), link]));
const places = [...document.querySelectorAll("h2[id]")];
function here() {
  const passed = places.filter(place => place.getBoundingClientRect().top < window.innerHeight / 3);
  for (const [id, link] of links) link.classList.toggle("here", id === passed.at(-1)?.id);
}
window.addEventListener("scroll", here, { passive: true });
here();
