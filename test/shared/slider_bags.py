# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of the EMPS axis with friction that is known, and what the tool must print."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.share import share_directory

SCHEMAS = Path(__file__).resolve().parents[2] / 'docs' / 'schema'
EMPS = share_directory() / 'config' / 'emps'
COULOMB, VISCOUS = 20.0, 200.0


def slider_log(effort=True, names=('slider',)):
    """Return the motion of the EMPS axis on a speed ladder, with friction that is known."""
    robot = read_model(EMPS).make_robot()
    ladder = speed_ladder({'slider': 0.1}, {'slider': 0.12}, [0.01, 0.04, 0.1], plateau_s=0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.004)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    noise = np.random.default_rng(3)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += COULOMB * np.sign(v) + VISCOUS * v + noise.normal(0.0, 0.3, v.shape)
    if not effort:
        tau[:] = np.nan
    return JointLog(names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


def record(folder, log, urdf=True, model=True):
    nominal = read_model(EMPS)
    return write_joint_log(
        log,
        folder,
        nominal.urdf if urdf else None,
        (EMPS / 'model.yaml').read_text(encoding='utf-8') if model else None,
    )


def text_message():
    text = message_class('std_msgs/msg/String')()
    text.data = 'hello'
    return serialize(text)


def text_bag(folder, messages=1):
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/greeting', 'std_msgs/msg/String')
        for k in range(messages):
            recorder.write('/greeting', text_message(), k)
    return folder


def checked(text, name):
    """Return the only JSON object of a text, checked against its schema."""
    document = json.loads(text, parse_constant=pytest.fail)
    jsonschema.validate(
        document,
        json.loads((SCHEMAS / f'{name}.schema.json').read_text()),
        cls=jsonschema.Draft202012Validator,
    )
    return document
