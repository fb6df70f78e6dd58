// Numbers of curves: from the page's pool, or from a run.

function curveSources(data) {
  const pool = data.numbers.map((numbers) => {
    if (Array.isArray(numbers)) return numbers.map((x) => x ?? NaN);
    const values = unpack(numbers);
    numbers.gaps.forEach((i) => { values[i] = NaN; });
    return values;
  });
  const runs = (data.runs ?? []).map((record) => new RunSeries(record));
  const at = (source) => (source === null ? null : typeof source === "number" ? pool[source] : runs[source.run].of(source));
  return (curve, magnified) => {
    const run = curve.y !== null && typeof curve.y === "object" ? runs[curve.y.run] : null, t = run?.t ?? null;
    const enlarged = (source) => (magnified > 1 ? runs[source.run].magnified(source, magnified) : at(source));
    const path = magnified > 1 && curve.x?.quantity?.startsWith("flange ");
    return { t, x: path ? enlarged(curve.x) : at(curve.x) ?? t, y: path ? enlarged(curve.y) : at(curve.y) };
  };
}

// The series of a run by their names; errors are reference minus actual.
class RunSeries {
  constructor(record) {
    Object.assign(this, { record, t: unpack(record.t), kept: new Map() });
    this.n = record.joints.length;
  }

  flat(name) {
    if (!this.kept.has(name)) this.kept.set(name, this.#flat(name));
    return this.kept.get(name);
  }

  #flat(name) {
    const { record } = this;
    if (name === "position error") {
      const q = this.flat("q");
      return this.flat("q_ref").map((desired, i) => desired - q[i]);
    }
    if (name === "tip error") return unpack(record.tip_error);
    return unpack(name === "q" || name === "q_ref" ? record[name] : record.series[name]);
  }

  of({ quantity, joint, scale }) {
    const flat = this.flat(quantity), width = joint === null ? 1 : this.n;
    return Float64Array.from(this.t, (_, k) => scale * flat[k * width + (joint ?? 0)]);
  }

  // A path with its errors drawn so many times as large.
  magnified(source, factor) {
    const reference = this.of({ ...source, quantity: source.quantity.replace("flange", "reference") });
    return this.of(source).map((x, k) => reference[k] + factor * (x - reference[k]));
  }
}

// A curve at a time: straight lines between its points, its ends beyond them.
function blendAt(times, values, time) {
  const last = times.length - 1, k = Math.min(Math.max(lastAtMost(times, time), 0), Math.max(last - 1, 0)), next = Math.min(k + 1, last);
  const span = times[next] - times[k], part = span > 0 ? Math.min(Math.max((time - times[k]) / span, 0), 1) : 0;
  return values[k] + part * (values[next] - values[k]);
}
