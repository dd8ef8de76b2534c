"""A homogeneous layer of another modulus on top of the solid."""

import math
from typing import Literal, Self

from fem_contact.solid import Solid
from validation.effects.base import ContactModel, Effect, Judgement, Roughness, TheoryInputs
from validation.errors import UsageError
from validation.units import Length, Number, Pressure, key

#: q_short d below which a coating is not felt.
_THIN = 0.1


class Coating(Effect):
    """A homogeneous layer of another modulus on top of the solid."""

    kind: Literal["coating"] = "coating"
    young: Pressure = key('Young\'s modulus of the coating, e.g. "20 GPa"')
    poisson: Number | None = key(
        "Poisson ratio of the coating, e.g. 0.25; default: that of the solid", None, gt=-1, le=0.5
    )
    thickness: Length = key('thickness of the coating, e.g. "1 um"')

    slot = "response"
    meshed = False
    cost = 1.4
    papers = ("Coated solid: K. L. Johnson, Contact Mechanics (Cambridge, 1985), Sec. 5.8.",)

    def fill(self, model: ContactModel) -> None:
        """Set the response to that of the layer on the solid."""
        from fem_contact.graded import LayeredSolid

        poisson = model.solid.poisson if self.poisson is None else self.poisson
        layer = Solid(young=self.young, poisson=poisson)
        model.response = LayeredSolid(layers=[layer], thicknesses=[self.thickness], base=model.solid)

    def theory(self, inputs: TheoryInputs) -> None:
        """Persson 2006, Sec. 5; the theory has one Poisson ratio for layer and solid."""
        from persson.graded import SurfaceLayer

        if self.poisson is not None and self.poisson != inputs.solid.poisson:
            raise UsageError(
                f"poisson = {self.poisson!r}: method 'theory' knows one Poisson ratio, that of "
                f"the solid, {inputs.solid.poisson!r}"
            )
        inputs.modulus = SurfaceLayer(
            bulk=inputs.solid.young,
            layer=self.young,
            thickness=self.thickness,
            poisson=inputs.solid.poisson,
        )

    def judge(self, rough: Roughness) -> Judgement:
        """Compare the thickness with the shortest wave."""
        thin = 2 * math.pi * self.thickness / rough.shortest
        number = f"q_short d = {thin:.3g}: the shortest waves feel the coating where it is above 0.1"
        return self.judgement(number, matters=thin > _THIN)

    @classmethod
    def example(cls, spacing: float) -> Self:
        """Return a stiff coating: on a soft one attraction as strong as repulsion reaches not two cells."""
        return cls(young=3.0, thickness=0.02)
