# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which causes a diagnosis leaves open, and which candidates look most alike."""

import numpy as np

from sosml_friction.arrays import IndexArray
from sosml_friction.diagnosis.decision.confusability import Confusability
from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.model.terms.kinds.term import ALL_JOINTS

Key = tuple[str, str]


def ambiguous_pairs(diagnosis: Diagnosis) -> list[tuple[Key, Key]]:
    """Return each cause with each of its rivals, as (effect, joint)."""
    pairs = []
    for cause in diagnosis.terms:
        for rival in cause.rivals:
            effect, _, joint = rival.partition('@')
            pairs.append((cause.key, (effect, joint or cause.joint)))
    return pairs


def most_alike(found: Confusability, kept: set[Key], most: int) -> IndexArray:
    """Return up to ``most`` candidates, joint by joint: those of ``kept``, then the most alike."""
    keys = list(zip(found.effects, found.joints, strict=True))
    off = found.share - np.diag(np.diag(found.share))
    alike = np.maximum(off.max(axis=0), off.max(axis=1))
    alike[[k for k, key in enumerate(keys) if key in kept]] = 2.0
    chosen = np.argsort(-alike, kind='stable')[:most]
    joints = list(dict.fromkeys(found.joints))
    joints.sort(key=lambda joint: joint == ALL_JOINTS)
    return np.array(sorted(chosen, key=lambda k: (joints.index(found.joints[k]), k)))
