// The panels of the page: each file adds its own; all are made anew when another arm is chosen, so none keeps an old arm.

const explorerPanels = (() => {
  const makers = [], warmed = new Set(), idle = window.requestIdleCallback ?? setTimeout;

  // `make(explorer)` gives the panel, or null for an arm that cannot have it; it becomes explorer[name]. Only for arms
  // that the page computes with, or always.
  const add = (name, make, { always = false } = {}) => { makers.push([name, make, always]); };

  // Panels with `warm()` compute some times while nobody waits, so that the browser has translated the functions when
  // they are needed.
  const build = (explorer) => {
    makers.forEach(([name, make, always]) => { explorer[name] = always || explorer.robot ? make(explorer) : null; });
    const { signal, data } = explorer;
    makers.forEach(([name]) => {
      if (!explorer[name]?.warm || warmed.has(`${name} ${data.set}`)) return;
      idle(() => {
        if (signal.aborted) return;
        explorer[name].warm();
        warmed.add(`${name} ${data.set}`);
      });
    });
  };

  return { add, build };
})();
