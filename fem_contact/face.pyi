from validation.notebook import measured as measured
from validation.notebook import press as press
from validation.notebook import reference as reference
from validation.notebook import self_affine as self_affine
from validation.notebook import study as study
from validation.notebook import table as table
from validation.notebook import theory as theory

def main() -> None: ...
