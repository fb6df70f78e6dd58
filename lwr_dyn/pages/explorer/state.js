// The state of the page: positions, speeds, accelerations; who listens is told at most once a frame.

const explorerState = (() => {
  const listeners = [], resters = [], REST = 150; // [ms]
  let waiting = false, resting = 0, last = 0, half = 0;
  const state = { q: new Float64Array(0), dq: new Float64Array(0), ddq: new Float64Array(0), computed: 0, spent: [] };

  const tell = (told) => {
    waiting = false;
    const before = performance.now();
    state.computed += 1;
    for (const entry of told) {
      entry.at = state.computed;
      entry.listener(state);
    }
    if (state.spent.push(performance.now() - before) > 400) state.spent.shift(); // how long it took [ms]
  };

  const catchUp = (late) => late.filter(({ at }) => at !== state.computed).forEach((entry) => {
    entry.at = state.computed;
    entry.listener(state);
  });

  const rest = () => {
    const left = last + REST - performance.now();
    resting = left > 1 ? setTimeout(rest, left) : 0;
    if (resting) return;
    catchUp(listeners);
    resters.forEach((act) => act());
  };

  // Everybody computes and writes now.
  state.compute = () => tell([...listeners]);

  // What can be seen computes and writes: the picture at each frame, of the cards one half at this frame, the other half
  // at the next; cards out of view when the arm rests.
  state.frame = () => {
    half = 1 - half;
    tell(listeners.filter(({ card, seen }, k) => !card || (seen && k % 2 === half)));
    last = performance.now();
    requestAnimationFrame(() => { if (!waiting) catchUp(listeners.filter(({ seen }) => seen)); });
    if (!resting) resting = setTimeout(rest, REST);
  };

  // New values of some of q, dq, ddq.
  state.set = (parts) => {
    Object.entries(parts).forEach(([name, values]) => { state[name] = Float64Array.from(values); });
    if (waiting || state.q.length === 0) return;
    waiting = true;
    requestAnimationFrame(() => { if (waiting) state.frame(); });
  };

  const watch = window.IntersectionObserver && new IntersectionObserver((changes) => changes.forEach(({ target, isIntersecting }) => {
    const own = listeners.filter(({ card }) => card === target);
    own.forEach((entry) => { entry.seen = isIntersecting; });
    if (isIntersecting && state.q.length > 0) catchUp(own);
  }), { rootMargin: "-40px 0px" }); // more than its head

  // A listener that writes into a card alone sleeps while the card is out of view.
  state.listen = (listener, card = null) => {
    listeners.push({ listener, card, seen: true, at: 0 });
    if (card) watch?.observe(card);
  };

  // What can wait until the arm rests.
  state.atRest = (act) => { resters.push(act); };

  // Another arm comes: nobody listens any more.
  state.forget = () => {
    listeners.length = 0;
    watch?.disconnect();
  };
  return state;
})();
