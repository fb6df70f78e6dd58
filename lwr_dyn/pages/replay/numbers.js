// Numbers of the page: packed series, the sample at a time, text of a number, and elements created in one line.
"use strict";

function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (letter) => letter.charCodeAt(0));
  const integers = new Int32Array(bytes.buffer);
  return Float64Array.from(integers, (value) => value * packed.step);
}

function rowsOf(packed) {
  const flat = unpack(packed), width = packed.shape[1], rows = [];
  for (let i = 0; i < packed.shape[0]; i += 1) rows.push(flat.subarray(i * width, (i + 1) * width));
  return rows;
}

function lastAtMost(times, t) {
  let low = -1, high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

// The run at a time: its samples, and straight lines between them.
function sampleAt(run, time) {
  const last = run.t.length - 1, k = Math.min(Math.max(lastAtMost(run.t, time), 0), Math.max(last - 1, 0)), next = Math.min(k + 1, last);
  const span = run.t[next] - run.t[k], part = span > 0 ? Math.min(Math.max((time - run.t[k]) / span, 0), 1) : 0;
  const blend = (series, width) => Float64Array.from({ length: width }, (_, j) => {
    const a = series[k * width + j];
    return a + part * (series[next * width + j] - a);
  });
  return { q: blend(run.q, run.n), qRef: blend(run.qRef, run.n), tipError: blend(run.tipError, 1)[0] };
}

function plainNumber(value) {
  const size = Math.abs(value);
  if (size < 1e-6) return "0"; // below the precision of the packing, in thousandths
  if (size < 1e-3) return value.toExponential(1);
  return value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}

// A colour of the look, such as ink("run1"), as it is in the present scheme.
const inkProbe = document.createElement("span");
inkProbe.hidden = true;
function ink(token) {
  if (!inkProbe.isConnected) document.body.append(inkProbe);
  inkProbe.style.color = `var(--${token})`;
  return getComputedStyle(inkProbe).color;
}

// The token of a run's colour: four hues, then grey.
const runToken = (record) => `run${Math.min(record.place, 4) + 1}`;

// Two or more round values within [low, high], about `most` of them.
function roundTicks(low, high, most) {
  const rough = (high - low) / most, scale = 10 ** Math.floor(Math.log10(rough));
  const steps = [10, 5, 2, 1, 0.5, 0.2, 0.1].map((step) => step * scale);
  const within = (step) => {
    const ticks = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k += 1) ticks.push(k * step);
    return ticks;
  };
  return within(steps.find((step) => within(step).length >= Math.max(2, Math.min(3, most))) ?? steps[6]);
}

function element(tag, className = "", text = "") {
  const node = document.createElement(tag);
  node.className = className;
  node.textContent = text;
  return node;
}
