"""Integrates one interval and handles every event in it: impacts at stops, joints that stick or are released.

The state is y = (q, dq, work of the motors, work of friction, memory of the controller); where external torques act,
their work stands before the memory. The usual step of a sampled run, in which the contact mode stays, is written for
speed (`FastStep`): the method of `integrators.rk4` on the rates of `Flow`, to rounding. A step in which a joint may
stop, turn round, start to slip or reach a limit is refused, and `Flow` computes it again.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.run import Event
from lwr_dyn.simulation import contact
from lwr_dyn.simulation.arm_friction import Mask, Sides
from lwr_dyn.simulation.contact import HOLDING, TURN, ContactMode, EventFunction, Interval, followable
from lwr_dyn.simulation.integrators import BoundedStep, HeldStep, Integrator, Rates, held_rk4
from lwr_dyn.simulation.plant import ExternalTorque, Plant

Drive = Callable[[float, Array, Array, Array], tuple[Array, Array]]
"""(t, q, dq, memory) -> torque that reaches the joints (n,), derivative of the memory."""

MOST_EVENTS = 50
"""Largest number of events that are followed in one interval."""

TIE = 1e-12
"""[s] Joints that would stop within it of each other stop in the same instant."""

SPEED_ROUNDING = 1e-14
"""Share of the largest speed before an impact that counts as none after it: rounding moves no joint."""


@dataclass(slots=True, eq=False)
class Flow:
    """Advances a plant; it keeps the contact mode, the events, and what the stops did: work [J] and time [s]."""

    plant: Plant
    integrate: Integrator
    external: ExternalTorque | None = None
    stop_work: float = 0.0
    evaluations: int = 0  # of accelerations
    events: list[Event] = field(default_factory=list)
    friction: Array = field(init=False)  # tau_friction (n,) where the last interval began [N m]
    mode: ContactMode = field(init=False)  # set by `begin`
    on_stop: Mask = field(init=False)  # joints that their stops held where the last interval began, (n,)
    stop_seconds: Array = field(init=False)  # time in which they did, interval by interval (n,) [s]
    _begun: bool = field(init=False, default=False)

    works: int = field(init=False)  # entries of the state between dq and the memory

    def __post_init__(self) -> None:
        self.works = 2 if self.external is None else 3
        self.stop_seconds = np.zeros(self.plant.n)

    def advance(self, drive: Drive, t: float, y: Array, h: float) -> Array:
        """y(t + h), with every event in between."""
        end, n = t + h, self.plant.n
        barred, forced = np.zeros((2, n), dtype=bool)
        y = self.begin(drive, t, y)
        self.stop_seconds += h * self.on_stop
        for _ in range(MOST_EVENTS):
            interval = Interval(self.integrate, self._rates(drive), t, end - t, y)
            after = interval.later(end - t)
            if not followable(after, n, h):
                return after
            first = contact.earliest(self._possible_events(drive, interval, after, barred))
            if first is None:
                return after
            event = first.event
            t, y = t + first.after, self._meet_stops(t + first.after, self._state_at(event, interval, first.after))
            if first.after > 0.0:
                barred[:] = forced[:] = False
            elif event.kind != "slip":
                # by rounding, just after the joint slipped or left its stop: it must not do so again at the same time
                barred[event.joint], forced[event.joint] = True, event.kind == "stop"
            guess = self._guess(y)
            guess[event.joint] = event.side * (event.kind == "slip")
            self._update_mode(t, y, self._torque(drive, t, y), guess, forced)
        self.events.append(Event(t, "more events than followed"))
        return self.integrate(self._rates(drive), t, y, end - t)

    def begin(self, drive: Drive, t: float, y: Array) -> Array:
        """The state at the start of an interval, impacts done; its contact mode and its friction torque are kept."""
        n = self.plant.n
        self.on_stop = np.zeros(n, dtype=bool)
        if not np.isfinite(y).all():
            return y
        y = self._meet_stops(t, y)
        q, dq, tau = y[:n], y[n : 2 * n], self._torque(drive, t, y)
        self._update_mode(t, y, tau, self._guess(y), np.zeros(n, dtype=bool))
        self.friction = self.mode.friction_torque(dq)
        if self.mode.any_at_rest:
            holding = self._holding_torque(q, dq, tau - self.friction)
            by_friction = self.mode.friction_part(holding)
            self.friction, self.on_stop = self.friction + by_friction, held_by_stop(holding, by_friction)
        return y

    def _torque(self, drive: Drive, t: float, y: Array) -> Array:
        n = self.plant.n
        q, dq = y[:n], y[n : 2 * n]
        tau = drive(t, q, dq, y[2 * n + self.works :])[0]
        return tau if self.external is None else tau + self.external(t, q, dq)

    def _holding_torque(self, q: Array, dq: Array, net: Array) -> Array:
        self.evaluations += 1
        return self.mode.holding_torque(q, dq, net, self.mode.accelerator()(q, dq, net))

    def _meet_stops(self, t: float, y: Array) -> Array:
        """The state after the impacts of joints that stand at a limit with outward speed, if there are any."""
        n = self.plant.n
        q, dq = y[:n], y[n : 2 * n]
        if not (self.plant.at_limit(q) * dq > 0.0).any():
            return y
        result = contact.impact(self.plant, q, dq)
        struck = np.flatnonzero(result.stopped & (dq != 0.0))
        self.stop_work += float(result.work.sum())
        self.events += [Event(t, "stop", int(joint), float(-result.work[joint])) for joint in struck]
        still = np.abs(result.dq) <= SPEED_ROUNDING * np.abs(dq).max()
        return np.concatenate([q, np.where(still, 0.0, result.dq), y[2 * n :]])

    def _guess(self, y: Array) -> Sides:
        """Sides of joints without speed where both rest and motion are right: friction holds, a stop alone releases."""
        away = -self.plant.at_limit(y[: self.plant.n]).astype(int)
        return np.where(self.plant.friction.directional, 0, away)

    def _update_mode(self, t: float, y: Array, tau: Array, guess: Sides, forced: Mask) -> None:
        """The contact mode from here on, `forced` joints at rest; joints that change become events."""
        plant, n = self.plant, self.plant.n
        sides = np.where(forced, 0, contact.resolve_stick_slip(plant, y[:n], y[n : 2 * n], tau, guess))
        at_stop = plant.at_limit(y[:n]) != 0.0
        if self._begun:
            old = self.mode.sides
            known = (sides != old) & (plant.friction.directional | self.mode.at_rest)
            self.events += [_change(t, int(j), old[j], sides[j], at_stop[j]) for j in np.flatnonzero(known)]
            if not at_stop.any() and (sides == old).all():
                return
        self.mode, self._begun = contact.contact_mode(plant, y[:n], sides), True

    def _rates(self, drive: Drive) -> Rates:
        n, friction_torque, accelerate = self.plant.n, self.mode.friction_torque, self.mode.accelerator()
        external, first = self.external, 2 * self.plant.n + self.works

        def rates(t: float, y: Array) -> Array:
            self.evaluations += 1
            q, dq = y[:n], y[n : 2 * n]
            tau, memory_rate = drive(t, q, dq, y[first:])
            friction = friction_torque(dq)
            if external is not None:
                pushed = external(t, q, dq)
                works = (tau @ dq, -(friction @ dq), pushed @ dq)
                return np.concatenate([dq, accelerate(q, dq, tau + pushed - friction), works, memory_rate])
            return np.concatenate([dq, accelerate(q, dq, tau - friction), (tau @ dq, -(friction @ dq)), memory_rate])

        return rates

    def _possible_events(self, drive: Drive, interval: Interval, after: Array, barred: Mask) -> list[EventFunction]:
        mode, n, known = self.mode, self.plant.n, dict[float, Array]()

        def holding(s: float) -> Array:
            if s not in known:
                y = interval.later(s)
                dq = y[n : 2 * n]
                net = self._torque(drive, interval.t + s, y) - mode.friction_torque(dq)
                known[s] = self._holding_torque(y[:n], dq, net)
            return known[s]

        return contact.possible_events(mode, interval, after, barred, holding)

    def _state_at(self, event: EventFunction, interval: Interval, after: float) -> Array:
        """The state at an event, the joint exactly where it stopped, and others that stop in the same instant too."""
        plant, n, sides = self.plant, self.plant.n, self.mode.sides
        y = interval.later(after).copy()
        y[:n] = np.clip(y[:n], plant.lower, plant.upper)
        dq = y[n : 2 * n]
        if event.kind == "stop":
            y[event.joint] = (plant.upper if event.side > 0 else plant.lower)[event.joint]
            if after == 0.0:  # it left by less than a float can show: it has not left
                dq[event.joint] = 0.0
        if event.kind == "stick":
            rate = sides * interval.rates(interval.t + after, y)[n : 2 * n]
            dq[plant.friction.directional & (rate < 0.0) & (sides * dq <= -TIE * rate)] = 0.0
            dq[event.joint] = 0.0
        return y


def held_by_stop(holding: Array, by_friction: Array) -> Mask:
    """Joints whose holding torque (n,) [N m] friction alone does not give."""
    return np.asarray(np.abs(holding - by_friction) > HOLDING)


def _change(t: float, joint: int, old: int, new: int, at_stop: bool) -> Event:
    """A joint that sticks, slips, is released from its stop, or turns round."""
    if new == 0:
        return Event(t, "stick", joint)
    if old == 0:
        return Event(t, "release" if at_stop else "slip", joint, float(new))
    return Event(t, "reverse", joint, float(new))


NO_WORK = (0.0, 0.0)
"""Of friction and the like in a step without any."""


class FastStep:
    """One sample of `h` [s] in RK4 substeps.

    `friction` (n,) [N m] at its start and `work`, what the step returned, are those of the last step that was taken.
    """

    def __init__(self, flow: Flow, h: float, substeps: int) -> None:
        plant, n = flow.plant, flow.plant.n
        self._flow, self._h, self._substeps = flow, h, substeps
        cap = np.full(n, TURN / h)
        self._ceiling, self._floor = np.array([plant.upper, cap]), np.array([plant.lower, -cap])
        self._inside = np.zeros((2, 2, n), dtype=bool)
        self._below, self._above = self._inside
        self._all_inside = np.ones_like(self._inside).tobytes()
        self._directional = plant.friction.directional
        self._mode: ContactMode | None = None
        self._step: HeldStep
        self.friction, self.on_stop = np.zeros(n), np.zeros(n, dtype=bool)
        self.work: tuple[float, ...] = NO_WORK

    def take(self, t: float, now: Array, tau: Array, after: Array) -> bool:
        """The step from `now` at t into `after`, states (2, n) = (q, dq); False where refused: `after` is invalid."""
        flow, mode = self._flow, self._flow.mode
        if mode is not self._mode:
            self._adopt(mode)
        if self._own is not None:
            self.work = NO_WORK
            flow.evaluations += 4 * self._substeps
            return self._own(now, tau, after) is None
        return self._take_judged(mode, t, now, tau, after)

    def _take_judged(self, mode: ContactMode, t: float, now: Array, tau: Array, after: Array) -> bool:
        flow = self._flow
        if not self._plain:
            if not self._stays_at_rest(mode, t, now, tau):
                return False
            if mode.all_at_rest and flow.external is None:
                after[:], self.work = now, NO_WORK
                flow.stop_seconds += self._h * self.on_stop
                return True
        self.work = self._step(t, now, tau, after)
        flow.evaluations += 4 * self._substeps
        # one comparison finds a limit that is passed, a speed that cannot be followed, and NaN
        np.less_equal(after, self._ceiling, out=self._below)
        np.greater_equal(after, self._floor, out=self._above)
        if self._inside.tobytes() != self._all_inside:
            return False
        if not (self._plain or self._keeps(mode, t + self._h, tau, after)):
            return False
        if mode.any_at_rest:
            flow.stop_seconds += self._h * self.on_stop
        return True

    def _adopt(self, mode: ContactMode) -> None:
        self._mode, self._accelerate = mode, mode.accelerator()
        n, external = mode.plant.n, self._flow.external
        self._step, self._tangent = held_rk4(self._accelerate, n, self._h, self._substeps, mode.friction, external)
        self._high, self._low = mode.highest + HOLDING, mode.lowest - HOLDING
        self._plain = mode.friction is None and not mode.any_at_rest
        own = getattr(mode.plant.ungated, "held_step", None)
        self._own: BoundedStep | None = None  # of an engine that has one
        if self._plain and external is None and own is not None:
            self._own = own(self._h, self._substeps, (self._floor, self._ceiling))

    def _stays_at_rest(self, mode: ContactMode, t: float, state: Array, tau: Array) -> bool:
        """Whether joints at rest, if any, stay so under tau; it also keeps the friction torque."""
        q, dq = state
        friction = mode.friction_torque(dq)
        if not mode.any_at_rest:
            self.friction = friction
            return True
        external = self._flow.external
        net = tau - friction if external is None else tau - friction + external(t, q, dq)
        holding = mode.holding_torque(q, dq, net, self._accelerate(q, dq, net))
        self._flow.evaluations += 1
        by_friction = mode.friction_part(holding)
        self.friction, self.on_stop = friction + by_friction, held_by_stop(holding, by_friction)
        return bool(((holding <= self._high) & (holding >= self._low)).all())

    def _keeps(self, mode: ContactMode, t: float, tau: Array, after: Array) -> bool:
        """Whether no joint turned round (or might have, by the tangent at the last substep), or started to slip."""
        sides = mode.sides
        same = ((sides * after[1] > 0.0) & (sides * self._tangent() >= 0.0)) | mode.at_rest | ~self._directional
        if not same.all():
            return False
        if not mode.any_at_rest:
            return True
        friction, on_stop = self.friction, self.on_stop
        stays = self._stays_at_rest(mode, t, after, tau)
        self.friction, self.on_stop = friction, on_stop
        return stays
