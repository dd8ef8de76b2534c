"""What a study is: a module with a table of options, a `run`, and what is shown of its dataset."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.errors import RunFailed, SolvesFailed, UsageError
from validation.execution.bench import Bench
from validation.execution.measurement import Call, measurement
from validation.measurements.limits import ABSENT, Measured, read_off, solved, stored_variables
from validation.report.places import gather
from validation.report.quantities import labelled
from validation.report.table import budget_table
from validation.report.values import with_places
from validation.scenes.mistakes import problems
from validation.scenes.scene import Scene
from validation.studies._options import StudyOptions

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.marks import Drawing
    from validation.report.table import ResultTable
    from validation.report.views import Views

#: With `gathered` all that a study solves by.
__all__ = ["ABSENT", "Bench", "Call", "Measured", "Study", "gathered", "measurement", "read_off", "solved"]
__all__ += ["stored_variables"]


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study by name."""

    name: str
    module: ModuleType

    @property
    def question(self) -> str:
        """First line of its docstring."""
        return (self.module.__doc__ or "").strip().partition("\n")[0]

    @property
    def options(self) -> type[StudyOptions]:
        """Table of options of the study."""
        options_class: type[StudyOptions] = self.module.Options
        return options_class

    def compute(self, options: StudyOptions, *, bench: Bench) -> xr.Dataset:
        """Run the study on a bench; of other methods that fail beside boundary elements ``failures`` says why.

        A UsageError for options that make no surface, solid or load. A RunFailed for a solve whose answer
        cannot be used.
        """
        try:
            return labelled(self.module.run(options, bench=bench)).assign_attrs(study=self.name)
        except SolvesFailed as error:
            others = options.without(error.failures)
            if others is None:
                raise
            data = self.compute(others, bench=bench)  # all of it is stored
            whys = [data.attrs.get("failures", ""), *error.failures.values()]
            return data.assign_attrs(failures="\n".join(dict.fromkeys(filter(None, whys))))
        except ValidationError as error:
            lines = "; ".join(problems(error))
            raise UsageError(f"study {self.name}: its options make no case: {lines}") from None
        except (fem_errors.InvalidInput, persson_errors.InvalidInput, ArithmeticError) as error:
            raise UsageError(f"study {self.name}: {error}") from None
        except (fem_errors.FemContactError, persson_errors.PerssonError) as error:
            raise RunFailed(f"study {self.name}: {error}") from error

    def views(self, data: xr.Dataset) -> Views:
        """Return what is shown of a dataset."""
        declared: Views = self.module.views(with_places(data))
        return declared

    def parse(self, arguments: Sequence[str], *, scene: Scene | None = None) -> StudyOptions:
        """Read its options from the command line.

        A UsageError for what it does not allow, and for a scene that it does not take.
        """
        if scene is not None and not self.options.takes_scene():
            why = f": {self.options.why_no_scene}" if self.options.why_no_scene else ""
            raise UsageError(f"study {self.name}: takes no scene{why}; leave {scene.name!r} out")
        try:
            return self.options.parse(arguments, scene=scene)
        except UsageError as error:
            raise UsageError(f"study {self.name}: {error}") from None

    def help_lines(self) -> tuple[str, ...]:
        """Question and options, each with kind, default and meaning."""
        takes = "  [takes a SCENE]" if self.options.takes_scene() else ""
        return (f"{self.name}: {self.question}{takes}", *self.options.help_lines())

    def figures(self, data: xr.Dataset) -> tuple[Drawing, ...]:
        """Return its figures of a dataset, drawn."""
        from validation.report.marks import draw

        return tuple(draw(figure, data) for figure in self.views(data).figures)

    def table(self, data: xr.Dataset) -> ResultTable | None:
        """Return its table of a dataset; None if it has none."""
        declared = self.views(data).table
        return None if declared is None else declared.of(data)

    def budget(self, data: xr.Dataset) -> ResultTable | None:
        """Return its uncertainties source by source; None if it lists none."""
        named = self.views(data).budget
        return budget_table(data, named) if named else None

    def findings(self, data: xr.Dataset) -> tuple[str, ...]:
        """Return its sentences on a dataset."""
        return tuple(unit.text for unit in self.views(data).findings)


def gathered(
    bench: Bench, cases: Mapping[Any, Call], reduced: Callable[[xr.Dataset, Call], xr.Dataset], *dims: str
) -> xr.Dataset:
    """Solve cases, reduce what each leaves with its call, and stack the parts along dimensions.

    A case is named by its place along `dims`, which have its values in the order of the cases.
    """
    parts = {
        place: reduced(result, cases[place]).assign_attrs(solve=cases[place].key)
        for place, result in solved(bench, cases).items()
    }
    return gather(parts, *dims)
