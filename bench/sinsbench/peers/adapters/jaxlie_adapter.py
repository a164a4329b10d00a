"""Jaxlie: exponentials, in a compiled scan."""

from typing import Any

import jax
import jaxlie
import numpy as np
from jax import numpy as jnp
from numpy.typing import NDArray

Array = NDArray[np.float64]

jax.config.update("jax_enable_x64", True)


def _composed(angle: Any, attitude0: Any) -> Any:
    def step(attitude: Any, increment: Any) -> tuple[Any, Any]:
        after = attitude @ jaxlie.SO3.exp(increment)
        return after, after.wxyz

    return jax.lax.scan(step, jaxlie.SO3(attitude0), angle)[1]


_compiled = jax.jit(_composed)


def exponential(angle: Array, velocity: Array, interval: float, attitude0: Array, velocity0: Array) -> Any:
    """Compose the exponentials of the angle increments."""
    made = _compiled(jnp.asarray(angle), jnp.asarray(attitude0))
    return np.vstack([attitude0, np.asarray(made)])
