# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What to change besides the motion: it tells causes apart that no trajectory does."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from sosml_friction.diagnosis.next_experiment.stretch import Stretch
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.model.terms.payload import point_mass
from sosml_friction.regression.signals import Signals

#: Length of a hold, and time from the cold recording to its warm repetition [s]. Chosen: 20 s of
#: rest average the noise of effort, gears warm up over minutes. No measurement.
HOLD_S, WARM_S = 20.0, 1800.0
#: First moment of the known payload as a share of the last body's, and its distance from the last
#: joint as a multiple of that body's centre of mass: half as far again, which is still on it.
#: Proposals to a person: no answer hangs on them.
_MOMENT, _DISTANCE = 0.5, 1.5
#: A payload that the actuators carry less than this share of is not proposed: 0.2 of 0.5 is a
#: tenth of the last body's first moment, three times the tolerance that it has without.
_LEAST = 0.2
#: A robot hangs free where gravity needs less than this share of the usual effort: above the
#: gradient of the potential energy at which the search for its minimum stops, 1e-5 Nm.
_LOAD = 1e-4


@dataclass(frozen=True)
class Condition:
    """
    Hold one change: ``name``, what to do, and the stretches of data that it adds.

    ``stretches`` are those that are recorded besides.
    """

    name: str
    instruction: str
    stretches: tuple[Stretch, ...]


def conditions(signals: tuple[Signals, ...]) -> Mapping[str, Condition]:
    """
    Return the changes that can be made here, by name.

    The motion of ``signals`` is repeated, but for the hold. With the motors off a joint that hangs
    free has no torque: what effort is measured is its bias. A payload that is known is part of the
    model, so that loads and efforts change and nothing is unknown of it.
    """
    result = {
        'not_worn': Condition(
            'not_worn',
            'repeat the recording without person or cable (not worn): a spring goes, '
            'the rest stays',
            tuple(Stretch(replace(s, cache={}), absent=_worn()) for s in signals),
        )
    }
    hold = _hold(signals[0])
    if hold:
        result['free_hanging_hold'] = Condition(
            'free_hanging_hold',
            'hold the joint where gravity asks nothing of it, free of load and at rest, motors '
            f'off, for {HOLD_S:g} s: a bias of effort stays, everything else goes',
            hold,
        )
    if all(s.temperature is None for s in signals):
        result['warm_up_repeat'] = Condition(
            'warm_up_repeat',
            f'repeat the recording after {WARM_S / 60.0:g} min of motion: what warms up has '
            'changed, a wrong number has not',
            tuple(Stretch(replace(s, time=s.time + WARM_S, cache={})) for s in signals),
        )
    mass, stretches = _payload(signals)
    if stretches:
        result['known_payload'] = Condition(
            'known_payload',
            f'repeat the recording with a known payload, such as {mass:.2g} kg on the last body, '
            'that the model has: what follows the load grows, what follows posture does not',
            stretches,
        )
    return result


def _worn() -> frozenset[str]:
    """Return what comes with a person or cable, and goes with them."""
    worn = (name for name, kind in TERMS.classes.items() if kind.worn)
    return frozenset({*worn, 'external_contact'})


def _hold(signals: Signals) -> tuple[Stretch, ...]:
    """Return a rest where the robot hangs by itself; none where it does not."""
    robot, n = signals.robot, signals.robot.n
    still = np.zeros(n)
    # A slide that has weight has no lowest position but where it ends.
    ends = zip(signals.q.min(axis=0).tolist(), signals.q.max(axis=0).tolist(), strict=True)
    found = minimize(
        robot.energy,
        signals.q.mean(axis=0),
        args=(still,),
        jac=lambda q, _: robot.gravity(q),
        bounds=[
            (low, high) if unit == 'N' else (None, None)
            for (low, high), unit in zip(ends, robot.effort_units, strict=True)
        ],
    )
    q = np.asarray(found.x)
    if np.abs(robot.gravity(q)).max() > _LOAD * float(signals.scales.effort.max()):
        return ()
    count = max(2, round(HOLD_S / signals.band.step))
    nothing = np.zeros((count, n))
    rest = replace(
        signals,
        time=signals.time[0] + signals.band.step * np.arange(count),
        q=np.tile(q, (count, 1)),
        v=nothing,
        a=nothing,
        tau=nothing,
        sign=nothing,
        rigid=nothing,
        friction=nothing,
        known=nothing,
        by_load=nothing,
        more_load=nothing,
        shaken=nothing,
        doubted=nothing,
        rough=nothing,
        held=1.0,
        regressor=np.tile(robot.torque_regressor(q, still, still), (count, 1, 1)),
        temperature=None
        if signals.temperature is None
        else np.tile(signals.temperature[:1], (count, 1)),
        rests=(),
        cache={},
    )
    return (Stretch(rest, only=frozenset({'effort_bias'})),)


def _payload(signals: tuple[Signals, ...]) -> tuple[float, tuple[Stretch, ...]]:
    """Return a mass [kg] and the motion repeated with it; none where there is nowhere for it."""
    robot = signals[0].robot
    body = robot.inertial_parameters()[-1]
    moment = float(np.linalg.norm(body[1:4]))
    if body[0] <= 0.0 or moment <= 1e-6 * body[0]:
        return 0.0, ()
    r = _DISTANCE * body[1:4] / body[0]
    mass = _MOMENT * moment / float(np.linalg.norm(r))
    point = mass * point_mass(r)
    # The share of it that the actuators carry beside what the motion needs without it.
    limit = np.array([x.effort if x.effort > 0.0 else np.inf for x in robot.limits])
    share = 1.0
    for s in signals:
        most = np.abs(s.whole_torque).max(axis=0)
        added = np.abs(s.through_gears(s.regressor[:, :, -10:] @ point)).max(axis=0)
        # A limit that the motion itself exceeds is not the actuator's.
        room = np.where(most < limit, limit - most, np.inf) / np.maximum(added, 1e-300)
        share = min(share, float(room.min()))
    if share < _LEAST:
        return 0.0, ()
    stretches = []
    for s in signals:
        more = s.regressor[:, :, -10:] @ (share * point)
        carried = s.through_gears(more)
        known = s.known + carried - more
        loaded = replace(s, rigid=s.rigid + more, known=known, tau=s.tau + carried, cache={})
        stretches.append(Stretch(loaded))
    return share * mass, tuple(stretches)
