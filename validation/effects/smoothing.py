"""An earlier squeezing whose plastic flow has flattened the short waves of the surface."""

from typing import Literal, Self

from pydantic import model_validator

from validation.effects.base import Effect, Judgement, Roughness, TheoryInputs
from validation.effects.hardness import RARE
from validation.report.quantities import in_prefixed_unit
from validation.units import Pressure, key, wrong


class Smoothing(Effect):
    """The surface was squeezed before, and what yielded then is smooth now; it changes C(q)."""

    kind: Literal["smoothing"] = "smoothing"
    pressure: Pressure = key('nominal pressure of the squeezing, e.g. "20 MPa"')
    hardness: Pressure = key('indentation hardness at the squeezing, e.g. "6 GPa"')
    form: Literal["gradual", "sharp"] = key(
        "C(q) less the share that yielded at q, or C(q) up to where half had yielded", "gradual"
    )

    slot = "spectrum"
    meshed = False
    papers = ("Surfaces smoothed by plastic flow: [persson2006], Sec. 10.2.",)

    @model_validator(mode="after")
    def _carried(self) -> Self:
        if self.hardness <= self.pressure:
            raise wrong(
                f"hardness = {in_prefixed_unit(self.hardness, 'Pa', 6)}: must be above the pressure of the "
                f"squeezing, {in_prefixed_unit(self.pressure, 'Pa', 6)}"
            )
        return self

    def theory(self, inputs: TheoryInputs) -> None:
        """Persson 2006, Sec. 10.2."""
        inputs.smoothing = {"pressure": self.pressure, "hardness": self.hardness, "form": self.form}

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the spread of the stress with the hardness."""
        ratio = rough.modulus * rough.gradient / self.hardness
        number = f"E* h'_rms / H = {ratio:.3g} at the squeezing (Persson 2006, Sec. 10.2)"
        return self.judgement(number, matters=ratio / 2 > 1 / RARE)

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a squeezing that yields a part of the contact."""
        return cls(pressure=0.02, hardness=0.06)
