"""What a drive's prior expects of the figures that have a limit, before anything is fitted."""

from __future__ import annotations

import numpy as np

from hdprog.config import Drive
from hdprog.inference.prior_file import prior_of_drive
from hdprog.inference.priors import RecordScales
from hdprog.physics.figures import FigureRequest, Operation, figures
from hdprog.physics.parameters import in_support

_DRAWS = 1000


def expected_figures(drive: Drive, scales: RecordScales) -> dict[str, tuple[float, float]]:
    """5 % and 95 % quantiles under the prior by the figure's key; empty where no draw can be.

    Parameters
    ----------
    drive : with its limits
    scales : of a record, which stand in for a prior or a rated torque that is not declared

    Raises
    ------
    BadInputError
        as `prior_of_drive`
    """
    prior, _ = prior_of_drive(drive, scales)
    drawn = prior.to_physical(prior.sample(_DRAWS, np.random.default_rng(0)))
    inside = in_support(drawn, drive.alpha)
    if not inside.any():
        return {}
    rated = drive.rated_torque or scales.largest_torque
    operation = Operation(
        drive.alpha, drive.reference_torque or rated, rated, prior.catalogue_torques
    )
    found = figures(
        [FigureRequest.of(limit) for limit in drive.limits],
        {name: values[inside] for name, values in drawn.items()},
        operation,
    )
    ends = {key: np.quantile(values, (0.05, 0.95)) for key, values in found.items()}
    return {key: (float(low), float(high)) for key, (low, high) in ends.items()}
