"""Figures of merit of a drive, computed from its parameters.

Width, loss and lost motion are those of the model's symmetric steady cycle to ± a reference
torque, so that tests run to different torques can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hdprog.config.limits import Limit, figure_key
from hdprog.physics.drive_model import slip
from hdprog.physics.elastic import elastic_angle
from hdprog.physics.parameters import FloatArray, Parameters
from hdprog.physics.torque_path import TorquePath

ARCMIN_PER_RAD = 180.0 * 60.0 / math.pi
LOST_MOTION_SHARE = 0.04
"""Share of rated torque at which makers read lost motion (Harmonic Drive catalogues)."""
LOSS_POINTS = 257


@dataclass(frozen=True)
class FigureRequest:
    """One figure of merit to compute, e.g. secant stiffness at 14 Nm."""

    quantity: str
    at_torque_Nm: float | None = None

    @property
    def key(self) -> str:
        """Name in summaries; a torque is part of it, as in `...@14Nm`."""
        return figure_key(self.quantity, self.at_torque_Nm)

    @staticmethod
    def of(limit: Limit) -> FigureRequest:
        """The figure that a limit is set on."""
        return FigureRequest(limit.quantity, limit.at_torque_Nm)


@dataclass(frozen=True)
class Operation:
    """What a drive's figures refer to.

    Attributes
    ----------
    alpha : gear-tooth angle in rad
    reference_torque : amplitude in Nm of the steady cycle of width, loss and lost motion
    rated_torque : in Nm; lost motion is read at ± 4 % of it
    catalogue_torques : T1 and T2 in Nm of the maker's piecewise-linear stiffness, or None
    """

    alpha: float
    reference_torque: float
    rated_torque: float
    catalogue_torques: tuple[float, float] | None = None


def stiffness_curve(torque: FloatArray, parameters: Parameters, alpha: float) -> FloatArray:
    """Torsion angle without friction (24); torque `(samples,)` in Nm → `(draws, samples)` rad."""
    path = TorquePath.exact(torque)
    wave_generator = np.reshape(math.tan(alpha) ** 2 / np.asarray(parameters["K_W"]), (-1, 1))
    return elastic_angle(path, parameters) + path.torque * wave_generator


def secant_stiffness(torque: float, parameters: Parameters, alpha: float) -> FloatArray:
    """Torque over angle of the stiffness curve (24), `(draws,)` in Nm/rad."""
    return torque / stiffness_curve(np.array([torque]), parameters, alpha)[:, 0]


def local_stiffness(torque: float, parameters: Parameters, alpha: float) -> FloatArray:
    """Slope dT/dΔθ of the stiffness curve (39) at a torque, `(draws,)` in Nm/rad."""
    K_T = parameters["a"] * np.minimum(abs(torque), parameters["T_T"]) + parameters["b"]
    compliance = 1 / parameters["K_F"] + math.tan(alpha) ** 2 / parameters["K_W"] + 1 / K_T
    return np.atleast_1d(1 / compliance)


def preload(parameters: Parameters) -> FloatArray:
    """Preload at no load, −c·T_i (16), `(draws,)` in Nm."""
    return np.atleast_1d(-parameters["c"] * parameters["T_i"])


def steady_history(torque: FloatArray, top: float) -> FloatArray:
    """Torque in Nm from no load into the steady cycle to ± `top`; see `both_branches`.

    Parameters
    ----------
    torque : (samples,) rising torques in Nm, inside the cycle, at which it is looked at
    """
    return np.concatenate([[0.0, top, -top], torque, [top], torque[::-1]])


def both_branches(along: FloatArray, samples: int) -> tuple[FloatArray, FloatArray]:
    """What (draws, ...) along a `steady_history` is on the rising and on the falling branch.

    Returns
    -------
    two (draws, samples) arrays, both in the order of rising torque
    """
    return along[:, 3 : 3 + samples], along[:, -1 : -1 - samples : -1]


def steady_slip(
    torque: FloatArray, parameters: Parameters, operation: Operation
) -> tuple[FloatArray, FloatArray]:
    """Slip on the rising and on the falling branch of the steady cycle to ± reference torque.

    Parameters
    ----------
    torque : (samples,) rising torques in Nm, inside ± the reference torque

    Returns
    -------
    two (draws, samples) arrays in rad: rising branch, falling branch
    """
    path = TorquePath.exact(steady_history(torque, operation.reference_torque))
    return both_branches(slip(path, parameters, operation.alpha), torque.size)


def hysteresis_width(parameters: Parameters, operation: Operation) -> FloatArray:
    """Angle between the branches at zero torque, `(draws,)` in rad."""
    rising, falling = steady_slip(np.array([0.0]), parameters, operation)
    return math.tan(operation.alpha) * (falling - rising)[:, 0]


def hysteresis_loss(parameters: Parameters, operation: Operation) -> FloatArray:
    """Energy lost in a steady cycle, the enclosed area, `(draws,)` in J."""
    top = operation.reference_torque
    torque = np.linspace(-top, top, LOSS_POINTS)
    rising, falling = steady_slip(torque, parameters, operation)
    area = np.trapezoid(falling - rising, torque, axis=1)
    return np.asarray(math.tan(operation.alpha) * area)


def lost_motion(parameters: Parameters, operation: Operation) -> FloatArray:
    """Difference of the loop's mid-line at + and − 4 % of rated torque, `(draws,)` in rad."""
    at = LOST_MOTION_SHARE * operation.rated_torque
    torque = np.array([-at, at])
    rising, falling = steady_slip(torque, parameters, operation)
    mid = elastic_angle(TorquePath.exact(torque), parameters)
    mid += 0.5 * math.tan(operation.alpha) * (rising + falling)
    return mid[:, 1] - mid[:, 0]


def catalogue_stiffness(index: int, parameters: Parameters, operation: Operation) -> FloatArray:
    """K1, K2 or K3: slope of the stiffness curve (24) over [0, T1], [T1, T2], [T2, reference].

    Returns `(draws,)` in Nm/rad. The caller makes sure that the range exists.
    """
    if operation.catalogue_torques is None:
        raise ValueError("catalogue torques T1 and T2 are not known")
    edges = np.array([0.0, *operation.catalogue_torques, operation.reference_torque])
    low, high = edges[index - 1], edges[index]
    angle = stiffness_curve(np.array([low, high]), parameters, operation.alpha)
    return np.asarray((high - low) / (angle[:, 1] - angle[:, 0]))


def figure(request: FigureRequest, parameters: Parameters, operation: Operation) -> FloatArray:
    """One figure of merit for every draw.

    Parameters
    ----------
    request : which figure, at which torque
    parameters : by name, each scalar or (draws,)
    operation : the torques and the tooth angle that it refers to

    Returns
    -------
    (draws,) in the unit that the quantity's name ends with

    Raises
    ------
    ValueError
        for a quantity that does not exist
    """
    at, alpha = request.at_torque_Nm, operation.alpha
    match request.quantity:
        case "hysteresis_width_arcmin":
            return ARCMIN_PER_RAD * hysteresis_width(parameters, operation)
        case "hysteresis_loss_J":
            return hysteresis_loss(parameters, operation)
        case "lost_motion_arcmin":
            return ARCMIN_PER_RAD * lost_motion(parameters, operation)
        case "preload_Nm":
            return preload(parameters)
        case "secant_stiffness_Nm_per_rad" if at is not None:
            return secant_stiffness(at, parameters, alpha)
        case "local_stiffness_Nm_per_rad" if at is not None:
            return local_stiffness(at, parameters, alpha)
        case "K1_Nm_per_rad" | "K2_Nm_per_rad" | "K3_Nm_per_rad":
            return catalogue_stiffness(int(request.quantity[1]), parameters, operation)
    raise ValueError(f"no figure of merit is called {request.key}")


def standard_requests(operation: Operation) -> tuple[FigureRequest, ...]:
    """Figures that every summary holds: those that the drive's data sheet allows."""
    rated = operation.rated_torque
    requests = [
        FigureRequest("hysteresis_width_arcmin"),
        FigureRequest("hysteresis_loss_J"),
        FigureRequest("lost_motion_arcmin"),
        FigureRequest("preload_Nm"),
        FigureRequest("secant_stiffness_Nm_per_rad", rated),
        FigureRequest("local_stiffness_Nm_per_rad", rated),
    ]
    if operation.catalogue_torques is not None:
        requests += [FigureRequest("K1_Nm_per_rad"), FigureRequest("K2_Nm_per_rad")]
        if operation.reference_torque > operation.catalogue_torques[1]:
            requests.append(FigureRequest("K3_Nm_per_rad"))
    return tuple(requests)


def figures(
    requests: Sequence[FigureRequest], parameters: Parameters, operation: Operation
) -> dict[str, FloatArray]:
    """Several figures of merit by key, each `(draws,)`."""
    return {request.key: figure(request, parameters, operation) for request in requests}
