// The buttons at the head of the page that make another arm of it the active one.

class ArmChooser {
  constructor(explorer) {
    const bar = document.getElementById("arms");
    this.explorer = explorer;
    this.buttons = explorer.arms.map(({ label }, index) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: label });
      button.addEventListener("click", () => { if (explorer.active !== index) explorer.choose(index); });
      return button;
    });
    bar.replaceChildren(...this.buttons);
    bar.hidden = this.buttons.length < 2;
    bar.setAttribute("aria-label", explorer.page.differing ? "Reading of the paper" : "Arm");
  }

  write() {
    this.buttons.forEach((button, index) => button.setAttribute("aria-pressed", String(index === this.explorer.active)));
  }
}
