// The replay page: one player that fills the window; on a phone the stage, the cards and the bar stand below each other.
{
  const side = document.getElementById("side"), bar = document.getElementById("bar");
  const narrow = matchMedia("(max-width: 700px)");
  const covered = () => (narrow.matches ? { left: 0, bottom: 0 }
    : { left: window.innerWidth > 900 ? side.offsetWidth + 24 : 0, bottom: bar.offsetHeight + 20 });
  const fold = () => { document.getElementById("shown").open = !narrow.matches; };
  fold();
  narrow.addEventListener("change", fold);
  window.lwrReplay = new Player(JSON.parse(document.getElementById("replay-data").textContent), { covered }).hook();
  // What covers the stage changes its height when the fonts are there.
  const watched = new ResizeObserver(() => {
    lwrReplay.stage.viewer.set_3d_pane_size();
    lwrReplay.stage.frameView();
  });
  [document.getElementById("stage"), bar].forEach((part) => watched.observe(part));
}
