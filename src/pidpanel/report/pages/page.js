"use strict";
// What a page does besides being read: folds open on the way to their content, sections open in
// print (with the tables and figures that the reader has opened), and curves are drawn by uPlot
// once they can be seen or printed.
document.documentElement.classList.add("scripted");

function openAround(element) {
  for (let at = element; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
}
function openTarget() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  openAround(target);
  target.scrollIntoView();
}
addEventListener("hashchange", openTarget);
document.querySelectorAll('nav a').forEach(a => a.addEventListener("click", () => setTimeout(openTarget)));
openTarget();

let closed = [], printing = false;
addEventListener("beforeprint", () => {
  printing = true;
  closed = [...document.querySelectorAll("details.topic:not([open])")];
  closed.forEach(one => { one.open = true; });
  document.querySelectorAll("div.chart").forEach(box => { if (box.checkVisibility()) drawIn(box, printedWidth(box)); });
});
addEventListener("afterprint", () => {
  printing = false;
  closed.forEach(one => { one.open = false; });
  document.querySelectorAll("div.chart").forEach(drawSeen);
});

// a point of a drawing shows what belongs to it
function choose(link) {
  const box = link.closest(".choice"), name = link.getAttribute("href").slice(1);
  box.querySelectorAll(".option").forEach(part => part.classList.toggle("chosen", part.id === name));
  box.querySelectorAll("a").forEach(a => a.classList.toggle("chosen", a.getAttribute("href") === "#" + name));
}
document.querySelectorAll(".choice").forEach(box => {
  const links = box.querySelectorAll('svg a, .picks a');
  links.forEach(link => link.addEventListener("click", event => { event.preventDefault(); choose(link); }));
  if (links.length) choose(box.querySelector(".picks a"));
});

function shortNumber(value) {
  if (value == null) return "";
  const size = Math.abs(value), isPlain = value === 0 || (size >= 1e-3 && size < 1e5);
  return (isPlain ? String(Number(value.toPrecision(3))) : value.toExponential(2)).replaceAll("-", "−");
}
// ticks of a logarithmic axis that holds less than a decade, where uPlot has none or one
function ticksOf(u, axis, low, high) {
  if (high / low < 30) {
    const wanted = (high - low) / 5, power = 10 ** Math.floor(Math.log10(wanted));
    const step = power * [1, 2, 5, 10].find(s => s * power >= wanted), ticks = [];
    for (let n = Math.ceil(low / step); n * step <= high * 1.000001; n++) ticks.push(n * step);
    return ticks;
  }
  const steps = high / low < 1e4 ? [1, 2, 5] : [1], ticks = [];
  for (let p = Math.floor(Math.log10(low)); 10 ** p <= high; p++)
    for (const s of steps) if (s * 10 ** p >= low * 0.9999 && s * 10 ** p <= high * 1.0001) ticks.push(s * 10 ** p);
  return ticks;
}
// where a chart is narrow, the numbers that would run into the one before are left out
function spaced(u, ticks) {
  let end = -Infinity;
  return ticks.map(tick => {
    const at = u.valToPos(tick, "x"), half = 4 * power(tick).length;
    if (at - half < end) return null;
    end = at + half + 4;
    return tick;
  });
}
function power(value) {
  const exponent = Math.floor(Math.log10(value) + 1e-9), front = value / 10 ** exponent;
  if (exponent > -3 && exponent < 5) return shortNumber(value);
  const raised = String(exponent).replace("-", "⁻").replace(/\d/g, d => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);
  return (Math.abs(front - 1) < 1e-6 ? "" : shortNumber(front) + "·") + "10" + raised;
}

function draw(box, width) {
  const told = JSON.parse(box.querySelector("script").textContent);
  const series = [{ label: "frequency, Hz", class: "frequency", value: (u, v) => v == null ? "" : shortNumber(v) }], data = [told.x], bands = [];
  // the first curve last: it lies over all others
  for (const curve of [...told.curves.slice(1), told.curves[0]]) {
    if (curve.band) {
      const edge = { stroke: "transparent", width: 0, points: { show: false }, class: "band" };
      bands.push({ series: [series.length, series.length + 1], fill: curve.colour + "38" });
      data.push(...curve.band);
      series.push({ ...edge, label: curve.label + " +" }, { ...edge, label: curve.label + " −" });
    }
    const outside = curve.values.map(() => null);
    if (curve.outside.length) {  // dashed, up to the neighbours of what is inside
      for (let n = 0; n < curve.outside.length; n += 2)
        for (let k = Math.max(0, curve.outside[n] - 1); k <= curve.outside[n + 1] && k < outside.length; k++) outside[k] = curve.values[k];
      data.push(outside);
      series.push({ label: curve.label + " outside", class: "band", stroke: curve.colour, width: curve.width, dash: DASHES.dashed, points: { show: false } });
    }
    data.push(curve.values.map((v, k) => curve.outside.filter(end => end <= k).length % 2 ? null : v));
    series.push({
      label: curve.label, class: curve === told.curves[0] ? "first" : "other", stroke: curve.colour, width: curve.width, dash: DASHES[curve.line], line: curve.line,
      points: { show: false }, value: (u, v, s, k) => k == null ? "" : shortNumber(curve.values[k]), colour: curve.colour,
      parts: (curve.band ? 2 : 0) + (curve.outside.length ? 1 : 0),
    });
  }
  const top = Math.max(...told.curves.flatMap(c => c.values.filter(v => v != null)));
  const bottom = Math.min(...told.curves.flatMap(c => c.values.filter(v => v != null)));
  const font = "12px system-ui, sans-serif", axis = { font, labelFont: font, labelSize: 18, grid: { stroke: "#e3e3e3", width: 1 }, ticks: { show: false } };
  const chart = new uPlot({
    width, height: heightOf(width),
    scales: {
      x: { time: false, distr: 3, range: (u, low, high) => [low, high] },
      y: told.log ? { distr: 3, range: (u, low, high) => [Math.max(low ?? bottom, top / 1e9), high ?? top] }
        : top > bottom ? {} : { range: [bottom - 1, top + 1] },
    },
    series, bands,
    legend: { markers: {
      width: 3, fill: () => "transparent", stroke: (u, index) => u.series[index].colour,
      dash: (u, index) => u.series[index].line,
    } },
    axes: [
      { ...axis, label: "frequency, Hz", splits: ticksOf, filter: spaced, values: (u, t) => t.map(tick => tick == null ? "" : power(tick)), size: 34 },
      { ...axis, label: told.unit, size: 52, ...(told.log ? { splits: ticksOf, filter: (u, ticks) => ticks, values: (u, t) => t.map(power) } : { values: (u, t) => t.map(tick => String(Number(tick.toPrecision(6))).replace("-", "−")) }) },
    ],
    cursor: { drag: { x: true, y: true, uni: 30 } },
    hooks: {
      // no line of the legend for a frequency that nobody reads
      setCursor: [u => u.root.classList.toggle("read", u.cursor.idx != null)],
      // a band and what is outside the data go with their curve
      setSeries: [(u, index, options) => {
        if (index == null || options.show == null) return;
        nameOf(u, index).setAttribute("aria-pressed", options.show);
        for (let part = 1; part <= u.series[index].parts; part++) u.setSeries(index - part, { show: options.show });
      }],
    },
  }, data, box);
  for (let n = 1; n < series.length; n++) {
    const name = nameOf(chart, n);
    Object.assign(name, { tabIndex: 0, role: "button", ariaPressed: "true" });
    name.addEventListener("keydown", event => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      name.click();
    });
  }
  box.addEventListener("keydown", event => { if (event.target === box) press(chart, event); });
  return chart;
}

const DASHES = { dashed: [6, 3], dotted: [1.5, 3] };
function nameOf(chart, index) { return chart.root.querySelectorAll(".u-series")[index].querySelector("th"); }

// arrows read values, + and - zoom about the value that is read, 0 shows all
function press(chart, event) {
  const width = chart.over.clientWidth, all = chart.data[0], last = all[all.length - 1];
  const left = chart.cursor.left >= 0 ? chart.cursor.left : width / 2;
  const step = { ArrowLeft: -4, ArrowRight: 4 }[event.key], factor = { "+": 0.5, "-": 2, "−": 2 }[event.key];
  if (step) {
    chart.root.querySelector(".u-legend").setAttribute("aria-live", "polite");
    chart.setCursor({ left: Math.min(width - 1, Math.max(0, left + step)), top: chart.over.clientHeight / 2 });
  } else if (factor) {
    const { min, max } = chart.scales.x, middle = chart.posToVal(left, "x");
    const [low, high] = [min, max].map(end => middle * (end / middle) ** factor);
    chart.setScale("x", { min: Math.max(all[0], low), max: Math.min(last, high) });
  } else if (event.key === "0") {
    chart.setScale("x", { min: all[0], max: last });
  } else return;
  event.preventDefault();
}

const drawn = new Map();
function heightOf(width) { return Math.round(Math.min(460, Math.max(260, 0.55 * width))); }
function drawIn(box, width) {
  const chart = drawn.get(box);
  if (!chart) drawn.set(box, draw(box, width));
  else if (chart.width !== width) chart.setSize({ width, height: heightOf(width) });
}
function drawSeen(box) {
  const width = Math.floor(box.clientWidth);
  if (width >= 50 && !printing) drawIn(box, width);
}
// of A4 less its margins, whole or of two columns, before the zoom of printed charts: a window's
// width says nothing of the paper's
function printedWidth(box) { return (box.closest(".first, .pair") ? 338 : 700) / 0.7; }
if (window.uPlot) {
  const watch = new ResizeObserver(entries => entries.forEach(entry => drawSeen(entry.target)));
  document.querySelectorAll("div.chart").forEach(box => watch.observe(box));
}

// a surface in space as an eye sees it from afar, turned by dragging or arrow keys
document.querySelectorAll("figure.turned").forEach(box => {
  const { vertices, cells, colours, colour, points } = JSON.parse(box.querySelector("script").textContent);
  const canvas = box.querySelector("canvas"), pen = canvas.getContext("2d");
  let around = -0.9, above = 0.5, zoom = 1;
  function seen([x, y, z]) { // to the right, up, towards the eye
    const along = x * Math.sin(around) - y * Math.cos(around);
    return [x * Math.cos(around) + y * Math.sin(around), z * Math.cos(above) - along * Math.sin(above),
      z * Math.sin(above) + along * Math.cos(above)];
  }
  function paint() {
    const width = box.clientWidth, height = Math.min(460, Math.round(0.6 * width)), sharp = devicePixelRatio || 1;
    if (width < 50) return;
    [canvas.width, canvas.height] = [width * sharp, height * sharp];
    canvas.style.height = height + "px";
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    const scale = zoom * 0.95 * height, place = ([x, y]) => [width / 2 + scale * x, height / 2 - scale * y];
    const eyes = vertices.map(seen), depth = cells.map(cell => cell.reduce((sum, n) => sum + eyes[n][2], 0) / cell.length);
    for (const k of cells.map((_, k) => k).sort((a, b) => depth[a] - depth[b])) {
      const [a, b, c] = cells[k].map(n => eyes[n]), u = [0, 1, 2].map(i => b[i] - a[i]), v = [0, 1, 2].map(i => c[i] - a[i]);
      const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      pen.beginPath();
      cells[k].forEach(n => pen.lineTo(...place(eyes[n])));
      pen.closePath();
      pen.fillStyle = colours[colour[k]];
      pen.fill();
      pen.fillStyle = `rgba(0, 0, 0, ${0.35 * (1 - Math.abs(normal[2]) / Math.hypot(...normal))})`;
      pen.fill();
      pen.strokeStyle = "rgba(90, 90, 90, 0.5)"; pen.lineWidth = 0.5; pen.stroke();
    }
    const corner = [0.09 * height, 0.88 * height];
    [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
      const [x, y] = seen(axis).map(part => 0.07 * height * part);
      pen.beginPath(); pen.moveTo(...corner); pen.lineTo(corner[0] + x, corner[1] - y);
      pen.strokeStyle = "black"; pen.lineWidth = 1; pen.stroke();
      pen.fillStyle = "black"; pen.font = "13px sans-serif"; pen.fillText(name, corner[0] + 1.3 * x - 3, corner[1] - 1.3 * y + 4);
    });
    for (const [name, point] of Object.entries(points)) {
      const [x, y] = place(seen(point));
      pen.beginPath(); pen.arc(x, y, 3.5, 0, 7); pen.fillStyle = "white"; pen.fill(); pen.stroke();
      pen.fillStyle = "black"; pen.fillText(name, x + 6, y - 6);
    }
  }
  function turn(right, up) {
    around += right; above = Math.max(-1.57, Math.min(1.57, above + up));
    paint();
  }
  canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", event => { if (event.buttons) turn(-0.01 * event.movementX, 0.01 * event.movementY); });
  box.addEventListener("keydown", event => {
    const by = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    zoom *= { "+": 1.2, "-": 1 / 1.2, "−": 1 / 1.2 }[event.key] || 1;
    turn(...(by || [0, 0]));
    if (by) event.preventDefault();
  });
  new ResizeObserver(paint).observe(box);
});
