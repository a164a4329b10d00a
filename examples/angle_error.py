"""The error of a crude attitude integrator against truth, with pandas and numpy alone, in the folder of a bundle."""

import numpy as np
import pandas as pd

FOLDER, CASE = "dual_precession/paper", [("case", "==", "variant1_coning")]
increments = pd.read_parquet(f"{FOLDER}/increments.parquet", filters=CASE)
truth = pd.read_parquet(f"{FOLDER}/truth.parquet", filters=CASE)


def product(p, q):
    """Hamilton product of quaternions, scalar first."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *vector])


# A crude integrator: over each sample the body turns about an axis that stands still.
exact = truth[["q_w", "q_x", "q_y", "q_z"]].to_numpy()
attitude = exact[0]
for angle in increments[["angle_x", "angle_y", "angle_z"]].to_numpy():
    half = np.linalg.norm(angle) / 2
    attitude = product(attitude, np.array([np.cos(half), *(np.sinc(half / np.pi) * angle / 2)]))

error = product(exact[-1] * [1, -1, -1, -1], attitude)  # from the true body to the computed one
angle = 2 * np.arctan2(np.linalg.norm(error[1:]), abs(error[0]))
time = truth["time"].iloc[-1]
print(f"error angle after {time:g} s: {np.degrees(angle) * 3600:.3f} arcsec")
print(f"drift: {np.degrees(angle) / (time / 3600):.4f} deg/h")
