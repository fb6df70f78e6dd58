// The state of the page: positions, speeds, accelerations; who listens is told at most once a frame.

const explorerState = (() => {
  const listeners = [];
  let waiting = false;
  const state = { q: new Float64Array(0), dq: new Float64Array(0), ddq: new Float64Array(0), computed: 0, spent: [] };

  // Everybody computes and writes now; `spent` keeps how long it took [ms].
  state.compute = () => {
    waiting = false;
    const before = performance.now();
    listeners.forEach((listener) => listener(state));
    state.computed += 1;
    if (state.spent.push(performance.now() - before) > 400) state.spent.shift();
  };

  // New values of some of q, dq, ddq.
  state.set = (parts) => {
    Object.entries(parts).forEach(([name, values]) => { state[name] = Float64Array.from(values); });
    if (waiting || state.q.length === 0) return;
    waiting = true;
    requestAnimationFrame(state.compute);
  };

  state.listen = (listener) => { listeners.push(listener); };

  // Another arm comes: nobody listens any more.
  state.forget = () => { listeners.length = 0; };
  return state;
})();
