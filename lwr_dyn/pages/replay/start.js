// The replay page: one player that fills the window; on a phone the stage, the cards and the bar stand below each other.
{
  const side = document.getElementById("side"), bar = document.getElementById("bar");
  const narrow = matchMedia("(max-width: 700px)");
  // Beside the cards, or below them.
  const covered = () => {
    if (narrow.matches) return [{}];
    const bottom = bar.offsetHeight + 20;
    return [{ left: side.offsetWidth + 24, bottom }, { top: side.offsetTop + side.offsetHeight + 8, bottom }];
  };
  const fold = () => { document.getElementById("shown").open = !narrow.matches; };
  fold();
  narrow.addEventListener("change", fold);
  window.lwrReplay = new Player(JSON.parse(document.getElementById("replay-data").textContent), { covered }).hook();
  // What covers the stage changes its height when the fonts are there.
  const watched = new ResizeObserver(() => {
    lwrReplay.stage.viewer.set_3d_pane_size();
    lwrReplay.stage.frameView(!lwrReplay.stage.turned);
  });
  [document.getElementById("stage"), side, bar].forEach((part) => watched.observe(part));
}
