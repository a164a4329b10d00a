"""Ground-truth datasets: cases, certified generation, Parquet, manifests, verification, publishing and loading.

`load` gets a published dataset, `Dataset(folder)` opens one that is on disk; everything else is in the modules.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sinsdata.publishing.loading import Dataset


def load(dataset: str, tier: str = "paper", **options: Any) -> Dataset:
    """Return a published dataset (`sinsdata.publishing.loading.load`).

    Parameters
    ----------
    dataset : str
        Such as ``dual_precession``.
    tier : str, default "paper"
        ``short`` is in the package; others come from the cache, a mirror or a bundle.
    **options
        As for `sinsdata.publishing.loading.load`.

    Returns
    -------
    sinsdata.publishing.loading.Dataset
    """
    # Here, so that importing the package stays cheap for who only wants a part of it.
    from sinsdata.publishing.loading import load as load_dataset

    return load_dataset(dataset, tier, **options)


def __getattr__(name: str) -> Any:
    if name == "Dataset":
        from sinsdata.publishing.loading import Dataset

        return Dataset
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
