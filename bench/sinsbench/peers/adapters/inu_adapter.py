"""inu: its mechanisation over the turning Earth."""

from typing import Any

import inu
import numpy as np
import r3f
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mechanised(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Navigate with mean rates, from rest at 45 degrees north, and take Earth's rotation and the travel out.

    Both frames, north-east-down at the start and inertial, coincide at time zero. The height is held: else the body,
    which no ground carries, would fall.
    """
    # The attitudes are those before each sample: one more, which does not count, for the last of them.
    rates, forces = (np.vstack([mean, mean[-1:]]).T for mean in (rate, force))
    path, _, angles = inu.mech(
        forces,
        rates,
        llh0=np.array([np.pi / 4, 0.0, 0.0]),
        vne0=np.zeros(3),
        rpy0=r3f.quat_to_rpy(attitude0),
        T=interval,
        hae_t=np.zeros(len(rate) + 1),
        show_progress=False,
    )
    turned = path[1] + inu.W_EI * interval * np.arange(len(rate) + 1)
    local = r3f.dcm_ecef_to_navigation(path[0], turned)  # these matrices are passive: from reference to body
    return r3f.dcm_to_quat(r3f.rpy_to_dcm(angles) @ local @ local[0].T).T
