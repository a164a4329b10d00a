"""qmt: its strapdown integration."""

from typing import Any

import numpy as np
import qmt
from numpy.typing import NDArray

Array = NDArray[np.float64]


def strapdown(rate: Array, force: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Integrate mean rates; the function starts at the identity, what it returns is the rotation since then."""
    turned = np.vstack([[1.0, 0.0, 0.0, 0.0], qmt.quatFromGyrStrapdown(rate, 1 / interval)])
    return qmt.qmult(attitude0, turned)
