// Numbers as text, and out of a field. What changes at every frame is written only where it reads otherwise than before, and without new
// nodes.

// Writes numbers into as many cells, each with so many decimals; a zero has no sign.
function numberWriter(cells, digits) {
  const scale = 10 ** digits, last = new Float64Array(cells.length).fill(NaN), nodes = Array.from(cells, textNode);
  return (values) => {
    for (let k = 0; k < nodes.length; k += 1) {
      const whole = Math.round(values[k] * scale);
      if (whole === last[k]) continue;
      last[k] = whole;
      nodes[k].data = (whole / scale).toFixed(digits);
    }
  };
}

// Shades cells by size: the largest of the numbers full, negative ones in another colour; in thirty steps.
function shadeWriter(cells) {
  const last = new Int8Array(cells.length).fill(99), styles = Array.from(cells, (cell) => cell.style);
  return (values) => {
    let most = 0;
    for (let k = 0; k < values.length; k += 1) most = Math.max(most, Math.abs(values[k]));
    for (let k = 0; k < styles.length; k += 1) {
      const step = most === 0 ? 0 : Math.round((30 * values[k]) / most);
      if (step === last[k]) continue;
      last[k] = step;
      styles[k].background = shades[step + 30] ??= `color-mix(in srgb, var(--${step < 0 ? "run2" : "run1"}) ${Math.abs(step)}%, transparent)`;
    }
  };
}
const shades = [];

// Text of a cell.
function put(cell, text) {
  const node = cell.firstChild?.nodeType === 3 && cell.childNodes.length === 1 ? cell.firstChild : textNode(cell);
  if (node.data !== text) node.data = text;
}

// An attribute of an element.
function attributeWriter(element, name) {
  let last = null;
  return (text) => {
    if (text !== last) element.setAttribute(name, text);
    last = text;
  };
}

function textNode(cell) {
  const node = document.createTextNode("");
  cell.replaceChildren(node);
  return node;
}

// The number that stands in a field, with a point or a comma; NaN where there is none.
function numberIn(field) {
  const text = field.value.trim().replace(",", "."), value = text === "" ? NaN : Number(text);
  return Number.isFinite(value) ? value : NaN;
}

function round(value, digits) {
  const out = Number(value.toFixed(digits));
  return out === 0 ? 0 : out; // no minus zero
}

// At most `digits` decimals, no exponent and no zeros at the end.
function plain(value, digits) {
  const text = value.toFixed(digits);
  return text.includes(".") ? text.replace(/\.?0+$/, "").replace(/^-0$/, "0") : text;
}

// With so many decimals; a zero has no sign.
function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}
