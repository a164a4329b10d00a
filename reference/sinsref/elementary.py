"""Elementary functions that formulas need near the zeros of their denominators."""

from __future__ import annotations

from math import atan2

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


def angle(ar: Arithmetic, sine: Number, cosine: Number) -> Number:
    """Return the angle in (-pi, pi] that has a sine and a cosine, of numbers that have a nearest binary64.

    The angle of the binary64 is corrected by the arcsine of what is left, a power series of terms that fall by 1e-32.

    Parameters
    ----------
    ar : Arithmetic
    sine, cosine : Number
        Their squares add up to 1.
    """
    guess = ar.number(atan2(float(sine), float(cosine)))
    sine_0, cosine_0 = ar.sin_cos(guess)
    rest = sine * cosine_0 - cosine * sine_0
    total = term = rest
    k = 0
    while ar.magnitude(term) > ar.resolution * 1e-9:
        k += 1
        term = term * rest * rest * (2 * k - 1) ** 2 / ((2 * k) * (2 * k + 1))
        total = total + term
    return guess + ar.widen(total, term)
