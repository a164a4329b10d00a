"""Navigation by on-board integration of the equations of gyroscopic systems: Chelnokov 1991.

`equations` holds the right-hand sides, `systems` the table that says what each is and when it holds, `drivers` the
integrators that all of them share, `subjects` the callables that can be scored.
"""
