"""The Faddeeva function w(z), of which the Voigt profile is the real part.

Near the origin Weideman's rational series, SIAM J. Numer. Anal. 31, 1497 (1994); far from it
Laplace's continued fraction (Gautschi, SIAM J. Numer. Anal. 7, 187 (1970)).
"""

import numpy as np

from ..spectrum.kernel import inner_kernel, kernel

N_TERMS = 24  # of Weideman's series: right to 1e-9 for |z| < 8
SCALE = float(np.sqrt(N_TERMS / np.sqrt(2.0)))  # Weideman's L
FAR_SQUARED = 64.0  # |z|^2 from which the continued fraction is as right
N_FRACTION = 8
ONE_BY_ROOT_PI = float(1.0 / np.sqrt(np.pi))


def _weideman_terms(n: int) -> np.ndarray:
    """Weideman's coefficients, lowest power first (his program `cef`)."""
    m = 2 * n
    theta = np.arange(-m + 1, m) * np.pi / m
    t = SCALE * np.tan(theta / 2)
    f = np.concatenate(([0.0], np.exp(-(t**2)) * (SCALE**2 + t**2)))
    return np.real(np.fft.fft(np.fft.fftshift(f)))[1 : n + 1] / (2 * m)


TERMS = _weideman_terms(N_TERMS)


@kernel
def faddeeva(z):
    """w(z) = exp(-z^2) erfc(-iz) for Im z >= 0."""
    if z.real * z.real + z.imag * z.imag > FAR_SQUARED:
        fraction = z
        for n in range(N_FRACTION, 0, -1):
            fraction = z - 0.5 * n / fraction
        return 1j * ONE_BY_ROOT_PI / fraction
    below = SCALE - 1j * z
    turned = (SCALE + 1j * z) / below
    # A polynomial with real terms at a complex point (Knuth, vol. 2, 4.6.4): half the products.
    twice_real = 2.0 * turned.real
    squared = turned.real * turned.real + turned.imag * turned.imag
    high, low = TERMS[N_TERMS - 1], TERMS[N_TERMS - 2]
    for n in range(N_TERMS - 3, -1, -1):
        high, low = low + twice_real * high, TERMS[n] - squared * high
    series = high * turned + low
    return (2.0 * series / below + ONE_BY_ROOT_PI) / below


@inner_kernel
def faddeeva_row(x, centre, scale, height, real, imag):
    """Fill real and imag (m,) with w((x - centre) scale + i height) for x of shape (m,).

    The series alone, to 1e-9 of its largest value: enough for a fit, not for far wings by themselves.
    The loop over terms is unrolled when it is compiled, that over x works on several channels at once.
    """
    top, level = SCALE + height, SCALE * SCALE - height * height
    for i in range(len(x)):
        away = (x[i] - centre) * scale
        inverse = 1.0 / (top * top + away * away)
        by_real, by_imag = top * inverse, away * inverse  # 1 / (L - iz)
        turned_real = (level - away * away) * inverse
        turned_imag = 2.0 * SCALE * by_imag
        twice_real = 2.0 * turned_real
        squared = turned_real * turned_real + turned_imag * turned_imag
        high, low = TERMS[N_TERMS - 1], TERMS[N_TERMS - 2]
        for n in range(N_TERMS - 3, -1, -1):
            high, low = low + twice_real * high, TERMS[n] - squared * high
        p_real, p_imag = 2.0 * (high * turned_real + low), 2.0 * high * turned_imag
        q_real = p_real * by_real - p_imag * by_imag + ONE_BY_ROOT_PI
        q_imag = p_real * by_imag + p_imag * by_real
        real[i] = q_real * by_real - q_imag * by_imag
        imag[i] = q_real * by_imag + q_imag * by_real
