"""Every application of Persson (2006) with its claims, and what the paper says that no row judges."""

from __future__ import annotations

from validation.paper.claims import Application, Unjudged
from validation.paper.general import GENERAL
from validation.paper.pmma import PMMA
from validation.paper.pyrex import PYREX
from validation.paper.rim import RIM
from validation.paper.steel import STEEL

#: In the order of the table.
APPLICATIONS: tuple[Application, ...] = (RIM, GENERAL, STEEL, PMMA, PYREX)

UNJUDGED: tuple[Unjudged, ...] = (
    Unjudged(
        section="2.1",
        statement="spectra and heights of two asphalts; the rms amplitude does not decide the friction",
        reason="they are measured and not printed as numbers, and rubber friction is not computed here",
    ),
    Unjudged(
        section="2.2",
        statement="maximum height fluctuation of glassy surfaces of typically 10 nm",
        reason="no system is named for it",
    ),
    Unjudged(
        section="3.5",
        statement="contact area +14 % in molecular dynamics, +13 % in Hyun's finite elements, -20 % in "
        "Borri-Brunetto's",
        reason="results of other computations, not of the theory; `fem-contact study hurst` puts converged "
        "ones beside them, by fractal dimension and magnification",
    ),
    Unjudged(
        section="10.1",
        statement="tau_f = 50 and 5 MPa, hardness of PMMA 300 MPa and 10 GPa, q_c of alkanes and polymers",
        reason="measured by others and fed in",
    ),
    Unjudged(
        section="10.2",
        statement="the straight line of the pull-off figure",
        reason="its numbers are not printed; the row on the pull-off force evaluates Eq. 56",
    ),
    Unjudged(
        section="12",
        statement="ten times the length costs a hundred times memory and time; 10 x 10 points per asperity",
        reason="about solvers, not about the theory: the studies `scaling`, `accuracy-cost` and `refinement` "
        "measure it",
    ),
)
