"""Models of torsion other than the drive model, each a competitor on the same record.

A new model is one file and one name in `MODELS`.
"""

from __future__ import annotations

from collections.abc import Mapping

from hdprog.physics.other_models.base import OtherModel
from hdprog.physics.other_models.catalogue_piecewise import CataloguePiecewise
from hdprog.physics.other_models.cubic import Cubic
from hdprog.physics.other_models.dhaouadi import Dhaouadi
from hdprog.physics.other_models.ideal_three_port import IdealThreePort
from hdprog.physics.other_models.maxwell_slip import MaxwellSlip
from hdprog.physics.other_models.preisach import Preisach
from hdprog.physics.other_models.seyfferth import Seyfferth
from hdprog.physics.other_models.taghirad import Taghirad
from hdprog.physics.other_models.tuttle import Tuttle
from hdprog.physics.other_models.zhang import Zhang

MODELS: tuple[OtherModel, ...] = (
    IdealThreePort(),
    Tuttle(),
    CataloguePiecewise(),
    Cubic(),
    Dhaouadi(),
    Zhang(),
    Seyfferth(),
    Taghirad(),
    Preisach(),
    MaxwellSlip(),
)
BY_ID: Mapping[str, OtherModel] = {model.id: model for model in MODELS}
