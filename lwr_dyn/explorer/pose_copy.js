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
    return `${location.href.split("#")[0]}#q=${list.replace(/ /g, "")}`;
  }

  write(q) {
    this.numbers(q).forEach((x, k) => { this.cells[k].textContent = fixed(x, 6); });
  }

  // A link of this page: as many numbers as joints, all inside the sliders; else it is said and nothing moves.
  #goTo(hash) {
    if (!hash.startsWith("#q=")) return;
    const given = hash.slice(3).split(","), q = given.map((x) => (x.trim() === "" ? NaN : Number(x)));
    const inside = (x, i) => x >= this.joints[i].slider[0] - 1e-9 && x <= this.joints[i].slider[1] + 1e-9;
    const right = q.length === this.joints.length && q.every(inside);
    this.word.textContent = right ? "" : "the link's pose is not one of this arm";
    if (right) this.explorer.setPose(q);
  }

  #build() {
    const card = document.createElement("section"), names = ["x", "y", "z", "A", "B", "C"];
    card.className = "card";
    card.setAttribute("aria-label", "Pose to copy");
    card.innerHTML = `<div class="head"><h2>Flange <small>m, rad; A B C as KUKA has them</small></h2><div class="buttons"><button data-form="python" type="button">Python</button><button data-form="krl" type="button">KRL</button><button data-form="link" type="button">link</button></div></div><div class="scroll" tabindex="0" role="region" aria-label="Flange in m and rad"><table class="heat"><thead><tr>${names.map((name) => `<th class="num" scope="col">${name}</th>`).join("")}</tr></thead><tbody><tr>${names.map(() => "<td></td>").join("")}</tr></tbody></table></div><div class="copy"><input readonly aria-label="The text copied" class="copied-text"><span role="status"></span></div>`;
    this.explorer.place(card);
    this.cells = [...card.querySelectorAll("td")];
    this.field = card.querySelector("input");
    this.word = card.querySelector("span");
    card.querySelectorAll("button").forEach((button) => button.addEventListener("click", () => this.#copy(button.dataset.form)));
  }

  async #copy(form) {
    this.field.value = this.text(form, explorerState.q);
    this.field.select();
    const done = await navigator.clipboard?.writeText(this.field.value).then(() => true, () => false);
    this.word.textContent = done || document.execCommand("copy") ? "copied" : "press Ctrl-C";
  }
}

explorerPanels.add("poseCopy", (explorer) => new PoseCopy(explorer));
