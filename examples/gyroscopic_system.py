"""A navigation system of one's own on gyro_systems: the vertical r and the moment of the velocity K = r x v, on board.

r' = K x r/R and K' = r x a over a sphere of radius R, with the specific force a in inertial axes: exact without errors,
whatever the motion, and without division by the speed. Classical Runge-Kutta, a step spans two intervals.
"""

import numpy as np


def product(p, q):
    """Return the Hamilton product of two quaternions, scalar first."""
    return np.concatenate([[p[0] * q[0] - p[1:] @ q[1:]], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def turned(q, vector):
    """Return q o vector o conj(q) for a unit quaternion."""
    twist = 2 * np.cross(q[1:], vector)
    return vector + q[0] * twist + np.cross(q[1:], twist)


def moment_of_velocity(inputs, start):
    """Integrate attitude s, vertical r and moment K from points of rate and specific force, (n+1, 3) each."""
    step = 2 * (inputs.time[1] - inputs.time[0])

    def slopes(state, k):
        s, r, moment = state[:4], state[4:7], state[7:]
        force = turned(s / np.linalg.norm(s), inputs.specific_force[k])
        rotation = product(s, np.append(0.0, inputs.rate[k])) / 2
        return np.concatenate([rotation, np.cross(moment, r) / start.radius, np.cross(r, force)])

    state = np.concatenate([start.attitude, start.vertical, np.cross(start.vertical, start.velocity)])
    states = [state]
    for k in range(0, len(inputs.time) - 1, 2):
        first = slopes(state, k)
        second = slopes(state + step / 2 * first, k + 1)
        third = slopes(state + step / 2 * second, k + 1)
        fourth = slopes(state + step * third, k + 2)
        state = state + step / 6 * (first + 2 * second + 2 * third + fourth)
        states.append(state)
    states = np.array(states)
    vertical = states[:, 4:7] / np.linalg.norm(states[:, 4:7], axis=1, keepdims=True)
    # Heading, pitch and roll are read out from a trihedron with this third axis; its azimuth does not matter.
    x, y, z = vertical.T
    trihedron = np.column_stack([1 + z, -y, x, 0 * z])
    return {
        "vertical": vertical,
        "attitude": states[:, :4],
        "trihedron": trihedron,
        "speed": np.linalg.norm(states[:, 7:], axis=1),
    }


moment_of_velocity.takes = "points"
moment_of_velocity.samples_per_step = 2
