// The page begins with its first arm, when all panels are known.

window.lwrExplorer = new Explorer(JSON.parse(document.getElementById("explorer-data").textContent));
window.lwrExplorer.choose(0);
window.lwrExplorer.ready = true;
