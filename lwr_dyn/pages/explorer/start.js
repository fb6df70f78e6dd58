// The page begins when all panels are known: with its first arm, or the one that its link names.

window.lwrExplorer = new Explorer(JSON.parse(document.getElementById("explorer-data").textContent));
const named = Number(location.hash.split("&arm=")[1] ?? 0);
window.lwrExplorer.choose(window.lwrExplorer.arms[named] ? named : 0);
window.lwrExplorer.ready = true;
