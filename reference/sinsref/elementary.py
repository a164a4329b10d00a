"""Elementary functions that formulas need near the zeros of their denominators."""

from __future__ import annotations

from sinsref.arithmetic import Arithmetic, Number


def cosine_and_sinc(ar: Arithmetic, square: Number) -> tuple[Number, Number]:
    """Return cos(x) and sin(x)/x as functions of x squared, by their power series where x is small.

    Near x = 0 the closed form divides two small numbers, and its derivatives (dual parts, Taylor coefficients)
    cancel; the series is an entire function of x squared and has neither trouble.

    Parameters
    ----------
    ar : Arithmetic
    square : Number
        x squared, not negative.
    """
    if ar.magnitude(square) > 0.0625:
        x = ar.sqrt(square)
        sine, cosine = ar.sin_cos(x)
        return cosine, sine / x
    term = ar.number(1) + square * 0
    cosine, sinc = term, term
    size, k = 1.0, 0
    # Terms fall by more than 16 each: what follows a negligible term is within a fifteenth of it.
    # Derivatives gain a factor k each, which the surplus of resolution covers.
    while size > ar.resolution * 1e-9:
        k += 1
        term = -(term * square) / ((2 * k - 1) * (2 * k))
        cosine = cosine + term
        sinc = sinc + term / (2 * k + 1)
        size /= 16 * (2 * k - 1) * (2 * k)
    return ar.widen(cosine, term / 8), ar.widen(sinc, term / 8)
