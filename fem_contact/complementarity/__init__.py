r"""The bounded quadratic programme of frictionless contact; it knows nothing but "apply the response".

.. math:: \min_x\ \tfrac12\, x\cdot S x - x\cdot h ,\qquad 0 \le x \le x_{\max},\qquad \textstyle\sum x = F

Its optimality conditions are those of contact: with the gap g = S x - h + offset (the offset is the
multiplier of the load), g = 0 where 0 < x < x_max, g >= 0 where x = 0, g <= 0 where x = x_max.

`operator` is the protocol with discretisations, `fourier` the periodic one by transforms, `free` that of a
patch alone, `solve` the iteration, `polonsky_keer` a slow one that checks it. Under the iteration:
`iteration_arrays`, compiled `kernels`, `rows` shared out over threads.
"""

from fem_contact.complementarity.fourier import FourierOperator as FourierOperator
from fem_contact.complementarity.free import FreeOperator as FreeOperator
from fem_contact.complementarity.free import operator_of as operator_of
from fem_contact.complementarity.operator import Operator as Operator
from fem_contact.complementarity.operator import Solution as Solution
from fem_contact.complementarity.polonsky_keer import polonsky_keer as polonsky_keer
from fem_contact.complementarity.solve import solve_bounded as solve_bounded
from fem_contact.complementarity.solve import solve_nested as solve_nested
from fem_contact.complementarity.solve import surely_partial as surely_partial
