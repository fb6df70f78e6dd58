// The pose to take along: m and rad, X Y Z A B C of a KUKA controller; as Python, as KRL, or as a link to this page.

class PoseCopy {
  constructor(explorer) {
    this.explorer = explorer;
    this.joints = explorer.data.arm.joints;
    this.#build();
    if (!explorer.ready) this.#goTo(location.hash); // once, when the page begins
    window.addEventListener("hashchange", () => this.#goTo(location.hash), { signal: explorer.signal });
    explorerState.listen((state) => this.write(state.q));
  }

  // X, Y, Z [m]; A, B, C [rad]: about z, about y, about x.
  numbers(q) {
    const pose = armKinematics.flange(this.explorer.data.arm, q), [roll, pitch, yaw] = armKinematics.rollPitchYaw(pose);
    return [pose[12], pose[13], pose[14], yaw, pitch, roll];
  }

  // What is copied; q with all its digits (the page itself keeps 1e-9 deg).
  text(form, q) {
    const list = Array.from(q, (x) => (x === 0 ? 0 : x)).join(", "), numbers = this.numbers(q);
    if (form === "python") return `q = [${list}]  # ${this.joints.every(({ kind }) => kind === "revolute") ? "rad" : "rad, m"}`;
    if (form === "krl") {
      const said = numbers.map((x, k) => fixed(k < 3 ? 1000 * x : (x * 180) / Math.PI, k < 3 ? 3 : 4));
      return `{X ${said[0]}, Y ${said[1]}, Z ${said[2]}, A ${said[3]}, B ${said[4]}, C ${said[5]}}`;
    }
    return `${location.href.split("#")[0]}#q=${list.replace(/ /g, "")}${this.explorer.active > 0 ? `&arm=${this.explorer.active}` : ""}`;
  }

  write(q) {
    this.cells(this.numbers(q));
  }

  // A link of this page: as many numbers as joints, all inside the limits; else it is said and nothing moves. It may
  // name another arm of the page.
  #goTo(hash) {
    if (!hash.startsWith("#q=")) return;
    const { explorer } = this, [numbers, place = "0"] = hash.slice(3).split("&arm=");
    if (explorer.arms[place] && explorer.arms[place] !== explorer.arms[explorer.active]) {
      explorer.choose(Number(place));
      explorer.poseCopy.#goTo(hash);
      return;
    }
    const given = numbers.split(","), q = given.map((x) => (x.trim() === "" ? NaN : Number(x)));
    const inside = (x, i) => Number.isFinite(x) && x >= (this.joints[i].lower ?? x) - 1e-9 && x <= (this.joints[i].upper ?? x) + 1e-9;
    const right = Boolean(explorer.arms[place]) && q.length === this.joints.length && q.every(inside);
    this.word.textContent = right ? "" : "the link's pose is not one of this arm";
    if (right) this.explorer.setPose(q);
  }

  // In the card of the flange: a row in m and rad, and buttons beside its own.
  #build() {
    const row = document.createElement("tr"), forms = document.createElement("span"), { signal, poseCard } = this.explorer;
    row.innerHTML = `<th scope="row">m, rad</th>${"<td></td>".repeat(6)}`;
    forms.className = "plain";
    forms.innerHTML = ["Python", "KRL", "link"].map((form) => `<button type="button">${form}</button>`).join("");
    document.querySelector(".flange-pose tbody").append(row);
    document.getElementById("copy").after(forms);
    signal.addEventListener("abort", () => [row, forms].forEach((part) => part.remove()));
    this.cells = numberWriter([...row.querySelectorAll("td")], 6);
    this.word = document.getElementById("copied");
    forms.querySelectorAll("button").forEach((button) => button.addEventListener("click", () => poseCard.copy(this.text(button.textContent.toLowerCase(), explorerState.q))));
  }
}

explorerPanels.add("poseCopy", (explorer) => new PoseCopy(explorer));
