"""Estimators of the attitude of an antenna on a mast on a moving vehicle: Sokolov, Pogorelov, Reshetnikova 2024.

`terms` holds the equations' coefficients, corrected, as printed and with each fault, as data; `model` the equations,
`jacobians` and `disturbances` their derivatives and their noise; `continuous` the filter of the paper, `discrete` the
multiplicative filter and `relinearised` the one that goes beyond both; `catalogue` names the subjects.
"""
