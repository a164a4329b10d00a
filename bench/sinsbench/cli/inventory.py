"""What there is: datasets, cases, strata, subjects, papers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any


def _datasets() -> list[dict[str, Any]]:
    from sinsdata.format.schema import DATASETS
    from sinsdata.tiers import cases_of, tiers_of

    return [
        {
            "dataset": name,
            "version": about.version,
            "tiers (cases)": ", ".join(f"{tier} ({len(cases_of(name, tier))})" for tier in tiers_of(name)),
            "tables": ", ".join(about.tables),
            "title": about.title,
        }
        for name, about in DATASETS.items()
    ]


def _strata() -> list[dict[str, Any]]:
    from sinsdata.format.schema import DATASETS
    from sinsdata.tiers import strata_of

    return [
        {"dataset": dataset, "stratum": name, "cases": cases, "rule": rule}
        for dataset in DATASETS
        for name, cases, rule in strata_of(dataset)
    ]


def _cases() -> list[dict[str, Any]]:
    from sinsdata.cases import CASE_CLASSES
    from sinsdata.tiers import paper_cases

    return [
        {
            "dataset": dataset,
            "case": case.name,
            "duration, s": float(case.duration),
            "interval, s": float(case.interval),
            "samples": case.samples,
        }
        for dataset in CASE_CLASSES
        for case in paper_cases(dataset)
    ]


def _subjects() -> list[dict[str, Any]]:
    from sinsbench.subjects.registry import BUILT_IN

    return [
        {
            "subject": subject.name,
            "dataset": subject.dataset,
            "order": subject.order,
            "of drift": subject.order_drift,
            "of drift, narrow cone": subject.order_coning,
            "of velocity": subject.order_velocity,
            "samples per step": subject.samples_per_step,
            "summary": subject.summary,
            "source": subject.source,
        }
        for subject in BUILT_IN.values()
    ]


def _papers() -> list[dict[str, Any]]:
    from sinsbench.claims.model import PAPERS, load_claims

    return [{"paper": paper, "claims": len(load_claims(paper))} for paper in PAPERS]


#: What can be listed.
INVENTORIES: Mapping[str, Callable[[], list[dict[str, Any]]]] = {
    "datasets": _datasets,
    "cases": _cases,
    "strata": _strata,
    "subjects": _subjects,
    "papers": _papers,
}
