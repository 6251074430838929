"use strict";
// What a page does besides being read: folds open on the way to their content and in print, and
// curves are drawn by uPlot once they can be seen.
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

let closed = [];
addEventListener("beforeprint", () => {
  closed = [...document.querySelectorAll("details:not([open])")];
  closed.forEach(one => { one.open = true; });
});
addEventListener("afterprint", () => closed.forEach(one => { one.open = false; }));

function shortNumber(value) {
  if (value == null) return "";
  if (value !== 0 && (value < 1e-3 || value >= 1e5)) return value.toExponential(2).replace("-", "−");
  return String(Number(value.toPrecision(3)));
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
function power(value) {
  const exponent = Math.floor(Math.log10(value) + 1e-9), front = value / 10 ** exponent;
  if (exponent > -3 && exponent < 5) return shortNumber(value);
  const raised = String(exponent).replace("-", "⁻").replace(/\d/g, d => "⁰¹²³⁴⁵⁶⁷⁸⁹"[d]);
  return (Math.abs(front - 1) < 1e-6 ? "" : shortNumber(front) + "·") + "10" + raised;
}

function draw(box, width) {
  const told = JSON.parse(box.querySelector("script").textContent);
  const series = [{ label: "frequency, Hz", value: (u, v) => v == null ? "–" : shortNumber(v) }], data = [told.x], bands = [];
  // the first curve last: it lies over all others
  for (const curve of [...told.curves.slice(1), told.curves[0]]) {
    if (curve.band) {
      const edge = { stroke: "transparent", width: 0, points: { show: false }, class: "band" };
      bands.push({ series: [series.length, series.length + 1], fill: curve.colour + "38" });
      data.push(...curve.band);
      series.push({ ...edge, label: curve.label + " +" }, { ...edge, label: curve.label + " −" });
    }
    data.push(curve.values);
    series.push({
      label: curve.label, class: curve === told.curves[0] ? "first" : "other", stroke: curve.colour, width: curve.width, dash: curve.dashed ? [6, 3] : undefined,
      points: { show: false }, value: (u, v) => shortNumber(v), banded: !!curve.band, colour: curve.colour,
    });
  }
  const top = Math.max(...told.curves.flatMap(c => c.values.filter(v => v != null)));
  const bottom = Math.min(...told.curves.flatMap(c => c.values.filter(v => v != null)));
  const font = "12px system-ui, sans-serif", axis = { font, labelFont: font, labelSize: 18, grid: { stroke: "#e3e3e3", width: 1 }, ticks: { show: false } };
  const chart = new uPlot({
    width, height: Math.round(Math.min(460, Math.max(260, 0.55 * width))),
    scales: {
      x: { time: false, distr: 3, range: (u, low, high) => [low, high] },
      y: { distr: 3, range: (u, low, high) => [Math.max(low ?? bottom, top / 1e9), high ?? top] },
    },
    series, bands,
    legend: { markers: { width: 0, fill: (u, index) => u.series[index].colour } },
    axes: [
      { ...axis, label: "frequency, Hz", splits: ticksOf, filter: (u, ticks) => ticks, values: (u, t) => t.map(power), size: 34 },
      { ...axis, label: told.unit, splits: ticksOf, filter: (u, ticks) => ticks, values: (u, t) => t.map(power), size: 52 },
    ],
    cursor: { drag: { x: true, y: true, uni: 30 } },
    hooks: {
      // a band goes with its curve
      setSeries: [(u, index, options) => {
        if (index == null || options.show == null || !u.series[index].banded) return;
        for (const edge of [index - 2, index - 1]) u.setSeries(edge, { show: options.show });
      }],
    },
  }, data, box);
  return chart;
}

if (window.uPlot) {
  const drawn = new Map();
  const watch = new ResizeObserver(entries => {
    for (const entry of entries) {
      const width = Math.floor(entry.contentRect.width), chart = drawn.get(entry.target);
      if (width < 50) continue;
      if (!chart) drawn.set(entry.target, draw(entry.target, width));
      else if (chart.width !== width) chart.setSize({ width, height: chart.height });
    }
  });
  document.querySelectorAll("div.chart").forEach(box => watch.observe(box));
}
