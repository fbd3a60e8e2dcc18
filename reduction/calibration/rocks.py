"""What rocks are made of: ln of the mass fractions of eight elements, and how they vary together.

Mean compositions of igneous rocks after Le Maitre (J. Petrol. 17, 589 (1976)), shale and greywacke: silicon,
potassium and sodium go with each other, and so do iron, magnesium, calcium and titanium.
"""

from functools import lru_cache

import numpy as np

from ..spectrum.spectrum import FloatArray

ELEMENTS = ("Si", "Ti", "Al", "Fe", "Mg", "Ca", "Na", "K")
_OF_OXIDE = (0.4674, 0.5993, 0.5293, 0.6994, 0.6030, 0.7147, 0.7419, 0.8302)
# wt % of SiO2, TiO2, Al2O3, Fe2O3 (all iron), MgO, CaO, Na2O, K2O.
_MEANS = (
    (71.3, 0.31, 14.3, 3.0, 0.71, 1.8, 3.7, 4.1),  # granite
    (66.1, 0.54, 15.7, 4.4, 1.7, 3.8, 3.7, 2.7),  # granodiorite
    (57.5, 0.95, 16.7, 8.0, 3.7, 6.6, 3.5, 1.8),  # diorite
    (50.1, 1.1, 15.5, 11.5, 7.6, 9.6, 2.4, 0.93),  # gabbro
    (58.6, 0.84, 16.6, 6.5, 1.9, 3.5, 5.2, 5.0),  # syenite
    (72.8, 0.28, 13.3, 2.7, 0.39, 1.1, 3.6, 4.3),  # rhyolite
    (65.0, 0.58, 15.9, 5.0, 1.8, 4.3, 3.8, 2.2),  # dacite
    (57.9, 0.87, 17.0, 7.8, 3.3, 6.8, 3.5, 1.6),  # andesite
    (49.2, 1.8, 15.7, 11.7, 6.7, 9.5, 2.9, 1.1),  # basalt
    (61.2, 0.70, 17.0, 5.5, 0.93, 2.3, 5.5, 5.0),  # trachyte
    (56.2, 0.62, 19.0, 5.1, 1.1, 2.7, 7.8, 5.2),  # phonolite
    (44.3, 2.5, 14.7, 12.3, 8.5, 10.2, 3.6, 2.0),  # basanite
    (42.3, 0.63, 4.2, 10.9, 31.2, 5.1, 0.49, 0.34),  # peridotite
    (58.1, 0.65, 15.4, 6.7, 2.4, 3.1, 1.3, 3.2),  # shale
    (66.7, 0.60, 13.5, 5.5, 2.1, 2.5, 2.9, 2.0),  # greywacke
)
# Of ln, the standard deviation of each element within a kind of rock.
_WITHIN = (0.06, 0.5, 0.15, 0.3, 0.5, 0.35, 0.3, 0.5)
_WIDER = 2.0  # times the variance: rocks of other kinds


@lru_cache(maxsize=32)
def of_rocks(names: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
    """Mean of ln(mass) of some of ELEMENTS, (n,), and its covariance, (n, n)."""
    log = np.log(np.array(_MEANS) * _OF_OXIDE)
    covariance = _WIDER * (np.cov(log.T) + np.diag(np.square(_WITHIN)))
    which = [ELEMENTS.index(name) for name in names]
    return log.mean(axis=0)[which], covariance[np.ix_(which, which)]
