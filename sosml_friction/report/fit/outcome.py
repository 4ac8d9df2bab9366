# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit one or several recordings, write the results, and say what a user is told of them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import RenderableType

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.source import bag_labels, bag_name
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.data_finding import NOTE
from sosml_friction.identification.effort_timing import TIMING
from sosml_friction.identification.late_effort import LATE
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis, analyse_bags
from sosml_friction.model.model_folder import RobotModelFile, read_model
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.report.common.figure_files import write_figures
from sosml_friction.report.common.output import check_output_folder
from sosml_friction.report.common.tables import summary_blocks
from sosml_friction.report.fit import results
from sosml_friction.report.fit.findings import shared_sentences, simulation_lines
from sosml_friction.report.fit.inverse_view import inverse_table
from sosml_friction.study.gain_proposal import parse_effort_hold


@dataclass(frozen=True)
class FitOutcome:
    """Hold a fit of the recordings ``bags`` that was written to ``folder``."""

    folder: Path
    bags: Sequence[Path]
    analysis: BagAnalysis | BagsAnalysis
    truth: RobotModelFile | None = None

    @cached_property
    def analyses(self) -> dict[Path, BagAnalysis]:
        """Return the fit of each recording by its path."""
        known = self.analysis
        own = known.bags.values() if isinstance(known, BagsAnalysis) else [known]
        return dict(zip(self.bags, own, strict=True))

    @property
    def document(self) -> dict[str, Any]:
        """Return the object of ``sosml fit --json``."""
        return results.fit_document(self.analysis, self.truth)

    @property
    def is_no(self) -> bool:
        """Tell whether a joint that reports effort has no fit: it rests, or was refused."""
        known = self.analysis
        if isinstance(known, BagsAnalysis):
            apart = known.consolidation
            without = [n for n, joint in known.model.joints.items() if joint.friction is None]
            failed = [*apart.unavailable, *(n for n in apart.joints if n in without)]
        else:
            fit = known.fit
            failed = [*(j for j in fit.unavailable if j not in fit.joints), *known.unmodelled]
        return any(
            (one.data_checks is not None and one.data_checks.not_fitted)
            or any(np.isfinite(one.log.select([joint]).tau).any() for joint in failed)
            for one in self.analyses.values()
        )

    def blocks(self) -> Iterator[str | RenderableType]:
        """Return what is printed on stdout: sentences and tables."""
        yield from summary_blocks(self.analysis, self.truth)
        for bag, one in self.analyses.items():
            if one.inverse is not None:
                if len(self.bags) > 1:
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
        found: dict[str, Sequence[str]] = {}
        for label, bag in bag_labels(list(self.bags)).items():
            one = self.analyses[bag]
            if one.model.provenance.get('recovered'):
                yield f'{bag} is cut off or damaged: only its readable part was used'
            found[label] = one.data_checks.sentences if one.data_checks else ()
            for joint, reason in one.unmodelled.items() if len(self.bags) == 1 else ():
                yield f'{joint} has no friction in the model: {reason}'
        yield from shared_sentences(found)
        gains = dict.fromkeys(g for one in self.analyses.values() for g in one.configuration.gains)
        if carrying := ', '.join(name for name in gains if OBSERVERS[name].carries_law):
            yield (
                f'{carrying} has a friction law inside: a law fitted to its estimate is that one '
                'again, and no evidence'
            )

    def hold_remark(self, namespace: str | None) -> Iterator[str]:
        """Return what was found or assumed of bags that do not say where effort holds."""
        silent, said = [], dict[str, None]()
        for bag, one in self.analyses.items():
            checks = one.data_checks
            told = [f for f in checks.findings if f.check in (TIMING, LATE)] if checks else []
            # A warning is among the remarks.
            said |= dict.fromkeys(f.sentence for f in told if f.level == NOTE)
            if not told and Bag.open(bag, namespace).text('observer_configuration') is None:
                silent.append(str(bag))
        # Recordings that are compared with the bodies together say the same.
        yield from (f'{text[:1].upper()}{text[1:]}.' for text in said)
        if silent:
            who = 'The bag does' if len(self.bags) == 1 else f'Of the bags, {", ".join(silent)} do'
            yield (
                f'{who} not say where in an interval effort holds, so it was taken for a\n'
                'command (start). --effort-hold states it: a value measured at its stamp is mean, '
                'one\nof the time since the sample before end; a delay reads as viscous friction.'
            )


def run_fit(
    bags: Sequence[Path],
    out: Path | None = None,
    truth: Path | None = None,
    effort_hold: Sequence[str] = (),
    namespace: str | None = None,
    roles: Sequence[str] = (),
    own_bias: bool | None = None,
    step: Callable[[str], None] = lambda what: None,
    figures: Sequence[str] = (),
    **how: Any,
) -> FitOutcome:
    """
    Fit friction to recordings and write a model folder with its report.

    :param out: folder of the results; None: the name of the first bag and ``_fit``.
    :param how: the other arguments of
        :func:`~sosml_friction.identification.bag_analysis.analyse_bag`.
    :raises SosmlFrictionError: as that function, or if ``out`` holds something else.
    """
    several = len(bags) > 1
    if not several and (roles or own_bias is not None):
        raise ConfigurationError(
            f'{"--role" if roles else "--own-bias"} says how several bags are put together, and '
            'one is given: give the others too, or leave it out'
        )
    folder = check_output_folder(out or Path(f'{bag_name(bags[0])}_fit'), results.KIND)
    known = None if truth is None else read_model(truth)
    names = Bag.open(bags[0], namespace).joint_log().names if effort_hold else ()
    how |= {'namespace': namespace, 'effort_hold': parse_effort_hold(effort_hold, names)}
    analysis = (
        analyse_bags(bags, roles=roles, own_bias=own_bias, progress=step, **how)
        if several
        else analyse_bag(bags[0], progress=step, **how)
    )
    step('drawing the report')
    results.write_results(folder, analysis, known, None, lambda what: step(f'drawing {what}'))
    for report, drawn in results.figure_views(analysis, known):
        write_figures(folder, report, drawn, figures)
    return FitOutcome(folder, bags, analysis, known)
