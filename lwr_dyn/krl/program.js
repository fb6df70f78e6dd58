// The program beside the stage: the line that moves the arm now is marked; a line with a motion goes to its motion.
{
  const data = JSON.parse(document.getElementById("replay-data").textContent);
  const { files, motions, events, about, assumed, left_out: leftOut } = data.program;
  const begins = motions.map((motion) => motion[2]), happenings = events.map((event) => event[2]);
  const box = element("section", "card"), head = element("header"), says = element("span", "now"), list = element("ol");
  const choice = element("select");
  box.id = "program";
  box.setAttribute("aria-label", "Program");
  list.tabIndex = 0;
  list.setAttribute("aria-label", "Lines");
  choice.setAttribute("aria-label", "file");
  choice.append(...files.map(({ name }, i) => Object.assign(element("option", "", name), { value: i })));
  head.append(files.length > 1 ? choice : element("span", "", files[0].name), says);
  const happened = element("div", "facts happened");
  box.append(head, ...(events.length > 0 ? [happened] : []), list);
  const marks = leftOut > 0 ? [`the lines of the last ${leftOut} motions are not marked`] : [];
  box.append(element("div", "facts", [...about, ...marks].join(" \u00B7 ")));
  if (assumed.length > 0) {
    const why = element("details", "assumed"), points = element("ul");
    points.append(...assumed.map((text) => element("li", "", text)));
    why.append(element("summary", "", `what is assumed (${assumed.length})`), points);
    box.append(why);
  }
  box.style.setProperty("--accent", `var(--${runToken(data.runs[0])})`);
  document.getElementById("cards").after(box);

  const moving = files.map((_, file) => {
    const times = new Map();
    [...motions, ...events].forEach(([of, line, begin]) => {
      if (of !== file) return;
      if (!times.has(line)) times.set(line, []);
      times.get(line).push(begin);
    });
    return times;
  });
  let shown = -1, rows = [], marked = [];

  // The next time of the line; after the last one its first.
  const goTo = (line) => {
    const times = moving[shown].get(line);
    lwrReplay.play(false);
    lwrReplay.setTime(times.find((t) => t > lwrReplay.time() + 1e-6) ?? times[0]);
  };

  const showFile = (file) => {
    shown = file;
    choice.value = file;
    marked = [];
    rows = files[file].lines.map((text, i) => {
      const row = element("li"), moves = moving[file].has(i + 1);
      const words = element(moves ? "button" : "code", /^\s*[;&]/.test(text) ? "aside" : "", text || " ");
      if (moves) {
        words.type = "button";
        words.addEventListener("click", () => goTo(i + 1));
      }
      row.append(element("i", "", String(i + 1)), words, ...(files[file].says[i + 1] ?? []).map((text) => element("em", "", text)));
      return row;
    });
    list.replaceChildren(...rows);
  };

  const mark = (line, name) => {
    const row = rows[line - 1];
    if (row === undefined) return;
    row.classList.add(name);
    if (name === "runs") row.setAttribute("aria-current", "step");
    marked.push(row);
  };

  const follow = (row) => {
    const from = row.offsetTop, seen = list.clientHeight;
    if (from < list.scrollTop || from + row.offsetHeight > list.scrollTop + seen) list.scrollTop = from - seen / 2;
  };

  let last = null;
  const show = (time) => {
    const k = Math.max(0, lastAtMost(begins, time + 1e-9)), now = motions[k];
    if (now === undefined) return;
    const before = motions[k - 1], ends = before !== undefined && before[3] > time + 1e-9 ? before : undefined;
    const latest = lastAtMost(happenings, time + 1e-9), state = `${k} ${ends !== undefined} ${latest}`;
    if (state === last) return;
    last = state;
    if (now[0] !== shown) showFile(now[0]);
    marked.forEach((row) => { row.classList.remove("runs", "ends", "happens"); row.removeAttribute("aria-current"); });
    marked = [];
    if (ends !== undefined && ends[0] === shown) mark(ends[1], "ends");
    // what has happened since the motion began
    for (let i = latest; i >= 0 && happenings[i] >= now[2] - 1e-9; i -= 1) if (events[i][0] === shown) mark(events[i][1], "happens");
    happened.textContent = latest < 0 ? "\u2013" : `${happenings[latest].toFixed(3)} s: ${events[latest][3]}`;
    mark(now[1], "runs");
    says.textContent = `line ${now[1]}: ${now[4]}`;
    follow(rows[now[1] - 1]);
  };
  choice.addEventListener("change", () => {
    showFile(Number(choice.value));
    last = null;
    if (motions[Math.max(0, lastAtMost(begins, lwrReplay.time()))]?.[0] === shown) show(lwrReplay.time());
  });
  showFile(0);
  lwrReplay.watch(show);
}
