# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a user is told of a fit of one or several recordings."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import RenderableType

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.source import bag_labels
from sosml_friction.identification.data_finding import NOTE
from sosml_friction.identification.effort_timing import TIMING
from sosml_friction.identification.late_effort import LATE
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.report.fit.findings import simulation_lines
from sosml_friction.report.fit.inverse_view import inverse_table


@dataclass(frozen=True)
class FitOutcome:
    """
    Hold a fit that was written to ``folder``, ready to be printed.

    ``analyses``: by the path of each recording; ``document``: the object of ``sosml fit --json``;
    ``found`` and ``open_ends``: sentences before and after ``table``; ``failed``: joints that
    could not be fitted.
    """

    folder: Path
    analyses: Mapping[Path, BagAnalysis]
    document: Mapping[str, Any]
    found: Sequence[str]
    table: RenderableType
    open_ends: Sequence[str]
    failed: Sequence[str]

    @property
    def is_no(self) -> bool:
        """Tell whether a joint that reports effort has no fit: it rests, or was refused."""
        return any(
            (one.data_checks is not None and one.data_checks.not_fitted)
            or any(np.isfinite(one.log.select([joint]).tau).any() for joint in self.failed)
            for one in self.analyses.values()
        )

    def blocks(self) -> Iterator[str | RenderableType]:
        """Return what is printed on stdout: sentences and tables."""
        several = len(self.analyses) > 1
        yield from self.found
        yield self.table
        yield from self.open_ends
        for bag, one in self.analyses.items():
            if one.inverse is not None:
                if several:
                    yield f'{bag}:'
                yield inverse_table(one, one.inverse)
            yield from simulation_lines(one)
        yield f'Model, report.html, fit.json and segments.csv are in {self.folder}'
        if not self.is_no:
            yield (
                f'Next: sosml diagnose with --model {self.folder} says what the model lacks, '
                f'sosml export {self.folder} takes it to other programs'
            )

    def remarks(self) -> Iterator[str]:
        """Return what is wrong with the recordings or is no evidence, for stderr."""
        several = len(self.analyses) > 1
        said: dict[str, list[str]] = {}
        for label, bag in bag_labels(list(self.analyses)).items():
            one = self.analyses[bag]
            if one.model.provenance.get('recovered'):
                yield f'{bag} is cut off or damaged: only its readable part was used'
            for sentence in one.data_checks.sentences if one.data_checks else ():
                said.setdefault(sentence, []).append(label)
            if not several:
                for joint, reason in one.unmodelled.items():
                    yield f'{joint} has no friction in the model: {reason}'
        for sentence, labels in said.items():
            whose = '' if len(labels) == len(self.analyses) else f'{", ".join(labels)}: '
            yield f'{whose}{sentence}'
        gains = dict.fromkeys(g for one in self.analyses.values() for g in one.configuration.gains)
        if carrying := ', '.join(name for name in gains if OBSERVERS[name].carries_law):
            yield (
                f'{carrying} has a friction law inside: a law fitted to its estimate is that one '
                'again, and no evidence'
            )


def hold_remark(analyses: Mapping[Path, BagAnalysis], namespace: str | None) -> Iterator[str]:
    """Return what was found or assumed of bags that do not say where effort holds."""
    silent, said = [], dict[str, None]()
    for bag, one in analyses.items():
        checks = one.data_checks
        told = [f for f in checks.findings if f.check in (TIMING, LATE)] if checks else []
        # A warning is among the remarks.
        said |= dict.fromkeys(f.sentence for f in told if f.level == NOTE)
        if not told and Bag.open(bag, namespace).text('observer_configuration') is None:
            silent.append(str(bag))
    # Recordings that are compared with the bodies together say the same.
    yield from (f'{text[:1].upper()}{text[1:]}.' for text in said)
    if silent:
        who = 'The bag does' if len(analyses) == 1 else f'Of the bags, {", ".join(silent)} do'
        yield (
            f'{who} not say where in an interval effort holds, so it was taken for a\n'
            'command (start). A measured current holds until its sample (--effort-hold end), '
            'and\na period of delay reads as viscous friction.'
        )
