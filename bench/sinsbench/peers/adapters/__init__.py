"""One script a package, run by its path in that package's environment: NumPy, the package, and nothing of ours.

Each function obeys the contract of an integrator, ``f(angle, velocity, interval, attitude0, velocity0)``, and does what
a user of the package writes. It translates conventions; the package's own errors are left alone.
"""
