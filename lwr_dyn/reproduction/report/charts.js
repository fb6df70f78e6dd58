// The figures: each a plotly.js graph of one or more panels, laid out for the width it has and the colours of the page.

const DASHES = ["solid", "dash"];

// Plotly reads a few tags in its texts; what comes from data must stay text.
function plainText(text) {
  return String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

const RAISED = { "-": "\u207B", 0: "\u2070", 1: "\u00B9", 2: "\u00B2", 3: "\u00B3", 4: "\u2074" };

// A unit as it is set in print: s^2 with its exponent raised.
function raised(unit) {
  return unit.replace(/\^(-?[0-4])/g, (_, digits) => [...digits].map((digit) => RAISED[digit]).join(""));
}

function withUnit(label, unit) {
  return plainText(unit ? `${label} [${raised(unit)}]` : label);
}

class Chart {
  // `sources` gives the numbers of a curve: {x, y} of arrays; `palettes` are for light and dark pages.
  constructor(place, record, sources, palettes) {
    Object.assign(this, { place, record, palettes, id: record.id });
    this.graph = element("div", "graph");
    place.append(this.graph);
    this.panels = record.panels.map((panel) => ({ ...panel, curves: panel.curves.map((curve) => ({ ...curve, ...sources(curve, record) })) }));
    this.drawn = false;
    this.#reserve();
  }

  columns(width) {
    const { columns } = this.record;
    return Math.min(columns, this.panels.length, Math.max(1, Math.floor(width / 270)));
  }

  #reserve() {
    this.graph.style.minHeight = `${this.#sizes(this.place.clientWidth).height}px`;
  }

  #sizes(width) {
    const columns = this.columns(width), rows = Math.ceil(this.panels.length / columns);
    const side = width / columns - 60;
    const single = this.panels.length === 1;
    const panel = this.record.equal_aspect ? Math.min(460, side) : single ? 250 : columns > 1 ? 150 : 165;
    const top = 30, bottom = 54 + this.#legendRows(width) * 29, gap = this.record.over_time ? 28 : 62;
    return { columns, rows, panel, gap, top, bottom, height: top + rows * panel + (rows - 1) * gap + bottom };
  }

  #legendRows(width) {
    const names = this.legend();
    if (names.length < 2) return 0;
    const wide = Math.max(...names.map((name) => name.length)) * 7.2 + 44;
    return Math.ceil(names.length / Math.max(1, Math.floor((width - 28) / wide)));
  }

  legend() {
    return [...new Set(this.panels.flatMap((panel) => panel.curves.map((curve) => curve.label)))];
  }

  draw(width = this.place.clientWidth) {
    const { data, layout } = this.#figure(width);
    const touch = window.matchMedia("(pointer: coarse)").matches;
    layout.dragmode = touch ? false : "zoom"; // a finger scrolls the page until zoom is chosen in the bar
    const config = {
      displaylogo: false,
      displayModeBar: touch ? true : "hover",
      modeBarButtons: [["toImage"], ["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"]],
      toImageButtonOptions: { format: "svg", filename: this.id },
      showTips: false,
      plotlyServerURL: "",
    };
    Plotly.react(this.graph, data, layout, config);
    this.width = width;
    this.drawn = true;
    this.onDraw?.();
    if (this.graph.dataset.watched) return;
    this.graph.dataset.watched = "yes";
    this.graph.on("plotly_afterplot", () => this.onDraw?.());
  }

  #figure(width) {
    const sizes = this.#sizes(width), style = getComputedStyle(document.documentElement);
    const ink = (name) => style.getPropertyValue(name).trim();
    const palette = this.palettes[Number(ink("--dark"))];
    const colourOf = ({ colour, runColour }) => (colour === null ? runColour : palette[colour % palette.length]);
    const seen = new Set();
    const data = this.panels.flatMap((panel, p) => panel.curves.map((curve, c) => {
      const first = !seen.has(curve.label);
      seen.add(curve.label);
      return this.#trace(panel, p, curve, colourOf(curve), first);
    }));
    return { data, layout: this.#layout(width, sizes, ink) };
  }

  #trace(panel, p, curve, colour, first) {
    const axis = p === 0 ? "" : String(p + 1);
    const unit = panel.y_unit ? ` ${plainText(raised(panel.y_unit))}` : "", xUnit = this.record.x_unit ? ` ${plainText(raised(this.record.x_unit))}` : "";
    const name = plainText(curve.label);
    const together = this.#together();
    const point = curve.text.length ? "<b>%{text}</b><br>" : "";
    return {
      type: "scatter",
      mode: { line: "lines", points: "markers", both: "lines+markers" }[curve.style],
      x: curve.x, y: curve.y, name, legendgroup: name, showlegend: first && this.legend().length > 1,
      text: curve.text.map(plainText),
      line: { color: colour, width: 1.6, dash: DASHES[Number(curve.dashed)] },
      marker: { color: colour, size: 7 },
      ...(curve.is_filled ? { fill: "toself", fillcolor: `${colour}26`, hoveron: "points" } : {}),
      xaxis: `x${axis}`, yaxis: `y${axis}`,
      hovertemplate: together
        ? `${point}%{y:.5~g}${unit}<extra>${name}</extra>`
        : `${point}%{x:.5~g}${xUnit}, %{y:.5~g}${unit}<extra>${name}</extra>`,
    };
  }

  // Over time all curves of a panel tell their values at once.
  #together() {
    return this.record.over_time && Math.max(...this.panels.map((panel) => panel.curves.length)) <= 8;
  }

  #layout(width, sizes, ink) {
    const { columns, rows, panel, gap, top, bottom, height } = sizes;
    const left = 62, right = 14, inner = width - left - right, tall = height - top - bottom, between = columns > 1 ? 68 : 0;
    const wide = (inner - between * (columns - 1)) / columns;
    const layout = {
      width, height, margin: { l: left, r: right, t: top, b: bottom, autoexpand: false },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif", size: 12, color: ink("--ink") },
      hovermode: this.#together() ? "x unified" : "closest",
      hoverlabel: { bgcolor: ink("--card"), bordercolor: ink("--line"), font: { size: 12, color: ink("--ink") } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: ink("--soft"), activecolor: ink("--ink") },
      legend: { orientation: "h", x: -44 / inner, xanchor: "left", y: -46 / tall, yanchor: "top", font: { size: 12 } },
      annotations: [], shapes: [],
    };
    this.panels.forEach((one, p) => {
      const row = Math.floor(p / columns), column = p % columns, axis = p === 0 ? "" : String(p + 1);
      const x0 = column * (wide + between), y1 = tall - row * (panel + gap);
      const last = p + columns >= this.panels.length;
      const lines = { gridcolor: ink("--grid"), zerolinecolor: ink("--soft"), zerolinewidth: 0.8, linecolor: ink("--line"), ticks: "outside", ticklen: 4, tickcolor: ink("--line") };
      layout[`xaxis${axis}`] = {
        ...lines, domain: [x0 / inner, (x0 + wide) / inner], anchor: `y${axis}`, hoverformat: ".5~g", unifiedhovertitle: { text: `%{x:.5~g} ${plainText(raised(this.record.x_unit))}` },
        showticklabels: last || !this.record.over_time,
        title: { text: last || !this.record.over_time ? withUnit(this.record.x_label, this.record.x_unit) : "", standoff: 6 },
        ...(this.record.over_time && p > 0 ? { matches: "x" } : {}),
      };
      layout[`yaxis${axis}`] = {
        ...lines, domain: [(y1 - panel) / tall, y1 / tall].map((part) => Math.min(1, Math.max(0, part))), anchor: `x${axis}`,
        title: { text: withUnit(one.y_label, one.y_unit), standoff: 4 }, exponentformat: "e", nticks: 6,
        ...(this.record.equal_aspect ? { scaleanchor: `x${axis}`, scaleratio: 1 } : {}),
      };
      layout.annotations.push({
        text: `<b>${plainText(one.title)}</b>`, showarrow: false, x: 0, xanchor: "left", y: 1, yanchor: "bottom",
        xref: `x${axis} domain`, yref: `y${axis} domain`, font: { size: 12 }, yshift: 2,
      });
      one.levels.forEach((level) => this.#level(layout, level, axis, ink));
    });
    return layout;
  }

  #level(layout, { label, value, axis: along }, axis, ink) {
    const flat = along === "y";
    layout.shapes.push({
      type: "line", layer: "below", line: { color: ink("--limit"), width: 1.2, dash: "dot" },
      ...(flat ? { xref: `x${axis} domain`, x0: 0, x1: 1, yref: `y${axis}`, y0: value, y1: value }
        : { yref: `y${axis} domain`, y0: 0, y1: 1, xref: `x${axis}`, x0: value, x1: value }),
    });
    layout.annotations.push({
      text: plainText(label), showarrow: false, font: { size: 11, color: ink("--limit") }, bgcolor: ink("--card"), opacity: 0.85, borderpad: 1,
      ...(flat ? { xref: `x${axis} domain`, x: 1, xanchor: "right", yref: `y${axis}`, y: value, yanchor: "bottom" }
        : { yref: `y${axis} domain`, y: 1, yanchor: "top", xref: `x${axis}`, x: value, xanchor: "left" }),
    });
  }
}
