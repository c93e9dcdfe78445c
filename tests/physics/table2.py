"""Table 2 of the paper: parameters of a CSF-25-80 when new and after 100 h at rated load."""

from __future__ import annotations

# When new, T_T = 0 and cup and teeth act as one stiffness K (38): any split of 1/K serves.
INITIAL = {
    "K_F": 2 * 50_923.2,
    "K_W": 101_837.5,
    "a": 0.0,
    "b": 2 * 50_923.2,
    "T_T": 0.0,
    "c": -1.177,
    "T_i": 115.5,
    "mu": 0.066,
}
POST_TEST = {
    "K_F": 78_197.8,
    "K_W": 98_548.7,
    "a": 1833.5,
    "b": 5729.6,
    "T_T": 30.0,
    "c": -1.152,
    "T_i": 70.2,
    "mu": 0.076,
}
