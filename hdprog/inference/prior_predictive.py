"""What a prior says of a drive before any test: its loops, stiffness and hysteresis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hdprog.config.drive import DEFAULT_ALPHA
from hdprog.errors import BadInputError
from hdprog.inference.catalogue_prior import TORQUE_REACH
from hdprog.inference.priors import Prior
from hdprog.physics.drive_model import torsion_angle
from hdprog.physics.figures import FigureRequest, Operation, figures, stiffness_curve
from hdprog.physics.parameters import NAMES, FloatArray, Parameters, in_support
from hdprog.physics.torque_path import TorquePath

QUANTILES = {"q05": 0.05, "q25": 0.25, "q50": 0.5, "q75": 0.75, "q95": 0.95}
_POINTS = 121  # a branch of a loop


@dataclass(frozen=True)
class PriorPredictive:
    """Draws from a prior and what follows from them.

    Attributes
    ----------
    prior : where they come from
    operation : torques and tooth angle that the figures refer to
    in_support : share of draws inside the hard support of the model; the others are left out
    parameters : by name, each (draws,)
    figures : by key, each (draws,): K1, K2, K3 where the catalogue gives T1 and T2, width at zero
        torque, lost motion, preload
    torque : (points,) of a steady cycle: up, then down, in Nm
    loops : (loops, points) torsion angle in rad of the first draws
    curve_torque : (levels,) from zero to the reference torque, in Nm
    curves : (draws, levels) torsion angle in rad without friction
    """

    prior: Prior
    operation: Operation
    in_support: float
    parameters: Parameters
    figures: Mapping[str, FloatArray]
    torque: FloatArray
    loops: FloatArray
    curve_torque: FloatArray
    curves: FloatArray


def operation_of_prior(prior: Prior, alpha: float = DEFAULT_ALPHA) -> Operation:
    """Torques at which a prior is looked at.

    The reference torque lies as far beyond T2 as the rated torque of a CSF-25-80 does; without T2
    it is the rated torque, and without that the torque at which the preload is gone.
    """
    torques = prior.catalogue_torques
    rated = prior.catalogue.get("rated_torque_Nm")
    if torques is not None:
        reference = TORQUE_REACH * torques[1]
    else:
        reference = rated or math.exp(prior.mean[NAMES.index("T_i")])
    return Operation(alpha, reference, rated or reference, torques)


def prior_predictive(
    prior: Prior,
    rng: np.random.Generator,
    *,
    alpha: float = DEFAULT_ALPHA,
    draws: int = 4000,
    loops: int = 40,
) -> PriorPredictive:
    """Draw from a prior.

    Parameters
    ----------
    prior : with numbers of its own, not those of a record
    rng : random numbers
    alpha : gear-tooth angle in rad
    draws : number of draws, before those outside the support are left out
    loops : number of draws whose loops are computed

    Raises
    ------
    BadInputError
        if no draw lies inside the model's support
    """
    drawn = prior.to_physical(prior.sample(draws, rng))
    inside = in_support(drawn, alpha)
    if not inside.any():
        raise BadInputError(
            f"none of {draws} draws inside the support of the model",
            f"prior {prior.name}, tooth angle {math.degrees(alpha):g}°",
            "stiffnesses > 0 and mu below tan(alpha) and its inverse",
            "Lower the median of mu; friction of lubricated teeth is about 0.05 to 0.2.",
        )
    kept = {name: values[inside] for name, values in drawn.items()}
    operation = operation_of_prior(prior, alpha)
    slopes = () if operation.catalogue_torques is None else ("K1", "K2", "K3")
    requests = [FigureRequest(f"{slope}_Nm_per_rad") for slope in slopes]
    requests += [
        FigureRequest(key)
        for key in ("hysteresis_width_arcmin", "lost_motion_arcmin", "preload_Nm")
    ]
    top = operation.reference_torque
    up = np.linspace(-top, top, _POINTS)
    leg = np.concatenate([up, up[-2::-1]])
    path = TorquePath.exact(np.concatenate([[0.0, top], leg]))
    few = {name: values[:loops] for name, values in kept.items()}
    levels = np.linspace(0.0, top, _POINTS)
    return PriorPredictive(
        prior=prior,
        operation=operation,
        in_support=float(inside.mean()),
        parameters=kept,
        figures=figures(requests, kept, operation),
        torque=leg,
        loops=torsion_angle(path, few, alpha)[:, 2:],
        curve_torque=levels,
        curves=stiffness_curve(levels, kept, alpha),
    )


def catalogue_curve(prior: Prior, torque: FloatArray) -> FloatArray | None:
    """Torsion angle in rad of the catalogue's three straight pieces; None where they are not known.

    Parameters
    ----------
    prior : with its catalogue figures
    torque : (levels,) at least zero, in Nm
    """
    torques = prior.catalogue_torques
    slopes = [prior.catalogue.get(f"K{index}_Nm_per_rad") for index in (1, 2, 3)]
    if torques is None or None in slopes:
        return None
    edges = np.array([0.0, *torques, np.inf])
    pieces = [
        np.clip(torque - low, 0.0, high - low) / slope
        for low, high, slope in zip(edges[:-1], edges[1:], slopes, strict=True)
    ]
    return np.asarray(np.sum(pieces, axis=0))


def prior_document(predictive: PriorPredictive) -> dict[str, object]:
    """What a prior says as JSON: quantiles of parameters and figures, and the catalogue's."""

    def quantiles(values: FloatArray) -> dict[str, float]:
        found = np.quantile(values, list(QUANTILES.values()))
        return dict(zip(QUANTILES, map(float, found), strict=True))

    prior = predictive.prior
    return {
        "schema": "hdprog.prior/1",
        "name": prior.name,
        "source": prior.source,
        "alpha_deg": round(math.degrees(predictive.operation.alpha), 9),
        "reference_torque_Nm": predictive.operation.reference_torque,
        "in_support": predictive.in_support,
        "parameters": {name: quantiles(values) for name, values in predictive.parameters.items()},
        "figures": {key: quantiles(values) for key, values in predictive.figures.items()},
        "catalogue": dict(prior.catalogue),
    }
