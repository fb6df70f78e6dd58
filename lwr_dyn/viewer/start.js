// The replay page: one player that fills the window.
{
  const side = document.getElementById("side"), bar = document.getElementById("bar");
  const covered = () => ({ left: window.innerWidth > 900 ? side.offsetWidth + 24 : 0, bottom: bar.offsetHeight + 20 });
  window.lwrReplay = new Player(JSON.parse(document.getElementById("replay-data").textContent), { covered }).hook();
}
