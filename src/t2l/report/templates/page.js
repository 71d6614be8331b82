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
// 1, 2, 5 times powers of ten between two logarithms, or the powers alone where those are many
function decades(low, high) {
  const ticks = [], steps = high - low > 2.2 ? [1] : high - low > 1.2 ? [1, 3] : [1, 2, 5];
  for (let e = Math.floor(low); e <= high; e++) for (const m of steps) {
    const v = Math.log10(m) + e;
    if (v >= low - 1e-6 && v <= high + 1e-6) ticks.push(v);
  }
  return ticks;
}
const power = v => digits(10 ** v, 1);
const narrow = () => window.innerWidth < 600;

function layout(extra) {
  const axis = { gridcolor: RULE, zerolinecolor: "#c3cad2", linecolor: "#c3cad2", automargin: true,
    ticks: "outside", tickcolor: "#c3cad2", ticklen: 4 };
  const titled = value => value.title ? { title: { font: { size: 13 }, ...value.title } } : {};
  const base = {
    font: { family: "system-ui, -apple-system, Segoe UI, Roboto, Arial, sans-serif", size: 13, color: INK },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", height: 380,
    margin: { l: 60, r: 16, t: 12, b: 48 }, hovermode: "closest",
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
  };
  for (const [key, value] of Object.entries(extra))
    base[key] = /^[xy]axis/.test(key) ? { ...axis, ...value, ...titled(value) } : value;
  return base;
}

const PLOTS = {
  falling() {
    const f = data.falling, line = (y, name, colour, dash) => ({ x: f.names, y, name, mode: "lines+markers",
      line: { color: colour, width: 2.5, dash }, marker: { size: 9 },
      hovertemplate: "%{x}<br>" + name + " %{y:.3g} mrad<extra></extra>" });
    const all = [...f.train, ...f.test, f.floor].filter(v => v > 0).map(Math.log10);
    const low = Math.min(...all) - 0.15, high = Math.max(...all) + 0.12, ticks = decades(low, high);
    return [[line(f.test, "test", BLUE), line(f.train, "training", SKY, "dot")],
      layout({ height: 340,
        xaxis: { type: "category", range: [-0.3, f.names.length - 0.7] },
        yaxis: { type: "log", title: { text: "RMS position error [mrad]" },
          range: [low, high], tickvals: ticks.map(v => 10 ** v), ticktext: ticks.map(power) },
        shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: f.floor, y1: f.floor,
          line: { color: INK, width: 1.5, dash: "dash" } }],
        annotations: [{ xref: "paper", x: 0.01, xanchor: "left", yanchor: "bottom", showarrow: false,
          y: Math.log10(f.floor), text: `noise floor ${digits(f.floor)} mrad` }] })];
  },

  curve(_, element) {
    const c = data.curves[element.dataset.number];
    const at = floats(c.at), low = floats(c.low), high = floats(c.high);
    const edge = y => ({ x: at, y, mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false });
    return [[edge(low), { ...edge(high), fill: "tonexty", fillcolor: BLUE + "33", name: "95 % band", showlegend: true },
      { x: at, y: floats(c.torque), mode: "lines", name: "learned torque", line: { color: BLUE, width: 2.5 },
        hovertemplate: `%{x:.4g}<br>%{y:.4g}${c.torque_unit}<extra></extra>` }],
      layout({ height: 320, xaxis: { title: { text: c.title } },
        yaxis: { title: { text: c.torque_title }, zeroline: true } })];
  },

  ranking(_, element) {
    const entries = data.rankings[element.dataset.step].slice().reverse();
    const kinds = { best: [data.falling ? "adopted" : "ranked first", BLUE], tied: ["explains as well", YELLOW], other: ["other candidates", GREY] };
    const low = Math.max(-40, Math.min(0, ...entries.map(e => Math.min(e.improvement, e.ci95[0]))) - 4);
    const traces = Object.entries(kinds).map(([kind, [name, colour]]) => {
      const own = entries.filter(e => e.kind === kind);
      // what lies left of the axis is drawn at its edge
      const inside = v => Math.max(v, low);
      return { name, mode: "markers", cliponaxis: false, y: own.map(e => e.title), x: own.map(e => inside(e.improvement)),
        marker: { color: colour, size: 10,
          symbol: own.map(e => e.improvement < low ? "triangle-left" : "circle") },
        error_x: { type: "data", symmetric: false, color: colour, thickness: 2, width: 4,
          array: own.map(e => Math.max(0, e.ci95[1] - inside(e.improvement))),
          arrayminus: own.map(e => Math.max(0, inside(e.improvement) - inside(e.ci95[0]))) },
        customdata: own.map(e => [e.improvement, e.ci95[0], e.ci95[1]]),
        hovertemplate: "%{y}<br>%{customdata[0]:.1f} % (%{customdata[1]:.1f} to %{customdata[2]:.1f})<extra></extra>" };
    }).filter(t => t.x.length);
    return [traces, layout({ height: 110 + 24 * entries.length,
      margin: { l: 60, r: 16, t: 34, b: 48 },
      xaxis: { title: { text: narrow() ? "fall of the validation error [%]"
        : "fall of the validation error [%], with 95 % interval" }, range: [low, 102], zeroline: true },
      yaxis: { type: "category", categoryorder: "array", categoryarray: entries.map(e => e.title),
        range: [-0.7, entries.length - 0.3], ticks: "", dtick: 1,
        tickfont: { size: narrow() ? 11 : 13 } } })];
  },

  overlay(choice) {
    const o = data.overlays[choice.recording][choice.joint];
    const t = floats(o.time), measured = floats(o.measured);
    const traces = [
      { x: t, y: floats(o.command), name: "commanded", line: { color: GREY, width: 1, shape: "hv" } },
      { x: t, y: measured, name: "measured", line: { color: BLACK, width: 2 } }];
    o.simulated.forEach((packed, i) => {
      const q = floats(packed);
      traces.push({ x: t, y: q, name: data.models[i], line: { color: MODEL[i], width: 2, dash: i ? "solid" : "4px,2px" } });
      traces.push({ x: t, y: measured.map((v, k) => 1e3 * (v - q[k])), yaxis: "y2", showlegend: false,
        name: data.models[i], line: { color: MODEL[i], width: 1.5 },
        hovertemplate: "%{x:.3f} s<br>%{y:.3g} mrad<extra></extra>" });
    });
    for (const trace of traces) {
      trace.mode = "lines";
      trace.hovertemplate ??= "%{x:.3f} s<br>%{y:.5f} rad<extra>" + trace.name + "</extra>";
    }
    return [traces, layout({ height: 520, margin: { l: 60, r: 16, t: 40, b: 48 },
      xaxis: { title: { text: "time [s]" }, anchor: "y2" },
      yaxis: { title: { text: "position [rad]" }, domain: [0.4, 1] },
      yaxis2: { title: { text: "error [mrad]" }, domain: [0, 0.33], zeroline: true } })];
  },

  cells(choice, element) {
    const joint = Number(choice.joint), model = Number(element.dataset.model);
    const own = m => data.cells[m].filter(c => c[0] === joint);
    const values = data.cells.flatMap((_, m) => own(m).map(c => c[3])).filter(v => v > 0).map(Math.log10);
    const low = Math.min(...values), high = Math.max(low + 0.05, ...values);
    const list = i => [...new Set(own(model).map(c => c[i]))].sort((a, b) => a - b);
    const kp = list(1), kd = list(2);
    // as they are told above: gains that were computed have many digits
    const gain = v => String(Number(v.toPrecision(6)));
    const z = kd.map(() => kp.map(() => null)), text = kd.map(() => kp.map(() => ""));
    for (const [, p, d, v] of own(model)) {
      z[kd.indexOf(d)][kp.indexOf(p)] = Math.log10(v);
      text[kd.indexOf(d)][kp.indexOf(p)] = digits(v, 2);
    }
    const ticks = decades(low, high);
    return [[{ type: "heatmap", x: kp.map(gain), y: kd.map(gain), z, text, xgap: 1, ygap: 1,
      texttemplate: "%{text}", textfont: { size: 12 }, colorscale: MAGMA,
      zmin: low - 0.08 * (high - low), zmax: high + 0.2 * (high - low), hoverongaps: false,
      hovertemplate: "Kp %{x}, Kd %{y}<br>%{text} mrad<extra></extra>",
      colorbar: { title: { text: "mrad", side: "top" }, thickness: 12, outlinewidth: 0, len: 0.9,
        tickvals: ticks, ticktext: ticks.map(power) } }],
      layout({ height: 130 + 40 * Math.max(4, kd.length), margin: { l: 50, r: 8, t: 30, b: 48 },
        title: { text: data.models.length > 1 ? data.models[model] : "", font: { size: 13 }, x: 0.08, y: 0.98 },
        xaxis: { type: "category", title: { text: "stiffness Kp [N·m/rad]" }, showgrid: false, ticks: "" },
        yaxis: { type: "category", title: { text: "damping Kd [N·m·s/rad]" }, showgrid: false, ticks: "" } })];
  },

  conditions(choice) {
    const joint = Number(choice.joint), condition = data.conditions[choice.condition];
    const key = choice.quantity, traces = [];
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
      traces.push({ x: spread, y, mode: "markers", name: data.models[i] + ", samples", legendgroup: i, hoverinfo: "skip",
        showlegend: false, marker: { color: MODEL[i], size: 3.5, opacity: 0.22 } });
    });
    data.clouds.forEach((clouds, i) => {
      const [x, y] = clouds[joint].over[condition.name][key].map(floats);
      traces.push({ x, y, mode: "lines+markers", name: data.models[i] + ", mean", legendgroup: i,
        line: { color: MODEL[i], width: 2.5 }, marker: { size: 7, line: { color: "white", width: 1 } },
        hovertemplate: "%{x:.3g} " + condition.unit + "<br>%{y:.3g} " + (key === "error" ? "mrad" : "N·m") + "<extra></extra>" });
    });
    const low = Math.min(...extremes), high = Math.max(...extremes), room = 0.06 * (high - low) || 1;
    const left = Math.min(...sides), right = Math.max(...sides), beside = 0.03 * (right - left) || 1;
    const named = condition.name === "direction"
      ? { tickvals: [-1, 0, 1], ticktext: ["negative", "at rest", "positive"], range: [-1.5, 1.5] }
      : { range: [left - beside, right + beside] };
    return [traces, layout({ height: 420, margin: { l: 60, r: 16, t: 36, b: 48 },
      xaxis: { title: { text: condition.name + (condition.unit ? ` [${condition.unit}]` : "") }, zeroline: true, ...named },
      yaxis: { title: { text: key === "error" ? "position error [mrad]" : "missing torque [N·m]" },
        range: [low - room, high + room], zeroline: true } })];
  },

  spectrum(choice) {
    const traces = data.spectra.map((joints, i) => {
      const [x, y] = joints[choice.joint].map(floats);
      return { x, y, mode: "lines", name: data.models[i], line: { color: MODEL[i], width: 2 },
        hovertemplate: "%{x:.3g} Hz<br>%{y:.3g} mrad/√Hz<extra></extra>" };
    });
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
      xaxis: axis("x", "frequency [Hz]"), yaxis: axis("y", "position error [mrad/√Hz]") })];
  },
};

const drawn = new Set();
function draw(element) {
  const choice = {};
  for (const select of document.querySelectorAll(`select[data-for="${element.dataset.plot}"]`))
    choice[select.dataset.key] = select.value;
  const [traces, arrangement] = PLOTS[element.dataset.plot](choice, element);
  const config = { responsive: true, displayModeBar: false };
  return Plotly.react(element, traces, arrangement, config).then(() => {
    drawn.add(element);
    body.dataset.plotsDrawn = drawn.size;
  });
}

const elements = [...document.querySelectorAll("[data-plot]")];
body.dataset.plots = elements.length;
elements.reduce((before, element) => before.then(() => draw(element)), Promise.resolve())
  .catch(error => { body.dataset.errors = Number(body.dataset.errors) + 1; console.error(error); });
for (const select of document.querySelectorAll("select[data-for]"))
  select.addEventListener("change", () => {
    for (const element of elements) if (element.dataset.plot === select.dataset.for) draw(element);
  });
