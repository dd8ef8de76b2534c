from .notebook import Contact as Contact
from .notebook import Surface as Surface
from .notebook import measured as measured
from .notebook import press as press
from .notebook import self_affine as self_affine
from .notebook import study as study
from .notebook import table as table
from .notebook import theory as theory

belongs_to_fem_contact: bool
__version__: str
