# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Friction that MJCF has no field for, set before each step of MuJoCo.

A term's effort at sign of motion +1 and -1 says all: half of the difference is a level that
opposes motion, for ``dof_frictionloss``, which sticks; half of the sum acts in both directions
alike, for ``qfrc_applied``. So each term keeps its one equation, and every term with an equation
of effort can be simulated. Viscous friction is ``dof_damping``, which MuJoCo integrates
implicitly; springs and ripple that the MJCF has itself are left to it.
"""

import json
import weakref
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import yaml

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.known_terms import KnownTerm, known_terms, read_term
from sosml_friction.model.model_folder import RobotModelFile, parse_model, read_model
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm, SimulatedReport
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.mujoco.engine import engine, joint_id

#: Name of the text in an MJCF that holds the model, of ``<custom>``.
TEXT = 'sosml_friction'
#: What the name of an actuator begins with that is a ripple of its joint.
RIPPLE = 'sosml cogging '
#: Both signs of motion.
_SIGNS = np.array([[1.0], [-1.0]])


class _Part(NamedTuple):
    """Hold one term in some joints: inner parameters and amplitudes of each joint."""

    term: EffortTerm
    joints: int | slice
    inner: Inner
    amplitudes: tuple[FloatArray, ...]


class Friction:
    """
    Hold the friction of a model folder for one MjModel, and the states of one MjData.

    :param model: MjModel; each joint that has friction was compiled with a frictionloss > 0, as
        ``sosml export --to mjcf`` writes it.
    :param source: model folder, ``model.yaml``, or what it holds; None: what the MJCF holds.
    :raises ConfigurationError: if there is no model, or one of its joints is not in the MjModel
        or was compiled without frictionloss.

    ``delay``: of the reported effort (n,) [s]. ``left_out``: sentence parts on terms that are no
    friction and no load: a gear that gives, an error of the encoder.
    """

    def __init__(self, model: Any, source: RobotModelFile | str | Path | None = None) -> None:
        self.content = content = _content(model, source)
        missing = [name for name in content.joints if joint_id(model, name) < 0]
        if missing:
            raise ConfigurationError(
                f'the MJCF has no joint {", ".join(missing)}: name its joints as model '
                f'{content.name} does'
            )
        ids = [joint_id(model, name) for name in content.joints]
        self._dof, self._q = model.jnt_dofadr[ids], model.jnt_qposadr[ids]
        self._rotor = model.dof_armature[self._dof].copy()
        self.left_out: list[str] = []
        self._reports: list[SimulatedReport] = []
        self.delay = np.zeros(len(ids))
        self._parts = self._grouped(model)
        self._damp(model)
        n = len(ids)
        still = np.zeros((2, n))
        self._motion = Motion(np.zeros(2), still, still.copy(), _SIGNS + still, still.copy(),
                              np.full((2, n), np.nan))  # fmt: skip
        self._constant = np.zeros((2, n))
        self._parts = [part for part in self._parts if not self._is_constant(part)]
        self._fresh = [part.term.path_state(np.zeros(1), part.inner) for part in self._parts]
        self._states = [np.repeat(state, 2, axis=0) for state in self._fresh]
        self._time, self._before = -np.inf, np.zeros(n)
        self._queue: deque[tuple[float, FloatArray]] = deque()
        self._work = np.zeros(model.nv)
        self._by_load = self._needs_load()
        level = self._total()[0]
        without = ~(model.dof_frictionloss[self._dof] > 0.0) & (level > 0.0)
        bare = [name for name, yes in zip(content.joints, without, strict=True) if yes]
        if bare:
            raise ConfigurationError(
                f'joint {", ".join(bare)} was compiled without frictionloss: write the MJCF with '
                'sosml export --to mjcf, or give it any above 0'
            )

    def _grouped(self, model: Any) -> list[_Part]:
        """Return what is applied at each step; a kind of term in all joints at once."""
        own = [t for e in self.content.law_terms() for t in read_term(e, self.content)]
        alone, groups = [], dict[tuple[type[EffortTerm], int], list[KnownTerm]]()
        names = self.content.joint_names
        for known in own + known_terms(self.content):
            term = known.term
            where = 'all joints' if known.joint < 0 else names[known.joint]
            if isinstance(term, MeasurementTerm):
                self._reports.append(cast(SimulatedReport, known.simulated(cast(Any, None))))
            elif term.identifier == 'effort_delay':
                self.delay[slice(None) if known.joint < 0 else known.joint] += known.amplitude[0]
            elif not isinstance(term, EffortTerm):
                self.left_out.append(f'{term.identifier} of {where}')
            elif _is_native(model, term.identifier, where):
                continue
            elif not _is_joint_wise(term, known.inner):
                alone.append(_Part(term, known.joint, known.inner,
                                   tuple(np.array([x]) for x in known.amplitude)))  # fmt: skip
            else:
                # The second of a kind in a joint, such as another harmonic, is in another group.
                k = 0
                while any(x.joint == known.joint for x in groups.get((type(term), k), ())):
                    k += 1
                groups.setdefault((type(term), k), []).append(known)
        return [*(_together(group, len(names)) for group in groups.values()), *alone]

    def _damp(self, model: Any) -> None:
        for name, joint, dof in zip(
            self.content.joints, self.content.joints.values(), self._dof, strict=True
        ):
            if joint.friction is not None and 'viscous' in joint.friction.parameters:
                slope = joint.friction.parameters['viscous'].value
                if slope < 0.0:
                    raise ConfigurationError(f'viscous friction of {name} is below 0: {slope:g}')
                model.dof_damping[dof] = slope
        for known in known_terms(self.content):
            # A deviation that a diagnosis could not write into the law.
            if known.term.identifier == 'viscous':
                model.dof_damping[self._dof[known.joint]] += float(known.amplitude[0])

    def _is_constant(self, part: _Part) -> bool:
        """Tell whether a part depends on the sign of motion alone, and keep it if so."""
        if not isinstance(part.joints, slice):
            return False
        rng, motion, found = np.random.default_rng(0), self._motion, []
        for _ in range(3):
            time, q, v, load = rng.uniform(-1.0, 1.0, 4)
            shape = motion.v.shape
            some = replace(motion, time=np.full(2, time), q=np.full(shape, q),
                           v=np.full(shape, v), load=np.full(shape, load))  # fmt: skip
            found.append(_effort(part, some, np.zeros((2, 0))))
        if not (np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])):
            return False
        self._constant += found[0]
        return True

    def _needs_load(self) -> bool:
        # At rest, where no part has faded.
        alone = self._total()
        self._motion.load[:] = 1.0
        loaded = self._total()
        self._motion.load[:] = 0.0
        return not np.array_equal(alone, loaded)

    def _total(self) -> tuple[FloatArray, FloatArray]:
        """Return the level that opposes motion and what acts in both directions, (n,) each."""
        total = self._constant.copy()
        for part, state in zip(self._parts, self._states, strict=True):
            total[:, part.joints] += _effort(part, self._motion, state)
        return 0.5 * (total[0] - total[1]), 0.5 * (total[0] + total[1])

    def apply(self, model: Any, data: Any) -> None:
        """
        Set ``dof_frictionloss`` and ``qfrc_applied`` of the model's joints for the next step.

        Friction that follows the load has that of the last step. A torque of one's own goes
        through an actuator, or is added to ``qfrc_applied`` after this.
        """
        motion = self._motion
        q, v = data.qpos[self._q], data.qvel[self._dof]
        if data.time < self._time or self._time == -np.inf:
            self._states = [np.repeat(state, 2, axis=0) for state in self._fresh]
            self._before = q
            self._queue.clear()
        self._time = data.time
        motion.time[:] = data.time
        motion.q[:] = q
        motion.v[:] = v
        if self._by_load:
            acceleration = data.qacc
            engine().mj_mulM(model, data, self._work, acceleration)
            motion.load[:] = (self._work + data.qfrc_bias)[self._dof] - self._rotor * acceleration[
                self._dof
            ]
        moved = q - self._before
        for k, part in enumerate(self._parts):
            if not isinstance(part.joints, slice):
                dq = np.full(2, moved[part.joints])
                self._states[k] = part.term.next_state(self._states[k], dq, part.inner)
        self._before = q
        level, both = self._total()
        model.dof_frictionloss[self._dof] = np.maximum(level, 0.0)
        data.qfrc_applied[self._dof] = -both

    def reports(self, torque: FloatArray) -> FloatArray:
        """Return what is reported of torques (..., n), delay left out."""
        for report in self._reports:
            torque = report.reported(torque)
        return torque

    def torques(self, reported: FloatArray) -> FloatArray:
        """Return the torques (..., n) behind what was reported, delay left out."""
        for report in reversed(self._reports):
            reported = report.torque(reported)
        return reported

    def reported(self, time: float, torque: FloatArray) -> FloatArray:
        """
        Return what the actuators report of a torque (n,) at the joints: scale, bias, delay.

        To be called at every sample: what is reported late is what was given before.
        """
        self._queue.append((time, self.reports(torque)))
        seen = time - self.delay + 1e-12
        while len(self._queue) > 1 and self._queue[1][0] <= seen.min():
            self._queue.popleft()
        (_, result), *later = self._queue
        for at, reported in later:
            result = np.where(at <= seen, reported, result)
        return result


def ripple_actuators(model: Any) -> list[int]:
    """Return the actuators of an MjModel that are ripple of their joints."""
    names = (model.actuator(k).name for k in range(len(model.actuator_trnid)))
    return [k for k, name in enumerate(names) if name.startswith(RIPPLE)]


def _is_native(model: Any, term: str, joint: str) -> bool:
    """Tell whether the MjModel has a term of a joint itself."""
    if term == 'spring':
        return bool(model.jnt_stiffness[joint_id(model, joint)])
    return term == 'viscous' or (term == 'cogging' and bool(ripple_actuators(model)))


def apply_friction(
    model: Any, data: Any, source: RobotModelFile | str | Path | None = None
) -> Friction:
    """
    Set friction for the next ``mj_step``: call it before each.

    ::

        while True:
            apply_friction(model, data)
            mujoco.mj_step(model, data)

    :param source: model folder where the MJCF holds no model; see :class:`Friction`, whose errors
        are those of the first call, and which is returned.
    """
    found = _KNOWN.get(data)
    if found is None or found[0]() is not model:
        found = _KNOWN[data] = (weakref.ref(model), Friction(model, source))
    found[1].apply(model, data)
    return found[1]


_KNOWN: weakref.WeakKeyDictionary[Any, tuple[Any, Friction]] = weakref.WeakKeyDictionary()


def embedded(model: RobotModelFile) -> str:
    """Return a model as the text that an MJCF holds: one line of JSON, without provenance."""
    document = yaml.safe_load(replace(model, provenance={}).to_yaml())
    return json.dumps(document, separators=(',', ':'))


def _content(model: Any, source: RobotModelFile | str | Path | None) -> RobotModelFile:
    if isinstance(source, RobotModelFile):
        return source
    if source is not None:
        return read_model(source)
    mujoco = engine()
    k = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXT, TEXT)
    if k < 0:
        raise ConfigurationError(
            f'the MJCF holds no model (custom text {TEXT}): write it with sosml export --to mjcf, '
            'or give the model folder'
        )
    first = int(model.text_adr[k])
    text = bytes(model.text_data)[first : first + int(model.text_size[k]) - 1].decode()
    return parse_model(text, f'text {TEXT} of the MJCF')


def _effort(part: _Part, motion: Motion, state: FloatArray) -> FloatArray:
    """Return the effort (2, n) of a part at both signs, (2,) of one in one joint."""
    found = part.term.effort(motion, part.joints, part.inner, state)
    return cast(FloatArray, sum(x * y for x, y in zip(part.amplitudes, found, strict=True)))


def _is_joint_wise(term: EffortTerm, inner: Inner) -> bool:
    """Tell whether a term can be computed in several joints at once: without states or time."""
    rows, n = 3, 2
    x = np.ones((rows, n))
    motion = Motion(np.ones(rows), x, x, x, x, np.full((rows, n), np.nan))
    if term.path_state(np.zeros(1), inner).shape[1]:
        return False
    arrays = cast(Inner, {name: np.full(n, value) for name, value in inner.items()})
    try:
        found = term.effort(motion, slice(None), arrays, np.zeros((rows, 0)))
    except (ValueError, TypeError):
        return False
    return all(np.shape(part) == x.shape for part in found)


def _together(group: Sequence[KnownTerm], n: int) -> _Part:
    """Return terms of one kind, each in another joint, as one."""
    term = cast(EffortTerm, group[0].term)
    inner = {name: np.ones(n) for name in term.inner}
    sizes = tuple(np.zeros(n) for _ in term.amplitudes)
    for known in group:
        for name, value in known.inner.items():
            inner[name][known.joint] = value
        for array, value in zip(sizes, known.amplitude, strict=True):
            array[known.joint] = value
    # Arrays, one entry for each joint: see EffortTerm.effort.
    return _Part(term, slice(None), cast(Inner, inner), sizes)
