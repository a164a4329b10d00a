"""Constants of the Earth as the equator paper prints them, exact decimals.

Source: Loginov, Tkachenko, Chelnokov 2013, section 1.
"""

from __future__ import annotations

from sinsref.exact import ExactNumber

#: Angular rate of the Earth's rotation, rad/s (the paper's rounding, not 7.292115e-5).
ROTATION_RATE = ExactNumber("7.29e-5")
#: Semi-major axis of the Krasovsky ellipsoid, m.
SEMI_MAJOR_AXIS = ExactNumber("6378245")
#: Square of the first eccentricity.
ECCENTRICITY_SQUARED = ExactNumber("0.006692")
#: Gravity on the equator at zero height, m/s^2.
EQUATORIAL_GRAVITY = ExactNumber("9.78049")
#: Relative excess of gravity at the poles.
GRAVITY_FLATTENING = ExactNumber("5.317e-3")
