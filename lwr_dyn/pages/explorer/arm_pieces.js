// What Python wrote of an arm (title, facts, notes, sliders, switches, numbers of the tables): another arm's pieces take
// the place of the first one's and are put back.

const armPieces = (() => {
  const kept = new Map();

  const show = (place) => {
    kept.forEach((nodes, id) => document.getElementById(id).replaceChildren(...nodes));
    kept.clear();
    document.getElementById(`arm-${place}`)?.content.querySelectorAll("[data-for]").forEach((piece) => {
      const at = document.getElementById(piece.dataset.for);
      kept.set(at.id, [...at.childNodes]);
      at.replaceChildren(...piece.cloneNode(true).childNodes);
    });
    document.title = document.getElementById("arm-title").textContent;
  };

  return { show };
})();
